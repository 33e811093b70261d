// SPDX-License-Identifier: Apache-2.0
// Layers, glass and fuzz in a furnace: where light of one comes from everywhere, white surfaces send back one.
#include "test.h"

#include <math.h>

#include "render/scatter.h"
#include "shared/path.h"

static const float roughnesses[] = {0.0f, 0.1f, 0.25f, 0.4f, 0.6f, 0.8f, 1.0f};
static const float cosines[] = {0.05f, 0.2f, 0.5f, 0.8f, 1.0f};
enum { ROUGHNESSES = sizeof roughnesses / sizeof roughnesses[0], COSINES = sizeof cosines / sizeof cosines[0] };

static const float iors[] = {1.0f, 1.1f, 1.5f, 2.42f, 3.0f};
enum { IORS = sizeof iors / sizeof iors[0] };

// A material for each index of refraction, the border of a volume, and one that is not.
typedef struct world {
    clast_context *context;
    clast_scene *scene;
    clast_scatter_tables *tables;
    uint32_t volumes[IORS], thin;
} world;

static uint32_t add(world *w, float ior, float thickness)
{
    clast_material_desc desc = clast_material_defaults();
    desc.transmission = 1.0f;
    desc.thickness = thickness;
    desc.ior = ior;
    desc.sheen_colour[0] = 1.0f;
    uint32_t number;
    assert_ok(w->context, clast_scene_add_material(w->scene, &desc, NULL, &number));
    return number;
}

static world open_world(clast_context *context)
{
    world w = {.context = context};
    assert_ok(context, clast_scene_create(context, &w.scene));
    for (size_t i = 0; i < IORS; i++) {
        w.volumes[i] = add(&w, iors[i], 1.0f);
    }
    w.thin = add(&w, 1.5f, 0.0f);
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

// What a sphere of a surface gives back, which shows as much of each cosine; `stretched` surfaces are turned as well.
static double sphere_of(const world *w, uint32_t material, const clast_bsdf_input *from, const char *name)
{
    uint32_t turns = from->base.anisotropy > 0.0f ? 3 : 1;
    double sphere = 0.0, weight = 0.0;
    for (size_t c = 0; c < COSINES; c++) {
        double energy = 0.0;
        for (uint32_t turn = 0; turn < turns; turn++) {
            float sine = sqrtf(1.0f - cosines[c] * cosines[c]);
            vec2 side = circle_point(((float)turn + 0.4f) / (4.0f * (float)turns));
            vec3 view = vec3(sine * side[0], sine * side[1], cosines[c]);
            clast_bsdf bsdf = clast_scatter_make(w->tables, material, from, 0.0f, view);
            energy += (double)energy_of(bsdf, view, 4096) / turns;
        }
        sphere += energy * (double)cosines[c];
        weight += (double)cosines[c];
        if (!(energy > 0.94 && energy < 1.05)) {
            fail_msg("%s: index %g roughness %g cosine %g: %g", name, (double)from->base.ior,
                     (double)from->base.roughness, (double)cosines[c], energy);
        }
    }
    return sphere / weight;
}

static void check_furnace(const world *w, const char *name, float metallic, layer set)
{
    for (size_t i = 0; i < IORS; i++) {
        for (size_t r = 0; r < ROUGHNESSES; r++) {
            clast_bsdf_input from = white(metallic, roughnesses[r]);
            from.base.ior = iors[i];
            set(&from, roughnesses[r]);
            double sphere = sphere_of(w, from.thin != 0 ? w->thin : w->volumes[i], &from, name);
            if (fabs(sphere - 1.0) > 0.01) {
                fail_msg("%s: index %g roughness %g: a sphere gives back %g", name, (double)iors[i],
                         (double)roughnesses[r], sphere);
            }
        }
    }
}

static void set_nothing(clast_bsdf_input *surface, float roughness)
{
    (void)surface;
    (void)roughness;
}

static void set_half_specular(clast_bsdf_input *surface, float roughness)
{
    (void)roughness;
    surface->base.specular = 0.5f;
}

static void set_no_specular(clast_bsdf_input *surface, float roughness)
{
    (void)roughness;
    surface->base.specular = 0.0f;
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

static void set_dull_glass(clast_bsdf_input *surface, float roughness)
{
    set_glass(surface, roughness);
    surface->base.specular = 0.3f;
    surface->inside = roughness > 0.5f;
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

static void set_filmed_glass(clast_bsdf_input *surface, float roughness)
{
    set_glass(surface, roughness);
    surface->base.film = 1.0f;
    surface->base.film_ior = 1.7f;
    surface->base.film_thickness = 300.0f + 400.0f * roughness;
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

static void set_leaf(clast_bsdf_input *surface, float roughness)
{
    surface->through = 0.3f + 0.7f * roughness;
}

static void set_stretch(clast_bsdf_input *surface, float roughness)
{
    surface->base.anisotropy = 1.0f - 0.6f * roughness;
}

static void set_stretched_glass(clast_bsdf_input *surface, float roughness)
{
    surface->base.anisotropy = 0.6f - 0.5f * roughness; // more loses more than a hundredth
    set_glass(surface, roughness);
}

static void set_all(clast_bsdf_input *surface, float roughness)
{
    set_coat(surface, 0.5f * roughness);
    set_fuzz(surface, roughness);
    set_half_glass(surface, roughness);
    set_leaf(surface, roughness);
    surface->base.specular = 0.8f;
}

static void white_surfaces_give_back_all_light(void **state)
{
    world w = open_world(*state);
    check_furnace(&w, "metal", 1.0f, set_nothing);
    check_furnace(&w, "dielectric", 0.0f, set_nothing);
    check_furnace(&w, "half metal", 0.5f, set_nothing);
    check_furnace(&w, "half specular", 0.0f, set_half_specular);
    check_furnace(&w, "not specular", 0.0f, set_no_specular);
    check_furnace(&w, "leaf", 0.0f, set_leaf);
    close_world(&w);
}

static void clear_glass_gives_back_all_light(void **state)
{
    world w = open_world(*state);
    check_furnace(&w, "glass", 0.0f, set_glass);
    check_furnace(&w, "glass from inside", 0.0f, set_glass_from_inside);
    check_furnace(&w, "dull glass", 0.0f, set_dull_glass);
    check_furnace(&w, "thin glass", 0.0f, set_thin_glass);
    check_furnace(&w, "half glass", 0.0f, set_half_glass);
    check_furnace(&w, "filmed glass", 0.0f, set_filmed_glass);
    close_world(&w);
}

static void layers_take_as_much_as_they_give(void **state)
{
    world w = open_world(*state);
    check_furnace(&w, "coat", 0.0f, set_coat);
    check_furnace(&w, "coated metal", 1.0f, set_coat);
    check_furnace(&w, "fuzz", 0.0f, set_fuzz);
    check_furnace(&w, "fuzzy metal", 1.0f, set_fuzz);
    check_furnace(&w, "all", 0.2f, set_all);
    close_world(&w);
}

static void stretched_highlights_lose_little(void **state)
{
    world w = open_world(*state);
    check_furnace(&w, "stretched metal", 1.0f, set_stretch);
    check_furnace(&w, "stretched dielectric", 0.0f, set_stretch);
    check_furnace(&w, "stretched glass", 0.0f, set_stretched_glass);
    close_world(&w);
}

// A film colours light: what it does not reflect of the brightest colour passes to what is below, of the others less. Metal
// below it takes light.
static void films_gain_no_light(void **state)
{
    world w = open_world(*state);
    float largest = 0.0f;
    for (uint32_t i = 0; i < 300; i++) {
        clast_bsdf_input from = white(i % 2 == 0 ? 1.0f : 0.0f, roughnesses[i % ROUGHNESSES]);
        from.base.film = i % 3 == 0 ? 0.5f : 1.0f;
        from.base.film_ior = 1.0f + 0.01f * (float)(i % 120);
        from.base.film_thickness = 4.0f * (float)i;
        vec3 view = view_of(cosines[i % COSINES]);
        clast_bsdf bsdf = clast_scatter_make(w.tables, w.thin, &from, 0.0f, view);
        float energy = energy_of(bsdf, view, 2048);
        largest = max1(largest, energy);
        assert_true(energy > 0.1f && energy < 1.02f);
    }
    assert_true(largest > 0.9f);
    close_world(&w);
}

// Soap: no film reflects nothing, a quarter of a wave the most, half a wave nothing again; black where it is very thin.
static void films_interfere(void **state)
{
    (void)state;
    vec3 water = splat3(reflectance_of_ior(1.0001f)); // air on both sides
    vec3 quarter = thin_film_reflectance(1.33f, 0.25f * 550.0f / 1.33f, 1.0f, water);
    vec3 half = thin_film_reflectance(1.33f, 0.5f * 550.0f / 1.33f, 1.0f, water);
    vec3 thin = thin_film_reflectance(1.33f, 1.0f, 1.0f, water);
    assert_true(quarter[1] > 0.06f && quarter[1] < 0.085f); // 4 R = 0.08
    assert_true(half[1] < 0.02f);
    assert_true(largest3(thin) < 5e-3f);
    vec3 on_glass = thin_film_reflectance(1.5f, 500.0f, 0.8f, splat3(0.04f)); // of the glass's own index
    vec3 glass = fresnel_schlick(splat3(0.04f), splat3(1.0f), 0.8f);
    assert_true(fabsf(on_glass[1] - glass[1]) < 2e-3f);
}

static void what_passes_diffusely_has_its_own_colour(void **state)
{
    world w = open_world(*state);
    clast_bsdf_input from = white(0.0f, 1.0f);
    from.through = 0.75f;
    from.through_colour = store3(vec3(1.0f, 0.5f, 0.25f));
    from.base.specular = 0.0f;
    vec3 view = view_of(0.7f);
    clast_bsdf bsdf = clast_scatter_make(w.tables, w.thin, &from, 0.0f, view);
    clast_brdf_answer above = bsdf_evaluate(bsdf, view, view_of(0.5f));
    clast_brdf_answer below = bsdf_evaluate(bsdf, view, view_of(0.5f) * vec3(1.0f, 1.0f, -1.0f));
    float lambert = 0.5f / PI;
    assert_true(fabsf(above.value.v[0] - 0.25f * lambert) < 1e-4f);
    for (int c = 0; c < 3; c++) {
        assert_true(fabsf(below.value.v[c] - 0.75f * lambert * from.through_colour.v[c]) < 1e-4f);
    }
    close_world(&w);
}

// Abbe's number as its definition has it: (n_d - 1) / (n_F - n_C), and the violet side is bent more.
static void glass_parts_colours_by_abbe_numbers(void **state)
{
    (void)state;
    float red = dispersed_ior(1.5f, 20.0f / 50.0f, 0), green = dispersed_ior(1.5f, 20.0f / 50.0f, 1),
          blue = dispersed_ior(1.5f, 20.0f / 50.0f, 2);
    assert_true(green == 1.5f && fabsf((green - 1.0f) / (blue - red) - 50.0f) < 0.1f);
    assert_true(dispersed_ior(1.1f, 100.0f, 0) == 1.0f && dispersed_ior(0.0f, 1.0f, 2) == 0.0f);
    vec3 sum = splat3(0.0f), carried = vec3(0.5f, 0.25f, 0.75f);
    for (uint32_t i = 0; i < 3000; i++) {
        clast_path_colour chosen = path_choose_colour(carried, ((float)i + 0.5f) / 3000.0f);
        assert_true(chosen.throughput.v[chosen.colour] == largest3(load3(chosen.throughput)));
        sum = sum + load3(chosen.throughput) * (1.0f / 3000.0f);
    }
    for (int c = 0; c < 3; c++) {
        assert_true(fabsf(sum[c] - carried[c]) < 1e-3f);
    }
    assert_int_equal(path_choose_colour(vec3(0.0f, 0.0f, 2.0f), 0.0f).colour, 2);
    assert_int_equal(path_choose_colour(vec3(1.0f, 1.0f, 0.0f), 0.99999994f).colour, 1);
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
    const layer layers[] = {set_glass, set_glass_from_inside, set_thin_glass,      set_half_glass, set_coat, set_fuzz,
                            set_leaf,  set_filmed_glass,      set_stretched_glass, set_all};
    for (size_t l = 0; l < sizeof layers / sizeof *layers; l++) {
        clast_bsdf_input from = white(0.0f, 0.5f);
        layers[l](&from, 0.5f);
        vec3 view = view_of(0.6f);
        clast_bsdf bsdf = clast_scatter_make(w.tables, w.volumes[2], &from, 0.0f, view);
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
    clast_bsdf bsdf = bsdf_make(from, 0.0f, view, glass_albedo(1.0f, 1.0f), 0.0f);
    vec3 passed = glass_direction(bsdf, view, vec2(0.5f, 0.5f), 0.999f);
    assert_true(fabsf(passed[0] + 0.4f) < 5e-3f && fabsf(passed[1]) < 5e-3f && passed[2] < 0.0f);
    from.inside = 1; // beyond the critical angle all is reflected
    bsdf = bsdf_make(from, 0.0f, view, glass_albedo(1.0f, 1.0f), 0.0f);
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
    assert_true(fabsf(energy_of(bsdf_make(from, 0.0f, head_on, glass_albedo(1.0f, 1.0f), 0.0f), head_on, 4096) -
                      0.04f) < 4e-3f);
    assert_true(energy_of(bsdf_make(from, 0.0f, grazing, glass_albedo(1.0f, 1.0f), 0.0f), grazing, 4096) > 0.5f);
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
        from.base.film = edge[i / 4 % 4];
        from.base.film_thickness = i % 5 == 0 ? 1e30f : 1000.0f * edge[i % 4];
        from.base.film_ior = i % 7 == 0 ? 1e30f : 1.0f + edge[i / 16 % 4];
        vec3 view = view_of(max1(edge[i / 64], 1e-6f));
        clast_bsdf bsdf = clast_scatter_make(w.tables, w.volumes[2], &from, 0.0f, view);
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
        CONTEXT_TEST(white_surfaces_give_back_all_light),
        CONTEXT_TEST(clear_glass_gives_back_all_light),
        CONTEXT_TEST(layers_take_as_much_as_they_give),
        CONTEXT_TEST(stretched_highlights_lose_little),
        CONTEXT_TEST(samples_lie_where_the_density_says),
        CONTEXT_TEST(smooth_glass_bends_light_as_snell_says),
        CONTEXT_TEST(a_coat_is_seen_on_what_is_black),
        CONTEXT_TEST(no_value_breaks_it),
        CONTEXT_TEST(films_gain_no_light),
        CONTEXT_TEST(films_interfere),
        CONTEXT_TEST(what_passes_diffusely_has_its_own_colour),
        CONTEXT_TEST(glass_parts_colours_by_abbe_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
