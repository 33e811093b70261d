// SPDX-License-Identifier: Apache-2.0
#include "generate/ornament.h"

// Half a round bar: 1 in its middle, 0 from `width` on.
static float bar(float distance, float width)
{
    float t = distance / width;
    return root(1.0f - t * t);
}

// Raised with steep, slightly rounded sides.
static float raised(float distance, float half_width, float edge)
{
    return smooth_step(half_width + edge, half_width - edge, distance);
}

static float segment_distance(float x, float y, float x0, float y0, float x1, float y1)
{
    float dx = x1 - x0, dy = y1 - y0;
    float t = clamp1(((x - x0) * dx + (y - y0) * dy) / max1(dx * dx + dy * dy, 1e-12f), 0.0f, 1.0f);
    return length2(vec2(x - x0 - t * dx, y - y0 - t * dy));
}

static float beads(float along, float across, float aspect)
{
    // Round whatever the band's shape; a small disc on edge between two pearls.
    float x = (fraction(along) - 0.5f) / (0.5f * aspect);
    float pearl = root(1.0f - (x * x + across * across) * 1.12f);
    float x2 = (fraction(along + 0.5f) - 0.5f) / (0.5f * aspect);
    float disc = 0.55f * bar(abs1(x2), 0.16f) * root(1.0f - 1.7f * across * across);
    return max1(pearl, disc);
}

static float rope(float along, float across)
{
    float phase = along + 0.55f * across;
    float strand = abs1(wave_sine(0.5f * phase));
    return root(1.0f - across * across) * (0.45f + 0.55f * root(strand));
}

static float strand_height(float across, float centre, float slope, float lift)
{
    float distance = abs1(across - centre) / sqrtf(1.0f + slope * slope);
    float width = 0.235f;
    if (distance >= width) {
        return 0.0f;
    }
    float t = distance / width;
    // Two grooves divide the strand into three reeds.
    float reeds = 0.16f * smooth_step(0.20f, 0.05f, abs1(t - 0.40f));
    return max1(0.62f + 0.22f * root(1.0f - t * t) - reeds + 0.16f * lift, 0.0f) * smooth_step(1.0f, 0.86f, t);
}

static float guilloche(float along, float across, float aspect)
{
    float swing_size = 0.62f;
    float s = wave_sine(along), c = wave_cosine(along);
    float slope = swing_size * 6.2831853f * c * 0.5f * aspect;
    float over = strand_height(across, swing_size * s, slope, c);
    float under = strand_height(across, -swing_size * s, slope, -c);
    // The eyes are dished; the corners hold small triangles of leaves.
    float corner = abs1(across) - (swing_size * abs1(s) + 0.235f);
    float spandrel = 0.38f * smooth_step(0.03f, 0.12f, corner) * (0.6f + 0.4f * abs1(wave_sine(along * 6.0f)));
    return max1(max1(over, under), abs1(across) < 0.94f ? spandrel : 0.0f);
}

static float meander(float along, float across)
{
    // A unit is 5.6 wide and 5 high; a rail below, and a hook that turns inwards.
    static const float line[6][2] = {{0.0f, 0.3f},  {0.0f, 4.4f},   {4.1f, 4.4f},
                                     {4.1f, 1.55f}, {1.55f, 1.55f}, {1.55f, 3.0f}};
    float y = 2.5f * (across + 1.0f);
    float least = abs1(y - 0.3f);
    for (int shift = -1; shift <= 1; shift++) {
        float x = (fraction(along) + (float)shift) * 5.6f - 0.55f;
        for (int i = 0; i < 5; i++) {
            least = min1(least, segment_distance(x, y, line[i][0], line[i][1], line[i + 1][0], line[i + 1][1]));
        }
    }
    return raised(least, 0.42f, 0.10f);
}

static float scales(float along, float across)
{
    // Each scale is a disc that hangs from its row over the next; the uppermost that covers a place counts.
    float y = 2.5f * (across + 1.0f);
    float height = 0.0f;
    for (int back = 2; back >= 0; back--) {
        float row = floor1(y) - (float)back;
        float shift = fraction(row * 0.5f);
        float x = fraction(along + shift) - 0.5f;
        float down = y - row - 0.35f;
        float distance = length2(vec2(x * 1.9f, down * 0.78f));
        if (distance < 1.0f) {
            float rim = smooth_step(1.0f, 0.93f, distance);
            float rib = 0.10f * smooth_step(0.06f, 0.0f, abs1(x)) * smooth_step(1.0f, 0.6f, distance);
            height = mix1(height, 0.30f + 0.34f * down * 0.78f + 0.24f * root(1.0f - distance * distance) + rib, rim);
        }
    }
    return clamp1(height, 0.0f, 1.0f);
}

float clast_rosette_height(float x, float y, float petals)
{
    float radius = length2(vec2(x, y));
    if (radius >= 1.0f) {
        return 0.0f;
    }
    float turns = turns_of(y, x);
    float boss = 0.95f * root(1.0f - square(radius / 0.24f));
    float ring = 0.55f * bar(abs1(radius - 0.30f), 0.06f);
    float height = max1(boss, ring);
    for (int layer = 0; layer < 2; layer++) {
        float phase = fraction(turns * petals + 0.5f * (float)layer) - 0.5f; // across a petal
        float tip = layer == 0 ? 0.80f : 1.0f, t = (radius - 0.22f) / (tip - 0.22f);
        if (t > 0.0f && t < 1.0f) {
            float width = (0.30f + 0.30f * t) * root(1.0f - square(max1(2.0f * t - 1.0f, 0.0f)));
            float across = abs1(phase) / max1(width, 1e-3f);
            if (across < 1.0f) {
                // A trough along the middle, turned up at the tip.
                float leaf = (layer == 0 ? 0.62f : 0.36f) * root(1.0f - across * across) -
                             0.14f * smooth_step(0.3f, 0.0f, across);
                height = max1(height, leaf * (0.72f + 0.28f * t * t) * smooth_step(1.0f, 0.96f, t));
            }
        }
    }
    return clamp1(height, 0.0f, 1.0f);
}

static float coffers(float along, float across, float aspect)
{
    float x = (fraction(along) - 0.5f) * 2.0f / aspect, reach = 1.0f / aspect;
    float edge = min1(1.0f - abs1(across), reach - abs1(x)); // distance to the panel's border
    float frame = smooth_step(0.20f, 0.12f, edge);
    float step = 0.35f * smooth_step(0.34f, 0.27f, edge);
    float rosette = 0.85f * clast_rosette_height(x / 0.62f, across / 0.62f, 8.0f);
    return max1(max1(frame, step), rosette);
}

// One leaf: y 0 at its root, 1 at its tip; x -1 to 1 over a repeat.
static float leaf(float x, float y)
{
    if (y < 0.0f || y > 1.0f) {
        return 0.0f;
    }
    float outline = 0.93f * root(1.0f - square(square(max1(y * 1.25f - 0.25f, 0.0f))));
    float t = abs1(x) / max1(outline, 1e-3f);
    if (t >= 1.0f) {
        return 0.0f;
    }
    float rim = 0.30f * smooth_step(0.16f, 0.06f, abs1(t - 0.86f));
    float rib = 0.35f * smooth_step(0.14f, 0.04f, t) * smooth_step(1.0f, 0.8f, y);
    float veins = 0.10f * smooth_step(0.4f, 0.9f, wave_sine(y * 6.0f - t * 1.2f)) * smooth_step(0.86f, 0.7f, t);
    return clamp1(0.42f + 0.22f * root(1.0f - t * t) + rim + rib + veins + 0.12f * y, 0.0f, 1.0f) *
           smooth_step(1.0f, 0.95f, t);
}

static float tongues(float along, float across)
{
    float y = 0.5f * (across + 1.0f);
    float front = leaf(2.0f * fraction(along) - 1.0f, y * 1.04f);
    float dart = 0.34f * raised(abs1(fraction(along + 0.5f) - 0.5f), 0.035f, 0.02f);
    return max1(front, dart);
}

static float leaves(float along, float across)
{
    float y = 0.5f * (across + 1.0f);
    float front = leaf(2.0f * fraction(along) - 1.0f, y * 1.75f);
    float back = 0.72f * leaf(2.0f * fraction(along + 0.5f) - 1.0f, y * 1.02f);
    return max1(front, back);
}

static float flutes(float along, float across)
{
    float x = abs1(2.0f * fraction(along) - 1.0f);
    float channel = root(1.0f - square(min1(x / 0.84f, 1.0f)));
    // Channels end in half-rounds.
    float end = smooth_step(1.0f, 0.985f, abs1(across));
    return 1.0f - channel * end;
}

static float lattice(float along, float across, float aspect)
{
    float x = along, y = across * 0.5f * aspect;
    float a = abs1(fraction(x + y) - 0.5f), b = abs1(fraction(x - y) - 0.5f);
    float height = 0.62f * max1(bar(0.5f - a, 0.13f), bar(0.5f - b, 0.13f));
    float stud = root(1.0f - (square((0.5f - a) / 0.2f) + square((0.5f - b) / 0.2f)));
    float pearl = 0.55f * root(1.0f - (square(a / 0.2f) + square(b / 0.2f)));
    float border = 0.9f * raised(1.0f - abs1(across), 0.14f, 0.03f);
    return max1(max1(max1(height, stud), pearl), border);
}

static float ticks(float along, float across)
{
    float border = raised(1.0f - abs1(across), 0.10f, 0.03f);
    float tenth = abs1(fraction(along * 10.0f + 0.5f) - 0.5f) * 0.1f, whole = abs1(fraction(along + 0.5f) - 0.5f);
    float groove = across > 0.25f ? raised(tenth, 0.016f, 0.008f) : 0.0f;
    groove = across > -0.35f ? max1(groove, raised(whole, 0.024f, 0.008f)) : groove;
    float dot = raised(length2(vec2((fraction(along) - 0.5f) * 4.0f, across + 0.5f)), 0.24f, 0.05f);
    return max1(border, 0.55f - 0.55f * groove + 0.35f * dot);
}

static float glyphs(float along, float across)
{
    uint cell = (uint)(int)floor1(along);
    float x = (fraction(along) - 0.5f) * 1.5f, y = across * 1.25f;
    float least = abs1(length2(vec2(x + 0.12f * swing(cell, 1, 2), y - 0.35f * swing(cell, 3, 4))) - 0.22f);
    least = chance(cell, 5, 6) < 0.45f ? least : 9.0f;
    for (uint i = 0; i < 4; i++) {
        // Strokes between points of a small grid.
        float x0 = 0.42f * ((float)(hash3(cell, i, 7) % 3) - 1.0f),
              y0 = 0.40f * ((float)(hash3(cell, i, 8) % 5) - 2.0f);
        float x1 = 0.42f * ((float)(hash3(cell, i, 9) % 3) - 1.0f),
              y1 = 0.40f * ((float)(hash3(cell, i, 10) % 5) - 2.0f);
        least = min1(least, segment_distance(x, y, x0, y0, (i & 1) != 0 ? x0 : x1, y1));
    }
    return raised(least, 0.085f, 0.035f);
}

static float waves(float along, float across, float aspect)
{
    // A spiral around each repeat's middle, joined by the line that runs below it.
    float x = (fraction(along) - 0.5f) * 2.0f / aspect, y = across;
    float radius = length2(vec2(x, y));
    float turns = turns_of(y, x);
    float spiral = abs1(fraction(radius * 2.1f - turns + 0.5f) - 0.5f) / 2.1f;
    float scroll = radius < 0.86f ? raised(spiral, 0.085f, 0.03f) : 0.0f;
    float eye = root(1.0f - square(radius / 0.2f));
    float rail = raised(abs1(abs1(y) - 0.93f), 0.06f, 0.02f);
    return max1(max1(scroll * 0.8f, eye), rail);
}

float clast_ornament_height(clast_ornament ornament, float along, float across, float aspect)
{
    switch (ornament) {
    case CLAST_ORNAMENT_BEADS: return beads(along, across, aspect);
    case CLAST_ORNAMENT_ROPE: return rope(along, across);
    case CLAST_ORNAMENT_GUILLOCHE: return guilloche(along, across, aspect);
    case CLAST_ORNAMENT_MEANDER: return meander(along, across);
    case CLAST_ORNAMENT_SCALES: return scales(along, across);
    case CLAST_ORNAMENT_COFFERS: return coffers(along, across, aspect);
    case CLAST_ORNAMENT_TONGUES: return tongues(along, across);
    case CLAST_ORNAMENT_LEAVES: return leaves(along, across);
    case CLAST_ORNAMENT_FLUTES: return flutes(along, across);
    case CLAST_ORNAMENT_LATTICE: return lattice(along, across, aspect);
    case CLAST_ORNAMENT_TICKS: return ticks(along, across);
    case CLAST_ORNAMENT_GLYPHS: return glyphs(along, across);
    case CLAST_ORNAMENT_WAVES: return waves(along, across, aspect);
    case CLAST_ORNAMENT_PLAIN: break;
    }
    return 0.0f;
}
