// SPDX-License-Identifier: Apache-2.0
#include "vulkan/fit.h"

// The push constants of shaders/accel/fit.comp.
typedef struct fit_push {
    uint64_t templates, inputs, vertices, clusters, boxes, positions, numbers, faults;
    uint32_t first, count, position_count;
} fit_push;
_Static_assert(sizeof(fit_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

void clast_gpu_fit_clusters(clast_gpu_commands *commands, const clast_gpu_fit *fit)
{
    if (fit->count == 0) {
        return;
    }
    fit_push push = {fit->templates, fit->inputs, fit->vertices, fit->clusters, fit->boxes,         fit->positions,
                     fit->numbers,   fit->faults, fit->first,    fit->count,    fit->position_count};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_FIT,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = fit->count});
}
