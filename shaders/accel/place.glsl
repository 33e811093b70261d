// SPDX-License-Identifier: Apache-2.0
// Boxes around instances in the world: the device's part of src/accel/place.kernel.c. The processor has inverted the maps, in
// double precision.
#ifndef CLAST_ACCEL_PLACE_GLSL
#define CLAST_ACCEL_PLACE_GLSL

#include "gpu.glsl"
#include "shared/cluster.h"
#include "shared/device.h"

ARRAY_OF(placement_list, clast_device_placement, 16)
ARRAY_OF(map_list, clast_device_map, 4)

// The largest that a coordinate in the world may be, and how far a box is padded: as in place.kernel.c, and by some roundings
// of floats.
const float WORLD_MOST = 6.6461399789245794e35; // 2^119
const float SPREAD_STEP = 7.62939453125e-6;     // 2^-17
const float ROUNDING = 1.9073486328125e-6;      // 2^-19

clast_box empty_box()
{
    clast_box box;
    box.lower = packed3(uintBitsToFloat(0x7f800000u));
    box.upper = packed3(uintBitsToFloat(0xff800000u));
    return box;
}

clast_box world_box(clast_device_map map, clast_box box)
{
    precise vec3 low = vec3(0.0);
    precise vec3 high = vec3(0.0);
    vec3 lower = load3(box.lower);
    vec3 upper = load3(box.upper);
    for (uint k = 0u; k < 3u; k++) {
        vec3 column = load3(map.to_world[k]);
        precise vec3 a = column * lower[k];
        precise vec3 b = column * upper[k];
        low += min3(a, b);
        high += max3(a, b);
    }
    vec3 origin = load3(map.origin);
    precise float farthest = max1(largest3(vec3(abs1(low.x), abs1(low.y), abs1(low.z))),
                                  largest3(vec3(abs1(high.x), abs1(high.y), abs1(high.z))));
    precise float sizes = farthest + largest3(vec3(abs1(origin.x), abs1(origin.y), abs1(origin.z)));
    precise float pad = farthest * map.condition * SPREAD_STEP + sizes * ROUNDING;
    precise vec3 least = origin + low - splat3(pad);
    precise vec3 most = origin + high + splat3(pad);
    clast_box world;
    world.lower = store3(least);
    world.upper = store3(most);
    return world;
}

bool is_within(clast_box box)
{
    bool within = true;
    for (uint axis = 0u; axis < 3u; axis++) {
        within = within && load3(box.lower)[axis] >= -WORLD_MOST && load3(box.upper)[axis] <= WORLD_MOST;
    }
    return within;
}

// Where an instance is. Its tree is not there yet.
clast_device_placement placement_of(clast_device_map map)
{
    clast_device_placement placement;
    placement.nodes = store_address(0ul);
    placement.clusters = store_address(0ul);
    placement.id = map.id;
    placement.flags = map.flags;
    placement.to_object = map.to_object;
    placement.to_world = map.to_world;
    placement.origin = map.origin;
    placement.unit = map.unit;
    placement.unused[0] = placement.unused[1] = 0u;
    placement.box = empty_box();
    return placement;
}

#endif
