// SPDX-License-Identifier: Apache-2.0
// Which device makes a picture: what there is without a driver, and what a software driver makes of the same scene. The driver is
// that of VK_DRIVER_FILES; where there is none, only what needs none is tested.
#include "test.h"

#include <math.h>
#include <string.h>

#include "shapes.h"

#include "clast/clast.h"

enum { WIDTH = 32, HEIGHT = 24, PIXELS = WIDTH * HEIGHT };

static char driver[4096]; // as the test was started; empty: none

static void hide_drivers(void)
{
    setenv("VK_DRIVER_FILES", "/nowhere/driver.json", 1);
    setenv("VK_ICD_FILENAMES", "/nowhere/driver.json", 1);
}

static void show_drivers(void)
{
    setenv("VK_DRIVER_FILES", driver, 1);
    setenv("VK_ICD_FILENAMES", driver, 1);
}

typedef struct world {
    clast_context *context;
    clast_scene *scene;
    clast_renderer *renderer;
    float colour[3 * PIXELS];
    uint32_t instance[PIXELS];
    clast_render_statistics statistics;
} world;

static world *world_open(clast_context *context)
{
    world *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->context = context;
    assert_ok(context, clast_scene_create(context, &w->scene));
    shape_add_instance(context, w->scene, shape_add_wave(context, w->scene, 3), 0, -1, 0, 1);
    shape_add_instance(context, w->scene, shape_add_sphere(context, w->scene, 12, 8), 0, 0, 0, 1);
    assert_ok(context, clast_renderer_create(w->scene, &w->renderer));
    return w;
}

static void world_close(world *w)
{
    clast_renderer_destroy(w->renderer);
    clast_scene_destroy(w->scene);
    free(w);
}

static clast_status render(world *w, clast_device device, const char *name)
{
    clast_render_settings settings = {.width = WIDTH,
                                      .height = HEIGHT,
                                      .spp = 2,
                                      .bounces = 2,
                                      .camera = "0,1,6/0,0,0",
                                      .device = device,
                                      .device_name = name};
    const clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, w->colour}, {CLAST_VIEW_INSTANCE, w->instance}};
    return clast_render(w->renderer, &settings, outputs, 2, &w->statistics);
}

static void without_a_driver_auto_is_the_processor(void **state)
{
    hide_drivers();
    world *w = world_open(*state);
    assert_ok(w->context, render(w, CLAST_DEVICE_AUTO, NULL));
    assert_string_equal(w->statistics.device, "cpu");
    assert_string_equal(w->statistics.driver, "");
    assert_true(w->statistics.triangles > 0);
    world_close(w);
}

static void without_a_driver_vulkan_is_refused_with_the_reason(void **state)
{
    hide_drivers();
    world *w = world_open(*state);
    assert_int_equal(render(w, CLAST_DEVICE_VULKAN, NULL), CLAST_ERROR_DEVICE);
    assert_non_null(strstr(clast_context_error(w->context), "vulkan: "));
    assert_ok(w->context, render(w, CLAST_DEVICE_CPU, NULL)); // the renderer is as good as before
    world_close(w);
}

static void a_software_driver_counts_only_by_its_name(void **state)
{
    show_drivers();
    world *w = world_open(*state);
    assert_ok(w->context, render(w, CLAST_DEVICE_AUTO, NULL));
    assert_string_equal(w->statistics.device, "cpu");
    assert_int_equal(render(w, CLAST_DEVICE_VULKAN, NULL), CLAST_ERROR_DEVICE);
    assert_non_null(strstr(clast_context_error(w->context), "llvmpipe"));
    assert_int_equal(render(w, CLAST_DEVICE_VULKAN, "no such device"), CLAST_ERROR_DEVICE);
    world_close(w);
}

static void compare(const world *a, const world *b)
{
    assert_memory_equal(a->instance, b->instance, sizeof a->instance);
    assert_int_equal(a->statistics.triangles, b->statistics.triangles);
    assert_int_equal(a->statistics.clusters, b->statistics.clusters);
    assert_int_equal(a->statistics.vertices, b->statistics.vertices);
    assert_true(a->statistics.cluster_fill == b->statistics.cluster_fill);
    double difference = 0.0, sum = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        difference += fabs((double)(a->colour[i] - b->colour[i]));
        sum += (double)a->colour[i];
    }
    assert_true(sum > 0.0 && difference <= 1e-3 * sum);
}

// A renderer goes from the processor to the device, and keeps what it has there; a device is opened once, as its kernels take long
// to compile.
static void a_device_makes_the_processors_picture(void **state)
{
    show_drivers();
    world *a = world_open(*state), *b = world_open(*state);
    clast_ray ray = {.origin = {0, 0, 5}, .direction = {0, 0, -1}, .t_max = INFINITY};
    clast_hit hit;
    assert_ok(a->context, render(a, CLAST_DEVICE_CPU, NULL));
    assert_ok(b->context, render(b, CLAST_DEVICE_CPU, NULL));
    assert_ok(b->context, clast_renderer_trace_closest(b->renderer, &ray, 1, &hit));
    assert_ok(b->context, render(b, CLAST_DEVICE_VULKAN, "llvmpipe"));
    assert_non_null(strstr(b->statistics.device, "llvmpipe"));
    assert_true(strlen(b->statistics.driver) > 0);
    assert_true(b->statistics.device_bytes > 0 && b->statistics.device_bytes_peak >= b->statistics.device_bytes);
    compare(a, b);
    assert_int_equal(clast_renderer_trace_closest(b->renderer, &ray, 1, &hit), CLAST_ERROR_STATE);
    assert_ok(b->context, clast_renderer_commit(b->renderer, NULL));
    assert_ok(b->context, clast_renderer_trace_closest(b->renderer, &ray, 1, &hit));
    assert_int_equal(hit.instance, 1);
    const float aside[12] = {1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 2};
    assert_ok(b->context, clast_scene_set_instance_transform(b->scene, 1, aside));
    assert_ok(b->context, render(b, CLAST_DEVICE_VULKAN, "llvmpipe"));
    for (int i = 0; i < PIXELS; i++) {
        assert_int_not_equal(b->instance[i], 1);
    }
    world_close(a);
    world_close(b);
}

// Puts what the build made of a shader into a folder, under the name of another.
static void put_shader(const char *folder, const char *from, const char *to)
{
    char path[4096], text[1 << 16];
    snprintf(path, sizeof path, "%s/%s.spv.exact", SHADER_FOLDER, from);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    static char bytes[1 << 20];
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_true(size > 0 && size < sizeof bytes);
    snprintf(text, sizeof text, "%s/%s.spv.exact", folder, to);
    file = fopen(text, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static clast_status render_with(world *w, const char *shaders)
{
    clast_render_settings settings = {.width = WIDTH,
                                      .height = HEIGHT,
                                      .spp = 2,
                                      .bounces = 2,
                                      .camera = "0,1,6/0,0,0",
                                      .device = CLAST_DEVICE_VULKAN,
                                      .device_name = "llvmpipe",
                                      .shaders = shaders};
    const clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, w->colour}, {CLAST_VIEW_INSTANCE, w->instance}};
    return clast_render(w->renderer, &settings, outputs, 2, &w->statistics);
}

// Kernels of a folder are used from the next picture on, in place of the library's.
static void kernels_of_a_folder_are_read_anew(void **state)
{
    show_drivers();
    world *w = world_open(*state);
    float plain[3 * PIXELS];
    char folder[] = "/tmp/clast-shaders-XXXXXX", path[4096];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/RENDER_FINISH.spv.exact", folder);
    assert_ok(w->context, render_with(w, folder));
    memcpy(plain, w->colour, sizeof plain);
    put_shader(folder, "PROBE_NOTHING", "RENDER_FINISH");
    assert_ok(w->context, render_with(w, folder));
    for (int i = 0; i < 3 * PIXELS; i++) {
        assert_true(w->colour[i] == 0.0f);
    }
    put_shader(folder, "RENDER_FINISH", "RENDER_FINISH");
    assert_ok(w->context, render_with(w, folder));
    assert_memory_equal(plain, w->colour, sizeof plain);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("no kernel", 1, 9, file), 9);
    fclose(file);
    assert_int_equal(render_with(w, folder), CLAST_ERROR_MALFORMED);
    assert_non_null(strstr(clast_context_error(w->context), path));
    remove(path);
    assert_ok(w->context, render_with(w, folder));
    assert_memory_equal(plain, w->colour, sizeof plain);
    remove(folder);
    world_close(w);
}

int main(void)
{
    const char *files = getenv("VK_DRIVER_FILES");
    snprintf(driver, sizeof driver, "%s", files != NULL ? files : "");
    const struct CMUnitTest bare[] = {
        CONTEXT_TEST(without_a_driver_auto_is_the_processor),
        CONTEXT_TEST(without_a_driver_vulkan_is_refused_with_the_reason),
    };
    const struct CMUnitTest driven[] = {
        CONTEXT_TEST(a_software_driver_counts_only_by_its_name),
        CONTEXT_TEST(a_device_makes_the_processors_picture),
        CONTEXT_TEST(kernels_of_a_folder_are_read_anew),
    };
    int failed = cmocka_run_group_tests(bare, NULL, NULL);
    if (driver[0] != '\0') {
        failed += cmocka_run_group_tests(driven, NULL, NULL);
    }
    return failed;
}
