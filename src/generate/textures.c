// SPDX-License-Identifier: Apache-2.0
#include "generate/textures.h"

#include "base/thread.h"
#include "generate/noise.h"
#include "generate/picture.h"

const clast_texture_files clast_texture_names[CLAST_TEXTURE_KINDS] = {
    [CLAST_TEXTURE_SAND] = {"sand_colour.png", "sand_normal.png", "sand_roughness.png"},
    [CLAST_TEXTURE_ROCK] = {"rock_colour.png", "rock_normal.png", "rock_roughness.png"},
    [CLAST_TEXTURE_STONE] = {"stone_colour.png", "stone_normal.png", "stone_roughness.png"},
    [CLAST_TEXTURE_GOLD] = {"gold_colour.png", "gold_normal.png", "gold_roughness.png"},
    [CLAST_TEXTURE_LAPIS] = {"lapis_colour.png", NULL, "lapis_roughness.png"},
    [CLAST_TEXTURE_MARBLE] = {"marble_colour.png", NULL, "marble_roughness.png"},
};

typedef struct texel {
    vec3 colour;  // linear
    float height; // in sides of the picture
    float roughness;
    float metal;
} texel;

// Each takes a place in [0, 1)^2 of the tile.

static texel sand(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 3.0f, 3, 3, seed), clast_fractal2_tiled(p * 3.0f, 3, 3, seed + 10));
    float phase = 17.0f * p[1] + 3.0f * p[0] + 2.1f * warp[0] + 0.55f * clast_noise2_tiled(p * 9.0f, 9, seed + 20);
    float t = fraction(phase);
    // Gentle on the windward side, steep on the lee.
    float wave = t < 0.68f ? smooth_step(0.0f, 0.68f, t) : smooth_step(1.0f, 0.68f, t);
    float strength = 0.35f +
                     0.65f * smooth_step(-0.35f, 0.30f, warp[1] + 0.5f * clast_noise2_tiled(p * 6.0f, 6, seed + 21));
    float grain = clast_fractal2_tiled(p * 96.0f, 96, 2, seed + 22);
    clast_cells pebbles = clast_cells2_tiled(p * 64.0f + warp * 2.0f, 64, seed + 23);
    float pebble_size = 0.12f + 0.2f * unit_float(hash1(pebbles.id));
    float pebble = unit_float(pebbles.id) < 0.03f ? root(1.0f - square((pebbles.nearest + 0.1f * grain) / pebble_size))
                                                  : 0.0f;
    float tone = 0.86f + 0.07f * strength * (wave - 0.5f) + 0.16f * grain + 0.10f * warp[1];
    vec3 colour = vec3(1.0f, 0.985f, 0.96f) * tone;
    colour = mix3(colour, vec3(0.66f, 0.60f, 0.56f), 0.7f * smooth_step(0.0f, 0.5f, pebble));
    return (texel){colour, 0.0021f * strength * wave + 0.0007f * grain + 0.0009f * pebble,
                   0.88f - 0.10f * grain - 0.2f * (pebble > 0.0f ? 1.0f : 0.0f), 0.0f};
}

static texel rock(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 4.0f, 4, 4, seed), clast_fractal2_tiled(p * 4.0f, 4, 4, seed + 10));
    vec2 q = p + warp * 0.05f;
    clast_cells blocks = clast_cells2_tiled(vec2(q[0] * 9.0f, q[1] * 9.0f), 9, seed + 20);
    clast_cells chips = clast_cells2_tiled(q * 31.0f, 31, seed + 21);
    // Cracks follow the creases of a noise, and only in places: cells' borders would look like a net.
    float crease = abs1(clast_fractal2_tiled(q * 3.0f + splat2(0.4f), 3, 6, seed + 24));
    float crack = smooth_step(0.018f, 0.0f, crease) * smooth_step(-0.05f, 0.25f, warp[1]);
    float beds = clast_fractal2_banded(vec2(q[0] * 2.0f, q[1] * 24.0f), 2, 24, 3, seed + 22);
    float fine = clast_fractal2_tiled(p * 24.0f, 24, 5, seed + 23);
    float facet = unit_float(blocks.id) - 0.5f, chip = unit_float(chips.id) - 0.5f;
    float height = 0.0035f * facet + 0.0022f * chip + 0.006f * fine + 0.004f * beds - 0.006f * crack + 0.01f * warp[0];
    float tone = 0.82f + 0.06f * facet + 0.08f * chip + 0.30f * fine + 0.18f * beds - 0.30f * crack;
    vec3 colour = vec3(1.0f, 0.97f, 0.94f) * tone * (1.0f + 0.16f * warp[1]);
    return (texel){colour, height, clamp1(0.80f + 0.3f * fine - 0.1f * facet, 0.5f, 1.0f), 0.0f};
}

static texel stone(vec2 p, uint seed)
{
    float cloud = clast_fractal2_tiled(p * 3.0f, 3, 4, seed);
    float fine = clast_fractal2_tiled(p * 48.0f, 48, 3, seed + 10);
    clast_cells pits = clast_cells2_tiled(p * 38.0f, 38, seed + 20);
    float pit = unit_float(pits.id) < 0.22f + 0.3f * cloud ? smooth_step(0.34f, 0.12f, pits.nearest) : 0.0f;
    // Chisel strokes, in patches that run two ways.
    clast_cells patches = clast_cells2_tiled(p * 5.0f + splat2(0.2f * cloud), 5, seed + 21);
    float way = unit_float(patches.id) < 0.5f ? 1.0f : -1.0f;
    float stroke = abs1(
        wave_sine(34.0f * p[0] + 34.0f * way * p[1] + 1.6f * clast_noise2_tiled(p * 12.0f, 12, seed + 22)));
    float crack = smooth_step(0.02f, 0.0f, abs1(clast_fractal2_tiled(p * 2.0f, 2, 5, seed + 23))) *
                  smooth_step(0.0f, 0.3f, cloud);
    float height = 0.0006f * stroke - 0.0034f * pit + 0.0016f * fine - 0.003f * crack;
    float tone = 0.86f + 0.14f * cloud + 0.17f * fine - 0.24f * pit + 0.03f * stroke - 0.25f * crack;
    return (texel){vec3(1.0f, 0.985f, 0.96f) * tone, height,
                   clamp1(0.70f + 0.25f * fine - 0.12f * cloud + 0.15f * pit, 0.35f, 1.0f), 0.0f};
}

static texel gold(vec2 p, uint seed)
{
    float cloud = clast_fractal2_tiled(p * 4.0f, 4, 5, seed);
    clast_cells hammer = clast_cells2_tiled(p * 34.0f, 34, seed + 10);
    float dent = square(min1(hammer.nearest, 0.8f));
    float scratch = clast_fractal2_banded(vec2(p[0] * 8.0f, p[1] * 128.0f), 8, 128, 2, seed + 20);
    float tarnish = smooth_step(0.10f, 0.42f, cloud + 0.12f * scratch);
    vec3 colour = mix3(vec3(0.95f, 0.64f, 0.26f), vec3(0.40f, 0.23f, 0.11f), 0.75f * tarnish);
    return (texel){colour, 0.0008f * dent + 0.0002f * scratch,
                   clamp1(0.23f + 0.24f * tarnish + 0.10f * scratch + 0.06f * cloud, 0.12f, 0.8f), 1.0f};
}

static texel lapis(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 3.0f, 3, 4, seed), clast_fractal2_tiled(p * 3.0f, 3, 4, seed + 10));
    float cloud = clast_fractal2_tiled(p * 5.0f + warp * 0.8f, 5, 5, seed + 20);
    float vein = smooth_step(0.045f, 0.0f, abs1(clast_fractal2_tiled(p * 4.0f + warp * 1.1f, 4, 4, seed + 21)));
    clast_cells flecks = clast_cells2_tiled(p * 70.0f, 70, seed + 22);
    bool fleck = unit_float(flecks.id) < 0.035f + 0.30f * vein && flecks.nearest < 0.34f;
    vec3 colour = mix3(vec3(0.012f, 0.035f, 0.20f), vec3(0.035f, 0.11f, 0.42f), smooth_step(-0.3f, 0.4f, cloud));
    colour = mix3(colour, vec3(0.30f, 0.36f, 0.52f), 0.35f * vein * smooth_step(0.0f, 0.3f, cloud));
    if (fleck) {
        return (texel){vec3(0.88f, 0.66f, 0.28f), 0.0f, 0.28f, 1.0f};
    }
    return (texel){colour, 0.0f, clamp1(0.10f + 0.10f * vein + 0.05f * cloud, 0.05f, 1.0f), 0.0f};
}

static texel marble(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 2.0f, 2, 4, seed), clast_fractal2_tiled(p * 2.0f, 2, 4, seed + 10));
    float vein = smooth_step(0.03f, 0.0f, abs1(clast_fractal2_tiled(p * 3.0f + warp * 1.4f, 3, 4, seed + 20)));
    float cloud = clast_fractal2_tiled(p * 6.0f + warp, 6, 4, seed + 21);
    float dust = smooth_step(-0.12f, 0.40f, clast_fractal2_tiled(p * 5.0f, 5, 5, seed + 22));
    float tone = 0.34f + 0.12f * cloud + 0.5f * vein + 0.28f * dust;
    return (texel){vec3(1.0f, 0.97f, 0.92f) * tone, 0.0f, clamp1(0.10f + 0.32f * dust + 0.04f * cloud, 0.05f, 1.0f),
                   0.0f};
}

static texel (*const recipes[CLAST_TEXTURE_KINDS])(vec2 p, uint seed) = {sand, rock, stone, gold, lapis, marble};

// ---------------------------------------------------------------------------------------------------------- writing

typedef struct painting {
    clast_texture_kind kind;
    uint32_t size, seed;
    float *heights;
    uint8_t *colours, *roughness, *normals;
    const uint8_t *gamma; // clast_make_gamma's
} painting;

static uint8_t to_byte(float x)
{
    return (uint8_t)(clamp1(x, 0.0f, 1.0f) * 255.0f + 0.5f);
}

static void paint_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    painting *w = data;
    for (size_t y = begin; y < end; y++) {
        for (uint32_t x = 0; x < w->size; x++) {
            vec2 place = vec2(((float)x + 0.5f) / (float)w->size, ((float)y + 0.5f) / (float)w->size);
            texel t = recipes[w->kind](place, w->seed);
            size_t at = y * w->size + x;
            w->heights[at] = t.height;
            for (int c = 0; c < 3; c++) {
                w->colours[3 * at + (size_t)c] = clast_gamma_byte(w->gamma, t.colour[c]);
            }
            w->roughness[3 * at] = 255; // no occlusion
            w->roughness[3 * at + 1] = to_byte(t.roughness);
            w->roughness[3 * at + 2] = to_byte(t.metal);
        }
    }
}

// Green is up, and rows go down: the slope of y is turned round.
static void slope_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    painting *w = data;
    uint32_t size = w->size;
    for (size_t y = begin; y < end; y++) {
        const float *row = w->heights + y * size, *above = w->heights + (y + size - 1) % size * size;
        const float *below = w->heights + (y + 1) % size * size;
        for (uint32_t x = 0; x < size; x++) {
            float scale = 0.5f * (float)size;
            float dx = (row[(x + 1) % size] - row[(x + size - 1) % size]) * scale, dy = (below[x] - above[x]) * scale;
            vec3 normal = normalize3(vec3(-dx, dy, 1.0f));
            for (int c = 0; c < 3; c++) {
                w->normals[3 * (y * size + x) + (size_t)c] = to_byte(0.5f + 0.5f * normal[c]);
            }
        }
    }
}

static void write_all(clast_outputs *outputs, painting *w)
{
    const clast_texture_files *names = &clast_texture_names[w->kind];
    clast_parallel_for(outputs->context, w->size, 4, paint_rows, w);
    clast_picture_write(outputs, names->colour, w->size, w->size, w->colours);
    clast_picture_write(outputs, names->roughness, w->size, w->size, w->roughness);
    if (names->normal != NULL) {
        clast_parallel_for(outputs->context, w->size, 16, slope_rows, w);
        clast_picture_write(outputs, names->normal, w->size, w->size, w->normals);
    }
}

void clast_write_textures(clast_outputs *outputs, clast_texture_kind kind, uint32_t size, uint32_t seed)
{
    clast_context *context = outputs->context;
    size_t count = (size_t)size * size;
    uint8_t gamma[CLAST_GAMMA_STEPS];
    clast_make_gamma(gamma);
    painting w = {.kind = kind, .size = size, .seed = hash2(seed, 700 + (uint)kind), .gamma = gamma};
    w.heights = clast_allocate(context, count, sizeof *w.heights);
    w.colours = clast_allocate(context, count, 3);
    w.roughness = clast_allocate(context, count, 3);
    w.normals = clast_allocate(context, count, 3);
    if (w.heights == NULL || w.colours == NULL || w.roughness == NULL || w.normals == NULL) {
        clast_outputs_note(outputs, CLAST_ERROR_OUT_OF_MEMORY);
    } else if (outputs->status == CLAST_OK) {
        write_all(outputs, &w);
    }
    clast_free(context, w.heights);
    clast_free(context, w.colours);
    clast_free(context, w.roughness);
    clast_free(context, w.normals);
}
