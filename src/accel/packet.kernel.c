// SPDX-License-Identifier: Apache-2.0
// A packet of rays through the trees, and in and out of its vectors.
//
// What is unusual goes the way of single rays, so that exponents stay far from where floats end: rays that begin behind
// their origin, directions, maps and scenes of sizes beyond 2^60 or below 2^-60.
#include "accel/packet_blocks.h"

#define USUAL_LEAST 8.6736174e-19f // 2^-60
#define USUAL_MOST 1.1529215e18f   // 2^60

// --------------------------------------------------------------------------------------------------------------- trees

CLAST_LANES void count_step(packet *p)
{
    p->steps++;
    p->work++;
}

// A beam that is wide beside the triangles meets far more of them than its rays do: it is given up, whatever it has found.
CLAST_LANES bool is_too_much(const packet *p)
{
    return p->work > p->work_most;
}

typedef struct waiting {
    float near;
    uint32_t child;
} waiting;

typedef struct waiting_stack {
    uint32_t height;
    waiting entries[TREE_STACK];
} waiting_stack;

// Puts what was hit on the stack, above `bottom` the nearest on top.
CLAST_LANES void push_hits(waiting_stack *stack, uint32_t bottom, const uint32_t *children, const beam_hits *hits)
{
    float near[TREE_WIDTH];
    memcpy(near, &hits->near, sizeof near);
    for (uint32_t bits = hits->bits; bits != 0; bits &= bits - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(bits), place = stack->height++;
        for (; place > bottom && stack->entries[place - 1].near <= near[lane]; place--) {
            stack->entries[place] = stack->entries[place - 1];
        }
        stack->entries[place] = (waiting){near[lane], children[lane]};
    }
}

CLAST_LANES void fetch_children(const clast_blas *blas, const uint32_t *children, uint32_t bits)
{
    for (; bits != 0; bits &= bits - 1) {
        uint32_t child = children[__builtin_ctz(bits)];
        const uint8_t *at = (child & CLAST_CHILD_ITEM) != 0
                                ? (const uint8_t *)clast_pool_slot(blas->pool, child & ~CLAST_CHILD_ITEM)
                                : (const uint8_t *)&blas->tree.nodes[child];
        __builtin_prefetch(at);
        __builtin_prefetch(at + 64);
    }
}

// Gives true where the search is over.
CLAST_LANES bool take_block(packet *p, uint32_t slot, const clast_clas *clas, uint32_t number)
{
    uint64_t hits = test_packet_block(p, slot, clas, &clast_clas_topology(clas)->blocks[number]);
    if (hits == 0) {
        return false;
    }
    if (p->any) {
        p->active &= ~hits;
        if (p->active == 0) {
            return true;
        }
    }
    look_no_farther(p, p->object_origin, hits);
    return false;
}

// Gives true where the search is over.
static bool test_packet_cluster(packet *p, uint32_t slot, const clast_clas *clas)
{
    static const uint32_t numbers[TEMPLATE_BLOCKS] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                                      16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
    waiting_stack blocks;
    blocks.height = 0;
    for (uint32_t first = 0; first < clas->block_count; first += TREE_WIDTH) {
        const uint8_t *sides = &clas->groups[first / CLUSTER_WIDTH][0][0][first % CLUSTER_WIDTH];
        beam_hits hits = test_beam(&p->beam, clas->lower, sides, CLUSTER_WIDTH, clas->block_count - first);
        push_hits(&blocks, 0, numbers + first, &hits);
    }
    const clast_template *topology = clast_clas_topology(clas);
    for (uint32_t i = 0; i < blocks.height; i++) {
        __builtin_prefetch(&topology->blocks[blocks.entries[i].child]);
    }
    for (uint32_t i = 0; blocks.height != 0 && i < topology->vertex_count; i += 5) { // five or six are a cache line
        __builtin_prefetch(clast_clas_vertices(clas) + 3 * i);
    }
    while (blocks.height > 0) {
        waiting next = blocks.entries[--blocks.height];
        if (next.near > p->beam.all.farthest) {
            break;
        }
        if (take_block(p, slot, clas, next.child)) {
            return true;
        }
    }
    return false;
}

static void traverse_packet_blas(packet *p, const clast_blas *blas)
{
    waiting_stack stack;
    stack.height = 1;
    stack.entries[0] = (waiting){-INFINITY, 0};
    while (stack.height > 0 && !is_too_much(p)) {
        waiting next = stack.entries[--stack.height];
        if (next.near > p->beam.all.farthest) {
            continue;
        }
        count_step(p);
        uint32_t slot = next.child & ~CLAST_CHILD_ITEM;
        if (slot != next.child) {
            if (test_packet_cluster(p, slot, clast_pool_slot(blas->pool, slot))) {
                return;
            }
            continue;
        }
        const clast_node *node = &blas->tree.nodes[next.child];
        beam_hits hits = test_beam(&p->beam, node->lower, node->boxes[0][0], TREE_WIDTH, node->child_count);
        fetch_children(blas, node->children, hits.bits);
        push_hits(&stack, stack.height, node->children, &hits);
    }
}

// ------------------------------------------------------------------------------------------------------- powers of two

CLAST_LANES lanes two_to_each(lane_ints exponent)
{
    return (lanes)((exponent + splat_int(127)) << 23);
}

// exponent_of, for each lane.
CLAST_LANES lane_ints exponents_of(lanes x)
{
    lane_ints biased = (lane_ints)x >> 23, tiny = (lane_ints)(x * splat(0x1p64f)) >> 23;
    return pick_int(is_equal_int(biased, splat_int(0)), tiny - splat_int(127 + 64), biased - splat_int(127));
}

// Half of an exponent, towards zero.
CLAST_LANES lane_ints half_of(lane_ints exponent)
{
    return (exponent - (exponent >> 31)) >> 1;
}

// scale_lanes, for exponents that need no cutting.
CLAST_LANES lanes scale_each(lanes x, lane_ints exponent)
{
    lane_ints half = half_of(exponent);
    return x * two_to_each(half) * two_to_each(exponent - half);
}

CLAST_LANES lanes largest_of_three(const lanes v[3])
{
    lanes x = absolute(v[0]), y = absolute(v[1]), z = absolute(v[2]);
    lanes most = pick(is_less(y, x), x, y);
    return pick(is_less(z, most), most, z);
}

CLAST_LANES lane_mask is_usual(lanes x)
{
    return is_at_most(splat(USUAL_LEAST), x) & is_at_most(x, splat(USUAL_MOST));
}

// ----------------------------------------------------------------------------------------------------------- instances

// Rays of one part as an instance, or the world, sees them.
typedef struct view {
    lanes origin[3], direction[3]; // directions with their largest component in [1, 2)
    lane_ints exponent;       // by two, of what they were multiplied by to that end, negated; the ray's own included
    lanes reach;              // largest distance from the origin to a side of the box
    lane_ints axis;           // main axis, times two, plus one where it is run downwards
    uint32_t enters, strange; // rays that may hit something, and of these those that have to be traced alone
} view;

CLAST_LANES void apply_each(const float columns[3][4], const lanes v[3], lanes result[3])
{
    for (int row = 0; row < 3; row++) {
        result[row] = splat(columns[0][row]) * v[0] + splat(columns[1][row]) * v[1] + splat(columns[2][row]) * v[2];
    }
}

CLAST_LANES lanes reach_of_each(const lanes origin[3], const clast_box *box)
{
    lanes most[3];
    for (int axis = 0; axis < 3; axis++) {
        most[axis] = maximum(absolute(splat(box->lower.v[axis]) - origin[axis]),
                             absolute(splat(box->upper.v[axis]) - origin[axis]));
    }
    return largest_of_three(most);
}

// watertight_ray's axis of each direction, and its sign.
CLAST_LANES lane_ints main_axis_of(const lanes d[3])
{
    lanes x = absolute(d[0]), y = absolute(d[1]), z = absolute(d[2]);
    lane_mask is_x = is_at_most(y, x) & is_at_most(z, x), is_y = is_at_most(z, y);
    lane_ints axis = pick_int(is_x, splat_int(0), pick_int(is_y, splat_int(2), splat_int(4)));
    lanes along = pick(is_x, d[0], pick(is_y, d[1], d[2]));
    return axis + pick_int(is_less(along, splat(0.0f)), splat_int(1), splat_int(0));
}

// What enter_instance (ray_hits.h) does.
CLAST_LANES void view_part(const packet *p, int part, const clast_placement *placement, view *view)
{
    lanes from[3], to[3], turned[3];
    for (int axis = 0; axis < 3; axis++) {
        from[axis] = p->origin[axis][part] - splat(placement->origin[axis]);
        to[axis] = p->direction[axis][part];
    }
    apply_each(placement->to_object, from, view->origin);
    apply_each(placement->to_object, to, turned);
    lanes largest = largest_of_three(turned);
    view->reach = reach_of_each(view->origin, &placement->blas->tree.boxes[0]);
    lane_mask enters = is_less(splat(0.0f), largest);
    for (int axis = 0; axis < 3; axis++) {
        enters &= is_at_most(absolute(turned[axis]), splat(FLT_MAX));
        enters &= is_at_most(absolute(view->origin[axis]), splat(BOX_COORDINATE_MOST));
    }
    view->enters = mask_bits(enters);
    view->strange = view->enters & ~mask_bits(is_usual(largest) & is_usual(view->reach));
    lane_ints own = exponents_of(largest);
    view->exponent = p->exponent[part] + own;
    for (int axis = 0; axis < 3; axis++) {
        view->direction[axis] = scale_each(turned[axis], splat_int(0) - own);
    }
    view->axis = main_axis_of(view->direction);
}

// Of the rays, those with the main axis of the first, which is told.
CLAST_LANES uint64_t rays_of_one_axis(const lane_ints axes[PARTS], uint64_t rays, int32_t *axis)
{
    *axis = RAY_LANE(axes, (uint32_t)__builtin_ctzll(rays));
    uint64_t same = 0;
    for (int part = 0; part < PARTS; part++) {
        same |= packet_bits(mask_bits(is_equal_int(axes[part], splat_int(*axis))), part);
    }
    return same & rays;
}

// set_shear (ray_hits.h).
CLAST_LANES void set_part_shear(packet *p, int part, const view *view, uint32_t w)
{
    lanes least = splat(WATERTIGHT_SHEAR_LEAST), zero = splat(0.0f), d = view->direction[w];
    lanes shear_x = view->direction[(w + 1) % 3] / d, shear_y = view->direction[(w + 2) % 3] / d;
    p->shear_x[part] = pick(is_less(absolute(shear_x), least), zero, shear_x);
    p->shear_y[part] = pick(is_less(absolute(shear_y), least), zero, shear_y);
    lane_ints scale = splat_int((int32_t)WATERTIGHT_EXPONENT) - exponents_of(view->reach);
    lane_ints rest = splat_int(0) - (view->exponent + scale), half = half_of(rest);
    p->scale[part] = two_to_each(scale);
    p->along[part] = splat(1.0f) / d * two_to_each(half);
    p->along_rest[part] = two_to_each(rest - half);
    p->depth[part] = scale_each(absolute(d), view->exponent);
    for (uint32_t k = 0; k < 3; k++) {
        p->object_origin[k][part] = view->origin[(w + 1 + k) % 3];
    }
}

static void trace_group(packet *p, const clast_blas *blas, const view views[PARTS], uint64_t group, int32_t axis,
                        float pad)
{
    lanes slopes[2][PARTS];
    uint32_t w = (uint32_t)axis / 2;
    for (int part = 0; part < PARTS; part++) {
        if (part_bits(group, part) != 0) {
            set_part_shear(p, part, &views[part], w);
            slopes[0][part] = p->shear_x[part];
            slopes[1][part] = p->shear_y[part];
        }
    }
    fit_beam(p, (const lanes(*)[PARTS])p->object_origin, (const lanes(*)[PARTS])slopes, group, w, axis % 2 != 0, pad);
    traverse_packet_blas(p, blas);
}

// Takes rays through an instance, and gives those that are still searching.
static uint64_t trace_placement(packet *p, uint32_t number, uint64_t rays)
{
    const clast_placement *placement = &p->batch->tlas->placements[number];
    if (placement->blas == NULL) {
        return rays;
    }
    p->work += PACKET_WORK_INSTANCE;
    view views[PARTS];
    lane_ints axes[PARTS];
    uint64_t left = 0, strange = 0;
    float reach = 0.0f;
    for (int part = 0; part < PARTS; part++) {
        uint32_t bits = part_bits(rays, part);
        if (bits != 0) {
            view_part(p, part, placement, &views[part]);
            axes[part] = views[part].axis;
            strange |= packet_bits(views[part].strange & bits, part);
            bits &= views[part].enters & ~views[part].strange;
            left |= packet_bits(bits, part);
            float most = most_lane(views[part].reach, bits);
            reach = most > reach ? most : reach;
        } else {
            axes[part] = splat_int(-1);
        }
    }
    p->restart |= strange;
    p->here = number;
    p->filter = placement->filtered ? p->batch->filter : NULL;
    uint64_t searching = rays & ~strange;
    while (left != 0 && !is_too_much(p)) {
        int32_t axis;
        uint64_t group = rays_of_one_axis(axes, left, &axis);
        trace_group(p, placement->blas, views, group, axis, reach * PAD_OBJECT);
        left &= ~group;
        searching &= ~group | p->active;
    }
    return searching;
}

// The beam of a group in the world. Its origins and depths, which instances overwrite in the packet, are kept with it.
typedef struct world_beam {
    beam beam;
    lanes origin[3][PARTS], depth[PARTS];
} world_beam;

static void fit_world_beam(packet *p, world_beam *world, uint64_t group, int32_t axis)
{
    const clast_tlas *tlas = p->batch->tlas;
    uint32_t w = (uint32_t)axis / 2;
    lanes slopes[2][PARTS];
    float reach = 0.0f;
    for (int part = 0; part < PARTS; part++) {
        lanes origin[3] = {p->origin[0][part], p->origin[1][part], p->origin[2][part]}, d = p->direction[w][part];
        for (uint32_t k = 0; k < 3; k++) {
            world->origin[k][part] = origin[(w + 1 + k) % 3];
        }
        slopes[0][part] = p->direction[(w + 1) % 3][part] / d;
        slopes[1][part] = p->direction[(w + 2) % 3][part] / d;
        p->depth[part] = world->depth[part] = scale_each(absolute(d), p->exponent[part]);
        float most = most_lane(reach_of_each(origin, &tlas->tree.boxes[0]), part_bits(group, part));
        reach = most > reach ? most : reach;
    }
    float pad = min1(reach * PAD_WORLD * tlas->spread, BOX_COORDINATE_MOST);
    fit_beam(p, (const lanes(*)[PARTS])world->origin, (const lanes(*)[PARTS])slopes, group, w, axis % 2 != 0, pad);
    world->beam = p->beam;
}

// After an instance, for the rays that are left.
static void return_to_world(packet *p, world_beam *world, uint64_t rays)
{
    p->beam = world->beam;
    memcpy(p->depth, world->depth, sizeof p->depth);
    p->active = rays;
    look_no_farther(p, (const lanes(*)[PARTS])world->origin, ~0ull);
    world->beam = p->beam;
}

static void trace_world_group(packet *p, uint64_t group, int32_t axis)
{
    const clast_tlas *tlas = p->batch->tlas;
    world_beam world;
    fit_world_beam(p, &world, group, axis);
    waiting_stack stack;
    stack.height = 1;
    stack.entries[0] = (waiting){-INFINITY, 0};
    while (stack.height > 0 && group != 0 && !is_too_much(p)) {
        waiting next = stack.entries[--stack.height];
        if (next.near > world.beam.all.farthest) {
            continue;
        }
        if ((next.child & CLAST_CHILD_ITEM) != 0) {
            group = trace_placement(p, next.child & ~CLAST_CHILD_ITEM, group);
            return_to_world(p, &world, group);
            continue;
        }
        count_step(p);
        const clast_node *node = &tlas->tree.nodes[next.child];
        beam_hits hits = test_beam(&world.beam, node->lower, node->boxes[0][0], TREE_WIDTH, node->child_count);
        push_hits(&stack, stack.height, node->children, &hits);
    }
}

// ------------------------------------------------------------------------------------------------------------- rays in

// Rows become columns.
CLAST_LANES void transpose8(clast_floats8 r[8])
{
    clast_floats8 a[8], b[8];
    for (int i = 0; i < 8; i += 2) {
        a[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        a[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int i = 0; i < 8; i += 4) {
        for (int k = 0; k < 2; k++) {
            b[i + 2 * k] = __builtin_shufflevector(a[i + k], a[i + 2 + k], 0, 1, 8, 9, 4, 5, 12, 13);
            b[i + 2 * k + 1] = __builtin_shufflevector(a[i + k], a[i + 2 + k], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    }
    for (int i = 0; i < 4; i++) {
        r[i] = __builtin_shufflevector(b[i], b[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        r[i + 4] = __builtin_shufflevector(b[i], b[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

_Static_assert(sizeof(clast_ray) == 32 && offsetof(clast_ray, direction) == 16, "eight floats, as they are loaded");

// Lanes beyond the last ray repeat the first.
static void load_rays(packet *p, uint32_t count)
{
    for (uint32_t first = 0; first < PACKET_RAYS; first += 8) {
        clast_floats8 rows[8];
        for (uint32_t i = 0; i < 8; i++) {
            memcpy(&rows[i], &p->batch->rays[p->numbers[first + i < count ? first + i : 0]], sizeof rows[i]);
        }
        transpose8(rows);
        for (int axis = 0; axis < 3; axis++) {
            memcpy((float *)p->origin[axis] + first, &rows[axis], sizeof rows[axis]);
            memcpy((float *)p->direction[axis] + first, &rows[4 + axis], sizeof rows[axis]);
        }
        memcpy((float *)p->t_min + first, &rows[3], sizeof rows[3]);
        memcpy((float *)p->t + first, &rows[7], sizeof rows[7]);
    }
}

// What begin_ray (ray_hits.h) does. Gives the rays that can hit something.
CLAST_LANES uint32_t begin_part(packet *p, int part, uint32_t *strange)
{
    lanes d[3] = {p->direction[0][part], p->direction[1][part], p->direction[2][part]};
    lanes largest = largest_of_three(d), most = splat(FLT_MAX), t_min = p->t_min[part];
    lane_mask valid = is_less(splat(0.0f), largest) & is_at_most(absolute(t_min), most) & is_at_most(t_min, p->t[part]);
    for (int axis = 0; axis < 3; axis++) {
        valid &= is_at_most(absolute(d[axis]), most);
        valid &= is_at_most(absolute(p->origin[axis][part]), splat(BOX_COORDINATE_MOST));
    }
    *strange = mask_bits(valid) & ~mask_bits(is_usual(largest) & is_at_most(splat(0.0f), t_min));
    p->exponent[part] = exponents_of(largest);
    for (int axis = 0; axis < 3; axis++) {
        p->direction[axis][part] = scale_each(d[axis], splat_int(0) - p->exponent[part]);
    }
    p->t[part] = pick(is_at_most(p->t[part], most), p->t[part], most);
    p->weight_b[part] = p->weight_c[part] = splat(0.0f);
    p->weight_sum[part] = splat(1.0f);
    p->slot[part] = p->triangle[part] = splat_int(0);
    p->placement[part] = splat_int(-1);
    return mask_bits(valid) & ~*strange;
}

static bool all_share_origin(const packet *p)
{
    uint32_t differ = 0;
    for (int part = 0; part < PARTS; part++) {
        for (int axis = 0; axis < 3; axis++) {
            differ |= ~mask_bits(is_equal(p->origin[axis][part], splat(p->origin[axis][0][0])));
        }
    }
    return (differ & ((1u << LANES) - 1u)) == 0;
}

// Gives the rays that search.
static uint64_t begin_packet(packet *p, uint32_t count)
{
    uint64_t rays = 0;
    p->restart = 0;
    load_rays(p, count);
    p->shares_origin = all_share_origin(p);
    for (int part = 0; part < PARTS; part++) {
        uint32_t strange;
        rays |= packet_bits(begin_part(p, part, &strange), part);
        p->restart |= packet_bits(strange, part);
    }
    uint64_t those = count < PACKET_RAYS ? (1ull << count) - 1u : ~0ull;
    p->restart &= those;
    return rays & those;
}

static void trace_packet(packet *p, uint64_t rays)
{
    const clast_tlas *tlas = p->batch->tlas;
    if (!tlas->visible) {
        p->restart = 0;
        return;
    }
    if (tlas->placement_count == 1) {
        if (rays != 0) {
            trace_placement(p, 0, rays);
        }
        return;
    }
    lane_ints axes[PARTS];
    for (int part = 0; part < PARTS; part++) {
        lanes d[3] = {p->direction[0][part], p->direction[1][part], p->direction[2][part]};
        axes[part] = main_axis_of(d);
    }
    while (rays != 0 && !is_too_much(p)) {
        int32_t axis;
        uint64_t group = rays_of_one_axis(axes, rays, &axis);
        trace_world_group(p, group, axis);
        rays &= ~group;
    }
}

// ------------------------------------------------------------------------------------------------------------ hits out

// scale_edge (ray_hits.h).
CLAST_LANES void scale_edges(lanes edge[3])
{
    lanes largest = largest_of_three((const lanes *)edge);
    lane_mask usual = is_less(splat(0.0f), largest) & is_at_most(largest, splat(FLT_MAX));
    lane_ints exponent = pick_int(usual, splat_int(0) - exponents_of(largest), splat_int(0));
    for (int axis = 0; axis < 3; axis++) {
        edge[axis] = scale_each(edge[axis], exponent);
    }
}

CLAST_LANES void cross_each(const lanes edges[2][3], lanes normal[3])
{
    for (int axis = 0; axis < 3; axis++) {
        int y = (axis + 1) % 3, z = (axis + 2) % 3;
        normal[axis] = edges[0][y] * edges[1][z] - edges[0][z] * edges[1][y];
    }
}

// The normals of a part's triangles, as if all were of one placement.
CLAST_LANES void find_normals(const packet *p, int part, const clast_placement *placement, lanes normal[3])
{
    lanes edges[2][3];
    for (int edge = 0; edge < 2; edge++) {
        lanes own[3] = {p->edges[edge][0][part], p->edges[edge][1][part], p->edges[edge][2][part]};
        if (placement->is_identity) {
            memcpy(edges[edge], own, sizeof own);
        } else {
            apply_each(placement->to_world, own, edges[edge]);
        }
    }
    cross_each((const lanes(*)[3])edges, normal);
    lanes largest = largest_of_three(normal);
    lane_mask usual = is_at_most(splat(NORMAL_LEAST), largest) & is_at_most(largest, splat(NORMAL_MOST));
    if ((~mask_bits(usual) & ((1u << LANES) - 1u)) != 0) { // as store_hit (ray_hits.h) has it
        lanes scaled[3];
        scale_edges(edges[0]);
        scale_edges(edges[1]);
        cross_each((const lanes(*)[3])edges, scaled);
        for (int axis = 0; axis < 3; axis++) {
            normal[axis] = pick(usual, normal[axis], scaled[axis]);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        normal[axis] = placement->mirrored ? -normal[axis] : normal[axis];
    }
}

// The normals and the instances' ids.
CLAST_LANES void find_instances(const packet *p, int part, lanes normal[3], lane_ints *instance)
{
    *instance = splat_int((int32_t)CLAST_NONE);
    for (int axis = 0; axis < 3; axis++) {
        normal[axis] = splat(0.0f);
    }
    uint32_t left = ~mask_bits(is_equal_int(p->placement[part], splat_int(-1))) & ((1u << LANES) - 1u);
    while (left != 0) {
        int32_t number = p->placement[part][__builtin_ctz(left)];
        const clast_placement *placement = &p->batch->tlas->placements[number];
        lane_mask same = is_equal_int(p->placement[part], splat_int(number));
        lanes theirs[3];
        find_normals(p, part, placement, theirs);
        for (int axis = 0; axis < 3; axis++) {
            normal[axis] = pick(same, theirs[axis], normal[axis]);
        }
        *instance = pick_int(same, splat_int((int32_t)placement->id), *instance);
        left &= ~mask_bits(same);
    }
}

_Static_assert(offsetof(clast_hit, cluster) == 28 && offsetof(clast_hit, triangle) == 32, "eight words, and two more");

static void store_part(const packet *p, int part, uint32_t count)
{
    lanes columns[8];
    lane_ints instance;
    columns[0] = p->t[part];
    columns[1] = p->weight_b[part] / p->weight_sum[part];
    columns[2] = p->weight_c[part] / p->weight_sum[part];
    find_instances(p, part, &columns[3], &instance);
    columns[6] = (lanes)instance;
    columns[7] = (lanes)p->slot[part];
    for (uint32_t first = 0; first < LANES; first += 8) {
        clast_floats8 rows[8];
        for (int i = 0; i < 8; i++) {
            memcpy(&rows[i], (const float *)&columns[i] + first, sizeof rows[i]);
        }
        transpose8(rows);
        for (uint32_t i = first; i < first + 8 && i < count; i++) {
            clast_hit *hit = &p->batch->hits[p->numbers[(uint32_t)part * LANES + i]];
            memcpy(hit, &rows[i - first], sizeof rows[0]);
            hit->triangle = (uint32_t)p->triangle[part][i];
            hit->steps = p->steps;
        }
    }
}

static void store_packet(const packet *p, uint32_t count)
{
    if (p->any) {
        for (uint32_t i = 0; i < count; i++) {
            p->batch->occluded[p->numbers[i]] = RAY_LANE(p->placement, i) >= 0;
        }
        return;
    }
    for (uint32_t first = 0; first < count; first += LANES) {
        store_part(p, (int)(first / LANES), count - first);
    }
}

static void trace_alone(const packet *p)
{
    const clast_batch *batch = p->batch;
    for (uint64_t left = p->restart; left != 0; left &= left - 1) {
        uint32_t number = p->numbers[__builtin_ctzll(left)];
        if (p->any) {
            CLAST_KERNEL(clast_any)(batch->tlas, &batch->rays[number], 1, batch->filter, &batch->occluded[number]);
        } else {
            CLAST_KERNEL(clast_closest)(batch->tlas, &batch->rays[number], 1, batch->filter, &batch->hits[number]);
        }
    }
}

// At most PACKET_RAYS rays, by their numbers.
bool CLAST_KERNEL(clast_packet)(const clast_batch *batch, const uint32_t *numbers, uint32_t count)
{
    packet p;
    p.batch = batch;
    p.numbers = numbers;
    p.any = batch->hits == NULL;
    p.steps = p.work = 0;
    p.work_most = count * PACKET_WORK_MOST;
    trace_packet(&p, begin_packet(&p, count));
    bool is_whole = !is_too_much(&p);
    if (is_whole) {
        store_packet(&p, count);
    } else {
        p.restart = count < PACKET_RAYS ? (1ull << count) - 1u : ~0ull;
    }
    trace_alone(&p);
    return is_whole;
}
