// SPDX-License-Identifier: Apache-2.0
// The boards of materials as files: sound glTF with every extension, the same for any number of threads.
#include "folder.h"

#include <jansson.h>

#include "clast/generate.h"

static folder make_boards(clast_context *context)
{
    folder to = folder_make();
    assert_ok(context, clast_generate(context, &(clast_generate_desc){"materials", 0.02, 0}, to.path));
    return to;
}

static void boards_show_every_extension(void **state)
{
    folder to = make_boards(*state);
    char path[512];
    snprintf(path, sizeof path, "%s/materials.gltf", to.path);
    json_t *root = json_load_file(path, 0, NULL);
    assert_non_null(root);
    const char *const names[] = {
        "KHR_materials_anisotropy",
        "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_iridescence",
        "KHR_materials_sheen",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_volume",
    };
    const json_t *used = json_object_get(root, "extensionsUsed");
    assert_int_equal(json_array_size(used), sizeof names / sizeof *names);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        bool found = false;
        for (size_t k = 0; k < json_array_size(used); k++) {
            found |= strcmp(json_string_value(json_array_get(used, k)), names[i]) == 0;
        }
        if (!found) {
            fail_msg("no board shows %s", names[i]);
        }
    }
    assert_int_equal(json_array_size(json_object_get(root, "cameras")), 11);
    json_decref(root);
    folder_remove(&to);
}

int main(void)
{
    const struct CMUnitTest tests[] = {CONTEXT_TEST(boards_show_every_extension)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
