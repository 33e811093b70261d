// SPDX-License-Identifier: Apache-2.0
// Which kernels count segments.
#include "source/rate.h"

#define KERNELS(set) \
    { \
        clast_rate_points_##set, clast_rate_edges_##set \
    }

const clast_rate_kernels *clast_rate_kernels_of(clast_isa isa)
{
    static const clast_rate_kernels plain = KERNELS(plain);
#if defined(__x86_64__)
    static const clast_rate_kernels sse42 = KERNELS(sse42);
    static const clast_rate_kernels avx2 = KERNELS(avx2);
    static const clast_rate_kernels avx512 = KERNELS(avx512);
    if (isa == CLAST_ISA_AVX512) {
        return &avx512;
    }
    if (isa == CLAST_ISA_AVX2) {
        return &avx2;
    }
    if (isa == CLAST_ISA_SSE42) {
        return &sse42;
    }
#else
    (void)isa;
#endif
    return &plain;
}
