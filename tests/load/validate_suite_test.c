// SPDX-License-Identifier: Apache-2.0
// The verdicts on the Khronos validator's own files, beside its reports: an error or none, for every file.
#include "test.h"

#include <dirent.h>
#include <jansson.h>
#include <string.h>
#include <sys/stat.h>

#include "clast/validate.h"

static const char report_ending[] = ".report.json";

typedef struct suite {
    clast_context *context;
    int files, disagreements;
    int codes, missed; // of errors in the reports, and those that the validation lacks
} suite;

static bool has_code(const clast_validation *validation, const char *code)
{
    for (size_t i = 0; i < clast_validation_fault_count(validation); i++) {
        if (strcmp(clast_validation_fault(validation, i)->code, code) == 0) {
            return true;
        }
    }
    return false;
}

static void compare_codes(suite *all, const clast_validation *validation, const json_t *report, const char *path)
{
    const json_t *messages = json_object_get(json_object_get(report, "issues"), "messages");
    for (size_t i = 0; i < json_array_size(messages); i++) {
        const json_t *message = json_array_get(messages, i);
        const char *code = json_string_value(json_object_get(message, "code"));
        if (json_integer_value(json_object_get(message, "severity")) == 0) {
            bool is_there = has_code(validation, code);
            all->codes++;
            all->missed += !is_there;
            if (!is_there) {
                printf("%s: no %s\n", path, code);
            }
        }
    }
}

static void compare_file(suite *all, const char *report_path)
{
    char path[1024];
    snprintf(path, sizeof path, "%.*s", (int)(strlen(report_path) - strlen(report_ending)), report_path);
    json_error_t error;
    json_t *report = json_load_file(report_path, 0, &error);
    assert_non_null(report);
    clast_validation *validation;
    uint64_t counts[CLAST_SEVERITY_COUNT];
    assert_ok(all->context, clast_validate(all->context, path, &validation));
    clast_validation_count(validation, counts);
    json_int_t expected = json_integer_value(json_object_get(json_object_get(report, "issues"), "numErrors"));
    all->files++;
    if ((expected != 0) != (counts[CLAST_SEVERITY_ERROR] != 0)) {
        all->disagreements++;
        printf("%s: %llu errors, the report has %llu\n", path, (unsigned long long)counts[CLAST_SEVERITY_ERROR],
               (unsigned long long)expected);
    }
    compare_codes(all, validation, report, path);
    clast_validation_destroy(validation);
    json_decref(report);
}

static void compare_folder(suite *all, const char *folder)
{
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        char path[1024];
        struct stat status;
        size_t length = strlen(entry->d_name), ending = strlen(report_ending);
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.' && stat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
            compare_folder(all, path);
        } else if (length > ending && strcmp(entry->d_name + length - ending, report_ending) == 0) {
            compare_file(all, path);
        }
    }
    closedir(directory);
}

static void every_verdict_is_that_of_the_report(void **state)
{
    suite all = {.context = *state};
    char folder[512];
    snprintf(folder, sizeof folder, "%s/malformed/gltf-validator", test_assets());
    compare_folder(&all, folder);
    printf("%d files, %d verdicts differ; %d errors in the reports, %d of them under another code here\n", all.files,
           all.disagreements, all.codes, all.missed);
    assert_true(all.files >= 200);
    assert_int_equal(all.disagreements, 0);
    assert_true(all.missed * 20 < all.codes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {CONTEXT_TEST(every_verdict_is_that_of_the_report)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
