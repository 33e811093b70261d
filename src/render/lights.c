// SPDX-License-Identifier: Apache-2.0
// Tables over a frame's lights, and one light chosen for a point.
#include "render/lights.h"

#include "base/thread.h"
#include "render/surface.h"

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
        clast_texture_area area = clast_texture_point(surface.coordinates);
        sum = sum + clast_emission(frame->scene, material, &area, lights->table) * 0.25f;
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

// --------------------------------------------------------------------------------------------------------------- shares

// How strong a punctual light is at a point, whatever the surface there.
static float punctual_strength(const clast_lights *lights, uint32_t number, vec3 position)
{
    return luminance(load3(light_incoming(lights->frame->motion.lights[number], position).irradiance));
}

static float punctual_weight(const clast_lights *lights, uint32_t number, vec3 position, vec3 geometric_normal,
                             vec3 normal)
{
    clast_incoming incoming = light_incoming(lights->frame->motion.lights[number], position);
    return luminance(load3(incoming.irradiance)) * light_facing(geometric_normal, normal, load3(incoming.direction));
}

static float punctual_sum(const clast_lights *lights, vec3 position, vec3 geometric_normal, vec3 normal)
{
    if (lights->punctual.count > PUNCTUAL_WEIGHED) {
        return lights->punctual.total / (lights->extent * lights->extent);
    }
    float sum = 0.0f;
    for (uint32_t i = 0; i < lights->punctual.count; i++) {
        sum += punctual_weight(lights, i, position, geometric_normal, normal);
    }
    return sum;
}

clast_light_shares clast_lights_share(const clast_lights *lights, vec3 position, vec3 geometric_normal, vec3 normal)
{
    const clast_surroundings *around = &lights->surroundings;
    float surroundings = lights->has_surroundings ? surroundings_strength(around->upper, around->lower, normal) : 0.0f;
    float sun = lights->has_sun ? sun_share(load3(lights->sun.z), lights->sun_height, geometric_normal) : 0.0f;
    float punctual = punctual_sum(lights, position, geometric_normal, normal);
    float emitters = lights->emitters.count != 0 ? emitters_strength(lights->emitters.total, lights->emitter_centre,
                                                                     lights->emitter_radius, position)
                                                 : 0.0f;
    return shares_of_strengths(surroundings, sun, punctual, emitters);
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

// Which punctual light, and how likely.
static uint32_t choose_punctual(const clast_lights *lights, vec3 position, float choice, float *density)
{
    uint32_t count = lights->punctual.count;
    if (count > PUNCTUAL_WEIGHED) {
        float rest;
        uint32_t number = clast_sums_find(lights->punctual.sums, count, choice, &rest);
        *density = lights->punctual.sums[number + 1] - lights->punctual.sums[number];
        return number;
    }
    float weights[PUNCTUAL_WEIGHED], sum = 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        weights[i] = punctual_strength(lights, i, position);
        sum += weights[i];
    }
    clast_weighed_choice chosen = choice_begin();
    for (uint32_t i = 0; i < count; i++) {
        chosen = choice_step(chosen, i, weights[i], choice * sum);
    }
    *density = chosen.chosen < count && is_finite1(sum) ? chosen.weight / sum : 0.0f;
    return chosen.chosen;
}

static clast_light_sample sample_punctual(const clast_lights *lights, const clast_light_shares *shares, vec3 position,
                                          float choice)
{
    float density;
    uint32_t number = choose_punctual(lights, position, choice, &density);
    clast_light_sample light = no_light();
    if (!(density > 0.0f)) {
        return light;
    }
    const clast_light *from = &lights->frame->motion.lights[number];
    clast_incoming incoming = light_incoming(*from, position);
    light.direction = incoming.direction;
    light.target = from->position;
    light.is_distant = from->type == CLAST_LIGHT_DIRECTIONAL;
    light.is_point = 1;
    light.radiance = incoming.irradiance;
    light.density = shares->punctual * density;
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

static clast_light_sample sample_emitter(const clast_lights *lights, const clast_light_shares *shares, vec3 position,
                                         float choice, vec2 u)
{
    const clast_frame *frame = lights->frame;
    float rest;
    uint32_t number = clast_sums_find(lights->emitters.sums, lights->emitters.count, choice, &rest);
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
    light.density = clast_emitter_density(lights, shares, emitter->instance, emitter->primitive, point.distance,
                                          dot3(load3(point.normal), load3(point.direction)));
    return light;
}

clast_light_sample clast_lights_sample_sun(const clast_lights *lights, const clast_light_shares *shares, vec2 u)
{
    if (!(shares->sun > 0.0f)) {
        return no_light();
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
    return no_light();
}

float clast_emitter_density(const clast_lights *lights, const clast_light_shares *shares, uint32_t frame_instance,
                            uint32_t primitive, float distance, float cosine)
{
    if (!(shares->emitters > 0.0f)) {
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
    float share = lights->emitters.sums[search.low + 1] - lights->emitters.sums[search.low];
    return emitter_density(shares->emitters, share, emitters[search.low].area, distance, cosine);
}
