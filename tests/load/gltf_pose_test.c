// SPDX-License-Identifier: Apache-2.0
// Morph targets and skins of glTF files, in the pose before any animation.
#include "gltf_fixture.h"

#include <math.h>

#include "scene/scene.h"

typedef struct data {
    float positions[9], normals[9];
    float moves[9], turns[9]; // a morph target
    uint16_t joints[12];
    float weights[12];
    float inverses[2][16];
} data;

static const data DATA = {
    .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
    .normals = {0, 0, 1, 0, 0, 1, 0, 0, 1},
    .moves = {0, 0, 2, 0, 0, 4, 0, 0, 0},
    .turns = {0, 0, 0, 2, 0, 0, 0, 0, 0},
    .joints = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0},
    .weights = {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0},
    .inverses = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}},
};

#define ACCESSOR(offset, component, count, type) \
    "{'bufferView':0,'byteOffset':" #offset ",'componentType':" #component ",'count':" #count ",'type':'" type "'}"
#define POSED(nodes, mesh, primitive, more) \
    "{" ASSET \
    "," BUFFER(344) ",'bufferViews':[{'buffer':0,'byteLength':344}],'accessors':[" ACCESSOR(0, 5126, 3, "VEC3") "," ACCESSOR( \
        36, 5126, 3, \
        "VEC3") "," ACCESSOR(72, 5126, 3, \
                             "VEC3") "," ACCESSOR(108, 5126, 3, \
                                                  "VEC3") "," ACCESSOR(144, 5123, 3, \
                                                                       "VEC4") "," ACCESSOR(168, 5126, 3, \
                                                                                            "VEC4") "," ACCESSOR(216, \
                                                                                                                 5126, \
                                                                                                                 2, \
                                                                                                                 "MAT4") "],'scenes':[{'nodes':[0,1]}],'nodes':[" nodes \
                                                                                                                         "],'meshes':[{" mesh \
                                                                                                                         "'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'JOINTS_0':4,'WEIGHTS_0':5}" primitive \
                                                                                                                         "}]}]" more \
                                                                                                                         "}"
#define TARGET ",'targets':[{'POSITION':2,'NORMAL':3}]"
#define SKIN(joints, more) ",'skins':[{'joints':[" joints "]" more "}]"

static void put_data(fixture *f, const data *bytes)
{
    assert_int_equal(sizeof *bytes, 344);
    memory_files_put(&f->files, "data.bin", bytes, sizeof *bytes);
}

// The three vertices of a geometry as they stand at rest.
typedef struct posed {
    packed3 positions[3], normals[3];
} posed;

static posed pose(const fixture *f, size_t geometry)
{
    static clast_transform joints[8];
    const clast_motion *motion = &f->scene->motion;
    const clast_geometry *from = &f->scene->geometries[geometry];
    const clast_deformation *deformation = &from->deformation;
    posed result;
    clast_deform_job job = {
        .geometry = from, .joints = joints, .positions = result.positions, .normals = result.normals};
    assert_true(clast_deforms(deformation));
    assert_int_equal(from->of.mesh.vertex_count, 3);
    if (deformation->influences != 0) {
        assert_true(motion->skins[deformation->skin].joint_count <= 8);
        assert_true(clast_scene_pose_joints(f->scene, deformation->skin, NULL, joints));
    }
    if (deformation->target_count != 0) {
        job.weights = motion->weights + motion->nodes[deformation->weights_node].first_weight;
    }
    assert_true(clast_deform(&job, 0, 3));
    return result;
}

static void the_mesh_has_weights_of_its_own(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    assert_loads(f, POSED("{'mesh':0},{'mesh':0}", "'weights':[0.5],", TARGET, ""));
    assert_int_equal(f->scene->geometry_count, 1); // both nodes show the same
    posed at_rest = pose(f, 0);
    assert_floats(at_rest.positions->v, (float[]){0, 0, 1, 1, 0, 2, 0, 1, 0}, 9, 0.0f);
    assert_floats(at_rest.normals->v, (float[]){0, 0, 1, sqrtf(0.5f), 0, sqrtf(0.5f), 0, 0, 1}, 9, 1e-6f);
}

static void weights_of_a_node_come_first(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    assert_loads(f, POSED("{'mesh':0,'weights':[-1]},{'mesh':0,'weights':[0]}", "'weights':[0.5],", TARGET, ""));
    assert_int_equal(f->scene->geometry_count, 2);
    assert_floats(pose(f, 0).positions->v, (float[]){0, 0, -2, 1, 0, -4, 0, 1, 0}, 9, 0.0f);
    assert_false(clast_deforms(&f->scene->geometries[1].deformation)); // its weights are all zero
    assert_floats(mesh_of(f, 1)->positions, DATA.positions, 9, 0.0f);
    assert_int_equal(f->scene->instances[0].geometry, 0);
    assert_int_equal(f->scene->instances[1].geometry, 1);
}

static void without_weights_targets_do_nothing(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    assert_loads(f, POSED("{'mesh':0},{}", "", TARGET, ""));
    assert_floats(mesh_of(f, 0)->positions, DATA.positions, 9, 0.0f);
    assert_int_equal(f->scene->file_count, 1); // still in place
}

static void broken_targets_are_refused(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    assert_refused(f, POSED("{'mesh':0},{}", "'weights':[1,1],", TARGET, ""), CLAST_ERROR_MALFORMED,
                   "meshes[0].primitives[0]: 1 morph targets: expected 2");
    assert_refused(f, POSED("{'mesh':0},{}", "'weights':[1],", "", ""), CLAST_ERROR_MALFORMED,
                   "0 morph targets: expected 1");
    assert_refused(f, POSED("{'mesh':0},{}", "'weights':['x'],", TARGET, ""), CLAST_ERROR_MALFORMED,
                   "meshes[0].weights[0]: a text");
    assert_refused(f, POSED("{'mesh':0},{}", "'weights':[1],", ",'targets':[{'POSITION':6}]", ""),
                   CLAST_ERROR_MALFORMED, "targets[0].POSITION: 2 elements");
    assert_refused(f, POSED("{'mesh':0},{}", "'weights':[1],", ",'targets':[7]", ""), CLAST_ERROR_MALFORMED,
                   "targets[0]: a number");
}

static void joints_move_the_vertices_and_the_node_does_not(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    // Joint 0 is node 2, moved by (0, 0, 3); joint 1 is node 3 below it, a quarter turn about z. The node of the mesh
    // is far away.
    assert_loads(
        f, POSED("{'mesh':0,'skin':0,'translation':[100,0,0]},{'children':[2]},{'translation':[0,0,3],'children':[3]},"
                 "{'rotation':[0,0,0.70710678,0.70710678]}",
                 "", "", SKIN("2,3", ",'inverseBindMatrices':6")));
    // Vertex 1 is first moved by (-1, 0, 0); vertex 2 is a blend of (0, 1, 0) and the turned (-1, 1, 0), which is
    // (-1, -1, 0).
    posed at_rest = pose(f, 0);
    assert_floats(at_rest.positions->v, (float[]){0, 0, 3, 0, 0, 3, -0.75f, -0.5f, 3}, 9, 1e-6f);
    assert_floats(at_rest.normals->v, DATA.normals, 9, 1e-6f);
    assert_floats(f->scene->instances[0].to_world.rows[0].v, (float[]){1, 0, 0, 0}, 4, 0.0f);
}

static void without_matrices_joints_are_bound_at_the_origin(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
    assert_loads(f, POSED("{'mesh':0,'skin':0},{'translation':[1,2,3]}", "", "", SKIN("1,1", "")));
    assert_floats(pose(f, 0).positions->v, (float[]){1, 2, 3, 2, 2, 3, 1, 3, 3}, 9, 1e-6f);
}

static void normals_follow_a_squeeze(void **state)
{
    fixture *f = *state;
    data bytes = DATA;
    memcpy(bytes.normals, (float[]){1, 1, 0, 1, 1, 0, 1, 1, 0}, sizeof bytes.normals);
    put_data(f, &bytes);
    assert_loads(f, POSED("{'mesh':0,'skin':0},{'scale':[1,0.5,1]}", "", "", SKIN("1,1", "")));
    assert_floats(pose(f, 0).normals->v, (float[]){sqrtf(0.2f), 2 * sqrtf(0.2f), 0}, 3, 1e-6f);
}

static void broken_skins_are_refused(void **state)
{
    fixture *f = *state;
    put_data(f, &DATA);
#define SKINNED(skin) POSED("{'mesh':0,'skin':0},{}", "", "", skin)
    assert_refused(f, SKINNED(""), CLAST_ERROR_MALFORMED, "nodes[0].skin: 0: the file has no skins");
    assert_refused(f, SKINNED(SKIN("", "")), CLAST_ERROR_MALFORMED, "skins[0]: no joints");
    assert_refused(f, SKINNED(SKIN("9,1", "")), CLAST_ERROR_MALFORMED, "skins[0].joints[0]: 9");
    assert_refused(f, SKINNED(SKIN("1,1,1", ",'inverseBindMatrices':6")), CLAST_ERROR_MALFORMED,
                   "inverseBindMatrices: 2 matrices");
    assert_refused(f, SKINNED(SKIN("1,1", ",'inverseBindMatrices':5")), CLAST_ERROR_MALFORMED,
                   "inverseBindMatrices: VEC4 of FLOAT");
    assert_refused(f, SKINNED(SKIN("1", "")), CLAST_ERROR_MALFORMED, "attributes.JOINTS_0: joint 1 of 1 (vertex 1)");
    data bytes = DATA;
    bytes.weights[4] = NAN;
    put_data(f, &bytes);
    assert_refused(f, SKINNED(SKIN("1,1", "")), CLAST_ERROR_MALFORMED, "attributes.WEIGHTS_0: vertex 1 is not finite");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(the_mesh_has_weights_of_its_own),
        GLTF_TEST(weights_of_a_node_come_first),
        GLTF_TEST(without_weights_targets_do_nothing),
        GLTF_TEST(broken_targets_are_refused),
        GLTF_TEST(joints_move_the_vertices_and_the_node_does_not),
        GLTF_TEST(without_matrices_joints_are_bound_at_the_origin),
        GLTF_TEST(normals_follow_a_squeeze),
        GLTF_TEST(broken_skins_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
