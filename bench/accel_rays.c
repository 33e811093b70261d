// SPDX-License-Identifier: Apache-2.0
// Rays after a mild motion: clast's templates and trees are those of the shape at rest, refitted; Embree's tree is built on
// the shape as it is.
#include "accel_rays.h"

#include <stdio.h>

#include "accel_job.h"

enum { VIEW_TILE = 8 };

static void normalise(float v[3])
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int axis = 0; axis < 3; axis++) {
        v[axis] /= length;
    }
}

// The pixel of ray i: tiles of 8 x 8, and in a tile bits of x and y in turns, so that any run of rays is compact.
static void pixel_of(size_t i, size_t width, size_t *x, size_t *y)
{
    size_t tile = i / (VIEW_TILE * VIEW_TILE), within = i % (VIEW_TILE * VIEW_TILE);
    *x = tile % (width / VIEW_TILE) * VIEW_TILE;
    *y = tile / (width / VIEW_TILE) * VIEW_TILE;
    for (int bit = 0; bit < 3; bit++) {
        *x += (within >> (2 * bit) & 1) << bit;
        *y += (within >> (2 * bit + 1) & 1) << bit;
    }
}

void accel_camera_rays(accel_job *j)
{
    const workload *w = j->work;
    size_t count = accel_job_rays(j), height = 256;
    while (2 * height * height < count) {
        height *= 2;
    }
    size_t width = count / height;
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
    for (size_t i = 0; i < count; i++) {
        size_t column, row;
        pixel_of(i, width, &column, &row);
        float x = 2.0f * ((float)column + 0.5f) / (float)width - 1.0f;
        float y = 0.5f - ((float)row + 0.5f) / (float)height;
        clast_ray *ray = &j->rays[i];
        *ray = (clast_ray){.t_max = INFINITY};
        for (int axis = 0; axis < 3; axis++) {
            ray->origin[axis] = w->eye[axis];
            ray->direction[axis] = forward[axis] + 0.7f * x * right[axis] + 0.7f * y * up[axis];
        }
        normalise(ray->direction);
    }
    j->ray_count = count;
}

// With the cosine's distribution, on the side where the ray came from.
void accel_bounce_rays(accel_job *j)
{
    randoms r = {1};
    size_t count = 0;
    for (size_t i = 0; i < j->ray_count; i++) {
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

static ray_run run_of(accel_job *j)
{
    return (ray_run){.context = j->context,
                     .ours = j->ours.tlas,
                     .theirs = {j->theirs.scene, j->wide.scene},
                     .rays = j->rays,
                     .count = j->ray_count,
                     .batch = 1,
                     .hits = j->hits};
}

void accel_trace_hits(accel_job *j)
{
    ray_run run = run_of(j);
    ray_run_ours(&run);
}

static void check_found(const accel_job *j, const ray_run *run, const char *metric)
{
    double ours = (double)run->found[0], theirs = (double)run->found[1];
    if (fabs(ours - theirs) > 1e-3 * theirs + 8.0) { // its fast mode leaks, and rays graze rims
        fprintf(stderr, "%s, %s: %.0f rays hit, Embree has %.0f\n", j->work->name, metric, ours, theirs);
        exit(1);
    }
}

void accel_check_hits(accel_job *j, const char *metric)
{
    accel_camera_rays(j);
    ray_run run = run_of(j);
    run.rays += run.count / 8 * 3;
    run.count = run.count / 16;
    ray_run_ours(&run);
    ray_run_theirs(&run);
    check_found(j, &run, metric);
    ray_run_free(&run);
}

static void measure(accel_job *j, const char *metric, const char *peer_detail, bool any, bool single)
{
    ray_run run = run_of(j);
    char name[BENCH_NAME_SIZE];
    run.any = any;
    ray_run_choose_way(&run, single);
    if (!single) {
        ray_run_choose_batch(&run);
    }
    run.found[0] = run.found[1] = 0;
    bench_pair seconds = bench_alternate(j->b, ray_run_ours, ray_run_theirs, &run);
    double rate = 1e-6 * (double)run.count;
    peer_way_name(run.way, any, name);
    check_found(j, &run, metric);
    accel_add_row(j, metric, "Mrays/s", peer_detail != NULL ? peer_detail : name,
                  (bench_pair){rate / seconds.clast, rate / seconds.peer});
    ray_run_free(&run);
}

void accel_measure_diffuse(accel_job *j, const char *metric, const char *peer_detail)
{
    measure(j, metric, peer_detail, false, true);
}

void accel_measure_rays(accel_job *j)
{
    workload_wave(j->context, j->work, 0.9f, j->moved);
    structure_gather(j->context, &j->ours, j->moved);
    structure_refit(j->context, &j->ours);
    accel_make_peers(j, PEER_SAH);
    accel_camera_rays(j);
    measure(j, "primary_single", NULL, false, true);
    measure(j, "primary_batch", NULL, false, false);
    accel_bounce_rays(j);
    measure(j, "diffuse_single", NULL, false, true);
    measure(j, "diffuse_batch", NULL, false, false);
    for (size_t i = 0; i < j->ray_count; i++) {
        j->rays[i].t_max = 0.1f * j->work->size;
    }
    measure(j, "anyhit_single", NULL, true, true);
    for (size_t i = 0; i < j->ray_count; i++) {
        j->rays[i].t_max = INFINITY;
    }
    accel_free_peers(j);
    accel_make_peers(j, PEER_ROBUST);
    measure(j, "diffuse_vs_robust", "robust", false, true);
    accel_free_peers(j);
}
