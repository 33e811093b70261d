// SPDX-License-Identifier: Apache-2.0
// Writes glTF 2.0. Section numbers cite the specification (Khronos Group, 2021). A buffer is a row of pieces, each a multiple of
// four bytes; where the machine's numbers are little endian, arrays are written as they lie in memory.
#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "clast/version.h"
#include "load/gltf_write.h"

enum { ARRAY_TARGET = 34962, INDEX_TARGET = 34963, FLOAT_TYPE = 5126, UINT_TYPE = 5125 };

void clast_gltf_write_set(clast_gltf_writer *writer, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0) {
        writer->failed = true;
    }
}

uint32_t clast_gltf_write_append(clast_gltf_writer *writer, json_t *array, json_t *value)
{
    uint32_t number = (uint32_t)json_array_size(array);
    if (json_array_append_new(array, value) != 0) {
        writer->failed = true;
    }
    return number;
}

json_t *clast_gltf_write_numbers(const float *values, uint32_t count)
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

// Names that are not UTF-8 are left out.
void clast_gltf_write_name(clast_gltf_writer *writer, json_t *object, const char *name)
{
    json_t *text = name != NULL && name[0] != '\0' ? json_string(name) : NULL;
    if (text != NULL) {
        clast_gltf_write_set(writer, object, "name", text);
    }
}

// ------------------------------------------------------------------------------------------------------------ buffer

uint32_t clast_gltf_write_piece(clast_gltf_writer *writer, const void *data, uint64_t size, void *owned, int target)
{
    clast_context *context = writer->context;
    clast_status status = CLAST_RESERVE(context, writer->pieces, writer->piece_capacity, writer->piece_count + 1);
    if (status != CLAST_OK) {
        clast_free(context, owned);
        writer->failed = true;
        return 0;
    }
    writer->pieces[writer->piece_count++] = (clast_gltf_piece){data, size, owned};
    json_t *view = json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)writer->length, "byteLength",
                             (json_int_t)size);
    if (target != 0) {
        clast_gltf_write_set(writer, view, "target", json_integer(target));
    }
    writer->length += (size + 3) / 4 * 4;
    return clast_gltf_write_append(writer, writer->views, view);
}

static uint32_t add_accessor(clast_gltf_writer *writer, uint32_t view, uint64_t offset, int component, uint64_t count,
                             const char *type)
{
    json_t *accessor = json_pack("{s:i, s:I, s:i, s:I, s:s}", "bufferView", (int)view, "byteOffset", (json_int_t)offset,
                                 "componentType", component, "count", (json_int_t)count, "type", type);
    return clast_gltf_write_append(writer, writer->accessors, accessor);
}

// An attribute's accessor in `attributes`.
static void add_attribute(clast_gltf_writer *writer, json_t *attributes, const char *name, const float *values,
                          uint64_t count, uint32_t width)
{
    static const char *const types[] = {"", "", "VEC2", "VEC3", "VEC4"};
    uint32_t view = clast_gltf_write_piece(writer, values, count * width * sizeof *values, NULL, ARRAY_TARGET);
    uint32_t accessor = add_accessor(writer, view, 0, FLOAT_TYPE, count, types[width]);
    clast_gltf_write_set(writer, attributes, name, json_integer(accessor));
}

// ------------------------------------------------------------------------------------------------------------ meshes

static void set_bounds(clast_gltf_writer *writer, const json_t *attributes, const clast_mesh *mesh)
{
    float lower[3], upper[3];
    memcpy(lower, mesh->positions, sizeof lower);
    memcpy(upper, mesh->positions, sizeof upper);
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++) {
        lower[i % 3] = min1(lower[i % 3], mesh->positions[i]);
        upper[i % 3] = max1(upper[i % 3], mesh->positions[i]);
    }
    json_int_t number = json_integer_value(json_object_get(attributes, "POSITION"));
    json_t *accessor = json_array_get(writer->accessors, (size_t)number);
    clast_gltf_write_set(writer, accessor, "min", clast_gltf_write_numbers(lower, 3));
    clast_gltf_write_set(writer, accessor, "max", clast_gltf_write_numbers(upper, 3));
}

static json_t *make_attributes(clast_gltf_writer *writer, const clast_mesh *mesh)
{
    json_t *attributes = json_object();
    uint64_t count = mesh->vertex_count;
    add_attribute(writer, attributes, "POSITION", mesh->positions, count, 3);
    add_attribute(writer, attributes, "NORMAL", mesh->normals, count, 3);
    if (mesh->coordinates[0] != NULL) {
        add_attribute(writer, attributes, "TEXCOORD_0", mesh->coordinates[0], count, 2);
    }
    if (mesh->coordinates[1] != NULL) {
        add_attribute(writer, attributes, "TEXCOORD_1", mesh->coordinates[1], count, 2);
    }
    if (mesh->colours != NULL) {
        add_attribute(writer, attributes, "COLOR_0", mesh->colours, count, 4);
    }
    set_bounds(writer, attributes, mesh);
    return attributes;
}

// Adds a primitive of `count` triangles from the `first` of the index view on.
static void add_primitive(clast_gltf_writer *writer, json_t *primitives, json_t *attributes, uint32_t view,
                          uint64_t first, uint64_t count, uint32_t material)
{
    uint32_t indices = add_accessor(writer, view, 12 * first, UINT_TYPE, 3 * count, "SCALAR");
    json_t *primitive = json_pack("{s:O, s:i, s:i}", "attributes", attributes, "indices", (int)indices, "material",
                                  (int)clast_gltf_write_material(writer, material));
    clast_gltf_write_append(writer, primitives, primitive);
}

// The indices in order of material, in a new block; `starts` is where each material's triangles begin, one more than there
// are materials. Null where memory ran out.
static uint32_t *sort_indices(clast_gltf_writer *writer, const clast_mesh *mesh, uint32_t *starts)
{
    size_t materials = writer->model->scene->material_count;
    uint32_t *indices = clast_allocate(writer->context, mesh->triangle_count, 3 * sizeof *indices);
    if (indices == NULL) {
        return NULL;
    }
    memset(starts, 0, (materials + 2) * sizeof *starts);
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        starts[mesh->triangle_materials[i] + 2]++;
    }
    for (size_t i = 2; i < materials + 2; i++) {
        starts[i] += starts[i - 1];
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        uint32_t to = starts[mesh->triangle_materials[i] + 1]++;
        memcpy(indices + 3 * (size_t)to, mesh->indices + 3 * i, 3 * sizeof *indices);
    }
    return indices;
}

static void add_mesh(clast_gltf_writer *writer, const clast_mesh *mesh, const char *name)
{
    json_t *primitives = json_array();
    json_t *attributes = make_attributes(writer, mesh);
    uint64_t size = 12 * (uint64_t)mesh->triangle_count;
    if (mesh->triangle_materials == NULL) {
        uint32_t view = clast_gltf_write_piece(writer, mesh->indices, size, NULL, INDEX_TARGET);
        add_primitive(writer, primitives, attributes, view, 0, mesh->triangle_count, mesh->material);
    } else {
        uint32_t *indices = sort_indices(writer, mesh, writer->starts);
        writer->failed = writer->failed || indices == NULL;
        uint32_t view = indices != NULL ? clast_gltf_write_piece(writer, indices, size, indices, INDEX_TARGET) : 0;
        for (size_t i = 0; i < writer->model->scene->material_count && !writer->failed; i++) {
            uint32_t first = writer->starts[i], end = writer->starts[i + 1];
            if (end > first) {
                add_primitive(writer, primitives, attributes, view, first, end - first, (uint32_t)i);
            }
        }
    }
    json_decref(attributes);
    json_t *object = json_object();
    clast_gltf_write_name(writer, object, name);
    clast_gltf_write_set(writer, object, "primitives", primitives);
    clast_gltf_write_append(writer, writer->meshes, object);
}

static void add_node(clast_gltf_writer *writer, const clast_write_instance *instance)
{
    json_t *node = json_pack("{s:i}", "mesh", (int)instance->mesh);
    clast_gltf_write_name(writer, node, instance->name);
    float matrix[16] = {[15] = 1.0f};
    bool is_identity = true;
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++) {
            matrix[4 * column + row] = instance->to_world.rows[row].v[column];
            is_identity = is_identity && instance->to_world.rows[row].v[column] == (row == column ? 1.0f : 0.0f);
        }
    }
    if (!is_identity) {
        clast_gltf_write_set(writer, node, "matrix", clast_gltf_write_numbers(matrix, 16));
    }
    clast_gltf_write_append(writer, writer->roots, json_integer(clast_gltf_write_append(writer, writer->nodes, node)));
}

// ------------------------------------------------------------------------------------------------------------- files

// A list must not be empty (section 5): it is left out then.
static void set_list(clast_gltf_writer *writer, json_t *root, const char *key, json_t *list)
{
    if (json_array_size(list) != 0) {
        clast_gltf_write_set(writer, root, key, json_incref(list));
    }
}

static json_t *make_document(clast_gltf_writer *writer, const char *buffer_name)
{
    char generator[40];
    snprintf(generator, sizeof generator, "clast %d.%d.%d", CLAST_VERSION_MAJOR, CLAST_VERSION_MINOR,
             CLAST_VERSION_PATCH);
    json_t *root = json_pack("{s:{s:s, s:s}, s:i, s:[{s:O}]}", "asset", "version", "2.0", "generator", generator,
                             "scene", 0, "scenes", "nodes", writer->roots);
    json_t *buffer = json_pack("{s:I}", "byteLength", (json_int_t)writer->length);
    if (buffer_name != NULL) {
        clast_gltf_write_set(writer, buffer, "uri", json_string(buffer_name));
    }
    set_list(writer, root, "extensionsUsed", writer->extensions);
    clast_gltf_write_set(writer, root, "buffers", json_pack("[o]", buffer));
    set_list(writer, root, "bufferViews", writer->views);
    set_list(writer, root, "accessors", writer->accessors);
    set_list(writer, root, "meshes", writer->meshes);
    set_list(writer, root, "nodes", writer->nodes);
    set_list(writer, root, "materials", writer->materials);
    set_list(writer, root, "textures", writer->textures);
    set_list(writer, root, "samplers", writer->samplers);
    set_list(writer, root, "images", writer->images);
    return root;
}

static void write_pieces(clast_gltf_writer *writer, clast_file_output *output)
{
    static const char nothing[4] = {0};
    uint64_t done = 0;
    for (size_t i = 0; i < writer->piece_count && output->status == CLAST_OK; i++) {
        const clast_gltf_piece *piece = &writer->pieces[i];
        clast_file_write(output, piece->data, (size_t)piece->size);
        clast_file_write(output, nothing, (size_t)((4 - piece->size % 4) % 4));
        done += piece->size;
        if (output->status == CLAST_OK) {
            output->status = clast_progress(writer->context, "write", done, writer->length);
        }
    }
}

static void put_header(clast_file_output *output, uint32_t a, uint32_t b)
{
    clast_file_write(output, &a, sizeof a);
    clast_file_write(output, &b, sizeof b);
}

// Section 4.4: a header, the JSON padded with blanks, the buffer padded with zeros.
static void write_binary(clast_gltf_writer *writer, clast_file_output *output, const char *text)
{
    enum { MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BINARY_CHUNK = 0x004e4942, HEADERS = 12 + 8 + 8 };
    uint64_t length = strlen(text), padded = (length + 3) / 4 * 4, size = HEADERS + padded + writer->length;
    if (size > UINT32_MAX) {
        output->status = clast_fail(writer->context, CLAST_ERROR_LIMIT,
                                    "%s: %llu bytes: a .glb file ends at 4 GiB, a .gltf does not", output->path,
                                    (unsigned long long)size);
        return;
    }
    put_header(output, MAGIC, 2);
    put_header(output, (uint32_t)size, (uint32_t)padded);
    uint32_t kind = JSON_CHUNK;
    clast_file_write(output, &kind, sizeof kind);
    clast_file_write(output, text, (size_t)length);
    clast_file_write(output, "   ", (size_t)(padded - length));
    put_header(output, (uint32_t)writer->length, BINARY_CHUNK);
    write_pieces(writer, output);
}

static clast_status write_files(clast_gltf_writer *writer, const char *text)
{
    clast_context *context = writer->context;
    clast_file_output main_file, buffer;
    clast_status status = clast_file_create(context, writer->path, &main_file);
    if (status != CLAST_OK || writer->is_binary) {
        if (status == CLAST_OK) {
            write_binary(writer, &main_file, text);
            status = clast_file_commit(&main_file);
        }
        return status;
    }
    clast_file_write(&main_file, text, strlen(text));
    clast_file_write(&main_file, "\n", 1);
    char *path = clast_path_beside(context, writer->path, writer->buffer_name);
    status = path != NULL ? clast_file_create(context, path, &buffer) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        write_pieces(writer, &buffer);
        status = clast_file_commit(&buffer);
    }
    if (status == CLAST_OK) {
        status = clast_gltf_write_images(writer);
    }
    if (status == CLAST_OK) {
        status = clast_file_commit(&main_file); // last: what it names is there
    } else {
        clast_file_discard(&main_file);
    }
    clast_free(context, path);
    return status;
}

// ------------------------------------------------------------------------------------------------------------- whole

// The file's name without folder and extension, with something else after it.
static void make_stem(clast_gltf_writer *writer)
{
    const char *slash = strrchr(writer->path, '/');
    const char *name = slash != NULL ? slash + 1 : writer->path;
    const char *dot = strrchr(name, '.');
    int length = dot != NULL && dot != name ? (int)(dot - name) : (int)strlen(name);
    snprintf(writer->stem, sizeof writer->stem, "%.*s", length < 200 ? length : 200, name);
    snprintf(writer->buffer_name, sizeof writer->buffer_name, "%s.bin", writer->stem);
}

static bool begin(clast_gltf_writer *writer)
{
    const clast_scene *scene = writer->model->scene;
    json_t **lists[] = {&writer->extensions, &writer->views,   &writer->accessors, &writer->meshes,
                        &writer->nodes,      &writer->roots,   &writer->materials, &writer->textures,
                        &writer->images,     &writer->samplers};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        *lists[i] = json_array();
        writer->failed = writer->failed || *lists[i] == NULL;
    }
    writer->material_numbers = clast_allocate(writer->context, scene->material_count, sizeof(uint32_t));
    writer->texture_numbers = clast_allocate(writer->context, scene->texture_count, sizeof(uint32_t));
    writer->image_numbers = clast_allocate(writer->context, scene->image_count, sizeof(uint32_t));
    writer->image_is_colour = clast_allocate_zeroed(writer->context, scene->image_count, sizeof(bool));
    writer->starts = clast_allocate(writer->context, scene->material_count + 2, sizeof(uint32_t));
    if (writer->material_numbers == NULL || writer->texture_numbers == NULL || writer->image_numbers == NULL ||
        writer->image_is_colour == NULL || writer->starts == NULL) {
        return false;
    }
    memset(writer->material_numbers, 0xff, scene->material_count * sizeof(uint32_t));
    memset(writer->texture_numbers, 0xff, scene->texture_count * sizeof(uint32_t));
    memset(writer->image_numbers, 0xff, scene->image_count * sizeof(uint32_t));
    return !writer->failed;
}

static void end(clast_gltf_writer *writer)
{
    json_t *lists[] = {writer->extensions, writer->views,     writer->accessors, writer->meshes, writer->nodes,
                       writer->roots,      writer->materials, writer->textures,  writer->images, writer->samplers};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        json_decref(lists[i]);
    }
    for (size_t i = 0; i < writer->piece_count; i++) {
        clast_free(writer->context, writer->pieces[i].owned);
    }
    clast_free(writer->context, writer->pieces);
    clast_free(writer->context, writer->material_numbers);
    clast_free(writer->context, writer->texture_numbers);
    clast_free(writer->context, writer->image_numbers);
    clast_free(writer->context, writer->image_is_colour);
    clast_free(writer->context, writer->starts);
}

static clast_status write_all(clast_gltf_writer *writer)
{
    const clast_write_model *model = writer->model;
    if (!begin(writer)) {
        return clast_fail(writer->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: memory ran out", writer->path);
    }
    for (size_t i = 0; i < model->mesh_count; i++) {
        add_mesh(writer, model->meshes[i], model->names[i]);
    }
    for (size_t i = 0; i < model->instance_count; i++) {
        add_node(writer, &model->instances[i]);
    }
    if (writer->status != CLAST_OK) {
        return writer->status;
    }
    json_t *root = make_document(writer, writer->is_binary ? NULL : writer->buffer_name);
    char *text = root != NULL && !writer->failed
                     ? json_dumps(root, (writer->is_binary ? JSON_COMPACT : JSON_INDENT(1)) | JSON_REAL_PRECISION(9))
                     : NULL;
    json_decref(root);
    clast_status status = text != NULL ? write_files(writer, text)
                                       : clast_fail(writer->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: memory ran out",
                                                    writer->path);
    free(text);
    return status;
}

clast_status clast_gltf_write(clast_context *context, const char *path, bool is_binary, const clast_write_model *model)
{
    clast_gltf_writer writer = {.context = context, .path = path, .is_binary = is_binary, .model = model};
    make_stem(&writer);
    clast_status status = write_all(&writer);
    end(&writer);
    return status;
}
