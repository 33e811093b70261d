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
    if (pose->positions == NULL && pose->normals == NULL) {
        return displaced_reach(unit->reach, pose->displacement_scale);
    }
    float most = unit->height_most * abs1(pose->displacement_scale);
    return (clast_box){store3(splat3(-most)), store3(splat3(most))};
}

static clast_box bounds(const clast_unit *base, const clast_pose *pose)
{
    const displaced_unit *unit = clast_displaced_of(base);
    if (base->item_count == 0) {
        return unit->rest;
    }
    clast_box box = pose->positions != NULL || pose->normals != NULL ? clast_displaced_rest_box(unit, pose)
                                                                     : unit->rest;
    return displaced_bounds(box, reach_in(unit, pose));
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
    bool same_view = memcmp(view_before, view_now, offsetof(clast_source_view, depths)) == 0;
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
    const clast_pattern_table *patterns = unit->patterns;
    size_t items = base->item_count, mesh_vertices = base->geometry->of.mesh.vertex_count;
    uint32_t first = clast_mesh_arrays(base, list), version = base->version;
#define ARRAY(array, count) \
    { \
#array, unit->array, unit->array != NULL ? (count) * sizeof *unit->array : 0, version, 0 \
    }
    const clast_source_array own[] = {
        {"header", &unit->header, sizeof unit->header, version, 0},
        ARRAY(clusters, items),
        ARRAY(triangles, unit->triangle_count),
        ARRAY(mesh_triangles, unit->triangle_count),
        ARRAY(vertex_numbers, unit->corner_count),
        ARRAY(edges, unit->edge_count),
        ARRAY(seams, unit->seam_count),
        ARRAY(vertices, unit->vertex_count + 1),
        ARRAY(normals, unit->normal_count),
        ARRAY(vertex_of, mesh_vertices),
        ARRAY(gradients[0], mesh_vertices),
        ARRAY(gradients[1], mesh_vertices),
        ARRAY(map_records, unit->map_count),
        ARRAY(map_of_material, unit->material_count),
        {"patterns", patterns->patterns, PATTERN_COUNT * sizeof *patterns->patterns, 0, patterns->hash},
        {"pattern_vertices", patterns->vertices, patterns->vertex_count * sizeof *patterns->vertices, 0,
         patterns->hash + 1},
        {"pattern_triangles", patterns->triangles, patterns->triangle_count * sizeof *patterns->triangles, 0,
         patterns->hash + 2},
    };
#undef ARRAY
    _Static_assert(MESH_ARRAYS + sizeof own / sizeof *own == DISPLACED_ARRAYS, "each array has its place");
    memcpy(list + first, own, sizeof own);
    return DISPLACED_ARRAYS;
}

static uint32_t height_count(const clast_unit *unit)
{
    return (uint32_t)clast_displaced_of(unit)->map_count;
}

static const clast_height *height(const clast_unit *unit, uint32_t number)
{
    return clast_displaced_of(unit)->maps[number].height;
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
    .hides_edges = true,
    .work = work,
    .cook = clast_displaced_cook,
    .destroy = clast_displaced_destroy,
    .update = update,
    .bounds = bounds,
    .changed = changed,
    .deviation = deviation,
    .arrays = arrays,
    .height_count = height_count,
    .height = height,
    .posed_array = DISPLACED_ARRAY_VERTICES,
    .posed_bytes = sizeof(clast_displaced_vertex),
    .count = clast_displaced_count,
    .emit = clast_displaced_emit,
    .draft = clast_displaced_draft,
    .fill = clast_displaced_fill,
    .corners = clast_displaced_corners,
    .fill_composite = clast_displaced_fill_composite,
    .resident = resident,
    .locate = clast_displaced_locate,
    .segments = clast_displaced_segments,
    .evaluate = clast_displaced_evaluate,
    .primitive_count = primitive_count,
    .primitive_material = primitive_material,
    .primitive_corners = primitive_corners,
};
