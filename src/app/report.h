// SPDX-License-Identifier: Apache-2.0
// Statistics as JSON. Each gives a new object, or null where memory ran out.
#ifndef CLAST_APP_REPORT_H
#define CLAST_APP_REPORT_H

#include "app/session.h"

// Milliseconds of each pass, by name.
json_t *clast_report_passes(const clast_render_statistics *statistics);
// Bytes of each structure, and the same for each triangle.
json_t *clast_report_bytes(const clast_render_statistics *statistics, bool for_each_triangle);
json_t *clast_report_settings(const clast_render_settings *settings);
// Triangles, clusters and the like, added to an object.
int clast_report_add_counts(json_t *object, const clast_render_statistics *statistics);
// Version, threads and instruction set.
json_t *clast_report_program(const clast_session *session);
// A text that need not be UTF-8, as file names and names in files.
json_t *clast_report_text(const char *text);
double clast_mega_rays_per_second(const clast_render_statistics *statistics);

#endif
