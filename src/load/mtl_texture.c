// SPDX-License-Identifier: Apache-2.0
// Textures of MTL materials. MTL has a file for each quantity where metallic-roughness wants several in one image:
// those are packed here.
#include <stdio.h>

#include "load/account.h"
#include "load/image.h"
#include "load/mtl.h"

static bool can_do_without(clast_status status)
{
    return status == CLAST_ERROR_FILE_NOT_FOUND || status == CLAST_ERROR_FILE_READ || status == CLAST_ERROR_MALFORMED ||
           status == CLAST_ERROR_UNSUPPORTED || status == CLAST_ERROR_LIMIT;
}

// Reads a map's image. Where that fails for the file's fault, warns and leaves the image empty.
static clast_status read_image(clast_scene *scene, const clast_mtl_map *map, clast_image *image)
{
    *image = (clast_image){0};
    if (map == NULL || map->path == NULL) {
        return CLAST_OK;
    }
    clast_status status = clast_account_image(scene, map->path, image);
    if (can_do_without(status)) {
        clast_log(scene->context, CLAST_LOG_WARNING, "a texture is left out: %s", clast_context_error(scene->context));
        return CLAST_OK;
    }
    return status;
}

// A channel at the middle of pixel (x, y) of a grid of that size, in 0 to 255; the nearest texel. Empty images are
// white.
static unsigned char fetch(const clast_image *image, uint32_t channel, size_t x, size_t y, const clast_image *grid)
{
    if (image->pixels == NULL) {
        return 255;
    }
    size_t u = (2 * x + 1) * image->width / (2 * (size_t)grid->width);
    size_t v = (2 * y + 1) * image->height / (2 * (size_t)grid->height);
    uint32_t c = channel < image->channels ? channel : 0;
    size_t i = (v * image->width + u) * image->channels + c;
    if (image->type == CLAST_PIXEL_UNORM8) {
        return ((const uint8_t *)image->pixels)[i];
    }
    if (image->type == CLAST_PIXEL_UNORM16) {
        return (unsigned char)((((const uint16_t *)image->pixels)[i] * 255u + 32767u) / 65535u);
    }
    float value = ((const float *)image->pixels)[i];
    return value >= 1.0f ? 255 : value > 0.0f ? (unsigned char)(value * 255.0f + 0.5f) : 0;
}

// What a map of one quantity holds: its alpha, where it is an opacity map with one; else its first channel.
static uint32_t scalar_channel(const clast_image *image, bool is_opacity)
{
    return is_opacity && image->channels % 2 == 0 && image->channels > 0 ? image->channels - 1 : 0;
}

// One image of 8 bits from two, as large as the larger.
static clast_status pack(clast_context *context, clast_mtl_texture_use use, const clast_image *first,
                         const clast_image *second, clast_image *packed)
{
    uint32_t width = first->width > second->width ? first->width : second->width;
    uint32_t height = first->height > second->height ? first->height : second->height;
    bool is_colour = use == CLAST_MTL_COLOUR;
    clast_status status = clast_image_allocate(context, "packed texture", UINT64_MAX, width, height, is_colour ? 4 : 3,
                                               CLAST_PIXEL_UNORM8, packed);
    if (status != CLAST_OK) {
        return status;
    }
    unsigned char *to = (unsigned char *)packed->pixels;
    uint32_t scalar = scalar_channel(second, is_colour);
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            to[0] = is_colour ? fetch(first, 0, x, y, packed) : 255;
            to[1] = fetch(first, is_colour && first->channels > 2 ? 1 : 0, x, y, packed);
            to[2] = is_colour ? fetch(first, first->channels > 2 ? 2 : 0, x, y, packed)
                              : fetch(second, scalar, x, y, packed);
            if (is_colour) {
                to[3] = fetch(second, scalar, x, y, packed);
            }
            to += packed->channels;
        }
    }
    return CLAST_OK;
}

// A map of normals has colours; one of heights is grey.
static bool has_colours(const clast_image *image)
{
    size_t size = clast_pixel_size(image->type);
    size_t count = (size_t)image->width * image->height;
    const unsigned char *pixel = image->pixels;
    for (size_t i = 0; image->channels >= 3 && i < count; i++, pixel += size * image->channels) {
        if (memcmp(pixel, pixel + size, size) != 0 || memcmp(pixel, pixel + 2 * size, size) != 0) {
            return true;
        }
    }
    return false;
}

// The image of a use; empty where there is none to be had.
static clast_status make_image(clast_scene *scene, clast_mtl_texture_use use, const clast_mtl_map *first,
                               const clast_mtl_map *second, clast_image *image)
{
    clast_image images[2] = {{0}, {0}};
    *image = (clast_image){0};
    clast_context *context = scene->context;
    clast_status status = read_image(scene, first, &images[0]);
    if (status == CLAST_OK) {
        status = read_image(scene, second, &images[1]);
    }
    bool any = images[0].pixels != NULL || images[1].pixels != NULL;
    if (status == CLAST_OK && any && (use == CLAST_MTL_ROUGHNESS_METAL || images[1].pixels != NULL)) {
        status = pack(context, use, &images[0], &images[1], image);
    } else if (status == CLAST_OK && use == CLAST_MTL_BUMPS && any && !has_colours(&images[0])) {
        if (!first->has_range) { // else it displaces
            clast_log(context, CLAST_LOG_WARNING,
                      "a texture is left out: %s: holds heights, not normals; -mm BASE GAIN would displace by it",
                      first->path);
        }
    } else if (status == CLAST_OK && !(use == CLAST_MTL_BUMP_HEIGHTS && any && has_colours(&images[0]))) {
        *image = images[0];
        images[0] = (clast_image){0};
    }
    clast_image_free(context, &images[0]);
    clast_image_free(context, &images[1]);
    return status;
}

static clast_status make_texture(clast_mtl *library, clast_mtl_texture_use use, const clast_mtl_map *first,
                                 const clast_mtl_map *second, bool clamp, uint32_t *number)
{
    clast_scene *scene = library->scene;
    clast_image image;
    *number = CLAST_NONE;
    clast_status status = make_image(scene, use, first, second, &image);
    if (status != CLAST_OK || image.pixels == NULL) {
        return status;
    }
    clast_texture texture = {.wrap_u = clamp ? CLAST_WRAP_CLAMP : CLAST_WRAP_REPEAT,
                             .wrap_v = clamp ? CLAST_WRAP_CLAMP : CLAST_WRAP_REPEAT};
    const char *name = first->path != NULL ? first->path : second->path;
    status = clast_scene_adopt_image(scene, &image, name, &texture.image);
    return status == CLAST_OK ? clast_scene_add_texture(scene, &texture, number) : status;
}

// What a texture is made from, as a text: its name in the library's table.
static char *texture_name(clast_context *context, clast_mtl_texture_use use, const clast_mtl_map *first,
                          const clast_mtl_map *second, bool clamp)
{
    const char *a = first->path != NULL ? first->path : "";
    const char *b = second != NULL && second->path != NULL ? second->path : "";
    size_t size = strlen(a) + strlen(b) + 8;
    char *name = clast_allocate(context, size, 1);
    if (name != NULL) {
        snprintf(name, size, "%d%d\n%s\n%s", (int)use, clamp, a, b);
    }
    return name;
}

static clast_status find_texture(clast_mtl *library, clast_mtl_texture_use use, const clast_mtl_map *first,
                                 const clast_mtl_map *second, bool clamp, uint32_t *number)
{
    clast_context *context = library->scene->context;
    char *name = texture_name(context, use, first, second, clamp);
    if (name == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_table_reserve(context, &library->texture_table);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, library->textures, library->texture_capacity, library->texture_count + 1);
    }
    uint32_t hash = clast_hash_text(name, strlen(name));
    size_t place = hash;
    uint32_t entry = CLAST_NONE;
    while (status == CLAST_OK && (entry = clast_table_next(&library->texture_table, hash, &place)) != CLAST_NONE) {
        if (strcmp(library->textures[entry].name, name) == 0) {
            *number = library->textures[entry].number;
            break;
        }
    }
    if (status == CLAST_OK && entry == CLAST_NONE) {
        status = make_texture(library, use, first, second, clamp, number);
        if (status == CLAST_OK) {
            clast_table_insert(&library->texture_table, hash, place, (uint32_t)library->texture_count);
            library->textures[library->texture_count++] = (clast_mtl_entry){name, *number};
            return CLAST_OK;
        }
    }
    clast_free(context, name);
    return status;
}

clast_status clast_mtl_texture(clast_mtl *library, clast_mtl_texture_use use, const clast_mtl_map *first,
                               const clast_mtl_map *second, clast_texture_slot *slot)
{
    const clast_mtl_map *leading = first->path != NULL || second == NULL ? first : second;
    if (leading->path == NULL) {
        return CLAST_OK;
    }
    clast_status status = find_texture(library, use, first, second, leading->clamp, &slot->texture);
    // MTL maps (u, v), v upwards, to (u s + o, v s + o); clast's v goes downwards.
    slot->scale[0] = leading->scale[0];
    slot->scale[1] = leading->scale[1];
    slot->offset[0] = leading->offset[0];
    slot->offset[1] = 1.0f - leading->scale[1] - leading->offset[1];
    return status;
}
