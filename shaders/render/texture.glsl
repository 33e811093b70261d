// SPDX-License-Identifier: Apache-2.0
// Values of textures: the twin of src/render/texture.c. Texels are fetched by number and blended by shared formulas, so the
// values are those of the processor, to the bit where the coordinates are.
#ifndef CLAST_RENDER_TEXTURE_GLSL
#define CLAST_RENDER_TEXTURE_GLSL

#include "render/tables.glsl"
#include "textures.glsl"
#include "shared/device_materials.h"
#include "shared/ray_cone.h"

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
    if (encoding_is_srgb(encoding)) {
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

vec4 fetch_texel(materials_reference all, clast_device_image image, uint level, uint x, uint y)
{
    if (format_block(image.format) != BLOCK_NONE) {
        return fetch_compressed_texel(all, image, x, y);
    }
    return texelFetch(textures[nonuniformEXT(image.texture)], ivec2(x, y), int(level));
}

// As red, green, blue, alpha: grey counts for all colours, a missing alpha is one. `level` is of the device's texture.
vec4 level_texel(materials_reference all, clast_device_image image, uint level, uint x, uint y, uint encoding)
{
    uint channels = format_channels(image.format);
    uint type = format_type(image.format);
    vec4 stored = fetch_texel(all, image, level, x, y);
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

vec4 level_blend(materials_reference all, clast_device_image image, uint level, clast_texel_pair x, clast_texel_pair y,
                 uint encoding)
{
    vec4 upper = blend_texels(level_texel(all, image, level, x.first, y.first, encoding),
                              level_texel(all, image, level, x.second, y.first, encoding), x.weight);
    vec4 lower = blend_texels(level_texel(all, image, level, x.first, y.second, encoding),
                              level_texel(all, image, level, x.second, y.second, encoding), x.weight);
    return blend_texels(upper, lower, y.weight);
}

vec4 image_blend(materials_reference all, clast_device_image image, clast_texel_pair x, clast_texel_pair y, uint encoding)
{
    return level_blend(all, image, 0u, x, y, encoding);
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

// On a level of so many texels. The texture's own filter counts on the finest.
texture_place place_on_level(clast_device_texture_use use, vec2 at, uint level)
{
    uint kind = level == 0u ? reading_filter(use.reading) : CLAST_FILTER_LINEAR;
    texture_place place;
    place.x = texels_along(at[0], reading_wrap_u(use.reading), max_uint(size_width(use.image.size) >> level, 1u), kind);
    place.y = texels_along(at[1], reading_wrap_v(use.reading), max_uint(size_height(use.image.size) >> level, 1u), kind);
    return place;
}

// Where a point of a surface is in textures, and how much of them a sample sees there: clast_texture_area.
struct texture_area
{
    vec2 coordinates[2];
    clast_footprint footprints[2];
    uint look; // LOOK_: how closely at these
};

// A point, as the finest level has it.
texture_area texture_point(vec2 coordinates[2])
{
    texture_area area;
    area.coordinates = coordinates;
    area.footprints[0] = area.footprints[1] = no_footprint();
    area.look = LOOK_POINT;
    return area;
}

clast_texture_taps taps_of(clast_device_texture_use use, clast_footprint footprint, uint look)
{
    clast_footprint there;
    there.first = store2(device_difference(use, load2(footprint.first)));
    there.second = store2(device_difference(use, load2(footprint.second)));
    return texture_taps(there, size_width(use.image.size), size_height(use.image.size), use.level_count, look);
}

bool has_texture(material_reference material, uint slot) { return material.of.uses[slot].image.texture != CLAST_NONE; }

vec4 read_level(materials_reference all, clast_device_texture_use use, vec2 at, uint level, uint encoding)
{
    texture_place place = place_on_level(use, at, level);
    clast_device_image image = use.image;
    if (level != 0u) {
        image = use.levels;
    }
    return level_blend(all, image, level != 0u ? level - 1u : 0u, place.x, place.y, encoding);
}

// A material's texture at a place of a surface; `otherwise` where there is none. Of a normal map, the fourth value is what the
// mean normal's length lacks of one. One loop goes over all points and both levels of each, as reading a level is long.
vec4 texture_value(materials_reference all, material_reference material, uint slot, texture_area area, uint encoding,
                   vec4 otherwise)
{
    if (!has_texture(material, slot)) {
        return otherwise;
    }
    clast_device_texture_use use = material.of.uses[slot];
    bool is_second = reading_set(use.reading) != 0u;
    clast_footprint footprint = area.footprints[0];
    if (is_second) {
        footprint = area.footprints[1];
    }
    clast_texture_taps taps = taps_of(use, footprint, area.look);
    vec2 at = device_coordinates(use, is_second ? area.coordinates[1] : area.coordinates[0]) + load2(taps.first);
    uint level = to_uint(taps.level);
    precise float part = taps.level - to_float(level);
    uint shift = part > 0.0f ? 1u : 0u;
    bool joins_normals = encoding == ENCODING_NORMAL && !taps_are_one_point(taps);
    vec4 mean = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    vec4 finer = mean;
    [[dont_unroll]] for (uint i = 0u; i < taps.count << shift; i++) {
        uint coarser = i & shift;
        vec4 value = read_level(all, use, at, level + coarser, encoding);
        if (joins_normals) {
            value = normal_vector(value, level + coarser);
        }
        if (coarser != shift) {
            finer = value;
            continue;
        }
        value = shift != 0u ? blend_texels(finer, value, part) : value;
        mean = mean_with(mean, value, i >> shift);
        at = at + load2(taps.step);
    }
    if (encoding == ENCODING_NORMAL) {
        mean = joins_normals ? normal_value(mean) : vec4(mean[0], mean[1], mean[2], 0.0f);
    }
    return mean;
}

float image_alpha(materials_reference all, clast_device_image image, uint x, uint y)
{
    vec4 stored = fetch_texel(all, image, 0u, x, y);
    return texel_number(format_channels(image.format) == 2u ? stored[1] : stored[3], format_type(image.format));
}

// The alpha alone, on the finest level.
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
    vec2 at = device_coordinates(use, reading_set(use.reading) != 0u ? coordinates[1] : coordinates[0]);
    texture_place place = place_on_level(use, at, 0u);
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
