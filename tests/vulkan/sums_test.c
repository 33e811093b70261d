// SPDX-License-Identifier: Apache-2.0
// Sums and sorts of a device, beside plain ones.
#include <string.h>

#include "test.h"
#include "vulkan/sort.h"
#include "vulkan/sums.h"
#include "vulkan/test_device.h"

static test_device device;

static uint32_t next_random(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(*seed >> 32);
}

static clast_gpu_buffer buffer_of(uint64_t bytes)
{
    clast_gpu_buffer buffer;
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, bytes, "test", &buffer));
    return buffer;
}

// ---------------------------------------------------------------------------------------------------------------- sums

static const uint32_t lengths[] = {0, 1, 7, 8, 9, 255, 256, 257, 2047, 2048, 2049, 4096, 65535, 65537, 600001};

// Columns as they lie in memory: one after another, or item by item.
static void check_sums(uint32_t count, uint32_t columns, bool by_item, bool in_place, uint32_t mask)
{
    uint64_t room = (uint64_t)(count + 1) * columns;
    uint32_t *from = malloc(room * sizeof *from), *to = malloc(room * sizeof *to);
    assert_non_null(from);
    assert_non_null(to);
    uint64_t seed = count + columns;
    for (uint64_t i = 0; i < room; i++) {
        from[i] = next_random(&seed) & mask;
    }
    clast_gpu_buffer a = buffer_of(room * 4), b = buffer_of(room * 4), totals = buffer_of(columns * 8),
                     scratch = buffer_of(clast_gpu_sums_scratch(columns));
    clast_gpu_columns layout = {a.address, by_item ? 1 : count + 1, by_item ? columns : 0};
    clast_gpu_sums_desc desc = {layout, layout, totals.address, scratch.address, count, columns};
    desc.to.address = in_place ? a.address : b.address;
    uint64_t sums[CLAST_GPU_SUMS_COLUMNS];
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &a, 0, from, room * 4);
    clast_gpu_barrier(commands);
    clast_gpu_sums(commands, &desc);
    clast_gpu_read(commands, in_place ? &a : &b, 0, to, room * 4);
    clast_gpu_read(commands, &totals, 0, sums, columns * 8);
    assert_ok(device.context, clast_gpu_finish(commands));
    for (uint32_t c = 0; c < columns; c++) {
        uint64_t sum = 0;
        for (uint32_t i = 0; i <= count; i++) {
            uint64_t place = by_item ? (uint64_t)i * columns + c : (uint64_t)c * (count + 1) + i;
            if (to[place] != (uint32_t)sum) {
                fail_msg("%u columns of %u: sum %u of column %u is %u, not %u", columns, count, i, c, to[place],
                         (uint32_t)sum);
            }
            sum += i < count ? from[place] : 0;
        }
        assert_true(sums[c] == sum);
    }
    clast_gpu_free(device.gpu, &a);
    clast_gpu_free(device.gpu, &b);
    clast_gpu_free(device.gpu, &totals);
    clast_gpu_free(device.gpu, &scratch);
    free(from);
    free(to);
}

static void sums_are_those_of_a_loop_at_any_length(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        check_sums(lengths[i], 1, false, false, 0xff);
    }
}

static void columns_are_summed_apart_however_they_lie(void **state)
{
    (void)state;
    check_sums(5000, 5, false, false, 0xfff);
    check_sums(5000, 5, true, false, 0xfff);
    check_sums(123457, 3, true, true, 0xfff);
    check_sums(4096, 4, false, true, 0xfff);
}

static void totals_hold_what_sums_cannot(void **state)
{
    (void)state;
    check_sums(100000, 2, true, false, UINT32_MAX);
    check_sums(2047, 1, false, false, UINT32_MAX);
}

static void too_many_numbers_are_refused(void **state)
{
    (void)state;
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_sums(commands, &(clast_gpu_sums_desc){.count = UINT64_C(1) << 32, .columns = 1});
    assert_int_equal(clast_gpu_finish(commands), CLAST_ERROR_LIMIT);
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_sort(commands, &(clast_gpu_sort_desc){.count = UINT64_C(1) << 32, .bits = 32});
    assert_int_equal(clast_gpu_finish(commands), CLAST_ERROR_LIMIT);
}

// ---------------------------------------------------------------------------------------------------------------- sort

typedef struct pair {
    uint64_t key;
    uint32_t value, place;
} pair;

static uint64_t compared_bits; // of keys

static int compare_pairs(const void *a, const void *b)
{
    const pair *x = a, *y = b;
    uint64_t p = x->key & compared_bits, q = y->key & compared_bits;
    return p != q ? (p < q ? -1 : 1) : x->place < y->place ? -1 : 1;
}

typedef enum key_kind { KEYS_RANDOM, KEYS_EQUAL, KEYS_FALLING, KEYS_FEW, KEYS_ONES, KEY_KINDS } key_kind;

static uint64_t make_key(key_kind kind, uint32_t i, uint32_t count, uint64_t *seed)
{
    uint64_t random = (uint64_t)next_random(seed) << 32;
    random |= next_random(seed);
    return kind == KEYS_RANDOM    ? random
           : kind == KEYS_EQUAL   ? UINT64_C(0x0123456789abcdef)
           : kind == KEYS_FALLING ? (uint64_t)(count - i) * UINT64_C(0x100000001)
           : kind == KEYS_FEW     ? random & UINT64_C(0x0100010001010001)
                                  : UINT64_MAX;
}

static void check_sort(uint32_t count, key_kind kind, bool wide, uint32_t bits, bool numbered)
{
    uint32_t key_bytes = wide ? 8 : 4;
    pair *pairs = malloc(sizeof *pairs * (count + 1));
    uint8_t *keys = malloc((uint64_t)key_bytes * (count + 1));
    uint32_t *values = malloc(sizeof *values * (count + 1));
    assert_true(pairs != NULL && keys != NULL && values != NULL);
    uint64_t seed = count + bits;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t key = make_key(kind, i, count, &seed);
        key = wide ? key : (uint32_t)key;
        pairs[i] = (pair){key, numbered ? i : next_random(&seed), i};
        memcpy(keys + (uint64_t)key_bytes * i, &key, key_bytes); // little-endian, as devices are
        values[i] = pairs[i].value;
    }
    uint64_t bytes = (uint64_t)key_bytes * count;
    clast_gpu_buffer a = buffer_of(bytes), b = buffer_of(4 * (uint64_t)count), c = buffer_of(bytes),
                     d = buffer_of(4 * (uint64_t)count), scratch = buffer_of(CLAST_GPU_SORT_SCRATCH);
    clast_gpu_sort_desc desc = {.keys = a.address,
                                .values = b.address,
                                .spare_keys = c.address,
                                .spare_values = d.address,
                                .scratch = scratch.address,
                                .count = count,
                                .bits = bits,
                                .wide = wide,
                                .numbered = numbered};
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &a, 0, keys, bytes);
    clast_gpu_write(commands, &b, 0, values, 4 * (uint64_t)count);
    bool spare = clast_gpu_sort(commands, &desc);
    clast_gpu_read(commands, spare ? &c : &a, 0, keys, bytes);
    clast_gpu_read(commands, spare ? &d : &b, 0, values, 4 * (uint64_t)count);
    assert_ok(device.context, clast_gpu_finish(commands));
    uint32_t whole_bits = (bits + 7) / 8 * 8;
    compared_bits = whole_bits == 64 ? UINT64_MAX : (UINT64_C(1) << whole_bits) - 1;
    qsort(pairs, count, sizeof *pairs, compare_pairs);
    for (uint32_t i = 0; i < count; i++) {
        if (memcmp(keys + (uint64_t)key_bytes * i, &pairs[i].key, key_bytes) != 0 || values[i] != pairs[i].value) {
            fail_msg("%u keys of kind %d, %u bits: place %u is wrong", count, kind, bits, i);
        }
    }
    clast_gpu_buffer *all[] = {&a, &b, &c, &d, &scratch};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        clast_gpu_free(device.gpu, all[i]);
    }
    free(pairs);
    free(keys);
    free(values);
}

static void sorts_are_stable_at_any_length(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        check_sort(lengths[i], KEYS_RANDOM, false, 32, false);
    }
}

static void sorts_are_right_for_any_keys(void **state)
{
    (void)state;
    for (int kind = 0; kind < KEY_KINDS; kind++) {
        check_sort(20000, (key_kind)kind, false, 32, true);
        check_sort(20000, (key_kind)kind, true, 64, false);
        check_sort(3001, (key_kind)kind, true, 37, true);
        check_sort(30000, (key_kind)kind, false, 9, false);
    }
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_those_of_a_loop_at_any_length),
        cmocka_unit_test(columns_are_summed_apart_however_they_lie),
        cmocka_unit_test(totals_hold_what_sums_cannot),
        cmocka_unit_test(too_many_numbers_are_refused),
        cmocka_unit_test(sorts_are_stable_at_any_length),
        cmocka_unit_test(sorts_are_right_for_any_keys),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
