// SPDX-License-Identifier: Apache-2.0
// Rays through the trees. Per ray a stack for the TLAS and one for the BLAS that it is in; no recursion.
//
// Boxes never cull what the triangle test would hit. That test (shared/watertight.h) works on vertices that are moved by
// roundings of v - o and of the shear: with M the largest distance from the ray's origin to a side of the tree's box, and
// e = 2^-24, by less than 6 e M; the distance it finds is off by less than 6 e M more. Here, the sides are
// q * (step * inverse) + (base - origin) * inverse -+ pad * |inverse|, of six roundings, on values of 3 M |inverse| at most:
// less than 10 e M. So all sides are moved outwards by pad = 32 e M = 2^-19 M, and ties at the limit are kept.
// Direction components below 2^-30 of the largest are taken as 2^-30: that moves the ray by less than 2^-28 M.
//
// In each space, lengths and distances are scaled by powers of two: the direction's largest component to [1, 2), and M to
// [1, 2), so that nothing overflows, and tiny scenes keep their precision.
#include <float.h>
#include <math.h>

#include "accel/structures.h"
#include "base/simd.h"
#include "shared/box.h"
#include "shared/watertight.h"

#define PAD_OBJECT 1.9073486328125e-6f // 2^-19
#define PAD_WORLD 7.62939453125e-6f    // 2^-17, times the condition of the maps (tlas.c)
#define INVERSE_MOST 1073741824.0f     // 2^30

enum { SCALE_MOST = 86 }; // exponent: of what is smaller, distances stay small

// -------------------------------------------------------------------------------------------------------- powers of two

// 2^exponent, for -126 <= exponent <= 127.
static float two_to(int exponent)
{
    return power_of_two((uint)(exponent + 127));
}

// x * 2^exponent; exponents beyond what changes a float are cut.
static float scale_by(float x, int exponent)
{
    exponent = exponent < -252 ? -252 : exponent > 252 ? 252 : exponent;
    int half = exponent / 2;
    return x * two_to(half) * two_to(exponent - half);
}

// The exponent of a positive finite number: x is in [2^e, 2^(e + 1)).
static int exponent_of(float x)
{
    uint biased = floatBitsToUint(x) >> 23;
    if (biased == 0) {
        return (int)(floatBitsToUint(x * 0x1p64f) >> 23) - 127 - 64;
    }
    return (int)biased - 127;
}

static float largest_of(const float v[3])
{
    float x = fabsf(v[0]), y = fabsf(v[1]), z = fabsf(v[2]);
    float most = x > y ? x : y;
    return most > z ? most : z;
}

// The largest of three lanes; the fourth is zero.
CLAST_LANES float largest_lane(clast_floats4 v)
{
    float most = v[0] > v[1] ? v[0] : v[1];
    return most > v[2] ? most : v[2];
}

CLAST_LANES clast_floats4 scale_lanes(clast_floats4 v, int exponent)
{
    exponent = exponent < -252 ? -252 : exponent > 252 ? 252 : exponent;
    int half = exponent / 2;
    return v * splat4(two_to(half)) * splat4(two_to(exponent - half));
}

// -------------------------------------------------------------------------------------------------------------- spaces

// A ray as boxes see it. The fourth lanes are zero.
typedef struct space {
    clast_floats4 origin;
    clast_floats4 inverse; // 1 / direction, scaled
    clast_floats4 pad;
    uint32_t first[3]; // for each axis, which sides the ray meets first: 1, the upper ones, where it runs downwards
    int exponent;      // distances here are the ray's t times 2^exponent
    float t_min;
} space;

// The largest distance from a point to a side of a box, along an axis; not finite where that is too far.
CLAST_LANES float reach_of(clast_floats4 origin, const clast_box *box)
{
    return largest_lane(max4(abs4(load_three4(box->lower.v) - origin), abs4(load_three4(box->upper.v) - origin)));
}

// `direction` has its largest component in [1, 2); `exponent` says how the ray's t becomes a multiple of it.
CLAST_LANES space make_space(clast_floats4 origin, clast_floats4 direction, int exponent, float reach, float pad,
                             float t_min)
{
    int scale = reach > 0.0f ? -exponent_of(reach) : SCALE_MOST;
    scale = scale > SCALE_MOST ? SCALE_MOST : scale;
    clast_floats4 inverse = splat4(1.0f) / direction;
    clast_floats4 most = pick4(direction < splat4(0.0f), splat4(-INVERSE_MOST), splat4(INVERSE_MOST));
    inverse = pick4(abs4(inverse) <= splat4(INVERSE_MOST), inverse, most);
    space s = {.origin = origin, .exponent = exponent + scale};
    s.inverse = inverse * splat4(two_to(scale));
    s.inverse[3] = 0.0f;
    s.pad = abs4(s.inverse) * splat4(pad);
    for (uint32_t axis = 0; axis < 3; axis++) {
        s.first[axis] = inverse[axis] < 0.0f;
    }
    s.t_min = scale_by(t_min, s.exponent);
    return s;
}

typedef struct box_hits {
    clast_floats8 near;
    uint32_t bits;
} box_hits;

// How a ray sees quantised boxes over one base: the distance to a side is its number of steps times `step`, plus `near` or
// `far`, one lane for each axis.
typedef struct grid {
    clast_floats4 step, near, far;
} grid;

// `lower` is followed by the three biased exponents and another byte, in nodes and clusters alike.
CLAST_LANES grid make_grid(const space *s, const float *lower)
{
    clast_ints4 exponents = load_bytes4((const uint8_t *)(lower + 3)) << 23;
    clast_floats4 shift = (load_three4(lower) - s->origin) * s->inverse;
    return (grid){(clast_floats4)exponents * s->inverse, shift - s->pad, shift + s->pad};
}

// Which of eight boxes the ray meets between its t_min and `limit`. `sides` are those of a node, or of half a cluster's
// group; from one plane's to the next are `stride` bytes.
CLAST_LANES box_hits test_boxes(const space *s, const grid *g, const uint8_t *sides, size_t stride, float limit)
{
    clast_floats8 near = splat8(s->t_min), far = splat8(limit);
    for (int axis = 0; axis < 3; axis++) {
        clast_floats8 step = splat_lane8(g->step, axis);
        near = max8(load_bytes8(sides + (2 * (size_t)axis + s->first[axis]) * stride) * step +
                        splat_lane8(g->near, axis),
                    near);
        far = min8(load_bytes8(sides + (2 * (size_t)axis + 1 - s->first[axis]) * stride) * step +
                       splat_lane8(g->far, axis),
                   far);
    }
    return (box_hits){near, bits8(near <= far)};
}

typedef struct stack_entry {
    float near;
    uint32_t child;
} stack_entry;

// Puts an entry among those above `bottom`, the nearest on top; of equal ones the first to come.
CLAST_LANES void push_sorted(stack_entry *stack, uint32_t bottom, uint32_t *height, stack_entry entry)
{
    uint32_t place = (*height)++;
    for (; place > bottom && stack[place - 1].near <= entry.near; place--) {
        stack[place] = stack[place - 1];
    }
    stack[place] = entry;
}

// Where a BLAS's nodes and clusters lie.
typedef struct child_arrays {
    const clast_node *nodes;
    const uint8_t *slots;
    size_t stride;
} child_arrays;

// Fetches a child that waits on the stack: two or three lines.
CLAST_LANES void prefetch_child(const child_arrays *arrays, uint32_t child)
{
    size_t size = (child & CLAST_CHILD_ITEM) != 0 ? arrays->stride : sizeof(clast_node);
    const uint8_t *first = (child & CLAST_CHILD_ITEM) != 0 ? arrays->slots : (const uint8_t *)arrays->nodes;
    const uint8_t *at = first + (child & ~CLAST_CHILD_ITEM) * size;
    __builtin_prefetch(at);
    __builtin_prefetch(at + 64);
    __builtin_prefetch(at + 128);
}

// The children of a node that were hit: gives the nearest, pushes the others. There must be one. `arrays` null: nothing is
// fetched ahead.
CLAST_LANES stack_entry nearest_child(stack_entry *stack, uint32_t *height, const uint32_t *children,
                                      const box_hits *hits, const child_arrays *arrays)
{
    float near[TREE_WIDTH];
    memcpy(near, &hits->near, sizeof near);
    uint32_t bits = hits->bits, lane = (uint32_t)__builtin_ctz(bits);
    stack_entry nearest = {near[lane], children[lane]};
    bits &= bits - 1;
    uint32_t bottom = *height;
    while (bits != 0) {
        lane = (uint32_t)__builtin_ctz(bits);
        bits &= bits - 1;
        stack_entry entry = {near[lane], children[lane]};
        if (arrays != NULL) {
            prefetch_child(arrays, entry.child);
        }
        if (entry.near < nearest.near) {
            stack_entry other = nearest;
            nearest = entry;
            entry = other;
        }
        push_sorted(stack, bottom, height, entry);
    }
    return nearest;
}

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

static bool is_sound_vertex(const float *v)
{
    return largest_of(v) <= BOX_COORDINATE_MOST && v[0] == v[0] && v[1] == v[1] && v[2] == v[2];
}

// Whether a hit at the same distance as the best takes its place.
static bool wins_tie(const traversal *w, const clast_hit *hit)
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
    return w->placement->index < w->best_placement->index; // two instances of one id
}

// A triangle that the ray passes within its range. Gives true where the search is over.
static bool consider(traversal *w, uint32_t slot, const clast_clas *clas, const clast_block *block, uint32_t lane,
                     float t, float u, float v)
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

// The blocks of a cluster whose boxes the ray meets, the nearest first. Gives true where the search is over.
CLAST_LANES bool test_cluster(traversal *w, const space *s, uint32_t slot, const clast_clas *clas)
{
    stack_entry blocks[TEMPLATE_BLOCKS];
    uint32_t count = 0, block_count = clas->block_count;
    grid g = make_grid(s, clas->lower);
    for (uint32_t first = 0; first < block_count; first += TREE_WIDTH) {
        box_hits hits = test_boxes(s, &g, &clas->groups[first / CLUSTER_WIDTH][0][0][first % CLUSTER_WIDTH],
                                   CLUSTER_WIDTH, w->limit);
        uint32_t left = block_count - first;
        uint32_t bits = hits.bits & (left < TREE_WIDTH ? (1u << left) - 1u : 0xffu);
        if (bits == 0) {
            continue;
        }
        float near[TREE_WIDTH];
        memcpy(near, &hits.near, sizeof near);
        while (bits != 0) {
            uint32_t lane = (uint32_t)__builtin_ctz(bits);
            bits &= bits - 1;
            __builtin_prefetch(&clast_clas_topology(clas)->blocks[first + lane]);
            push_sorted(blocks, 0, &count, (stack_entry){near[lane], first + lane});
        }
    }
    if (count > 0) { // the blocks say which vertices they need when they arrive; till then, all of them
        for (uint32_t i = 0; i < clast_clas_topology(clas)->vertex_count; i += 5) {
            __builtin_prefetch(clast_clas_vertices(clas) + 3 * i);
        }
    }
    while (count > 0 && blocks[--count].near <= w->limit) {
        if (test_block(w, slot, clas, &clast_clas_topology(clas)->blocks[blocks[count].child])) {
            return true;
        }
    }
    return false;
}

// ---------------------------------------------------------------------------------------------------------------- trees

// Gives true where the search is over.
static bool traverse_blas(traversal *w)
{
    const clast_blas *blas = w->placement->blas;
    const child_arrays arrays = {blas->tree.nodes, blas->pool->slots, blas->pool->stride};
    const space s = w->object;
    stack_entry stack[TREE_STACK];
    uint32_t height = 0, steps = 0;
    stack_entry top = {-INFINITY, 0};
    for (;;) {
        steps++;
        if ((top.child & CLAST_CHILD_ITEM) == 0) {
            const clast_node *node = &arrays.nodes[top.child];
            grid g = make_grid(&s, node->lower);
            box_hits hits = test_boxes(&s, &g, node->boxes[0][0], TREE_WIDTH, w->limit);
            hits.bits &= (1u << node->child_count) - 1u;
            if (hits.bits != 0) {
                top = nearest_child(stack, &height, node->children, &hits, &arrays);
                continue;
            }
        } else {
            uint32_t slot = top.child & ~CLAST_CHILD_ITEM;
            if (test_cluster(w, &s, slot, (const clast_clas *)(const void *)(arrays.slots + slot * arrays.stride))) {
                w->steps += steps;
                return true;
            }
        }
        do {
            if (height == 0) {
                w->steps += steps;
                return false;
            }
            top = stack[--height];
        } while (top.near > w->limit);
    }
}

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
static bool is_valid_ray(const clast_ray *ray)
{
    float largest = largest_of(ray->direction);
    return is_sound_vertex(ray->origin) && largest > 0.0f && largest <= FLT_MAX &&
           ray->direction[0] == ray->direction[0] && ray->direction[1] == ray->direction[1] &&
           ray->direction[2] == ray->direction[2] && fabsf(ray->t_min) <= FLT_MAX && ray->t_min <= ray->t_max;
}

// `direction` has its largest component in [1, 2) by 2^exponent.
static void traverse_tlas(const clast_tlas *tlas, traversal *w, clast_floats4 direction, int exponent)
{
    clast_floats4 origin = load_three4(w->ray->origin);
    float reach = reach_of(origin, &tlas->tree.boxes[0]),
          pad = min1(reach * PAD_WORLD * tlas->spread, BOX_COORDINATE_MOST);
    space world = make_space(origin, direction, exponent, reach, pad, w->ray->t_min);
    float limit = scale_by(w->best.t, world.exponent);
    stack_entry stack[TREE_STACK];
    uint32_t height = 0;
    stack_entry top = {-INFINITY, 0};
    for (;;) {
        if ((top.child & CLAST_CHILD_ITEM) == 0) {
            w->steps++;
            const clast_node *node = &tlas->tree.nodes[top.child];
            grid g = make_grid(&world, node->lower);
            box_hits hits = test_boxes(&world, &g, node->boxes[0][0], TREE_WIDTH, limit);
            hits.bits &= (1u << node->child_count) - 1u;
            if (hits.bits != 0) {
                top = nearest_child(stack, &height, node->children, &hits, NULL);
                continue;
            }
        } else if (enter_instance(w, &tlas->placements[top.child & ~CLAST_CHILD_ITEM], direction, exponent)) {
            if (traverse_blas(w)) {
                return;
            }
            limit = scale_by(w->best.t, world.exponent);
        }
        do {
            if (height == 0) {
                return;
            }
            top = stack[--height];
        } while (top.near > limit);
    }
}

CLAST_LANES void traverse(const clast_tlas *tlas, traversal *w)
{
    const clast_ray *ray = w->ray;
    w->best = (clast_hit){.t = ray->t_max <= FLT_MAX ? ray->t_max : FLT_MAX, .instance = CLAST_NONE};
    w->best_placement = NULL;
    w->steps = 0;
    if (tlas->tree.node_count == 0 || !is_valid_ray(ray)) {
        return;
    }
    int exponent = exponent_of(largest_of(ray->direction));
    clast_floats4 direction = scale_lanes(load_three4(ray->direction), -exponent);
    if (tlas->placement_count > 1) {
        traverse_tlas(tlas, w, direction, exponent);
    } else if (enter_instance(w, &tlas->placements[0], direction, exponent)) {
        traverse_blas(w); // alone: its own tree says whether the ray meets it
    }
}

// -------------------------------------------------------------------------------------------------------------- results

// A vector in the world, scaled by a power of two so that its largest component is in [1, 2): products of two neither
// overflow nor vanish.
static vec3 world_edge(const clast_placement *placement, const float *from, const float *to)
{
    clast_floats4 world = apply(placement->to_world, load_three4(to) - load_three4(from));
    float largest = largest_lane(abs4(world));
    return (vec3)scale_lanes(world, largest > 0.0f && largest <= FLT_MAX ? -exponent_of(largest) : 0);
}

static void store_normal(traversal *w)
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

void CLAST_KERNEL(clast_closest)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                 const clast_hit_filter *filter, clast_hit *hits)
{
    for (size_t i = 0; i < count; i++) {
        traversal w = {.ray = &rays[i], .filter = filter, .any = false};
        traverse(tlas, &w);
        if (w.best_placement != NULL) {
            store_normal(&w);
        }
        w.best.steps = w.steps;
        hits[i] = w.best;
    }
}

void CLAST_KERNEL(clast_any)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                             const clast_hit_filter *filter, uint8_t *occluded)
{
    for (size_t i = 0; i < count; i++) {
        traversal w = {.ray = &rays[i], .filter = filter, .any = true};
        traverse(tlas, &w);
        occluded[i] = w.best_placement != NULL;
    }
}
