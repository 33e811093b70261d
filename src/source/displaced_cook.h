// SPDX-License-Identifier: Apache-2.0
// What cooking a displaced mesh needs in passing.
#ifndef CLAST_SOURCE_DISPLACED_COOK_H
#define CLAST_SOURCE_DISPLACED_COOK_H

#include "clast/geometry.h"
#include "source/displaced.h"

typedef struct displaced_cook {
    clast_context *context;
    displaced_unit *unit;
    const clast_mesh *mesh;
    uint32_t *remap;  // by the mesh's vertex: the lowest of its position
    uint32_t *welded; // indices by that; null where the mesh's own are the same
    clast_clusters clusters;
} displaced_cook;

// Clusters with their triangles, edges and seams, and the templates. Vertices are there.
clast_status clast_displaced_cook_clusters(displaced_cook *cook, clast_template_set *templates);

// What the map of each of the mesh's triangles holds over it, by triangle: a block of clast_allocate. Vertices are there. `cache`
// may be null.
clast_status clast_displaced_find_heights(const displaced_cook *cook, const clast_cook_cache *cache,
                                          clast_height_range **ranges);

#endif
