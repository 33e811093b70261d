// SPDX-License-Identifier: Apache-2.0
// Surfaces: sources give attributes, materials and their textures give the rest.
#include "render/surface.h"

clast_visibility clast_visibility_of_hit(const clast_hit *hit)
{
    vec3 normal = visible_normal(vec3(hit->normal[0], hit->normal[1], hit->normal[2]));
    bool found = hit->instance != CLAST_NONE;
    return (clast_visibility){
        .instance = hit->instance,
        .cluster = found ? hit->cluster : CLAST_NONE,
        .triangle = found ? hit->triangle : CLAST_NONE,
        .barycentrics = found ? (packed2){{hit->u, hit->v}} : (packed2){{0.0f, 0.0f}},
        .distance = found ? hit->t : INFINITY,
        .normal = found ? store3(normal) : (packed3){{0.0f, 0.0f, 0.0f}},
        .steps = hit->steps,
    };
}

// ---------------------------------------------------------------------------------------------------------- surface

static void triangle_corners(const clast_frame_unit *unit, const clast_visibility *seen, vec3 corners[3])
{
    float found[3][3];
    clast_clas_corners(unit->clas, seen->cluster, seen->triangle, found);
    for (int i = 0; i < 3; i++) {
        corners[i] = vec3(found[i][0], found[i][1], found[i][2]);
    }
}

static void place_point(const clast_frame_unit *unit, const clast_frame_instance *instance,
                        const clast_visibility *seen, clast_shading_point *point)
{
    vec3 corners[3];
    triangle_corners(unit, seen, corners);
    clast_surface_place place = surface_place(instance->to_world, instance->to_object, corners[0], corners[1],
                                              corners[2], load2(seen->barycentrics), point->geometric_normal);
    point->position = load3(place.position);
    point->offset = place.offset;
}

static vec3 map_normal(const clast_scene *scene, const clast_texture_use *use, float scale,
                       const clast_source_surface *surface, const clast_srgb_table *table, const clast_basis *axes)
{
    if (use->texture == CLAST_NONE || !has_axes(*axes)) {
        return load3(axes->z);
    }
    vec4 texel = clast_texture_value(scene, *use, surface->coordinates, CLAST_ENCODING_LINEAR, table,
                                     vec4(0.5f, 0.5f, 1.0f, 1.0f));
    return mapped_normal(*axes, scale, texel);
}

// Highlights stretch along the tangent, turned by the material and its texture (KHR_materials_anisotropy).
static void turn_highlights(const clast_scene *scene, const clast_material *material,
                            const clast_source_surface *surface, const clast_srgb_table *table, const clast_basis *axes,
                            clast_shading_point *point)
{
    clast_stretch stretch = {material->anisotropy_direction, material->anisotropy};
    if (material->anisotropy_texture.texture != CLAST_NONE) {
        vec4 texel = clast_texture_value(scene, material->anisotropy_texture, surface->coordinates,
                                         CLAST_ENCODING_LINEAR, table, vec4(1.0f, 0.5f, 1.0f, 1.0f));
        stretch = stretch_by_texel(load2(stretch.along), stretch.strength, texel);
    }
    vec3 direction = stretch_direction(*axes, load2(stretch.along), point->normal);
    if (dot3(direction, direction) > 0.0f) {
        point->surface.base.anisotropy = stretch.strength;
        point->frame = stretch_basis(direction, point->normal);
    }
}

static void shade_normals(const clast_scene *scene, const clast_material *material, const clast_source_surface *surface,
                          const clast_frame_instance *instance, const clast_srgb_table *table, vec3 view,
                          clast_shading_point *point)
{
    vec3 normal = instance_normal(instance->to_object, surface->normal, point->geometric_normal);
    clast_basis axes = map_axes(instance->to_world, surface->tangent, surface->bitangent_sign, normal);
    float side = normal_side(normal, point->geometric_normal);
    vec3 mapped = map_normal(scene, &material->normal_texture, material->normal_scale, surface, table, &axes);
    point->normal = shading_normal_repair(mapped * side, point->geometric_normal, view);
    point->frame = basis_around(point->normal);
    if ((material->layers & MATERIAL_ANISOTROPY) != 0 && has_axes(axes)) {
        turn_highlights(scene, material, surface, table, &axes, point);
    }
    if ((material->layers & MATERIAL_CLEARCOAT) != 0) {
        vec3 coat = map_normal(scene, &material->clearcoat_normal_texture, material->clearcoat_normal_scale, surface,
                               table, &axes);
        coat = shading_normal_repair(coat * side, point->geometric_normal, view);
        point->surface.clearcoat_normal = store3(to_basis(point->frame, coat));
    }
}

vec3 clast_emission(const clast_scene *scene, const clast_material *material, const vec2 coordinates[2],
                    const clast_srgb_table *table)
{
    vec3 emission = load3(material->emissive);
    if (largest3(emission) > 0.0f && material->emissive_texture.texture != CLAST_NONE) {
        vec4 texel = clast_texture_value(scene, material->emissive_texture, coordinates, CLAST_ENCODING_SRGB, table,
                                         vec4(1.0f, 1.0f, 1.0f, 1.0f));
        emission = emission * texture_colour(texel);
    }
    return emission;
}

typedef struct texture_reader {
    const clast_scene *scene;
    const clast_source_surface *surface;
    const clast_srgb_table *table;
} texture_reader;

static vec4 read_texture(const texture_reader *reader, const clast_texture_use *use, clast_encoding encoding)
{
    return clast_texture_value(reader->scene, *use, reader->surface->coordinates, encoding, reader->table,
                               vec4(1.0f, 1.0f, 1.0f, 1.0f));
}

static vec3 read_colour(const texture_reader *reader, const clast_texture_use *use)
{
    return texture_colour(read_texture(reader, use, CLAST_ENCODING_SRGB));
}

static float read_factor(const texture_reader *reader, const clast_texture_use *use, int channel, float factor)
{
    return texture_factor(factor, read_texture(reader, use, CLAST_ENCODING_LINEAR)[channel]);
}

// What extensions of the material add.
static void shade_layers(const texture_reader *reader, const clast_material *material, bool is_back,
                         clast_shading_point *point)
{
    clast_bsdf_input *surface = &point->surface;
    if ((material->layers & MATERIAL_SPECULAR) != 0) {
        surface->base.ior = material->ior;
        surface->base.specular = read_factor(reader, &material->specular_texture, 3, material->specular);
        surface->base.specular_colour = store3(load3(material->specular_colour) *
                                               read_colour(reader, &material->specular_colour_texture));
    }
    if ((material->layers & MATERIAL_CLEARCOAT) != 0) {
        surface->clearcoat = read_factor(reader, &material->clearcoat_texture, 0, material->clearcoat);
        surface->clearcoat_roughness = read_factor(reader, &material->clearcoat_roughness_texture, 1,
                                                   material->clearcoat_roughness);
    }
    if ((material->layers & MATERIAL_SHEEN) != 0) {
        vec3 colour = load3(material->sheen_colour) * read_colour(reader, &material->sheen_colour_texture);
        surface->sheen = store3(clamp_unit3(colour));
        surface->sheen_roughness = read_factor(reader, &material->sheen_roughness_texture, 3,
                                               material->sheen_roughness);
    }
    if ((material->layers & MATERIAL_TRANSMISSION) != 0) {
        surface->transmission = read_factor(reader, &material->transmission_texture, 0, material->transmission);
        surface->thin = material->thickness > 0.0f ? 0 : 1;
        surface->inside = surface->thin == 0 && is_back ? 1 : 0;
        point->absorption = surface->thin == 0 ? load3(material->absorption) : splat3(0.0f);
    }
}

static void shade_material(const texture_reader *reader, const clast_material *material, bool is_back,
                           clast_shading_point *point)
{
    const clast_source_surface *surface = reader->surface;
    vec4 colour = read_texture(reader, &material->base_colour_texture, CLAST_ENCODING_SRGB);
    vec4 rough = read_texture(reader, &material->metallic_roughness_texture, CLAST_ENCODING_LINEAR);
    point->surface = surface_base(load4(material->base_colour), surface->colour, colour, material->metallic,
                                  material->roughness, rough);
    point->absorption = splat3(0.0f);
    if (material->layers != 0) {
        shade_layers(reader, material, is_back, point);
    }
    point->emission = clast_emission(reader->scene, material, surface->coordinates, reader->table);
    point->unlit = material->unlit != 0;
    point->coordinates = surface->coordinates[0];
}

static const clast_material *material_of(const clast_scene *scene, uint32_t number)
{
    return &scene->materials[number < scene->material_count ? number : 0].record;
}

clast_found_surface clast_find_surface(const clast_frame *frame, const clast_visibility *seen)
{
    clast_found_surface found;
    clast_shading_point *point = &found.point;
    point->frame_instance = frame->frame_instance_of[seen->instance];
    const clast_frame_instance *instance = &frame->instances[point->frame_instance];
    const clast_frame_unit *unit = &frame->units[instance->unit];
    const clast_source *source = clast_source_of(unit->unit);
    point->geometric_normal = load3(seen->normal);
    place_point(unit, instance, seen, point);
    clast_surface_point on_source = source->locate(unit->unit, &unit->pose, &unit->records[seen->cluster],
                                                   clast_frame_words(unit, &unit->records[seen->cluster]),
                                                   seen->triangle, load2(seen->barycentrics));
    found.surface = source->evaluate(unit->unit, &unit->pose, on_source);
    point->material = found.surface.material < frame->scene->material_count ? found.surface.material : 0;
    found.material = material_of(frame->scene, point->material);
    point->primitive = on_source.primitive;
    clast_texture_prefetch(frame->scene, found.material->base_colour_texture, found.surface.coordinates);
    clast_texture_prefetch(frame->scene, found.material->metallic_roughness_texture, found.surface.coordinates);
    clast_texture_prefetch(frame->scene, found.material->normal_texture, found.surface.coordinates);
    return found;
}

void clast_shade_surface(const clast_frame *frame, const clast_srgb_table *table, vec3 view, clast_found_surface *found)
{
    clast_shading_point *point = &found->point;
    bool is_back = dot3(point->geometric_normal, view) < 0.0f;
    if (is_back) {
        point->geometric_normal = point->geometric_normal * -1.0f;
    }
    texture_reader reader = {frame->scene, &found->surface, table};
    shade_material(&reader, found->material, is_back, point);
    const clast_frame_instance *instance = &frame->instances[point->frame_instance];
    shade_normals(frame->scene, found->material, &found->surface, instance, table, view, point);
}

clast_hit_surface clast_surface_of_hit(const clast_frame *frame, const clast_hit *hit)
{
    const clast_frame_instance *instance = &frame->instances[frame->frame_instance_of[hit->instance]];
    const clast_frame_unit *unit = &frame->units[instance->unit];
    const clast_source *source = clast_source_of(unit->unit);
    clast_surface_point point = source->locate(unit->unit, &unit->pose, &unit->records[hit->cluster],
                                               clast_frame_words(unit, &unit->records[hit->cluster]), hit->triangle,
                                               vec2(hit->u, hit->v));
    clast_source_surface surface = source->evaluate(unit->unit, &unit->pose, point);
    const clast_material *material = material_of(frame->scene, surface.material);
    float alpha = material->base_colour.v[3] * surface.colour[3] *
                  clast_texture_alpha(frame->scene, material->base_colour_texture, surface.coordinates);
    return (clast_hit_surface){material, alpha, point.primitive};
}
