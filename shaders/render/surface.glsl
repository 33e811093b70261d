// SPDX-License-Identifier: Apache-2.0
// From a hit to what is there: the twin of src/render/surface.c. Sources give attributes, materials and their textures give
// the rest.
#ifndef CLAST_RENDER_SURFACE_GLSL
#define CLAST_RENDER_SURFACE_GLSL

#include "accel/corners.glsl"
#include "render/texture.glsl"
#include "source/sources.glsl"

// A hit, ready to be shaded: clast_shading_point.
struct shading_point
{
    vec3 position;         // on the triangle that the ray hit, world space
    vec3 geometric_normal; // unit length, on the viewer's side
    vec3 normal;           // to shade with: unit length, normal map applied, repaired; on the viewer's side
    float offset;      // how far along the geometric normal a ray must begin, so that it cannot hit this surface again
    clast_basis frame; // around the normal; along the highlights where they have a direction
    clast_bsdf_input surface;
    vec3 absorption; // of the volume behind; zero where there is none
    bool unlit;
    vec3 emission;
    vec2 coordinates;
    clast_ray_cone cone; // of the sample, here
    float bend;          // the surface's curvature times the cone's width
    uint material;
    uint frame_instance;
    uint primitive;
};

// A hit on its way to be shaded.
struct found_surface
{
    shading_point point; // lacks what the material says, and its geometric normal is the front's
    source_surface surface;
    texture_area area;
};

// The ray that found it, as far as that matters to what is seen there.
struct finding_ray
{
    vec3 direction;      // unit length
    clast_ray_cone cone; // where the ray began
    uint look;           // LOOK_: how closely at textures
};

// What reads a surface's textures.
struct texture_reader
{
    materials_reference all;
    material_reference material;
    texture_area area;
};

vec4 read_texture(texture_reader reader, uint slot, uint encoding)
{
    return texture_value(reader.all, reader.material, slot, reader.area, encoding, vec4(1.0f, 1.0f, 1.0f, 1.0f));
}

vec3 read_colour(texture_reader reader, uint slot)
{
    return texture_colour(read_texture(reader, slot, ENCODING_SRGB));
}

float read_factor(texture_reader reader, uint slot, uint channel, float factor)
{
    return texture_factor(factor, read_texture(reader, slot, ENCODING_LINEAR)[channel]);
}

// -------------------------------------------------------------------------------------------------------------- places

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer instance_reference { clast_device_instance of; };

instance_reference instance_at(frame_reference frame, uint number)
{
    return instance_reference(load_address(frame.of.instances)) + number;
}

uint frame_instance_of(frame_reference frame, uint scene_instance)
{
    return uints(load_address(frame.of.instance_of)).at[scene_instance];
}

// What of a source a hit is.
struct source_hit
{
    unit_reference unit;
    clast_cluster_record record;
    clast_surface_point point;
};

source_hit locate_hit(frame_reference frame, uint frame_instance, uint cluster, uint triangle, vec2 barycentrics)
{
    source_hit hit;
    hit.unit = unit_at(load_address(frame.of.units), instance_at(frame, frame_instance).of.unit);
    hit.record = cluster_records(load_address(hit.unit.of.records)).at[cluster];
    hit.point = source_locate(hit.unit, hit.record, words_of(hit.unit, hit.record), triangle, barycentrics);
    return hit;
}

// How much of its textures a ray's cone covers.
texture_area area_of(source_surface surface, clast_transform to_object, finding_ray ray, inout shading_point point)
{
    clast_cone_axes axes = cone_axes(point.geometric_normal, ray.direction, point.cone.width);
    vec3 first = transform_vector(to_object, load3(axes.first));
    vec3 second = transform_vector(to_object, load3(axes.second));
    point.bend = surface.curvature * length3(second);
    texture_area area;
    area.coordinates = surface.coordinates;
    area.footprints[0] = footprint_of(surface.gradients[0], first, second);
    area.footprints[1] = footprint_of(surface.gradients[1], first, second);
    area.look = ray.look;
    return area;
}

found_surface find_surface(frame_reference frame, materials_reference all, clast_visibility seen, finding_ray ray)
{
    found_surface found;
    found.point.frame_instance = frame_instance_of(frame, seen.instance);
    vec2 weights = load2(seen.barycentrics);
    source_hit hit = locate_hit(frame, found.point.frame_instance, seen.cluster, seen.triangle, weights);
    found.point.geometric_normal = load3(seen.normal);
    instance_reference instance = instance_at(frame, found.point.frame_instance);
    triangle_corners corners = corners_of_hit(frame, hit.unit, hit.record, seen.cluster, seen.triangle);
    clast_surface_place place = surface_place(instance.of.to_world, instance.of.to_object, corners.a, corners.b,
                                              corners.c, weights, found.point.geometric_normal);
    found.point.position = load3(place.position);
    found.point.offset = place.offset;
    found.surface = source_evaluate(hit.unit, hit.point);
    found.point.material = found.surface.material < all.of.material_count ? found.surface.material : 0u;
    found.point.primitive = hit.point.primitive;
    found.point.cone = cone_at(ray.cone, seen.distance);
    found.area = area_of(found.surface, instance.of.to_object, ray, found.point);
    return found;
}

// ------------------------------------------------------------------------------------------------------------ normals

// A mapped normal. What the map's normals differ by, where several count, is added to the roughness.
vec3 map_normal(texture_reader reader, uint slot, float scale, clast_basis axes, inout float roughness)
{
    if (!has_texture(reader.material, slot) || !has_axes(axes)) {
        return load3(axes.z);
    }
    vec4 texel = texture_value(reader.all, reader.material, slot, reader.area, ENCODING_NORMAL,
                               vec4(0.5f, 0.5f, 1.0f, 0.0f));
    roughness = widened_roughness(roughness, texel[3], scale);
    return mapped_normal(axes, scale, texel);
}

// Highlights stretch along the tangent, turned by the material and its texture (KHR_materials_anisotropy).
void turn_highlights(texture_reader reader, clast_basis axes, inout shading_point point)
{
    clast_stretch stretch;
    stretch.along = reader.material.of.record.anisotropy_direction;
    stretch.strength = reader.material.of.record.anisotropy;
    if (has_texture(reader.material, SLOT_ANISOTROPY)) {
        vec4 texel = texture_value(reader.all, reader.material, SLOT_ANISOTROPY, reader.area, ENCODING_LINEAR,
                                   vec4(1.0f, 0.5f, 1.0f, 1.0f));
        stretch = stretch_by_texel(load2(stretch.along), stretch.strength, texel);
    }
    vec3 direction = stretch_direction(axes, load2(stretch.along), point.normal);
    if (dot3(direction, direction) > 0.0f) {
        point.surface.base.anisotropy = stretch.strength;
        point.frame = stretch_basis(direction, point.normal);
    }
}

void shade_normals(texture_reader reader, clast_transform to_world, clast_transform to_object, source_surface surface,
                   vec3 view, inout shading_point point)
{
    material_reference material = reader.material;
    vec3 normal = instance_normal(to_object, surface.normal, point.geometric_normal);
    clast_basis axes = map_axes(to_world, surface.tangent, surface.bitangent_sign, normal);
    float side = normal_side(normal, point.geometric_normal);
    vec3 mapped = map_normal(reader, SLOT_NORMAL, material.of.record.normal_scale, axes, point.surface.base.roughness);
    point.normal = shading_normal_repair(mapped * side, point.geometric_normal, view);
    point.frame = basis_around(point.normal);
    uint layers = material.of.record.layers;
    if ((layers & MATERIAL_ANISOTROPY) != 0u && has_axes(axes)) {
        turn_highlights(reader, axes, point);
    }
    if ((layers & MATERIAL_CLEARCOAT) != 0u) {
        vec3 coat = map_normal(reader, SLOT_CLEARCOAT_NORMAL, material.of.record.clearcoat_normal_scale, axes,
                               point.surface.clearcoat_roughness);
        coat = shading_normal_repair(coat * side, point.geometric_normal, view);
        point.surface.clearcoat_normal = store3(to_basis(point.frame, coat));
    }
}

// ---------------------------------------------------------------------------------------------------------- materials

// The light that a material sends out at texture coordinates.
vec3 emission_of(texture_reader reader)
{
    vec3 emission = load3(reader.material.of.record.emissive);
    if (largest3(emission) > 0.0f && has_texture(reader.material, SLOT_EMISSIVE)) {
        emission = emission * read_colour(reader, SLOT_EMISSIVE);
    }
    return emission;
}

// What extensions of the material add.
void shade_layers(texture_reader reader, bool is_back, inout shading_point point)
{
    material_reference material = reader.material;
    uint layers = material.of.record.layers;
    if ((layers & MATERIAL_SPECULAR) != 0u) {
        point.surface.base.ior = material.of.record.ior;
        point.surface.base.specular = read_factor(reader, SLOT_SPECULAR, 3u, material.of.record.specular);
        point.surface.base.specular_colour =
            store3(load3(material.of.record.specular_colour) * read_colour(reader, SLOT_SPECULAR_COLOUR));
    }
    if ((layers & MATERIAL_CLEARCOAT) != 0u) {
        point.surface.clearcoat = read_factor(reader, SLOT_CLEARCOAT, 0u, material.of.record.clearcoat);
        point.surface.clearcoat_roughness =
            read_factor(reader, SLOT_CLEARCOAT_ROUGHNESS, 1u, material.of.record.clearcoat_roughness);
    }
    if ((layers & MATERIAL_SHEEN) != 0u) {
        vec3 colour = load3(material.of.record.sheen_colour) * read_colour(reader, SLOT_SHEEN_COLOUR);
        point.surface.sheen = store3(clamp_unit3(colour));
        point.surface.sheen_roughness =
            read_factor(reader, SLOT_SHEEN_ROUGHNESS, 3u, material.of.record.sheen_roughness);
    }
    if ((layers & MATERIAL_TRANSMISSION) != 0u) {
        point.surface.transmission = read_factor(reader, SLOT_TRANSMISSION, 0u, material.of.record.transmission);
        bool disperses = point.surface.transmission > 0.0f && material.of.record.thickness > 0.0f;
        point.surface.dispersion = disperses ? material.of.record.dispersion : 0.0f;
    }
    if ((layers & MATERIAL_DIFFUSE_TRANSMISSION) != 0u) {
        point.surface.through =
            read_factor(reader, SLOT_DIFFUSE_TRANSMISSION, 3u, material.of.record.diffuse_transmission);
        vec3 colour = load3(material.of.record.diffuse_transmission_colour) *
                      read_colour(reader, SLOT_DIFFUSE_TRANSMISSION_COLOUR);
        point.surface.through_colour = store3(clamp_unit3(colour));
    }
    if ((layers & (MATERIAL_TRANSMISSION | MATERIAL_DIFFUSE_TRANSMISSION)) != 0u) {
        point.surface.thin = material.of.record.thickness > 0.0f ? 0u : 1u;
        point.surface.inside = point.surface.thin == 0u && is_back ? 1u : 0u;
        point.absorption = point.surface.thin == 0u ? load3(material.of.record.absorption) : splat3(0.0f);
    }
    if ((layers & MATERIAL_IRIDESCENCE) != 0u) {
        float share = read_texture(reader, SLOT_IRIDESCENCE_THICKNESS, ENCODING_LINEAR)[1];
        point.surface.base.film_ior = material.of.record.iridescence_ior;
        point.surface.base.film_thickness = film_thickness(material.of.record.iridescence_thickness_minimum,
                                                           material.of.record.iridescence_thickness_maximum, share);
        float film = read_factor(reader, SLOT_IRIDESCENCE, 0u, material.of.record.iridescence);
        point.surface.base.film = point.surface.base.film_thickness > 0.0f ? film : 0.0f;
    }
}

void shade_material(texture_reader reader, vec4 colour, bool is_back, inout shading_point point)
{
    material_reference material = reader.material;
    vec4 colour_texel = read_texture(reader, SLOT_BASE_COLOUR, ENCODING_SRGB);
    vec4 rough_texel = read_texture(reader, SLOT_METALLIC_ROUGHNESS, ENCODING_LINEAR);
    point.surface = surface_base(load4(material.of.record.base_colour), colour, colour_texel,
                                 material.of.record.metallic, material.of.record.roughness, rough_texel);
    point.absorption = splat3(0.0f);
    if (material.of.record.layers != 0u) {
        shade_layers(reader, is_back, point);
    }
    point.emission = emission_of(reader);
    point.unlit = material.of.record.unlit != 0u;
    point.coordinates = reader.area.coordinates[0];
}

// Completes a point. `view` is the unit vector towards where the ray came from.
void shade_surface(frame_reference frame, materials_reference all, vec3 view, inout found_surface found)
{
    bool is_back = dot3(found.point.geometric_normal, view) < 0.0f;
    if (is_back) {
        found.point.geometric_normal = found.point.geometric_normal * -1.0f;
    }
    texture_reader reader;
    reader.all = all;
    reader.material = material_at(all, found.point.material);
    reader.area = found.area;
    shade_material(reader, found.surface.colour, is_back, found.point);
    instance_reference instance = instance_at(frame, found.point.frame_instance);
    shade_normals(reader, instance.of.to_world, instance.of.to_object, found.surface, view, found.point);
}

// Both.
shading_point surface_of_hit(frame_reference frame, materials_reference all, clast_visibility seen, finding_ray ray)
{
    found_surface found = find_surface(frame, all, seen, ray);
    shade_surface(frame, all, ray.direction * -1.0f, found);
    return found.point;
}

// The light that a primitive of an instance sends out, at a point of it.
vec3 emission_at(frame_reference frame, materials_reference all, uint frame_instance, uint material,
                 clast_surface_point point)
{
    texture_reader reader;
    reader.all = all;
    reader.material = material_at(all, material);
    if (has_texture(reader.material, SLOT_EMISSIVE)) {
        unit_reference unit = unit_at(load_address(frame.of.units), instance_at(frame, frame_instance).of.unit);
        reader.area = texture_point(source_evaluate(unit, point).coordinates);
    }
    return emission_of(reader);
}

#endif
