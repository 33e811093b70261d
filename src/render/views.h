// SPDX-License-Identifier: Apache-2.0
// Views of how geometry is cut.
#ifndef CLAST_RENDER_VIEWS_H
#define CLAST_RENDER_VIEWS_H

#include "render/render.h"

// Fills rows of those views that were asked for, from the visibility of the first sample.
void clast_keep_cut_views(const clast_frame *frame, clast_render_target *target, uint32_t row, uint32_t rows);

#endif
