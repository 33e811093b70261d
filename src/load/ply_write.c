// SPDX-License-Identifier: Apache-2.0
// Binary PLY. (G. Turk, The PLY Polygon File Format, 1994.)
#include <string.h>

#include "load/bytes.h"
#include "load/mesh_write.h"

enum { CHUNK = 1 << 14 }; // vertices or triangles that are written at once

typedef struct ply_writer {
    const clast_write_model *model;
    clast_file_output output;
    bool has_coordinates;
    uint64_t vertices, triangles, done;
    unsigned char *chunk;
} ply_writer;

// Numbers of the file are little endian.
static unsigned char *put_word(unsigned char *to, uint32_t word)
{
    to[0] = (unsigned char)word;
    to[1] = (unsigned char)(word >> 8);
    to[2] = (unsigned char)(word >> 16);
    to[3] = (unsigned char)(word >> 24);
    return to + 4;
}

static unsigned char *put_float(unsigned char *to, float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    return put_word(to, word);
}

static unsigned char *put_vector(unsigned char *to, vec3 v)
{
    return put_float(put_float(put_float(to, v[0]), v[1]), v[2]);
}

static bool go_on(ply_writer *writer, const unsigned char *end, uint64_t items)
{
    clast_file_output *output = &writer->output;
    clast_file_write(output, writer->chunk, (size_t)(end - writer->chunk));
    writer->done += items;
    if (output->status == CLAST_OK) {
        output->status = clast_progress(output->context, "write", writer->done, writer->vertices + writer->triangles);
    }
    return output->status == CLAST_OK;
}

static vec3 vector_at(const float *array, size_t i)
{
    return vec3(array[3 * i], array[3 * i + 1], array[3 * i + 2]);
}

// The cofactors of the linear part: what normals go by, but for their length and, where the map mirrors, their sign.
static clast_transform normal_map(const clast_transform *t)
{
    vec3 x = vec3(t->rows[0].v[0], t->rows[0].v[1], t->rows[0].v[2]);
    vec3 y = vec3(t->rows[1].v[0], t->rows[1].v[1], t->rows[1].v[2]);
    vec3 z = vec3(t->rows[2].v[0], t->rows[2].v[1], t->rows[2].v[2]);
    float side = transform_determinant(*t) < 0.0f ? -1.0f : 1.0f;
    vec3 a = cross3(y, z) * side, b = cross3(z, x) * side, c = cross3(x, y) * side;
    return transform_rows(vec4(a[0], a[1], a[2], 0.0f), vec4(b[0], b[1], b[2], 0.0f), vec4(c[0], c[1], c[2], 0.0f));
}

static vec3 unit(vec3 v)
{
    float largest = largest3(vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])));
    return largest > 0.0f ? normalize3(v * (1.0f / largest)) : v;
}

static bool write_vertices(ply_writer *writer, const clast_write_instance *instance)
{
    const clast_mesh *mesh = writer->model->meshes[instance->mesh];
    clast_transform normals = normal_map(&instance->to_world);
    for (size_t first = 0; first < mesh->vertex_count; first += CHUNK) {
        size_t end = mesh->vertex_count - first < CHUNK ? mesh->vertex_count : first + CHUNK;
        unsigned char *to = writer->chunk;
        for (size_t i = first; i < end; i++) {
            to = put_vector(to, transform_point(instance->to_world, vector_at(mesh->positions, i)));
            to = put_vector(to, unit(transform_vector(normals, vector_at(mesh->normals, i))));
            if (writer->has_coordinates) {
                const float *uv = mesh->coordinates[0] != NULL ? mesh->coordinates[0] + 2 * i : NULL;
                to = put_float(to, uv != NULL ? uv[0] : 0.0f);
                to = put_float(to, uv != NULL ? 1.0f - uv[1] : 0.0f); // t goes up
            }
        }
        if (!go_on(writer, to, end - first)) {
            return false;
        }
    }
    return true;
}

static bool write_triangles(ply_writer *writer, const clast_write_instance *instance, uint32_t base)
{
    const clast_mesh *mesh = writer->model->meshes[instance->mesh];
    bool is_mirrored = transform_determinant(instance->to_world) < 0.0f;
    for (size_t first = 0; first < mesh->triangle_count; first += CHUNK) {
        size_t end = mesh->triangle_count - first < CHUNK ? mesh->triangle_count : first + CHUNK;
        unsigned char *to = writer->chunk;
        for (size_t i = first; i < end; i++) {
            const uint32_t *corners = mesh->indices + 3 * i;
            *to++ = 3;
            to = put_word(to, base + corners[0]);
            to = put_word(to, base + corners[is_mirrored ? 2 : 1]);
            to = put_word(to, base + corners[is_mirrored ? 1 : 2]);
        }
        if (!go_on(writer, to, end - first)) {
            return false;
        }
    }
    return true;
}

static void write_header(ply_writer *writer)
{
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz", "s", "t"};
    clast_file_output *output = &writer->output;
    clast_file_print(output, "ply\nformat binary_little_endian 1.0\nelement vertex %llu\n",
                     (unsigned long long)writer->vertices);
    for (size_t i = 0; i < (writer->has_coordinates ? 8 : 6); i++) {
        clast_file_print(output, "property float %s\n", names[i]);
    }
    clast_file_print(output, "element face %llu\nproperty list uchar int vertex_indices\nend_header\n",
                     (unsigned long long)writer->triangles);
}

static void write_model(ply_writer *writer)
{
    const clast_write_model *model = writer->model;
    write_header(writer);
    for (size_t i = 0; i < model->instance_count; i++) {
        if (!write_vertices(writer, &model->instances[i])) {
            return;
        }
    }
    uint32_t base = 0;
    for (size_t i = 0; i < model->instance_count; i++) {
        if (!write_triangles(writer, &model->instances[i], base)) {
            return;
        }
        base += model->meshes[model->instances[i].mesh]->vertex_count;
    }
}

clast_status clast_ply_write(clast_context *context, const char *path, const clast_write_model *model)
{
    ply_writer writer = {.model = model};
    for (size_t i = 0; i < model->instance_count; i++) {
        const clast_mesh *mesh = model->meshes[model->instances[i].mesh];
        writer.vertices += mesh->vertex_count;
        writer.triangles += mesh->triangle_count;
        writer.has_coordinates = writer.has_coordinates || mesh->coordinates[0] != NULL;
    }
    if (writer.vertices > INT32_MAX) { // indices are signed: no other type is read everywhere
        return clast_fail(context, CLAST_ERROR_LIMIT, "%s: %llu vertices: a PLY file holds at most %d", path,
                          (unsigned long long)writer.vertices, INT32_MAX);
    }
    writer.chunk = clast_allocate(context, CHUNK, 8 * sizeof(float));
    if (writer.chunk == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_file_create(context, path, &writer.output);
    if (status == CLAST_OK) {
        write_model(&writer);
        status = clast_file_commit(&writer.output);
    }
    clast_free(context, writer.chunk);
    return status;
}
