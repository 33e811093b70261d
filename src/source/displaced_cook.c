// SPDX-License-Identifier: Apache-2.0
// Cooking displaced meshes: maps, the welded mesh's vertices, and what displacement may reach. Clusters are
// displaced_clusters.c's.
#include "source/displaced_cook.h"

#include <math.h>

#include "base/size.h"
#include "base/thread.h"

// Squares of coordinates are floats too.
static const float coordinate_most = 1e18f;
static const float height_most = 1e12f;

// ------------------------------------------------------------------------------------------------------------- maps

vec2 clast_displaced_coordinates(const displaced_map *map, const clast_mesh *mesh, uint32_t vertex)
{
    const float *coordinates = mesh->coordinates[map->coordinate_set];
    if (coordinates == NULL) {
        return splat2(0.0f);
    }
    const float *at = coordinates + 2 * (size_t)vertex;
    return (map->columns[0] * at[0] + map->columns[1] * at[1]) + map->moved;
}

float clast_displaced_height(const displaced_map *map, vec2 coordinates, float level)
{
    return map->height != NULL ? clast_height_value(map->height, coordinates, level) * map->scale + map->offset : 0.0f;
}

static clast_status add_map(displaced_cook *cook, const clast_cook_job *job, uint32_t material)
{
    displaced_unit *unit = cook->unit;
    const clast_material *from = &job->scene->materials[material].record;
    const clast_texture_use *use = &from->displacement_texture;
    unit->opaque = unit->opaque && from->alpha_mode == CLAST_ALPHA_OPAQUE && from->transmission == 0.0f;
    if (use->texture == CLAST_NONE) {
        return CLAST_OK;
    }
    uint32_t set = use->coordinate_set & 1;
    const char *name = job->geometry->name != NULL ? job->geometry->name : "mesh";
    if (cook->mesh->coordinates[set] == NULL) {
        clast_log(job->context, CLAST_LOG_WARNING,
                  "%s: material %u displaces it by texture coordinates %u, which it does not have: it is not displaced",
                  name, material, set);
        return CLAST_OK;
    }
    displaced_map *map = &unit->maps[unit->map_count];
    clast_status status = clast_height_acquire(unit->heights, job->scene, use->texture, &map->height);
    if (status != CLAST_OK) {
        return status;
    }
    map->scale = from->displacement_scale;
    map->offset = from->displacement_offset;
    map->coordinate_set = set;
    map->moved = transform_coordinates(*use, splat2(0.0f));
    map->columns[0] = transform_coordinates(*use, vec2(1.0f, 0.0f)) - map->moved;
    map->columns[1] = transform_coordinates(*use, vec2(0.0f, 1.0f)) - map->moved;
    unit->map_of_material[material] = (uint32_t)unit->map_count++;
    unit->displaced = true;
    return CLAST_OK;
}

static clast_status make_maps(displaced_cook *cook, const clast_cook_job *job)
{
    displaced_unit *unit = cook->unit;
    clast_context *context = job->context;
    unit->maps = clast_allocate_zeroed(context, (size_t)unit->base.material_count + 1, sizeof *unit->maps);
    unit->map_of_material = clast_allocate_zeroed(context, job->scene->material_count, sizeof *unit->map_of_material);
    unit->material_count = job->scene->material_count;
    if (unit->maps == NULL || unit->map_of_material == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    unit->map_count = 1; // DISPLACED_NO_MAP
    unit->opaque = true;
    clast_status status = CLAST_OK;
    for (uint32_t i = 0; i < unit->base.material_count && status == CLAST_OK; i++) {
        status = add_map(cook, job, unit->base.materials[i]);
    }
    return status;
}

// --------------------------------------------------------------------------------------------------------- vertices

// Vertices are numbered as clusters first have them, so that those of a cluster lie close to each other.
static clast_status number_vertices(displaced_cook *cook)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    unit->vertex_of = clast_allocate(cook->context, mesh->vertex_count, sizeof *unit->vertex_of);
    unit->vertex_numbers = clast_allocate(cook->context, cook->clusters.vertex_count, sizeof *unit->vertex_numbers);
    if (unit->vertex_of == NULL || unit->vertex_numbers == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(unit->vertex_of, 0xff, mesh->vertex_count * sizeof *unit->vertex_of); // CLAST_NONE
    for (size_t i = 0; i < cook->clusters.vertex_count; i++) {
        uint32_t *number = &unit->vertex_of[cook->clusters.vertices[i]];
        if (*number == CLAST_NONE) {
            *number = (uint32_t)unit->vertex_count++;
        }
        unit->vertex_numbers[i] = *number;
    }
    unit->corner_count = cook->clusters.vertex_count;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        unit->vertex_of[i] = unit->vertex_of[cook->remap[i]];
    }
    unit->vertices = clast_allocate_zeroed(cook->context, unit->vertex_count + 1, sizeof *unit->vertices);
    return unit->vertices != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static void find_owners(displaced_cook *cook)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    for (size_t i = 0; i < unit->vertex_count; i++) {
        unit->vertices[i].mesh_vertex = CLAST_NONE;
        unit->vertices[i].density_square = INFINITY;
        unit->vertices[i].shortest_square = INFINITY;
    }
    for (uint32_t triangle = 0; triangle < mesh->triangle_count; triangle++) {
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t corner = mesh->indices[3 * (size_t)triangle + k];
            displaced_vertex *vertex = &unit->vertices[unit->vertex_of[corner]];
            if (vertex->mesh_vertex == CLAST_NONE) {
                vertex->mesh_vertex = corner;
                vertex->position = clast_mesh_position(mesh, corner);
                vertex->map = displaced_map_of(unit, triangle);
                vertex->coordinates = store2(clast_displaced_coordinates(&unit->maps[vertex->map], mesh, corner));
            }
        }
    }
}

static vec3 direction_of(vec3 v)
{
    float largest = largest3(vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])));
    return largest > 0.0f && is_finite1(largest) ? normalize3(v * (1.0f / largest)) : splat3(0.0f);
}

// The angle at a corner, and a little where there is none: a vertex of nothing but degenerate triangles has normals too.
static float corner_angle(vec3 at, vec3 next, vec3 last)
{
    float cosine = dot3(direction_of(next - at), direction_of(last - at));
    return max1(1e-6f, acosf(clamp1(cosine, -1.0f, 1.0f)));
}

typedef struct mesh_triangle {
    const uint32_t *vertices;
    vec3 positions[3];
    vec3 normal; // unit length, or zero
    float angles[3];
} mesh_triangle;

static mesh_triangle triangle_at(const clast_mesh *mesh, size_t triangle)
{
    mesh_triangle result = {.vertices = mesh->indices + 3 * triangle};
    for (uint32_t k = 0; k < 3; k++) {
        result.positions[k] = load3(clast_mesh_position(mesh, result.vertices[k]));
    }
    const vec3 *p = result.positions;
    vec3 first = p[1] - p[0], second = p[2] - p[0];
    float largest = max1(largest3(vec3(abs1(first[0]), abs1(first[1]), abs1(first[2]))),
                         largest3(vec3(abs1(second[0]), abs1(second[1]), abs1(second[2]))));
    float scale = largest > 1e-30f ? 1.0f / largest : 0.0f;
    result.normal = direction_of(cross3(first * scale, second * scale));
    for (uint32_t k = 0; k < 3; k++) {
        result.angles[k] = corner_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    }
    return result;
}

// A normal of the mesh; zero where it is none.
static vec3 mesh_normal(const clast_mesh *mesh, size_t vertex)
{
    const float *normal = mesh->normals + 3 * vertex;
    return direction_of(vec3(normal[0], normal[1], normal[2]));
}

static void add_normal(displaced_vertex *vertex, vec3 normal, float weight)
{
    vertex->normal = store3(load3(vertex->normal) + normal * weight);
}

// Of all normals at a position, weighted by the angles of the corners that have them. `counts` says of how many.
static void sum_normals(displaced_cook *cook, const float *angles, uint32_t *counts)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    for (size_t i = 0; mesh->normals != NULL && i < mesh->vertex_count; i++) {
        if (angles[i] > 0.0f) {
            add_normal(&unit->vertices[unit->vertex_of[i]], mesh_normal(mesh, i), angles[i]);
            counts[unit->vertex_of[i]]++;
        }
    }
    for (size_t i = 0; mesh->normals == NULL && i < mesh->triangle_count; i++) {
        mesh_triangle triangle = triangle_at(mesh, i);
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t number = unit->vertex_of[triangle.vertices[k]];
            add_normal(&unit->vertices[number], triangle.normal, triangle.angles[k]);
            counts[number]++;
        }
    }
    for (size_t i = 0; i < unit->vertex_count; i++) {
        unit->vertices[i].normal = store3(direction_of(load3(unit->vertices[i].normal)));
    }
}

static void put_normal(displaced_unit *unit, uint32_t *counts, uint32_t vertex, uint32_t number, float weight)
{
    uint32_t first = unit->vertices[vertex].first_normal, end = unit->vertices[vertex + 1].first_normal;
    if (first != end) {
        unit->normals[end - counts[vertex]--] = (displaced_normal){number, weight};
    }
}

// What poses need: where a vertex has the normals of several vertices or triangles, all of these.
static clast_status list_normals(displaced_cook *cook, const float *angles, uint32_t *counts)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    uint32_t least = mesh->normals != NULL ? 2 : 1;
    size_t sum = 0; // at most three for each triangle: they fit
    for (size_t i = 0; i < unit->vertex_count; i++) {
        unit->vertices[i].first_normal = (uint32_t)sum;
        sum += counts[i] >= least ? counts[i] : 0;
    }
    unit->vertices[unit->vertex_count].first_normal = (uint32_t)sum;
    unit->vertices[unit->vertex_count].mesh_vertex = CLAST_NONE;
    unit->normal_count = sum;
    unit->normals = clast_allocate(cook->context, sum, sizeof *unit->normals);
    if (unit->normals == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; mesh->normals != NULL && i < mesh->vertex_count; i++) {
        if (angles[i] > 0.0f) {
            put_normal(unit, counts, unit->vertex_of[i], i, angles[i]);
        }
    }
    for (uint32_t i = 0; mesh->normals == NULL && i < mesh->triangle_count; i++) {
        mesh_triangle triangle = triangle_at(mesh, i);
        for (uint32_t k = 0; k < 3; k++) {
            put_normal(unit, counts, unit->vertex_of[triangle.vertices[k]], i, triangle.angles[k]);
        }
    }
    return CLAST_OK;
}

static clast_status make_normals(displaced_cook *cook)
{
    const clast_mesh *mesh = cook->mesh;
    float *angles = clast_allocate_zeroed(cook->context, mesh->vertex_count, sizeof *angles);
    uint32_t *counts = clast_allocate_zeroed(cook->context, cook->unit->vertex_count, sizeof *counts);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (angles != NULL && counts != NULL) {
        for (size_t i = 0; mesh->normals != NULL && i < mesh->triangle_count; i++) {
            mesh_triangle triangle = triangle_at(mesh, i);
            for (uint32_t k = 0; k < 3; k++) {
                angles[triangle.vertices[k]] += triangle.angles[k];
            }
        }
        sum_normals(cook, angles, counts);
        status = list_normals(cook, angles, counts);
    }
    clast_free(cook->context, angles);
    clast_free(cook->context, counts);
    return status;
}

// ---------------------------------------------------------------------------------------------------------- lengths

static double square_between(vec3 a, vec3 b)
{
    double x = (double)b[0] - (double)a[0], y = (double)b[1] - (double)a[1], z = (double)b[2] - (double)a[2];
    return x * x + y * y + z * z;
}

static double area_of(const vec3 p[3])
{
    double e[2][3];
    for (uint32_t axis = 0; axis < 3; axis++) {
        e[0][axis] = (double)p[1][axis] - (double)p[0][axis];
        e[1][axis] = (double)p[2][axis] - (double)p[0][axis];
    }
    double x = e[0][1] * e[1][2] - e[0][2] * e[1][1];
    double y = e[0][2] * e[1][0] - e[0][0] * e[1][2];
    double z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return sqrt(x * x + y * y + z * z);
}

// Texels over the area of a triangle; 0 where either has none.
static float density_square_of(const displaced_map *map, const clast_mesh *mesh, const uint32_t *vertices, double area)
{
    if (map->height == NULL || area <= 0.0) {
        return 0.0f;
    }
    vec2 a = clast_displaced_coordinates(map, mesh, vertices[0]);
    vec2 first = clast_displaced_coordinates(map, mesh, vertices[1]) - a;
    vec2 second = clast_displaced_coordinates(map, mesh, vertices[2]) - a;
    double covered = fabs((double)first[0] * (double)second[1] - (double)first[1] * (double)second[0]);
    double texels = covered * map->height->map.widths[0] * map->height->map.heights[0];
    float density = (float)(texels / area);
    return is_finite1(density) ? density : 0.0f;
}

// The finest level of its triangles that a vertex has: the fewest texels for each length, and its shortest edge.
static void measure_vertices(displaced_cook *cook)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *vertices = mesh->indices + 3 * i;
        vec3 p[3];
        for (uint32_t k = 0; k < 3; k++) {
            p[k] = load3(clast_mesh_position(mesh, vertices[k]));
        }
        const displaced_map *map = &unit->maps[displaced_map_of(unit, (uint32_t)i)];
        float density = density_square_of(map, mesh, vertices, area_of(p));
        for (uint32_t k = 0; k < 3; k++) {
            displaced_vertex *ends[2] = {&unit->vertices[unit->vertex_of[vertices[k]]],
                                         &unit->vertices[unit->vertex_of[vertices[(k + 1) % 3]]]};
            float square = (float)square_between(p[k], p[(k + 1) % 3]);
            for (uint32_t end = 0; end < 2 && square > 0.0f; end++) {
                ends[end]->shortest_square = min1(ends[end]->shortest_square, square);
            }
            ends[0]->density_square = density > 0.0f ? min1(ends[0]->density_square, density) : ends[0]->density_square;
        }
    }
    for (size_t i = 0; i < unit->vertex_count; i++) {
        displaced_vertex *vertex = &unit->vertices[i];
        vertex->density_square = is_finite1(vertex->density_square) ? vertex->density_square : 0.0f;
        vertex->shortest_square = is_finite1(vertex->shortest_square) ? vertex->shortest_square : 0.0f;
        float level = vertex_rest_level(vertex->density_square, vertex->shortest_square);
        vertex->height = clast_displaced_height(&unit->maps[vertex->map], load2(vertex->coordinates), level);
    }
}

// -------------------------------------------------------------------------------------------------------- gradients

// The gradients of two functions that are linear on a triangle and grow by these differences along its edges. False for a
// triangle without area.
static bool gradients_of(const vec3 p[3], vec2 first, vec2 second, vec3 *u, vec3 *v, float *area)
{
    vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    double a = square_between(p[0], p[1]), c = square_between(p[0], p[2]);
    double b = (double)e1[0] * (double)e2[0] + (double)e1[1] * (double)e2[1] + (double)e1[2] * (double)e2[2];
    double determinant = a * c - b * b;
    if (!(determinant > 1e-12 * a * c)) {
        return false;
    }
    float s1 = (float)((c * (double)first[0] - b * (double)second[0]) / determinant);
    float t1 = (float)((a * (double)second[0] - b * (double)first[0]) / determinant);
    float s2 = (float)((c * (double)first[1] - b * (double)second[1]) / determinant);
    float t2 = (float)((a * (double)second[1] - b * (double)first[1]) / determinant);
    *u = e1 * s1 + e2 * t1;
    *v = e1 * s2 + e2 * t2;
    *area = (float)sqrt(determinant);
    return is_finite3(*u) && is_finite3(*v) && is_finite1(*area);
}

// Adds up over the triangles of each vertex of the mesh, times their areas.
static void sum_gradients(const clast_mesh *mesh, const float *coordinates, displaced_gradient *gradients, float *areas)
{
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *vertices = mesh->indices + 3 * i;
        vec3 p[3];
        vec2 at[3];
        for (uint32_t k = 0; k < 3; k++) {
            p[k] = load3(clast_mesh_position(mesh, vertices[k]));
            at[k] = vec2(coordinates[2 * (size_t)vertices[k]], coordinates[2 * (size_t)vertices[k] + 1]);
        }
        vec3 u, v;
        float area;
        if (!gradients_of(p, at[1] - at[0], at[2] - at[0], &u, &v, &area)) {
            continue;
        }
        for (uint32_t k = 0; k < 3; k++) {
            displaced_gradient *sum = &gradients[vertices[k]];
            sum->u = store3(load3(sum->u) + u * area);
            sum->v = store3(load3(sum->v) + v * area);
            areas[vertices[k]] += area;
        }
    }
}

// Where the mesh has a position several times with the same texture coordinates, as hard edges do, all get the mean.
static void share_gradients(const uint32_t *members, size_t count, displaced_gradient *gradients, const float *areas)
{
    vec3 u = splat3(0.0f), v = splat3(0.0f);
    float area = 0.0f;
    for (size_t i = 0; i < count; i++) {
        u += load3(gradients[members[i]].u);
        v += load3(gradients[members[i]].v);
        area += areas[members[i]];
    }
    float scale = area > 1e-36f ? 1.0f / area : 0.0f;
    displaced_gradient mean = {store3(u * scale), store3(v * scale)};
    for (size_t i = 0; i < count; i++) {
        gradients[members[i]] = mean;
    }
}

static uint64_t place_and_coordinates(const displaced_unit *unit, const float *coordinates, size_t vertex)
{
    uint32_t bits[2];
    memcpy(bits, coordinates + 2 * vertex, sizeof bits);
    uint32_t mixed = (bits[0] * 2654435761u) ^ (bits[1] * 2246822519u); // others in one place seldom share it
    return (uint64_t)unit->vertex_of[vertex] << 32 | mixed;
}

static clast_status make_gradients(displaced_cook *cook, uint32_t set)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    clast_context *context = cook->context;
    const float *coordinates = mesh->coordinates[set];
    size_t count = mesh->vertex_count;
    displaced_gradient *gradients = clast_allocate_zeroed(context, count, sizeof *gradients);
    float *areas = clast_allocate_zeroed(context, count, sizeof *areas);
    uint64_t *keys = clast_allocate(context, count, sizeof *keys);
    uint32_t *members = clast_allocate(context, count, sizeof *members);
    unit->gradients[set] = gradients;
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (gradients != NULL && areas != NULL && keys != NULL && members != NULL) {
        sum_gradients(mesh, coordinates, gradients, areas);
        for (size_t i = 0; i < count; i++) {
            keys[i] = place_and_coordinates(unit, coordinates, i);
            members[i] = (uint32_t)i;
        }
        status = clast_sort_pairs(context, keys, members, count);
    }
    for (size_t first = 0, end = 0; status == CLAST_OK && first < count; first = end) {
        for (end = first + 1; end < count && keys[end] == keys[first]; end++) {
        }
        share_gradients(members + first, end - first, gradients, areas);
    }
    clast_free(context, areas);
    clast_free(context, keys);
    clast_free(context, members);
    return status;
}

static clast_status make_all_gradients(displaced_cook *cook)
{
    clast_status status = CLAST_OK;
    for (uint32_t set = 0; set < 2; set++) {
        bool used = false;
        for (size_t i = 1; i < cook->unit->map_count; i++) {
            used = used || cook->unit->maps[i].coordinate_set == set;
        }
        if (used && status == CLAST_OK) {
            status = make_gradients(cook, set);
        }
    }
    return status;
}

// ----------------------------------------------------------------------------------------------------------- bounds

static void widen(clast_box *box, vec3 point)
{
    box->lower = store3(min3(load3(box->lower), point));
    box->upper = store3(max3(load3(box->upper), point));
}

// The least and greatest that the direction of a blend of unit normals may be along each axis: a blend is at least as long as
// one of equal parts of three that are as far apart as any two of these.
static clast_box directions_of(const vec3 n[3])
{
    clast_box box = {store3(n[0]), store3(n[0])};
    float least = 1.0f;
    for (uint32_t k = 0; k < 3; k++) {
        widen(&box, n[k]);
        least = min1(least, dot3(n[k], n[(k + 1) % 3]));
        least = dot3(n[k], n[k]) > 0.5f ? least : -1.0f; // none there
    }
    float square = (1.0f + 2.0f * least) * 0.333333f;
    float stretch = square > 0.01f ? 1.0001f / sqrtf(square) : 1e6f;
    for (uint32_t axis = 0; axis < 3; axis++) {
        float lower = box.lower.v[axis] < 0.0f || stretch > 1e5f ? box.lower.v[axis] * stretch : box.lower.v[axis];
        float upper = box.upper.v[axis] > 0.0f || stretch > 1e5f ? box.upper.v[axis] * stretch : box.upper.v[axis];
        box.lower.v[axis] = stretch > 1e5f ? -1.0f : clamp1(lower, -1.0f, 1.0f);
        box.upper.v[axis] = stretch > 1e5f ? 1.0f : clamp1(upper, -1.0f, 1.0f);
    }
    return box;
}

// What a triangle's map holds over it, as heights.
static clast_height_range heights_of(const displaced_unit *unit, size_t triangle, clast_height_range range)
{
    const displaced_map *map = &unit->maps[displaced_map_of(unit, (uint32_t)triangle)];
    if (map->height == NULL) {
        return (clast_height_range){0.0f, 0.0f};
    }
    float a = range.lower * map->scale + map->offset, b = range.upper * map->scale + map->offset;
    return (clast_height_range){min1(a, b), max1(a, b)};
}

static float reach_of_triangle(const displaced_unit *unit, const clast_mesh *mesh, size_t triangle,
                               clast_height_range range, clast_box *reach)
{
    vec3 n[3];
    for (uint32_t k = 0; k < 3; k++) {
        n[k] = load3(unit->vertices[unit->vertex_of[mesh->indices[3 * triangle + k]]].normal);
    }
    clast_height_range heights = heights_of(unit, triangle, range);
    clast_box directions = directions_of(n);
    widen(reach, load3(directions.lower) * heights.lower);
    widen(reach, load3(directions.lower) * heights.upper);
    widen(reach, load3(directions.upper) * heights.lower);
    widen(reach, load3(directions.upper) * heights.upper);
    return max1(abs1(heights.lower), abs1(heights.upper));
}

typedef struct reach_job {
    const displaced_unit *unit;
    const clast_mesh *mesh;
    const clast_height_range *ranges; // by triangle
    clast_box *boxes;                 // one for each chunk
    float *heights;
} reach_job;

enum { REACH_GRAIN = 4096 };

static void reach_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    reach_job *job = data;
    clast_box *box = &job->boxes[begin / REACH_GRAIN];
    *box = (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    float *height = &job->heights[begin / REACH_GRAIN];
    *height = 0.0f;
    for (size_t i = begin; i < end; i++) {
        *height = max1(*height, reach_of_triangle(job->unit, job->mesh, i, job->ranges[i], box));
    }
}

static bool box_within(const clast_box *box, float most)
{
    bool within = true;
    for (uint32_t axis = 0; axis < 3; axis++) {
        within = within && box->lower.v[axis] >= -most && box->upper.v[axis] <= most;
    }
    return within;
}

static clast_status bound_surface(displaced_cook *cook, const clast_height_range *ranges)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    size_t chunks = ((size_t)mesh->triangle_count + REACH_GRAIN - 1) / REACH_GRAIN;
    reach_job job = {unit, mesh, ranges, clast_allocate(cook->context, chunks, sizeof *job.boxes),
                     clast_allocate(cook->context, chunks, sizeof *job.heights)};
    if (job.boxes == NULL || job.heights == NULL) {
        clast_free(cook->context, job.boxes);
        clast_free(cook->context, job.heights);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(cook->context, mesh->triangle_count, REACH_GRAIN, reach_range, &job);
    unit->reach = job.boxes[0];
    for (size_t i = 0; i < chunks; i++) {
        unit->height_most = max1(unit->height_most, job.heights[i]);
        widen(&unit->reach, load3(job.boxes[i].lower));
        widen(&unit->reach, load3(job.boxes[i].upper));
    }
    clast_free(cook->context, job.boxes);
    clast_free(cook->context, job.heights);
    unit->rest = clast_displaced_rest_box(unit, &(clast_pose){0});
    const char *name = unit->base.geometry->name != NULL ? unit->base.geometry->name : "mesh";
    if (!(unit->height_most <= height_most)) {
        return clast_fail(cook->context, CLAST_ERROR_LIMIT, "%s: displacement by more than %g, which is the most", name,
                          (double)height_most);
    }
    if (!box_within(&unit->rest, coordinate_most)) {
        return clast_fail(cook->context, CLAST_ERROR_LIMIT,
                          "%s: coordinates beyond %g, which tessellated meshes may not have", name,
                          (double)coordinate_most);
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- cook

static void count_bytes(displaced_unit *unit)
{
    const clast_mesh *mesh = &unit->base.geometry->of.mesh;
    size_t gradients = (unit->gradients[0] != NULL) + (size_t)(unit->gradients[1] != NULL);
    unit->base.bytes = sizeof *unit + DISPLACED_FACTORS * sizeof *unit->pattern_uses +
                       unit->base.item_count * sizeof *unit->clusters +
                       unit->triangle_count * (sizeof *unit->triangles + sizeof *unit->mesh_triangles) +
                       unit->corner_count * sizeof *unit->vertex_numbers + unit->edge_count * sizeof *unit->edges +
                       unit->seam_count * sizeof *unit->seams + unit->vertex_count * sizeof *unit->vertices +
                       unit->normal_count * sizeof *unit->normals + mesh->vertex_count * sizeof *unit->vertex_of +
                       gradients * mesh->vertex_count * sizeof(displaced_gradient) +
                       unit->map_count * (sizeof *unit->maps + sizeof *unit->map_records) +
                       unit->material_count * sizeof *unit->map_of_material +
                       unit->base.material_count * sizeof(uint32_t);
}

// What devices need of a unit beside its arrays.
static clast_status make_records(displaced_unit *unit)
{
    unit->header = (clast_displaced_header){
        .flags = (unit->curved ? DISPLACED_CURVED : 0) | (unit->closed ? DISPLACED_CLOSED : 0) |
                 (unit->opaque ? DISPLACED_OPAQUE : 0) | (unit->displaced ? DISPLACED_MOVED : 0),
        .first_pattern = unit->first_pattern,
        .height_most = unit->height_most,
        .rest = unit->rest,
        .reach = unit->reach,
    };
    unit->map_records = clast_allocate(unit->base.context, unit->map_count, sizeof *unit->map_records);
    for (size_t i = 0; unit->map_records != NULL && i < unit->map_count; i++) {
        const displaced_map *map = &unit->maps[i];
        unit->map_records[i] = (clast_displaced_map){
            .is_there = map->height != NULL,
            .scale = map->scale,
            .offset = map->offset,
            .coordinate_set = map->coordinate_set,
            .columns = {store2(map->columns[0]), store2(map->columns[1])},
            .moved = store2(map->moved),
        };
    }
    return unit->map_records != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// For cancelling between the stages of a mesh that takes seconds.
static clast_status look_up(const displaced_cook *cook, uint64_t stage)
{
    enum { PROGRESS_TRIANGLES = 1000000, STAGES = 5 };
    return cook->mesh->triangle_count < PROGRESS_TRIANGLES ? CLAST_OK
                                                           : clast_progress(cook->context, "displaced", stage, STAGES);
}

static clast_status cut_clusters(displaced_cook *cook)
{
    const clast_mesh *mesh = cook->mesh;
    cook->remap = clast_allocate(cook->context, mesh->vertex_count, sizeof *cook->remap);
    if (cook->remap == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    size_t unique = 0;
    clast_status status = clast_mesh_weld_positions(cook->context, cook->unit->base.geometry, cook->remap, &unique);
    if (status == CLAST_OK) {
        status = clast_mesh_weld(cook->context, mesh, cook->remap, unique, &cook->welded);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_clusterize_desc desc = {
        .positions = mesh->positions,
        .position_count = mesh->vertex_count,
        .indices = cook->welded != NULL ? cook->welded : mesh->indices,
        .triangle_count = mesh->triangle_count,
        .max_triangles = CLUSTER_TRIANGLES,
        .max_vertices = CLUSTER_VERTICES,
    };
    return clast_clusterize(cook->context, &desc, &cook->clusters);
}

static clast_status cook_mesh(displaced_cook *cook, const clast_cook_job *job)
{
    displaced_unit *unit = cook->unit;
    clast_status status = clast_mesh_list_materials(cook->context, cook->mesh, &unit->base.materials,
                                                    &unit->base.material_count);
    status = status == CLAST_OK ? make_maps(cook, job) : status;
    status = status == CLAST_OK ? look_up(cook, 1) : status;
    status = status == CLAST_OK ? cut_clusters(cook) : status;
    status = status == CLAST_OK ? look_up(cook, 2) : status;
    status = status == CLAST_OK ? number_vertices(cook) : status;
    if (status != CLAST_OK) {
        return status;
    }
    find_owners(cook);
    status = make_normals(cook);
    if (status != CLAST_OK) {
        return status;
    }
    measure_vertices(cook);
    status = make_all_gradients(cook);
    status = status == CLAST_OK ? look_up(cook, 3) : status;
    clast_height_range *ranges = NULL;
    status = status == CLAST_OK ? clast_displaced_find_heights(cook, job->cache, &ranges) : status;
    status = status == CLAST_OK ? bound_surface(cook, ranges) : status;
    clast_free(cook->context, ranges);
    status = status == CLAST_OK ? look_up(cook, 4) : status;
    status = status == CLAST_OK ? clast_displaced_cook_clusters(cook, job->templates) : status;
    status = status == CLAST_OK ? make_records(unit) : status;
    return status;
}

void clast_displaced_destroy(clast_unit *base)
{
    displaced_unit *unit = (displaced_unit *)base;
    clast_context *context = base->context;
    for (size_t i = 0; i < unit->map_count; i++) {
        if (unit->maps[i].height != NULL) {
            clast_height_release(unit->heights, unit->maps[i].height);
        }
    }
    clast_free(context, base->materials);
    clast_free(context, unit->pattern_uses);
    clast_free(context, unit->clusters);
    clast_free(context, unit->triangles);
    clast_free(context, unit->mesh_triangles);
    clast_free(context, unit->vertex_numbers);
    clast_free(context, unit->edges);
    clast_free(context, unit->seams);
    clast_free(context, unit->vertices);
    clast_free(context, unit->normals);
    clast_free(context, unit->vertex_of);
    clast_free(context, unit->gradients[0]);
    clast_free(context, unit->gradients[1]);
    clast_free(context, unit->maps);
    clast_free(context, unit->map_records);
    clast_free(context, unit->map_of_material);
    clast_free(context, unit);
}

clast_status clast_displaced_cook(const clast_cook_job *job, clast_unit **result)
{
    displaced_unit *unit = clast_allocate_zeroed(job->context, 1, sizeof *unit);
    if (unit == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    unit->base = (clast_unit){
        .context = job->context,
        .kind = CLAST_SOURCE_DISPLACED,
        .geometry = job->geometry,
        .geometry_version = job->geometry->version,
        .bytes = sizeof *unit,
    };
    unit->templates = job->templates;
    unit->heights = job->heights;
    unit->patterns = job->patterns;
    unit->curved = job->geometry->tessellation.curved;
    unit->rest = (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    displaced_cook cook = {.context = job->context, .unit = unit, .mesh = &job->geometry->of.mesh};
    clast_status status = cook.mesh->triangle_count != 0 ? cook_mesh(&cook, job) : CLAST_OK;
    clast_free(job->context, cook.remap);
    clast_free(job->context, cook.welded);
    clast_clusters_free(job->context, &cook.clusters);
    if (status != CLAST_OK) {
        clast_displaced_destroy(&unit->base);
        return status;
    }
    count_bytes(unit);
    *result = &unit->base;
    return CLAST_OK;
}
