// SPDX-License-Identifier: Apache-2.0
#include "cook/cook.h"

#include "base/thread.h"

clast_status clast_cooked_create(clast_context *context, clast_cooked **result)
{
    clast_cooked *cooked = clast_allocate_zeroed(context, 1, sizeof *cooked);
    if (cooked == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    cooked->context = context;
    cooked->file_cache = (clast_file_cache){context, clast_context_cache_folder(context)};
    if (cooked->file_cache.folder != NULL) {
        cooked->cache = clast_file_cache_hooks(&cooked->file_cache);
    }
    cooked->patterns = &clast_patterns;
    clast_status status = clast_template_set_create(context, &cooked->templates);
    if (status == CLAST_OK) {
        status = clast_height_store_create(context, &cooked->heights);
    }
    if (status != CLAST_OK) {
        clast_cooked_destroy(cooked);
        return status;
    }
    *result = cooked;
    return CLAST_OK;
}

void clast_cooked_release(clast_cooked *cooked)
{
    for (size_t i = 0; i < cooked->retired_count; i++) {
        clast_source_of(cooked->retired[i])->destroy(cooked->retired[i]);
    }
    cooked->retired_count = 0;
}

void clast_cooked_destroy(clast_cooked *cooked)
{
    if (cooked == NULL) {
        return;
    }
    clast_context *context = cooked->context;
    clast_cooked_release(cooked);
    for (size_t i = 0; i < cooked->unit_count; i++) {
        if (cooked->units[i] != NULL) {
            clast_source_of(cooked->units[i])->destroy(cooked->units[i]);
        }
    }
    clast_free(context, cooked->units);
    clast_free(context, cooked->retired);
    clast_free(context, cooked->geometries);
    clast_height_store_destroy(cooked->heights);
    clast_template_set_destroy(cooked->templates);
    clast_free(context, cooked);
}

void clast_cooked_use_patterns(clast_cooked *cooked, const clast_pattern_table *patterns)
{
    patterns = patterns != NULL ? patterns : &clast_patterns;
    for (size_t i = 0; cooked->patterns != patterns && i < cooked->unit_count; i++) {
        if (cooked->units[i] != NULL) {
            cooked->units[i]->stale = clast_source_of(cooked->units[i])->adapts;
        }
    }
    cooked->patterns = patterns;
}

static clast_status make_room(clast_cooked *cooked, const clast_scene *scene)
{
    clast_status status = CLAST_RESERVE(cooked->context, cooked->units, cooked->unit_capacity, scene->geometry_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(cooked->context, cooked->geometries, cooked->geometry_capacity, scene->geometry_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < cooked->unit_count; i++) {
        if (cooked->units[i] != NULL) {
            cooked->units[i]->geometry = &cooked->geometries[i];
        }
    }
    while (cooked->unit_count < scene->geometry_count) {
        cooked->units[cooked->unit_count++] = NULL;
    }
    return CLAST_OK;
}

static clast_status cook_anew(clast_cooked *cooked, const clast_scene *scene, const clast_geometry *geometry,
                              uint32_t number)
{
    clast_unit *old = cooked->units[number];
    clast_status status = CLAST_OK;
    if (old != NULL) {
        status = CLAST_RESERVE(cooked->context, cooked->retired, cooked->retired_capacity, cooked->retired_count + 1);
    }
    clast_unit *unit = NULL;
    if (status == CLAST_OK) {
        clast_cook_job job = {
            .context = cooked->context,
            .scene = scene,
            .geometry = geometry,
            .templates = cooked->templates,
            .heights = cooked->heights,
            .patterns = cooked->patterns,
            .cache = cooked->cache.find != NULL ? &cooked->cache : NULL,
        };
        status = clast_sources[geometry->kind]->cook(&job, &unit);
    }
    if (status != CLAST_OK) {
        return status;
    }
    unit->number = number;
    unit->serial = ++cooked->serials;
    cooked->units[number] = unit;
    if (old != NULL) {
        cooked->retired[cooked->retired_count++] = old;
    }
    return CLAST_OK;
}

static clast_status bring_up_to_date(clast_cooked *cooked, const clast_scene *scene, const clast_geometry *geometry,
                                     uint32_t number)
{
    clast_unit *unit = cooked->units[number];
    if (unit == NULL || unit->stale) {
        return cook_anew(cooked, scene, geometry, number);
    }
    if (unit->geometry_version == geometry->version) {
        return CLAST_OK;
    }
    clast_status status = unit->kind == geometry->kind ? clast_source_of(unit)->update(unit, geometry)
                                                       : CLAST_ERROR_UNSUPPORTED;
    return status == CLAST_ERROR_UNSUPPORTED ? cook_anew(cooked, scene, geometry, number) : status;
}

// How long a geometry takes, for the progress only.
static uint64_t work_of(const clast_geometry *geometry)
{
    return clast_sources[geometry->kind]->work(geometry) + 1;
}

static bool is_current(const clast_cooked *cooked, const clast_geometry *geometry, size_t number)
{
    const clast_unit *unit = cooked->units[number];
    return unit != NULL && !unit->stale && unit->geometry_version == geometry->version;
}

static clast_status cook_all(clast_cooked *cooked, const clast_scene *scene)
{
    uint64_t total = 0;
    for (size_t i = 0; i < scene->geometry_count; i++) {
        cooked->geometries[i] = scene->geometries[i];
        total += is_current(cooked, &scene->geometries[i], i) ? 0 : work_of(&scene->geometries[i]);
    }
    uint64_t done = 0;
    for (size_t i = 0; i < scene->geometry_count; i++) {
        const clast_geometry *geometry = &cooked->geometries[i];
        bool current = is_current(cooked, geometry, i);
        clast_status status = current ? CLAST_OK : clast_progress(cooked->context, "cook", done, total);
        if (status == CLAST_OK) {
            status = bring_up_to_date(cooked, scene, geometry, (uint32_t)i);
        }
        if (status != CLAST_OK) {
            return status;
        }
        done += current ? 0 : work_of(geometry);
    }
    return total != 0 ? clast_progress(cooked->context, "cook", total, total) : CLAST_OK;
}

clast_status clast_cooked_update(clast_cooked *cooked, const clast_scene *scene)
{
    double start = clast_clock();
    clast_status status = make_room(cooked, scene);
    if (status == CLAST_OK) {
        status = cook_all(cooked, scene);
    }
    cooked->bytes = 0;
    for (size_t i = 0; i < cooked->unit_count; i++) {
        cooked->bytes += cooked->units[i] != NULL ? cooked->units[i]->bytes : 0;
    }
    cooked->milliseconds = (clast_clock() - start) * 1e3;
    return status;
}
