// SPDX-License-Identifier: Apache-2.0
// Aims rays exactly at shared edges and vertices of closed meshes and counts those that slip through.
//
//   watertight --rays N --seed S [--isa plain|sse4.2|avx2] [--threads T]
//
// Ends with a line `leaks: L of N rays` and exits 1 where L > 0. The rays depend on the seed alone.
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>

#include "accel/meshes.h"
#include "base/isa.h"
#include "base/thread.h"

enum { MESHES = 7, MAPS = 8, SIZES = 5, CHUNK = 4096 };

// A closed mesh. Those that look round from everywhere are also tested from outside, and by the distance of the hit.
typedef struct shape {
    const char *name;
    mesh m;
    bool is_round;
    float ring;  // a torus: the radius of the circle inside it; else 0
    float inner; // what is nearer to the middle, or to the ring, is inside
} shape;

typedef struct variant {
    const shape *shape;
    mesh m; // scaled
    float size;
    clustered c;
    float maps[MAPS][3][4];
    clast_tlas *tlas[MAPS];
} variant;

typedef struct run {
    clast_context *context;
    shape shapes[MESHES];
    variant variants[MESHES * SIZES];
    uint64_t rays, seed;
    atomic_uint_fast64_t leaks;
} run;

// For a mesh of size one.
static const float maps[MAPS][3][4] = {
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

static void make_shapes(run *r)
{
    r->shapes[0] = (shape){"sphere", mesh_sphere(96, 48), true, 0, 0.9f};
    r->shapes[1] = (shape){"octasphere", mesh_octasphere(5), true, 0, 0.9f};
    r->shapes[2] = (shape){"torus", mesh_torus(128, 48, 1.0f, 0.3f), false, 1.0f, 0.2f};
    r->shapes[3] = (shape){"bumpy sphere", mesh_octasphere(5), false, 0, 0.3f};
    r->shapes[4] = (shape){"spiky sphere", mesh_sphere(64, 64), false, 0, 0.05f};
    r->shapes[5] = (shape){"tetrahedron", tetrahedron(), false, 0, 0.5f};
    r->shapes[6] = (shape){"thin torus", mesh_torus(2000, 6, 1.0f, 0.01f), false, 1.0f, 0.005f};
    mesh_displace(&r->shapes[3].m, 0.2f, r->seed + 1);
    mesh_displace(&r->shapes[4].m, 0.8f, r->seed + 2);
}

// Each edge must have two faces, which run along it in opposite ways. Gives how many do not.
static uint32_t open_edges(const mesh *m)
{
    uint32_t slots = 8 * m->triangle_count, open = 0;
    struct {
        uint32_t lower, upper;
        int count, sum;
    } *table = calloc(slots, sizeof *table);
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++) {
        uint32_t a = m->indices[i], b = m->indices[i % 3 == 2 ? i - 2 : i + 1];
        uint32_t lower = a < b ? a : b, upper = a < b ? b : a;
        uint32_t slot = (lower * 2654435761u ^ upper * 40503u) % slots;
        while (table[slot].count != 0 && (table[slot].lower != lower || table[slot].upper != upper)) {
            slot = (slot + 1) % slots;
        }
        table[slot].lower = lower;
        table[slot].upper = upper;
        table[slot].count++;
        table[slot].sum += a < b ? 1 : -1;
    }
    for (uint32_t i = 0; i < slots; i++) {
        open += table[i].count != 0 && (table[i].count != 2 || table[i].sum != 0);
    }
    free(table);
    return open;
}

// ---------------------------------------------------------------------------------------------------------------- aim

static float nudge(float x, randoms *r)
{
    uint32_t way = random_below(r, 3);
    return way == 0 ? x : nextafterf(x, way == 1 ? INFINITY : -INFINITY);
}

static void nudge3(float v[3], randoms *r)
{
    for (int axis = 0; axis < 3; axis++) {
        v[axis] = nudge(v[axis], r);
    }
}

static float length_of(const float v[3])
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        sum += (double)v[axis] * (double)v[axis];
    }
    return (float)sqrt(sum);
}

// A point of a random edge: an end, the middle, or between.
static void edge_point(const mesh *m, randoms *r, float point[3])
{
    uint32_t triangle = random_below(r, m->triangle_count), corner = random_below(r, 3);
    const float *a = m->positions + 3 * (size_t)m->indices[3 * triangle + corner];
    const float *b = m->positions + 3 * (size_t)m->indices[3 * triangle + (corner + 1) % 3];
    const float places[4] = {0.0f, 0.5f, 1.0f, random_float(r)};
    float t = places[random_below(r, 4)];
    for (int axis = 0; axis < 3; axis++) {
        point[axis] = t == 1.0f ? b[axis] : a[axis] + t * (b[axis] - a[axis]);
    }
    if (random_below(r, 4) == 0) {
        nudge3(point, r);
    }
}

// A point inside, in the mesh's own space.
static void inside_point(const variant *v, randoms *r, float point[3])
{
    float radius = v->shape->inner * v->size * 0.55f; // a cube's corner is 1.73 away
    float turn = 6.2831853f * random_float(r), ring = v->shape->ring * v->size;
    point[0] = ring * cosf(turn) + random_between(r, -radius, radius);
    point[1] = ring * sinf(turn) + random_between(r, -radius, radius);
    point[2] = random_between(r, -radius, radius);
}

static bool is_inside(const variant *v, const float point[3])
{
    float across = v->shape->ring > 0.0f ? hypotf(point[0] / v->size, point[1] / v->size) - v->shape->ring : 0.0f;
    const float to_ring[3] = {across, 0, point[2] / v->size},
                to_middle[3] = {point[0] / v->size, point[1] / v->size, point[2] / v->size};
    return length_of(v->shape->ring > 0.0f ? to_ring : to_middle) < v->shape->inner;
}

static void to_world(const float map[3][4], const float p[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = (float)((double)map[i][0] * (double)p[0] + (double)map[i][1] * (double)p[1] +
                         (double)map[i][2] * (double)p[2] + (double)map[i][3]);
    }
}

// Where a ray that passes the point from outside has surely gone in: seen from there, the surface is not steep.
static bool outside_point(const variant *v, const float at[3], randoms *r, float point[3])
{
    float distance = exp2f(random_between(r, 1.0f, 16.6f)), way[3], cosine = 0.0f; // up to 1e5 sizes
    for (int axis = 0; axis < 3; axis++) {
        way[axis] = random_between(r, -1, 1);
    }
    float length = length_of(way);
    if (!v->shape->is_round || length < 0.1f) {
        return false;
    }
    for (int axis = 0; axis < 3; axis++) {
        point[axis] = way[axis] / length * distance * v->size;
        way[axis] = way[axis] / length * distance - at[axis] / v->size;
        cosine += way[axis] * (at[axis] / v->size); // the surface's normal, almost
    }
    return cosine > 0.3f * length_of(way);
}

typedef struct aimed {
    clast_ray ray;
    float farthest; // a hit beyond this has missed the surface that was aimed at
} aimed;

static aimed aim(const variant *v, const float map[3][4], randoms *r)
{
    float at[3], from[3];
    edge_point(&v->m, r, at);
    bool from_outside = random_below(r, 3) == 0 && outside_point(v, at, r, from);
    if (!from_outside) {
        inside_point(v, r, from);
        uint32_t keep = random_below(r, 8); // axes along which the ray does not move
        float aligned[3];
        for (uint32_t axis = 0; axis < 3; axis++) {
            aligned[axis] = (keep >> axis & 1) != 0 ? at[axis] : from[axis];
        }
        if (keep != 7 && is_inside(v, aligned)) {
            memcpy(from, aligned, sizeof from);
        }
    }
    aimed a = {.ray.t_max = INFINITY, .farthest = INFINITY};
    float target[3];
    to_world(map, at, target);
    to_world(map, from, a.ray.origin);
    for (int axis = 0; axis < 3; axis++) {
        a.ray.direction[axis] = target[axis] - a.ray.origin[axis];
    }
    if (random_below(r, 2) == 0) {
        nudge3(a.ray.direction, r);
    }
    if (v->shape->is_round) {
        const float way[3] = {at[0] - from[0], at[1] - from[1], at[2] - from[2]};
        a.farthest = 1.0f + 0.3f * v->size / length_of(way);
    }
    return a;
}

// ---------------------------------------------------------------------------------------------------------------- run

static void trace_chunk(run *r, const variant *v, uint32_t map, uint64_t chunk, size_t count)
{
    randoms random = {r->seed * 0x100000001b3u + chunk};
    uint64_t leaks = 0;
    for (size_t i = 0; i < count; i++) {
        aimed a = aim(v, (const float(*)[4])v->maps[map], &random);
        clast_hit hit;
        uint8_t occluded;
        clast_trace_closest(v->tlas[map], &a.ray, 1, NULL, &hit);
        clast_trace_any(v->tlas[map], &a.ray, 1, NULL, &occluded);
        if (hit.instance != 0 || occluded == 0 || hit.t > a.farthest) {
            if (leaks++ == 0) {
                printf("%s, size %g, map %u: from %.9g %.9g %.9g towards %.9g %.9g %.9g: %s, t %g of %g\n",
                       v->shape->name, (double)v->size, map, (double)a.ray.origin[0], (double)a.ray.origin[1],
                       (double)a.ray.origin[2], (double)a.ray.direction[0], (double)a.ray.direction[1],
                       (double)a.ray.direction[2], hit.instance == 0 ? "a hit" : "nothing", (double)hit.t,
                       (double)a.farthest);
            }
        }
    }
    atomic_fetch_add(&r->leaks, leaks);
}

static void trace_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    run *r = data;
    for (size_t chunk = begin; chunk < end; chunk++) {
        uint64_t left = r->rays - chunk * CHUNK;
        trace_chunk(r, &r->variants[chunk / MAPS % (MESHES * SIZES)], (uint32_t)(chunk % MAPS), chunk,
                    left < CHUNK ? (size_t)left : CHUNK);
    }
}

// What a map does to a mesh of size one, for one of another size. Where the world would be too small or too large for
// floats to tell its points apart, the identity.
static void make_map(uint32_t number, float size, float map[3][4])
{
    float scale = length_of(maps[number][0]) * size;
    memcpy(map, maps[scale > 1e-22f && scale < 1e22f ? number : 0], sizeof maps[0]);
    for (int i = 0; i < 3; i++) {
        map[i][3] *= size;
    }
}

static clast_status make_variant(run *r, const shape *s, float size, variant *v)
{
    *v = (variant){.shape = s, .size = size, .m = mesh_of(s->m.vertex_count, s->m.triangle_count)};
    memcpy(v->m.positions, s->m.positions, (size_t)s->m.vertex_count * 12);
    memcpy(v->m.indices, s->m.indices, (size_t)s->m.triangle_count * 12);
    mesh_transform(&v->m, size, 0, 0, 0);
    clast_status status = clustered_make(r->context, &v->m, 128, &v->c);
    for (uint32_t map = 0; map < MAPS && status == CLAST_OK; map++) {
        clast_tlas_instance instances[2] = {{.blas = v->c.blas, .id = 0}, {.blas = v->c.blas, .id = 1}};
        make_map(map, size, v->maps[map]);
        memcpy(instances[0].transform, v->maps[map], sizeof instances[0].transform);
        memcpy(instances[1].transform, v->maps[map], sizeof instances[1].transform);
        status = clast_tlas_create(r->context, &v->tlas[map]);
        // every other one twice in the same place: all hits are ties, and there is a tree over the instances
        status = status == CLAST_OK ? clast_tlas_build(v->tlas[map], instances, 1 + map % 2, CLAST_BUILD_BEST) : status;
    }
    return status;
}

static int test_all(run *r)
{
    make_shapes(r);
    for (uint32_t i = 0; i < MESHES; i++) {
        uint32_t open = open_edges(&r->shapes[i].m);
        printf("%s: %u triangles, %u edges without two faces\n", r->shapes[i].name, r->shapes[i].m.triangle_count,
               open);
        if (open != 0) {
            return 2;
        }
        for (uint32_t k = 0; k < SIZES; k++) {
            if (make_variant(r, &r->shapes[i], sizes[k], &r->variants[i * SIZES + k]) != CLAST_OK) {
                printf("%s\n", clast_context_error(r->context));
                return 2;
            }
        }
    }
    clast_parallel_for(r->context, (size_t)((r->rays + CHUNK - 1) / CHUNK), 1, trace_range, r);
    uint64_t leaks = atomic_load(&r->leaks);
    printf("leaks: %llu of %llu rays\n", (unsigned long long)leaks, (unsigned long long)r->rays);
    return leaks > 0;
}

static void free_all(run *r)
{
    for (uint32_t i = 0; i < MESHES * SIZES; i++) {
        variant *v = &r->variants[i];
        for (uint32_t map = 0; map < MAPS; map++) {
            clast_tlas_destroy(v->tlas[map]);
        }
        clustered_free(&v->c);
        mesh_free(&v->m);
    }
    for (uint32_t i = 0; i < MESHES; i++) {
        mesh_free(&r->shapes[i].m);
    }
}

static bool read_number(const char *text, uint64_t *number)
{
    char *end;
    errno = 0;
    *number = strtoull(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && text[0] != '-';
}

static bool read_isa(const char *text, clast_isa *isa)
{
    for (int i = CLAST_ISA_PLAIN; i <= CLAST_ISA_AVX2; i++) {
        if (strcmp(text, clast_isa_text((clast_isa)i)) == 0) {
            *isa = (clast_isa)i;
            return true;
        }
    }
    return false;
}

int main(int count, char **arguments)
{
    run r = {.rays = 1000000, .seed = 1};
    clast_context_desc desc = {0};
    for (int i = 1; i < count; i += 2) {
        uint64_t threads = 0;
        const char *value = i + 1 < count ? arguments[i + 1] : "";
        bool known = (strcmp(arguments[i], "--rays") == 0 && read_number(value, &r.rays)) ||
                     (strcmp(arguments[i], "--seed") == 0 && read_number(value, &r.seed)) ||
                     (strcmp(arguments[i], "--isa") == 0 && read_isa(value, &desc.isa)) ||
                     (strcmp(arguments[i], "--threads") == 0 && read_number(value, &threads) && threads <= 1024);
        if (!known) {
            fprintf(stderr, "usage: watertight [--rays N] [--seed S] [--isa plain|sse4.2|avx2] [--threads T]\n");
            return 2;
        }
        desc.threads = threads != 0 ? (uint32_t)threads : desc.threads;
    }
    clast_status status = clast_context_create(&desc, &r.context);
    if (status == CLAST_ERROR_DEVICE) {
        printf("skipped: the machine lacks %s\n", clast_isa_text(desc.isa));
        return 77;
    }
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_status_text(status));
        return 2;
    }
    int result = test_all(&r);
    free_all(&r);
    clast_context_destroy(r.context);
    return result;
}
