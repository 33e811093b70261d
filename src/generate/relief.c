// SPDX-License-Identifier: Apache-2.0
#include "generate/relief.h"

#include "base/thread.h"
#include "generate/ornament.h"
#include "generate/picture.h"

const clast_relief_files clast_relief_names[CLAST_RELIEF_KINDS] = {
    [CLAST_RELIEF_COBBLES] = {"cobbles_height.png", "cobbles_colour.png", 1, 0.062f, 0.85f},
    [CLAST_RELIEF_PANEL] = {"panel_height.png", "panel_colour.png", 1, 0.055f, 1.0f},
    [CLAST_RELIEF_GLOBE] = {"globe_height.png", "globe_colour.png", 2, 0.050f, 0.5f},
    [CLAST_RELIEF_ROPE] = {"rope_height.png", "rope_colour.png", 4, 0.036f, 0.4f},
    [CLAST_RELIEF_BARK] = {"bark_height.png", "bark_colour.png", 1, 0.075f, 0.5f},
    [CLAST_RELIEF_RINGS] = {"rings_height.png", "rings_colour.png", 1, 0.020f, 0.8f},
    [CLAST_RELIEF_ASHLAR] = {"ashlar_height.png", "ashlar_colour.png", 1, 0.060f, 0.5f},
    [CLAST_RELIEF_HILLS] = {"hills_height.png", "hills_colour.png", 1, 56.0f, 0.0f},
};

// A texel: linear colour, and height, about 0 to 1.
typedef struct relief {
    vec3 colour;
    float height;
} relief;

static const float GROUND_SIDE = 640.0f; // metres that the hills' map spans
static const vec3 STONE = {0.60f, 0.50f, 0.385f};

// Dark where it lies deep, pale on what is touched, stained in clouds.
static vec3 carved_colour(float height, float cloud, float fine)
{
    float tone = mix1(0.42f, 1.0f, smooth_step(0.0f, 0.75f, height)) * (0.94f + 0.20f * cloud + 0.20f * fine);
    vec3 colour = STONE * tone;
    return mix3(colour, vec3(0.20f, 0.195f, 0.10f), 0.45f * smooth_step(0.10f, 0.50f, cloud) * (1.0f - 0.6f * height));
}

// ---------------------------------------------------------------------------------------------------------- recipes
// Each takes a place in [0, 1)^2 of the picture, y downwards.

static relief cobbles(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 8.0f, 8, 3, seed), clast_fractal2_tiled(p * 8.0f, 8, 3, seed + 10));
    clast_cells stones = clast_cells2_tiled((p + warp * 0.012f) * 15.0f, 15, seed + 20);
    float edge = clamp1((stones.second - stones.nearest) * 1.9f - 0.10f, 0.0f, 1.0f);
    float dome = root(1.0f - square(1.0f - edge));
    float own = unit_float(stones.id), tint = unit_float(hash1(stones.id)), worn = unit_float(hash1(stones.id + 7));
    float fine = clast_fractal2_tiled(p * 40.0f, 40, 5, seed + 21);
    float grain = clast_fractal2_tiled(p * 150.0f, 150, 2, seed + 22);
    float cloud = clast_fractal2_tiled(p * 3.0f, 3, 4, seed + 23);
    float chip = smooth_step(0.22f, 0.42f, clast_fractal2_tiled(p * 24.0f, 24, 3, seed + 24));
    float stone = dome * (0.72f + 0.23f * own) + (0.05f + 0.03f * worn) * fine - 0.05f * chip;
    float sand = 0.30f + 0.07f * fine + 0.10f * cloud + 0.015f * grain;
    float above = smooth_step(-0.02f, 0.07f, stone - sand);
    vec3 colour = mix3(vec3(0.40f, 0.335f, 0.27f), vec3(0.58f, 0.475f, 0.36f), tint);
    colour = mix3(colour, vec3(0.33f, 0.335f, 0.345f), smooth_step(0.72f, 0.80f, own));
    colour = colour * (0.84f + 0.5f * fine + 0.12f * grain - 0.15f * chip);
    vec3 earth = mix3(vec3(0.33f, 0.245f, 0.155f), vec3(0.125f, 0.155f, 0.045f), smooth_step(-0.05f, 0.25f, cloud));
    colour = mix3(earth * (0.8f + 0.5f * fine + 0.5f * grain), colour, above);
    return (relief){colour, max1(stone, sand)};
}

// A running key along the sides of a square, mitred; `across` is the distance from the border over the band's width.
static float key_band(vec2 p, float border, float from, float to)
{
    float x = min1(p[0], 1.0f - p[0]), y = min1(p[1], 1.0f - p[1]);
    float along = (x < y ? p[1] : p[0]) * 16.0f;
    return clast_ornament_height(CLAST_ORNAMENT_MEANDER, along, 1.0f - 2.0f * (border - from) / (to - from), 1.0f);
}

static relief panel(vec2 p, uint seed)
{
    float border = min1(min1(p[0], 1.0f - p[0]), min1(p[1], 1.0f - p[1]));
    vec2 q = vec2(p[0] - 0.5f, p[1] - 0.5f);
    float radius = length2(q);
    float rim = smooth_step(0.052f, 0.046f, border);
    float height = 0.22f;
    if (border > 0.062f && border < 0.142f) {
        height = 0.42f + 0.40f * key_band(p, border, 0.062f, 0.142f);
    }
    float step = 0.80f * smooth_step(0.152f, 0.157f, border) * smooth_step(0.176f, 0.170f, border);
    float ring = smooth_step(0.014f, 0.010f, abs1(radius - 0.285f)) * 0.78f;
    float beads = clast_ornament_height(CLAST_ORNAMENT_BEADS, turns_of(q[1], q[0]) * 44.0f,
                                        clamp1((radius - 0.257f) / 0.013f, -1.0f, 1.0f), 0.72f);
    float flower = 0.22f + 0.78f * clast_rosette_height(q[0] / 0.236f, q[1] / 0.236f, 12.0f);
    vec2 corner = vec2(abs1(q[0]) - 0.252f, abs1(q[1]) - 0.252f);
    float bud = 0.22f + 0.62f * clast_rosette_height(corner[0] / 0.066f, corner[1] / 0.066f, 6.0f);
    height = max1(max1(max1(height, step), max1(ring, 0.22f + 0.5f * beads)),
                  max1(radius < 0.24f ? flower : 0.0f, bud));
    height = max1(height, rim);
    float cloud = clast_fractal2(p * 5.0f, 4, seed), fine = clast_fractal2(p * 60.0f, 5, seed + 20);
    clast_cells pits = clast_cells2(p * 46.0f, seed + 21);
    float pit = unit_float(pits.id) < 0.16f + 0.3f * cloud ? smooth_step(0.36f, 0.14f, pits.nearest) : 0.0f;
    float chip = smooth_step(0.10f, 0.30f, clast_fractal2(p * 7.0f, 5, seed + 22)) * 0.32f;
    float inside = smooth_step(0.0f, 0.012f, border);
    height = height * (1.0f - inside * chip * 0.8f) + inside * (0.045f * fine - 0.10f * pit);
    return (relief){carved_colour(height, cloud, fine), clamp1(height, 0.0f, 1.1f)};
}

// A carved band of a globe between two latitudes; 0 to 1 from the north pole to the south.
typedef struct globe_band {
    float from, to;
    clast_ornament ornament;
    float repeats, low, high;
} globe_band;

static float band_height(const globe_band *band, vec2 p)
{
    float middle = 0.5f * (band->from + band->to), width = band->to - band->from;
    float across = (middle - p[1]) / (0.5f * width);
    float around = max1(2.0f * wave_sine(0.5f * middle), 0.05f); // of the circle over half the meridian's length
    float inside = smooth_step(1.0f, 0.965f, abs1(across));
    float aspect = width * band->repeats / around;
    return band->low +
           inside * (band->high - band->low) *
               clast_ornament_height(band->ornament, p[0] * band->repeats, clamp1(across, -1.0f, 1.0f), aspect);
}

static relief globe(vec2 p, uint seed)
{
    static const globe_band bands[] = {
        {0.100f, 0.124f, CLAST_ORNAMENT_BEADS, 44.0f, 0.30f, 0.80f},
        {0.134f, 0.262f, CLAST_ORNAMENT_LEAVES, 22.0f, 0.18f, 0.92f},
        {0.274f, 0.300f, CLAST_ORNAMENT_ROPE, 64.0f, 0.30f, 0.86f},
        {0.312f, 0.402f, CLAST_ORNAMENT_MEANDER, 22.0f, 0.22f, 0.74f},
        {0.416f, 0.584f, CLAST_ORNAMENT_GUILLOCHE, 12.0f, 0.10f, 1.00f},
    };
    vec2 q = p[1] > 0.5f ? vec2(p[0], 1.0f - p[1]) : p;
    float height = 0.62f;
    if (q[1] < 0.092f) {
        float r = q[1] / 0.092f;
        height = 0.25f + 0.7f * clast_rosette_height(r * wave_cosine(p[0]), r * wave_sine(p[0]), 10.0f);
        height = max1(height, 0.70f * smooth_step(0.86f, 0.92f, r));
    }
    for (size_t i = 0; i < sizeof bands / sizeof bands[0]; i++) {
        if (q[1] >= bands[i].from && q[1] <= bands[i].to) {
            height = band_height(&bands[i], i < 4 ? q : p);
        }
    }
    vec3 place = vec3(wave_cosine(p[0]) * wave_sine(0.5f * p[1]), wave_cosine(0.5f * p[1]),
                      wave_sine(p[0]) * wave_sine(0.5f * p[1]));
    float cloud = clast_fractal3(place * 2.4f, 4, seed), fine = clast_fractal3(place * 34.0f, 5, seed + 20);
    float chip = smooth_step(0.16f, 0.36f, clast_fractal3(place * 3.4f, 5, seed + 22)) * 0.40f;
    clast_cells pits = clast_cells3(place * 26.0f, seed + 21);
    float pit = unit_float(pits.id) < 0.14f + 0.3f * cloud ? smooth_step(0.34f, 0.12f, pits.nearest) : 0.0f;
    height = height * (1.0f - chip) + 0.05f * fine - 0.09f * pit;
    return (relief){carved_colour(height, cloud, fine), height};
}

static relief rope(vec2 p, uint seed)
{
    float phase = p[0] * 42.0f + p[1] * 3.0f;
    float strand = root(abs1(wave_sine(0.5f * phase)));
    float ply = abs1(wave_sine(0.5f * (phase * 5.0f - p[1] * 9.0f)));
    float fine = clast_fractal2_banded(vec2(p[0] * 96.0f, p[1] * 24.0f), 96, 24, 4, seed);
    float cloud = clast_fractal2_banded(vec2(p[0] * 12.0f, p[1] * 3.0f), 12, 3, 4, seed + 20);
    float height = 0.80f * strand + 0.10f * ply * strand + 0.07f * fine;
    vec3 colour = mix3(vec3(0.10f, 0.115f, 0.10f), vec3(0.31f, 0.345f, 0.30f), smooth_step(0.1f, 0.9f, height));
    colour = mix3(colour * (0.9f + 0.6f * fine), vec3(0.30f, 0.155f, 0.06f), 0.7f * smooth_step(0.02f, 0.30f, cloud));
    return (relief){colour, height};
}

static relief bark(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 5.0f, 5, 4, seed), clast_fractal2_tiled(p * 5.0f, 5, 4, seed + 10));
    vec2 q = p + vec2(warp[0] * 0.05f, warp[1] * 0.06f);
    // Furrows follow the creases of a noise that is stretched along the trunk; fewer cross them.
    float along = abs1(clast_fractal2_banded(vec2(q[0] * 9.0f, q[1] * 4.0f), 9, 4, 2, seed + 20));
    float across = abs1(clast_fractal2_banded(vec2(q[0] * 7.0f, q[1] * 12.0f), 7, 12, 2, seed + 21));
    float ridge = smooth_step(0.015f, 0.22f, along), plate = mix1(0.55f, 1.0f, smooth_step(0.0f, 0.12f, across));
    clast_cells flakes = clast_cells2_tiled(q * 21.0f, 21, seed + 22);
    float flake = (unit_float(flakes.id) - 0.5f) * smooth_step(0.0f, 0.2f, flakes.second - flakes.nearest);
    float fibre = clast_fractal2_banded(vec2(q[0] * 56.0f, q[1] * 12.0f), 56, 12, 4, seed + 23);
    float fine = clast_fractal2_tiled(p * 48.0f, 48, 4, seed + 24);
    float cloud = clast_fractal2_tiled(p * 3.0f, 3, 4, seed + 25);
    float height = 0.06f + ridge * plate * (0.74f + 0.16f * flake) + 0.12f * fibre + 0.05f * fine;
    float lift = smooth_step(0.10f, 0.85f, height);
    vec3 colour = mix3(vec3(0.085f, 0.052f, 0.030f), vec3(0.36f, 0.29f, 0.22f), lift);
    colour = colour * (0.85f + 0.7f * fibre + 0.3f * fine + 0.2f * flake);
    colour = mix3(colour, vec3(0.27f, 0.29f, 0.15f), 0.6f * smooth_step(0.08f, 0.34f, cloud) * lift);
    return (relief){colour, height};
}

static relief rings(vec2 p, uint seed)
{
    vec2 q = vec2(2.0f * p[0] - 1.0f, 2.0f * p[1] - 1.0f);
    float radius = length2(q), turns = turns_of(q[1], q[0]);
    float wobble = clast_fractal2(q * 1.7f, 3, seed), fine = clast_fractal2(q * 40.0f, 4, seed + 20);
    float year = radius * 19.0f + 2.2f * wobble + 0.15f * fine, late = fraction(year);
    float saw = clast_fractal2(vec2(q[0] * 5.0f + q[1] * 1.5f, q[1] * 60.0f), 3, seed + 21);
    float ray = clast_noise2(vec2(wave_cosine(turns) * 2.6f, wave_sine(turns) * 2.6f), seed + 22);
    float crack = smooth_step(0.055f, 0.0f, abs1(ray)) * smooth_step(0.05f, 0.5f, radius) *
                  smooth_step(-0.2f, 0.3f, wobble + radius - 0.6f);
    float rind = smooth_step(0.90f, 0.94f, radius);
    float height = 0.70f + 0.16f * smooth_step(0.0f, 0.7f, late) * smooth_step(1.0f, 0.85f, late) + 0.10f * saw +
                   0.05f * fine - 0.65f * crack - 0.1f * rind;
    vec3 colour = mix3(vec3(0.55f, 0.37f, 0.20f), vec3(0.37f, 0.215f, 0.10f), smooth_step(0.45f, 0.95f, late));
    colour = mix3(colour, vec3(0.30f, 0.17f, 0.085f), smooth_step(0.55f, 0.2f, radius) * 0.7f);
    colour = mix3(colour * (1.0f + 0.35f * saw + 0.3f * fine - 0.7f * crack), vec3(0.10f, 0.065f, 0.04f), rind);
    return (relief){colour, height};
}

static relief ashlar(vec2 p, uint seed)
{
    vec2 warp = vec2(clast_fractal2_tiled(p * 4.0f, 4, 4, seed), clast_fractal2_tiled(p * 4.0f, 4, 4, seed + 10));
    vec2 q = p + warp * 0.06f;
    clast_cells facets = clast_cells2_tiled(q * 7.0f, 7, seed + 20);
    clast_cells chips = clast_cells2_tiled(q * 23.0f, 23, seed + 21);
    float fine = clast_fractal2_tiled(p * 28.0f, 28, 6, seed + 22);
    float broad = clast_fractal2_tiled(p * 3.0f, 3, 3, seed + 23);
    float lichen = clast_fractal2_tiled(p * 9.0f, 9, 5, seed + 24);
    float height = 0.50f + 0.40f * broad +
                   0.22f * (unit_float(facets.id) - 0.5f) * smooth_step(0.0f, 0.25f, facets.second - facets.nearest) +
                   0.10f * (unit_float(chips.id) - 0.5f) * smooth_step(0.0f, 0.2f, chips.second - chips.nearest) +
                   0.20f * fine;
    float tone = 0.80f + 0.5f * fine + 0.35f * (height - 0.5f) + 0.12f * warp[0];
    vec3 colour = mix3(vec3(0.50f, 0.41f, 0.315f), vec3(0.44f, 0.40f, 0.36f), unit_float(hash1(facets.id)));
    colour = mix3(colour * tone, vec3(0.46f, 0.44f, 0.30f), 0.6f * smooth_step(0.16f, 0.28f, lichen));
    return (relief){colour, height};
}

static relief hills(vec2 p, uint seed)
{
    vec2 q = vec2((p[0] - 0.5f) * GROUND_SIDE, (p[1] - 0.5f) * GROUND_SIDE);
    float radius = length2(q);
    vec2 bend = vec2(clast_fractal2(q * 0.012f, 3, seed + 30), clast_fractal2(q * 0.012f, 3, seed + 31));
    vec2 place = q * 0.0075f + bend * 0.7f;
    float ridge = clast_ridged2(place, 5, seed), swell = clast_fractal2(q * 0.02f, 4, seed + 10);
    float fine = clast_fractal2(q * 0.35f, 5, seed + 20), patch = clast_fractal2(q * 0.03f, 5, seed + 21);
    // A valley is open towards +x, where the sun is.
    float rise = smooth_step(30.0f, 250.0f, radius) *
                 (1.0f - 0.55f * smooth_step(0.3f, 0.85f, q[0] / max1(radius, 1.0f)));
    float height = rise * rise * (0.20f + 0.80f * ridge + 0.35f * swell + 0.03f * fine) +
                   0.0045f * smooth_step(14.0f, 26.0f, radius) * (1.0f + swell + 0.4f * fine);
    vec3 grass = mix3(vec3(0.34f, 0.275f, 0.125f), vec3(0.165f, 0.175f, 0.055f), smooth_step(-0.15f, 0.30f, patch));
    vec3 rock = vec3(0.42f, 0.35f, 0.28f);
    vec3 colour = mix3(grass, rock, smooth_step(0.34f, 0.60f, ridge + 0.35f * fine) * rise) * (0.9f + 0.6f * fine);
    return (relief){mix3(colour, vec3(0.46f, 0.41f, 0.43f), 0.5f * smooth_step(40.0f, 320.0f, radius)), height};
}

static relief (*const recipes[CLAST_RELIEF_KINDS])(vec2 p, uint seed) = {cobbles, panel, globe,  rope,
                                                                         bark,    rings, ashlar, hills};

// ---------------------------------------------------------------------------------------------------------- writing

typedef struct carving {
    clast_relief_kind kind;
    uint32_t width, height, seed;
    float *heights;
    uint8_t *colours;
    const uint8_t *gamma;
} carving;

static void carve_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const carving *c = data;
    for (size_t y = begin; y < end; y++) {
        for (uint32_t x = 0; x < c->width; x++) {
            relief r = recipes[c->kind](vec2(((float)x + 0.5f) / (float)c->width, ((float)y + 0.5f) / (float)c->height),
                                        c->seed);
            size_t at = y * c->width + x;
            c->heights[at] = r.height;
            for (int k = 0; k < 3; k++) {
                c->colours[3 * at + (size_t)k] = clast_gamma_byte(c->gamma, r.colour[k]);
            }
        }
    }
}

static float carved_height(const void *data, uint32_t x, uint32_t y)
{
    const carving *c = data;
    return c->heights[(size_t)y * c->width + x];
}

clast_relief_range clast_write_relief(clast_outputs *outputs, clast_relief_kind kind, uint32_t size, uint32_t seed)
{
    clast_context *context = outputs->context;
    const clast_relief_files *files = &clast_relief_names[kind];
    uint8_t gamma[CLAST_GAMMA_STEPS];
    carving c = {.kind = kind,
                 .width = size * files->aspect,
                 .height = size,
                 .seed = hash2(seed, 900 + (uint)kind),
                 .gamma = gamma};
    float low = 0.0f, high = 0.0f;
    size_t count = (size_t)c.width * c.height;
    clast_make_gamma(gamma);
    c.heights = clast_allocate(context, count, sizeof *c.heights);
    c.colours = clast_allocate(context, count, 3);
    if (c.heights == NULL || c.colours == NULL) {
        clast_outputs_note(outputs, CLAST_ERROR_OUT_OF_MEMORY);
    } else if (outputs->status == CLAST_OK) {
        clast_parallel_for(context, c.height, 4, carve_rows, &c);
        clast_picture_write(outputs, files->colour, c.width, c.height, c.colours);
        clast_picture_write_heights(outputs, files->height, c.width, c.height, carved_height, &c, &low, &high);
    }
    clast_free(context, c.heights);
    clast_free(context, c.colours);
    return (clast_relief_range){files->depth * (high - low), files->depth * (low - files->level)};
}
