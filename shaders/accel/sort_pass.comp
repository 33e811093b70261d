// SPDX-License-Identifier: Apache-2.0
// Puts keys and values in the order of one digit; those of one digit keep their order. Within a tile, keys are ranked by the
// bits of those that have the same digit in a row of 32 (Adinets, Merrill, Onesweep, 2022, section 3.4), sorted in the group's
// memory, and written in runs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/sort.glsl"
#include "accel/group.glsl"

// 1: subgroups are 32 wide or wider, so that a row is within one.
layout(constant_id = 1) const uint ROWS_TOGETHER = 0u;

// For each invocation, up to 8: fewer where rows wait by barriers, of which drivers that are programs make much code.
layout(constant_id = 2) const uint ITEMS = 8u;

const uint TILE = GROUP_SIZE * ITEMS;
const uint TILE_MOST = GROUP_SIZE * 8u;
const uint ROW = 32u;
const uint ROWS = GROUP_SIZE / ROW;
const uint ROW_COUNTS = ROWS * DIGITS; // where they begin in `room`

// While ranking: for each row and digit who has it, then how many there were. Later a tile's keys, then its values.
shared uint room[2u * TILE_MOST];
shared uint bases[DIGITS];  // where the chunk's next key of each digit goes
shared uint shifts[DIGITS]; // from a place in the tile to where that goes

void row_barrier()
{
    if (ROWS_TOGETHER != 0u) {
        subgroupMemoryBarrierShared();
        subgroupBarrier();
    } else {
        barrier();
    }
}

void find_bases(uint chunk, uint lane)
{
    uints table = table_of(push.digit);
    uint before = 0u, all = 0u;
    for (uint i = 0u; i < push.chunks; i += 16u) {
        [[unroll]] for (uint k = 0u; k < 16u; k++) {
            uint part = i + k < push.chunks ? table.at[(i + k) * DIGITS + lane] : 0u;
            before += i + k < chunk ? part : 0u;
            all += part;
        }
    }
    bases[lane] = sum_over_group(all).before + before;
}

void clear_rows(uint lane)
{
    for (uint i = lane; i < 2u * ROW_COUNTS; i += GROUP_SIZE) {
        room[i] = 0u;
    }
}

// How many keys of the row with this digit came before, in earlier calls or in lower lanes.
uint rank_in_row(uint row, uint digit, uint bit)
{
    uint slot = row * DIGITS + digit;
    atomicOr(room[slot], bit);
    row_barrier();
    uint peers = room[slot];
    uint before = room[ROW_COUNTS + slot];
    uint lower = bitCount(peers & (bit - 1u));
    row_barrier();
    if (lower == 0u) {
        room[slot] = 0u;
        room[ROW_COUNTS + slot] = before + bitCount(peers);
    }
    row_barrier();
    return before + lower;
}

// Counts become where the row's keys with the digit begin in the tile.
void place_rows(uint lane)
{
    uint sum = 0u;
    [[unroll]] for (uint row = 0u; row < ROWS; row++) {
        sum += room[ROW_COUNTS + row * DIGITS + lane];
    }
    uint first = sum_over_group(sum).before;
    shifts[lane] = bases[lane] - first;
    bases[lane] += sum;
    [[unroll]] for (uint row = 0u; row < ROWS; row++) {
        uint count = room[ROW_COUNTS + row * DIGITS + lane];
        room[ROW_COUNTS + row * DIGITS + lane] = first;
        first += count;
    }
}

void write_item(uvec2 key, uint to)
{
    if (KEY_WORDS == 1u) {
        uints(push.to_keys).at[to] = key.x;
    } else {
        uints words = uints(push.to_keys + 8ul * to);
        words.at[0] = key.x;
        words.at[1] = key.y;
    }
    if (push.digit + 1u < push.digits) {
        uint place = (to >> push.chunk_bits) * DIGITS + digit_of(key, push.digit + 1u);
        atomicAdd(table_of(push.digit + 1u).at[place], 1u);
    }
}

void sort_tile(uint first, uint end, uint lane)
{
    uint row = lane / ROW, bit = 1u << (lane % ROW);
    uvec2 keys[ITEMS];
    uint values[ITEMS], places[ITEMS];
    clear_rows(lane);
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        uint place = first + (row * ITEMS + i) * ROW + lane % ROW;
        bool there = place < end;
        keys[i] = there ? load_key(push.from_keys, place) : uvec2(0xffffffffu); // after all that are there
        values[i] = push.numbered != 0u || !there ? place : uints(push.from_values).at[place];
    }
    barrier();
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        places[i] = rank_in_row(row, digit_of(keys[i], push.digit), bit);
    }
    barrier();
    place_rows(lane);
    barrier();
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        places[i] += room[ROW_COUNTS + row * DIGITS + digit_of(keys[i], push.digit)];
    }
    barrier();
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        room[places[i]] = keys[i].x;
        room[TILE + places[i]] = KEY_WORDS == 1u ? values[i] : keys[i].y;
    }
    barrier();
    uint to[ITEMS];
    [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
        uint place = i * GROUP_SIZE + lane;
        uint second = room[TILE + place];
        uvec2 key = uvec2(room[place], KEY_WORDS == 1u ? 0u : second);
        to[i] = shifts[digit_of(key, push.digit)] + place;
        if (place < end - first) {
            write_item(key, to[i]);
            if (KEY_WORDS == 1u) {
                uints(push.to_values).at[to[i]] = second;
            }
        }
    }
    barrier();
    if (KEY_WORDS != 1u) {
        [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
            room[places[i]] = values[i];
        }
        barrier();
        [[unroll]] for (uint i = 0u; i < ITEMS; i++) {
            uint place = i * GROUP_SIZE + lane;
            if (place < end - first) {
                uints(push.to_values).at[to[i]] = room[place];
            }
        }
        barrier();
    }
}

void main()
{
    uint chunk = linear_group();
    if (chunk >= push.chunks) {
        return;
    }
    uint lane = group_lane();
    find_bases(chunk, lane);
    uint first = chunk << push.chunk_bits;
    uint end = first + min(push.count - first, 1u << push.chunk_bits);
    for (; first < end; first += TILE) {
        sort_tile(first, end, lane);
    }
}
