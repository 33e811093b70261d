// SPDX-License-Identifier: Apache-2.0
// The path tracer against one that does nothing cleverly: every triangle is tried for every ray, directions are chosen alike over
// all sides, lights are met by chance, paths end only where they must, and numbers are plain random ones. What they share is how
// surfaces scatter and what a camera sees. A number as argument multiplies the samples of both.
#include "picture.h"

#include <stdlib.h>

#include "render/scatter.h"
#include "shared/path.h"

enum { SIZE = 24, REGIONS = 3, REGION = SIZE / REGIONS, RENDERS = 8, BOUNCES = 5, TRIANGLES_MOST = 64 };
static uint32_t effort = 1;

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1};

typedef struct triangle {
    vec3 corner, first, second, normal; // edges; the front's
    uint32_t material;
} triangle;

// A picture, and its triangles once more.
typedef struct room {
    picture picture;
    triangle triangles[TRIANGLES_MOST];
    size_t count;
    clast_scatter_tables *tables;
    uint64_t random;
} room;

// ---------------------------------------------------------------------------------------------------------------- rooms

static void add_square(room *r, vec3 centre, vec3 right, vec3 up, uint32_t material)
{
    picture_add_square(&r->picture, centre, right, up, material);
    vec3 a = centre - right - up, c = centre + right + up, normal = normalize3(cross3(right, up));
    assert_true(r->count + 2 <= TRIANGLES_MOST);
    r->triangles[r->count++] = (triangle){a, right * 2.0f, right * 2.0f + up * 2.0f, normal, material};
    r->triangles[r->count++] = (triangle){a, c - a, up * 2.0f, normal, material};
}

// A block turned about the vertical; half its sides.
static void add_block(room *r, vec3 centre, vec3 half, float turns, uint32_t material)
{
    vec2 turned = circle_point(turns);
    vec3 x = vec3(turned[0], 0.0f, turned[1]) * half[0], z = vec3(-turned[1], 0.0f, turned[0]) * half[2],
         y = Y * half[1];
    add_square(r, centre + z, x, y, material);
    add_square(r, centre - z, x * -1.0f, y, material);
    add_square(r, centre + x, z * -1.0f, y, material);
    add_square(r, centre - x, z, y, material);
    add_square(r, centre + y, x, z * -1.0f, material);
    add_square(r, centre - y, x, z, material);
}

static uint32_t add_material(room *r, const clast_material_desc *desc)
{
    uint32_t number;
    assert_ok(r->picture.context, clast_scene_add_material(r->picture.scene, desc, NULL, &number));
    return number;
}

static uint32_t add_paint(room *r, float red, float green, float blue)
{
    clast_material_desc desc = clast_material_defaults();
    desc.base_colour[0] = red;
    desc.base_colour[1] = green;
    desc.base_colour[2] = blue;
    return add_material(r, &desc);
}

// Goral et al., Modeling the Interaction of Light Between Diffuse Surfaces, 1984: white walls, one red, one green, a lamp above.
static room cornell_box(clast_context *context)
{
    room r = {.picture = picture_open(context, SIZE, 16 * effort), .random = 12345};
    r.picture.settings.bounces = BOUNCES;
    uint32_t white = add_paint(&r, 0.73f, 0.73f, 0.7f);
    add_square(&r, Y * -1.0f, X, Z * -1.0f, white);
    add_square(&r, Y * 1.0f, X, Z, white);
    add_square(&r, Z * -1.0f, X, Y, white);
    add_square(&r, X * -1.0f, Z * -1.0f, Y, add_paint(&r, 0.6f, 0.06f, 0.05f));
    add_square(&r, X * 1.0f, Z, Y, add_paint(&r, 0.12f, 0.45f, 0.1f));
    add_square(&r, Y * 0.98f, X * 0.5f, Z * 0.5f, picture_material(&r.picture, 0.5f, 0.0f, 1.0f, 6.0f));
    picture_look(&r.picture, Z * 3.4f, vec3(0.0f, -0.05f, 0.0f), 0.68f);
    return r;
}

static void add_blocks(room *r, uint32_t tall, uint32_t low)
{
    add_block(r, vec3(-0.35f, -0.4f, -0.3f), vec3(0.3f, 0.6f, 0.3f), 0.05f, tall);
    add_block(r, vec3(0.35f, -0.65f, 0.3f), vec3(0.32f, 0.34f, 0.32f), -0.06f, low);
}

// ------------------------------------------------------------------------------------------------------ the plain tracer

static float draw(room *r)
{
    r->random = r->random * 6364136223846793005ull + 1442695040888963407ull;
    uint32_t bits = (uint32_t)(((r->random >> 22) ^ r->random) >> (22 + (r->random >> 61)));
    return (float)(bits >> 8) * 0x1p-24f;
}

// Moller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
static const triangle *find(const room *r, vec3 origin, vec3 direction, float *distance)
{
    const triangle *found = NULL;
    *distance = INFINITY;
    for (size_t i = 0; i < r->count; i++) {
        const triangle *t = &r->triangles[i];
        vec3 p = cross3(direction, t->second), away = origin - t->corner, q = cross3(away, t->first);
        float scale = 1.0f / dot3(t->first, p), u = dot3(away, p) * scale, v = dot3(direction, q) * scale,
              along = dot3(t->second, q) * scale;
        if (u >= 0.0f && v >= 0.0f && u + v <= 1.0f && along > 1e-4f && along < *distance) {
            *distance = along;
            found = t;
        }
    }
    return found;
}

// All sides alike. Through glass, a few of them carry nearly all light: half of the directions are those that it prefers.
static vec3 choose_side(room *r, clast_bsdf bsdf, vec3 view, float *density)
{
    bool passes = bsdf_passes(bsdf);
    float z = 2.0f * draw(r) - 1.0f, level = sqrtf(max1(1.0f - z * z, 0.0f));
    vec2 circle = circle_point(draw(r));
    vec3 light = vec3(level * circle[0], level * circle[1], passes ? z : fabsf(z));
    *density = passes ? 0.25f * INVERSE_PI : 0.5f * INVERSE_PI;
    if (bsdf.glass > 0.0f) {
        if (draw(r) < 0.5f) {
            vec2 u = vec2(draw(r), draw(r));
            light = load3(bsdf_direction(bsdf, view, u, draw(r)).direction);
        }
        *density = 0.5f * *density + 0.5f * bsdf_evaluate(bsdf, view, light).density;
    }
    return light;
}

static vec3 follow(room *r, vec3 origin, vec3 direction)
{
    vec3 carried = splat3(1.0f), sum = splat3(0.0f), absorption = splat3(0.0f);
    for (uint32_t bounce = 0;; bounce++) {
        float distance;
        const triangle *met = find(r, origin, direction, &distance);
        if (met == NULL) {
            return sum;
        }
        const clast_material *material = &r->picture.scene->materials[met->material].record;
        carried = carried * passed_through(absorption, distance);
        sum = sum + carried * load3(material->emissive);
        if (bounce == BOUNCES) {
            return sum;
        }
        bool from_behind = dot3(met->normal, direction) > 0.0f;
        clast_basis frame = basis_around(from_behind ? met->normal * -1.0f : met->normal);
        clast_bsdf_input from = bsdf_input(brdf_input(
            load3((packed3){{material->base_colour.v[0], material->base_colour.v[1], material->base_colour.v[2]}}),
            material->metallic, material->roughness));
        from.base.ior = material->ior;
        from.transmission = material->transmission;
        from.through = material->diffuse_transmission;
        from.clearcoat = material->clearcoat;
        from.clearcoat_roughness = material->clearcoat_roughness;
        from.thin = material->thickness > 0.0f ? 0 : 1;
        from.inside = from.thin == 0 && from_behind;
        vec3 view = to_basis(frame, direction * -1.0f);
        clast_bsdf bsdf = clast_scatter_make(r->tables, met->material, &from, 0.0f, view);
        float density;
        vec3 light = choose_side(r, bsdf, view, &density);
        carried = carried * load3(bsdf_evaluate(bsdf, view, light).value) * (1.0f / density);
        if (light[2] < 0.0f) {
            absorption = from.thin == 0 && from.inside == 0 ? load3(material->absorption) : splat3(0.0f);
        }
        origin = origin + direction * distance;
        direction = from_basis(frame, light);
    }
}

// ----------------------------------------------------------------------------------------------------------- comparisons

// Sums over what was found for a region.
typedef struct tally {
    double sum, squares;
    double count;
} tally;

static void add(tally *t, double value)
{
    t->sum += value;
    t->squares += value * value;
    t->count += 1.0;
}

static double mean_of(const tally *t)
{
    return t->sum / t->count;
}

// Of the mean.
static double variance_of(const tally *t)
{
    double mean = mean_of(t);
    return (t->squares / t->count - mean * mean) / (t->count - 1.0);
}

static void trace_plainly(room *r, tally regions[REGIONS * REGIONS])
{
    uint32_t paths = 700 * effort; // of each pixel
    clast_camera camera = r->picture.frame->settings.camera;
    for (uint32_t pixel = 0; pixel < SIZE * SIZE; pixel++) {
        uint32_t x = pixel % SIZE, y = pixel / SIZE;
        tally *region = &regions[y / REGION * REGIONS + x / REGION];
        for (uint32_t i = 0; i < paths; i++) {
            clast_camera_ray ray = camera_ray(camera, ((float)x + camera_offset(draw(r))) / SIZE,
                                              ((float)y + camera_offset(draw(r))) / SIZE);
            add(region, (double)luminance(follow(r, load3(ray.origin), load3(ray.direction))));
        }
    }
}

static void render_cleverly(room *r, tally regions[REGIONS * REGIONS])
{
    const clast_view colour = CLAST_VIEW_COLOUR;
    for (uint32_t i = 0; i < RENDERS; i++) {
        r->picture.settings.seed = i;
        assert_ok(r->picture.context, picture_try(&r->picture, &colour, 1));
        double sums[REGIONS * REGIONS] = {0};
        for (uint32_t pixel = 0; pixel < SIZE * SIZE; pixel++) {
            uint32_t x = pixel % SIZE, y = pixel / SIZE;
            const float *p = picture_pixel(&r->picture, x, y);
            sums[y / REGION * REGIONS + x / REGION] += (double)luminance(vec3(p[0], p[1], p[2]));
        }
        for (int k = 0; k < REGIONS * REGIONS; k++) {
            add(&regions[k], sums[k] / (REGION * REGION));
        }
    }
}

static void compare(const char *name, room *r)
{
    picture_build(&r->picture);
    assert_ok(r->picture.context, clast_scatter_create(r->picture.scene, &r->tables));
    tally plain[REGIONS * REGIONS] = {{0}}, clever[REGIONS * REGIONS] = {{0}};
    trace_plainly(r, plain);
    render_cleverly(r, clever);
    double most = 0.0, whole = 0.0, whole_variance = 0.0;
    for (int k = 0; k < REGIONS * REGIONS; k++) {
        double difference = mean_of(&clever[k]) - mean_of(&plain[k]);
        double error = sqrt(variance_of(&clever[k]) + variance_of(&plain[k]));
        print_message("%s, region %d: %.5f, plainly %.5f: %+.2f standard errors of %.2f %%\n", name, k,
                      mean_of(&clever[k]), mean_of(&plain[k]), difference / error, 100.0 * error / mean_of(&plain[k]));
        most = fmax(most, fabs(difference) / error);
        whole += difference;
        whole_variance += error * error;
    }
    double all = whole / sqrt(whole_variance);
    print_message("%s: regions differ by up to %.2f standard errors, the whole by %.2f\n", name, most, all);
    assert_true(most < 3.0 && fabs(all) < 3.0);
    clast_scatter_destroy(r->picture.context, r->tables);
    picture_close(&r->picture);
}

static void a_box_of_painted_walls_is_lit_alike(void **state)
{
    room r = cornell_box(*state);
    uint32_t white = add_paint(&r, 0.73f, 0.73f, 0.7f);
    add_blocks(&r, white, white);
    compare("Cornell box", &r);
}

static void rough_glass_and_metal_are_lit_alike(void **state)
{
    room r = cornell_box(*state);
    clast_material_desc glass = clast_material_defaults(), metal = glass;
    glass.base_colour[0] = glass.base_colour[1] = glass.base_colour[2] = 1.0f;
    glass.transmission = 1.0f;
    glass.thickness = 1.0f;
    glass.roughness = 0.6f;
    glass.attenuation_distance = 1.0f;
    glass.attenuation_colour[0] = 0.4f;
    metal.metallic = 1.0f;
    metal.roughness = 0.6f;
    add_blocks(&r, add_material(&r, &metal), add_material(&r, &glass));
    compare("rough glass", &r);
}

static void leaves_and_coats_are_lit_alike(void **state)
{
    room r = cornell_box(*state);
    clast_material_desc leaf = clast_material_defaults(), coat = leaf;
    leaf.diffuse_transmission = 0.6f;
    coat.clearcoat = 1.0f;
    coat.clearcoat_roughness = 0.5f;
    coat.base_colour[2] = 0.1f;
    add_blocks(&r, add_material(&r, &leaf), add_material(&r, &coat));
    compare("leaf and coat", &r);
}

int main(int argc, char **argv)
{
    effort = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 1;
    effort = effort > 0 ? effort : 1;
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_box_of_painted_walls_is_lit_alike),
        CONTEXT_TEST(rough_glass_and_metal_are_lit_alike),
        CONTEXT_TEST(leaves_and_coats_are_lit_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
