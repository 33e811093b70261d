// SPDX-License-Identifier: Apache-2.0
// Displacement maps: what their levels hold, how they are read, and that bounds hold all that can be read.
#include "scarce.h"

#include <math.h>
#include <string.h>

#include "source/height_make.h"

static const clast_wrap ways[] = {CLAST_WRAP_REPEAT, CLAST_WRAP_CLAMP, CLAST_WRAP_MIRROR};
enum { WAYS = 3 };

static uint32_t random_state = 1;

static float random_between(float low, float high)
{
    random_state = random_state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(random_state >> 8) * 0x1p-24f;
}

static uint32_t random_below(uint32_t end)
{
    return (uint32_t)random_between(0.0f, (float)end - 0.01f);
}

// ------------------------------------------------------------------------------------------------------------- worlds

typedef struct world {
    clast_scene *scene;
    clast_height_store *store;
    uint32_t texture;
    const clast_height *height;
} world;

static world open_image(clast_context *context, clast_image image, clast_wrap wrap_u, clast_wrap wrap_v)
{
    world w;
    uint32_t number;
    assert_ok(context, clast_scene_create(context, &w.scene));
    assert_ok(context, clast_height_store_create(context, &w.store));
    assert_ok(context, clast_scene_add_image(w.scene, &image, NULL, &number));
    clast_texture texture = {number, wrap_u, wrap_v, CLAST_FILTER_LINEAR};
    assert_ok(context, clast_scene_add_texture(w.scene, &texture, &w.texture));
    assert_ok(context, clast_height_acquire(w.store, w.scene, w.texture, &w.height));
    return w;
}

static void close_world(world *w)
{
    clast_height_release(w->store, w->height);
    clast_height_store_destroy(w->store);
    clast_scene_destroy(w->scene);
}

// Of one channel, all values different from their neighbours'.
static world open_random(clast_context *context, uint32_t width, uint32_t rows, clast_pixel_type type,
                         clast_wrap wrap_u, clast_wrap wrap_v)
{
    size_t texels = (size_t)width * rows;
    float *floats = malloc(texels * sizeof *floats);
    uint16_t *words = malloc(texels * sizeof *words);
    uint8_t *bytes = malloc(texels);
    for (size_t i = 0; i < texels; i++) {
        float value = random_between(0.0f, 1.0f);
        floats[i] = 20.0f * value - 10.0f;
        words[i] = (uint16_t)(value * 65535.0f);
        bytes[i] = (uint8_t)(value * 255.0f);
    }
    const void *pixels = type == CLAST_PIXEL_FLOAT    ? (const void *)floats
                         : type == CLAST_PIXEL_UNORM8 ? (const void *)bytes
                                                      : (const void *)words;
    world w = open_image(context, (clast_image){width, rows, 1, type, pixels}, wrap_u, wrap_v);
    free(floats);
    free(words);
    free(bytes);
    return w;
}

static double texel(const clast_height *height, uint32_t level, int64_t x, int64_t y)
{
    return (double)clast_height_texel(height, clast_height_place(&height->map, level, x, y));
}

// ------------------------------------------------------------------------------------------------------------- levels

static void the_first_channel_counts(void **state)
{
    static const uint8_t bytes[] = {0, 9, 9, 255, 9, 9, 10, 9, 9, 128, 9, 9};
    world w = open_image(*state, (clast_image){2, 2, 3, CLAST_PIXEL_UNORM8, bytes}, CLAST_WRAP_CLAMP, CLAST_WRAP_CLAMP);
    assert_true(clast_height_value(w.height, vec2(0.25f, 0.25f), 0.0f) == 0.0f);
    assert_true(clast_height_value(w.height, vec2(0.75f, 0.25f), 0.0f) == 1.0f);
    assert_float_equal(clast_height_value(w.height, vec2(0.25f, 0.75f), 0.0f), 10.0f / 255.0f, 1e-7f);
    assert_float_equal(clast_height_value(w.height, vec2(0.75f, 0.75f), 0.0f), 128.0f / 255.0f, 1e-7f);
    close_world(&w);
}

static void floats_stay_as_they_are(void **state)
{
    static const float floats[] = {-3.5f, 1e6f};
    world w = open_image(*state, (clast_image){2, 1, 1, CLAST_PIXEL_FLOAT, floats}, CLAST_WRAP_REPEAT,
                         CLAST_WRAP_REPEAT);
    assert_true(clast_height_value(w.height, vec2(0.25f, 0.5f), 0.0f) == -3.5f);
    assert_true(clast_height_value(w.height, vec2(0.75f, 0.5f), 0.0f) == 1e6f);
    close_world(&w);
}

// The mean of a level over a box, by how much of each texel lies in it.
static double box_mean(const clast_height *height, uint32_t level, double left, double right, double top, double bottom)
{
    double sum = 0.0;
    for (int64_t y = (int64_t)top; (double)y < bottom - 1e-9; y++) {
        for (int64_t x = (int64_t)left; (double)x < right - 1e-9; x++) {
            double across = fmin(right, (double)x + 1.0) - fmax(left, (double)x);
            double down = fmin(bottom, (double)y + 1.0) - fmax(top, (double)y);
            sum += texel(height, level, x, y) * fmax(across, 0.0) * fmax(down, 0.0);
        }
    }
    return sum / ((right - left) * (bottom - top));
}

static void assert_levels_are_means(const clast_height *height)
{
    const clast_height_map *map = &height->map;
    for (uint32_t level = 1; level < map->level_count; level++) {
        uint32_t width = map->widths[level], rows = map->heights[level];
        double across = (double)map->widths[level - 1] / width, down = (double)map->heights[level - 1] / rows;
        for (uint32_t y = 0; y < rows; y++) {
            for (uint32_t x = 0; x < width; x++) {
                double mean = box_mean(height, level - 1, x * across, (x + 1) * across, y * down, (y + 1) * down);
                assert_true(fabs(texel(height, level, x, y) - mean) <= (map->is_float ? 1e-5 : 0.5 + 1e-6));
            }
        }
    }
    assert_int_equal(map->widths[map->level_count - 1], 1);
    assert_int_equal(map->heights[map->level_count - 1], 1);
}

static void levels_are_means_of_those_before(void **state)
{
    static const uint32_t sizes[][2] = {{16, 16}, {37, 22}, {1, 1}, {5, 1}, {1, 64}, {127, 3}, {30, 61}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        for (int type = CLAST_PIXEL_UNORM8; type <= CLAST_PIXEL_FLOAT; type++) {
            world w = open_random(*state, sizes[i][0], sizes[i][1], (clast_pixel_type)type, ways[i % WAYS],
                                  ways[(i + 1) % WAYS]);
            assert_levels_are_means(w.height);
            close_world(&w);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- reading

// The texel that a way of wrapping puts at a place outside.
static int64_t wrapped(int64_t place, clast_wrap wrap, int64_t size)
{
    int64_t turn = place >= 0 ? place / size : -((size - 1 - place) / size), within = place - turn * size;
    if (wrap == CLAST_WRAP_REPEAT) {
        return within;
    }
    if (wrap == CLAST_WRAP_MIRROR) {
        return turn % 2 == 0 ? within : size - 1 - within;
    }
    return place < 0 ? 0 : place >= size ? size - 1 : place;
}

// Bilinear, in double precision, over the endless picture that wrapping makes. Clamped coordinates stop at the edges.
static double plain_value(const clast_height *height, clast_wrap wrap_u, clast_wrap wrap_v, vec2 at, uint32_t level)
{
    const clast_height_map *map = &height->map;
    double u = (double)at[0], v = (double)at[1];
    u = wrap_u == CLAST_WRAP_CLAMP ? fmin(fmax(u, 0.0), 1.0) : u;
    v = wrap_v == CLAST_WRAP_CLAMP ? fmin(fmax(v, 0.0), 1.0) : v;
    double x = u * map->widths[level] - 0.5, y = v * map->heights[level] - 0.5;
    int64_t column = (int64_t)floor(x), row = (int64_t)floor(y);
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        double across = k % 2 == 0 ? 1.0 - (x - (double)column) : x - (double)column;
        double down = k / 2 == 0 ? 1.0 - (y - (double)row) : y - (double)row;
        sum += across * down *
               texel(height, level, wrapped(column + k % 2, wrap_u, map->widths[level]),
                     wrapped(row + k / 2, wrap_v, map->heights[level]));
    }
    return sum * (double)map->unit;
}

static void heights_are_bilinear_however_coordinates_wrap(void **state)
{
    for (int way = 0; way < WAYS * WAYS; way++) {
        clast_wrap wrap_u = ways[way % WAYS], wrap_v = ways[way / WAYS];
        world w = open_random(*state, 13, 8, CLAST_PIXEL_UNORM16, wrap_u, wrap_v);
        for (int i = 0; i < 500; i++) {
            vec2 at = vec2(random_between(-3.0f, 3.0f), random_between(-3.0f, 3.0f));
            float level = random_between(0.0f, 3.0f), share = level - floorf(level);
            double finer = plain_value(w.height, wrap_u, wrap_v, at, (uint32_t)level);
            double coarser = plain_value(w.height, wrap_u, wrap_v, at, (uint32_t)fmin((double)level + 1.0, 3.0));
            double wanted = finer * (1.0 - (double)share) + coarser * (double)share;
            assert_true(fabs((double)clast_height_value(w.height, at, level) - wanted) < 2e-5);
        }
        close_world(&w);
    }
}

static void heights_are_continuous_where_coordinates_wrap(void **state)
{
    for (int way = 0; way < WAYS; way++) {
        world w = open_random(*state, 32, 32, CLAST_PIXEL_UNORM16, ways[way], ways[way]);
        for (int i = -2; i <= 2; i++) {
            float v = random_between(0.0f, 1.0f), turn = (float)i;
            float before = clast_height_value(w.height, vec2(turn - 1e-5f, v), 0.5f);
            float after = clast_height_value(w.height, vec2(turn + 1e-5f, v), 0.5f);
            assert_float_equal(before, after, 1e-3f);
        }
        close_world(&w);
    }
}

static void slopes_are_those_of_the_heights(void **state)
{
    for (int way = 0; way < WAYS * WAYS; way++) {
        world w = open_random(*state, 9, 16, CLAST_PIXEL_FLOAT, ways[way % WAYS], ways[way / WAYS]);
        int far = 0;
        for (int i = 0; i < 300; i++) {
            const float step = 1e-4f;
            vec2 at = vec2(random_between(-2.0f, 2.0f), random_between(-2.0f, 2.0f));
            float level = random_between(0.0f, 2.0f);
            clast_height_slope slope = clast_height_value_and_slope(w.height, at, level);
            assert_true(slope.height == clast_height_value(w.height, at, level));
            vec2 found = load2(slope.slope);
            for (int k = 0; k < 2; k++) {
                vec2 aside = k == 0 ? vec2(step, 0.0f) : vec2(0.0f, step);
                float run = clast_height_value(w.height, at + aside, level) -
                            clast_height_value(w.height, at - aside, level);
                far += fabsf(run / (2.0f * step) - found[k]) > 1.0f + 0.01f * fabsf(found[k]);
            }
        }
        assert_true(far < 20); // where the step crosses from texel to texel
        close_world(&w);
    }
}

static void coordinates_that_are_no_numbers_are_read_somewhere(void **state)
{
    static const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 3e9f, 1e-40f};
    for (int way = 0; way < WAYS; way++) {
        world w = open_random(*state, 7, 5, CLAST_PIXEL_UNORM16, ways[way], ways[way]);
        for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
            float value = clast_height_value(w.height, vec2(odd[i], 0.3f), odd[i]);
            assert_true(value >= 0.0f && value <= 1.0f);
        }
        close_world(&w);
    }
}

// ------------------------------------------------------------------------------------------------------------- bounds

static vec2 inside(const vec2 corners[3])
{
    float a = random_between(0.0f, 1.0f), b = random_between(0.0f, 1.0f - a);
    switch (random_below(8)) {
    case 0: a = 0.0f; break;
    case 1: a = 0.0f, b = 1.0f; break;
    case 2: a = 1.0f, b = 0.0f; break;
    default: break;
    }
    return corners[0] * (1.0f - a - b) + corners[1] * a + corners[2] * b;
}

static void bounds_hold_whatever_is_read(void **state)
{
    static const uint32_t sizes[][2] = {{200, 150}, {64, 64}, {1, 1}, {37, 300}, {3, 5}};
    for (int way = 0; way < WAYS * WAYS; way++) {
        const uint32_t *size = sizes[way % 5];
        world w = open_random(*state, size[0], size[1], way % 2 == 0 ? CLAST_PIXEL_UNORM16 : CLAST_PIXEL_FLOAT,
                              ways[way % WAYS], ways[way / WAYS]);
        float last = (float)(w.height->map.level_count - 1);
        for (int i = 0; i < 400; i++) {
            float extent = powf(2.0f, random_between(-12.0f, 1.5f)),
                  most = random_below(3) * random_between(0.0f, last) * 0.5f;
            vec2 first = vec2(random_between(-3.0f, 3.0f), random_between(-3.0f, 3.0f)), corners[3];
            for (int k = 0; k < 3; k++) {
                corners[k] = first + vec2(random_between(-extent, extent), random_between(-extent, extent));
            }
            clast_height_range range = clast_height_bounds(w.height, corners, most);
            for (int k = 0; k < 30; k++) {
                float value = clast_height_value(w.height, inside(corners),
                                                 k % 2 == 0 ? most : random_between(0.0f, most));
                assert_true(value >= range.lower && value <= range.upper);
            }
        }
        close_world(&w);
    }
}

static void bounds_are_near(void **state)
{
    enum { SIDE = 1024 };
    uint16_t *ramp = malloc(SIDE * SIDE * sizeof *ramp);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        ramp[i] = (uint16_t)(i % SIDE * 64);
    }
    world w = open_image(*state, (clast_image){SIDE, SIDE, 1, CLAST_PIXEL_UNORM16, ramp}, CLAST_WRAP_REPEAT,
                         CLAST_WRAP_REPEAT);
    free(ramp);
    // a triangle of 100 texels, its height that of 100; and one of a texel
    const vec2 large[3] = {vec2(0.3f, 0.3f), vec2(0.3f + 100.0f / SIDE, 0.3f), vec2(0.3f, 0.3f + 100.0f / SIDE)};
    const vec2 small[3] = {vec2(0.3f, 0.3f), vec2(0.3f + 1.0f / SIDE, 0.3f), vec2(0.3f, 0.3f + 1.0f / SIDE)};
    clast_height_range range = clast_height_bounds(w.height, large, 0.0f);
    assert_true((range.upper - range.lower) * 65535.0f / 64.0f < 150.0f);
    range = clast_height_bounds(w.height, small, 0.0f);
    assert_true((range.upper - range.lower) * 65535.0f / 64.0f < 12.0f);
    close_world(&w);
}

static void bounds_of_unknown_places_hold_everything(void **state)
{
    world w = open_random(*state, 50, 50, CLAST_PIXEL_UNORM8, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT);
    const vec2 corners[3] = {vec2(NAN, 0.0f), vec2(0.0f, 1e30f), vec2(0.0f, 0.0f)};
    clast_height_range range = clast_height_bounds(w.height, corners, 0.0f);
    for (int i = 0; i < 500; i++) {
        float value = clast_height_value(w.height, vec2(random_between(0.0f, 1.0f), random_between(0.0f, 1.0f)), 0.0f);
        assert_true(value >= range.lower && value <= range.upper);
    }
    close_world(&w);
}

// ------------------------------------------------------------------------------------------------------------- store

static void units_share_maps(void **state)
{
    clast_context *context = *state;
    world w = open_random(context, 8, 8, CLAST_PIXEL_UNORM8, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT);
    uint32_t same, mirrored;
    clast_texture texture = w.scene->textures[w.texture];
    assert_ok(context, clast_scene_add_texture(w.scene, &texture, &same));
    texture.wrap_u = CLAST_WRAP_MIRROR;
    assert_ok(context, clast_scene_add_texture(w.scene, &texture, &mirrored));
    const clast_height *second, *third;
    assert_ok(context, clast_height_acquire(w.store, w.scene, same, &second));
    assert_ptr_equal(second, w.height);
    assert_ok(context, clast_height_acquire(w.store, w.scene, mirrored, &third));
    assert_ptr_not_equal(third, w.height);
    assert_true(third->hash != w.height->hash);
    clast_height_release(w.store, third);
    clast_height_release(w.store, w.height);
    assert_true(clast_height_value(second, vec2(0.5f, 0.5f), 0.0f) >= 0.0f); // is there still
    uint64_t before = clast_context_memory(context);
    clast_height_release(w.store, second);
    assert_true(clast_context_memory(context) < before);
    w.height = NULL;
    close_world(&w);
}

static void textures_that_are_not_there_are_refused(void **state)
{
    clast_context *context = *state;
    world w = open_random(context, 2, 2, CLAST_PIXEL_UNORM8, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT);
    const clast_height *height = NULL;
    assert_int_equal(clast_height_acquire(w.store, w.scene, 7, &height), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "texture 7"));
    close_world(&w);
}

static void maps_of_too_many_texels_are_refused(void **state)
{
    clast_context *context = *state;
    const clast_texture texture = {0};
    clast_height height = {0};
    clast_image image = {65536, 65536, 1, CLAST_PIXEL_UNORM8, NULL};
    assert_int_equal(clast_height_lay_out(context, &image, &texture, &height), CLAST_ERROR_LIMIT);
    image.height = 16384; // 1.4 thousand million with all levels
    assert_ok(context, clast_height_lay_out(context, &image, &texture, &height));
    assert_int_equal(height.map.level_count, HEIGHT_LEVELS);
    assert_int_equal(height.map.widths[HEIGHT_LEVELS - 1], 2);
}

static void count_line(void *user, clast_log_level level, const char *line)
{
    assert_int_equal(level, CLAST_LOG_WARNING);
    assert_non_null(strstr(line, "3 heights"));
    (*(int *)user)++;
}

static void heights_that_are_no_numbers_count_as_zero(void **state)
{
    (void)state;
    static const float floats[] = {NAN, INFINITY, -INFINITY, 2.0f};
    int lines = 0;
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .log = {count_line, &lines}};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    world w = open_image(context, (clast_image){2, 2, 1, CLAST_PIXEL_FLOAT, floats}, CLAST_WRAP_CLAMP,
                         CLAST_WRAP_CLAMP);
    assert_int_equal(lines, 1);
    assert_true(clast_height_value(w.height, vec2(0.0f, 0.0f), 0.0f) == 0.0f);
    assert_true(clast_height_value(w.height, vec2(1.0f, 0.0f), 0.0f) == 0.0f);
    assert_true(clast_height_value(w.height, vec2(1.0f, 1.0f), 0.0f) == 2.0f);
    assert_true(clast_height_value(w.height, vec2(0.3f, 0.6f), 1.0f) == 0.5f);
    close_world(&w);
    clast_context_destroy(context);
}

static void memory_that_runs_out_leaves_nothing(void **state)
{
    (void)state;
    static const uint8_t bytes[16];
    shortage s;
    clast_context *context = scarce_context(&s);
    world w = open_image(context, (clast_image){4, 4, 1, CLAST_PIXEL_UNORM8, bytes}, CLAST_WRAP_CLAMP,
                         CLAST_WRAP_CLAMP);
    clast_height_release(w.store, w.height);
    clast_height_store_destroy(w.store);
    uint64_t before = clast_context_memory(context);
    int failures = 0;
    for (int64_t n = 0; s.left < 0; n++, failures++) {
        const clast_height *height = NULL;
        s.left = n;
        clast_status status = clast_height_store_create(context, &w.store);
        if (status == CLAST_OK) {
            status = clast_height_acquire(w.store, w.scene, w.texture, &height);
            clast_height_release(w.store, height);
            clast_height_store_destroy(w.store);
        }
        assert_int_equal(clast_context_memory(context), before);
        if (s.left >= 0) {
            assert_ok(context, status);
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
    }
    assert_int_equal(failures, 5); // store, place, map, texels, ranges
    clast_scene_destroy(w.scene);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(the_first_channel_counts),
        CONTEXT_TEST(floats_stay_as_they_are),
        CONTEXT_TEST(levels_are_means_of_those_before),
        CONTEXT_TEST(heights_are_bilinear_however_coordinates_wrap),
        CONTEXT_TEST(heights_are_continuous_where_coordinates_wrap),
        CONTEXT_TEST(slopes_are_those_of_the_heights),
        CONTEXT_TEST(coordinates_that_are_no_numbers_are_read_somewhere),
        CONTEXT_TEST(bounds_hold_whatever_is_read),
        CONTEXT_TEST(bounds_are_near),
        CONTEXT_TEST(bounds_of_unknown_places_hold_everything),
        CONTEXT_TEST(units_share_maps),
        CONTEXT_TEST(textures_that_are_not_there_are_refused),
        CONTEXT_TEST(maps_of_too_many_texels_are_refused),
        cmocka_unit_test(heights_that_are_no_numbers_count_as_zero),
        cmocka_unit_test(memory_that_runs_out_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
