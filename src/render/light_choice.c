// SPDX-License-Identifier: Apache-2.0
// One of a frame's lights chosen for a point, a point of it, and how likely that was.
#include "render/lights.h"
#include "render/surface.h"

// ------------------------------------------------------------------------------------------------------------ far away

vec3 clast_distant_radiance(const clast_lights *lights, vec3 direction)
{
    if (!lights->has_surroundings && !lights->has_sun) {
        return splat3(0.0f);
    }
    vec3 radiance = clast_surroundings_radiance(lights, direction);
    if (lights->has_sun) {
        radiance = radiance + sun_radiance(load3(lights->sun.z), lights->sun_height, lights->sun_irradiance,
                                           lights->sun_density, direction);
    }
    return radiance;
}

float clast_distant_density(const clast_lights *lights, const clast_light_shares *shares, vec3 direction)
{
    float density = 0.0f;
    if (shares->surroundings > 0.0f) {
        density = shares->surroundings * clast_surroundings_density(&lights->surroundings, direction);
    }
    return density +
           sun_density_at(load3(lights->sun.z), lights->sun_height, lights->sun_density, shares->sun, direction);
}

// ------------------------------------------------------------------------------------------------------------- the tree

// Of a light of a leaf.
static float entry_importance(const clast_lights *lights, clast_light_entry entry, clast_lit_point point,
                              clast_light_view view)
{
    if (entry.number < lights->emitter_count) {
        const clast_emitter *emitter = &lights->frame->emitters[entry.number];
        return light_triangle_importance(load3(emitter->corners[0]), load3(emitter->corners[1]),
                                         load3(emitter->corners[2]), entry.power, view);
    }
    return light_punctual_importance(lights->frame->motion.lights[entry.number - lights->emitter_count], entry.power,
                                     load3(point.position), view);
}

clast_chosen_light clast_light_tree_choose(const clast_lights *lights, clast_lit_point point, float u)
{
    const clast_light_tree *tree = &lights->tree;
    clast_light_view view = light_view(point, tree->scale);
    clast_light_node node = tree->nodes[0];
    clast_chosen_light made = {.density = 1.0f};
    uint32_t count = light_node_count(node);
    while (count == 0) {
        const clast_light_node *children = &tree->nodes[node.first];
        clast_light_turn turn = light_turn(light_node_importance(children[0], view),
                                           light_node_importance(children[1], view), u);
        made.density = made.density * turn.chance;
        u = turn.u;
        node = children[turn.second];
        count = light_node_count(node);
    }
    clast_light_pick pick = pick_begin(u);
    for (uint32_t i = 0; i < count; i++) {
        clast_light_entry entry = tree->entries[node.first + i];
        pick = pick_step(pick, i, entry_importance(lights, entry, point, view));
    }
    pick = pick_end(pick, count);
    made.number = tree->entries[node.first + pick.chosen].number;
    made.density = made.density * pick_chance(pick.weight, pick.sum, count);
    return made;
}

float clast_light_tree_density(const clast_lights *lights, clast_lit_point point, uint32_t number)
{
    const clast_light_tree *tree = &lights->tree;
    if (tree->count == 0 || tree->places[number] == CLAST_NONE) {
        return 0.0f;
    }
    clast_light_view view = light_view(point, tree->scale);
    clast_light_node node = tree->nodes[0];
    float density = 1.0f;
    uint32_t trail = tree->trails[number], count = light_node_count(node);
    while (count == 0) {
        const clast_light_node *children = &tree->nodes[node.first];
        density = density * turn_chance(light_node_importance(children[0], view),
                                        light_node_importance(children[1], view), trail & 1);
        node = children[trail & 1];
        trail >>= 1;
        count = light_node_count(node);
    }
    float sum = 0.0f, weight = 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        float importance = entry_importance(lights, tree->entries[node.first + i], point, view);
        sum = sum + importance;
        weight = node.first + i == tree->places[number] ? importance : weight;
    }
    return density * pick_chance(weight, sum, count);
}

// --------------------------------------------------------------------------------------------------------------- shares

static const clast_light *directional_light(const clast_lights *lights, uint32_t entry)
{
    return &lights->frame->motion.lights[lights->directional_numbers[entry]];
}

static float directional_weight(const clast_lights *lights, uint32_t entry, clast_light_view view)
{
    return light_directional_importance(*directional_light(lights, entry), view);
}

static float directional_strength(const clast_lights *lights, clast_light_view view)
{
    const clast_choice_table *table = &lights->directional;
    if (table->count > DIRECTIONAL_WEIGHED) {
        return table->total;
    }
    float sum = 0.0f;
    for (uint32_t i = 0; i < table->count; i++) {
        sum += directional_weight(lights, i, view);
    }
    return sum;
}

// How much light the tree's lights may send to a point.
static float tree_strength(const clast_lights *lights, clast_lit_point point, clast_light_view view)
{
    const clast_light_tree *tree = &lights->tree;
    if (tree->count == 0) {
        return 0.0f;
    }
    clast_light_node root = tree->nodes[0];
    uint32_t count = light_node_count(root);
    float sum = 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        sum += entry_importance(lights, tree->entries[root.first + i], point, view);
    }
    if (count == 0) {
        sum = light_node_importance(tree->nodes[root.first], view) +
              light_node_importance(tree->nodes[root.first + 1], view);
    }
    return sum * tree->strength;
}

clast_light_shares clast_lights_share(const clast_lights *lights, clast_lit_point point, vec3 geometric_normal,
                                      vec3 normal)
{
    const clast_surroundings *around = &lights->surroundings;
    clast_light_view view = light_view(point, lights->tree.scale);
    float surroundings = lights->has_surroundings ? surroundings_strength(around->upper, around->lower, normal) : 0.0f;
    float sun = lights->has_sun ? sun_share(load3(lights->sun.z), lights->sun_height, geometric_normal) : 0.0f;
    return shares_of_strengths(surroundings, sun, directional_strength(lights, view),
                               tree_strength(lights, point, view));
}

// -------------------------------------------------------------------------------------------------------------- samples

static clast_light_sample sample_distant(const clast_lights *lights, const clast_light_shares *shares, vec3 direction)
{
    clast_light_sample light = no_light();
    light.direction = store3(direction);
    light.is_distant = 1;
    light.radiance = store3(clast_distant_radiance(lights, direction));
    light.density = clast_distant_density(lights, shares, direction);
    return light;
}

static clast_light_sample sample_directional(const clast_lights *lights, const clast_light_shares *shares,
                                             clast_lit_point point, float choice)
{
    const clast_choice_table *table = &lights->directional;
    clast_light_view view = light_view(point, lights->tree.scale);
    uint32_t entry;
    float density;
    if (table->count > DIRECTIONAL_WEIGHED) {
        float rest;
        entry = clast_sums_find(table->sums, table->count, choice, &rest);
        density = table->sums[entry + 1] - table->sums[entry];
    } else {
        clast_light_pick pick = pick_begin(choice);
        for (uint32_t i = 0; i < table->count; i++) {
            pick = pick_step(pick, i, directional_weight(lights, i, view));
        }
        entry = pick_end(pick, table->count).chosen;
        density = pick_chance(pick.weight, pick.sum, table->count);
    }
    clast_light_sample light = no_light();
    clast_incoming incoming = light_incoming(*directional_light(lights, entry), load3(point.position));
    light.direction = incoming.direction;
    light.is_distant = 1;
    light.is_point = 1;
    light.radiance = incoming.irradiance;
    light.density = shares->directional * density;
    return light;
}

static clast_light_sample sample_punctual(const clast_light *from, vec3 position, float density)
{
    clast_light_sample light = no_light();
    clast_incoming incoming = light_incoming(*from, position);
    light.direction = incoming.direction;
    light.target = from->position;
    light.is_point = 1;
    light.radiance = incoming.irradiance;
    light.density = density;
    return light;
}

// What an emitter sends out at a point of it.
static vec3 emission_at(const clast_lights *lights, const clast_emitter *emitter, vec2 weights)
{
    const clast_frame *frame = lights->frame;
    const clast_frame_unit *unit = &frame->units[frame->instances[emitter->instance].unit];
    const clast_material *material = &frame->scene->materials[emitter->material].record;
    if (material->emissive_texture.texture == CLAST_NONE) {
        return load3(material->emissive);
    }
    clast_surface_point point = {.primitive = emitter->primitive, .coordinates = store2(weights)};
    clast_source_surface surface = clast_source_of(unit->unit)->evaluate(unit->unit, &unit->pose, point);
    clast_texture_area area = clast_texture_point(surface.coordinates);
    return clast_emission(frame->scene, material, &area, lights->table);
}

// `share` is the chance with which the emitter was chosen.
static clast_light_sample sample_emitter(const clast_lights *lights, uint32_t number, float share, vec3 position,
                                         vec2 u)
{
    const clast_frame *frame = lights->frame;
    const clast_emitter *emitter = &frame->emitters[number];
    vec2 weights = sample_triangle(u);
    clast_emitter_point point = emitter_point(*emitter, weights, position);
    clast_light_sample light = no_light();
    if (!(point.distance > 0.0f)) {
        return light;
    }
    const clast_frame_instance *instance = &frame->instances[emitter->instance];
    const clast_frame_unit *unit = &frame->units[instance->unit];
    vec3 bound = max3(load3(unit->bounds.upper), load3(unit->bounds.lower) * -1.0f);
    float extent = largest3(load3(unit->bounds.upper) - load3(unit->bounds.lower));
    vec3 error = clast_position_error(instance, max3(bound, splat3(0.0f)), extent, load3(point.place));
    light.direction = point.direction;
    light.target = store3(emitter_target(point, error));
    light.radiance = store3(emission_at(lights, emitter, weights));
    light.density = emitter_density(share, emitter->area, point.distance,
                                    dot3(load3(point.normal), load3(point.direction)));
    return light;
}

static clast_light_sample sample_tree(const clast_lights *lights, const clast_light_shares *shares,
                                      clast_lit_point point, float choice, vec2 u)
{
    clast_chosen_light chosen = clast_light_tree_choose(lights, point, choice);
    float density = shares->tree * chosen.density;
    if (chosen.number < lights->emitter_count) {
        return sample_emitter(lights, chosen.number, density, load3(point.position), u);
    }
    const clast_light *from = &lights->frame->motion.lights[chosen.number - lights->emitter_count];
    return sample_punctual(from, load3(point.position), density);
}

clast_light_sample clast_lights_sample_sun(const clast_lights *lights, const clast_light_shares *shares, vec2 u)
{
    if (!(shares->sun > 0.0f)) {
        return no_light();
    }
    return sample_distant(lights, shares, normalize3(from_basis(lights->sun, sample_cone(u, lights->sun_height))));
}

clast_light_sample clast_lights_sample(const clast_lights *lights, const clast_light_shares *shares,
                                       clast_lit_point point, float choice, vec2 u)
{
    if (choice < shares->surroundings) {
        float density;
        return sample_distant(lights, shares, clast_surroundings_sample(&lights->surroundings, u, &density));
    }
    choice -= shares->surroundings;
    if (choice < shares->directional) {
        return sample_directional(lights, shares, point, choice / shares->directional);
    }
    choice -= shares->directional;
    if (shares->tree > 0.0f) {
        return sample_tree(lights, shares, point, below_one(choice / shares->tree), u);
    }
    return no_light();
}

float clast_emitter_density(const clast_lights *lights, const clast_light_shares *shares, clast_lit_point point,
                            uint32_t frame_instance, uint32_t primitive, float distance, float cosine)
{
    if (!(shares->tree > 0.0f) || lights->first_emitter == NULL) {
        return 0.0f;
    }
    // Emitters of an instance are in order of their primitives.
    const clast_emitter *emitters = lights->frame->emitters;
    uint32_t first = lights->first_emitter[frame_instance], end = lights->first_emitter[frame_instance + 1];
    clast_search search = search_between(first, end);
    while (search_goes_on(search)) {
        search = search_step(search, primitive < emitters[search_middle(search)].primitive);
    }
    if (first == end || emitters[search.low].primitive != primitive) {
        return 0.0f; // it has no area, or its source has no such list: found by chance alone
    }
    float share = clast_light_tree_density(lights, point, search.low);
    return emitter_density(shares->tree * share, emitters[search.low].area, distance, cosine);
}
