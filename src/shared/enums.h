// SPDX-License-Identifier: Apache-2.0
// The enumerations of clast/lists.h that shaders read. C has them from the public headers.
#ifndef CLAST_SHARED_ENUMS_H
#define CLAST_SHARED_ENUMS_H

#include "clast/lists.h"
#include "shared/dialect.h"

ENUM(CLAST_SOURCE_LIST)
ENUM(CLAST_METRIC_LIST)
ENUM(CLAST_ALPHA_LIST)
ENUM(CLAST_WRAP_LIST)
ENUM(CLAST_FILTER_LIST)
ENUM(CLAST_LIGHT_LIST)
ENUM(CLAST_ENVIRONMENT_LIST)
ENUM(CLAST_PROJECTION_LIST)
ENUM(CLAST_TONE_MAP_LIST)
ENUM(CLAST_PIXEL_LIST)
ENUM(CLAST_INTEGRATOR_LIST)
ENUM(CLAST_FIREFLIES_LIST)

#ifndef VULKAN
#include "clast/render.h"
#endif

#endif
