// SPDX-License-Identifier: Apache-2.0
// Views from what the first sample's rays hit, and of how geometry is cut there: the twin of src/render/views.c.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/paths.glsl"
#include "render/surface.glsl"
layout(local_size_x = 128) in;

// Segments that the edge has over those that it would have if it were seen and no budget were short.
float rate_of(unit_reference unit, clast_cluster_record record, clast_visibility seen, float granted)
{
    clast_source_view wanted = unit.of.view;
    wanted.rate = render_of().of.rate;
    wanted.hidden = 0u;
    wanted.hidden_fraction = 1.0f;
    float full = source_segments(unit, wanted, record, words_of(unit, record), seen.triangle, load2(seen.barycentrics));
    return full > 0.0f ? rough_divide(granted, full) : 1.0f;
}

float area_of(frame_reference frame, uint frame_instance, source_hit hit, clast_visibility seen)
{
    clast_transform to_world = instance_at(frame, frame_instance).of.to_world;
    triangle_corners corners = corners_of_hit(frame, hit.unit, hit.record, seen.cluster, seen.triangle);
    return camera_area(frame.of.camera, to_float(render_of().of.height), transform_point(to_world, corners.a),
                       transform_point(to_world, corners.b), transform_point(to_world, corners.c));
}

void keep_hit(clast_path_pixel pixel, clast_visibility seen)
{
    bool found = seen.instance != CLAST_NONE;
    if (is_wanted(CLAST_VIEW_INSTANCE)) {
        view_pixel_bits(CLAST_VIEW_INSTANCE, pixel).at[0] = seen.instance;
    }
    if (is_wanted(CLAST_VIEW_CLUSTER)) {
        view_pixel_bits(CLAST_VIEW_CLUSTER, pixel).at[0] = found ? seen.cluster : CLAST_NONE;
    }
    if (is_wanted(CLAST_VIEW_TRIANGLE)) {
        view_pixel_bits(CLAST_VIEW_TRIANGLE, pixel).at[0] = found ? seen.triangle : CLAST_NONE;
    }
    if (is_wanted(CLAST_VIEW_STEPS)) {
        view_pixel_bits(CLAST_VIEW_STEPS, pixel).at[0] = seen.steps;
    }
}

void keep_depth(clast_path_pixel pixel, uint path, clast_visibility seen)
{
    vec4 direction = load_piece(PATH_DIRECTION, path);
    clast_camera_ray ray;
    ray.direction = store3(vec3(direction[0], direction[1], direction[2]));
    view_pixel(CLAST_VIEW_DEPTH, 1u, pixel).at[0] = camera_depth(frame_of_render().of.camera, ray, seen.distance);
}

void keep_cut(clast_path_pixel pixel, clast_visibility seen)
{
    frame_reference frame = frame_of_render();
    uint frame_instance = frame_instance_of(frame, seen.instance);
    vec2 weights = load2(seen.barycentrics);
    source_hit hit = locate_hit(frame, frame_instance, seen.cluster, seen.triangle, weights);
    if (is_wanted(CLAST_VIEW_PRIMITIVE)) {
        view_pixel_bits(CLAST_VIEW_PRIMITIVE, pixel).at[0] = hit.point.primitive;
    }
    if (is_wanted(CLAST_VIEW_SEGMENTS) || is_wanted(CLAST_VIEW_RATE)) {
        float segments = source_segments(hit.unit, hit.unit.of.view, hit.record, words_of(hit.unit, hit.record),
                                         seen.triangle, weights);
        if (is_wanted(CLAST_VIEW_SEGMENTS)) {
            view_pixel(CLAST_VIEW_SEGMENTS, 1u, pixel).at[0] = segments;
        }
        if (is_wanted(CLAST_VIEW_RATE)) {
            view_pixel(CLAST_VIEW_RATE, 1u, pixel).at[0] = rate_of(hit.unit, hit.record, seen, segments);
        }
    }
    if (is_wanted(CLAST_VIEW_AREA)) {
        view_pixel(CLAST_VIEW_AREA, 1u, pixel).at[0] = area_of(frame, frame_instance, hit, seen);
    }
}

// Where nothing is hit, the other views stay as they began: nothing.
void main()
{
    uint path = linear_group() * PATH_GROUP + gl_LocalInvocationIndex;
    clast_path_pixel pixel = pixel_of_path(path);
    if (path >= push.places || !is_in_picture(pixel)) {
        return;
    }
    clast_visibility seen = load_hit(path);
    keep_hit(pixel, seen);
    if (seen.instance == CLAST_NONE) {
        return;
    }
    if (is_wanted(CLAST_VIEW_DEPTH)) {
        keep_depth(pixel, path, seen);
    }
    if (is_wanted(CLAST_VIEW_PRIMITIVE) || is_wanted(CLAST_VIEW_SEGMENTS) || is_wanted(CLAST_VIEW_RATE) ||
        is_wanted(CLAST_VIEW_AREA)) {
        keep_cut(pixel, seen);
    }
}
