// SPDX-License-Identifier: Apache-2.0
// MTL libraries. Kd is the base colour, times map_Kd (white where a file sets it to black under a map); Ke and map_Ke
// emission; d or 1 - Tr the opacity, map_d its map; Pr, Pm, map_Pr, map_Pm roughness and metalness; norm, map_Bump and
// bump a normal map; disp and map_disp a height map that displaces the surface, by -mm's base and gain times -bm, as does
// a map of heights under map_Bump or bump where -mm is given (without, it is left out with a warning: nobody knows how
// high it is). Without Pr the roughness follows from Ns, by the width
// of Blinn and Phong's lobe; without Ks as well there is no gloss to describe and it is 1. Without Pm, a black Kd under
// a coloured Ks is a metal's. Ni above 1 is the index of refraction; Ps sheen, Pc and Pcr a clear coat and its roughness, aniso and
// anisor anisotropy and its turn. All else (Ka, illum, map_Ka, map_Ks, map_Ns, refl ...) has no counterpart and is
// passed over.
#include "load/mtl.h"

#include <math.h>

typedef enum mtl_slot { MAP_KD, MAP_KE, MAP_D, MAP_PR, MAP_PM, MAP_BUMP, MAP_NORM, MAP_DISP, MAP_COUNT } mtl_slot;

// A material as the file has it. Numbers that the file does not give are NaN.
typedef struct mtl_material {
    char *name; // null: none begun
    float diffuse[3], specular[3], emission[3];
    float exponent, opacity, roughness, metalness, ior, sheen, clearcoat, clearcoat_roughness, anisotropy, rotation;
    clast_mtl_map maps[MAP_COUNT];
} mtl_material;

typedef struct mtl_reader {
    clast_mtl *library;
    clast_context *context;
    const char *path;
    clast_text text;
    mtl_material material;
} mtl_reader;

static clast_status malformed(const mtl_reader *reader, const char *expected)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s, line %llu: expected %s", reader->path,
                      (unsigned long long)reader->text.line, expected);
}

static char *copy_word(clast_context *context, clast_word word)
{
    char *copy = clast_allocate(context, word.length + 1, 1);
    if (copy != NULL) {
        memcpy(copy, word.begin, word.length);
        copy[word.length] = '\0';
    }
    return copy;
}

// --------------------------------------------------------------------------------------------------- what has been
// read

static void begin_material(mtl_reader *reader)
{
    mtl_material *material = &reader->material;
    clast_free(reader->context, material->name);
    for (int i = 0; i < MAP_COUNT; i++) {
        clast_free(reader->context, material->maps[i].path);
    }
    *material = (mtl_material){
        .diffuse = {NAN, NAN, NAN},
        .specular = {NAN, NAN, NAN},
        .emission = {NAN, NAN, NAN},
        .exponent = NAN,
        .opacity = NAN,
        .roughness = NAN,
        .metalness = NAN,
        .ior = NAN,
        .sheen = NAN,
        .clearcoat = NAN,
        .clearcoat_roughness = NAN,
        .anisotropy = NAN,
        .rotation = NAN,
    };
}

static bool is_black(const float colour[3])
{
    return colour[0] == 0.0f && colour[1] == 0.0f && colour[2] == 0.0f;
}

static bool is_given(const float colour[3])
{
    return !isnan(colour[0]);
}

// Clamps to [0, 1], and says so.
static float unit(const mtl_reader *reader, float value, const char *what)
{
    float clamped = value < 0.0f ? 0.0f : value > 1.0f ? 1.0f : value;
    if (clamped != value) {
        clast_log(reader->context, CLAST_LOG_WARNING, "%s: material %s: %s is not between 0 and 1: taken as %g",
                  reader->path, reader->material.name, what, (double)clamped);
    }
    return clamped;
}

static float roughness_of(const mtl_reader *reader)
{
    const mtl_material *material = &reader->material;
    if (!isnan(material->roughness)) {
        return unit(reader, material->roughness, "Pr");
    }
    if (material->maps[MAP_PR].path != NULL || isnan(material->exponent) || !is_given(material->specular) ||
        is_black(material->specular)) {
        return 1.0f;
    }
    float exponent = material->exponent > 0.0f ? material->exponent : 0.0f;
    return sqrtf(sqrtf(2.0f / (exponent + 2.0f))); // GGX: alpha is the square of the roughness
}

// What is not given stays as it is. An index of 1 is what programs write that know none: it would take all gloss away.
static void set_layers(const mtl_reader *reader, clast_material_desc *desc)
{
    static const float fuzz_roughness = 0.5f, turn = 6.28318531f;
    const mtl_material *material = &reader->material;
    desc->ior = material->ior > 1.0f ? material->ior : desc->ior;
    if (!isnan(material->sheen)) {
        float sheen = unit(reader, material->sheen, "Ps");
        desc->sheen_colour[0] = desc->sheen_colour[1] = desc->sheen_colour[2] = sheen;
        desc->sheen_roughness = fuzz_roughness;
    }
    desc->clearcoat = !isnan(material->clearcoat) ? unit(reader, material->clearcoat, "Pc") : desc->clearcoat;
    desc->clearcoat_roughness = !isnan(material->clearcoat_roughness)
                                    ? unit(reader, material->clearcoat_roughness, "Pcr")
                                    : desc->clearcoat_roughness;
    desc->anisotropy = !isnan(material->anisotropy) ? unit(reader, material->anisotropy, "aniso") : desc->anisotropy;
    desc->anisotropy_rotation = !isnan(material->rotation) ? fmodf(material->rotation, 1.0f) * turn
                                                           : desc->anisotropy_rotation;
}

static void set_surface(const mtl_reader *reader, clast_material_desc *desc)
{
    const mtl_material *material = &reader->material;
    bool metal_by_colour = isnan(material->metalness) && material->maps[MAP_PM].path == NULL &&
                           material->maps[MAP_KD].path == NULL && is_given(material->diffuse) &&
                           is_black(material->diffuse) && is_given(material->specular) && !is_black(material->specular);
    const float *colour = metal_by_colour ? material->specular : material->diffuse;
    bool white = material->maps[MAP_KD].path != NULL && (!is_given(colour) || is_black(colour));
    for (int c = 0; c < 3; c++) {
        desc->base_colour[c] = white              ? 1.0f
                               : is_given(colour) ? unit(reader, colour[c], "a colour")
                                                  : desc->base_colour[c];
        bool glows = is_given(material->emission) && material->emission[c] > 0.0f;
        desc->emissive[c] = glows ? material->emission[c] : 0.0f;
    }
    if (material->maps[MAP_KE].path != NULL && is_black(desc->emissive)) {
        desc->emissive[0] = desc->emissive[1] = desc->emissive[2] = 1.0f;
    }
    bool metal_by_map = material->maps[MAP_PM].path != NULL;
    desc->metallic = !isnan(material->metalness)       ? unit(reader, material->metalness, "Pm")
                     : metal_by_colour || metal_by_map ? 1.0f
                                                       : 0.0f;
    desc->roughness = roughness_of(reader);
    desc->base_colour[3] = !isnan(material->opacity) ? unit(reader, material->opacity, "d") : 1.0f;
    desc->alpha_mode = desc->base_colour[3] < 1.0f || material->maps[MAP_D].path != NULL ? CLAST_ALPHA_BLEND
                                                                                         : CLAST_ALPHA_OPAQUE;
    desc->double_sided = true; // OBJ surfaces have no back
    set_layers(reader, desc);
}

static clast_status set_textures(const mtl_reader *reader, clast_material_desc *desc)
{
    clast_mtl *library = reader->library;
    const clast_mtl_map *maps = reader->material.maps;
    const clast_mtl_map *normals = &maps[maps[MAP_NORM].path != NULL ? MAP_NORM : MAP_BUMP];
    bool is_bump = maps[MAP_DISP].path == NULL && maps[MAP_BUMP].has_range;
    const clast_mtl_map *heights = &maps[is_bump ? MAP_BUMP : MAP_DISP];
    clast_status status = clast_mtl_texture(library, CLAST_MTL_COLOUR, &maps[MAP_KD], &maps[MAP_D],
                                            &desc->base_colour_texture);
    if (status == CLAST_OK) {
        status = clast_mtl_texture(library, CLAST_MTL_COLOUR, &maps[MAP_KE], NULL, &desc->emissive_texture);
    }
    if (status == CLAST_OK) {
        status = clast_mtl_texture(library, CLAST_MTL_ROUGHNESS_METAL, &maps[MAP_PR], &maps[MAP_PM],
                                   &desc->metallic_roughness_texture);
    }
    if (status == CLAST_OK) {
        status = clast_mtl_texture(library, maps[MAP_NORM].path != NULL ? CLAST_MTL_NORMALS : CLAST_MTL_BUMPS, normals,
                                   NULL, &desc->normal_texture);
        desc->normal_scale = normals->path != NULL ? normals->multiplier : 1.0f;
    }
    if (status == CLAST_OK && heights->path != NULL) {
        status = clast_mtl_texture(library, is_bump ? CLAST_MTL_BUMP_HEIGHTS : CLAST_MTL_HEIGHTS, heights, NULL,
                                   &desc->displacement_texture);
        desc->displacement_scale = heights->gain * heights->multiplier;
        desc->displacement_offset = heights->base * heights->multiplier;
    }
    return status;
}

// Adds the material at hand to the scene, if one was begun. Of two with one name the later counts.
static clast_status end_material(mtl_reader *reader)
{
    clast_mtl *library = reader->library;
    mtl_material *material = &reader->material;
    if (material->name == NULL) {
        return CLAST_OK;
    }
    clast_material_desc desc = clast_material_defaults();
    set_surface(reader, &desc);
    clast_status status = set_textures(reader, &desc);
    uint32_t number = 0;
    if (status == CLAST_OK) {
        status = clast_scene_add_material(library->scene, &desc, material->name, &number);
    }
    if (status == CLAST_OK) {
        status = clast_table_reserve(reader->context, &library->entry_table);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(reader->context, library->entries, library->entry_capacity, library->entry_count + 1);
    }
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t hash = clast_hash_text(material->name, strlen(material->name));
    size_t place = hash;
    uint32_t entry;
    while ((entry = clast_table_next(&library->entry_table, hash, &place)) != CLAST_NONE) {
        if (strcmp(library->entries[entry].name, material->name) == 0) {
            library->entries[entry].number = number;
            return CLAST_OK;
        }
    }
    clast_table_insert(&library->entry_table, hash, place, (uint32_t)library->entry_count);
    library->entries[library->entry_count++] = (clast_mtl_entry){material->name, number};
    material->name = NULL;
    return CLAST_OK;
}

// -----------------------------------------------------------------------------------------------------------
// statements

static bool read_number(mtl_reader *reader, float *value)
{
    double read;
    if (!clast_next_number(&reader->text, &read) || !isfinite((float)read)) {
        return false;
    }
    *value = (float)read;
    return true;
}

static clast_status read_scalar(mtl_reader *reader, float *value)
{
    return read_number(reader, value) ? CLAST_OK : malformed(reader, "a finite number");
}

// r g b, or one number for all three. Spectra and CIE colours are passed over, with a warning.
static clast_status read_colour(mtl_reader *reader, float colour[3])
{
    clast_text before = reader->text;
    clast_word word = clast_next_word(&reader->text);
    if (clast_word_is(word, "spectral") || clast_word_is(word, "xyz")) {
        clast_log(reader->context, CLAST_LOG_WARNING, "%s, line %llu: a colour by %s is not read", reader->path,
                  (unsigned long long)reader->text.line, clast_word_is(word, "xyz") ? "xyz" : "a spectrum");
        return CLAST_OK;
    }
    reader->text = before;
    if (!read_number(reader, &colour[0])) {
        return malformed(reader, "1 or 3 finite numbers");
    }
    colour[1] = colour[2] = colour[0];
    if (!clast_line_is_over(&reader->text) && (!read_number(reader, &colour[1]) || !read_number(reader, &colour[2]))) {
        return malformed(reader, "1 or 3 finite numbers");
    }
    return CLAST_OK;
}

// Up to three numbers after an option; gives how many there were.
static uint32_t read_vector(mtl_reader *reader, float values[3])
{
    uint32_t count = 0;
    clast_text before = reader->text;
    while (count < 3 && read_number(reader, &values[count])) {
        before = reader->text;
        count++;
    }
    reader->text = before;
    return count;
}

// An option of a map and what follows it; false where the word is none.
static bool read_option(mtl_reader *reader, clast_word option, clast_mtl_map *map)
{
    static const char *const with_word[] = {"-blendu", "-blendv", "-cc", "-imfchan", "-type", "-colorspace", "-texres"};
    float values[3] = {0.0f, 0.0f, 0.0f};
    if (clast_word_is(option, "-bm")) {
        return read_number(reader, &map->multiplier);
    }
    if (clast_word_is(option, "-clamp")) {
        map->clamp = clast_word_is(clast_next_word(&reader->text), "on");
        return true;
    }
    if (clast_word_is(option, "-o") || clast_word_is(option, "-s")) {
        uint32_t count = read_vector(reader, values);
        float *to = clast_word_is(option, "-o") ? map->offset : map->scale;
        to[0] = count > 0 ? values[0] : to[0];
        to[1] = count > 1 ? values[1] : to[1];
        return count > 0;
    }
    if (clast_word_is(option, "-mm")) {
        map->has_range = read_vector(reader, values) >= 2;
        map->base = map->has_range ? values[0] : map->base;
        map->gain = map->has_range ? values[1] : map->gain;
        return map->has_range;
    }
    if (clast_word_is(option, "-t") || clast_word_is(option, "-boost")) {
        return read_vector(reader, values) > 0;
    }
    for (size_t i = 0; i < sizeof with_word / sizeof with_word[0]; i++) {
        if (clast_word_is(option, with_word[i])) {
            return clast_next_word(&reader->text).length > 0;
        }
    }
    return false;
}

// Options may stand before the file's name and after it; the name may have blanks in it.
static clast_status read_map(mtl_reader *reader, clast_mtl_map *map)
{
    clast_free(reader->context, map->path);
    *map = (clast_mtl_map){.scale = {1.0f, 1.0f}, .multiplier = 1.0f, .gain = 1.0f};
    clast_word name = {NULL, 0};
    while (!clast_line_is_over(&reader->text) ||
           (name.begin != NULL && reader->text.at < reader->text.end && *reader->text.at == '#')) {
        clast_word word = clast_next_word(&reader->text);
        clast_text before = reader->text;
        if (word.begin[0] == '-' && read_option(reader, word, map)) {
            continue;
        }
        reader->text = before;
        name.begin = name.begin == NULL ? word.begin : name.begin;
        name.length = (size_t)(word.begin + word.length - name.begin);
    }
    if (name.length == 0) {
        return malformed(reader, "an image's file name");
    }
    char *relative = copy_word(reader->context, name);
    if (relative == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (char *c = relative; *c != '\0'; c++) {
        *c = *c == '\\' ? '/' : *c; // as other systems part folders
    }
    map->path = clast_path_beside(reader->context, reader->path, relative);
    clast_free(reader->context, relative);
    return map->path != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static clast_status read_name(mtl_reader *reader)
{
    clast_word name = clast_rest_of_line(&reader->text);
    clast_status status = end_material(reader);
    if (status != CLAST_OK) {
        return status;
    }
    begin_material(reader);
    if (name.length == 0) {
        return malformed(reader, "newmtl with a name");
    }
    reader->material.name = copy_word(reader->context, name);
    return reader->material.name != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static clast_status read_line(mtl_reader *reader)
{
    static const struct {
        const char *keyword;
        mtl_slot slot;
    } maps[] = {
        {"map_Kd", MAP_KD},   {"map_Ke", MAP_KE},     {"map_d", MAP_D},       {"map_Pr", MAP_PR},
        {"map_Pm", MAP_PM},   {"map_Bump", MAP_BUMP}, {"bump", MAP_BUMP},     {"norm", MAP_NORM},
        {"map_Kn", MAP_NORM}, {"disp", MAP_DISP},     {"map_disp", MAP_DISP},
    };
    if (clast_line_is_over(&reader->text)) {
        return CLAST_OK;
    }
    mtl_material *material = &reader->material;
    clast_word keyword = clast_next_word(&reader->text);
    if (clast_word_is(keyword, "newmtl")) {
        return read_name(reader);
    }
    if (material->name == NULL) {
        return CLAST_OK; // there is nothing yet that it could describe
    }
    if (clast_word_is(keyword, "Kd")) {
        return read_colour(reader, material->diffuse);
    }
    if (clast_word_is(keyword, "Ks")) {
        return read_colour(reader, material->specular);
    }
    if (clast_word_is(keyword, "Ke")) {
        return read_colour(reader, material->emission);
    }
    const struct {
        const char *keyword;
        float *value;
    } scalars[] = {
        {"Ns", &material->exponent},
        {"Pr", &material->roughness},
        {"Pm", &material->metalness},
        {"Ni", &material->ior},
        {"Ps", &material->sheen},
        {"Pc", &material->clearcoat},
        {"Pcr", &material->clearcoat_roughness},
        {"aniso", &material->anisotropy},
        {"anisor", &material->rotation},
    };
    for (size_t i = 0; i < sizeof scalars / sizeof scalars[0]; i++) {
        if (clast_word_is(keyword, scalars[i].keyword)) {
            return read_scalar(reader, scalars[i].value);
        }
    }
    if (clast_word_is(keyword, "d")) {
        clast_text before = reader->text;
        if (!clast_word_is(clast_next_word(&reader->text), "-halo")) {
            reader->text = before;
        }
        return read_scalar(reader, &material->opacity);
    }
    if (clast_word_is(keyword, "Tr")) {
        float transparency = 0.0f;
        clast_status status = read_scalar(reader, &transparency);
        material->opacity = isnan(material->opacity) ? 1.0f - transparency
                                                     : material->opacity; // d wins: some write both alike
        return status;
    }
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; i++) {
        if (clast_word_resembles(keyword, maps[i].keyword)) {
            return read_map(reader, &material->maps[maps[i].slot]);
        }
    }
    return CLAST_OK;
}

clast_status clast_mtl_load(clast_mtl *library, const char *path)
{
    clast_context *context = library->scene->context;
    clast_file_view file;
    clast_status status = clast_file_map(context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    mtl_reader reader = {.library = library, .context = context, .path = path};
    reader.text = clast_text_of((clast_bytes){file.data, file.size});
    begin_material(&reader);
    while (status == CLAST_OK && reader.text.at < reader.text.end) {
        status = read_line(&reader);
        clast_next_line(&reader.text);
    }
    if (status == CLAST_OK) {
        status = end_material(&reader);
    }
    begin_material(&reader); // frees what is left
    clast_file_unmap(context, &file);
    return status;
}

uint32_t clast_mtl_find(const clast_mtl *library, const char *name)
{
    uint32_t hash = clast_hash_text(name, strlen(name));
    size_t place = hash;
    uint32_t entry;
    while ((entry = clast_table_next(&library->entry_table, hash, &place)) != CLAST_NONE) {
        if (strcmp(library->entries[entry].name, name) == 0) {
            return library->entries[entry].number;
        }
    }
    return CLAST_NONE;
}

static void entries_free(clast_context *context, clast_mtl_entry *entries, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        clast_free(context, entries[i].name);
    }
    clast_free(context, entries);
}

void clast_mtl_free(clast_mtl *library)
{
    clast_context *context = library->scene->context;
    entries_free(context, library->entries, library->entry_count);
    entries_free(context, library->textures, library->texture_count);
    clast_table_free(context, &library->entry_table);
    clast_table_free(context, &library->texture_table);
}
