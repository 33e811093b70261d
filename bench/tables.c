// SPDX-License-Identifier: Apache-2.0
// tables FILE...: prints the results of benchmarks, and the statistics of "clast render --json", as tables for
// docs/performance.md.
#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static double number_of(const json_t *object, const char *name)
{
    return json_number_value(json_object_get(object, name));
}

static const char *text_of(const json_t *object, const char *name)
{
    const char *text = json_string_value(json_object_get(object, name));
    return text != NULL ? text : "";
}

static void print_rows(const json_t *result)
{
    const json_t *rows = json_object_get(result, "rows");
    size_t index;
    json_t *row;
    printf("\n### %s\n\nMachine: %s\n\n", text_of(result, "bench"), text_of(result, "machine"));
    printf("| workload | triangles | threads | metric | unit | clast | peer | peer's value | ratio |\n"
           "|---|---:|---:|---|---|---:|---|---:|---:|\n");
    json_array_foreach(rows, index, row)
    {
        bool has_peer = json_is_number(json_object_get(row, "peer_value"));
        printf("| %s | %.0f | %.0f | %s | %s | %.4g | %s |", text_of(row, "workload"), number_of(row, "triangles"),
               number_of(row, "threads"), text_of(row, "metric"), text_of(row, "unit"), number_of(row, "clast"),
               text_of(row, "peer"));
        if (has_peer) {
            printf(" %.4g | %.2f |\n", number_of(row, "peer_value"), number_of(row, "ratio"));
        } else {
            printf(" | |\n");
        }
    }
}

static void print_render(const json_t *result)
{
    const json_t *milliseconds = json_object_get(result, "milliseconds");
    const json_t *settings = json_object_get(result, "settings");
    printf("\n### A picture of %s\n\n", text_of(result, "input"));
    printf(
        "| triangles | pixels | samples | threads | load s | cook s | first picture s | million rays a second | most memory GiB |\n"
        "|---:|---|---:|---:|---:|---:|---:|---:|---:|\n");
    printf("| %.0f | %.0f x %.0f | %.0f | %.0f | %.2f | %.2f | %.2f | %.2f | %.2f |\n",
           number_of(result, "instanced_triangles"), number_of(settings, "width"), number_of(settings, "height"),
           number_of(result, "samples"), number_of(json_object_get(result, "clast"), "threads"),
           number_of(milliseconds, "load") / 1e3, number_of(milliseconds, "cook") / 1e3,
           number_of(milliseconds, "first_picture") / 1e3, number_of(result, "mrays_per_second"),
           number_of(result, "process_memory_peak") / 1073741824.0);
}

int main(int count, char **arguments)
{
    for (int i = 1; i < count; i++) {
        json_error_t error;
        json_t *result = json_load_file(arguments[i], 0, &error);
        if (result == NULL) {
            fprintf(stderr, "%s: %s\n", arguments[i], error.text);
            return 1;
        }
        if (json_is_array(json_object_get(result, "rows"))) {
            print_rows(result);
        } else {
            print_render(result);
        }
        json_decref(result);
    }
    return 0;
}
