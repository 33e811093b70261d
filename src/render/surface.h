// SPDX-License-Identifier: Apache-2.0
// From a hit to what is there: position, normals, material.
#ifndef CLAST_RENDER_SURFACE_H
#define CLAST_RENDER_SURFACE_H

#include "frame/frame.h"
#include "render/texture.h"
#include "shared/surface.h"

// A hit, ready to be shaded.
typedef struct clast_shading_point {
    vec3 position;         // on the triangle that the ray hit, world space
    vec3 geometric_normal; // unit length, on the viewer's side
    vec3 normal;           // to shade with: unit length, normal map applied, repaired; on the viewer's side
    float offset;      // how far along the geometric normal a ray must begin, so that it cannot hit this surface again
    clast_basis frame; // around the normal; along the highlights where they have a direction
    clast_bsdf_input surface;
    vec3 absorption; // of the volume behind; zero where there is none
    bool unlit;
    vec3 emission;
    vec2 coordinates;
    clast_ray_cone cone; // of the sample, here
    float bend;          // the surface's curvature times the cone's width
    uint32_t material;
    uint32_t frame_instance;
    uint32_t primitive;
} clast_shading_point;

// What a ray found, for the visibility buffer.
clast_visibility clast_visibility_of_hit(const clast_hit *hit);

// A hit on its way to be shaded. `point` lacks what the material says, and its geometric normal is the front's.
typedef struct clast_found_surface {
    clast_shading_point point;
    clast_source_surface surface;
    clast_texture_area area;
    const clast_material *material;
} clast_found_surface;

// The ray that found it, as far as that matters to what is seen there.
typedef struct clast_finding_ray {
    vec3 direction;      // unit length
    clast_ray_cone cone; // where the ray began
    uint32_t look;       // LOOK_: how closely at textures
} clast_finding_ray;

// In two steps, so that many surfaces can wait for memory together: the first asks for the texels that the second reads.
clast_found_surface clast_find_surface(const clast_frame *frame, const clast_visibility *seen,
                                       const clast_finding_ray *ray);
// Completes `found->point`. `view` is the unit vector towards where the ray came from.
void clast_shade_surface(const clast_frame *frame, const clast_srgb_table *table, vec3 view,
                         clast_found_surface *found);

// The light that a material sends out at a place of its textures.
vec3 clast_emission(const clast_scene *scene, const clast_material *material, const clast_texture_area *area,
                    const clast_srgb_table *table);

// position_error() of an instance of the frame.
static inline vec3 clast_position_error(const clast_frame_instance *instance, vec3 largest, float size, vec3 position)
{
    return position_error(instance->to_world, instance->to_object, largest, size, position);
}

// A candidate hit as alpha sees it.
typedef struct clast_hit_surface {
    const clast_material *material;
    float alpha;
    uint32_t primitive; // the source's own, whatever clusters it was cut into
} clast_hit_surface;
clast_hit_surface clast_surface_of_hit(const clast_frame *frame, const clast_hit *hit);

#endif
