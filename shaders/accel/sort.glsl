// SPDX-License-Identifier: Apache-2.0
// What the kernels of the sort share. Keys are cut into chunks; for each pass over a digit there is a table of how many keys of
// each chunk have which digit. sort_count.comp makes the first table. sort_pass.comp puts keys where they go, and counts there
// for the pass after it, so that a pass is one kernel, and no group waits for another.
#define GROUP_SIZE 256u
layout(local_size_x = 256) in;
layout(constant_id = 0) const uint KEY_WORDS = 1u;

const uint DIGIT_BITS = 8u;
const uint DIGITS = 256u; // as many as invocations

// vulkan/sort.c hands these over.
layout(push_constant, scalar) uniform clast_sort_push {
    uint64_t from_keys, from_values, to_keys, to_values;
    uint64_t counts; // the tables, for each chunk DIGITS numbers
    uint count;
    uint digit, digits; // which of how many
    uint chunk_bits;    // a chunk is so many keys, as a power of two
    uint chunks;
    uint numbered;      // values are the keys' own numbers
}
push;

uints table_of(uint digit) { return uints(push.counts + 4ul * DIGITS * (uint64_t(digit) * push.chunks)); }

// The low word first.
uvec2 load_key(uint64_t keys, uint place)
{
    if (KEY_WORDS == 1u) {
        return uvec2(uints(keys).at[place], 0u);
    }
    uints words = uints(keys + 8ul * place);
    return uvec2(words.at[0], words.at[1]);
}

uint digit_of(uvec2 key, uint digit)
{
    uint word = KEY_WORDS == 1u || digit < 4u ? key.x : key.y;
    return word >> (DIGIT_BITS * (digit & 3u)) & (DIGITS - 1u);
}
