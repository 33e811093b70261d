// SPDX-License-Identifier: Apache-2.0
#include "base/isa.h"

clast_isa clast_isa_best(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_cpu_init();
    // Each asks the system, too, whether it keeps the registers.
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vbmi") && __builtin_cpu_supports("bmi2")) {
        return CLAST_ISA_AVX512;
    }
    if (__builtin_cpu_supports("avx2")) {
        return CLAST_ISA_AVX2;
    }
    if (__builtin_cpu_supports("sse4.2")) {
        return CLAST_ISA_SSE42;
    }
#endif
    return CLAST_ISA_PLAIN;
}

const char *clast_isa_text(clast_isa isa)
{
    switch (isa) {
#define CASE(name, value, text) \
    case name: return text;
        CLAST_ISA_LIST(CASE)
#undef CASE
    case CLAST_ISA_AUTOMATIC: break;
    }
    return "automatic";
}
