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

// ------------------------------------------------------------------------------------------- rows, and goals for them

// A goal is a least ratio, or a most of bytes a triangle; zero: there is none. Some workloads have goals of their own.
typedef struct goal {
    const char *bench, *metric;
    double own, other;
    const char *what;
} goal;

static const goal goals[] = {
    {"accel", "refit_vs_refit", 20, 12, "all vertices moved, in their clusters; Embree's refit"},
    {"accel", "gathered_vs_refit", 0, 8, "the same from the mesh's vertices, the copy included"},
    {"accel", "rebuild_vs_rebuild", 40, 20, "clusters in another order, nothing kept; Embree's fastest build"},
    {"accel", "rebuild_vs_grids", 25, 0, "the same; Embree's grids"},
    {"accel", "build_static", 0, 1.5, "from plain triangles; Embree's SAH build"},
    {"accel", "diffuse_single", 1, 1, "single rays after a mild motion; fresh SAH tree, leaking mode"},
    {"accel", "diffuse_vs_robust", 1.25, 1.25, "the same; watertight mode"},
    {"accel", "diffuse_after_twist", 0, 0.95, "after half a turn in 60 frames; fresh SAH tree"},
    {"accel", "twist_frame", 0, 1, "the longest update of those frames; twice the usual update"},
    {"accel", "diffuse_batch", 1.15, 1.15, "best batch call; the best of Embree's calls"},
    {"accel", "primary_batch", 1, 1, "the same, a camera's rays"},
    {"accel", "primary_single", 0, 0, "single rays of a camera"},
    {"accel", "anyhit_single", 1.15, 1.15, "shadow rays, one by one"},
    {"accel", "bytes_per_triangle", 10, 14, "everything, vertices and indices included"},
    {"accel", "tlas_update", 0, 3, "10,000 moved instances; Embree's fastest build"},
    {"accel", "tlas_partial", 0, 20, "10,000 of 1,000,000; the same"},
    {"tess", "frame_mtris_per_core", 1, 1, "the whole frame, on one core; 150 and 60 Mtri/s"},
    {"tess", "frame_vs_rebuild", 10, 4, "the whole frame; Embree's fastest build, the same vertex evaluation included"},
    {"tess", "frame_vs_refit", 3, 1.2, "the same; Embree's refit, of a topology that stays"},
    {"tess", "frame_vs_subdiv", 5, 0, "the same; Embree's subdivision surface, as many triangles"},
    {"tess", "trace_vs_sah", 0.95, 0.9, "single diffuse rays; Embree's SAH tree over the same triangles"},
    {"tess", "bytes_per_triangle", 12, 18, "records, vertices, clusters and trees"},
    {"vulkan", "ready_vs_build", 80, 80, "vertices, clusters and their tree; the driver's fastest build alone"},
    {"vulkan", "ready_vs_update", 12, 12, "the same; the driver's update"},
    {"vulkan", "any_order_vs_build", 30, 30,
     "the same, the tree over clusters in any order; the driver's fastest build"},
    {"vulkan", "primary", 1.9, 1.3, "a picture's rays; the driver's build for fast rays"},
    {"vulkan", "diffuse", 2.6, 1.7, "a ray from each hit; the same"},
    {"vulkan", "bytes_per_triangle", 13, 13, "all that rays need, vertices included"},
};
enum {
    GOALS = sizeof goals / sizeof goals[0],
    VULKAN_TRIANGLES = 4000000, // from which on there are goals for a device: smaller work is over before it is busy
};

static bool has_text(const json_t *row, const char *member, const char *text)
{
    return strstr(text_of(row, member), text) != NULL;
}

// What is in the names of workloads that have goals of their own.
static const char *own_workload(const char *bench)
{
    return strcmp(bench, "tess") == 0 ? "long" : strcmp(bench, "vulkan") == 0 ? "terrain, grids" : ", grids";
}

static double goal_of(const goal *g, const json_t *row)
{
    // Embree's refit stands beside the twist, and its grids beside the bytes, for comparison only.
    if (has_text(row, "peer", "refitted")) {
        return 0.0;
    }
    if (strcmp(g->bench, "vulkan") == 0 &&
        (number_of(row, "triangles") < VULKAN_TRIANGLES || !has_text(row, "workload", ", grids"))) {
        return 0.0;
    }
    return has_text(row, "workload", own_workload(g->bench)) ? g->own : g->other;
}

static bool is_bytes(const json_t *row)
{
    return strcmp(text_of(row, "unit"), "bytes") == 0;
}

// How far a row is: 1 is at its goal, more is better.
static double reached(const goal *g, const json_t *row)
{
    double wanted = goal_of(g, row);
    return is_bytes(row) ? wanted / number_of(row, "clast") : number_of(row, "ratio") / wanted;
}

static bool is_metric(const json_t *row, const char *metric)
{
    return strcmp(text_of(row, "metric"), metric) == 0;
}

static bool has_goals(const char *bench)
{
    bool found = false;
    for (int i = 0; i < GOALS; i++) {
        found = found || strcmp(goals[i].bench, bench) == 0;
    }
    return found;
}

static void print_summary(const json_t *rows, const char *bench)
{
    const char *own = own_workload(bench);
    printf("| metric | what; peer | goal, %s / other | reached by | least | there |\n|---|---|---|---:|---:|---|\n",
           own + strspn(own, ", "));
    for (int i = 0; i < GOALS; i++) {
        const goal *g = &goals[i];
        if (strcmp(g->bench, bench) != 0) {
            continue;
        }
        const json_t *least = NULL;
        json_t *row;
        size_t index, count = 0, held = 0;
        json_array_foreach(rows, index, row)
        {
            if (is_metric(row, g->metric) && goal_of(g, row) > 0.0) {
                count++;
                held += reached(g, row) >= 1.0;
                least = least == NULL || reached(g, row) < reached(g, least) ? row : least;
            }
        }
        if (least != NULL) {
            const char *bound = is_bytes(least) ? "<=" : ">=";
            printf("| `%s` | %s | ", g->metric, g->what);
            g->own > 0.0 ? printf("%s %g / ", bound, g->own) : printf("- / ");
            g->other > 0.0 ? printf("%s %g", bound, g->other) : printf("-");
            printf(" | %zu of %zu | %.2f | %s, %.3g Mtri, threads: %.0f |\n", held, count,
                   number_of(least, is_bytes(least) ? "clast" : "ratio"), text_of(least, "workload"),
                   1e-6 * number_of(least, "triangles"), number_of(least, "threads"));
        }
    }
}

// The row of the same measurement with another number of threads: the one with the same place among its like.
static const json_t *row_with_threads(const json_t *rows, size_t of, double threads)
{
    const json_t *row = json_array_get(rows, of);
    size_t before = 0;
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const json_t *other = json_array_get(rows, i);
        bool same = is_metric(other, text_of(row, "metric")) &&
                    strcmp(text_of(other, "workload"), text_of(row, "workload")) == 0 &&
                    number_of(other, "triangles") == number_of(row, "triangles");
        if (same && i < of && number_of(other, "threads") == number_of(row, "threads")) {
            before++;
        }
    }
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const json_t *other = json_array_get(rows, i);
        bool same = is_metric(other, text_of(row, "metric")) &&
                    strcmp(text_of(other, "workload"), text_of(row, "workload")) == 0 &&
                    number_of(other, "triangles") == number_of(row, "triangles") &&
                    number_of(other, "threads") == threads;
        if (same && before-- == 0) {
            return other;
        }
    }
    return NULL;
}

static void print_values(const json_t *row)
{
    if (row == NULL) {
        printf(" | | |");
    } else if (json_is_number(json_object_get(row, "peer_value"))) {
        printf(" %.4g | %.4g | %.2f |", number_of(row, "clast"), number_of(row, "peer_value"), number_of(row, "ratio"));
    } else {
        printf(" %.4g | | |", number_of(row, "clast"));
    }
}

static void print_rows(const json_t *result)
{
    const json_t *rows = json_object_get(result, "rows");
    double fewest = 1e9, most = 0.0;
    json_t *row;
    size_t index;
    printf("\n### %s\n\nMachine: %s\n\n", text_of(result, "bench"), text_of(result, "machine"));
    if (has_goals(text_of(result, "bench"))) {
        print_summary(rows, text_of(result, "bench"));
        printf("\nAll of it:\n\n");
    }
    json_array_foreach(rows, index, row)
    {
        double threads = number_of(row, "threads");
        fewest = threads < fewest ? threads : fewest;
        most = threads > most ? threads : most;
    }
    printf("| workload | Mtri | metric | unit | peer | clast, threads: %.0f | peer | ratio |", fewest);
    if (most > fewest) {
        printf(" clast, threads: %.0f | peer | ratio |", most);
    }
    printf("\n|---|---:|---|---|---|---:|---:|---:|%s\n", most > fewest ? "---:|---:|---:|" : "");
    json_array_foreach(rows, index, row)
    {
        if (number_of(row, "threads") != fewest) {
            continue;
        }
        printf("| %s | %.3g | %s | %s | %s |", text_of(row, "workload"), 1e-6 * number_of(row, "triangles"),
               text_of(row, "metric"), text_of(row, "unit"), text_of(row, "peer"));
        print_values(row);
        if (most > fewest) {
            print_values(row_with_threads(rows, index, most));
        }
        printf("\n");
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
