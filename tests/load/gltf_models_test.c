// SPDX-License-Identifier: Apache-2.0
// Real glTF files, from CLAST_ASSETS: each loads, or is refused for a reason that is listed here.
#include "test.h"

#include <ftw.h>
#include <math.h>
#include <string.h>

#include "load/load.h"

// Files that are refused: what their path ends with, and what the error says. The compressed ones name the extension
// that they require; the others break a rule of the format, or come from a later version of it.
static const struct refusal {
    const char *path;
    clast_status status;
    const char *words;
} REFUSALS[] = {
    {"gltf-compressed/BoxDraco/BoxDraco.gltf", CLAST_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"gltf-compressed/Box_Draco.glb", CLAST_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"gltf-compressed/CesiumMilkTruck/CesiumMilkTruck.gltf", CLAST_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"gltf-compressed/DracoSparseMesh/DracoSparseMesh.gltf", CLAST_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"gltf-compressed/chess-board.glb", CLAST_ERROR_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"gltf-edge/AssetGenerator/Compatibility/Compatibility_04.gltf", CLAST_ERROR_UNSUPPORTED, "version 2.1"},
    {"gltf-edge/AssetGenerator/Compatibility/Compatibility_05.gltf", CLAST_ERROR_UNSUPPORTED,
     "FAKE_materials_quantumRendering"},
    {"gltf-edge/CubeScaledInstances/cube_att.gltf", CLAST_ERROR_MALFORMED, "expected one parent"},
};
enum { REFUSAL_COUNT = sizeof REFUSALS / sizeof *REFUSALS };

static clast_context *test_context; // nftw has no argument for its caller
static size_t loaded_count, refused_count, wrong_count;
static bool is_strict;

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), end_length = strlen(end);
    return length >= end_length && strcmp(text + length - end_length, end) == 0;
}

static const struct refusal *expected_refusal(const char *path)
{
    for (size_t i = 0; i < REFUSAL_COUNT; i++) {
        if (ends_with(path, REFUSALS[i].path)) {
            return &REFUSALS[i];
        }
    }
    return NULL;
}

static clast_status load(const char *path, clast_scene **scene)
{
    clast_file_view file;
    *scene = NULL;
    clast_status status = clast_file_map(test_context, path, &file);
    if (status == CLAST_OK) {
        status = clast_scene_create(test_context, scene);
    }
    if (status == CLAST_OK) {
        status = clast_load_gltf(*scene, path, &file);
    }
    clast_file_unmap(test_context, &file);
    return status;
}

static void note(const char *path, clast_status status)
{
    const char *error = status != CLAST_OK ? clast_context_error(test_context) : "";
    const struct refusal *refusal = expected_refusal(path);
    bool sound = status == CLAST_OK
                     ? refusal == NULL
                     : refusal != NULL && status == refusal->status && strstr(error, refusal->words) != NULL;
    loaded_count += status == CLAST_OK;
    refused_count += status != CLAST_OK;
    if (is_strict && !sound) {
        fprintf(stderr, "%s: %s: %s\n", path, clast_status_text(status), error);
        wrong_count++;
    }
    // Every error is one line that names the file.
    if (status != CLAST_OK && (strstr(error, path) != error || strchr(error, '\n') != NULL)) {
        fprintf(stderr, "%s: error \"%s\"\n", path, error);
        wrong_count++;
    }
}

static int visit(const char *path, const struct stat *information, int type, struct FTW *walk)
{
    (void)information;
    (void)walk;
    if (type == FTW_F && (ends_with(path, ".gltf") || ends_with(path, ".glb"))) {
        uint64_t before = clast_context_memory(test_context);
        clast_scene *scene;
        note(path, load(path, &scene));
        clast_scene_destroy(scene);
        wrong_count += clast_context_memory(test_context) != before;
    }
    return 0;
}

static void visit_folder(clast_context *context, const char *folder, bool strict)
{
    char path[1024];
    test_context = context;
    is_strict = strict;
    loaded_count = refused_count = wrong_count = 0;
    snprintf(path, sizeof path, "%s/%s", test_assets(), folder);
    assert_int_equal(nftw(path, visit, 16, FTW_PHYS), 0);
    assert_int_equal(wrong_count, 0);
}

static void every_model_loads_or_is_refused_by_name(void **state)
{
    const char *folders[] = {"gltf-models",    "gltf-edge",       "gltf-animated",
                             "displaced-gltf", "gltf-compressed", "micromesh"};
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        visit_folder(*state, folders[i], true);
        assert_true(loaded_count > 0);
    }
}

static void every_malformed_file_is_survived(void **state)
{
    visit_folder(*state, "malformed", false);
    assert_true(refused_count > 40);
}

typedef struct expectation {
    const char *path;
    uint32_t geometries, instances, images;
    uint64_t triangles;
    float lower[3], upper[3];
} expectation;

static void check(clast_context *context, const expectation *expected)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", test_assets(), expected->path);
    test_context = context;
    clast_scene *scene;
    assert_ok(context, load(path, &scene));
    clast_scene_counts counts;
    clast_scene_count(scene, &counts);
    assert_int_equal(counts.geometries, expected->geometries);
    assert_int_equal(counts.instances, expected->instances);
    assert_int_equal(counts.images, expected->images);
    assert_int_equal(counts.instanced_triangles, expected->triangles);
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    for (int i = 0; i < 3; i++) {
        assert_float_equal(lower[i], expected->lower[i], 1e-3f * fmaxf(1.0f, fabsf(expected->lower[i])));
        assert_float_equal(upper[i], expected->upper[i], 1e-3f * fmaxf(1.0f, fabsf(expected->upper[i])));
    }
    clast_scene_destroy(scene);
}

// Counts from the files' JSON; boxes from the accessors' bounds and the nodes' transforms.
static void well_known_models_have_their_counts_and_boxes(void **state)
{
    static const expectation expected[] = {
        {"gltf-edge/Box.glb", 1, 1, 0, 12, {-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}},
        {"gltf-models/Avocado.glb", 1, 1, 1, 682, {-0.173f, -0.256f, 0.1436f}, {0.173f, 0.256f, 0.3684f}},
        {"gltf-models/FlightHelmet/FlightHelmet.gltf",
         6,
         6,
         15,
         94722,
         {-0.2036f, 0, -0.1715f},
         {0.1629f, 0.716f, 0.2f}},
        {"gltf-models/2CylinderEngine.glb",
         34,
         115,
         0,
         121496,
         {-373.294f, -188.283f, -140.0f},
         {371.692f, 115.259f, 135.258f}},
        {"gltf-edge/one_face_123_mirror/one_face_123_mirror.gltf", 1, 1, 0, 1, {-3, -0.11f, 0}, {-1, -0.01f, 0}},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        check(*state, &expected[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(every_model_loads_or_is_refused_by_name),
        CONTEXT_TEST(every_malformed_file_is_survived),
        CONTEXT_TEST(well_known_models_have_their_counts_and_boxes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
