// SPDX-License-Identifier: Apache-2.0
#include "load/account.h"

#include "load/image.h"
#include "load/load.h"

clast_status clast_account_make(clast_scene *scene, const char *name, uint64_t count, uint64_t size)
{
    uint64_t most = clast_unpacked_most(scene->stored_bytes),
             left = most - scene->made_bytes; // made before: within the bound
    if (count != 0 && size > left / count) {
        return clast_fail(scene->context, CLAST_ERROR_LIMIT,
                          "%s: %llu elements of %llu bytes more than the %llu that files of %llu bytes may come to",
                          name, (unsigned long long)count, (unsigned long long)size, (unsigned long long)most,
                          (unsigned long long)scene->stored_bytes);
    }
    scene->made_bytes += count * size;
    return CLAST_OK;
}

clast_status clast_account_image(clast_scene *scene, const char *path, clast_image *image)
{
    clast_file_view file;
    *image = (clast_image){0};
    clast_status status = clast_file_map(scene->context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    clast_account_read(scene, file.size);
    status = clast_decode_image(scene->context, path, file.data, file.size, image);
    clast_file_unmap(scene->context, &file);
    if (status == CLAST_OK) {
        status = clast_account_make(scene, path, (uint64_t)image->width * image->height,
                                    image->channels * clast_pixel_size(image->type));
    }
    if (status != CLAST_OK) {
        clast_image_free(scene->context, image);
    }
    return status;
}
