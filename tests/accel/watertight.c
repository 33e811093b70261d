// SPDX-License-Identifier: Apache-2.0
// Aims rays exactly at shared edges and vertices of closed meshes and counts those that slip through.
//
//   watertight [--rays N] [--seed S] [--isa NAME | all] [--device cpu|vulkan] [--threads T]
//              [--peer embree] [--meshes made|models|all|displaced]
//
// A leak is a ray from inside that hits nothing, or a ray that crosses the surface for certain (watertight_crossing.c) at the
// edge it was aimed at, and hits nothing or only something behind. Rays go one by one and in batches, to the nearest hit and
// to any. Models are those of the folder CLAST_ASSETS. Displaced meshes are looked at in each frame of a flight; an edge
// along which not as many triangles run forth as back is a leak too. With a device, rays are traced there, and clusters fitted. Ends with a line `leaks: L of N rays` and exits 1 where L > 0. The rays
// depend on the seed and the meshes alone; each instruction set gets N.
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>

#include "accel/watertight.h"
#include "base/isa.h"
#include "base/thread.h"

enum { SIZES = 5, CHUNK = 512, WAVE = 1024, BUNDLE = 64, SAMPLED = 256, MODES = 4 };

// A surface of some size, in some kind of clusters, and its trees.
typedef struct variant {
    surface s;
    cluster_kind kind;
    bool is_moved; // built over another shape, then refitted
    float size;
    clusters c;
    placing maps[WATERTIGHT_MAPS];
    clast_tlas *tlas[WATERTIGHT_MAPS];
    device_tlas *there[WATERTIGHT_MAPS];
    peer_scene *peer;
} variant;

typedef struct counters {
    atomic_uint_fast64_t leaks, rims, sampled, sure, peer_leaks[2], peer_rays;
} counters;

typedef struct run {
    clast_context *context;
    surface *surfaces; // as they are, and as they are when moved
    surface *moved;
    uint32_t surface_count, variant_count;
    variant *variants;
    peer *peer;
    device_tracer *device; // null: the processor
    uint64_t rays, seed, total;
    counters count;
} run;

// For a mesh of size one.
static const float maps[WATERTIGHT_MAPS][3][4] = {
    {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
    {{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},                                    // a mirror
    {{0, 0, 4, 1}, {0.25f, 0, 0, 2}, {0, 1, 0, -3}},                                // axes changed, powers of two
    {{3, 0, 0, 0.1f}, {0, 0.07f, 0, 0.2f}, {0, 0, 1.3f, 0.3f}},                     // not uniform
    {{-0.5f, 0.8f, 0.1f, 5}, {0.6f, 0.7f, -0.3f, 1}, {0.2f, 0.1f, 0.9f, -2}},       // mirrored and sheared
    {{1e-15f, 0, 0, 0}, {0, 1e-15f, 0, 0}, {0, 0, 1e-15f, 0}},                      // tiny
    {{0, 1e15f, 0, 1e15f}, {-1e15f, 0, 0, 3e14f}, {0, 0, 1e15f, -1e14f}},           // huge
    {{0.36f, 0.48f, -0.8f, 100}, {-0.8f, 0.6f, 0, 200}, {0.48f, 0.64f, 0.6f, 300}}, // turned, far from the middle
};
// What the mesh itself is multiplied by.
static const float sizes[SIZES] = {1.0f, 1e-15f, 1e15f, 1e-20f, 1e5f};

// ------------------------------------------------------------------------------------------------------------- meshes

static mesh tetrahedron(void)
{
    static const float points[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
    static const uint32_t faces[12] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
    mesh m = mesh_of(4, 4);
    memcpy(m.positions, points, sizeof points);
    memcpy(m.indices, faces, sizeof faces);
    return m;
}

static bool add_surface(run *r, const char *name, mesh m, uint32_t columns, uint32_t rows)
{
    surface s;
    uint32_t open = surface_make(r->context, name, &m, &s);
    printf("%s: %u triangles, %u edges without two faces\n", name, m.triangle_count, open);
    s.columns = columns;
    s.rows = rows;
    s.sheets = columns != 0 ? m.triangle_count / (2 * columns * rows) : 0;
    r->surfaces = realloc(r->surfaces, (r->surface_count + 1) * sizeof *r->surfaces);
    r->surfaces[r->surface_count++] = s;
    return open == 0 && surface_find_inside(&r->surfaces[r->surface_count - 1], r->seed);
}

static bool make_surfaces(run *r)
{
    mesh bumpy = mesh_octasphere(5), spiky = mesh_sphere(64, 64);
    mesh_displace(&bumpy, 0.2f, r->seed + 1);
    mesh_displace(&spiky, 0.8f, r->seed + 2);
    bool sound = add_surface(r, "sphere", mesh_sphere(96, 48), 0, 0);
    sound = add_surface(r, "octasphere", mesh_octasphere(5), 0, 0) && sound;
    sound = add_surface(r, "torus", mesh_torus(128, 48, 1.0f, 0.3f), 128, 48) && sound;
    sound = add_surface(r, "bumpy sphere", bumpy, 0, 0) && sound;
    sound = add_surface(r, "spiky sphere", spiky, 0, 0) && sound;
    sound = add_surface(r, "tetrahedron", tetrahedron(), 0, 0) && sound;
    sound = add_surface(r, "thin torus", mesh_torus(2000, 6, 1.0f, 0.01f), 2000, 6) && sound;
    return add_surface(r, "cube sphere", mesh_cube_sphere(37), 37, 37) && sound;
}

// Bends and swells a surface; false where nothing is inside any more.
static bool make_moved(run *r, const surface *s, surface *moved)
{
    *moved = surface_scaled(s, 1.0f);
    for (uint32_t i = 0; i < s->m.vertex_count; i++) {
        float *p = moved->m.positions + 3 * (size_t)i, from[3];
        for (int axis = 0; axis < 3; axis++) {
            from[axis] = (float)(((double)p[axis] - s->centre[axis]) / s->radius);
        }
        float swelling = 1.0f + 0.2f * sinf(4.0f * from[1] + 1.0f) + 0.05f * sinf(17.0f * from[0] + 9.0f * from[2]);
        for (int axis = 0; axis < 3; axis++) {
            float bent = axis == 0 ? 0.3f * from[2] * from[2] : 0.0f;
            p[axis] = (float)(s->centre[axis] + s->radius * (double)(from[axis] * swelling + bent));
        }
    }
    surface rescaled = surface_scaled(moved, 1.0f); // with its own middle
    surface_free(moved);
    *moved = rescaled;
    return surface_find_inside(moved, r->seed + 3);
}

// ------------------------------------------------------------------------------------------------------------ variants

// What a map does to a mesh of size one, for one of another size. Where the world would be too small or too large for
// floats to tell its points apart, the identity.
static placing make_map(uint32_t number, double size)
{
    float map[3][4];
    double scale = size *
                   sqrt((double)(maps[number][0][0] * maps[number][0][0] + maps[number][0][1] * maps[number][0][1] +
                                 maps[number][0][2] * maps[number][0][2]));
    memcpy(map, maps[scale > 1e-22 && scale < 1e22 ? number : 0], sizeof map);
    for (int i = 0; i < 3; i++) {
        map[i][3] = (float)((double)map[i][3] * size);
    }
    return placing_of(map);
}

// At once, or somewhere else first.
static clast_status place(clast_tlas *tlas, const clast_tlas_instance *instances, uint32_t count, clast_build build)
{
    if (build == CLAST_BUILD_BEST) {
        return clast_tlas_build(tlas, instances, count, build);
    }
    clast_tlas_instance elsewhere[2] = {instance_of(instances[0].blas, 7), instance_of(instances[0].blas, 8)};
    clast_status status = clast_tlas_build(tlas, elsewhere, count, build);
    return status == CLAST_OK ? clast_tlas_update(tlas, NULL, instances, count) : status;
}

static clast_status make_trees(run *r, variant *v, clast_build build)
{
    clast_status status = CLAST_OK;
    float placed[WATERTIGHT_MAPS][3][4];
    for (uint32_t map = 0; map < WATERTIGHT_MAPS && status == CLAST_OK; map++) {
        clast_tlas_instance instances[2] = {{.blas = v->c.blas, .id = 0}, {.blas = v->c.blas, .id = 1}};
        v->maps[map] = make_map(map, v->s.radius);
        memcpy(placed[map], v->maps[map].to_world, sizeof placed[map]);
        memcpy(instances[0].transform, placed[map], sizeof placed[map]);
        memcpy(instances[1].transform, placed[map], sizeof placed[map]);
        status = clast_tlas_create(r->context, &v->tlas[map]);
        // every other one twice in the same place: all hits are ties, and there is a tree over the instances
        status = status == CLAST_OK ? place(v->tlas[map], instances, 1 + map % 2, build) : status;
        if (status == CLAST_OK && r->device != NULL) {
            v->there[map] = device_tlas_create(r->device, v->tlas[map], v->there[0]);
            status = v->there[map] != NULL ? CLAST_OK : CLAST_ERROR_DEVICE;
        }
    }
    if (r->peer != NULL) {
        v->peer = peer_scene_create(r->peer, &v->s, (const float(*)[3][4])placed);
    }
    return status;
}

static clast_status add_variant(run *r, uint32_t number, float size, cluster_kind kind, bool is_moved)
{
    variant *v = &r->variants[r->variant_count++];
    clast_build build = r->variant_count % 2 == 0 ? CLAST_BUILD_BEST : CLAST_BUILD_FAST;
    surface rest = surface_scaled(&r->surfaces[number], size);
    *v = (variant){.kind = kind, .is_moved = is_moved, .size = size};
    v->s = surface_scaled(is_moved ? &r->moved[number] : &r->surfaces[number], size);
    clast_status status = clusters_make(r->context, &rest, kind, build, &v->c);
    if (is_moved && status == CLAST_OK) {
        status = clusters_refit(&v->c, &v->s);
    }
    surface_free(&rest);
    return status == CLAST_OK ? make_trees(r, v, build) : status;
}

static clast_status make_variants(run *r, uint32_t made)
{
    clast_status status = CLAST_OK;
    r->variants = calloc((size_t)r->surface_count * 2 * SIZES, sizeof *r->variants);
    r->moved = calloc(r->surface_count, sizeof *r->moved);
    for (uint32_t i = 0; i < r->surface_count && status == CLAST_OK; i++) {
        bool can_move = make_moved(r, &r->surfaces[i], &r->moved[i]), has_sheets = r->surfaces[i].sheets != 0;
        for (uint32_t k = 0; k < (i < made ? SIZES : 2) && status == CLAST_OK; k++) {
            float size = sizes[k == 0 ? 0 : (k + (i < made ? 0 : i)) % SIZES];
            status = add_variant(r, i, size, (cluster_kind)((i + k) % CLUSTERS_GRIDS), can_move && k % 2 == 1);
            if (has_sheets && status == CLAST_OK) {
                status = add_variant(r, i, size, CLUSTERS_GRIDS, can_move && k % 2 == 0);
            }
        }
    }
    return status;
}

static void free_variants(run *r)
{
    for (uint32_t i = 0; i < r->variant_count; i++) {
        variant *v = &r->variants[i];
        for (uint32_t map = WATERTIGHT_MAPS; map-- > 0;) {
            device_tlas_destroy(r->device, v->there[map]);
            clast_tlas_destroy(v->tlas[map]);
        }
        peer_scene_destroy(v->peer);
        clusters_free(&v->c);
        surface_free(&v->s);
    }
    for (uint32_t i = 0; r->moved != NULL && i < r->surface_count; i++) {
        surface_free(&r->moved[i]);
    }
    free(r->variants);
    free(r->moved);
    r->variants = NULL;
    r->moved = NULL;
    r->variant_count = 0;
}

// ----------------------------------------------------------------------------------------------------------------- run

typedef struct outcome {
    float t;      // of the hit, or infinite
    bool is_near; // there is a hit, and its distance is not known
} outcome;

typedef enum verdict { VERDICT_HIT, VERDICT_RIM, VERDICT_LEAK } verdict;

// A hit that is not behind what was aimed at needs no proof; rounding moves t by some parts of 1e-7.
static verdict judge(const variant *v, uint32_t map, const shot *a, outcome o)
{
    if (o.is_near || o.t <= 1.000001f) {
        return VERDICT_HIT;
    }
    if (a->is_inside && o.t == INFINITY) {
        return VERDICT_LEAK;
    }
    double farthest = INFINITY;
    crossing c = surface_crossing(&v->s, &v->maps[map], &a->ray, a->half_edge, &farthest);
    if (c == CROSSING_SURE) {
        return (double)o.t > farthest ? VERDICT_LEAK : VERDICT_HIT;
    }
    return c == CROSSING_RIM && o.t == INFINITY ? VERDICT_RIM : VERDICT_HIT;
}

// Some rays at one variant.
typedef struct chunk {
    const variant *v;
    uint32_t map, mode;
    size_t batch, count;
    shot shots[CHUNK];
    clast_ray rays[CHUNK];
    clast_hit hits[CHUNK];
    uint32_t occluded[CHUNK];
} chunk;

static const char *const ways[MODES] = {"nearest, single", "nearest, batches", "any, single", "any, batches"};

static bool is_any(const chunk *c)
{
    return c->mode >= 2;
}

static void aim_chunk(const run *r, uint64_t number, chunk *c)
{
    static const size_t batches[] = {2, 7, 16, 64, CHUNK};
    uint64_t turn = number / r->variant_count, left = r->rays - number * CHUNK;
    c->v = &r->variants[number % r->variant_count];
    c->map = (uint32_t)(turn % WATERTIGHT_MAPS);
    c->mode = (uint32_t)((turn / WATERTIGHT_MAPS + number) % MODES);
    c->batch = c->mode % 2 == 0 ? 1 : batches[number % 5];
    c->count = left < CHUNK ? (size_t)left : CHUNK;
    randoms random = {(r->seed * 0x100000001b3u) ^ (number * 0x9e3779b97f4a7c15u)};
    size_t alike = c->mode % 2 == 1 && number / 7 % 2 == 0 ? BUNDLE : 1; // some batches are of rays that go together
    for (size_t i = 0; i < c->count; i += alike) {
        aim(&c->v->s, &c->v->maps[c->map], &random, c->shots + i, c->count - i < alike ? c->count - i : alike);
    }
    for (size_t i = 0; i < c->count; i++) {
        c->rays[i] = c->shots[i].ray;
    }
}

static void trace_batches(chunk *c)
{
    uint8_t occluded[CHUNK];
    const clast_tlas *tlas = c->v->tlas[c->map];
    for (size_t i = 0; i < c->count; i += c->batch) {
        size_t some = c->count - i < c->batch ? c->count - i : c->batch;
        if (is_any(c)) {
            clast_trace_any(tlas, c->rays + i, some, NULL, occluded + i);
        } else {
            clast_trace_closest(tlas, c->rays + i, some, NULL, c->hits + i);
        }
    }
    for (size_t i = 0; is_any(c) && i < c->count; i++) {
        c->occluded[i] = occluded[i];
    }
}

static outcome outcome_of(const chunk *c, size_t i)
{
    bool hit = is_any(c) ? c->occluded[i] != 0 : c->hits[i].instance == 0; // of equal ones the lower instance
    return (outcome){!is_any(c) && hit ? c->hits[i].t : INFINITY, is_any(c) && hit};
}

static void report(const run *r, const variant *v, uint32_t map, const shot *a, outcome o, const char *way)
{
    printf("%s, %s clusters, size %g%s, map %u, %s, %s: from %a %a %a towards %a %a %a, %s, half edge %u: t %.9g\n",
           v->s.name, cluster_kind_name(v->kind), (double)v->size, v->is_moved ? ", moved" : "", map, way,
           clast_isa_text(clast_context_isa(r->context)), (double)a->ray.origin[0], (double)a->ray.origin[1],
           (double)a->ray.origin[2], (double)a->ray.direction[0], (double)a->ray.direction[1],
           (double)a->ray.direction[2], a->is_inside ? "inside" : "outside", a->half_edge, (double)o.t);
}

// Embree takes coordinates up to 1e18, and ends the program where there are others.
static bool peer_can(const variant *v, uint32_t map)
{
    return v->peer != NULL && v->s.radius > 1e-6 && v->s.radius < 1e9 && map != 5 && map != 6;
}

static void trace_peer(run *r, const variant *v, uint32_t map, const shot *shots, size_t count)
{
    for (int robust = 0; robust < 2; robust++) {
        uint64_t leaks = 0;
        for (size_t i = 0; i < count; i++) {
            outcome o = {peer_trace(v->peer, map, robust == 1, &shots[i].ray), false};
            leaks += judge(v, map, &shots[i], o) == VERDICT_LEAK;
        }
        atomic_fetch_add(&r->count.peer_leaks[robust], leaks);
    }
    atomic_fetch_add(&r->count.peer_rays, count);
}

static void judge_chunk(run *r, const chunk *c)
{
    uint64_t verdicts[3] = {0};
    for (size_t i = 0; i < c->count; i++) {
        outcome o = outcome_of(c, i);
        verdict found = judge(c->v, c->map, &c->shots[i], o);
        if (found == VERDICT_LEAK && verdicts[found] == 0 && atomic_load(&r->count.leaks) < 10) {
            report(r, c->v, c->map, &c->shots[i], o, ways[c->mode]);
        }
        verdicts[found]++;
        if (!c->shots[i].is_inside && i % SAMPLED == 0) {
            double farthest;
            crossing at = surface_crossing(&c->v->s, &c->v->maps[c->map], &c->shots[i].ray, c->shots[i].half_edge,
                                           &farthest);
            atomic_fetch_add(&r->count.sampled, 1);
            atomic_fetch_add(&r->count.sure, at == CROSSING_SURE);
        }
    }
    atomic_fetch_add(&r->count.leaks, verdicts[VERDICT_LEAK]);
    atomic_fetch_add(&r->count.rims, verdicts[VERDICT_RIM]);
    if (peer_can(c->v, c->map)) {
        trace_peer(r, c->v, c->map, c->shots, c->count);
    }
}

static void trace_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    run *r = data;
    chunk *c = malloc(sizeof *c);
    for (size_t number = begin; number < end; number++) {
        aim_chunk(r, number, c);
        trace_batches(c);
        judge_chunk(r, c);
    }
    free(c);
}

// Chunks that a device traces together.
typedef struct wave {
    run *r;
    uint64_t first;
    chunk *chunks;
} wave;

static void aim_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    wave *w = data;
    for (size_t i = begin; i < end; i++) {
        aim_chunk(w->r, w->first + i, &w->chunks[i]);
    }
}

static void judge_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    wave *w = data;
    for (size_t i = begin; i < end; i++) {
        judge_chunk(w->r, &w->chunks[i]);
    }
}

static bool trace_there(run *r, uint64_t chunks)
{
    wave w = {r, 0, malloc(WAVE * sizeof *w.chunks)};
    device_batch *batches = malloc(WAVE * sizeof *batches);
    bool done = true;
    for (; w.first < chunks && done; w.first += WAVE) {
        size_t count = chunks - w.first < WAVE ? (size_t)(chunks - w.first) : WAVE;
        clast_parallel_for(r->context, count, 1, aim_range, &w);
        for (size_t i = 0; i < count; i++) {
            chunk *c = &w.chunks[i];
            batches[i] = (device_batch){.tlas = c->v->there[c->map],
                                        .any = is_any(c),
                                        .incoherent = c->mode % 2 == 0,
                                        .count = (uint32_t)c->count,
                                        .rays = c->rays,
                                        .hits = c->hits,
                                        .occluded = c->occluded};
        }
        done = device_trace(r->device, batches, count);
        if (done) {
            clast_parallel_for(r->context, count, 1, judge_range, &w);
        }
    }
    free(batches);
    free(w.chunks);
    return done;
}

// False, and the error printed, where a device failed.
static bool trace_all(run *r)
{
    uint64_t chunks = (r->rays + CHUNK - 1) / CHUNK;
    r->total += r->rays;
    if (r->device != NULL) {
        return trace_there(r, chunks);
    }
    clast_parallel_for(r->context, (size_t)chunks, 1, trace_range, r);
    return true;
}

// ------------------------------------------------------------------------------------------------------------- flights

// Rays at one frame of a flight.
static bool test_moment(run *r, displaced_moment *moment)
{
    atomic_fetch_add(&r->count.leaks, moment->open);
    if (moment->collapsed != 0) {
        printf("%s: of %u triangles, %u edges are open; %u have collapsed: no rays\n", moment->s.name,
               moment->s.m.triangle_count, moment->open, moment->collapsed);
        return true;
    }
    if (!surface_find_inside(&moment->s, r->seed)) {
        printf("%s: nothing is inside\n", moment->s.name);
        return false;
    }
    variant v = {.s = moment->s, .kind = CLUSTERS_OWN, .size = 1.0f};
    for (uint32_t map = 0; map < WATERTIGHT_MAPS; map++) {
        v.maps[map] = moment->map;
        v.tlas[map] = moment->tlas;
    }
    device_tlas *there = r->device != NULL ? device_tlas_create(r->device, moment->tlas, NULL) : NULL;
    for (uint32_t map = 0; map < WATERTIGHT_MAPS; map++) {
        v.there[map] = there;
    }
    r->variants = &v;
    r->variant_count = 1;
    bool done = (r->device == NULL || there != NULL) && trace_all(r);
    r->variants = NULL;
    r->variant_count = 0;
    device_tlas_destroy(r->device, there);
    return done;
}

static int test_flight(run *r, const char *assets)
{
    displaced_flight *flight = displaced_flight_create(r->context, assets);
    if (flight == NULL) {
        return 2;
    }
    uint64_t rays = r->rays, seed = r->seed, triangles = 0;
    uint32_t frames = displaced_flight_frames(flight);
    int result = 0;
    for (uint32_t i = 0; i < frames && result == 0; i++) {
        displaced_moment moment;
        clast_status status = displaced_flight_fly(flight, i, &moment);
        if (status != CLAST_OK) {
            fprintf(stderr, "frame %u: %s\n", i, clast_context_error(r->context));
            result = 2;
            break;
        }
        r->rays = rays * (i + 1) / frames - rays * i / frames;
        r->seed = seed + i;
        triangles += moment.s.m.triangle_count;
        result = test_moment(r, &moment) ? 0 : 2;
        surface_free(&moment.s);
    }
    r->rays = rays;
    r->seed = seed;
    displaced_flight_destroy(flight);
    printf("%s: %llu rays at %u frames of %llu triangles\n", clast_isa_text(clast_context_isa(r->context)),
           (unsigned long long)rays, frames, (unsigned long long)triangles);
    return result;
}

// All surfaces through one instruction set. Gives 77 where the machine lacks it.
static int test_isa(run *r, const clast_context_desc *desc, bool made, bool models, bool displaced, bool device)
{
    clast_status status = clast_context_create(desc, &r->context);
    if (status == CLAST_ERROR_DEVICE) {
        printf("skipped: the machine lacks %s\n", clast_isa_text(desc->isa));
        return 77;
    }
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_status_text(status));
        return 2;
    }
    double start = clast_clock();
    const char *assets = getenv("CLAST_ASSETS");
    int result = 0;
    r->device = device ? device_tracer_create(r->context) : NULL;
    if (device && r->device == NULL) {
        clast_context_destroy(r->context);
        return 77;
    }
    if (displaced) {
        result = test_flight(r, assets);
        device_tracer_destroy(r->device);
        clast_context_destroy(r->context);
        return result;
    }
    if (r->surfaces == NULL) {
        if (made && !make_surfaces(r)) {
            result = 2;
        }
    }
    uint32_t made_count = made ? 8 : 0;
    if (models && assets != NULL && assets[0] != '\0' && r->surface_count == made_count) {
        r->surface_count = surfaces_load(r->context, assets, &r->surfaces, r->surface_count);
    }
    if (r->surface_count == 0) {
        printf("skipped: no closed mesh; CLAST_ASSETS may name a folder of models\n");
        result = 77;
    }
    if (result == 0) {
        status = make_variants(r, made_count);
        if (status != CLAST_OK) {
            fprintf(stderr, "%s\n", clast_context_error(r->context));
            result = 2;
        }
    }
    if (result == 0 && !trace_all(r)) {
        result = 2;
    }
    if (result == 0) {
        printf("%s: %llu rays at %u surfaces in %u ways, %.0f s\n", clast_isa_text(clast_context_isa(r->context)),
               (unsigned long long)r->rays, r->surface_count, r->variant_count, clast_clock() - start);
    }
    free_variants(r);
    device_tracer_destroy(r->device);
    clast_context_destroy(r->context);
    return result;
}

static unsigned long long shown(const atomic_uint_fast64_t *counter)
{
    return (unsigned long long)atomic_load(counter);
}

static int finish(run *r)
{
    printf("rays from outside that cross for certain: %llu of %llu looked at\n", shown(&r->count.sure),
           shown(&r->count.sampled));
    printf("rays that cross by less than rounding, at a silhouette, and hit nothing: %llu\n", shown(&r->count.rims));
    for (int mode = 0; r->peer != NULL && mode < 2; mode++) {
        printf("Embree, %s: leaks: %llu of the %llu rays at sizes that it takes\n", mode == 0 ? "fast" : "robust",
               shown(&r->count.peer_leaks[mode]), shown(&r->count.peer_rays));
    }
    printf("leaks: %llu of %llu rays\n", shown(&r->count.leaks), (unsigned long long)r->total);
    return atomic_load(&r->count.leaks) > 0;
}

// -------------------------------------------------------------------------------------------------------------- options

typedef struct options {
    uint64_t rays, seed, threads;
    clast_isa isa;
    bool all_isas, has_peer, made, models, displaced, device;
} options;

static bool read_number(const char *text, uint64_t *number)
{
    char *end;
    errno = 0;
    *number = strtoull(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && text[0] != '-';
}

static bool read_isa(const char *text, options *o)
{
    static const struct {
        clast_isa isa;
        const char *text;
    } list[] = {
#define ENTRY(name, value, text) {name, text},
        CLAST_ISA_LIST(ENTRY)
#undef ENTRY
    };
    o->all_isas = strcmp(text, "all") == 0;
    for (size_t i = 0; i < sizeof list / sizeof list[0]; i++) {
        if (strcmp(text, list[i].text) == 0) {
            o->isa = list[i].isa;
            return true;
        }
    }
    return o->all_isas;
}

static bool read_meshes(const char *text, options *o)
{
    o->displaced = strcmp(text, "displaced") == 0;
    if (o->displaced) {
        return true;
    }
    o->made = strcmp(text, "models") != 0;
    o->models = strcmp(text, "made") != 0;
    return (o->made && o->models) == (strcmp(text, "all") == 0);
}

static bool read_options(int count, char **arguments, options *o)
{
    *o = (options){.rays = 1000000, .seed = 1, .made = true, .models = true};
    for (int i = 1; i < count; i += 2) {
        const char *name = arguments[i], *value = i + 1 < count ? arguments[i + 1] : "";
        bool known = (strcmp(name, "--rays") == 0 && read_number(value, &o->rays)) ||
                     (strcmp(name, "--seed") == 0 && read_number(value, &o->seed)) ||
                     (strcmp(name, "--isa") == 0 && read_isa(value, o)) ||
                     (strcmp(name, "--threads") == 0 && read_number(value, &o->threads) && o->threads <= 1024) ||
                     (strcmp(name, "--meshes") == 0 && read_meshes(value, o)) ||
                     (strcmp(name, "--device") == 0 && (strcmp(value, "vulkan") == 0 || strcmp(value, "cpu") == 0)) ||
                     (strcmp(name, "--peer") == 0 && strcmp(value, "embree") == 0);
        if (!known) {
            return false;
        }
        o->has_peer = o->has_peer || strcmp(name, "--peer") == 0;
        o->device = strcmp(name, "--device") == 0 ? strcmp(value, "vulkan") == 0 : o->device;
    }
    return true;
}

int main(int count, char **arguments)
{
    static const clast_isa list[] = {
#define ENTRY(name, value, text) name,
        CLAST_ISA_LIST(ENTRY)
#undef ENTRY
    };
    options o;
    setvbuf(stdout, NULL, _IOLBF, 0); // long runs are watched
    if (!read_options(count, arguments, &o)) {
        fprintf(stderr, "usage: watertight [--rays N] [--seed S] [--isa NAME|all] [--device cpu|vulkan] [--threads T]\n"
                        "                  [--peer embree] [--meshes made|models|all|displaced]\n");
        return 2;
    }
    static run r;
    r = (run){.rays = o.rays, .seed = o.seed, .peer = o.has_peer ? peer_create() : NULL};
    if (o.has_peer && r.peer == NULL) {
        printf("skipped: built without Embree\n");
        return 77;
    }
    clast_context_desc desc = {.threads = (uint32_t)o.threads, .isa = o.isa};
    int result = 0;
    for (size_t i = 0; i < (o.all_isas ? sizeof list / sizeof list[0] : 1) && result != 2; i++) {
        desc.isa = o.all_isas ? list[i] : o.isa;
        int one = test_isa(&r, &desc, o.made, o.models, o.displaced, o.device);
        result = one == 77 && r.total > 0 ? result : one;
    }
    result = result == 0 ? finish(&r) : result;
    for (uint32_t i = 0; i < r.surface_count; i++) {
        surface_free(&r.surfaces[i]);
    }
    free(r.surfaces);
    peer_destroy(r.peer);
    return result;
}
