// SPDX-License-Identifier: Apache-2.0
#include "app/print.h"

#include <inttypes.h>
#include <string.h>

static void print_line(const char *prefix, const char *format, va_list arguments)
{
    char text[2048];
    vsnprintf(text, sizeof text, format, arguments);
    for (char *c = text; *c != '\0'; c++) {
        if ((unsigned char)*c < 32 || *c == 127) {
            *c = ' ';
        }
    }
    fprintf(stderr, "%s%s\n", prefix, text);
}

void clast_print_error(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line("clast: ", format, arguments);
    va_end(arguments);
}

void clast_print_warning(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print_line("clast: warning: ", format, arguments);
    va_end(arguments);
}

void clast_print_wrapped(FILE *stream, const char *text, int column, int indent, int width)
{
    bool line_is_empty = true;
    while (*text != '\0') {
        int length = (int)strcspn(text, " ");
        if (!line_is_empty && column + 1 + length > width) {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
            line_is_empty = true;
        }
        fprintf(stream, "%s%.*s", line_is_empty ? "" : " ", length, text);
        column += length + !line_is_empty;
        line_is_empty = false;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', stream);
}

const char *clast_format_bytes(uint64_t bytes, char text[32])
{
    static const char *const units[] = {"KiB", "MiB", "GiB", "TiB"};
    if (bytes < 1024) {
        snprintf(text, 32, "%" PRIu64 " bytes", bytes);
        return text;
    }
    double amount = (double)bytes / 1024.0;
    size_t unit = 0;
    while (amount >= 1024.0 && unit + 1 < sizeof units / sizeof *units) {
        amount /= 1024.0;
        unit++;
    }
    snprintf(text, 32, amount < 10.0 ? "%.2f %s" : amount < 100.0 ? "%.1f %s" : "%.0f %s", amount, units[unit]);
    return text;
}

const char *clast_format_count(uint64_t count, char text[32])
{
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%" PRIu64, count);
    char *end = text;
    for (int i = 0; i < length; i++) {
        if (i != 0 && (length - i) % 3 == 0) {
            *end++ = ' ';
        }
        *end++ = digits[i];
    }
    *end = '\0';
    return text;
}
