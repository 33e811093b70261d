// SPDX-License-Identifier: Apache-2.0
// Makes the levels of a scene's pictures.
#ifndef CLAST_RENDER_LEVELS_H
#define CLAST_RENDER_LEVELS_H

#include "render/texture.h"

// Makes those that the scene's materials read and that are not there yet, each from the one before it: means over as much of the
// picture as a texel stands for, of light as it is and not as it is stored. Levels that came with a file are taken, and continued
// where they end early; normal maps get levels of their own, which tell how far normals spread. They take a third of what the
// picture does; of normal maps, three numbers of 16 bits for each texel. Reports progress as "levels". The same bits on any number
// of threads. Where it fails, levels are whole or not there.
clast_status clast_make_levels(clast_scene *scene);

// Bytes of those that were made or came with files.
uint64_t clast_level_bytes(const clast_scene *scene);

#endif
