// SPDX-License-Identifier: Apache-2.0
// Fits a tree's boxes anew. Nodes are numbered level by level, so the descendants of neighbours are neighbours on each level:
// threads take subtrees, each from its lowest level up, and nobody waits between levels.
#include "accel/structures.h"
#include "base/thread.h"
#include "shared/box.h"

enum {
    ALONE_NODES = 256,  // trees of fewer nodes are done before another thread wakes
    SUBTREE_ROOTS = 48, // the level that is cut has at least so many nodes
    MOST_PARTS = 256,
};

clast_box clast_box_empty(void)
{
    return (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
}

bool clast_box_is_empty(const clast_box *box)
{
    return !(box->lower.v[0] <= box->upper.v[0]);
}

// ----------------------------------------------------------------------------------------------------------- one node

static void quantise_child(clast_node *node, uint32_t lane, const clast_box *box)
{
    for (int axis = 0; axis < 3; axis++) {
        uint8_t *lower = &node->boxes[axis][0][lane], *upper = &node->boxes[axis][1][lane];
        if (clast_box_is_empty(box)) { // may still be visited: what is below hits nothing
            *lower = 255;
            *upper = 0;
        } else {
            *lower = (uint8_t)box_quantise_down(box->lower.v[axis], node->lower[axis], node->exponents[axis]);
            *upper = (uint8_t)box_quantise_up(box->upper.v[axis], node->lower[axis], node->exponents[axis]);
        }
    }
}

// The plain twin of clast_refit_nodes.
void clast_tree_refit_node(clast_tree *tree, const clast_box *items, uint32_t number)
{
    clast_node *node = &tree->nodes[number];
    clast_box boxes[TREE_WIDTH];
    clast_box whole = clast_box_empty();
    for (uint32_t i = 0; i < TREE_WIDTH; i++) {
        uint32_t child = node->children[i];
        boxes[i] = i >= node->child_count            ? clast_box_empty()
                   : (child & CLAST_CHILD_ITEM) != 0 ? items[child & ~CLAST_CHILD_ITEM]
                                                     : tree->boxes[child];
        whole.lower = store3(min3(load3(whole.lower), load3(boxes[i].lower)));
        whole.upper = store3(max3(load3(whole.upper), load3(boxes[i].upper)));
    }
    bool empty = clast_box_is_empty(&whole);
    for (int axis = 0; axis < 3; axis++) {
        whole.lower.v[axis] = unsigned_zero(whole.lower.v[axis]);
        whole.upper.v[axis] = unsigned_zero(whole.upper.v[axis]);
        node->lower[axis] = empty ? 0.0f : whole.lower.v[axis];
        node->exponents[axis] = (uint8_t)(empty ? BOX_STEP_LEAST
                                                : box_exponent(whole.upper.v[axis] - whole.lower.v[axis]));
    }
    tree->boxes[number] = whole;
    for (uint32_t i = 0; i < TREE_WIDTH; i++) {
        quantise_child(node, i, &boxes[i]);
    }
}

// ----------------------------------------------------------------------------------------------------------- all nodes

typedef struct node_range {
    uint32_t begin, end;
} node_range;

typedef struct refit_job {
    clast_tree *tree;
    const clast_box *boxes;
    clast_refit_kernel refit;
    uint32_t level, parts;
} refit_job;

// The nodes on the next level below those of a range.
static node_range range_below(const clast_tree *tree, node_range r)
{
    for (uint32_t i = r.begin; i < r.end; i++) {
        const clast_node *first = &tree->nodes[i];
        for (uint32_t k = 0; k < first->child_count; k++) {
            if ((first->children[k] & CLAST_CHILD_ITEM) != 0) {
                continue;
            }
            for (uint32_t j = r.end; j-- > i;) {
                const clast_node *last = &tree->nodes[j];
                for (uint32_t m = last->child_count; m-- > 0;) {
                    if ((last->children[m] & CLAST_CHILD_ITEM) == 0) {
                        return (node_range){first->children[k], last->children[m] + 1};
                    }
                }
            }
        }
    }
    return (node_range){0, 0};
}

static void refit_subtrees(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const refit_job *job = data;
    uint32_t first = job->tree->levels[job->level];
    uint64_t nodes = job->tree->levels[job->level + 1] - first;
    node_range ranges[TREE_DEPTH];
    uint32_t depth = 0;
    ranges[0].begin = first + (uint32_t)(nodes * begin / job->parts);
    ranges[0].end = first + (uint32_t)(nodes * end / job->parts);
    while (ranges[depth].begin < ranges[depth].end) {
        ranges[depth + 1] = range_below(job->tree, ranges[depth]);
        depth++;
    }
    while (depth-- > 0) {
        job->refit(job->tree, job->boxes, ranges[depth].begin, ranges[depth].end);
    }
}

void clast_tree_refit(clast_context *context, clast_tree *tree, const clast_box *boxes)
{
    refit_job job = {tree, boxes, clast_accel_kernels_of(clast_context_isa(context))->refit_nodes, 0, 0};
    uint32_t alone = tree->node_count;
    if (alone >= ALONE_NODES && clast_worker_count(context) > 1) {
        while (job.level + 1 < tree->level_count &&
               tree->levels[job.level + 1] - tree->levels[job.level] < SUBTREE_ROOTS) {
            job.level++;
        }
        alone = tree->levels[job.level];
        uint32_t nodes = tree->levels[job.level + 1] - alone;
        job.parts = nodes < MOST_PARTS ? nodes : MOST_PARTS;
        clast_parallel_for(context, job.parts, 1, refit_subtrees, &job);
    }
    job.refit(tree, boxes, 0, alone); // children come after their parents: from the last to the first
}
