// SPDX-License-Identifier: Apache-2.0
// Clusters of a mesh: cells of its triangles (cells.c), parted into groups (cut.c), cut into clusters (group.c),
// gathered into arrays.
#include <math.h>

#include "base/thread.h"
#include "geometry/cells.h"
#include "geometry/cut.h"
#include "shared/limits.h"

enum { STACK_MOST = 64, STACK_DEEP = 40, TASK_LEAST = 4096, TASK_MOST = 32768, TASKS_WANTED = 16, SCRATCH_LINE = 64 };

// Smaller meshes are done before anyone could cancel.
enum { PROGRESS_LEAST = 1 << 18 };

// A range that one thread cuts to the end.
typedef struct task {
    cut_range range;
    group_output output;
    uint32_t first_cluster;
    uint64_t first_vertex;
} task;

typedef struct clusterizer {
    clast_context *context;
    const clast_clusterize_desc *desc;
    cut_limits limits;
    cells cells;
    task *tasks;
    size_t task_count, task_capacity;
    size_t batch;     // the first task of those under way
    cut_range *large; // still to be cut by all threads
    size_t large_count, large_capacity;
    unsigned char *scratch; // for each worker, a group and the boxes of a task's triangles
    size_t group_bytes, scratch_bytes;
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
        uint32_t *words = (uint32_t *)(void *)(c->cells.spare + range->first);
        group_output output = {words, 2 * (size_t)range->triangles, range->triangles, 0, 0, true};
        c->tasks[c->task_count++] = (task){.range = *range, .output = output};
    }
    return status;
}

static size_t task_most(const clusterizer *c)
{
    size_t most = c->desc->triangle_count / TASKS_WANTED;
    return most < TASK_LEAST ? TASK_LEAST : most > TASK_MOST ? TASK_MOST : most;
}

// Cuts with all threads until each range is one thread's work. Tasks come in the order of the cut.
static clast_status cut_large(clusterizer *c)
{
    clast_status status = push_large(c, &c->cells.whole);
    while (status == CLAST_OK && c->large_count != 0) {
        cut_range range = c->large[--c->large_count];
        if (range.triangles <= task_most(c)) {
            status = push_task(c, &range);
            continue;
        }
        cut_pair pair;
        status = clast_cut_in_two(c->context, c->cells.boxes, &range, &c->limits, &pair);
        status = status == CLAST_OK ? push_large(c, &pair.right) : status;
        status = status == CLAST_OK ? push_large(c, &pair.left) : status;
    }
    return status;
}

// The boxes of the triangles of a task's cells.
static void expand_cells(const clusterizer *c, const cut_range *range, cut_box *boxes, cut_range *expanded)
{
    uint32_t count = 0;
    for (uint32_t i = range->begin; i < range->begin + range->count; i++) {
        const cut_corner *lower = &c->cells.boxes[i].lower, *upper = &c->cells.boxes[i].upper;
        for (uint32_t k = lower->number; k < lower->number + upper->number; k++) {
            boxes[count++].lower.number = (uint32_t)c->cells.order[k];
        }
    }
    *expanded = (cut_range){0, count, range->first, count, box_none_lower(), box_none_upper()};
    for (uint32_t i = 0; i < count; i++) {
        cells_prefetch(c->desc, boxes[i + CELLS_LATER < count ? i + CELLS_LATER : count - 1].lower.number,
                       boxes[i + CELLS_SOON < count ? i + CELLS_SOON : count - 1].lower.number);
        uint32_t triangle = boxes[i].lower.number;
        lanes_box box = steering_box(c->desc->positions, c->desc->indices + 3 * (size_t)triangle, c->cells.tame);
        lanes_store(&boxes[i].lower, box.lower);
        lanes_store(&boxes[i].upper, box.upper);
        boxes[i].lower.number = triangle;
        boxes[i].upper.number = 1;
        lanes centre = lanes_add(box.lower, box.upper);
        expanded->centre_lower = lanes_min(expanded->centre_lower, centre);
        expanded->centre_upper = lanes_max(expanded->centre_upper, centre);
    }
}

static void cut_task(void *data, size_t begin, size_t end, uint32_t worker)
{
    clusterizer *c = data;
    group *scratch = (group *)(void *)(c->scratch + worker * c->scratch_bytes);
    cut_box *boxes = (cut_box *)(void *)(c->scratch + worker * c->scratch_bytes + c->group_bytes);
    group_job job = {boxes, c->desc->indices, c->result->triangles, c->result->indices};
    for (size_t i = c->batch + begin; i < c->batch + end; i++) {
        task *task = &c->tasks[i];
        cut_range stack[STACK_MOST];
        uint32_t size = 0;
        expand_cells(c, &task->range, boxes, &stack[size++]);
        while (size != 0) {
            cut_range range = stack[--size];
            if (range.triangles <= CUT_GROUP_MOST) {
                clast_group_cut(scratch, &job, &range, &task->output);
                continue;
            }
            cut_pair pair;
            if (size < STACK_DEEP) {
                clast_cut_in_two_alone(boxes, &range, &c->limits, &pair);
            } else { // a mesh made to be cut a little at a time
                clast_cut_halve(boxes, &range, &c->limits, &pair);
            }
            stack[size++] = pair.right;
            stack[size++] = pair.left;
        }
    }
}

// In batches, between which the caller may cancel.
static clast_status cut_tasks(clusterizer *c)
{
    enum { BATCH = 256 };
    clast_status status = CLAST_OK;
    for (c->batch = 0; c->batch < c->task_count && status == CLAST_OK; c->batch += BATCH) {
        size_t left = c->task_count - c->batch;
        if (c->batch != 0) {
            status = clast_progress(c->context, "clusterize", c->tasks[c->batch].range.first, c->desc->triangle_count);
        }
        if (status == CLAST_OK) {
            clast_parallel_for(c->context, left < BATCH ? left : BATCH, 1, cut_task, c);
        }
    }
    return status;
}

static clast_status cut_all(clusterizer *c)
{
    size_t count = c->desc->triangle_count;
    uint32_t workers = clast_worker_count(c->context);
    clast_status status = cut_large(c);
    if (status != CLAST_OK) {
        return status;
    }
    c->result->triangles = clast_allocate(c->context, count, sizeof *c->result->triangles);
    c->result->indices = clast_allocate(c->context, count, 3);
    size_t most = count < task_most(c) ? count : task_most(c);
    c->group_bytes = (clast_group_size() + SCRATCH_LINE - 1) / SCRATCH_LINE * SCRATCH_LINE;
    c->scratch_bytes = c->group_bytes + (most * sizeof(cut_box) + SCRATCH_LINE - 1) / SCRATCH_LINE * SCRATCH_LINE;
    c->scratch = clast_allocate(c->context, workers, c->scratch_bytes);
    if (c->result->triangles == NULL || c->result->indices == NULL || c->scratch == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < workers; i++) {
        clast_group_begin((group *)(void *)(c->scratch + i * c->scratch_bytes), &c->limits);
    }
    return cut_tasks(c);
}

// --------------------------------------------------------------------------------------------------------- gathering

// The vertices of a cluster whose task had no room for them.
static void find_vertices(const clusterizer *c, const clast_cluster *cluster)
{
    const clast_clusters *result = c->result;
    for (uint32_t t = cluster->first_triangle; t < cluster->first_triangle + cluster->triangle_count; t++) {
        const uint32_t *corner = c->desc->indices + 3 * (size_t)result->triangles[t];
        for (uint32_t k = 0; k < 3; k++) {
            result->vertices[cluster->first_vertex + result->indices[3 * (size_t)t + k]] = corner[k];
        }
    }
}

static void gather_task(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clusterizer *c = data;
    clast_clusters *result = c->result;
    for (size_t i = begin; i < end; i++) {
        const task *task = &c->tasks[i];
        const group_output *output = &task->output;
        uint32_t triangle = task->range.first, vertex = (uint32_t)task->first_vertex;
        if (output->vertices_fit) {
            memcpy(result->vertices + vertex, output->words, output->vertices * sizeof *result->vertices);
        }
        for (uint32_t k = 0; k < output->clusters; k++) {
            uint32_t packed = output->words[output->word_count - 1 - k];
            clast_cluster cluster = {triangle, packed >> 16, vertex, packed & 0xffff};
            result->clusters[task->first_cluster + k] = cluster;
            if (!output->vertices_fit) {
                find_vertices(c, &cluster);
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
        clusters += (uint32_t)c->tasks[i].output.clusters;
        vertices += c->tasks[i].output.vertices;
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
        status = clast_cells_make(context, desc, &c.cells);
        if (status == CLAST_OK && desc->triangle_count >= PROGRESS_LEAST) {
            status = clast_progress(context, "clusterize", 0, desc->triangle_count);
        }
        status = status == CLAST_OK ? cut_all(&c) : status;
        status = status == CLAST_OK ? gather(&c) : status;
    }
    clast_cells_free(context, &c.cells);
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
