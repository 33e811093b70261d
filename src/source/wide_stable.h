// SPDX-License-Identifier: Apache-2.0
// What kernels of sources share: the functions of shared/dialect.h and shared/stable.h over lanes, to the bit.
#ifndef CLAST_SOURCE_WIDE_STABLE_H
#define CLAST_SOURCE_WIDE_STABLE_H

#include "base/simd_wide.h"

// min1() and max1(), also of what is no number.
CLAST_LANES clast_wide wide_min1(clast_wide a, clast_wide b)
{
    return wide_min(b, a);
}

CLAST_LANES clast_wide wide_max1(clast_wide a, clast_wide b)
{
    return wide_max(b, a);
}

CLAST_LANES clast_wide wide_clamp1(clast_wide x, float low, float high)
{
    return wide_min1(wide_max1(wide_splat(low), x), wide_splat(high));
}

// Without the sign of a zero, which nothing may rely on.
CLAST_LANES clast_wide wide_abs1(clast_wide x)
{
    return (clast_wide)((clast_wide_ints)x & wide_splat_ints(INT32_MAX));
}

CLAST_LANES clast_wide wide_reciprocal(clast_wide x)
{
    clast_wide guess = (clast_wide)(0x7ee80000 - (clast_wide_ints)x);
    clast_wide c = x * guess;
    clast_wide near = guess * (3.1692004f + c * (-3.3463538f + c * 1.1772445f));
    return near * (2.0f - x * near);
}

CLAST_LANES clast_wide wide_rsqrt(clast_wide x)
{
    clast_wide guess = (clast_wide)(0x5f300000 - wide_shift_right((clast_wide_ints)x, 1));
    clast_wide c = x * guess * guess;
    clast_wide near = guess * (1.942495f + c * (-1.3888756f + c * 0.44642657f));
    return near * (1.5f - 0.5f * x * near * near);
}

CLAST_LANES clast_wide wide_log2(clast_wide x)
{
    clast_wide_ints bits = (clast_wide_ints)x;
    return wide_to_floats(wide_shift_right(bits, 23)) - 127.0f +
           wide_to_floats(bits & wide_splat_ints(0x7fffff)) * 0x1p-23f;
}

typedef struct clast_wide3 {
    clast_wide x, y, z;
} clast_wide3;

CLAST_LANES clast_wide wide_dot3(clast_wide3 a, clast_wide3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

CLAST_LANES clast_wide3 wide_minus3(clast_wide3 a, clast_wide3 b)
{
    return (clast_wide3){a.x - b.x, a.y - b.y, a.z - b.z};
}

// displaced_point()
CLAST_LANES clast_wide3 wide_displaced(clast_wide3 position, clast_wide3 normal, clast_wide height)
{
    clast_wide turn = wide_rsqrt(wide_max1(wide_dot3(normal, normal), wide_splat(1e-24f)));
    return (clast_wide3){position.x + normal.x * turn * height, position.y + normal.y * turn * height,
                         position.z + normal.z * turn * height};
}

#endif
