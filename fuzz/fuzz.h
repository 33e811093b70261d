// SPDX-License-Identifier: Apache-2.0
// What fuzz targets share. A target NAME_fuzz.c defines fuzz_one(), which looks at some bytes; libFuzzer calls it by way of fuzz.c,
// or replay.c does with files. Each input is a block of exactly its size, so that the address sanitizer sees reads beyond it;
// memory of the context that is left over ends the program.
#ifndef CLAST_FUZZ_FUZZ_H
#define CLAST_FUZZ_FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/image.h"
#include "load/load.h"

// The target's own.
void fuzz_one(clast_context *context, const uint8_t *data, size_t size);

// Ends the program: what must hold does not.
#define FUZZ_CHECK(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
            abort(); \
        } \
    } while (0)

// A block of malloc with a copy.
void *fuzz_copy(const void *data, size_t size);
// Another file that the context has from now on; its bytes stay the caller's.
void fuzz_put_file(const char *name, const void *data, size_t size);

// What the context holds now is kept from input to input.
void fuzz_keep(const clast_context *context);
// Ends the program where a failure has not one line of text, or is one that would be our own fault.
void fuzz_check_outcome(clast_context *context, clast_status status);

// Loads a scene from the input under that name, with clast's own samples as the files beside it.
typedef clast_status fuzz_loader(clast_scene *scene, const char *path, clast_file_view *file);
void fuzz_load(clast_context *context, fuzz_loader *load, const char *name, const uint8_t *data, size_t size);
// Decodes a picture. The input gets the signature that the format's files begin with.
typedef clast_status fuzz_decoder(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
void fuzz_decode(clast_context *context, fuzz_decoder *decode, const char *signature, size_t signature_size,
                 const uint8_t *data, size_t size);

// Numbers taken from the input, from its beginning; zero after its end.
typedef struct fuzz_bytes {
    const uint8_t *at, *end;
} fuzz_bytes;

static inline uint8_t fuzz_byte(fuzz_bytes *bytes)
{
    return bytes->at < bytes->end ? *bytes->at++ : 0;
}

static inline uint32_t fuzz_word(fuzz_bytes *bytes)
{
    uint32_t word = 0;
    for (uint32_t i = 0; i < 4; i++) {
        word |= (uint32_t)fuzz_byte(bytes) << 8 * i;
    }
    return word;
}

#endif
