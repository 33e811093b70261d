// SPDX-License-Identifier: Apache-2.0
// What moves in a scene, and how it stands at a moment. Nodes are in an order in which each comes after its parent, so that
// one pass over them places them all.
#ifndef CLAST_SCENE_MOTION_H
#define CLAST_SCENE_MOTION_H

#include "clast/animation.h"
#include "scene/matrix.h"

// Where a node is relative to its parent, as animations move it.
typedef struct clast_node_parts {
    double translation[3], rotation[4], scale[3];
} clast_node_parts;

typedef struct clast_scene_node {
    uint32_t parent; // a lower number, or CLAST_NONE
    bool has_matrix; // which then says where it is; else the parts do
    clast_node_parts parts;
    clast_matrix matrix;
    clast_matrix to_world; // at rest
    uint32_t first_weight; // into clast_motion.weights
    uint32_t weight_count;
    char *name; // null where none
} clast_scene_node;

// An instance that hangs from a node. Sorted by instance.
typedef struct clast_attachment {
    uint32_t instance;
    uint32_t node;
    clast_transform in_node;
    packed3 offset; // added in world space: copies stand beside each other
} clast_attachment;

typedef struct clast_scene_animation {
    clast_channel *channels;
    size_t channel_count;
    double length;
    bool is_first; // of what a file brought
    char *name;
} clast_scene_animation;

typedef struct clast_skin {
    uint32_t *joints; // nodes
    clast_matrix *binds;
    uint32_t joint_count;
} clast_skin;

// A setting of renders, of a real number, that changes with time.
typedef struct clast_setting_keys {
    size_t offset;      // in clast_render_settings
    bool has_default;   // zero is not its default: CLAST_ZERO says zero
    const double *keys; // for each key time and value; times ascend
    size_t key_count;   // 1 or more
} clast_setting_keys;

typedef struct clast_motion {
    clast_scene_node *nodes;
    size_t node_count, node_capacity;
    uint32_t base;  // one more than the node that the nodes of a file are hung from; 0: none
    float *weights; // of all nodes, at rest
    size_t weight_count, weight_capacity;
    clast_attachment *attachments;
    size_t attachment_count, attachment_capacity;
    clast_scene_animation *animations;
    size_t animation_count, animation_capacity;
    clast_skin *skins;
    size_t skin_count, skin_capacity;
    clast_setting_keys *settings;
    size_t setting_count, setting_capacity;
    void **blocks; // that arrays of the above lie in, and arrays that several meshes share
    size_t block_count, block_capacity;
} clast_motion;

// What moves a mesh's vertices; all zero where nothing does.
typedef struct clast_deformation {
    uint32_t target_count;
    const clast_morph_target *targets;
    uint32_t weights_node; // whose weights count
    uint32_t influences;   // joints of each vertex; 0: no skin
    uint32_t skin;
    const uint16_t *joints;     // for each vertex: in the skin's list
    const float *joint_weights; // their sum is one, or zero
} clast_deformation;

static inline bool clast_deforms(const clast_deformation *deformation)
{
    return deformation->target_count != 0 || deformation->influences != 0;
}

// ------------------------------------------------------------------------------------------------- editing: node.c

void clast_motion_destroy(clast_context *context, clast_motion *motion);
// Keeps a block until the scene ends; frees it where this call fails.
clast_status clast_scene_keep_block(clast_scene *scene, void *block);
// From a node's space to its parent's.
clast_matrix clast_node_at_rest(const clast_scene_node *node);
// A node whose description has been checked; `name` is copied.
clast_status clast_scene_adopt_node(clast_scene *scene, const clast_scene_node *node, const char *name,
                                    uint32_t *number);
clast_attachment *clast_scene_find_attachment(clast_scene *scene, uint32_t instance);
// The first attachment that is not of an instance before `instance`.
size_t clast_motion_first_attachment(const clast_motion *motion, size_t instance);
// Where an attachment is while its node is there.
clast_transform clast_attachment_to_world(const clast_attachment *attachment, const clast_matrix *node);
// A camera or light at the origin of a node, along its -z.
clast_camera_desc clast_camera_at(const clast_camera_desc *camera, const clast_matrix *to_world);
clast_light clast_light_at(const clast_light *light, const clast_matrix *to_world);
// Adds a copy of an instance, moved by (x, 0, z). There must be room for it.
clast_status clast_scene_copy_instance(clast_scene *scene, size_t instance, float x, float z);
// Takes the instances from `first` on, which have no names, out of the scene.
void clast_scene_drop_instances(clast_scene *scene, size_t first);

// ---------------------------------------------------------------------------------------- animations: animation.c

// As clast_scene_add_animation, with arrays that the scene keeps already. is_first: of a file.
clast_status clast_scene_adopt_animation(clast_scene *scene, const clast_channel *channels, size_t count, bool is_first,
                                         const char *name, uint32_t *number);

// Which animations play, beside the number of a single one.
#define CLAST_ANIMATION_FIRST (CLAST_NONE - 2u) // the first of each file
#define CLAST_ANIMATION_ALL (CLAST_NONE - 1u)
#define CLAST_ANIMATION_REST CLAST_NONE

typedef struct clast_moment {
    uint32_t animation;
    double time; // seconds
} clast_moment;

// The animations that a setting names: "" the first of each file, a number, a name, "all" or "none".
clast_status clast_scene_choose_animation(const clast_scene *scene, const char *text, uint32_t *animation);

typedef struct clast_posed_node {
    clast_node_parts parts;
    clast_matrix to_world;
} clast_posed_node;

// All nodes and weights at a moment. `nodes` has room for the scene's nodes, `weights` for its weights.
void clast_scene_pose(const clast_scene *scene, clast_moment moment, clast_posed_node *nodes, float *weights);

// Unit length, for 0 <= t <= 1, along the shorter arc between two quaternions.
void clast_slerp(const double from[4], const double to[4], double t, double result[4]);

// ------------------------------------------------------------------------------------- vertices that move: deform.c

// As the public functions, with arrays that the scene keeps already, and which have been checked.
clast_status clast_scene_adopt_morph(clast_scene *scene, uint32_t geometry, const clast_morph_target *targets,
                                     uint32_t count, uint32_t node);
clast_status clast_scene_adopt_skinning(clast_scene *scene, uint32_t geometry, uint32_t skin, uint32_t influences,
                                        const uint16_t *joints, const float *weights);
// Makes the sum of each vertex's weights one where it is not zero. False where a joint or weight is out of range: *wrong
// says which of all.
bool clast_weigh_joints(const uint16_t *joints, float *weights, size_t vertex_count, uint32_t influences,
                        uint32_t joint_count, size_t *wrong);

// Where the joints of a skin take vertices; `nodes` null: at rest. False where that is not finite.
bool clast_scene_pose_joints(const clast_scene *scene, uint32_t skin, const clast_posed_node *nodes,
                             clast_transform *joints);

struct clast_geometry;

// The vertices of a mesh at a moment.
typedef struct clast_deform_job {
    const struct clast_geometry *geometry;
    const clast_transform *joints; // of its skin
    const float *weights;          // of its morph targets
    size_t first;                  // the vertex that the arrays below begin with
    packed3 *positions;
    packed3 *normals;  // null where they are not wanted
    packed4 *tangents; // likewise
} clast_deform_job;

// Makes vertices [begin, end). False where one is not finite.
bool clast_deform(const clast_deform_job *job, size_t begin, size_t end);
// The box of a mesh's vertices at rest.
clast_box clast_deformed_box(const clast_scene *scene, const struct clast_geometry *geometry);

#endif
