// SPDX-License-Identifier: Apache-2.0
// Tables over a frame's lights, and one light chosen for a point.
#include "render/lights.h"

#include "base/thread.h"
#include "render/surface.h"

enum {
    PUNCTUAL_MOST = 16
}; // so many punctual lights are weighed at each point; of more, one is chosen by its strength alone

static const float LEAST_SHARE = 0.1f; // of a kind of light that is there at all: guesses of its strength may be wrong

static vec3 vector_of(const float v[3])
{
    return vec3(v[0], v[1], v[2]);
}

// ---------------------------------------------------------------------------------------------------------- creation

static clast_status make_sky(clast_context *context, clast_lights *lights)
{
    const clast_environment *environment = &lights->environment;
    vec3 sun = vector_of(environment->sun_direction);
    float largest = largest3(vec3(abs1(sun[0]), abs1(sun[1]), abs1(sun[2])));
    sun = normalize3(largest > 0.0f ? sun * (1.0f / largest) : vec3(0.45f, 0.7f, 0.55f));
    float radius = environment->sun_size > 0.0f ? environment->sun_size : SKY_SUN_RADIUS;
    float turbidity = environment->turbidity > 0.0f ? environment->turbidity : SKY_TURBIDITY;
    clast_status status = clast_sky_create(context, sun, turbidity, &lights->sky);
    if (status != CLAST_OK) {
        return status;
    }
    lights->surroundings.rotation = lights->sky.rotation;
    float half_sine = rough_sin(0.5f * min1(radius, PI));
    lights->sun_height = 2.0f * half_sine * half_sine;
    lights->sun = basis_around(sun);
    lights->sun_irradiance = lights->sky.sun_irradiance * lights->factor;
    lights->sun_density = 1.0f / (2.0f * PI * lights->sun_height);
    lights->has_sun = largest3(lights->sun_irradiance) > 0.0f && sun[1] > -radius;
    return CLAST_OK;
}

static clast_status make_surroundings(clast_context *context, clast_lights *lights)
{
    const clast_scene *scene = lights->frame->scene;
    if (!scene->has_environment) {
        return CLAST_OK;
    }
    clast_environment *environment = &lights->environment;
    *environment = scene->environment;
    lights->factor = max3(splat3(0.0f), vector_of(environment->colour));
    if (environment->type != CLAST_ENVIRONMENT_CONSTANT && largest3(lights->factor) == 0.0f) {
        lights->factor = splat3(1.0f);
    }
    clast_status status = CLAST_OK;
    if (environment->type == CLAST_ENVIRONMENT_SKY) {
        status = make_sky(context, lights);
    } else if (environment->type == CLAST_ENVIRONMENT_IMAGE && environment->image < scene->image_count) {
        const clast_image *image = &scene->images[environment->image].image;
        lights->image = image->width != 0 && image->height != 0 ? image : NULL;
        lights->surroundings.rotation = environment->rotation;
    }
    if (status == CLAST_OK && largest3(lights->factor) > 0.0f) {
        status = clast_surroundings_create(context, lights);
        lights->has_surroundings = lights->surroundings.upper + lights->surroundings.lower > 0.0f;
    }
    return status;
}

static clast_status make_punctual(clast_context *context, clast_lights *lights)
{
    const clast_scene *scene = lights->frame->scene;
    if (scene->light_count == 0) {
        return CLAST_OK;
    }
    clast_choice_table *table = &lights->punctual;
    table->count = (uint32_t)scene->light_count;
    table->sums = clast_allocate(context, scene->light_count + 1, sizeof *table->sums);
    if (table->sums == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        const clast_light *light = &lights->frame->motion.lights[i];
        float scale = light->type == CLAST_LIGHT_DIRECTIONAL ? lights->extent * lights->extent : 1.0f;
        table->sums[i + 1] = luminance(load3(light->radiance)) * scale;
    }
    table->total = clast_sums_make(table->sums, table->count);
    return CLAST_OK;
}

// The mean emission of a triangle, from a few of its points.
static vec3 mean_emission(const clast_lights *lights, const clast_emitter *emitter)
{
    const clast_frame *frame = lights->frame;
    const clast_material *material = &frame->scene->materials[emitter->material].record;
    if (material->emissive_texture.texture == CLAST_NONE) {
        return load3(material->emissive);
    }
    static const float points[4][2] = {{0.3333f, 0.3333f}, {0.6f, 0.2f}, {0.2f, 0.6f}, {0.2f, 0.2f}};
    const clast_frame_unit *unit = &frame->units[frame->instances[emitter->instance].unit];
    vec3 sum = splat3(0.0f);
    for (int i = 0; i < 4; i++) {
        clast_surface_point point = {.primitive = emitter->primitive, .coordinates = {{points[i][0], points[i][1]}}};
        clast_source_surface surface = clast_source_of(unit->unit)->evaluate(unit->unit, &unit->pose, point);
        sum = sum + clast_emission(frame->scene, material, surface.coordinates, lights->table) * 0.25f;
    }
    // Dark where it was looked at: there may be light beside.
    return max3(sum, load3(material->emissive) * 0.02f);
}

static void emitter_weights(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_lights *lights = data;
    for (size_t i = begin; i < end; i++) {
        const clast_emitter *emitter = &lights->frame->emitters[i];
        lights->emitters.sums[i + 1] = emitter->area * luminance(mean_emission(lights, emitter));
    }
}

static void bound_emitters(clast_lights *lights)
{
    const clast_frame *frame = lights->frame;
    vec3 lower = splat3(INFINITY), upper = splat3(-INFINITY);
    for (size_t i = 0; i < frame->emitter_count; i++) {
        for (int k = 0; k < 3; k++) {
            lower = min3(lower, load3(frame->emitters[i].corners[k]));
            upper = max3(upper, load3(frame->emitters[i].corners[k]));
        }
    }
    lights->emitter_centre = (lower + upper) * 0.5f;
    lights->emitter_radius = 0.5f * length3(upper - lower);
}

static clast_status make_emitters(clast_context *context, clast_lights *lights)
{
    const clast_frame *frame = lights->frame;
    if (frame->emitter_count == 0) {
        return CLAST_OK;
    }
    if (frame->emitter_count >= UINT32_MAX) {
        return clast_fail(context, CLAST_ERROR_LIMIT,
                          "the frame has %zu emissive triangles; at most 2^32 - 2 are possible", frame->emitter_count);
    }
    clast_choice_table *table = &lights->emitters;
    table->count = (uint32_t)frame->emitter_count;
    table->sums = clast_allocate(context, frame->emitter_count + 1, sizeof *table->sums);
    lights->first_emitter = clast_allocate(context, frame->instance_count + 1, sizeof *lights->first_emitter);
    if (table->sums == NULL || lights->first_emitter == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(context, frame->emitter_count, 256, emitter_weights, lights);
    table->total = clast_sums_make(table->sums, table->count);
    size_t emitter = 0;
    for (size_t i = 0; i <= frame->instance_count; i++) {
        while (emitter < frame->emitter_count && frame->emitters[emitter].instance < i) {
            emitter++;
        }
        lights->first_emitter[i] = (uint32_t)emitter;
    }
    bound_emitters(lights);
    return CLAST_OK;
}

static float scene_extent(const clast_frame *frame)
{
    vec3 lower = splat3(INFINITY), upper = splat3(-INFINITY);
    for (size_t i = 0; i < frame->instance_count; i++) {
        lower = min3(lower, load3(frame->instances[i].bounds.lower));
        upper = max3(upper, load3(frame->instances[i].bounds.upper));
    }
    float extent = length3(upper - lower);
    return extent > 0.0f && is_finite1(extent) ? extent : 1.0f;
}

clast_status clast_lights_create(const clast_frame *frame, const clast_srgb_table *table, clast_lights **result)
{
    clast_context *context = frame->context;
    clast_lights *lights = clast_allocate_zeroed(context, 1, sizeof *lights);
    if (lights == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    lights->frame = frame;
    lights->table = table;
    lights->extent = scene_extent(frame);
    clast_status status = make_surroundings(context, lights);
    if (status == CLAST_OK) {
        status = make_punctual(context, lights);
    }
    if (status == CLAST_OK) {
        status = make_emitters(context, lights);
    }
    if (status != CLAST_OK) {
        clast_lights_destroy(context, lights);
        return status;
    }
    *result = lights;
    return CLAST_OK;
}

void clast_lights_destroy(clast_context *context, clast_lights *lights)
{
    if (lights == NULL) {
        return;
    }
    clast_sky_destroy(context, &lights->sky);
    clast_surroundings_destroy(context, &lights->surroundings);
    clast_free(context, lights->punctual.sums);
    clast_free(context, lights->emitters.sums);
    clast_free(context, lights->first_emitter);
    clast_free(context, lights);
}

// ------------------------------------------------------------------------------------------------------------ far away

// 1 - cosine between a unit vector and the sun's middle. Of small angles, the difference itself would keep no digits.
static float below_sun(const clast_lights *lights, vec3 direction)
{
    vec3 difference = direction - load3(lights->sun.z);
    return 0.5f * dot3(difference, difference);
}

vec3 clast_distant_radiance(const clast_lights *lights, vec3 direction)
{
    if (!lights->has_surroundings && !lights->has_sun) {
        return splat3(0.0f);
    }
    vec3 radiance = clast_surroundings_radiance(lights, direction);
    if (lights->has_sun) {
        float below = below_sun(lights, direction);
        if (below < lights->sun_height && direction[1] > 0.0f) {
            radiance = radiance +
                       lights->sun_irradiance * (lights->sun_density * sun_profile(below, lights->sun_height));
        }
    }
    return radiance;
}

float clast_distant_density(const clast_lights *lights, const clast_light_shares *shares, vec3 direction)
{
    float density = 0.0f;
    if (shares->surroundings > 0.0f) {
        density = shares->surroundings * clast_surroundings_density(&lights->surroundings, direction);
    }
    if (shares->sun > 0.0f && below_sun(lights, direction) < lights->sun_height) {
        density += shares->sun * lights->sun_density;
    }
    return density;
}

// --------------------------------------------------------------------------------------------------------------- shares

static float facing(vec3 geometric_normal, vec3 normal, vec3 direction)
{
    return dot3(geometric_normal, direction) > 0.0f ? 0.1f + 0.9f * max1(dot3(normal, direction), 0.0f) : 0.0f;
}

static float punctual_weight(const clast_lights *lights, uint32_t number, vec3 position, vec3 geometric_normal,
                             vec3 normal)
{
    clast_incoming incoming = light_incoming(lights->frame->motion.lights[number], position);
    return luminance(load3(incoming.irradiance)) * facing(geometric_normal, normal, load3(incoming.direction));
}

static float least(float weight, float sum)
{
    return weight > 0.0f ? max1(weight, LEAST_SHARE * sum) : 0.0f;
}

clast_light_shares clast_lights_share(const clast_lights *lights, vec3 position, vec3 geometric_normal, vec3 normal)
{
    clast_light_shares s = {0.0f, 0.0f, 0.0f, 0.0f};
    if (lights->has_surroundings) {
        float up = 0.5f + 0.5f * normal[1];
        s.surroundings = PI * (lights->surroundings.upper * up + lights->surroundings.lower * (1.0f - up));
        s.surroundings = max1(s.surroundings, 1e-3f * (lights->surroundings.upper + lights->surroundings.lower));
    }
    if (lights->has_sun) {
        vec3 sun = load3(lights->sun.z);
        // A wide sun may stand half above the surface's horizon.
        float reach = rough_sqrt(2.0f * lights->sun_height);
        s.sun = dot3(geometric_normal, sun) > -reach ? 1.0f : 0.0f;
    }
    if (lights->punctual.count > PUNCTUAL_MOST) {
        s.punctual = lights->punctual.total / (lights->extent * lights->extent);
    } else {
        for (uint32_t i = 0; i < lights->punctual.count; i++) {
            s.punctual += punctual_weight(lights, i, position, geometric_normal, normal);
        }
    }
    if (lights->emitters.count != 0) {
        vec3 away = lights->emitter_centre - position;
        float square = max1(dot3(away, away), 0.25f * lights->emitter_radius * lights->emitter_radius);
        s.emitters = lights->emitters.total / max1(square, 1e-30f);
    }
    float sum = s.surroundings + s.punctual + s.emitters;
    s = (clast_light_shares){least(s.surroundings, sum), s.sun, least(s.punctual, sum), least(s.emitters, sum)};
    sum = s.surroundings + s.punctual + s.emitters;
    float scale = sum > 0.0f && is_finite1(sum) ? 1.0f / sum : 0.0f;
    return (clast_light_shares){s.surroundings * scale, s.sun, s.punctual * scale, s.emitters * scale};
}

// -------------------------------------------------------------------------------------------------------------- samples

static clast_light_sample sample_distant(const clast_lights *lights, const clast_light_shares *shares, vec3 direction)
{
    return (clast_light_sample){
        .direction = direction,
        .is_distant = true,
        .radiance = clast_distant_radiance(lights, direction),
        .density = clast_distant_density(lights, shares, direction),
    };
}

// Which punctual light, and how likely.
static uint32_t choose_punctual(const clast_lights *lights, vec3 position, float choice, float *density)
{
    uint32_t count = lights->punctual.count;
    if (count > PUNCTUAL_MOST) {
        float rest;
        uint32_t number = clast_sums_find(lights->punctual.sums, count, choice, &rest);
        *density = lights->punctual.sums[number + 1] - lights->punctual.sums[number];
        return number;
    }
    float weights[PUNCTUAL_MOST], sum = 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        weights[i] = luminance(load3(light_incoming(lights->frame->motion.lights[i], position).irradiance));
        sum += weights[i];
    }
    float before = 0.0f;
    uint32_t chosen = count;
    for (uint32_t i = 0; i < count; i++) {
        if (weights[i] > 0.0f && (chosen == count || choice * sum >= before)) {
            chosen = i;
        }
        before += weights[i];
    }
    *density = chosen < count && is_finite1(sum) ? weights[chosen] / sum : 0.0f;
    return chosen;
}

static clast_light_sample sample_punctual(const clast_lights *lights, const clast_light_shares *shares, vec3 position,
                                          float choice)
{
    float density;
    uint32_t number = choose_punctual(lights, position, choice, &density);
    if (!(density > 0.0f)) {
        return (clast_light_sample){.density = 0.0f};
    }
    const clast_light *light = &lights->frame->motion.lights[number];
    clast_incoming incoming = light_incoming(*light, position);
    return (clast_light_sample){
        .direction = load3(incoming.direction),
        .target = load3(light->position),
        .is_distant = light->type == CLAST_LIGHT_DIRECTIONAL,
        .is_point = true,
        .radiance = load3(incoming.irradiance),
        .density = shares->punctual * density,
    };
}

// The point is moved towards the viewer by what arithmetic may have moved it by, so that its own triangle does not hide it.
static clast_light_sample sample_emitter(const clast_lights *lights, const clast_light_shares *shares, vec3 position,
                                         float choice, vec2 u)
{
    const clast_frame *frame = lights->frame;
    float rest;
    uint32_t number = clast_sums_find(lights->emitters.sums, lights->emitters.count, choice, &rest);
    const clast_emitter *emitter = &frame->emitters[number];
    vec2 weights = sample_triangle(u);
    vec3 a = load3(emitter->corners[0]), b = load3(emitter->corners[1]), c = load3(emitter->corners[2]);
    vec3 place = a + (b - a) * weights[0] + (c - a) * weights[1];
    vec3 normal = cross3(b - a, c - a) * (1.0f / (2.0f * emitter->area));
    vec3 away = place - position;
    float distance = length3(away);
    if (!(distance > 0.0f)) {
        return (clast_light_sample){.density = 0.0f};
    }
    vec3 direction = away * (1.0f / distance);
    const clast_frame_instance *instance = &frame->instances[emitter->instance];
    const clast_frame_unit *unit = &frame->units[instance->unit];
    const clast_material *material = &frame->scene->materials[emitter->material].record;
    vec3 emission = load3(material->emissive);
    if (material->emissive_texture.texture != CLAST_NONE) {
        clast_surface_point point = {.primitive = emitter->primitive, .coordinates = store2(weights)};
        clast_source_surface surface = clast_source_of(unit->unit)->evaluate(unit->unit, &unit->pose, point);
        emission = clast_emission(frame->scene, material, surface.coordinates, lights->table);
    }
    vec3 bound = max3(load3(unit->bounds.upper), load3(unit->bounds.lower) * -1.0f);
    float extent = largest3(load3(unit->bounds.upper) - load3(unit->bounds.lower));
    vec3 error = clast_position_error(instance, max3(bound, splat3(0.0f)), extent, place);
    vec3 size = vec3(abs1(normal[0]), abs1(normal[1]), abs1(normal[2]));
    float offset = 2.0f * dot3(size, error);
    return (clast_light_sample){
        .direction = direction,
        .target = place + normal * (dot3(normal, direction) < 0.0f ? offset : -offset),
        .radiance = emission,
        .density = clast_emitter_density(lights, shares, emitter->instance, emitter->primitive, distance,
                                         dot3(normal, direction)),
    };
}

clast_light_sample clast_lights_sample_sun(const clast_lights *lights, const clast_light_shares *shares, vec2 u)
{
    if (!(shares->sun > 0.0f)) {
        return (clast_light_sample){.density = 0.0f};
    }
    return sample_distant(lights, shares, normalize3(from_basis(lights->sun, sample_cone(u, lights->sun_height))));
}

clast_light_sample clast_lights_sample(const clast_lights *lights, const clast_light_shares *shares, vec3 position,
                                       float choice, vec2 u)
{
    if (choice < shares->surroundings) {
        float density;
        return sample_distant(lights, shares, clast_surroundings_sample(&lights->surroundings, u, &density));
    }
    choice -= shares->surroundings;
    if (choice < shares->punctual) {
        return sample_punctual(lights, shares, position, choice / shares->punctual);
    }
    choice -= shares->punctual;
    if (shares->emitters > 0.0f) {
        return sample_emitter(lights, shares, position, min1(choice / shares->emitters, 0.99999994f), u);
    }
    return (clast_light_sample){.density = 0.0f};
}

float clast_emitter_density(const clast_lights *lights, const clast_light_shares *shares, uint32_t frame_instance,
                            uint32_t primitive, float distance, float cosine)
{
    if (!(shares->emitters > 0.0f)) {
        return 0.0f;
    }
    // Emitters of an instance are in order of their primitives.
    const clast_emitter *emitters = lights->frame->emitters;
    uint32_t low = lights->first_emitter[frame_instance], high = lights->first_emitter[frame_instance + 1], end = high;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (emitters[middle].primitive < primitive) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (low == end || emitters[low].primitive != primitive) {
        return 0.0f; // it has no area, or its source has no such list: found by chance alone
    }
    float share = lights->emitters.sums[low + 1] - lights->emitters.sums[low];
    float size = max1(abs1(cosine), 1e-6f) * emitters[low].area;
    return shares->emitters * share * distance * distance / size;
}
