// SPDX-License-Identifier: Apache-2.0
// Lights sampled: the twin of src/render/light_choice.c and surroundings.c, whose tables it reads.
#ifndef CLAST_RENDER_LIGHTS_GLSL
#define CLAST_RENDER_LIGHTS_GLSL

#include "render/surface.glsl"
#include "shared/device_lights.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer lights_reference { clast_device_lights of; };
ARRAY_OF(punctual_lights, clast_light, 4)
ARRAY_OF(emitter_list, clast_emitter, 4)
ARRAY_OF(light_nodes, clast_light_node, 4)
ARRAY_OF(light_entries, clast_light_entry, 4)

// What lights are made of, beside their own tables.
struct light_room
{
    frame_reference frame;
    materials_reference materials;
    lights_reference lights;
};

// -------------------------------------------------------------------------------------------------- choice by weight

// The entry of a running sum that a number falls into, and where in it.
struct found_sum
{
    uint entry;
    float rest;  // 0 to 1
    float share; // of the entry
};

found_sum sums_find(uint64_t sums, uint count, float u)
{
    floats values = floats(sums);
    clast_search search = search_between(0u, count);
    while (search_goes_on(search)) {
        search = search_step(search, u < values.at[search_middle(search)]);
    }
    float low = values.at[search.low];
    float high = values.at[search.low + 1u];
    return found_sum(search.low, place_between(low, high, u), high - low);
}

float sums_share(uint64_t sums, uint entry)
{
    return floats(sums).at[entry + 1u] - floats(sums).at[entry];
}

// ----------------------------------------------------------------------------------------------------- surroundings

vec3 image_radiance(materials_reference materials, clast_device_image image, vec2 place)
{
    clast_texel_pair x = linear_texels(place[0], CLAST_WRAP_REPEAT, size_width(image.size));
    clast_texel_pair y = linear_texels(place[1], CLAST_WRAP_CLAMP, size_height(image.size));
    vec4 value = image_blend(materials, image, x, y, ENCODING_SRGB);
    return min3(max3(splat3(0.0f), vec3(value[0], value[1], value[2])), splat3(1e30f));
}

vec3 sky_radiance(uint64_t sky, vec2 place)
{
    clast_texel_pair x = linear_texels(place[0], CLAST_WRAP_REPEAT, SKY_WIDTH);
    clast_texel_pair y = linear_texels(place[1], CLAST_WRAP_CLAMP, SKY_HEIGHT);
    positions3 upper = positions3(sky + 12ul * uint64_t(y.first * SKY_WIDTH));
    positions3 lower = positions3(sky + 12ul * uint64_t(y.second * SKY_WIDTH));
    return mix3(mix3(load3(upper.at[x.first]), load3(upper.at[x.second]), x.weight),
                mix3(load3(lower.at[x.first]), load3(lower.at[x.second]), x.weight), y.weight);
}

vec3 surroundings_radiance(light_room room, vec3 direction)
{
    vec3 factor = load3(room.lights.of.factor);
    clast_device_image image = room.lights.of.image;
    uint64_t sky = load_address(room.lights.of.sky);
    bool is_even = image.texture == CLAST_NONE && sky == 0ul;
    vec2 place = is_even ? splat2(0.0f) : surroundings_place(direction, room.lights.of.rotation);
    if (image.texture != CLAST_NONE) {
        factor = factor * image_radiance(room.materials, image, place);
    } else if (sky != 0ul) {
        factor = factor * sky_radiance(sky, place);
    }
    return factor;
}

uint64_t row_of_cells(lights_reference lights, uint row)
{
    return load_address(lights.of.cell_sums) + 4ul * uint64_t(row) * uint64_t(lights.of.cells_width + 1u);
}

float surroundings_density(lights_reference lights, vec3 direction)
{
    vec2 place = surroundings_place(direction, lights.of.rotation);
    uint width = lights.of.cells_width;
    uint height = lights.of.cells_height;
    clast_cell cell = cell_of_place(place, width, height);
    float share = sums_share(load_address(lights.of.row_sums), cell.row) *
                  sums_share(row_of_cells(lights, cell.row), cell.column);
    return cell_density(share, cell.row, width, height);
}

vec3 surroundings_sample(lights_reference lights, vec2 u)
{
    uint width = lights.of.cells_width;
    uint height = lights.of.cells_height;
    found_sum row = sums_find(load_address(lights.of.row_sums), height, u[1]);
    found_sum column = sums_find(row_of_cells(lights, row.entry), width, u[0]);
    clast_cell cell;
    cell.row = row.entry;
    cell.column = column.entry;
    return cell_direction(cell, vec2(column.rest, row.rest), width, height, lights.of.rotation);
}

// ------------------------------------------------------------------------------------------------------------ far away

// What comes from far away along a direction (unit length).
vec3 distant_radiance(light_room room, vec3 direction)
{
    uint flags = room.lights.of.flags;
    vec3 radiance = splat3(0.0f);
    if (flags != 0u) {
        radiance = surroundings_radiance(room, direction);
    }
    if ((flags & LIGHTS_SUN) != 0u) {
        radiance = radiance + sun_radiance(load3(room.lights.of.sun.z), room.lights.of.sun_height,
                                           load3(room.lights.of.sun_irradiance), room.lights.of.sun_density, direction);
    }
    return radiance;
}

float distant_density(lights_reference lights, clast_light_shares shares, vec3 direction)
{
    float density = 0.0f;
    if (shares.surroundings > 0.0f) {
        density = shares.surroundings * surroundings_density(lights, direction);
    }
    return density + sun_density_at(load3(lights.of.sun.z), lights.of.sun_height, lights.of.sun_density, shares.sun,
                                    direction);
}

// ------------------------------------------------------------------------------------------------------------- the tree

clast_light punctual_light(lights_reference lights, uint number)
{
    return punctual_lights(load_address(lights.of.punctual)).at[number];
}

clast_light_node tree_node(lights_reference lights, uint number)
{
    return light_nodes(load_address(lights.of.tree_nodes)).at[number];
}

clast_light_entry tree_entry(lights_reference lights, uint number)
{
    return light_entries(load_address(lights.of.tree_entries)).at[number];
}

// Of a light of a leaf.
float entry_importance(lights_reference lights, clast_light_entry entry, vec3 position, clast_light_view view)
{
    uint emitters = lights.of.emitter_count;
    float importance;
    if (entry.number < emitters) {
        clast_emitter emitter = emitter_list(load_address(lights.of.emitters)).at[entry.number];
        importance = light_triangle_importance(load3(emitter.corners[0]), load3(emitter.corners[1]),
                                               load3(emitter.corners[2]), entry.power, view);
    } else {
        importance =
            light_punctual_importance(punctual_light(lights, entry.number - emitters), entry.power, position, view);
    }
    return importance;
}

// A light of the tree, by its number there, and the chance with which it is chosen.
struct chosen_light
{
    uint number;
    float density;
};

chosen_light tree_choose(lights_reference lights, clast_lit_point point, float u)
{
    clast_light_view view = light_view(point, lights.of.tree_scale);
    vec3 position = load3(point.position);
    clast_light_node node = tree_node(lights, 0u);
    chosen_light made;
    made.density = 1.0f;
    uint count = light_node_count(node);
    while (count == 0u) {
        clast_light_node first = tree_node(lights, node.first);
        clast_light_node second = tree_node(lights, node.first + 1u);
        clast_light_turn turn =
            light_turn(light_node_importance(first, view), light_node_importance(second, view), u);
        made.density = made.density * turn.chance;
        u = turn.u;
        if (turn.second != 0u) {
            node = second;
        } else {
            node = first;
        }
        count = light_node_count(node);
    }
    clast_light_pick pick = pick_begin(u);
    for (uint i = 0u; i < count; i++) {
        pick = pick_step(pick, i, entry_importance(lights, tree_entry(lights, node.first + i), position, view));
    }
    pick = pick_end(pick, count);
    made.number = tree_entry(lights, node.first + pick.chosen).number;
    made.density = made.density * pick_chance(pick.weight, pick.sum, count);
    return made;
}

// The chance of a light that shines.
float tree_density(lights_reference lights, clast_lit_point point, uint number)
{
    clast_light_view view = light_view(point, lights.of.tree_scale);
    vec3 position = load3(point.position);
    uint trail = uints(load_address(lights.of.tree_trails)).at[number];
    uint place = uints(load_address(lights.of.tree_places)).at[number];
    clast_light_node node = tree_node(lights, 0u);
    float density = 1.0f;
    uint count = light_node_count(node);
    while (count == 0u) {
        clast_light_node first = tree_node(lights, node.first);
        clast_light_node second = tree_node(lights, node.first + 1u);
        density = density * turn_chance(light_node_importance(first, view), light_node_importance(second, view), trail & 1u);
        if ((trail & 1u) != 0u) {
            node = second;
        } else {
            node = first;
        }
        trail = trail >> 1u;
        count = light_node_count(node);
    }
    float sum = 0.0f;
    float weight = 0.0f;
    for (uint i = 0u; i < count; i++) {
        float importance = entry_importance(lights, tree_entry(lights, node.first + i), position, view);
        sum = sum + importance;
        weight = node.first + i == place ? importance : weight;
    }
    return density * pick_chance(weight, sum, count);
}

// --------------------------------------------------------------------------------------------------------------- shares

clast_light directional_light(lights_reference lights, uint entry)
{
    return punctual_light(lights, uints(load_address(lights.of.directional)).at[entry]);
}

float directional_strength(lights_reference lights, clast_light_view view)
{
    uint count = lights.of.directional_count;
    float sum = 0.0f;
    if (count > DIRECTIONAL_WEIGHED) {
        sum = lights.of.directional_total;
    } else {
        for (uint i = 0u; i < count; i++) {
            sum += light_directional_importance(directional_light(lights, i), view);
        }
    }
    return sum;
}

// How much light the tree's lights may send to a point.
float tree_strength(lights_reference lights, clast_lit_point point, clast_light_view view)
{
    float sum = 0.0f;
    if (lights.of.tree_count != 0u) {
        clast_light_node root = tree_node(lights, 0u);
        uint count = light_node_count(root);
        for (uint i = 0u; i < count; i++) {
            sum += entry_importance(lights, tree_entry(lights, root.first + i), load3(point.position), view);
        }
        if (count == 0u) {
            sum = light_node_importance(tree_node(lights, root.first), view) +
                  light_node_importance(tree_node(lights, root.first + 1u), view);
        }
    }
    return sum * lights.of.tree_strength;
}

// The shares at a point; both normals face the viewer.
clast_light_shares lights_share(lights_reference lights, clast_lit_point point, vec3 geometric_normal, vec3 normal)
{
    uint flags = lights.of.flags;
    clast_light_view view = light_view(point, lights.of.tree_scale);
    float surroundings = 0.0f;
    float sun = 0.0f;
    if ((flags & LIGHTS_SURROUNDINGS) != 0u) {
        surroundings = surroundings_strength(lights.of.upper, lights.of.lower, normal);
    }
    if ((flags & LIGHTS_SUN) != 0u) {
        sun = sun_share(load3(lights.of.sun.z), lights.of.sun_height, geometric_normal);
    }
    return shares_of_strengths(surroundings, sun, directional_strength(lights, view), tree_strength(lights, point, view));
}

// -------------------------------------------------------------------------------------------------------------- samples

clast_light_sample sample_distant(light_room room, clast_light_shares shares, vec3 direction)
{
    clast_light_sample light = no_light();
    light.direction = store3(direction);
    light.is_distant = 1u;
    light.radiance = store3(distant_radiance(room, direction));
    light.density = distant_density(room.lights, shares, direction);
    return light;
}

clast_light_sample sample_directional(lights_reference lights, clast_light_shares shares, clast_lit_point point,
                                      float choice)
{
    uint count = lights.of.directional_count;
    uint entry;
    float density;
    if (count > DIRECTIONAL_WEIGHED) {
        found_sum found = sums_find(load_address(lights.of.directional_sums), count, choice);
        entry = found.entry;
        density = found.share;
    } else {
        clast_light_view view = light_view(point, lights.of.tree_scale);
        clast_light_pick pick = pick_begin(choice);
        for (uint i = 0u; i < count; i++) {
            pick = pick_step(pick, i, light_directional_importance(directional_light(lights, i), view));
        }
        entry = pick_end(pick, count).chosen;
        density = pick_chance(pick.weight, pick.sum, count);
    }
    clast_light_sample light = no_light();
    clast_incoming incoming = light_incoming(directional_light(lights, entry), load3(point.position));
    light.direction = incoming.direction;
    light.is_distant = 1u;
    light.is_point = 1u;
    light.radiance = incoming.irradiance;
    light.density = shares.directional * density;
    return light;
}

clast_light_sample sample_punctual(clast_light from, vec3 position, float density)
{
    clast_light_sample light = no_light();
    clast_incoming incoming = light_incoming(from, position);
    light.direction = incoming.direction;
    light.target = from.position;
    light.is_point = 1u;
    light.radiance = incoming.irradiance;
    light.density = density;
    return light;
}

// `share` is the chance with which the emitter was chosen.
clast_light_sample sample_emitter(light_room room, uint number, float share, vec3 position, vec2 u)
{
    clast_emitter emitter = emitter_list(load_address(room.lights.of.emitters)).at[number];
    vec2 weights = sample_triangle(u);
    clast_emitter_point point = emitter_point(emitter, weights, position);
    clast_light_sample light = no_light();
    if (point.distance > 0.0f) {
        instance_reference instance = instance_at(room.frame, emitter.instance);
        clast_box bounds = unit_at(load_address(room.frame.of.units), instance.of.unit).of.bounds;
        vec3 lower = load3(bounds.lower);
        vec3 upper = load3(bounds.upper);
        vec3 largest = max3(max3(upper, lower * -1.0f), splat3(0.0f));
        vec3 error = position_error(instance.of.to_world, instance.of.to_object, largest, largest3(upper - lower),
                                    load3(point.place));
        clast_surface_point on_source;
        on_source.primitive = emitter.primitive;
        on_source.coordinates = store2(weights);
        on_source.level = 0.0f;
        light.direction = point.direction;
        light.target = store3(emitter_target(point, error));
        light.radiance =
            store3(emission_at(room.frame, room.materials, emitter.instance, emitter.material, on_source));
        light.density = emitter_density(share, emitter.area, point.distance,
                                        dot3(load3(point.normal), load3(point.direction)));
    }
    return light;
}

clast_light_sample sample_tree(light_room room, clast_light_shares shares, clast_lit_point point, float choice, vec2 u)
{
    chosen_light chosen = tree_choose(room.lights, point, choice);
    float density = shares.tree * chosen.density;
    uint emitters = room.lights.of.emitter_count;
    clast_light_sample light;
    if (chosen.number < emitters) {
        light = sample_emitter(room, chosen.number, density, load3(point.position), u);
    } else {
        light = sample_punctual(punctual_light(room.lights, chosen.number - emitters), load3(point.position), density);
    }
    return light;
}

// Chooses one of the lights but the sun by `choice` in [0, 1) and a point of it by `u`; or, `of_sun`, a point of the sun, of
// density 0 where its share is none. One text for both, as what comes from far away is long.
clast_light_sample lights_sample(light_room room, clast_light_shares shares, clast_lit_point point, bool of_sun,
                                 float choice, vec2 u)
{
    clast_light_sample light = no_light();
    float after = choice - shares.surroundings;
    float last = after - shares.directional;
    vec3 direction = splat3(0.0f);
    bool is_far = false;
    if (of_sun) {
        is_far = shares.sun > 0.0f;
        direction = normalize3(from_basis(room.lights.of.sun, sample_cone(u, room.lights.of.sun_height)));
    } else if (choice < shares.surroundings) {
        is_far = true;
        direction = surroundings_sample(room.lights, u);
    } else if (after < shares.directional) {
        light = sample_directional(room.lights, shares, point, rough_divide(after, shares.directional));
    } else if (shares.tree > 0.0f) {
        light = sample_tree(room, shares, point, below_one(rough_divide(last, shares.tree)), u);
    }
    if (is_far) {
        light = sample_distant(room, shares, direction);
    }
    return light;
}

// The density with which an emissive triangle is found. Emitters of an instance are in order of their primitives.
float emitter_density_at(lights_reference lights, float tree_share, clast_lit_point point, uint frame_instance,
                         uint primitive, float distance, float cosine)
{
    if (!(tree_share > 0.0f) || lights.of.emitter_count == 0u) {
        return 0.0f;
    }
    emitter_list emitters = emitter_list(load_address(lights.of.emitters));
    uints first_emitter = uints(load_address(lights.of.first_emitter));
    uint first = first_emitter.at[frame_instance];
    uint end = first_emitter.at[frame_instance + 1u];
    clast_search search = search_between(first, end);
    while (search_goes_on(search)) {
        search = search_step(search, primitive < emitters.at[search_middle(search)].primitive);
    }
    if (first == end || emitters.at[search.low].primitive != primitive) {
        return 0.0f; // it has no area, or its source has no such list: found by chance alone
    }
    return emitter_density(tree_share * tree_density(lights, point, search.low), emitters.at[search.low].area, distance, cosine);
}

#endif
