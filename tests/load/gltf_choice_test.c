// SPDX-License-Identifier: Apache-2.0
// Which scene, which variant of the materials, and which image of a texture are taken.
#include "loader_fixture.h"

// Two scenes; a triangle whose material has two variants.
static const char text[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":1,"
    "\"scenes\":[{\"name\":\"empty\",\"nodes\":[0]},{\"nodes\":[1,2]},{\"name\":\"0\",\"nodes\":[3]}],"
    "\"nodes\":[{},{\"mesh\":0},{\"mesh\":0},{\"mesh\":0}],\"extensionsUsed\":[\"KHR_materials_variants\"],"
    "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"dusk\"},{\"name\":\"dawn\"},{\"name\":\"none\"}]}},"
    "\"materials\":[{\"name\":\"day\"},{\"name\":\"red\"},{\"name\":\"blue\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0,\"extensions\":{\"KHR_materials_variants\":"
    "{\"mappings\":[{\"material\":1,\"variants\":[0]},{\"material\":2,\"variants\":[1]}]}}}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

static clast_status load_chosen(fixture *f, const char *name, const char *scene, const char *variant)
{
    clast_scene_destroy(f->scene);
    f->scene = NULL;
    return clast_scene_load_chosen(f->context, name, &(clast_scene_choice){scene, variant}, &f->scene);
}

static void assert_refused_choice(fixture *f, const char *scene, const char *variant, const char *words)
{
    assert_int_equal(load_chosen(f, "a.gltf", scene, variant), CLAST_ERROR_INVALID_ARGUMENT);
    if (strstr(clast_context_error(f->context), words) == NULL) {
        fail_msg("no \"%s\" in \"%s\"", words, clast_context_error(f->context));
    }
}

static void a_scene_is_chosen_by_name_then_by_number(void **state)
{
    fixture *f = *state;
    put_text(f, "a.gltf", text);
    static const struct {
        const char *scene;
        size_t instances;
    } cases[] = {{NULL, 2}, {"empty", 0}, {"1", 2}, {"0", 1}, {"2", 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_ok(f->context, load_chosen(f, "a.gltf", cases[i].scene, NULL));
        assert_int_equal(f->scene->instance_count, cases[i].instances);
    }
    assert_refused_choice(f, "3", NULL, "no scene \"3\": there are 0 empty, 1, 2 0");
    assert_refused_choice(f, "Empty", NULL, "no scene \"Empty\"");
}

static const char *material_of(const fixture *f, size_t geometry)
{
    return f->scene->materials[mesh_of(f, geometry)->material].name;
}

static void a_variant_changes_the_material(void **state)
{
    fixture *f = *state;
    put_text(f, "a.gltf", text);
    static const char *const cases[][2] = {{NULL, "day"}, {"dusk", "red"}, {"1", "blue"}, {"none", "day"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_ok(f->context, load_chosen(f, "a.gltf", NULL, cases[i][0]));
        assert_string_equal(material_of(f, 0), cases[i][1]);
    }
    assert_refused_choice(f, NULL, "noon", "no variant \"noon\": there are 0 dusk, 1 dawn, 2 none");
    put_text(f, "b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_ok(f->context, load_chosen(f, "b.obj", "any", "any")); // other formats have none to choose from
}

static void models_of_scene_files_choose_for_themselves(void **state)
{
    fixture *f = *state;
    put_text(f, "a.gltf", text);
    put_text(
        f, "s.json",
        "{\"clast\":1,\"models\":[{\"path\":\"a.gltf\"},{\"path\":\"a.gltf\",\"scene\":\"2\",\"variant\":\"dawn\"}]}");
    assert_ok(f->context, load_chosen(f, "s.json", NULL, "dusk"));
    assert_int_equal(f->scene->instance_count, 3);
    assert_string_equal(material_of(f, 0), "red");
    assert_string_equal(material_of(f, f->scene->geometry_count - 1), "blue");
}

// A texture whose image only an extension has: the picture is a DDS file of one pixel block.
static void images_of_extensions_are_read(void **state)
{
    fixture *f = *state;
    unsigned char dds[136] = "DDS \x7c";
    dds[12] = dds[16] = 4;
    dds[76] = 32;
    dds[80] = 4;
    memcpy(dds + 84, "DXT1", 4);
    memory_files_put(&f->files, "a.dds", dds, sizeof dds);
    char changed[4096];
    const char *at = strstr(text, "{\"name\":\"day\"}");
    assert_non_null(at);
    snprintf(changed, sizeof changed,
             "%.*s{\"name\":\"day\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}%.*s,"
             "\"textures\":[{\"extensions\":{\"MSFT_texture_dds\":{\"source\":0}}}],\"images\":[{\"uri\":\"a.dds\"}]}",
             (int)(at - text), text, (int)(strlen(at) - 15), at + 14);
    put_text(f, "a.gltf", changed);
    assert_ok(f->context, load_chosen(f, "a.gltf", NULL, NULL));
    assert_int_equal(f->scene->image_count, 1);
    assert_int_equal(f->scene->texture_count, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(a_scene_is_chosen_by_name_then_by_number),
        LOADER_TEST(a_variant_changes_the_material),
        LOADER_TEST(models_of_scene_files_choose_for_themselves),
        LOADER_TEST(images_of_extensions_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
