// SPDX-License-Identifier: Apache-2.0
// What the files of the driver's structures share.
#ifndef CLAST_VULKAN_DRIVER_STATE_H
#define CLAST_VULKAN_DRIVER_STATE_H

#include "vulkan/device.h"
#include "vulkan/driver.h"

VkPhysicalDeviceAccelerationStructurePropertiesKHR clast_driver_limits(clast_gpu *gpu);

// Makes a structure that takes so many instances, in place of what `structure` was where that is not enough.
clast_status clast_driver_reserve_top(clast_gpu *gpu, uint32_t count, clast_driver_build build,
                                      clast_driver_structure *structure);
// Builds it over instances, as Vulkan lays them out, at an address.
void clast_driver_build_top(clast_gpu_commands *commands, const clast_driver_structure *structure, uint64_t instances,
                            uint32_t count, clast_driver_scratch *scratch);

#endif
