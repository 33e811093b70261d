// SPDX-License-Identifier: Apache-2.0
// Many instances of one mesh, which move: all of 10,000, and one in a hundred of 1,000,000. Embree builds its scene of
// instances anew, its fastest way; that a moved instance is told to it belongs to it, as it does on our side.
#include <stdio.h>

#include "accel_job.h"
#include "base/context.h"
#include "base/thread.h"

enum { MESH_TRIANGLES = 20000, INSTANCE_GRAIN = 64 };

typedef struct crowd {
    accel_job *job;
    clast_tlas_instance *instances; // all
    uint32_t count;
    uint32_t *numbers; // of those that move in this frame
    clast_tlas_instance *moved;
    uint32_t moved_count;
    clast_tlas *tlas;
    RTCScene scene;
    RTCGeometry *geometries;
    bool dynamic;  // which of Embree's scenes commits faster
    bool rebuilds; // ours builds anew, instead of keeping the tree
    randoms r;
} crowd;

static void place(crowd *c, uint32_t number, float room)
{
    clast_tlas_instance *instance = &c->instances[number];
    float turn = random_between(&c->r, 0.0f, 6.2831853f), scale = random_between(&c->r, 0.5f, 1.5f);
    *instance = instance_of(c->job->ours.blas, number);
    instance->transform[0][0] = instance->transform[1][1] = scale * cosf(turn);
    instance->transform[0][1] = -(instance->transform[1][0] = scale * sinf(turn));
    instance->transform[2][2] = scale;
    for (int axis = 0; axis < 3; axis++) {
        instance->transform[axis][3] = room * random_float(&c->r);
    }
}

// Those that move take a step as long as a part of their size. Where not all do, they are scattered.
static void move(crowd *c)
{
    uint32_t apart = c->count / c->moved_count;
    for (uint32_t i = 0; i < c->moved_count; i++) {
        uint32_t number = i * apart + random_below(&c->r, apart);
        clast_tlas_instance *instance = &c->instances[number];
        for (int axis = 0; axis < 3; axis++) {
            instance->transform[axis][3] += random_between(&c->r, -0.1f, 0.1f);
        }
        c->numbers[i] = number;
        c->moved[i] = *instance;
    }
}

static double update_ours(void *data)
{
    crowd *c = data;
    move(c);
    double begun = bench_seconds();
    if (c->rebuilds) {
        bench_check(clast_tlas_build(c->tlas, c->instances, c->count, CLAST_BUILD_FAST), c->job->context);
    } else {
        bench_check(clast_tlas_update(c->tlas, c->numbers, c->moved, c->moved_count), c->job->context);
    }
    return bench_seconds() - begun;
}

static void tell_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    crowd *c = data;
    for (size_t i = begin; i < end; i++) {
        RTCGeometry geometry = c->geometries[c->numbers[i]];
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, c->moved[i].transform);
        rtcCommitGeometry(geometry);
    }
}

static double update_theirs(void *data)
{
    crowd *c = data;
    move(c);
    double begun = bench_seconds();
    clast_parallel_for(c->job->context, c->moved_count, INSTANCE_GRAIN, tell_range, c);
    rtcCommitScene(c->scene);
    return bench_seconds() - begun;
}

static void build_scene(crowd *c, RTCScene mesh, enum RTCSceneFlags flags)
{
    c->scene = rtcNewScene(c->job->devices[0]);
    rtcSetSceneFlags(c->scene, flags);
    rtcSetSceneBuildQuality(c->scene, RTC_BUILD_QUALITY_LOW);
    for (uint32_t i = 0; i < c->count; i++) {
        RTCGeometry geometry = rtcNewGeometry(c->job->devices[0], RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, mesh);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, c->instances[i].transform);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(c->scene, geometry, i);
        rtcReleaseGeometry(geometry); // the scene keeps it
        c->geometries[i] = geometry;
    }
    rtcCommitScene(c->scene);
}

// Embree's scene as static or dynamic, whichever commits faster.
static void choose_scene(crowd *c, RTCScene mesh)
{
    build_scene(c, mesh, RTC_SCENE_FLAG_NONE);
    RTCScene kept = c->scene;
    double seconds = update_theirs(c);
    RTCGeometry *geometries = c->geometries;
    c->geometries = bench_allocate(c->count, sizeof(RTCGeometry));
    build_scene(c, mesh, RTC_SCENE_FLAG_DYNAMIC);
    c->dynamic = update_theirs(c) < seconds;
    if (c->dynamic) {
        rtcReleaseScene(kept);
        free(geometries);
        return;
    }
    rtcReleaseScene(c->scene);
    free(c->geometries);
    c->scene = kept;
    c->geometries = geometries;
    tell_range(c, 0, c->moved_count, 0); // what it has not heard of
    rtcCommitScene(c->scene);
}

static void check_hits(crowd *c, const char *metric)
{
    accel_job *j = c->job;
    bench_check(clast_tlas_build(c->tlas, c->instances, c->count, CLAST_BUILD_BEST), j->context);
    clast_tlas *kept = j->ours.tlas;
    j->ours.tlas = c->tlas;
    j->theirs.scene = c->scene;
    accel_check_hits(j, metric);
    j->ours.tlas = kept;
}

static void measure(crowd *c, const char *metric, const char *peer)
{
    bench_pair seconds = bench_alternate(c->job->b, update_ours, update_theirs, c);
    accel_add_row(c->job, metric, "ms", peer, (bench_pair){1e3 * seconds.clast, 1e3 * seconds.peer});
}

static void measure_crowd(accel_job *j, uint32_t count, uint32_t moved, const char *metric)
{
    crowd c = {.job = j, .count = count, .moved_count = moved, .r = {3}};
    float side = 1.5f * cbrtf((float)count);
    c.instances = bench_allocate(count, sizeof *c.instances);
    c.moved = bench_allocate(moved, sizeof *c.moved);
    c.numbers = bench_allocate(moved, sizeof *c.numbers);
    c.geometries = bench_allocate(count, sizeof(RTCGeometry));
    for (uint32_t i = 0; i < count; i++) {
        place(&c, i, side);
    }
    bench_check(clast_tlas_create(j->context, &c.tlas), j->context);
    bench_check(clast_tlas_build(c.tlas, c.instances, count, CLAST_BUILD_BEST), j->context);
    peer mesh = peer_make(j->devices[0], j->work, j->work->m.positions, PEER_SAH);
    choose_scene(&c, mesh.scene);
    const char *kind = c.dynamic ? "dynamic" : "static";
    measure(&c, metric, kind);
    if (moved == count) { // and beside it, built anew as Embree does
        c.rebuilds = true;
        kind = c.dynamic ? "dynamic; built anew" : "static; built anew";
        measure(&c, metric, kind);
    }
    check_hits(&c, metric);
    rtcReleaseScene(c.scene);
    peer_free(&mesh);
    clast_tlas_destroy(c.tlas);
    free(c.instances);
    free(c.moved);
    free(c.numbers);
    free(c.geometries);
}

void accel_measure_instances(bench *b, uint32_t threads, bool all)
{
    workload w = workload_surface(SURFACE_SPHERE, MESH_TRIANGLES);
    accel_job j = accel_job_begin(b, &w, false, threads);
    snprintf(w.name, sizeof w.name, "10,000 instances");
    for (int axis = 0; axis < 3; axis++) {
        w.eye[axis] = -10.0f;
        w.target[axis] = 10.0f;
    }
    measure_crowd(&j, 10000, 10000, "tlas_update");
    snprintf(w.name, sizeof w.name, "1,000,000 instances");
    if (all) {
        measure_crowd(&j, 1000000, 10000, "tlas_partial");
    }
    accel_job_end(&j);
    workload_free(&w);
}
