// SPDX-License-Identifier: Apache-2.0
// The files of one scene: all appear together at the end, or none does.
#ifndef CLAST_GENERATE_OUTPUTS_H
#define CLAST_GENERATE_OUTPUTS_H

#include "base/file.h"

enum { CLAST_OUTPUTS_MOST = 48 };

typedef struct clast_outputs {
    clast_context *context;
    const char *folder; // the caller's
    clast_file_output files[CLAST_OUTPUTS_MOST];
    char *paths[CLAST_OUTPUTS_MOST];
    uint32_t count;
    clast_status status; // the first failure
} clast_outputs;

void clast_outputs_begin(clast_outputs *outputs, clast_context *context, const char *folder);
// Begins the file `name` of the folder. Null after a failure, which is kept in outputs->status.
clast_file_output *clast_outputs_open(clast_outputs *outputs, const char *name);
// Makes all files visible, in the order of opening; after a failure gives all up. Earlier files stay until then.
clast_status clast_outputs_commit(clast_outputs *outputs);
void clast_outputs_discard(clast_outputs *outputs);
// Keeps the first failure.
void clast_outputs_note(clast_outputs *outputs, clast_status status);

#endif
