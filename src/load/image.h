// SPDX-License-Identifier: Apache-2.0
// What the image formats share. A decoder gets the whole file in memory and gives pixels in a block of clast_allocate;
// on failure the image is left empty. `name` is for errors.
#ifndef CLAST_LOAD_IMAGE_H
#define CLAST_LOAD_IMAGE_H

#include "base/file.h"
#include "clast/image.h"
#include "load/bytes.h"
#include "scene/levels.h"

// Bounds on hostile headers: what is larger is refused before anything is allocated.
enum { CLAST_IMAGE_SIDE = 65536 };

static inline size_t clast_pixel_size(clast_pixel_type type)
{
    return type == CLAST_PIXEL_UNORM8 ? 1 : type == CLAST_PIXEL_UNORM16 ? 2 : 4;
}

// Whether a picture from a file of `stored` bytes may take `size` bytes of memory: LIMIT where that passes clast_unpacked_most().
clast_status clast_image_check_size(clast_context *context, const char *name, uint64_t stored, uint64_t size);

// Checks the limits, allocates and fills `image`; its pixels are undefined yet.
clast_status clast_image_allocate(clast_context *context, const char *name, uint64_t stored, uint64_t width,
                                  uint64_t height, uint32_t channels, clast_pixel_type type, clast_image *image);

// Copies the first line of what a library or a hostile file says, with ? for what does not print.
void clast_copy_line(char *to, size_t size, const char *text);

clast_status clast_png_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_jpeg_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_hdr_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_pfm_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_dds_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_ktx_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_ktx2_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
// The same with blocks and levels; `parts` is empty, or null. Levels that are broken, or broken off, are left out with all below
// them: the picture is there without them.
clast_status clast_dds_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                    clast_image_parts *parts);
clast_status clast_ktx_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                    clast_image_parts *parts);
clast_status clast_ktx2_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                     clast_image_parts *parts);
// Puts a level of a file, decoded, where it belongs, and frees it; the first time, makes room for `count`. False where it is no such
// level, or memory ran out: then no further level is taken.
bool clast_image_take_level(clast_context *context, const clast_image *finest, uint32_t level, uint32_t count,
                            clast_image *decoded, clast_image_levels *levels);
clast_status clast_webp_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_tga_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
clast_status clast_exr_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
// The same of a layer, as clast_image_read_layer has it; and the names of all.
clast_status clast_exr_decode_layer(clast_context *context, const char *name, clast_bytes bytes, const char *layer,
                                    clast_image *image);
clast_status clast_exr_list_layers(clast_context *context, const char *name, clast_bytes bytes,
                                   clast_layer_function function, void *user);

// Whether the bytes begin as an image of a type that is read.
bool clast_is_image(clast_bytes bytes);
// Whether the bytes begin as a TGA file does. The format has no signature, so this is asked last.
bool clast_is_tga(clast_bytes bytes);

// Each writes what its format can hold (the caller has checked) and leaves failures in output->status.
void clast_png_encode(clast_file_output *output, const clast_image *image);
// The same into a new block of clast_allocate.
clast_status clast_png_encode_block(clast_context *context, const char *name, const clast_image *image, void **block,
                                    size_t *size);
void clast_jpeg_encode(clast_file_output *output, const clast_image *image);
void clast_hdr_encode(clast_file_output *output, const clast_image *image);
void clast_pfm_encode(clast_file_output *output, const clast_image *image);
void clast_exr_encode(clast_file_output *output, const clast_image_window *window, const clast_image_layer *layers,
                      size_t count);

#endif
