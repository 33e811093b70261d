// SPDX-License-Identifier: Apache-2.0
// Which hits count: the filters that accel/ asks.
#include "render/render.h"
#include "render/surface.h"

bool clast_alpha_accepts(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    (void)ray;
    clast_hit_surface surface = clast_surface_of_hit(frame, hit);
    return alpha_accepts(surface.material->alpha_mode, surface.alpha, surface.material->alpha_cutoff);
}

bool clast_alpha_accepts_by_chance(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    clast_hit_surface surface = clast_surface_of_hit(frame, hit);
    const float *o = ray->origin, *d = ray->direction;
    float chance = alpha_chance(vec3(o[0], o[1], o[2]), vec3(d[0], d[1], d[2]), hit->instance, surface.primitive);
    return alpha_accepts_by_chance(surface.material->alpha_mode, surface.alpha, surface.material->alpha_cutoff, chance);
}
