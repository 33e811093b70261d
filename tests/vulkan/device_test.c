// SPDX-License-Identifier: Apache-2.0
// Devices, memory and copies.
#include <string.h>

#include "test.h"
#include "vulkan/gpu.h"
#include "vulkan/test_device.h"

static test_device device;

static uint32_t pattern(uint64_t i)
{
    return (uint32_t)(i * 2654435761u) ^ (uint32_t)(i >> 7);
}

static void copies_of_any_size_arrive_whole(void **state)
{
    (void)state;
    const uint64_t sizes[] = {4, 16, 4096, (uint64_t)(8 << 20) + 4, (uint64_t)(65 << 20) + 12, (uint64_t)260 << 20};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        uint64_t words = sizes[s] / 4;
        uint32_t *data = malloc(sizes[s]), *back = calloc(1, sizes[s]);
        assert_non_null(data);
        assert_non_null(back);
        for (uint64_t i = 0; i < words; i++) {
            data[i] = pattern(i);
        }
        clast_gpu_buffer a, b;
        assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, sizes[s], "a", &a));
        assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, sizes[s], "b", &b));
        clast_gpu_commands *commands;
        assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
        clast_gpu_pass(commands, "copy");
        clast_gpu_write(commands, &a, 0, data, sizes[s]);
        clast_gpu_barrier(commands);
        clast_gpu_copy(commands, &b, 0, &a, 0, sizes[s]);
        clast_gpu_read(commands, &b, 0, back, sizes[s]);
        assert_ok(device.context, clast_gpu_finish(commands));
        assert_memory_equal(data, back, sizes[s]);
        clast_gpu_free(device.gpu, &a);
        clast_gpu_free(device.gpu, &b);
        free(data);
        free(back);
    }
    assert_int_equal(clast_gpu_bytes(device.gpu) >> 30, 0);
}

static void fills_write_what_they_are_told(void **state)
{
    (void)state;
    clast_gpu_buffer buffer;
    uint32_t back[64];
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, sizeof back, "filled", &buffer));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_fill(commands, &buffer, 0, sizeof back, 7);
    clast_gpu_barrier(commands);
    clast_gpu_fill(commands, &buffer, 16, 32, 9);
    clast_gpu_read(commands, &buffer, 0, back, sizeof back);
    assert_ok(device.context, clast_gpu_finish(commands));
    for (int i = 0; i < 64; i++) {
        assert_int_equal(back[i], i >= 4 && i < 12 ? 9 : 7);
    }
    clast_gpu_free(device.gpu, &buffer);
}

static void buffers_do_not_overlap_and_are_used_again(void **state)
{
    (void)state;
    enum { COUNT = 400 };
    static clast_gpu_buffer buffers[COUNT];
    uint64_t seed = 1;
    for (int round = 0; round < 20; round++) {
        for (int i = 0; i < COUNT; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            if ((seed >> 33) % 3 == 0) {
                clast_gpu_free(device.gpu, &buffers[i]);
            } else if (buffers[i].bytes == 0) {
                uint64_t bytes = (seed >> 40) % 300000;
                assert_ok(device.context,
                          clast_gpu_allocate(device.gpu, CLAST_GPU_UPLOAD, bytes, "piece", &buffers[i]));
                assert_int_equal(buffers[i].address % 256, 0);
                memset(buffers[i].mapped, i, buffers[i].bytes);
            }
        }
        for (int i = 0; i < COUNT; i++) {
            const unsigned char *bytes = buffers[i].mapped;
            for (uint64_t k = 0; k < buffers[i].bytes; k += 61) {
                assert_int_equal(bytes[k], i & 255);
            }
        }
    }
    for (int i = 0; i < COUNT; i++) {
        clast_gpu_free(device.gpu, &buffers[i]);
    }
}

static void copies_outside_a_buffer_are_refused(void **state)
{
    (void)state;
    clast_gpu_buffer buffer;
    char data[64] = {0};
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, 32, "small", &buffer));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &buffer, 0, data, 64);
    assert_int_equal(clast_gpu_finish(commands), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &buffer, 0, data, 32);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &buffer);
}

static void a_limit_of_memory_is_kept(void **state)
{
    (void)state;
    test_device bounded = test_device_open_as(
        &(clast_gpu_desc){.software = true, .hardware = true, .memory_limit = (uint64_t)16 << 20});
    clast_gpu_buffer small, large;
    assert_ok(bounded.context, clast_gpu_allocate(bounded.gpu, CLAST_GPU_DEVICE, 8 << 20, "small", &small));
    assert_int_equal(clast_gpu_allocate(bounded.gpu, CLAST_GPU_DEVICE, 12 << 20, "large", &large),
                     CLAST_ERROR_OUT_OF_MEMORY);
    assert_non_null(strstr(clast_context_error(bounded.context), "large"));
    clast_gpu_free(bounded.gpu, &small);
    assert_ok(bounded.context, clast_gpu_allocate(bounded.gpu, CLAST_GPU_DEVICE, 12 << 20, "large", &large));
    clast_gpu_free(bounded.gpu, &large);
    assert_true(test_device_close(&bounded));
}

static void a_device_that_is_not_there_is_refused_with_the_reason(void **state)
{
    (void)state;
    clast_gpu *gpu;
    clast_gpu_desc desc = {.software = true, .hardware = true, .device = "no such device"};
    assert_int_equal(clast_gpu_create(device.context, &desc, &gpu), CLAST_ERROR_DEVICE);
    assert_null(gpu);
    assert_non_null(strstr(clast_context_error(device.context), "no such device"));
    desc = (clast_gpu_desc){0};
    assert_int_equal(clast_gpu_create(device.context, &desc, &gpu), CLAST_ERROR_DEVICE);
    assert_non_null(strstr(clast_context_error(device.context), "not asked for"));
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_of_any_size_arrive_whole),
        cmocka_unit_test(fills_write_what_they_are_told),
        cmocka_unit_test(buffers_do_not_overlap_and_are_used_again),
        cmocka_unit_test(copies_outside_a_buffer_are_refused),
        cmocka_unit_test(a_limit_of_memory_is_kept),
        cmocka_unit_test(a_device_that_is_not_there_is_refused_with_the_reason),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
