// SPDX-License-Identifier: Apache-2.0
// What material extensions of glTF files become.
#include "gltf_fixture.h"

#define SURFACE(extensions) \
    "{" ASSET "," BUFFER(36) "," MESH( \
        "'material':0,'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}]," \
                                                    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]," \
                                                    "'materials':[{'extensions':{" extensions \
                                                    "}}],'nodes':[{'mesh':0}]}"

static const clast_material *read_material(fixture *f, const char *text)
{
    put_triangle(f);
    assert_loads(f, text);
    assert_int_equal(f->scene->material_count, 2);
    return &f->scene->materials[1].record;
}

static void layers_are_off_by_default(void **state)
{
    const clast_material *m = read_material(*state, SURFACE("'KHR_materials_sheen':{},'KHR_materials_clearcoat':{},"
                                                            "'KHR_materials_volume':{},'KHR_materials_iridescence':{},"
                                                            "'KHR_materials_dispersion':{},"
                                                            "'KHR_materials_diffuse_transmission':{},"
                                                            "'KHR_materials_transmission':{}"));
    assert_int_equal(m->layers, 0);
    assert_float_equal(m->ior, 1.5f, 0.0f);
    assert_float_equal(m->iridescence_ior, 1.3f, 0.0f);
    assert_float_equal(m->iridescence_thickness_minimum, 100.0f, 0.0f);
    assert_float_equal(m->iridescence_thickness_maximum, 400.0f, 0.0f);
    assert_floats(m->diffuse_transmission_colour.v, (float[]){1, 1, 1}, 3, 0.0f);
}

static void coats_fuzz_and_specular_layers_are_read(void **state)
{
    const clast_material *m = read_material(
        *state, SURFACE("'KHR_materials_sheen':{'sheenColorFactor':[0.1,0.2,0.3],'sheenRoughnessFactor':0.4},"
                        "'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'clearcoatRoughnessFactor':0.6},"
                        "'KHR_materials_specular':{'specularFactor':0.7,'specularColorFactor':[1,2,3]},"
                        "'KHR_materials_ior':{'ior':1.8},"
                        "'KHR_materials_anisotropy':{'anisotropyStrength':0.9}"));
    assert_int_equal(m->layers, MATERIAL_SHEEN | MATERIAL_CLEARCOAT | MATERIAL_SPECULAR | MATERIAL_ANISOTROPY);
    assert_floats(m->sheen_colour.v, (float[]){0.1f, 0.2f, 0.3f}, 3, 1e-6f);
    assert_float_equal(m->sheen_roughness, 0.4f, 1e-6f);
    assert_float_equal(m->clearcoat, 0.5f, 1e-6f);
    assert_float_equal(m->clearcoat_roughness, 0.6f, 1e-6f);
    assert_float_equal(m->specular, 0.7f, 1e-6f);
    assert_floats(m->specular_colour.v, (float[]){1, 2, 3}, 3, 0.0f);
    assert_float_equal(m->ior, 1.8f, 1e-6f);
    assert_float_equal(m->anisotropy, 0.9f, 1e-6f);
}

static void what_passes_is_read(void **state)
{
    const clast_material *m = read_material(
        *state, SURFACE("'KHR_materials_transmission':{'transmissionFactor':0.5},"
                        "'KHR_materials_volume':{'thicknessFactor':2,'attenuationDistance':3,"
                        "'attenuationColor':[0.5,0.25,1]},"
                        "'KHR_materials_dispersion':{'dispersion':0.4},"
                        "'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor':0.3,"
                        "'diffuseTransmissionColorFactor':[0.2,0.4,0.6]}"));
    assert_int_equal(m->layers, MATERIAL_TRANSMISSION | MATERIAL_DIFFUSE_TRANSMISSION);
    assert_float_equal(m->transmission, 0.5f, 0.0f);
    assert_float_equal(m->thickness, 2.0f, 0.0f);
    assert_float_equal(m->absorption.v[0], 0.693147f / 3.0f, 1e-5f);
    assert_float_equal(m->absorption.v[2], 0.0f, 1e-6f);
    assert_float_equal(m->dispersion, 0.4f, 1e-6f);
    assert_float_equal(m->diffuse_transmission, 0.3f, 1e-6f);
    assert_floats(m->diffuse_transmission_colour.v, (float[]){0.2f, 0.4f, 0.6f}, 3, 1e-6f);
}

static void films_are_read(void **state)
{
    const clast_material *m = read_material(
        *state, SURFACE("'KHR_materials_iridescence':{'iridescenceFactor':0.8,'iridescenceIor':1.7,"
                        "'iridescenceThicknessMinimum':50,'iridescenceThicknessMaximum':700}"));
    assert_int_equal(m->layers, MATERIAL_IRIDESCENCE);
    assert_float_equal(m->iridescence, 0.8f, 1e-6f);
    assert_float_equal(m->iridescence_ior, 1.7f, 1e-6f);
    assert_float_equal(m->iridescence_thickness_minimum, 50.0f, 0.0f);
    assert_float_equal(m->iridescence_thickness_maximum, 700.0f, 0.0f);
}

static void broken_layers_are_refused(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    const char *place = "materials[0].extensions.KHR_materials_";
    assert_refused(f, SURFACE("'KHR_materials_iridescence':{'iridescenceIor':0.5}"), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, SURFACE("'KHR_materials_dispersion':{'dispersion':-1}"), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, SURFACE("'KHR_materials_diffuse_transmission':{'diffuseTransmissionFactor':2}"),
                   CLAST_ERROR_MALFORMED, place);
    assert_refused(f, SURFACE("'KHR_materials_ior':{'ior':0.5}"), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, SURFACE("'KHR_materials_iridescence':{'iridescenceTexture':{'index':0}}"), CLAST_ERROR_MALFORMED,
                   place);
}

int main(void)
{

    const struct CMUnitTest tests[] = {
        GLTF_TEST(layers_are_off_by_default), GLTF_TEST(coats_fuzz_and_specular_layers_are_read),
        GLTF_TEST(what_passes_is_read),       GLTF_TEST(films_are_read),
        GLTF_TEST(broken_layers_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
