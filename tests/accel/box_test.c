// SPDX-License-Identifier: Apache-2.0
// Quantised boxes hold what they were made from.
#include "test.h"

#include "accel/meshes.h"
#include "accel/structures.h"
#include "shared/box.h"

// Any float of moderate size, near others or far from them.
static float wild(randoms *r, int low, int high)
{
    float x = ldexpf(1.0f + random_float(r), low + (int)random_below(r, (uint32_t)(high - low)));
    return random_bits(r) % 2 == 0 ? x : -x;
}

// base + q * step, exactly: 24 bits and 8 bits shifted by less than what a long double holds, or else far apart enough
static void assert_holds(float lower, float x, float upper)
{
    uint32_t exponent = box_exponent(upper - lower);
    float down = box_quantise_down(x, lower, exponent), up = box_quantise_up(x, lower, exponent),
          step = power_of_two(exponent);
    assert_true(down >= 0.0f && up <= 255.0f && down <= up);
    // in real numbers: the difference in long double is exact, or off by far less than a step
    assert_true((long double)down * step <= (long double)x - lower);
    assert_true((long double)up * step >= (long double)x - lower);
    // in floats
    assert_true(box_decode(lower, down, step) <= x);
    assert_true(box_decode(lower, up, step) >= x);
    // and not by much
    assert_true((long double)up * step - ((long double)x - lower) <= 1.001L * step);
}

static void decoded_sides_hold_the_true_ones(void **state)
{
    (void)state;
    randoms r = {1};
    for (int i = 0; i < 1000000; i++) {
        float a = wild(&r, -30, 30), b = i % 2 == 0 ? wild(&r, -30, 30) : a * (1.0f + random_float(&r) * 1e-5f);
        float lower = a < b ? a : b, upper = a < b ? b : a, x = lower + (upper - lower) * random_float(&r);
        x = x < lower ? lower : x > upper ? upper : x;
        assert_holds(lower, x, upper);
        assert_holds(lower, lower, upper);
        assert_holds(lower, upper, upper);
    }
}

static void worst_cases_hold(void **state)
{
    (void)state;
    const float bases[] = {0.0f, 1.0f,  -1.0f,  1e-20f,     -1e-20f, 1e20f,   -1e20f,
                           0.1f, -1e5f, 1e-40f, 8388608.0f, 1.3e36f, -1.3e36f};
    for (size_t i = 0; i < sizeof bases / sizeof *bases; i++) {
        float upper = bases[i];
        for (int k = 0; k < 200; k++) { // one, two ... units in the last place, then every power of two
            upper = k < 100 ? nextafterf(upper, INFINITY) : bases[i] + ldexpf(255.0f, k - 150);
            if (fabsf(upper) <= BOX_COORDINATE_MOST && upper >= bases[i]) {
                assert_holds(bases[i], bases[i], upper);
                assert_holds(bases[i], upper, upper);
                assert_holds(bases[i], nextafterf(upper, -INFINITY) < bases[i] ? upper : nextafterf(upper, -INFINITY),
                             upper);
            }
        }
        assert_holds(bases[i], bases[i], bases[i]);
    }
    assert_holds(-BOX_COORDINATE_MOST, BOX_COORDINATE_MOST, BOX_COORDINATE_MOST);
}

static void steps_are_the_least_that_reach(void **state)
{
    (void)state;
    randoms r = {2};
    for (int i = 0; i < 100000; i++) {
        float extent = fabsf(wild(&r, -60, 60));
        uint32_t exponent = box_exponent(extent);
        assert_true(255.0L * power_of_two(exponent) >= extent);
        assert_true(127.5L * power_of_two(exponent) <= extent * 1.000001L);
    }
}

// The kernel restates the formulas over lanes.
static void fitted_clusters_have_the_bits_of_the_formulas(void **state)
{
    clast_context *context = *state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        mesh m = mesh_soup(256, ldexpf(1.0f, (int)seed - 10), seed);
        clustered c;
        assert_ok(context, clustered_make(context, &m, 77, &c));
        for (uint32_t i = 0; i < c.cluster_count; i++) {
            const clast_clas *clas = clast_pool_slot(c.pool, i);
            const clast_template *topology = clast_clas_topology(clas);
            assert_int_equal(clas->block_count, (topology->triangle_count + 7) / 8);
            for (uint32_t k = 0; k < 8u * clas->block_count; k++) {
                const clast_block *block = &topology->blocks[k / 8];
                uint32_t place = k / 8 % CLUSTER_WIDTH;
                for (uint32_t corner = 0; corner < 3; corner++) {
                    for (uint32_t axis = 0; axis < 3; axis++) {
                        float x = clast_clas_vertices(clas)[3 * block->corners[corner][k % 8] + axis];
                        uint32_t exponent = clas->exponents[axis];
                        assert_int_equal(exponent, box_exponent(c.pool->boxes[i].upper.v[axis] - clas->lower[axis]));
                        assert_true(clas->groups[k / 8 / CLUSTER_WIDTH][axis][0][place] <=
                                    box_quantise_down(x, clas->lower[axis], exponent));
                        assert_true(clas->groups[k / 8 / CLUSTER_WIDTH][axis][1][place] >=
                                    box_quantise_up(x, clas->lower[axis], exponent));
                    }
                }
            }
        }
        clustered_free(&c);
        mesh_free(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(decoded_sides_hold_the_true_ones),
        cmocka_unit_test(worst_cases_hold),
        cmocka_unit_test(steps_are_the_least_that_reach),
        CONTEXT_TEST(fitted_clusters_have_the_bits_of_the_formulas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
