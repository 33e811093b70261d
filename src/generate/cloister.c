// SPDX-License-Identifier: Apache-2.0
// The displaced scene put together: materials, cameras, and the files that name it all.
#include "generate/cloister.h"
#include "generate/noise.h"

static const char NAME[] = "cloister";

// Towards the sun: low, from the right and a little behind what is seen, so that it rakes over the stones.
static const float SUN[3] = {0.900f, 0.205f, -0.100f};
static const float TURBIDITY = 3.2f;
static const float EXPOSURE = 1.3f;

static const struct {
    const char *name;
    float position[3], target[3], degrees;
} cameras[] = {
    {"hero", {-1.9f, 1.30f, 5.2f}, {0.15f, 0.78f, -0.2f}, 36.0f},
    {"globe", {-0.55f, 1.62f, 1.35f}, {0.02f, 1.38f, 0.0f}, 40.0f},
    {"pavement", {-0.9f, 0.36f, 3.1f}, {0.9f, 0.05f, 0.6f}, 38.0f},
    {"yard", {-7.5f, 3.6f, 10.5f}, {0.4f, 0.6f, -2.2f}, 46.0f},
};
enum { CAMERAS = sizeof cameras / sizeof cameras[0] };

static const float roughness[CLAST_RELIEF_KINDS] = {
    [CLAST_RELIEF_COBBLES] = 0.80f, [CLAST_RELIEF_PANEL] = 0.72f, [CLAST_RELIEF_GLOBE] = 0.68f,
    [CLAST_RELIEF_ROPE] = 0.42f,    [CLAST_RELIEF_BARK] = 0.90f,  [CLAST_RELIEF_RINGS] = 0.75f,
    [CLAST_RELIEF_ASHLAR] = 0.85f,  [CLAST_RELIEF_HILLS] = 0.95f,
};
static const char *const material_names[CLAST_RELIEF_KINDS] = {
    [CLAST_RELIEF_COBBLES] = "cobbles", [CLAST_RELIEF_PANEL] = "panel", [CLAST_RELIEF_GLOBE] = "globe",
    [CLAST_RELIEF_ROPE] = "rope",       [CLAST_RELIEF_BARK] = "bark",   [CLAST_RELIEF_RINGS] = "rings",
    [CLAST_RELIEF_ASHLAR] = "ashlar",   [CLAST_RELIEF_HILLS] = "hills",
};

// Writes the pictures, and makes a material of each kind.
static void add_materials(clast_cloister *cloister)
{
    uint32_t size = cloister->detail < 0.1 ? 128 : cloister->detail < 0.5 ? 512 : cloister->detail < 4.0 ? 1024 : 2048;
    for (uint32_t i = 0; i < CLAST_RELIEF_KINDS && cloister->outputs->status == CLAST_OK; i++) {
        const clast_relief_files *files = &clast_relief_names[i];
        clast_relief_range range = clast_write_relief(cloister->outputs, (clast_relief_kind)i, size, cloister->seed);
        clast_gltf_material material = {
            .name = material_names[i],
            .roughness = roughness[i],
            .metallic = i == CLAST_RELIEF_ROPE ? 0.55f : 0.0f,
            .colour_image = files->colour,
            .colour = {1.0f, 1.0f, 1.0f},
            .displacement_image = files->height,
            .displacement_factor = range.factor,
            .displacement_offset = range.offset,
        };
        cloister->materials[i] = clast_gltf_add_material(&cloister->writer, &material);
        clast_outputs_note(cloister->outputs,
                           clast_progress(cloister->context, "generate textures", i + 1, CLAST_RELIEF_KINDS));
    }
}

static vec3 from_array(const float v[3])
{
    return vec3(v[0], v[1], v[2]);
}

static void write_models(clast_cloister *cloister)
{
    clast_gltf_begin(&cloister->writer, cloister->outputs, NAME);
    add_materials(cloister);
    cloister->builder = (clast_builder){
        .context = cloister->context, .writer = &cloister->writer, .expected = (uint64_t)(62000.0 * cloister->detail)};
    clast_cloister_build_ground(cloister);
    clast_cloister_build_globes(cloister);
    clast_cloister_build_rings(cloister);
    clast_cloister_build_trees(cloister);
    clast_cloister_build_walls(cloister);
    clast_builder_end(&cloister->builder);
    for (uint32_t i = 0; i < CAMERAS; i++) {
        clast_gltf_writer_add_camera(&cloister->writer, cameras[i].name, from_array(cameras[i].position),
                                     from_array(cameras[i].target), cameras[i].degrees * 0.0174532925f);
    }
    clast_gltf_end(&cloister->writer);
}

static void write_scene_file(clast_cloister *cloister)
{
    json_t *root = json_pack("{s:i, s:[{s:s}], s:{s:{s:[f, f, f], s:f}}, s:{s:s, s:f}}", "clast", 1, "models", "path",
                             "cloister.gltf", "environment", "sky", "sun_direction", (double)SUN[0], (double)SUN[1],
                             (double)SUN[2], "turbidity", (double)TURBIDITY, "settings", "camera", cameras[0].name,
                             "exposure", (double)EXPOSURE);
    clast_write_scene_file(cloister->outputs, root);
}

clast_status clast_generate_cloister(clast_context *context, double detail, uint32_t seed, const char *folder)
{
    clast_outputs *outputs = clast_allocate_zeroed(context, 1, sizeof *outputs);
    clast_cloister *cloister = clast_allocate_zeroed(context, 1, sizeof *cloister);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (outputs != NULL && cloister != NULL) {
        clast_outputs_begin(outputs, context, folder);
        *cloister = (clast_cloister){
            .context = context, .outputs = outputs, .detail = detail, .seed = hash1(seed) & 0xffffffu};
        write_models(cloister);
        write_scene_file(cloister); // last: a folder with it is whole
        status = clast_outputs_commit(outputs);
    }
    clast_free(context, cloister);
    clast_free(context, outputs);
    return status;
}
