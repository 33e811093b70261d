// SPDX-License-Identifier: Apache-2.0
// Buffers of a device as small as they may be, and twice as large, one after the other: the picture stays the same.
#include "render/picture.h"

#include <string.h>

#include "vulkan/render.h"
#include "vulkan/test_device.h"

enum { SIZE = 16, NAMES_MOST = 128, NAME_BYTES = 64 };

// Which buffers there are, and which one is larger than it need be.
typedef struct sizes {
    char names[NAMES_MOST][NAME_BYTES];
    uint32_t name_count;
    const char *forced; // null: none
    bool met;
} sizes;

static sizes all;
static test_device device;

static uint64_t size_of(void *user, const char *name, uint64_t bytes)
{
    (void)user;
    uint32_t i = 0;
    while (i < all.name_count && strcmp(all.names[i], name) != 0) {
        i++;
    }
    if (i == all.name_count && all.forced == NULL) {
        assert_true(all.name_count < NAMES_MOST && strlen(name) < NAME_BYTES);
        snprintf(all.names[all.name_count++], NAME_BYTES, "%s", name);
    }
    bool forced = all.forced != NULL && strcmp(name, all.forced) == 0;
    all.met = all.met || forced;
    return forced ? 2 * bytes : bytes;
}

// Something of each kind: a ball of clusters, a bumpy one, a sheet, a lamp and a sky.
static picture open_scene(void)
{
    picture p = picture_open(device.context, SIZE, 2);
    picture_add_sphere(&p, vec3(-1, 0, 0), 0.8f, 12, picture_material(&p, 0.7f, 0, 0.5f, 0));
    uint32_t bumpy = picture_material(&p, 0.5f, 0, 0.4f, 0);
    uint32_t geometry = shape_add_sphere(device.context, p.scene, 8, 6);
    shape_displace(device.context, p.scene, geometry, bumpy, 0.1f);
    shape_add_instance(device.context, p.scene, geometry, 1, 0, 0, 1);
    shape_add_instance(device.context, p.scene, shape_add_wave(device.context, p.scene, 3), 0, -1, 0, 1);
    picture_add_square(&p, vec3(0, 2, 0), vec3(0.5f, 0, 0), vec3(0, 0, 0.5f),
                       picture_material(&p, 0.5f, 0, 0.5f, 8.0f));
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.5f, 0.5f}};
    assert_ok(device.context, clast_scene_set_environment(p.scene, &sky));
    picture_look(&p, vec3(0, 1, 5), vec3(0, 0, 0), 0.8f);
    p.settings.bounces = 2;
    return p;
}

// A frame and a picture with nothing kept from before.
static void render(const picture *p, float *pixels)
{
    uint32_t instances[SIZE * SIZE];
    clast_frame *frame;
    clast_vulkan_frame *made;
    assert_ok(device.context, clast_frame_create(p->scene, p->cooked, &frame));
    assert_ok(device.context, clast_vulkan_frame_create(device.gpu, &made));
    frame->device = made;
    frame->settings = p->frame->settings;
    assert_ok(device.context,
              clast_frame_run(frame, &clast_vulkan_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, pixels}, {CLAST_VIEW_INSTANCE, instances}};
    clast_render_statistics statistics;
    assert_ok(device.context, clast_render_frame(frame, &clast_vulkan_backend, &p->settings, outputs, 2, &statistics));
    clast_vulkan_frame_destroy(made);
    clast_frame_destroy(frame);
}

static void pictures_do_not_depend_on_room(void **state)
{
    (void)state;
    picture p = open_scene();
    picture_build(&p);
    static float expected[SIZE * SIZE * 3], pixels[SIZE * SIZE * 3];
    render(&p, expected); // each as small as may be
    float sum = 0.0f;
    for (uint32_t i = 0; i < SIZE * SIZE * 3; i++) {
        sum += expected[i];
    }
    assert_true(sum > 1.0f && all.name_count > 20);
    for (uint32_t i = 0; i < all.name_count; i++) {
        all.forced = all.names[i];
        all.met = false;
        render(&p, pixels);
        assert_true(all.met);
        if (memcmp(pixels, expected, sizeof pixels) != 0) {
            fail_msg("twice the room for \"%s\" makes another picture", all.forced);
        }
    }
    print_message("%u buffers\n", all.name_count);
    picture_close(&p);
}

int main(void)
{
    device = test_device_open_as(
        &(clast_gpu_desc){.software = true, .hardware = true, .validate = true, .size_hook = {size_of, NULL}});
    const struct CMUnitTest tests[] = {cmocka_unit_test(pictures_do_not_depend_on_room)};
    int failed = cmocka_run_group_tests_name("room of buffers on a device", tests, NULL, NULL);
    return test_device_close(&device) ? failed : 1;
}
