// SPDX-License-Identifier: Apache-2.0
// Displacement maps: who uses them, and the plain way to read them.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/size.h"
#include "source/height_make.h"

// --------------------------------------------------------------------------------------------------------------- store

typedef struct kept_map {
    uint32_t image;
    clast_wrap wrap_u, wrap_v;
    clast_height *height; // null where the place is free
    uint32_t users;
} kept_map;

struct clast_height_store {
    clast_context *context;
    kept_map *maps;
    size_t count, capacity;
};

clast_status clast_height_store_create(clast_context *context, clast_height_store **result)
{
    clast_height_store *store = clast_allocate_zeroed(context, 1, sizeof *store);
    if (store == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    store->context = context;
    *result = store;
    return CLAST_OK;
}

void clast_height_store_destroy(clast_height_store *store)
{
    if (store != NULL) {
        clast_context *context = store->context;
        clast_free(context, store->maps);
        clast_free(context, store);
    }
}

static void free_height(clast_context *context, clast_height *height)
{
    clast_free(context, (void *)height->texels);
    clast_free(context, (void *)height->ranges);
    clast_free(context, height);
}

static clast_status fill_height(clast_context *context, const clast_image *image, uint32_t texture,
                                clast_height *height)
{
    size_t texel_size = height->map.is_float ? sizeof(float) : sizeof(uint16_t);
    size_t range_count = clast_height_lay_out_ranges(height);
    void *texels = clast_allocate(context, height->texel_count, texel_size);
    height->texels = texels;
    clast_height_range *ranges = clast_allocate(context, range_count, sizeof *ranges);
    height->ranges = ranges;
    if (texels == NULL || ranges == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint64_t unsound = clast_height_fill_levels(context, image, height);
    if (unsound != 0) {
        clast_log(context, CLAST_LOG_WARNING, "texture %u: %llu heights are not finite: they count as 0", texture,
                  (unsigned long long)unsound);
    }
    clast_height_fill_ranges(context, height, ranges);
    height->bytes = sizeof *height + height->texel_count * texel_size + range_count * sizeof *ranges;
    height->hash = XXH3_64bits_withSeed(texels, height->texel_count * texel_size,
                                        height->map.wrap_u * 4 + height->map.wrap_v);
    return CLAST_OK;
}

static clast_status make_height(clast_context *context, const clast_scene *scene, uint32_t texture,
                                clast_height **result)
{
    const clast_texture *way = &scene->textures[texture];
    const clast_image *image = &scene->images[way->image].image;
    clast_height *height = clast_allocate_zeroed(context, 1, sizeof *height);
    if (height == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_height_lay_out(context, image, way, height);
    if (status == CLAST_OK) {
        status = fill_height(context, image, texture, height);
    }
    if (status != CLAST_OK) {
        free_height(context, height);
        return status;
    }
    *result = height;
    return CLAST_OK;
}

static kept_map *find_map(clast_height_store *store, const clast_texture *texture)
{
    for (size_t i = 0; i < store->count; i++) {
        kept_map *map = &store->maps[i];
        if (map->height != NULL && map->image == texture->image && map->wrap_u == texture->wrap_u &&
            map->wrap_v == texture->wrap_v) {
            return map;
        }
    }
    return NULL;
}

static clast_status free_place(clast_height_store *store, kept_map **place)
{
    for (size_t i = 0; i < store->count; i++) {
        if (store->maps[i].height == NULL) {
            *place = &store->maps[i];
            return CLAST_OK;
        }
    }
    clast_status status = CLAST_RESERVE(store->context, store->maps, store->capacity, store->count + 1);
    if (status == CLAST_OK) {
        *place = &store->maps[store->count++];
        **place = (kept_map){0};
    }
    return status;
}

static bool has_pixels(const clast_scene *scene, uint32_t texture)
{
    if (texture >= scene->texture_count || scene->textures[texture].image >= scene->image_count) {
        return false;
    }
    const clast_image *image = &scene->images[scene->textures[texture].image].image;
    return image->width != 0 && image->height != 0 && image->pixels != NULL;
}

clast_status clast_height_acquire(clast_height_store *store, const clast_scene *scene, uint32_t texture,
                                  const clast_height **height)
{
    if (!has_pixels(scene, texture)) {
        return clast_fail(store->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "texture %u is to displace: it is not there, or has no pixels", texture);
    }
    const clast_texture *way = &scene->textures[texture];
    kept_map *map = find_map(store, way);
    if (map == NULL) {
        clast_status status = free_place(store, &map);
        clast_height *made = NULL;
        if (status == CLAST_OK) {
            status = make_height(store->context, scene, texture, &made);
        }
        if (status != CLAST_OK) {
            return status;
        }
        *map = (kept_map){way->image, way->wrap_u, way->wrap_v, made, 0};
    }
    map->users++;
    *height = map->height;
    return CLAST_OK;
}

void clast_height_release(clast_height_store *store, const clast_height *height)
{
    for (size_t i = 0; height != NULL && i < store->count; i++) {
        kept_map *map = &store->maps[i];
        if (map->height == height && --map->users == 0) {
            free_height(store->context, map->height);
            *map = (kept_map){0};
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- reading

static vec2 wrap(const clast_height_map *map, vec2 coordinates)
{
    return vec2(wrap_coordinate(coordinates[0], map->wrap_u), wrap_coordinate(coordinates[1], map->wrap_v));
}

static float value_in_level(const clast_height *height, vec2 wrapped, uint32_t level)
{
    clast_height_texels texels = height_texels(height->map, wrapped, level);
    return height_bilinear(texels, clast_height_texel(height, texels.upper),
                           clast_height_texel(height, texels.upper + 1), clast_height_texel(height, texels.lower),
                           clast_height_texel(height, texels.lower + 1));
}

float clast_height_value(const clast_height *height, vec2 coordinates, float level)
{
    clast_height_levels levels = height_levels(height->map, level);
    vec2 wrapped = wrap(&height->map, coordinates);
    float finer = value_in_level(height, wrapped, levels.finer);
    float coarser = value_in_level(height, wrapped, levels.coarser);
    return height_between(finer, coarser, levels.weight) * height->map.unit;
}

static clast_height_slope slope_in_level(const clast_height *height, vec2 wrapped, uint32_t level)
{
    clast_height_texels texels = height_texels(height->map, wrapped, level);
    return height_bilinear_slope(height->map, level, texels, clast_height_texel(height, texels.upper),
                                 clast_height_texel(height, texels.upper + 1), clast_height_texel(height, texels.lower),
                                 clast_height_texel(height, texels.lower + 1));
}

clast_height_slope clast_height_value_and_slope(const clast_height *height, vec2 coordinates, float level)
{
    const clast_height_map *map = &height->map;
    clast_height_levels levels = height_levels(*map, level);
    vec2 wrapped = wrap(map, coordinates);
    clast_height_slope finer = slope_in_level(height, wrapped, levels.finer);
    clast_height_slope coarser = slope_in_level(height, wrapped, levels.coarser);
    vec2 a = load2(finer.slope), b = load2(coarser.slope);
    float across = height_between(a[0], b[0], levels.weight) * height_wrap_sign(coordinates[0], map->wrap_u);
    float down = height_between(a[1], b[1], levels.weight) * height_wrap_sign(coordinates[1], map->wrap_v);
    return (clast_height_slope){height_between(finer.height, coarser.height, levels.weight) * map->unit,
                                store2(vec2(across, down) * map->unit)};
}
