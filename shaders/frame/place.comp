#version 460
// SPDX-License-Identifier: Apache-2.0
// What placements tell of their units, and boxes around them in the world.
#extension GL_GOOGLE_include_directive : require
#include "accel/place.glsl"
#include "source/source.glsl"

layout(local_size_x = 128) in;

layout(push_constant, scalar) uniform place_push
{
    uint64_t units;      // clast_device_unit
    uint64_t maps;       // clast_device_map
    uint64_t placements; // clast_device_placement
    uint64_t boxes;      // clast_box of each
    uint count;
} push;

void main()
{
    uint number = linear_group() * 128u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    clast_device_map map = map_list(push.maps).at[number];
    unit_reference unit = unit_at(push.units, map.unit);
    uint clusters = unit.of.record_count;
    clast_device_placement placement = placement_of(map);
    placement.clusters = unit.of.clusters;
    placement.flags |= unit.of.filtered != 0u ? PLACEMENT_FILTERED : 0u;
    clast_box world = empty_box();
    if (clusters != 0u && map.condition > 0.0) {
        placement.box = boxes(load_address(unit.of.boxes)).at[clusters];
        bool there = load3(placement.box.lower)[0] <= load3(placement.box.upper)[0];
        clast_box around = world_box(map, placement.box);
        if (there && is_within(around)) {
            world = around;
            placement.nodes = unit.of.tree;
        }
    }
    placement_list(push.placements).at[number] = placement;
    boxes(push.boxes).at[number] = world;
}
