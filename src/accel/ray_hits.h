// SPDX-License-Identifier: Apache-2.0
// A ray on its way through an instance: bringing it there, testing blocks of triangles, and what it hit. For the kernel
// files that trace rays. A search is a `traversal`; begin_ray sets it up, enter_instance brings it into each instance that it
// meets, test_block looks for hits, and store_hit ends it.
#ifndef CLAST_ACCEL_RAY_HITS_H
#define CLAST_ACCEL_RAY_HITS_H

#include "accel/ray_boxes.h"

// ---------------------------------------------------------------------------------------------------------------- state

// A ray on its way.
typedef struct traversal {
    const clast_ray *ray;
    const clast_hit_filter *filter;
    const clast_placement *placement;      // the instance that it is in
    clast_hit best;                        // without a normal and steps
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
    float cull;  // and as keys do
    bool any;
} traversal;

// Whether the corners of a triangle are all finite, and not too far away.
CLAST_LANES bool is_sound_triangle(const float *vertices, const clast_block *block, uint32_t lane)
{
    const clast_floats4 most = splat4(BOX_COORDINATE_MOST);
    clast_ints4 sound = {-1, -1, -1, -1};
    for (uint32_t corner = 0; corner < 3; corner++) {
        sound &= abs4(load_three4(vertices + 3 * (uint32_t)block->corners[corner][lane])) <= most;
    }
    return bits4(sound) == 15;
}

CLAST_LANES void set_limit(traversal *w)
{
    w->limit = distance_in(&w->object, w->best.t);
    w->cull = cull_limit(w->limit);
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

// Whether a hit that looks like the best one is not: by the order of ties, or by the filter.
static __attribute__((noinline, cold, unused)) bool is_refused(const traversal *w, const clast_hit *hit)
{
    if (hit->t == w->best.t && !wins_tie(w, hit)) {
        return true;
    }
    return w->placement->filtered && w->filter != NULL && !w->filter->accepts(w->filter->user, w->ray, hit);
}

// A triangle that the ray passes within its range. Gives true where the search is over.
CLAST_LANES bool consider(traversal *w, uint32_t slot, const clast_clas *clas, const clast_block *block, uint32_t lane,
                          float t, float u, float v)
{
    if (__builtin_expect(!is_sound_triangle(clast_clas_vertices(clas), block, lane), 0)) {
        return false;
    }
    uint32_t instance = w->placement->id, triangle = block->triangles[lane];
    if (__builtin_expect(t == w->best.t || (w->placement->filtered && w->filter != NULL), 0)) {
        clast_hit hit = {.t = t, .u = u, .v = v, .instance = instance, .cluster = slot, .triangle = triangle};
        if (is_refused(w, &hit)) {
            return false;
        }
    }
    w->best.t = t;
    w->best.u = u;
    w->best.v = v;
    w->best.instance = instance;
    w->best.cluster = slot;
    w->best.triangle = triangle;
    w->best_placement = w->placement;
    w->best_block = block;
    w->best_lane = lane;
    set_limit(w);
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

// Considers the lanes whose bits are set. Gives true where the search is over.
CLAST_LANES bool consider_all(traversal *w, uint32_t slot, const clast_clas *clas, const clast_block *block,
                              uint32_t bits, clast_floats8 t, clast_floats8 edge_b, clast_floats8 edge_c,
                              clast_floats8 sum)
{
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
    return consider_all(w, slot, clas, block, bits, t, edge_b, edge_c, sum);
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
    return (bits4(abs4(v) <= splat4(most)) & 7) == 7;
}

// The lane of the largest of three, the first of equal ones.
CLAST_LANES uint32_t largest_axis(clast_floats4 size)
{
    clast_ints4 largest = (size >= __builtin_shufflevector(size, size, 1, 2, 0, 3)) &
                          (size >= __builtin_shufflevector(size, size, 2, 0, 1, 3));
    return (uint32_t)__builtin_ctz(bits4(largest));
}

// Turns three lanes so that lane `axis` becomes the third; the fourth becomes a one.
CLAST_LANES clast_floats4 turn_lanes(clast_floats4 v, uint32_t axis)
{
    const clast_floats4 one = {1.0f, 1.0f, 1.0f, 1.0f};
#if defined(__AVX2__)
    static const int32_t turns[3][4] = {{1, 2, 0, 3}, {2, 0, 1, 3}, {0, 1, 2, 3}};
    __m128i turn = _mm_loadu_si128((const __m128i *)(const void *)turns[axis]);
    return (clast_floats4)_mm_blend_ps(_mm_permutevar_ps((__m128)v, turn), (__m128)one, 8);
#else
    return axis == 0   ? __builtin_shufflevector(v, one, 1, 2, 0, 4)
           : axis == 1 ? __builtin_shufflevector(v, one, 2, 0, 1, 4)
                       : __builtin_shufflevector(v, one, 0, 1, 2, 4);
#endif
}

// watertight_ray, in vectors, and what makes a distance of a depth.
CLAST_LANES void set_shear(traversal *w, clast_floats4 origin, clast_floats4 direction, int exponent, float reach)
{
    uint32_t axis = largest_axis(abs4(direction));
    clast_floats4 turned = turn_lanes(direction, axis);
    clast_floats4 shear = turned / __builtin_shufflevector(turned, turned, 2, 2, 2, 2);
    shear = (clast_floats4)((clast_ints4)shear & (abs4(shear) >= splat4(WATERTIGHT_SHEAR_LEAST)));
    int scale = 254 + (int)WATERTIGHT_EXPONENT - (int)(floatBitsToUint(reach) >> 23);
    scale = scale < 253 ? scale : 253;
    memcpy(&w->watertight.origin, &origin, sizeof w->watertight.origin);
    w->watertight.scale = power_of_two((uint)scale);
    w->watertight.axis = axis;
    w->watertight.shear_x = shear[0];
    w->watertight.shear_y = shear[1];
    w->along = shear[3];
    w->along_rest = power_of_two((uint)(254 - scale));
    if (__builtin_expect(exponent != 0, 0)) {
        int rest = 127 - scale - exponent, half = rest < -252 ? -126 : rest > 252 ? 126 : rest / 2;
        rest = rest - half < -126 ? -126 : rest - half > 126 ? 126 : rest - half;
        w->along = shear[3] * two_to(half);
        w->along_rest = two_to(rest);
    }
}

// Brings a direction whose length is extraordinary to [1, 2), and gives the exponent by which; zero for others.
CLAST_LANES int tame_direction(clast_floats4 *direction, float *largest)
{
    int exponent = 0;
    if (__builtin_expect(!(*largest >= DIRECTION_LEAST && *largest <= DIRECTION_MOST), 0)) {
        exponent = exponent_of(*largest);
        *direction = scale_lanes(*direction, -exponent);
        *largest = largest_lane(abs4(*direction));
    }
    return exponent;
}

// Brings the ray into an instance's object space. False where it cannot hit anything there.
CLAST_LANES bool enter_instance(traversal *w, const clast_placement *placement, clast_floats4 direction, int exponent)
{
    if (placement->blas == NULL) {
        return false;
    }
    clast_floats4 origin = load_three4(w->ray->origin), turned = direction;
    float largest;
    if (placement->is_identity) {
        largest = largest_lane(abs4(turned));
    } else {
        origin = apply(placement->to_object, origin - load_three4(placement->origin));
        turned = apply(placement->to_object, direction);
        largest = largest_lane(abs4(turned));
        if (!(largest > 0.0f && are_below(turned, FLT_MAX) && are_below(origin, BOX_COORDINATE_MOST))) {
            return false;
        }
        exponent += tame_direction(&turned, &largest);
    }
    float reach = reach_of(origin, &placement->blas->tree.boxes[0]);
    w->placement = placement;
    w->object = make_space(origin, turned, largest, exponent, reach, reach * PAD_OBJECT, w->ray->t_min);
    set_limit(w);
    set_shear(w, origin, turned, exponent, reach);
    return true;
}

// A ray that can hit something: all finite but t_max, a direction, a range. Gives the direction's largest component.
CLAST_LANES bool is_valid_ray(const clast_ray *ray, float *largest)
{
    const clast_floats4 most = {BOX_COORDINATE_MOST, BOX_COORDINATE_MOST, BOX_COORDINATE_MOST, FLT_MAX};
    const clast_ints4 three = {-1, -1, -1, 0};
    clast_floats4 origin = load_four4(ray->origin); // and t_min
    clast_floats4 direction = (clast_floats4)((clast_ints4)load_four4(ray->direction) & three);
    *largest = largest_lane(abs4(direction));
    return bits4((abs4(origin) <= most) & (abs4(direction) <= splat4(FLT_MAX))) == 15 && *largest > 0.0f &&
           ray->t_min <= ray->t_max;
}

// Sets up a search: false where the ray can hit nothing. Gives its direction, tame, which is the ray's times 2^-exponent.
CLAST_LANES bool begin_ray(traversal *w, const clast_tlas *tlas, clast_floats4 *direction, int *exponent)
{
    const clast_ray *ray = w->ray;
    float largest;
    w->best.t = ray->t_max <= FLT_MAX ? ray->t_max : FLT_MAX;
    w->best_placement = NULL;
    w->steps = 0;
    if (!tlas->visible || !is_valid_ray(ray, &largest)) {
        return false;
    }
    *direction = load_three4(ray->direction);
    *exponent = tame_direction(direction, &largest);
    return true;
}

// -------------------------------------------------------------------------------------------------------------- results

// A vector scaled by a power of two so that its largest component is in [1, 2): products of two neither overflow nor vanish.
CLAST_LANES clast_floats4 scale_edge(clast_floats4 edge)
{
    float largest = largest_lane(abs4(edge));
    return scale_lanes(edge, largest > 0.0f && largest <= FLT_MAX ? -exponent_of(largest) : 0);
}

CLAST_LANES clast_floats4 cross4(clast_floats4 a, clast_floats4 b)
{
    clast_floats4 a_next = __builtin_shufflevector(a, a, 1, 2, 0, 3),
                  b_next = __builtin_shufflevector(b, b, 1, 2, 0, 3);
    clast_floats4 turned = a * b_next - a_next * b; // z, x, y
    return __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
}

// Of this size are products that neither overflow nor lose bits: else edges are scaled first.
#define NORMAL_LEAST 8.673617379884035e-19f // 2^-60
#define NORMAL_MOST 1.152921504606847e18f   // 2^60

// The hit as the caller gets it: with the normal of the best triangle in the world, and the steps.
CLAST_LANES void store_hit(const traversal *w, clast_hit *hit)
{
    const clast_placement *placement = w->best_placement;
    if (placement == NULL) {
        *hit = (clast_hit){.t = w->best.t, .instance = CLAST_NONE, .steps = w->steps};
        return;
    }
    const float *vertices = clast_clas_vertices(clast_pool_slot(placement->blas->pool, w->best.cluster));
    clast_floats4 corners[3];
    for (uint32_t corner = 0; corner < 3; corner++) {
        corners[corner] = load_three4(vertices + 3 * (uint32_t)w->best_block->corners[corner][w->best_lane]);
    }
    clast_floats4 edges[2] = {corners[1] - corners[0], corners[2] - corners[0]};
    if (!placement->is_identity) {
        edges[0] = apply(placement->to_world, edges[0]);
        edges[1] = apply(placement->to_world, edges[1]);
    }
    clast_floats4 normal = cross4(edges[0], edges[1]);
    float largest = largest_lane(abs4(normal));
    if (__builtin_expect(!(largest >= NORMAL_LEAST && largest <= NORMAL_MOST), 0)) {
        normal = cross4(scale_edge(edges[0]), scale_edge(edges[1]));
    }
    if (placement->mirrored) {
        normal = -normal;
    }
    hit->t = w->best.t;
    hit->u = w->best.u;
    hit->v = w->best.v;
    memcpy(hit->normal, &normal, sizeof hit->normal);
    hit->instance = w->best.instance;
    hit->cluster = w->best.cluster;
    hit->triangle = w->best.triangle;
    hit->steps = w->steps;
}

#endif
