// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ, beside a material library. The input's length decides how large the pieces are in which it is read.
#include "fuzz.h"
#include "load/obj.h"

static clast_status load_in_pieces(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_file_source source = {scene->context, file->size, *file, -1};
    return clast_load_obj_source(scene, path, &source, 3 + (size_t)(file->size % 61));
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_load(context, load_in_pieces, "input.obj", data, size);
}
