// SPDX-License-Identifier: Apache-2.0
// A hash table of numbers: the caller keeps the keys in an array and asks for the numbers whose keys have a hash. What
// it gives depends on the order of insertion only.
#ifndef CLAST_LOAD_TABLE_H
#define CLAST_LOAD_TABLE_H

#include "base/context.h"

typedef struct clast_table_slot {
    uint32_t hash;
    uint32_t number; // CLAST_NONE: free
} clast_table_slot;

// Zero is an empty table.
typedef struct clast_table {
    clast_table_slot *slots;
    size_t size; // a power of two, or 0
    size_t count;
} clast_table;

// Makes room for one more number. Call it before the search that clast_table_insert follows.
clast_status clast_table_reserve(clast_context *context, clast_table *table);
void clast_table_free(clast_context *context, clast_table *table);

// Walks over the numbers that were inserted with `hash`: begin with *place = hash; CLAST_NONE ends.
static inline uint32_t clast_table_next(const clast_table *table, uint32_t hash, size_t *place)
{
    while (table->size != 0) {
        const clast_table_slot *slot = &table->slots[*place & (table->size - 1)];
        if (slot->number == CLAST_NONE) {
            break;
        }
        (*place)++;
        if (slot->hash == hash) {
            return slot->number;
        }
    }
    return CLAST_NONE;
}

// Inserts at the free place where such a walk ended.
static inline void clast_table_insert(clast_table *table, uint32_t hash, size_t place, uint32_t number)
{
    table->slots[place & (table->size - 1)] = (clast_table_slot){hash, number};
    table->count++;
}

// Steele, Lea and Flood's 64-bit finaliser ("variant 13"), for keys of words.
static inline uint64_t clast_hash_word(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * 0xbf58476d1ce4e5b9u;
    hash = (hash ^ hash >> 27) * 0x94d049bb133111ebu;
    return hash ^ hash >> 31;
}

static inline uint32_t clast_hash_text(const char *text, size_t length)
{
    uint64_t hash = 0;
    for (size_t i = 0; i < length; i++) {
        hash = clast_hash_word(hash, (unsigned char)text[i] + 1u);
    }
    return (uint32_t)(hash >> 16);
}

#endif
