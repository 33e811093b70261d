// SPDX-License-Identifier: Apache-2.0
// From pairs to nodes of eight, as their costs tell (Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs, HPG 2017, section 3). A node has the number of its pair, so that numbers do not depend on timing; the
// root, which no pair has, is 0.
//
// First a group for each tree takes nodes from the top, until there are many under them, and puts these into a queue. Then groups
// finish what is in the queue, the lowest first: so what waits never takes much room.
#version 460
#extension GL_GOOGLE_include_directive : require
#define GROUP_SIZE 256u
#include "gpu.glsl"
#include "accel/node.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;

const uint MANY = 512u;
const uint DEPTH_SHIFT = TREE_ITEMS_BITS;
const uint NUMBER_MASK = (1u << TREE_ITEMS_BITS) - 1u;
// Of each level, what a step adds.
const uint ROOM = TREE_LEVELS * TEAMS * TREE_CHILDREN;

shared uint waiting[ROOM]; // pairs that become nodes, each with its level
shared uint wait_end;
shared uint queue_first;

ARRAY_OF(tree_pairs, clast_tree_pair, 16)

struct widen_job {
    uint64_t boxes, items, nodes, bounds, kept, pairs;
    uint number, count;
};

widen_job load_job(uint number)
{
    tree_jobs jobs = tree_jobs(push.jobs);
    widen_job job;
    job.boxes = load_address(jobs.at[number].boxes);
    job.items = load_address(jobs.at[number].items);
    job.nodes = load_address(jobs.at[number].nodes);
    job.bounds = load_address(jobs.at[number].bounds);
    job.kept = load_address(jobs.at[number].kept);
    job.pairs = push.pairs + 64ul * jobs.at[number].first;
    job.number = number;
    job.count = jobs.at[number].count;
    return job;
}

// The child at a place of the node that stands for a pair, or CLAST_NONE: an item or a pair. A part of n children has n
// places: its left half the first of them, its right half the next.
uint find_child(widen_job job, uint cluster, uint place)
{
    uint first = 0u, children = TREE_CHILDREN;
    bool opens = true;
    while ((cluster & CHILD_ITEM) == 0u) {
        tree_pairs pairs = tree_pairs(job.pairs);
        uint shares = pairs.at[cluster].shares;
        while (children > 1u && share_of(shares, children) == 0u) {
            children--;
        }
        if (place >= first + children || (children == 1u && !opens)) {
            break;
        }
        opens = false;
        uint share = share_of(shares, children);
        bool is_left = place < first + share;
        cluster = is_left ? pairs.at[cluster].left : pairs.at[cluster].right;
        first += is_left ? 0u : share;
        children = is_left ? share : children - share;
    }
    return place == first ? cluster : CLAST_NONE;
}

team_child load_child(widen_job job, uint cluster)
{
    team_child child;
    child.there = cluster != CLAST_NONE;
    child.child = cluster;
    child.box.lower = vec3(uintBitsToFloat(TREE_BEYOND_BITS));
    child.box.upper = -child.box.lower;
    if (child.there && (cluster & CHILD_ITEM) != 0u) {
        uint item = cluster & ~CHILD_ITEM;
        child.child = item_child(job.items, item);
        child.box = load_item_box(job.boxes, item);
    } else if (child.there) {
        tree_pairs pairs = tree_pairs(job.pairs);
        child.box.lower = pairs.at[cluster].lower;
        child.box.upper = pairs.at[cluster].upper;
    }
    return child;
}

// What a pair that waits is told as.
uint entry_of(uint number, uint level) { return number | level << DEPTH_SHIFT; }

// Notes what fitting the tree anew needs. Where a node has no nodes below, fitting begins.
void keep(widen_job job, uint number, uint below, clast_box box, bool is_root)
{
    uint lane = team_lane(), place = lane % TEAM;
    bool is_node = below != CLAST_NONE && (below & CHILD_ITEM) == 0u;
    float nodes_below = is_node ? 1.0 : 0.0;
    for (uint mask = 1u; mask < TEAM; mask <<= 1u) {
        nodes_below += team_xor(nodes_below, mask);
    }
    if (number == CLAST_NONE) {
        return;
    }
    kept_nodes nodes = kept_nodes(kept_nodes_at(job.kept));
    nodes.at[number].children[place] = below;
    if (is_node) {
        nodes.at[below].parent = number;
    }
    if (place == 0u) {
        nodes.at[number].box = box;
        nodes.at[number].arrivals = 0u;
        if (is_root) {
            nodes.at[number].parent = CLAST_NONE;
        }
        if (nodes_below == 0.0) {
            uint at = atomicAdd(kept_head(job.kept).of.bottoms, 1u);
            uints(kept_bottoms_at(job.kept)).at[at] = number;
        }
    }
}

// Makes a node of an entry of each team, where it has one, and lets its children wait.
void widen(widen_job job, bool there, uint entry, bool is_root)
{
    uint place = team_lane() % TEAM, level = entry >> DEPTH_SHIFT;
    uint cluster = is_root ? tree_works(push.work).at[job.number].root : entry & NUMBER_MASK;
    uint number = is_root ? 0u : entry & NUMBER_MASK;
    uint below = there ? find_child(job, cluster, place) : CLAST_NONE;
    clast_box box = write_node(load_child(job, below), there ? job.nodes + NODE_BYTES * number : 0ul);
    if (job.kept != 0ul) {
        keep(job, there ? number : CLAST_NONE, below, box, is_root);
    }
    if (below != CLAST_NONE && (below & CHILD_ITEM) == 0u) {
        if (level + 1u < TREE_LEVELS) {
            waiting[atomicAdd(wait_end, 1u)] = entry_of(below, level + 1u);
        } else {
            tree_works(push.work).at[job.number].is_deep = 1u;
        }
    }
    if (is_root && there && place == 0u && job.bounds != 0ul) {
        boxes(job.bounds).at[0] = box;
    }
    barrier();
}

// From the first on, so that what waits in the end is alike.
void widen_top(widen_job job)
{
    uint lane = team_lane(), team = lane / TEAM;
    if (lane == 0u) {
        wait_end = 0u;
    }
    barrier();
    widen(job, team == 0u, 0u, team == 0u);
    uint begin = 0u, end = wait_end;
    while (begin != end && end - begin < MANY && end + TEAMS * TEAM <= ROOM) {
        bool there = begin + team < end;
        uint entry = there ? waiting[begin + team] : 0u;
        barrier();
        widen(job, there, entry, false);
        begin = min(begin + TEAMS, end);
        end = wait_end;
        barrier();
    }
    if (begin == end) {
        return;
    }
    if (lane == 0u) {
        queue_first = atomicAdd(tree_works(push.work).at[push.job_count].root, end - begin);
    }
    barrier();
    uints queue = uints(push.queue);
    for (uint i = begin + lane; i < end; i += GROUP_SIZE) {
        queue.at[2u * (queue_first + i - begin)] = waiting[i];
        queue.at[2u * (queue_first + i - begin) + 1u] = job.number;
    }
}

// From the last on: what waits is of few levels.
void widen_rest(widen_job job, uint entry)
{
    uint lane = team_lane(), team = lane / TEAM;
    barrier();
    if (lane == 0u) {
        waiting[0] = entry;
        wait_end = 1u;
    }
    barrier();
    for (uint end = 1u; end != 0u;) {
        uint taken = min(end, TEAMS);
        bool there = team < taken;
        uint own = there ? waiting[end - taken + team] : 0u;
        barrier();
        if (lane == 0u) {
            wait_end = end - taken;
        }
        barrier();
        widen(job, there, own, false);
        end = wait_end;
        barrier();
    }
}

void main()
{
    uint group = linear_group();
    if (group >= push.group_count) {
        return;
    }
    if (push.phase == 0u) {
        widen_job job = load_job(group);
        if (job.count > 0u) {
            widen_top(job);
        } else if (job.bounds != 0ul && team_lane() == 0u) {
            clast_box none;
            none.lower = vec3(uintBitsToFloat(TREE_BEYOND_BITS));
            none.upper = -none.lower;
            boxes(job.bounds).at[0] = none;
        }
        return;
    }
    uints queue = uints(push.queue);
    uint count = tree_works(push.work).at[push.job_count].root;
    for (uint i = group; i < count; i += push.group_count) {
        widen_job job = load_job(queue.at[2u * i + 1u]);
        widen_rest(job, queue.at[2u * i]);
    }
}
