/* SPDX-License-Identifier: Apache-2.0
 *
 * Cluster acceleration structures on a Vulkan device, within an engine's own frame: it hands in its device, and command buffers
 * to record into. Vertices, rays and hits lie in its buffers, by their addresses.
 *
 *   clast_vulkan         the device in use
 *   clast_vulkan_blas    clusters of templates (clast/accel.h), fitted to vertices, and a tree over them
 *   clast_vulkan_tlas    a tree over instances of these; rays go here
 *
 * When vertices move: clast_vulkan_blas_build, then clast_vulkan_tlas_build, then rays. Hits are those of clast_trace_closest, to the
 * bit, but for their steps.
 *
 * Calls that record only record: the caller submits, to the queue that it named or another of its family. Objects must stay until what
 * was recorded with them has run. Each such call has a barrier before what it records and within; what follows it and is not clast's
 * needs one, from the stages of compute shaders and of transfers. One call at a time for one clast_vulkan and all that it made.
 */
#ifndef CLAST_VULKAN_H
#define CLAST_VULKAN_H

#include <vulkan/vulkan_core.h>

#include "clast/accel.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ----------------------------------------------------------------------------------------------------------- device */

typedef struct clast_vulkan clast_vulkan;

/** What the caller made, and keeps: a Vulkan 1.3 device with the features that clast_vulkan_ask_features sets. */
typedef struct clast_vulkan_desc {
    PFN_vkGetInstanceProcAddr get_instance_function;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue; /**< can compute; used by calls that say so, while the caller does not */
    uint32_t queue_family;
    uint64_t memory_limit;    /**< bytes of device memory that may be held; 0 is no limit */
    const char *cache_folder; /**< where compiled kernels are kept for the next run; null is nowhere */
} clast_vulkan_desc;

/** Sets the features that clast needs in structs for vkCreateDevice, and leaves the others as they are. */
CLAST_API void clast_vulkan_ask_features(VkPhysicalDeviceFeatures *core, VkPhysicalDeviceVulkan12Features *v12,
                                         VkPhysicalDeviceVulkan13Features *v13);
/** Begins to use a device. DEVICE, with a text that tells what it lacks, where it will not do; INVALID_ARGUMENT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_vulkan_create(clast_context *context, const clast_vulkan_desc *desc,
                                           clast_vulkan **vulkan);
/** Waits until the device is idle. All objects made with it must have been destroyed. */
CLAST_API void clast_vulkan_destroy(clast_vulkan *vulkan);
/** Tells that all that was recorded so far has run: memory that objects gave up since, as they were destroyed or grew, is free for
 *  others. */
CLAST_API void clast_vulkan_collect(clast_vulkan *vulkan);
/** Bytes of device memory that buffers of clast hold. */
CLAST_API uint64_t clast_vulkan_bytes(const clast_vulkan *vulkan);

/* ------------------------------------------------------------------------------------------------------------- BLAS */

typedef struct clast_vulkan_blas clast_vulkan_blas;

/** A cluster: a template, and where its vertices begin in a buffer, counted in vertices. */
typedef struct clast_vulkan_cluster {
    uint32_t template_number;
    uint32_t first_vertex;
} clast_vulkan_cluster;

/** Makes room for clusters, and uploads their topologies: it submits to the queue, and waits. Hits tell clusters by their
 *  number in the list. The set may be destroyed afterwards. Errors: INVALID_ARGUMENT, LIMIT, OUT_OF_MEMORY, DEVICE. */
CLAST_API clast_status clast_vulkan_blas_create(clast_vulkan *vulkan, const clast_template_set *set,
                                                const clast_vulkan_cluster *clusters, size_t count,
                                                clast_vulkan_blas **blas);
CLAST_API void clast_vulkan_blas_destroy(clast_vulkan_blas *blas);

/** How the tree is built. */
typedef enum clast_vulkan_order {
    CLAST_VULKAN_ORDER_ANY, /**< whatever the order of the clusters */
    CLAST_VULKAN_ORDER_STORED, /**< clusters that follow each other in the list are close to each other: takes a tenth of the time */
} clast_vulkan_order;

/** Where vertices are, 3 floats each, by addresses in the device's memory. */
typedef struct clast_vulkan_vertices {
    VkDeviceAddress vertices;  /**< of the clusters; rays read them, so they stay until the next build */
    VkDeviceAddress positions; /**< 0, or vertices that clusters share, which are copied to `vertices` first: */
    VkDeviceAddress numbers;   /**< vertex i is position numbers[i], of 32 bits */
    uint32_t position_count;   /**< a cluster that has a number not below it stays as it was */
} clast_vulkan_vertices;

/** Records fitting all clusters to their vertices, and building the tree over them. */
CLAST_API clast_status clast_vulkan_blas_build(clast_vulkan_blas *blas, VkCommandBuffer commands,
                                               const clast_vulkan_vertices *vertices, clast_vulkan_order order);

/* ------------------------------------------------------------------------------------------------------------- TLAS */

typedef struct clast_vulkan_tlas clast_vulkan_tlas;

/** An instance. */
typedef struct clast_vulkan_instance {
    const clast_vulkan_blas *blas; /**< null: nothing there */
    float transform[3][4]; /**< object to world, rows; one that cannot be inverted makes the instance invisible */
    uint32_t id;           /**< what hits report; not CLAST_NONE */
} clast_vulkan_instance;

/** Makes room for so many instances. */
CLAST_API clast_status clast_vulkan_tlas_create(clast_vulkan *vulkan, size_t most_instances, clast_vulkan_tlas **tlas);
CLAST_API void clast_vulkan_tlas_destroy(clast_vulkan_tlas *tlas);
/** Records building the tree over instances, which are copied into the command buffer. */
CLAST_API clast_status clast_vulkan_tlas_build(clast_vulkan_tlas *tlas, VkCommandBuffer commands,
                                               const clast_vulkan_instance *instances, size_t count);

/** How rays that follow each other in a buffer go. */
typedef enum clast_vulkan_rays_kind {
    CLAST_VULKAN_RAYS_COHERENT,   /**< much the same way: as those of a camera, or towards a light */
    CLAST_VULKAN_RAYS_INCOHERENT, /**< any way */
} clast_vulkan_rays_kind;

/** Records tracing rays (clast_ray each, at `rays`) to their nearest hits (clast_hit each, at `hits`). Addresses are multiples
 *  of 4. */
CLAST_API clast_status clast_vulkan_trace_closest(clast_vulkan_tlas *tlas, VkCommandBuffer commands,
                                                  VkDeviceAddress rays, size_t count, clast_vulkan_rays_kind kind,
                                                  VkDeviceAddress hits);
/** The same for whether each ray hits anything: 32 bits each, 1 or 0. */
CLAST_API clast_status clast_vulkan_trace_any(clast_vulkan_tlas *tlas, VkCommandBuffer commands, VkDeviceAddress rays,
                                              size_t count, clast_vulkan_rays_kind kind, VkDeviceAddress occluded);

#ifdef __cplusplus
}
#endif

#endif
