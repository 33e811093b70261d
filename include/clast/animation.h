/* SPDX-License-Identifier: Apache-2.0
 *
 * What moves in a scene: nodes that instances, lights and cameras hang from; animations of nodes; meshes whose vertices
 * follow nodes (skins) and weights (morph targets). It is glTF 2.0's model, and scenes from glTF files come with it; the
 * functions here make it without a file. The settings `time` and `animation` of a render choose the moment.
 *
 * What is given here is the scene at rest: a render without an animation shows that. All arrays are copied.
 */
#ifndef CLAST_ANIMATION_H
#define CLAST_ANIMATION_H

#include "clast/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum clast_animated { CLAST_ANIMATED_LIST(CLAST_ENUMERATOR) } clast_animated;
typedef enum clast_interpolation { CLAST_INTERPOLATION_LIST(CLAST_ENUMERATOR) } clast_interpolation;

/* -------------------------------------------------------------------------------------------------------------- nodes */

/** A node: a place relative to another. A point goes to translation + rotation (scale point), then to the parent. */
typedef struct clast_node_desc {
    uint32_t parent; /**< a node added before, or CLAST_NONE */
    float translation[3];
    float rotation[4];   /**< a quaternion x, y, z, w of any length; all zero turns nothing */
    float scale[3];      /**< all zero is 1, 1, 1 */
    const float *matrix; /**< three rows of four in place of these, or null; such a node cannot be animated */
} clast_node_desc;

/** Adds a node. `name` may be null. Errors: INVALID_ARGUMENT (not finite, no such parent), LIMIT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_scene_add_node(clast_scene *scene, const clast_node_desc *node, const char *name,
                                            uint32_t *number);
/** Places a node anew; its parent stays what it was. A node that an animation moves must not get a matrix. */
CLAST_API clast_status clast_scene_set_node(clast_scene *scene, uint32_t number, const clast_node_desc *node);
/** The weights of morph targets of the meshes that follow the node (clast_scene_set_mesh_morph). The first call decides how
 *  many there are; later ones give as many. */
CLAST_API clast_status clast_scene_set_node_weights(clast_scene *scene, uint32_t number, const float *weights,
                                                    uint32_t count);

/** Hangs an instance from a node: from now on its transform is relative to the node's. */
CLAST_API clast_status clast_scene_attach_instance(clast_scene *scene, uint32_t instance, uint32_t node);
/** Hangs a light from a node: it stands at the node's origin and shines along its -z. */
CLAST_API clast_status clast_scene_attach_light(clast_scene *scene, uint32_t light, uint32_t node);
/** Hangs a camera from a node: it stands at the node's origin and looks along its -z, with its y up. */
CLAST_API clast_status clast_scene_attach_camera(clast_scene *scene, uint32_t camera, uint32_t node);

/* --------------------------------------------------------------------------------------------------------- animations */

/** How one property of a node changes. Before its first key and after its last it stands still. */
typedef struct clast_channel {
    uint32_t node;
    clast_animated animated;
    clast_interpolation interpolation;
    uint32_t key_count; /**< 1 or more */
    const float *times; /**< seconds, ascending, 0 or more */
    /** For each key the property's numbers: 3 (translation, scale), 4 (rotation: x, y, z, w) or as many as the node has
     *  weights. With CLAST_INTERPOLATION_CUBICSPLINE three times as many: the tangent before, the value, the tangent after. */
    const float *values;
} clast_channel;

/** Adds an animation: channels that play together. It lasts to its last key and then begins again.
 *  Errors: INVALID_ARGUMENT (names the channel: times that do not ascend, values that are not finite, a node with a matrix or
 *  without weights, two channels for one property), OUT_OF_MEMORY. */
CLAST_API clast_status clast_scene_add_animation(clast_scene *scene, const clast_channel *channels, size_t count,
                                                 const char *name, uint32_t *number);
/** How long an animation lasts, in seconds; 0 where there is none of that number. */
CLAST_API double clast_scene_animation_length(const clast_scene *scene, uint32_t number);

/* ---------------------------------------------------------------------------------------------- vertices that move */

/** Adds a geometry that shares the arrays of a mesh, and gives its number: for a skin, or weights, of its own. */
CLAST_API clast_status clast_scene_share_mesh(clast_scene *scene, uint32_t geometry, const char *name,
                                              uint32_t *number);

/** Displacements of a mesh's vertices, 3 numbers for each vertex; null where there are none. */
typedef struct clast_morph_target {
    const float *positions, *normals, *tangents;
} clast_morph_target;

/** Gives a mesh morph targets: to each vertex the displacements are added, times the weights of `node`, which must have as
 *  many. Count 0 takes them away. Normals and tangents get unit length again. */
CLAST_API clast_status clast_scene_set_mesh_morph(clast_scene *scene, uint32_t geometry,
                                                  const clast_morph_target *targets, uint32_t count, uint32_t node);

/** Joints that vertices follow. */
typedef struct clast_skin_desc {
    uint32_t joint_count;   /**< 1 to 65536 */
    const uint32_t *joints; /**< nodes */
    /** For each joint three rows of four: from the mesh's space to the joint's, as they were bound; null: all identity. */
    const float *inverse_binds;
} clast_skin_desc;
CLAST_API clast_status clast_scene_add_skin(clast_scene *scene, const clast_skin_desc *skin, uint32_t *number);

/** Makes a mesh follow a skin, after its morph targets: a vertex goes to the mean of where its joints take it, by weight, in
 *  world space; the transforms of its instances come after that. Vertices whose weights are all zero stay.
 *  `influences` joints (numbers in the skin) and weights (0 or more) for each vertex; 0 takes the skin away. */
CLAST_API clast_status clast_scene_set_mesh_skin(clast_scene *scene, uint32_t geometry, uint32_t skin,
                                                 uint32_t influences, const uint16_t *joints, const float *weights);

#ifdef __cplusplus
}
#endif

#endif
