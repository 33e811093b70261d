#version 460
// SPDX-License-Identifier: Apache-2.0
// Placements of trees that stand in a list, and boxes around them in the world (vulkan/place.h).
#extension GL_GOOGLE_include_directive : require
#include "accel/place.glsl"

layout(local_size_x = 128) in;

ARRAY_OF(tree_list, clast_device_tree, 8)

layout(push_constant, scalar) uniform place_push
{
    uint64_t maps;       // clast_device_map: the unit is a number in `trees`
    uint64_t trees;      // clast_device_tree
    uint64_t placements; // gets clast_device_placement
    uint64_t boxes;      // gets the clast_box of each
    uint count;
}
push;

void main()
{
    uint number = linear_group() * 128u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    clast_device_map map = map_list(push.maps).at[number];
    clast_device_placement placement = placement_of(map);
    clast_box world = empty_box();
    if (map.condition > 0.0) {
        clast_device_tree tree = tree_list(push.trees).at[map.unit];
        placement.box = boxes(load_address(tree.bounds)).at[0];
        placement.clusters = tree.clusters;
        bool there = load3(placement.box.lower)[0] <= load3(placement.box.upper)[0];
        clast_box around = world_box(map, placement.box);
        if (there && is_within(around)) {
            world = around;
            placement.nodes = tree.nodes;
        }
    }
    placement_list(push.placements).at[number] = placement;
    boxes(push.boxes).at[number] = world;
}
