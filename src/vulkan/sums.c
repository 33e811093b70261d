// SPDX-License-Identifier: Apache-2.0
// Columns are cut into chunks: one kernel adds up each chunk, another adds up the chunks before its own and writes the sums
// within it. Chunks are so few that this needs no kernel of its own, and no group waits for another.
#include "vulkan/sums.h"

enum {
    TILE = 2048, // numbers that a group adds up at once: as in shaders/accel/sums.glsl
};
#define COUNT_MOST (UINT64_C(1) << 31)

// The push constants of shaders/accel/sums.glsl.
typedef struct sums_push {
    uint64_t from, to, from_column, to_column, totals, parts;
    uint32_t from_stride, to_stride, count, columns, chunk, chunks;
} sums_push;
_Static_assert(sizeof(sums_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

uint64_t clast_gpu_sums_scratch(uint32_t columns)
{
    return (uint64_t)columns * CLAST_GPU_SUMS_CHUNKS * sizeof(uint64_t);
}

static void run(clast_gpu_commands *commands, clast_shader shader, const sums_push *push)
{
    clast_gpu_run(commands, &(clast_gpu_call){.shader = shader,
                                              .push = push,
                                              .push_bytes = sizeof *push,
                                              .groups = (uint64_t)push->chunks * push->columns});
}

void clast_gpu_sums(clast_gpu_commands *commands, const clast_gpu_sums_desc *desc)
{
    if (desc->count > COUNT_MOST || desc->columns > CLAST_GPU_SUMS_COLUMNS) {
        clast_gpu_note(commands, clast_fail(clast_gpu_context(clast_gpu_of(commands)), CLAST_ERROR_LIMIT,
                                            "sums over %u columns of %llu numbers; %d columns of 2^31 are possible",
                                            desc->columns, (unsigned long long)desc->count, CLAST_GPU_SUMS_COLUMNS));
        return;
    }
    if (desc->columns == 0) {
        return;
    }
    uint32_t tiles = (uint32_t)(desc->count / TILE) + 1; // one number more is written than there are
    uint32_t chunk = (tiles + CLAST_GPU_SUMS_CHUNKS - 1) / CLAST_GPU_SUMS_CHUNKS;
    sums_push push = {.from = desc->from.address,
                      .to = desc->to.address,
                      .from_column = desc->from.column,
                      .to_column = desc->to.column,
                      .totals = desc->totals,
                      .parts = desc->scratch,
                      .from_stride = desc->from.stride != 0 ? desc->from.stride : 1,
                      .to_stride = desc->to.stride != 0 ? desc->to.stride : 1,
                      .count = (uint32_t)desc->count,
                      .columns = desc->columns,
                      .chunk = chunk,
                      .chunks = (tiles + chunk - 1) / chunk};
    if (push.chunks > 1) {
        run(commands, CLAST_SHADER_ACCEL_SUMS_REDUCE, &push);
        clast_gpu_barrier(commands);
    }
    run(commands, CLAST_SHADER_ACCEL_SUMS_WRITE, &push);
}
