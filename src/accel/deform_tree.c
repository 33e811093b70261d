// SPDX-License-Identifier: Apache-2.0
// The tree of a deforming mesh is built anew over several updates, beside the one in use, whose place it takes when it
// is done. Boxes may move meanwhile: what was built is a shape, to which later boxes are fitted like any.
#include <string.h>

#include "accel/deform.h"

// Work of the steps, in passes over single items. A subtree's takes so many for each of its levels.
enum { PASSES_BEGIN = 2, PASSES_LARGE = 1, PASSES_LEVEL = 4 };

void clast_deform_tree_take(clast_deforming_mesh *mesh, clast_arena *arena)
{
    size_t count = mesh->cluster_count;
    mesh->tree_scratch = clast_arena_take(arena, clast_tree_scratch(count), 1);
    clast_tree_place(&mesh->next_tree, count, arena);
    clast_tree_place(arena->memory != NULL ? &mesh->blas->tree : &(clast_tree){0}, count, arena);
}

void clast_deform_tree_begin(clast_deforming_mesh *mesh)
{
    clast_arena scratch = {mesh->tree_scratch, 0};
    mesh->builder = clast_tree_builder_make(mesh->context, mesh->pool->boxes, NULL, mesh->cluster_count,
                                            CLAST_BUILD_BEST, &scratch);
    mesh->tree_phase = CLAST_TREE_BEGIN;
}

static uint64_t subtree_work(const clast_build_range *range)
{
    uint32_t count = range->end - range->begin, levels = 1;
    for (uint32_t i = count; i > 1; i /= 2) {
        levels++;
    }
    return (uint64_t)PASSES_LEVEL * levels * count;
}

// As many subtrees as there is work for, one at least.
static uint64_t build_subtrees(clast_deforming_mesh *mesh, uint64_t work)
{
    clast_tree_builder *b = &mesh->builder;
    uint32_t first = mesh->next_subtree;
    uint64_t done = 0;
    for (; mesh->next_subtree < b->range_count && done < work; mesh->next_subtree++) {
        done += subtree_work(&b->ranges[mesh->next_subtree]);
    }
    clast_tree_split_subtrees(b, first, mesh->next_subtree - first);
    return done;
}

static void finish(clast_deforming_mesh *mesh)
{
    clast_tree_split_end(&mesh->builder);
    (void)clast_tree_collapse(&mesh->builder, &mesh->next_tree); // cannot fail: there is memory for the nodes
    clast_tree old = mesh->blas->tree;
    mesh->blas->tree = mesh->next_tree;
    mesh->next_tree = old;
}

bool clast_deform_tree_go_on(clast_deforming_mesh *mesh, uint64_t work)
{
    uint64_t done = 0, count = mesh->cluster_count;
    while (done < work) {
        switch (mesh->tree_phase) {
        case CLAST_TREE_BEGIN:
            clast_tree_split_begin(&mesh->builder);
            mesh->tree_phase = CLAST_TREE_LARGE;
            done += PASSES_BEGIN * count;
            break;
        case CLAST_TREE_LARGE:
            if (!clast_tree_split_large(&mesh->builder)) {
                mesh->next_subtree = 0;
                mesh->tree_phase = CLAST_TREE_SUBTREES;
            }
            done += PASSES_LARGE * count;
            break;
        case CLAST_TREE_SUBTREES:
            done += build_subtrees(mesh, work - done);
            if (mesh->next_subtree == mesh->builder.range_count) { // the rest is an update's work
                mesh->tree_phase = CLAST_TREE_END;
                return false;
            }
            break;
        case CLAST_TREE_END:
            finish(mesh);
            mesh->tree_phase = CLAST_TREE_IDLE;
            return true;
        case CLAST_TREE_IDLE: return false;
        }
    }
    return false;
}
