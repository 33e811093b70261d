// SPDX-License-Identifier: Apache-2.0
// Tables and the tree over a frame's lights.
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

static clast_status make_directional(clast_context *context, clast_lights *lights)
{
    const clast_scene *scene = lights->frame->scene;
    uint32_t count = 0;
    for (size_t i = 0; i < scene->light_count; i++) {
        count += lights->frame->motion.lights[i].type == CLAST_LIGHT_DIRECTIONAL;
    }
    if (count == 0) {
        return CLAST_OK;
    }
    clast_choice_table *table = &lights->directional;
    table->sums = clast_allocate(context, (size_t)count + 1, sizeof *table->sums);
    lights->directional_numbers = clast_allocate(context, count, sizeof *lights->directional_numbers);
    if (table->sums == NULL || lights->directional_numbers == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        const clast_light *light = &lights->frame->motion.lights[i];
        if (light->type == CLAST_LIGHT_DIRECTIONAL) {
            lights->directional_numbers[table->count++] = (uint32_t)i;
            table->sums[table->count] = light_strength(load3(light->radiance));
        }
    }
    table->total = clast_sums_make(table->sums, table->count);
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- emitters

typedef struct radiance_job {
    const clast_lights *lights;
    float *radiances;
} radiance_job;

enum { POINTS_LEAST = 4, POINTS_MOST = 256 };

// How many points of a triangle are looked at for its mean emission: about one for each texel on it.
static uint32_t emission_points(const clast_lights *lights, const clast_emitter *emitter, const clast_texture_use *use)
{
    const clast_frame *frame = lights->frame;
    const clast_scene *scene = frame->scene;
    uint32_t number = use->texture < scene->texture_count ? scene->textures[use->texture].image : CLAST_NONE;
    if (number >= scene->image_count) {
        return POINTS_LEAST;
    }
    static const float corners[3][2] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}};
    const clast_frame_unit *unit = &frame->units[frame->instances[emitter->instance].unit];
    vec2 places[3];
    for (int k = 0; k < 3; k++) {
        clast_surface_point point = {.primitive = emitter->primitive, .coordinates = {{corners[k][0], corners[k][1]}}};
        clast_source_surface surface = clast_source_of(unit->unit)->evaluate(unit->unit, &unit->pose, point);
        places[k] = transform_coordinates(*use, surface.coordinates[use->coordinate_set & 1]);
    }
    vec2 a = places[1] - places[0], b = places[2] - places[0];
    const clast_image *image = &scene->images[number].image;
    float texels = 0.5f * abs1(a[0] * b[1] - a[1] * b[0]) * (float)image->width * (float)image->height;
    return to_uint(clamp1(texels, (float)POINTS_LEAST, (float)POINTS_MOST));
}

// Luminance of a triangle's emission, the mean over points of it.
static float mean_emission(const clast_lights *lights, const clast_emitter *emitter)
{
    const clast_frame *frame = lights->frame;
    const clast_material *material = &frame->scene->materials[emitter->material].record;
    float even = light_strength(load3(material->emissive));
    if (material->emissive_texture.texture == CLAST_NONE) {
        return even;
    }
    const clast_frame_unit *unit = &frame->units[frame->instances[emitter->instance].unit];
    uint32_t points = emission_points(lights, emitter, &material->emissive_texture);
    float sum = 0.0f;
    for (uint32_t i = 0; i < points; i++) {
        clast_surface_point point = {.primitive = emitter->primitive,
                                     .coordinates = store2(sample_triangle(sample_square(i, 0)))};
        clast_source_surface surface = clast_source_of(unit->unit)->evaluate(unit->unit, &unit->pose, point);
        clast_texture_area area = clast_texture_point(surface.coordinates);
        sum += light_strength(clast_emission(frame->scene, material, &area, lights->table));
    }
    // Dark where it was looked at: there may be light beside.
    return max1(sum / (float)points, even * (0.5f / (float)points));
}

static void emitter_radiances(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const radiance_job *job = data;
    for (size_t i = begin; i < end; i++) {
        float radiance = mean_emission(job->lights, &job->lights->frame->emitters[i]);
        job->radiances[i] = clamp1(radiance, 1e-30f, 1e30f);
    }
}

static clast_status number_emitters(clast_context *context, clast_lights *lights)
{
    const clast_frame *frame = lights->frame;
    lights->first_emitter = clast_allocate(context, frame->instance_count + 1, sizeof *lights->first_emitter);
    if (lights->first_emitter == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    size_t emitter = 0;
    for (size_t i = 0; i <= frame->instance_count; i++) {
        while (emitter < frame->emitter_count && frame->emitters[emitter].instance < i) {
            emitter++;
        }
        lights->first_emitter[i] = (uint32_t)emitter;
    }
    return CLAST_OK;
}

static clast_status make_tree(clast_context *context, clast_lights *lights)
{
    const clast_frame *frame = lights->frame;
    lights->emitter_count = (uint32_t)frame->emitter_count;
    radiance_job job = {lights, clast_allocate(context, frame->emitter_count, sizeof(float))};
    if (job.radiances == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(context, frame->emitter_count, 256, emitter_radiances, &job);
    clast_light_sources sources = {.emitters = frame->emitters,
                                   .emitter_radiances = job.radiances,
                                   .emitter_count = frame->emitter_count,
                                   .punctual = frame->motion.lights,
                                   .punctual_count = frame->scene->light_count,
                                   .extent = lights->extent};
    clast_status status = clast_light_tree_create(context, &sources, &lights->tree);
    clast_free(context, job.radiances);
    return status == CLAST_OK && frame->emitter_count != 0 ? number_emitters(context, lights) : status;
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
        status = make_directional(context, lights);
    }
    if (status == CLAST_OK) {
        status = make_tree(context, lights);
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
    clast_free(context, lights->directional.sums);
    clast_free(context, lights->directional_numbers);
    clast_light_tree_destroy(context, &lights->tree);
    clast_free(context, lights->first_emitter);
    clast_free(context, lights);
}
