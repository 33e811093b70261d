// SPDX-License-Identifier: Apache-2.0
// Plain meshes: the twin of src/source/clusters.c.
#ifndef CLAST_SOURCE_CLUSTERS_GLSL
#define CLAST_SOURCE_CLUSTERS_GLSL

#include "shared/cooked.h"
#include "source/mesh.glsl"

#define CLAST_SOURCE_CLUSTERS_RESIDENT resident_clusters
#define CLAST_SOURCE_CLUSTERS_LOCATE locate_clusters
#define CLAST_SOURCE_CLUSTERS_SEGMENTS segments_clusters
#define CLAST_SOURCE_CLUSTERS_EVALUATE evaluate_clusters

ARRAY_OF(cooked_clusters, clast_cooked_cluster, 4)

clast_cooked_cluster cooked_cluster_of(unit_reference unit, uint item)
{
    return cooked_clusters(array_of(unit, CLUSTERS_ARRAY_CLUSTERS)).at[item];
}

bool clusters_move(unit_reference unit) { return array_of(unit, CLUSTERS_ARRAY_NUMBERS) != 0ul; }

uint64_t resident_clusters(unit_reference unit, clast_cluster_record record)
{
    uint64_t positions = array_of(unit, CLUSTERS_ARRAY_POSITIONS);
    uint first = cooked_cluster_of(unit, record.item).first_vertex;
    return clusters_move(unit) ? 0ul : positions + 12ul * uint64_t(first);
}

clast_surface_point locate_clusters(unit_reference unit, clast_cluster_record record, uint64_t words, uint triangle,
                                    vec2 barycentrics)
{
    uints triangles = uints(array_of(unit, CLUSTERS_ARRAY_TRIANGLES));
    clast_surface_point point;
    point.primitive = triangles.at[cooked_cluster_of(unit, record.item).first_triangle + triangle];
    point.coordinates = store2(barycentrics);
    point.level = 0.0f;
    return point;
}

float segments_clusters(unit_reference unit, clast_source_view view, clast_cluster_record record, uint64_t words,
                        uint triangle, vec2 barycentrics)
{
    return 0.0f;
}

source_surface evaluate_clusters(unit_reference unit, clast_surface_point point) { return mesh_evaluate(unit, point); }

#ifdef SOURCE_KIND
#define SOURCE_SINGLE_ITEMS
#define source_resident resident_clusters

clast_source_count source_count(unit_reference unit, uint item)
{
    return cooked_count(cooked_cluster_of(unit, item), clusters_move(unit));
}

void source_emit(unit_reference unit, uint item, uint first_vertex, uint first_word, uint64_t words, uint64_t records)
{
    cluster_records(records).at[0] =
        cooked_record(cooked_cluster_of(unit, item), unit.of.number, item, first_vertex, first_word);
}
#endif

#ifdef SOURCE_FILLS
void source_fill(unit_reference unit, clast_cluster_record record, uint64_t words)
{
    clast_cooked_cluster cluster = cooked_cluster_of(unit, record.item);
    bool moves = clusters_move(unit);
    uints numbers = uints(array_of(unit, CLUSTERS_ARRAY_NUMBERS));
    uint64_t positions = moves ? mesh_positions(unit) : array_of(unit, CLUSTERS_ARRAY_POSITIONS);
    for (uint i = cluster_lane(); i < cluster.vertex_count; i += LANES) {
        uint vertex = cluster.first_vertex + i;
        if (moves) {
            vertex = numbers.at[vertex];
        }
        set_cluster_point(i, mesh_value3(positions, vertex, 3u));
    }
    cluster_barrier();
}
#endif

#endif
