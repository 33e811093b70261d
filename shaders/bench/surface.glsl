// SPDX-License-Identifier: Apache-2.0
// Surfaces over the unit square that benchmarks trace: a terrain, and a sphere seen from within. Both are displaced by six
// octaves of a product of two sines each.
#ifndef CLAST_BENCH_SURFACE_GLSL
#define CLAST_BENCH_SURFACE_GLSL

const uint SURFACE_TERRAIN = 0u;
const uint SURFACE_SPHERE = 1u;

// Fused, as graphics programs are (all other arithmetic of clast's kernels is not).
float bench_dot(vec3 a, vec3 b, float c) { return fma(a.x, b.x, fma(a.y, b.y, fma(a.z, b.z, c))); }

float bench_height(vec3 p, float time)
{
    float height = 0.0, amplitude = 0.22;
    p *= 3.1;
    [[unroll]] for (uint octave = 0u; octave < 6u; octave++) {
        float first = bench_dot(p, vec3(0.83, 0.41, -0.37), time + 1.7 * float(octave));
        float second = bench_dot(p, vec3(-0.29, 0.78, 0.92), 2.9 * float(octave) - 0.7 * time);
        height = fma(amplitude * sin(first), sin(second), height);
        p = vec3(bench_dot(p, vec3(1.61, 0.72, -0.93), 0.3), bench_dot(p, vec3(-0.93, 1.61, 0.72), 0.7),
                 bench_dot(p, vec3(0.72, -0.93, 1.61), 0.1));
        amplitude *= 0.48;
    }
    return height;
}

// The square as an octahedron that is unfolded (Meyer and others, On Floating-Point Normal Vectors, 2010).
vec3 bench_direction(vec2 place)
{
    vec2 q = place * 2.0 - 1.0;
    vec3 n = vec3(q, 1.0 - abs(q.x) - abs(q.y));
    if (n.z < 0.0) {
        vec2 side = vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
        n.xy = (1.0 - abs(n.yx)) * side;
    }
    return normalize(n);
}

vec3 bench_surface(uint surface, vec2 place, float time)
{
    if (surface == SURFACE_TERRAIN) {
        vec3 p = vec3(place.x * 4.0 - 2.0, 0.0, place.y * 4.0 - 2.0);
        return p + vec3(0.0, bench_height(p, time), 0.0);
    }
    vec3 n = bench_direction(place);
    return n * (1.0 + bench_height(n * 1.2, time));
}

// The cell of a number: Morton order in a rectangle whose sides are powers of two.
uint every_second_bit(uint x)
{
    x &= 0x55555555u;
    x = (x | x >> 1u) & 0x33333333u;
    x = (x | x >> 2u) & 0x0f0f0f0fu;
    x = (x | x >> 4u) & 0x00ff00ffu;
    return (x | x >> 8u) & 0xffffu;
}

uvec2 bench_cell(uint number, uvec2 logarithms)
{
    uint both = min(logarithms.x, logarithms.y);
    uint low = number & ((1u << 2u * both) - 1u), high = number >> 2u * both;
    uvec2 cell = uvec2(every_second_bit(low), every_second_bit(low >> 1u));
    cell[logarithms.x > logarithms.y ? 0 : 1] |= high << both;
    return cell;
}

#endif
