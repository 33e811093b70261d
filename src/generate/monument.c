// SPDX-License-Identifier: Apache-2.0
// The centrepiece: a carved ring of stone on a drum, and in it an armillary sphere of gold around a globe of lapis.
#include "generate/canyon.h"
#include "generate/hoop.h"
#include "generate/lathe.h"
#include "generate/picture.h"

static const float RING_HEIGHT = 8.2f; // of its centre
static const vec4 UPRIGHT = {0.0f, 0.0f, 0.0f, 1.0f};
#define GOLD_COLOUR vec3(0.98f, 0.98f, 0.98f)

// Of the guilloche: an eye of it every half repeat.
enum { GUILLOCHE_REPEATS = 18 };
static const float GUILLOCHE_MIDDLE = -0.20f;

static clast_hoop ring_shape(uint seed)
{
    const clast_hoop_face face = {
        .count = 4,
        .bands =
            {
                {-0.92f, -0.76f, CLAST_ORNAMENT_BEADS, 132.0f, 0.065f, -0.02f},
                {-0.76f, -0.68f, CLAST_ORNAMENT_PLAIN, 1.0f, 0.0f, -0.035f},
                {-0.68f, 0.28f, CLAST_ORNAMENT_GUILLOCHE, GUILLOCHE_REPEATS, 0.125f, -0.045f},
                {0.38f, 0.90f, CLAST_ORNAMENT_MEANDER, 58.0f, 0.062f, -0.035f},
            },
    };
    return (clast_hoop){
        .radius = 4.6f,
        .half_radial = 1.15f,
        .half_axial = 0.85f,
        .corner = 0.20f,
        .front = face,
        .back = face,
        .outer = {.count = 3,
                  .bands = {{-0.63f, -0.52f, CLAST_ORNAMENT_BEADS, 210.0f, 0.05f, 0.0f},
                            {-0.50f, 0.50f, CLAST_ORNAMENT_SCALES, 110.0f, 0.075f, -0.02f},
                            {0.52f, 0.63f, CLAST_ORNAMENT_BEADS, 210.0f, 0.05f, 0.0f}}},
        .inner = {.count = 1, .bands = {{-0.52f, 0.52f, CLAST_ORNAMENT_COFFERS, 20.0f, 0.085f, -0.06f}}},
        .rope_repeats = 150.0f,
        .rope_depth = 0.065f,
        .back_weight = 0.5f,
        .colour = CLAST_STONE_COLOUR,
        .wear = 0.035f,
        .tile = 1.6f,
        .seed = seed,
        .bite_count = 4,
        .bites = {vec4(4.72f, 3.62f, 0.80f, 1.12f), vec4(-5.80f, 1.30f, 0.95f, 0.62f), vec4(1.9f, 5.75f, 1.05f, 0.45f),
                  vec4(-2.6f, -5.25f, 1.0f, 0.5f)},
    };
}

static void begin(clast_canyon *canyon, clast_canyon_material material)
{
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[material]);
}

static uint32_t end(clast_canyon *canyon, const char *name)
{
    clast_gltf_end_primitive(&canyon->writer);
    return clast_gltf_end_mesh(&canyon->writer, name);
}

static void place(clast_canyon *canyon, const char *name, uint32_t mesh, vec3 position, vec4 rotation)
{
    clast_gltf_add_node(&canyon->writer, name, mesh, position, rotation, splat3(1.0f));
}

static vec4 about_axis(vec3 axis, float turns)
{
    float s = wave_sine(0.5f * turns);
    return vec4(axis[0] * s, axis[1] * s, axis[2] * s, wave_cosine(0.5f * turns));
}

// --------------------------------------------------------------------------------------------------------- the ring

static void build_ring(clast_canyon *canyon, double triangles)
{
    clast_hoop ring = ring_shape(canyon->seed + 200);
    begin(canyon, CLAST_CANYON_STONE);
    clast_build_hoop(&canyon->builder, &ring, triangles);
    place(canyon, "ring", end(canyon, "ring"), vec3(0.0f, RING_HEIGHT, 0.0f), UPRIGHT);
}

// Rods of gold in the grooves between the bands, and clasps over the ring.
static void build_ring_metal(clast_canyon *canyon, double triangles)
{
    begin(canyon, CLAST_CANYON_GOLD);
    static const float offsets[2] = {-0.72f, 0.33f};
    for (uint32_t i = 0; i < 4; i++) {
        // Both faces in one hoop: only its front and back stand out of the stone.
        clast_hoop rod = {.radius = 4.6f + offsets[i & 1],
                          .half_radial = 0.034f,
                          .half_axial = 0.885f,
                          .corner = 0.033f,
                          .rope_repeats = 6.2831853f * (4.6f + offsets[i & 1]) / 0.11f,
                          .rope_depth = 0.014f,
                          .colour = GOLD_COLOUR,
                          .tile = 0.8f};
        rod.rope_repeats = floor1(rod.rope_repeats);
        if (i < 2) {
            clast_build_hoop(&canyon->builder, &rod, triangles * 0.14);
        }
    }
    for (uint32_t i = 0; i < 6; i++) {
        float middle = 0.0833333f + (float)i / 6.0f;
        clast_hoop clasp = {
            .radius = 4.6f,
            .half_radial = 1.23f,
            .half_axial = 0.93f,
            .corner = 0.22f,
            .front = {.count = 1, .bands = {{-1.0f, 1.0f, CLAST_ORNAMENT_LATTICE, 58.0f, 0.05f, 0.0f}}},
            .back = {.count = 1, .bands = {{-1.0f, 1.0f, CLAST_ORNAMENT_LATTICE, 58.0f, 0.05f, 0.0f}}},
            .outer = {.count = 1, .bands = {{-0.7f, 0.7f, CLAST_ORNAMENT_LATTICE, 58.0f, 0.05f, 0.0f}}},
            .inner = {.count = 1, .bands = {{-0.7f, 0.7f, CLAST_ORNAMENT_LATTICE, 58.0f, 0.05f, 0.0f}}},
            .back_weight = 0.5f,
            .from = middle - 0.0087f,
            .to = middle + 0.0087f,
            .end_drop = 0.16f,
            .colour = GOLD_COLOUR,
            .tile = 0.8f,
        };
        clast_build_hoop(&canyon->builder, &clasp, triangles * 0.12);
    }
    place(canyon, "ring metal", end(canyon, "ring metal"), vec3(0.0f, RING_HEIGHT, 0.0f), UPRIGHT);
}

static void evaluate_rosette(const void *shape, float u, float v, clast_surface_point *point)
{
    (void)shape;
    float c = wave_cosine(u), s = wave_sine(u), radius = v < 0.9f ? v / 0.9f : 1.0f;
    float height = clast_rosette_height(c * radius * 0.97f, s * radius * 0.97f, 8.0f);
    float dome = 0.075f * (1.0f - radius * radius) + 0.055f * height;
    point->position = vec3(0.165f * radius * c, 0.165f * radius * s, v > 0.95f ? -0.06f : dome);
    point->colour = GOLD_COLOUR * mix1(0.5f, 1.0f, height);
    point->coordinates = vec2(c, s) * (0.165f * radius / 0.8f);
}

// A flower of gold in each eye of the guilloche.
static void build_rosettes(clast_canyon *canyon, double triangles)
{
    clast_sheet sheet = {.evaluate = evaluate_rosette, .wraps_columns = true, .flipped = true};
    clast_sheet_divide(&sheet, triangles, 0.8f, 0.2f);
    begin(canyon, CLAST_CANYON_GOLD);
    clast_build_sheet(&canyon->builder, &sheet);
    uint32_t mesh = end(canyon, "rosette");
    for (uint32_t i = 0; i < 2 * GUILLOCHE_REPEATS; i++) {
        float turns = ((float)i + 0.5f) / (2.0f * GUILLOCHE_REPEATS), radius = 4.6f + GUILLOCHE_MIDDLE;
        vec3 front = vec3(radius * wave_cosine(turns), RING_HEIGHT + radius * wave_sine(turns), 0.80f);
        if (front[1] < 3.2f) {
            continue; // inside the drum
        }
        place(canyon, "rosette", mesh, front, about_axis(vec3(0.0f, 0.0f, 1.0f), turns));
        vec4 turned = about_axis(vec3(0.0f, 1.0f, 0.0f), 0.5f);
        place(canyon, "rosette", mesh, vec3(front[0], front[1], -front[2]), turned);
    }
}

// --------------------------------------------------------------------------------------------------------- the drum

static void build_drum(clast_canyon *canyon, double triangles)
{
    static const clast_lathe_point points[] = {
        {3.56f, 1.00f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.4f},
        {3.56f, 1.30f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.53f, 1.33f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.40f, 1.34f, CLAST_ORNAMENT_ROPE, 90.0f, 0.085f, 1.3f},
        {3.40f, 1.52f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.34f, 1.54f, CLAST_ORNAMENT_LEAVES, 44.0f, 0.06f, 1.2f},
        {3.12f, 1.80f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.10f, 1.82f, CLAST_ORNAMENT_COFFERS, 26.0f, 0.085f, 1.3f},
        {3.10f, 2.44f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.10f, 2.46f, CLAST_ORNAMENT_BEADS, 170.0f, 0.05f, 1.5f},
        {3.10f, 2.56f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.13f, 2.58f, CLAST_ORNAMENT_TONGUES, 60.0f, 0.06f, 1.3f},
        {3.42f, 2.82f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.48f, 2.83f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.50f, 2.86f, CLAST_ORNAMENT_MEANDER, 130.0f, 0.022f, 1.4f},
        {3.50f, 2.99f, CLAST_ORNAMENT_PLAIN, 0, 0, 1.0f},
        {3.46f, 3.02f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.5f},
        {2.30f, 3.03f, CLAST_ORNAMENT_PLAIN, 0, 0, 0.2f},
        {0.00f, 3.03f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe drum = {.points = points,
                        .point_count = sizeof points / sizeof points[0],
                        .colour = CLAST_STONE_COLOUR,
                        .wear = 0.02f,
                        .tile = 1.6f,
                        .seed = canyon->seed + 210};
    begin(canyon, CLAST_CANYON_STONE);
    clast_build_lathe(&canyon->builder, &drum, triangles);
    place(canyon, "drum", end(canyon, "drum"), splat3(0.0f), UPRIGHT);
}

// ---------------------------------------------------------------------------------------------------- the armillary

static uint32_t build_band(clast_canyon *canyon, const char *name, float radius, float width, clast_ornament ornament,
                           float repeats, double triangles)
{
    float half = 0.5f * width;
    clast_hoop band = {
        .radius = radius,
        .half_radial = 0.055f,
        .half_axial = half,
        .corner = 0.018f,
        .outer = {.count = 1, .bands = {{-half + 0.02f, half - 0.02f, ornament, repeats, 0.022f, 0.0f}}},
        .inner = {.count = 1, .bands = {{-half + 0.02f, half - 0.02f, ornament, repeats, 0.022f, 0.0f}}},
        .front = {.count = 1, .bands = {{-0.037f, 0.037f, CLAST_ORNAMENT_BEADS, floor1(radius * 70.0f), 0.014f, 0.0f}}},
        .back = {.count = 1, .bands = {{-0.037f, 0.037f, CLAST_ORNAMENT_BEADS, floor1(radius * 70.0f), 0.014f, 0.0f}}},
        .colour = GOLD_COLOUR,
        .tile = 0.8f,
    };
    begin(canyon, CLAST_CANYON_GOLD);
    clast_build_hoop(&canyon->builder, &band, triangles);
    return end(canyon, name);
}

static void evaluate_globe(const void *shape, vec3 point, uint32_t face, clast_surface_point *result)
{
    const float *radius = shape;
    // Tangent-spaced lattice lines: nearly equal squares.
    vec3 direction = normalize3(vec3(wave_sine(point[0] * 0.125f) / wave_cosine(point[0] * 0.125f),
                                     wave_sine(point[1] * 0.125f) / wave_cosine(point[1] * 0.125f),
                                     wave_sine(point[2] * 0.125f) / wave_cosine(point[2] * 0.125f)));
    result->position = direction * *radius;
    result->normal = direction;
    uint32_t axis = face / 2;
    result->coordinates = vec2(point[(axis + 1) % 3] * 0.5f + 0.13f * (float)face,
                               point[(axis + 2) % 3] * 0.5f + 0.29f * (float)face);
}

static void build_globe(clast_canyon *canyon, double triangles)
{
    static const float radius = 1.12f;
    uint32_t segments = (uint32_t)sqrt(triangles / 12.0);
    segments = segments < 3 ? 3 : segments > 512 ? 512 : segments;
    clast_block block = {.shape = &radius, .evaluate = evaluate_globe, .segments = {segments, segments, segments}};
    begin(canyon, CLAST_CANYON_LAPIS);
    clast_build_block(&canyon->builder, &block);
    place(canyon, "globe", end(canyon, "globe"), vec3(0.0f, RING_HEIGHT, 0.0f),
          about_axis(vec3(0.0f, 0.0f, 1.0f), 0.065f));
}

static void build_armillary(clast_canyon *canyon, double triangles)
{
    vec3 middle = vec3(0.0f, RING_HEIGHT, 0.0f);
    vec3 x = vec3(1.0f, 0.0f, 0.0f), z = vec3(0.0f, 0.0f, 1.0f);
    uint32_t meridian = build_band(canyon, "meridian", 2.92f, 0.34f, CLAST_ORNAMENT_TICKS, 72.0f, triangles * 0.26);
    uint32_t colure = build_band(canyon, "colure", 2.62f, 0.26f, CLAST_ORNAMENT_WAVES, 60.0f, triangles * 0.20);
    uint32_t equator = build_band(canyon, "equator", 2.42f, 0.42f, CLAST_ORNAMENT_GLYPHS, 64.0f, triangles * 0.27);
    uint32_t ecliptic = build_band(canyon, "ecliptic", 2.14f, 0.34f, CLAST_ORNAMENT_LATTICE, 72.0f, triangles * 0.17);
    place(canyon, "meridian", meridian, middle, UPRIGHT);
    // Tilted like the sky of 34 degrees north.
    place(canyon, "colure", colure, middle, about_axis(normalize3(vec3(0.25f, 1.0f, 0.0f)), 0.19f));
    place(canyon, "equator", equator, middle, about_axis(normalize3(vec3(1.0f, 0.06f, 0.32f)), 0.218f));
    place(canyon, "ecliptic", ecliptic, middle, about_axis(normalize3(vec3(1.0f, 0.10f, -0.35f)), 0.165f));
    uint32_t rib = build_band(canyon, "globe rib", 1.13f, 0.07f, CLAST_ORNAMENT_PLAIN, 1.0f, triangles * 0.02);
    place(canyon, "globe rib", rib, middle, about_axis(x, 0.25f));
    place(canyon, "globe rib", rib, middle, about_axis(normalize3(vec3(0.2f, 1.0f, 0.1f)), 0.08f));
    place(canyon, "globe rib", rib, middle, about_axis(normalize3(vec3(0.2f, 1.0f, 0.1f)), 0.33f));

    static const clast_lathe_point rod[] = {
        {0.0f, -2.90f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},     {0.07f, -2.88f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
        {0.07f, -1.62f, CLAST_ORNAMENT_ROPE, 6, 0.02f, 2}, {0.16f, -1.50f, CLAST_ORNAMENT_BEADS, 12, 0.05f, 3},
        {0.16f, -1.38f, CLAST_ORNAMENT_ROPE, 6, 0.02f, 2}, {0.09f, -1.28f, CLAST_ORNAMENT_PLAIN, 0, 0, 1},
        {0.09f, 1.28f, CLAST_ORNAMENT_ROPE, 6, 0.02f, 2},  {0.16f, 1.38f, CLAST_ORNAMENT_BEADS, 12, 0.05f, 3},
        {0.16f, 1.50f, CLAST_ORNAMENT_ROPE, 6, 0.02f, 2},  {0.07f, 1.62f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
        {0.07f, 2.88f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},     {0.0f, 2.90f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe axis = {.points = rod, .point_count = sizeof rod / sizeof rod[0], .colour = GOLD_COLOUR, .tile = 0.8f};
    begin(canyon, CLAST_CANYON_GOLD);
    clast_build_lathe(&canyon->builder, &axis, triangles * 0.04);
    place(canyon, "axis", end(canyon, "axis"), middle, about_axis(z, 0.065f));

    // Balusters that hold the meridian in the ring.
    static const clast_lathe_point baluster[] = {
        {0.0f, 2.86f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},       {0.13f, 2.90f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
        {0.13f, 3.00f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},      {0.09f, 3.04f, CLAST_ORNAMENT_LEAVES, 6, 0.03f, 2},
        {0.20f, 3.20f, CLAST_ORNAMENT_BEADS, 14, 0.04f, 2}, {0.20f, 3.28f, CLAST_ORNAMENT_FLUTES, 12, 0.03f, 2},
        {0.10f, 3.40f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},      {0.24f, 3.50f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
        {0.24f, 3.62f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe holder = {
        .points = baluster, .point_count = sizeof baluster / sizeof baluster[0], .colour = GOLD_COLOUR, .tile = 0.8f};
    begin(canyon, CLAST_CANYON_GOLD);
    clast_build_lathe(&canyon->builder, &holder, triangles * 0.04);
    uint32_t mesh = end(canyon, "baluster");
    for (uint32_t i = 0; i < 4; i++) {
        place(canyon, "baluster", mesh, middle, about_axis(z, 0.125f + 0.25f * (float)i));
    }
}

// A bud of gold on the ring's crown.
static void build_finial(clast_canyon *canyon, double triangles)
{
    static const clast_lathe_point bud[] = {
        {0.55f, -0.25f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},     {0.55f, 0.16f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
        {0.50f, 0.20f, CLAST_ORNAMENT_BEADS, 30, 0.05f, 2}, {0.50f, 0.30f, CLAST_ORNAMENT_TONGUES, 16, 0.05f, 2},
        {0.22f, 0.52f, CLAST_ORNAMENT_ROPE, 12, 0.04f, 2},  {0.22f, 0.62f, CLAST_ORNAMENT_LEAVES, 9, 0.06f, 2},
        {0.46f, 0.98f, CLAST_ORNAMENT_LEAVES, 9, 0.06f, 2}, {0.42f, 1.32f, CLAST_ORNAMENT_FLUTES, 14, 0.03f, 2},
        {0.14f, 1.72f, CLAST_ORNAMENT_PLAIN, 0, 0, 2},      {0.05f, 2.05f, CLAST_ORNAMENT_PLAIN, 0, 0, 2},
        {0.0f, 2.30f, CLAST_ORNAMENT_PLAIN, 0, 0, 0},
    };
    clast_lathe finial = {
        .points = bud, .point_count = sizeof bud / sizeof bud[0], .colour = GOLD_COLOUR, .tile = 0.8f};
    begin(canyon, CLAST_CANYON_GOLD);
    clast_build_lathe(&canyon->builder, &finial, triangles);
    place(canyon, "finial", end(canyon, "finial"), vec3(0.0f, RING_HEIGHT + 5.75f, 0.0f), UPRIGHT);
}

void clast_canyon_build_monument(clast_canyon *canyon, double triangles)
{
    build_ring(canyon, triangles * 0.46);
    build_ring_metal(canyon, triangles * 0.085);
    build_rosettes(canyon, triangles * 0.006);
    build_drum(canyon, triangles * 0.13);
    build_armillary(canyon, triangles * 0.28);
    build_globe(canyon, triangles * 0.012);
    build_finial(canyon, triangles * 0.02);
}

// --------------------------------------------------------------------------------------------------- the height map

typedef struct ornament_job {
    clast_hoop ring;
    uint32_t width, height;
} ornament_job;

static float ornament_texel(const void *data, uint32_t x, uint32_t y)
{
    const ornament_job *job = data;
    return clast_hoop_relief(&job->ring, ((float)x + 0.5f) / (float)job->width, ((float)y + 0.5f) / (float)job->height);
}

void clast_canyon_write_ornament(clast_canyon *canyon, const char *name, uint32_t width, uint32_t height, float *low,
                                 float *high)
{
    ornament_job job = {ring_shape(canyon->seed + 200), width, height};
    clast_picture_write_heights(canyon->outputs, name, width, height, ornament_texel, &job, low, high);
}
