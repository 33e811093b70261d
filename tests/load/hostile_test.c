// SPDX-License-Identifier: Apache-2.0
// Hostile files, made from the samples by the recipes of hostile.txt, which says how they are written: each comes to the status
// that its recipe says.
#include "load/sample_fixture.h"

#include <ctype.h>

enum { LINE_MOST = 4096, FILE_MOST = 1 << 20, CASES_LEAST = 500 };

typedef struct recipe {
    char name[64], status[32], edit[LINE_MOST];
    uint32_t line;
} recipe;

typedef struct bytes {
    unsigned char data[FILE_MOST];
    size_t size;
} bytes;

static sample_fixture *f;
static uint32_t case_count, wrong_count;

static void fail_recipe(const recipe *r, const char *what)
{
    fail_msg("hostile.txt, line %u: %s", r->line, what);
}

static void append(bytes *to, const void *data, size_t size)
{
    assert_true(size <= sizeof to->data - to->size);
    memcpy(to->data + to->size, data, size);
    to->size += size;
}

// ---------------------------------------------------------------------------------------------------------------- texts

// Appends a text with its escapes resolved: \n \t \r \\ \xHH; %i is `number`, %j the next one.
static void append_text(bytes *to, const char *text, size_t length, uint32_t number)
{
    for (size_t i = 0; i < length; i++) {
        char character = text[i], digits[16];
        if (i + 1 < length && text[i] == '%' && (text[i + 1] == 'i' || text[i + 1] == 'j')) {
            append(to, digits, (size_t)snprintf(digits, sizeof digits, "%u", number + (text[++i] == 'j')));
            continue;
        }
        if (i + 1 < length && text[i] == '\\') {
            i++;
            character = text[i] == 'n' ? '\n' : text[i] == 't' ? '\t' : text[i] == 'r' ? '\r' : text[i];
            if (text[i] == 'x') {
                character = (char)strtoul((char[]){text[i + 1], text[i + 2], '\0'}, NULL, 16);
                i += 2;
            }
        }
        append(to, &character, 1);
    }
}

// Appends a text with repetitions: <3*abc> is abcabcabc.
static void append_repeated(bytes *to, const char *text)
{
    while (*text != '\0') {
        size_t plain = strcspn(text, "<");
        append_text(to, text, plain, 0);
        text += plain;
        if (*text == '<') {
            char *rest;
            unsigned long times = strtoul(text + 1, &rest, 10);
            size_t length = strcspn(rest, ">");
            for (unsigned long i = 0; i < times; i++) {
                append_text(to, rest + 1, length - 1, (uint32_t)i);
            }
            text = rest + length + 1;
        }
    }
}

static const unsigned char *find(const sample *s, const bytes *what)
{
    for (size_t i = 0; what->size != 0 && i + what->size <= s->size; i++) {
        if (memcmp(s->data + i, what->data, what->size) == 0) {
            return s->data + i;
        }
    }
    return NULL;
}

// OLD => NEW: in place of the first OLD.
static void replace(const recipe *r, const sample *s, char *edit, bytes *made)
{
    static bytes old;
    char *arrow = strstr(edit, " => ");
    if (arrow == NULL) {
        fail_recipe(r, "expected OLD => NEW");
    }
    old.size = 0;
    append_text(&old, edit, (size_t)(arrow - edit), 0);
    const unsigned char *at = find(s, &old);
    if (at == NULL) {
        fail_recipe(r, "the sample does not have that text");
    }
    append(made, s->data, (size_t)(at - s->data));
    append_repeated(made, arrow + 4);
    append(made, at + old.size, s->size - (size_t)(at - s->data) - old.size);
}

// ---------------------------------------------------------------------------------------------------------------- bytes

static uint32_t read_big(const unsigned char *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

// Makes the checksums of a PNG's chunks right again: length, type, data, CRC-32 of type and data.
static void mend_png(bytes *png)
{
    for (size_t at = 8; at + 12 <= png->size;) {
        size_t length = read_big(png->data + at);
        if (length > png->size - at - 12) {
            return;
        }
        uint32_t crc = 0xffffffffu;
        for (size_t i = at + 4; i < at + 8 + length; i++) {
            crc ^= png->data[i];
            for (int k = 0; k < 8; k++) {
                crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
            }
        }
        for (size_t i = 0; i < 4; i++) {
            png->data[at + 8 + length + i] = (unsigned char)(~crc >> (24 - 8 * i));
        }
        at += 12 + length;
    }
}

static void put_hexadecimal(const recipe *r, const char *text, bytes *made, size_t at)
{
    for (; *text != '\0'; text += strspn(text, " ")) {
        char *rest;
        unsigned long byte = strtoul(text, &rest, 16);
        if (rest != text + 2 || at > made->size || at >= sizeof made->data) {
            fail_recipe(r, "expected bytes as two digits each, within the file or at its end");
        }
        made->data[at++] = (unsigned char)byte;
        made->size = at > made->size ? at : made->size;
        text = rest;
    }
}

// AT => BYTES: from byte AT on, or from so many before the end on.
static void patch(const recipe *r, const sample *s, const char *edit, bytes *made)
{
    char *rest;
    long at = strtol(edit, &rest, 10);
    if (strncmp(rest, " => ", 4) != 0) {
        fail_recipe(r, "expected AT => BYTES");
    }
    append(made, s->data, s->size);
    put_hexadecimal(r, rest + 4, made, at >= 0 ? (size_t)at : s->size - (size_t)-at);
}

// -------------------------------------------------------------------------------------------------------------- recipes

static const char *reader_of(const sample *s)
{
    return !s->is_part                          ? s->name
           : strcmp(s->name, "shape.mtl") == 0  ? "shape.obj"
           : strcmp(s->name, "packed.bin") == 0 ? "packed.gltf"
                                                : "scene.gltf";
}

static void make_file(const recipe *r, const sample *s, char *edit, bytes *made)
{
    made->size = 0;
    if (strncmp(edit, "whole ", 6) == 0) {
        append_repeated(made, edit + 6);
    } else if (strncmp(edit, "cut ", 4) == 0) {
        long size = strtol(edit + 4, NULL, 10);
        append(made, s->data, size >= 0 ? (size_t)size : s->size - (size_t)-size);
    } else if (edit[0] == '@') {
        patch(r, s, edit + 1, made);
        if (strstr(s->name, ".png") != NULL) {
            mend_png(made);
        }
    } else if (strncmp(edit, "raw@", 4) == 0) {
        patch(r, s, edit + 4, made);
    } else {
        replace(r, s, edit, made);
    }
}

static void run_case(const recipe *r, char *edit)
{
    static bytes made;
    static const char *const names[] = {
#define NAME(name, value, text) [value] = #name,
        CLAST_STATUS_LIST(NAME)
#undef NAME
    };
    const sample *s = samples_find(&f->all, r->name);
    if (s == NULL) {
        fail_recipe(r, "there is no such sample");
    }
    make_file(r, s, edit, &made);
    memory_files_put(&f->files, s->name, made.data, made.size);
    clast_status status = read_sample(f, reader_of(s), s->is_picture);
    memory_files_put(&f->files, s->name, s->data, s->size);
    const char *name = strstr(names[status], "ERROR_") != NULL ? names[status] + strlen("CLAST_ERROR_") : "OK";
    if (!is_sound_outcome(f, status) || strcmp(name, r->status) != 0) {
        print_error("hostile.txt, line %u: %s: %.200s: %s (%s), expected %s\n", r->line, r->name, edit, name,
                    status != CLAST_OK ? clast_context_error(f->context) : "", r->status);
        wrong_count++;
    }
    case_count++;
}

// Runs a recipe once for each way to choose from its lists: <a|b> is a or b.
static void run_choices(const recipe *r, const char *edit)
{
    const char *open = strchr(edit, '<');
    while (open != NULL && strcspn(open, "|") > strcspn(open, ">")) {
        open = strchr(open + 1, '<'); // a repetition
    }
    char chosen[LINE_MOST];
    if (open == NULL) {
        snprintf(chosen, sizeof chosen, "%s", edit);
        run_case(r, chosen);
        return;
    }
    const char *close = open + strcspn(open, ">");
    for (const char *choice = open + 1; choice < close;) {
        size_t length = strcspn(choice, "|>");
        snprintf(chosen, sizeof chosen, "%.*s%.*s%s", (int)(open - edit), edit, (int)length, choice, close + 1);
        run_choices(r, chosen);
        choice += length + 1;
    }
}

static void every_recipe_comes_to_its_status(void **state)
{
    (void)state;
    f = sample_fixture_make();
    FILE *file = fopen(CLAST_TESTS_HOSTILE_RECIPES, "r");
    assert_non_null(file);
    static char line[LINE_MOST];
    static recipe r;
    uint32_t class_count = 0;
    while (fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        r.line++;
        class_count += strncmp(line, "## ", 3) == 0;
        if (line[0] == '#' || line[0] == '\0') {
            continue;
        }
        if (sscanf(line, "%63s %31s %4095[^\n]", r.name, r.status, r.edit) != 3) {
            fail_recipe(&r, "expected SAMPLE STATUS EDIT");
        }
        run_choices(&r, r.edit);
    }
    fclose(file);
    printf("%u cases of %u classes\n", case_count, class_count);
    assert_int_equal(wrong_count, 0);
    assert_true(case_count >= CASES_LEAST);
    sample_fixture_free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_recipe_comes_to_its_status)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
