// SPDX-License-Identifier: Apache-2.0
// Once per frame: the buffers that passes read and write, and the list of passes in order. How a pass is computed is
// the backend's (backend.h); what there is to compute is written here, once.
#ifndef CLAST_FRAME_FRAME_H
#define CLAST_FRAME_FRAME_H

#include "cook/cook.h"
#include "frame/pose.h"
#include "shared/light_choice.h"

// What a unit, or all of a frame, takes at some rate.
typedef struct clast_frame_need {
    uint64_t clusters, triangles, vertices, words, blocks; // as clast_source_count has them
    uint64_t bytes; // at most, while it is made: records, words, vertices, clusters and trees
} clast_frame_need;

// What items emitted while they were counted (draft.c).
typedef struct clast_frame_drafts {
    bool known;       // they are of what was counted last
    uint32_t *places; // by item: where in `words` its records begin, which its words follow; CLAST_NONE: nowhere
    size_t place_capacity;
    uint32_t *words;
    size_t capacity;
    size_t wanted; // as many would have had room for all
} clast_frame_drafts;

// A unit in this frame.
typedef struct clast_frame_unit {
    const clast_unit *unit;
    clast_source_view view; // the nearest of its instances decides
    clast_pose pose;
    clast_posed_mesh posed; // what the pose points to
    bool used;              // an instance shows it
    bool filtered;          // a material of it is not opaque
    bool may_emit;          // one shines
    clast_box bounds;       // of the pose, in the unit's own space; lower > upper where there is nothing
    clast_change change;    // what the passes must make anew
    bool made;              // view and pose below are those of what is there
    uint32_t made_serial;   // the unit's, of what is known of it here
    clast_pose made_pose;
    clast_source_view made_view;
    clast_frame_need sum;     // of all items
    clast_frame_need minimum; // at CLAST_RATE_LEAST
    bool minimum_known;
    bool counted; // item_counts and counted_sum are for counted_rate in this frame's view
    float counted_rate;
    clast_frame_need counted_sum;
    uint64_t cluster_vertices; // of all records, resident ones too
    uint64_t cluster_fill;     // of each record the larger of its triangles and its vertices
    clast_cluster_record *records;
    size_t record_count, record_capacity;
    packed3 *vertices; // of this frame; records with resident positions have none here
    size_t vertex_count, vertex_capacity;
    uint32_t *words; // of the records of this frame: the source's own
    size_t word_count, word_capacity;
    uint32_t *item_counts; // scratch of count and emit: [clusters][vertices][words]
    size_t item_capacity;
    clast_frame_drafts drafts;
    clast_clas_pool *clas;
    clast_blas *blas;
} clast_frame_unit;

typedef struct clast_frame_instance {
    uint32_t scene_instance;
    uint32_t unit;
    clast_transform to_world;
    clast_transform to_object;
    clast_box bounds; // world space
    bool hidden;      // the camera cannot see it; rays still do
    bool occluded;    // and that is since it lies behind others
} clast_frame_instance;

// The farthest depths of parts of the picture, as a coarse pass found them, in levels of half as many a side until there is
// one.
typedef struct clast_depth_pyramid {
    float *depths;
    size_t capacity;
    size_t first;           // where the levels begin, the finest first
    uint32_t width, height; // of the finest
    uint32_t level_count;   // 0: nothing is known
    float *rows;            // what edges compare themselves with (shared/occlusion.h), and room to make it
    size_t row_capacity;
    size_t row_count; // places that have one; 0: no edge is compared
    uint64_t row_key; // other rows, another
} clast_depth_pyramid;

// What a frame is asked for.
typedef struct clast_frame_settings {
    clast_camera camera;
    double aperture, focus; // in place of the camera's; 0 is the camera's own
    uint32_t camera_number; // of the scene's, which it is and moves with; CLAST_NONE where it is none of them
    uint32_t width, height;
    double time;
    uint32_t animation;       // as clast_moment has it
    clast_camera rate_camera; // decides how finely geometry is tessellated
    uint32_t rate_camera_number;
    uint32_t metric;        // CLAST_METRIC_
    double rate;            // wanted density
    double segment;         // wanted length of a segment, in the metric's unit
    double hidden_fraction; // of the wanted density, where no camera ray looks
    double displacement_scale;
    uint64_t max_triangles; // 0 is no bound
    uint64_t max_clusters;  // likewise
    uint64_t max_bytes;     // likewise: of what clast_frame_need counts
    uint32_t seed;
} clast_frame_settings;

// The bytes of what the frame's units hold.
typedef struct clast_frame_bytes {
    uint64_t records, vertices, clas, blas, tlas;
} clast_frame_bytes;

struct clast_backend;
struct clast_unit_tally;

typedef struct clast_frame {
    clast_context *context;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame_settings settings;
    const struct clast_backend *backend; // that runs passes now, or did last
    void *device;                   // what that keeps of the frame, where it is not the CPU's: the backend's maker's
    clast_frame_bytes device_bytes; // and how much that is
    clast_frame_unit *units;        // by geometry number
    size_t unit_count, unit_capacity;
    clast_frame_instance *instances;
    size_t instance_count, instance_capacity;
    uint32_t *frame_instance_of;    // by scene instance; CLAST_NONE where it is not in the frame
    size_t frame_instance_of_count; // the scene's instances when the frame was made
    size_t frame_instance_capacity;
    clast_tlas *tlas;         // hits name the scene's instance
    clast_frame_unit *coarse; // by geometry number: at the least rate, of units that adapt
    size_t coarse_count, coarse_capacity;
    clast_tlas *coarse_tlas; // hits name the frame's instance
    clast_depth_pyramid pyramid;
    uint64_t occlude_bytes; // that all of this takes, at most
    clast_frame_motion motion;
    uint64_t moved_vertices; // that were posed anew for this frame
    clast_emitter *emitters; // in order of instance, then primitive
    size_t emitter_count, emitter_capacity;
    float fitted_rate;                         // 1, or the step of the ladder that the budgets left
    clast_bound bound;                         // the budget that the step before did not keep
    clast_frame_need wanted, granted, minimum; // at the settings' rate, at the fitted one, at the least
    uint64_t triangles, clusters, vertices, instanced_triangles;
    double milliseconds[CLAST_PASS_COUNT_]; // of this frame; passes that run again and again add up
    clast_clas_input *clas_inputs;          // scratch
    size_t clas_input_capacity;
    uint32_t *draft_scratch; // scratch, for each thread
    size_t draft_scratch_capacity;
    clast_tlas_instance *tlas_instances; // scratch
    size_t tlas_instance_capacity;
    struct clast_unit_tally *tallies; // scratch
    size_t tally_capacity;
} clast_frame;

clast_status clast_frame_create(clast_scene *scene, clast_cooked *cooked, clast_frame **frame);
void clast_frame_destroy(clast_frame *frame);

// Runs passes first..last (clast_pass) in order on a backend and times each. `target` goes to the passes of render/.
// Where a pass fails, what was made is made anew by the next run, and rays hit nothing until then.
clast_status clast_frame_run(clast_frame *frame, const struct clast_backend *backend, clast_pass first, clast_pass last,
                             void *target);

// The ladder of rates: step k is 2^(-k / RATE_STEPS); CLAST_FRAME_LAST_RATE_STEP is CLAST_RATE_LEAST.
enum { CLAST_FRAME_LAST_RATE_STEP = 20 * RATE_STEPS };
float clast_frame_rate_step(uint32_t step);

clast_frame_bytes clast_frame_count_bytes(const clast_frame *frame);
clast_frame_bytes clast_unit_bytes(const clast_frame_unit *unit); // no TLAS

// What a source is given beside a record.
static inline const uint32_t *clast_frame_words(const clast_frame_unit *unit, const clast_cluster_record *record)
{
    return unit->words + record->first_word;
}

#endif
