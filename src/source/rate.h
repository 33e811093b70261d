// SPDX-License-Identifier: Apache-2.0
// Segments of edges and levels of maps, many at once: what counting and emitting do most. The kernels restate rate_point(),
// vertex_level(), edge_wanted() and edge_factor() of shared/tessellation.h and those of shared/occlusion.h, to the bit.
#ifndef CLAST_SOURCE_RATE_H
#define CLAST_SOURCE_RATE_H

#include "base/isa.h"
#include "shared/occlusion.h"

enum {
    RATE_POINTS = 128,    // most points of a cluster or of a pattern
    RATE_LANES_MOST = 16, // as many are read and written at once
};

// Points of a surface, displaced by a height each, by array.
typedef struct clast_rate_points {
    _Alignas(64) float positions[3][RATE_POINTS]; // not displaced
    float normals[3][RATE_POINTS];
    float heights[RATE_POINTS];
    float density_squares[RATE_POINTS], shortest_squares[RATE_POINTS]; // as vertex_level() takes them
} clast_rate_points;

// What a point comes to in a view.
enum {
    RATE_POSITION = 0, // not displaced
    RATE_NORMAL = 3,
    RATE_CAMERA = 6, // clast_rate_point, displaced
    RATE_SCREEN = 9,
    RATE_FACING = 11,
};
typedef struct clast_rate_site {
    _Alignas(64) float of[16];
} clast_rate_site;

typedef struct clast_rate_edges {
    const clast_rate_site *sites;
    const clast_rate_edge *edges;
    uint32_t count;
    float scale; // of the displacement
    bool curved; // the middle lies on a curve
    // Null, or by edge: the middle, instead of what follows from the ends; and how far the weights of the ends are apart.
    const clast_rate_site *middles;
    const uint32_t *apart;
} clast_rate_edges;

// The depths of the first place; null where edges are not compared with them.
static inline const float *clast_rate_depths(const clast_rate_view *view)
{
    return view->looks != 0 ? (const float *)(uintptr_t)load_address(view->depths) : NULL;
}

// Whether a view's depths hide an edge: 1 for nothing of it, 0 for all.
static inline float clast_rate_open(const clast_rate_view *view, clast_rate_point a, clast_rate_point middle,
                                    clast_rate_point b)
{
    const float *depths = clast_rate_depths(view);
    if (depths == NULL) {
        return 1.0f;
    }
    clast_edge_place edge = edge_place(*view, a, middle, b);
    float radius = 0.0f;
    for (uint32_t i = 0; i < OCCLUSION_DEPTHS; i++) {
        radius += occlusion_part(edge, depths[(size_t)edge.place * OCCLUSION_DEPTHS + i], i);
    }
    return occlusion_open(edge, radius);
}

// The first `count` points; room for the arrays' full length of each.
typedef void (*clast_rate_points_kernel)(const clast_rate_view *view, const clast_rate_points *points, uint32_t count,
                                         clast_rate_site *sites, uint16_t *levels);
// By edge: its segments; 1 where both ends are one site.
typedef void (*clast_rate_edges_kernel)(const clast_rate_view *view, const clast_rate_edges *edges, uint32_t *factors);

typedef struct clast_rate_kernels {
    clast_rate_points_kernel points;
    clast_rate_edges_kernel edges;
} clast_rate_kernels;
const clast_rate_kernels *clast_rate_kernels_of(clast_isa isa);

#define CLAST_DECLARE_RATE(set) \
    void clast_rate_points_##set(const clast_rate_view *view, const clast_rate_points *points, uint32_t count, \
                                 clast_rate_site *sites, uint16_t *levels); \
    void clast_rate_edges_##set(const clast_rate_view *view, const clast_rate_edges *edges, uint32_t *factors);
CLAST_EACH_ISA(CLAST_DECLARE_RATE)

#endif
