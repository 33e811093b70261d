// SPDX-License-Identifier: Apache-2.0
#include "accel_structures.h"

#include <stdatomic.h>
#include <stdio.h>

#include "base/context.h"
#include "base/thread.h"

enum { GATHER_GRAIN = 4096 };

// ------------------------------------------------------------------------------------------------------------- clast's

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

void structure_gather(clast_context *context, structure *s, const float *positions)
{
    gather_job g = {positions, s};
    clast_parallel_for(context, s->vertex_count, GATHER_GRAIN, gather_range, &g);
}

void structure_refit_gathered(clast_context *context, structure *s, const float *positions, size_t position_count)
{
    clast_clas_gather gather = {positions, position_count, s->sources, s->first_vertex, s->vertices};
    bench_check(clast_clas_refit_gathered(s->pool, 0, s->cluster_count, &gather), context);
    bench_check(clast_blas_refit(s->blas), context);
    structure_build_tlas(context, s);
}

void structure_build_tlas(clast_context *context, structure *s)
{
    clast_tlas_instance instance = instance_of(s->blas, 0);
    bench_check(clast_tlas_build(s->tlas, &instance, 1, CLAST_BUILD_BEST), context);
}

void structure_refit(clast_context *context, structure *s)
{
    bench_check(clast_clas_refit(s->pool, 0, s->cluster_count), context);
    bench_check(clast_blas_refit(s->blas), context);
    structure_build_tlas(context, s);
}

static void create_objects(clast_context *context, structure *s)
{
    bench_check(clast_template_set_create(context, &s->set), context);
    bench_check(clast_clas_pool_create(s->set, &s->pool), context);
    bench_check(clast_blas_create(s->pool, &s->blas), context);
    bench_check(clast_tlas_create(context, &s->tlas), context);
    s->vertices = clast_allocate(context, s->vertex_count, 12); // as an engine would: large pages where there are
    s->sources = bench_allocate(s->vertex_count, sizeof *s->sources);
    s->first_vertex = bench_allocate(s->cluster_count, sizeof *s->first_vertex);
    s->templates = bench_allocate(s->cluster_count, sizeof *s->templates);
}

void structure_instantiate(clast_context *context, structure *s)
{
    clast_clas_input *inputs = bench_allocate(s->cluster_count, sizeof *inputs);
    for (size_t i = 0; i < s->cluster_count; i++) {
        inputs[i] = (clast_clas_input){s->templates[i], s->vertices + 3 * (size_t)s->first_vertex[i]};
    }
    bench_check(clast_clas_instantiate(s->pool, 0, s->cluster_count, inputs), context);
    free(inputs);
    bench_check(clast_blas_build(s->blas, NULL, s->cluster_count, CLAST_BUILD_BEST), context);
    structure_build_tlas(context, s);
}

static void add_templates(clast_context *context, structure *s, const clast_clusters *clusters)
{
    clast_template_desc *descs = bench_allocate(s->cluster_count, sizeof *descs);
    for (size_t i = 0; i < s->cluster_count; i++) {
        const clast_cluster *c = &clusters->clusters[i];
        s->first_vertex[i] = c->first_vertex;
        descs[i] = (clast_template_desc){c->triangle_count, c->vertex_count,
                                         clusters->indices + 3 * (size_t)c->first_triangle, NULL};
    }
    s->first_vertex[s->cluster_count] = s->vertex_count;
    uint32_t first;
    bench_check(clast_template_set_add(s->set, descs, s->cluster_count, &first), context);
    for (uint32_t i = 0; i < s->cluster_count; i++) {
        s->templates[i] = first + i;
    }
    free(descs);
}

structure structure_of_clusters(clast_context *context, const workload *w)
{
    clast_clusters clusters;
    double begun = bench_seconds();
    clast_clusterize_desc desc = {.positions = w->m.positions,
                                  .position_count = w->m.vertex_count,
                                  .indices = w->m.indices,
                                  .triangle_count = w->m.triangle_count};
    bench_check(clast_clusterize(context, &desc, &clusters), context);
    structure s = {.vertex_count = (uint32_t)clusters.vertex_count, .cluster_count = (uint32_t)clusters.cluster_count};
    create_objects(context, &s);
    memcpy(s.sources, clusters.vertices, s.vertex_count * sizeof *s.sources);
    structure_gather(context, &s, w->m.positions);
    add_templates(context, &s, &clusters);
    structure_instantiate(context, &s);
    clast_clusters_free(context, &clusters);
    s.build_seconds = bench_seconds() - begun;
    return s;
}

structure structure_of_grids(clast_context *context, const workload *w)
{
    uint32_t tiles = w->sheet_count * w->sheet_tiles * w->sheet_tiles, side = w->sheet_tiles * TILE_QUADS + 1;
    double begun = bench_seconds();
    structure s = {.vertex_count = tiles * TILE_VERTICES, .cluster_count = tiles};
    create_objects(context, &s);
    uint32_t number, *source = s.sources;
    bench_check(clast_template_set_add_grid(s.set, TILE_QUADS, TILE_QUADS, &number), context);
    for (uint32_t tile = 0; tile < tiles; tile++) {
        uint32_t sheet = tile / (w->sheet_tiles * w->sheet_tiles), column = tile % w->sheet_tiles,
                 row = tile / w->sheet_tiles % w->sheet_tiles;
        s.first_vertex[tile] = tile * TILE_VERTICES;
        s.templates[tile] = number;
        for (uint32_t v = 0; v < TILE_VERTICES; v++) {
            *source++ = (sheet * side + row * TILE_QUADS + v / (TILE_QUADS + 1)) * side + column * TILE_QUADS +
                        v % (TILE_QUADS + 1);
        }
    }
    s.first_vertex[tiles] = s.vertex_count;
    structure_gather(context, &s, w->m.positions);
    structure_instantiate(context, &s);
    s.build_seconds = bench_seconds() - begun;
    return s;
}

void structure_free(clast_context *context, structure *s)
{
    clast_tlas_destroy(s->tlas);
    clast_blas_destroy(s->blas);
    clast_clas_pool_destroy(s->pool);
    clast_template_set_destroy(s->set);
    clast_free(context, s->vertices);
    free(s->sources);
    free(s->first_vertex);
    free(s->templates);
}

double structure_bytes(const structure *s)
{
    return (double)(clast_template_set_bytes(s->set) + clast_clas_pool_bytes(s->pool) + clast_blas_bytes(s->blas) +
                    clast_tlas_bytes(s->tlas)) +
           12.0 * (double)s->vertex_count;
}

// ------------------------------------------------------------------------------------------------------------- Embree's

static atomic_int_fast64_t peer_memory;

static bool count_memory(void *user, ssize_t bytes, bool post)
{
    (void)user;
    (void)post;
    atomic_fetch_add(&peer_memory, bytes);
    return true;
}

RTCDevice peer_device(uint32_t threads, uint32_t number)
{
    char config[96];
    snprintf(config, sizeof config, "threads=%u,start_threads=1%s", threads,
             number != 0 ? ",frequency_level=simd512" : "");
    RTCDevice device = rtcNewDevice(config);
    if (device == NULL) {
        fprintf(stderr, "Embree does not start\n");
        exit(1);
    }
    rtcSetDeviceMemoryMonitorFunction(device, count_memory, NULL);
    return device;
}

static RTCGeometry make_triangles(RTCDevice device, const workload *w, const float *positions)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12,
                               w->m.vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, w->m.indices, 0, 12,
                               w->m.triangle_count);
    return geometry;
}

// Tiles point into the sheets: no vertex is stored twice.
static RTCGeometry make_grids(RTCDevice device, const workload *w, const float *positions)
{
    uint32_t tiles = w->sheet_count * w->sheet_tiles * w->sheet_tiles, side = w->sheet_tiles * TILE_QUADS + 1;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12,
                               w->m.vertex_count);
    struct RTCGrid *grids = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof *grids,
                                                    tiles);
    for (uint32_t tile = 0; tile < tiles; tile++) {
        uint32_t sheet = tile / (w->sheet_tiles * w->sheet_tiles), column = tile % w->sheet_tiles,
                 row = tile / w->sheet_tiles % w->sheet_tiles;
        grids[tile] = (struct RTCGrid){(sheet * side + row * TILE_QUADS) * side + column * TILE_QUADS, side,
                                       TILE_QUADS + 1, TILE_QUADS + 1};
    }
    return geometry;
}

static enum RTCBuildQuality quality_of(peer_kind kind)
{
    return kind == PEER_SAH || kind == PEER_SAH_DYNAMIC || kind == PEER_ROBUST ? RTC_BUILD_QUALITY_MEDIUM
           : kind == PEER_REFIT                                                ? RTC_BUILD_QUALITY_REFIT
                                                                               : RTC_BUILD_QUALITY_LOW;
}

peer peer_make(RTCDevice device, const workload *w, const float *positions, peer_kind kind)
{
    bool grids = kind == PEER_GRIDS || kind == PEER_GRIDS_DYNAMIC;
    bool dynamic = kind == PEER_REFIT || kind == PEER_SAH_DYNAMIC || kind == PEER_FAST_DYNAMIC ||
                   kind == PEER_GRIDS_DYNAMIC;
    enum RTCBuildQuality quality = quality_of(kind);
    int_fast64_t before = atomic_load(&peer_memory);
    peer p = {.scene = rtcNewScene(device)};
    p.geometry = grids ? make_grids(device, w, positions) : make_triangles(device, w, positions);
    rtcSetSceneFlags(p.scene, (dynamic ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE) |
                                  (kind == PEER_ROBUST ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE));
    rtcSetSceneBuildQuality(p.scene, kind == PEER_REFIT ? RTC_BUILD_QUALITY_LOW : quality);
    rtcSetGeometryBuildQuality(p.geometry, quality);
    rtcCommitGeometry(p.geometry);
    rtcAttachGeometry(p.scene, p.geometry);
    rtcReleaseGeometry(p.geometry); // the scene keeps it
    rtcCommitScene(p.scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
        fprintf(stderr, "%s: Embree fails\n", w->name);
        exit(1);
    }
    p.bytes = (double)(atomic_load(&peer_memory) - before) + 12.0 * (double)w->m.vertex_count +
              (grids ? 0.0 : 12.0 * (double)w->m.triangle_count); // of grids the buffer is Embree's own
    return p;
}

void peer_commit(peer *p)
{
    rtcUpdateGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(p->geometry);
    rtcCommitScene(p->scene);
}

void peer_free(peer *p)
{
    rtcReleaseScene(p->scene);
    *p = (peer){0};
}
