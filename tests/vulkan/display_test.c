// SPDX-License-Identifier: Apache-2.0
// Pictures of views, made on a device, against those of the processor.
#include <math.h>
#include <string.h>

#include "shared/random.h"
#include "test.h"
#include "vulkan/display.h"
#include "vulkan/test_device.h"

enum { WIDTH = 61, HEIGHT = 47, PIXELS = WIDTH * HEIGHT, SAMPLES = 4 }; // not whole words

static test_device device;

#define VIEW_LAYOUT(name, value, text, channels, is_float, help) [name] = {channels, is_float},
static const struct {
    uint32_t channels;
    bool is_float;
} layouts[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(VIEW_LAYOUT)};

// Values as renders have them: of all sizes, negative ones too, and pixels where nothing is.
static void make_values(clast_view view, uint32_t *values)
{
    for (uint32_t i = 0; i < PIXELS * layouts[view].channels; i++) {
        uint32_t bits = hash2(view, i);
        float u = unit_float(bits), real = view == CLAST_VIEW_NORMAL ? 2.0f * u - 1.0f : expf(14.0f * u - 9.0f);
        real = view == CLAST_VIEW_UV ? 8.0f * u - 4.0f : real;
        bool is_empty = hash1(i / layouts[view].channels) % 16 == 0;
        float nothing = view == CLAST_VIEW_DEPTH ? INFINITY : 0.0f;
        float given = is_empty ? nothing : real;
        values[i] = is_empty ? CLAST_NONE : bits >> 9 & 0xffff;
        if (layouts[view].is_float) {
            memcpy(&values[i], &given, sizeof given);
        }
    }
}

// On the device the values of views that are means are sums over samples.
static bool is_mean(clast_view view)
{
    return view == CLAST_VIEW_COLOUR || view == CLAST_VIEW_ALBEDO || view == CLAST_VIEW_NORMAL;
}

static void make_sums(clast_view view, const uint32_t *values, uint32_t *sums)
{
    for (uint32_t i = 0; i < PIXELS * layouts[view].channels; i++) {
        float value;
        memcpy(&value, &values[i], sizeof value);
        value *= SAMPLES;
        sums[i] = values[i];
        if (is_mean(view)) {
            memcpy(&sums[i], &value, sizeof value);
        }
    }
}

static void display_on_device(clast_view view, const clast_render_settings *settings, const uint32_t *values,
                              uint32_t bits, void *pixels)
{
    clast_gpu_buffer given, range, made;
    uint64_t bytes = (uint64_t)PIXELS * layouts[view].channels * 4,
             display_bytes = clast_gpu_display_bytes(WIDTH, HEIGHT, bits);
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, bytes, "values", &given));
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, CLAST_GPU_DISPLAY_RANGE, "range", &range));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, display_bytes, "pixels", &made));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &given, 0, values, bytes);
    clast_gpu_barrier(commands);
    clast_gpu_display_desc desc = {.view = view,
                                   .values = given.address,
                                   .scale = 1.0f / SAMPLES,
                                   .width = WIDTH,
                                   .height = HEIGHT,
                                   .bits = bits,
                                   .how = clast_display_of(settings),
                                   .pixels = made.address};
    clast_gpu_display(commands, &desc, &range);
    clast_gpu_read(commands, &made, 0, pixels, (uint64_t)PIXELS * 3 * bits / 8);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &given);
    clast_gpu_free(device.gpu, &range);
    clast_gpu_free(device.gpu, &made);
}

static void compare(clast_view view, const clast_render_settings *settings, const uint32_t *values)
{
    static uint32_t sums[3 * PIXELS];
    static uint8_t bytes[3 * PIXELS], device_bytes[3 * PIXELS];
    static uint16_t words[3 * PIXELS], device_words[3 * PIXELS];
    make_sums(view, values, sums);
    assert_ok(device.context, clast_view_to_display(device.context, view, values, WIDTH, HEIGHT, settings, bytes));
    assert_ok(device.context, clast_view_to_display_16(device.context, view, values, WIDTH, HEIGHT, settings, words));
    display_on_device(view, settings, sums, 8, device_bytes);
    display_on_device(view, settings, sums, 16, device_words);
    uint32_t differ = 0;
    for (uint32_t i = 0; i < 3 * PIXELS; i++) {
        int step = abs((int)bytes[i] - device_bytes[i]), fine = abs((int)words[i] - device_words[i]);
        if (step > 1 || fine > 16) {
            fail_msg("view %d, value %u: %u and %u, not %u and %u", (int)view, i, device_bytes[i], device_words[i],
                     bytes[i], words[i]);
        }
        differ += step != 0;
    }
    assert_true(differ < 3 * PIXELS / 100); // only at borders between two steps
}

static void pictures_are_those_of_the_processor(void **state)
{
    (void)state;
    static uint32_t values[3 * PIXELS];
    for (int view = 0; view < CLAST_VIEW_COUNT_; view++) {
        clast_render_settings settings = {.exposure = 1.5, .segment = 2.0};
        make_values((clast_view)view, values);
        uint32_t curves = view == CLAST_VIEW_COLOUR ? 4 : 1;
        for (uint32_t curve = 0; curve < curves; curve++) {
            settings.tonemap = (clast_tone_map)curve;
            compare((clast_view)view, &settings, values);
        }
    }
}

// Nothing but sky: there is no range.
static void pictures_of_nothing_are_black(void **state)
{
    (void)state;
    static uint32_t values[PIXELS];
    static uint8_t bytes[3 * PIXELS];
    const float nothing = INFINITY;
    for (uint32_t i = 0; i < PIXELS; i++) {
        memcpy(&values[i], &nothing, sizeof nothing);
    }
    clast_render_settings settings = {0};
    display_on_device(CLAST_VIEW_DEPTH, &settings, values, 8, bytes);
    for (uint32_t i = 0; i < 3 * PIXELS; i++) {
        assert_int_equal(bytes[i], 0);
    }
    memset(values, 0xff, sizeof values);
    display_on_device(CLAST_VIEW_STEPS, &settings, values, 8, bytes);
    for (uint32_t i = 0; i < 3 * PIXELS; i++) {
        assert_int_equal(bytes[i], 0);
    }
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_those_of_the_processor),
        cmocka_unit_test(pictures_of_nothing_are_black),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
