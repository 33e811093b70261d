// SPDX-License-Identifier: Apache-2.0
#include "geometry/blocks.h"

enum { KEY_BITS = 11, KEYS = 1 << KEY_BITS, FEW_BITS = 8, FEW_BOXES = 512, ORDERED_MOST = 256, BLOCKS_MOST = 32 };

void clast_boxes_sort(sorted_boxes *b, uint32_t count)
{
    uint32_t bits = count > FEW_BOXES ? KEY_BITS : FEW_BITS, keys = 1u << bits;
    uint16_t places[3][KEYS];
    for (int axis = 0; axis < 3; axis++) {
        memset(places[axis], 0, keys * sizeof places[axis][0]);
    }
    for (uint32_t i = 0; i < count; i++) {
        uint16_t key[3];
        step_box_keys(b->box[i], 16 - (int)bits, key);
        for (int axis = 0; axis < 3; axis++) {
            b->key[axis][i] = key[axis];
            places[axis][key[axis]]++;
        }
    }
    uint32_t sum[3] = {0, 0, 0};
    for (uint32_t key = 0; key < keys; key++) {
        for (int axis = 0; axis < 3; axis++) {
            uint32_t here = places[axis][key];
            places[axis][key] = (uint16_t)sum[axis];
            sum[axis] += here;
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < count; i++) {
            b->order[axis][places[axis][b->key[axis][i]]++] = (uint16_t)i;
        }
    }
}

static inline step_box join_eight(const step_box *box, const uint16_t *order)
{
    step_box a = step_box_join(box[order[0]], box[order[1]]), c = step_box_join(box[order[2]], box[order[3]]);
    step_box d = step_box_join(box[order[4]], box[order[5]]), e = step_box_join(box[order[6]], box[order[7]]);
    return step_box_join(step_box_join(a, c), step_box_join(d, e));
}

static inline step_box join_few(const step_box *box, const uint16_t *order, uint32_t count)
{
    step_box joined = box[order[0]];
    for (uint32_t i = 1; i < count; i++) {
        joined = step_box_join(joined, box[order[i]]);
    }
    return joined;
}

void clast_boxes_sweep(sorted_boxes *b, uint32_t axis, uint32_t begin, uint32_t count, uint32_t first,
                       const boxes_weights *weights, bool extra, boxes_cut *best)
{
    const uint16_t *order = b->order[axis] + begin;
    uint32_t last = (count - first - 1) / BLOCKS_PIECE; // the number of the last piece but one
    uint32_t place = first + last * BLOCKS_PIECE;
    step_box right = join_few(b->box, order + place, count - place);
    b->right[last + 1] = step_box_none();
    b->right[last] = right;
    b->right_area[last] = step_box_area(right);
    for (uint32_t k = last; k > 0; k--) {
        place -= BLOCKS_PIECE;
        step_box piece = join_eight(b->box, order + place);
        right = step_box_join(right, piece);
        b->piece[k] = piece;
        b->right[k - 1] = right;
        b->right_area[k - 1] = step_box_area(right);
    }
    step_box left = join_few(b->box, order, first), far_left = step_box_none();
    uint64_t half = extra ? step_box_area(step_box_join(left, right)) / 2 : 0;
    for (uint32_t k = 0;; k++) {
        uint64_t on_left = weights->left[k + 1], on_right = weights->right[k + 1];
        uint64_t cost = step_box_area(left) * on_left + b->right_area[k] * on_right + half * (on_left + on_right);
        if (cost < best->cost) {
            *best = (boxes_cut){cost, axis, first + k * BLOCKS_PIECE, half, far_left, b->right[k + 1]};
        }
        if (k == last) {
            break;
        }
        far_left = left;
        left = step_box_join(left, b->piece[k + 1]);
    }
}

void clast_boxes_part(sorted_boxes *b, uint32_t begin, uint32_t count, const boxes_cut *cut, bool right_first)
{
    const uint16_t *chosen = b->order[cut->axis] + begin;
    for (uint32_t i = 0; i < count; i++) {
        b->goes_first[chosen[i]] = (i < cut->left) != right_first;
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        if (axis == cut->axis && !right_first) {
            continue;
        }
        uint16_t *order = b->order[axis] + begin;
        uint32_t first = 0, second = 0;
        for (uint32_t i = 0; i < count; i++) { // both are written, one counts: which one is hard to foresee
            uint16_t number = order[i];
            bool goes_first = b->goes_first[number];
            order[first] = number;
            b->kept[second] = number;
            first += goes_first;
            second += !goes_first;
        }
        memcpy(order + first, b->kept, second * sizeof *order);
    }
}

static void weigh_blocks(uint32_t blocks, boxes_weights *weights)
{
    for (uint32_t k = 0; k <= blocks; k++) {
        weights->left[k] = k;
        weights->right[k] = blocks - k;
    }
}

void clast_boxes_order_blocks(sorted_boxes *b, uint32_t begin, uint32_t count, uint16_t *result)
{
    boxes_weights weights;
    uint32_t ends[BLOCKS_MOST + 1], waiting = 0, end = begin + count; // of what waits, the next on top
    ends[waiting++] = end;
    while (waiting != 0) {
        end = ends[waiting - 1];
        count = end - begin;
        if (count <= BLOCKS_PIECE) {
            memcpy(result, b->order[0] + begin, count * sizeof *result);
            result += count;
            begin = end;
            waiting--;
            continue;
        }
        uint32_t over = count % BLOCKS_PIECE;
        weigh_blocks((count + BLOCKS_PIECE - 1) / BLOCKS_PIECE, &weights);
        boxes_cut best = {.cost = UINT64_MAX}, mirrored;
        for (uint32_t axis = 0; axis < 3; axis++) {
            clast_boxes_sweep(b, axis, begin, count, BLOCKS_PIECE, &weights, false, &best);
        }
        mirrored = best;
        for (uint32_t axis = 0; axis < 3 && over != 0; axis++) { // the block that is not full on the other side
            clast_boxes_sweep(b, axis, begin, count, over, &weights, false, &mirrored);
        }
        bool right_first = mirrored.cost < best.cost;
        best = mirrored;
        uint32_t first = right_first ? count - best.left : best.left;
        if (count <= 2 * BLOCKS_PIECE) { // no order is needed any more
            const uint16_t *order = b->order[best.axis] + begin;
            memcpy(result, right_first ? order + best.left : order, first * sizeof *result);
            memcpy(result + first, right_first ? order : order + first, (count - first) * sizeof *result);
            result += count;
            begin = end;
            waiting--;
            continue;
        }
        clast_boxes_part(b, begin, count, &best, right_first);
        ends[waiting++] = begin + first;
    }
}
