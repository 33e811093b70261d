// SPDX-License-Identifier: Apache-2.0
#include "vulkan/lights.h"

#include "base/size.h"

_Static_assert((int)CLAST_SKY_WIDTH == (int)SKY_WIDTH && (int)CLAST_SKY_HEIGHT == (int)SKY_HEIGHT,
               "size of the picture of a sky");

// The tables, in the order in which they lie in the buffer.
enum {
    ROW_SUMS,
    CELL_SUMS,
    SKY,
    PUNCTUAL,
    DIRECTIONAL,
    DIRECTIONAL_SUMS,
    EMITTERS,
    FIRST_EMITTER,
    TREE_NODES,
    TREE_ENTRIES,
    TREE_TRAILS,
    TREE_PLACES,
    TABLES
};

typedef struct table {
    const void *data;
    size_t count, size, offset;
} table;

// Those that are not there are empty.
static void list_tables(const clast_lights *lights, table tables[TABLES])
{
    const clast_frame *frame = lights->frame;
    const clast_surroundings *cells = &lights->surroundings;
    size_t rows = cells->row_sums != NULL ? cells->height : 0, sky = lights->sky.radiance != NULL ? SKY_WIDTH : 0;
    size_t directional = lights->directional.count, emitters = lights->emitter_count;
    const clast_light_tree *tree = &lights->tree;
    size_t numbers = tree->count != 0 ? tree->number_count : 0;
    tables[ROW_SUMS] = (table){cells->row_sums, rows != 0 ? rows + 1 : 0, sizeof(float), 0};
    tables[CELL_SUMS] = (table){cells->cell_sums, rows * ((size_t)cells->width + 1), sizeof(float), 0};
    tables[SKY] = (table){lights->sky.radiance, sky * SKY_HEIGHT, sizeof(packed3), 0};
    tables[PUNCTUAL] = (table){frame->motion.lights, frame->scene->light_count, sizeof(clast_light), 0};
    tables[DIRECTIONAL] = (table){lights->directional_numbers, directional, sizeof(uint32_t), 0};
    tables[DIRECTIONAL_SUMS] = (table){lights->directional.sums, directional != 0 ? directional + 1 : 0, sizeof(float),
                                       0};
    tables[EMITTERS] = (table){frame->emitters, emitters, sizeof(clast_emitter), 0};
    tables[FIRST_EMITTER] = (table){lights->first_emitter, emitters != 0 ? frame->instance_count + 1 : 0,
                                    sizeof(uint32_t), 0};
    tables[TREE_NODES] = (table){tree->nodes, tree->node_count, sizeof(clast_light_node), 0};
    tables[TREE_ENTRIES] = (table){tree->entries, tree->count, sizeof(clast_light_entry), 0};
    tables[TREE_TRAILS] = (table){tree->trails, numbers, sizeof(uint32_t), 0};
    tables[TREE_PLACES] = (table){tree->places, numbers, sizeof(uint32_t), 0};
}

// False where there are more than memory has addresses for.
static bool place_tables(table tables[TABLES], size_t *bytes)
{
    *bytes = 0;
    for (int i = 0; i < TABLES; i++) {
        size_t size;
        tables[i].offset = *bytes;
        if (!clast_multiply_size(tables[i].count, tables[i].size, &size) || !clast_add_size(*bytes, size, bytes)) {
            return false;
        }
    }
    return true;
}

static packed_address address_of(const clast_gpu_lights *mirror, const table *table)
{
    return store_address(table->count != 0 ? mirror->tables.address + table->offset : 0);
}

static clast_device_lights head_of(const clast_gpu_lights *mirror, const clast_lights *lights,
                                   const table tables[TABLES], clast_device_image image)
{
    const clast_surroundings *cells = &lights->surroundings;
    return (clast_device_lights){
        .row_sums = address_of(mirror, &tables[ROW_SUMS]),
        .cell_sums = address_of(mirror, &tables[CELL_SUMS]),
        .sky = address_of(mirror, &tables[SKY]),
        .punctual = address_of(mirror, &tables[PUNCTUAL]),
        .directional = address_of(mirror, &tables[DIRECTIONAL]),
        .directional_sums = address_of(mirror, &tables[DIRECTIONAL_SUMS]),
        .emitters = address_of(mirror, &tables[EMITTERS]),
        .first_emitter = address_of(mirror, &tables[FIRST_EMITTER]),
        .tree_nodes = address_of(mirror, &tables[TREE_NODES]),
        .tree_entries = address_of(mirror, &tables[TREE_ENTRIES]),
        .tree_trails = address_of(mirror, &tables[TREE_TRAILS]),
        .tree_places = address_of(mirror, &tables[TREE_PLACES]),
        .image = image,
        .flags = (lights->has_surroundings ? LIGHTS_SURROUNDINGS : 0u) | (lights->has_sun ? LIGHTS_SUN : 0u),
        .factor = store3(lights->factor),
        .cells_width = cells->width,
        .cells_height = cells->height,
        .rotation = cells->rotation,
        .upper = cells->upper,
        .lower = cells->lower,
        .sun = lights->sun,
        .sun_height = lights->sun_height,
        .sun_irradiance = store3(lights->sun_irradiance),
        .sun_density = lights->sun_density,
        .directional_count = lights->directional.count,
        .directional_total = lights->directional.total,
        .emitter_count = lights->emitter_count,
        .tree_count = lights->tree.count,
        .tree_scale = lights->tree.scale,
        .tree_strength = lights->tree.strength,
    };
}

clast_status clast_gpu_lights_update(clast_gpu_lights *mirror, clast_gpu_commands *commands, const clast_lights *lights,
                                     clast_device_image image)
{
    table tables[TABLES];
    size_t bytes;
    list_tables(lights, tables);
    if (!place_tables(tables, &bytes)) {
        return clast_fail(clast_gpu_context(mirror->gpu), CLAST_ERROR_LIMIT,
                          "the tables of the lights take more memory than there are addresses");
    }
    clast_status status = clast_gpu_reserve(mirror->gpu, CLAST_GPU_DEVICE, sizeof(clast_device_lights), "lights",
                                            &mirror->head);
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(mirror->gpu, CLAST_GPU_DEVICE, bytes, "tables of lights", &mirror->tables);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_device_lights head = head_of(mirror, lights, tables, image);
    clast_gpu_write(commands, &mirror->head, 0, &head, sizeof head);
    for (int i = 0; i < TABLES; i++) {
        clast_gpu_write(commands, &mirror->tables, tables[i].offset, tables[i].data, tables[i].count * tables[i].size);
    }
    return CLAST_OK;
}

void clast_gpu_lights_free(clast_gpu_lights *mirror)
{
    clast_gpu_free(mirror->gpu, &mirror->head);
    clast_gpu_free(mirror->gpu, &mirror->tables);
}
