// SPDX-License-Identifier: Apache-2.0
// Textures and materials on a device against those of the processor.
#include <math.h>

#include "render/levels.h"
#include "render/scatter.h"
#include "render/texture.h"
#include "shared/random.h"
#include "test.h"
#include "vulkan/materials.h"
#include "vulkan/test_device.h"

static test_device device;

static uint32_t draws;

static float draw(void)
{
    return unit_float(hash1(draws++));
}

static float draw_between(float low, float high)
{
    return low + (high - low) * draw();
}

// What the probes of shaders/probe/ are handed.
typedef struct probe_push {
    uint64_t materials, questions, answers;
    uint32_t count;
} probe_push;

static void ask(clast_shader shader, const clast_scene *scene, const void *questions, size_t question_size,
                void *answers, size_t answer_size, uint32_t count)
{
    clast_gpu_materials materials = {.gpu = device.gpu, .pictures = {.gpu = device.gpu}};
    clast_gpu_buffer asked, answered;
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, question_size * count, "questions", &asked));
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, answer_size * count, "answers", &answered));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, scene, CLAST_NONE));
    clast_gpu_write(commands, &asked, 0, questions, question_size * count);
    clast_gpu_barrier(commands);
    probe_push push = {materials.head.address, asked.address, answered.address, count};
    clast_gpu_run(
        commands,
        &(clast_gpu_call){.shader = shader, .push = &push, .push_bytes = sizeof push, .groups = (count + 63) / 64});
    clast_gpu_read(commands, &answered, 0, answers, answer_size * count);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &asked);
    clast_gpu_free(device.gpu, &answered);
    clast_gpu_materials_free(&materials);
}

// ----------------------------------------------------------------------------------------------------------- textures

enum { IMAGES = 14, TEXTURES = IMAGES * 18, MATERIALS = TEXTURES / TEXTURE_SLOTS + 1, TEXTURE_QUESTIONS = 40000 };

// Every type with every number of channels, and two of a size that is no power of two, or one.
static void add_images(clast_scene *scene)
{
    for (uint32_t i = 0; i < IMAGES; i++) {
        uint32_t width = i == 12 ? 1 : 13 + i, height = i == 12 ? 1 : i == 13 ? 3 : 7, number;
        clast_image image = {width, height, i % 4 + 1, (clast_pixel_type)(i / 4 % 3), NULL};
        size_t elements = (size_t)width * height * image.channels;
        float *values = malloc(elements * sizeof *values);
        assert_non_null(values);
        for (size_t k = 0; k < elements; k++) {
            uint32_t bits = hash2(i, (uint32_t)k);
            switch (image.type) {
            case CLAST_PIXEL_UNORM8: ((uint8_t *)values)[k] = (uint8_t)bits; break;
            case CLAST_PIXEL_UNORM16: ((uint16_t *)values)[k] = (uint16_t)bits; break;
            case CLAST_PIXEL_FLOAT: values[k] = 20.0f * unit_float(bits) - 2.0f; break;
            }
        }
        image.pixels = values;
        assert_ok(device.context, clast_scene_add_image(scene, &image, NULL, &number));
        free(values);
    }
}

static clast_texture_slot some_slot(uint32_t texture)
{
    clast_texture_slot slot = {.texture = texture, .coordinate_set = hash1(texture) & 1, .scale = {1.0f, 1.0f}};
    if (texture % 3 != 0) {
        slot.scale[0] = draw_between(-2.0f, 3.0f);
        slot.scale[1] = draw_between(-2.0f, 3.0f);
        slot.offset[0] = draw_between(-1.0f, 1.0f);
        slot.offset[1] = draw_between(-1.0f, 1.0f);
        slot.rotation = texture % 3 == 1 ? draw_between(-4.0f, 4.0f) : 0.0f;
    }
    return slot;
}

// Every image is read in every way by some slot of some material.
static clast_scene *textured_scene(void)
{
    clast_scene *scene;
    assert_ok(device.context, clast_scene_create(device.context, &scene));
    add_images(scene);
    uint32_t number;
    for (uint32_t i = 0; i < TEXTURES; i++) {
        clast_texture texture = {i / 18, (clast_wrap)(i % 3), (clast_wrap)(i / 3 % 3), (clast_filter)(i / 9 % 2)};
        assert_ok(device.context, clast_scene_add_texture(scene, &texture, &number));
    }
    for (uint32_t m = 0, next = 0; m < MATERIALS; m++) {
        clast_material_desc desc = clast_material_defaults();
#define SET_SLOT(name, slot, member, encoding) desc.member = next < TEXTURES ? some_slot(next) : desc.member, next++;
        CLAST_TEXTURE_SLOT_LIST(SET_SLOT)
        assert_ok(device.context, clast_scene_add_material(scene, &desc, NULL, &number));
    }
    return scene;
}

typedef struct texture_question {
    uint32_t material, slot, encoding, look;
    packed2 coordinates[2];
    clast_footprint footprints[2];
} texture_question;

typedef struct texture_answer {
    packed4 value;
    float alpha;
} texture_answer;

static clast_texture_use use_of(const clast_scene *scene, const texture_question *question)
{
    const clast_material *record = &scene->materials[question->material].record;
    switch (question->slot) {
#define USE_OF(name, slot, member, encoding) \
    case slot: return record->member;
        CLAST_TEXTURE_SLOT_LIST(USE_OF)
    }
    fail();
    return record->base_colour_texture;
}

static void make_questions(texture_question *questions)
{
    for (uint32_t i = 0; i < TEXTURE_QUESTIONS; i++) {
        questions[i].material = i % (MATERIALS + 1); // the scene's first has none
        questions[i].slot = i / (MATERIALS + 1) % TEXTURE_SLOTS;
        questions[i].encoding = hash1(i) & 1;
        float reach = i % 5 == 0 ? 1000.0f : 3.0f;
        for (uint32_t set = 0; set < 2; set++) {
            float u = draw_between(-reach, reach), v = draw_between(-reach, reach);
            questions[i].coordinates[set] = i % 7 == 0 ? (packed2){{floorf(u), floorf(v) * 0.5f}} : (packed2){{u, v}};
        }
    }
}

// What a sample sees of textures, from less than a texel to more than there are.
static void add_footprints(const clast_scene *scene, texture_question *questions)
{
    static const uint32_t encodings[TEXTURE_SLOTS] = {
#define ENCODING_OF(name, slot, member, encoding) [slot] = encoding,
        CLAST_TEXTURE_SLOT_LIST(ENCODING_OF)};
    for (uint32_t i = 0; i < TEXTURE_QUESTIONS; i++) {
        const clast_material *material = &scene->materials[questions[i].material].record;
        questions[i].encoding = slot_encoding(questions[i].slot, encodings[questions[i].slot], material->alpha_mode);
        questions[i].look = i % 3;
        for (uint32_t set = 0; set < 2; set++) {
            float size = exp2f(draw_between(-8.0f, 2.0f));
            for (int c = 0; c < 2; c++) {
                questions[i].footprints[set].first.v[c] = draw_between(-size, size);
                questions[i].footprints[set].second.v[c] = draw_between(-size, size) * draw();
            }
        }
    }
}

static vec4 expected_value(const clast_scene *scene, const clast_srgb_table *table, const texture_question *question)
{
    clast_texture_area area = {
        .coordinates = {load2(question->coordinates[0]), load2(question->coordinates[1])},
        .footprints = {question->footprints[0], question->footprints[1]},
        .look = question->look,
    };
    return clast_texture_value(scene, use_of(scene, question), &area, (clast_encoding)question->encoding, table,
                               vec4(-1.0f, -2.0f, -3.0f, -4.0f));
}

static void textures_have_the_values_of_the_processor(void **state)
{
    (void)state;
    clast_scene *scene = textured_scene();
    texture_question *questions = calloc(TEXTURE_QUESTIONS, sizeof *questions);
    texture_answer *answers = calloc(TEXTURE_QUESTIONS, sizeof *answers);
    assert_non_null(questions);
    assert_non_null(answers);
    make_questions(questions);
    ask(CLAST_SHADER_PROBE_TEXTURE, scene, questions, sizeof *questions, answers, sizeof *answers, TEXTURE_QUESTIONS);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    uint32_t read = 0;
    for (uint32_t i = 0; i < TEXTURE_QUESTIONS; i++) {
        clast_texture_use use = use_of(scene, &questions[i]);
        vec2 coordinates[2] = {load2(questions[i].coordinates[0]), load2(questions[i].coordinates[1])};
        vec4 value = expected_value(scene, &table, &questions[i]);
        for (uint32_t c = 0; c < 4; c++) {
            if (answers[i].value.v[c] != value[c]) {
                fail_msg("question %u, channel %u: %.9g, not %.9g", i, c, (double)answers[i].value.v[c],
                         (double)value[c]);
            }
        }
        assert_true(answers[i].alpha == clast_texture_alpha(scene, use, coordinates));
        read += use.texture != CLAST_NONE;
    }
    assert_true(read > TEXTURE_QUESTIONS / 2);
    free(questions);
    free(answers);
    clast_scene_destroy(scene);
}

// Levels and points are found by roots, which differ in their last digits between machines; and where one more point begins,
// another may see it.
static void footprints_have_the_values_of_the_processor(void **state)
{
    (void)state;
    clast_scene *scene = textured_scene();
    assert_ok(device.context, clast_make_levels(scene));
    texture_question *questions = calloc(TEXTURE_QUESTIONS, sizeof *questions);
    texture_answer *answers = calloc(TEXTURE_QUESTIONS, sizeof *answers);
    assert_non_null(questions);
    assert_non_null(answers);
    make_questions(questions);
    add_footprints(scene, questions);
    ask(CLAST_SHADER_PROBE_TEXTURE, scene, questions, sizeof *questions, answers, sizeof *answers, TEXTURE_QUESTIONS);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    uint32_t different = 0;
    for (uint32_t i = 0; i < TEXTURE_QUESTIONS; i++) {
        vec4 value = expected_value(scene, &table, &questions[i]);
        float most = 0.0f;
        for (uint32_t c = 0; c < 4; c++) {
            most = max1(most, abs1(answers[i].value.v[c] - value[c]));
        }
        different += !(most < 2e-3f); // of values up to 18
    }
    if (different > TEXTURE_QUESTIONS / 5000) {
        fail_msg("%u of %d values differ", different, TEXTURE_QUESTIONS);
    }
    free(questions);
    free(answers);
    clast_scene_destroy(scene);
}

static void only_pictures_that_shading_reads_are_uploaded(void **state)
{
    (void)state;
    clast_scene *scene = textured_scene();
    clast_gpu_materials materials = {.gpu = device.gpu, .pictures = {.gpu = device.gpu}};
    uint32_t image, texture, number;
    const uint8_t pixel = 200;
    assert_ok(device.context,
              clast_scene_add_image(scene, &(clast_image){1, 1, 1, CLAST_PIXEL_UNORM8, &pixel}, "late", &image));
    assert_ok(device.context, clast_scene_add_texture(scene, &(clast_texture){.image = image}, &texture));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, scene, CLAST_NONE));
    assert_ok(device.context, clast_gpu_finish(commands));
    assert_int_equal(materials.pictures.count, IMAGES);
    uint64_t address = materials.head.address;

    clast_material_desc desc = clast_material_defaults();
    desc.occlusion_texture.texture = texture; // which path tracing does not read
    assert_ok(device.context, clast_scene_add_material(scene, &desc, NULL, &number));
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, scene, CLAST_NONE));
    assert_ok(device.context, clast_gpu_finish(commands));
    assert_int_equal(materials.pictures.count, IMAGES);

    desc.emissive_texture.texture = texture;
    assert_ok(device.context, clast_scene_set_material(scene, number, &desc));
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_materials_update(&materials, commands, scene, image));
    assert_ok(device.context, clast_gpu_finish(commands));
    assert_int_equal(materials.pictures.count, IMAGES + 1);
    assert_true(materials.surroundings.texture == materials.pictures.images[image].finest.texture);
    assert_true(materials.head.address == address);
    clast_gpu_materials_free(&materials);
    clast_scene_destroy(scene);
}

static void images_that_are_too_large_are_refused_by_name(void **state)
{
    (void)state;
    clast_scene *scene;
    assert_ok(device.context, clast_scene_create(device.context, &scene));
    static uint8_t row[65536];
    uint32_t number;
    assert_ok(device.context, clast_scene_add_image(scene, &(clast_image){65536, 1, 1, CLAST_PIXEL_UNORM8, row},
                                                    "a long row", &number));
    clast_gpu_pictures pictures = {.gpu = device.gpu};
    clast_gpu_commands *commands;
    clast_device_image image;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_status status = clast_gpu_pictures_need(&pictures, commands, scene, number, &image);
    if (status != CLAST_OK) { // a device that can hold it may
        assert_int_equal(status, CLAST_ERROR_LIMIT);
        assert_non_null(strstr(clast_context_error(device.context), "a long row"));
    }
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_pictures_free(&pictures);
    clast_scene_destroy(scene);
}

enum { COMPRESSED_WIDTH = 22, COMPRESSED_HEIGHT = 13, COMPRESSED_BLOCKS = 6 * 4 };

// A picture of random blocks. Its pixels, which tell something else, show which of both a device has read.
static uint32_t add_compressed(clast_scene *scene, clast_block_format format, uint32_t channels, size_t block)
{
    static const uint8_t pixels[4 * COMPRESSED_WIDTH * COMPRESSED_HEIGHT] = {0};
    uint32_t image, texture, number;
    clast_image desc = {COMPRESSED_WIDTH, COMPRESSED_HEIGHT, channels, CLAST_PIXEL_UNORM8, pixels};
    assert_ok(device.context, clast_scene_add_image(scene, &desc, NULL, &image));
    size_t bytes = COMPRESSED_BLOCKS * block;
    clast_image_blocks blocks = {format, clast_allocate(device.context, bytes, 1), bytes};
    assert_non_null(blocks.data);
    for (size_t i = 0; i < bytes; i++) {
        ((uint8_t *)blocks.data)[i] = (uint8_t)hash2(format, (uint32_t)i);
    }
    clast_scene_adopt_blocks(scene, image, &blocks);
    assert_ok(device.context, clast_scene_add_texture(
                                  scene, &(clast_texture){.image = image, .filter = CLAST_FILTER_NEAREST}, &texture));
    clast_material_desc material = clast_material_defaults();
    material.normal_texture = (clast_texture_slot){.texture = texture, .scale = {1.0f, 1.0f}};
    assert_ok(device.context, clast_scene_add_material(scene, &material, NULL, &number));
    return number;
}

static uint32_t expected_texel(const clast_scene *scene, uint32_t number, uint32_t kind, uint32_t x, uint32_t y)
{
    uint32_t words[4] = {0};
    size_t bytes = kind == BLOCK_BC1 || kind == BLOCK_BC4 ? 8 : 16;
    memcpy(words, (const uint8_t *)scene->images[number].blocks.data + (y / 4 * 6 + x / 4) * bytes, bytes);
    return block_texel(kind, words[0], words[1], words[2], words[3], y % 4 * 4 + x % 4);
}

static void compressed_pictures_are_read_from_their_blocks(void **state)
{
    (void)state;
    enum { TEXELS = COMPRESSED_WIDTH * COMPRESSED_HEIGHT, KINDS = 5, ALL = TEXELS * KINDS };
    static const struct {
        clast_block_format format;
        uint32_t channels, block;
    } kinds[KINDS] = {
        {CLAST_BLOCK_BC1, 4, 8}, {CLAST_BLOCK_BC2, 4, 16}, {CLAST_BLOCK_BC3, 4, 16},
        {CLAST_BLOCK_BC4, 1, 8}, {CLAST_BLOCK_BC5, 3, 16},
    };
    static texture_question questions[ALL];
    static texture_answer answers[ALL];
    clast_scene *scene;
    assert_ok(device.context, clast_scene_create(device.context, &scene));
    for (uint32_t k = 0; k < KINDS; k++) {
        uint32_t material = add_compressed(scene, kinds[k].format, kinds[k].channels, kinds[k].block);
        for (uint32_t i = 0; i < TEXELS; i++) {
            float u = ((float)(i % COMPRESSED_WIDTH) + 0.5f) / COMPRESSED_WIDTH,
                  v = ((float)(i / COMPRESSED_WIDTH) + 0.5f) / COMPRESSED_HEIGHT;
            questions[k * TEXELS + i] = (texture_question){
                .material = material, .slot = SLOT_NORMAL, .encoding = ENCODING_LINEAR, .coordinates = {{{u, v}}}};
        }
    }
    ask(CLAST_SHADER_PROBE_TEXTURE, scene, questions, sizeof *questions, answers, sizeof *answers, ALL);
    for (uint32_t i = 0; i < ALL; i++) {
        uint32_t k = i / TEXELS, x = i % TEXELS % COMPRESSED_WIDTH, y = i % TEXELS / COMPRESSED_WIDTH;
        uint32_t texel = expected_texel(scene, k, BLOCK_BC1 + k, x, y);
        for (uint32_t c = 0; c < 4; c++) {
            float expected = unorm8(texel >> 8 * (kinds[k].channels == 1 ? 0 : c) & 255);
            expected = c == 3 && kinds[k].channels != 4 ? 1.0f : expected;
            assert_true(answers[i].value.v[c] == expected);
        }
        assert_true(answers[i].alpha == answers[i].value.v[3]);
    }
    clast_scene_destroy(scene);
}

static void a_device_that_is_too_small_for_pictures_says_so(void **state)
{
    (void)state;
    enum { SIDE = 2048 };
    test_device small = test_device_open_as(
        &(clast_gpu_desc){.software = true, .hardware = true, .validate = true, .memory_limit = (uint64_t)12 << 20});
    clast_scene *scene;
    clast_texture_slot slot = {.scale = {1.0f, 1.0f}};
    uint8_t *pixels = calloc((size_t)SIDE * SIDE, 3);
    uint32_t image, number;
    assert_non_null(pixels);
    assert_ok(small.context, clast_scene_create(small.context, &scene));
    assert_ok(small.context, clast_scene_add_image(scene, &(clast_image){SIDE, SIDE, 3, CLAST_PIXEL_UNORM8, pixels},
                                                   "wallpaper", &image));
    free(pixels);
    assert_ok(small.context, clast_scene_add_texture(scene, &(clast_texture){.image = image}, &slot.texture));
    clast_material_desc desc = clast_material_defaults();
    desc.base_colour_texture = slot;
    assert_ok(small.context, clast_scene_add_material(scene, &desc, NULL, &number));
    clast_gpu_materials materials = {.gpu = small.gpu, .pictures = {.gpu = small.gpu}};
    for (int turn = 0; turn < 2; turn++) { // and says so again
        clast_gpu_commands *commands;
        assert_ok(small.context, clast_gpu_begin(small.gpu, &commands));
        assert_int_equal(clast_gpu_materials_update(&materials, commands, scene, CLAST_NONE),
                         CLAST_ERROR_OUT_OF_MEMORY);
        assert_non_null(strstr(clast_context_error(small.context), "wallpaper"));
        assert_ok(small.context, clast_gpu_finish(commands));
        clast_gpu_materials_free(&materials);
    }
    clast_scene_destroy(scene);
    assert_true(test_device_close(&small));
}

// ------------------------------------------------------------------------------------------------------------ scattering

enum { SCATTER_QUESTIONS = 20000 };

typedef struct scatter_question {
    uint32_t material;
    clast_bsdf_input surface;
    float alpha_floor;
    packed3 view, light;
    packed2 square;
    float lobe;
} scatter_question;

typedef struct scatter_answer {
    clast_bsdf bsdf;
    clast_brdf_answer value;
    clast_bsdf_sample direction;
} scatter_answer;

static clast_scene *glassy_scene(void)
{
    clast_scene *scene;
    uint32_t number;
    assert_ok(device.context, clast_scene_create(device.context, &scene));
    const float iors[] = {1.5f, 1.33f, 2.4f};
    for (uint32_t i = 0; i < 3; i++) {
        clast_material_desc desc = clast_material_defaults();
        desc.ior = iors[i];
        desc.dispersion = i == 1 ? 4.0f : 0.0f;
        desc.transmission = 1.0f;
        desc.thickness = 1.0f;
        desc.sheen_colour[0] = desc.sheen_colour[1] = 0.5f;
        assert_ok(device.context, clast_scene_add_material(scene, &desc, NULL, &number));
    }
    return scene;
}

static packed3 some_direction(float least)
{
    vec3 v = sample_cosine_hemisphere(vec2(draw(), draw()));
    return store3(normalize3(vec3(v[0], v[1], max1(v[2], least))));
}

static scatter_question some_question(uint32_t i)
{
    vec3 colour = vec3(draw(), draw(), draw());
    clast_bsdf_input surface = bsdf_input(brdf_input(colour, i % 3 == 0 ? draw() : 0.0f, draw_between(0.1f, 1.0f)));
    surface.base.anisotropy = i % 5 == 0 ? draw() : 0.0f;
    surface.base.specular = draw();
    if (i % 2 != 0) {
        surface.transmission = draw();
        surface.thin = i % 4 == 1;
        surface.inside = i % 8 == 3;
    }
    if (i % 7 < 3) {
        surface.clearcoat = draw();
        surface.clearcoat_roughness = draw_between(0.1f, 1.0f);
        surface.clearcoat_normal = some_direction(0.8f);
    }
    if (i % 11 < 4) {
        surface.sheen = store3(vec3(draw(), draw(), draw()));
        surface.sheen_roughness = draw_between(0.1f, 1.0f);
    }
    if (i % 9 < 3) {
        surface.base.film = draw();
        surface.base.film_ior = draw_between(1.0f, 2.0f);
        surface.base.film_thickness = draw_between(0.0f, 1000.0f);
    }
    if (i % 10 < 3) {
        surface.through = draw();
        surface.through_colour = store3(vec3(draw(), draw(), draw()));
    }
    scatter_question question = {.material = i % 4, .surface = surface, .view = some_direction(0.05f)};
    question.surface.base.ior = question.material == 0 ? 1.5f : question.material == 1 ? 1.5f : 1.33f;
    question.surface.colour = question.material == 2 ? i % 3 : 0;
    question.alpha_floor = i % 13 == 0 ? 0.25f : 0.0f;
    question.light = some_direction(0.02f);
    question.light.v[2] *= i % 3 == 1 ? -1.0f : 1.0f;
    question.square = (packed2){{draw(), draw()}};
    question.lobe = draw();
    return question;
}

static bool near_enough(const float *a, const float *b, size_t count, double tolerance)
{
    for (size_t i = 0; i < count; i++) {
        double size = fmax(fabs((double)b[i]), 1.0);
        if (!(fabs((double)a[i] - (double)b[i]) <= tolerance * size)) {
            return false;
        }
    }
    return true;
}

static scatter_answer answer_of(const clast_scatter_tables *tables, const scatter_question *question)
{
    vec3 view = load3(question->view);
    scatter_answer answer;
    answer.bsdf = clast_scatter_make(tables, question->material, &question->surface, question->alpha_floor, view);
    answer.value = bsdf_evaluate(answer.bsdf, view, load3(question->light));
    answer.direction = bsdf_direction(answer.bsdf, view, load2(question->square), question->lobe);
    return answer;
}

// Shading agrees to a tolerance; a number that chooses between lobes, or between both sides of glass, may fall on the other
// side of a border by a last digit.
static void surfaces_scatter_as_on_the_processor(void **state)
{
    (void)state;
    clast_scene *scene = glassy_scene();
    clast_scatter_tables *tables;
    assert_ok(device.context, clast_scatter_create(scene, &tables));
    scatter_question *questions = calloc(SCATTER_QUESTIONS, sizeof *questions);
    scatter_answer *answers = calloc(SCATTER_QUESTIONS, sizeof *answers);
    assert_non_null(questions);
    assert_non_null(answers);
    for (uint32_t i = 0; i < SCATTER_QUESTIONS; i++) {
        questions[i] = some_question(i);
    }
    ask(CLAST_SHADER_PROBE_SCATTER, scene, questions, sizeof *questions, answers, sizeof *answers, SCATTER_QUESTIONS);
    uint32_t makes = 0, values = 0, directions = 0;
    for (uint32_t i = 0; i < SCATTER_QUESTIONS; i++) {
        scatter_answer expected = answer_of(tables, &questions[i]);
        assert_int_equal(answers[i].bsdf.thin, expected.bsdf.thin);
        answers[i].bsdf.thin = expected.bsdf.thin = 0;
        makes += !near_enough((const float *)&answers[i].bsdf, (const float *)&expected.bsdf, sizeof(clast_bsdf) / 4,
                              1e-4);
        values += !near_enough(answers[i].value.value.v, expected.value.value.v, 3, 1e-3) ||
                  !near_enough(&answers[i].value.density, &expected.value.density, 1, 1e-3);
        directions += answers[i].direction.diffuse != expected.direction.diffuse ||
                      !near_enough(answers[i].direction.direction.v, expected.direction.direction.v, 3, 1e-3);
    }
    print_message("of %d surfaces, %u were made otherwise, %u had other values, %u other directions\n",
                  SCATTER_QUESTIONS, makes, values, directions);
    assert_int_equal(makes, 0);
    assert_true(values <= SCATTER_QUESTIONS / 1000);
    assert_true(directions <= SCATTER_QUESTIONS / 1000);
    free(questions);
    free(answers);
    clast_scatter_destroy(device.context, tables);
    clast_scene_destroy(scene);
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(textures_have_the_values_of_the_processor),
        cmocka_unit_test(footprints_have_the_values_of_the_processor),
        cmocka_unit_test(only_pictures_that_shading_reads_are_uploaded),
        cmocka_unit_test(images_that_are_too_large_are_refused_by_name),
        cmocka_unit_test(a_device_that_is_too_small_for_pictures_says_so),
        cmocka_unit_test(compressed_pictures_are_read_from_their_blocks),
        cmocka_unit_test(surfaces_scatter_as_on_the_processor),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
