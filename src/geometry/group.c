// SPDX-License-Identifier: Apache-2.0
// The lower part of the clusterizer: a group of some hundred to two thousand triangles becomes clusters. Triangles are
// sorted once along each axis; every cut looks at the three orders and keeps them sorted (blocks.c). The cost of a side
// is its area times the number of clusters that it will need, rounded up: this alone makes most cuts leave full
// clusters. Another term keeps the cut from peeling small full-cost pieces off.
#include <math.h>

#include "geometry/blocks.h"
#include "geometry/cut.h"

enum {
    CORNERS_MOST = 3 * CUT_GROUP_MOST,
    DIGIT_BITS = 8,
    DIGITS = 1 << DIGIT_BITS,
    // A hash table for the vertices; where it is too small, they are sorted.
    TABLE_BITS = 12,
    TABLE_SIZE = 1 << TABLE_BITS,
    TABLE_MOST = TABLE_SIZE * 3 / 4,
    PROBES_A_CORNER = 8,
};
_Static_assert((uint32_t)CUT_GROUP_MOST == (uint32_t)BLOCKS_SORTED_MOST, "a group's triangles are sorted");

// Below this limit of triangles every place is looked at: an eighth of places would leave clusters that are not full.
#define EIGHTHS_LEAST 64
// Sweeps look at so many triangles for each triangle at most: it stands in some ten parts of a usual mesh. Where the
// cut takes a few triangles off at a time, which a mesh can be made for, the rest is halved.
#define LOOKS_A_TRIANGLE 64
// A group whose triangles have fewer corners of their own than this, in proportion to the limits, is never stopped by
// the limit of vertices; its sweeps need not count them.
#define VERTICES_MATTER 0.75f

typedef struct part {
    uint16_t begin, count;
} part;

struct group {
    SORTED_ROOM(CUT_GROUP_MOST) room;
    sorted_boxes sorted; // in it
    boxes_weights weights;
    uint32_t triangles[CUT_GROUP_MOST]; // as the mesh counts
    uint16_t corners[CORNERS_MOST];     // for each corner, its vertex within the group
    uint32_t vertices[CORNERS_MOST];    // as the mesh counts
    uint16_t right_vertices[CUT_GROUP_MOST + 1];
    uint64_t numbered[2][CORNERS_MOST];
    uint32_t table_keys[TABLE_SIZE]; // a vertex plus one; 0: none
    uint16_t table_values[TABLE_SIZE];
    uint32_t seen[CORNERS_MOST]; // for each vertex, the count that met it last
    uint8_t slot[CORNERS_MOST];
    uint16_t ordered[CUT_GROUP_MOST]; // a cluster's triangles, in the order of its blocks
    uint32_t tick;
    part stack[CUT_GROUP_MOST + 1];
    uint32_t stack_size;
    part clusters[CUT_GROUP_MOST];
    uint32_t cluster_count;
    uint32_t looks_left; // triangles that sweeps may still look at
    cut_limits limits;
    bool vertices_matter;
    uint32_t triangle_clusters[CUT_GROUP_MOST + 1]; // how many clusters so many triangles need
    uint32_t vertex_clusters[CORNERS_MOST + 1];
};

size_t clast_group_size(void)
{
    return sizeof(group);
}

// Cut a connected sheet in two, and the vertices along the cut count twice: a round piece of v vertices has about 4
// sqrt(v) along its rim, each shared by two pieces, so k full pieces hold k V = v + 2 k sqrt(V) - 2 sqrt(v) of them. A
// cut through a strip doubles two vertices: k V = v + 2 (k - 1). Of triangles that share nothing, a cluster leaves up
// to two vertices unused: the same. `sharing` is 1 for a sheet, 0 for the others.
static float own_vertices(uint32_t vertices, float sharing)
{
    return (float)vertices - 2.0f * (1.0f - sharing) - 2.0f * sharing * sqrtf((float)vertices);
}

// How many clusters a part of so many vertices needs.
static void fill_vertex_table(group *g, uint32_t count, uint32_t most, float sharing)
{
    float full = own_vertices(most, sharing);
    for (uint32_t i = 0; i < count; i++) {
        float pieces = ceilf(own_vertices(i, sharing) / (full > 1.0f ? full : 1.0f));
        g->vertex_clusters[i] = i <= most ? 1 : pieces <= 2.0f ? 2 : (uint32_t)pieces;
    }
}

// ----------------------------------------------------------------------------------------------------------- loading

// Boxes on a grid over the group, so that areas of tiny and of huge meshes are ordinary numbers.
static void load_boxes(group *g, const group_job *job, uint32_t begin, uint32_t count)
{
    const cut_box *boxes = job->boxes + begin;
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t i = 0; i < count; i++) {
        __builtin_prefetch(job->mesh_indices + 3 * (size_t)boxes[i].lower.number); // for the corners' numbers
        lower = lanes_min(lower, lanes_three(&boxes[i].lower));
        upper = lanes_max(upper, lanes_three(&boxes[i].upper));
    }
    lanes factor = lanes_all(STEP_BOX_STEPS * clast_cut_scale(lower, upper));
    for (uint32_t i = 0; i < count; i++) {
        g->triangles[i] = boxes[i].lower.number;
        g->sorted.box[i] = step_box_from(lanes_multiply(lanes_subtract(lanes_three(&boxes[i].lower), lower), factor),
                                         lanes_multiply(lanes_subtract(lanes_three(&boxes[i].upper), lower), factor));
    }
    clast_boxes_sort(&g->sorted, count);
}

// Gives each different vertex of the group a number, by a hash table, and says how many there are; 0 where the table is
// too small or a file made it slow.
static uint32_t hash_corners(group *g, const group_job *job, uint32_t count)
{
    memset(g->table_keys, 0, sizeof g->table_keys);
    uint32_t probes_left = PROBES_A_CORNER * 3 * count, different = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *corner = job->mesh_indices + 3 * (size_t)g->triangles[i];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t key = corner[k] + 1, slot = (key * 0x9e3779b1u) >> (32 - TABLE_BITS);
            while (g->table_keys[slot] != key) {
                if (g->table_keys[slot] == 0) {
                    if (different == TABLE_MOST) {
                        return 0;
                    }
                    g->table_keys[slot] = key;
                    g->table_values[slot] = (uint16_t)different;
                    g->vertices[different++] = corner[k];
                    break;
                }
                if (probes_left-- == 0) {
                    return 0;
                }
                slot = (slot + 1) & (TABLE_SIZE - 1);
            }
            g->corners[3 * i + k] = g->table_values[slot];
        }
    }
    return different;
}

// One stable pass of radix sort by the digit at `shift`.
static void sort_pass(const uint64_t *from, uint64_t *to, uint32_t count, uint32_t shift)
{
    uint32_t places[DIGITS] = {0};
    for (uint32_t i = 0; i < count; i++) {
        places[from[i] >> shift & (DIGITS - 1)]++;
    }
    for (uint32_t digit = 0, sum = 0; digit < DIGITS; digit++) {
        uint32_t here = places[digit];
        places[digit] = sum;
        sum += here;
    }
    for (uint32_t i = 0; i < count; i++) {
        to[places[from[i] >> shift & (DIGITS - 1)]++] = from[i];
    }
}

// The same by sorting.
static uint32_t sort_corners(group *g, const group_job *job, uint32_t count)
{
    uint32_t lowest = UINT32_MAX, highest = 0;
    uint64_t *from = g->numbered[0], *to = g->numbered[1];
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *corner = job->mesh_indices + 3 * (size_t)g->triangles[i];
        for (uint32_t k = 0; k < 3; k++) {
            lowest = corner[k] < lowest ? corner[k] : lowest;
            highest = corner[k] > highest ? corner[k] : highest;
            from[3 * i + k] = (uint64_t)corner[k] << 16 | (3 * i + k);
        }
    }
    uint32_t differing = lowest ^ highest; // digits above the highest differing bit are equal for all
    for (uint32_t shift = 0; shift < 32 && differing >> shift != 0; shift += DIGIT_BITS) {
        sort_pass(from, to, 3 * count, 16 + shift);
        uint64_t *other = from;
        from = to;
        to = other;
    }
    uint32_t vertex = 0;
    for (uint32_t i = 0; i < 3 * count; i++) {
        vertex += i != 0 && from[i] >> 16 != from[i - 1] >> 16;
        g->vertices[vertex] = (uint32_t)(from[i] >> 16);
        g->corners[from[i] & 0xffff] = (uint16_t)vertex;
    }
    return vertex + 1;
}

// ---------------------------------------------------------------------------------------------------------- counting

static uint32_t next_tick(group *g)
{
    if (++g->tick == 0) { // once in 2^32 counts
        memset(g->seen, 0, sizeof g->seen);
        g->tick = 1;
    }
    return g->tick;
}

// How many of a triangle's vertices this count has not met yet.
static inline uint32_t meet(group *g, uint32_t triangle, uint32_t tick)
{
    uint32_t fresh = 0;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t vertex = g->corners[3 * triangle + k];
        fresh += g->seen[vertex] != tick;
        g->seen[vertex] = tick;
    }
    return fresh;
}

static uint32_t count_vertices(group *g, uint32_t begin, uint32_t count)
{
    uint32_t tick = next_tick(g), vertices = 0;
    for (uint32_t i = begin; i < begin + count; i++) {
        vertices += meet(g, g->sorted.order[0][i], tick);
    }
    return vertices;
}

// ----------------------------------------------------------------------------------------------------------- cutting

static inline uint32_t clusters_for(const group *g, uint32_t triangles, uint32_t vertices)
{
    uint32_t by_triangles = g->triangle_clusters[triangles], by_vertices = g->vertex_clusters[vertices];
    return by_triangles > by_vertices ? by_triangles : by_vertices;
}

// What a cluster more than needed costs: half the area that is cut.
static uint64_t extra_of(const group *g, const part *p)
{
    step_box whole = step_box_none();
    for (uint32_t i = p->begin; i < (uint32_t)p->begin + p->count; i++) {
        whole = step_box_join(whole, g->sorted.box[g->sorted.order[0][i]]);
    }
    return step_box_area(whole) / 2;
}

// Looks at all places of one axis' order, where vertices may be what fills a cluster.
static void sweep_counting(group *g, const part *p, uint32_t axis, uint64_t extra, boxes_cut *best)
{
    sorted_boxes *b = &g->sorted;
    const uint16_t *order = b->order[axis] + p->begin;
    step_box box = step_box_none();
    uint32_t tick = next_tick(g), vertices = 0;
    for (uint32_t i = p->count; i-- > 1;) {
        box = step_box_join(box, b->box[order[i]]);
        vertices += meet(g, order[i], tick);
        b->right_area[i] = step_box_area(box);
        g->right_vertices[i] = (uint16_t)vertices;
    }
    box = step_box_none();
    tick = next_tick(g);
    vertices = 0;
    for (uint32_t i = 1; i < p->count; i++) {
        box = step_box_join(box, b->box[order[i - 1]]);
        vertices += meet(g, order[i - 1], tick);
        uint64_t left = clusters_for(g, i, vertices), right = clusters_for(g, p->count - i, g->right_vertices[i]);
        uint64_t cost = step_box_area(box) * left + b->right_area[i] * right + extra * (left + right);
        if (cost < best->cost) {
            *best = (boxes_cut){.cost = cost, .axis = axis, .left = i};
        }
    }
}

static void weigh(group *g, uint32_t count)
{
    uint32_t pieces = (count + BLOCKS_PIECE - 1) / BLOCKS_PIECE;
    for (uint32_t k = 1; k < pieces; k++) {
        g->weights.left[k] = g->triangle_clusters[BLOCKS_PIECE * k];
        g->weights.right[k] = g->triangle_clusters[count - BLOCKS_PIECE * k];
    }
}

// Looks at the places next to one that a sweep found.
static void refine(group *g, const part *p, boxes_cut *best)
{
    sorted_boxes *b = &g->sorted;
    const uint16_t *order = b->order[best->axis] + p->begin;
    uint32_t begin = best->left - BLOCKS_PIECE, end = best->left + BLOCKS_PIECE;
    end = end < p->count ? end : p->count;
    step_box box = best->far_right;
    for (uint32_t i = end; i-- > begin + 1;) {
        box = step_box_join(box, b->box[order[i]]);
        b->right_area[i - begin] = step_box_area(box);
    }
    box = best->far_left;
    for (uint32_t i = begin + 1; i < end; i++) {
        box = step_box_join(box, b->box[order[i - 1]]);
        uint64_t left = g->triangle_clusters[i], right = g->triangle_clusters[p->count - i];
        uint64_t cost = step_box_area(box) * left + b->right_area[i - begin] * right + best->extra * (left + right);
        if (cost < best->cost) {
            best->cost = cost;
            best->left = i;
        }
    }
}

static void cut_part(group *g, const part *p, bool counting)
{
    boxes_cut best = {.cost = UINT64_MAX};
    if (g->looks_left >= p->count) {
        g->looks_left -= p->count;
        bool eighths = !counting && p->count > BLOCKS_PIECE && g->limits.triangles >= EIGHTHS_LEAST;
        uint64_t extra = eighths ? 0 : extra_of(g, p);
        if (eighths) {
            weigh(g, p->count);
        }
        for (uint32_t axis = 0; axis < 3; axis++) {
            if (eighths) {
                clast_boxes_sweep(&g->sorted, axis, p->begin, p->count, BLOCKS_PIECE, &g->weights, true, &best);
            } else {
                sweep_counting(g, p, axis, extra, &best);
            }
        }
        if (eighths) {
            refine(g, p, &best);
        }
    }
    if (best.left == 0) { // too many looks
        best.left = p->count / 2;
    }
    clast_boxes_part(&g->sorted, p->begin, p->count, &best, false);
    uint16_t middle = (uint16_t)(p->begin + best.left);
    g->stack[g->stack_size++] = (part){middle, (uint16_t)(p->count - best.left)};
    g->stack[g->stack_size++] = (part){p->begin, (uint16_t)best.left};
}

// Cuts until the limits hold; clusters come in the order of the cut.
static void cut_clusters(group *g, uint32_t count)
{
    g->cluster_count = 0;
    g->looks_left = LOOKS_A_TRIANGLE * count;
    g->stack_size = 0;
    g->stack[g->stack_size++] = (part){0, (uint16_t)count};
    while (g->stack_size != 0) {
        part p = g->stack[--g->stack_size];
        bool few = p.count <= g->limits.triangles;
        if (few && count_vertices(g, p.begin, p.count) <= g->limits.vertices) {
            g->clusters[g->cluster_count++] = p;
        } else {
            cut_part(g, &p, few || g->vertices_matter);
        }
    }
}

// ---------------------------------------------------------------------------------------------------------- joining

// Makes one sorted run of two that follow each other.
static void merge_runs(group *g, uint32_t axis, uint32_t begin, uint32_t middle, uint32_t end)
{
    uint16_t *order = g->sorted.order[axis];
    const uint16_t *keys = g->sorted.key[axis];
    uint32_t left = begin, right = middle;
    for (uint32_t i = 0; i < end - begin; i++) {
        bool from_left = right == end || (left < middle && keys[order[left]] <= keys[order[right]]);
        g->sorted.kept[i] = order[from_left ? left++ : right++];
    }
    memcpy(order + begin, g->sorted.kept, (end - begin) * sizeof *order);
}

// Joins `next` to `last` where the limits allow it and it costs no more than keeping them apart.
static bool join(group *g, part *last, const part *next)
{
    part both = {last->begin, (uint16_t)(last->count + next->count)};
    if (both.count > g->limits.triangles || count_vertices(g, both.begin, both.count) > g->limits.vertices ||
        extra_of(g, &both) > 2 * (extra_of(g, last) + extra_of(g, next))) {
        return false;
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        merge_runs(g, axis, both.begin, next->begin, (uint32_t)both.begin + both.count);
    }
    *last = both;
    return true;
}

// A cut foresees only roughly how many clusters its sides will need: neighbours may be left that fit into one.
static void join_neighbours(group *g)
{
    uint32_t kept = 0;
    for (uint32_t i = 1; i < g->cluster_count; i++) {
        if (!join(g, &g->clusters[kept], &g->clusters[i])) {
            g->clusters[++kept] = g->clusters[i];
        }
    }
    g->cluster_count = kept + 1;
}

// ----------------------------------------------------------------------------------------------------------- writing

// Writes a cluster's triangles from place `begin` of the mesh on, and its vertices where there is room. Vertices are
// numbered in the order of first use.
static void write_cluster(group *g, const group_job *job, uint32_t begin, const part *cluster, group_output *output)
{
    uint32_t tick = next_tick(g), vertices = 0;
    uint32_t used[256];
    clast_boxes_order_blocks(&g->sorted, cluster->begin, cluster->count, g->ordered);
    uint32_t *triangles = job->triangles + begin + cluster->begin;
    uint8_t *indices = job->indices + 3 * ((size_t)begin + cluster->begin);
    for (uint32_t i = 0; i < cluster->count; i++) {
        uint32_t triangle = g->ordered[i];
        triangles[i] = g->triangles[triangle];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t vertex = g->corners[3 * triangle + k];
            if (g->seen[vertex] != tick) {
                g->seen[vertex] = tick;
                g->slot[vertex] = (uint8_t)vertices;
                used[vertices++] = g->vertices[vertex];
            }
            indices[3 * (size_t)i + k] = g->slot[vertex];
        }
    }
    output->triangles_left -= cluster->count;
    output->clusters++;
    output->words[output->word_count - output->clusters] = (uint32_t)cluster->count << 16 | vertices;
    // Each triangle that is left may become a cluster, which needs a word.
    output->vertices_fit = output->vertices_fit &&
                           output->vertices + vertices + output->clusters + output->triangles_left <=
                               output->word_count;
    if (output->vertices_fit) {
        memcpy(output->words + output->vertices, used, vertices * sizeof used[0]);
    }
    output->vertices += vertices;
}

void clast_group_begin(group *g, const cut_limits *limits)
{
    g->sorted = (sorted_boxes)SORTED_IN(&g->room);
    g->limits = *limits;
    g->tick = 0;
    memset(g->seen, 0, sizeof g->seen);
    for (uint32_t i = 0; i <= CUT_GROUP_MOST; i++) {
        g->triangle_clusters[i] = (i + limits->triangles - 1) / limits->triangles;
    }
}

void clast_group_cut(group *g, const group_job *job, const cut_range *range, group_output *output)
{
    uint32_t count = range->triangles;
    load_boxes(g, job, range->begin, count);
    uint32_t different = hash_corners(g, job, count);
    different = different != 0 ? different : sort_corners(g, job, count);
    g->vertices_matter = (float)different * (float)g->limits.triangles >
                         VERTICES_MATTER * (float)count * (float)g->limits.vertices;
    float sharing = ((float)count / (float)different - 1.0f) / 0.9f;
    fill_vertex_table(g, different + 1, g->limits.vertices, sharing < 0.0f ? 0.0f : sharing > 1.0f ? 1.0f : sharing);
    cut_clusters(g, count);
    join_neighbours(g);
    for (uint32_t i = 0; i < g->cluster_count; i++) {
        write_cluster(g, job, range->first, &g->clusters[i], output);
    }
}
