// SPDX-License-Identifier: Apache-2.0
// Up to 64 rays that go through the trees together: their numbers, a ray to a lane, and the beam that holds them.
//
// All rays of a group have one main axis w, of the largest component of their directions, and run along it the same
// way; u and v are the next two in turn. A ray is where u - o_u = slope_u * (w - o_w), and likewise v: slopes are the
// shears of shared/watertight.h, in [-1, 1]. So the group lies between planes through a point of reference, u - slope *
// w = offset, for the least and the most slope. A box or a triangle is out where it lies beyond one of them. Distances
// are measured along w, upwards whichever way the rays run. Ranges begin at zero or later: no ray looks back.
//
// As in ray_boxes.h nothing is culled that the triangle test would hit. With M the largest distance from any of the
// origins to a side of the tree's box, and e = 2^-24, what is compared here is off by less than 16 e M, that test by
// less than 12 e M: planes are moved by 2 * pad = 64 e M, and ends by pad, besides a relative 2^-19 for distances along
// rays.
#ifndef CLAST_ACCEL_PACKET_STATE_H
#define CLAST_ACCEL_PACKET_STATE_H

#include "accel/batch.h"
#include "accel/ray_hits.h"
#include "accel/ray_lanes.h"

#define PACKET_MARGIN 1.9073486328125e-6f // 2^-19

enum { PARTS = PACKET_RAYS / LANES };

// One ray's number in a packet's vectors.
#define RAY_LANE(vectors, ray) ((vectors)[(ray) / LANES][(ray) % LANES])

typedef struct pyramid {
    float slopes[2][2];  // of u, v: the least and the most, for w upwards
    float offsets[2][2]; // of the planes through the reference with these slopes
    float farthest;      // along w
} pyramid;

typedef struct beam {
    pyramid all, parts[PARTS];
    clast_ints8 rising[2][2]; // whether the slopes of `all` are: all lanes alike
    float reference[3];       // by axis
    float sign;               // of the directions along w
    float pad, nearest;
    uint32_t axes[3]; // u, v, w
    uint32_t first;   // which sides rays meet first along w: 1, the upper ones
} beam;

typedef struct packet {
    // the rays, in the world; directions with their largest component in [1, 2), by 2^-exponent
    lanes origin[3][PARTS], direction[3][PARTS], t_min[PARTS];
    lane_ints exponent[PARTS];
    // what they hit
    lanes t[PARTS], weight_b[PARTS], weight_c[PARTS], weight_sum[PARTS];
    lanes edges[2][3][PARTS]; // from the triangle's first corner to the others, in object space
    lane_ints slot[PARTS], triangle[PARTS];
    lane_ints placement[PARTS]; // -1: nothing
    // in an instance, a group at a time: u, v, w
    lanes object_origin[3][PARTS], shear_x[PARTS], shear_y[PARTS], scale[PARTS], along[PARTS], along_rest[PARTS];
    lanes depth[PARTS]; // how far rays get along w where t is one
    beam beam;
    uint64_t active;  // rays of the group that are still searching
    uint64_t restart; // rays that have to be traced alone
    bool any;
    bool shares_origin;
    uint32_t here; // the placement's number
    const clast_batch *batch;
    const uint32_t *numbers;
    const clast_hit_filter *filter;  // in this instance
    uint32_t steps, work, work_most; // so far, and how much it is worth
} packet;

CLAST_LANES uint32_t part_bits(uint64_t bits, int part)
{
    return (uint32_t)(bits >> (part * LANES)) & ((1u << LANES) - 1u);
}

CLAST_LANES uint64_t packet_bits(uint32_t bits, int part)
{
    return (uint64_t)bits << (part * LANES);
}

// -------------------------------------------------------------------------------------------------------------- limits

// Where rays begin along w.
CLAST_LANES lanes along_of(const beam *b, const lanes origin[3][PARTS], int part)
{
    return (origin[2][part] - splat(b->reference[b->axes[2]])) * splat(b->sign);
}

CLAST_LANES float farthest_of(const packet *p, const lanes origin[3][PARTS], int part, uint32_t bits)
{
    lanes reach = p->t[part] * p->depth[part] * splat(1.0f + PACKET_MARGIN);
    return most_lane(along_of(&p->beam, origin, part) + reach, bits) + p->beam.pad;
}

// After hits of the rays in `changed`, or after some have left.
static void look_no_farther(packet *p, const lanes origin[3][PARTS], uint64_t changed)
{
    beam *b = &p->beam;
    float farthest = -INFINITY;
    for (int part = 0; part < PARTS; part++) {
        if (part_bits(changed, part) != 0) {
            b->parts[part].farthest = farthest_of(p, origin, part, part_bits(p->active, part));
        }
        farthest = b->parts[part].farthest > farthest ? b->parts[part].farthest : farthest;
    }
    b->all.farthest = farthest;
}

// ------------------------------------------------------------------------------------------------------------- fitting

CLAST_LANES void widen(pyramid *all, const pyramid *part)
{
    for (int k = 0; k < 2; k++) {
        all->slopes[k][0] = part->slopes[k][0] < all->slopes[k][0] ? part->slopes[k][0] : all->slopes[k][0];
        all->slopes[k][1] = part->slopes[k][1] > all->slopes[k][1] ? part->slopes[k][1] : all->slopes[k][1];
    }
}

// Rays begin on their planes; those whose origin is not the reference may begin beyond the pyramid's.
static void fit_offsets(const packet *p, const lanes origin[3][PARTS], uint64_t group, pyramid *around)
{
    const beam *b = &p->beam;
    for (int k = 0; k < 2; k++) {
        float least = 0.0f, most = 0.0f;
        for (int part = 0; part < PARTS && !p->shares_origin; part++) {
            uint32_t bits = part_bits(group, part);
            if (bits != 0) {
                lanes along = along_of(b, origin, part), across = origin[k][part] - splat(b->reference[b->axes[k]]);
                float low = least_lane(across - splat(around->slopes[k][0]) * along, bits);
                float high = most_lane(across - splat(around->slopes[k][1]) * along, bits);
                least = low < least ? low : least;
                most = high > most ? high : most;
            }
        }
        around->offsets[k][0] = least - 2.0f * b->pad;
        around->offsets[k][1] = most + 2.0f * b->pad;
    }
}

static void fit_part(packet *p, const lanes origin[3][PARTS], const lanes slope[2][PARTS], int part, uint32_t bits)
{
    beam *b = &p->beam;
    pyramid *around = &b->parts[part];
    for (int k = 0; k < 2; k++) {
        around->slopes[k][0] = least_lane(slope[k][part] * splat(b->sign), bits);
        around->slopes[k][1] = most_lane(slope[k][part] * splat(b->sign), bits);
    }
    fit_offsets(p, origin, packet_bits(bits, part), around);
    widen(&b->all, around);
    lanes begins = p->t_min[part] * p->depth[part] * splat(1.0f - PACKET_MARGIN);
    float near = least_lane(along_of(b, origin, part) + begins, bits) - b->pad;
    b->nearest = near < b->nearest ? near : b->nearest;
}

// Fits the beam to a group. `origin` and `slope` are along its axes; p->depth is set.
static void fit_beam(packet *p, const lanes origin[3][PARTS], const lanes slope[2][PARTS], uint64_t group,
                     uint32_t main_axis, bool down, float pad)
{
    beam *b = &p->beam;
    uint32_t one = (uint32_t)__builtin_ctzll(group);
    for (uint32_t k = 0; k < 3; k++) {
        b->axes[k] = (main_axis + 1 + k) % 3;
        b->reference[b->axes[k]] = RAY_LANE(origin[k], one);
    }
    b->sign = down ? -1.0f : 1.0f;
    b->first = down;
    b->pad = pad;
    b->nearest = INFINITY;
    b->all = (pyramid){.slopes = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}}};
    for (int part = 0; part < PARTS; part++) {
        b->parts[part].farthest = -INFINITY;
        if (part_bits(group, part) != 0) {
            fit_part(p, origin, slope, part, part_bits(group, part));
        }
    }
    fit_offsets(p, origin, group, &b->all);
    for (int k = 0; k < 2; k++) {
        for (int end = 0; end < 2; end++) {
            b->rising[k][end] = splat8(b->all.slopes[k][end]) >= splat8(0.0f);
        }
    }
    p->active = group;
    look_no_farther(p, origin, group);
}

// --------------------------------------------------------------------------------------------------------------- boxes

typedef struct beam_hits {
    clast_floats8 near;
    uint32_t bits;
} beam_hits;

// Which of the first `count` of eight boxes the beam meets; test_boxes says how they lie.
CLAST_LANES beam_hits test_beam(const beam *b, const float *lower, const uint8_t *sides, size_t stride, uint32_t count)
{
    const uint8_t *exponents = (const uint8_t *)(lower + 3);
    uint32_t w = b->axes[2];
    clast_floats8 step = splat8(power_of_two(exponents[w]) * b->sign);
    clast_floats8 base = splat8((lower[w] - b->reference[w]) * b->sign);
    clast_floats8 near = load_bytes8(sides + (2 * w + b->first) * stride) * step + base;
    clast_floats8 far = load_bytes8(sides + (2 * w + 1 - b->first) * stride) * step + base;
    clast_ints8 meets = (near <= splat8(b->all.farthest)) & (far >= splat8(b->nearest));
    for (int k = 0; k < 2; k++) {
        uint32_t axis = b->axes[k];
        step = splat8(power_of_two(exponents[axis]));
        base = splat8(lower[axis] - b->reference[axis]);
        clast_floats8 low = load_bytes8(sides + 2 * axis * stride) * step + base;
        clast_floats8 high = load_bytes8(sides + (2 * axis + 1) * stride) * step + base;
        clast_floats8 most = splat8(b->all.slopes[k][1]) * pick8(b->rising[k][1], far, near);
        clast_floats8 least = splat8(b->all.slopes[k][0]) * pick8(b->rising[k][0], near, far);
        meets &= (low - most <= splat8(b->all.offsets[k][1])) & (high - least >= splat8(b->all.offsets[k][0]));
    }
    return (beam_hits){near, bits8(meets) & (count < TREE_WIDTH ? (1u << count) - 1u : 0xffu)};
}

#endif
