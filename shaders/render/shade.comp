// SPDX-License-Identifier: Apache-2.0
// A step of light paths from what their rays hit: the twin of src/render/path.c's step_path(). What a shadow ray brings is
// added by shadow.comp.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/paths.glsl"
#include "render/lights.glsl"
#include "render/scatter.glsl"
#define GROUP_SIZE 128u // PATH_GROUP
#include "accel/group.glsl"
layout(local_size_x = 128) in;

// What a step came to: which lists the path goes into.
const uint GOES_ON = 1u;
const uint TO_LIGHT = 2u;
const uint TO_SUN = 4u;

struct path_state
{
    vec3 throughput;
    vec3 radiance;
    clast_light_shares shares; // of the point where its ray began
    clast_lit_point lit;       // that point
    vec3 absorption;
    vec3 direction;
    float density;
    float alpha_floor;
    clast_ray_cone cone; // around its ray, where that began
};

path_state load_path(uint path)
{
    path_state state;
    vec4 direction = load_piece(PATH_DIRECTION, path);
    state.direction = vec3(direction[0], direction[1], direction[2]);
    state.throughput = splat3(1.0f);
    state.radiance = splat3(0.0f);
    state.absorption = splat3(0.0f);
    state.density = 0.0f;
    state.alpha_floor = 0.0f;
    state.shares.surroundings = state.shares.sun = state.shares.directional = state.shares.tree = 0.0f;
    if (push.bounce != 0u) {
        vec4 throughput = load_piece(PATH_THROUGHPUT, path);
        vec4 radiance = load_piece(PATH_RADIANCE, path);
        vec4 shares = load_piece(PATH_SHARES, path);
        state.throughput = vec3(throughput[0], throughput[1], throughput[2]);
        state.radiance = vec3(radiance[0], radiance[1], radiance[2]);
        state.absorption = vec3(throughput[3], radiance[3], shares[3]);
        state.shares.surroundings = shares[0];
        state.shares.sun = shares[1];
        state.shares.tree = shares[2];
        state.density = load_piece(PATH_ORIGIN, path)[3];
        state.alpha_floor = direction[3];
        vec4 cone = load_piece(PATH_CONE, path);
        state.cone.width = cone[0];
        state.cone.spread = cone[1];
    } else {
        state.cone = camera_cone(frame_of_render().of.camera, render_of().of.height, state.direction, push.sample_number);
    }
    return state;
}

void store_radiance(uint path, path_state state)
{
    store_piece(PATH_RADIANCE, path, state.radiance, state.absorption[1]);
}

// All but the radiance.
void store_ray(uint path, path_state state, vec3 origin)
{
    store_piece(PATH_THROUGHPUT, path, state.throughput, state.absorption[0]);
    store_piece(PATH_SHARES, path, vec3(state.shares.surroundings, state.shares.sun, state.shares.tree),
                state.absorption[2]);
    store_lit(path, state.lit);
    store_piece(PATH_ORIGIN, path, origin, state.density);
    store_piece(PATH_DIRECTION, path, state.direction, state.alpha_floor);
    store_piece(PATH_CONE, path, vec3(state.cone.width, state.cone.spread, 0.0f), 0.0f);
}

// Light that was scattered once is what shadow rays from the first surface bring, and what the first scattered ray meets.
void note_direct(uint path, vec3 radiance)
{
    if (render_of().of.fireflies == CLAST_FIREFLIES_CLAMPED && push.bounce <= 1u) {
        float4s(load_address(render_of().of.direct)).at[path] = vec4(radiance, 0.0f);
    }
}

void add_surface_views(clast_path_pixel pixel, shading_point point)
{
    if (is_wanted(CLAST_VIEW_ALBEDO)) {
        add_to_view(CLAST_VIEW_ALBEDO, pixel, load3(point.surface.base.base_colour));
    }
    if (is_wanted(CLAST_VIEW_NORMAL)) {
        add_to_view(CLAST_VIEW_NORMAL, pixel, point.normal);
    }
    // A mean over an edge or a seam would be no place at all.
    if (is_wanted(CLAST_VIEW_UV) && push.sample_number == 0u) {
        floats coordinates = view_pixel(CLAST_VIEW_UV, 2u, pixel);
        coordinates.at[0] = point.coordinates[0];
        coordinates.at[1] = point.coordinates[1];
    }
}

void add_distant_light(light_room room, inout path_state state)
{
    float weight = 1.0f;
    if (push.bounce != 0u) {
        weight = mis_weight(state.density, distant_density(room.lights, state.shares, state.direction));
    }
    state.radiance = state.radiance + state.throughput * distant_radiance(room, state.direction) * weight;
}

void add_emission(light_room room, uint path, inout path_state state, shading_point point, float distance)
{
    if (!(largest3(point.emission) > 0.0f)) {
        return;
    }
    float weight = 1.0f;
    if (push.bounce != 0u) {
        float cosine = dot3(point.geometric_normal, state.direction);
        float other = emitter_density_at(room.lights, state.shares.tree, load_lit(path), point.frame_instance, point.primitive,
                                         distance, cosine);
        weight = mis_weight(state.density, other);
    }
    state.radiance = state.radiance + state.throughput * point.emission * weight;
}

clast_path_surface path_surface_of(shading_point point)
{
    clast_path_surface at;
    at.position = store3(point.position);
    at.geometric_normal = store3(point.geometric_normal);
    at.normal = store3(point.normal);
    at.offset = point.offset;
    at.frame = point.frame;
    return at;
}

vec2 next_square(clast_pixel_samples samples, uint use) { return path_square(push.sample_number, samples, push.bounce, use); }

// A shadow ray to a side that is more likely the more the surface faces it: what comes through is white.
uint add_openness(uint path, clast_pixel_samples samples, shading_point point)
{
    vec2 u = path_square(push.sample_number, samples, 0u, PATH_USE_DIRECTION);
    vec3 direction = from_basis(basis_around(point.normal), sample_cosine_hemisphere(u));
    if (dot3(direction, point.geometric_normal) <= 0.0f) {
        return 0u;
    }
    clast_path_connection made;
    made.origin = store3(beside_surface(path_surface_of(point), direction));
    made.direction = store3(direction);
    made.t_max = render_of().of.ao_distance;
    made.radiance = store3(splat3(1.0f));
    store_shadow(LIST_LIGHT, path, made);
    return TO_LIGHT;
}

// Where the path goes on from a step is stored; false where it ends.
bool follow(uint path, clast_pixel_samples samples, path_state state, clast_path_surface at, clast_bsdf bsdf, clast_path_step made,
            shading_point point)
{
    float chance = path_survival(load3(made.throughput), push.bounce);
    bool survives = chance >= 1.0f || next_square(samples, PATH_USE_ROULETTE)[0] < chance;
    bool goes_on = made.density > 0.0f && survives;
    if (made.passes != 0u) {
        bool is_open = bsdf.thin != 0u || point.surface.inside != 0u;
        state.absorption = is_open ? splat3(0.0f) : point.absorption;
    }
    if (goes_on) {
        state.throughput = load3(made.throughput) * rough_divide(1.0f, chance);
        state.direction = load3(made.direction);
        state.density = made.density;
        state.alpha_floor = made.alpha_floor;
        state.cone = cone_scattered(point.cone, point.bend, made.passes != 0u, made.density, push.sample_number);
        store_ray(path, state, beside_surface(at, state.direction));
    }
    store_radiance(path, state);
    return goes_on;
}

// What a direction that is looked at is for; a light comes first.
const uint TURN_LIGHT = 0u;
const uint TURN_SUN = 1u;
const uint TURN_NEXT = 2u;
const uint TURNS = 3u;

// Scatters light at a surface: from a light, from the sun, and to where the path goes on. One text for the three, as how a
// surface scatters is long.
uint scatter_path(light_room room, uint path, clast_pixel_samples samples, path_state state, shading_point point)
{
    clast_path_surface at = path_surface_of(point);
    vec3 view = path_view(at, state.direction);
    clast_bsdf_input surface = point.surface;
    if (surface.dispersion > 0.0f) {
        clast_path_colour in_colour = path_choose_colour(state.throughput, next_square(samples, PATH_USE_ROULETTE)[1]);
        state.throughput = load3(in_colour.throughput);
        surface = surface_of_colour(surface, in_colour.colour);
    }
    clast_bsdf bsdf = scatter_make(room.materials, point.material, surface, state.alpha_floor, view);
    state.lit = lit_point(point.position, point.normal, bsdf_passes(bsdf));
    state.shares = lights_share(room.lights, state.lit, point.geometric_normal, point.normal);
    bool softens = render_of().of.fireflies == CLAST_FIREFLIES_SOFTENED;
    vec2 choice = next_square(samples, PATH_USE_CHOICE);
    uint lists = 0u;
    [[dont_unroll]] for (uint turn = 0u; turn < TURNS; turn++) {
        vec2 u = next_square(samples, turn == TURN_LIGHT ? PATH_USE_LIGHT : turn == TURN_SUN ? PATH_USE_SUN : PATH_USE_DIRECTION);
        clast_light_sample light = no_light();
        clast_bsdf_sample chosen;
        vec3 direction;
        if (turn == TURN_NEXT) {
            chosen = bsdf_direction(bsdf, view, u, choice[1]);
            direction = path_direction(at, chosen);
        } else {
            light = lights_sample(room, state.shares, state.lit, turn == TURN_SUN, choice[0], u);
            direction = load3(light.direction);
        }
        if (turn != TURN_NEXT && !light_shines(light)) {
            continue;
        }
        clast_brdf_answer answer = path_scatter(at, bsdf, view, direction);
        if (turn == TURN_NEXT) {
            clast_path_step made =
                path_step(at, bsdf, chosen, direction, answer, state.throughput, state.alpha_floor, softens);
            lists |= follow(path, samples, state, at, bsdf, made, point) ? GOES_ON : 0u;
        } else {
            clast_path_connection made = path_connect(at, answer, state.throughput, light);
            if (largest3(load3(made.radiance)) > 0.0f) {
                store_shadow(turn == TURN_SUN ? LIST_SUN : LIST_LIGHT, path, made);
                lists |= turn == TURN_SUN ? TO_SUN : TO_LIGHT;
            }
        }
    }
    return lists;
}

uint most_bounces() { return render_of().of.integrator == CLAST_INTEGRATOR_DIRECT ? 1u : render_of().of.bounces; }

void step_to_distance(light_room room, uint path, path_state state)
{
    if (render_of().of.integrator == CLAST_INTEGRATOR_AO) {
        state.radiance = splat3(1.0f);
    } else if (render_of().of.integrator != CLAST_INTEGRATOR_PRIMARY) {
        add_distant_light(room, state);
        note_direct(path, state.radiance);
    }
    store_radiance(path, state);
}

uint step_at_surface(light_room room, uint path, clast_pixel_samples samples, path_state state, shading_point point, float distance)
{
    uint lists = 0u;
    bool is_lit = render_of().of.integrator == CLAST_INTEGRATOR_PATH || render_of().of.integrator == CLAST_INTEGRATOR_DIRECT;
    if (render_of().of.integrator == CLAST_INTEGRATOR_PRIMARY) {
        float facing = abs1(dot3(point.normal, state.direction));
        state.radiance = point.emission + load3(point.surface.base.base_colour) * facing;
    } else if (render_of().of.integrator == CLAST_INTEGRATOR_AO) {
        lists = add_openness(path, samples, point);
    } else {
        add_emission(room, path, state, point, distance);
        note_direct(path, state.radiance);
        if (point.unlit) {
            state.radiance = state.radiance + state.throughput * load3(point.surface.base.base_colour);
        }
    }
    if (is_lit && !point.unlit && push.bounce < most_bounces()) {
        lists = scatter_path(room, path, samples, state, point);
    } else {
        store_radiance(path, state);
    }
    return lists;
}

uint step_path(uint path, clast_path_pixel pixel)
{
    light_room room;
    room.frame = frame_of_render();
    room.materials = materials_reference(load_address(render_of().of.materials));
    room.lights = lights_reference(load_address(render_of().of.lights));
    path_state state = load_path(path);
    if (push.bounce == 0u) {
        note_direct(path, splat3(0.0f));
    }
    clast_visibility seen = load_hit(path);
    bool has_colour = is_wanted(CLAST_VIEW_COLOUR);
    uint lists = 0u;
    if (seen.instance != CLAST_NONE) {
        if (largest3(state.absorption) > 0.0f) {
            state.throughput = state.throughput * passed_through(state.absorption, seen.distance);
        }
        finding_ray ray;
        ray.direction = state.direction;
        ray.cone = state.cone;
        ray.look = cone_look(state.cone, push.sample_number);
        shading_point point = surface_of_hit(room.frame, room.materials, seen, ray);
        if (push.bounce == 0u) {
            add_surface_views(pixel, point);
        }
        if (has_colour) {
            lists = step_at_surface(room, path, samples_of(pixel), state, point, seen.distance);
        }
    } else if (has_colour) {
        step_to_distance(room, path, state);
    }
    return lists;
}

// ---------------------------------------------------------------------------------------------------------------- lists

shared uint list_first[LISTS];

// Each list gets the group's paths one after the other; which group comes first is a matter of timing.
void append(uint path, uint lists)
{
    uint value = 0u;
    for (uint list = 0u; list < LISTS; list++) {
        value |= (lists >> list & 1u) << (10u * list); // 10 bits hold the sum over a group
    }
    group_sum sum = sum_over_group(value);
    uint lane = group_lane();
    if (lane < LISTS) {
        uint count = sum.all >> (10u * lane) & 1023u;
        list_first[lane] = count != 0u ? atomicAdd(queue_of().of.growing[lane], count) : 0u;
    }
    barrier();
    for (uint list = 0u; list < LISTS; list++) {
        if ((lists >> list & 1u) != 0u) {
            uint place = list_first[list] + (sum.before >> (10u * list) & 1023u);
            paths_in(list, push.bounce + 1u).at[place] = path;
        }
    }
}

void main()
{
    uint count = push.bounce == 0u ? push.places : queue_of().of.lengths[LIST_NEXT];
    uint first = linear_group() * PATH_GROUP;
    if (first >= count) {
        return;
    }
    uint place = first + group_lane();
    uint path = 0u;
    uint lists = 0u;
    if (place < count) {
        path = push.bounce == 0u ? place : paths_in(LIST_NEXT, push.bounce).at[place];
        clast_path_pixel pixel = pixel_of_path(path);
        if (is_in_picture(pixel)) {
            lists = step_path(path, pixel);
        }
    }
    append(path, lists);
}
