// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "clast/clast.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static const float quad_positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float quad_coordinates[] = {0, 1, 1, 1, 1, 0, 0, 0};
static const uint32_t quad_indices[] = {0, 1, 2, 0, 2, 3};

static const clast_render_settings small = {.width = WIDTH, .height = HEIGHT, .spp = 2, .camera = "0,0,4/0,0,0"};

// A square of two triangles that faces +z, placed once.
static clast_scene *quad_scene(clast_context *context, uint32_t *instance)
{
    clast_scene *scene = NULL;
    assert_ok(context, clast_scene_create(context, &scene));
    clast_mesh mesh = {.vertex_count = 4,
                       .triangle_count = 2,
                       .positions = quad_positions,
                       .coordinates = {quad_coordinates},
                       .indices = quad_indices,
                       .material = CLAST_NONE};
    uint32_t geometry = 0;
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, "quad", &geometry));
    assert_ok(context, clast_scene_add_instance(scene, geometry, NULL, NULL, instance));
    return scene;
}

static clast_hit trace(clast_context *context, const clast_renderer *renderer, float x, float y)
{
    clast_ray ray = {.origin = {x, y, 5}, .direction = {0, 0, -1}, .t_max = INFINITY};
    clast_hit hit;
    assert_ok(context, clast_renderer_trace_closest(renderer, &ray, 1, &hit));
    uint8_t occluded = 2;
    assert_ok(context, clast_renderer_trace_any(renderer, &ray, 1, &occluded));
    assert_int_equal(occluded, hit.instance != CLAST_NONE);
    return hit;
}

static void rays_need_a_commit(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    clast_ray ray = {.direction = {0, 0, -1}, .t_max = 1};
    clast_hit hit;
    clast_render_statistics statistics;
    assert_int_equal(clast_renderer_trace_closest(renderer, &ray, 1, &hit), CLAST_ERROR_STATE);
    assert_int_equal(clast_renderer_statistics(renderer, &statistics), CLAST_ERROR_STATE);
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    assert_ok(context, clast_renderer_trace_closest(renderer, &ray, 1, &hit));
    assert_int_equal(clast_renderer_trace_closest(renderer, NULL, 1, &hit), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(context, clast_renderer_statistics(renderer, &statistics));
    assert_int_equal(statistics.triangles, 2);
    assert_int_equal(statistics.clusters, 1);
    assert_int_equal(statistics.instances, 1);
    assert_true(statistics.blas_bytes > 0 && statistics.tlas_bytes > 0 && statistics.clas_bytes > 0);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static void edits_are_seen_by_the_next_commit(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    assert_int_equal(trace(context, renderer, 0.5f, 0.25f).instance, instance);
    const float aside[12] = {1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 2};
    assert_ok(context, clast_scene_set_instance_transform(scene, instance, aside));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    assert_int_equal(trace(context, renderer, 0.5f, 0.25f).instance, CLAST_NONE);
    clast_hit hit = trace(context, renderer, 10.5f, 0.25f);
    assert_int_equal(hit.instance, instance);
    assert_true(fabsf(hit.t - 3.0f) < 1e-5f);
    assert_ok(context, clast_scene_remove_instance(scene, instance));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    assert_int_equal(trace(context, renderer, 10.5f, 0.25f).instance, CLAST_NONE);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static void replaced_positions_need_a_commit(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    clast_hit hit = trace(context, renderer, 0.5f, 0.25f);
    float positions[12];
    for (int i = 0; i < 12; i++) {
        positions[i] = quad_positions[i] + 3.0f;
    }
    assert_ok(context, clast_scene_set_mesh_positions(scene, 0, positions, NULL));
    clast_ray ray = {.origin = {0, 0, 5}, .direction = {0, 0, -1}, .t_max = INFINITY};
    clast_surface surface;
    uint8_t occluded;
    assert_int_equal(clast_renderer_locate(renderer, &hit, &surface), CLAST_ERROR_STATE);
    assert_int_equal(clast_renderer_trace_closest(renderer, &ray, 1, &hit), CLAST_ERROR_STATE);
    assert_int_equal(clast_renderer_trace_any(renderer, &ray, 1, &occluded), CLAST_ERROR_STATE);
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    assert_int_equal(trace(context, renderer, 0.5f, 0.25f).instance, CLAST_NONE);
    assert_int_equal(trace(context, renderer, 3.5f, 3.25f).instance, instance);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static void a_hit_is_located_on_the_surface(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    const float mirrored[12] = {-2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 1};
    assert_ok(context, clast_scene_set_instance_transform(scene, instance, mirrored));
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    clast_hit hit = trace(context, renderer, 1.0f, 0.5f);
    clast_surface surface;
    assert_ok(context, clast_renderer_locate(renderer, &hit, &surface));
    assert_true(fabsf(surface.position[0] - 1.0f) < 1e-5f && fabsf(surface.position[1] - 0.5f) < 1e-5f);
    assert_true(fabsf(surface.position[2] - 1.0f) < 1e-5f);
    assert_true(fabsf(fabsf(surface.geometric_normal[2]) - 1.0f) < 1e-5f);
    // The side agrees with what the trace reports.
    assert_true(surface.geometric_normal[2] * hit.normal[2] > 0.0f);
    // x = 1 in the world is x = -0.5 in the mesh: a quarter of its width; y is 0.25: three eighths from the top.
    assert_true(fabsf(surface.coordinates[0][0] - 0.25f) < 1e-5f && fabsf(surface.coordinates[0][1] - 0.375f) < 1e-5f);
    hit.triangle = 77;
    assert_int_equal(clast_renderer_locate(renderer, &hit, &surface), CLAST_ERROR_INVALID_ARGUMENT);
    hit.instance = 5;
    assert_int_equal(clast_renderer_locate(renderer, &hit, &surface), CLAST_ERROR_INVALID_ARGUMENT);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static void settings_out_of_range_are_named(void **state)
{
    clast_context *context = *state;
    clast_render_settings settings = {0};
    assert_ok(context, clast_render_settings_resolve(context, &settings));
    assert_int_equal(settings.width, 1280);
    assert_int_equal(settings.spp, 16);
    assert_string_equal(settings.camera, "");
    settings.bounces = 2000;
    assert_int_equal(clast_render_settings_resolve(context, &settings), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "bounces"));
    settings = (clast_render_settings){.rate = (double)NAN};
    assert_int_equal(clast_render_settings_resolve(context, &settings), CLAST_ERROR_INVALID_ARGUMENT);
    settings = (clast_render_settings){.tonemap = 9};
    assert_int_equal(clast_render_settings_resolve(context, &settings), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "tonemap"));
}

static void outputs_are_checked(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    float pixels[3 * PIXELS];
    clast_render_output twice[2] = {{CLAST_VIEW_COLOUR, pixels}, {CLAST_VIEW_COLOUR, pixels}};
    clast_render_output nowhere = {CLAST_VIEW_COLOUR, NULL};
    clast_render_output unknown = {CLAST_VIEW_COUNT_, pixels};
    assert_int_equal(clast_render(renderer, &small, NULL, 0, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_render(renderer, &small, twice, 2, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_render(renderer, &small, &nowhere, 1, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_render(renderer, &small, &unknown, 1, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(context, clast_render(renderer, &small, twice, 1, NULL));
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static double brightness(clast_context *context, clast_renderer *renderer, const char *environment)
{
    static float pixels[3 * PIXELS];
    clast_render_settings settings = small;
    settings.env = environment;
    clast_render_output output = {CLAST_VIEW_COLOUR, pixels};
    assert_ok(context, clast_render(renderer, &settings, &output, 1, NULL));
    double sum = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        assert_true(isfinite(pixels[i]));
        sum += (double)pixels[i];
    }
    return sum;
}

static void a_dark_scene_gets_a_sky_and_the_setting_replaces_it(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    double sky = brightness(context, renderer, NULL);
    assert_true(sky > 0.0);
    assert_true(brightness(context, renderer, "0,0,0") == 0.0);
    assert_true(brightness(context, renderer, "2,2,2") > brightness(context, renderer, "1,1,1"));
    assert_true(brightness(context, renderer, "sky") == sky);
    assert_true(brightness(context, renderer, "") == sky); // nothing of the settings before is left
    clast_render_settings settings = small;
    settings.env = "no such file.hdr";
    float pixels[3 * PIXELS];
    clast_render_output output = {CLAST_VIEW_COLOUR, pixels};
    assert_int_equal(clast_render(renderer, &settings, &output, 1, NULL), CLAST_ERROR_FILE_NOT_FOUND);
    clast_environment own = {.type = CLAST_ENVIRONMENT_CONSTANT, .colour = {0.5f, 0.5f, 0.5f}};
    assert_ok(context, clast_scene_set_environment(scene, &own));
    double grey = brightness(context, renderer, "");
    assert_true(grey > 0.0 && grey != sky);
    assert_true(brightness(context, renderer, "0.5,0.5,0.5") == grey);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

typedef struct thread_work {
    const clast_renderer *renderer;
    clast_hit hits[PIXELS];
    clast_status status;
} thread_work;

static void *trace_grid(void *argument)
{
    thread_work *work = argument;
    clast_ray rays[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        rays[i] = (clast_ray){
            .origin = {3.0f * (float)(i % WIDTH) / WIDTH - 1.5f, 3.0f * (float)(i / WIDTH) / HEIGHT - 1.5f, 5},
            .direction = {0, 0, -1},
            .t_max = INFINITY};
    }
    work->status = clast_renderer_trace_closest(work->renderer, rays, PIXELS, work->hits);
    return NULL;
}

static void rays_may_be_traced_from_threads_at_once(void **state)
{
    clast_context *context = *state;
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_ok(context, clast_renderer_commit(renderer, NULL));
    enum { THREADS = 4 };
    static thread_work works[THREADS];
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) {
        works[i].renderer = renderer;
        assert_int_equal(pthread_create(&threads[i], NULL, trace_grid, &works[i]), 0);
    }
    int hits = 0;
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
        assert_int_equal(works[i].status, CLAST_OK);
    }
    for (int i = 0; i < PIXELS; i++) {
        for (int j = 1; j < THREADS; j++) {
            assert_int_equal(works[0].hits[i].instance, works[j].hits[i].instance);
        }
        hits += works[0].hits[i].instance != CLAST_NONE;
    }
    assert_true(hits > PIXELS / 4 && hits < PIXELS);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

static bool stop_the_render(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)user;
    return strcmp(stage, "render") != 0 || done * 4 < total;
}

static void a_cancelled_render_keeps_what_it_has(void **state)
{
    (void)state;
    clast_context *context = NULL;
    assert_int_equal(
        clast_context_create(&(clast_context_desc){.threads = 2, .progress = {stop_the_render, NULL}}, &context),
        CLAST_OK);
    uint64_t before = clast_context_memory(context);
    uint32_t instance = 0;
    clast_scene *scene = quad_scene(context, &instance);
    clast_renderer *renderer = NULL;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    clast_render_settings settings = small;
    settings.spp = 64;
    settings.env = "1,1,1";
    static float pixels[3 * PIXELS];
    clast_render_output output = {CLAST_VIEW_COLOUR, pixels};
    clast_render_statistics statistics;
    assert_int_equal(clast_render(renderer, &settings, &output, 1, &statistics), CLAST_ERROR_CANCELLED);
    assert_true(statistics.samples > 0 && statistics.samples < 64);
    assert_true(fabsf(pixels[0] - 1.0f) < 1e-4f); // a corner shows the environment, rightly exposed
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
    assert_int_equal(clast_context_memory(context), before);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(rays_need_a_commit),
        CONTEXT_TEST(edits_are_seen_by_the_next_commit),
        CONTEXT_TEST(replaced_positions_need_a_commit),
        CONTEXT_TEST(a_hit_is_located_on_the_surface),
        CONTEXT_TEST(settings_out_of_range_are_named),
        CONTEXT_TEST(outputs_are_checked),
        CONTEXT_TEST(a_dark_scene_gets_a_sky_and_the_setting_replaces_it),
        CONTEXT_TEST(rays_may_be_traced_from_threads_at_once),
        cmocka_unit_test(a_cancelled_render_keeps_what_it_has),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
