// SPDX-License-Identifier: Apache-2.0
// The reciprocal, the root and the logarithm that are the same on every machine.
#include "test.h"

#include <math.h>

#include "shared/stable.h"

// Every mantissa that a float has, 64 apart, with exponents over the range.
static void for_many_floats(int first_exponent, int last_exponent, void (*check)(float x))
{
    for (int exponent = first_exponent; exponent <= last_exponent; exponent += exponent < -3 || exponent > 3 ? 7 : 1) {
        for (uint32_t mantissa = 0; mantissa < 0x800000; mantissa += 61) {
            check(uintBitsToFloat((uint32_t)(exponent + 127) << 23 | mantissa));
        }
    }
}

static void check_reciprocal(float x)
{
    double error = fabs((double)stable_reciprocal(x) * (double)x - 1.0);
    if (!(error <= 0x1p-22)) {
        fail_msg("1 / %a: off by %a", (double)x, error);
    }
}

static void check_rsqrt(float x)
{
    double error = fabs((double)stable_rsqrt(x) * sqrt((double)x) - 1.0);
    if (!(error <= 0x1p-22)) {
        fail_msg("1 / sqrt(%a): off by %a", (double)x, error);
    }
}

static void check_log2(float x)
{
    double low = log2((double)x) - (double)stable_log2(x);
    if (!(low >= -1e-5 && low <= 0.0861)) {
        fail_msg("log2(%a): low by %a", (double)x, low);
    }
}

static void reciprocals_are_near(void **state)
{
    (void)state;
    for_many_floats(-125, 124, check_reciprocal);
    assert_true(stable_reciprocal(-3.0f) == -stable_reciprocal(3.0f));
}

static void roots_are_near(void **state)
{
    (void)state;
    for_many_floats(-126, 127, check_rsqrt);
}

static void logarithms_are_near_and_exact_at_powers_of_two(void **state)
{
    (void)state;
    for_many_floats(-126, 127, check_log2);
    for (int exponent = -126; exponent <= 127; exponent++) {
        assert_true(stable_log2(ldexpf(1.0f, exponent)) == (float)exponent);
    }
}

static void logarithms_never_fall(void **state)
{
    (void)state;
    float before = -INFINITY;
    for (uint32_t bits = 0x00800000; bits < 0x7f800000; bits += 101) {
        float now = stable_log2(uintBitsToFloat(bits));
        assert_true(now >= before);
        before = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reciprocals_are_near),
        cmocka_unit_test(roots_are_near),
        cmocka_unit_test(logarithms_are_near_and_exact_at_powers_of_two),
        cmocka_unit_test(logarithms_never_fall),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
