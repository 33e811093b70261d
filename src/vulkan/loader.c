// SPDX-License-Identifier: Apache-2.0
// The Vulkan loader, opened at run time.
#include "vulkan/device.h"

#if defined(__APPLE__)
static const char *const loader_names[] = {"libvulkan.1.dylib", "libvulkan.dylib", "libMoltenVK.dylib"};
#else
static const char *const loader_names[] = {"libvulkan.so.1", "libvulkan.so"};
#endif

clast_status clast_gpu_open_loader(clast_gpu *gpu)
{
    for (size_t i = 0; i < sizeof loader_names / sizeof *loader_names && gpu->library == NULL; i++) {
        gpu->library = clast_library_open(loader_names[i]);
    }
    if (gpu->library == NULL) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE,
                          "vulkan: there is no loader (%s) on this machine; it comes with the package libvulkan1",
                          loader_names[0]);
    }
    gpu->vk.vkGetInstanceProcAddr = (PFN_vkGetInstanceProcAddr)clast_library_find(gpu->library,
                                                                                  "vkGetInstanceProcAddr");
    if (gpu->vk.vkGetInstanceProcAddr == NULL) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: the loader has no vkGetInstanceProcAddr");
    }
#define FIND(name) gpu->vk.name = (PFN_##name)gpu->vk.vkGetInstanceProcAddr(NULL, #name);
    CLAST_VULKAN_LOADER_FUNCTIONS(FIND)
#undef FIND
    if (gpu->vk.vkCreateInstance == NULL || gpu->vk.vkEnumerateInstanceVersion == NULL) {
        return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: the loader is older than Vulkan 1.1");
    }
    return CLAST_OK;
}

static clast_status missing(clast_gpu *gpu, const char *name)
{
    return clast_fail(gpu->context, CLAST_ERROR_DEVICE, "vulkan: the driver has no function %s", name);
}

clast_status clast_gpu_load_instance_functions(clast_gpu *gpu)
{
    const char *absent = NULL;
#define FIND(name) \
    gpu->vk.name = (PFN_##name)gpu->vk.vkGetInstanceProcAddr(gpu->instance, #name); \
    absent = gpu->vk.name == NULL ? #name : absent;
    CLAST_VULKAN_INSTANCE_FUNCTIONS(FIND)
#undef FIND
    // these are functions of the instance where its layers serve them, and absent without the extension
    if (gpu->features.labels || gpu->desc.validate) {
#define FIND(name) gpu->vk.name = (PFN_##name)gpu->vk.vkGetInstanceProcAddr(gpu->instance, #name);
        CLAST_VULKAN_DEBUG_FUNCTIONS(FIND)
#undef FIND
    }
    return absent != NULL ? missing(gpu, absent) : CLAST_OK;
}

clast_status clast_gpu_load_device_functions(clast_gpu *gpu)
{
    const char *absent = NULL;
#define FIND(name) \
    gpu->vk.name = (PFN_##name)gpu->vk.vkGetDeviceProcAddr(gpu->device, #name); \
    absent = gpu->vk.name == NULL ? #name : absent;
    CLAST_VULKAN_DEVICE_FUNCTIONS(FIND)
    if (gpu->features.ray_tracing) {
        CLAST_VULKAN_RAY_TRACING_FUNCTIONS(FIND)
    }
#undef FIND
    return absent != NULL ? missing(gpu, absent) : CLAST_OK;
}
