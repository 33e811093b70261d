// SPDX-License-Identifier: Apache-2.0
// Meshes of OBJ files that lack normals: faces go one after the other, as sums of normals depend on their order.
#include <math.h>

#include "load/obj.h"
#include "load/polygon.h"

// The normals that a mesh's faces need and the file does not give: one for each flat face, and one for each position of
// a smoothing group. Their numbers follow those of the file's normals.
typedef struct derived_normal {
    double sum[3];
    uint32_t position, group;
} derived_normal;

typedef struct smooth_builder {
    const clast_obj *obj;
    const clast_obj_object *object;
    clast_obj_arrays *arrays;
    clast_obj_corner *vertices; // `normal` also counts derived ones
    size_t vertex_count, vertex_capacity;
    clast_table vertex_table;
    derived_normal *derived;
    size_t derived_count, derived_capacity;
    clast_table derived_table;
    uint32_t *face_vertices; // of the face at hand
    size_t face_capacity;
    clast_polygon polygon;
} smooth_builder;

static clast_status add_derived(smooth_builder *builder, uint32_t position, uint32_t group, uint32_t *number)
{
    const clast_obj *obj = builder->obj;
    if (obj->normal_count + builder->derived_count >= CLAST_NONE) {
        return clast_obj_out_of_range(obj);
    }
    clast_status status = CLAST_RESERVE(obj->context, builder->derived, builder->derived_capacity,
                                        builder->derived_count + 1);
    if (status == CLAST_OK) {
        *number = (uint32_t)builder->derived_count;
        builder->derived[builder->derived_count++] = (derived_normal){.position = position, .group = group};
    }
    return status;
}

// The derived normal of a position in a smoothing group.
static clast_status find_smooth(smooth_builder *builder, uint32_t position, uint32_t group, uint32_t *number)
{
    clast_status status = clast_table_reserve(builder->obj->context, &builder->derived_table);
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t hash = (uint32_t)(clast_hash_word(clast_hash_word(0, position), group) >> 16);
    size_t place = hash;
    while ((*number = clast_table_next(&builder->derived_table, hash, &place)) != CLAST_NONE) {
        if (builder->derived[*number].position == position && builder->derived[*number].group == group) {
            return CLAST_OK;
        }
    }
    status = add_derived(builder, position, group, number);
    if (status == CLAST_OK) {
        clast_table_insert(&builder->derived_table, hash, place, *number);
    }
    return status;
}

static clast_status add_vertex(smooth_builder *builder, clast_obj_corner key, uint32_t *number)
{
    if (builder->vertex_count + 1 >= CLAST_NONE) {
        return clast_obj_out_of_range(builder->obj);
    }
    clast_status status = CLAST_RESERVE(builder->obj->context, builder->vertices, builder->vertex_capacity,
                                        builder->vertex_count + 1);
    if (status == CLAST_OK) {
        *number = (uint32_t)builder->vertex_count;
        builder->vertices[builder->vertex_count++] = key;
    }
    return status;
}

static clast_status find_vertex(smooth_builder *builder, clast_obj_corner key, uint32_t *number)
{
    clast_context *context = builder->obj->context;
    clast_status status = clast_table_reserve(context, &builder->vertex_table);
    if (status != CLAST_OK) {
        return status;
    }
    uint64_t pair = (uint64_t)key.coordinate << 32 | key.normal;
    uint32_t hash = (uint32_t)(clast_hash_word(clast_hash_word(0, key.position), pair) >> 16);
    size_t place = hash;
    while ((*number = clast_table_next(&builder->vertex_table, hash, &place)) != CLAST_NONE) {
        const clast_obj_corner *vertex = &builder->vertices[*number];
        if (vertex->position == key.position && vertex->coordinate == key.coordinate && vertex->normal == key.normal) {
            return CLAST_OK;
        }
    }
    status = add_vertex(builder, key, number);
    if (status == CLAST_OK) {
        clast_table_insert(&builder->vertex_table, hash, place, *number);
    }
    return status;
}

// The normal of a corner: the file's, or the group's at its position, or the face's own (`flat`, made when first
// needed).
static clast_status choose_normal(smooth_builder *builder, uint32_t group, clast_obj_corner *corner, uint32_t *flat)
{
    const clast_obj *obj = builder->obj;
    if (clast_obj_has_normal(obj, *corner)) {
        return CLAST_OK;
    }
    uint32_t derived = *flat;
    clast_status status = CLAST_OK;
    if (group != 0) {
        status = find_smooth(builder, corner->position, group, &derived);
    } else if (derived == CLAST_NONE) {
        status = add_derived(builder, CLAST_NONE, 0, &derived);
        *flat = derived;
    }
    if (status == CLAST_OK) {
        // The polygon's area-weighted normal goes to each of its corners once; to a flat face's own normal all are the
        // same.
        for (int c = 0; c < 3; c++) {
            builder->derived[derived].sum[c] += builder->polygon.normal[c];
        }
        corner->normal = (uint32_t)obj->normal_count + derived;
    }
    return status;
}

static clast_status add_face(smooth_builder *builder, const clast_obj_cursor *face, size_t *triangle)
{
    const clast_obj *obj = builder->obj;
    uint32_t count = face->length;
    clast_status status = clast_polygon_reserve(obj->context, &builder->polygon, count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(obj->context, builder->face_vertices, builder->face_capacity, count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t position = builder->object->positions[face->corner + i];
        memcpy(builder->polygon.points[i], obj->positions[position], sizeof *builder->polygon.points);
    }
    clast_polygon_cut(&builder->polygon, count);
    uint32_t flat = CLAST_NONE;
    for (uint32_t i = 0; i < count; i++) {
        clast_obj_corner corner = clast_obj_corner_at(builder->object, face->corner + i);
        status = choose_normal(builder, face->run->smoothing, &corner, &flat);
        if (status == CLAST_OK) {
            status = find_vertex(builder, corner, &builder->face_vertices[i]);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    for (uint32_t i = 0; i < 3 * (count - 2); i++) {
        builder->arrays->indices[3 * *triangle + i] = builder->face_vertices[builder->polygon.corners[i]];
    }
    *triangle += count - 2;
    return CLAST_OK;
}

static clast_status add_faces(smooth_builder *builder)
{
    const clast_obj *obj = builder->obj;
    const clast_obj_object *object = builder->object;
    builder->arrays->indices = clast_allocate(obj->context, (size_t)object->triangle_count,
                                              3 * sizeof *builder->arrays->indices);
    if (builder->arrays->indices == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    size_t triangle = 0;
    for (size_t i = 0; i < object->span_count; i++) {
        clast_obj_cursor face = clast_obj_first_face(obj, &obj->spans[object->first_span + i]);
        for (; clast_obj_has_face(&face); clast_obj_next_face(&face)) {
            clast_status status = add_face(builder, &face, &triangle);
            if (status != CLAST_OK) {
                return status;
            }
        }
    }
    return CLAST_OK;
}

static void store_normal(const smooth_builder *builder, uint32_t number, float normal[3])
{
    const clast_obj *obj = builder->obj;
    if (number < obj->normal_count) {
        memcpy(normal, obj->normals[number], sizeof *obj->normals);
        return;
    }
    const double *sum = builder->derived[number - obj->normal_count].sum;
    double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    bool known = length > 0.0 && isfinite(length);
    for (int c = 0; c < 3; c++) {
        normal[c] = known ? (float)(sum[c] / length) : c == 2 ? 1.0f : 0.0f; // of degenerate faces: any
    }
}

static clast_status fill_arrays(const smooth_builder *builder, bool has_coordinates)
{
    const clast_obj *obj = builder->obj;
    clast_obj_arrays *arrays = builder->arrays;
    size_t count = arrays->vertex_count = builder->vertex_count;
    bool whole = (arrays->positions = clast_allocate(obj->context, count, sizeof *arrays->positions)) != NULL &&
                 (arrays->normals = clast_allocate(obj->context, count, sizeof *arrays->normals)) != NULL;
    if (whole && has_coordinates) {
        whole = (arrays->coordinates = clast_allocate(obj->context, count, sizeof *arrays->coordinates)) != NULL;
    }
    if (whole && obj->colours != NULL) {
        whole = (arrays->colours = clast_allocate(obj->context, count, sizeof *arrays->colours)) != NULL;
    }
    for (size_t i = 0; whole && i < count; i++) {
        clast_obj_corner vertex = builder->vertices[i];
        memcpy(arrays->positions[i], obj->positions[vertex.position], sizeof *arrays->positions);
        store_normal(builder, vertex.normal, arrays->normals[i]);
        if (has_coordinates) {
            bool given = vertex.coordinate != CLAST_NONE;
            arrays->coordinates[i][0] = given ? obj->coordinates[vertex.coordinate][0] : 0.0f;
            arrays->coordinates[i][1] = given ? obj->coordinates[vertex.coordinate][1] : 0.0f;
        }
        if (obj->colours != NULL) {
            clast_obj_fill_colour(obj, vertex.position, arrays->colours[i]);
        }
    }
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

clast_status clast_obj_smooth_mesh(clast_obj *obj, clast_obj_object *object, bool has_coordinates,
                                   clast_obj_arrays *arrays)
{
    clast_context *context = obj->context;
    smooth_builder builder = {.obj = obj, .object = object, .arrays = arrays};
    clast_status status = add_faces(&builder);
    clast_table_free(context, &builder.vertex_table);
    clast_table_free(context, &builder.derived_table);
    clast_free(context, builder.face_vertices);
    clast_polygon_free(context, &builder.polygon);
    clast_obj_free_corners(obj, object);
    if (status == CLAST_OK) {
        status = fill_arrays(&builder, has_coordinates);
    }
    clast_free(context, builder.vertices);
    clast_free(context, builder.derived);
    return status;
}
