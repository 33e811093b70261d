// SPDX-License-Identifier: Apache-2.0
// Pass animate, the part that moves: nodes, what hangs from them, and the vertices of meshes. A mesh is posed anew where what
// it is made from is not to the bit what it was made from before; so what a frame holds depends on its moment alone.
#include <stdatomic.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "frame/frame.h"

enum { VERTEX_GRAIN = 2048 };

void clast_frame_motion_destroy(clast_context *context, clast_frame_motion *motion)
{
    clast_free(context, motion->nodes);
    clast_free(context, motion->weights);
    clast_free(context, motion->lights);
    clast_free(context, motion->made_of);
}

void clast_posed_mesh_destroy(clast_context *context, clast_posed_mesh *mesh)
{
    clast_free(context, mesh->vertices);
    clast_free(context, mesh->made_of);
}

// ------------------------------------------------------------------------------------------------------------- nodes

static void move_camera(const clast_frame *frame, uint32_t number, clast_camera *camera)
{
    const clast_scene *scene = frame->scene;
    if (number < scene->camera_count && scene->cameras[number].node != CLAST_NONE) {
        const clast_matrix *to_world = &frame->motion.nodes[scene->cameras[number].node].to_world;
        clast_camera_desc desc = clast_camera_at(&scene->cameras[number].desc, to_world);
        *camera = clast_camera_record(&desc, frame->settings.width, frame->settings.height);
    }
}

static void focus_camera(const clast_frame_settings *settings, clast_camera *camera)
{
    camera->lens_radius = settings->aperture > 0.0 ? (float)(0.5 * settings->aperture) : camera->lens_radius;
    camera->focus = settings->focus > 0.0 ? (float)settings->focus : camera->focus;
}

static void move_lights(clast_frame *frame)
{
    const clast_scene *scene = frame->scene;
    for (size_t i = 0; i < scene->light_count; i++) {
        const clast_scene_light *light = &scene->lights[i];
        frame->motion.lights[i] = light->node != CLAST_NONE
                                      ? clast_light_at(&light->record, &frame->motion.nodes[light->node].to_world)
                                      : light->record;
    }
}

clast_status clast_frame_pose_scene(clast_frame *frame)
{
    clast_context *context = frame->context;
    const clast_scene *scene = frame->scene;
    clast_frame_motion *motion = &frame->motion;
    clast_status status = CLAST_RESERVE(context, motion->nodes, motion->node_capacity, scene->motion.node_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, motion->weights, motion->weight_capacity, scene->motion.weight_count);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, motion->lights, motion->light_capacity, scene->light_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_moment moment = {frame->settings.animation, frame->settings.time};
    clast_scene_pose(scene, moment, motion->nodes, motion->weights);
    move_camera(frame, frame->settings.camera_number, &frame->settings.camera);
    move_camera(frame, frame->settings.rate_camera_number, &frame->settings.rate_camera);
    focus_camera(&frame->settings, &frame->settings.camera);
    focus_camera(&frame->settings, &frame->settings.rate_camera);
    move_lights(frame);
    return CLAST_OK;
}

clast_transform clast_frame_place_instance(const clast_frame *frame, size_t instance, size_t *next)
{
    const clast_motion *motion = &frame->scene->motion;
    while (*next < motion->attachment_count && motion->attachments[*next].instance < instance) {
        ++*next;
    }
    if (*next == motion->attachment_count || motion->attachments[*next].instance != instance) {
        return frame->scene->instances[instance].to_world;
    }
    const clast_attachment *attachment = &motion->attachments[*next];
    return clast_attachment_to_world(attachment, &frame->motion.nodes[attachment->node].to_world);
}

// ---------------------------------------------------------------------------------------------------------- vertices

// What a mesh is made from at the frame's moment, into the frame's scratch.
static clast_status find_made_of(clast_frame *frame, const clast_deformation *deformation, size_t *count)
{
    clast_frame_motion *motion = &frame->motion;
    const clast_motion *scene = &frame->scene->motion;
    size_t joint_floats = deformation->influences != 0 ? 12 * (size_t)scene->skins[deformation->skin].joint_count : 0;
    *count = joint_floats + deformation->target_count;
    clast_status status = CLAST_RESERVE(frame->context, motion->made_of, motion->made_of_capacity, *count);
    if (status != CLAST_OK) {
        return status;
    }
    if (joint_floats != 0) {
        clast_scene_pose_joints(frame->scene, deformation->skin, motion->nodes, (clast_transform *)motion->made_of);
    }
    if (deformation->target_count != 0) {
        memcpy(motion->made_of + joint_floats, motion->weights + scene->nodes[deformation->weights_node].first_weight,
               deformation->target_count * sizeof *motion->weights);
    }
    return CLAST_OK;
}

typedef struct pose_job {
    clast_deform_job deform;
    atomic_bool is_wrong;
} pose_job;

static void pose_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    pose_job *job = data;
    if (!clast_deform(&job->deform, begin, end)) {
        atomic_store_explicit(&job->is_wrong, true, memory_order_relaxed);
    }
}

// Points a pose to the arrays of a posed mesh.
static void point_to(const clast_posed_mesh *posed, const clast_mesh *mesh, clast_pose *pose)
{
    size_t count = mesh->vertex_count;
    const float *next = posed->vertices + 3 * count;
    pose->shape = posed->shape;
    pose->positions = (const packed3 *)posed->vertices;
    pose->normals = mesh->normals != NULL ? (const packed3 *)next : NULL;
    next += mesh->normals != NULL ? 3 * count : 0;
    pose->tangents = mesh->tangents != NULL ? (const packed4 *)next : NULL;
}

static clast_status make_vertices(clast_frame *frame, clast_frame_unit *unit, size_t made_of_count)
{
    clast_context *context = frame->context;
    const clast_geometry *geometry = unit->unit->geometry;
    const clast_mesh *mesh = &geometry->of.mesh;
    clast_posed_mesh *posed = &unit->posed;
    size_t width = 3u + (mesh->normals != NULL ? 3u : 0u) + (mesh->tangents != NULL ? 4u : 0u), floats;
    posed->made_of_count = 0; // until all is well
    if (!clast_multiply_size(width, mesh->vertex_count, &floats)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "geometry %u: %u vertices are too many to be moved",
                          unit->unit->number, mesh->vertex_count);
    }
    clast_status status = CLAST_RESERVE(context, posed->vertices, posed->capacity, floats);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, posed->made_of, posed->made_of_capacity, made_of_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    posed->shape++;
    point_to(posed, mesh, &unit->pose);
    size_t target_count = geometry->deformation.target_count;
    pose_job job = {.deform = {.geometry = geometry,
                               .joints = (const clast_transform *)frame->motion.made_of,
                               .weights = frame->motion.made_of + (made_of_count - target_count),
                               .positions = (packed3 *)unit->pose.positions,
                               .normals = (packed3 *)unit->pose.normals,
                               .tangents = (packed4 *)unit->pose.tangents}};
    atomic_init(&job.is_wrong, false);
    clast_parallel_for(context, mesh->vertex_count, VERTEX_GRAIN, pose_range, &job);
    if (atomic_load(&job.is_wrong)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "geometry %u (%s) leaves single precision at %g s",
                          unit->unit->number, geometry->name != NULL ? geometry->name : "no name",
                          frame->settings.time);
    }
    memcpy(posed->made_of, frame->motion.made_of, made_of_count * sizeof *posed->made_of);
    posed->made_of_count = made_of_count;
    posed->geometry_version = geometry->version;
    frame->moved_vertices += mesh->vertex_count;
    return CLAST_OK;
}

clast_status clast_frame_pose_unit(clast_frame *frame, clast_frame_unit *unit)
{
    const clast_geometry *geometry = unit->unit->geometry;
    clast_posed_mesh *posed = &unit->posed;
    size_t count = 0;
    if (!clast_geometry_is_mesh(geometry) || !clast_deforms(&geometry->deformation)) {
        return CLAST_OK;
    }
    clast_status status = find_made_of(frame, &geometry->deformation, &count);
    if (status != CLAST_OK) {
        return status;
    }
    if (posed->made_of_count == count && posed->geometry_version == geometry->version &&
        memcmp(posed->made_of, frame->motion.made_of, count * sizeof *posed->made_of) == 0) {
        point_to(posed, &geometry->of.mesh, &unit->pose);
        return CLAST_OK;
    }
    return make_vertices(frame, unit, count);
}
