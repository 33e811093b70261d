// SPDX-License-Identifier: Apache-2.0
// Copies a cluster's vertices from shared ones.
#include <string.h>

#include "accel/structures.h"
#include "base/simd.h"

// Copies whole vectors: a vertex and, to where the next one comes, whatever follows it.
static void copy_vectors(float *to, const float *positions, const uint32_t *numbers, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        clast_floats4 v;
        memcpy(&v, positions + 3 * (size_t)numbers[i], sizeof v);
        memcpy(to + 3 * i, &v, sizeof v);
    }
}

static void copy_vertices(float *to, const float *positions, const uint32_t *numbers, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        memcpy(to + 3 * i, positions + 3 * (size_t)numbers[i], 3 * sizeof(float));
    }
}

bool CLAST_KERNEL(clast_gather)(float *to, const float *positions, size_t position_count, const uint32_t *numbers,
                                uint32_t count)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < count; i++) {
        most = numbers[i] > most ? numbers[i] : most;
    }
    if (most >= position_count) {
        return false;
    }
    // Nothing is read beyond the last position, and nothing written beyond the last vertex.
    uint32_t with_more = most + 1 < position_count ? count - 1 : 0;
    copy_vectors(to, positions, numbers, with_more);
    copy_vertices(to + 3 * with_more, positions, numbers + with_more, count - with_more);
    return true;
}
