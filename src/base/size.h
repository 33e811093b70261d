// SPDX-License-Identifier: Apache-2.0
// Overflow-checked arithmetic of sizes and ranges. Every length, count and offset that comes from outside passes here
// before anything is allocated or read.
#ifndef CLAST_BASE_SIZE_H
#define CLAST_BASE_SIZE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Each gives false where the result does not fit, and leaves `*result` alone.
static inline bool clast_add_size(size_t a, size_t b, size_t *result)
{
    if (b > SIZE_MAX - a) {
        return false;
    }
    *result = a + b;
    return true;
}

static inline bool clast_multiply_size(size_t a, size_t b, size_t *result)
{
    if (a != 0 && b > SIZE_MAX / a) {
        return false;
    }
    *result = a * b;
    return true;
}

// True where [offset, offset + length) lies within `size` bytes.
static inline bool clast_range_fits(uint64_t offset, uint64_t length, uint64_t size)
{
    return offset <= size && length <= size - offset;
}

// True where `count` elements of `element` bytes, `stride` bytes apart, starting at `offset`, lie within `size` bytes.
// The last element needs `element` bytes only, not a whole stride. A count of zero needs a valid offset only.
static inline bool clast_elements_fit(uint64_t offset, uint64_t count, uint64_t stride, uint64_t element, uint64_t size)
{
    if (offset > size) {
        return false;
    }
    if (count == 0) {
        return true;
    }
    uint64_t room = size - offset;
    if (element > room) {
        return false;
    }
    return count - 1 == 0 || stride == 0 || count - 1 <= (room - element) / stride;
}

#endif
