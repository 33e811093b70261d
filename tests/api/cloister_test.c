// SPDX-License-Identifier: Apache-2.0
// The scene of height maps, as files: everything is displaced, and closed but for the land.
#include <string.h>

#include "closed.h"
#include "generate/folder.h"
#include "test.h"

#include "clast/generate.h"
#include "scene/scene.h"

static void everything_is_displaced_and_closed(void **state)
{
    clast_context *context = *state;
    folder to = folder_make();
    char path[512];
    clast_scene *scene;
    assert_ok(context, clast_generate(context, &(clast_generate_desc){"cloister", 0.02, 3}, to.path));
    folder_file(&to, "scene.json", path);
    assert_ok(context, clast_scene_load(context, path, &scene));
    assert_true(scene->geometry_count >= 10 && scene->instance_count >= 100);
    uint32_t lands = 0, joined = 0;
    for (size_t i = 0; i < scene->geometry_count; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        assert_true(geometry->tessellated);
        if (strcmp(geometry->name, "hills") == 0) {
            lands++;
        } else {
            assert_closed(context, &geometry->of.mesh, false);
        }
        joined += geometry->of.mesh.triangle_materials != NULL;
    }
    assert_int_equal(lands, 1);
    assert_int_equal(joined, 2); // trunks and their ends
    for (size_t i = 1; i < scene->material_count; i++) {
        const clast_material *material = &scene->materials[i].record;
        assert_int_not_equal(material->displacement_texture.texture, CLAST_NONE);
        assert_true(material->displacement_scale > 0.0f);
    }
    for (size_t i = 0; i < scene->image_count; i++) {
        const clast_image *image = &scene->images[i].image;
        assert_true(image->type == (image->channels == 1 ? CLAST_PIXEL_UNORM16 : CLAST_PIXEL_UNORM8));
    }
    clast_scene_destroy(scene);
    folder_remove(&to);
}

int main(void)
{
    const struct CMUnitTest tests[] = {CONTEXT_TEST(everything_is_displaced_and_closed)};
    return cmocka_run_group_tests_name("cloister", tests, NULL, NULL);
}
