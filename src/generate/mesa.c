// SPDX-License-Identifier: Apache-2.0
// Table mountains: strata of unlike hardness, joints and alcoves.
#include "generate/canyon.h"

// Insets and heights of the silhouette, over the mountain's height, and the share of rows of the stretch that begins here.
static const struct {
    float inset, height, rows;
} profile[] = {
    {-0.64f, 0.00f, 0.23f}, {0.00f, 0.26f, 0.18f}, {0.05f, 0.41f, 0.09f}, {0.17f, 0.485f, 0.34f},
    {0.205f, 0.93f, 0.07f}, {0.25f, 0.99f, 0.05f}, {0.60f, 1.02f, 0.04f}, {1.00f, 1.03f, 0.0f},
};
enum { PROFILE_STRETCHES = sizeof profile / sizeof profile[0] - 1 };
static const float APRON = 0.64f; // reach of the debris at the foot, over the height

float clast_mesa_apron(const clast_mesa *mesa, float x, float z, float distance)
{
    float t = clamp1(1.0f - distance / (APRON * mesa->height), 0.0f, 1.05f);
    if (t <= 0.0f) {
        return -9.0f;
    }
    float gullies = clast_ridged2(vec2(x, z) * (1.0f / 38.0f), 3, mesa->seed + 41);
    float lobes = clast_fractal2(vec2(x, z) * 0.045f, 3, mesa->seed + 42);
    return mesa->height * (0.30f * t * t * (0.80f + 0.40f * gullies + 0.30f * lobes)) - 1.2f * (1.0f - t);
}

// Scree: blocks of all sizes.
static float scree_relief(vec3 p, uint seed)
{
    clast_cells large = clast_cells3(p * 0.23f, seed + 43), small = clast_cells3(p * 0.7f, seed + 44);
    float a = unit_float(large.id) < 0.35f ? root(1.0f - square(large.nearest / 0.55f)) : 0.0f;
    float b = root(1.0f - square(small.nearest / 0.6f)) * (0.3f + 0.7f * unit_float(small.id));
    return 1.1f * a + 0.40f * b + 0.5f * clast_fractal3(p * 0.35f, 3, seed + 45);
}

void clast_canyon_place_mesas(clast_canyon *canyon)
{
    // Left and right of the view from the south, a gate of two in the middle distance, and lines of them behind.
    const clast_mesa mesas[CLAST_MESA_COUNT] = {
        {vec2(-128.0f, -62.0f), 92.0f, 0.72f, 0.22f, 62.0f, -0.25f, 0.27f, 0.04f, 0.20f, 1},
        {vec2(128.0f, -150.0f), 98.0f, 0.70f, -0.10f, 74.0f, 0.12f, 0.63f, 0.10f, 0.33f, 2},
        {vec2(22.0f, -262.0f), 34.0f, 0.8f, 0.05f, 92.0f, 0.0f, 1.0f, 0.20f, 0.13f, 3},
        {vec2(-62.0f, -330.0f), 46.0f, 0.75f, 0.2f, 70.0f, 0.0f, 1.0f, 0.28f, 0.08f, 4},
        {vec2(-190.0f, -520.0f), 150.0f, 0.55f, 0.05f, 118.0f, 0.0f, 1.0f, 0.45f, 0.08f, 5},
        {vec2(160.0f, -640.0f), 190.0f, 0.5f, -0.06f, 128.0f, 0.0f, 1.0f, 0.55f, 0.08f, 6},
        {vec2(-30.0f, -980.0f), 240.0f, 0.45f, 0.02f, 150.0f, 0.0f, 1.0f, 0.68f, 0.05f, 7},
        {vec2(-520.0f, -900.0f), 260.0f, 0.5f, 0.08f, 165.0f, 0.0f, 1.0f, 0.72f, 0.04f, 8},
        {vec2(560.0f, -1040.0f), 300.0f, 0.5f, -0.05f, 175.0f, 0.0f, 1.0f, 0.75f, 0.04f, 9},
    };
    for (uint32_t i = 0; i < CLAST_MESA_COUNT; i++) {
        canyon->mesas[i] = mesas[i];
        canyon->mesas[i].seed = hash2(canyon->seed, 100 + mesas[i].seed);
    }
}

// The foot's distance from the centre, in a direction of unit length.
static float foot_radius(const clast_mesa *mesa, vec2 direction)
{
    float c = wave_cosine(mesa->turn), s = wave_sine(mesa->turn);
    float along = direction[0] * c + direction[1] * s, across = direction[1] * c - direction[0] * s;
    float radius = mesa->radius / sqrtf(square(along) + square(across / mesa->flatness));
    // Bays and promontories: as large as the height is, whatever the mountain's size.
    vec3 place = vec3(direction[0], direction[1], 0.0f) * (mesa->radius / (0.75f * mesa->height));
    float bays = clast_fractal3(place, 3, mesa->seed) * 0.34f;
    float notches = clast_ridged3(place * 1.35f + splat3(7.0f), 3, mesa->seed + 5);
    float reach = min1(mesa->height, 1.4f * mesa->radius);
    return radius + reach * (bays - 0.26f * square(notches));
}

float clast_mesa_distance(const clast_mesa *mesa, float x, float z)
{
    vec2 offset = vec2(x, z) - mesa->centre;
    float distance = length2(offset);
    // Noise is dear: where it cannot matter an estimate does.
    if (distance > 2.2f * mesa->radius + 1.5f * mesa->height) {
        return distance - mesa->radius;
    }
    return distance - foot_radius(mesa, distance > 0.0f ? offset * (1.0f / distance) : vec2(1.0f, 0.0f));
}

// A layer of rock, found by height: beds of uneven thickness.
typedef struct bed {
    float within; // 0 at its bottom, 1 at its top
    uint id;
} bed;

static bed find_bed(float height, float thickness, uint seed)
{
    float x = height / thickness;
    float cell = floor1(x);
    float boundary = 0.5f + 0.42f * swing(seed, (uint)(int)cell, 11);
    float lower = boundary, upper = 1.0f + 0.5f + 0.42f * swing(seed, (uint)((int)cell + 1), 11);
    float t = x - cell;
    if (t < boundary) {
        cell -= 1.0f;
        upper = boundary + 1.0f;
        lower = 0.5f + 0.42f * swing(seed, (uint)(int)cell, 11);
        t += 1.0f;
    }
    return (bed){(t - lower) / (upper - lower), hash2(seed, (uint)(int)cell)};
}

// Heights along bedding planes, which are gently folded.
static float bedding_height(vec3 p)
{
    return p[1] + 5.0f * clast_fractal2(vec2(p[0], p[2]) * (1.0f / 140.0f), 2, 31) + 0.010f * p[0] - 0.012f * p[2];
}

vec3 clast_rock_colour(vec3 p, uint seed)
{
    static const float palette[8][3] = {
        {0.52f, 0.235f, 0.115f}, {0.44f, 0.175f, 0.085f}, {0.60f, 0.315f, 0.165f}, {0.49f, 0.215f, 0.12f},
        {0.66f, 0.43f, 0.27f},   {0.40f, 0.165f, 0.095f}, {0.56f, 0.26f, 0.12f},   {0.47f, 0.25f, 0.165f},
    };
    float height = bedding_height(p) + 0.5f * clast_noise3(p * 0.22f, seed + 3);
    bed thick = find_bed(height, 5.5f, 41), thin = find_bed(height, 1.1f, 43);
    const float *a = palette[thick.id & 7], *b = palette[thin.id & 7];
    vec3 colour = mix3(vec3(a[0], a[1], a[2]), vec3(b[0], b[1], b[2]), 0.34f);
    colour = colour * (1.0f + 0.28f * clast_fractal3(p * 0.11f, 3, seed + 9));
    // Desert varnish: dark streaks that ran down.
    float streaks = clast_fractal3(vec3(p[0] * 0.42f, p[1] * 0.035f, p[2] * 0.42f), 3, seed + 17);
    colour = mix3(colour, vec3(0.20f, 0.095f, 0.06f), 0.62f * smooth_step(0.06f, 0.42f, streaks));
    return min3(colour, splat3(1.0f));
}

// How far the rock stands out at a place of a cliff, in metres.
static float cliff_relief(vec3 p, float scale, uint seed)
{
    float height = bedding_height(p);
    bed thick = find_bed(height, 5.5f * scale, 41), thin = find_bed(height, 1.1f * scale, 43);
    float t = 2.0f * thick.within - 1.0f, s = 2.0f * thin.within - 1.0f;
    float bulge = (0.25f + 0.75f * unit_float(hash1(thick.id))) * root(1.0f - t * t * t * t);
    float ledge = unit_float(hash1(thin.id + 5)) * root(1.0f - s * s * s * s);
    // Columns between vertical joints, each bed its own; blocks that fell leave steps.
    float joint_shift = 3.7f * unit_float(thick.id);
    clast_cells joints = clast_cells3(vec3(p[0] * 0.115f, p[1] * 0.028f + joint_shift, p[2] * 0.115f) * (1.0f / scale),
                                      seed + 1);
    clast_cells blocks = clast_cells3(vec3(p[0] * 0.30f, p[1] * 0.22f, p[2] * 0.30f) * (1.0f / scale), seed + 2);
    float cracks = smooth_step(0.16f, 0.0f, joints.second - joints.nearest);
    float flutes = clast_ridged3(vec3(p[0] * 0.06f, p[1] * 0.012f, p[2] * 0.06f) * (1.0f / scale), 4, seed + 3);
    float small = clast_fractal3(p * (0.45f / scale), 4, seed + 4);
    float relief = 1.5f * bulge + 0.55f * ledge + 1.9f * unit_float(joints.id) + 0.8f * unit_float(blocks.id);
    return scale * (relief - 1.7f * cracks - 3.6f * flutes + 0.8f * small);
}

typedef struct mesa_shape {
    const clast_mesa *mesa;
} mesa_shape;

// Stretch and place in it of v in [0, 1]: rows are handed out by the profile's weights.
static uint32_t find_stretch(float v, float *within)
{
    uint32_t stretch = 0;
    float rest = v;
    while (stretch + 1 < PROFILE_STRETCHES && rest >= profile[stretch].rows) {
        rest -= profile[stretch++].rows;
    }
    *within = clamp1(rest / profile[stretch].rows, 0.0f, 1.0f);
    return stretch;
}

// Slender mountains draw in less than their height asks for, and never to nothing.
static float inset_radius(float foot, float inset)
{
    return inset > 0.0f ? foot * foot / (foot + inset) : foot - inset;
}

// Most columns go to the side that is seen. Turns fall with u, so that the front is outside.
static const float SEEN = 0.88f;

static float direction_at(const clast_mesa *mesa, float u)
{
    float seen = mesa->to - mesa->from;
    if (seen >= 1.0f) {
        return -u;
    }
    return u <= SEEN ? mesa->to - seen * (u / SEEN) : mesa->from - (1.0f - seen) * ((u - SEEN) / (1.0f - SEEN));
}

static void evaluate_mesa(const void *data, float u, float v, clast_surface_point *point)
{
    const clast_mesa *mesa = ((const mesa_shape *)data)->mesa;
    float turns = direction_at(mesa, u);
    vec2 direction = vec2(wave_cosine(turns), wave_sine(turns));
    float within;
    uint32_t stretch = find_stretch(v, &within);
    float inset = mix1(profile[stretch].inset, profile[stretch + 1].inset, within) * mesa->height;
    float height = mix1(profile[stretch].height, profile[stretch + 1].height, within) * mesa->height;
    float foot = foot_radius(mesa, direction);
    // Rims vary in height; benches too.
    vec3 around = vec3(direction[0], direction[1], 0.3f) * (mesa->radius / 60.0f);
    float rise = clast_fractal3(around, 3, mesa->seed + 21);
    height *= 1.0f + 0.16f * rise * smooth_step(0.3f, 1.0f, v);
    float radius = inset_radius(foot, inset);
    if (stretch + 1 == PROFILE_STRETCHES) {
        radius = inset_radius(foot, profile[stretch].inset * mesa->height) * (1.0f - within);
    }
    vec3 place = vec3(mesa->centre[0] + direction[0] * radius, height, mesa->centre[1] + direction[1] * radius);
    if (stretch == 0) {
        place[1] = clast_mesa_apron(mesa, place[0], place[2], -inset);
        place[1] += (within > 0.0f ? 1.0f - 0.6f * within : 0.0f) * scree_relief(place, mesa->seed);
    } else if (stretch == 1) { // from the apron, whatever its height is there, to the cliff
        place[1] = mix1(
            clast_mesa_apron(mesa, mesa->centre[0] + direction[0] * foot, mesa->centre[1] + direction[1] * foot, 0.0f),
            height, within);
    }
    float relief = cliff_relief(place, clamp1(mesa->height / 70.0f, 0.8f, 2.0f), mesa->seed) *
                   smooth_step(0.21f, 0.27f, v) * (1.0f - smooth_step(0.88f, 0.97f, v));
    float pull = within == 1.0f && stretch + 1 == PROFILE_STRETCHES ? 0.0f : 1.0f;
    point->position = place + vec3(direction[0], 0.0f, direction[1]) * (relief * pull);
    point->position[1] += 1.2f * clast_fractal3(place * 0.2f, 3, mesa->seed + 8) * smooth_step(0.23f, 0.4f, v) * pull;
    vec3 colour = clast_rock_colour(point->position, mesa->seed & 7);
    // Hollows are dark, edges are worn pale.
    colour = colour * clamp1(0.98f + 0.045f * relief, 0.72f, 1.18f);
    colour = mix3(colour, CLAST_SAND_COLOUR * vec3(0.96f, 0.86f, 0.78f), 0.72f * (1.0f - smooth_step(0.0f, 0.26f, v)));
    point->colour = mix3(colour, CLAST_HAZE_COLOUR, mesa->haze);
    point->coordinates = vec2((mesa->to - turns) * 6.2831853f * mesa->radius, v * 1.5f * mesa->height) * (1.0f / 9.0f);
}

void clast_canyon_build_mesas(clast_canyon *canyon, double triangles)
{
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_ROCK]);
    for (uint32_t i = 0; i < CLAST_MESA_COUNT; i++) {
        const clast_mesa *mesa = &canyon->mesas[i];
        mesa_shape shape = {mesa};
        clast_sheet sheet = {.shape = &shape, .evaluate = evaluate_mesa, .wraps_columns = true};
        float around = (mesa->to - mesa->from) * 6.2831853f * mesa->radius * 0.8f;
        clast_sheet_divide(&sheet, triangles * (double)mesa->share, around, 1.45f * mesa->height);
        clast_build_sheet(&canyon->builder, &sheet);
    }
    clast_gltf_end_primitive(&canyon->writer);
    uint32_t mesh = clast_gltf_end_mesh(&canyon->writer, "mesas");
    clast_gltf_add_node(&canyon->writer, "mesas", mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
}
