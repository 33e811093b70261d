// SPDX-License-Identifier: Apache-2.0
// Renders as a whole: the same bits on every run, views, alpha, cancelling, memory that runs out.
#include "picture.h"

static const vec3 ORIGIN = {0, 0, 0};
static const clast_view all_views[] = {
    CLAST_VIEW_COLOUR,   CLAST_VIEW_ALBEDO,  CLAST_VIEW_NORMAL,   CLAST_VIEW_DEPTH,  CLAST_VIEW_UV,
    CLAST_VIEW_INSTANCE, CLAST_VIEW_CLUSTER, CLAST_VIEW_TRIANGLE, CLAST_VIEW_STEPS,  CLAST_VIEW_PRIMITIVE,
    CLAST_VIEW_SEGMENTS, CLAST_VIEW_RATE,    CLAST_VIEW_AREA,     CLAST_VIEW_SAMPLES};

// A bit of everything: sky, lamp, point light, metal, a blended square.
static picture rich_scene(clast_context *context, uint32_t size, uint32_t samples)
{
    picture p = picture_open(context, size, samples);
    clast_environment environment = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.4f, 0.6f}};
    assert_ok(context, clast_scene_set_environment(p.scene, &environment));
    clast_light_desc light = {
        .type = CLAST_LIGHT_POINT, .position = {1, 2, 2}, .colour = {1, 0.8f, 0.6f}, .intensity = 5.0f};
    uint32_t number;
    assert_ok(context, clast_scene_add_light(p.scene, &light, NULL, &number));
    picture_add_sphere(&p, ORIGIN, 1.0f, 64, picture_material(&p, 0.8f, 1.0f, 0.3f, 0.0f));
    picture_add_square(&p, vec3(0, -1, 0), vec3(0, 0, 5), vec3(5, 0, 0), picture_material(&p, 0.5f, 0.0f, 0.7f, 0.0f));
    picture_add_square(&p, vec3(-2, 0, 0), vec3(0, 0, 1), vec3(0, 1, 0), picture_material(&p, 0.5f, 0.0f, 0.7f, 3.0f));
    clast_material_desc glass = clast_material_defaults();
    glass.alpha_mode = CLAST_ALPHA_BLEND;
    glass.base_colour[3] = 0.4f;
    assert_ok(context, clast_scene_add_material(p.scene, &glass, NULL, &number));
    picture_add_square(&p, vec3(1, 0, 1.5f), vec3(0.5f, 0, 0), vec3(0, 0.5f, 0), number);
    picture_look(&p, vec3(0.5f, 0.7f, 5.0f), ORIGIN, 0.8f);
    return p;
}

typedef struct rendered {
    uint8_t *bytes;
    size_t size;
} rendered;

static rendered render_with(uint32_t threads, clast_isa isa)
{
    clast_context *context = NULL;
    clast_status status = clast_context_create(&(clast_context_desc){.threads = threads, .isa = isa}, &context);
    if (status == CLAST_ERROR_DEVICE) {
        return (rendered){NULL, 0};
    }
    assert_int_equal(status, CLAST_OK);
    picture p = rich_scene(context, 48, 3);
    picture_build(&p);
    assert_ok(context, picture_try(&p, all_views, CLAST_VIEW_COUNT_));
    size_t bytes = 48 * 48 * 4;
    rendered r = {malloc(bytes * 21), 0};
    const size_t channels[] = {3, 3, 3, 1, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    for (int i = 0; i < CLAST_VIEW_COUNT_; i++) {
        memcpy(r.bytes + r.size, p.pixels[i], bytes * channels[i]);
        r.size += bytes * channels[i];
    }
    picture_close(&p);
    clast_context_destroy(context);
    return r;
}

static void check_same(rendered a, rendered b)
{
    assert_int_equal(a.size, b.size);
    assert_memory_equal(a.bytes, b.bytes, a.size);
    free(b.bytes);
}

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    rendered one = render_with(1, CLAST_ISA_AUTOMATIC);
    check_same(one, render_with(2, CLAST_ISA_AUTOMATIC));
    check_same(one, render_with(5, CLAST_ISA_AUTOMATIC));
    free(one.bytes);
}

static void instruction_sets_do_not_change_a_bit(void **state)
{
    (void)state;
    rendered plain = render_with(2, CLAST_ISA_PLAIN);
    const clast_isa sets[] = {CLAST_ISA_SSE42, CLAST_ISA_AVX2, CLAST_ISA_AVX512};
    for (int i = 0; i < 3; i++) {
        rendered other = render_with(2, sets[i]);
        if (other.bytes != NULL) {
            check_same(plain, other);
        }
    }
    free(plain.bytes);
}

static void seeds_change_the_noise(void **state)
{
    picture p = rich_scene(*state, 16, 2);
    picture_render(&p);
    float before = picture_pixel(&p, 8, 12)[1];
    p.settings.seed = 1;
    const clast_view colour = CLAST_VIEW_COLOUR;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    assert_true(picture_pixel(&p, 8, 12)[1] != before);
    picture_close(&p);
}

static void views_say_what_is_there(void **state)
{
    picture p = picture_open(*state, 9, 2);
    picture_surround(&p, 1.0f);
    uint32_t material = picture_material(&p, 0.25f, 0.0f, 0.5f, 0.0f);
    uint32_t instance = picture_add_square(&p, ORIGIN, vec3(1, 0, 0), vec3(0, 1, 0), material);
    picture_look(&p, vec3(0, 0, 2), ORIGIN, 1.8f); // the square does not fill the picture
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, all_views, CLAST_VIEW_COUNT_));
    const float *albedo = p.pixels[CLAST_VIEW_ALBEDO], *normal = p.pixels[CLAST_VIEW_NORMAL],
                *depth = p.pixels[CLAST_VIEW_DEPTH], *uv = p.pixels[CLAST_VIEW_UV];
    const uint32_t *instances = p.pixels[CLAST_VIEW_INSTANCE], *triangles = p.pixels[CLAST_VIEW_TRIANGLE],
                   *steps = p.pixels[CLAST_VIEW_STEPS];
    uint32_t middle = 4 * 9 + 4;
    assert_near(albedo[3 * middle], 0.25, 1e-6);
    assert_near(normal[3 * middle + 2], 1.0, 1e-5);
    assert_near(depth[middle], 2.0, 1e-5);
    assert_near(uv[2 * middle], 0.5, 1e-5);
    assert_int_equal(instances[middle], instance);
    assert_true(triangles[middle] < 2 && steps[middle] > 0 && steps[middle] < 100);
    assert_true(isinf(depth[0]) && instances[0] == CLAST_NONE && triangles[0] == CLAST_NONE && albedo[0] == 0.0f);
    // Depth is along the axis: the same all over the square.
    assert_near(depth[middle + 1], 2.0, 1e-5);
    picture_close(&p);
}

static double seen_through(clast_context *context, clast_alpha_mode mode, float alpha, float cutoff)
{
    picture p = picture_open(context, 16, 64);
    picture_surround(&p, 1.0f);
    clast_material_desc desc = clast_material_defaults();
    desc.alpha_mode = mode;
    desc.alpha_cutoff = cutoff;
    desc.base_colour[0] = desc.base_colour[1] = desc.base_colour[2] = 0.0f;
    desc.roughness = 1.0f;
    desc.base_colour[3] = alpha;
    uint32_t material;
    assert_ok(context, clast_scene_add_material(p.scene, &desc, NULL, &material));
    picture_add_square(&p, ORIGIN, vec3(9, 0, 0), vec3(0, 9, 0), material);
    picture_look(&p, vec3(0, 0, 2), ORIGIN, 0.5f);
    picture_render(&p);
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

// A black surface: what is seen is what is behind, and a reflection of a few hundredths.
static void alpha_lets_light_through_as_its_mode_says(void **state)
{
    double opaque = seen_through(*state, CLAST_ALPHA_OPAQUE, 0.3f, 0.5f);
    assert_true(opaque < 0.06);
    assert_near(seen_through(*state, CLAST_ALPHA_MASK, 0.3f, 0.5f), 1.0, 1e-6);
    assert_near(seen_through(*state, CLAST_ALPHA_MASK, 0.5f, 0.5f), opaque, 1e-6);
    assert_near(seen_through(*state, CLAST_ALPHA_BLEND, 0.3f, 0.5f), 0.7 + 0.3 * opaque, 0.02);
    assert_near(seen_through(*state, CLAST_ALPHA_BLEND, 1.0f, 0.5f), opaque, 1e-6);
    assert_near(seen_through(*state, CLAST_ALPHA_BLEND, 0.0f, 0.5f), 1.0, 1e-6);
}

static void shadows_honour_alpha(void **state)
{
    picture p = picture_open(*state, 16, 256);
    p.settings.bounces = 1;
    clast_light_desc light = {
        .type = CLAST_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .colour = {1, 1, 1}, .intensity = 3.0f};
    uint32_t number;
    assert_ok(p.context, clast_scene_add_light(p.scene, &light, NULL, &number));
    picture_add_square(&p, ORIGIN, vec3(1, 0, 0), vec3(0, 1, 0), picture_material(&p, 0.5f, 0.0f, 1.0f, 0.0f));
    picture_look(&p, vec3(1.5f, 0, 1.0f), ORIGIN, 0.05f);
    picture_render(&p);
    double open = picture_mean(&p);
    clast_material_desc veil = clast_material_defaults();
    veil.alpha_mode = CLAST_ALPHA_BLEND;
    veil.base_colour[3] = 0.25f;
    assert_ok(p.context, clast_scene_add_material(p.scene, &veil, NULL, &number));
    picture_add_square(&p, vec3(0, 0, 2), vec3(1, 0, 0), vec3(0, 1, 0), number);
    clast_frame_destroy(p.frame);
    clast_cooked_destroy(p.cooked);
    picture_render(&p);
    assert_near(picture_mean(&p) / open, 0.75, 0.03);
    picture_close(&p);
}

static void the_eye_looks_through_backs_of_single_sided_surfaces_only(void **state)
{
    for (int round = 0; round < 4; round++) {
        bool double_sided = round % 2 != 0, mirrored = round / 2 != 0;
        picture p = picture_open(*state, 9, 1);
        clast_material_desc desc = clast_material_defaults();
        desc.double_sided = double_sided;
        uint32_t material;
        assert_ok(p.context, clast_scene_add_material(p.scene, &desc, NULL, &material));
        uint32_t front = picture_add_square(&p, ORIGIN, vec3(1, 0, 0), vec3(0, 1, 0), material);
        picture_add_square(&p, vec3(0, 0, 1), vec3(-1, 0, 0), vec3(0, 1, 0), material); // its back is seen
        uint32_t back = front + 1;
        const float mirror[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}; // fronts stay fronts
        if (mirrored) {
            assert_ok(p.context, clast_scene_set_instance_transform(p.scene, front, mirror));
            assert_ok(p.context, clast_scene_set_instance_transform(p.scene, back, mirror));
        }
        picture_look(&p, vec3(0, 0, 3), ORIGIN, 0.5f);
        picture_build(&p);
        assert_ok(p.context, picture_try(&p, all_views, CLAST_VIEW_COUNT_));
        const uint32_t *instances = p.pixels[CLAST_VIEW_INSTANCE];
        assert_int_equal(instances[9 * 4 + 4], double_sided ? back : front);
        picture_close(&p);
    }
}

static void backs_of_single_sided_surfaces_cast_shadows(void **state)
{
    picture p = picture_open(*state, 9, 1);
    p.settings.bounces = 1;
    clast_light_desc light = {
        .type = CLAST_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .colour = {1, 1, 1}, .intensity = 3.0f};
    clast_material_desc desc = clast_material_defaults();
    desc.double_sided = false;
    uint32_t number, material;
    assert_ok(p.context, clast_scene_add_light(p.scene, &light, NULL, &number));
    assert_ok(p.context, clast_scene_add_material(p.scene, &desc, NULL, &material));
    picture_add_square(&p, ORIGIN, vec3(1, 0, 0), vec3(0, 1, 0), material);
    picture_add_square(&p, vec3(0, 0, 1), vec3(-3, 0, 0), vec3(0, 3, 0), material);
    picture_look(&p, vec3(0, 0, 3), ORIGIN, 0.2f);
    picture_render(&p);
    assert_near(picture_mean(&p), 0.0, 0.0);
    picture_close(&p);
}

// ------------------------------------------------------------------------------------------------- cancel, and failures

typedef struct patience {
    uint64_t calls, most;
} patience;

static bool ask(void *user, const char *stage, uint64_t done, uint64_t total)
{
    patience *p = user;
    assert_true(done <= total);
    return strcmp(stage, "render") != 0 || ++p->calls <= p->most;
}

static void a_cancelled_render_keeps_what_it_has(void **state)
{
    (void)state;
    // One sample is two calls for each band; the picture has two bands. 13 calls: three samples, and the first band of
    // a fourth.
    const uint64_t calls[] = {1, 13, 1000};
    const uint32_t samples[] = {0, 3, 6};
    for (int i = 0; i < 3; i++) {
        patience patient = {0, calls[i]};
        clast_context *context;
        clast_context_desc desc = {.threads = 2, .progress = {ask, &patient}};
        assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
        uint64_t before = clast_context_memory(context);
        picture p = picture_open(context, 300, 6);
        picture_surround(&p, 0.5f);
        picture_look(&p, vec3(0, 0, 2), ORIGIN, 0.5f);
        picture_build(&p);
        const clast_view colour = CLAST_VIEW_COLOUR;
        clast_status status = picture_try(&p, &colour, 1);
        assert_int_equal(status, i == 2 ? CLAST_OK : CLAST_ERROR_CANCELLED);
        assert_int_equal(p.statistics.samples, samples[i]);
        assert_near(picture_mean(&p), i == 0 ? 0.0 : 0.5, 1e-5);
        picture_close(&p);
        assert_int_equal(clast_context_memory(context), before);
        clast_context_destroy(context);
    }
}

static void a_render_without_memory_fails_and_leaves_nothing(void **state)
{
    (void)state;
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .memory_limit = 24u << 20}, &context),
                     CLAST_OK);
    picture p = rich_scene(context, 1024, 1); // 40 bytes a pixel do not fit
    picture_build(&p);
    uint64_t before = clast_context_memory(context);
    const clast_view colour = CLAST_VIEW_COLOUR;
    assert_int_equal(picture_try(&p, &colour, 1), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(clast_context_memory(context), before);
    picture_close(&p);
    clast_context_destroy(context);
}

// ---------------------------------------------------------------------------------------------------------------- views

static void every_view_can_be_shown(void **state)
{
    picture p = rich_scene(*state, 32, 1);
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, all_views, CLAST_VIEW_COUNT_));
    for (int i = 0; i < CLAST_VIEW_COUNT_; i++) {
        if (all_views[i] == CLAST_VIEW_SEGMENTS || all_views[i] == CLAST_VIEW_SAMPLES) {
            continue; // nothing here adapts, and all pixels have as many samples
        }
        uint8_t shown[32 * 32 * 3] = {0};
        assert_ok(p.context, clast_view_to_display(p.context, all_views[i], p.pixels[i], 32, 32, &p.settings, shown));
        uint8_t low = 255, high = 0;
        for (size_t k = 0; k < sizeof shown; k++) {
            low = shown[k] < low ? shown[k] : low;
            high = shown[k] > high ? shown[k] : high;
        }
        assert_true(high > 100 && low < 100);
    }
    picture_close(&p);
}

static void neighbouring_numbers_are_told_apart(void **state)
{
    clast_context *context = *state;
    uint32_t numbers[1024];
    uint8_t shown[1024 * 3];
    for (uint32_t i = 0; i < 1024; i++) {
        numbers[i] = i == 1023 ? CLAST_NONE : i;
    }
    assert_ok(context, clast_view_to_display(context, CLAST_VIEW_CLUSTER, numbers, 1024, 1, NULL, shown));
    for (uint32_t i = 1; i < 1024; i++) {
        int difference = 0;
        for (uint32_t c = 0; c < 3; c++) {
            difference += abs((int)shown[3 * i + c] - (int)shown[3 * i - 3 + c]);
        }
        assert_true(difference > 60);
    }
    assert_true(shown[3 * 1023] == 0 && shown[3 * 1023 + 1] == 0);
}

static void a_view_that_is_none_is_refused(void **state)
{
    uint8_t pixels[3];
    float value = 0.0f;
    assert_int_equal(clast_view_to_display(*state, CLAST_VIEW_COUNT_, &value, 1, 1, NULL, pixels),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_view_to_display(*state, CLAST_VIEW_DEPTH, NULL, 1, 1, NULL, pixels),
                     CLAST_ERROR_INVALID_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(instruction_sets_do_not_change_a_bit),
        CONTEXT_TEST(seeds_change_the_noise),
        CONTEXT_TEST(views_say_what_is_there),
        CONTEXT_TEST(alpha_lets_light_through_as_its_mode_says),
        CONTEXT_TEST(shadows_honour_alpha),
        CONTEXT_TEST(the_eye_looks_through_backs_of_single_sided_surfaces_only),
        CONTEXT_TEST(backs_of_single_sided_surfaces_cast_shadows),
        cmocka_unit_test(a_cancelled_render_keeps_what_it_has),
        cmocka_unit_test(a_render_without_memory_fails_and_leaves_nothing),
        CONTEXT_TEST(every_view_can_be_shown),
        CONTEXT_TEST(neighbouring_numbers_are_told_apart),
        CONTEXT_TEST(a_view_that_is_none_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
