// SPDX-License-Identifier: Apache-2.0
// Surfaces cut into clusters of every kind.
#include "accel/watertight.h"
#include "clast/geometry.h"

const char *cluster_kind_name(cluster_kind kind)
{
    static const char *const names[CLUSTER_KINDS] = {"cut", "full",   "tiny",    "in turn",
                                                     "own", "mapped", "watched", "grids"};
    return names[kind];
}

typedef struct builder {
    const surface *s;
    clusters *c;
    size_t vertex_capacity, cluster_capacity;
    clast_template_desc *descs;
    clast_clas_input *inputs;
    bool own; // no templates: descs stay
    clast_clusters cut;
} builder;

static void gather(clusters *c, const surface *s)
{
    for (size_t i = 0; i < c->vertex_count; i++) {
        memcpy(c->vertices + 3 * i, s->m.positions + 3 * (size_t)c->sources[i], 12);
    }
}

// Adds a cluster without its template; gives where its sources go.
static uint32_t *add_cluster(builder *b, uint32_t vertex_count)
{
    clusters *c = b->c;
    if (c->cluster_count + 2 > b->cluster_capacity) {
        b->cluster_capacity = 2 * b->cluster_capacity + 64;
        c->firsts = realloc(c->firsts, 4 * b->cluster_capacity);
        b->inputs = realloc(b->inputs, b->cluster_capacity * sizeof *b->inputs);
        b->descs = realloc(b->descs, b->cluster_capacity * sizeof *b->descs);
    }
    if (c->vertex_count + vertex_count > b->vertex_capacity) {
        b->vertex_capacity = 2 * b->vertex_capacity + 4096;
        c->sources = realloc(c->sources, 4 * b->vertex_capacity);
    }
    c->firsts[c->cluster_count++] = (uint32_t)c->vertex_count;
    c->vertex_count += vertex_count;
    c->firsts[c->cluster_count] = (uint32_t)c->vertex_count;
    return c->sources + c->vertex_count - vertex_count;
}

// --------------------------------------------------------------------------------------------------------------- grids

// Vertex (i, j) of a sheet, from the corners of a quad that has it.
static uint32_t sheet_vertex(const surface *s, uint32_t sheet, uint32_t i, uint32_t j)
{
    uint32_t right = i == s->columns, top = j == s->rows;
    size_t quad = (size_t)sheet * s->columns * s->rows + (size_t)(j - top) * s->columns + (i - right);
    return s->m.indices[6 * quad + (right != 0 ? (top != 0 ? 2u : 1u) : (top != 0 ? 5u : 0u))];
}

// Cuts sheets into tiles of changing size, all from 1 x 1 to 11 x 11 in the end.
static clast_status add_grids(builder *b)
{
    static const uint32_t widths[] = {11, 3, 8, 1, 5, 2, 9, 10, 4, 7, 6};
    const surface *s = b->s;
    uint32_t turn = 0;
    for (uint32_t sheet = 0; sheet < s->sheets; sheet++) {
        for (uint32_t j = 0, rows; j < s->rows; j += rows) {
            rows = widths[turn++ % 11];
            rows = rows < s->rows - j ? rows : s->rows - j;
            for (uint32_t i = 0, columns; i < s->columns; i += columns) {
                columns = widths[turn++ % 11];
                columns = columns < s->columns - i ? columns : s->columns - i;
                uint32_t *sources = add_cluster(b, (columns + 1) * (rows + 1));
                for (uint32_t k = 0; k < (columns + 1) * (rows + 1); k++) {
                    sources[k] = sheet_vertex(s, sheet, i + k % (columns + 1), j + k / (columns + 1));
                }
                clast_status status = clast_template_set_add_grid(b->c->set, columns, rows,
                                                                  &b->inputs[b->c->cluster_count - 1].template_number);
                if (status != CLAST_OK) {
                    return status;
                }
            }
        }
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------ triangles

static clast_status add_templates(builder *b, bool with_rest, const float *rest)
{
    for (size_t i = 0; i < b->c->cluster_count; i++) {
        b->descs[i].rest_positions = with_rest ? rest + 3 * (size_t)b->c->firsts[i] : NULL;
    }
    uint32_t first = 0;
    clast_status status = clast_template_set_add(b->c->set, b->descs, b->c->cluster_count, &first);
    for (size_t i = 0; i < b->c->cluster_count; i++) {
        b->inputs[i].template_number = first + (uint32_t)i;
    }
    return status;
}

static float *rest_of(const builder *b)
{
    float *rest = malloc(12 * b->c->vertex_count + 12);
    for (size_t i = 0; i < b->c->vertex_count; i++) {
        memcpy(rest + 3 * i, b->s->m.positions + 3 * (size_t)b->c->sources[i], 12);
    }
    return rest;
}

static clast_status add_cut(builder *b, clast_context *context, uint32_t most, bool with_rest)
{
    clast_clusterize_desc desc = {.positions = b->s->m.positions,
                                  .position_count = b->s->m.vertex_count,
                                  .indices = b->s->m.indices,
                                  .triangle_count = b->s->m.triangle_count,
                                  .max_triangles = most,
                                  .max_vertices = most < 3 ? 3 : most};
    clast_status status = clast_clusterize(context, &desc, &b->cut);
    if (status != CLAST_OK) {
        return status;
    }
    const clast_clusters *cut = &b->cut;
    for (size_t i = 0; i < cut->cluster_count; i++) {
        const clast_cluster *cluster = &cut->clusters[i];
        uint32_t *sources = add_cluster(b, cluster->vertex_count);
        memcpy(sources, cut->vertices + cluster->first_vertex, 4 * (size_t)cluster->vertex_count);
        b->descs[i] = (clast_template_desc){cluster->triangle_count, cluster->vertex_count,
                                            cut->indices + 3 * (size_t)cluster->first_triangle, NULL};
    }
    if (b->own) {
        return CLAST_OK;
    }
    float *rest = rest_of(b);
    status = add_templates(b, with_rest, rest);
    free(rest);
    return status;
}

static clast_status add_in_turn(builder *b, uint32_t most)
{
    const mesh *m = &b->s->m;
    uint8_t *indices = malloc(3 * (size_t)m->triangle_count + 3);
    uint16_t *local = malloc(sizeof *local * ((size_t)m->vertex_count + 1));
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        local[i] = 256;
    }
    for (uint32_t first = 0; first < m->triangle_count;) {
        uint32_t sources[256], source_count, count;
        count = cluster_cut(m, first, most, local, indices + 3 * (size_t)first, sources, &source_count);
        memcpy(add_cluster(b, source_count), sources, 4 * (size_t)source_count);
        b->descs[b->c->cluster_count - 1] = (clast_template_desc){count, source_count, indices + 3 * (size_t)first,
                                                                  NULL};
        first += count;
    }
    float *rest = rest_of(b);
    clast_status status = add_templates(b, true, rest);
    free(rest);
    free(indices);
    free(local);
    return status;
}

// ---------------------------------------------------------------------------------------------------------------- all

static clast_status fill(clast_context *context, builder *b, cluster_kind kind)
{
    switch (kind) {
    case CLUSTERS_GRIDS: return add_grids(b);
    case CLUSTERS_IN_TURN: return add_in_turn(b, 100);
    case CLUSTERS_OWN: return add_cut(b, context, 140, false);
    case CLUSTERS_TINY: return add_cut(b, context, 5, true);
    case CLUSTERS_FULL: return add_cut(b, context, 256, false);
    default: return add_cut(b, context, 128, true);
    }
}

// Into the pool: by templates, or by triangles of their own.
static clast_status fill_pool(builder *b)
{
    clusters *c = b->c;
    c->vertices = malloc(12 * c->vertex_count + 12);
    c->templates = calloc(c->cluster_count + 1, 4);
    gather(c, b->s);
    clast_clas_desc *own = calloc(c->cluster_count + 1, sizeof *own);
    for (size_t i = 0; i < c->cluster_count; i++) {
        const float *vertices = c->vertices + 3 * (size_t)c->firsts[i];
        if (b->own) {
            own[i] = (clast_clas_desc){b->descs[i].triangle_count, b->descs[i].vertex_count, b->descs[i].indices,
                                       vertices, 0};
        } else {
            b->inputs[i].vertices = vertices;
            c->templates[i] = b->inputs[i].template_number;
        }
    }
    clast_status status = b->own ? clast_clas_build(c->pool, 0, c->cluster_count, own)
                                 : clast_clas_instantiate(c->pool, 0, c->cluster_count, b->inputs);
    free(own);
    return status;
}

// Writes the tree as a block, and uses that from now on.
static clast_status map_block(clusters *c)
{
    uint64_t bytes = 0;
    clast_blas_destroy(c->mapped);
    free(c->block);
    c->block = NULL;
    c->mapped = NULL;
    clast_status status = clast_blas_serialise(c->tree, NULL, 0, &bytes);
    if (status == CLAST_OK) {
        c->block = aligned_alloc(64, (size_t)(bytes + 63) & ~(size_t)63);
        status = clast_blas_serialise(c->tree, c->block, (size_t)bytes, &bytes);
    }
    status = status == CLAST_OK ? clast_blas_map(c->context, c->block, (size_t)bytes, true, &c->mapped) : status;
    c->blas = c->mapped;
    return status;
}

static clast_status make_deforming(clusters *c, const surface *s)
{
    clast_deforming_mesh_desc desc = {.positions = s->m.positions,
                                      .position_count = s->m.vertex_count,
                                      .indices = s->m.indices,
                                      .triangle_count = s->m.triangle_count};
    clast_status status = clast_deforming_mesh_create(c->context, &desc, &c->deforming);
    c->vertices = malloc(12 * (size_t)s->m.vertex_count + 12); // where they were
    memcpy(c->vertices, s->m.positions, 12 * (size_t)s->m.vertex_count);
    c->blas = status == CLAST_OK ? clast_deforming_mesh_blas(c->deforming) : NULL;
    return status;
}

// In many steps, so that there is time to cut much of it anew.
static clast_status deform(clusters *c, const surface *s)
{
    enum { STEPS = 8 };
    float *between = malloc(12 * (size_t)s->m.vertex_count + 12);
    clast_status status = CLAST_OK;
    for (uint32_t step = 1; step <= 2 * STEPS && status == CLAST_OK; step++) {
        float part = step < STEPS ? (float)step / (float)STEPS : 1.0f;
        for (size_t i = 0; i < 3 * (size_t)s->m.vertex_count; i++) {
            float to = s->m.positions[i];
            between[i] = part == 1.0f ? to : c->vertices[i] + part * (to - c->vertices[i]);
        }
        status = clast_deforming_mesh_update(c->deforming, between, NULL);
    }
    free(between);
    return status;
}

clast_status clusters_make(clast_context *context, const surface *s, cluster_kind kind, clast_build build, clusters *c)
{
    *c = (clusters){.context = context};
    builder b = {.s = s, .c = c, .own = kind == CLUSTERS_OWN};
    if (kind == CLUSTERS_WATCHED) {
        return make_deforming(c, s);
    }
    clast_status status = clast_template_set_create(context, &c->set);
    status = status == CLAST_OK ? clast_clas_pool_create(c->set, &c->pool) : status;
    status = status == CLAST_OK ? clast_blas_create(c->pool, &c->tree) : status;
    status = status == CLAST_OK ? fill(context, &b, kind) : status;
    status = status == CLAST_OK ? fill_pool(&b) : status;
    status = status == CLAST_OK ? clast_blas_build(c->tree, NULL, c->cluster_count, build) : status;
    c->blas = c->tree;
    clast_clusters_free(context, &b.cut);
    free(b.descs);
    free(b.inputs);
    return status == CLAST_OK && kind == CLUSTERS_MAPPED ? map_block(c) : status;
}

clast_status clusters_refit(clusters *c, const surface *s)
{
    if (c->deforming != NULL) {
        return deform(c, s);
    }
    clast_clas_gather from = {s->m.positions, s->m.vertex_count, c->sources, c->firsts, c->vertices};
    clast_status status;
    if (c->cluster_count % 2 == 0) { // one way or the other
        status = clast_clas_refit_gathered(c->pool, 0, c->cluster_count, &from);
    } else {
        gather(c, s);
        status = clast_clas_refit(c->pool, 0, c->cluster_count);
    }
    status = status == CLAST_OK ? clast_blas_refit(c->tree) : status;
    return status == CLAST_OK && c->block != NULL ? map_block(c) : status;
}

void clusters_corners(const clusters *c, uint32_t cluster, uint32_t triangle, uint32_t corners[3])
{
    clast_template_triangle(c->set, c->templates[cluster], triangle, corners);
    for (int k = 0; k < 3; k++) {
        corners[k] = c->sources[c->firsts[cluster] + corners[k]];
    }
}

void clusters_free(clusters *c)
{
    clast_deforming_mesh_destroy(c->deforming);
    clast_blas_destroy(c->mapped);
    clast_blas_destroy(c->tree);
    free(c->block);
    clast_clas_pool_destroy(c->pool);
    clast_template_set_destroy(c->set);
    free(c->vertices);
    free(c->sources);
    free(c->firsts);
    free(c->templates);
}
