// SPDX-License-Identifier: Apache-2.0
#include "vulkan_open.h"

#include <stdio.h>

static void log_line(void *user, clast_log_level level, const char *text)
{
    (void)user;
    if (level == CLAST_LOG_WARNING) {
        fprintf(stderr, "%s\n", text);
    }
}

bool vulkan_open(bench *b, bool ray_tracing, clast_context **context, clast_gpu **gpu)
{
    clast_context_desc desc = {.threads = b->options.threads, .log = {log_line, NULL}};
    bench_check(clast_context_create(&desc, context), NULL);
    clast_gpu_desc wanted = {.software = b->options.triangles != 0, .hardware = true, .ray_tracing = ray_tracing};
    if (clast_gpu_create(*context, &wanted, gpu) != CLAST_OK) {
        fprintf(stderr, "skipped: %s\n", clast_context_error(*context));
        clast_context_destroy(*context);
        bench_end(b);
        return false;
    }
    const clast_gpu_features *features = clast_gpu_features_of(*gpu);
    snprintf(b->machine, sizeof b->machine, "%s, %s", features->name, features->driver);
    return true;
}

void vulkan_wake(clast_context *context, clast_gpu *gpu)
{
    enum { GROUPS = 2048, SPIN_TURNS = 20000 };
    const double enough = 0.1; // seconds
    if (clast_gpu_features_of(gpu)->is_software) {
        return;
    }
    struct {
        uint64_t to;
        uint32_t turns;
    } push = {0, SPIN_TURNS};
    for (double begin = bench_seconds(); bench_seconds() - begin < enough;) {
        clast_gpu_commands *commands;
        bench_check(clast_gpu_begin(gpu, &commands), context);
        clast_gpu_run(
            commands,
            &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_SPIN, .push = &push, .push_bytes = 12, .groups = GROUPS});
        bench_check(clast_gpu_finish(commands), context);
    }
}

void vulkan_close(clast_context *context, clast_gpu *gpu)
{
    clast_gpu_destroy(gpu);
    clast_context_destroy(context);
}
