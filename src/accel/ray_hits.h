// SPDX-License-Identifier: Apache-2.0
// A ray on its way through an instance: bringing it there, testing blocks of triangles, and what it hit. For the kernel
// files that trace rays. A search is a `traversal`; begin_ray sets it up, enter_instance brings it into each instance that it
// meets, test_block looks for hits, and store_normal ends it.
#ifndef CLAST_ACCEL_RAY_HITS_H
#define CLAST_ACCEL_RAY_HITS_H

#include "accel/ray_boxes.h"

// ---------------------------------------------------------------------------------------------------------------- state

// A ray on its way.
typedef struct traversal {
    const clast_ray *ray;
    const clast_hit_filter *filter;
    const clast_placement *placement; // the instance that it is in
    clast_hit best;
    const clast_placement *best_placement; // null: nothing was hit
    const clast_block *best_block;
    uint32_t best_lane;
    uint32_t steps;
    // in the instance's space
    space object;
    clast_watertight_ray watertight;
    float along; // one over the direction's largest component, scaled so that depth * along * along_rest is t
    float along_rest;
    float limit; // best.t as the boxes see it
    bool any;
} traversal;

static inline bool is_sound_vertex(const float *v)
{
    return largest_of(v) <= BOX_COORDINATE_MOST && v[0] == v[0] && v[1] == v[1] && v[2] == v[2];
}

// Whether a hit at the same distance as the best takes its place.
static inline bool wins_tie(const traversal *w, const clast_hit *hit)
{
    const clast_hit *best = &w->best;
    if (w->best_placement == NULL) {
        return true;
    }
    if (hit->instance != best->instance) {
        return hit->instance < best->instance;
    }
    if (hit->cluster != best->cluster) {
        return hit->cluster < best->cluster;
    }
    if (hit->triangle != best->triangle) {
        return hit->triangle < best->triangle;
    }
    return w->placement < w->best_placement; // two instances of one id
}

// A triangle that the ray passes within its range. Gives true where the search is over.
static inline bool consider(traversal *w, uint32_t slot, const clast_clas *clas, const clast_block *block,
                            uint32_t lane, float t, float u, float v)
{
    for (uint32_t corner = 0; corner < 3; corner++) {
        if (!is_sound_vertex(clast_clas_vertices(clas) + 3 * (uint32_t)block->corners[corner][lane])) {
            return false;
        }
    }
    clast_hit hit = {
        .t = t, .u = u, .v = v, .instance = w->placement->id, .cluster = slot, .triangle = block->triangles[lane]};
    if (t == w->best.t && !wins_tie(w, &hit)) {
        return false;
    }
    if (w->placement->filtered && w->filter != NULL && !w->filter->accepts(w->filter->user, w->ray, &hit)) {
        return false;
    }
    w->best = hit;
    w->best_placement = w->placement;
    w->best_block = block;
    w->best_lane = lane;
    w->limit = scale_by(t, w->object.exponent);
    return w->any;
}

// ------------------------------------------------------------------------------------------------------------ triangles

CLAST_LANES clast_floats8 upper_bits8(clast_floats8 x)
{
    clast_floats8 large = x * splat8(4097.0f);
    return large - (large - x);
}

CLAST_LANES clast_floats8 product_error8(clast_floats8 a, clast_floats8 b, clast_floats8 product)
{
    clast_floats8 a1 = upper_bits8(a), b1 = upper_bits8(b);
    clast_floats8 a2 = a - a1, b2 = b - b1;
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
}

CLAST_LANES clast_floats8 signed_difference8(clast_floats8 a, clast_floats8 b, clast_floats8 c, clast_floats8 d)
{
    clast_floats8 ab = a * b, cd = c * d;
    clast_floats8 rough = ab - cd;
    clast_ints8 is_zero = rough == splat8(0.0f);
    if (__builtin_expect(bits8(is_zero) != 0, 0)) {
        rough = pick8(is_zero, product_error8(a, b, ab) - product_error8(c, d, cd), rough);
    }
    return rough;
}

// watertight_vertex for eight vertices.
CLAST_LANES clast_points8 shear8(const clast_watertight_ray *ray, clast_points8 v)
{
    clast_floats8 x = v.x - splat8(ray->origin.v[0]), y = v.y - splat8(ray->origin.v[1]),
                  z = v.z - splat8(ray->origin.v[2]);
    clast_points8 turned = {x, y, z};
    if (ray->axis == 0) {
        turned = (clast_points8){y, z, x};
    } else if (ray->axis == 1) {
        turned = (clast_points8){z, x, y};
    }
    clast_floats8 scale = splat8(ray->scale);
    return (clast_points8){(turned.x - splat8(ray->shear_x) * turned.z) * scale,
                           (turned.y - splat8(ray->shear_y) * turned.z) * scale, turned.z * scale};
}

// A block's eight triangles: watertight_edges, watertight_passes, and the range. Gives true where the search is over.
CLAST_LANES bool test_block(traversal *w, uint32_t slot, const clast_clas *clas, const clast_block *block)
{
    clast_points8 a = shear8(&w->watertight, load_points8(clast_clas_vertices(clas), block->corners[0]));
    clast_points8 b = shear8(&w->watertight, load_points8(clast_clas_vertices(clas), block->corners[1]));
    clast_points8 c = shear8(&w->watertight, load_points8(clast_clas_vertices(clas), block->corners[2]));
    clast_floats8 zero = splat8(0.0f);
    clast_floats8 edge_a = signed_difference8(c.x, b.y, c.y, b.x);
    clast_floats8 edge_b = signed_difference8(a.x, c.y, a.y, c.x);
    clast_floats8 edge_c = signed_difference8(b.x, a.y, b.y, a.x);
    clast_ints8 positive = (edge_a >= zero) & (edge_b >= zero) & (edge_c >= zero);
    clast_ints8 negative = (edge_a <= zero) & (edge_b <= zero) & (edge_c <= zero);
    clast_floats8 sum = (edge_a + edge_b) + edge_c;
    clast_ints8 passes = (positive | negative) & (sum != zero);
    if (bits8(passes) == 0) {
        return false;
    }
    clast_floats8 depth = (edge_a * a.z + edge_b * b.z) + edge_c * c.z;
    clast_floats8 t = depth / sum * splat8(w->along) * splat8(w->along_rest);
    uint32_t bits = bits8(passes & (t >= splat8(w->ray->t_min)) & (t <= splat8(w->best.t)));
    while (bits != 0) {
        uint32_t lane = (uint32_t)__builtin_ctz(bits);
        bits &= bits - 1;
        if (t[lane] <= w->best.t &&
            consider(w, slot, clas, block, lane, t[lane], edge_b[lane] / sum[lane], edge_c[lane] / sum[lane])) {
            return true;
        }
    }
    return false;
}

// ------------------------------------------------------------------------------------------------------------ instances

// By a map's columns.
CLAST_LANES clast_floats4 apply(const float columns[3][4], clast_floats4 v)
{
    clast_floats4 x, y, z;
    memcpy(&x, columns[0], sizeof x);
    memcpy(&y, columns[1], sizeof y);
    memcpy(&z, columns[2], sizeof z);
    return x * splat4(v[0]) + y * splat4(v[1]) + z * splat4(v[2]);
}

// All three lanes are numbers of at most that size.
CLAST_LANES bool are_below(clast_floats4 v, float most)
{
    clast_ints4 sound = abs4(v) <= splat4(most);
    return (sound[0] & sound[1] & sound[2]) != 0;
}

// Brings the ray into an instance's object space. False where it cannot hit anything there.
CLAST_LANES bool enter_instance(traversal *w, const clast_placement *placement, clast_floats4 direction, int exponent)
{
    if (placement->blas == NULL) {
        return false;
    }
    clast_floats4 origin = apply(placement->to_object, load_three4(w->ray->origin) - load_three4(placement->origin));
    clast_floats4 turned = apply(placement->to_object, direction);
    float largest = largest_lane(abs4(turned)), reach = reach_of(origin, &placement->blas->tree.boxes[0]);
    if (!(largest > 0.0f && are_below(turned, FLT_MAX) && are_below(origin, BOX_COORDINATE_MOST))) {
        return false;
    }
    int own = exponent_of(largest);
    turned = scale_lanes(turned, -own);
    w->placement = placement;
    w->object = make_space(origin, turned, exponent + own, reach, reach * PAD_OBJECT, w->ray->t_min);
    w->limit = scale_by(w->best.t, w->object.exponent);
    int scale = reach > 0.0f ? (int)WATERTIGHT_EXPONENT - exponent_of(reach) : 0;
    scale = scale > 126 ? 126 : scale;
    w->watertight = watertight_ray(vec3(origin[0], origin[1], origin[2]), vec3(turned[0], turned[1], turned[2]),
                                   two_to(scale));
    int rest = -(exponent + own + scale), half = rest < -252 ? -126 : rest > 252 ? 126 : rest / 2;
    rest = rest - half < -126 ? -126 : rest - half > 126 ? 126 : rest - half;
    w->along = 1.0f / component3(turned, w->watertight.axis) * two_to(half);
    w->along_rest = two_to(rest);
    return true;
}

// A ray that can hit something: all finite but t_max, a direction, a range.
static inline bool is_valid_ray(const clast_ray *ray)
{
    float largest = largest_of(ray->direction);
    return is_sound_vertex(ray->origin) && largest > 0.0f && largest <= FLT_MAX &&
           ray->direction[0] == ray->direction[0] && ray->direction[1] == ray->direction[1] &&
           ray->direction[2] == ray->direction[2] && fabsf(ray->t_min) <= FLT_MAX && ray->t_min <= ray->t_max;
}

// Sets up a search: false where the ray can hit nothing. Gives its direction with the largest component in [1, 2), which
// is the ray's times 2^-exponent.
CLAST_LANES bool begin_ray(traversal *w, const clast_tlas *tlas, clast_floats4 *direction, int *exponent)
{
    const clast_ray *ray = w->ray;
    w->best = (clast_hit){.t = ray->t_max <= FLT_MAX ? ray->t_max : FLT_MAX, .instance = CLAST_NONE};
    w->best_placement = NULL;
    w->steps = 0;
    if (!tlas->visible || !is_valid_ray(ray)) {
        return false;
    }
    *exponent = exponent_of(largest_of(ray->direction));
    *direction = scale_lanes(load_three4(ray->direction), -*exponent);
    return true;
}

// -------------------------------------------------------------------------------------------------------------- results

// A vector in the world, scaled by a power of two so that its largest component is in [1, 2): products of two neither
// overflow nor vanish.
static inline vec3 world_edge(const clast_placement *placement, const float *from, const float *to)
{
    clast_floats4 world = apply(placement->to_world, load_three4(to) - load_three4(from));
    float largest = largest_lane(abs4(world));
    return (vec3)scale_lanes(world, largest > 0.0f && largest <= FLT_MAX ? -exponent_of(largest) : 0);
}

static inline void store_normal(traversal *w)
{
    const clast_placement *placement = w->best_placement;
    const float *vertices = clast_clas_vertices(clast_pool_slot(placement->blas->pool, w->best.cluster));
    const float *corners[3];
    for (uint32_t corner = 0; corner < 3; corner++) {
        corners[corner] = vertices + 3 * (uint32_t)w->best_block->corners[corner][w->best_lane];
    }
    vec3 normal = cross3(world_edge(placement, corners[0], corners[1]), world_edge(placement, corners[0], corners[2]));
    for (int axis = 0; axis < 3; axis++) {
        w->best.normal[axis] = placement->mirrored ? -normal[axis] : normal[axis];
    }
}

#endif
