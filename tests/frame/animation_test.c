// SPDX-License-Identifier: Apache-2.0
// Frames of a scene that moves: an arm of two joints, a sheet that bulges, and what hangs from nodes.
#include "stage.h"

#include <string.h>

#include "clast/animation.h"

enum { SIDE = 9, VERTICES = SIDE * SIDE, TRIANGLES = (SIDE - 1) * (SIDE - 1) * 2 };

// A square sheet in the plane z = 0, from (0, 0) to (2, 2).
typedef struct sheet {
    float positions[3 * VERTICES], normals[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
} sheet;

static uint32_t add_sheet(stage *s)
{
    static sheet made;
    uint32_t *corner = made.indices;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float position[3] = {2.0f * (float)(i % SIDE) / (SIDE - 1), 2.0f * (float)(i / SIDE) / (SIDE - 1), 0};
        const float normal[3] = {0, 0, 1};
        memcpy(made.positions + 3 * i, position, sizeof position);
        memcpy(made.normals + 3 * i, normal, sizeof normal);
        if (i % SIDE != SIDE - 1 && i / SIDE != SIDE - 1) {
            const uint32_t quad[6] = {i, i + 1, i + SIDE + 1, i, i + SIDE + 1, i + SIDE};
            memcpy(corner, quad, sizeof quad);
            corner += 6;
        }
    }
    clast_mesh mesh = {.vertex_count = VERTICES,
                       .triangle_count = TRIANGLES,
                       .positions = made.positions,
                       .normals = made.normals,
                       .indices = made.indices,
                       .material = CLAST_NONE};
    uint32_t geometry = CLAST_NONE;
    assert_ok(s->context, clast_scene_add_mesh(s->scene, &mesh, "sheet", &geometry));
    return geometry;
}

static uint32_t add_node(stage *s, uint32_t parent, float x, float y, float z)
{
    clast_node_desc desc = {.parent = parent, .translation = {x, y, z}};
    uint32_t number = CLAST_NONE;
    assert_ok(s->context, clast_scene_add_node(s->scene, &desc, NULL, &number));
    return number;
}

// The upper half of the sheet follows a joint at (0, 1), which turns by a quarter about x within a second.
static void add_arm(stage *s)
{
    uint32_t geometry = add_sheet(s), shoulder = add_node(s, CLAST_NONE, 0, 0, 0),
             elbow = add_node(s, shoulder, 0, 1, 0);
    const uint32_t joints[] = {shoulder, elbow};
    const float binds[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1, 0};
    clast_skin_desc desc = {.joint_count = 2, .joints = joints, .inverse_binds = binds};
    uint16_t numbers[2 * VERTICES];
    float weights[2 * VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++) {
        numbers[2 * i] = 0;
        numbers[2 * i + 1] = 1;
        weights[2 * i] = i / SIDE <= SIDE / 2 ? 3.0f : 0.0f;
        weights[2 * i + 1] = i / SIDE <= SIDE / 2 ? 0.0f : 3.0f;
    }
    uint32_t skin, instance, number;
    assert_ok(s->context, clast_scene_add_skin(s->scene, &desc, &skin));
    assert_ok(s->context, clast_scene_set_mesh_skin(s->scene, geometry, skin, 2, numbers, weights));
    assert_ok(s->context, clast_scene_add_instance(s->scene, geometry, NULL, NULL, &instance));
    const float half = sqrtf(0.5f), times[] = {0, 1, 2}, turns[] = {0, 0, 0, 1, half, 0, 0, half, half, 0, 0, half};
    clast_channel channel = {elbow, CLAST_ANIMATED_ROTATION, CLAST_INTERPOLATION_LINEAR, 3, times, turns};
    assert_ok(s->context, clast_scene_add_animation(s->scene, &channel, 1, "bend", &number));
}

static void run_at(stage *s, double time)
{
    s->frame->settings.time = time;
    stage_run(s);
}

static void a_bent_arm_is_where_its_joints_take_it(void **state)
{
    stage s = stage_open(*state);
    add_arm(&s);
    run_at(&s, 0.0);
    assert_true(fabsf(stage_trace(s.frame, 1, 1.75f, 5, 0, 0, -1).t - 5) < 1e-5f); // still flat
    run_at(&s, 1.5);                                                               // the forearm points to the viewer
    assert_int_equal(stage_trace(s.frame, 1, 1.75f, 5, 0, 0, -1).instance, CLAST_NONE);
    clast_hit hit = stage_trace(s.frame, 1, 9, 0.75f, 0, -1, 0);
    assert_int_equal(hit.instance, 0);
    assert_true(fabsf(hit.t - 8) < 1e-5f);
    assert_true(fabsf(stage_trace(s.frame, 1, 0.5f, 5, 0, 0, -1).t - 5) < 1e-5f); // the upper arm stays
    const clast_frame_unit *unit = &s.frame->units[0];
    assert_true(fabsf(unit->bounds.upper.v[2] - 1) < 1e-5f && fabsf(unit->bounds.upper.v[1] - 1) < 1e-5f);
    assert_true(fabsf(unit->pose.normals[VERTICES - 1].v[1] + 1) < 1e-5f); // normals turn too
    stage_close(&s);
}

// What a frame is, whichever was made before it: to the bit.
static void frames_do_not_depend_on_those_before(void **state)
{
    static packed3 alone[VERTICES];
    clast_hit expected[16];
    for (int turn = 0; turn < 2; turn++) {
        stage s = stage_open(*state);
        add_arm(&s);
        for (int i = turn == 0 ? 10 : 1; i <= 10; i++) {
            run_at(&s, (double)i / 16.0);
        }
        const clast_frame_unit *unit = &s.frame->units[0];
        for (int i = 0; i < 16; i++) {
            clast_hit hit = stage_trace(s.frame, 0.11f * (float)i, 1.3f, 5, 0, 0, -1);
            expected[i] = turn == 0 ? hit : expected[i];
            assert_memory_equal(&hit, &expected[i], sizeof hit);
        }
        if (turn == 0) {
            memcpy(alone, unit->pose.positions, sizeof alone);
        }
        assert_memory_equal(unit->pose.positions, alone, sizeof alone);
        stage_close(&s);
    }
}

static void what_stands_still_is_not_made_anew(void **state)
{
    stage s = stage_open(*state);
    add_arm(&s);
    run_at(&s, 0.25);
    assert_int_equal(s.frame->moved_vertices, VERTICES);
    run_at(&s, 0.25);
    assert_int_equal(s.frame->moved_vertices, 0);
    assert_int_equal(s.frame->units[0].change, CLAST_CHANGE_NOTHING);
    run_at(&s, 1.25); // from here to the end it stays bent
    assert_int_equal(s.frame->moved_vertices, VERTICES);
    assert_int_equal(s.frame->units[0].change, CLAST_CHANGE_VERTICES);
    run_at(&s, 1.75);
    assert_int_equal(s.frame->moved_vertices, 0);
    run_at(&s, 2.25); // and again from the beginning
    assert_int_equal(s.frame->moved_vertices, VERTICES);
    stage_close(&s);
}

static void morph_targets_add_up(void **state)
{
    stage s = stage_open(*state);
    uint32_t geometry = add_sheet(&s), node = add_node(&s, CLAST_NONE, 0, 0, 0), instance, number;
    static float up[3 * VERTICES], aside[3 * VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++) {
        up[3 * i + 2] = 1;
        aside[3 * i] = 10;
    }
    const clast_morph_target targets[] = {{.positions = up}, {.positions = aside, .normals = aside}};
    const float rest[] = {0.5f, 0}, times[] = {0, 1}, values[] = {0.5f, 0, 3, 1};
    assert_ok(s.context, clast_scene_set_node_weights(s.scene, node, rest, 2));
    assert_ok(s.context, clast_scene_set_mesh_morph(s.scene, geometry, targets, 2, node));
    assert_ok(s.context, clast_scene_add_instance(s.scene, geometry, NULL, NULL, &instance));
    clast_channel channel = {node, CLAST_ANIMATED_WEIGHTS, CLAST_INTERPOLATION_LINEAR, 2, times, values};
    assert_ok(s.context, clast_scene_add_animation(s.scene, &channel, 1, NULL, &number));
    run_at(&s, 0.0);
    assert_true(fabsf(stage_trace(s.frame, 1, 1, 5, 0, 0, -1).t - 4.5f) < 1e-5f);
    run_at(&s, 0.5); // 1.75 up, 5 aside; the normal is (5, 0, 1), made unit length
    assert_true(fabsf(stage_trace(s.frame, 6, 1, 5, 0, 0, -1).t - 3.25f) < 1e-5f);
    assert_true(fabsf(s.frame->units[0].pose.normals[3].v[0] - 5 / sqrtf(26)) < 1e-5f);
    s.frame->settings.animation = CLAST_ANIMATION_REST;
    run_at(&s, 0.5);
    assert_true(fabsf(stage_trace(s.frame, 1, 1, 5, 0, 0, -1).t - 4.5f) < 1e-5f);
    stage_close(&s);
}

// Two vertices in one place that part: a mouth that opens. Where they stay together the mesh stays closed.
static void vertices_that_part_are_not_welded(void **state)
{
    stage s = stage_open(*state);
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, -1, 0};
    const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    const float down[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, -1, 0, 0, -1, 0};
    clast_mesh mesh = {
        .vertex_count = 6, .triangle_count = 2, .positions = positions, .indices = indices, .material = CLAST_NONE};
    const clast_morph_target target = {.positions = down};
    const float weight = 0;
    uint32_t geometry, node = add_node(&s, CLAST_NONE, 0, 0, 0), instance;
    assert_ok(s.context, clast_scene_add_mesh(s.scene, &mesh, NULL, &geometry));
    assert_ok(s.context, clast_scene_set_node_weights(s.scene, node, &weight, 1));
    assert_ok(s.context, clast_scene_add_instance(s.scene, geometry, NULL, NULL, &instance));
    stage_run(&s);
    assert_int_equal(s.frame->vertices, 4);
    assert_ok(s.context, clast_scene_set_mesh_morph(s.scene, geometry, &target, 1, node));
    const float open = 1;
    assert_ok(s.context, clast_scene_set_node_weights(s.scene, node, &open, 1));
    stage_run(&s);
    assert_int_equal(s.frame->vertices, 6);
    assert_int_equal(stage_trace(s.frame, 0.6f, -0.5f, 5, 0, 0, -1).instance, CLAST_NONE); // between the lips
    assert_int_equal(stage_trace(s.frame, 0.6f, -1.2f, 5, 0, 0, -1).instance, 0);
    assert_ok(s.context, clast_scene_set_mesh_morph(s.scene, geometry, NULL, 0, node)); // as it was
    stage_run(&s);
    assert_int_equal(s.frame->vertices, 4);
    stage_close(&s);
}

static void shared_meshes_move_by_themselves(void **state)
{
    stage s = stage_open(*state);
    uint32_t first = add_sheet(&s), second, instance;
    static float up[3 * VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++) {
        up[3 * i + 2] = 1;
    }
    const clast_morph_target target = {.positions = up};
    uint32_t nodes[2] = {add_node(&s, CLAST_NONE, 0, 0, 0), add_node(&s, CLAST_NONE, 0, 0, 0)};
    const float weights[2] = {1, 2};
    assert_ok(s.context, clast_scene_share_mesh(s.scene, first, "again", &second));
    assert_ptr_equal(s.scene->geometries[first].of.mesh.positions, s.scene->geometries[second].of.mesh.positions);
    for (uint32_t i = 0; i < 2; i++) {
        uint32_t geometry = i == 0 ? first : second;
        assert_ok(s.context, clast_scene_set_node_weights(s.scene, nodes[i], &weights[i], 1));
        assert_ok(s.context, clast_scene_set_mesh_morph(s.scene, geometry, &target, 1, nodes[i]));
        const float place[12] = {1, 0, 0, 4.0f * (float)i, 0, 1, 0, 0, 0, 0, 1, 0};
        assert_ok(s.context, clast_scene_add_instance(s.scene, geometry, place, NULL, &instance));
    }
    stage_run(&s);
    assert_true(fabsf(stage_trace(s.frame, 1, 1, 5, 0, 0, -1).t - 4) < 1e-5f);
    assert_true(fabsf(stage_trace(s.frame, 5, 1, 5, 0, 0, -1).t - 3) < 1e-5f);
    stage_close(&s);
}

static void instances_lights_and_cameras_follow_their_nodes(void **state)
{
    stage s = stage_open(*state);
    uint32_t sphere = shape_add_sphere(s.context, s.scene, 16, 8), node = add_node(&s, CLAST_NONE, 0, 0, 0), number;
    uint32_t instance = shape_add_instance(s.context, s.scene, sphere, 0, 0, 0, 1);
    clast_light_desc lamp = {.type = CLAST_LIGHT_POINT, .intensity = 1};
    clast_camera_desc eye = {.target = {0, 0, -1}};
    assert_ok(s.context, clast_scene_add_light(s.scene, &lamp, NULL, &number));
    assert_ok(s.context, clast_scene_attach_light(s.scene, number, node));
    assert_ok(s.context, clast_scene_add_camera(s.scene, &eye, NULL, &number));
    assert_ok(s.context, clast_scene_attach_camera(s.scene, number, node));
    assert_ok(s.context, clast_scene_attach_instance(s.scene, instance, node));
    const float times[] = {0, 1}, values[] = {0, 0, 0, 8, 0, 0};
    clast_channel channel = {node, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 2, times, values};
    assert_ok(s.context, clast_scene_add_animation(s.scene, &channel, 1, NULL, &number));
    run_at(&s, 0.25);
    assert_int_equal(stage_trace(s.frame, 0, 0, 5, 0, 0, -1).instance, CLAST_NONE);
    assert_int_equal(stage_trace(s.frame, 2, 0, 5, 0, 0, -1).instance, instance);
    assert_true(fabsf(s.frame->motion.lights[0].position.v[0] - 2) < 1e-6f);
    assert_true(fabsf(s.frame->settings.camera.position.v[0] - 2) < 1e-6f);
    assert_int_equal(s.frame->units[sphere].posed.shape, 0); // nothing of the mesh itself moves
    stage_close(&s);
}

static void a_mesh_that_leaves_single_precision_is_refused(void **state)
{
    stage s = stage_open(*state);
    uint32_t geometry = add_sheet(&s), node = add_node(&s, CLAST_NONE, 0, 0, 0), instance;
    static float far_away[3 * VERTICES];
    for (uint32_t i = 0; i < 3 * VERTICES; i++) {
        far_away[i] = 1e30f;
    }
    const clast_morph_target target = {.positions = far_away};
    float weight = 1e30f;
    assert_ok(s.context, clast_scene_set_node_weights(s.scene, node, &weight, 1));
    assert_ok(s.context, clast_scene_set_mesh_morph(s.scene, geometry, &target, 1, node));
    assert_ok(s.context, clast_scene_add_instance(s.scene, geometry, NULL, NULL, &instance));
    assert_int_equal(stage_try(&s), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(s.context), "leaves single precision"));
    weight = 0;
    assert_ok(s.context, clast_scene_set_node_weights(s.scene, node, &weight, 1));
    stage_run(&s);
    assert_int_equal(stage_trace(s.frame, 1, 1, 5, 0, 0, -1).instance, instance);
    stage_close(&s);
}

static void wrong_skins_and_targets_are_refused(void **state)
{
    stage s = stage_open(*state);
    uint32_t geometry = add_sheet(&s), wave = shape_add_wave(s.context, s.scene, 1), skin;
    uint32_t node = add_node(&s, CLAST_NONE, 0, 0, 0), missing = 9;
    static uint16_t joints[VERTICES];
    static float weights[VERTICES];
    clast_skin_desc desc = {.joint_count = 1, .joints = &missing};
    assert_int_equal(clast_scene_add_skin(s.scene, &desc, &skin), CLAST_ERROR_INVALID_ARGUMENT);
    desc.joint_count = 0;
    assert_int_equal(clast_scene_add_skin(s.scene, &desc, &skin), CLAST_ERROR_INVALID_ARGUMENT);
    desc = (clast_skin_desc){.joint_count = 1, .joints = &node};
    assert_ok(s.context, clast_scene_add_skin(s.scene, &desc, &skin));
    assert_int_equal(clast_scene_set_mesh_skin(s.scene, geometry, 1, 1, joints, weights), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_scene_set_mesh_skin(s.scene, wave, skin, 1, joints, weights), CLAST_ERROR_INVALID_ARGUMENT);
    weights[7] = 1;
    joints[7] = 1;
    assert_int_equal(clast_scene_set_mesh_skin(s.scene, geometry, skin, 1, joints, weights),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(s.context), "vertex 7"));
    joints[7] = 0;
    weights[7] = -1;
    assert_int_equal(clast_scene_set_mesh_skin(s.scene, geometry, skin, 1, joints, weights),
                     CLAST_ERROR_INVALID_ARGUMENT);
    const clast_morph_target target = {0};
    assert_int_equal(clast_scene_set_mesh_morph(s.scene, geometry, &target, 1, node), CLAST_ERROR_INVALID_ARGUMENT);
    assert_false(clast_deforms(&s.scene->geometries[geometry].deformation));
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_bent_arm_is_where_its_joints_take_it),
        CONTEXT_TEST(frames_do_not_depend_on_those_before),
        CONTEXT_TEST(what_stands_still_is_not_made_anew),
        CONTEXT_TEST(morph_targets_add_up),
        CONTEXT_TEST(vertices_that_part_are_not_welded),
        CONTEXT_TEST(shared_meshes_move_by_themselves),
        CONTEXT_TEST(instances_lights_and_cameras_follow_their_nodes),
        CONTEXT_TEST(a_mesh_that_leaves_single_precision_is_refused),
        CONTEXT_TEST(wrong_skins_and_targets_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
