// SPDX-License-Identifier: Apache-2.0
// Bytes on disk -> scene. A loader gets a mapped file and an empty scene; on failure it says so by clast_fail, with the file's
// name and the place, and the caller destroys the scene.
#ifndef CLAST_LOAD_LOAD_H
#define CLAST_LOAD_LOAD_H

#include "base/file.h"
#include "clast/image.h"
#include "load/bytes.h"
#include "scene/scene.h"

// Each may keep `file` by clast_scene_keep_file (and then owns it: sets file->data to null); the caller unmaps it otherwise.
clast_status clast_load_gltf(clast_scene *scene, const char *path, clast_file_view *file);
clast_status clast_load_obj(clast_scene *scene, const char *path, clast_file_view *file);
clast_status clast_load_ply(clast_scene *scene, const char *path, clast_file_view *file);
clast_status clast_load_stl(clast_scene *scene, const char *path, clast_file_view *file);
clast_status clast_load_scene_file(clast_scene *scene, const char *path, clast_file_view *file);

// Whether a file is to be taken for glTF: by its name, then by its contents.
bool clast_is_gltf(const char *path, clast_bytes bytes);

// Reads any of these into an existing scene (a scene file's models come this way); told by contents, then by name.
clast_status clast_load_into(clast_scene *scene, const char *path);
// The same for a model that a scene file names: refuses scene files, so that none can name itself.
clast_status clast_load_model(clast_scene *scene, const char *path);

// Decodes an image in memory (the formats of clast_image_read), told by the contents. `name` is for errors. The pixels are a
// block of clast_allocate.
clast_status clast_decode_image(clast_context *context, const char *name, const void *data, uint64_t size,
                                clast_image *image);
// The same, with what else the file has of it; `parts` may be null.
clast_status clast_decode_image_parts(clast_context *context, const char *name, const void *data, uint64_t size,
                                      clast_image *image, clast_image_parts *parts);

#endif
