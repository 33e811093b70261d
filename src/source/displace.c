// SPDX-License-Identifier: Apache-2.0
// Which kernel displaces.
#include "source/displace.h"

clast_displace_kernel clast_displace_kernel_of(clast_isa isa)
{
#if defined(__x86_64__)
    if (isa == CLAST_ISA_AVX512) {
        return clast_displace_avx512;
    }
    if (isa == CLAST_ISA_AVX2) {
        return clast_displace_avx2;
    }
    if (isa == CLAST_ISA_SSE42) {
        return clast_displace_sse42;
    }
#else
    (void)isa;
#endif
    return clast_displace_plain;
}
