// SPDX-License-Identifier: Apache-2.0
// What the map of each triangle holds over it, at least and at most: cooked, or found in the cache.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/thread.h"
#include "source/displaced_cook.h"

enum { TRIANGLE_GRAIN = 1024 };

// ------------------------------------------------------------------------------------------------------------- finding

static clast_height_range range_of(const displaced_unit *unit, const clast_mesh *mesh, size_t triangle)
{
    const displaced_map *map = &unit->maps[displaced_map_of(unit, (uint32_t)triangle)];
    if (map->height == NULL) {
        return (clast_height_range){0.0f, 0.0f};
    }
    vec2 corners[3];
    float density = 0.0f, shortest = 0.0f;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t vertex = mesh->indices[3 * triangle + k];
        corners[k] = clast_displaced_coordinates(map, mesh, vertex);
        density = max1(density, unit->vertices[unit->vertex_of[vertex]].density_square);
        shortest = max1(shortest, unit->vertices[unit->vertex_of[vertex]].shortest_square);
    }
    return clast_height_bounds(map->height, corners, vertex_rest_level(density, shortest));
}

typedef struct range_job {
    const displaced_unit *unit;
    const clast_mesh *mesh;
    clast_height_range *ranges;
} range_job;

static void find_ranges(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const range_job *job = data;
    for (size_t i = begin; i < end; i++) {
        job->ranges[i] = range_of(job->unit, job->mesh, i);
    }
}

// --------------------------------------------------------------------------------------------------------------- cache

// All that ranges follow from, and a number that grows where they follow otherwise.
static clast_cook_key key_of(const displaced_unit *unit, const clast_mesh *mesh)
{
    static const char how[] = "height ranges 1";
    XXH3_state_t state;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, how, sizeof how);
    for (size_t i = 0; i < unit->map_count; i++) {
        const displaced_map *map = &unit->maps[i];
        uint64_t texels = map->height != NULL ? map->height->hash : 0;
        XXH3_128bits_update(&state, &texels, sizeof texels);
        XXH3_128bits_update(&state, &map->coordinate_set, sizeof map->coordinate_set);
        XXH3_128bits_update(&state, map->columns, sizeof map->columns);
        XXH3_128bits_update(&state, &map->moved, sizeof map->moved);
    }
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        uint32_t map = displaced_map_of(unit, (uint32_t)i);
        XXH3_128bits_update(&state, &map, sizeof map);
    }
    XXH3_128bits_update(&state, mesh->indices, 12 * (size_t)mesh->triangle_count);
    XXH3_128bits_update(&state, mesh->positions, 12 * (size_t)mesh->vertex_count);
    for (uint32_t set = 0; set < 2; set++) {
        bool is_there = mesh->coordinates[set] != NULL;
        XXH3_128bits_update(&state, mesh->coordinates[set], is_there ? 8 * (size_t)mesh->vertex_count : 0);
    }
    XXH128_hash_t hash = XXH3_128bits_digest(&state);
    return (clast_cook_key){hash.low64, hash.high64};
}

static clast_height_range range_of_map(const displaced_map *map)
{
    static const vec2 anywhere[3] = {{NAN, NAN}, {NAN, NAN}, {NAN, NAN}};
    return map->height != NULL ? clast_height_bounds(map->height, anywhere, 0.0f) : (clast_height_range){0.0f, 0.0f};
}

// What a cache holds may be anything: no more is believed than could be.
static bool could_be(const displaced_unit *unit, const clast_mesh *mesh, const clast_height_range *ranges)
{
    bool could = true;
    for (size_t map = 0; map < unit->map_count; map++) {
        clast_height_range most = range_of_map(&unit->maps[map]);
        for (size_t i = 0; i < mesh->triangle_count; i++) {
            bool within = ranges[i].lower >= most.lower && ranges[i].lower <= ranges[i].upper &&
                          ranges[i].upper <= most.upper; // false for what is no number
            could = could && (within || displaced_map_of(unit, (uint32_t)i) != map);
        }
    }
    return could;
}

clast_status clast_displaced_find_heights(const displaced_cook *cook, const clast_cook_cache *cache,
                                          clast_height_range **result)
{
    const displaced_unit *unit = cook->unit;
    size_t count = cook->mesh->triangle_count;
    clast_height_range *ranges = clast_allocate(cook->context, count, sizeof *ranges);
    if (ranges == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *result = ranges;
    clast_cook_key key = {0, 0};
    if (cache != NULL) {
        key = key_of(unit, cook->mesh);
        if (cache->find(cache->user, key, ranges, count * sizeof *ranges) && could_be(unit, cook->mesh, ranges)) {
            return CLAST_OK;
        }
    }
    range_job job = {unit, cook->mesh, ranges};
    clast_parallel_for(cook->context, count, TRIANGLE_GRAIN, find_ranges, &job);
    if (cache != NULL) {
        cache->keep(cache->user, key, ranges, count * sizeof *ranges);
    }
    return CLAST_OK;
}
