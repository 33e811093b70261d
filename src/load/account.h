// SPDX-License-Identifier: Apache-2.0
// What a scene's files may come to in memory: at most clast_unpacked_most() of what they have in sum, so that small files cannot
// fill it. Loaders note what they read, and count what they make of it before they make it, or, for pictures, as soon as it is
// made: each of those has the same bound by itself.
#ifndef CLAST_LOAD_ACCOUNT_H
#define CLAST_LOAD_ACCOUNT_H

#include "clast/image.h"
#include "load/bytes.h"
#include "scene/scene.h"

static inline void clast_account_read(clast_scene *scene, uint64_t bytes)
{
    scene->stored_bytes += bytes; // no overflow: files have below 2^63 bytes, and are in memory
}

// Counts `count` elements of `size` bytes; LIMIT where they would pass the bound, with a text that begins with `name`.
clast_status clast_account_make(clast_scene *scene, const char *name, uint64_t count, uint64_t size);
// Reads a picture of a scene's, and counts it. The pixels are the caller's.
clast_status clast_account_image(clast_scene *scene, const char *path, clast_image *image);

#endif
