// SPDX-License-Identifier: Apache-2.0
#include "load/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { DIGITS_MOST = 19, DIGITS_KEPT = 800 }; // 19 fit 64 bits; 770 decide any double

__extension__ typedef unsigned __int128 wide;

static const double exact_powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                      1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// A number as it stands in the text: 0.DIGITS is not normalised here, the value is digits * 10^exponent.
typedef struct decimal {
    uint64_t digits; // the first 19 that matter
    int64_t exponent;
    bool cut; // later digits were left out of `digits`
    bool negative;
    const char *begin; // of the digits and the point, for the slow way
    const char *end;
    int64_t written_exponent;
} decimal;

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool scan_exponent(const char *at, const char *end, int64_t *exponent, const char **next)
{
    if (at == end || (*at != 'e' && *at != 'E')) {
        return false;
    }
    at++;
    bool negative = at < end && *at == '-';
    at += at < end && (*at == '-' || *at == '+');
    if (at == end || !is_digit(*at)) {
        return false;
    }
    int64_t value = 0;
    for (; at < end && is_digit(*at); at++) {
        value = value < 100000 ? value * 10 + (*at - '0') : value;
    }
    *exponent = negative ? -value : value;
    *next = at;
    return true;
}

static bool scan(const char *at, const char *end, decimal *number, const char **next)
{
    *number = (decimal){0};
    number->negative = at < end && *at == '-';
    at += at < end && (*at == '-' || *at == '+');
    number->begin = at;
    int significant = 0;
    bool any = false;
    bool fraction = false;
    for (; at < end; at++) {
        if (*at == '.' && !fraction) {
            fraction = true;
            continue;
        }
        if (!is_digit(*at)) {
            break;
        }
        any = true;
        if (significant < DIGITS_MOST) {
            number->digits = number->digits * 10 + (uint64_t)(*at - '0');
            significant += number->digits != 0;
            number->exponent -= fraction;
        } else {
            number->cut = number->cut || *at != '0';
            number->exponent += !fraction;
        }
    }
    if (!any) {
        return false;
    }
    number->end = at;
    *next = at;
    if (scan_exponent(at, end, &number->written_exponent, next)) {
        number->exponent += number->written_exponent;
    }
    return true;
}

// Rounds mantissa * 2^shift to a double, to nearest even; `inexact`: a little more than the mantissa is meant. The
// mantissa has 65 significant bits at least, or is exact.
static double round_wide(wide mantissa, int shift, bool inexact)
{
    int length = 0;
    for (wide rest = mantissa; rest != 0; rest >>= 1) {
        length++;
    }
    int dropped = length - 53;
    if (dropped <= 0) {
        return ldexp((double)(uint64_t)mantissa, shift);
    }
    uint64_t kept = (uint64_t)(mantissa >> dropped);
    wide rest = mantissa & (((wide)1 << dropped) - 1);
    wide half = (wide)1 << (dropped - 1);
    bool up = rest > half || (rest == half && (inexact || (kept & 1)));
    return ldexp((double)(kept + up), shift + dropped);
}

// digits * 10^exponent for exponents whose power fits 64 bits, by integers.
static double scale_exactly(uint64_t digits, int exponent, bool inexact)
{
    uint64_t power = 1;
    for (int i = 0; i < (exponent < 0 ? -exponent : exponent); i++) {
        power *= 10;
    }
    if (exponent >= 0) {
        return round_wide((wide)digits * power, 0, inexact);
    }
    int shift = 64 + __builtin_clzll(digits);
    wide numerator = (wide)digits << shift;
    wide quotient = numerator / power; // at least 2^127 / 10^19: 63 bits and more
    return round_wide(quotient, -shift, inexact || quotient * power != numerator);
}

// The C library's way, with the point taken out of the text so that the locale has no say.
static double scale_slowly(const decimal *number)
{
    char text[DIGITS_KEPT + 32];
    int length = 0;
    int64_t exponent = number->written_exponent;
    bool fraction = false;
    for (const char *c = number->begin; c < number->end; c++) {
        if (*c == '.') {
            fraction = true;
        } else if (length == 0 && *c == '0') {
            exponent -= fraction;
        } else if (length < DIGITS_KEPT) {
            text[length++] = *c;
            exponent -= fraction;
        } else {
            exponent += !fraction;
        }
    }
    snprintf(text + length, 32, "e%lld", (long long)exponent);
    return length == 0 ? 0.0 : strtod(text, NULL);
}

static double magnitude(const decimal *number)
{
    int64_t exponent = number->exponent;
    if (number->digits == 0) {
        return 0.0;
    }
    // Clinger, How to Read Floating Point Numbers Accurately, 1990: one correctly rounded operation on exact operands.
    if (number->digits >> 53 == 0 && !number->cut && exponent >= -22 && exponent <= 22) {
        double digits = (double)number->digits;
        return exponent < 0 ? digits / exact_powers[-exponent] : digits * exact_powers[exponent];
    }
    if (exponent >= -19 && exponent <= 19) {
        double low = scale_exactly(number->digits, (int)exponent, number->cut);
        // Digits that were cut lie between these two; mostly both round to one double.
        if (!number->cut || low == scale_exactly(number->digits + 1, (int)exponent, false)) {
            return low;
        }
    }
    return scale_slowly(number);
}

bool clast_parse_number(const char *at, const char *end, double *value, const char **next)
{
    decimal number;
    if (!scan(at, end, &number, next)) {
        return false;
    }
    double size = magnitude(&number);
    *value = number.negative ? -size : size;
    return true;
}

bool clast_parse_integer(const char *at, const char *end, int64_t *value, const char **next)
{
    bool negative = at < end && *at == '-';
    at += at < end && (*at == '-' || *at == '+');
    if (at == end || !is_digit(*at)) {
        return false;
    }
    uint64_t sum = 0;
    for (; at < end && is_digit(*at); at++) {
        sum = sum * 10 + (uint64_t)(*at - '0');
        if (sum > INT64_MAX / 16) {
            return false;
        }
    }
    *value = negative ? -(int64_t)sum : (int64_t)sum;
    *next = at;
    return true;
}
