// SPDX-License-Identifier: Apache-2.0
// How settings have views displayed.
#ifndef CLAST_RENDER_DISPLAY_H
#define CLAST_RENDER_DISPLAY_H

#include "render/render.h"
#include "shared/display.h"

// All but the range of depths and steps, which the picture itself tells.
clast_display clast_display_of(const clast_render_settings *settings);

#endif
