// SPDX-License-Identifier: Apache-2.0
// What every kernel begins with: the extensions that clast needs of a device, arrays by address, and where it is in its
// dispatch. See docs/vulkan.md.
#ifndef CLAST_GPU_GLSL
#define CLAST_GPU_GLSL

#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_clustered : require
#ifdef GPU_RAY_STAGE // the build sets it for stages of ray tracing pipelines
#extension GL_EXT_ray_tracing : require
#endif

#include "shared/dialect.h"
#include "shared/limits.h"
#include "shared/enums.h"
#include "shared/records.h"

// An array of `type` by its address: `floats(address).at[i]`. Addresses are aligned to `alignment` bytes.
#define ARRAY_OF(name, type, alignment) \
    layout(buffer_reference, scalar, buffer_reference_align = alignment) buffer name { type at[]; };

ARRAY_OF(floats, float, 4)
ARRAY_OF(uints, uint, 4)
ARRAY_OF(uint4s, uvec4, 16)
ARRAY_OF(float4s, vec4, 16)
ARRAY_OF(uint64s, uint64_t, 8)
ARRAY_OF(positions3, packed3, 4)
ARRAY_OF(boxes, clast_box, 4)
ARRAY_OF(cluster_records, clast_cluster_record, 4)

uint64_t load_address(packed_address p) { return packUint2x32(p); }
packed_address store_address(uint64_t a) { return unpackUint2x32(a); }

#ifndef GPU_RAY_STAGE // these have no groups
// The number of this work group, however the groups were laid out.
uint linear_group() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
#endif

#endif
