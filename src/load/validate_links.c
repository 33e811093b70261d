// SPDX-License-Identifier: Apache-2.0
// How nodes, scenes, skins and animations refer to each other (sections 3.5, 3.7.3 and 3.11), and what nothing refers to.
#include "load/validate.h"

enum { SCENES_MOST = 100 }; // that are compared with each skin

static clast_gltf_value node_at(const clast_validator *v, size_t index)
{
    return clast_validate_entry(v, CLAST_VALIDATE_NODES, index);
}

// ------------------------------------------------------------------------------------------------------------ the forest

// The nodes as trees. All arrays have an entry for each node.
typedef struct forest {
    uint32_t *roots;         // CLAST_NONE for those that are below themselves
    uint32_t *order, *stack; // of a visit
    uint32_t *numbers;       // when the visit came: those below a node come next
    uint32_t *sizes;         // nodes at it and below
    bool *is_moved;          // a node above has a transform
} forest;

static bool has_transform(const clast_gltf_value *node)
{
    static const char *const names[] = {"matrix", "translation", "rotation", "scale"};
    for (int i = 0; i < 4; i++) {
        if (json_object_get(node->json, names[i]) != NULL) {
            return true;
        }
    }
    return false;
}

static void find_parents(clast_validator *v)
{
    size_t count = clast_validate_size(v, CLAST_VALIDATE_NODES);
    for (size_t i = 0; i < count; i++) {
        v->parents[i] = CLAST_NONE;
    }
    for (size_t i = 0; i < count; i++) {
        clast_gltf_value node = node_at(v, i), children = clast_gltf_member(&node, "children");
        for (size_t k = 0; k < clast_gltf_size(&children); k++) {
            uint32_t child = clast_validate_element_index(v, &children, k, CLAST_VALIDATE_NODES);
            clast_gltf_value place = clast_gltf_element(&children, k);
            if (child == CLAST_NONE) {
                continue;
            }
            if (v->parents[child] != CLAST_NONE && v->parents[child] != i) {
                clast_validate_fault(v, CLAST_FAULT_NODE_PARENT_OVERRIDE, &place, "node %u has the parent %u already",
                                     child, v->parents[child]);
            }
            v->parents[child] = (uint32_t)i;
        }
    }
}

// Visits the nodes from the roots down, each before those below it. What is not visited is below itself, or below a node that is.
static void number_nodes(clast_validator *v, forest *f)
{
    uint32_t count = (uint32_t)clast_validate_size(v, CLAST_VALIDATE_NODES), number = 0, waiting = 0;
    for (uint32_t i = 0; i < count; i++) {
        f->roots[i] = CLAST_NONE;
        f->sizes[i] = 1;
        if (v->parents[i] == CLAST_NONE) {
            f->roots[i] = i;
            f->stack[waiting++] = i;
        }
    }
    while (waiting > 0) {
        uint32_t at = f->stack[--waiting];
        clast_gltf_value node = node_at(v, at), children = clast_gltf_member(&node, "children");
        f->order[number] = at;
        f->numbers[at] = number++;
        for (size_t k = 0; k < clast_gltf_size(&children); k++) {
            uint32_t child = clast_validate_element_index(v, &children, k, CLAST_VALIDATE_NODES);
            if (child != CLAST_NONE && v->parents[child] == at && f->roots[child] == CLAST_NONE) {
                f->roots[child] = f->roots[at];
                f->is_moved[child] = f->is_moved[at] || has_transform(&node);
                f->stack[waiting++] = child;
            }
        }
    }
    while (number > 0) {
        uint32_t at = f->order[--number];
        if (v->parents[at] != CLAST_NONE) {
            f->sizes[v->parents[at]] += f->sizes[at];
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        clast_gltf_value node = node_at(v, i);
        if (f->roots[i] == CLAST_NONE) {
            clast_validate_fault(v, CLAST_FAULT_NODE_LOOP, &node, "the node is below itself, or below a node that is");
        }
    }
}

static bool is_at_or_above(const forest *f, uint32_t ancestor, uint32_t node)
{
    return f->roots[ancestor] != CLAST_NONE && f->roots[node] != CLAST_NONE &&
           f->numbers[node] >= f->numbers[ancestor] && f->numbers[node] - f->numbers[ancestor] < f->sizes[ancestor];
}

// ------------------------------------------------------------------------------------------------------- scenes and nodes

static void check_scenes(clast_validator *v)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_SCENES); i++) {
        clast_gltf_value scene = clast_validate_entry(v, CLAST_VALIDATE_SCENES, i),
                         nodes = clast_gltf_member(&scene, "nodes");
        for (size_t k = 0; k < clast_gltf_size(&nodes); k++) {
            uint32_t node = clast_validate_element_index(v, &nodes, k, CLAST_VALIDATE_NODES);
            clast_gltf_value place = clast_gltf_element(&nodes, k);
            if (node != CLAST_NONE && v->parents[node] != CLAST_NONE) {
                clast_validate_fault(v, CLAST_FAULT_SCENE_NON_ROOT_NODE, &place, "node %u has a parent", node);
            }
        }
    }
}

static void check_skinned_node(clast_validator *v, uint32_t index, const clast_gltf_value *node, const forest *f)
{
    if (has_transform(node)) {
        clast_validate_fault(v, CLAST_FAULT_NODE_SKINNED_MESH_LOCAL_TRANSFORMS, node, "of no effect on a skinned mesh");
    }
    if (v->parents[index] != CLAST_NONE) {
        clast_validate_fault(v, CLAST_FAULT_NODE_SKINNED_MESH_NON_ROOT, node, "a skinned mesh should be at the root");
    }
    if (f->is_moved[index]) {
        clast_validate_fault(v, CLAST_FAULT_NODE_SKINNED_MESH_PARENT_TRANSFORMS, node,
                             "transforms above it have no effect on a skinned mesh");
    }
}

// A scene with a skinned mesh must have the joints too. `is_listed` has an entry for each node, of roots in the scene.
static void check_scene_of_skins(clast_validator *v, size_t scene_number, const forest *f, const bool *is_listed)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_NODES); i++) {
        clast_gltf_value node = node_at(v, i);
        uint32_t skin = clast_validate_index(v, &node, "skin", CLAST_VALIDATE_SKINS);
        uint32_t mesh = clast_validate_index(v, &node, "mesh", CLAST_VALIDATE_MESHES);
        if (skin == CLAST_NONE || mesh == CLAST_NONE || f->roots[i] == CLAST_NONE || !is_listed[f->roots[i]]) {
            continue;
        }
        clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_SKINS, skin),
                         joints = clast_gltf_member(&value, "joints");
        uint32_t joint = clast_validate_element_index(v, &joints, 0, CLAST_VALIDATE_NODES);
        if (joint != CLAST_NONE && (f->roots[joint] == CLAST_NONE || !is_listed[f->roots[joint]])) {
            clast_validate_fault(v, CLAST_FAULT_NODE_SKIN_NO_SCENE, &node, "scene %zu has the mesh, but not its joints",
                                 scene_number);
        }
    }
}

static void check_scenes_of_skins(clast_validator *v, const forest *f)
{
    size_t count = clast_validate_size(v, CLAST_VALIDATE_NODES), scenes = clast_validate_size(v, CLAST_VALIDATE_SCENES);
    bool *is_listed = clast_allocate(v->context, count, sizeof *is_listed);
    if (is_listed == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < scenes && i < SCENES_MOST && clast_validate_size(v, CLAST_VALIDATE_SKINS) > 0; i++) {
        clast_gltf_value scene = clast_validate_entry(v, CLAST_VALIDATE_SCENES, i),
                         nodes = clast_gltf_member(&scene, "nodes");
        memset(is_listed, 0, count * sizeof *is_listed);
        for (size_t k = 0; k < clast_gltf_size(&nodes); k++) {
            uint32_t node = clast_validate_element_index(v, &nodes, k, CLAST_VALIDATE_NODES);
            if (node != CLAST_NONE) {
                is_listed[node] = true;
            }
        }
        check_scene_of_skins(v, i, f, is_listed);
    }
    clast_free(v->context, is_listed);
}

static void check_instances(clast_validator *v, const clast_gltf_value *node)
{
    clast_gltf_value extensions;
    clast_gltf_value instancing = clast_validate_extension(node, &extensions, "EXT_mesh_gpu_instancing");
    clast_gltf_value attributes = clast_gltf_member(&instancing, "attributes");
    const char *name;
    json_t *json;
    json_object_foreach(attributes.json, name, json)
    {
        clast_gltf_value place = {.around = &attributes, .name = name, .json = json};
        uint32_t accessor = clast_validate_index(v, &attributes, name, CLAST_VALIDATE_ACCESSORS);
        if (accessor != CLAST_NONE && v->accessors[accessor].components != 0) {
            clast_validate_use(v, &place, accessor, CLAST_USAGE_INSTANCES);
        }
    }
}

static void check_node(clast_validator *v, uint32_t index, const forest *f, bool *overridden)
{
    clast_gltf_value node = node_at(v, index), weights = clast_gltf_member(&node, "weights");
    uint32_t mesh = clast_validate_index(v, &node, "mesh", CLAST_VALIDATE_MESHES);
    uint32_t skin = clast_validate_index(v, &node, "skin", CLAST_VALIDATE_SKINS);
    check_instances(v, &node);
    if (mesh == CLAST_NONE) {
        return;
    }
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_MESHES, mesh);
    size_t targets = clast_validate_target_count(&value);
    bool has_joints = clast_validate_has_joints(&value);
    if (json_is_array(weights.json) && clast_gltf_size(&weights) != targets) {
        clast_validate_fault(v, CLAST_FAULT_NODE_WEIGHTS_INVALID, &weights, "%zu weights for %zu morph targets",
                             clast_gltf_size(&weights), targets);
    }
    overridden[mesh] = overridden[mesh] && weights.json != NULL;
    if (skin != CLAST_NONE && !has_joints) {
        clast_validate_fault(v, CLAST_FAULT_NODE_SKIN_WITH_NON_SKINNED_MESH, &node, "mesh %u has no joints", mesh);
    } else if (json_object_get(node.json, "skin") == NULL && has_joints) {
        clast_validate_fault(v, CLAST_FAULT_NODE_SKINNED_MESH_WITHOUT_SKIN, &node,
                             "mesh %u has joints, the node no skin", mesh);
    } else if (skin != CLAST_NONE) {
        check_skinned_node(v, index, &node, f);
    }
}

static void check_nodes(clast_validator *v, const forest *f)
{
    size_t meshes = clast_validate_size(v, CLAST_VALIDATE_MESHES);
    bool *overridden = clast_allocate(v->context, meshes,
                                      sizeof *overridden); // meshes whose weights every node has its own for
    if (overridden == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < meshes; i++) {
        overridden[i] = v->used[CLAST_VALIDATE_MESHES][i];
    }
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_NODES) && v->status == CLAST_OK; i++) {
        check_node(v, (uint32_t)i, f, overridden);
    }
    for (size_t i = 0; i < meshes; i++) {
        clast_gltf_value mesh = clast_validate_entry(v, CLAST_VALIDATE_MESHES, i),
                         weights = clast_gltf_member(&mesh, "weights");
        if (overridden[i] && weights.json != NULL) {
            clast_validate_fault(v, CLAST_FAULT_UNUSED_MESH_WEIGHTS, &weights, "every node has weights of its own");
        }
    }
    clast_free(v->context, overridden);
}

// -------------------------------------------------------------------------------------------------------------- skins

static void check_joints(clast_validator *v, const clast_gltf_value *skin, const forest *f)
{
    clast_gltf_value joints = clast_gltf_member(skin, "joints"), place = clast_gltf_member(skin, "skeleton");
    uint32_t skeleton = clast_validate_index(v, skin, "skeleton", CLAST_VALIDATE_NODES), root = CLAST_NONE;
    bool has_common_root = true, is_below = true;
    for (size_t i = 0; i < clast_gltf_size(&joints); i++) {
        uint32_t joint = clast_validate_element_index(v, &joints, i, CLAST_VALIDATE_NODES);
        uint32_t own = joint != CLAST_NONE ? f->roots[joint] : CLAST_NONE;
        has_common_root = has_common_root && own != CLAST_NONE && (i == 0 || own == root);
        root = i == 0 ? own : root;
        is_below = is_below && (own == CLAST_NONE || skeleton == CLAST_NONE || is_at_or_above(f, skeleton, joint));
    }
    if (!has_common_root) {
        clast_validate_fault(v, CLAST_FAULT_SKIN_NO_COMMON_ROOT, &joints, "the joints have no common root");
    }
    if (!is_below) {
        clast_validate_fault(v, CLAST_FAULT_SKIN_SKELETON_INVALID, &place, "node %u is not above all joints", skeleton);
    }
}

static void check_matrices(clast_validator *v, const clast_gltf_value *skin)
{
    clast_gltf_value place = clast_gltf_member(skin, "inverseBindMatrices"), joints = clast_gltf_member(skin, "joints");
    uint32_t index = clast_validate_index(v, skin, "inverseBindMatrices", CLAST_VALIDATE_ACCESSORS);
    if (index == CLAST_NONE || v->accessors[index].components == 0) {
        return;
    }
    const clast_validate_accessor *accessor = &v->accessors[index];
    clast_validate_use(v, &place, index, CLAST_USAGE_MATRICES);
    if (accessor->view != CLAST_NONE && v->views[accessor->view].stride != 0) {
        clast_validate_fault(v, CLAST_FAULT_SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE, &place, "view %u has a byteStride",
                             accessor->view);
    }
    if (accessor->columns != 4 || accessor->rows != 4 || accessor->component != CLAST_GLTF_FLOAT) {
        clast_validate_fault(v, CLAST_FAULT_SKIN_IBM_INVALID_FORMAT, &place, "expected matrices of 4 x 4 floats");
    }
    if (accessor->count < clast_gltf_size(&joints)) {
        clast_validate_fault(v, CLAST_FAULT_INVALID_IBM_ACCESSOR_COUNT, &place, "%llu matrices for %zu joints",
                             (unsigned long long)accessor->count, clast_gltf_size(&joints));
    }
}

static void check_skins(clast_validator *v, const forest *f)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_SKINS) && v->status == CLAST_OK; i++) {
        clast_gltf_value skin = clast_validate_entry(v, CLAST_VALIDATE_SKINS, i);
        if (clast_gltf_size(&(clast_gltf_value){.json = json_object_get(skin.json, "joints")}) > 0) {
            check_joints(v, &skin, f);
        }
        check_matrices(v, &skin);
    }
}

// ------------------------------------------------------------------------------------------------------------------ all

static void tell_unused(clast_validator *v)
{
    static const clast_validate_list lists[] = {
        CLAST_VALIDATE_ACCESSORS, CLAST_VALIDATE_BUFFERS,   CLAST_VALIDATE_BUFFER_VIEWS, CLAST_VALIDATE_CAMERAS,
        CLAST_VALIDATE_IMAGES,    CLAST_VALIDATE_MATERIALS, CLAST_VALIDATE_MESHES,       CLAST_VALIDATE_NODES,
        CLAST_VALIDATE_SAMPLERS,  CLAST_VALIDATE_SKINS,     CLAST_VALIDATE_TEXTURES,     CLAST_VALIDATE_LIGHTS};
    for (size_t l = 0; l < sizeof lists / sizeof *lists; l++) {
        for (size_t i = 0; i < clast_validate_size(v, lists[l]); i++) {
            clast_gltf_value value = clast_validate_entry(v, lists[l], i);
            if (!v->used[lists[l]][i]) {
                clast_validate_fault(v, CLAST_FAULT_UNUSED_OBJECT, &value, "nothing refers to it");
            }
        }
    }
}

void clast_validate_links(clast_validator *v)
{
    size_t count = clast_validate_size(v, CLAST_VALIDATE_NODES);
    if (v->status != CLAST_OK) {
        return;
    }
    forest f = {0};
    uint32_t *words = clast_allocate_zeroed(v->context, count, 5 * sizeof *words);
    v->parents = clast_allocate(v->context, count, sizeof *v->parents);
    f.is_moved = clast_allocate_zeroed(v->context, count, sizeof *f.is_moved);
    if (words == NULL || v->parents == NULL || f.is_moved == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
    } else {
        uint32_t **arrays[] = {&f.roots, &f.order, &f.stack, &f.numbers, &f.sizes};
        for (size_t i = 0; i < 5; i++) {
            *arrays[i] = words + i * count;
        }
        find_parents(v);
        check_scenes(v);
        number_nodes(v, &f);
        check_nodes(v, &f);
        check_scenes_of_skins(v, &f);
        check_skins(v, &f);
        clast_validate_animations(v);
        tell_unused(v);
    }
    clast_free(v->context, f.is_moved);
    clast_free(v->context, words);
}
