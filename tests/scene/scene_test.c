// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <string.h>

#include "scene/scene.h"

static const float quad_positions[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0};
static const float quad_coordinates[] = {0, 1, 1, 1, 1, 0, 0, 0}; // v grows downwards
static const uint32_t quad_indices[] = {0, 1, 2, 0, 2, 3};

static clast_mesh quad(void)
{
    return (clast_mesh){
        .vertex_count = 4,
        .triangle_count = 2,
        .positions = quad_positions,
        .coordinates = {quad_coordinates},
        .indices = quad_indices,
        .material = CLAST_NONE,
    };
}

static clast_scene *new_scene(clast_context *context)
{
    clast_scene *scene;
    assert_ok(context, clast_scene_create(context, &scene));
    return scene;
}

static void a_new_scene_has_the_plain_material_only(void **state)
{
    clast_scene *scene = new_scene(*state);
    clast_scene_counts counts;
    clast_scene_count(scene, &counts);
    assert_int_equal(counts.materials, 1);
    assert_int_equal(counts.geometries + counts.instances + counts.lights + counts.cameras + counts.images, 0);
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    assert_true(lower[0] > upper[0]);
    clast_scene_destroy(scene);
}

static void a_mesh_is_copied(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    float positions[12];
    memcpy(positions, quad_positions, sizeof positions);
    clast_mesh mesh = quad();
    mesh.positions = positions;
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, "quad", &geometry));
    memset(positions, 0, sizeof positions);
    assert_float_equal(scene->geometries[geometry].of.mesh.positions[3], 2.0f, 0.0f);
    assert_int_equal(scene->geometries[geometry].of.mesh.material, 0);
    clast_scene_destroy(scene);
}

static void a_mesh_with_a_wrong_index_is_refused_with_its_triangle(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    uint32_t indices[] = {0, 1, 2, 0, 2, 4};
    clast_mesh mesh = quad();
    mesh.indices = indices;
    uint32_t geometry;
    assert_int_equal(clast_scene_add_mesh(scene, &mesh, "bad", &geometry), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "bad: triangle 1"));
    clast_scene_destroy(scene);
}

static void a_position_that_is_not_finite_is_refused(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 3; i++) {
        float positions[12];
        memcpy(positions, quad_positions, sizeof positions);
        positions[7] = bad[i];
        clast_mesh mesh = quad();
        mesh.positions = positions;
        uint32_t geometry;
        assert_int_equal(clast_scene_add_mesh(scene, &mesh, NULL, &geometry), CLAST_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(clast_context_error(context), "vertex 2"));
    }
    clast_scene_destroy(scene);
}

static void adopted_blocks_are_freed_on_failure_too(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    uint32_t *indices = clast_allocate_zeroed(context, 6, sizeof *indices);
    indices[3] = 9;
    clast_mesh mesh = quad();
    mesh.indices = indices;
    void *blocks[] = {indices};
    uint32_t geometry;
    assert_int_equal(clast_scene_adopt_mesh(scene, &mesh, blocks, 1, NULL, &geometry), CLAST_ERROR_INVALID_ARGUMENT);
    clast_scene_destroy(scene); // the teardown finds what is left over
}

static void new_positions_replace_the_old_any_number_of_times(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    clast_mesh mesh = quad();
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, NULL, &geometry));
    float positions[12], normals[12];
    for (int round = 1; round <= 30; round++) {
        for (int i = 0; i < 12; i++) {
            positions[i] = quad_positions[i] * (float)round;
            normals[i] = i % 3 == 2 ? 1.0f : 0.0f;
        }
        assert_ok(context, clast_scene_set_mesh_positions(scene, geometry, positions, round % 2 ? normals : NULL));
        assert_float_equal(scene->geometries[geometry].of.mesh.positions[3], 2.0f * (float)round, 0.0f);
        assert_int_equal(scene->geometries[geometry].of.mesh.normals != NULL, round % 2);
        assert_int_equal(scene->geometries[geometry].version, round + 1);
    }
    clast_scene_destroy(scene);
}

static void materials_outside_their_ranges_are_refused(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    clast_material_desc desc = clast_material_defaults();
    uint32_t number;
    desc.roughness = NAN;
    assert_int_equal(clast_scene_add_material(scene, &desc, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    desc = clast_material_defaults();
    desc.base_colour[3] = 1.5f;
    assert_int_equal(clast_scene_add_material(scene, &desc, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    desc = clast_material_defaults();
    desc.normal_texture.texture = 0; // there is none
    assert_int_equal(clast_scene_add_material(scene, &desc, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    desc = clast_material_defaults();
    assert_ok(context, clast_scene_add_material(scene, &desc, "fine", &number));
    assert_int_equal(number, 1);
    assert_int_equal(clast_scene_set_material(scene, 2, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    clast_scene_destroy(scene);
}

static void instances_move_bounds_and_their_numbers_stay(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    clast_mesh mesh = quad();
    uint32_t geometry, first, second, third;
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, NULL, &geometry));
    const float mirrored[12] = {-1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 5};
    assert_ok(context, clast_scene_add_instance(scene, geometry, NULL, "a", &first));
    assert_ok(context, clast_scene_add_instance(scene, geometry, mirrored, "b", &second));
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    assert_float_equal(lower[0], 0.0f, 0.0f);
    assert_float_equal(upper[0], 10.0f, 0.0f);
    assert_float_equal(upper[2], 5.0f, 0.0f);
    assert_ok(context, clast_scene_remove_instance(scene, first));
    clast_scene_bounds(scene, lower, upper);
    assert_float_equal(lower[0], 8.0f, 0.0f);
    assert_ok(context, clast_scene_add_instance(scene, geometry, NULL, "c", &third));
    assert_int_not_equal(third, first);
    assert_int_equal(clast_scene_set_instance_visible(scene, first, true), CLAST_ERROR_INVALID_ARGUMENT);
    clast_scene_destroy(scene);
}

static void copies_stand_side_by_side(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    clast_mesh mesh = quad();
    uint32_t geometry, instance;
    assert_ok(context, clast_scene_add_mesh(scene, &mesh, NULL, &geometry));
    assert_ok(context, clast_scene_add_instance(scene, geometry, NULL, NULL, &instance));
    assert_ok(context, clast_scene_repeat(scene, 5));
    clast_scene_counts counts;
    clast_scene_count(scene, &counts);
    assert_int_equal(counts.instances, 5);
    assert_int_equal(counts.triangles, 2);
    assert_int_equal(counts.instanced_triangles, 10);
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    assert_true(upper[0] - lower[0] > 6.0f); // three in a row
    clast_scene_destroy(scene);
}

static void tangents_follow_u_and_their_bitangent_points_up_in_the_image(void **state)
{
    clast_context *context = *state;
    clast_mesh mesh = quad();
    float *normals = clast_mesh_normals(context, &mesh);
    assert_non_null(normals);
    for (int i = 0; i < 4; i++) {
        assert_float_equal(normals[3 * i + 2], 1.0f, 1e-6f);
    }
    mesh.normals = normals;
    float *tangents = clast_mesh_tangents(context, &mesh);
    assert_non_null(tangents);
    for (int i = 0; i < 4; i++) {
        assert_float_equal(tangents[4 * i], 1.0f, 1e-6f);
        assert_float_equal(tangents[4 * i + 3], 1.0f, 0.0f); // cross((0,0,1), (1,0,0)) is +y: up in the image
    }
    clast_free(context, tangents);
    clast_free(context, normals);
}

static void normals_of_tiny_meshes_are_unit_vectors(void **state)
{
    clast_context *context = *state;
    float positions[12];
    for (int i = 0; i < 12; i++) {
        positions[i] = quad_positions[i] * 1e-15f;
    }
    clast_mesh mesh = quad();
    mesh.positions = positions;
    float *normals = clast_mesh_normals(context, &mesh);
    assert_non_null(normals);
    assert_float_equal(normals[2], 1.0f, 1e-5f);
    clast_free(context, normals);
}

static void lights_and_environments_are_checked(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    uint32_t number;
    clast_light_desc light = {.type = CLAST_LIGHT_DIRECTIONAL, .colour = {1, 1, 1}, .intensity = 3};
    assert_int_equal(clast_scene_add_light(scene, &light, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT); // no direction
    light.direction[1] = -2.0f;
    assert_ok(context, clast_scene_add_light(scene, &light, "sun", &number));
    clast_light_desc bright = light;
    bright.intensity = bright.colour[1] = 1e30f; // their product is not finite
    assert_int_equal(clast_scene_add_light(scene, &bright, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    assert_float_equal(scene->lights[number].record.direction.v[1], -1.0f, 1e-6f);
    light = (clast_light_desc){.type = CLAST_LIGHT_SPOT,
                               .direction = {1, 0, 0},
                               .colour = {1, 1, 1},
                               .intensity = 1,
                               .inner_angle = 1,
                               .outer_angle = 0.5f};
    assert_int_equal(clast_scene_add_light(scene, &light, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY};
    assert_int_equal(clast_scene_set_environment(scene, &sky), CLAST_ERROR_INVALID_ARGUMENT); // no sun
    sky.sun_direction[1] = 4.0f;
    assert_ok(context, clast_scene_set_environment(scene, &sky));
    assert_float_equal(scene->environment.sun_direction[1], 1.0f, 1e-6f);
    assert_float_equal(scene->environment.colour[2], 1.0f, 0.0f);
    clast_environment image = {.type = CLAST_ENVIRONMENT_IMAGE, .image = 3};
    assert_int_equal(clast_scene_set_environment(scene, &image), CLAST_ERROR_INVALID_ARGUMENT);
    clast_scene_destroy(scene);
}

static void a_camera_is_chosen_by_name_number_or_text(void **state)
{
    clast_context *context = *state;
    clast_scene *scene = new_scene(context);
    uint32_t number;
    clast_camera_desc desc = {.position = {0, 0, 5}, .vertical_angle = 1.0f};
    assert_ok(context, clast_scene_add_camera(scene, &desc, "front", &number));
    desc.position[0] = 7.0f;
    assert_ok(context, clast_scene_add_camera(scene, &desc, "side", &number));
    clast_camera camera;
    assert_ok(context, clast_scene_choose_camera(scene, "", 200, 100, &camera));
    assert_float_equal(camera.position.v[0], 0.0f, 0.0f);
    assert_float_equal(camera.aspect, 2.0f, 0.0f);
    assert_float_equal(camera.forward.v[2], -1.0f, 1e-6f);
    assert_float_equal(camera.right.v[0], 1.0f, 1e-6f);
    assert_ok(context, clast_scene_choose_camera(scene, "side", 1, 1, &camera));
    assert_float_equal(camera.position.v[0], 7.0f, 0.0f);
    assert_ok(context, clast_scene_choose_camera(scene, "1", 1, 1, &camera));
    assert_float_equal(camera.position.v[0], 7.0f, 0.0f);
    assert_ok(context, clast_scene_choose_camera(scene, "1,2,3/0,0,0/0,0,1/90", 1, 1, &camera));
    assert_float_equal(camera.position.v[2], 3.0f, 0.0f);
    assert_float_equal(camera.vertical_extent, 1.0f, 1e-5f);
    const char *wrong[] = {
        "2", "back",         "1,2,3", "1,2,3/1,2,3", "1,2/0,0,0", "1,2,3/0,0,0/0,1,0/180", "1,2,3/0,0,0/0,1,0/45/6",
        "/", "nan,0,0/1,1,1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(clast_scene_choose_camera(scene, wrong[i], 1, 1, &camera), CLAST_ERROR_INVALID_ARGUMENT);
    }
    clast_scene_destroy(scene);
}

static void the_default_camera_sees_the_scene_at_any_scale(void **state)
{
    clast_context *context = *state;
    const float scales[] = {1e-12f, 1e-3f, 1.0f, 1e6f};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        clast_scene *scene = new_scene(context);
        clast_mesh mesh = quad();
        uint32_t geometry, instance;
        float s = scales[i];
        const float transform[12] = {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0};
        assert_ok(context, clast_scene_add_mesh(scene, &mesh, NULL, &geometry));
        assert_ok(context, clast_scene_add_instance(scene, geometry, transform, NULL, &instance));
        clast_camera camera;
        assert_ok(context, clast_scene_choose_camera(scene, NULL, 160, 90, &camera));
        vec3 to_centre = vec3(s, s, 0.0f) - load3(camera.position);
        assert_float_equal(length3(load3(camera.forward)), 1.0f, 1e-4f);
        assert_true(dot3(load3(camera.forward), to_centre) > s);
        clast_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_new_scene_has_the_plain_material_only),
        CONTEXT_TEST(a_mesh_is_copied),
        CONTEXT_TEST(a_mesh_with_a_wrong_index_is_refused_with_its_triangle),
        CONTEXT_TEST(a_position_that_is_not_finite_is_refused),
        CONTEXT_TEST(adopted_blocks_are_freed_on_failure_too),
        CONTEXT_TEST(new_positions_replace_the_old_any_number_of_times),
        CONTEXT_TEST(materials_outside_their_ranges_are_refused),
        CONTEXT_TEST(instances_move_bounds_and_their_numbers_stay),
        CONTEXT_TEST(copies_stand_side_by_side),
        CONTEXT_TEST(tangents_follow_u_and_their_bitangent_points_up_in_the_image),
        CONTEXT_TEST(normals_of_tiny_meshes_are_unit_vectors),
        CONTEXT_TEST(lights_and_environments_are_checked),
        CONTEXT_TEST(a_camera_is_chosen_by_name_number_or_text),
        CONTEXT_TEST(the_default_camera_sees_the_scene_at_any_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
