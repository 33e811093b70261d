// SPDX-License-Identifier: Apache-2.0
// What the driver of the same device builds over the same triangles.
#include "vulkan_work.h"

#include <stdio.h>

static void make_triangles(vulkan_work *work)
{
    vulkan_peer *peer = &work->peer;
    const vulkan_device *device = work->device;
    peer->triangles = (clast_driver_triangles){.positions = work->vertices.address,
                                               .vertex_count = work->vertex_count,
                                               .triangle_count = work->triangle_count};
    if (work->kind == VULKAN_MESH) { // as the mesh has them
        peer->triangles.positions = work->positions.address;
        peer->triangles.vertex_count = work->rest_count * work->copies;
    } else {
        vulkan_allocate(device, (uint64_t)work->triangle_count * 12, "indices", &peer->indices);
        vulkan_allocate(device, (uint64_t)work->triangle_count * 4, "triangles", &peer->places);
        clast_gpu_commands *commands = vulkan_begin(device);
        clast_driver_make_triangles(commands,
                                    &(clast_driver_clusters){.clusters = work->clusters.address,
                                                             .places = work->places.address,
                                                             .firsts = work->firsts.address,
                                                             .positions = work->vertices.address,
                                                             .count = work->cluster_count},
                                    peer->indices.address, peer->places.address);
        vulkan_finish(device, commands);
    }
    peer->triangles.indices = peer->indices.address;
}

static clast_status reserve(vulkan_work *work, clast_driver_build build, bool updated,
                            clast_driver_structure *structure)
{
    const clast_driver_triangles *triangles = &work->peer.triangles;
    return clast_driver_reserve(work->device->gpu,
                                &(clast_driver_structure_desc){.build = build,
                                                               .updated = updated,
                                                               .triangle_count = triangles->triangle_count,
                                                               .vertex_count = triangles->vertex_count},
                                structure);
}

void vulkan_peer_make(vulkan_work *work)
{
    vulkan_peer *peer = &work->peer;
    vulkan_device *device = work->device;
    make_triangles(work);
    clast_status status = reserve(work, CLAST_DRIVER_FAST_BUILD, true, &peer->fast_build);
    status = status == CLAST_OK ? reserve(work, CLAST_DRIVER_FAST_TRACE, false, &peer->fast_trace) : status;
    if (status != CLAST_OK) {
        fprintf(stderr, "%s: without the driver's structures: %s\n", work->name, clast_context_error(device->context));
        return;
    }
    clast_gpu_commands *commands = vulkan_begin(device);
    vulkan_peer_build(work, commands, CLAST_DRIVER_FAST_BUILD);
    vulkan_peer_build(work, commands, CLAST_DRIVER_FAST_TRACE);
    clast_driver_instance instance = {.structure = &peer->fast_trace,
                                      .positions = peer->triangles.positions,
                                      .indices = peer->triangles.indices,
                                      .triangles = peer->places.address};
    for (int k = 0; k < 3; k++) {
        instance.to_world.rows[k].v[k] = 1.0f;
    }
    clast_driver_scene_build(commands, &instance, 1, CLAST_DRIVER_FAST_TRACE, &peer->scene);
    vulkan_finish(device, commands);
    peer->is_there = true;
}

void vulkan_peer_build(vulkan_work *work, clast_gpu_commands *commands, clast_driver_build build)
{
    vulkan_peer *peer = &work->peer;
    clast_driver_job job = {.structure = build == CLAST_DRIVER_FAST_BUILD ? &peer->fast_build : &peer->fast_trace,
                            .triangles = peer->triangles};
    clast_driver_build_all(commands, &job, 1, &peer->scratch);
    clast_gpu_barrier(commands);
}

void vulkan_peer_update(vulkan_work *work, clast_gpu_commands *commands)
{
    vulkan_peer *peer = &work->peer;
    clast_driver_job job = {.structure = &peer->fast_build, .triangles = peer->triangles, .update = true};
    clast_driver_build_all(commands, &job, 1, &peer->scratch);
    clast_gpu_barrier(commands);
}

uint64_t vulkan_peer_bytes(const vulkan_work *work, clast_driver_build build)
{
    const vulkan_peer *peer = &work->peer;
    uint64_t structure = build == CLAST_DRIVER_FAST_BUILD ? peer->fast_build.bytes : peer->fast_trace.bytes;
    return structure + 12 * (uint64_t)peer->triangles.vertex_count + 12 * (uint64_t)peer->triangles.triangle_count;
}

void vulkan_peer_free(vulkan_work *work)
{
    vulkan_peer *peer = &work->peer;
    clast_gpu *gpu = work->device->gpu;
    clast_driver_scene_free(gpu, &peer->scene);
    clast_driver_free(gpu, &peer->fast_build);
    clast_driver_free(gpu, &peer->fast_trace);
    clast_gpu_free(gpu, &peer->scratch.buffer);
    clast_gpu_free(gpu, &peer->indices);
    clast_gpu_free(gpu, &peer->places);
}
