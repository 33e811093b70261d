// SPDX-License-Identifier: Apache-2.0
// The tree over lights: that every light has the chance that is told of it, and that what is chosen by it adds up to what all
// lights send.
#include "picture.h"

#include "render/lights.h"
#include "shared/random.h"

static uint32_t draws;

static float draw(void)
{
    return unit_float(hash1(draws++));
}

static float draw_between(float low, float high)
{
    return low + (high - low) * draw();
}

static vec3 draw_direction(void)
{
    vec2 u = vec2(draw(), draw());
    float z = 2.0f * u[0] - 1.0f, level = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    vec2 circle = circle_point(u[1]);
    return vec3(level * circle[0], z, level * circle[1]);
}

static vec3 draw_place(float size)
{
    return vec3(draw_between(-size, size), draw_between(-size, size), draw_between(-size, size));
}

// -------------------------------------------------------------------------------------------------------------- lights

// Lights without a scene: as much of a frame as choosing one of them reads.
typedef struct light_set {
    clast_emitter *emitters;
    float *radiances;
    size_t emitter_count;
    clast_light *punctual;
    size_t punctual_count;
    clast_frame frame;
    clast_lights lights;
    clast_context *context;
} light_set;

static light_set open_set(clast_context *context, size_t emitters, size_t punctual)
{
    return (light_set){.context = context,
                       .emitters = calloc(emitters + 1, sizeof(clast_emitter)),
                       .radiances = calloc(emitters + 1, sizeof(float)),
                       .punctual = calloc(punctual + 1, sizeof(clast_light))};
}

static void add_triangle(light_set *set, vec3 place, float size, float radiance)
{
    vec3 a = draw_direction() * size, b = draw_direction() * size;
    clast_emitter *emitter = &set->emitters[set->emitter_count];
    *emitter = (clast_emitter){.corners = {store3(place), store3(place + a), store3(place + b)},
                               .area = 0.5f * length3(cross3(a, b))};
    set->radiances[set->emitter_count++] = radiance;
}

static void add_punctual(light_set *set, uint32_t type, vec3 place, float intensity, float range)
{
    set->punctual[set->punctual_count++] = (clast_light){.type = type,
                                                         .position = store3(place),
                                                         .direction = store3(draw_direction()),
                                                         .radiance = store3(splat3(intensity)),
                                                         .range = range,
                                                         .inner_cosine = 0.9f,
                                                         .outer_cosine = 0.5f};
}

static void build_set(light_set *set, float extent)
{
    clast_light_sources sources = {set->emitters, set->radiances,      set->emitter_count,
                                   set->punctual, set->punctual_count, extent};
    set->frame = (clast_frame){.emitters = set->emitters, .emitter_count = set->emitter_count};
    set->frame.motion.lights = set->punctual;
    set->lights = (clast_lights){.frame = &set->frame, .emitter_count = (uint32_t)set->emitter_count};
    assert_ok(set->context, clast_light_tree_create(set->context, &sources, &set->lights.tree));
}

static void close_set(light_set *set)
{
    clast_light_tree_destroy(set->context, &set->lights.tree);
    free(set->emitters);
    free(set->radiances);
    free(set->punctual);
}

// Triangles, points and spots all over a cube of a side of two.
static void open_mixed_set(clast_context *context, size_t count, light_set *set)
{
    *set = open_set(context, count, count);
    for (size_t i = 0; i < count; i++) {
        uint32_t kind = (uint32_t)(draw() * 4.0f);
        vec3 place = draw_place(1.0f);
        if (kind < 2) {
            add_triangle(set, place, draw_between(0.001f, 0.2f), draw_between(0.1f, 10.0f));
        } else {
            add_punctual(set, kind == 2 ? CLAST_LIGHT_POINT : CLAST_LIGHT_SPOT, place, draw_between(0.1f, 2.0f),
                         draw() < 0.5f ? 0.0f : draw_between(0.3f, 2.0f));
        }
    }
    build_set(set, 2.0f);
}

static clast_lit_point draw_point(float size)
{
    return lit_point(draw_place(size), draw_direction(), draw() < 0.2f);
}

static size_t number_count(const light_set *set)
{
    return set->emitter_count + set->punctual_count;
}

static double sum_of_chances(const light_set *set, clast_lit_point point)
{
    double sum = 0.0;
    for (size_t i = 0; i < number_count(set); i++) {
        float chance = clast_light_tree_density(&set->lights, point, (uint32_t)i);
        assert_true(chance >= 0.0f && chance <= 1.0f);
        sum += (double)chance;
    }
    return sum;
}

static void check_chances(const light_set *set, clast_lit_point point)
{
    assert_near(sum_of_chances(set, point), 1.0, 1e-4);
    for (int i = 0; i < 64; i++) {
        clast_chosen_light chosen = clast_light_tree_choose(&set->lights, point, draw());
        float chance = clast_light_tree_density(&set->lights, point, chosen.number);
        assert_true(chosen.number < number_count(set));
        assert_memory_equal(&chance, &chosen.density, sizeof chance);
        assert_true(chance > 0.0f);
    }
}

// ------------------------------------------------------------------------------------------------------------- chances

static void chances_add_up_to_one_and_are_those_of_samples(void **state)
{
    const size_t counts[] = {1, 2, 3, 8, 9, 17, 100, 1000};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        light_set set;
        open_mixed_set(*state, counts[i], &set);
        for (int k = 0; k < 20; k++) {
            check_chances(&set, draw_point(k < 10 ? 1.5f : 20.0f));
        }
        close_set(&set);
    }
}

static void chances_add_up_with_ten_thousand_lights(void **state)
{
    light_set set;
    open_mixed_set(*state, 10000, &set);
    for (int k = 0; k < 3; k++) {
        check_chances(&set, draw_point(1.5f));
    }
    close_set(&set);
}

static void lights_at_one_place_are_chosen_by_their_power(void **state)
{
    light_set set = open_set(*state, 0, 300);
    for (int i = 0; i < 300; i++) {
        add_punctual(&set, CLAST_LIGHT_POINT, splat3(0.25f), i < 150 ? 1.0f : 3.0f, 0.0f);
    }
    build_set(&set, 1.0f);
    clast_lit_point point = lit_point(splat3(0.0f), vec3(0, 1, 0), false);
    check_chances(&set, point);
    check_chances(&set, lit_point(splat3(0.25f), vec3(0, 1, 0), false)); // on them
    assert_near(clast_light_tree_density(&set.lights, point, 0), 1.0 / 600.0, 1e-5);
    assert_near(clast_light_tree_density(&set.lights, point, 299), 3.0 / 600.0, 1e-5);
    close_set(&set);
}

static void points_on_lights_and_lights_behind_are_no_trouble(void **state)
{
    light_set set;
    open_mixed_set(*state, 200, &set);
    for (size_t i = 0; i < set.emitter_count; i++) {
        check_chances(&set, lit_point(load3(set.emitters[i].corners[i % 3]), draw_direction(), false));
    }
    for (size_t i = 0; i < set.punctual_count; i++) {
        check_chances(&set, lit_point(load3(set.punctual[i].position), draw_direction(), false));
    }
    check_chances(&set, lit_point(vec3(0, 3, 0), vec3(0, 1, 0), false)); // all are behind
    check_chances(&set, lit_point(vec3(NAN, 0, 0), vec3(0, 1, 0), false));
    check_chances(&set, lit_point(vec3(INFINITY, 0, 0), splat3(NAN), false));
    close_set(&set);
}

static void huge_tiny_and_thin_lights_are_no_trouble(void **state)
{
    const float sizes[] = {1e-12f, 1e-6f, 1.0f, 1e6f, 1e15f};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        light_set set = open_set(*state, 64, 64);
        for (int i = 0; i < 64; i++) {
            add_triangle(&set, draw_place(sizes[s]), sizes[s] * 0.1f, i % 8 == 0 ? 1e30f : 1e-30f);
            add_punctual(&set, i % 2 != 0 ? CLAST_LIGHT_POINT : CLAST_LIGHT_SPOT, draw_place(sizes[s]), 1.0f, 0.0f);
        }
        for (int i = 0; i < 8; i++) { // as thin as numbers allow
            clast_emitter *emitter = &set.emitters[8 * i];
            emitter->corners[2] = emitter->corners[1];
            emitter->area = 1e-38f;
        }
        build_set(&set, sizes[s]);
        for (int k = 0; k < 10; k++) {
            check_chances(&set, draw_point(sizes[s] * 1.5f));
        }
        close_set(&set);
    }
}

static void dark_lights_are_never_chosen(void **state)
{
    light_set set = open_set(*state, 0, 20);
    for (int i = 0; i < 20; i++) {
        add_punctual(&set, i % 4 == 3 ? CLAST_LIGHT_DIRECTIONAL : CLAST_LIGHT_POINT, draw_place(1.0f),
                     i % 2 != 0 ? 1.0f : 0.0f, 0.0f);
    }
    build_set(&set, 1.0f);
    clast_lit_point point = lit_point(splat3(0.0f), vec3(0, 1, 0), true);
    check_chances(&set, point);
    for (uint32_t i = 0; i < 20; i++) {
        assert_true((clast_light_tree_density(&set.lights, point, i) > 0.0f) == (i % 4 == 1));
    }
    close_set(&set);
    set = open_set(*state, 0, 0);
    build_set(&set, 1.0f);
    assert_int_equal(set.lights.tree.count, 0);
    close_set(&set);
}

static void lights_are_chosen_as_often_as_they_say(void **state)
{
    enum { SAMPLES = 1 << 17, LIGHTS = 60 };
    light_set set;
    open_mixed_set(*state, LIGHTS, &set);
    for (int k = 0; k < 5; k++) {
        uint32_t counts[LIGHTS] = {0};
        clast_lit_point point = draw_point(1.2f);
        for (uint32_t i = 0; i < SAMPLES; i++) {
            counts[clast_light_tree_choose(&set.lights, point, sample_square(i, 7)[0]).number]++;
        }
        for (uint32_t i = 0; i < number_count(&set); i++) {
            double chance = (double)clast_light_tree_density(&set.lights, point, i);
            assert_near((double)counts[i] / SAMPLES, chance, 4e-3 * chance + 6.0 / SAMPLES);
        }
    }
    close_set(&set);
}

// Every light that can send anything has a chance: against what each sends.
static void what_lights_send_is_found(void **state)
{
    enum { LIGHTS = 400 };
    light_set set;
    open_mixed_set(*state, LIGHTS, &set);
    for (int k = 0; k < 200; k++) {
        vec3 place = draw_place(1.2f), normal = draw_direction();
        clast_lit_point point = lit_point(place, normal, false);
        for (uint32_t i = 0; i < number_count(&set); i++) {
            float sent = 0.0f;
            if (i < set.emitter_count) {
                for (int c = 0; c < 3; c++) {
                    sent = max1(sent, dot3(normal, load3(set.emitters[i].corners[c]) - place));
                }
            } else {
                clast_incoming incoming = light_incoming(set.punctual[i - set.emitter_count], place);
                sent = max1(dot3(load3(incoming.direction), normal), 0.0f) * load3(incoming.irradiance)[0];
            }
            assert_true(!(sent > 1e-6f) || clast_light_tree_density(&set.lights, point, i) > 0.0f);
        }
    }
    close_set(&set);
}

// ---------------------------------------------------------------------------------------------------------- determinism

static void threads_do_not_matter(void **state)
{
    (void)state;
    clast_light_tree trees[3];
    clast_context *contexts[3];
    const uint32_t threads[] = {1, 2, 5};
    for (int t = 0; t < 3; t++) {
        clast_context_desc desc = {.threads = threads[t]};
        assert_int_equal(clast_context_create(&desc, &contexts[t]), CLAST_OK);
        draws = 77;
        light_set set;
        open_mixed_set(contexts[t], 20000, &set);
        trees[t] = set.lights.tree;
        set.lights.tree = (clast_light_tree){0};
        close_set(&set);
    }
    for (int t = 1; t < 3; t++) {
        assert_int_equal(trees[t].node_count, trees[0].node_count);
        assert_memory_equal(trees[t].nodes, trees[0].nodes, trees[0].node_count * sizeof *trees[0].nodes);
        assert_memory_equal(trees[t].entries, trees[0].entries, trees[0].count * sizeof *trees[0].entries);
        assert_memory_equal(trees[t].trails, trees[0].trails, trees[0].number_count * sizeof *trees[0].trails);
    }
    for (int t = 0; t < 3; t++) {
        clast_light_tree_destroy(contexts[t], &trees[t]);
        clast_context_destroy(contexts[t]);
    }
}

// ------------------------------------------------------------------------------------------------------------- pictures

static void add_emitters(picture *p, uint32_t count)
{
    uint32_t materials[4];
    for (int i = 0; i < 4; i++) {
        materials[i] = picture_material(p, 0.0f, 0.0f, 1.0f, 1.0f + 3.0f * draw());
    }
    for (uint32_t i = 0; i < count; i++) {
        vec3 right = draw_direction() * draw_between(0.02f, 0.2f);
        picture_add_square(p, draw_place(1.0f), right, cross3(right, draw_direction()), materials[i % 4]);
    }
}

static clast_lights *lights_of(picture *p, clast_srgb_table *table)
{
    clast_lights *lights;
    clast_srgb_table_fill(table);
    picture_build(p);
    assert_ok(p->context, clast_lights_create(p->frame, table, &lights));
    return lights;
}

// Irradiance of all triangles at a point, each by many points of it; nothing is in the way.
static double irradiance_of_all(const clast_lights *lights, vec3 place, vec3 normal, uint32_t samples)
{
    double sum = 0.0;
    for (size_t e = 0; e < lights->frame->emitter_count; e++) {
        const clast_emitter *emitter = &lights->frame->emitters[e];
        const clast_material *material = &lights->frame->scene->materials[emitter->material].record;
        for (uint32_t i = 0; i < samples; i++) {
            clast_emitter_point point = emitter_point(*emitter, sample_triangle(sample_square(i, 5)), place);
            float received = max1(dot3(load3(point.direction), normal), 0.0f),
                  sent = abs1(dot3(load3(point.direction), load3(point.normal)));
            sum += (double)(material->emissive.v[0] * received * sent * emitter->area /
                            (point.distance * point.distance)) /
                   samples;
        }
    }
    return sum;
}

static void irradiance_is_that_of_all_lights(void **state)
{
    enum { SAMPLES = 1 << 15 };
    picture p = picture_open(*state, 4, 1);
    add_emitters(&p, 150);
    clast_srgb_table table;
    clast_lights *lights = lights_of(&p, &table);
    for (int k = 0; k < 8; k++) {
        vec3 place = draw_direction() * 2.5f, normal = normalize3(place * -1.0f + draw_direction() * 1.5f);
        clast_lit_point point = lit_point(place, normal, false);
        clast_light_shares shares = clast_lights_share(lights, point, normal, normal);
        assert_near(shares.tree, 1.0, 1e-6);
        double sum = 0.0, square = 0.0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            clast_light_sample light = clast_lights_sample(lights, &shares, point, unit_float(hash2(i, 1)),
                                                           vec2(unit_float(hash2(i, 2)), unit_float(hash2(i, 3))));
            double value = light.density > 0.0f ? (double)(max1(dot3(load3(light.direction), normal), 0.0f) *
                                                           light.radiance.v[0] / light.density)
                                                : 0.0;
            sum += value / SAMPLES;
            square += value * value / SAMPLES;
        }
        double all = irradiance_of_all(lights, place, normal, 64), error = sqrt((square - sum * sum) / SAMPLES);
        assert_near(sum, all, 4.0 * error + 2e-3 * all);
    }
    clast_lights_destroy(p.context, lights);
    picture_close(&p);
}

// Shines where a block of its texture is.
static uint32_t textured_lamp(picture *p, uint32_t size, uint32_t block)
{
    uint8_t *pixels = calloc(3 * (size_t)size * size, 1);
    for (uint32_t i = 0; i < block * block; i++) {
        pixels[3 * ((size_t)(1 + i / block) * size + 1 + i % block)] = 255; // red
    }
    clast_image image = {size, size, 3, CLAST_PIXEL_UNORM8, pixels};
    uint32_t number, texture, material;
    assert_ok(p->context, clast_scene_add_image(p->scene, &image, NULL, &number));
    free(pixels);
    clast_texture of_image = {.image = number};
    assert_ok(p->context, clast_scene_add_texture(p->scene, &of_image, &texture));
    clast_material_desc desc = clast_material_defaults();
    desc.emissive[0] = desc.emissive[1] = desc.emissive[2] = 20.0f;
    desc.emissive_texture = (clast_texture_slot){.texture = texture, .scale = {1.0f, 1.0f}};
    assert_ok(p->context, clast_scene_add_material(p->scene, &desc, NULL, &material));
    return material;
}

static double textured_floor(clast_context *context, bool known)
{
    picture p = picture_open(context, 6, 4096);
    p.settings.bounces = 1;
    picture_add_square(&p, splat3(0.0f), vec3(2, 0, 0), vec3(0, 2, 0), picture_material(&p, 0.6f, 0.0f, 1.0f, 0.0f));
    picture_add_square(&p, vec3(0, 0, 1), vec3(0.8f, 0, 0), vec3(0, -0.8f, 0), textured_lamp(&p, 16, 4));
    picture_add_square(&p, vec3(1, 0, 1), vec3(0.1f, 0, 0), vec3(0, -0.1f, 0), picture_material(&p, 0, 0, 1, 0.5f));
    picture_look(&p, vec3(0.0f, -3.0f, 0.6f), splat3(0.0f), 0.4f);
    picture_build(&p);
    p.frame->emitter_count = known ? p.frame->emitter_count : 0;
    const clast_view colour = CLAST_VIEW_COLOUR;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

static void textured_lamps_light_as_by_chance(void **state)
{
    double known = textured_floor(*state, true), chance = textured_floor(*state, false);
    assert_true(chance > 0.01);
    assert_near(known / chance, 1.0, 0.04);
}

static void every_triangle_of_a_dark_texture_has_a_chance(void **state)
{
    picture p = picture_open(*state, 4, 1);
    picture_add_square(&p, vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, -1, 0), textured_lamp(&p, 256, 1));
    add_emitters(&p, 20);
    clast_srgb_table table;
    clast_lights *lights = lights_of(&p, &table);
    clast_lit_point point = lit_point(splat3(0.0f), vec3(0, 0, 1), false);
    for (uint32_t i = 0; i < 2; i++) {
        assert_true(clast_light_tree_density(lights, point, i) > 0.0f);
    }
    clast_lights_destroy(p.context, lights);
    picture_close(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(chances_add_up_to_one_and_are_those_of_samples),
        CONTEXT_TEST(chances_add_up_with_ten_thousand_lights),
        CONTEXT_TEST(lights_at_one_place_are_chosen_by_their_power),
        CONTEXT_TEST(points_on_lights_and_lights_behind_are_no_trouble),
        CONTEXT_TEST(huge_tiny_and_thin_lights_are_no_trouble),
        CONTEXT_TEST(dark_lights_are_never_chosen),
        CONTEXT_TEST(lights_are_chosen_as_often_as_they_say),
        CONTEXT_TEST(what_lights_send_is_found),
        cmocka_unit_test(threads_do_not_matter),
        CONTEXT_TEST(irradiance_is_that_of_all_lights),
        CONTEXT_TEST(textured_lamps_light_as_by_chance),
        CONTEXT_TEST(every_triangle_of_a_dark_texture_has_a_chance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
