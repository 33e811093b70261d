// SPDX-License-Identifier: Apache-2.0
// The scene graph (section 3.5): nodes become instances, cameras and lights with world transforms. Nodes form strict trees;
// that is checked first, so the walk is a loop that meets each node once, however deep.
#include <float.h>
#include <math.h>
#include <string.h>

#include "load/gltf.h"

static const float HALF_TURN = 3.14159265f;

// Three rows of four, x' = row . (x, y, z, 1), in double precision: deep trees far from the origin keep their places.
typedef struct transform {
    double rows[3][4];
} transform;

typedef struct walk_step {
    uint32_t node;
    transform to_world;
} walk_step;

typedef struct walk {
    clast_gltf *gltf;
    uint32_t node_count;
    uint32_t *parents; // CLAST_NONE for roots
    walk_step *steps;  // nodes still to visit
    size_t step_count, step_capacity;
    clast_gltf_value lights_extension, lights_object, lights;
} walk;

// ---------------------------------------------------------------------------------------------------------- transforms

static transform identity(void)
{
    return (transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

// a after b.
static transform product(const transform *a, const transform *b)
{
    transform result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            const double *row = a->rows[i];
            result.rows[i][j] = row[0] * b->rows[0][j] + row[1] * b->rows[1][j] + row[2] * b->rows[2][j] + (j == 3 ? row[3] : 0.0);
        }
    }
    return result;
}

// Translation after rotation after scale (section 3.5.3). The quaternion is made unit length.
static transform compose(const float translation[3], const float rotation[4], const float scale[3])
{
    double x = (double)rotation[0], y = (double)rotation[1], z = (double)rotation[2], w = (double)rotation[3];
    double square = x * x + y * y + z * z + w * w;
    double s = square > 0.0 ? 2.0 / square : 0.0;
    double turn[3][3] = {
        {1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
        {s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)},
        {s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)},
    };
    transform result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            result.rows[i][j] = turn[i][j] * (double)scale[j];
        }
        result.rows[i][3] = (double)translation[i];
    }
    return result;
}

static transform read_matrix(clast_gltf *gltf, const clast_gltf_value *node, const float columns[16])
{
    transform result = identity();
    if (columns[3] != 0.0f || columns[7] != 0.0f || columns[11] != 0.0f || columns[15] != 1.0f) {
        clast_gltf_value place = clast_gltf_member(node, "matrix");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "the last row is %g %g %g %g: expected 0 0 0 1", (double)columns[3],
                        (double)columns[7], (double)columns[11], (double)columns[15]);
        return result;
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            result.rows[i][j] = (double)columns[4 * j + i];
        }
    }
    return result;
}

static transform local_transform(clast_gltf *gltf, const clast_gltf_value *node)
{
    float columns[16] = {0}, translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    bool has_matrix = clast_gltf_numbers(gltf, node, "matrix", 16, -FLT_MAX, FLT_MAX, columns);
    bool has_parts = clast_gltf_numbers(gltf, node, "translation", 3, -FLT_MAX, FLT_MAX, translation);
    has_parts |= clast_gltf_numbers(gltf, node, "rotation", 4, -FLT_MAX, FLT_MAX, rotation);
    has_parts |= clast_gltf_numbers(gltf, node, "scale", 3, -FLT_MAX, FLT_MAX, scale);
    if (has_matrix && has_parts) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, node, "both matrix and translation, rotation or scale: expected one of the two");
    }
    if (rotation[0] == 0.0f && rotation[1] == 0.0f && rotation[2] == 0.0f && rotation[3] == 0.0f) {
        clast_gltf_value place = clast_gltf_member(node, "rotation");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "zero: expected a unit quaternion");
    }
    return has_matrix ? read_matrix(gltf, node, columns) : compose(translation, rotation, scale);
}

// As floats; false, with its error, where they do not hold it.
static bool to_floats(clast_gltf *gltf, const clast_gltf_value *node, const transform *from, float floats[12])
{
    for (int i = 0; i < 12; i++) {
        floats[i] = (float)from->rows[i / 4][i % 4];
        if (!is_finite1(floats[i])) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, node, "the transform to world space is not finite");
        }
    }
    return true;
}

// ----------------------------------------------------------------------------------------------------- cameras, lights

// A column of a transform, without its scale.
static void axis(const transform *to_world, int column, double sign, float out[3])
{
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        length += to_world->rows[i][column] * to_world->rows[i][column];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++) {
        out[i] = length > 0.0 ? (float)(sign * to_world->rows[i][column] / length) : 0.0f;
    }
}

static void read_projection(clast_gltf *gltf, const clast_gltf_value *value, clast_camera_desc *camera)
{
    const char *type = clast_gltf_text(gltf, value, "type");
    bool is_perspective = type != NULL && strcmp(type, "perspective") == 0;
    if (!is_perspective && (type == NULL || strcmp(type, "orthographic") != 0)) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "type \"%.40s\": expected perspective or orthographic", type != NULL ? type : "");
        return;
    }
    clast_gltf_value part = clast_gltf_object(gltf, value, is_perspective ? "perspective" : "orthographic");
    if (clast_gltf_ok(gltf) && part.json == NULL) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &part, "missing: expected an object");
    }
    camera->near_plane = clast_gltf_number(gltf, &part, "znear", 0.0f, FLT_MAX, 0.0f);
    camera->far_plane = clast_gltf_number(gltf, &part, "zfar", 0.0f, FLT_MAX, 0.0f);
    if (is_perspective) {
        camera->projection = CLAST_PROJECTION_PERSPECTIVE;
        camera->vertical_angle = clast_gltf_number(gltf, &part, "yfov", FLT_MIN, HALF_TURN - 1e-3f, 0.8f);
    } else {
        camera->projection = CLAST_PROJECTION_ORTHOGRAPHIC;
        camera->height = 2.0f * fabsf(clast_gltf_number(gltf, &part, "ymag", -FLT_MAX / 4.0f, FLT_MAX / 4.0f, 0.0f));
        if (clast_gltf_ok(gltf) && camera->height == 0.0f) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &part, "ymag: expected half the height of what is seen, not 0");
        }
    }
}

// Cameras look along -z with y up; scale does not act on them (section 3.10.2). The aspect ratio is the picture's.
static void add_camera(clast_gltf *gltf, const clast_gltf_value *node, uint32_t index, const transform *to_world)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_CAMERAS, index);
    clast_camera_desc camera = {0};
    read_projection(gltf, &value, &camera);
    const char *name = clast_gltf_text(gltf, node, "name");
    if (name == NULL) {
        name = clast_gltf_text(gltf, &value, "name");
    }
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    float forward[3];
    axis(to_world, 2, -1.0, forward);
    axis(to_world, 1, 1.0, camera.up);
    double reach = 1.0; // far enough that position and target differ as floats
    for (int i = 0; i < 3; i++) {
        reach = fmax(reach, fabs(to_world->rows[i][3]));
    }
    for (int i = 0; i < 3; i++) {
        camera.position[i] = (float)to_world->rows[i][3];
        camera.target[i] = (float)(to_world->rows[i][3] + (double)forward[i] * reach);
    }
    if (forward[0] == 0.0f && forward[1] == 0.0f && forward[2] == 0.0f) {
        clast_gltf_warn(gltf, node, "the camera's direction is scaled to nothing: left out");
        return;
    }
    uint32_t number;
    clast_gltf_check(gltf, clast_scene_add_camera(gltf->scene, &camera, name, &number));
}

static bool read_light_type(clast_gltf *gltf, const clast_gltf_value *value, clast_light_type *type)
{
    static const char *const names[] = {
#define NAME(name, value, text) [value] = text,
        CLAST_LIGHT_LIST(NAME)
#undef NAME
    };
    const char *text = clast_gltf_text(gltf, value, "type");
    for (size_t i = 0; text != NULL && i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], text) == 0) {
            *type = (clast_light_type)i;
            return true;
        }
    }
    return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "type \"%.40s\": expected point, spot or directional", text != NULL ? text : "");
}

// KHR_lights_punctual. Lights shine along -z.
static void add_light(walk *walk, const clast_gltf_value *node, const transform *to_world)
{
    clast_gltf *gltf = walk->gltf;
    clast_gltf_value extensions;
    clast_gltf_value use = clast_gltf_extension(gltf, node, &extensions, "KHR_lights_punctual");
    if (use.json == NULL) {
        return;
    }
    uint64_t count = clast_gltf_size(&walk->lights);
    uint64_t index = clast_gltf_integer(gltf, &use, "light", 0, count != 0 ? count - 1 : 0, CLAST_GLTF_REQUIRED);
    if (clast_gltf_ok(gltf) && count == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &use, "the file has no lights: expected extensions.KHR_lights_punctual.lights");
    }
    clast_light_desc light = {.colour = {1, 1, 1}};
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    clast_gltf_value value = clast_gltf_element_object(gltf, &walk->lights, (size_t)index);
    if (!clast_gltf_ok(gltf) || !read_light_type(gltf, &value, &light.type)) {
        return;
    }
    clast_gltf_numbers(gltf, &value, "color", 3, 0.0f, FLT_MAX, light.colour);
    light.intensity = clast_gltf_number(gltf, &value, "intensity", 0.0f, FLT_MAX, 1.0f);
    light.range = clast_gltf_number(gltf, &value, "range", 0.0f, FLT_MAX, 0.0f);
    if (light.type == CLAST_LIGHT_SPOT) {
        clast_gltf_value cone = clast_gltf_object(gltf, &value, "spot");
        light.outer_angle = clast_gltf_number(gltf, &cone, "outerConeAngle", 0.0f, HALF_TURN / 2.0f, HALF_TURN / 4.0f);
        light.inner_angle = clast_gltf_number(gltf, &cone, "innerConeAngle", 0.0f, light.outer_angle, 0.0f);
    }
    const char *name = clast_gltf_text(gltf, node, "name");
    name = name != NULL ? name : clast_gltf_text(gltf, &value, "name");
    axis(to_world, 2, -1.0, light.direction);
    for (int i = 0; i < 3; i++) {
        light.position[i] = (float)to_world->rows[i][3];
    }
    if (light.type != CLAST_LIGHT_POINT && light.direction[0] == 0.0f && light.direction[1] == 0.0f && light.direction[2] == 0.0f) {
        clast_gltf_warn(gltf, node, "the light's direction is scaled to nothing: left out");
        return;
    }
    uint32_t number;
    if (clast_gltf_ok(gltf)) {
        clast_gltf_check(gltf, clast_scene_add_light(gltf->scene, &light, name, &number));
    }
}

// ----------------------------------------------------------------------------------------------------------- instances

static void add_instances(clast_gltf *gltf, const clast_gltf_value *node, uint32_t first, uint32_t count, const transform *to_world)
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
static float *read_instances(clast_gltf *gltf, const clast_gltf_value *attributes, const char *name, uint32_t components, uint32_t rows,
                             uint64_t *count)
{
    clast_gltf_value place = clast_gltf_member(attributes, name);
    clast_gltf_accessor accessor;
    if (place.json == NULL || !clast_gltf_ok(gltf)) {
        return NULL;
    }
    uint32_t index = clast_gltf_value_index(gltf, &place, CLAST_GLTF_ACCESSORS);
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, &place, index, &accessor) ||
        !clast_gltf_accessor_is(gltf, &place, &accessor, components, 1, rows)) {
        return NULL;
    }
    if (*count != 0 && *count != accessor.count) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "%llu elements: expected %llu, as the others have",
                        (unsigned long long)accessor.count, (unsigned long long)*count);
        return NULL;
    }
    float *floats = clast_allocate(gltf->context, accessor.count, rows * sizeof *floats);
    if (floats == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    clast_gltf_read_floats(&accessor, floats);
    *count = accessor.count;
    return floats;
}

// EXT_mesh_gpu_instancing: false where the node does not have it.
static bool add_many_instances(clast_gltf *gltf, const clast_gltf_value *node, uint32_t first, uint32_t count, const transform *to_world)
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
    for (size_t i = 0; i < many && clast_gltf_ok(gltf); i++) {
        transform local = compose(translations != NULL ? translations + 3 * i : none, rotations != NULL ? rotations + 4 * i : still,
                                  scales != NULL ? scales + 3 * i : one);
        transform whole = product(to_world, &local);
        add_instances(gltf, node, first, count, &whole);
    }
    clast_free(gltf->context, translations);
    clast_free(gltf->context, rotations);
    clast_free(gltf->context, scales);
    return true;
}

static void add_mesh(clast_gltf *gltf, const clast_gltf_value *node, const transform *to_world)
{
    uint32_t mesh = clast_gltf_index(gltf, node, "mesh", CLAST_GLTF_MESHES), first, count;
    uint32_t skin = clast_gltf_index(gltf, node, "skin", CLAST_GLTF_SKINS);
    if (!clast_gltf_ok(gltf) || mesh == CLAST_NONE || !clast_gltf_use_mesh(gltf, mesh, &first, &count)) {
        return;
    }
    transform still = identity();
    // The joints move a skinned mesh, and its own node does not (section 3.7.3.3).
    const transform *place = skin != CLAST_NONE ? &still : to_world;
    if (!add_many_instances(gltf, node, first, count, place)) {
        add_instances(gltf, node, first, count, place);
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
                clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &element, "node %u is a child of node %u too: expected one parent", child,
                                walk->parents[child]);
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

// With one parent each, nodes that no root leads to are in cycles, or below one. Going up from a node for as many steps as
// there are nodes would be quadratic; `state` remembers which are known to end at a root.
static bool check_cycles(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    unsigned char *state = clast_allocate_zeroed(gltf->context, walk->node_count, 1); // 1: on the way up, 2: ends at a root
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

static bool push(walk *walk, uint32_t node, const transform *to_world)
{
    clast_context *context = walk->gltf->context;
    if (!clast_gltf_check(walk->gltf, CLAST_RESERVE(context, walk->steps, walk->step_capacity, walk->step_count + 1))) {
        return false;
    }
    walk->steps[walk->step_count++] = (walk_step){node, *to_world};
    return true;
}

static void visit(walk *walk, const walk_step *step)
{
    clast_gltf *gltf = walk->gltf;
    clast_gltf_value node = clast_gltf_entry(gltf, CLAST_GLTF_NODES, step->node);
    transform local = local_transform(gltf, &node);
    transform to_world = product(&step->to_world, &local);
    float floats[12];
    if (!clast_gltf_ok(gltf) || !to_floats(gltf, &node, &to_world, floats)) {
        return;
    }
    add_mesh(gltf, &node, &to_world);
    uint32_t camera = clast_gltf_index(gltf, &node, "camera", CLAST_GLTF_CAMERAS);
    if (clast_gltf_ok(gltf) && camera != CLAST_NONE) {
        add_camera(gltf, &node, camera, &to_world);
    }
    add_light(walk, &node, &to_world);
    clast_gltf_value children = clast_gltf_array(gltf, &node, "children");
    for (size_t k = clast_gltf_size(&children); k-- > 0 && clast_gltf_ok(gltf);) { // pushed backwards: visited in order
        clast_gltf_value element = clast_gltf_element(&children, k);
        push(walk, clast_gltf_value_index(gltf, &element, CLAST_GLTF_NODES), &to_world);
    }
}

static void walk_from(walk *walk, uint32_t root)
{
    transform still = identity();
    walk->step_count = 0;
    push(walk, root, &still);
    while (clast_gltf_ok(walk->gltf) && walk->step_count > 0) {
        walk_step step = walk->steps[--walk->step_count];
        visit(walk, &step);
    }
}

// The roots of the default scene; without `scene` the first one, and without scenes every root, as viewers do.
static void walk_scene(walk *walk)
{
    clast_gltf *gltf = walk->gltf;
    uint32_t index = clast_gltf_index(gltf, &gltf->root, "scene", CLAST_GLTF_SCENES);
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
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &element, "node %u is below another, or listed twice: expected a root", node);
        }
        if (clast_gltf_ok(gltf)) {
            walk->parents[node] = node; // not to be listed again
            walk_from(walk, node);
        }
    }
}

void clast_gltf_read_nodes(clast_gltf *gltf)
{
    walk walk = {.gltf = gltf, .node_count = (uint32_t)clast_gltf_size(&gltf->lists[CLAST_GLTF_NODES])};
    walk.parents = clast_allocate(gltf->context, walk.node_count, sizeof *walk.parents);
    if (walk.parents == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return;
    }
    memset(walk.parents, 0xff, walk.node_count * sizeof *walk.parents);
    walk.lights_extension = clast_gltf_object(gltf, &gltf->root, "extensions");
    walk.lights_object = clast_gltf_object(gltf, &walk.lights_extension, "KHR_lights_punctual");
    walk.lights = clast_gltf_array(gltf, &walk.lights_object, "lights");
    if (clast_gltf_ok(gltf) && find_parents(&walk) && check_cycles(&walk)) {
        walk_scene(&walk);
    }
    clast_free(gltf->context, walk.steps);
    clast_free(gltf->context, walk.parents);
}
