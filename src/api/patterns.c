// SPDX-License-Identifier: Apache-2.0
// Tables of patterns of the user's own.
#include <string.h>

#include "api/renderer.h"
#include "load/pattern_file.h"

static clast_status read_table(clast_renderer *renderer, const char *path)
{
    clast_context *context = renderer->context;
    clast_status status = CLAST_RESERVE(context, renderer->patterns, renderer->pattern_capacity,
                                        renderer->pattern_count + 1);
    char *copy = status == CLAST_OK ? clast_copy_text(context, path) : NULL;
    if (copy == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_pattern_table *table;
    status = clast_load_patterns(context, path, &table);
    if (status != CLAST_OK) {
        clast_free(context, copy);
        return status;
    }
    renderer->patterns[renderer->pattern_count++] = table;
    renderer->patterns_path = copy;
    clast_cooked_use_patterns(renderer->cooked, table);
    return CLAST_OK;
}

clast_status clast_use_patterns(clast_renderer *renderer, const clast_render_settings *settings)
{
    const char *wanted = settings->patterns, *current = renderer->patterns_path != NULL ? renderer->patterns_path : "";
    if (strcmp(wanted, current) == 0) {
        return CLAST_OK;
    }
    if (wanted[0] != '\0') {
        char *before = renderer->patterns_path;
        clast_status status = read_table(renderer, wanted);
        if (status == CLAST_OK) {
            clast_free(renderer->context, before);
        }
        return status;
    }
    clast_free(renderer->context, renderer->patterns_path);
    renderer->patterns_path = NULL;
    clast_cooked_use_patterns(renderer->cooked, NULL);
    return CLAST_OK;
}

void clast_free_patterns(clast_renderer *renderer)
{
    for (size_t i = 0; i < renderer->pattern_count; i++) {
        clast_pattern_table_free(renderer->context, renderer->patterns[i]);
    }
    clast_free(renderer->context, renderer->patterns);
    clast_free(renderer->context, renderer->patterns_path);
}
