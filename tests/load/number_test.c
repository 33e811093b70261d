// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <string.h>

#include "load/number.h"

static double parsed(const char *text)
{
    double value = NAN;
    const char *next;
    if (!clast_parse_number(text, text + strlen(text), &value, &next) || *next != '\0') {
        fail_msg("%s is not read whole", text);
    }
    return value;
}

static void assert_same(const char *text)
{
    double got = parsed(text), expected = strtod(text, NULL);
    if (memcmp(&got, &expected, sizeof got) != 0) {
        fail_msg("%s is read as %.17g, expected %.17g", text, got, expected);
    }
}

static void numbers_are_rounded_as_the_c_library_rounds(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "0",
        "-0",
        "1",
        "+1.5",
        ".5",
        "5.",
        "1e5",
        "1E-5",
        "1e+22",
        "1e23",
        "0.1",
        "0.3",
        "123456789012345678",
        "9007199254740993",
        "9007199254740992.5",
        "9007199254740993.0000000000000000000000000000001",
        "1.7976931348623157e308",
        "1e400",
        "-1e400",
        "4.9e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "1e-400",
        "0.000000000000000000000000000000001234",
        "0.1000000000000000055511151231257827021181583404541015625",
        "1234567890123456789012345678901234567890",
        "179769313486231580793e289",
        "6.02214076e23",
        "3.141592653589793238462643383279502884197169399375105820974944",
        "00000000000000000000000000000001",
        "0.00000000000000000000000000000000000000000000000000e50",
        "8.98846567431158e307",
        "1e00000000000000000005",
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        assert_same(texts[i]);
    }
}

static void random_numbers_are_rounded_as_the_c_library_rounds(void **state)
{
    (void)state;
    uint64_t random = 88172645463325252u;
    for (int i = 0; i < 200000; i++) {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        char text[80];
        double value = ldexp((double)(random >> 11), (int)(random % 150) - 120);
        static const char *const formats[] = {"%.*g", "%.*e", "%.*f"};
        snprintf(text, sizeof text, formats[i % 3], (int)(random >> 32) % 25, value);
        assert_same(text);
    }
}

static void a_halfway_case_is_told_by_its_last_digit(void **state)
{
    (void)state;
    char text[1000];
    // 2^53 + 1 lies between two doubles; a digit far behind the point makes it more.
    snprintf(text, sizeof text, "9007199254740993.%0700d", 0);
    assert_true(parsed(text) == 9007199254740992.0);
    text[strlen(text) - 1] = '1';
    assert_true(parsed(text) == 9007199254740994.0);
}

static void what_is_no_number_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"", "-", "+", ".", "-.", "e5", "x", "nan", "inf", "--1", "+-1"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double value;
        const char *next;
        assert_false(clast_parse_number(texts[i], texts[i] + strlen(texts[i]), &value, &next));
    }
}

static void reading_stops_where_the_number_ends(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        size_t length;
    } cases[] = {{"1.2.3", 3}, {"1e", 1}, {"1e+", 1}, {"1e5e", 3}, {"12abc", 2}, {"0x10", 1}, {"1,5", 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double value;
        const char *next;
        assert_true(clast_parse_number(cases[i].text, cases[i].text + strlen(cases[i].text), &value, &next));
        assert_int_equal(next - cases[i].text, cases[i].length);
    }
    double value;
    const char *next;
    static const char text[] = "1234";
    assert_true(clast_parse_number(text, text + 2, &value, &next)); // not beyond the end
    assert_true(value == 12.0);
}

static void integers_are_read_or_refused(void **state)
{
    (void)state;
    int64_t value;
    const char *next;
    static const char text[] = "-12/3";
    assert_true(clast_parse_integer(text, text + 5, &value, &next));
    assert_int_equal(value, -12);
    assert_int_equal(next - text, 3);
    assert_false(clast_parse_integer("x", (const char *)"x" + 1, &value, &next));
    static const char large[] = "99999999999999999999999999";
    assert_false(clast_parse_integer(large, large + strlen(large), &value, &next));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_rounded_as_the_c_library_rounds),
        cmocka_unit_test(random_numbers_are_rounded_as_the_c_library_rounds),
        cmocka_unit_test(a_halfway_case_is_told_by_its_last_digit),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(reading_stops_where_the_number_ends),
        cmocka_unit_test(integers_are_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
