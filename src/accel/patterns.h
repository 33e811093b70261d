// SPDX-License-Identifier: Apache-2.0
#ifndef CLAST_ACCEL_PATTERNS_H
#define CLAST_ACCEL_PATTERNS_H

#include "clast/accel.h"
#include "geometry/pattern.h"

// Adds the templates of a table's patterns: pattern i is number *first + i. A set that has those of an equal table gives their
// numbers again.
clast_status clast_template_set_add_patterns(clast_template_set *set, const clast_pattern_table *table,
                                             uint32_t *first);

#endif
