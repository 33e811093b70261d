// SPDX-License-Identifier: Apache-2.0
// Pass occlude: what hides behind what. A coarse pass of the same frame traces the scene at the least rate and keeps the
// farthest depths that it saw; an instance that lies behind them is hidden. So a frame's picture does not depend on the
// frames before. Edges compare themselves with those depths too (occlusion.c). Nothing is done where no unit adapts, where nothing
// can hide anything, or where being hidden changes nothing.
//
// The depths err to the far side: to them comes how far a unit may be from its coarse form; each is the farthest of as many
// neighbours as that may be in the picture, and one more; transparent surfaces, and backs of triangles, hide nothing.
#include <math.h>

#include "base/thread.h"
#include "frame/occlude.h"
#include "shared/camera.h"
#include "shared/transform.h"

enum {
    PIXELS = 8,      // of the picture, to a side of a depth
    TILE = 8,        // depths, to a side: rays that go together
    LOOKED_AT = 32,  // depths, to a side, that a box is compared with
    RADIUS_MOST = 4, // depths that a surface may be off
    INSTANCE_GRAIN = 64,
};

// All around, depths are no distances from a plane, and parallel rays through a lens are not those of a pinhole.
static bool has_depths(const clast_camera *camera)
{
    bool parallel = camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    return camera->projection != CLAST_PROJECTION_PANORAMA && !(parallel && camera->lens_radius > 0.0f);
}

// How many depths a surface may be off that is not where it was seen, or that a lens sees past: at that depth, by so much.
static float radius_of(const clast_frame *frame, float depth, float slack)
{
    const clast_camera *camera = &frame->settings.rate_camera;
    float pixels = (slack + camera->lens_radius) * (float)frame->settings.height / (2.0f * camera->vertical_extent);
    bool parallel = camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    return floorf(pixels / ((float)PIXELS * (parallel ? 1.0f : depth)));
}

// Whether an instance is near enough to its coarse form, even where it is farthest, to hide anything.
static bool may_hide(const clast_frame *frame, const clast_frame_instance *instance)
{
    clast_box_extent extent = clast_box_extent_of(&frame->settings.rate_camera, &instance->bounds);
    float slack = clast_frame_slack(frame, instance);
    return !frame->units[instance->unit].filtered && !instance->hidden && is_finite1(slack) &&
           radius_of(frame, extent.farthest, slack) <= (float)RADIUS_MOST;
}

static bool is_wanted(const clast_frame *frame)
{
    bool adapts = false, hides = false;
    for (size_t i = 0; i < frame->unit_count; i++) {
        adapts = adapts || (frame->units[i].used && clast_source_of(frame->units[i].unit)->adapts);
    }
    bool matters = adapts && frame->settings.hidden_fraction < 1.0 && frame->settings.rate > 0.0;
    bool several = frame->instance_count > 1 || clast_occlusion_is_wanted(frame);
    for (size_t i = 0; i < frame->instance_count && matters && several && !hides; i++) {
        hides = may_hide(frame, &frame->instances[i]);
    }
    return hides && has_depths(&frame->settings.rate_camera);
}

// ---------------------------------------------------------------------------------------------------- the coarse scene

static clast_status make_unit(clast_frame *frame, clast_frame_unit *unit, float rate)
{
    double fit_milliseconds = 0.0;
    clast_status status = clast_unit_settle(frame, unit, rate);
    status = status == CLAST_OK ? clast_unit_emit(frame, unit) : status;
    status = status == CLAST_OK ? clast_unit_fill(frame, unit, &fit_milliseconds) : status;
    status = status == CLAST_OK ? clast_unit_refit(frame, unit) : status;
    return status == CLAST_OK ? clast_unit_build(unit) : status;
}

// A unit that does not adapt is made as it will be, one that does has a coarse twin.
static clast_status make_coarse(clast_frame *frame, size_t number)
{
    clast_frame_unit *unit = &frame->units[number], *twin = &frame->coarse[number];
    if (!unit->used) {
        return CLAST_OK;
    }
    if (!clast_source_of(unit->unit)->adapts) {
        return make_unit(frame, unit, (float)frame->settings.rate);
    }
    twin->unit = unit->unit;
    twin->view = unit->view;
    twin->pose = unit->pose;
    twin->counted = false;
    if (twin->made_serial != unit->unit->serial) {
        twin->made_serial = unit->unit->serial;
        twin->made = false;
    }
    return make_unit(frame, twin, CLAST_RATE_LEAST);
}

static const clast_frame_unit *coarse_of(const clast_frame *frame, uint32_t unit)
{
    return clast_source_of(frame->units[unit].unit)->adapts ? &frame->coarse[unit] : &frame->units[unit];
}

static clast_status build_tlas(clast_frame *frame)
{
    clast_status status = CLAST_RESERVE(frame->context, frame->tlas_instances, frame->tlas_instance_capacity,
                                        frame->instance_count);
    if (status == CLAST_OK && frame->coarse_tlas == NULL) {
        status = clast_tlas_create(frame->context, &frame->coarse_tlas);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < frame->instance_count; i++) {
        const clast_frame_instance *instance = &frame->instances[i];
        const clast_frame_unit *unit = coarse_of(frame, instance->unit);
        bool hides = unit->record_count != 0 && !frame->units[instance->unit].filtered;
        clast_tlas_instance *to = &frame->tlas_instances[i];
        *to = (clast_tlas_instance){.blas = hides ? unit->blas : NULL, .id = (uint32_t)i};
        memcpy(to->transform, &instance->to_world, sizeof to->transform);
    }
    return clast_tlas_build(frame->coarse_tlas, frame->tlas_instances, frame->instance_count, CLAST_BUILD_FAST);
}

static clast_status make_scene(clast_frame *frame)
{
    clast_status status = CLAST_RESERVE(frame->context, frame->coarse, frame->coarse_capacity, frame->unit_count);
    while (status == CLAST_OK && frame->coarse_count < frame->unit_count) {
        frame->coarse[frame->coarse_count++] = (clast_frame_unit){0};
    }
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        status = make_coarse(frame, i);
    }
    return status == CLAST_OK ? build_tlas(frame) : status;
}

// ------------------------------------------------------------------------------------------------------------- depths

static size_t pyramid_size(uint32_t width, uint32_t height)
{
    size_t size = (size_t)width * height;
    while (width > 1 || height > 1) {
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        size += (size_t)width * height;
    }
    return size;
}

static clast_status begin_depths(clast_frame *frame)
{
    clast_depth_pyramid *pyramid = &frame->pyramid;
    uint32_t width = (frame->settings.width + PIXELS - 1) / PIXELS;
    uint32_t height = (frame->settings.height + PIXELS - 1) / PIXELS;
    pyramid->width = width > 0 ? width : 1;
    pyramid->height = height > 0 ? height : 1;
    size_t count = (size_t)pyramid->width * pyramid->height;
    pyramid->first = 2 * count; // what was traced comes before the levels: depths, and how many depths they may be off
    return CLAST_RESERVE(frame->context, pyramid->depths, pyramid->capacity,
                         pyramid->first + pyramid_size(pyramid->width, pyramid->height));
}

// What a ray saw: the depth, and how far off it may be in the picture.
typedef struct seen_depth {
    float depth, radius;
} seen_depth;

static seen_depth depth_of(const clast_frame *frame, const clast_camera_ray *ray, const clast_hit *hit)
{
    const clast_camera *camera = &frame->settings.rate_camera;
    const float *d = ray->direction.v, *n = hit->normal;
    if (hit->instance == CLAST_NONE || !(n[0] * d[0] + n[1] * d[1] + n[2] * d[2] < 0.0f)) {
        return (seen_depth){INFINITY, 0.0f};
    }
    float depth = camera_depth(*camera, *ray, hit->t);
    float slack = clast_frame_slack(frame, &frame->instances[hit->instance]);
    float radius = radius_of(frame, depth, slack);
    return radius <= (float)RADIUS_MOST ? (seen_depth){depth + slack, radius} : (seen_depth){INFINITY, 0.0f};
}

// The rays of a tile; those beyond the picture's edge go there too.
static void make_rays(const clast_frame *frame, uint32_t left, uint32_t top, clast_camera_ray from[TILE * TILE],
                      clast_ray rays[TILE * TILE])
{
    const clast_depth_pyramid *pyramid = &frame->pyramid;
    for (uint32_t i = 0; i < TILE * TILE; i++) {
        float x = ((float)(left + i % TILE) + 0.5f) / (float)pyramid->width;
        float y = ((float)(top + i / TILE) + 0.5f) / (float)pyramid->height;
        from[i] = camera_ray(frame->settings.rate_camera, x, y);
        memcpy(rays[i].origin, from[i].origin.v, sizeof rays[i].origin);
        memcpy(rays[i].direction, from[i].direction.v, sizeof rays[i].direction);
        rays[i].t_min = from[i].t_min;
        rays[i].t_max = from[i].t_max;
    }
}

static void keep_depths(const clast_frame *frame, uint32_t left, uint32_t top, const clast_camera_ray from[TILE * TILE],
                        const clast_hit hits[TILE * TILE])
{
    const clast_depth_pyramid *pyramid = &frame->pyramid;
    size_t count = (size_t)pyramid->width * pyramid->height;
    for (uint32_t i = 0; i < TILE * TILE; i++) {
        uint32_t x = left + i % TILE, y = top + i / TILE;
        if (x < pyramid->width && y < pyramid->height) {
            size_t at = (size_t)y * pyramid->width + x;
            seen_depth seen = depth_of(frame, &from[i], &hits[i]);
            pyramid->depths[at] = seen.depth;
            pyramid->depths[count + at] = seen.radius;
        }
    }
}

static uint32_t tiles_across(const clast_depth_pyramid *pyramid)
{
    return (pyramid->width + TILE - 1) / TILE;
}

static size_t tile_count(const clast_depth_pyramid *pyramid)
{
    return (size_t)tiles_across(pyramid) * ((pyramid->height + TILE - 1) / TILE);
}

static void trace_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const clast_frame *frame = data;
    uint32_t across = tiles_across(&frame->pyramid);
    for (size_t i = begin; i < end; i++) {
        uint32_t left = (uint32_t)(i % across) * TILE, top = (uint32_t)(i / across) * TILE;
        clast_camera_ray from[TILE * TILE];
        clast_ray rays[TILE * TILE];
        clast_hit hits[TILE * TILE];
        make_rays(frame, left, top, from, rays);
        clast_trace_closest(frame->coarse_tlas, rays, TILE * TILE, NULL, hits);
        keep_depths(frame, left, top, from, hits);
    }
}

// Where another device makes the frame, it traces all rays at once.
typedef struct coarse_rays {
    clast_camera_ray *from;
    clast_ray *rays;
    clast_hit *hits;
} coarse_rays;

static void trace_all(clast_frame *frame, const coarse_rays *r, clast_status *status)
{
    size_t tiles = tile_count(&frame->pyramid);
    uint32_t across = tiles_across(&frame->pyramid);
    for (size_t i = 0; i < tiles; i++) {
        make_rays(frame, (uint32_t)(i % across) * TILE, (uint32_t)(i / across) * TILE, r->from + i * TILE * TILE,
                  r->rays + i * TILE * TILE);
    }
    *status = frame->backend->coarse(frame, r->rays, tiles * TILE * TILE, r->hits);
    for (size_t i = 0; i < tiles && *status == CLAST_OK; i++) {
        keep_depths(frame, (uint32_t)(i % across) * TILE, (uint32_t)(i / across) * TILE, r->from + i * TILE * TILE,
                    r->hits + i * TILE * TILE);
    }
}

static clast_status trace_elsewhere(clast_frame *frame)
{
    size_t count = tile_count(&frame->pyramid) * TILE * TILE;
    coarse_rays r = {.from = clast_allocate(frame->context, count, sizeof *r.from),
                     .rays = clast_allocate(frame->context, count, sizeof *r.rays),
                     .hits = clast_allocate(frame->context, count, sizeof *r.hits)};
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (r.from != NULL && r.rays != NULL && r.hits != NULL) {
        trace_all(frame, &r, &status);
    }
    clast_free(frame->context, r.from);
    clast_free(frame->context, r.rays);
    clast_free(frame->context, r.hits);
    return status;
}

static clast_status find_depths(clast_frame *frame)
{
    if (frame->backend != NULL && frame->backend->coarse != NULL) {
        return trace_elsewhere(frame);
    }
    clast_status status = make_scene(frame);
    if (status == CLAST_OK) {
        clast_parallel_for(frame->context, tile_count(&frame->pyramid), 1, trace_range, frame);
    }
    return status;
}

// The farthest of the places [left, right) x [top, bottom) of a level, as far as they are there.
static float farthest(const float *level, int64_t width, int64_t height, int64_t left, int64_t top, int64_t right,
                      int64_t bottom)
{
    float most = 0.0f;
    for (int64_t y = top > 0 ? top : 0; y < bottom && y < height; y++) {
        for (int64_t x = left > 0 ? left : 0; x < right && x < width; x++) {
            most = max1(most, level[y * width + x]);
        }
    }
    return most;
}

// The finest level: the farthest of as many neighbours as any that lies so near may be off, and one more.
static void settle_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const clast_depth_pyramid *pyramid = data;
    int64_t width = pyramid->width, height = pyramid->height;
    const float *from = pyramid->depths, *radii = from + width * height;
    float *to = pyramid->depths + pyramid->first;
    for (int64_t y = (int64_t)begin; y < (int64_t)end; y++) {
        for (int64_t x = 0; x < width; x++) {
            int64_t r = 1 + (int64_t)farthest(radii, width, height, x - RADIUS_MOST, y - RADIUS_MOST,
                                              x + RADIUS_MOST + 1, y + RADIUS_MOST + 1);
            to[y * width + x] = farthest(from, width, height, x - r, y - r, x + r + 1, y + r + 1);
        }
    }
}

static void build_levels(clast_frame *frame)
{
    clast_depth_pyramid *pyramid = &frame->pyramid;
    int64_t width = pyramid->width, height = pyramid->height;
    const float *from;
    float *to = pyramid->depths + pyramid->first;
    clast_parallel_for(frame->context, pyramid->height, TILE, settle_range, pyramid);
    pyramid->level_count = 1;
    while (width > 1 || height > 1) {
        from = to;
        to += width * height;
        int64_t wide = (width + 1) / 2, high = (height + 1) / 2;
        for (int64_t i = 0; i < wide * high; i++) {
            int64_t x = i % wide, y = i / wide;
            to[i] = farthest(from, width, height, 2 * x, 2 * y, 2 * x + 2, 2 * y + 2);
        }
        width = wide;
        height = high;
        pyramid->level_count++;
    }
}

// -------------------------------------------------------------------------------------------------------------- boxes

float clast_frame_slack(const clast_frame *frame, const clast_frame_instance *instance)
{
    const clast_frame_unit *unit = &frame->units[instance->unit];
    const clast_source *source = clast_source_of(unit->unit);
    float slack = source->deviation != NULL ? source->deviation(unit->unit, &unit->pose) : 0.0f;
    // The longest that a unit length becomes: its square is the largest eigenvalue of the map's square, which is at most a
    // row's sum (Gershgorin); exactly that where lengths are scaled alike.
    float most = 0.0f;
    for (uint32_t i = 0; i < 3; i++) {
        float sum = 0.0f;
        for (uint32_t j = 0; j < 3; j++) {
            float product = 0.0f;
            for (uint32_t k = 0; k < 3; k++) {
                product += instance->to_world.rows[k].v[i] * instance->to_world.rows[k].v[j];
            }
            sum += abs1(product);
        }
        most = max1(most, sum);
    }
    return slack * sqrtf(most);
}

clast_box_extent clast_box_extent_of(const clast_camera *camera, const clast_box *box)
{
    clast_box_extent e = {1.0f, 1.0f, 0.0f, 0.0f, INFINITY, -INFINITY, true};
    bool parallel = camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    for (uint32_t corner = 0; corner < 8; corner++) {
        vec3 away;
        for (uint32_t axis = 0; axis < 3; axis++) {
            away[axis] = (corner >> axis & 1) != 0 ? box->upper.v[axis] : box->lower.v[axis];
        }
        away = away - load3(camera->position);
        float depth = dot3(away, load3(camera->forward));
        float scale = 0.5f / (camera->vertical_extent * (parallel ? 1.0f : depth));
        float x = 0.5f + dot3(away, load3(camera->right)) * scale / camera->aspect;
        float y = 0.5f - dot3(away, load3(camera->up)) * scale;
        e.sound = e.sound && depth > camera->near_plane && depth > 0.0f && is_finite1(x) && is_finite1(y);
        e.left = min1(e.left, x);
        e.right = max1(e.right, x);
        e.top = min1(e.top, y);
        e.bottom = max1(e.bottom, y);
        e.nearest = min1(e.nearest, depth);
        e.farthest = max1(e.farthest, depth);
    }
    return e;
}

static bool is_behind(const clast_frame *frame, const clast_box *box)
{
    const clast_depth_pyramid *pyramid = &frame->pyramid;
    clast_box_extent e = clast_box_extent_of(&frame->settings.rate_camera, box);
    if (!e.sound || !is_finite1(e.nearest)) {
        return false;
    }
    int64_t width = pyramid->width, height = pyramid->height;
    int64_t left = (int64_t)(clamp1(e.left, 0.0f, 1.0f) * (float)width);
    int64_t right = (int64_t)(clamp1(e.right, 0.0f, 1.0f) * (float)width) + 1;
    int64_t top = (int64_t)(clamp1(e.top, 0.0f, 1.0f) * (float)height);
    int64_t bottom = (int64_t)(clamp1(e.bottom, 0.0f, 1.0f) * (float)height) + 1;
    const float *level = pyramid->depths + pyramid->first;
    for (uint32_t i = 1; i < pyramid->level_count && (right - left > LOOKED_AT || bottom - top > LOOKED_AT); i++) {
        level += width * height;
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        left /= 2;
        top /= 2;
        right = (right + 1) / 2;
        bottom = (bottom + 1) / 2;
    }
    return e.nearest > farthest(level, width, height, left, top, right, bottom) * 1.0001f;
}

static void hide_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_frame *frame = data;
    for (size_t i = begin; i < end; i++) {
        clast_frame_instance *instance = &frame->instances[i];
        bool adapts = clast_source_of(frame->units[instance->unit].unit)->adapts;
        instance->occluded = adapts && !instance->hidden && is_behind(frame, &instance->bounds);
        instance->hidden = instance->hidden || instance->occluded;
    }
}

void clast_frame_free_coarse(clast_frame *frame)
{
    clast_tlas_destroy(frame->coarse_tlas);
    frame->coarse_tlas = NULL;
    for (size_t i = 0; i < frame->coarse_count; i++) {
        clast_unit_free(frame->context, &frame->coarse[i]);
    }
    clast_free(frame->context, frame->coarse);
    clast_free(frame->context, frame->pyramid.depths);
    clast_free(frame->context, frame->pyramid.rows);
    frame->coarse = NULL;
    frame->coarse_count = frame->coarse_capacity = 0;
    frame->pyramid = (clast_depth_pyramid){0};
}

clast_status clast_cpu_occlude(clast_frame *frame, void *target)
{
    (void)target;
    frame->occlude_bytes = 0;
    frame->pyramid.level_count = 0;
    frame->pyramid.row_count = 0;
    if (!is_wanted(frame)) {
        clast_frame_free_coarse(frame);
        return CLAST_OK;
    }
    clast_status status = begin_depths(frame);
    status = status == CLAST_OK ? clast_occlusion_begin(frame) : status;
    status = status == CLAST_OK ? clast_frame_find_minima(frame) : status;
    frame->occlude_bytes = clast_tlas_memory(frame->instance_count) +
                           (frame->pyramid.capacity + frame->pyramid.row_capacity) * sizeof *frame->pyramid.depths;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        bool twin = unit->used && clast_source_of(unit->unit)->adapts;
        frame->occlude_bytes += twin ? unit->minimum.bytes : 0;
    }
    status = status == CLAST_OK ? clast_frame_check_minimum(frame) : status;
    status = status == CLAST_OK ? find_depths(frame) : status;
    if (status != CLAST_OK) {
        return status;
    }
    build_levels(frame);
    clast_parallel_for(frame->context, frame->instance_count, INSTANCE_GRAIN, hide_range, frame);
    status = clast_frame_view_units(frame);
    if (status == CLAST_OK) {
        clast_occlusion_find(frame);
    }
    return status;
}
