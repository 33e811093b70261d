// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <string.h>

#include "clast/image.h"

static clast_image_difference compare(clast_context *context, const clast_image *a, const clast_image *b)
{
    clast_image_difference difference;
    assert_ok(context, clast_image_compare(context, a, b, &difference));
    return difference;
}

static void equal_images_differ_by_nothing(void **state)
{
    const float pixels[6] = {1.0f, NAN, INFINITY, -INFINITY, 0.0f, 3.0f};
    const clast_image image = {2, 1, 3, CLAST_PIXEL_FLOAT, pixels};
    clast_image_difference difference = compare(*state, &image, &image);
    assert_true(difference.mean_squared_error == 0.0 && difference.maximum == 0.0);
    assert_int_equal(difference.differing_pixels, 0);
}

static void differences_are_on_the_scale_of_the_file(void **state)
{
    const uint8_t a[6] = {0, 0, 0, 0, 0, 0}, b[6] = {0, 0, 0, 0, 51, 255};
    const clast_image image_a = {2, 1, 3, CLAST_PIXEL_UNORM8, a}, image_b = {2, 1, 3, CLAST_PIXEL_UNORM8, b};
    clast_image_difference difference = compare(*state, &image_a, &image_b);
    assert_true(fabs(difference.mean_squared_error - (0.04 + 1.0) / 6.0) < 1e-12);
    assert_true(difference.maximum == 1.0);
    assert_int_equal(difference.maximum_x, 1);
    assert_int_equal(difference.maximum_y, 0);
    assert_int_equal(difference.differing_pixels, 1);
}

static void types_and_channels_may_differ(void **state)
{
    const uint8_t grey[2] = {255, 0};
    const uint16_t colour[8] = {65535, 65535, 65535, 65535, 0, 0, 0, 65535};
    const clast_image a = {1, 2, 1, CLAST_PIXEL_UNORM8, grey}, b = {1, 2, 4, CLAST_PIXEL_UNORM16, colour};
    assert_int_equal(compare(*state, &a, &b).differing_pixels, 0);
    const float clear[4] = {1.0f, 0.5f, 0.0f, 1.0f};
    const clast_image c = {1, 2, 2, CLAST_PIXEL_FLOAT, clear};
    clast_image_difference difference = compare(*state, &a, &c);
    assert_int_equal(difference.differing_pixels, 1);
    assert_true(difference.maximum == 0.5 && fabs(difference.mean_squared_error - 0.25 / 8.0) < 1e-12);
}

static void a_nan_in_one_is_infinitely_different(void **state)
{
    const float a[3] = {0.0f, 0.0f, 0.0f}, b[3] = {0.0f, NAN, 0.0f}, c[3] = {0.0f, INFINITY, 0.0f};
    const clast_image image_a = {3, 1, 1, CLAST_PIXEL_FLOAT, a}, image_b = {3, 1, 1, CLAST_PIXEL_FLOAT, b};
    const clast_image image_c = {3, 1, 1, CLAST_PIXEL_FLOAT, c};
    assert_true(isinf(compare(*state, &image_a, &image_b).maximum));
    assert_true(isinf(compare(*state, &image_a, &image_c).mean_squared_error));
    assert_int_equal(compare(*state, &image_b, &image_c).maximum_x, 1);
}

static void images_of_different_size_are_refused(void **state)
{
    const uint8_t pixels[4] = {0};
    const clast_image a = {2, 1, 1, CLAST_PIXEL_UNORM8, pixels}, b = {1, 2, 1, CLAST_PIXEL_UNORM8, pixels};
    clast_image_difference difference;
    assert_int_equal(clast_image_compare(*state, &a, &b, &difference), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(*state), "2 x 1 and 1 x 2"));
    assert_int_equal(clast_image_compare(*state, &a, NULL, &difference), CLAST_ERROR_INVALID_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(equal_images_differ_by_nothing),       CONTEXT_TEST(differences_are_on_the_scale_of_the_file),
        CONTEXT_TEST(types_and_channels_may_differ),        CONTEXT_TEST(a_nan_in_one_is_infinitely_different),
        CONTEXT_TEST(images_of_different_size_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
