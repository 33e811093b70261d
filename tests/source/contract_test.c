// SPDX-License-Identifier: Apache-2.0
// What source.h promises, for every kind.
#include "source/kinds.h"

#include <string.h>

#include "base/isa.h"
#include "base/thread.h"

static void every_kind_is_tested(void **state)
{
    (void)state;
    assert_int_equal(sizeof kind_cases / sizeof kind_cases[0], clast_source_kind_count);
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        assert_non_null(kind_cases[kind].add);
        assert_non_null(clast_sources[kind]);
        assert_true(strlen(clast_sources[kind]->name) > 0);
    }
}

// ------------------------------------------------------------------------------------------------------- count, emit

// Its counts are those of its template, or of corners that a cluster can have.
static void check_record(const kind_world *world, const clast_cluster_record *record, const uint32_t *words)
{
    if (record_form(*record) == FORM_WHOLE) {
        uint32_t number = record->template_index;
        assert_true(number < clast_template_set_count(world->templates));
        assert_int_equal(record_triangles(*record), clast_template_triangle_count(world->templates, number));
        assert_int_equal(record_vertices(*record), clast_template_vertex_count(world->templates, number));
        return;
    }
    assert_int_equal(record_form(*record), FORM_COMPOSITE);
    assert_in_range(record_triangles(*record), 1, TEMPLATE_TRIANGLES);
    assert_in_range(record_vertices(*record), 3, TEMPLATE_VERTICES);
    uint8_t corners[3 * TEMPLATE_TRIANGLES];
    world->source->corners(world->unit, record, words, corners);
    for (uint32_t i = 0; i < 3 * record_triangles(*record); i++) {
        assert_true(corners[i] < record_vertices(*record));
    }
}

static void check_item(const kind_world *world, const clast_pose *pose, const clast_source_view *view, uint32_t item)
{
    clast_source_count count = world->source->count(world->unit, pose, view, item);
    clast_cluster_record *records = malloc((count.clusters + 1) * sizeof *records);
    memset(records, 0xa5, (count.clusters + 1) * sizeof *records);
    clast_cluster_record untouched = records[count.clusters];
    uint32_t *words = malloc((count.words + 1) * sizeof *words);
    memset(words, 0xa5, (count.words + 1) * sizeof *words);
    world->source->emit(world->unit, pose, view, item, 1000, 500, words, records);
    uint32_t triangles = 0, vertices = 0, blocks = 0;
    for (uint32_t i = 0; i < count.clusters; i++) {
        check_record(world, &records[i], words + (records[i].first_word - 500));
        assert_in_range(records[i].first_word, 500, 500 + count.words);
        triangles += record_triangles(records[i]);
        if (record_form(records[i]) == FORM_COMPOSITE) {
            blocks += (record_triangles(records[i]) + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES;
        }
        assert_true(record_triangles(records[i]) <= world->source->most_triangles);
        if (world->source->resident(world->unit, &records[i]) == NULL) {
            assert_int_equal(records[i].first_vertex, 1000 + vertices);
            vertices += record_vertices(records[i]);
        }
    }
    assert_memory_equal(&records[count.clusters], &untouched, sizeof untouched);
    assert_int_equal(words[count.words], 0xa5a5a5a5u);
    free(words);
    assert_int_equal(triangles, count.triangles);
    assert_int_equal(vertices, count.vertices);
    assert_int_equal(blocks, count.blocks);
    free(records);
}

static void check_items(kind_world *world)
{
    for (uint32_t view = 0; view < KIND_VIEWS; view++) {
        for (uint32_t item = 0; item < world->unit->item_count; item++) {
            check_item(world, &kind_poses[1], &kind_views[view], item);
        }
    }
}

static void emit_writes_what_count_said(void **state)
{
    for_each_kind(state, check_items);
}

// What emit writes from zero on, all of it where there is room, and nothing beyond the room.
static void check_draft(const kind_world *world, const clast_pose *pose, const clast_source_view *view, uint32_t item)
{
    clast_source_count count = world->source->count(world->unit, pose, view, item);
    size_t record_bytes = count.clusters * sizeof(clast_cluster_record), word_bytes = count.words * sizeof(uint32_t);
    clast_cluster_record *emitted = malloc(record_bytes + 1), *drafted = malloc(record_bytes + 1);
    uint32_t *words = malloc(word_bytes + 1), *drafted_words = malloc(word_bytes + 1);
    world->source->emit(world->unit, pose, view, item, 0, 0, words, emitted);
    for (uint32_t missing = 0; missing < 3; missing++) {
        uint32_t records_missing = missing == 1, words_missing = missing == 2;
        if (records_missing > count.clusters || words_missing > count.words) {
            continue;
        }
        memset(drafted, 0xa5, record_bytes + 1);
        memset(drafted_words, 0xa5, word_bytes + 1);
        clast_source_draft draft = {drafted, drafted_words, count.clusters - records_missing,
                                    count.words - words_missing};
        clast_source_count again = world->source->draft(world->unit, pose, view, item, &draft);
        assert_memory_equal(&again, &count, sizeof count);
        if (missing == 0) {
            assert_memory_equal(drafted, emitted, record_bytes);
            assert_memory_equal(drafted_words, words, word_bytes);
        }
        const uint8_t *beyond = (const uint8_t *)(drafted + draft.record_room);
        assert_int_equal(*beyond, 0xa5);
        assert_int_equal(*(const uint8_t *)(drafted_words + draft.word_room), 0xa5);
    }
    free(emitted);
    free(drafted);
    free(words);
    free(drafted_words);
}

static void check_drafts(kind_world *world)
{
    for (uint32_t view = 0; view < KIND_VIEWS && world->source->draft != NULL; view++) {
        for (uint32_t item = 0; item < world->unit->item_count; item++) {
            check_draft(world, &kind_poses[1], &kind_views[view], item);
        }
    }
}

static void drafts_are_what_emit_writes(void **state)
{
    for_each_kind(state, check_drafts);
}

static uint64_t count_triangles(const kind_world *world, const clast_source_view *view)
{
    uint64_t sum = 0;
    for (uint32_t item = 0; item < world->unit->item_count; item++) {
        sum += world->source->count(world->unit, &kind_poses[0], view, item).triangles;
    }
    return sum;
}

static void check_monotone(kind_world *world)
{
    clast_source_view view = kind_views[0];
    uint64_t last = UINT64_MAX;
    for (float rate = 64.0f; rate > 1e-6f; rate *= 0.957603281f) {
        view.rate = rate;
        uint64_t sum = count_triangles(world, &view);
        assert_true(sum <= last);
        last = sum;
    }
    view.rate = CLAST_RATE_LEAST;
    assert_true(count_triangles(world, &view) <= last);
}

static void counts_never_fall_while_the_rate_grows(void **state)
{
    for_each_kind(state, check_monotone);
}

static void check_least(kind_world *world)
{
    clast_source_view least = kind_views[0];
    least.rate = CLAST_RATE_LEAST;
    uint64_t expected = count_triangles(world, &least);
    assert_true(expected > 0);
    for (uint32_t view = 0; view < KIND_VIEWS; view++) {
        least = kind_views[view];
        least.rate = CLAST_RATE_LEAST;
        assert_int_equal(count_triangles(world, &least), expected);
    }
}

static void the_least_rate_gives_the_same_from_everywhere(void **state)
{
    for_each_kind(state, check_least);
}

// ---------------------------------------------------------------------------------------------------- fill, resident

static void check_bounds(kind_world *world)
{
    for (uint32_t pose = 0; pose < KIND_POSES; pose++) {
        clast_box box = world->source->bounds(world->unit, &kind_poses[pose]);
        for (uint32_t view = 0; view < KIND_VIEWS; view++) {
            kind_emission all = kind_emit(world, &kind_poses[pose], &kind_views[view]);
            for (size_t i = 0; i < all.record_count; i++) {
                uint32_t count = record_vertices(all.records[i]);
                const packed3 *vertices = kind_vertices(world, &all, i);
                for (uint32_t v = 0; v < 3 * count; v++) {
                    float value = vertices[v / 3].v[v % 3];
                    assert_true(value >= box.lower.v[v % 3] && value <= box.upper.v[v % 3]);
                }
            }
            kind_emission_free(&all);
        }
    }
}

static void bounds_hold_what_fill_gives(void **state)
{
    for_each_kind(state, check_bounds);
}

static void check_resident(kind_world *world)
{
    kind_emission all = kind_emit(world, &kind_poses[0], &kind_views[0]);
    for (size_t i = 0; i < all.record_count; i++) {
        packed3 filled[TEMPLATE_VERTICES];
        uint32_t count = record_vertices(all.records[i]);
        world->source->fill(world->unit, &kind_poses[0], &all.records[i], all.words + all.records[i].first_word,
                            filled);
        assert_memory_equal(filled, kind_vertices(world, &all, i), count * sizeof *filled);
    }
    kind_emission_free(&all);
}

static void resident_positions_are_those_that_fill_gives(void **state)
{
    for_each_kind(state, check_resident);
}

static void check_composites(kind_world *world)
{
    for (uint32_t view = 0; view < KIND_VIEWS && world->source->fill_composite != NULL; view++) {
        kind_emission all = kind_emit(world, &kind_poses[1], &kind_views[view]);
        for (size_t i = 0; i < all.record_count; i++) {
            const clast_cluster_record *record = &all.records[i];
            if (record_form(*record) != FORM_COMPOSITE) {
                continue;
            }
            const uint32_t *words = all.words + record->first_word;
            packed3 alone[TEMPLATE_VERTICES], together[TEMPLATE_VERTICES];
            uint8_t corners_alone[3 * TEMPLATE_TRIANGLES], corners[3 * TEMPLATE_TRIANGLES];
            world->source->fill(world->unit, &kind_poses[1], record, words, alone);
            world->source->corners(world->unit, record, words, corners_alone);
            world->source->fill_composite(world->unit, &kind_poses[1], record, words, together, corners);
            assert_memory_equal(together, alone, record_vertices(*record) * sizeof *alone);
            assert_memory_equal(corners, corners_alone, 3 * (size_t)record_triangles(*record));
        }
        kind_emission_free(&all);
    }
}

static void composites_are_filled_as_in_two_steps(void **state)
{
    for_each_kind(state, check_composites);
}

// -------------------------------------------------------------------------------------------------- locate, evaluate

static float distance3(vec3 a, vec3 b)
{
    return length3(a - b);
}

static void check_point(const kind_world *world, const clast_cluster_record *record, const uint32_t *words,
                        const packed3 *vertices, uint32_t triangle, vec2 at, float tolerance)
{
    uint32_t corners[3];
    kind_corners(world, record, words, triangle, corners);
    vec3 expected = load3(vertices[corners[0]]) * (1.0f - at[0] - at[1]) + load3(vertices[corners[1]]) * at[0] +
                    load3(vertices[corners[2]]) * at[1];
    clast_surface_point point = world->source->locate(world->unit, &kind_poses[1], record, words, triangle, at);
    clast_source_surface surface = world->source->evaluate(world->unit, &kind_poses[1], point);
    assert_true(distance3(surface.position, expected) <= tolerance);
}

static void check_locate(kind_world *world)
{
    float chord = kind_cases[world->unit->kind].chord;
    for (uint32_t view = 0; view < KIND_VIEWS; view++) {
        kind_emission all = kind_emit(world, &kind_poses[1], &kind_views[view]);
        for (size_t i = 0; i < all.record_count; i++) {
            const clast_cluster_record *record = &all.records[i];
            const uint32_t *words = all.words + record->first_word;
            const packed3 *vertices = kind_vertices(world, &all, i);
            for (uint32_t t = 0; t < record_triangles(*record); t++) {
                check_point(world, record, words, vertices, t, vec2(0.0f, 0.0f), 1e-4f);
                check_point(world, record, words, vertices, t, vec2(1.0f, 0.0f), 1e-4f);
                check_point(world, record, words, vertices, t, vec2(0.0f, 1.0f), 1e-4f);
                if (view == 2) { // from within, so at the finest
                    check_point(world, record, words, vertices, t, vec2(0.25f, 0.4f), chord);
                }
            }
        }
        kind_emission_free(&all);
    }
}

static void located_points_lie_on_their_triangles(void **state)
{
    for_each_kind(state, check_locate);
}

static void check_normals(kind_world *world)
{
    kind_emission all = kind_emit(world, &kind_poses[1], &kind_views[2]);
    for (size_t i = 0; i < all.record_count; i++) {
        const packed3 *vertices = kind_vertices(world, &all, i);
        for (uint32_t t = 0; t < record_triangles(all.records[i]); t++) {
            uint32_t c[3];
            kind_corners(world, &all.records[i], all.words + all.records[i].first_word, t, c);
            vec3 origin = load3(vertices[c[0]]);
            vec3 normal = cross3(load3(vertices[c[1]]) - origin, load3(vertices[c[2]]) - origin);
            if (length3(normal) < 1e-6f) {
                continue; // degenerate at a pole
            }
            clast_surface_point point = world->source->locate(world->unit, &kind_poses[1], &all.records[i],
                                                              all.words + all.records[i].first_word, t,
                                                              vec2(0.3f, 0.3f));
            clast_source_surface surface = world->source->evaluate(world->unit, &kind_poses[1], point);
            assert_true(dot3(normalize3(surface.geometric_normal), normalize3(normal)) > 0.9f);
            assert_true(dot3(normalize3(surface.normal), normalize3(normal)) > 0.9f);
        }
    }
    kind_emission_free(&all);
}

static void normals_point_to_the_counter_clockwise_side(void **state)
{
    for_each_kind(state, check_normals);
}

// ------------------------------------------------------------------------------------------------------------ purity

typedef struct thread_job {
    const kind_world *world;
    const kind_emission *expected;
    kind_emission got;
} thread_job;

static void emit_item(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    thread_job *job = data;
    const kind_world *world = job->world;
    for (size_t item = begin; item < end; item++) {
        uint32_t first = job->expected->firsts[item];
        clast_source_count count = world->source->count(world->unit, &kind_poses[1], &kind_views[0], (uint32_t)item);
        world->source->emit(world->unit, &kind_poses[1], &kind_views[0], (uint32_t)item,
                            job->expected->records[first].first_vertex, job->expected->first_words[item],
                            job->got.words + job->expected->first_words[item], job->got.records + first);
        for (uint32_t i = first; i < first + count.clusters; i++) {
            if (world->source->resident(world->unit, &job->got.records[i]) == NULL) {
                world->source->fill(world->unit, &kind_poses[1], &job->got.records[i],
                                    job->got.words + job->got.records[i].first_word,
                                    job->got.vertices + job->got.records[i].first_vertex);
            }
        }
    }
}

static void check_purity(kind_world *world)
{
    kind_emission first = kind_emit(world, &kind_poses[1], &kind_views[0]);
    kind_emission other = kind_emit(world, &kind_poses[2], &kind_views[3]);
    kind_emission again = kind_emit(world, &kind_poses[1], &kind_views[0]);
    assert_int_equal(first.record_count, again.record_count);
    assert_memory_equal(first.records, again.records, first.record_count * sizeof *first.records);
    assert_memory_equal(first.vertices, again.vertices, first.vertex_count * sizeof *first.vertices);
    memset(again.records, 0, again.record_count * sizeof *again.records);
    memset(again.vertices, 0, again.vertex_count * sizeof *again.vertices);
    memset(again.words, 0, again.word_count * sizeof *again.words);
    thread_job job = {world, &first, again};
    clast_parallel_for(world->context, world->unit->item_count, 1, emit_item, &job);
    assert_memory_equal(first.records, again.records, first.record_count * sizeof *first.records);
    assert_memory_equal(first.vertices, again.vertices, first.vertex_count * sizeof *first.vertices);
    kind_emission_free(&first);
    kind_emission_free(&other);
    kind_emission_free(&again);
}

static void the_same_question_gets_the_same_bits_on_any_thread(void **state)
{
    for_each_kind(state, check_purity);
}

static void assert_same_emission(const kind_world *a, const kind_world *b, const clast_source_view *view)
{
    kind_emission first = kind_emit(a, &kind_poses[1], view), second = kind_emit(b, &kind_poses[1], view);
    assert_int_equal(first.record_count, second.record_count);
    assert_memory_equal(first.records, second.records, first.record_count * sizeof *first.records);
    assert_memory_equal(first.vertices, second.vertices, first.vertex_count * sizeof *first.vertices);
    assert_memory_equal(first.words, second.words, first.word_count * sizeof *first.words);
    for (size_t i = 0; i < first.record_count; i++) {
        const clast_cluster_record *record = &first.records[i];
        if (record_form(*record) == FORM_COMPOSITE) {
            uint8_t corners[2][3 * TEMPLATE_TRIANGLES];
            a->source->corners(a->unit, record, first.words + record->first_word, corners[0]);
            b->source->corners(b->unit, record, second.words + record->first_word, corners[1]);
            assert_memory_equal(corners[0], corners[1], 3 * (size_t)record_triangles(*record));
        }
    }
    kind_emission_free(&first);
    kind_emission_free(&second);
}

static void instruction_sets_do_not_matter(void **state)
{
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        kind_world best = kind_open(*state, (clast_source_kind)kind);
        for (uint32_t isa = CLAST_ISA_PLAIN; isa < (uint32_t)clast_isa_best(); isa++) {
            clast_context *context;
            clast_context_desc desc = {.threads = 1, .isa = (clast_isa)isa};
            assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
            kind_world other = kind_open(context, (clast_source_kind)kind);
            for (uint32_t view = 0; view < KIND_VIEWS; view++) {
                assert_same_emission(&best, &other, &kind_views[view]);
            }
            kind_close(&other);
            clast_context_destroy(context);
        }
        kind_close(&best);
    }
}

static void check_changed(kind_world *world)
{
    for (uint32_t i = 0; i < KIND_VIEWS; i++) {
        for (uint32_t j = 0; j < KIND_VIEWS; j++) {
            clast_change change = world->source->changed(world->unit, &kind_poses[0], &kind_views[i], &kind_poses[1],
                                                         &kind_views[j]);
            kind_emission before = kind_emit(world, &kind_poses[0], &kind_views[i]);
            kind_emission now = kind_emit(world, &kind_poses[1], &kind_views[j]);
            if (change < CLAST_CHANGE_TOPOLOGY) {
                assert_int_equal(before.record_count, now.record_count);
                assert_memory_equal(before.records, now.records, now.record_count * sizeof *now.records);
            }
            if (change == CLAST_CHANGE_NOTHING) {
                assert_memory_equal(before.vertices, now.vertices, now.vertex_count * sizeof *now.vertices);
            }
            kind_emission_free(&before);
            kind_emission_free(&now);
        }
    }
    assert_int_equal(
        world->source->changed(world->unit, &kind_poses[1], &kind_views[0], &kind_poses[1], &kind_views[0]),
        CLAST_CHANGE_NOTHING);
}

static void what_is_said_not_to_change_does_not(void **state)
{
    for_each_kind(state, check_changed);
}

// ------------------------------------------------------------------------------------------------------------ others

static void check_primitives(kind_world *world)
{
    clast_box box = world->source->bounds(world->unit, &kind_poses[0]);
    for (uint32_t i = 0; i < world->source->primitive_count(world->unit); i++) {
        vec3 corners[3];
        world->source->primitive_corners(world->unit, &kind_poses[0], i, corners);
        for (uint32_t k = 0; k < 9; k++) {
            float value = corners[k / 3][k % 3];
            assert_true(value >= box.lower.v[k % 3] && value <= box.upper.v[k % 3]);
        }
        clast_source_surface surface = world->source->evaluate(world->unit, &kind_poses[0],
                                                               (clast_surface_point){.primitive = i});
        assert_true(distance3(surface.position, corners[0]) <= 1e-6f);
        assert_int_equal(surface.material, world->source->primitive_material(world->unit, i));
    }
}

static void primitives_are_corners_and_material_of_the_surface(void **state)
{
    for_each_kind(state, check_primitives);
}

static void check_unit(kind_world *world)
{
    assert_true(world->unit->material_count == 1 && world->unit->materials[0] == 0);
    assert_true(world->unit->bytes > 0);
    clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST];
    uint32_t count = world->source->arrays(world->unit, arrays);
    assert_true(count > 0 && count <= CLAST_SOURCE_ARRAYS_MOST);
    uint32_t held = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (arrays[i].bytes != 0) {
            assert_non_null(arrays[i].data);
            assert_true(strlen(arrays[i].name) > 0);
            held++;
        }
    }
    assert_true(held > 0);
}

static void units_say_what_they_hold(void **state)
{
    for_each_kind(state, check_unit);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_is_tested),
        CONTEXT_TEST(emit_writes_what_count_said),
        CONTEXT_TEST(drafts_are_what_emit_writes),
        CONTEXT_TEST(counts_never_fall_while_the_rate_grows),
        CONTEXT_TEST(the_least_rate_gives_the_same_from_everywhere),
        CONTEXT_TEST(bounds_hold_what_fill_gives),
        CONTEXT_TEST(resident_positions_are_those_that_fill_gives),
        CONTEXT_TEST(composites_are_filled_as_in_two_steps),
        CONTEXT_TEST(located_points_lie_on_their_triangles),
        CONTEXT_TEST(normals_point_to_the_counter_clockwise_side),
        CONTEXT_TEST(the_same_question_gets_the_same_bits_on_any_thread),
        CONTEXT_TEST(instruction_sets_do_not_matter),
        CONTEXT_TEST(what_is_said_not_to_change_does_not),
        CONTEXT_TEST(primitives_are_corners_and_material_of_the_surface),
        CONTEXT_TEST(units_say_what_they_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
