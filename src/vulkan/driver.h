// SPDX-License-Identifier: Apache-2.0
// The driver's own acceleration structures and ray tracing pipeline (VK_KHR_acceleration_structure,
// VK_KHR_ray_tracing_pipeline): a second way to trace what clusters make, on devices that were opened with
// clast_gpu_desc.ray_tracing and have it.
//
// Hits are those of clast's own rays but where drivers decide otherwise: which of several hits at equal distances is told,
// whether a ray passes that meets a triangle at its edge or edge on, and how coordinates beyond some 1e18 come out. t, u and v
// differ by rounding.
#ifndef CLAST_VULKAN_DRIVER_H
#define CLAST_VULKAN_DRIVER_H

#include "clast/accel.h"
#include "shared/cluster.h"
#include "shared/driver.h"
#include "vulkan/gpu.h"

// ------------------------------------------------------------------------------------------------------- structures

typedef enum clast_driver_build {
    CLAST_DRIVER_FAST_TRACE,
    CLAST_DRIVER_FAST_BUILD,
} clast_driver_build;

// A structure. All zero is an empty one, which can be freed.
typedef struct clast_driver_structure {
    VkAccelerationStructureKHR handle;
    uint64_t address; // 0: there is none
    uint64_t bytes;
    uint64_t build_scratch, update_scratch; // bytes of working memory
    clast_gpu_buffer memory;
    VkBuildAccelerationStructureFlagsKHR flags;
    bool is_top;        // over instances
    bool is_compacted;  // it has no room for another build
    uint32_t triangles; // that it has room for; or instances
    uint32_t vertices;
} clast_driver_structure;

typedef struct clast_driver_structure_desc {
    clast_driver_build build;
    bool updated;                          // it can be fitted to vertices that moved
    bool compacted;                        // clast_driver_compact can make it smaller
    uint32_t triangle_count, vertex_count; // most
} clast_driver_structure_desc;

// Makes a structure, in place of what `structure` was, for triangles that are built later. LIMIT where there are more than the device
// takes.
clast_status clast_driver_reserve(clast_gpu *gpu, const clast_driver_structure_desc *desc,
                                  clast_driver_structure *structure);
void clast_driver_free(clast_gpu *gpu, clast_driver_structure *structure);

// Triangles that lie in the device's memory: positions (packed3), and three numbers of positions for each, 32 bits each.
typedef struct clast_driver_triangles {
    uint64_t positions, indices;
    uint32_t vertex_count, triangle_count;
} clast_driver_triangles;

// What is built, within one call.
typedef struct clast_driver_job {
    clast_driver_structure *structure;
    clast_driver_triangles triangles;
    bool
        update; // the triangles are those of the last build; only their positions are others, and as sound as they were
} clast_driver_job;

// Working memory of builds; all zero is none. Calls that use one and the same need a barrier between them.
typedef struct clast_driver_scratch {
    clast_gpu_buffer buffer;
    uint64_t least; // bytes to make it of; 0 is what the largest job needs: then jobs follow each other
} clast_driver_scratch;

// Builds structures; jobs whose working memory fits together run at the same time. Needs a barrier before it, for what wrote the
// triangles, and one after it.
void clast_driver_build_all(clast_gpu_commands *commands, const clast_driver_job *jobs, size_t count,
                            clast_driver_scratch *scratch);
// Moves a structure that was built to memory that is no larger than it needs. Waits for the device; nothing may be under way.
clast_status clast_driver_compact(clast_gpu *gpu, clast_driver_structure *structure);

// -------------------------------------------------------------------------------------------------------- triangles

// Clusters, as shared/cluster.h has them, that become triangles.
typedef struct clast_driver_clusters {
    uint64_t clusters;  // where the unit's begin
    uint64_t places;    // 32 bits each, in CLUSTER_UNITs from there on; 0: each `space` of these after the one before
    uint64_t firsts;    // the triangles before each cluster, and before the end, 32 bits each; 0: each has `triangles`
    uint64_t positions; // from which all their vertices are multiples of 12 bytes away
    uint32_t count;
    uint32_t space, triangles;
} clast_driver_clusters;

// Writes their indices (3 for each triangle) and which triangle of clast each is (shared/driver.h). A cluster's triangles stand in the
// order of their numbers. Needs barriers before and after. LIMIT is noted where there are too many clusters.
void clast_driver_make_triangles(clast_gpu_commands *commands, const clast_driver_clusters *clusters, uint64_t indices,
                                 uint64_t triangles);

// -------------------------------------------------------------------------------------------------------- instances

typedef struct clast_driver_instance {
    const clast_driver_structure *structure; // null, or empty: nothing is there
    uint64_t positions, indices, triangles;  // what it was made of, and clast_driver_make_triangles made
    clast_transform to_world;                // one that cannot be inverted makes the instance invisible
    uint32_t id;                             // what hits report; not CLAST_NONE
    bool filtered;                           // hits are put to the filter, where there is one
} clast_driver_instance;

// Instances, and the structure over them. All zero is an empty one.
typedef struct clast_driver_scene {
    clast_driver_structure structure;
    clast_gpu_buffer instances, shapes;
    clast_gpu_buffer top; // clast_driver_top: what launches are told
    clast_driver_scratch scratch;
    uint32_t count;
} clast_driver_scene;

// Needs a barrier after it. What cannot be done is noted in the commands: LIMIT where there are too many instances.
void clast_driver_scene_build(clast_gpu_commands *commands, const clast_driver_instance *instances, size_t count,
                              clast_driver_build build, clast_driver_scene *scene);
void clast_driver_scene_free(clast_gpu *gpu, clast_driver_scene *scene);
uint64_t clast_driver_scene_bytes(const clast_driver_scene *scene);

// ------------------------------------------------------------------------------------------------------------- rays

typedef struct clast_driver clast_driver; // a pipeline that traces

enum { CLAST_DRIVER_LAUNCHES_MOST = 8 };

// `filter` is an any-hit shader that decides about hits of filtered instances, or CLAST_SHADER_COUNT_ for none. Launches are ray
// generation shaders that include driver/trace.glsl, as shaders/driver/rays.glsl and shaders/render/trace.glsl do.
typedef struct clast_driver_desc {
    clast_shader filter;
    clast_shader launches[CLAST_DRIVER_LAUNCHES_MOST];
    uint32_t launch_count; // 0: those for rays of buffers (clast_driver_trace)
} clast_driver_desc;

// UNSUPPORTED where the device was not opened for ray tracing, or cannot do it.
clast_status clast_driver_create(clast_gpu *gpu, const clast_driver_desc *desc, clast_driver **driver);
// Waits for the device.
void clast_driver_destroy(clast_driver *driver);

// Runs a launch, by its place in the desc, for each of so many numbers. Needs barriers before and after it.
void clast_driver_launch(clast_gpu_commands *commands, const clast_driver *driver, uint32_t launch, const void *push,
                         uint32_t push_bytes, uint32_t count);

typedef struct clast_driver_rays {
    uint64_t rays;    // clast_ray
    uint64_t results; // of closest hits: clast_hit; of any hits: 1 or 0, 32 bits each
    uint64_t counts;  // 0, or where the number of rays lies, 32 bits: no more than `count`
    uint64_t user;    // the filter's own
    uint32_t count;
    bool any; // whether each ray hits anything, and not the nearest hit
} clast_driver_rays;

// Traces them, by a pipeline without launches of its own. Needs barriers before and after it.
void clast_driver_trace(clast_gpu_commands *commands, const clast_driver *driver, const clast_driver_scene *scene,
                        const clast_driver_rays *rays);

#endif
