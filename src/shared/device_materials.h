// SPDX-License-Identifier: Apache-2.0
// Materials and pictures as they lie in a device's memory.
#ifndef CLAST_SHARED_DEVICE_MATERIALS_H
#define CLAST_SHARED_DEVICE_MATERIALS_H

#include "shared/block.h"
#include "shared/scatter.h"
#include "shared/surface.h"
#include "shared/texture_filter.h"

// A picture that kernels read: integers lie in it as fractions of their largest, three channels as four. Or compressed: then it is
// no texture of the device's, but blocks that the kernels look into.
RECORD(clast_device_image)
{
    uint texture; // among the device's, or into clast_device_materials.blocks; CLAST_NONE for none
    uint format;  // image_format()
    uint size;    // image_size()
};
RECORD_SIZE(clast_device_image, 12)

// Of 1 to 4 channels; CLAST_PIXEL_: what its numbers were before; BLOCK_: how it is compressed.
FN uint image_format(uint channels, uint type, uint block) { return channels | type << 8u | block << 16u; }
FN uint format_channels(uint format) { return format & 255u; }
FN uint format_type(uint format) { return format >> 8u & 255u; }
FN uint format_block(uint format) { return format >> 16u; }
// Up to 65536 texels a side.
FN uint image_size(uint width, uint height) { return (width - 1u) | (height - 1u) << 16u; }
FN uint size_width(uint size) { return (size & 65535u) + 1u; }
FN uint size_height(uint size) { return (size >> 16u) + 1u; }

// A texture as a material uses it: clast_texture_use with its texture and image.
RECORD(clast_device_texture_use)
{
    clast_device_image image;
    clast_device_image levels; // of the image, the finest of them the first below it; texture CLAST_NONE for none
    uint level_count;
    uint reading; // texture_reading()
    packed2 offset;
    packed2 scale;
    float cosine; // of the rotation
    float sine;
};
RECORD_SIZE(clast_device_texture_use, 56)

LIMIT(READING_TURNED, 256u, "the coordinates are rotated")

// CLAST_WRAP_ both ways, CLAST_FILTER_, and which set of coordinates.
FN uint texture_reading(uint wrap_u, uint wrap_v, uint kind, uint set, bool turned)
{
    return wrap_u | wrap_v << 2u | kind << 4u | (set & 1u) << 6u | (turned ? READING_TURNED : 0u);
}
FN uint reading_wrap_u(uint reading) { return reading & 3u; }
FN uint reading_wrap_v(uint reading) { return reading >> 2u & 3u; }
FN uint reading_filter(uint reading) { return reading >> 4u & 3u; }
FN uint reading_set(uint reading) { return reading >> 6u & 1u; }

// transform_coordinates() of a texture on a device; of a difference, without the offset.
FN vec2 device_difference(clast_device_texture_use use, vec2 coordinates)
{
    vec2 scaled = coordinates * load2(use.scale);
    bool turned = (use.reading & READING_TURNED) != 0u;
    return turned ? turn_coordinates(scaled, use.cosine, use.sine) : scaled;
}

FN vec2 device_coordinates(clast_device_texture_use use, vec2 coordinates)
{
    return device_difference(use, coordinates) + load2(use.offset);
}

// X(name, number, member of clast_material, what its values mean): the textures that shading reads.
#define CLAST_TEXTURE_SLOT_LIST(X) \
    X(SLOT_BASE_COLOUR, 0u, base_colour_texture, ENCODING_SRGB) \
    X(SLOT_METALLIC_ROUGHNESS, 1u, metallic_roughness_texture, ENCODING_LINEAR) \
    X(SLOT_NORMAL, 2u, normal_texture, ENCODING_NORMAL) \
    X(SLOT_EMISSIVE, 3u, emissive_texture, ENCODING_SRGB) \
    X(SLOT_SPECULAR, 4u, specular_texture, ENCODING_LINEAR) \
    X(SLOT_SPECULAR_COLOUR, 5u, specular_colour_texture, ENCODING_SRGB) \
    X(SLOT_CLEARCOAT, 6u, clearcoat_texture, ENCODING_LINEAR) \
    X(SLOT_CLEARCOAT_ROUGHNESS, 7u, clearcoat_roughness_texture, ENCODING_LINEAR) \
    X(SLOT_CLEARCOAT_NORMAL, 8u, clearcoat_normal_texture, ENCODING_NORMAL) \
    X(SLOT_SHEEN_COLOUR, 9u, sheen_colour_texture, ENCODING_SRGB) \
    X(SLOT_SHEEN_ROUGHNESS, 10u, sheen_roughness_texture, ENCODING_LINEAR) \
    X(SLOT_ANISOTROPY, 11u, anisotropy_texture, ENCODING_LINEAR) \
    X(SLOT_TRANSMISSION, 12u, transmission_texture, ENCODING_LINEAR) \
    X(SLOT_IRIDESCENCE, 13u, iridescence_texture, ENCODING_LINEAR) \
    X(SLOT_IRIDESCENCE_THICKNESS, 14u, iridescence_thickness_texture, ENCODING_LINEAR) \
    X(SLOT_DIFFUSE_TRANSMISSION, 15u, diffuse_transmission_texture, ENCODING_LINEAR) \
    X(SLOT_DIFFUSE_TRANSMISSION_COLOUR, 16u, diffuse_transmission_colour_texture, ENCODING_SRGB)
#define SLOT_ENTRY(name, number, member, encoding) LIMIT(name, number, "a texture of a material")
CLAST_TEXTURE_SLOT_LIST(SLOT_ENTRY)
LIMIT(TEXTURE_SLOTS, 17u, "of a material")

// What a slot's values mean in a material. Colours that cut a surface out, or blend it, count as far as they are there.
FN uint slot_encoding(uint slot, uint encoding, uint alpha_mode)
{
    return slot == SLOT_BASE_COLOUR && alpha_mode != CLAST_ALPHA_OPAQUE ? ENCODING_CUTOUT : encoding;
}

RECORD(clast_device_material)
{
    clast_material record;
    clast_device_texture_use uses[TEXTURE_SLOTS]; // in place of the record's own
    uint glass; // number of its first table, CLAST_NONE where it is no border of a volume
};
RECORD_SIZE(clast_device_material, 720 + 17 * 56 + 4)

RECORD(clast_device_materials)
{
    packed_address materials; // clast_device_material; number 0 is always there
    packed_address linear8;   // what sRGB's 256 values are
    packed_address linear16;  // and its 65536 values; 0 where no picture has 16 bits
    packed_address ggx;       // GGX_TABLES floats: the tables of shared/brdf.h
    packed_address sheen;     // SCATTER_CELLS floats: what fuzz gives back
    packed_address glass;     // likewise, GLASS_TABLES for each index of refraction
    packed_address blocks;    // packed_address of each compressed picture's blocks, row by row from the top
    uint material_count;
};
RECORD_SIZE(clast_device_materials, 60)

#endif
