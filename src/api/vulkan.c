// SPDX-License-Identifier: Apache-2.0
// Cluster acceleration structures on a device of the caller's.
#include <string.h>

#include "vulkan/fit.h"
#include "vulkan/maps.h"
#include "vulkan/place.h"
#include "vulkan/rays.h"
#include "vulkan/topologies.h"
#include "vulkan/trees.h"

#include "clast/vulkan.h"

#define COUNT_MOST ((size_t)1 << 26) // of clusters, or instances: TREE_ITEMS_BITS

struct clast_vulkan {
    clast_context *context;
    clast_gpu *gpu;
    clast_gpu_trees *trees;
};

struct clast_vulkan_blas {
    clast_vulkan *vulkan;
    uint32_t count;
    clast_topologies topologies;
    clast_gpu_buffer inputs, places, clusters, boxes, nodes;
    clast_gpu_buffer bounds; // a clast_box, then a number that tells faults
};

struct clast_vulkan_tlas {
    clast_vulkan *vulkan;
    size_t most;
    clast_device_map *maps_made;
    clast_device_tree *trees_made;
    clast_gpu_buffer maps, trees, placements, boxes, nodes, scene, scratch;
};

enum { FAULTS_OFFSET = 32, SCENE_BOX_OFFSET = offsetof(clast_device_scene, box) };

// ----------------------------------------------------------------------------------------------------------- device

void clast_vulkan_ask_features(VkPhysicalDeviceFeatures *core, VkPhysicalDeviceVulkan12Features *v12,
                               VkPhysicalDeviceVulkan13Features *v13)
{
    if (core != NULL && v12 != NULL && v13 != NULL) {
        clast_gpu_ask_features(core, v12, v13);
    }
}

clast_status clast_vulkan_create(clast_context *context, const clast_vulkan_desc *desc, clast_vulkan **vulkan)
{
    if (context == NULL || desc == NULL || vulkan == NULL || desc->get_instance_function == NULL ||
        desc->device == VK_NULL_HANDLE || desc->queue == VK_NULL_HANDLE) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_vulkan *made = clast_allocate_zeroed(context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->context = context;
    clast_gpu_desc wanted = {.memory_limit = desc->memory_limit, .cache_folder = desc->cache_folder};
    clast_gpu_foreign foreign = {
        desc->get_instance_function, desc->instance, desc->physical_device, desc->device, desc->queue,
        desc->queue_family};
    clast_status status = clast_gpu_adopt(context, &wanted, &foreign, &made->gpu);
    status = status == CLAST_OK ? clast_gpu_trees_create(made->gpu, &made->trees) : status;
    if (status != CLAST_OK) {
        clast_vulkan_destroy(made);
        return status;
    }
    *vulkan = made;
    return CLAST_OK;
}

void clast_vulkan_destroy(clast_vulkan *vulkan)
{
    if (vulkan != NULL) {
        if (vulkan->gpu != NULL) {
            clast_gpu_trees_destroy(vulkan->trees);
        }
        clast_gpu_destroy(vulkan->gpu);
        clast_free(vulkan->context, vulkan);
    }
}

void clast_vulkan_collect(clast_vulkan *vulkan)
{
    if (vulkan != NULL) {
        clast_gpu_collect(vulkan->gpu);
    }
}

uint64_t clast_vulkan_bytes(const clast_vulkan *vulkan)
{
    return vulkan != NULL ? clast_gpu_bytes(vulkan->gpu) : 0;
}

static clast_status allocate(clast_gpu *gpu, uint64_t bytes, const char *name, clast_gpu_buffer *buffer)
{
    return clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, bytes, name, buffer);
}

// ------------------------------------------------------------------------------------------------------------- BLAS

// What a device must know of the clusters, and the space that they take.
static clast_status make_inputs(clast_context *context, const clast_template_set *set,
                                const clast_vulkan_cluster *clusters, size_t count, clast_device_cluster *inputs,
                                uint32_t *places, uint64_t *space)
{
    *space = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t number = clusters[i].template_number;
        if (number >= set->count) {
            return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu has template %u; the set has %zu", i,
                              number, set->count);
        }
        inputs[i] = (clast_device_cluster){number, clusters[i].first_vertex, (uint32_t)*space};
        places[i] = (uint32_t)*space;
        *space += cluster_space(triangles_counts(set->templates[number]->triangle_count), false);
        if (*space >= UINT32_C(1) << 31) {
            return clast_fail(context, CLAST_ERROR_LIMIT, "%zu clusters do not fit in a BLAS of a device", count);
        }
    }
    return CLAST_OK;
}

static clast_status allocate_blas(clast_vulkan_blas *blas, uint64_t space)
{
    clast_gpu *gpu = blas->vulkan->gpu;
    const struct {
        clast_gpu_buffer *buffer;
        uint64_t bytes;
        const char *name;
    } all[] = {
        {&blas->inputs, blas->count * sizeof(clast_device_cluster), "clusters to fit"},
        {&blas->places, blas->count * sizeof(uint32_t), "places of clusters"},
        {&blas->clusters, space * CLUSTER_UNIT, "clusters"},
        {&blas->boxes, blas->count * sizeof(clast_box), "boxes of clusters"},
        {&blas->nodes, clast_gpu_tree_bytes(blas->count), "a tree over clusters"},
        {&blas->bounds, FAULTS_OFFSET + sizeof(uint32_t), "bounds of a tree"},
    };
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < sizeof all / sizeof *all && status == CLAST_OK; i++) {
        status = allocate(gpu, all[i].bytes, all[i].name, all[i].buffer);
    }
    return status;
}

// Uploads all, by a submission of its own.
static clast_status fill_blas(clast_vulkan_blas *blas, const clast_template_set *set,
                              const clast_device_cluster *inputs, const uint32_t *places, uint64_t space)
{
    clast_status status = allocate_blas(blas, space);
    clast_gpu_commands *commands;
    status = status == CLAST_OK ? clast_gpu_begin(blas->vulkan->gpu, &commands) : status;
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_note(commands, clast_topologies_update(&blas->topologies, commands, set));
    clast_gpu_write(commands, &blas->inputs, 0, inputs, blas->count * sizeof *inputs);
    clast_gpu_write(commands, &blas->places, 0, places, blas->count * sizeof *places);
    clast_gpu_fill(commands, &blas->clusters, 0, space * CLUSTER_UNIT, 0);
    status = clast_gpu_finish(commands);
    blas->topologies.set = NULL; // no longer looked at
    return status;
}

clast_status clast_vulkan_blas_create(clast_vulkan *vulkan, const clast_template_set *set,
                                      const clast_vulkan_cluster *clusters, size_t count, clast_vulkan_blas **blas)
{
    if (vulkan == NULL || set == NULL || blas == NULL || clusters == NULL || count == 0) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = vulkan->context;
    if (count >= COUNT_MOST) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%zu clusters; less than %zu are possible", count, COUNT_MOST);
    }
    clast_vulkan_blas *made = clast_allocate_zeroed(context, 1, sizeof *made);
    clast_device_cluster *inputs = clast_allocate(context, count, sizeof *inputs);
    uint32_t *places = clast_allocate(context, count, sizeof *places);
    clast_status status = made != NULL && inputs != NULL && places != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    uint64_t space = 0;
    if (status == CLAST_OK) {
        made->vulkan = vulkan;
        made->count = (uint32_t)count;
        status = make_inputs(context, set, clusters, count, inputs, places, &space);
    }
    status = status == CLAST_OK ? fill_blas(made, set, inputs, places, space) : status;
    clast_free(context, inputs);
    clast_free(context, places);
    if (status != CLAST_OK) {
        if (made != NULL && made->vulkan == NULL) {
            clast_free(context, made);
        } else {
            clast_vulkan_blas_destroy(made);
        }
        return status;
    }
    *blas = made;
    return CLAST_OK;
}

void clast_vulkan_blas_destroy(clast_vulkan_blas *blas)
{
    if (blas == NULL) {
        return;
    }
    clast_gpu *gpu = blas->vulkan->gpu;
    clast_gpu_buffer *const all[] = {&blas->inputs, &blas->places, &blas->clusters,
                                     &blas->boxes,  &blas->nodes,  &blas->bounds};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        clast_gpu_free(gpu, all[i]);
    }
    clast_topologies_free(gpu, &blas->topologies);
    clast_free(blas->vulkan->context, blas);
}

clast_status clast_vulkan_blas_build(clast_vulkan_blas *blas, VkCommandBuffer commands,
                                     const clast_vulkan_vertices *vertices, clast_vulkan_order order)
{
    if (blas == NULL || commands == VK_NULL_HANDLE || vertices == NULL || vertices->vertices == 0 ||
        (vertices->positions != 0 && vertices->numbers == 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_gpu_commands *own;
    clast_status status = clast_gpu_begin_foreign(blas->vulkan->gpu, commands, &own);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_barrier(own);
    clast_gpu_fit_clusters(own, &(clast_gpu_fit){.templates = blas->topologies.templates.address,
                                                 .inputs = blas->inputs.address,
                                                 .vertices = vertices->vertices,
                                                 .clusters = blas->clusters.address,
                                                 .boxes = blas->boxes.address,
                                                 .positions = vertices->positions,
                                                 .numbers = vertices->numbers,
                                                 .faults = blas->bounds.address + FAULTS_OFFSET,
                                                 .position_count = vertices->position_count,
                                                 .count = blas->count});
    clast_gpu_tree tree = {.boxes = blas->boxes.address,
                           .items = blas->places.address,
                           .nodes = blas->nodes.address,
                           .bounds = blas->bounds.address,
                           .count = blas->count};
    clast_gpu_note(
        own, clast_gpu_trees_build(blas->vulkan->trees, own, &tree, 1,
                                   order == CLAST_VULKAN_ORDER_STORED ? CLAST_GPU_TREE_STORED : CLAST_GPU_TREE_SORTED));
    return clast_gpu_release(own);
}

// ------------------------------------------------------------------------------------------------------------- TLAS

static clast_status allocate_tlas(clast_vulkan_tlas *tlas)
{
    clast_gpu *gpu = tlas->vulkan->gpu;
    uint64_t most = tlas->most;
    const struct {
        clast_gpu_buffer *buffer;
        uint64_t bytes;
        const char *name;
    } all[] = {
        {&tlas->maps, most * sizeof(clast_device_map), "maps of instances"},
        {&tlas->trees, most * sizeof(clast_device_tree), "trees of instances"},
        {&tlas->placements, most * sizeof(clast_device_placement), "placements"},
        {&tlas->boxes, most * sizeof(clast_box), "boxes of instances"},
        {&tlas->nodes, clast_gpu_tree_bytes((uint32_t)most), "a tree over instances"},
        {&tlas->scene, sizeof(clast_device_scene), "a scene"},
        {&tlas->scratch, CLAST_GPU_RAYS_SCRATCH, "tickets of rays"},
    };
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < sizeof all / sizeof *all && status == CLAST_OK; i++) {
        status = allocate(gpu, all[i].bytes, all[i].name, all[i].buffer);
    }
    tlas->maps_made = clast_allocate(tlas->vulkan->context, most, sizeof *tlas->maps_made);
    tlas->trees_made = clast_allocate(tlas->vulkan->context, most, sizeof *tlas->trees_made);
    return tlas->maps_made != NULL && tlas->trees_made != NULL ? status : CLAST_ERROR_OUT_OF_MEMORY;
}

clast_status clast_vulkan_tlas_create(clast_vulkan *vulkan, size_t most_instances, clast_vulkan_tlas **tlas)
{
    if (vulkan == NULL || tlas == NULL || most_instances == 0) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (most_instances >= COUNT_MOST) {
        return clast_fail(vulkan->context, CLAST_ERROR_LIMIT, "%zu instances; less than %zu are possible",
                          most_instances, COUNT_MOST);
    }
    clast_vulkan_tlas *made = clast_allocate_zeroed(vulkan->context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->vulkan = vulkan;
    made->most = most_instances;
    clast_status status = allocate_tlas(made);
    if (status != CLAST_OK) {
        clast_vulkan_tlas_destroy(made);
        return status;
    }
    *tlas = made;
    return CLAST_OK;
}

void clast_vulkan_tlas_destroy(clast_vulkan_tlas *tlas)
{
    if (tlas == NULL) {
        return;
    }
    clast_gpu_buffer *const all[] = {&tlas->maps,  &tlas->trees, &tlas->placements, &tlas->boxes,
                                     &tlas->nodes, &tlas->scene, &tlas->scratch};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        clast_gpu_free(tlas->vulkan->gpu, all[i]);
    }
    clast_free(tlas->vulkan->context, tlas->maps_made);
    clast_free(tlas->vulkan->context, tlas->trees_made);
    clast_free(tlas->vulkan->context, tlas);
}

// The maps and trees of instances; gives the largest condition of a map.
static float make_instances(clast_vulkan_tlas *tlas, const clast_vulkan_instance *instances, size_t count)
{
    clast_isa isa = clast_context_isa(tlas->vulkan->context);
    float spread = 1.0f;
    for (size_t first = 0; first < count; first += CLAST_MAPS_TOGETHER) {
        const clast_transform *transforms[CLAST_MAPS_TOGETHER];
        clast_transform copies[CLAST_MAPS_TOGETHER];
        size_t some = count - first < CLAST_MAPS_TOGETHER ? count - first : CLAST_MAPS_TOGETHER;
        for (size_t i = 0; i < some; i++) {
            memcpy(&copies[i], instances[first + i].transform, sizeof copies[i]);
            transforms[i] = &copies[i];
        }
        clast_make_maps(clast_accel_kernels_of(isa)->place, transforms, some, tlas->maps_made + first);
    }
    for (size_t i = 0; i < count; i++) {
        const clast_vulkan_blas *blas = instances[i].blas;
        clast_device_map *map = &tlas->maps_made[i];
        map->unit = (uint32_t)i;
        map->id = instances[i].id;
        map->condition = blas != NULL ? map->condition : 0.0f;
        spread = map->condition > spread ? map->condition : spread;
        tlas->trees_made[i] = (clast_device_tree){store_address(blas != NULL ? blas->nodes.address : 0),
                                                  store_address(blas != NULL ? blas->clusters.address : 0),
                                                  store_address(blas != NULL ? blas->bounds.address : 0)};
    }
    return spread;
}

static void record_tlas(clast_vulkan_tlas *tlas, clast_gpu_commands *own, uint32_t count, float spread)
{
    clast_device_scene scene = {.nodes = store_address(tlas->nodes.address),
                                .placements = store_address(tlas->placements.address),
                                .spread = spread,
                                .placement_count = count};
    clast_gpu_barrier(own);
    clast_gpu_write(own, &tlas->scene, 0, &scene, sizeof scene);
    clast_gpu_write(own, &tlas->maps, 0, tlas->maps_made, count * sizeof *tlas->maps_made);
    clast_gpu_write(own, &tlas->trees, 0, tlas->trees_made, count * sizeof *tlas->trees_made);
    clast_gpu_barrier(own);
    clast_gpu_place_instances(own, &(clast_gpu_place){.maps = tlas->maps.address,
                                                      .trees = tlas->trees.address,
                                                      .placements = tlas->placements.address,
                                                      .boxes = tlas->boxes.address,
                                                      .count = count});
    clast_gpu_tree tree = {.boxes = tlas->boxes.address,
                           .nodes = tlas->nodes.address,
                           .bounds = tlas->scene.address + SCENE_BOX_OFFSET,
                           .count = count};
    if (count != 0) {
        clast_gpu_note(own, clast_gpu_trees_build(tlas->vulkan->trees, own, &tree, 1, CLAST_GPU_TREE_SORTED));
    }
}

clast_status clast_vulkan_tlas_build(clast_vulkan_tlas *tlas, VkCommandBuffer commands,
                                     const clast_vulkan_instance *instances, size_t count)
{
    if (tlas == NULL || commands == VK_NULL_HANDLE || (instances == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count > tlas->most) {
        return clast_fail(tlas->vulkan->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%zu instances; the TLAS was made for %zu", count, tlas->most);
    }
    clast_gpu_commands *own;
    clast_status status = clast_gpu_begin_foreign(tlas->vulkan->gpu, commands, &own);
    if (status != CLAST_OK) {
        return status;
    }
    record_tlas(tlas, own, (uint32_t)count, make_instances(tlas, instances, count));
    return clast_gpu_release(own);
}

// ------------------------------------------------------------------------------------------------------------- rays

static clast_status trace(clast_vulkan_tlas *tlas, VkCommandBuffer commands, VkDeviceAddress rays, size_t count,
                          clast_vulkan_rays_kind kind, VkDeviceAddress to, bool any)
{
    if (tlas == NULL || commands == VK_NULL_HANDLE || (count != 0 && (rays == 0 || to == 0))) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count >= UINT32_C(1) << 31) {
        return clast_fail(tlas->vulkan->context, CLAST_ERROR_LIMIT, "%zu rays; less than 2^31 are possible", count);
    }
    clast_gpu_commands *own;
    clast_status status = clast_gpu_begin_foreign(tlas->vulkan->gpu, commands, &own);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_rays call = {.scene = tlas->scene.address,
                           .rays = rays,
                           .to = to,
                           .scratch = &tlas->scratch,
                           .count = (uint32_t)count,
                           .kind = kind == CLAST_VULKAN_RAYS_INCOHERENT ? CLAST_GPU_RAYS_INCOHERENT
                                                                        : CLAST_GPU_RAYS_COHERENT};
    clast_gpu_barrier(own);
    if (any) {
        clast_gpu_trace_any(own, &call);
    } else {
        clast_gpu_trace_closest(own, &call);
    }
    return clast_gpu_release(own);
}

clast_status clast_vulkan_trace_closest(clast_vulkan_tlas *tlas, VkCommandBuffer commands, VkDeviceAddress rays,
                                        size_t count, clast_vulkan_rays_kind kind, VkDeviceAddress hits)
{
    return trace(tlas, commands, rays, count, kind, hits, false);
}

clast_status clast_vulkan_trace_any(clast_vulkan_tlas *tlas, VkCommandBuffer commands, VkDeviceAddress rays,
                                    size_t count, clast_vulkan_rays_kind kind, VkDeviceAddress occluded)
{
    return trace(tlas, commands, rays, count, kind, occluded, true);
}
