// SPDX-License-Identifier: Apache-2.0
// What is exported: the triangles of a frame, closed where they were, read back the same.
#include <string.h>
#include <unistd.h>

#include "closed.h"
#include "test.h"

#include "clast/export.h"
#include "clast/geometry.h"
#include "scene/scene.h"

// A cube with hard edges, and seams of its texture coordinates along all of them: four corners for each face.
static clast_scene *make_cube(clast_context *context, bool displaced)
{
    static const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
    float positions[24][3], normals[24][3], coordinates[24][2];
    uint32_t indices[36];
    for (uint32_t face = 0; face < 6; face++) {
        uint32_t axis = face / 2;
        float side = face % 2 != 0 ? 1.0f : -1.0f;
        for (uint32_t corner = 0; corner < 4; corner++) {
            float a = corner == 1 || corner == 2 ? 1.0f : -1.0f, b = corner >= 2 ? 1.0f : -1.0f;
            float *p = positions[4 * face + corner], *n = normals[4 * face + corner];
            p[axis] = side;
            p[(axis + 1) % 3] = side * a;
            p[(axis + 2) % 3] = b;
            n[0] = n[1] = n[2] = 0.0f;
            n[axis] = side;
            coordinates[4 * face + corner][0] = 0.5f * a + 0.5f;
            coordinates[4 * face + corner][1] = 0.5f * b + 0.5f;
        }
        for (uint32_t i = 0; i < 6; i++) {
            indices[6 * face + i] = 4 * face + quad[i];
        }
    }
    clast_scene *scene;
    assert_ok(context, clast_scene_create(context, &scene));
    static uint16_t heights[16][16];
    for (uint32_t y = 0; y < 16; y++) {
        for (uint32_t x = 0; x < 16; x++) {
            heights[y][x] = (uint16_t)((x * 2654435761u ^ y * 40503u * 65537u) >> 16);
        }
    }
    clast_image image = {16, 16, 1, CLAST_PIXEL_UNORM16, heights};
    clast_texture texture = {0};
    clast_material_desc material = clast_material_defaults();
    material.double_sided = false;
    material.emissive[1] = 3.0f;
    material.base_colour[2] = 0.25f;
    uint32_t number, geometry, instance;
    assert_ok(context, clast_scene_add_image(scene, &image, "heights", &texture.image));
    assert_ok(context, clast_scene_add_texture(scene, &texture, &material.displacement_texture.texture));
    material.base_colour_texture.texture = material.displacement_texture.texture;
    material.base_colour_texture.scale[0] = 2.0f;
    material.displacement_scale = 0.25f;
    assert_ok(context, clast_scene_add_material(scene, &material, "stone", &number));
    clast_mesh mesh = {.vertex_count = 24,
                       .triangle_count = 12,
                       .positions = positions[0],
                       .normals = normals[0],
                       .coordinates = {coordinates[0]},
                       .indices = indices,
                       .material = number};
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, "cube", &geometry));
    if (displaced) {
        assert_ok(context, clast_scene_set_tessellation(scene, geometry, &(clast_tessellation){0}));
    }
    assert_ok(context, clast_scene_add_instance(scene, geometry, NULL, "first", &instance));
    float mirrored[12] = {-2, 0, 0, 7, 0, 2, 0, 0, 0, 0, 2, 0};
    assert_ok(context, clast_scene_add_instance(scene, geometry, mirrored, "second", &instance));
    return scene;
}

static clast_render_settings settings_of(double segments)
{
    return (clast_render_settings){.metric = CLAST_METRIC_FIXED, .segment = segments, .width = 64, .height = 64};
}

static clast_scene *exported(clast_context *context, const clast_scene *from, const clast_export_desc *desc,
                             double segments, const char *name, clast_export_statistics *statistics)
{
    clast_renderer *renderer;
    clast_scene *scene;
    clast_render_settings settings = settings_of(segments);
    assert_ok(context, clast_renderer_create((clast_scene *)from, &renderer));
    assert_ok(context, clast_export(renderer, &settings, desc, name, statistics));
    clast_renderer_destroy(renderer);
    assert_ok(context, clast_scene_load(context, name, &scene));
    return scene;
}

static double volume(const clast_mesh *mesh)
{
    double sum = 0.0;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const float *a = mesh->positions + 3 * (size_t)mesh->indices[3 * i];
        const float *b = mesh->positions + 3 * (size_t)mesh->indices[3 * i + 1];
        const float *c = mesh->positions + 3 * (size_t)mesh->indices[3 * i + 2];
        for (int k = 0; k < 3; k++) {
            int l = (k + 1) % 3, m = (k + 2) % 3;
            sum += (double)a[k] * ((double)b[l] * (double)c[m] - (double)b[m] * (double)c[l]) / 6.0;
        }
    }
    return sum;
}

static void a_displaced_cube_stays_closed_as_gltf(void **state)
{
    clast_context *context = *state;
    static const char *const names[] = {"export_test.gltf", "export_test.glb"};
    for (int i = 0; i < 2; i++) {
        clast_scene *scene = make_cube(context, true);
        clast_export_statistics statistics;
        clast_scene *read = exported(context, scene, NULL, 6.0, names[i], &statistics);
        assert_int_equal(statistics.meshes, 1);
        assert_int_equal(statistics.instances, 2);
        assert_int_equal(statistics.triangles, 12 * 36);
        assert_int_equal(statistics.instanced_triangles, 2 * 12 * 36);
        assert_int_equal(read->geometry_count, 1);
        assert_int_equal(read->instance_count, 2);
        assert_false(read->geometries[0].tessellated);
        const clast_mesh *mesh = &read->geometries[0].of.mesh;
        assert_int_equal(mesh->triangle_count, statistics.triangles);
        assert_int_equal(mesh->vertex_count, statistics.vertices);
        assert_non_null(mesh->normals);
        assert_non_null(mesh->coordinates[0]);
        assert_closed(context, mesh, false);
        assert_true(volume(mesh) > 8.0 && volume(mesh) < 12.0);
        assert_memory_equal(read->instances[1].to_world.rows, scene->instances[1].to_world.rows, 48);
        assert_string_equal(read->instances[1].name, "second");
        const clast_material *material = &read->materials[mesh->material].record;
        const clast_material *before = &scene->materials[scene->geometries[0].of.mesh.material].record;
        assert_memory_equal(material->base_colour.v, before->base_colour.v, 16);
        assert_float_equal(material->emissive.v[1], 3.0f, 1e-6);
        assert_int_equal(material->double_sided, 0);
        assert_float_equal(material->base_colour_texture.scale.v[0], 2.0f, 0.0);
        assert_int_equal(material->displacement_texture.texture, CLAST_NONE);
        assert_int_equal(read->image_count, 1);
        assert_memory_equal(read->images[0].image.pixels, scene->images[0].image.pixels, 512);
        clast_scene_destroy(read);
        clast_scene_destroy(scene);
        unlink(names[i]);
    }
    unlink("export_test.bin");
    unlink("export_test.0.png");
}

static void a_welded_cube_is_closed_by_its_indices(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = make_cube(context, true);
    uint32_t first = 0;
    clast_export_desc desc = {.instances = &first, .instance_count = 1, .welded = true};
    clast_scene *read = exported(context, scene, &desc, 7.0, "export_test.ply", NULL);
    const clast_mesh *mesh = &read->geometries[0].of.mesh;
    assert_int_equal(mesh->triangle_count, 12 * 49);
    assert_int_equal(mesh->vertex_count, mesh->triangle_count / 2 + 2); // Euler
    assert_null(mesh->coordinates[0]);
    assert_closed(context, mesh, true);
    clast_scene_destroy(read);
    clast_scene_destroy(scene);
    unlink("export_test.ply");
}

static void ply_has_all_instances_in_the_world(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = make_cube(context, false); // the plain mesh, at that
    clast_scene *read = exported(context, scene, NULL, 3.0, "export_test.ply", NULL);
    const clast_mesh *mesh = &read->geometries[0].of.mesh;
    assert_int_equal(mesh->triangle_count, 24);
    assert_int_equal(mesh->vertex_count, 48); // hard edges part vertices
    assert_non_null(mesh->coordinates[0]);
    assert_closed(context, mesh, false);
    assert_true(fabs((double)volume(mesh) - 72.0) <= 1e-3); // the mirrored one is not inside out
    float lower[3], upper[3];
    clast_scene_bounds(read, lower, upper);
    assert_float_equal(lower[0], -1.0f, 1e-5);
    assert_float_equal(upper[0], 9.0f, 1e-5);
    clast_scene_destroy(read);
    clast_scene_destroy(scene);
    unlink("export_test.ply");
}

static void positions_are_those_that_rays_meet(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = make_cube(context, true);
    clast_renderer *renderer;
    clast_render_settings settings = settings_of(5.0);
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_ok(context, clast_export(renderer, &settings, NULL, "export_test.glb", NULL));
    clast_scene *read;
    assert_ok(context, clast_scene_load(context, "export_test.glb", &read));
    clast_renderer *again;
    assert_ok(context, clast_renderer_create(read, &again));
    assert_ok(context, clast_renderer_commit(again, &settings));
    for (int i = 0; i < 500; i++) {
        float x = 0.9f * (float)((i * 37) % 101 - 50) / 50.0f, y = 0.9f * (float)((i * 61) % 97 - 48) / 48.0f;
        clast_ray ray = {.origin = {x, y, 5.0f}, .direction = {0.03f, 0.01f, -1.0f}, .t_max = 100.0f};
        clast_hit a, b;
        assert_ok(context, clast_renderer_trace_closest(renderer, &ray, 1, &a));
        assert_ok(context, clast_renderer_trace_closest(again, &ray, 1, &b));
        assert_float_equal(a.t, b.t, 1e-5);
    }
    clast_renderer_destroy(again);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(read);
    clast_scene_destroy(scene);
    unlink("export_test.glb");
}

static void what_cannot_be_exported_is_refused(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = make_cube(context, true);
    clast_renderer *renderer;
    uint32_t none = 7;
    assert_ok(context, clast_renderer_create(scene, &renderer));
    assert_int_equal(clast_export(renderer, NULL, NULL, "export_test.obj", NULL), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(clast_export(renderer, NULL, &(clast_export_desc){.instances = &none, .instance_count = 1},
                                  "export_test.ply", NULL),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_export(renderer, NULL, NULL, "no such folder/a.ply", NULL), CLAST_ERROR_FILE_WRITE);
    assert_int_equal(clast_export(NULL, NULL, NULL, "export_test.ply", NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(access("export_test.ply", F_OK), -1);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_displaced_cube_stays_closed_as_gltf), CONTEXT_TEST(a_welded_cube_is_closed_by_its_indices),
        CONTEXT_TEST(ply_has_all_instances_in_the_world),    CONTEXT_TEST(positions_are_those_that_rays_meet),
        CONTEXT_TEST(what_cannot_be_exported_is_refused),
    };
    return cmocka_run_group_tests_name("export", tests, NULL, NULL);
}
