// SPDX-License-Identifier: Apache-2.0
// Template sets. A template's treelet is its triangles in blocks of eight, cut top down by the surface area heuristic: each
// cut leaves a multiple of eight on one side, so that all blocks but one are full.
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "base/size.h"
#include "base/thread.h"

enum { KEYS = 256, TEMPLATE_GRAIN = 16 };

// ------------------------------------------------------------------------------------------------------------- cuts

typedef struct cut_box {
    float lower[3], upper[3];
} cut_box;

// A template being built: triangles in the order of their centres along each axis.
typedef struct cutter {
    cut_box boxes[TEMPLATE_TRIANGLES];
    uint8_t orders[3][TEMPLATE_TRIANGLES];
    uint8_t side[TEMPLATE_TRIANGLES]; // of the cut under way: 1 for those on the right
    float right_areas[TEMPLATE_TRIANGLES + 1];
} cutter;

static void box_add(cut_box *to, const cut_box *box)
{
    for (int axis = 0; axis < 3; axis++) {
        to->lower[axis] = box->lower[axis] < to->lower[axis] ? box->lower[axis] : to->lower[axis];
        to->upper[axis] = box->upper[axis] > to->upper[axis] ? box->upper[axis] : to->upper[axis];
    }
}

static float box_area(const cut_box *box)
{
    float x = box->upper[0] - box->lower[0], y = box->upper[1] - box->lower[1], z = box->upper[2] - box->lower[2];
    return x * y + y * z + z * x;
}

// Rest positions scaled to about [0, 1], so that areas are finite; what is not finite goes to the corner.
static void scale_positions(const clast_template_desc *desc, float (*scaled)[3])
{
    float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < 3 * desc->vertex_count; i++) {
        float x = desc->rest_positions[i];
        if (fabsf(x) <= 1e36f) {
            lower[i % 3] = x < lower[i % 3] ? x : lower[i % 3];
            upper[i % 3] = x > upper[i % 3] ? x : upper[i % 3];
        }
    }
    float size = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        size = upper[axis] - lower[axis] > size ? upper[axis] - lower[axis] : size;
    }
    float scale = size > 1e-37f ? 1.0f / size : 0.0f;
    for (uint32_t i = 0; i < 3 * desc->vertex_count; i++) {
        float x = desc->rest_positions[i];
        scaled[i / 3][i % 3] = fabsf(x) <= 1e36f ? (x - lower[i % 3]) * scale : 0.0f;
    }
}

// Orders triangles by the upper eight bits of their centres along an axis; equal ones keep their order.
static void sort_axis(cutter *c, uint32_t count, int axis)
{
    uint8_t keys[TEMPLATE_TRIANGLES];
    uint16_t places[KEYS + 1] = {0};
    for (uint32_t i = 0; i < count; i++) {
        float key = (c->boxes[i].lower[axis] + c->boxes[i].upper[axis]) * (0.5f * (KEYS - 1));
        keys[i] = (uint8_t)(key > 0.0f ? key < KEYS - 1 ? key : KEYS - 1 : 0.0f);
        places[keys[i] + 1]++;
    }
    for (uint32_t key = 0; key < KEYS; key++) {
        places[key + 1] = (uint16_t)(places[key + 1] + places[key]);
    }
    for (uint32_t i = 0; i < count; i++) {
        c->orders[axis][places[keys[i]]++] = (uint8_t)i;
    }
}

static void cutter_begin(cutter *c, const clast_template_desc *desc)
{
    float scaled[TEMPLATE_VERTICES][3];
    scale_positions(desc, scaled);
    for (uint32_t i = 0; i < desc->triangle_count; i++) {
        const uint8_t *corner = desc->indices + 3 * (size_t)i;
        cut_box *box = &c->boxes[i];
        memcpy(box->lower, scaled[corner[0]], sizeof box->lower);
        memcpy(box->upper, scaled[corner[0]], sizeof box->upper);
        for (int k = 1; k < 3; k++) {
            cut_box point;
            memcpy(point.lower, scaled[corner[k]], sizeof point.lower);
            memcpy(point.upper, scaled[corner[k]], sizeof point.upper);
            box_add(box, &point);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        sort_axis(c, desc->triangle_count, axis);
    }
}

typedef struct cut {
    float cost;
    int axis;
    uint32_t left_count;
} cut;

// The cheapest cut of [begin, end) across one axis, if it is cheaper than `best`: area times blocks, summed.
static void try_axis(cutter *c, uint32_t begin, uint32_t end, int axis, cut *best)
{
    const uint8_t *order = c->orders[axis] + begin;
    uint32_t count = end - begin;
    cut_box box = c->boxes[order[count - 1]];
    for (uint32_t i = count; i-- > 1;) {
        box_add(&box, &c->boxes[order[i]]);
        c->right_areas[i] = box_area(&box);
    }
    box = c->boxes[order[0]];
    for (uint32_t left = 1; left < count; left++) {
        box_add(&box, &c->boxes[order[left - 1]]);
        uint32_t right = count - left;
        if (left % BLOCK_TRIANGLES != 0 && right % BLOCK_TRIANGLES != 0) {
            continue;
        }
        float left_blocks = (float)((left + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES);
        float right_blocks = (float)((right + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES);
        float cost = box_area(&box) * left_blocks + c->right_areas[left] * right_blocks;
        if (cost < best->cost) {
            *best = (cut){cost, axis, left};
        }
    }
}

// Brings all orders into the halves of a cut, each keeping its order within.
static void apply_cut(cutter *c, uint32_t begin, uint32_t end, const cut *chosen)
{
    for (uint32_t i = begin; i < end; i++) {
        c->side[c->orders[chosen->axis][i]] = i - begin >= chosen->left_count;
    }
    for (int axis = 0; axis < 3; axis++) {
        uint8_t right[TEMPLATE_TRIANGLES];
        uint32_t left_end = begin, right_count = 0;
        for (uint32_t i = begin; i < end; i++) {
            uint8_t triangle = c->orders[axis][i];
            if (c->side[triangle]) {
                right[right_count++] = triangle;
            } else {
                c->orders[axis][left_end++] = triangle;
            }
        }
        memcpy(c->orders[axis] + left_end, right, right_count);
    }
}

// Cuts all triangles into blocks, left to right; gives the block's triangles one after the other in `orders[0]`, and the
// length of each block.
static uint32_t cut_blocks(cutter *c, uint32_t count, uint32_t lengths[TEMPLATE_BLOCKS])
{
    uint32_t ends[TEMPLATE_BLOCKS + 1] = {count}; // of what waits, the next on top
    uint32_t waiting = 1, begin = 0, blocks = 0;
    while (waiting > 0) {
        uint32_t end = ends[waiting - 1];
        if (end - begin <= BLOCK_TRIANGLES) {
            lengths[blocks++] = end - begin;
            begin = end;
            waiting--;
            continue;
        }
        cut best = {INFINITY, 0, BLOCK_TRIANGLES};
        for (int axis = 0; axis < 3; axis++) {
            try_axis(c, begin, end, axis, &best);
        }
        apply_cut(c, begin, end, &best);
        ends[waiting++] = begin + best.left_count;
    }
    return blocks;
}

static void fill_block(clast_block *block, const clast_template_desc *desc, const uint8_t *order, uint32_t count)
{
    for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
        uint8_t triangle = order[lane < count ? lane : 0];
        block->triangles[lane] = triangle;
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
    cutter c;
    uint32_t lengths[TEMPLATE_BLOCKS];
    uint32_t count = desc->triangle_count;
    made->triangle_count = (uint16_t)count;
    made->vertex_count = (uint16_t)desc->vertex_count;
    made->all_used = uses_all_vertices(desc);
    if (desc->rest_positions != NULL) {
        cutter_begin(&c, desc);
        made->block_count = (uint16_t)cut_blocks(&c, count, lengths);
    } else {
        made->block_count = (uint16_t)clast_blocks_of(desc->triangle_count);
        for (uint32_t i = 0; i < count; i++) {
            c.orders[0][i] = (uint8_t)i;
        }
        for (uint32_t i = 0; i < made->block_count; i++) {
            uint32_t left = count - i * BLOCK_TRIANGLES;
            lengths[i] = left < BLOCK_TRIANGLES ? left : BLOCK_TRIANGLES;
        }
    }
    const uint8_t *order = c.orders[0];
    for (uint32_t i = 0; i < made->block_count; i++) {
        fill_block(&made->blocks[i], desc, order, lengths[i]);
        order += lengths[i];
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
    for (uint32_t i = 0; i < 3 * desc->triangle_count; i++) {
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

void clast_template_triangle(const clast_template_set *set, uint32_t number, uint32_t triangle, uint32_t corners[3])
{
    corners[0] = corners[1] = corners[2] = 0;
    if (set == NULL || number >= set->count) {
        return;
    }
    const clast_template *topology = set->templates[number];
    for (uint32_t i = 0; i < topology->block_count * BLOCK_TRIANGLES; i++) {
        const clast_block *block = &topology->blocks[i / BLOCK_TRIANGLES];
        if (block->triangles[i % BLOCK_TRIANGLES] == triangle) {
            for (uint32_t corner = 0; corner < 3; corner++) {
                corners[corner] = block->corners[corner][i % BLOCK_TRIANGLES];
            }
            return;
        }
    }
}

uint64_t clast_template_set_bytes(const clast_template_set *set)
{
    return set != NULL ? sizeof *set + set->bytes + set->capacity * sizeof *set->templates +
                             set->memory_capacity * sizeof *set->memory
                       : 0;
}
