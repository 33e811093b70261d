// SPDX-License-Identifier: Apache-2.0
// The scene graph (section 3.5): nodes become instances, cameras and lights with world transforms, and, where anything in
// the file moves, nodes of the scene that these hang from. Nodes form strict trees; that is checked first, so the walk is a
// loop that meets each node once, however deep.
#include <float.h>
#include <math.h>
#include <string.h>

#include "load/gltf.h"

typedef struct walk {
    clast_gltf *gltf;
    uint32_t node_count;
    uint32_t base;          // the scene's node that roots hang from; CLAST_NONE
    uint32_t *parents;      // CLAST_NONE for roots
    clast_matrix *to_world; // of each node
    uint32_t *stack;        // nodes still to visit: each at most once
    size_t stack_size;
} walk;

// ---------------------------------------------------------------------------------------------------------- transforms

static clast_node_parts parts_of(const float translation[3], const float rotation[4], const float scale[3])
{
    clast_node_parts parts;
    for (int i = 0; i < 4; i++) {
        parts.rotation[i] = (double)rotation[i];
    }
    for (int i = 0; i < 3; i++) {
        parts.translation[i] = (double)translation[i];
        parts.scale[i] = (double)scale[i];
    }
    return parts;
}

// A matrix by columns, without its last row.
static clast_matrix from_columns(const float columns[16])
{
    clast_matrix result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            result.rows[i][j] = (double)columns[4 * j + i];
        }
    }
    return result;
}

static clast_matrix read_matrix(clast_gltf *gltf, const clast_gltf_value *node, const float columns[16])
{
    if (columns[3] != 0.0f || columns[7] != 0.0f || columns[11] != 0.0f || columns[15] != 1.0f) {
        clast_gltf_value place = clast_gltf_member(node, "matrix");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "the last row is %g %g %g %g: expected 0 0 0 1",
                        (double)columns[3], (double)columns[7], (double)columns[11], (double)columns[15]);
    }
    return from_columns(columns);
}

// Where a node is relative to its parent.
static clast_scene_node read_place(clast_gltf *gltf, const clast_gltf_value *node)
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
    clast_scene_node result = {
        .parent = CLAST_NONE, .has_matrix = has_matrix, .parts = parts_of(translation, rotation, scale)};
    if (has_matrix) {
        result.matrix = read_matrix(gltf, node, columns);
    }
    return result;
}

// As floats; false, with its error, where they do not hold it.
static bool to_floats(clast_gltf *gltf, const clast_gltf_value *node, const clast_matrix *from, float floats[12])
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

// Where an instance of a node's mesh goes.
typedef struct placement {
    uint32_t node;        // of the scene, that it hangs from; CLAST_NONE
    clast_matrix to_node; // the parent's space is that node's, or the world
} placement;

static void add_instances(clast_gltf *gltf, const clast_gltf_value *node, uint32_t first, uint32_t count,
                          const placement *place)
{
    float floats[12];
    const char *name = clast_gltf_text(gltf, node, "name");
    if (!clast_gltf_ok(gltf) || !to_floats(gltf, node, &place->to_node, floats)) {
        return;
    }
    for (uint32_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        uint32_t geometry = gltf->geometries[first + i], number;
        if (geometry != CLAST_NONE &&
            clast_gltf_check(gltf, clast_scene_add_instance(gltf->scene, geometry, floats, name, &number)) &&
            place->node != CLAST_NONE) {
            clast_gltf_check(gltf, clast_scene_attach_instance(gltf->scene, number, place->node));
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
                               const placement *place)
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
        clast_node_parts parts = parts_of(translations != NULL ? translations + 3 * i : none,
                                          rotations != NULL ? rotations + 4 * i : still,
                                          scales != NULL ? scales + 3 * i : one);
        clast_matrix local = clast_matrix_compose(parts.translation, parts.rotation, parts.scale);
        placement moved = {place->node, clast_matrix_product(&place->to_node, &local)};
        add_instances(gltf, node, first, count, &moved);
    }
    clast_free(gltf->context, translations);
    clast_free(gltf->context, rotations);
    clast_free(gltf->context, scales);
    return true;
}

static bool any_weight(const float *weights, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (weights[i] != 0.0f) {
            return true;
        }
    }
    return false;
}

// Gives the scene's node the weights that count at rest: its own, the mesh's, or zeros where an animation sets them.
static void read_weights(clast_gltf *gltf, const clast_gltf_value *node, uint32_t index, uint32_t mesh,
                         clast_gltf_use *use)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_MESHES, mesh);
    size_t count = 0, mesh_count = 0;
    float *own = clast_gltf_read_weights(gltf, node, &count);
    float *given = clast_gltf_ok(gltf) ? clast_gltf_read_weights(gltf, &value, &mesh_count) : NULL;
    bool moves = gltf->weights_move[index], mesh_counts = any_weight(given, given != NULL ? mesh_count : 0);
    use->is_own = use->is_own || moves || (own != NULL && (mesh_counts || any_weight(own, count)));
    use->has_weights = moves || (own != NULL ? any_weight(own, count) : mesh_counts);
    count = own != NULL ? count : given != NULL ? mesh_count : moves ? clast_gltf_count_targets(gltf, mesh) : 0;
    float *zeros = own == NULL && given == NULL && count != 0
                       ? clast_allocate_zeroed(gltf->context, count, sizeof *zeros)
                       : NULL;
    const float *weights = own != NULL ? own : given != NULL ? given : zeros;
    if (clast_gltf_ok(gltf) && count != 0 && weights == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    if (clast_gltf_ok(gltf) && use->has_weights && count != 0) {
        clast_gltf_check(gltf, clast_scene_set_node_weights(gltf->scene, use->node, weights, (uint32_t)count));
    }
    use->has_weights = use->has_weights && count != 0;
    clast_free(gltf->context, own);
    clast_free(gltf->context, given);
    clast_free(gltf->context, zeros);
}

static void add_mesh(walk *walk, const clast_gltf_value *node, uint32_t index)
{
    clast_gltf *gltf = walk->gltf;
    uint32_t mesh = clast_gltf_index(gltf, node, "mesh", CLAST_GLTF_MESHES), first, count;
    uint32_t skin = clast_gltf_index(gltf, node, "skin", CLAST_GLTF_SKINS);
    if (!clast_gltf_ok(gltf) || mesh == CLAST_NONE) {
        return;
    }
    clast_gltf_use use = {.skin = skin, .is_own = skin != CLAST_NONE, .node = CLAST_NONE};
    placement place = {CLAST_NONE, walk->to_world[index]};
    if (gltf->node_numbers != NULL) {
        use.node = gltf->node_numbers[index];
        read_weights(gltf, node, index, mesh, &use);
        place = (placement){skin == CLAST_NONE ? use.node : CLAST_NONE, clast_matrix_identity()};
    }
    // The joints move a skinned mesh, and its own node does not (section 3.7.3.3).
    if (clast_gltf_ok(gltf) && clast_gltf_use_mesh(gltf, mesh, &use, &first, &count) &&
        !add_many_instances(gltf, node, first, count, &place)) {
        add_instances(gltf, node, first, count, &place);
    }
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

// Keeps a node in the scene; what it hangs from is kept already.
static void keep_node(walk *walk, uint32_t index, const clast_gltf_value *value, const clast_scene_node *place)
{
    clast_gltf *gltf = walk->gltf;
    clast_scene_node node = *place;
    uint32_t parent = walk->parents[index];
    node.parent = parent != CLAST_NONE ? gltf->node_numbers[parent] : walk->base;
    const char *name = clast_gltf_text(gltf, value, "name");
    if (clast_gltf_ok(gltf)) {
        clast_gltf_check(gltf, clast_scene_adopt_node(gltf->scene, &node, name, &gltf->node_numbers[index]));
    }
}

// The transform of every node to world space, parents first.
static void find_transforms(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    const clast_matrix *base = walk->base != CLAST_NONE ? &gltf->scene->motion.nodes[walk->base].to_world : NULL;
    clast_matrix root = base != NULL ? *base : clast_matrix_identity();
    for (uint32_t i = walk->node_count; i-- > 0;) {
        if (walk->parents[i] == CLAST_NONE) {
            walk->stack[walk->stack_size++] = i;
        }
    }
    while (walk->stack_size > 0 && clast_gltf_ok(gltf)) {
        uint32_t index = walk->stack[--walk->stack_size];
        clast_gltf_value node = clast_gltf_entry(gltf, CLAST_GLTF_NODES, index);
        clast_scene_node place = read_place(gltf, &node);
        clast_matrix local = clast_node_at_rest(&place);
        uint32_t parent = walk->parents[index];
        walk->to_world[index] = clast_matrix_product(parent != CLAST_NONE ? &walk->to_world[parent] : &root, &local);
        float floats[12];
        if (clast_gltf_ok(gltf) && to_floats(gltf, &node, &walk->to_world[index], floats)) {
            if (gltf->node_numbers != NULL) {
                keep_node(walk, index, &node, &place);
            }
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
        uint32_t number = gltf->node_numbers != NULL ? gltf->node_numbers[index] : CLAST_NONE;
        add_mesh(walk, &node, index);
        clast_gltf_add_camera(gltf, &node, number, &walk->to_world[index]);
        clast_gltf_add_light(gltf, &node, number, &walk->to_world[index]);
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

static void read_nodes(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    bool moves = false;
    memset(walk->parents, 0xff, walk->node_count * sizeof *walk->parents);
    if (!find_parents(walk) || !check_cycles(walk) || !clast_gltf_find_motion(gltf, &moves)) {
        return;
    }
    if (moves) {
        walk->base = gltf->scene->motion.base - 1;
        gltf->node_numbers = clast_allocate(gltf->context, walk->node_count, sizeof *gltf->node_numbers);
        clast_gltf_check(gltf, gltf->node_numbers != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    }
    if (clast_gltf_ok(gltf)) {
        find_transforms(walk);
    }
    if (clast_gltf_ok(gltf)) {
        walk_scene(walk);
    }
}

void clast_gltf_read_nodes(clast_gltf *gltf)
{
    clast_context *context = gltf->context;
    walk walk = {
        .gltf = gltf, .node_count = (uint32_t)clast_gltf_size(&gltf->lists[CLAST_GLTF_NODES]), .base = CLAST_NONE};
    walk.parents = clast_allocate(context, walk.node_count, sizeof *walk.parents);
    walk.to_world = walk.parents != NULL ? clast_allocate(context, walk.node_count, sizeof *walk.to_world) : NULL;
    walk.stack = walk.to_world != NULL ? clast_allocate(context, walk.node_count, sizeof *walk.stack) : NULL;
    if (walk.stack == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    } else {
        read_nodes(&walk);
    }
    clast_free(context, walk.stack);
    clast_free(context, walk.to_world);
    clast_free(context, walk.parents);
}
