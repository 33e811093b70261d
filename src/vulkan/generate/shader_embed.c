// SPDX-License-Identifier: Apache-2.0
// A program of the build: shader_embed IN OUT.spv OUT.inc. Marks all floating-point arithmetic of a SPIR-V module as not to be
// contracted, and writes the module, and its words as numbers of C.
//
// GLSL's `precise` would say the same of what it reaches; but it has to be followed from result to operand through all code,
// which takes the compiler minutes and gigabytes for large kernels, and leaves out what nobody thought of.
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Of SPIR-V 1.6, section 3.42.
enum {
    MAGIC = 0x07230203,
    HEADER_WORDS = 5,
    OP_TYPE_VOID = 19,
    OP_TYPE_LAST = 39,
    OP_VARIABLE = 59,
    OP_DECORATE = 71,
    OP_FNEGATE = 127,
    OP_FADD = 129,
    OP_FSUB = 131,
    OP_FMUL = 133,
    OP_FDIV = 136,
    OP_FREM = 140,
    OP_DOT = 148, // from OP_FREM to here: remainders and products of vectors and matrices
    DECORATION_NO_CONTRACTION = 42,
};

typedef struct module {
    uint32_t *words;
    size_t count;
} module;

static void stop(const char *path, const char *why)
{
    fprintf(stderr, "shader_embed: %s: %s\n", path, why);
    exit(1);
}

static module read_module(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) {
        stop(path, "cannot be read");
    }
    long size = ftell(file);
    rewind(file);
    module read = {malloc(size > 0 ? (size_t)size : 1), size > 0 ? (size_t)size / 4 : 0};
    if (read.words == NULL || fread(read.words, 4, read.count, file) != read.count) {
        stop(path, "cannot be read");
    }
    fclose(file);
    if (read.count < HEADER_WORDS || read.words[0] != MAGIC) {
        stop(path, "is no SPIR-V of this machine's byte order");
    }
    return read;
}

static bool is_arithmetic(uint32_t operation)
{
    return operation == OP_FNEGATE || operation == OP_FADD || operation == OP_FSUB || operation == OP_FMUL ||
           operation == OP_FDIV || (operation >= OP_FREM && operation <= OP_DOT);
}

// Results of arithmetic that are not marked yet: wanted[id] becomes true. Gives where types begin: before them stand the decorations.
static size_t find_arithmetic(const char *path, module from, bool *wanted)
{
    size_t types = 0;
    for (size_t pass = 0; pass < 2; pass++) {
        for (size_t at = HEADER_WORDS, length; at < from.count; at += length) {
            const uint32_t *words = from.words + at;
            uint32_t operation = words[0] & 0xffff;
            length = words[0] >> 16;
            if (length == 0 || length > from.count - at) {
                stop(path, "is cut short");
            }
            if (types == 0 && operation >= OP_TYPE_VOID && operation <= OP_TYPE_LAST) {
                types = at;
            }
            if (pass == 0 && is_arithmetic(operation)) {
                wanted[words[2]] = true;
            } else if (pass == 1 && operation == OP_DECORATE && length == 3 && words[2] == DECORATION_NO_CONTRACTION) {
                wanted[words[1]] = false;
            }
        }
    }
    return types;
}

static module mark(const char *path, module from)
{
    uint32_t bound = from.words[3];
    bool *wanted = calloc(bound, sizeof *wanted);
    module to = {malloc((from.count + 3 * (size_t)bound) * 4), 0};
    if (wanted == NULL || to.words == NULL) {
        stop(path, "memory ran out");
    }
    size_t types = find_arithmetic(path, from, wanted);
    memcpy(to.words, from.words, types * 4);
    to.count = types;
    for (uint32_t id = 0; id < bound; id++) {
        if (wanted[id]) {
            to.words[to.count++] = 3u << 16 | OP_DECORATE;
            to.words[to.count++] = id;
            to.words[to.count++] = DECORATION_NO_CONTRACTION;
        }
    }
    memcpy(to.words + to.count, from.words + types, (from.count - types) * 4);
    to.count += from.count - types;
    free(wanted);
    return to;
}

static void write_module(const char *path, module written)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(written.words, 4, written.count, file) != written.count || fclose(file) != 0) {
        stop(path, "cannot be written");
    }
}

static void write_numbers(const char *path, module written)
{
    FILE *file = fopen(path, "w");
    bool failed = file == NULL;
    for (size_t i = 0; !failed && i < written.count; i++) {
        failed = fprintf(file, "0x%08x,%s", (unsigned)written.words[i], i % 8 == 7 ? "\n" : "") < 0;
    }
    if (failed || fprintf(file, "\n") < 0 || fclose(file) != 0) {
        stop(path, "cannot be written");
    }
}

int main(int count, char **arguments)
{
    if (count != 4) {
        fprintf(stderr, "usage: shader_embed IN.spv OUT.spv OUT.inc\n");
        return 2;
    }
    module from = read_module(arguments[1]);
    module to = mark(arguments[1], from);
    write_module(arguments[2], to);
    write_numbers(arguments[3], to);
    free(from.words);
    free(to.words);
    return 0;
}
