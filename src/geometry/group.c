// SPDX-License-Identifier: Apache-2.0
// The lower part of the clusterizer: a group of some hundred to two thousand triangles becomes clusters. Triangles are
// sorted once along each axis; every cut looks at all places of the three orders (exact sweeps, as in the split builder of
// Stich et al. 2009 without splits) and keeps the orders sorted. The cost of a side is its area times the number of
// clusters that it will need, rounded up: this alone makes most cuts leave full clusters. Another term keeps the cut from
// peeling small full-cost pieces off.
#include <math.h>

#include "geometry/cut.h"

enum {
    CORNERS_MOST = 3 * CUT_GROUP_MOST,
    BLOCK = 8, // triangles that a leaf of a cluster's own tree holds
    DIGIT_BITS = 8,
    DIGITS = 1 << DIGIT_BITS,
};

// Sweeps look at so many places for each triangle at most: a triangle stands in some ten parts of a usual mesh. Where the cut
// takes a few triangles off at a time, which a mesh can be made for, the rest is halved.
#define LOOKS_A_TRIANGLE 64
// How much a cluster more than needed costs, in areas of the box that is cut.
#define EXTRA_CLUSTER 0.5f
// Boxes count as wider by this, in sides of the group, so that those of flat, thin and equal triangles have areas to compare.
#define PADDING 1e-4f
// A group whose triangles have fewer corners of their own than this, in proportion to the limits, is never stopped by the
// limit of vertices; its sweeps need not count them.
#define VERTICES_MATTER 0.75f

typedef struct part {
    uint16_t begin, count;
    bool inside; // of a cluster: cut further only for the order of its triangles
} part;

struct group {
    lanes lower[CUT_GROUP_MOST], upper[CUT_GROUP_MOST];
    float right_area[CUT_GROUP_MOST + 1];
    uint16_t right_vertices[CUT_GROUP_MOST + 1];
    uint16_t keys[3][CUT_GROUP_MOST];  // centres along each axis
    uint16_t order[3][CUT_GROUP_MOST]; // triangles, sorted by them
    uint16_t kept[CUT_GROUP_MOST];
    bool goes_left[CUT_GROUP_MOST];
    uint32_t sorted[2][CUT_GROUP_MOST];
    uint16_t corners[CORNERS_MOST]; // for each corner, its vertex within the group
    uint64_t numbered[2][CORNERS_MOST];
    uint32_t seen[CORNERS_MOST]; // for each vertex, the count that met it last
    uint8_t slot[CORNERS_MOST];
    uint32_t tick;
    part stack[CUT_GROUP_MOST + 1];
    uint32_t stack_size;
    part clusters[CUT_GROUP_MOST];
    uint32_t cluster_count;
    uint32_t looks_left; // places that sweeps may still look at
    cut_limits limits;
    bool vertices_matter;
    float triangle_clusters[CUT_GROUP_MOST + 1]; // how many clusters so many triangles need
    float vertex_clusters[CORNERS_MOST + 1];
    cut_limits table_limits; // of those two
};

size_t clast_group_size(void)
{
    return sizeof(group);
}

static void fill_table(float *table, uint32_t count, uint32_t most)
{
    for (uint32_t i = 0; i < count; i++) {
        table[i] = (float)((i + most - 1) / most);
    }
}

// Cut a connected sheet in two, and the vertices along the cut count twice: a round piece of v vertices has about 4 sqrt(v)
// along its rim, each shared by two pieces, so k full pieces hold k V = v + 2 k sqrt(V) - 2 sqrt(v) of them. A cut through a
// strip doubles two vertices: k V = v + 2 (k - 1). Of triangles that share nothing, a cluster leaves up to two vertices
// unused: the same. `sharing` is 1 for a sheet, 0 for the others.
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
        g->vertex_clusters[i] = i <= most ? 1.0f : pieces <= 2.0f ? 2.0f : pieces;
    }
}

// ----------------------------------------------------------------------------------------------------------- loading

// One stable pass of radix sort by the digit at `shift`.
static void sort_pass(const uint32_t *from, uint32_t *to, uint32_t count, uint32_t shift)
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

static void sort_axis(group *g, int axis, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        g->sorted[0][i] = (uint32_t)g->keys[axis][i] << 16 | i;
    }
    sort_pass(g->sorted[0], g->sorted[1], count, 16);
    sort_pass(g->sorted[1], g->sorted[0], count, 24);
    for (uint32_t i = 0; i < count; i++) {
        g->order[axis][i] = (uint16_t)g->sorted[0][i];
    }
}

// Boxes are scaled to the group's size, so that areas of tiny and of huge meshes are ordinary numbers.
static void load_boxes(group *g, const cut_box *boxes, uint32_t count)
{
    lanes lower = box_none_lower(), upper = box_none_upper();
    cut_range range = {0, count, lower, upper};
    clast_cut_measure(boxes, &range);
    for (uint32_t i = 0; i < count; i++) {
        lower = lanes_min(lower, lanes_three(&boxes[i].lower));
        upper = lanes_max(upper, lanes_three(&boxes[i].upper));
    }
    lanes factor = lanes_all(clast_cut_scale(lower, upper));
    float sides[4], scale[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    lanes_store(sides, lanes_subtract(range.centre_upper, range.centre_lower));
    for (int axis = 0; axis < 3; axis++) {
        scale[axis] = sides[axis] > CUT_FLAT ? 65535.0f / sides[axis] : 0.0f;
    }
    lanes key_factor = lanes_load(scale);
    for (uint32_t i = 0; i < count; i++) {
        int32_t keys[4];
        lanes_truncate(keys, lanes_multiply(lanes_subtract(cut_centre(&boxes[i]), range.centre_lower), key_factor));
        for (int axis = 0; axis < 3; axis++) {
            g->keys[axis][i] = (uint16_t)(keys[axis] < 65535 ? keys[axis] : 65535);
        }
        g->lower[i] = lanes_multiply(lanes_subtract(lanes_three(&boxes[i].lower), lower), factor);
        g->upper[i] = lanes_multiply(lanes_subtract(lanes_three(&boxes[i].upper), lower), factor);
    }
    for (int axis = 0; axis < 3; axis++) {
        sort_axis(g, axis, count);
    }
}

static void number_pass(const uint64_t *from, uint64_t *to, uint32_t count, uint32_t shift)
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

// Gives each different vertex of the group a number, and says how many there are. By sorting: a hash table could be made
// slow by a file.
static uint32_t number_corners(group *g, const group_job *job, uint32_t begin, uint32_t count)
{
    uint32_t lowest = UINT32_MAX, highest = 0;
    uint64_t *from = g->numbered[0], *to = g->numbered[1];
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *corner = job->mesh_indices + 3 * (size_t)job->boxes[begin + i].lower.number;
        for (uint32_t k = 0; k < 3; k++) {
            lowest = corner[k] < lowest ? corner[k] : lowest;
            highest = corner[k] > highest ? corner[k] : highest;
            from[3 * i + k] = (uint64_t)corner[k] << 16 | (3 * i + k);
        }
    }
    uint32_t differing = lowest ^ highest; // digits above the highest differing bit are equal for all
    for (uint32_t shift = 0; shift < 32 && differing >> shift != 0; shift += DIGIT_BITS) {
        number_pass(from, to, 3 * count, 16 + shift);
        uint64_t *other = from;
        from = to;
        to = other;
    }
    uint32_t vertex = 0;
    for (uint32_t i = 0; i < 3 * count; i++) {
        vertex += i != 0 && from[i] >> 16 != from[i - 1] >> 16;
        g->corners[from[i] & 0xffff] = (uint16_t)vertex;
    }
    return vertex + 1;
}

static inline float area_between(lanes lower, lanes upper)
{
    return box_half_area(lower, lanes_add(upper, lanes_all(PADDING)));
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
        vertices += meet(g, g->order[0][i], tick);
    }
    return vertices;
}

// ----------------------------------------------------------------------------------------------------------- cutting

typedef struct best_cut {
    float cost;
    uint32_t axis, left; // left: triangles; 0 where none was found
} best_cut;

static inline float clusters_for(const group *g, uint32_t triangles, uint32_t vertices)
{
    float by_triangles = g->triangle_clusters[triangles], by_vertices = g->vertex_clusters[vertices];
    return by_triangles > by_vertices ? by_triangles : by_vertices;
}

// Looks at all places of one axis' order.
static void sweep(group *g, const part *p, uint32_t axis, best_cut *best)
{
    const uint16_t *order = g->order[axis] + p->begin;
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t i = p->count; i-- > 1;) {
        lower = lanes_min(lower, g->lower[order[i]]);
        upper = lanes_max(upper, g->upper[order[i]]);
        g->right_area[i] = area_between(lower, upper);
    }
    float whole = area_between(lanes_min(lower, g->lower[order[0]]), lanes_max(upper, g->upper[order[0]])) *
                  EXTRA_CLUSTER;
    lower = box_none_lower();
    upper = box_none_upper();
    const float *clusters = g->triangle_clusters;
    for (uint32_t i = 1; i < p->count; i++) {
        lower = lanes_min(lower, g->lower[order[i - 1]]);
        upper = lanes_max(upper, g->upper[order[i - 1]]);
        float left = clusters[i], right = clusters[p->count - i];
        float cost = area_between(lower, upper) * left + g->right_area[i] * right + whole * (left + right);
        if (cost < best->cost) {
            *best = (best_cut){cost, axis, i};
        }
    }
}

// The same where vertices may be what fills a cluster.
static void sweep_counting(group *g, const part *p, uint32_t axis, best_cut *best)
{
    const uint16_t *order = g->order[axis] + p->begin;
    lanes lower = box_none_lower(), upper = box_none_upper();
    uint32_t tick = next_tick(g), vertices = 0;
    for (uint32_t i = p->count; i-- > 1;) {
        lower = lanes_min(lower, g->lower[order[i]]);
        upper = lanes_max(upper, g->upper[order[i]]);
        vertices += meet(g, order[i], tick);
        g->right_area[i] = area_between(lower, upper);
        g->right_vertices[i] = (uint16_t)vertices;
    }
    float whole = area_between(lanes_min(lower, g->lower[order[0]]), lanes_max(upper, g->upper[order[0]])) *
                  EXTRA_CLUSTER;
    lower = box_none_lower();
    upper = box_none_upper();
    tick = next_tick(g);
    vertices = 0;
    for (uint32_t i = 1; i < p->count; i++) {
        lower = lanes_min(lower, g->lower[order[i - 1]]);
        upper = lanes_max(upper, g->upper[order[i - 1]]);
        vertices += meet(g, order[i - 1], tick);
        float left = clusters_for(g, i, vertices), right = clusters_for(g, p->count - i, g->right_vertices[i]);
        float cost = area_between(lower, upper) * left + g->right_area[i] * right + whole * (left + right);
        if (cost < best->cost) {
            *best = (best_cut){cost, axis, i};
        }
    }
}

// Inside a cluster: only cuts that leave whole blocks on the left.
static void sweep_blocks(group *g, const part *p, uint32_t axis, best_cut *best)
{
    const uint16_t *order = g->order[axis] + p->begin;
    lanes lower = box_none_lower(), upper = box_none_upper();
    uint32_t last = (p->count - 1) / BLOCK * BLOCK;
    for (uint32_t i = p->count; i-- > BLOCK;) {
        lower = lanes_min(lower, g->lower[order[i]]);
        upper = lanes_max(upper, g->upper[order[i]]);
        if (i % BLOCK == 0) {
            g->right_area[i] = area_between(lower, upper);
        }
    }
    lower = box_none_lower();
    upper = box_none_upper();
    for (uint32_t i = 1; i <= last; i++) {
        lower = lanes_min(lower, g->lower[order[i - 1]]);
        upper = lanes_max(upper, g->upper[order[i - 1]]);
        if (i % BLOCK == 0) {
            float cost = area_between(lower, upper) * (float)i + g->right_area[i] * (float)(p->count - i);
            if (cost < best->cost) {
                *best = (best_cut){cost, axis, i};
            }
        }
    }
}

// Brings the triangles of the left side to the front of the two orders that were not cut, keeping their order.
static void part_orders(group *g, const part *p, const best_cut *cut)
{
    const uint16_t *chosen = g->order[cut->axis] + p->begin;
    for (uint32_t i = 0; i < p->count; i++) {
        g->goes_left[chosen[i]] = i < cut->left;
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        if (axis == cut->axis) {
            continue;
        }
        uint16_t *order = g->order[axis] + p->begin;
        uint32_t left = 0, right = 0;
        for (uint32_t i = 0; i < p->count; i++) { // both are written, one counts: which one is hard to foresee
            uint16_t triangle = order[i];
            bool goes_left = g->goes_left[triangle];
            order[left] = triangle;
            g->kept[right] = triangle;
            left += goes_left;
            right += !goes_left;
        }
        memcpy(order + left, g->kept, right * sizeof *order);
    }
}

static void cut_part(group *g, const part *p, bool counting)
{
    best_cut best = {INFINITY, 0, 0};
    bool looks = p->inside || g->looks_left >= p->count;
    g->looks_left -= looks && !p->inside ? p->count : 0;
    for (uint32_t axis = 0; axis < 3 && looks; axis++) {
        if (p->inside) {
            sweep_blocks(g, p, axis, &best);
        } else if (counting) {
            sweep_counting(g, p, axis, &best);
        } else {
            sweep(g, p, axis, &best);
        }
    }
    if (best.left == 0) { // too many looks, or no cost was a number below infinity
        best.left = p->inside ? BLOCK : p->count / 2;
    }
    part_orders(g, p, &best);
    uint16_t middle = (uint16_t)(p->begin + best.left);
    g->stack[g->stack_size++] = (part){middle, (uint16_t)(p->count - best.left), p->inside};
    g->stack[g->stack_size++] = (part){p->begin, (uint16_t)best.left, p->inside};
}

// Cuts until the limits hold; clusters come in the order of the cut.
static void cut_clusters(group *g, uint32_t count)
{
    g->cluster_count = 0;
    g->looks_left = LOOKS_A_TRIANGLE * count;
    g->stack_size = 0;
    g->stack[g->stack_size++] = (part){0, (uint16_t)count, false};
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

static float area_of(const group *g, const part *p)
{
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t i = p->begin; i < (uint32_t)p->begin + p->count; i++) {
        lower = lanes_min(lower, g->lower[g->order[0][i]]);
        upper = lanes_max(upper, g->upper[g->order[0][i]]);
    }
    return area_between(lower, upper);
}

// Makes one sorted run of two that follow each other.
static void merge_runs(group *g, uint32_t axis, uint32_t begin, uint32_t middle, uint32_t end)
{
    uint16_t *order = g->order[axis];
    const uint16_t *keys = g->keys[axis];
    uint32_t left = begin, right = middle;
    for (uint32_t i = 0; i < end - begin; i++) {
        bool from_left = right == end || (left < middle && keys[order[left]] <= keys[order[right]]);
        g->kept[i] = order[from_left ? left++ : right++];
    }
    memcpy(order + begin, g->kept, (end - begin) * sizeof *order);
}

// Joins `next` to `last` where the limits allow it and it costs no more than keeping them apart.
static bool join(group *g, part *last, const part *next)
{
    part both = {last->begin, (uint16_t)(last->count + next->count), false};
    if (both.count > g->limits.triangles || count_vertices(g, both.begin, both.count) > g->limits.vertices ||
        area_of(g, &both) * (1.0f - EXTRA_CLUSTER) > area_of(g, last) + area_of(g, next)) {
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

// Orders a cluster's triangles so that each block of them is compact.
static void order_blocks(group *g, const part *cluster)
{
    g->stack_size = 0;
    g->stack[g->stack_size++] = (part){cluster->begin, cluster->count, true};
    while (g->stack_size != 0) {
        part p = g->stack[--g->stack_size];
        if (p.count > BLOCK) {
            cut_part(g, &p, false);
        }
    }
}

// ----------------------------------------------------------------------------------------------------------- writing

// Writes a cluster's triangles from place `begin` of the mesh on. Vertices are numbered in the order of first use.
static uint32_t write_cluster(group *g, const group_job *job, uint32_t begin, const part *cluster,
                              const uint32_t *numbers)
{
    uint32_t tick = next_tick(g), vertices = 0;
    for (uint32_t i = 0; i < cluster->count; i++) {
        uint32_t triangle = g->order[0][cluster->begin + i];
        size_t place = (size_t)begin + cluster->begin + i;
        job->triangles[place] = numbers[triangle];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t vertex = g->corners[3 * triangle + k];
            if (g->seen[vertex] != tick) {
                g->seen[vertex] = tick;
                g->slot[vertex] = (uint8_t)vertices++;
            }
            job->indices[3 * place + k] = g->slot[vertex];
        }
    }
    return vertices;
}

static void prepare(group *g, const cut_limits *limits)
{
    g->limits = *limits;
    if (g->table_limits.triangles != limits->triangles || g->table_limits.vertices != limits->vertices) {
        fill_table(g->triangle_clusters, CUT_GROUP_MOST + 1, limits->triangles);
        g->table_limits = *limits;
    }
}

void clast_group_cut(group *g, const group_job *job, uint32_t begin, uint32_t count, uint32_t *clusters,
                     uint64_t *vertices)
{
    prepare(g, &job->limits);
    load_boxes(g, job->boxes + begin, count);
    uint32_t different = number_corners(g, job, begin, count);
    g->vertices_matter = (float)different * (float)g->limits.triangles >
                         VERTICES_MATTER * (float)count * (float)g->limits.vertices;
    float sharing = ((float)count / (float)different - 1.0f) / 0.9f;
    fill_vertex_table(g, different + 1, g->limits.vertices, sharing < 0.0f ? 0.0f : sharing > 1.0f ? 1.0f : sharing);
    cut_clusters(g, count);
    join_neighbours(g);
    uint32_t *numbers = g->sorted[0]; // free since load_boxes
    for (uint32_t i = 0; i < count; i++) {
        numbers[i] = job->boxes[begin + i].lower.number;
    }
    for (uint32_t i = 0; i < g->cluster_count; i++) {
        const part *cluster = &g->clusters[i];
        order_blocks(g, cluster);
        uint32_t used = write_cluster(g, job, begin, cluster, numbers);
        job->boxes[begin + cluster->begin].upper.number = (uint32_t)cluster->count << 16 | used;
        *vertices += used;
    }
    *clusters += g->cluster_count;
}
