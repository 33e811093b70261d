/* SPDX-License-Identifier: Apache-2.0
 *
 * The geometry of a frame as a file: what is tessellated and displaced is written as it is traced.
 */
#ifndef CLAST_EXPORT_H
#define CLAST_EXPORT_H

#include "clast/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct clast_export_desc {
    const uint32_t *instances; /**< which of the scene's; null is all that are visible */
    size_t instance_count;
    bool
        welded; /**< one vertex for each position, so that a closed surface is closed by its indices too: normals are averaged,
                  *   texture coordinates and colours left out. Else vertices are parted where attributes differ */
} clast_export_desc;

typedef struct clast_export_statistics {
    uint32_t meshes, instances;
    uint64_t vertices, triangles; /**< of the meshes, once each */
    uint64_t instanced_triangles;
} clast_export_statistics;

/** Commits, then writes the committed frame's triangles with smooth normals, texture coordinates and materials: .gltf (with .bin
 *  and .png beside it) or .glb, where instances stay instances, or .ply (binary, one mesh in the world's coordinates). Triangles
 *  that share a point have the same bits there. `desc` and `statistics` may be null. Nothing appears under `path` unless the file
 *  is whole. Errors: INVALID_ARGUMENT, UNSUPPORTED (the extension), LIMIT, FILE_WRITE, CANCELLED, those of clast_renderer_commit. */
CLAST_API clast_status clast_export(clast_renderer *renderer, const clast_render_settings *settings,
                                    const clast_export_desc *desc, const char *path,
                                    clast_export_statistics *statistics);

#ifdef __cplusplus
}
#endif

#endif
