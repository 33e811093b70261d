// SPDX-License-Identifier: Apache-2.0
// Animations of glTF files: what of them comes into the scene, and what is refused.
#include "gltf_fixture.h"

#include <math.h>

#include "scene/scene.h"

typedef struct data {
    float positions[9];
    float times[3];
    float moves[9];
    float cubes[27];
    int16_t turns[12]; // normalised
    float weights[6];
    float back[3];
} data;

static const data DATA = {
    .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
    .times = {0, 1, 2},
    .moves = {0, 0, 0, 2, 0, 0, 2, 4, 0},
    .cubes = {0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 2, 2, 2, 0, 0, 0, 0, 0, 0, 3, 3, 3, 0, 0, 0},
    .turns = {0, 0, 0, 32767, 0, 0, 32767, 0, 0, 0, 32767, 0},
    .weights = {0, 1, 0.5f, 0.5f, 1, 0},
    .back = {0, 2, 1},
};

#define VIEW(at) "{'bufferView':0,'byteOffset':" #at ",'componentType':5126,'count':"
// positions, times, moves, cubes, turns, weights, back
#define FILE_WITH(nodes, more) \
    "{" ASSET \
    "," BUFFER(252) ",'bufferViews':[{'buffer':0,'byteLength':252}],'accessors':[" VIEW(0) "3,'type':'VEC3'}," VIEW(36) "3,'type':'SCALAR'}," VIEW( \
        48) "3,'type':'VEC3'}," VIEW(84) "9,'type':'VEC3'}," \
                                         "{'bufferView':0,'byteOffset':192,'componentType':5122,'normalized':true,'count':3,'type':'VEC4'}," VIEW( \
                                             216) "6,'type':'SCALAR'}," VIEW(240) "3,'type':'SCALAR'}],'scenes':[{'nodes':[0]}],'nodes':[" nodes \
                                                                                  "],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}," \
                                                                                  "{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':0},{'POSITION':2}]}]}]" more \
                                                                                  "}"
#define ANIMATION(samplers, channels) \
    ",'animations':[{'name':'first','samplers':[" samplers "],'channels':[" channels "]}]"
#define CHANNEL(node, path) "{'sampler':0,'target':{'node':" #node ",'path':'" path "'}}"
#define LINEAR(output) "{'input':1,'output':" #output "}"

static void put_data(fixture *f)
{
    assert_int_equal(sizeof DATA, 252);
    memory_files_put(&f->files, "data.bin", &DATA, sizeof DATA);
}

static clast_posed_node posed_nodes[8];
static float posed_weights[8];

static const clast_matrix *node_at(const fixture *f, double time, uint32_t node)
{
    assert_true(f->scene->motion.node_count <= 8 && f->scene->motion.weight_count <= 8);
    clast_scene_pose(f->scene, (clast_moment){CLAST_ANIMATION_FIRST, time}, posed_nodes, posed_weights);
    return &posed_nodes[node].to_world;
}

static void assert_row(const clast_matrix *matrix, int row, double a, double b, double c, double d)
{
    const double expected[4] = {a, b, c, d};
    for (int i = 0; i < 4; i++) {
        if (!(fabs(matrix->rows[row][i] - expected[i]) < 1e-6)) {
            fail_msg("row %d, %d is %g, not %g", row, i, matrix->rows[row][i], expected[i]);
        }
    }
}

static void key_frames_are_used_where_they_lie(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), CHANNEL(0, "translation"))));
    const clast_motion *motion = &f->scene->motion;
    assert_int_equal(motion->animation_count, 1);
    assert_string_equal(motion->animations[0].name, "first");
    assert_true(motion->animations[0].length == 2.0);
    assert_int_equal(motion->block_count, 0); // nothing was copied
    assert_row(node_at(f, 0.5, 0), 0, 1, 0, 0, 1);
    assert_row(node_at(f, 1.5, 0), 1, 0, 1, 0, 2);
    assert_int_equal(motion->attachment_count, 1);
    assert_false(clast_deforms(&f->scene->geometries[0].deformation));
}

static void rotations_may_be_normalised_integers(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(4), CHANNEL(0, "rotation"))));
    assert_row(node_at(f, 1.0, 0), 0, -1, 0, 0, 0); // half a turn about z
    assert_row(node_at(f, 0.5, 0), 2, 0, 0, 1, 0);
}

static void cubic_splines_have_tangents(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'mesh':0}",
                              ANIMATION("{'input':1,'output':3,'interpolation':'CUBICSPLINE'}", CHANNEL(0, "scale"))));
    assert_row(node_at(f, 1.0, 0), 0, 2, 0, 0, 0);
    assert_row(node_at(f, 0.5, 0), 0, 1.5, 0, 0, 0); // tangents are zero: halfway
}

static void weights_of_targets_are_animated(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'mesh':1,'children':[1]},{'mesh':1}", ANIMATION(LINEAR(5), CHANNEL(0, "weights"))));
    node_at(f, 0.5, 0);
    assert_floats(posed_weights, (float[]){0.25f, 0.75f}, 2, 1e-6f);
    assert_int_equal(f->scene->geometry_count, 2); // the other node's stands still
    assert_true(clast_deforms(&f->scene->geometries[0].deformation));
    assert_false(clast_deforms(&f->scene->geometries[1].deformation));
}

static void cameras_and_lights_follow(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'camera':0,'extensions':{'KHR_lights_punctual':{'light':0}}}",
                              ANIMATION(LINEAR(2), CHANNEL(0, "translation")) //
                              ",'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1}}]"
                              ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}}"));
    assert_int_equal(f->scene->cameras[0].node, 0);
    assert_int_equal(f->scene->lights[0].node, 0);
}

static void files_without_motion_keep_no_nodes(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, TRIANGLE_WITH(""));
    assert_int_equal(f->scene->motion.node_count, 0);
    assert_int_equal(f->scene->motion.attachment_count, 0);
}

static void what_is_not_followed_is_said(void **state)
{
    fixture *f = *state;
    put_data(f);
    assert_loads(f, FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), "{'sampler':0,'target':{'path':'pointer'}}")));
    assert_non_null(strstr(f->log, "animations[0].channels[0]: KHR_animation_pointer is not followed"));
    assert_loads(f, FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(5), CHANNEL(0, "weights"))));
    assert_non_null(strstr(f->log, "node 0 shows no morph targets"));
    assert_loads(f, FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), "{'sampler':0,'target':{'path':'scale'}}")));
    assert_int_equal(f->scene->motion.animations[0].channel_count, 0);
}

static void broken_animations_are_refused(void **state)
{
    fixture *f = *state;
    put_data(f);
    const struct {
        const char *text, *words;
    } cases[] = {
        {FILE_WITH("{'mesh':0}", ANIMATION("{'input':6,'output':2}", CHANNEL(0, "scale"))), "do not ascend"},
        {FILE_WITH("{'mesh':0}", ANIMATION("{'input':1,'output':3}", CHANNEL(0, "scale"))),
         "samplers[0]: output: 9 elements of 3 numbers: expected 3 of 3"},
        {FILE_WITH("{'mesh':1}", ANIMATION("{'input':1,'output':6}", CHANNEL(0, "weights"))), "expected 6 of 1"},
        {FILE_WITH("{'mesh':0}", ANIMATION("{'input':1,'output':2,'interpolation':'SINE'}", CHANNEL(0, "scale"))),
         "\"SINE\": expected LINEAR"},
        {FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), CHANNEL(0, "colour"))), "path \"colour\": expected translation"},
        {FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), CHANNEL(7, "scale"))), "target.node: 7"},
        {FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), CHANNEL(0, "rotation"))), "output: VEC3 of FLOAT"},
        {FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(4), CHANNEL(0, "scale"))), "output: VEC4 of SHORT"},
        {FILE_WITH("{'mesh':0}", ANIMATION("{'output':2}", CHANNEL(0, "scale"))), "samplers[0].input: missing"},
        {FILE_WITH("{'mesh':0}", ANIMATION("", CHANNEL(0, "scale"))), "the animation has none"},
        {FILE_WITH("{'mesh':0}", ANIMATION(LINEAR(2), CHANNEL(0, "scale") "," CHANNEL(0, "scale"))),
         "animations[0]: channel 1: a channel before it"},
        {FILE_WITH("{'mesh':0,'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}", ANIMATION(LINEAR(2), CHANNEL(0, "scale"))),
         "the node has a matrix"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_refused(f, cases[i].text, CLAST_ERROR_MALFORMED, cases[i].words);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(key_frames_are_used_where_they_lie), GLTF_TEST(rotations_may_be_normalised_integers),
        GLTF_TEST(cubic_splines_have_tangents),        GLTF_TEST(weights_of_targets_are_animated),
        GLTF_TEST(cameras_and_lights_follow),          GLTF_TEST(files_without_motion_keep_no_nodes),
        GLTF_TEST(what_is_not_followed_is_said),       GLTF_TEST(broken_animations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
