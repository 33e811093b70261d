// SPDX-License-Identifier: Apache-2.0
// Which kernels count segments.
#include "source/rate.h"

const clast_rate_kernels *clast_rate_kernels_of(clast_isa isa)
{
#define KERNELS(set) \
    { \
        clast_rate_points_##set, clast_rate_edges_##set \
    }
    static const clast_rate_kernels kernels[] = CLAST_KERNELS_BY_ISA(KERNELS);
    return &kernels[clast_isa_index(isa)];
}
