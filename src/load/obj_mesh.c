// SPDX-License-Identifier: Apache-2.0
// Meshes from the faces of an OBJ file: a vertex for each different corner, in the order in which the corners come.
#include <math.h>

#include "load/obj.h"
#include "load/polygon.h"
#include "shared/texture_filter.h"

// The normals that a mesh's faces need and the file does not give: one for each flat face, and one for each position of
// a smoothing group. Their numbers follow those of the file's normals.
typedef struct derived_normal {
    double sum[3];
    uint32_t position, group;
} derived_normal;

typedef struct mesh_builder {
    const clast_obj *obj;
    size_t begin, end; // faces
    bool has_normals, has_coordinates, has_one_material;
    uint32_t lowest, highest; // positions used
    bool lacks_normals;       // of a corner, at least
    uint32_t *numbers; // of the vertices of positions from `lowest` on, where corners are alike; null: the table's
    clast_obj_corner *vertices; // `normal` also counts derived ones
    size_t vertex_count, vertex_capacity;
    clast_table vertex_table;
    derived_normal *derived;
    size_t derived_count, derived_capacity;
    clast_table derived_table;
    uint32_t *indices;
    uint32_t *materials;
    uint32_t material; // of the first face
    size_t triangle_count;
    uint32_t *face_vertices; // of the face at hand
    size_t face_capacity;
    clast_polygon polygon;
} mesh_builder;

static clast_status out_of_range(const mesh_builder *builder)
{
    return clast_fail(builder->obj->context, CLAST_ERROR_LIMIT,
                      "%s: an object has more vertices or triangles than a mesh may have", builder->obj->path);
}

static uint64_t face_end(const clast_obj *obj, size_t face)
{
    return face + 1 < obj->face_count ? obj->faces[face + 1].first_corner : obj->corner_count;
}

static bool has_normal(const clast_obj *obj, clast_obj_corner corner)
{
    if (corner.normal == CLAST_NONE) {
        return false;
    }
    const float *n = obj->normals[corner.normal];
    return n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f;
}

static uint32_t scene_material(const clast_obj *obj, size_t face)
{
    uint32_t name = obj->faces[face].material;
    return name != CLAST_NONE ? obj->materials[name].number : 0;
}

static clast_status survey(mesh_builder *builder)
{
    const clast_obj *obj = builder->obj;
    builder->has_one_material = true;
    builder->lowest = UINT32_MAX;
    for (size_t f = builder->begin; f < builder->end; f++) {
        uint64_t end = face_end(obj, f);
        builder->triangle_count += end - obj->faces[f].first_corner - 2;
        builder->has_normals = builder->has_normals || obj->faces[f].smoothing != 0;
        builder->has_one_material = builder->has_one_material &&
                                    scene_material(obj, f) == scene_material(obj, builder->begin);
        for (uint64_t i = obj->faces[f].first_corner; i < end; i++) {
            clast_obj_corner corner = clast_obj_corner_at(obj, i);
            bool has_own_normal = has_normal(obj, corner);
            builder->has_normals = builder->has_normals || has_own_normal;
            builder->lacks_normals = builder->lacks_normals || !has_own_normal;
            builder->has_coordinates = builder->has_coordinates || corner.coordinate != CLAST_NONE;
            builder->lowest = corner.position < builder->lowest ? corner.position : builder->lowest;
            builder->highest = corner.position > builder->highest ? corner.position : builder->highest;
        }
    }
    return builder->triangle_count <= UINT32_MAX / 3 ? CLAST_OK : out_of_range(builder);
}

static clast_status add_derived(mesh_builder *builder, uint32_t position, uint32_t group, uint32_t *number)
{
    const clast_obj *obj = builder->obj;
    if (obj->normal_count + builder->derived_count >= CLAST_NONE) {
        return out_of_range(builder);
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
static clast_status find_smooth(mesh_builder *builder, uint32_t position, uint32_t group, uint32_t *number)
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

// Where corners are alike and none needs a normal made, a position is one vertex: its number is looked up, not searched. Not for
// an object with few of the positions between its first and its last.
static clast_status number_by_position(mesh_builder *builder)
{
    const clast_obj *obj = builder->obj;
    uint64_t range = (uint64_t)builder->highest - builder->lowest + 1;
    uint64_t corners = face_end(obj, builder->end - 1) - obj->faces[builder->begin].first_corner;
    if (obj->corners != NULL || (builder->has_normals && builder->lacks_normals) || range > corners) {
        return CLAST_OK;
    }
    builder->numbers = clast_allocate(obj->context, (size_t)range, sizeof *builder->numbers);
    if (builder->numbers == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(builder->numbers, 0xff, (size_t)range * sizeof *builder->numbers); // CLAST_NONE
    return CLAST_OK;
}

static clast_status add_vertex(mesh_builder *builder, clast_obj_corner key, uint32_t *number)
{
    if (builder->vertex_count + 1 >= CLAST_NONE) {
        return out_of_range(builder);
    }
    clast_status status = CLAST_RESERVE(builder->obj->context, builder->vertices, builder->vertex_capacity,
                                        builder->vertex_count + 1);
    if (status == CLAST_OK) {
        *number = (uint32_t)builder->vertex_count;
        builder->vertices[builder->vertex_count++] = key;
    }
    return status;
}

static clast_status find_vertex(mesh_builder *builder, clast_obj_corner key, uint32_t *number)
{
    if (builder->numbers != NULL) {
        uint32_t *known = &builder->numbers[key.position - builder->lowest];
        clast_status status = *known == CLAST_NONE ? add_vertex(builder, key, known) : CLAST_OK;
        *number = *known;
        return status;
    }
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
static clast_status choose_normal(mesh_builder *builder, size_t face, clast_obj_corner *corner, uint32_t *flat)
{
    const clast_obj *obj = builder->obj;
    if (!builder->has_normals) {
        corner->normal = CLAST_NONE;
        return CLAST_OK;
    }
    if (has_normal(obj, *corner)) {
        return CLAST_OK;
    }
    uint32_t derived = *flat;
    uint32_t group = obj->faces[face].smoothing;
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

static clast_status add_face(mesh_builder *builder, size_t face, size_t *triangle)
{
    const clast_obj *obj = builder->obj;
    uint64_t first = obj->faces[face].first_corner;
    uint32_t count = (uint32_t)(face_end(obj, face) - first);
    clast_status status = clast_polygon_reserve(obj->context, &builder->polygon, count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(obj->context, builder->face_vertices, builder->face_capacity, count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t position = clast_obj_corner_at(obj, first + i).position;
        memcpy(builder->polygon.points[i], obj->positions[position], sizeof *builder->polygon.points);
    }
    clast_polygon_cut(&builder->polygon, count);
    uint32_t flat = CLAST_NONE;
    for (uint32_t i = 0; i < count; i++) {
        clast_obj_corner corner = clast_obj_corner_at(obj, first + i);
        status = choose_normal(builder, face, &corner, &flat);
        if (status == CLAST_OK) {
            status = find_vertex(builder, corner, &builder->face_vertices[i]);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    for (uint32_t i = 0; i < 3 * (count - 2); i++) {
        builder->indices[3 * *triangle + i] = builder->face_vertices[builder->polygon.corners[i]];
    }
    for (uint32_t i = 0; builder->materials != NULL && i < count - 2; i++) {
        builder->materials[*triangle + i] = scene_material(obj, face);
    }
    *triangle += count - 2;
    return CLAST_OK;
}

static clast_status add_faces(mesh_builder *builder)
{
    clast_context *context = builder->obj->context;
    builder->indices = clast_allocate(context, builder->triangle_count, 3 * sizeof *builder->indices);
    if (builder->indices == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (!builder->has_one_material) {
        builder->materials = clast_allocate(context, builder->triangle_count, sizeof *builder->materials);
        if (builder->materials == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    size_t triangle = 0;
    for (size_t f = builder->begin; f < builder->end; f++) {
        clast_status status = add_face(builder, f, &triangle);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- arrays

static void store_normal(const mesh_builder *builder, uint32_t number, float normal[3])
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

typedef struct mesh_arrays {
    float (*positions)[3];
    float (*normals)[3];
    float (*coordinates)[2];
    float (*colours)[4];
} mesh_arrays;

static void fill_arrays(const mesh_builder *builder, const mesh_arrays *arrays)
{
    const clast_obj *obj = builder->obj;
    for (size_t i = 0; i < builder->vertex_count; i++) {
        clast_obj_corner vertex = builder->vertices[i];
        memcpy(arrays->positions[i], obj->positions[vertex.position], sizeof *arrays->positions);
        if (arrays->normals != NULL) {
            store_normal(builder, vertex.normal, arrays->normals[i]);
        }
        if (arrays->coordinates != NULL) {
            bool given = vertex.coordinate != CLAST_NONE;
            arrays->coordinates[i][0] = given ? obj->coordinates[vertex.coordinate][0] : 0.0f;
            arrays->coordinates[i][1] = given ? obj->coordinates[vertex.coordinate][1] : 0.0f;
        }
        if (arrays->colours != NULL) {
            for (int c = 0; c < 3; c++) { // vertex colours are those of a display
                arrays->colours[i][c] = srgb_to_linear(obj->colours[vertex.position][c]);
            }
            arrays->colours[i][3] = 1.0f;
        }
    }
}

static bool allocate_arrays(const mesh_builder *builder, mesh_arrays *arrays)
{
    clast_context *context = builder->obj->context;
    size_t count = builder->vertex_count;
    bool whole = (arrays->positions = clast_allocate(context, count, sizeof *arrays->positions)) != NULL;
    if (builder->has_normals) {
        whole = whole && (arrays->normals = clast_allocate(context, count, sizeof *arrays->normals)) != NULL;
    }
    if (builder->has_coordinates) {
        whole = whole && (arrays->coordinates = clast_allocate(context, count, sizeof *arrays->coordinates)) != NULL;
    }
    if (builder->obj->colour_count > 0) {
        whole = whole && (arrays->colours = clast_allocate(context, count, sizeof *arrays->colours)) != NULL;
    }
    return whole;
}

static clast_status add_mesh(mesh_builder *builder, const char *name)
{
    const clast_obj *obj = builder->obj;
    mesh_arrays arrays = {0};
    if (!allocate_arrays(builder, &arrays)) {
        clast_free(obj->context, arrays.positions);
        clast_free(obj->context, arrays.normals);
        clast_free(obj->context, arrays.coordinates);
        clast_free(obj->context, arrays.colours);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    fill_arrays(builder, &arrays);
    clast_mesh mesh = {
        .vertex_count = (uint32_t)builder->vertex_count,
        .triangle_count = (uint32_t)builder->triangle_count,
        .positions = (const float *)arrays.positions,
        .normals = (const float *)arrays.normals,
        .coordinates = {(const float *)arrays.coordinates, NULL},
        .colours = (const float *)arrays.colours,
        .indices = builder->indices,
        .triangle_materials = builder->materials,
        .material = builder->material,
    };
    void *blocks[] = {arrays.positions, arrays.normals,   arrays.coordinates,
                      arrays.colours,   builder->indices, builder->materials};
    builder->indices = NULL;
    builder->materials = NULL;
    uint32_t geometry, instance;
    clast_status status = clast_scene_adopt_mesh(obj->scene, &mesh, blocks, sizeof blocks / sizeof blocks[0], name,
                                                 &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(obj->scene, geometry, NULL, name, &instance) : status;
}

static void builder_free(mesh_builder *builder)
{
    clast_context *context = builder->obj->context;
    clast_free(context, builder->numbers);
    clast_free(context, builder->vertices);
    clast_table_free(context, &builder->vertex_table);
    clast_free(context, builder->derived);
    clast_table_free(context, &builder->derived_table);
    clast_free(context, builder->indices);
    clast_free(context, builder->materials);
    clast_free(context, builder->face_vertices);
    clast_polygon_free(context, &builder->polygon);
}

static void free_statements(clast_obj *obj)
{
    clast_free(obj->context, obj->corners);
    clast_free(obj->context, obj->alike_corners);
    clast_free(obj->context, obj->faces);
    obj->corners = NULL;
    obj->alike_corners = NULL;
    obj->faces = NULL;
    obj->corner_count = obj->face_count = 0;
}

clast_status clast_obj_add_meshes(clast_obj *obj)
{
    size_t face_count = obj->face_count;
    for (size_t i = 0; i < obj->object_count; i++) {
        mesh_builder builder = {
            .obj = obj,
            .begin = obj->objects[i].first_face,
            .end = i + 1 < obj->object_count ? obj->objects[i + 1].first_face : face_count,
        };
        if (builder.begin == builder.end) {
            continue;
        }
        clast_status status = survey(&builder);
        if (status == CLAST_OK) {
            status = number_by_position(&builder);
        }
        if (status == CLAST_OK) {
            builder.material = scene_material(obj, builder.begin);
            status = add_faces(&builder);
        }
        if (builder.end == face_count) { // the meshes' arrays come in the place of what they were made from
            free_statements(obj);
        }
        if (status == CLAST_OK) {
            status = add_mesh(&builder, obj->objects[i].name);
        }
        builder_free(&builder);
        if (status == CLAST_OK) {
            status = clast_progress(obj->context, "load", i + 1, obj->object_count);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    if (face_count == 0) {
        clast_log(obj->context, CLAST_LOG_WARNING, "%s: the file has no faces", obj->path);
    }
    return CLAST_OK;
}
