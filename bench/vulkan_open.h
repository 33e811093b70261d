// SPDX-License-Identifier: Apache-2.0
// The Vulkan device that a benchmark runs on.
#ifndef CLAST_BENCH_VULKAN_OPEN_H
#define CLAST_BENCH_VULKAN_OPEN_H

#include "bench.h"
#include "vulkan/gpu.h"

enum { BENCH_NO_DEVICE = 77 }; // what a program ends with where there is none

// Opens it, and tells the results which it is. Drivers that are programs on the processor count where the number of triangles is
// given. False, after a line that tells why, where there is none: all is freed then, the benchmark too.
bool vulkan_open(bench *b, bool ray_tracing, clast_context **context, clast_gpu **gpu);
// Keeps the device busy until it runs as fast as it can: to be called before what is measured, wherever the processor worked for
// long.
void vulkan_wake(clast_context *context, clast_gpu *gpu);
void vulkan_close(clast_context *context, clast_gpu *gpu);

#endif
