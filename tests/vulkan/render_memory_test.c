// SPDX-License-Identifier: Apache-2.0
// Memory that runs out in the middle of a render on a device: a clean error, nothing that dangles, and the next render makes
// the same picture.
#include "render/picture.h"

#include "scarce.h"
#include "vulkan/render.h"

enum { SIZE = 24 };

static shortage scarce = {-1, 0};
static clast_context *context;
static clast_gpu *gpu;

// A lamp over a textured ball, under a sky.
static picture open_scene(void)
{
    picture p = picture_open(context, SIZE, 2);
    uint8_t texels[64];
    for (uint32_t i = 0; i < sizeof texels; i++) {
        texels[i] = (uint8_t)(40 + i * 37 % 200);
    }
    clast_image image = {4, 4, 4, CLAST_PIXEL_UNORM8, texels};
    clast_material_desc desc = clast_material_defaults();
    uint32_t image_number, material;
    assert_ok(context, clast_scene_add_image(p.scene, &image, NULL, &image_number));
    clast_texture texture = {image_number, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    assert_ok(context, clast_scene_add_texture(p.scene, &texture, &desc.base_colour_texture.texture));
    assert_ok(context, clast_scene_add_material(p.scene, &desc, NULL, &material));
    picture_add_sphere(&p, vec3(0, 0, 0), 1.0f, 12, material);
    picture_add_square(&p, vec3(0, 2, 0), vec3(0.5f, 0, 0), vec3(0, 0, 0.5f),
                       picture_material(&p, 0.5f, 0, 0.5f, 8.0f));
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.5f, 0.5f}};
    assert_ok(context, clast_scene_set_environment(p.scene, &sky));
    picture_look(&p, vec3(0, 1, 5), vec3(0, 0, 0), 0.8f);
    p.settings.bounces = 2;
    return p;
}

static clast_status render(const picture *p, clast_frame *frame, float *pixels, uint32_t *instances)
{
    clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, pixels}, {CLAST_VIEW_INSTANCE, instances}};
    clast_render_statistics statistics;
    return clast_render_frame(frame, &clast_vulkan_backend, &p->settings, outputs, 2, &statistics);
}

// With the nth allocation failing; true where there was one.
static bool render_short(const picture *p, clast_frame *frame, int64_t n, const float *expected)
{
    static float pixels[SIZE * SIZE * 3];
    static uint32_t instances[SIZE * SIZE];
    uint32_t failed = scarce.failed;
    scarce.left = n;
    clast_status status = render(p, frame, pixels, instances);
    scarce.left = -1;
    bool hit = scarce.failed != failed;
    assert_int_equal(status, hit ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_OK);
    if (hit) {
        assert_true(clast_context_error(context)[0] != '\0');
        assert_ok(context, render(p, frame, pixels, instances));
    }
    assert_memory_equal(pixels, expected, sizeof pixels);
    return hit;
}

static void a_render_recovers_from_want_of_memory(void **state)
{
    (void)state;
    uint64_t kept = 0, kept_on_device = 0; // by the device itself, for the next commands
    picture p = open_scene();
    picture_build(&p);
    static float expected[SIZE * SIZE * 3];
    static uint32_t instances[SIZE * SIZE];
    int64_t n = 0;
    bool hit = true;
    for (; hit; n++) { // what was kept from the render before is made anew
        clast_frame *frame;
        clast_vulkan_frame *made;
        assert_ok(context, clast_frame_create(p.scene, p.cooked, &frame));
        assert_ok(context, clast_vulkan_frame_create(gpu, &made));
        frame->device = made;
        frame->settings = p.frame->settings;
        assert_ok(context, clast_frame_run(frame, &clast_vulkan_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
        if (n == 0) {
            assert_ok(context, render(&p, frame, expected, instances));
        }
        hit = render_short(&p, frame, n, expected);
        clast_vulkan_frame_destroy(made);
        clast_frame_destroy(frame);
        kept = n == 0 ? clast_context_memory(context) : kept;
        kept_on_device = n == 0 ? clast_gpu_bytes(gpu) : kept_on_device;
    }
    assert_true(n > 10);
    print_message("%d allocations failed, one after the other\n", (int)n - 1);
    assert_int_equal(clast_gpu_bytes(gpu), kept_on_device);
    assert_int_equal(clast_context_memory(context), kept);
    picture_close(&p);
}

int main(void)
{
    clast_context_desc desc = {.memory = {scarce_reallocate, &scarce}, .threads = 1};
    if (clast_context_create(&desc, &context) != CLAST_OK) {
        return 1;
    }
    uint64_t before = clast_context_memory(context);
    if (clast_gpu_create(context, &(clast_gpu_desc){.software = true, .hardware = true}, &gpu) != CLAST_OK) {
        fprintf(stderr, "skipped: %s\n", clast_context_error(context));
        clast_context_destroy(context);
        return 77;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_render_recovers_from_want_of_memory)};
    int failed = cmocka_run_group_tests_name("memory of renders on a device", tests, NULL, NULL);
    clast_gpu_destroy(gpu);
    uint64_t left = clast_context_memory(context) - before;
    clast_context_destroy(context);
    if (left != 0) {
        fprintf(stderr, "%llu bytes left over\n", (unsigned long long)left);
    }
    return left == 0 ? failed : 1;
}
