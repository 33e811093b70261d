// SPDX-License-Identifier: Apache-2.0
// Every allocation, file open and map that a small scene's life needs is made to fail once, the 1st, 2nd, ... until none
// does: each failure is a clean error, leaves nothing behind, and the same context works afterwards.
#include "test.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "clast/clast.h"

typedef struct fault_switch {
    int64_t allocations_left; // the one that makes it 0 fails; negative: never
    int64_t files_left;
    uint64_t allocations_failed;
    uint64_t files_failed;
} fault_switch;

static bool is_due(int64_t *left)
{
    if (*left < 0) {
        return false;
    }
    return (*left)-- == 0;
}

static void *failing_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)old_size;
    fault_switch *faults = user;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    if (is_due(&faults->allocations_left)) {
        faults->allocations_failed++;
        return NULL;
    }
    return realloc(pointer, new_size);
}

static clast_status failing_map(void *user, const char *path, clast_file_view *view)
{
    fault_switch *faults = user;
    if (is_due(&faults->files_left)) {
        faults->files_failed++;
        return CLAST_ERROR_FILE_READ;
    }
    return clast_machine_files.map(NULL, path, view);
}

static void map_ended(void *user, clast_file_view *view)
{
    (void)user;
    clast_machine_files.unmap(NULL, view);
}

static clast_status failing_create(void *user, const char *path, void **file)
{
    fault_switch *faults = user;
    if (is_due(&faults->files_left)) {
        faults->files_failed++;
        return CLAST_ERROR_FILE_WRITE;
    }
    return clast_machine_files.create(NULL, path, file);
}

static clast_status failing_write(void *user, void *file, const void *data, size_t size)
{
    fault_switch *faults = user;
    if (is_due(&faults->files_left)) {
        faults->files_failed++;
        return CLAST_ERROR_FILE_WRITE;
    }
    return clast_machine_files.write(NULL, file, data, size);
}

// One thread: the order of allocations is then the same each time.
static clast_context *faulty_context(fault_switch *faults)
{
    clast_context *context;
    clast_context_desc desc = {
        .memory = {failing_reallocate, faults},
        .file = {failing_map, map_ended, failing_create, failing_write, clast_machine_files.commit,
                 clast_machine_files.discard, faults},
        .threads = 1,
    };
    *faults = (fault_switch){-1, -1, 0, 0};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    return context;
}

// A second mesh that shares the first one's arrays, and moves by a skin and a morph target.
static clast_status add_motion(clast_scene *scene, uint32_t geometry)
{
    enum { VERTICES = 24 * 24 };
    static float moves[3 * VERTICES], weights[VERTICES];
    static uint16_t joints[VERTICES];
    const float weight = 0.5f, times[] = {0, 1}, values[] = {0, 0, 0, 1, 1, 1}, rises[] = {0, 1};
    uint32_t node = 0, child = 0, skin, number, shared = 0;
    for (size_t i = 0; i < VERTICES; i++) {
        moves[3 * i + 1] = weights[i] = 1;
    }
    clast_node_desc desc = {.parent = CLAST_NONE};
    clast_status status = clast_scene_add_node(scene, &desc, "root", &node);
    desc.parent = node;
    status = status != CLAST_OK ? status : clast_scene_add_node(scene, &desc, "child", &child);
    status = status != CLAST_OK ? status : clast_scene_set_node_weights(scene, node, &weight, 1);
    status = status != CLAST_OK ? status : clast_scene_share_mesh(scene, geometry, "moving", &shared);
    clast_skin_desc bones = {.joint_count = 1, .joints = &child};
    status = status != CLAST_OK ? status : clast_scene_add_skin(scene, &bones, &skin);
    status = status != CLAST_OK ? status : clast_scene_set_mesh_skin(scene, shared, skin, 1, joints, weights);
    const clast_morph_target target = {.positions = moves};
    status = status != CLAST_OK ? status : clast_scene_set_mesh_morph(scene, shared, &target, 1, node);
    const clast_channel channels[] = {
        {child, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 2, times, values},
        {node, CLAST_ANIMATED_WEIGHTS, CLAST_INTERPOLATION_LINEAR, 2, times, rises},
    };
    status = status != CLAST_OK ? status : clast_scene_add_animation(scene, channels, 2, "all of it", &number);
    status = status != CLAST_OK ? status : clast_scene_add_instance(scene, shared, NULL, "c", &number);
    return status != CLAST_OK ? status : clast_scene_attach_instance(scene, number, node);
}

static clast_status fill_scene(clast_scene *scene)
{
    enum { SIDE = 24 };
    float positions[SIDE * SIDE * 3], coordinates[SIDE * SIDE * 2];
    uint32_t indices[(SIDE - 1) * (SIDE - 1) * 6], count = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        float x = (float)(i % SIDE), z = (float)(i / SIDE);
        positions[3 * i] = x;
        positions[3 * i + 1] = sinf(x) * cosf(z);
        positions[3 * i + 2] = z;
        coordinates[2 * i] = x / SIDE;
        coordinates[2 * i + 1] = z / SIDE;
        if (i % SIDE != SIDE - 1 && i / SIDE != SIDE - 1) {
            const uint32_t quad[6] = {i, i + SIDE, i + SIDE + 1, i, i + SIDE + 1, i + 1};
            memcpy(indices + count, quad, sizeof quad);
            count += 6;
        }
    }
    const uint8_t pixels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
    clast_image image = {2, 2, 4, CLAST_PIXEL_UNORM8, pixels};
    uint32_t number, texture, geometry, wave;
    clast_status status = clast_scene_add_image(scene, &image, "checks", &number);
    clast_texture reading = {.image = number};
    status = status != CLAST_OK ? status : clast_scene_add_texture(scene, &reading, &texture);
    clast_material_desc material = clast_material_defaults();
    material.base_colour_texture.texture = 0;
    material.alpha_mode = CLAST_ALPHA_MASK;
    material.emissive[0] = 1.0f;
    status = status != CLAST_OK ? status : clast_scene_add_material(scene, &material, "glowing", &number);
    clast_mesh mesh = {.vertex_count = SIDE * SIDE,
                       .triangle_count = count / 3,
                       .positions = positions,
                       .coordinates = {coordinates},
                       .indices = indices,
                       .material = 1};
    status = status != CLAST_OK ? status : clast_scene_add_mesh(scene, &mesh, "sheet", &geometry);
    clast_wave sheet = {.size = 20, .tiles = 3, .amplitude = 0.5f, .wavelength = 5, .speed = 1, .material = CLAST_NONE};
    status = status != CLAST_OK ? status : clast_scene_add_wave(scene, &sheet, "sea", &wave);
    status = status != CLAST_OK ? status : clast_scene_add_instance(scene, geometry, NULL, "a", &number);
    status = status != CLAST_OK ? status : clast_scene_add_instance(scene, wave, NULL, "b", &number);
    clast_light_desc light = {.type = CLAST_LIGHT_POINT, .position = {5, 9, 5}, .colour = {1, 1, 1}, .intensity = 100};
    status = status != CLAST_OK ? status : clast_scene_add_light(scene, &light, "lamp", &number);
    status = status != CLAST_OK ? status : add_motion(scene, geometry);
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {1, 1, 0}};
    return status != CLAST_OK ? status : clast_scene_set_environment(scene, &sky);
}

// A scene's whole life: made, committed, rendered, moved, rendered again, written.
static clast_status live(clast_context *context, const char *folder)
{
    enum { WIDTH = 12, HEIGHT = 8 };
    clast_scene *scene = NULL;
    clast_renderer *renderer = NULL;
    float colour[WIDTH * HEIGHT * 3];
    uint32_t ids[WIDTH * HEIGHT];
    const clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, colour}, {CLAST_VIEW_CLUSTER, ids}};
    clast_render_settings settings = {
        .width = WIDTH, .height = HEIGHT, .spp = 1, .bounces = 2, .device = CLAST_DEVICE_CPU};
    clast_status status = clast_scene_create(context, &scene);
    status = status != CLAST_OK ? status : fill_scene(scene);
    status = status != CLAST_OK ? status : clast_renderer_create(scene, &renderer);
    status = status != CLAST_OK ? status : clast_render(renderer, &settings, outputs, 2, NULL);
    settings.time = 0.3;
    status = status != CLAST_OK ? status : clast_render(renderer, &settings, outputs, 2, NULL);
    const char *endings[] = {"png", "pfm", "exr"};
    for (int i = 0; i < 3 && status == CLAST_OK; i++) {
        char path[512];
        uint8_t display[WIDTH * HEIGHT * 3];
        snprintf(path, sizeof path, "%s/faults.%s", folder, endings[i]);
        status = clast_view_to_display(context, CLAST_VIEW_COLOUR, colour, WIDTH, HEIGHT, &settings, display);
        clast_image image = {WIDTH, HEIGHT, 3, i == 0 ? CLAST_PIXEL_UNORM8 : CLAST_PIXEL_FLOAT,
                             i == 0 ? (const void *)display : colour};
        status = status != CLAST_OK ? status : clast_image_write(context, path, &image);
        clast_image back;
        status = status != CLAST_OK ? status : clast_image_read(context, path, &back);
        if (status == CLAST_OK) {
            clast_image_free(context, &back);
            remove(path);
        }
    }
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
    return status;
}

static void make_folder(char folder[64])
{
    strcpy(folder, "/tmp/clast_faults_XXXXXX");
    assert_non_null(mkdtemp(folder));
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    fault_switch faults;
    clast_context *context = faulty_context(&faults);
    char folder[64];
    make_folder(folder);
    uint64_t before = clast_context_memory(context);
    uint64_t points = 0;
    for (int64_t k = 0;; k++) {
        faults.allocations_failed = 0;
        faults.allocations_left = k;
        clast_status status = live(context, folder);
        faults.allocations_left = -1;
        assert_int_equal(clast_context_memory(context), before);
        if (faults.allocations_failed == 0) {
            assert_ok(context, status);
            break;
        }
        points++;
        // A few allocations only save work; where one of them fails the call goes on.
        if (status != CLAST_OK) {
            assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
            assert_true(strlen(clast_context_error(context)) > 0);
        }
        if (k % 32 == 0) {
            assert_ok(context, live(context, folder));
        }
    }
    assert_true(points > 50);
    printf("%llu allocations made to fail\n", (unsigned long long)points);
    assert_int_equal(rmdir(folder), 0); // nothing half written is left in it
    clast_context_destroy(context);
}

static void every_file_call_may_fail(void **state)
{
    (void)state;
    fault_switch faults;
    clast_context *context = faulty_context(&faults);
    char folder[64];
    make_folder(folder);
    uint64_t before = clast_context_memory(context);
    for (int64_t k = 0;; k++) {
        faults.files_failed = 0;
        faults.files_left = k;
        clast_status status = live(context, folder);
        faults.files_left = -1;
        assert_int_equal(clast_context_memory(context), before);
        if (faults.files_failed == 0) {
            assert_ok(context, status);
            assert_true(k > 5);
            break;
        }
        assert_true(status == CLAST_ERROR_FILE_READ || status == CLAST_ERROR_FILE_WRITE);
        const char *endings[] = {"png", "pfm", "exr"};
        for (int i = 0; i < 3; i++) { // one whose read-back failed is whole, and is there
            char path[512];
            snprintf(path, sizeof path, "%s/faults.%s", folder, endings[i]);
            remove(path);
        }
    }
    assert_int_equal(rmdir(folder), 0);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(every_file_call_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
