// SPDX-License-Identifier: Apache-2.0
// What a frame has on a device, for the files that make it.
#ifndef CLAST_VULKAN_FRAME_STATE_H
#define CLAST_VULKAN_FRAME_STATE_H

#include "frame/unit.h"
#include "vulkan/frame.h"
#include "vulkan/trees.h"

// What was made of a unit.
typedef struct clast_vulkan_unit {
    clast_gpu_buffer records, words, vertices;
    clast_gpu_buffer clusters, boxes, places, tree;
    uint32_t record_count;
    clast_gpu_buffer shape; // of its tree, where that is fitted (frame_shape.c); empty where it would be too deep
    bool shape_is_made;
    uint32_t shape_serial, shape_version; // of the unit for which it was made
    bool filtered;                        // that placements tell
    uint64_t first_item;                  // of the unit in what was counted last
    uint64_t drafts;                      // where items emitted while that was kept; 0: nowhere
    uint64_t first_record;                // of the unit in what is emitted now
} clast_vulkan_unit;

struct clast_vulkan_frame {
    clast_gpu *gpu;
    clast_context *context;
    clast_mirror *mirror;
    clast_topologies topologies;
    clast_gpu_trees *trees;
    bool is_prepared;         // the frame's units are mirrored
    clast_vulkan_unit *units; // by geometry number, as are the next
    clast_device_unit *records;
    size_t unit_count, unit_capacity, record_capacity;
    clast_gpu_buffer unit_records, instances, instance_of, head;
    clast_gpu_buffer maps;  // clast_device_map of each instance
    clast_gpu_buffer scene; // clast_device_scene: what rays are traced through, as are the next
    clast_gpu_buffer placements, placement_boxes, placement_tree;
    clast_gpu_buffer spans, item_counts, sums, spaces, scratch;
    clast_gpu_buffer depths; // that edges compare themselves with, as are the next: clast_depth_pyramid.rows
    uint64_t depths_key;
    size_t depths_count;          // 0: none are there
    clast_gpu_buffer drafts;      // places by item, then clast_draft_head and its words
    clast_device_span *span_list; // what `spans` gets
    size_t span_count, span_capacity;
    clast_unit_sums *unit_sums; // what came back, by geometry number
    size_t sum_capacity;
    clast_device_instance *instance_list; // what `instances` holds
    clast_device_map *map_list;           // what `maps` holds
    size_t instance_count, instance_capacity, map_capacity;
    // Of what was counted last, where it was kept.
    uint64_t kept_items;
    size_t kept_units;
    float kept_rate;
    clast_gpu_commands *commands; // from emit to tlas
    bool is_whole;                // `head` tells of a frame that was made
    clast_frame *coarse;          // of the pass occlude (frame_coarse.c), where that is wanted, as are the next
    clast_vulkan_frame *coarse_device;
    clast_gpu_buffer coarse_rays;
    clast_vulkan_frame *parent;         // of such a frame: whose mirrored data it uses
    struct clast_frame_driver *driver;  // vulkan/frame_driver.h; null: rays go through clast's own trees
    struct clast_vulkan_render *render; // vulkan/render.h; null before the first render
};

// The push constants of shaders/frame/spans.glsl.
typedef struct clast_span_push {
    uint64_t units, spans, templates;
    uint32_t span_count, keep;
} clast_span_push;

// Parts of several units that one dispatch works on: a range of span_list.
typedef struct clast_span_range {
    size_t first, count; // without the span that ends it
    uint64_t groups;
} clast_span_range;

enum { CLAST_KINDS_MOST = 16 };

// The kernel of a kind of source, of those that the build made of NAME.source.comp: they follow each other.
#define CLAST_SHADER_OF_KIND(name, kind) ((clast_shader)((int)CLAST_SHADER_##name##_CLUSTERS + (int)(kind)))

// Work groups of a unit in a dispatch.
typedef uint64_t (*clast_groups_function)(const clast_frame_unit *unit);
// Groups of SOURCE_GROUP items or, where a kind's items are the work of a group each, as many as items.
uint64_t clast_item_groups(const clast_frame_unit *unit);
uint64_t clast_record_groups(const clast_frame_unit *unit);  // one a record
uint64_t clast_record_batches(const clast_frame_unit *unit); // of SOURCE_GROUP records

static inline clast_vulkan_frame *clast_vulkan_of(const clast_frame *frame)
{
    return frame->device;
}

// Before the passes of a frame.
void clast_vulkan_begin(clast_vulkan_frame *device);
void clast_vulkan_free_coarse(clast_vulkan_frame *device);
static inline const clast_topologies *clast_vulkan_topologies(const clast_vulkan_frame *device)
{
    return device->parent != NULL ? &device->parent->topologies : &device->topologies;
}

// Uploads what is new of the frame's units, once a frame.
clast_status clast_vulkan_prepare(clast_frame *frame);
// Writes into `records` what is known of the units, and makes room for what clast_vulkan_write_units copies.
clast_status clast_vulkan_describe_units(clast_frame *frame);
// Copies `records` and `span_list` to the device, and clears the units' sums. The commands have a barrier after it.
void clast_vulkan_write_units(clast_vulkan_frame *device, clast_gpu_commands *commands);

// Appends spans of some units to span_list: of a kind, or of all where it is CLAST_NONE.
clast_status clast_vulkan_add_spans(clast_vulkan_frame *device, clast_frame_unit *const *units, size_t count,
                                    uint32_t kind, clast_groups_function groups, clast_span_range *range);
// Runs a kernel over a range of spans.
void clast_vulkan_run_spans(clast_vulkan_frame *device, clast_gpu_commands *commands, clast_shader shader,
                            const clast_span_range *range, bool keep);
// The same of a call with more than shader and groups.
void clast_vulkan_call_spans(clast_vulkan_frame *device, clast_gpu_commands *commands, const clast_span_range *range,
                             bool keep, clast_gpu_call call);

// Uploads the instances where they are not those that the device has; `moves` says whether any is placed anew (frame_place.c).
clast_status clast_vulkan_write_instances(clast_frame *frame, clast_gpu_commands *commands, bool *moves);
// Whether a unit's tree is fitted, not built: a mesh whose clusters move while their topology stays.
bool clast_vulkan_keeps_shape(const clast_frame_unit *unit);
// Makes the shape that the tree of such a unit has, and brings it to the device, once.
clast_status clast_vulkan_shape_unit(clast_frame *frame, const clast_frame_unit *unit);
// Records what makes the scene that rays are traced through. Units' trees are there.
clast_status clast_vulkan_build_scene(clast_frame *frame, clast_gpu_commands *commands);

// What the frame takes, by what it is for.
clast_frame_bytes clast_vulkan_count_bytes(const clast_vulkan_frame *device);

// Makes a buffer hold so many bytes; contents are lost. Exactly so many, where memory is bounded.
clast_status clast_vulkan_renew(clast_frame *frame, uint64_t bytes, const char *name, clast_gpu_buffer *buffer);

#endif
