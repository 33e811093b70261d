// SPDX-License-Identifier: Apache-2.0
// Boxes on a grid, and their order in blocks of eight.
#include "geometry/blocks.h"
#include "geometry/clusters.h"

enum { MOST = 256 };

// A box as plain numbers.
typedef struct plain_box {
    int32_t lower[3], upper[3];
} plain_box;

static step_box step_box_of(const plain_box *b)
{
    const float lower[4] = {(float)b->lower[0], (float)b->lower[1], (float)b->lower[2], 0.0f};
    const float upper[4] = {(float)b->upper[0], (float)b->upper[1], (float)b->upper[2], 0.0f};
    return step_box_from(lanes_load(lower), lanes_load(upper));
}

static plain_box random_box(uint32_t *numbers, int32_t size)
{
    plain_box b;
    for (int axis = 0; axis < 3; axis++) {
        b.lower[axis] = (int32_t)(next_number(numbers) % 32761);
        b.upper[axis] = b.lower[axis] + (int32_t)(next_number(numbers) % (uint32_t)size);
        b.upper[axis] = b.upper[axis] < 32760 ? b.upper[axis] : 32760;
    }
    return b;
}

static uint32_t plain_area(const plain_box *b)
{
    uint64_t x = (uint64_t)(b->upper[0] - b->lower[0] + STEP_BOX_PADDING);
    uint64_t y = (uint64_t)(b->upper[1] - b->lower[1] + STEP_BOX_PADDING);
    uint64_t z = (uint64_t)(b->upper[2] - b->lower[2] + STEP_BOX_PADDING);
    uint64_t area = x * y + y * z + z * x;
    assert_true(area <= UINT32_MAX);
    return (uint32_t)area;
}

static void areas_are_exact(void **state)
{
    (void)state;
    uint32_t numbers = 1;
    for (int i = 0; i < 20000; i++) {
        plain_box b = random_box(&numbers, i % 2 == 0 ? 32760 : 100);
        assert_int_equal(step_box_area(step_box_of(&b)), plain_area(&b));
    }
    plain_box whole = {{0, 0, 0}, {32760, 32760, 32760}}, point = {{5, 6, 7}, {5, 6, 7}};
    assert_int_equal(step_box_area(step_box_of(&whole)), plain_area(&whole));
    assert_int_equal(step_box_area(step_box_of(&point)), plain_area(&point));
}

static void joined_boxes_hold_both(void **state)
{
    (void)state;
    uint32_t numbers = 2;
    for (int i = 0; i < 20000; i++) {
        plain_box a = random_box(&numbers, 5000), b = random_box(&numbers, 5000), both;
        for (int axis = 0; axis < 3; axis++) {
            both.lower[axis] = a.lower[axis] < b.lower[axis] ? a.lower[axis] : b.lower[axis];
            both.upper[axis] = a.upper[axis] > b.upper[axis] ? a.upper[axis] : b.upper[axis];
        }
        step_box joined = step_box_join(step_box_of(&a), step_box_join(step_box_none(), step_box_of(&b)));
        assert_int_equal(step_box_area(joined), plain_area(&both));
    }
}

static void keys_are_centres(void **state)
{
    (void)state;
    uint32_t numbers = 3;
    for (int i = 0; i < 20000; i++) {
        plain_box b = random_box(&numbers, 32760);
        uint16_t keys[3];
        step_box_keys(step_box_of(&b), i % 9, keys);
        for (int axis = 0; axis < 3; axis++) {
            assert_int_equal(keys[axis], (uint32_t)(b.lower[axis] + b.upper[axis]) >> (i % 9));
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- orders

typedef SORTED_ROOM(MOST) sorted_room;

static void orders_are_sorted_and_stable(void **state)
{
    (void)state;
    uint32_t numbers = 4;
    sorted_room room;
    sorted_boxes b = SORTED_IN(&room);
    for (uint32_t i = 0; i < MOST; i++) {
        plain_box box = random_box(&numbers, 300);
        b.box[i] = step_box_of(&box);
    }
    clast_boxes_sort(&b, MOST);
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 1; i < MOST; i++) {
            uint32_t one = b.order[axis][i - 1], next = b.order[axis][i];
            assert_true(b.key[axis][one] < b.key[axis][next] || (b.key[axis][one] == b.key[axis][next] && one < next));
        }
    }
}

static void blocks_hold_every_box_once(void **state)
{
    (void)state;
    uint32_t numbers = 5;
    sorted_room room;
    sorted_boxes b = SORTED_IN(&room);
    for (uint32_t count = 1; count <= MOST; count++) {
        bool met[MOST] = {false};
        uint16_t order[MOST];
        for (uint32_t i = 0; i < count; i++) {
            plain_box box = random_box(&numbers, count % 5 == 0 ? 1 : 4000);
            b.box[i] = step_box_of(&box);
        }
        clast_boxes_sort(&b, count);
        clast_boxes_order_blocks(&b, 0, count, order);
        for (uint32_t i = 0; i < count; i++) {
            assert_true(order[i] < count && !met[order[i]]);
            met[order[i]] = true;
        }
    }
}

// Boxes in far groups of eight, and one of `over`, in no order: each group becomes a block.
static void check_groups(uint32_t groups, uint32_t over, uint32_t seed)
{
    uint32_t count = 8 * groups + over, group_of[MOST];
    uint16_t order[MOST];
    sorted_room room;
    sorted_boxes b = SORTED_IN(&room);
    for (uint32_t i = 0; i < count; i++) {
        group_of[i] = i / 8;
    }
    for (uint32_t i = count; i-- > 1;) {
        uint32_t other = next_number(&seed) % (i + 1), kept = group_of[i];
        group_of[i] = group_of[other];
        group_of[other] = kept;
    }
    for (uint32_t i = 0; i < count; i++) {
        plain_box box;
        for (uint32_t axis = 0; axis < 3; axis++) {
            box.lower[axis] = (int32_t)(group_of[i] * 7919 * (axis + 1) % 15 * 2000 + next_number(&seed) % 40);
            box.upper[axis] = box.lower[axis] + 10;
        }
        b.box[i] = step_box_of(&box);
    }
    clast_boxes_sort(&b, count);
    clast_boxes_order_blocks(&b, 0, count, order);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(group_of[order[i]], group_of[order[i / 8 * 8]]);
    }
}

static void groups_of_eight_become_blocks(void **state)
{
    (void)state;
    for (uint32_t groups = 1; groups <= 15; groups++) {
        check_groups(groups, 0, groups);
    }
}

static void the_block_that_is_not_full_may_stand_anywhere(void **state)
{
    (void)state;
    for (uint32_t over = 1; over < 8; over++) {
        check_groups(1, over, over);
        check_groups(4, over, over + 100);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_are_exact),
        cmocka_unit_test(joined_boxes_hold_both),
        cmocka_unit_test(keys_are_centres),
        cmocka_unit_test(orders_are_sorted_and_stable),
        cmocka_unit_test(blocks_hold_every_box_once),
        cmocka_unit_test(groups_of_eight_become_blocks),
        cmocka_unit_test(the_block_that_is_not_full_may_stand_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
