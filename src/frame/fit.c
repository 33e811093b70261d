// SPDX-License-Identifier: Apache-2.0
// Pass fit: the first step of the ladder of rates that keeps all budgets. Nothing is dropped for want of room: where the
// wanted rate needs too much, all of the frame becomes coarser.
#include "base/size.h"
#include "frame/unit.h"

// Counts may fall a little where the rate grows, as clusters are filled better: so many steps before one that fits are
// looked at too.
enum { STEPS_BEFORE = 4 };

// Of a unit: hits, and the tree, number them.
static const uint64_t clusters_most = (uint64_t)1 << 31;

float clast_frame_rate_step(uint32_t step)
{
    // 2^(-k/16)
    static const float steps[RATE_STEPS] = {
        1.0f,         0.957603281f, 0.917004043f, 0.878126080f, 0.840896415f, 0.805245166f, 0.771105413f, 0.738413073f,
        0.707106781f, 0.677127773f, 0.648419777f, 0.620928906f, 0.594603558f, 0.569394317f, 0.545253866f, 0.522136891f,
    };
    if (step >= CLAST_FRAME_LAST_RATE_STEP) {
        return CLAST_RATE_LEAST;
    }
    return steps[step % RATE_STEPS] * power_of_two(127u - step / RATE_STEPS);
}

static float rate_at(const clast_frame *frame, uint32_t step)
{
    return (float)frame->settings.rate * clast_frame_rate_step(step);
}

// The budgets of a frame, in the order in which they are told.
typedef struct budget {
    clast_bound bound;
    uint64_t most; // 0 is no bound
    size_t member; // of clast_frame_need
    const char *unit;
} budget;

enum { BUDGETS = 3 };

static void list_budgets(const clast_frame_settings *settings, budget budgets[BUDGETS])
{
    budgets[0] = (budget){CLAST_BOUND_TRIANGLES, settings->max_triangles, offsetof(clast_frame_need, triangles),
                          "triangles"};
    budgets[1] = (budget){CLAST_BOUND_CLUSTERS, settings->max_clusters, offsetof(clast_frame_need, clusters),
                          "clusters"};
    budgets[2] = (budget){CLAST_BOUND_MEMORY, settings->max_bytes, offsetof(clast_frame_need, bytes),
                          "bytes of memory"};
}

static uint64_t needed(const budget *b, const clast_frame_need *need)
{
    return *(const uint64_t *)(const void *)((const char *)need + b->member);
}

// The first budget that is not kept; null where all are.
static const budget *broken_budget(const budget budgets[BUDGETS], const clast_frame_need *need)
{
    for (int i = 0; i < BUDGETS; i++) {
        if (budgets[i].most != 0 && needed(&budgets[i], need) > budgets[i].most) {
            return &budgets[i];
        }
    }
    return NULL;
}

// A search for a step.
typedef struct step_search {
    clast_frame *frame;
    budget budgets[BUDGETS];
    clast_frame_need need; // of the step that was last looked at
} step_search;

static clast_status look_at_step(step_search *search, uint32_t step, const budget **broken)
{
    clast_status status = clast_frame_count(search->frame, rate_at(search->frame, step), &search->need);
    *broken = broken_budget(search->budgets, &search->need);
    return status;
}

// How many steps away from one that needs this much one may be that fits: what is needed falls with the rate's square.
static uint32_t guess_steps(const step_search *search)
{
    double most = 1.0;
    for (int i = 0; i < BUDGETS; i++) {
        const budget *b = &search->budgets[i];
        double ratio = b->most != 0 ? (double)needed(b, &search->need) / (double)b->most : 1.0;
        most = ratio > most ? ratio : most;
    }
    uint32_t steps = 1;
    for (double left = most; left > 1.0905077 && steps < CLAST_FRAME_LAST_RATE_STEP; left /= 1.0905077) {
        steps++; // 2^(2/16)
    }
    return steps;
}

// Narrows a range of steps whose first does not fit and whose last does, until they are neighbours. The last of all
// fits: it is the minimum.
static clast_status narrow(step_search *search, uint32_t *too_much, uint32_t *fits)
{
    uint32_t stride = guess_steps(search);
    while (*fits - *too_much > 1) {
        uint32_t room = *fits - *too_much;
        uint32_t step = *too_much + (stride < room ? stride : room / 2);
        const budget *broken;
        clast_status status = look_at_step(search, step, &broken);
        if (status != CLAST_OK) {
            return status;
        }
        if (broken == NULL) {
            *fits = step;
            stride = stride / 2 > 1 ? stride / 2 : 1;
        } else {
            search->frame->bound = broken->bound;
            *too_much = step;
            stride = guess_steps(search);
        }
    }
    return CLAST_OK;
}

static clast_status find_step(step_search *search, uint32_t *step)
{
    uint32_t too_much = 0, fits = CLAST_FRAME_LAST_RATE_STEP;
    clast_status status = narrow(search, &too_much, &fits);
    uint32_t first = fits > STEPS_BEFORE ? fits - STEPS_BEFORE : 1;
    for (; status == CLAST_OK && first < too_much; first++) {
        const budget *broken;
        status = look_at_step(search, first, &broken);
        if (broken == NULL) {
            fits = first;
            break;
        }
    }
    *step = fits;
    return status;
}

static clast_status refuse(clast_frame *frame, const budget *b)
{
    return clast_fail(frame->context, CLAST_ERROR_BUDGET, "a budget of %llu %s is below the scene's minimum of %llu",
                      (unsigned long long)b->most, b->unit, (unsigned long long)needed(b, &frame->minimum));
}

clast_status clast_frame_check_minimum(clast_frame *frame)
{
    budget budgets[BUDGETS];
    list_budgets(&frame->settings, budgets);
    clast_status status = clast_frame_find_minima(frame);
    if (status != CLAST_OK) {
        return status;
    }
    frame->minimum = clast_frame_instance_need(frame);
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (frame->units[i].used) {
            clast_frame_add_need(&frame->minimum, &frame->units[i].minimum);
        }
    }
    const budget *broken = broken_budget(budgets, &frame->minimum);
    return broken != NULL ? refuse(frame, broken) : CLAST_OK;
}

clast_status clast_unit_settle(clast_frame *frame, clast_frame_unit *unit, float rate)
{
    clast_frame_need sum = unit->sum;
    clast_change change = clast_unit_change(frame, unit, rate);
    if (change == CLAST_CHANGE_TOPOLOGY) {
        clast_status status = clast_unit_count(frame, unit, rate, &sum);
        if (status != CLAST_OK) {
            return status;
        }
    }
    // what items need stays at the largest number where it would be more
    if (sum.clusters >= clusters_most || sum.triangles >= UINT32_MAX || sum.vertices >= UINT32_MAX ||
        sum.words >= UINT32_MAX) {
        return clast_fail(
            frame->context, CLAST_ERROR_LIMIT,
            "geometry %u needs %llu triangles in %llu clusters of %llu vertices; expected less than 2^32 of each, and "
            "2^31 clusters",
            unit->unit->number, (unsigned long long)sum.triangles, (unsigned long long)sum.clusters,
            (unsigned long long)sum.vertices);
    }
    unit->change = change;
    unit->made = unit->made && change == CLAST_CHANGE_NOTHING; // until the passes that follow have made it
    unit->sum = sum;
    unit->view.rate = rate;
    return CLAST_OK;
}

clast_status clast_cpu_fit(clast_frame *frame, void *target)
{
    (void)target;
    step_search search = {.frame = frame, .need = frame->wanted};
    list_budgets(&frame->settings, search.budgets);
    uint32_t step = 0;
    const budget *broken = broken_budget(search.budgets, &frame->wanted);
    frame->bound = broken != NULL ? broken->bound : CLAST_BOUND_NONE;
    clast_status status = broken != NULL ? find_step(&search, &step) : CLAST_OK;
    frame->fitted_rate = clast_frame_rate_step(step);
    status = status == CLAST_OK ? clast_frame_count(frame, rate_at(frame, step), &search.need) : status;
    frame->granted = clast_frame_instance_need(frame);
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        if (frame->units[i].used) {
            status = clast_unit_settle(frame, &frame->units[i], rate_at(frame, step));
            clast_frame_add_need(&frame->granted, &frame->units[i].sum);
        }
    }
    frame->triangles = frame->granted.triangles;
    return status;
}
