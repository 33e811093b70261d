// SPDX-License-Identifier: Apache-2.0
// Where instances are: four at a time, in double precision.
//
// A ray goes to an instance's object space in float arithmetic. There it is a slightly different ray, and what it hits may
// lie a little beside the instance's box in the world. How far is bounded by the map's condition number, the norm of
// |M| |M^-1| (Bauer, Skeel), times a few units in the last place of the largest distance from the ray's origin and from the
// object's. The part that comes from the object is added to the box here, the part that comes from the ray is added by the
// traversal, which multiplies it by the largest condition number (clast_tlas.spread).
#include <float.h>

#include "accel/structures.h"
#include "base/simd.h"
#include "shared/box.h"

#define SPREAD_STEP (1.0 / 131072.0) // 2^-17; about 30 roundings of 2^-24 are possible
#define SPREAD_MOST 1e20

enum { LANES = 4, LINE = 64, PLACE_AHEAD = 4 };

typedef double doubles4 __attribute__((vector_size(32)));
typedef int64_t longs4 __attribute__((vector_size(32))); // also masks

CLAST_LANES doubles4 splat_double(double x)
{
    return (doubles4){x, x, x, x};
}

CLAST_LANES doubles4 pick_double(longs4 mask, doubles4 yes, doubles4 no)
{
    return (doubles4)((mask & (longs4)yes) | (~mask & (longs4)no));
}

CLAST_LANES doubles4 min_double(doubles4 a, doubles4 b)
{
    return pick_double(a < b, a, b);
}

CLAST_LANES doubles4 max_double(doubles4 a, doubles4 b)
{
    return pick_double(a > b, a, b);
}

CLAST_LANES doubles4 abs_double(doubles4 a)
{
    return (doubles4)((longs4)a & (longs4){INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX});
}

CLAST_LANES doubles4 widen(clast_floats4 a)
{
    return __builtin_convertvector(a, doubles4);
}

CLAST_LANES clast_floats4 narrow(doubles4 a)
{
    return __builtin_convertvector(a, clast_floats4);
}

CLAST_LANES clast_ints4 narrow_mask(longs4 mask)
{
    return __builtin_convertvector(mask, clast_ints4);
}

// Four rows become four columns.
CLAST_LANES void turn(clast_floats4 v[LANES])
{
    clast_floats4 a = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5),
                  b = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
    clast_floats4 c = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7),
                  d = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
    v[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    v[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    v[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    v[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

// Four instances: element [i][k] of each one's map, and the sides of what they place.
typedef struct maps {
    clast_floats4 element[3][LANES];
    clast_floats4 lower[LANES], upper[LANES]; // the fourth is not looked at
    clast_ints4 there;                        // what has a box that is not empty
} maps;

static clast_box object_box(const clast_tlas_instance *instance)
{
    return instance->blas != NULL && instance->blas->tree.node_count != 0 ? instance->blas->tree.boxes[0]
                                                                          : (clast_box){{{1, 1, 1}}, {{-1, -1, -1}}};
}

CLAST_LANES maps load_maps(const clast_tlas_instance *const instances[LANES])
{
    maps m;
    for (int lane = 0; lane < LANES; lane++) {
        for (int i = 0; i < 3; i++) {
            memcpy(&m.element[i][lane], instances[lane]->transform[i], sizeof m.element[i][lane]);
        }
        clast_box box = object_box(instances[lane]);
        m.lower[lane] = load_three4(box.lower.v);
        m.upper[lane] = load_three4(box.upper.v);
    }
    for (int i = 0; i < 3; i++) {
        turn(m.element[i]);
    }
    turn(m.lower);
    turn(m.upper);
    m.there = m.lower[0] <= m.upper[0];
    return m;
}

// Which maps have finite elements only, and which change nothing.
CLAST_LANES void look_at_maps(const maps *m, clast_ints4 *finite, clast_ints4 *identity)
{
    *finite = *identity = (clast_ints4){-1, -1, -1, -1};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < LANES; k++) {
            *finite &= abs4(m->element[i][k]) <= splat4(FLT_MAX);
            *identity &= m->element[i][k] == splat4(i == k ? 1.0f : 0.0f);
        }
    }
}

// Inverses by cofactors. Gives which there are, as far as floats can hold them.
CLAST_LANES longs4 invert(const doubles4 m[3][3], doubles4 inverse[3][3], doubles4 *determinant)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            inverse[i][j] = m[r][c] * m[s][d] - m[r][d] * m[s][c];
        }
    }
    *determinant = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
    doubles4 scale = splat_double(1.0) / *determinant;
    longs4 holds = (abs_double(*determinant) <= splat_double(DBL_MAX)) & (abs_double(scale) <= splat_double(DBL_MAX));
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            inverse[i][j] *= scale;
            holds &= abs_double(inverse[i][j]) <= splat_double((double)FLT_MAX);
        }
    }
    return holds;
}

// The largest row sums of |m| |inverse|.
CLAST_LANES doubles4 conditions(const doubles4 m[3][3], const doubles4 inverse[3][3])
{
    doubles4 sums[3], most = splat_double(1.0);
    for (int k = 0; k < 3; k++) {
        sums[k] = abs_double(inverse[k][0]) + abs_double(inverse[k][1]) + abs_double(inverse[k][2]);
    }
    for (int i = 0; i < 3; i++) {
        most = max_double(abs_double(m[i][0]) * sums[0] + abs_double(m[i][1]) * sums[1] + abs_double(m[i][2]) * sums[2],
                          most);
    }
    return min_double(most, splat_double(SPREAD_MOST));
}

// The floats next to these, below.
CLAST_LANES clast_floats4 next_below(clast_floats4 x)
{
    clast_ints4 bits = (clast_ints4)x, zero = x == splat4(0.0f);
    bits += 1 & (x < splat4(0.0f));
    bits -= 1 & (x > splat4(0.0f));
    const int32_t least = INT32_MIN + 1; // the bits of the largest number below zero
    return (clast_floats4)((zero & (clast_ints4){least, least, least, least}) | (~zero & bits));
}

CLAST_LANES clast_floats4 round_down(doubles4 x)
{
    clast_floats4 near = narrow(x);
    return pick4(narrow_mask(widen(near) > x), next_below(near), near);
}

// The boxes in the world, padded by what comes from the objects' size and their distance from their own origin, rounded
// outwards. Gives which are not too far away.
CLAST_LANES longs4 world_boxes(const maps *m, const doubles4 map[3][3], doubles4 spread, clast_floats4 lower[LANES],
                               clast_floats4 upper[LANES])
{
    doubles4 low[3], high[3], farthest = splat_double(0.0);
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = high[axis] = splat_double(0.0);
        for (int k = 0; k < 3; k++) {
            doubles4 a = map[axis][k] * widen(m->lower[k]), b = map[axis][k] * widen(m->upper[k]);
            low[axis] += min_double(a, b);
            high[axis] += max_double(a, b);
        }
        farthest = max_double(max_double(abs_double(low[axis]), abs_double(high[axis])), farthest);
    }
    doubles4 pad = farthest * spread * splat_double(SPREAD_STEP), most = splat_double((double)BOX_COORDINATE_MOST / 2);
    longs4 near = {-1, -1, -1, -1};
    for (int axis = 0; axis < 3; axis++) {
        doubles4 origin = widen(m->element[axis][3]);
        low[axis] = origin + low[axis] - pad;
        high[axis] = origin + high[axis] + pad;
        near &= (low[axis] >= -most) & (high[axis] <= most);
        lower[axis] = round_down(low[axis]);
        upper[axis] = -round_down(-high[axis]);
    }
    lower[3] = upper[3] = splat4(0.0f);
    return near;
}

// What four placements hold, an array of lanes for each column.
typedef struct placed {
    clast_floats4 to_object[3][LANES], to_world[3][LANES], origin[LANES], lower[LANES], upper[LANES];
    doubles4 spread;
    clast_ints4 seen, mirrored, identity; // masks
} placed;

CLAST_LANES placed place_four(const maps *m)
{
    placed p;
    doubles4 map[3][3], inverse[3][3], determinant;
    clast_ints4 finite;
    look_at_maps(m, &finite, &p.identity);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            map[i][k] = widen(m->element[i][k]);
        }
    }
    longs4 sound = invert((const doubles4(*)[3])map, inverse, &determinant);
    p.spread = conditions((const doubles4(*)[3])map, (const doubles4(*)[3])inverse);
    sound &= world_boxes(m, (const doubles4(*)[3])map, p.spread, p.lower, p.upper);
    p.seen = m->there & finite & narrow_mask(sound);
    p.mirrored = narrow_mask(determinant < splat_double(0.0));
    for (int k = 0; k < LANES; k++) {
        for (int i = 0; k < 3 && i < 3; i++) {
            p.to_object[k][i] = narrow(inverse[i][k]);
            p.to_world[k][i] = m->element[i][k];
        }
        p.origin[k] = k < 3 ? m->element[k][3] : splat4(0.0f);
    }
    for (int k = 0; k < 3; k++) {
        p.to_object[k][3] = p.to_world[k][3] = splat4(0.0f);
        turn(p.to_object[k]);
        turn(p.to_world[k]);
    }
    turn(p.origin);
    turn(p.lower);
    turn(p.upper);
    return p;
}

CLAST_LANES void store_placement(const placed *p, int lane, const clast_tlas_instance *instance,
                                 clast_placement *placement, clast_box *box)
{
    bool seen = p->seen[lane] != 0;
    clast_placement made = {.blas = seen ? instance->blas : NULL,
                            .id = instance->id,
                            .filtered = instance->filtered != 0,
                            .mirrored = seen && p->mirrored[lane] != 0,
                            .is_identity = seen && p->identity[lane] != 0};
    clast_floats4 lower = p->lower[lane], upper = p->upper[lane];
    if (seen) {
        for (int k = 0; k < 3; k++) {
            memcpy(made.to_object[k], &p->to_object[k][lane], sizeof made.to_object[k]);
            memcpy(made.to_world[k], &p->to_world[k][lane], sizeof made.to_world[k]);
        }
        memcpy(made.origin, &p->origin[lane], sizeof made.origin);
    } else {
        lower = splat4(INFINITY);
        upper = splat4(-INFINITY);
    }
    *placement = made;
    memcpy(&box->lower, &lower, sizeof box->lower);
    memcpy(&box->upper, &upper, sizeof box->upper);
}

float CLAST_KERNEL(clast_place)(const clast_tlas_instance *instances, const uint32_t *numbers, size_t first,
                                size_t count, clast_placement *placements, clast_box *boxes)
{
    float spread = 1.0f;
    for (size_t i = 0; i < count; i += LANES) {
        const clast_tlas_instance *four[LANES];
        size_t left = count - i < LANES ? count - i : LANES;
        for (size_t lane = 0; lane < LANES; lane++) { // those beyond the last repeat it, and are not stored
            four[lane] = &instances[i + (lane < left ? lane : left - 1)];
        }
        for (size_t lane = 0; numbers != NULL && lane < LANES && i + PLACE_AHEAD + lane < count; lane++) {
            const clast_placement *ahead = &placements[numbers[i + PLACE_AHEAD + lane]];
            __builtin_prefetch(ahead, 1);
            __builtin_prefetch((const char *)ahead + LINE, 1);
            __builtin_prefetch(&boxes[numbers[i + PLACE_AHEAD + lane]], 1);
        }
        maps m = load_maps(four);
        placed p = place_four(&m);
        for (size_t lane = 0; lane < left; lane++) {
            size_t number = numbers != NULL ? numbers[i + lane] : first + i + lane;
            store_placement(&p, (int)lane, four[lane], &placements[number], &boxes[number]);
            float own = p.seen[lane] != 0 ? (float)p.spread[lane] : 1.0f;
            spread = own > spread ? own : spread;
        }
    }
    return spread;
}
