// SPDX-License-Identifier: Apache-2.0
// A million rays at each real model, beside Embree's (robust): hits may differ on ties only. The models' meshes are taken
// together, without their instances' transforms.
#include "test.h"

#include <dirent.h>
#include <sys/stat.h>

#include "accel/meshes.h"
#include "base/file.h"
#include "base/thread.h"
#include "clast/clast.h"
#include "embree.h"
#include "embree_agreement.h"
#include "scene/scene.h"

enum { RAYS = 1000000, CHUNK = 10000 };

typedef struct trial {
    clast_context *context;
    mesh m;
    float lower[3], upper[3];
    clast_clusters clusters;
    float *vertices;
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_tlas *tlas;
    embree_mesh theirs;
    agreement agreements[RAYS / CHUNK];
} trial;

static void append_mesh(mesh *m, const clast_mesh *from)
{
    mesh grown = mesh_of(m->vertex_count + from->vertex_count, m->triangle_count + from->triangle_count);
    memcpy(grown.positions, m->positions, (size_t)m->vertex_count * 12);
    memcpy(grown.positions + 3 * (size_t)m->vertex_count, from->positions, (size_t)from->vertex_count * 12);
    memcpy(grown.indices, m->indices, (size_t)m->triangle_count * 12);
    for (size_t i = 0; i < 3 * (size_t)from->triangle_count; i++) {
        grown.indices[3 * (size_t)m->triangle_count + i] = m->vertex_count + from->indices[i];
    }
    mesh_free(m);
    *m = grown;
}

static void build_ours(trial *t)
{
    clast_context *context = t->context;
    clast_clusterize_desc desc = {.positions = t->m.positions,
                                  .position_count = t->m.vertex_count,
                                  .indices = t->m.indices,
                                  .triangle_count = t->m.triangle_count};
    assert_ok(context, clast_clusterize(context, &desc, &t->clusters));
    size_t count = t->clusters.cluster_count;
    clast_template_desc *descs = calloc(count, sizeof *descs);
    clast_clas_input *inputs = calloc(count, sizeof *inputs);
    t->vertices = malloc(t->clusters.vertex_count * 12);
    for (size_t i = 0; i < t->clusters.vertex_count; i++) {
        memcpy(t->vertices + 3 * i, t->m.positions + 3 * (size_t)t->clusters.vertices[i], 12);
    }
    for (size_t i = 0; i < count; i++) {
        const clast_cluster *c = &t->clusters.clusters[i];
        inputs[i].vertices = t->vertices + 3 * (size_t)c->first_vertex;
        descs[i] = (clast_template_desc){c->triangle_count, c->vertex_count,
                                         t->clusters.indices + 3 * (size_t)c->first_triangle, inputs[i].vertices};
    }
    uint32_t first;
    assert_ok(context, clast_template_set_create(context, &t->set));
    assert_ok(context, clast_clas_pool_create(t->set, &t->pool));
    assert_ok(context, clast_blas_create(t->pool, &t->blas));
    assert_ok(context, clast_tlas_create(context, &t->tlas));
    assert_ok(context, clast_template_set_add(t->set, descs, count, &first));
    for (size_t i = 0; i < count; i++) {
        inputs[i].template_number = first + (uint32_t)i;
    }
    clast_tlas_instance instance = instance_of(t->blas, 0);
    assert_ok(context, clast_clas_instantiate(t->pool, 0, count, inputs));
    assert_ok(context, clast_blas_build(t->blas, NULL, count, CLAST_BUILD_BEST));
    instance.blas = t->blas;
    assert_ok(context, clast_tlas_build(t->tlas, &instance, 1, CLAST_BUILD_BEST));
    clast_tlas_bounds(t->tlas, t->lower, t->upper);
    free(descs);
    free(inputs);
}

static void free_ours(trial *t)
{
    clast_tlas_destroy(t->tlas);
    clast_blas_destroy(t->blas);
    clast_clas_pool_destroy(t->pool);
    clast_template_set_destroy(t->set);
    clast_clusters_free(t->context, &t->clusters);
    free(t->vertices);
}

// From somewhere in and around the box, to a point of the surface, near it, or anywhere.
static clast_ray random_ray(const trial *t, randoms *r)
{
    clast_ray ray = {.t_max = INFINITY};
    uint32_t kind = random_below(r, 4);
    const uint32_t *corner = t->m.indices + 3 * (size_t)random_below(r, t->m.triangle_count);
    float u = random_float(r), v = random_float(r) * (1.0f - u);
    for (uint32_t axis = 0; axis < 3; axis++) {
        float size = t->upper[axis] - t->lower[axis];
        float a = t->m.positions[3 * (size_t)corner[0] + axis], b = t->m.positions[3 * (size_t)corner[1] + axis];
        float c = t->m.positions[3 * (size_t)corner[2] + axis], on = a + u * (b - a) + v * (c - a);
        ray.origin[axis] = t->lower[axis] + size * random_between(r, -0.5f, 1.5f);
        ray.direction[axis] = on - ray.origin[axis];
        if (kind == 0) {
            ray.direction[axis] = random_between(r, -1, 1);
        } else if (kind == 1) { // from near the surface
            ray.origin[axis] = on + 0.01f * size * random_between(r, -1, 1);
            ray.direction[axis] = random_between(r, -1, 1);
        }
    }
    return ray;
}

static void compare_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    trial *t = data;
    agreement *a = &t->agreements[begin / CHUNK];
    randoms r = {begin};
    for (int axis = 0; axis < 3; axis++) {
        a->scale = fmaxf(a->scale, 2.0f * fmaxf(fabsf(t->lower[axis]), fabsf(t->upper[axis])));
    }
    for (size_t i = begin; i < end; i++) {
        clast_ray ray = random_ray(t, &r);
        clast_hit hit;
        clast_trace_closest(t->tlas, &ray, 1, NULL, &hit);
        struct RTCRayHit expected = embree_closest(t->theirs.scene, &ray, false);
        uint32_t triangle = CLAST_NONE;
        if (hit.instance != CLAST_NONE) {
            triangle = t->clusters.triangles[t->clusters.clusters[hit.cluster].first_triangle + hit.triangle];
        }
        agreement_count(a, &ray, agreement_corners(&t->m, triangle), hit.t,
                        agreement_corners(&t->m, expected.hit.primID), expected.ray.tfar);
    }
}

static void try_model(clast_context *context, RTCDevice device, const char *path)
{
    clast_scene *scene;
    clast_status status = clast_scene_load(context, path, &scene);
    if (status != CLAST_OK) {
        assert_int_equal(status, CLAST_ERROR_UNSUPPORTED); // its extension is named
        return;
    }
    trial *t = calloc(1, sizeof *t);
    t->context = context;
    t->m = mesh_of(0, 0);
    for (size_t i = 0; i < scene->geometry_count; i++) {
        append_mesh(&t->m, &scene->geometries[i].of.mesh);
    }
    clast_scene_destroy(scene);
    if (t->m.triangle_count > 0) {
        build_ours(t);
        t->theirs = embree_mesh_make(device, t->m.positions, t->m.vertex_count, t->m.indices, t->m.triangle_count,
                                     RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_ROBUST);
        clast_parallel_for(context, RAYS, CHUNK, compare_range, t);
        agreement sum = {0};
        for (int i = 0; i < RAYS / CHUNK; i++) {
            sum.hits += t->agreements[i].hits;
            sum.ties += t->agreements[i].ties;
            sum.wrong += t->agreements[i].wrong;
        }
        printf("%s: %u triangles, %llu hits, %llu ties, %llu wrong\n", path, t->m.triangle_count,
               (unsigned long long)sum.hits, (unsigned long long)sum.ties, (unsigned long long)sum.wrong);
        assert_true(sum.hits > RAYS / 4);
        assert_int_equal(sum.wrong, 0);
        rtcReleaseScene(t->theirs.scene);
        free_ours(t);
    }
    mesh_free(&t->m);
    free(t);
}

static void try_folder(clast_context *context, RTCDevice device, const char *folder)
{
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    for (struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        char path[1024], extension[8];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        clast_path_extension(path, extension, sizeof extension);
        if (entry->d_name[0] == '.') {
            continue;
        }
        if (clast_path_is_folder(path)) {
            try_folder(context, device, path);
        } else if (strcmp(extension, "gltf") == 0 || strcmp(extension, "glb") == 0 || strcmp(extension, "obj") == 0 ||
                   strcmp(extension, "ply") == 0) {
            try_model(context, device, path);
        }
    }
    closedir(entries);
}

static void models_are_hit_as_embree_hits_them(void **state)
{
    const char *folders[] = {"dense", "gltf-models", "terrain"};
    RTCDevice device = rtcNewDevice(NULL);
    for (int i = 0; i < 3; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", test_assets(), folders[i]);
        if (clast_path_is_folder(path)) {
            try_folder(*state, device, path);
        }
    }
    rtcReleaseDevice(device);
}

int main(void)
{
    test_assets();
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(models_are_hit_as_embree_hits_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
