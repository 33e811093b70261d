// SPDX-License-Identifier: Apache-2.0
// The path integrator: shared/path.h tells what a path does at a surface; here are the order of things and the tiles.
#include "render/path.h"

#include "base/thread.h"
#include "render/scatter.h"

enum { SURFACES = 16 }; // that are found before the first of them is shaded

// By the pixel's place in the whole picture.
static clast_pixel_samples samples_of(const clast_render_target *target, clast_path_pixel at)
{
    return pixel_samples(target->area.x + at.x, target->area.y + at.y, target->settings.seed, target->power);
}

static vec2 next_square(const clast_render_target *target, clast_pixel_samples samples, uint32_t bounce, uint32_t use)
{
    return path_square(target->sample, samples, bounce, use);
}

clast_camera_ray clast_primary_ray(const clast_frame *frame, const clast_render_target *target, clast_path_pixel at)
{
    return primary_ray(frame->settings.camera, target->width, target->height, target->area.x + at.x,
                       target->area.y + at.y, target->sample, samples_of(target, at));
}

clast_ray clast_ray_of(clast_camera_ray from)
{
    const float *o = from.origin.v, *d = from.direction.v;
    return (clast_ray){{o[0], o[1], o[2]}, from.t_min, {d[0], d[1], d[2]}, from.t_max};
}

// ------------------------------------------------------------------------------------------------------------- a bounce

// A surface that a path reached, and how it scatters.
typedef struct interaction {
    clast_path_surface at;
    clast_bsdf bsdf;
    vec3 view; // in the surface's frame
} interaction;

static clast_path_surface surface_of(const clast_shading_point *point)
{
    return (clast_path_surface){
        .position = store3(point->position),
        .geometric_normal = store3(point->geometric_normal),
        .normal = store3(point->normal),
        .offset = point->offset,
        .frame = point->frame,
    };
}

static interaction interact(const clast_render_target *target, clast_path *path, const clast_shading_point *point,
                            uint32_t bounce)
{
    interaction made = {.at = surface_of(point)};
    made.view = path_view(made.at, path->direction);
    clast_bsdf_input surface = point->surface;
    if (surface.dispersion > 0.0f) {
        float choice = next_square(target, path->samples, bounce, PATH_USE_ROULETTE)[1];
        clast_path_colour chosen = path_choose_colour(path->throughput, choice);
        path->throughput = load3(chosen.throughput);
        surface = surface_of_colour(surface, chosen.colour);
    }
    made.bsdf = clast_scatter_make(target->scatter, point->material, &surface, path->alpha_floor, made.view);
    return made;
}

static clast_ray ray_of(packed3 origin, packed3 direction, float t_max)
{
    const float *o = origin.v, *d = direction.v;
    return (clast_ray){{o[0], o[1], o[2]}, 0.0f, {d[0], d[1], d[2]}, t_max};
}

static clast_ray leave_surface(const clast_path_surface *at, vec3 direction, float t_max)
{
    return ray_of(store3(beside_surface(*at, direction)), store3(direction), t_max);
}

// Chooses where the path goes on; false where it ends.
static bool sample_direction(const clast_render_target *target, clast_path *path, const interaction *of,
                             const clast_shading_point *point, uint32_t bounce)
{
    vec2 u = next_square(target, path->samples, bounce, PATH_USE_DIRECTION);
    float lobe = next_square(target, path->samples, bounce, PATH_USE_CHOICE)[1];
    clast_bsdf_sample chosen = bsdf_direction(of->bsdf, of->view, u, lobe);
    vec3 direction = path_direction(of->at, chosen);
    if (load3(chosen.direction)[2] == 0.0f) {
        return false;
    }
    bool softens = target->settings.fireflies == CLAST_FIREFLIES_SOFTENED;
    clast_path_step step = path_step(of->at, of->bsdf, chosen, direction,
                                     path_scatter(of->at, of->bsdf, of->view, direction), path->throughput,
                                     path->alpha_floor, softens);
    if (!(step.density > 0.0f)) {
        return false;
    }
    path->throughput = load3(step.throughput);
    path->direction = load3(step.direction);
    path->density = step.density;
    path->alpha_floor = step.alpha_floor;
    path->cone = cone_scattered(point->cone, point->bend, step.passes != 0, step.density, target->sample);
    if (step.passes != 0) {
        path->absorption = of->bsdf.thin != 0 || point->surface.inside != 0 ? splat3(0.0f) : point->absorption;
    }
    return true;
}

// Paths that carry little end by chance.
static bool survives(const clast_render_target *target, clast_path *path, uint32_t bounce)
{
    float chance = path_survival(path->throughput, bounce);
    if (chance < 1.0f && next_square(target, path->samples, bounce, PATH_USE_ROULETTE)[0] >= chance) {
        return false;
    }
    path->throughput = path->throughput * (1.0f / chance);
    return true;
}

// --------------------------------------------------------------------------------------------------------------- a tile

typedef struct tile_job {
    const clast_frame *frame;
    clast_render_target *target;
    clast_scratch *scratch;
    uint32_t path_count;
    uint32_t shadow_count;
} tile_job;

static void add3(float *sums, uint32_t pixel, vec3 value)
{
    for (int c = 0; c < 3; c++) {
        sums[3 * (size_t)pixel + (size_t)c] += value[c];
    }
}

static void finish_path(const tile_job *job, const clast_path *path)
{
    clast_render_target *target = job->target;
    vec3 radiance = path->radiance;
    if (target->settings.fireflies == CLAST_FIREFLIES_CLAMPED) {
        radiance = clamp_indirect(radiance, path->direct);
    }
    if (!is_finite3(radiance)) {
        atomic_fetch_add_explicit(&target->rejected, 1, memory_order_relaxed);
        radiance = splat3(0.0f);
    }
    add3(target->sums[CLAST_VIEW_COLOUR], path->pixel, radiance);
    if (target->halves != NULL && is_of_half(target->sample)) {
        add3(target->halves, path->pixel, radiance);
    }
}

static void add_surface_views(clast_render_target *target, uint32_t pixel, const clast_shading_point *point)
{
    if (target->sums[CLAST_VIEW_ALBEDO] != NULL) {
        add3(target->sums[CLAST_VIEW_ALBEDO], pixel, load3(point->surface.base.base_colour));
    }
    if (target->sums[CLAST_VIEW_NORMAL] != NULL) {
        add3(target->sums[CLAST_VIEW_NORMAL], pixel, point->normal);
    }
    // A mean over an edge or a seam would be no place at all.
    if (target->sums[CLAST_VIEW_UV] != NULL && target->sample == 0) {
        target->sums[CLAST_VIEW_UV][2 * (size_t)pixel] = point->coordinates[0];
        target->sums[CLAST_VIEW_UV][2 * (size_t)pixel + 1] = point->coordinates[1];
    }
}

static void add_distant_light(const tile_job *job, clast_path *path, uint32_t bounce)
{
    const clast_lights *lights = job->target->lights;
    float weight = bounce == 0
                       ? 1.0f
                       : mis_weight(path->density, clast_distant_density(lights, &path->shares, path->direction));
    path->radiance = path->radiance + path->throughput * clast_distant_radiance(lights, path->direction) * weight;
}

static void add_emission(const tile_job *job, clast_path *path, const clast_visibility *seen,
                         const clast_shading_point *point, uint32_t bounce)
{
    if (!(largest3(point->emission) > 0.0f)) {
        return;
    }
    float weight = 1.0f;
    if (bounce != 0) {
        float cosine = dot3(point->geometric_normal, path->direction);
        float other = clast_emitter_density(job->target->lights, &path->shares, path->lit, point->frame_instance,
                                            point->primitive, seen->distance, cosine);
        weight = mis_weight(path->density, other);
    }
    path->radiance = path->radiance + path->throughput * point->emission * weight;
}

static void add_shadow(tile_job *job, uint32_t from, const interaction *of, const clast_light_sample *light)
{
    clast_scratch *scratch = job->scratch;
    if (!light_shines(*light)) {
        return;
    }
    clast_brdf_answer answer = path_scatter(of->at, of->bsdf, of->view, load3(light->direction));
    clast_path_connection made = path_connect(of->at, answer, scratch->paths[from].throughput, *light);
    if (largest3(load3(made.radiance)) > 0.0f) {
        uint32_t place = job->shadow_count++;
        scratch->shadow_rays[place] = ray_of(made.origin, made.direction, made.t_max);
        scratch->shadow_radiance[place] = load3(made.radiance);
        scratch->shadow_paths[place] = from;
    }
}

static void sample_lights(tile_job *job, uint32_t from, const interaction *of, uint32_t bounce)
{
    const clast_render_target *target = job->target;
    const clast_path *path = &job->scratch->paths[from];
    vec2 u = next_square(target, path->samples, bounce, PATH_USE_LIGHT);
    float choice = next_square(target, path->samples, bounce, PATH_USE_CHOICE)[0];
    clast_light_sample light = clast_lights_sample(target->lights, &path->shares, path->lit, choice, u);
    add_shadow(job, from, of, &light);
    if (path->shares.sun > 0.0f) {
        light = clast_lights_sample_sun(target->lights, &path->shares,
                                        next_square(target, path->samples, bounce, PATH_USE_SUN));
        add_shadow(job, from, of, &light);
    }
}

// Scatters light at a surface; where the path goes on, ray `to` is its next.
static bool scatter_path(tile_job *job, uint32_t from, uint32_t to, uint32_t bounce, const clast_shading_point *point)
{
    clast_render_target *target = job->target;
    clast_path *path = &job->scratch->paths[from];
    interaction of = interact(target, path, point, bounce);
    path->lit = lit_point(point->position, point->normal, bsdf_passes(of.bsdf));
    path->shares = clast_lights_share(target->lights, path->lit, point->geometric_normal, point->normal);
    sample_lights(job, from, &of, bounce);
    if (!sample_direction(target, path, &of, point, bounce) || !survives(target, path, bounce)) {
        return false;
    }
    job->scratch->rays[to] = leave_surface(&of.at, path->direction, INFINITY);
    return true;
}

// Light that was scattered once is what shadow rays from the first surface bring, and what the first scattered ray meets.
static void note_direct(clast_path *path, uint32_t bounce)
{
    if (bounce <= 1) {
        path->direct = path->radiance;
    }
}

// A shadow ray to a side that is more likely the more the surface faces it: what comes through is white.
static void add_openness(tile_job *job, uint32_t from, const clast_shading_point *point)
{
    clast_scratch *scratch = job->scratch;
    const clast_render_target *target = job->target;
    vec2 u = next_square(target, scratch->paths[from].samples, 0, PATH_USE_DIRECTION);
    vec3 direction = from_basis(basis_around(point->normal), sample_cosine_hemisphere(u));
    if (dot3(direction, point->geometric_normal) <= 0.0f) {
        return;
    }
    float distance = target->settings.ao_distance > 0.0 ? (float)target->settings.ao_distance : INFINITY;
    uint32_t place = job->shadow_count++;
    clast_path_surface at = surface_of(point);
    scratch->shadow_rays[place] = leave_surface(&at, direction, distance);
    scratch->shadow_radiance[place] = splat3(1.0f);
    scratch->shadow_paths[place] = from;
}

static uint32_t most_bounces(const clast_render_target *target)
{
    return target->settings.integrator == CLAST_INTEGRATOR_DIRECT ? 1 : target->settings.bounces;
}

// Takes path `from` a step on from what its ray saw; where it goes on, ray `to` is its next.
static bool step_path(tile_job *job, uint32_t from, uint32_t to, uint32_t bounce, clast_found_surface *found)
{
    clast_render_target *target = job->target;
    clast_path *path = &job->scratch->paths[from];
    const clast_visibility *seen = &job->scratch->seen[from];
    bool has_colour = target->sums[CLAST_VIEW_COLOUR] != NULL;
    if (seen->instance == CLAST_NONE) {
        if (has_colour && target->settings.integrator == CLAST_INTEGRATOR_AO) {
            path->radiance = splat3(1.0f);
        } else if (has_colour && target->settings.integrator != CLAST_INTEGRATOR_PRIMARY) {
            add_distant_light(job, path, bounce);
            note_direct(path, bounce);
        }
        return false;
    }
    if (largest3(path->absorption) > 0.0f) {
        path->throughput = path->throughput * passed_through(path->absorption, seen->distance);
    }
    clast_shade_surface(job->frame, &target->srgb, path->direction * -1.0f, found);
    const clast_shading_point *point = &found->point;
    if (bounce == 0) {
        add_surface_views(target, path->pixel, point);
    }
    if (!has_colour) {
        return false;
    }
    if (target->settings.integrator == CLAST_INTEGRATOR_PRIMARY) {
        float facing = abs1(dot3(point->normal, path->direction));
        path->radiance = point->emission + load3(point->surface.base.base_colour) * facing;
        return false;
    }
    if (target->settings.integrator == CLAST_INTEGRATOR_AO) {
        add_openness(job, from, point);
        return false;
    }
    add_emission(job, path, seen, point, bounce);
    note_direct(path, bounce);
    if (point->unlit) {
        path->radiance = path->radiance + path->throughput * load3(point->surface.base.base_colour);
        return false;
    }
    return bounce < most_bounces(target) && scatter_path(job, from, to, bounce, point);
}

static void trace_shadows(tile_job *job, uint32_t bounce)
{
    clast_scratch *scratch = job->scratch;
    clast_hit_filter filter = {clast_alpha_accepts_by_chance, (void *)job->frame};
    clast_trace_any(job->frame->tlas, scratch->shadow_rays, job->shadow_count, &filter, scratch->occluded);
    for (uint32_t i = 0; i < job->shadow_count; i++) {
        if (scratch->occluded[i] == 0) {
            clast_path *path = &scratch->paths[scratch->shadow_paths[i]];
            path->radiance = path->radiance + scratch->shadow_radiance[i];
            note_direct(path, bounce == 0 ? 0 : 2);
        }
    }
}

static void begin_paths(tile_job *job)
{
    clast_render_target *target = job->target;
    for (uint32_t i = 0; i < job->scratch->pixel_count; i++) {
        clast_path_pixel at = job->scratch->pixels[i];
        uint32_t pixel = at.y * target->area.width + at.x;
        clast_camera_ray ray = clast_primary_ray(job->frame, target, at);
        job->scratch->paths[i] = (clast_path){
            .throughput = splat3(1.0f),
            .radiance = splat3(0.0f),
            .direct = splat3(0.0f),
            .direction = load3(ray.direction),
            .cone = camera_cone(job->frame->settings.camera, target->height, load3(ray.direction), target->sample),
            .pixel = pixel,
            .samples = samples_of(target, at),
        };
        job->scratch->seen[i] = target->visibility[pixel];
    }
    job->path_count = job->scratch->pixel_count;
}

// All paths take a step; those that end are finished, the others close ranks.
static void step_paths(tile_job *job, uint32_t bounce)
{
    clast_scratch *scratch = job->scratch;
    bool goes_on[CLAST_TILE_PIXELS];
    uint32_t count = 0;
    job->shadow_count = 0;
    for (uint32_t first = 0; first < job->path_count; first += SURFACES) {
        uint32_t end = min_uint(first + SURFACES, job->path_count);
        clast_found_surface found[SURFACES];
        for (uint32_t i = first; i < end; i++) {
            if (scratch->seen[i].instance != CLAST_NONE) {
                const clast_path *path = &scratch->paths[i];
                clast_finding_ray ray = {path->direction, path->cone, cone_look(path->cone, job->target->sample)};
                found[i - first] = clast_find_surface(job->frame, &scratch->seen[i], &ray);
            }
        }
        for (uint32_t i = first; i < end; i++) {
            goes_on[i] = step_path(job, i, count, bounce, &found[i - first]);
            count += goes_on[i];
        }
    }
    trace_shadows(job, bounce);
    clast_hit_filter filter = {clast_alpha_accepts_by_chance, (void *)job->frame};
    clast_trace_closest(job->frame->tlas, scratch->rays, count, &filter, scratch->hits);
    atomic_fetch_add_explicit(&job->target->rays, job->shadow_count + count, memory_order_relaxed);
    uint32_t place = 0;
    for (uint32_t i = 0; i < job->path_count; i++) {
        if (goes_on[i]) {
            scratch->paths[place++] = scratch->paths[i];
        } else if (job->target->sums[CLAST_VIEW_COLOUR] != NULL) {
            finish_path(job, &scratch->paths[i]);
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        scratch->seen[i] = clast_visibility_of_hit(&scratch->hits[i]);
    }
    job->path_count = count;
}

void clast_shade_tile(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch)
{
    tile_job job = {.frame = frame, .target = target, .scratch = scratch};
    begin_paths(&job);
    for (uint32_t bounce = 0; job.path_count != 0; bounce++) {
        step_paths(&job, bounce);
    }
}
