// SPDX-License-Identifier: Apache-2.0
#include "source/kinds.h"

#include <string.h>

static clast_unit *cook_mesh(clast_context *context, kind_world *world, const clast_mesh *mesh)
{
    assert_ok(context, clast_scene_create(context, &world->scene));
    assert_ok(context, clast_template_set_create(context, &world->templates));
    uint32_t geometry = CLAST_NONE;
    assert_ok(context, clast_scene_add_mesh(world->scene, mesh, "mesh", &geometry));
    world->context = context;
    world->source = clast_sources[CLAST_SOURCE_CLUSTERS];
    kind_cook(world, geometry);
    return world->unit;
}

static kind_world open_mesh(clast_context *context, const clast_mesh *mesh)
{
    kind_world world = {0};
    cook_mesh(context, &world, mesh);
    return world;
}

static void every_triangle_of_the_mesh_is_there_once(void **state)
{
    kind_world world = kind_open(*state, CLAST_SOURCE_CLUSTERS);
    kind_emission all = kind_emit(&world, &kind_poses[0], &kind_views[0]);
    uint32_t triangles = world.unit->geometry->of.mesh.triangle_count;
    uint8_t *seen = calloc(triangles, 1);
    for (size_t i = 0; i < all.record_count; i++) {
        for (uint32_t t = 0; t < clast_template_triangle_count(world.templates, all.records[i].template_index); t++) {
            clast_surface_point point = world.source->locate(world.unit, &kind_poses[0], &all.records[i], NULL, t,
                                                             vec2(0.0f, 0.0f));
            assert_true(point.primitive < triangles);
            assert_int_equal(seen[point.primitive]++, 0);
        }
    }
    for (uint32_t i = 0; i < triangles; i++) {
        assert_int_equal(seen[i], 1);
    }
    free(seen);
    kind_emission_free(&all);
    kind_close(&world);
}

static void cooked_data_is_small(void **state)
{
    shape s = shape_sphere(200, 200);
    kind_world world = open_mesh(*state, &s.mesh);
    double each = (double)(world.unit->bytes + clast_template_set_bytes(world.templates)) / s.mesh.triangle_count;
    assert_true(each < 45.0);
    shape_free(&s);
    kind_close(&world);
}

static const float triangle_positions[] = {0, 0, 0, 2, 0, 0, 0, 2, 0};
static const uint32_t triangle_indices[] = {0, 1, 2};

static clast_mesh one_triangle(void)
{
    return (clast_mesh){
        .vertex_count = 3,
        .triangle_count = 1,
        .positions = triangle_positions,
        .indices = triangle_indices,
        .material = CLAST_NONE,
    };
}

static clast_source_surface evaluate_middle(kind_world *world)
{
    clast_surface_point point = {.coordinates = {{0.25f, 0.5f}}};
    return world->source->evaluate(world->unit, &kind_poses[0], point);
}

static void attributes_are_interpolated(void **state)
{
    clast_mesh mesh = one_triangle();
    const float normals[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const float tangents[] = {0, 0, 2, -1, 0, 2, 0, -1, 2, 0, 0, -1};
    const float first[] = {0, 0, 4, 0, 0, 4}, second[] = {1, 1, 1, 1, 3, 5};
    const float colours[] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 0};
    mesh.normals = normals;
    mesh.tangents = tangents;
    mesh.coordinates[0] = first;
    mesh.coordinates[1] = second;
    mesh.colours = colours;
    kind_world world = open_mesh(*state, &mesh);
    clast_source_surface s = evaluate_middle(&world);
    assert_true(length3(s.position - vec3(0.5f, 1.0f, 0.0f)) < 1e-6f);
    assert_true(length3(s.normal - vec3(0.25f, 0.25f, 0.5f)) < 1e-6f);
    assert_true(length3(s.tangent - vec3(1.0f, 0.5f, 0.5f)) < 1e-6f);
    assert_true(s.bitangent_sign == -1.0f);
    assert_true(abs1(s.coordinates[0][0] - 1.0f) < 1e-6f && abs1(s.coordinates[0][1] - 2.0f) < 1e-6f);
    assert_true(abs1(s.coordinates[1][0] - 2.0f) < 1e-6f && abs1(s.coordinates[1][1] - 3.0f) < 1e-6f);
    assert_true(abs1(s.colour[0] - 0.25f) < 1e-6f && abs1(s.colour[3] - 0.5f) < 1e-6f);
    vec3 edge = vec3(triangle_positions[3] - triangle_positions[0], triangle_positions[4] - triangle_positions[1],
                     triangle_positions[5] - triangle_positions[2]);
    for (uint32_t set = 0; set < 2; set++) { // along an edge, coordinates grow by their difference
        assert_true(abs1(dot3(load3(s.gradients[set].u), edge) -
                         (mesh.coordinates[set][2] - mesh.coordinates[set][0])) < 1e-5f);
        assert_true(abs1(dot3(load3(s.gradients[set].v), edge) -
                         (mesh.coordinates[set][3] - mesh.coordinates[set][1])) < 1e-5f);
        assert_true(abs1(dot3(load3(s.gradients[set].u), s.geometric_normal)) < 1e-5f);
    }
    assert_true(normalize3(s.geometric_normal)[2] > 0.999f);
    kind_close(&world);
}

static void attributes_that_are_not_there_have_their_defaults(void **state)
{
    clast_mesh mesh = one_triangle();
    kind_world world = open_mesh(*state, &mesh);
    clast_source_surface s = evaluate_middle(&world);
    assert_true(normalize3(s.normal)[2] > 0.999f);
    assert_true(length3(s.tangent) == 0.0f && length3(load3(s.gradients[0].u)) == 0.0f);
    assert_true(s.colour[0] == 1.0f && s.colour[3] == 1.0f);
    assert_int_equal(s.material, 0);
    kind_close(&world);
}

static void the_tangent_follows_the_texture_where_the_mesh_has_none(void **state)
{
    clast_mesh mesh = one_triangle();
    const float upright[] = {0, 1, 1, 1, 0, 0}; // the second coordinate grows downwards, as images do
    mesh.coordinates[0] = upright;
    kind_world world = open_mesh(*state, &mesh);
    clast_source_surface s = evaluate_middle(&world);
    assert_true(normalize3(s.tangent)[0] > 0.999f);
    assert_true(s.bitangent_sign == 1.0f);
    kind_close(&world);
    const float mirrored[] = {0, 0, 1, 0, 0, 1};
    mesh.coordinates[0] = mirrored;
    world = open_mesh(*state, &mesh);
    s = evaluate_middle(&world);
    assert_true(normalize3(s.tangent)[0] > 0.999f);
    assert_true(s.bitangent_sign == -1.0f);
    kind_close(&world);
}

static void normals_that_cancel_give_way_to_the_geometric_one(void **state)
{
    clast_mesh mesh = one_triangle();
    const float normals[] = {0, 0, 0, 1, 0, 0, -0.5f, 0, 0};
    mesh.normals = normals;
    kind_world world = open_mesh(*state, &mesh);
    assert_true(normalize3(evaluate_middle(&world).normal)[2] > 0.999f);
    kind_close(&world);
    const float wild[] = {NAN, 0, 0, 0, 1, 0, 0, INFINITY, 0};
    mesh.normals = wild;
    world = open_mesh(*state, &mesh);
    assert_true(normalize3(evaluate_middle(&world).normal)[2] > 0.999f);
    kind_close(&world);
}

static void tiny_and_huge_triangles_have_a_normal(void **state)
{
    const float sizes[] = {1e-30f, 1e-15f, 1e15f, 1e30f};
    for (uint32_t i = 0; i < 4; i++) {
        float positions[9];
        for (uint32_t k = 0; k < 9; k++) {
            positions[k] = triangle_positions[k] * sizes[i];
        }
        clast_mesh mesh = one_triangle();
        const float coordinates[] = {0, 0, 1, 0, 0, 1};
        mesh.positions = positions;
        mesh.coordinates[0] = coordinates;
        kind_world world = open_mesh(*state, &mesh);
        clast_source_surface s = evaluate_middle(&world);
        assert_true(normalize3(s.geometric_normal)[2] > 0.999f);
        assert_true(is_finite3(load3(s.gradients[0].u)) && is_finite3(load3(s.gradients[0].v)) &&
                    is_finite3(s.tangent));
        kind_close(&world);
    }
}

static void degenerate_triangles_give_no_wild_values(void **state)
{
    const float positions[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    const float coordinates[6] = {0};
    clast_mesh mesh = one_triangle();
    mesh.positions = positions;
    mesh.coordinates[0] = coordinates;
    kind_world world = open_mesh(*state, &mesh);
    clast_source_surface s = evaluate_middle(&world);
    assert_true(is_finite3(s.position) && is_finite3(s.normal) && is_finite3(s.geometric_normal) &&
                is_finite3(s.tangent));
    assert_true(length3(load3(s.gradients[0].u)) == 0.0f && s.curvature == 0.0f);
    kind_close(&world);
}

static void a_mesh_without_triangles_cooks_to_nothing(void **state)
{
    clast_mesh mesh = {.vertex_count = 3, .positions = triangle_positions, .material = CLAST_NONE};
    kind_world world = open_mesh(*state, &mesh);
    assert_int_equal(world.unit->item_count, 0);
    clast_box box = world.source->bounds(world.unit, &kind_poses[0]);
    assert_true(box.lower.v[0] > box.upper.v[0]);
    assert_int_equal(world.source->primitive_count(world.unit), 0);
    kind_close(&world);
}

static void materials_are_listed_once_each(void **state)
{
    clast_context *context = *state;
    enum { MATERIALS = 300 };
    clast_scene *scene;
    clast_template_set *templates;
    assert_ok(context, clast_scene_create(context, &scene));
    assert_ok(context, clast_template_set_create(context, &templates));
    clast_material_desc material = clast_material_defaults();
    uint32_t number = 0;
    for (uint32_t i = 1; i < MATERIALS; i++) {
        assert_ok(context, clast_scene_add_material(scene, &material, NULL, &number));
    }
    shape s = shape_sphere(40, 40);
    uint32_t *materials = malloc(s.mesh.triangle_count * sizeof *materials);
    for (uint32_t i = 0; i < s.mesh.triangle_count; i++) {
        materials[i] = i * 7 % MATERIALS;
    }
    s.mesh.triangle_materials = materials;
    uint32_t geometry = 0;
    assert_ok(context, clast_scene_add_mesh(scene, &s.mesh, NULL, &geometry));
    const clast_source *source = clast_sources[CLAST_SOURCE_CLUSTERS];
    clast_unit *unit = NULL;
    clast_cook_job job = {
        .context = context, .scene = scene, .geometry = &scene->geometries[0], .templates = templates};
    assert_ok(context, source->cook(&job, &unit));
    assert_int_equal(unit->material_count, MATERIALS);
    for (uint32_t i = 0; i < MATERIALS; i++) {
        assert_int_equal(unit->materials[i], i * 7 % MATERIALS);
    }
    assert_int_equal(source->primitive_material(unit, 11), 77);
    source->destroy(unit);
    clast_template_set_destroy(templates);
    clast_scene_destroy(scene);
    shape_free(&s);
    free(materials);
}

static void new_positions_are_taken_over(void **state)
{
    clast_context *context = *state;
    shape s = shape_sphere(40, 20);
    kind_world world = open_mesh(context, &s.mesh);
    kind_emission before = kind_emit(&world, &kind_poses[0], &kind_views[0]);
    const packed3 *place = kind_vertices(&world, &before, 0);
    for (uint32_t i = 0; i < 3 * s.mesh.vertex_count; i++) {
        s.positions[i] = s.positions[i] * 2.0f + 1.0f;
    }
    assert_ok(context, clast_scene_set_mesh_positions(world.scene, 0, s.positions, s.normals));
    uint32_t version = world.unit->version;
    assert_ok(context, world.source->update(world.unit, &world.scene->geometries[0]));
    assert_true(world.unit->version != version);
    assert_ptr_equal(kind_vertices(&world, &before, 0), place);
    clast_pose old = {.version = version}, now = {.version = world.unit->version};
    assert_int_equal(world.source->changed(world.unit, &old, &kind_views[0], &now, &kind_views[0]),
                     CLAST_CHANGE_VERTICES);
    clast_box box = world.source->bounds(world.unit, &now);
    assert_true(abs1(box.lower.v[1] + 1.0f) < 1e-6f && abs1(box.upper.v[1] - 3.0f) < 1e-6f);
    for (size_t i = 0; i < before.record_count; i++) {
        uint32_t corners[3];
        clast_template_triangle(world.templates, before.records[i].template_index, 0, corners);
        clast_surface_point point = world.source->locate(world.unit, &now, &before.records[i], NULL, 0,
                                                         vec2(0.0f, 0.0f));
        vec3 position = world.source->evaluate(world.unit, &now, point).position;
        assert_true(length3(position - load3(kind_vertices(&world, &before, i)[corners[0]])) < 1e-6f);
    }
    kind_emission_free(&before);
    shape_free(&s);
    kind_close(&world);
}

static void positions_that_part_are_refused_and_nothing_is_written(void **state)
{
    clast_context *context = *state;
    // two triangles that share an edge by position only
    float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    clast_mesh mesh = {
        .vertex_count = 6, .triangle_count = 2, .positions = positions, .indices = indices, .material = CLAST_NONE};
    kind_world world = open_mesh(context, &mesh);
    kind_emission all = kind_emit(&world, &kind_poses[0], &kind_views[0]);
    assert_int_equal(clast_template_vertex_count(world.templates, all.records[0].template_index), 4);
    packed3 before[4];
    memcpy(before, kind_vertices(&world, &all, 0), sizeof before);
    positions[9] = 2.0f;
    positions[2] = 5.0f;
    assert_ok(context, clast_scene_set_mesh_positions(world.scene, 0, positions, NULL));
    assert_int_equal(world.source->update(world.unit, &world.scene->geometries[0]), CLAST_ERROR_UNSUPPORTED);
    assert_memory_equal(before, kind_vertices(&world, &all, 0), sizeof before);
    kind_emission_free(&all);
    kind_close(&world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(every_triangle_of_the_mesh_is_there_once),
        CONTEXT_TEST(cooked_data_is_small),
        CONTEXT_TEST(attributes_are_interpolated),
        CONTEXT_TEST(attributes_that_are_not_there_have_their_defaults),
        CONTEXT_TEST(the_tangent_follows_the_texture_where_the_mesh_has_none),
        CONTEXT_TEST(normals_that_cancel_give_way_to_the_geometric_one),
        CONTEXT_TEST(tiny_and_huge_triangles_have_a_normal),
        CONTEXT_TEST(degenerate_triangles_give_no_wild_values),
        CONTEXT_TEST(a_mesh_without_triangles_cooks_to_nothing),
        CONTEXT_TEST(materials_are_listed_once_each),
        CONTEXT_TEST(new_positions_are_taken_over),
        CONTEXT_TEST(positions_that_part_are_refused_and_nothing_is_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
