// SPDX-License-Identifier: Apache-2.0
// A scene from arrays, edited while it lives: two pyramids on a floor; then one moves, its material changes, and the scene is
// rendered again. What has not changed is not built anew.
//
//   cc mesh_in_memory.c -o mesh_in_memory $(pkg-config --cflags --libs clast)
//   ./mesh_in_memory before.png after.png
#include <clast/clast.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 180 };

static const float pyramid_positions[] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, 1.5f, 0};
static const uint32_t pyramid_indices[] = {3, 2, 4, 2, 1, 4, 1, 0, 4, 0, 3, 4, 0, 1, 2, 0, 2, 3};
static const float floor_positions[] = {-6, 0, -6, 6, 0, -6, 6, 0, 6, -6, 0, 6};
static const uint32_t floor_indices[] = {3, 2, 1, 3, 1, 0};

static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

static uint32_t add_material(clast_scene *scene, const clast_context *context, float red, float green, float blue)
{
    clast_material_desc material = clast_material_defaults();
    material.base_colour[0] = red;
    material.base_colour[1] = green;
    material.base_colour[2] = blue;
    uint32_t number = 0;
    check(clast_scene_add_material(scene, &material, NULL, &number), context);
    return number;
}

static void render(clast_renderer *renderer, clast_context *context, const char *path)
{
    static float radiance[3 * WIDTH * HEIGHT];
    static uint8_t display[3 * WIDTH * HEIGHT];
    clast_render_settings settings = {.width = WIDTH, .height = HEIGHT, .spp = 16};
    clast_render_output output = {CLAST_VIEW_COLOUR, radiance};
    clast_render_statistics statistics;
    check(clast_render(renderer, &settings, &output, 1, &statistics), context);
    check(clast_view_to_display(context, CLAST_VIEW_COLOUR, radiance, WIDTH, HEIGHT, &settings, display), context);
    clast_image image = {
        .width = WIDTH, .height = HEIGHT, .channels = 3, .type = CLAST_PIXEL_UNORM8, .pixels = display};
    check(clast_image_write(context, path, &image), context);
    printf("%s: %u instances, cooked in %.2f ms\n", path, statistics.instances, statistics.cook_milliseconds);
}

int main(int count, char **arguments)
{
    if (count != 3) {
        fprintf(stderr, "usage: mesh_in_memory BEFORE.png AFTER.png\n");
        return 2;
    }
    clast_context *context = NULL;
    clast_scene *scene = NULL;
    check(clast_context_create(NULL, &context), context);
    check(clast_scene_create(context, &scene), context);

    uint32_t sand = add_material(scene, context, 0.7f, 0.6f, 0.4f);
    uint32_t red = add_material(scene, context, 0.7f, 0.1f, 0.1f);
    clast_mesh pyramid = {.vertex_count = 5,
                          .triangle_count = 6,
                          .positions = pyramid_positions,
                          .indices = pyramid_indices,
                          .material = red};
    clast_mesh floor = {.vertex_count = 4,
                        .triangle_count = 2,
                        .positions = floor_positions,
                        .indices = floor_indices,
                        .material = sand};
    uint32_t pyramid_number = 0;
    uint32_t floor_number = 0;
    check(clast_scene_add_mesh(scene, &pyramid, "pyramid", &pyramid_number), context);
    check(clast_scene_add_mesh(scene, &floor, "floor", &floor_number), context);

    // One geometry, two instances: the second is half as large and stands aside.
    const float aside[12] = {0.5f, 0, 0, 2.5f, 0, 0.5f, 0, 0, 0, 0, 0.5f, 1};
    uint32_t ignored = 0;
    uint32_t small = 0;
    check(clast_scene_add_instance(scene, floor_number, NULL, NULL, &ignored), context);
    check(clast_scene_add_instance(scene, pyramid_number, NULL, NULL, &ignored), context);
    check(clast_scene_add_instance(scene, pyramid_number, aside, "small", &small), context);

    clast_renderer *renderer = NULL;
    check(clast_renderer_create(scene, &renderer), context);
    render(renderer, context, arguments[1]);

    // Edits are seen by the next commit, which a render begins with.
    const float moved[12] = {0.5f, 0, 0, -2.5f, 0, 0.5f, 0, 0, 0, 0, 0.5f, 1};
    clast_material_desc blue = clast_material_defaults();
    blue.base_colour[0] = 0.1f;
    blue.base_colour[1] = 0.2f;
    blue.base_colour[2] = 0.8f;
    check(clast_scene_set_instance_transform(scene, small, moved), context);
    check(clast_scene_set_material(scene, red, &blue), context);
    render(renderer, context, arguments[2]);

    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
    clast_context_destroy(context);
    return 0;
}
