// SPDX-License-Identifier: Apache-2.0
// Rays, by the kernels of the context's instruction set.
#include "accel/batch.h"

const clast_accel_kernels *clast_accel_kernels_of(clast_isa isa)
{
#define KERNELS(set) \
    { \
        clast_fit_##set, clast_gather_##set, clast_order_##set, clast_refit_nodes_##set, clast_place_##set, \
            clast_closest_##set, clast_any_##set \
    }
    static const clast_accel_kernels kernels[] = CLAST_KERNELS_BY_ISA(KERNELS);
    return &kernels[clast_isa_index(isa)];
}

static clast_batch_kernel batch_kernel_of(clast_isa isa)
{
#define BATCH_KERNEL(set) clast_batch_##set
    static const clast_batch_kernel kernels[] = CLAST_KERNELS_BY_ISA(BATCH_KERNEL);
    return kernels[clast_isa_index(isa)];
}

void clast_trace_closest(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter,
                         clast_hit *hits)
{
    if (tlas == NULL || rays == NULL || hits == NULL) {
        return;
    }
    clast_isa isa = clast_context_isa(tlas->context);
    if (count < BATCH_LEAST) {
        clast_accel_kernels_of(isa)->closest(tlas, rays, count, filter, hits);
    } else {
        batch_kernel_of(isa)(&(clast_batch){.tlas = tlas, .rays = rays, .filter = filter, .hits = hits}, count);
    }
}

void clast_trace_any(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter,
                     uint8_t *occluded)
{
    if (tlas == NULL || rays == NULL || occluded == NULL) {
        return;
    }
    clast_isa isa = clast_context_isa(tlas->context);
    if (count < BATCH_LEAST) {
        clast_accel_kernels_of(isa)->any(tlas, rays, count, filter, occluded);
    } else {
        batch_kernel_of(isa)(&(clast_batch){.tlas = tlas, .rays = rays, .filter = filter, .occluded = occluded}, count);
    }
}
