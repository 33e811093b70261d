#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Fits clusters whose vertices lie in memory, a work group each; where they are gathered from shared ones, copies them there
// first (vulkan/fit.h).
#include "gpu.glsl"
#include "shared/cluster.h"

layout(local_size_x = 128) in;

shared vec3 cluster_points[TEMPLATE_VERTICES];
shared uint fit_refused;

#include "accel/fit.glsl"

ARRAY_OF(fit_inputs, clast_device_cluster, 4)

layout(push_constant, scalar) uniform clast_fit_push
{
    uint64_t templates, inputs;
    uint64_t vertices;  // of all clusters
    uint64_t clusters;  // where the clusters begin to be counted
    uint64_t boxes;     // by number of the cluster
    uint64_t positions; // shared ones; 0: vertices are there already
    uint64_t numbers;   // of the position of each vertex
    uint64_t faults;    // one number: gets a 1 where one is out of range
    uint first, count;
    uint position_count;
}
push;

// The vertices of a cluster; from shared ones, where these are used. False, for all invocations, where a number is wrong.
bool load_points(uint first, uint count)
{
    uint lane = gl_LocalInvocationIndex;
    positions3 vertices = positions3(push.vertices + 12ul * first);
    if (push.positions == 0ul) {
        for (uint i = lane; i < count; i += FIT_GROUP) {
            cluster_points[i] = load3(vertices.at[i]);
        }
        barrier();
        return true;
    }
    uints numbers = uints(push.numbers + 4ul * first);
    if (lane == 0u) {
        fit_refused = 0u;
    }
    barrier();
    for (uint i = lane; i < count; i += FIT_GROUP) {
        uint number = numbers.at[i];
        if (number < push.position_count) {
            cluster_points[i] = load3(positions3(push.positions).at[number]);
        } else {
            atomicOr(fit_refused, 1u);
        }
    }
    barrier();
    if (fit_refused != 0u) {
        if (lane == 0u) {
            atomicOr(uints(push.faults).at[0], 1u);
        }
        return false;
    }
    for (uint i = lane; i < count; i += FIT_GROUP) {
        vertices.at[i] = store3(cluster_points[i]);
    }
    return true;
}

void main()
{
    uint group = linear_group();
    if (group >= push.count) {
        return;
    }
    uint number = push.first + group;
    clast_device_cluster from = fit_inputs(push.inputs).at[number];
    clast_device_template topology = fit_templates(push.templates).at[from.template_number];
    if (!load_points(from.first_vertex, topology.vertices)) {
        return;
    }
    fit_target target;
    target.head = push.clusters + uint64_t(CLUSTER_UNIT) * from.place;
    target.vertices = push.vertices + 12ul * from.first_vertex;
    target.pairs = load_address(topology.pairs);
    target.box = push.boxes + 24ul * number;
    target.cluster = number;
    target.counts = topology.counts;
    fit_cluster(target, fit_template_pair(target));
}
