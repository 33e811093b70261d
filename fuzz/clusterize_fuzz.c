// SPDX-License-Identifier: Apache-2.0
// The clusterizer: every triangle comes back once, in clusters within the limits.
#include "clast/geometry.h"
#include "mesh.h"

static void check(const clast_clusterize_desc *desc, const clast_clusters *made)
{
    static uint8_t met[FUZZ_TRIANGLES];
    size_t triangles = 0;
    memset(met, 0, sizeof met);
    for (size_t i = 0; i < made->cluster_count; i++) {
        const clast_cluster *cluster = &made->clusters[i];
        FUZZ_CHECK(cluster->triangle_count >= 1 && cluster->triangle_count <= desc->max_triangles);
        FUZZ_CHECK(cluster->vertex_count >= 1 && cluster->vertex_count <= desc->max_vertices);
        FUZZ_CHECK(cluster->first_triangle == triangles);
        for (uint32_t k = 0; k < cluster->triangle_count; k++, triangles++) {
            uint32_t triangle = made->triangles[triangles];
            FUZZ_CHECK(triangle < desc->triangle_count && !met[triangle]);
            met[triangle] = 1;
            for (uint32_t corner = 0; corner < 3; corner++) {
                uint8_t local = made->indices[3 * triangles + corner];
                FUZZ_CHECK(local < cluster->vertex_count);
                FUZZ_CHECK(made->vertices[cluster->first_vertex + local] == desc->indices[3 * triangle + corner]);
            }
        }
    }
    FUZZ_CHECK(triangles == desc->triangle_count);
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    static fuzz_mesh mesh;
    clast_clusterize_desc desc = {.max_triangles = 1u + fuzz_byte(&bytes),
                                  .max_vertices = 3u + fuzz_byte(&bytes) % 254u};
    fuzz_mesh_fill(&bytes, &mesh);
    desc.positions = mesh.positions;
    desc.position_count = mesh.vertex_count;
    desc.indices = mesh.indices;
    desc.triangle_count = mesh.triangle_count;
    clast_clusters made;
    FUZZ_CHECK(clast_clusterize(context, &desc, &made) == CLAST_OK);
    check(&desc, &made);
    clast_clusters_free(context, &made);
}
