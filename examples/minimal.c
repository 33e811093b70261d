// SPDX-License-Identifier: Apache-2.0
// The smallest use of the library: load a scene, render it, write a picture.
//
//   cc minimal.c -o minimal $(pkg-config --cflags --libs clast)
//   ./minimal scene.gltf picture.png
#include <clast/clast.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 180 };

static float radiance[3 * WIDTH * HEIGHT];
static uint8_t display[3 * WIDTH * HEIGHT];

// Every call gives a status; the context keeps the text of the newest error.
static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

int main(int count, char **arguments)
{
    if (count != 3) {
        fprintf(stderr, "usage: minimal SCENE PICTURE.png\n");
        return 2;
    }
    clast_context *context = NULL;
    clast_scene *scene = NULL;
    clast_renderer *renderer = NULL;
    check(clast_context_create(NULL, &context), context);
    check(clast_scene_load(context, arguments[1], &scene), context);
    check(clast_renderer_create(scene, &renderer), context);

    // What is zero has its default: camera and light are found, 8 bounces, ...
    clast_render_settings settings = {.width = WIDTH, .height = HEIGHT, .spp = 16};
    clast_render_output output = {CLAST_VIEW_COLOUR, radiance};
    check(clast_render(renderer, &settings, &output, 1, NULL), context);

    // Radiance is linear and may be of any size; this makes of it what a screen shows.
    check(clast_view_to_display(context, CLAST_VIEW_COLOUR, radiance, WIDTH, HEIGHT, &settings, display), context);
    clast_image image = {
        .width = WIDTH, .height = HEIGHT, .channels = 3, .type = CLAST_PIXEL_UNORM8, .pixels = display};
    check(clast_image_write(context, arguments[2], &image), context);

    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
    clast_context_destroy(context);
    return 0;
}
