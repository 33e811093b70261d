// SPDX-License-Identifier: Apache-2.0
// Triangles and instances for the driver's own acceleration structures: what tells rays through these what they hit.
#ifndef CLAST_SHARED_DRIVER_H
#define CLAST_SHARED_DRIVER_H

#include "shared/records.h"

LIMIT(DRIVER_CLUSTERS_MOST, 0x1000000u, "clusters of a unit: 24 bits beside a triangle's 8")
LIMIT(DRIVER_INSTANCES_MOST, 0x1000000u, "instances: drivers number them by 24 bits")

// Which triangle of clast a triangle of the driver's is.
FN uint driver_triangle(uint cluster, uint triangle) { return cluster << 8u | triangle; }
FN uint driver_triangle_cluster(uint word) { return word >> 8u; }
FN uint driver_triangle_number(uint word) { return word & 255u; }

LIMIT(DRIVER_MIRRORED, 1u, "the map turns space inside out")

// What an instance shows, by its place in the list.
RECORD(clast_driver_shape)
{
    clast_transform to_world;
    packed_address positions; // packed3
    packed_address indices;   // three positions of each triangle
    packed_address triangles; // driver_triangle() of each
    uint id;                  // what hits report
    uint flags;               // DRIVER_ bits
};
RECORD_SIZE(clast_driver_shape, 80)

// What rays are traced through.
RECORD(clast_driver_top)
{
    packed_address structure; // the driver's, over instances
    packed_address shapes;    // clast_driver_shape of each
};
RECORD_SIZE(clast_driver_top, 16)

#endif
