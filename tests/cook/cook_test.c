// SPDX-License-Identifier: Apache-2.0
#include "shapes.h"

#include "cook/cook.h"

typedef struct kitchen {
    clast_scene *scene;
    clast_cooked *cooked;
} kitchen;

static kitchen open_kitchen(clast_context *context)
{
    kitchen k;
    assert_ok(context, clast_scene_create(context, &k.scene));
    assert_ok(context, clast_cooked_create(context, &k.cooked));
    return k;
}

static void close_kitchen(kitchen *k)
{
    clast_cooked_destroy(k->cooked);
    clast_scene_destroy(k->scene);
}

static void units_have_the_numbers_of_their_geometries(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    shape_add_sphere(context, k.scene, 10, 10);
    shape_add_wave(context, k.scene, 2);
    shape_add_sphere(context, k.scene, 5, 5);
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_int_equal(k.cooked->unit_count, 3);
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(k.cooked->units[i]->number, i);
        assert_int_equal(k.cooked->units[i]->kind, k.scene->geometries[i].kind);
        assert_int_equal(k.cooked->units[i]->geometry_version, k.scene->geometries[i].version);
        bytes += k.cooked->units[i]->bytes;
    }
    assert_int_equal(k.cooked->bytes, bytes);
    assert_true(k.cooked->milliseconds > 0.0);
    close_kitchen(&k);
}

static void an_empty_scene_cooks(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_int_equal(k.cooked->unit_count, 0);
    close_kitchen(&k);
}

static void what_did_not_change_is_kept(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    shape_add_sphere(context, k.scene, 10, 10);
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    clast_unit *unit = k.cooked->units[0];
    uint32_t templates = clast_template_set_count(k.cooked->templates);
    for (uint32_t i = 0; i < 20; i++) { // moves the scene's array
        shape_add_sphere(context, k.scene, 4, 4);
    }
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_ptr_equal(k.cooked->units[0], unit);
    assert_int_equal(unit->serial, 1);
    assert_ptr_equal(unit->geometry->of.mesh.indices, k.scene->geometries[0].of.mesh.indices);
    assert_true(clast_template_set_count(k.cooked->templates) > templates);
    templates = clast_template_set_count(k.cooked->templates);
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_int_equal(clast_template_set_count(k.cooked->templates), templates);
    close_kitchen(&k);
}

static void moved_vertices_update_the_unit_in_place(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    shape s = shape_sphere(10, 10);
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(k.scene, &s.mesh, NULL, &geometry));
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    clast_unit *unit = k.cooked->units[0];
    for (uint32_t i = 0; i < 3 * s.mesh.vertex_count; i++) {
        s.positions[i] *= 3.0f;
    }
    assert_ok(context, clast_scene_set_mesh_positions(k.scene, 0, s.positions, NULL));
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_ptr_equal(k.cooked->units[0], unit);
    assert_int_equal(unit->version, 1);
    assert_int_equal(unit->geometry_version, k.scene->geometries[0].version);
    shape_free(&s);
    close_kitchen(&k);
}

static void vertices_that_part_cook_the_unit_anew(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    shape s = shape_sphere(10, 10);
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(k.scene, &s.mesh, NULL, &geometry));
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    for (uint32_t i = 0; i < 3 * s.mesh.vertex_count; i++) {
        s.positions[i] += 0.001f * (float)(i / 3); // tears the seam open
    }
    assert_ok(context, clast_scene_set_mesh_positions(k.scene, 0, s.positions, NULL));
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_int_equal(k.cooked->units[0]->serial, 2);
    assert_int_equal(k.cooked->units[0]->geometry_version, k.scene->geometries[0].version);
    assert_int_equal(k.cooked->retired_count, 1);
    clast_cooked_release(k.cooked);
    assert_int_equal(k.cooked->retired_count, 0);
    shape_free(&s);
    close_kitchen(&k);
}

typedef struct stopper {
    uint32_t calls;
    uint32_t stop_at;
    uint64_t last_done;
    bool backwards;
} stopper;

static bool stop(void *user, const char *stage, uint64_t done, uint64_t total)
{
    stopper *s = user;
    (void)stage;
    s->backwards = s->backwards || done < s->last_done || done > total;
    s->last_done = done;
    return ++s->calls != s->stop_at;
}

static void cooking_can_be_cancelled_and_resumed(void **state)
{
    (void)state;
    stopper s = {.stop_at = 2};
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .progress = {stop, &s}}, &context),
                     CLAST_OK);
    uint64_t memory = clast_context_memory(context);
    kitchen k = open_kitchen(context);
    shape_add_sphere(context, k.scene, 10, 10);
    shape_add_sphere(context, k.scene, 12, 10);
    assert_int_equal(clast_cooked_update(k.cooked, k.scene), CLAST_ERROR_CANCELLED);
    assert_non_null(k.cooked->units[0]);
    assert_null(k.cooked->units[1]);
    s = (stopper){0};
    assert_ok(context, clast_cooked_update(k.cooked, k.scene));
    assert_non_null(k.cooked->units[1]);
    assert_int_equal(k.cooked->units[0]->serial, 1);
    assert_true(s.calls >= 2 && !s.backwards);
    close_kitchen(&k);
    assert_int_equal(clast_context_memory(context), memory);
    clast_context_destroy(context);
}

static void a_geometry_that_cannot_be_cooked_is_an_error(void **state)
{
    clast_context *context = *state;
    kitchen k = open_kitchen(context);
    shape_add_sphere(context, k.scene, 10, 10);
    clast_wave wave = {
        .size = 1e9f, .tiles = 1, .amplitude = 1.0f, .wavelength = 1.0f, .speed = 1.0f, .material = CLAST_NONE};
    uint32_t geometry;
    assert_ok(context, clast_scene_add_wave(k.scene, &wave, "storm", &geometry));
    assert_int_equal(clast_cooked_update(k.cooked, k.scene), CLAST_ERROR_LIMIT);
    assert_non_null(strstr(clast_context_error(context), "storm"));
    close_kitchen(&k);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(units_have_the_numbers_of_their_geometries),
        CONTEXT_TEST(an_empty_scene_cooks),
        CONTEXT_TEST(what_did_not_change_is_kept),
        CONTEXT_TEST(moved_vertices_update_the_unit_in_place),
        CONTEXT_TEST(vertices_that_part_cook_the_unit_anew),
        cmocka_unit_test(cooking_can_be_cancelled_and_resumed),
        CONTEXT_TEST(a_geometry_that_cannot_be_cooked_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
