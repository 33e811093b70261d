// SPDX-License-Identifier: Apache-2.0
// Which instruction set the kernels use. A kernel file NAME.kernel.c is compiled once for each set; its functions are
// named CLAST_KERNEL(function), which adds the set's suffix, and a table in the file that uses them picks by
// clast_context_isa(). All sets must give the same bits.
#ifndef CLAST_BASE_ISA_H
#define CLAST_BASE_ISA_H

#include "clast/status.h"

#define CLAST_JOIN_(a, b) a##_##b
#define CLAST_JOIN(a, b) CLAST_JOIN_(a, b)
// CLAST_KERNEL_SUFFIX is plain, sse42, avx2 or avx512, from CMake.
#define CLAST_KERNEL(name) CLAST_JOIN(name, CLAST_KERNEL_SUFFIX)

// The best instruction set of this machine; CLAST_ISA_PLAIN where it is not an x86.
clast_isa clast_isa_best(void);
const char *clast_isa_text(clast_isa isa);

#endif
