// SPDX-License-Identifier: Apache-2.0
// Pass classify: which instances the camera sees, and from where each unit is adapted. That camera is the one that decides
// rates, which may be another than the picture's.
#include "base/thread.h"
#include "frame/unit.h"
#include "shared/transform.h"

enum { INSTANCE_GRAIN = 1024 };

static bool box_is_empty(const clast_box *box)
{
    return !(box->lower.v[0] <= box->upper.v[0]);
}

// The box around a transformed box: the extent along a world axis is the sum of what each side adds to it.
static clast_box transform_box(const clast_transform *t, const clast_box *box)
{
    if (box_is_empty(box)) {
        return *box;
    }
    vec3 centre = (load3(box->lower) + load3(box->upper)) * 0.5f;
    vec3 half = load3(box->upper) - centre;
    vec3 middle = transform_point(*t, centre);
    clast_box result;
    for (uint32_t axis = 0; axis < 3; axis++) {
        const float *row = t->rows[axis].v;
        float extent = abs1(row[0]) * half[0] + abs1(row[1]) * half[1] + abs1(row[2]) * half[2];
        result.lower.v[axis] = middle[axis] - extent;
        result.upper.v[axis] = middle[axis] + extent;
    }
    return result;
}

// Whether all of a box lies on the far side of the plane through `at` whose inner side `normal` points to. Rounding
// errors go in favour of what may be seen.
static bool beyond(const clast_box *box, vec3 at, vec3 normal)
{
    vec3 centre = (load3(box->lower) + load3(box->upper)) * 0.5f - at;
    vec3 half = (load3(box->upper) - load3(box->lower)) * 0.5f;
    vec3 size = vec3(abs1(normal[0]), abs1(normal[1]), abs1(normal[2]));
    vec3 reach = vec3(abs1(centre[0]), abs1(centre[1]), abs1(centre[2])) + half;
    return dot3(normal, centre) + dot3(size, half) < -1e-5f * dot3(size, reach);
}

static bool beyond_far_plane(const clast_camera *camera, const clast_box *box)
{
    vec3 forward = load3(camera->forward);
    return camera->far_plane > 0.0f && beyond(box, load3(camera->position) + forward * camera->far_plane, -forward);
}

// Whether no ray of the camera can meet a box.
static bool outside_camera(const clast_camera *camera, const clast_box *box)
{
    if (box_is_empty(box)) {
        return true;
    }
    // All around, and through a lens from beside the pinhole's cone, anything may be seen.
    if (camera->projection == CLAST_PROJECTION_PANORAMA || camera->lens_radius > 0.0f) {
        return false;
    }
    vec3 position = load3(camera->position);
    vec3 forward = load3(camera->forward);
    vec3 sides[2] = {load3(camera->right), load3(camera->up)};
    float extents[2] = {camera->vertical_extent * camera->aspect, camera->vertical_extent};
    bool parallel = camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    bool hidden = beyond(box, position + forward * camera->near_plane, forward);
    hidden = hidden || beyond_far_plane(camera, box);
    for (uint32_t axis = 0; axis < 2; axis++) {
        vec3 inclined = parallel ? splat3(0.0f) : forward * extents[axis];
        vec3 offset = parallel ? sides[axis] * extents[axis] : splat3(0.0f);
        hidden = hidden || beyond(box, position - offset, sides[axis] + inclined);
        hidden = hidden || beyond(box, position + offset, inclined - sides[axis]);
    }
    return hidden;
}

// An instance as seen from the eye. What is nearest counts: lengths there cover scale / distance as many pixels as at
// distance one. Squares, as those need no root.
typedef struct nearness {
    vec3 eye;              // in the unit's own space
    float scale_square;    // of lengths, from the unit's space to the world's: the mean over three axes
    float distance_square; // in world space, from the eye to the unit's box
    float own_square;      // the same in the unit's own space
} nearness;

static nearness nearness_of(const clast_frame_instance *instance, const clast_box *box, vec3 eye)
{
    nearness result = {.eye = transform_point(instance->to_object, eye)};
    vec3 away = splat3(0.0f);
    for (uint32_t axis = 0; axis < 3; axis++) {
        const float *row = instance->to_world.rows[axis].v;
        result.scale_square += (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]) * (1.0f / 3.0f);
        away[axis] = result.eye[axis] - clamp1(result.eye[axis], box->lower.v[axis], box->upper.v[axis]);
    }
    vec3 away_in_world = transform_vector(instance->to_world, away);
    result.own_square = dot3(away, away);
    result.distance_square = dot3(away_in_world, away_in_world);
    return result;
}

// Pixels that a length of one covers: at distance one, or anywhere where rays are parallel.
static float pixels_of(const clast_frame_settings *settings)
{
    float extent = settings->rate_camera.vertical_extent;
    return (float)settings->height / (2.0f * (extent > 0.0f ? extent : 1.0f));
}

// The eye of a view, and pixels that a length of one covers at distance one from it. Parallel rays show everything at
// the same size: as an eye does that is far away.
static vec3 eye_of(const clast_frame *frame, const clast_box *box, float *pixels)
{
    const clast_camera *camera = &frame->settings.rate_camera;
    *pixels = pixels_of(&frame->settings);
    vec3 eye = load3(camera->position);
    if (camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC && !box_is_empty(box)) {
        vec3 centre = (load3(box->lower) + load3(box->upper)) * 0.5f;
        float far_away = 1024.0f * length3(load3(box->upper) - load3(box->lower));
        *pixels *= far_away;
        eye = centre - load3(camera->forward) * far_away;
    }
    return eye;
}

// From an instance's own space to the camera's axes.
static clast_transform camera_transform(const clast_camera *camera, const clast_transform *to_world)
{
    const vec3 axes[3] = {load3(camera->right), load3(camera->up), load3(camera->forward)};
    vec4 rows[3];
    for (uint32_t i = 0; i < 3; i++) {
        rows[i] = vec4(axes[i][0], axes[i][1], axes[i][2], -dot3(axes[i], load3(camera->position)));
    }
    return transform_product(transform_rows(rows[0], rows[1], rows[2]), *to_world);
}

static bool has_transparency(const clast_scene *scene, const clast_unit *unit)
{
    for (uint32_t i = 0; i < unit->material_count; i++) {
        uint32_t material = unit->materials[i];
        if (material < scene->material_count && scene->materials[material].record.alpha_mode != CLAST_ALPHA_OPAQUE) {
            return true;
        }
    }
    return false;
}

static void classify_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_frame *frame = data;
    for (size_t i = begin; i < end; i++) {
        clast_frame_instance *instance = &frame->instances[i];
        instance->bounds = transform_box(&instance->to_world, &frame->units[instance->unit].bounds);
        instance->occluded = false;
        instance->hidden = outside_camera(&frame->settings.rate_camera, &instance->bounds);
    }
}

// What decides which instance of a unit is looked at: found of all instances at once, on all threads. The rest is found anew of
// the one that it becomes.
typedef struct closeness {
    float scale_square, distance_square; // as nearness has them
    uint32_t unit;
    bool hidden;
} closeness;

typedef struct closeness_job {
    const clast_frame *frame;
    closeness *list;
} closeness_job;

// What makes the view of a unit, found so far.
typedef struct unit_view {
    uint32_t instances;
    bool seen;
    const clast_frame_instance *instance; // the nearest
    closeness nearest;
} unit_view;

static nearness look_at_instance(const clast_frame *frame, const clast_frame_instance *instance, float *pixels)
{
    const clast_box *box = &frame->units[instance->unit].bounds;
    vec3 eye = eye_of(frame, &instance->bounds, pixels);
    return box_is_empty(box) ? (nearness){.eye = eye} : nearness_of(instance, box, eye);
}

static void look_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    closeness_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const clast_frame_instance *instance = &job->frame->instances[i];
        float pixels = 0.0f;
        nearness here = look_at_instance(job->frame, instance, &pixels);
        job->list[i] = (closeness){here.scale_square, here.distance_square, instance->unit, instance->hidden};
    }
}

// Whether lengths of `a` are seen larger than those of `b`.
static bool is_nearer(const closeness *a, const closeness *b)
{
    return a->scale_square * b->distance_square > b->scale_square * a->distance_square;
}

static void compare_instance(const closeness *here, const clast_frame_instance *instance, unit_view *view)
{
    // an instance that is seen comes before all that are not
    bool better = here->hidden == !view->seen ? is_nearer(here, &view->nearest) : !here->hidden;
    if (view->instances++ == 0 || better) {
        view->instance = instance;
        view->nearest = *here;
    }
    view->seen = view->seen || !here->hidden;
}

// Whether all of a unit is as coarse as what is hidden. Where its edges tell for themselves they come to that little by little, as
// the last of it leaves sight.
static bool is_hidden(const clast_frame *frame, const unit_view *found)
{
    const clast_frame_instance *instance = found->instance;
    bool by_edges = found->instances == 1 && clast_source_of(frame->units[instance->unit].unit)->hides_edges &&
                    !beyond_far_plane(&frame->settings.rate_camera, &instance->bounds);
    return !found->seen && !by_edges;
}

// Uniform scales change nothing: lengths and distances grow alike. Others are right where the instance is nearest.
static clast_source_view view_of(const clast_frame *frame, const unit_view *found)
{
    const clast_frame_settings *settings = &frame->settings;
    float pixels = 0.0f;
    nearness here = look_at_instance(frame, found->instance, &pixels);
    const nearness *nearest = &here;
    const clast_camera *camera = &settings->rate_camera;
    float stretch = rough_sqrt(rough_divide(nearest->scale_square * nearest->own_square, nearest->distance_square));
    bool sound = nearest->distance_square > 0.0f && is_finite1(stretch) && stretch > 0.0f;
    return (clast_source_view){
        .eye = store3(nearest->eye),
        .pixels_per_unit = pixels * (sound ? stretch : 1.0f),
        .rate = (float)settings->rate,
        .hidden = is_hidden(frame, found) ? 1u : 0u,
        .to_camera = camera_transform(camera, &found->instance->to_world),
        .extent = {{camera->vertical_extent * camera->aspect, camera->vertical_extent}},
        .pixels = pixels_of(settings),
        .near_plane = camera->near_plane,
        .projection = camera->projection,
        .metric = camera->projection == CLAST_PROJECTION_PANORAMA && settings->metric == CLAST_METRIC_PIXELS
                      ? CLAST_METRIC_SPHERE
                      : settings->metric,
        .segment = (float)settings->segment,
        .hidden_fraction = (float)settings->hidden_fraction,
        .alone = found->instances == 1 ? 1u : 0u,
    };
}

clast_status clast_frame_view_units(clast_frame *frame)
{
    unit_view *views = clast_allocate_zeroed(frame->context, frame->unit_count, sizeof *views);
    closeness *list = clast_allocate(frame->context, frame->instance_count, sizeof *list);
    clast_status status = views != NULL && list != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        closeness_job job = {frame, list};
        clast_parallel_for(frame->context, frame->instance_count, INSTANCE_GRAIN, look_range, &job);
        for (size_t i = 0; i < frame->instance_count; i++) {
            compare_instance(&list[i], &frame->instances[i], &views[list[i].unit]);
        }
    }
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        if (frame->units[i].used) {
            frame->units[i].view = view_of(frame, &views[i]);
            frame->units[i].filtered = has_transparency(frame->scene, frame->units[i].unit);
        }
    }
    clast_free(frame->context, list);
    clast_free(frame->context, views);
    return status;
}

clast_status clast_cpu_classify(clast_frame *frame, void *target)
{
    (void)target;
    clast_parallel_for(frame->context, frame->instance_count, INSTANCE_GRAIN, classify_range, frame);
    return clast_frame_view_units(frame);
}
