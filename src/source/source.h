// SPDX-License-Identifier: Apache-2.0
// The one interface of all kinds of dense geometry. A kind is a file in this folder that fills a clast_source; the
// list of kinds is CLAST_SOURCE_LIST. frame/ and render/ know nothing else of them: a further kind needs no change
// there.
//
// A *unit* is one cooked geometry: it owns one BLAS and serves any number of instances. A *pose* is a moment of it. An
// *item* is the part of a unit that emits on its own (a cooked cluster, a tile, a base triangle): items are counted and
// emitted in parallel, and placed by prefix sums, so that the order of records never depends on timing.
//
// count, emit, fill, locate and evaluate are pure: the same arguments give the same bits, on any thread, at any time.
// The formulas they need are in shared/, so that a GPU gives the same bits too.
#ifndef CLAST_SOURCE_SOURCE_H
#define CLAST_SOURCE_SOURCE_H

#include "base/context.h"
#include "clast/accel.h"
#include "geometry/pattern.h"
#include "scene/scene.h"
#include "shared/device.h"
#include "shared/records.h"
#include "source/height.h"

// A moment of a unit: what moves is a function of these and of the geometry's arrays.
typedef struct clast_pose {
    double time;      // seconds
    uint32_t version; // of the unit's positions (clast_unit.version): grows when `update` takes new ones over
    uint32_t shape;   // of the arrays below: another number, other contents
    // Of the mesh's vertices; null where they are as the geometry has them. The frame's own.
    const packed3 *positions, *normals;
    const packed4 *tangents;
    float displacement_scale; // times what the materials say
} clast_pose;

// What has to be made anew for a pose, given what was made for the pose before. Each includes those before it.
typedef enum clast_change {
    CLAST_CHANGE_NOTHING,  // records, vertices and boxes can be kept
    CLAST_CHANGE_VERTICES, // same records, other positions
    CLAST_CHANGE_TOPOLOGY, // other records
} clast_change;

// A flat array of cooked data, for a backend that mirrors it.
typedef struct clast_source_array {
    const char *name;
    const void *data;
    uint64_t bytes;   // 0: nothing is in this place
    uint32_t version; // grows when the contents change
    uint64_t common;  // not 0: the number of contents that several units list, which never change
} clast_source_array;

enum { CLAST_SOURCE_ARRAYS_MOST = SOURCE_ARRAYS };

// What a hit is made of, in the unit's own space.
typedef struct clast_source_surface {
    vec3 position;
    vec3 geometric_normal; // not normalised, counter-clockwise side
    vec3 normal;           // interpolated, not normalised; the geometric one where the geometry is flat
    vec3 tangent;          // not normalised; zero where there is none
    float bitangent_sign;
    vec2 coordinates[2];                 // texture coordinates
    vec4 colour;                         // vertex colour; white where there is none
    clast_texture_gradient gradients[2]; // of these; zero where they do not tell
    float curvature;                     // mesh_curvature(); 0 where it is not known
    uint32_t material;
} clast_source_surface;

// A unit's cooked data, common to all kinds; a kind's own struct begins with it.
typedef struct clast_unit {
    clast_context *context;
    clast_source_kind kind;
    const clast_geometry *geometry; // cook/'s copy of the scene's, as of the last commit
    uint32_t geometry_version;      // that was cooked
    uint32_t item_count;
    uint64_t bytes;      // of the cooked data
    uint32_t number;     // of the geometry; records carry it. Set by cook/
    uint32_t serial;     // no two units of a clast_cooked ever had the same. Set by cook/
    uint32_t version;    // of the positions: poses carry it
    bool stale;          // must be cooked anew. Set by cook/
    uint32_t *materials; // the different materials of its surface, in order of first use
    uint32_t material_count;
} clast_unit;

// Room for what an item emits while it is counted.
typedef struct clast_source_draft {
    clast_cluster_record *records;
    uint32_t *words;
    uint32_t record_room, word_room;
} clast_source_draft;

// What identifies cooked data: a hash of all that it is made of, and of how.
typedef struct clast_cook_key {
    uint64_t low, high;
} clast_cook_key;

// Keeps what takes long to cook from one run to the next. Both are called from the thread that cooks.
typedef struct clast_cook_cache {
    void *user;
    // Copies what is kept under a key, where that is `size` bytes; false where there is nothing. Sources check what they get.
    bool (*find)(void *user, clast_cook_key key, void *data, size_t size);
    // Where it fails, the log says so, and cooking goes on.
    void (*keep)(void *user, clast_cook_key key, const void *data, size_t size);
} clast_cook_cache;

// What is to be cooked, and with what.
typedef struct clast_cook_job {
    clast_context *context;
    const clast_scene *scene;
    const clast_geometry *geometry;      // of the scene; units keep the pointer
    clast_template_set *templates;       // of all units: further ones are added
    clast_height_store *heights;         // displacement maps that units share
    const clast_pattern_table *patterns; // that cut triangles; outlives the units
    const clast_cook_cache *cache;       // null where nothing is kept
} clast_cook_job;

typedef struct clast_source {
    const char *name;
    uint32_t most_triangles; // of any record
    bool adapts;             // its records depend on the view
    bool hides_edges;        // edges that lie behind what view->depths tells of are coarser
    bool single_items;       // each item is the work of a single invocation of its twin (SOURCE_SINGLE_ITEMS)

    // How long cooking takes, in triangles: for the progress only.
    uint64_t (*work)(const clast_geometry *geometry);
    // Sets all of clast_unit but number and serial.
    clast_status (*cook)(const clast_cook_job *job, clast_unit **unit);
    void (*destroy)(clast_unit *unit);
    // The geometry's positions changed and its topology did not: take them over, so that `changed` says so. May
    // refuse by CLAST_ERROR_UNSUPPORTED: the unit is cooked anew then.
    clast_status (*update)(clast_unit *unit, const clast_geometry *geometry);

    // Holds all positions that fill gives for this pose at any rate.
    clast_box (*bounds)(const clast_unit *unit, const clast_pose *pose);
    // Compares what was made (pose, view) with what is wanted.
    clast_change (*changed)(const clast_unit *unit, const clast_pose *before, const clast_source_view *view_before,
                            const clast_pose *now, const clast_source_view *view_now);
    // How far the surface may be, at any rate, from that at CLAST_RATE_LEAST; infinite where that is not known. Null for
    // sources that do not adapt.
    float (*deviation)(const clast_unit *unit, const clast_pose *pose);
    // Describes the cooked arrays, and of the geometry what `evaluate` needs; returns how many. What stands in which place is
    // known to the kind's twin (shaders/source); units of meshes begin with clast_mesh_arrays().
    uint32_t (*arrays)(const clast_unit *unit, clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST]);
    // The displacement maps, by the numbers that the arrays have for them: null for one that moves nothing. Both are null for
    // kinds without maps.
    uint32_t (*height_count)(const clast_unit *unit);
    const clast_height *(*height)(const clast_unit *unit, uint32_t number);
    // What the twin must know of a pose beside its arrays and displacement_scale; null for nothing.
    packed4 (*moment)(const clast_unit *unit, const clast_pose *pose);
    // Which of the arrays the twin makes anew, as many elements of `posed_bytes` as it has, where a pose has positions or normals
    // (source_pose); 0: none.
    uint32_t posed_array, posed_bytes;

    // What an item emits at view->rate; `vertices` are those that fill writes, not resident ones. The rate
    // CLAST_RATE_LEAST gives the least that is still whole (every factor 1), whatever the rest of the view and the
    // pose. The sum over a unit's items never falls while the rate grows.
    clast_source_count (*count)(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                                uint32_t item);
    // Writes exactly count().clusters records and count().words words. first_vertex is where the item's vertices begin,
    // first_word where its words do; `words` points to the first of them.
    void (*emit)(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view, uint32_t item,
                 uint32_t first_vertex, uint32_t first_word, uint32_t *words, clast_cluster_record *records);
    // Null, or counts and emits in one go, for sources for which counting is most of the work: what emit would write with
    // first_vertex and first_word 0, all of it where the room is as large as what count says.
    clast_source_count (*draft)(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                                uint32_t item, const clast_source_draft *draft);
    // The positions of a record's vertices, in the template's order. `words` points to the record's first word, here and
    // below.
    void (*fill)(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                 const uint32_t *words, packed3 *positions);
    // The corners of a composite record's triangles, three for each: numbers of its vertices. Null for sources that emit
    // none.
    void (*corners)(const clast_unit *unit, const clast_cluster_record *record, const uint32_t *words,
                    uint8_t corners[3 * TEMPLATE_TRIANGLES]);
    // Null, or what fill and corners write of a composite record, both at once.
    void (*fill_composite)(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                           const uint32_t *words, packed3 *positions, uint8_t corners[3 * TEMPLATE_TRIANGLES]);
    // Where the positions of a record lie already, as long as the unit lives; null where fill must write them.
    const packed3 *(*resident)(const clast_unit *unit, const clast_cluster_record *record);

    // What a hit on a record's triangle is on the source's surface. barycentrics weigh the second and third corner.
    clast_surface_point (*locate)(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                                  const uint32_t *words, uint32_t triangle, vec2 barycentrics);
    // The segments, not rounded, that a view gives the base edge that is nearest to a hit. Null for sources that do not
    // adapt.
    float (*segments)(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                      const clast_cluster_record *record, const uint32_t *words, uint32_t triangle, vec2 barycentrics);
    // Position, normals and attributes of a surface point.
    clast_source_surface (*evaluate)(const clast_unit *unit, const clast_pose *pose, clast_surface_point point);
    // The emissive primitives: material of each primitive, and its corners, for sampling lights. primitive_count 0
    // where the kind has no such list.
    uint32_t (*primitive_count)(const clast_unit *unit);
    uint32_t (*primitive_material)(const clast_unit *unit, uint32_t primitive);
    void (*primitive_corners)(const clast_unit *unit, const clast_pose *pose, uint32_t primitive, vec3 corners[3]);

    // What it would like to be resident for a view; null where all always is.
    void (*requests)(const clast_unit *unit, const clast_source_view *view, void (*request)(void *user, uint64_t block),
                     void *user);
} clast_source;

// A rate so low that every factor is 1.
#define CLAST_RATE_LEAST 0.0f

// The kinds, by clast_source_kind.
extern const clast_source *const clast_sources[];
extern const uint32_t clast_source_kind_count;
#define CLAST_SOURCE_DECLARE(name, value, text) extern const clast_source name##_TABLE;
CLAST_SOURCE_LIST(CLAST_SOURCE_DECLARE)

static inline const clast_source *clast_source_of(const clast_unit *unit)
{
    return clast_sources[unit->kind];
}

#endif
