// SPDX-License-Identifier: Apache-2.0
// Quotients with the same bits everywhere: those of IEEE 754, rounded to nearest. Devices give quotients that may be off by
// some units in the last place. A guess becomes exact by the remainder that it leaves, which is a float, as the errors of
// products are (shared/watertight.h; Dekker 1971): it tells on which side of the guess the quotient lies, and how far.
#ifndef CLAST_SHARED_QUOTIENT_H
#define CLAST_SHARED_QUOTIENT_H

#include "shared/watertight.h"

// a - q * b, for a, b in [1, 2), q within some units of a / b.
FN float quotient_remainder(float a, float b, float q)
{
    float product = q * b;
    return (a - product) - product_error(q, b, product);
}

// a / b for a, b in [1, 2), from a guess within eight units in the last place. A quotient of two floats never lies just half way
// between two others.
FN float quotient_from(float a, float b, float guess)
{
    float q = guess + rough_divide(quotient_remainder(a, b, guess), b);
    float rest = quotient_remainder(a, b, q);
    float half_up = power_of_two(q < 1.0f ? 102u : 103u) * b; // half a unit, times b
    float half_down = power_of_two(q > 1.0f ? 103u : 102u) * b;
    float up = power_of_two(q < 1.0f ? 103u : 104u);
    float down = power_of_two(q > 1.0f ? 104u : 103u);
    return rest > half_up ? q + up : rest < -half_down ? q - down : q;
}

// a / b, as long as a, b and the quotient are normal numbers; else it is as exact as the device's own.
FN float corrected_divide(float a, float b)
{
    uint a_bits = floatBitsToUint(a);
    uint b_bits = floatBitsToUint(b);
    uint a_exponent = a_bits >> 23u & 255u;
    uint b_exponent = b_bits >> 23u & 255u;
    float a_one = uintBitsToFloat((a_bits & 0x7fffffu) | 0x3f800000u);
    float b_one = uintBitsToFloat((b_bits & 0x7fffffu) | 0x3f800000u);
    uint q_bits = floatBitsToUint(quotient_from(a_one, b_one, rough_divide(a_one, b_one)));
    uint exponent = (q_bits >> 23u) + a_exponent + 512u - b_exponent; // plus 512
    bool plain = a_exponent - 1u < 254u && b_exponent - 1u < 254u && exponent - 513u < 254u;
    uint bits = ((a_bits ^ b_bits) & 0x80000000u) | (exponent & 255u) << 23u | (q_bits & 0x7fffffu);
    return plain ? uintBitsToFloat(bits) : rough_divide(a, b);
}

#ifdef VULKAN
FN float exact_divide(float a, float b) { return corrected_divide(a, b); }
#else
FN float exact_divide(float a, float b) { return rough_divide(a, b); }
#endif

#endif
