// SPDX-License-Identifier: Apache-2.0
// The triangles of a frame's units as meshes of arrays: what export writes.
#ifndef CLAST_FRAME_EXTRACT_H
#define CLAST_FRAME_EXTRACT_H

#include "frame/frame.h"

// A mesh whose arrays are blocks of clast_allocate, freed by clast_extraction_free. Corners share a vertex where their positions are
// the same bits and the attributes alike.
typedef struct clast_extraction {
    clast_mesh mesh; // triangle_materials where there are several
    void *blocks[8];
    uint32_t block_count;
} clast_extraction;

// Extracts a unit that the frame has made, as it is traced. `welded` gives each position one vertex: normals are averaged, texture
// coordinates and colours left out. Reports progress as "extract": triangles, from `done` on, of `total`.
// Errors: OUT_OF_MEMORY, LIMIT, CANCELLED.
clast_status clast_frame_extract(const clast_frame *frame, const clast_frame_unit *unit, bool welded, uint64_t done,
                                 uint64_t total, clast_extraction *extraction);
void clast_extraction_free(clast_context *context, clast_extraction *extraction);

#endif
