// SPDX-License-Identifier: Apache-2.0
// Computes the sky's picture by following light through the atmosphere of shared/sky.h: once scattered light is integrated
// along each direction; what is scattered more often comes from a small table, which sums the orders as a geometric series
// (Hillaire, A Scalable and Production Ready Sky and Atmosphere Rendering Technique, EGSR 2020).
#include "render/sky.h"

#include "base/thread.h"
#include "shared/light.h"

enum {
    DEPTH_WIDTH = 128,
    DEPTH_HEIGHT = 32,
    DEPTH_STEPS = 40, // by direction and height
    AGAIN_WIDTH = 32,
    AGAIN_HEIGHT = 12,
    AGAIN_STEPS = 20,
    AGAIN_ROWS = 8,
    AGAIN_COLUMNS = 8, // by the sun and height
    VIEW_STEPS = 48,
};

typedef struct sky_job {
    vec3 sun;
    float turbidity;
    packed3 *passed; // of light from the end of the air to a point: DEPTH
    packed3 *again;  // light that was scattered twice or more, the same from all sides, of a sun of 1: AGAIN
    packed3 *radiance;
    float *row_sums; // irradiance from above of each row, 3 each
} sky_job;

static vec3 exponential(vec3 v)
{
    return vec3(rough_exp(-v[0]), rough_exp(-v[1]), rough_exp(-v[2]));
}

// Value of a table at a place of [0, 1] x [0, 1], its outermost values at the edges.
static vec3 look_up(const packed3 *table, uint32_t width, uint32_t height, float x, float y)
{
    float column = clamp1(x, 0.0f, 1.0f) * (float)(width - 1), row = clamp1(y, 0.0f, 1.0f) * (float)(height - 1);
    uint32_t c = min_uint(to_uint(column), width - 2), r = min_uint(to_uint(row), height - 2);
    const packed3 *first = table + r * width + c;
    vec3 upper = mix3(load3(first[0]), load3(first[1]), column - (float)c);
    vec3 lower = mix3(load3(first[width]), load3(first[width + 1]), column - (float)c);
    return mix3(upper, lower, row - (float)r);
}

// ------------------------------------------------------------------------------------------------- light from the sun

// The layout of Bruneton and Neyret, Precomputed Atmospheric Scattering, EGSR 2008: by the distance to the ground's horizon
// and to the end of the air, so that the steep part near the horizon has room.
static float horizon_distance(float radius)
{
    return rough_sqrt(max1((radius - SKY_GROUND) * (radius + SKY_GROUND), 0.0f));
}

static vec3 passed_light(const sky_job *job, float radius, float cosine)
{
    float whole = horizon_distance(SKY_TOP), here = horizon_distance(radius);
    float least = SKY_TOP - radius, most = here + whole;
    float distance = sky_distance(radius, cosine, SKY_TOP, true);
    return look_up(job->passed, DEPTH_WIDTH, DEPTH_HEIGHT, rough_divide(distance - least, most - least),
                   rough_divide(here, whole));
}

static vec3 depth_along(float radius, float cosine, float length, float turbidity)
{
    vec3 depth = splat3(0.0f);
    for (uint32_t i = 0; i < DEPTH_STEPS; i++) {
        float near = (float)i / DEPTH_STEPS, far = (float)(i + 1) / DEPTH_STEPS;
        float begin = near * near * length, end = far * far * length;
        clast_air air = sky_air(sky_radius(radius, cosine, 0.5f * (begin + end)), turbidity);
        depth = depth + load3(air.extinction) * (end - begin);
    }
    return depth;
}

static void passed_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    sky_job *job = data;
    float whole = horizon_distance(SKY_TOP);
    for (size_t row = begin; row < end; row++) {
        float here = whole * (float)row / (DEPTH_HEIGHT - 1);
        float radius = rough_sqrt(here * here + SKY_GROUND * SKY_GROUND);
        float least = SKY_TOP - radius, most = here + whole;
        for (uint32_t column = 0; column < DEPTH_WIDTH; column++) {
            float distance = least + (most - least) * (float)column / (DEPTH_WIDTH - 1);
            float cosine = distance > 0.0f
                               ? (whole * whole - here * here - distance * distance) / (2.0f * radius * distance)
                               : 1.0f;
            vec3 depth = depth_along(radius, clamp1(cosine, -1.0f, 1.0f), distance, job->turbidity);
            job->passed[row * DEPTH_WIDTH + column] = store3(exponential(depth));
        }
    }
}

// Of a sun of 1, at a point: nothing where the ground is in between.
static vec3 sun_light(const sky_job *job, float radius, float cosine)
{
    float dip = rough_divide(horizon_distance(radius), radius);     // of the horizon, as a cosine below zero
    float lit = clamp1((cosine + dip) * 100.0f + 0.5f, 0.0f, 1.0f); // the sun is no point
    return lit > 0.0f ? passed_light(job, radius, max1(cosine, -dip)) * lit : splat3(0.0f);
}

// --------------------------------------------------------------------------------------------------- along a direction

typedef struct sky_path {
    vec3 scattered; // into the direction's start, of a sun of 1
    vec3 passed;    // of what lies behind
    vec3 again;     // scattered part of light that is 1 from all sides
} sky_path;

// From `radius` above the centre; `again` null leaves out what is scattered more than once. `phases`: false scatters evenly.
static sky_path follow(const sky_job *job, float radius, vec3 direction, vec3 sun, uint32_t steps, bool phases,
                       bool with_again)
{
    float ground = sky_distance(radius, direction[1], SKY_GROUND, false);
    float length = ground > 0.0f && direction[1] < 0.0f ? ground : sky_distance(radius, direction[1], SKY_TOP, true);
    float towards = dot3(direction, sun);
    float air_phase = phases ? sky_air_phase(towards) : 0.25f * INVERSE_PI;
    float haze_phase = phases ? sky_haze_phase(towards) : 0.25f * INVERSE_PI;
    sky_path path = {splat3(0.0f), splat3(1.0f), splat3(0.0f)};
    for (uint32_t i = 0; i < steps; i++) {
        float near = (float)i / (float)steps, far = (float)(i + 1) / (float)steps;
        float begin = near * near * length, step = far * far * length - begin;
        vec3 place = vec3(0.0f, radius, 0.0f) + direction * (begin + 0.5f * step);
        float here = sky_radius(radius, direction[1], begin + 0.5f * step);
        float sun_cosine = dot3(place, sun) / here;
        clast_air air = sky_air(here, job->turbidity);
        vec3 all = load3(air.air) + load3(air.haze);
        vec3 light = sun_light(job, here, sun_cosine);
        vec3 source = (load3(air.air) * air_phase + load3(air.haze) * haze_phase) * light;
        if (with_again) {
            float height = rough_divide(here - SKY_GROUND, SKY_TOP - SKY_GROUND);
            source = source + all * look_up(job->again, AGAIN_WIDTH, AGAIN_HEIGHT, 0.5f + 0.5f * sun_cosine,
                                            rough_sqrt(max1(height, 0.0f)));
        }
        // The integral over a step of even air is known.
        vec3 extinction = load3(air.extinction);
        vec3 step_passed = exponential(extinction * step);
        vec3 share = splat3(0.0f);
        for (int c = 0; c < 3; c++) {
            share[c] = extinction[c] > 1e-9f ? (1.0f - step_passed[c]) / extinction[c] : step;
        }
        path.scattered = path.scattered + path.passed * source * share;
        path.again = path.again + path.passed * all * share;
        path.passed = path.passed * step_passed;
    }
    return path;
}

// ------------------------------------------------------------------------------------------------------ more than once

static vec3 sphere_direction(uint32_t row, uint32_t column)
{
    float y = 1.0f - 2.0f * ((float)row + 0.5f) / AGAIN_ROWS;
    vec2 circle = circle_point(((float)column + 0.5f) / AGAIN_COLUMNS);
    float s = rough_sqrt(1.0f - y * y);
    return vec3(s * circle[0], y, s * circle[1]);
}

static void again_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    sky_job *job = data;
    const float weight = 1.0f / (AGAIN_ROWS * AGAIN_COLUMNS); // a part of the sphere, times the even phase
    for (size_t place = begin; place < end; place++) {
        float cosine = 2.0f * (float)(place % AGAIN_WIDTH) / (AGAIN_WIDTH - 1) - 1.0f;
        float height = (float)(place / AGAIN_WIDTH) / (AGAIN_HEIGHT - 1);
        float radius = SKY_GROUND + 0.01f + (SKY_TOP - SKY_GROUND - 0.02f) * height * height;
        vec3 sun = vec3(rough_sqrt(1.0f - cosine * cosine), cosine, 0.0f);
        vec3 twice = splat3(0.0f), again = splat3(0.0f);
        for (uint32_t i = 0; i < AGAIN_ROWS * AGAIN_COLUMNS; i++) {
            vec3 direction = sphere_direction(i / AGAIN_COLUMNS, i % AGAIN_COLUMNS);
            sky_path path = follow(job, radius, direction, sun, AGAIN_STEPS, false, false);
            twice = twice + path.scattered * weight;
            again = again + path.again * weight;
            float ground = sky_distance(radius, direction[1], SKY_GROUND, false);
            if (ground > 0.0f && direction[1] < 0.0f) {
                vec3 normal = normalize3(vec3(0.0f, radius, 0.0f) + direction * ground);
                vec3 light = sun_light(job, SKY_GROUND, dot3(normal, sun)) * max1(dot3(normal, sun), 0.0f);
                twice = twice + path.passed * light * (SKY_GROUND_ALBEDO * INVERSE_PI * weight);
            }
        }
        vec3 all = splat3(0.0f);
        for (int c = 0; c < 3; c++) {
            all[c] = twice[c] / max1(1.0f - again[c], 0.05f);
        }
        job->again[place] = store3(all);
    }
}

// -------------------------------------------------------------------------------------------------------------- picture

static vec3 texel_direction(uint32_t row, uint32_t column)
{
    return surroundings_direction(
        vec2(((float)column + 0.5f) / CLAST_SKY_WIDTH, ((float)row + 0.5f) / CLAST_SKY_HEIGHT), 0.0f);
}

// The sun stands over the middle, so the right half mirrors the left.
static void mirror_row(packed3 *row)
{
    for (uint32_t column = 0; column < CLAST_SKY_WIDTH / 2; column++) {
        row[CLAST_SKY_WIDTH - 1 - column] = row[column];
    }
}

static void sky_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    sky_job *job = data;
    for (size_t row = begin; row < end; row++) {
        packed3 *texels = job->radiance + row * CLAST_SKY_WIDTH;
        vec3 sum = splat3(0.0f);
        for (uint32_t column = 0; column < CLAST_SKY_WIDTH / 2; column++) {
            vec3 direction = texel_direction((uint32_t)row, column);
            sky_path path = follow(job, SKY_EYE, direction, job->sun, VIEW_STEPS, true, true);
            texels[column] = store3(path.scattered * SKY_SUN_IRRADIANCE);
            float sine = rough_sqrt(max1(1.0f - direction[1] * direction[1], 0.0f));
            sum = sum + load3(texels[column]) * (2.0f * max1(direction[1], 0.0f) * sine);
        }
        mirror_row(texels);
        for (int c = 0; c < 3; c++) {
            job->row_sums[3 * row + (size_t)c] = sum[c] *
                                                 (2.0f * PI * PI / ((float)CLAST_SKY_WIDTH * CLAST_SKY_HEIGHT));
        }
    }
}

// The earth below the horizon, lit by sun and sky.
static void add_ground(sky_job *job, vec3 irradiance)
{
    for (uint32_t row = CLAST_SKY_HEIGHT / 2; row < CLAST_SKY_HEIGHT; row++) {
        vec3 direction = texel_direction(row, 0);
        float length = sky_distance(SKY_EYE, direction[1], SKY_GROUND, false);
        if (length <= 0.0f) {
            continue;
        }
        vec3 passed = exponential(depth_along(SKY_EYE, direction[1], length, job->turbidity));
        vec3 added = passed * irradiance * (SKY_GROUND_ALBEDO * INVERSE_PI);
        for (uint32_t column = 0; column < CLAST_SKY_WIDTH; column++) {
            packed3 *texel = &job->radiance[row * CLAST_SKY_WIDTH + column];
            *texel = store3(load3(*texel) + added);
        }
    }
}

static void compute(clast_context *context, sky_job *job, clast_sky *sky)
{
    clast_parallel_for(context, DEPTH_HEIGHT, 1, passed_rows, job);
    clast_parallel_for(context, (size_t)AGAIN_WIDTH * AGAIN_HEIGHT, 8, again_rows, job);
    clast_parallel_for(context, CLAST_SKY_HEIGHT, 2, sky_rows, job);
    float dip = rough_divide(horizon_distance(SKY_EYE), SKY_EYE);
    sky->sun_irradiance = passed_light(job, SKY_EYE, max1(job->sun[1], -dip)) * SKY_SUN_IRRADIANCE;
    vec3 irradiance = sky->sun_irradiance * max1(job->sun[1], 0.0f);
    for (uint32_t row = 0; row < CLAST_SKY_HEIGHT; row++) {
        irradiance = irradiance + vec3(job->row_sums[3 * row], job->row_sums[3 * row + 1], job->row_sums[3 * row + 2]);
    }
    add_ground(job, irradiance);
}

clast_status clast_sky_create(clast_context *context, vec3 sun, float turbidity, clast_sky *sky)
{
    *sky = (clast_sky){.rotation = -rough_atan2(sun[2], sun[0])};
    float level = rough_sqrt(max1(1.0f - sun[1] * sun[1], 0.0f));
    sky_job job = {.sun = vec3(level, sun[1], 0.0f), .turbidity = turbidity};
    job.passed = clast_allocate(context, (size_t)DEPTH_WIDTH * DEPTH_HEIGHT, sizeof *job.passed);
    job.again = clast_allocate(context, (size_t)AGAIN_WIDTH * AGAIN_HEIGHT, sizeof *job.again);
    job.radiance = clast_allocate(context, (size_t)CLAST_SKY_WIDTH * CLAST_SKY_HEIGHT, sizeof *job.radiance);
    job.row_sums = clast_allocate(context, CLAST_SKY_HEIGHT, 3 * sizeof *job.row_sums);
    bool sound = job.passed != NULL && job.again != NULL && job.radiance != NULL && job.row_sums != NULL;
    if (sound) {
        compute(context, &job, sky);
        sky->radiance = job.radiance;
    } else {
        clast_free(context, job.radiance);
    }
    clast_free(context, job.passed);
    clast_free(context, job.again);
    clast_free(context, job.row_sums);
    return sound ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

void clast_sky_destroy(clast_context *context, clast_sky *sky)
{
    clast_free(context, sky->radiance);
    *sky = (clast_sky){0};
}
