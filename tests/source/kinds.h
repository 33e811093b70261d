// SPDX-License-Identifier: Apache-2.0
// One unit of each kind of source, for tests that every kind must pass. A new kind adds a line to kind_cases.
#ifndef CLAST_TESTS_SOURCE_KINDS_H
#define CLAST_TESTS_SOURCE_KINDS_H

#include "shapes.h"

#include "source/source.h"

typedef struct kind_case {
    uint32_t (*add)(clast_context *context, clast_scene *scene);
    float chord; // how far a triangle may be from the surface that it stands for, at the finest rate
} kind_case;

static inline uint32_t kind_add_clusters(clast_context *context, clast_scene *scene)
{
    return shape_add_sphere(context, scene, 40, 21);
}

static inline uint32_t kind_add_wave(clast_context *context, clast_scene *scene)
{
    return shape_add_wave(context, scene, 3);
}

// A bumpy sphere: rough maps of few texels, so that triangles of the finest rate follow them.
static inline uint32_t kind_add_displaced(clast_context *context, clast_scene *scene)
{
    uint32_t geometry = shape_add_sphere(context, scene, 12, 7);
    shape_displace(context, scene, geometry, 0, 0.1f);
    return geometry;
}

static const kind_case kind_cases[] = {
    [CLAST_SOURCE_CLUSTERS] = {kind_add_clusters, 1e-5f},
    [CLAST_SOURCE_WAVE] = {kind_add_wave, 0.05f},
    [CLAST_SOURCE_DISPLACED] = {kind_add_displaced, 0.01f},
};

typedef struct kind_world {
    clast_context *context;
    clast_scene *scene;
    clast_template_set *templates;
    clast_height_store *heights;
    clast_unit *unit;
    const clast_source *source;
} kind_world;

static inline clast_cook_job kind_job(const kind_world *world, uint32_t geometry)
{
    return (clast_cook_job){.context = world->context,
                            .scene = world->scene,
                            .geometry = &world->scene->geometries[geometry],
                            .templates = world->templates,
                            .heights = world->heights,
                            .patterns = &clast_patterns};
}

static inline void kind_cook(kind_world *world, uint32_t geometry)
{
    clast_cook_job job = kind_job(world, geometry);
    assert_ok(world->context, world->source->cook(&job, &world->unit));
}

// Without a unit.
static inline kind_world kind_begin(clast_context *context, clast_source_kind kind)
{
    kind_world world = {.context = context, .source = clast_sources[kind]};
    assert_ok(context, clast_scene_create(context, &world.scene));
    assert_ok(context, clast_template_set_create(context, &world.templates));
    assert_ok(context, clast_height_store_create(context, &world.heights));
    return world;
}

static inline kind_world kind_open(clast_context *context, clast_source_kind kind)
{
    kind_world world = kind_begin(context, kind);
    kind_cook(&world, kind_cases[kind].add(context, world.scene));
    return world;
}

static inline void kind_close(kind_world *world)
{
    if (world->unit != NULL) {
        world->source->destroy(world->unit);
    }
    clast_height_store_destroy(world->heights);
    clast_template_set_destroy(world->templates);
    clast_scene_destroy(world->scene);
}

// Runs a test's body once for each kind.
static inline void for_each_kind(void **state, void (*body)(kind_world *world))
{
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        kind_world world = kind_open(*state, (clast_source_kind)kind);
        body(&world);
        kind_close(&world);
    }
}

// From an eye, along -z.
#define KIND_VIEW(x, y, z, covered, density, unseen) \
    { \
        .eye = {{x, y, z}}, .pixels_per_unit = covered, .rate = density, .hidden = unseen, \
        .to_camera = {{{{1, 0, 0, -(x)}}, {{0, 1, 0, -(y)}}, {{0, 0, -1, z}}}}, .extent = {{0.8f, 0.45f}}, \
        .pixels = covered, .segment = 8, .hidden_fraction = 0.25f, .alone = 1 \
    }
static const clast_source_view kind_views[] = {
    KIND_VIEW(0, 3, 8, 900, 1, 0),    KIND_VIEW(0, 3, 8, 900, 0.125f, 0), KIND_VIEW(0, 0, 0, 900, 1, 0),
    KIND_VIEW(500, 30, 0, 900, 1, 0), KIND_VIEW(0, 30, 0, 200, 1, 1),     KIND_VIEW(0, 3, 8, 900, CLAST_RATE_LEAST, 0),
};
enum { KIND_VIEWS = sizeof kind_views / sizeof kind_views[0] };

static const clast_pose kind_poses[] = {{.time = 0.0, .displacement_scale = 1.0f},
                                        {.time = 0.7, .displacement_scale = 1.0f},
                                        {.time = 12345.678, .displacement_scale = 1.0f}};
enum { KIND_POSES = sizeof kind_poses / sizeof kind_poses[0] };

// All records and vertices of a unit, as a frame makes them, on one thread.
typedef struct kind_emission {
    clast_cluster_record *records;
    packed3 *vertices;
    uint32_t *words;
    uint32_t *firsts;      // by item: its first record
    uint32_t *first_words; // and its first word
    size_t record_count, vertex_count, word_count;
} kind_emission;

static inline kind_emission kind_emit(const kind_world *world, const clast_pose *pose, const clast_source_view *view)
{
    kind_emission all = {
        .firsts = malloc((world->unit->item_count + 1) * sizeof *all.firsts),
        .first_words = malloc((world->unit->item_count + 1) * sizeof *all.first_words),
    };
    for (uint32_t item = 0; item < world->unit->item_count; item++) {
        clast_source_count count = world->source->count(world->unit, pose, view, item);
        all.record_count += count.clusters;
        all.vertex_count += count.vertices;
        all.word_count += count.words;
    }
    all.records = calloc(all.record_count + 1, sizeof *all.records);
    all.vertices = calloc(all.vertex_count + 1, sizeof *all.vertices);
    all.words = calloc(all.word_count + 1, sizeof *all.words);
    size_t record = 0, vertex = 0, word = 0;
    for (uint32_t item = 0; item < world->unit->item_count; item++) {
        clast_source_count count = world->source->count(world->unit, pose, view, item);
        all.firsts[item] = (uint32_t)record;
        all.first_words[item] = (uint32_t)word;
        world->source->emit(world->unit, pose, view, item, (uint32_t)vertex, (uint32_t)word, all.words + word,
                            all.records + record);
        record += count.clusters;
        vertex += count.vertices;
        word += count.words;
    }
    for (size_t i = 0; i < all.record_count; i++) {
        if (world->source->resident(world->unit, &all.records[i]) == NULL) {
            world->source->fill(world->unit, pose, &all.records[i], all.words + all.records[i].first_word,
                                all.vertices + all.records[i].first_vertex);
        }
    }
    return all;
}

static inline void kind_emission_free(kind_emission *all)
{
    free(all->records);
    free(all->vertices);
    free(all->words);
    free(all->firsts);
    free(all->first_words);
}

// The vertices of a record's triangle.
static inline void kind_corners(const kind_world *world, const clast_cluster_record *record, const uint32_t *words,
                                uint32_t triangle, uint32_t corners[3])
{
    if (record_form(*record) == FORM_WHOLE) {
        clast_template_triangle(world->templates, record->template_index, triangle, corners);
        return;
    }
    uint8_t all[3 * TEMPLATE_TRIANGLES];
    world->source->corners(world->unit, record, words, all);
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = all[3 * triangle + k];
    }
}

static inline const packed3 *kind_vertices(const kind_world *world, const kind_emission *all, size_t record)
{
    const packed3 *resident = world->source->resident(world->unit, &all->records[record]);
    return resident != NULL ? resident : all->vertices + all->records[record].first_vertex;
}

#endif
