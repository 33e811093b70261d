// SPDX-License-Identifier: Apache-2.0
#include "vulkan/fit.h"

// The push constants of shaders/accel/fit.comp.
typedef struct fit_push {
    uint64_t templates, inputs, vertices, clusters, boxes, positions, numbers, faults;
    uint32_t first, count, position_count;
} fit_push;
_Static_assert(sizeof(fit_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

clast_gpu_lanes clast_gpu_lanes_of(const clast_gpu *gpu)
{
    enum { WANTED = 32 }; // half as many as a cluster may have leaves
    const clast_gpu_features *features = clast_gpu_features_of(gpu);
    uint32_t lanes = WANTED < features->subgroup_least ? features->subgroup_least : WANTED;
    lanes = lanes > features->subgroup_most ? features->subgroup_most : lanes;
    // Drivers that are programs on the processor may hold up all subgroups of a group where one waits for itself.
    return (clast_gpu_lanes){lanes, features->is_software ? lanes : lanes * CLUSTERS_TOGETHER};
}

void clast_gpu_fit_clusters(clast_gpu_commands *commands, const clast_gpu_fit *fit)
{
    if (fit->count == 0) {
        return;
    }
    fit_push push = {fit->templates, fit->inputs, fit->vertices, fit->clusters, fit->boxes,         fit->positions,
                     fit->numbers,   fit->faults, fit->first,    fit->count,    fit->position_count};
    clast_gpu_lanes lanes = clast_gpu_lanes_of(clast_gpu_of(commands));
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_FIT,
                                              .constants = {lanes.lanes, lanes.group},
                                              .constant_count = 2,
                                              .subgroup = lanes.lanes,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = clast_gpu_lane_groups(lanes, fit->count)});
}
