// SPDX-License-Identifier: Apache-2.0
#include "generate/stone.h"

#include "generate/canyon.h"
#include "generate/lathe.h"

static const float TILE = 1.7f;

// The rotation about y that takes local z to "outwards" at `turns`.
static vec3 turn_vector(vec3 v, float turns)
{
    float c = wave_cosine(turns), s = wave_sine(turns);
    return vec3(v[0] * s + v[2] * c, v[1], -v[0] * c + v[2] * s);
}

static vec3 to_world(const clast_stone *stone, vec3 p, float *turns)
{
    p[1] += stone->tilt_x * p[2] + stone->tilt_z * p[0];
    if (stone->radius > 0.0f) {
        *turns = stone->turn - p[0] / (6.2831853f * stone->radius);
        vec3 q = turn_vector(vec3(0.0f, p[1], stone->radius + p[2]), *turns);
        return q + vec3(0.0f, stone->centre[1], 0.0f);
    }
    *turns = stone->turn;
    return turn_vector(p, stone->turn) + stone->centre;
}

typedef struct box_point {
    vec3 position, normal;
    float edge; // 0 on a face, to 1 on an edge or corner
} box_point;

static box_point rounded_box(const clast_stone *stone, vec3 lattice)
{
    vec3 p = lattice * stone->half, inner;
    for (int i = 0; i < 3; i++) {
        float reach = max1(stone->half[i] - stone->bevel, 0.0f);
        inner[i] = clamp1(p[i], -reach, reach);
    }
    inner[3] = 0.0f;
    vec3 out = p - inner;
    vec3 normal = normalize3(out);
    float largest = max1(abs1(normal[0]), max1(abs1(normal[1]), abs1(normal[2])));
    return (box_point){inner + normal * stone->bevel, normal, clamp1((1.0f - largest) * 3.4f, 0.0f, 1.0f)};
}

static float outer_relief(const clast_stone *stone, vec3 p)
{
    if (stone->ornament == CLAST_ORNAMENT_PLAIN || p[2] < stone->half[2] - 1.2f * stone->bevel) {
        return 0.0f;
    }
    float height = stone->half[1] - stone->bevel, across = p[1] / height;
    float inside = smooth_step(1.0f, 0.93f, abs1(across)) *
                   smooth_step(stone->half[0] - stone->bevel, stone->half[0] - 2.5f * stone->bevel, abs1(p[0]));
    float along = (p[0] / stone->half[0] * 0.5f + 0.5f) * stone->repeats;
    return inside * clast_ornament_height(stone->ornament, along, clamp1(across, -1.0f, 1.0f),
                                          height * stone->repeats / stone->half[0]);
}

// How far a place of the box is worn in, local coordinates.
static float worn(const clast_stone *stone, vec3 p, float edge)
{
    vec3 q = p + vec3(unit_float(hash1(stone->seed)), unit_float(hash2(stone->seed, 1)),
                      unit_float(hash2(stone->seed, 2))) *
                     64.0f;
    float wear = clast_wear(q, stone->seed);
    float bite = smooth_step(0.12f, 0.5f, clast_noise3(q * 1.9f, stone->seed + 5));
    return stone->wear * (wear * (0.5f + edge) + 2.2f * bite * edge);
}

static void evaluate_stone(const void *shape, vec3 lattice, uint32_t face, clast_surface_point *result)
{
    const clast_stone *stone = shape;
    box_point box = rounded_box(stone, lattice);
    float relief = outer_relief(stone, box.position);
    vec3 p = box.position - box.normal * worn(stone, box.position, box.edge);
    p = p + vec3(0.0f, 0.0f, stone->depth * relief);
    float turns;
    result->position = to_world(stone, p, &turns);
    // The normal leans with the slope of what was worn and carved: by differences, the same on both sides of an edge.
    float step = 0.02f;
    vec3 slope = splat3(0.0f);
    for (int i = 0; i < 3; i++) {
        vec3 q = box.position;
        q[i] += step;
        float rise = -worn(stone, q, box.edge) + stone->depth * outer_relief(stone, q);
        q[i] -= 2.0f * step;
        rise -= -worn(stone, q, box.edge) + stone->depth * outer_relief(stone, q);
        slope[i] = rise / (2.0f * step);
    }
    slope = slope - box.normal * dot3(slope, box.normal);
    vec3 normal = box.normal - slope - vec3(stone->tilt_z, 0.0f, stone->tilt_x) * box.normal[1];
    result->normal = normalize3(turn_vector(normal, turns));
    vec3 colour = clast_carved_colour(
        stone->colour, result->position,
        stone->ornament != CLAST_ORNAMENT_PLAIN && face == 5 ? relief : 0.45f + 0.4f * box.edge, stone->seed & 1);
    float low = smooth_step(-0.9f, -1.0f, lattice[1]); // the joint below
    colour = colour * (1.0f - 0.35f * low);
    result->colour = mix3(
        colour, CLAST_SAND_COLOUR,
        stone->dust * smooth_step(0.3f, 0.9f, box.normal[1]) *
            clamp1(0.55f + 0.9f * clast_fractal2(vec2(result->position[0], result->position[2]) * 0.9f, 3, 77), 0.0f,
                   1.0f));
    uint32_t axis = face / 2;
    vec2 offset = vec2(chance(stone->seed, 3, axis), chance(stone->seed, 4, axis));
    result->coordinates = (axis == 0   ? vec2(p[2], -p[1])
                           : axis == 1 ? vec2(p[0], p[2])
                                       : vec2(p[0], -p[1])) *
                              (1.0f / TILE) +
                          offset;
}

static uint32_t divide(float length, float side)
{
    float count = length / side + 0.5f;
    return count < 1.0f ? 1 : count > 900.0f ? 900 : (uint32_t)count;
}

void clast_build_stone(clast_builder *builder, const clast_stone *stone, double triangles)
{
    vec3 h = stone->half;
    double area = 8.0 * (double)(h[0] * h[1] + h[1] * h[2] + h[0] * h[2]);
    float side = (float)sqrt(area * 2.0 / triangles);
    clast_block block = {.shape = stone, .evaluate = evaluate_stone, .hidden_faces = stone->hidden_faces};
    // A row of quads for the bevel at each end, where that leaves some between.
    bool bevelled = triangles >= 90.0;
    for (uint32_t i = 0; i < 3; i++) {
        uint32_t count = divide(2.0f * h[i], side);
        block.segments[i] = bevelled ? (count < 3 ? 3 : count) : count;
        block.bevels[i] = min1(stone->bevel / h[i], 0.45f);
    }
    block.bevel_segments = bevelled ? (triangles > 2500.0 ? 2 : 1) : 0;
    if (block.bevel_segments == 2) {
        for (uint32_t i = 0; i < 3; i++) {
            block.segments[i] = block.segments[i] < 5 ? 5 : block.segments[i];
        }
    }
    clast_build_block(builder, &block);
}
