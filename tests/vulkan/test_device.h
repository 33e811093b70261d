// SPDX-License-Identifier: Apache-2.0
// A Vulkan device for tests: the one that the loader offers, with the validation layer where there is one. ctest names the
// software driver (scripts/mesa); CLAST_TEST_SUBGROUP asks for a width of subgroups.
#ifndef CLAST_TESTS_VULKAN_DEVICE_H
#define CLAST_TESTS_VULKAN_DEVICE_H

#include <stdio.h>
#include <stdlib.h>

#include "vulkan/gpu.h"

typedef struct test_device {
    clast_context *context;
    clast_gpu *gpu;
    uint64_t memory; // of the context alone
} test_device;

static inline void test_device_log(void *user, clast_log_level level, const char *text)
{
    (void)user;
    if (level == CLAST_LOG_WARNING || getenv("CLAST_TEST_VERBOSE") != NULL) {
        fprintf(stderr, "%s\n", text);
    }
}

// A test that stops what is under way sets this before it opens the device.
static clast_progress_hook test_device_progress;

// Opens it, or ends the test as skipped.
static inline test_device test_device_open_as(const clast_gpu_desc *wanted)
{
    clast_gpu_desc desc = *wanted;
    const char *subgroup = getenv("CLAST_TEST_SUBGROUP");
    desc.subgroup = subgroup != NULL ? (uint32_t)strtoul(subgroup, NULL, 10) : desc.subgroup;
    test_device device = {0};
    clast_context_desc context = {.log = {test_device_log, NULL}, .progress = test_device_progress};
    if (clast_context_create(&context, &device.context) != CLAST_OK) {
        fprintf(stderr, "no context\n");
        exit(1);
    }
    device.memory = clast_context_memory(device.context);
    if (clast_gpu_create(device.context, &desc, &device.gpu) != CLAST_OK) {
        fprintf(stderr, "skipped: %s\n", clast_context_error(device.context));
        clast_context_destroy(device.context);
        exit(77);
    }
    return device;
}

static inline test_device test_device_open(void)
{
    return test_device_open_as(&(clast_gpu_desc){.software = true, .hardware = true, .validate = true});
}

// Closes it; false where the validation layer had something to say, or memory was not freed.
static inline bool test_device_close(test_device *device)
{
    uint32_t messages = clast_gpu_validation_messages(device->gpu);
    clast_gpu_destroy(device->gpu);
    uint64_t memory = clast_context_memory(device->context) - device->memory;
    clast_context_destroy(device->context);
    if (messages != 0 || memory != 0) {
        fprintf(stderr, "%u validation messages, %llu bytes of memory left\n", messages, (unsigned long long)memory);
    }
    return messages == 0 && memory == 0;
}

#endif
