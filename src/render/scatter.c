// SPDX-License-Identifier: Apache-2.0
#include "render/scatter.h"

#include "base/thread.h"

enum {
    SIDE = SCATTER_SIDE,
    CELLS = SCATTER_CELLS,
    PER_AXIS = 32, // samples of a cell, along each axis of the unit square
};

// ---------------------------------------------------------------------------------------------------------- integration

static vec3 view_at(uint32_t column)
{
    float root = (float)column / (SIDE - 1);
    float cosine = max1(root * root, 1e-4f);
    return vec3(rough_sqrt(1.0f - cosine * cosine), 0.0f, cosine);
}

// The middles of PER_AXIS x PER_AXIS squares, those of a row shifted against those before it.
static vec2 square_at(uint32_t i)
{
    uint32_t x = i % PER_AXIS, y = i / PER_AXIS;
    return vec2(((float)x + ((float)y + 0.5f) / PER_AXIS) / PER_AXIS, ((float)y + 0.5f) / PER_AXIS);
}

// What a facet sends to where others do not shadow it.
static float unshadowed(vec2 alpha, vec3 view, vec3 light, bool sound)
{
    float masked = glass_smith(alpha, view);
    return sound ? (1.0f + masked) / (1.0f + masked + glass_smith(alpha, light)) : 0.0f;
}

// `bare`: facets reflect nothing but what they must.
static float integrate_glass(float roughness, float eta, bool bare, vec3 view)
{
    vec2 alpha = splat2(max1(roughness * roughness, ALPHA_LEAST));
    float sum = 0.0f;
    for (uint32_t i = 0; i < PER_AXIS * PER_AXIS; i++) {
        vec3 h = ggx_visible_normal(alpha, view, square_at(i));
        float cosine = dot3(view, h);
        float full = fresnel_dielectric(cosine, eta);
        float reflects = bare && full < 1.0f ? 0.0f : full;
        vec3 mirrored = h * (2.0f * cosine) - view, passed = refract_view(view, h, eta);
        sum += reflects * unshadowed(alpha, view, mirrored, mirrored[2] > 1e-6f);
        sum += (1.0f - reflects) * unshadowed(alpha, view, passed, passed[2] < -1e-6f);
    }
    return sum / (PER_AXIS * PER_AXIS);
}

static float sheen_albedo(float roughness, vec3 view)
{
    float alpha = max1(roughness * roughness, SHEEN_ALPHA_LEAST), sum = 0.0f;
    for (uint32_t i = 0; i < PER_AXIS * PER_AXIS; i++) {
        vec2 u = square_at(i), circle = circle_point(u[1]);
        float level = rough_sqrt(1.0f - u[0] * u[0]);
        sum += sheen_value(alpha, view, vec3(level * circle[0], level * circle[1], u[0]));
    }
    return min1(sum * 2.0f * PI / (PER_AXIS * PER_AXIS), 1.0f);
}

static void fill_glass(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_scatter_tables *tables = data;
    for (size_t i = begin; i < end; i++) { // a row of a table's side
        clast_glass_table *table = &tables->glass[i / (GLASS_TABLES * SIDE)];
        uint32_t number = (uint32_t)(i / SIDE % GLASS_TABLES), row = (uint32_t)(i % SIDE);
        float eta = number >= glass_table(1, 0) ? 1.0f / table->ior : table->ior;
        bool bare = number % 2 != 0;
        for (uint32_t column = 0; column < SIDE; column++) {
            float roughness = (float)row / (SIDE - 1);
            table->albedos[number][row * SIDE + column] = integrate_glass(roughness, eta, bare, view_at(column));
        }
    }
}

static void fill_sheen(clast_scatter_tables *tables)
{
    for (uint32_t i = 0; i < CELLS; i++) {
        tables->sheen[i] = sheen_albedo((float)(i / SIDE) / (SIDE - 1), view_at(i % SIDE));
    }
}

// --------------------------------------------------------------------------------------------------------------- tables

// Glass that disperses has a table for each colour, one after the other.
static clast_status table_of(clast_context *context, clast_scatter_tables *tables, const clast_material *material,
                             uint32_t *number)
{
    *number = CLAST_NONE;
    if ((material->layers & MATERIAL_TRANSMISSION) == 0 || !(material->thickness > 0.0f)) {
        return CLAST_OK;
    }
    uint32_t count = material->dispersion > 0.0f ? 3 : 1;
    float iors[3] = {glass_ior(material->ior)};
    for (uint32_t i = 0; i < count && count > 1; i++) {
        iors[i] = glass_ior(dispersed_ior(material->ior, material->dispersion, i));
    }
    for (*number = 0; *number + count <= tables->glass_count; (*number)++) {
        uint32_t same = 0;
        while (same < count && tables->glass[*number + same].ior == iors[same]) {
            same++;
        }
        if (same == count) {
            return CLAST_OK;
        }
    }
    clast_status status = CLAST_RESERVE(context, tables->glass, tables->glass_capacity, tables->glass_count + count);
    *number = (uint32_t)tables->glass_count;
    for (uint32_t i = 0; i < count && status == CLAST_OK; i++) {
        tables->glass[tables->glass_count++].ior = iors[i];
    }
    return status;
}

clast_status clast_scatter_create(const clast_scene *scene, clast_scatter_tables **result)
{
    clast_context *context = scene->context;
    clast_scatter_tables *tables = clast_allocate_zeroed(context, 1, sizeof *tables);
    if (tables == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    tables->glass_of = clast_allocate(context, scene->material_count, sizeof *tables->glass_of);
    clast_status status = tables->glass_of != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    bool fuzzy = false;
    for (size_t i = 0; i < scene->material_count && status == CLAST_OK; i++) {
        status = table_of(context, tables, &scene->materials[i].record, &tables->glass_of[i]);
        fuzzy = fuzzy || (scene->materials[i].record.layers & MATERIAL_SHEEN) != 0;
    }
    if (status != CLAST_OK) {
        clast_scatter_destroy(context, tables);
        return status;
    }
    clast_parallel_for(context, tables->glass_count * GLASS_TABLES * SIDE, 1, fill_glass, tables);
    if (fuzzy) {
        fill_sheen(tables);
    }
    *result = tables;
    return CLAST_OK;
}

void clast_scatter_destroy(clast_context *context, clast_scatter_tables *tables)
{
    if (tables != NULL) {
        clast_free(context, tables->glass);
        clast_free(context, tables->glass_of);
        clast_free(context, tables);
    }
}

static float look_up(const float table[CELLS], float roughness, float cosine)
{
    clast_scatter_place at = scatter_place(roughness, cosine);
    const float *low = table + at.first, *high = low + SIDE;
    return scatter_blend(at, low[0], low[1], high[0], high[1]);
}

clast_bsdf clast_scatter_make(const clast_scatter_tables *tables, uint32_t material, const clast_bsdf_input *from,
                              float alpha_floor, vec3 view)
{
    clast_glass_albedo glass = glass_albedo(1.0f, 1.0f);
    float sheen = 0.0f;
    if (from->transmission > 0.0f) {
        float roughness = scatter_roughness(*from, alpha_floor);
        uint32_t number = tables->glass_of[material];
        if (from->thin != 0 || number == CLAST_NONE) {
            glass = thin_glass_albedo(roughness, view[2]);
        } else {
            const clast_glass_table *table = &tables->glass[number + from->colour];
            glass = glass_albedo(look_up(table->albedos[glass_table(from->inside, 0)], roughness, view[2]),
                                 look_up(table->albedos[glass_table(from->inside, 1)], roughness, view[2]));
        }
    }
    if (largest3(load3(from->sheen)) > 0.0f) {
        sheen = look_up(tables->sheen, from->sheen_roughness, view[2]);
    }
    return bsdf_make(*from, alpha_floor, view, glass, sheen);
}
