// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>

#include "generate/noise.h"

static void noise_varies_and_stays_in_range(void **state)
{
    (void)state;
    float low = 9.0f, high = -9.0f;
    for (uint i = 0; i < 20000; i++) {
        vec3 p = vec3(chance(1, i, 0), chance(1, i, 1), chance(1, i, 2)) * 200.0f - splat3(100.0f);
        float value = clast_noise3(p, 5);
        low = fminf(low, value);
        high = fmaxf(high, value);
        assert_true(fabsf(value) <= 1.1f);
        assert_true(fabsf(clast_noise2(vec2(p[0], p[1]), 5)) <= 1.2f);
        assert_true(fabsf(clast_fractal3(p, 6, 5)) <= 1.1f);
        float ridges = clast_ridged3(p, 5, 5);
        assert_true(ridges >= 0.0f && ridges <= 1.0f);
    }
    assert_true(low < -0.6f && high > 0.6f);
}

static void noise_is_continuous_across_cells(void **state)
{
    (void)state;
    for (int i = -20; i < 20; i++) {
        vec3 below = vec3((float)i - 1e-4f, 0.37f * (float)i, 1.9f),
             above = vec3((float)i + 1e-4f, 0.37f * (float)i, 1.9f);
        assert_true(fabsf(clast_noise3(below, 3) - clast_noise3(above, 3)) < 2e-3f);
        clast_cells a = clast_cells3(below, 3), b = clast_cells3(above, 3);
        assert_true(fabsf(a.nearest - b.nearest) < 1e-3f && fabsf(a.second - b.second) < 1e-3f);
    }
}

static void seeds_give_different_noise(void **state)
{
    (void)state;
    uint32_t equal = 0;
    for (uint i = 0; i < 1000; i++) {
        vec3 p = vec3(chance(2, i, 0), chance(2, i, 1), chance(2, i, 2)) * 50.0f;
        equal += clast_noise3(p, 1) == clast_noise3(p, 2);
    }
    assert_true(equal < 10);
}

static void tiled_noise_repeats(void **state)
{
    (void)state;
    for (uint i = 0; i < 2000; i++) {
        // Multiples of 1/64 add up exactly, so that the repeat is exact too.
        vec2 p = vec2(floor1(chance(3, i, 0) * 512.0f) / 64.0f, floor1(chance(3, i, 1) * 512.0f) / 64.0f);
        vec2 q = p + vec2(8.0f, -16.0f);
        assert_true(clast_noise2_tiled(p, 8, 7) == clast_noise2_tiled(q, 8, 7));
        assert_true(clast_fractal2_tiled(p, 8, 4, 7) == clast_fractal2_tiled(q, 8, 4, 7));
        assert_true(clast_fractal2_banded(p, 4, 16, 3, 7) == clast_fractal2_banded(q, 4, 16, 3, 7));
        clast_cells a = clast_cells2_tiled(p, 8, 7), b = clast_cells2_tiled(q, 8, 7);
        assert_true(a.id == b.id && fabsf(a.nearest - b.nearest) < 1e-5f);
    }
}

static void sines_and_angles_are_true(void **state)
{
    (void)state;
    for (int i = -4000; i <= 4000; i++) {
        float turns = (float)i / 1000.0f;
        assert_true(fabs((double)wave_sine(turns) - sin(6.283185307179586 * (double)turns)) < 2e-6);
        double x = cos((double)i * 0.01), y = sin((double)i * 0.01);
        double angle = atan2(y, x) / 6.283185307179586;
        assert_true(fabs((double)turns_of((float)y, (float)x) - angle) < 3e-4);
    }
    assert_true(wave_sine(0.25f) == wave_sine(1.25f) && wave_sine(0.0f) == 0.0f && wave_sine(0.5f) == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_varies_and_stays_in_range), cmocka_unit_test(noise_is_continuous_across_cells),
        cmocka_unit_test(seeds_give_different_noise),      cmocka_unit_test(tiled_noise_repeats),
        cmocka_unit_test(sines_and_angles_are_true),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
