// SPDX-License-Identifier: Apache-2.0
// What a light path does at a surface, and which points of the sequence decide it. At each surface one light is sampled,
// and one direction is followed; what both could have found is weighed by the power heuristic (Veach, Robust Monte Carlo
// Methods for Light Transport Simulation, 1997, chapter 9).
#ifndef CLAST_SHARED_PATH_H
#define CLAST_SHARED_PATH_H

#include "shared/bsdf.h"
#include "shared/camera.h"
#include "shared/light_choice.h"

// Which points of the sequence a decision at a bounce uses.
LIMIT(PATH_USE_CAMERA, 0u, "where in the pixel")
LIMIT(PATH_USE_LIGHT, 1u, "where on a light")
LIMIT(PATH_USE_SUN, 2u, "where on the sun")
LIMIT(PATH_USE_CHOICE, 3u, "which light, which lobe")
LIMIT(PATH_USE_DIRECTION, 4u, "where to")
LIMIT(PATH_USE_ROULETTE, 5u, "whether to go on, and in which colour")
LIMIT(PATH_USE_LENS, 6u, "where through the lens")
LIMIT(PATH_USES, 7u, "how many there are")

TABLE float PATH_DIFFUSE_WIDTH = 0.25f;  // least alpha of the lobes after a diffuse surface
TABLE float PATH_GLOSSY_WIDTH = 0.5f;    // and after a glossy one, in parts of its own
TABLE float PATH_INDIRECT_MOST = 10.0f;  // of a sample's light that is clamped: far whiter than white
TABLE float PATH_SURE_SHARE = 4.0f;      // paths go on surely until they carry one over this: ending them earlier costs more noise
                                         // than it saves time
TABLE float PATH_LEAST_SURVIVAL = 0.02f; // of paths that carry next to nothing

// The point for a use at a bounce of the path of a pixel's sample.
FN vec2 path_square(uint sample_number, clast_pixel_samples pixel, uint bounce, uint use)
{
    return square_of_pixel(sample_number, pixel, bounce * PATH_USES + use);
}

// The first sample's go through the centres of pixels.
FN clast_camera_ray primary_ray(clast_camera camera, uint width, uint height, uint x, uint y, uint sample_number,
                                clast_pixel_samples pixel)
{
    vec2 offset = vec2(0.5f, 0.5f);
    vec2 lens = vec2(0.0f, 0.0f);
    if (sample_number != 0u) {
        vec2 u = path_square(sample_number, pixel, 0u, PATH_USE_CAMERA);
        offset = vec2(camera_offset(u[0]), camera_offset(u[1]));
    }
    if (camera.lens_radius > 0.0f) {
        lens = sample_disc(path_square(sample_number, pixel, 0u, PATH_USE_LENS));
    }
    return camera_lens_ray(camera, rough_divide(to_float(x) + offset[0], to_float(width)),
                           rough_divide(to_float(y) + offset[1], to_float(height)), lens);
}

// ------------------------------------------------------------------------------------------------------------ surfaces

// A surface that a path reached.
RECORD(clast_path_surface)
{
    packed3 position;         // on the triangle that the ray hit
    packed3 geometric_normal; // both unit length, on the viewer's side
    packed3 normal;
    float offset;             // how far along the geometric normal rays must begin
    clast_basis frame;        // around the normal
};
RECORD_SIZE(clast_path_surface, 76)

// Towards the viewer in the surface's frame, for a ray that came along a direction.
FN vec3 path_view(clast_path_surface at, vec3 direction)
{
    vec3 view = to_basis(at.frame, direction * -1.0f);
    return vec3(view[0], view[1], max1(view[2], 1e-6f));
}

// Just off the surface, on the side that a direction points to.
FN vec3 beside_surface(clast_path_surface at, vec3 direction)
{
    vec3 normal = load3(at.geometric_normal);
    float offset = dot3(normal, direction) < 0.0f ? -at.offset : at.offset;
    return load3(at.position) + normal * offset;
}

// The scattered part of light from a direction (world space), times the cosine. What passes the surface comes from behind
// its geometry too.
FN clast_brdf_answer path_scatter(clast_path_surface at, clast_bsdf bsdf, vec3 view, vec3 light)
{
    vec3 local = to_basis(at.frame, light);
    float geometric = dot3(load3(at.geometric_normal), light);
    bool above = geometric > 0.0f && local[2] > 0.0f;
    bool below = geometric < 0.0f && local[2] < 0.0f && bsdf_passes(bsdf);
    clast_brdf_answer answer;
    answer.value = store3(splat3(0.0f));
    answer.density = 0.0f;
    if (above || below) {
        answer = bsdf_evaluate(bsdf, view, local);
        float normals = dot3(load3(at.geometric_normal), load3(at.normal));
        float fade = above ? shadow_terminator(geometric, local[2], normals) : 1.0f;
        answer.value = store3(load3(answer.value) * fade);
    }
    return answer;
}

// Where glass parts colours, a path goes on with one of them, chosen by how much it carries of each.
RECORD(clast_path_colour)
{
    packed3 throughput;
    uint colour; // 0 red, 1 green, 2 blue
};
RECORD_SIZE(clast_path_colour, 16)

FN clast_path_colour path_choose_colour(vec3 throughput, float choice)
{
    precise float sum = throughput[0] + throughput[1] + throughput[2];
    precise float at = choice * sum;
    precise bool is_red = at < throughput[0];
    precise bool is_green = !is_red && (at < throughput[0] + throughput[1] || !(throughput[2] > 0.0f));
    clast_path_colour made;
    made.colour = is_red ? 0u : is_green ? 1u : 2u;
    made.throughput = store3(vec3(is_red ? sum : 0.0f, is_green ? sum : 0.0f, is_red || is_green ? 0.0f : sum));
    return made;
}

// The same surface for light of one colour.
FN clast_bsdf_input surface_of_colour(clast_bsdf_input from, uint colour)
{
    clast_bsdf_input made = from;
    made.colour = colour;
    made.base.ior = dispersed_ior(from.base.ior, from.dispersion, colour);
    return made;
}

// What a shadow ray brings where nothing is in between, and the ray: t = 1 is its end, but for lights that are far away.
RECORD(clast_path_connection)
{
    packed3 origin;
    packed3 direction;
    float t_max;
    packed3 radiance; // zero: there is nothing to trace
};
RECORD_SIZE(clast_path_connection, 40)

// `answer` is path_scatter() of the light's direction.
FN clast_path_connection path_connect(clast_path_surface at, clast_brdf_answer answer, vec3 throughput,
                                      clast_light_sample light)
{
    clast_path_connection made;
    vec3 direction = load3(light.direction);
    vec3 radiance = splat3(0.0f);
    if (light_shines(light)) {
        float weight = light.is_point != 0u ? 1.0f : mis_weight(light.density, answer.density);
        radiance = throughput * load3(answer.value) * load3(light.radiance) * rough_divide(weight, light.density);
    }
    bool brings = largest3(radiance) > 0.0f;
    made.radiance = store3(brings ? radiance : splat3(0.0f));
    vec3 origin = beside_surface(at, direction);
    if (light.is_distant == 0u) {
        direction = load3(light.target) - origin;
        origin = beside_surface(at, direction);
    }
    made.origin = store3(origin);
    made.direction = store3(direction);
    made.t_max = light.is_distant != 0u ? uintBitsToFloat(0x7f800000u) : 1.0f;
    return made;
}

// Where a path goes on.
RECORD(clast_path_step)
{
    packed3 direction;
    packed3 throughput;
    float density;      // of the direction, by solid angle; 0: the path ends
    float alpha_floor;  // least width of the lobes to come
    uint passes;        // 1: through the surface
};
RECORD_SIZE(clast_path_step, 36)

// A direction of the surface's frame in the world; zero where there is none.
FN vec3 path_direction(clast_path_surface at, clast_bsdf_sample chosen)
{
    vec3 local = load3(chosen.direction);
    return local[2] != 0.0f ? normalize3(from_basis(at.frame, local)) : splat3(0.0f);
}

// `answer` is path_scatter() of the direction. Light that is focused by a sharp surface onto a dull one is found by rare
// chance; seen from dull surfaces, sharp ones are blurred where `softens` says so (Kaplanyan and Dachsbacher, Path Space
// Regularization for Holistic and Robust Light Transport, 2013).
FN clast_path_step path_step(clast_path_surface at, clast_bsdf bsdf, clast_bsdf_sample chosen, vec3 direction,
                             clast_brdf_answer answer, vec3 throughput, float alpha_floor, bool softens)
{
    clast_path_step made;
    vec3 carried = throughput * load3(answer.value) * rough_divide(1.0f, answer.density);
    bool is_chosen = load3(chosen.direction)[2] != 0.0f;
    bool goes_on = is_chosen && answer.density > 0.0f && largest3(carried) > 0.0f;
    bool passes = dot3(direction, load3(at.geometric_normal)) < 0.0f;
    float width = chosen.diffuse != 0u ? PATH_DIFFUSE_WIDTH : PATH_GLOSSY_WIDTH * load2(bsdf.base.alpha)[1];
    made.direction = store3(direction);
    made.throughput = store3(goes_on ? carried : splat3(0.0f));
    made.density = goes_on ? answer.density : 0.0f;
    made.alpha_floor = softens ? max1(alpha_floor, width) : alpha_floor;
    made.passes = passes ? 1u : 0u;
    return made;
}

// The chance with which a path goes on: those that carry little end by Russian roulette, and those that live carry the
// others' share.
FN float path_survival(vec3 throughput, uint bounce)
{
    float chance = PATH_SURE_SHARE * largest3(throughput);
    bool surely = bounce < 2u || chance >= 1.0f;
    return surely ? 1.0f : max1(chance, PATH_LEAST_SURVIVAL);
}

// Beer and Lambert's law.
FN vec3 passed_through(vec3 absorption, float distance)
{
    vec3 depth = absorption * distance;
    return vec3(rough_exp(-depth[0]), rough_exp(-depth[1]), rough_exp(-depth[2]));
}

// Of a path's light, the direct part counts whole.
FN vec3 clamp_indirect(vec3 radiance, vec3 direct)
{
    vec3 indirect = radiance - direct;
    float scale = rough_divide(PATH_INDIRECT_MOST, max1(largest3(indirect), PATH_INDIRECT_MOST));
    return direct + indirect * min1(1.0f, scale);
}

#endif
