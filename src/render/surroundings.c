// SPDX-License-Identifier: Apache-2.0
// The surroundings as cells to sample: each by its brightness and its size on the sphere.
#include "base/thread.h"
#include "render/lights.h"

enum {
    CELLS_WIDTH_MOST = 1024,
    CELLS_HEIGHT_MOST = 512,
    EVEN_WIDTH = 8,
    EVEN_HEIGHT = 4,
    SKY_CELLS_WIDTH = CLAST_SKY_WIDTH,
    SKY_CELLS_HEIGHT = CLAST_SKY_HEIGHT / 2
};

// -------------------------------------------------------------------------------------------------- choice by weight

float clast_sums_make(float *sums, uint32_t count)
{
    double total = 0.0;
    for (uint32_t i = 1; i <= count; i++) {
        total += (double)sums[i];
    }
    double sum = 0.0;
    sums[0] = 0.0f;
    for (uint32_t i = 1; i <= count; i++) {
        sum += total > 0.0 ? (double)sums[i] : 1.0;
        sums[i] = (float)(sum / (total > 0.0 ? total : (double)count));
    }
    sums[count] = 1.0f;
    return (float)total;
}

uint32_t clast_sums_find(const float *sums, uint32_t count, float u, float *rest)
{
    clast_search search = search_between(0, count); // sums[low] <= u < sums[high]
    while (search_goes_on(search)) {
        search = search_step(search, !(sums[search_middle(search)] <= u));
    }
    *rest = place_between(sums[search.low], sums[search.low + 1], u);
    return search.low;
}

// --------------------------------------------------------------------------------------------------------- radiance

static vec3 image_radiance(const clast_lights *lights, vec2 place)
{
    const clast_image *image = lights->image;
    clast_texel_pair x = linear_texels(place[0], CLAST_WRAP_REPEAT, image->width);
    clast_texel_pair y = linear_texels(place[1], CLAST_WRAP_CLAMP, image->height);
    vec4 value = clast_image_blend(image, x, y, CLAST_ENCODING_SRGB, lights->table);
    vec3 radiance = max3(splat3(0.0f), vec3(value[0], value[1], value[2])); // a NaN becomes 0
    return min3(radiance, splat3(1e30f));
}

static vec3 sky_radiance(const clast_sky *sky, vec2 place)
{
    clast_texel_pair x = linear_texels(place[0], CLAST_WRAP_REPEAT, CLAST_SKY_WIDTH);
    clast_texel_pair y = linear_texels(place[1], CLAST_WRAP_CLAMP, CLAST_SKY_HEIGHT);
    const packed3 *upper = sky->radiance + (size_t)y.first * CLAST_SKY_WIDTH,
                  *lower = sky->radiance + (size_t)y.second * CLAST_SKY_WIDTH;
    return mix3(mix3(load3(upper[x.first]), load3(upper[x.second]), x.weight),
                mix3(load3(lower[x.first]), load3(lower[x.second]), x.weight), y.weight);
}

static vec3 radiance_at(const clast_lights *lights, vec2 place)
{
    if (lights->image != NULL) {
        return lights->factor * image_radiance(lights, place);
    }
    return lights->factor * (lights->sky.radiance != NULL ? sky_radiance(&lights->sky, place) : splat3(1.0f));
}

vec3 clast_surroundings_radiance(const clast_lights *lights, vec3 direction)
{
    if (lights->image == NULL && lights->sky.radiance == NULL) {
        return lights->factor;
    }
    return radiance_at(lights, surroundings_place(direction, lights->surroundings.rotation));
}

// ------------------------------------------------------------------------------------------------------------ cells

typedef struct cell_job {
    const clast_lights *lights;
    const clast_surroundings *cells;
    float *row_means; // luminance
} cell_job;

// The mean of the picture's texels whose centres lie in the cell; there is one at least.
static float cell_luminance(const clast_lights *lights, const clast_surroundings *cells, uint32_t row, uint32_t column)
{
    uint32_t width = lights->image != NULL          ? lights->image->width
                     : lights->sky.radiance != NULL ? CLAST_SKY_WIDTH
                                                    : cells->width;
    uint32_t height = lights->image != NULL          ? lights->image->height
                      : lights->sky.radiance != NULL ? CLAST_SKY_HEIGHT
                                                     : cells->height;
    uint32_t left = (uint32_t)((uint64_t)column * width / cells->width),
             right = (uint32_t)((uint64_t)(column + 1) * width / cells->width);
    uint32_t top = (uint32_t)((uint64_t)row * height / cells->height),
             bottom = (uint32_t)((uint64_t)(row + 1) * height / cells->height);
    double sum = 0.0;
    for (uint32_t y = top; y < bottom; y++) {
        for (uint32_t x = left; x < right; x++) {
            vec2 place = vec2(((float)x + 0.5f) / (float)width, ((float)y + 0.5f) / (float)height);
            sum += (double)luminance(radiance_at(lights, place));
        }
    }
    return (float)(sum / ((double)(right - left) * (bottom - top)));
}

static void cell_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cell_job *job = data;
    uint32_t width = job->cells->width;
    for (size_t row = begin; row < end; row++) {
        float *sums = job->cells->cell_sums + row * (width + 1);
        for (uint32_t column = 0; column < width; column++) {
            sums[column + 1] = cell_luminance(job->lights, job->cells, (uint32_t)row, column);
        }
        job->row_means[row] = clast_sums_make(sums, width) / (float)width;
    }
}

static uint32_t cells_along(uint32_t texels, uint32_t most)
{
    return texels < most ? texels : most;
}

clast_status clast_surroundings_create(clast_context *context, clast_lights *lights)
{
    clast_surroundings *cells = &lights->surroundings;
    if (lights->image != NULL) {
        cells->width = cells_along(lights->image->width, CELLS_WIDTH_MOST);
        cells->height = cells_along(lights->image->height, CELLS_HEIGHT_MOST);
    } else {
        bool even = lights->sky.radiance == NULL;
        cells->width = even ? EVEN_WIDTH : SKY_CELLS_WIDTH;
        cells->height = even ? EVEN_HEIGHT : SKY_CELLS_HEIGHT;
    }
    cells->row_sums = clast_allocate(context, (size_t)cells->height + 1, sizeof *cells->row_sums);
    cells->cell_sums = clast_allocate(context, (size_t)cells->height * (cells->width + 1), sizeof *cells->cell_sums);
    float *means = clast_allocate(context, cells->height, sizeof *means);
    if (cells->row_sums == NULL || cells->cell_sums == NULL || means == NULL) {
        clast_free(context, means);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    cell_job job = {lights, cells, means};
    clast_parallel_for(context, cells->height, 4, cell_rows, &job);
    for (uint32_t row = 0; row < cells->height; row++) {
        float share = means[row] * cell_row_area(row, cells->height);
        cells->row_sums[row + 1] = share;
        if (2 * row + 1 < cells->height || cells->height == 1) {
            cells->upper += share;
        } else {
            cells->lower += share;
        }
    }
    clast_sums_make(cells->row_sums, cells->height);
    clast_free(context, means);
    return CLAST_OK;
}

void clast_surroundings_destroy(clast_context *context, clast_surroundings *surroundings)
{
    clast_free(context, surroundings->row_sums);
    clast_free(context, surroundings->cell_sums);
}

static float density_in(const clast_surroundings *cells, clast_cell cell)
{
    const float *sums = cells->cell_sums + (size_t)cell.row * (cells->width + 1);
    float share = (cells->row_sums[cell.row + 1] - cells->row_sums[cell.row]) *
                  (sums[cell.column + 1] - sums[cell.column]);
    return cell_density(share, cell.row, cells->width, cells->height);
}

vec3 clast_surroundings_sample(const clast_surroundings *cells, vec2 u, float *density)
{
    float across, down;
    clast_cell cell;
    cell.row = clast_sums_find(cells->row_sums, cells->height, u[1], &down);
    const float *sums = cells->cell_sums + (size_t)cell.row * (cells->width + 1);
    cell.column = clast_sums_find(sums, cells->width, u[0], &across);
    *density = density_in(cells, cell);
    return cell_direction(cell, vec2(across, down), cells->width, cells->height, cells->rotation);
}

float clast_surroundings_density(const clast_surroundings *cells, vec3 direction)
{
    vec2 place = surroundings_place(direction, cells->rotation);
    return density_in(cells, cell_of_place(place, cells->width, cells->height));
}
