// SPDX-License-Identifier: Apache-2.0
// Small whole files of the formats that are read, made by writers or by hand: what tests cut and change, and what fuzzing begins
// with.
#ifndef CLAST_TESTS_LOAD_SAMPLES_H
#define CLAST_TESTS_LOAD_SAMPLES_H

#include <stdbool.h>
#include <stddef.h>

enum { SAMPLES_MOST = 64 };

typedef struct sample {
    const char *name;    // of the file
    bool is_picture;     // else a scene, or a part of one (is_part)
    bool is_part;        // no file on its own: what others name
    size_t header;       // bytes that decide how the rest is read; all, for text
    unsigned char *data; // a block of malloc
    size_t size;
} sample;

typedef struct samples {
    sample list[SAMPLES_MOST];
    size_t count;
} samples;

// Ends the program where one cannot be made.
samples samples_make(void);
void samples_free(samples *all);
// Null where there is none of that name.
const sample *samples_find(const samples *all, const char *name);

#endif
