// SPDX-License-Identifier: Apache-2.0
// Choosing a device, and opening it.
#include "vulkan/device.h"

#include <stdio.h>
#include <string.h>

#include "clast/version.h"

enum {
    DEVICES_MOST = 64,
    REASON_BYTES = 512,
    SHARED_BYTES_LEAST = 32768,
    GROUP_LEAST = 256, // invocations
};

static const VkSubgroupFeatureFlags subgroup_operations =
    VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT |
    VK_SUBGROUP_FEATURE_ARITHMETIC_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT | VK_SUBGROUP_FEATURE_CLUSTERED_BIT;

static const char *const ray_tracing_extensions[] = {
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
};
enum { RAY_TRACING_EXTENSIONS = sizeof ray_tracing_extensions / sizeof *ray_tracing_extensions };

// ----------------------------------------------------------------------------------------------------------- errors

static const char *result_text(VkResult result)
{
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY: return "the driver ran out of memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "the device ran out of memory";
    case VK_ERROR_INITIALIZATION_FAILED: return "the driver could not start";
    case VK_ERROR_DEVICE_LOST: return "the device was lost: its driver stopped it";
    case VK_ERROR_LAYER_NOT_PRESENT: return "a layer is not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT: return "an extension is not present";
    case VK_ERROR_FEATURE_NOT_PRESENT: return "a feature is not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER: return "no driver was found";
    case VK_ERROR_TOO_MANY_OBJECTS: return "there are too many objects";
    default: return NULL;
    }
}

clast_status clast_gpu_fail(clast_gpu *gpu, VkResult result, const char *what)
{
    gpu->is_lost = gpu->is_lost || result == VK_ERROR_DEVICE_LOST;
    bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY ||
                  result == VK_ERROR_TOO_MANY_OBJECTS;
    clast_status status = memory ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_ERROR_DEVICE;
    const char *text = result_text(result);
    if (text != NULL) {
        return clast_fail(gpu->context, status, "vulkan: %s: %s", what, text);
    }
    return clast_fail(gpu->context, status, "vulkan: %s: error %d", what, (int)result);
}

static VKAPI_ATTR VkBool32 VKAPI_CALL take_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT types,
                                                   const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    (void)severity;
    clast_gpu *gpu = user;
    if ((types & (VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT)) !=
        0) {
        gpu->validation_messages++;
        clast_log(gpu->context, CLAST_LOG_WARNING, "vulkan validation: %s", data->pMessage);
    }
    return VK_FALSE;
}

uint32_t clast_gpu_validation_messages(const clast_gpu *gpu)
{
    return gpu->validation_messages;
}

// --------------------------------------------------------------------------------------------------------- instance

static const char validation_layer[] = "VK_LAYER_KHRONOS_validation";

static bool has_layer(clast_gpu *gpu, const char *name)
{
    VkLayerProperties layers[64];
    uint32_t count = 64;
    VkResult result = gpu->vk.vkEnumerateInstanceLayerProperties(&count, layers);
    for (uint32_t i = 0; (result == VK_SUCCESS || result == VK_INCOMPLETE) && i < count; i++) {
        if (strcmp(layers[i].layerName, name) == 0) {
            return true;
        }
    }
    return false;
}

static bool instance_has(clast_gpu *gpu, const char *layer, const char *name)
{
    VkExtensionProperties extensions[128];
    uint32_t count = 128;
    VkResult result = gpu->vk.vkEnumerateInstanceExtensionProperties(layer, &count, extensions);
    for (uint32_t i = 0; (result == VK_SUCCESS || result == VK_INCOMPLETE) && i < count; i++) {
        if (strcmp(extensions[i].extensionName, name) == 0) {
            return true;
        }
    }
    return false;
}

static clast_status create_instance(clast_gpu *gpu)
{
    uint32_t version = 0;
    if (gpu->vk.vkEnumerateInstanceVersion(&version) != VK_SUCCESS || version < VK_API_VERSION_1_3) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: the loader knows Vulkan %u.%u; expected 1.3",
                          VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version));
    }
    gpu->desc.validate = gpu->desc.validate && has_layer(gpu, validation_layer);
    gpu->features.labels = instance_has(gpu, NULL, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    const char *extensions[2];
    uint32_t extension_count = 0;
    if (gpu->features.labels || gpu->desc.validate) {
        extensions[extension_count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    }
    const char *layers[1] = {validation_layer};
    const VkValidationFeatureEnableEXT checks[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT validation = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                          .enabledValidationFeatureCount = 1,
                                          .pEnabledValidationFeatures = checks};
    bool synchronisation = gpu->desc.validate &&
                           instance_has(gpu, validation_layer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    if (synchronisation) {
        extensions[extension_count++] = VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME;
    }
    VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .pEngineName = "clast",
        .engineVersion = VK_MAKE_API_VERSION(0, CLAST_VERSION_MAJOR, CLAST_VERSION_MINOR, CLAST_VERSION_PATCH),
        .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                   .pNext = synchronisation ? &validation : NULL,
                                   .pApplicationInfo = &application,
                                   .enabledLayerCount = gpu->desc.validate ? 1 : 0,
                                   .ppEnabledLayerNames = layers,
                                   .enabledExtensionCount = extension_count,
                                   .ppEnabledExtensionNames = extensions};
    VkResult result = gpu->vk.vkCreateInstance(&create, NULL, &gpu->instance);
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "making an instance");
}

static clast_status listen(clast_gpu *gpu)
{
    if (!gpu->desc.validate || gpu->vk.vkCreateDebugUtilsMessengerEXT == NULL) {
        return CLAST_OK;
    }
    VkDebugUtilsMessengerCreateInfoEXT create = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                                 .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                                                    VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                                                 .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                                                 .pfnUserCallback = take_message,
                                                 .pUserData = gpu};
    VkResult result = gpu->vk.vkCreateDebugUtilsMessengerEXT(gpu->instance, &create, NULL, &gpu->messenger);
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "listening to the validation layer");
}

// ---------------------------------------------------------------------------------------------------------- choosing

void clast_gpu_link_features(clast_gpu_feature_chain *chain, bool ray_tracing)
{
    *chain = (clast_gpu_feature_chain){
        .all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &chain->v12},
        .v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &chain->v13},
        .v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                .pNext = ray_tracing ? &chain->structures : NULL},
        .structures = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR,
                       .pNext = &chain->pipelines},
        .pipelines = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR},
    };
}

// What a device that may be chosen is like.
typedef struct candidate {
    VkPhysicalDevice device;
    VkPhysicalDeviceProperties properties;
    VkPhysicalDeviceSubgroupSizeControlProperties subgroup;
    VkPhysicalDeviceMaintenance3Properties maintenance;
    VkPhysicalDeviceVulkan12Properties v12;
    VkPhysicalDeviceSubgroupProperties operations;
    uint32_t queue_family, timestamp_bits;
    bool has_ray_tracing;
    clast_gpu_feature_chain features;
    char reason[REASON_BYTES]; // why it will not do; empty where it will
} candidate;

static void lacks(candidate *c, const char *what)
{
    size_t length = strlen(c->reason);
    snprintf(c->reason + length, sizeof c->reason - length, "%s%s", length == 0 ? "it lacks " : ", ", what);
}

static bool device_has(const VkExtensionProperties *extensions, uint32_t count, const char *name)
{
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(extensions[i].extensionName, name) == 0) {
            return true;
        }
    }
    return false;
}

static void look_at_extensions(clast_gpu *gpu, candidate *c)
{
    uint32_t count = 0;
    if (gpu->vk.vkEnumerateDeviceExtensionProperties(c->device, NULL, &count, NULL) != VK_SUCCESS || count == 0) {
        return;
    }
    VkExtensionProperties *extensions = clast_allocate(gpu->context, count, sizeof *extensions);
    if (extensions == NULL ||
        gpu->vk.vkEnumerateDeviceExtensionProperties(c->device, NULL, &count, extensions) != VK_SUCCESS) {
        clast_free(gpu->context, extensions);
        return;
    }
    c->has_ray_tracing = true;
    for (int i = 0; i < RAY_TRACING_EXTENSIONS; i++) {
        c->has_ray_tracing = c->has_ray_tracing && device_has(extensions, count, ray_tracing_extensions[i]);
    }
    clast_free(gpu->context, extensions);
}

static void look_at_queues(clast_gpu *gpu, candidate *c)
{
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    gpu->vk.vkGetPhysicalDeviceQueueFamilyProperties(c->device, &count, families);
    c->queue_family = CLAST_NONE;
    for (uint32_t i = 0; i < count && c->queue_family == CLAST_NONE; i++) {
        if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0 && families[i].queueCount != 0) {
            c->queue_family = i;
            c->timestamp_bits = families[i].timestampValidBits;
        }
    }
    if (c->queue_family == CLAST_NONE) {
        lacks(c, "a queue that computes");
    }
}

static void look_at_limits(candidate *c)
{
    const VkPhysicalDeviceLimits *limits = &c->properties.limits;
    if ((c->operations.supportedOperations & subgroup_operations) != subgroup_operations ||
        (c->operations.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) == 0) {
        lacks(c, "subgroup operations (vote, ballot, arithmetic, shuffle, clustered)");
    }
    if (limits->maxComputeSharedMemorySize < SHARED_BYTES_LEAST) {
        lacks(c, "32 KiB of shared memory for a work group");
    }
    if (limits->maxComputeWorkGroupInvocations < GROUP_LEAST || limits->maxComputeWorkGroupSize[0] < GROUP_LEAST) {
        lacks(c, "work groups of 256 invocations");
    }
    if (limits->maxPushConstantsSize < CLAST_GPU_PUSH_BYTES) {
        lacks(c, "128 bytes of push constants");
    }
}

static void look_at_features(clast_gpu *gpu, candidate *c)
{
    bool asks = gpu->desc.ray_tracing && c->has_ray_tracing;
    clast_gpu_feature_chain there;
    clast_gpu_link_features(&there, asks);
    gpu->vk.vkGetPhysicalDeviceFeatures2(c->device, &there.all);
    clast_gpu_link_features(&c->features, asks);
#define NEED(part, name, text) \
    if (CLAST_GPU_FEATURE_##part(there).name != VK_TRUE) { \
        lacks(c, text); \
    } \
    CLAST_GPU_FEATURE_##part(c->features).name = VK_TRUE;
    CLAST_GPU_FEATURE_LIST(NEED)
#undef NEED
#define WISH(part, name) CLAST_GPU_FEATURE_##part(c->features).name = CLAST_GPU_FEATURE_##part(there).name;
    CLAST_GPU_OPTION_LIST(WISH)
#undef WISH
    c->has_ray_tracing = asks && there.structures.accelerationStructure == VK_TRUE &&
                         there.pipelines.rayTracingPipeline == VK_TRUE;
    c->features.structures.accelerationStructure = VK_TRUE;
    c->features.pipelines.rayTracingPipeline = VK_TRUE;
    c->features.v13.pNext = c->has_ray_tracing ? &c->features.structures : NULL;
}

static void look_at(clast_gpu *gpu, VkPhysicalDevice device, candidate *c)
{
    *c = (candidate){.device = device};
    c->maintenance.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES;
    c->v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES;
    c->subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_PROPERTIES;
    c->operations.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    c->maintenance.pNext = &c->v12;
    c->v12.pNext = &c->operations;
    c->operations.pNext = &c->subgroup;
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    gpu->vk.vkGetPhysicalDeviceProperties2(device, &properties);
    c->properties = properties.properties;
    if (c->properties.apiVersion < VK_API_VERSION_1_3) {
        snprintf(c->reason, sizeof c->reason, "it has Vulkan %u.%u; expected 1.3",
                 VK_API_VERSION_MAJOR(c->properties.apiVersion), VK_API_VERSION_MINOR(c->properties.apiVersion));
        return;
    }
    properties.pNext = &c->maintenance;
    gpu->vk.vkGetPhysicalDeviceProperties2(device, &properties);
    look_at_extensions(gpu, c);
    look_at_queues(gpu, c);
    look_at_limits(c);
    look_at_features(gpu, c);
    bool software = c->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    if (c->reason[0] == '\0' && !(software ? gpu->desc.software : gpu->desc.hardware)) {
        snprintf(c->reason, sizeof c->reason, "it is %s, which was not asked for",
                 software ? "a program on the processor" : "no program on the processor");
    }
    if (gpu->desc.device != NULL && strstr(c->properties.deviceName, gpu->desc.device) == NULL) {
        snprintf(c->reason, sizeof c->reason, "another was asked for: '%s'", gpu->desc.device);
    }
}

void clast_gpu_ask_features(VkPhysicalDeviceFeatures *core, VkPhysicalDeviceVulkan12Features *v12,
                            VkPhysicalDeviceVulkan13Features *v13)
{
    clast_gpu_feature_chain wanted = {.all.features = *core, .v12 = *v12, .v13 = *v13};
#define ASK(part, name, text) CLAST_GPU_FEATURE_##part(wanted).name = VK_TRUE;
    CLAST_GPU_FEATURE_LIST(ASK)
#undef ASK
    *core = wanted.all.features;
    *v12 = wanted.v12;
    *v13 = wanted.v13;
}

static int worth(const candidate *c)
{
    switch (c->properties.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 5;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 4;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 3;
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return 1;
    default: return 2;
    }
}

// The first of the best.
static clast_status choose(clast_gpu *gpu, candidate *best)
{
    VkPhysicalDevice devices[DEVICES_MOST];
    uint32_t count = DEVICES_MOST;
    VkResult result = gpu->vk.vkEnumeratePhysicalDevices(gpu->instance, &count, devices);
    if (result != VK_SUCCESS && result != VK_INCOMPLETE) {
        return clast_gpu_fail(gpu, result, "looking for devices");
    }
    if (count == 0) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: there is no device on this machine");
    }
    bool found = false;
    char last[sizeof best->reason + 300] = "";
    for (uint32_t i = 0; i < count; i++) {
        candidate c;
        look_at(gpu, devices[i], &c);
        if (c.reason[0] != '\0') {
            snprintf(last, sizeof last, "%s: %s", c.properties.deviceName, c.reason);
            clast_log(gpu->context, CLAST_LOG_INFORMATION, "vulkan: passed over %s", last);
        } else if (!found || worth(&c) > worth(best)) {
            *best = c;
            found = true;
        }
    }
    if (!found) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: none of %u device%s will do: %s", count,
                          count == 1 ? "" : "s", last);
    }
    return CLAST_OK;
}

static void take_features(clast_gpu *gpu, const candidate *c)
{
    clast_gpu_features *to = &gpu->features;
    const VkPhysicalDeviceProperties *properties = &c->properties;
    snprintf(to->name, sizeof to->name, "%s", properties->deviceName);
    snprintf(to->driver, sizeof to->driver, "%.100s %.150s", c->v12.driverName, c->v12.driverInfo);
    to->subgroup_control = c->features.v13.subgroupSizeControl == VK_TRUE &&
                           (c->subgroup.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
    to->subgroup_least = to->subgroup_control ? c->subgroup.minSubgroupSize : c->operations.subgroupSize;
    to->subgroup_most = to->subgroup_control ? c->subgroup.maxSubgroupSize : c->operations.subgroupSize;
    to->is_software = properties->deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    to->is_discrete = properties->deviceType == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    to->is_integrated = properties->deviceType == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU;
    to->ray_tracing = c->has_ray_tracing;
    to->timestamp_period = c->timestamp_bits != 0 ? properties->limits.timestampPeriod : 0.0f;
    uint32_t textures = c->v12.maxPerStageDescriptorUpdateAfterBindSampledImages;
    uint32_t in_set = c->v12.maxDescriptorSetUpdateAfterBindSampledImages;
    textures = textures < in_set ? textures : in_set;
    to->textures = textures < GPU_TEXTURES ? textures : GPU_TEXTURES;
    gpu->largest_allocation = c->maintenance.maxMemoryAllocationSize;
    gpu->has_compression = c->features.all.features.textureCompressionBC == VK_TRUE;
    VkPhysicalDeviceMemoryProperties2 memory = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2};
    gpu->vk.vkGetPhysicalDeviceMemoryProperties2(gpu->physical_device, &memory);
    gpu->memory = memory.memoryProperties;
    for (uint32_t i = 0; i < gpu->memory.memoryHeapCount; i++) {
        bool own = (gpu->memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0;
        uint64_t size = own ? gpu->memory.memoryHeaps[i].size : 0;
        to->memory = size > to->memory ? size : to->memory;
    }
}

static clast_status open_device(clast_gpu *gpu, candidate *c)
{
    gpu->physical_device = c->device;
    gpu->queue_family = c->queue_family;
    // the copy of the chain must point to its own members
    clast_gpu_feature_chain *chain = &c->features;
    chain->all.pNext = &chain->v12;
    chain->v12.pNext = &chain->v13;
    chain->v13.pNext = c->has_ray_tracing ? &chain->structures : NULL;
    chain->structures.pNext = &chain->pipelines;
    take_features(gpu, c);
    const char *extensions[RAY_TRACING_EXTENSIONS];
    uint32_t extension_count = 0;
    for (int i = 0; c->has_ray_tracing && i < RAY_TRACING_EXTENSIONS; i++) {
        extensions[extension_count++] = ray_tracing_extensions[i];
    }
    float priority = 1.0f;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = c->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                 .pNext = &chain->all,
                                 .queueCreateInfoCount = 1,
                                 .pQueueCreateInfos = &queue,
                                 .enabledExtensionCount = extension_count,
                                 .ppEnabledExtensionNames = extensions};
    VkResult result = gpu->vk.vkCreateDevice(c->device, &create, NULL, &gpu->device);
    if (result != VK_SUCCESS) {
        gpu->device = VK_NULL_HANDLE;
        return clast_gpu_fail(gpu, result, "opening the device");
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- life

static clast_status make_objects(clast_gpu *gpu)
{
    clast_status status = clast_gpu_load_device_functions(gpu);
    if (status != CLAST_OK) {
        return status;
    }
    if (gpu->queue == VK_NULL_HANDLE) {
        gpu->vk.vkGetDeviceQueue(gpu->device, gpu->queue_family, 0, &gpu->queue);
    }
    status = clast_gpu_make_layouts(gpu);
    if (status == CLAST_OK) {
        status = clast_gpu_open_cache(gpu);
    }
    return status == CLAST_OK ? clast_gpu_make_commands(gpu) : status;
}

static clast_status open_own(clast_gpu *gpu)
{
    clast_status status = clast_gpu_open_loader(gpu);
    if (status == CLAST_OK) {
        status = create_instance(gpu);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_load_instance_functions(gpu);
    }
    if (status == CLAST_OK) {
        status = listen(gpu);
    }
    candidate chosen;
    if (status == CLAST_OK) {
        status = choose(gpu, &chosen);
    }
    if (status == CLAST_OK) {
        status = open_device(gpu, &chosen);
    }
    return status == CLAST_OK ? make_objects(gpu) : status;
}

static clast_status begin_life(clast_context *context, const clast_gpu_desc *desc, clast_gpu **gpu)
{
    *gpu = NULL;
    clast_gpu *made = clast_allocate_zeroed(context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->context = context;
    made->desc = *desc;
    made->desc.shader_folder = NULL; // the copy is the device's own
    if (desc->shader_folder != NULL) {
        made->shader_folder = clast_copy_text(context, desc->shader_folder);
        if (made->shader_folder == NULL) {
            clast_free(context, made);
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    *gpu = made;
    return CLAST_OK;
}

static clast_status end_creation(clast_gpu *made, clast_status status, clast_gpu **gpu)
{
    if (status != CLAST_OK) {
        clast_gpu_destroy(made);
        return status;
    }
    clast_log(made->context, CLAST_LOG_INFORMATION, "vulkan: using %s (%s)", made->features.name,
              made->features.driver);
    *gpu = made;
    return CLAST_OK;
}

clast_status clast_gpu_create(clast_context *context, const clast_gpu_desc *desc, clast_gpu **gpu)
{
    *gpu = NULL;
    clast_gpu *made;
    clast_status status = begin_life(context, desc, &made);
    return status == CLAST_OK ? end_creation(made, open_own(made), gpu) : status;
}

static clast_status open_foreign(clast_gpu *gpu, const clast_gpu_foreign *foreign)
{
    gpu->vk.vkGetInstanceProcAddr = foreign->get_instance_function;
    gpu->instance = foreign->instance;
    gpu->desc.validate = false;
    clast_status status = clast_gpu_load_instance_functions(gpu);
    if (status != CLAST_OK) {
        return status;
    }
    candidate c;
    gpu->desc.software = gpu->desc.hardware = true;
    gpu->desc.device = NULL;
    look_at(gpu, foreign->physical_device, &c);
    if (c.reason[0] != '\0') {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: %s will not do: %s", c.properties.deviceName,
                          c.reason);
    }
    gpu->physical_device = foreign->physical_device;
    gpu->device = foreign->device;
    gpu->queue = foreign->queue;
    gpu->queue_family = foreign->queue_family;
    take_features(gpu, &c);
    return make_objects(gpu);
}

clast_status clast_gpu_adopt(clast_context *context, const clast_gpu_desc *desc, const clast_gpu_foreign *foreign,
                             clast_gpu **gpu)
{
    *gpu = NULL;
    clast_gpu *made;
    clast_status status = begin_life(context, desc, &made);
    if (status != CLAST_OK) {
        return status;
    }
    made->is_foreign = true;
    return end_creation(made, open_foreign(made, foreign), gpu);
}

void clast_gpu_destroy(clast_gpu *gpu)
{
    if (gpu == NULL) {
        return;
    }
    if (gpu->device != VK_NULL_HANDLE && gpu->vk.vkDeviceWaitIdle != NULL) {
        gpu->vk.vkDeviceWaitIdle(gpu->device);
        gpu->reached = gpu->ticket;
        clast_gpu_free_commands(gpu);
        clast_gpu_free_textures(gpu);
        clast_gpu_collect(gpu);
        clast_gpu_free_blocks(gpu);
        clast_gpu_keep_cache(gpu);
        clast_gpu_free_kernels(gpu);
    }
    if (!gpu->is_foreign) {
        if (gpu->device != VK_NULL_HANDLE && gpu->vk.vkDestroyDevice != NULL) {
            gpu->vk.vkDestroyDevice(gpu->device, NULL);
        }
        if (gpu->messenger != VK_NULL_HANDLE) {
            gpu->vk.vkDestroyDebugUtilsMessengerEXT(gpu->instance, gpu->messenger, NULL);
        }
        if (gpu->instance != VK_NULL_HANDLE && gpu->vk.vkDestroyInstance != NULL) {
            gpu->vk.vkDestroyInstance(gpu->instance, NULL);
        }
        clast_library_close(gpu->library);
    }
    clast_free(gpu->context, gpu->leaving);
    clast_free(gpu->context, gpu->shader_folder);
    clast_free(gpu->context, gpu);
}

const clast_gpu_features *clast_gpu_features_of(const clast_gpu *gpu)
{
    return &gpu->features;
}

clast_context *clast_gpu_context(const clast_gpu *gpu)
{
    return gpu->context;
}
