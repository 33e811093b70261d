// SPDX-License-Identifier: Apache-2.0
// Clusters of real models, from CLAST_ASSETS: whole, within the limits, and full.
#include "geometry/clusters.h"

#include <ftw.h>

#include "clast/scene.h"
#include "scene/scene.h"

enum { TRIANGLES_LEAST = 10000 }; // models below are not held to the fill

static clast_context *walk_context; // nftw has no argument for its caller
static size_t large_count, wrong_count;

typedef struct tally {
    double fill; // sum over clusters
    size_t clusters, triangles;
} tally;

// The mesh as the sources cook it: equal positions are one.
static mesh welded(clast_context *context, const clast_mesh *from)
{
    mesh m = mesh_make(from->vertex_count, from->triangle_count);
    memcpy(m.positions, from->positions, 12 * (size_t)from->vertex_count);
    uint32_t *remap = malloc(((size_t)from->vertex_count + 1) * sizeof *remap);
    size_t unique;
    assert_ok(context, clast_weld_positions(context, m.positions, m.position_count, remap, &unique));
    for (size_t i = 0; i < 3 * m.triangle_count; i++) {
        m.indices[i] = remap[from->indices != NULL ? from->indices[i] : i];
    }
    free(remap);
    return m;
}

static void add_mesh(clast_context *context, const clast_mesh *from, tally *t)
{
    mesh m = welded(context, from);
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_clusters clusters;
    assert_ok(context, clast_clusterize(context, &desc, &clusters));
    check_clusters(&desc, &clusters);
    t->fill += cluster_fill(&clusters, 128, 128) * (double)clusters.cluster_count;
    t->clusters += clusters.cluster_count;
    t->triangles += m.triangle_count;
    clast_clusters_free(context, &clusters);
    mesh_free(&m);
}

static void check_model(const char *path)
{
    clast_scene *scene;
    if (clast_scene_load(walk_context, path, &scene) != CLAST_OK) {
        return; // what loads is other tests' business
    }
    tally t = {0};
    for (size_t i = 0; i < scene->geometry_count; i++) {
        if (scene->geometries[i].kind == CLAST_SOURCE_CLUSTERS) {
            add_mesh(walk_context, &scene->geometries[i].of.mesh, &t);
        }
    }
    clast_scene_destroy(scene);
    if (t.triangles < TRIANGLES_LEAST) {
        return;
    }
    double fill = t.fill / (double)t.clusters;
    printf("%s: %zu triangles, %zu clusters, %.1f %% full\n", path, t.triangles, t.clusters, 100.0 * fill);
    large_count++;
    wrong_count += fill < 0.85;
}

static int visit(const char *path, const struct stat *information, int type, struct FTW *place)
{
    (void)information;
    (void)place;
    const char *dot = strrchr(path, '.');
    static const char *const extensions[] = {".gltf", ".glb", ".obj", ".ply"};
    for (size_t i = 0; type == FTW_F && dot != NULL && i < sizeof extensions / sizeof *extensions; i++) {
        if (strcmp(dot, extensions[i]) == 0) {
            check_model(path);
        }
    }
    return 0;
}

static void real_models_fill_their_clusters(void **state)
{
    static const char *const folders[] = {"dense", "gltf-models", "terrain"};
    walk_context = *state;
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", test_assets(), folders[i]);
        nftw(path, visit, 16, FTW_PHYS);
    }
    assert_true(large_count > 0);
    assert_int_equal(wrong_count, 0);
}

int main(void)
{
    test_assets();
    const struct CMUnitTest tests[] = {CONTEXT_TEST(real_models_fill_their_clusters)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
