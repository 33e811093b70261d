// SPDX-License-Identifier: Apache-2.0
// What stands in the cloister's yard, as coarse meshes.
#include "generate/cloister.h"
#include "generate/noise.h"

static const vec3 UNIT = {1.0f, 1.0f, 1.0f};

// A count of quads at detail 1, for this detail: triangles grow with its square.
static uint32_t quads(const clast_cloister *cloister, double count)
{
    double scaled = count * sqrt(cloister->detail);
    return scaled < 3.0 ? 3 : (uint32_t)(scaled + 0.5);
}

// The rotation by an angle in turns about an axis of unit length.
static vec4 rotation(vec3 axis, float turns)
{
    float s = wave_sine(0.5f * turns);
    return vec4(axis[0] * s, axis[1] * s, axis[2] * s, wave_cosine(0.5f * turns));
}

static vec4 rotation_product(vec4 a, vec4 b)
{
    return vec4(
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]);
}

static vec4 turned(float turns)
{
    return rotation(vec3(0.0f, 1.0f, 0.0f), turns);
}

static void begin(clast_cloister *cloister, clast_relief_kind kind)
{
    clast_gltf_begin_mesh(&cloister->writer);
    clast_gltf_begin_primitive(&cloister->writer, cloister->materials[kind]);
}

static uint32_t end(clast_cloister *cloister, const char *name)
{
    clast_gltf_end_primitive(&cloister->writer);
    return clast_gltf_end_mesh(&cloister->writer, name);
}

// ------------------------------------------------------------------------------------------------------------ boxes

// A box with flat faces. Texture coordinates are metres over `tile`; with a tile of 0, each face shows the picture once.
typedef struct box {
    vec3 half;
    float tile;
    vec2 offset;
} box;

static void evaluate_box(const void *shape, vec3 point, uint32_t face, clast_surface_point *result)
{
    const box *b = shape;
    uint32_t axis = face / 2;
    float side = (face & 1) != 0 ? 1.0f : -1.0f;
    vec3 p = vec3(point[0] * b->half[0], point[1] * b->half[1], point[2] * b->half[2]);
    vec3 unit = b->tile > 0.0f ? p * (1.0f / b->tile) : vec3(point[0] * 0.5f, point[1] * 0.5f, point[2] * 0.5f);
    // Pictures stand upright on the sides, and none is a mirror image.
    vec2 place = axis == 0   ? vec2(-unit[2] * side, -unit[1])
                 : axis == 1 ? vec2(unit[0], unit[2] * side)
                             : vec2(unit[0] * side, -unit[1]);
    result->position = p;
    result->normal = splat3(0.0f);
    result->normal[axis] = side;
    result->coordinates = b->tile > 0.0f ? place + b->offset : place + splat2(0.5f);
}

static void build_box(clast_cloister *cloister, const box *b, double x, double y, double z)
{
    clast_block block = {
        .shape = b, .evaluate = evaluate_box, .segments = {quads(cloister, x), quads(cloister, y), quads(cloister, z)}};
    clast_build_block(&cloister->builder, &block);
}

// ------------------------------------------------------------------------------------------------------ round things

// A sphere by latitude and longitude, or a ring where `minor` is given.
typedef struct turned_shape {
    float radius, minor;
} turned_shape;

static void evaluate_sphere(const void *shape, float u, float v, clast_surface_point *point)
{
    const turned_shape *s = shape;
    float latitude = 0.5f * (v - 0.5f), ring = wave_cosine(latitude);
    point->normal = vec3(wave_cosine(u) * ring, wave_sine(latitude), -wave_sine(u) * ring);
    if (v == 0.0f || v == 1.0f) { // one place, whatever u
        point->normal = vec3(0.0f, v == 0.0f ? -1.0f : 1.0f, 0.0f);
    }
    point->position = point->normal * s->radius;
    point->coordinates = vec2(u, 1.0f - v);
}

static void evaluate_ring(const void *shape, float u, float v, clast_surface_point *point)
{
    const turned_shape *s = shape;
    vec3 outwards = vec3(wave_cosine(u), 0.0f, -wave_sine(u));
    point->normal = outwards * wave_cosine(v) + vec3(0.0f, wave_sine(v), 0.0f);
    point->position = outwards * s->radius + point->normal * s->minor;
    point->coordinates = vec2(u, -v);
}

// A log or a trunk along y: its side by u around and v up, its ends by v from the rim to the middle.
typedef struct trunk {
    float length, radius;
    float flare; // of the radius at the foot
    float bend;  // metres
    float repeats, tile;
    uint seed;
    bool is_top;
} trunk;

// The place and the outward direction at an angle and a height from 0 to 1.
static vec3 trunk_place(const trunk *t, float u, float rise, vec3 *outwards)
{
    *outwards = vec3(wave_cosine(u), 0.0f, -wave_sine(u));
    float foot = square(square(1.0f - rise));
    float lobes = 0.05f + 0.10f * foot;
    float radius = t->radius * (1.0f + t->flare * foot * (1.0f + 0.5f * wave_sine(3.0f * u + unit_float(t->seed))) +
                                lobes * clast_noise3(*outwards * 1.6f + vec3(0.0f, rise * 1.3f, 0.0f), t->seed));
    vec3 lean = vec3(wave_sine(0.23f * rise + 0.1f), 0.0f, wave_sine(0.31f * rise)) * (t->bend * rise);
    return *outwards * radius + lean + vec3(0.0f, t->length * rise, 0.0f);
}

static void evaluate_side(const void *shape, float u, float v, clast_surface_point *point)
{
    const trunk *t = shape;
    vec3 outwards;
    point->position = trunk_place(t, u, v, &outwards);
    point->normal = outwards;
    point->coordinates = vec2(u * t->repeats, -v * t->length / t->tile);
}

static void evaluate_end(const void *shape, float u, float v, clast_surface_point *point)
{
    const trunk *t = shape;
    vec3 outwards, rim = trunk_place(t, u, t->is_top ? 1.0f : 0.0f, &outwards);
    vec3 middle = trunk_place(&(trunk){.length = t->length, .bend = t->bend}, 0.0f, t->is_top ? 1.0f : 0.0f, &outwards);
    point->position = v == 0.0f ? rim : v == 1.0f ? middle : mix3(rim, middle, v);
    point->normal = vec3(0.0f, t->is_top ? 1.0f : -1.0f, 0.0f);
    point->coordinates = vec2(0.5f + 0.5f * (1.0f - v) * wave_cosine(u), 0.5f + 0.5f * (1.0f - v) * wave_sine(u));
}

static uint32_t build_trunk(clast_cloister *cloister, const char *name, trunk *t, double around, double along)
{
    clast_sheet side = {.shape = t,
                        .evaluate = evaluate_side,
                        .columns = quads(cloister, around),
                        .rows = quads(cloister, along),
                        .wraps_columns = true};
    begin(cloister, CLAST_RELIEF_BARK);
    clast_build_sheet(&cloister->builder, &side);
    clast_gltf_end_primitive(&cloister->writer);
    clast_gltf_begin_primitive(&cloister->writer, cloister->materials[CLAST_RELIEF_RINGS]);
    for (int top = 0; top < 2; top++) {
        t->is_top = top == 1;
        clast_sheet cap = {.shape = t,
                           .evaluate = evaluate_end,
                           .columns = side.columns,
                           .rows = quads(cloister, 4),
                           .wraps_columns = true,
                           .flipped = top == 0};
        clast_build_sheet(&cloister->builder, &cap);
    }
    return end(cloister, name);
}

// ------------------------------------------------------------------------------------------------------------ ground

static void evaluate_land(const void *shape, float u, float v, clast_surface_point *point)
{
    float side = *(const float *)shape;
    point->position = vec3((u - 0.5f) * side, 0.0f, (v - 0.5f) * side);
    point->normal = vec3(0.0f, 1.0f, 0.0f);
    point->coordinates = vec2(u, v);
}

void clast_cloister_build_ground(clast_cloister *cloister)
{
    box slab = {.half = vec3(13.2f, 0.20f, 13.2f), .tile = 2.4f};
    begin(cloister, CLAST_RELIEF_COBBLES);
    build_box(cloister, &slab, 66, 3, 66);
    uint32_t mesh = end(cloister, "pavement");
    clast_gltf_add_node(&cloister->writer, "pavement", mesh, vec3(0.0f, -0.20f, 0.0f), turned(0.0f), UNIT);

    static const float side = 640.0f;
    clast_sheet land = {.shape = &side,
                        .evaluate = evaluate_land,
                        .columns = quads(cloister, 96),
                        .rows = quads(cloister, 96),
                        .flipped = true};
    begin(cloister, CLAST_RELIEF_HILLS);
    clast_build_sheet(&cloister->builder, &land);
    mesh = end(cloister, "hills");
    clast_gltf_add_node(&cloister->writer, "hills", mesh, vec3(0.0f, -0.36f, 0.0f), turned(0.0f), UNIT);
}

// ------------------------------------------------------------------------------------------------- stones and globes

void clast_cloister_build_globes(clast_cloister *cloister)
{
    clast_gltf_writer *writer = &cloister->writer;
    box plinth = {.half = vec3(0.52f, 0.46f, 0.52f)};
    begin(cloister, CLAST_RELIEF_PANEL);
    build_box(cloister, &plinth, 8, 8, 8);
    uint32_t mesh = end(cloister, "plinth");
    clast_gltf_add_node(writer, "plinth", mesh, vec3(0.0f, 0.455f, 0.0f), turned(0.045f), UNIT);
    clast_gltf_add_node(writer, "plinth", mesh, vec3(4.3f, 0.40f, -2.9f),
                        rotation_product(turned(0.11f), rotation(vec3(0.0f, 0.0f, 1.0f), 0.25f)), UNIT);
    clast_gltf_add_node(writer, "plinth", mesh, vec3(-4.4f, 0.455f, -3.0f), turned(-0.03f), UNIT);

    turned_shape sphere = {.radius = 0.5f};
    clast_sheet sheet = {.shape = &sphere,
                         .evaluate = evaluate_sphere,
                         .columns = quads(cloister, 56),
                         .rows = quads(cloister, 28),
                         .wraps_columns = true};
    begin(cloister, CLAST_RELIEF_GLOBE);
    clast_build_sheet(&cloister->builder, &sheet);
    mesh = end(cloister, "globe");
    static const struct {
        float x, y, z, scale, lean, turn;
    } globes[] = {
        {0.0f, 1.405f, 0.0f, 1.0f, 0.020f, 0.10f},    {1.62f, 0.245f, 0.95f, 0.52f, 0.19f, 0.37f},
        {2.42f, 0.165f, 1.75f, 0.36f, -0.14f, 0.62f}, {-4.4f, 1.405f, -3.0f, 1.0f, 0.04f, 0.71f},
        {0.75f, 0.125f, 2.05f, 0.27f, 0.31f, 0.05f},  {3.05f, 0.36f, -1.55f, 0.75f, -0.08f, 0.25f},
    };
    for (size_t i = 0; i < sizeof globes / sizeof globes[0]; i++) {
        clast_gltf_add_node(writer, "globe", mesh, vec3(globes[i].x, globes[i].y, globes[i].z),
                            rotation_product(turned(globes[i].turn), rotation(vec3(0.0f, 0.0f, 1.0f), globes[i].lean)),
                            splat3(globes[i].scale));
    }
}

void clast_cloister_build_rings(clast_cloister *cloister)
{
    turned_shape ring = {.radius = 0.62f, .minor = 0.085f};
    clast_sheet sheet = {.shape = &ring,
                         .evaluate = evaluate_ring,
                         .columns = quads(cloister, 64),
                         .rows = quads(cloister, 10),
                         .wraps_columns = true,
                         .wraps_rows = true};
    begin(cloister, CLAST_RELIEF_ROPE);
    clast_build_sheet(&cloister->builder, &sheet);
    uint32_t mesh = end(cloister, "ring");
    // One leans on the plinth, one lies flat.
    clast_gltf_add_node(&cloister->writer, "ring", mesh, vec3(-0.89f, 0.660f, 0.28f),
                        rotation_product(turned(0.04f), rotation(vec3(0.0f, 0.0f, 1.0f), 0.200f)), UNIT);
    clast_gltf_add_node(&cloister->writer, "ring", mesh, vec3(-2.15f, 0.105f, 1.35f), turned(0.2f), UNIT);
}

// -------------------------------------------------------------------------------------------------- trees and walls

void clast_cloister_build_trees(clast_cloister *cloister)
{
    clast_gltf_writer *writer = &cloister->writer;
    trunk tree = {.length = 7.5f,
                  .radius = 0.30f,
                  .flare = 0.85f,
                  .bend = 0.9f,
                  .repeats = 2.0f,
                  .tile = 1.5f,
                  .seed = hash2(cloister->seed, 41)};
    uint32_t mesh = build_trunk(cloister, "tree", &tree, 24, 26);
    clast_gltf_add_node(writer, "tree", mesh, vec3(-2.55f, -0.15f, -0.95f), turned(0.13f), UNIT);
    clast_gltf_add_node(writer, "tree", mesh, vec3(6.4f, -0.15f, -4.0f), turned(0.55f), splat3(1.15f));
    clast_gltf_add_node(writer, "tree", mesh, vec3(-7.6f, -0.15f, -6.6f), turned(0.82f), splat3(1.3f));

    trunk log = {.length = 1.9f,
                 .radius = 0.21f,
                 .bend = 0.05f,
                 .repeats = 2.0f,
                 .tile = 1.5f,
                 .seed = hash2(cloister->seed, 43)};
    mesh = build_trunk(cloister, "log", &log, 20, 20);
    static const struct {
        float x, y, z, turn, roll;
    } logs[] = {
        {2.00f, 0.215f, -3.30f, 0.035f, 0.10f}, {1.95f, 0.215f, -3.76f, 0.030f, 0.45f},
        {2.05f, 0.215f, -2.84f, 0.022f, 0.70f}, {2.02f, 0.60f, -3.53f, 0.026f, 0.25f},
        {1.98f, 0.60f, -3.07f, 0.033f, 0.90f},  {2.10f, 0.98f, -3.30f, 0.040f, 0.62f},
    };
    for (size_t i = 0; i < sizeof logs / sizeof logs[0]; i++) {
        vec4 lying = rotation(vec3(0.0f, 0.0f, 1.0f), -0.25f);
        vec4 rolled = rotation_product(lying, turned(logs[i].roll));
        clast_gltf_add_node(writer, "log", mesh, vec3(logs[i].x - 0.95f, logs[i].y, logs[i].z),
                            rotation_product(turned(logs[i].turn), rolled), UNIT);
    }
}

enum { WALL_STONES = 4 };

static void build_wall(clast_cloister *cloister, const uint32_t meshes[WALL_STONES], vec3 from, float turn,
                       float length, uint seed)
{
    static const float height = 0.34f;
    vec3 along = vec3(wave_cosine(turn), 0.0f, -wave_sine(turn));
    for (uint course = 0; course < 4; course++) {
        float x = 0.45f * chance(seed, course, 1);
        for (uint i = 0; x < length; i++) {
            uint at = hash3(seed, course, i);
            float width = 0.66f + 0.34f * chance(at, 1, 0);
            bool is_gone = course == 3 && chance(at, 2, 0) < 0.42f;
            if (!is_gone) {
                vec3 place = from + along * (x + 0.5f * width) +
                             vec3(0.03f * swing(at, 3, 0), (0.5f + (float)course) * height, 0.03f * swing(at, 4, 0));
                vec4 turned_stone = turned(turn + 0.012f * swing(at, 5, 0) + (chance(at, 6, 0) < 0.5f ? 0.5f : 0.0f));
                clast_gltf_add_node(
                    &cloister->writer, "stone", meshes[at % WALL_STONES], place,
                    rotation_product(turned_stone, rotation(vec3(0.0f, 0.0f, 1.0f), 0.006f * swing(at, 7, 0))),
                    vec3(width / 0.86f, 1.0f, 0.95f + 0.15f * chance(at, 8, 0)));
            }
            x += width + 0.012f;
        }
    }
}

void clast_cloister_build_walls(clast_cloister *cloister)
{
    uint32_t meshes[WALL_STONES];
    for (uint32_t i = 0; i < WALL_STONES; i++) {
        box stone = {.half = vec3(0.41f, 0.155f, 0.25f),
                     .tile = 1.1f,
                     .offset = vec2(chance(cloister->seed, 51, i), chance(cloister->seed, 52, i))};
        begin(cloister, CLAST_RELIEF_ASHLAR);
        build_box(cloister, &stone, 6, 3, 4);
        meshes[i] = end(cloister, "stone");
    }
    build_wall(cloister, meshes, vec3(-12.8f, 0.0f, -7.4f), 0.0f, 10.4f, hash2(cloister->seed, 61));
    build_wall(cloister, meshes, vec3(0.4f, 0.0f, -7.5f), 0.0f, 12.4f, hash2(cloister->seed, 62));
    build_wall(cloister, meshes, vec3(12.9f, 0.0f, -7.2f), -0.25f, 15.0f, hash2(cloister->seed, 63));
    build_wall(cloister, meshes, vec3(-12.9f, 0.0f, -7.0f), -0.25f, 15.0f, hash2(cloister->seed, 64));
}
