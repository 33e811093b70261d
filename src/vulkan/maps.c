// SPDX-License-Identifier: Apache-2.0
#include "vulkan/maps.h"

#include <math.h>
#include <string.h>

#include "shared/cluster.h"

// The largest row sum of |map| |inverse|, at least 1: what place.kernel.c finds of several.
static float condition_of(const clast_placement *placement)
{
    double most = 1.0;
    for (int row = 0; row < 3; row++) {
        double sum = 0.0;
        for (int k = 0; k < 3; k++) {
            double inner = 0.0;
            for (int column = 0; column < 3; column++) {
                inner += fabs((double)placement->to_object[column][k]);
            }
            sum += fabs((double)placement->to_world[k][row]) * inner;
        }
        most = sum > most ? sum : most;
    }
    // what is stored was rounded
    most *= 1.00001;
    return most < 1e20 ? (float)most : 1e20f;
}

static clast_device_map map_of(const clast_placement *placement)
{
    clast_device_map map = {.condition = 0.0f};
    if (placement->blas != NULL) {
        map.condition = condition_of(placement);
        map.flags = placement->mirrored ? PLACEMENT_MIRRORED : 0;
        for (int column = 0; column < 3; column++) {
            memcpy(&map.to_object[column], placement->to_object[column], sizeof map.to_object[column]);
            memcpy(&map.to_world[column], placement->to_world[column], sizeof map.to_world[column]);
        }
        memcpy(&map.origin, placement->origin, sizeof map.origin);
    }
    return map;
}

void clast_make_maps(clast_place_kernel place, const clast_transform *const *transforms, size_t count,
                     clast_device_map *maps)
{
    clast_box box = {{{0.0f, 0.0f, 0.0f}}, {{0.0f, 0.0f, 0.0f}}};
    const clast_blas somewhere = {.tree = {.boxes = &box, .node_count = 1}};
    clast_tlas_instance instances[CLAST_MAPS_TOGETHER] = {{0}};
    clast_placement placements[CLAST_MAPS_TOGETHER];
    clast_box boxes[CLAST_MAPS_TOGETHER];
    for (size_t i = 0; i < count; i++) {
        instances[i] = (clast_tlas_instance){.blas = &somewhere};
        memcpy(instances[i].transform, transforms[i], sizeof instances[i].transform);
    }
    place(instances, NULL, 0, count, placements, boxes);
    for (size_t i = 0; i < count; i++) {
        maps[i] = map_of(&placements[i]);
    }
}
