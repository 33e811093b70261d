/* SPDX-License-Identifier: Apache-2.0
 *
 * Every enumeration and settings table of clast, once: lists of X(name, value, text...) that C headers and GLSL
 * includes expand. This file holds preprocessor lists only, so that both languages can read it. Values are explicit
 * because they are stored in files and records.
 */
#ifndef CLAST_LISTS_H
#define CLAST_LISTS_H

/* No such index: a mesh, texture or hit that is not there. */
#define CLAST_NONE 0xffffffffu

/* X(name, value, text): what a call came to. */
#define CLAST_STATUS_LIST(X) \
    X(CLAST_OK, 0, "success") \
    X(CLAST_ERROR_INVALID_ARGUMENT, 1, "an argument is outside its documented range") \
    X(CLAST_ERROR_OUT_OF_MEMORY, 2, "memory ran out, or the memory limit was reached") \
    X(CLAST_ERROR_FILE_NOT_FOUND, 3, "the file does not exist") \
    X(CLAST_ERROR_FILE_READ, 4, "the file could not be read") \
    X(CLAST_ERROR_FILE_WRITE, 5, "the file could not be written") \
    X(CLAST_ERROR_MALFORMED, 6, "the file breaks its format's rules") \
    X(CLAST_ERROR_UNSUPPORTED, 7, "the file needs a feature that clast does not have") \
    X(CLAST_ERROR_LIMIT, 8, "the input is larger than a limit of clast") \
    X(CLAST_ERROR_BUDGET, 9, "the budget is below the scene's minimum") \
    X(CLAST_ERROR_CANCELLED, 10, "the progress hook asked to stop") \
    X(CLAST_ERROR_THREAD, 11, "a thread could not be started") \
    X(CLAST_ERROR_STATE, 12, "the object is not in a state that allows this call") \
    X(CLAST_ERROR_DEVICE, 13, "the device is absent or failed")

/* X(name, value, text): instruction sets of the CPU kernels, least first. Each gives the same bits. */
#define CLAST_ISA_LIST(X) \
    X(CLAST_ISA_PLAIN, 1, "plain") \
    X(CLAST_ISA_SSE42, 2, "sse4.2") \
    X(CLAST_ISA_AVX2, 3, "avx2") \
    X(CLAST_ISA_AVX512, 4, "avx512") /* F, VL, BW, DQ and VBMI: Ice Lake, Zen 4 and later */

/* X(name, value, text): how a tree is built over clusters or instances. */
#define CLAST_BUILD_LIST(X) \
    X(CLAST_BUILD_BEST, 0, "best") /* by the surface area heuristic: rays are fastest */ \
    X(CLAST_BUILD_FAST, 1, "fast") /* by the same, sought less thoroughly: for what changes every frame */

/* X(name, value, text): how much a log line matters. */
#define CLAST_LOG_LIST(X) \
    X(CLAST_LOG_WARNING, 1, "warning") \
    X(CLAST_LOG_INFORMATION, 2, "information")

/* X(name, value, text): how much a fault of a file matters. */
#define CLAST_SEVERITY_LIST(X) \
    X(CLAST_SEVERITY_ERROR, 0, "error")             /* the file breaks a rule */ \
    X(CLAST_SEVERITY_WARNING, 1, "warning")         /* it will hardly do what was meant */ \
    X(CLAST_SEVERITY_INFORMATION, 2, "information") /* it has what it does not need */ \
    X(CLAST_SEVERITY_HINT, 3, "hint")               /* it could be better for some programs */

/* X(name, value, text): the kinds of dense geometry. A source file in src/source/ for each. */
#define CLAST_SOURCE_LIST(X) \
    X(CLAST_SOURCE_CLUSTERS, 0, "clusters") \
    X(CLAST_SOURCE_WAVE, 1, "wave") \
    X(CLAST_SOURCE_DISPLACED, 2, "displaced")

/* X(name, value, text): how long an edge is, for the number of its segments. */
#define CLAST_METRIC_LIST(X) \
    X(CLAST_METRIC_PIXELS, 0, "pixels") /* as projected */ \
    X(CLAST_METRIC_SPHERE, 1, \
      "sphere") /* over the distance from the eye, whichever way it looks: pixels, unforeshortened */ \
    X(CLAST_METRIC_LENGTH, 2, "length") /* in the world */ \
    X(CLAST_METRIC_FIXED, 3, "fixed")   /* as many segments for all edges */

/* X(name, value, text): what makes a picture. */
#define CLAST_DEVICE_LIST(X) \
    X(CLAST_DEVICE_AUTO, 0, \
      "auto") /* a discrete or integrated GPU, where there is one that will do; else the processor */ \
    X(CLAST_DEVICE_CPU, 1, "cpu")       /* the processor */ \
    X(CLAST_DEVICE_VULKAN, 2, "vulkan") /* a device that Vulkan drives */

/* X(name, value, text): what rays of a picture go through, on a Vulkan device. */
#define CLAST_ACCEL_LIST(X) \
    X(CLAST_ACCEL_CLAST, 0, "clast")   /* clast's own structures, on any device */ \
    X(CLAST_ACCEL_DRIVER, 1, "driver") /* those of the driver: VK_KHR_ray_tracing_pipeline */

/* X(name, value, text): what kept a frame below the wanted rate. */
#define CLAST_BOUND_LIST(X) \
    X(CLAST_BOUND_NONE, 0, "none") \
    X(CLAST_BOUND_CLUSTERS, 1, "max_clusters") \
    X(CLAST_BOUND_TRIANGLES, 2, "max_triangles") \
    X(CLAST_BOUND_MEMORY, 3, "max_memory")

/* X(name, value, text): what of a node an animation moves; glTF 2.0 animation.channel.target.path. */
#define CLAST_ANIMATED_LIST(X) \
    X(CLAST_ANIMATED_TRANSLATION, 0, "translation") \
    X(CLAST_ANIMATED_ROTATION, 1, "rotation") \
    X(CLAST_ANIMATED_SCALE, 2, "scale") \
    X(CLAST_ANIMATED_WEIGHTS, 3, "weights") /* of morph targets */

/* X(name, value, text): how an animation goes from key to key; glTF 2.0 animation.sampler.interpolation. */
#define CLAST_INTERPOLATION_LIST(X) \
    X(CLAST_INTERPOLATION_LINEAR, 0, "LINEAR") /* rotations along the shorter arc */ \
    X(CLAST_INTERPOLATION_STEP, 1, "STEP") \
    X(CLAST_INTERPOLATION_CUBICSPLINE, 2, "CUBICSPLINE")

/* X(name, value, text): glTF 2.0 alpha modes. */
#define CLAST_ALPHA_LIST(X) \
    X(CLAST_ALPHA_OPAQUE, 0, "OPAQUE") \
    X(CLAST_ALPHA_MASK, 1, "MASK") \
    X(CLAST_ALPHA_BLEND, 2, "BLEND")

/* X(name, value, text): what texture coordinates outside [0, 1] do; glTF 2.0 sampler.wrapS/T. */
#define CLAST_WRAP_LIST(X) \
    X(CLAST_WRAP_REPEAT, 0, "REPEAT") \
    X(CLAST_WRAP_CLAMP, 1, "CLAMP_TO_EDGE") \
    X(CLAST_WRAP_MIRROR, 2, "MIRRORED_REPEAT")

/* X(name, value, text): texture filters. */
#define CLAST_FILTER_LIST(X) \
    X(CLAST_FILTER_LINEAR, 0, "LINEAR") \
    X(CLAST_FILTER_NEAREST, 1, "NEAREST")

/* X(name, value, text): light types; KHR_lights_punctual. */
#define CLAST_LIGHT_LIST(X) \
    X(CLAST_LIGHT_POINT, 0, "point") \
    X(CLAST_LIGHT_SPOT, 1, "spot") \
    X(CLAST_LIGHT_DIRECTIONAL, 2, "directional")

/* X(name, value, text): what surrounds a scene. */
#define CLAST_ENVIRONMENT_LIST(X) \
    X(CLAST_ENVIRONMENT_SKY, 0, "sky") \
    X(CLAST_ENVIRONMENT_IMAGE, 1, "image") \
    X(CLAST_ENVIRONMENT_CONSTANT, 2, "constant")

/* X(name, value, text): camera projections. */
#define CLAST_PROJECTION_LIST(X) \
    X(CLAST_PROJECTION_PERSPECTIVE, 0, "perspective") \
    X(CLAST_PROJECTION_ORTHOGRAPHIC, 1, "orthographic") \
    X(CLAST_PROJECTION_PANORAMA, 2, "panorama") /* all around: longitude across, latitude up, forward in the middle */

/* X(name, value, text): how radiance becomes a displayed colour. */
#define CLAST_TONE_MAP_LIST(X) \
    X(CLAST_TONE_MAP_ACES, 0, "aces") \
    X(CLAST_TONE_MAP_NONE, 1, "none") \
    X(CLAST_TONE_MAP_AGX, 2, "agx") \
    X(CLAST_TONE_MAP_NEUTRAL, 3, "neutral")

/* X(name, value, text): how light is computed. */
#define CLAST_INTEGRATOR_LIST(X) \
    X(CLAST_INTEGRATOR_PATH, 0, "path")       /* all of it */ \
    X(CLAST_INTEGRATOR_DIRECT, 1, "direct")   /* what lights send straight to surfaces */ \
    X(CLAST_INTEGRATOR_AO, 2, "ao")           /* how open to all sides surfaces are, white */ \
    X(CLAST_INTEGRATOR_PRIMARY, 3, "primary") /* base colours, as lit from the eye */

/* X(name, value, text): what becomes of light that few paths find and that is bright then, as focused by glass. */
#define CLAST_FIREFLIES_LIST(X) \
    X(CLAST_FIREFLIES_KEPT, 0, "keep")       /* all light counts: the mean of many samples is right */ \
    X(CLAST_FIREFLIES_SOFTENED, 1, "soften") /* seen by way of a dull surface, sharp ones are blurred */ \
    X(CLAST_FIREFLIES_CLAMPED, 2, "clamp")   /* indirect light of a sample is bounded */

/* X(name, value, text): image element types. */
#define CLAST_PIXEL_LIST(X) \
    X(CLAST_PIXEL_UNORM8, 0, "8 bit") \
    X(CLAST_PIXEL_UNORM16, 1, "16 bit") \
    X(CLAST_PIXEL_FLOAT, 2, "float")

/* X(name, value, text, channels, is_float, help): the pictures that a render can give. Integer views hold uint32_t,
 * with CLAST_NONE where nothing was hit. */
#define CLAST_VIEW_LIST(X) \
    X(CLAST_VIEW_COLOUR, 0, "colour", 3, 1, "path traced radiance, linear Rec. 709") \
    X(CLAST_VIEW_ALBEDO, 1, "albedo", 3, 1, "base colour at the first hit") \
    X(CLAST_VIEW_NORMAL, 2, "normal", 3, 1, "shading normal in world space") \
    X(CLAST_VIEW_DEPTH, 3, "depth", 1, 1, "distance from the camera along its axis; infinite where nothing is hit") \
    X(CLAST_VIEW_UV, 4, "uv", 2, 1, "first texture coordinates") \
    X(CLAST_VIEW_INSTANCE, 5, "instance", 1, 0, "instance number") \
    X(CLAST_VIEW_CLUSTER, 6, "cluster", 1, 0, "cluster number within the instance's unit") \
    X(CLAST_VIEW_TRIANGLE, 7, "triangle", 1, 0, "triangle number within the cluster") \
    X(CLAST_VIEW_STEPS, 8, "steps", 1, 0, "tree nodes visited by the primary ray") \
    X(CLAST_VIEW_PRIMITIVE, 9, "primitive", 1, 0, "number of the base triangle, or other part, of the geometry") \
    X(CLAST_VIEW_SEGMENTS, 10, "segments", 1, 1, "segments of the nearest base edge; 0 where geometry does not adapt") \
    X(CLAST_VIEW_RATE, 11, "rate", 1, 1, "segments granted over segments wanted, of the nearest base edge") \
    X(CLAST_VIEW_AREA, 12, "area", 1, 1, "pixels that the triangle covers, seen or not") \
    X(CLAST_VIEW_SAMPLES, 13, "samples", 1, 0, "samples that the pixel got: where noise decides, not all get as many")

/* X(name, value, text, help): the passes of a frame, in order. */
#define CLAST_PASS_LIST(X) \
    X(CLAST_PASS_ANIMATE, 0, "animate", "poses and instance transforms of this frame") \
    X(CLAST_PASS_CLASSIFY, 1, "classify", "which instances the camera sees") \
    X(CLAST_PASS_OCCLUDE, 2, "occlude", "which instances lie behind others, by a coarse pass") \
    X(CLAST_PASS_COUNT, 3, "count", "what the wanted rate needs") \
    X(CLAST_PASS_FIT, 4, "fit", "the largest rate that fits the budget") \
    X(CLAST_PASS_EMIT, 5, "emit", "cluster records") \
    X(CLAST_PASS_FILL, 6, "fill", "vertices") \
    X(CLAST_PASS_REFIT, 7, "refit", "cluster acceleration structures") \
    X(CLAST_PASS_BLAS, 8, "blas", "trees over the clusters of each unit") \
    X(CLAST_PASS_TLAS, 9, "tlas", "the tree over the instances") \
    X(CLAST_PASS_LIGHTS, 10, "lights", "tables for sampling the lights") \
    X(CLAST_PASS_TRACE, 11, "trace", "visibility of the primary rays") \
    X(CLAST_PASS_SHADE, 12, "shade", "radiance and the other views")

/* Samples of a pixel at most where a time limit or a noise target ends a render and no count is given. */
#define CLAST_SPP_WITHOUT_COUNT 65536u

/* The settings of a render, from which come clast_render_settings, the command line, the scene file's "settings" and
 * the help. Zero always means the default; a number whose default is another is zero where it is CLAST_ZERO. On the
 * command line, dashes stand for underscores.
 *   UINT(name, default, minimum, maximum, placeholder, help)
 *   REAL(name, default, minimum, maximum, placeholder, help)
 *   CHOICE(name, list, default, help): a value of the named X-macro list
 *   TEXT(name, default, placeholder, help) */
#define CLAST_RENDER_SETTING_LIST(UINT, REAL, CHOICE, TEXT) \
    UINT(width, 1280, 1, 65536, "PIXELS", "width of the picture") \
    UINT(height, 720, 1, 65536, "PIXELS", "height of the picture") \
    TEXT( \
        crop, "", "X,Y,WIDTH,HEIGHT", \
        "part of the picture that is rendered, in pixels from its upper left corner: the same pixels as in the whole") \
    UINT(spp, 16, 1, 1048576, "N", \
         "samples per pixel; not given, up to 65536 where a time limit or a noise target ends the picture") \
    REAL(time_limit, 0.0, 0.0, 1e9, "SECONDS", \
         "renders whole samples of all pixels, one at least, until the next would take longer; 0 is no limit") \
    REAL( \
        noise_target, 0.0, 0.0, 1.0, "NOISE", \
        "ends squares of 8 x 8 pixels whose noise is below it; of 1, what is seen of white: 0.01 is fine; 0 is no target") \
    UINT(min_spp, 32, 1, 1048576, "N", "samples that each pixel gets before noise is looked at, each 16th time") \
    UINT(bounces, 8, 1, 1024, "N", "most surface interactions of a path; 1 is direct light only") \
    UINT(seed, 0, 0, 4294967295u, "N", "seed of the random numbers") \
    UINT(max_clusters, 0, 0, 4294967295u, "N", "most clusters of a frame; 0 is no bound") \
    UINT(max_triangles, 0, 0, 4294967295u, "N", "most triangles of a frame; 0 is no bound") \
    UINT(max_memory, 0, 0, 4294967295u, "MIB", "most MiB of a frame's clusters, vertices and trees; 0 is no bound") \
    REAL(rate, 1.0, 0.0, 1000.0, "FACTOR", \
         "scales the wanted density of geometry that adapts; 0 turns tessellation off") \
    CHOICE( \
        metric, CLAST_METRIC_LIST, CLAST_METRIC_PIXELS, \
        "how the length of an edge's segments is measured: as projected, by distance alone, in the world, or not at all") \
    REAL(segment, 2.0, 1e-6, 1e6, "LENGTH", \
         "wanted length of a segment in the metric's unit; fixed: how many segments an edge has") \
    TEXT(patterns, "", "FILE", "table of patterns that cut triangles, instead of the library's own: docs/patterns.md") \
    REAL(hidden_fraction, 0.25, 0.0, 1.0, "FRACTION", "of the wanted density, what is left where no camera ray looks") \
    REAL(displacement_scale, 1.0, -1e6, 1e6, "FACTOR", "scales the displacement of all materials") \
    TEXT(tess_camera, "", "CAMERA", \
         "camera that decides how finely geometry is tessellated, as --camera has it; without it, the picture's") \
    REAL(time, 0.0, -1e9, 1e9, "SECONDS", "moment of the animation") \
    REAL(shutter, 0.0, 0.0, 1e9, "SECONDS", \
         "how long the shutter is open, from that moment on: what moves is blurred; 0 is no time at all") \
    UINT(shutter_steps, 16, 1, 65536, "N", \
         "moments while the shutter is open: each gets a part of the samples, and a frame of its own") \
    TEXT(animation, "", "ANIMATION", \
         "name or number of an animation of the scene, all at once, or none; without it, the first of each file") \
    REAL(exposure, 0.0, -64.0, 64.0, "STOPS", "exposure of the picture, in powers of two") \
    CHOICE(fireflies, CLAST_FIREFLIES_LIST, CLAST_FIREFLIES_KEPT, \
           "rare bright light, as focused by glass; soften and clamp make less noise, and a darker picture") \
    CHOICE(integrator, CLAST_INTEGRATOR_LIST, CLAST_INTEGRATOR_PATH, \
           "all light, direct light only, openness (ao), or base colours as lit from the eye") \
    REAL(ao_distance, 0.0, 0.0, 1e30, "LENGTH", \
         "how far away what closes a surface for --integrator ao may be; 0 is endless") \
    REAL(aperture, 0.0, 0.0, 1e30, "LENGTH", \
         "diameter of the camera's lens; 0 is the camera's own, which is mostly a pinhole") \
    REAL(focus, 0.0, 0.0, 1e30, "LENGTH", \
         "distance that is sharp; 0 is the camera's own, which is mostly its target's") \
    CHOICE( \
        device, CLAST_DEVICE_LIST, CLAST_DEVICE_AUTO, \
        "what makes the picture: a GPU where there is one and else the processor, the processor, or a Vulkan device") \
    TEXT( \
        device_name, "", "NAME", \
        "part of the name of the Vulkan device that is wanted; drivers that are programs count only where named, as llvmpipe") \
    TEXT( \
        shaders, "", "FOLDER", \
        "kernels of the Vulkan device to use in place of clast's own, as a build leaves them in its folder shaders; read anew " \
        "for each picture, for whoever changes them") \
    CHOICE(accel, CLAST_ACCEL_LIST, CLAST_ACCEL_CLAST, \
           "what rays go through on a Vulkan device: clast's own structures, or those of its driver") \
    CHOICE(tonemap, CLAST_TONE_MAP_LIST, CLAST_TONE_MAP_ACES, "tone map of 8 and 16-bit pictures") \
    TEXT(camera, "", "CAMERA", \
         "name or number of a camera of the scene, or eye/target[/up[/fov]], as 0,1,4/0,0,0/0,1,0/45") \
    TEXT(env, "", "ENV", \
         "image file (.hdr, .png, .jpg), sky, or a colour such as 1,1,1; replaces the scene's environment")

#endif
