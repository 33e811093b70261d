// SPDX-License-Identifier: Apache-2.0
// Copies of a displaced sphere of half a million triangles, cut into clusters as any mesh is. Copies share nothing on the
// device: each has its own topologies, as the parts of one large mesh would.
#include "vulkan_work.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/meshes.h"

enum { LEVELS_MOST = 8 }; // of halved edges: 8 * 4^8 triangles

// A cut mesh, and where its clusters' pairs lie.
typedef struct mesh_cut {
    mesh m;
    clast_clusters clusters;
    uint64_t pair_bytes;
    uint32_t space; // of all clusters
} mesh_cut;

// Smooth hills, and no random heights: neighbours of a real scan are near each other too.
static mesh make_mesh(uint32_t triangles, uint32_t *copies)
{
    uint32_t levels = 1;
    while (levels < LEVELS_MOST && 8u << 2 * (levels + 1) <= triangles) {
        levels++;
    }
    mesh m = mesh_octasphere(levels);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i;
        float x = p[0], y = p[1], z = p[2];
        float factor = 1.0f + 0.1f * sinf(9.0f * x + 2.0f * y) * sinf(8.0f * y - z) +
                       0.03f * sinf(31.0f * z + 17.0f * x);
        for (int k = 0; k < 3; k++) {
            p[k] *= factor;
        }
    }
    *copies = (triangles + m.triangle_count / 2) / m.triangle_count;
    *copies = *copies != 0 ? *copies : 1;
    return m;
}

static void cut_mesh(vulkan_work *work, mesh_cut *cut)
{
    const vulkan_device *device = work->device;
    clast_clusterize_desc desc = {.positions = cut->m.positions,
                                  .position_count = cut->m.vertex_count,
                                  .indices = cut->m.indices,
                                  .triangle_count = cut->m.triangle_count};
    vulkan_check(device, clast_clusterize(device->context, &desc, &cut->clusters));
    const clast_clusters *c = &cut->clusters;
    clast_template_desc *descs = calloc(c->cluster_count, sizeof *descs);
    vulkan_check(device, descs != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    for (size_t i = 0; i < c->cluster_count; i++) {
        descs[i] = (clast_template_desc){.triangle_count = c->clusters[i].triangle_count,
                                         .vertex_count = c->clusters[i].vertex_count,
                                         .indices = c->indices + 3 * (size_t)c->clusters[i].first_triangle};
    }
    uint32_t first;
    vulkan_check(device, clast_template_set_add(work->set, descs, c->cluster_count, &first));
    free(descs);
    clast_gpu_commands *commands = vulkan_begin(device);
    vulkan_check(device, clast_topologies_update(&work->topologies, commands, work->set));
    vulkan_finish(device, commands);
    cut->pair_bytes = work->topologies.pairs[0].bytes;
}

// Pairs and templates of all copies.
static void copy_topologies(vulkan_work *work, const mesh_cut *cut)
{
    const vulkan_device *device = work->device;
    const clast_topologies *one = &work->topologies;
    uint64_t stride = (cut->pair_bytes + 15) / 16 * 16, from = one->pairs[0].address;
    vulkan_allocate(device, stride * work->copies, "pairs", &work->pairs);
    clast_device_template *list = calloc((size_t)one->count * work->copies, sizeof *list);
    vulkan_check(device, list != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    clast_gpu_commands *commands = vulkan_begin(device);
    for (uint32_t copy = 0; copy < work->copies; copy++) {
        uint64_t to = work->pairs.address + stride * copy;
        clast_gpu_copy(commands, &work->pairs, stride * copy, &one->pairs[0], 0, cut->pair_bytes);
        for (uint32_t i = 0; i < one->count; i++) {
            clast_device_template *made = &list[(size_t)copy * one->count + i];
            *made = one->records[i];
            made->pairs = store_address(load_address(made->pairs) - from + to);
            made->corners = store_address(load_address(made->corners) - from + to);
        }
    }
    vulkan_finish(device, commands);
    vulkan_upload(device, list, (uint64_t)one->count * work->copies * sizeof *list, "templates", &work->templates);
    free(list);
}

// Inputs, places and first triangles of the clusters of all copies.
static void list_clusters(vulkan_work *work, const mesh_cut *cut)
{
    const vulkan_device *device = work->device;
    const clast_clusters *c = &cut->clusters;
    size_t count = c->cluster_count * work->copies;
    clast_device_cluster *list = calloc(count, sizeof *list);
    uint32_t *places = calloc(count, sizeof *places), *firsts = calloc(count + 1, sizeof *firsts), place = 0;
    vulkan_check(device, list != NULL && places != NULL && firsts != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    for (size_t i = 0; i < count; i++) {
        const clast_cluster *cluster = &c->clusters[i % c->cluster_count];
        list[i] = (clast_device_cluster){(uint32_t)i, work->vertex_count, place};
        places[i] = place;
        firsts[i] = work->triangle_count;
        work->vertex_count += cluster->vertex_count;
        work->triangle_count += cluster->triangle_count;
        place += cluster_space(triangles_counts(cluster->triangle_count), false);
    }
    firsts[count] = work->triangle_count;
    work->cluster_count = (uint32_t)count;
    vulkan_upload(device, list, count * sizeof *list, "inputs", &work->inputs);
    vulkan_upload(device, places, count * sizeof *places, "places", &work->places);
    vulkan_upload(device, firsts, (count + 1) * sizeof *firsts, "firsts", &work->firsts);
    vulkan_allocate(device, (uint64_t)place * CLUSTER_UNIT, "clusters", &work->clusters);
    free(list);
    free(places);
    free(firsts);
}

// Which position each vertex of each cluster has; and the triangles as the driver takes them, with their places in clusters.
static void list_numbers(vulkan_work *work, const mesh_cut *cut)
{
    const vulkan_device *device = work->device;
    const clast_clusters *c = &cut->clusters;
    size_t vertices = c->vertex_count, triangles = cut->m.triangle_count;
    uint32_t *numbers = calloc(vertices, sizeof *numbers), *indices = calloc(3 * triangles, sizeof *indices);
    uint32_t *places = calloc(triangles, sizeof *places);
    vulkan_check(device, numbers != NULL && indices != NULL && places != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    vulkan_allocate(device, vertices * work->copies * sizeof *numbers, "numbers", &work->numbers);
    vulkan_allocate(device, 3 * triangles * work->copies * sizeof *indices, "indices", &work->peer.indices);
    vulkan_allocate(device, triangles * work->copies * sizeof *places, "triangles", &work->peer.places);
    for (uint32_t copy = 0; copy < work->copies; copy++) {
        for (size_t i = 0; i < vertices; i++) {
            numbers[i] = c->vertices[i] + copy * cut->m.vertex_count;
        }
        for (size_t i = 0; i < 3 * triangles; i++) {
            indices[i] = cut->m.indices[i] + copy * cut->m.vertex_count;
        }
        for (size_t i = 0; i < c->cluster_count; i++) {
            for (uint32_t k = 0; k < c->clusters[i].triangle_count; k++) {
                places[c->triangles[c->clusters[i].first_triangle + k]] = driver_triangle(
                    (uint32_t)(copy * c->cluster_count + i), k);
            }
        }
        clast_gpu_commands *commands = vulkan_begin(device);
        clast_gpu_write(commands, &work->numbers, copy * vertices * sizeof *numbers, numbers,
                        vertices * sizeof *numbers);
        clast_gpu_write(commands, &work->peer.indices, copy * 3 * triangles * sizeof *indices, indices,
                        3 * triangles * sizeof *indices);
        clast_gpu_write(commands, &work->peer.places, copy * triangles * sizeof *places, places,
                        triangles * sizeof *places);
        vulkan_finish(device, commands);
    }
    free(numbers);
    free(indices);
    free(places);
}

void vulkan_mesh_make(vulkan_work *work, uint32_t triangles)
{
    const vulkan_device *device = work->device;
    mesh_cut cut = {.m = make_mesh(triangles, &work->copies)};
    cut_mesh(work, &cut);
    while (work->side * work->side * work->side < work->copies) {
        work->side++;
    }
    copy_topologies(work, &cut);
    list_clusters(work, &cut);
    list_numbers(work, &cut);
    work->rest_count = cut.m.vertex_count;
    const uint32_t no_faults = 0;
    vulkan_upload(device, cut.m.positions, (uint64_t)work->rest_count * sizeof(packed3), "rest", &work->rest);
    vulkan_upload(device, &no_faults, sizeof no_faults, "faults", &work->faults);
    vulkan_allocate(device, (uint64_t)work->rest_count * work->copies * sizeof(packed3), "positions", &work->positions);
    clast_clusters_free(device->context, &cut.clusters);
    mesh_free(&cut.m);
}
