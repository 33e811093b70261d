// SPDX-License-Identifier: Apache-2.0
#include "app/report.h"

#include <string.h>

#include "base/isa.h"

// json_object_set_new with a null value gives -1: errors add up, and are looked at once.
#define SET_UINT(object, name, value) json_object_set_new(object, name, json_integer((json_int_t)(value)))
#define SET_REAL(object, name, value) json_object_set_new(object, name, json_real(value))

static json_t *object_or_null(json_t *object, int failures)
{
    if (failures != 0) {
        json_decref(object);
        return NULL;
    }
    return object;
}

json_t *clast_report_text(const char *text)
{
    json_t *value = json_string(text);
    if (value != NULL) {
        return value;
    }
    char clean[1024]; // not UTF-8: what is not ASCII becomes a question mark
    size_t length = 0;
    for (; text[length] != '\0' && length + 1 < sizeof clean; length++) {
        clean[length] = (unsigned char)text[length] < 128 ? text[length] : '?';
    }
    clean[length] = '\0';
    return json_string(clean);
}

json_t *clast_report_passes(const clast_render_statistics *statistics)
{
    json_t *object = json_object();
    int failures = object == NULL;
#define SET_PASS(name, value, text, ...) failures += SET_REAL(object, text, statistics->pass_milliseconds[value]) != 0;
    CLAST_PASS_LIST(SET_PASS)
    return object_or_null(object, failures);
}

json_t *clast_report_bytes(const clast_render_statistics *statistics, bool for_each_triangle)
{
    const struct {
        const char *name;
        uint64_t bytes;
    } rows[] = {
        {"scene", statistics->scene_bytes},        {"cook", statistics->cook_bytes},
        {"templates", statistics->template_bytes}, {"clas", statistics->clas_bytes},
        {"vertices", statistics->vertex_bytes},    {"blas", statistics->blas_bytes},
        {"tlas", statistics->tlas_bytes},
    };
    json_t *object = json_object();
    int failures = object == NULL;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (for_each_triangle) {
            double triangles = statistics->triangles != 0 ? (double)statistics->triangles : 1.0;
            failures += SET_REAL(object, rows[i].name, (double)rows[i].bytes / triangles) != 0;
        } else {
            failures += SET_UINT(object, rows[i].name, rows[i].bytes) != 0;
        }
    }
    return object_or_null(object, failures);
}

static const char *choice_text(const char *option, uint32_t value)
{
    for (size_t i = 0; i < clast_option_count; i++) {
        const clast_choice *choice = clast_options[i].choices;
        if (choice == NULL || strcmp(clast_options[i].name, option) != 0) {
            continue;
        }
        for (; choice->text != NULL; choice++) {
            if (choice->value == value) {
                return choice->text;
            }
        }
    }
    return "";
}

json_t *clast_report_settings(const clast_render_settings *settings)
{
    json_t *object = json_object();
    int failures = object == NULL;
#define SETTING_UINT(name, ...) failures += SET_UINT(object, #name, settings->name) != 0;
#define SETTING_REAL(name, ...) \
    failures += SET_REAL(object, #name, settings->name != CLAST_ZERO ? settings->name : 0.0) != 0;
#define SETTING_CHOICE(name, ...) \
    failures += json_object_set_new(object, #name, clast_report_text(choice_text(#name, settings->name))) != 0;
#define SETTING_TEXT(name, ...) failures += json_object_set_new(object, #name, clast_report_text(settings->name)) != 0;
    CLAST_RENDER_SETTING_LIST(SETTING_UINT, SETTING_REAL, SETTING_CHOICE, SETTING_TEXT)
    return object_or_null(object, failures);
}

static const char *bound_text(clast_bound bound)
{
    switch (bound) {
#define BOUND_TEXT(name, value, text) \
    case name: return text;
        CLAST_BOUND_LIST(BOUND_TEXT)
#undef BOUND_TEXT
    }
    return "";
}

static json_t *device_object(const clast_render_statistics *statistics)
{
    json_t *object = json_object();
    int failures = object == NULL;
    failures += json_object_set_new(object, "name", clast_report_text(statistics->device)) != 0;
    failures += json_object_set_new(object, "driver", clast_report_text(statistics->driver)) != 0;
    failures += SET_UINT(object, "bytes", statistics->device_bytes) != 0;
    failures += SET_UINT(object, "bytes_peak", statistics->device_bytes_peak) != 0;
    return object_or_null(object, failures);
}

int clast_report_add_counts(json_t *object, const clast_render_statistics *statistics)
{
    int failures = json_object_set_new(object, "device", device_object(statistics)) != 0;
    failures += SET_UINT(object, "triangles", statistics->triangles) != 0;
    failures += SET_UINT(object, "instanced_triangles", statistics->instanced_triangles) != 0;
    failures += SET_UINT(object, "clusters", statistics->clusters) != 0;
    failures += SET_REAL(object, "cluster_fill", statistics->cluster_fill) != 0;
    failures += SET_UINT(object, "vertices", statistics->vertices) != 0;
    failures += SET_UINT(object, "units", statistics->units) != 0;
    failures += SET_UINT(object, "moved_units", statistics->moved_units) != 0;
    failures += SET_UINT(object, "moved_vertices", statistics->moved_vertices) != 0;
    failures += SET_UINT(object, "instances", statistics->instances) != 0;
    failures += SET_UINT(object, "hidden_instances", statistics->hidden_instances) != 0;
    failures += SET_UINT(object, "occluded_instances", statistics->occluded_instances) != 0;
    failures += SET_UINT(object, "lights", statistics->lights) != 0;
    failures += SET_REAL(object, "rate", statistics->rate) != 0;
    failures += json_object_set_new(object, "bound", json_string(bound_text(statistics->bound))) != 0;
    failures += SET_UINT(object, "wanted_clusters", statistics->wanted_clusters) != 0;
    failures += SET_UINT(object, "wanted_triangles", statistics->wanted_triangles) != 0;
    failures += SET_UINT(object, "wanted_bytes", statistics->wanted_bytes) != 0;
    failures += SET_UINT(object, "frame_bytes", statistics->frame_bytes) != 0;
    failures += SET_UINT(object, "minimum_clusters", statistics->minimum_clusters) != 0;
    failures += SET_UINT(object, "minimum_triangles", statistics->minimum_triangles) != 0;
    failures += SET_UINT(object, "minimum_bytes", statistics->minimum_bytes) != 0;
    failures += json_object_set_new(object, "bytes", clast_report_bytes(statistics, false)) != 0;
    failures += json_object_set_new(object, "bytes_per_triangle", clast_report_bytes(statistics, true)) != 0;
    failures += SET_UINT(object, "memory_peak", statistics->memory_peak) != 0;
    failures += SET_UINT(object, "process_memory_peak", statistics->process_memory_peak) != 0;
    return failures;
}

json_t *clast_report_program(const clast_session *session)
{
    json_t *object = json_object();
    int failures = object == NULL;
    failures += json_object_set_new(object, "version", json_string(clast_version())) != 0;
    failures += json_object_set_new(object, "isa", json_string(clast_isa_text(clast_context_isa(session->context)))) !=
                0;
    failures += SET_UINT(object, "threads", clast_context_threads(session->context)) != 0;
    return object_or_null(object, failures);
}

double clast_mega_rays_per_second(const clast_render_statistics *statistics)
{
    double milliseconds = statistics->pass_milliseconds[CLAST_PASS_TRACE] +
                          statistics->pass_milliseconds[CLAST_PASS_SHADE];
    return milliseconds > 0.0 ? (double)statistics->rays / milliseconds / 1000.0 : 0.0;
}
