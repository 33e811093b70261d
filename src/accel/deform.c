// SPDX-License-Identifier: Apache-2.0
// Deforming meshes: creation, fitting, questions.
#include <string.h>

#include "accel/deform.h"
#include "base/thread.h"
#include "clast/geometry.h"

enum {
    CLUSTER_FILL = CLUSTER_TRIANGLES * 7 /
                   8, // of clusters at first: cut anew, some need more vertices for their triangles
    FILL_GRAIN = 64,
    BUDGET_SHARE = 50, // of the triangles that an update cuts, where nothing else is asked for
    BUDGET_LEAST = 1024,
    PIECE_LEAST = 512, // triangles: there are choices for a budget's worth of such pieces
};

// ------------------------------------------------------------------------------------------------------------- memory

// All arrays. Without memory in the arena this only counts.
static void take_arrays(clast_deforming_mesh *mesh, clast_arena *arena)
{
    uint32_t count = mesh->cluster_count;
    size_t vertices = (size_t)count * mesh->vertex_stride;
    mesh->first = clast_arena_take(arena, count, sizeof *mesh->first);
    mesh->numbers = clast_arena_take(arena, vertices, sizeof *mesh->numbers);
    mesh->triangles = clast_arena_take(arena, (size_t)count * CLUSTER_TRIANGLES, sizeof *mesh->triangles);
    mesh->vertices = clast_arena_take(arena, vertices, 3 * sizeof *mesh->vertices);
    clast_deform_tree_take(mesh, arena);
    if (mesh->watched) {
        mesh->expected = clast_arena_take(arena, count, sizeof *mesh->expected);
        mesh->order = clast_arena_take(arena, count, sizeof *mesh->order);
        mesh->pieces = clast_arena_take(arena, count, sizeof *mesh->pieces);
        mesh->states = clast_arena_take(arena, count, sizeof *mesh->states);
        mesh->choices = clast_arena_take(arena, mesh->choice_most, sizeof *mesh->choices);
        mesh->cutters = clast_arena_take(arena, clast_worker_count(mesh->context), clast_piece_cutter_size());
    }
}

static clast_status allocate_arrays(clast_deforming_mesh *mesh)
{
    clast_arena arena = {0};
    take_arrays(mesh, &arena);
    mesh->bytes = arena.used;
    mesh->memory = clast_allocate_zeroed(mesh->context, arena.used, 1);
    if (mesh->memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    arena = (clast_arena){mesh->memory, 0};
    take_arrays(mesh, &arena);
    return CLAST_OK;
}

static clast_status make_objects(clast_deforming_mesh *mesh)
{
    clast_status status = clast_template_set_create(mesh->context, &mesh->set);
    status = status == CLAST_OK ? clast_clas_pool_create(mesh->set, &mesh->pool) : status;
    status = status == CLAST_OK ? clast_clas_pool_reserve_own(mesh->pool, mesh->cluster_count, CLUSTER_TRIANGLES)
                                : status;
    return status == CLAST_OK ? clast_blas_create(mesh->pool, &mesh->blas) : status;
}

// ------------------------------------------------------------------------------------------------------------- filling

typedef struct fill_job {
    clast_deforming_mesh *mesh;
    const clast_clusters *clusters;
    const float *positions;
    clast_clas_desc *descs;
} fill_job;

static void fill_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const fill_job *job = data;
    clast_deforming_mesh *mesh = job->mesh;
    for (size_t slot = begin; slot < end; slot++) {
        const clast_cluster *cluster = &job->clusters->clusters[slot];
        size_t first = slot * mesh->vertex_stride;
        mesh->first[slot] = (uint32_t)first;
        for (uint32_t i = 0; i < cluster->vertex_count; i++) {
            uint32_t number = job->clusters->vertices[cluster->first_vertex + i];
            mesh->numbers[first + i] = number;
            memcpy(mesh->vertices + 3 * (first + i), job->positions + 3 * (size_t)number, 3 * sizeof *mesh->vertices);
        }
        memcpy(mesh->triangles + slot * CLUSTER_TRIANGLES, job->clusters->triangles + cluster->first_triangle,
               cluster->triangle_count * sizeof *mesh->triangles);
        job->descs[slot] = (clast_clas_desc){.triangle_count = cluster->triangle_count,
                                             .vertex_count = cluster->vertex_count,
                                             .indices = job->clusters->indices + 3 * (size_t)cluster->first_triangle,
                                             .vertices = mesh->vertices + 3 * first};
    }
}

static clast_status fill_clusters(clast_deforming_mesh *mesh, const float *positions, const clast_clusters *clusters)
{
    clast_clas_desc *descs = clast_allocate(mesh->context, mesh->cluster_count, sizeof *descs);
    if (descs == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    fill_job job = {mesh, clusters, positions, descs};
    clast_parallel_for(mesh->context, mesh->cluster_count, FILL_GRAIN, fill_range, &job);
    clast_status status = clast_clas_build(mesh->pool, 0, mesh->cluster_count, descs);
    clast_free(mesh->context, descs);
    return status;
}

static clast_status fill_mesh(clast_deforming_mesh *mesh, const float *positions, const clast_clusters *clusters)
{
    mesh->vertex_stride = CLUSTER_VERTICES;
    mesh->cluster_count = (uint32_t)clusters->cluster_count;
    if (clusters->cluster_count > UINT32_MAX / CLUSTER_VERTICES) {
        return clast_fail(mesh->context, CLAST_ERROR_LIMIT, "a deforming mesh of %zu clusters; %u are possible",
                          clusters->cluster_count, UINT32_MAX / CLUSTER_VERTICES);
    }
    clast_status status = make_objects(mesh);
    status = status == CLAST_OK ? allocate_arrays(mesh) : status;
    status = status == CLAST_OK ? fill_clusters(mesh, positions, clusters) : status;
    if (status != CLAST_OK || mesh->cluster_count == 0) {
        return status;
    }
    clast_deform_tree_begin(mesh);
    while (!clast_deform_tree_go_on(mesh, UINT64_MAX)) {
    }
    clast_tree_refit(mesh->context, &mesh->blas->tree, mesh->pool->boxes);
    if (mesh->watched) {
        clast_deform_watch_begin(mesh);
    }
    return CLAST_OK;
}

// ---------------------------------------------------------------------------------------------------------------- all

static clast_status create(clast_deforming_mesh *mesh, const clast_deforming_mesh_desc *desc)
{
    clast_clusterize_desc clusterize = {.positions = desc->positions,
                                        .position_count = desc->position_count,
                                        .indices = desc->indices,
                                        .triangle_count = desc->triangle_count,
                                        .max_triangles = CLUSTER_FILL};
    clast_clusters clusters;
    clast_status status = clast_clusterize(mesh->context, &clusterize, &clusters);
    if (status == CLAST_OK) {
        status = fill_mesh(mesh, desc->positions, &clusters);
        clast_clusters_free(mesh->context, &clusters);
    }
    return status;
}

clast_status clast_deforming_mesh_create(clast_context *context, const clast_deforming_mesh_desc *desc,
                                         clast_deforming_mesh **mesh)
{
    if (context == NULL || desc == NULL || mesh == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *mesh = NULL;
    clast_deforming_mesh *made = clast_allocate_zeroed(context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint64_t budget = desc->watch_budget != 0 ? desc->watch_budget : desc->triangle_count / BUDGET_SHARE;
    made->context = context;
    made->position_count = desc->position_count;
    made->watched = !desc->unwatched;
    budget = desc->watch_budget != 0 || budget > BUDGET_LEAST ? budget : BUDGET_LEAST;
    made->budget = (uint32_t)budget;
    made->choice_most = made->budget / PIECE_LEAST + 1;
    clast_status status = create(made, desc);
    if (status != CLAST_OK) {
        clast_deforming_mesh_destroy(made);
        return status;
    }
    *mesh = made;
    return CLAST_OK;
}

void clast_deforming_mesh_destroy(clast_deforming_mesh *mesh)
{
    if (mesh != NULL) {
        clast_blas_destroy(mesh->blas);
        clast_clas_pool_destroy(mesh->pool);
        clast_template_set_destroy(mesh->set);
        clast_free(mesh->context, mesh->memory);
        clast_free(mesh->context, mesh);
    }
}

static clast_status update(clast_deforming_mesh *mesh, const float *positions,
                           clast_deforming_mesh_statistics *statistics)
{
    clast_clas_gather gather = {positions, mesh->position_count, mesh->numbers, mesh->first, mesh->vertices};
    clast_status status = clast_clas_refit_gathered(mesh->pool, 0, mesh->cluster_count, &gather);
    if (status != CLAST_OK) {
        return status;
    }
    if (mesh->watched) {
        clast_deform_watch(mesh, positions, statistics);
    }
    clast_tree_refit(mesh->context, &mesh->blas->tree, mesh->pool->boxes);
    if (mesh->watched) {
        clast_deform_watch_end(mesh, statistics);
    }
    return CLAST_OK;
}

clast_status clast_deforming_mesh_update(clast_deforming_mesh *mesh, const float *positions,
                                         clast_deforming_mesh_statistics *statistics)
{
    if (mesh == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (positions == NULL && mesh->cluster_count != 0) {
        return clast_fail(mesh->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "an update of a deforming mesh without positions");
    }
    clast_deforming_mesh_statistics own = {0};
    clast_status status = mesh->cluster_count != 0 ? update(mesh, positions, &own) : CLAST_OK;
    if (statistics != NULL) {
        *statistics = own;
    }
    return status;
}

const clast_blas *clast_deforming_mesh_blas(const clast_deforming_mesh *mesh)
{
    return mesh != NULL ? mesh->blas : NULL;
}

uint32_t clast_deforming_mesh_triangle(const clast_deforming_mesh *mesh, uint32_t cluster, uint32_t triangle)
{
    if (mesh == NULL || cluster >= mesh->cluster_count ||
        triangle >= clast_deform_template(mesh, cluster)->triangle_count) {
        return CLAST_NONE;
    }
    return mesh->triangles[(size_t)cluster * CLUSTER_TRIANGLES + triangle];
}

uint64_t clast_deforming_mesh_bytes(const clast_deforming_mesh *mesh)
{
    return mesh != NULL ? sizeof *mesh + mesh->bytes + clast_template_set_bytes(mesh->set) +
                              clast_clas_pool_bytes(mesh->pool) + clast_blas_bytes(mesh->blas)
                        : 0;
}
