// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

#define MODEL "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"

// A model with one face of each of the materials m and n.
static const clast_material *load_material(fixture *f, const char *library)
{
    put_text(f, "a.mtl", library);
    assert_loads(f, "a.obj", MODEL "usemtl m\nf 1 2 3\n");
    uint32_t number = mesh_of(f, 0)->material;
    assert_true(number > 0 && number < f->scene->material_count);
    return &f->scene->materials[number].record;
}

static void colours_and_numbers_are_read(void **state)
{
    fixture *f = *state;
    const clast_material *m = load_material(
        f, "newmtl m\n\tKd 0.1 0.2 0.3\n Ke 4 5 6\nPr 0.25\nPm 0.75\nd 0.5\nNi 1.5\nillum 2\n");
    ASSERT_FLOATS(m->base_colour.v, 1e-6, 0.1f, 0.2f, 0.3f, 0.5f);
    ASSERT_FLOATS(m->emissive.v, 1e-6, 4, 5, 6);
    ASSERT_FLOATS(&m->roughness, 1e-6, 0.25f);
    ASSERT_FLOATS(&m->metallic, 1e-6, 0.75f);
    assert_int_equal(m->alpha_mode, CLAST_ALPHA_BLEND);
    assert_int_equal(m->double_sided, 1);
    ASSERT_FLOATS(load_material(f, "newmtl m\nKd 0.5\nTr 0.25\n")->base_colour.v, 1e-6, 0.5f, 0.5f, 0.5f, 0.75f);
    assert_int_equal(load_material(f, "newmtl m\nKd 1 1 1\nd 1\nTr 1\n")->alpha_mode, CLAST_ALPHA_OPAQUE);
}

static void layers_are_read(void **state)
{
    fixture *f = *state;
    const clast_material *m = load_material(
        f, "newmtl m\nKd 1 1 1\nNi 1.7\nPs 0.5\nPc 0.75\nPcr 0.25\naniso 0.5\nanisor 0.25\n");
    ASSERT_FLOATS(&m->ior, 1e-6, 1.7f);
    ASSERT_FLOATS(m->sheen_colour.v, 1e-6, 0.5f, 0.5f, 0.5f);
    ASSERT_FLOATS(&m->clearcoat, 1e-6, 0.75f);
    ASSERT_FLOATS(&m->clearcoat_roughness, 1e-6, 0.25f);
    ASSERT_FLOATS(&m->anisotropy, 1e-6, 0.5f);
    ASSERT_FLOATS(m->anisotropy_direction.v, 1e-6, 0, 1);
    m = load_material(f, "newmtl m\nKd 1 1 1\nNi 1\nPc 3\n"); // an index that takes all gloss away, a coat out of range
    ASSERT_FLOATS(&m->ior, 1e-6, 1.5f);
    ASSERT_FLOATS(&m->clearcoat, 1e-6, 1);
    assert_non_null(strstr(f->log, "Pc"));
}

static void roughness_follows_the_exponent(void **state)
{
    fixture *f = *state;
    ASSERT_FLOATS(&load_material(f, "newmtl m\nKs 1 1 1\nNs 0\n")->roughness, 1e-6, 1);
    ASSERT_FLOATS(&load_material(f, "newmtl m\nKs 1 1 1\nNs 30\n")->roughness, 1e-6, 0.5f);
    ASSERT_FLOATS(&load_material(f, "newmtl m\nKs 0 0 0\nNs 30\n")->roughness, 1e-6, 1);
    ASSERT_FLOATS(&load_material(f, "newmtl m\nKs 1 1 1\nNs 30\nPr 0.1\n")->roughness, 1e-6, 0.1f);
}

static void a_black_surface_with_a_coloured_gloss_is_metal(void **state)
{
    fixture *f = *state;
    const clast_material *m = load_material(f, "newmtl m\nKd 0 0 0\nKs 1 0.8 0.3\nNs 100\n");
    ASSERT_FLOATS(&m->metallic, 0, 1);
    ASSERT_FLOATS(m->base_colour.v, 1e-6, 1, 0.8f, 0.3f, 1);
    ASSERT_FLOATS(&load_material(f, "newmtl m\nKd 0.1 0 0\nKs 1 0.8 0.3\n")->metallic, 0, 0);
}

static void values_out_of_range_are_clamped_with_a_warning(void **state)
{
    fixture *f = *state;
    ASSERT_FLOATS(load_material(f, "newmtl m\nKd 2 -1 0.5\n")->base_colour.v, 0, 1, 0, 0.5f, 1);
    assert_non_null(strstr(f->log, "material m: a colour is not between 0 and 1"));
}

static void each_face_has_its_material(void **state)
{
    fixture *f = *state;
    put_text(f, "a.mtl", "newmtl two words \nKd 1 0 0\nnewmtl n\nKd 0 1 0\nnewmtl n\nKd 0 0 1\n");
    assert_loads(f, "a.obj", MODEL "f 1 2 3\nusemtl two words\nf 1 2 3\nusemtl n\nf 1 2 3\nusemtl missing\nf 1 2 3\n");
    const uint32_t *materials = mesh_of(f, 0)->triangle_materials;
    assert_non_null(materials);
    assert_int_equal(materials[0], 0);
    ASSERT_FLOATS(f->scene->materials[materials[1]].record.base_colour.v, 0, 1, 0, 0);
    ASSERT_FLOATS(f->scene->materials[materials[2]].record.base_colour.v, 0, 0, 0, 1);
    assert_string_equal(f->scene->materials[materials[1]].name, "two words");
    assert_int_equal(materials[3], 0);
    assert_non_null(strstr(f->log, "missing"));
}

static void missing_libraries_are_warned_of(void **state)
{
    fixture *f = *state;
    put_text(f, "c d.mtl", "newmtl x\n");
    put_text(f, "b.mtl", "newmtl m\n");
    assert_loads(f, "a.obj",
                 "mtllib nowhere.mtl\nmtllib c d.mtl\nmtllib x.mtl b.mtl c\\ d.mtl\nv 0 0 0\nusemtl m\nf 1 1 1\n");
    assert_non_null(strstr(f->log, "nowhere.mtl is missing"));
    assert_non_null(strstr(f->log, "x.mtl is missing"));
    assert_null(strstr(f->log, "d.mtl is missing"));
    assert_int_equal(mesh_of(f, 0)->material != 0, 1);
}

static void libraries_lie_beside_the_model(void **state)
{
    fixture *f = *state;
    put_text(f, "models/a.mtl", "newmtl m\n");
    assert_loads(f, "models/a.obj", MODEL "usemtl m\nf 1 2 3\n");
    assert_int_equal(mesh_of(f, 0)->material, 1);
}

// ----------------------------------------------------------------------------------------------------------- textures

// PFM pictures, which are easily made: 1 x 1, grey or coloured.
static const char grey_pfm[] = "Pf\n1 1\n1.0\n\x3f\0\0\0";                       // 0.5
static const char blue_pfm[] = "PF\n1 1\n1.0\n\x3f\0\0\0\x3f\0\0\0\x3f\x80\0\0"; // 0.5 0.5 1
static const char dark_pfm[] = "Pf\n1 1\n1.0\n\x3e\x80\0\0";                     // 0.25

static void put_pictures(fixture *f)
{
    memory_files_put(&f->files, "grey.pfm", grey_pfm, sizeof grey_pfm - 1);
    memory_files_put(&f->files, "t/blue sky.pfm", blue_pfm, sizeof blue_pfm - 1);
    memory_files_put(&f->files, "dark.pfm", dark_pfm, sizeof dark_pfm - 1);
}

static const clast_image *image_of(const fixture *f, uint32_t texture)
{
    assert_true(texture < f->scene->texture_count);
    return &f->scene->images[f->scene->textures[texture].image].image;
}

static void textures_are_read_once(void **state)
{
    fixture *f = *state;
    put_pictures(f);
    const clast_material *m = load_material(
        f, "newmtl n\nmap_Kd t\\blue sky.pfm\nnewmtl m\nmap_Kd t/blue sky.pfm\nmap_Ke t/blue sky.pfm\n");
    assert_int_equal(f->scene->image_count, 1);
    assert_int_equal(f->scene->texture_count, 1);
    assert_int_equal(m->base_colour_texture.texture, 0);
    assert_int_equal(m->emissive_texture.texture, 0);
    ASSERT_FLOATS(m->emissive.v, 0, 1, 1, 1);
    ASSERT_FLOATS(m->base_colour.v, 0, 1, 1, 1, 1);
    assert_int_equal(m->normal_texture.texture, CLAST_NONE);
}

static void options_of_maps_are_heeded_or_skipped(void **state)
{
    fixture *f = *state;
    put_pictures(f);
    const clast_material *m = load_material(
        f, "newmtl m\nmap_Kd -blendu on -s 2 3 1 -o 0.25 0.5 -clamp on -mm 0 1 -texres 512 t/blue sky.pfm -imfchan r\n"
           "map_Bump -bm 2.5 t/blue sky.pfm\n");
    const clast_texture_use *use = &m->base_colour_texture;
    ASSERT_FLOATS(use->scale.v, 0, 2, 3);
    ASSERT_FLOATS(use->offset.v, 0, 0.25f, -2.5f);
    assert_int_equal(f->scene->textures[use->texture].wrap_u, CLAST_WRAP_CLAMP);
    assert_int_equal(f->scene->textures[m->normal_texture.texture].wrap_u, CLAST_WRAP_REPEAT);
    ASSERT_FLOATS(&m->normal_scale, 0, 2.5f);
}

static void roughness_and_metalness_are_packed(void **state)
{
    fixture *f = *state;
    put_pictures(f);
    const clast_material *m = load_material(f, "newmtl m\nmap_Pr grey.pfm\nmap_Pm dark.pfm\n");
    const unsigned char *pixel = image_of(f, m->metallic_roughness_texture.texture)->pixels;
    assert_int_equal(pixel[1], 128);
    assert_int_equal(pixel[2], 64);
    ASSERT_FLOATS(&m->roughness, 0, 1);
    ASSERT_FLOATS(&m->metallic, 0, 1);
    m = load_material(f, "newmtl m\nmap_Pm dark.pfm\nPr 0.5\n");
    pixel = image_of(f, m->metallic_roughness_texture.texture)->pixels;
    assert_int_equal(pixel[1], 255);
    assert_int_equal(pixel[2], 64);
}

static void an_opacity_map_becomes_alpha(void **state)
{
    fixture *f = *state;
    put_pictures(f);
    const clast_material *m = load_material(f, "newmtl m\nmap_Kd t/blue sky.pfm\nmap_d dark.pfm\n");
    const clast_image *image = image_of(f, m->base_colour_texture.texture);
    const unsigned char expected[4] = {128, 128, 255, 64};
    assert_int_equal(image->channels, 4);
    assert_memory_equal(image->pixels, expected, 4);
    assert_int_equal(m->alpha_mode, CLAST_ALPHA_BLEND);
}

static void maps_of_heights_are_no_normal_maps(void **state)
{
    fixture *f = *state;
    put_pictures(f);
    assert_int_equal(load_material(f, "newmtl m\nbump grey.pfm\n")->normal_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "heights"));
    assert_int_equal(load_material(f, "newmtl m\nbump grey.pfm\nnorm t/blue sky.pfm\n")->normal_texture.texture, 0);
}

static void missing_textures_are_warned_of(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "broken.pfm", "PF\n1 1\n-1\n\0", 12);
    const clast_material *m = load_material(f, "newmtl m\nmap_Kd nowhere.png\nmap_Ke broken.pfm\n");
    assert_int_equal(m->base_colour_texture.texture, CLAST_NONE);
    assert_int_equal(m->emissive_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "nowhere.png"));
    assert_non_null(strstr(f->log, "broken.pfm"));
}

static void wrong_lines_are_refused_with_their_number(void **state)
{
    fixture *f = *state;
    static const char *const lines[] = {"Kd", "Kd x", "Kd 1 2", "Ns", "d 1e99", "map_Kd", "map_Kd -bm 2", "newmtl"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        char library[100];
        snprintf(library, sizeof library, "newmtl m\n%s\n", lines[i]);
        put_text(f, "a.mtl", library);
        put_text(f, "a.obj", MODEL);
        assert_int_equal(load(f, "a.obj"), CLAST_ERROR_MALFORMED);
        assert_non_null(strstr(clast_context_error(f->context), "a.mtl, line 2: "));
    }
}

static void broken_libraries_do_no_harm(void **state)
{
    fixture *f = *state;
    static const char text[] =
        "newmtl m\nKd 1 0 0\nKs 1 1 1\nKe 0 0 1\nNs 10\nd 0.5\nmap_Kd -s 1 2 grey.pfm\nmap_d dark.pfm\nmap_Pr grey.pfm\nbump -bm 2 grey.pfm\n"
        "newmtl n\nKd xyz 1 2 3\nTr 0.5\nmap_Pm dark.pfm\nnorm grey.pfm\n";
    put_pictures(f);
    put_text(f, "a.obj", MODEL "usemtl m\nf 1 2 3\n");
    unsigned char copy[sizeof text];
    uint32_t random = 99;
    for (uint32_t i = 0; i < 2000; i++) {
        size_t length = i < sizeof text ? i : sizeof text - 1;
        memcpy(copy, text, sizeof text);
        for (int k = 0; i >= sizeof text && k < 2; k++) {
            random = random * 1664525u + 1013904223u;
            copy[(random >> 8) % length] = (unsigned char)(random >> 24);
        }
        memory_files_put(&f->files, "a.mtl", copy, length);
        load(f, "a.obj");
    }
    put_text(f, "a.mtl", text);
    load_without_memory(f, "a.obj");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(colours_and_numbers_are_read),
        LOADER_TEST(layers_are_read),
        LOADER_TEST(roughness_follows_the_exponent),
        LOADER_TEST(a_black_surface_with_a_coloured_gloss_is_metal),
        LOADER_TEST(values_out_of_range_are_clamped_with_a_warning),
        LOADER_TEST(each_face_has_its_material),
        LOADER_TEST(missing_libraries_are_warned_of),
        LOADER_TEST(libraries_lie_beside_the_model),
        LOADER_TEST(textures_are_read_once),
        LOADER_TEST(options_of_maps_are_heeded_or_skipped),
        LOADER_TEST(roughness_and_metalness_are_packed),
        LOADER_TEST(an_opacity_map_becomes_alpha),
        LOADER_TEST(maps_of_heights_are_no_normal_maps),
        LOADER_TEST(missing_textures_are_warned_of),
        LOADER_TEST(wrong_lines_are_refused_with_their_number),
        LOADER_TEST(broken_libraries_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
