// SPDX-License-Identifier: Apache-2.0
// A sheet of grids that waves, and a ball that floats on it: geometry that moves and adapts each frame, a ray that
// asks where the surface is, an instance that follows, and a picture of each moment.
//
//   waving_sheet [FRAMES [PREFIX]]     writes PREFIX0.png, PREFIX1.png, ... ("sheet" unless told), prints a line each
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "clast/clast.h"

enum {
    WIDTH = 320,
    HEIGHT = 180,
    COLUMNS = 48,
    ROWS = 24,
    VERTICES = (COLUMNS + 1) * (ROWS + 1),
    TRIANGLES = COLUMNS * ROWS * 2
};

static const float ball_radius = 0.6f;

typedef struct sea {
    clast_context *context;
    clast_scene *scene;
    clast_renderer *renderer;
    uint32_t sheet, ball; // instances
} sea;

static clast_status add_material(clast_scene *scene, float red, float green, float blue, float roughness,
                                 uint32_t *number)
{
    clast_material_desc material = clast_material_defaults();
    material.base_colour[0] = red;
    material.base_colour[1] = green;
    material.base_colour[2] = blue;
    material.roughness = roughness;
    return clast_scene_add_material(scene, &material, NULL, number);
}

static clast_status add_sheet(sea *s)
{
    uint32_t water = 0, geometry = 0;
    clast_status status = add_material(s->scene, 0.05f, 0.22f, 0.35f, 0.2f, &water);
    if (status != CLAST_OK) {
        return status;
    }
    clast_wave wave = {
        .size = 24.0f, .tiles = 24, .amplitude = 0.5f, .wavelength = 6.0f, .speed = 0.4f, .material = water};
    status = clast_scene_add_wave(s->scene, &wave, "sheet", &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(s->scene, geometry, NULL, "sheet", &s->sheet) : status;
}

// A sphere of radius one around the origin. On it, a vertex is its own normal.
static void make_sphere(float *positions, uint32_t *indices)
{
    for (uint32_t v = 0; v < VERTICES; v++) {
        uint32_t column = v % (COLUMNS + 1) % COLUMNS; // the last column lies on the first, to the bit
        float turn = 6.2831853f * (float)column / COLUMNS, height = 3.1415927f * (float)(v / (COLUMNS + 1)) / ROWS;
        positions[3 * v] = sinf(height) * cosf(turn);
        positions[3 * v + 1] = cosf(height);
        positions[3 * v + 2] = -sinf(height) * sinf(turn);
    }
    for (uint32_t quad = 0; quad < COLUMNS * ROWS; quad++) {
        uint32_t a = quad / COLUMNS * (COLUMNS + 1) + quad % COLUMNS, b = a + COLUMNS + 1;
        uint32_t corners[6] = {a, b, b + 1, a, b + 1, a + 1};
        for (uint32_t k = 0; k < 6; k++) {
            indices[6 * quad + k] = corners[k];
        }
    }
}

static clast_status add_ball(sea *s)
{
    static float positions[3 * VERTICES];
    static uint32_t indices[3 * TRIANGLES];
    make_sphere(positions, indices);
    uint32_t paint = 0, geometry = 0;
    clast_status status = add_material(s->scene, 0.8f, 0.12f, 0.05f, 0.4f, &paint);
    if (status != CLAST_OK) {
        return status;
    }
    clast_mesh mesh = {
        .vertex_count = VERTICES,
        .triangle_count = TRIANGLES,
        .positions = positions,
        .normals = positions,
        .indices = indices,
        .material = paint,
    };
    status = clast_scene_add_mesh(s->scene, &mesh, "ball", &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(s->scene, geometry, NULL, "ball", &s->ball) : status;
}

static clast_status add_surroundings(sea *s)
{
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.6f, -0.4f}};
    return clast_scene_set_environment(s->scene, &sky);
}

static clast_status open_sea(sea *s)
{
    clast_status status = clast_scene_create(s->context, &s->scene);
    if (status == CLAST_OK) {
        status = add_sheet(s);
    }
    if (status == CLAST_OK) {
        status = add_ball(s);
    }
    if (status == CLAST_OK) {
        status = add_surroundings(s);
    }
    return status == CLAST_OK ? clast_renderer_create(s->scene, &s->renderer) : status;
}

static clast_status place_ball(sea *s, float height, bool visible)
{
    float r = ball_radius;
    const float transform[12] = {r, 0, 0, 0, 0, r, 0, height, 0, 0, r, 0};
    clast_status status = clast_scene_set_instance_transform(s->scene, s->ball, transform);
    return status == CLAST_OK ? clast_scene_set_instance_visible(s->scene, s->ball, visible) : status;
}

// Where the sheet is under the ball: the ball is put aside, and a ray goes straight down.
static clast_status float_ball(sea *s, const clast_render_settings *settings, float *height)
{
    clast_ray down = {.origin = {0.0f, 10.0f, 0.0f}, .direction = {0.0f, -1.0f, 0.0f}, .t_max = 100.0f};
    clast_hit hit = {.instance = CLAST_NONE};
    clast_status status = place_ball(s, 0.0f, false);
    if (status == CLAST_OK) {
        status = clast_renderer_commit(s->renderer, settings);
    }
    if (status == CLAST_OK) {
        status = clast_renderer_trace_closest(s->renderer, &down, 1, &hit);
    }
    *height = hit.instance == s->sheet ? 10.0f - hit.t : 0.0f;
    return status == CLAST_OK ? place_ball(s, *height + 0.3f * ball_radius, true) : status;
}

// The eye draws back from moment to moment, so that the sheet needs fewer triangles.
static clast_status render_moment(sea *s, uint32_t frame, const char *prefix)
{
    static float colour[WIDTH * HEIGHT * 3];
    static uint8_t display[WIDTH * HEIGHT * 3];
    char camera[64], path[512];
    snprintf(camera, sizeof camera, "0,%u.5,%u/0,0,0", 3 + frame, 9 + 3 * frame);
    snprintf(path, sizeof path, "%s%u.png", prefix, frame);
    clast_render_settings settings = {
        .width = WIDTH, .height = HEIGHT, .spp = 16, .bounces = 4, .time = 0.25 * frame, .camera = camera};
    clast_render_output output = {CLAST_VIEW_COLOUR, colour};
    clast_render_statistics statistics;
    float height = 0.0f;
    clast_status status = float_ball(s, &settings, &height);
    if (status == CLAST_OK) {
        status = clast_render(s->renderer, &settings, &output, 1, &statistics);
    }
    if (status == CLAST_OK) {
        status = clast_view_to_display(s->context, CLAST_VIEW_COLOUR, colour, WIDTH, HEIGHT, &settings, display);
    }
    clast_image image = {WIDTH, HEIGHT, 3, CLAST_PIXEL_UNORM8, display};
    if (status == CLAST_OK) {
        status = clast_image_write(s->context, path, &image);
    }
    if (status == CLAST_OK) {
        printf("%s: time %.2f s, water at %+.3f m, %llu triangles in %llu clusters, %llu rays in %.0f ms\n", path,
               settings.time, (double)height, (unsigned long long)statistics.triangles,
               (unsigned long long)statistics.clusters, (unsigned long long)statistics.rays,
               statistics.total_milliseconds);
    }
    return status;
}

int main(int count, char **arguments)
{
    int frames = count > 1 ? atoi(arguments[1]) : 4;
    const char *prefix = count > 2 ? arguments[2] : "sheet";
    sea s = {0};
    clast_status status = clast_context_create(NULL, &s.context);
    if (status != CLAST_OK) {
        fprintf(stderr, "waving_sheet: %s\n", clast_status_text(status));
        return 1;
    }
    status = open_sea(&s);
    for (int frame = 0; frame < frames && status == CLAST_OK; frame++) {
        status = render_moment(&s, (uint32_t)frame, prefix);
    }
    if (status != CLAST_OK) {
        fprintf(stderr, "waving_sheet: %s\n", clast_context_error(s.context));
    }
    clast_renderer_destroy(s.renderer);
    clast_scene_destroy(s.scene);
    clast_context_destroy(s.context);
    return status == CLAST_OK ? 0 : 1;
}
