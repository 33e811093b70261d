// SPDX-License-Identifier: Apache-2.0
// A template's triangles as pairs in leaves, as clusters on a device have them (shared/cluster.h).
#ifndef CLAST_VULKAN_PAIRS_H
#define CLAST_VULKAN_PAIRS_H

#include "accel/structures.h"
#include "shared/cluster.h"

enum { CLAST_PAIRS_MOST = TEMPLATE_TRIANGLES / 2 };

// Fills (triangle_count + 1) / 2 pairs, as cluster_pairs(triangles_counts(triangle_count)) says. Only the last may be lone.
void clast_pairs_of_template(const clast_template *topology, clast_pair pairs[CLAST_PAIRS_MOST]);

#endif
