// SPDX-License-Identifier: Apache-2.0
// A template keeps no positions, but an order: blocks of eight triangles, each compact, cut by the surface area heuristic
// where there were positions. Blocks that have the most vertices in common become nodes; within these, triangles that share
// an edge become pairs. How large a box will be is guessed by how many vertices are in it.
#include "vulkan/pairs.h"

#include <string.h>

enum {
    GROUPS_MOST = TEMPLATE_BLOCKS,
    GROUP_TRIANGLES = 32, // most that a node has
    PLACES = TREE_CHILDREN,
};

typedef struct vertex_set {
    uint64_t words[TEMPLATE_VERTICES / 64];
} vertex_set;

static vertex_set join(const vertex_set *a, const vertex_set *b)
{
    vertex_set joined;
    for (size_t i = 0; i < sizeof joined.words / sizeof *joined.words; i++) {
        joined.words[i] = a->words[i] | b->words[i];
    }
    return joined;
}

static uint32_t size_of(const vertex_set *set)
{
    uint32_t size = 0;
    for (size_t i = 0; i < sizeof set->words / sizeof *set->words; i++) {
        size += (uint32_t)__builtin_popcountll(set->words[i]);
    }
    return size;
}

// Of two sets together.
static uint32_t joined_size(const vertex_set *a, const vertex_set *b)
{
    vertex_set joined = join(a, b);
    return size_of(&joined);
}

typedef struct triangle {
    uint8_t corners[3];
    uint8_t number;
} triangle;

static vertex_set set_of(const triangle *t)
{
    vertex_set set = {{0}};
    for (int k = 0; k < 3; k++) {
        set.words[t->corners[k] / 64] |= UINT64_C(1) << t->corners[k] % 64;
    }
    return set;
}

// Triangles, and their vertices.
typedef struct group {
    uint32_t count;
    triangle triangles[GROUP_TRIANGLES];
    vertex_set set;
} group;

static void add_triangle(group *to, const triangle *t)
{
    vertex_set set = set_of(t);
    to->triangles[to->count++] = *t;
    to->set = join(&to->set, &set);
}

static void add_group(group *to, const group *from)
{
    memcpy(&to->triangles[to->count], from->triangles, from->count * sizeof *from->triangles);
    to->count += from->count;
    to->set = join(&to->set, &from->set);
}

// ------------------------------------------------------------------------------------------------------------ couples

static uint32_t couple_size(const vertex_set *sets, uint8_t a, uint8_t b)
{
    return joined_size(&sets[a], &sets[b]);
}

// Where two couples have more in common with exchanged partners, exchanges them.
static bool exchange(const vertex_set *sets, uint8_t first[2], uint8_t second[2])
{
    uint32_t now = couple_size(sets, first[0], first[1]) + couple_size(sets, second[0], second[1]);
    for (int k = 0; k < 2; k++) {
        uint8_t partner = second[k];
        if (couple_size(sets, first[0], partner) + couple_size(sets, first[1], second[1 - k]) < now) {
            second[k] = first[1];
            first[1] = partner;
            return true;
        }
    }
    return false;
}

// Those that were put together first left little choice to the last ones: exchanges partners as long as it helps. Each time
// there are fewer vertices in all, so it comes to an end.
static void improve_couples(const vertex_set *sets, uint8_t couples[][2], uint32_t count)
{
    bool better = true;
    while (better) {
        better = false;
        for (uint32_t i = 0; i + 1 < count; i++) {
            for (uint32_t k = i + 1; k < count; k++) {
                better = exchange(sets, couples[i], couples[k]) || better;
            }
        }
    }
}

// Puts sets together two by two, those first that have the most in common. Where their number is odd, the last stays alone; the
// couple that has the last, which may hold less than others, comes last. Gives how many couples there are.
static uint32_t find_couples(const vertex_set *sets, uint32_t count, uint8_t couples[][2])
{
    bool taken[CLAST_PAIRS_MOST] = {false};
    uint32_t made = 0, last_couple = 0;
    for (; count - 2 * made >= 2; made++) {
        uint32_t least = UINT32_MAX;
        for (uint32_t i = 0; i + 1 < count; i++) {
            for (uint32_t k = i + 1; !taken[i] && k < count - count % 2; k++) {
                uint32_t size = taken[k] ? UINT32_MAX : joined_size(&sets[i], &sets[k]);
                if (size < least) {
                    least = size;
                    couples[made][0] = (uint8_t)i;
                    couples[made][1] = (uint8_t)k;
                }
            }
        }
        taken[couples[made][0]] = taken[couples[made][1]] = true;
    }
    improve_couples(sets, couples, made);
    if (count % 2 != 0) {
        couples[made][0] = couples[made][1] = (uint8_t)(count - 1);
        return made + 1;
    }
    for (uint32_t i = 0; i < made; i++) {
        last_couple = couples[i][0] == count - 1 || couples[i][1] == count - 1 ? i : last_couple;
    }
    uint8_t last[2] = {couples[last_couple][0], couples[last_couple][1]};
    if (last[0] == count - 1) { // what may hold less comes last
        last[0] = last[1];
        last[1] = (uint8_t)(count - 1);
    }
    memmove(couples[last_couple], couples[last_couple + 1], (made - 1 - last_couple) * sizeof *couples);
    memcpy(couples[made - 1], last, sizeof last);
    return made;
}

static uint32_t couple_groups(group *groups, uint32_t count)
{
    vertex_set sets[GROUPS_MOST];
    uint8_t couples[GROUPS_MOST][2];
    group made[GROUPS_MOST / 2 + 1] = {{0}};
    for (uint32_t i = 0; i < count; i++) {
        sets[i] = groups[i].set;
    }
    uint32_t made_count = find_couples(sets, count, couples);
    for (uint32_t i = 0; i < made_count; i++) {
        add_group(&made[i], &groups[couples[i][0]]);
        if (couples[i][1] != couples[i][0]) {
            add_group(&made[i], &groups[couples[i][1]]);
        }
    }
    memcpy(groups, made, made_count * sizeof *groups);
    return made_count;
}

// -------------------------------------------------------------------------------------------------------------- order

// Of [begin, end) of an order, brings `half` to the front, such that both halves have few vertices. The very last of all stays
// where it is.
static void halve(const vertex_set *sets, uint8_t *order, uint32_t begin, uint32_t end, uint32_t half)
{
    uint32_t count = end - begin, all = (1u << count) - 1, best = 0, least = UINT32_MAX;
    vertex_set unions[1 << PLACES]; // of those whose bits are set
    memset(&unions[0], 0, sizeof unions[0]);
    for (uint32_t mask = 1; mask <= all; mask++) {
        unions[mask] = join(&unions[mask & (mask - 1)], &sets[order[begin + (uint32_t)__builtin_ctz(mask)]]);
    }
    for (uint32_t mask = 0; mask <= all >> 1; mask++) {
        if ((uint32_t)__builtin_popcount(mask) != half) {
            continue;
        }
        uint32_t size = size_of(&unions[mask]) + size_of(&unions[all ^ mask]);
        if (size < least) {
            least = size;
            best = mask;
        }
    }
    uint8_t halves[PLACES];
    uint32_t first = 0, second = half;
    for (uint32_t i = 0; i < count; i++) {
        halves[(best >> i & 1) != 0 ? first++ : second++] = order[begin + i];
    }
    memcpy(order + begin, halves, count);
}

// An order of up to eight sets in which halves, and quarters, have few vertices. The last stays the last.
static void order_sets(const vertex_set *sets, uint32_t count, uint8_t order[PLACES])
{
    for (uint32_t i = 0; i < count; i++) {
        order[i] = (uint8_t)i;
    }
    for (uint32_t half = PLACES / 2; half >= 2; half /= 2) {
        for (uint32_t begin = 0; begin + half < count; begin += 2 * half) {
            uint32_t end = begin + 2 * half;
            halve(sets, order, begin, end < count ? end : count, half);
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- pairs

static uint32_t word_of(const triangle *t)
{
    return triangle_word(t->corners[0], t->corners[1], t->corners[2], t->number);
}

static bool share_edge(const triangle *first, const triangle *second)
{
    clast_pair pair = pair_of(word_of(first), word_of(second));
    return pair_is_fan(pair) && !pair_is_lone(pair);
}

typedef struct pair_list {
    uint32_t count;
    clast_pair pairs[GROUP_TRIANGLES / 2];
    vertex_set sets[GROUP_TRIANGLES / 2];
} pair_list;

static void add_pair(pair_list *list, const triangle *first, const triangle *second)
{
    vertex_set a = set_of(first), b = set_of(second);
    list->pairs[list->count] = first == second ? lone_pair(word_of(first)) : pair_of(word_of(first), word_of(second));
    list->sets[list->count++] = join(&a, &b);
}

// Which triangles of a group share an edge, as bits.
static void find_neighbours(const group *g, uint32_t neighbours[GROUP_TRIANGLES])
{
    memset(neighbours, 0, GROUP_TRIANGLES * sizeof *neighbours);
    for (uint32_t i = 0; i < g->count; i++) {
        for (uint32_t k = i + 1; k < g->count; k++) {
            if (share_edge(&g->triangles[i], &g->triangles[k])) {
                neighbours[i] |= 1u << k;
                neighbours[k] |= 1u << i;
            }
        }
    }
}

static uint32_t least_choice(const uint32_t *neighbours, uint32_t among, uint32_t free)
{
    uint32_t least = UINT32_MAX, choice = 0;
    for (; among != 0; among &= among - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(among), count = (uint32_t)__builtin_popcount(neighbours[i] & free);
        if (count != 0 && count < least) {
            least = count;
            choice = i;
        }
    }
    return choice;
}

// The one to go with a triangle: the other half of what looks like a quad, or who has the least choice.
static uint32_t choose_partner(const group *g, const uint32_t *neighbours, uint32_t i, uint32_t free)
{
    uint32_t among = neighbours[i] & free;
    for (uint32_t left = among; left != 0; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        if ((g->triangles[k].number ^ g->triangles[i].number) == 1) {
            return k;
        }
    }
    return least_choice(neighbours, among, free);
}

// The one of those that are left that shares the most vertices.
static uint32_t choose_any(const group *g, uint32_t i, uint32_t free)
{
    uint32_t least = UINT32_MAX, choice = i;
    vertex_set own = set_of(&g->triangles[i]);
    for (; free != 0; free &= free - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(free);
        vertex_set other = set_of(&g->triangles[k]);
        uint32_t size = joined_size(&own, &other);
        if (size < least) {
            least = size;
            choice = k;
        }
    }
    return choice;
}

// Pairs with a common edge first, each time for a triangle that has the least choice; then any. One that is left over comes
// last.
static void pair_triangles(const group *g, pair_list *list)
{
    uint32_t neighbours[GROUP_TRIANGLES], free = (uint32_t)((UINT64_C(1) << g->count) - 1);
    find_neighbours(g, neighbours);
    list->count = 0;
    while (true) {
        uint32_t i = least_choice(neighbours, free, free);
        if ((free >> i & 1) == 0 || (neighbours[i] & free) == 0) {
            break;
        }
        uint32_t k = choose_partner(g, neighbours, i, free);
        uint32_t first = i < k ? i : k, second = i < k ? k : i;
        add_pair(list, &g->triangles[first], &g->triangles[second]);
        free &= ~(1u << i | 1u << k);
    }
    while (free != 0) {
        uint32_t i = (uint32_t)__builtin_ctz(free);
        free &= free - 1;
        uint32_t k = choose_any(g, i, free);
        add_pair(list, &g->triangles[i], &g->triangles[k]);
        free &= ~(1u << k);
    }
}

// Writes a node's pairs in the order of its leaves, which have one or two each; gives how many.
static uint32_t write_leaves(const pair_list *list, uint32_t shift, clast_pair *pairs)
{
    uint8_t members[GROUP_TRIANGLES / 2][2], order[PLACES];
    vertex_set sets[GROUP_TRIANGLES / 2] = {{{0}}};
    uint32_t leaves = list->count, written = 0;
    for (uint32_t i = 0; i < list->count; i++) {
        members[i][0] = members[i][1] = (uint8_t)i;
    }
    if (shift != 0) {
        leaves = find_couples(list->sets, list->count, members);
    }
    for (uint32_t i = 0; i < leaves; i++) {
        sets[i] = join(&list->sets[members[i][0]], &list->sets[members[i][1]]);
    }
    order_sets(sets, leaves, order);
    for (uint32_t i = 0; i < leaves; i++) {
        const uint8_t *of = members[order[i]];
        pairs[written++] = list->pairs[of[0]];
        if (of[1] != of[0]) {
            pairs[written++] = list->pairs[of[1]];
        }
    }
    return written;
}

// ---------------------------------------------------------------------------------------------------------- templates

static uint32_t make_groups(const clast_template *topology, group groups[GROUPS_MOST])
{
    uint32_t count = topology->block_count;
    memset(groups, 0, count * sizeof *groups);
    for (uint32_t i = 0; i < topology->triangle_count; i++) {
        const clast_block *block = &topology->blocks[i / BLOCK_TRIANGLES];
        uint32_t lane = i % BLOCK_TRIANGLES;
        triangle t = {{block->corners[0][lane], block->corners[1][lane], block->corners[2][lane]},
                      block->triangles[lane]};
        add_triangle(&groups[i / BLOCK_TRIANGLES], &t);
    }
    return couple_groups(groups, count);
}

void clast_pairs_of_template(const clast_template *topology, clast_pair pairs[CLAST_PAIRS_MOST])
{
    uint32_t shift = cluster_shift(triangles_counts(topology->triangle_count));
    group groups[GROUPS_MOST];
    uint32_t count = make_groups(topology, groups);
    if (shift != 0) {
        count = couple_groups(groups, count);
    }
    vertex_set sets[PLACES] = {{{0}}};
    uint8_t order[PLACES];
    for (uint32_t i = 0; i < count; i++) {
        sets[i] = groups[i].set;
    }
    order_sets(sets, count, order);
    for (uint32_t i = 0; i < count; i++) {
        pair_list list;
        pair_triangles(&groups[order[i]], &list);
        pairs += write_leaves(&list, shift, pairs);
    }
}
