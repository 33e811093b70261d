// SPDX-License-Identifier: Apache-2.0
// Passes trace and shade on a device: memory and tables at the first sample, then tiles of squares one after the other.
#include "vulkan/render.h"

#include <math.h>
#include <string.h>

#include "base/thread.h"
#include "render/path.h"
#include "shared/device_paths.h"
#include "vulkan/frame_driver.h"
#include "vulkan/frame_state.h"
#include "vulkan/lights.h"
#include "vulkan/materials.h"

_Static_assert(offsetof(clast_path_queue, tickets) == 84, "PATH_TICKETS of shaders/render/paths.glsl");
_Static_assert((int)CLAST_VIEW_COUNT_ == (int)RENDER_VIEWS, "views of clast_device_render");

#define VULKAN_PASS(pass, function) [pass] = function,
const clast_backend clast_vulkan_backend = {
    .name = "vulkan",
    .passes = {CLAST_FRAME_VULKAN_PASSES(VULKAN_PASS) VULKAN_PASS(CLAST_PASS_TRACE, clast_vulkan_trace)
                   VULKAN_PASS(CLAST_PASS_SHADE, clast_vulkan_shade)},
    .count = clast_vulkan_count_units,
    .coarse = clast_vulkan_trace_coarse,
    .forget = clast_vulkan_forget,
    .measure = clast_vulkan_measure,
    .fetch = clast_vulkan_fetch,
};

// Paths under way: enough that the longest dispatches fill a device; few where a program stands in for it, so that progress is
// told.
enum { PATHS_ON_HARDWARE = 1 << 21, PATHS_IN_SOFTWARE = 1 << 15 };

struct clast_vulkan_render {
    clast_gpu *gpu;
    clast_gpu_materials materials;
    clast_gpu_lights lights;
    clast_gpu_buffer head;  // clast_device_render
    clast_gpu_buffer queue; // clast_path_queue
    clast_gpu_buffer paths, direct, hits, shadows, lists;
    clast_gpu_buffer views[CLAST_VIEW_COUNT_];
    clast_gpu_buffer squares; // those that go on
    clast_gpu_buffer halves, noise;
    uint32_t capacity;                     // paths under way
    uint32_t moment;                       // of the shutter's that lights and head are of
    uint32_t squares_version;              // that the device has
    clast_gpu_time times[CLAST_GPU_TIMES]; // of this render
    uint32_t time_count;
};

// The push constants of shaders/render/paths.glsl.
typedef struct path_push {
    uint64_t render;
    uint32_t sample, bounce, first_square, places, list;
} path_push;

// The arrays of paths under way, and how many bytes of each a path takes.
typedef struct path_memory {
    clast_gpu_buffer *buffer;
    uint64_t bytes;
    const char *name;
} path_memory;

enum { PATH_BUFFERS = 5 };

static void list_path_memory(clast_vulkan_render *render, bool clamps, path_memory list[PATH_BUFFERS])
{
    list[0] = (path_memory){&render->paths, 16 * PATH_PIECES, "paths"};
    list[1] = (path_memory){&render->hits, 16 * HIT_PIECES, "hits of paths"};
    list[2] = (path_memory){&render->shadows, 2 * 16 * SHADOW_PIECES, "shadow rays of paths"};
    list[3] = (path_memory){&render->lists, 4 * LIST_ARRAYS, "lists of paths"};
    list[4] = (path_memory){&render->direct, clamps ? 16 : 0, "direct light of paths"};
}

static void free_paths(clast_vulkan_render *render)
{
    path_memory list[PATH_BUFFERS];
    list_path_memory(render, false, list);
    for (int i = 0; i < PATH_BUFFERS; i++) {
        clast_gpu_free(render->gpu, list[i].buffer);
    }
}

void clast_vulkan_render_destroy(clast_vulkan_render *render)
{
    if (render == NULL) {
        return;
    }
    free_paths(render);
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        clast_gpu_free(render->gpu, &render->views[view]);
    }
    clast_gpu_free(render->gpu, &render->squares);
    clast_gpu_free(render->gpu, &render->halves);
    clast_gpu_free(render->gpu, &render->noise);
    clast_gpu_free(render->gpu, &render->head);
    clast_gpu_free(render->gpu, &render->queue);
    clast_gpu_lights_free(&render->lights);
    clast_gpu_materials_free(&render->materials);
    clast_free(clast_gpu_context(render->gpu), render);
}

// -------------------------------------------------------------------------------------------------------------- memory

typedef struct view_layout {
    uint32_t channels, begins; // bits of what each number is before the first sample
} view_layout;

#define VIEW_LAYOUT(name, value, text, channels, is_float, help) [name] = {channels, is_float ? 0 : CLAST_NONE},
static const view_layout layouts[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(VIEW_LAYOUT)};

static uint32_t first_bits(int view)
{
    return view == CLAST_VIEW_DEPTH ? floatBitsToUint(INFINITY) : layouts[view].begins;
}

static uint64_t pixels_of(const clast_render_target *target)
{
    return (uint64_t)target->area.width * target->area.height;
}

// Where the target has a view, and how many bytes; null where it is not wanted, or not the device's.
static void *view_of(const clast_render_target *target, int view, uint64_t *bytes)
{
    *bytes = pixels_of(target) * layouts[view].channels * sizeof(float);
    if (view == CLAST_VIEW_SAMPLES) {
        return NULL;
    }
    return target->sums[view] != NULL ? (void *)target->sums[view] : (void *)target->firsts[view];
}

static uint64_t squares_bytes(const clast_render_target *target)
{
    return target->squares.count * sizeof(uint32_t);
}

static clast_status reserve_views(clast_vulkan_render *render, const clast_render_target *target)
{
    clast_status status = CLAST_OK;
    for (int view = 0; view < CLAST_VIEW_COUNT_ && status == CLAST_OK; view++) {
        uint64_t bytes;
        if (view_of(target, view, &bytes) == NULL) {
            clast_gpu_free(render->gpu, &render->views[view]);
        } else {
            status = clast_gpu_reserve(render->gpu, CLAST_GPU_DEVICE, bytes, "picture", &render->views[view]);
        }
    }
    return status;
}

static clast_status reserve_paths_of(clast_vulkan_render *render, bool clamps, uint64_t capacity)
{
    path_memory list[PATH_BUFFERS];
    list_path_memory(render, clamps, list);
    clast_status status = CLAST_OK;
    for (int i = 0; i < PATH_BUFFERS && status == CLAST_OK; i++) {
        if (list[i].bytes != 0) {
            status = clast_gpu_reserve(render->gpu, CLAST_GPU_DEVICE, list[i].bytes * capacity, list[i].name,
                                       list[i].buffer);
        }
    }
    return status;
}

// Tiles are whole squares. Where memory is short, they are fewer, down to some.
static clast_status reserve_paths(clast_vulkan_render *render, const clast_render_target *target)
{
    enum { SQUARES_LEAST = 16 };
    bool in_software = clast_gpu_features_of(render->gpu)->is_software;
    uint32_t most = (in_software ? PATHS_IN_SOFTWARE : PATHS_ON_HARDWARE) / SQUARE_PIXELS;
    uint32_t squares = min_uint(most, target->squares.count);
    bool clamps = target->settings.fireflies == CLAST_FIREFLIES_CLAMPED;
    clast_status status = reserve_paths_of(render, clamps, (uint64_t)squares * SQUARE_PIXELS);
    while (status == CLAST_ERROR_OUT_OF_MEMORY && squares > SQUARES_LEAST) {
        free_paths(render);
        squares = squares / 2;
        status = reserve_paths_of(render, clamps, (uint64_t)squares * SQUARE_PIXELS);
    }
    render->capacity = squares * SQUARE_PIXELS;
    return status;
}

// Kernels look up squares before they know whether there is anything to do: a group's worth more than there are.
enum { SPARE_SQUARES = PATH_GROUP / SQUARE_PIXELS };

static clast_status reserve_squares(clast_vulkan_render *render, const clast_render_target *target)
{
    clast_gpu *gpu = render->gpu;
    uint64_t bytes = squares_bytes(target);
    clast_status status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, bytes + SPARE_SQUARES * sizeof(uint32_t), "squares",
                                            &render->squares);
    if (target->halves == NULL) {
        clast_gpu_free(gpu, &render->halves);
        clast_gpu_free(gpu, &render->noise);
        return status;
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, bytes, "noise", &render->noise);
    }
    return status == CLAST_OK ? clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, 3 * sizeof(float) * pixels_of(target),
                                                  "halves of the picture", &render->halves)
                              : status;
}

static clast_status reserve(clast_vulkan_render *render, const clast_render_target *target)
{
    clast_status status = reserve_views(render, target);
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(render->gpu, CLAST_GPU_DEVICE, sizeof(clast_device_render), "render", &render->head);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(render->gpu, CLAST_GPU_DEVICE, sizeof(clast_path_queue), "queue of paths",
                                   &render->queue);
    }
    if (status == CLAST_OK) {
        status = reserve_squares(render, target);
    }
    return status == CLAST_OK ? reserve_paths(render, target) : status;
}

// ----------------------------------------------------------------------------------------------------- the first sample

static clast_device_render head_of(const clast_vulkan_render *render, const clast_frame *frame,
                                   const clast_render_target *target)
{
    const clast_vulkan_frame *device = clast_vulkan_of(frame);
    const clast_render_settings *settings = &target->settings;
    bool clamps = settings->fireflies == CLAST_FIREFLIES_CLAMPED;
    clast_device_render head = {
        .frame = store_address(clast_vulkan_frame_address(device)),
        .materials = store_address(render->materials.head.address),
        .lights = store_address(render->lights.head.address),
        .paths = store_address(render->paths.address),
        .direct = store_address(clamps ? render->direct.address : 0),
        .hits = store_address(render->hits.address),
        .shadows = store_address(render->shadows.address),
        .lists = store_address(render->lists.address),
        .queue = store_address(render->queue.address),
        .squares = store_address(render->squares.address),
        .halves = store_address(render->halves.address),
        .noise = store_address(render->noise.address),
        .capacity = render->capacity,
        .width = target->width,
        .height = target->height,
        .area_x = target->area.x,
        .area_y = target->area.y,
        .area_width = target->area.width,
        .area_height = target->area.height,
        .squares_across = target->squares.across,
        .seed = settings->seed,
        .power = target->power,
        .bounces = settings->bounces,
        .integrator = (uint32_t)settings->integrator,
        .fireflies = (uint32_t)settings->fireflies,
        .ao_distance = settings->ao_distance > 0.0 ? (float)settings->ao_distance : INFINITY,
        .rate = (float)frame->settings.rate,
        .gain = exp2f((float)settings->exposure),
    };
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        head.views[view] = store_address(render->views[view].address);
    }
    return head;
}

// Sums begin with nothing, or with those of the checkpoint that the render goes on with.
static void write_sums(clast_vulkan_render *render, clast_gpu_commands *commands, const clast_render_target *target)
{
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        uint64_t bytes;
        const void *sums = view_of(target, view, &bytes);
        if (sums != NULL && target->is_resumed) {
            clast_gpu_write(commands, &render->views[view], 0, sums, bytes);
        } else if (sums != NULL) {
            clast_gpu_fill(commands, &render->views[view], 0, bytes, first_bits(view));
        }
    }
    uint64_t bytes = 3 * sizeof(float) * pixels_of(target);
    if (target->halves != NULL && target->is_resumed) {
        clast_gpu_write(commands, &render->halves, 0, target->halves, bytes);
    } else if (target->halves != NULL) {
        clast_gpu_fill(commands, &render->halves, 0, bytes, 0);
    }
}

static void write_all(clast_vulkan_render *render, clast_gpu_commands *commands, const clast_frame *frame,
                      const clast_render_target *target)
{
    const clast_lights *lights = target->lights;
    uint32_t image = lights->image != NULL ? lights->environment.image : CLAST_NONE;
    clast_gpu_note(commands, clast_gpu_materials_update(&render->materials, commands, frame->scene, image));
    clast_gpu_note(commands,
                   clast_gpu_lights_update(&render->lights, commands, lights, render->materials.surroundings));
    clast_device_render head = head_of(render, frame, target);
    clast_gpu_write(commands, &render->head, 0, &head, sizeof head);
    clast_gpu_fill(commands, &render->queue, 0, render->queue.bytes, 0);
    clast_gpu_fill(commands, &render->squares, 0, render->squares.bytes, 0);
    write_sums(render, commands, target);
}

// Those that go on, where they are others than before.
static clast_status write_squares(clast_vulkan_render *render, const clast_render_target *target)
{
    const clast_squares *squares = &target->squares;
    if (target->is_begun && render->squares_version == squares->version) {
        return CLAST_OK;
    }
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(render->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_barrier(commands);
    clast_gpu_write(commands, &render->squares, 0, squares->active, squares->active_count * sizeof(uint32_t));
    render->squares_version = squares->version;
    return clast_gpu_finish(commands);
}

static clast_status create(clast_vulkan_frame *device)
{
    clast_vulkan_render *render = clast_allocate_zeroed(device->context, 1, sizeof *render);
    if (render == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    render->gpu = device->gpu;
    render->lights.gpu = device->gpu;
    render->materials = (clast_gpu_materials){.gpu = device->gpu, .pictures = {.gpu = device->gpu}};
    device->render = render;
    return CLAST_OK;
}

static clast_status begin_render(clast_frame *frame, const clast_render_target *target)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = device->render != NULL ? CLAST_OK : create(device);
    if (status == CLAST_OK) {
        status = reserve(device->render, target);
    }
    clast_gpu_commands *commands;
    if (status == CLAST_OK) {
        device->render->time_count = 0;
        status = clast_gpu_begin(device->gpu, &commands);
    }
    if (status == CLAST_OK) {
        clast_gpu_pass(commands, "lights");
        clast_gpu_barrier(commands); // what was submitted before reads what is written now
        write_all(device->render, commands, frame, target);
        status = clast_gpu_finish(commands);
    }
    if (status != CLAST_OK && device->render != NULL) {
        clast_gpu_materials_free(&device->render->materials);
    }
    return status;
}

// What another moment of the shutter changes: lights, and where the frame is.
static clast_status write_moment(clast_vulkan_render *render, const clast_frame *frame,
                                 const clast_render_target *target)
{
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(render->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_pass(commands, "lights");
    clast_gpu_barrier(commands);
    clast_gpu_note(commands,
                   clast_gpu_lights_update(&render->lights, commands, target->lights, render->materials.surroundings));
    clast_device_render head = head_of(render, frame, target);
    clast_gpu_write(commands, &render->head, 0, &head, sizeof head);
    return clast_gpu_finish(commands);
}

clast_status clast_vulkan_trace(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    clast_status status = CLAST_OK;
    if (!target->is_begun) {
        status = begin_render(frame, target);
    } else if (clast_vulkan_of(frame)->render->moment != target->moment) {
        status = write_moment(clast_vulkan_of(frame)->render, frame, target);
    }
    if (status == CLAST_OK) {
        clast_vulkan_of(frame)->render->moment = target->moment;
    }
    if (status == CLAST_OK) {
        status = write_squares(clast_vulkan_of(frame)->render, target);
    }
    target->is_begun = target->is_begun || status == CLAST_OK;
    return status;
}

// -------------------------------------------------------------------------------------------------------------- a tile

// How rays are traced: the constants of shaders/render/trace.glsl.
enum {
    REFILL = 8,          // of rays that go any way: invocations that wait before they take the next ones
    STEPS = 4,           // and between two looks at who waits
    TRACE_GROUPS = 4096, // that take rays: enough to fill a large device
    TRACE_GROUPS_SOFTWARE = 64,
};

// Squares of the picture whose paths are under way.
typedef struct tile {
    clast_gpu_commands *commands;
    const clast_vulkan_render *render;
    const clast_render_target *target;
    const clast_frame_driver *driver; // null: rays go through clast's own trees
    path_push push;
    uint32_t trace_groups;
    bool filtered;  // not every surface is opaque
    bool has_backs; // that eyes look through
} tile;

static clast_gpu_call call_of(const tile *tile, clast_shader shader)
{
    return (clast_gpu_call){
        .shader = shader,
        .push = &tile->push,
        .push_bytes = sizeof tile->push,
    };
}

// Over all places of the tile.
static void run_places(const tile *tile, clast_shader shader)
{
    clast_gpu_call call = call_of(tile, shader);
    call.groups = (tile->push.places + PATH_GROUP - 1) / PATH_GROUP;
    clast_gpu_run(tile->commands, &call);
}

// Over the paths of a list.
static void run_list(const tile *tile, clast_shader shader, uint32_t list)
{
    clast_gpu_call call = call_of(tile, shader);
    call.indirect = &tile->render->queue;
    call.indirect_offset = offsetof(clast_path_queue, groups) + 12 * (uint64_t)list;
    clast_gpu_run(tile->commands, &call);
}

// Rays that go much the same way.
static void trace_places(const tile *tile, clast_shader shader)
{
    if (tile->driver != NULL) {
        clast_frame_driver_trace(tile->driver, tile->commands, shader, &tile->push, sizeof tile->push,
                                 tile->push.places);
        return;
    }
    clast_gpu_call call = {
        .shader = shader,
        .constants = {PATH_TRACE_GROUP, 0, STEPS, 1, tile->filtered},
        .constant_count = 5,
        .push = &tile->push,
        .push_bytes = sizeof tile->push,
        .groups = (tile->push.places + PATH_TRACE_GROUP - 1) / PATH_TRACE_GROUP,
    };
    clast_gpu_run(tile->commands, &call);
}

// Rays that go any way.
static void trace_list(const tile *tile, clast_shader shader, uint32_t list)
{
    path_push push = tile->push;
    push.list = list;
    if (tile->driver != NULL) { // a list has no more rays than the tile has paths
        clast_frame_driver_trace(tile->driver, tile->commands, shader, &push, sizeof push, push.places);
        return;
    }
    clast_gpu_call call = {
        .shader = shader,
        .constants = {PATH_TRACE_GROUP, REFILL, STEPS, 1, tile->filtered},
        .constant_count = 5,
        .push = &push,
        .push_bytes = sizeof push,
        .indirect = &tile->render->queue,
        .indirect_offset = offsetof(clast_path_queue, trace_groups) + 12 * (uint64_t)list,
    };
    clast_gpu_run(tile->commands, &call);
}

static void run_queue(const tile *tile)
{
    clast_gpu_call call = {.shader = CLAST_SHADER_RENDER_QUEUE,
                           .constants = {tile->trace_groups},
                           .constant_count = 1,
                           .push = &tile->push,
                           .push_bytes = sizeof tile->push,
                           .groups = 1};
    clast_gpu_barrier(tile->commands);
    clast_gpu_run(tile->commands, &call);
    clast_gpu_barrier(tile->commands);
}

// How many bounces are recorded: those of the last have nothing to do where all paths have ended before.
static uint32_t most_bounces(const clast_render_target *target)
{
    switch (target->settings.integrator) {
    case CLAST_INTEGRATOR_PATH: return target->settings.bounces;
    case CLAST_INTEGRATOR_DIRECT: return 1;
    default: return 0;
    }
}

static void run_shadows(const tile *tile, uint32_t list)
{
    clast_gpu_pass(tile->commands, "shadow rays");
    trace_list(tile, CLAST_SHADER_RENDER_SHADOW, list);
}

// From a bounce to the next: shadow rays and the next rays of those paths that go on. The shadow rays of a path add to it
// one after the other.
static void run_rays(tile *tile)
{
    run_queue(tile);
    run_shadows(tile, LIST_LIGHT);
    if (tile->target->settings.integrator != CLAST_INTEGRATOR_AO) {
        clast_gpu_pass(tile->commands, "next rays");
        trace_list(tile, CLAST_SHADER_RENDER_NEXT, LIST_NEXT);
        if (tile->target->lights->has_sun) {
            clast_gpu_barrier(tile->commands);
            run_shadows(tile, LIST_SUN);
        }
    }
    clast_gpu_barrier(tile->commands);
}

// Views that only rays of the first sample give.
static bool wants_first_views(const clast_render_target *target)
{
    static const clast_view views[] = {CLAST_VIEW_DEPTH,    CLAST_VIEW_INSTANCE, CLAST_VIEW_CLUSTER,
                                       CLAST_VIEW_TRIANGLE, CLAST_VIEW_STEPS,    CLAST_VIEW_PRIMITIVE,
                                       CLAST_VIEW_SEGMENTS, CLAST_VIEW_RATE,     CLAST_VIEW_AREA};
    bool wanted = false;
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        wanted = wanted || target->sums[views[i]] != NULL || target->firsts[views[i]] != NULL;
    }
    return wanted;
}

static bool wants_surfaces(const clast_render_target *target)
{
    return target->sums[CLAST_VIEW_COLOUR] != NULL || target->sums[CLAST_VIEW_ALBEDO] != NULL ||
           target->sums[CLAST_VIEW_NORMAL] != NULL || target->sums[CLAST_VIEW_UV] != NULL;
}

static void trace_primary(const tile *tile)
{
    clast_gpu_commands *commands = tile->commands;
    clast_gpu_pass(commands, "primary rays");
    trace_places(tile, CLAST_SHADER_RENDER_PRIMARY);
    clast_gpu_barrier(commands);
    if (tile->has_backs) {
        trace_places(tile, CLAST_SHADER_RENDER_BACKS);
        clast_gpu_barrier(commands);
    }
}

static void record_tile(tile *tile)
{
    clast_gpu_commands *commands = tile->commands;
    const clast_render_target *target = tile->target;
    clast_gpu_barrier(commands); // the tile before has the same memory
    trace_primary(tile);
    if (target->sample == 0 && wants_first_views(target)) {
        clast_gpu_pass(commands, "views");
        run_places(tile, CLAST_SHADER_RENDER_VIEWS);
    }
    if (!wants_surfaces(target)) {
        return;
    }
    clast_gpu_pass(commands, "shade");
    run_places(tile, CLAST_SHADER_RENDER_SHADE);
    if (target->sums[CLAST_VIEW_COLOUR] == NULL) {
        return;
    }
    uint32_t most = most_bounces(target);
    if (target->settings.integrator == CLAST_INTEGRATOR_AO) {
        run_rays(tile);
    }
    for (uint32_t bounce = 0; bounce < most; bounce++) {
        tile->push.bounce = bounce;
        run_rays(tile);
        tile->push.bounce = bounce + 1;
        clast_gpu_pass(commands, "shade");
        run_list(tile, CLAST_SHADER_RENDER_SHADE, LIST_NEXT);
    }
    clast_gpu_barrier(commands);
    clast_gpu_pass(commands, "finish");
    run_places(tile, CLAST_SHADER_RENDER_FINISH);
}

static bool is_filtered(const clast_frame *frame)
{
    bool filtered = false;
    for (size_t i = 0; i < frame->unit_count; i++) {
        filtered = filtered || (frame->units[i].used && frame->units[i].filtered);
    }
    return filtered;
}

static bool has_backs(const clast_scene *scene)
{
    bool found = false;
    for (size_t i = 0; i < scene->material_count; i++) {
        found = found || scene->materials[i].record.double_sided == 0;
    }
    return found;
}

static clast_status submit_tile(const clast_vulkan_render *render, const clast_frame *frame,
                                const clast_render_target *target, uint32_t first, uint32_t count, uint64_t *ticket)
{
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(render->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    bool in_software = clast_gpu_features_of(render->gpu)->is_software;
    tile tile = {
        .commands = commands,
        .render = render,
        .target = target,
        .driver = clast_vulkan_of(frame)->driver,
        .push = {.render = render->head.address,
                 .sample = target->sample,
                 .first_square = first,
                 .places = count * SQUARE_PIXELS},
        .trace_groups = in_software ? TRACE_GROUPS_SOFTWARE : TRACE_GROUPS,
        .filtered = is_filtered(frame),
        .has_backs = has_backs(frame->scene),
    };
    record_tile(&tile);
    return clast_gpu_submit(commands, ticket);
}

// ------------------------------------------------------------------------------------------------------------ a sample

// Before it has begun there is nothing to bring.
clast_status clast_vulkan_fetch(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    const clast_vulkan_render *render = clast_vulkan_of(frame)->render;
    if (!target->is_begun) {
        return CLAST_OK;
    }
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(render->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_pass(commands, "read");
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        uint64_t bytes;
        void *to = view_of(target, view, &bytes);
        if (to != NULL) {
            clast_gpu_read(commands, &render->views[view], 0, to, bytes);
        }
    }
    if (target->halves != NULL) {
        clast_gpu_read(commands, &render->halves, 0, target->halves, 3 * sizeof(float) * pixels_of(target));
    }
    clast_path_queue queue;
    clast_gpu_read(commands, &render->queue, 0, &queue, sizeof queue);
    status = clast_gpu_finish(commands);
    if (status == CLAST_OK) {
        atomic_store(&target->rays, load_address(queue.rays));
        atomic_store(&target->rejected, queue.rejected);
    }
    return status;
}

// Adds up the times of the tile that was waited for.
static void add_times(clast_vulkan_render *render)
{
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t count = clast_gpu_passes(render->gpu, times);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t k = 0;
        while (k < render->time_count && strcmp(render->times[k].pass, times[i].pass) != 0) {
            k++;
        }
        if (k == render->time_count && k < CLAST_GPU_TIMES) {
            render->times[render->time_count++] = (clast_gpu_time){times[i].pass, 0.0};
        }
        if (k < render->time_count) {
            render->times[k].milliseconds += times[i].milliseconds;
        }
    }
}

uint32_t clast_vulkan_render_times(const clast_vulkan_render *render, clast_gpu_time times[CLAST_GPU_TIMES])
{
    memcpy(times, render->times, render->time_count * sizeof *times);
    return render->time_count;
}

static double milliseconds_of(const clast_vulkan_render *render, bool primary)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < render->time_count; i++) {
        bool counts = (strcmp(render->times[i].pass, "primary rays") == 0) == primary;
        sum += counts ? render->times[i].milliseconds : 0.0;
    }
    return sum;
}

// All tiles, two of them under way at a time.
static clast_status run_tiles(clast_vulkan_render *render, clast_frame *frame, clast_render_target *target)
{
    clast_squares *squares = &target->squares;
    uint32_t first = squares->done, end = first;
    uint64_t ticket = 0, before = 0;
    clast_status status = CLAST_OK;
    while (end < squares->active_count && status == CLAST_OK) {
        uint32_t count = min_uint(render->capacity / SQUARE_PIXELS, squares->active_count - end);
        status = clast_render_report(frame, target, (double)end / (double)squares->active_count);
        if (status == CLAST_OK) {
            before = ticket;
            status = submit_tile(render, frame, target, end, count, &ticket);
        }
        if (status == CLAST_OK) {
            end += count;
        }
        if (status == CLAST_OK && before != 0) {
            status = clast_gpu_wait(render->gpu, before);
            add_times(render);
        }
    }
    if (end != first) {
        clast_status waited = clast_gpu_wait(render->gpu, ticket);
        add_times(render);
        status = status == CLAST_OK ? waited : status;
    }
    clast_squares_advance(squares, end - first);
    return status;
}

// The time that the device took, in place of that for which the processor waited, where the device has a clock.
static void note_times(clast_frame *frame, const clast_vulkan_render *render, double primary, double others,
                       double waited)
{
    double traced = milliseconds_of(render, true) - primary, shaded = milliseconds_of(render, false) - others;
    if (traced + shaded > 0.0) {
        frame->milliseconds[CLAST_PASS_TRACE] += traced;
        frame->milliseconds[CLAST_PASS_SHADE] += shaded - waited; // which frame.c adds
    }
}

clast_status clast_vulkan_shade(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    clast_vulkan_render *render = clast_vulkan_of(frame)->render;
    double primary = milliseconds_of(render, true), others = milliseconds_of(render, false), start = clast_clock();
    clast_status status = run_tiles(render, frame, target);
    note_times(frame, render, primary, others, (clast_clock() - start) * 1e3);
    return status;
}

// --------------------------------------------------------------------------------------------------------------- noise

clast_status clast_vulkan_measure(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    clast_squares *squares = &target->squares;
    const clast_vulkan_render *render = clast_vulkan_of(frame)->render;
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(render->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    path_push push = {.render = render->head.address, .sample = target->sample, .places = squares->active_count};
    clast_gpu_call call = {
        .shader = CLAST_SHADER_RENDER_NOISE, .push = &push, .push_bytes = sizeof push, .groups = squares->active_count};
    clast_gpu_pass(commands, "noise");
    clast_gpu_barrier(commands);
    clast_gpu_run(commands, &call);
    clast_gpu_read(commands, &render->noise, 0, squares->noise, squares_bytes(target));
    return clast_gpu_finish(commands);
}
