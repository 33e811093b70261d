// SPDX-License-Identifier: Apache-2.0
// Which hits count: the filters that accel/ asks.
#include "render/render.h"
#include "render/surface.h"
#include "shared/random.h"

// A number in [0, 1) for a ray and a triangle: the same whenever a traversal comes upon it, whatever the order.
static float chance(const clast_ray *ray, const clast_hit *hit)
{
    uint32_t bits = hash3(hit->instance, hit->cluster, hit->triangle);
    for (int i = 0; i < 3; i++) {
        bits = hash2(bits, floatBitsToUint(unsigned_zero(ray->direction[i])));
        bits = hash2(bits, floatBitsToUint(unsigned_zero(ray->origin[i])));
    }
    return unit_float(bits);
}

bool clast_alpha_accepts(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    (void)ray;
    const clast_material *material;
    float alpha = clast_hit_alpha(frame, hit, &material);
    switch (material->alpha_mode) {
    case CLAST_ALPHA_MASK: return alpha >= material->alpha_cutoff;
    case CLAST_ALPHA_BLEND: return alpha >= 0.5f;
    default: return true;
    }
}

bool clast_alpha_accepts_by_chance(void *frame, const clast_ray *ray, const clast_hit *hit)
{
    const clast_material *material;
    float alpha = clast_hit_alpha(frame, hit, &material);
    switch (material->alpha_mode) {
    case CLAST_ALPHA_MASK: return alpha >= material->alpha_cutoff;
    case CLAST_ALPHA_BLEND: return chance(ray, hit) < alpha;
    default: return true;
    }
}
