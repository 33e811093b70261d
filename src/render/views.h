// SPDX-License-Identifier: Apache-2.0
// Views of what the first sample hit.
#ifndef CLAST_RENDER_VIEWS_H
#define CLAST_RENDER_VIEWS_H

#include "render/render.h"

// Fills a pixel of those views that were asked for, from the visibility of the first sample.
void clast_keep_views(const clast_frame *frame, clast_render_target *target, size_t pixel);

#endif
