// SPDX-License-Identifier: Apache-2.0
// Your own rays: loads a scene, looks straight down on a grid of points, prints heights and what was hit.
//
//   cc trace_rays.c -o trace_rays $(pkg-config --cflags --libs clast) -lm
//   ./trace_rays scene.gltf
//
// Rays may be traced by any number of threads at once, as long as nothing is edited or committed meanwhile.
#include <clast/clast.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 8 };

static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

// A grid of rays from above the box, straight down.
static void aim(const float lower[3], const float upper[3], clast_ray rays[SIDE * SIDE])
{
    float height = upper[1] - lower[1] + 1.0f;
    for (int i = 0; i < SIDE * SIDE; i++) {
        float across = (float)(i % SIDE) + 0.5f;
        float along = (float)(i / SIDE) + 0.5f;
        rays[i] = (clast_ray){
            .origin = {lower[0] + (upper[0] - lower[0]) * across / SIDE, upper[1] + height,
                       lower[2] + (upper[2] - lower[2]) * along / SIDE},
            .direction = {0.0f, -1.0f, 0.0f},
            .t_max = INFINITY,
        };
    }
}

static void print_heights(const clast_ray rays[SIDE * SIDE], const clast_hit hits[SIDE * SIDE])
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        if (hits[i].instance == CLAST_NONE) {
            printf("%10s", "-");
        } else {
            printf("%10.4g", (double)(rays[i].origin[1] - hits[i].t));
        }
        if (i % SIDE == SIDE - 1) {
            printf("\n");
        }
    }
}

// Of the first hit, all that there is to know.
static void print_surface(const clast_renderer *renderer, const clast_context *context,
                          const clast_hit hits[SIDE * SIDE])
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        if (hits[i].instance != CLAST_NONE) {
            clast_surface surface;
            check(clast_renderer_locate(renderer, &hits[i], &surface), context);
            printf("ray %d: instance %u, geometry %u, triangle %u, material %u, at %g %g %g, normal %g %g %g\n", i,
                   hits[i].instance, surface.geometry, surface.primitive, surface.material, (double)surface.position[0],
                   (double)surface.position[1], (double)surface.position[2], (double)surface.shading_normal[0],
                   (double)surface.shading_normal[1], (double)surface.shading_normal[2]);
            return;
        }
    }
    printf("no ray hits anything\n");
}

int main(int count, char **arguments)
{
    if (count != 2) {
        fprintf(stderr, "usage: trace_rays SCENE\n");
        return 2;
    }
    clast_context *context = NULL;
    clast_scene *scene = NULL;
    clast_renderer *renderer = NULL;
    check(clast_context_create(NULL, &context), context);
    check(clast_scene_load(context, arguments[1], &scene), context);
    check(clast_renderer_create(scene, &renderer), context);
    check(clast_renderer_commit(renderer, NULL), context); // cooks, and builds what rays need

    float lower[3];
    float upper[3];
    clast_ray rays[SIDE * SIDE];
    clast_hit hits[SIDE * SIDE];
    clast_scene_bounds(scene, lower, upper);
    aim(lower, upper, rays);
    check(clast_renderer_trace_closest(renderer, rays, SIDE * SIDE, hits), context);
    print_heights(rays, hits);
    print_surface(renderer, context, hits);

    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
    clast_context_destroy(context);
    return 0;
}
