// SPDX-License-Identifier: Apache-2.0
// Clusters within an engine's own Vulkan frame: its device, its queue, its command buffers. A waving sheet of grids is fitted
// anew in each frame, and rays that look straight down on two instances of it find how high it is.
//
//   cc vulkan_frame.c -o vulkan_frame $(pkg-config --cflags --libs clast) -lvulkan -lm
//   ./vulkan_frame 3
//
// What an engine would compute on the device, vertices and rays, is written by the processor here, into memory that both see.
#include <clast/clast.h>
#include <clast/vulkan.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TILES = 8, QUADS = 8, SIDE = QUADS + 1, CLUSTERS = TILES * TILES, VERTICES = SIDE * SIDE, RAYS = 64 };

// The engine: what it has anyway.
typedef struct engine {
    PFN_vkGetInstanceProcAddr get;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
} engine;

#define INSTANCE_CALL(e, name) ((PFN_##name)(e)->get((e)->instance, #name))
#define DEVICE_CALL(e, name) ((PFN_##name)INSTANCE_CALL(e, vkGetDeviceProcAddr)((e)->device, #name))

static void skip(const char *reason)
{
    printf("skipped: %s\n", reason);
    exit(77);
}

static void check(VkResult result, const char *what)
{
    if (result != VK_SUCCESS) {
        fprintf(stderr, "%s: Vulkan error %d\n", what, (int)result);
        exit(1);
    }
}

static void check_clast(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

// ----------------------------------------------------------------------------------------------------------- engine

static void open_instance(engine *e)
{
    void *loader = dlopen("libvulkan.so.1", RTLD_NOW);
    if (loader == NULL) {
        skip("no Vulkan loader");
    }
    *(void **)&e->get = dlsym(loader, "vkGetInstanceProcAddr");
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)e->get(NULL, "vkCreateInstance");
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    if (create == NULL || create(&info, NULL, &e->instance) != VK_SUCCESS) {
        skip("no Vulkan instance");
    }
    uint32_t count = 1;
    VkResult result = INSTANCE_CALL(e, vkEnumeratePhysicalDevices)(e->instance, &count, &e->physical_device);
    if ((result != VK_SUCCESS && result != VK_INCOMPLETE) || count == 0) {
        skip("no Vulkan device");
    }
    VkPhysicalDeviceProperties properties;
    INSTANCE_CALL(e, vkGetPhysicalDeviceProperties)(e->physical_device, &properties);
    printf("%s\n", properties.deviceName);
    if (properties.apiVersion < VK_API_VERSION_1_3) {
        skip("the device has no Vulkan 1.3");
    }
}

// With what the engine needs, and what clast asks for.
static void open_device(engine *e)
{
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    INSTANCE_CALL(e, vkGetPhysicalDeviceQueueFamilyProperties)(e->physical_device, &count, families);
    while (e->family < count && (families[e->family].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) {
        e->family++;
    }
    VkPhysicalDeviceVulkan13Features v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                            .pNext = &v13};
    VkPhysicalDeviceFeatures2 core = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v12};
    clast_vulkan_ask_features(&core.features, &v12, &v13);
    float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = e->family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &core,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue};
    if (INSTANCE_CALL(e, vkCreateDevice)(e->physical_device, &info, NULL, &e->device) != VK_SUCCESS) {
        skip("the device lacks features that clast needs");
    }
    DEVICE_CALL(e, vkGetDeviceQueue)(e->device, e->family, 0, &e->queue);
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = e->family};
    check(DEVICE_CALL(e, vkCreateCommandPool)(e->device, &pool, NULL, &e->pool), "making a command pool");
    VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = e->pool, .commandBufferCount = 1};
    check(DEVICE_CALL(e, vkAllocateCommandBuffers)(e->device, &allocate, &e->commands), "making a command buffer");
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(DEVICE_CALL(e, vkCreateFence)(e->device, &fence, NULL, &e->fence), "making a fence");
}

static void close_engine(engine *e)
{
    DEVICE_CALL(e, vkDestroyFence)(e->device, e->fence, NULL);
    DEVICE_CALL(e, vkDestroyCommandPool)(e->device, e->pool, NULL);
    DEVICE_CALL(e, vkDestroyDevice)(e->device, NULL);
    INSTANCE_CALL(e, vkDestroyInstance)(e->instance, NULL);
}

// A buffer in memory that processor and device see.
typedef struct buffer {
    VkBuffer handle;
    VkDeviceMemory memory;
    VkDeviceAddress address;
    void *mapped;
} buffer;

static uint32_t memory_type(const engine *e, uint32_t allowed)
{
    const VkMemoryPropertyFlags wanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties memory;
    INSTANCE_CALL(e, vkGetPhysicalDeviceMemoryProperties)(e->physical_device, &memory);
    uint32_t type = 0;
    while ((allowed >> type & 1) == 0 || (memory.memoryTypes[type].propertyFlags & wanted) != wanted) {
        type++; // Vulkan promises that there is one
    }
    return type;
}

static buffer make_buffer(const engine *e, VkDeviceSize bytes)
{
    buffer b;
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                               .size = bytes,
                               .usage = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
    check(DEVICE_CALL(e, vkCreateBuffer)(e->device, &info, NULL, &b.handle), "making a buffer");
    VkMemoryRequirements needs;
    DEVICE_CALL(e, vkGetBufferMemoryRequirements)(e->device, b.handle, &needs);
    VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                       .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    VkMemoryAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .pNext = &flags,
                                     .allocationSize = needs.size,
                                     .memoryTypeIndex = memory_type(e, needs.memoryTypeBits)};
    check(DEVICE_CALL(e, vkAllocateMemory)(e->device, &allocate, NULL, &b.memory), "allocating memory");
    check(DEVICE_CALL(e, vkBindBufferMemory)(e->device, b.handle, b.memory, 0), "binding memory");
    check(DEVICE_CALL(e, vkMapMemory)(e->device, b.memory, 0, VK_WHOLE_SIZE, 0, &b.mapped), "mapping memory");
    VkBufferDeviceAddressInfo address = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = b.handle};
    b.address = DEVICE_CALL(e, vkGetBufferDeviceAddress)(e->device, &address);
    return b;
}

static void free_buffer(const engine *e, const buffer *b)
{
    DEVICE_CALL(e, vkDestroyBuffer)(e->device, b->handle, NULL);
    DEVICE_CALL(e, vkFreeMemory)(e->device, b->memory, NULL);
}

static void begin_commands(engine *e)
{
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    check(DEVICE_CALL(e, vkResetCommandPool)(e->device, e->pool, 0), "resetting commands");
    check(DEVICE_CALL(e, vkBeginCommandBuffer)(e->commands, &begin), "beginning commands");
}

// Submits, and waits till the processor may read what was written.
static void run_commands(engine *e)
{
    VkMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
        .srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT,
        .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
        .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT,
    };
    VkDependencyInfo dependency = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    DEVICE_CALL(e, vkCmdPipelineBarrier2)(e->commands, &dependency);
    check(DEVICE_CALL(e, vkEndCommandBuffer)(e->commands), "ending commands");
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &e->commands};
    check(DEVICE_CALL(e, vkQueueSubmit)(e->queue, 1, &submit, e->fence), "submitting");
    check(DEVICE_CALL(e, vkWaitForFences)(e->device, 1, &e->fence, VK_TRUE, UINT64_MAX), "waiting");
    check(DEVICE_CALL(e, vkResetFences)(e->device, 1, &e->fence), "resetting a fence");
}

// ------------------------------------------------------------------------------------------------------------ sheet

static float height_at(float x, float z, float time)
{
    return 0.2f * sinf(3.0f * x + time) * cosf(2.0f * z - 0.5f * time);
}

// Tile after tile, in an order that keeps neighbours together.
static void move_vertices(float *vertices, float time)
{
    for (int cluster = 0; cluster < CLUSTERS; cluster++) {
        int column = 0, row = 0;
        for (int bit = 0; bit < 3; bit++) {
            column |= (cluster >> (2 * bit) & 1) << bit;
            row |= (cluster >> (2 * bit + 1) & 1) << bit;
        }
        for (int i = 0; i < VERTICES; i++) {
            float x = (float)(column * QUADS + i % SIDE) / (TILES * QUADS);
            float z = (float)(row * QUADS + i / SIDE) / (TILES * QUADS);
            float *v = vertices + 3 * (cluster * VERTICES + i);
            v[0] = x;
            v[1] = height_at(x, z, time);
            v[2] = z;
        }
    }
}

// Half of them look at the sheet, half at its copy, which is twice as high.
static void aim(clast_ray *rays)
{
    for (int i = 0; i < RAYS; i++) {
        float x = ((float)(i % 8) + 0.37f) / 8.0f, z = ((float)(i / 8) + 0.59f) / 8.0f;
        rays[i] = (clast_ray){
            .origin = {x + (i % 2 == 0 ? 0.0f : 2.0f), 3.0f, z}, .direction = {0.0f, -1.0f, 0.0f}, .t_max = INFINITY};
    }
}

// The largest difference between what rays found and how high the sheet is; or an infinite one.
static float largest_error(const clast_ray *rays, const clast_hit *hits, float time)
{
    float largest = 0.0f;
    for (int i = 0; i < RAYS; i++) {
        float scale = i % 2 == 0 ? 1.0f : 2.0f, x = rays[i].origin[0] - (i % 2 == 0 ? 0.0f : 2.0f);
        if (hits[i].instance != (uint32_t)(i % 2)) {
            return INFINITY;
        }
        float error = fabsf(3.0f - hits[i].t - scale * height_at(x, rays[i].origin[2], time));
        largest = error > largest ? error : largest;
    }
    return largest;
}

// --------------------------------------------------------------------------------------------------------------- use

typedef struct scene {
    clast_context *context;
    clast_vulkan *vulkan;
    clast_vulkan_blas *sheet;
    clast_vulkan_tlas *tlas;
} scene;

static scene make_scene(const engine *e)
{
    scene s;
    check_clast(clast_context_create(NULL, &s.context), NULL);
    clast_vulkan_desc desc = {.get_instance_function = e->get,
                              .instance = e->instance,
                              .physical_device = e->physical_device,
                              .device = e->device,
                              .queue = e->queue,
                              .queue_family = e->family};
    clast_status status = clast_vulkan_create(s.context, &desc, &s.vulkan);
    if (status == CLAST_ERROR_DEVICE) {
        skip(clast_context_error(s.context));
    }
    check_clast(status, s.context);
    clast_template_set *set;
    uint32_t grid;
    clast_vulkan_cluster clusters[CLUSTERS];
    check_clast(clast_template_set_create(s.context, &set), s.context);
    check_clast(clast_template_set_add_grid(set, QUADS, QUADS, &grid), s.context);
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        clusters[i] = (clast_vulkan_cluster){grid, i * VERTICES};
    }
    check_clast(clast_vulkan_blas_create(s.vulkan, set, clusters, CLUSTERS, &s.sheet), s.context);
    clast_template_set_destroy(set);
    check_clast(clast_vulkan_tlas_create(s.vulkan, 2, &s.tlas), s.context);
    return s;
}

static void free_scene(scene *s)
{
    clast_vulkan_tlas_destroy(s->tlas);
    clast_vulkan_blas_destroy(s->sheet);
    clast_vulkan_destroy(s->vulkan);
    clast_context_destroy(s->context);
}

// One frame: structures over vertices as they are, then rays.
static void record_frame(const scene *s, VkCommandBuffer commands, const buffer *vertices, const buffer *rays,
                         const buffer *hits)
{
    const clast_vulkan_instance instances[2] = {
        {s->sheet, {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, 0},
        {s->sheet, {{1, 0, 0, 2}, {0, 2, 0, 0}, {0, 0, 1, 0}}, 1},
    };
    check_clast(clast_vulkan_blas_build(s->sheet, commands, &(clast_vulkan_vertices){.vertices = vertices->address},
                                        CLAST_VULKAN_ORDER_STORED),
                s->context);
    check_clast(clast_vulkan_tlas_build(s->tlas, commands, instances, 2), s->context);
    check_clast(
        clast_vulkan_trace_closest(s->tlas, commands, rays->address, RAYS, CLAST_VULKAN_RAYS_COHERENT, hits->address),
        s->context);
}

int main(int count, char **arguments)
{
    int frames = count > 1 ? atoi(arguments[1]) : 3;
    engine e = {0};
    open_instance(&e);
    open_device(&e);
    scene s = make_scene(&e);
    buffer vertices = make_buffer(&e, sizeof(float) * 3 * CLUSTERS * VERTICES);
    buffer rays = make_buffer(&e, RAYS * sizeof(clast_ray)), hits = make_buffer(&e, RAYS * sizeof(clast_hit));
    aim(rays.mapped);
    int result = 0;
    for (int frame = 0; frame < frames; frame++) {
        float time = 0.7f * (float)frame;
        move_vertices(vertices.mapped, time);
        begin_commands(&e);
        record_frame(&s, e.commands, &vertices, &rays, &hits);
        run_commands(&e);
        clast_vulkan_collect(s.vulkan);
        float error = largest_error(rays.mapped, hits.mapped, time);
        printf("frame %d: %d triangles, heights within %.2g, %llu bytes on the device\n", frame,
               CLUSTERS * QUADS * QUADS * 2, (double)error, (unsigned long long)clast_vulkan_bytes(s.vulkan));
        result = error < 1e-3f ? result : 1;
    }
    free_scene(&s);
    free_buffer(&e, &vertices);
    free_buffer(&e, &rays);
    free_buffer(&e, &hits);
    close_engine(&e);
    return result;
}
