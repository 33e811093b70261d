// SPDX-License-Identifier: Apache-2.0
// Which hits count: the filters that accel/ asks.
#include "render/render.h"
#include "render/surface.h"
#include "shared/random.h"

// A number in [0, 1) for a ray and a primitive: the same whenever a traversal comes upon it, in whatever order, and however
// the mesh was cut into clusters.
static float chance(const clast_ray *ray, uint32_t instance, uint32_t primitive)
{
    uint32_t bits = hash2(instance, primitive);
    for (int i = 0; i < 3; i++) {
        bits = hash2(bits, floatBitsToUint(unsigned_zero(ray->direction[i])));
        bits = hash2(bits, floatBitsToUint(unsigned_zero(ray->origin[i])));
    }
    return unit_float(bits);
}

bool clast_alpha_accepts(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    (void)ray;
    clast_hit_surface surface = clast_surface_of_hit(frame, hit);
    switch (surface.material->alpha_mode) {
    case CLAST_ALPHA_MASK: return surface.alpha >= surface.material->alpha_cutoff;
    case CLAST_ALPHA_BLEND: return surface.alpha >= 0.5f;
    default: return true;
    }
}

bool clast_alpha_accepts_by_chance(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    clast_hit_surface surface = clast_surface_of_hit(frame, hit);
    switch (surface.material->alpha_mode) {
    case CLAST_ALPHA_MASK: return surface.alpha >= surface.material->alpha_cutoff;
    case CLAST_ALPHA_BLEND: return chance(ray, hit->instance, surface.primitive) < surface.alpha;
    default: return true;
    }
}
