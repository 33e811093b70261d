// SPDX-License-Identifier: Apache-2.0
// Meshes: each primitive (section 3.7.2) becomes a geometry of the scene. Arrays that the file holds as clast wants
// them are used where they lie.
#include <stdio.h>
#include <string.h>

#include "base/thread.h"
#include "load/gltf.h"

enum { CHECK_GRAIN = 65536, MODE_TRIANGLES = 4, MODE_STRIP = 5, MODE_FAN = 6 };

#define FLOAT CLAST_GLTF_BIT(CLAST_GLTF_FLOAT)
#define SIGNED (CLAST_GLTF_BIT(CLAST_GLTF_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_SHORT))
#define UNSIGNED (CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_SHORT))

// A mesh in the making; its blocks are the scene's once it has been adopted. Its vertices are a window of the
// accessors' elements: files often share long accessors among many primitives.
typedef struct primitive {
    clast_mesh mesh;
    uint32_t first_vertex;
    uint32_t all_vertices; // elements of each accessor
    void *blocks[10];
    uint32_t block_count;
} primitive;

static void *add_block(clast_gltf *gltf, primitive *made, size_t count, size_t size)
{
    bool fits = clast_gltf_account(gltf, &gltf->lists[CLAST_GLTF_MESHES], count, size);
    void *block = fits ? clast_allocate(gltf->context, count, size) : NULL;
    if (block == NULL && fits) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    if (block == NULL) {
        return NULL;
    }
    made->blocks[made->block_count++] = block;
    return block;
}

// Frees a block that is not needed any more; what is none of the blocks lies in a file.
static void drop_block(clast_gltf *gltf, primitive *made, const void *array)
{
    for (uint32_t i = 0; i < made->block_count; i++) {
        if (made->blocks[i] == array) {
            clast_free(gltf->context, made->blocks[i]);
            made->blocks[i] = made->blocks[--made->block_count];
            return;
        }
    }
}

// An array that may be written to: itself where it is a block, a copy where it lies in a file. Null for null, or on
// failure.
static void *writable(clast_gltf *gltf, primitive *made, const void *array, size_t count, size_t size)
{
    for (uint32_t i = 0; i < made->block_count; i++) {
        if (made->blocks[i] == array) {
            return made->blocks[i];
        }
    }
    void *block = array != NULL ? add_block(gltf, made, count, size) : NULL;
    if (block != NULL) {
        memcpy(block, array, count * size);
    }
    return block;
}

static void free_blocks(clast_gltf *gltf, primitive *made)
{
    for (uint32_t i = 0; i < made->block_count; i++) {
        clast_free(gltf->context, made->blocks[i]);
    }
    made->block_count = 0;
}

// -------------------------------------------------------------------------------------------------------------- checks

typedef struct check_job {
    const float *floats;
    const uint32_t *indices;
    uint32_t most;
    atomic_size_t first_wrong; // the least over all chunks is the same whatever the threads
} check_job;

static void note_wrong(check_job *job, size_t place)
{
    size_t least = atomic_load(&job->first_wrong);
    while (place < least && !atomic_compare_exchange_weak(&job->first_wrong, &least, place)) {
    }
}

static void check_floats(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    check_job *job = data;
    for (size_t i = begin; i < end; i++) {
        if (!is_finite1(job->floats[i])) {
            note_wrong(job, i);
            return;
        }
    }
}

static void check_indices(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    check_job *job = data;
    for (size_t i = begin; i < end; i++) {
        if (job->indices[i] > job->most) {
            note_wrong(job, i);
            return;
        }
    }
}

static bool all_finite(clast_gltf *gltf, const clast_gltf_value *place, clast_gltf_window window, const float *floats,
                       uint32_t width)
{
    check_job job = {.floats = floats};
    atomic_init(&job.first_wrong, SIZE_MAX);
    clast_parallel_for(gltf->context, (size_t)window.count * width, CHECK_GRAIN, check_floats, &job);
    size_t wrong = job.first_wrong;
    return wrong == SIZE_MAX || clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place, "vertex %zu is not finite",
                                                window.first + wrong / width);
}

// ---------------------------------------------------------------------------------------------------------- attributes

// An attribute's accessor, checked; false where the primitive has none, or on failure.
static bool open_attribute(clast_gltf *gltf, const clast_gltf_value *place, clast_gltf_window window,
                           clast_gltf_accessor *accessor)
{
    if (place->json == NULL) {
        return false;
    }
    uint32_t index = clast_gltf_value_index(gltf, place, CLAST_GLTF_ACCESSORS);
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, place, index, accessor)) {
        return false;
    }
    return accessor->count == window.all || clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                                                            "%llu elements: expected one for each of the %u vertices",
                                                            (unsigned long long)accessor->count, window.all);
}

const float *clast_gltf_read_vertices(clast_gltf *gltf, const clast_gltf_value *place, clast_gltf_window window,
                                      uint32_t components, uint32_t rows, void **block)
{
    clast_gltf_accessor accessor;
    *block = NULL;
    if (!open_attribute(gltf, place, window, &accessor) ||
        !clast_gltf_accessor_is(gltf, place, &accessor, components, 1, rows)) {
        return NULL;
    }
    const float *whole = accessor.component == CLAST_GLTF_FLOAT ? clast_gltf_borrow(gltf, &accessor) : NULL;
    const float *floats = whole != NULL ? whole + (size_t)window.first * rows : NULL;
    if (floats == NULL && clast_gltf_ok(gltf)) {
        bool fits = clast_gltf_account(gltf, place, window.count, rows * sizeof(float));
        float *made = fits ? clast_allocate(gltf->context, window.count, rows * sizeof *made) : NULL;
        if (made == NULL) {
            clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
            return NULL;
        }
        clast_gltf_read_floats(&accessor, window.first, window.count, made);
        *block = made;
        floats = made;
    }
    if (clast_gltf_ok(gltf) && all_finite(gltf, place, window, floats, rows)) {
        return floats;
    }
    clast_free(gltf->context, *block);
    *block = NULL;
    return NULL;
}

static clast_gltf_window window_of(const primitive *made)
{
    return (clast_gltf_window){made->first_vertex, made->mesh.vertex_count, made->all_vertices};
}

static const float *read_attribute(clast_gltf *gltf, primitive *made, const clast_gltf_value *place,
                                   uint32_t components, uint32_t rows)
{
    void *block;
    const float *floats = clast_gltf_read_vertices(gltf, place, window_of(made), components, rows, &block);
    if (block != NULL) {
        made->blocks[made->block_count++] = block;
    }
    return floats;
}

// Vertex colours come as RGB or RGBA, and integers are normalised whatever the flag says (section 3.7.2.1).
static const float *read_colours(clast_gltf *gltf, primitive *made, const clast_gltf_value *place)
{
    clast_gltf_accessor accessor;
    if (!open_attribute(gltf, place, window_of(made), &accessor)) {
        return NULL;
    }
    uint32_t rows = accessor.columns == 1 && accessor.rows == 3 ? 3 : 4;
    if (!clast_gltf_accessor_is(gltf, place, &accessor, FLOAT | UNSIGNED, 1, rows)) {
        return NULL;
    }
    if (rows == 4 && accessor.component == CLAST_GLTF_FLOAT) {
        return read_attribute(gltf, made, place, FLOAT, 4);
    }
    accessor.normalised = true;
    size_t count = made->mesh.vertex_count;
    float *colours = add_block(gltf, made, count, 4 * sizeof *colours);
    if (colours == NULL) {
        return NULL;
    }
    clast_gltf_read_floats(&accessor, made->first_vertex, count, colours);
    for (size_t i = rows == 3 ? count : 0; i-- > 0;) { // spread in place, from the end
        memmove(colours + 4 * i, colours + 3 * i, 3 * sizeof *colours);
        colours[4 * i + 3] = 1.0f;
    }
    return all_finite(gltf, place, window_of(made), colours, 4) ? colours : NULL;
}

typedef struct length_job {
    const float *vectors;
    atomic_bool odd;
} length_job;

static void find_odd_lengths(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    length_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const float *v = job->vectors + 3 * i;
        float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if (!(square > 0.999f && square < 1.001f)) {
            atomic_store(&job->odd, true);
            return;
        }
    }
}

// Makes normals unit length where they are not (quantised ones, and files that break the rule); vertices without
// direction get the normal of their triangles.
static void repair_normals(clast_gltf *gltf, primitive *made)
{
    clast_mesh *mesh = &made->mesh;
    length_job job = {.vectors = mesh->normals};
    atomic_init(&job.odd, false);
    clast_parallel_for(gltf->context, mesh->vertex_count, CHECK_GRAIN, find_odd_lengths, &job);
    if (!atomic_load(&job.odd)) {
        return;
    }
    float *normals = clast_mesh_normals(gltf->context, mesh);
    if (normals == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return;
    }
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const float *given = mesh->normals + 3 * i;
        float largest = largest3(vec3(abs1(given[0]), abs1(given[1]), abs1(given[2])));
        if (largest > 0.0f) {
            vec3 unit = normalize3(vec3(given[0], given[1], given[2]) * (1.0f / largest));
            packed3 stored = store3(unit);
            memcpy(normals + 3 * i, stored.v, sizeof stored.v);
        }
    }
    drop_block(gltf, made, mesh->normals);
    made->blocks[made->block_count++] = normals;
    mesh->normals = normals;
}

// ------------------------------------------------------------------------------------------------------------- indices

// The triangles of a strip or fan over `count` vertices, by section 3.7.2.1: all face the same way.
static void expand(uint32_t mode, const uint32_t *list, size_t triangles, uint32_t *indices)
{
    for (size_t i = 0; i < triangles; i++) {
        size_t corners[3] = {i, i + 1 + i % 2, i + 2 - i % 2};
        if (mode == MODE_FAN) {
            corners[0] = 0;
            corners[1] = i + 1;
            corners[2] = i + 2;
        }
        for (size_t k = 0; k < 3; k++) {
            indices[3 * i + k] = list != NULL ? list[corners[k]] : (uint32_t)corners[k];
        }
    }
}

static bool check_list(clast_gltf *gltf, const clast_gltf_value *place, const clast_gltf_accessor *accessor,
                       const uint32_t *list, const clast_mesh *mesh)
{
    // The largest value of the type would restart a primitive (section 3.7.2.1), also where there is such a vertex.
    uint32_t restart = accessor->component_size == 4 ? UINT32_MAX : (1u << 8 * accessor->component_size) - 1;
    check_job job = {.indices = list, .most = mesh->vertex_count - 1 < restart ? mesh->vertex_count - 1 : restart - 1};
    atomic_init(&job.first_wrong, SIZE_MAX);
    clast_parallel_for(gltf->context, accessor->count, CHECK_GRAIN, check_indices, &job);
    size_t wrong = job.first_wrong;
    if (wrong == SIZE_MAX) {
        return true;
    }
    return list[wrong] == restart
               ? clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                                 "index %zu is %u, which restarts a primitive: expected a vertex", wrong, list[wrong])
               : clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place, "vertex %u of %u (index %zu)", list[wrong],
                                 mesh->vertex_count, wrong);
}

// The index list as the file has it, checked; null where the primitive has none, or on failure.
static const uint32_t *read_list(clast_gltf *gltf, primitive *made, const clast_gltf_value *place, size_t *count)
{
    *count = made->mesh.vertex_count;
    if (place->json == NULL) {
        return NULL;
    }
    clast_gltf_accessor accessor;
    uint32_t index = clast_gltf_value_index(gltf, place, CLAST_GLTF_ACCESSORS);
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, place, index, &accessor) ||
        !clast_gltf_accessor_is(gltf, place, &accessor, UNSIGNED | CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_INT), 1, 1)) {
        return NULL;
    }
    const uint32_t *list = clast_gltf_borrow(gltf, &accessor);
    if (list == NULL && clast_gltf_ok(gltf)) {
        uint32_t *block = add_block(gltf, made, accessor.count, sizeof *block);
        if (block == NULL) {
            return NULL;
        }
        clast_gltf_read_integers(&accessor, block);
        list = block;
    }
    *count = accessor.count;
    return clast_gltf_ok(gltf) && check_list(gltf, place, &accessor, list, &made->mesh) ? list : NULL;
}

static void read_triangles(clast_gltf *gltf, primitive *made, const clast_gltf_value *value, uint32_t mode)
{
    clast_gltf_value place = clast_gltf_member(value, "indices");
    size_t count;
    const uint32_t *list = read_list(gltf, made, &place, &count);
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    size_t triangles = mode == MODE_TRIANGLES ? count / 3 : count < 3 ? 0 : count - 2;
    if (triangles > UINT32_MAX / 3) {
        clast_gltf_fail(gltf, CLAST_ERROR_LIMIT, value, "%zu triangles: expected at most %u", triangles,
                        UINT32_MAX / 3);
        return;
    }
    if (mode == MODE_TRIANGLES && count % 3 != 0) {
        clast_gltf_warn(gltf, value, "%zu indices make no whole triangles: the last %zu are left out", count,
                        count % 3);
    }
    made->mesh.triangle_count = (uint32_t)triangles;
    if (mode == MODE_TRIANGLES && list != NULL) {
        made->mesh.indices = list;
        return;
    }
    uint32_t *indices = add_block(gltf, made, triangles, 3 * sizeof *indices);
    if (indices == NULL) {
        return;
    }
    if (mode == MODE_TRIANGLES) {
        for (size_t i = 0; i < 3 * triangles; i++) {
            indices[i] = (uint32_t)i;
        }
    } else {
        expand(mode, list, triangles, indices);
        drop_block(gltf, made, list);
    }
    made->mesh.indices = indices;
}

// Keeps only the range of vertices that the triangles use, where that is much less than there are.
static void narrow(clast_gltf *gltf, primitive *made)
{
    clast_mesh *mesh = &made->mesh;
    size_t count = 3 * (size_t)mesh->triangle_count;
    uint32_t least = UINT32_MAX, most = 0;
    for (size_t i = 0; i < count; i++) {
        least = mesh->indices[i] < least ? mesh->indices[i] : least;
        most = mesh->indices[i] > most ? mesh->indices[i] : most;
    }
    if (count == 0 || most - least >= made->all_vertices / 2) {
        return;
    }
    if (least > 0) {
        uint32_t *indices = writable(gltf, made, mesh->indices, count, sizeof *indices);
        if (indices == NULL) {
            return;
        }
        for (size_t i = 0; i < count; i++) {
            indices[i] -= least;
        }
        mesh->indices = indices;
    }
    made->first_vertex = least;
    mesh->vertex_count = most - least + 1;
}

// ---------------------------------------------------------------------------------------------------------- primitives

static void read_coordinates(clast_gltf *gltf, primitive *made, const clast_gltf_value *attributes,
                             const clast_gltf_material *material)
{
    for (uint32_t slot = 0; slot < 2; slot++) {
        uint32_t set = material != NULL ? material->sets[slot] : slot;
        if (set != CLAST_NONE && clast_gltf_ok(gltf)) {
            char name[24];
            snprintf(name, sizeof name, "TEXCOORD_%u", set);
            clast_gltf_value place = clast_gltf_member(attributes, name);
            made->mesh.coordinates[slot] = read_attribute(gltf, made, &place, FLOAT | SIGNED | UNSIGNED, 2);
        }
    }
}

// Tangents for a normal map of a mesh that brings none, along the coordinates that the map uses.
static void derive_tangents(clast_gltf *gltf, primitive *made, const clast_gltf_material *material)
{
    clast_mesh along = made->mesh;
    along.coordinates[0] = made->mesh.coordinates[material->normal_set];
    if (along.tangents != NULL || along.coordinates[0] == NULL) {
        return;
    }
    float *tangents = clast_mesh_tangents(gltf->context, &along);
    if (tangents == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return;
    }
    made->blocks[made->block_count++] = tangents;
    made->mesh.tangents = tangents;
}

// The triangles, and the window of vertices that they use.
static bool read_topology(clast_gltf *gltf, primitive *made, const clast_gltf_value *value, uint32_t mode,
                          const clast_gltf_value *positions)
{
    clast_gltf_accessor accessor;
    uint32_t index = clast_gltf_value_index(gltf, positions, CLAST_GLTF_ACCESSORS);
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, positions, index, &accessor)) {
        return false;
    }
    made->all_vertices = made->mesh.vertex_count = (uint32_t)accessor.count;
    read_triangles(gltf, made, value, mode);
    if (clast_gltf_ok(gltf)) {
        narrow(gltf, made);
    }
    return clast_gltf_ok(gltf);
}

static void read_arrays(clast_gltf *gltf, primitive *made, const clast_gltf_value *value, uint32_t mode,
                        const clast_gltf_material *material)
{
    clast_gltf_value attributes = clast_gltf_object(gltf, value, "attributes");
    clast_gltf_value positions = clast_gltf_member(&attributes, "POSITION");
    if (!read_topology(gltf, made, value, mode, &positions)) {
        return;
    }
    // The core rules say floats; KHR_mesh_quantization adds the rest.
    made->mesh.positions = read_attribute(gltf, made, &positions, FLOAT | SIGNED | UNSIGNED, 3);
    clast_gltf_value normals = clast_gltf_member(&attributes, "NORMAL");
    if (clast_gltf_ok(gltf)) {
        made->mesh.normals = read_attribute(gltf, made, &normals, FLOAT | SIGNED, 3);
    }
    if (made->mesh.normals != NULL) { // tangents without normals are to be ignored (section 3.7.2.1)
        clast_gltf_value tangents = clast_gltf_member(&attributes, "TANGENT");
        made->mesh.tangents = read_attribute(gltf, made, &tangents, FLOAT | SIGNED, 4);
    }
    read_coordinates(gltf, made, &attributes, material);
    clast_gltf_value colours = clast_gltf_member(&attributes, "COLOR_0");
    if (clast_gltf_ok(gltf)) {
        made->mesh.colours = read_colours(gltf, made, &colours);
    }
    if (clast_gltf_ok(gltf) && made->mesh.normals != NULL) {
        repair_normals(gltf, made);
    }
    if (clast_gltf_ok(gltf) && material != NULL && material->needs_tangents) {
        derive_tangents(gltf, made, material);
    }
}

// False, with its error, where the vertices are compressed by an extension that is lacking here.
static bool check_compression(clast_gltf *gltf, const clast_gltf_value *value)
{
    static const char draco[] = "KHR_draco_mesh_compression";
    clast_gltf_value extensions;
    if (clast_gltf_extension(gltf, value, &extensions, draco).json == NULL) {
        return clast_gltf_ok(gltf);
    }
    clast_gltf_value attributes = clast_gltf_object(gltf, value, "attributes");
    uint32_t position = clast_gltf_index(gltf, &attributes, "POSITION", CLAST_GLTF_ACCESSORS);
    if (position == CLAST_NONE) {
        return clast_gltf_ok(gltf);
    }
    clast_gltf_value accessor = clast_gltf_entry(gltf, CLAST_GLTF_ACCESSORS, position);
    return json_object_get(accessor.json, "bufferView") != NULL || json_object_get(accessor.json, "sparse") != NULL ||
           clast_gltf_fail(gltf, CLAST_ERROR_UNSUPPORTED, value, "needs the extension %s", draco);
}

// Reads a primitive into the scene; *geometry is CLAST_NONE where it draws nothing.
static bool read_primitive(clast_gltf *gltf, const clast_gltf_value *value, const char *name, uint32_t *geometry,
                           clast_gltf_window *window)
{
    *geometry = CLAST_NONE;
    uint32_t mode = (uint32_t)clast_gltf_integer(gltf, value, "mode", 0, MODE_FAN, MODE_TRIANGLES);
    clast_gltf_value attributes = clast_gltf_object(gltf, value, "attributes");
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (attributes.json == NULL) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "no attributes: expected an object");
    }
    if (mode < MODE_TRIANGLES) {
        clast_gltf_warn(gltf, value, "points and lines are left out");
        return true;
    }
    if (json_object_get(attributes.json, "POSITION") == NULL) {
        clast_gltf_warn(gltf, value, "a primitive without positions is left out");
        return true;
    }
    if (!check_compression(gltf, value)) {
        return false;
    }
    primitive made = {.mesh.material = CLAST_NONE};
    uint32_t index = clast_gltf_primitive_material(gltf, value);
    const clast_gltf_material *material = index != CLAST_NONE ? clast_gltf_use_material(gltf, index) : NULL;
    if (material != NULL) {
        made.mesh.material = material->number;
    }
    if (clast_gltf_ok(gltf)) {
        read_arrays(gltf, &made, value, mode, material);
    }
    *window = window_of(&made);
    if (!clast_gltf_ok(gltf) || made.mesh.triangle_count == 0) {
        free_blocks(gltf, &made);
        return clast_gltf_ok(gltf);
    }
    return clast_gltf_check(
        gltf, clast_scene_adopt_mesh(gltf->scene, &made.mesh, made.blocks, made.block_count, name, geometry));
}

// Where a primitive of a mesh is displaced, its primitives become one geometry, so that the surface stays whole between
// them: the first entry has it, the others draw nothing. What moves by itself stays as it is.
static bool join_displaced(clast_gltf *gltf, uint32_t *geometries, size_t count, size_t first)
{
    clast_scene *scene = gltf->scene;
    bool is_displaced = false;
    for (size_t i = first; i < scene->geometry_count; i++) {
        is_displaced = is_displaced || clast_mesh_is_displaced(scene, &scene->geometries[i].of.mesh);
    }
    if (!is_displaced || scene->geometry_count - first < 2) {
        return true;
    }
    for (size_t i = 0, joined = 0; i < count; i++) {
        joined += geometries[i] != CLAST_NONE;
        geometries[i] = joined == 1 ? geometries[i] : CLAST_NONE;
    }
    return clast_gltf_check(gltf, clast_scene_join_meshes(scene, first));
}

static bool read_primitives(clast_gltf *gltf, uint32_t mesh, const clast_gltf_value *value,
                            const clast_gltf_value *primitives, bool moves)
{
    const char *name = clast_gltf_text(gltf, value, "name");
    size_t count = clast_gltf_size(primitives), first = gltf->scene->geometry_count;
    for (size_t i = 0; i < count; i++) {
        clast_gltf_value element = clast_gltf_element_object(gltf, primitives, i);
        size_t at = gltf->geometry_count + i;
        if (!clast_gltf_ok(gltf) || !read_primitive(gltf, &element, name, &gltf->geometries[at], &gltf->windows[at]) ||
            !clast_gltf_check(
                gltf, clast_progress(gltf->context, "load", mesh, clast_gltf_size(&gltf->lists[CLAST_GLTF_MESHES])))) {
            return false;
        }
    }
    return moves || join_displaced(gltf, gltf->geometries + gltf->geometry_count, count, first);
}

// Geometries of a node's own that share the arrays of another's.
static bool share_primitives(clast_gltf *gltf, const clast_gltf_value *value, uint32_t known, uint32_t count)
{
    const char *name = clast_gltf_text(gltf, value, "name");
    for (uint32_t i = 0; i < count; i++) {
        uint32_t geometry = gltf->geometries[known + i], *shared = &gltf->geometries[gltf->geometry_count + i];
        gltf->windows[gltf->geometry_count + i] = gltf->windows[known + i];
        *shared = CLAST_NONE;
        if (geometry != CLAST_NONE &&
            !clast_gltf_check(gltf, clast_scene_share_mesh(gltf->scene, geometry, name, shared))) {
            return false;
        }
    }
    return clast_gltf_ok(gltf);
}

static bool deform_primitives(clast_gltf *gltf, const clast_gltf_value *primitives, const clast_gltf_use *use,
                              uint32_t known, uint32_t first, uint32_t count)
{
    for (uint32_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value element = clast_gltf_element_object(gltf, primitives, i);
        if (gltf->geometries[first + i] != CLAST_NONE) {
            clast_gltf_deform(gltf, &element, gltf->windows[first + i], use,
                              known != CLAST_NONE ? gltf->geometries[known + i] : CLAST_NONE,
                              gltf->geometries[first + i]);
        }
    }
    return clast_gltf_ok(gltf);
}

bool clast_gltf_use_mesh(clast_gltf *gltf, uint32_t mesh, const clast_gltf_use *use, uint32_t *first, uint32_t *count)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_MESHES, mesh);
    clast_gltf_value primitives = clast_gltf_array(gltf, &value, "primitives");
    *count = (uint32_t)clast_gltf_size(&primitives);
    if (clast_gltf_ok(gltf) && *count == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "no primitives: expected at least one");
    }
    uint32_t *entry = use->is_own ? &gltf->own_geometries[mesh] : &gltf->mesh_geometries[mesh], known = *entry;
    if (clast_gltf_ok(gltf) && !use->is_own && known != CLAST_NONE) {
        *first = known;
        return true;
    }
    size_t wanted = gltf->geometry_count + *count;
    clast_gltf_check(gltf, CLAST_RESERVE(gltf->context, gltf->geometries, gltf->geometry_capacity, wanted));
    if (clast_gltf_ok(gltf)) {
        clast_gltf_check(gltf, CLAST_RESERVE(gltf->context, gltf->windows, gltf->window_capacity, wanted));
    }
    bool moves = use->has_weights || use->skin != CLAST_NONE;
    bool is_read = clast_gltf_ok(gltf) &&
                   (known != CLAST_NONE ? share_primitives(gltf, &value, known, *count)
                                        : read_primitives(gltf, mesh, &value, &primitives, moves));
    if (!is_read) {
        return false;
    }
    *first = (uint32_t)gltf->geometry_count;
    gltf->geometry_count += *count;
    *entry = known != CLAST_NONE ? known : *first;
    return deform_primitives(gltf, &primitives, use, known, *first, *count);
}
