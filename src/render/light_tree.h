// SPDX-License-Identifier: Apache-2.0
// A tree over lights that are somewhere, to choose one of them for a point: shared/light_tree.h.
#ifndef CLAST_RENDER_LIGHT_TREE_H
#define CLAST_RENDER_LIGHT_TREE_H

#include "base/context.h"
#include "shared/light_choice.h"

typedef struct clast_light_tree {
    clast_light_node *nodes; // the root, then pairs of children; null where no light shines
    uint32_t node_count;
    clast_light_entry *entries; // the lights of leaves
    uint32_t count;             // of entries
    uint32_t *trails;           // by light number: the turns to its leaf, the first in bit 0
    uint32_t *places;           // by light number: its entry; CLAST_NONE where it does not shine
    uint32_t number_count;      // of light numbers
    float scale;                // a power of two: from world space to the tree's
    float strength;             // importances times this are irradiances
} clast_light_tree;

// What a tree is built over. Light numbers are those of emitters, then of punctual lights.
typedef struct clast_light_sources {
    const clast_emitter *emitters;
    const float *emitter_radiances; // luminance of each, the mean over its triangle; above zero and finite
    size_t emitter_count;
    const clast_light *punctual; // directional ones are left out, and those that are dark
    size_t punctual_count;
    float extent; // of the scene
} clast_light_sources;

// The same lights give the same tree on any number of threads. `*tree` is to be destroyed whatever is returned.
clast_status clast_light_tree_create(clast_context *context, const clast_light_sources *sources,
                                     clast_light_tree *tree);
void clast_light_tree_destroy(clast_context *context, clast_light_tree *tree);

#endif
