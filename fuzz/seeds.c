// SPDX-License-Identifier: Apache-2.0
// seeds FOLDER: writes what fuzzing begins with, in a folder for each target: the samples of the tests, and inputs of the targets
// that read no file.
#include <stdint.h>

#include "load/samples.h"
#include "seeds.h"

// Targets by the extensions of the files that they read.
static void write_samples(void)
{
    static const struct {
        const char *extension, *target;
    } targets[] = {
        {"gltf", "gltf"},    {"glb", "glb"},         {"obj", "obj"},   {"mtl", "mtl"},   {"ply", "ply"},
        {"stl", "stl"},      {"json", "scene_file"}, {"json", "json"}, {"gltf", "json"}, {"png", "png"},
        {"jpg", "jpeg"},     {"hdr", "hdr"},         {"pfm", "pfm"},   {"exr", "exr"},   {"dds", "dds"},
        {"tga", "tga"},      {"ktx", "ktx"},         {"ktx2", "ktx"},  {"webp", "webp"}, {"gltf", "validate"},
        {"glb", "validate"},
    };
    samples all = samples_make();
    for (size_t i = 0; i < all.count; i++) {
        const sample *s = &all.list[i];
        const char *extension = strrchr(s->name, '.') + 1;
        for (size_t k = 0; k < sizeof targets / sizeof *targets; k++) {
            if (strcmp(targets[k].extension, extension) == 0) {
                write_seed(targets[k].target, s->name, s->data, s->size);
            }
        }
        if (s->is_picture) {
            write_seed("image", s->name, s->data, s->size);
        }
    }
    samples_free(&all);
}

static void write_numbers(void)
{
    static const char *const numbers[] = {"0",
                                          "-1.5",
                                          "1e22",
                                          "123456789012345678901e-30",
                                          ".5",
                                          "+7.",
                                          "9007199254740993",
                                          "1e-400",
                                          "4294967296",
                                          "-9223372036854775807"};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        write_seed("number", numbers[i], numbers[i], strlen(numbers[i]));
    }
}

static void write_bytes(void)
{
    unsigned char bytes[600];
    for (uint32_t seed = 0; seed < 12; seed++) {
        char name[8];
        uint32_t random = seed;
        for (size_t i = 0; i < sizeof bytes; i++) {
            random = random * 1664525u + 1013904223u;
            bytes[i] = (unsigned char)((random >> 16) % (seed % 3 == 0 ? 256 : seed % 3 == 1 ? 64 : 8));
        }
        snprintf(name, sizeof name, "%u", seed);
        bytes[0] = (unsigned char)seed;
        write_seed("block", name, bytes, 1 + 16 * 4);
        write_seed("polygon", name, bytes, 120);
        write_seed("clusterize", name, bytes, 60 + 40 * seed);
        write_seed("cook", name, bytes, 60 + 40 * seed);
        // Sound accessors are rare among random ones: these have offsets of zero and views that fit.
        bytes[0] = (unsigned char)(seed & 7);
        write_seed("accessor", name, bytes, sizeof bytes);
        write_seed("elements", name, bytes, 200);
    }
    // mode, filter, version, stride - 1, count, its high part, then a stream.
    static const unsigned char attributes[6 + 45] = {0, 0, 0, 11, 3, 0, 0xa0},
                                              indices[6 + 8] = {2, 0, 0, 3, 3, 0, 0xd1, 0, 4, 4},
                                              triangles[6 + 1 + 1 + 16] = {1, 0, 0, 3, 3, 0, 0xe1, 0xf0};
    write_seed("meshopt", "attributes", attributes, sizeof attributes);
    write_seed("meshopt", "indices", indices, sizeof indices);
    write_seed("meshopt", "triangles", triangles, sizeof triangles);
}

int main(int argument_count, char **arguments)
{
    if (argument_count != 2) {
        fprintf(stderr, "usage: seeds FOLDER\n");
        return 2;
    }
    seeds_begin(arguments[1]);
    write_samples();
    write_numbers();
    write_bytes();
    return 0;
}
