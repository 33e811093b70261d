// SPDX-License-Identifier: Apache-2.0
// What the kernels of light paths share: where paths, their rays and lists lie (shared/device_paths.h).
#ifndef CLAST_RENDER_PATHS_GLSL
#define CLAST_RENDER_PATHS_GLSL

#include "render/tables.glsl"
#include "shared/device_paths.h"
#include "source/source.glsl"

#define VIEW_ENTRY(name, value, text, channels, is_float, help) const uint name = value;
CLAST_VIEW_LIST(VIEW_ENTRY)

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer render_reference { clast_device_render of; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer queue_reference { clast_path_queue of; };

const uint64_t PATH_TICKETS = 84ul; // offset of clast_path_queue.tickets

// vulkan/render.c hands these over.
layout(push_constant, scalar) uniform clast_path_push {
    uint64_t render;    // clast_device_render
    uint sample_number; // of each pixel
    uint bounce;
    uint first_square;  // of the list, where the tile begins
    uint places;        // of the tile
    uint list;          // LIST_ that is worked on
} push;

render_reference render_of() { return render_reference(push.render); }
frame_reference frame_of_render() { return frame_reference(load_address(render_of().of.frame)); }
queue_reference queue_of() { return queue_reference(load_address(render_of().of.queue)); }

// ------------------------------------------------------------------------------------------------------------- memory

// Where a piece of a path lies, in one of the arrays of `capacity` that begin at an address.
uint64_t piece_of(packed_address base, uint piece, uint path)
{
    return load_address(base) + 16ul * (uint64_t(piece) * uint64_t(render_of().of.capacity) + uint64_t(path));
}

vec4 load_piece(uint piece, uint path) { return float4s(piece_of(render_of().of.paths, piece, path)).at[0]; }

void store_piece(uint piece, uint path, vec3 first, float last)
{
    float4s(piece_of(render_of().of.paths, piece, path)).at[0] = vec4(first, last);
}

// The point where a path's ray began, as lights see it.
void store_lit(uint path, clast_lit_point point)
{
    uint4s(piece_of(render_of().of.paths, PATH_LIT, path)).at[0] = uvec4(floatBitsToUint(load3(point.position)), point.normal);
}

clast_lit_point load_lit(uint path)
{
    uvec4 piece = uint4s(piece_of(render_of().of.paths, PATH_LIT, path)).at[0];
    clast_lit_point point;
    point.position = store3(vec3(uintBitsToFloat(piece[0]), uintBitsToFloat(piece[1]), uintBitsToFloat(piece[2])));
    point.normal = piece[3];
    return point;
}

void store_hit(uint path, clast_visibility seen)
{
    packed_address hits = render_of().of.hits;
    uint4s(piece_of(hits, 0u, path)).at[0] = uvec4(seen.instance, seen.cluster, seen.triangle, seen.steps);
    if (seen.instance != CLAST_NONE) {
        float4s(piece_of(hits, 1u, path)).at[0] = vec4(load2(seen.barycentrics), seen.distance, 0.0f);
        float4s(piece_of(hits, 2u, path)).at[0] = vec4(load3(seen.normal), 0.0f);
    }
}

// Where it hit nothing, the rest is undefined.
clast_visibility load_hit(uint path)
{
    packed_address hits = render_of().of.hits;
    uvec4 numbers = uint4s(piece_of(hits, 0u, path)).at[0];
    clast_visibility seen;
    seen.instance = numbers[0];
    seen.cluster = numbers[1];
    seen.triangle = numbers[2];
    seen.steps = numbers[3];
    if (seen.instance != CLAST_NONE) {
        vec4 place = float4s(piece_of(hits, 1u, path)).at[0];
        vec4 normal = float4s(piece_of(hits, 2u, path)).at[0];
        seen.barycentrics = store2(vec2(place[0], place[1]));
        seen.distance = place[2];
        seen.normal = store3(vec3(normal[0], normal[1], normal[2]));
    }
    return seen;
}

// The shadow ray of a path: of LIST_LIGHT, or of LIST_SUN.
uint64_t shadow_piece(uint list, uint piece, uint path)
{
    return piece_of(render_of().of.shadows, (list == LIST_SUN ? SHADOW_PIECES : 0u) + piece, path);
}

void store_shadow(uint list, uint path, clast_path_connection made)
{
    float4s(shadow_piece(list, 0u, path)).at[0] = vec4(load3(made.origin), made.t_max);
    float4s(shadow_piece(list, 1u, path)).at[0] = vec4(load3(made.direction), 0.0f);
    float4s(shadow_piece(list, 2u, path)).at[0] = vec4(load3(made.radiance), 0.0f);
}

// The paths of a list: those that go on are at a bounce, the others belong to this one.
uints paths_in(uint list, uint bounce)
{
    uint number = list == LIST_NEXT ? (bounce & 1u) : list + 1u;
    return uints(load_address(render_of().of.lists) + 4ul * uint64_t(number) * uint64_t(render_of().of.capacity));
}

// Where the ticket for the rays of a list is.
uint64_t ticket_of(uint list) { return load_address(render_of().of.queue) + PATH_TICKETS + 4ul * uint64_t(list); }

// ------------------------------------------------------------------------------------------------------------- pixels

// A pixel of what is rendered, or, at its edges, outside of that.
clast_path_pixel pixel_of_path(uint path)
{
    uint square = uints(load_address(render_of().of.squares)).at[push.first_square + path / SQUARE_PIXELS];
    return pixel_of_square(square, path % SQUARE_PIXELS, render_of().of.squares_across, square_inset(render_of().of.area_x),
                           square_inset(render_of().of.area_y));
}

bool is_in_picture(clast_path_pixel pixel)
{
    return pixel.x < render_of().of.area_width && pixel.y < render_of().of.area_height;
}

uint64_t pixel_number(clast_path_pixel pixel)
{
    return uint64_t(pixel.y) * uint64_t(render_of().of.area_width) + uint64_t(pixel.x);
}

// By the pixel's place in the whole picture.
clast_pixel_samples samples_of(clast_path_pixel pixel)
{
    return pixel_samples(render_of().of.area_x + pixel.x, render_of().of.area_y + pixel.y, render_of().of.seed,
                         render_of().of.power);
}

// A view's first channel in a pixel; not to be read where the view is not wanted.
bool is_wanted(uint view) { return any(notEqual(render_of().of.views[view], uvec2(0u, 0u))); }

floats view_pixel(uint view, uint channels, clast_path_pixel pixel)
{
    return floats(load_address(render_of().of.views[view]) + 4ul * uint64_t(channels) * pixel_number(pixel));
}

// A view of integers.
uints view_pixel_bits(uint view, clast_path_pixel pixel) { return uints(uint64_t(view_pixel(view, 1u, pixel))); }

void add_to_view(uint view, clast_path_pixel pixel, vec3 value)
{
    floats sums = view_pixel(view, 3u, pixel);
    for (uint c = 0u; c < 3u; c++) {
        sums.at[c] += value[c];
    }
}

#endif
