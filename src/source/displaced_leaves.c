// SPDX-License-Identifier: Apache-2.0
// Reading the leaves of a record.
#include "source/displaced.h"

displaced_reader clast_displaced_read(const displaced_unit *unit, const clast_cluster_record *record,
                                      const uint32_t *words)
{
    displaced_reader reader;
    reader.unit = unit;
    reader.cluster = &unit->clusters[record->item];
    reader.words = words + 1;
    reader.splits = words + 1 + record->detail;
    reader.levels = unit->displaced ? words - words[0] : NULL;
    reader.leaf_count = record->detail;
    reader.next = 0;
    return reader;
}

float clast_displaced_level_of(const displaced_reader *reader, uint32_t corner)
{
    if (reader->leaf.split) {
        return displaced_level(reader->leaf.corners[corner].level);
    }
    displaced_triangle triangle = reader->unit->triangles[reader->cluster->first_triangle + reader->leaf.triangle];
    return displaced_cluster_level(reader, displaced_corner(triangle, corner));
}

static void read_split(displaced_reader *reader)
{
    displaced_leaf *leaf = &reader->leaf;
    for (uint32_t k = 0; k < 3; k++) {
        leaf->corners[k].at = weights_of(reader->splits[k]);
    }
    leaf->corners[0].level = reader->splits[3] & 65535;
    leaf->corners[1].level = reader->splits[3] >> 16;
    leaf->corners[2].level = reader->splits[4];
    reader->splits += DISPLACED_SPLIT_WORDS;
}

bool clast_displaced_next(displaced_reader *reader)
{
    if (reader->next == reader->leaf_count) {
        return false;
    }
    uint32_t word = reader->words[reader->next++];
    displaced_leaf *leaf = &reader->leaf;
    leaf->triangle = displaced_leaf_triangle(word);
    leaf->factors = displaced_leaf_factors(word);
    leaf->split = displaced_leaf_is_split(word);
    reader->first_triangle = displaced_leaf_first(word);
    reader->use = displaced_pattern_of(reader->unit, leaf->factors);
    if (leaf->split) {
        read_split(reader);
    }
    return true;
}

// --------------------------------------------------------------------------------------------------------- corners

const displaced_kernels *clast_displaced_kernels_of(clast_isa isa)
{
    static const displaced_kernels kernels[] = CLAST_KERNELS_BY_ISA(DISPLACED_KERNELS);
    return &kernels[clast_isa_index(isa)];
}

void clast_displaced_corners(const clast_unit *base, const clast_cluster_record *record, const uint32_t *words,
                             uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    displaced_reader reader = clast_displaced_read(clast_displaced_of(base), record, words);
    const displaced_kernels *kernels = clast_displaced_kernels_of(clast_context_isa(base->context));
    displaced_layout layout;
    kernels->lay_out(&reader, &layout);
    kernels->place(&reader, &layout, corners);
}
