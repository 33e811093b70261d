// SPDX-License-Identifier: Apache-2.0
// The passes up to the trees: what is made, what is kept, and that rays hit it.
#include "frame/stage.h"

#include <string.h>

static void an_empty_scene_is_a_frame_that_nothing_hits(void **state)
{
    stage s = stage_open(*state);
    stage_run(&s);
    assert_int_equal(stage_trace(s.frame, 0, 0, 10, 0, 0, -1).instance, CLAST_NONE);
    assert_int_equal(s.frame->triangles, 0);
    assert_true(s.frame->fitted_rate == 1.0f);
    stage_close(&s);
}

static void geometry_without_instances_or_triangles_is_no_trouble(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    shape_add_sphere(context, s.scene, 10, 10);
    const float positions[] = {0, 0, 0};
    clast_mesh points = {.vertex_count = 1, .positions = positions, .material = CLAST_NONE};
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(s.scene, &points, NULL, &geometry));
    shape_add_instance(context, s.scene, geometry, 0, 0, 0, 1);
    stage_run(&s);
    assert_int_equal(s.frame->triangles, 0);
    assert_int_equal(s.frame->instance_count, 1);
    assert_false(s.frame->units[0].used);
    assert_int_equal(stage_trace(s.frame, 0, 0, 10, 0, 0, -1).instance, CLAST_NONE);
    stage_close(&s);
}

static void rays_hit_the_instance_that_is_there(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 40, 20);
    uint32_t wave = shape_add_wave(context, s.scene, 3);
    uint32_t left = shape_add_instance(context, s.scene, sphere, -3, 0, 0, 1);
    uint32_t right = shape_add_instance(context, s.scene, sphere, 3, 0, 0, 2);
    uint32_t ground = shape_add_instance(context, s.scene, wave, 0, -5, 0, 1);
    stage_run(&s);
    clast_hit hit = stage_trace(s.frame, -3.01f, 0.02f, 10, 0, 0, -1);
    assert_int_equal(hit.instance, left);
    assert_true(fabsf(hit.t - 9.0f) < 0.01f);
    hit = stage_trace(s.frame, 3.01f, 0.02f, 10, 0, 0, -1);
    assert_int_equal(hit.instance, right);
    assert_true(fabsf(hit.t - 8.0f) < 0.02f);
    hit = stage_trace(s.frame, 0.1f, 1, 0.1f, 0, -1, 0);
    assert_int_equal(hit.instance, ground);
    assert_true(fabsf(hit.t - 6.0f) < 0.3f && hit.normal[1] > 0.0f);
    assert_int_equal(stage_trace(s.frame, 0.0f, 4, 10, 0, 0, -1).instance, CLAST_NONE);
    const clast_frame *frame = s.frame;
    uint64_t mesh = 2 * 40 * 20, sheet = frame->units[wave].sum.triangles;
    assert_int_equal(frame->triangles, mesh + sheet);
    assert_int_equal(frame->instanced_triangles, 2 * mesh + sheet);
    assert_int_equal(frame->clusters, frame->units[sphere].record_count + 9);
    assert_int_equal(frame->vertices, frame->units[sphere].cluster_vertices + frame->units[wave].vertex_count);
    clast_frame_bytes bytes = clast_frame_count_bytes(frame);
    assert_true(bytes.clas > 0 && bytes.blas > 0 && bytes.tlas > 0 && bytes.records > 0 && bytes.vertices > 0);
    stage_close(&s);
}

static void a_hit_leads_back_to_the_surface(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t wave = shape_add_wave(context, s.scene, 4);
    shape_add_instance(context, s.scene, wave, 0, 0, 0, 1);
    s.frame->settings.time = 0.4;
    stage_run(&s);
    const clast_frame_unit *unit = &s.frame->units[wave];
    for (float x = -4.7f; x < 4.8f; x += 0.37f) {
        clast_hit hit = stage_trace(s.frame, x, 3, 0.3f * x + 0.1f, 0, -1, 0);
        assert_int_equal(hit.instance, 0);
        const clast_source *source = clast_source_of(unit->unit);
        clast_surface_point point = source->locate(unit->unit, &unit->pose, &unit->records[hit.cluster],
                                                   clast_frame_words(unit, &unit->records[hit.cluster]), hit.triangle,
                                                   vec2(hit.u, hit.v));
        vec3 position = source->evaluate(unit->unit, &unit->pose, point).position;
        assert_true(fabsf(position[0] - x) < 1e-3f && fabsf(position[2] - 0.3f * x - 0.1f) < 1e-3f);
        assert_true(fabsf(position[1] - (3.0f - hit.t)) < 0.05f);
    }
    stage_close(&s);
}

static void many_instances_keep_their_order_where_some_drop_out(void **state)
{
    enum { COUNT = 7000 };
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t geometry = shape_add_sphere(context, s.scene, 4, 3), expected = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        shape_add_instance(context, s.scene, geometry, (float)i, 0, 0, i % 11 == 3 ? 0.0f : 1.0f);
        if (i % 7 == 0 || (i > 2500 && i < 5000)) {
            assert_ok(context, clast_scene_set_instance_visible(s.scene, i, false));
        }
    }
    stage_run(&s);
    for (uint32_t i = 0; i < COUNT; i++) {
        bool there = i % 11 != 3 && i % 7 != 0 && !(i > 2500 && i < 5000);
        assert_int_equal(s.frame->frame_instance_of[i], there ? expected : CLAST_NONE);
        if (there) {
            assert_int_equal(s.frame->instances[expected].scene_instance, i);
            assert_true(s.frame->instances[expected++].to_world.rows[0].v[3] == (float)i);
        }
    }
    assert_int_equal(s.frame->instance_count, expected);
    stage_close(&s);
}

static void removed_and_invisible_instances_drop_out(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 20, 20);
    uint32_t gone = shape_add_instance(context, s.scene, sphere, -3, 0, 0, 1);
    uint32_t unseen = shape_add_instance(context, s.scene, sphere, 0, 0, 0, 1);
    uint32_t stays = shape_add_instance(context, s.scene, sphere, 3, 0, 0, 1);
    uint32_t squashed = shape_add_instance(context, s.scene, sphere, 0, 3, 0, 0);
    assert_ok(context, clast_scene_remove_instance(s.scene, gone));
    assert_ok(context, clast_scene_set_instance_visible(s.scene, unseen, false));
    stage_run(&s);
    assert_int_equal(s.frame->instance_count, 1);
    assert_int_equal(s.frame->frame_instance_of[stays], 0);
    assert_int_equal(s.frame->frame_instance_of[gone], CLAST_NONE);
    assert_int_equal(s.frame->frame_instance_of[squashed], CLAST_NONE);
    assert_int_equal(stage_trace(s.frame, -3, 0.1f, 10, 0, 0, -1).instance, CLAST_NONE);
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, CLAST_NONE);
    assert_int_equal(stage_trace(s.frame, 3, 0.1f, 10, 0, 0, -1).instance, stays);
    assert_ok(context, clast_scene_set_instance_visible(s.scene, unseen, true));
    stage_run(&s);
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, unseen);
    assert_ok(context, clast_scene_remove_instance(s.scene, unseen));
    assert_ok(context, clast_scene_remove_instance(s.scene, stays));
    stage_run(&s);
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, CLAST_NONE);
    assert_int_equal(s.frame->triangles, 0);
    stage_close(&s);
}

static void moved_instances_are_hit_where_they_are(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 20, 20);
    uint32_t instance = shape_add_instance(context, s.scene, sphere, 0, 0, 0, 1);
    stage_run(&s);
    const clast_cluster_record *records = s.frame->units[sphere].records;
    float mirrored[12] = {-1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
    assert_ok(context, clast_scene_set_instance_transform(s.scene, instance, mirrored));
    stage_run(&s);
    assert_ptr_equal(s.frame->units[sphere].records, records);
    assert_int_equal(s.frame->units[sphere].change, CLAST_CHANGE_NOTHING);
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, CLAST_NONE);
    clast_hit hit = stage_trace(s.frame, 5.1f, 0.1f, 10, 0, 0, -1);
    assert_int_equal(hit.instance, instance);
    vec3 back = transform_point(s.frame->instances[0].to_object, vec3(5.1f, 0.1f, 10.0f - hit.t));
    assert_true(fabsf(length3(back) - 1.0f) < 0.03f);
    stage_close(&s);
}

static void units_that_did_not_change_keep_all_they_have(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 20, 20);
    uint32_t wave = shape_add_wave(context, s.scene, 2);
    shape_add_instance(context, s.scene, sphere, 0, 0, 0, 1);
    shape_add_instance(context, s.scene, wave, 0, -2, 0, 1);
    stage_run(&s);
    clast_frame_unit before[2] = {s.frame->units[0], s.frame->units[1]};
    s.frame->settings.time = 1.0;
    stage_run(&s);
    const clast_frame_unit *now = s.frame->units;
    assert_int_equal(now[sphere].change, CLAST_CHANGE_NOTHING);
    assert_int_equal(now[wave].change, CLAST_CHANGE_VERTICES);
    for (uint32_t i = 0; i < 2; i++) {
        assert_ptr_equal(now[i].records, before[i].records);
        assert_ptr_equal(now[i].clas, before[i].clas);
        assert_ptr_equal(now[i].blas, before[i].blas);
        assert_int_equal(now[i].record_count, before[i].record_count);
    }
    stage_run(&s);
    assert_int_equal(s.frame->units[wave].change, CLAST_CHANGE_NOTHING);
    stage_close(&s);
}

static void moved_vertices_are_hit_where_they_are(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    shape sphere = shape_sphere(20, 20);
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(s.scene, &sphere.mesh, NULL, &geometry));
    shape_add_instance(context, s.scene, geometry, 0, 0, 0, 1);
    stage_run(&s);
    for (uint32_t i = 0; i < 3 * sphere.mesh.vertex_count; i++) {
        sphere.positions[i] *= 3.0f;
    }
    assert_ok(context, clast_scene_set_mesh_positions(s.scene, geometry, sphere.positions, NULL));
    stage_run(&s);
    assert_int_equal(s.frame->units[0].change, CLAST_CHANGE_VERTICES);
    assert_true(fabsf(stage_trace(s.frame, 0.1f, 0.1f, 10, 0, 0, -1).t - 7.0f) < 0.06f);
    assert_int_equal(stage_trace(s.frame, 2.5f, 0.1f, 10, 0, 0, -1).instance, 0);
    for (uint32_t i = 0; i < 3 * sphere.mesh.vertex_count; i++) {
        sphere.positions[i] = sphere.positions[i] / 3.0f +
                              (i % 3 == 0 ? 1e-4f * (float)(i / 3) : 0.0f); // opens the seam
    }
    assert_ok(context, clast_scene_set_mesh_positions(s.scene, geometry, sphere.positions, NULL));
    stage_run(&s);
    assert_int_equal(s.frame->units[0].change, CLAST_CHANGE_TOPOLOGY);
    assert_int_equal(s.cooked->retired_count, 0);
    assert_true(fabsf(stage_trace(s.frame, 0.1f, 0.1f, 10, 0, 0, -1).t - 9.0f) < 0.03f);
    shape_free(&sphere);
    stage_close(&s);
}

// -------------------------------------------------------------------------------------------------------------- purity

enum { RAYS = 400 };

static void trace_fan(const clast_frame *frame, clast_hit hits[RAYS])
{
    for (int i = 0; i < RAYS; i++) {
        memset(&hits[i], 0, sizeof hits[i]);
        hits[i] = stage_trace(frame, 0, 4, 10, 0.05f * (float)(i % 20 - 10), -0.3f - 0.02f * (float)(i / 20), -1);
        if (hits[i].instance == CLAST_NONE) {
            hits[i] = (clast_hit){.instance = CLAST_NONE, .steps = hits[i].steps};
        }
    }
}

static void compare_frames(const clast_frame *a, const clast_frame *b)
{
    assert_int_equal(a->instance_count, b->instance_count);
    assert_true(a->fitted_rate == b->fitted_rate);
    assert_int_equal(a->triangles, b->triangles);
    assert_int_equal(a->clusters, b->clusters);
    for (size_t i = 0; i < a->unit_count; i++) {
        const clast_frame_unit *u = &a->units[i], *v = &b->units[i];
        assert_int_equal(u->record_count, v->record_count);
        assert_int_equal(u->vertex_count, v->vertex_count);
        assert_memory_equal(u->records, v->records, u->record_count * sizeof *u->records);
        if (u->vertex_count != 0) {
            assert_memory_equal(u->vertices, v->vertices, u->vertex_count * sizeof *u->vertices);
        }
        clast_box p, q;
        clast_blas_bounds(u->blas, p.lower.v, p.upper.v);
        clast_blas_bounds(v->blas, q.lower.v, q.upper.v);
        assert_memory_equal(&p, &q, sizeof p);
    }
    clast_hit hits[RAYS], others[RAYS];
    trace_fan(a, hits);
    trace_fan(b, others);
    assert_memory_equal(hits, others, sizeof hits); // steps too: the trees have the same shape
}

static void a_frame_does_not_depend_on_what_was_made_before(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t wave = shape_add_wave(context, s.scene, 7);
    uint32_t sphere = shape_add_sphere(context, s.scene, 30, 30);
    shape_add_instance(context, s.scene, wave, 0, 0, 0, 1);
    shape_add_instance(context, s.scene, sphere, 0, 1, 0, 1);
    clast_frame_settings wanted = s.frame->settings;
    wanted.time = 0.9;
    wanted.max_triangles = 6000;
    s.frame->settings = wanted;
    stage_run(&s);
    s.frame->settings.time = 3.3; // another moment, from elsewhere, unbounded
    s.frame->settings.max_triangles = 0;
    s.frame->settings.rate_camera.position.v[2] = 2.0f;
    stage_run(&s);
    s.frame->settings = wanted;
    s.frame->settings.time = 0.2; // same topology as wanted, other vertices
    stage_run(&s);
    s.frame->settings = wanted;
    stage_run(&s);
    clast_frame *fresh = stage_add_frame(&s);
    fresh->settings = wanted;
    assert_ok(context, clast_frame_run(fresh, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    compare_frames(s.frame, fresh);
    clast_frame_destroy(fresh);
    stage_close(&s);
}

static clast_frame *build_on(uint32_t threads, clast_isa isa, stage *s)
{
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads, .isa = isa}, &context), CLAST_OK);
    *s = stage_open(context);
    shape_add_instance(context, s->scene, shape_add_wave(context, s->scene, 40), 0, 0, 0, 1);
    shape_add_instance(context, s->scene, shape_add_sphere(context, s->scene, 200, 100), 0, 1, 0, 1);
    s->frame->settings.time = 0.3;
    s->frame->settings.max_triangles = 100000;
    stage_run(s);
    return s->frame;
}

static void threads_and_instruction_sets_do_not_matter(void **state)
{
    (void)state;
    stage one, five;
    compare_frames(build_on(1, CLAST_ISA_PLAIN, &one), build_on(5, CLAST_ISA_AUTOMATIC, &five));
    clast_context *contexts[2] = {one.context, five.context};
    stage_close(&one);
    stage_close(&five);
    clast_context_destroy(contexts[0]);
    clast_context_destroy(contexts[1]);
}

// -------------------------------------------------------------------------------------------------------- other passes

static void passes_are_timed_and_missing_ones_refused(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 40, 20), 0, 0, 0, 1);
    stage_run(&s);
    for (uint32_t pass = 0; pass <= CLAST_PASS_LIGHTS; pass++) {
        assert_true(s.frame->milliseconds[pass] > 0.0);
    }
    assert_int_equal(clast_frame_run(s.frame, &stage_backend, CLAST_PASS_TRACE, CLAST_PASS_TRACE, NULL),
                     CLAST_ERROR_UNSUPPORTED);
    assert_non_null(strstr(clast_context_error(context), "trace"));
    assert_int_equal(stage_trace(s.frame, 0.1f, 0.1f, 10, 0, 0, -1).instance, 0); // the trees stand
    stage_close(&s);
}

static void an_instance_of_what_is_not_cooked_is_refused(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 4, 4), 0, 0, 0, 1);
    assert_int_equal(clast_frame_run(s.frame, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_TLAS, NULL),
                     CLAST_ERROR_STATE);
    stage_close(&s);
}

static bool refuse(void *user, const clast_ray *ray, const clast_hit *hit)
{
    (void)ray;
    (void)hit;
    (*(uint32_t *)user)++;
    return false;
}

static void only_what_has_alpha_goes_to_the_filter(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    clast_material_desc material = clast_material_defaults();
    uint32_t leaf = 0;
    assert_ok(context, clast_scene_add_material(s.scene, &material, "leaf", &leaf));
    shape sphere = shape_sphere(20, 20);
    sphere.mesh.material = leaf;
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(s.scene, &sphere.mesh, NULL, &geometry));
    shape_free(&sphere);
    shape_add_instance(context, s.scene, geometry, 0, 0, 0, 1);
    uint32_t asked = 0;
    clast_hit_filter filter = {refuse, &asked};
    clast_ray ray = {{0.1f, 0.1f, 10}, 0.0f, {0, 0, -1}, INFINITY};
    clast_hit hit;
    stage_run(&s);
    clast_trace_closest(s.frame->tlas, &ray, 1, &filter, &hit);
    assert_int_equal(hit.instance, 0);
    assert_int_equal(asked, 0);
    for (uint32_t mode = CLAST_ALPHA_MASK; mode <= CLAST_ALPHA_BLEND; mode++) {
        material.alpha_mode = (clast_alpha_mode)mode;
        assert_ok(context, clast_scene_set_material(s.scene, leaf, &material));
        stage_run(&s);
        asked = 0;
        clast_trace_closest(s.frame->tlas, &ray, 1, &filter, &hit);
        assert_int_equal(hit.instance, CLAST_NONE);
        assert_true(asked >= 2);
    }
    stage_close(&s);
}

static void emitters_are_the_glowing_triangles_in_world_space(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    clast_material_desc material = clast_material_defaults();
    material.emissive[1] = 2.0f;
    uint32_t lamp = 0;
    assert_ok(context, clast_scene_add_material(s.scene, &material, "lamp", &lamp));
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 0, 1, 1, 3, 2}; // the second has no area
    const uint32_t materials[] = {lamp, lamp, 0};
    clast_mesh mesh = {.vertex_count = 4,
                       .triangle_count = 3,
                       .positions = positions,
                       .indices = indices,
                       .triangle_materials = materials};
    uint32_t geometry;
    assert_ok(context, clast_scene_add_mesh(s.scene, &mesh, NULL, &geometry));
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 8, 8), 0, 0, 0, 1);
    shape_add_instance(context, s.scene, geometry, 0, 0, 5, 1);
    shape_add_instance(context, s.scene, geometry, 0, 0, 0, 3);
    stage_run(&s);
    assert_int_equal(s.frame->emitter_count, 2);
    const clast_emitter *e = s.frame->emitters;
    assert_int_equal(e[0].instance, 1);
    assert_int_equal(e[1].instance, 2);
    assert_int_equal(e[0].primitive, 0);
    assert_int_equal(e[0].material, lamp);
    assert_true(fabsf(e[0].area - 0.5f) < 1e-6f && fabsf(e[1].area - 4.5f) < 1e-5f);
    assert_true(e[0].corners[1].v[2] == 5.0f && e[1].corners[1].v[0] == 3.0f);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(an_empty_scene_is_a_frame_that_nothing_hits),
        CONTEXT_TEST(geometry_without_instances_or_triangles_is_no_trouble),
        CONTEXT_TEST(rays_hit_the_instance_that_is_there),
        CONTEXT_TEST(a_hit_leads_back_to_the_surface),
        CONTEXT_TEST(removed_and_invisible_instances_drop_out),
        CONTEXT_TEST(many_instances_keep_their_order_where_some_drop_out),
        CONTEXT_TEST(moved_instances_are_hit_where_they_are),
        CONTEXT_TEST(units_that_did_not_change_keep_all_they_have),
        CONTEXT_TEST(moved_vertices_are_hit_where_they_are),
        CONTEXT_TEST(a_frame_does_not_depend_on_what_was_made_before),
        cmocka_unit_test(threads_and_instruction_sets_do_not_matter),
        CONTEXT_TEST(passes_are_timed_and_missing_ones_refused),
        CONTEXT_TEST(an_instance_of_what_is_not_cooked_is_refused),
        CONTEXT_TEST(only_what_has_alpha_goes_to_the_filter),
        CONTEXT_TEST(emitters_are_the_glowing_triangles_in_world_space),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
