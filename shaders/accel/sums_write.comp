// SPDX-License-Identifier: Apache-2.0
// The sums before each item, of each chunk of each column, and the columns' totals.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/sums.glsl"
#include "accel/group.glsl"

// Of the chunks [0, end) of a column.
uint64_t sum_of_chunks(uint column, uint end)
{
    uint64_t sum = 0ul;
    for (uint first = 0u; first < end; first += GROUP_SIZE) {
        uint i = first + group_lane();
        sum += i < end ? uint64s(push.parts).at[column * push.chunks + i] : 0ul;
    }
    return sum_over_group64(sum);
}

// Where a chunk has come to: the sum before the next tile as the columns hold it, and what this invocation has seen.
struct progress {
    uint sum;
    uint64_t own;
};

progress write_tile(uint column, uint first, progress done)
{
    uint items[ITEMS];
    load_items(column, first, items);
    uint64_t own = 0ul;
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        own += items[i];
    }
    group_sum all = sum_over_group(uint(own));
    uint before = done.sum + all.before;
    uints to = uints(to_address(column, first));
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        if (first + i <= push.count) { // one more than there are: the sum of all
            to.at[i * push.to_stride] = before;
        }
        before += items[i];
    }
    return progress(done.sum + all.all, done.own + own);
}

void main()
{
    uint number = linear_group();
    if (number >= push.chunks * push.columns) {
        return;
    }
    uint column = number % push.columns;
    uint chunk = number / push.columns;
    uint64_t before = chunk == 0u ? 0ul : sum_of_chunks(column, chunk);
    progress done = progress(uint(before), 0ul);
    for (uint tile = 0u; tile < push.chunk; tile++) {
        done = write_tile(column, (chunk * push.chunk + tile) * TILE + group_lane() * ITEMS, done);
    }
    if (push.totals != 0ul && chunk == push.chunks - 1u) {
        uint64_t own = sum_over_group64(done.own);
        if (group_lane() == 0u) {
            uint64s(push.totals).at[column] = before + own;
        }
    }
}
