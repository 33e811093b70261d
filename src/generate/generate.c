// SPDX-License-Identifier: Apache-2.0
// The public entry points, and the list of scenes.
#include "clast/generate.h"

#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "generate/canyon.h"
#include "generate/cloister.h"
#include "generate/materials.h"

static const struct {
    const char *name, *text;
    clast_status (*generate)(clast_context *context, double detail, uint32_t seed, const char *folder);
} scenes[] = {
    {"canyon",
     "an old sanctuary in a desert canyon: cliffs, boulders, a colonnade and a carved ring around an armillary sphere",
     clast_generate_canyon},
    {"cloister",
     "a paved yard with carved globes, rings, logs and rough walls: a few thousand triangles under height maps of 16 bits",
     clast_generate_cloister},
    {"materials", "boards of spheres that show glTF's material extensions, each with a camera of its name",
     clast_generate_materials},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

bool clast_generate_scene(uint32_t index, const char **name, const char **text)
{
    if (index >= SCENES) {
        return false;
    }
    *name = scenes[index].name;
    *text = scenes[index].text;
    return true;
}

clast_status clast_generate(clast_context *context, const clast_generate_desc *desc, const char *path)
{
    if (context == NULL || desc == NULL || desc->scene == NULL || path == NULL || path[0] == '\0') {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    double detail = desc->detail == 0.0 ? 1.0 : desc->detail;
    if (!(detail >= 0.02 && detail <= 25.0)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "detail %g: expected 0.02 to 25", detail);
    }
    for (uint32_t i = 0; i < SCENES; i++) {
        if (strcmp(scenes[i].name, desc->scene) == 0) {
            clast_status status = clast_make_folder(context, path);
            return status == CLAST_OK ? scenes[i].generate(context, detail, desc->seed, path) : status;
        }
    }
    return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "scene \"%s\": there is none of that name; \"%s\" is one",
                      desc->scene, scenes[0].name);
}
