// SPDX-License-Identifier: Apache-2.0
#include "source/source.h"

const clast_source *const clast_sources[] = {
#define ENTRY(name, value, text) [value] = &name##_TABLE,
    CLAST_SOURCE_LIST(ENTRY)
#undef ENTRY
};

const uint32_t clast_source_kind_count = sizeof clast_sources / sizeof clast_sources[0];
