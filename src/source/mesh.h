// SPDX-License-Identifier: Apache-2.0
// What sources that are made of triangle meshes have in common.
#ifndef CLAST_SOURCE_MESH_H
#define CLAST_SOURCE_MESH_H

#include "source/source.h"

static inline packed3 clast_mesh_position(const clast_mesh *mesh, size_t vertex)
{
    packed3 position;
    memcpy(&position, mesh->positions + 3 * vertex, sizeof position);
    return position;
}

static inline uint32_t clast_mesh_material(const clast_mesh *mesh, size_t triangle)
{
    uint32_t material = mesh->triangle_materials != NULL ? mesh->triangle_materials[triangle] : mesh->material;
    return material != CLAST_NONE ? material : 0;
}

// The mesh with what a pose moves in the place of its own arrays.
clast_mesh clast_mesh_posed(const clast_mesh *mesh, const clast_pose *pose);

// Describes the mesh of a unit in the places that shared/device.h gives its arrays (MESH_ARRAY_); returns MESH_ARRAYS.
uint32_t clast_mesh_arrays(const clast_unit *unit, clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST]);

// As clast_weld_positions, for a geometry's mesh; vertices of one position that its morph targets or joints move apart stay
// apart.
clast_status clast_mesh_weld_positions(clast_context *context, const clast_geometry *geometry, uint32_t *remap,
                                       size_t *unique_count);

// The mesh's indices with equal positions made one, in a new block; null where they are as they should be already. `remap`
// is what clast_mesh_weld_positions gave.
clast_status clast_mesh_weld(clast_context *context, const clast_mesh *mesh, const uint32_t *remap, size_t unique_count,
                             uint32_t **welded);

// The different materials, in order of first use, as a block of the unit's.
clast_status clast_mesh_list_materials(clast_context *context, const clast_mesh *mesh, uint32_t **materials,
                                       uint32_t *count);

// Position, normals and attributes of a point of a mesh: its primitive is a triangle.
clast_source_surface clast_mesh_evaluate(const clast_mesh *mesh, clast_surface_point point);

#endif
