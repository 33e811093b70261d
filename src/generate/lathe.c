// SPDX-License-Identifier: Apache-2.0
#include "generate/lathe.h"

float clast_wear(vec3 p, uint seed)
{
    float broad = smooth_step(0.05f, 0.55f, clast_fractal3(p * 0.7f, 3, seed + 1));
    clast_cells chips = clast_cells3(p * 2.6f, seed + 2);
    float chip = smooth_step(0.42f, 0.18f, chips.nearest) * (unit_float(chips.id) < 0.16f ? 1.0f : 0.0f);
    float grain = 0.5f + 0.5f * clast_fractal3(p * 5.0f, 3, seed + 3);
    return 0.42f * broad * grain + 0.6f * chip + 0.10f * grain;
}

vec3 clast_carved_colour(vec3 base, vec3 p, float relief, uint seed)
{
    float cloud = clast_fractal3(p * 0.55f, 3, seed + 11), fine = clast_fractal3(p * 3.1f, 2, seed + 12);
    vec3 colour = base * (1.0f + 0.16f * cloud + 0.10f * fine);
    colour = mix3(colour, vec3(0.50f, 0.31f, 0.19f), clamp1(0.22f + 0.55f * cloud, 0.0f, 0.5f)); // iron stains
    colour = mix3(colour * vec3(0.50f, 0.44f, 0.40f), colour * 1.08f, smooth_step(0.0f, 0.62f, relief));
    float streaks = clast_fractal3(vec3(p[0] * 1.7f, p[1] * 0.16f, p[2] * 1.7f), 3, seed + 13);
    colour = colour * (1.0f - 0.42f * smooth_step(0.08f, 0.5f, streaks));
    return min3(colour, splat3(1.0f));
}

static float point_distance(const clast_lathe_point *a, const clast_lathe_point *b)
{
    return length2(vec2(b->radius - a->radius, b->height - a->height));
}

// Hands out whole rows to the stretches, so that every corner of the profile lies on a row.
static void hand_out_rows(clast_lathe *lathe, double rows)
{
    double sum = 0.0;
    lathe->start[0] = 0.0f;
    for (uint32_t i = 0; i + 1 < lathe->point_count; i++) {
        float length = point_distance(&lathe->points[i], &lathe->points[i + 1]);
        lathe->start[i + 1] = lathe->start[i] + length;
        sum += (double)(length * (lathe->points[i].weight > 0.0f ? lathe->points[i].weight : 1.0f));
    }
    lathe->rows = 0;
    for (uint32_t i = 0; i + 1 < lathe->point_count; i++) {
        float length = lathe->start[i + 1] - lathe->start[i];
        double wanted = rows * (double)(length * (lathe->points[i].weight > 0.0f ? lathe->points[i].weight : 1.0f)) /
                        sum;
        lathe->first_row[i] = lathe->rows;
        lathe->rows += wanted < 1.0 ? 1 : (uint32_t)(wanted + 0.5);
    }
    lathe->first_row[lathe->point_count - 1] = lathe->rows;
}

static void evaluate_lathe(const void *shape, float u, float v, clast_surface_point *point)
{
    const clast_lathe *lathe = shape;
    float row = v * (float)lathe->rows;
    uint32_t stretch = 0;
    while (stretch + 2 < lathe->point_count && row >= (float)lathe->first_row[stretch + 1] - 1e-3f) {
        stretch++;
    }
    const clast_lathe_point *a = &lathe->points[stretch], *b = a + 1;
    float t = (row - (float)lathe->first_row[stretch]) /
              (float)(lathe->first_row[stretch + 1] - lathe->first_row[stretch]);
    t = clamp1(t, 0.0f, 1.0f);
    float length = max1(point_distance(a, b), 1e-6f);
    float radius = mix1(a->radius, b->radius, t), height = mix1(a->height, b->height, t);
    vec2 outwards = vec2((b->height - a->height) / length, -(b->radius - a->radius) / length);
    float along = u * a->repeats;
    float aspect = a->repeats > 0.0f ? length * a->repeats / (6.2831853f * 0.5f * (a->radius + b->radius)) : 1.0f;
    float relief = a->ornament != CLAST_ORNAMENT_PLAIN
                       ? clast_ornament_height(a->ornament, along, 2.0f * t - 1.0f, aspect)
                       : 0.0f;
    float c = wave_cosine(u), s = wave_sine(u);
    vec3 place = vec3(c * radius, height, -s * radius);
    float shift = relief * a->depth;
    float wear = lathe->wear > 0.0f ? clast_wear(place + splat3(0.37f * unit_float(lathe->seed)), lathe->seed) : 0.0f;
    shift = shift * (1.0f - 0.5f * min1(wear, 1.0f)) - wear * lathe->wear;
    if (radius <= 0.0f) {
        shift = 0.0f;
    }
    point->position = place + vec3(outwards[0] * c, outwards[1], outwards[0] * -s) * shift;
    if (lathe->fracture > 0.0f) {
        float rise = smooth_step(lathe->fracture - 1.1f, lathe->fracture, height);
        vec3 q = vec3(place[0], 0.0f, place[2]);
        float slope = clast_noise3(q * 0.9f, lathe->seed + 31) + 0.55f * q[0];
        clast_cells facets = clast_cells3(q * 2.3f, lathe->seed + 32);
        float break_height = slope + 0.5f * unit_float(facets.id) +
                             0.35f * clast_fractal3(q * 4.0f, 3, lathe->seed + 33);
        point->position[1] += rise * lathe->fracture_depth * break_height;
    }
    vec3 tinted = lathe->wear > 0.0f
                      ? clast_carved_colour(lathe->colour, place, a->ornament != CLAST_ORNAMENT_PLAIN ? relief : 0.55f,
                                            lathe->seed)
                      : lathe->colour * mix1(0.62f, 1.0f, a->ornament != CLAST_ORNAMENT_PLAIN ? relief : 1.0f);
    point->colour = tinted;
    // A whole number of repeats around: textures meet at the seam.
    point->coordinates = vec2(u * max1(floor1(6.2831853f * lathe->points[0].radius / lathe->tile + 0.5f), 1.0f),
                              -(lathe->start[stretch] + t * length) / lathe->tile);
}

void clast_build_lathe(clast_builder *builder, clast_lathe *lathe, double triangles)
{
    float length = 0.0f, radius = 0.0f;
    for (uint32_t i = 0; i + 1 < lathe->point_count; i++) {
        float weight = lathe->points[i].weight > 0.0f ? lathe->points[i].weight : 1.0f;
        length += weight * point_distance(&lathe->points[i], &lathe->points[i + 1]);
        radius = max1(radius, lathe->points[i].radius);
    }
    // d/du x d/dv: at u = 0 that is -z x up = outwards.
    clast_sheet sheet = {.shape = lathe, .evaluate = evaluate_lathe, .wraps_columns = true};
    clast_sheet_divide(&sheet, triangles, 6.2831853f * radius * 0.9f, length);
    hand_out_rows(lathe, (double)sheet.rows);
    clast_sheet_set_rows(&sheet, triangles, lathe->rows, 6);
    clast_build_sheet(builder, &sheet);
}
