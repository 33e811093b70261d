// SPDX-License-Identifier: Apache-2.0
// clast validate: what is wrong with a file.
#include "app/session.h"
#include "app/print.h"
#include "app/report.h"
#include "clast/validate.h"

static const char *const severities[] = {
#define SEVERITY_TEXT(name, value, text) [value] = text,
    CLAST_SEVERITY_LIST(SEVERITY_TEXT)};

static void print_fault(const clast_fault *fault)
{
    char place[32];
    if (fault->pointer == NULL) {
        snprintf(place, sizeof place, "byte %llu", (unsigned long long)fault->offset);
    }
    printf("%s %s at %s: %s\n", severities[fault->severity], fault->code,
           fault->pointer == NULL      ? place
           : fault->pointer[0] == '\0' ? "the root"
                                       : fault->pointer,
           fault->text);
}

static void print_results(const clast_validation *validation, const uint64_t counts[CLAST_SEVERITY_COUNT])
{
    size_t listed = clast_validation_fault_count(validation);
    uint64_t all = 0;
    for (size_t i = 0; i < listed; i++) {
        print_fault(clast_validation_fault(validation, i));
    }
    for (int i = 0; i < CLAST_SEVERITY_COUNT; i++) {
        printf("%s%s: %llu", i > 0 ? ", " : "", severities[i], (unsigned long long)counts[i]);
        all += counts[i];
    }
    if (all > listed) {
        printf("; the first %zu are listed", listed);
    }
    printf("\n");
}

static json_t *fault_object(const clast_fault *fault)
{
    json_t *object = json_pack("{s:s, s:s, s:o}", "severity", severities[fault->severity], "code", fault->code, "text",
                               clast_report_text(fault->text));
    json_t *place = fault->pointer != NULL ? clast_report_text(fault->pointer)
                                           : json_integer((json_int_t)fault->offset);
    if (object == NULL || json_object_set_new(object, fault->pointer != NULL ? "pointer" : "offset", place) != 0) {
        json_decref(object);
        return NULL;
    }
    return object;
}

static json_t *results_object(const clast_session *session, const clast_validation *validation,
                              const uint64_t counts[CLAST_SEVERITY_COUNT])
{
    json_t *faults = json_array(), *numbers = json_object();
    for (size_t i = 0; i < clast_validation_fault_count(validation); i++) {
        json_array_append_new(faults, fault_object(clast_validation_fault(validation, i)));
    }
    for (int i = 0; i < CLAST_SEVERITY_COUNT; i++) {
        json_object_set_new(numbers, severities[i], json_integer((json_int_t)counts[i]));
    }
    bool is_whole = json_array_size(faults) == clast_validation_fault_count(validation) &&
                    json_object_size(numbers) == CLAST_SEVERITY_COUNT;
    json_t *object = is_whole ? json_pack("{s:s, s:o, s:o, s:b, s:O, s:O}", "verb", "validate", "clast",
                                          clast_report_program(session), "input",
                                          clast_report_text(session->command->positionals[0]), "valid",
                                          counts[CLAST_SEVERITY_ERROR] == 0, "counts", numbers, "faults", faults)
                              : NULL;
    json_decref(faults);
    json_decref(numbers);
    return object;
}

clast_exit clast_run_validate(const clast_command *command)
{
    clast_session session;
    if (!clast_session_begin(&session, command)) {
        return CLAST_EXIT_USAGE;
    }
    clast_validation *validation = NULL;
    clast_exit code;
    clast_status status = clast_validate(session.context, command->positionals[0], &validation);
    if (status != CLAST_OK) {
        code = clast_session_fail(&session, status);
        code = code == CLAST_EXIT_FAILURE ? CLAST_EXIT_USAGE : code; // 1 says that the file has errors, and it may not
    } else {
        uint64_t counts[CLAST_SEVERITY_COUNT];
        clast_validation_count(validation, counts);
        code = counts[CLAST_SEVERITY_ERROR] == 0 ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
        if (clast_session_prints(&session)) {
            print_results(validation, counts);
        }
        if (command->json != NULL &&
            !clast_session_write_json(&session, results_object(&session, validation, counts))) {
            code = CLAST_EXIT_USAGE;
        }
    }
    clast_validation_destroy(validation);
    clast_session_end(&session);
    return code;
}
