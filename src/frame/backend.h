// SPDX-License-Identifier: Apache-2.0
// What a backend does: one function for each pass of the list. The order, the buffers and the timing are frame.c's.
#ifndef CLAST_FRAME_BACKEND_H
#define CLAST_FRAME_BACKEND_H

#include "frame/frame.h"

// Computes a pass from the frame's buffers into the frame's buffers. `target` is the render's, for the passes of
// render/.
typedef clast_status (*clast_pass_function)(clast_frame *frame, void *target);

// What one of some units takes.
typedef struct clast_unit_tally {
    clast_frame_unit *unit;
    clast_frame_need need;
} clast_unit_tally;

// Counts what units need at a rate, except bytes. With `keep`, these are all units that the pass emit may have to write at this
// rate, and what each of their items needs is kept for it.
typedef clast_status (*clast_count_function)(clast_frame *frame, clast_unit_tally *tallies, size_t count, float rate,
                                             bool keep);

// For the pass occlude: makes the scene at the least rate and traces rays through it. Hits name the frame's instances; units that
// can be seen through are not hit.
typedef clast_status (*clast_coarse_function)(clast_frame *frame, const clast_ray *rays, size_t count, clast_hit *hits);

typedef struct clast_backend {
    const char *name;
    clast_pass_function passes[CLAST_PASS_COUNT_];
    clast_count_function count;         // null is the CPU's
    clast_coarse_function coarse;       // likewise
    clast_pass_function measure;        // the noise of a render so far: render/render.h
    clast_pass_function fetch;          // brings a render's sums to its target; null where they are there
    void (*forget)(clast_frame *frame); // a pass failed: what was made is made anew; null where nothing is kept
} clast_backend;

// The CPU's passes up to CLAST_PASS_LIGHTS; render/ adds the rest (clast_render_cpu_backend).
#define CLAST_FRAME_CPU_PASSES(X) \
    X(CLAST_PASS_ANIMATE, clast_cpu_animate) \
    X(CLAST_PASS_CLASSIFY, clast_cpu_classify) \
    X(CLAST_PASS_OCCLUDE, clast_cpu_occlude) \
    X(CLAST_PASS_COUNT, clast_cpu_count) \
    X(CLAST_PASS_FIT, clast_cpu_fit) \
    X(CLAST_PASS_EMIT, clast_cpu_emit) \
    X(CLAST_PASS_FILL, clast_cpu_fill) \
    X(CLAST_PASS_REFIT, clast_cpu_refit) \
    X(CLAST_PASS_BLAS, clast_cpu_blas) \
    X(CLAST_PASS_TLAS, clast_cpu_tlas) \
    X(CLAST_PASS_LIGHTS, clast_cpu_lights)

#define CLAST_DECLARE_PASS(pass, function) clast_status function(clast_frame *frame, void *target);
CLAST_FRAME_CPU_PASSES(CLAST_DECLARE_PASS)

#endif
