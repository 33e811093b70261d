// SPDX-License-Identifier: Apache-2.0
// Which kernel displaces.
#include "source/displace.h"

clast_displace_kernel clast_displace_kernel_of(clast_isa isa)
{
#define KERNEL(set) clast_displace_##set
    static const clast_displace_kernel kernels[] = CLAST_KERNELS_BY_ISA(KERNEL);
    return kernels[clast_isa_index(isa)];
}
