/* SPDX-License-Identifier: Apache-2.0
 *
 * Procedural scenes, written as ordinary files.
 */
#ifndef CLAST_GENERATE_H
#define CLAST_GENERATE_H

#include "clast/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct clast_generate_desc {
    const char *scene; /**< which: "canyon" is the demonstration scene */
    double detail;     /**< scales the number of triangles; 1 is about a million, 0.02 to 25; 0 is 1 */
    uint32_t seed;
} clast_generate_desc;

/** Writes a scene's files into the folder `path` (made where missing): scene.json, which names the rest, .gltf with .bin,
 *  and .png textures and height maps. Deterministic. */
CLAST_API clast_status clast_generate(clast_context *context, const clast_generate_desc *desc, const char *path);

/** The name and a line of text of each scene; false past the last. */
CLAST_API bool clast_generate_scene(uint32_t index, const char **name, const char **text);

#ifdef __cplusplus
}
#endif

#endif
