// SPDX-License-Identifier: Apache-2.0
// Plain meshes as they are cooked: what the source `clusters` keeps of them (source/clusters.c).
#ifndef CLAST_SHARED_COOKED_H
#define CLAST_SHARED_COOKED_H

#include "shared/device.h"

LIMIT(CLUSTERS_ARRAY_CLUSTERS, 9u, "clast_cooked_cluster, by item")
LIMIT(CLUSTERS_ARRAY_TRIANGLES, 10u, "the mesh's triangle, for each of the clusters' triangles")
LIMIT(CLUSTERS_ARRAY_POSITIONS, 11u, "of the clusters' vertices; none where the mesh moves")
LIMIT(CLUSTERS_ARRAY_NUMBERS, 12u, "where it does: the mesh's vertices that they are")
LIMIT(CLUSTERS_ARRAYS, 13u, "how many there are with the mesh's own")

// 20 bytes a cluster, beside which are 4 a triangle, and 12 or 4 a vertex.
RECORD(clast_cooked_cluster)
{
    uint first_triangle; // into the triangles
    uint triangle_count;
    uint first_vertex;   // into the positions or numbers
    uint vertex_count;
    uint template_index;
};
RECORD_SIZE(clast_cooked_cluster, 20)

// What an item emits: itself. `moves`: its vertices are filled.
FN clast_source_count cooked_count(clast_cooked_cluster cluster, bool moves)
{
    clast_source_count count;
    count.clusters = 1u;
    count.triangles = cluster.triangle_count;
    count.vertices = moves ? cluster.vertex_count : 0u;
    count.words = 0u;
    count.blocks = 0u;
    return count;
}

FN clast_cluster_record cooked_record(clast_cooked_cluster cluster, uint unit, uint item, uint first_vertex, uint first_word)
{
    clast_cluster_record record;
    record.unit = unit;
    record.template_index = cluster.template_index;
    record.first_vertex = first_vertex;
    record.item = item;
    record.form_and_counts = form_and_counts(FORM_WHOLE, cluster.triangle_count, cluster.vertex_count);
    record.detail = 0u;
    record.first_word = first_word;
    return record;
}

#endif
