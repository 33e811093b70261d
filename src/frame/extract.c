// SPDX-License-Identifier: Apache-2.0
#include "frame/extract.h"

#include <math.h>
#include <string.h>

#include "base/thread.h"

enum {
    BATCH_RECORDS = 256,  // evaluated side by side, then added one by one
    PLACE_VARIANTS = 64,  // vertices that may share a position; more are not sought
    TABLE_LEAST = 1 << 12 // slots
};

// A corner of a triangle, and a vertex: all of it is floats.
typedef struct vertex {
    packed3 position, normal;
    packed2 coordinates[2];
    packed4 colour;
} vertex;

typedef struct extractor {
    clast_context *context;
    const clast_frame_unit *unit;
    const clast_source *source;
    bool welded;
    size_t first_record;    // of the batch
    uint32_t *first_corner; // of each record of the batch, over 3
    vertex *corners;        // of the batch
    uint32_t *materials;    // of the batch's triangles
    vertex *vertices;
    size_t vertex_count, vertex_capacity;
    uint32_t *slots; // an open hash table by position: vertex + 1; 0 is free
    size_t slot_count;
    uint32_t *indices;
    uint32_t *triangle_materials;
    size_t triangle_count;
    bool has_coordinates[2], has_colours, has_materials;
} extractor;

// ------------------------------------------------------------------------------------------------------- evaluating

static packed3 unit_normal(vec3 normal, vec3 otherwise)
{
    vec3 candidates[2] = {normal, otherwise};
    for (int i = 0; i < 2; i++) {
        vec3 v = candidates[i];
        float largest = largest3(vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])));
        if (largest > 0.0f && is_finite1(largest)) {
            return store3(normalize3(v * (1.0f / largest)));
        }
    }
    return (packed3){{0.0f, 0.0f, 1.0f}};
}

static void evaluate_corner(const extractor *e, const clast_cluster_record *record, uint32_t triangle, uint32_t corner,
                            vertex *v, uint32_t *material)
{
    const clast_frame_unit *unit = e->unit;
    vec2 barycentrics = vec2(corner == 1 ? 1.0f : 0.0f, corner == 2 ? 1.0f : 0.0f);
    clast_surface_point point = e->source->locate(unit->unit, &unit->pose, record, clast_frame_words(unit, record),
                                                  triangle, barycentrics);
    clast_source_surface surface = e->source->evaluate(unit->unit, &unit->pose, point);
    v->normal = unit_normal(surface.normal, surface.geometric_normal);
    v->coordinates[0] = store2(surface.coordinates[0]);
    v->coordinates[1] = store2(surface.coordinates[1]);
    v->colour = store4(surface.colour);
    *material = surface.material;
}

static void evaluate_records(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    extractor *e = data;
    for (size_t i = begin; i < end; i++) {
        size_t number = e->first_record + i;
        const clast_cluster_record *record = &e->unit->records[number];
        for (uint32_t t = 0; t < record_triangles(*record); t++) {
            size_t triangle = e->first_corner[i] + t;
            float positions[3][3];
            clast_clas_corners(e->unit->clas, number, t, positions);
            for (uint32_t c = 0; c < 3; c++) {
                vertex *v = &e->corners[3 * triangle + c];
                evaluate_corner(e, record, t, c, v, &e->materials[triangle]);
                for (int axis = 0; axis < 3; axis++) {
                    v->position.v[axis] = positions[c][axis] + 0.0f; // one sign of zero
                }
            }
        }
    }
}

// ---------------------------------------------------------------------------------------------------------- sharing

static size_t hash_position(packed3 position)
{
    uint32_t bits[3];
    memcpy(bits, &position, sizeof bits);
    uint64_t hash = (bits[0] * 0x9e3779b97f4a7c15u ^ bits[1]) * 0xc2b2ae3d27d4eb4fu;
    hash = ((hash >> 29 ^ hash) + bits[2]) * 0x165667b19e3779f9u;
    return (size_t)(hash >> 32 ^ hash);
}

static bool is_close(const float *a, const float *b, int count, float most)
{
    for (int i = 0; i < count; i++) {
        if (!(abs1(a[i] - b[i]) <= most * max1(1.0f, abs1(a[i])))) {
            return false;
        }
    }
    return true;
}

// Whether an eye would take the two for one: rounding differs between the triangles around a point.
static bool is_alike(const vertex *a, const vertex *b)
{
    return is_close(a->normal.v, b->normal.v, 3, 4e-3f) &&
           is_close(a->coordinates[0].v, b->coordinates[0].v, 2, 1e-5f) &&
           is_close(a->coordinates[1].v, b->coordinates[1].v, 2, 1e-5f) && is_close(a->colour.v, b->colour.v, 4, 1e-3f);
}

static clast_status grow_table(extractor *e)
{
    size_t count = e->slot_count != 0 ? 2 * e->slot_count : TABLE_LEAST;
    uint32_t *slots = clast_allocate_zeroed(e->context, count, sizeof *slots);
    if (slots == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_free(e->context, e->slots);
    e->slots = slots;
    e->slot_count = count;
    for (size_t i = 0; i < e->vertex_count; i++) {
        size_t slot = hash_position(e->vertices[i].position) & (count - 1);
        while (slots[slot] != 0) {
            slot = (slot + 1) & (count - 1);
        }
        slots[slot] = (uint32_t)i + 1;
    }
    return CLAST_OK;
}

// The number of a corner's vertex, which may be new. The arrays have room.
static uint32_t share_corner(extractor *e, const vertex *corner)
{
    size_t mask = e->slot_count - 1, slot = hash_position(corner->position) & mask;
    for (uint32_t variants = 0; e->slots[slot] != 0 && variants < PLACE_VARIANTS; slot = (slot + 1) & mask) {
        vertex *there = &e->vertices[e->slots[slot] - 1];
        if (memcmp(&there->position, &corner->position, sizeof there->position) != 0) {
            continue;
        }
        if (e->welded) {
            there->normal = store3(load3(there->normal) + load3(corner->normal));
        }
        if (e->welded || is_alike(there, corner)) {
            return e->slots[slot] - 1;
        }
        variants++;
    }
    while (e->slots[slot] != 0) {
        slot = (slot + 1) & mask;
    }
    e->vertices[e->vertex_count] = *corner;
    e->slots[slot] = (uint32_t)++e->vertex_count;
    return (uint32_t)e->vertex_count - 1;
}

static void note_attributes(extractor *e, const vertex *corner)
{
    for (int set = 0; set < 2; set++) {
        e->has_coordinates[set] = e->has_coordinates[set] || corner->coordinates[set].v[0] != 0.0f ||
                                  corner->coordinates[set].v[1] != 0.0f;
    }
    const float *colour = corner->colour.v;
    e->has_colours = e->has_colours || colour[0] != 1.0f || colour[1] != 1.0f || colour[2] != 1.0f || colour[3] != 1.0f;
}

static clast_status add_batch(extractor *e, size_t triangles)
{
    clast_status status = CLAST_RESERVE(e->context, e->vertices, e->vertex_capacity, e->vertex_count + 3 * triangles);
    while (status == CLAST_OK && 2 * (e->vertex_count + 3 * triangles) > e->slot_count) {
        status = grow_table(e);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t t = 0; t < triangles; t++) {
        size_t at = e->triangle_count++;
        for (uint32_t c = 0; c < 3; c++) {
            const vertex *corner = &e->corners[3 * t + c];
            note_attributes(e, corner);
            e->indices[3 * at + c] = share_corner(e, corner);
        }
        e->triangle_materials[at] = e->materials[t];
        e->has_materials = e->has_materials || e->materials[t] != e->triangle_materials[0];
    }
    return CLAST_OK;
}

static clast_status extract_records(extractor *e, uint64_t done, uint64_t total)
{
    const clast_frame_unit *unit = e->unit;
    clast_status status = CLAST_OK;
    for (e->first_record = 0; e->first_record < unit->record_count && status == CLAST_OK;
         e->first_record += BATCH_RECORDS) {
        size_t left = unit->record_count - e->first_record, count = left < BATCH_RECORDS ? left : BATCH_RECORDS;
        uint32_t triangles = 0;
        for (size_t i = 0; i < count; i++) {
            e->first_corner[i] = triangles;
            triangles += record_triangles(unit->records[e->first_record + i]);
        }
        clast_parallel_for(e->context, count, 4, evaluate_records, e);
        status = add_batch(e, triangles);
        if (status == CLAST_OK) {
            status = clast_progress(e->context, "extract", done + e->triangle_count, total);
        }
    }
    return status;
}

// ----------------------------------------------------------------------------------------------------------- arrays

// An attribute of all vertices in an array of its own; null where memory ran out.
static const float *separate(extractor *e, clast_extraction *extraction, size_t offset, size_t width)
{
    float *array = clast_allocate(e->context, e->vertex_count, width * sizeof *array);
    if (array != NULL) {
        extraction->blocks[extraction->block_count++] = array;
        for (size_t i = 0; i < e->vertex_count; i++) {
            memcpy(array + i * width, (const char *)&e->vertices[i] + offset, width * sizeof *array);
        }
    }
    return array;
}

static void keep_block(clast_extraction *extraction, void *block)
{
    extraction->blocks[extraction->block_count++] = block;
}

static clast_status finish(extractor *e, clast_extraction *extraction)
{
    clast_mesh *mesh = &extraction->mesh;
    for (size_t i = 0; e->welded && i < e->vertex_count; i++) {
        e->vertices[i].normal = unit_normal(load3(e->vertices[i].normal), vec3(0.0f, 0.0f, 1.0f));
    }
    *mesh = (clast_mesh){.vertex_count = (uint32_t)e->vertex_count, .triangle_count = (uint32_t)e->triangle_count};
    mesh->material = e->triangle_count != 0 ? e->triangle_materials[0] : 0;
    mesh->indices = e->indices;
    keep_block(extraction, e->indices);
    if (e->has_materials) {
        mesh->triangle_materials = e->triangle_materials;
    }
    keep_block(extraction, e->triangle_materials);
    e->indices = NULL;
    e->triangle_materials = NULL;
    mesh->positions = separate(e, extraction, offsetof(vertex, position), 3);
    mesh->normals = separate(e, extraction, offsetof(vertex, normal), 3);
    bool whole = mesh->positions != NULL && mesh->normals != NULL;
    for (int set = 0; set < 2 && !e->welded; set++) {
        // the second set stands alone nowhere
        if (e->has_coordinates[set] || (set == 0 && e->has_coordinates[1])) {
            mesh->coordinates[set] = separate(e, extraction, offsetof(vertex, coordinates[set]), 2);
            whole = whole && mesh->coordinates[set] != NULL;
        }
    }
    if (e->has_colours && !e->welded) {
        mesh->colours = separate(e, extraction, offsetof(vertex, colour), 4);
        whole = whole && mesh->colours != NULL;
    }
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

clast_status clast_frame_extract(const clast_frame *frame, const clast_frame_unit *unit, bool welded, uint64_t done,
                                 uint64_t total, clast_extraction *extraction)
{
    clast_context *context = frame->context;
    *extraction = (clast_extraction){0};
    uint64_t triangles = 0;
    for (size_t i = 0; i < unit->record_count; i++) {
        triangles += record_triangles(unit->records[i]);
    }
    if (triangles > UINT32_MAX / 3) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%llu triangles: expected at most %u in a mesh",
                          (unsigned long long)triangles, UINT32_MAX / 3);
    }
    extractor e = {.context = context, .unit = unit, .source = clast_source_of(unit->unit), .welded = welded};
    size_t batch = BATCH_RECORDS * (size_t)TEMPLATE_TRIANGLES;
    e.first_corner = clast_allocate(context, BATCH_RECORDS, sizeof *e.first_corner);
    e.corners = clast_allocate(context, 3 * batch, sizeof *e.corners);
    e.materials = clast_allocate(context, batch, sizeof *e.materials);
    e.indices = clast_allocate(context, triangles, 3 * sizeof *e.indices);
    e.triangle_materials = clast_allocate(context, triangles, sizeof *e.triangle_materials);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (e.first_corner != NULL && e.corners != NULL && e.materials != NULL && e.indices != NULL &&
        e.triangle_materials != NULL) {
        status = extract_records(&e, done, total);
    }
    if (status == CLAST_OK) {
        status = finish(&e, extraction);
    }
    void *scratch[] = {e.first_corner, e.corners, e.materials, e.indices, e.triangle_materials, e.vertices, e.slots};
    for (size_t i = 0; i < sizeof scratch / sizeof scratch[0]; i++) {
        clast_free(context, scratch[i]);
    }
    if (status != CLAST_OK) {
        clast_extraction_free(context, extraction);
    }
    return status;
}

void clast_extraction_free(clast_context *context, clast_extraction *extraction)
{
    for (uint32_t i = 0; i < extraction->block_count; i++) {
        clast_free(context, extraction->blocks[i]);
    }
    *extraction = (clast_extraction){0};
}
