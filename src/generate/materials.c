// SPDX-License-Identifier: Apache-2.0
#include "generate/materials.h"

#include <math.h>
#include <stdio.h>

#include "generate/noise.h"
#include "generate/surface.h"

static const char NAME[] = "materials";

enum { COLUMNS = 7, TILES_ACROSS = 18, TILES_UP = 8 };
static const float RADIUS = 0.44f, TILE = 0.5f, BOARD_DISTANCE = 60.0f;
static const float SUN[3] = {-0.45f, 0.6f, 0.66f};

// What a row of spheres varies, `t` from 0 to 1 along it.
typedef void (*material_of_row)(uint32_t row, float t, clast_gltf_material *material);

typedef struct board {
    const char *name; // of its camera
    uint32_t rows;
    material_of_row make;
} board;

// ------------------------------------------------------------------------------------------------------------ materials

static void paint(clast_gltf_material *m, float red, float green, float blue, float metallic, float roughness)
{
    m->colour[0] = red;
    m->colour[1] = green;
    m->colour[2] = blue;
    m->metallic = metallic;
    m->roughness = roughness;
}

// An extension with one number; what jansson cannot allocate is null, which the writer notes.
static json_t *one(const char *extension, const char *key, double value)
{
    return json_pack("{s:{s:f}}", extension, key, value);
}

static json_t *two(const char *extension, const char *key, double value, const char *other, double second)
{
    return json_pack("{s:{s:f, s:f}}", extension, key, value, other, second);
}

// Gold and red paint from smooth to rough, then from paint to metal.
static void make_base(uint32_t row, float t, clast_gltf_material *m)
{
    if (row == 0) {
        paint(m, 1.0f, 0.77f, 0.34f, 1.0f, t);
    } else if (row == 1) {
        paint(m, 0.7f, 0.08f, 0.06f, 0.0f, t);
    } else {
        paint(m, 0.55f, 0.56f, 0.9f, t, 0.3f);
    }
}

// Indices of refraction from 1 to 3, strength from 0 to 1, colour from white to blue.
static void make_specular(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.08f, 0.08f, 0.09f, 0.0f, 0.15f);
    double x = (double)t;
    m->extensions = row == 0 ? one("KHR_materials_ior", "ior", 1.0 + 2.0 * x)
                    : row == 1
                        ? one("KHR_materials_specular", "specularFactor", x)
                        : json_pack("{s:{s:[f, f, f]}, s:{s:f}}", "KHR_materials_specular", "specularColorFactor",
                                    1.0 - 0.9 * x, 1.0 - 0.6 * x, 1.0, "KHR_materials_ior", "ior", 2.0);
}

// More and more of a coat on rough paint, then a coat from smooth to rough on metal.
static void make_clearcoat(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.6f, 0.05f, 0.08f, row == 0 ? 0.0f : 1.0f, 0.6f);
    m->extensions = two("KHR_materials_clearcoat", "clearcoatFactor", row == 0 ? (double)t : 1.0,
                        "clearcoatRoughnessFactor", row == 0 ? 0.0 : (double)t);
}

// Fuzz from fine to coarse, then from none to white.
static void make_sheen(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.12f, 0.03f, 0.16f, 0.0f, 1.0f);
    double colour = row == 0 ? 1.0 : (double)t;
    m->extensions = json_pack("{s:{s:[f, f, f], s:f}}", "KHR_materials_sheen", "sheenColorFactor", colour, colour,
                              colour, "sheenRoughnessFactor", row == 0 ? (double)t : 0.4);
}

// More and more stretched highlights, then turned ones.
static void make_anisotropy(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.95f, 0.93f, 0.88f, 1.0f, 0.25f);
    m->extensions = two("KHR_materials_anisotropy", "anisotropyStrength", row == 0 ? (double)t : 0.9,
                        "anisotropyRotation", row == 0 ? 0.0 : 3.14159265 * (double)t);
}

// Thin walls from smooth to rough, solid glass likewise, then more and more glass.
static void make_transmission(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 1.0f, 1.0f, 1.0f, 0.0f, row < 2 ? t : 0.0f);
    m->extensions = json_pack("{s:{s:f}, s:{s:f}}", "KHR_materials_transmission", "transmissionFactor",
                              row < 2 ? 1.0 : (double)t, "KHR_materials_volume", "thicknessFactor",
                              row == 0 ? 0.0 : 1.0);
    m->colour[0] = row == 2 ? 0.3f : 1.0f;
}

// Less and less clear glass, then denser and denser glass.
static void make_volume(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f);
    m->extensions = json_pack("{s:{s:f}, s:{s:f, s:f, s:[f, f, f]}, s:{s:f}}", "KHR_materials_transmission",
                              "transmissionFactor", 1.0, "KHR_materials_volume", "thicknessFactor", 1.0,
                              "attenuationDistance", row == 0 ? 4.0 * pow(0.05, (double)t) : 2.0, "attenuationColor",
                              0.1, 0.6, 0.9, "KHR_materials_ior", "ior", row == 0 ? 1.3 : 1.0 + 1.42 * (double)t);
}

static void make_dispersion(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f);
    m->extensions = json_pack("{s:{s:f}, s:{s:f}, s:{s:f}, s:{s:f}}", "KHR_materials_transmission",
                              "transmissionFactor", 1.0, "KHR_materials_volume", "thicknessFactor", 1.0,
                              "KHR_materials_ior", "ior", row == 0 ? 1.5 : 2.2, "KHR_materials_dispersion",
                              "dispersion", 8.0 * (double)t);
}

// Films from thin to thick on black paint and on metal, then on glass.
static void make_iridescence(uint32_t row, float t, clast_gltf_material *m)
{
    double thickness = 100.0 + 900.0 * (double)t;
    paint(m, 0.02f, 0.02f, 0.02f, 0.0f, 0.1f);
    if (row == 1) {
        paint(m, 0.7f, 0.7f, 0.7f, 1.0f, 0.25f);
    } else if (row == 2) {
        paint(m, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f);
    }
    m->extensions = json_pack("{s:{s:f, s:f, s:f}, s:{s:f}}", "KHR_materials_iridescence", "iridescenceFactor", 1.0,
                              "iridescenceIor", row == 1 ? 2.0 : 1.6, "iridescenceThicknessMaximum", thickness,
                              "KHR_materials_transmission", "transmissionFactor", row == 2 ? 1.0 : 0.0);
}

// More and more light that passes, then its colours; a lamp stands behind.
static void make_diffuse_transmission(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.6f, 0.6f, 0.55f, 0.0f, 1.0f);
    double x = (double)t;
    m->extensions = json_pack("{s:{s:f, s:[f, f, f]}}", "KHR_materials_diffuse_transmission",
                              "diffuseTransmissionFactor", row == 0 ? x : 0.8, "diffuseTransmissionColorFactor",
                              row == 0 ? 0.9 : 1.0 - x, row == 0 ? 0.9 : 0.6, row == 0 ? 0.8 : x);
}

// Stronger and stronger light, then colours that light does not change.
static void make_emission(uint32_t row, float t, clast_gltf_material *m)
{
    paint(m, 0.2f + 0.6f * t, 0.5f, 0.8f - 0.6f * t, 0.0f, 0.6f);
    if (row == 0) {
        m->emissive[0] = 1.0f;
        m->emissive[1] = 0.55f;
        m->emissive[2] = 0.2f;
        m->extensions = one("KHR_materials_emissive_strength", "emissiveStrength", 0.1 * pow(100.0, (double)t));
    } else {
        m->extensions = json_pack("{s:{}}", "KHR_materials_unlit");
    }
}

static const board boards[] = {
    {"base", 3, make_base},
    {"specular", 3, make_specular},
    {"clearcoat", 2, make_clearcoat},
    {"sheen", 2, make_sheen},
    {"anisotropy", 2, make_anisotropy},
    {"transmission", 3, make_transmission},
    {"volume", 2, make_volume},
    {"dispersion", 2, make_dispersion},
    {"iridescence", 3, make_iridescence},
    {"diffuse_transmission", 2, make_diffuse_transmission},
    {"emission", 2, make_emission},
};
enum { BOARDS = sizeof boards / sizeof boards[0] };

// --------------------------------------------------------------------------------------------------------------- shapes

typedef struct sphere {
    vec3 centre;
} sphere;

static void sphere_point(const void *shape, float u, float v, clast_surface_point *point)
{
    const sphere *s = shape;
    float ring = wave_sine(0.5f * v);
    vec3 normal = vec3(ring * wave_sine(u), -wave_cosine(0.5f * v), ring * wave_cosine(u));
    *point = (clast_surface_point){s->centre + normal * RADIUS, normal, splat3(1.0f), vec2(u, 1.0f - v)};
}

typedef struct tile {
    vec3 corner, right, up;
} tile;

static void tile_point(const void *shape, float u, float v, clast_surface_point *point)
{
    const tile *t = shape;
    *point = (clast_surface_point){t->corner + t->right * u + t->up * v, normalize3(cross3(t->right, t->up)),
                                   splat3(1.0f), vec2(u, v)};
}

typedef struct maker {
    clast_gltf_writer writer;
    clast_builder builder;
    uint32_t light, dark, lamp; // materials
    double detail;
} maker;

static vec3 board_place(uint32_t number)
{
    return vec3(BOARD_DISTANCE * (float)number, 0.0f, 0.0f);
}

static void build_sphere(maker *m, vec3 centre, uint32_t material)
{
    sphere shape = {centre};
    clast_sheet sheet = {.shape = &shape, .evaluate = sphere_point, .wraps_columns = true};
    clast_sheet_divide(&sheet, 3600.0 * m->detail, 2.0f, 1.0f);
    clast_gltf_begin_primitive(&m->writer, material);
    clast_build_sheet(&m->builder, &sheet);
    clast_gltf_end_primitive(&m->writer);
}

static void build_tile(maker *m, vec3 corner, vec3 right, vec3 up)
{
    tile shape = {corner, right, up};
    clast_sheet sheet = {.shape = &shape, .evaluate = tile_point, .columns = 1, .rows = 1};
    clast_build_sheet(&m->builder, &sheet);
}

// A wall and a floor of squares of two colours.
static void build_wall(maker *m, vec3 at)
{
    for (uint32_t colour = 0; colour < 2; colour++) {
        clast_gltf_begin_primitive(&m->writer, colour == 0 ? m->light : m->dark);
        for (uint32_t i = 0; i < TILES_ACROSS * 2 * TILES_UP; i++) {
            uint32_t column = i % TILES_ACROSS, row = i / TILES_ACROSS;
            if ((column + row) % 2 != colour) {
                continue;
            }
            float x = ((float)column - 0.5f * TILES_ACROSS) * TILE, along = (float)row * TILE;
            if (row < TILES_UP) {
                build_tile(m, at + vec3(x, along, -1.5f), vec3(TILE, 0.0f, 0.0f), vec3(0.0f, TILE, 0.0f));
            } else {
                float z = -1.5f + along - TILES_UP * TILE;
                build_tile(m, at + vec3(x, 0.0f, z + TILE), vec3(TILE, 0.0f, 0.0f), vec3(0.0f, 0.0f, -TILE));
            }
        }
        clast_gltf_end_primitive(&m->writer);
    }
}

static void build_board(maker *m, uint32_t number)
{
    const board *from = &boards[number];
    vec3 at = board_place(number);
    clast_gltf_begin_mesh(&m->writer);
    build_wall(m, at);
    for (uint32_t i = 0; i < from->rows * COLUMNS; i++) {
        uint32_t row = i / COLUMNS, column = i % COLUMNS;
        char name[64];
        snprintf(name, sizeof name, "%s %u %u", from->name, row, column);
        clast_gltf_material material = {.name = name};
        from->make(row, (float)column / (COLUMNS - 1), &material);
        m->writer.failed |= material.extensions == NULL && from->make != make_base; // memory ran out
        vec3 centre = at + vec3((float)column - 0.5f * (COLUMNS - 1), 0.55f + (float)(from->rows - 1 - row), 0.0f);
        build_sphere(m, centre, clast_gltf_add_material(&m->writer, &material));
    }
    if (from->make == make_diffuse_transmission) {
        clast_gltf_begin_primitive(&m->writer, m->lamp);
        build_tile(m, at + vec3(-3.5f, 0.2f, -1.2f), vec3(7.0f, 0.0f, 0.0f), vec3(0.0f, 1.8f, 0.0f));
        clast_gltf_end_primitive(&m->writer);
    }
    uint32_t mesh = clast_gltf_end_mesh(&m->writer, from->name);
    clast_gltf_add_node(&m->writer, from->name, mesh, splat3(0.0f), vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
    float middle = 0.5f * (float)from->rows + 0.05f;
    clast_gltf_writer_add_camera(&m->writer, from->name, at + vec3(0.0f, middle + 0.6f, 9.0f),
                                 at + vec3(0.0f, middle, 0.0f), 0.43f);
}

static void write_model(maker *m, clast_outputs *outputs)
{
    clast_gltf_begin(&m->writer, outputs, NAME);
    m->builder = (clast_builder){
        .context = outputs->context, .writer = &m->writer, .expected = (uint64_t)(BOARDS * 63000.0 * m->detail)};
    clast_gltf_material light = {.name = "light", .roughness = 0.9f, .colour = {0.75f, 0.73f, 0.7f}};
    clast_gltf_material dark = {.name = "dark", .roughness = 0.9f, .colour = {0.16f, 0.17f, 0.2f}};
    clast_gltf_material lamp = {.name = "lamp", .roughness = 1.0f, .emissive = {1.0f, 0.95f, 0.9f}};
    lamp.extensions = one("KHR_materials_emissive_strength", "emissiveStrength", 3.0);
    m->light = clast_gltf_add_material(&m->writer, &light);
    m->dark = clast_gltf_add_material(&m->writer, &dark);
    m->lamp = clast_gltf_add_material(&m->writer, &lamp);
    for (uint32_t i = 0; i < BOARDS && outputs->status == CLAST_OK; i++) {
        build_board(m, i);
    }
    clast_builder_end(&m->builder);
    clast_gltf_end(&m->writer);
}

clast_status clast_generate_materials(clast_context *context, double detail, uint32_t seed, const char *folder)
{
    (void)seed; // there is nothing that chance decides
    clast_outputs *outputs = clast_allocate_zeroed(context, 1, sizeof *outputs);
    maker *m = clast_allocate_zeroed(context, 1, sizeof *m);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (outputs != NULL && m != NULL) {
        clast_outputs_begin(outputs, context, folder);
        m->detail = detail;
        write_model(m, outputs);
        json_t *root = json_pack("{s:i, s:[{s:s}], s:{s:{s:[f, f, f]}}, s:{s:s}}", "clast", 1, "models", "path",
                                 "materials.gltf", "environment", "sky", "sun_direction", (double)SUN[0],
                                 (double)SUN[1], (double)SUN[2], "settings", "camera", boards[0].name);
        clast_write_scene_file(outputs, root); // last: a folder with it is whole
        status = clast_outputs_commit(outputs);
    }
    clast_free(context, m);
    clast_free(context, outputs);
    return status;
}
