// SPDX-License-Identifier: Apache-2.0
// What benchmarks share: options, times, medians of alternating runs, and one JSON object of results.
//
// Each measures clast beside what a user would pick instead, in one process, in turns, so that whatever else the machine
// does meets both alike.
#ifndef CLAST_BENCH_BENCH_H
#define CLAST_BENCH_BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "clast/context.h"

enum { BENCH_REPETITIONS_MOST = 31, BENCH_NAME_SIZE = 64 };

// --json, --quick, --threads N (0: each of 1 and 2), --triangles N (0: the benchmark's own sizes), --only TEXT (workloads
// whose names have it), --metric TEXT (metrics whose names have it, where the benchmark can leave others out). --cpu-time, for
// machines that do other things too: the processor's time, on one thread.
typedef struct bench_options {
    bool json;
    bool quick;
    uint32_t threads;
    uint32_t triangles;
    uint32_t repetitions;
    const char *only;   // null: all
    const char *metric; // likewise
} bench_options;

// A line of results. `ratio` is made from the values: more than 1 means that clast is better.
typedef struct bench_row {
    char workload[BENCH_NAME_SIZE];
    uint64_t triangles;
    uint32_t threads;
    const char *metric;
    const char *unit;
    bool less_is_better;
    double clast;
    char peer[BENCH_NAME_SIZE]; // empty: there is none
    double peer_value;
} bench_row;

typedef struct bench {
    const char *name;
    char machine[520]; // what the figures are of; empty: the processor
    bench_options options;
    bench_row *rows;
    size_t count, capacity;
} bench;

// Reads the options; ends the program where they are wrong.
void bench_begin(bench *b, const char *name, int count, char **arguments);
// Adds a row, and prints it where a person reads.
void bench_add(bench *b, bench_row row);
// Prints the object where --json is given, frees all, and gives the exit status.
int bench_end(bench *b);

// Ends the program where a call failed. `context` may be null.
void bench_check(clast_status status, const clast_context *context);

// Whether a workload is to be measured.
bool bench_wants(const bench *b, const char *workload);
// Whether a metric is.
bool bench_measures(const bench *b, const char *metric);

double bench_seconds(void);
// Sorts the values.
double bench_median(double *values, uint32_t count);

// Runs `clast` and `peer` in turns and gives the medians of what they return (seconds, or any figure).
typedef double (*bench_function)(void *data);
typedef struct bench_pair {
    double clast, peer;
} bench_pair;
bench_pair bench_alternate(const bench *b, bench_function clast, bench_function peer, void *data);

#endif
