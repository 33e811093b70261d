// SPDX-License-Identifier: Apache-2.0
#include "generate/hoop.h"

#include "generate/lathe.h"

// The section's eight pieces, in the order in which v goes: faces and the edges between them.
enum { FRONT, FRONT_OUTER, OUTER, OUTER_BACK, BACK, BACK_INNER, INNER, INNER_FRONT, PIECES };

typedef struct section_point {
    float radial, axial; // from the section's middle
    float normal_radial, normal_axial;
    uint32_t piece;
    float across; // metres from the middle of the piece
    float length; // of the piece
    float path;   // metres from v = 0
} section_point;

static float piece_length(const clast_hoop *hoop, uint32_t piece)
{
    if ((piece & 1) != 0) {
        return 1.5707963f * hoop->corner;
    }
    return 2.0f * ((piece == FRONT || piece == BACK ? hoop->half_radial : hoop->half_axial) - hoop->corner);
}

static float piece_weight(const clast_hoop *hoop, uint32_t piece)
{
    float rare = hoop->back_weight > 0.0f ? hoop->back_weight : 1.0f;
    return piece == BACK || piece == OUTER_BACK || piece == BACK_INNER ? rare
           : piece == OUTER                                            ? 0.5f * (1.0f + rare)
                                                                       : 1.0f;
}

static section_point section_at(const clast_hoop *hoop, float v)
{
    float sum = 0.0f;
    for (uint32_t i = 0; i < PIECES; i++) {
        sum += piece_length(hoop, i) * piece_weight(hoop, i);
    }
    float rest = fraction(v) * sum;
    section_point p = {0};
    while (p.piece + 1 < PIECES && rest >= piece_length(hoop, p.piece) * piece_weight(hoop, p.piece)) {
        rest -= piece_length(hoop, p.piece) * piece_weight(hoop, p.piece);
        p.path += piece_length(hoop, p.piece);
        p.piece++;
    }
    p.length = piece_length(hoop, p.piece);
    float t = rest / piece_weight(hoop, p.piece); // metres into the piece
    p.path += t;
    p.across = t - 0.5f * p.length;
    // Quarter turns from the front face: the piece's frame, turned back at the end.
    float a = hoop->half_radial - hoop->corner, b = hoop->half_axial - hoop->corner;
    float angle = (p.piece & 1) != 0 ? 0.25f * t / p.length : 0.0f;
    float n = wave_cosine(angle), m = wave_sine(angle); // normal along the face's own normal, and forwards
    switch (p.piece / 2) {
    case 0: // front: forwards is outwards
        p = (section_point){(p.piece & 1) != 0 ? a : p.across, b, m, n, p.piece, p.across, p.length, p.path};
        break;
    case 1: // outer rim: forwards is to the back
        p = (section_point){a, (p.piece & 1) != 0 ? -b : -p.across, n, -m, p.piece, -p.across, p.length, p.path};
        break;
    case 2: // back: forwards is inwards
        p = (section_point){(p.piece & 1) != 0 ? -a : -p.across, -b, -m, -n, p.piece, -p.across, p.length, p.path};
        break;
    default: // inner rim: forwards is to the front
        p = (section_point){-a, (p.piece & 1) != 0 ? b : p.across, -n, m, p.piece, p.across, p.length, p.path};
        break;
    }
    p.radial += p.normal_radial * hoop->corner;
    p.axial += p.normal_axial * hoop->corner;
    return p;
}

// Relief in metres, and how high it is within its ornament (0 to 1) for colour.
typedef struct relief {
    float metres, level;
} relief;

static relief relief_at(const clast_hoop *hoop, float turns, const section_point *p)
{
    if ((p->piece & 1) != 0) {
        if (hoop->rope_depth == 0.0f) {
            return (relief){0.0f, 0.7f};
        }
        float height = clast_ornament_height(CLAST_ORNAMENT_ROPE, turns * hoop->rope_repeats,
                                             2.0f * p->across / p->length, 1.0f);
        return (relief){height * hoop->rope_depth, height};
    }
    const clast_hoop_face *faces[] = {&hoop->front, &hoop->outer, &hoop->back, &hoop->inner};
    const clast_hoop_face *face = faces[p->piece / 2];
    for (uint32_t i = 0; i < face->count; i++) {
        const clast_hoop_band *band = &face->bands[i];
        if (p->across >= band->from && p->across <= band->to) {
            float width = band->to - band->from, middle = 0.5f * (band->to + band->from);
            float radius = hoop->radius + (p->piece == FRONT || p->piece == BACK ? middle
                                           : p->piece == OUTER                   ? hoop->half_radial
                                                                                 : -hoop->half_radial);
            float aspect = width * band->repeats / (6.2831853f * radius);
            float height = clast_ornament_height(band->ornament, turns * band->repeats,
                                                 (p->across - middle) / (0.5f * width), aspect);
            return (relief){height * band->depth + band->offset, band->depth < 0.0f ? 1.0f - height : height};
        }
    }
    return (relief){0.0f, 0.7f};
}

float clast_hoop_relief(const clast_hoop *hoop, float u, float v)
{
    section_point p = section_at(hoop, v);
    return relief_at(hoop, u, &p).metres;
}

// Moves a place out of the balls that are broken away, towards `core`, the middle of the section: what is seen from there
// as a height stays one, so that nothing folds over. Gives how much of it is a fresh break.
static float bite(const clast_hoop *hoop, vec3 core, vec3 *place)
{
    float fresh = 0.0f;
    for (uint32_t i = 0; i < hoop->bite_count; i++) {
        vec3 away = *place - vec3(hoop->bites[i][0], hoop->bites[i][1], hoop->bites[i][2]);
        float distance = length3(away), radius = hoop->bites[i][3];
        if (distance > 1.6f * radius || distance == 0.0f) {
            continue;
        }
        // Conchoidal: facets and fine steps.
        clast_cells facets = clast_cells3(*place * (2.4f / radius) + splat3((float)i), hoop->seed + 61);
        float rough = 0.20f * (unit_float(facets.id) - 0.5f) +
                      0.26f * clast_fractal3(*place * (1.8f / radius) + splat3((float)i), 4, hoop->seed + 62);
        float reach = radius * (1.0f + rough);
        if (distance < reach) {
            // Where the way to the core leaves the ball.
            vec3 inwards = normalize3(core - *place);
            float along = -dot3(away, inwards);
            float exit = along + root(along * along + reach * reach - distance * distance);
            *place = *place + inwards * min1(exit, 0.8f * length3(core - *place));
            fresh = max1(fresh, smooth_step(0.0f, 0.06f, reach - distance));
        }
    }
    return fresh;
}

static void evaluate_hoop(const void *shape, float u, float v, clast_surface_point *point)
{
    const clast_hoop *hoop = shape;
    bool whole = hoop->from == hoop->to;
    float turns = whole ? u : hoop->from + (hoop->to - hoop->from) * u;
    section_point p = section_at(hoop, v);
    relief carved = relief_at(hoop, turns, &p);
    float c = wave_cosine(turns), s = wave_sine(turns);
    vec3 place = vec3(c * (hoop->radius + p.radial), s * (hoop->radius + p.radial), p.axial);
    float shift = carved.metres;
    if (hoop->wear > 0.0f) {
        float wear = clast_wear(place, hoop->seed);
        shift = shift * (1.0f - 0.45f * min1(wear, 1.0f)) - wear * hoop->wear;
    }
    if (!whole) {
        float end = min1(u, 1.0f - u);
        shift = mix1(-hoop->end_drop, shift, end > 0.0f ? 1.0f : 0.0f);
    }
    point->position = place + vec3(c * p.normal_radial, s * p.normal_radial, p.normal_axial) * shift;
    float fresh = bite(hoop, vec3(c * hoop->radius, s * hoop->radius, 0.0f), &point->position);
    carved.level = mix1(carved.level, 0.72f, fresh);
    point->colour = hoop->wear > 0.0f ? clast_carved_colour(hoop->colour, place, carved.level, hoop->seed)
                                      : hoop->colour * mix1(0.50f, 1.0f, carved.level);
    float around = max1(floor1(6.2831853f * hoop->radius / hoop->tile + 0.5f), 1.0f);
    // v = 1 is a whole way around the section: there `path` is 0 again, and the texture goes on.
    float path = v >= 1.0f ? 0.0f : p.path;
    if (v >= 1.0f) {
        for (uint32_t i = 0; i < PIECES; i++) {
            path += piece_length(hoop, i);
        }
    }
    point->coordinates = vec2(turns * around, path / hoop->tile);
}

void clast_build_hoop(clast_builder *builder, const clast_hoop *hoop, double triangles)
{
    bool whole = hoop->from == hoop->to;
    float section = 0.0f;
    for (uint32_t i = 0; i < PIECES; i++) {
        section += piece_length(hoop, i) * piece_weight(hoop, i);
    }
    // d/du x d/dv on the front face is y x x = -z: inwards.
    clast_sheet sheet = {
        .shape = hoop, .evaluate = evaluate_hoop, .wraps_columns = whole, .wraps_rows = true, .flipped = true};
    float part = whole ? 1.0f : hoop->to - hoop->from;
    clast_sheet_divide(&sheet, triangles, 6.2831853f * hoop->radius * part, section);
    if (sheet.rows < 8) {
        clast_sheet_set_rows(&sheet, triangles, 8, whole ? 8 : 2);
    }
    clast_build_sheet(builder, &sheet);
}
