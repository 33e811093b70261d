// SPDX-License-Identifier: Apache-2.0
#include "vulkan_work.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/patterns.h"
#include "vulkan/fit.h"

enum {
    GRID_SEGMENTS_HERE = 8,
    GRID_VERTICES = (GRID_SEGMENTS_HERE + 1) * (GRID_SEGMENTS_HERE + 1),
    GRID_TRIANGLES = 2 * GRID_SEGMENTS_HERE * GRID_SEGMENTS_HERE,
    PATTERN_TRIANGLES_ABOUT = 88, // with edges of 8 to 11 segments
};

// ------------------------------------------------------------------------------------------------------------ device

void vulkan_check(const vulkan_device *device, clast_status status)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(device->context));
        exit(1);
    }
}

void vulkan_allocate(const vulkan_device *device, uint64_t bytes, const char *name, clast_gpu_buffer *buffer)
{
    vulkan_check(device, clast_gpu_allocate(device->gpu, CLAST_GPU_DEVICE, bytes, name, buffer));
}

clast_gpu_commands *vulkan_begin(const vulkan_device *device)
{
    clast_gpu_commands *commands;
    vulkan_check(device, clast_gpu_begin(device->gpu, &commands));
    return commands;
}

void vulkan_finish(const vulkan_device *device, clast_gpu_commands *commands)
{
    vulkan_check(device, clast_gpu_finish(commands));
}

void vulkan_upload(const vulkan_device *device, const void *data, uint64_t bytes, const char *name,
                   clast_gpu_buffer *buffer)
{
    vulkan_allocate(device, bytes, name, buffer);
    if (bytes != 0) {
        clast_gpu_commands *commands = vulkan_begin(device);
        clast_gpu_write(commands, buffer, 0, data, bytes);
        vulkan_finish(device, commands);
    }
}

// ---------------------------------------------------------------------------------------------------------- clusters

// Cells along the sides: as near to a wanted number as powers of two come.
static void choose_cells(vulkan_work *work, double wanted)
{
    int bits = (int)floor(log2(wanted) + 0.5);
    bits = bits < 0 ? 0 : bits;
    work->logarithms[0] = (uint32_t)(bits + 1) / 2;
    work->logarithms[1] = (uint32_t)bits / 2;
}

static uint32_t hash(uint32_t x)
{
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

// The segments of an edge of cells, by where it is and which way it goes: both sides agree.
static uint32_t segments_of(uint32_t x, uint32_t y, uint32_t way)
{
    return 8 + hash(x * 3 + way + hash(y)) % 4;
}

static uint32_t every_second_bit(uint32_t x)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 16; i++) {
        bits |= (x >> 2 * i & 1) << i;
    }
    return bits;
}

// As in shaders/bench/surface.glsl.
static void cell_of(const vulkan_work *work, uint32_t number, uint32_t cell[2])
{
    uint32_t both = work->logarithms[1], low = number & ((1u << 2 * both) - 1);
    cell[0] = every_second_bit(low) | number >> 2 * both << both;
    cell[1] = every_second_bit(low >> 1);
}

// Half a cell: corners (0, 0), (1, 0), (1, 1), or (0, 0), (1, 1), (0, 1).
static clast_pattern_use pattern_of_half(const vulkan_work *work, uint32_t number)
{
    uint32_t cell[2];
    cell_of(work, number / 2, cell);
    uint32_t x = cell[0], y = cell[1], diagonal = segments_of(x, y, 2);
    uint32_t factors = number % 2 == 0 ? pattern_factors(segments_of(x, y, 0), segments_of(x + 1, y, 1), diagonal)
                                       : pattern_factors(diagonal, segments_of(x, y + 1, 0), segments_of(x, y, 1));
    return pattern_use(factors);
}

// Which template each cluster has. Gives their number, in memory of the caller.
static clast_device_cluster *choose_templates(vulkan_work *work)
{
    bool patterns = work->kind == VULKAN_PATTERNS;
    work->cluster_count = 1u << (work->logarithms[0] + work->logarithms[1] + (patterns ? 1 : 0));
    clast_device_cluster *list = calloc(work->cluster_count, sizeof *list);
    uint32_t *rotations = calloc(work->cluster_count, sizeof *rotations), first = 0;
    vulkan_check(work->device, list != NULL && rotations != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    if (!patterns) {
        vulkan_check(work->device,
                     clast_template_set_add_grid(work->set, GRID_SEGMENTS_HERE, GRID_SEGMENTS_HERE, &first));
    } else {
        vulkan_check(work->device, clast_template_set_add_patterns(work->set, &clast_patterns, &first));
    }
    for (uint32_t i = 0; i < work->cluster_count; i++) {
        clast_pattern_use use = patterns ? pattern_of_half(work, i) : (clast_pattern_use){0, 0};
        list[i].template_number = first + use.number;
        rotations[i] = use.rotation;
    }
    if (patterns) {
        const clast_pattern_table *table = &clast_patterns;
        vulkan_upload(work->device, rotations, work->cluster_count * sizeof *rotations, "rotations", &work->rotations);
        vulkan_upload(work->device, table->patterns, PATTERN_COUNT * sizeof *table->patterns, "patterns",
                      &work->patterns);
        vulkan_upload(work->device, table->vertices, table->vertex_count * sizeof *table->vertices, "weights",
                      &work->weights);
    }
    free(rotations);
    return list;
}

static void make_surface(vulkan_work *work, uint32_t triangles)
{
    bool patterns = work->kind == VULKAN_PATTERNS;
    choose_cells(work, triangles / (patterns ? 2.0 * PATTERN_TRIANGLES_ABOUT : (double)GRID_TRIANGLES));
    clast_device_cluster *list = choose_templates(work);
    uint32_t *places = calloc(work->cluster_count, sizeof *places);
    uint32_t *firsts = calloc((size_t)work->cluster_count + 1, sizeof *firsts), place = 0;
    vulkan_check(work->device, places != NULL && firsts != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    for (uint32_t i = 0; i < work->cluster_count; i++) {
        uint32_t number = list[i].template_number;
        list[i].first_vertex = work->vertex_count;
        list[i].place = places[i] = place;
        firsts[i] = work->triangle_count;
        work->vertex_count += clast_template_vertex_count(work->set, number);
        work->triangle_count += clast_template_triangle_count(work->set, number);
        place += cluster_space(triangles_counts(clast_template_triangle_count(work->set, number)), false);
    }
    firsts[work->cluster_count] = work->triangle_count;
    vulkan_upload(work->device, list, work->cluster_count * sizeof *list, "inputs", &work->inputs);
    vulkan_upload(work->device, places, work->cluster_count * sizeof *places, "places", &work->places);
    vulkan_upload(work->device, firsts, ((uint64_t)work->cluster_count + 1) * sizeof *firsts, "firsts", &work->firsts);
    vulkan_allocate(work->device, (uint64_t)place * CLUSTER_UNIT, "clusters", &work->clusters);
    free(list);
    free(places);
    free(firsts);
}

// ------------------------------------------------------------------------------------------------------------- fills

// The push constants of shaders/bench/surface.comp.
typedef struct surface_push {
    uint64_t inputs, templates, vertices, clusters, boxes, patterns, weights, rotations;
    uint32_t logarithms[2], count;
    float time;
} surface_push;

static void run_surface(const vulkan_work *work, clast_gpu_commands *commands, bool fits)
{
    surface_push push = {.inputs = work->inputs.address,
                         .templates = work->topologies.templates.address,
                         .vertices = work->vertices.address,
                         .clusters = work->clusters.address,
                         .boxes = work->boxes.address,
                         .patterns = work->patterns.address,
                         .weights = work->weights.address,
                         .rotations = work->rotations.address,
                         .logarithms = {work->logarithms[0], work->logarithms[1]},
                         .count = work->cluster_count,
                         .time = work->time};
    clast_gpu_lanes lanes = clast_gpu_lanes_of(work->device->gpu);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_SURFACE,
                                              .constants = {work->surface, work->kind == VULKAN_PATTERNS, fits,
                                                            lanes.lanes, lanes.group},
                                              .constant_count = 5,
                                              .subgroup = lanes.lanes,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = clast_gpu_lane_groups(lanes, work->cluster_count)});
}

// The push constants of shaders/bench/move.comp.
typedef struct move_push {
    uint64_t rest, positions;
    uint32_t vertices, copies, side;
    float time;
} move_push;

static void move_mesh(const vulkan_work *work, clast_gpu_commands *commands)
{
    move_push push = {.rest = work->rest.address,
                      .positions = work->positions.address,
                      .vertices = work->rest_count,
                      .copies = work->copies,
                      .side = work->side,
                      .time = work->time};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_MOVE,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = ((uint64_t)work->rest_count * work->copies + 255) / 256});
}

void vulkan_fill(const vulkan_work *work, clast_gpu_commands *commands)
{
    clast_gpu_barrier(commands);
    if (work->kind == VULKAN_MESH) {
        move_mesh(work, commands);
    } else {
        run_surface(work, commands, false);
    }
    clast_gpu_barrier(commands);
}

void vulkan_fit(const vulkan_work *work, clast_gpu_commands *commands)
{
    clast_gpu_barrier(commands);
    if (work->kind == VULKAN_MESH) {
        clast_gpu_fit_clusters(commands, &(clast_gpu_fit){.templates = work->templates.address,
                                                          .inputs = work->inputs.address,
                                                          .vertices = work->vertices.address,
                                                          .clusters = work->clusters.address,
                                                          .boxes = work->boxes.address,
                                                          .positions = work->positions.address,
                                                          .numbers = work->numbers.address,
                                                          .faults = work->faults.address,
                                                          .position_count = work->rest_count * work->copies,
                                                          .count = work->cluster_count});
    } else {
        run_surface(work, commands, true);
    }
    clast_gpu_barrier(commands);
}

void vulkan_tree(const vulkan_work *work, clast_gpu_commands *commands, clast_gpu_tree_order order)
{
    clast_gpu_tree tree = {.boxes = work->boxes.address,
                           .items = work->places.address,
                           .nodes = work->nodes.address,
                           .bounds = work->bounds.address,
                           .kept = work->shape.address,
                           .count = work->cluster_count};
    if (order == CLAST_GPU_TREE_STORED && work->shape.bytes != 0) {
        clast_gpu_trees_refit(work->device->trees, commands, &tree, 1);
    } else {
        tree.kept = 0;
        clast_gpu_trees_build(work->device->trees, commands, &tree, 1, order);
    }
    clast_gpu_barrier(commands);
}

static clast_gpu_tree kept_tree(const vulkan_work *work)
{
    return (clast_gpu_tree){.boxes = work->boxes.address,
                            .items = work->places.address,
                            .nodes = work->kept_nodes.address,
                            .kept = work->kept.address,
                            .count = work->cluster_count};
}

void vulkan_tree_keep(const vulkan_work *work, clast_gpu_commands *commands)
{
    clast_gpu_tree tree = kept_tree(work);
    clast_gpu_trees_build(work->device->trees, commands, &tree, 1, CLAST_GPU_TREE_SORTED);
    clast_gpu_barrier(commands);
}

void vulkan_tree_refit(const vulkan_work *work, clast_gpu_commands *commands)
{
    clast_gpu_tree tree = kept_tree(work);
    clast_gpu_trees_refit(work->device->trees, commands, &tree, 1);
    clast_gpu_barrier(commands);
}

// ------------------------------------------------------------------------------------------------------------- scene

// Builds a tree over the clusters of a mesh that has not moved.
static void make_shape(vulkan_work *work)
{
    vulkan_device *device = work->device;
    clast_box *boxes = calloc(work->cluster_count, sizeof *boxes);
    clast_arena arena = {malloc(clast_tree_scratch(work->cluster_count)), 0};
    vulkan_check(device, boxes != NULL && arena.memory != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    float time = work->time;
    work->time = 0.0f;
    clast_gpu_commands *commands = vulkan_begin(device);
    vulkan_fill(work, commands);
    vulkan_fit(work, commands);
    clast_gpu_read(commands, &work->boxes, 0, boxes, work->cluster_count * sizeof *boxes);
    vulkan_finish(device, commands);
    work->time = time;
    clast_tree tree = {0};
    vulkan_check(device,
                 clast_tree_build(device->context, &tree, boxes, NULL, work->cluster_count, CLAST_BUILD_BEST, &arena));
    void *shape = malloc(clast_gpu_tree_shape_bytes(&tree));
    vulkan_check(device, shape != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    vulkan_check(device, clast_gpu_tree_shape(device->context, &tree, shape));
    vulkan_upload(device, shape, clast_gpu_tree_shape_bytes(&tree), "shape", &work->shape);
    work->tree_bytes = tree.node_count * sizeof(clast_tree_node);
    clast_tree_free(device->context, &tree);
    free(shape);
    free(arena.memory);
    free(boxes);
}

// The unit, where it is, as the only instance.
static void make_scene(vulkan_work *work)
{
    vulkan_device *device = work->device;
    clast_box box;
    clast_gpu_commands *commands = vulkan_begin(device);
    vulkan_fill(work, commands);
    vulkan_fit(work, commands);
    vulkan_tree(work, commands, CLAST_GPU_TREE_STORED);
    clast_gpu_read(commands, &work->bounds, 0, &box, sizeof box);
    vulkan_finish(device, commands);
    clast_device_placement placement = {
        .nodes = store_address(work->nodes.address), .clusters = store_address(work->clusters.address), .box = box};
    for (int k = 0; k < 3; k++) {
        placement.to_object[k].v[k] = placement.to_world[k].v[k] = 1.0f;
    }
    vulkan_upload(device, &placement, sizeof placement, "placement", &work->placement);
    vulkan_allocate(device, clast_gpu_tree_bytes(1), "tree over instances", &work->top);
    vulkan_allocate(device, CLAST_GPU_RAYS_SCRATCH, "scratch", &work->scratch);
    commands = vulkan_begin(device);
    clast_gpu_tree tree = {.boxes = work->bounds.address, .nodes = work->top.address, .count = 1};
    clast_gpu_trees_build(device->trees, commands, &tree, 1, CLAST_GPU_TREE_STORED);
    vulkan_finish(device, commands);
    clast_device_scene scene = {.nodes = store_address(work->top.address),
                                .placements = store_address(work->placement.address),
                                .box = box,
                                .spread = 1.0f,
                                .placement_count = 1};
    vulkan_upload(device, &scene, sizeof scene, "scene", &work->scene);
}

static void place_camera(vulkan_work *work)
{
    const float cameras[3][6] = {{0.3f, 0.75f, -1.5f, 0.0f, -0.1f, -0.35f}, {0.1f, 0.05f, -0.1f, 1.0f, 0.3f, 0.5f}};
    const float *from = cameras[work->surface];
    memcpy(work->eye, from, sizeof work->eye);
    memcpy(work->target, from + 3, sizeof work->target);
    work->field = work->surface == VULKAN_TERRAIN ? 0.55f : 0.6f;
    if (work->kind == VULKAN_MESH) { // from outside, upon a corner of the lattice
        float reach = 1.25f * (float)(work->side - 1) + 1.0f;
        const float way[3] = {0.9f, 0.7f, 1.1f};
        for (int k = 0; k < 3; k++) {
            work->eye[k] = way[k] * 2.2f * reach;
            work->target[k] = 0.0f;
        }
    }
}

void vulkan_work_make(vulkan_device *device, vulkan_kind kind, vulkan_surface surface, uint32_t triangles,
                      vulkan_work *work)
{
    static const char *const names[3][2] = {
        {"terrain, grids", "sphere, grids"}, {"terrain, patterns", "sphere, patterns"}, {"mesh, moved", "mesh, moved"}};
    *work = (vulkan_work){.device = device, .name = names[kind][surface], .kind = kind, .surface = surface};
    work->time = 0.3f;
    vulkan_check(device, clast_template_set_create(device->context, &work->set));
    if (kind == VULKAN_MESH) {
        vulkan_mesh_make(work, triangles);
    } else {
        make_surface(work, triangles);
        clast_gpu_commands *commands = vulkan_begin(device);
        vulkan_check(device, clast_topologies_update(&work->topologies, commands, work->set));
        vulkan_finish(device, commands);
    }
    vulkan_allocate(device, (uint64_t)work->vertex_count * sizeof(packed3), "vertices", &work->vertices);
    vulkan_allocate(device, (uint64_t)work->cluster_count * sizeof(clast_box), "boxes", &work->boxes);
    vulkan_allocate(device, clast_gpu_tree_bytes(work->cluster_count), "tree", &work->nodes);
    vulkan_allocate(device, sizeof(clast_box), "bounds", &work->bounds);
    vulkan_allocate(device, clast_gpu_tree_bytes(work->cluster_count), "fitted tree", &work->kept_nodes);
    vulkan_allocate(device, clast_gpu_tree_kept_bytes(work->cluster_count), "what is kept", &work->kept);
    work->tree_bytes = clast_gpu_tree_stored_bytes(work->cluster_count);
    if (kind == VULKAN_MESH) {
        make_shape(work);
    }
    make_scene(work);
    place_camera(work);
    if (device->driver != NULL) {
        vulkan_peer_make(work);
    }
}

void vulkan_work_free(vulkan_work *work)
{
    vulkan_peer_free(work);
    clast_gpu *gpu = work->device->gpu;
    clast_gpu_buffer *const buffers[] = {
        &work->inputs, &work->places, &work->firsts,    &work->vertices, &work->clusters,  &work->boxes,
        &work->nodes,  &work->bounds, &work->rotations, &work->patterns, &work->weights,   &work->templates,
        &work->pairs,  &work->rest,   &work->positions, &work->numbers,  &work->faults,    &work->placement,
        &work->top,    &work->scene,  &work->scratch,   &work->kept,     &work->kept_nodes};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        clast_gpu_free(gpu, buffers[i]);
    }
    clast_topologies_free(gpu, &work->topologies);
    clast_template_set_destroy(work->set);
}
