// SPDX-License-Identifier: Apache-2.0
// Meshes from the faces of an OBJ file: a vertex for each different corner, in the order in which the corners come. What can be is
// made in the place of what was read: corners become the indices of triangles, and the file's lists those of vertices.
#include <math.h>

#include "load/obj.h"
#include "load/polygon.h"
#include "shared/texture_filter.h"

enum { VERTEX_GRAIN = 16384 };

// Numbers in a file's list, of vertices in their order; null where the vertices have none.
typedef struct vertex_keys {
    uint32_t *positions, *coordinates, *normals;
} vertex_keys;

typedef struct mesh_builder {
    clast_obj *obj;
    clast_obj_object *object;
    bool is_last; // nobody needs the file's lists afterwards
    bool has_normals, has_coordinates;
    uint32_t lowest, highest; // positions used
    uint32_t material;        // of the first face
    // Which vertices there are: either the numbers of those that positions from `lowest` on become, or the keys of each.
    uint32_t *numbers;
    vertex_keys keys;
    size_t vertex_count, vertex_capacity;
    clast_obj_arrays arrays;
} mesh_builder;

clast_status clast_obj_out_of_range(const clast_obj *obj)
{
    return clast_fail(obj->context, CLAST_ERROR_LIMIT,
                      "%s: an object has more vertices or triangles than a mesh may have", obj->path);
}

void clast_obj_free_corners(const clast_obj *obj, clast_obj_object *object)
{
    clast_free(obj->context, object->positions);
    clast_free(obj->context, object->coordinates);
    clast_free(obj->context, object->normals);
    object->positions = object->coordinates = object->normals = NULL;
}

// -------------------------------------------------------------------------------------------------------------- survey

typedef struct survey_job {
    const clast_obj *obj;
    const clast_obj_object *object;
    uint32_t material;
    atomic_bool has_normals, lacks_normals, has_coordinates, has_materials;
    atomic_uint lowest, highest;
} survey_job;

static void survey_span(survey_job *job, const clast_obj_span *span)
{
    const clast_obj *obj = job->obj;
    bool has_normals = false, lacks_normals = false, has_coordinates = false;
    uint32_t lowest = UINT32_MAX, highest = 0;
    for (size_t i = span->first_corner; i < span->first_corner + span->corner_count; i++) {
        clast_obj_corner corner = clast_obj_corner_at(job->object, i);
        bool has_own_normal = clast_obj_has_normal(obj, corner);
        has_normals = has_normals || has_own_normal;
        lacks_normals = lacks_normals || !has_own_normal;
        has_coordinates = has_coordinates || corner.coordinate != CLAST_NONE;
        lowest = corner.position < lowest ? corner.position : lowest;
        highest = corner.position > highest ? corner.position : highest;
    }
    const clast_obj_piece *piece = &obj->pieces[span->piece];
    const clast_obj_run *end = piece->runs + piece->run_count;
    for (const clast_obj_run *run = clast_obj_first_face(obj, span).run;
         run < end && (run->first_face < span->first_face || run->first_face - span->first_face < span->face_count);
         run++) {
        has_normals = has_normals || run->smoothing != 0;
        if (clast_obj_material(obj, run) != job->material) {
            atomic_store(&job->has_materials, true);
        }
    }
    if (has_normals) {
        atomic_store(&job->has_normals, true);
    }
    if (lacks_normals) {
        atomic_store(&job->lacks_normals, true);
    }
    if (has_coordinates) {
        atomic_store(&job->has_coordinates, true);
    }
    unsigned known = atomic_load(&job->lowest);
    while (lowest < known && !atomic_compare_exchange_weak(&job->lowest, &known, lowest)) {
    }
    known = atomic_load(&job->highest);
    while (highest > known && !atomic_compare_exchange_weak(&job->highest, &known, highest)) {
    }
}

static void survey_spans(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    survey_job *job = data;
    for (size_t i = begin; i < end; i++) {
        survey_span(job, &job->obj->spans[job->object->first_span + i]);
    }
}

// --------------------------------------------------------------------------------------------------- numbers of vertices

// Where corners are alike a position is one vertex: its number is looked up, not searched.
static clast_status number_by_position(mesh_builder *builder)
{
    clast_obj_object *object = builder->object;
    size_t range = (size_t)builder->highest - builder->lowest + 1;
    builder->numbers = clast_allocate(builder->obj->context, range, sizeof *builder->numbers);
    if (builder->numbers == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(builder->numbers, 0xff, range * sizeof *builder->numbers); // CLAST_NONE
    uint32_t count = 0;
    for (size_t i = 0; i < object->corner_count; i++) {
        uint32_t *number = &builder->numbers[object->positions[i] - builder->lowest];
        *number = *number == CLAST_NONE ? count++ : *number;
        object->positions[i] = *number;
    }
    builder->vertex_count = count;
    return CLAST_OK;
}

static clast_status grow_keys(mesh_builder *builder)
{
    clast_context *context = builder->obj->context;
    vertex_keys *keys = &builder->keys;
    size_t capacity = builder->vertex_capacity, wanted = builder->vertex_count + 1;
    clast_status status = CLAST_RESERVE(context, keys->positions, capacity, wanted);
    if (status == CLAST_OK && builder->has_coordinates) {
        size_t known = builder->vertex_capacity;
        status = CLAST_RESERVE(context, keys->coordinates, known, wanted);
    }
    if (status == CLAST_OK && builder->has_normals) {
        size_t known = builder->vertex_capacity;
        status = CLAST_RESERVE(context, keys->normals, known, wanted);
    }
    builder->vertex_capacity = status == CLAST_OK ? capacity : builder->vertex_capacity;
    return status;
}

static bool has_key(const mesh_builder *builder, uint32_t number, clast_obj_corner key)
{
    const vertex_keys *keys = &builder->keys;
    return keys->positions[number] == key.position &&
           (!builder->has_coordinates || keys->coordinates[number] == key.coordinate) &&
           (!builder->has_normals || keys->normals[number] == key.normal);
}

static clast_status find_vertex(mesh_builder *builder, clast_table *table, clast_obj_corner key, uint32_t *number)
{
    clast_status status = clast_table_reserve(builder->obj->context, table);
    if (status != CLAST_OK) {
        return status;
    }
    uint64_t pair = (uint64_t)key.coordinate << 32 | key.normal;
    uint32_t hash = (uint32_t)(clast_hash_word(clast_hash_word(0, key.position), pair) >> 16);
    size_t place = hash;
    while ((*number = clast_table_next(table, hash, &place)) != CLAST_NONE) {
        if (has_key(builder, *number, key)) {
            return CLAST_OK;
        }
    }
    if (builder->vertex_count + 1 >= CLAST_NONE) {
        return clast_obj_out_of_range(builder->obj);
    }
    if (builder->vertex_count == builder->vertex_capacity && (status = grow_keys(builder)) != CLAST_OK) {
        return status;
    }
    *number = (uint32_t)builder->vertex_count++;
    builder->keys.positions[*number] = key.position;
    if (builder->has_coordinates) {
        builder->keys.coordinates[*number] = key.coordinate;
    }
    if (builder->has_normals) {
        builder->keys.normals[*number] = key.normal;
    }
    clast_table_insert(table, hash, place, *number);
    return CLAST_OK;
}

static clast_status number_by_search(mesh_builder *builder)
{
    clast_obj_object *object = builder->object;
    clast_table table = {0};
    clast_status status = CLAST_OK;
    for (size_t i = 0; status == CLAST_OK && i < object->corner_count; i++) {
        clast_obj_corner key = clast_obj_corner_at(object, i);
        if (!builder->has_normals) {
            key.normal = CLAST_NONE;
        }
        status = find_vertex(builder, &table, key, &object->positions[i]);
    }
    clast_table_free(builder->obj->context, &table);
    return status;
}

static clast_status number_vertices(mesh_builder *builder)
{
    clast_obj_object *object = builder->object;
    uint64_t range = (uint64_t)builder->highest - builder->lowest + 1;
    bool alike = (object->form & CLAST_OBJ_UNLIKE) == 0 && range <= object->corner_count;
    clast_status status = alike ? number_by_position(builder) : number_by_search(builder);
    clast_free(builder->obj->context, object->coordinates);
    clast_free(builder->obj->context, object->normals);
    object->coordinates = object->normals = NULL;
    return status;
}

// ------------------------------------------------------------------------------------------------------------- vertices

// The floats of vertices, from a list of the file's.
typedef struct copy_job {
    const mesh_builder *builder;
    const uint32_t *keys; // where there are no numbers
    const float *from;
    float *to;
    int width;
} copy_job;

static void copy_floats(float *to, const float *from, int width)
{
    to[0] = from[0];
    to[1] = from[1];
    if (width == 3) {
        to[2] = from[2];
    }
}

static void copy_numbered(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const copy_job *job = data;
    for (size_t i = begin; i < end; i++) {
        uint32_t number = job->builder->numbers[i];
        if (number != CLAST_NONE) {
            size_t from = job->builder->lowest + i;
            copy_floats(job->to + (size_t)job->width * number, job->from + (size_t)job->width * from, job->width);
        }
    }
}

static void copy_keyed(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    static const float none[3] = {0.0f, 0.0f, 0.0f};
    const copy_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const float *from = job->keys[i] != CLAST_NONE ? job->from + (size_t)job->width * job->keys[i] : none;
        copy_floats(job->to + (size_t)job->width * i, from, job->width);
    }
}

// Puts the floats of a list into the order of the vertices, where each is that of one: along the cycles of the permutation.
// `done` has a bit for each.
static void permute(const uint32_t *numbers, size_t count, uint64_t *done, float *list, int width)
{
    for (size_t first = 0; first < count; first++) {
        if ((done[first / 64] >> first % 64 & 1) != 0 || numbers[first] == first) {
            continue;
        }
        float held[3] = {0.0f}, next[3] = {0.0f};
        copy_floats(held, list + (size_t)width * first, width);
        size_t at = first;
        do {
            at = numbers[at];
            copy_floats(next, list + (size_t)width * at, width);
            copy_floats(list + (size_t)width * at, held, width);
            copy_floats(held, next, width);
            done[at / 64] |= (uint64_t)1 << at % 64;
        } while (at != first);
    }
}

// Makes an array of the vertices from a list of `count` of the file's, in its place where nobody else needs it.
static clast_status take_list(mesh_builder *builder, float **list, size_t count, int width, uint32_t **keys, float **to)
{
    clast_context *context = builder->obj->context;
    size_t vertices = builder->vertex_count;
    if (builder->is_last && builder->numbers != NULL && vertices == count) {
        uint64_t *done = clast_allocate_zeroed(context, count / 64 + 1, sizeof *done);
        if (done == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
        permute(builder->numbers, count, done, *list, width);
        clast_free(context, done);
        *to = *list;
        *list = NULL;
        return CLAST_OK;
    }
    *to = clast_allocate(context, vertices, (size_t)width * sizeof **to);
    if (*to == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    copy_job job = {builder, *keys, *list, *to, width};
    if (builder->numbers != NULL) {
        size_t range = (size_t)builder->highest - builder->lowest + 1;
        clast_parallel_for(context, range, VERTEX_GRAIN, copy_numbered, &job);
    } else {
        clast_parallel_for(context, vertices, VERTEX_GRAIN, copy_keyed, &job);
        clast_free(context, *keys);
        *keys = NULL;
    }
    if (builder->is_last) {
        clast_free(context, *list);
        *list = NULL;
    }
    return CLAST_OK;
}

void clast_obj_fill_colour(const clast_obj *obj, uint32_t position, float colour[4])
{
    for (int c = 0; c < 3; c++) { // vertex colours are those of a display
        colour[c] = srgb_to_linear(obj->colours[position][c]);
    }
    colour[3] = 1.0f;
}

static void copy_colours(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const mesh_builder *builder = data;
    for (size_t i = begin; i < end; i++) {
        bool is_numbered = builder->numbers != NULL;
        uint32_t vertex = is_numbered ? builder->numbers[i] : (uint32_t)i;
        uint32_t position = is_numbered ? builder->lowest + (uint32_t)i : builder->keys.positions[i];
        if (vertex != CLAST_NONE) {
            clast_obj_fill_colour(builder->obj, position, builder->arrays.colours[vertex]);
        }
    }
}

static clast_status take_colours(mesh_builder *builder)
{
    clast_obj *obj = builder->obj;
    size_t vertices = builder->vertex_count;
    size_t count = builder->numbers != NULL ? (size_t)builder->highest - builder->lowest + 1 : vertices;
    builder->arrays.colours = clast_allocate(obj->context, vertices, sizeof *builder->arrays.colours);
    if (builder->arrays.colours == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(obj->context, count, VERTEX_GRAIN, copy_colours, builder);
    if (builder->is_last) {
        clast_free(obj->context, obj->colours);
        obj->colours = NULL;
    }
    return CLAST_OK;
}

static clast_status make_vertices(mesh_builder *builder)
{
    clast_obj *obj = builder->obj;
    clast_status status = CLAST_OK;
    if (builder->is_last && !builder->has_normals) {
        clast_free(obj->context, obj->normals);
        obj->normals = NULL;
    }
    if (builder->is_last && !builder->has_coordinates) {
        clast_free(obj->context, obj->coordinates);
        obj->coordinates = NULL;
    }
    if (builder->has_coordinates) {
        status = take_list(builder, (float **)&obj->coordinates, obj->coordinate_count, 2, &builder->keys.coordinates,
                           (float **)&builder->arrays.coordinates);
    }
    if (status == CLAST_OK && builder->has_normals) {
        status = take_list(builder, (float **)&obj->normals, obj->normal_count, 3, &builder->keys.normals,
                           (float **)&builder->arrays.normals);
    }
    if (status == CLAST_OK && obj->colours != NULL) {
        status = take_colours(builder);
    }
    if (status == CLAST_OK) {
        status = take_list(builder, (float **)&obj->positions, obj->position_count, 3, &builder->keys.positions,
                           (float **)&builder->arrays.positions);
    }
    clast_free(obj->context, builder->numbers);
    builder->numbers = NULL;
    builder->arrays.vertex_count = builder->vertex_count;
    return status;
}

// ------------------------------------------------------------------------------------------------------------ triangles

typedef struct triangle_job {
    const mesh_builder *builder;
    clast_polygon *polygons; // of each worker
    uint32_t *indices, *materials;
    atomic_bool memory_ran_out;
} triangle_job;

static bool cut_face(const triangle_job *job, clast_polygon *polygon, const uint32_t *vertices, uint32_t length,
                     uint32_t *indices)
{
    if (length == 3) {
        memcpy(indices, vertices, 3 * sizeof *indices);
        return true;
    }
    if (clast_polygon_reserve(job->builder->obj->context, polygon, length) != CLAST_OK) {
        return false;
    }
    for (uint32_t i = 0; i < length; i++) {
        memcpy(polygon->points[i], job->builder->arrays.positions[vertices[i]], sizeof *polygon->points);
    }
    clast_polygon_cut(polygon, length);
    for (size_t i = 0; i < 3 * ((size_t)length - 2); i++) {
        indices[i] = vertices[polygon->corners[i]];
    }
    return true;
}

static void cut_spans(void *data, size_t begin, size_t end, uint32_t worker)
{
    triangle_job *job = data;
    const clast_obj *obj = job->builder->obj;
    const clast_obj_object *object = job->builder->object;
    for (size_t i = begin; i < end; i++) {
        const clast_obj_span *span = &obj->spans[object->first_span + i];
        uint32_t *to = job->indices + 3 * span->first_triangle;
        clast_obj_cursor face = clast_obj_first_face(obj, span);
        for (; clast_obj_has_face(&face); clast_obj_next_face(&face)) {
            if (!cut_face(job, &job->polygons[worker], object->positions + face.corner, face.length, to)) {
                atomic_store(&job->memory_ran_out, true);
                return;
            }
            to += 3 * ((size_t)face.length - 2);
        }
    }
}

// Where all faces are triangles, their corners are the indices.
static clast_status make_triangles(mesh_builder *builder)
{
    clast_obj_object *object = builder->object;
    clast_context *context = builder->obj->context;
    if (object->corner_count == 3 * object->face_count) {
        builder->arrays.indices = object->positions;
        object->positions = NULL;
        return CLAST_OK;
    }
    uint32_t workers = clast_worker_count(context);
    triangle_job job = {.builder = builder};
    job.indices = builder->arrays.indices = clast_allocate(context, (size_t)object->triangle_count,
                                                           3 * sizeof *job.indices);
    job.polygons = clast_allocate_zeroed(context, workers, sizeof *job.polygons);
    if (job.indices != NULL && job.polygons != NULL) {
        clast_parallel_for(context, object->span_count, 1, cut_spans, &job);
    }
    bool whole = job.indices != NULL && job.polygons != NULL && !atomic_load(&job.memory_ran_out);
    for (uint32_t i = 0; job.polygons != NULL && i < workers; i++) {
        clast_polygon_free(context, &job.polygons[i]);
    }
    clast_free(context, job.polygons);
    clast_obj_free_corners(builder->obj, object);
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static void note_materials(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    triangle_job *job = data;
    const clast_obj *obj = job->builder->obj;
    for (size_t i = begin; i < end; i++) {
        const clast_obj_span *span = &obj->spans[job->builder->object->first_span + i];
        uint32_t *to = job->materials + span->first_triangle;
        clast_obj_cursor face = clast_obj_first_face(obj, span);
        for (; clast_obj_has_face(&face); clast_obj_next_face(&face)) {
            for (uint32_t k = 0; k < face.length - 2; k++) {
                *to++ = clast_obj_material(obj, face.run);
            }
        }
    }
}

static clast_status make_materials(mesh_builder *builder)
{
    clast_context *context = builder->obj->context;
    triangle_job job = {.builder = builder};
    job.materials = builder->arrays.materials = clast_allocate(context, (size_t)builder->object->triangle_count,
                                                               sizeof *job.materials);
    if (job.materials == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(context, builder->object->span_count, 1, note_materials, &job);
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------------- meshes

static clast_status make_arrays(mesh_builder *builder)
{
    clast_obj *obj = builder->obj;
    clast_obj_object *object = builder->object;
    if (object->triangle_count > UINT32_MAX / 3) {
        return clast_obj_out_of_range(obj);
    }
    survey_job job = {.obj = obj, .object = object};
    job.material = builder->material = clast_obj_material(
        obj, clast_obj_first_face(obj, &obj->spans[object->first_span]).run);
    atomic_init(&job.lowest, UINT32_MAX);
    clast_parallel_for(obj->context, object->span_count, 1, survey_spans, &job);
    builder->has_normals = atomic_load(&job.has_normals);
    builder->has_coordinates = atomic_load(&job.has_coordinates);
    builder->lowest = atomic_load(&job.lowest);
    builder->highest = atomic_load(&job.highest);
    clast_status status;
    if (builder->has_normals && atomic_load(&job.lacks_normals)) {
        status = clast_obj_smooth_mesh(obj, object, builder->has_coordinates, &builder->arrays);
    } else {
        status = number_vertices(builder);
        status = status == CLAST_OK ? make_vertices(builder) : status;
        status = status == CLAST_OK ? make_triangles(builder) : status;
    }
    return status == CLAST_OK && atomic_load(&job.has_materials) ? make_materials(builder) : status;
}

static void free_builder(mesh_builder *builder)
{
    clast_context *context = builder->obj->context;
    clast_free(context, builder->numbers);
    clast_free(context, builder->keys.positions);
    clast_free(context, builder->keys.coordinates);
    clast_free(context, builder->keys.normals);
    clast_free(context, builder->arrays.positions);
    clast_free(context, builder->arrays.normals);
    clast_free(context, builder->arrays.coordinates);
    clast_free(context, builder->arrays.colours);
    clast_free(context, builder->arrays.indices);
    clast_free(context, builder->arrays.materials);
}

static clast_status add_mesh(mesh_builder *builder)
{
    clast_obj *obj = builder->obj;
    const clast_obj_arrays *arrays = &builder->arrays;
    clast_mesh mesh = {
        .vertex_count = (uint32_t)arrays->vertex_count,
        .triangle_count = (uint32_t)builder->object->triangle_count,
        .positions = (const float *)arrays->positions,
        .normals = (const float *)arrays->normals,
        .coordinates = {(const float *)arrays->coordinates, NULL},
        .colours = (const float *)arrays->colours,
        .indices = arrays->indices,
        .triangle_materials = arrays->materials,
        .material = builder->material,
    };
    void *blocks[] = {arrays->positions, arrays->normals, arrays->coordinates,
                      arrays->colours,   arrays->indices, arrays->materials};
    builder->arrays = (clast_obj_arrays){0}; // they are the scene's
    uint32_t geometry, instance;
    const char *name = builder->object->name;
    clast_status status = clast_scene_adopt_mesh(obj->scene, &mesh, blocks, sizeof blocks / sizeof blocks[0], name,
                                                 &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(obj->scene, geometry, NULL, name, &instance) : status;
}

clast_status clast_obj_add_meshes(clast_obj *obj)
{
    for (size_t i = 0; i < obj->object_count; i++) {
        mesh_builder builder = {.obj = obj, .object = &obj->objects[i], .is_last = i + 1 == obj->object_count};
        clast_status status = make_arrays(&builder);
        if (status == CLAST_OK) {
            status = add_mesh(&builder);
        }
        free_builder(&builder);
        if (status == CLAST_OK) {
            status = clast_progress(obj->context, "load", i + 1, obj->object_count);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    if (obj->object_count == 0) {
        clast_log(obj->context, CLAST_LOG_WARNING, "%s: the file has no faces", obj->path);
    }
    return CLAST_OK;
}
