// SPDX-License-Identifier: Apache-2.0
// Images brought into formats that devices read. Integers stay as they are: kernels make of them what the processor does. So do
// blocks, which are looked into by kernels where devices would round otherwise.
#include "vulkan/pictures.h"

#include "base/size.h"
#include "base/thread.h"
#include "render/texture.h"

enum { GRAIN_TEXELS = 1 << 16 };

// How an image lies on the device.
typedef struct picture_layout {
    VkFormat format;
    clast_pixel_type type;
    uint32_t channels;
    size_t texel; // bytes
} picture_layout;

static const VkFormat formats[3][3] = {
    // by type; of one, two, and four channels
    [CLAST_PIXEL_UNORM8] = {VK_FORMAT_R8_UNORM, VK_FORMAT_R8G8_UNORM, VK_FORMAT_R8G8B8A8_UNORM},
    [CLAST_PIXEL_UNORM16] = {VK_FORMAT_R16_UNORM, VK_FORMAT_R16G16_UNORM, VK_FORMAT_R16G16B16A16_UNORM},
    [CLAST_PIXEL_FLOAT] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT},
};

// How kernels look into blocks (shared/block.h); BLOCK_NONE: they do not.
static uint32_t block_kind(const clast_image_blocks *blocks)
{
    switch (blocks->data != NULL ? blocks->format : CLAST_BLOCK_COUNT) {
    case CLAST_BLOCK_BC1: return BLOCK_BC1;
    case CLAST_BLOCK_BC2: return BLOCK_BC2;
    case CLAST_BLOCK_BC3: return BLOCK_BC3;
    case CLAST_BLOCK_BC4: return BLOCK_BC4;
    case CLAST_BLOCK_BC5: return BLOCK_BC5;
    default: return BLOCK_NONE;
    }
}

// The format of blocks that all devices decode alike, to the bit, which the specification of these asks for; else
// UNDEFINED.
static VkFormat block_format(const clast_gpu *gpu, const clast_image_blocks *blocks)
{
    VkFormat format = VK_FORMAT_UNDEFINED;
    switch (blocks->data != NULL ? blocks->format : CLAST_BLOCK_COUNT) {
    case CLAST_BLOCK_BC6: format = VK_FORMAT_BC6H_UFLOAT_BLOCK; break;
    case CLAST_BLOCK_BC6_SIGNED: format = VK_FORMAT_BC6H_SFLOAT_BLOCK; break;
    case CLAST_BLOCK_BC7: format = VK_FORMAT_BC7_UNORM_BLOCK; break;
    default: break;
    }
    return format != VK_FORMAT_UNDEFINED && clast_gpu_can_read(gpu, format) ? format : VK_FORMAT_UNDEFINED;
}

static size_t element_bytes(clast_pixel_type type)
{
    return type == CLAST_PIXEL_UNORM8 ? 1 : type == CLAST_PIXEL_UNORM16 ? 2 : 4;
}

// Few devices read three channels, and some do not read 16 bits: they are given as four, and as floats.
static picture_layout layout_of(const clast_gpu *gpu, const clast_image *image)
{
    uint32_t place = image->channels < 3 ? image->channels - 1 : 2;
    clast_pixel_type type = image->type;
    if (type == CLAST_PIXEL_UNORM16 && !clast_gpu_can_read(gpu, formats[type][place])) {
        type = CLAST_PIXEL_FLOAT;
    }
    uint32_t channels = place < 2 ? place + 1 : 4;
    return (picture_layout){formats[type][place], type, channels, channels * element_bytes(type)};
}

// --------------------------------------------------------------------------------------------------------- conversion

typedef struct convert_job {
    const clast_image *image;
    picture_layout layout;
    void *pixels;
} convert_job;

static void convert8(const convert_job *job, size_t begin, size_t end)
{
    const uint8_t *from = job->image->pixels;
    uint8_t *to = job->pixels;
    for (size_t i = begin; i < end; i++) {
        for (size_t c = 0; c < 3; c++) {
            to[4 * i + c] = from[3 * i + c];
        }
        to[4 * i + 3] = UINT8_MAX;
    }
}

static void convert16(const convert_job *job, size_t begin, size_t end)
{
    const uint16_t *from = job->image->pixels;
    uint16_t *to = job->pixels;
    for (size_t i = begin; i < end; i++) {
        for (size_t c = 0; c < 3; c++) {
            to[4 * i + c] = from[3 * i + c];
        }
        to[4 * i + 3] = UINT16_MAX;
    }
}

static float float_at(const clast_image *image, size_t element)
{
    return image->type == CLAST_PIXEL_UNORM16 ? unorm16(((const uint16_t *)image->pixels)[element])
                                              : ((const float *)image->pixels)[element];
}

static void convert_float(const convert_job *job, size_t begin, size_t end)
{
    const clast_image *image = job->image;
    size_t given = image->channels, wanted = job->layout.channels;
    float *to = job->pixels;
    for (size_t i = begin; i < end; i++) {
        for (size_t c = 0; c < wanted; c++) {
            to[wanted * i + c] = c < given ? float_at(image, given * i + c) : 1.0f;
        }
    }
}

static void convert_texels(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const convert_job *job = data;
    switch (job->layout.type) {
    case CLAST_PIXEL_UNORM8: convert8(job, begin, end); break;
    case CLAST_PIXEL_UNORM16: convert16(job, begin, end); break;
    case CLAST_PIXEL_FLOAT: convert_float(job, begin, end); break;
    }
}

// ------------------------------------------------------------------------------------------------------------- upload

static clast_status write_pixels(clast_gpu_commands *commands, clast_gpu_texture texture, uint32_t level,
                                 const clast_image *image, picture_layout layout)
{
    clast_context *context = clast_gpu_context(clast_gpu_of(commands));
    size_t texels, bytes;
    if (!clast_multiply_size(image->width, image->height, &texels) ||
        !clast_multiply_size(texels, layout.texel, &bytes)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "vulkan: an image of %u x %u texels does not fit the memory",
                          image->width, image->height);
    }
    if (layout.type == image->type && layout.channels == image->channels) {
        clast_gpu_texture_write(commands, texture, level, image->pixels, bytes);
        return CLAST_OK;
    }
    convert_job job = {image, layout, clast_allocate(context, texels, layout.texel)};
    if (job.pixels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(context, texels, GRAIN_TEXELS, convert_texels, &job);
    clast_gpu_texture_write(commands, texture, level, job.pixels, bytes);
    clast_free(context, job.pixels);
    return CLAST_OK;
}

static const char *name_of(const clast_scene_image *image)
{
    return image->name != NULL ? image->name : "an image";
}

static clast_status upload_blocks(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                  const clast_scene_image *from, clast_device_image *made)
{
    clast_context *context = clast_gpu_context(pictures->gpu);
    const clast_image *image = &from->image;
    clast_status status = CLAST_RESERVE(context, pictures->blocks, pictures->block_capacity, pictures->block_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_buffer *buffer = &pictures->blocks[pictures->block_count];
    *buffer = (clast_gpu_buffer){0};
    status = clast_gpu_allocate(pictures->gpu, CLAST_GPU_DEVICE, from->blocks.bytes, name_of(from), buffer);
    if (status == CLAST_OK) {
        clast_gpu_write(commands, buffer, 0, from->blocks.data, from->blocks.bytes);
        *made = (clast_device_image){(uint32_t)pictures->block_count++,
                                     image_format(image->channels, image->type, block_kind(&from->blocks)),
                                     image_size(image->width, image->height)};
    }
    return status;
}

static clast_status upload_texture(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                   const clast_scene_image *from, clast_device_image *made)
{
    const clast_image *image = &from->image;
    picture_layout layout = layout_of(pictures->gpu, image);
    VkFormat compressed = block_format(pictures->gpu, &from->blocks);
    clast_gpu_texture_desc desc = {.format = compressed != VK_FORMAT_UNDEFINED ? compressed : layout.format,
                                   .width = image->width,
                                   .height = image->height,
                                   .levels = 1,
                                   .name = name_of(from)};
    clast_gpu_texture texture;
    clast_status status = clast_gpu_texture_create(pictures->gpu, &desc, &texture);
    if (status != CLAST_OK) {
        return status;
    }
    *made = (clast_device_image){texture.number, image_format(image->channels, image->type, BLOCK_NONE),
                                 image_size(image->width, image->height)};
    pictures->has_16_bits = pictures->has_16_bits || image->type == CLAST_PIXEL_UNORM16;
    if (compressed != VK_FORMAT_UNDEFINED) {
        clast_gpu_texture_write(commands, texture, 0, from->blocks.data, from->blocks.bytes);
        return CLAST_OK;
    }
    return write_pixels(commands, texture, 0, image, layout);
}

// All levels as one texture, whose own first is the first below the picture.
static clast_status upload_levels(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                  const clast_scene_image *from, const clast_image_levels *levels,
                                  clast_device_image *made)
{
    clast_image largest = clast_level_image(&from->image, levels, 1);
    picture_layout layout = layout_of(pictures->gpu, &largest);
    clast_gpu_texture_desc desc = {.format = layout.format,
                                   .width = largest.width,
                                   .height = largest.height,
                                   .levels = levels->count,
                                   .name = name_of(from)};
    clast_gpu_texture texture;
    clast_status status = clast_gpu_texture_create(pictures->gpu, &desc, &texture);
    if (status != CLAST_OK) {
        return status;
    }
    *made = (clast_device_image){texture.number, image_format(largest.channels, largest.type, BLOCK_NONE),
                                 image_size(largest.width, largest.height)};
    pictures->has_16_bits = pictures->has_16_bits || largest.type == CLAST_PIXEL_UNORM16;
    for (uint32_t level = 1; level <= levels->count && status == CLAST_OK; level++) {
        clast_image image = clast_level_image(&from->image, levels, level);
        status = write_pixels(commands, texture, level - 1, &image, layout);
    }
    return status;
}

static const clast_device_image no_image = {.texture = CLAST_NONE};

// Has a place for an image of the scene; null where it is no picture, or memory ran out.
static clast_status reserve_place(clast_gpu_pictures *pictures, const clast_scene *scene, uint32_t number,
                                  clast_gpu_levels **place)
{
    *place = NULL;
    if (number >= scene->image_count || scene->images[number].image.width == 0 ||
        scene->images[number].image.height == 0) {
        return CLAST_OK;
    }
    clast_context *context = clast_gpu_context(pictures->gpu);
    clast_status status = CLAST_RESERVE(context, pictures->images, pictures->capacity, (size_t)number + 1);
    if (status != CLAST_OK) {
        return status;
    }
    for (; pictures->count <= number; pictures->count++) {
        pictures->images[pictures->count] = (clast_gpu_levels){no_image, {no_image, no_image, no_image, no_image}};
    }
    *place = &pictures->images[number];
    return CLAST_OK;
}

clast_status clast_gpu_pictures_need(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                     const clast_scene *scene, uint32_t number, clast_device_image *image)
{
    clast_gpu_levels *place;
    clast_status status = reserve_place(pictures, scene, number, &place);
    *image = no_image;
    if (place == NULL) {
        return status;
    }
    if (place->finest.texture == CLAST_NONE) {
        const clast_scene_image *from = &scene->images[number];
        status = block_kind(&from->blocks) != BLOCK_NONE ? upload_blocks(pictures, commands, from, &place->finest)
                                                         : upload_texture(pictures, commands, from, &place->finest);
    }
    *image = place->finest;
    return status;
}

clast_status clast_gpu_pictures_need_levels(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                            const clast_scene *scene, uint32_t number, uint32_t encoding,
                                            clast_device_image *levels, uint32_t *count)
{
    clast_gpu_levels *place;
    clast_status status = reserve_place(pictures, scene, number, &place);
    *levels = no_image;
    *count = 0;
    if (place == NULL) {
        return status;
    }
    const clast_scene_image *from = &scene->images[number];
    clast_encoding meant = clast_levels_encoding(&from->image, (clast_encoding)encoding);
    if (from->levels[meant].count == 0) {
        return CLAST_OK;
    }
    if (place->levels[meant].texture == CLAST_NONE) {
        status = upload_levels(pictures, commands, from, &from->levels[meant], &place->levels[meant]);
    }
    *levels = place->levels[meant];
    *count = from->levels[meant].count;
    return status;
}

static void free_texture(clast_gpu *gpu, clast_device_image image)
{
    if (format_block(image.format) == BLOCK_NONE) {
        clast_gpu_texture texture = {image.texture};
        clast_gpu_texture_destroy(gpu, &texture);
    }
}

void clast_gpu_pictures_free(clast_gpu_pictures *pictures)
{
    for (size_t i = 0; i < pictures->count; i++) {
        free_texture(pictures->gpu, pictures->images[i].finest);
        for (uint32_t encoding = 0; encoding < ENCODINGS; encoding++) {
            free_texture(pictures->gpu, pictures->images[i].levels[encoding]);
        }
    }
    for (size_t i = 0; i < pictures->block_count; i++) {
        clast_gpu_free(pictures->gpu, &pictures->blocks[i]);
    }
    if (pictures->gpu != NULL) {
        clast_free(clast_gpu_context(pictures->gpu), pictures->images);
        clast_free(clast_gpu_context(pictures->gpu), pictures->blocks);
    }
    *pictures = (clast_gpu_pictures){.gpu = pictures->gpu};
}
