// SPDX-License-Identifier: Apache-2.0
// Displaced meshes have no cracks: where two triangles meet, both have the same points there, to the bit. So in a closed mesh
// each side of a triangle, told by the bits of its ends, is another's side the other way round: whatever the rates, splits,
// seams and maps.
#include <string.h>

#include "shared/occlusion.h"
#include "source/displaced_worlds.h"

enum { TRIANGLES_MOST = 300000, VIEWS = 24 };

// ------------------------------------------------------------------------------------------------------------- sides

typedef struct side {
    packed3 ends[2]; // the lower one first, by its bits
    int32_t balance; // how often one way, less how often the other
    bool used;
} side;

typedef struct sides {
    side *slots;
    size_t size; // a power of two
} sides;

static packed3 without_signs_of_zero(packed3 point)
{
    for (int axis = 0; axis < 3; axis++) {
        assert_true(isfinite(point.v[axis]));
        point.v[axis] = unsigned_zero(point.v[axis]);
    }
    return point;
}

static uint64_t hash_point(uint64_t hash, packed3 point)
{
    uint32_t bits[3];
    memcpy(bits, point.v, sizeof bits);
    for (int axis = 0; axis < 3; axis++) {
        hash = (hash ^ bits[axis]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return hash;
}

static void add_side(sides *all, packed3 a, packed3 b)
{
    a = without_signs_of_zero(a);
    b = without_signs_of_zero(b);
    int order = memcmp(&a, &b, sizeof a);
    if (order == 0) {
        return;
    }
    side wanted = {.ends = {order < 0 ? a : b, order < 0 ? b : a}, .used = true};
    size_t place = (size_t)hash_point(hash_point(1, wanted.ends[0]), wanted.ends[1]);
    side *slot;
    while ((slot = &all->slots[place++ & (all->size - 1)])->used &&
           memcmp(slot->ends, wanted.ends, sizeof slot->ends) != 0) {
    }
    if (!slot->used) {
        *slot = wanted;
    }
    slot->balance += order < 0 ? 1 : -1;
}

static uint32_t open_sides(const sides *all)
{
    uint32_t open = 0;
    for (size_t i = 0; i < all->size; i++) {
        const side *s = &all->slots[i];
        if (s->balance != 0 && open++ < 3) {
            print_message("open: (%.9g %.9g %.9g) (%.9g %.9g %.9g) %d\n", (double)s->ends[0].v[0],
                          (double)s->ends[0].v[1], (double)s->ends[0].v[2], (double)s->ends[1].v[0],
                          (double)s->ends[1].v[1], (double)s->ends[1].v[2], s->balance);
        }
    }
    return open;
}

// What a pose and a view came to.
typedef struct outcome {
    uint64_t triangles;
    uint32_t whole, composite, split, open; // records of each form, and those that have parts of split triangles
} outcome;

static void add_record(const kind_world *world, const kind_emission *all, size_t number, sides *to, outcome *sum)
{
    const clast_cluster_record *record = &all->records[number];
    const uint32_t *words = all->words + record->first_word;
    const packed3 *vertices = kind_vertices(world, all, number);
    for (uint32_t i = 0; i < record_triangles(*record); i++) {
        uint32_t corners[3];
        kind_corners(world, record, words, i, corners);
        for (uint32_t k = 0; k < 3; k++) {
            add_side(to, vertices[corners[k]], vertices[corners[(k + 1) % 3]]);
        }
    }
    sum->triangles += record_triangles(*record);
    sum->whole += record_form(*record) == FORM_WHOLE;
    sum->composite += record_form(*record) == FORM_COMPOSITE;
    for (uint32_t i = 0; i < record->detail; i++) {
        if ((words[1 + i] >> DISPLACED_LEAF_SPLIT_BIT & 1) != 0) {
            sum->split++;
            break;
        }
    }
}

static uint64_t wanted_triangles(const kind_world *world, const clast_pose *pose, const clast_source_view *view)
{
    uint64_t sum = 0;
    for (uint32_t item = 0; item < world->unit->item_count; item++) {
        sum += world->source->count(world->unit, pose, view, item).triangles;
    }
    return sum;
}

static outcome look(const kind_world *world, const clast_pose *pose, const clast_source_view *view)
{
    outcome sum = {0};
    uint64_t triangles = wanted_triangles(world, pose, view);
    if (triangles > TRIANGLES_MOST) {
        return sum;
    }
    sides all = {.size = 1024};
    while (all.size < 4 * triangles) {
        all.size *= 2;
    }
    all.slots = calloc(all.size, sizeof *all.slots);
    assert_non_null(all.slots);
    kind_emission emission = kind_emit(world, pose, view);
    for (size_t i = 0; i < emission.record_count; i++) {
        add_record(world, &emission, i, &all, &sum);
    }
    sum.open = open_sides(&all);
    kind_emission_free(&emission);
    free(all.slots);
    return sum;
}

static void add_outcome(outcome *to, outcome one)
{
    to->triangles += one.triangles;
    to->whole += one.whole;
    to->composite += one.composite;
    to->split += one.split;
    to->open += one.open;
}

// Something hides parts of the picture, now and then: depths of places, which never fall.
static void hide_some(clast_source_view *view, numbers *random)
{
    enum { ACROSS = 32, DOWN = 18 };
    static float depths[ACROSS * DOWN][OCCLUSION_DEPTHS];
    float far_away = sqrtf(dot3(load3(view->eye), load3(view->eye))) + 2.0f;
    for (uint32_t i = 0; i < ACROSS * DOWN; i++) {
        float depth = far_away * fabsf(next_number(random));
        for (uint32_t k = 0; k < OCCLUSION_DEPTHS; k++) {
            depths[i][k] = depth;
            depth += next_number(random) > 0.8f ? 0.2f * far_away : 0.0f;
        }
    }
    view->places = (packed2){{ACROSS, DOWN}};
    view->places_across = ACROSS;
    view->places_down = DOWN;
    view->depths = store_address((uint64_t)(uintptr_t)depths);
}

static outcome look_from_many_places(const kind_world *world, const clast_pose *pose, uint32_t views)
{
    outcome sum = {0};
    numbers random = {99};
    for (uint32_t i = 0; i < views; i++) {
        clast_source_view view = random_view(&random, i);
        if (i % 3 == 1) {
            hide_some(&view, &random);
        }
        outcome one = look(world, pose, &view);
        if (one.open != 0) {
            print_message("view %u: %u of %llu sides are open\n", i, one.open,
                          (unsigned long long)one.triangles * 3 / 2);
        }
        add_outcome(&sum, one);
    }
    return sum;
}

static void assert_closed(outcome sum)
{
    assert_int_equal(sum.open, 0);
    assert_true(sum.whole > 0 && sum.composite > 0 && sum.split > 0); // all there is was seen
}

// ------------------------------------------------------------------------------------------------------ closed meshes

static void a_sphere_is_closed_from_everywhere(void **state)
{
    shape s = shape_sphere(12, 7);
    for (int curved = 0; curved < 2; curved++) {
        kind_world world = world_of(*state, &s.mesh, 0.3f, curved != 0);
        assert_closed(look_from_many_places(&world, &at_rest, VIEWS));
        kind_close(&world);
    }
    shape_free(&s);
}

static void hard_edges_and_seams_are_closed(void **state)
{
    box_mesh box;
    box_mesh_make(&box);
    for (int i = 0; i < 4; i++) {
        box.mesh.normals = i % 2 == 0 ? box.normals[0] : NULL;
        kind_world world = world_of(*state, &box.mesh, 0.4f, i >= 2);
        assert_closed(look_from_many_places(&world, &at_rest, VIEWS));
        kind_close(&world);
    }
}

static void triangles_that_share_nothing_but_positions_are_closed(void **state)
{
    shape s = shape_sphere(10, 8);
    for (int i = 0; i < 4; i++) {
        loose l = loosen(&s.mesh, i % 2 == 0);
        kind_world world = world_of(*state, &l.mesh, 0.3f, i >= 2);
        assert_closed(look_from_many_places(&world, &at_rest, VIEWS));
        kind_close(&world);
        loose_free(&l);
    }
    shape_free(&s);
}

// A spike: its foot has few segments, its sides are split many times.
static void split_triangles_meet_those_that_are_not_split(void **state)
{
    clast_mesh mesh = spike_mesh(broad_spike);
    kind_world world = world_of(*state, &mesh, 0.5f, false);
    clast_source_view view = view_from(vec3(0, 0, 20), vec3(0, 0, 0), 100.0f);
    view.metric = CLAST_METRIC_LENGTH;
    outcome sum = {0};
    for (float segment = 8.0f; segment > 0.2f; segment *= 0.93f) {
        view.segment = segment;
        add_outcome(&sum, look(&world, &at_rest, &view));
    }
    assert_int_equal(sum.open, 0);
    assert_true(sum.split > 0 && sum.composite > 0);
    kind_close(&world);
}

// A needle, cut down to the last unit of the weights.
static void parts_as_small_as_weights_tell_apart_are_closed(void **state)
{
    clast_mesh mesh = spike_mesh(needle);
    kind_world world = world_of(*state, &mesh, 0.001f, false);
    clast_source_view view = view_from(vec3(0, 0, 20), vec3(0, 0, 0), 100.0f);
    view.metric = CLAST_METRIC_LENGTH;
    view.segment = 0.012f;
    outcome one = look(&world, &at_rest, &view);
    assert_int_equal(one.open, 0);
    assert_in_range(one.triangles, 3 * 32768, TRIANGLES_MOST);
    kind_close(&world);
}

// What a budget does to a frame: the rate falls by steps until all fits.
static void each_step_of_the_ladder_is_closed(void **state)
{
    shape s = shape_sphere(9, 6);
    loose l = loosen(&s.mesh, true);
    kind_world world = world_of(*state, &l.mesh, 0.3f, false);
    clast_source_view view = view_from(vec3(0.2f, 0.4f, 2.1f), vec3(0, 0, 0), 300.0f);
    uint64_t last = UINT64_MAX;
    for (uint32_t step = 0; step <= 160; step++) {
        view.rate = step < 160 ? exp2f(-(float)step / RATE_STEPS) : CLAST_RATE_LEAST;
        outcome one = look(&world, &at_rest, &view);
        assert_int_equal(one.open, 0);
        assert_in_range(one.triangles, 1, last);
        last = one.triangles;
    }
    assert_int_equal(last, l.mesh.triangle_count);
    kind_close(&world);
    loose_free(&l);
    shape_free(&s);
}

// Points that were at one place stay there, wherever their vertices went: one of them says where.
static void meshes_that_move_stay_closed(void **state)
{
    shape s = shape_sphere(10, 6);
    loose l = loosen(&s.mesh, true);
    kind_world world = world_of(*state, &l.mesh, 0.3f, false);
    packed3 *positions = malloc(l.mesh.vertex_count * sizeof *positions);
    packed3 *normals = malloc(l.mesh.vertex_count * sizeof *normals);
    numbers random = {5};
    outcome sum = {0};
    for (uint32_t pose = 1; pose <= 4; pose++) {
        for (uint32_t i = 0; i < l.mesh.vertex_count; i++) {
            for (uint32_t axis = 0; axis < 3; axis++) {
                positions[i].v[axis] = l.positions[3 * i + axis] + 0.1f * (float)pose * next_number(&random);
                normals[i].v[axis] = next_number(&random);
            }
        }
        clast_pose moved = {
            .shape = pose,
            .positions = positions,
            .normals = pose % 2 == 0 ? normals : NULL,
            .displacement_scale = -0.5f * (float)pose,
        };
        add_outcome(&sum, look_from_many_places(&world, &moved, VIEWS / 2));
    }
    assert_closed(sum);
    free(positions);
    free(normals);
    kind_close(&world);
    loose_free(&l);
    shape_free(&s);
}

// -------------------------------------------------------------------------------------------------------------- pairs

// Two triangles with an edge in common, of which nothing else is: `first` and `second` are the corners where it begins in
// each; `along` where both go along it the same way.
typedef struct pair {
    float positions[6][3], normals[6][3], coordinates[6][2];
    uint32_t indices[6], materials[2];
} pair;

static clast_mesh make_pair(pair *p, uint32_t first, uint32_t second, bool along)
{
    static const float places[4][3] = {
        {0.1f, 0.2f, 0.3f}, {1.3f, -0.4f, 0.2f}, {0.4f, 1.1f, -0.3f}, {0.7f, -1.3f, 0.8f}};
    uint32_t place[6];
    place[first] = 0;
    place[(first + 1) % 3] = 1;
    place[(first + 2) % 3] = 2;
    place[3 + second] = along ? 0 : 1;
    place[3 + (second + 1) % 3] = along ? 1 : 0;
    place[3 + (second + 2) % 3] = 3;
    numbers random = {first * 3 + second + 1};
    for (uint32_t i = 0; i < 6; i++) {
        memcpy(p->positions[i], places[place[i]], sizeof p->positions[i]);
        vec3 normal = normalize3(vec3(next_number(&random), next_number(&random), 2.0f));
        for (uint32_t axis = 0; axis < 3; axis++) {
            p->normals[i][axis] = normal[axis];
        }
        p->coordinates[i][0] = next_number(&random);
        p->coordinates[i][1] = next_number(&random);
        p->indices[i] = i;
        p->materials[i / 3] = i / 3;
    }
    clast_mesh mesh = {.vertex_count = 6, .triangle_count = 2, .positions = p->positions[0], .indices = p->indices};
    mesh.normals = p->normals[0];
    mesh.coordinates[0] = p->coordinates[0];
    mesh.triangle_materials = p->materials;
    mesh.material = CLAST_NONE;
    return mesh;
}

// The points of an edge of one triangle of a pair, from corner `edge` on, where its edges have these segments.
static void edge_points(const kind_world *world, uint32_t triangle, const uint32_t factors[3], uint32_t edge,
                        packed3 points[PATTERN_SEGMENTS + 1])
{
    const displaced_unit *unit = clast_displaced_of(world->unit);
    const displaced_cluster *cluster = &unit->clusters[0];
    uint32_t levels = displaced_level_words(unit, cluster), words[CLUSTER_VERTICES] = {0};
    for (uint32_t i = 0; i < levels; i++) {
        words[i] = (40 + 90 * i) | (300 - 50 * i) << 16;
    }
    uint32_t packed = pattern_factors(factors[0], factors[1], factors[2]);
    displaced_pattern use = displaced_pattern_of(unit, packed);
    words[levels] = levels;
    words[levels + 1] = triangle | packed << DISPLACED_LEAF_TRIANGLE_BITS;
    clast_cluster_record record = {
        .template_index = unit->first_pattern + use.number,
        .form_and_counts = form_and_counts(FORM_WHOLE, pattern_triangles(*use.pattern), pattern_vertices(*use.pattern)),
        .detail = 1,
    };
    packed3 vertices[PATTERN_VERTICES];
    world->source->fill(world->unit, &at_rest, &record, words + levels, vertices);
    uint32_t own = (edge + 3 - use.rotation) % 3;
    uint32_t begin = pattern_edge_begin(pattern_own_factors(*use.pattern), own);
    for (uint32_t step = 0; step <= factors[edge]; step++) {
        points[step] = vertices[step == 0 ? own : step == factors[edge] ? (own + 1) % 3 : begin + step - 1];
    }
}

// Whatever the other edges of both have, in the corners' order of the mesh's triangles.
static void check_pair(const kind_world *world, uint32_t triangle, uint32_t edge, uint32_t segments, bool turned,
                       const packed3 expected[PATTERN_SEGMENTS + 1])
{
    for (uint32_t i = 0; i < PATTERN_SEGMENTS * PATTERN_SEGMENTS; i++) {
        uint32_t factors[3];
        factors[edge] = segments;
        factors[(edge + 1) % 3] = i % PATTERN_SEGMENTS + 1;
        factors[(edge + 2) % 3] = i / PATTERN_SEGMENTS + 1;
        packed3 points[PATTERN_SEGMENTS + 1];
        edge_points(world, triangle, factors, edge, points);
        for (uint32_t step = 0; step <= segments; step++) {
            assert_memory_equal(&points[step], &expected[turned ? segments - step : step], sizeof *points);
        }
    }
}

// Where the cooked cluster has the edge from place 0 to place 1 of the pair: triangles and corners may come in another order.
static uint32_t find_edge(const displaced_unit *unit, uint32_t triangle)
{
    const displaced_triangle *other = &unit->triangles[1 - triangle];
    displaced_triangle own = unit->triangles[triangle];
    for (uint32_t k = 0; k < 3; k++) {
        for (uint32_t m = 0; m < 3; m++) {
            if (displaced_edge_of(own, k) == displaced_edge_of(*other, m)) {
                return k;
            }
        }
    }
    fail();
    return 0;
}

static void every_two_patterns_meet_on_their_edge(void **state)
{
    for (uint32_t i = 0; i < 18; i++) {
        pair p;
        clast_mesh mesh = make_pair(&p, i % 3, i / 3 % 3, i >= 9);
        kind_world world = world_of(*state, &mesh, 0.5f, i % 4 == 3);
        const displaced_unit *unit = clast_displaced_of(world.unit);
        assert_int_equal(unit->base.item_count, 1);
        uint32_t first = find_edge(unit, 0), second = find_edge(unit, 1);
        bool turned = displaced_corner(unit->triangles[0], first) != displaced_corner(unit->triangles[1], second);
        assert_int_equal(turned, i < 9);
        for (uint32_t segments = 1; segments <= PATTERN_SEGMENTS; segments++) {
            packed3 expected[PATTERN_SEGMENTS + 1];
            uint32_t factors[3] = {1, 1, 1};
            factors[first] = segments;
            edge_points(&world, 0, factors, first, expected);
            check_pair(&world, 0, first, segments, false, expected);
            check_pair(&world, 1, second, segments, turned, expected);
        }
        kind_close(&world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(every_two_patterns_meet_on_their_edge),
        CONTEXT_TEST(a_sphere_is_closed_from_everywhere),
        CONTEXT_TEST(hard_edges_and_seams_are_closed),
        CONTEXT_TEST(triangles_that_share_nothing_but_positions_are_closed),
        CONTEXT_TEST(split_triangles_meet_those_that_are_not_split),
        CONTEXT_TEST(parts_as_small_as_weights_tell_apart_are_closed),
        CONTEXT_TEST(each_step_of_the_ladder_is_closed),
        CONTEXT_TEST(meshes_that_move_stay_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
