// SPDX-License-Identifier: Apache-2.0
// Segments of edges and levels of maps, by a work group for a whole cluster: the twin of src/source/displaced_rate.c and
// rate.kernel.c.
#ifndef CLAST_SOURCE_DISPLACED_RATE_GLSL
#define CLAST_SOURCE_DISPLACED_RATE_GLSL

#include "source/displaced_surface.glsl"

#define GROUP_SIZE 128
#include "accel/group.glsl"

const uint DISPLACED_SITES = 256u;     // points of the triangles that are split at once, or of a cluster
const uint DISPLACED_SITE_FLOATS = 6u; // clast_rate_point

shared clast_rate_view displaced_view;
shared float displaced_sites[DISPLACED_SITES * DISPLACED_SITE_FLOATS]; // each float of all sites, one after the other
shared uint displaced_factors[DISPLACED_EDGES];                        // of the cluster's edges
shared uint displaced_levels[CLUSTER_VERTICES];                        // at its vertices, in HEIGHT_LEVEL_STEPS

// --------------------------------------------------------------------------------------------------------------- sites

void displaced_put_site(uint number, clast_rate_point point)
{
    vec3 camera = load3(point.camera);
    vec2 screen = load2(point.screen);
    displaced_sites[number] = camera[0];
    displaced_sites[DISPLACED_SITES + number] = camera[1];
    displaced_sites[2u * DISPLACED_SITES + number] = camera[2];
    displaced_sites[3u * DISPLACED_SITES + number] = screen[0];
    displaced_sites[4u * DISPLACED_SITES + number] = screen[1];
    displaced_sites[5u * DISPLACED_SITES + number] = point.facing;
}

clast_rate_point displaced_get_site(uint number)
{
    clast_rate_point point;
    point.camera = store3(vec3(displaced_sites[number], displaced_sites[DISPLACED_SITES + number],
                               displaced_sites[2u * DISPLACED_SITES + number]));
    point.screen = store2(vec2(displaced_sites[3u * DISPLACED_SITES + number],
                               displaced_sites[4u * DISPLACED_SITES + number]));
    point.facing = displaced_sites[5u * DISPLACED_SITES + number];
    return point;
}

// A level of vertex_level(), in steps.
FN uint displaced_steps(float level) { return to_uint(level * to_float(HEIGHT_LEVEL_STEPS)); }

FN uint displaced_vertex_level(vec3 position, float density_square, float shortest_square)
{
    vec3 camera = transform_point(displaced_view.to_camera, position);
    return displaced_steps(vertex_level(displaced_view, camera, density_square, shortest_square));
}

// The middle of an edge, from its ends.
FN clast_rate_point displaced_middle_point(clast_displaced_vertex a, clast_displaced_vertex b, float height, bool curved)
{
    vec3 normal = (load3(a.normal) + load3(b.normal)) * 0.5f;
    vec3 middle = displaced_middle(load3(a.position), load3(b.position), load3(a.normal), load3(b.normal), curved);
    return rate_point(displaced_view, displaced_point(middle, normal, height), normal);
}

// ---------------------------------------------------------------------------------------------------------------- edges

// The segments of an edge of the cluster, whose vertices are sites.
FN uint displaced_edge_factor(unit_reference unit, clast_displaced_cluster cluster, clast_rate_edge edge)
{
    uint a = edge.ends & 255u;
    uint b = edge.ends >> 8u & 255u;
    if (a == b) {
        return 1u;
    }
    float wanted = displaced_view.density;
    if (displaced_view.metric != CLAST_METRIC_FIXED) {
        clast_displaced_vertex first = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, a));
        clast_displaced_vertex second = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, b));
        clast_rate_point middle = displaced_middle_point(first, second, edge.height * unit.of.displacement_scale,
                                                         displaced_is_curved(unit));
        clast_rate_point from = displaced_get_site(a);
        clast_rate_point to = displaced_get_site(b);
        wanted = edge_wanted(displaced_view, from, middle, to, displaced_edge_open(displaced_view, from, middle, to));
    }
    return edge_factor(wanted, WEIGHT_ONE);
}

// The segments of a cluster's edges, and the levels at its vertices. All of the group call it; ends with a barrier.
void displaced_find_rates(unit_reference unit, clast_displaced_cluster cluster)
{
    uint lane = group_lane(); // an invocation for each vertex: there are no more
    clast_displaced_vertex vertex;
    if (lane < cluster.vertex_count) {
        vertex = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, lane));
    }
    if (lane == GROUP_SIZE - 1u) { // which seldom has one
        displaced_view = displaced_rate_view(unit, unit.of.view);
    }
    barrier();
    if (lane < cluster.vertex_count) {
        displaced_levels[lane] =
            displaced_vertex_level(load3(vertex.position), vertex.density_square, vertex.shortest_square);
        displaced_put_site(lane, displaced_end_point(displaced_view, vertex, unit.of.displacement_scale));
    }
    barrier();
    for (uint i = lane; i < cluster.edge_count; i += GROUP_SIZE) {
        displaced_factors[i] = displaced_edge_factor(unit, cluster, displaced_edge_at(unit, cluster, i));
    }
    barrier();
}

#endif
