// SPDX-License-Identifier: Apache-2.0
// Where the corners of a triangle are that a ray hit: clast_clas_corners.
#ifndef CLAST_ACCEL_CORNERS_GLSL
#define CLAST_ACCEL_CORNERS_GLSL

#include "shared/cluster.h"
#include "source/source.glsl"

ARRAY_OF(cluster_heads, clast_cluster_head, 4)
ARRAY_OF(device_templates, clast_device_template, 4)
ARRAY_OF(device_pairs, clast_pair, 4)

struct triangle_corners
{
    vec3 a, b, c;
};

uvec3 corners_of_word(uint word) { return uvec3(pair_corner(word, 0u), pair_corner(word, 1u), pair_corner(word, 2u)); }

// Of a fan's triangle (a, b, c), in its own order.
uvec3 turn_corners(uvec3 corners, uint turn)
{
    return uvec3(corners[turn % 3u], corners[(turn + 1u) % 3u], corners[(turn + 2u) % 3u]);
}

uvec3 first_corners(clast_pair pair)
{
    uvec3 corners = corners_of_word(pair.first);
    return pair_is_fan(pair) ? turn_corners(corners, pair_first_turn(pair)) : corners;
}

uvec3 second_corners(clast_pair pair)
{
    uvec3 own = corners_of_word(pair.second);
    uvec3 fan = uvec3(pair_corner(pair.first, 0u), pair_corner(pair.first, 2u), own[2]);
    return pair_is_fan(pair) ? turn_corners(fan, pair_second_turn(pair)) : own;
}

// The corners of a triangle by its number, among pairs.
uvec3 corners_among(uint64_t address, uint count, uint triangle)
{
    device_pairs pairs = device_pairs(address);
    for (uint i = 0u; i < count; i++) {
        clast_pair pair = pairs.at[i];
        if (pair.first >> 24u == triangle) {
            return first_corners(pair);
        }
        if (pair.second >> 24u == triangle) {
            return second_corners(pair);
        }
    }
    return uvec3(0u, 0u, 0u);
}

triangle_corners corners_of_hit(frame_reference frame, unit_reference unit, clast_cluster_record record, uint cluster,
                                uint triangle)
{
    uint place = uints(load_address(unit.of.places)).at[cluster];
    cluster_heads head = cluster_heads(load_address(unit.of.clusters) + uint64_t(CLUSTER_UNIT) * uint64_t(place));
    uvec3 corners;
    if (record_form(record) == FORM_WHOLE) {
        device_templates templates = device_templates(load_address(frame.of.templates));
        uints words = uints(load_address(templates.at[record.template_index].corners));
        corners = corners_of_word(words.at[triangle]);
    } else {
        corners = corners_among(load_address(head.at[0].pairs), cluster_pairs(head.at[0].counts), triangle);
    }
    positions3 vertices = positions3(load_address(head.at[0].vertices));
    return triangle_corners(load3(vertices.at[corners[0]]), load3(vertices.at[corners[1]]), load3(vertices.at[corners[2]]));
}

#endif
