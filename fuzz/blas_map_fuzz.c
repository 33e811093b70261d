// SPDX-License-Identifier: Apache-2.0
// Stored acceleration structures, used where they lie: what decides whether the rest is looked at is put right, and rays go
// through what is accepted.
#include <math.h>

#include "accel/stored.h"
#include "fuzz.h"

static void put_right(uint8_t *block, size_t size)
{
    stored_header header;
    if (size >= sizeof header) {
        memcpy(&header, block, sizeof header);
        memcpy(header.magic, STORED_MAGIC, sizeof STORED_MAGIC);
        header.version = STORED_VERSION;
        header.order = STORED_ORDER;
        header.bytes = size;
        memset(header.zeros, 0, sizeof header.zeros);
        memcpy(block, &header, sizeof header);
    }
}

static void trace(clast_context *context, const clast_blas *blas)
{
    clast_tlas *tlas;
    clast_tlas_instance instance = {.blas = blas, .transform = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    FUZZ_CHECK(clast_tlas_create(context, &tlas) == CLAST_OK);
    FUZZ_CHECK(clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST) == CLAST_OK);
    for (int i = 0; i < 4; i++) {
        clast_ray ray = {{0.1f * (float)i, -2.0f, 0.3f}, 0, {0.05f, 1.0f, 0.1f * (float)i}, INFINITY};
        clast_hit hit;
        uint8_t occluded;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        clast_trace_any(tlas, &ray, 1, NULL, &occluded);
    }
    clast_tlas_destroy(tlas);
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    void *block = NULL;
    size_t whole = size / STORED_ALIGNMENT * STORED_ALIGNMENT;
    FUZZ_CHECK(posix_memalign(&block, STORED_ALIGNMENT, whole != 0 ? whole : 1) == 0);
    memcpy(block, data, whole);
    put_right(block, whole);
    clast_blas *blas;
    if (clast_blas_map(context, block, whole, false, &blas) == CLAST_OK) {
        trace(context, blas);
        clast_blas_destroy(blas);
    }
    free(block);
}
