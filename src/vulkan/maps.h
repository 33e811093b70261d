// SPDX-License-Identifier: Apache-2.0
// Where instances are, as a device's placements tell it.
#ifndef CLAST_VULKAN_MAPS_H
#define CLAST_VULKAN_MAPS_H

#include "accel/structures.h"
#include "shared/device.h"

enum { CLAST_MAPS_TOGETHER = 64 };

// Maps of up to CLAST_MAPS_TOGETHER transforms, inverted in double precision by the processor's own kernel (accel/place.kernel.c).
// Units and numbers of instances are left zero.
void clast_make_maps(clast_place_kernel place, const clast_transform *const *transforms, size_t count,
                     clast_device_map *maps);

#endif
