// SPDX-License-Identifier: Apache-2.0
// The demonstration scene put together: who gets how many triangles, materials, cameras, and the files that name it all.
#include "generate/canyon.h"

#include "generate/textures.h"

static const char NAME[] = "canyon";
static const double TRIANGLES = 1e6; // at detail 1

// Towards the sun: low, from the right and a little behind the viewer, so that it rakes over the carving.
static const float SUN[3] = {0.895f, 0.240f, 0.376f};
static const float TURBIDITY = 3.0f;
static const float EXPOSURE = 1.35f;

static const struct {
    const char *name;
    float position[3], target[3], degrees;
} cameras[] = {
    {"hero", {-10.6f, 2.1f, 27.5f}, {1.1f, 6.1f, 0.0f}, 37.0f},
    {"ornament", {-3.4f, 7.6f, 10.6f}, {-1.5f, 8.6f, 0.0f}, 34.0f},
    {"wide", {-36.0f, 13.0f, 54.0f}, {2.0f, 13.0f, -24.0f}, 50.0f},
};

static void add_materials(clast_canyon *canyon)
{
    static const clast_gltf_material materials[CLAST_CANYON_MATERIALS] = {
        [CLAST_CANYON_SAND] =
            {"sand", 1.0f, 0.0f, 1.0f, false, "sand_colour.png", "sand_roughness.png", "sand_normal.png", {1, 1, 1}},
        [CLAST_CANYON_ROCK] =
            {"rock", 1.0f, 0.0f, 1.0f, false, "rock_colour.png", "rock_roughness.png", "rock_normal.png", {1, 1, 1}},
        [CLAST_CANYON_STONE] = {"stone",
                                1.0f,
                                0.0f,
                                1.0f,
                                false,
                                "stone_colour.png",
                                "stone_roughness.png",
                                "stone_normal.png",
                                {1, 1, 1}},
        [CLAST_CANYON_GOLD] =
            {"gold", 1.0f, 1.0f, 1.0f, false, "gold_colour.png", "gold_roughness.png", "gold_normal.png", {1, 1, 1}},
        [CLAST_CANYON_LAPIS] =
            {"lapis", 1.0f, 1.0f, 1.0f, false, "lapis_colour.png", "lapis_roughness.png", NULL, {1, 1, 1}},
        [CLAST_CANYON_MARBLE] =
            {"marble", 1.0f, 0.0f, 1.0f, false, "marble_colour.png", "marble_roughness.png", NULL, {1, 1, 1}},
        [CLAST_CANYON_STRAW] = {"straw", 0.85f, 0.0f, 1.0f, true, NULL, NULL, NULL, {1, 1, 1}},
    };
    for (uint32_t i = 0; i < CLAST_CANYON_MATERIALS; i++) {
        canyon->materials[i] = clast_gltf_add_material(&canyon->writer, &materials[i]);
    }
}

static double max_double(double a, double b)
{
    return a < b ? b : a;
}

static void build_meshes(clast_canyon *canyon)
{
    double triangles = TRIANGLES * canyon->detail;
    canyon->builder = (clast_builder){
        .context = canyon->context, .writer = &canyon->writer, .expected = (uint64_t)triangles};
    // Stones are many and none has less than its few sides: the others share what they leave.
    clast_canyon_build_masonry(canyon, triangles * 0.10);
    double rest = max_double(triangles - (double)canyon->writer.triangle_count, 0.5 * triangles);
    clast_canyon_build_monument(canyon, rest * 0.465);
    clast_canyon_build_columns(canyon, rest * 0.105);
    clast_canyon_build_terrain(canyon, rest * 0.165);
    clast_canyon_build_mesas(canyon, rest * 0.20);
    clast_canyon_build_boulders(canyon, rest * 0.055);
    clast_canyon_build_grass(canyon, rest * 0.01);
    clast_builder_end(&canyon->builder);
}

static vec3 from_array(const float v[3])
{
    return vec3(v[0], v[1], v[2]);
}

// Height maps are for displacement; what their values mean stands in the glTF's extras.
static void write_heights(clast_canyon *canyon)
{
    static const float side = 400.0f;
    uint32_t size = canyon->detail < 0.1 ? 128 : 1024;
    float ground[2] = {0.0f, 0.0f}, ornament[2] = {0.0f, 0.0f};
    clast_canyon_write_heights(canyon, "terrain_height.png", size, side, &ground[0], &ground[1]);
    clast_canyon_write_ornament(canyon, "ornament_height.png", 4 * size, size / 2, &ornament[0], &ornament[1]);
    canyon->writer.extras = json_pack("{s:[{s:s, s:f, s:f, s:f}, {s:s, s:f, s:f}]}", "heightMaps", "uri",
                                      "terrain_height.png", "low", (double)ground[0], "high", (double)ground[1], "size",
                                      (double)side, "uri", "ornament_height.png", "low", (double)ornament[0], "high",
                                      (double)ornament[1]);
}

static void write_models(clast_canyon *canyon)
{
    clast_gltf_begin(&canyon->writer, canyon->outputs, NAME);
    write_heights(canyon);
    add_materials(canyon);
    build_meshes(canyon);
    for (uint32_t i = 0; i < sizeof cameras / sizeof cameras[0]; i++) {
        clast_gltf_writer_add_camera(&canyon->writer, cameras[i].name, from_array(cameras[i].position),
                                     from_array(cameras[i].target), cameras[i].degrees * 0.0174532925f);
    }
    clast_gltf_end(&canyon->writer);
}

static void write_pictures(clast_canyon *canyon)
{
    uint32_t size = canyon->detail < 0.1 ? 128 : canyon->detail < 0.5 ? 512 : canyon->detail < 8.0 ? 1024 : 2048;
    for (uint32_t i = 0; i < CLAST_TEXTURE_KINDS; i++) {
        clast_write_textures(canyon->outputs, (clast_texture_kind)i, size, canyon->seed);
        if (canyon->outputs->status == CLAST_OK) {
            clast_outputs_note(canyon->outputs,
                               clast_progress(canyon->context, "generate textures", i + 1, CLAST_TEXTURE_KINDS));
        }
    }
}

static json_t *numbers3(const float v[3])
{
    return json_pack("[f, f, f]", (double)v[0], (double)v[1], (double)v[2]);
}

static json_t *scene_document(void)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < sizeof cameras / sizeof cameras[0]; i++) {
        json_array_append_new(list, json_pack("{s:s, s:o, s:o, s:f}", "name", cameras[i].name, "position",
                                              numbers3(cameras[i].position), "target", numbers3(cameras[i].target),
                                              "vertical_angle", (double)cameras[i].degrees));
    }
    return json_pack("{s:i, s:[{s:s}], s:{s:{s:o, s:f}}, s:o, s:{s:s, s:f}}", "clast", 1, "models", "path",
                     "canyon.gltf", "environment", "sky", "sun_direction", numbers3(SUN), "turbidity",
                     (double)TURBIDITY, "cameras", list, "settings", "camera", cameras[0].name, "exposure",
                     (double)EXPOSURE);
}

static void write_scene_file(clast_canyon *canyon)
{
    clast_write_scene_file(canyon->outputs, scene_document());
}

clast_status clast_generate_canyon(clast_context *context, double detail, uint32_t seed, const char *folder)
{
    clast_outputs *outputs = clast_allocate_zeroed(context, 1, sizeof *outputs);
    clast_canyon *canyon = clast_allocate_zeroed(context, 1, sizeof *canyon);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (outputs != NULL && canyon != NULL) {
        clast_outputs_begin(outputs, context, folder);
        *canyon = (clast_canyon){
            .context = context, .outputs = outputs, .detail = detail, .seed = hash1(seed) & 0xffffffu};
        clast_canyon_place_mesas(canyon);
        write_pictures(canyon);
        write_models(canyon);
        write_scene_file(canyon); // last: a folder with it is whole
        status = clast_outputs_commit(outputs);
    }
    clast_free(context, canyon);
    clast_free(context, outputs);
    return status;
}
