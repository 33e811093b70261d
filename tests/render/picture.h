// SPDX-License-Identifier: Apache-2.0
// Scenes rendered into memory, by the passes of the CPU.
#ifndef CLAST_TESTS_RENDER_PICTURE_H
#define CLAST_TESTS_RENDER_PICTURE_H

#include "shapes.h"

#include <string.h>

#include "frame/backend.h"
#include "render/render.h"

#define assert_near(value, expected, tolerance) \
    do { \
        double value_ = (double)(value), expected_ = (double)(expected); \
        if (!(fabs(value_ - expected_) <= (double)(tolerance))) { \
            fail_msg("%s is %g, not %g", #value, value_, expected_); \
        } \
    } while (0)

typedef struct picture {
    clast_context *context;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;
    clast_render_settings settings;
    clast_render_statistics statistics;
    void *pixels[CLAST_VIEW_COUNT_];
} picture;

// An empty scene, to be rendered with size * size pixels.
static inline picture picture_open(clast_context *context, uint32_t size, uint32_t samples)
{
    picture p = {
        .context = context,
        .settings = {
            .width = size, .height = size, .spp = samples, .bounces = 8, .rate = 1.0, .camera = "", .env = ""}};
    assert_ok(context, clast_scene_create(context, &p.scene));
    return p;
}

static inline uint32_t picture_material(picture *p, float grey, float metallic, float roughness, float emissive)
{
    clast_material_desc material = clast_material_defaults();
    for (int c = 0; c < 3; c++) {
        material.base_colour[c] = grey;
        material.emissive[c] = emissive;
    }
    material.metallic = metallic;
    material.roughness = roughness;
    uint32_t number;
    assert_ok(p->context, clast_scene_add_material(p->scene, &material, NULL, &number));
    return number;
}

static inline void picture_surround(picture *p, float radiance)
{
    clast_environment environment = {.type = CLAST_ENVIRONMENT_CONSTANT, .colour = {radiance, radiance, radiance}};
    assert_ok(p->context, clast_scene_set_environment(p->scene, &environment));
}

// A square with corners at centre +- right +- up; its front is where right x up points.
static inline uint32_t picture_add_square(picture *p, vec3 centre, vec3 right, vec3 up, uint32_t material)
{
    float positions[12], coordinates[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    const float signs[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int v = 0; v < 4; v++) {
        vec3 corner = centre + right * signs[v][0] + up * signs[v][1];
        for (int k = 0; k < 3; k++) {
            positions[3 * v + k] = corner[k];
        }
    }
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    clast_mesh mesh = {.vertex_count = 4,
                       .triangle_count = 2,
                       .positions = positions,
                       .coordinates = {coordinates},
                       .indices = indices,
                       .material = material};
    uint32_t geometry, instance;
    assert_ok(p->context, clast_scene_add_mesh(p->scene, &mesh, "square", &geometry));
    assert_ok(p->context, clast_scene_add_instance(p->scene, geometry, NULL, NULL, &instance));
    return instance;
}

// A sphere.
static inline void picture_add_sphere(picture *p, vec3 centre, float radius, uint32_t columns, uint32_t material)
{
    shape s = shape_sphere(columns, columns / 2);
    s.mesh.material = material;
    uint32_t geometry = CLAST_NONE;
    clast_status status = clast_scene_add_mesh(p->scene, &s.mesh, "sphere", &geometry);
    shape_free(&s);
    assert_ok(p->context, status);
    shape_add_instance(p->context, p->scene, geometry, centre[0], centre[1], centre[2], radius);
}

static inline void picture_look(picture *p, vec3 from, vec3 at, float angle)
{
    clast_camera_desc camera = {.vertical_angle = angle};
    for (int k = 0; k < 3; k++) {
        camera.position[k] = from[k];
        camera.target[k] = at[k];
    }
    uint32_t number;
    assert_ok(p->context, clast_scene_add_camera(p->scene, &camera, NULL, &number));
}

// Runs the passes up to the lights.
static inline void picture_build(picture *p)
{
    uint32_t size = p->settings.width;
    assert_ok(p->context, clast_cooked_create(p->context, &p->cooked));
    assert_ok(p->context, clast_cooked_update(p->cooked, p->scene));
    assert_ok(p->context, clast_frame_create(p->scene, p->cooked, &p->frame));
    p->frame->settings = (clast_frame_settings){
        .width = size, .height = size, .rate = 1.0, .segment = 2.0, .displacement_scale = 1.0};
    assert_ok(p->context, clast_scene_choose_camera(p->scene, "", size, size, &p->frame->settings.camera));
    p->frame->settings.rate_camera = p->frame->settings.camera;
    assert_ok(p->context, clast_frame_run(p->frame, &clast_cpu_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
}

static inline clast_status picture_try(picture *p, const clast_view *views, size_t count)
{
    clast_render_output outputs[CLAST_VIEW_COUNT_];
    for (size_t i = 0; i < count; i++) {
        size_t bytes = (size_t)p->settings.width * p->settings.height * 12;
        free(p->pixels[views[i]]);
        p->pixels[views[i]] = malloc(bytes);
        outputs[i] = (clast_render_output){views[i], p->pixels[views[i]]};
    }
    return clast_render_frame(p->frame, &clast_cpu_backend, &p->settings, outputs, count, &p->statistics);
}

// Builds, and renders colour.
static inline const float *picture_render(picture *p)
{
    const clast_view colour = CLAST_VIEW_COLOUR;
    picture_build(p);
    assert_ok(p->context, picture_try(p, &colour, 1));
    return p->pixels[CLAST_VIEW_COLOUR];
}

static inline const float *picture_pixel(const picture *p, uint32_t x, uint32_t y)
{
    return (const float *)p->pixels[CLAST_VIEW_COLOUR] + 3 * ((size_t)y * p->settings.width + x);
}

static inline double picture_mean(const picture *p)
{
    const float *values = p->pixels[CLAST_VIEW_COLOUR];
    size_t count = 3 * (size_t)p->settings.width * p->settings.height;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)values[i];
    }
    return sum / (double)count;
}

static inline void picture_close(picture *p)
{
    for (int i = 0; i < CLAST_VIEW_COUNT_; i++) {
        free(p->pixels[i]);
    }
    clast_frame_destroy(p->frame);
    clast_cooked_destroy(p->cooked);
    clast_scene_destroy(p->scene);
}

#endif
