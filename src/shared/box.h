// SPDX-License-Identifier: Apache-2.0
// Boxes in 8 bits a side. A coordinate is base + q * step: the base is the lower corner of the box around all of them, the
// step a power of two. Lower sides round down, upper ones up, so that the decoded box holds the true one: in real numbers,
// and so in float arithmetic too, as rounding keeps order.
//
// x - base rounds. BOX_SHRINK and BOX_GROW move the difference by more than that rounding, so what is quantised is on the
// safe side of the real difference. Dividing by a power of two is exact, so floor and ceiling are decided exactly.
#ifndef CLAST_SHARED_BOX_H
#define CLAST_SHARED_BOX_H

#include "shared/dialect.h"

LIMIT(BOX_STEP_LEAST, 7u, "biased exponent of the least step, 2^-120: far above the denormals, and its inverse is finite")
TABLE float BOX_GROW = 1.0000002384185791f;   // 1 + 2^-22
TABLE float BOX_SHRINK = 0.9999997615814209f; // 1 - 2^-22
TABLE float BOX_COORDINATE_MOST = 1.329227996e36f; // 2^120; what is larger counts as not finite: differences must be

FN float box_decode(float base, float q, float step) { return base + q * step; }

// The biased exponent of the least step with which 255 steps reach over `extent`, the float difference of the sides.
FN uint box_exponent(float extent)
{
    float grown = extent * BOX_GROW;
    uint exponent = floatBitsToUint(grown) >> 23u;
    exponent = exponent < BOX_STEP_LEAST + 7u ? BOX_STEP_LEAST : exponent - 7u; // grown is below 256 steps now
    precise float reach = 255.0f * power_of_two(exponent);
    return reach < grown ? exponent + 1u : exponent;
}

// The number of steps for the lower and the upper side at x >= base; `exponent` from box_exponent.
FN float box_quantise_down(float x, float base, uint exponent)
{
    return floor1((x - base) * BOX_SHRINK * power_of_two(254u - exponent));
}

FN float box_quantise_up(float x, float base, uint exponent)
{
    float steps = (x - base) * BOX_GROW * power_of_two(254u - exponent);
    float whole = floor1(steps);
    return whole < steps ? whole + 1.0f : whole;
}

#endif
