// SPDX-License-Identifier: Apache-2.0
// A packet against blocks of triangles: those that no part of it can meet are passed over, the others meet a part at
// once, a ray to a lane.
#ifndef CLAST_ACCEL_PACKET_BLOCKS_H
#define CLAST_ACCEL_PACKET_BLOCKS_H

#include "accel/packet_state.h"

// Between 2^62, which is more than the size of what packets enter, and 2^119, the least distance to an unsound vertex.
#define SOUND_DISTANCE 1.2676506e30f // 2^100

// Eight triangles, in memory, as they are taken lane by lane.
typedef struct corners8 {
    clast_floats8 of[3][3];    // corners a, b, c: u, v, w
    clast_floats8 edges[2][3]; // from a to b, and to c: x, y, z
} corners8;

// A triangle of a block.
typedef struct candidate {
    uint32_t slot, triangle;
    const float *of[3][3], *edges[2][3];
} candidate;

// ---------------------------------------------------------------------------------------------------------- arithmetic

CLAST_LANES lanes upper_bits_of(lanes x)
{
    lanes large = x * splat(4097.0f);
    return large - (large - x);
}

CLAST_LANES lanes product_error_of(lanes a, lanes b)
{
    lanes a1 = upper_bits_of(a), b1 = upper_bits_of(b);
    lanes a2 = a - a1, b2 = b - b1;
    return ((a1 * b1 - a * b) + a1 * b2 + a2 * b1) + a2 * b2;
}

// signed_difference of a b and c d, of which the rough difference is known.
CLAST_LANES lanes exact_difference(lanes rough, lanes a, lanes b, lanes c, lanes d)
{
    return pick(is_equal(rough, splat(0.0f)), product_error_of(a, b) - product_error_of(c, d), rough);
}

// Where something is not a number, the answer is undefined.
CLAST_LANES lane_mask have_one_sign(const lanes edges[3])
{
    lanes zero = splat(0.0f);
    return is_at_most(zero, minimum(minimum(edges[0], edges[1]), edges[2])) |
           is_at_most(maximum(maximum(edges[0], edges[1]), edges[2]), zero);
}

CLAST_LANES lane_mask have_zero(const lanes edges[3])
{
    lanes zero = splat(0.0f);
    return is_equal(edges[0], zero) | is_equal(edges[1], zero) | is_equal(edges[2], zero);
}

// ---------------------------------------------------------------------------------------------------------------- hits

// A hit that the order of ties or the filter may refuse.
static __attribute__((noinline, cold)) bool refuses_lane(const packet *p, uint32_t ray, float t, float u, float v,
                                                         const candidate *c)
{
    const clast_placement *placements = p->batch->tlas->placements, *here = &placements[p->here];
    int32_t best = RAY_LANE(p->placement, ray);
    clast_hit hit = {.t = t, .u = u, .v = v, .instance = here->id, .cluster = c->slot, .triangle = c->triangle};
    traversal w = {.ray = &p->batch->rays[p->numbers[ray]], .filter = p->filter, .placement = here};
    w.best.t = RAY_LANE(p->t, ray);
    if (best >= 0) {
        w.best_placement = &placements[best];
        w.best.instance = placements[best].id;
        w.best.cluster = (uint32_t)RAY_LANE(p->slot, ray);
        w.best.triangle = (uint32_t)RAY_LANE(p->triangle, ray);
    }
    return is_refused(&w, &hit);
}

// Of the rays in `mask`, those whose hit counts.
CLAST_LANES lane_mask accepted_rays(const packet *p, int part, lane_mask mask, lanes t, const lanes edges[3], lanes sum,
                                    const candidate *c)
{
    uint32_t bits = mask_bits(mask);
    uint32_t doubtful = p->filter != NULL ? bits : mask_bits(mask & is_equal(t, p->t[part]));
    if (__builtin_expect(doubtful == 0, 1)) {
        return mask;
    }
    lanes u = edges[1] / sum, v = edges[2] / sum;
    for (; doubtful != 0; doubtful &= doubtful - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(doubtful);
        if (refuses_lane(p, (uint32_t)part * LANES + lane, t[lane], u[lane], v[lane], c)) {
            bits &= ~(1u << lane);
        }
    }
    return mask_of(bits);
}

CLAST_LANES void keep_hits(packet *p, int part, lane_mask mask, lanes t, const lanes edges[3], lanes sum,
                           const candidate *c)
{
    p->placement[part] = pick_int(mask, splat_int((int32_t)p->here), p->placement[part]);
    if (p->any) {
        return;
    }
    p->t[part] = pick(mask, t, p->t[part]);
    p->weight_b[part] = pick(mask, edges[1], p->weight_b[part]);
    p->weight_c[part] = pick(mask, edges[2], p->weight_c[part]);
    p->weight_sum[part] = pick(mask, sum, p->weight_sum[part]);
    p->slot[part] = pick_int(mask, splat_int((int32_t)c->slot), p->slot[part]);
    p->triangle[part] = pick_int(mask, splat_int((int32_t)c->triangle), p->triangle[part]);
    for (int edge = 0; edge < 2; edge++) {
        for (int axis = 0; axis < 3; axis++) {
            p->edges[edge][axis][part] = pick(mask, splat(*c->edges[edge][axis]), p->edges[edge][axis][part]);
        }
    }
}

// ----------------------------------------------------------------------------------------------------------- triangles

// watertight_vertex for a corner, but for z, which is not scaled. Corners are relative to the origin that all rays
// share, or not moved.
CLAST_LANES void shear_corner(const packet *p, int part, bool shared, const float *const corner[3], lanes *x, lanes *y,
                              lanes *z)
{
    lanes u = splat(*corner[0]), v = splat(*corner[1]), w = splat(*corner[2]);
    if (!shared) {
        u -= p->object_origin[0][part];
        v -= p->object_origin[1][part];
        w -= p->object_origin[2][part];
    }
    *x = (u - p->shear_x[part] * w) * p->scale[part];
    *y = (v - p->shear_y[part] * w) * p->scale[part];
    *z = w;
}

// One triangle and a part's rays: the arithmetic of test_block (ray_hits.h). Gives the rays that hit. Where the edge
// functions are not numbers, or add up to zero, the distance is not a number, and no hit.
CLAST_LANES uint32_t test_triangle(packet *p, int part, bool shared, const candidate *c)
{
    lanes x[3], y[3], z[3];
    for (int corner = 0; corner < 3; corner++) {
        shear_corner(p, part, shared, c->of[corner], &x[corner], &y[corner], &z[corner]);
    }
    lanes edges[3] = {x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]};
    lane_mask passes = have_one_sign(edges) & mask_of(part_bits(p->active, part));
    if (mask_bits(passes) == 0) {
        return 0; // a zero counts for either sign: its exact sign makes no hits
    }
    if (__builtin_expect(mask_bits(passes & have_zero(edges)) != 0, 0)) {
        edges[0] = exact_difference(edges[0], x[2], y[1], y[2], x[1]);
        edges[1] = exact_difference(edges[1], x[0], y[2], y[0], x[2]);
        edges[2] = exact_difference(edges[2], x[1], y[0], y[1], x[0]);
        passes &= have_one_sign(edges);
    }
    lanes scale = p->scale[part], sum = (edges[0] + edges[1]) + edges[2];
    lanes depth = (edges[0] * (z[0] * scale) + edges[1] * (z[1] * scale)) + edges[2] * (z[2] * scale);
    lanes t = depth / sum * p->along[part] * p->along_rest[part];
    passes &= is_at_most(p->t_min[part], t) & is_at_most(t, p->t[part]);
    if (mask_bits(passes) == 0) {
        return 0;
    }
    passes = accepted_rays(p, part, passes, t, edges, sum, c);
    keep_hits(p, part, passes, t, edges, sum, c);
    return mask_bits(passes);
}

CLAST_LANES uint32_t test_triangles(packet *p, int part, bool shared, const corners8 *corners, uint32_t triangles,
                                    uint32_t slot, const clast_block *block)
{
    uint32_t hits = 0;
    for (; triangles != 0; triangles &= triangles - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(triangles);
        candidate c = {.slot = slot, .triangle = block->triangles[lane]};
        for (int k = 0; k < 3; k++) {
            for (int corner = 0; corner < 3; corner++) {
                c.of[corner][k] = (const float *)&corners->of[corner][k] + lane;
            }
            for (int edge = 0; edge < 2; edge++) {
                c.edges[edge][k] = (const float *)&corners->edges[edge][k] + lane;
            }
        }
        hits |= test_triangle(p, part, shared, &c);
    }
    return hits;
}

// -------------------------------------------------------------------------------------------------------------- blocks

CLAST_LANES clast_floats8 least_of_three(clast_floats8 a, clast_floats8 b, clast_floats8 c)
{
    return min8(min8(a, b), c);
}

CLAST_LANES clast_floats8 most_of_three(clast_floats8 a, clast_floats8 b, clast_floats8 c)
{
    return max8(max8(a, b), c);
}

// Which triangles a part of the beam can meet. Corners are relative to the beam's reference. Where one is not a number
// the answer is undefined.
CLAST_LANES uint32_t triangles_in(const pyramid *around, float sign, const corners8 *v)
{
    clast_floats8 w[3];
    for (int corner = 0; corner < 3; corner++) {
        w[corner] = v->of[corner][2] * splat8(sign);
    }
    clast_ints8 meets = least_of_three(w[0], w[1], w[2]) <= splat8(around->farthest);
    for (int k = 0; k < 2; k++) {
        clast_floats8 least = splat8(around->slopes[k][0]), most = splat8(around->slopes[k][1]);
        clast_floats8 inner = most_of_three(v->of[0][k] - least * w[0], v->of[1][k] - least * w[1],
                                            v->of[2][k] - least * w[2]);
        clast_floats8 outer = least_of_three(v->of[0][k] - most * w[0], v->of[1][k] - most * w[1],
                                             v->of[2][k] - most * w[2]);
        meets &= (inner >= splat8(around->offsets[k][0])) & (outer <= splat8(around->offsets[k][1]));
    }
    return bits8(meets);
}

// Which triangles have sound corners only, and do not repeat the first.
CLAST_LANES uint32_t triangles_that_count(const corners8 *v, const clast_block *block)
{
    const clast_ints8 magnitude = (clast_ints8)splat8(0.0f) + INT32_MAX;
    clast_ints8 sound = magnitude < 0;
    sound = ~sound;
    for (int corner = 0; corner < 3; corner++) {
        for (int k = 0; k < 3; k++) {
            sound &= (clast_floats8)((clast_ints8)v->of[corner][k] & magnitude) <= splat8(SOUND_DISTANCE);
        }
    }
    uint32_t repeats = 0;
    for (uint32_t lane = 1; lane < BLOCK_TRIANGLES; lane++) {
        repeats |= (uint32_t)(block->triangles[lane] == block->triangles[0]) << lane;
    }
    return bits8(sound) & ~repeats;
}

CLAST_LANES clast_floats8 component_of(const clast_points8 *v, uint32_t axis)
{
    return axis == 0 ? v->x : axis == 1 ? v->y : v->z;
}

CLAST_LANES uint64_t test_parts(packet *p, bool shared, const corners8 *corners, const uint32_t triangles[PARTS],
                                uint32_t slot, const clast_block *block)
{
    uint64_t hits = 0;
    for (int part = 0; part < PARTS; part++) {
        hits |= packet_bits(test_triangles(p, part, shared, corners, triangles[part], slot, block), part);
    }
    return hits;
}

// Gives the rays that hit something.
static uint64_t test_packet_block(packet *p, uint32_t slot, const clast_clas *clas, const clast_block *block)
{
    const beam *b = &p->beam;
    corners8 corners;
    clast_points8 v[3];
    for (int corner = 0; corner < 3; corner++) {
        v[corner] = load_points8(clast_clas_vertices(clas), block->corners[corner]);
        for (int k = 0; k < 3; k++) {
            corners.of[corner][k] = component_of(&v[corner], b->axes[k]) - splat8(b->reference[b->axes[k]]);
        }
    }
    p->work += PACKET_WORK_BLOCK;
    uint32_t triangles[PARTS], those = triangles_that_count(&corners, block), met = 0;
    for (int part = 0; part < PARTS; part++) {
        bool searches = part_bits(p->active, part) != 0;
        triangles[part] = searches ? those & triangles_in(&b->parts[part], b->sign, &corners) : 0;
        met |= triangles[part];
    }
    if (met == 0) {
        return 0;
    }
    for (int edge = 0; edge < 2; edge++) {
        for (uint32_t axis = 0; axis < 3; axis++) {
            corners.edges[edge][axis] = component_of(&v[edge + 1], axis) - component_of(&v[0], axis);
        }
    }
    if (p->shares_origin) { // which is the reference
        return test_parts(p, true, &corners, triangles, slot, block);
    }
    for (int corner = 0; corner < 3; corner++) {
        for (int k = 0; k < 3; k++) {
            corners.of[corner][k] = component_of(&v[corner], b->axes[k]);
        }
    }
    return test_parts(p, false, &corners, triangles, slot, block);
}

#endif
