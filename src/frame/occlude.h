// SPDX-License-Identifier: Apache-2.0
// What the files of the pass occlude share.
#ifndef CLAST_FRAME_OCCLUDE_H
#define CLAST_FRAME_OCCLUDE_H

#include "frame/unit.h"

// Where a box is in the picture, from 0 to 1 each way, and its depths.
typedef struct clast_box_extent {
    float left, top, right, bottom;
    float nearest, farthest;
    bool sound; // all of it lies beyond the near plane: else only the farthest depth is right
} clast_box_extent;

clast_box_extent clast_box_extent_of(const clast_camera *camera, const clast_box *box);

// How far an instance's surface may be from where its coarse form was hit, in the world.
float clast_frame_slack(const clast_frame *frame, const clast_frame_instance *instance);

// Whether edges of any unit may be compared with depths (occlusion.c).
bool clast_occlusion_is_wanted(const clast_frame *frame);
// Makes room for their depths, by the pyramid's size.
clast_status clast_occlusion_begin(clast_frame *frame);
// Finds them, and what units' views know of them. The pyramid is there, and the views are those of this frame.
void clast_occlusion_find(clast_frame *frame);

#endif
