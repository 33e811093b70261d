// SPDX-License-Identifier: Apache-2.0
// The colonnade around the pavement: some columns stand and carry beams, some are broken, drums of others lie about.
#include "generate/canyon.h"
#include "generate/lathe.h"
#include "generate/stone.h"

enum { COLUMNS = 12, POINTS = 24 };
static const float CIRCLE = 14.4f; // of their middles
static const float SHAFT_TOP = 6.7f;

// A column's profile up to `top`, where it ends flat; returns the number of points.
static uint32_t column_profile(clast_lathe_point *points, float top)
{
    static const clast_lathe_point foot[] = {
        {0.98f, -0.30f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.3f}, {0.98f, 0.22f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.95f, 0.25f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},     {0.86f, 0.26f, CLAST_ORNAMENT_ROPE, 28.0f, 0.09f, 1.3f},
        {0.86f, 0.46f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},     {0.78f, 0.48f, CLAST_ORNAMENT_BEADS, 44.0f, 0.05f, 1.3f},
        {0.78f, 0.58f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},     {0.70f, 0.60f, CLAST_ORNAMENT_LEAVES, 16.0f, 0.07f, 1.3f},
        {0.64f, 1.10f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},     {0.655f, 1.14f, CLAST_ORNAMENT_FLUTES, 20.0f, 0.06f, 1.0f},
    };
    static const clast_lathe_point head[] = {
        {0.53f, SHAFT_TOP, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.53f, 6.76f, CLAST_ORNAMENT_ROPE, 24.0f, 0.06f, 1.4f},
        {0.53f, 6.88f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.53f, 6.92f, CLAST_ORNAMENT_LEAVES, 10.0f, 0.11f, 1.6f},
        {0.86f, 7.62f, CLAST_ORNAMENT_BEADS, 48.0f, 0.05f, 1.4f},
        {0.88f, 7.74f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.80f, 7.78f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.3f},
        {0.0f, 7.78f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    uint32_t count = 0;
    for (uint32_t i = 0; i < sizeof foot / sizeof foot[0]; i++) {
        points[count++] = foot[i];
    }
    if (top < SHAFT_TOP) {
        float radius = mix1(0.66f, 0.53f, (top - 1.14f) / (SHAFT_TOP - 1.14f));
        points[count++] = (clast_lathe_point){radius, top, CLAST_ORNAMENT_PLAIN, 0, 0, 1};
        points[count++] = (clast_lathe_point){radius * 0.93f, top + 0.02f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.5f};
        points[count++] = (clast_lathe_point){0.0f, top + 0.05f, CLAST_ORNAMENT_PLAIN, 0, 0, 0};
        return count;
    }
    for (uint32_t i = 0; i < sizeof head / sizeof head[0]; i++) {
        points[count++] = head[i];
    }
    return count;
}

static uint32_t build_column(clast_canyon *canyon, const char *name, float top, uint seed, double triangles)
{
    clast_lathe_point points[POINTS];
    bool whole = top >= SHAFT_TOP;
    clast_lathe column = {.points = points,
                          .point_count = column_profile(points, top),
                          .colour = CLAST_STONE_COLOUR * vec3(0.97f, 0.93f, 0.88f),
                          .wear = 0.03f,
                          .tile = 1.6f,
                          .seed = seed,
                          .fracture = whole ? 0.0f : top,
                          .fracture_depth = 0.55f};
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_STONE]);
    clast_build_lathe(&canyon->builder, &column, triangles * (whole ? 0.9 : 1.0));
    if (whole) {
        clast_stone abacus = {.half = vec3(0.98f, 0.17f, 0.98f),
                              .bevel = 0.04f,
                              .centre = vec3(0.0f, 7.92f, 0.0f),
                              .turn = 0.25f,
                              .colour = CLAST_STONE_COLOUR,
                              .wear = 0.035f,
                              .seed = seed + 1};
        clast_build_stone(&canyon->builder, &abacus, triangles * 0.1);
    }
    clast_gltf_end_primitive(&canyon->writer);
    return clast_gltf_end_mesh(&canyon->writer, name);
}

static uint32_t build_drum(clast_canyon *canyon, double triangles)
{
    static const clast_lathe_point points[] = {
        {0.0f, -0.02f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.5f},           {0.56f, 0.0f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.585f, 0.03f, CLAST_ORNAMENT_FLUTES, 20.0f, 0.06f, 1.0f}, {0.57f, 1.55f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.53f, 1.57f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.2f},           {0.0f, 1.60f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe drum = {.points = points,
                        .point_count = sizeof points / sizeof points[0],
                        .colour = CLAST_STONE_COLOUR * vec3(0.97f, 0.93f, 0.88f),
                        .wear = 0.045f,
                        .tile = 1.6f,
                        .seed = canyon->seed + 420,
                        .fracture = 1.57f,
                        .fracture_depth = 0.35f};
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_STONE]);
    clast_build_lathe(&canyon->builder, &drum, triangles);
    clast_gltf_end_primitive(&canyon->writer);
    return clast_gltf_end_mesh(&canyon->writer, "drum of a column");
}

static vec4 yaw(float turns)
{
    return vec4(0.0f, wave_sine(0.5f * turns), 0.0f, wave_cosine(0.5f * turns));
}

static vec4 product(vec4 a, vec4 b)
{
    return vec4(
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
        a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]);
}

static float column_turn(uint32_t i)
{
    return ((float)i + 0.5f) / (float)COLUMNS;
}

// What became of each column, from +x towards +z.
static const char fates[COLUMNS + 1] = "wblgwwwwwlww";
// w whole, b broken high, l broken low, g gone

static void build_beams(clast_canyon *canyon, double triangles)
{
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_STONE]);
    uint32_t spans = 0;
    for (uint32_t i = 0; i < COLUMNS; i++) {
        spans += fates[i] == 'w' && fates[(i + 1) % COLUMNS] == 'w';
    }
    for (uint32_t i = 0; i < COLUMNS; i++) {
        if (fates[i] != 'w' || fates[(i + 1) % COLUMNS] != 'w') {
            continue;
        }
        float turn = 0.5f * (column_turn(i) + column_turn(i + 1));
        float length = 6.2831853f * CIRCLE / (float)COLUMNS;
        clast_stone beam = {.half = vec3(0.5f * length - 0.02f, 0.44f, 0.62f),
                            .bevel = 0.05f,
                            .centre = vec3(0.0f, 8.53f, 0.0f),
                            .turn = turn,
                            .radius = CIRCLE,
                            .colour = CLAST_STONE_COLOUR,
                            .wear = 0.05f,
                            .ornament = CLAST_ORNAMENT_MEANDER,
                            .repeats = 9.0f,
                            .depth = 0.05f,
                            .seed = hash2(canyon->seed + 430, i)};
        clast_build_stone(&canyon->builder, &beam, triangles * 0.72 / (double)spans);
        clast_stone cornice = {.half = vec3(0.5f * length - 0.02f, 0.15f, 0.80f),
                               .bevel = 0.05f,
                               .centre = vec3(0.0f, 9.12f, 0.0f),
                               .turn = turn,
                               .radius = CIRCLE,
                               .colour = CLAST_STONE_COLOUR,
                               .wear = 0.07f,
                               .seed = hash2(canyon->seed + 431, i)};
        clast_build_stone(&canyon->builder, &cornice, triangles * 0.28 / (double)spans);
    }
    clast_gltf_end_primitive(&canyon->writer);
    uint32_t mesh = clast_gltf_end_mesh(&canyon->writer, "beams");
    clast_gltf_add_node(&canyon->writer, "beams", mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
}

static void place_columns(clast_canyon *canyon, uint32_t whole, uint32_t high, uint32_t low)
{
    for (uint32_t i = 0; i < COLUMNS; i++) {
        float turn = column_turn(i);
        vec3 position = vec3(CIRCLE * wave_cosine(turn), 0.0f, CIRCLE * wave_sine(turn));
        uint32_t mesh = fates[i] == 'w' ? whole : fates[i] == 'b' ? high : low;
        if (fates[i] != 'g') {
            // Each turned by a quarter more: no two side by side are worn alike; the abacus stays in line.
            clast_gltf_add_node(&canyon->writer, "column", mesh, position, yaw(0.25f - turn + 0.25f * (float)(i % 4)),
                                splat3(1.0f));
        }
    }
}

// Drums where columns fell: around the gaps, on their sides, half in the sand.
static void place_drums(clast_canyon *canyon, uint32_t drum)
{
    static const struct {
        float x, z, turn, roll, sink;
    } drums[] = {
        {10.6f, 9.6f, 0.13f, 0.1f, 0.05f},   {9.4f, 11.6f, 0.05f, 0.3f, 0.08f},   {4.4f, 17.0f, 0.42f, 0.7f, 0.16f},
        {7.6f, 18.9f, 0.30f, 0.5f, 0.24f},   {-8.6f, -11.2f, 0.2f, 0.2f, 0.05f},  {14.6f, 14.0f, 0.17f, 0.9f, 0.2f},
        {-13.2f, 19.0f, 0.36f, 0.4f, 0.26f}, {-0.7f, 17.9f, 0.07f, 0.15f, 0.10f},
    };
    vec4 lying = vec4(0.70710678f, 0.0f, 0.0f, 0.70710678f); // its axis becomes z
    for (uint32_t i = 0; i < sizeof drums / sizeof drums[0]; i++) {
        float y = clast_canyon_ground(canyon, drums[i].x, drums[i].z);
        y = max1(y, length2(vec2(drums[i].x, drums[i].z)) < CLAST_PLAZA_RADIUS ? -0.02f : -9.0f);
        vec3 position = vec3(drums[i].x, y + 0.56f - drums[i].sink, drums[i].z);
        vec4 rotation = product(yaw(drums[i].turn), product(lying, yaw(drums[i].roll)));
        clast_gltf_add_node(&canyon->writer, "drum of a column", drum, position, rotation, splat3(1.0f));
    }
}

void clast_canyon_build_columns(clast_canyon *canyon, double triangles)
{
    uint seed = canyon->seed + 400;
    uint32_t whole = build_column(canyon, "column", SHAFT_TOP + 1.0f, seed, triangles * 0.40);
    uint32_t high = build_column(canyon, "column, broken high", 4.3f, seed + 2, triangles * 0.16);
    uint32_t low = build_column(canyon, "column, broken low", 2.1f, seed + 4, triangles * 0.11);
    uint32_t drum = build_drum(canyon, triangles * 0.08);
    place_columns(canyon, whole, high, low);
    place_drums(canyon, drum);
    build_beams(canyon, triangles * 0.25);
}
