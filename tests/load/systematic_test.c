// SPDX-License-Identifier: Apache-2.0
// Every sample cut at every length, and with every bit of its header turned: an error or a scene, never a crash, never memory that
// is left over.
#include "load/sample_fixture.h"

static uint64_t cases, wrong;

static clast_status read_bytes(sample_fixture *f, const sample *s, const unsigned char *data, size_t size)
{
    // A part is read by way of what names it.
    const char *name = !s->is_part                          ? s->name
                       : strcmp(s->name, "shape.mtl") == 0  ? "shape.obj"
                       : strcmp(s->name, "packed.bin") == 0 ? "packed.gltf"
                                                            : "scene.gltf";
    memory_files_put(&f->files, s->name, data, size);
    clast_status status = read_sample(f, name, s->is_picture);
    if (!is_sound_outcome(f, status)) {
        print_error("%s: %s: %s\n", s->name, clast_status_text(status), clast_context_error(f->context));
        wrong++;
    }
    cases++;
    return status;
}

static void every_sample_is_sound(void **state)
{
    (void)state;
    sample_fixture *f = sample_fixture_make();
    for (size_t i = 0; i < f->all.count; i++) {
        const sample *s = &f->all.list[i];
        clast_status status = read_bytes(f, s, s->data, s->size);
        if (status != CLAST_OK) {
            fail_msg("%s: %s", s->name, clast_context_error(f->context));
        }
    }
    assert_true(f->all.count > 30);
    sample_fixture_free(f);
}

static void every_cut_is_an_error_or_a_scene(void **state)
{
    (void)state;
    sample_fixture *f = sample_fixture_make();
    for (size_t i = 0; i < f->all.count; i++) {
        const sample *s = &f->all.list[i];
        for (size_t size = 0; size < s->size; size++) {
            read_bytes(f, s, s->data, size);
        }
        read_bytes(f, s, s->data, s->size);
    }
    assert_int_equal(wrong, 0);
    sample_fixture_free(f);
}

static void every_bit_of_a_header_may_be_wrong(void **state)
{
    (void)state;
    sample_fixture *f = sample_fixture_make();
    for (size_t i = 0; i < f->all.count; i++) {
        const sample *s = &f->all.list[i];
        for (size_t at = 0; at < s->header; at++) {
            for (uint32_t bit = 0; bit < 8; bit++) {
                s->data[at] ^= (unsigned char)(1u << bit);
                read_bytes(f, s, s->data, s->size);
                s->data[at] ^= (unsigned char)(1u << bit);
            }
        }
        read_bytes(f, s, s->data, s->size);
    }
    printf("%llu cases\n", (unsigned long long)cases);
    assert_int_equal(wrong, 0);
    assert_true(cases >= 100000);
    sample_fixture_free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_sample_is_sound),
        cmocka_unit_test(every_cut_is_an_error_or_a_scene),
        cmocka_unit_test(every_bit_of_a_header_may_be_wrong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
