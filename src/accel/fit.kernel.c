// SPDX-License-Identifier: Apache-2.0
// Fits a cluster's boxes to its vertices: one pass over its template.
#include "accel/structures.h"
#include "base/simd.h"
#include "shared/box.h"

typedef struct extent {
    clast_floats4 lower, upper;
} extent;

CLAST_LANES extent extent_empty(void)
{
    return (extent){splat4(INFINITY), splat4(-INFINITY)};
}

CLAST_LANES void extend(extent *e, clast_floats4 v)
{
    e->lower = min4(v, e->lower);
    e->upper = max4(v, e->upper);
}

// False for NaN, and for what is too large for differences to be finite.
CLAST_LANES bool is_sound(clast_floats4 v)
{
    for (int axis = 0; axis < 3; axis++) {
        if (!(v[axis] <= BOX_COORDINATE_MOST && v[axis] >= -BOX_COORDINATE_MOST)) {
            return false;
        }
    }
    return true;
}

// Whether all vertices can be hit. What is not sound never makes its lane of the sum zero.
static bool all_sound(const float *vertices, uint32_t count)
{
    clast_ints4 unsound = {0, 0, 0, 0};
    for (uint32_t i = 0; i < count; i++) {
        clast_floats4 v = load_three4(vertices + 3 * i);
        unsound |= ~((v <= splat4(BOX_COORDINATE_MOST)) & (v >= splat4(-BOX_COORDINATE_MOST)));
    }
    return (unsound[0] | unsound[1] | unsound[2]) == 0;
}

static extent block_extent(const clast_block *block, const float *vertices)
{
    extent e = extent_empty();
    for (uint32_t corner = 0; corner < 3; corner++) {
        for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
            extend(&e, load_three4(vertices + 3 * (uint32_t)block->corners[corner][lane]));
        }
    }
    return e;
}

// Of the triangles whose corners are all sound.
static extent sound_extent(const clast_block *block, const float *vertices)
{
    extent e = extent_empty();
    for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
        clast_floats4 v[3];
        for (uint32_t corner = 0; corner < 3; corner++) {
            v[corner] = load_three4(vertices + 3 * (uint32_t)block->corners[corner][lane]);
        }
        if (is_sound(v[0]) && is_sound(v[1]) && is_sound(v[2])) {
            extend(&e, v[0]);
            extend(&e, v[1]);
            extend(&e, v[2]);
        }
    }
    return e;
}

// box_quantise_down and box_quantise_up over three axes.
CLAST_LANES clast_floats4 steps_down(clast_floats4 x, clast_floats4 base, clast_floats4 inverse_step)
{
    clast_floats4 steps = (x - base) * splat4(BOX_SHRINK) * inverse_step;
    return __builtin_convertvector(__builtin_convertvector(steps, clast_ints4), clast_floats4); // not negative
}

CLAST_LANES clast_floats4 steps_up(clast_floats4 x, clast_floats4 base, clast_floats4 inverse_step)
{
    clast_floats4 steps = (x - base) * splat4(BOX_GROW) * inverse_step;
    clast_floats4 whole = __builtin_convertvector(__builtin_convertvector(steps, clast_ints4), clast_floats4);
    return pick4(whole < steps, whole + splat4(1.0f), whole);
}

static void quantise_block(uint8_t group[3][2][CLUSTER_WIDTH], uint32_t lane, const extent *e, clast_floats4 base,
                           clast_floats4 inverse_step)
{
    // A block without a sound triangle has no sides: a box inside out, as far as bytes go.
    bool empty = !(e->lower[0] <= e->upper[0]);
    clast_ints4 down = {255, 255, 255, 255}, up = {0, 0, 0, 0};
    if (!empty) {
        down = __builtin_convertvector(steps_down(e->lower, base, inverse_step), clast_ints4);
        up = __builtin_convertvector(steps_up(e->upper, base, inverse_step), clast_ints4);
    }
    for (int axis = 0; axis < 3; axis++) {
        group[axis][0][lane] = (uint8_t)down[axis];
        group[axis][1][lane] = (uint8_t)up[axis];
    }
}

void CLAST_KERNEL(clast_fit)(clast_clas *clas, clast_box *box)
{
    const clast_template *topology = clast_clas_topology(clas);
    const float *vertices = clast_clas_vertices(clas);
    uint32_t block_count = topology->block_count;
    bool sound = all_sound(vertices, topology->vertex_count);
    extent blocks[TEMPLATE_BLOCKS];
    extent all = extent_empty();
    for (uint32_t i = 0; i < block_count; i++) {
        blocks[i] = sound ? block_extent(&topology->blocks[i], vertices) : sound_extent(&topology->blocks[i], vertices);
        all.lower = min4(blocks[i].lower, all.lower);
        all.upper = max4(blocks[i].upper, all.upper);
    }
    clast_floats4 inverse_step = splat4(0.0f);
    for (int axis = 0; axis < 3; axis++) {
        clas->lower[axis] = all.lower[axis];
        box->lower.v[axis] = all.lower[axis];
        box->upper.v[axis] = all.upper[axis];
        uint32_t exponent = all.lower[axis] <= all.upper[axis] ? box_exponent(all.upper[axis] - all.lower[axis])
                                                               : BOX_STEP_LEAST;
        clas->exponents[axis] = (uint8_t)exponent;
        inverse_step[axis] = power_of_two(254u - exponent);
    }
    clas->block_count = (uint8_t)(all.lower[0] <= all.upper[0] ? block_count : 0);
    for (uint32_t i = 0; i < clas->block_count; i++) {
        quantise_block(clas->groups[i / CLUSTER_WIDTH], i % CLUSTER_WIDTH, &blocks[i], all.lower, inverse_step);
    }
}
