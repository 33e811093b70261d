// SPDX-License-Identifier: Apache-2.0
// What may stand where in a glTF file: sections 3 and 5 of the specification and the extensions' own texts, as tables.
#include <math.h>

#include "load/validate.h"

#define END \
    { \
        .name = NULL \
    }
#define ANY(text) \
    { \
        .name = text, .type = CLAST_RULE_ANY \
    }
#define BOOLEAN(text) \
    { \
        .name = text, .type = CLAST_RULE_BOOLEAN \
    }
#define TEXT(text, ...) \
    { \
        .name = text, .type = CLAST_RULE_TEXT, __VA_ARGS__ \
    }
#define URI(text) \
    { \
        .name = text, .type = CLAST_RULE_URI \
    }
#define INTEGER(text, ...) \
    { \
        .name = text, .type = CLAST_RULE_INTEGER, __VA_ARGS__ \
    }
#define NUMBER(text, ...) \
    { \
        .name = text, .type = CLAST_RULE_NUMBER, __VA_ARGS__ \
    }
#define NUMBERS(text, ...) \
    { \
        .name = text, .type = CLAST_RULE_NUMBERS, __VA_ARGS__ \
    }
#define INDEX(text, to, ...) \
    { \
        .name = text, .type = CLAST_RULE_INDEX, .list = CLAST_VALIDATE_##to, __VA_ARGS__ \
    }
#define INDICES(text, to, ...) \
    { \
        .name = text, .type = CLAST_RULE_INDICES, .list = CLAST_VALIDATE_##to, __VA_ARGS__ \
    }
#define OBJECT(text, rules, ...) \
    { \
        .name = text, .type = CLAST_RULE_OBJECT, .object = &(rules), __VA_ARGS__ \
    }
#define OBJECTS(text, rules, ...) \
    { \
        .name = text, .type = CLAST_RULE_OBJECTS, .object = &(rules), __VA_ARGS__ \
    }
#define REQUIRED .is_required = true
#define RANGE(a, b) .least = (a), .most = (b)
#define UNIT RANGE(0.0, 1.0)
#define FROM(a) RANGE(a, INFINITY)
#define NOT_NEGATIVE .least = 0.0, .most = INFINITY
#define ABOVE_ZERO NOT_NEGATIVE, .excludes_least = true
#define RULES(name, ...) static const clast_rule name##_rules[] = {__VA_ARGS__, END}
#define RULED(name, ...) static const clast_rule_object name = {.rules = name##_rules, __VA_ARGS__}

// ---------------------------------------------------------------------------------------------- accessors and buffers

#define COMPONENTS "5120 5121 5122 5123 5125 5126"

RULES(sparse_indices, INDEX("bufferView", BUFFER_VIEWS, REQUIRED), INTEGER("byteOffset", NOT_NEGATIVE),
      INTEGER("componentType", REQUIRED, .choices = "5121 5123 5125"));
RULED(sparse_indices);
RULES(sparse_values, INDEX("bufferView", BUFFER_VIEWS, REQUIRED), INTEGER("byteOffset", NOT_NEGATIVE));
RULED(sparse_values);
RULES(sparse, INTEGER("count", REQUIRED, FROM(1.0)), OBJECT("indices", sparse_indices, REQUIRED),
      OBJECT("values", sparse_values, REQUIRED));
RULED(sparse);
RULES(accessor, INDEX("bufferView", BUFFER_VIEWS), INTEGER("byteOffset", NOT_NEGATIVE, .needs = "bufferView"),
      INTEGER("componentType", REQUIRED, .choices = COMPONENTS), BOOLEAN("normalized"),
      INTEGER("count", REQUIRED, FROM(1.0)), TEXT("type", REQUIRED, .choices = "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4"),
      NUMBERS("max", .lengths = {1, 2, 3, 4, 9, 16}), NUMBERS("min", .lengths = {1, 2, 3, 4, 9, 16}),
      OBJECT("sparse", sparse), TEXT("name"));
RULED(accessor, .check = clast_validate_accessor_object);
RULES(buffer, URI("uri"), INTEGER("byteLength", REQUIRED, FROM(1.0)), TEXT("name"));
RULED(buffer);
RULES(buffer_view, INDEX("buffer", BUFFERS, REQUIRED), INTEGER("byteOffset", NOT_NEGATIVE),
      INTEGER("byteLength", REQUIRED, FROM(1.0)), INTEGER("byteStride", RANGE(4.0, 252.0)),
      INTEGER("target", .choices = "34962 34963"), TEXT("name"));
RULED(buffer_view, .check = clast_validate_view_object);
#define MESHOPT_MODES "ATTRIBUTES TRIANGLES INDICES"
RULES(meshopt, INDEX("buffer", BUFFERS, REQUIRED), INTEGER("byteOffset", NOT_NEGATIVE),
      INTEGER("byteLength", REQUIRED, FROM(1.0)), INTEGER("byteStride", REQUIRED, FROM(1.0)),
      INTEGER("count", REQUIRED, FROM(1.0)), TEXT("mode", REQUIRED, .choices = MESHOPT_MODES),
      TEXT("filter", .choices = "NONE OCTAHEDRAL QUATERNION EXPONENTIAL COLOR"));
RULED(meshopt);
RULES(meshopt_buffer, BOOLEAN("fallback"));
RULED(meshopt_buffer);

// ----------------------------------------------------------------------------------------------------------- animation

RULES(channel_target, INDEX("node", NODES),
      TEXT("path", REQUIRED, .choices = "translation rotation scale weights pointer"));
RULED(channel_target, .check = clast_validate_channel_target);
RULES(pointer, TEXT("pointer", REQUIRED));
RULED(pointer, .check = clast_validate_pointer_target);
RULES(channel, INTEGER("sampler", REQUIRED, NOT_NEGATIVE), OBJECT("target", channel_target, REQUIRED));
RULED(channel);
RULES(animation_sampler, INDEX("input", ACCESSORS, REQUIRED), INDEX("output", ACCESSORS, REQUIRED),
      TEXT("interpolation", .choices = "LINEAR STEP CUBICSPLINE"));
RULED(animation_sampler);
RULES(animation, OBJECTS("channels", channel, REQUIRED), OBJECTS("samplers", animation_sampler, REQUIRED),
      TEXT("name"));
RULED(animation);

// ------------------------------------------------------------------------------------------------------------- cameras

RULES(orthographic, NUMBER("xmag", REQUIRED), NUMBER("ymag", REQUIRED), NUMBER("zfar", REQUIRED, ABOVE_ZERO),
      NUMBER("znear", REQUIRED, NOT_NEGATIVE));
RULED(orthographic, .check = clast_validate_orthographic);
RULES(perspective, NUMBER("aspectRatio", ABOVE_ZERO), NUMBER("yfov", REQUIRED, ABOVE_ZERO), NUMBER("zfar", ABOVE_ZERO),
      NUMBER("znear", REQUIRED, ABOVE_ZERO));
RULED(perspective, .check = clast_validate_perspective);
RULES(camera, OBJECT("orthographic", orthographic), OBJECT("perspective", perspective),
      TEXT("type", REQUIRED, .choices = "orthographic perspective"), TEXT("name"));
RULED(camera, .check = clast_validate_camera);

// ----------------------------------------------------------------------------------------------- textures and materials

RULES(image, URI("uri"), TEXT("mimeType", .choices = "image/jpeg image/png image/webp image/ktx2 image/vnd-ms.dds"),
      INDEX("bufferView", BUFFER_VIEWS), TEXT("name"));
RULED(image, .check = clast_validate_image_object);
#define WRAPS "10497 33071 33648"
RULES(sampler, INTEGER("magFilter", .choices = "9728 9729"),
      INTEGER("minFilter", .choices = "9728 9729 9984 9985 9986 9987"), INTEGER("wrapS", .choices = WRAPS),
      INTEGER("wrapT", .choices = WRAPS), TEXT("name"));
RULED(sampler);
RULES(texture, INDEX("sampler", SAMPLERS), INDEX("source", IMAGES), TEXT("name"));
RULED(texture);
RULES(texture_source, INDEX("source", IMAGES));
RULED(texture_source);

#define TEXTURE_RULES INDEX("index", TEXTURES, REQUIRED), INTEGER("texCoord", NOT_NEGATIVE)
RULES(texture_info, TEXTURE_RULES);
RULED(texture_info);
RULES(normal_info, TEXTURE_RULES, NUMBER("scale"));
RULED(normal_info);
RULES(occlusion_info, TEXTURE_RULES, NUMBER("strength", UNIT));
RULED(occlusion_info);
RULES(texture_transform, NUMBERS("offset", .lengths = {2}), NUMBER("rotation"), NUMBERS("scale", .lengths = {2}),
      INTEGER("texCoord", NOT_NEGATIVE));
RULED(texture_transform);

#define COLOUR(text) NUMBERS(text, .lengths = {3}, UNIT)
RULES(metallic_roughness, NUMBERS("baseColorFactor", .lengths = {4}, UNIT), OBJECT("baseColorTexture", texture_info),
      NUMBER("metallicFactor", UNIT), NUMBER("roughnessFactor", UNIT),
      OBJECT("metallicRoughnessTexture", texture_info));
RULED(metallic_roughness);
RULES(material, OBJECT("pbrMetallicRoughness", metallic_roughness), OBJECT("normalTexture", normal_info),
      OBJECT("occlusionTexture", occlusion_info), OBJECT("emissiveTexture", texture_info), COLOUR("emissiveFactor"),
      TEXT("alphaMode", .choices = "OPAQUE MASK BLEND"), NUMBER("alphaCutoff", NOT_NEGATIVE), BOOLEAN("doubleSided"),
      TEXT("name"));
RULED(material, .check = clast_validate_material);

RULES(unlit, END);
RULED(unlit);
RULES(ior, NUMBER("ior"));
RULED(ior, .check = clast_validate_ior);
RULES(clearcoat, NUMBER("clearcoatFactor", UNIT), OBJECT("clearcoatTexture", texture_info),
      NUMBER("clearcoatRoughnessFactor", UNIT), OBJECT("clearcoatRoughnessTexture", texture_info),
      OBJECT("clearcoatNormalTexture", normal_info));
RULED(clearcoat);
RULES(transmission, NUMBER("transmissionFactor", UNIT), OBJECT("transmissionTexture", texture_info));
RULED(transmission);
RULES(volume, NUMBER("thicknessFactor", NOT_NEGATIVE), OBJECT("thicknessTexture", texture_info),
      NUMBER("attenuationDistance", ABOVE_ZERO), COLOUR("attenuationColor"));
RULED(volume, .check = clast_validate_volume);
RULES(dispersion, NUMBER("dispersion", NOT_NEGATIVE));
RULED(dispersion, .check = clast_validate_dispersion);
RULES(specular, NUMBER("specularFactor", UNIT), OBJECT("specularTexture", texture_info),
      NUMBERS("specularColorFactor", .lengths = {3}, NOT_NEGATIVE), OBJECT("specularColorTexture", texture_info));
RULED(specular);
RULES(sheen, COLOUR("sheenColorFactor"), OBJECT("sheenColorTexture", texture_info),
      NUMBER("sheenRoughnessFactor", UNIT), OBJECT("sheenRoughnessTexture", texture_info));
RULED(sheen);
RULES(iridescence, NUMBER("iridescenceFactor", UNIT), OBJECT("iridescenceTexture", texture_info),
      NUMBER("iridescenceIor", FROM(1.0)), NUMBER("iridescenceThicknessMinimum", NOT_NEGATIVE),
      NUMBER("iridescenceThicknessMaximum", NOT_NEGATIVE), OBJECT("iridescenceThicknessTexture", texture_info));
RULED(iridescence);
RULES(anisotropy, NUMBER("anisotropyStrength", UNIT), NUMBER("anisotropyRotation"),
      OBJECT("anisotropyTexture", texture_info));
RULED(anisotropy, .check = clast_validate_anisotropy);
RULES(emissive_strength, NUMBER("emissiveStrength", NOT_NEGATIVE));
RULED(emissive_strength);
RULES(specular_glossiness, NUMBERS("diffuseFactor", .lengths = {4}, UNIT), OBJECT("diffuseTexture", texture_info),
      COLOUR("specularFactor"), NUMBER("glossinessFactor", UNIT), OBJECT("specularGlossinessTexture", texture_info));
RULED(specular_glossiness);
RULES(displacement, NUMBER("displacementGeometryFactor"), NUMBER("displacementGeometryOffset"),
      OBJECT("displacementGeometryTexture", texture_info));
RULED(displacement);

// -------------------------------------------------------------------------------------------------- meshes and skins

RULES(primitive, {.name = "attributes", .type = CLAST_RULE_MAP, .list = CLAST_VALIDATE_ACCESSORS, REQUIRED},
      INDEX("indices", ACCESSORS), INDEX("material", MATERIALS), INTEGER("mode", .choices = "0 1 2 3 4 5 6"),
      {.name = "targets", .type = CLAST_RULE_MAPS, .list = CLAST_VALIDATE_ACCESSORS});
RULED(primitive);
RULES(mesh, OBJECTS("primitives", primitive, REQUIRED), NUMBERS("weights"), TEXT("name"));
RULED(mesh);
RULES(skin, INDEX("inverseBindMatrices", ACCESSORS), INDEX("skeleton", NODES),
      INDICES("joints", NODES, REQUIRED, .is_distinct = true), TEXT("name"));
RULED(skin);
RULES(variant_mapping, INDEX("material", MATERIALS, REQUIRED),
      INDICES("variants", VARIANTS, REQUIRED, .is_distinct = true), TEXT("name"));
RULED(variant_mapping);
RULES(variant_mappings, OBJECTS("mappings", variant_mapping, REQUIRED));
RULED(variant_mappings, .check = clast_validate_variant_mappings);
RULES(draco, INDEX("bufferView", BUFFER_VIEWS, REQUIRED), ANY("attributes"));
RULED(draco);

// --------------------------------------------------------------------------------------------------- nodes and scenes

RULES(node, INDEX("camera", CAMERAS), INDICES("children", NODES, .is_distinct = true),
      INDEX("skin", SKINS, .needs = "mesh"), NUMBERS("matrix", .lengths = {16}), INDEX("mesh", MESHES),
      NUMBERS("rotation", .lengths = {4}, RANGE(-1.0, 1.0)), NUMBERS("scale", .lengths = {3}),
      NUMBERS("translation", .lengths = {3}), NUMBERS("weights", .needs = "mesh"), TEXT("name"));
RULED(node, .check = clast_validate_node_object);
RULES(visibility, BOOLEAN("visible"));
RULED(visibility);
RULES(instancing, {.name = "attributes", .type = CLAST_RULE_MAP, .list = CLAST_VALIDATE_ACCESSORS, REQUIRED});
RULED(instancing);
RULES(light_of_node, INDEX("light", LIGHTS, REQUIRED));
RULED(light_of_node);
RULES(scene, INDICES("nodes", NODES, .is_distinct = true), TEXT("name"));
RULED(scene);
RULES(spot, NUMBER("innerConeAngle", RANGE(0.0, 1.5707964)), NUMBER("outerConeAngle", RANGE(0.0, 1.5707964)));
RULED(spot);
RULES(light, COLOUR("color"), NUMBER("intensity", NOT_NEGATIVE), NUMBER("range", ABOVE_ZERO), OBJECT("spot", spot),
      TEXT("type", REQUIRED, .choices = "directional point spot"), TEXT("name"));
RULED(light, .check = clast_validate_light);
RULES(lights, OBJECTS("lights", light, REQUIRED));
RULED(lights);
RULES(variant, TEXT("name", REQUIRED));
RULED(variant);
RULES(variants, OBJECTS("variants", variant, REQUIRED));
RULED(variants);

// ---------------------------------------------------------------------------------------------------------- the root

RULES(asset, TEXT("copyright"), TEXT("generator"), TEXT("version", REQUIRED), TEXT("minVersion"));
RULED(asset, .check = clast_validate_asset);
RULES(root, {.name = "extensionsUsed", .type = CLAST_RULE_TEXTS, .is_distinct = true},
      {.name = "extensionsRequired", .type = CLAST_RULE_TEXTS, .is_distinct = true, .needs = "extensionsUsed"},
      OBJECTS("accessors", accessor), OBJECTS("animations", animation), OBJECT("asset", asset, REQUIRED),
      OBJECTS("buffers", buffer), OBJECTS("bufferViews", buffer_view), OBJECTS("cameras", camera),
      OBJECTS("images", image), OBJECTS("materials", material), OBJECTS("meshes", mesh), OBJECTS("nodes", node),
      OBJECTS("samplers", sampler), INDEX("scene", SCENES), OBJECTS("scenes", scene), OBJECTS("skins", skin),
      OBJECTS("textures", texture));
const clast_rule_object clast_rules_of_root = {.rules = root_rules, .check = clast_validate_extension_lists};

// Texture infos are the same object wherever an extension has them.
#define TRANSFORMS(around) \
    { \
        "KHR_texture_transform", &(around), &texture_transform \
    }
const clast_rule_extension clast_rule_extensions[] = {
    {"EXT_mesh_gpu_instancing", &node, &instancing},
    {"EXT_meshopt_compression", &buffer_view, &meshopt},
    {"EXT_meshopt_compression", &buffer, &meshopt_buffer},
    {"EXT_texture_webp", &texture, &texture_source},
    {"KHR_animation_pointer", &channel_target, &pointer},
    {"KHR_draco_mesh_compression", &primitive, &draco},
    {"KHR_lights_punctual", &clast_rules_of_root, &lights},
    {"KHR_lights_punctual", &node, &light_of_node},
    {"KHR_materials_anisotropy", &material, &anisotropy},
    {"KHR_materials_clearcoat", &material, &clearcoat},
    {"KHR_materials_dispersion", &material, &dispersion},
    {"KHR_materials_displacement", &material, &displacement},
    {"KHR_materials_emissive_strength", &material, &emissive_strength},
    {"KHR_materials_ior", &material, &ior},
    {"KHR_materials_iridescence", &material, &iridescence},
    {"KHR_materials_pbrSpecularGlossiness", &material, &specular_glossiness},
    {"KHR_materials_sheen", &material, &sheen},
    {"KHR_materials_specular", &material, &specular},
    {"KHR_materials_transmission", &material, &transmission},
    {"KHR_materials_unlit", &material, &unlit},
    {"KHR_materials_variants", &clast_rules_of_root, &variants},
    {"KHR_materials_variants", &primitive, &variant_mappings},
    {"KHR_materials_volume", &material, &volume},
    {"KHR_meshopt_compression", &buffer_view, &meshopt},
    {"KHR_meshopt_compression", &buffer, &meshopt_buffer},
    {"KHR_node_visibility", &node, &visibility},
    {"KHR_texture_basisu", &texture, &texture_source},
    TRANSFORMS(texture_info),
    TRANSFORMS(normal_info),
    TRANSFORMS(occlusion_info),
    {"MSFT_texture_dds", &texture, &texture_source},
    // extensions without objects
    {"KHR_mesh_quantization", NULL, NULL},
};
const size_t clast_rule_extension_count = sizeof clast_rule_extensions / sizeof *clast_rule_extensions;
