// SPDX-License-Identifier: Apache-2.0
#include "load/samples.h"

#include <stdint.h>
#include <stdio.h>

#include "load/gltf_sample.h"
#include "load/sample_pictures.h"

void *sample_check(void *pointer)
{
    if (pointer == NULL) {
        fprintf(stderr, "a sample could not be made\n");
        abort();
    }
    return pointer;
}

sample *sample_add(samples *all, const char *name, const void *data, size_t size)
{
    sample_check(all->count < SAMPLES_MOST ? all : NULL);
    sample *added = &all->list[all->count++];
    *added = (sample){.name = name, .header = size, .data = sample_check(malloc(size + 1)), .size = size};
    memcpy(added->data, data, size);
    added->data[size] = 0;
    return added;
}

// -------------------------------------------------------------------------------------------------------------- texts

static const char SHAPE_OBJ[] = "# a shape\n"
                                "mtllib shape.mtl\n"
                                "o first\n"
                                "v 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1.0\nv 0 1 0 0.5 0.5 1 1\nv .5 2e0 -1.25E-1\n"
                                "vt 0 0\nvt 1 0\nvt 1 1 0\nvt 0\n"
                                "vn 0 0 1\nvn 0 0 -2\n"
                                "usemtl red\ns 1\n"
                                "f 1/1/1 2/2/1 3/3/2 4/4/2\n"
                                "s off\ng group\nusemtl blue\n"
                                "f -3//1 -2//2 \\\n -1//1\n"
                                "o second\n"
                                "f 1/1 2/2 3/3\nfo 1 3 5\nl 1 2\np 1\nf 1 2\n"
                                "t crease 2/1/0 0 1 2.5\n";

static const char SHAPE_MTL[] =
    "newmtl red\nKd 1 0 0\nKs 0.5\nNs 20\nd 0.5\nTr 0.5\nKe 0 1 0\nillum 2\n"
    "map_Kd -o 0.5 0 -s 2 2 2 -clamp on rgb.png\nmap_d rgb.png\nbump -bm 0.5 -imfchan r rgb.png\n"
    "newmtl blue\nKd spectral file.rfl\nKs xyz 1 1 1\nPr 0.3\nPm 1\nmap_Pr rgb.png\nmap_Ke rgb.png\nnorm rgb.png\n";

static const char ASCII_PLY[] =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\n"
    "property float x\nproperty float y\nproperty double z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property float nx\nproperty float ny\nproperty float nz\n"
    "property float s\nproperty float t\n"
    "element face 2\nproperty list uchar int vertex_indices\nproperty int flags\n"
    "element edge 1\nproperty list uchar short what\n"
    "end_header\n"
    "0 0 0 255 0 0 0 0 1 0 0\n1 0 0 0 255 0 0 0 1 1 0\n1 1 0 0 0 255 0 0 1 1 1\n0 1 0 9 9 9 0 0 0 0 1\n"
    "4 0 1 2 3 7\n3 0 2 3 -1\n"
    "2 1 2\n";

static const char ASCII_STL[] =
    "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n"
    "  endloop\n endfacet\n facet normal 0 0 1\n  outer loop\n   vertex 1 0 0\n   vertex 1e0 1 0\n"
    "   vertex 0 1 0\n  endloop\n endfacet\nendsolid a\n";

static const char SCENE_JSON[] =
    "{\"clast\": 1, \"models\": [{\"path\": \"little.ply\", \"translation\": [0, 1, 0], \"rotation\": [0, 0, 0, 1], \"scale\": 2, "
    "\"copies\": 4}, {\"path\": \"shape.obj\", \"scale\": [1, 2, 3]}],"
    "\"environment\": {\"sky\": {\"sun_direction\": [0, 1, 0], \"turbidity\": 2, \"sun_size\": 0.3, \"colour\": [1, 1, 1]}},"
    "\"cameras\": [{\"name\": \"a\", \"projection\": \"perspective\", \"position\": [0, 0, 5], \"target\": [0, 0, 0], \"up\": [0, 1, 0], "
    "\"vertical_angle\": 40, \"near_plane\": 0.1, \"far_plane\": 100}, {\"projection\": \"orthographic\", \"position\": [1, 1, 1], "
    "\"target\": [0, 0, 0], \"height\": 3}],"
    "\"lights\": [{\"type\": \"spot\", \"position\": [0, 3, 0], \"direction\": [0, -1, 0], \"colour\": [1, 1, 1], \"intensity\": 5, "
    "\"range\": 9, \"inner_angle\": 10, \"outer_angle\": 20}, {\"type\": \"directional\", \"direction\": [0, -1, 0]}],"
    "\"waves\": [{\"size\": 4, \"tiles\": 2, \"amplitude\": 0.1, \"wavelength\": 1, \"speed\": 1}],"
    "\"settings\": {\"width\": 8, \"height\": 8, \"spp\": 1, \"exposure\": -1.5, \"tonemap\": \"none\", \"camera\": \"a\"}}";

static void add_text(samples *all, const char *name, const char *text)
{
    sample_add(all, name, text, strlen(text));
}

// ------------------------------------------------------------------------------------------------------------- writing

typedef struct writer {
    unsigned char data[8192];
    size_t size;
    bool is_big; // the high byte first
} writer;

static void put_bytes(writer *w, const void *data, size_t size)
{
    sample_check(size <= sizeof w->data - w->size ? w : NULL);
    memcpy(w->data + w->size, data, size);
    w->size += size;
}

static void put_integer(writer *w, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        unsigned char byte = (unsigned char)(value >> 8 * (w->is_big ? size - 1 - i : i));
        put_bytes(w, &byte, 1);
    }
}

static void put_float(writer *w, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_integer(w, bits, 4);
}

static void add_written(samples *all, const char *name, const writer *w, size_t header)
{
    sample_add(all, name, w->data, w->size)->header = header;
}

static void add_binary_ply(samples *all, const char *name, bool is_big)
{
    writer w = {.is_big = is_big};
    char head[512];
    snprintf(
        head, sizeof head,
        "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        "element face 2\nproperty list uchar uint vertex_indices\n"
        "element tristrips 1\nproperty list int short vertex_indices\nend_header\n",
        is_big ? "big" : "little");
    put_bytes(&w, head, strlen(head));
    for (uint32_t i = 0; i < 4; i++) {
        put_float(&w, (float)(i == 1 || i == 2));
        put_float(&w, (float)(i / 2));
        put_float(&w, 0.25f);
        put_integer(&w, 0xff804020u, 4);
    }
    static const uint32_t faces[2][5] = {{4, 0, 1, 2, 3}, {3, 0, 2, 3, 0}};
    for (uint32_t i = 0; i < 2; i++) {
        put_integer(&w, faces[i][0], 1);
        for (uint32_t k = 1; k <= faces[i][0]; k++) {
            put_integer(&w, faces[i][k], 4);
        }
    }
    static const uint16_t strip[] = {0, 1, 3, 2, 0xffff, 0, 1, 2};
    put_integer(&w, 8, 4);
    for (uint32_t i = 0; i < 8; i++) {
        put_integer(&w, strip[i], 2);
    }
    add_written(all, name, &w, strlen(head));
}

static void add_binary_stl(samples *all)
{
    writer w = {.size = 80};
    put_integer(&w, 2, 4);
    for (uint32_t i = 0; i < 2; i++) {
        for (uint32_t k = 0; k < 12; k++) {
            put_float(&w, k < 3 ? 0.0f : (float)((k * 7 + i * 3) % 5));
        }
        put_integer(&w, 0, 2);
    }
    add_written(all, "binary.stl", &w, 84);
}

// ---------------------------------------------------------------------------------------------------------------- glTF

static void put_chunk(writer *w, const char *type, const void *data, size_t size, unsigned char padding)
{
    put_integer(w, (size + 3) / 4 * 4, 4);
    put_bytes(w, type, 4);
    put_bytes(w, data, size);
    while (w->size % 4 != 0) {
        put_bytes(w, &padding, 1);
    }
}

static void add_gltf(samples *all)
{
    sample *gltf = sample_add(all, "scene.gltf", SAMPLE, sizeof SAMPLE - 1);
    for (size_t i = 0; i < gltf->size; i++) {
        gltf->data[i] = gltf->data[i] == '\'' ? '"' : gltf->data[i];
    }
    fill_sample_bytes();
    sample_add(all, "data.bin", sample_bytes, sizeof sample_bytes)->is_part = true;
    sample_add(all, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG)->is_picture = true;
    // The same with the buffer in the file.
    static const char named[] = "\"uri\":\"data.bin\",";
    const char *text = (const char *)gltf->data, *at = sample_check(strstr(text, named));
    writer json = {0}, w = {0};
    put_bytes(&json, text, (size_t)(at - text));
    put_bytes(&json, at + strlen(named), strlen(at + strlen(named)));
    put_bytes(&w, "glTF", 4);
    put_integer(&w, 2, 4);
    put_integer(&w, 12 + 8 + (json.size + 3) / 4 * 4 + 8 + sizeof sample_bytes, 4);
    put_chunk(&w, "JSON", json.data, json.size, ' ');
    put_chunk(&w, "BIN", sample_bytes, sizeof sample_bytes, 0);
    add_written(all, "scene.glb", &w, 20);
}

// Streams as KHR_meshopt_compression has them: attributes that are all zero, and a triangle by its indices.
static void add_packed_gltf(samples *all)
{
    static const unsigned char streams[45 + 11] = {
        [0] = 0xa0,                                         // attributes: zeros, and the first element at the end
        [45] = 0xd1, [46] = 0x00, [47] = 0x04, [48] = 0x04, // indices: 0, 1, 2 by their differences
    };
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"EXT_meshopt_compression\"],"
        "\"extensionsRequired\":[\"EXT_meshopt_compression\"],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
        "\"buffers\":[{\"uri\":\"packed.bin\",\"byteLength\":56},{\"byteLength\":48}],"
        "\"bufferViews\":[{\"buffer\":1,\"byteLength\":36,\"byteStride\":12,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,"
        "\"byteLength\":45,\"byteStride\":12,\"count\":3,\"mode\":\"ATTRIBUTES\",\"filter\":\"NONE\"}}},"
        "{\"buffer\":1,\"byteOffset\":36,\"byteLength\":12,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,\"byteOffset\":45,"
        "\"byteLength\":8,\"byteStride\":4,\"count\":3,\"mode\":\"INDICES\"}}}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[0,0,0]},"
        "{\"bufferView\":1,\"componentType\":5125,\"count\":3,\"type\":\"SCALAR\"}]}";
    add_text(all, "packed.gltf", text);
    sample_add(all, "packed.bin", streams, sizeof streams)->is_part = true;
}

// ----------------------------------------------------------------------------------------------------------------- all

samples samples_make(void)
{
    samples all = {.count = 0};
    add_gltf(&all);
    add_packed_gltf(&all);
    add_text(&all, "shape.obj", SHAPE_OBJ);
    sample_add(&all, "shape.mtl", SHAPE_MTL, sizeof SHAPE_MTL - 1)->is_part = true;
    add_text(&all, "ascii.ply", ASCII_PLY);
    add_binary_ply(&all, "little.ply", false);
    add_binary_ply(&all, "big.ply", true);
    add_text(&all, "ascii.stl", ASCII_STL);
    add_binary_stl(&all);
    add_text(&all, "scene.json", SCENE_JSON);
    sample_add_pictures(&all);
    return all;
}

void samples_free(samples *all)
{
    for (size_t i = 0; i < all->count; i++) {
        free(all->list[i].data);
    }
    all->count = 0;
}

const sample *samples_find(const samples *all, const char *name)
{
    for (size_t i = 0; i < all->count; i++) {
        if (strcmp(all->list[i].name, name) == 0) {
            return &all->list[i];
        }
    }
    return NULL;
}
