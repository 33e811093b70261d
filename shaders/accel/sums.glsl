// SPDX-License-Identifier: Apache-2.0
// What the kernels of sums share: sums_reduce.comp adds up chunks, sums_write.comp writes the sums within each (reduce, then
// scan: Merrill, Grimshaw, Parallel Scan for Stream Architectures, 2009). Groups wait for no other group.
#define GROUP_SIZE 256u
layout(local_size_x = 256) in;

const uint ITEMS = 8u; // that follow each other, for each invocation
const uint TILE = GROUP_SIZE * ITEMS;

// vulkan/sums.c hands these over.
layout(push_constant, scalar) uniform clast_sums_push {
    uint64_t from, to;
    uint64_t from_column, to_column; // elements from a column to the next
    uint64_t totals;                 // zero: not wanted
    uint64_t parts;                  // sums of chunks: those of the first column, then those of the next
    uint from_stride, to_stride;     // elements from an item to the next
    uint count, columns;
    uint chunk, chunks; // tiles of a chunk, chunks of a column
}
push;

uint64_t from_address(uint column, uint item)
{
    return push.from + 4ul * (push.from_column * column + uint64_t(push.from_stride) * item);
}

uint64_t to_address(uint column, uint item)
{
    return push.to + 4ul * (push.to_column * column + uint64_t(push.to_stride) * item);
}

// Items from `first` on, zeros beyond the last.
void load_items(uint column, uint first, out uint items[ITEMS])
{
    uints from = uints(from_address(column, first));
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        items[i] = first + i < push.count ? from.at[i * push.from_stride] : 0u;
    }
}
