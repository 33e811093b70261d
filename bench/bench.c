// SPDX-License-Identifier: Apache-2.0
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <time.h>

#include "base/thread.h"
#include "clast/clast.h"

static bool processor_time; // --cpu-time

void bench_check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

static void usage(const char *name)
{
    fprintf(
        stderr,
        "usage: bench_%s [--json] [--quick] [--threads N] [--triangles N] [--only TEXT] [--metric TEXT] [--cpu-time]\n",
        name);
    exit(2);
}

static uint32_t read_number(const char *name, const char *text)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    if (end == text || *end != '\0' || text[0] == '-' || number > 1000000000ul) {
        usage(name);
    }
    return (uint32_t)number;
}

void bench_begin(bench *b, const char *name, int count, char **arguments)
{
    *b = (bench){.name = name};
    for (int i = 1; i < count; i++) {
        if (strcmp(arguments[i], "--json") == 0) {
            b->options.json = true;
        } else if (strcmp(arguments[i], "--quick") == 0) {
            b->options.quick = true;
        } else if (strcmp(arguments[i], "--threads") == 0 && i + 1 < count) {
            b->options.threads = read_number(name, arguments[++i]);
        } else if (strcmp(arguments[i], "--triangles") == 0 && i + 1 < count) {
            b->options.triangles = read_number(name, arguments[++i]);
        } else if (strcmp(arguments[i], "--only") == 0 && i + 1 < count) {
            b->options.only = arguments[++i];
        } else if (strcmp(arguments[i], "--metric") == 0 && i + 1 < count) {
            b->options.metric = arguments[++i];
        } else if (strcmp(arguments[i], "--cpu-time") == 0) {
            processor_time = true;
        } else {
            usage(name);
        }
    }
    if (processor_time) {
        b->options.threads = 1;
    }
    b->options.repetitions = b->options.quick ? 3 : 7;
}

bool bench_wants(const bench *b, const char *workload)
{
    return b->options.only == NULL || strstr(workload, b->options.only) != NULL;
}

bool bench_measures(const bench *b, const char *metric)
{
    return b->options.metric == NULL || strstr(metric, b->options.metric) != NULL;
}

static bool has_peer(const bench_row *row)
{
    return row->peer[0] != '\0';
}

static double ratio_of(const bench_row *row)
{
    double better = row->less_is_better ? row->peer_value : row->clast,
           worse = row->less_is_better ? row->clast : row->peer_value;
    return worse > 0.0 ? better / worse : 0.0;
}

void bench_add(bench *b, bench_row row)
{
    if (b->count == b->capacity) {
        b->capacity = b->capacity != 0 ? 2 * b->capacity : 32;
        b->rows = realloc(b->rows, b->capacity * sizeof *b->rows);
        if (b->rows == NULL) {
            fprintf(stderr, "out of memory\n");
            exit(1);
        }
    }
    b->rows[b->count++] = row;
    if (!b->options.json) {
        if (b->count == 1) {
            printf("%-20s %10s %3s  %-18s %12s %12s %6s  unit, peer\n", "workload", "triangles", "thr", "metric",
                   "clast", "peer", "ratio");
        }
        printf("%-20s %10llu %3u  %-18s %12.5g ", row.workload, (unsigned long long)row.triangles, row.threads,
               row.metric, row.clast);
        if (has_peer(&row)) {
            printf("%12.5g %6.2f  %s, %s\n", row.peer_value, ratio_of(&row), row.unit, row.peer);
        } else {
            printf("%12s %6s  %s\n", "", "", row.unit);
        }
        fflush(stdout);
    }
}

static void print_text(const char *text)
{
    putchar('"');
    for (; *text != '\0'; text++) {
        if (*text == '"' || *text == '\\') {
            putchar('\\');
        }
        putchar((unsigned char)*text < 32 ? ' ' : *text);
    }
    putchar('"');
}

// The processor's name where the system tells it.
static void machine_name(char *name, size_t size)
{
    struct utsname system;
    FILE *file = fopen("/proc/cpuinfo", "r");
    char line[256];
    snprintf(name, size, "%s", uname(&system) == 0 ? system.machine : "unknown");
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon != NULL) {
            line[strcspn(line, "\n")] = '\0';
            snprintf(name, size, "%s, %u processors", colon + 2, clast_processor_count());
            break;
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

int bench_end(bench *b)
{
    if (b->options.json) {
        if (b->machine[0] == '\0') {
            machine_name(b->machine, sizeof b->machine);
        }
        printf("{\"bench\": \"%s\", \"version\": \"%d.%d.%d\", \"machine\": ", b->name, CLAST_VERSION_MAJOR,
               CLAST_VERSION_MINOR, CLAST_VERSION_PATCH);
        print_text(b->machine);
        printf(", \"rows\": [");
        for (size_t i = 0; i < b->count; i++) {
            const bench_row *row = &b->rows[i];
            printf("%s\n  {\"workload\": ", i != 0 ? "," : "");
            print_text(row->workload);
            printf(", \"triangles\": %llu, \"threads\": %u, \"metric\": \"%s\", \"unit\": \"%s\", \"clast\": %.6g",
                   (unsigned long long)row->triangles, row->threads, row->metric, row->unit, row->clast);
            if (has_peer(row)) {
                printf(", \"peer\": \"%s\", \"peer_value\": %.6g, \"ratio\": %.4g", row->peer, row->peer_value,
                       ratio_of(row));
            } else {
                printf(", \"peer\": null, \"peer_value\": null, \"ratio\": null");
            }
            printf("}");
        }
        printf("\n]}\n");
    }
    free(b->rows);
    return 0;
}

double bench_seconds(void)
{
    struct timespec spent;
    if (processor_time && clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent) == 0) {
        return (double)spent.tv_sec + 1e-9 * (double)spent.tv_nsec;
    }
    return clast_clock();
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return values[count / 2];
}

bench_pair bench_alternate(const bench *b, bench_function clast, bench_function peer, void *data)
{
    double ours[BENCH_REPETITIONS_MOST], theirs[BENCH_REPETITIONS_MOST];
    for (uint32_t i = 0; i < b->options.repetitions; i++) {
        ours[i] = clast(data);
        theirs[i] = peer(data);
    }
    return (bench_pair){bench_median(ours, b->options.repetitions), bench_median(theirs, b->options.repetitions)};
}
