// SPDX-License-Identifier: Apache-2.0
// Views of what the first sample's rays hit, and of how finely geometry is cut there and was wanted.
#include "render/views.h"

#include "render/surface.h"
#include "shared/camera.h"

// What a hit's record is asked.
typedef struct found_cluster {
    const clast_frame_instance *instance;
    const clast_frame_unit *unit;
    const clast_cluster_record *record;
    const uint32_t *words;
} found_cluster;

static found_cluster cluster_of(const clast_frame *frame, const clast_visibility *seen)
{
    const clast_frame_instance *instance = &frame->instances[frame->frame_instance_of[seen->instance]];
    const clast_frame_unit *unit = &frame->units[instance->unit];
    const clast_cluster_record *record = &unit->records[seen->cluster];
    return (found_cluster){instance, unit, record, clast_frame_words(unit, record)};
}

static uint32_t primitive_of(const found_cluster *at, const clast_visibility *seen)
{
    const clast_unit *unit = at->unit->unit;
    return clast_source_of(unit)
        ->locate(unit, &at->unit->pose, at->record, at->words, seen->triangle, load2(seen->barycentrics))
        .primitive;
}

static float segments_in(const found_cluster *at, const clast_visibility *seen, const clast_source_view *view)
{
    const clast_unit *unit = at->unit->unit;
    const clast_source *source = clast_source_of(unit);
    return source->segments != NULL ? source->segments(unit, &at->unit->pose, view, at->record, at->words,
                                                       seen->triangle, load2(seen->barycentrics))
                                    : 0.0f;
}

// Segments that the edge has over those that it would have if it were seen and no budget were short.
static float rate_of(const clast_frame *frame, const found_cluster *at, const clast_visibility *seen)
{
    clast_source_view wanted = at->unit->view;
    wanted.rate = (float)frame->settings.rate;
    wanted.hidden = 0;
    wanted.hidden_fraction = 1.0f;
    float full = segments_in(at, seen, &wanted);
    return full > 0.0f ? segments_in(at, seen, &at->unit->view) / full : 1.0f;
}

static float area_of(const clast_frame *frame, const found_cluster *at, const clast_visibility *seen)
{
    float found[3][3];
    vec3 corners[3];
    clast_clas_corners(at->unit->clas, seen->cluster, seen->triangle, found);
    for (int k = 0; k < 3; k++) {
        corners[k] = transform_point(at->instance->to_world, vec3(found[k][0], found[k][1], found[k][2]));
    }
    return camera_area(frame->settings.camera, (float)frame->settings.height, corners[0], corners[1], corners[2]);
}

static void keep(uint32_t *view, size_t pixel, uint32_t number)
{
    if (view != NULL) {
        view[pixel] = number;
    }
}

static void keep_cut(const clast_frame *frame, clast_render_target *target, size_t pixel)
{
    const clast_visibility *seen = &target->visibility[pixel];
    found_cluster at = cluster_of(frame, seen);
    if (target->firsts[CLAST_VIEW_PRIMITIVE] != NULL) {
        target->firsts[CLAST_VIEW_PRIMITIVE][pixel] = primitive_of(&at, seen);
    }
    if (target->sums[CLAST_VIEW_SEGMENTS] != NULL) {
        target->sums[CLAST_VIEW_SEGMENTS][pixel] = segments_in(&at, seen, &at.unit->view);
    }
    if (target->sums[CLAST_VIEW_RATE] != NULL) {
        target->sums[CLAST_VIEW_RATE][pixel] = rate_of(frame, &at, seen);
    }
    if (target->sums[CLAST_VIEW_AREA] != NULL) {
        target->sums[CLAST_VIEW_AREA][pixel] = area_of(frame, &at, seen);
    }
}

void clast_keep_views(const clast_frame *frame, clast_render_target *target, size_t pixel)
{
    const clast_visibility *seen = &target->visibility[pixel];
    keep(target->firsts[CLAST_VIEW_INSTANCE], pixel, seen->instance);
    keep(target->firsts[CLAST_VIEW_CLUSTER], pixel, seen->cluster);
    keep(target->firsts[CLAST_VIEW_TRIANGLE], pixel, seen->triangle);
    keep(target->firsts[CLAST_VIEW_STEPS], pixel, seen->steps);
    bool is_cut = target->firsts[CLAST_VIEW_PRIMITIVE] != NULL || target->sums[CLAST_VIEW_SEGMENTS] != NULL ||
                  target->sums[CLAST_VIEW_RATE] != NULL || target->sums[CLAST_VIEW_AREA] != NULL;
    if (is_cut && seen->instance != CLAST_NONE) { // else as the views began: nothing
        keep_cut(frame, target, pixel);
    }
}
