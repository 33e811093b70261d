// SPDX-License-Identifier: Apache-2.0
// Budgets from the least upward: every frame is closed, keeps what it was given, says so, and is the same each time.
#include "frame/stage.h"

#include <string.h>

// A bumpy sphere, a waving sheet and a plain sphere.
static stage open_rich(clast_context *context)
{
    stage s = stage_open(context);
    uint32_t bumpy = shape_add_sphere(context, s.scene, 12, 7);
    shape_displace(context, s.scene, bumpy, 0, 0.1f);
    shape_add_instance(context, s.scene, bumpy, 0, 1, 4, 1);
    shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 6), 0, -1, 0, 1);
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 10, 10), -2, 1, 0, 1);
    s.frame->settings.segment = 6.0;
    return s;
}

// ------------------------------------------------------------------------------------------------------------ closed

static uint64_t mix(uint64_t hash, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        hash = (hash ^ ((const uint8_t *)data)[i]) * 0x100000001b3u;
    }
    return hash ^ hash >> 29;
}

// A number of a side, with a sign for its direction: those of the same side both ways add up to nothing.
static uint64_t side_number(const float *a, const float *b)
{
    float ends[2][3];
    for (int axis = 0; axis < 3; axis++) {
        ends[0][axis] = unsigned_zero(a[axis]);
        ends[1][axis] = unsigned_zero(b[axis]);
    }
    int order = memcmp(ends[0], ends[1], sizeof ends[0]);
    if (order == 0) {
        return 0;
    }
    uint64_t hash = mix(mix(1469598103934665603u, ends[order < 0 ? 0 : 1], 12), ends[order < 0 ? 1 : 0], 12);
    return order < 0 ? hash : (uint64_t)0 - hash;
}

// The sheet ends somewhere.
static bool is_on_rim(const float *p)
{
    return fabsf(p[0]) > 4.9999f || fabsf(p[2]) > 4.9999f;
}

static void assert_closed(const clast_frame_unit *unit)
{
    bool sheet = unit->unit->kind == CLAST_SOURCE_WAVE;
    uint64_t sum = 0;
    for (size_t r = 0; r < unit->record_count; r++) {
        for (uint32_t t = 0; t < record_triangles(unit->records[r]); t++) {
            float corners[3][3];
            assert_true(clast_clas_corners(unit->clas, r, t, corners));
            for (int k = 0; k < 3; k++) {
                const float *a = corners[k], *b = corners[(k + 1) % 3];
                sum += sheet && is_on_rim(a) && is_on_rim(b) ? 0 : side_number(a, b);
            }
        }
    }
    assert_true(sum == 0);
}

static void check_frame(const clast_frame *frame)
{
    uint64_t triangles = 0, clusters = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        const clast_frame_unit *unit = &frame->units[i];
        assert_closed(unit);
        clusters += unit->record_count;
        for (size_t r = 0; r < unit->record_count; r++) {
            triangles += record_triangles(unit->records[r]);
        }
    }
    assert_int_equal(triangles, frame->granted.triangles);
    assert_int_equal(clusters, frame->granted.clusters);
    assert_int_equal(triangles, frame->triangles);
    clast_frame_bytes bytes = clast_frame_count_bytes(frame);
    assert_true(bytes.records + bytes.vertices + bytes.clas + bytes.blas <= frame->granted.bytes ||
                frame->settings.max_bytes == 0);
}

static uint64_t hash_frame(const clast_frame *frame)
{
    uint64_t hash = 1;
    for (size_t i = 0; i < frame->unit_count; i++) {
        const clast_frame_unit *unit = &frame->units[i];
        hash = mix(hash, unit->records, unit->record_count * sizeof *unit->records);
        hash = mix(hash, unit->words, unit->word_count * sizeof *unit->words);
        hash = mix(hash, unit->vertices, unit->vertex_count * sizeof *unit->vertices);
    }
    return hash;
}

static uint64_t hash_of_fresh_frame(stage *s)
{
    clast_frame *fresh = stage_add_frame(s);
    fresh->settings = s->frame->settings;
    assert_ok(s->context, clast_frame_run(fresh, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    uint64_t hash = hash_frame(fresh);
    clast_frame_destroy(fresh);
    return hash;
}

// ------------------------------------------------------------------------------------------------------------ sweeps

static void frames_are_closed_and_honest_at_any_budget_of_triangles(void **state)
{
    stage s = open_rich(*state);
    stage_run(&s);
    check_frame(s.frame);
    clast_frame_need all = s.frame->wanted, least = s.frame->minimum;
    assert_true(all.triangles > 10 * least.triangles);
    int steps = 0;
    for (uint64_t budget = least.triangles; budget < all.triangles; budget += budget / 8, steps++) {
        s.frame->settings.max_triangles = budget;
        stage_run(&s);
        check_frame(s.frame);
        assert_true(s.frame->triangles <= budget);
        assert_int_equal(s.frame->bound, CLAST_BOUND_TRIANGLES);
        if (steps % 4 == 0) {
            assert_true(hash_frame(s.frame) == hash_of_fresh_frame(&s));
        }
    }
    assert_true(steps > 15);
    s.frame->settings.max_triangles = all.triangles;
    stage_run(&s);
    assert_true(s.frame->fitted_rate == 1.0f && s.frame->bound == CLAST_BOUND_NONE);
    s.frame->settings.max_triangles = least.triangles - 1;
    assert_int_equal(stage_try(&s), CLAST_ERROR_BUDGET);
    stage_close(&s);
}

static void frames_keep_any_bound_of_memory(void **state)
{
    stage s = open_rich(*state);
    stage_run(&s);
    uint64_t all = s.frame->wanted.bytes;
    for (uint64_t budget = s.frame->minimum.bytes; budget < all; budget += budget / 4) {
        s.frame->settings.max_bytes = budget;
        stage_run(&s);
        check_frame(s.frame);
        assert_true(s.frame->granted.bytes <= budget);
        assert_int_equal(s.frame->bound, CLAST_BOUND_MEMORY);
    }
    stage_close(&s);
}

static void it_is_the_first_step_of_the_ladder_that_fits(void **state)
{
    stage s = open_rich(*state);
    stage_run(&s);
    uint64_t least = s.frame->minimum.triangles, all = s.frame->wanted.triangles;
    clast_frame *trial = stage_add_frame(&s);
    trial->settings = s.frame->settings;
    for (uint64_t budget = least; budget < all; budget *= 3) {
        s.frame->settings.max_triangles = budget;
        stage_run(&s);
        uint32_t step = 0;
        do {
            trial->settings.rate = (double)clast_frame_rate_step(step++);
            assert_ok(s.context, clast_frame_run(trial, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_FIT, NULL));
        } while (trial->triangles > budget);
        assert_true(s.frame->fitted_rate == clast_frame_rate_step(step - 1));
    }
    clast_frame_destroy(trial);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(frames_are_closed_and_honest_at_any_budget_of_triangles),
        CONTEXT_TEST(frames_keep_any_bound_of_memory),
        CONTEXT_TEST(it_is_the_first_step_of_the_ladder_that_fits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
