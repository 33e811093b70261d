// SPDX-License-Identifier: Apache-2.0
// Quotients that devices correct are those of the processor.
#include "test.h"

#include "accel/meshes.h"
#include "shared/quotient.h"

static float one_and_some(randoms *r)
{
    return uintBitsToFloat((random_bits(r) & 0x7fffffu) | 0x3f800000u);
}

// A pair of mantissas: any, near each other, or with few bits.
static void next_pair(randoms *r, int i, float *a, float *b)
{
    *a = one_and_some(r);
    *b = one_and_some(r);
    if (i % 4 == 1) {
        *b = uintBitsToFloat(floatBitsToUint(*a) + random_below(r, 17) - 8u);
        *b = *b < 1.0f || *b >= 2.0f ? *a : *b;
    } else if (i % 4 == 2) {
        *b = uintBitsToFloat(floatBitsToUint(*b) & 0xfffff000u);
    }
}

static void bad_guesses_become_the_quotient(void **state)
{
    (void)state;
    randoms r = {1};
    for (int i = 0; i < 2000000; i++) {
        float a, b;
        next_pair(&r, i, &a, &b);
        float guess = uintBitsToFloat(floatBitsToUint(a / b) + random_below(&r, 17) - 8u);
        assert_true(quotient_from(a, b, guess) == a / b);
    }
}

static void quotients_of_any_floats_are_the_processors(void **state)
{
    (void)state;
    randoms r = {2};
    const float special[] = {0.0f, -0.0f, 1.0f, -1.0f, INFINITY, -INFINITY, 1e-45f, 3.4e38f, 1.18e-38f, -1.18e-38f};
    uint32_t count = sizeof special / sizeof *special;
    for (uint32_t i = 0; i < 2000000 + count * count; i++) {
        float a = uintBitsToFloat(random_bits(&r)), b = uintBitsToFloat(random_bits(&r));
        if (i < count * count) {
            a = special[i / count];
            b = special[i % count];
        }
        float quotient = a / b, corrected = corrected_divide(a, b);
        assert_true(floatBitsToUint(quotient) == floatBitsToUint(corrected) ||
                    (quotient != quotient && corrected != corrected));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_guesses_become_the_quotient),
        cmocka_unit_test(quotients_of_any_floats_are_the_processors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
