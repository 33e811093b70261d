// SPDX-License-Identifier: Apache-2.0
// Rays of a picture, 8x4 pixels after each other; or one from each hit of these, spread by the cosine.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/ray.glsl"

layout(constant_id = 0) const uint DIFFUSE = 0u;
layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform clast_bench_rays_push {
    uint64_t to;
    uint64_t from, seen; // the rays before, and their hits
    uint64_t count;      // gets how many rays there are
    packed3 eye, right, up, forward;
    uint width, height;
}
push;

uint hash(uint x)
{
    x = (x ^ x >> 16u) * 0x7feb352du;
    x = (x ^ x >> 15u) * 0x846ca68bu;
    return x ^ x >> 16u;
}

clast_ray primary(uint i)
{
    uint tile = i / 32u, inside = i % 32u, across = push.width / 8u;
    vec2 pixel = vec2(tile % across * 8u + inside % 8u, tile / across * 4u + inside / 8u) + 0.5;
    vec2 place = (pixel / vec2(push.width, push.height) * 2.0 - 1.0) * vec2(1.0, -1.0);
    clast_ray ray;
    ray.origin = push.eye;
    ray.direction = normalize(push.forward + place.x * push.right + place.y * push.up);
    ray.t_min = 0.0;
    ray.t_max = 1e4;
    return ray;
}

clast_ray diffuse(uint i)
{
    clast_ray ray = rays(push.from).at[i];
    clast_hit hit = hits(push.seen).at[i];
    if (hit.instance == CLAST_NONE || ray.t_max < 0.0) {
        ray.t_max = -1.0; // none
        return ray;
    }
    vec3 n = normalize(hit.normal);
    n = dot(n, ray.direction) > 0.0 ? -n : n;
    uint bits = hash(2u * i + 1u);
    float u = float(hash(bits) >> 8u) / 16777216.0, v = float(hash(bits ^ 0x9e3779b9u) >> 8u) / 16777216.0;
    vec3 x = normalize(cross(n, abs(n.x) > 0.5 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0))), y = cross(n, x);
    ray.origin = ray.origin + ray.direction * hit.t + n * 2e-4;
    ray.direction = normalize(sqrt(u) * (cos(6.2831853 * v) * x + sin(6.2831853 * v) * y) + sqrt(max(1.0 - u, 0.0)) * n);
    ray.t_min = 1e-5;
    ray.t_max = 1e4;
    return ray;
}

void main()
{
    uint i = linear_group() * 64u + gl_LocalInvocationIndex;
    if (i >= push.width * push.height) {
        return;
    }
    clast_ray ray = DIFFUSE != 0u ? diffuse(i) : primary(i);
    rays(push.to).at[i] = ray;
    if (ray.t_max > 0.0) {
        atomicAdd(uints(push.count).at[0], 1u);
    }
}
