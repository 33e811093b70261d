// SPDX-License-Identifier: Apache-2.0
#include "vulkan/frame_driver.h"

#include <string.h>

#include "vulkan/frame_state.h"
#include "vulkan/sums.h"

// What the driver has of a unit.
typedef struct driver_unit {
    clast_gpu_buffer firsts, indices, triangles;
    clast_driver_structure structure;
    uint64_t positions; // from which indices count
} driver_unit;

struct clast_frame_driver {
    clast_gpu *gpu;
    clast_context *context;
    clast_driver *pipeline;
    driver_unit *units; // by geometry number
    size_t unit_count, unit_capacity;
    clast_driver_job *jobs;
    size_t job_capacity;
    clast_driver_instance *instances;
    size_t instance_capacity;
    clast_driver_scene scene;
    clast_driver_scratch scratch;
    clast_gpu_buffer sums;
};

// The kernels that trace, and what they are as launches.
static const struct {
    clast_shader shader, launch;
} launches[] = {
    {CLAST_SHADER_RENDER_PRIMARY, CLAST_SHADER_RENDER_PRIMARY_DRIVER},
    {CLAST_SHADER_RENDER_BACKS, CLAST_SHADER_RENDER_BACKS_DRIVER},
    {CLAST_SHADER_RENDER_NEXT, CLAST_SHADER_RENDER_NEXT_DRIVER},
    {CLAST_SHADER_RENDER_SHADOW, CLAST_SHADER_RENDER_SHADOW_DRIVER},
};
enum {
    LAUNCHES = sizeof launches / sizeof *launches,
    SCRATCH_BYTES = 1 << 26, // of working memory, for small structures that are built together
};

// -------------------------------------------------------------------------------------------------------------- life

clast_status clast_frame_driver_create(clast_gpu *gpu, clast_frame_driver **result)
{
    *result = NULL;
    clast_context *context = clast_gpu_context(gpu);
    clast_frame_driver *driver = clast_allocate_zeroed(context, 1, sizeof *driver);
    if (driver == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    driver->gpu = gpu;
    driver->context = context;
    driver->scratch.least = SCRATCH_BYTES;
    clast_driver_desc desc = {.filter = CLAST_SHADER_DRIVER_ALPHA, .launch_count = LAUNCHES};
    for (int i = 0; i < LAUNCHES; i++) {
        desc.launches[i] = launches[i].launch;
    }
    clast_status status = clast_driver_create(gpu, &desc, &driver->pipeline);
    if (status != CLAST_OK) {
        clast_free(context, driver);
        return status;
    }
    *result = driver;
    return CLAST_OK;
}

static void free_unit(clast_gpu *gpu, driver_unit *unit)
{
    clast_driver_free(gpu, &unit->structure);
    clast_gpu_free(gpu, &unit->firsts);
    clast_gpu_free(gpu, &unit->indices);
    clast_gpu_free(gpu, &unit->triangles);
    *unit = (driver_unit){0};
}

void clast_frame_driver_destroy(clast_frame_driver *driver)
{
    if (driver == NULL) {
        return;
    }
    clast_driver_destroy(driver->pipeline);
    for (size_t i = 0; i < driver->unit_count; i++) {
        free_unit(driver->gpu, &driver->units[i]);
    }
    clast_driver_scene_free(driver->gpu, &driver->scene);
    clast_gpu_free(driver->gpu, &driver->scratch.buffer);
    clast_gpu_free(driver->gpu, &driver->sums);
    clast_free(driver->context, driver->units);
    clast_free(driver->context, driver->jobs);
    clast_free(driver->context, driver->instances);
    clast_free(driver->context, driver);
}

uint64_t clast_frame_driver_bytes(const clast_frame_driver *driver)
{
    uint64_t bytes = clast_driver_scene_bytes(&driver->scene) + driver->scratch.buffer.bytes + driver->sums.bytes;
    for (size_t i = 0; i < driver->unit_count; i++) {
        const driver_unit *unit = &driver->units[i];
        bytes += unit->firsts.bytes + unit->indices.bytes + unit->triangles.bytes + unit->structure.memory.bytes;
    }
    return bytes;
}

uint64_t clast_frame_driver_scene(const clast_frame_driver *driver)
{
    return driver->scene.top.address;
}

// ------------------------------------------------------------------------------------------------------------- units

// Where the positions of a unit lie and how many they are: those of the frame or, where its source keeps them, the array
// that they are in.
static clast_status find_positions(const clast_frame *frame, size_t number, uint64_t *address, uint64_t *count)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    const clast_frame_unit *unit = &frame->units[number];
    *address = device->units[number].vertices.address;
    *count = unit->vertex_count;
    if (unit->vertex_count != 0) {
        return CLAST_OK;
    }
    const clast_cluster_record first = {.unit = (uint32_t)number};
    const uint8_t *place = (const uint8_t *)clast_source_of(unit->unit)->resident(unit->unit, &first);
    clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST];
    uint32_t array_count = clast_source_of(unit->unit)->arrays(unit->unit, arrays);
    for (uint32_t i = 0; i < array_count && place != NULL; i++) {
        const uint8_t *data = arrays[i].data;
        if (arrays[i].bytes != 0 && place >= data && place < data + arrays[i].bytes &&
            (size_t)(place - data) % sizeof(packed3) == 0) {
            *address = load_address(device->records[number].arrays[i]);
            *count = arrays[i].bytes / sizeof(packed3);
            return CLAST_OK;
        }
    }
    return clast_fail(frame->context, CLAST_ERROR_UNSUPPORTED,
                      "vulkan: the driver's structures cannot have geometry %zu: its positions lie apart", number);
}

static clast_status make_unit_room(clast_frame *frame, size_t number, driver_unit *own, clast_driver_job *job)
{
    clast_gpu *gpu = clast_vulkan_of(frame)->gpu;
    const clast_frame_unit *unit = &frame->units[number];
    uint64_t triangles = unit->sum.triangles, vertices = 0;
    clast_status status = find_positions(frame, number, &own->positions, &vertices);
    if (status == CLAST_OK && (triangles > UINT32_MAX || vertices > UINT32_MAX)) {
        status = clast_fail(frame->context, CLAST_ERROR_LIMIT, "vulkan: geometry %zu has too many triangles", number);
    }
    if (status == CLAST_OK) {
        status = clast_vulkan_renew(frame, (unit->record_count + 1) * sizeof(uint32_t), "first triangles of clusters",
                                    &own->firsts);
    }
    if (status == CLAST_OK) {
        status = clast_vulkan_renew(frame, 3 * triangles * sizeof(uint32_t), "the driver's indices", &own->indices);
    }
    if (status == CLAST_OK) {
        status = clast_vulkan_renew(frame, triangles * sizeof(uint32_t), "the driver's triangles", &own->triangles);
    }
    if (status == CLAST_OK) {
        status = clast_driver_reserve(gpu,
                                      &(clast_driver_structure_desc){.build = CLAST_DRIVER_FAST_TRACE,
                                                                     .triangle_count = (uint32_t)triangles,
                                                                     .vertex_count = (uint32_t)vertices},
                                      &own->structure);
    }
    job->structure = &own->structure;
    job->triangles = (clast_driver_triangles){.positions = own->positions,
                                              .indices = own->indices.address,
                                              .vertex_count = (uint32_t)vertices,
                                              .triangle_count = (uint32_t)triangles};
    return status;
}

static bool is_built(const clast_frame *frame, size_t number)
{
    const clast_frame_unit *unit = &frame->units[number];
    return unit->used && unit->change != CLAST_CHANGE_NOTHING && unit->record_count != 0;
}

static clast_status make_room(clast_frame *frame, size_t *job_count)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_frame_driver *driver = device->driver;
    clast_context *context = driver->context;
    clast_status status = CLAST_RESERVE(context, driver->units, driver->unit_capacity, frame->unit_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, driver->jobs, driver->job_capacity, frame->unit_count);
    }
    while (status == CLAST_OK && driver->unit_count < frame->unit_count) {
        driver->units[driver->unit_count++] = (driver_unit){0};
    }
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        if (!frame->units[i].used || frame->units[i].record_count == 0) {
            free_unit(driver->gpu, &driver->units[i]);
        } else if (is_built(frame, i)) {
            driver->jobs[*job_count] = (clast_driver_job){0};
            status = make_unit_room(frame, i, &driver->units[i], &driver->jobs[(*job_count)++]);
        }
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(driver->gpu, CLAST_GPU_DEVICE, *job_count * clast_gpu_sums_scratch(1),
                                   "sums of triangles", &driver->sums);
    }
    return status;
}

// The push constants of shaders/driver/counts.comp.
typedef struct counts_push {
    uint64_t records, triangles;
    uint32_t count;
} counts_push;

static void count_triangles(const clast_frame *frame, clast_gpu_commands *commands, size_t number)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    counts_push push = {.records = device->units[number].records.address,
                        .triangles = device->driver->units[number].firsts.address,
                        .count = device->units[number].record_count};
    clast_gpu_run(commands,
                  &(clast_gpu_call){.shader = CLAST_SHADER_DRIVER_COUNTS,
                                    .push = &push,
                                    .push_bytes = sizeof push.records + sizeof push.triangles + sizeof push.count,
                                    .groups = ((uint64_t)push.count + 255) / 256});
}

static void sum_triangles(const clast_frame *frame, clast_gpu_commands *commands, size_t number, uint64_t scratch)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_gpu_columns column = {.address = device->driver->units[number].firsts.address};
    clast_gpu_sums(commands, &(clast_gpu_sums_desc){.from = column,
                                                    .to = column,
                                                    .scratch = scratch,
                                                    .count = device->units[number].record_count,
                                                    .columns = 1});
}

static void make_triangles(const clast_frame *frame, clast_gpu_commands *commands, size_t number)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    const clast_vulkan_unit *unit = &device->units[number];
    const driver_unit *own = &device->driver->units[number];
    clast_driver_make_triangles(commands,
                                &(clast_driver_clusters){.clusters = unit->clusters.address,
                                                         .places = unit->places.address,
                                                         .firsts = own->firsts.address,
                                                         .positions = own->positions,
                                                         .count = unit->record_count},
                                own->indices.address, own->triangles.address);
}

clast_status clast_frame_driver_build_units(clast_frame *frame, clast_gpu_commands *commands)
{
    clast_frame_driver *driver = clast_vulkan_of(frame)->driver;
    size_t job_count = 0, job = 0;
    clast_status status = make_room(frame, &job_count);
    if (status != CLAST_OK || job_count == 0) {
        return status;
    }
    clast_gpu_pass(commands, "blas");
    clast_gpu_barrier(commands);
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (is_built(frame, i)) {
            count_triangles(frame, commands, i);
        }
    }
    clast_gpu_barrier(commands);
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (is_built(frame, i)) {
            sum_triangles(frame, commands, i, driver->sums.address + job++ * clast_gpu_sums_scratch(1));
        }
    }
    clast_gpu_barrier(commands);
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (is_built(frame, i)) {
            make_triangles(frame, commands, i);
        }
    }
    clast_gpu_barrier(commands);
    clast_driver_build_all(commands, driver->jobs, job_count, &driver->scratch);
    clast_gpu_barrier(commands);
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------- instances

clast_status clast_frame_driver_build_scene(clast_frame *frame, clast_gpu_commands *commands)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_frame_driver *driver = device->driver;
    clast_status status = CLAST_RESERVE(driver->context, driver->instances, driver->instance_capacity,
                                        frame->instance_count);
    for (size_t i = 0; i < frame->instance_count && status == CLAST_OK; i++) {
        const clast_frame_instance *instance = &frame->instances[i];
        const driver_unit *unit = &driver->units[instance->unit];
        driver->instances[i] = (clast_driver_instance){.structure = &unit->structure,
                                                       .positions = unit->positions,
                                                       .indices = unit->indices.address,
                                                       .triangles = unit->triangles.address,
                                                       .to_world = instance->to_world,
                                                       .id = instance->scene_instance,
                                                       .filtered = frame->units[instance->unit].filtered};
    }
    if (status == CLAST_OK) {
        clast_driver_scene_build(commands, driver->instances, frame->instance_count, CLAST_DRIVER_FAST_TRACE,
                                 &driver->scene);
        clast_gpu_barrier(commands);
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- rays

void clast_frame_driver_trace(const clast_frame_driver *driver, clast_gpu_commands *commands, clast_shader shader,
                              const void *push, uint32_t push_bytes, uint32_t count)
{
    uint32_t launch = 0;
    while (launch + 1 < LAUNCHES && launches[launch].shader != shader) {
        launch++;
    }
    clast_driver_launch(commands, driver->pipeline, launch, push, push_bytes, count);
}
