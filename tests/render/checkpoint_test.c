// SPDX-License-Identifier: Apache-2.0
// Renders that were interrupted and go on from a checkpoint: the same bits; and files that are not of the picture, or of nothing.
#define XXH_INLINE_ALL
#include "picture.h"

#include <unistd.h>
#include <xxhash.h>

#include "clast/animation.h"

enum { SIZE = 37, PIXELS = SIZE * SIZE };

static const clast_view views[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_NORMAL, CLAST_VIEW_DEPTH, CLAST_VIEW_INSTANCE,
                                   CLAST_VIEW_SAMPLES};
enum { VIEWS = sizeof views / sizeof *views };
#define LAYOUT(name, value, text, channels, is_float, help) [name] = channels,
static const uint32_t channels[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(LAYOUT)};

static char folder[] = "/tmp/clast_checkpoint_XXXXXX", file[sizeof folder + 8];

// When a render is stopped: at which report of its progress.
static uint64_t reports, last_report;

static bool go_on(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)user;
    (void)done;
    (void)total;
    return strcmp(stage, "render") != 0 || reports++ < last_report;
}

static clast_context *open_context(uint32_t threads)
{
    clast_context *context;
    assert_int_equal(
        clast_context_create(&(clast_context_desc){.threads = threads, .progress = {.progress = go_on}}, &context),
        CLAST_OK);
    return context;
}

static picture lamp_scene(clast_context *context)
{
    picture p = picture_open(context, SIZE, 12);
    picture_surround(&p, 0.05f);
    picture_add_square(&p, vec3(0, -1, 0), vec3(0, 0, 2), vec3(2, 0, 0), picture_material(&p, 0.6f, 0.0f, 0.8f, 0.0f));
    picture_add_sphere(&p, vec3(0, 0, 0), 0.7f, 32, picture_material(&p, 0.7f, 0.0f, 0.3f, 0.0f));
    picture_add_square(&p, vec3(0.5f, 2, 0), vec3(0, 0, -0.4f), vec3(0.4f, 0, 0),
                       picture_material(&p, 0.0f, 0.0f, 1.0f, 8.0f));
    picture_look(&p, vec3(0, 2, 7), vec3(0, 1, 0), 0.8f);
    // The camera goes aside while a shutter is open.
    const float times[] = {0, 1}, places[] = {0, 1, 7, 1, 1, 7};
    const clast_node_desc stand = {.parent = CLAST_NONE, .translation = {0, 1, 7}};
    uint32_t node, animation;
    assert_ok(context, clast_scene_add_node(p.scene, &stand, NULL, &node));
    assert_ok(context, clast_scene_attach_camera(p.scene, 0, node));
    clast_channel channel = {node, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 2, times, places};
    assert_ok(context, clast_scene_add_animation(p.scene, &channel, 1, NULL, &animation));
    return p;
}

// The same with a context of its own, built, for so many samples. close_built() frees both.
static picture open_built(uint32_t threads, uint32_t samples)
{
    picture p = lamp_scene(open_context(threads));
    p.settings.spp = samples;
    picture_build(&p);
    return p;
}

static void close_built(picture *p)
{
    clast_context *context = p->context;
    picture_close(p);
    clast_context_destroy(context);
}

// Renders up to a report of progress, with a file to go on from, or none.
static clast_status run(picture *p, const char *resume, uint64_t most_reports)
{
    clast_render_output outputs[VIEWS];
    for (int i = 0; i < VIEWS; i++) {
        free(p->pixels[views[i]]);
        p->pixels[views[i]] = malloc((size_t)PIXELS * 12);
        outputs[i] = (clast_render_output){views[i], p->pixels[views[i]]};
    }
    clast_render_request request = {&p->settings, outputs, VIEWS, {resume, file, 1e-9}, "cpu"};
    reports = 0;
    last_report = most_reports;
    return clast_render_run(p->frame, &clast_cpu_backend, &request, &p->statistics);
}

static void check_same(const picture *a, const picture *b)
{
    for (int i = 0; i < VIEWS; i++) {
        assert_memory_equal(a->pixels[views[i]], b->pixels[views[i]], (size_t)PIXELS * channels[views[i]] * 4);
    }
}

// Interrupted again and again, each time in a process of its own, as far as a test can tell, with other threads.
static void check_interrupted(double noise_target, double shutter)
{
    picture whole = open_built(2, noise_target > 0.0 ? 160 : 12);
    whole.settings.noise_target = noise_target;
    whole.settings.shutter = shutter;
    whole.settings.shutter_steps = 4;
    assert_ok(whole.context, run(&whole, NULL, UINT64_MAX));
    clast_status status = CLAST_ERROR_CANCELLED;
    uint32_t rounds = 0;
    const char *resume = NULL;
    for (; status == CLAST_ERROR_CANCELLED; rounds++) {
        picture p = open_built(1 + rounds % 3, whole.settings.spp);
        p.settings = whole.settings;
        status = run(&p, resume, noise_target > 0.0 ? 61 : 3 + rounds);
        resume = file;
        if (status == CLAST_OK) {
            check_same(&p, &whole);
            assert_int_equal(p.statistics.samples, whole.statistics.samples);
            assert_near(p.statistics.mean_samples, whole.statistics.mean_samples, 0.0);
        }
        close_built(&p);
    }
    assert_int_equal(status, CLAST_OK);
    assert_true(rounds > 2);
    close_built(&whole);
}

static void interrupted_renders_have_the_same_bits(void **state)
{
    (void)state;
    check_interrupted(0.0, 0.0);
}

static void interrupted_renders_with_a_noise_target_have_the_same_bits(void **state)
{
    (void)state;
    check_interrupted(0.004, 0.0);
}

// What moves is not at the same place in the middle of a render as at its beginning.
static void interrupted_renders_with_an_open_shutter_have_the_same_bits(void **state)
{
    (void)state;
    check_interrupted(0.0, 1.0);
}

// Up to the next power of two, which points are laid out for, as if they had been asked for at once; beyond, with other ones.
static void a_finished_render_goes_on_with_more_samples(void **state)
{
    (void)state;
    clast_context *context = open_context(2);
    picture p = lamp_scene(context), more = lamp_scene(context);
    picture_build(&p);
    picture_build(&more);
    p.settings.spp = 8;
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    more.settings.spp = 5;
    assert_ok(context, run(&more, NULL, UINT64_MAX));
    more.settings.spp = 8;
    more.settings.tonemap = CLAST_TONE_MAP_AGX; // decides nothing about samples
    assert_ok(context, run(&more, file, UINT64_MAX));
    assert_int_equal(more.statistics.primary_rays, 3 * PIXELS);
    check_same(&p, &more);
    double mean = picture_mean(&more);
    more.settings.spp = 64;
    assert_ok(context, run(&more, file, UINT64_MAX));
    assert_int_equal(more.statistics.samples, 64);
    assert_near(picture_mean(&more), mean, 0.1 * mean);
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    more.settings.spp = 3; // it has them: nothing is left to do
    assert_ok(context, run(&more, file, UINT64_MAX));
    check_same(&p, &more);
    picture_close(&p);
    picture_close(&more);
    clast_context_destroy(context);
}

// -------------------------------------------------------------------------------------------------------- other pictures

static void refuses(picture *p, const char *text)
{
    assert_int_equal(run(p, file, UINT64_MAX), CLAST_ERROR_INVALID_ARGUMENT);
    if (strstr(clast_context_error(p->context), text) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", clast_context_error(p->context), text);
    }
}

static void checkpoints_of_other_pictures_are_refused(void **state)
{
    (void)state;
    picture p = open_built(2, 12);
    clast_context *context = p.context;
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    clast_render_settings kept = p.settings;
    p.settings.height = SIZE - 1;
    refuses(&p, "for a picture of 37 x 37 pixels, not of 37 x 36");
    p.settings = kept;
    p.settings.crop = "1,2,3,4";
    refuses(&p, "for the crop 0,0,37,37, not for 1,2,3,4");
    p.settings = kept;
    p.settings.noise_target = 0.1;
    refuses(&p, "without a noise target");
    p.settings = kept;
    p.settings.bounces = 3;
    refuses(&p, "another value of the setting bounces");
    p.settings = kept;
    p.settings.seed = 3;
    refuses(&p, "another value of the setting seed");
    p.settings = kept;
    p.settings.env = "1,1,1";
    refuses(&p, "another value of the setting env");
    p.settings = kept;
    clast_camera camera = p.frame->settings.camera;
    p.frame->settings.camera.position.v[0] += 0.01f;
    refuses(&p, "for another camera");
    p.frame->settings.camera = camera;
    p.scene->materials[1].record.roughness = 0.81f;
    refuses(&p, "of another scene");
    p.scene->materials[1].record.roughness = 0.8f;
    float *position = (float *)(uintptr_t)p.scene->geometries[1].of.mesh.positions, before = *position;
    *position += 1e-3f;
    refuses(&p, "of another scene");
    *position = before;
    assert_ok(context, run(&p, file, UINT64_MAX));
    clast_render_output output = {CLAST_VIEW_COLOUR, p.pixels[CLAST_VIEW_COLOUR]};
    clast_render_request request = {&p.settings, &output, 1, {.resume = file}, "cpu"};
    assert_int_equal(clast_render_run(p.frame, &clast_cpu_backend, &request, &p.statistics),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "for other views"));
    close_built(&p);
}

// ------------------------------------------------------------------------------------------------------- hostile files

static size_t read_file(uint8_t **bytes)
{
    FILE *stream = fopen(file, "rb");
    assert_non_null(stream);
    assert_int_equal(fseek(stream, 0, SEEK_END), 0);
    size_t size = (size_t)ftell(stream);
    rewind(stream);
    *bytes = malloc(size);
    assert_non_null(*bytes);
    assert_int_equal(fread(*bytes, 1, size, stream), size);
    fclose(stream);
    return size;
}

static void write_file(const uint8_t *bytes, size_t size)
{
    FILE *stream = fopen(file, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, size, stream), size);
    fclose(stream);
}

static void write_with_checksum(uint8_t *bytes, size_t size)
{
    uint64_t sum = XXH3_64bits(bytes, size - 8);
    memcpy(bytes + size - 8, &sum, sizeof sum);
    write_file(bytes, size);
}

static void damaged_files_are_refused(void **state)
{
    (void)state;
    picture p = open_built(2, 3);
    clast_context *context = p.context;
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    uint8_t *bytes;
    size_t size = read_file(&bytes);
    const size_t lengths[] = {0, 7, 8, 100, 300, size / 2, size - 1};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        write_file(bytes, lengths[i]);
        assert_int_equal(run(&p, file, UINT64_MAX), CLAST_ERROR_MALFORMED);
    }
    for (size_t i = 0; i < size; i += size / 97) { // each of them is noticed
        bytes[i] ^= 0x10;
        write_file(bytes, size);
        assert_int_not_equal(run(&p, file, UINT64_MAX), CLAST_OK);
        bytes[i] ^= 0x10;
    }
    unlink(file);
    assert_int_equal(run(&p, file, UINT64_MAX), CLAST_ERROR_FILE_NOT_FOUND);
    free(bytes);
    close_built(&p);
}

// Whoever makes the checksum right can write any sums, but neither other sizes nor counts that a render cannot have.
static void forged_counts_are_refused(void **state)
{
    (void)state;
    picture p = open_built(1, 3);
    clast_context *context = p.context;
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    uint8_t *bytes;
    size_t size = read_file(&bytes);
    const size_t squares = 25, counts = size - 8 - squares - 4 * squares;
    for (uint32_t i = 0; i < 400; i++) {
        size_t place = i % 2 == 0 ? hash1(i) % 112 : counts + hash1(i) % (5 * squares);
        uint8_t before = bytes[place];
        bytes[place] = (uint8_t)hash1(i + 1000);
        write_with_checksum(bytes, size);
        clast_status status = run(&p, file, UINT64_MAX);
        bool may_work = bytes[place] == before || (place >= counts + 4 * squares && bytes[place] != 0) ||
                        (place >= 68 && place < 88); // what is not looked at, and what only tells progress
        assert_true(status != CLAST_OK || may_work);
        bytes[place] = before;
    }
    const uint32_t nan = 0x7fc00000u;
    memcpy(bytes + 4096, &nan, sizeof nan);
    write_with_checksum(bytes, size);
    assert_int_equal(run(&p, file, UINT64_MAX), CLAST_ERROR_MALFORMED);
    free(bytes);
    close_built(&p);
}

static void a_file_that_cannot_be_written_does_not_lose_the_picture(void **state)
{
    (void)state;
    picture p = open_built(2, 2);
    clast_context *context = p.context;
    assert_ok(context, run(&p, NULL, UINT64_MAX));
    float kept[PIXELS * 3];
    memcpy(kept, p.pixels[CLAST_VIEW_COLOUR], sizeof kept);
    clast_render_output output = {CLAST_VIEW_COLOUR, p.pixels[CLAST_VIEW_COLOUR]};
    clast_render_request request = {&p.settings, &output, 1, {NULL, "/nowhere/at/all", 1e-9}, "cpu"};
    assert_int_equal(clast_render_run(p.frame, &clast_cpu_backend, &request, &p.statistics), CLAST_ERROR_FILE_WRITE);
    assert_int_equal(p.statistics.samples, 2);
    assert_memory_equal(kept, p.pixels[CLAST_VIEW_COLOUR], sizeof kept);
    close_built(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interrupted_renders_have_the_same_bits),
        cmocka_unit_test(interrupted_renders_with_a_noise_target_have_the_same_bits),
        cmocka_unit_test(interrupted_renders_with_an_open_shutter_have_the_same_bits),
        cmocka_unit_test(a_finished_render_goes_on_with_more_samples),
        cmocka_unit_test(checkpoints_of_other_pictures_are_refused),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(forged_counts_are_refused),
        cmocka_unit_test(a_file_that_cannot_be_written_does_not_lose_the_picture),
    };
    if (mkdtemp(folder) == NULL) {
        return 1;
    }
    snprintf(file, sizeof file, "%s/a", folder);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(file);
    rmdir(folder);
    return failed;
}
