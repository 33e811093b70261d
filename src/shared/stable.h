// SPDX-License-Identifier: Apache-2.0
// A reciprocal, a root and a logarithm of + - * and integers only: every machine gives the same bits, so that they may
// decide integers and shared points. A guess comes from the bits of the number (Blinn, Floating-point tricks, 1997); a
// polynomial, best in the largest relative error over what the guess leaves, and a Newton step bring it to a float's precision.
#ifndef CLAST_SHARED_STABLE_H
#define CLAST_SHARED_STABLE_H

#include "shared/dialect.h"

// 1 / x to 2^-22 of it, for 2^-125 <= |x| <= 2^125.
FN float stable_reciprocal(float x)
{
    float guess = uintBitsToFloat(0x7ee80000u - floatBitsToUint(x));
    float c = x * guess; // 0.906 to 0.989
    float near = guess * (3.1692004f + c * (-3.3463538f + c * 1.1772445f));
    return near * (2.0f - x * near);
}

// 1 / sqrt(x) to 2^-22 of it, for normal x > 0.
FN float stable_rsqrt(float x)
{
    float guess = uintBitsToFloat(0x5f300000u - (floatBitsToUint(x) >> 1u));
    float c = x * guess * guess; // 0.875 to 0.992
    float near = guess * (1.942495f + c * (-1.3888756f + c * 0.44642657f));
    return near * (1.5f - 0.5f * x * near * near);
}

// A vector of unit length to 2^-20; zero for one of no length, or that is not finite.
FN vec3 stable_normalize3(vec3 v)
{
    float largest = largest3(vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])));
    uint exponent = floatBitsToUint(largest) >> 23u & 255u;
    bool sound = largest > 0.0f && exponent > 0u && exponent < 255u;
    vec3 scaled = v * power_of_two(max_uint(254u - min_uint(exponent, 253u), 1u)); // its largest is 1 to 4
    return sound ? scaled * stable_rsqrt(dot3(scaled, scaled)) : splat3(0.0f);
}

// The binary logarithm, exact at powers of two, linear between them: continuous, never falling, at most 0.0861 too low. For
// normal x > 0.
FN float stable_log2(float x)
{
    uint bits = floatBitsToUint(x);
    return to_float(bits >> 23u) - 127.0f + to_float(bits & 0x7fffffu) * power_of_two(104u);
}

#endif
