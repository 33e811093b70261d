// SPDX-License-Identifier: Apache-2.0
#include "render/levels.h"

#include <string.h>

#include "base/thread.h"
#include "render/texture.h"
#include "shared/device_materials.h"

enum {
    ROW_GRAIN = 4,
    CODES = 256,     // of a channel of 8 bits
    GUESSES = 4096,  // of the table that finds them
    TEXELS_MOST = 3, // that a texel of the next level takes from a row
};

// Light to the nearest of 256 codes of a display: a first guess, and the light from which on the next code is nearer.
typedef struct code_table {
    uint8_t guesses[GUESSES + 1];
    float limits[CODES];
} code_table;

// A level in the making.
typedef struct level_job {
    const clast_image *image; // the level before, where that has no sums
    const vec4 *before;       // else: as it was before it was rounded
    clast_encoding encoding;
    const clast_srgb_table *colours;
    const code_table *codes;
    uint32_t width_before, height_before, width, height;
    vec4 *sums;
    vec4 *rows; // of the level before, one for each worker
    clast_image made;
} level_job;

static size_t element_bytes(clast_pixel_type type)
{
    return type == CLAST_PIXEL_UNORM8 ? 1 : type == CLAST_PIXEL_UNORM16 ? 2 : 4;
}

// -------------------------------------------------------------------------------------------------------------- reading

// What is no number, or endless, would spread over all levels.
static vec4 sound_texel(vec4 texel)
{
    for (int c = 0; c < 4; c++) {
        texel[c] = is_finite1(texel[c]) ? texel[c] : 0.0f;
    }
    return texel;
}

static void read_row(const level_job *job, uint32_t y, vec4 *row)
{
    if (job->before != NULL) {
        memcpy(row, job->before + (size_t)y * job->width_before, job->width_before * sizeof *row);
        return;
    }
    for (uint32_t x = 0; x < job->width_before; x++) {
        vec4 texel = sound_texel(clast_image_texel(job->image, x, y, job->encoding, job->colours));
        row[x] = job->encoding == CLAST_ENCODING_NORMAL ? normal_vector(texel, 0) : texel;
    }
}

// ------------------------------------------------------------------------------------------------------------- averages

// Texels of a line of `before` that make texel i of one of `after`, and how much each counts: all that lies in the i-th of
// `after` equal parts.
typedef struct line_part {
    uint32_t first, count;
    float weights[TEXELS_MOST];
} line_part;

static line_part part_of(uint32_t before, uint32_t after, uint32_t i)
{
    line_part part = {.first = 2 * i, .count = 2, .weights = {0.5f, 0.5f, 0.0f}};
    if (before == 1) {
        part = (line_part){.first = 0, .count = 1, .weights = {1.0f, 0.0f, 0.0f}};
    } else if (before != 2 * after) { // odd: 2 after + 1
        float whole = 1.0f / (float)before;
        part.count = 3;
        part.weights[0] = (float)(after - i) * whole;
        part.weights[1] = (float)after * whole;
        part.weights[2] = (float)(i + 1) * whole;
    }
    return part;
}

// A mean under way. Colours that count by their alpha have two: where nothing is there, all count alike.
typedef struct level_sum {
    vec4 plain, covered;
    vec4 least, largest;
} level_sum;

static vec4 least4(vec4 a, vec4 b)
{
    return vec4(min1(a[0], b[0]), min1(a[1], b[1]), min1(a[2], b[2]), min1(a[3], b[3]));
}

static vec4 largest4(vec4 a, vec4 b)
{
    return vec4(max1(a[0], b[0]), max1(a[1], b[1]), max1(a[2], b[2]), max1(a[3], b[3]));
}

static void add_texel(level_sum *sum, vec4 texel, float weight)
{
    sum->plain = sum->plain + texel * weight;
    sum->covered = sum->covered + texel * (weight * texel[3]);
    sum->least = least4(sum->least, texel);
    sum->largest = largest4(sum->largest, texel);
}

// No mean lies outside of what it is of, whatever rounding says: what is equal stays so.
static vec4 mean_of(const level_sum *sum, clast_encoding encoding)
{
    vec4 mean = sum->plain;
    if (encoding == CLAST_ENCODING_CUTOUT && sum->plain[3] > 0.0f) {
        float scale = 1.0f / sum->plain[3];
        mean = vec4(sum->covered[0] * scale, sum->covered[1] * scale, sum->covered[2] * scale, sum->plain[3]);
    }
    return least4(largest4(mean, sum->least), sum->largest);
}

// -------------------------------------------------------------------------------------------------------------- writing

static void fill_codes(code_table *codes, const clast_srgb_table *colours)
{
    for (uint32_t i = 0; i < CODES; i++) {
        codes->limits[i] = i + 1 < CODES ? srgb_to_linear(((float)i + 0.5f) / 255.0f) : INFINITY;
    }
    uint32_t code = 0;
    for (uint32_t i = 0; i <= GUESSES; i++) {
        while (code + 1 < CODES && colours->linear[code + 1] <= (float)i / GUESSES) {
            code++;
        }
        codes->guesses[i] = (uint8_t)code;
    }
}

static uint8_t code_of(const code_table *codes, float light)
{
    float within = clamp1(light, 0.0f, 1.0f);
    uint32_t code = codes->guesses[(uint32_t)(within * GUESSES)];
    while (within >= codes->limits[code]) {
        code++;
    }
    return (uint8_t)code;
}

static uint32_t rounded(float value, float most)
{
    return (uint32_t)(clamp1(value, 0.0f, 1.0f) * most + 0.5f);
}

static void write_texel(const level_job *job, size_t place, vec4 texel)
{
    const clast_image *made = &job->made;
    size_t first = place * made->channels;
    for (uint32_t c = 0; c < made->channels; c++) {
        bool is_alpha = (made->channels == 2 && c == 1) || c == 3;
        float value = texel[made->channels == 2 && c == 1 ? 3 : c];
        bool is_srgb = encoding_is_srgb(job->encoding) && !is_alpha;
        switch (made->type) {
        case CLAST_PIXEL_UNORM8:
            ((uint8_t *)made->pixels)[first + c] = is_srgb ? code_of(job->codes, value)
                                                           : (uint8_t)rounded(value, 255.0f);
            break;
        case CLAST_PIXEL_UNORM16:
            value = is_srgb ? linear_to_srgb(value) : value;
            ((uint16_t *)made->pixels)[first + c] = (uint16_t)rounded(value, 65535.0f);
            break;
        case CLAST_PIXEL_FLOAT: ((float *)made->pixels)[first + c] = value; break;
        }
    }
}

// --------------------------------------------------------------------------------------------------------------- levels

// `rows` are those of the level before that count.
static void make_row(const level_job *job, uint32_t y, const vec4 *rows)
{
    line_part down = part_of(job->height_before, job->height, y);
    vec4 *sums = job->sums + (size_t)y * job->width;
    for (uint32_t x = 0; x < job->width; x++) {
        line_part across = part_of(job->width_before, job->width, x);
        level_sum sum = {.least = vec4(INFINITY, INFINITY, INFINITY, INFINITY),
                         .largest = vec4(-INFINITY, -INFINITY, -INFINITY, -INFINITY)};
        for (uint32_t j = 0; j < down.count; j++) {
            const vec4 *line = rows + (size_t)j * job->width_before;
            for (uint32_t i = 0; i < across.count; i++) {
                add_texel(&sum, line[across.first + i], down.weights[j] * across.weights[i]);
            }
        }
        sums[x] = mean_of(&sum, job->encoding);
        vec4 texel = job->encoding == CLAST_ENCODING_NORMAL ? sums[x] * 0.5f + 0.5f : sums[x];
        write_texel(job, (size_t)y * job->width + x, texel);
    }
}

static void make_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    const level_job *job = data;
    vec4 *rows = job->rows + (size_t)worker * TEXELS_MOST * job->width_before;
    for (size_t y = begin; y < end; y++) {
        line_part down = part_of(job->height_before, job->height, (uint32_t)y);
        for (uint32_t j = 0; j < down.count; j++) {
            read_row(job, down.first + j, rows + (size_t)j * job->width_before);
        }
        make_row(job, (uint32_t)y, rows);
    }
}

// A chain of levels in the making: what it is made of, and the sums of the last two levels.
typedef struct chain {
    clast_context *context;
    const clast_scene_image *from;
    clast_encoding encoding;
    const clast_srgb_table *colours;
    const code_table *codes;
    clast_image_levels levels;
    vec4 *sums[2];
    vec4 *rows;
} chain;

static clast_status begin_chain(chain *chain)
{
    const clast_image *image = &chain->from->image;
    bool is_normal = chain->encoding == CLAST_ENCODING_NORMAL;
    clast_status status = clast_levels_create(chain->context, image, is_normal ? 3 : image->channels,
                                              is_normal ? CLAST_PIXEL_UNORM16 : image->type, CLAST_LEVELS_MOST,
                                              &chain->levels);
    if (status != CLAST_OK) {
        return status;
    }
    size_t first = (size_t)clast_level_side(image->width, 1) * clast_level_side(image->height, 1);
    size_t second = (size_t)clast_level_side(image->width, 2) * clast_level_side(image->height, 2);
    chain->sums[0] = clast_allocate(chain->context, first, sizeof *chain->sums[0]);
    chain->sums[1] = clast_allocate(chain->context, second, sizeof *chain->sums[1]);
    chain->rows = clast_allocate(
        chain->context, (size_t)clast_worker_count(chain->context) * TEXELS_MOST * image->width, sizeof *chain->rows);
    bool all = chain->sums[0] != NULL && chain->sums[1] != NULL && chain->rows != NULL;
    return all ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// Levels of the file's own, where what they mean is known; gives how many.
static uint32_t take_stored(const chain *chain)
{
    const clast_image_levels *stored = &chain->from->stored, *made = &chain->levels;
    if (chain->encoding == CLAST_ENCODING_NORMAL) {
        return 0;
    }
    uint32_t count = min_uint(stored->count, made->count);
    for (uint32_t level = 1; level <= count; level++) {
        clast_image from = clast_level_image(&chain->from->image, stored, level);
        size_t bytes = (size_t)from.width * from.height * from.channels * element_bytes(from.type);
        memcpy((char *)made->pixels + made->offsets[level - 1], from.pixels, bytes);
    }
    return count;
}

static void make_level(chain *chain, uint32_t level, bool has_sums)
{
    const clast_image *finest = &chain->from->image;
    clast_image before = *finest;
    if (level > 1) {
        before = clast_level_image(finest, &chain->levels, level - 1);
    }
    clast_image made = clast_level_image(finest, &chain->levels, level);
    level_job job = {.image = &before,
                     .before = has_sums ? chain->sums[level & 1] : NULL,
                     .encoding = chain->encoding,
                     .colours = chain->colours,
                     .codes = chain->codes,
                     .width_before = before.width,
                     .height_before = before.height,
                     .width = made.width,
                     .height = made.height,
                     .sums = chain->sums[(level - 1) & 1],
                     .rows = chain->rows,
                     .made = made};
    clast_parallel_for(chain->context, made.height, ROW_GRAIN, make_rows, &job);
}

static clast_status make_chain(clast_context *context, clast_scene_image *image, clast_encoding encoding,
                               const clast_srgb_table *colours, const code_table *codes)
{
    chain chain = {.context = context, .from = image, .encoding = encoding, .colours = colours, .codes = codes};
    clast_status status = begin_chain(&chain);
    if (status == CLAST_OK) {
        uint32_t first = take_stored(&chain) + 1;
        for (uint32_t level = first; level <= chain.levels.count; level++) {
            make_level(&chain, level, level > first);
        }
        image->levels[encoding] = chain.levels;
    } else {
        clast_free(context, chain.levels.pixels);
    }
    clast_free(context, chain.sums[0]);
    clast_free(context, chain.sums[1]);
    clast_free(context, chain.rows);
    return status;
}

// --------------------------------------------------------------------------------------------------------------- scenes

clast_encoding clast_levels_encoding(const clast_image *image, clast_encoding encoding)
{
    bool has_alpha = image->channels == 2 || image->channels == 4;
    return encoding == CLAST_ENCODING_CUTOUT && !has_alpha ? CLAST_ENCODING_SRGB : encoding;
}

// The image that a use reads and that lacks levels; null where there is none.
static clast_scene_image *lacking(clast_scene *scene, const clast_texture_use *use, clast_encoding *encoding)
{
    if (use->texture >= scene->texture_count || scene->textures[use->texture].image >= scene->image_count) {
        return NULL;
    }
    clast_scene_image *image = &scene->images[scene->textures[use->texture].image];
    *encoding = clast_levels_encoding(&image->image, *encoding);
    bool has_levels = clast_level_count(image->image.width, image->image.height) != 0;
    return has_levels && image->levels[*encoding].pixels == NULL ? image : NULL;
}

typedef struct level_tables {
    clast_srgb_table colours;
    code_table codes;
} level_tables;

static clast_status make_for_use(clast_scene *scene, const level_tables *tables, const clast_texture_use *use,
                                 clast_encoding encoding)
{
    clast_scene_image *image = lacking(scene, use, &encoding);
    return image != NULL ? make_chain(scene->context, image, encoding, &tables->colours, &tables->codes) : CLAST_OK;
}

static clast_status make_for_material(clast_scene *scene, const level_tables *tables, const clast_material *material)
{
    clast_status status = CLAST_OK;
#define MAKE_LEVELS(name, slot, member, encoding) \
    status = status != CLAST_OK ? status \
                                : make_for_use(scene, tables, &material->member, \
                                               (clast_encoding)slot_encoding(slot, encoding, material->alpha_mode));
    CLAST_TEXTURE_SLOT_LIST(MAKE_LEVELS)
#undef MAKE_LEVELS
    return status;
}

clast_status clast_make_levels(clast_scene *scene)
{
    if (scene->has_levels && scene->levels_version == scene->material_version) {
        return CLAST_OK;
    }
    clast_context *context = scene->context;
    level_tables *tables = clast_allocate(context, 1, sizeof *tables);
    if (tables == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_srgb_table_fill(&tables->colours);
    fill_codes(&tables->codes, &tables->colours);
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < scene->material_count && status == CLAST_OK; i++) {
        status = make_for_material(scene, tables, &scene->materials[i].record);
        if (status == CLAST_OK && scene->image_count != 0) {
            status = clast_progress(context, "levels", i + 1, scene->material_count);
        }
    }
    clast_free(context, tables);
    scene->has_levels = status == CLAST_OK;
    scene->levels_version = scene->material_version;
    return status;
}

uint64_t clast_level_bytes(const clast_scene *scene)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < scene->image_count; i++) {
        bytes += scene->images[i].stored.bytes;
        for (uint32_t encoding = 0; encoding < ENCODINGS; encoding++) {
            bytes += scene->images[i].levels[encoding].bytes;
        }
    }
    return bytes;
}
