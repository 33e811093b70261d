// SPDX-License-Identifier: Apache-2.0
// The scene graph (section 3.5): nodes become instances, cameras and lights with world transforms. Nodes form strict
// trees; that is checked first, so the walk is a loop that meets each node once, however deep.
#include <float.h>
#include <math.h>
#include <string.h>

#include "load/gltf.h"

typedef struct walk {
    clast_gltf *gltf;
    uint32_t node_count;
    uint32_t *parents;              // CLAST_NONE for roots
    clast_gltf_transform *to_world; // of each node
    uint32_t *stack;                // nodes still to visit: each at most once
    size_t stack_size;
} walk;

// ---------------------------------------------------------------------------------------------------------- transforms

static clast_gltf_transform identity(void)
{
    return (clast_gltf_transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

// a after b.
static clast_gltf_transform product(const clast_gltf_transform *a, const clast_gltf_transform *b)
{
    clast_gltf_transform result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            const double *row = a->rows[i];
            result.rows[i][j] = row[0] * b->rows[0][j] + row[1] * b->rows[1][j] + row[2] * b->rows[2][j] +
                                (j == 3 ? row[3] : 0.0);
        }
    }
    return result;
}

// Translation after rotation after scale (section 3.5.3). The quaternion is made unit length.
static clast_gltf_transform compose(const float translation[3], const float rotation[4], const float scale[3])
{
    double x = (double)rotation[0], y = (double)rotation[1], z = (double)rotation[2], w = (double)rotation[3];
    double square = x * x + y * y + z * z + w * w;
    double s = square > 0.0 ? 2.0 / square : 0.0;
    double turn[3][3] = {
        {1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
        {s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)},
        {s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)},
    };
    clast_gltf_transform result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            result.rows[i][j] = turn[i][j] * (double)scale[j];
        }
        result.rows[i][3] = (double)translation[i];
    }
    return result;
}

// A matrix by columns, without its last row.
static clast_gltf_transform from_columns(const float columns[16])
{
    clast_gltf_transform result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            result.rows[i][j] = (double)columns[4 * j + i];
        }
    }
    return result;
}

static clast_gltf_transform read_matrix(clast_gltf *gltf, const clast_gltf_value *node, const float columns[16])
{
    if (columns[3] != 0.0f || columns[7] != 0.0f || columns[11] != 0.0f || columns[15] != 1.0f) {
        clast_gltf_value place = clast_gltf_member(node, "matrix");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "the last row is %g %g %g %g: expected 0 0 0 1",
                        (double)columns[3], (double)columns[7], (double)columns[11], (double)columns[15]);
    }
    return from_columns(columns);
}

static clast_gltf_transform local_transform(clast_gltf *gltf, const clast_gltf_value *node)
{
    float columns[16] = {0}, translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    bool has_matrix = clast_gltf_numbers(gltf, node, "matrix", 16, -FLT_MAX, FLT_MAX, columns);
    bool has_parts = clast_gltf_numbers(gltf, node, "translation", 3, -FLT_MAX, FLT_MAX, translation);
    has_parts |= clast_gltf_numbers(gltf, node, "rotation", 4, -FLT_MAX, FLT_MAX, rotation);
    has_parts |= clast_gltf_numbers(gltf, node, "scale", 3, -FLT_MAX, FLT_MAX, scale);
    if (has_matrix && has_parts) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, node,
                        "both matrix and translation, rotation or scale: expected one of the two");
    }
    if (rotation[0] == 0.0f && rotation[1] == 0.0f && rotation[2] == 0.0f && rotation[3] == 0.0f) {
        clast_gltf_value place = clast_gltf_member(node, "rotation");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "zero: expected a unit quaternion");
    }
    return has_matrix ? read_matrix(gltf, node, columns) : compose(translation, rotation, scale);
}

// As floats; false, with its error, where they do not hold it.
static bool to_floats(clast_gltf *gltf, const clast_gltf_value *node, const clast_gltf_transform *from,
                      float floats[12])
{
    for (int i = 0; i < 12; i++) {
        floats[i] = (float)from->rows[i / 4][i % 4];
        if (!is_finite1(floats[i])) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, node, "the transform to world space is not finite");
        }
    }
    return true;
}

// ----------------------------------------------------------------------------------------------------------- instances

static void add_instances(clast_gltf *gltf, const clast_gltf_value *node, uint32_t first, uint32_t count,
                          const clast_gltf_transform *to_world)
{
    float floats[12];
    const char *name = clast_gltf_text(gltf, node, "name");
    if (!clast_gltf_ok(gltf) || !to_floats(gltf, node, to_world, floats)) {
        return;
    }
    for (uint32_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        uint32_t geometry = gltf->geometries[first + i], number;
        if (geometry != CLAST_NONE) {
            clast_gltf_check(gltf, clast_scene_add_instance(gltf->scene, geometry, floats, name, &number));
        }
    }
}

// One attribute of EXT_mesh_gpu_instancing as floats, in a new block; null where it is absent, or on failure.
static float *read_instances(clast_gltf *gltf, const clast_gltf_value *attributes, const char *name,
                             uint32_t components, uint32_t rows, uint64_t *count)
{
    clast_gltf_value place = clast_gltf_member(attributes, name);
    return place.json != NULL && clast_gltf_ok(gltf) ? clast_gltf_read_block(gltf, &place, components, 1, rows, count)
                                                     : NULL;
}

// EXT_mesh_gpu_instancing: false where the node does not have it.
static bool add_many_instances(clast_gltf *gltf, const clast_gltf_value *node, uint32_t first, uint32_t count,
                               const clast_gltf_transform *to_world)
{
    const uint32_t any_float = CLAST_GLTF_BIT(CLAST_GLTF_FLOAT);
    const uint32_t any_turn = any_float | CLAST_GLTF_BIT(CLAST_GLTF_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_SHORT);
    static const float none[3] = {0, 0, 0}, still[4] = {0, 0, 0, 1}, one[3] = {1, 1, 1};
    clast_gltf_value extensions;
    clast_gltf_value instancing = clast_gltf_extension(gltf, node, &extensions, "EXT_mesh_gpu_instancing");
    if (instancing.json == NULL) {
        return false;
    }
    clast_gltf_value attributes = clast_gltf_object(gltf, &instancing, "attributes");
    uint64_t many = 0;
    float *translations = read_instances(gltf, &attributes, "TRANSLATION", any_float, 3, &many);
    float *rotations = read_instances(gltf, &attributes, "ROTATION", any_turn, 4, &many);
    float *scales = read_instances(gltf, &attributes, "SCALE", any_float, 3, &many);
    clast_gltf_account(gltf, &attributes, many, count * sizeof(clast_instance));
    for (size_t i = 0; i < many && clast_gltf_ok(gltf); i++) {
        clast_gltf_transform local = compose(translations != NULL ? translations + 3 * i : none,
                                             rotations != NULL ? rotations + 4 * i : still,
                                             scales != NULL ? scales + 3 * i : one);
        clast_gltf_transform whole = product(to_world, &local);
        add_instances(gltf, node, first, count, &whole);
    }
    clast_free(gltf->context, translations);
    clast_free(gltf->context, rotations);
    clast_free(gltf->context, scales);
    return true;
}

// Where the joints of a skin are, against where they were bound (section 3.7.3): a new block, null on failure.
static clast_gltf_transform *read_joints(walk *walk, uint32_t skin, size_t *count)
{
    clast_gltf *gltf = walk->gltf;
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_SKINS, skin);
    clast_gltf_value list = clast_gltf_array(gltf, &value, "joints");
    clast_gltf_value matrices = clast_gltf_member(&value, "inverseBindMatrices");
    uint64_t bound = *count = clast_gltf_size(&list);
    if (clast_gltf_ok(gltf) && bound == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "no joints: expected at least one");
    }
    if (!clast_gltf_ok(gltf)) {
        return NULL;
    }
    float *inverse = NULL;
    if (matrices.json != NULL) {
        bound = 0; // there may be more matrices than joints
        inverse = clast_gltf_read_block(gltf, &matrices, CLAST_GLTF_BIT(CLAST_GLTF_FLOAT), 4, 4, &bound);
        if (inverse != NULL && bound < *count) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &matrices,
                            "%llu matrices: expected one for each of the %zu joints", (unsigned long long)bound,
                            *count);
        }
    }
    clast_gltf_transform *joints = clast_gltf_ok(gltf) ? clast_allocate(gltf->context, *count, sizeof *joints) : NULL;
    if (joints == NULL && clast_gltf_ok(gltf)) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    for (size_t i = 0; i < *count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value element = clast_gltf_element(&list, i);
        uint32_t node = clast_gltf_value_index(gltf, &element, CLAST_GLTF_NODES);
        if (node != CLAST_NONE) {
            clast_gltf_transform bind = inverse != NULL ? from_columns(inverse + 16 * i) : identity();
            joints[i] = product(&walk->to_world[node], &bind);
        }
    }
    clast_free(gltf->context, inverse);
    if (!clast_gltf_ok(gltf)) {
        clast_free(gltf->context, joints);
        return NULL;
    }
    return joints;
}

static void add_mesh(walk *walk, const clast_gltf_value *node, const clast_gltf_transform *to_world)
{
    clast_gltf *gltf = walk->gltf;
    uint32_t mesh = clast_gltf_index(gltf, node, "mesh", CLAST_GLTF_MESHES), first, count;
    uint32_t skin = clast_gltf_index(gltf, node, "skin", CLAST_GLTF_SKINS);
    if (!clast_gltf_ok(gltf) || mesh == CLAST_NONE) {
        return;
    }
    clast_gltf_pose pose = {0};
    float *weights = clast_gltf_read_weights(gltf, node, &pose.weight_count); // its own, if any
    clast_gltf_transform *joints = skin != CLAST_NONE && clast_gltf_ok(gltf)
                                       ? read_joints(walk, skin, &pose.joint_count)
                                       : NULL;
    pose.weights = weights;
    pose.joints = joints;
    clast_gltf_transform still = identity();
    // The joints move a skinned mesh, and its own node does not (section 3.7.3.3).
    const clast_gltf_transform *place = joints != NULL ? &still : to_world;
    const clast_gltf_pose *used = weights != NULL || joints != NULL ? &pose : NULL;
    if (clast_gltf_ok(gltf) && clast_gltf_use_mesh(gltf, mesh, used, &first, &count) &&
        !add_many_instances(gltf, node, first, count, place)) {
        add_instances(gltf, node, first, count, place);
    }
    clast_free(gltf->context, weights);
    clast_free(gltf->context, joints);
}

// ------------------------------------------------------------------------------------------------------------- walking

// Finds each node's parent; a second one is an error (section 3.5.2).
static bool find_parents(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    for (uint32_t i = 0; i < walk->node_count; i++) {
        clast_gltf_value node = clast_gltf_entry(gltf, CLAST_GLTF_NODES, i);
        clast_gltf_value children = clast_gltf_array(gltf, &node, "children");
        for (size_t k = 0; k < clast_gltf_size(&children); k++) {
            clast_gltf_value element = clast_gltf_element(&children, k);
            uint32_t child = clast_gltf_value_index(gltf, &element, CLAST_GLTF_NODES);
            if (child != CLAST_NONE && walk->parents[child] != CLAST_NONE) {
                clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &element,
                                "node %u is a child of node %u too: expected one parent", child, walk->parents[child]);
            }
            if (!clast_gltf_ok(gltf)) {
                return false;
            }
            walk->parents[child] = i;
        }
        if (!clast_gltf_ok(gltf)) {
            return false;
        }
    }
    return true;
}

// With one parent each, nodes that no root leads to are in cycles, or below one. Going up from a node for as many
// steps as there are nodes would be quadratic; `state` remembers which are known to end at a root.
static bool check_cycles(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    unsigned char *state = clast_allocate_zeroed(gltf->context, walk->node_count,
                                                 1); // 1: on the way up, 2: ends at a root
    if (state == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    for (uint32_t i = 0; i < walk->node_count && clast_gltf_ok(gltf); i++) {
        uint32_t node = i;
        while (node != CLAST_NONE && state[node] == 0) {
            state[node] = 1;
            node = walk->parents[node];
        }
        if (node != CLAST_NONE && state[node] == 1) {
            clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_NODES, node);
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "is below itself: expected trees of nodes");
        }
        for (node = i; node != CLAST_NONE && state[node] == 1; node = walk->parents[node]) {
            state[node] = 2;
        }
    }
    clast_free(gltf->context, state);
    return clast_gltf_ok(gltf);
}

// Pushes a node's children backwards, so that they are visited in order.
static void push_children(walk *walk, const clast_gltf_value *node)
{
    clast_gltf_value children = clast_gltf_array(walk->gltf, node, "children");
    for (size_t k = clast_gltf_size(&children); k-- > 0;) {
        clast_gltf_value element = clast_gltf_element(&children, k);
        walk->stack[walk->stack_size++] = clast_gltf_value_index(walk->gltf, &element, CLAST_GLTF_NODES);
    }
}

// The transform of every node to world space, parents first.
static void find_transforms(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    for (uint32_t i = walk->node_count; i-- > 0;) {
        if (walk->parents[i] == CLAST_NONE) {
            walk->stack[walk->stack_size++] = i;
        }
    }
    while (walk->stack_size > 0 && clast_gltf_ok(gltf)) {
        uint32_t index = walk->stack[--walk->stack_size];
        clast_gltf_value node = clast_gltf_entry(gltf, CLAST_GLTF_NODES, index);
        clast_gltf_transform local = local_transform(gltf, &node);
        uint32_t parent = walk->parents[index];
        walk->to_world[index] = parent != CLAST_NONE ? product(&walk->to_world[parent], &local) : local;
        float floats[12];
        if (clast_gltf_ok(gltf) && to_floats(gltf, &node, &walk->to_world[index], floats)) {
            push_children(walk, &node);
        }
    }
    walk->stack_size = 0;
}

static void walk_from(walk *walk, uint32_t root)
{
    clast_gltf *gltf = walk->gltf;
    walk->stack[walk->stack_size++] = root;
    while (clast_gltf_ok(gltf) && walk->stack_size > 0) {
        uint32_t index = walk->stack[--walk->stack_size];
        clast_gltf_value node = clast_gltf_entry(gltf, CLAST_GLTF_NODES, index);
        add_mesh(walk, &node, &walk->to_world[index]);
        clast_gltf_add_camera(gltf, &node, &walk->to_world[index]);
        clast_gltf_add_light(gltf, &node, &walk->to_world[index]);
        push_children(walk, &node);
    }
}

// The roots of the scene that is wanted, or of the default one; without `scene` the first one, and without scenes every root, as viewers do.
static void walk_scene(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    uint32_t index = gltf->chosen_scene;
    if (clast_gltf_size(&gltf->lists[CLAST_GLTF_SCENES]) == 0) {
        for (uint32_t i = 0; i < walk->node_count && clast_gltf_ok(gltf); i++) {
            if (walk->parents[i] == CLAST_NONE) {
                walk_from(walk, i);
            }
        }
        return;
    }
    clast_gltf_value scene = clast_gltf_entry(gltf, CLAST_GLTF_SCENES, index != CLAST_NONE ? index : 0);
    clast_gltf_value nodes = clast_gltf_array(gltf, &scene, "nodes");
    for (size_t i = 0; i < clast_gltf_size(&nodes) && clast_gltf_ok(gltf); i++) {
        clast_gltf_value element = clast_gltf_element(&nodes, i);
        uint32_t node = clast_gltf_value_index(gltf, &element, CLAST_GLTF_NODES);
        if (clast_gltf_ok(gltf) && walk->parents[node] != CLAST_NONE) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &element,
                            "node %u is below another, or listed twice: expected a root", node);
        }
        if (clast_gltf_ok(gltf)) {
            walk->parents[node] = node; // not to be listed again
            walk_from(walk, node);
        }
    }
}

void clast_gltf_read_nodes(clast_gltf *gltf)
{
    clast_context *context = gltf->context;
    walk walk = {.gltf = gltf, .node_count = (uint32_t)clast_gltf_size(&gltf->lists[CLAST_GLTF_NODES])};
    walk.parents = clast_allocate(context, walk.node_count, sizeof *walk.parents);
    walk.to_world = walk.parents != NULL ? clast_allocate(context, walk.node_count, sizeof *walk.to_world) : NULL;
    walk.stack = walk.to_world != NULL ? clast_allocate(context, walk.node_count, sizeof *walk.stack) : NULL;
    if (walk.stack == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    } else {
        memset(walk.parents, 0xff, walk.node_count * sizeof *walk.parents);
        if (find_parents(&walk) && check_cycles(&walk)) {
            find_transforms(&walk);
        }
        if (clast_gltf_ok(gltf)) {
            walk_scene(&walk);
        }
    }
    clast_free(context, walk.stack);
    clast_free(context, walk.to_world);
    clast_free(context, walk.parents);
}
