// SPDX-License-Identifier: Apache-2.0
// What of a scene moves, as a frame holds it.
#ifndef CLAST_FRAME_POSE_H
#define CLAST_FRAME_POSE_H

#include "scene/scene.h"

// Nodes, weights and lights at the frame's moment.
typedef struct clast_frame_motion {
    clast_posed_node *nodes;
    size_t node_capacity;
    float *weights;
    size_t weight_capacity;
    clast_light *lights; // as many as the scene's
    size_t light_capacity;
    float *made_of; // scratch
    size_t made_of_capacity;
} clast_frame_motion;

// A mesh that morph targets or joints move.
typedef struct clast_posed_mesh {
    float *vertices; // positions, then normals and tangents where the mesh has them
    size_t capacity;
    float *
        made_of; // the joints' transforms, then the weights of morph targets; as long as these are equal, nothing moves
    size_t made_of_count, made_of_capacity;
    uint32_t geometry_version;
    uint32_t shape; // grows when the vertices are made anew; 0: not made yet
} clast_posed_mesh;

struct clast_frame;
struct clast_frame_unit;

// Finds where nodes are at settings.time, and moves the frame's cameras and lights that hang from them.
clast_status clast_frame_pose_scene(struct clast_frame *frame);
// An instance's place at that moment. To be asked for instances of the scene in order; *next is clast_motion_first_attachment()
// of the first of them.
clast_transform clast_frame_place_instance(const struct clast_frame *frame, size_t instance, size_t *next);
// Gives the pose of a unit its vertices, where something moves them.
clast_status clast_frame_pose_unit(struct clast_frame *frame, struct clast_frame_unit *unit);
void clast_frame_motion_destroy(clast_context *context, clast_frame_motion *motion);
void clast_posed_mesh_destroy(clast_context *context, clast_posed_mesh *mesh);

#endif
