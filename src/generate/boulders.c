// SPDX-License-Identifier: Apache-2.0
// Boulders: a few shapes, broken along joints as sandstone is, instanced many times; stones; tufts of dry grass.
#include "generate/canyon.h"
#include "generate/lathe.h"

enum { SHAPES = 5, PLANES = 20 };

typedef struct boulder {
    vec3 normals[PLANES];
    float distances[PLANES];
    vec3 stretch;
    uint seed;
} boulder;

static vec3 random_direction(uint seed, uint number)
{
    float y = swing(seed, number, 1), turns = chance(seed, number, 2);
    float r = root(1.0f - y * y);
    return vec3(r * wave_cosine(turns), y, r * wave_sine(turns));
}

// Faces along three directions of joints, nearly square to each other, and random breaks between.
static boulder make_boulder(uint seed)
{
    boulder b = {.seed = seed};
    vec3 bedding = normalize3(vec3(0.22f * swing(seed, 1, 9), 1.0f, 0.22f * swing(seed, 2, 9)));
    vec3 joint = normalize3(
        cross3(bedding, vec3(wave_cosine(chance(seed, 3, 9)), 0.0f, wave_sine(chance(seed, 3, 9)))));
    vec3 cross = cross3(bedding, joint);
    const vec3 axes[6] = {bedding, bedding * -1.0f, joint, joint * -1.0f, cross, cross * -1.0f};
    for (uint i = 0; i < PLANES; i++) {
        vec3 loose = random_direction(seed, 20 + i);
        b.normals[i] = normalize3(i < 6 ? axes[i] + loose * 0.16f : loose);
        b.distances[i] = i < 6 ? 0.66f + 0.14f * chance(seed, i, 4) : 0.80f + 0.20f * chance(seed, i, 4);
    }
    b.stretch = vec3(1.0f + 0.35f * chance(seed, 5, 9), 0.72f + 0.32f * chance(seed, 6, 9),
                     0.85f + 0.2f * chance(seed, 7, 9));
    return b;
}

// The surface in a direction of unit length; relief, for colour, in *hollow: below 0 in hollows.
static vec3 boulder_surface(const boulder *b, vec3 direction, float *hollow)
{
    float radius = 1.25f;
    for (uint i = 0; i < PLANES; i++) {
        float facing = dot3(direction, b->normals[i]);
        if (facing > 0.15f) {
            radius = smooth_minimum(radius, b->distances[i] / facing, 0.085f);
        }
    }
    vec3 p = direction * radius;
    float large = clast_fractal3(p * 1.3f, 3, b->seed + 1);
    clast_cells facets = clast_cells3(p * 2.1f + vec3(large, clast_noise3(p * 3.1f, b->seed + 8), -large) * 0.35f,
                                      b->seed + 2);
    float step = unit_float(facets.id) - 0.5f;
    // Cracks here and there, not around every facet.
    float torn = smooth_step(0.05f, 0.30f, clast_noise3(p * 1.7f, b->seed + 5));
    float crack = torn * smooth_step(0.05f, 0.0f, facets.second - facets.nearest);
    // Beds stand out by turns.
    float bed = dot3(p, b->normals[0]) * 6.5f + 0.9f * large;
    float within = fraction(bed) * 2.0f - 1.0f;
    float ledge = (0.3f + 0.7f * chance(b->seed, (uint)(int)floor1(bed), 3)) * root(1.0f - square(within * within));
    float small = clast_fractal3(p * 5.5f, 4, b->seed + 4);
    float relief = 0.085f * large + 0.045f * step - 0.040f * crack + 0.028f * ledge + 0.030f * small;
    *hollow = 9.0f * (0.02f * large + 0.03f * step - 0.05f * crack + 0.022f * ledge + 0.04f * small);
    return direction * (radius + relief) * b->stretch;
}

static void evaluate_boulder(const void *shape, vec3 lattice, uint32_t face, clast_surface_point *result)
{
    const boulder *b = shape;
    vec3 direction = normalize3(lattice * (splat3(1.0f) + lattice * lattice * 0.2f)); // nearly equal squares
    float hollow, ignored;
    vec3 p = boulder_surface(b, direction, &hollow);
    vec3 side = normalize3(
        cross3(direction, abs1(direction[1]) < 0.7f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f)));
    vec3 other = cross3(direction, side);
    float step = 0.014f;
    vec3 du = boulder_surface(b, normalize3(direction + side * step), &ignored) - p;
    vec3 dv = boulder_surface(b, normalize3(direction + other * step), &ignored) - p;
    result->position = p;
    result->normal = normalize3(cross3(du, dv) * 1e3f);
    if (dot3(result->normal, direction) < 0.0f) {
        result->normal = result->normal * -1.0f;
    }
    static const float tints[SHAPES][3] = {{0.50f, 0.245f, 0.13f},
                                           {0.56f, 0.32f, 0.19f},
                                           {0.44f, 0.20f, 0.11f},
                                           {0.54f, 0.27f, 0.14f},
                                           {0.60f, 0.40f, 0.26f}};
    const float *t = tints[hash1(b->seed) % SHAPES];
    float cloud = clast_fractal3(p * 1.6f, 4, b->seed + 6);
    vec3 colour = vec3(t[0], t[1], t[2]) * (1.0f + 0.35f * cloud);
    float varnish = smooth_step(0.05f, 0.4f,
                                clast_fractal3(vec3(p[0] * 2.6f, p[1] * 0.8f, p[2] * 2.6f), 3, b->seed + 7));
    colour = mix3(colour, vec3(0.22f, 0.11f, 0.075f), 0.5f * varnish);
    colour = colour * clamp1(1.0f + 0.45f * hollow, 0.5f, 1.25f);
    result->colour = mix3(colour, CLAST_SAND_COLOUR, 0.45f * smooth_step(0.1f, -0.45f, p[1]));
    uint32_t axis = face / 2;
    result->coordinates = vec2(p[(axis + 1) % 3], p[(axis + 2) % 3]) * 0.42f + vec2(0.31f, 0.17f) * (float)face;
}

// ------------------------------------------------------------------------------------------------------- scattering

typedef struct scatter {
    clast_canyon *canyon;
    const uint32_t *meshes;
    uint32_t mesh_count;
    const char *name;
} scatter;

static vec4 random_rotation(uint seed, float tumble)
{
    vec3 axis = random_direction(seed, 31);
    float tilt = 0.5f * tumble * swing(seed, 32, 0), turns = chance(seed, 33, 0);
    // First about y, then tumbled about a level axis.
    axis = normalize3(vec3(axis[0], 0.0f, axis[2]) + vec3(1e-3f, 0.0f, 0.0f));
    float s = wave_sine(0.5f * tilt), c = wave_cosine(0.5f * tilt), ys = wave_sine(0.5f * turns),
          yc = wave_cosine(0.5f * turns);
    vec4 q = vec4(axis[0] * s * yc - axis[2] * s * ys, c * ys, axis[2] * s * yc + axis[0] * s * ys, c * yc);
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return q * (1.0f / length);
}

static float floor_height(const clast_canyon *canyon, float x, float z)
{
    float ground = clast_canyon_ground(canyon, x, z);
    return length2(vec2(x, z)) < CLAST_PLAZA_RADIUS - 0.3f ? max1(ground, 0.0f) : ground;
}

// Puts one down, sunk by `sink` of its size; the lowest ground under it counts, so that none hovers on a slope.
static void put(scatter *s, float x, float z, float size, float sink, float tumble, uint seed)
{
    float reach = 0.55f * size;
    float ground = floor_height(s->canyon, x, z);
    for (uint32_t i = 0; i < 4; i++) {
        float dx = i < 2 ? (i == 0 ? reach : -reach) : 0.0f, dz = i < 2 ? 0.0f : (i == 2 ? reach : -reach);
        ground = min1(ground, 0.5f * (ground + floor_height(s->canyon, x + dx, z + dz)));
    }
    vec3 scale = vec3(size * (1.0f + 0.18f * swing(seed, 41, 0)), size * (1.0f + 0.18f * swing(seed, 42, 0)),
                      size * (1.0f + 0.18f * swing(seed, 43, 0)));
    uint32_t mesh = s->meshes[hash2(seed, 44) % s->mesh_count];
    vec3 place = vec3(x, ground + size * (0.52f - sink), z);
    clast_gltf_add_node(&s->canyon->writer, s->name, mesh, place, random_rotation(seed, tumble), scale);
}

static bool kept_clear(float x, float z, float size)
{
    float radius = length2(vec2(x, z));
    bool plaza = radius < CLAST_PLAZA_RADIUS + 0.6f + 1.1f * size;
    bool way = abs1(x) < 2.6f + size && z > 10.0f && z < 50.0f;
    // Where the cameras stand, and what they look across.
    bool view = abs1(x + 0.36f * z) < 2.5f + 1.2f * size && z > 14.0f && z < 40.0f && size > 0.3f;
    return plaza || way || view;
}

static void scatter_around(scatter *s, uint32_t count, float inner, float outer, float small, float large, uint seed)
{
    for (uint32_t i = 0, tries = 0; i < count && tries < 20 * count; tries++) {
        uint own = hash2(seed, tries);
        float turns = chance(own, 1, 1), t = chance(own, 2, 1);
        float radius = inner + (outer - inner) * t * t;
        float x = radius * wave_cosine(turns), z = radius * wave_sine(turns);
        float size = small + (large - small) * square(square(chance(own, 3, 1)));
        // In swarms, not evenly.
        float swarm = clast_noise2(vec2(x, z) * 0.11f, seed + 7);
        if (swarm < 0.35f * swing(own, 4, 1) || kept_clear(x, z, size)) {
            continue;
        }
        put(s, x, z, size, 0.18f + 0.25f * chance(own, 5, 1), size < 0.5f ? 1.0f : 0.22f, own);
        i++;
    }
}

// Fallen from the cliffs: on the talus, larger ones farther down.
static void scatter_below_cliffs(scatter *s, uint32_t count, uint seed)
{
    for (uint32_t i = 0, tries = 0; i < count && tries < 40 * count; tries++) {
        uint own = hash2(seed, tries);
        const clast_mesa *mesa = &s->canyon->mesas[hash2(own, 1) % 4];
        float turns = chance(own, 2, 2), reach = mesa->radius * (0.6f + 0.9f * chance(own, 3, 2));
        float x = mesa->centre[0] + reach * wave_cosine(turns), z = mesa->centre[1] + reach * wave_sine(turns);
        float distance = clast_mesa_distance(mesa, x, z);
        if (distance < 0.0f || distance > 0.75f * mesa->height || z > 40.0f) {
            continue;
        }
        float size = 0.45f + 4.8f * square(square(square(chance(own, 4, 2)))) + 1.3f * distance / mesa->height;
        if (kept_clear(x, z, size)) {
            continue;
        }
        put(s, x, z, size, 0.22f + 0.2f * chance(own, 5, 2), 0.4f, own);
        i++;
    }
}

// Placed by hand, for the pictures.
static void place_known(scatter *s, uint seed)
{
    static const struct {
        float x, z, size;
    } known[] = {
        {-21.5f, -7.5f, 3.3f},  {-24.5f, -11.5f, 5.2f}, {-19.0f, -12.5f, 1.5f}, {21.5f, -9.5f, 4.2f},
        {25.5f, -14.0f, 6.0f},  {19.4f, -5.2f, 1.6f},   {24.0f, 3.5f, 2.4f},    {-22.6f, 5.0f, 2.2f},
        {-20.4f, 7.6f, 1.1f},   {9.5f, 23.5f, 1.9f},    {12.3f, 22.2f, 1.0f},   {7.9f, 24.9f, 0.7f},
        {-20.5f, 15.8f, 1.7f},  {-18.9f, 17.3f, 0.8f},  {16.0f, -24.0f, 3.1f},  {-9.0f, -27.0f, 2.7f},
        {-34.0f, -22.0f, 7.0f}, {38.0f, -30.0f, 7.6f},  {30.0f, -2.0f, 3.2f},   {3.0f, -36.0f, 3.6f},
    };
    for (uint i = 0; i < sizeof known / sizeof known[0]; i++) {
        put(s, known[i].x, known[i].z, known[i].size, 0.26f, 0.12f, hash2(seed, i));
    }
}

void clast_canyon_build_boulders(clast_canyon *canyon, double triangles)
{
    uint32_t meshes[SHAPES];
    uint32_t segments = (uint32_t)sqrt(triangles / (12.0 * SHAPES));
    segments = segments < 3 ? 3 : segments > 900 ? 900 : segments;
    for (uint32_t i = 0; i < SHAPES; i++) {
        char name[24];
        snprintf(name, sizeof name, "boulder %u", i + 1);
        boulder shape = make_boulder(hash2(canyon->seed + 500, i));
        clast_block block = {.shape = &shape, .evaluate = evaluate_boulder, .segments = {segments, segments, segments}};
        clast_gltf_begin_mesh(&canyon->writer);
        clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_ROCK]);
        clast_build_block(&canyon->builder, &block);
        clast_gltf_end_primitive(&canyon->writer);
        meshes[i] = clast_gltf_end_mesh(&canyon->writer, name);
    }
    scatter s = {canyon, meshes, SHAPES, "boulder"};
    place_known(&s, canyon->seed + 510);
    scatter_below_cliffs(&s, 420, canyon->seed + 520);
    scatter_around(&s, 110, 18.0f, 90.0f, 0.3f, 2.2f, canyon->seed + 530);
    s.name = "stone";
    scatter_around(&s, 520, 17.5f, 48.0f, 0.05f, 0.34f, canyon->seed + 540);
}

// ------------------------------------------------------------------------------------------------------------ grass

typedef struct blade {
    float turn, lean, length, width, offset, curl;
    vec3 colour;
} blade;

static void evaluate_blade(const void *shape, float u, float v, clast_surface_point *point)
{
    const blade *b = shape;
    float c = wave_cosine(b->turn), s = wave_sine(b->turn);
    // A parabola outwards and down.
    float out = b->offset + b->length * b->lean * v * (0.35f + 0.65f * v * b->curl);
    float up = b->length * v * (1.0f - 0.45f * b->lean * v * b->curl);
    float side = b->width * (u - 0.5f) * (1.0f - 0.92f * v * v);
    point->position = vec3(c * out - s * side, up - 0.03f, s * out + c * side);
    point->colour = b->colour * mix1(0.55f, 1.0f, v);
    point->coordinates = vec2(u, v);
}

static uint32_t build_tuft(clast_canyon *canyon, const char *name, uint32_t blades, uint32_t rows, uint seed)
{
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_STRAW]);
    for (uint32_t i = 0; i < blades; i++) {
        float dry = chance(seed, i, 8);
        blade b = {
            .turn = chance(seed, i, 1),
            .lean = 0.15f + 0.75f * chance(seed, i, 2),
            .length = 0.32f + 0.46f * chance(seed, i, 3),
            .width = 0.009f + 0.008f * chance(seed, i, 4),
            .offset = 0.09f * root(chance(seed, i, 5)),
            .curl = 0.5f + 0.9f * chance(seed, i, 6),
            .colour = mix3(vec3(0.46f, 0.36f, 0.17f), vec3(0.62f, 0.50f, 0.28f), dry),
        };
        clast_sheet sheet = {.shape = &b, .evaluate = evaluate_blade, .columns = 1, .rows = rows};
        clast_build_sheet(&canyon->builder, &sheet);
    }
    clast_gltf_end_primitive(&canyon->writer);
    return clast_gltf_end_mesh(&canyon->writer, name);
}

void clast_canyon_build_grass(clast_canyon *canyon, double triangles)
{
    double each = triangles / 3.0;
    uint32_t rows = each > 3000.0 ? 6 : each > 600.0 ? 4 : 2;
    double wanted = each / (2.0 * (double)rows);
    uint32_t blades = wanted < 6.0 ? 6 : wanted > 240.0 ? 240 : (uint32_t)wanted;
    uint32_t meshes[3];
    for (uint32_t i = 0; i < 3; i++) {
        meshes[i] = build_tuft(canyon, "tuft", blades, rows, hash2(canyon->seed + 600, i));
    }
    static const float known[][2] = {{-4.7f, 18.7f}, {-4.2f, 19.3f}, {-8.4f, 20.4f}, {0.7f, 17.3f},
                                     {-1.9f, 18.4f}, {-7.6f, 17.6f}, {4.6f, 18.3f}};
    for (uint32_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        float x = known[i][0], z = known[i][1];
        vec3 place = vec3(x, clast_canyon_ground(canyon, x, z) - 0.02f, z);
        clast_gltf_add_node(&canyon->writer, "tuft", meshes[i % 3], place,
                            random_rotation(hash2(canyon->seed + 605, i), 0.05f), splat3(0.75f));
    }
    for (uint32_t i = 0, tries = 0; i < 260 && tries < 6000; tries++) {
        uint own = hash2(canyon->seed + 610, tries);
        float turns = chance(own, 1, 1), radius = 17.6f + 46.0f * square(chance(own, 2, 1));
        float x = radius * wave_cosine(turns), z = radius * wave_sine(turns);
        float swarm = clast_noise2(vec2(x, z) * 0.16f, canyon->seed + 620);
        bool way = abs1(x) < 2.3f && z > 10.0f && z < 48.0f;
        if (swarm < 0.12f + 0.3f * swing(own, 3, 1) || way) {
            continue;
        }
        float size = 0.6f + 0.8f * chance(own, 4, 1);
        vec3 place = vec3(x, clast_canyon_ground(canyon, x, z) - 0.02f, z);
        clast_gltf_add_node(&canyon->writer, "tuft", meshes[hash2(own, 5) % 3], place, random_rotation(own, 0.05f),
                            splat3(size));
        i++;
    }
}
