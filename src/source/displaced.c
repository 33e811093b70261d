// SPDX-License-Identifier: Apache-2.0
// The table of displaced meshes, and their smaller duties.
#include "source/displaced.h"

#include <math.h>

static uint64_t work(const clast_geometry *geometry)
{
    return 4 * (uint64_t)geometry->of.mesh.triangle_count;
}

// Cooking anew is what it takes: vertices may part, and what is known of their edges changes.
static clast_status update(clast_unit *unit, const clast_geometry *geometry)
{
    (void)unit;
    (void)geometry;
    return CLAST_ERROR_UNSUPPORTED;
}

// Where displacement goes in a pose: as cooked, or, where normals have moved, as far any way.
static clast_box reach_in(const displaced_unit *unit, const clast_pose *pose)
{
    vec3 a = load3(unit->reach.lower) * pose->displacement_scale;
    vec3 b = load3(unit->reach.upper) * pose->displacement_scale;
    clast_box reach = {store3(min3(a, b)), store3(max3(a, b))};
    if (pose->positions != NULL || pose->normals != NULL) {
        float most = unit->height_most * abs1(pose->displacement_scale);
        reach = (clast_box){store3(splat3(-most)), store3(splat3(most))};
    }
    return reach;
}

static clast_box bounds(const clast_unit *base, const clast_pose *pose)
{
    const displaced_unit *unit = clast_displaced_of(base);
    if (base->item_count == 0) {
        return unit->rest;
    }
    clast_box box = pose->positions != NULL || pose->normals != NULL ? clast_displaced_rest_box(unit, pose)
                                                                     : unit->rest;
    clast_box reach = reach_in(unit, pose);
    for (uint32_t axis = 0; axis < 3; axis++) {
        float lower = box.lower.v[axis], upper = box.upper.v[axis];
        // some roundings of what is added up
        float error = 4e-6f * (max1(abs1(lower), abs1(upper)) + abs1(reach.lower.v[axis]) + abs1(reach.upper.v[axis]));
        box.lower.v[axis] = lower + reach.lower.v[axis] - error;
        box.upper.v[axis] = upper + reach.upper.v[axis] + error;
    }
    return box;
}

static bool same_pose(const clast_pose *a, const clast_pose *b)
{
    return a->version == b->version && a->shape == b->shape && a->displacement_scale == b->displacement_scale;
}

// Segments follow from both the view and where the edges are.
static clast_change changed(const clast_unit *unit, const clast_pose *before, const clast_source_view *view_before,
                            const clast_pose *now, const clast_source_view *view_now)
{
    (void)unit;
    bool same_view = memcmp(view_before, view_now, sizeof *view_now) == 0;
    if (same_view && same_pose(before, now)) {
        return CLAST_CHANGE_NOTHING;
    }
    bool any_place = view_now->metric == CLAST_METRIC_FIXED;
    return same_view && any_place ? CLAST_CHANGE_VERTICES : CLAST_CHANGE_TOPOLOGY;
}

// Between its vertices the surface lies anywhere within what displaces it. How far a curved triangle is from a flat one is
// not kept.
static float deviation(const clast_unit *base, const clast_pose *pose)
{
    const displaced_unit *unit = clast_displaced_of(base);
    return unit->curved ? INFINITY : 2.0f * unit->height_most * abs1(pose->displacement_scale);
}

static uint32_t arrays(const clast_unit *base, clast_source_array list[CLAST_SOURCE_ARRAYS_MOST])
{
    const displaced_unit *unit = clast_displaced_of(base);
    const clast_mesh *mesh = &base->geometry->of.mesh;
    const clast_source_array all[] = {
        {"clusters", unit->clusters, base->item_count * sizeof *unit->clusters, 0},
        {"triangles", unit->triangles, unit->triangle_count * sizeof *unit->triangles, 0},
        {"mesh_triangles", unit->mesh_triangles, unit->triangle_count * sizeof *unit->mesh_triangles, 0},
        {"vertex_numbers", unit->vertex_numbers, unit->corner_count * sizeof *unit->vertex_numbers, 0},
        {"edges", unit->edges, unit->edge_count * sizeof *unit->edges, 0},
        {"seams", unit->seams, unit->seam_count * sizeof *unit->seams, 0},
        {"vertices", unit->vertices, unit->vertex_count * sizeof *unit->vertices, 0},
        {"normals", unit->normals, unit->normal_count * sizeof *unit->normals, 0},
        {"vertex_of", unit->vertex_of, mesh->vertex_count * sizeof *unit->vertex_of, 0},
        {"gradients_0", unit->gradients[0], mesh->vertex_count * sizeof *unit->gradients[0], 0},
        {"gradients_1", unit->gradients[1], mesh->vertex_count * sizeof *unit->gradients[1], 0},
        {"maps", unit->maps, unit->map_count * sizeof *unit->maps, 0},
    };
    uint32_t count = 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (all[i].data != NULL && all[i].bytes != 0) {
            list[count++] = all[i];
        }
    }
    return count;
}

static const packed3 *resident(const clast_unit *unit, const clast_cluster_record *record)
{
    (void)unit;
    (void)record;
    return NULL;
}

// A displaced glowing mesh is seen by rays that hit it; where its surface is that of the mesh, its triangles are sampled too.
static uint32_t primitive_count(const clast_unit *base)
{
    const displaced_unit *unit = clast_displaced_of(base);
    return unit->displaced || unit->curved ? 0 : base->geometry->of.mesh.triangle_count;
}

static uint32_t primitive_material(const clast_unit *unit, uint32_t primitive)
{
    return clast_mesh_material(&unit->geometry->of.mesh, primitive);
}

static void primitive_corners(const clast_unit *unit, const clast_pose *pose, uint32_t primitive, vec3 corners[3])
{
    clast_mesh mesh = clast_mesh_posed(&unit->geometry->of.mesh, pose);
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = load3(clast_mesh_position(&mesh, mesh.indices[3 * (size_t)primitive + k]));
    }
}

const clast_source CLAST_SOURCE_DISPLACED_TABLE = {
    .name = "displaced",
    .most_triangles = CLUSTER_TRIANGLES,
    .adapts = true,
    .work = work,
    .cook = clast_displaced_cook,
    .destroy = clast_displaced_destroy,
    .update = update,
    .bounds = bounds,
    .changed = changed,
    .deviation = deviation,
    .arrays = arrays,
    .count = clast_displaced_count,
    .emit = clast_displaced_emit,
    .fill = clast_displaced_fill,
    .corners = clast_displaced_corners,
    .resident = resident,
    .locate = clast_displaced_locate,
    .segments = clast_displaced_segments,
    .evaluate = clast_displaced_evaluate,
    .primitive_count = primitive_count,
    .primitive_material = primitive_material,
    .primitive_corners = primitive_corners,
};
