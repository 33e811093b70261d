// SPDX-License-Identifier: Apache-2.0
// Lights sampled on a device against those of the processor, at random points.
#include "render/picture.h"

#include "render/lights.h"
#include "shared/device.h"
#include "shared/random.h"
#include "vulkan/lights.h"
#include "vulkan/materials.h"
#include "vulkan/test_device.h"

static test_device device;

enum { QUESTIONS = 8192, BLOCK = 64 };

static uint32_t draws;

static float draw(void)
{
    return unit_float(hash1(draws++));
}

static vec3 draw_direction(void)
{
    vec2 u = vec2(draw(), draw());
    float z = 2.0f * u[0] - 1.0f, level = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    vec2 circle = circle_point(u[1]);
    return vec3(level * circle[0], z, level * circle[1]);
}

// As shaders/probe/lights.comp has them.
typedef struct question {
    packed3 position, geometric_normal, normal, direction;
    packed2 square, sun_square;
    float choice, distance, cosine;
    uint32_t instance, primitive, passes;
} question;

typedef struct answer {
    clast_light_shares shares;
    clast_light_sample light, sun;
    packed3 distant_radiance;
    float distant_density;
    float emitter_density;
} answer;

// ------------------------------------------------------------------------------------------------------------- device

static void upload(clast_gpu_commands *commands, const void *data, size_t bytes, clast_gpu_buffer *buffer)
{
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, bytes, "test", buffer));
    clast_gpu_write(commands, buffer, 0, data, bytes);
}

// Of the frame, what lights ask for.
typedef struct frame_buffers {
    clast_gpu_buffer units, instances, head;
} frame_buffers;

static void upload_frame(clast_gpu_commands *commands, const clast_frame *frame, frame_buffers *made)
{
    clast_device_unit *units = calloc(frame->unit_count + 1, sizeof *units);
    clast_device_instance *instances = calloc(frame->instance_count + 1, sizeof *instances);
    for (size_t i = 0; i < frame->unit_count; i++) {
        units[i].bounds = frame->units[i].bounds;
    }
    for (size_t i = 0; i < frame->instance_count; i++) {
        instances[i].to_world = frame->instances[i].to_world;
        instances[i].to_object = frame->instances[i].to_object;
        instances[i].unit = frame->instances[i].unit;
    }
    upload(commands, units, (frame->unit_count + 1) * sizeof *units, &made->units);
    upload(commands, instances, (frame->instance_count + 1) * sizeof *instances, &made->instances);
    clast_device_frame head = {.units = store_address(made->units.address),
                               .instances = store_address(made->instances.address)};
    upload(commands, &head, sizeof head, &made->head);
    free(units);
    free(instances);
}

static void ask_device(const clast_frame *frame, const clast_lights *lights, const question *questions, answer *answers)
{
    clast_gpu_materials materials = {.gpu = device.gpu, .pictures = {.gpu = device.gpu}};
    clast_gpu_lights mirror = {.gpu = device.gpu};
    frame_buffers of_frame;
    clast_gpu_buffer asked, answered;
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    uint32_t image = lights->image != NULL ? lights->environment.image : CLAST_NONE;
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, frame->scene, image));
    assert_ok(device.context, clast_gpu_lights_update(&mirror, commands, lights, materials.surroundings));
    upload_frame(commands, frame, &of_frame);
    upload(commands, questions, QUESTIONS * sizeof *questions, &asked);
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, QUESTIONS * sizeof *answers, "answers", &answered));
    clast_gpu_barrier(commands);
    struct {
        uint64_t frame, materials, lights, questions, answers;
        uint32_t count;
    } push = {of_frame.head.address, materials.head.address, mirror.head.address,
              asked.address,         answered.address,       QUESTIONS};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_PROBE_LIGHTS,
                                              .push = &push,
                                              .push_bytes = 44,
                                              .groups = QUESTIONS / BLOCK});
    clast_gpu_read(commands, &answered, 0, answers, QUESTIONS * sizeof *answers);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_buffer *all[] = {&of_frame.units, &of_frame.instances, &of_frame.head, &asked, &answered};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        clast_gpu_free(device.gpu, all[i]);
    }
    clast_gpu_lights_free(&mirror);
    clast_gpu_materials_free(&materials);
}

// ---------------------------------------------------------------------------------------------------------- comparison

static answer ask_processor(const clast_lights *lights, const question *q)
{
    answer a;
    clast_lit_point point = lit_point(load3(q->position), load3(q->normal), q->passes != 0);
    a.shares = clast_lights_share(lights, point, load3(q->geometric_normal), load3(q->normal));
    a.light = clast_lights_sample(lights, &a.shares, point, q->choice, load2(q->square));
    a.sun = clast_lights_sample_sun(lights, &a.shares, load2(q->sun_square));
    a.distant_radiance = store3(clast_distant_radiance(lights, load3(q->direction)));
    a.distant_density = clast_distant_density(lights, &a.shares, load3(q->direction));
    a.emitter_density = clast_emitter_density(lights, &a.shares, point, q->instance, q->primitive, q->distance,
                                              q->cosine);
    return a;
}

// All members are numbers but is_distant and is_point, whose bits are equal where they are.
static bool alike(const void *a, const void *b, size_t bytes)
{
    for (size_t i = 0; i < bytes / sizeof(float); i++) {
        float x, y;
        memcpy(&x, (const char *)a + i * sizeof x, sizeof x);
        memcpy(&y, (const char *)b + i * sizeof y, sizeof y);
        if (memcmp(&x, &y, sizeof x) != 0 && !(fabsf(x - y) <= 2e-4f * (fabsf(x) + fabsf(y)) + 5e-5f)) {
            return false;
        }
    }
    return true;
}

static void draw_question(const clast_frame *frame, question *q)
{
    vec3 normal = draw_direction();
    q->position = store3(vec3(4.0f * draw() - 2.0f, 4.0f * draw() - 2.0f, 4.0f * draw() - 2.0f));
    q->geometric_normal = store3(normal);
    q->normal = store3(normalize3(normal + draw_direction() * 0.3f));
    q->direction = store3(draw_direction());
    q->square = store2(vec2(draw(), draw()));
    q->sun_square = store2(vec2(draw(), draw()));
    q->choice = draw();
    q->distance = 0.1f + 3.0f * draw();
    q->cosine = 2.0f * draw() - 1.0f;
    q->instance = frame->instance_count != 0 ? (uint32_t)(draw() * (float)frame->instance_count) : 0;
    q->primitive = (uint32_t)(draw() * 3.0f);
    q->passes = draw() < 0.1f;
}

// Functions of the machine are a little different on each, so a few directions fall into the next cell of a picture: one in a
// thousand is let pass.
static void compare(picture *p)
{
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    clast_lights *lights;
    assert_ok(p->context, clast_lights_create(p->frame, &table, &lights));
    question *questions = calloc(QUESTIONS, sizeof *questions);
    answer *answers = calloc(QUESTIONS, sizeof *answers);
    for (int i = 0; i < QUESTIONS; i++) {
        draw_question(p->frame, &questions[i]);
    }
    ask_device(p->frame, lights, questions, answers);
    uint32_t different = 0, lit = 0;
    for (int i = 0; i < QUESTIONS; i++) {
        answer expected = ask_processor(lights, &questions[i]);
        bool same = alike(&answers[i], &expected, sizeof expected);
        different += !same;
        lit += expected.light.density > 0.0f;
        if (!same && different < 4) {
            print_message("point %d: light %g %g, density %g %g, sun %g %g, far %g %g, emitter %g %g\n", i,
                          (double)answers[i].light.radiance.v[1], (double)expected.light.radiance.v[1],
                          (double)answers[i].light.density, (double)expected.light.density,
                          (double)answers[i].sun.radiance.v[1], (double)expected.sun.radiance.v[1],
                          (double)answers[i].distant_radiance.v[1], (double)expected.distant_radiance.v[1],
                          (double)answers[i].emitter_density, (double)expected.emitter_density);
        }
    }
    assert_true(lit > QUESTIONS / 2);
    assert_true(different <= QUESTIONS / 1000);
    free(questions);
    free(answers);
    clast_lights_destroy(p->context, lights);
    picture_close(p);
}

// --------------------------------------------------------------------------------------------------------------- scenes

static void a_picture_surrounds(void **state)
{
    (void)state;
    enum { WIDTH = 64, HEIGHT = 32 };
    picture p = picture_open(device.context, 4, 1);
    float *pixels = malloc(sizeof(float) * 3 * WIDTH * HEIGHT);
    for (uint32_t i = 0; i < 3 * WIDTH * HEIGHT; i++) {
        pixels[i] = unit_float(hash1(i)) * (i % 1000 < 3 ? 20.0f : 1.0f);
    }
    clast_image image = {WIDTH, HEIGHT, 3, CLAST_PIXEL_FLOAT, pixels};
    uint32_t number;
    assert_ok(p.context, clast_scene_add_image(p.scene, &image, NULL, &number));
    free(pixels);
    clast_environment environment = {.type = CLAST_ENVIRONMENT_IMAGE, .image = number, .rotation = 0.4f};
    assert_ok(p.context, clast_scene_set_environment(p.scene, &environment));
    picture_build(&p);
    compare(&p);
}

static void a_sky_surrounds(void **state)
{
    (void)state;
    picture p = picture_open(device.context, 4, 1);
    clast_environment environment = {
        .type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.6f, 0.5f, 0.8f}, .sun_size = 0.1f};
    assert_ok(p.context, clast_scene_set_environment(p.scene, &environment));
    picture_build(&p);
    compare(&p);
}

static void add_lights(picture *p, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        vec3 at = draw_direction() * 3.0f, shines = draw_direction();
        clast_light_desc light = {.type = (clast_light_type)(i % 3),
                                  .position = {at[0], at[1], at[2]},
                                  .direction = {shines[0], shines[1], shines[2]},
                                  .colour = {0.2f + draw(), 0.2f + draw(), 0.2f + draw()},
                                  .intensity = 1.0f + 10.0f * draw(),
                                  .range = i % 2 != 0 ? 8.0f : 0.0f,
                                  .inner_angle = 0.3f,
                                  .outer_angle = 1.4f};
        uint32_t number;
        assert_ok(p->context, clast_scene_add_light(p->scene, &light, NULL, &number));
    }
}

static void a_few_lights_are_weighed(void **state)
{
    (void)state;
    picture p = picture_open(device.context, 4, 1);
    add_lights(&p, 7);
    picture_surround(&p, 0.5f);
    picture_build(&p);
    compare(&p);
}

static void many_lights_are_chosen_from(void **state)
{
    (void)state;
    picture p = picture_open(device.context, 4, 1);
    add_lights(&p, 50);
    picture_build(&p);
    compare(&p);
}

static void triangles_shine(void **state)
{
    (void)state;
    picture p = picture_open(device.context, 4, 1);
    for (uint32_t i = 0; i < 20; i++) {
        uint32_t material = picture_material(&p, 0.5f, 0.0f, 0.5f, i % 4 != 0 ? 1.0f + draw() : 0.0f);
        vec3 right = draw_direction(), up = cross3(right, draw_direction());
        picture_add_square(&p, draw_direction() * 3.0f, right, up, material);
    }
    add_lights(&p, 2);
    picture_build(&p);
    assert_int_equal(p.frame->emitter_count, 30);
    compare(&p);
}

// So many that the tree over them is deep.
static void hundreds_of_triangles_and_lights_shine(void **state)
{
    (void)state;
    picture p = picture_open(device.context, 4, 1);
    uint32_t material = picture_material(&p, 0.5f, 0.0f, 0.5f, 3.0f);
    for (uint32_t i = 0; i < 300; i++) {
        vec3 right = draw_direction() * (0.02f + 0.2f * draw());
        picture_add_square(&p, draw_direction() * (4.0f * draw()), right, cross3(right, draw_direction()), material);
    }
    add_lights(&p, 150);
    picture_surround(&p, 0.2f);
    picture_build(&p);
    compare(&p);
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_surrounds),      cmocka_unit_test(a_sky_surrounds),
        cmocka_unit_test(a_few_lights_are_weighed), cmocka_unit_test(many_lights_are_chosen_from),
        cmocka_unit_test(triangles_shine),          cmocka_unit_test(hundreds_of_triangles_and_lights_shine),
    };
    int failed = cmocka_run_group_tests_name("lights of a device", tests, NULL, NULL);
    return test_device_close(&device) ? failed : 1;
}
