// SPDX-License-Identifier: Apache-2.0
// Nodes, cameras, lights, materials and textures of glTF files.
#include "gltf_fixture.h"

#include <float.h>
#include <math.h>

static const float HALF_TURN = 3.14159265f;

#define TRIANGLE_PARTS \
    BUFFER(36) \
    "," MESH( \
        "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]"
#define NODES(scenes, nodes) "{" ASSET "," TRIANGLE_PARTS "," scenes ",'nodes':[" nodes "]}"
#define SCENE_OF(list) "'scene':0,'scenes':[{'nodes':[" list "]}]"

static void assert_transform(const fixture *f, size_t instance, const float expected[12])
{
    assert_true(instance < f->scene->instance_count);
    assert_floats(f->scene->instances[instance].to_world.rows[0].v, expected, 12, 1e-5f);
}

// --------------------------------------------------------------------------------------------------------------- nodes

static void translation_rotation_and_scale_are_composed(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    // A quarter turn about z, after a scale; then the translation.
    assert_loads(f, NODES(SCENE_OF("0"),
                          "{'mesh':0,'translation':[1,2,3],'rotation':[0,0,0.70710678,0.70710678],'scale':[2,3,-4]}"));
    assert_transform(f, 0, (float[]){0, -3, 0, 1, 2, 0, 0, 2, 0, 0, -4, 3});
    assert_loads(f, NODES(SCENE_OF("0"), "{'mesh':0,'rotation':[0,0,10,10]}")); // made unit length
    assert_transform(f, 0, (float[]){0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0});
}

static void a_matrix_is_column_major(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, NODES(SCENE_OF("0"), "{'mesh':0,'matrix':[1,2,3,0,4,5,6,0,7,8,9,0,10,11,12,1]}"));
    assert_transform(f, 0, (float[]){1, 4, 7, 10, 2, 5, 8, 11, 3, 6, 9, 12});
}

static void transforms_go_down_the_tree(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, NODES(SCENE_OF("2"), "{'mesh':0,'translation':[1,0,0]},{'children':[0],'scale':[2,2,2],'mesh':0},"
                                         "{'children':[1],'translation':[0,5,0]}"));
    assert_int_equal(f->scene->instance_count, 2);
    assert_transform(f, 0, (float[]){2, 0, 0, 0, 0, 2, 0, 5, 0, 0, 2, 0});
    assert_transform(f, 1, (float[]){2, 0, 0, 2, 0, 2, 0, 5, 0, 0, 2, 0});
}

static void children_are_visited_in_order(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(
        f,
        NODES(SCENE_OF("0"),
              "{'children':[3,1]},{'mesh':0,'name':'c'},{'mesh':0,'name':'b'},{'mesh':0,'name':'a','children':[2]}"));
    assert_string_equal(f->scene->instances[0].name, "a");
    assert_string_equal(f->scene->instances[1].name, "b");
    assert_string_equal(f->scene->instances[2].name, "c");
}

static void a_deep_chain_is_no_deep_stack(void **state)
{
    fixture *f = *state;
    enum { DEPTH = 20000 };
    put_triangle(f);
    char *text = malloc(DEPTH * 64);
    assert_non_null(text);
    size_t length = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
    for (int i = 0; i + 1 < DEPTH; i++) {
        length += (size_t)sprintf(text + length, "{\"children\":[%d],\"translation\":[1,0,0]},", i + 1);
    }
    length += (size_t)sprintf(
        text + length,
        "{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}]}");
    memory_files_put(&f->files, "deep.gltf", text, length);
    assert_ok(f->context, load_file(f, "deep.gltf"));
    assert_float_equal(f->scene->cameras[0].desc.position[0], DEPTH - 1, 0.0f);
    free(text);
}

static void the_default_scene_is_drawn(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    const char *nodes = "{'mesh':0,'name':'a'},{'mesh':0,'name':'b'},{'children':[1]}";
    char text[2048];
    const struct {
        const char *scenes, *first;
        size_t count;
    } cases[] = {
        {"'scene':1,'scenes':[{'nodes':[0]},{'nodes':[2]}]", "b", 1},
        {"'scenes':[{'nodes':[0]},{'nodes':[2]}]", "a", 1}, // without `scene` the first
        {"'scenes':[]", "a", 2},                            // without scenes all roots
        {"'scenes':[{'nodes':[2,0]}]", "b", 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(text, sizeof text, "{" ASSET "," TRIANGLE_PARTS ",%s,'nodes':[%s]}", cases[i].scenes, nodes);
        assert_loads(f, text);
        assert_int_equal(f->scene->instance_count, cases[i].count);
        assert_string_equal(f->scene->instances[0].name, cases[i].first);
    }
    snprintf(text, sizeof text, "{" ASSET "," TRIANGLE_PARTS ",'scene':2,'scenes':[{'nodes':[0]}],'nodes':[%s]}",
             nodes);
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "scene: 2: expected the index of one of the 1 scenes");
}

static void what_is_no_forest_is_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[0]}]}", CLAST_ERROR_MALFORMED, "nodes[0]: is below itself");
    assert_refused(f, "{" ASSET ",'nodes':[{},{'children':[3]},{'children':[1]},{'children':[2]}]}",
                   CLAST_ERROR_MALFORMED, "is below itself");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[2]},{'children':[2]},{}]}", CLAST_ERROR_MALFORMED,
                   "nodes[1].children[0]: node 2 is a child of node 0 too");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[1,1]},{}]}", CLAST_ERROR_MALFORMED,
                   "nodes[0].children[1]: node 1");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[1]}]}", CLAST_ERROR_MALFORMED, "nodes[0].children[0]: 1");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[-1]}]}", CLAST_ERROR_MALFORMED, "nodes[0].children[0]: -1");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':{}}]}", CLAST_ERROR_MALFORMED, "nodes[0].children: an object");
    assert_refused(f, "{" ASSET ",'nodes':[{'children':[1]},{}]," SCENE_OF("1") "}", CLAST_ERROR_MALFORMED,
                   "scenes[0].nodes[0]: node 1");
    assert_refused(f, "{" ASSET ",'nodes':[{},{}]," SCENE_OF("1,1") "}", CLAST_ERROR_MALFORMED,
                   "scenes[0].nodes[1]: node 1");
    assert_refused(f, "{" ASSET ",'nodes':[{}]," SCENE_OF("5") "}", CLAST_ERROR_MALFORMED, "scenes[0].nodes[0]: 5");
}

static void broken_transforms_are_refused(void **state)
{
    fixture *f = *state;
#define ONE(node) "{" ASSET ",'nodes':[" node "]}"
    assert_refused(f, ONE("{'translation':[1,2]}"), CLAST_ERROR_MALFORMED,
                   "nodes[0].translation: 2 elements: expected 3");
    assert_refused(f, ONE("{'scale':[1,2,'x']}"), CLAST_ERROR_MALFORMED,
                   "nodes[0].scale[2]: a text: expected a number");
    assert_refused(f, ONE("{'scale':[1,2,1e39]}"), CLAST_ERROR_MALFORMED, "nodes[0].scale[2]: 1e+39");
    assert_refused(f, ONE("{'rotation':[0,0,0,0]}"), CLAST_ERROR_MALFORMED, "nodes[0].rotation: zero");
    assert_refused(f, ONE("{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}"), CLAST_ERROR_MALFORMED,
                   "nodes[0].matrix: the last row");
    assert_refused(f, ONE("{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],'scale':[1,1,1]}"), CLAST_ERROR_MALFORMED,
                   "both matrix and");
    assert_refused(f, ONE("{'scale':[1e30,1,1],'children':[1]},{'scale':[1e30,1,1]}"), CLAST_ERROR_MALFORMED,
                   "nodes[1]: the transform");
}

static void instances_by_attributes_are_placed(void **state)
{
    fixture *f = *state;
    float data[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, /* translations */ 1, 2, 3, 4, 5, 6, /* scales */ 2, 2, 2, 1, 1, 1};
    memory_files_put(&f->files, "data.bin", data, sizeof data);
    const char *text = "{" ASSET "," BUFFER(84) "," MESH(
        "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':84}],"
                                       "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
                                       "{'bufferView':0,'byteOffset':36,'componentType':5126,'count':2,'type':'VEC3'},"
                                       "{'bufferView':0,'byteOffset':60,'componentType':5126,'count':%d,'type':'VEC3'}]," SCENE_OF(
                                           "0") ",'nodes':[{'mesh':0,'scale':[10,10,10],"
                                                "'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1,'SCALE':2}}}}]}";
    char exact[2048];
    snprintf(exact, sizeof exact, text, 2);
    assert_loads(f, exact);
    assert_int_equal(f->scene->instance_count, 2);
    assert_transform(f, 0, (float[]){20, 0, 0, 10, 0, 20, 0, 20, 0, 0, 20, 30});
    assert_transform(f, 1, (float[]){10, 0, 0, 40, 0, 10, 0, 50, 0, 0, 10, 60});
    snprintf(exact, sizeof exact, text, 1);
    assert_refused(f, exact, CLAST_ERROR_MALFORMED, "attributes.SCALE: 1 elements: expected 2");
}

// ----------------------------------------------------------------------------------------------------- cameras, lights

#define CAMERA(camera, node) "{" ASSET ",'cameras':[" camera "],'nodes':[{'camera':0" node "}]}"

static void cameras_look_along_their_nodes(void **state)
{
    fixture *f = *state;
    assert_loads(f,
                 CAMERA("{'type':'perspective','perspective':{'yfov':0.7,'znear':0.01,'zfar':100,'aspectRatio':2}}",
                        ",'name':'eye','translation':[1,2,3],'rotation':[0,0.70710678,0,0.70710678],'scale':[5,5,5]"));
    const clast_camera_desc *camera = &f->scene->cameras[0].desc;
    assert_int_equal(camera->projection, CLAST_PROJECTION_PERSPECTIVE);
    assert_floats(camera->position, (float[]){1, 2, 3}, 3, 0.0f);
    float direction[3], expected[3] = {-1, 0, 0}, length = 0.0f;
    for (int i = 0; i < 3; i++) {
        direction[i] = camera->target[i] - camera->position[i];
        length += direction[i] * direction[i];
    }
    for (int i = 0; i < 3; i++) {
        direction[i] /= sqrtf(length);
    }
    assert_floats(direction, expected, 3, 1e-6f);
    assert_floats(camera->up, (float[]){0, 1, 0}, 3, 1e-6f);
    assert_float_equal(camera->vertical_angle, 0.7f, 0.0f);
    assert_float_equal(camera->near_plane, 0.01f, 0.0f);
    assert_float_equal(camera->far_plane, 100.0f, 0.0f);
    assert_string_equal(f->scene->cameras[0].name, "eye");
}

static void an_orthographic_camera_has_a_height(void **state)
{
    fixture *f = *state;
    assert_loads(
        f, CAMERA("{'name':'plan','type':'orthographic','orthographic':{'xmag':3,'ymag':2,'znear':0,'zfar':9}}", ""));
    assert_int_equal(f->scene->cameras[0].desc.projection, CLAST_PROJECTION_ORTHOGRAPHIC);
    assert_float_equal(f->scene->cameras[0].desc.height, 4.0f, 0.0f);
    assert_string_equal(f->scene->cameras[0].name, "plan");
}

static void a_far_camera_still_has_a_direction(void **state)
{
    fixture *f = *state;
    assert_loads(f, CAMERA("{'type':'perspective','perspective':{'yfov':1,'znear':1}}", ",'translation':[0,0,1e12]"));
    assert_true(f->scene->cameras[0].desc.target[2] < f->scene->cameras[0].desc.position[2]);
}

static void broken_cameras_are_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, CAMERA("{'type':'fisheye'}", ""), CLAST_ERROR_MALFORMED, "cameras[0]: type \"fisheye\"");
    assert_refused(f, CAMERA("{}", ""), CLAST_ERROR_MALFORMED, "cameras[0]: type");
    assert_refused(f, CAMERA("{'type':'perspective'}", ""), CLAST_ERROR_MALFORMED, "cameras[0].perspective: missing");
    assert_refused(f, CAMERA("{'type':'perspective','perspective':{'yfov':0,'znear':1}}", ""), CLAST_ERROR_MALFORMED,
                   "perspective.yfov: 0");
    assert_refused(f, CAMERA("{'type':'perspective','perspective':{'yfov':4,'znear':1}}", ""), CLAST_ERROR_MALFORMED,
                   "perspective.yfov: 4");
    assert_refused(f, CAMERA("{'type':'perspective','perspective':{'yfov':1,'znear':-1}}", ""), CLAST_ERROR_MALFORMED,
                   "perspective.znear: -1");
    assert_refused(f, CAMERA("{'type':'orthographic','orthographic':{'ymag':0}}", ""), CLAST_ERROR_MALFORMED,
                   "orthographic: ymag");
    assert_refused(f, "{" ASSET ",'nodes':[{'camera':0}]}", CLAST_ERROR_MALFORMED,
                   "nodes[0].camera: 0: the file has no cameras");
    assert_loads(f, CAMERA("{'type':'perspective','perspective':{'yfov':1,'znear':1}}", ",'scale':[0,0,0]"));
    assert_int_equal(f->scene->camera_count, 0);
    assert_non_null(strstr(f->log, "left out"));
}

#define LIGHT(light, node) \
    "{" ASSET ",'extensionsUsed':['KHR_lights_punctual'],'extensions':{'KHR_lights_punctual':{'lights':[" light "]}}," \
    "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}" node "}]}"

static void lights_shine_along_their_nodes(void **state)
{
    fixture *f = *state;
    assert_loads(
        f,
        LIGHT(
            "{'type':'spot','color':[1,0.5,0],'intensity':10,'range':7,'spot':{'innerConeAngle':0.25,'outerConeAngle':0.5}}",
            ",'translation':[1,2,3],'rotation':[0.70710678,0,0,0.70710678],'name':'lamp'"));
    const clast_light *light = &f->scene->lights[0].record;
    assert_int_equal(light->type, CLAST_LIGHT_SPOT);
    assert_floats(light->position.v, (float[]){1, 2, 3}, 3, 0.0f);
    assert_floats(light->direction.v, (float[]){0, 1, 0}, 3, 1e-6f);
    assert_floats(light->radiance.v, (float[]){10, 5, 0}, 3, 0.0f);
    assert_float_equal(light->range, 7.0f, 0.0f);
    assert_float_equal(light->inner_cosine, cosf(0.25f), 1e-6f);
    assert_float_equal(light->outer_cosine, cosf(0.5f), 1e-6f);
    assert_string_equal(f->scene->lights[0].name, "lamp");
}

static void lights_have_defaults(void **state)
{
    fixture *f = *state;
    assert_loads(f, LIGHT("{'type':'spot'}", ""));
    assert_floats(f->scene->lights[0].record.radiance.v, (float[]){1, 1, 1}, 3, 0.0f);
    assert_float_equal(f->scene->lights[0].record.range, 0.0f, 0.0f);
    assert_float_equal(f->scene->lights[0].record.inner_cosine, 1.0f, 0.0f);
    assert_float_equal(f->scene->lights[0].record.outer_cosine, cosf(HALF_TURN / 4.0f), 1e-6f);
    assert_loads(f, LIGHT("{'type':'point'}", ""));
    assert_int_equal(f->scene->lights[0].record.type, CLAST_LIGHT_POINT);
    assert_loads(f, LIGHT("{'type':'directional'}", ""));
    assert_int_equal(f->scene->lights[0].record.type, CLAST_LIGHT_DIRECTIONAL);
    assert_floats(f->scene->lights[0].record.direction.v, (float[]){0, 0, -1}, 3, 0.0f);
}

static void broken_lights_are_refused(void **state)
{
    fixture *f = *state;
    const char *place = "extensions.KHR_lights_punctual.lights[0]";
    assert_refused(f, LIGHT("{'type':'laser'}", ""), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("{}", ""), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("{'type':'point','intensity':-1}", ""), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("{'type':'point','color':[1,1]}", ""), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("{'type':'spot','spot':{'outerConeAngle':2}}", ""), CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("{'type':'spot','spot':{'innerConeAngle':1,'outerConeAngle':0.5}}", ""),
                   CLAST_ERROR_MALFORMED, place);
    assert_refused(f, LIGHT("", ""), CLAST_ERROR_MALFORMED, "the file has no lights");
    assert_refused(f,
                   "{" ASSET ",'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},"
                   "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':1}}}]}",
                   CLAST_ERROR_MALFORMED, "nodes[0].extensions.KHR_lights_punctual.light: 1");
}

// ----------------------------------------------------------------------------------------------------------- materials

// The triangle with texture coordinates and a material. A picture of one pixel is in pixel.png.
#define SURFACE(material, more) \
    "{" ASSET "," NODE "," BUFFER(36) "," MESH( \
        "'material':0,'attributes':{'POSITION':0,'NORMAL':0,'TEXCOORD_0':1,'TEXCOORD_1':1," \
        "'TEXCOORD_2':1,'TEXCOORD_3':2}") ",'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126," \
                                          "'count':3,'type':'VEC3'},{'bufferView':0,'componentType':5126,'count':3,'type':'VEC2'},{'bufferView':0,'byteOffset':12," \
                                          "'componentType':5126,'count':3,'type':'VEC2'}],'materials':[" material \
                                          "]" more "}"
#define PIXEL ",'images':[{'uri':'pixel.png','name':'pixel'}],'textures':[{'source':0}]"

// A grey pixel as a PNG file of 8 bits, written out by hand.
static const unsigned char PIXEL_PNG[] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81,
    0x77, 0xcd, 0x72, 0xb6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
};

static const clast_material *material_of(const fixture *f)
{
    assert_int_equal(f->scene->material_count, 2);
    assert_int_equal(mesh_of(f, 0)->material, 1);
    return &f->scene->materials[1].record;
}

static void a_material_has_the_defaults_of_the_format(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, SURFACE("{}", ""));
    const clast_material *material = material_of(f);
    assert_floats(material->base_colour.v, (float[]){1, 1, 1, 1}, 4, 0.0f);
    assert_floats(material->emissive.v, (float[]){0, 0, 0}, 3, 0.0f);
    assert_float_equal(material->metallic, 1.0f, 0.0f);
    assert_float_equal(material->roughness, 1.0f, 0.0f);
    assert_float_equal(material->normal_scale, 1.0f, 0.0f);
    assert_float_equal(material->occlusion_strength, 1.0f, 0.0f);
    assert_float_equal(material->alpha_cutoff, 0.5f, 0.0f);
    assert_int_equal(material->alpha_mode, CLAST_ALPHA_OPAQUE);
    assert_int_equal(material->double_sided, 0);
    assert_int_equal(material->base_colour_texture.texture, CLAST_NONE);
}

static void the_factors_of_a_material_are_read(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(
        f,
        SURFACE(
            "{'name':'brass','pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.5,'roughnessFactor':0.6},"
            "'emissiveFactor':[1,2,3],'alphaMode':'MASK','alphaCutoff':0.7,'doubleSided':true,"
            "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':2}}}",
            ""));
    const clast_material *material = material_of(f);
    assert_floats(material->base_colour.v, (float[]){0.1f, 0.2f, 0.3f, 0.4f}, 4, 0.0f);
    assert_floats(material->emissive.v, (float[]){2, 4, 6}, 3, 0.0f);
    assert_float_equal(material->metallic, 0.5f, 0.0f);
    assert_float_equal(material->roughness, 0.6f, 0.0f);
    assert_float_equal(material->alpha_cutoff, 0.7f, 0.0f);
    assert_int_equal(material->alpha_mode, CLAST_ALPHA_MASK);
    assert_int_equal(material->double_sided, 1);
    assert_string_equal(f->scene->materials[1].name, "brass");
    assert_loads(f, SURFACE("{'alphaMode':'BLEND'}", ""));
    assert_int_equal(material_of(f)->alpha_mode, CLAST_ALPHA_BLEND);
}

static void all_five_textures_are_read(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
    assert_loads(
        f,
        SURFACE(
            "{'pbrMetallicRoughness':{'baseColorTexture':{'index':0},'metallicRoughnessTexture':{'index':1,'texCoord':1}},"
            "'normalTexture':{'index':2,'scale':0.5},'occlusionTexture':{'index':3,'strength':0.25},'emissiveTexture':{'index':4}}",
            ",'images':[{'uri':'pixel.png'}],'textures':[{'source':0},{'source':0},{'source':0},{'source':0},{'source':0}]"));
    const clast_material *material = material_of(f);
    assert_int_equal(f->scene->image_count, 1);
    assert_int_equal(f->scene->texture_count, 5);
    assert_int_equal(material->base_colour_texture.texture, 0);
    assert_int_equal(material->metallic_roughness_texture.texture, 1);
    assert_int_equal(material->metallic_roughness_texture.coordinate_set, 1);
    assert_int_equal(material->normal_texture.texture, 2);
    assert_int_equal(material->occlusion_texture.texture, 3);
    assert_int_equal(material->emissive_texture.texture, 4);
    assert_float_equal(material->normal_scale, 0.5f, 0.0f);
    assert_float_equal(material->occlusion_strength, 0.25f, 0.0f);
    assert_string_equal(f->scene->images[0].name, "pixel.png");
    assert_non_null(mesh_of(f, 0)->tangents); // derived for the normal map
}

static void samplers_are_read(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
#define SAMPLER(sampler) \
    SURFACE("{'emissiveTexture':{'index':0}}", \
            ",'images':[{'uri':'pixel.png'}],'textures':[{'source':0,'sampler':0}]," \
            "'samplers':[" sampler "]")
    assert_loads(f, SAMPLER("{'wrapS':33071,'wrapT':33648,'magFilter':9728,'minFilter':9987}"));
    assert_int_equal(f->scene->textures[0].wrap_u, CLAST_WRAP_CLAMP);
    assert_int_equal(f->scene->textures[0].wrap_v, CLAST_WRAP_MIRROR);
    assert_int_equal(f->scene->textures[0].filter, CLAST_FILTER_NEAREST);
    assert_loads(f, SAMPLER("{}"));
    assert_int_equal(f->scene->textures[0].wrap_u, CLAST_WRAP_REPEAT);
    assert_int_equal(f->scene->textures[0].wrap_v, CLAST_WRAP_REPEAT);
    assert_int_equal(f->scene->textures[0].filter, CLAST_FILTER_LINEAR);
    assert_refused(f, SAMPLER("{'wrapS':1}"), CLAST_ERROR_MALFORMED, "samplers[0].wrapS: 1");
    assert_refused(f, SAMPLER("{'magFilter':9987}"), CLAST_ERROR_MALFORMED, "samplers[0].magFilter: 9987");
}

static void a_texture_transform_is_read(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
    assert_loads(f, SURFACE("{'emissiveTexture':{'index':0,'texCoord':0,'extensions':{'KHR_texture_transform':"
                            "{'offset':[0.5,0.25],'scale':[2,3],'rotation':1.5,'texCoord':1}}}}",
                            PIXEL));
    const clast_texture_use *use = &material_of(f)->emissive_texture;
    assert_floats(use->offset.v, (float[]){0.5f, 0.25f}, 2, 0.0f);
    assert_floats(use->scale.v, (float[]){2, 3}, 2, 0.0f);
    assert_float_equal(use->rotation, 1.5f, 0.0f);
    assert_int_equal(use->coordinate_set, 1);
}

// Slots with transforms of their own, told by their offsets.
#define TURNED(name, offset) \
    "'" name "':{'index':0,'extensions':{'KHR_texture_transform':{'offset':[" #offset \
    ",0.5],'scale':[2,3],'rotation':0.25,'texCoord':1}}}"
#define TURNED_BASE TURNED("baseColorTexture", 1) "," TURNED("metallicRoughnessTexture", 2)
#define TURNED_MAPS TURNED("normalTexture", 3) "," TURNED("occlusionTexture", 4)
#define TURNED_LIGHT TURNED("emissiveTexture", 5)
#define TURNED_SPECULAR TURNED("specularTexture", 6) "," TURNED("specularColorTexture", 7)
#define TURNED_COAT TURNED("clearcoatTexture", 8) "," TURNED("clearcoatRoughnessTexture", 9)
#define TURNED_COAT_NORMAL TURNED("clearcoatNormalTexture", 10)
#define TURNED_SHEEN TURNED("sheenColorTexture", 11) "," TURNED("sheenRoughnessTexture", 12)
#define TURNED_STRETCH TURNED("anisotropyTexture", 13)
#define TURNED_GLASS TURNED("transmissionTexture", 14)
#define TURNED_SURFACE \
    "{'pbrMetallicRoughness':{" TURNED_BASE "}," TURNED_MAPS "," TURNED_LIGHT ",'extensions':{" \
    "'KHR_materials_specular':{" TURNED_SPECULAR "}," \
    "'KHR_materials_clearcoat':{" TURNED_COAT "," TURNED_COAT_NORMAL "}," \
    "'KHR_materials_sheen':{" TURNED_SHEEN "}," \
    "'KHR_materials_anisotropy':{" TURNED_STRETCH "}," \
    "'KHR_materials_transmission':{" TURNED_GLASS "}}}"

static void every_slot_has_a_transform_of_its_own(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
    assert_loads(f, SURFACE(TURNED_SURFACE, PIXEL));
    const clast_material *m = material_of(f);
    const clast_texture_use *uses[] = {
        &m->base_colour_texture,      &m->metallic_roughness_texture, &m->normal_texture,
        &m->occlusion_texture,        &m->emissive_texture,           &m->specular_texture,
        &m->specular_colour_texture,  &m->clearcoat_texture,          &m->clearcoat_roughness_texture,
        &m->clearcoat_normal_texture, &m->sheen_colour_texture,       &m->sheen_roughness_texture,
        &m->anisotropy_texture,       &m->transmission_texture,
    };
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++) {
        assert_int_equal(uses[i]->texture, 0);
        assert_int_equal(uses[i]->coordinate_set, 1);
        assert_floats(uses[i]->offset.v, (float[]){(float)i + 1.0f, 0.5f}, 2, 0.0f);
        assert_floats(uses[i]->scale.v, (float[]){2.0f, 3.0f}, 2, 0.0f);
        assert_float_equal(uses[i]->rotation, 0.25f, 0.0f);
    }
}

static void later_coordinate_sets_take_the_two_places(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
    assert_loads(
        f, SURFACE("{'normalTexture':{'index':0,'texCoord':3},'emissiveTexture':{'index':0,'texCoord':1}}", PIXEL));
    const clast_material *material = material_of(f);
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(material->normal_texture.coordinate_set, 0);
    assert_int_equal(material->emissive_texture.coordinate_set, 1);
    assert_floats(mesh->coordinates[0], TRIANGLE + 3, 6, 0.0f); // set 3
    assert_floats(mesh->coordinates[1], TRIANGLE, 6, 0.0f);     // set 1
    assert_refused(
        f,
        SURFACE(
            "{'normalTexture':{'index':0,'texCoord':3},'emissiveTexture':{'index':0,'texCoord':1},'occlusionTexture':{'index':0}}",
            PIXEL),
        CLAST_ERROR_LIMIT, "materials[0]: 3 sets of texture coordinates");
}

static void images_come_from_views_and_data_uris(void **state)
{
    fixture *f = *state;
    unsigned char data[36 + sizeof PIXEL_PNG];
    memcpy(data, TRIANGLE, 36);
    memcpy(data + 36, PIXEL_PNG, sizeof PIXEL_PNG);
    memory_files_put(&f->files, "data.bin", data, sizeof data);
    assert_int_equal(sizeof PIXEL_PNG, 67);
    assert_loads(
        f,
        "{" ASSET "," NODE "," BUFFER(103) "," MESH(
            "'material':0,'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,"
                                                        "'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':67}],'accessors':[{'bufferView':0,'componentType':5126,"
                                                        "'count':3,'type':'VEC3'}],'materials':[{'emissiveTexture':{'index':0}}],'textures':[{'source':0}],"
                                                        "'images':[{'bufferView':1,'mimeType':'image/png'}]}");
    assert_int_equal(f->scene->image_count, 1);
    assert_int_equal(f->scene->images[0].image.width, 1);
    put_triangle(f);
    assert_loads(
        f, SURFACE("{'emissiveTexture':{'index':0}}",
                   ",'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,"
                   "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg=='}]"));
    assert_int_equal(f->scene->image_count, 1);
}

static void images_that_no_material_uses_are_not_opened(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, SURFACE("{}", ",'images':[{'uri':'gone.png'}],'textures':[{'source':0}]"));
    assert_int_equal(f->scene->image_count, 0);
}

static void broken_images_and_textures_are_refused(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
    memory_files_put(&f->files, "cut.png", PIXEL_PNG, 40);
#define GLOWING(more) SURFACE("{'emissiveTexture':{'index':0}}", more)
    assert_refused(f, GLOWING(""), CLAST_ERROR_MALFORMED,
                   "materials[0].emissiveTexture.index: 0: the file has no textures");
    assert_refused(f, GLOWING(",'textures':[{'source':0}]"), CLAST_ERROR_MALFORMED,
                   "textures[0].source: 0: the file has no images");
    assert_refused(f, GLOWING(",'textures':[{'source':0}],'images':[{}]"), CLAST_ERROR_MALFORMED,
                   "images[0]: expected either a uri or a bufferView");
    assert_refused(f, GLOWING(",'textures':[{'source':0}],'images':[{'uri':'pixel.png','bufferView':0}]"),
                   CLAST_ERROR_MALFORMED, "images[0]");
    assert_refused(f, GLOWING(",'textures':[{'source':0}],'images':[{'uri':'gone.png'}]"), CLAST_ERROR_FILE_NOT_FOUND,
                   "images[0].uri: \"gone.png\"");
    assert_refused(f, GLOWING(",'textures':[{'source':0}],'images':[{'uri':'cut.png'}]"), CLAST_ERROR_MALFORMED,
                   "images[0] (cut.png)");
    assert_refused(f, GLOWING(",'textures':[{'source':0,'sampler':0}],'images':[{'uri':'pixel.png'}]"),
                   CLAST_ERROR_MALFORMED, "textures[0].sampler: 0");
    assert_refused(f, SURFACE("{'emissiveTexture':{}}", PIXEL), CLAST_ERROR_MALFORMED,
                   "materials[0].emissiveTexture: no index");
    assert_refused(f, SURFACE("{'emissiveTexture':{'index':0,'texCoord':-1}}", PIXEL), CLAST_ERROR_MALFORMED,
                   "emissiveTexture.texCoord: -1");
}

static void compressed_images_keep_their_blocks(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    uint8_t file[136] = {'D', 'D', 'S', ' ', 124};
    file[12] = file[16] = 4; // texels
    file[76] = 32;
    file[80] = 4;
    memcpy(file + 84, "DXT1", 4);
    memcpy(file + 128, "\x01\x02\x03\x04\x05\x06\x07\x08", 8);
    memory_files_put(&f->files, "picture.dds", file, sizeof file);
    assert_loads(
        f, GLOWING(",'textures':[{'extensions':{'MSFT_texture_dds':{'source':0}}}],'images':[{'uri':'picture.dds'}]"));
    assert_int_equal(f->scene->image_count, 1);
    const clast_image_blocks *blocks = &f->scene->images[0].blocks;
    assert_int_equal(blocks->format, CLAST_BLOCK_BC1);
    assert_int_equal(blocks->bytes, 8);
    assert_memory_equal(blocks->data, file + 128, 8);
}

static void an_image_of_an_unknown_type_is_left_out_with_a_word(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    memory_files_put(&f->files, "picture.xyz", "no picture of any kind", 22);
    assert_loads(f, GLOWING(",'textures':[{'source':0}],'images':[{'uri':'picture.xyz'}]"));
    assert_int_equal(material_of(f)->emissive_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "images[0] (picture.xyz)"));
    assert_loads(f, GLOWING(",'textures':[{'extensions':{'KHR_texture_basisu':{'source':0}}}]"));
    assert_int_equal(material_of(f)->emissive_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "KHR_texture_basisu"));
}

static void broken_materials_are_refused(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_refused(f, SURFACE("{'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,2]}}", ""), CLAST_ERROR_MALFORMED,
                   "materials[0].pbrMetallicRoughness.baseColorFactor[3]: 2: expected a number from 0 to 1");
    assert_refused(f, SURFACE("{'pbrMetallicRoughness':{'metallicFactor':-1}}", ""), CLAST_ERROR_MALFORMED,
                   "metallicFactor: -1");
    assert_refused(f, SURFACE("{'pbrMetallicRoughness':{'roughnessFactor':'x'}}", ""), CLAST_ERROR_MALFORMED,
                   "roughnessFactor: a text");
    assert_refused(f, SURFACE("{'pbrMetallicRoughness':[]}", ""), CLAST_ERROR_MALFORMED,
                   "materials[0].pbrMetallicRoughness: an array");
    assert_refused(f, SURFACE("{'alphaMode':'GLASS'}", ""), CLAST_ERROR_MALFORMED, "materials[0].alphaMode: \"GLASS\"");
    assert_refused(f, SURFACE("{'alphaCutoff':-1}", ""), CLAST_ERROR_MALFORMED, "materials[0].alphaCutoff: -1");
    assert_refused(f, SURFACE("{'doubleSided':1}", ""), CLAST_ERROR_MALFORMED, "materials[0].doubleSided: a number");
    assert_refused(f, SURFACE("{'emissiveFactor':[-1,0,0]}", ""), CLAST_ERROR_MALFORMED, "emissiveFactor[0]: -1");
    assert_refused(
        f,
        SURFACE(
            "{'emissiveFactor':[1e38,0,0],'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':1e38}}}",
            ""),
        CLAST_ERROR_MALFORMED, "is not finite");
    assert_refused(f, "{" ASSET "," NODE "," MESH("'material':3,'attributes':{'POSITION':0}") "}",
                   CLAST_ERROR_MALFORMED, "primitives[0].material: 3: the file has no materials");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(translation_rotation_and_scale_are_composed),
        GLTF_TEST(a_matrix_is_column_major),
        GLTF_TEST(transforms_go_down_the_tree),
        GLTF_TEST(children_are_visited_in_order),
        GLTF_TEST(a_deep_chain_is_no_deep_stack),
        GLTF_TEST(the_default_scene_is_drawn),
        GLTF_TEST(what_is_no_forest_is_refused),
        GLTF_TEST(broken_transforms_are_refused),
        GLTF_TEST(instances_by_attributes_are_placed),
        GLTF_TEST(cameras_look_along_their_nodes),
        GLTF_TEST(an_orthographic_camera_has_a_height),
        GLTF_TEST(a_far_camera_still_has_a_direction),
        GLTF_TEST(broken_cameras_are_refused),
        GLTF_TEST(lights_shine_along_their_nodes),
        GLTF_TEST(lights_have_defaults),
        GLTF_TEST(broken_lights_are_refused),
        GLTF_TEST(a_material_has_the_defaults_of_the_format),
        GLTF_TEST(the_factors_of_a_material_are_read),
        GLTF_TEST(all_five_textures_are_read),
        GLTF_TEST(samplers_are_read),
        GLTF_TEST(a_texture_transform_is_read),
        GLTF_TEST(every_slot_has_a_transform_of_its_own),
        GLTF_TEST(later_coordinate_sets_take_the_two_places),
        GLTF_TEST(images_come_from_views_and_data_uris),
        GLTF_TEST(images_that_no_material_uses_are_not_opened),
        GLTF_TEST(broken_images_and_textures_are_refused),
        GLTF_TEST(compressed_images_keep_their_blocks),
        GLTF_TEST(an_image_of_an_unknown_type_is_left_out_with_a_word),
        GLTF_TEST(broken_materials_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
