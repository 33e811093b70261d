// SPDX-License-Identifier: Apache-2.0
// The one checked-range mechanism for binary reads. A clast_bytes is a piece of a file; pieces of it, and values in it, are had
// only by the functions below, which refuse what does not lie inside.
#ifndef CLAST_LOAD_BYTES_H
#define CLAST_LOAD_BYTES_H

#include <string.h>

#include "base/size.h"

typedef struct clast_bytes {
    const unsigned char *data;
    uint64_t size;
} clast_bytes;

// The most bytes that a file of `stored` bytes may come to in memory: what needs more is refused, so that a small file cannot
// fill it. Scenes count all of their files together.
static inline uint64_t clast_unpacked_most(uint64_t stored)
{
    const uint64_t free_bytes = (uint64_t)64 << 20, ratio = 20;
    return stored < (UINT64_MAX - free_bytes) / ratio ? free_bytes + ratio * stored : UINT64_MAX;
}

// The piece [offset, offset + length); false where it is not inside.
static inline bool clast_bytes_slice(clast_bytes bytes, uint64_t offset, uint64_t length, clast_bytes *slice)
{
    if (!clast_range_fits(offset, length, bytes.size)) {
        return false;
    }
    *slice = (clast_bytes){bytes.data + offset, length};
    return true;
}

// Copies `length` bytes from `offset`; false where they are not inside. For values of any alignment.
static inline bool clast_bytes_read(clast_bytes bytes, uint64_t offset, void *value, size_t length)
{
    if (!clast_range_fits(offset, length, bytes.size)) {
        return false;
    }
    memcpy(value, bytes.data + offset, length);
    return true;
}

// Four bytes, the low one first.
static inline uint32_t clast_load_word(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

// Whether this machine stores the low byte first.
static inline bool clast_is_little_endian(void)
{
    uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static inline bool clast_bytes_begin_with(clast_bytes bytes, const char *text)
{
    size_t length = strlen(text);
    return bytes.size >= length && memcmp(bytes.data, text, length) == 0;
}

#endif
