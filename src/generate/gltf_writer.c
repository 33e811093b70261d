// SPDX-License-Identifier: Apache-2.0
#include "generate/gltf_writer.h"

#include <stdio.h>

#include "clast/version.h"

#define TEXT_OF(number) #number
#define TEXT(number) TEXT_OF(number)
#define GENERATOR "clast " TEXT(CLAST_VERSION_MAJOR) "." TEXT(CLAST_VERSION_MINOR) "." TEXT(CLAST_VERSION_PATCH)

static const char DISPLACEMENT[] = "KHR_materials_displacement";

// What each stream is, as glTF says it (5126 float, 5123 unsigned short, 5125 unsigned int).
static const struct {
    const char *file, *attribute, *type;
    uint32_t component, bytes, target;
} streams[CLAST_GLTF_STREAMS] = {
    [CLAST_GLTF_POSITIONS] = {"positions", "POSITION", "VEC3", 5126, 12, 34962},
    [CLAST_GLTF_NORMALS] = {"normals", "NORMAL", "VEC3", 5126, 12, 34962},
    [CLAST_GLTF_TANGENTS] = {"tangents", "TANGENT", "VEC4", 5126, 16, 34962},
    [CLAST_GLTF_COORDINATES] = {"coordinates", "TEXCOORD_0", "VEC2", 5126, 8, 34962},
    [CLAST_GLTF_COLOURS] = {"colours", "COLOR_0", "VEC4", 5123, 8, 34962},
    [CLAST_GLTF_INDICES] = {"indices", NULL, "SCALAR", 5125, 4, 34963},
};

// Buffers beyond this are refused: readers keep offsets in 32 bits.
static const uint64_t STREAM_MOST = 0xfffffff0u;

static bool sound(const clast_gltf_writer *writer)
{
    return writer->outputs->status == CLAST_OK && !writer->failed;
}

// Appends, taking `value` over; gives its number.
static uint32_t append(clast_gltf_writer *writer, json_t *array, json_t *value)
{
    uint32_t number = (uint32_t)json_array_size(array);
    if (json_array_append_new(array, value) != 0) {
        writer->failed = true;
    }
    return number;
}

// Sets a member, taking `value` over.
static void set(clast_gltf_writer *writer, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0) {
        writer->failed = true;
    }
}

static json_t *numbers(const float *values, uint32_t count)
{
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        if (json_array_append_new(array, json_real((double)values[i])) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static json_t *numbers3(vec3 v)
{
    return numbers((float[3]){v[0], v[1], v[2]}, 3);
}

void clast_gltf_begin(clast_gltf_writer *writer, clast_outputs *outputs, const char *name)
{
    *writer = (clast_gltf_writer){.outputs = outputs, .name = name};
    for (uint32_t i = 0; i < CLAST_GLTF_STREAMS; i++) {
        snprintf(writer->stream_names[i], sizeof writer->stream_names[i], "%s_%s.bin", name, streams[i].file);
        writer->streams[i] = clast_outputs_open(outputs, writer->stream_names[i]);
    }
    json_t **arrays[] = {&writer->accessors, &writer->meshes, &writer->nodes,  &writer->materials,
                         &writer->textures,  &writer->images, &writer->cameras};
    for (uint32_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        *arrays[i] = json_array();
        writer->failed |= *arrays[i] == NULL;
    }
    writer->extensions = json_object();
    writer->failed |= writer->extensions == NULL;
}

// ------------------------------------------------------------------------------------------------------ materials

static json_t *texture_reference(clast_gltf_writer *writer, const char *image)
{
    uint32_t number = append(writer, writer->images, json_pack("{s:s}", "uri", image));
    number = append(writer, writer->textures, json_pack("{s:i, s:i}", "sampler", 0, "source", (int)number));
    return json_pack("{s:i}", "index", (int)number);
}

// Takes the extensions over, and notes their names.
static void set_extensions(clast_gltf_writer *writer, json_t *object, json_t *extensions)
{
    const char *name;
    json_t *value;
    json_object_foreach(extensions, name, value)
    {
        set(writer, writer->extensions, name, json_true());
    }
    set(writer, object, "extensions", extensions);
}

uint32_t clast_gltf_add_material(clast_gltf_writer *writer, const clast_gltf_material *material)
{
    json_t *surface = json_pack("{s:f, s:f}", "metallicFactor", (double)material->metallic, "roughnessFactor",
                                (double)material->roughness);
    set(writer, surface, "baseColorFactor",
        numbers((float[4]){material->colour[0], material->colour[1], material->colour[2], 1.0f}, 4));
    if (material->colour_image != NULL) {
        set(writer, surface, "baseColorTexture", texture_reference(writer, material->colour_image));
    }
    if (material->roughness_image != NULL) {
        set(writer, surface, "metallicRoughnessTexture", texture_reference(writer, material->roughness_image));
    }
    json_t *object = json_pack("{s:s}", "name", material->name);
    set(writer, object, "pbrMetallicRoughness", surface);
    if (material->normal_image != NULL) {
        json_t *normal = texture_reference(writer, material->normal_image);
        set(writer, normal, "scale", json_real((double)material->normal_scale));
        set(writer, object, "normalTexture", normal);
    }
    if (material->displacement_image != NULL) {
        json_t *displacement = json_pack("{s:o, s:f, s:f}", "displacementGeometryTexture",
                                         texture_reference(writer, material->displacement_image),
                                         "displacementGeometryFactor", (double)material->displacement_factor,
                                         "displacementGeometryOffset", (double)material->displacement_offset);
        set_extensions(writer, object, json_pack("{s:o}", DISPLACEMENT, displacement));
    }
    if (material->extensions != NULL) {
        set_extensions(writer, object, material->extensions);
    }
    if (material->emissive[0] > 0.0f || material->emissive[1] > 0.0f || material->emissive[2] > 0.0f) {
        set(writer, object, "emissiveFactor", numbers(material->emissive, 3));
    }
    if (material->double_sided) {
        set(writer, object, "doubleSided", json_true());
    }
    return append(writer, writer->materials, object);
}

// --------------------------------------------------------------------------------------------------------- meshes

void clast_gltf_begin_mesh(clast_gltf_writer *writer)
{
    writer->primitives = json_array();
    writer->failed |= writer->primitives == NULL;
}

void clast_gltf_begin_primitive(clast_gltf_writer *writer, uint32_t material)
{
    writer->material = material;
    writer->vertex_count = 0;
    writer->index_count = 0;
    writer->lower = splat3(3e38f);
    writer->upper = splat3(-3e38f);
    for (uint32_t i = 0; i < CLAST_GLTF_STREAMS; i++) {
        writer->first_byte[i] = writer->bytes[i];
    }
}

static void write_stream(clast_gltf_writer *writer, clast_gltf_stream stream, const void *data, uint32_t count)
{
    uint64_t size = (uint64_t)count * streams[stream].bytes;
    if (!sound(writer)) {
        return;
    }
    if (writer->bytes[stream] + size > STREAM_MOST) {
        clast_outputs_note(writer->outputs, clast_fail(writer->outputs->context, CLAST_ERROR_LIMIT,
                                                       "%s: would pass 4 GiB", writer->stream_names[stream]));
        return;
    }
    clast_outputs_note(writer->outputs, clast_file_write(writer->streams[stream], data, (size_t)size));
    writer->bytes[stream] += size;
}

void clast_gltf_add_vertices(clast_gltf_writer *writer, const clast_gltf_vertices *vertices, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        vec3 position = load3(vertices->positions[i]);
        writer->lower = min3(writer->lower, position);
        writer->upper = max3(writer->upper, position);
    }
    const void *data[] = {vertices->positions, vertices->normals, vertices->tangents, vertices->coordinates,
                          vertices->colours};
    for (uint32_t i = 0; i < CLAST_GLTF_INDICES; i++) {
        write_stream(writer, (clast_gltf_stream)i, data[i], count);
    }
    writer->vertex_count += count;
}

void clast_gltf_add_indices(clast_gltf_writer *writer, const uint32_t *indices, uint32_t count)
{
    write_stream(writer, CLAST_GLTF_INDICES, indices, count);
    writer->index_count += count;
    writer->triangle_count += count / 3;
}

static uint32_t add_accessor(clast_gltf_writer *writer, clast_gltf_stream stream, uint64_t count)
{
    json_t *accessor = json_pack(
        "{s:i, s:I, s:i, s:I, s:s}", "bufferView", (int)stream, "byteOffset", (json_int_t)writer->first_byte[stream],
        "componentType", (int)streams[stream].component, "count", (json_int_t)count, "type", streams[stream].type);
    if (stream == CLAST_GLTF_COLOURS) {
        set(writer, accessor, "normalized", json_true());
    }
    if (stream == CLAST_GLTF_POSITIONS) {
        set(writer, accessor, "min", numbers3(writer->lower));
        set(writer, accessor, "max", numbers3(writer->upper));
    }
    return append(writer, writer->accessors, accessor);
}

void clast_gltf_end_primitive(clast_gltf_writer *writer)
{
    if (!sound(writer) || writer->vertex_count == 0 || writer->index_count == 0) {
        return;
    }
    json_t *attributes = json_object();
    for (uint32_t i = 0; i < CLAST_GLTF_INDICES; i++) {
        set(writer, attributes, streams[i].attribute,
            json_integer(add_accessor(writer, (clast_gltf_stream)i, writer->vertex_count)));
    }
    json_t *primitive = json_object();
    set(writer, primitive, "attributes", attributes);
    set(writer, primitive, "indices", json_integer(add_accessor(writer, CLAST_GLTF_INDICES, writer->index_count)));
    set(writer, primitive, "material", json_integer(writer->material));
    append(writer, writer->primitives, primitive);
}

uint32_t clast_gltf_end_mesh(clast_gltf_writer *writer, const char *name)
{
    json_t *mesh = json_pack("{s:s}", "name", name);
    set(writer, mesh, "primitives", writer->primitives);
    writer->primitives = NULL;
    return append(writer, writer->meshes, mesh);
}

// ---------------------------------------------------------------------------------------------------------- nodes

void clast_gltf_add_node(clast_gltf_writer *writer, const char *name, uint32_t mesh, vec3 translation, vec4 rotation,
                         vec3 scale)
{
    json_t *node = json_pack("{s:s, s:i}", "name", name, "mesh", (int)mesh);
    if (translation[0] != 0.0f || translation[1] != 0.0f || translation[2] != 0.0f) {
        set(writer, node, "translation", numbers3(translation));
    }
    if (rotation[3] != 1.0f) {
        set(writer, node, "rotation", numbers((float[4]){rotation[0], rotation[1], rotation[2], rotation[3]}, 4));
    }
    if (scale[0] != 1.0f || scale[1] != 1.0f || scale[2] != 1.0f) {
        set(writer, node, "scale", numbers3(scale));
    }
    append(writer, writer->nodes, node);
}

void clast_gltf_writer_add_camera(clast_gltf_writer *writer, const char *name, vec3 position, vec3 target,
                                  float vertical_angle)
{
    json_t *perspective = json_pack("{s:f, s:f, s:f}", "aspectRatio", 16.0 / 9.0, "yfov", (double)vertical_angle,
                                    "znear", 0.05);
    json_t *camera = json_pack("{s:s, s:s, s:o}", "name", name, "type", "perspective", "perspective", perspective);
    uint32_t number = append(writer, writer->cameras, camera);
    // A camera looks along its -z, with y up: the columns of its matrix.
    vec3 back = normalize3(position - target);
    vec3 right = normalize3(cross3(vec3(0.0f, 1.0f, 0.0f), back));
    vec3 up = cross3(back, right);
    float matrix[16] = {right[0], right[1], right[2], 0.0f, up[0],       up[1],       up[2],       0.0f,
                        back[0],  back[1],  back[2],  0.0f, position[0], position[1], position[2], 1.0f};
    json_t *node = json_pack("{s:s, s:i}", "name", name, "camera", (int)number);
    set(writer, node, "matrix", numbers(matrix, 16));
    append(writer, writer->nodes, node);
}

// ------------------------------------------------------------------------------------------------------- the text

static json_t *document(clast_gltf_writer *writer)
{
    json_t *root = json_pack("{s:{s:s, s:s}, s:i}", "asset", "version", "2.0", "generator", GENERATOR, "scene", 0);
    json_t *roots = json_array(), *buffers = json_array(), *views = json_array();
    for (size_t i = 0; i < json_array_size(writer->nodes); i++) {
        append(writer, roots, json_integer((json_int_t)i));
    }
    if (json_object_size(writer->extensions) > 0) {
        json_t *names = json_array();
        const char *name;
        json_t *value;
        json_object_foreach(writer->extensions, name, value)
        {
            append(writer, names, json_string(name));
        }
        set(writer, root, "extensionsUsed", names);
    }
    set(writer, root, "scenes", json_pack("[{s:s, s:o}]", "name", writer->name, "nodes", roots));
    set(writer, root, "nodes", json_incref(writer->nodes));
    set(writer, root, "meshes", json_incref(writer->meshes));
    set(writer, root, "cameras", json_incref(writer->cameras));
    set(writer, root, "materials", json_incref(writer->materials));
    if (json_array_size(writer->textures) > 0) {
        set(writer, root, "textures", json_incref(writer->textures));
        set(writer, root, "images", json_incref(writer->images));
        // Trilinear, repeating.
        set(writer, root, "samplers",
            json_pack("[{s:i, s:i, s:i, s:i}]", "magFilter", 9729, "minFilter", 9987, "wrapS", 10497, "wrapT", 10497));
    }
    set(writer, root, "accessors", json_incref(writer->accessors));
    for (uint32_t i = 0; i < CLAST_GLTF_STREAMS; i++) {
        json_t *buffer = json_pack("{s:s, s:I}", "uri", writer->stream_names[i], "byteLength",
                                   (json_int_t)writer->bytes[i]);
        append(writer, buffers, buffer);
        json_t *view = json_pack("{s:i, s:i, s:I, s:i}", "buffer", (int)i, "byteOffset", 0, "byteLength",
                                 (json_int_t)writer->bytes[i], "target", (int)streams[i].target);
        if (i != CLAST_GLTF_INDICES) { // several accessors share a view
            set(writer, view, "byteStride", json_integer(streams[i].bytes));
        }
        append(writer, views, view);
    }
    set(writer, root, "bufferViews", views);
    set(writer, root, "buffers", buffers);
    if (writer->extras != NULL) {
        set(writer, root, "extras", json_incref(writer->extras));
    }
    return root;
}

static int write_text(const char *text, size_t size, void *file)
{
    return clast_file_write(file, text, size) == CLAST_OK ? 0 : -1;
}

// Ends the document. Reals get that many digits.
static void write_document_text(clast_file_output *file, json_t *root, int digits)
{
    if (json_dump_callback(root, write_text, file, JSON_INDENT(1) | JSON_REAL_PRECISION(digits)) != 0 &&
        file->status == CLAST_OK) {
        file->status = clast_fail(file->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: out of memory", file->path);
    }
    clast_file_write(file, "\n", 1);
    json_decref(root);
}

void clast_write_scene_file(clast_outputs *outputs, json_t *root)
{
    clast_file_output *file = root != NULL ? clast_outputs_open(outputs, "scene.json") : NULL;
    if (root == NULL) {
        clast_outputs_note(outputs,
                           clast_fail(outputs->context, CLAST_ERROR_OUT_OF_MEMORY, "scene.json: out of memory"));
    } else if (file == NULL) {
        json_decref(root);
    } else {
        write_document_text(file, root, 6);
        clast_outputs_note(outputs, file->status);
    }
}

static void write_document(clast_gltf_writer *writer)
{
    char name[80];
    snprintf(name, sizeof name, "%s.gltf", writer->name);
    clast_file_output *file = clast_outputs_open(writer->outputs, name);
    json_t *root = document(writer);
    if (file != NULL && !writer->failed) {
        write_document_text(file, root, 9); // 9 digits tell any float from its neighbours
        clast_outputs_note(writer->outputs, file->status);
    } else {
        json_decref(root);
    }
}

void clast_gltf_end(clast_gltf_writer *writer)
{
    if (sound(writer)) {
        write_document(writer);
    }
    json_t *arrays[] = {writer->accessors, writer->meshes,  writer->nodes,      writer->materials, writer->textures,
                        writer->images,    writer->cameras, writer->primitives, writer->extras,    writer->extensions};
    for (uint32_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
        json_decref(arrays[i]);
    }
    if (writer->failed) {
        clast_outputs_note(writer->outputs, clast_fail(writer->outputs->context, CLAST_ERROR_OUT_OF_MEMORY,
                                                       "%s.gltf: out of memory", writer->name));
    }
}
