// SPDX-License-Identifier: Apache-2.0
// How one of a frame's lights is chosen for a point, and a point of it; and how likely that was. Tables are read by the
// callers: formulas are here.
#ifndef CLAST_SHARED_LIGHT_CHOICE_H
#define CLAST_SHARED_LIGHT_CHOICE_H

#include "shared/light_tree.h"

LIMIT(DIRECTIONAL_WEIGHED, 16u, "so many directional lights are weighed at each point; of more, one is chosen by its strength alone")
TABLE float LIGHT_LEAST_SHARE = 0.1f; // of a kind of light that is there at all: guesses of its strength may be wrong

// How likely each kind of light is chosen at a point; they add up to one, or are all zero. The sun has a sample of its
// own wherever it can be seen: its share is 1 or 0, beside the others'.
RECORD(clast_light_shares)
{
    float surroundings;
    float sun;
    float directional;
    float tree; // of lights that are somewhere: emissive triangles, points and spots
};
RECORD_SIZE(clast_light_shares, 16)

// Where light may come from.
RECORD(clast_light_sample)
{
    packed3 direction; // towards the light, unit length
    packed3 target;    // of a light that is somewhere: where the ray ends
    packed3 radiance;  // is_point: irradiance
    float density;     // by solid angle, the choice of the light included; is_point: of the choice alone; 0: no light
    uint is_distant;
    uint is_point;     // 1: cannot be found by following a direction: gets all of the weight
};
RECORD_SIZE(clast_light_sample, 48)

// An emissive triangle in world space.
RECORD(clast_emitter)
{
    packed3 corners[3];
    uint instance; // of the frame
    uint primitive;
    uint material;
    float area;
};
RECORD_SIZE(clast_emitter, 52)

FN clast_light_sample no_light(void)
{
    clast_light_sample light;
    light.direction = store3(splat3(0.0f));
    light.target = store3(splat3(0.0f));
    light.radiance = store3(splat3(0.0f));
    light.density = 0.0f;
    light.is_distant = 0u;
    light.is_point = 0u;
    return light;
}

// Whether anything may arrive.
FN bool light_shines(clast_light_sample light)
{
    return light.density > 0.0f && largest3(load3(light.radiance)) > 0.0f;
}

// ------------------------------------------------------------------------------------------------------------ searches

// Halves a range of ordered entries until one is left: the last that what is looked for is not before.
RECORD(clast_search)
{
    uint low;
    uint high; // what is looked for is before it
};
RECORD_SIZE(clast_search, 8)

FN clast_search search_between(uint low, uint high)
{
    clast_search search;
    search.low = low;
    search.high = high;
    return search;
}

FN bool search_goes_on(clast_search search) { return search.high - search.low > 1u; }
FN uint search_middle(clast_search search) { return search.low + ((search.high - search.low) >> 1u); }

// `is_before`: what is looked for is before the middle.
FN clast_search search_step(clast_search search, bool is_before)
{
    uint middle = search_middle(search);
    return search_between(is_before ? search.low : middle, is_before ? middle : search.high);
}

// Where in an entry of a running sum, which goes from `low` to `high`, a number is: 0 to 1.
FN float place_between(float low, float high, float u)
{
    float width = high - low;
    return width > 0.0f ? clamp1(rough_divide(u - low, width), 0.0f, 1.0f) : 0.5f;
}

// --------------------------------------------------------------------------------------------------------------- shares

// How much of a light from a direction a surface may scatter; both normals face the viewer.
FN float light_facing(vec3 geometric_normal, vec3 normal, vec3 direction)
{
    bool above = dot3(geometric_normal, direction) > 0.0f;
    return above ? 0.1f + 0.9f * max1(dot3(normal, direction), 0.0f) : 0.0f;
}

// `upper` and `lower` are the mean luminance of each half of the surroundings.
FN float surroundings_strength(float upper, float lower, vec3 normal)
{
    float up = 0.5f + 0.5f * normal[1];
    float strength = PI * (upper * up + lower * (1.0f - up));
    return max1(strength, 1e-3f * (upper + lower));
}

// `height` is 1 - cosine of the sun's angular radius. A wide sun may stand half above the surface's horizon.
FN float sun_share(vec3 sun, float height, vec3 geometric_normal)
{
    float reach = rough_sqrt(2.0f * height);
    return dot3(geometric_normal, sun) > -reach ? 1.0f : 0.0f;
}

FN float least_share(float strength, float sum)
{
    return strength > 0.0f ? max1(strength, LIGHT_LEAST_SHARE * sum) : 0.0f;
}

// From how strong each kind is.
FN clast_light_shares shares_of_strengths(float surroundings, float sun, float directional, float tree)
{
    float all = surroundings + directional + tree;
    float a = least_share(surroundings, all);
    float b = least_share(directional, all);
    float c = least_share(tree, all);
    float sum = a + b + c;
    float scale = sum > 0.0f && is_finite1(sum) ? rough_divide(1.0f, sum) : 0.0f;
    clast_light_shares shares;
    shares.surroundings = a * scale;
    shares.sun = sun;
    shares.directional = b * scale;
    shares.tree = c * scale;
    return shares;
}

// ------------------------------------------------------------------------------------------------------------ far away

// 1 - cosine between two unit vectors. Of small angles, the difference itself would keep no digits.
FN float below_cosine(vec3 middle, vec3 direction)
{
    vec3 difference = direction - middle;
    return 0.5f * dot3(difference, difference);
}

// Of the sun's disc, where it is above the horizon. `density` is that of its directions.
FN vec3 sun_radiance(vec3 sun, float height, vec3 irradiance, float density, vec3 direction)
{
    float below = below_cosine(sun, direction);
    bool is_seen = below < height && direction[1] > 0.0f;
    return is_seen ? irradiance * (density * sun_profile(below, height)) : splat3(0.0f);
}

// With which the sun's own samples find a direction.
FN float sun_density_at(vec3 sun, float height, float density, float share, vec3 direction)
{
    bool is_seen = share > 0.0f && below_cosine(sun, direction) < height;
    return is_seen ? share * density : 0.0f;
}

// The surroundings' picture in cells, chosen by brightness and size.
RECORD(clast_cell)
{
    uint row;
    uint column;
};
RECORD_SIZE(clast_cell, 8)

FN clast_cell cell_of_place(vec2 place, uint width, uint height)
{
    clast_cell cell;
    cell.column = min_uint(to_uint(place[0] * to_float(width)), width - 1u);
    cell.row = min_uint(to_uint(place[1] * to_float(height)), height - 1u);
    return cell;
}

FN float cell_border(uint row, uint height) { return rough_cos(rough_divide(PI * to_float(row), to_float(height))); }
FN float cell_row_area(uint row, uint height) { return cell_border(row, height) - cell_border(row + 1u, height); }

// By solid angle: even in azimuth and height within a cell. `share` is that of its row times its own of the row.
FN float cell_density(float share, uint row, uint width, uint height)
{
    return rough_divide(share * to_float(width), 2.0f * PI * cell_row_area(row, height));
}

// `within` is the place in the cell, 0 to 1 both ways.
FN vec3 cell_direction(clast_cell cell, vec2 within, uint width, uint height, float rotation)
{
    float y = mix1(cell_border(cell.row, height), cell_border(cell.row + 1u, height), within[1]);
    y = clamp1(y, -1.0f, 1.0f);
    float turns = rough_divide(to_float(cell.column) + within[0], to_float(width)) - 0.5f;
    float azimuth = turns * (2.0f * PI) - rotation;
    float level = rough_sqrt(max1(1.0f - y * y, 0.0f));
    return vec3(level * rough_cos(azimuth), y, level * rough_sin(azimuth));
}

// ------------------------------------------------------------------------------------------------------------- emitters

// A point of an emitter, as another point sees it.
RECORD(clast_emitter_point)
{
    packed3 place;
    packed3 normal;    // unit length, counter-clockwise side
    packed3 direction; // towards it, unit length
    float distance;    // 0: it is where it is seen from
};
RECORD_SIZE(clast_emitter_point, 40)

// `weights` are those of the second and third corner.
FN clast_emitter_point emitter_point(clast_emitter emitter, vec2 weights, vec3 position)
{
    vec3 a = load3(emitter.corners[0]);
    vec3 b = load3(emitter.corners[1]);
    vec3 c = load3(emitter.corners[2]);
    vec3 place = a + (b - a) * weights[0] + (c - a) * weights[1];
    vec3 away = place - position;
    clast_emitter_point point;
    point.place = store3(place);
    point.normal = store3(cross3(b - a, c - a) * rough_divide(1.0f, 2.0f * emitter.area));
    point.distance = length3(away);
    bool apart = point.distance > 0.0f;
    point.direction = store3(apart ? away * rough_divide(1.0f, point.distance) : splat3(0.0f));
    return point;
}

// Where a shadow ray to it ends: moved towards the viewer by what arithmetic may have moved it by (`error`, on each axis), so
// that its own triangle does not hide it.
FN vec3 emitter_target(clast_emitter_point point, vec3 error)
{
    vec3 normal = load3(point.normal);
    vec3 size = vec3(abs1(normal[0]), abs1(normal[1]), abs1(normal[2]));
    float offset = 2.0f * dot3(size, error);
    bool faces = dot3(normal, load3(point.direction)) < 0.0f;
    return load3(point.place) + normal * (faces ? offset : -offset);
}

// By solid angle. `share` is the chance with which it is chosen.
FN float emitter_density(float share, float area, float distance, float cosine)
{
    float size = max1(abs1(cosine), 1e-6f) * area;
    return rough_divide(share * distance * distance, size);
}

#endif
