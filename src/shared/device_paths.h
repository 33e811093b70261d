// SPDX-License-Identifier: Apache-2.0
// Light paths in a device's memory. A tile of the picture at a time is under way: squares of SQUARE_PIXELS pixels, one after
// the other in a list, each pixel with a path of its own at a place of its own. Lists tell which paths go on; the order of a list
// depends on timing, and nothing else depends on that order.
#ifndef CLAST_SHARED_DEVICE_PATHS_H
#define CLAST_SHARED_DEVICE_PATHS_H

#include "shared/path.h"
#include "shared/square.h"

LIMIT(PATH_GROUP, 128u, "invocations of a work group")
LIMIT(RENDER_VIEWS, 14u, "views that there are")

// A path's pieces of four floats, each in an array of its own:
//   throughput x y z, absorption x
//   radiance x y z, absorption y
//   shares of surroundings, sun and the tree where its ray began, absorption z
//   origin of its ray x y z, density with which that was chosen
//   direction of its ray x y z, least width of the lobes to come
//   width and spread of the cone around its ray, nothing, nothing
//   where its ray began as lights see it: clast_lit_point
LIMIT(PATH_THROUGHPUT, 0u, "piece of a path")
LIMIT(PATH_RADIANCE, 1u, "piece of a path")
LIMIT(PATH_SHARES, 2u, "piece of a path")
LIMIT(PATH_ORIGIN, 3u, "piece of a path")
LIMIT(PATH_DIRECTION, 4u, "piece of a path")
LIMIT(PATH_CONE, 5u, "piece of a path")
LIMIT(PATH_LIT, 6u, "piece of a path")
LIMIT(PATH_PIECES, 7u, "how many there are")

// What a path's ray hit, in three pieces of four words:
//   instance, cluster, triangle, steps
//   barycentrics, distance, nothing
//   normal x y z, nothing
LIMIT(HIT_PIECES, 3u, "pieces of a hit")

// A path's shadow ray to a light, or to the sun, in three pieces:
//   origin x y z, where it ends
//   direction x y z, nothing
//   the radiance that arrives where nothing is in between x y z, nothing
LIMIT(SHADOW_PIECES, 3u, "pieces of a shadow ray")

// Lists of paths that a step of the paths makes.
LIMIT(LIST_NEXT, 0u, "those that go on")
LIMIT(LIST_LIGHT, 1u, "those with a shadow ray to a light")
LIMIT(LIST_SUN, 2u, "those with a shadow ray to the sun")
LIMIT(LISTS, 3u, "how many there are")
LIMIT(LIST_ARRAYS, 4u, "those that go on at even steps, at odd ones; then the others")

LIMIT(PATH_TRACE_GROUP, 64u, "invocations of a work group that traces rays")
LIMIT(PATH_TRACE_RAYS, 8u, "rays for each invocation that traces those of a list, at least")

// How long lists are.
RECORD(clast_path_queue)
{
    uint groups[9];       // of what works on each list: three numbers a list, as indirect dispatches read them
    uint trace_groups[9]; // likewise of what traces its rays
    uint lengths[3];
    uint tickets[3];      // of rays that are traced: the next that nobody took
    uint growing[3];      // lengths of the lists that a step is making
    uint rejected;        // samples that were not finite
    packed_address rays;  // traced beside the primary ones
};
RECORD_SIZE(clast_path_queue, 120)

// A render.
RECORD(clast_device_render)
{
    packed_address frame;     // clast_device_frame
    packed_address materials; // clast_device_materials
    packed_address lights;    // clast_device_lights
    packed_address paths;     // PATH_PIECES arrays of `capacity`
    packed_address direct;    // of each path, the light that was not clamped: four floats; 0 where nothing is clamped
    packed_address hits;      // HIT_PIECES arrays of `capacity`
    packed_address shadows;   // SHADOW_PIECES arrays of `capacity` for a light; then the same for the sun
    packed_address lists;     // LIST_ARRAYS of `capacity` paths
    packed_address queue;     // clast_path_queue
    packed_address views[14]; // by CLAST_VIEW_: rows of pixels; 0 where it is not wanted
    packed_address squares;   // those that go on
    packed_address halves;    // sums of colour of the samples of pixels' halves; 0 where no noise is too much
    packed_address noise;     // of each square; likewise
    uint capacity;            // paths that can be under way
    uint width;               // of the whole picture
    uint height;
    uint area_x;              // what is rendered of it: pixels of views are its
    uint area_y;
    uint area_width;
    uint area_height;
    uint squares_across;
    uint seed;
    uint power;               // of two: samples that points are laid out for
    uint bounces;             // most of a path
    uint integrator;          // CLAST_INTEGRATOR_
    uint fireflies;           // CLAST_FIREFLIES_
    float ao_distance;        // infinite where it is endless
    float rate;               // wanted density of geometry
    float gain;               // two to the power of the exposure
};
RECORD_SIZE(clast_device_render, 12 * 8 + 14 * 8 + 64)

#endif
