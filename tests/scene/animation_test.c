// SPDX-License-Identifier: Apache-2.0
// Nodes and animations of a scene: where things stand at a moment, by formulas worked out by hand.
#include "shapes.h"

#include <string.h>

#include "clast/animation.h"
#include "scene/scene.h"

#define assert_near(value, expected) \
    do { \
        double value_ = (double)(value), expected_ = (double)(expected); \
        if (!(fabs(value_ - expected_) <= 1e-6)) { \
            fail_msg("%s is %.9g, not %.9g", #value, value_, expected_); \
        } \
    } while (0)

// A scene of a node, and what it is at a moment.
typedef struct stand {
    clast_context *context;
    clast_scene *scene;
    clast_posed_node nodes[8];
    float weights[8];
} stand;

static uint32_t add_node(stand *s, uint32_t parent, float x, float y, float z)
{
    clast_node_desc desc = {.parent = parent, .translation = {x, y, z}};
    uint32_t number = CLAST_NONE;
    assert_ok(s->context, clast_scene_add_node(s->scene, &desc, "node", &number));
    return number;
}

static stand stand_open(clast_context *context)
{
    stand s = {.context = context};
    assert_ok(context, clast_scene_create(context, &s.scene));
    add_node(&s, CLAST_NONE, 0, 0, 0);
    return s;
}

static uint32_t animate(stand *s, const clast_channel *channels, size_t count, const char *name)
{
    uint32_t number = CLAST_NONE;
    assert_ok(s->context, clast_scene_add_animation(s->scene, channels, count, name, &number));
    return number;
}

static const clast_matrix *at(stand *s, uint32_t animation, double time, uint32_t node)
{
    clast_scene_pose(s->scene, (clast_moment){animation, time}, s->nodes, s->weights);
    return &s->nodes[node].to_world;
}

static void between_keys_translations_go_straight(void **state)
{
    stand s = stand_open(*state);
    const float times[] = {1, 3}, values[] = {0, 0, 0, 4, -8, 0};
    clast_channel channel = {0, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 2, times, values};
    animate(&s, &channel, 1, "go");
    assert_near(at(&s, 0, 0.0, 0)->rows[0][3], 0); // before the first key
    assert_near(at(&s, 0, 1.5, 0)->rows[0][3], 1);
    assert_near(at(&s, 0, 1.5, 0)->rows[1][3], -2);
    assert_near(at(&s, 0, 2.999, 0)->rows[0][3], 3.998);
    clast_scene_destroy(s.scene);
}

static void an_animation_begins_again_at_its_end(void **state)
{
    stand s = stand_open(*state);
    const float times[] = {0, 2}, values[] = {0, 0, 0, 2, 0, 0};
    clast_channel channel = {0, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 2, times, values};
    animate(&s, &channel, 1, NULL);
    assert_near(clast_scene_animation_length(s.scene, 0), 2);
    assert_near(at(&s, 0, 5.5, 0)->rows[0][3], 1.5);
    assert_near(at(&s, 0, -0.5, 0)->rows[0][3], 1.5);
    assert_near(at(&s, 0, 2.0, 0)->rows[0][3], 0);
    clast_scene_destroy(s.scene);
}

static void steps_hold_their_value(void **state)
{
    stand s = stand_open(*state);
    const float times[] = {0, 1, 2}, values[] = {1, 1, 1, 2, 2, 2, 3, 3, 3};
    clast_channel channel = {0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_STEP, 3, times, values};
    animate(&s, &channel, 1, NULL);
    assert_near(at(&s, 0, 0.999, 0)->rows[1][1], 1);
    assert_near(at(&s, 0, 1.0, 0)->rows[1][1], 2);
    assert_near(at(&s, 0, 1.999, 0)->rows[2][2], 2);
    clast_scene_destroy(s.scene);
}

// Halfway from none to a quarter turn about z is an eighth of a turn.
static void rotations_go_along_the_arc(void **state)
{
    stand s = stand_open(*state);
    const float half = sqrtf(0.5f), times[] = {0, 1, 2};
    const float values[] = {0, 0, 0, 1, 0, 0, half, half, 0, 0, -half, -half}; // the third is the second again
    clast_channel channel = {0, CLAST_ANIMATED_ROTATION, CLAST_INTERPOLATION_LINEAR, 3, times, values};
    animate(&s, &channel, 1, NULL);
    for (int i = 0; i <= 16; i++) {
        double angle = 1.5707963267948966 * i / 16.0;
        const clast_matrix *turned = at(&s, 0, i / 16.0, 0);
        assert_near(turned->rows[0][0], cos(angle));
        assert_near(turned->rows[1][0], sin(angle));
        assert_near(turned->rows[2][2], 1);
    }
    assert_near(at(&s, 0, 1.5, 0)->rows[1][0], 1); // the same turn by another sign: it stands still
    clast_scene_destroy(s.scene);
}

static void slerp_is_even_for_any_angle(void **state)
{
    (void)state;
    for (int degrees = 0; degrees <= 180; degrees += 15) {
        double angle = degrees * 3.14159265358979323846 / 180.0; // between the quaternions: half of it is turned
        const double from[4] = {0, 0, 0, 2}, to[4] = {0, sin(angle), 0, cos(angle)};
        double whole = degrees <= 90 ? angle : angle - 3.14159265358979323846; // the shorter way
        for (int i = 0; i <= 8; i++) {
            double q[4], sign;
            clast_slerp(from, to, i / 8.0, q);
            sign = q[3] < 0.0 ? -1.0 : 1.0;
            assert_near(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1);
            if (degrees != 90) { // both ways are as long there
                assert_near(sign * q[1], sin(whole * i / 8.0));
            }
        }
    }
}

static void cubic_splines_follow_their_tangents(void **state)
{
    stand s = stand_open(*state);
    // in-tangent, value, out-tangent of each key
    const float times[] = {0, 2}, values[] = {9, 9, 9, 1, 0, 0, 3, 0, 0, -1, 0, 0, 5, 0, 0, 9, 9, 9};
    clast_channel channel = {0, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_CUBICSPLINE, 2, times, values};
    animate(&s, &channel, 1, NULL);
    for (int i = 0; i < 8; i++) {
        double t = i / 8.0, t2 = t * t, t3 = t2 * t;
        double expected = (2 * t3 - 3 * t2 + 1) * 1 + 2 * (t3 - 2 * t2 + t) * 3 + (3 * t2 - 2 * t3) * 5 +
                          2 * (t3 - t2) * -1;
        assert_near(at(&s, 0, 2 * t, 0)->rows[0][3], expected);
    }
    clast_scene_destroy(s.scene);
}

static void children_go_with_their_parents(void **state)
{
    stand s = stand_open(*state);
    uint32_t child = add_node(&s, 0, 2, 0, 0), grandchild = add_node(&s, child, 0, 3, 0);
    const float half = sqrtf(0.5f), times[] = {0, 1}, values[] = {0, 0, 0, 1, 0, 0, half, half};
    clast_channel channel = {0, CLAST_ANIMATED_ROTATION, CLAST_INTERPOLATION_STEP, 2, times, values};
    const float later[] = {0, 4}, none[] = {0, 0, 0, 0, 0, 0};
    clast_channel channels[] = {channel, {child, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_STEP, 2, later, none}};
    animate(&s, &channel, 1, NULL);
    animate(&s, channels, 2, "squashed");
    const clast_matrix *moved = at(&s, CLAST_ANIMATION_REST, 1.0, grandchild);
    assert_near(moved->rows[0][3], 2);
    assert_near(moved->rows[1][3], 3);
    moved = at(&s, 1, 1.5, grandchild); // (2, 3, 0) a quarter turn on, the 3 of a child that has no size
    assert_near(moved->rows[0][3], 0);
    assert_near(moved->rows[1][3], 2);
    clast_scene_destroy(s.scene);
}

static void what_hangs_from_a_node_stands_there(void **state)
{
    stand s = stand_open(*state);
    uint32_t sphere = shape_add_sphere(s.context, s.scene, 4, 2);
    uint32_t instance = shape_add_instance(s.context, s.scene, sphere, 0, 0, 1, 2), light, camera;
    clast_light_desc lamp = {.type = CLAST_LIGHT_SPOT, .direction = {1, 0, 0}, .intensity = 1, .outer_angle = 1};
    clast_camera_desc eye = {.target = {1, 0, 0}};
    assert_ok(s.context, clast_scene_add_light(s.scene, &lamp, NULL, &light));
    assert_ok(s.context, clast_scene_add_camera(s.scene, &eye, NULL, &camera));
    uint32_t node = add_node(&s, 0, 5, 6, 7);
    assert_ok(s.context, clast_scene_attach_instance(s.scene, instance, node));
    assert_ok(s.context, clast_scene_attach_light(s.scene, light, node));
    assert_ok(s.context, clast_scene_attach_camera(s.scene, camera, node));
    const clast_transform *place = &s.scene->instances[instance].to_world;
    assert_near(place->rows[0].v[3], 5);
    assert_near(place->rows[2].v[3], 8);
    assert_near(place->rows[1].v[1], 2);
    assert_near(s.scene->lights[light].record.position.v[1], 6);
    assert_near(s.scene->lights[light].record.direction.v[2], -1);
    assert_near(s.scene->cameras[camera].desc.position[2], 7);
    clast_node_desc elsewhere = {.parent = CLAST_NONE, .translation = {10, 0, 0}};
    assert_ok(s.context, clast_scene_set_node(s.scene, 0, &elsewhere));
    assert_near(place->rows[0].v[3], 15);
    assert_ok(s.context, clast_scene_repeat(s.scene, 2)); // copies hang from it too
    elsewhere.translation[0] = 0;
    float apart = s.scene->instances[1].to_world.rows[0].v[3] - place->rows[0].v[3];
    assert_true(apart > 1);
    assert_ok(s.context, clast_scene_set_node(s.scene, 0, &elsewhere));
    assert_near(s.scene->instances[1].to_world.rows[0].v[3], 5 + apart);
    clast_scene_destroy(s.scene);
}

static void animations_are_chosen_by_name_or_number(void **state)
{
    stand s = stand_open(*state);
    uint32_t choice;
    const float times[] = {0}, values[] = {1, 2, 3};
    clast_channel channel = {0, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 1, times, values};
    animate(&s, &channel, 1, "walk");
    animate(&s, &channel, 1, "run");
    const struct {
        const char *text;
        uint32_t expected;
    } cases[] = {{"", CLAST_ANIMATION_FIRST},  {NULL, CLAST_ANIMATION_FIRST}, {"run", 1}, {"0", 0},
                 {"all", CLAST_ANIMATION_ALL}, {"none", CLAST_ANIMATION_REST}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_ok(s.context, clast_scene_choose_animation(s.scene, cases[i].text, &choice));
        assert_int_equal(choice, cases[i].expected);
    }
    assert_int_equal(clast_scene_choose_animation(s.scene, "2", &choice), CLAST_ERROR_INVALID_ARGUMENT);
    assert_near(at(&s, CLAST_ANIMATION_FIRST, 0, 0)->rows[2][3], 3);
    assert_near(at(&s, CLAST_ANIMATION_REST, 0, 0)->rows[2][3], 0);
    clast_scene_destroy(s.scene);
}

static void broken_animations_are_refused(void **state)
{
    stand s = stand_open(*state);
    const float matrix[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    clast_node_desc fixed = {.parent = CLAST_NONE, .matrix = matrix};
    uint32_t node, number;
    assert_ok(s.context, clast_scene_add_node(s.scene, &fixed, NULL, &node));
    const float good[] = {0, 1}, back[] = {1, 0}, twice[] = {1, 1}, early[] = {-1, 0}, odd[] = {0, NAN};
    const float values[] = {0, 0, 0, 0, 0, 0}, infinite[] = {0, 0, 0, 0, INFINITY, 0};
    const struct {
        clast_channel channel;
        const char *words;
    } cases[] = {
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, back, values}, "do not ascend"},
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, twice, values}, "do not ascend"},
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, early, values}, "do not ascend"},
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, odd, values}, "do not ascend"},
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, good, infinite}, "not finite"},
        {{0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 0, good, values}, "a key at least"},
        {{9, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, good, values}, "node is not there"},
        {{0, CLAST_ANIMATED_WEIGHTS, CLAST_INTERPOLATION_LINEAR, 2, good, values}, "no weights"},
        {{node, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, good, values}, "has a matrix"},
        {{0, (clast_animated)9, CLAST_INTERPOLATION_LINEAR, 2, good, values}, "none of the list"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(clast_scene_add_animation(s.scene, &cases[i].channel, 1, NULL, &number),
                         CLAST_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(clast_context_error(s.context), cases[i].words));
    }
    clast_channel channel = {0, CLAST_ANIMATED_SCALE, CLAST_INTERPOLATION_LINEAR, 2, good, values};
    clast_channel both[] = {channel, channel};
    assert_int_equal(clast_scene_add_animation(s.scene, both, 2, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(s.context), "channel 1"));
    assert_int_equal(s.scene->motion.animation_count, 0);
    clast_node_desc orphan = {.parent = 7};
    assert_int_equal(clast_scene_add_node(s.scene, &orphan, NULL, &number), CLAST_ERROR_INVALID_ARGUMENT);
    animate(&s, &channel, 1, NULL);
    assert_int_equal(clast_scene_set_node(s.scene, 0, &fixed), CLAST_ERROR_INVALID_ARGUMENT);
    assert_near(at(&s, CLAST_ANIMATION_REST, 0, 0)->rows[0][0], 1);
    clast_scene_destroy(s.scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(between_keys_translations_go_straight),
        CONTEXT_TEST(an_animation_begins_again_at_its_end),
        CONTEXT_TEST(steps_hold_their_value),
        CONTEXT_TEST(rotations_go_along_the_arc),
        CONTEXT_TEST(slerp_is_even_for_any_angle),
        CONTEXT_TEST(cubic_splines_follow_their_tangents),
        CONTEXT_TEST(children_go_with_their_parents),
        CONTEXT_TEST(what_hangs_from_a_node_stands_there),
        CONTEXT_TEST(animations_are_chosen_by_name_or_number),
        CONTEXT_TEST(broken_animations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
