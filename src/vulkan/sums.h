// SPDX-License-Identifier: Apache-2.0
// Sums before each of many numbers, on the device: from counts to where each one's part begins.
#ifndef CLAST_VULKAN_SUMS_H
#define CLAST_VULKAN_SUMS_H

#include "vulkan/gpu.h"

enum {
    CLAST_GPU_SUMS_COLUMNS = 64,
    CLAST_GPU_SUMS_CHUNKS = 1024, // the most that a column is cut into
};

// Columns of 32-bit numbers. Number i of column c is number i * stride + c * column from `address` on.
typedef struct clast_gpu_columns {
    uint64_t address;
    uint64_t column;
    uint32_t stride; // zero is one
} clast_gpu_columns;

typedef struct clast_gpu_sums_desc {
    clast_gpu_columns from;
    // Gets count + 1 numbers a column: number i is the sum of those before i, and the last the sum of all, modulo 2^32. So the
    // difference of two of them is right where that sum is less than 2^32, even if the sum of all is not. May be `from`.
    clast_gpu_columns to;
    uint64_t totals;  // address of 64 bits for each column: the sum of all; zero: not wanted
    uint64_t scratch; // address of clast_gpu_sums_scratch(columns) bytes
    uint64_t count;   // at most 2^31
    uint32_t columns; // at most CLAST_GPU_SUMS_COLUMNS
} clast_gpu_sums_desc;

uint64_t clast_gpu_sums_scratch(uint32_t columns);
// Two kernels, with a barrier between them. LIMIT is noted in the commands where there are too many.
void clast_gpu_sums(clast_gpu_commands *commands, const clast_gpu_sums_desc *desc);

#endif
