// SPDX-License-Identifier: Apache-2.0
// Meshes as sources take them in: posed, welded, and by their materials.
#include "source/mesh.h"

#include "base/size.h"
#include "base/thread.h"
#include "clast/geometry.h"

enum {
    CORNER_GRAIN = 65536,
    ALIKE_MOST = 16, // different movements looked for at one position; what comes after stays apart
};

clast_mesh clast_mesh_posed(const clast_mesh *mesh, const clast_pose *pose)
{
    clast_mesh posed = *mesh;
    posed.positions = pose->positions != NULL ? pose->positions->v : mesh->positions;
    posed.normals = pose->normals != NULL ? pose->normals->v : mesh->normals;
    posed.tangents = pose->tangents != NULL ? pose->tangents->v : mesh->tangents;
    return posed;
}

uint32_t clast_mesh_arrays(const clast_unit *unit, clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST])
{
    const clast_mesh *mesh = &unit->geometry->of.mesh;
    uint64_t corners = 3 * (uint64_t)mesh->triangle_count, vertices = mesh->vertex_count;
    uint32_t version = unit->geometry_version;
    const clast_source_array all[MESH_ARRAYS] = {
        [MESH_ARRAY_INDICES] = {"indices", mesh->indices, corners * sizeof *mesh->indices, version, 0},
        [MESH_ARRAY_MATERIAL] = {"material", &mesh->material, sizeof mesh->material, version, 0},
        [MESH_ARRAY_MATERIALS] = {"materials", mesh->triangle_materials,
                                  mesh->triangle_count * sizeof *mesh->triangle_materials, version, 0},
        [MESH_ARRAY_POSITIONS] = {"mesh positions", mesh->positions, vertices * 3 * sizeof(float), version, 0},
        [MESH_ARRAY_NORMALS] = {"mesh normals", mesh->normals, vertices * 3 * sizeof(float), version, 0},
        [MESH_ARRAY_TANGENTS] = {"mesh tangents", mesh->tangents, vertices * 4 * sizeof(float), version, 0},
        [MESH_ARRAY_COORDINATES_0] = {"mesh coordinates 0", mesh->coordinates[0], vertices * 2 * sizeof(float), version,
                                      0},
        [MESH_ARRAY_COORDINATES_1] = {"mesh coordinates 1", mesh->coordinates[1], vertices * 2 * sizeof(float), version,
                                      0},
        [MESH_ARRAY_COLOURS] = {"mesh colours", mesh->colours, vertices * 4 * sizeof(float), version, 0},
    };
    for (uint32_t i = 0; i < MESH_ARRAYS; i++) {
        arrays[i] = all[i].data != NULL ? all[i] : (clast_source_array){0};
    }
    return MESH_ARRAYS;
}

// ------------------------------------------------------------------------------------------------------------- weld

static bool same_vectors(const float *vectors, size_t width, uint32_t a, uint32_t b)
{
    return vectors == NULL || memcmp(vectors + width * a, vectors + width * b, width * sizeof *vectors) == 0;
}

// Whether two vertices of one position have one position in every pose.
static bool move_alike(const clast_deformation *deformation, uint32_t a, uint32_t b)
{
    uint32_t influences = deformation->influences;
    for (uint32_t i = 0; i < deformation->target_count; i++) {
        if (!same_vectors(deformation->targets[i].positions, 3, a, b)) {
            return false;
        }
    }
    return influences == 0 ||
           (same_vectors(deformation->joint_weights, influences, a, b) &&
            memcmp(deformation->joints + (size_t)influences * a, deformation->joints + (size_t)influences * b,
                   influences * sizeof *deformation->joints) == 0);
}

// The lowest vertex at the position of `first` that moves as `vertex` does, or itself. `next` chains those that differ.
static uint32_t find_alike(const clast_deformation *deformation, uint32_t first, uint32_t vertex, uint32_t *next)
{
    uint32_t at = first;
    for (int tried = 0; tried < ALIKE_MOST; tried++) {
        if (move_alike(deformation, at, vertex)) {
            return at;
        }
        if (next[at] == CLAST_NONE) {
            next[at] = vertex;
            return vertex;
        }
        at = next[at];
    }
    return vertex;
}

clast_status clast_mesh_weld_positions(clast_context *context, const clast_geometry *geometry, uint32_t *remap,
                                       size_t *unique_count)
{
    const clast_mesh *mesh = &geometry->of.mesh;
    clast_status status = clast_weld_positions(context, mesh->positions, mesh->vertex_count, remap, unique_count);
    if (status != CLAST_OK || !clast_deforms(&geometry->deformation) || *unique_count == mesh->vertex_count) {
        return status;
    }
    uint32_t *next = clast_allocate(context, mesh->vertex_count, sizeof *next);
    if (next == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(next, 0xff, mesh->vertex_count * sizeof *next);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        if (remap[i] != i) {
            remap[i] = find_alike(&geometry->deformation, remap[i], i, next);
            *unique_count += remap[i] == i;
        }
    }
    clast_free(context, next);
    return CLAST_OK;
}

typedef struct weld_job {
    const uint32_t *indices;
    const uint32_t *remap;
    uint32_t *welded;
} weld_job;

static void weld_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    weld_job *job = data;
    for (size_t i = begin; i < end; i++) {
        job->welded[i] = job->remap[job->indices[i]];
    }
}

clast_status clast_mesh_weld(clast_context *context, const clast_mesh *mesh, const uint32_t *remap, size_t unique_count,
                             uint32_t **welded)
{
    *welded = NULL;
    if (unique_count == mesh->vertex_count) {
        return CLAST_OK;
    }
    size_t corners = (size_t)mesh->triangle_count * 3;
    *welded = clast_allocate(context, corners, sizeof **welded);
    if (*welded == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    weld_job job = {mesh->indices, remap, *welded};
    clast_parallel_for(context, corners, CORNER_GRAIN, weld_range, &job);
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------- materials

// The different materials, in order of first use: an open hash table of numbers into the list.
typedef struct material_table {
    uint32_t *slots; // place in the list plus one; 0 is free
    size_t slot_count;
    uint32_t *list;
    size_t count, capacity;
} material_table;

static uint32_t *material_slot(material_table *table, uint32_t material)
{
    size_t slot = material * 2654435761u % table->slot_count;
    while (table->slots[slot] != 0 && table->list[table->slots[slot] - 1] != material) {
        slot = (slot + 1) % table->slot_count;
    }
    return &table->slots[slot];
}

static clast_status grow_materials(clast_context *context, material_table *table)
{
    size_t count = table->slot_count != 0 ? table->slot_count * 2 : 64;
    uint32_t *slots = clast_allocate_zeroed(context, count, sizeof *slots);
    if (slots == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_free(context, table->slots);
    table->slots = slots;
    table->slot_count = count;
    for (size_t i = 0; i < table->count; i++) {
        *material_slot(table, table->list[i]) = (uint32_t)i + 1;
    }
    return CLAST_OK;
}

static clast_status add_material(clast_context *context, material_table *table, uint32_t material)
{
    if (2 * table->count >= table->slot_count) {
        clast_status status = grow_materials(context, table);
        if (status != CLAST_OK) {
            return status;
        }
    }
    uint32_t *slot = material_slot(table, material);
    if (*slot != 0) {
        return CLAST_OK;
    }
    clast_status status = CLAST_RESERVE(context, table->list, table->capacity, table->count + 1);
    if (status == CLAST_OK) {
        table->list[table->count++] = material;
        *slot = (uint32_t)table->count;
    }
    return status;
}

clast_status clast_mesh_list_materials(clast_context *context, const clast_mesh *mesh, uint32_t **materials,
                                       uint32_t *count)
{
    material_table table = {0};
    clast_status status = CLAST_OK;
    size_t looked_at = mesh->triangle_materials != NULL || mesh->triangle_count == 0 ? mesh->triangle_count : 1;
    uint32_t last = CLAST_NONE; // no triangle's: clast_mesh_material never gives it
    for (size_t i = 0; i < looked_at && status == CLAST_OK; i++) {
        uint32_t material = clast_mesh_material(mesh, i);
        if (material != last) {
            status = add_material(context, &table, material);
            last = material;
        }
    }
    clast_free(context, table.slots);
    *materials = table.list;
    *count = (uint32_t)table.count;
    return status;
}
