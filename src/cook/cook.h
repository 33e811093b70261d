// SPDX-License-Identifier: Apache-2.0
// Once per asset: runs the sources' cook for what is new or changed in a scene.
#ifndef CLAST_COOK_COOK_H
#define CLAST_COOK_COOK_H

#include "cook/cache.h"

// A scene's units, by geometry number, and the templates they share.
typedef struct clast_cooked {
    clast_context *context;
    clast_template_set *templates;
    clast_height_store *heights;
    const clast_pattern_table *patterns;
    clast_file_cache file_cache;
    clast_cook_cache cache; // empty where the context has no folder for it
    clast_unit **units;
    size_t unit_count, unit_capacity;
    clast_geometry
        *geometries; // copies of the scene's records, which may move when the scene is edited; units point here
    size_t geometry_capacity;
    clast_unit **retired; // replaced units: a frame made before may still point into them
    size_t retired_count, retired_capacity;
    uint32_t serials; // units ever cooked
    uint64_t bytes;
    double milliseconds; // of the last update
} clast_cooked;

clast_status clast_cooked_create(clast_context *context, clast_cooked **cooked);
void clast_cooked_destroy(clast_cooked *cooked);
// Has triangles cut by other patterns from the next update on: the caller's table, which stays until units that were cooked with
// it are released; null, as at first, is the library's own.
void clast_cooked_use_patterns(clast_cooked *cooked, const clast_pattern_table *patterns);
// Cooks new geometries of the scene, cooks changed ones anew, keeps the rest. Reports progress as "cook". Where it
// fails, each unit is either the old or the new one, whole.
clast_status clast_cooked_update(clast_cooked *cooked, const clast_scene *scene);
// Frees replaced units: called by a frame that no longer points into them.
void clast_cooked_release(clast_cooked *cooked);

#endif
