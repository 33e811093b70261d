// SPDX-License-Identifier: Apache-2.0
// What is done once for each mesh, beside meshoptimizer, on the same meshes.
//
//   weld            equal positions found; meshoptimizer's vertex remap
//   clusterize      clusters of at most 128 triangles and 128 positions; meshoptimizer's meshlets (one thread)
//   cook            from a mesh whose triangles share no vertices to clusters with a tree each; meshoptimizer's remap and meshlets
//   cluster_fill    how full clusters are of what limits them, on average
//   cluster_area    the sum of the areas of their boxes, in areas of the mesh's box: what a ray meets
//
// Meshes: a displaced sphere and a terrain.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <meshoptimizer.h>

#include "accel/meshes.h"
#include "bench.h"
#include "clast/clast.h"
#include "cook/cook.h"
#include "scene/scene.h"

enum { LIMIT = 128 };

typedef struct job {
    clast_context *context;
    mesh shared; // vertices shared by triangles
    mesh apart;  // the same, three vertices for each triangle
    uint32_t *remap;
} job;

typedef struct figures {
    double fill, area;
} figures;

// ---------------------------------------------------------------------------------------------------------------- meshes

static float height_at(float x, float y)
{
    float height = 0.0f, size = 0.12f, frequency = 5.0f;
    for (int octave = 0; octave < 6; octave++) {
        height += size * sinf(frequency * x + (float)octave) * cosf(1.1f * frequency * y - (float)octave);
        size *= 0.5f;
        frequency *= 2.1f;
    }
    return height;
}

static mesh make_sphere(uint32_t triangles)
{
    uint32_t rows = (uint32_t)sqrt((double)triangles / 4.0);
    mesh m = mesh_sphere(2 * rows, rows + 1);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i;
        float factor = 1.0f + 0.4f * height_at(4.0f * p[0] + p[2], 4.0f * p[1] - p[2]);
        for (int axis = 0; axis < 3; axis++) {
            p[axis] *= factor;
        }
    }
    return m;
}

static mesh make_terrain(uint32_t triangles)
{
    mesh m = mesh_terrain((uint32_t)sqrt((double)triangles / 2.0), 0.0f, 1);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i;
        p[2] = height_at(p[0], p[1]);
    }
    return m;
}

static mesh take_apart(const mesh *m)
{
    mesh apart = mesh_of(3 * m->triangle_count, m->triangle_count);
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        memcpy(apart.positions + 3 * i, m->positions + 3 * (size_t)m->indices[i], 12);
        apart.indices[i] = (uint32_t)i;
    }
    return apart;
}

// --------------------------------------------------------------------------------------------------------------- figures

typedef struct box {
    float lower[3], upper[3];
} box;

static box empty_box(void)
{
    return (box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static void extend(box *b, const float *p)
{
    for (int axis = 0; axis < 3; axis++) {
        b->lower[axis] = fminf(b->lower[axis], p[axis]);
        b->upper[axis] = fmaxf(b->upper[axis], p[axis]);
    }
}

static double area(const box *b)
{
    double x = b->upper[0] - b->lower[0], y = b->upper[1] - b->lower[1], z = b->upper[2] - b->lower[2];
    return x * y + y * z + z * x;
}

static void add_cluster(figures *f, const mesh *m, const uint32_t *vertices, uint32_t vertex_count,
                        uint32_t triangle_count)
{
    box b = empty_box();
    for (uint32_t i = 0; i < vertex_count; i++) {
        extend(&b, m->positions + 3 * (size_t)vertices[i]);
    }
    f->area += area(&b);
    f->fill += (double)(triangle_count > vertex_count ? triangle_count : vertex_count) / LIMIT;
}

static figures finish(figures f, const mesh *m, size_t cluster_count)
{
    box b = empty_box();
    for (size_t i = 0; i < m->vertex_count; i++) {
        extend(&b, m->positions + 3 * i);
    }
    return (figures){f.fill / (double)cluster_count, f.area / area(&b)};
}

// ----------------------------------------------------------------------------------------------------------------- ours

static double weld_ours(void *data)
{
    job *j = data;
    size_t unique;
    double before = bench_seconds();
    bench_check(clast_weld_positions(j->context, j->apart.positions, j->apart.vertex_count, j->remap, &unique),
                j->context);
    return bench_seconds() - before;
}

static double cut_ours(job *j, figures *f)
{
    const mesh *m = &j->shared;
    clast_clusterize_desc desc = {m->positions, m->vertex_count, m->indices, m->triangle_count, LIMIT, LIMIT};
    clast_clusters c;
    double before = bench_seconds();
    bench_check(clast_clusterize(j->context, &desc, &c), j->context);
    double seconds = bench_seconds() - before;
    if (f != NULL) {
        *f = (figures){0.0, 0.0};
        for (size_t i = 0; i < c.cluster_count; i++) {
            const clast_cluster *cluster = &c.clusters[i];
            add_cluster(f, m, c.vertices + cluster->first_vertex, cluster->vertex_count, cluster->triangle_count);
        }
        *f = finish(*f, m, c.cluster_count);
    }
    clast_clusters_free(j->context, &c);
    return seconds;
}

static double clusterize_ours(void *data)
{
    return cut_ours(data, NULL);
}

// The scene keeps a copy of the mesh; that is made before the clock starts.
static double cook_ours(void *data)
{
    job *j = data;
    clast_scene *scene;
    clast_cooked *cooked;
    uint32_t geometry;
    clast_mesh m = {
        .vertex_count = j->apart.vertex_count,
        .triangle_count = j->apart.triangle_count,
        .positions = j->apart.positions,
        .indices = j->apart.indices,
        .material = CLAST_NONE,
    };
    bench_check(clast_scene_create(j->context, &scene), j->context);
    bench_check(clast_scene_add_mesh(scene, &m, "mesh", &geometry), j->context);
    bench_check(clast_cooked_create(j->context, &cooked), j->context);
    double before = bench_seconds();
    bench_check(clast_cooked_update(cooked, scene), j->context);
    double seconds = bench_seconds() - before;
    clast_cooked_destroy(cooked);
    clast_scene_destroy(scene);
    return seconds;
}

// --------------------------------------------------------------------------------------------------------------- theirs

static double weld_theirs(void *data)
{
    job *j = data;
    double before = bench_seconds();
    meshopt_generateVertexRemap(j->remap, NULL, j->apart.vertex_count, j->apart.positions, j->apart.vertex_count, 12);
    return bench_seconds() - before;
}

static double cut_theirs(const mesh *m, const uint32_t *indices, const float *positions, size_t vertex_count,
                         figures *f)
{
    double before = bench_seconds();
    size_t bound = meshopt_buildMeshletsBound(3 * (size_t)m->triangle_count, LIMIT, LIMIT);
    struct meshopt_Meshlet *meshlets = malloc(bound * sizeof *meshlets);
    uint32_t *vertices = malloc(bound * LIMIT * sizeof *vertices);
    unsigned char *corners = malloc(bound * LIMIT * 3);
    size_t count = meshopt_buildMeshlets(meshlets, vertices, corners, indices, 3 * (size_t)m->triangle_count, positions,
                                         vertex_count, 12, LIMIT, LIMIT, 0.0f);
    double seconds = bench_seconds() - before;
    if (f != NULL) {
        *f = (figures){0.0, 0.0};
        for (size_t i = 0; i < count; i++) {
            add_cluster(f, m, vertices + meshlets[i].vertex_offset, meshlets[i].vertex_count,
                        meshlets[i].triangle_count);
        }
        *f = finish(*f, m, count);
    }
    free(meshlets);
    free(vertices);
    free(corners);
    return seconds;
}

static double clusterize_theirs(void *data)
{
    const job *j = data;
    return cut_theirs(&j->shared, j->shared.indices, j->shared.positions, j->shared.vertex_count, NULL);
}

static double cook_theirs(void *data)
{
    job *j = data;
    const mesh *m = &j->apart;
    double before = bench_seconds();
    size_t unique = meshopt_generateVertexRemap(j->remap, NULL, m->vertex_count, m->positions, m->vertex_count, 12);
    uint32_t *indices = malloc((size_t)m->vertex_count * sizeof *indices);
    float *positions = malloc(unique * 12);
    meshopt_remapIndexBuffer(indices, NULL, m->vertex_count, j->remap);
    meshopt_remapVertexBuffer(positions, m->positions, m->vertex_count, 12, j->remap);
    double seconds = bench_seconds() - before;
    seconds += cut_theirs(m, indices, positions, unique, NULL);
    free(indices);
    free(positions);
    return seconds;
}

// -------------------------------------------------------------------------------------------------------------- measuring

static void add_speed(bench *b, bench_row row, const char *metric, const char *unit, double count, bench_pair seconds)
{
    row.metric = metric;
    row.unit = unit;
    row.clast = count * 1e-6 / seconds.clast;
    row.peer_value = count * 1e-6 / seconds.peer;
    bench_add(b, row);
}

static void measure(bench *b, job *j, const char *name, uint32_t threads)
{
    bench_row row = {.triangles = j->shared.triangle_count, .threads = threads, .peer = "meshoptimizer"};
    snprintf(row.workload, sizeof row.workload, "%s", name);
    double triangles = j->shared.triangle_count;
    bench_check(clast_context_create(&(clast_context_desc){.threads = threads}, &j->context), NULL);
    add_speed(b, row, "weld", "Mvertices/s", 3.0 * triangles, bench_alternate(b, weld_ours, weld_theirs, j));
    add_speed(b, row, "clusterize", "Mtri/s", triangles, bench_alternate(b, clusterize_ours, clusterize_theirs, j));
    add_speed(b, row, "cook", "Mtri/s", triangles, bench_alternate(b, cook_ours, cook_theirs, j));
    figures ours, theirs;
    cut_ours(j, &ours);
    cut_theirs(&j->shared, j->shared.indices, j->shared.positions, j->shared.vertex_count, &theirs);
    row.metric = "cluster_fill";
    row.unit = "of the limit";
    row.clast = ours.fill;
    row.peer_value = theirs.fill;
    bench_add(b, row);
    row.metric = "cluster_area";
    row.unit = "mesh boxes";
    row.less_is_better = true;
    row.clast = ours.area;
    row.peer_value = theirs.area;
    bench_add(b, row);
    clast_context_destroy(j->context);
}

static void measure_all(bench *b, const char *name, mesh m)
{
    job j = {.shared = m, .apart = take_apart(&m)};
    j.remap = malloc((size_t)j.apart.vertex_count * sizeof *j.remap);
    for (uint32_t threads = 1; threads <= 2 && bench_wants(b, name); threads++) {
        if (b->options.threads == 0 || threads == 1) {
            measure(b, &j, name, b->options.threads == 0 ? threads : b->options.threads);
        }
    }
    mesh_free(&j.shared);
    mesh_free(&j.apart);
    free(j.remap);
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "cook", count, arguments);
    uint32_t sizes[2] = {1000000, 4000000}, size_count = b.options.quick ? 1 : 2;
    if (b.options.triangles != 0) {
        sizes[0] = b.options.triangles;
        size_count = 1;
    }
    for (uint32_t i = 0; i < size_count; i++) {
        measure_all(&b, "displaced sphere", make_sphere(sizes[i]));
        measure_all(&b, "terrain", make_terrain(sizes[i]));
    }
    return bench_end(&b);
}
