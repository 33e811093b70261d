// SPDX-License-Identifier: Apache-2.0
#include "vulkan/materials.h"

#include "base/size.h"
#include "render/scatter.h"
#include "render/texture.h"

enum {
    LINEAR8 = 256,                        // values of the table of 8-bit colours
    LINEAR16 = 65536,                     // and of that of 16-bit colours
    GLASS = GLASS_TABLES * SCATTER_CELLS, // and of glass of an index of refraction
};

// ----------------------------------------------------------------------------------------------------------- materials

static clast_status use_texture(clast_gpu_materials *materials, clast_gpu_commands *commands, const clast_scene *scene,
                                const clast_texture_use *use, uint32_t encoding, clast_device_texture_use *made)
{
    *made = (clast_device_texture_use){.image = {.texture = CLAST_NONE}, .levels = {.texture = CLAST_NONE}};
    if (use->texture >= scene->texture_count) {
        return CLAST_OK;
    }
    const clast_texture *texture = &scene->textures[use->texture];
    bool turned = use->rotation != 0.0f;
    made->reading = texture_reading(texture->wrap_u, texture->wrap_v, texture->filter, use->coordinate_set, turned);
    made->offset = use->offset;
    made->scale = use->scale;
    made->cosine = rough_cos(use->rotation);
    made->sine = rough_sin(use->rotation);
    clast_status status = clast_gpu_pictures_need(&materials->pictures, commands, scene, texture->image, &made->image);
    if (status == CLAST_OK) {
        status = clast_gpu_pictures_need_levels(&materials->pictures, commands, scene, texture->image, encoding,
                                                &made->levels, &made->level_count);
    }
    return status;
}

static clast_status make_record(clast_gpu_materials *materials, clast_gpu_commands *commands, const clast_scene *scene,
                                const clast_scatter_tables *scatter, size_t number, clast_device_material *made)
{
    const clast_material *record = &scene->materials[number].record;
    made->record = *record;
    made->glass = scatter->glass_of[number];
    clast_status status = CLAST_OK;
#define USE_TEXTURE(name, slot, member, encoding) \
    status = status != CLAST_OK ? status \
                                : use_texture(materials, commands, scene, &record->member, \
                                              slot_encoding(slot, encoding, record->alpha_mode), &made->uses[slot]);
    CLAST_TEXTURE_SLOT_LIST(USE_TEXTURE)
#undef USE_TEXTURE
    return status;
}

static clast_status write_records(clast_gpu_materials *materials, clast_gpu_commands *commands,
                                  const clast_scene *scene, const clast_scatter_tables *scatter)
{
    clast_context *context = clast_gpu_context(materials->gpu);
    clast_device_material *records = clast_allocate(context, scene->material_count, sizeof *records);
    if (records == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < scene->material_count && status == CLAST_OK; i++) {
        status = make_record(materials, commands, scene, scatter, i, &records[i]);
    }
    uint64_t bytes = (uint64_t)scene->material_count * sizeof *records;
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(materials->gpu, CLAST_GPU_DEVICE, bytes, "materials", &materials->records);
    }
    if (status == CLAST_OK) {
        clast_gpu_write(commands, &materials->records, 0, records, bytes);
    }
    clast_free(context, records);
    return status;
}

// -------------------------------------------------------------------------------------------------------------- tables

static void fill_tables(const clast_gpu_materials *materials, const clast_scatter_tables *scatter, float *tables)
{
    clast_srgb_table colours;
    clast_srgb_table_fill(&colours);
    memcpy(tables, colours.linear, sizeof colours.linear);
    tables += LINEAR8;
    memcpy(tables, GGX_LOSS, sizeof GGX_LOSS);
    memcpy(tables + GGX_CELLS, GGX_RIM, sizeof GGX_RIM);
    memcpy(tables + 2 * GGX_CELLS, GGX_MEAN_LOSS, sizeof GGX_MEAN_LOSS);
    memcpy(tables + 2 * GGX_CELLS + GGX_SIDE, GGX_MEAN_RIM, sizeof GGX_MEAN_RIM);
    tables += GGX_TABLES;
    memcpy(tables, scatter->sheen, sizeof scatter->sheen);
    tables += SCATTER_CELLS;
    for (size_t i = 0; i < scatter->glass_count; i++) {
        memcpy(tables, scatter->glass[i].albedos, sizeof scatter->glass[i].albedos);
        tables += GLASS;
    }
    for (uint32_t i = 0; materials->pictures.has_16_bits && i < LINEAR16; i++) {
        tables[i] = srgb_to_linear(unorm16(i));
    }
    tables += materials->pictures.has_16_bits ? LINEAR16 : 0;
    for (size_t i = 0; i < materials->pictures.block_count; i++) {
        packed_address address = store_address(materials->pictures.blocks[i].address);
        memcpy((packed_address *)tables + i, &address, sizeof address);
    }
}

static clast_status write_tables(clast_gpu_materials *materials, clast_gpu_commands *commands,
                                 const clast_scatter_tables *scatter, clast_device_materials *head)
{
    clast_context *context = clast_gpu_context(materials->gpu);
    uint64_t ggx = LINEAR8, sheen = ggx + GGX_TABLES, glass = sheen + SCATTER_CELLS,
             colours16 = glass + (uint64_t)scatter->glass_count * GLASS;
    uint64_t blocks = colours16 + (materials->pictures.has_16_bits ? LINEAR16 : 0);
    uint64_t count = blocks + materials->pictures.block_count * (sizeof(packed_address) / sizeof(float));
    float *tables = clast_allocate(context, count, sizeof *tables);
    if (tables == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    fill_tables(materials, scatter, tables);
    uint64_t bytes = count * sizeof *tables;
    clast_status status = clast_gpu_reserve(materials->gpu, CLAST_GPU_DEVICE, bytes, "tables of materials",
                                            &materials->tables);
    if (status == CLAST_OK) {
        clast_gpu_write(commands, &materials->tables, 0, tables, bytes);
        uint64_t address = materials->tables.address;
        head->linear8 = store_address(address);
        head->ggx = store_address(address + ggx * sizeof *tables);
        head->sheen = store_address(address + sheen * sizeof *tables);
        head->glass = store_address(address + glass * sizeof *tables);
        head->blocks = store_address(address + blocks * sizeof *tables);
        head->linear16 = store_address(materials->pictures.has_16_bits ? address + colours16 * sizeof *tables : 0);
    }
    clast_free(context, tables);
    return status;
}

// -------------------------------------------------------------------------------------------------------------- update

static clast_status write_all(clast_gpu_materials *materials, clast_gpu_commands *commands, const clast_scene *scene,
                              const clast_scatter_tables *scatter)
{
    clast_device_materials head = {.material_count = (uint32_t)scene->material_count};
    clast_status status = write_records(materials, commands, scene, scatter);
    if (status == CLAST_OK) {
        status = write_tables(materials, commands, scatter, &head);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(materials->gpu, CLAST_GPU_DEVICE, sizeof head, "materials", &materials->head);
    }
    if (status == CLAST_OK) {
        head.materials = store_address(materials->records.address);
        clast_gpu_write(commands, &materials->head, 0, &head, sizeof head);
    }
    return status;
}

clast_status clast_gpu_materials_update(clast_gpu_materials *materials, clast_gpu_commands *commands,
                                        const clast_scene *scene, uint32_t surroundings)
{
    if (materials->made && materials->version == scene->material_version &&
        materials->surroundings_image == surroundings) {
        return CLAST_OK;
    }
    materials->made = false;
    clast_scatter_tables *scatter;
    clast_status status = clast_scatter_create(scene, &scatter);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_barrier(commands); // kernels before may still read what is overwritten
    status = clast_gpu_pictures_need(&materials->pictures, commands, scene, surroundings, &materials->surroundings);
    if (status == CLAST_OK) {
        status = write_all(materials, commands, scene, scatter);
    }
    clast_gpu_barrier(commands);
    clast_scatter_destroy(scene->context, scatter);
    materials->made = status == CLAST_OK;
    materials->version = scene->material_version;
    materials->surroundings_image = surroundings;
    return status;
}

void clast_gpu_materials_free(clast_gpu_materials *materials)
{
    if (materials->gpu == NULL) {
        return;
    }
    clast_gpu_pictures_free(&materials->pictures);
    clast_gpu_free(materials->gpu, &materials->head);
    clast_gpu_free(materials->gpu, &materials->records);
    clast_gpu_free(materials->gpu, &materials->tables);
    *materials = (clast_gpu_materials){.gpu = materials->gpu, .pictures = {.gpu = materials->gpu}};
}
