// SPDX-License-Identifier: Apache-2.0
// Surfaces: sources give attributes, materials and their textures give the rest.
#include "render/surface.h"

#include "shared/device_materials.h"

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

// What reads a surface's textures.
typedef struct texture_reader {
    const clast_scene *scene;
    const clast_source_surface *surface;
    const clast_texture_area *area;
    const clast_srgb_table *table;
} texture_reader;

static vec4 read_texture(const texture_reader *reader, const clast_texture_use *use, clast_encoding encoding)
{
    return clast_texture_value(reader->scene, *use, reader->area, encoding, reader->table,
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

// A mapped normal. What the map's normals differ by, where several count, is added to the roughness.
static vec3 map_normal(const texture_reader *reader, const clast_texture_use *use, float scale, const clast_basis *axes,
                       float *roughness)
{
    if (use->texture == CLAST_NONE || !has_axes(*axes)) {
        return load3(axes->z);
    }
    vec4 texel = clast_texture_value(reader->scene, *use, reader->area, CLAST_ENCODING_NORMAL, reader->table,
                                     vec4(0.5f, 0.5f, 1.0f, 0.0f));
    *roughness = widened_roughness(*roughness, texel[3], scale);
    return mapped_normal(*axes, scale, texel);
}

// Highlights stretch along the tangent, turned by the material and its texture (KHR_materials_anisotropy).
static void turn_highlights(const texture_reader *reader, const clast_material *material, const clast_basis *axes,
                            clast_shading_point *point)
{
    clast_stretch stretch = {material->anisotropy_direction, material->anisotropy};
    if (material->anisotropy_texture.texture != CLAST_NONE) {
        vec4 texel = clast_texture_value(reader->scene, material->anisotropy_texture, reader->area,
                                         CLAST_ENCODING_LINEAR, reader->table, vec4(1.0f, 0.5f, 1.0f, 1.0f));
        stretch = stretch_by_texel(load2(stretch.along), stretch.strength, texel);
    }
    vec3 direction = stretch_direction(*axes, load2(stretch.along), point->normal);
    if (dot3(direction, direction) > 0.0f) {
        point->surface.base.anisotropy = stretch.strength;
        point->frame = stretch_basis(direction, point->normal);
    }
}

static void shade_normals(const texture_reader *reader, const clast_material *material,
                          const clast_frame_instance *instance, vec3 view, clast_shading_point *point)
{
    const clast_source_surface *surface = reader->surface;
    vec3 normal = instance_normal(instance->to_object, surface->normal, point->geometric_normal);
    clast_basis axes = map_axes(instance->to_world, surface->tangent, surface->bitangent_sign, normal);
    float side = normal_side(normal, point->geometric_normal);
    vec3 mapped = map_normal(reader, &material->normal_texture, material->normal_scale, &axes,
                             &point->surface.base.roughness);
    point->normal = shading_normal_repair(mapped * side, point->geometric_normal, view);
    point->frame = basis_around(point->normal);
    if ((material->layers & MATERIAL_ANISOTROPY) != 0 && has_axes(axes)) {
        turn_highlights(reader, material, &axes, point);
    }
    if ((material->layers & MATERIAL_CLEARCOAT) != 0) {
        vec3 coat = map_normal(reader, &material->clearcoat_normal_texture, material->clearcoat_normal_scale, &axes,
                               &point->surface.clearcoat_roughness);
        coat = shading_normal_repair(coat * side, point->geometric_normal, view);
        point->surface.clearcoat_normal = store3(to_basis(point->frame, coat));
    }
}

vec3 clast_emission(const clast_scene *scene, const clast_material *material, const clast_texture_area *area,
                    const clast_srgb_table *table)
{
    vec3 emission = load3(material->emissive);
    if (largest3(emission) > 0.0f && material->emissive_texture.texture != CLAST_NONE) {
        vec4 texel = clast_texture_value(scene, material->emissive_texture, area, CLAST_ENCODING_SRGB, table,
                                         vec4(1.0f, 1.0f, 1.0f, 1.0f));
        emission = emission * texture_colour(texel);
    }
    return emission;
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
        surface->dispersion = surface->transmission > 0.0f && material->thickness > 0.0f ? material->dispersion : 0.0f;
    }
    if ((material->layers & MATERIAL_DIFFUSE_TRANSMISSION) != 0) {
        surface->through = read_factor(reader, &material->diffuse_transmission_texture, 3,
                                       material->diffuse_transmission);
        vec3 colour = load3(material->diffuse_transmission_colour) *
                      read_colour(reader, &material->diffuse_transmission_colour_texture);
        surface->through_colour = store3(clamp_unit3(colour));
    }
    if ((material->layers & (MATERIAL_TRANSMISSION | MATERIAL_DIFFUSE_TRANSMISSION)) != 0) {
        surface->thin = material->thickness > 0.0f ? 0 : 1;
        surface->inside = surface->thin == 0 && is_back ? 1 : 0;
        point->absorption = surface->thin == 0 ? load3(material->absorption) : splat3(0.0f);
    }
    if ((material->layers & MATERIAL_IRIDESCENCE) != 0) {
        float share = read_texture(reader, &material->iridescence_thickness_texture, CLAST_ENCODING_LINEAR)[1];
        surface->base.film_ior = material->iridescence_ior;
        surface->base.film_thickness = film_thickness(material->iridescence_thickness_minimum,
                                                      material->iridescence_thickness_maximum, share);
        float film = read_factor(reader, &material->iridescence_texture, 0, material->iridescence);
        surface->base.film = surface->base.film_thickness > 0.0f ? film : 0.0f;
    }
}

static void shade_material(const texture_reader *reader, const clast_material *material, bool is_back,
                           clast_shading_point *point)
{
    const clast_source_surface *surface = reader->surface;
    uint32_t encoding = slot_encoding(SLOT_BASE_COLOUR, ENCODING_SRGB, material->alpha_mode);
    vec4 colour = read_texture(reader, &material->base_colour_texture, (clast_encoding)encoding);
    vec4 rough = read_texture(reader, &material->metallic_roughness_texture, CLAST_ENCODING_LINEAR);
    point->surface = surface_base(load4(material->base_colour), surface->colour, colour, material->metallic,
                                  material->roughness, rough);
    point->absorption = splat3(0.0f);
    if (material->layers != 0) {
        shade_layers(reader, material, is_back, point);
    }
    point->emission = clast_emission(reader->scene, material, reader->area, reader->table);
    point->unlit = material->unlit != 0;
    point->coordinates = surface->coordinates[0];
}

static const clast_material *material_of(const clast_scene *scene, uint32_t number)
{
    return &scene->materials[number < scene->material_count ? number : 0].record;
}

// How much of its textures a ray's cone covers.
static clast_texture_area area_of(const clast_source_surface *surface, const clast_frame_instance *instance,
                                  const clast_finding_ray *ray, clast_shading_point *point)
{
    clast_cone_axes axes = cone_axes(point->geometric_normal, ray->direction, point->cone.width);
    vec3 first = transform_vector(instance->to_object, load3(axes.first));
    vec3 second = transform_vector(instance->to_object, load3(axes.second));
    point->bend = surface->curvature * length3(second);
    return (clast_texture_area){.coordinates = {surface->coordinates[0], surface->coordinates[1]},
                                .footprints = {footprint_of(surface->gradients[0], first, second),
                                               footprint_of(surface->gradients[1], first, second)},
                                .look = ray->look};
}

static void prefetch_textures(const clast_scene *scene, const clast_found_surface *found)
{
    const clast_material *material = found->material;
    uint32_t encoding = slot_encoding(SLOT_BASE_COLOUR, ENCODING_SRGB, material->alpha_mode);
    clast_texture_prefetch(scene, material->base_colour_texture, &found->area, (clast_encoding)encoding);
    clast_texture_prefetch(scene, material->metallic_roughness_texture, &found->area, CLAST_ENCODING_LINEAR);
    clast_texture_prefetch(scene, material->normal_texture, &found->area, CLAST_ENCODING_NORMAL);
}

clast_found_surface clast_find_surface(const clast_frame *frame, const clast_visibility *seen,
                                       const clast_finding_ray *ray)
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
    point->cone = cone_at(ray->cone, seen->distance);
    found.area = area_of(&found.surface, instance, ray, point);
    prefetch_textures(frame->scene, &found);
    return found;
}

void clast_shade_surface(const clast_frame *frame, const clast_srgb_table *table, vec3 view, clast_found_surface *found)
{
    clast_shading_point *point = &found->point;
    bool is_back = dot3(point->geometric_normal, view) < 0.0f;
    if (is_back) {
        point->geometric_normal = point->geometric_normal * -1.0f;
    }
    texture_reader reader = {frame->scene, &found->surface, &found->area, table};
    shade_material(&reader, found->material, is_back, point);
    const clast_frame_instance *instance = &frame->instances[point->frame_instance];
    shade_normals(&reader, found->material, instance, view, point);
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
