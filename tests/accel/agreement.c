// SPDX-License-Identifier: Apache-2.0
// Compares hits and distances with Embree's robust mode on the same rays.
//
//   agreement [--rays N] [--seed S] [--threads T] [--triangles M]
//
// N rays for each workload: grids, real models (of the folder CLAST_ASSETS), and instances; from a camera, from surfaces into
// all directions, and from anywhere. Half of them go in batches. Rays may differ where two triangles are at the same distance,
// or an edge is passed within what floats can tell: those are ties (embree_agreement.h). Ends with a line
// `... wrong: W of N rays` and exits 1 where W > 0.
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>

#include "accel/watertight.h"
#include "base/thread.h"
#include "embree.h"
#include "embree_agreement.h"

enum { CHUNK = 1024, INSTANCES = 10000 };

typedef struct workload {
    const char *name;
    surface s;
    cluster_kind kind;
    uint32_t instance_count;
    clast_tlas_instance *instances;
    clusters c;
    clast_tlas *tlas;
    embree_mesh theirs;
    RTCScene scene;
    float *positions; // Embree's, with a float to spare
    float size;       // of the whole
} workload;

typedef struct run {
    clast_context *context;
    RTCDevice device;
    const workload *work;
    uint64_t rays, seed;
    atomic_uint_fast64_t hits, ties, wrong, theirs;
} run;

// ------------------------------------------------------------------------------------------------------------ workloads

static float height_at(float x, float y)
{
    float height = 0.0f, size = 0.1f, frequency = 6.0f;
    for (int i = 0; i < 6; i++) {
        height += size * sinf(frequency * x + 1.3f * (float)i) * cosf(frequency * 0.9f * y + 0.4f * (float)i);
        size *= 0.5f;
        frequency *= 2.1f;
    }
    return height;
}

static surface sheets_of(clast_context *context, const char *name, mesh m, uint32_t columns, uint32_t rows)
{
    surface s;
    surface_make(context, name, &m, &s); // need not be closed
    s.columns = columns;
    s.rows = rows;
    s.sheets = m.triangle_count / (2 * columns * rows);
    return s;
}

static surface make_sphere(clast_context *context, uint32_t triangles)
{
    uint32_t side = (uint32_t)sqrt((double)triangles / 12.0);
    mesh m = mesh_cube_sphere(side);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i;
        float factor = 1.0f + 0.4f * height_at(2.0f * p[0] + p[2], 2.0f * p[1] - p[2]);
        for (int axis = 0; axis < 3; axis++) {
            p[axis] *= factor;
        }
    }
    return sheets_of(context, "displaced sphere", m, side, side);
}

static surface make_terrain(clast_context *context, uint32_t triangles)
{
    uint32_t side = (uint32_t)sqrt((double)triangles / 2.0);
    mesh m = mesh_terrain(side, 0.0f, 1);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i;
        p[2] = height_at(p[0], p[1]);
    }
    return sheets_of(context, "terrain", m, side, side);
}

// Folded over itself many times.
static surface make_cloth(clast_context *context, uint32_t triangles)
{
    uint32_t side = (uint32_t)sqrt((double)triangles / 2.0);
    mesh m = mesh_terrain(side, 0.0f, 1);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i, x = p[0], y = p[1];
        p[0] = 0.3f * x + 0.2f * sinf(11.0f * x + 3.0f * y) + 0.02f * sinf(61.0f * y);
        p[1] = 0.4f * y + 0.15f * sinf(9.0f * y - 4.0f * x);
        p[2] = 0.25f * sinf(7.0f * x) * cosf(8.0f * y) + 0.01f * sinf(83.0f * x);
    }
    return sheets_of(context, "cloth", m, side, side);
}

// Turned, mirrored and stretched copies, side by side and in each other.
static clast_tlas_instance *make_instances(const clast_blas *blas, uint32_t count, uint64_t seed)
{
    clast_tlas_instance *instances = calloc(count, sizeof *instances);
    randoms r = {seed};
    for (uint32_t i = 0; i < count; i++) {
        instances[i] = instance_of(blas, i);
        for (uint32_t k = 0; k < 12 && count > 1; k++) {
            float place = k == 3 ? (float)(i % 100) : k == 7 ? (float)(i / 100) : 0.0f;
            float *element = &instances[i].transform[k / 4][k % 4];
            *element = k % 4 == 3 ? place + random_between(&r, -0.5f, 0.5f)
                                  : 0.4f * *element + random_between(&r, -0.2f, 0.2f);
        }
    }
    return instances;
}

static void place_theirs(run *r, workload *w)
{
    w->positions = calloc((size_t)w->s.m.vertex_count + 1, 12);
    memcpy(w->positions, w->s.m.positions, 12 * (size_t)w->s.m.vertex_count);
    w->theirs = embree_mesh_make(r->device, w->positions, w->s.m.vertex_count, w->s.m.indices, w->s.m.triangle_count,
                                 RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_ROBUST);
    w->scene = w->theirs.scene;
    if (w->instance_count == 1) {
        return;
    }
    w->scene = rtcNewScene(r->device);
    rtcSetSceneFlags(w->scene, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < w->instance_count; i++) {
        RTCGeometry instance = rtcNewGeometry(r->device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, w->theirs.scene);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, w->instances[i].transform);
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(w->scene, instance, i);
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(w->scene);
}

static clast_status make_workload(run *r, workload *w)
{
    clast_status status = clusters_make(r->context, &w->s, w->kind, CLAST_BUILD_BEST, &w->c);
    status = status == CLAST_OK ? clast_tlas_create(r->context, &w->tlas) : status;
    if (status == CLAST_OK) {
        w->instances = make_instances(w->c.blas, w->instance_count, r->seed);
        status = clast_tlas_build(w->tlas, w->instances, w->instance_count, CLAST_BUILD_BEST);
        place_theirs(r, w);
    }
    float lower[3], upper[3];
    clast_tlas_bounds(w->tlas, lower, upper);
    for (int axis = 0; axis < 3; axis++) {
        w->size = fmaxf(w->size, fmaxf(fabsf(lower[axis]), fabsf(upper[axis])));
    }
    return status;
}

static void free_workload(workload *w)
{
    if (w->instance_count > 1) {
        rtcReleaseScene(w->scene);
    }
    rtcReleaseScene(w->theirs.scene);
    clast_tlas_destroy(w->tlas);
    clusters_free(&w->c);
    free(w->instances);
    free(w->positions);
    surface_free(&w->s);
}

// ----------------------------------------------------------------------------------------------------------------- rays

static clast_ray make_ray(const workload *w, uint64_t number, randoms *r)
{
    float lower[3], upper[3], extent = 0.0f;
    clast_ray ray = {.t_max = INFINITY};
    clast_tlas_bounds(w->tlas, lower, upper);
    for (int axis = 0; axis < 3; axis++) {
        extent = fmaxf(extent, upper[axis] - lower[axis]);
    }
    uint32_t kind = (uint32_t)(number / CHUNK % 4);
    const float *p = w->s.m.positions + 3 * (size_t)w->s.m.indices[random_below(r, 3 * w->s.m.triangle_count)];
    const float(*map)[4] = w->instances[random_below(r, w->instance_count)].transform;
    for (int axis = 0; axis < 3; axis++) {
        float middle = (lower[axis] + upper[axis]) / 2.0f, way = random_between(r, -1, 1);
        float at = map[axis][0] * p[0] + map[axis][1] * p[1] + map[axis][2] * p[2] + map[axis][3];
        if (kind == 0) { // from one point, row by row
            ray.origin[axis] = middle + extent * (axis == 2 ? 1.1f : 0.3f);
            ray.direction[axis] = axis == 0   ? ((float)(number % CHUNK) / CHUNK - 0.5f)
                                  : axis == 1 ? ((float)(number / CHUNK % 977) / 977.0f - 0.5f)
                                              : -1.0f;
        } else if (kind == 1) { // from next to the surface
            ray.origin[axis] = at + extent * 1e-3f * random_between(r, -1, 1);
            ray.direction[axis] = way;
        } else if (kind == 2) { // at a vertex
            ray.origin[axis] = middle + extent * random_between(r, -1, 1);
            ray.direction[axis] = at - ray.origin[axis] + extent * 1e-6f * way;
        } else {
            ray.origin[axis] = middle + extent * 0.7f * random_between(r, -1, 1);
            ray.direction[axis] = way;
        }
    }
    if (random_below(r, 4) == 0) {
        ray.t_max = extent * random_float(r);
    }
    return ray;
}

// ------------------------------------------------------------------------------------------------------------- compare

typedef struct found {
    uint32_t instance; // CLAST_NONE: nothing
    uint32_t corners[3];
    float world[3][3];
} found;

static void place_corners(const workload *w, found *f)
{
    for (int k = 0; k < 3; k++) {
        const float *p = w->s.m.positions + 3 * (size_t)f->corners[k];
        const float(*map)[4] = w->instances[f->instance].transform;
        for (int axis = 0; axis < 3; axis++) {
            f->world[k][axis] = (float)((double)map[axis][0] * (double)p[0] + (double)map[axis][1] * (double)p[1] +
                                        (double)map[axis][2] * (double)p[2] + (double)map[axis][3]);
        }
    }
}

static corners corners_of(const found *f)
{
    corners none = {{NULL, NULL, NULL}};
    return f->instance == CLAST_NONE ? none : (corners){{f->world[0], f->world[1], f->world[2]}};
}

static void compare(const run *r, const clast_ray *ray, const clast_hit *hit, agreement *a)
{
    const workload *w = r->work;
    struct RTCRayHit theirs = embree_closest(w->scene, ray, false);
    found ours = {.instance = hit->instance}, other = {.instance = CLAST_NONE};
    if (hit->instance != CLAST_NONE) {
        clusters_corners(&w->c, hit->cluster, hit->triangle, ours.corners);
        place_corners(w, &ours);
    }
    if (theirs.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        other.instance = w->instance_count == 1 ? 0 : theirs.hit.instID[0];
        memcpy(other.corners, w->s.m.indices + 3 * (size_t)theirs.hit.primID, sizeof other.corners);
        place_corners(w, &other);
    }
    corners our_corners = corners_of(&ours), their_corners = corners_of(&other);
    if (ours.instance == other.instance && memcmp(ours.corners, other.corners, sizeof ours.corners) == 0) {
        their_corners = our_corners; // one triangle
    }
    agreement_count(a, ray, our_corners, hit->t, their_corners, theirs.ray.tfar);
}

static void compare_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    run *r = data;
    for (size_t chunk = begin; chunk < end; chunk++) {
        randoms random = {(r->seed * 0x100000001b3u) ^ (chunk * 0x9e3779b97f4a7c15u)};
        agreement a = {.scale = 2.0f * r->work->size};
        clast_ray rays[CHUNK];
        clast_hit hits[CHUNK];
        size_t left = (size_t)(r->rays - chunk * CHUNK), count = left < CHUNK ? left : CHUNK;
        size_t batch = chunk / 4 % 2 == 0 ? 1 : 256;
        for (size_t i = 0; i < count; i++) {
            rays[i] = make_ray(r->work, chunk * CHUNK + i, &random);
        }
        for (size_t i = 0; i < count; i += batch) {
            clast_trace_closest(r->work->tlas, rays + i, count - i < batch ? count - i : batch, NULL, hits + i);
        }
        for (size_t i = 0; i < count; i++) {
            compare(r, &rays[i], &hits[i], &a);
        }
        atomic_fetch_add(&r->hits, a.hits);
        atomic_fetch_add(&r->ties, a.ties);
        atomic_fetch_add(&r->wrong, a.wrong);
        atomic_fetch_add(&r->theirs, a.theirs);
    }
}

// Gives false where the workload could not be made; frees it.
static bool compare_workload(run *r, workload *w)
{
    double start = clast_clock();
    uint64_t hits = atomic_load(&r->hits), ties = atomic_load(&r->ties), wrong = atomic_load(&r->wrong);
    r->work = w;
    bool made = make_workload(r, w) == CLAST_OK;
    if (made) {
        clast_parallel_for(r->context, (size_t)((r->rays + CHUNK - 1) / CHUNK), 1, compare_range, r);
        printf("%s: %u triangles, %u instances, %llu rays, %llu hits, %llu ties, %llu wrong, %.0f s\n", w->name,
               w->s.m.triangle_count, w->instance_count, (unsigned long long)r->rays,
               (unsigned long long)(atomic_load(&r->hits) - hits), (unsigned long long)(atomic_load(&r->ties) - ties),
               (unsigned long long)(atomic_load(&r->wrong) - wrong), clast_clock() - start);
    } else {
        fprintf(stderr, "%s\n", clast_context_error(r->context));
    }
    free_workload(w);
    return made;
}

// Gives how many workloads there were, or 0 where one could not be made.
static uint32_t compare_all(run *r, uint32_t triangles)
{
    workload made[] = {
        {.name = "displaced sphere, grids", .s = make_sphere(r->context, triangles), .kind = CLUSTERS_GRIDS},
        {.name = "terrain, grids", .s = make_terrain(r->context, triangles), .kind = CLUSTERS_GRIDS},
        {.name = "cloth, grids", .s = make_cloth(r->context, triangles), .kind = CLUSTERS_GRIDS},
        {.name = "instances", .s = make_sphere(r->context, 3000), .kind = CLUSTERS_CUT, .instance_count = INSTANCES},
    };
    uint32_t count = 0;
    for (size_t i = 0; i < sizeof made / sizeof made[0]; i++, count++) {
        made[i].instance_count += made[i].instance_count == 0;
        if (!compare_workload(r, &made[i])) {
            return 0;
        }
    }
    const char *assets = getenv("CLAST_ASSETS");
    surface *surfaces = NULL;
    char folder[2048];
    snprintf(folder, sizeof folder, "%s/dense", assets != NULL ? assets : "");
    uint32_t models = assets != NULL ? surfaces_load_all(r->context, folder, &surfaces) : 0;
    bool sound = true;
    for (uint32_t i = 0; i < models; i++, count++) {
        workload w = {.name = surfaces[i].name, .s = surfaces[i], .kind = CLUSTERS_CUT, .instance_count = 1};
        sound = compare_workload(r, &w) && sound;
    }
    free(surfaces);
    return sound ? count : 0;
}

// -------------------------------------------------------------------------------------------------------------- options

static bool read_number(const char *text, uint64_t *number)
{
    char *end;
    errno = 0;
    *number = strtoull(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && text[0] != '-';
}

int main(int count, char **arguments)
{
    static run r = {.rays = 1000000, .seed = 1};
    uint64_t threads = 0, triangles = 1000000;
    for (int i = 1; i < count; i += 2) {
        const char *name = arguments[i], *value = i + 1 < count ? arguments[i + 1] : "";
        bool known = (strcmp(name, "--rays") == 0 && read_number(value, &r.rays)) ||
                     (strcmp(name, "--seed") == 0 && read_number(value, &r.seed)) ||
                     (strcmp(name, "--threads") == 0 && read_number(value, &threads) && threads <= 1024) ||
                     (strcmp(name, "--triangles") == 0 && read_number(value, &triangles) && triangles >= 1000 &&
                      triangles <= 100000000);
        if (!known) {
            fprintf(stderr, "usage: agreement [--rays N] [--seed S] [--threads T] [--triangles M]\n");
            return 2;
        }
    }
    clast_context_desc desc = {.threads = (uint32_t)threads};
    if (clast_context_create(&desc, &r.context) != CLAST_OK) {
        return 2;
    }
    r.device = rtcNewDevice(NULL);
    uint32_t workloads = compare_all(&r, (uint32_t)triangles);
    uint64_t wrong = atomic_load(&r.wrong), rays = r.rays * workloads;
    printf("ties: %llu; Embree alone wrong: %llu; wrong: %llu of %llu rays\n", (unsigned long long)atomic_load(&r.ties),
           (unsigned long long)atomic_load(&r.theirs), (unsigned long long)wrong, (unsigned long long)rays);
    rtcReleaseDevice(r.device);
    clast_context_destroy(r.context);
    return workloads == 0 ? 2 : wrong > 0;
}
