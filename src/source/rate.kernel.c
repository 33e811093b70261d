// SPDX-License-Identifier: Apache-2.0
// Segments of edges and levels of maps, as many at once as a register holds, by the formulas of shared/tessellation.h and
// shared/occlusion.h in the same order of the same operations.
#include "source/rate.h"
#include "source/wide_stable.h"

// ------------------------------------------------------------------------------------------------------------- points

// clast_rate_point
typedef struct seen_point {
    clast_wide3 camera;
    clast_wide screen[2];
    clast_wide facing;
} seen_point;

CLAST_LANES clast_wide row_of(packed4 row, clast_wide3 p)
{
    return row.v[0] * p.x + row.v[1] * p.y + row.v[2] * p.z + row.v[3];
}

CLAST_LANES clast_wide3 to_camera(const clast_rate_view *view, clast_wide3 p)
{
    const packed4 *rows = view->to_camera.rows;
    return (clast_wide3){row_of(rows[0], p), row_of(rows[1], p), row_of(rows[2], p)};
}

// rate_point()
CLAST_LANES void put_on_screen(const clast_rate_view *view, seen_point *point)
{
    clast_wide3 camera = point->camera;
    clast_wide sideways = wide_max1(wide_abs1(camera.x) * view->narrowing.v[0],
                                    wide_abs1(camera.y) * view->narrowing.v[1]);
    clast_wide depth = wide_max1(wide_max1(wide_splat(view->near_plane), camera.z), sideways);
    clast_wide scale = wide_splat(view->pixels);
    if (view->parallel == 0) {
        scale = scale * wide_reciprocal(wide_clamp1(depth, 1e-30f, 1e30f));
    }
    point->screen[0] = camera.x * scale;
    point->screen[1] = camera.y * scale;
}

CLAST_LANES clast_wide facing_of(const clast_rate_view *view, clast_wide3 position, clast_wide3 normal)
{
    clast_wide3 away = {view->eye.v[0] - position.x, view->eye.v[1] - position.y, view->eye.v[2] - position.z};
    return wide_dot3(normal, away) * wide_rsqrt(wide_clamp1(wide_dot3(away, away), 1e-36f, 1e36f));
}

CLAST_LANES seen_point look_at(const clast_rate_view *view, clast_wide3 position, clast_wide3 normal)
{
    seen_point point = {.camera = to_camera(view, position), .facing = facing_of(view, position, normal)};
    put_on_screen(view, &point);
    return point;
}

// vertex_level(), in steps
CLAST_LANES clast_wide level_of(const clast_rate_view *view, clast_wide3 camera, clast_wide density,
                                clast_wide shortest)
{
    clast_wide distance = wide_max1(wide_dot3(camera, camera), wide_splat(view->near_plane * view->near_plane));
    clast_wide wanted = (distance * view->square_by_distance + view->square) + shortest * view->square_by_edge;
    clast_wide texels = wide_clamp1(density * wide_min1(shortest, wanted), 0x1p-100f, 1e30f);
    clast_wide level = wide_clamp1(0.5f * wide_log2(texels), 0.0f, (float)(HEIGHT_LEVELS - 1));
    return wide_floor(level * (float)HEIGHT_LEVEL_STEPS + 0.5f);
}

CLAST_LANES clast_wide3 load_three(const float arrays[3][RATE_POINTS], uint32_t first)
{
    return (clast_wide3){wide_load(arrays[0] + first), wide_load(arrays[1] + first), wide_load(arrays[2] + first)};
}

void CLAST_KERNEL(clast_rate_points)(const clast_rate_view *view, const clast_rate_points *points, uint32_t count,
                                     clast_rate_site *sites, uint16_t *levels)
{
    typedef uint16_t words __attribute__((vector_size(2 * WIDE_LANES)));
    for (uint32_t first = 0; first < count; first += WIDE_LANES) {
        clast_wide3 position = load_three(points->positions, first), normal = load_three(points->normals, first);
        clast_wide3 moved = wide_displaced(position, normal, wide_load(points->heights + first));
        seen_point seen = look_at(view, moved, normal);
        clast_wide steps = level_of(view, to_camera(view, position), wide_load(points->density_squares + first),
                                    wide_load(points->shortest_squares + first));
        words small = __builtin_convertvector(wide_to_ints(steps), words);
        memcpy(levels + first, &small, sizeof small);
        clast_wide_columns all = {{position.x, position.y, position.z, normal.x, normal.y, normal.z, seen.camera.x,
                                   seen.camera.y, seen.camera.z, seen.screen[0], seen.screen[1], seen.facing}};
        wide_store_rows(sites[first].of, WIDE_LANES, all);
    }
}

// --------------------------------------------------------------------------------------------------------------- edges

CLAST_LANES clast_wide root_of_wide(clast_wide square)
{
    clast_wide sound = wide_clamp1(square, 1e-36f, 1e36f);
    return sound * wide_rsqrt(sound);
}

// outside_side(): of both sides of an axis the one that the points lie further out of.
CLAST_LANES clast_wide outside_sides(const clast_rate_view *view, uint32_t axis, const clast_wide across[3],
                                     const clast_wide depth[3])
{
    clast_wide reach[3], least[2];
    for (int i = 0; i < 3; i++) {
        reach[i] = wide_splat(view->extent.v[axis]);
        if (view->parallel == 0) {
            reach[i] = reach[i] * depth[i];
        }
    }
    least[0] = wide_min1(wide_min1(across[0] - reach[0], across[1] - reach[1]), across[2] - reach[2]);
    least[1] = wide_min1(wide_min1(-across[0] - reach[0], -across[1] - reach[1]), -across[2] - reach[2]);
    return wide_max1(least[0] * view->side_scale.v[axis], least[1] * view->side_scale.v[axis]);
}

// Of edge_seen(): how far within the picture, by how far outside, the way from end to end, and the middle's depth.
CLAST_LANES clast_wide within_of(const clast_rate_view *view, clast_wide outside, clast_wide3 chord, clast_wide depth)
{
    clast_wide reach = root_of_wide(wide_dot3(chord, chord));
    clast_wide margin = wide_splat(0.1f * max1(view->extent.v[0], view->extent.v[1]));
    if (view->parallel == 0) {
        margin = margin * wide_max1(wide_abs1(depth), wide_splat(view->near_plane));
    }
    clast_wide softness = wide_clamp1(reach + margin, 1e-30f, 1e30f);
    return wide_clamp1(1.0f - (outside - reach) * wide_reciprocal(softness), 0.0f, 1.0f);
}

// edge_seen(); the middle comes last.
CLAST_LANES clast_wide seen_of(const clast_rate_view *view, const seen_point *a, const seen_point *b,
                               const seen_point *m)
{
    clast_wide across[3] = {a->camera.x, b->camera.x, m->camera.x}, up[3] = {a->camera.y, b->camera.y, m->camera.y};
    clast_wide depth[3] = {a->camera.z, b->camera.z, m->camera.z};
    clast_wide outside = view->near_plane - wide_max1(wide_max1(depth[0], depth[1]), depth[2]);
    outside = wide_max1(outside, outside_sides(view, 0, across, depth));
    outside = wide_max1(outside, outside_sides(view, 1, up, depth));
    clast_wide within = wide_splat(1.0f);
    if (!wide_all_at_most(outside, (clast_wide){0})) { // else the reach does not matter
        within = within_of(view, outside, wide_minus3(b->camera, a->camera), depth[2]);
    }
    if (view->faces == 0) {
        return within;
    }
    clast_wide towards = wide_max1(wide_max1(a->facing, b->facing), m->facing);
    return within * wide_clamp1((towards + 0.8f) * 2.0f, 0.0f, 1.0f);
}

// ------------------------------------------------------------------------------------------------------------ occlusion

// edge_place()
typedef struct edge_places {
    uint32_t of[WIDE_LANES]; // where each one's depths begin
    clast_wide depth, softness, radius;
} edge_places;

CLAST_LANES clast_wide over_depth(const clast_rate_view *view, clast_wide depth)
{
    return view->parallel != 0
               ? wide_splat(1.0f)
               : wide_reciprocal(wide_clamp1(wide_max1(depth, wide_splat(view->near_plane)), 1e-30f, 1e30f));
}

CLAST_LANES void place_edges(const clast_rate_view *view, clast_wide across, clast_wide up, edge_places *places)
{
    clast_wide column = wide_clamp1(0.5f * view->places.v[0] + across, 0.0f, (float)view->places_across - 1.0f);
    clast_wide row = wide_clamp1(0.5f * view->places.v[1] - up, 0.0f, (float)view->places_down - 1.0f);
    clast_wide_ints number = wide_to_ints(row) * (int32_t)view->places_across + wide_to_ints(column);
    number *= (int32_t)OCCLUSION_DEPTHS;
    memcpy(places->of, &number, sizeof number);
}

CLAST_LANES edge_places places_of(const clast_rate_view *view, const seen_point *a, const seen_point *b,
                                  const seen_point *m)
{
    edge_places places;
    clast_wide3 chord = wide_minus3(b->camera, a->camera);
    clast_wide3 from_a = wide_minus3(a->camera, m->camera), from_b = wide_minus3(b->camera, m->camera);
    clast_wide square = wide_max1(wide_dot3(chord, chord),
                                  wide_max1(wide_dot3(from_a, from_a), wide_dot3(from_b, from_b)));
    clast_wide ball = root_of_wide(square) + view->deviation, nearest = m->camera.z - ball;
    clast_wide shrink = over_depth(view, m->camera.z), x = m->camera.x * shrink, y = m->camera.y * shrink;
    clast_wide inclined = view->parallel != 0 ? wide_splat(1.0f) : 1.0f + 0.5f * (x * x + y * y);
    const float *by_slope = view->places_by_slope.v;
    clast_wide radius = ball * over_depth(view, nearest) * inclined * max1(by_slope[0], by_slope[1]);
    place_edges(view, x * by_slope[0], y * by_slope[1], &places);
    clast_wide low = wide_splat(view->near_plane), most = wide_splat(1000.0f), zero = wide_splat(0.0f);
    places.depth = wide_pick_less(low, nearest, wide_pick_less(radius, most, nearest, zero), zero);
    places.radius = wide_pick_less(low, nearest, wide_pick_less(radius, most, radius, most), most);
    places.softness = wide_reciprocal(wide_clamp1(0.05f * nearest, 1e-30f, 1e30f));
    return places;
}

// Whether none lies behind even the nearest of its depths: then all are open.
CLAST_LANES bool all_in_front(const float *depths, const edge_places *places)
{
    float first[WIDE_LANES];
    for (int i = 0; i < WIDE_LANES; i++) {
        first[i] = depths[places->of[i]];
    }
    return wide_all_at_most(places->depth, wide_load(first));
}

// clast_rate_open()
CLAST_LANES clast_wide open_of(const float *depths, const edge_places *places)
{
    if (all_in_front(depths, places)) {
        return wide_splat(1.0f);
    }
    clast_wide_columns rows = wide_turn(depths, places->of);
    clast_wide radius = wide_splat(0.0f);
    for (uint32_t i = 0; i < OCCLUSION_DEPTHS; i++) {
        clast_wide behind = wide_clamp1((places->depth - rows.of[i]) * places->softness, 0.0f, 1.0f);
        radius = radius + behind * (float)occlusion_step(i);
    }
    clast_wide margin = 8.0f + 0.5f * places->radius;
    return wide_clamp1(1.0f - (radius - places->radius) * wide_reciprocal(margin), 0.0f, 1.0f);
}

// ------------------------------------------------------------------------------------------------------------- lengths

CLAST_LANES clast_wide pixels_between(const seen_point *a, const seen_point *b)
{
    clast_wide x = a->screen[0] - b->screen[0], y = a->screen[1] - b->screen[1];
    return root_of_wide(x * x + y * y);
}

CLAST_LANES clast_wide length_between(const seen_point *a, const seen_point *b)
{
    clast_wide3 way = wide_minus3(a->camera, b->camera);
    return root_of_wide(wide_dot3(way, way));
}

// edge_sphere()
CLAST_LANES clast_wide sphere_of(const clast_rate_view *view, const seen_point *a, const seen_point *b,
                                 const seen_point *m)
{
    clast_wide size = (length_between(a, m) + length_between(b, m)) * view->pixels;
    if (view->parallel != 0) {
        return size;
    }
    clast_wide nearest = wide_min1(wide_dot3(a->camera, a->camera), wide_dot3(b->camera, b->camera));
    clast_wide square = wide_max1(wide_splat(view->near_plane * view->near_plane), nearest);
    return size * wide_rsqrt(wide_clamp1(square, 1e-36f, 1e36f));
}

// edge_wanted()
CLAST_LANES clast_wide wanted_of(const clast_rate_view *view, const seen_point *a, const seen_point *b,
                                 const seen_point *m)
{
    clast_wide seen = view->looks != 0 ? seen_of(view, a, b, m) : wide_splat(1.0f);
    const float *depths = clast_rate_depths(view);
    if (depths != NULL) {
        edge_places places = places_of(view, a, b, m);
        seen = seen * open_of(depths, &places);
    }
    if (view->metric == CLAST_METRIC_PIXELS) {
        clast_wide shown = (pixels_between(a, m) + pixels_between(b, m)) * view->density;
        if (wide_all_at_most(wide_splat(1.0f), seen)) {
            return shown;
        }
        clast_wide hidden = sphere_of(view, a, b, m) * view->hidden_density;
        return wide_pick_less(seen, wide_splat(1.0f), shown * seen + hidden * (1.0f - seen), shown);
    }
    clast_wide size = view->metric == CLAST_METRIC_SPHERE ? sphere_of(view, a, b, m)
                                                          : length_between(a, m) + length_between(b, m);
    return size * (view->density * seen + view->hidden_density * (1.0f - seen));
}

CLAST_LANES seen_point seen_in(const clast_wide_columns *site)
{
    const clast_wide *of = site->of;
    return (seen_point){{of[RATE_CAMERA], of[RATE_CAMERA + 1], of[RATE_CAMERA + 2]},
                        {of[RATE_SCREEN], of[RATE_SCREEN + 1]},
                        of[RATE_FACING]};
}

// curved_edge_term() of half and half, along one axis; `along` are the rises of the chord over both normals.
CLAST_LANES clast_wide curve_term(clast_wide a, clast_wide b, clast_wide normal_a, clast_wide normal_b,
                                  clast_wide along_a, clast_wide along_b)
{
    clast_wide near_a = ((a + a) + (b - normal_a * along_a)) * 0.333333333f;
    clast_wide near_b = ((b + b) + (a - normal_b * along_b)) * 0.333333333f;
    return near_a * 0.125f + near_b * 0.125f;
}

CLAST_LANES clast_wide3 three_of(const clast_wide_columns *site, int first)
{
    return (clast_wide3){site->of[first], site->of[first + 1], site->of[first + 2]};
}

CLAST_LANES clast_wide3 middle_position(const clast_wide_columns *at, const clast_wide_columns *to, bool curved)
{
    clast_wide3 a = three_of(at, RATE_POSITION), b = three_of(to, RATE_POSITION);
    clast_wide3 sum = {a.x + b.x, a.y + b.y, a.z + b.z};
    if (!curved) {
        return (clast_wide3){sum.x * 0.5f, sum.y * 0.5f, sum.z * 0.5f};
    }
    clast_wide3 na = three_of(at, RATE_NORMAL), nb = three_of(to, RATE_NORMAL);
    clast_wide along_a = wide_dot3(wide_minus3(b, a), na), along_b = wide_dot3(wide_minus3(a, b), nb);
    return (clast_wide3){
        sum.x * 0.125f + curve_term(a.x, b.x, na.x, nb.x, along_a, along_b) * 3.0f,
        sum.y * 0.125f + curve_term(a.y, b.y, na.y, nb.y, along_a, along_b) * 3.0f,
        sum.z * 0.125f + curve_term(a.z, b.z, na.z, nb.z, along_a, along_b) * 3.0f,
    };
}

// Only what edges are measured by in this view.
CLAST_LANES seen_point look_at_middle(const clast_rate_view *view, const clast_rate_edges *edges,
                                      const clast_wide_columns *a, const clast_wide_columns *b, clast_wide height)
{
    clast_wide3 na = three_of(a, RATE_NORMAL), nb = three_of(b, RATE_NORMAL);
    clast_wide3 normal = {(na.x + nb.x) * 0.5f, (na.y + nb.y) * 0.5f, (na.z + nb.z) * 0.5f};
    clast_wide3 position = wide_displaced(middle_position(a, b, edges->curved), normal, height * edges->scale);
    seen_point point = {.camera = to_camera(view, position)};
    if (view->metric == CLAST_METRIC_PIXELS) {
        put_on_screen(view, &point);
    }
    if (view->faces != 0) {
        point.facing = facing_of(view, position, normal);
    }
    return point;
}

// Sixteen edges, or eight; where there are fewer, from the first site to itself.
typedef struct edge_batch {
    uint32_t firsts[WIDE_LANES], seconds[WIDE_LANES]; // where their sites begin among all floats
    clast_wide heights, most;
} edge_batch;

CLAST_LANES void load_edges(const clast_rate_edge *edges, uint32_t count, clast_wide_ints *ends, clast_wide *heights)
{
#if defined(__AVX512F__)
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const uint32_t *words = &edges->ends;
    __m512i early = (__m512i)wide_load_first(words, 2 * count);
    __m512i late = (__m512i)wide_load_first(words + WIDE_LANES, count > 8 ? 2 * count - WIDE_LANES : 0);
    *ends = (clast_wide_ints)_mm512_permutex2var_epi32(early, even, late);
    *heights = (clast_wide)_mm512_permutex2var_epi32(early, _mm512_add_epi32(even, _mm512_set1_epi32(1)), late);
#else
    uint32_t all_ends[WIDE_LANES] = {0};
    float all_heights[WIDE_LANES] = {0};
    for (uint32_t i = 0; i < count && i < WIDE_LANES; i++) {
        all_ends[i] = edges[i].ends;
        all_heights[i] = edges[i].height;
    }
    *ends = wide_load_ints(all_ends);
    *heights = wide_load(all_heights);
#endif
}

CLAST_LANES edge_batch load_batch(const clast_rate_edges *edges, uint32_t first)
{
    enum { SITE_FLOATS = sizeof(clast_rate_site) / sizeof(float) };
    edge_batch batch;
    clast_wide_ints ends, apart = wide_splat_ints(WEIGHT_ONE);
    load_edges(edges->edges + first, edges->count - first, &ends, &batch.heights);
    clast_wide_ints a = ends & wide_splat_ints(255), b = wide_shift_right(ends, 8) & wide_splat_ints(255);
    clast_wide_ints firsts = a * SITE_FLOATS, seconds = b * SITE_FLOATS;
    memcpy(batch.firsts, &firsts, sizeof firsts);
    memcpy(batch.seconds, &seconds, sizeof seconds);
    if (edges->apart != NULL) {
        apart = wide_load_first(edges->apart + first, edges->count - first);
    }
    clast_wide_ints most = apart * (int32_t)PATTERN_SEGMENTS, one = wide_splat_ints(1);
    most = wide_pick_more_ints(a, b, most, wide_pick_more_ints(b, a, most, one));
    batch.most = wide_to_floats(most);
    return batch;
}

CLAST_LANES clast_wide_columns middles_of(const clast_rate_site *middles, uint32_t count)
{
    uint32_t places[WIDE_LANES];
    for (uint32_t i = 0; i < WIDE_LANES; i++) {
        places[i] = wide_rows_together[min_uint(i, count - 1)];
    }
    return wide_turn(middles->of, places);
}

CLAST_LANES clast_wide wanted_of_batch(const clast_rate_view *view, const clast_rate_edges *edges, uint32_t at,
                                       const edge_batch *batch)
{
    clast_wide_columns a = wide_turn(edges->sites->of, batch->firsts), b = wide_turn(edges->sites->of, batch->seconds);
    seen_point first = seen_in(&a), second = seen_in(&b), middle;
    if (edges->middles != NULL) {
        clast_wide_columns m = middles_of(edges->middles + at, edges->count - at);
        middle = seen_in(&m);
    } else {
        middle = look_at_middle(view, edges, &a, &b, batch->heights);
    }
    return wanted_of(view, &first, &second, &middle);
}

void CLAST_KERNEL(clast_rate_edges)(const clast_rate_view *view, const clast_rate_edges *edges, uint32_t *factors)
{
    for (uint32_t first = 0; first < edges->count; first += WIDE_LANES) {
        edge_batch batch = load_batch(edges, first);
        clast_wide wanted = wide_splat(view->density);
        if (view->metric != CLAST_METRIC_FIXED) {
            wanted = wanted_of_batch(view, edges, first, &batch);
        }
        clast_wide rounded = wide_max1(wide_splat(1.0f), wanted + 0.5f);
        clast_wide_ints whole = wide_to_ints(wide_min1(rounded, batch.most));
        uint32_t count = edges->count - first;
        memcpy(factors + first, &whole, (count < WIDE_LANES ? count : WIDE_LANES) * sizeof *factors);
    }
}
