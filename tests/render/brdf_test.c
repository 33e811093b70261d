// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>

#include "shared/brdf.h"

#define assert_near(value, expected, tolerance) \
    assert_true(fabs((double)(value) - (double)(expected)) <= (double)(tolerance))

static const float roughnesses[] = {0.0f, 0.05f, 0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.85f, 1.0f};
static const float cosines[] = {0.02f, 0.1f, 0.3f, 0.6f, 0.9f, 1.0f};
enum { ROUGHNESSES = sizeof roughnesses / sizeof roughnesses[0], COSINES = sizeof cosines / sizeof cosines[0] };

static vec3 view_of(float cosine)
{
    return vec3(sqrtf(1.0f - cosine * cosine), 0.0f, cosine);
}

// What a surface reflects of light from everywhere, by its own sampling.
static vec3 reflected(clast_brdf brdf, vec3 view, uint32_t count)
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < count; i++) {
        vec3 light = brdf_direction(brdf, view, sample_square(i, 11), sample_square(i, 12)[0]);
        clast_brdf_answer answer = brdf_evaluate(brdf, view, light);
        for (int c = 0; c < 3 && answer.density > 0.0f; c++) {
            sum[c] += (double)(answer.value.v[c] / answer.density);
        }
    }
    return vec3((float)(sum[0] / count), (float)(sum[1] / count), (float)(sum[2] / count));
}

static void a_white_metal_gives_back_all_light(void **state)
{
    (void)state;
    for (size_t r = 0; r < ROUGHNESSES; r++) {
        for (size_t c = 0; c < COSINES; c++) {
            clast_brdf brdf = brdf_make(brdf_input(splat3(1.0f), 1.0f, roughnesses[r]), 0.0f, cosines[c]);
            float energy = reflected(brdf, view_of(cosines[c]), 16384)[1];
            if (!(energy > 0.975f && energy < 1.015f)) {
                fail_msg("roughness %g cosine %g: %g", (double)roughnesses[r], (double)cosines[c], (double)energy);
            }
        }
    }
}

static void a_white_dielectric_never_gains_and_loses_little(void **state)
{
    (void)state;
    for (size_t r = 0; r < ROUGHNESSES; r++) {
        for (size_t c = 0; c < COSINES; c++) {
            clast_brdf brdf = brdf_make(brdf_input(splat3(1.0f), 0.0f, roughnesses[r]), 0.0f, cosines[c]);
            float energy = reflected(brdf, view_of(cosines[c]), 16384)[1];
            if (!(energy > 0.96f && energy < 1.03f)) {
                fail_msg("roughness %g cosine %g: %g", (double)roughnesses[r], (double)cosines[c], (double)energy);
            }
        }
    }
}

static void half_metals_and_colours_stay_within_their_colour(void **state)
{
    (void)state;
    for (size_t r = 0; r < ROUGHNESSES; r++) {
        clast_brdf brdf = brdf_make(brdf_input(vec3(0.9f, 0.5f, 0.1f), 0.5f, roughnesses[r]), 0.0f, 0.7f);
        vec3 energy = reflected(brdf, view_of(0.7f), 4096);
        assert_true(energy[0] < 1.0f && energy[0] > energy[1] && energy[1] > energy[2] && energy[2] > 0.03f);
    }
}

static void light_and_view_can_be_exchanged(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 4096; i++) {
        vec3 a = sample_cosine_hemisphere(sample_square(i, 1));
        vec3 b = sample_cosine_hemisphere(sample_square(i, 2));
        vec2 u = sample_square(i, 3);
        clast_brdf from_a = brdf_make(brdf_input(vec3(0.8f, 0.6f, 0.3f), u[0], u[1]), 0.0f, a[2]);
        clast_brdf from_b = brdf_make(brdf_input(vec3(0.8f, 0.6f, 0.3f), u[0], u[1]), 0.0f, b[2]);
        vec3 forth = load3(brdf_evaluate(from_a, a, b).value) * (1.0f / b[2]);
        vec3 back = load3(brdf_evaluate(from_b, b, a).value) * (1.0f / a[2]);
        for (int c = 0; c < 3; c++) {
            assert_true(fabsf(forth[c] - back[c]) <= 2e-4f * (forth[c] + back[c]) + 1e-6f);
        }
    }
}

// The density, over the sphere by a grid, adds up to one less what is sampled below the surface.
static void the_density_adds_up_to_what_is_sampled(void **state)
{
    (void)state;
    enum { ROWS = 1200, COLUMNS = 1200, SAMPLES = 16384 };
    for (size_t r = 3; r < ROUGHNESSES; r++) {
        vec3 view = view_of(0.5f);
        clast_brdf brdf = brdf_make(brdf_input(splat3(0.5f), 0.5f, roughnesses[r]), 0.0f, view[2]);
        double sum = 0.0;
        for (uint32_t row = 0; row < ROWS; row++) {
            for (uint32_t column = 0; column < COLUMNS; column++) {
                float z = ((float)row + 0.5f) / ROWS, turns = ((float)column + 0.5f) / COLUMNS;
                vec2 p = circle_point(turns);
                float s = sqrtf(1.0f - z * z);
                sum += (double)brdf_evaluate(brdf, view, vec3(s * p[0], s * p[1], z)).density;
            }
        }
        sum *= 2.0 * 3.14159265358979 / ROWS / COLUMNS;
        uint32_t above = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            above += brdf_direction(brdf, view, sample_square(i, 5), sample_square(i, 6)[0])[2] > 0.0f;
        }
        assert_near(sum, (double)above / SAMPLES, 0.004);
    }
}

// Counts of samples in cells of the hemisphere against the density there.
static void samples_lie_where_the_density_says(void **state)
{
    (void)state;
    enum { ROWS = 8, COLUMNS = 12, FINE = 24, SAMPLES = 1 << 17 };
    vec3 view = view_of(0.4f);
    clast_brdf brdf = brdf_make(brdf_input(vec3(0.4f, 0.5f, 0.6f), 0.3f, 0.5f), 0.0f, view[2]);
    static uint32_t counts[ROWS][COLUMNS];
    for (uint32_t i = 0; i < SAMPLES; i++) {
        vec3 d = brdf_direction(brdf, view, sample_square(i, 7), sample_square(i, 8)[0]);
        if (d[2] > 0.0f) {
            float turns = atan2f(d[1], d[0]) * 0.159154943f;
            turns -= floorf(turns);
            uint32_t row = min_uint((uint32_t)(d[2] * ROWS), ROWS - 1),
                     column = min_uint((uint32_t)(turns * COLUMNS), COLUMNS - 1);
            counts[row][column]++;
        }
    }
    for (uint32_t row = 0; row < ROWS; row++) {
        for (uint32_t column = 0; column < COLUMNS; column++) {
            double expected = 0.0;
            for (uint32_t i = 0; i < FINE * FINE; i++) {
                float z = ((float)row + ((float)(i / FINE) + 0.5f) / FINE) / ROWS;
                float turns = ((float)column + ((float)(i % FINE) + 0.5f) / FINE) / COLUMNS;
                vec2 p = circle_point(turns);
                float s = sqrtf(1.0f - z * z);
                expected += (double)brdf_evaluate(brdf, view, vec3(s * p[0], s * p[1], z)).density;
            }
            expected *= 2.0 * 3.14159265358979 / ROWS / COLUMNS / FINE / FINE * SAMPLES;
            assert_true(fabs(expected - counts[row][column]) < 5.0 * sqrt(expected + 1.0) + 0.01 * expected);
        }
    }
}

static void nothing_is_divided_by_zero(void **state)
{
    (void)state;
    const float edge[] = {0.0f, 1e-30f, 1e-9f, 1e-5f, 1.0f};
    for (int r = 0; r < 5; r++) {
        for (int m = 0; m < 5; m++) {
            for (int v = 0; v < 5; v++) {
                for (int l = 0; l < 5; l++) {
                    vec3 view = view_of(edge[v]), light = view_of(edge[l]);
                    light[0] = -light[0];
                    clast_brdf brdf = brdf_make(brdf_input(splat3(edge[m]), edge[m], edge[r]), 0.0f, view[2]);
                    clast_brdf_answer answer = brdf_evaluate(brdf, view, light);
                    vec3 direction = brdf_direction(brdf, view, vec2(0.0f, 0.0f), 0.0f);
                    assert_true(is_finite3(load3(answer.value)) && is_finite1(answer.density) && is_finite3(direction));
                    assert_true(answer.density >= 0.0f && answer.value.v[0] >= 0.0f);
                }
            }
        }
    }
}

static void a_repaired_normal_faces_the_view_and_reflects_outwards(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        vec3 geometric = vec3(0.0f, 0.0f, 1.0f);
        vec3 view = sample_cosine_hemisphere(sample_square(i, 1));
        vec2 u = sample_square(i, 2);
        vec2 p = circle_point(u[1]);
        float z = 2.0f * u[0] - 1.0f;
        vec3 normal = vec3(p[0] * sqrtf(1.0f - z * z), p[1] * sqrtf(1.0f - z * z), z);
        vec3 repaired = shading_normal_repair(normal, geometric, view);
        vec3 reflected = repaired * (2.0f * dot3(repaired, view)) - view;
        assert_near(length3(repaired), 1.0f, 1e-5f);
        assert_true(dot3(repaired, view) > 0.0f && reflected[2] > -1e-4f);
    }
}

static void a_sound_normal_is_left_alone(void **state)
{
    (void)state;
    vec3 geometric = vec3(0.0f, 0.0f, 1.0f);
    for (uint32_t i = 0; i < 1000; i++) {
        vec3 view = sample_cosine_hemisphere(sample_square(i, 1));
        vec3 repaired = shading_normal_repair(geometric, geometric, view);
        assert_true(repaired[0] == 0.0f && repaired[1] == 0.0f && repaired[2] == 1.0f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_white_metal_gives_back_all_light),
        cmocka_unit_test(a_white_dielectric_never_gains_and_loses_little),
        cmocka_unit_test(half_metals_and_colours_stay_within_their_colour),
        cmocka_unit_test(light_and_view_can_be_exchanged),
        cmocka_unit_test(the_density_adds_up_to_what_is_sampled),
        cmocka_unit_test(samples_lie_where_the_density_says),
        cmocka_unit_test(nothing_is_divided_by_zero),
        cmocka_unit_test(a_repaired_normal_faces_the_view_and_reflects_outwards),
        cmocka_unit_test(a_sound_normal_is_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
