// SPDX-License-Identifier: Apache-2.0
// The shutter: samples are divided among moments while it is open, one moment after the other, and the frame is brought to each. So
// all that moves is blurred, whatever moves it, at the cost of a frame for each moment and of no memory. The samples of a
// moment follow each other, and are well spread by themselves.
#ifndef CLAST_RENDER_SHUTTER_H
#define CLAST_RENDER_SHUTTER_H

#include "render/render.h"

// The number of the moment of a sample; samples of the same moment follow each other. 0 where there is no shutter.
uint32_t clast_shutter_moment(const clast_render_settings *settings, uint32_t sample);
// In seconds: the middle of the moment's part of the time.
double clast_shutter_time(const clast_render_settings *settings, uint32_t moment);

// Brings the frame, and the lights of the target, to the moment of the target's sample, where they are at another.
clast_status clast_shutter_move(clast_frame *frame, const clast_backend *backend, clast_render_target *target);
// Brings the frame back to when the shutter opens, for whoever traces rays through it.
clast_status clast_shutter_close(clast_frame *frame, const clast_backend *backend, const clast_render_target *target);

#endif
