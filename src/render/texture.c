// SPDX-License-Identifier: Apache-2.0
// Texels of every kind of image, blended as shared/texture_filter.h says.
#include "render/texture.h"

void clast_srgb_table_fill(clast_srgb_table *table)
{
    for (uint32_t i = 0; i < 256; i++) {
        table->linear[i] = srgb_to_linear(unorm8(i));
        table->plain[i] = unorm8(i);
    }
}

// ------------------------------------------------------------------------------------------------------------- texels

// Channels 1 to 4 as red, green, blue, alpha. Always inlined into a loop over texels of one type.
#define SPREAD(channels, colour, alpha) \
    ((channels) < 3 ? vec4(colour(0), colour(0), colour(0), (channels) == 2 ? alpha(1) : 1.0f) \
                    : vec4(colour(0), colour(1), colour(2), (channels) == 4 ? alpha(3) : 1.0f))

static inline vec4 texel8(const clast_image *image, size_t place, const float colours[256], const float plain[256])
{
    const uint8_t *texel = (const uint8_t *)image->pixels + place * image->channels;
#define COLOUR(c) colours[texel[c]]
#define ALPHA(c) plain[texel[c]]
    return SPREAD(image->channels, COLOUR, ALPHA);
#undef COLOUR
#undef ALPHA
}

static inline float decode16(uint16_t value, clast_encoding encoding)
{
    float plain = unorm16(value);
    return encoding_is_srgb(encoding) ? srgb_to_linear(plain) : plain;
}

static inline vec4 texel16(const clast_image *image, size_t place, clast_encoding encoding)
{
    const uint16_t *texel = (const uint16_t *)image->pixels + place * image->channels;
#define COLOUR(c) decode16(texel[c], encoding)
#define ALPHA(c) decode16(texel[c], CLAST_ENCODING_LINEAR)
    return SPREAD(image->channels, COLOUR, ALPHA);
#undef COLOUR
#undef ALPHA
}

static vec4 texel_float(const clast_image *image, size_t place)
{
    const float *texel = (const float *)image->pixels + place * image->channels;
#define VALUE(c) texel[c]
    return SPREAD(image->channels, VALUE, VALUE);
#undef VALUE
}

vec4 clast_image_texel(const clast_image *image, uint32_t x, uint32_t y, clast_encoding encoding,
                       const clast_srgb_table *table)
{
    size_t place = (size_t)y * image->width + x;
    switch (image->type) {
    case CLAST_PIXEL_UNORM8:
        return texel8(image, place, encoding_is_srgb(encoding) ? table->linear : table->plain, table->plain);
    case CLAST_PIXEL_UNORM16: return texel16(image, place, encoding);
    default: return texel_float(image, place);
    }
}

// Of the four texels of two pairs.
#define BLEND_TEXELS(texel) \
    blend_texels(blend_texels(texel(x.first, y.first), texel(x.second, y.first), x.weight), \
                 blend_texels(texel(x.first, y.second), texel(x.second, y.second), x.weight), y.weight)
#define PLACE(column, row) ((size_t)(row)*image->width + (column))

vec4 clast_image_blend(const clast_image *image, clast_texel_pair x, clast_texel_pair y, clast_encoding encoding,
                       const clast_srgb_table *table)
{
    if (image->type == CLAST_PIXEL_UNORM8) { // nearly all textures: one decision for four texels
        const float *colours = encoding_is_srgb(encoding) ? table->linear : table->plain;
#define TEXEL(column, row) texel8(image, PLACE(column, row), colours, table->plain)
        return BLEND_TEXELS(TEXEL);
#undef TEXEL
    }
    if (image->type == CLAST_PIXEL_UNORM16 && !encoding_is_srgb(encoding)) { // and levels of normal maps
#define TEXEL(column, row) texel16(image, PLACE(column, row), CLAST_ENCODING_LINEAR)
        return BLEND_TEXELS(TEXEL);
#undef TEXEL
    }
#define TEXEL(column, row) clast_image_texel(image, column, row, encoding, table)
    return BLEND_TEXELS(TEXEL);
#undef TEXEL
}

// ----------------------------------------------------------------------------------------------------------- textures

static const clast_texture *find_texture(const clast_scene *scene, clast_texture_use use, const clast_image **image)
{
    if (use.texture >= scene->texture_count) {
        return NULL;
    }
    const clast_texture *texture = &scene->textures[use.texture];
    if (texture->image >= scene->image_count) {
        return NULL;
    }
    *image = &scene->images[texture->image].image;
    return (*image)->width != 0 && (*image)->height != 0 ? texture : NULL;
}

// The picture of a level: the finest is the image itself.
static clast_image level_of(const clast_scene_image *image, const clast_image_levels *levels, uint32_t level)
{
    return level == 0 ? image->image : clast_level_image(&image->image, levels, level);
}

// What is read of a texture.
typedef struct reading {
    const clast_texture *texture;
    const clast_scene_image *image;
    const clast_image_levels *levels;
    clast_encoding encoding;
    const clast_srgb_table *table;
    vec2 middle;
    clast_texture_taps taps;
} reading;

static reading read_place(const clast_scene *scene, const clast_texture *texture, clast_texture_use use,
                          const clast_texture_area *area, clast_encoding encoding)
{
    uint32_t set = use.coordinate_set & 1;
    const clast_scene_image *image = &scene->images[texture->image];
    const clast_image_levels *levels = &image->levels[clast_levels_encoding(&image->image, encoding)];
    clast_footprint footprint = transform_footprint(use, area->footprints[set]);
    return (reading){
        .texture = texture,
        .image = image,
        .levels = levels,
        .encoding = encoding,
        .middle = transform_coordinates(use, area->coordinates[set]),
        .taps = texture_taps(footprint, image->image.width, image->image.height, levels->count, area->look),
    };
}

static vec4 read_level(const reading *from, vec2 place, uint32_t level)
{
    clast_image image = level_of(from->image, from->levels, level);
    const clast_texture *texture = from->texture;
    vec4 value;
    if (level == 0 && texture->filter == CLAST_FILTER_NEAREST) {
        uint32_t x = nearest_texel(place[0], texture->wrap_u, image.width);
        uint32_t y = nearest_texel(place[1], texture->wrap_v, image.height);
        value = clast_image_texel(&image, x, y, from->encoding, from->table);
    } else {
        clast_texel_pair x = linear_texels(place[0], texture->wrap_u, image.width);
        clast_texel_pair y = linear_texels(place[1], texture->wrap_v, image.height);
        value = clast_image_blend(&image, x, y, from->encoding, from->table);
    }
    return value;
}

static vec4 read_tap(const reading *from, vec2 place)
{
    uint32_t level = to_uint(from->taps.level);
    float part = from->taps.level - to_float(level);
    vec4 value = read_level(from, place, level), coarser = value;
    if (part > 0.0f) {
        coarser = read_level(from, place, level + 1);
    }
    if (from->encoding == CLAST_ENCODING_NORMAL) {
        value = normal_vector(value, level);
        coarser = normal_vector(coarser, level + 1);
    }
    return part > 0.0f ? blend_texels(value, coarser, part) : value;
}

static vec4 read_taps(const reading *from)
{
    const clast_texture_taps *taps = &from->taps;
    vec2 place = from->middle + load2(taps->first);
    vec4 mean = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (uint32_t i = 0; i < taps->count; i++) {
        mean = mean_with(mean, read_tap(from, place), i);
        place = place + load2(taps->step);
    }
    return from->encoding == CLAST_ENCODING_NORMAL ? normal_value(mean) : mean;
}

vec4 clast_texture_value(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                         clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise)
{
    const clast_image *image;
    const clast_texture *texture = find_texture(scene, use, &image);
    if (texture == NULL) {
        return otherwise;
    }
    reading from = read_place(scene, texture, use, area, encoding);
    from.table = table;
    if (taps_are_one_point(from.taps)) { // most of what is near
        vec4 value = read_level(&from, from.middle, 0);
        return encoding == CLAST_ENCODING_NORMAL ? vec4(value[0], value[1], value[2], 0.0f) : value;
    }
    return read_taps(&from);
}

static size_t texel_bytes(const clast_image *image)
{
    size_t element = image->type == CLAST_PIXEL_UNORM8 ? 1 : image->type == CLAST_PIXEL_UNORM16 ? 2 : 4;
    return element * image->channels;
}

void clast_texture_prefetch(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                            clast_encoding encoding)
{
    const clast_image *finest;
    const clast_texture *texture = find_texture(scene, use, &finest);
    if (texture == NULL) {
        return;
    }
    reading from = read_place(scene, texture, use, area, encoding);
    clast_image image = level_of(from.image, from.levels, to_uint(from.taps.level));
    clast_texel_pair x = linear_texels(from.middle[0], texture->wrap_u, image.width);
    clast_texel_pair y = linear_texels(from.middle[1], texture->wrap_v, image.height);
    const char *pixels = image.pixels;
    size_t bytes = texel_bytes(&image);
    __builtin_prefetch(pixels + ((size_t)y.first * image.width + x.first) * bytes);
    __builtin_prefetch(pixels + ((size_t)y.second * image.width + x.first) * bytes);
}

static float texel_alpha(const clast_image *image, uint32_t x, uint32_t y)
{
    size_t element = ((size_t)y * image->width + x) * image->channels + image->channels - 1;
    switch (image->type) {
    case CLAST_PIXEL_UNORM8: return unorm8(((const uint8_t *)image->pixels)[element]);
    case CLAST_PIXEL_UNORM16: return unorm16(((const uint16_t *)image->pixels)[element]);
    default: return ((const float *)image->pixels)[element];
    }
}

float clast_texture_alpha(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2])
{
    const clast_image *image;
    const clast_texture *texture = find_texture(scene, use, &image);
    if (texture == NULL || image->channels == 1 || image->channels == 3) {
        return 1.0f;
    }
    vec2 place = transform_coordinates(use, coordinates[use.coordinate_set & 1]);
    if (texture->filter == CLAST_FILTER_NEAREST) {
        uint32_t x = nearest_texel(place[0], texture->wrap_u, image->width);
        return texel_alpha(image, x, nearest_texel(place[1], texture->wrap_v, image->height));
    }
    clast_texel_pair x = linear_texels(place[0], texture->wrap_u, image->width);
    clast_texel_pair y = linear_texels(place[1], texture->wrap_v, image->height);
    float upper = mix1(texel_alpha(image, x.first, y.first), texel_alpha(image, x.second, y.first), x.weight);
    float lower = mix1(texel_alpha(image, x.first, y.second), texel_alpha(image, x.second, y.second), x.weight);
    return mix1(upper, lower, y.weight);
}
