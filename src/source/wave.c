// SPDX-License-Identifier: Apache-2.0
// The waving sheet: the smallest source that moves and adapts. An item is a tile, and a record is one grid template.
#include <math.h>

#include "shared/wave.h"
#include "source/source.h"

// More waves than this across the sheet are beyond what single precision tells apart.
static const double most_waves = 65536.0;

typedef struct wave_unit {
    clast_unit base;
    clast_wave_sheet sheet;
    float speed;
    uint32_t templates[GRID_SEGMENTS + 1]; // by n
    uint32_t material;                     // what base.materials points to
} wave_unit;

static const wave_unit *wave_of(const clast_unit *unit)
{
    return (const wave_unit *)unit;
}

static uint64_t work(const clast_geometry *geometry)
{
    (void)geometry;
    return 1;
}

static clast_status check(clast_context *context, const clast_geometry *geometry)
{
    const clast_wave *wave = &geometry->of.wave;
    const char *name = geometry->name != NULL ? geometry->name : "wave";
    bool sound = isfinite(wave->size) && wave->size > 0.0f && isfinite(wave->amplitude) && isfinite(wave->wavelength) &&
                 wave->wavelength > 0.0f && isfinite(wave->speed) && wave->tiles >= 1 && wave->tiles <= 1024;
    if (!sound) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s: a sheet's size and wavelength must be more than 0 and finite, its tiles 1 to 1024",
                          name);
    }
    if ((double)wave->size / (double)wave->wavelength > most_waves) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%s: %g waves across the sheet, expected at most %g", name,
                          (double)wave->size / (double)wave->wavelength, most_waves);
    }
    return CLAST_OK;
}

static clast_wave_sheet make_sheet(const clast_wave *wave)
{
    double frequency = 1.0 / (double)wave->wavelength;
    clast_wave_sheet sheet = {
        .tiles = wave->tiles,
        .material = wave->material != CLAST_NONE ? wave->material : 0,
        .size = wave->size,
        .amplitude = wave->amplitude,
        .tile_length = (float)((double)wave->size / wave->tiles),
        // a long wave, and a shorter one across it
        .first_wave = {{(float)(0.8 * frequency), (float)(0.6 * frequency)}},
        .second_wave = {{(float)(-1.0 * frequency), (float)(1.25 * frequency)}},
    };
    for (uint32_t n = 1; n <= GRID_SEGMENTS; n++) {
        sheet.half_steps[n] = (float)((double)wave->size / (2.0 * wave->tiles * n));
    }
    return sheet;
}

static clast_status cook(const clast_cook_job *job, clast_unit **result)
{
    clast_context *context = job->context;
    const clast_geometry *geometry = job->geometry;
    clast_status status = check(context, geometry);
    if (status != CLAST_OK) {
        return status;
    }
    wave_unit *unit = clast_allocate_zeroed(context, 1, sizeof *unit);
    if (unit == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t n = 1; n <= GRID_SEGMENTS && status == CLAST_OK; n++) {
        status = clast_template_set_add_grid(job->templates, n, n, &unit->templates[n]);
    }
    if (status != CLAST_OK) {
        clast_free(context, unit);
        return status;
    }
    unit->sheet = make_sheet(&geometry->of.wave);
    unit->speed = geometry->of.wave.speed;
    unit->material = unit->sheet.material;
    unit->base = (clast_unit){
        .context = context,
        .kind = CLAST_SOURCE_WAVE,
        .geometry = geometry,
        .geometry_version = geometry->version,
        .item_count = unit->sheet.tiles * unit->sheet.tiles,
        .bytes = sizeof *unit,
        .materials = &unit->material,
        .material_count = 1,
    };
    *result = &unit->base;
    return CLAST_OK;
}

static void destroy(clast_unit *unit)
{
    clast_free(unit->context, unit);
}

static clast_status update(clast_unit *unit, const clast_geometry *geometry)
{
    (void)unit;
    (void)geometry;
    return CLAST_ERROR_UNSUPPORTED; // cooking anew costs nothing
}

static double turns_within_one(double turns)
{
    return turns - floor(turns);
}

static clast_wave_moment moment_of(const wave_unit *unit, const clast_pose *pose)
{
    double turns = (double)unit->speed * pose->time;
    // rounding to float may give 1: the sine takes any
    return (clast_wave_moment){(float)turns_within_one(turns), (float)turns_within_one(turns * 1.25)};
}

static packed4 moment(const clast_unit *unit, const clast_pose *pose)
{
    clast_wave_moment moment = moment_of(wave_of(unit), pose);
    return (packed4){{moment.first_turns, moment.second_turns, 0.0f, 0.0f}};
}

static clast_box bounds(const clast_unit *base, const clast_pose *pose)
{
    (void)pose;
    const clast_wave_sheet *sheet = &wave_of(base)->sheet;
    // wider than the sine's error and the rounding of a vertex's place
    float half = sheet->size * 0.50001f;
    float height = fabsf(sheet->amplitude) * 1.0001f;
    return (clast_box){{{-half, -height, -half}}, {{half, height, half}}};
}

static clast_change changed(const clast_unit *base, const clast_pose *before, const clast_source_view *view_before,
                            const clast_pose *now, const clast_source_view *view_now)
{
    const wave_unit *unit = wave_of(base);
    if (wave_segments(unit->sheet, *view_before) != wave_segments(unit->sheet, *view_now)) {
        return CLAST_CHANGE_TOPOLOGY;
    }
    clast_wave_moment a = moment_of(unit, before);
    clast_wave_moment b = moment_of(unit, now);
    bool same = a.first_turns == b.first_turns && a.second_turns == b.second_turns;
    return same && before->version == now->version ? CLAST_CHANGE_NOTHING : CLAST_CHANGE_VERTICES;
}

static float deviation(const clast_unit *unit, const clast_pose *pose)
{
    (void)pose;
    return 2.0f * fabsf(wave_of(unit)->sheet.amplitude);
}

static uint32_t arrays(const clast_unit *base, clast_source_array arrays[CLAST_SOURCE_ARRAYS_MOST])
{
    const wave_unit *unit = wave_of(base);
    arrays[WAVE_ARRAY_SHEET] = (clast_source_array){"sheet", &unit->sheet, sizeof unit->sheet, base->version, 0};
    arrays[WAVE_ARRAY_TEMPLATES] = (clast_source_array){"templates", unit->templates, sizeof unit->templates,
                                                        base->version, 0};
    return WAVE_ARRAYS;
}

static clast_source_count count(const clast_unit *base, const clast_pose *pose, const clast_source_view *view,
                                uint32_t item)
{
    (void)pose;
    (void)item;
    return wave_count(wave_segments(wave_of(base)->sheet, *view));
}

static void emit(const clast_unit *base, const clast_pose *pose, const clast_source_view *view, uint32_t item,
                 uint32_t first_vertex, uint32_t first_word, uint32_t *words, clast_cluster_record *records)
{
    (void)words;
    (void)pose;
    const wave_unit *unit = wave_of(base);
    uint32_t n = wave_segments(unit->sheet, *view);
    records[0] = wave_record(n, unit->templates[n], base->number, item, first_vertex, first_word);
}

static void fill(const clast_unit *base, const clast_pose *pose, const clast_cluster_record *record,
                 const uint32_t *words, packed3 *positions)
{
    (void)words;
    const wave_unit *unit = wave_of(base);
    clast_wave_moment moment = moment_of(unit, pose);
    uint32_t n = record->detail;
    uint32_t first_column = record->item % unit->sheet.tiles * n;
    uint32_t first_row = record->item / unit->sheet.tiles * n;
    for (uint32_t j = 0; j <= n; j++) {
        for (uint32_t i = 0; i <= n; i++) {
            positions[j * (n + 1) + i] = store3(wave_vertex(unit->sheet, moment, n, first_column + i, first_row + j));
        }
    }
}

static const packed3 *resident(const clast_unit *unit, const clast_cluster_record *record)
{
    (void)unit;
    (void)record;
    return NULL;
}

static clast_surface_point locate(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                                  const uint32_t *words, uint32_t triangle, vec2 barycentrics)
{
    (void)words;
    (void)unit;
    (void)pose;
    return (clast_surface_point){record->item, store2(wave_locate(record->detail, triangle, barycentrics)), 0.0f};
}

// All edges have as many.
static float segments(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                      const clast_cluster_record *record, const uint32_t *words, uint32_t triangle, vec2 barycentrics)
{
    (void)pose;
    (void)record;
    (void)words;
    (void)triangle;
    (void)barycentrics;
    return (float)wave_segments(wave_of(unit)->sheet, *view);
}

static clast_source_surface evaluate(const clast_unit *base, const clast_pose *pose, clast_surface_point point)
{
    const wave_unit *unit = wave_of(base);
    const clast_wave_sheet *sheet = &unit->sheet;
    vec2 plane = wave_plane(*sheet, point.primitive, load2(point.coordinates));
    clast_wave_height height = wave_height_and_slopes(*sheet, moment_of(unit, pose), plane[0], plane[1]);
    vec3 normal = vec3(-height.slope_x, 1.0f, -height.slope_z);
    vec2 coordinates = vec2(plane[0] / sheet->size + 0.5f, plane[1] / sheet->size + 0.5f);
    float scale = 1.0f / sheet->size;
    clast_texture_gradient gradient = {{{scale, 0.0f, 0.0f}}, {{0.0f, 0.0f, scale}}};
    return (clast_source_surface){
        .position = vec3(plane[0], height.height, plane[1]),
        .geometric_normal = normal,
        .normal = normal,
        .tangent = vec3(1.0f, height.slope_x, 0.0f),
        .bitangent_sign = 1.0f,
        .coordinates = {coordinates, coordinates},
        .colour = vec4(1.0f, 1.0f, 1.0f, 1.0f),
        .gradients = {gradient, gradient},
        .material = sheet->material,
    };
}

// A glowing sheet is seen by rays that hit it; its triangles change with n, so that there is no list of them to sample.
static uint32_t primitive_count(const clast_unit *unit)
{
    (void)unit;
    return 0;
}

static uint32_t primitive_material(const clast_unit *unit, uint32_t primitive)
{
    (void)primitive;
    return wave_of(unit)->sheet.material;
}

static void primitive_corners(const clast_unit *unit, const clast_pose *pose, uint32_t primitive, vec3 corners[3])
{
    (void)unit;
    (void)pose;
    (void)primitive;
    corners[0] = corners[1] = corners[2] = splat3(0.0f);
}

const clast_source CLAST_SOURCE_WAVE_TABLE = {
    .name = "wave",
    .most_triangles = 2 * GRID_SEGMENTS * GRID_SEGMENTS,
    .adapts = true,
    .single_items = true,
    .work = work,
    .cook = cook,
    .destroy = destroy,
    .update = update,
    .bounds = bounds,
    .changed = changed,
    .deviation = deviation,
    .arrays = arrays,
    .moment = moment,
    .count = count,
    .emit = emit,
    .fill = fill,
    .resident = resident,
    .locate = locate,
    .segments = segments,
    .evaluate = evaluate,
    .primitive_count = primitive_count,
    .primitive_material = primitive_material,
    .primitive_corners = primitive_corners,
};
