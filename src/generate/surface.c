// SPDX-License-Identifier: Apache-2.0
#include "generate/surface.h"

#include "base/thread.h"

// Vertices of a strip, about: bounds the memory of a sheet of any size.
enum { STRIP_VERTICES = 1 << 17 };

// A grid of evaluated points on its way to the files.
typedef struct strip {
    const clast_sheet *sheet;
    const clast_block *block; // where it is a block's face
    clast_builder *builder;
    uint32_t face;
    const float *face_u, *face_v;  // lattice coordinates of a block's face
    uint32_t first_row, row_count; // vertex rows that are written
    uint32_t before;               // rows evaluated before the first written one
    uint32_t evaluated_rows;
} strip;

static uint32_t vertex_columns(const strip *s)
{
    return s->sheet->columns + 1;
}

// ----------------------------------------------------------------------------------------------------- evaluation

static vec3 face_point(uint32_t face, float a, float b)
{
    float side = (face & 1) != 0 ? 1.0f : -1.0f;
    switch (face / 2) {
    case 0: return vec3(side, a, b);
    case 1: return vec3(b, side, a);
    default: return vec3(a, b, side);
    }
}

static void evaluate_point(const strip *s, uint32_t column, int64_t row, clast_surface_point *point)
{
    const clast_sheet *sheet = s->sheet;
    *point = (clast_surface_point){.colour = splat3(1.0f)};
    if (s->block != NULL) {
        s->block->evaluate(s->block->shape, face_point(s->face, s->face_u[column], s->face_v[row]), s->face, point);
        return;
    }
    int64_t rows = sheet->rows;
    if (sheet->wraps_rows) {
        row = row < 0 ? row + rows : row > rows ? row - rows : row;
    }
    float u = (float)column / (float)sheet->columns, v = (float)row / (float)rows;
    sheet->evaluate(sheet->shape, u, v, point);
    // The seam's two sides are the same points to the bit.
    bool seam_column = sheet->wraps_columns && column == sheet->columns, seam_row = sheet->wraps_rows && row == rows;
    if (seam_column || seam_row) {
        clast_surface_point first = {.colour = splat3(1.0f)};
        sheet->evaluate(sheet->shape, seam_column ? 0.0f : u, seam_row ? 0.0f : v, &first);
        first.coordinates = point->coordinates;
        *point = first;
    }
}

static void evaluate_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const strip *s = data;
    uint32_t columns = vertex_columns(s);
    for (size_t i = begin; i < end; i++) {
        int64_t row = (int64_t)s->first_row - s->before + (int64_t)(i / columns);
        evaluate_point(s, (uint32_t)(i % columns), row, &s->builder->points[i]);
    }
}

// --------------------------------------------------------------------------------------------------------- frames

typedef struct difference {
    vec3 position;
    vec2 coordinates;
} difference;

static difference subtract(const clast_surface_point *a, const clast_surface_point *b)
{
    return (difference){a->position - b->position, a->coordinates - b->coordinates};
}

// Differences along u and v around a point of the strip: over two steps, one at a border. At a seam the texture
// coordinates jump, and are taken over one step, twice.
static void differences(const strip *s, uint32_t column, uint32_t row, difference *along_u, difference *along_v)
{
    const clast_sheet *sheet = s->sheet;
    uint32_t columns = sheet->columns;
    const clast_surface_point *line = s->builder->points + (size_t)row * (columns + 1);
    uint32_t left = column > 0 ? column - 1 : column, right = column < columns ? column + 1 : column;
    *along_u = subtract(&line[right], &line[left]);
    if (sheet->wraps_columns && (column == 0 || column == columns)) {
        along_u->position = line[1].position - line[columns - 1].position;
        along_u->coordinates = along_u->coordinates * 2.0f;
    }
    const clast_surface_point *at = line + column;
    const clast_surface_point *up = row > 0 ? at - (columns + 1) : at;
    const clast_surface_point *down = row + 1 < s->evaluated_rows ? at + (columns + 1) : at;
    *along_v = subtract(down, up);
    uint32_t sheet_row = s->first_row + row - s->before;
    if (sheet->wraps_rows && (sheet_row == 0 || sheet_row == sheet->rows)) {
        along_v->coordinates = (sheet_row == 0 ? subtract(down, at) : subtract(at, up)).coordinates * 2.0f;
    }
}

// Unit normal; where the grid degenerates (a pole), from the row beside.
static vec3 normal_at(const strip *s, uint32_t column, uint32_t row, vec3 along_u, vec3 along_v)
{
    vec3 normal = cross3(along_u, along_v);
    if (dot3(along_u, along_u) < 1e-12f) {
        uint32_t beside = row + 1 < s->evaluated_rows && row == s->before ? row + 1 : row - 1;
        difference u, v;
        differences(s, column, beside < s->evaluated_rows ? beside : row, &u, &v);
        normal = cross3(u.position, along_v);
    }
    normal = s->sheet->flipped ? normal * -1.0f : normal;
    // Scaled first: the square of a fine grid's cross product may have no bits left.
    float largest = max1(abs1(normal[0]), max1(abs1(normal[1]), abs1(normal[2])));
    return largest > 0.0f ? normalize3(normal * (1.0f / largest)) : vec3(0.0f, 1.0f, 0.0f);
}

static vec3 any_tangent(vec3 normal)
{
    return normalize3(cross3(normal, abs1(normal[0]) < 0.6f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 0.0f, 1.0f)));
}

// The tangent is the way in which u of the texture grows; cross(normal, tangent) * sign the way in which its v falls,
// since glTF's normal maps have green up while v goes down.
static packed4 tangent_at(difference a, difference b, vec3 normal)
{
    float determinant = a.coordinates[0] * b.coordinates[1] - a.coordinates[1] * b.coordinates[0];
    vec3 tangent = (a.position * b.coordinates[1] - b.position * a.coordinates[1]) *
                   (determinant < 0.0f ? -1.0f : 1.0f);
    vec3 fall = (a.position * b.coordinates[0] - b.position * a.coordinates[0]) * (determinant < 0.0f ? 1.0f : -1.0f);
    float largest = max1(abs1(tangent[0]), max1(abs1(tangent[1]), abs1(tangent[2])));
    tangent = largest > 0.0f ? tangent * (1.0f / largest) : tangent;
    tangent = tangent - normal * dot3(normal, tangent);
    tangent = dot3(tangent, tangent) > 1e-8f ? normalize3(tangent) : any_tangent(normal);
    float sign = dot3(cross3(normal, tangent), fall) < 0.0f ? -1.0f : 1.0f;
    return store4(vec4(tangent[0], tangent[1], tangent[2], sign));
}

static uint16_t to_unorm16(float x)
{
    return (uint16_t)(clamp1(x, 0.0f, 1.0f) * 65535.0f + 0.5f);
}

static void finish_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const strip *s = data;
    clast_builder *builder = s->builder;
    uint32_t columns = vertex_columns(s);
    for (size_t i = begin; i < end; i++) {
        uint32_t column = (uint32_t)(i % columns), row = (uint32_t)(i / columns) + s->before;
        const clast_surface_point *point = &builder->points[(size_t)row * columns + column];
        difference u, v;
        differences(s, column, row, &u, &v);
        vec3 normal = point->normal;
        if (normal[0] == 0.0f && normal[1] == 0.0f && normal[2] == 0.0f) {
            normal = normal_at(s, column, row, u.position, v.position);
        }
        builder->positions[i] = store3(point->position);
        builder->normals[i] = store3(normal);
        builder->tangents[i] = tangent_at(u, v, normal);
        builder->coordinates[i] = store2(point->coordinates);
        builder->colours[i][0] = to_unorm16(point->colour[0]);
        builder->colours[i][1] = to_unorm16(point->colour[1]);
        builder->colours[i][2] = to_unorm16(point->colour[2]);
        builder->colours[i][3] = 65535;
    }
}

// -------------------------------------------------------------------------------------------------------- writing

static void note(clast_builder *builder, clast_status status)
{
    clast_outputs_note(builder->writer->outputs, status);
}

static bool sound(const clast_builder *builder)
{
    return builder->writer->outputs->status == CLAST_OK;
}

static void free_buffers(clast_builder *builder)
{
    clast_free(builder->context, builder->positions);
    clast_free(builder->context, builder->normals);
    clast_free(builder->context, builder->tangents);
    clast_free(builder->context, builder->coordinates);
    clast_free(builder->context, builder->colours);
    builder->positions = builder->normals = NULL;
    builder->tangents = NULL;
    builder->coordinates = NULL;
    builder->colours = NULL;
    builder->vertex_capacity = 0;
}

static bool reserve(clast_builder *builder, size_t points, size_t vertices, size_t indices)
{
    note(builder, CLAST_RESERVE(builder->context, builder->points, builder->point_capacity, points));
    note(builder, CLAST_RESERVE(builder->context, builder->indices, builder->index_capacity, indices));
    if (!sound(builder) || vertices <= builder->vertex_capacity) {
        return sound(builder);
    }
    free_buffers(builder);
    builder->positions = clast_allocate(builder->context, vertices, sizeof *builder->positions);
    builder->normals = clast_allocate(builder->context, vertices, sizeof *builder->normals);
    builder->tangents = clast_allocate(builder->context, vertices, sizeof *builder->tangents);
    builder->coordinates = clast_allocate(builder->context, vertices, sizeof *builder->coordinates);
    builder->colours = clast_allocate(builder->context, vertices, sizeof *builder->colours);
    if (builder->positions == NULL || builder->normals == NULL || builder->tangents == NULL ||
        builder->coordinates == NULL || builder->colours == NULL) {
        note(builder, CLAST_ERROR_OUT_OF_MEMORY);
        return false;
    }
    builder->vertex_capacity = vertices;
    return true;
}

void clast_builder_end(clast_builder *builder)
{
    free_buffers(builder);
    clast_free(builder->context, builder->points);
    clast_free(builder->context, builder->indices);
    *builder = (clast_builder){0};
}

static bool same_place(const clast_surface_point *points, size_t a, size_t b)
{
    vec3 p = points[a].position, q = points[b].position;
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static uint32_t add_triangle(uint32_t *indices, const clast_surface_point *points, const size_t at[3],
                             const uint32_t number[3], bool flipped)
{
    if (same_place(points, at[0], at[1]) || same_place(points, at[1], at[2]) || same_place(points, at[2], at[0])) {
        return 0; // at a pole
    }
    indices[0] = number[0];
    indices[1] = number[flipped ? 2 : 1];
    indices[2] = number[flipped ? 1 : 2];
    return 3;
}

// Quads between written rows, and between the first of them and the row before it, which the strip before wrote.
static uint32_t write_quads(const strip *s, uint32_t base)
{
    const clast_builder *builder = s->builder;
    uint32_t columns = s->sheet->columns, count = 0;
    for (uint32_t j = s->first_row > 0 ? 0 : 1; j < s->row_count; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            size_t at_upper = (size_t)(j + s->before - 1) * (columns + 1) + i, at_lower = at_upper + columns + 1;
            uint32_t lower = base + (s->first_row + j) * (columns + 1) + i, upper = lower - (columns + 1);
            // Alternate diagonals: no direction is preferred.
            if (((i + s->first_row + j) & 1) != 0) {
                count += add_triangle(builder->indices + count, builder->points,
                                      (size_t[3]){at_upper, at_upper + 1, at_lower + 1},
                                      (uint32_t[3]){upper, upper + 1, lower + 1}, s->sheet->flipped);
                count += add_triangle(builder->indices + count, builder->points,
                                      (size_t[3]){at_upper, at_lower + 1, at_lower},
                                      (uint32_t[3]){upper, lower + 1, lower}, s->sheet->flipped);
            } else {
                count += add_triangle(builder->indices + count, builder->points,
                                      (size_t[3]){at_upper, at_upper + 1, at_lower},
                                      (uint32_t[3]){upper, upper + 1, lower}, s->sheet->flipped);
                count += add_triangle(builder->indices + count, builder->points,
                                      (size_t[3]){at_upper + 1, at_lower + 1, at_lower},
                                      (uint32_t[3]){upper + 1, lower + 1, lower}, s->sheet->flipped);
            }
        }
    }
    return count;
}

static void write_strip(strip *s, uint32_t base)
{
    clast_builder *builder = s->builder;
    size_t columns = vertex_columns(s);
    size_t points = columns * s->evaluated_rows, vertices = columns * s->row_count;
    if (!reserve(builder, points, vertices, vertices * 6)) {
        return;
    }
    clast_parallel_for(builder->context, points, 512, evaluate_rows, s);
    clast_parallel_for(builder->context, vertices, 4096, finish_rows, s);
    clast_gltf_add_vertices(builder->writer,
                            &(clast_gltf_vertices){builder->positions, builder->normals, builder->tangents,
                                                   builder->coordinates, builder->colours},
                            (uint32_t)vertices);
    clast_gltf_add_indices(builder->writer, builder->indices, write_quads(s, base));
    note(builder, clast_progress(builder->context, "generate", builder->writer->triangle_count, builder->expected));
}

void clast_build_sheet(clast_builder *builder, const clast_sheet *sheet)
{
    uint32_t base = builder->writer->vertex_count;
    uint32_t rows = sheet->rows + 1, strip_rows = STRIP_VERTICES / (sheet->columns + 1);
    strip_rows = strip_rows < 8 ? 8 : strip_rows;
    for (uint32_t row = 0; row < rows && sound(builder); row += strip_rows) {
        uint32_t count = rows - row < strip_rows ? rows - row : strip_rows;
        uint32_t before = row > 0 || sheet->wraps_rows ? 1 : 0;
        uint32_t after = row + count < rows || sheet->wraps_rows ? 1 : 0;
        strip s = {.sheet = sheet,
                   .builder = builder,
                   .first_row = row,
                   .row_count = count,
                   .before = before,
                   .evaluated_rows = before + count + after};
        write_strip(&s, base);
    }
}

// --------------------------------------------------------------------------------------------------------- blocks

enum { BLOCK_SEGMENTS_MOST = 1024 };

static void lattice(const clast_block *block, uint32_t axis, float *coordinates)
{
    uint32_t count = block->segments[axis], bevel = 2 * block->bevel_segments < count ? block->bevel_segments : 0;
    for (uint32_t i = 0; i <= count; i++) {
        uint32_t from_end = i < count - i ? i : count - i;
        float inner = bevel != 0 ? 1.0f - block->bevels[axis] : 1.0f, x;
        if (from_end < bevel) {
            x = 1.0f - block->bevels[axis] * (float)from_end / (float)bevel;
        } else {
            x = inner * (float)(count - 2 * from_end) / (float)(count - 2 * bevel);
        }
        coordinates[i] = i < count - i ? -x : x; // the same numbers on both sides of the middle
    }
}

void clast_build_block(clast_builder *builder, const clast_block *block)
{
    float coordinates[3][BLOCK_SEGMENTS_MOST + 1];
    for (uint32_t axis = 0; axis < 3; axis++) {
        lattice(block, axis, coordinates[axis]);
    }
    for (uint32_t face = 0; face < 6 && sound(builder); face++) {
        if ((block->hidden_faces >> face & 1) != 0) {
            continue;
        }
        uint32_t u_axis = (face / 2 + 1) % 3, v_axis = (face / 2 + 2) % 3;
        // face_point() takes its first number for axis + 1.
        clast_sheet sheet = {
            .columns = block->segments[u_axis], .rows = block->segments[v_axis], .flipped = (face & 1) == 0};
        strip s = {.sheet = &sheet,
                   .block = block,
                   .builder = builder,
                   .face = face,
                   .face_u = coordinates[u_axis],
                   .face_v = coordinates[v_axis],
                   .row_count = sheet.rows + 1,
                   .evaluated_rows = sheet.rows + 1};
        write_strip(&s, builder->writer->vertex_count);
    }
}

void clast_sheet_set_rows(clast_sheet *sheet, double triangles, uint32_t rows, uint32_t least_columns)
{
    double columns = 0.5 * triangles / (double)rows + 0.5;
    sheet->rows = rows;
    sheet->columns = columns < (double)least_columns ? least_columns : (uint32_t)columns;
}

void clast_sheet_divide(clast_sheet *sheet, double triangles, float length_u, float length_v)
{
    double quads = triangles * 0.5;
    double side = sqrt((double)length_u * (double)length_v / quads);
    double columns = (double)length_u / side + 0.5, rows = (double)length_v / side + 0.5;
    sheet->columns = columns < 3.0 ? 3 : (uint32_t)columns;
    sheet->rows = rows < 3.0 ? 3 : (uint32_t)rows;
    if (rows < 3.0) {
        clast_sheet_set_rows(sheet, triangles, 3, 3);
    }
}
