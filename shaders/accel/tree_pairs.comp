// SPDX-License-Identifier: Apache-2.0
// Binary trees from the bottom up: H-PLOC (Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler, H-PLOC: Hierarchical Parallel
// Locally-Ordered Clustering for Bounding Volume Hierarchy Construction, HPG 2024). Items are in the order of their codes. An
// invocation begins at each, and walks up the tree of the codes: where two ranges meet, the first to come stops, and the
// second takes both. Where there are many clusters in a range then, its group joins nearest neighbours until there are few.
//
// A group is 32 invocations that share memory, and wait for each other by barriers where subgroups are narrower; nothing
// relies on how they diverge. Nodes have numbers that do not depend on timing: each cluster stands for one of its items, and a
// pair takes the number of the item for which its right half stood. So none has number 0.
//
// Costs of gathering pairs into nodes of eight are found on the way (accel/tree_collapse.c).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 32) in;
layout(constant_id = 0) const uint KEY_WORDS = 1u;
layout(constant_id = 1) const uint LANES_TOGETHER = 0u; // 1: subgroups are 32 wide or wider

const uint LANES = 32u;
const uint FEW = 16u; // clusters that a range keeps, at most
const uint RADIUS = 8u;
const uint COSTS = 7u;

// Other groups write these at the same time.
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer shared_numbers { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer shared_slots { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer shared_words { uvec4 at[]; };

// The clusters that are being joined.
shared float sides[6u * LANES];
shared float costs[COSTS * LANES];
shared uint clusters[LANES]; // an item or a pair
shared uint stands[LANES];   // for which item, counted through all jobs
shared uint nearest[LANES];
shared uint kept;
// What the invocations want joined.
shared uint wanting[2];
shared uint walking[2];
shared uint lefts[LANES], rights[LANES], splits[LANES], jobs_of[LANES];

void lanes_barrier()
{
    if (LANES_TOGETHER != 0u) {
        subgroupMemoryBarrierShared();
        subgroupBarrier();
    } else {
        barrier();
    }
}

// ---------------------------------------------------------------------------------------------------------- walking up

uvec2 key_difference(uint i)
{
    if (KEY_WORDS == 1u) {
        return uvec2(uints(push.keys).at[i] ^ uints(push.keys).at[i + 1u], 0u);
    }
    uint64_t difference = uint64s(push.keys).at[i] ^ uint64s(push.keys).at[i + 1u];
    return uvec2(uint(difference), uint(difference >> 32));
}

// Whether items a and a + 1 are nearer to each other than b and b + 1. Of equal codes, numbers decide, which halves them.
bool is_nearer(uint a, uint b)
{
    uvec2 x = key_difference(a), y = key_difference(b);
    if (x != y) {
        return x.y != y.y ? x.y < y.y : x.x < y.x;
    }
    uint p = a ^ (a + 1u), q = b ^ (b + 1u);
    return p != q ? p < q : a < b;
}

struct walk {
    uint left, right; // the range's ends
    uint split;       // where its right half begins
    bool goes_on;
};

// Takes the range to where it meets its neighbour. What this group has written is seen by whoever goes on there, and what those
// wrote who came before is seen by this group: a barrier follows each step and each merge.
walk step_up(walk w, uint first, uint last)
{
    shared_numbers ranges = shared_numbers(push.ranges);
    bool to_right = w.left == first || (w.right != last && is_nearer(w.right, w.left - 1u));
    uint met = atomicExchange(ranges.at[to_right ? w.right : w.left - 1u], to_right ? w.left : w.right);
    memoryBarrierBuffer();
    w.goes_on = met != CLAST_NONE;
    if (w.goes_on) {
        w.split = to_right ? w.right + 1u : w.left;
        w.left = to_right ? w.left : met;
        w.right = to_right ? met : w.right;
    }
    return w;
}

// -------------------------------------------------------------------------------------------------------------- joining

struct merge_job {
    uint64_t boxes;
    uint first; // item
    uint number;
    float scale;
};

vec3 lower_of(uint i) { return vec3(sides[i], sides[LANES + i], sides[2u * LANES + i]); }
vec3 upper_of(uint i) { return vec3(sides[3u * LANES + i], sides[4u * LANES + i], sides[5u * LANES + i]); }

void put_box(uint i, vec3 lower, vec3 upper)
{
    for (uint axis = 0u; axis < 3u; axis++) {
        sides[axis * LANES + i] = lower[axis];
        sides[(axis + 3u) * LANES + i] = upper[axis];
    }
}

// Takes the clusters of both halves of a range, and gives how many there are.
uint load_clusters(uint lane, uint left, uint right, uint split, merge_job job)
{
    shared_slots slots = shared_slots(push.slots);
    if (lane == 0u) {
        kept = 0u;
    }
    lanes_barrier();
    bool is_right = lane >= FEW;
    uint place = is_right ? split + (lane - FEW) : left + lane;
    uvec2 slot = uvec2(CLAST_NONE);
    if (is_right ? place <= right : place < split) {
        slot = slots.at[place];
    }
    if (slot.x != CLAST_NONE) {
        atomicOr(kept, 1u << lane);
    }
    lanes_barrier();
    uint there = kept, count = bitCount(there);
    if (slot.x != CLAST_NONE) {
        uint to = bitCount(there & ((1u << lane) - 1u));
        clusters[to] = slot.x;
        stands[to] = slot.y;
    }
    lanes_barrier();
    if (lane < count) {
        uint cluster = clusters[lane];
        bool is_item = (cluster & CHILD_ITEM) != 0u;
        if (is_item) {
            clast_box box = load_item_box(job.boxes, cluster & ~CHILD_ITEM);
            put_box(lane, box.lower, box.upper);
        } else {
            shared_words words = shared_words(push.pairs + 64ul * (job.first + cluster));
            uvec4 a = words.at[0], b = words.at[1], c = words.at[2], d = words.at[3];
            put_box(lane, uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz));
            [[unroll]] for (uint i = 0u; i < COSTS; i++) {
                costs[i * LANES + lane] = uintBitsToFloat(i < 4u ? c[i & 3u] : d[i & 3u]);
            }
        }
        for (uint i = 0u; is_item && i < COSTS; i++) {
            costs[i * LANES + lane] = 0.0; // items are visited alike, however they are gathered
        }
    }
    lanes_barrier();
    return count;
}

// The cluster that is nearest to one's own: the box around both is least. Ties go to lower numbers, so that some two are
// nearest to each other.
uint find_nearest(uint lane, uint count, float scale)
{
    vec3 lower = lower_of(lane), upper = upper_of(lane);
    float least = 0.0;
    uint best = lane, best_pair = 0u;
    uint first = lane > RADIUS ? lane - RADIUS : 0u, end = min(lane + RADIUS + 1u, count);
    for (uint i = first; i < end; i++) {
        if (i == lane) {
            continue;
        }
        float area = half_area(min(lower, lower_of(i)), max(upper, upper_of(i)), scale);
        uint pair = min(lane, i) * LANES + max(lane, i);
        if (best == lane || area < least || (area == least && pair < best_pair)) {
            least = area;
            best = i;
            best_pair = pair;
        }
    }
    return best;
}

struct pair_costs {
    float of[COSTS];
    uint shares;
};

// From those of the halves: of n children the left half gets as many as is best.
pair_costs find_costs(uint left, uint right, float area)
{
    float a[COSTS], b[COSTS];
    [[unroll]] for (uint i = 0u; i < COSTS; i++) {
        a[i] = costs[i * LANES + left];
        b[i] = costs[i * LANES + right];
    }
    float best[COSTS + 2u]; // of n children at n
    pair_costs result;
    result.shares = 0u;
    [[unroll]] for (uint n = 2u; n <= TREE_CHILDREN; n++) {
        best[n] = a[0] + b[n - 2u];
        uint share = 1u;
        [[unroll]] for (uint s = 2u; s < n; s++) {
            float cost = a[s - 1u] + b[n - s - 1u];
            share = cost < best[n] ? s : share;
            best[n] = min(cost, best[n]);
        }
        result.shares |= share << (3u * n - 6u);
    }
    result.of[0] = area + best[TREE_CHILDREN]; // as one child it is a node, with eight of its own
    [[unroll]] for (uint n = 2u; n <= COSTS; n++) {
        bool worse = best[n] >= result.of[n - 2u];
        result.of[n - 1u] = worse ? result.of[n - 2u] : best[n];
        result.shares &= worse ? ~(7u << (3u * n - 6u)) : CLAST_NONE;
    }
    return result;
}

void write_pair(merge_job job, uint number, uint left, uint right, vec3 lower, vec3 upper, pair_costs cost)
{
    shared_words words = shared_words(push.pairs + 64ul * (job.first + number));
    words.at[0] = uvec4(floatBitsToUint(lower), left);
    words.at[1] = uvec4(floatBitsToUint(upper), right);
    words.at[2] = floatBitsToUint(vec4(cost.of[0], cost.of[1], cost.of[2], cost.of[3]));
    words.at[3] = uvec4(floatBitsToUint(vec3(cost.of[4], cost.of[5], cost.of[6])), cost.shares);
}

// Joins those that are nearest to each other, and gives how many clusters are left.
uint join_nearest(uint lane, uint count, merge_job job)
{
    bool there = lane < count;
    if (lane == 0u) {
        kept = 0u;
    }
    uint other = there ? find_nearest(lane, count, job.scale) : lane;
    nearest[lane] = other;
    lanes_barrier();
    bool joins = there && nearest[other] == lane;
    bool keeps = there && !(joins && other < lane);
    if (keeps) {
        atomicOr(kept, 1u << lane);
    }
    vec3 lower = lower_of(lane), upper = upper_of(lane);
    uint cluster = clusters[lane], stand = stands[lane];
    pair_costs cost;
    if (joins && keeps) {
        lower = min(lower, lower_of(other));
        upper = max(upper, upper_of(other));
        cost = find_costs(lane, other, half_area(lower, upper, job.scale));
        uint number = stands[other] - job.first;
        write_pair(job, number, cluster, clusters[other], lower, upper, cost);
        cluster = number;
    } else {
        [[unroll]] for (uint i = 0u; i < COSTS; i++) {
            cost.of[i] = costs[i * LANES + lane];
        }
    }
    lanes_barrier();
    uint left = kept;
    if (keeps) {
        uint to = bitCount(left & ((1u << lane) - 1u));
        put_box(to, lower, upper);
        clusters[to] = cluster;
        stands[to] = stand;
        [[unroll]] for (uint i = 0u; i < COSTS; i++) {
            costs[i * LANES + to] = cost.of[i];
        }
    }
    lanes_barrier();
    return bitCount(left);
}

void merge_range(uint lane, uint left, uint right, uint split, merge_job job, bool is_all)
{
    uint before = load_clusters(lane, left, right, split, job);
    uint count = before;
    while (count > (is_all ? 1u : FEW)) {
        count = join_nearest(lane, count, job);
    }
    if (lane < before) {
        shared_slots(push.slots).at[left + lane] = lane < count ? uvec2(clusters[lane], stands[lane]) : uvec2(CLAST_NONE);
    }
    if (is_all && lane == 0u) {
        tree_works(push.work).at[job.number].root = clusters[0];
    }
    memoryBarrierBuffer();
    barrier();
}

merge_job load_job(uint number)
{
    clast_tree_job of = tree_jobs(push.jobs).at[number];
    clast_tree_work work = tree_works(push.work).at[number];
    vec3 size = vec3(0.0);
    for (uint axis = 0u; axis < 3u; axis++) {
        bool known = work.lower[axis] <= work.upper[axis];
        size[axis] = known ? ordered_float(work.upper[axis]) - ordered_float(work.lower[axis]) : 0.0;
    }
    return merge_job(load_address(of.boxes), of.first, number, box_scale(size));
}

void main()
{
    uint lane = gl_LocalInvocationIndex;
    uint item = linear_group() * LANES + lane;
    if (item - lane >= push.item_count) {
        return;
    }
    walk w = walk(item, item, item, item < push.item_count);
    uint first = 0u, last = 0u, number = 0u;
    if (w.goes_on) {
        number = job_of_item(item);
        first = tree_jobs(push.jobs).at[number].first;
        last = first + tree_jobs(push.jobs).at[number].count - 1u;
        uint cluster = CHILD_ITEM | (uints(push.order).at[item] - first);
        shared_slots(push.slots).at[item] = uvec2(cluster, item);
        memoryBarrierBuffer();
        if (first == last) {
            tree_works(push.work).at[number].root = cluster;
            w.goes_on = false;
        }
    }
    if (lane < 2u) {
        wanting[lane] = 0u;
        walking[lane] = 0u;
    }
    barrier();
    for (uint turn = 0u;; turn ^= 1u) {
        if (w.goes_on) {
            w = step_up(w, first, last);
        }
        bool is_all = w.goes_on && w.left == first && w.right == last;
        if (w.goes_on && (is_all || w.right - w.left >= FEW)) {
            lefts[lane] = w.left;
            rights[lane] = w.right;
            splits[lane] = w.split;
            jobs_of[lane] = is_all ? number | CHILD_ITEM : number;
            atomicOr(wanting[turn], 1u << lane);
        }
        w.goes_on = w.goes_on && !is_all;
        if (w.goes_on) {
            atomicOr(walking[turn], 1u << lane);
        }
        barrier();
        uint wants = wanting[turn], walks = walking[turn];
        if (lane == 0u) {
            wanting[turn ^ 1u] = 0u;
            walking[turn ^ 1u] = 0u;
        }
        for (; wants != 0u; wants &= wants - 1u) {
            uint of = findLSB(wants);
            merge_job job = load_job(jobs_of[of] & ~CHILD_ITEM);
            merge_range(lane, lefts[of], rights[of], splits[of], job, (jobs_of[of] & CHILD_ITEM) != 0u);
        }
        barrier();
        if (walks == 0u) {
            break;
        }
    }
}
