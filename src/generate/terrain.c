// SPDX-License-Identifier: Apache-2.0
// The canyon's floor: sand flats, dunes, talus at the feet of the cliffs, drifts on the pavement, hills far away.
#include "generate/canyon.h"

#include "base/thread.h"
#include "generate/picture.h"

// Half the side of the ground, and where the grid is densest: before the monument.
static const float EXTENT = 1900.0f;
static const float DENSE_Z = 9.0f;

// Sand that the wind has piled on the pavement: more in the lee of the monument.
static float drift_height(float x, float z, uint seed)
{
    float angle_lee = 0.75f * x - 0.66f * z; // away from the sun's side the wind rests
    float drift = clast_fractal2(vec2(x, z) * 0.11f, 3, seed + 50) + 0.012f * angle_lee;
    float radius = length2(vec2(x, z));
    float rim = smooth_step(9.5f, CLAST_PLAZA_RADIUS + 0.8f, radius);
    return -0.34f + 0.62f * smooth_step(-0.1f, 0.55f, drift + 0.62f * rim - 0.28f);
}

static float dune_height(float x, float z, uint seed)
{
    vec2 p = vec2(x, z) * (1.0f / 46.0f);
    vec2 warp = vec2(clast_noise2(p * 0.6f + vec2(3.1f, 0.0f), seed + 60),
                     clast_noise2(p * 0.6f + vec2(0.0f, 5.7f), seed + 61));
    float crest = 1.0f - abs1(clast_noise2(vec2(p[0] * 0.55f + p[1] * 0.2f, p[1] * 1.25f) + warp * 0.7f, seed + 62));
    return 2.6f * crest * crest * crest;
}

// How near the foot of a cliff is, 0 to 1; and the height of the debris there, below the ground where there is none.
typedef struct foothill {
    float nearness, height;
} foothill;

static foothill foothill_at(const clast_canyon *canyon, float x, float z)
{
    foothill found = {0.0f, -9.0f};
    for (uint32_t i = 0; i < CLAST_MESA_COUNT; i++) {
        const clast_mesa *mesa = &canyon->mesas[i];
        float distance = clast_mesa_distance(mesa, x, z);
        float t = clamp1(1.0f - distance / (0.80f * mesa->height), 0.0f, 1.0f);
        if (t > 0.0f) {
            found.nearness = max1(found.nearness, t);
            found.height = max1(found.height, clast_mesa_apron(mesa, x, z, distance));
        }
    }
    return found;
}

typedef struct ground {
    float height; // of the sand
    foothill foothill;
    float plaza; // 0 to 1: on the pavement
} ground;

static ground ground_at(const clast_canyon *canyon, float x, float z)
{
    uint seed = canyon->seed;
    float radius = length2(vec2(x, z));
    float plaza = 1.0f - smooth_step(CLAST_PLAZA_RADIUS - 0.3f, CLAST_PLAZA_RADIUS + 5.0f, radius);
    float near = smooth_step(70.0f, 30.0f, radius);
    float swell = 0.9f * clast_fractal2(vec2(x, z) * (1.0f / 34.0f), 2, seed + 70);
    if (near > 0.0f) {
        swell += near * 0.14f * clast_fractal2(vec2(x, z) * 0.25f, 4, seed + 71);
    }
    float away = smooth_step(26.0f, 85.0f, radius);
    float open = 0.12f + swell * smooth_step(14.0f, 40.0f, radius) + dune_height(x, z, seed) * away;
    // The way to the monument is kept low between banks.
    float way = (1.0f - smooth_step(2.6f, 6.5f, abs1(x))) * smooth_step(8.0f, 14.0f, z) *
                (1.0f - smooth_step(40.0f, 62.0f, z));
    open = mix1(open, -0.05f + 0.20f * clast_fractal2(vec2(x, z) * 0.33f, 3, seed + 72), way);
    float hills = smooth_step(700.0f, 1900.0f, radius);
    if (hills > 0.0f) {
        open += 210.0f * hills * clast_ridged2(vec2(x, z) * (1.0f / 720.0f), 6, seed + 74);
    }
    float height = plaza > 0.0f ? mix1(open, drift_height(x, z, seed), plaza) : open;
    return (ground){height, foothill_at(canyon, x, z), plaza};
}

float clast_canyon_ground(const clast_canyon *canyon, float x, float z)
{
    ground here = ground_at(canyon, x, z);
    return max1(here.height, here.foothill.height);
}

// Squares small near the middle, larger with distance: t in [-1, 1].
static float stretch(float t)
{
    float t2 = t * t;
    return EXTENT * t * (0.020f + 0.10f * t2 * t2 + 0.88f * t2 * t2 * t2);
}

static void evaluate_ground(const void *shape, float u, float v, clast_surface_point *point)
{
    const clast_canyon *canyon = shape;
    float x = stretch(2.0f * u - 1.0f), z = DENSE_Z + stretch(2.0f * v - 1.0f);
    ground here = ground_at(canyon, x, z);
    point->position = vec3(x, here.height, z);
    // Large fields of paler and redder sand; debris takes the colour of its rock.
    float tint = clast_fractal2(vec2(x, z) * (1.0f / 23.0f), 4, canyon->seed + 80);
    float patches = clast_fractal2(vec2(x, z) * 0.55f, 3, canyon->seed + 81);
    vec3 colour = CLAST_SAND_COLOUR * (1.0f + 0.16f * tint + 0.10f * patches);
    colour = mix3(colour, vec3(0.60f, 0.33f, 0.17f), clamp1(0.35f + 0.9f * tint, 0.0f, 0.55f));
    float nearness = here.foothill.nearness;
    float stony = smooth_step(0.0f, 0.45f, nearness + 0.25f * clast_fractal2(vec2(x, z) * 0.09f, 4, canyon->seed + 82));
    colour = mix3(colour, vec3(0.56f, 0.31f, 0.17f), 0.6f * stony * (nearness > 0.0f ? 1.0f : 0.0f));
    colour = mix3(colour, CLAST_SAND_COLOUR * 1.06f, 0.7f * here.plaza);
    float distance = length2(vec2(x, z));
    point->colour = min3(mix3(colour, CLAST_HAZE_COLOUR, 0.78f * smooth_step(120.0f, 1300.0f, distance)), splat3(1.0f));
    // Texture coordinates bend a little, so that the ripples' repetition does not line up.
    vec2 bend = vec2(clast_noise2(vec2(x, z) * 0.045f, canyon->seed + 83),
                     clast_noise2(vec2(x, z) * 0.045f + splat2(9.0f), canyon->seed + 84));
    point->coordinates = vec2(x, z) * 0.19f + bend * 0.75f;
}

void clast_canyon_build_terrain(clast_canyon *canyon, double triangles)
{
    // The front is up: d/du x d/dv = x cross z is down.
    clast_sheet sheet = {.shape = canyon, .evaluate = evaluate_ground, .flipped = true};
    clast_sheet_divide(&sheet, triangles, 1.0f, 1.0f);
    clast_gltf_begin_mesh(&canyon->writer);
    clast_gltf_begin_primitive(&canyon->writer, canyon->materials[CLAST_CANYON_SAND]);
    clast_build_sheet(&canyon->builder, &sheet);
    clast_gltf_end_primitive(&canyon->writer);
    uint32_t mesh = clast_gltf_end_mesh(&canyon->writer, "ground");
    clast_gltf_add_node(&canyon->writer, "ground", mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
}

// ------------------------------------------------------------------------------------------------- the height map

typedef struct height_job {
    const clast_canyon *canyon;
    uint32_t pixels;
    float size;
} height_job;

static float height_texel(const void *data, uint32_t x, uint32_t y)
{
    const height_job *job = data;
    float step = job->size / (float)job->pixels;
    return clast_canyon_ground(job->canyon, ((float)x + 0.5f) * step - 0.5f * job->size,
                               ((float)y + 0.5f) * step - 0.5f * job->size);
}

void clast_canyon_write_heights(clast_canyon *canyon, const char *name, uint32_t pixels, float size, float *low,
                                float *high)
{
    height_job job = {canyon, pixels, size};
    clast_picture_write_heights(canyon->outputs, name, pixels, pixels, height_texel, &job, low, high);
}
