// SPDX-License-Identifier: Apache-2.0
// What an update of a deforming mesh does beside fitting boxes: it measures pieces in turns, and cuts those that may
// save most; or, in some updates, it goes on with the next tree instead.
#include <string.h>

#include "accel/deform.h"
#include "base/thread.h"
#include "shared/box.h"

enum {
    TURNS = 4, // updates in which each piece is measured once
    MEASURE_GRAIN = 16,
    TREE_UPDATES_LEAST = 10, // from one tree to the beginning of the next
    TREE_PASSES = 24,        // over all clusters, in an update that goes on with the next tree
};

// A piece is cut where it costs so many times what is expected.
#define MISFIT 1.03f
// The tree is built anew where its nodes have so many times the area that they had, or so large a part of the clusters
// was cut.
#define TREE_MISFIT 1.02f
#define TREE_CHANGES 16

// ---------------------------------------------------------------------------------------------------------- measuring

static float box_area(const clast_box *box, float scale)
{
    if (clast_box_is_empty(box)) {
        return 0.0f;
    }
    float x = (box->upper.v[0] - box->lower.v[0]) * scale, y = (box->upper.v[1] - box->lower.v[1]) * scale,
          z = (box->upper.v[2] - box->lower.v[2]) * scale;
    return x * y + y * z + z * x;
}

// The areas of all blocks of a cluster of at most CLUSTER_WIDTH, from their quantised boxes.
static float blocks_area(const clast_clas *clas, float scale)
{
    uint16_t sides[3][CLUSTER_WIDTH]; // products of two fit
    uint32_t sums[3] = {0, 0, 0};
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < CLUSTER_WIDTH; i++) {
            uint8_t lower = clas->groups[0][axis][0][i], upper = clas->groups[0][axis][1][i];
            sides[axis][i] = (uint8_t)((upper > lower ? upper : lower) - lower);
        }
        for (int i = clas->block_count; i < CLUSTER_WIDTH; i++) {
            sides[axis][i] = 0;
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < CLUSTER_WIDTH; i++) {
            sums[axis] += (uint16_t)(sides[axis][i] * sides[(axis + 1) % 3][i]);
        }
    }
    float step[3], area = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        step[axis] = power_of_two(clas->exponents[axis]) * scale;
    }
    for (int axis = 0; axis < 3; axis++) {
        area += (float)sums[axis] * (step[axis] * step[(axis + 1) % 3]);
    }
    return area;
}

// The areas of a piece's clusters and blocks; `box` becomes that of the piece's own box.
static float piece_area(const clast_deforming_mesh *mesh, const clast_piece *piece, float *box)
{
    clast_box whole = clast_box_empty();
    float area = 0.0f;
    for (uint32_t i = 0; i < piece->count; i++) {
        uint32_t slot = mesh->order[piece->first + i];
        const clast_box *own = &mesh->pool->boxes[slot];
        for (int axis = 0; axis < 3; axis++) {
            whole.lower.v[axis] = min1(whole.lower.v[axis], own->lower.v[axis]);
            whole.upper.v[axis] = max1(whole.upper.v[axis], own->upper.v[axis]);
        }
        area += box_area(own, mesh->scale) + blocks_area(clast_pool_slot(mesh->pool, slot), mesh->scale);
    }
    *box = box_area(&whole, mesh->scale);
    return area;
}

// What a piece costs in the beginning is what is to be expected of its clusters.
static void expect_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_deforming_mesh *mesh = data;
    for (size_t i = begin; i < end; i++) {
        const clast_piece *piece = &mesh->pieces[i];
        float box, area = piece_area(mesh, piece, &box);
        for (uint32_t k = 0; k < piece->count; k++) {
            mesh->expected[mesh->order[piece->first + k]] = box > 0.0f ? area / box : 0.0f;
        }
        mesh->states[i] = (clast_piece_state){area, 0.0f, 0.0f};
    }
}

static float expected_of(const clast_deforming_mesh *mesh, uint32_t number)
{
    const clast_piece *piece = &mesh->pieces[number];
    float sum = 0.0f;
    for (uint32_t i = 0; i < piece->count; i++) {
        sum += mesh->expected[mesh->order[piece->first + i]];
    }
    return max1(sum / (float)piece->count, mesh->states[number].tried);
}

static void measure_piece(clast_deforming_mesh *mesh, uint32_t number)
{
    clast_piece_state *state = &mesh->states[number];
    float box;
    state->area = piece_area(mesh, &mesh->pieces[number], &box);
    float expected = expected_of(mesh, number) * box;
    state->gain = state->area > MISFIT * expected ? (state->area - expected) / (float)mesh->pieces[number].count : 0.0f;
}

// After a piece was cut: what it costs now is the least that it can.
static void settle_piece(clast_deforming_mesh *mesh, uint32_t number)
{
    float box, area = piece_area(mesh, &mesh->pieces[number], &box);
    mesh->states[number] = (clast_piece_state){area, box > 0.0f ? area / box : 0.0f, 0.0f};
}

// Measures one in so many pieces.
typedef struct measure_job {
    clast_deforming_mesh *mesh;
    uint32_t turns, turn;
} measure_job;

static void measure_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const measure_job *job = data;
    for (size_t i = begin; i < end; i++) {
        uint32_t number = (uint32_t)i * job->turns + job->turn;
        if (number < job->mesh->piece_count) {
            measure_piece(job->mesh, number);
        }
    }
}

static void measure(clast_deforming_mesh *mesh, uint32_t turns)
{
    measure_job job = {mesh, turns, mesh->updates % turns};
    clast_parallel_for(mesh->context, (mesh->piece_count + turns - 1) / turns, MEASURE_GRAIN, measure_range, &job);
}

// ----------------------------------------------------------------------------------------------------------- choosing

// Whether one piece is to be cut rather than another.
static bool is_worse(const clast_piece_choice *a, const clast_piece_choice *b)
{
    return a->gain > b->gain || (a->gain == b->gain && a->piece < b->piece);
}

static void sink(clast_piece_choice *heap, uint32_t count, uint32_t place)
{
    for (;;) {
        uint32_t least = place, left = 2 * place + 1;
        if (left < count && is_worse(&heap[least], &heap[left])) {
            least = left;
        }
        if (left + 1 < count && is_worse(&heap[least], &heap[left + 1])) {
            least = left + 1;
        }
        if (least == place) {
            return;
        }
        clast_piece_choice other = heap[place];
        heap[place] = heap[least];
        heap[least] = other;
        place = least;
    }
}

// The worst pieces, the worst first: a heap of as many as there may be, the least bad of them on top.
static uint32_t find_worst(clast_deforming_mesh *mesh)
{
    clast_piece_choice *heap = mesh->choices;
    uint32_t count = 0;
    for (uint32_t i = 0; i < mesh->piece_count; i++) {
        clast_piece_choice choice = {.piece = i, .gain = mesh->states[i].gain};
        if (!(choice.gain > 0.0f)) {
            continue;
        }
        if (count < mesh->choice_most) {
            heap[count++] = choice;
            for (uint32_t k = count == mesh->choice_most ? count / 2 : 0; k-- > 0;) {
                sink(heap, count, k);
            }
        } else if (is_worse(&choice, &heap[0])) {
            heap[0] = choice;
            sink(heap, count, 0);
        }
    }
    for (uint32_t k = count / 2; k-- > 0;) {
        sink(heap, count, k);
    }
    for (uint32_t left = count; left > 1;) {
        clast_piece_choice other = heap[0];
        heap[0] = heap[--left];
        heap[left] = other;
        sink(heap, left, 0);
    }
    return count;
}

// The worst pieces for which there is budget.
static uint32_t choose(clast_deforming_mesh *mesh)
{
    uint32_t count = find_worst(mesh), chosen = 0;
    for (; chosen < count; chosen++) {
        clast_piece_choice *choice = &mesh->choices[chosen];
        const clast_piece *piece = &mesh->pieces[choice->piece];
        for (uint32_t i = 0; i < piece->count; i++) {
            choice->triangles += clast_deform_template(mesh, mesh->order[piece->first + i])->triangle_count;
        }
        if (choice->triangles > mesh->credit) {
            break;
        }
        mesh->credit -= choice->triangles;
    }
    return chosen;
}

// What is not spent is kept for the next update, but no more than a piece may need.
static void earn(clast_deforming_mesh *mesh)
{
    uint64_t most = mesh->budget > PIECE_TRIANGLES ? mesh->budget : PIECE_TRIANGLES;
    uint64_t credit = (uint64_t)mesh->credit + mesh->budget;
    mesh->credit = (uint32_t)(credit < most ? credit : most);
}

// ------------------------------------------------------------------------------------------------------------- cutting

typedef struct cut_job {
    clast_deforming_mesh *mesh;
    const float *positions;
} cut_job;

static void cut_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    const cut_job *job = data;
    clast_deforming_mesh *mesh = job->mesh;
    clast_piece_cutter *cutter = (clast_piece_cutter *)(void *)(mesh->cutters + worker * clast_piece_cutter_size());
    for (size_t i = begin; i < end; i++) {
        clast_piece_choice *choice = &mesh->choices[i];
        choice->kept = clast_deform_cut(mesh, cutter, &mesh->pieces[choice->piece], job->positions);
        settle_piece(mesh, choice->piece);
    }
}

static void cut_worst(clast_deforming_mesh *mesh, const float *positions, clast_deforming_mesh_statistics *statistics)
{
    uint32_t chosen = choose(mesh);
    cut_job job = {mesh, positions};
    clast_parallel_for(mesh->context, chosen, 1, cut_range, &job);
    for (uint32_t i = 0; i < chosen; i++) {
        const clast_piece_choice *choice = &mesh->choices[i];
        statistics->cut_triangles += choice->triangles;
        statistics->changed_clusters += choice->kept ? mesh->pieces[choice->piece].count : 0;
    }
    mesh->tree_changes += statistics->changed_clusters;
}

// ---------------------------------------------------------------------------------------------------------------- tree

static uint32_t count_items(const clast_tree *tree, const clast_node *node)
{
    uint32_t stack[TREE_STACK], waiting = 0, count = 0;
    for (;;) {
        for (uint32_t i = 0; i < node->child_count; i++) {
            if ((node->children[i] & CLAST_CHILD_ITEM) != 0) {
                count++;
            } else {
                stack[waiting++] = node->children[i];
            }
        }
        if (count > PIECE_CLUSTERS || waiting == 0) {
            return count;
        }
        node = &tree->nodes[stack[--waiting]];
    }
}

// A child's items join the last piece where both have one parent and it stays small enough.
static void add_item(clast_deforming_mesh *mesh, uint32_t item, uint32_t *found, bool begins)
{
    if (begins) {
        mesh->pieces[mesh->piece_count++] = (clast_piece){*found, 0};
    }
    mesh->order[(*found)++] = item;
    mesh->pieces[mesh->piece_count - 1].count++;
}

// All items below a node.
static void add_items(clast_deforming_mesh *mesh, uint32_t child, uint32_t *found, bool begins)
{
    const clast_tree *tree = &mesh->blas->tree;
    uint32_t stack[TREE_STACK], waiting = 0;
    stack[waiting++] = child;
    while (waiting != 0) {
        child = stack[--waiting];
        if ((child & CLAST_CHILD_ITEM) != 0) {
            add_item(mesh, child & ~CLAST_CHILD_ITEM, found, begins);
            begins = false;
            continue;
        }
        const clast_node *node = &tree->nodes[child];
        for (uint32_t i = node->child_count; i-- > 0;) {
            stack[waiting++] = node->children[i];
        }
    }
}

// Cuts the tree into pieces: children that follow each other, as many as make no more than eight clusters.
static void find_pieces(clast_deforming_mesh *mesh)
{
    const clast_tree *tree = &mesh->blas->tree;
    uint32_t stack[TREE_STACK], waiting = 0, found = 0;
    mesh->piece_count = 0;
    stack[waiting++] = 0;
    while (waiting != 0 && tree->node_count != 0) {
        const clast_node *node = &tree->nodes[stack[--waiting]];
        uint32_t large[TREE_WIDTH], large_count = 0, together = PIECE_CLUSTERS + 1;
        for (uint32_t i = 0; i < node->child_count; i++) {
            uint32_t child = node->children[i];
            uint32_t items = (child & CLAST_CHILD_ITEM) != 0 ? 1 : count_items(tree, &tree->nodes[child]);
            if (items > PIECE_CLUSTERS) {
                large[large_count++] = child;
                continue;
            }
            bool begins = together + items > PIECE_CLUSTERS;
            together = begins ? items : together + items;
            add_items(mesh, child, &found, begins);
        }
        while (large_count != 0) {
            stack[waiting++] = large[--large_count];
        }
    }
    memset(mesh->states, 0, mesh->piece_count * sizeof *mesh->states);
}

static void go_on_with_tree(clast_deforming_mesh *mesh, clast_deforming_mesh_statistics *statistics)
{
    statistics->sorted_clusters = mesh->cluster_count;
    if (clast_deform_tree_go_on(mesh, (uint64_t)TREE_PASSES * mesh->cluster_count)) {
        find_pieces(mesh);
        measure(mesh, 1);
        mesh->tree_updates = 0;
        mesh->tree_changes = 0;
        mesh->tree_area = 0.0f;
        statistics->tree_replaced = true;
    }
}

static bool tree_is_due(const clast_deforming_mesh *mesh)
{
    return mesh->tree_updates >= TREE_UPDATES_LEAST && (mesh->tree_area_now > TREE_MISFIT * mesh->tree_area ||
                                                        mesh->tree_changes > mesh->cluster_count / TREE_CHANGES);
}

// The areas of all nodes but the root, in areas of the root.
static float tree_area(const clast_deforming_mesh *mesh)
{
    const clast_tree *tree = &mesh->blas->tree;
    float sum = 0.0f, root = tree->node_count != 0 ? box_area(&tree->boxes[0], mesh->scale) : 0.0f;
    for (uint32_t i = 1; i < tree->node_count; i++) {
        sum += box_area(&tree->boxes[i], mesh->scale);
    }
    return root > 0.0f ? sum / root : 0.0f;
}

// ---------------------------------------------------------------------------------------------------------------- all

static void measure_scale(clast_deforming_mesh *mesh)
{
    clast_box whole = clast_tree_bounds(&mesh->blas->tree);
    float size = 0.0f;
    for (int axis = 0; axis < 3 && !clast_box_is_empty(&whole); axis++) {
        size = max1(size, whole.upper.v[axis] - whole.lower.v[axis]);
    }
    mesh->scale = size > 1e-37f ? 1.0f / size : 0.0f;
}

void clast_deform_watch_begin(clast_deforming_mesh *mesh)
{
    find_pieces(mesh);
    measure_scale(mesh);
    clast_parallel_for(mesh->context, mesh->piece_count, MEASURE_GRAIN, expect_range, mesh);
    mesh->tree_area = mesh->tree_area_now = tree_area(mesh);
    mesh->tree_updates = 1;
}

void clast_deform_watch(clast_deforming_mesh *mesh, const float *positions, clast_deforming_mesh_statistics *statistics)
{
    mesh->updates++;
    mesh->tree_updates++;
    earn(mesh);
    if (mesh->tree_phase == CLAST_TREE_IDLE && tree_is_due(mesh)) {
        clast_deform_tree_begin(mesh);
    }
    if (mesh->tree_phase != CLAST_TREE_IDLE) {
        go_on_with_tree(mesh, statistics);
    } else {
        measure(mesh, TURNS);
        cut_worst(mesh, positions, statistics);
    }
}

void clast_deform_watch_end(clast_deforming_mesh *mesh, clast_deforming_mesh_statistics *statistics)
{
    measure_scale(mesh);
    mesh->tree_area_now = tree_area(mesh);
    if (mesh->tree_area == 0.0f) {
        mesh->tree_area = mesh->tree_area_now;
    }
    statistics->tree_area = mesh->tree_area_now;
}
