// SPDX-License-Identifier: Apache-2.0
#include "app/option.h"

#include <string.h>

#define CHOICE_ROW(name, value, text, ...) {text, value},
#define CHOICES(list) static const clast_choice choices_##list[] = {list(CHOICE_ROW){NULL, 0}};
CHOICES(CLAST_METRIC_LIST)
CHOICES(CLAST_FIREFLIES_LIST)
CHOICES(CLAST_INTEGRATOR_LIST)
CHOICES(CLAST_TONE_MAP_LIST)
CHOICES(CLAST_VIEW_LIST)
CHOICES(CLAST_DEVICE_LIST)
CHOICES(CLAST_ACCEL_LIST)
CHOICES(CLAST_BITS_LIST)
CHOICES(CLAST_ISA_CHOICE_LIST)

// Settings are options of both verbs that make a frame.
enum { CLAST_IN_FRAME = CLAST_IN_RENDER | CLAST_IN_EXPORT };

#define RENDER_PLACES(name) offsetof(clast_command, render.name), offsetof(clast_command, given.name)
#define RENDER_UINT(name, initial, minimum, maximum, placeholder, help) \
    {#name, CLAST_OPTION_UINT,  CLAST_IN_FRAME, initial, minimum, maximum, "", placeholder, help, \
     NULL,  RENDER_PLACES(name)},
#define RENDER_REAL(name, initial, minimum, maximum, placeholder, help) \
    {#name, CLAST_OPTION_REAL,  CLAST_IN_FRAME, initial, minimum, maximum, "", placeholder, help, \
     NULL,  RENDER_PLACES(name)},
#define RENDER_CHOICE(name, list, initial, help) \
    {#name, CLAST_OPTION_CHOICE, CLAST_IN_FRAME, initial, 0, 0, "", "NAME", help, choices_##list, RENDER_PLACES(name)},
#define RENDER_TEXT(name, initial, placeholder, help) \
    {#name, CLAST_OPTION_TEXT, CLAST_IN_FRAME, 0, 0, 0, initial, placeholder, help, NULL, RENDER_PLACES(name)},

#define PLACES(field) offsetof(clast_command, field), offsetof(clast_command, given.field##_)
#define COMMAND_UINT(verbs, field, name, initial, minimum, maximum, placeholder, help) \
    {name, CLAST_OPTION_UINT, verbs, initial, minimum, maximum, "", placeholder, help, NULL, PLACES(field)},
#define COMMAND_REAL(verbs, field, name, initial, minimum, maximum, placeholder, help) \
    {name, CLAST_OPTION_REAL, verbs, initial, minimum, maximum, "", placeholder, help, NULL, PLACES(field)},
#define COMMAND_CHOICE(verbs, field, name, list, initial, help) \
    {name, CLAST_OPTION_CHOICE, verbs, initial, 0, 0, "", "NAME", help, choices_##list, PLACES(field)},
#define COMMAND_SIZE(verbs, field, name, placeholder, help) \
    {name, CLAST_OPTION_SIZE, verbs, 0, 0, 0, "", placeholder, help, NULL, PLACES(field)},
#define COMMAND_FLAG(verbs, field, name, help) \
    {name, CLAST_OPTION_FLAG, verbs, 0, 0, 0, "", "", help, NULL, PLACES(field)},
#define COMMAND_TEXT(verbs, field, name, placeholder, help) \
    {name, CLAST_OPTION_TEXT, verbs, 0, 0, 0, "", placeholder, help, NULL, PLACES(field)},
#define COMMAND_OPTIONAL(verbs, field, name, placeholder, help) \
    {name, CLAST_OPTION_OPTIONAL, verbs, 0, 0, 0, "", placeholder, help, NULL, PLACES(field)},
#define COMMAND_RANGE(verbs, field, name, placeholder, help) \
    {name, CLAST_OPTION_RANGE, verbs, 0, 0, 0, "", placeholder, help, NULL, PLACES(field)},

const clast_option clast_options[] = {
    CLAST_RENDER_SETTING_LIST(RENDER_UINT, RENDER_REAL, RENDER_CHOICE, RENDER_TEXT)
        CLAST_COMMAND_OPTION_LIST(COMMAND_UINT, COMMAND_REAL, COMMAND_CHOICE, COMMAND_SIZE, COMMAND_FLAG, COMMAND_TEXT,
                                  COMMAND_OPTIONAL, COMMAND_RANGE)};
const size_t clast_option_count = sizeof clast_options / sizeof *clast_options;

clast_option_word clast_option_spell(const clast_option *option)
{
    clast_option_word word = {""};
    for (size_t i = 0; option->name[i] != '\0' && i + 1 < sizeof word.text; i++) {
        word.text[i] = option->name[i] != '_' ? option->name[i] : '-';
    }
    return word;
}

bool clast_option_is_for(const clast_option *option, clast_verb verb)
{
    // Settings of a render that are of the picture, not of the geometry.
    static const char *const of_picture[] = {"spp",       "bounces", "seed",       "exposure",     "tonemap", "env",
                                             "fireflies", "crop",    "time_limit", "noise_target", "min_spp"};
    for (size_t i = 0; verb == CLAST_VERB_EXPORT && i < sizeof of_picture / sizeof *of_picture; i++) {
        if (strcmp(option->name, of_picture[i]) == 0) {
            return false;
        }
    }
    return (option->verbs >> verb & 1) != 0;
}

static const char *const render_details[] = {
    "INPUT is a scene: glTF 2.0 (.gltf, .glb), Wavefront (.obj), Stanford (.ply), stereolithography (.stl) or a scene file (.json). A scene without "
    "camera gets one that sees all of it; one without light gets a sky with a sun.",
    "OUTPUT is a picture: .png or .jpg (as seen on a screen: tone map and exposure for colour, false colours for other views), .exr "
    "(layers: all views, or the one that --view names), .pfm or .hdr (linear values of one view). Without it, the name is "
    "the input's with .png, in the current folder.",
    "A setting that is not on the command line has the value of the scene file, where it has one.",
    "With --frames, a picture of each frame is written as soon as it is done: picture.0001.png and so on for picture.png. The "
    "same frame has the same picture, whichever frames were asked for.",
    "Ctrl-C ends the render and writes what there is until then, and the checkpoint; a second one ends the command at once.",
    "With --crop, the picture has the crop's size; an .exr file says where in the whole it lies, by its data and display windows.",
    NULL,
};
static const char *const generate_details[] = {
    "SCENE is one of those that --list names. OUTPUT is a folder, made where it is missing: scene.json, which names the rest, "
    "glTF files and PNG images. The same scene, detail and seed give the same files.",
    NULL,
};
static const char *const export_details[] = {
    "INPUT is any scene that render takes. OUTPUT gets the triangles of one frame, tessellated and displaced as they are rendered, with "
    "smooth normals: .gltf (with .bin and .png files beside it) or .glb with texture coordinates and materials, where instances stay "
    "instances; or .ply, one mesh in the world's coordinates. Triangles that share a point have the same bits there: what is closed stays "
    "closed.",
    "How fine the triangles are is said as for a picture: by the camera, the picture's size and the settings of tessellation. "
    "--metric length and --metric fixed do not depend on a camera.",
    NULL,
};
static const char *const info_details[] = {
    "INPUT is any file that render takes, or an image. Prints what it holds, and, for a scene, what its clusters and acceleration "
    "structures take.",
    NULL,
};
static const char *const compare_details[] = {
    "A and B are images of any type that is read. Values are those of the files, 0 to 1 for integer types. Prints the mean "
    "squared error (MSE), the peak signal-to-noise ratio for a peak of 1 (PSNR), the largest difference of a channel, and where it "
    "is. A value that is not a number in one image only is an infinite difference. FLIP is what an eye sees of the difference when "
    "B takes A's place, 0 to 1; of two float images, the largest of the exposures that suit A.",
    "ERRORS is a picture of FLIP: its values as .pfm or .exr, in false colours as .png or .jpg, black where nothing is seen.",
    "Of EXR files with layers, --layer chooses one. With --layer all, each is compared by itself, and one that only one file has makes them "
    "differ; FLIP is of the picture alone.",
    NULL,
};
static const char *const validate_details[] = {
    "INPUT is any file that render takes, or an image. Prints each fault with its severity, its code, its place and a text. Of glTF "
    "files all faults are told, in the JSON, its objects, the buffers and the images, by the codes and JSON pointers of the Khronos "
    "Group's validator; of other files the first that the reader meets.",
    NULL,
};

const clast_verb_info clast_verbs[CLAST_VERB_COUNT_] = {
    [CLAST_VERB_RENDER] = {"render", "renders a picture of a scene", "INPUT [OUTPUT]", 1, 2, render_details,
                           clast_run_render},
    [CLAST_VERB_GENERATE] = {"generate", "writes a procedural scene as files", "SCENE OUTPUT", 2, 2, generate_details,
                             clast_run_generate},
    [CLAST_VERB_INFO] = {"info", "tells what a file holds", "INPUT", 1, 1, info_details, clast_run_info},
    [CLAST_VERB_COMPARE] = {"compare", "tells how two images differ", "A B [ERRORS]", 2, 3, compare_details,
                            clast_run_compare},
    [CLAST_VERB_VALIDATE] = {"validate", "tells what is wrong with a file", "INPUT", 1, 1, validate_details,
                             clast_run_validate},
    [CLAST_VERB_EXPORT] = {"export", "writes the triangles of a frame as a model", "INPUT OUTPUT", 2, 2, export_details,
                           clast_run_export},
};
