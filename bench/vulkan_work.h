// SPDX-License-Identifier: Apache-2.0
// What bench_vulkan measures on, as it lies in a device's memory: surfaces of grids and of patterns whose vertices the device
// evaluates anew each time, and copies of a mesh in clusters of which every vertex moves.
#ifndef CLAST_BENCH_VULKAN_WORK_H
#define CLAST_BENCH_VULKAN_WORK_H

#include "bench.h"
#include "clast/clast.h"
#include "shared/cluster.h"
#include "vulkan/driver.h"
#include "vulkan/rays.h"
#include "vulkan/topologies.h"
#include "vulkan/trees.h"

typedef enum vulkan_kind { VULKAN_GRIDS, VULKAN_PATTERNS, VULKAN_MESH } vulkan_kind;
typedef enum vulkan_surface { VULKAN_TERRAIN, VULKAN_SPHERE } vulkan_surface; // as in shaders/bench/surface.glsl

typedef struct vulkan_device {
    clast_context *context;
    clast_gpu *gpu;
    clast_gpu_trees *trees;
    clast_driver *driver; // null: the device has none
} vulkan_device;

// What the driver makes of the same triangles.
typedef struct vulkan_peer {
    clast_driver_triangles triangles;
    clast_gpu_buffer indices, places; // places: driver_triangle() of each triangle
    clast_driver_structure fast_build, fast_trace;
    clast_driver_scratch scratch;
    clast_driver_scene scene;
    bool is_there;
} vulkan_peer;

typedef struct vulkan_work {
    vulkan_device *device;
    const char *name;
    vulkan_kind kind;
    vulkan_surface surface;
    uint32_t cluster_count, triangle_count, vertex_count;
    uint32_t logarithms[2]; // of cells along the sides
    float time;
    clast_template_set *set;
    clast_topologies topologies;
    clast_gpu_buffer inputs, places, firsts, vertices, clusters, boxes, nodes, bounds;
    clast_gpu_buffer kept, kept_nodes; // of a tree that is fitted anew
    uint64_t tree_bytes;               // of the nodes of the tree in stored order, or of a mesh's that is fitted
    clast_gpu_buffer shape;            // of meshes: a tree of the processor's, which is kept and fitted
    clast_gpu_buffer rotations, patterns, weights;                       // of patterns
    clast_gpu_buffer templates, pairs, rest, positions, numbers, faults; // of meshes: of all copies
    uint32_t copies, side, rest_count;
    clast_gpu_buffer placement, top, scene, scratch;
    vulkan_peer peer;
    float eye[3], target[3], field; // a camera
} vulkan_work;

// Ends the program where a call failed.
void vulkan_check(const vulkan_device *device, clast_status status);
void vulkan_allocate(const vulkan_device *device, uint64_t bytes, const char *name, clast_gpu_buffer *buffer);
clast_gpu_commands *vulkan_begin(const vulkan_device *device);
void vulkan_finish(const vulkan_device *device, clast_gpu_commands *commands);
// Allocates and fills a buffer.
void vulkan_upload(const vulkan_device *device, const void *data, uint64_t bytes, const char *name,
                   clast_gpu_buffer *buffer);

// Makes about so many triangles, and all that rays need.
void vulkan_work_make(vulkan_device *device, vulkan_kind kind, vulkan_surface surface, uint32_t triangles,
                      vulkan_work *work);
void vulkan_work_free(vulkan_work *work);

// Commands, each with barriers before and after it where it needs some.
void vulkan_fill(const vulkan_work *work, clast_gpu_commands *commands); // vertices alone; of meshes, the shared ones
void vulkan_fit(const vulkan_work *work, clast_gpu_commands *commands);  // and boxes, in one go; meshes gather theirs
// The tree that rays go through. Where the order is kept that of a mesh is fitted: built with care for the mesh at rest.
void vulkan_tree(const vulkan_work *work, clast_gpu_commands *commands, clast_gpu_tree_order order);
void vulkan_tree_keep(const vulkan_work *work, clast_gpu_commands *commands); // a sorted tree, beside the other
void vulkan_tree_refit(const vulkan_work *work, clast_gpu_commands *commands);

// vulkan_peer.c: the driver's structures; `is_there` is false where it cannot have them.
void vulkan_peer_make(vulkan_work *work);
void vulkan_peer_free(vulkan_work *work);
void vulkan_peer_build(vulkan_work *work, clast_gpu_commands *commands, clast_driver_build build);
void vulkan_peer_update(vulkan_work *work, clast_gpu_commands *commands);
uint64_t vulkan_peer_bytes(const vulkan_work *work, clast_driver_build build); // with vertices and indices

// vulkan_mesh.c: the mesh of VULKAN_MESH.
void vulkan_mesh_make(vulkan_work *work, uint32_t triangles);

#endif
