// SPDX-License-Identifier: Apache-2.0
// The pavement around the monument, its steps and kerb, and the way that leads there, stone by stone.
#include "generate/canyon.h"
#include "generate/hoop.h"
#include "generate/lathe.h"
#include "generate/stone.h"

enum { STEPS = 4, COURSES = 8 };
static const uint32_t BOTTOM = 1u << 2; // face of axis 1, negative side

typedef struct mason {
    clast_canyon *canyon;
    double per_area; // triangles for a square metre of stone
    double area;     // laid so far
    bool laying;     // else only measuring
    bool polished;   // the courses of dark polished stone are under way; else all others
} mason;

static double surface(vec3 h)
{
    return (double)(4.0f * h[0] * h[2] + 8.0f * h[1] * (h[0] + h[2]));
}

static void lay(mason *m, clast_stone *stone)
{
    double area = surface(stone->half) + 1.2; // a little for each, however small
    m->area += area;
    if (m->laying) {
        stone->hidden_faces |= BOTTOM;
        clast_build_stone(&m->canyon->builder, stone, m->per_area * area);
    }
}

static vec3 stone_tint(uint seed)
{
    static const float tints[4][3] = {
        {1.0f, 1.0f, 1.0f}, {0.93f, 0.88f, 0.83f}, {1.06f, 1.0f, 0.94f}, {0.86f, 0.84f, 0.84f}};
    const float *t = tints[hash1(seed) & 3];
    float light = 0.90f + 0.14f * unit_float(hash2(seed, 9));
    return CLAST_STONE_COLOUR * vec3(t[0], t[1], t[2]) * light;
}

// A course of bent stones between two radii; `top` is the height of their upper side.
static void lay_course(mason *m, float inner, float outer, float top, float thickness, uint32_t count, float phase,
                       float settle, uint seed)
{
    for (uint32_t i = 0; i < count; i++) {
        uint own = hash2(seed, i);
        float middle = 0.5f * (inner + outer), length = 6.2831853f * middle / (float)count;
        float sunk = settle * square(chance(own, 1, 0)) * 2.0f;
        clast_stone stone = {
            .half = vec3(0.5f * length - 0.012f - 0.01f * chance(own, 2, 0), 0.5f * thickness,
                         0.5f * (outer - inner) - 0.012f),
            .bevel = 0.028f + 0.012f * chance(own, 3, 0),
            .centre = vec3(0.0f, top - 0.5f * thickness - sunk, 0.0f),
            .turn = ((float)i + phase) / (float)count,
            .radius = middle,
            .tilt_x = 0.55f * settle * swing(own, 4, 0),
            .tilt_z = 0.55f * settle * swing(own, 5, 0),
            .colour = stone_tint(own),
            .wear = 0.022f,
            .dust = 0.75f,
            .seed = own,
        };
        if (m->polished) {
            stone.colour = vec3(0.085f, 0.080f, 0.078f) * (0.8f + 0.5f * chance(own, 6, 0));
            stone.wear = 0.005f;
            stone.dust = 0.12f;
            stone.tilt_x *= 0.3f;
            stone.tilt_z *= 0.3f;
        }
        lay(m, &stone);
    }
}

static void lay_steps(mason *m)
{
    uint seed = m->canyon->seed + 300;
    for (uint32_t i = 0; i < STEPS; i++) {
        float outer = 7.1f - 0.86f * (float)i, inner = i + 1 < STEPS ? outer - 1.0f : 3.2f;
        lay_course(m, inner, outer, 0.27f * (float)(i + 1), 0.36f, 34 - 4 * i, 0.5f * (float)(i & 1), 0.012f, seed + i);
    }
}

static void lay_pavement(mason *m)
{
    // Radii of the joints; the band of metal lies where a course is left out.
    static const float joints[COURSES + 1] = {6.95f, 8.15f, 9.45f, 9.95f, 11.15f, 12.45f, 13.85f, 15.3f, 16.8f};
    uint seed = m->canyon->seed + 320;
    for (uint32_t i = 0; i < COURSES; i++) {
        if (i == 2 || m->polished != (i == 1 || i == 3)) {
            continue;
        }
        uint32_t count = (uint32_t)(6.2831853f * joints[i] / (1.45f + 0.12f * (float)i) + 0.5f);
        float settle = 0.010f + 0.0045f * (float)i;
        lay_course(m, joints[i], joints[i + 1], 0.0f, 0.42f, count, chance(seed, i, 3), settle, seed + i);
    }
}

// A low wall around the pavement, of which much is gone.
static void lay_kerb(mason *m)
{
    uint seed = m->canyon->seed + 340;
    const uint32_t count = 46;
    for (uint32_t i = 0; i < count; i++) {
        uint own = hash2(seed, i);
        float turn = ((float)i + 0.5f) / (float)count;
        if (abs1(turn - 0.25f) < 0.075f || chance(own, 1, 1) < 0.24f) {
            continue; // the way in, from +z; and gaps
        }
        float fallen = chance(own, 2, 1) < 0.25f ? 1.0f : 0.0f;
        clast_stone stone = {
            .half = vec3(1.12f - 0.18f * fallen, 0.34f, 0.36f),
            .bevel = 0.06f,
            .centre = vec3(0.0f, 0.24f - 0.25f * fallen - 0.1f * chance(own, 3, 1), 0.0f),
            .turn = turn,
            .radius = 17.2f + 0.12f * swing(own, 4, 1) + 0.9f * fallen,
            .tilt_x = 0.05f * swing(own, 5, 1) - 0.35f * fallen,
            .tilt_z = 0.07f * swing(own, 6, 1),
            .colour = stone_tint(own),
            .wear = 0.05f,
            .dust = 0.6f,
            .ornament = CLAST_ORNAMENT_WAVES,
            .repeats = 4.0f,
            .depth = 0.03f,
            .seed = own,
        };
        lay(m, &stone);
    }
}

// The way from the south: three rows of slabs, sunk and shifted the more the farther they are.
static void lay_way(mason *m)
{
    uint seed = m->canyon->seed + 360;
    for (uint32_t row = 0; row < 22; row++) {
        for (uint32_t column = 0; column < 3; column++) {
            uint own = hash3(seed, row, column);
            float z = 18.4f + 1.36f * (float)row, age = (float)row / 22.0f;
            float x = 1.42f * ((float)column - 1.0f) + 0.10f * swing(own, 1, 2) * (1.0f + 3.0f * age);
            if (chance(own, 2, 2) < 0.10f + 0.42f * age) {
                continue;
            }
            float ground = clast_canyon_ground(m->canyon, x, z);
            clast_stone slab = {
                .half = vec3(0.68f, 0.20f, 0.64f),
                .bevel = 0.035f,
                .centre = vec3(x, ground - 0.12f - 0.10f * age * chance(own, 3, 2), z),
                .turn = 0.25f + 0.012f * swing(own, 4, 2) * (1.0f + 2.0f * age),
                .tilt_x = 0.06f * swing(own, 5, 2),
                .tilt_z = 0.06f * swing(own, 6, 2),
                .colour = stone_tint(own),
                .wear = 0.035f,
                .dust = 0.95f,
                .seed = own,
            };
            lay(m, &slab);
        }
    }
}

static void lay_all(mason *m)
{
    lay_pavement(m);
    if (m->polished) {
        return;
    }
    lay_steps(m);
    lay_kerb(m);
    lay_way(m);
}

// A band of bronze let into the pavement, with an inscription.
static void build_inlay(clast_canyon *canyon, double triangles)
{
    static const clast_lathe_point points[] = {
        {9.93f, -0.2f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.3f},
        {9.93f, 0.0f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {9.91f, 0.012f, CLAST_ORNAMENT_GLYPHS, 150.0f, 0.016f, 1.0f},
        {9.49f, 0.012f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {9.47f, 0.0f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.3f},
        {9.47f, -0.2f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe band = {.points = points,
                        .point_count = sizeof points / sizeof points[0],
                        .colour = vec3(0.80f, 0.76f, 0.70f),
                        .tile = 0.8f};
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_GOLD]);
    clast_build_lathe(&canyon->builder, &band, triangles);
    clast_gltf_end_primitive(&canyon->writer);
    uint32_t mesh = clast_gltf_end_mesh(&canyon->writer, "inlay");
    clast_gltf_add_node(&canyon->writer, "inlay", mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
}

void clast_canyon_build_masonry(clast_canyon *canyon, double triangles)
{
    mason measure = {.canyon = canyon};
    lay_all(&measure);
    measure.polished = true;
    lay_all(&measure);
    mason m = {.canyon = canyon, .laying = true, .per_area = triangles * 0.88 / measure.area};
    clast_gltf_begin_mesh(&canyon->writer);
    for (int pass = 0; pass < 2; pass++) {
        m.polished = pass == 1;
        clast_gltf_begin_primitive(&canyon->writer,
                                   canyon->materials[m.polished ? CLAST_CANYON_MARBLE : CLAST_CANYON_STONE]);
        lay_all(&m);
        clast_gltf_end_primitive(&canyon->writer);
    }
    uint32_t mesh = clast_gltf_end_mesh(&canyon->writer, "masonry");
    clast_gltf_add_node(&canyon->writer, "masonry", mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
    build_inlay(canyon, triangles * 0.12);
}
