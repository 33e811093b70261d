// SPDX-License-Identifier: Apache-2.0
// Broken, cut and hostile glTF files, memory that runs out, files that cannot be read: an error or a scene, never a
// crash or a leak. The address and undefined sanitizers make these tests count in full.
#include "gltf_fixture.h"
#include "gltf_sample.h"

#include <ctype.h>

static void the_sample_itself_is_sound(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    assert_loads(f, SAMPLE);
    assert_int_equal(f->scene->instance_count, 1 + 2 * 3 + 2);
    assert_int_equal(f->scene->camera_count, 2);
    assert_int_equal(f->scene->light_count, 1);
    assert_int_equal(f->scene->texture_count, 2);
    assert_int_equal(f->scene->material_count, 3);
}

// A load that may fail, but by a status that fits, with one line that names the file.
static void load_hostile(fixture *f, const char *text)
{
    clast_status status = load_text(f, text);
    const char *error = clast_context_error(f->context);
    bool sound = status == CLAST_OK || status == CLAST_ERROR_MALFORMED || status == CLAST_ERROR_UNSUPPORTED ||
                 status == CLAST_ERROR_LIMIT || status == CLAST_ERROR_FILE_NOT_FOUND;
    if (!sound || (status != CLAST_OK && strncmp(error, "scene.gltf: ", 12) != 0)) {
        fail_msg("status \"%s\", error \"%s\"", clast_status_text(status), error);
    }
}

// Loads the sample with [at, at + length) replaced.
static void load_replaced(fixture *f, size_t at, size_t length, const char *by)
{
    static char text[sizeof SAMPLE + 128];
    snprintf(text, sizeof text, "%.*s%s%s", (int)at, SAMPLE, by, SAMPLE + at + length);
    load_hostile(f, text);
}

static const char *const NASTY[] = {
    "-1",   "0",          "1",          "255",        "256",        "0.5",
    "-0.0", "2147483647", "2147483648", "4294967295", "4294967296", "9223372036854775807",
    "1e15", "1e38",       "1e300",      "-1e38",      "1e-40",      "null",
    "true", "'x'",        "[]",         "{}",         "[[0]]",      "7"};
enum { NASTY_COUNT = sizeof NASTY / sizeof *NASTY };

static bool begins_number(size_t i)
{
    return isdigit((unsigned char)SAMPLE[i]) && strchr(":[,", SAMPLE[i - 1]) != NULL;
}

static void every_number_can_be_nasty(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    size_t numbers = 0;
    for (size_t i = 1; i + 1 < sizeof SAMPLE; i++) {
        if (begins_number(i)) {
            size_t length = strspn(SAMPLE + i, "0123456789.");
            for (size_t k = 0; k < NASTY_COUNT; k++) {
                load_replaced(f, i, length, NASTY[k]);
            }
            numbers++;
        }
    }
    assert_true(numbers > 150);
}

static void every_text_and_list_can_be_nasty(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    for (size_t i = 1; i + 1 < sizeof SAMPLE; i++) {
        if (SAMPLE[i - 1] == ':' && (SAMPLE[i] == '\'' || SAMPLE[i] == '[' || SAMPLE[i] == '{')) {
            size_t length = 1, depth = 1;
            char open = SAMPLE[i], close = open == '[' ? ']' : open == '{' ? '}' : '\'';
            for (; depth > 0; length++) {
                depth = SAMPLE[i + length] == close ? depth - 1 : depth + (SAMPLE[i + length] == open);
            }
            for (size_t k = 0; k < NASTY_COUNT; k++) {
                load_replaced(f, i, length, NASTY[k]);
            }
            load_replaced(f, i, length, "'\\u00e9%41/../../..//data.bin'");
            load_replaced(f, i, length, "'data:;base64,AAAA'");
        }
    }
}

static void every_name_can_be_another(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    for (size_t i = 1; i + 1 < sizeof SAMPLE; i++) {
        if (SAMPLE[i] == '\'' && strchr("{,", SAMPLE[i - 1]) != NULL) {
            size_t length = strcspn(SAMPLE + i + 1, "'") + 2;
            load_replaced(f, i, length, "'gone'");
        }
    }
}

static void every_cut_of_the_text_is_refused(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    static char text[sizeof SAMPLE];
    for (size_t cut = 0; cut + 1 < sizeof SAMPLE; cut++) {
        memcpy(text, SAMPLE, cut);
        text[cut] = '\0';
        assert_int_equal(load_text(f, text), CLAST_ERROR_MALFORMED);
    }
}

static uint32_t next_random(uint32_t *random)
{
    *random = *random * 1664525u + 1013904223u;
    return *random >> 8;
}

static void random_characters_do_no_harm(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    static char text[sizeof SAMPLE];
    static const char characters[] = "0123456789-.eE'[]{},: \\\"untrf\x01\x80\xff";
    uint32_t random = 1;
    for (int round = 0; round < 3000; round++) {
        memcpy(text, SAMPLE, sizeof SAMPLE);
        for (uint32_t k = next_random(&random) % 3; k < 3; k++) {
            text[next_random(&random) % (sizeof SAMPLE - 1)] =
                characters[next_random(&random) % (sizeof characters - 1)];
        }
        load_hostile(f, text);
    }
}

static void random_bytes_in_a_buffer_do_no_harm(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    uint32_t random = 2;
    for (int round = 0; round < 3000; round++) {
        unsigned char kept[3];
        uint32_t places[3];
        for (int k = 0; k < 3; k++) {
            places[k] = next_random(&random) % sizeof sample_bytes;
            kept[k] = sample_bytes[places[k]];
            sample_bytes[places[k]] = (unsigned char)next_random(&random);
        }
        load_hostile(f, SAMPLE);
        for (int k = 2; k >= 0; k--) {
            sample_bytes[places[k]] = kept[k];
        }
    }
}

static void every_length_of_a_buffer_is_checked(void **state)
{
    fixture *f = *state;
    put_sample(&f->files);
    for (size_t size = 0; size < sizeof sample_bytes; size++) {
        memory_files_put(&f->files, "data.bin", sample_bytes, size);
        assert_int_equal(load_text(f, SAMPLE), CLAST_ERROR_MALFORMED);
    }
}

// --------------------------------------------------------------------------------------------------- memory runs out

typedef struct failing_memory {
    uint64_t allocations; // since the count began
    uint64_t fail_at;     // this one and all after it fail; 0: none
    int64_t blocks;
} failing_memory;

static void *failing_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    failing_memory *memory = user;
    (void)old_size;
    if (new_size == 0) {
        memory->blocks -= pointer != NULL;
        free(pointer);
        return NULL;
    }
    memory->allocations++;
    if (memory->fail_at != 0 && memory->allocations >= memory->fail_at) {
        return NULL;
    }
    void *block = realloc(pointer, new_size);
    memory->blocks += pointer == NULL && block != NULL;
    return block;
}

static void every_allocation_can_fail(void **state)
{
    (void)state;
    failing_memory memory = {0};
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    clast_context_desc desc = {.memory = {failing_reallocate, &memory}, .threads = 1};
    desc.file = memory_files_hook(&f->files);
    assert_int_equal(clast_context_create(&desc, &f->context), CLAST_OK);
    put_sample(&f->files);
    int64_t blocks = memory.blocks;
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    uint64_t fail_at = 1;
    for (; status != CLAST_OK && fail_at < 10000; fail_at++) {
        memory.allocations = 0;
        memory.fail_at = fail_at;
        status = load_text(f, SAMPLE);
        memory.fail_at = 0;
        assert_true(status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY);
        clast_scene_destroy(f->scene);
        f->scene = NULL;
        assert_int_equal(memory.blocks, blocks);
        assert_int_equal(f->files.mapped, 0);
    }
    assert_int_equal(status, CLAST_OK);
    assert_true(fail_at > 50);
    clast_context_destroy(f->context);
    free(f);
}

// ------------------------------------------------------------------------------------------------------------- cancel

static bool stop(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)stage;
    (void)done;
    (void)total;
    int *left = user;
    return (*left)-- > 0;
}

static void a_load_can_be_cancelled(void **state)
{
    (void)state;
    int left = 0;
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    clast_context_desc desc = {.threads = 1, .progress = {stop, &left}};
    desc.file = memory_files_hook(&f->files);
    assert_int_equal(clast_context_create(&desc, &f->context), CLAST_OK);
    put_sample(&f->files);
    uint64_t before = clast_context_memory(f->context);
    for (int stops = 0; stops < 3; stops++) {
        left = stops;
        assert_int_equal(load_text(f, SAMPLE), CLAST_ERROR_CANCELLED);
        clast_scene_destroy(f->scene);
        f->scene = NULL;
        assert_int_equal(clast_context_memory(f->context), before);
        assert_int_equal(f->files.mapped, 0);
    }
    left = 1000;
    assert_int_equal(load_text(f, SAMPLE), CLAST_OK);
    clast_scene_destroy(f->scene);
    clast_context_destroy(f->context);
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(the_sample_itself_is_sound),          GLTF_TEST(every_number_can_be_nasty),
        GLTF_TEST(every_text_and_list_can_be_nasty),    GLTF_TEST(every_name_can_be_another),
        GLTF_TEST(every_cut_of_the_text_is_refused),    GLTF_TEST(random_characters_do_no_harm),
        GLTF_TEST(random_bytes_in_a_buffer_do_no_harm), GLTF_TEST(every_length_of_a_buffer_is_checked),
        cmocka_unit_test(every_allocation_can_fail),    cmocka_unit_test(a_load_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
