// SPDX-License-Identifier: Apache-2.0
// Texels of every kind of image, blended as shared/texture_filter.h says.
#include "render/texture.h"

void clast_srgb_table_fill(clast_srgb_table *table)
{
    for (uint32_t i = 0; i < 256; i++) {
        table->linear[i] = srgb_to_linear((float)i / 255.0f);
    }
}

// Channel `channel` of a texel that begins at element `first`.
static float element(const clast_image *image, size_t first, uint32_t channel, const clast_srgb_table *table)
{
    if (image->type == CLAST_PIXEL_UNORM8) {
        uint8_t value = ((const uint8_t *)image->pixels)[first + channel];
        return table != NULL ? table->linear[value] : (float)value * (1.0f / 255.0f);
    }
    if (image->type == CLAST_PIXEL_UNORM16) {
        float value = (float)((const uint16_t *)image->pixels)[first + channel] * (1.0f / 65535.0f);
        return table != NULL ? srgb_to_linear(value) : value;
    }
    return ((const float *)image->pixels)[first + channel];
}

vec4 clast_image_texel(const clast_image *image, uint32_t x, uint32_t y, const clast_srgb_table *table)
{
    uint32_t channels = image->channels;
    size_t first = ((size_t)y * image->width + x) * channels;
    float alpha = channels == 2 || channels == 4 ? element(image, first, channels - 1, NULL) : 1.0f;
    float red = element(image, first, 0, table);
    if (channels < 3) {
        return vec4(red, red, red, alpha);
    }
    return vec4(red, element(image, first, 1, table), element(image, first, 2, table), alpha);
}

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

vec4 clast_texture_value(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2], const clast_srgb_table *table,
                         vec4 otherwise)
{
    const clast_image *image;
    const clast_texture *texture = find_texture(scene, use, &image);
    if (texture == NULL) {
        return otherwise;
    }
    vec2 place = transform_coordinates(use, coordinates[use.coordinate_set & 1]);
    if (texture->filter == CLAST_FILTER_NEAREST) {
        uint32_t x = nearest_texel(place[0], texture->wrap_u, image->width);
        return clast_image_texel(image, x, nearest_texel(place[1], texture->wrap_v, image->height), table);
    }
    clast_texel_pair x = linear_texels(place[0], texture->wrap_u, image->width);
    clast_texel_pair y = linear_texels(place[1], texture->wrap_v, image->height);
    vec4 upper = clast_image_texel(image, x.first, y.first, table) * (1.0f - x.weight) +
                 clast_image_texel(image, x.second, y.first, table) * x.weight;
    vec4 lower = clast_image_texel(image, x.first, y.second, table) * (1.0f - x.weight) +
                 clast_image_texel(image, x.second, y.second, table) * x.weight;
    return upper * (1.0f - y.weight) + lower * y.weight;
}

static float texel_alpha(const clast_image *image, uint32_t x, uint32_t y)
{
    size_t first = ((size_t)y * image->width + x) * image->channels;
    return element(image, first, image->channels - 1, NULL);
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
