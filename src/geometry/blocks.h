// SPDX-License-Identifier: Apache-2.0
// Cuts across boxes that are sorted along each axis: the surface area heuristic with exact sweeps (Stich et al. 2009,
// "Spatial splits in bounding volume hierarchies", without the splits) that look at every eighth place only.
#ifndef CLAST_GEOMETRY_BLOCKS_H
#define CLAST_GEOMETRY_BLOCKS_H

#include <stdbool.h>

#include "geometry/step_box.h"

enum {
    BLOCKS_PIECE = 8, // boxes between two places: as many as a block of a treelet has triangles
    BLOCKS_SORTED_MOST = 2048,
    BLOCKS_PIECES_MOST = BLOCKS_SORTED_MOST / BLOCKS_PIECE + 1,
};

// Boxes and three orders of their numbers, one sorted along each axis. The arrays stand in a room.
typedef struct sorted_boxes {
    step_box *box;
    uint16_t *order[3];
    uint16_t *key[3]; // of each box, what its order was sorted by
    // For one cut at a time:
    step_box *piece, *right;
    uint32_t *right_area;
    uint16_t *kept;
    bool *goes_first;
} sorted_boxes;

// Memory for `most` boxes, BLOCKS_SORTED_MOST at most.
#define SORTED_ROOM(most) \
    struct { \
        step_box box[most], piece[(most) / BLOCKS_PIECE + 1], right[(most) / BLOCKS_PIECE + 2]; \
        uint32_t right_area[(most) + 1]; \
        uint16_t order[3][most], key[3][most], kept[most]; \
        bool goes_first[most]; \
    }
#define SORTED_IN(room) \
    { \
        (room)->box, {(room)->order[0], (room)->order[1], (room)->order[2]}, \
            {(room)->key[0], (room)->key[1], (room)->key[2]}, (room)->piece, (room)->right, (room)->right_area, \
            (room)->kept, (room)->goes_first \
    }

// A place in an order, and what a cut there costs.
typedef struct boxes_cut {
    uint64_t cost;
    uint32_t axis, left; // left: boxes before the place; 0 where there is none
    uint64_t extra;      // half of the whole area, where a sweep found the cut and counted it
    // Of a cut that a sweep found: around all boxes that stand before the piece on the left, and after the piece on the
    // right.
    step_box far_left, far_right;
} boxes_cut;

// Sorts the numbers of boxes 0 to count - 1 along each axis, equal ones by number. The boxes' centres count on a grid
// that is finer where there are many.
void clast_boxes_sort(sorted_boxes *b, uint32_t count);

// Looks at places `first`, `first` + 8, ... of one axis' order, for boxes [begin, begin + count). With k pieces to the
// left the cost is left area * left[k] + right area * right[k], and where `extra` half of the whole area * (left[k] +
// right[k]).
typedef struct boxes_weights {
    uint32_t left[BLOCKS_PIECES_MOST], right[BLOCKS_PIECES_MOST];
} boxes_weights;
void clast_boxes_sweep(sorted_boxes *b, uint32_t axis, uint32_t begin, uint32_t count, uint32_t first,
                       const boxes_weights *weights, bool extra, boxes_cut *best);

// Brings the boxes that stand before the cut to the front of all orders, each keeping its order; those after it instead
// where `right_first`.
void clast_boxes_part(sorted_boxes *b, uint32_t begin, uint32_t count, const boxes_cut *cut, bool right_first);

// Numbers of boxes [begin, begin + count) in an order in which each eight are a compact block; only the last may have
// less. The orders there are undefined then. At most 256 boxes.
void clast_boxes_order_blocks(sorted_boxes *b, uint32_t begin, uint32_t count, uint16_t *result);

#endif
