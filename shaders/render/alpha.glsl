// SPDX-License-Identifier: Apache-2.0
// Which hits count: the twin of src/render/alpha.c.
#ifndef CLAST_RENDER_ALPHA_GLSL
#define CLAST_RENDER_ALPHA_GLSL

#include "render/surface.glsl"

// A candidate hit as alpha sees it.
struct hit_surface
{
    material_reference material;
    float alpha;
    uint primitive; // the source's own, whatever clusters it was cut into
};

// `instance` is the scene's, as hits tell it.
hit_surface surface_of_candidate(frame_reference frame, materials_reference all, uint instance, uint cluster,
                                 uint triangle, vec2 barycentrics)
{
    source_hit hit = locate_hit(frame, frame_instance_of(frame, instance), cluster, triangle, barycentrics);
    source_surface surface = source_evaluate(hit.unit, hit.point);
    hit_surface found;
    found.material = material_at(all, surface.material);
    precise float alpha = load4(found.material.of.record.base_colour)[3] * surface.colour[3] *
                          texture_alpha(all, found.material, SLOT_BASE_COLOUR, surface.coordinates);
    found.alpha = alpha;
    found.primitive = hit.point.primitive;
    return found;
}

// Whether its alpha lets it count. Blended surfaces count from an alpha of a half on.
bool candidate_accepts(hit_surface found)
{
    return alpha_accepts(found.material.of.record.alpha_mode, found.alpha, found.material.of.record.alpha_cutoff);
}

// The same, but blended surfaces count with a chance of their alpha: a hash of the ray, which is in world space, and the
// triangle decides.
bool candidate_accepts_by_chance(hit_surface found, vec3 origin, vec3 direction, uint instance)
{
    return alpha_accepts_by_chance(found.material.of.record.alpha_mode, found.alpha,
                                   found.material.of.record.alpha_cutoff,
                                   alpha_chance(origin, direction, instance, found.primitive));
}

// Whether an eye that looks along a direction looks through what it hit, as the back of a single-sided surface (glTF 2.0,
// material.doubleSided). The ray goes on from beyond_hit() then, BACKS_MOST times at most.
bool candidate_is_hidden_back(hit_surface found, vec3 normal, vec3 direction)
{
    return sees_back(normal, direction) && found.material.of.record.double_sided == 0u;
}

// These, of hits.
bool hit_accepts_by_chance(frame_reference frame, materials_reference all, vec3 origin, vec3 direction, uint instance,
                           uint cluster, uint triangle, vec2 barycentrics)
{
    hit_surface found = surface_of_candidate(frame, all, instance, cluster, triangle, barycentrics);
    return candidate_accepts_by_chance(found, origin, direction, instance);
}

bool is_hidden_back(frame_reference frame, materials_reference all, clast_visibility seen, vec3 direction)
{
    if (seen.instance == CLAST_NONE || !sees_back(load3(seen.normal), direction)) {
        return false;
    }
    hit_surface found = surface_of_candidate(frame, all, seen.instance, seen.cluster, seen.triangle,
                                             load2(seen.barycentrics));
    return candidate_is_hidden_back(found, load3(seen.normal), direction);
}

#endif
