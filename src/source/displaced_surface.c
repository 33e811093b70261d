// SPDX-License-Identifier: Apache-2.0
// Points of displaced surfaces: where a hit is on the mesh, and what is there.
#include "source/displaced.h"

// ----------------------------------------------------------------------------------------------------------- locate

// The weights of a pattern's vertex as numbers up to 1, of the leaf's corners.
static vec3 weights_of_vertex(const displaced_reader *reader, uint32_t vertex)
{
    uint32_t word = reader->unit->patterns->vertices[reader->use.pattern->first_vertex + vertex];
    clast_weights at = pattern_unrotate(weights_of(word), reader->use.rotation);
    return vec3((float)at.of[0], (float)at.of[1], (float)at.of[2]) * power_of_two(112u);
}

// Of the leaf's corners, in the base triangle.
static vec3 weights_in_base(const displaced_leaf *leaf, vec3 at)
{
    if (!leaf->split) {
        return at;
    }
    vec3 sum = splat3(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        clast_weights corner = leaf->corners[k].at;
        sum += vec3((float)corner.of[0], (float)corner.of[1], (float)corner.of[2]) * (at[k] * power_of_two(112u));
    }
    return sum;
}

static void find_leaf(displaced_reader *reader, uint32_t triangle)
{
    while (clast_displaced_next(reader)) {
        if (triangle < reader->first_triangle + pattern_triangles(*reader->use.pattern)) {
            return;
        }
    }
}

// A point of a base triangle.
typedef struct base_point {
    const displaced_cluster *cluster;
    uint32_t triangle; // of the cluster
    vec3 weights;
    float level;
} base_point;

static base_point find_point(const displaced_unit *unit, const clast_cluster_record *record, const uint32_t *words,
                             uint32_t triangle, vec2 barycentrics)
{
    displaced_reader reader = clast_displaced_read(unit, record, words);
    vec3 within = vec3(1.0f - barycentrics[0] - barycentrics[1], barycentrics[0], barycentrics[1]);
    base_point point = {reader.cluster, triangle, within, 0.0f};
    if (record->detail == 0) {
        displaced_triangle corners = unit->triangles[reader.cluster->first_triangle + triangle];
        for (uint32_t k = 0; k < 3; k++) {
            point.level += displaced_cluster_level(&reader, displaced_corner(corners, k)) * within[k];
        }
        return point;
    }
    find_leaf(&reader, triangle);
    uint32_t word = unit->patterns->triangles[reader.use.pattern->first_triangle + triangle - reader.first_triangle];
    vec3 at = splat3(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        at += weights_of_vertex(&reader, word >> 8 * k & 255) * within[k];
    }
    for (uint32_t k = 0; k < 3; k++) {
        point.level += clast_displaced_level_of(&reader, k) * at[k];
    }
    point.triangle = reader.leaf.triangle;
    point.weights = weights_in_base(&reader.leaf, at);
    return point;
}

clast_surface_point clast_displaced_locate(const clast_unit *base, const clast_pose *pose,
                                           const clast_cluster_record *record, const uint32_t *words, uint32_t triangle,
                                           vec2 barycentrics)
{
    (void)pose;
    const displaced_unit *unit = clast_displaced_of(base);
    base_point point = find_point(unit, record, words, triangle, barycentrics);
    return (clast_surface_point){
        .primitive = unit->mesh_triangles[point.cluster->first_triangle + point.triangle],
        .coordinates = {{point.weights[1], point.weights[2]}},
        .level = point.level,
    };
}

float clast_displaced_segments(const clast_unit *base, const clast_pose *pose, const clast_source_view *view,
                               const clast_cluster_record *record, const uint32_t *words, uint32_t triangle,
                               vec2 barycentrics)
{
    const displaced_unit *unit = clast_displaced_of(base);
    base_point point = find_point(unit, record, words, triangle, barycentrics);
    vec3 w = point.weights;
    uint32_t opposite = w[0] < w[1] ? (w[0] < w[2] ? 0 : 2) : (w[1] < w[2] ? 1 : 2);
    displaced_triangle corners = unit->triangles[point.cluster->first_triangle + point.triangle];
    clast_rate_view rates = clast_displaced_rate_view(unit, pose, view);
    return clast_displaced_wanted(unit, pose, &rates, point.cluster, displaced_edge_of(corners, (opposite + 1) % 3));
}

// --------------------------------------------------------------------------------------------------------- evaluate

// A mesh's triangle with what its points are blended from.
typedef struct base_triangle {
    const uint32_t *vertices;
    vec3 weights;
    vec3 positions[3], normals[3];
    const displaced_map *map;
} base_triangle;

static base_triangle triangle_at(const displaced_unit *unit, const clast_pose *pose, clast_surface_point point)
{
    const clast_mesh *mesh = &unit->base.geometry->of.mesh;
    vec2 at = load2(point.coordinates);
    base_triangle triangle = {
        .vertices = mesh->indices + 3 * (size_t)point.primitive,
        .weights = vec3(1.0f - at[0] - at[1], at[0], at[1]),
        .map = &unit->maps[displaced_map_of(unit, point.primitive)],
    };
    for (uint32_t k = 0; k < 3; k++) {
        const displaced_vertex *vertex = &unit->vertices[unit->vertex_of[triangle.vertices[k]]];
        triangle.positions[k] = clast_displaced_position(unit, pose, vertex);
        triangle.normals[k] = clast_displaced_normal(unit, pose, vertex);
    }
    return triangle;
}

static vec3 blend_at(const vec3 values[3], vec3 weights)
{
    return values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
}

static vec3 base_position(const displaced_unit *unit, const base_triangle *triangle)
{
    const vec3 *p = triangle->positions, *n = triangle->normals;
    vec3 w = triangle->weights;
    return unit->curved ? curved_position(p, n, w) : blend_at(p, w);
}

static vec3 posed_gradient(const clast_mesh *rest, const base_triangle *triangle, vec3 gradient)
{
    vec3 origin = load3(clast_mesh_position(rest, triangle->vertices[0]));
    return displaced_posed_gradient(gradient, load3(clast_mesh_position(rest, triangle->vertices[1])) - origin,
                                    load3(clast_mesh_position(rest, triangle->vertices[2])) - origin,
                                    triangle->positions[1] - triangle->positions[0],
                                    triangle->positions[2] - triangle->positions[0]);
}

// The slope of the height along the surface: a vector towards which it grows, by how much for each length. The map's own
// derivatives jump from texel to texel; differences over a texel do not.
static vec3 slope_at(const displaced_unit *unit, const clast_pose *pose, const base_triangle *triangle,
                     vec2 coordinates, float level)
{
    const displaced_map *map = triangle->map;
    const clast_mesh *mesh = &unit->base.geometry->of.mesh;
    const clast_height_map *height = &map->height->map;
    vec2 step = displaced_half_texel(exp2f(level), height->widths[0], height->heights[0]);
    float across = clast_height_value(map->height, coordinates + vec2(step[0], 0.0f), level) -
                   clast_height_value(map->height, coordinates - vec2(step[0], 0.0f), level);
    float down = clast_height_value(map->height, coordinates + vec2(0.0f, step[1]), level) -
                 clast_height_value(map->height, coordinates - vec2(0.0f, step[1]), level);
    vec2 by_mesh = displaced_mesh_slope(unit->map_records[map - unit->maps], map->scale * pose->displacement_scale,
                                        across, down, step);
    const displaced_gradient *gradients = unit->gradients[map->coordinate_set];
    vec3 u = splat3(0.0f), v = splat3(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        u += load3(gradients[triangle->vertices[k]].u) * triangle->weights[k];
        v += load3(gradients[triangle->vertices[k]].v) * triangle->weights[k];
    }
    vec3 slope = u * by_mesh[0] + v * by_mesh[1];
    return pose->positions != NULL ? posed_gradient(mesh, triangle, slope) : slope;
}

clast_source_surface clast_displaced_evaluate(const clast_unit *base, const clast_pose *pose, clast_surface_point point)
{
    const displaced_unit *unit = clast_displaced_of(base);
    clast_mesh posed = clast_mesh_posed(&base->geometry->of.mesh, pose);
    clast_source_surface surface = clast_mesh_evaluate(&posed, point);
    base_triangle triangle = triangle_at(unit, pose, point);
    vec3 flat = displaced_unit_or(surface.geometric_normal, splat3(0.0f));
    vec3 towards = displaced_unit_or(blend_at(triangle.normals, triangle.weights), splat3(0.0f));
    surface.position = base_position(unit, &triangle);
    if (triangle.map->height == NULL) {
        return surface;
    }
    vec2 coordinates = splat2(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        coordinates += clast_displaced_coordinates(triangle.map, &posed, triangle.vertices[k]) * triangle.weights[k];
    }
    float height = clast_displaced_height(triangle.map, coordinates, point.level) * pose->displacement_scale;
    surface.position = surface.position + towards * height;
    vec3 slope = slope_at(unit, pose, &triangle, coordinates, point.level);
    surface.geometric_normal = displaced_geometric_normal(towards, flat, slope);
    surface.normal = displaced_shading_normal(surface.normal, towards, flat, slope);
    return surface;
}
