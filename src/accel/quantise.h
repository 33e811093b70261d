// SPDX-License-Identifier: Apache-2.0
// shared/box.h over lanes, for kernels: the same bits.
//
// (x - base) * BOX_SHRINK * 2^k is computed as (x - base) * (BOX_SHRINK * 2^k): products of powers of two are exact, so both
// ways round alike, but for what is so small that it makes no step or one either way.
#ifndef CLAST_ACCEL_QUANTISE_H
#define CLAST_ACCEL_QUANTISE_H

#include "base/simd.h"
#include "shared/box.h"

enum { STEPS_MOST = 255 };

// How coordinates become steps: (x - base) * down towards zero, (x - base) * up away from it. The fourth lanes are zero.
typedef struct clast_steps {
    clast_floats4 base, down, up;
} clast_steps;

CLAST_LANES clast_floats4 power_of_two4(clast_ints4 exponents)
{
    return (clast_floats4)(exponents << 23);
}

// box_exponent for three axes.
CLAST_LANES clast_ints4 box_exponents4(clast_floats4 size)
{
    const clast_ints4 least = {BOX_STEP_LEAST, BOX_STEP_LEAST, BOX_STEP_LEAST, BOX_STEP_LEAST};
    clast_floats4 grown = size * splat4(BOX_GROW);
    clast_ints4 exponents = ((clast_ints4)grown >> 23) - 7;
    clast_ints4 large = exponents > least;
    exponents = (large & exponents) | (~large & least);
    return exponents - (splat4((float)STEPS_MOST) * power_of_two4(exponents) < grown); // true is -1
}

CLAST_LANES clast_steps steps_from(clast_floats4 base, clast_ints4 exponents)
{
    const clast_ints4 sum = {254, 254, 254, 0};
    exponents[3] = 0; // the bits of zero, not of a power
    base[3] = 0.0f;
    clast_floats4 inverse = power_of_two4(sum - exponents);
    return (clast_steps){base, inverse * splat4(BOX_SHRINK), inverse * splat4(BOX_GROW)};
}

// From differences to the base, which are not negative: steps of the lower side, and of the upper one.
CLAST_LANES clast_ints4 steps_down4(clast_floats4 away, clast_floats4 down)
{
    return __builtin_convertvector(away * down, clast_ints4);
}

CLAST_LANES clast_ints4 steps_up4(clast_floats4 away, clast_floats4 up)
{
    clast_floats4 steps = away * up;
    clast_ints4 whole = __builtin_convertvector(steps, clast_ints4);
    return whole - (__builtin_convertvector(whole, clast_floats4) < steps);
}

CLAST_LANES clast_ints8 steps_down8(clast_floats8 away, clast_floats8 down)
{
    return __builtin_convertvector(away * down, clast_ints8);
}

CLAST_LANES clast_ints8 steps_up8(clast_floats8 away, clast_floats8 up)
{
    clast_floats8 steps = away * up;
    clast_ints8 whole = __builtin_convertvector(steps, clast_ints8);
    return whole - (__builtin_convertvector(whole, clast_floats8) < steps);
}

CLAST_LANES clast_floats4 load_any4(const float *p)
{
    clast_floats4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

CLAST_LANES clast_floats8 load_any8(const float *p)
{
    clast_floats8 v;
    memcpy(&v, p, sizeof v);
    return v;
}

#define JOIN4(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7)
#define LOWER_HALF4(v) __builtin_shufflevector(v, v, 0, 1, 2, 3)
#define UPPER_HALF4(v) __builtin_shufflevector(v, v, 4, 5, 6, 7)

#endif
