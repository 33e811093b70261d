// SPDX-License-Identifier: Apache-2.0
// Fills clusters of a benchmark's surface, and fits them while their vertices are on the chip. A cluster is a grid of 8x8 quads,
// or half a cell, cut by a pattern.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "shared/cluster.h"
#include "shared/pattern.h"
#include "bench/surface.glsl"

layout(constant_id = 0) const uint SURFACE = 0u;
layout(constant_id = 1) const uint PATTERNS = 0u; // 1: halves of cells
layout(constant_id = 2) const uint FITS = 1u;     // 0: vertices are written, and that is all
#define LANES_CONSTANT 3
#define GROUP_CONSTANT 4
#include "accel/fit.glsl"

ARRAY_OF(bench_clusters, clast_device_cluster, 4)
ARRAY_OF(bench_patterns, clast_pattern, 4)

layout(push_constant, scalar) uniform clast_bench_push {
    uint64_t inputs, templates;
    uint64_t vertices, clusters;
    uint64_t boxes;
    uint64_t patterns, weights; // of patterns: geometry/pattern.h
    uint64_t rotations;         // of each cluster's pattern
    uvec2 logarithms;           // of the cells along the sides
    uint count;
    float time;
}
push;

const uint QUADS = 8u;

// `step` is from a vertex of the cell to the next.
vec2 place_in_grid(uvec2 cell, vec2 step, uint vertex)
{
    uvec2 corner = cell * QUADS + uvec2(vertex % (QUADS + 1u), vertex / (QUADS + 1u));
    return vec2(corner) * step;
}

vec2 place_in_pattern(uint cluster, uint pattern, uint vertex)
{
    uint word = uints(push.weights).at[bench_patterns(push.patterns).at[pattern].first_vertex + vertex];
    clast_weights weights = pattern_unrotate(weights_of(word), uints(push.rotations).at[cluster]);
    bool upper = (cluster & 1u) != 0u;
    vec2 second = upper ? vec2(1.0, 1.0) : vec2(1.0, 0.0);
    vec2 third = upper ? vec2(0.0, 1.0) : vec2(1.0, 1.0);
    vec2 inside = (second * to_float(weights.of[1]) + third * to_float(weights.of[2])) / to_float(WEIGHT_ONE);
    return (vec2(bench_cell(cluster >> 1u, push.logarithms)) + inside) /
           vec2(1u << push.logarithms.x, 1u << push.logarithms.y);
}

void main()
{
    uint number = cluster_of_group();
    if (number >= push.count) {
        return;
    }
    clast_device_cluster from = bench_clusters(push.inputs).at[number];
    clast_device_template topology = fit_templates(push.templates).at[from.template_number];
    uvec2 cell = bench_cell(number, push.logarithms);
    vec2 step = 1.0 / vec2(QUADS << push.logarithms.x, QUADS << push.logarithms.y);
    for (uint i = cluster_lane(); i < topology.vertices; i += LANES) {
        vec2 place = PATTERNS != 0u ? place_in_pattern(number, from.template_number, i) : place_in_grid(cell, step, i);
        set_cluster_point(i, bench_surface(SURFACE, place, push.time));
    }
    cluster_barrier();
    fit_target target;
    target.head = push.clusters + uint64_t(CLUSTER_UNIT) * from.place;
    target.vertices = push.vertices + 12ul * from.first_vertex;
    target.pairs = load_address(topology.pairs);
    target.box = push.boxes + 24ul * number;
    target.cluster = number;
    target.counts = topology.counts;
    target.own_triangles = 0u;
    store_cluster_points(target.vertices, topology.vertices);
    if (FITS != 0u) {
        fit_cluster(target);
    }
}
