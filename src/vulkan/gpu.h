// SPDX-License-Identifier: Apache-2.0
// A Vulkan device in use, and what passes need of it: memory, kernels, commands. It knows nothing of geometry.
//
// Kernels are compute shaders of the folder shaders/, compiled by the build and embedded; the build makes the list of them
// (clast_shader). What they work on they reach by addresses in buffers, which they are handed as push constants; only
// textures have descriptors. Failures while commands are recorded are kept, and told where they are submitted: recording
// needs no checks.
#ifndef CLAST_VULKAN_GPU_H
#define CLAST_VULKAN_GPU_H

#include "base/context.h"
#include "vulkan/functions.h"
#include "vulkan_shaders.h" // made by the build: enum clast_shader, CLAST_SHADER_COUNT_

// ---------------------------------------------------------------------------------------------------------- devices

typedef struct clast_gpu clast_gpu;

// For tests: tells how many bytes a buffer of the device's gets, which needs so many. Null: as many, or more where it grows.
typedef struct clast_gpu_size_hook {
    uint64_t (*size)(void *user, const char *name, uint64_t bytes);
    void *user;
} clast_gpu_size_hook;

typedef struct clast_gpu_desc {
    const char *device; // part of the name of the device that is wanted; null is any
    bool software;      // drivers that are programs on the processor count too
    bool hardware;      // other devices count
    bool validate;      // use the validation layer, where there is one: what it says goes to the log as warnings
    bool ray_tracing;   // use the driver's acceleration structures and ray tracing pipelines, where there are some
    uint32_t subgroup;  // wanted width of subgroups; 0 is the device's own choice
    clast_gpu_size_hook size_hook;
    uint64_t memory_limit; // bytes of the device's memory that may be held; 0 is no limit
    const char
        *shader_folder; // whose files are used in place of kernels of their names (clast_shader_code); null is none
    const char *cache_folder; // where compiled pipelines are kept for the next run; null is nowhere
} clast_gpu_desc;

// What a device can do that not all can.
typedef struct clast_gpu_features {
    char name[256], driver[256];
    uint32_t subgroup_least, subgroup_most;
    bool subgroup_control; // a kernel can ask for its width
    bool is_software, is_discrete, is_integrated;
    bool ray_tracing;       // asked for, and there
    bool labels;            // tools can be told names
    float timestamp_period; // nanoseconds of a step of the clock; 0: it has none
    uint64_t memory;        // bytes of the largest heap of the device's own
    uint32_t textures;      // most at a time
} clast_gpu_features;

// Opens the best device that has what clast needs: discrete before integrated before others. The log tells for each device
// that is passed over what it lacks. DEVICE, with a text that tells why, where there is none: no loader, no device, or
// none that will do.
clast_status clast_gpu_create(clast_context *context, const clast_gpu_desc *desc, clast_gpu **gpu);
// Waits until the device is idle. All buffers must have been freed.
void clast_gpu_destroy(clast_gpu *gpu);
const clast_gpu_features *clast_gpu_features_of(const clast_gpu *gpu);
// Forgets kernels whose files have changed in the meantime. Nothing without clast_gpu_desc.shader_folder.
clast_status clast_gpu_renew_kernels(clast_gpu *gpu);
clast_context *clast_gpu_context(const clast_gpu *gpu);

// A device, with a queue that can compute, that the caller made, who keeps it. It must have been made with the features that
// clast_gpu_ask_features sets. What is freed stays till clast_gpu_collect.
typedef struct clast_gpu_foreign {
    PFN_vkGetInstanceProcAddr get_instance_function;
    VkInstance instance;
    VkPhysicalDevice physical_device;
    VkDevice device;
    VkQueue queue;
    uint32_t queue_family;
} clast_gpu_foreign;
clast_status clast_gpu_adopt(clast_context *context, const clast_gpu_desc *desc, const clast_gpu_foreign *foreign,
                             clast_gpu **gpu);

// Sets the features that clast needs, and leaves the others.
void clast_gpu_ask_features(VkPhysicalDeviceFeatures *core, VkPhysicalDeviceVulkan12Features *v12,
                            VkPhysicalDeviceVulkan13Features *v13);
// On a device of the caller: all commands recorded so far have run, so that what was freed can go.
void clast_gpu_collect(clast_gpu *gpu);

// How many messages the validation layer has had about errors and hazards.
uint32_t clast_gpu_validation_messages(const clast_gpu *gpu);

// ----------------------------------------------------------------------------------------------------------- memory

typedef enum clast_gpu_memory {
    CLAST_GPU_DEVICE,   // the device's own
    CLAST_GPU_UPLOAD,   // written by the processor in order, read by the device
    CLAST_GPU_READBACK, // written by the device, read by the processor
} clast_gpu_memory;

// A piece of memory. All zero is an empty one, which can be freed. Addresses are aligned to 256 bytes.
typedef struct clast_gpu_buffer {
    uint64_t bytes; // as asked for, rounded up to 16
    uint64_t address;
    void *mapped; // null for the device's own
    VkBuffer handle;
    uint64_t offset; // in `handle`
    struct clast_gpu_block *block;
} clast_gpu_buffer;

// `name` is for tools and errors. OUT_OF_MEMORY, with a text that names the buffer and its size. Contents are undefined.
clast_status clast_gpu_allocate(clast_gpu *gpu, clast_gpu_memory memory, uint64_t bytes, const char *name,
                                clast_gpu_buffer *buffer);
// Frees, once the device has done what was submitted so far; `buffer` is empty at once.
void clast_gpu_free(clast_gpu *gpu, clast_gpu_buffer *buffer);
// Makes a buffer hold at least so many bytes; where it must grow, it grows by a half at least, and its contents are lost.
clast_status clast_gpu_reserve(clast_gpu *gpu, clast_gpu_memory memory, uint64_t bytes, const char *name,
                               clast_gpu_buffer *buffer);
// Held now by buffers, and the most there was.
uint64_t clast_gpu_bytes(const clast_gpu *gpu);
uint64_t clast_gpu_bytes_peak(const clast_gpu *gpu);

// --------------------------------------------------------------------------------------------------------- commands

typedef struct clast_gpu_commands clast_gpu_commands;

enum { CLAST_GPU_CONSTANTS = 8, CLAST_GPU_PUSH_BYTES = 128 };

// A run of a kernel. Groups are laid out in two dimensions where there are many: kernels ask linear_group() of
// shaders/gpu.glsl, and return where it is beyond what there is to do.
typedef struct clast_gpu_call {
    clast_shader shader;
    uint32_t constants
        [CLAST_GPU_CONSTANTS]; // of specialisation, by constant_id; the shader's own default beyond `constant_count`
    uint32_t constant_count;
    const void *push; // its push constants
    uint32_t push_bytes;
    uint64_t groups;
    const clast_gpu_buffer *indirect; // null, or where three numbers of groups lie, in place of `groups`
    uint64_t indirect_offset;
    uint32_t subgroup; // width that it needs, all of them full; 0 is any
} clast_gpu_call;

// Begins to record: two of them can be under way, a further one waits for the first. Errors come by clast_gpu_submit.
clast_status clast_gpu_begin(clast_gpu *gpu, clast_gpu_commands **commands);
// Records into a command buffer of the caller, who submits it and keeps what it names until it has run. It is ended by
// clast_gpu_release, which gives the first error.
clast_status clast_gpu_begin_foreign(clast_gpu *gpu, VkCommandBuffer buffer, clast_gpu_commands **commands);
clast_status clast_gpu_release(clast_gpu_commands *commands);

// Names what follows, for tools and for clast_gpu_passes, up to the next name. `name` must be a literal.
void clast_gpu_pass(clast_gpu_commands *commands, const char *name);
void clast_gpu_run(clast_gpu_commands *commands, const clast_gpu_call *call);
// What follows sees what kernels and copies before have written.
void clast_gpu_barrier(clast_gpu_commands *commands);
// Copies from the processor's memory, at once; the device has it for what follows a barrier. Any size.
void clast_gpu_write(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, const void *data,
                     uint64_t bytes);
// Copies to the processor's memory once the commands are done (clast_gpu_wait), so `to` must stay until then. Has its own barrier
// before it. Any size.
void clast_gpu_read(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, void *to,
                    uint64_t bytes);
void clast_gpu_copy(clast_gpu_commands *commands, const clast_gpu_buffer *to, uint64_t to_offset,
                    const clast_gpu_buffer *from, uint64_t from_offset, uint64_t bytes);
// `value` for every 32 bits; offset and bytes are multiples of 4.
void clast_gpu_fill(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, uint64_t bytes,
                    uint32_t value);
// Keeps an error, as if recording had failed: for what calls these functions.
void clast_gpu_note(clast_gpu_commands *commands, clast_status status);
VkCommandBuffer clast_gpu_command_buffer(const clast_gpu_commands *commands);
clast_gpu *clast_gpu_of(const clast_gpu_commands *commands);

// Submits, or gives the first error of recording. The commands are no longer the caller's: `*ticket` is, for clast_gpu_wait.
clast_status clast_gpu_submit(clast_gpu_commands *commands, uint64_t *ticket);
// Waits until what was submitted up to a ticket is done and its reads are there. DEVICE where the device was lost.
clast_status clast_gpu_wait(clast_gpu *gpu, uint64_t ticket);
// Both.
clast_status clast_gpu_finish(clast_gpu_commands *commands);

// How long the passes of what was waited for last took on the device, in the order of their first appearance; passes of
// one name add up.
typedef struct clast_gpu_time {
    const char *pass;
    double milliseconds;
} clast_gpu_time;
enum { CLAST_GPU_TIMES = 64 };
uint32_t clast_gpu_passes(const clast_gpu *gpu, clast_gpu_time times[CLAST_GPU_TIMES]);

// --------------------------------------------------------------------------------------------------------- textures

// Pictures with levels that kernels read by number: textures[] of shaders/gpu.glsl, texel by texel. Filtering is the
// kernels' own (shared/texture_filter.h).
typedef struct clast_gpu_texture {
    uint32_t number; // CLAST_NONE: none
} clast_gpu_texture;

typedef struct clast_gpu_texture_desc {
    VkFormat format;
    uint32_t width, height, levels;
    const char *name;
} clast_gpu_texture_desc;

// UNSUPPORTED where the device cannot read the format; LIMIT where there are too many, or one is too large.
clast_status clast_gpu_texture_create(clast_gpu *gpu, const clast_gpu_texture_desc *desc, clast_gpu_texture *texture);
// Freed as buffers are. What is read of it from then on is undefined.
void clast_gpu_texture_destroy(clast_gpu *gpu, clast_gpu_texture *texture);
// Fills a level: rows one after the other, without gaps. Begins a level's life: all of it must be written.
void clast_gpu_texture_write(clast_gpu_commands *commands, clast_gpu_texture texture, uint32_t level, const void *data,
                             uint64_t bytes);
bool clast_gpu_can_read(const clast_gpu *gpu, VkFormat format);

#endif
