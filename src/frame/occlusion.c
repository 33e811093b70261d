// SPDX-License-Identifier: Apache-2.0
// Depths that edges compare themselves with: of each place of the pyramid, the farthest within more and more places around it
// (shared/occlusion.h). Views of units tell where they are, and have a key of those that a unit can come to see: so what moves
// elsewhere, or behind a unit, changes nothing of it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/thread.h"
#include "frame/occlude.h"
#include "shared/occlusion.h"

enum {
    PLACES_MOST = 1 << 18, // larger pictures use a coarser level
    ROW_GRAIN = 8,
    UNIT_GRAIN = 4,
};

// Units with several instances are as fine as the nearest needs them, and edges of some metrics are not measured in the picture.
static bool compares(const clast_frame_unit *unit)
{
    return unit->used && clast_source_of(unit->unit)->hides_edges && unit->view.alone != 0 && unit->view.hidden == 0 &&
           unit->view.metric != CLAST_METRIC_FIXED && unit->view.projection != CLAST_PROJECTION_PANORAMA;
}

bool clast_occlusion_is_wanted(const clast_frame *frame)
{
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (compares(&frame->units[i])) {
            return true;
        }
    }
    return false;
}

// A level of the pyramid.
typedef struct pyramid_level {
    const float *depths;
    size_t width, height;
    float scale; // its places are as many of the finest level's
} pyramid_level;

// The finest that has not too many places.
static pyramid_level level_of(const clast_depth_pyramid *pyramid)
{
    pyramid_level level = {pyramid->depths + pyramid->first, pyramid->width, pyramid->height, 1.0f};
    while (level.width * level.height > PLACES_MOST) {
        level.depths += level.width * level.height;
        level.width = (level.width + 1) / 2;
        level.height = (level.height + 1) / 2;
        level.scale *= 2.0f;
    }
    return level;
}

clast_status clast_occlusion_begin(clast_frame *frame)
{
    clast_depth_pyramid *pyramid = &frame->pyramid;
    if (!clast_occlusion_is_wanted(frame)) {
        return CLAST_OK;
    }
    pyramid_level level = level_of(pyramid);
    size_t count = level.width * level.height;
    // the rows, and what is found of all places while these are made
    clast_status status = CLAST_RESERVE(frame->context, pyramid->rows, pyramid->row_capacity,
                                        count * (OCCLUSION_DEPTHS + 2));
    pyramid->row_count = status == CLAST_OK ? count : 0;
    return status;
}

// --------------------------------------------------------------------------------------------------------------- rows

// From depths within a radius to those within a larger one: first along rows, then along columns.
typedef struct row_job {
    size_t width, height;
    uint32_t number, step;
    float *found, *across, *rows;
} row_job;

static void take_farther(float *to, const float *from, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        to[i] = max1(to[i], from[i]);
    }
}

static void across_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const row_job *job = data;
    for (size_t y = begin; y < end; y++) {
        const float *from = job->found + y * job->width;
        float *to = job->across + y * job->width;
        memcpy(to, from, job->width * sizeof *to);
        for (size_t d = 1; d <= job->step && d < job->width; d++) {
            take_farther(to + d, from, job->width - d);
            take_farther(to, from + d, job->width - d);
        }
    }
}

static void down_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const row_job *job = data;
    for (size_t y = begin; y < end; y++) {
        float *to = job->found + y * job->width;
        size_t first = y > job->step ? y - job->step : 0, last = y + job->step + 1;
        memcpy(to, job->across + first * job->width, job->width * sizeof *to);
        for (size_t from = first + 1; from < last && from < job->height; from++) {
            take_farther(to, job->across + from * job->width, job->width);
        }
        for (size_t x = 0; x < job->width; x++) {
            job->rows[(y * job->width + x) * OCCLUSION_DEPTHS + job->number] = to[x];
        }
    }
}

static void make_rows(clast_frame *frame, const pyramid_level *level)
{
    clast_depth_pyramid *pyramid = &frame->pyramid;
    size_t count = level->width * level->height;
    float *found = pyramid->rows + count * OCCLUSION_DEPTHS;
    for (size_t i = 0; i < count; i++) {
        found[i] = min1(level->depths[i], 1e30f); // nothing is there
    }
    for (uint32_t i = 0; i < OCCLUSION_DEPTHS; i++) {
        row_job job = {level->width, level->height, i, occlusion_step(i), found, found + count, pyramid->rows};
        clast_parallel_for(frame->context, level->height, ROW_GRAIN, across_range, &job);
        clast_parallel_for(frame->context, level->height, ROW_GRAIN, down_range, &job);
    }
    pyramid->row_key = XXH3_64bits_withSeed(level->depths, count * sizeof *level->depths, level->width);
}

// -------------------------------------------------------------------------------------------------------------- views

// The places that a unit's edges look at, with those around them.
typedef struct place_range {
    size_t left, top, right, bottom;
} place_range;

static size_t place_at(float part, float places, size_t most)
{
    size_t place = (size_t)(clamp1(part, 0.0f, 1.0f) * places);
    return place < most ? place : most;
}

static place_range places_of(const pyramid_level *level, const clast_depth_pyramid *pyramid,
                             const clast_box_extent *extent)
{
    if (!extent->sound) {
        return (place_range){0, 0, level->width, level->height};
    }
    float across = (float)pyramid->width / level->scale, down = (float)pyramid->height / level->scale;
    size_t left = place_at(extent->left, across, level->width), top = place_at(extent->top, down, level->height);
    size_t more = OCCLUSION_RADIUS + 1; // and the place itself
    size_t right = place_at(extent->right, across, level->width) + more + 1;
    size_t bottom = place_at(extent->bottom, down, level->height) + more + 1;
    return (place_range){left > more ? left - more : 0, top > more ? top - more : 0,
                         right < level->width ? right : level->width, bottom < level->height ? bottom : level->height};
}

// A key of the depths in a range that are less than `farthest`: others hide nothing. Gives the least of all.
static float key_of(const pyramid_level *level, place_range range, float farthest, uint64_t *key)
{
    float nearest = INFINITY, some[256];
    uint64_t sum = 0;
    for (size_t y = range.top; y < range.bottom; y++) {
        for (size_t x = range.left; x < range.right; x += sizeof some / sizeof *some) {
            size_t count = range.right - x < sizeof some / sizeof *some ? range.right - x : sizeof some / sizeof *some;
            for (size_t i = 0; i < count; i++) {
                float depth = level->depths[y * level->width + x + i];
                some[i] = min1(depth, farthest);
                nearest = min1(nearest, depth);
            }
            sum = XXH3_64bits_withSeed(some, count * sizeof *some, sum + y * level->width + x);
        }
    }
    *key = sum;
    return nearest;
}

static void look_behind(clast_frame *frame, const clast_frame_instance *instance, const pyramid_level *level)
{
    clast_frame_unit *unit = &frame->units[instance->unit];
    clast_source_view *view = &unit->view;
    clast_box_extent extent = clast_box_extent_of(&frame->settings.rate_camera, &instance->bounds);
    float deviation = clast_frame_slack(frame, instance);
    uint64_t key = 0;
    if (!compares(unit) || !is_finite1(extent.farthest) || !is_finite1(deviation) ||
        !(key_of(level, places_of(level, &frame->pyramid, &extent), extent.farthest, &key) < extent.farthest)) {
        return;
    }
    view->deviation = deviation;
    view->places = (packed2){{(float)frame->pyramid.width / level->scale, (float)frame->pyramid.height / level->scale}};
    view->places_across = (uint32_t)level->width;
    view->places_down = (uint32_t)level->height;
    view->depths_key[0] = (uint32_t)key;
    view->depths_key[1] = (uint32_t)(key >> 32);
    view->depths = store_address((uint64_t)(uintptr_t)frame->pyramid.rows);
}

static void look_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_frame *frame = data;
    pyramid_level level = level_of(&frame->pyramid);
    for (size_t i = begin; i < end; i++) {
        look_behind(frame, &frame->instances[i], &level); // of those that are compared, each has one instance
    }
}

void clast_occlusion_find(clast_frame *frame)
{
    if (frame->pyramid.row_count == 0) {
        return;
    }
    pyramid_level level = level_of(&frame->pyramid);
    make_rows(frame, &level);
    clast_parallel_for(frame->context, frame->instance_count, UNIT_GRAIN, look_range, frame);
}
