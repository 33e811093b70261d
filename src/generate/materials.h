// SPDX-License-Identifier: Apache-2.0
// Boards of spheres that show what glTF's material extensions do, each with a camera of its own.
#ifndef CLAST_GENERATE_MATERIALS_H
#define CLAST_GENERATE_MATERIALS_H

#include "base/context.h"

clast_status clast_generate_materials(clast_context *context, double detail, uint32_t seed, const char *folder);

#endif
