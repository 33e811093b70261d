// SPDX-License-Identifier: Apache-2.0
// Files of patterns: the library's own table as a file, and files with faults.
#include "loader_fixture.h"

#include "load/pattern_file.h"

enum { TEXT_MOST = 400000 };

typedef struct text {
    char data[TEXT_MOST];
    size_t size;
} text;

static void add_line(text *to, const char *keyword, uint32_t a, uint32_t b, uint32_t c)
{
    to->size += (size_t)snprintf(to->data + to->size, TEXT_MOST - to->size, "%s %u %u %u\n", keyword, a, b, c);
    assert_true(to->size < TEXT_MOST);
}

static text *write_own_table(void)
{
    text *to = calloc(1, sizeof *to);
    assert_non_null(to);
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        const clast_pattern *pattern = &clast_patterns.patterns[i];
        uint32_t factors = pattern_own_factors(*pattern);
        add_line(to, "pattern", pattern_factor(factors, 0), pattern_factor(factors, 1), pattern_factor(factors, 2));
        for (uint32_t k = pattern_edge_begin(factors, 3); k < pattern_vertices(*pattern); k++) {
            clast_weights weights = weights_of(clast_patterns.vertices[pattern->first_vertex + k]);
            add_line(to, "point", weights.of[0], weights.of[1], weights.of[2]);
        }
        for (uint32_t k = 0; k < pattern_triangles(*pattern); k++) {
            uint32_t word = clast_patterns.triangles[pattern->first_triangle + k];
            add_line(to, "triangle", word & 255u, word >> 8 & 255u, word >> 16);
        }
    }
    return to;
}

static void a_file_gives_its_patterns(void **state)
{
    fixture *f = *state;
    text *file = write_own_table();
    put_text(f, "own.txt", file->data);
    clast_pattern_table *table;
    assert_ok(f->context, clast_load_patterns(f->context, "own.txt", &table));
    assert_int_equal(table->hash, clast_patterns.hash);
    clast_pattern_table_free(f->context, table);
    free(file);
}

// Refused by one line that begins with the file's name.
static void refuse(fixture *f, const char *data, const char *words)
{
    clast_pattern_table *table = NULL;
    put_text(f, "a.txt", data);
    assert_int_equal(clast_load_patterns(f->context, "a.txt", &table), CLAST_ERROR_MALFORMED);
    assert_null(table);
    const char *error = clast_context_error(f->context);
    if (strncmp(error, "a.txt", 5) != 0 || strstr(error, words) == NULL || strchr(error, '\n') != NULL) {
        fail_msg("expected \"%s\", got \"%s\"", words, error);
    }
}

static void faults_are_named_by_line(void **state)
{
    fixture *f = *state;
    refuse(f, "", "a.txt: 0 patterns, expected 286");
    refuse(f, "# nothing\n\npattern 1 1 1\ntriangle 0 1 2\n", "1 patterns, expected 286");
    refuse(f, "triangle 0 1 2\n", "line 1: expected pattern");
    refuse(f, "pattern 1 1 1\nface 0 1 2\n", "line 2: expected pattern, point or triangle");
    refuse(f, "pattern 1 2 1\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 12 1 1\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 3 1 0\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 3 1\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 3 1 1 1\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 3 1 nan\n", "line 1: expected three counts from 11 to 1");
    refuse(f, "pattern 1 1 1\r\ntriangle 0 1 2\r\npattern 1 1 1", "line 3: expected each pattern once");
    refuse(f, "pattern 3 3 3\npoint 10923 10923 10923\n", "line 2: expected three weights that add up to 32768");
    refuse(f, "pattern 3 3 3\npoint 1e9 1 1\n", "line 2: expected three weights");
    refuse(f, "pattern 3 3 3\npoint 0.5 0.5 32767\n", "line 2: expected three weights");
    refuse(f, "pattern 3 3 3\ntriangle 0 1 2\npoint 10922 10923 10923\n",
           "line 3: expected a pattern's points before its triangles");
    refuse(f, "pattern 3 3 3\npoint 10922 10923 10923\ntriangle 0 1 10\n",
           "line 3: expected three of the pattern's vertices");
}

static void too_much_of_a_pattern_is_refused(void **state)
{
    fixture *f = *state;
    text *file = calloc(1, sizeof *file);
    assert_non_null(file);
    add_line(file, "pattern", 3, 3, 3);
    for (int i = 0; i < 200; i++) {
        add_line(file, "point", 10922, 10923, 10923);
    }
    refuse(f, file->data, "line 121: expected at most 128 vertices");
    file->size = 0;
    add_line(file, "pattern", 3, 3, 3);
    for (int i = 0; i < 200; i++) {
        add_line(file, "triangle", 0, 1, 2);
    }
    refuse(f, file->data, "line 130: expected at most 128 triangles");
    free(file);
}

static void a_fault_of_a_pattern_is_named(void **state)
{
    fixture *f = *state;
    text *file = write_own_table();
    char *line = strstr(file->data, "pattern 4 4 4\n");
    line = strstr(line, "triangle ");
    memcpy(line, "#riangle ", 9);
    refuse(f, file->data, "a.txt: pattern 4 4 4: its triangles are not as many as its points need");
    free(file);
}

static void without_memory_nothing_is_left(void **state)
{
    fixture *f = *state;
    text *file = write_own_table();
    put_text(f, "own.txt", file->data);
    clast_pattern_table *table;
    for (long blocks = 0;; blocks++) {
        f->blocks_left = blocks;
        clast_status status = clast_load_patterns(f->context, "own.txt", &table);
        f->blocks_left = -1;
        if (status == CLAST_OK) {
            assert_true(blocks >= 2);
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
        assert_int_equal(clast_context_memory(f->context), f->memory_before);
    }
    clast_pattern_table_free(f->context, table);
    free(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(a_file_gives_its_patterns),        LOADER_TEST(faults_are_named_by_line),
        LOADER_TEST(too_much_of_a_pattern_is_refused), LOADER_TEST(a_fault_of_a_pattern_is_named),
        LOADER_TEST(without_memory_nothing_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
