// SPDX-License-Identifier: Apache-2.0
// A mesh of an input's bytes: few vertices, on a grid or anywhere, and any triangles over them.
#ifndef CLAST_FUZZ_MESH_H
#define CLAST_FUZZ_MESH_H

#include "fuzz.h"

enum { FUZZ_VERTICES = 256, FUZZ_TRIANGLES = 512 };

typedef struct fuzz_mesh {
    float positions[FUZZ_VERTICES * 3];
    uint32_t indices[FUZZ_TRIANGLES * 3];
    uint32_t vertex_count, triangle_count;
} fuzz_mesh;

static inline float fuzz_float(fuzz_bytes *bytes, bool is_wild)
{
    if (!is_wild) {
        return (float)(int8_t)fuzz_byte(bytes) * 0.125f;
    }
    uint32_t bits = fuzz_word(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value - value == 0.0f ? value : 1.0f; // finite
}

// Takes all bytes that are left.
static inline void fuzz_mesh_fill(fuzz_bytes *bytes, fuzz_mesh *mesh)
{
    bool is_wild = fuzz_byte(bytes) % 4 == 3;
    mesh->vertex_count = 1u + fuzz_byte(bytes);
    for (uint32_t i = 0; i < 3 * mesh->vertex_count; i++) {
        mesh->positions[i] = fuzz_float(bytes, is_wild);
    }
    mesh->triangle_count = 0;
    while (bytes->at < bytes->end && mesh->triangle_count < FUZZ_TRIANGLES) {
        for (uint32_t k = 0; k < 3; k++) {
            mesh->indices[3 * mesh->triangle_count + k] = fuzz_byte(bytes) % mesh->vertex_count;
        }
        mesh->triangle_count++;
    }
}

#endif
