// SPDX-License-Identifier: Apache-2.0
// Clusters as triangles for the driver: three numbers of positions each, and which triangle of clast it is. A group a cluster;
// a cluster's triangles stand in their order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/corners.glsl"
#include "shared/driver.h"

layout(local_size_x = 64) in;

// vulkan/driver_instances.c hands these over.
layout(push_constant, scalar) uniform clast_driver_triangles_push {
    uint64_t clusters;  // of the unit
    uint64_t places;    // of the clusters, in CLUSTER_UNITs from there on; 0: each `space` after the one before
    uint64_t firsts;    // the triangles before each cluster; 0: each has `triangles`
    uint64_t positions; // which numbers count from
    uint64_t indices;
    uint64_t triangles_of; // driver_triangle() of each
    uint count;            // clusters
    uint space;
    uint triangles;
}
push;

bool is_sound(positions3 vertices, uint corner) { return is_sound3(load3(vertices.at[corner])); }

// A vertex of the cluster that boxes can hold, where there is one.
uint find_sound(clast_cluster_head head, positions3 vertices, uint otherwise)
{
    for (uint i = 0u; i < cluster_pairs(head.counts); i++) {
        clast_pair pair = device_pairs(load_address(head.pairs)).at[i];
        for (uint k = 0u; k < 3u; k++) {
            if (is_sound(vertices, first_corners(pair)[k])) {
                return first_corners(pair)[k];
            }
        }
    }
    return otherwise;
}

// Triangles with a corner that is not sound are hit by nothing: they become points, and these sound ones, as what drivers make of
// others is their own affair.
uvec3 sound_corners(clast_cluster_head head, uvec3 corners)
{
    positions3 vertices = positions3(load_address(head.vertices));
    if ((head.counts & CLUSTER_UNSOUND) == 0u ||
        is_sound(vertices, corners[0]) && is_sound(vertices, corners[1]) && is_sound(vertices, corners[2])) {
        return corners;
    }
    return uvec3(find_sound(head, vertices, corners[0]));
}

void write_triangle(clast_cluster_head head, uint place, uint number, uvec3 corners)
{
    uint base = uint((load_address(head.vertices) - push.positions) / 12ul);
    corners = sound_corners(head, corners);
    uints indices = uints(push.indices);
    for (uint k = 0u; k < 3u; k++) {
        indices.at[3u * place + k] = base + corners[k];
    }
    uints(push.triangles_of).at[place] = driver_triangle(head.cluster, number);
}

void main()
{
    uint cluster = linear_group();
    if (cluster >= push.count) {
        return;
    }
    uint place = push.places != 0ul ? uints(push.places).at[cluster] : cluster * push.space;
    clast_cluster_head head = cluster_heads(push.clusters + uint64_t(place) * CLUSTER_UNIT).at[0];
    uint first = push.firsts != 0ul ? uints(push.firsts).at[cluster] : cluster * push.triangles;
    uint end = push.firsts != 0ul ? uints(push.firsts).at[cluster + 1u] : first + push.triangles;
    for (uint i = gl_LocalInvocationIndex; i < 2u * cluster_pairs(head.counts); i += gl_WorkGroupSize.x) {
        clast_pair pair = device_pairs(load_address(head.pairs)).at[i / 2u];
        uint number = (i % 2u == 0u ? pair.first : pair.second) >> 24u;
        bool is_there = i % 2u == 0u || !pair_is_lone(pair);
        if (is_there && first + number < end) {
            write_triangle(head, first + number, number, i % 2u == 0u ? first_corners(pair) : second_corners(pair));
        }
    }
}
