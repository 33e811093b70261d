// SPDX-License-Identifier: Apache-2.0
// What gpu.h's objects are made of; for the files of this folder that implement it.
#ifndef CLAST_VULKAN_DEVICE_H
#define CLAST_VULKAN_DEVICE_H

#include "base/library.h"
#include "vulkan/gpu.h"

enum {
    GPU_COMMANDS = 2,       // that may be under way
    GPU_QUERIES = 1024,     // of times, of one clast_gpu_commands
    GPU_TEXTURES = 1 << 14, // most
};

// Features that clast needs, by the struct of Vulkan that has them.
#define CLAST_GPU_FEATURE_LIST(X) \
    X(core, shaderInt64, "64-bit integers in shaders") \
    X(v12, bufferDeviceAddress, "buffer device addresses") \
    X(v12, shaderBufferInt64Atomics, "64-bit atomics on buffers") \
    X(v12, scalarBlockLayout, "scalar block layout") \
    X(v12, timelineSemaphore, "timeline semaphores") \
    X(v12, runtimeDescriptorArray, "runtime descriptor arrays") \
    X(v12, descriptorBindingPartiallyBound, "partially bound descriptors") \
    X(v12, descriptorBindingSampledImageUpdateAfterBind, "updates of bound descriptors") \
    X(v12, shaderSampledImageArrayNonUniformIndexing, "non-uniform indexing of textures") \
    X(v12, vulkanMemoryModel, "the Vulkan memory model") \
    X(v12, vulkanMemoryModelDeviceScope, "the Vulkan memory model at device scope") \
    X(v13, synchronization2, "synchronization2") \
    X(v13, maintenance4, "maintenance4")

// Used where there are some.
#define CLAST_GPU_OPTION_LIST(X) \
    X(core, textureCompressionBC) \
    X(v13, subgroupSizeControl) \
    X(v13, computeFullSubgroups)

typedef struct clast_gpu_feature_chain {
    VkPhysicalDeviceFeatures2 all;
    VkPhysicalDeviceVulkan12Features v12;
    VkPhysicalDeviceVulkan13Features v13;
    VkPhysicalDeviceAccelerationStructureFeaturesKHR structures;
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipelines;
} clast_gpu_feature_chain;
#define CLAST_GPU_FEATURE_core(chain) (chain).all.features
#define CLAST_GPU_FEATURE_v12(chain) (chain).v12
#define CLAST_GPU_FEATURE_v13(chain) (chain).v13

// Links an empty chain; the extensions' structs are part of it where `ray_tracing`.
void clast_gpu_link_features(clast_gpu_feature_chain *chain, bool ray_tracing);

// A range of a block that is free.
typedef struct clast_gpu_range {
    uint64_t offset, bytes;
} clast_gpu_range;

// Memory that buffers, or pictures, share.
typedef struct clast_gpu_block {
    struct clast_gpu_block *next;
    VkDeviceMemory memory;
    VkBuffer buffer; // over all of it; null for pictures
    uint64_t address;
    uint8_t *mapped;
    uint64_t bytes;
    uint32_t type; // of memory
    clast_gpu_memory use;
    bool is_for_pictures;
    clast_gpu_range *ranges; // free, in order, apart from each other
    size_t range_count, range_capacity;
} clast_gpu_block;

typedef struct clast_gpu_picture {
    VkImage image;
    VkImageView view;
    clast_gpu_block *block;
    uint64_t offset, bytes;
    uint32_t width, height, levels;
} clast_gpu_picture;

// What is freed when the device has passed a ticket.
typedef struct clast_gpu_leaving {
    uint64_t ticket;
    clast_gpu_block *block;
    uint64_t offset, bytes;
    VkImage image;
    VkImageView view;
    VkAccelerationStructureKHR structure; // the driver's; null: none, else there is no block
    uint32_t number;                      // of the texture; CLAST_NONE for others
} clast_gpu_leaving;

typedef struct clast_gpu_kernel {
    VkPipeline pipeline; // null: this place is free
    clast_shader shader;
    uint64_t code_hash; // of the file that it was made of (kernel.c)
    uint32_t subgroup;
    uint32_t constant_count;
    uint32_t constants[CLAST_GPU_CONSTANTS];
} clast_gpu_kernel;

// A read that is delivered when the commands are done.
typedef struct clast_gpu_delivery {
    void *to;
    const void *from;
    uint64_t bytes;
} clast_gpu_delivery;

// A part of a staging buffer that copies pass through.
typedef struct clast_gpu_staging {
    clast_gpu_buffer buffer;
    uint64_t used;
} clast_gpu_staging;

struct clast_gpu_commands {
    clast_gpu *gpu;
    VkCommandPool pool; // null: the buffer is the caller's
    VkCommandBuffer buffer;
    VkQueryPool queries;
    bool is_recording, is_labelled;
    clast_status status;
    uint64_t ticket;               // of the last submission
    clast_gpu_staging *staging[2]; // by direction: to the device, from the device
    size_t staging_count[2], staging_capacity[2];
    uint64_t staged[2]; // bytes since it was last emptied
    clast_gpu_delivery *deliveries;
    size_t delivery_count, delivery_capacity;
    const char *passes[GPU_QUERIES];
    uint32_t pass_count;
};

struct clast_gpu {
    clast_context *context;
    clast_gpu_desc desc;
    char *shader_folder; // null: there is none
    clast_gpu_features features;
    clast_library *library;
    clast_vulkan_functions vk;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;
    uint32_t queue_family;
    bool is_foreign; // instance and device are the caller's
    bool is_lost;
    bool has_compression; // of pictures, in blocks
    uint32_t validation_messages;
    VkPhysicalDeviceMemoryProperties memory;
    uint64_t largest_allocation;
    clast_gpu_block *blocks;
    uint64_t block_bytes, buffer_bytes, buffer_bytes_peak;
    clast_gpu_leaving *leaving;
    size_t leaving_count, leaving_capacity;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool descriptor_pool;
    VkDescriptorSet set;
    VkPipelineLayout pipeline_layout;
    VkPipelineCache pipeline_cache;
    clast_gpu_kernel *kernels; // a table of a power of two of places
    size_t kernel_count, kernel_capacity;
    VkSemaphore timeline;
    uint64_t ticket;  // of the last submission
    uint64_t reached; // known to be done
    clast_gpu_commands commands[GPU_COMMANDS];
    uint32_t next_commands;
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t time_count;
    clast_gpu_picture *pictures; // by number
    size_t picture_count, picture_capacity;
    uint32_t *free_numbers;
    size_t free_number_count, free_number_capacity;
};

// Records what a function of Vulkan failed with. `what` says what was tried.
clast_status clast_gpu_fail(clast_gpu *gpu, VkResult result, const char *what);

// loader.c
clast_status clast_gpu_open_loader(clast_gpu *gpu);
clast_status clast_gpu_load_instance_functions(clast_gpu *gpu);
clast_status clast_gpu_load_device_functions(clast_gpu *gpu);

// memory.c
// Of a block for pictures, where `pictures`; `types` is a bit for each type of memory that will do.
clast_status clast_gpu_take(clast_gpu *gpu, clast_gpu_memory use, bool pictures, uint32_t types, uint64_t bytes,
                            uint64_t alignment, const char *name, clast_gpu_block **block, uint64_t *offset);
// Frees what left and the device is done with; all, where it is idle.
void clast_gpu_let_go(clast_gpu *gpu);
void clast_gpu_leave(clast_gpu *gpu, const clast_gpu_leaving *leaving);
void clast_gpu_free_blocks(clast_gpu *gpu);

// kernel.c
clast_status clast_gpu_make_layouts(clast_gpu *gpu);
clast_status clast_gpu_open_cache(clast_gpu *gpu);
void clast_gpu_keep_cache(clast_gpu *gpu);
void clast_gpu_free_kernels(clast_gpu *gpu);
// The code of a shader, taken over by the device, and a number that tells files of it apart.
clast_status clast_gpu_open_shader(clast_gpu *gpu, clast_shader shader, VkShaderModule *module, uint64_t *hash);
clast_status clast_gpu_kernel_of(clast_gpu *gpu, const clast_gpu_call *call, VkPipeline *pipeline);

// commands.c
clast_status clast_gpu_make_commands(clast_gpu *gpu);
void clast_gpu_free_commands(clast_gpu *gpu);
clast_status clast_gpu_update_reached(clast_gpu *gpu);
// Submits what was recorded, waits, delivers, and goes on recording: for copies that are larger than what may be staged.
void clast_gpu_flush(clast_gpu_commands *commands);
void clast_gpu_deliver(clast_gpu_commands *commands);

// transfer.c: room for `bytes` on the way to the device (0) or from it (1)
bool clast_gpu_stage(clast_gpu_commands *commands, int direction, uint64_t bytes, clast_gpu_buffer *piece);
void clast_gpu_free_staging(clast_gpu_commands *commands);

// texture.c
void clast_gpu_free_textures(clast_gpu *gpu);
void clast_gpu_free_picture(clast_gpu *gpu, const clast_gpu_leaving *leaving);

#endif
