// SPDX-License-Identifier: Apache-2.0
#include "load/table.h"

#include "base/size.h"

static clast_status grow(clast_context *context, clast_table *table)
{
    clast_table larger = {.count = table->count};
    if (!clast_multiply_size(table->size != 0 ? table->size : 8, 2, &larger.size)) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "a table of %zu entries cannot grow", table->size);
    }
    larger.slots = clast_allocate(context, larger.size, sizeof *larger.slots);
    if (larger.slots == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < larger.size; i++) {
        larger.slots[i].number = CLAST_NONE;
    }
    for (size_t i = 0; i < table->size; i++) {
        clast_table_slot slot = table->slots[i];
        size_t place = slot.hash;
        if (slot.number == CLAST_NONE) {
            continue;
        }
        while (larger.slots[place & (larger.size - 1)].number != CLAST_NONE) {
            place++;
        }
        larger.slots[place & (larger.size - 1)] = slot;
    }
    clast_free(context, table->slots);
    *table = larger;
    return CLAST_OK;
}

clast_status clast_table_reserve(clast_context *context, clast_table *table)
{
    return table->count < table->size / 2 ? CLAST_OK : grow(context, table);
}

void clast_table_free(clast_context *context, clast_table *table)
{
    clast_free(context, table->slots);
    *table = (clast_table){0};
}
