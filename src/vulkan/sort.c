// SPDX-License-Identifier: Apache-2.0
// A radix sort from the lowest digit up, as shaders/accel/sort.glsl tells.
#include "vulkan/sort.h"

enum {
    DIGIT_BITS = 8,
    CHUNK_BITS = 11, // a chunk has so many keys at least, as a power of two
    ROW = 32,        // keys that are ranked together
    ITEMS = 8,       // keys of an invocation
    ITEMS_APART = 2, // where rows are no subgroups
};
#define COUNT_MOST (UINT64_C(1) << 31)

// The push constants of shaders/accel/sort.glsl.
typedef struct sort_push {
    uint64_t from_keys, from_values, to_keys, to_values, counts;
    uint32_t count, digit, digits, chunk_bits, chunks, numbered;
} sort_push;

static void run(clast_gpu_commands *commands, clast_shader shader, const sort_push *push, bool wide)
{
    const clast_gpu_features *features = clast_gpu_features_of(clast_gpu_of(commands));
    bool can_ask = features->subgroup_control && features->subgroup_least <= ROW && features->subgroup_most >= ROW;
    bool together = can_ask || features->subgroup_least >= ROW;
    clast_gpu_barrier(commands);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = shader,
                                              .constants = {wide ? 2 : 1, together, together ? ITEMS : ITEMS_APART},
                                              .constant_count = shader == CLAST_SHADER_ACCEL_SORT_PASS ? 3 : 1,
                                              .push = push,
                                              .push_bytes = sizeof *push,
                                              .groups = push->chunks,
                                              .subgroup = can_ask ? ROW : 0});
}

bool clast_gpu_sort(clast_gpu_commands *commands, const clast_gpu_sort_desc *desc)
{
    if (desc->count > COUNT_MOST) {
        clast_gpu_note(commands, clast_fail(clast_gpu_context(clast_gpu_of(commands)), CLAST_ERROR_LIMIT,
                                            "a sort of %llu keys; 2^31 are possible", (unsigned long long)desc->count));
        return false;
    }
    if (desc->count == 0) {
        return false;
    }
    sort_push push = {.from_keys = desc->keys,
                      .from_values = desc->values,
                      .to_keys = desc->spare_keys,
                      .to_values = desc->spare_values,
                      .counts = desc->scratch,
                      .count = (uint32_t)desc->count,
                      .digits = (desc->bits + DIGIT_BITS - 1) / DIGIT_BITS,
                      .chunk_bits = CHUNK_BITS,
                      .numbered = desc->numbered};
    while ((desc->count - 1) >> push.chunk_bits >= CLAST_GPU_SORT_CHUNKS) {
        push.chunk_bits++;
    }
    push.chunks = (uint32_t)((desc->count - 1) >> push.chunk_bits) + 1;
    run(commands, CLAST_SHADER_ACCEL_SORT_COUNT, &push, desc->wide);
    for (; push.digit < push.digits; push.digit++) {
        run(commands, CLAST_SHADER_ACCEL_SORT_PASS, &push, desc->wide);
        uint64_t keys = push.from_keys, values = push.from_values;
        push.from_keys = push.to_keys;
        push.from_values = push.to_values;
        push.to_keys = keys;
        push.to_values = values;
        push.numbered = 0;
    }
    return push.digits % 2 != 0;
}
