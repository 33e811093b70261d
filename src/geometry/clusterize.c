// SPDX-License-Identifier: Apache-2.0
// Clusters of a mesh: boxes of its triangles, cut into groups (cut.c), cut into clusters (group.c), gathered into arrays.
#include <math.h>
#include <stdatomic.h>

#include "base/thread.h"
#include "geometry/cut.h"
#include "shared/limits.h"

enum { TRIANGLE_GRAIN = 16384, STACK_MOST = 64 };

// A range that one thread cuts to the end.
typedef struct task {
    cut_range range;
    uint32_t cluster_count;
    uint32_t first_cluster;
    uint64_t vertex_count;
    uint64_t first_vertex;
} task;

typedef struct clusterizer {
    clast_context *context;
    const clast_clusterize_desc *desc;
    cut_limits limits;
    cut_box *boxes;
    lanes *centres; // for each worker, lower and upper
    atomic_bool out_of_range;
    task *tasks;
    size_t task_count, task_capacity;
    cut_range *large; // still to be cut by all threads
    size_t large_count, large_capacity;
    unsigned char *scratch; // a group for each worker
    clast_clusters *result;
} clusterizer;

static clast_status refuse(clast_context *context, const char *what)
{
    return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "clusterize: %s", what);
}

static clast_status check(clusterizer *c)
{
    const clast_clusterize_desc *desc = c->desc;
    c->limits.triangles = desc->max_triangles != 0 ? desc->max_triangles : CLUSTER_TRIANGLES;
    c->limits.vertices = desc->max_vertices != 0 ? desc->max_vertices : CLUSTER_VERTICES;
    if (c->limits.triangles > TEMPLATE_TRIANGLES) {
        return refuse(c->context, "max_triangles: expected 0 to 256");
    }
    if (c->limits.vertices < 3 || c->limits.vertices > TEMPLATE_VERTICES) {
        return refuse(c->context, "max_vertices: expected 0, or 3 to 256");
    }
    if (desc->triangle_count > UINT32_MAX - 1 || desc->position_count > UINT32_MAX - 1) {
        return refuse(c->context, "more than 4294967294 triangles or positions");
    }
    if (desc->triangle_count != 0 && (desc->indices == NULL || desc->positions == NULL)) {
        return refuse(c->context, "indices and positions: expected arrays, got null");
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- boxes

// A corner as far as it steers the cut: finite, and not so large that sums are not.
static inline lanes steering(const float *positions, uint32_t corner)
{
    lanes position = lanes_finite(positions + 3 * (size_t)corner);
    return lanes_max(lanes_min(position, lanes_all(CUT_FAR)), lanes_all(-CUT_FAR));
}

static void make_boxes(void *data, size_t begin, size_t end, uint32_t worker)
{
    clusterizer *c = data;
    const clast_clusterize_desc *desc = c->desc;
    lanes lower = c->centres[2 * worker], upper = c->centres[2 * worker + 1];
    for (size_t i = begin; i < end; i++) {
        const uint32_t *corner = desc->indices + 3 * i;
        if (corner[0] >= desc->position_count || corner[1] >= desc->position_count ||
            corner[2] >= desc->position_count) {
            atomic_store(&c->out_of_range, true);
            return;
        }
        lanes p = steering(desc->positions, corner[0]);
        lanes q = steering(desc->positions, corner[1]);
        lanes r = steering(desc->positions, corner[2]);
        cut_box *box = &c->boxes[i];
        lanes_store(&box->lower, lanes_min(lanes_min(p, q), r));
        lanes_store(&box->upper, lanes_max(lanes_max(p, q), r));
        box->lower.number = (uint32_t)i;
        box->upper.number = 0;
        lanes centre = cut_centre(box);
        lower = lanes_min(lower, centre);
        upper = lanes_max(upper, centre);
    }
    c->centres[2 * worker] = lower;
    c->centres[2 * worker + 1] = upper;
}

// The first of the triangles at fault, whatever thread came upon which.
static clast_status refuse_index(const clusterizer *c)
{
    const clast_clusterize_desc *desc = c->desc;
    for (size_t i = 0; i < 3 * desc->triangle_count; i++) {
        if (desc->indices[i] >= desc->position_count) {
            return clast_fail(c->context, CLAST_ERROR_INVALID_ARGUMENT,
                              "clusterize: triangle %zu has index %u, expected below %zu", i / 3, desc->indices[i],
                              desc->position_count);
        }
    }
    return refuse(c->context, "an index is out of range");
}

static clast_status bound_all(clusterizer *c, cut_range *range)
{
    size_t count = c->desc->triangle_count;
    uint32_t workers = clast_worker_count(c->context);
    c->boxes = clast_allocate(c->context, count, sizeof *c->boxes);
    c->centres = clast_allocate(c->context, workers, 2 * sizeof *c->centres);
    if (c->boxes == NULL || c->centres == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < workers; i++) {
        c->centres[2 * i] = box_none_lower();
        c->centres[2 * i + 1] = box_none_upper();
    }
    clast_parallel_for(c->context, count, TRIANGLE_GRAIN, make_boxes, c);
    if (atomic_load(&c->out_of_range)) {
        return refuse_index(c);
    }
    *range = (cut_range){0, (uint32_t)count, c->centres[0], c->centres[1]};
    for (uint32_t i = 1; i < workers; i++) {
        range->centre_lower = lanes_min(range->centre_lower, c->centres[2 * i]);
        range->centre_upper = lanes_max(range->centre_upper, c->centres[2 * i + 1]);
    }
    return CLAST_OK;
}

// ----------------------------------------------------------------------------------------------------------- cutting

static clast_status push_large(clusterizer *c, const cut_range *range)
{
    clast_status status = CLAST_RESERVE(c->context, c->large, c->large_capacity, c->large_count + 1);
    if (status == CLAST_OK) {
        c->large[c->large_count++] = *range;
    }
    return status;
}

static clast_status push_task(clusterizer *c, const cut_range *range)
{
    clast_status status = CLAST_RESERVE(c->context, c->tasks, c->task_capacity, c->task_count + 1);
    if (status == CLAST_OK) {
        c->tasks[c->task_count++] = (task){.range = *range};
    }
    return status;
}

// Cuts with all threads until each range is one thread's work. Tasks come in the order of the cut.
static clast_status cut_large(clusterizer *c, const cut_range *whole)
{
    clast_status status = push_large(c, whole);
    while (status == CLAST_OK && c->large_count != 0) {
        cut_range range = c->large[--c->large_count];
        if (range.count <= CUT_ALONE_MOST) {
            status = push_task(c, &range);
            continue;
        }
        cut_pair pair;
        status = clast_cut_in_two(c->context, c->boxes, &range, &c->limits, &pair);
        status = status == CLAST_OK ? push_large(c, &pair.right) : status;
        status = status == CLAST_OK ? push_large(c, &pair.left) : status;
    }
    return status;
}

static void cut_task(void *data, size_t begin, size_t end, uint32_t worker)
{
    clusterizer *c = data;
    group_job job = {c->boxes, c->desc->indices, c->limits, c->result->triangles, c->result->indices};
    group *scratch = (group *)(void *)(c->scratch + worker * clast_group_size());
    for (size_t i = begin; i < end; i++) {
        task *task = &c->tasks[i];
        cut_range stack[STACK_MOST];
        uint32_t size = 0;
        stack[size++] = task->range;
        while (size != 0) {
            cut_range range = stack[--size];
            if (range.count <= CUT_GROUP_MOST) {
                clast_group_cut(scratch, &job, range.begin, range.count, &task->cluster_count, &task->vertex_count);
                continue;
            }
            cut_pair pair;
            clast_cut_in_two_alone(c->boxes, &range, &c->limits, &pair);
            // The smaller side is cut first: the stack then holds halves of halves only.
            bool left_first = pair.left.count < pair.right.count;
            stack[size++] = left_first ? pair.right : pair.left;
            stack[size++] = left_first ? pair.left : pair.right;
        }
    }
}

static clast_status cut_all(clusterizer *c, const cut_range *whole)
{
    size_t count = c->desc->triangle_count;
    uint32_t workers = clast_worker_count(c->context);
    clast_status status = cut_large(c, whole);
    if (status != CLAST_OK) {
        return status;
    }
    c->result->triangles = clast_allocate(c->context, count, sizeof *c->result->triangles);
    c->result->indices = clast_allocate(c->context, count, 3);
    c->scratch = clast_allocate_zeroed(c->context, workers, clast_group_size());
    if (c->result->triangles == NULL || c->result->indices == NULL || c->scratch == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(c->context, c->task_count, 1, cut_task, c);
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------- gathering

static void gather_task(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clusterizer *c = data;
    clast_clusters *result = c->result;
    for (size_t i = begin; i < end; i++) {
        const task *task = &c->tasks[i];
        uint32_t triangle = task->range.begin, vertex = (uint32_t)task->first_vertex;
        for (uint32_t k = 0; k < task->cluster_count; k++) {
            uint32_t packed = c->boxes[triangle].upper.number;
            clast_cluster cluster = {triangle, packed >> 16, vertex, packed & 0xffff};
            result->clusters[task->first_cluster + k] = cluster;
            for (uint32_t t = 0; t < cluster.triangle_count; t++) {
                const uint32_t *corner = c->desc->indices + 3 * (size_t)result->triangles[triangle + t];
                const uint8_t *local = result->indices + 3 * (size_t)(triangle + t);
                for (uint32_t k3 = 0; k3 < 3; k3++) {
                    result->vertices[vertex + local[k3]] = corner[k3];
                }
            }
            triangle += cluster.triangle_count;
            vertex += cluster.vertex_count;
        }
    }
}

static clast_status gather(clusterizer *c)
{
    uint64_t vertices = 0;
    uint32_t clusters = 0;
    for (size_t i = 0; i < c->task_count; i++) {
        c->tasks[i].first_cluster = clusters;
        c->tasks[i].first_vertex = vertices;
        clusters += c->tasks[i].cluster_count;
        vertices += c->tasks[i].vertex_count;
    }
    if (vertices > UINT32_MAX) {
        return clast_fail(c->context, CLAST_ERROR_LIMIT,
                          "clusterize: %llu vertices of clusters, expected below 4294967296",
                          (unsigned long long)vertices);
    }
    c->result->cluster_count = clusters;
    c->result->vertex_count = (size_t)vertices;
    c->result->clusters = clast_allocate(c->context, clusters, sizeof *c->result->clusters);
    c->result->vertices = clast_allocate(c->context, (size_t)vertices, sizeof *c->result->vertices);
    if (c->result->clusters == NULL || c->result->vertices == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(c->context, c->task_count, 1, gather_task, c);
    return CLAST_OK;
}

clast_status clast_clusterize(clast_context *context, const clast_clusterize_desc *desc, clast_clusters *clusters)
{
    if (context == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (desc == NULL || clusters == NULL) {
        return refuse(context, "desc and clusters: expected pointers, got null");
    }
    *clusters = (clast_clusters){0};
    clusterizer c = {.context = context, .desc = desc, .result = clusters};
    clast_status status = check(&c);
    if (status == CLAST_OK && desc->triangle_count != 0) {
        cut_range whole;
        status = bound_all(&c, &whole);
        status = status == CLAST_OK ? cut_all(&c, &whole) : status;
        status = status == CLAST_OK ? gather(&c) : status;
    }
    clast_free(context, c.boxes);
    clast_free(context, c.centres);
    clast_free(context, c.tasks);
    clast_free(context, c.large);
    clast_free(context, c.scratch);
    if (status != CLAST_OK) {
        clast_clusters_free(context, clusters);
    }
    return status;
}

void clast_clusters_free(clast_context *context, clast_clusters *clusters)
{
    if (clusters == NULL) {
        return;
    }
    clast_free(context, clusters->clusters);
    clast_free(context, clusters->triangles);
    clast_free(context, clusters->indices);
    clast_free(context, clusters->vertices);
    *clusters = (clast_clusters){0};
}
