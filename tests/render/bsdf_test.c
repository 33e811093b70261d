// SPDX-License-Identifier: Apache-2.0
// Layers, glass and fuzz in a furnace: where light of one comes from everywhere, white surfaces send back one.
#include "test.h"

#include <math.h>

#include "render/scatter.h"

static const float roughnesses[] = {0.0f, 0.1f, 0.25f, 0.4f, 0.6f, 0.8f, 1.0f};
static const float cosines[] = {0.05f, 0.2f, 0.5f, 0.8f, 1.0f};
enum { ROUGHNESSES = sizeof roughnesses / sizeof roughnesses[0], COSINES = sizeof cosines / sizeof cosines[0] };

typedef struct world {
    clast_context *context;
    clast_scene *scene;
    clast_scatter_tables *tables;
    uint32_t glass, thin, plain;
} world;

static uint32_t add(world *w, float transmission, float thickness)
{
    clast_material_desc desc = clast_material_defaults();
    desc.transmission = transmission;
    desc.thickness = thickness;
    desc.ior = 1.5f;
    desc.sheen_colour[0] = 1.0f;
    uint32_t number;
    assert_ok(w->context, clast_scene_add_material(w->scene, &desc, NULL, &number));
    return number;
}

static world open_world(clast_context *context)
{
    world w = {.context = context};
    assert_ok(context, clast_scene_create(context, &w.scene));
    w.glass = add(&w, 1.0f, 1.0f);
    w.thin = add(&w, 1.0f, 0.0f);
    w.plain = add(&w, 0.0f, 0.0f);
    assert_ok(context, clast_scatter_create(w.scene, &w.tables));
    return w;
}

static void close_world(world *w)
{
    clast_scatter_destroy(w->context, w->tables);
    clast_scene_destroy(w->scene);
}

static vec3 view_of(float cosine)
{
    float sine = sqrtf(1.0f - cosine * cosine);
    return vec3(0.8f * sine, 0.6f * sine, cosine);
}

static clast_bsdf_input white(float metallic, float roughness)
{
    return bsdf_input(brdf_input(splat3(1.0f), metallic, roughness));
}

// What comes back of light from everywhere, by the surface's own sampling.
static float energy_of(clast_bsdf bsdf, vec3 view, uint32_t count)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        clast_bsdf_sample to = bsdf_direction(bsdf, view, sample_square(i, 11), sample_square(i, 12)[0]);
        vec3 light = load3(to.direction);
        if (light[2] == 0.0f) {
            continue;
        }
        clast_brdf_answer answer = bsdf_evaluate(bsdf, view, light);
        sum += answer.density > 0.0f ? (double)(answer.value.v[1] / answer.density) : 0.0;
    }
    return (float)(sum / count);
}

typedef void (*layer)(clast_bsdf_input *surface, float roughness);

static void check_furnace(void **state, const char *name, float metallic, layer set, uint32_t material_of(world *))
{
    world w = open_world(*state);
    for (size_t r = 0; r < ROUGHNESSES; r++) {
        double sphere = 0.0, weight = 0.0;
        for (size_t c = 0; c < COSINES; c++) {
            clast_bsdf_input from = white(metallic, roughnesses[r]);
            set(&from, roughnesses[r]);
            vec3 view = view_of(cosines[c]);
            clast_bsdf bsdf = clast_scatter_make(w.tables, material_of(&w), &from, 0.0f, view);
            float energy = energy_of(bsdf, view, 32768);
            sphere += (double)(energy * cosines[c]); // a sphere shows as much of each cosine
            weight += (double)cosines[c];
            if (!(energy > 0.95f && energy < 1.04f)) {
                fail_msg("%s: roughness %g cosine %g: %g", name, (double)roughnesses[r], (double)cosines[c],
                         (double)energy);
            }
        }
        if (fabs(sphere / weight - 1.0) > 0.01) {
            fail_msg("%s: roughness %g: a sphere gives back %g", name, (double)roughnesses[r], sphere / weight);
        }
    }
    close_world(&w);
}

static uint32_t plain_of(world *w)
{
    return w->plain;
}

static uint32_t glass_of(world *w)
{
    return w->glass;
}

static uint32_t thin_of(world *w)
{
    return w->thin;
}

static void set_nothing(clast_bsdf_input *surface, float roughness)
{
    (void)surface;
    (void)roughness;
}

static void set_glass(clast_bsdf_input *surface, float roughness)
{
    (void)roughness;
    surface->transmission = 1.0f;
    surface->thin = 0;
}

static void set_glass_from_inside(clast_bsdf_input *surface, float roughness)
{
    set_glass(surface, roughness);
    surface->inside = 1;
}

static void set_thin_glass(clast_bsdf_input *surface, float roughness)
{
    (void)roughness;
    surface->transmission = 1.0f;
}

static void set_half_glass(clast_bsdf_input *surface, float roughness)
{
    set_glass(surface, roughness);
    surface->transmission = 0.5f;
}

static void set_coat(clast_bsdf_input *surface, float roughness)
{
    surface->clearcoat = 1.0f;
    surface->clearcoat_roughness = 1.0f - roughness;
}

static void set_fuzz(clast_bsdf_input *surface, float roughness)
{
    surface->sheen = store3(splat3(1.0f));
    surface->sheen_roughness = 1.0f - 0.9f * roughness;
}

static void set_all(clast_bsdf_input *surface, float roughness)
{
    set_coat(surface, 0.5f * roughness);
    set_fuzz(surface, roughness);
    set_half_glass(surface, roughness);
}

static void white_surfaces_give_back_all_light(void **state)
{
    check_furnace(state, "metal", 1.0f, set_nothing, plain_of);
    check_furnace(state, "dielectric", 0.0f, set_nothing, plain_of);
    check_furnace(state, "half metal", 0.5f, set_nothing, plain_of);
}

static void clear_glass_gives_back_all_light(void **state)
{
    check_furnace(state, "glass", 0.0f, set_glass, glass_of);
    check_furnace(state, "glass from inside", 0.0f, set_glass_from_inside, glass_of);
    check_furnace(state, "thin glass", 0.0f, set_thin_glass, thin_of);
    check_furnace(state, "half glass", 0.0f, set_half_glass, glass_of);
}

static void layers_take_as_much_as_they_give(void **state)
{
    check_furnace(state, "coat", 0.0f, set_coat, plain_of);
    check_furnace(state, "coated metal", 1.0f, set_coat, plain_of);
    check_furnace(state, "fuzz", 0.0f, set_fuzz, plain_of);
    check_furnace(state, "all", 0.0f, set_all, glass_of);
}

static void stretched_highlights_lose_little(void **state)
{
    (void)state;
    for (float strength = 0.25f; strength <= 1.0f; strength += 0.25f) {
        for (size_t r = 0; r < ROUGHNESSES; r++) {
            double sum = 0.0, weight = 0.0;
            for (int turn = 0; turn < 8; turn++) {
                for (size_t c = 0; c < COSINES; c++) {
                    clast_bsdf_input from = white(1.0f, roughnesses[r]);
                    from.base.anisotropy = strength;
                    float sine = sqrtf(1.0f - cosines[c] * cosines[c]);
                    vec2 side = circle_point((float)turn / 8.0f + 0.03f);
                    vec3 view = vec3(sine * side[0], sine * side[1], cosines[c]);
                    clast_bsdf bsdf = bsdf_make(from, 0.0f, view, 1.0f, 0.0f);
                    sum += (double)(energy_of(bsdf, view, 4096) * cosines[c]);
                    weight += (double)cosines[c];
                }
            }
            if (fabs(sum / weight - 1.0) > 0.01) {
                fail_msg("strength %g roughness %g: %g", (double)strength, (double)roughnesses[r], sum / weight);
            }
        }
    }
}

// The density over all directions, by a grid in height and azimuth.
static double whole_density(clast_bsdf bsdf, vec3 view, double *above)
{
    enum { ROWS = 1000, COLUMNS = 400 };
    double sum = 0.0;
    *above = 0.0;
    for (int i = 0; i < ROWS; i++) {
        for (int k = 0; k < COLUMNS; k++) {
            float z = 2.0f * ((float)i + 0.5f) / ROWS - 1.0f, s = sqrtf(1.0f - z * z);
            vec2 p = circle_point(((float)k + 0.5f) / COLUMNS);
            double density = (double)bsdf_evaluate(bsdf, view, vec3(s * p[0], s * p[1], z)).density;
            sum += density;
            *above += z > 0.0f ? density : 0.0;
        }
    }
    *above *= 4.0 * 3.14159265358979 / (ROWS * COLUMNS);
    return sum * 4.0 * 3.14159265358979 / (ROWS * COLUMNS);
}

static void samples_lie_where_the_density_says(void **state)
{
    world w = open_world(*state);
    const layer layers[] = {set_glass, set_glass_from_inside, set_thin_glass, set_half_glass, set_coat, set_fuzz,
                            set_all};
    for (size_t l = 0; l < sizeof layers / sizeof *layers; l++) {
        clast_bsdf_input from = white(0.0f, 0.5f);
        layers[l](&from, 0.5f);
        vec3 view = view_of(0.6f);
        clast_bsdf bsdf = clast_scatter_make(w.tables, w.glass, &from, 0.0f, view);
        uint32_t sampled = 0, above = 0, count = 65536;
        for (uint32_t i = 0; i < count; i++) {
            clast_bsdf_sample to = bsdf_direction(bsdf, view, sample_square(i, 5), sample_square(i, 6)[0]);
            sampled += to.direction.v[2] != 0.0f;
            above += to.direction.v[2] > 0.0f;
        }
        double expected_above, expected = whole_density(bsdf, view, &expected_above);
        if (fabs(expected - (double)sampled / count) > 0.01 || fabs(expected_above - (double)above / count) > 0.01) {
            fail_msg("layer %zu: density %g, above %g; sampled %g, above %g", l, expected, expected_above,
                     (double)sampled / count, (double)above / count);
        }
    }
    close_world(&w);
}

static void smooth_glass_bends_light_as_snell_says(void **state)
{
    (void)state;
    clast_bsdf_input from = white(0.0f, 0.0f);
    set_glass(&from, 0.0f);
    vec3 view = vec3(0.6f, 0.0f, 0.8f);
    clast_bsdf bsdf = bsdf_make(from, 0.0f, view, 1.0f, 0.0f);
    vec3 passed = glass_direction(bsdf, view, vec2(0.5f, 0.5f), 0.999f);
    assert_true(fabsf(passed[0] + 0.4f) < 5e-3f && fabsf(passed[1]) < 5e-3f && passed[2] < 0.0f);
    from.inside = 1; // beyond the critical angle all is reflected
    bsdf = bsdf_make(from, 0.0f, view, 1.0f, 0.0f);
    vec3 steep = vec3(0.8f, 0.0f, 0.6f);
    assert_true(glass_direction(bsdf, steep, vec2(0.5f, 0.5f), 0.999f)[2] > 0.0f);
    assert_true(fabsf(fresnel_dielectric(1.0f, 1.5f) - 0.04f) < 1e-6f);
    assert_true(fabsf(fresnel_dielectric(0.5f, 1.5f) - 0.0892f) < 1e-3f);
    assert_true(fresnel_dielectric(0.6f, 1.0f / 1.5f) == 1.0f);
    assert_true(fresnel_dielectric(0.0f, 1.5f) > 0.999f);
}

static void a_coat_is_seen_on_what_is_black(void **state)
{
    (void)state;
    clast_bsdf_input from = bsdf_input(brdf_input(splat3(0.0f), 1.0f, 0.5f));
    set_coat(&from, 1.0f);
    vec3 head_on = view_of(1.0f), grazing = view_of(0.1f);
    assert_true(fabsf(energy_of(bsdf_make(from, 0.0f, head_on, 1.0f, 0.0f), head_on, 4096) - 0.04f) < 4e-3f);
    assert_true(energy_of(bsdf_make(from, 0.0f, grazing, 1.0f, 0.0f), grazing, 4096) > 0.5f);
}

static void no_value_breaks_it(void **state)
{
    world w = open_world(*state);
    const float edge[] = {0.0f, 1e-6f, 0.5f, 1.0f};
    for (uint32_t i = 0; i < 4 * 4 * 4 * 4; i++) {
        clast_bsdf_input from = white(edge[i % 4], edge[i / 4 % 4]);
        set_all(&from, edge[i / 16 % 4]);
        from.base.ior = i % 3 == 0 ? 0.0f : 1.0f + edge[i / 64];
        from.base.specular = edge[i % 4];
        from.base.anisotropy = edge[i / 16 % 4];
        from.inside = i % 2;
        vec3 view = view_of(max1(edge[i / 64], 1e-6f));
        clast_bsdf bsdf = clast_scatter_make(w.tables, w.glass, &from, 0.0f, view);
        for (uint32_t s = 0; s < 64; s++) {
            clast_bsdf_sample to = bsdf_direction(bsdf, view, sample_square(s, 3), sample_square(s, 4)[0]);
            clast_brdf_answer answer = bsdf_evaluate(bsdf, view, load3(to.direction));
            assert_true(is_finite3(load3(to.direction)) && is_finite3(load3(answer.value)));
            assert_true(is_finite1(answer.density) && answer.density >= 0.0f);
        }
    }
    close_world(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(white_surfaces_give_back_all_light), CONTEXT_TEST(clear_glass_gives_back_all_light),
        CONTEXT_TEST(layers_take_as_much_as_they_give),   CONTEXT_TEST(stretched_highlights_lose_little),
        CONTEXT_TEST(samples_lie_where_the_density_says), CONTEXT_TEST(smooth_glass_bends_light_as_snell_says),
        CONTEXT_TEST(a_coat_is_seen_on_what_is_black),    CONTEXT_TEST(no_value_breaks_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
