// SPDX-License-Identifier: Apache-2.0
// Real models, from CLAST_ASSETS, through the public functions: loaded, cooked, rendered.
#include "test.h"

#include <ftw.h>
#include <math.h>
#include <string.h>

#include "clast/clast.h"
#include "scene/scene.h"

enum { WIDTH = 48, HEIGHT = 36, PIXELS = WIDTH * HEIGHT };

typedef struct pictures {
    float colour[3 * PIXELS];
    float depth[PIXELS];
    uint32_t instance[PIXELS];
} pictures;

// Renders with a camera that sees the whole scene.
static clast_status render(clast_scene *scene, pictures *made, clast_render_statistics *statistics)
{
    uint32_t camera = 0;
    clast_status status = clast_scene_add_default_camera(scene, &camera);
    clast_renderer *renderer = NULL;
    if (status == CLAST_OK) {
        status = clast_renderer_create(scene, &renderer);
    }
    char number[16];
    snprintf(number, sizeof number, "%u", camera);
    clast_render_settings settings = {.width = WIDTH, .height = HEIGHT, .spp = 1, .bounces = 3, .camera = number};
    clast_render_output outputs[] = {
        {CLAST_VIEW_COLOUR, made->colour}, {CLAST_VIEW_DEPTH, made->depth}, {CLAST_VIEW_INSTANCE, made->instance}};
    if (status == CLAST_OK) {
        status = clast_render(renderer, &settings, outputs, sizeof outputs / sizeof *outputs, statistics);
    }
    clast_renderer_destroy(renderer);
    return status;
}

// ------------------------------------------------------------------------------------------------------- every model

static clast_context *walk_context; // nftw has no argument for its caller
static size_t rendered_count, wrong_count;

static bool is_model(const char *path)
{
    static const char *const extensions[] = {".gltf", ".glb", ".obj", ".ply"};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot != NULL && i < sizeof extensions / sizeof *extensions; i++) {
        if (strcmp(dot, extensions[i]) == 0) {
            return true;
        }
    }
    return false;
}

// Some models show their backs to the camera, which it looks through.
static void show_backs(clast_scene *scene)
{
    for (size_t i = 0; i < scene->material_count; i++) {
        scene->materials[i].record.double_sided = 1;
    }
}

// False for a scene that is empty, or so thin that its camera sees nothing of it.
static bool can_be_seen(const clast_scene *scene)
{
    float lower[3], upper[3], largest = 0.0f, sum = 0.0f;
    clast_scene_bounds(scene, lower, upper);
    for (int i = 0; i < 3; i++) {
        float extent = upper[i] - lower[i];
        largest = fmaxf(largest, extent);
        sum += extent > 0.0f ? extent : 0.0f;
    }
    return sum - largest > 1e-3f * largest;
}

static const char *find_fault(const clast_scene *scene, const clast_scene_counts *counts, const pictures *made,
                              const clast_render_statistics *statistics)
{
    uint32_t hits = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        const float *colour = made->colour + 3 * i;
        for (int k = 0; k < 3; k++) {
            if (!isfinite(colour[k]) || colour[k] < 0.0f) {
                return "a colour is negative or not finite";
            }
        }
        bool is_hit = made->instance[i] != CLAST_NONE;
        if (is_hit && made->instance[i] >= counts->instances) {
            return "an instance that is not there was hit";
        }
        if (is_hit != (bool)isfinite(made->depth[i])) {
            return "depth and instance disagree about what was hit";
        }
        hits += is_hit;
    }
    if (statistics->triangles != counts->triangles || statistics->instanced_triangles != counts->instanced_triangles) {
        return "triangles were lost or added";
    }
    return hits == 0 && can_be_seen(scene) ? "nothing was seen" : NULL;
}

static int visit(const char *path, const struct stat *information, int type, struct FTW *walk)
{
    (void)information;
    (void)walk;
    if (type != FTW_F || !is_model(path)) {
        return 0;
    }
    static pictures made;
    uint64_t before = clast_context_memory(walk_context);
    clast_scene *scene = NULL;
    clast_status status = clast_scene_load(walk_context, path, &scene);
    if (status == CLAST_OK) {
        clast_scene_counts counts;
        clast_render_statistics statistics = {0};
        clast_scene_count(scene, &counts);
        show_backs(scene);
        status = render(scene, &made, &statistics);
        const char *fault = status != CLAST_OK ? clast_context_error(walk_context)
                                               : find_fault(scene, &counts, &made, &statistics);
        if (fault != NULL) {
            fprintf(stderr, "%s: %s\n", path, fault);
            wrong_count++;
        }
        rendered_count++;
    }
    clast_scene_destroy(scene);
    if (clast_context_memory(walk_context) != before) {
        fprintf(stderr, "%s: memory is left over\n", path);
        wrong_count++;
    }
    return 0;
}

// Which files are refused, and why, is the loaders' tests' subject.
static void every_model_that_loads_is_rendered_whole(void **state)
{
    static const struct {
        const char *folder;
        size_t least;
    } folders[] = {{"gltf-models", 8}, {"gltf-edge", 60}, {"gltf-animated", 5}, {"displaced-gltf", 3}, {"dense", 7}};
    walk_context = *state;
    wrong_count = 0;
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", test_assets(), folders[i].folder);
        rendered_count = 0;
        assert_int_equal(nftw(path, visit, 16, FTW_PHYS), 0);
        assert_true(rendered_count >= folders[i].least);
    }
    assert_int_equal(wrong_count, 0);
}

// ------------------------------------------------------------------------------------------------------ the same bits

static void render_with(const char *model, uint32_t threads, clast_isa isa, pictures *made)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", test_assets(), model);
    clast_context *context = NULL;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads, .isa = isa}, &context), CLAST_OK);
    clast_scene *scene = NULL;
    assert_ok(context, clast_scene_load(context, path, &scene));
    assert_ok(context, render(scene, made, NULL));
    clast_scene_destroy(scene);
    clast_context_destroy(context);
}

static clast_isa best_isa(void)
{
    clast_context *context = NULL;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1}, &context), CLAST_OK);
    clast_isa best = clast_context_isa(context);
    clast_context_destroy(context);
    return best;
}

static void threads_and_instruction_sets_give_the_same_bits(void **state)
{
    (void)state;
    static const char *const models[] = {"gltf-edge/VertexColorTest/VertexColorTest.gltf",
                                         "gltf-models/CesiumMilkTruck/CesiumMilkTruck.gltf"};
    static pictures first, other;
    clast_isa best = best_isa();
    for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
        render_with(models[i], 1, CLAST_ISA_PLAIN, &first);
        for (clast_isa isa = CLAST_ISA_PLAIN; isa <= best; isa++) {
            for (size_t k = 0; k < 3; k++) {
                render_with(models[i], (uint32_t[]){1, 2, 5}[k], isa, &other);
                assert_memory_equal(&first, &other, sizeof first);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(every_model_that_loads_is_rendered_whole),
        cmocka_unit_test(threads_and_instruction_sets_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
