// SPDX-License-Identifier: Apache-2.0
// Rays through a scene (shared/cluster.h): the nearest hit, or any. The hits are those of src/accel, to the bit.
//
// A ray goes down by groups: those children of a node that it meets, as bits in the order in which it comes to them (Ylitie,
// Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, 2017). What waits is a stack of groups,
// of which each level of a tree leaves one at most.
//
// Which triangle the ray passes is decided exactly by the signs of edge functions, and the distances of these are found with the
// processor's bits; the rest of a hit is found so at the end (exact_hit). What is next on the way is chosen as early as it is
// known, so that what tells where it lies comes while triangles are tested; what is seldom needed is kept out of registers.
//
// A kernel may define before:
//   TRACE_RAY()       where the ray is read whenever it is needed: clast_ray; without, it is kept
//   TRACE_FILTER(hit) whether a hit of a filtered placement counts: hit has all but normal and steps
//   TRACE_BYTES       0: bytes become floats as halves, 1: by conversion
#ifndef CLAST_ACCEL_TRACE_GLSL
#define CLAST_ACCEL_TRACE_GLSL

#include "accel/ray.glsl"

#ifndef TRACE_BYTES
#define TRACE_BYTES 0u
#endif

// Trees have at most 24 levels each (TREE_LEVELS of shared/tree.h), a cluster has two.
const uint TRACE_STACK = 58u;
// The stack's first places keep what is seldom needed, out of the registers.
const uint COLD_BEST = 0u;      // cluster, triangle
const uint COLD_PLACEMENT = 1u; // of the best, CLAST_NONE where there is none; and the one that the ray is in
const uint COLD_ALONG = 2u;     // the shear's `along` and `along_rest`
const uint COLD_SCALE = 3u;     // the space's `scale`
const uint COLD_SCENE = 4u;     // its address
const uint COLD_CLUSTERS = 5u; // where those of the placement begin to be counted
const uint STACK_BEGIN = 6u;
const uint IN_PLACEMENT = 64u; // a bit of space.octant

// A group of children: `at` is a node's number or a cluster's place. The bits of `rest`:
const uint GROUP_LEFT = 255u;     // children that are left, the next the highest
const uint GROUP_TURN = 8u;       // three bits: child = bit ^ turn
const uint GROUP_CLUSTER = 2048u; // the children are a cluster's nodes
const uint GROUP_START = 4096u;   // there is one child, which is `at`
const uint GROUP_COUNTS = 16u;    // of a cluster's nodes: its counts
// A group of leaves has beside the first two:
const uint LEAVES_SECOND = 2048u; // the first pair of the next leaf was looked at
const uint LEAVES_NODE = 12u;     // three bits: the leaves are eight times this and on

const uint NEXT_NONE = 0xffffffffu; // there is none in this tree
const uint NEXT_CLUSTER = 16u;      // a cluster's node

const float SLACK = 1.9073486328125e-6; // 2^-19
const float BYTES_SHIFT = 1024.0;       // what bytes that became halves have too much

ARRAY_OF(trace_pairs, clast_pair, 8)

// Where a triangle is: a placement, a place of a cluster, and two times a pair's number, plus 1 for its second triangle.
struct trace_place
{
    uint placement, cluster, triangle;
};

struct trace_state
{
    ray_space space;
    ray_shear shear;
    uint64_t nodes; // of the tree that the ray is in
    bool any;
    bool more;                // there may be more to find
    float t;                  // of the best hit, or the ray's end
    float limit;              // as boxes see it
    uint at, rest;            // the group that the ray is at
    uint height, base;        // of the stack, and where that of the placement begins
    uint next;                // the child that comes next: NEXT_NONE, or as GROUP_ tells
    uint next_at;
    uint leaves;              // the group of leaves that is left
    uint leaves_at;           // the place of its cluster
    uint steps;
};

trace_state trace;
uvec2 trace_stack[TRACE_STACK];

bool trace_found() { return trace_stack[COLD_PLACEMENT].x != CLAST_NONE; }
trace_place trace_best()
{
    uvec2 best = trace_stack[COLD_BEST];
    return trace_place(trace_stack[COLD_PLACEMENT].x, best.x, best.y);
}
bool in_placement() { return (trace.space.octant & IN_PLACEMENT) != 0u; }

#ifndef TRACE_RAY
clast_ray trace_kept;
#define TRACE_RAY() trace_kept
#define TRACE_KEEPS
#endif

// -------------------------------------------------------------------------------------------------------------- boxes

// A byte of a word as a float, plus BYTES_SHIFT where it went by a half: 0x6400 is 1024, and its last bits are ones.
float byte_of(uint word, uint which)
{
    if (TRACE_BYTES != 0u) {
        return float(word >> (8u * which) & 255u);
    }
    vec2 halves = unpackHalf2x16((word >> (8u * (which & 1u)) & 0x00ff00ffu) | 0x64006400u);
    return which < 2u ? halves.x : halves.y;
}

// Four boxes, one after the other, which takes fewest registers: bits of those that the ray meets.
uint test_four(uvec3 near_sides, uvec3 far_sides, vec3 step, vec3 near, vec3 far)
{
    uint bits = 0u;
    [[unroll]] for (uint i = 0u; i < 4u; i++) {
        float enter = max(max(fma(byte_of(near_sides.x, i), step.x, near.x), fma(byte_of(near_sides.y, i), step.y, near.y)),
                          max(fma(byte_of(near_sides.z, i), step.z, near.z), trace.space.t_min));
        float leave = min(min(fma(byte_of(far_sides.x, i), step.x, far.x), fma(byte_of(far_sides.y, i), step.y, far.y)),
                          min(fma(byte_of(far_sides.z, i), step.z, far.z), trace.limit));
        bits |= enter <= leave ? 1u << i : 0u;
    }
    return bits;
}

// Eight boxes over a base with exponents. `x`, `y` and `z` are the words of sides[] for each axis.
uint test_boxes(uvec4 base, uvec4 x, uvec4 y, uvec4 z)
{
    vec3 step = vec3(power_of_two(base.w & 255u), power_of_two(base.w >> 8u & 255u), power_of_two(base.w >> 16u & 255u)) *
                trace.space.inverse;
    vec3 shift = (uintBitsToFloat(base.xyz) - trace.space.origin) * trace.space.inverse;
    if (TRACE_BYTES == 0u) {
        shift -= BYTES_SHIFT * step;
    }
    vec3 pad = abs(trace.space.inverse) * trace.space.pad;
    vec3 near = shift - pad, far = shift + pad;
    bvec3 down = bvec3((trace.space.octant & 1u) != 0u, (trace.space.octant & 2u) != 0u, (trace.space.octant & 4u) != 0u);
    x = down.x ? x.zwxy : x;
    y = down.y ? y.zwxy : y;
    z = down.z ? z.zwxy : z;
    return test_four(uvec3(x.x, y.x, z.x), uvec3(x.z, y.z, z.z), step, near, far) |
           test_four(uvec3(x.y, y.y, z.y), uvec3(x.w, y.w, z.w), step, near, far) << 4u;
}

// Bits by place become bits in the order of the ray, the next the highest: bit i is place i ^ turn.
uint turn_bits(uint bits, uint turn)
{
    bits = (turn & 1u) != 0u ? (bits & 0x55u) << 1u | (bits >> 1u & 0x55u) : bits;
    bits = (turn & 2u) != 0u ? (bits & 0x33u) << 2u | (bits >> 2u & 0x33u) : bits;
    return (turn & 4u) != 0u ? (bits & 0x0fu) << 4u | bits >> 4u : bits;
}

// The highest bit is the place that the ray comes to first: the opposite of the signs.
uint tree_turn(uint order)
{
    uint octant = trace.space.octant >> 3u;
    return (octant >> order_axis(order, 0u) & 1u) | (octant >> order_axis(order, 1u) & 1u) << 1u |
           (octant >> order_axis(order, 2u) & 1u) << 2u;
}

uint cluster_turn(uint order)
{
    uint octant = trace.space.octant >> 3u | (trace.space.octant & 7u) << 3u;
    return (octant >> order_side(order, 0u) & 1u) | (octant >> order_side(order, 1u) & 1u) << 1u |
           (octant >> order_side(order, 2u) & 1u) << 2u;
}

// ------------------------------------------------------------------------------------------------------------- spaces

// The best hit's distance, as boxes see it, no less than it may be.
void set_limit()
{
    float t = min(trace.t, NUMBER_MOST);
    vec2 scale = uintBitsToFloat(trace_stack[COLD_SCALE]);
    trace.limit = min((t + abs(t) * SLACK) * scale.x * scale.y, NUMBER_MOST);
}

tame_direction tame_world(clast_ray ray) { return tame(load3(ray.direction), 0); }

uint64_t placement_address(uint number)
{
    return load_address(scene_reference(load_address(trace_stack[COLD_SCENE])).of.placements) + 144ul * number;
}

// Where a cluster of the placement is that the ray is in.
uint64_t cluster_address(uint place)
{
    return load_address(trace_stack[COLD_CLUSTERS]) + uint64_t(CLUSTER_UNIT) * place;
}

// Goes into a placement's tree, at its root. False where nothing can be hit there.
bool enter(uint number)
{
    clast_ray ray = TRACE_RAY();
    uint64_t address = placement_address(number);
    object_ray object = enter_placement(ray, tame_world(ray), address);
    if (!object.there) {
        return false;
    }
    placements from = placements(address);
    trace_stack[COLD_PLACEMENT].y = number;
    trace.nodes = load_address(from.at[0].nodes);
    trace_stack[COLD_CLUSTERS] = from.at[0].clusters;
    trace.space = make_space(object.origin, object.tamed, object.reach, object.reach * PAD_OBJECT, ray.t_min);
    trace.space.octant |= IN_PLACEMENT;
    trace.shear = make_shear(object.origin, object.tamed, object.reach);
    trace_stack[COLD_ALONG] = floatBitsToUint(vec2(trace.shear.along, trace.shear.along_rest));
    trace_stack[COLD_SCALE] = floatBitsToUint(trace.space.scale);
    trace.base = trace.height;
    set_limit();
    return true;
}

// Into the world, or back.
void enter_world()
{
    clast_ray ray = TRACE_RAY();
    clast_device_scene scene = scene_reference(load_address(trace_stack[COLD_SCENE])).of;
    vec3 origin = load3(ray.origin);
    float reach = reach_of(origin, scene.box);
    float pad = min(min(reach * PAD_WORLD, BOX_COORDINATE_MOST) * scene.spread, BOX_COORDINATE_MOST);
    trace.nodes = load_address(scene.nodes);
    trace.space = make_space(origin, tame_world(ray), reach, pad, ray.t_min);
    trace_stack[COLD_SCALE] = floatBitsToUint(trace.space.scale);
    trace.base = STACK_BEGIN;
    set_limit();
}

// -------------------------------------------------------------------------------------------------------------- hits

// A triangle as the ray hits it, to the bit.
struct exact_hit
{
    float t, u, v;
    vec3 corners[3];
    uint instance, cluster, triangle;
};

// The corners of a pair's triangle, in their order, and its number: three times 8 bits, and 8.
uint triangle_of(clast_pair pair, uint second)
{
    if (!pair_is_fan(pair)) {
        return second != 0u ? pair.second : pair.first;
    }
    uint d = pair_corner(pair.second, 2u);
    uint a = pair_corner(pair.first, 0u);
    uint fan[3] = {a, pair_corner(pair.first, second != 0u ? 2u : 1u), second != 0u ? d : pair_corner(pair.first, 2u)};
    uint turn = second != 0u ? pair_second_turn(pair) : pair_first_turn(pair);
    return triangle_word(fan[turn], fan[(turn + 1u) % 3u], fan[(turn + 2u) % 3u],
                         (second != 0u ? pair.second : pair.first) >> 24u);
}

exact_hit find_exactly(trace_place place)
{
    clast_ray ray = TRACE_RAY();
    uint64_t address = placement_address(place.placement);
    object_ray object = enter_placement(ray, tame_world(ray), address);
    ray_shear shear = make_shear(object.origin, object.tamed, object.reach);
    placements from = placements(address);
    uint4s head = uint4s(load_address(from.at[0].clusters) + uint64_t(CLUSTER_UNIT) * place.cluster);
    uvec4 addresses = head.at[1];
    clast_pair pair = trace_pairs(load_address(addresses.zw)).at[place.triangle >> 1u];
    uint triangle = triangle_of(pair, place.triangle & 1u);
    positions3 vertices = positions3(load_address(addresses.xy));
    exact_hit hit;
    for (uint k = 0u; k < 3u; k++) {
        hit.corners[k] = load3(vertices.at[pair_corner(triangle, k)]);
    }
    vec3 a = watertight_vertex(shear.ray, hit.corners[0]);
    vec3 b = watertight_vertex(shear.ray, hit.corners[1]);
    vec3 c = watertight_vertex(shear.ray, hit.corners[2]);
    clast_watertight_edges edges = watertight_edges(a, b, c);
    precise float t = exact_divide(edges.depth, edges.sum) * shear.along * shear.along_rest;
    hit.t = t;
    hit.u = exact_divide(edges.b, edges.sum);
    hit.v = exact_divide(edges.c, edges.sum);
    hit.instance = from.at[0].id;
    hit.cluster = head.at[2].x;
    hit.triangle = triangle >> 24u;
    return hit;
}

// What decides between hits at one distance: the numbers of the instance, the cluster and the triangle.
uvec4 tie_of(trace_place place)
{
    uint64_t address = placement_address(place.placement);
    placements from = placements(address);
    uint4s head = uint4s(load_address(from.at[0].clusters) + uint64_t(CLUSTER_UNIT) * place.cluster);
    clast_pair pair = trace_pairs(load_address(head.at[1].zw)).at[place.triangle >> 1u];
    return uvec4(from.at[0].id, head.at[2].x, triangle_of(pair, place.triangle & 1u) >> 24u, place.placement);
}

// Whether a hit at the distance of the best takes its place.
bool wins_tie(trace_place place)
{
    uvec4 keys[2];
    [[dont_unroll]] for (uint i = 0u; i < 2u; i++) {
        keys[i] = tie_of(i == 0u ? trace_best() : place);
    }
    [[unroll]] for (uint k = 0u; k < 4u; k++) {
        if (keys[0][k] != keys[1][k]) {
            return keys[1][k] < keys[0][k];
        }
    }
    return false;
}

// A triangle that the ray passes, with its edge functions, the depths of its corners, both in the order of its corners.
void consider(uint triangle, vec3 edges, vec3 depths)
{
    precise float sum = (edges.x + edges.y) + edges.z;
    precise float depth = (edges.x * depths.x + edges.y * depths.y) + edges.z * depths.z;
    vec2 along = uintBitsToFloat(trace_stack[COLD_ALONG]);
    precise float t = exact_divide(depth, sum) * along.x * along.y;
    if (!(t >= TRACE_RAY().t_min && t <= trace.t)) {
        return;
    }
    trace_place place = trace_place(trace_stack[COLD_PLACEMENT].y, trace.leaves_at, triangle);
    if (t == trace.t && trace_found() && !wins_tie(place)) {
        return;
    }
#ifdef TRACE_FILTER
    if ((placements(placement_address(place.placement)).at[0].flags & PLACEMENT_FILTERED) != 0u) {
        uvec4 key = tie_of(place);
        clast_hit put;
        put.t = t;
        put.barycentrics = store2(vec2(exact_divide(edges.y, sum), exact_divide(edges.z, sum)));
        put.normal = store3(vec3(0.0));
        put.instance = key.x;
        put.cluster = key.y;
        put.triangle = key.z;
        put.steps = 0u;
        if (!TRACE_FILTER(put)) {
            return;
        }
    }
#endif
    trace_stack[COLD_BEST] = uvec2(place.cluster, place.triangle);
    trace_stack[COLD_PLACEMENT].x = place.placement;
    trace.t = t;
    trace.more = !trace.any;
    set_limit();
}

// ---------------------------------------------------------------------------------------------------------- triangles

// A vertex as watertight_vertex gives it: (v - origin) * scale is v * scale - origin * scale, rounded once, whether fused or
// not, as multiplying by the scale is exact.
precise vec3 shear_vertex(uint64_t vertices, uint number, uvec3 axes, vec3 moved)
{
    floats from = floats(vertices + 12ul * number);
    float scale = trace.shear.ray.scale;
    float z = fma(from.at[axes.z], scale, -moved.z);
    float x = fma(from.at[axes.x], scale, -moved.x);
    float y = fma(from.at[axes.y], scale, -moved.y);
    return vec3(x - trace.shear.ray.shear_x * z, y - trace.shear.ray.shear_y * z, z);
}

// Edge functions of a triangle, as long as none is zero: the weights of its corners.
precise vec3 rough_edges(vec3 a, vec3 b, vec3 c)
{
    float at_a = c.x * b.y - c.y * b.x;
    float at_b = a.x * c.y - a.y * c.x;
    float at_c = b.x * a.y - b.y * a.x;
    return vec3(at_a, at_b, at_c);
}

// Whether a ray passes a triangle with these edge functions: 1; or may, as one is zero: 2.
uint passes(vec3 edges)
{
    ivec3 bits = floatBitsToInt(edges);
    bool same = ((bits.x ^ bits.y) | (bits.x ^ bits.z)) >= 0;
    bool zero = min(min(abs(edges.x), abs(edges.y)), abs(edges.z)) == 0.0;
    return zero ? 2u : same ? 1u : 0u;
}

// Whether all corners of a triangle are numbers that boxes can hold.
bool is_sound_triangle(uint64_t vertices, uint triangle)
{
    bool sound = true;
    for (uint k = 0u; k < 3u; k++) {
        sound = sound && is_sound3(load3(positions3(vertices).at[pair_corner(triangle, k)]));
    }
    return sound;
}

// The next pair of the group of leaves.
void step_pair()
{
    uint counts = trace.leaves >> GROUP_COUNTS, shift = cluster_shift(counts);
    uint bit = uint(findMSB(trace.leaves & GROUP_LEFT));
    uint leaf = (trace.leaves >> LEAVES_NODE & 7u) * TREE_CHILDREN + (bit ^ (trace.leaves >> GROUP_TURN & 7u));
    uint second = (trace.leaves & LEAVES_SECOND) != 0u ? 1u : 0u;
    uint number = min((leaf << shift) + second, cluster_pairs(counts) - 1u);
    trace.leaves = shift > second ? trace.leaves | LEAVES_SECOND : trace.leaves & ~(LEAVES_SECOND | 1u << bit);
    uvec4 addresses = uint4s(cluster_address(trace.leaves_at)).at[1];
    uint64_t vertices = load_address(addresses.xy);
    clast_pair pair = trace_pairs(load_address(addresses.zw)).at[number];
    uint axis = trace.shear.ray.axis;
    uvec3 axes = axis == 0u ? uvec3(1u, 2u, 0u) : axis == 1u ? uvec3(2u, 0u, 1u) : uvec3(0u, 1u, 2u);
    vec3 o = trace.space.origin * trace.shear.ray.scale;
    vec3 moved = axis == 0u ? o.yzx : axis == 1u ? o.zxy : o;
    bool unsound = (counts & CLUSTER_UNSOUND) != 0u, fan = pair_is_fan(pair);
    vec3 a = shear_vertex(vertices, pair_corner(pair.first, 0u), axes, moved);
    vec3 b = shear_vertex(vertices, pair_corner(pair.first, 1u), axes, moved);
    vec3 c = shear_vertex(vertices, pair_corner(pair.first, 2u), axes, moved);
    vec3 d = shear_vertex(vertices, pair_corner(pair.second, 2u), axes, moved);
    [[dont_unroll]] for (uint i = 0u; i < (pair_is_lone(pair) ? 1u : 2u) && trace.more; i++) {
        if (i == 1u) {
            b = c;
            c = d;
            if (!fan) {
                a = shear_vertex(vertices, pair_corner(pair.second, 0u), axes, moved);
                b = shear_vertex(vertices, pair_corner(pair.second, 1u), axes, moved);
            }
        }
        vec3 edges = rough_edges(a, b, c), depths = vec3(a.z, b.z, c.z);
        uint passed = unsound ? 2u : passes(edges);
        if (passed == 0u) {
            continue;
        }
        if (passed == 2u) {
            clast_watertight_edges exact = watertight_edges(a, b, c);
            edges = vec3(exact.a, exact.b, exact.c);
            if (!watertight_passes(exact) || (unsound && !is_sound_triangle(vertices, triangle_of(pair, i)))) {
                continue;
            }
        }
        uint turn = !fan ? 0u : i == 1u ? pair_second_turn(pair) : pair_first_turn(pair);
        edges = turn == 0u ? edges : turn == 1u ? edges.yzx : edges.zxy;
        depths = turn == 0u ? depths : turn == 1u ? depths.yzx : depths.zxy;
        consider(2u * number + i, edges, depths);
    }
}

// -------------------------------------------------------------------------------------------------------------- nodes

bool has_leaves() { return (trace.leaves & GROUP_LEFT) != 0u; }

// Chooses the next child, as early as it is known: what tells where it is begins to be loaded while triangles are tested. The rest of
// its group waits.
void advance()
{
    if ((trace.rest & GROUP_LEFT) == 0u) {
        if (trace.height == trace.base) {
            trace.next = NEXT_NONE;
            return;
        }
        trace.height--;
        trace.at = trace_stack[trace.height].x;
        trace.rest = trace_stack[trace.height].y;
    }
    uint bit = uint(findMSB(trace.rest & GROUP_LEFT));
    uint child = bit ^ (trace.rest >> GROUP_TURN & 7u);
    trace.rest &= ~(1u << bit);
    trace.next = child + 1u | ((trace.rest & GROUP_CLUSTER) != 0u ? NEXT_CLUSTER : 0u);
    trace.next_at = trace.at;
    if ((trace.rest & (GROUP_CLUSTER | GROUP_START)) == 0u) {
        trace.next_at = uints(trace.nodes + 96ul * trace.at + 64ul).at[child];
    }
    if ((trace.rest & GROUP_LEFT) != 0u) {
        trace_stack[trace.height] = uvec2(trace.at, trace.rest);
        trace.height++;
    }
}

// What is known of a cluster's node beside its boxes: loaded before these are tested, as it takes as long to come.
struct cluster_info
{
    uint counts, orders;
};

cluster_info load_cluster(uint64_t address, uint node)
{
    cluster_info info;
    uint4s head = uint4s(address);
    if (node == 0u) {
        uvec4 counts = head.at[2];
        info.counts = counts.y;
        info.orders = counts.z;
    } else {
        info.counts = trace.rest >> GROUP_COUNTS;
        info.orders = uints(address + 40ul).at[node >> 1u];
    }
    return info;
}

// What a cluster's node leaves to do, of bits of its children: its nodes, or leaves.
void leave_cluster(uint place, uint node, cluster_info info, uint bits)
{
    uint turn = cluster_turn(info.orders >> (node & 1u) * 16u);
    uint nodes = cluster_nodes(info.counts), leaves = cluster_leaves(info.counts);
    uint left = nodes == 1u ? leaves : node == 0u ? nodes - 1u : leaves - (node - 1u) * TREE_CHILDREN;
    bits &= (1u << min(left, 8u)) - 1u; // rays from far away may meet boxes that are inside out
    uint group = turn_bits(bits, turn) | turn << GROUP_TURN | info.counts << GROUP_COUNTS;
    if (nodes > 1u && node == 0u) {
        trace.at = place;
        trace.rest = group | GROUP_CLUSTER;
    } else {
        trace.leaves_at = place;
        trace.leaves = group | (max(node, 1u) - 1u) << LEAVES_NODE;
        trace.rest = 0u;
    }
}

// Goes to the next node, and finds which of its children the ray meets.
void step_node()
{
    if (trace.next == NEXT_NONE) {
        trace.more = trace.height != STACK_BEGIN;
        if (trace.more) {
            enter_world();
            trace.rest = 0u;
            advance();
        }
        return;
    }
    uint at = trace.next_at, node = trace.next & 15u; // of a cluster: its place, and which of its nodes; else the node's number
    bool in_cluster = (trace.next & NEXT_CLUSTER) != 0u;
    if ((at & CHILD_ITEM) != 0u) {
        at &= ~CHILD_ITEM;
        in_cluster = in_placement();
        node = 0u;
        if (!in_cluster) {
            if (!enter(at)) {
                trace.rest = 0u;
                advance();
                return;
            }
            at = 0u;
        }
    }
    uint64_t address = in_cluster ? cluster_address(at) : trace.nodes + 96ul * at;
    uint4s sides = uint4s(address + (in_cluster ? CLUSTER_HEAD_BYTES + CLUSTER_NODE_BYTES * node : 16u));
    uvec4 base = uint4s(address).at[0];
    cluster_info info;
    if (in_cluster) {
        info = load_cluster(address, node);
    }
    uint bits = test_boxes(base, sides.at[0], sides.at[1], sides.at[2]);
    trace.steps += !in_cluster || node == 0u ? 1u : 0u;
    if (in_cluster) {
        leave_cluster(at, node, info, bits);
    } else {
        uint turn = tree_turn(base.w >> 24u);
        trace.at = at;
        trace.rest = turn_bits(bits, turn) | turn << GROUP_TURN;
    }
    advance();
}

// ---------------------------------------------------------------------------------------------------------------- use

// Begins a search. `any`: the first hit that is found will do.
void begin_trace(uint64_t scene, clast_ray ray, bool any)
{
#ifdef TRACE_KEEPS
    trace_kept = ray;
#endif
    trace_stack[COLD_SCENE] = store_address(scene);
    trace.any = any;
    trace.t = ray.t_max <= NUMBER_MOST ? ray.t_max : NUMBER_MOST;
    trace_stack[COLD_PLACEMENT].x = CLAST_NONE;
    trace.leaves = 0u;
    trace.height = STACK_BEGIN;
    trace.base = STACK_BEGIN;
    trace.space.octant = 0u;
    trace.steps = 0u;
    uint count = scene_reference(scene).of.placement_count;
    trace.more = count != 0u && is_valid_ray(ray);
    trace.at = count == 1u ? CHILD_ITEM : 0u; // alone: its own tree says whether the ray meets it
    trace.rest = 1u | GROUP_START;
    if (count > 1u && trace.more) {
        enter_world();
    }
    advance();
}

// A vector scaled by a power of two so that its largest component is in [1, 2).
precise vec3 scale_edge(vec3 edge)
{
    float largest = largest_size(edge);
    if (largest > 0.0 && largest <= NUMBER_MOST) {
        vec2 scale = powers_of_two(-exponent_of(largest));
        edge = edge * scale.x * scale.y;
    }
    return edge;
}

// Perpendicular to a triangle in the world, as clast_hit tells.
precise vec3 normal_of(exact_hit hit, uint64_t placement)
{
    placements from = placements(placement);
    vec3 first = apply_map(from.at[0].to_world, hit.corners[1] - hit.corners[0]);
    vec3 second = apply_map(from.at[0].to_world, hit.corners[2] - hit.corners[0]);
    vec3 normal = cross3(first, second);
    float largest = largest_size(normal);
    if (!(largest >= 8.673617379884035e-19 && largest <= 1.152921504606847e18)) { // 2^-60, 2^60
        normal = cross3(scale_edge(first), scale_edge(second));
    }
    return (from.at[0].flags & PLACEMENT_MIRRORED) != 0u ? -normal : normal;
}

// A hit as the caller gets it, of what was found by a ray that ended at t.
clast_hit hit_at(trace_place place, float t, uint steps)
{
    clast_hit result;
    result.t = t;
    result.barycentrics = store2(vec2(0.0));
    result.normal = store3(vec3(0.0));
    result.instance = CLAST_NONE;
    result.cluster = 0u;
    result.triangle = 0u;
    result.steps = steps;
    if (place.placement != CLAST_NONE) {
        exact_hit hit = find_exactly(place);
        result.t = hit.t;
        result.barycentrics = store2(vec2(hit.u, hit.v));
        result.normal = store3(normal_of(hit, placement_address(place.placement)));
        result.instance = hit.instance;
        result.cluster = hit.cluster;
        result.triangle = hit.triangle;
    }
    return result;
}

// What was found. `instance` is CLAST_NONE where nothing was.
clast_hit traced_hit() { return hit_at(trace_best(), trace.t, trace.steps); }

// The nearest hit: clast_trace_closest.
clast_hit trace_closest(uint64_t scene, clast_ray ray)
{
    begin_trace(scene, ray, false);
    while (trace.more) {
        step_node();
        while (has_leaves()) {
            step_pair();
        }
    }
    return traced_hit();
}

// Whether there is any hit: clast_trace_any.
bool trace_any(uint64_t scene, clast_ray ray)
{
    begin_trace(scene, ray, true);
    while (trace.more) {
        step_node();
        while (has_leaves() && trace.more) {
            step_pair();
        }
    }
    return trace_found();
}

#endif
