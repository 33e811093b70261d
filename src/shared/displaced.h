// SPDX-License-Identifier: Apache-2.0
// Displaced meshes as they are cooked, and the formulas by which they are cut and moved that are theirs alone: what the source
// `displaced` keeps (source/displaced.h tells how it hangs together).
#ifndef CLAST_SHARED_DISPLACED_H
#define CLAST_SHARED_DISPLACED_H

#include "shared/device.h"
#include "shared/tessellation.h"

// The arrays of a unit, after those of its mesh.
LIMIT(DISPLACED_ARRAY_HEADER, 9u, "clast_displaced_header, one")
LIMIT(DISPLACED_ARRAY_CLUSTERS, 10u, "clast_displaced_cluster, by item")
LIMIT(DISPLACED_ARRAY_TRIANGLES, 11u, "clast_displaced_triangle")
LIMIT(DISPLACED_ARRAY_MESH_TRIANGLES, 12u, "the mesh's triangle, for each of them")
LIMIT(DISPLACED_ARRAY_VERTEX_NUMBERS, 13u, "into the vertices, for each of the clusters' vertices")
LIMIT(DISPLACED_ARRAY_EDGES, 14u, "clast_rate_edge")
LIMIT(DISPLACED_ARRAY_SEAMS, 15u, "clast_displaced_seam")
LIMIT(DISPLACED_ARRAY_VERTICES, 16u, "clast_displaced_vertex, and one more, of which first_normal counts")
LIMIT(DISPLACED_ARRAY_NORMALS, 17u, "clast_displaced_normal_part")
LIMIT(DISPLACED_ARRAY_VERTEX_OF, 18u, "by the mesh's vertex: into the vertices, CLAST_NONE where no triangle has it")
LIMIT(DISPLACED_ARRAY_GRADIENTS_0, 19u, "clast_displaced_gradient, by the mesh's vertex; none where no map needs them")
LIMIT(DISPLACED_ARRAY_GRADIENTS_1, 20u, "of the second set of coordinates")
LIMIT(DISPLACED_ARRAY_MAPS, 21u, "clast_displaced_map")
LIMIT(DISPLACED_ARRAY_MAP_OF_MATERIAL, 22u, "into the maps")
LIMIT(DISPLACED_ARRAY_PATTERNS, 23u, "clast_pattern, PATTERN_COUNT of them")
LIMIT(DISPLACED_ARRAY_PATTERN_VERTICES, 24u, "weights_word()")
LIMIT(DISPLACED_ARRAY_PATTERN_TRIANGLES, 25u, "three vertices of the pattern, 8 bits each")
LIMIT(DISPLACED_ARRAYS, 26u, "how many there are with the mesh's own")

LIMIT(DISPLACED_EDGES, 384u, "most edges of a cluster: three of each triangle")
LIMIT(DISPLACED_NO_SEAM, 0xffffu, "of an edge whose triangles in the cluster have what its owner has")
LIMIT(DISPLACED_NO_MAP, 0u, "the first map moves nothing")
LIMIT(DISPLACED_SPLITS_DEEPEST, 24u, "most splits above a part; each makes halves at least: thousands of segments take five")
LIMIT(DISPLACED_ITEM_TRIANGLES, 0x40000000u, "an item of more comes to 2^32 - 1 of everything: no frame can hold it")

LIMIT(DISPLACED_CURVED, 1u, "triangles bend along their normals")
LIMIT(DISPLACED_CLOSED, 2u, "each edge has as many triangles to either side")
LIMIT(DISPLACED_OPAQUE, 4u, "nothing is seen through it")
LIMIT(DISPLACED_MOVED, 8u, "some map moves something")

RECORD(clast_displaced_header)
{
    uint flags;
    uint first_pattern; // template of the first pattern
    float height_most;  // the largest height either way, where the displacement's scale is 1
    clast_box rest;     // of the undisplaced surface
    clast_box reach;    // what displacement adds where its scale is 1
};
RECORD_SIZE(clast_displaced_header, 60)

// How a material uses a displacement texture.
RECORD(clast_displaced_map)
{
    uint is_there;      // 0: nothing is moved
    float scale;        // the height is value * scale + offset
    float offset;
    uint coordinate_set;
    packed2 columns[2]; // coordinates of the map: columns[0] * u + columns[1] * v + moved
    packed2 moved;
};
RECORD_SIZE(clast_displaced_map, 40)

// A vertex of the welded mesh. The order is that in which devices read four words at once.
RECORD(clast_displaced_vertex)
{
    packed3 position;      // at rest
    uint map;
    packed3 normal;        // at rest, of unit length or zero
    float height;          // at rest, where the displacement's scale is 1
    packed2 coordinates;   // of its map
    float density_square;  // texels for each length: the least of its triangles
    float shortest_square; // of its edges
    uint mesh_vertex;      // the owner's corner
    uint first_normal;     // of what its normal is made of in a pose: up to the next vertex's; none: mesh_vertex's own
    uint unused[2];
};
RECORD_SIZE(clast_displaced_vertex, 64)

// What counts for a vertex's normal: a vertex of the mesh or, where that has no normals, a triangle.
RECORD(clast_displaced_normal_part)
{
    uint number;
    float weight;
};
RECORD_SIZE(clast_displaced_normal_part, 8)

// Of a cluster. Edge k goes from corner k to corner k + 1.
RECORD(clast_displaced_triangle)
{
    uint corners; // vertices of the cluster, 8 bits each; above them 1 where it is plain: the owners' coordinates and map are
                  // its own, all around
    uint edges;   // edges of the cluster, 9 bits each; above them a bit for each that it has in the edge's own direction
};
RECORD_SIZE(clast_displaced_triangle, 8)

FN uint displaced_corner(clast_displaced_triangle triangle, uint k) { return triangle.corners >> 8u * k & 255u; }
FN bool displaced_is_plain(clast_displaced_triangle triangle) { return triangle.corners >> 24u != 0u; }
FN uint displaced_edge_of(clast_displaced_triangle triangle, uint k) { return triangle.edges >> 9u * k & 511u; }
FN bool displaced_goes_along(clast_displaced_triangle triangle, uint k) { return (triangle.edges >> (27u + k) & 1u) != 0u; }

// Of a cluster's edge (clast_rate_edge), whose ends are vertices of the cluster: above them stands its seam, counted from the
// cluster's first.
FN uint displaced_seam_of(clast_rate_edge edge) { return edge.ends >> 16u; }

// What the owner of an edge has at its two ends, where a triangle of the cluster has something else.
RECORD(clast_displaced_seam)
{
    packed2 coordinates[2]; // of the map
    uint map;
};
RECORD_SIZE(clast_displaced_seam, 20)

RECORD(clast_displaced_cluster)
{
    uint first_triangle;
    uint triangle_count;
    uint first_vertex; // into the vertex numbers
    uint vertex_count;
    uint first_edge;
    uint edge_count;
    uint first_seam;
    uint template_index;
};
RECORD_SIZE(clast_displaced_cluster, 32)

// How texture coordinates of a set grow along the surface at rest, at a vertex of the mesh.
RECORD(clast_displaced_gradient)
{
    packed3 u;
    packed3 v;
};
RECORD_SIZE(clast_displaced_gradient, 24)

// ----------------------------------------------------------------------------------------------------------- records

// Words of an item: the levels of its cluster's vertices, two in a word, where it is displaced; then of each record how far
// back these are, the words of its leaves, and five more for each of those that are split: the weights of three corners, and
// their levels.
LIMIT(DISPLACED_LEAF_TRIANGLE_BITS, 8u, "above them the factors")
LIMIT(DISPLACED_LEAF_SPLIT_BIT, 20u, "1 for a part of a triangle that was split")
LIMIT(DISPLACED_LEAF_FIRST_BIT, 21u, "its first triangle in the record, 8 bits")
LIMIT(DISPLACED_SPLIT_WORDS, 5u, "of each leaf that is split")
LIMIT(DISPLACED_RECORD_TRIANGLES, 128u, "most triangles of a record of several leaves")

FN uint displaced_leaf_word(uint triangle, uint factors, bool split, uint first_triangle)
{
    return triangle | factors << DISPLACED_LEAF_TRIANGLE_BITS | (split ? 1u << DISPLACED_LEAF_SPLIT_BIT : 0u) |
           first_triangle << DISPLACED_LEAF_FIRST_BIT;
}
FN uint displaced_leaf_triangle(uint word) { return word & 255u; }
FN uint displaced_leaf_factors(uint word) { return word >> DISPLACED_LEAF_TRIANGLE_BITS & 4095u; }
FN bool displaced_leaf_is_split(uint word) { return (word >> DISPLACED_LEAF_SPLIT_BIT & 1u) != 0u; }
FN uint displaced_leaf_first(uint word) { return word >> DISPLACED_LEAF_FIRST_BIT & 255u; }

// Words of the levels of a cluster's vertices, in an item of a unit that is displaced.
FN uint displaced_words_of_levels(uint vertex_count, bool moved) { return moved ? (vertex_count + 1u) / 2u : 0u; }
FN float displaced_level(uint steps) { return to_float(steps) * power_of_two(119u); } // over HEIGHT_LEVEL_STEPS, exactly

// ------------------------------------------------------------------------------------------------------------- bounds

// Where displacement goes in a pose, from where it goes where its scale is 1.
FN clast_box displaced_reach(clast_box reach, float scale)
{
    vec3 a = load3(reach.lower) * scale;
    vec3 b = load3(reach.upper) * scale;
    clast_box scaled;
    scaled.lower = store3(min3(a, b));
    scaled.upper = store3(max3(a, b));
    return scaled;
}

FN float displaced_bounds_error(float lower, float upper, float reach_lower, float reach_upper)
{
    return 4e-6f * (max1(abs1(lower), abs1(upper)) + abs1(reach_lower) + abs1(reach_upper));
}

// Of the undisplaced box, and what displacement adds; by some roundings of the sums more.
FN clast_box displaced_bounds(clast_box box, clast_box reach)
{
    vec3 lower = load3(box.lower);
    vec3 upper = load3(box.upper);
    vec3 down = load3(reach.lower);
    vec3 up = load3(reach.upper);
    vec3 error = vec3(displaced_bounds_error(lower[0], upper[0], down[0], up[0]),
                      displaced_bounds_error(lower[1], upper[1], down[1], up[1]),
                      displaced_bounds_error(lower[2], upper[2], down[2], up[2]));
    clast_box bounds;
    bounds.lower = store3(lower + down - error);
    bounds.upper = store3(upper + up + error);
    return bounds;
}

// 1 where what faces away from the eye is hidden: the surface is closed and opaque, and the eye outside of it. `still`: no pose
// moves it; of what moves that is not known.
FN uint displaced_faces(clast_displaced_header header, float scale, vec3 eye, bool still)
{
    clast_box box = displaced_bounds(header.rest, displaced_reach(header.reach, scale));
    vec3 lower = load3(box.lower);
    vec3 upper = load3(box.upper);
    bool within = eye[0] >= lower[0] && eye[0] <= upper[0] && eye[1] >= lower[1] && eye[1] <= upper[1] &&
                  eye[2] >= lower[2] && eye[2] <= upper[2];
    bool solid = (header.flags & (DISPLACED_CLOSED | DISPLACED_OPAQUE)) == (DISPLACED_CLOSED | DISPLACED_OPAQUE);
    return still && solid && !within ? 1u : 0u;
}

// ------------------------------------------------------------------------------------------------------------- points

// The coordinates of a map at a vertex of the mesh that has the coordinates `at`.
FN vec2 displaced_coordinates(clast_displaced_map map, vec2 at)
{
    return (load2(map.columns[0]) * at[0] + load2(map.columns[1]) * at[1]) + load2(map.moved);
}

// What a seam has between its ends, from the end whose weight is `a`.
FN vec2 displaced_seam_blend(vec2 first, vec2 second, uint a, uint b)
{
    return (first * to_float(a) + second * to_float(b)) * power_of_two(112u);
}

// The middle of an edge of the mesh, not displaced.
FN vec3 displaced_middle(vec3 a, vec3 b, vec3 normal_a, vec3 normal_b, bool curved)
{
    vec3 sum = a + b;
    return curved ? sum * 0.125f + curved_edge_term(a, b, normal_a, normal_b, 0.5f, 0.5f) * 3.0f : sum * 0.5f;
}

// The edge of a triangle that two points lie on, as weights_place() has it; WEIGHTS_INSIDE for none.
FN uint displaced_place_between(clast_weights a, clast_weights b)
{
    uint place = WEIGHTS_INSIDE;
    for (uint edge = 0u; edge < 3u; edge++) {
        uint opposite = (edge + 2u) % 3u;
        place = a.of[opposite] == 0u && b.of[opposite] == 0u ? WEIGHTS_EDGE + edge : place;
    }
    return place;
}

// Whether a point is nearer to an edge than a quarter of one of its segments, on the triangle before it is displaced. `along` is the
// edge, scaled to about 1, `away` the way to the point from an end of it.
FN bool displaced_is_near(vec3 along, vec3 away, uint segments)
{
    vec3 area = cross3(along, away);
    float square = dot3(along, along);
    precise bool near_by = square > 0.5f && dot3(area, area) * squared(4.0f * to_float(segments)) <= square * square;
    return near_by;
}

// The most segments of the edge from a to b where a part keeps the segments of another, as these are few enough for a pattern: no
// more than a pattern has, where it lies beside that. It may ask for more, as it is measured in other places; parts between the two
// would then be split until weights tell no points apart.
FN uint displaced_most_beside(vec3 from, vec3 to, uint kept, vec3 a, vec3 b)
{
    vec3 along = to - from;
    float scale = stable_reciprocal(within_reach(largest3(vec3(abs1(along[0]), abs1(along[1]), abs1(along[2])))));
    bool beside = kept <= PATTERN_SEGMENTS && displaced_is_near(along * scale, (a - from) * scale, kept) &&
                  displaced_is_near(along * scale, (b - from) * scale, kept);
    return beside ? PATTERN_SEGMENTS : EDGE_SEGMENTS;
}

// The most segments of an edge between points of a part that is split, which are `within_a` and `within_b` of its corners. Where
// it is part of an edge of the part, the neighbour must come to the same: that has no such bound. Points are as before they are
// displaced, and on flat triangles.
FN uint displaced_split_most(const vec3 corners[3], const uint factors[3], clast_weights within_a, clast_weights within_b,
                             vec3 a, vec3 b)
{
    uint most = EDGE_SEGMENTS;
    for (uint k = 0u; k < 3u; k++) {
        most = min_uint(most, displaced_most_beside(corners[k], corners[(k + 1u) % 3u], factors[k], a, b));
    }
    return displaced_place_between(within_a, within_b) == WEIGHTS_INSIDE ? most : EDGE_SEGMENTS;
}

// The normal of a posed triangle, of unit length or zero.
FN vec3 displaced_triangle_normal(vec3 a, vec3 b, vec3 c) { return stable_normalize3(cross3(b - a, c - a)); }

// ------------------------------------------------------------------------------------------------------------ shading

FN vec3 displaced_unit_or(vec3 v, vec3 otherwise)
{
    float largest = largest3(vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])));
    bool sound = largest > 0.0f && is_finite1(largest);
    return sound ? normalize3(v * rough_divide(1.0f, largest)) : otherwise;
}

// What a vector along the surface at rest becomes where a pose bends the triangle: it keeps its products with the edges, which
// are the first two at rest, the last two in the pose.
FN vec3 displaced_posed_gradient(vec3 gradient, vec3 rest_first, vec3 rest_second, vec3 first, vec3 second)
{
    float s = dot3(gradient, rest_first);
    float t = dot3(gradient, rest_second);
    float a = dot3(first, first);
    float b = dot3(first, second);
    float c = dot3(second, second);
    float determinant = a * c - b * b;
    precise bool sound = determinant > 1e-12f * a * c;
    vec3 posed = (first * (c * s - b * t) + second * (a * t - b * s)) * rough_divide(1.0f, determinant);
    return sound ? posed : splat3(0.0f);
}

// Half a texel of a level, of which `texel` of the finest make one, in coordinates.
FN vec2 displaced_half_texel(float texel, uint width, uint height)
{
    float part = 0.5f * texel;
    return vec2(rough_divide(part, to_float(width)), rough_divide(part, to_float(height)));
}

// How the height grows by the mesh's coordinates, from how much it does between half a texel before and one behind.
FN vec2 displaced_mesh_slope(clast_displaced_map map, float scale, float across, float down, vec2 half_texel)
{
    vec2 by_map = vec2(rough_divide(across, 2.0f * half_texel[0]), rough_divide(down, 2.0f * half_texel[1])) * scale;
    return vec2(dot2(by_map, load2(map.columns[0])), dot2(by_map, load2(map.columns[1])));
}

// A normal turned as the slope has it. What of the slope lies along the normal is none of the surface's.
FN vec3 displaced_turned(vec3 normal, vec3 slope)
{
    vec3 along = slope - normal * dot3(slope, normal);
    return is_finite3(along) ? normal - along : normal;
}

// The normal of the displaced surface. `towards` is where displacement goes, `flat_normal` that of the triangle: the mesh's
// normals may point inwards.
FN vec3 displaced_geometric_normal(vec3 towards, vec3 flat_normal, vec3 slope)
{
    precise bool inwards = dot3(towards, flat_normal) < 0.0f;
    vec3 outwards = inwards ? towards * -1.0f : towards;
    return displaced_turned(displaced_unit_or(outwards, flat_normal), inwards ? slope * -1.0f : slope);
}

FN vec3 displaced_shading_normal(vec3 normal, vec3 towards, vec3 flat_normal, vec3 slope)
{
    vec3 shading = displaced_unit_or(normal, flat_normal);
    precise bool against = dot3(shading, towards) < 0.0f;
    return displaced_turned(shading, against ? slope * -1.0f : slope);
}

#endif
