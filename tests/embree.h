// SPDX-License-Identifier: Apache-2.0
// Embree 3 or 4, whichever is installed, behind the few calls that tests and benchmarks need.
#ifndef CLAST_TESTS_EMBREE_H
#define CLAST_TESTS_EMBREE_H

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <stdbool.h>
#include <stdint.h>

#include "clast/accel.h"

// A scene of one mesh; `positions` must have a float to spare at the end, as Embree reads vertices four floats at a time.
typedef struct embree_mesh {
    RTCScene scene;
    RTCGeometry geometry;
} embree_mesh;

static inline embree_mesh embree_mesh_make(RTCDevice device, const float *positions, uint32_t vertex_count,
                                           const uint32_t *indices, uint32_t triangle_count,
                                           enum RTCBuildQuality quality, enum RTCSceneFlags flags)
{
    embree_mesh m = {rtcNewScene(device), rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE)};
    rtcSetSceneFlags(m.scene, flags);
    rtcSetSceneBuildQuality(m.scene, quality == RTC_BUILD_QUALITY_REFIT ? RTC_BUILD_QUALITY_LOW : quality);
    rtcSetGeometryBuildQuality(m.geometry, quality);
    rtcSetSharedGeometryBuffer(m.geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12,
                               vertex_count);
    rtcSetSharedGeometryBuffer(m.geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12, triangle_count);
    rtcCommitGeometry(m.geometry);
    rtcAttachGeometry(m.scene, m.geometry);
    rtcReleaseGeometry(m.geometry); // the scene keeps it
    rtcCommitScene(m.scene);
    return m;
}

static inline struct RTCRayHit embree_ray(const clast_ray *ray)
{
    struct RTCRayHit r = {
        .ray = {ray->origin[0], ray->origin[1], ray->origin[2], ray->t_min, ray->direction[0], ray->direction[1],
                ray->direction[2], 0, ray->t_max, ~0u, 0, 0},
    };
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.primID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

// The nearest hit, in `hit.geomID`, `hit.primID`, `hit.instID[0]` and `ray.tfar`. `coherent` says that the rays that follow
// each other are alike.
static inline struct RTCRayHit embree_closest(RTCScene scene, const clast_ray *ray, bool coherent)
{
    struct RTCRayHit r = embree_ray(ray);
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect1(scene, &r, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect1(scene, &context, &r);
#endif
    return r;
}

static inline bool embree_any(RTCScene scene, const clast_ray *ray)
{
    struct RTCRayHit r = embree_ray(ray);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &r.ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &r.ray);
#endif
    return r.ray.tfar < 0.0f;
}

#endif
