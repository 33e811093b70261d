// SPDX-License-Identifier: Apache-2.0
// Plain meshes: cooked clusters, each its own template. Positions stay where they are from frame to frame, or, where morph
// targets or a skin move the mesh, are gathered from the pose. An item is a cluster.
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "clast/geometry.h"
#include "shared/cooked.h"
#include "source/mesh.h"

enum {
    CLUSTER_GRAIN = 64,
    BOXES_MOST = 64,
    PROGRESS_TRIANGLES = 1000000, // meshes of fewer are cooked in less time than it takes to look
};

typedef struct clusters_unit {
    clast_unit base;
    const clast_template_set *templates;
    clast_cooked_cluster *clusters;
    uint32_t *triangles; // the mesh's triangle, for each of the clusters' triangles
    packed3 *positions;  // of the clusters' vertices; null where the mesh moves
    uint32_t *numbers;   // where it does: the mesh's vertices that they are
    size_t triangle_count;
    size_t position_count;
    clast_box box; // of the positions
} clusters_unit;

static const clusters_unit *clusters_of(const clast_unit *unit)
{
    return (const clusters_unit *)unit;
}

// How long cooking takes: in triangles.
static uint64_t work(const clast_geometry *geometry)
{
    return geometry->of.mesh.triangle_count;
}

// ----------------------------------------------------------------------------------------------------------- bounds

typedef struct box_job {
    const packed3 *positions;
    size_t grain;
    clast_box boxes[BOXES_MOST]; // one for each chunk
} box_job;

static clast_box empty_box(void)
{
    return (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
}

static void widen(clast_box *box, packed3 lower, packed3 upper)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        box->lower.v[axis] = min1(box->lower.v[axis], lower.v[axis]);
        box->upper.v[axis] = max1(box->upper.v[axis], upper.v[axis]);
    }
}

static void bound_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    box_job *job = data;
    clast_box box = empty_box();
    for (size_t i = begin; i < end; i++) {
        widen(&box, job->positions[i], job->positions[i]);
    }
    job->boxes[begin / job->grain] = box;
}

static clast_box box_of(clast_context *context, const packed3 *positions, size_t count)
{
    box_job job = {.positions = positions, .grain = count / BOXES_MOST + 1};
    for (size_t i = 0; i < BOXES_MOST; i++) {
        job.boxes[i] = empty_box();
    }
    clast_parallel_for(context, count, job.grain, bound_range, &job);
    clast_box box = empty_box();
    for (size_t i = 0; i < BOXES_MOST; i++) {
        widen(&box, job.boxes[i].lower, job.boxes[i].upper);
    }
    return box;
}

// ------------------------------------------------------------------------------------------------------------- cook

static clast_status weld(clast_context *context, const clast_geometry *geometry, uint32_t **welded)
{
    const clast_mesh *mesh = &geometry->of.mesh;
    uint32_t *remap = clast_allocate(context, mesh->vertex_count, sizeof *remap);
    if (remap == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    size_t unique = 0;
    clast_status status = clast_mesh_weld_positions(context, geometry, remap, &unique);
    if (status == CLAST_OK) {
        status = clast_mesh_weld(context, mesh, remap, unique, welded);
    }
    clast_free(context, remap);
    return status;
}

typedef struct gather_job {
    clusters_unit *unit;
    const clast_mesh *mesh;
    const clast_clusters *clusters;
    clast_template_desc *descs;
} gather_job;

// Positions, triangle numbers and the template description of clusters.
static void gather_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    gather_job *job = data;
    clusters_unit *unit = job->unit;
    for (size_t i = begin; i < end; i++) {
        clast_cluster from = job->clusters->clusters[i];
        for (uint32_t v = from.first_vertex; v < from.first_vertex + from.vertex_count; v++) {
            uint32_t number = job->clusters->vertices[v];
            if (unit->numbers != NULL) {
                unit->numbers[v] = number;
            } else {
                unit->positions[v] = clast_mesh_position(job->mesh, number);
            }
        }
        memcpy(unit->triangles + from.first_triangle, job->clusters->triangles + from.first_triangle,
               from.triangle_count * sizeof *unit->triangles);
        unit->clusters[i] = (clast_cooked_cluster){from.first_triangle, from.triangle_count, from.first_vertex,
                                                   from.vertex_count, (uint32_t)i};
        job->descs[i] = (clast_template_desc){
            .triangle_count = from.triangle_count,
            .vertex_count = from.vertex_count,
            .indices = job->clusters->indices + 3 * (size_t)from.first_triangle,
            .rest_positions = NULL, // clusters come in the order of their blocks
        };
    }
}

static clast_status keep_clusters(clusters_unit *unit, const clast_mesh *mesh, const clast_clusters *clusters,
                                  clast_template_set *templates)
{
    clast_context *context = unit->base.context;
    unit->triangle_count = mesh->triangle_count;
    unit->position_count = clusters->vertex_count;
    unit->clusters = clast_allocate(context, clusters->cluster_count, sizeof *unit->clusters);
    unit->triangles = clast_allocate(context, unit->triangle_count, sizeof *unit->triangles);
    size_t vertex_size = 0;
    if (clast_deforms(&unit->base.geometry->deformation)) {
        vertex_size = sizeof *unit->numbers;
        unit->numbers = clast_allocate(context, unit->position_count, vertex_size);
    } else {
        vertex_size = sizeof *unit->positions;
        unit->positions = clast_allocate(context, unit->position_count, vertex_size);
    }
    clast_template_desc *descs = clast_allocate(context, clusters->cluster_count, sizeof *descs);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (unit->clusters != NULL && unit->triangles != NULL && (unit->positions != NULL || unit->numbers != NULL) &&
        descs != NULL) {
        gather_job job = {unit, mesh, clusters, descs};
        clast_parallel_for(context, clusters->cluster_count, CLUSTER_GRAIN, gather_range, &job);
        status = CLAST_OK;
    }
    if (unit->positions != NULL && status == CLAST_OK) {
        unit->box = box_of(context, unit->positions, unit->position_count);
    }
    uint32_t first = 0;
    if (status == CLAST_OK) { // last, as a set cannot give templates back
        status = clast_template_set_add(templates, descs, clusters->cluster_count, &first);
    }
    clast_free(context, descs);
    for (size_t i = 0; status == CLAST_OK && i < clusters->cluster_count; i++) {
        unit->clusters[i].template_index += first;
    }
    unit->base.item_count = (uint32_t)clusters->cluster_count;
    unit->base.bytes = sizeof *unit + clusters->cluster_count * sizeof *unit->clusters +
                       unit->triangle_count * sizeof *unit->triangles + unit->position_count * vertex_size +
                       unit->base.material_count * sizeof(uint32_t);
    return status;
}

// For cancelling between the stages of a mesh that takes seconds.
static clast_status look_up(const clusters_unit *unit, const clast_mesh *mesh, uint64_t stage)
{
    return mesh->triangle_count < PROGRESS_TRIANGLES ? CLAST_OK
                                                     : clast_progress(unit->base.context, "clusters", stage, 3);
}

static clast_status cook_mesh(clusters_unit *unit, const clast_mesh *mesh, clast_template_set *templates)
{
    clast_context *context = unit->base.context;
    uint32_t *welded = NULL;
    clast_clusters clusters = {0};
    clast_status status = clast_mesh_list_materials(context, mesh, &unit->base.materials, &unit->base.material_count);
    if (status == CLAST_OK) {
        status = weld(context, unit->base.geometry, &welded);
    }
    if (status == CLAST_OK) {
        status = look_up(unit, mesh, 1);
    }
    if (status == CLAST_OK) {
        clast_clusterize_desc desc = {
            .positions = mesh->positions,
            .position_count = mesh->vertex_count,
            .indices = welded != NULL ? welded : mesh->indices,
            .triangle_count = mesh->triangle_count,
            .max_triangles = CLUSTER_TRIANGLES,
            .max_vertices = CLUSTER_VERTICES,
        };
        status = clast_clusterize(context, &desc, &clusters);
    }
    clast_free(context, welded);
    if (status != CLAST_OK) {
        return status;
    }
    status = look_up(unit, mesh, 2);
    if (status == CLAST_OK) {
        status = keep_clusters(unit, mesh, &clusters, templates);
    }
    clast_clusters_free(context, &clusters);
    return status;
}

static void destroy(clast_unit *base)
{
    clusters_unit *unit = (clusters_unit *)base;
    clast_context *context = base->context;
    clast_free(context, base->materials);
    clast_free(context, unit->clusters);
    clast_free(context, unit->triangles);
    clast_free(context, unit->positions);
    clast_free(context, unit->numbers);
    clast_free(context, unit);
}

static clast_status cook(const clast_cook_job *job, clast_unit **result)
{
    clusters_unit *unit = clast_allocate_zeroed(job->context, 1, sizeof *unit);
    if (unit == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    unit->base = (clast_unit){
        .context = job->context,
        .kind = CLAST_SOURCE_CLUSTERS,
        .geometry = job->geometry,
        .geometry_version = job->geometry->version,
        .bytes = sizeof *unit,
    };
    unit->templates = job->templates;
    unit->box = empty_box();
    const clast_mesh *mesh = &job->geometry->of.mesh;
    clast_status status = mesh->triangle_count != 0 ? cook_mesh(unit, mesh, job->templates) : CLAST_OK;
    if (status != CLAST_OK) {
        destroy(&unit->base);
        return status;
    }
    *result = &unit->base;
    return CLAST_OK;
}

// ----------------------------------------------------------------------------------------------------------- update

typedef struct update_job {
    clusters_unit *unit;
    const clast_mesh *mesh;
    atomic_bool torn;
} update_job;

static bool same_position(packed3 a, packed3 b)
{
    return a.v[0] == b.v[0] && a.v[1] == b.v[1] && a.v[2] == b.v[2];
}

// The mesh's present positions of a cluster's vertices, by way of its triangles' corners. False where vertices that
// were welded are no longer in one place.
static bool gather_cluster(const clusters_unit *unit, const clast_mesh *mesh, const clast_cooked_cluster *cluster,
                           packed3 *positions)
{
    bool known[TEMPLATE_VERTICES] = {false};
    for (uint32_t t = 0; t < cluster->triangle_count; t++) {
        const uint32_t *vertices = mesh->indices + 3 * (size_t)unit->triangles[cluster->first_triangle + t];
        uint32_t corners[3];
        clast_template_triangle(unit->templates, cluster->template_index, t, corners);
        for (uint32_t k = 0; k < 3; k++) {
            packed3 position = clast_mesh_position(mesh, vertices[k]);
            if (known[corners[k]] && !same_position(positions[corners[k]], position)) {
                return false;
            }
            known[corners[k]] = true;
            positions[corners[k]] = position;
        }
    }
    return true;
}

static void check_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    update_job *job = data;
    packed3 positions[TEMPLATE_VERTICES];
    for (size_t i = begin; i < end; i++) {
        if (!gather_cluster(job->unit, job->mesh, &job->unit->clusters[i], positions)) {
            atomic_store_explicit(&job->torn, true, memory_order_relaxed);
            return;
        }
    }
}

static void write_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    update_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const clast_cooked_cluster *cluster = &job->unit->clusters[i];
        gather_cluster(job->unit, job->mesh, cluster, job->unit->positions + cluster->first_vertex);
    }
}

// Vertices of one position share a vertex of their clusters: where they part, clusters would be drawn closed that are
// not, or the other way round, so the mesh is cooked anew. Nothing is written before that is known. Vertices that met
// since stay apart: that is no crack, as they are equal to the bit.
static clast_status update(clast_unit *base, const clast_geometry *geometry)
{
    clusters_unit *unit = (clusters_unit *)base;
    const clast_mesh *mesh = &geometry->of.mesh;
    // What welds the vertices of a mesh that moves is also how they move.
    if (mesh->triangle_count != unit->triangle_count || unit->numbers != NULL ||
        clast_deforms(&geometry->deformation)) {
        return CLAST_ERROR_UNSUPPORTED;
    }
    update_job job = {.unit = unit, .mesh = mesh};
    atomic_init(&job.torn, false);
    clast_parallel_for(base->context, base->item_count, CLUSTER_GRAIN, check_range, &job);
    if (atomic_load(&job.torn)) {
        return CLAST_ERROR_UNSUPPORTED;
    }
    clast_parallel_for(base->context, base->item_count, CLUSTER_GRAIN, write_range, &job);
    unit->box = box_of(base->context, unit->positions, unit->position_count);
    base->version++;
    base->geometry_version = geometry->version;
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------ frame

static clast_box bounds(const clast_unit *unit, const clast_pose *pose)
{
    if (clusters_of(unit)->numbers == NULL) {
        return clusters_of(unit)->box;
    }
    clast_mesh mesh = clast_mesh_posed(&unit->geometry->of.mesh, pose);
    return box_of(unit->context, (const packed3 *)mesh.positions, mesh.vertex_count);
}

static clast_change changed(const clast_unit *unit, const clast_pose *before, const clast_source_view *view_before,
                            const clast_pose *now, const clast_source_view *view_now)
{
    (void)unit;
    (void)view_before;
    (void)view_now;
    bool stands = before->version == now->version && before->shape == now->shape;
    return stands ? CLAST_CHANGE_NOTHING : CLAST_CHANGE_VERTICES;
}

static uint32_t arrays(const clast_unit *base, clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST])
{
    const clusters_unit *unit = clusters_of(base);
    for (uint32_t i = clast_mesh_arrays(base, arrays); i < CLUSTERS_ARRAYS; i++) {
        arrays[i] = (clast_source_array){0};
    }
    arrays[CLUSTERS_ARRAY_CLUSTERS] = (clast_source_array){"clusters", unit->clusters,
                                                           base->item_count * sizeof *unit->clusters, 0, 0};
    arrays[CLUSTERS_ARRAY_TRIANGLES] = (clast_source_array){"triangles", unit->triangles,
                                                            unit->triangle_count * sizeof *unit->triangles, 0, 0};
    if (unit->numbers != NULL) {
        arrays[CLUSTERS_ARRAY_NUMBERS] = (clast_source_array){"numbers", unit->numbers,
                                                              unit->position_count * sizeof *unit->numbers, 0, 0};
    } else {
        arrays[CLUSTERS_ARRAY_POSITIONS] = (clast_source_array){
            "positions", unit->positions, unit->position_count * sizeof *unit->positions, base->version, 0};
    }
    return CLUSTERS_ARRAYS;
}

static clast_source_count count(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                                uint32_t item)
{
    (void)pose;
    (void)view;
    return cooked_count(clusters_of(unit)->clusters[item], clusters_of(unit)->numbers != NULL);
}

static void emit(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view, uint32_t item,
                 uint32_t first_vertex, uint32_t first_word, uint32_t *words, clast_cluster_record *records)
{
    (void)words;
    (void)pose;
    (void)view;
    records[0] = cooked_record(clusters_of(unit)->clusters[item], unit->number, item, first_vertex, first_word);
}

static const packed3 *resident(const clast_unit *unit, const clast_cluster_record *record)
{
    const clusters_unit *clusters = clusters_of(unit);
    return clusters->positions != NULL ? clusters->positions + clusters->clusters[record->item].first_vertex : NULL;
}

static void fill(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                 const uint32_t *words, packed3 *positions)
{
    (void)words;
    const clusters_unit *clusters = clusters_of(unit);
    const clast_cooked_cluster *cluster = &clusters->clusters[record->item];
    if (clusters->numbers == NULL) {
        memcpy(positions, clusters->positions + cluster->first_vertex, cluster->vertex_count * sizeof *positions);
        return;
    }
    clast_mesh mesh = clast_mesh_posed(&unit->geometry->of.mesh, pose);
    for (uint32_t i = 0; i < cluster->vertex_count; i++) {
        positions[i] = clast_mesh_position(&mesh, clusters->numbers[cluster->first_vertex + i]);
    }
}

static clast_surface_point locate(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                                  const uint32_t *words, uint32_t triangle, vec2 barycentrics)
{
    (void)words;
    (void)pose;
    const clusters_unit *clusters = clusters_of(unit);
    return (clast_surface_point){
        .primitive = clusters->triangles[clusters->clusters[record->item].first_triangle + triangle],
        .coordinates = store2(barycentrics),
    };
}

// -------------------------------------------------------------------------------------------------------- attributes

static clast_source_surface evaluate(const clast_unit *unit, const clast_pose *pose, clast_surface_point point)
{
    clast_mesh mesh = clast_mesh_posed(&unit->geometry->of.mesh, pose);
    return clast_mesh_evaluate(&mesh, point);
}

static uint32_t primitive_count(const clast_unit *unit)
{
    return unit->geometry->of.mesh.triangle_count;
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

const clast_source CLAST_SOURCE_CLUSTERS_TABLE = {
    .name = "clusters",
    .most_triangles = CLUSTER_TRIANGLES,
    .single_items = true,
    .work = work,
    .cook = cook,
    .destroy = destroy,
    .update = update,
    .bounds = bounds,
    .changed = changed,
    .arrays = arrays,
    .count = count,
    .emit = emit,
    .fill = fill,
    .resident = resident,
    .locate = locate,
    .evaluate = evaluate,
    .primitive_count = primitive_count,
    .primitive_material = primitive_material,
    .primitive_corners = primitive_corners,
};
