// SPDX-License-Identifier: Apache-2.0
// A frame on a device: the second implementation of frame/backend.h. Passes that are cheap, or that other passes wait for, stay
// with the processor: animate, which instances are seen, the search for a rate, tables of lights. What is counted, emitted,
// filled and fitted, and all trees, are the device's; only sums come back.
//
// What kernels are handed is shared/device.h's. Each unit has buffers of its own, so that what does not change stays where it is;
// a pass is one dispatch for each kind of source, over all units that change (clast_device_span).
#ifndef CLAST_VULKAN_FRAME_H
#define CLAST_VULKAN_FRAME_H

#include "frame/backend.h"
#include "vulkan/mirror.h"
#include "vulkan/topologies.h"

typedef struct clast_vulkan_frame clast_vulkan_frame;

// What the backend keeps of a frame: for clast_frame.device. Freed before the frame's templates are.
clast_status clast_vulkan_frame_create(clast_gpu *gpu, clast_vulkan_frame **device);
void clast_vulkan_frame_destroy(clast_vulkan_frame *device);
// From the next frame on, pictures' rays go through the driver's own acceleration structures (vulkan/driver.h), and clast's trees are
// not built: for a frame that was just created. UNSUPPORTED where the device was not opened with ray_tracing, or has none.
clast_status clast_vulkan_frame_use_driver(clast_vulkan_frame *device);

clast_gpu *clast_vulkan_frame_gpu(const clast_vulkan_frame *device);
// Where the clast_device_frame lies, once the passes up to CLAST_PASS_TLAS have run.
uint64_t clast_vulkan_frame_address(const clast_vulkan_frame *device);
// Where its clast_device_scene lies, which rays are traced through (vulkan/rays.h); 0 as above, and with the driver's structures.
uint64_t clast_vulkan_frame_scene(const clast_vulkan_frame *device);
// Bytes of the device's memory that the frame takes.
uint64_t clast_vulkan_frame_bytes(const clast_vulkan_frame *device);

// Copies a unit's records, or words, or vertices from the device, as long as the frame stays as it is: for tests and for
// what looks at single hits. Positions of resident records are the source's.
clast_status clast_vulkan_frame_read_records(clast_frame *frame, size_t unit, size_t first, size_t count,
                                             clast_cluster_record *records);
clast_status clast_vulkan_frame_read_words(clast_frame *frame, size_t unit, size_t first, size_t count,
                                           uint32_t *words);
clast_status clast_vulkan_frame_read_vertices(clast_frame *frame, size_t unit, size_t first, size_t count,
                                              packed3 *vertices);

// The passes up to CLAST_PASS_LIGHTS.
#define CLAST_FRAME_VULKAN_PASSES(X) \
    X(CLAST_PASS_ANIMATE, clast_vulkan_animate) \
    X(CLAST_PASS_CLASSIFY, clast_cpu_classify) \
    X(CLAST_PASS_OCCLUDE, clast_vulkan_occlude) \
    X(CLAST_PASS_COUNT, clast_vulkan_count) \
    X(CLAST_PASS_FIT, clast_cpu_fit) \
    X(CLAST_PASS_EMIT, clast_vulkan_emit) \
    X(CLAST_PASS_FILL, clast_vulkan_fill) \
    X(CLAST_PASS_REFIT, clast_vulkan_refit) \
    X(CLAST_PASS_BLAS, clast_vulkan_blas) \
    X(CLAST_PASS_TLAS, clast_vulkan_tlas) \
    X(CLAST_PASS_LIGHTS, clast_cpu_lights)

CLAST_FRAME_VULKAN_PASSES(CLAST_DECLARE_PASS)
clast_status clast_vulkan_count_units(clast_frame *frame, clast_unit_tally *tallies, size_t count, float rate,
                                      bool keep);
clast_status clast_vulkan_trace_coarse(clast_frame *frame, const clast_ray *rays, size_t count, clast_hit *hits);
void clast_vulkan_forget(clast_frame *frame);

#endif
