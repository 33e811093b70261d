// SPDX-License-Identifier: Apache-2.0
// Surfaces of hits, and which hits alpha lets count, on a device against the processor: hits of rays through a small scene
// with every kind of source and every layer of materials.
#include <math.h>
#include <string.h>

#include "render/levels.h"
#include "render/path.h"
#include "shapes.h"
#include "shared/random.h"
#include "vulkan/frame.h"
#include "vulkan/materials.h"
#include "vulkan/test_device.h"

enum { RAYS = 6000, SIZE = 32 };

static test_device device;

static float draw(void)
{
    static uint32_t draws;
    return unit_float(hash1(draws++));
}

// --------------------------------------------------------------------------------------------------------------- scene

static uint32_t add_texture(clast_scene *scene, uint32_t channels, clast_pixel_type type, uint32_t seed)
{
    enum { WIDTH = 16, HEIGHT = 8 };
    float values[WIDTH * HEIGHT * 4];
    for (uint32_t i = 0; i < WIDTH * HEIGHT * channels; i++) {
        uint32_t bits = hash2(seed, i);
        switch (type) {
        case CLAST_PIXEL_UNORM8: ((uint8_t *)values)[i] = (uint8_t)bits; break;
        case CLAST_PIXEL_UNORM16: ((uint16_t *)values)[i] = (uint16_t)bits; break;
        case CLAST_PIXEL_FLOAT: values[i] = unit_float(bits); break;
        }
    }
    clast_image image = {WIDTH, HEIGHT, channels, type, values};
    clast_texture texture = {0, CLAST_WRAP_REPEAT, CLAST_WRAP_MIRROR, (clast_filter)(seed % 4 == 3)};
    uint32_t number;
    assert_ok(device.context, clast_scene_add_image(scene, &image, NULL, &texture.image));
    assert_ok(device.context, clast_scene_add_texture(scene, &texture, &number));
    return number;
}

static clast_texture_slot slot_of(uint32_t texture, uint32_t i)
{
    return (clast_texture_slot){.texture = texture,
                                .coordinate_set = i & 1,
                                .offset = {0.1f * (float)i, 0.3f},
                                .scale = {1.5f, 0.5f + 0.25f * (float)i},
                                .rotation = i % 3 == 2 ? 0.7f : 0.0f};
}

static clast_material_desc plain_material(uint32_t textures[4], uint32_t seed)
{
    clast_material_desc desc = clast_material_defaults();
    for (int c = 0; c < 3; c++) {
        desc.base_colour[c] = 0.5f + 0.5f * draw();
    }
    desc.metallic = draw();
    desc.roughness = draw();
    desc.normal_scale = 0.7f;
    desc.base_colour_texture = slot_of(textures[0], seed);
    desc.metallic_roughness_texture = slot_of(textures[1], seed + 1);
    desc.normal_texture = slot_of(textures[2], 0);
    return desc;
}

static clast_material_desc layered_material(uint32_t textures[4])
{
    clast_material_desc desc = plain_material(textures, 1);
    desc.emissive[0] = 3.0f;
    desc.emissive[2] = 1.0f;
    desc.emissive_texture = slot_of(textures[3], 2);
    desc.ior = 1.4f;
    desc.specular = 0.8f;
    desc.specular_texture = slot_of(textures[0], 3);
    desc.specular_colour_texture = slot_of(textures[1], 4);
    desc.clearcoat = 0.9f;
    desc.clearcoat_roughness = 0.4f;
    desc.clearcoat_normal_scale = 1.2f;
    desc.clearcoat_texture = slot_of(textures[3], 1);
    desc.clearcoat_roughness_texture = slot_of(textures[2], 2);
    desc.clearcoat_normal_texture = slot_of(textures[1], 0);
    desc.sheen_colour[0] = desc.sheen_colour[1] = 0.7f;
    desc.sheen_roughness = 0.6f;
    desc.sheen_colour_texture = slot_of(textures[2], 5);
    desc.sheen_roughness_texture = slot_of(textures[0], 1);
    desc.anisotropy = 0.8f;
    desc.anisotropy_rotation = 0.4f;
    desc.anisotropy_texture = slot_of(textures[3], 0);
    desc.iridescence = 0.8f;
    desc.iridescence_ior = 1.6f;
    desc.iridescence_texture = slot_of(textures[2], 1);
    desc.iridescence_thickness_texture = slot_of(textures[1], 3);
    desc.diffuse_transmission = 0.7f;
    desc.diffuse_transmission_colour[1] = 0.6f;
    desc.diffuse_transmission_texture = slot_of(textures[0], 2);
    desc.diffuse_transmission_colour_texture = slot_of(textures[3], 4);
    return desc;
}

static uint32_t add_material(clast_scene *scene, const clast_material_desc *desc)
{
    uint32_t number;
    assert_ok(device.context, clast_scene_add_material(scene, desc, NULL, &number));
    return number;
}

static uint32_t add_materials(clast_scene *scene)
{
    uint32_t textures[4];
    for (uint32_t i = 0; i < 4; i++) {
        textures[i] = add_texture(scene, 4 - i % 2, (clast_pixel_type)(i % 3), i);
    }
    clast_material_desc desc = layered_material(textures);
    uint32_t first = add_material(scene, &desc);
    desc = plain_material(textures, 0);
    desc.alpha_mode = CLAST_ALPHA_MASK;
    desc.alpha_cutoff = 0.4f;
    desc.double_sided = false;
    add_material(scene, &desc);
    desc = plain_material(textures, 2);
    desc.alpha_mode = CLAST_ALPHA_BLEND;
    desc.base_colour[3] = 0.8f;
    add_material(scene, &desc);
    desc = clast_material_defaults();
    desc.unlit = true;
    desc.double_sided = false;
    add_material(scene, &desc);
    desc = plain_material(textures, 1);
    desc.metallic_roughness_texture.texture = CLAST_NONE;
    desc.transmission = 0.9f;
    desc.transmission_texture = slot_of(textures[0], 1);
    desc.thickness = 1.0f;
    desc.attenuation_distance = 2.0f;
    desc.dispersion = 0.3f;
    desc.attenuation_colour[1] = 0.5f;
    add_material(scene, &desc);
    return first;
}

// A sphere whose triangles have materials in turn, with colours, tangents and two sets of coordinates.
static uint32_t add_rich_sphere(clast_scene *scene, uint32_t first_material)
{
    shape s = shape_sphere(24, 12);
    float *colours = malloc(s.mesh.vertex_count * 16), *tangents = malloc(s.mesh.vertex_count * 16),
          *second = malloc(s.mesh.vertex_count * 8);
    uint32_t *materials = malloc(s.mesh.triangle_count * 4), geometry;
    assert_true(colours != NULL && tangents != NULL && second != NULL && materials != NULL);
    for (uint32_t i = 0; i < s.mesh.vertex_count; i++) {
        const float *n = s.normals + 3 * i;
        const float tangent[4] = {n[2], 0.1f, -n[0], i % 2 == 0 ? 1.0f : -1.0f};
        memcpy(tangents + 4 * i, tangent, sizeof tangent);
        for (uint32_t c = 0; c < 4; c++) {
            colours[4 * i + c] = 0.6f + 0.4f * draw();
        }
        second[2 * i] = draw();
        second[2 * i + 1] = 3.0f * draw();
    }
    for (uint32_t i = 0; i < s.mesh.triangle_count; i++) {
        materials[i] = first_material + i % 5;
    }
    s.mesh.colours = colours;
    s.mesh.tangents = tangents;
    s.mesh.coordinates[1] = second;
    s.mesh.triangle_materials = materials;
    assert_ok(device.context, clast_scene_add_mesh(scene, &s.mesh, "rich", &geometry));
    shape_free(&s);
    free(colours);
    free(tangents);
    free(second);
    free(materials);
    return geometry;
}

static void add_instance(clast_scene *scene, uint32_t geometry, float x, float y, const float linear[9])
{
    uint32_t instance;
    const float map[12] = {linear[0], linear[1], linear[2], x,         linear[3], linear[4],
                           linear[5], y,         linear[6], linear[7], linear[8], 0};
    assert_ok(device.context, clast_scene_add_instance(scene, geometry, map, NULL, &instance));
}

static clast_scene *make_scene(void)
{
    clast_scene *scene;
    uint32_t geometry, camera;
    const float plain[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, mirrored[9] = {-1, 0.2f, 0, 0.1f, 0.7f, 0, 0, 0.3f, 1.2f},
                small[9] = {0.5f, 0, 0, 0, 0.3f, 0.1f, 0, -0.1f, 0.4f};
    assert_ok(device.context, clast_scene_create(device.context, &scene));
    uint32_t first = add_materials(scene);
    uint32_t rich = add_rich_sphere(scene, first);
    add_instance(scene, rich, 0, 0, plain);
    add_instance(scene, rich, 3, 0, mirrored);
    shape flat = shape_sphere(8, 4); // without normals or coordinates
    flat.mesh.normals = flat.mesh.coordinates[0] = NULL;
    flat.mesh.material = first + 1;
    assert_ok(device.context, clast_scene_add_mesh(scene, &flat.mesh, "flat", &geometry));
    shape_free(&flat);
    add_instance(scene, geometry, 0, 3, plain);
    clast_wave wave = {.size = 2, .tiles = 3, .amplitude = 0.2f, .wavelength = 0.7f, .speed = 1, .material = first};
    assert_ok(device.context, clast_scene_add_wave(scene, &wave, NULL, &geometry));
    const float tilted[9] = {1, 0, 0, 0, 0.5f, -0.8f, 0, 0.8f, 0.5f};
    add_instance(scene, geometry, 3, 3, tilted);
    clast_material_desc bumpy = clast_material_defaults();
    uint32_t material = add_material(scene, &bumpy);
    for (int curved = 0; curved < 2; curved++) {
        shape s = shape_sphere(12, 6);
        s.mesh.material = material;
        assert_ok(device.context, clast_scene_add_mesh(scene, &s.mesh, "bumpy", &geometry));
        shape_free(&s);
        shape_displace(device.context, scene, geometry, material, 0.15f);
        assert_ok(device.context,
                  clast_scene_set_tessellation(scene, geometry, &(clast_tessellation){.curved = curved != 0}));
        add_instance(scene, geometry, 6, 3.0f * (float)curved, plain);
        add_instance(scene, geometry, 6, 1.5f + 3.0f * (float)curved, small);
    }
    clast_camera_desc desc = {.position = {3, 2, 9}, .target = {3, 2, 0}};
    assert_ok(device.context, clast_scene_add_camera(scene, &desc, NULL, &camera));
    return scene;
}

// --------------------------------------------------------------------------------------------------------------- frame

static const clast_backend passes = {
    .name = "vulkan",
#define DEVICE_PASS(pass, function) .passes[pass] = function,
    CLAST_FRAME_VULKAN_PASSES(DEVICE_PASS)
#undef DEVICE_PASS
        .count = clast_vulkan_count_units,
    .coarse = clast_vulkan_trace_coarse,
    .forget = clast_vulkan_forget,
};

typedef struct built {
    clast_cooked *cooked;
    clast_frame *frame;
} built;

static built build(clast_scene *scene, bool on_device)
{
    built b;
    assert_ok(device.context, clast_cooked_create(device.context, &b.cooked));
    assert_ok(device.context, clast_cooked_update(b.cooked, scene));
    assert_ok(device.context, clast_frame_create(scene, b.cooked, &b.frame));
    b.frame->settings = (clast_frame_settings){
        .width = SIZE, .height = SIZE, .time = 0.3, .rate = 1.0, .segment = 2.0, .displacement_scale = 1.0};
    assert_ok(device.context, clast_scene_choose_camera(scene, "", SIZE, SIZE, &b.frame->settings.camera));
    b.frame->settings.rate_camera = b.frame->settings.camera;
    if (on_device) {
        assert_ok(device.context, clast_vulkan_frame_create(device.gpu, (clast_vulkan_frame **)&b.frame->device));
    }
    assert_ok(device.context, clast_frame_run(b.frame, on_device ? &passes : &clast_cpu_backend, CLAST_PASS_ANIMATE,
                                              CLAST_PASS_TLAS, NULL));
    return b;
}

static void destroy(built *b)
{
    if (b->frame->device != NULL) {
        clast_vulkan_frame_destroy(b->frame->device);
    }
    clast_frame_destroy(b->frame);
    clast_cooked_destroy(b->cooked);
}

// ----------------------------------------------------------------------------------------------------------- questions

// As shaders/probe/surface.comp has them.
typedef struct surface_question {
    clast_visibility seen;
    packed3 origin, direction;
    clast_ray_cone cone;
    uint32_t look;
} surface_question;

typedef struct surface_answer {
    packed3 position, geometric_normal, normal;
    float offset;
    clast_basis frame;
    clast_bsdf_input surface;
    packed3 absorption, emission;
    packed2 coordinates;
    clast_ray_cone cone;
    float bend;
    uint32_t unlit, material, frame_instance, primitive;
    uint32_t accepts, accepts_by_chance, hidden_back;
} surface_answer;

typedef struct questions {
    clast_ray rays[RAYS];
    clast_hit hits[RAYS];
    surface_question asked[RAYS];
    uint32_t count;
} questions;

// Rays from all around, some from within; those that hit.
static questions *make_questions(const clast_frame *frame)
{
    questions *q = calloc(1, sizeof *q);
    assert_non_null(q);
    for (uint32_t i = 0; i < RAYS; i++) {
        vec3 target = vec3(8.0f * draw() - 1.0f, 6.0f * draw() - 1.0f, draw() - 0.5f);
        vec3 origin = vec3(20.0f * draw() - 7.0f, 20.0f * draw() - 8.0f, i % 4 == 0 ? 0.0f : 16.0f * draw() - 8.0f);
        vec3 direction = normalize3(target - origin);
        clast_ray ray = {{origin[0], origin[1], origin[2]}, 0, {direction[0], direction[1], direction[2]}, INFINITY};
        clast_hit hit;
        clast_trace_closest(frame->tlas, &ray, 1, NULL, &hit);
        if (hit.instance != CLAST_NONE) {
            q->rays[q->count] = ray;
            q->hits[q->count] = hit;
            clast_ray_cone cone = {i % 2 == 0 ? 0.0f : 0.01f * draw(),
                                   i % 2 == 0 ? 0.0f : exp2f(-4.0f - 6.0f * draw())};
            q->asked[q->count++] = (surface_question){clast_visibility_of_hit(&hit), store3(origin), store3(direction),
                                                      cone, i % 3};
        }
    }
    return q;
}

static void ask(const clast_frame *frame, const clast_scene *scene, const questions *q, surface_answer *answers)
{
    clast_gpu_materials materials = {.gpu = device.gpu, .pictures = {.gpu = device.gpu}};
    clast_gpu_buffer asked, answered;
    uint64_t asked_bytes = q->count * sizeof q->asked[0], answered_bytes = q->count * sizeof *answers;
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, asked_bytes, "questions", &asked));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, answered_bytes, "answers", &answered));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, scene, CLAST_NONE));
    clast_gpu_write(commands, &asked, 0, q->asked, asked_bytes);
    clast_gpu_barrier(commands);
    struct {
        uint64_t frame, materials, questions, answers;
        uint32_t count;
    } push = {clast_vulkan_frame_address(frame->device), materials.head.address, asked.address, answered.address,
              q->count};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_PROBE_SURFACE,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = (q->count + 63) / 64});
    clast_gpu_read(commands, &answered, 0, answers, answered_bytes);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &asked);
    clast_gpu_free(device.gpu, &answered);
    clast_gpu_materials_free(&materials);
}

// ------------------------------------------------------------------------------------------------------------- answers

static surface_answer expect(const clast_frame *frame, const clast_srgb_table *table, const questions *q, uint32_t i)
{
    vec3 direction = load3(q->asked[i].direction);
    clast_finding_ray ray = {direction, q->asked[i].cone, q->asked[i].look};
    clast_found_surface found = clast_find_surface(frame, &q->asked[i].seen, &ray);
    clast_shade_surface(frame, table, direction * -1.0f, &found);
    const clast_shading_point *p = &found.point;
    const float *n = q->hits[i].normal;
    bool is_back = sees_back(vec3(n[0], n[1], n[2]), direction);
    return (surface_answer){
        .position = store3(p->position),
        .geometric_normal = store3(p->geometric_normal),
        .normal = store3(p->normal),
        .offset = p->offset,
        .frame = p->frame,
        .surface = p->surface,
        .absorption = store3(p->absorption),
        .emission = store3(p->emission),
        .coordinates = store2(p->coordinates),
        .cone = p->cone,
        .bend = p->bend,
        .unlit = p->unlit,
        .material = p->material,
        .frame_instance = p->frame_instance,
        .primitive = p->primitive,
        .accepts = clast_alpha_accepts((void *)frame, &q->rays[i], &q->hits[i]),
        .accepts_by_chance = clast_alpha_accepts_by_chance((void *)frame, &q->rays[i], &q->hits[i]),
        .hidden_back = is_back && found.material->double_sided == 0,
    };
}

static void assert_alike(const char *what, uint32_t i, const void *got, const void *wanted, size_t count,
                         double tolerance)
{
    const float *a = got, *b = wanted;
    for (size_t k = 0; k < count; k++) {
        if (!(fabs((double)a[k] - (double)b[k]) <= tolerance * fmax(1.0, fabs((double)b[k])))) {
            fail_msg("%s of hit %u: number %zu is %.9g, not %.9g", what, i, k, (double)a[k], (double)b[k]);
        }
    }
}

// `tolerance` is that of what textures say: where levels are blended, roots have told which.
static void assert_same_surface(uint32_t i, const surface_answer *got, surface_answer *wanted, double tolerance)
{
    assert_int_equal(got->material, wanted->material);
    assert_int_equal(got->frame_instance, wanted->frame_instance);
    assert_int_equal(got->primitive, wanted->primitive);
    assert_int_equal(got->unlit, wanted->unlit);
    assert_int_equal(got->surface.thin, wanted->surface.thin);
    assert_int_equal(got->surface.inside, wanted->surface.inside);
    assert_alike("position", i, &got->position, &wanted->position, 3, 1e-6);
    assert_true(fabs((double)got->offset / (double)wanted->offset - 1.0) < 1e-3);
    assert_alike("geometric normal", i, &got->geometric_normal, &wanted->geometric_normal, 3, 1e-6);
    assert_alike("coordinates", i, &got->coordinates, &wanted->coordinates, 2, 1e-6);
    assert_alike("cone", i, &got->cone, &wanted->cone, 2, 1e-5);
    assert_alike("bend", i, &got->bend, &wanted->bend, 1, 1e-5);
    assert_alike("emission", i, &got->emission, &wanted->emission, 3, tolerance);
    assert_alike("absorption", i, &got->absorption, &wanted->absorption, 3, 1e-6);
    assert_alike("normal", i, &got->normal, &wanted->normal, 3, 2e-4 + tolerance);
    assert_alike("base", i, &got->surface.base, &wanted->surface.base, sizeof got->surface.base / 4, tolerance);
    assert_alike("clearcoat", i, &got->surface.clearcoat, &wanted->surface.clearcoat, 2, tolerance);
    assert_alike("sheen", i, &got->surface.sheen, &wanted->surface.sheen, 4, tolerance);
    assert_alike("transmission", i, &got->surface.transmission, &wanted->surface.transmission, 2, tolerance);
    assert_alike("diffuse transmission", i, &got->surface.through, &wanted->surface.through, 4, tolerance);
}

static void surfaces_and_decisions_are_those_of_the_processor(void **state)
{
    (void)state;
    clast_scene *scene = make_scene();
    assert_ok(device.context, clast_make_levels(scene));
    built here = build(scene, false), there = build(scene, true);
    questions *q = make_questions(here.frame);
    surface_answer *answers = calloc(RAYS, sizeof *answers);
    assert_non_null(answers);
    ask(there.frame, scene, q, answers);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    uint32_t kinds[3] = {0}, refused = 0, hidden = 0, otherwise = 0;
    for (uint32_t i = 0; i < q->count; i++) {
        surface_answer wanted = expect(here.frame, &table, q, i);
        assert_same_surface(i, &answers[i], &wanted, q->asked[i].cone.spread > 0.0f ? 1e-3 : 1e-5);
        otherwise += answers[i].accepts != wanted.accepts || answers[i].accepts_by_chance != wanted.accepts_by_chance;
        assert_int_equal(answers[i].hidden_back, wanted.hidden_back);
        kinds[here.frame->units[here.frame->instances[wanted.frame_instance].unit].unit->kind]++;
        refused += wanted.accepts == 0;
        hidden += wanted.hidden_back;
    }
    print_message("%u hits: %u of meshes, %u of sheets, %u displaced; %u refused, %u hidden backs\n", q->count,
                  kinds[0], kinds[1], kinds[2], refused, hidden);
    assert_int_equal(otherwise, 0);
    assert_true(kinds[0] > 500 && kinds[1] > 100 && kinds[2] > 300 && refused > 50 && hidden > 10);
    free(answers);
    free(q);
    destroy(&here);
    destroy(&there);
    clast_scene_destroy(scene);
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_and_decisions_are_those_of_the_processor),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
