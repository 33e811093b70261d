// SPDX-License-Identifier: Apache-2.0
#include "vulkan/rays.h"

enum {
    GROUP = 128,
    PAIRS = 1,
    REFILL = 8,
    STEPS = 4,
    GROUPS = 4096, // that take rays: enough to fill a large device
    GROUPS_SOFTWARE = 64,
    RAYS_LEAST = 8, // for each invocation that takes rays
};

// The push constants of shaders/accel/trace_rays.glsl.
typedef struct rays_push {
    uint64_t scene, from, to, ticket;
    uint32_t count;
} rays_push;
_Static_assert(sizeof(rays_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

// A number of a tuning: as it is, 0 where it says never, or a default.
static uint32_t choose(uint32_t number, uint32_t otherwise)
{
    return number == 0 ? otherwise : number == UINT32_MAX ? 0 : number;
}

static void trace(clast_gpu_commands *commands, const clast_gpu_rays *rays, clast_shader shader)
{
    if (rays->count == 0) {
        return;
    }
    const clast_gpu_rays_tuning *tuning = &rays->tuning;
    bool incoherent = rays->kind == CLAST_GPU_RAYS_INCOHERENT;
    bool is_software = clast_gpu_features_of(clast_gpu_of(commands))->is_software;
    uint32_t group = choose(tuning->group, GROUP), refill = choose(tuning->refill, incoherent ? REFILL : 0);
    uint64_t groups = ((uint64_t)rays->count + group - 1) / group;
    if (refill != 0) {
        uint64_t most = choose(tuning->groups, is_software ? GROUPS_SOFTWARE : GROUPS);
        uint64_t enough = ((uint64_t)rays->count + (uint64_t)RAYS_LEAST * group - 1) / (RAYS_LEAST * group);
        groups = enough < most ? enough : most;
        clast_gpu_barrier(commands);
        clast_gpu_fill(commands, rays->scratch, 0, sizeof(uint32_t), 0);
        clast_gpu_barrier(commands);
    }
    rays_push push = {rays->scene, rays->rays, rays->to, rays->scratch != NULL ? rays->scratch->address : 0,
                      rays->count};
    clast_gpu_call call = {
        .shader = shader,
        .constants = {group, refill, choose(tuning->steps, STEPS), choose(tuning->pairs, PAIRS), tuning->bytes},
        .constant_count = 5,
        .push = &push,
        .push_bytes = sizeof push,
        .groups = groups};
    clast_gpu_run(commands, &call);
    if (refill != 0 && shader == CLAST_SHADER_ACCEL_TRACE_CLOSEST) {
        call.shader = CLAST_SHADER_ACCEL_TRACE_FINISH;
        call.groups = ((uint64_t)rays->count + group - 1) / group;
        clast_gpu_barrier(commands);
        clast_gpu_run(commands, &call);
    }
}

void clast_gpu_trace_closest(clast_gpu_commands *commands, const clast_gpu_rays *rays)
{
    trace(commands, rays, CLAST_SHADER_ACCEL_TRACE_CLOSEST);
}

void clast_gpu_trace_any(clast_gpu_commands *commands, const clast_gpu_rays *rays)
{
    trace(commands, rays, CLAST_SHADER_ACCEL_TRACE_ANY);
}
