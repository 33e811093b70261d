#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: Apache-2.0
// Fits clusters whose vertices lie in memory, a subgroup each; where they are gathered from shared ones, copies them there
// first (vulkan/fit.h).
#define LANES_CONSTANT 0
#define GROUP_CONSTANT 1
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
    uint64_t address = push.vertices + 12ul * first;
    if (push.positions == 0ul) {
        for (uint i = cluster_lane(); i < 3u * count; i += LANES) {
            float coordinate = floats(address).at[i];
            cluster_size_bits = max(cluster_size_bits, size_bits(coordinate));
            cluster_floats[cluster_slot() * CLUSTER_FLOATS + i] = coordinate;
        }
        cluster_barrier();
        return true;
    }
    bool refused = false;
    for (uint i = cluster_lane(); i < count; i += LANES) {
        uint number = uints(push.numbers + 4ul * first).at[i];
        if (number < push.position_count) {
            set_cluster_point(i, load3(positions3(push.positions).at[number]));
        } else {
            refused = true;
        }
    }
    cluster_barrier();
    if (subgroupAny(refused)) {
        if (cluster_lane() == 0u) {
            atomicOr(uints(push.faults).at[0], 1u);
        }
        return false;
    }
    store_cluster_points(address, count);
    return true;
}

void main()
{
    if (cluster_of_group() >= push.count) {
        return;
    }
    uint number = push.first + cluster_of_group();
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
    target.own_triangles = 0u;
    fit_cluster(target);
}
