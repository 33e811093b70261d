// SPDX-License-Identifier: Apache-2.0
// The sum of each chunk of each column.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/sums.glsl"
#include "accel/group.glsl"

void main()
{
    uint number = linear_group();
    if (number >= push.chunks * push.columns) {
        return;
    }
    // Columns may lie item by item: groups of the same items are neighbours.
    uint column = number % push.columns;
    uint chunk = number / push.columns;
    uint64_t sum = 0ul;
    for (uint tile = 0u; tile < push.chunk; tile++) {
        uint items[ITEMS];
        load_items(column, (chunk * push.chunk + tile) * TILE + group_lane() * ITEMS, items);
        [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
            sum += items[i];
        }
    }
    sum = sum_over_group64(sum);
    if (group_lane() == 0u) {
        uint64s(push.parts).at[column * push.chunks + chunk] = sum;
    }
}
