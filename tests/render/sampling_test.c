// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <string.h>

#include "shared/sampling.h"

#define assert_near(value, expected, tolerance) \
    assert_true(fabs((double)(value) - (double)(expected)) <= (double)(tolerance))

// Sobol's second dimension by its direction numbers, from the recurrence of the primitive polynomial x + 1.
static uint32_t sobol_second_by_direction_numbers(uint32_t index)
{
    uint32_t direction = 0x80000000u, x = 0;
    for (uint32_t bit = 0; bit < 32; bit++) {
        x ^= (index >> bit & 1) != 0 ? direction : 0;
        direction ^= direction >> 1;
    }
    return x;
}

static void the_second_dimension_is_sobols(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 100000; i++) {
        uint32_t index = i < 4096 ? i : hash1(i);
        assert_int_equal(reverse_bits(sobol_second_reversed(index)), sobol_second_by_direction_numbers(index));
    }
}

// Every elementary box of area 1 / count holds one point.
static void every_power_of_two_of_points_fills_all_boxes(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 20; seed++) {
        for (uint32_t bits = 0; bits <= 10; bits++) {
            uint32_t count = 1u << bits;
            for (uint32_t across = 0; across <= bits; across++) {
                bool seen[1024] = {false};
                for (uint32_t i = 0; i < count; i++) {
                    vec2 p = sample_square(i, hash1(seed));
                    uint32_t x = (uint32_t)(p[0] * (float)(1u << across));
                    uint32_t y = (uint32_t)(p[1] * (float)(1u << (bits - across)));
                    uint32_t box = y * (1u << across) + x;
                    assert_false(seen[box]);
                    seen[box] = true;
                }
            }
        }
    }
}

static void seeds_give_uncorrelated_points(void **state)
{
    (void)state;
    double sum = 0.0, mean = 0.0;
    for (uint32_t i = 0; i < 65536; i++) {
        float a = sample_square(i & 15, hash2(1, hash1(i >> 4)))[0];
        float b = sample_square(i & 15, hash2(2, hash1(i >> 4)))[0];
        sum += ((double)a - 0.5) * ((double)b - 0.5);
        mean += (double)a;
    }
    assert_true(fabs(sum / 65536.0) < 0.002);
    assert_near(mean / 65536.0, 0.5, 0.003);
}

// Whether points fill all elementary boxes of area 1 / 2^bits, one each.
static void check_net(const vec2 *points, uint32_t bits)
{
    for (uint32_t across = 0; across <= bits; across++) {
        bool seen[256] = {false};
        for (uint32_t i = 0; i < 1u << bits; i++) {
            uint32_t x = (uint32_t)(points[i][0] * (float)(1u << across));
            uint32_t y = (uint32_t)(points[i][1] * (float)(1u << (bits - across)));
            uint32_t box = y * (1u << across) + x;
            assert_false(seen[box]);
            seen[box] = true;
        }
    }
}

// A pixel's first 2^k points do, as do those of squares of 2 x 2 and of 4 x 4 pixels together, wherever they are; and so do
// points beyond those that were planned.
static void pixels_have_nets_alone_and_together(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 200; i++) {
        uint32_t x = hash1(i) % 65536u & ~3u, y = hash1(i + 1000) % 65536u & ~3u, use = i % 50, power = i % 5;
        uint32_t beyond = (i % 3) << power;
        for (uint32_t side = 0; side <= 2; side++) {
            vec2 points[256];
            uint32_t count = 0;
            for (uint32_t k = 0; k < 1u << (2 * side); k++) {
                clast_pixel_samples pixel = pixel_samples(x + (k & ((1u << side) - 1u)), y + (k >> side), i, power);
                for (uint32_t n = 0; n < 1u << power; n++) {
                    points[count++] = square_of_pixel(beyond + n, pixel, use);
                }
            }
            check_net(points, power + 2 * side);
        }
        clast_pixel_samples pixel = pixel_samples(x, y, i, 16);
        vec2 points[256];
        for (uint32_t n = 0; n < 256; n++) {
            points[n] = square_of_pixel(n, pixel, use);
        }
        for (uint32_t bits = 0; bits <= 8; bits++) {
            check_net(points, bits);
        }
    }
}

static void uses_of_pixels_give_uncorrelated_points(void **state)
{
    (void)state;
    double sum = 0.0, mean = 0.0;
    for (uint32_t i = 0; i < 65536; i++) {
        clast_pixel_samples pixel = pixel_samples(i % 128, i / 128, 3, 2);
        float a = square_of_pixel(0, pixel, 1)[0], b = square_of_pixel(0, pixel, 2)[0];
        sum += ((double)a - 0.5) * ((double)b - 0.5);
        mean += (double)a;
    }
    assert_true(fabs(sum / 65536.0) < 0.002);
    assert_near(mean / 65536.0, 0.5, 0.004);
}

// The error of a picture of 64 x 64 pixels, each the mean of a function over its samples: as it is, and after a blur of 1.5 pixels.
typedef struct grain {
    double raw, blurred;
} grain;

static double integrand(int kind, vec2 u)
{
    double x = (double)u[0], y = (double)u[1];
    return kind == 0 ? x * x + y : (x - 0.3) * (x - 0.3) + (y - 0.4) * (y - 0.4) < 0.09 ? 1.0 : 0.0;
}

static void add_grain(double error[64][64], grain *sum)
{
    enum { REACH = 4 };
    for (int y = REACH; y < 64 - REACH; y++) {
        for (int x = REACH; x < 64 - REACH; x++) {
            double blurred = 0.0, weights = 0.0;
            for (int k = 0; k < (2 * REACH + 1) * (2 * REACH + 1); k++) {
                int i = k % (2 * REACH + 1) - REACH, j = k / (2 * REACH + 1) - REACH;
                double weight = exp(-(i * i + j * j) / (2.0 * 1.5 * 1.5));
                blurred += weight * error[y + j][x + i];
                weights += weight;
            }
            sum->raw += error[y][x] * error[y][x];
            sum->blurred += blurred * blurred / (weights * weights);
        }
    }
}

static grain measure_grain(int kind, uint32_t power, bool alone)
{
    const double truths[] = {1.0 / 3.0 + 0.5, 0.09 * 3.14159265358979};
    grain sum = {0.0, 0.0};
    for (uint32_t trial = 0; trial < 6; trial++) {
        static double error[64][64];
        for (uint32_t i = 0; i < 64 * 64; i++) {
            clast_pixel_samples pixel = pixel_samples(i % 64, i / 64, trial, power);
            double mean = 0.0;
            for (uint32_t n = 0; n < 1u << power; n++) {
                vec2 u = alone ? sample_square(n, hash3(i, trial, 9)) : square_of_pixel(n, pixel, 3);
                mean += integrand(kind, u);
            }
            error[i / 64][i % 64] = mean / (double)(1u << power) - truths[kind];
        }
        add_grain(error, &sum);
    }
    return (grain){sqrt(sum.raw), sqrt(sum.blurred)};
}

// Beside points that each pixel has for itself: no more error, and less of it that is seen from a distance.
static void errors_of_neighbours_cancel(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        for (uint32_t power = 0; power <= 6; power += 2) {
            grain alone = measure_grain(kind, power, true), together = measure_grain(kind, power, false);
            assert_true(together.raw < 1.1 * alone.raw);
            assert_true(together.blurred < (kind == 0 ? 0.5 : 0.75) * alone.blurred);
        }
    }
}

static void points_of_a_circle_are_its_sine_and_cosine(void **state)
{
    (void)state;
    for (uint32_t i = 0; i <= 10000; i++) {
        float turns = (float)i / 10000.0f;
        vec2 p = circle_point(turns);
        assert_near(p[0], cos(2.0 * 3.14159265358979 * (double)turns), 1e-6f);
        assert_near(p[1], sin(2.0 * 3.14159265358979 * (double)turns), 1e-6f);
    }
}

static void discs_and_hemispheres_have_the_right_means(void **state)
{
    (void)state;
    double radius = 0.0, cosine = 0.0, x = 0.0;
    enum { COUNT = 4096 };
    for (uint32_t i = 0; i < COUNT; i++) {
        vec2 p = sample_disc(sample_square(i, 9));
        vec3 d = sample_cosine_hemisphere(sample_square(i, 10));
        assert_true(dot2(p, p) <= 1.000001f);
        assert_near(length3(d), 1.0f, 1e-5f);
        radius += (double)sqrtf(dot2(p, p));
        cosine += (double)d[2];
        x += (double)p[0];
    }
    assert_near(radius / COUNT, 2.0 / 3.0, 1e-3);
    assert_near(cosine / COUNT, 2.0 / 3.0, 1e-3);
    assert_near(x / COUNT, 0.0, 1e-3);
}

static void a_narrow_cone_keeps_its_precision(void **state)
{
    (void)state;
    float angle = 0.00465f, height = 1.081e-5f;
    double square = 0.0;
    for (uint32_t i = 0; i < 1024; i++) {
        vec3 d = sample_cone(sample_square(i, 4), height);
        float off = sqrtf(d[0] * d[0] + d[1] * d[1]);
        assert_true(off <= angle * 1.001f);
        square += (double)(off * off);
    }
    assert_near(square / 1024.0, 0.5 * (double)(angle * angle), 1e-7);
}

static void triangles_are_sampled_uniformly(void **state)
{
    (void)state;
    double u = 0.0, v = 0.0, uv = 0.0;
    for (uint32_t i = 0; i < 4096; i++) {
        vec2 p = sample_triangle(sample_square(i, 5));
        assert_true(p[0] >= 0.0f && p[1] >= 0.0f && p[0] + p[1] <= 1.0f);
        u += (double)p[0], v += (double)p[1], uv += (double)(p[0] * p[1]);
    }
    assert_near(u / 4096.0, 1.0 / 3.0, 1e-3);
    assert_near(v / 4096.0, 1.0 / 3.0, 1e-3);
    assert_near(uv / 4096.0, 1.0 / 12.0, 1e-3);
}

static void bases_are_orthonormal_also_at_the_poles(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        vec2 u = sample_square(i, 6);
        float z = i == 0 ? 1.0f : i == 1 ? -1.0f : 2.0f * u[0] - 1.0f;
        vec2 p = circle_point(u[1]);
        float s = sqrtf(max1(1.0f - z * z, 0.0f));
        vec3 n = vec3(p[0] * s, p[1] * s, z);
        clast_basis basis = basis_around(n);
        vec3 x = load3(basis.x), y = load3(basis.y);
        assert_true(fabsf(dot3(x, y)) < 2e-6f && fabsf(dot3(x, n)) < 2e-6f && fabsf(dot3(y, n)) < 2e-6f);
        assert_near(dot3(cross3(x, y), n), 1.0f, 1e-5f);
    }
}

static void weights_of_two_techniques_add_up_to_one(void **state)
{
    (void)state;
    assert_near(mis_weight(3.0f, 2.0f) + mis_weight(2.0f, 3.0f), 1.0f, 1e-6f);
    assert_near(mis_weight(1.0f, 0.0f), 1.0f, 0.0f);
    assert_near(mis_weight(0.0f, 1.0f), 0.0f, 0.0f);
    assert_near(mis_weight(1e-30f, 1e30f), 0.0f, 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_second_dimension_is_sobols),
        cmocka_unit_test(every_power_of_two_of_points_fills_all_boxes),
        cmocka_unit_test(seeds_give_uncorrelated_points),
        cmocka_unit_test(pixels_have_nets_alone_and_together),
        cmocka_unit_test(uses_of_pixels_give_uncorrelated_points),
        cmocka_unit_test(errors_of_neighbours_cancel),
        cmocka_unit_test(points_of_a_circle_are_its_sine_and_cosine),
        cmocka_unit_test(discs_and_hemispheres_have_the_right_means),
        cmocka_unit_test(a_narrow_cone_keeps_its_precision),
        cmocka_unit_test(triangles_are_sampled_uniformly),
        cmocka_unit_test(bases_are_orthonormal_also_at_the_poles),
        cmocka_unit_test(weights_of_two_techniques_add_up_to_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
