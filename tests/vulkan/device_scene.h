// SPDX-License-Identifier: Apache-2.0
// Brings a TLAS of the processor, and all below it, to a device: clusters are fitted there; trees are built there, or are those of
// the processor.
#ifndef CLAST_TESTS_VULKAN_DEVICE_SCENE_H
#define CLAST_TESTS_VULKAN_DEVICE_SCENE_H

#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "shared/cluster.h"
#include "vulkan/fit.h"
#include "vulkan/pairs.h"
#include "vulkan/trees.h"

// A pool's clusters and a tree over them.
typedef struct device_blas {
    const clast_blas *blas;
    clast_gpu_buffer pairs, templates, inputs, vertices, clusters, boxes, items, nodes;
    uint32_t *places;
    clast_device_cluster *clusters_in;
    size_t count;
} device_blas;

typedef struct device_scene {
    clast_gpu *gpu;
    device_blas *blases;
    size_t blas_count;
    bool borrowed;          // the BLASes are another scene's
    clast_gpu_trees *trees; // to build trees with; null: they are the processor's
    clast_gpu_buffer nodes, placements, boxes, scene;
} device_scene;

static inline clast_status device_upload(clast_gpu_commands *commands, const void *data, size_t bytes,
                                         clast_gpu_buffer *buffer)
{
    clast_status status = clast_gpu_allocate(clast_gpu_of(commands), CLAST_GPU_DEVICE, bytes + 16, "test", buffer);
    if (status == CLAST_OK && bytes != 0) {
        clast_gpu_write(commands, buffer, 0, data, bytes);
    }
    return status;
}

// Children keep their places; the order is that of the axes along which they happen to be spread.
static inline clast_tree_node device_node(const clast_node *from, const uint32_t *places)
{
    clast_tree_node to = {.lower = {{from->lower[0], from->lower[1], from->lower[2]}}};
    to.exponents = from->exponents[0] | (uint32_t)from->exponents[1] << 8 | (uint32_t)from->exponents[2] << 16;
    uint32_t axes[3];
    for (uint32_t axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < TREE_WIDTH; i++) {
            uint32_t shift = 8 * (i % 4);
            bool there = i < from->child_count;
            to.sides[4 * axis + i / 4] |= (uint32_t)(there ? from->boxes[axis][0][i] : 255) << shift;
            to.sides[4 * axis + 2 + i / 4] |= (uint32_t)(there ? from->boxes[axis][1][i] : 0) << shift;
        }
    }
    for (uint32_t bit = 0; bit < 3; bit++) {
        vec3 sum = splat3(0.0f);
        for (uint32_t axis = 0; axis < 3; axis++) {
            const uint *sides = &to.sides[4 * axis];
            sum[axis] = centre_differences(sides[0], sides[1], sides[2], sides[3])[bit] *
                        power_of_two(from->exponents[axis]);
        }
        axes[bit] = side_of(sum) % 3;
    }
    to.exponents |= tree_order(axes[0], axes[1], axes[2]) << 24;
    for (uint32_t i = 0; i < TREE_WIDTH; i++) {
        uint32_t child = from->children[i < from->child_count ? i : 0];
        bool item = (child & CLAST_CHILD_ITEM) != 0 && places != NULL;
        to.children[i] = item ? CLAST_CHILD_ITEM | places[child & ~CLAST_CHILD_ITEM] : child;
    }
    return to;
}

// With room for any tree over so many items. Where the device will build it, there is nothing in it yet.
static inline clast_status device_tree(clast_gpu_commands *commands, const clast_tree *tree, const uint32_t *places,
                                       size_t items, bool later, clast_gpu_buffer *buffer)
{
    size_t room = items > tree->node_count ? items : tree->node_count;
    clast_tree_node *nodes = calloc(room + 1, sizeof *nodes);
    for (uint32_t i = 0; i < tree->node_count; i++) {
        nodes[i] = device_node(later ? &(clast_node){0} : &tree->nodes[i], places);
    }
    clast_status status = device_upload(commands, nodes, (room + 1) * sizeof *nodes, buffer);
    free(nodes);
    return status;
}

// Which slots the processor's tree has.
static inline bool *device_used_slots(const clast_blas *blas)
{
    bool *used = calloc(blas->pool->count + 1, sizeof *used);
    for (uint32_t i = 0; i < blas->tree.node_count; i++) {
        const clast_node *node = &blas->tree.nodes[i];
        for (uint32_t k = 0; k < node->child_count; k++) {
            if ((node->children[k] & CLAST_CHILD_ITEM) != 0) {
                used[node->children[k] & ~CLAST_CHILD_ITEM] = true;
            }
        }
    }
    return used;
}

// Slots are numbered as they are; each has its pairs, whatever its template.
static inline clast_status device_clusters(clast_gpu_commands *commands, device_blas *to)
{
    const clast_clas_pool *pool = to->blas->pool;
    size_t count = to->count = pool->count, vertex_count = 0;
    clast_pair *pairs = malloc((count + 1) * CLAST_PAIRS_MOST * sizeof *pairs);
    clast_device_template *templates = calloc(count + 1, sizeof *templates);
    to->clusters_in = calloc(count + 1, sizeof *to->clusters_in);
    to->places = calloc(count + 1, sizeof *to->places);
    float *vertices = malloc((count + 1) * (size_t)TEMPLATE_VERTICES * 12);
    bool *used = device_used_slots(to->blas);
    uint32_t place = 0;
    size_t pair_count = 0;
    for (size_t i = 0; i < count; i++) {
        const clast_clas *clas = clast_pool_slot(pool, i);
        if (clas->topology == 0 || !used[i]) { // nothing there
            const float nowhere[3] = {NAN, NAN, NAN};
            templates[i].pairs = store_address(pair_count * sizeof *pairs);
            templates[i].counts = cluster_counts(1, 0);
            templates[i].vertices = 1;
            pairs[pair_count++] = lone_pair(0);
            to->clusters_in[i] = (clast_device_cluster){(uint32_t)i, (uint32_t)vertex_count, place};
            memcpy(vertices + 3 * vertex_count++, nowhere, sizeof nowhere);
            to->places[i] = place;
            place += cluster_space(templates[i].counts, false);
            continue;
        }
        const clast_template *topology = clast_clas_topology(clas);
        templates[i].counts = triangles_counts(topology->triangle_count);
        templates[i].vertices = topology->vertex_count;
        templates[i].pairs = store_address(pair_count * sizeof *pairs);
        clast_pairs_of_template(topology, pairs + pair_count);
        pair_count += cluster_pairs(templates[i].counts);
        to->clusters_in[i] = (clast_device_cluster){(uint32_t)i, (uint32_t)vertex_count, place};
        memcpy(vertices + 3 * vertex_count, clast_clas_vertices(clas), topology->vertex_count * (size_t)12);
        vertex_count += topology->vertex_count;
        to->places[i] = place;
        place += cluster_space(templates[i].counts, false);
    }
    clast_status status = device_upload(commands, pairs, pair_count * sizeof *pairs, &to->pairs);
    for (size_t i = 0; i < count; i++) {
        templates[i].pairs = store_address(load_address(templates[i].pairs) + to->pairs.address);
    }
    status = status == CLAST_OK ? device_upload(commands, templates, count * sizeof *templates, &to->templates)
                                : status;
    status = status == CLAST_OK ? device_upload(commands, to->clusters_in, count * sizeof *to->clusters_in, &to->inputs)
                                : status;
    status = status == CLAST_OK ? device_upload(commands, vertices, vertex_count * 12, &to->vertices) : status;
    status = status == CLAST_OK
                 ? clast_gpu_allocate(clast_gpu_of(commands), CLAST_GPU_DEVICE, 24 * count + 16, "boxes", &to->boxes)
                 : status;
    status = status == CLAST_OK ? clast_gpu_allocate(clast_gpu_of(commands), CLAST_GPU_DEVICE,
                                                     (uint64_t)place * CLUSTER_UNIT + 16, "clusters", &to->clusters)
                                : status;
    status = status == CLAST_OK ? device_upload(commands, to->places, count * sizeof *to->places, &to->items) : status;
    free(used);
    free(pairs);
    free(templates);
    free(vertices);
    return status;
}

static inline void device_fit(clast_gpu_commands *commands, const device_blas *b)
{
    clast_gpu_fit_clusters(commands, &(clast_gpu_fit){.templates = b->templates.address,
                                                      .inputs = b->inputs.address,
                                                      .vertices = b->vertices.address,
                                                      .clusters = b->clusters.address,
                                                      .boxes = b->boxes.address,
                                                      .count = (uint32_t)b->count});
}

static inline void device_blas_free(clast_gpu *gpu, device_blas *b)
{
    clast_gpu_buffer *const buffers[] = {&b->pairs,    &b->templates, &b->inputs, &b->vertices,
                                         &b->clusters, &b->boxes,     &b->items,  &b->nodes};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        clast_gpu_free(gpu, buffers[i]);
    }
    free(b->places);
    free(b->clusters_in);
}

static inline device_blas *device_find_blas(device_scene *scene, const clast_blas *blas)
{
    for (size_t i = 0; i < scene->blas_count; i++) {
        if (scene->blases[i].blas == blas) {
            return &scene->blases[i];
        }
    }
    return NULL;
}

static inline clast_device_placement device_place(device_scene *scene, const clast_placement *from)
{
    clast_device_placement to = {
        .id = from->id, .flags = (from->filtered ? PLACEMENT_FILTERED : 0) | (from->mirrored ? PLACEMENT_MIRRORED : 0)};
    for (int k = 0; k < 3; k++) {
        memcpy(&to.to_object[k], from->to_object[k], 12);
        memcpy(&to.to_world[k], from->to_world[k], 12);
    }
    memcpy(&to.origin, from->origin, 12);
    if (from->blas != NULL && from->blas->tree.node_count != 0) {
        device_blas *b = device_find_blas(scene, from->blas);
        to.nodes = store_address(b->nodes.address);
        to.clusters = store_address(b->clusters.address);
        to.box = from->blas->tree.boxes[0];
    }
    return to;
}

static inline clast_status device_scene_blases(clast_gpu_commands *commands, const clast_tlas *tlas,
                                               device_scene *scene)
{
    scene->blases = calloc(tlas->placement_count + 1, sizeof *scene->blases);
    for (size_t i = 0; i < tlas->placement_count; i++) {
        const clast_blas *blas = tlas->placements[i].blas;
        if (blas == NULL || blas->tree.node_count == 0 || device_find_blas(scene, blas) != NULL) {
            continue;
        }
        device_blas *made = &scene->blases[scene->blas_count++];
        made->blas = blas;
        clast_status status = device_clusters(commands, made);
        status = status == CLAST_OK
                     ? device_tree(commands, &blas->tree, made->places, made->count, scene->trees != NULL, &made->nodes)
                     : status;
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

static inline clast_status device_build(const device_scene *scene, clast_gpu_commands *commands, uint64_t boxes,
                                        uint64_t items, uint64_t nodes, size_t count)
{
    clast_gpu_tree tree = {.boxes = boxes, .items = items, .nodes = nodes, .count = (uint32_t)count};
    clast_gpu_barrier(commands);
    return clast_gpu_trees_build(scene->trees, commands, &tree, 1, CLAST_GPU_TREE_SORTED);
}

// Trees there, in place of the processor's.
static inline clast_status device_build_trees(device_scene *scene, clast_gpu_commands *commands, const clast_tlas *tlas)
{
    clast_status status = CLAST_OK;
    for (size_t i = 0; status == CLAST_OK && i < scene->blas_count && !scene->borrowed; i++) {
        device_blas *b = &scene->blases[i];
        status = device_build(scene, commands, b->boxes.address, b->items.address, b->nodes.address, b->count);
    }
    if (status == CLAST_OK && tlas->tree.node_count != 0) {
        status = device_build(scene, commands, scene->boxes.address, 0, scene->nodes.address, tlas->placement_count);
    }
    return status;
}

// All of it, ready for rays. With `lender`, all BLASes are those of that scene.
static inline clast_status device_scene_make_with(clast_gpu *gpu, const clast_tlas *tlas, const device_scene *lender,
                                                  clast_gpu_trees *trees, device_scene *scene)
{
    *scene = (device_scene){.gpu = gpu, .trees = trees};
    if (lender != NULL) {
        scene->blases = lender->blases;
        scene->blas_count = lender->blas_count;
        scene->borrowed = true;
    }
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    status = lender != NULL ? CLAST_OK : device_scene_blases(commands, tlas, scene);
    clast_device_placement *placements = malloc((tlas->placement_count + 1) * sizeof *placements);
    clast_device_scene record = {.spread = tlas->spread};
    record.placement_count = tlas->visible ? (uint32_t)tlas->placement_count : 0;
    for (size_t i = 0; status == CLAST_OK && i < tlas->placement_count; i++) {
        placements[i] = device_place(scene, &tlas->placements[i]);
    }
    status = status == CLAST_OK
                 ? device_upload(commands, placements, tlas->placement_count * sizeof *placements, &scene->placements)
                 : status;
    status = status == CLAST_OK
                 ? device_tree(commands, &tlas->tree, NULL, tlas->placement_count, trees != NULL, &scene->nodes)
                 : status;
    if (tlas->tree.node_count != 0) {
        record.box = tlas->tree.boxes[0];
    }
    record.nodes = store_address(scene->nodes.address);
    record.placements = store_address(scene->placements.address);
    status = status == CLAST_OK ? device_upload(commands, &record, sizeof record, &scene->scene) : status;
    status = status == CLAST_OK
                 ? device_upload(commands, tlas->boxes, tlas->placement_count * sizeof *tlas->boxes, &scene->boxes)
                 : status;
    clast_gpu_barrier(commands);
    for (size_t i = 0; i < scene->blas_count && !scene->borrowed; i++) {
        device_fit(commands, &scene->blases[i]);
    }
    if (status == CLAST_OK && trees != NULL) {
        status = device_build_trees(scene, commands, tlas);
    }
    free(placements);
    clast_gpu_note(commands, status);
    return clast_gpu_finish(commands);
}

static inline clast_status device_scene_make(clast_gpu *gpu, const clast_tlas *tlas, device_scene *scene)
{
    return device_scene_make_with(gpu, tlas, NULL, NULL, scene);
}

static inline void device_scene_free(device_scene *scene)
{
    for (size_t i = 0; i < scene->blas_count && !scene->borrowed; i++) {
        device_blas_free(scene->gpu, &scene->blases[i]);
    }
    if (!scene->borrowed) {
        free(scene->blases);
    }
    clast_gpu_free(scene->gpu, &scene->nodes);
    clast_gpu_free(scene->gpu, &scene->placements);
    clast_gpu_free(scene->gpu, &scene->boxes);
    clast_gpu_free(scene->gpu, &scene->scene);
}

#endif
