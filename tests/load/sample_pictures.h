// SPDX-License-Identifier: Apache-2.0
// What the files that make samples share.
#ifndef CLAST_TESTS_LOAD_SAMPLE_PICTURES_H
#define CLAST_TESTS_LOAD_SAMPLE_PICTURES_H

#include "load/samples.h"

// Ends the program for null.
void *sample_check(void *pointer);
// Adds a copy.
sample *sample_add(samples *all, const char *name, const void *data, size_t size);
void sample_add_pictures(samples *all);

#endif
