// SPDX-License-Identifier: Apache-2.0
// Records that cross between CPU, GPU and disk. Every member is 4-byte aligned, so that C and GLSL (scalar layout) agree
// without padding. Smaller fields are bits of a uint.
#ifndef CLAST_SHARED_RECORDS_H
#define CLAST_SHARED_RECORDS_H

#include "shared/dialect.h"
#include "shared/limits.h"

RECORD(clast_box)
{
    packed3 lower;
    packed3 upper;
};
RECORD_SIZE(clast_box, 24)

// An affine map, as three rows of four: x' = row0 . (x, y, z, 1).
RECORD(clast_transform)
{
    packed4 rows[3];
};
RECORD_SIZE(clast_transform, 48)

// How a record's triangles follow from templates.
LIMIT(FORM_WHOLE, 0u, "one template")
LIMIT(FORM_COMPOSITE, 1u, "consecutive small patterns: the source tells the corners of its triangles")

// One cluster of a frame: a template, where its vertices go, and what surface it came from.
RECORD(clast_cluster_record)
{
    uint unit;             // which unit of the frame
    uint template_index;   // whole: into the frame's template set
    uint first_vertex;     // into the unit's vertices of this frame
    uint item;             // the source's own: which cooked cluster, tile or base triangle
    uint form_and_counts;  // record_form(), record_triangles(), record_vertices()
    uint detail;           // the source's own: level, segments or factors
    uint first_word;       // into the unit's words of this frame: what else the source must know of the record
};
RECORD_SIZE(clast_cluster_record, 28)

FN uint form_and_counts(uint form, uint triangles, uint vertices) { return form | triangles << 8u | vertices << 17u; }
FN uint record_form(clast_cluster_record record) { return record.form_and_counts & 255u; }
FN uint record_triangles(clast_cluster_record record) { return record.form_and_counts >> 8u & 511u; }
FN uint record_vertices(clast_cluster_record record) { return record.form_and_counts >> 17u & 511u; }

// What a unit's item needs at a rate. Each stays at 2^32 - 1 where it would be more.
RECORD(clast_source_count)
{
    uint clusters;
    uint triangles;
    uint vertices;
    uint words;
    uint blocks; // of composite clusters: blocks of BLOCK_TRIANGLES, the last of each cluster begun
};
RECORD_SIZE(clast_source_count, 20)

// What a ray or a pixel saw: the visibility buffer's element.
RECORD(clast_visibility)
{
    uint instance; // CLAST_NONE where nothing
    uint cluster;
    uint triangle;
    packed2 barycentrics; // weights of the triangle's second and third corner
    float distance;       // along the ray
    packed3 normal;       // geometric, world space, unit length, counter-clockwise side
    uint steps;           // tree nodes visited
};
RECORD_SIZE(clast_visibility, 40)

// Where on a source's surface: what a hit becomes by `locate`.
RECORD(clast_surface_point)
{
    uint primitive;       // the source's own: base triangle, patch or tile
    packed2 coordinates;  // barycentrics of the base triangle's second and third corner, or a patch's (u, v)
    float level;          // of a displacement map there; 0 where there is none
};
RECORD_SIZE(clast_surface_point, 16)

// A texture as a material uses it.
RECORD(clast_texture_use)
{
    uint texture;         // into the scene's textures, CLAST_NONE for none
    uint coordinate_set;  // 0 or 1
    packed2 offset;       // KHR_texture_transform
    packed2 scale;
    float rotation;       // radians
};
RECORD_SIZE(clast_texture_use, 28)

LIMIT(MATERIAL_SPECULAR, 1u, "an index of refraction or a specular colour of its own")
LIMIT(MATERIAL_CLEARCOAT, 2u, "a clear coat")
LIMIT(MATERIAL_SHEEN, 4u, "fuzz")
LIMIT(MATERIAL_ANISOTROPY, 8u, "stretched highlights")
LIMIT(MATERIAL_TRANSMISSION, 16u, "what is not metal is clear")
LIMIT(MATERIAL_IRIDESCENCE, 32u, "a thin film")
LIMIT(MATERIAL_DIFFUSE_TRANSMISSION, 64u, "diffuse light passes")

// glTF 2.0 metallic-roughness, and its extensions.
RECORD(clast_material)
{
    packed4 base_colour;      // linear; fourth is alpha
    packed3 emissive;         // linear, times strength
    float metallic;
    float roughness;
    float normal_scale;
    float occlusion_strength; // kept for export: path tracing computes occlusion
    float alpha_cutoff;
    uint alpha_mode;          // CLAST_ALPHA_
    uint double_sided;
    clast_texture_use base_colour_texture;
    clast_texture_use metallic_roughness_texture; // green is roughness, blue is metallic
    clast_texture_use normal_texture;
    clast_texture_use occlusion_texture;
    clast_texture_use emissive_texture;
    clast_texture_use displacement_texture; // red: a height of texel * displacement_scale + displacement_offset
    float displacement_scale;
    float displacement_offset;
    uint layers;              // MATERIAL_ bits: what must be looked at beside the above
    float ior;                // zero is infinite
    float specular;
    packed3 specular_colour;
    float clearcoat;
    float clearcoat_roughness;
    float clearcoat_normal_scale;
    packed3 sheen_colour;
    float sheen_roughness;
    float anisotropy;
    packed2 anisotropy_direction; // (cos, sin) of its angle from the tangent
    float transmission;
    float thickness;
    packed3 absorption;       // of a volume, for a length of one
    float dispersion;
    float iridescence;
    float iridescence_ior;
    float iridescence_thickness_minimum; // nanometres, where the texture is 0; without a texture, the maximum counts
    float iridescence_thickness_maximum;
    float diffuse_transmission;
    packed3 diffuse_transmission_colour;
    uint unlit;
    clast_texture_use specular_texture;        // alpha
    clast_texture_use specular_colour_texture;
    clast_texture_use clearcoat_texture;       // red
    clast_texture_use clearcoat_roughness_texture; // green
    clast_texture_use clearcoat_normal_texture;
    clast_texture_use sheen_colour_texture;
    clast_texture_use sheen_roughness_texture; // alpha
    clast_texture_use anisotropy_texture;      // red and green a direction, blue a factor
    clast_texture_use transmission_texture;    // red
    clast_texture_use iridescence_texture;     // red
    clast_texture_use iridescence_thickness_texture; // green
    clast_texture_use diffuse_transmission_texture;  // alpha
    clast_texture_use diffuse_transmission_colour_texture;
};
RECORD_SIZE(clast_material, 56 + 6 * 28 + 8 + 124 + 13 * 28)

RECORD(clast_light)
{
    uint type;            // CLAST_LIGHT_
    packed3 position;     // world space
    packed3 direction;    // the way the light shines, unit length
    packed3 radiance;     // point and spot: intensity in candela (W/sr); directional: irradiance in lux (W/m2)
    float range;          // 0 is endless
    float inner_cosine;   // spot: full intensity within
    float outer_cosine;   // spot: none beyond
};
RECORD_SIZE(clast_light, 52)

RECORD(clast_camera)
{
    uint projection;      // CLAST_PROJECTION_
    packed3 position;
    packed3 right;        // unit vectors of the camera in world space
    packed3 up;
    packed3 forward;
    float vertical_extent; // perspective: tangent of half the vertical angle; orthographic: half the height; panorama: pi / 2
    float aspect;          // width / height
    float near_plane;      // hits nearer than this along the axis are not seen
    float far_plane;       // 0 is endless
    float lens_radius;     // 0 is a pinhole
    float focus;           // distance along the axis that is sharp
};
RECORD_SIZE(clast_camera, 76)

// From where geometry is adapted, and how finely.
RECORD(clast_source_view)
{
    packed3 eye;               // in the unit's own space
    float pixels_per_unit;     // pixels that a length of one covers at distance one from the eye, which is far away where
                               // rays are parallel
    float rate;                // wanted density, 1 is the settings' own
    uint hidden;               // 1 where no camera ray can see it: coarser, but never gone
    clast_transform to_camera; // from the unit's own space: x to the right, y up, z forward; lengths are the world's
    packed2 extent;            // half of what is seen, across and up: at distance one, or anywhere (orthographic)
    float pixels;              // that a length of one of the world covers: at distance one, or anywhere (orthographic)
    float near_plane;
    uint projection;           // CLAST_PROJECTION_
    uint metric;               // CLAST_METRIC_
    float segment;             // wanted length of a segment in the metric's unit; fixed: segments of an edge
    float hidden_fraction;     // of the wanted density that is left where nothing is seen
    uint alone;                // 1 where a single instance shows the unit: its parts may be taken for hidden
    float deviation;           // in the world, of the surface from where ends and middles of its edges are, at most
    packed2 places;            // of the picture, across and up: what is known of depths in it (shared/occlusion.h)
    uint places_across;        // that there are
    uint places_down;
    uint depths_key[2];        // other depths, where the unit is, have another
    packed_address depths;     // of each place, from the top left; 0: the unit lies behind nothing. What has the same key has the
                               // same depths, wherever they lie
};
RECORD_SIZE(clast_source_view, 144)

#endif
