// SPDX-License-Identifier: Apache-2.0
// The textures of a device by their numbers (clast_gpu_texture). Read by texelFetch, filtered by shared/texture_filter.h.
#ifndef CLAST_TEXTURES_GLSL
#define CLAST_TEXTURES_GLSL

layout(set = 0, binding = 0) uniform texture2D textures[];

#endif
