// SPDX-License-Identifier: Apache-2.0
// Which scene and which variant of the materials (KHR_materials_variants) are wanted.
#include <stdio.h>
#include <string.h>

#include "load/gltf.h"
#include "load/number.h"

// Lists the names that there are, for an error.
static void list_names(const clast_gltf_value *list, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (size_t i = 0; i < clast_gltf_size(list) && length + 80 < size; i++) {
        clast_gltf_value entry = clast_gltf_element(list, i);
        const char *name = json_string_value(json_object_get(entry.json, "name"));
        length += (size_t)snprintf(text + length, size - length, "%s%zu%s%.40s", i > 0 ? ", " : "", i,
                                   name != NULL ? " " : "", name != NULL ? name : "");
    }
}

// An entry by its name, or by its number where none has that name; CLAST_NONE, with an error, where there is none.
static uint32_t find_entry(clast_gltf *gltf, const clast_gltf_value *list, const char *wanted, const char *what)
{
    size_t count = clast_gltf_size(list);
    for (size_t i = 0; i < count; i++) {
        clast_gltf_value entry = clast_gltf_element(list, i);
        const char *name = json_string_value(json_object_get(entry.json, "name"));
        if (name != NULL && strcmp(name, wanted) == 0) {
            return (uint32_t)i;
        }
    }
    int64_t number;
    const char *end = wanted + strlen(wanted), *next;
    if (clast_parse_integer(wanted, end, &number, &next) && next == end && number >= 0 && (uint64_t)number < count) {
        return (uint32_t)number;
    }
    char names[400];
    list_names(list, names, sizeof names);
    clast_gltf_fail(gltf, CLAST_ERROR_INVALID_ARGUMENT, NULL, "no %s \"%.80s\": there %s %s", what, wanted,
                    count == 0 ? "is" : "are", count == 0 ? "none" : names);
    return CLAST_NONE;
}

void clast_gltf_choose(clast_gltf *gltf)
{
    const clast_scene_choice *choice = &gltf->scene->choice;
    clast_gltf_value extensions;
    clast_gltf_value holder = clast_gltf_extension(gltf, &gltf->root, &extensions, "KHR_materials_variants");
    clast_gltf_value variants = clast_gltf_array(gltf, &holder, "variants");
    gltf->chosen_scene = clast_gltf_index(gltf, &gltf->root, "scene", CLAST_GLTF_SCENES);
    gltf->chosen_variant = CLAST_NONE;
    if (clast_gltf_ok(gltf) && choice->scene != NULL) {
        gltf->chosen_scene = find_entry(gltf, &gltf->lists[CLAST_GLTF_SCENES], choice->scene, "scene");
    }
    if (clast_gltf_ok(gltf) && choice->variant != NULL) {
        gltf->chosen_variant = find_entry(gltf, &variants, choice->variant, "variant");
    }
}

// Whether a mapping is for the chosen variant.
static bool is_for_variant(clast_gltf *gltf, const clast_gltf_value *mapping)
{
    clast_gltf_value variants = clast_gltf_array(gltf, mapping, "variants");
    for (size_t i = 0; i < clast_gltf_size(&variants); i++) {
        clast_gltf_value element = clast_gltf_element(&variants, i);
        if (json_is_number(element.json) && json_number_value(element.json) == (double)gltf->chosen_variant) {
            return true;
        }
    }
    return false;
}

uint32_t clast_gltf_primitive_material(clast_gltf *gltf, const clast_gltf_value *primitive)
{
    clast_gltf_value extensions;
    clast_gltf_value holder = clast_gltf_extension(gltf, primitive, &extensions, "KHR_materials_variants");
    clast_gltf_value mappings = clast_gltf_array(gltf, &holder, "mappings");
    for (size_t i = 0; gltf->chosen_variant != CLAST_NONE && i < clast_gltf_size(&mappings); i++) {
        clast_gltf_value mapping = clast_gltf_element_object(gltf, &mappings, i);
        if (clast_gltf_ok(gltf) && is_for_variant(gltf, &mapping)) {
            return clast_gltf_index(gltf, &mapping, "material", CLAST_GLTF_MATERIALS);
        }
    }
    return clast_gltf_index(gltf, primitive, "material", CLAST_GLTF_MATERIALS);
}
