/* SPDX-License-Identifier: Apache-2.0
 *
 * Image files, and comparing images.
 */
#ifndef CLAST_IMAGE_H
#define CLAST_IMAGE_H

#include "clast/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Reads PNG, JPEG (progressive and CMYK too), WebP (not moving), Radiance HDR, EXR (scanlines or tiles; the first flat part that
 *  has a picture), PFM, TGA, DDS, or KTX of version 1 or 2 (BC1 to BC7 and uncompressed, packed by zstd or not); the type is told
 *  by the contents. 16-bit and float pixels are kept. Fills `image`, whose pixels are freed by clast_image_free. Errors:
 *  FILE_NOT_FOUND, FILE_READ, MALFORMED, UNSUPPORTED, LIMIT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_image_read(clast_context *context, const char *path, clast_image *image);
CLAST_API void clast_image_free(clast_context *context, clast_image *image);

/** A layer of an EXR file. Its channels are named LAYER.X, or X alone where the name is empty. */
typedef struct clast_image_layer {
    const char *name;     /**< "" , "Albedo", "N", ... */
    const char *channels; /**< one letter each, as "RGB" or "XYZ" */
    bool is_integer;      /**< uint32_t instead of float */
    const void *pixels;   /**< interleaved */
    bool is_half;         /**< stored as 16-bit floats, which reach 65504 with 11 bits; not for integers */
} clast_image_layer;

/** Reads a layer of an EXR file, as floats, which integers up to 2^24 become without loss. `layer` is a name that
 *  clast_image_list_layers tells; an empty one is the picture that clast_image_read gives. UNSUPPORTED where the file is no EXR file,
 *  has no such layer, or one of more than four channels; else as clast_image_read. */
CLAST_API clast_status clast_image_read_layer(clast_context *context, const char *path, const char *layer,
                                              clast_image *image);
/** Told of each layer; the name is valid during the call only. */
typedef void (*clast_layer_function)(void *user, const char *layer);
/** Lists the layers of an EXR file's flat parts, by name, each once: what stands before the last dot of channels' names. Channels
 *  without a dot are a layer each of their own name, but for those of the picture (R, G, B, A or Y), whose layer's name is empty.
 *  UNSUPPORTED where the file is no EXR file; LIMIT where it has more than 1024 channels; else as clast_image_read. */
CLAST_API clast_status clast_image_list_layers(clast_context *context, const char *path, clast_layer_function function,
                                               void *user);

/** Writes an image by the extension of `path`: .png (UNORM8, UNORM16), .jpg or .jpeg (UNORM8, 1 or 3 channels), .pfm (FLOAT, 1 or
 *  3 channels), .exr (FLOAT), .hdr (FLOAT, 3 channels). Nothing appears under `path` unless the file is whole.
 *  Errors: INVALID_ARGUMENT, UNSUPPORTED, FILE_WRITE, OUT_OF_MEMORY. */
CLAST_API clast_status clast_image_write(clast_context *context, const char *path, const clast_image *image);
/** Writes an EXR file of several layers, ZIP compressed. */
CLAST_API clast_status clast_image_write_layers(clast_context *context, const char *path, uint32_t width,
                                                uint32_t height, const clast_image_layer *layers, size_t count);

/** A part of a picture that a file has, and the size of the whole. */
typedef struct clast_image_window {
    uint32_t x, y; /**< of the part, from the picture's upper left corner */
    uint32_t width, height;
    uint32_t picture_width, picture_height;
} clast_image_window;
/** The same for a part of a picture: the file's data window, within a display window that is the picture's. The layers' pixels
 *  are those of the part. INVALID_ARGUMENT where it does not lie in the picture. */
CLAST_API clast_status clast_image_write_window(clast_context *context, const char *path,
                                                const clast_image_window *window, const clast_image_layer *layers,
                                                size_t count);

/** How two images differ. Values are on the scale of the files: 0 to 1 for integer types. */
typedef struct clast_image_difference {
    double mean_squared_error;
    double maximum;                /**< largest difference of a channel */
    uint32_t maximum_x, maximum_y; /**< where */
    uint64_t differing_pixels;
} clast_image_difference;
/** Compares images of the same size; INVALID_ARGUMENT otherwise. A missing alpha is 1; a grey one counts as three channels.
 *  A NaN in one only is an infinite difference. */
CLAST_API clast_status clast_image_compare(clast_context *context, const clast_image *a, const clast_image *b,
                                           clast_image_difference *difference);

/** What an eye sees of the difference when two images of the same size take turns in one place: FLIP (Andersson et al., 2020),
 *  from 0 to 1 for each pixel. Integer images are taken as sRGB; float ones as linear, and the largest of the exposures that
 *  suit the reference counts (HDR-FLIP, 2021). Alpha is not looked at.
 *  `pixels_per_degree` is of the viewer's eye; 0 is 67, a 4K monitor at the distance of its width. `errors` takes width x height
 *  values, or may be null; `*mean` their mean. Errors: INVALID_ARGUMENT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_image_flip(clast_context *context, const clast_image *reference, const clast_image *test,
                                        double pixels_per_degree, float *errors, double *mean);

#ifdef __cplusplus
}
#endif

#endif
