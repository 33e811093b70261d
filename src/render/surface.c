// SPDX-License-Identifier: Apache-2.0
// Surfaces: sources give attributes, materials and their textures give the rest.
#include "render/surface.h"

#include "shared/brdf.h"

static vec3 absolute3(vec3 v)
{
    return vec3(abs1(v[0]), abs1(v[1]), abs1(v[2]));
}

// Scaled first: the squares of very small and very large vectors are not numbers.
static vec3 direction_of(vec3 v, vec3 otherwise)
{
    float largest = largest3(absolute3(v));
    return largest > 0.0f && is_finite1(largest) ? normalize3(v * (1.0f / largest)) : otherwise;
}

clast_visibility clast_visibility_of_hit(const clast_hit *hit)
{
    vec3 normal = direction_of(vec3(hit->normal[0], hit->normal[1], hit->normal[2]), vec3(0.0f, 1.0f, 0.0f));
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

// ------------------------------------------------------------------------------------------------- where rays begin

// |M| v
static vec3 transform_absolute(const clast_transform *t, vec3 v)
{
    vec3 result = splat3(0.0f);
    for (int i = 0; i < 3; i++) {
        const float *row = t->rows[i].v;
        result[i] = abs1(row[0]) * v[0] + abs1(row[1]) * v[1] + abs1(row[2]) * v[2];
    }
    return result;
}

static vec3 translation(const clast_transform *t)
{
    return vec3(t->rows[0].v[3], t->rows[1].v[3], t->rows[2].v[3]);
}

// Running error analysis as in Pharr, Jakob and Humphreys, Physically Based Rendering, 3rd ed., 3.9: a sum of n products is off
// by at most n + 1 roundings of the sum of their sizes. Into the object's space and back, since the next ray is brought there
// with an error of its own. The ray test mixes the axes of differences of corners, so a triangle's size counts on all of them;
// this also keeps the bound above zero where all else is exact.
vec3 clast_position_error(const clast_frame_instance *instance, vec3 largest, float size, vec3 position)
{
    const float rounding = 5.9604645e-8f; // half a unit of the last place of 1
    const clast_transform *m = &instance->to_world, *inverse = &instance->to_object;
    vec3 there = absolute3(position);
    vec3 object = largest * (8.0f * rounding) + splat3(16.0f * rounding * size);
    object = object + (transform_absolute(inverse, there) + absolute3(translation(inverse))) * (4.0f * rounding);
    vec3 world = (transform_absolute(m, largest) + absolute3(translation(m))) * (4.0f * rounding);
    return transform_absolute(m, object) + world + there * (2.0f * rounding);
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

// The position comes from the triangle that was traced, not from the source's smooth surface: rays that leave a curved
// surface would begin behind the triangles that stand for it.
static void place_point(const clast_frame_unit *unit, const clast_frame_instance *instance,
                        const clast_visibility *seen, clast_shading_point *point)
{
    vec3 corner[3];
    triangle_corners(unit, seen, corner);
    vec2 weights = load2(seen->barycentrics);
    vec3 first = corner[1] - corner[0], second = corner[2] - corner[0];
    vec3 object = corner[0] + first * weights[0] + second * weights[1];
    vec3 largest = max3(max3(absolute3(corner[0]), absolute3(corner[1])), absolute3(corner[2]));
    point->position = transform_point(instance->to_world, object);
    vec3 error = clast_position_error(instance, largest, largest3(max3(absolute3(first), absolute3(second))),
                                      point->position);
    point->offset = 2.0f * dot3(absolute3(point->geometric_normal), error);
}

// The axes that a normal map's values mean, in the world; the first two are zero where nothing tells them.
static clast_basis map_axes(const clast_source_surface *surface, const clast_frame_instance *instance, vec3 normal)
{
    vec3 tangent = transform_vector(instance->to_world, surface->tangent);
    tangent = direction_of(tangent, splat3(0.0f));
    tangent = direction_of(tangent - normal * dot3(normal, tangent), splat3(0.0f));
    // A mirrored instance turns the cross product around.
    float sign = transform_determinant(instance->to_world) < 0.0f ? -surface->bitangent_sign : surface->bitangent_sign;
    return (clast_basis){store3(tangent), store3(cross3(normal, tangent) * sign), store3(normal)};
}

static bool has_axes(const clast_basis *axes)
{
    return dot3(load3(axes->x), load3(axes->x)) > 0.0f;
}

static vec3 map_normal(const clast_scene *scene, const clast_texture_use *use, float scale,
                       const clast_source_surface *surface, const clast_srgb_table *table, const clast_basis *axes)
{
    vec3 normal = load3(axes->z);
    if (use->texture == CLAST_NONE || !has_axes(axes)) {
        return normal;
    }
    vec4 texel = clast_texture_value(scene, *use, surface->coordinates, CLAST_ENCODING_LINEAR, table,
                                     vec4(0.5f, 0.5f, 1.0f, 1.0f));
    float x = (2.0f * texel[0] - 1.0f) * scale;
    float y = (2.0f * texel[1] - 1.0f) * scale;
    return direction_of(load3(axes->x) * x + load3(axes->y) * y + normal * (2.0f * texel[2] - 1.0f), normal);
}

// Highlights stretch along the tangent, turned by the material and its texture (KHR_materials_anisotropy).
static void turn_highlights(const clast_scene *scene, const clast_material *material,
                            const clast_source_surface *surface, const clast_srgb_table *table, const clast_basis *axes,
                            clast_shading_point *point)
{
    float strength = material->anisotropy;
    vec2 along = load2(material->anisotropy_direction);
    if (material->anisotropy_texture.texture != CLAST_NONE) {
        vec4 texel = clast_texture_value(scene, material->anisotropy_texture, surface->coordinates,
                                         CLAST_ENCODING_LINEAR, table, vec4(1.0f, 0.5f, 1.0f, 1.0f));
        vec2 d = vec2(2.0f * texel[0] - 1.0f, 2.0f * texel[1] - 1.0f);
        along = vec2(along[0] * d[0] - along[1] * d[1], along[1] * d[0] + along[0] * d[1]);
        strength = clamp1(strength * texel[2], 0.0f, 1.0f);
    }
    vec3 direction = load3(axes->x) * along[0] + load3(axes->y) * along[1];
    direction = direction_of(direction - point->normal * dot3(point->normal, direction), splat3(0.0f));
    if (dot3(direction, direction) > 0.0f) {
        point->surface.base.anisotropy = strength;
        point->frame = (clast_basis){store3(direction), store3(cross3(point->normal, direction)),
                                     store3(point->normal)};
    }
}

static void shade_normals(const clast_scene *scene, const clast_material *material, const clast_source_surface *surface,
                          const clast_frame_instance *instance, const clast_srgb_table *table, vec3 view,
                          clast_shading_point *point)
{
    vec3 normal = direction_of(transform_transposed(instance->to_object, surface->normal), point->geometric_normal);
    clast_basis axes = map_axes(surface, instance, normal);
    // Seen from behind, all normals turn around (glTF 2.0, double sided).
    float side = dot3(normal, point->geometric_normal) < 0.0f ? -1.0f : 1.0f;
    vec3 mapped = map_normal(scene, &material->normal_texture, material->normal_scale, surface, table, &axes);
    point->normal = shading_normal_repair(mapped * side, point->geometric_normal, view);
    point->frame = basis_around(point->normal);
    if ((material->layers & MATERIAL_ANISOTROPY) != 0 && has_axes(&axes)) {
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
        emission = emission * max3(vec3(texel[0], texel[1], texel[2]), splat3(0.0f));
    }
    return emission;
}

static vec3 clamp_unit3(vec3 v)
{
    return vec3(clamp1(v[0], 0.0f, 1.0f), clamp1(v[1], 0.0f, 1.0f), clamp1(v[2], 0.0f, 1.0f));
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
    vec4 texel = read_texture(reader, use, CLAST_ENCODING_SRGB);
    return max3(vec3(texel[0], texel[1], texel[2]), splat3(0.0f));
}

static float read_factor(const texture_reader *reader, const clast_texture_use *use, int channel, float factor)
{
    return clamp1(factor * read_texture(reader, use, CLAST_ENCODING_LINEAR)[channel], 0.0f, 1.0f);
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
    vec4 colour = load4(material->base_colour) * surface->colour;
    colour = colour * read_texture(reader, &material->base_colour_texture, CLAST_ENCODING_SRGB);
    vec4 rough = read_texture(reader, &material->metallic_roughness_texture, CLAST_ENCODING_LINEAR);
    point->surface = bsdf_input(brdf_input(clamp_unit3(vec3(colour[0], colour[1], colour[2])),
                                           clamp1(material->metallic * rough[2], 0.0f, 1.0f),
                                           clamp1(material->roughness * rough[1], 0.0f, 1.0f)));
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
