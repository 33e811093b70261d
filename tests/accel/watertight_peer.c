// SPDX-License-Identifier: Apache-2.0
// Embree on the same surfaces: its fast mode and its robust one, through instances. Without Embree, no peer.
#include "accel/watertight.h"

#if defined(CLAST_TESTS_WITH_EMBREE)
#include "embree.h"

struct peer {
    RTCDevice device;
};

struct peer_scene {
    embree_mesh meshes[2];
    RTCScene placed[2][WATERTIGHT_MAPS];
    float *positions; // with a float to spare
};

peer *peer_create(void)
{
    peer *p = malloc(sizeof *p);
    p->device = rtcNewDevice("threads=1");
    return p;
}

void peer_destroy(peer *p)
{
    if (p != NULL) {
        rtcReleaseDevice(p->device);
        free(p);
    }
}

peer_scene *peer_scene_create(peer *p, const surface *s, const float maps[WATERTIGHT_MAPS][3][4])
{
    peer_scene *scene = malloc(sizeof *scene);
    scene->positions = calloc((size_t)s->m.vertex_count + 1, 12);
    memcpy(scene->positions, s->m.positions, 12 * (size_t)s->m.vertex_count);
    for (int mode = 0; mode < 2; mode++) {
        scene->meshes[mode] = embree_mesh_make(p->device, scene->positions, s->m.vertex_count, s->m.indices,
                                               s->m.triangle_count, RTC_BUILD_QUALITY_MEDIUM,
                                               mode == 1 ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
        for (int map = 0; map < WATERTIGHT_MAPS; map++) {
            RTCScene placed = rtcNewScene(p->device);
            RTCGeometry instance = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetSceneFlags(placed, mode == 1 ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
            rtcSetGeometryInstancedScene(instance, scene->meshes[mode].scene);
            rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, maps[map]);
            rtcCommitGeometry(instance);
            rtcAttachGeometry(placed, instance);
            rtcReleaseGeometry(instance);
            rtcCommitScene(placed);
            scene->placed[mode][map] = placed;
        }
    }
    return scene;
}

void peer_scene_destroy(peer_scene *scene)
{
    for (int mode = 0; scene != NULL && mode < 2; mode++) {
        for (int map = 0; map < WATERTIGHT_MAPS; map++) {
            rtcReleaseScene(scene->placed[mode][map]);
        }
        rtcReleaseScene(scene->meshes[mode].scene);
    }
    if (scene != NULL) {
        free(scene->positions);
    }
    free(scene);
}

float peer_trace(const peer_scene *scene, uint32_t map, bool robust, const clast_ray *ray)
{
    struct RTCRayHit hit = embree_closest(scene->placed[robust ? 1 : 0][map], ray, false);
    return hit.hit.geomID != RTC_INVALID_GEOMETRY_ID ? hit.ray.tfar : INFINITY;
}

#else

peer *peer_create(void)
{
    return NULL;
}

void peer_destroy(peer *p)
{
    (void)p;
}

peer_scene *peer_scene_create(peer *p, const surface *s, const float maps[WATERTIGHT_MAPS][3][4])
{
    (void)p;
    (void)s;
    (void)maps;
    return NULL;
}

void peer_scene_destroy(peer_scene *scene)
{
    (void)scene;
}

float peer_trace(const peer_scene *scene, uint32_t map, bool robust, const clast_ray *ray)
{
    (void)scene;
    (void)map;
    (void)robust;
    (void)ray;
    return INFINITY;
}

#endif
