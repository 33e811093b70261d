/* SPDX-License-Identifier: Apache-2.0
 *
 * A renderer shows a scene: it cooks the geometry, builds acceleration structures each time the scene changes, traces rays
 * for the caller, and renders pictures into the caller's memory.
 */
#ifndef CLAST_RENDER_H
#define CLAST_RENDER_H

#include "clast/accel.h"
#include "clast/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum clast_view { CLAST_VIEW_LIST(CLAST_ENUMERATOR) CLAST_VIEW_COUNT_ } clast_view;
typedef enum clast_metric { CLAST_METRIC_LIST(CLAST_ENUMERATOR) } clast_metric;
typedef enum clast_tone_map { CLAST_TONE_MAP_LIST(CLAST_ENUMERATOR) } clast_tone_map;
typedef enum clast_integrator { CLAST_INTEGRATOR_LIST(CLAST_ENUMERATOR) } clast_integrator;
typedef enum clast_fireflies { CLAST_FIREFLIES_LIST(CLAST_ENUMERATOR) } clast_fireflies;
typedef enum clast_device { CLAST_DEVICE_LIST(CLAST_ENUMERATOR) } clast_device;
typedef enum clast_accel { CLAST_ACCEL_LIST(CLAST_ENUMERATOR) } clast_accel;
typedef enum clast_pass { CLAST_PASS_LIST(CLAST_ENUMERATOR) CLAST_PASS_COUNT_ } clast_pass;
typedef enum clast_bound { CLAST_BOUND_LIST(CLAST_ENUMERATOR) } clast_bound;

#define CLAST_SETTING_UINT(name, ...) uint32_t name;
#define CLAST_SETTING_REAL(name, ...) double name;
#define CLAST_SETTING_CHOICE(name, ...) uint32_t name;
#define CLAST_SETTING_TEXT(name, ...) const char *name;
/** In a setting of a real number, zero, where the default is another number. Whatever is as small does as well. */
#define CLAST_ZERO 1e-300

/** The settings of a render: see CLAST_RENDER_SETTING_LIST in clast/lists.h. Zero is the default everywhere. */
typedef struct clast_render_settings {
    CLAST_RENDER_SETTING_LIST(CLAST_SETTING_UINT, CLAST_SETTING_REAL, CLAST_SETTING_CHOICE, CLAST_SETTING_TEXT)
} clast_render_settings;

/** Puts defaults in place of zeros, and checks ranges: INVALID_ARGUMENT names the setting and its range. */
CLAST_API clast_status clast_render_settings_resolve(clast_context *context, clast_render_settings *settings);

/** A part of a picture, in pixels from its upper left corner. */
typedef struct clast_render_area {
    uint32_t x, y, width, height;
} clast_render_area;
/** The part that settings.crop says, or the whole picture: outputs have its size. INVALID_ARGUMENT where it does not lie in the
 *  picture. */
CLAST_API clast_status clast_render_settings_area(clast_context *context, const clast_render_settings *settings,
                                                  clast_render_area *area);

/** The settings that a scene file brought; zero where it says nothing. Texts are the scene's. */
CLAST_API void clast_scene_settings(const clast_scene *scene, clast_render_settings *settings);
/** The same, with those that the scene file gives keys over time as they are at `time`, in seconds. */
CLAST_API void clast_scene_settings_at(const clast_scene *scene, double time, clast_render_settings *settings);

typedef struct clast_renderer clast_renderer;

/** Makes a renderer of a scene, which must outlive it. Nothing is cooked yet. */
CLAST_API clast_status clast_renderer_create(clast_scene *scene, clast_renderer **renderer);
CLAST_API void clast_renderer_destroy(clast_renderer *renderer);

/** Brings the renderer up to date with the scene, for the given settings (null: defaults): cooks new geometry, and runs
 *  the passes that end with the tree over the instances. What has not changed is kept.
 *  Errors: OUT_OF_MEMORY, BUDGET (the message has the least budget that works), CANCELLED. */
CLAST_API clast_status clast_renderer_commit(clast_renderer *renderer, const clast_render_settings *settings);

/** Rays against the scene as last committed; from any number of threads at once. The processor traces them, whatever
 *  settings.device says. Hits name the scene's instances. Alpha masks are honoured; blended surfaces count as hit where their
 *  alpha is at least a half. The scene must not be edited meanwhile. After clast_scene_set_mesh_positions these calls are
 *  refused (STATE) until the next commit. */
CLAST_API clast_status clast_renderer_trace_closest(const clast_renderer *renderer, const clast_ray *rays, size_t count,
                                                    clast_hit *hits);
CLAST_API clast_status clast_renderer_trace_any(const clast_renderer *renderer, const clast_ray *rays, size_t count,
                                                uint8_t *occluded);

/** What lies at a hit. */
typedef struct clast_surface {
    float position[3];         /**< world space, on the triangle */
    float geometric_normal[3]; /**< unit length, on the side that clast_hit.normal is on */
    float shading_normal[3];   /**< unit length, interpolated; no normal map */
    float coordinates[2][2];   /**< texture coordinates, two sets; 0 where there are none */
    uint32_t geometry;
    uint32_t primitive; /**< mesh: the triangle's number in the mesh as added */
    uint32_t material;
} clast_surface;
CLAST_API clast_status clast_renderer_locate(const clast_renderer *renderer, const clast_hit *hit,
                                             clast_surface *surface);

/** A picture to make: `pixels` is the caller's, width * height * channels (CLAST_VIEW_LIST) floats or uint32_t, row by row
 *  from the top. Width and height are those of clast_render_settings_area. */
typedef struct clast_render_output {
    clast_view view;
    void *pixels;
} clast_render_output;

typedef struct clast_render_statistics {
    double pass_milliseconds[CLAST_PASS_COUNT_];
    double cook_milliseconds;
    double total_milliseconds;
    uint32_t samples;    /**< per pixel, done; fewer than asked where cancelled, or where a limit ended the render */
    double mean_samples; /**< of all pixels: where noise decides, not all get as many */
    uint64_t pixels_above_target;     /**< whose noise was above the target when the render ended */
    double first_sample_milliseconds; /**< from the call until each pixel had a sample */
    uint64_t rays;                    /**< all */
    uint64_t primary_rays;
    uint64_t triangles; /**< emitted this frame, over all units */
    uint64_t instanced_triangles;
    uint64_t clusters;
    uint64_t vertices;
    uint32_t units, instances, lights;
    uint32_t hidden_instances;   /**< that no camera ray meets, as far as boxes tell */
    uint32_t occluded_instances; /**< of these, what lies behind others: looked for where geometry adapts */
    uint32_t moved_units;        /**< whose vertices this frame made anew though their triangles stayed */
    uint64_t moved_vertices;     /**< of meshes that skins and morph targets posed anew for this frame */
    double rate;                 /**< of 1: what the budgets left */
    clast_bound bound;           /**< the budget that did not allow more */
    uint64_t wanted_clusters, wanted_triangles;
    uint64_t wanted_bytes; /**< as `frame_bytes`, at the wanted rate */
    uint64_t frame_bytes;  /**< at most, while the frame is made: its records, vertices, clusters and trees */
    double cluster_fill;   /**< of 1: how full clusters are, by the fuller of triangles and vertices; mean */
    uint64_t minimum_clusters, minimum_triangles,
        minimum_bytes; /**< the least budgets that this scene can be drawn with */
    uint64_t scene_bytes, cook_bytes, template_bytes, clas_bytes, vertex_bytes, blas_bytes, tlas_bytes;
    uint64_t memory_peak; /**< clast's own accounting */
    uint64_t process_memory_peak;
    const char *device; /**< that made the picture: "cpu", or a name; the renderer's, until it renders on another */
    const char *driver; /**< of a Vulkan device: its name and version; else empty */
    uint64_t device_bytes, device_bytes_peak; /**< of a Vulkan device's memory: held now, and at most so far */
} clast_render_statistics;

/** What the scene as last committed takes; the members of a render (samples, rays, total_milliseconds) are zero.
 *  Errors: INVALID_ARGUMENT, STATE (nothing is committed). */
CLAST_API clast_status clast_renderer_statistics(const clast_renderer *renderer, clast_render_statistics *statistics);

/** Commits, then renders. All outputs come from the same rays. A scene with neither environment nor lights nor surfaces
 *  that emit (a textured emission of at most one does not count: it is a display or a glowing detail) is lit by a sky with
 *  a sun. Where the progress hook cancels, CLAST_ERROR_CANCELLED is returned and the outputs hold what was rendered so far,
 *  rightly exposed; statistics->samples says how much (0: nothing). `statistics` may be null. The same scene and settings
 *  give the same bits, whatever the threads or instruction set; another device gives the same geometry to the bit, and colours
 *  that differ by roundings. Where settings.device is a Vulkan device, DEVICE says why it cannot be had,
 *  or that it was lost, and UNSUPPORTED that it, or the processor, lacks what settings.accel asks for; rays of the caller's
 *  need a commit of their own after such a picture (STATE). */
CLAST_API clast_status clast_render(clast_renderer *renderer, const clast_render_settings *settings,
                                    const clast_render_output *outputs, size_t count,
                                    clast_render_statistics *statistics);

/** Files from which a long render goes on where it was interrupted. */
typedef struct clast_checkpoint {
    const char *resume; /**< to go on from; null: from the beginning */
    const char
        *save; /**< written now and then, where the progress hook cancels, and at the end; null: none. May be that of
                         *   `resume`. */
    double interval; /**< seconds between two writes; 0 is 300 */
} clast_checkpoint;
/** As clast_render, with checkpoints (null: none). What comes of a render that goes on has the bits of one that was never
 *  interrupted. The picture's size, crop, camera, views, device, scene and all settings must be those of the render that wrote the
 *  file, but for spp, which may be more, time_limit, tonemap, and exposure where no noise target is set: INVALID_ARGUMENT
 *  says what is other, UNSUPPORTED that the file is of another version of clast, MALFORMED that it is damaged. A file that cannot be
 *  written on the way is a warning; FILE_WRITE tells that the last could not be, and the outputs hold the picture all the same. */
CLAST_API clast_status clast_render_with_checkpoint(clast_renderer *renderer, const clast_render_settings *settings,
                                                    const clast_checkpoint *checkpoint,
                                                    const clast_render_output *outputs, size_t count,
                                                    clast_render_statistics *statistics);

/** Makes a picture to look at (RGB, 8 bit, sRGB) of a view: tone map and exposure for colour, legible false colours for the
 *  rest. `pixels` has 3 bytes for each pixel. */
CLAST_API clast_status clast_view_to_display(clast_context *context, clast_view view, const void *values,
                                             uint32_t width, uint32_t height, const clast_render_settings *settings,
                                             uint8_t *pixels);
/** The same of 16 bits: 3 values for each pixel. */
CLAST_API clast_status clast_view_to_display_16(clast_context *context, clast_view view, const void *values,
                                                uint32_t width, uint32_t height, const clast_render_settings *settings,
                                                uint16_t *pixels);

#ifdef __cplusplus
}
#endif

#endif
