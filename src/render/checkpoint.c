// SPDX-License-Identifier: Apache-2.0
// The file of a checkpoint: a header; a number for each setting; sums and views in the order of CLAST_VIEW_LIST, sums of halves,
// noise, samples of squares and which of them go on; a checksum of all before it. A header that agrees with the render says how
// long the rest is.
#include "render/checkpoint.h"

#define XXH_INLINE_ALL
#include <string.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/size.h"
#include "base/thread.h"
#include "clast/version.h"

static const char MAGIC[8] = {'c', 'l', 'a', 's', 't', 'c', 'k', 'p'};
enum { FORMAT = 1, INTERVAL = 300 };

typedef struct checkpoint_header {
    char magic[8];
    uint32_t format;
    uint32_t version[3]; // of clast
    uint32_t setting_count;
    uint32_t views; // a bit each
    uint32_t width, height;
    clast_render_area area;
    uint32_t by_noise;
    uint32_t sample;
    uint32_t done; // active squares that have it
    uint32_t power;
    uint64_t work, expected;
    uint64_t camera, scene, device;
} checkpoint_header;
_Static_assert(sizeof(checkpoint_header) == 8 + 16 * 4 + 5 * 8, "without padding");

// A part of the file after the settings.
typedef struct checkpoint_part {
    void *data; // the target's
    size_t count, size;
} checkpoint_part;

enum { PARTS_MOST = CLAST_VIEW_COUNT_ + 4 };

#define VIEW_CHANNELS(name, value, text, channels, is_float, help) [name] = channels,
static const uint32_t view_channels[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(VIEW_CHANNELS)};

static void *pixels_of(const clast_render_target *target, int view)
{
    return target->sums[view] != NULL ? (void *)target->sums[view] : (void *)target->firsts[view];
}

// All but which squares go on, a byte for each square, which ends the file.
static size_t list_parts(const clast_render_target *target, checkpoint_part parts[PARTS_MOST])
{
    size_t pixels = (size_t)target->area.width * target->area.height, count = 0;
    const clast_squares *squares = &target->squares;
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        if (pixels_of(target, view) != NULL && view != CLAST_VIEW_SAMPLES) {
            parts[count++] = (checkpoint_part){pixels_of(target, view), pixels, view_channels[view] * sizeof(float)};
        }
    }
    if (target->halves != NULL) {
        parts[count++] = (checkpoint_part){target->halves, pixels, 3 * sizeof(float)};
        parts[count++] = (checkpoint_part){squares->noise, squares->count, sizeof *squares->noise};
    }
    parts[count++] = (checkpoint_part){squares->samples, squares->count, sizeof *squares->samples};
    return count;
}

static checkpoint_header header_of(const clast_checkpoint_keeper *keeper, const clast_render_target *target)
{
    checkpoint_header header = {
        .format = FORMAT,
        .version = {CLAST_VERSION_MAJOR, CLAST_VERSION_MINOR, CLAST_VERSION_PATCH},
        .setting_count = CLAST_SETTING_COUNT,
        .width = target->width,
        .height = target->height,
        .area = target->area,
        .by_noise = target->halves != NULL,
        .sample = target->sample,
        .done = target->squares.done,
        .power = target->power,
        .work = target->squares.work,
        .expected = target->squares.expected,
        .camera = keeper->camera,
        .scene = keeper->scene,
        .device = XXH3_64bits(keeper->device, strlen(keeper->device)),
    };
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        header.views |= pixels_of(target, view) != NULL ? 1u << view : 0;
    }
    return header;
}

// -------------------------------------------------------------------------------------------------------------- writing

typedef struct checkpoint_writer {
    clast_file_output output;
    XXH3_state_t *state;
} checkpoint_writer;

static void write_piece(checkpoint_writer *writer, const void *data, size_t bytes)
{
    XXH3_64bits_update(writer->state, data, bytes);
    clast_file_write(&writer->output, data, bytes);
}

static void write_all(checkpoint_writer *writer, const checkpoint_header *header, const clast_render_target *target,
                      const uint8_t *goes_on)
{
    uint64_t settings[CLAST_SETTING_COUNT];
    checkpoint_part parts[PARTS_MOST];
    size_t count = list_parts(target, parts);
    clast_settings_identity(&target->settings, settings);
    XXH3_64bits_reset(writer->state);
    write_piece(writer, header, sizeof *header);
    write_piece(writer, settings, sizeof settings);
    for (size_t i = 0; i < count; i++) {
        write_piece(writer, parts[i].data, parts[i].count * parts[i].size);
    }
    write_piece(writer, goes_on, target->squares.count);
    uint64_t sum = XXH3_64bits_digest(writer->state);
    clast_file_write(&writer->output, &sum, sizeof sum);
}

clast_status clast_checkpoint_save(const clast_frame *frame, clast_checkpoint_keeper *keeper,
                                   const clast_render_target *target)
{
    clast_context *context = frame->context;
    checkpoint_header header = header_of(keeper, target);
    checkpoint_writer writer = {.state = clast_allocate(context, 1, sizeof *writer.state)};
    uint8_t *goes_on = clast_allocate_zeroed(context, target->squares.count, 1);
    clast_status status = writer.state != NULL && goes_on != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        status = clast_file_create(context, keeper->files.save, &writer.output);
    }
    if (status == CLAST_OK) {
        for (uint32_t i = 0; i < target->squares.active_count; i++) {
            goes_on[target->squares.active[i]] = 1;
        }
        write_all(&writer, &header, target, goes_on);
        status = clast_file_commit(&writer.output);
    }
    clast_free(context, writer.state);
    clast_free(context, goes_on);
    keeper->saved = clast_clock();
    keeper->failed = status != CLAST_OK;
    return status;
}

// -------------------------------------------------------------------------------------------------------------- reading

// How long a file of this render is. False where no memory could hold it.
static bool file_size(const clast_render_target *target, size_t *size)
{
    checkpoint_part parts[PARTS_MOST];
    size_t count = list_parts(target, parts);
    *size = sizeof(checkpoint_header) + CLAST_SETTING_COUNT * sizeof(uint64_t) + sizeof(uint64_t);
    bool fits = clast_add_size(*size, target->squares.count, size);
    for (size_t i = 0; i < count && fits; i++) {
        size_t bytes;
        fits = clast_multiply_size(parts[i].count, parts[i].size, &bytes) && clast_add_size(*size, bytes, size);
    }
    return fits;
}

#define REFUSE(...) return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, __VA_ARGS__)

// Whether the file is one of this picture.
static clast_status compare(clast_context *context, const char *path, const checkpoint_header *found,
                            const checkpoint_header *wanted, const char *device)
{
    const clast_render_area *a = &found->area, *b = &wanted->area;
    if (found->width != wanted->width || found->height != wanted->height) {
        REFUSE("%s: the checkpoint was made for a picture of %u x %u pixels, not of %u x %u", path, found->width,
               found->height, wanted->width, wanted->height);
    }
    if (a->x != b->x || a->y != b->y || a->width != b->width || a->height != b->height) {
        REFUSE("%s: the checkpoint was made for the crop %u,%u,%u,%u, not for %u,%u,%u,%u", path, a->x, a->y, a->width,
               a->height, b->x, b->y, b->width, b->height);
    }
    if (found->by_noise != wanted->by_noise) {
        REFUSE("%s: the checkpoint was made %s a noise target", path, wanted->by_noise != 0 ? "without" : "with");
    }
    if (found->views != wanted->views) {
        REFUSE("%s: the checkpoint was made for other views", path);
    }
    if (found->camera != wanted->camera) {
        REFUSE("%s: the checkpoint was made for another camera", path);
    }
    if (found->device != wanted->device) {
        REFUSE("%s: the checkpoint was made by another device, or another version of its driver, than %s", path,
               device);
    }
    if (found->scene != wanted->scene) {
        REFUSE("%s: the checkpoint was made of another scene, or of another moment of it", path);
    }
    return CLAST_OK;
}

static clast_status compare_settings(clast_context *context, const char *path, const clast_file_view *file,
                                     const clast_render_settings *settings)
{
    uint64_t found[CLAST_SETTING_COUNT], wanted[CLAST_SETTING_COUNT];
    memcpy(found, (const char *)file->data + sizeof(checkpoint_header), sizeof found);
    clast_settings_identity(settings, wanted);
    for (int i = 0; i < CLAST_SETTING_COUNT; i++) {
        if (found[i] != wanted[i]) {
            REFUSE("%s: the checkpoint was made with another value of the setting %s", path, clast_setting_names[i]);
        }
    }
    return CLAST_OK;
}

static clast_status check_file(clast_context *context, const char *path, const clast_file_view *file)
{
    checkpoint_header found;
    size_t least = sizeof found + CLAST_SETTING_COUNT * sizeof(uint64_t) + sizeof(uint64_t);
    if (file->size < sizeof MAGIC || memcmp(file->data, MAGIC, sizeof MAGIC) != 0) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the file is no checkpoint of clast", path);
    }
    if (file->size < least) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the checkpoint is cut short", path);
    }
    memcpy(&found, file->data, sizeof found);
    const uint32_t *v = found.version;
    if (found.format != FORMAT || v[0] != CLAST_VERSION_MAJOR || v[1] != CLAST_VERSION_MINOR ||
        v[2] != CLAST_VERSION_PATCH || found.setting_count != CLAST_SETTING_COUNT) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: the checkpoint was made by another version of clast",
                          path);
    }
    return CLAST_OK;
}

// All sums are finite, as samples that are not count as black; depths may be infinite.
static bool sums_are_finite(const clast_render_target *target)
{
    const float *const sums[] = {target->sums[CLAST_VIEW_COLOUR], target->sums[CLAST_VIEW_ALBEDO],
                                 target->sums[CLAST_VIEW_NORMAL], target->halves};
    size_t count = 3 * (size_t)target->area.width * target->area.height;
    bool finite = true;
    for (size_t i = 0; i < sizeof sums / sizeof *sums; i++) {
        for (size_t k = 0; sums[i] != NULL && k < count; k++) {
            finite = finite && is_finite1(sums[i][k]);
        }
    }
    return finite;
}

// Whether the squares are in a state that a render can be in.
static bool squares_are_sound(const clast_render_target *target, const checkpoint_header *found, const uint8_t *goes_on)
{
    const clast_squares *squares = &target->squares;
    uint64_t work = 0;
    bool sound = found->done <= squares->active_count && found->sample <= 1u << 20 && found->power <= 20 &&
                 (found->done == 0 || found->done < squares->active_count);
    for (uint32_t i = 0; i < squares->count && sound; i++) {
        sound = goes_on[i] != 0 || (squares->samples[i] <= found->sample && squares->noise != NULL);
        work += (uint64_t)squares->samples[i] * clast_square_pixels(squares, i);
    }
    for (uint32_t i = 0; i < squares->active_count && sound; i++) {
        sound = squares->samples[squares->active[i]] == found->sample + (i < found->done);
    }
    return sound && work == found->work;
}

static clast_status take(clast_context *context, const char *path, const clast_file_view *file,
                         clast_render_target *target)
{
    checkpoint_header found;
    checkpoint_part parts[PARTS_MOST];
    size_t count = list_parts(target, parts), size;
    uint64_t sum;
    memcpy(&found, file->data, sizeof found);
    if (!file_size(target, &size) || file->size != size) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the checkpoint has %llu bytes, not %zu", path,
                          (unsigned long long)file->size, size);
    }
    memcpy(&sum, (const char *)file->data + size - sizeof sum, sizeof sum);
    if (sum != XXH3_64bits(file->data, size - sizeof sum)) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the checkpoint is damaged: its checksum differs", path);
    }
    const uint8_t *from = (const uint8_t *)file->data + sizeof found + CLAST_SETTING_COUNT * sizeof(uint64_t);
    for (size_t i = 0; i < count; i++) {
        memcpy(parts[i].data, from, parts[i].count * parts[i].size);
        from += parts[i].count * parts[i].size;
    }
    clast_squares_choose(&target->squares, from);
    if (!squares_are_sound(target, &found, from) || !sums_are_finite(target)) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the checkpoint's counts or sums cannot be a render's",
                          path);
    }
    target->sample = target->first_sample = found.sample;
    target->squares.done = found.done;
    target->power = found.power; // samples beyond are laid out anew
    target->squares.work = target->first_work = found.work;
    target->squares.expected = found.expected;
    target->is_resumed = true;
    return CLAST_OK;
}

static clast_status resume(const clast_frame *frame, const clast_checkpoint_keeper *keeper, clast_render_target *target)
{
    clast_context *context = frame->context;
    const char *path = keeper->files.resume;
    clast_file_view file;
    clast_status status = clast_file_map(context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    status = check_file(context, path, &file);
    if (status == CLAST_OK) {
        checkpoint_header found, wanted = header_of(keeper, target);
        memcpy(&found, file.data, sizeof found);
        status = compare(context, path, &found, &wanted, keeper->device);
    }
    if (status == CLAST_OK) {
        status = compare_settings(context, path, &file, &target->settings);
    }
    if (status == CLAST_OK) {
        status = take(context, path, &file, target);
    }
    clast_file_unmap(context, &file);
    return status;
}

clast_status clast_checkpoint_begin(const clast_frame *frame, clast_checkpoint_keeper *keeper,
                                    clast_render_target *target)
{
    if (keeper->files.resume == NULL && keeper->files.save == NULL) {
        return CLAST_OK;
    }
    keeper->files.interval = keeper->files.interval > 0.0 ? keeper->files.interval : INTERVAL;
    keeper->saved = clast_clock();
    keeper->camera = clast_camera_identity(frame);
    clast_status status = clast_scene_identity(frame, &keeper->scene);
    return status == CLAST_OK && keeper->files.resume != NULL ? resume(frame, keeper, target) : status;
}
