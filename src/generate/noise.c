// SPDX-License-Identifier: Apache-2.0
#include "generate/noise.h"

static uint hash_cell(int x, int y, int z, uint seed)
{
    // Primes spread the axes; hash1 mixes.
    return hash1((uint)x * 0x8da6b343u ^ (uint)y * 0xd8163841u ^ (uint)z * 0xcb1ab31fu ^ seed * 0x9e3779b9u);
}

static float fade(float t)
{
    return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

// The dot product with one of 12 edge directions of a cube (16 entries, 4 of them twice).
static float gradient3(uint hash, float x, float y, float z)
{
    uint h = hash >> 28;
    float u = h < 8 ? x : y;
    float v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return ((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v);
}

// Eight directions, a eighth of a turn apart, none along an axis: axes show as streaks on near planes.
static float gradient2(uint hash, float x, float y)
{
    static const float c = 0.92387953f, s = 0.38268343f;
    uint h = hash >> 29;
    float a = (h & 1) != 0 ? c : s, b = (h & 1) != 0 ? s : c;
    return ((h & 2) != 0 ? -a : a) * x + ((h & 4) != 0 ? -b : b) * y;
}

float clast_noise3(vec3 p, uint seed)
{
    float fx = floor1(p[0]), fy = floor1(p[1]), fz = floor1(p[2]);
    int ix = (int)fx, iy = (int)fy, iz = (int)fz;
    float x = p[0] - fx, y = p[1] - fy, z = p[2] - fz;
    float u = fade(x), v = fade(y), w = fade(z);
    float sums[2];
    for (int k = 0; k < 2; k++) {
        float zk = z - (float)k;
        float a = mix1(gradient3(hash_cell(ix, iy, iz + k, seed), x, y, zk),
                       gradient3(hash_cell(ix + 1, iy, iz + k, seed), x - 1.0f, y, zk), u);
        float b = mix1(gradient3(hash_cell(ix, iy + 1, iz + k, seed), x, y - 1.0f, zk),
                       gradient3(hash_cell(ix + 1, iy + 1, iz + k, seed), x - 1.0f, y - 1.0f, zk), u);
        sums[k] = mix1(a, b, v);
    }
    return mix1(sums[0], sums[1], w);
}

// A period of 0 is none.
static int wrap_cell(int i, uint period)
{
    if (period == 0) {
        return i;
    }
    int rest = i % (int)period;
    return rest < 0 ? rest + (int)period : rest;
}

static float noise2(vec2 p, uint period_x, uint period_y, uint seed)
{
    float fx = floor1(p[0]), fy = floor1(p[1]);
    int x0 = wrap_cell((int)fx, period_x), x1 = wrap_cell((int)fx + 1, period_x);
    int y0 = wrap_cell((int)fy, period_y), y1 = wrap_cell((int)fy + 1, period_y);
    float x = p[0] - fx, y = p[1] - fy;
    float u = fade(x), v = fade(y);
    float a = mix1(gradient2(hash_cell(x0, y0, 0, seed), x, y), gradient2(hash_cell(x1, y0, 0, seed), x - 1.0f, y), u);
    float b = mix1(gradient2(hash_cell(x0, y1, 0, seed), x, y - 1.0f),
                   gradient2(hash_cell(x1, y1, 0, seed), x - 1.0f, y - 1.0f), u);
    return 1.4f * mix1(a, b, v);
}

float clast_noise2_tiled(vec2 p, uint period, uint seed)
{
    return noise2(p, period, period, seed);
}

float clast_noise2(vec2 p, uint seed)
{
    return noise2(p, 0, 0, seed);
}

float clast_fractal2_banded(vec2 p, uint period_x, uint period_y, uint octaves, uint seed)
{
    float sum = 0.0f, strength = 0.5f;
    for (uint i = 0; i < octaves; i++) {
        sum += strength * noise2(p, period_x, period_y, seed + i);
        p = p * 2.0f; // a whole number: what tiles keeps tiling
        period_x *= 2;
        period_y *= 2;
        strength *= 0.5f;
    }
    return sum;
}

float clast_fractal2_tiled(vec2 p, uint period, uint octaves, uint seed)
{
    return clast_fractal2_banded(p, period, period, octaves, seed);
}

float clast_fractal2(vec2 p, uint octaves, uint seed)
{
    float sum = 0.0f, strength = 0.5f;
    for (uint i = 0; i < octaves; i++) {
        sum += strength * clast_noise2(p, seed + i);
        // Turned as well as scaled: the octaves' lattices must not coincide.
        p = vec2(1.616f * p[0] - 1.178f * p[1] + 0.37f, 1.178f * p[0] + 1.616f * p[1] + 0.71f);
        strength *= 0.5f;
    }
    return sum;
}

// Turned about the diagonal and doubled.
static vec3 next_octave(vec3 p)
{
    return vec3(0.0f * p[0] + 1.6f * p[1] + 1.2f * p[2] + 0.31f, -1.6f * p[0] + 0.72f * p[1] - 0.96f * p[2] + 0.53f,
                -1.2f * p[0] - 0.96f * p[1] + 1.28f * p[2] + 0.17f);
}

float clast_fractal3(vec3 p, uint octaves, uint seed)
{
    float sum = 0.0f, strength = 0.5f;
    for (uint i = 0; i < octaves; i++) {
        sum += strength * clast_noise3(p, seed + i);
        p = next_octave(p);
        strength *= 0.5f;
    }
    return sum;
}

// One octave more of a ridged sum. `weight` carries how strong the octave before was: valleys stay smooth.
typedef struct ridge {
    float sum, strength, weight;
} ridge;

static ridge add_ridge(ridge r, float noise)
{
    float value = square(1.0f - min1(abs1(noise), 1.0f)) * r.weight;
    return (ridge){r.sum + value * r.strength, r.strength * 0.5f, clamp1(value * 2.0f, 0.0f, 1.0f)};
}

float clast_ridged2(vec2 p, uint octaves, uint seed)
{
    ridge r = {0.0f, 0.5f, 1.0f};
    for (uint i = 0; i < octaves; i++) {
        r = add_ridge(r, clast_noise2(p, seed + i));
        p = vec2(1.616f * p[0] - 1.178f * p[1] + 0.37f, 1.178f * p[0] + 1.616f * p[1] + 0.71f);
    }
    return r.sum;
}

float clast_ridged3(vec3 p, uint octaves, uint seed)
{
    ridge r = {0.0f, 0.5f, 1.0f};
    for (uint i = 0; i < octaves; i++) {
        r = add_ridge(r, clast_noise3(p, seed + i));
        p = next_octave(p);
    }
    return r.sum;
}

static clast_cells add_point(clast_cells cells, float distance2, uint id)
{
    if (distance2 < cells.nearest) {
        return (clast_cells){distance2, cells.nearest, id};
    }
    cells.second = min1(cells.second, distance2);
    return cells;
}

static clast_cells finish_cells(clast_cells cells)
{
    return (clast_cells){sqrtf(cells.nearest), sqrtf(cells.second), cells.id};
}

clast_cells clast_cells2_tiled(vec2 p, uint period, uint seed)
{
    int cx = (int)floor1(p[0]), cy = (int)floor1(p[1]);
    clast_cells cells = {1e9f, 1e9f, 0};
    for (int y = cy - 1; y <= cy + 1; y++) {
        for (int x = cx - 1; x <= cx + 1; x++) {
            uint id = hash_cell(wrap_cell(x, period), wrap_cell(y, period), 1, seed);
            float dx = (float)x + unit_float(id) - p[0];
            float dy = (float)y + unit_float(hash1(id)) - p[1];
            cells = add_point(cells, dx * dx + dy * dy, id);
        }
    }
    return finish_cells(cells);
}

clast_cells clast_cells2(vec2 p, uint seed)
{
    return clast_cells2_tiled(p, 0, seed);
}

clast_cells clast_cells3(vec3 p, uint seed)
{
    int cx = (int)floor1(p[0]), cy = (int)floor1(p[1]), cz = (int)floor1(p[2]);
    clast_cells cells = {1e9f, 1e9f, 0};
    for (int z = cz - 1; z <= cz + 1; z++) {
        for (int y = cy - 1; y <= cy + 1; y++) {
            for (int x = cx - 1; x <= cx + 1; x++) {
                uint id = hash_cell(x, y, z, seed);
                float dx = (float)x + unit_float(id) - p[0];
                float dy = (float)y + unit_float(hash1(id)) - p[1];
                float dz = (float)z + unit_float(hash1(id + 1)) - p[2];
                cells = add_point(cells, dx * dx + dy * dy + dz * dz, id);
            }
        }
    }
    return finish_cells(cells);
}
