// SPDX-License-Identifier: Apache-2.0
// Values of textures: the twin of src/render/texture.c. Texels are fetched by number and blended by shared formulas, so the
// values are those of the processor, to the bit where the coordinates are.
#ifndef CLAST_RENDER_TEXTURE_GLSL
#define CLAST_RENDER_TEXTURE_GLSL

#include "render/tables.glsl"
#include "textures.glsl"
#include "shared/device_materials.h"

ARRAY_OF(addresses, packed_address, 4)
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer materials_reference { clast_device_materials of; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer material_reference { clast_device_material of; };

// The material of a number; the first where there is none.
material_reference material_at(materials_reference all, uint number)
{
    return material_reference(load_address(all.of.materials)) + (number < all.of.material_count ? number : 0u);
}

// ------------------------------------------------------------------------------------------------------------- texels

// A number of a picture, from what the device made of it.
FN float texel_number(float stored, uint type)
{
    float number = stored;
    if (type == CLAST_PIXEL_UNORM8) {
        number = unorm8(to_uint(stored * 255.0f + 0.5f));
    } else if (type == CLAST_PIXEL_UNORM16) {
        number = unorm16(to_uint(stored * 65535.0f + 0.5f));
    }
    return number;
}

FN float texel_colour(materials_reference all, float stored, uint type, uint encoding)
{
    float colour = texel_number(stored, type);
    if (encoding == ENCODING_SRGB) {
        if (type == CLAST_PIXEL_UNORM8) {
            colour = floats(load_address(all.of.linear8)).at[to_uint(stored * 255.0f + 0.5f)];
        } else if (type == CLAST_PIXEL_UNORM16) {
            colour = floats(load_address(all.of.linear16)).at[to_uint(stored * 65535.0f + 0.5f)];
        }
    }
    return colour;
}

vec4 fetch_compressed_texel(materials_reference all, clast_device_image image, uint x, uint y)
{
    uint kind = format_block(image.format);
    uint64_t words = kind == BLOCK_BC1 || kind == BLOCK_BC4 ? 2ul : 4ul;
    uint64_t across = uint64_t((size_width(image.size) + 3u) / 4u);
    uint64_t number = uint64_t(y / 4u) * across + uint64_t(x / 4u);
    uint64_t address = load_address(addresses(load_address(all.of.blocks)).at[image.texture]);
    uints block = uints(address + 4ul * words * number);
    uvec2 first = uvec2(block.at[0], block.at[1]);
    uvec2 second = words == 4ul ? uvec2(block.at[2], block.at[3]) : uvec2(0u, 0u);
    uint texel = block_texel(kind, first[0], first[1], second[0], second[1], (y & 3u) * 4u + (x & 3u));
    return vec4(unorm8(texel & 255u), unorm8(texel >> 8u & 255u), unorm8(texel >> 16u & 255u), unorm8(texel >> 24u));
}

vec4 fetch_texel(materials_reference all, clast_device_image image, uint x, uint y)
{
    if (format_block(image.format) != BLOCK_NONE) {
        return fetch_compressed_texel(all, image, x, y);
    }
    return texelFetch(textures[nonuniformEXT(image.texture)], ivec2(x, y), 0);
}

// As red, green, blue, alpha: grey counts for all colours, a missing alpha is one.
vec4 image_texel(materials_reference all, clast_device_image image, uint x, uint y, uint encoding)
{
    uint channels = format_channels(image.format);
    uint type = format_type(image.format);
    vec4 stored = fetch_texel(all, image, x, y);
    float first = texel_colour(all, stored[0], type, encoding);
    vec4 texel = vec4(first, first, first, 1.0f);
    if (channels >= 3u) {
        texel[1] = texel_colour(all, stored[1], type, encoding);
        texel[2] = texel_colour(all, stored[2], type, encoding);
    }
    if (channels == 2u || channels == 4u) {
        texel[3] = texel_number(channels == 2u ? stored[1] : stored[3], type);
    }
    return texel;
}

vec4 image_blend(materials_reference all, clast_device_image image, clast_texel_pair x, clast_texel_pair y, uint encoding)
{
    vec4 upper = mix4(image_texel(all, image, x.first, y.first, encoding),
                      image_texel(all, image, x.second, y.first, encoding), x.weight);
    vec4 lower = mix4(image_texel(all, image, x.first, y.second, encoding),
                      image_texel(all, image, x.second, y.second, encoding), x.weight);
    return mix4(upper, lower, y.weight);
}

// ----------------------------------------------------------------------------------------------------------- textures

// Which texels are read, and with what weights. A pair with weight zero where the nearest is wanted.
struct texture_place
{
    clast_texel_pair x, y;
};

clast_texel_pair texels_along(float coordinate, uint wrap, uint size, uint kind)
{
    clast_texel_pair texels = linear_texels(coordinate, wrap, size);
    if (kind == CLAST_FILTER_NEAREST) {
        texels.first = nearest_texel(coordinate, wrap, size);
        texels.second = texels.first;
        texels.weight = 0.0f;
    }
    return texels;
}

texture_place place_in_texture(clast_device_texture_use use, vec2 coordinates[2])
{
    vec2 at = device_coordinates(use, reading_set(use.reading) != 0u ? coordinates[1] : coordinates[0]);
    uint kind = reading_filter(use.reading);
    texture_place place;
    place.x = texels_along(at[0], reading_wrap_u(use.reading), size_width(use.image.size), kind);
    place.y = texels_along(at[1], reading_wrap_v(use.reading), size_height(use.image.size), kind);
    return place;
}

bool has_texture(material_reference material, uint slot) { return material.of.uses[slot].image.texture != CLAST_NONE; }

// A material's texture at a surface's coordinates; `otherwise` where there is none.
vec4 texture_value(materials_reference all, material_reference material, uint slot, vec2 coordinates[2], uint encoding,
                   vec4 otherwise)
{
    if (!has_texture(material, slot)) {
        return otherwise;
    }
    clast_device_texture_use use = material.of.uses[slot];
    texture_place place = place_in_texture(use, coordinates);
    if (reading_filter(use.reading) == CLAST_FILTER_NEAREST) {
        return image_texel(all, use.image, place.x.first, place.y.first, encoding);
    }
    return image_blend(all, use.image, place.x, place.y, encoding);
}

float image_alpha(materials_reference all, clast_device_image image, uint x, uint y)
{
    vec4 stored = fetch_texel(all, image, x, y);
    return texel_number(format_channels(image.format) == 2u ? stored[1] : stored[3], format_type(image.format));
}

// Its alpha alone.
float texture_alpha(materials_reference all, material_reference material, uint slot, vec2 coordinates[2])
{
    if (!has_texture(material, slot)) {
        return 1.0f;
    }
    clast_device_texture_use use = material.of.uses[slot];
    uint channels = format_channels(use.image.format);
    if (channels == 1u || channels == 3u) {
        return 1.0f;
    }
    texture_place place = place_in_texture(use, coordinates);
    float alpha = image_alpha(all, use.image, place.x.first, place.y.first);
    if (reading_filter(use.reading) != CLAST_FILTER_NEAREST) {
        float upper = mix1(alpha, image_alpha(all, use.image, place.x.second, place.y.first), place.x.weight);
        float lower = mix1(image_alpha(all, use.image, place.x.first, place.y.second),
                           image_alpha(all, use.image, place.x.second, place.y.second), place.x.weight);
        alpha = mix1(upper, lower, place.y.weight);
    }
    return alpha;
}

#endif
