// SPDX-License-Identifier: Apache-2.0
// Cutting a piece anew: its triangles are dealt among the same clusters, so that these are compact again, and each
// cluster's triangles are cut into blocks. Both by the clusterizer's sweeps over sorted boxes (geometry/blocks.c).
// Each part of the piece gets a number of clusters with its triangles, about in proportion, so that there are always
// enough.
#include <string.h>

#include "accel/deform.h"
#include "geometry/blocks.h"

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };
_Static_assert((uint32_t)PIECE_TRIANGLES <= (uint32_t)BLOCKS_SORTED_MOST, "a piece's triangles are sorted together");
_Static_assert((uint32_t)BLOCKS_PIECE == BLOCK_TRIANGLES, "triangles are ordered for the blocks of treelets");

_Static_assert(sizeof(clast_template) == sizeof(uint64_t), "a template's head");

// A cut is kept where its areas are below this share of those before.
#define KEPT_NUMERATOR 99
#define KEPT_DENOMINATOR 100
// Weighs places where there would not be clusters enough.
#define UNWANTED (1u << 24)

// Triangles [begin, begin + count) of the orders, which make so many clusters.
typedef struct part {
    uint16_t begin, count, clusters;
} part;

struct clast_piece_cutter {
    // The piece's triangles.
    SORTED_ROOM(PIECE_TRIANGLES) room;
    uint16_t corners[PIECE_TRIANGLES][3]; // among the piece's vertices
    uint32_t originals[PIECE_TRIANGLES];  // in the mesh
    uint32_t triangle_count;
    // Its vertices, each once.
    lanes positions[PIECE_VERTICES]; // in steps of the piece's box
    uint32_t numbers[PIECE_VERTICES];
    uint64_t sorted[2][PIECE_VERTICES]; // number, cluster and vertex of it
    uint16_t piece_vertices[PIECE_CLUSTERS][CLUSTER_VERTICES];
    uint32_t vertex_count;
    // Its box.
    lanes base, top, factor;
    // What becomes of it.
    boxes_weights weights;
    part clusters[PIECE_CLUSTERS];
    uint32_t cluster_count;
    uint16_t seen[PIECE_VERTICES]; // one more than the cluster that met the vertex last
    uint8_t local[PIECE_VERTICES]; // its number there
    uint16_t locals[PIECE_CLUSTERS][CLUSTER_VERTICES];
    uint32_t cluster_originals[PIECE_CLUSTERS][CLUSTER_TRIANGLES];
    lanes cluster_lower[PIECE_CLUSTERS], cluster_upper[PIECE_CLUSTERS];
    struct {
        uint64_t head; // a clast_template's
        clast_block blocks[CLUSTER_BLOCKS];
    } templates[PIECE_CLUSTERS];
};

size_t clast_piece_cutter_size(void)
{
    return (sizeof(clast_piece_cutter) + ARENA_ALIGNMENT - 1) / ARENA_ALIGNMENT * ARENA_ALIGNMENT;
}

static clast_template *staged(clast_piece_cutter *c, uint32_t cluster)
{
    return (clast_template *)(void *)&c->templates[cluster];
}

// A piece under the knife.
typedef struct cut_job {
    clast_deforming_mesh *mesh;
    const uint32_t *slots;
    uint32_t count;
    const float *positions;
} cut_job;

// ------------------------------------------------------------------------------------------------------------ loading

// False where there is nothing to be told apart.
static bool load_box(clast_piece_cutter *c, const cut_job *job)
{
    c->base = box_none_lower();
    c->top = box_none_upper();
    bool any = false;
    for (uint32_t i = 0; i < job->count; i++) {
        const clast_box *box = &job->mesh->pool->boxes[job->slots[i]];
        if (!clast_box_is_empty(box)) {
            c->base = lanes_min(c->base, lanes_finite(box->lower.v));
            c->top = lanes_max(c->top, lanes_finite(box->upper.v));
            any = true;
        }
    }
    float sides[4], longest = 0.0f;
    lanes_store(sides, lanes_subtract(c->top, c->base));
    for (int axis = 0; axis < 3 && any; axis++) {
        longest = sides[axis] > longest ? sides[axis] : longest;
    }
    c->factor = lanes_all(longest > 1e-30f ? STEP_BOX_STEPS / longest : 0.0f);
    return longest > 1e-30f;
}

static lanes in_steps(const clast_piece_cutter *c, const float *position)
{
    lanes within = lanes_min(lanes_max(lanes_finite(position), c->base), c->top);
    return lanes_multiply(lanes_subtract(within, c->base), c->factor);
}

static void sort_pass(const uint64_t *from, uint64_t *to, uint32_t count, uint32_t shift)
{
    uint16_t places[DIGITS] = {0};
    for (uint32_t i = 0; i < count; i++) {
        places[from[i] >> shift & (DIGITS - 1)]++;
    }
    for (uint32_t digit = 0, sum = 0; digit < DIGITS; digit++) {
        uint32_t here = places[digit];
        places[digit] = (uint16_t)sum;
        sum += here;
    }
    for (uint32_t i = 0; i < count; i++) {
        to[places[from[i] >> shift & (DIGITS - 1)]++] = from[i];
    }
}

// Finds the vertices that clusters share. By sorting: a table could be made slow by a mesh.
static void load_vertices(clast_piece_cutter *c, const cut_job *job)
{
    uint64_t *from = c->sorted[0], *to = c->sorted[1];
    uint32_t total = 0, lowest = UINT32_MAX, highest = 0;
    for (uint32_t i = 0; i < job->count; i++) {
        const uint32_t *numbers = job->mesh->numbers + job->mesh->first[job->slots[i]];
        uint32_t vertices = clast_deform_template(job->mesh, job->slots[i])->vertex_count;
        for (uint32_t k = 0; k < vertices; k++) {
            lowest = numbers[k] < lowest ? numbers[k] : lowest;
            highest = numbers[k] > highest ? numbers[k] : highest;
            from[total++] = (uint64_t)numbers[k] << 16 | i << 8 | k;
        }
    }
    for (uint32_t shift = 0; shift < 32 && (lowest ^ highest) >> shift != 0; shift += DIGIT_BITS) {
        sort_pass(from, to, total, 16 + shift);
        uint64_t *other = from;
        from = to;
        to = other;
    }
    uint32_t found = 0;
    for (uint32_t i = 0; i < total; i++) {
        uint32_t number = (uint32_t)(from[i] >> 16);
        if (i == 0 || number != c->numbers[found - 1]) {
            c->seen[found] = 0;
            uint32_t slot = job->slots[from[i] >> 8 & 0xff];
            c->positions[found] = in_steps(c, job->mesh->vertices + 3 * (job->mesh->first[slot] + (from[i] & 0xff)));
            c->numbers[found++] = number;
        }
        c->piece_vertices[from[i] >> 8 & 0xff][from[i] & 0xff] = (uint16_t)(found - 1);
    }
    c->vertex_count = found;
}

// A block's lanes after the last triangle repeat the first.
static uint32_t lanes_of(const clast_block *block)
{
    uint32_t count = 1;
    while (count < BLOCK_TRIANGLES && block->triangles[count] != block->triangles[0]) {
        count++;
    }
    return count;
}

static void load_triangle(clast_piece_cutter *c, const clast_block *block, uint32_t lane, const uint16_t *vertices,
                          const uint32_t *originals)
{
    uint32_t item = c->triangle_count++;
    lanes p[3];
    for (uint32_t corner = 0; corner < 3; corner++) {
        c->corners[item][corner] = vertices[block->corners[corner][lane]];
        p[corner] = c->positions[c->corners[item][corner]];
    }
    c->room.box[item] = step_box_from(lanes_min(lanes_min(p[0], p[1]), p[2]), lanes_max(lanes_max(p[0], p[1]), p[2]));
    c->originals[item] = originals[block->triangles[lane]];
}

// Gives the areas of the clusters and blocks that there are.
static uint64_t load_triangles(clast_piece_cutter *c, const cut_job *job)
{
    const clast_deforming_mesh *mesh = job->mesh;
    uint64_t areas = 0;
    c->triangle_count = 0;
    for (uint32_t i = 0; i < job->count; i++) {
        const clast_template *topology = clast_deform_template(mesh, job->slots[i]);
        const uint32_t *originals = mesh->triangles + (size_t)job->slots[i] * CLUSTER_TRIANGLES;
        step_box all = step_box_none();
        for (uint32_t b = 0; b < topology->block_count; b++) {
            const clast_block *block = &topology->blocks[b];
            step_box box = step_box_none();
            for (uint32_t lane = 0, count = lanes_of(block); lane < count; lane++) {
                load_triangle(c, block, lane, c->piece_vertices[i], originals);
                box = step_box_join(box, c->room.box[c->triangle_count - 1]);
            }
            areas += step_box_area(box);
            all = step_box_join(all, box);
        }
        areas += step_box_area(all);
    }
    return areas;
}

// ------------------------------------------------------------------------------------------------------------ dealing

static uint32_t clusters_for(uint32_t triangles, uint32_t most)
{
    return (triangles + most - 1) / most;
}

// How many of a part's clusters its first `left` triangles get; 0 where that cannot be.
static uint32_t clusters_of_left(const part *p, uint32_t left, uint32_t most)
{
    uint32_t right = p->count - left, clusters = (2u * p->clusters * left + p->count) / (2u * p->count);
    uint32_t enough = clusters_for(left, most), others = clusters_for(right, most);
    if (enough + others > p->clusters) {
        return 0;
    }
    clusters = clusters < enough ? enough : clusters > p->clusters - others ? p->clusters - others : clusters;
    return clusters <= left && p->clusters - clusters <= right ? clusters : 0; // none is empty
}

// The nearest to the middle that can be. A part always has clusters <= triangles <= clusters * most, and both its
// sides have.
static uint32_t any_left(const part *p, uint32_t most)
{
    uint32_t clusters = p->clusters / 2, others = p->clusters - clusters;
    uint32_t least = p->count > others * most + clusters ? p->count - others * most : clusters;
    uint32_t largest = clusters * most < p->count - others ? clusters * most : p->count - others;
    uint32_t left = p->count / 2;
    return left < least ? least : left > largest ? largest : left;
}

static part cut_part(clast_piece_cutter *c, sorted_boxes *sorted, const part *p, uint32_t most)
{
    boxes_cut best = {.cost = UINT64_MAX};
    uint32_t pieces = (p->count + BLOCKS_PIECE - 1u) / BLOCKS_PIECE;
    for (uint32_t k = 1; k < pieces; k++) {
        uint32_t clusters = clusters_of_left(p, k * BLOCKS_PIECE, most);
        c->weights.left[k] = clusters != 0 ? clusters : UNWANTED;
        c->weights.right[k] = clusters != 0 ? p->clusters - clusters : UNWANTED;
    }
    for (uint32_t axis = 0; axis < 3 && pieces > 1; axis++) {
        clast_boxes_sweep(sorted, axis, p->begin, p->count, BLOCKS_PIECE, &c->weights, false, &best);
    }
    uint32_t clusters = best.left != 0 ? clusters_of_left(p, best.left, most) : 0;
    if (clusters == 0) {
        best.left = any_left(p, most);
        clusters = clusters_of_left(p, best.left, most);
    }
    clast_boxes_part(sorted, p->begin, p->count, &best, false);
    return (part){p->begin, (uint16_t)best.left, (uint16_t)clusters};
}

// Deals all triangles among so many clusters, of at most `most` each.
static void deal(clast_piece_cutter *c, sorted_boxes *sorted, uint32_t clusters, uint32_t most)
{
    part stack[PIECE_CLUSTERS + 1];
    uint32_t waiting = 0;
    clast_boxes_sort(sorted, c->triangle_count);
    c->cluster_count = 0;
    stack[waiting++] = (part){0, (uint16_t)c->triangle_count, (uint16_t)clusters};
    while (waiting != 0) {
        part p = stack[--waiting];
        if (p.clusters == 1) {
            c->clusters[c->cluster_count++] = p;
            continue;
        }
        part left = cut_part(c, sorted, &p, most);
        stack[waiting++] = (part){(uint16_t)(p.begin + left.count), (uint16_t)(p.count - left.count),
                                  (uint16_t)(p.clusters - left.clusters)};
        stack[waiting++] = left;
    }
}

// ----------------------------------------------------------------------------------------------------------- building

// Makes a cluster's template of its triangles, whose numbers are in the order of its blocks; adds the areas of its box
// and its blocks' boxes. False where the vertices are too many.
static bool build_cluster(clast_piece_cutter *c, uint32_t cluster, const uint16_t *ordered, uint32_t most,
                          uint64_t *areas)
{
    clast_template *topology = staged(c, cluster);
    uint32_t count = c->clusters[cluster].count, vertices = 0;
    step_box all = step_box_none(), box = step_box_none();
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t i = 0; i < count; i++) {
        uint32_t item = ordered[i], lane = i % BLOCK_TRIANGLES;
        clast_block *block = &topology->blocks[i / BLOCK_TRIANGLES];
        for (uint32_t corner = 0; corner < 3; corner++) {
            uint32_t vertex = c->corners[item][corner];
            if (c->seen[vertex] != cluster + 1) {
                if (vertices == most) {
                    return false;
                }
                c->seen[vertex] = (uint16_t)(cluster + 1);
                c->local[vertex] = (uint8_t)vertices;
                c->locals[cluster][vertices++] = (uint16_t)vertex;
                lower = lanes_min(lower, c->positions[vertex]);
                upper = lanes_max(upper, c->positions[vertex]);
            }
            block->corners[corner][lane] = c->local[vertex];
        }
        block->triangles[lane] = (uint8_t)i;
        c->cluster_originals[cluster][i] = c->originals[item];
        box = step_box_join(box, c->room.box[item]);
        if (lane == BLOCK_TRIANGLES - 1 || i == count - 1) {
            *areas += step_box_area(box);
            all = step_box_join(all, box);
            box = step_box_none();
        }
    }
    for (uint32_t i = count; i % BLOCK_TRIANGLES != 0; i++) { // the lanes beyond the last repeat the block's first
        clast_block *block = &topology->blocks[i / BLOCK_TRIANGLES];
        block->triangles[i % BLOCK_TRIANGLES] = block->triangles[0];
        for (uint32_t corner = 0; corner < 3; corner++) {
            block->corners[corner][i % BLOCK_TRIANGLES] = block->corners[corner][0];
        }
    }
    *topology = (clast_template){.triangle_count = (uint16_t)count,
                                 .vertex_count = (uint16_t)vertices,
                                 .block_count = (uint16_t)((count + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES),
                                 .all_used = 1};
    c->cluster_lower[cluster] = lower;
    c->cluster_upper[cluster] = upper;
    *areas += step_box_area(all);
    return true;
}

// ------------------------------------------------------------------------------------------------------------ keeping

// The slot among those not taken whose box is nearest: the tree above stays fitting.
static uint32_t nearest_slot(const clast_piece_cutter *c, uint32_t cluster, const cut_job *job, uint64_t taken)
{
    uint32_t nearest = 0;
    float least = INFINITY;
    lanes centre = lanes_add(c->cluster_lower[cluster], c->cluster_upper[cluster]);
    for (uint32_t i = 0; i < job->count; i++) {
        if ((taken >> i & 1) != 0) {
            continue;
        }
        const clast_box *box = &job->mesh->pool->boxes[job->slots[i]];
        float distance = 1e30f, away[4]; // of a cluster that was nowhere
        if (!clast_box_is_empty(box)) {
            lanes there = lanes_add(in_steps(c, box->lower.v), in_steps(c, box->upper.v));
            lanes_store(away, lanes_subtract(there, centre));
            distance = away[0] * away[0] + away[1] * away[1] + away[2] * away[2];
        }
        if (distance < least) {
            least = distance;
            nearest = i;
        }
    }
    return nearest;
}

static void keep_cluster(clast_piece_cutter *c, uint32_t cluster, const cut_job *job, uint32_t slot)
{
    clast_deforming_mesh *mesh = job->mesh;
    const clast_template *topology = staged(c, cluster);
    memcpy(clast_deform_template(mesh, slot), topology,
           sizeof *topology + topology->block_count * sizeof topology->blocks[0]);
    memcpy(mesh->triangles + (size_t)slot * CLUSTER_TRIANGLES, c->cluster_originals[cluster],
           topology->triangle_count * sizeof *mesh->triangles);
    size_t first = mesh->first[slot];
    for (uint32_t i = 0; i < topology->vertex_count; i++) {
        uint32_t number = c->numbers[c->locals[cluster][i]];
        mesh->numbers[first + i] = number;
        memcpy(mesh->vertices + 3 * (first + i), job->positions + 3 * (size_t)number, 3 * sizeof *mesh->vertices);
    }
}

static void keep(clast_piece_cutter *c, const cut_job *job)
{
    const clast_clas_pool *pool = job->mesh->pool;
    clast_fit_kernel fit = clast_accel_kernels_of(clast_context_isa(pool->context))->fit;
    uint64_t taken = 0;
    uint32_t target[PIECE_CLUSTERS];
    for (uint32_t i = 0; i < job->count; i++) {
        uint32_t place = nearest_slot(c, i, job, taken);
        taken |= UINT64_C(1) << place;
        target[i] = job->slots[place];
    }
    for (uint32_t i = 0; i < job->count; i++) {
        keep_cluster(c, i, job, target[i]);
        fit(clast_pool_slot(pool, target[i]), &pool->boxes[target[i]]);
    }
}

// ---------------------------------------------------------------------------------------------------------------- all

// Where vertices are what fills clusters, none may get more triangles than one has.
static uint32_t most_triangles(const clast_piece_cutter *c, const cut_job *job)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < job->count; i++) {
        uint32_t triangles = clast_deform_template(job->mesh, job->slots[i])->triangle_count;
        most = triangles > most ? triangles : most;
    }
    return 2 * c->vertex_count > 3 * c->triangle_count ? most : CLUSTER_TRIANGLES;
}

typedef enum outcome { CUT_BETTER, CUT_NO_BETTER, CUT_CROWDED } outcome;

// Deals the triangles, at most so many to each cluster, and builds the clusters. Crowded: one has too many vertices.
static outcome try_cut(clast_piece_cutter *c, const cut_job *job, uint32_t most, uint64_t before)
{
    sorted_boxes sorted = SORTED_IN(&c->room);
    uint64_t after = 0;
    deal(c, &sorted, job->count, most);
    for (uint32_t i = 0; i < job->count; i++) {
        uint16_t ordered[CLUSTER_TRIANGLES];
        clast_boxes_order_blocks(&sorted, c->clusters[i].begin, c->clusters[i].count, ordered);
        if (!build_cluster(c, i, ordered, job->mesh->vertex_stride, &after)) {
            return CUT_CROWDED;
        }
        if (after * KEPT_DENOMINATOR >= before * KEPT_NUMERATOR) {
            return CUT_NO_BETTER;
        }
    }
    return CUT_BETTER;
}

bool clast_deform_cut(clast_deforming_mesh *mesh, clast_piece_cutter *c, const clast_piece *piece,
                      const float *positions)
{
    cut_job job = {mesh, mesh->order + piece->first, piece->count, positions};
    if (!load_box(c, &job)) {
        return false;
    }
    load_vertices(c, &job);
    uint64_t before = load_triangles(c, &job);
    outcome came = try_cut(c, &job, most_triangles(c, &job), before);
    if (came == CUT_CROWDED) { // dealt evenly, the fullest has fewer vertices
        uint32_t even = clusters_for(c->triangle_count, job.count) + BLOCK_TRIANGLES / 2;
        memset(c->seen, 0, c->vertex_count * sizeof c->seen[0]);
        came = try_cut(c, &job, even < CLUSTER_TRIANGLES ? even : CLUSTER_TRIANGLES, before);
    }
    if (came == CUT_BETTER) {
        keep(c, &job);
    }
    return came == CUT_BETTER;
}
