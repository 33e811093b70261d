// SPDX-License-Identifier: Apache-2.0
// Clusters of displaced meshes: their triangles and edges, whom these belong to, and their templates.
#include "source/displaced_cook.h"

#include "accel/patterns.h"
#include "base/size.h"
#include "base/thread.h"

enum {
    CLUSTER_GRAIN = 32,
    EDGE_SLOTS = 1024, // of a cluster's table of edges: more than twice as many as it has
};

// ----------------------------------------------------------------------------------------------------------- owners

// By side (3 * triangle + edge): the lowest side of the same edge. And whether each edge has as many triangles to either side.
static clast_status find_edge_owners(displaced_cook *cook, uint32_t *owners)
{
    displaced_unit *unit = cook->unit;
    const clast_mesh *mesh = cook->mesh;
    size_t count = 3 * (size_t)mesh->triangle_count;
    uint64_t *keys = clast_allocate(cook->context, count, sizeof *keys);
    uint32_t *sides = clast_allocate(cook->context, count, sizeof *sides);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (keys != NULL && sides != NULL) {
        for (size_t i = 0; i < count; i++) {
            uint64_t a = unit->vertex_of[mesh->indices[i]];
            uint64_t b = unit->vertex_of[mesh->indices[i % 3 == 2 ? i - 2 : i + 1]];
            keys[i] = a < b ? a << 32 | b : b << 32 | a;
            sides[i] = (uint32_t)i;
        }
        status = clast_sort_pairs(cook->context, keys, sides, count);
    }
    unit->closed = true;
    for (size_t first = 0, end = 0; status == CLAST_OK && first < count; first = end) {
        uint32_t begin = unit->vertex_of[mesh->indices[sides[first]]];
        size_t alike = 0;
        for (end = first; end < count && keys[end] == keys[first]; end++) {
            owners[sides[end]] = sides[first]; // the sort is stable
            alike += unit->vertex_of[mesh->indices[sides[end]]] == begin;
        }
        bool point = keys[first] >> 32 == (keys[first] & 0xffffffffu);
        unit->closed = unit->closed && (point || 2 * alike == end - first);
    }
    clast_free(cook->context, keys);
    clast_free(cook->context, sides);
    return status;
}

// --------------------------------------------------------------------------------------------------------- clusters

// A cluster's edges by their owners.
typedef struct edge_table {
    uint32_t count;
    uint32_t owners[DISPLACED_EDGES];
    uint16_t slots[EDGE_SLOTS]; // edge plus one; 0 is free
} edge_table;

static uint32_t find_edge(edge_table *table, uint32_t owner)
{
    uint32_t slot = owner * 2654435761u % EDGE_SLOTS;
    while (table->slots[slot] != 0 && table->owners[table->slots[slot] - 1] != owner) {
        slot = (slot + 1) % EDGE_SLOTS;
    }
    if (table->slots[slot] == 0) {
        table->owners[table->count] = owner;
        table->slots[slot] = (uint16_t)++table->count;
    }
    return table->slots[slot] - 1u;
}

typedef struct cluster_job {
    displaced_cook *cook;
    const uint32_t *owners;
    uint32_t *edge_counts; // by cluster: then where its edges begin
    uint32_t *seam_counts;
    bool counts_only;
} cluster_job;

// What a side has at its two ends.
typedef struct side_site {
    vec2 coordinates[2];
    uint32_t map;
} side_site;

static side_site site_of_side(const displaced_cook *cook, uint32_t side)
{
    const displaced_unit *unit = cook->unit;
    side_site site = {.map = displaced_map_of(unit, side / 3)};
    const displaced_map *map = &unit->maps[site.map];
    uint32_t next = side % 3 == 2 ? side - 2 : side + 1;
    site.coordinates[0] = clast_displaced_coordinates(map, cook->mesh, cook->mesh->indices[side]);
    site.coordinates[1] = clast_displaced_coordinates(map, cook->mesh, cook->mesh->indices[next]);
    return site;
}

static bool same_place(vec2 a, vec2 b)
{
    return a[0] == b[0] && a[1] == b[1];
}

static uint32_t first_end(const displaced_cook *cook, uint32_t side)
{
    return cook->unit->vertex_of[cook->mesh->indices[side]];
}

// Whether a side has what its edge's owner has.
static bool is_as_owner(const displaced_cook *cook, uint32_t side, uint32_t owner)
{
    if (side == owner) {
        return true;
    }
    side_site own = site_of_side(cook, side), owners = site_of_side(cook, owner);
    bool along = first_end(cook, side) == first_end(cook, owner);
    return own.map == owners.map && same_place(own.coordinates[0], owners.coordinates[along ? 0 : 1]) &&
           same_place(own.coordinates[1], owners.coordinates[along ? 1 : 0]);
}

// Whether a corner has what the vertex's owner has.
static bool is_as_vertex(const displaced_cook *cook, uint32_t side)
{
    const displaced_vertex *vertex = &cook->unit->vertices[first_end(cook, side)];
    side_site own = site_of_side(cook, side);
    return own.map == vertex->map && same_place(own.coordinates[0], load2(vertex->coordinates));
}

static bool is_plain(const displaced_cook *cook, const uint32_t *owners, uint32_t mesh_triangle)
{
    bool plain = true;
    for (uint32_t side = 3 * mesh_triangle; side < 3 * mesh_triangle + 3; side++) {
        plain = plain && is_as_owner(cook, side, owners[side]) && is_as_vertex(cook, side);
    }
    return plain;
}

// The edges of a cluster, and which of them have a seam.
static uint32_t gather_edges(const cluster_job *job, size_t number, edge_table *table, bool seams[DISPLACED_EDGES])
{
    const displaced_cook *cook = job->cook;
    clast_cluster from = cook->clusters.clusters[number];
    memset(table, 0, sizeof *table);
    memset(seams, 0, DISPLACED_EDGES * sizeof *seams);
    uint32_t seam_count = 0;
    for (uint32_t t = from.first_triangle; t < from.first_triangle + from.triangle_count; t++) {
        for (uint32_t side = 3 * cook->clusters.triangles[t], k = 0; k < 3; side++, k++) {
            uint32_t edge = find_edge(table, job->owners[side]);
            if (!seams[edge] && !is_as_owner(cook, side, job->owners[side])) {
                seams[edge] = true;
                seam_count++;
            }
        }
    }
    return seam_count;
}

// The number in a cluster of a vertex of the mesh, by the corner of a triangle of the cluster that has it.
typedef struct edge_ends {
    uint8_t ends[2];
} edge_ends;

static float middle_height(const displaced_cook *cook, uint32_t owner)
{
    const displaced_unit *unit = cook->unit;
    side_site site = site_of_side(cook, owner);
    uint32_t next = owner % 3 == 2 ? owner - 2 : owner + 1;
    const displaced_vertex *a = &unit->vertices[first_end(cook, owner)];
    const displaced_vertex *b = &unit->vertices[first_end(cook, next)];
    float level = vertex_rest_level((a->density_square + b->density_square) * 0.5f,
                                    (a->shortest_square + b->shortest_square) * 0.5f);
    vec2 middle = (site.coordinates[0] + site.coordinates[1]) * 0.5f;
    return clast_displaced_height(&unit->maps[site.map], middle, level);
}

static void write_triangles(const cluster_job *job, size_t number, edge_table *table, edge_ends *ends)
{
    displaced_cook *cook = job->cook;
    displaced_unit *unit = cook->unit;
    clast_cluster from = cook->clusters.clusters[number];
    for (uint32_t t = from.first_triangle; t < from.first_triangle + from.triangle_count; t++) {
        uint32_t mesh_triangle = cook->clusters.triangles[t];
        const uint8_t *corners = cook->clusters.indices + 3 * (size_t)t;
        displaced_triangle triangle = {0};
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t side = 3 * mesh_triangle + k, owner = job->owners[side];
            uint32_t edge = find_edge(table, owner);
            bool along = first_end(cook, side) == first_end(cook, owner);
            triangle.corners |= (uint32_t)corners[k] << 8 * k;
            triangle.edges |= edge << 9 * k | (uint32_t)along << (27 + k);
            ends[edge].ends[0] = corners[along ? k : (k + 1) % 3];
            ends[edge].ends[1] = corners[along ? (k + 1) % 3 : k];
        }
        triangle.corners |= (uint32_t)is_plain(cook, job->owners, mesh_triangle) << 24;
        unit->triangles[t] = triangle;
        unit->mesh_triangles[t] = mesh_triangle;
    }
}

static void write_edges(const cluster_job *job, const displaced_cluster *cluster, const edge_table *table,
                        const edge_ends *ends, const bool *seams)
{
    displaced_cook *cook = job->cook;
    displaced_unit *unit = cook->unit;
    uint32_t seam = 0;
    for (uint32_t i = 0; i < table->count; i++) {
        uint32_t number = seams[i] ? seam++ : DISPLACED_NO_SEAM;
        unit->edges[cluster->first_edge + i] = (displaced_edge){
            ends[i].ends[0] | (uint32_t)ends[i].ends[1] << 8 | number << 16,
            middle_height(cook, table->owners[i]),
        };
        if (seams[i]) {
            side_site site = site_of_side(cook, table->owners[i]);
            unit->seams[cluster->first_seam + number] = (displaced_seam){
                {store2(site.coordinates[0]), store2(site.coordinates[1])},
                site.map,
            };
        }
    }
}

static void cluster_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cluster_job *job = data;
    displaced_unit *unit = job->cook->unit;
    edge_table table;
    bool seams[DISPLACED_EDGES];
    edge_ends ends[DISPLACED_EDGES];
    for (size_t i = begin; i < end; i++) {
        uint32_t seam_count = gather_edges(job, i, &table, seams);
        if (job->counts_only) {
            job->edge_counts[i] = table.count;
            job->seam_counts[i] = seam_count;
            continue;
        }
        clast_cluster from = job->cook->clusters.clusters[i];
        unit->clusters[i] = (displaced_cluster){
            .first_triangle = from.first_triangle,
            .triangle_count = from.triangle_count,
            .first_vertex = from.first_vertex,
            .vertex_count = from.vertex_count,
            .first_edge = job->edge_counts[i],
            .edge_count = table.count,
            .first_seam = job->seam_counts[i],
        };
        write_triangles(job, i, &table, ends);
        write_edges(job, &unit->clusters[i], &table, ends, seams);
    }
}

static clast_status write_clusters(displaced_cook *cook, cluster_job *job)
{
    displaced_unit *unit = cook->unit;
    clast_context *context = cook->context;
    size_t count = cook->clusters.cluster_count;
    job->counts_only = true;
    clast_parallel_for(context, count, CLUSTER_GRAIN, cluster_range, job);
    uint32_t edges = 0, seams = 0; // at most three for each triangle: they fit
    clast_exclusive_scan(context, job->edge_counts, count, &edges);
    clast_exclusive_scan(context, job->seam_counts, count, &seams);
    unit->edge_count = edges;
    unit->seam_count = seams;
    unit->triangle_count = cook->mesh->triangle_count;
    unit->clusters = clast_allocate(context, count, sizeof *unit->clusters);
    unit->triangles = clast_allocate(context, unit->triangle_count, sizeof *unit->triangles);
    unit->mesh_triangles = clast_allocate(context, unit->triangle_count, sizeof *unit->mesh_triangles);
    unit->edges = clast_allocate(context, edges, sizeof *unit->edges);
    unit->seams = clast_allocate(context, seams, sizeof *unit->seams);
    if (unit->clusters == NULL || unit->triangles == NULL || unit->mesh_triangles == NULL || unit->edges == NULL ||
        unit->seams == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    job->counts_only = false;
    clast_parallel_for(context, count, CLUSTER_GRAIN, cluster_range, job);
    unit->base.item_count = (uint32_t)count;
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------- templates

// By all factors of 4 bits.
static clast_status make_pattern_uses(displaced_cook *cook)
{
    uint16_t *uses = clast_allocate_zeroed(cook->context, DISPLACED_FACTORS, sizeof *uses);
    cook->unit->pattern_uses = uses;
    for (uint32_t factors = 0; uses != NULL && factors < DISPLACED_FACTORS; factors++) {
        bool sound = true;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t factor = pattern_factor(factors, k);
            sound = sound && factor >= 1 && factor <= PATTERN_SEGMENTS;
        }
        clast_pattern_use use = sound ? pattern_use(factors) : (clast_pattern_use){0, 0};
        uses[factors] = (uint16_t)(use.number | use.rotation << 9);
    }
    return uses != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// Last, as a set cannot give templates back.
static clast_status add_templates(displaced_cook *cook, clast_template_set *templates)
{
    displaced_unit *unit = cook->unit;
    const clast_clusters *clusters = &cook->clusters;
    clast_status status = clast_template_set_add_patterns(templates, unit->patterns, &unit->first_pattern);
    if (status != CLAST_OK) {
        return status;
    }
    clast_template_desc *descs = clast_allocate(cook->context, clusters->cluster_count, sizeof *descs);
    if (descs == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < clusters->cluster_count; i++) {
        descs[i] = (clast_template_desc){
            .triangle_count = clusters->clusters[i].triangle_count,
            .vertex_count = clusters->clusters[i].vertex_count,
            .indices = clusters->indices + 3 * (size_t)clusters->clusters[i].first_triangle,
            .rest_positions = NULL, // clusters come in the order of their blocks
        };
    }
    uint32_t first = 0;
    status = clast_template_set_add(templates, descs, clusters->cluster_count, &first);
    clast_free(cook->context, descs);
    for (size_t i = 0; status == CLAST_OK && i < clusters->cluster_count; i++) {
        unit->clusters[i].template_index = first + (uint32_t)i;
    }
    return status;
}

clast_status clast_displaced_cook_clusters(displaced_cook *cook, clast_template_set *templates)
{
    clast_context *context = cook->context;
    size_t count = cook->clusters.cluster_count;
    uint32_t *owners = clast_allocate(context, 3 * (size_t)cook->mesh->triangle_count, sizeof *owners);
    cluster_job job = {
        .cook = cook,
        .owners = owners,
        .edge_counts = clast_allocate(context, count, sizeof *job.edge_counts),
        .seam_counts = clast_allocate(context, count, sizeof *job.seam_counts),
    };
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (owners != NULL && job.edge_counts != NULL && job.seam_counts != NULL) {
        status = find_edge_owners(cook, owners);
    }
    status = status == CLAST_OK ? write_clusters(cook, &job) : status;
    status = status == CLAST_OK ? make_pattern_uses(cook) : status;
    status = status == CLAST_OK ? add_templates(cook, templates) : status;
    clast_free(context, owners);
    clast_free(context, job.edge_counts);
    clast_free(context, job.seam_counts);
    return status;
}
