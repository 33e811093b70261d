// SPDX-License-Identifier: Apache-2.0
// Template sets. A template's treelet is its triangles in blocks of eight, cut top down by the surface area heuristic;
// only the last block may hold less (geometry/blocks.c).
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "base/size.h"
#include "base/thread.h"
#include "geometry/blocks.h"

enum { TEMPLATE_GRAIN = 16 };
_Static_assert((uint32_t)BLOCKS_PIECE == BLOCK_TRIANGLES, "triangles are ordered for the blocks of treelets");

// ----------------------------------------------------------------------------------------------------------- treelets

// Rest positions on the grid of step boxes; what is not finite goes to the corner. A fourth float each, zero.
static void scale_positions(const clast_template_desc *desc, float (*scaled)[4])
{
    float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < desc->vertex_count; i++) {
        for (uint32_t axis = 0; axis < 3; axis++) {
            float x = desc->rest_positions[3 * (size_t)i + axis];
            if (fabsf(x) <= 1e36f) {
                lower[axis] = x < lower[axis] ? x : lower[axis];
                upper[axis] = x > upper[axis] ? x : upper[axis];
            }
        }
    }
    float size = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        size = upper[axis] - lower[axis] > size ? upper[axis] - lower[axis] : size;
    }
    float scale = size > 1e-30f ? STEP_BOX_STEPS / size : 0.0f;
    for (uint32_t i = 0; i < desc->vertex_count; i++) {
        for (uint32_t axis = 0; axis < 3; axis++) {
            float x = desc->rest_positions[3 * (size_t)i + axis];
            scaled[i][axis] = fabsf(x) <= 1e36f ? (x - lower[axis]) * scale : 0.0f;
        }
        scaled[i][3] = 0.0f;
    }
}

// The triangles, each eight a block: by their rest positions.
static void order_triangles(const clast_template_desc *desc, uint16_t *order)
{
    float scaled[TEMPLATE_VERTICES][4];
    SORTED_ROOM(TEMPLATE_TRIANGLES) room;
    sorted_boxes sorted = SORTED_IN(&room);
    scale_positions(desc, scaled);
    for (uint32_t i = 0; i < desc->triangle_count; i++) {
        const uint8_t *corner = desc->indices + 3 * (size_t)i;
        lanes p = lanes_load(scaled[corner[0]]), q = lanes_load(scaled[corner[1]]), r = lanes_load(scaled[corner[2]]);
        sorted.box[i] = step_box_from(lanes_min(lanes_min(p, q), r), lanes_max(lanes_max(p, q), r));
    }
    clast_boxes_sort(&sorted, desc->triangle_count);
    clast_boxes_order_blocks(&sorted, 0, desc->triangle_count, order);
}

static void fill_block(clast_block *block, const clast_template_desc *desc, const uint16_t *order, uint32_t count)
{
    for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
        uint32_t triangle = order[lane < count ? lane : 0];
        block->triangles[lane] = (uint8_t)triangle;
        for (uint32_t corner = 0; corner < 3; corner++) {
            block->corners[corner][lane] = desc->indices[3 * (size_t)triangle + corner];
        }
    }
}

static bool uses_all_vertices(const clast_template_desc *desc)
{
    bool used[TEMPLATE_VERTICES] = {false};
    uint32_t count = 0;
    for (uint32_t i = 0; i < 3 * desc->triangle_count; i++) {
        count += !used[desc->indices[i]];
        used[desc->indices[i]] = true;
    }
    return count == desc->vertex_count;
}

void clast_template_build(clast_template *made, const clast_template_desc *desc)
{
    uint16_t order[TEMPLATE_TRIANGLES];
    uint32_t count = desc->triangle_count;
    made->triangle_count = (uint16_t)count;
    made->vertex_count = (uint16_t)desc->vertex_count;
    made->block_count = (uint16_t)clast_blocks_of(count);
    made->all_used = uses_all_vertices(desc);
    if (desc->rest_positions != NULL) {
        order_triangles(desc, order);
    } else {
        for (uint32_t i = 0; i < count; i++) {
            order[i] = (uint16_t)i;
        }
    }
    for (uint32_t i = 0; i < count; i += BLOCK_TRIANGLES) {
        uint32_t left = count - i;
        fill_block(&made->blocks[i / BLOCK_TRIANGLES], desc, order + i,
                   left < BLOCK_TRIANGLES ? left : BLOCK_TRIANGLES);
    }
}

// -------------------------------------------------------------------------------------------------------------- sets

clast_status clast_template_set_create(clast_context *context, clast_template_set **set)
{
    if (context == NULL || set == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *set = clast_allocate_zeroed(context, 1, sizeof **set);
    if (*set == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    (*set)->context = context;
    return CLAST_OK;
}

void clast_template_set_destroy(clast_template_set *set)
{
    if (set == NULL) {
        return;
    }
    for (size_t i = 0; i < set->memory_count; i++) {
        clast_free(set->context, set->memory[i]);
    }
    clast_free(set->context, set->memory);
    clast_free(set->context, set->templates);
    clast_free(set->context, set);
}

clast_status clast_template_check(clast_context *context, const clast_template_desc *desc, const char *what,
                                  size_t place)
{
    if (desc->triangle_count < 1 || desc->triangle_count > TEMPLATE_TRIANGLES) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s %zu has %u triangles; 1 to %u are possible", what,
                          place, desc->triangle_count, TEMPLATE_TRIANGLES);
    }
    if (desc->vertex_count < 1 || desc->vertex_count > TEMPLATE_VERTICES) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s %zu has %u vertices; 1 to %u are possible", what,
                          place, desc->vertex_count, TEMPLATE_VERTICES);
    }
    if (desc->indices == NULL) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s %zu has no indices", what, place);
    }
    uint8_t largest = 0; // almost always all are right, and this takes many at once
    for (uint32_t i = 0; i < 3 * desc->triangle_count; i++) {
        largest = desc->indices[i] > largest ? desc->indices[i] : largest;
    }
    for (uint32_t i = 0; largest >= desc->vertex_count; i++) {
        if (desc->indices[i] >= desc->vertex_count) {
            return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s %zu: index %u is %u; it has %u vertices", what,
                              place, i, desc->indices[i], desc->vertex_count);
        }
    }
    return CLAST_OK;
}

typedef struct build_job {
    const clast_template_desc *descs;
    const clast_template **made;
} build_job;

static void build_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    build_job *job = data;
    for (size_t i = begin; i < end; i++) {
        clast_template_build((clast_template *)job->made[i], &job->descs[i]);
    }
}

static size_t template_bytes(const clast_template_desc *desc)
{
    return sizeof(clast_template) + clast_blocks_of(desc->triangle_count) * sizeof(clast_block);
}

clast_status clast_template_set_add(clast_template_set *set, const clast_template_desc *descs, size_t count,
                                    uint32_t *first)
{
    if (set == NULL || first == NULL || (descs == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count > CLAST_NONE - set->count) {
        return clast_fail(set->context, CLAST_ERROR_INVALID_ARGUMENT, "%zu templates do not fit in a set", count);
    }
    size_t bytes = 0; // a template takes less than 1100 bytes, and there are less than 2^32
    uint32_t most_blocks = set->most_blocks;
    for (size_t i = 0; i < count; i++) {
        clast_status status = clast_template_check(set->context, &descs[i], "template", i);
        if (status != CLAST_OK) {
            return status;
        }
        bytes += template_bytes(&descs[i]);
        uint32_t blocks = clast_blocks_of(descs[i].triangle_count);
        most_blocks = blocks > most_blocks ? blocks : most_blocks;
    }
    if (CLAST_RESERVE(set->context, set->templates, set->capacity, set->count + count) != CLAST_OK ||
        CLAST_RESERVE(set->context, set->memory, set->memory_capacity, set->memory_count + 1) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint8_t *memory = clast_allocate(set->context, bytes, 1);
    if (memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    set->memory[set->memory_count++] = memory;
    set->bytes += bytes;
    for (size_t i = 0; i < count; i++) {
        set->templates[set->count + i] = (const clast_template *)(void *)memory;
        memory += template_bytes(&descs[i]);
    }
    build_job job = {descs, set->templates + set->count};
    clast_parallel_for(set->context, count, TEMPLATE_GRAIN, build_range, &job);
    *first = (uint32_t)set->count;
    set->count += count;
    set->most_blocks = most_blocks;
    return CLAST_OK;
}

// A flat grid, from which its treelet is built; what it becomes is bent, but its parameters stay neighbours.
static void grid_desc(uint32_t columns, uint32_t rows, uint8_t *indices, float *positions, clast_template_desc *desc)
{
    for (uint32_t j = 0; j <= rows; j++) {
        for (uint32_t i = 0; i <= columns; i++) {
            float *p = positions + 3 * (size_t)(j * (columns + 1) + i);
            p[0] = (float)i;
            p[1] = (float)j;
            p[2] = 0.0f;
        }
    }
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
            const uint32_t corners[6] = {a, a + 1, b + 1, a, b + 1, b};
            for (int k = 0; k < 6; k++) {
                *indices++ = (uint8_t)corners[k];
            }
        }
    }
    desc->triangle_count = 2 * columns * rows;
    desc->vertex_count = (columns + 1) * (rows + 1);
}

clast_status clast_template_set_add_grid(clast_template_set *set, uint32_t columns, uint32_t rows, uint32_t *number)
{
    if (set == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (columns < 1 || columns > GRID_SEGMENTS || rows < 1 || rows > GRID_SEGMENTS) {
        return clast_fail(set->context, CLAST_ERROR_INVALID_ARGUMENT, "a grid of %u x %u quads; 1 to %u are possible",
                          columns, rows, GRID_SEGMENTS);
    }
    uint32_t *known = &set->grids[rows - 1][columns - 1];
    if (*known == 0) {
        uint8_t indices[3 * TEMPLATE_TRIANGLES];
        float positions[3 * TEMPLATE_VERTICES];
        clast_template_desc desc = {.indices = indices, .rest_positions = positions};
        grid_desc(columns, rows, indices, positions, &desc);
        uint32_t first;
        clast_status status = clast_template_set_add(set, &desc, 1, &first);
        if (status != CLAST_OK) {
            return status;
        }
        *known = first + 1;
    }
    *number = *known - 1;
    return CLAST_OK;
}

uint32_t clast_template_set_count(const clast_template_set *set)
{
    return set != NULL ? (uint32_t)set->count : 0;
}

uint32_t clast_template_triangle_count(const clast_template_set *set, uint32_t number)
{
    return set != NULL && number < set->count ? set->templates[number]->triangle_count : 0;
}

uint32_t clast_template_vertex_count(const clast_template_set *set, uint32_t number)
{
    return set != NULL && number < set->count ? set->templates[number]->vertex_count : 0;
}

bool clast_template_corners(const clast_template *topology, uint32_t triangle, uint32_t corners[3])
{
    uint32_t lanes = topology->block_count * (uint32_t)BLOCK_TRIANGLES;
    for (uint32_t i = 0; i < lanes; i++) {
        uint32_t at = (triangle + i) % lanes; // in most templates it lies there, or near
        const clast_block *block = &topology->blocks[at / BLOCK_TRIANGLES];
        if (block->triangles[at % BLOCK_TRIANGLES] == triangle) {
            for (uint32_t corner = 0; corner < 3; corner++) {
                corners[corner] = block->corners[corner][at % BLOCK_TRIANGLES];
            }
            return true;
        }
    }
    return false;
}

void clast_template_triangle(const clast_template_set *set, uint32_t number, uint32_t triangle, uint32_t corners[3])
{
    corners[0] = corners[1] = corners[2] = 0;
    if (set == NULL || number >= set->count) {
        return;
    }
    clast_template_corners(set->templates[number], triangle, corners);
}

uint64_t clast_template_set_bytes(const clast_template_set *set)
{
    return set != NULL ? sizeof *set + set->bytes + set->capacity * sizeof *set->templates +
                             set->memory_capacity * sizeof *set->memory
                       : 0;
}
