// SPDX-License-Identifier: Apache-2.0
// Building and tracing beside Embree, on the same meshes and the same rays.
//
//   build_static        from an indexed mesh to where rays can be traced: clusters, templates, boxes, trees; Embree's default build
//   refit_vs_refit      all vertices moved: gathered into clusters, boxes and tree refitted; Embree's refit
//   primary_single      a camera's rays, one by one; Embree's default scene
//   diffuse_single      one bounce from each of their hits
//   anyhit_single       from the same points in the same directions, up to a tenth of the scene's size
//   bytes_per_triangle  what the structures hold, vertices of clusters included; Embree's with the mesh's vertices and indices
//
// Meshes: a displaced sphere seen from inside, a terrain seen from above, and, where CLAST_ASSETS names a folder, its scans.
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/meshes.h"
#include "base/context.h"
#include "base/thread.h"
#include "bench.h"
#include "clast/clast.h"
#include "embree.h"
#include "scene/scene.h"

enum { WIDTH = 1024, HEIGHT = 512, RAYS = WIDTH * HEIGHT, RAY_GRAIN = 1024, GATHER_GRAIN = 4096 };

typedef struct workload {
    const char *name;
    mesh m; // one vertex to spare
    float eye[3], target[3];
    float size;
} workload;

// A mesh's clast side: all that an engine would keep.
typedef struct structure {
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_tlas *tlas;
    float *vertices;
    uint32_t *sources;
    size_t vertex_count;
    size_t cluster_count;
    double build_seconds;
} structure;

typedef struct job {
    clast_context *context;
    RTCDevice device;
    const workload *work;
    structure ours;
    embree_mesh theirs;
    clast_ray *rays;
    size_t ray_count;
    bool any, coherent;
    clast_hit *hits;
    atomic_uint_fast64_t found[2];
    float *moved; // the mesh's vertices at another moment
} job;

static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(context));
        exit(1);
    }
}

// ----------------------------------------------------------------------------------------------------------- workloads

static float height_at(float x, float y)
{
    float height = 0.0f, size = 0.11f, frequency = 7.0f;
    for (int i = 0; i < 7; i++) {
        height += size * sinf(frequency * x + 1.7f * (float)i) * cosf(frequency * 0.93f * y + 0.6f * (float)i);
        size *= 0.5f;
        frequency *= 2.1f;
    }
    return height;
}

static workload make_sphere(uint32_t triangles)
{
    uint32_t rows = (uint32_t)sqrt((double)triangles / 4.0);
    workload w = {
        .name = "displaced sphere", .m = mesh_sphere(2 * rows, rows + 1), .target = {1, 0.2f, 0.1f}, .size = 2.0f};
    for (uint32_t i = 0; i < w.m.vertex_count; i++) {
        float *p = w.m.positions + 3 * (size_t)i;
        float factor = 1.0f + 0.4f * height_at(4.0f * p[0] + p[2], 4.0f * p[1] - p[2]);
        for (int axis = 0; axis < 3; axis++) {
            p[axis] *= factor;
        }
    }
    return w;
}

static workload make_terrain(uint32_t triangles)
{
    workload w = {.name = "terrain",
                  .m = mesh_terrain((uint32_t)sqrt((double)triangles / 2.0), 0.0f, 1),
                  .eye = {-0.1f, -0.1f, 0.35f},
                  .target = {0.6f, 0.6f, 0.0f},
                  .size = 1.0f};
    for (uint32_t i = 0; i < w.m.vertex_count; i++) {
        float *p = w.m.positions + 3 * (size_t)i;
        p[2] = height_at(p[0], p[1]);
    }
    return w;
}

static uint32_t append_mesh(workload *w, const clast_mesh *from)
{
    mesh grown = mesh_of(w->m.vertex_count + from->vertex_count, w->m.triangle_count + from->triangle_count);
    memcpy(grown.positions, w->m.positions, (size_t)w->m.vertex_count * 12);
    memcpy(grown.positions + 3 * (size_t)w->m.vertex_count, from->positions, (size_t)from->vertex_count * 12);
    memcpy(grown.indices, w->m.indices, (size_t)w->m.triangle_count * 12);
    for (size_t i = 0; i < 3 * (size_t)from->triangle_count; i++) {
        grown.indices[3 * (size_t)w->m.triangle_count + i] = w->m.vertex_count + from->indices[i];
    }
    mesh_free(&w->m);
    w->m = grown;
    return from->triangle_count;
}

// All meshes of a file, without their instances' transforms. No triangles where the file is not there.
static workload load_model(clast_context *context, const char *name)
{
    workload w = {.name = name, .m = mesh_of(0, 0)};
    char path[1024];
    clast_scene *scene;
    snprintf(path, sizeof path, "%s/dense/%s", getenv("CLAST_ASSETS") != NULL ? getenv("CLAST_ASSETS") : ".", name);
    if (getenv("CLAST_ASSETS") == NULL || clast_scene_load(context, path, &scene) != CLAST_OK) {
        return w;
    }
    for (size_t i = 0; i < scene->geometry_count; i++) {
        if (scene->geometries[i].kind == CLAST_SOURCE_CLUSTERS) {
            append_mesh(&w, &scene->geometries[i].of.mesh);
        }
    }
    clast_scene_destroy(scene);
    float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * (size_t)w.m.vertex_count; i++) {
        lower[i % 3] = fminf(lower[i % 3], w.m.positions[i]);
        upper[i % 3] = fmaxf(upper[i % 3], w.m.positions[i]);
    }
    for (int axis = 0; axis < 3; axis++) {
        w.size = fmaxf(w.size, upper[axis] - lower[axis]);
    }
    for (int axis = 0; axis < 3; axis++) {
        w.target[axis] = 0.5f * (lower[axis] + upper[axis]);
        w.eye[axis] = w.target[axis] + w.size * (axis == 2 ? 0.9f : 0.5f);
    }
    return w;
}

// ----------------------------------------------------------------------------------------------------------- structures

typedef struct gather_job {
    const float *positions;
    structure *s;
} gather_job;

static void gather_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    gather_job *g = data;
    for (size_t i = begin; i < end; i++) {
        memcpy(g->s->vertices + 3 * i, g->positions + 3 * (size_t)g->s->sources[i], 12);
    }
}

static void gather(clast_context *context, structure *s, const float *positions)
{
    gather_job g = {positions, s};
    clast_parallel_for(context, s->vertex_count, GATHER_GRAIN, gather_range, &g);
}

static void fill_structure(clast_context *context, structure *s, const clast_clusters *clusters)
{
    clast_template_desc *descs = calloc(clusters->cluster_count, sizeof *descs);
    clast_clas_input *inputs = calloc(clusters->cluster_count, sizeof *inputs);
    for (size_t i = 0; i < clusters->cluster_count; i++) {
        const clast_cluster *c = &clusters->clusters[i];
        float *vertices = s->vertices + 3 * (size_t)c->first_vertex;
        descs[i] = (clast_template_desc){c->triangle_count, c->vertex_count,
                                         clusters->indices + 3 * (size_t)c->first_triangle, vertices};
        inputs[i].vertices = vertices;
    }
    uint32_t first;
    check(clast_template_set_add(s->set, descs, clusters->cluster_count, &first), context);
    for (size_t i = 0; i < clusters->cluster_count; i++) {
        inputs[i].template_number = first + (uint32_t)i;
    }
    check(clast_clas_instantiate(s->pool, 0, clusters->cluster_count, inputs), context);
    free(descs);
    free(inputs);
}

static void build_tlas(clast_context *context, structure *s)
{
    clast_tlas_instance instance = instance_of(s->blas, 0);
    check(clast_tlas_build(s->tlas, &instance, 1, CLAST_BUILD_BEST), context);
}

static structure build_structure(clast_context *context, const workload *w)
{
    structure s = {0};
    clast_clusters clusters;
    double begun = bench_seconds();
    clast_clusterize_desc desc = {.positions = w->m.positions,
                                  .position_count = w->m.vertex_count,
                                  .indices = w->m.indices,
                                  .triangle_count = w->m.triangle_count};
    check(clast_clusterize(context, &desc, &clusters), context);
    s.vertex_count = clusters.vertex_count;
    s.cluster_count = clusters.cluster_count;
    s.sources = malloc(s.vertex_count * sizeof *s.sources);
    s.vertices = clast_allocate(context, s.vertex_count, 12); // as the renderer does
    memcpy(s.sources, clusters.vertices, s.vertex_count * sizeof *s.sources);
    gather(context, &s, w->m.positions);
    check(clast_template_set_create(context, &s.set), context);
    check(clast_clas_pool_create(s.set, &s.pool), context);
    check(clast_blas_create(s.pool, &s.blas), context);
    check(clast_tlas_create(context, &s.tlas), context);
    fill_structure(context, &s, &clusters);
    check(clast_blas_build(s.blas, NULL, s.cluster_count, CLAST_BUILD_BEST), context);
    build_tlas(context, &s);
    s.build_seconds = bench_seconds() - begun;
    clast_clusters_free(context, &clusters);
    return s;
}

static void free_structure(clast_context *context, structure *s)
{
    clast_tlas_destroy(s->tlas);
    clast_blas_destroy(s->blas);
    clast_clas_pool_destroy(s->pool);
    clast_template_set_destroy(s->set);
    clast_free(context, s->vertices);
    free(s->sources);
}

static embree_mesh build_embree(const job *j, enum RTCBuildQuality quality)
{
    const mesh *m = &j->work->m;
    bool refits = quality == RTC_BUILD_QUALITY_REFIT;
    return embree_mesh_make(j->device, refits ? j->moved : m->positions, m->vertex_count, m->indices, m->triangle_count,
                            quality, refits ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE);
}

// -------------------------------------------------------------------------------------------------------------- builds

static double build_ours(void *data)
{
    job *j = data;
    structure s = build_structure(j->context, j->work);
    double seconds = s.build_seconds;
    free_structure(j->context, &s);
    return 1e-6 * (double)j->work->m.triangle_count / seconds;
}

static double build_theirs(void *data)
{
    job *j = data;
    double begun = bench_seconds();
    embree_mesh built = build_embree(j, RTC_BUILD_QUALITY_MEDIUM);
    double seconds = bench_seconds() - begun;
    rtcReleaseScene(built.scene);
    return 1e-6 * (double)j->work->m.triangle_count / seconds;
}

static void move_vertices(job *j, float phase)
{
    const mesh *m = &j->work->m;
    for (size_t i = 0; i < 3 * (size_t)m->vertex_count; i++) {
        j->moved[i] = m->positions[i] +
                      0.002f * j->work->size * sinf(phase + 9.0f * m->positions[i / 3 * 3] / j->work->size);
    }
}

static double refit_ours(void *data)
{
    job *j = data;
    move_vertices(j, 1.0f);
    double begun = bench_seconds();
    gather(j->context, &j->ours, j->moved);
    check(clast_clas_refit(j->ours.pool, 0, j->ours.cluster_count), j->context);
    check(clast_blas_refit(j->ours.blas), j->context);
    build_tlas(j->context, &j->ours);
    return 1e-6 * (double)j->work->m.triangle_count / (bench_seconds() - begun);
}

static double refit_theirs(void *data)
{
    job *j = data;
    move_vertices(j, 2.0f);
    double begun = bench_seconds();
    rtcUpdateGeometryBuffer(j->theirs.geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(j->theirs.geometry);
    rtcCommitScene(j->theirs.scene);
    return 1e-6 * (double)j->work->m.triangle_count / (bench_seconds() - begun);
}

// ---------------------------------------------------------------------------------------------------------------- rays

static void trace_ours_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    job *j = data;
    uint64_t found = 0;
    for (size_t i = begin; i < end; i++) {
        if (j->any) {
            uint8_t occluded;
            clast_trace_any(j->ours.tlas, &j->rays[i], 1, NULL, &occluded);
            found += occluded;
        } else {
            clast_trace_closest(j->ours.tlas, &j->rays[i], 1, NULL, &j->hits[i]);
            found += j->hits[i].instance != CLAST_NONE;
        }
    }
    atomic_fetch_add(&j->found[0], found);
}

static void trace_theirs_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    job *j = data;
    uint64_t found = 0;
    for (size_t i = begin; i < end; i++) {
        found += j->any
                     ? embree_any(j->theirs.scene, &j->rays[i])
                     : embree_closest(j->theirs.scene, &j->rays[i], j->coherent).hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    atomic_fetch_add(&j->found[1], found);
}

static double trace_ours(void *data)
{
    job *j = data;
    double begun = bench_seconds();
    clast_parallel_for(j->context, j->ray_count, RAY_GRAIN, trace_ours_range, j);
    return 1e-6 * (double)j->ray_count / (bench_seconds() - begun);
}

static double trace_theirs(void *data)
{
    job *j = data;
    double begun = bench_seconds();
    clast_parallel_for(j->context, j->ray_count, RAY_GRAIN, trace_theirs_range, j);
    return 1e-6 * (double)j->ray_count / (bench_seconds() - begun);
}

static void normalise(float v[3])
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int axis = 0; axis < 3; axis++) {
        v[axis] /= length;
    }
}

static void camera_rays(job *j)
{
    const workload *w = j->work;
    float forward[3], right[3], up[3];
    for (int axis = 0; axis < 3; axis++) {
        forward[axis] = w->target[axis] - w->eye[axis];
    }
    normalise(forward);
    right[0] = forward[1];
    right[1] = -forward[0];
    right[2] = 0.0f;
    normalise(right);
    for (int axis = 0; axis < 3; axis++) {
        up[axis] = right[(axis + 1) % 3] * forward[(axis + 2) % 3] - right[(axis + 2) % 3] * forward[(axis + 1) % 3];
    }
    for (size_t i = 0; i < RAYS; i++) {
        clast_ray *ray = &j->rays[i];
        float x = 2.0f * ((float)(i % WIDTH) + 0.5f) / WIDTH - 1.0f, y = 0.5f - ((float)(i / WIDTH) + 0.5f) / HEIGHT;
        *ray = (clast_ray){.t_max = INFINITY};
        for (int axis = 0; axis < 3; axis++) {
            ray->origin[axis] = w->eye[axis];
            ray->direction[axis] = forward[axis] + 0.7f * x * right[axis] + 0.7f * y * up[axis];
        }
        normalise(ray->direction);
    }
    j->ray_count = RAYS;
}

// From each hit a ray with the cosine's distribution, on the side where the ray came from.
static void bounce_rays(job *j)
{
    randoms r = {1};
    size_t count = 0;
    for (size_t i = 0; i < RAYS; i++) {
        clast_hit hit = j->hits[i];
        clast_ray ray = j->rays[i], *bounce = &j->rays[count];
        if (hit.instance == CLAST_NONE) {
            continue;
        }
        normalise(hit.normal);
        float dot = hit.normal[0] * ray.direction[0] + hit.normal[1] * ray.direction[1] +
                    hit.normal[2] * ray.direction[2];
        float z = 2.0f * random_float(&r) - 1.0f, turn = 6.2831853f * random_float(&r), radius = sqrtf(1.0f - z * z);
        const float sphere[3] = {radius * cosf(turn), radius * sinf(turn), z};
        *bounce = (clast_ray){.t_min = 1e-5f * j->work->size, .t_max = INFINITY};
        for (int axis = 0; axis < 3; axis++) {
            bounce->origin[axis] = ray.origin[axis] + hit.t * ray.direction[axis];
            bounce->direction[axis] = (dot > 0.0f ? -hit.normal[axis] : hit.normal[axis]) * 1.0001f + sphere[axis];
        }
        normalise(bounce->direction);
        count++;
    }
    j->ray_count = count;
}

// ---------------------------------------------------------------------------------------------------------------- all

static void add_row(bench *b, const job *j, uint32_t threads, const char *metric, const char *unit, bench_pair values)
{
    bench_row row = {.triangles = j->work->m.triangle_count,
                     .threads = threads,
                     .metric = metric,
                     .unit = unit,
                     .less_is_better = strcmp(unit, "bytes") == 0,
                     .clast = values.clast,
                     .peer = "Embree " RTC_VERSION_STRING,
                     .peer_value = values.peer};
    snprintf(row.workload, sizeof row.workload, "%s", j->work->name);
    bench_add(b, row);
}

static atomic_int_fast64_t embree_bytes;

static bool count_bytes(void *user, ssize_t bytes, bool post)
{
    (void)user;
    (void)post;
    atomic_fetch_add(&embree_bytes, bytes);
    return true;
}

static void measure_bytes(bench *b, const job *j, uint32_t threads)
{
    const mesh *m = &j->work->m;
    double ours = (double)(clast_template_set_bytes(j->ours.set) + clast_clas_pool_bytes(j->ours.pool) +
                           clast_blas_bytes(j->ours.blas) + clast_tlas_bytes(j->ours.tlas)) +
                  12.0 * (double)j->ours.vertex_count;
    double theirs = (double)atomic_load(&embree_bytes) + 12.0 * (double)m->vertex_count +
                    12.0 * (double)m->triangle_count;
    add_row(b, j, threads, "bytes_per_triangle", "bytes",
            (bench_pair){ours / (double)m->triangle_count, theirs / (double)m->triangle_count});
}

static void measure_rays(bench *b, job *j, uint32_t threads)
{
    camera_rays(j);
    j->any = false;
    j->coherent = true;
    add_row(b, j, threads, "primary_single", "Mrays/s", bench_alternate(b, trace_ours, trace_theirs, j));
    bounce_rays(j);
    j->coherent = false;
    add_row(b, j, threads, "diffuse_single", "Mrays/s", bench_alternate(b, trace_ours, trace_theirs, j));
    for (size_t i = 0; i < j->ray_count; i++) {
        j->rays[i].t_max = 0.1f * j->work->size;
    }
    j->any = true;
    add_row(b, j, threads, "anyhit_single", "Mrays/s", bench_alternate(b, trace_ours, trace_theirs, j));
    double ours = (double)atomic_load(&j->found[0]), theirs = (double)atomic_load(&j->found[1]);
    if (fabs(ours - theirs) > 1e-3 * theirs) {
        fprintf(stderr, "%s: %.0f hits, Embree has %.0f\n", j->work->name, ours, theirs);
        exit(1);
    }
}

static void measure(bench *b, const workload *w, uint32_t threads)
{
    job j = {.work = w};
    char config[64];
    snprintf(config, sizeof config, "threads=%u", threads);
    check(clast_context_create(&(clast_context_desc){.threads = threads}, &j.context), j.context);
    j.device = rtcNewDevice(config);
    j.rays = malloc(RAYS * sizeof *j.rays);
    j.hits = malloc(RAYS * sizeof *j.hits);
    j.moved = calloc((size_t)w->m.vertex_count + 1, 12);
    add_row(b, &j, threads, "build_static", "Mtri/s", bench_alternate(b, build_ours, build_theirs, &j));
    j.ours = build_structure(j.context, w);
    atomic_store(&embree_bytes, 0);
    rtcSetDeviceMemoryMonitorFunction(j.device, count_bytes, NULL);
    j.theirs = build_embree(&j, RTC_BUILD_QUALITY_MEDIUM);
    measure_bytes(b, &j, threads);
    rtcSetDeviceMemoryMonitorFunction(j.device, NULL, NULL);
    measure_rays(b, &j, threads);
    rtcReleaseScene(j.theirs.scene);
    move_vertices(&j, 0.0f);
    j.theirs = build_embree(&j, RTC_BUILD_QUALITY_REFIT);
    add_row(b, &j, threads, "refit_vs_refit", "Mtri/s", bench_alternate(b, refit_ours, refit_theirs, &j));
    rtcReleaseScene(j.theirs.scene);
    rtcReleaseDevice(j.device);
    free_structure(j.context, &j.ours);
    free(j.rays);
    free(j.hits);
    free(j.moved);
    clast_context_destroy(j.context);
}

static void measure_all(bench *b, workload w)
{
    for (uint32_t threads = 1; threads <= 2 && w.m.triangle_count > 0; threads++) {
        if (b->options.threads == 0 || threads == 1) {
            measure(b, &w, b->options.threads != 0 ? b->options.threads : threads);
        }
    }
    mesh_free(&w.m);
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "accel", count, arguments);
    uint32_t sizes[2] = {1000000, 4000000}, size_count = b.options.quick ? 1 : 2;
    if (b.options.triangles != 0) {
        sizes[0] = b.options.triangles;
        size_count = 1;
    }
    for (uint32_t i = 0; i < size_count; i++) {
        measure_all(&b, make_sphere(sizes[i]));
        measure_all(&b, make_terrain(sizes[i]));
    }
    if (!b.options.quick) {
        const char *models[] = {"lucy.ply", "bun_zipper.ply", "nefertiti-lowres.obj"};
        clast_context *context;
        check(clast_context_create(NULL, &context), context);
        for (int i = 0; i < 3; i++) {
            measure_all(&b, load_model(context, models[i]));
        }
        clast_context_destroy(context);
    }
    return bench_end(&b);
}
