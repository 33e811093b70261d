// SPDX-License-Identifier: Apache-2.0
// Meshes whose materials displace them: what loaders do with them.
#include <string.h>

#include "base/size.h"
#include "scene/scene.h"

static bool displaces(const clast_scene *scene, uint32_t material)
{
    return material < scene->material_count &&
           scene->materials[material].record.displacement_texture.texture != CLAST_NONE;
}

bool clast_mesh_is_displaced(const clast_scene *scene, const clast_mesh *mesh)
{
    if (mesh->triangle_materials == NULL) {
        return displaces(scene, mesh->material != CLAST_NONE ? mesh->material : 0);
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        if (displaces(scene, mesh->triangle_materials[i])) {
            return true;
        }
    }
    return false;
}

static vec2 add_heights(vec2 range, const clast_material *material)
{
    float a = material->displacement_offset, b = a + material->displacement_scale;
    return vec2(min1(range[0], min1(a, b)), max1(range[1], max1(a, b)));
}

vec2 clast_mesh_heights(const clast_scene *scene, const clast_mesh *mesh)
{
    vec2 range = vec2(0.0f, 0.0f);
    size_t looked_at = mesh->triangle_materials != NULL ? mesh->triangle_count : 1;
    uint32_t last = CLAST_NONE;
    for (size_t i = 0; i < looked_at; i++) {
        uint32_t material = mesh->triangle_materials != NULL ? mesh->triangle_materials[i] : mesh->material;
        if (material != last && displaces(scene, material)) {
            range = add_heights(range, &scene->materials[material].record);
        }
        last = material;
    }
    return range;
}

clast_status clast_scene_tessellate_displaced(clast_scene *scene, size_t first)
{
    clast_status status = CLAST_OK;
    for (size_t i = first; i < scene->geometry_count && status == CLAST_OK; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        if (clast_geometry_is_mesh(geometry) && !geometry->tessellated &&
            clast_mesh_is_displaced(scene, &geometry->of.mesh)) {
            status = clast_scene_set_tessellation(scene, (uint32_t)i, &(clast_tessellation){0});
        }
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------ joining

// What the joined mesh has: an attribute that one of the parts has.
typedef struct join {
    clast_scene *scene;
    const clast_geometry *parts;
    size_t count;
    clast_mesh mesh;
    void *blocks[CLAST_GEOMETRY_BLOCKS];
    uint32_t block_count;
} join;

typedef enum attribute {
    ATTRIBUTE_POSITIONS,
    ATTRIBUTE_NORMALS,
    ATTRIBUTE_TANGENTS,
    ATTRIBUTE_COORDINATES,
    ATTRIBUTE_MORE_COORDINATES,
    ATTRIBUTE_COLOURS,
} attribute;

static const float **array_of(clast_mesh *mesh, attribute which)
{
    switch (which) {
    case ATTRIBUTE_POSITIONS: return &mesh->positions;
    case ATTRIBUTE_NORMALS: return &mesh->normals;
    case ATTRIBUTE_TANGENTS: return &mesh->tangents;
    case ATTRIBUTE_COORDINATES: return &mesh->coordinates[0];
    case ATTRIBUTE_MORE_COORDINATES: return &mesh->coordinates[1];
    default: return &mesh->colours;
    }
}

static void *add_block(join *j, size_t count, size_t size)
{
    void *block = clast_allocate(j->scene->context, count, size);
    if (block != NULL) {
        j->blocks[j->block_count++] = block;
    }
    return block;
}

static void fill(float *to, const float *value, size_t width, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        memcpy(to + i * width, value, width * sizeof *to);
    }
}

// Joins an attribute. Vertices of parts that lack it get `otherwise`; null: normals of their triangles. False where
// memory ran out.
static bool join_attribute(join *j, attribute which, size_t width, const float *otherwise)
{
    bool any = false;
    for (size_t i = 0; i < j->count; i++) {
        clast_mesh part = j->parts[i].of.mesh;
        any = any || *array_of(&part, which) != NULL;
    }
    float *joined = any ? add_block(j, j->mesh.vertex_count, width * sizeof *joined) : NULL;
    if (joined == NULL) {
        return !any;
    }
    *array_of(&j->mesh, which) = joined;
    for (size_t i = 0; i < j->count; i++) {
        clast_mesh part = j->parts[i].of.mesh;
        const float *array = *array_of(&part, which);
        float *made = array == NULL && otherwise == NULL ? clast_mesh_normals(j->scene->context, &part) : NULL;
        if (array == NULL && otherwise == NULL && made == NULL) {
            return false;
        }
        if (array != NULL || made != NULL) {
            memcpy(joined, array != NULL ? array : made, part.vertex_count * width * sizeof *joined);
        } else {
            fill(joined, otherwise, width, part.vertex_count);
        }
        clast_free(j->scene->context, made);
        joined += part.vertex_count * width;
    }
    return true;
}

static bool join_triangles(join *j)
{
    uint32_t *indices = add_block(j, j->mesh.triangle_count, 3 * sizeof *indices);
    uint32_t *materials = add_block(j, j->mesh.triangle_count, sizeof *materials);
    if (indices == NULL || materials == NULL) {
        return false;
    }
    j->mesh.indices = indices;
    j->mesh.triangle_materials = materials;
    uint32_t first = 0;
    for (size_t i = 0; i < j->count; i++) {
        const clast_mesh *part = &j->parts[i].of.mesh;
        for (size_t k = 0; k < 3 * (size_t)part->triangle_count; k++) {
            *indices++ = first + part->indices[k];
        }
        for (size_t k = 0; k < part->triangle_count; k++) {
            *materials++ = part->triangle_materials != NULL ? part->triangle_materials[k] : part->material;
        }
        first += part->vertex_count;
    }
    return true;
}

static clast_status join_arrays(join *j)
{
    static const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f}, white[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    uint64_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < j->count; i++) {
        vertices += j->parts[i].of.mesh.vertex_count;
        triangles += j->parts[i].of.mesh.triangle_count;
    }
    if (vertices >= CLAST_NONE || triangles > UINT32_MAX / 3) {
        return clast_fail(j->scene->context, CLAST_ERROR_LIMIT, "%llu triangles: expected at most %u in a mesh",
                          (unsigned long long)triangles, UINT32_MAX / 3);
    }
    j->mesh.vertex_count = (uint32_t)vertices;
    j->mesh.triangle_count = (uint32_t)triangles;
    bool whole = join_attribute(j, ATTRIBUTE_POSITIONS, 3, nothing) && join_attribute(j, ATTRIBUTE_NORMALS, 3, NULL) &&
                 join_attribute(j, ATTRIBUTE_TANGENTS, 4, nothing) &&
                 join_attribute(j, ATTRIBUTE_COORDINATES, 2, nothing) &&
                 join_attribute(j, ATTRIBUTE_MORE_COORDINATES, 2, nothing) &&
                 join_attribute(j, ATTRIBUTE_COLOURS, 4, white) && join_triangles(j);
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static void free_blocks(clast_context *context, void *const *blocks, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        clast_free(context, blocks[i]);
    }
}

clast_status clast_scene_join_meshes(clast_scene *scene, size_t first)
{
    clast_context *context = scene->context;
    join j = {.scene = scene, .parts = scene->geometries + first, .count = scene->geometry_count - first};
    if (j.count < 2) {
        return CLAST_OK;
    }
    clast_status status = join_arrays(&j);
    if (status != CLAST_OK) {
        free_blocks(context, j.blocks, j.block_count);
        return status;
    }
    for (size_t i = first; i < scene->geometry_count; i++) {
        free_blocks(context, scene->geometries[i].blocks, scene->geometries[i].block_count);
        if (i > first) {
            clast_free(context, scene->geometries[i].name);
        }
    }
    clast_geometry *joined = &scene->geometries[first];
    joined->of.mesh = j.mesh;
    memcpy(joined->blocks, j.blocks, sizeof j.blocks);
    joined->block_count = j.block_count;
    joined->version++;
    scene->geometry_count = first + 1;
    return CLAST_OK;
}
