// SPDX-License-Identifier: Apache-2.0
// Which instruction set the kernels use. A kernel file NAME.kernel.c is compiled once for each set; its functions are
// named CLAST_KERNEL(function), which adds the set's suffix, and a table in the file that uses them picks by
// clast_context_isa(). All sets must give the same bits.
#ifndef CLAST_BASE_ISA_H
#define CLAST_BASE_ISA_H

#include <stdint.h>

#include "clast/status.h"

#define CLAST_JOIN_(a, b) a##_##b
#define CLAST_JOIN(a, b) CLAST_JOIN_(a, b)
// CLAST_KERNEL_SUFFIX is plain, sse42, avx2 or avx512, from CMake.
#define CLAST_KERNEL(name) CLAST_JOIN(name, CLAST_KERNEL_SUFFIX)

// MACRO(set) for each set of this machine's kind.
#if defined(__x86_64__)
#define CLAST_EACH_ISA(MACRO) MACRO(plain) MACRO(sse42) MACRO(avx2) MACRO(avx512)
#define CLAST_KERNELS_BY_ISA(MACRO) \
    { \
        MACRO(plain), MACRO(sse42), MACRO(avx2), MACRO(avx512) \
    }
#else
#define CLAST_EACH_ISA(MACRO) MACRO(plain)
#define CLAST_KERNELS_BY_ISA(MACRO) \
    { \
        MACRO(plain) \
    }
#endif
// Where a set stands in CLAST_KERNELS_BY_ISA, which makes a table of MACRO(set).
static inline uint32_t clast_isa_index(clast_isa isa)
{
    uint32_t index = isa == CLAST_ISA_AVX512 ? 3 : isa == CLAST_ISA_AVX2 ? 2 : isa == CLAST_ISA_SSE42 ? 1 : 0;
#if defined(__x86_64__)
    return index;
#else
    return 0 * index;
#endif
}

// The best instruction set of this machine; CLAST_ISA_PLAIN where it is not an x86.
clast_isa clast_isa_best(void);
const char *clast_isa_text(clast_isa isa);

#endif
