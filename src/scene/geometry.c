// SPDX-License-Identifier: Apache-2.0
// Geometries of a scene: checks, copies, and vertex normals and tangents where a file brings none.
#include <math.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "scene/scene.h"

enum { CHECK_GRAIN = 65536 };

// -------------------------------------------------------------------------------------------------------------- checks

// The first element that is wrong, over all chunks: the least is the same whatever the threads.
typedef struct check_job {
    const clast_mesh *mesh;
    size_t material_count;
    atomic_size_t first_wrong;
} check_job;

static void note_wrong(check_job *job, size_t place)
{
    size_t least = atomic_load(&job->first_wrong);
    while (place < least && !atomic_compare_exchange_weak(&job->first_wrong, &least, place)) {
    }
}

static void check_positions(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    check_job *job = data;
    const float *p = job->mesh->positions;
    for (size_t i = begin; i < end; i++) {
        if (!is_finite1(p[3 * i]) || !is_finite1(p[3 * i + 1]) || !is_finite1(p[3 * i + 2])) {
            note_wrong(job, i);
            return;
        }
    }
}

static void check_triangles(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    check_job *job = data;
    const clast_mesh *mesh = job->mesh;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *corner = mesh->indices + 3 * i;
        bool sound = corner[0] < mesh->vertex_count && corner[1] < mesh->vertex_count && corner[2] < mesh->vertex_count;
        if (!sound || (mesh->triangle_materials != NULL && mesh->triangle_materials[i] >= job->material_count)) {
            note_wrong(job, i);
            return;
        }
    }
}

static clast_status check_mesh(const clast_scene *scene, const clast_mesh *mesh, const char *name)
{
    clast_context *context = scene->context;
    name = name != NULL ? name : "mesh";
    if ((mesh->vertex_count != 0 && mesh->positions == NULL) || (mesh->triangle_count != 0 && mesh->indices == NULL)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s: positions and indices are needed", name);
    }
    if (mesh->vertex_count == CLAST_NONE || mesh->triangle_count > UINT32_MAX / 3) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%s: %u triangles: expected at most %u in a mesh", name,
                          mesh->triangle_count, UINT32_MAX / 3);
    }
    if (mesh->material != CLAST_NONE && mesh->material >= scene->material_count) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s: material %u: the scene has %zu", name,
                          mesh->material, scene->material_count);
    }
    check_job job = {.mesh = mesh, .material_count = scene->material_count};
    atomic_init(&job.first_wrong, SIZE_MAX);
    clast_parallel_for(context, mesh->vertex_count, CHECK_GRAIN, check_positions, &job);
    if (job.first_wrong != SIZE_MAX) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "%s: the position of vertex %zu is not finite", name,
                          (size_t)job.first_wrong);
    }
    clast_parallel_for(context, mesh->triangle_count, CHECK_GRAIN, check_triangles, &job);
    if (job.first_wrong != SIZE_MAX) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s: triangle %zu has a vertex or material that is not there (of %u vertices, %zu materials)",
                          name, (size_t)job.first_wrong, mesh->vertex_count, scene->material_count);
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- adding

// Adds a geometry whose blocks the scene takes over; frees them on failure.
static clast_status add_geometry(clast_scene *scene, clast_geometry *added, const char *name, uint32_t *number)
{
    clast_context *context = scene->context;
    clast_status status = CLAST_RESERVE(context, scene->geometries, scene->geometry_capacity,
                                        scene->geometry_count + 1);
    if (status == CLAST_OK && name != NULL && name[0] != '\0') {
        added->name = clast_copy_text(context, name);
        status = added->name != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status != CLAST_OK) {
        for (uint32_t i = 0; i < added->block_count; i++) {
            clast_free(context, added->blocks[i]);
        }
        return status;
    }
    added->version = 1;
    *number = (uint32_t)scene->geometry_count;
    scene->geometries[scene->geometry_count++] = *added;
    return CLAST_OK;
}

clast_status clast_scene_adopt_mesh(clast_scene *scene, const clast_mesh *mesh, void *const *blocks,
                                    uint32_t block_count, const char *name, uint32_t *number)
{
    clast_geometry added = {.kind = CLAST_SOURCE_CLUSTERS, .of.mesh = *mesh, .block_count = block_count};
    clast_status status = block_count <= CLAST_GEOMETRY_BLOCKS ? check_mesh(scene, mesh, name)
                                                               : clast_fail(scene->context, CLAST_ERROR_LIMIT,
                                                                            "a mesh of %u blocks: expected at most %d",
                                                                            block_count, CLAST_GEOMETRY_BLOCKS);
    if (status != CLAST_OK) {
        for (uint32_t i = 0; i < block_count; i++) {
            clast_free(scene->context, blocks[i]);
        }
        return status;
    }
    memcpy(added.blocks, blocks, block_count * sizeof *blocks);
    if (added.of.mesh.material == CLAST_NONE) {
        added.of.mesh.material = 0;
    }
    return add_geometry(scene, &added, name, number);
}

// A copy of an array in a new block of the geometry; null stays null. False where memory ran out.
static bool copy_array(clast_context *context, clast_geometry *geometry, const void *array, size_t count, size_t size,
                       const void **copy)
{
    *copy = NULL;
    if (array == NULL) {
        return true;
    }
    void *block = clast_allocate(context, count, size);
    if (block == NULL) {
        return false;
    }
    memcpy(block, array, count * size);
    geometry->blocks[geometry->block_count++] = block;
    *copy = block;
    return true;
}

clast_status clast_scene_add_mesh(clast_scene *scene, const clast_mesh *mesh, const char *name, uint32_t *number)
{
    if (scene == NULL || mesh == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check_mesh(scene, mesh, name);
    if (status != CLAST_OK) {
        return status;
    }
    clast_context *context = scene->context;
    clast_geometry added = {.kind = CLAST_SOURCE_CLUSTERS, .of.mesh = *mesh};
    clast_mesh *copy = &added.of.mesh;
    size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    bool whole = copy_array(context, &added, mesh->positions, vertices, 12, (const void **)&copy->positions) &&
                 copy_array(context, &added, mesh->normals, vertices, 12, (const void **)&copy->normals) &&
                 copy_array(context, &added, mesh->tangents, vertices, 16, (const void **)&copy->tangents) &&
                 copy_array(context, &added, mesh->coordinates[0], vertices, 8, (const void **)&copy->coordinates[0]) &&
                 copy_array(context, &added, mesh->coordinates[1], vertices, 8, (const void **)&copy->coordinates[1]) &&
                 copy_array(context, &added, mesh->colours, vertices, 16, (const void **)&copy->colours) &&
                 copy_array(context, &added, mesh->indices, triangles, 12, (const void **)&copy->indices) &&
                 copy_array(context, &added, mesh->triangle_materials, triangles, 4,
                            (const void **)&copy->triangle_materials);
    if (!whole) {
        for (uint32_t i = 0; i < added.block_count; i++) {
            clast_free(context, added.blocks[i]);
        }
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    copy->material = mesh->material != CLAST_NONE ? mesh->material : 0;
    return add_geometry(scene, &added, name, number);
}

clast_status clast_scene_add_wave(clast_scene *scene, const clast_wave *wave, const char *name, uint32_t *number)
{
    if (scene == NULL || wave == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    bool sound = wave->size > 0.0f && is_finite1(wave->size) && wave->tiles >= 1 && wave->tiles <= 1024 &&
                 is_finite1(wave->amplitude) && wave->wavelength > 0.0f && is_finite1(wave->wavelength) &&
                 is_finite1(wave->speed);
    if (!sound || (wave->material != CLAST_NONE && wave->material >= scene->material_count)) {
        return clast_fail(
            scene->context, CLAST_ERROR_INVALID_ARGUMENT,
            "wave: expected a size and wavelength above 0, 1 to 1024 tiles, finite values and a material of the scene");
    }
    clast_geometry added = {.kind = CLAST_SOURCE_WAVE, .of.wave = *wave};
    if (wave->material == CLAST_NONE) {
        added.of.wave.material = 0;
    }
    return add_geometry(scene, &added, name, number);
}

clast_status clast_scene_set_mesh_positions(clast_scene *scene, uint32_t number, const float *positions,
                                            const float *normals)
{
    if (scene == NULL || positions == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    if (number >= scene->geometry_count || !clast_geometry_is_mesh(&scene->geometries[number])) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "geometry %u is no mesh of the scene", number);
    }
    clast_geometry *geometry = &scene->geometries[number];
    clast_mesh changed = geometry->of.mesh;
    changed.positions = positions;
    clast_status status = check_mesh(scene, &changed, geometry->name);
    if (status != CLAST_OK) {
        return status;
    }
    // One block for both replaces whatever the mesh had; the old ones go when they are the scene's own.
    size_t count = (size_t)changed.vertex_count * 3;
    float *block = clast_allocate(context, count * (normals != NULL ? 2 : 1), sizeof *block);
    if (block == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memcpy(block, positions, count * sizeof *block);
    if (normals != NULL) {
        memcpy(block + count, normals, count * sizeof *block);
    }
    const void *old[] = {geometry->of.mesh.positions, geometry->of.mesh.normals};
    uint32_t kept = 0;
    for (uint32_t i = 0; i < geometry->block_count; i++) {
        if (geometry->blocks[i] == old[0] || geometry->blocks[i] == old[1]) {
            clast_free(context, geometry->blocks[i]);
        } else {
            geometry->blocks[kept++] = geometry->blocks[i];
        }
    }
    geometry->blocks[kept++] = block; // there is room for it: CLAST_GEOMETRY_BLOCKS
    geometry->block_count = kept;
    geometry->of.mesh.positions = block;
    geometry->of.mesh.normals = normals != NULL ? block + count : NULL;
    geometry->version++;
    scene->position_version++;
    return CLAST_OK;
}

clast_status clast_scene_set_tessellation(clast_scene *scene, uint32_t number, const clast_tessellation *tessellation)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (number >= scene->geometry_count || !clast_geometry_is_mesh(&scene->geometries[number])) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "geometry %u is no mesh of the scene", number);
    }
    clast_geometry *geometry = &scene->geometries[number];
    geometry->kind = tessellation != NULL ? CLAST_SOURCE_DISPLACED : CLAST_SOURCE_CLUSTERS;
    geometry->tessellated = tessellation != NULL;
    geometry->tessellation = tessellation != NULL ? *tessellation : (clast_tessellation){0};
    geometry->version++;
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------- derived attributes

static vec3 point_at(const float *array, uint32_t index)
{
    const float *p = array + 3 * (size_t)index;
    return vec3(p[0], p[1], p[2]);
}

float *clast_mesh_normals(clast_context *context, const clast_mesh *mesh)
{
    float *normals = clast_allocate_zeroed(context, mesh->vertex_count, 3 * sizeof *normals);
    if (normals == NULL) {
        return NULL;
    }
    for (size_t triangle = 0; triangle < mesh->triangle_count; triangle++) {
        const uint32_t *corner = mesh->indices + 3 * triangle;
        vec3 a = point_at(mesh->positions, corner[0]);
        vec3 normal = cross3(point_at(mesh->positions, corner[1]) - a, point_at(mesh->positions, corner[2]) - a);
        for (int i = 0; i < 3; i++) {
            float *sum = normals + 3 * (size_t)corner[i];
            sum[0] += normal[0];
            sum[1] += normal[1];
            sum[2] += normal[2];
        }
    }
    for (uint32_t vertex = 0; vertex < mesh->vertex_count; vertex++) {
        vec3 normal = point_at(normals, vertex);
        float largest = largest3(vec3(abs1(normal[0]), abs1(normal[1]), abs1(normal[2])));
        // Scaled first: the square of a tiny triangle's area is below the smallest float.
        normal = largest > 0.0f && is_finite1(largest) ? normalize3(normal * (1.0f / largest)) : vec3(0.0f, 1.0f, 0.0f);
        normals[3 * (size_t)vertex] = normal[0];
        normals[3 * (size_t)vertex + 1] = normal[1];
        normals[3 * (size_t)vertex + 2] = normal[2];
    }
    return normals;
}

// Adds a triangle's tangent (direction of growing u) to its corners, and its bitangent's sign to the fourth component.
static void add_triangle_tangent(const clast_mesh *mesh, const uint32_t corner[3], float *tangents)
{
    vec3 a = point_at(mesh->positions, corner[0]);
    vec3 e1 = point_at(mesh->positions, corner[1]) - a;
    vec3 e2 = point_at(mesh->positions, corner[2]) - a;
    const float *t0 = mesh->coordinates[0] + 2 * (size_t)corner[0];
    const float *t1 = mesh->coordinates[0] + 2 * (size_t)corner[1];
    const float *t2 = mesh->coordinates[0] + 2 * (size_t)corner[2];
    float u1 = t1[0] - t0[0], v1 = t1[1] - t0[1], u2 = t2[0] - t0[0], v2 = t2[1] - t0[1];
    float area = u1 * v2 - u2 * v1;
    if (area == 0.0f || !is_finite1(area)) {
        return;
    }
    float sign = area < 0.0f ? -1.0f : 1.0f;
    vec3 tangent = normalize3((e1 * v2 - e2 * v1) * sign);
    // glTF: bitangent = cross(normal, tangent) * w points up in the image, and v grows downwards.
    float weight = length3(cross3(e1, e2));
    for (int i = 0; i < 3; i++) {
        float *sum = tangents + 4 * (size_t)corner[i];
        sum[0] += tangent[0] * weight;
        sum[1] += tangent[1] * weight;
        sum[2] += tangent[2] * weight;
        sum[3] -= sign * weight;
    }
}

float *clast_mesh_tangents(clast_context *context, const clast_mesh *mesh)
{
    float *tangents = clast_allocate_zeroed(context, mesh->vertex_count, 4 * sizeof *tangents);
    if (tangents == NULL || mesh->coordinates[0] == NULL) {
        return tangents;
    }
    for (size_t triangle = 0; triangle < mesh->triangle_count; triangle++) {
        add_triangle_tangent(mesh, mesh->indices + 3 * triangle, tangents);
    }
    for (uint32_t vertex = 0; vertex < mesh->vertex_count; vertex++) {
        float *t = tangents + 4 * (size_t)vertex;
        vec3 tangent = vec3(t[0], t[1], t[2]);
        if (mesh->normals != NULL) {
            vec3 normal = point_at(mesh->normals, vertex);
            tangent = tangent - normal * dot3(normal, tangent);
        }
        float largest = largest3(vec3(abs1(tangent[0]), abs1(tangent[1]), abs1(tangent[2])));
        tangent = largest > 0.0f && is_finite1(largest) ? normalize3(tangent * (1.0f / largest)) : splat3(0.0f);
        t[0] = tangent[0];
        t[1] = tangent[1];
        t[2] = tangent[2];
        t[3] = t[3] < 0.0f ? -1.0f : 1.0f;
    }
    return tangents;
}
