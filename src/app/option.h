// SPDX-License-Identifier: Apache-2.0
// The command's verbs, options and exit codes: one table each, from which come the parser, every --help, the manual page and
// shell completion. The settings of a render are clast/lists.h's; this file adds what only the command knows.
#ifndef CLAST_APP_OPTION_H
#define CLAST_APP_OPTION_H

#include "clast/render.h"
#include "clast/version.h"

// X(name, value, text): the verbs.
#define CLAST_VERB_LIST(X) \
    X(CLAST_VERB_RENDER, 0, "render") \
    X(CLAST_VERB_GENERATE, 1, "generate") \
    X(CLAST_VERB_INFO, 2, "info") \
    X(CLAST_VERB_COMPARE, 3, "compare") \
    X(CLAST_VERB_VALIDATE, 4, "validate") \
    X(CLAST_VERB_EXPORT, 5, "export")

typedef enum clast_verb { CLAST_VERB_LIST(CLAST_ENUMERATOR) CLAST_VERB_COUNT_ } clast_verb;

// X(name, value, text): what the command's exit code says.
#define CLAST_EXIT_LIST(X) \
    X(CLAST_EXIT_SUCCESS, 0, "all is done; compare: the images agree; validate: the file has no error") \
    X(CLAST_EXIT_FAILURE, 1, \
      "the input or the work failed, and no file is left half written; compare: the images differ; validate: " \
      "the file has errors") \
    X(CLAST_EXIT_USAGE, 2, \
      "the command line is wrong; compare: an image could not be read, or the sizes differ; " \
      "validate: the file could not be read") \
    X(CLAST_EXIT_CANCELLED, 3, "stopped by an interrupt; what was rendered until then is written")

typedef enum clast_exit { CLAST_EXIT_LIST(CLAST_ENUMERATOR) } clast_exit;

// X(name, value, text): bits of a channel of a picture that is written.
#define CLAST_BITS_LIST(X) \
    X(CLAST_BITS_AUTOMATIC, 0, "auto") \
    X(CLAST_BITS_8, 8, "8") \
    X(CLAST_BITS_16, 16, "16") \
    X(CLAST_BITS_32, 32, "32")

typedef enum clast_bits { CLAST_BITS_LIST(CLAST_ENUMERATOR) } clast_bits;

enum {
    CLAST_IN_RENDER = 1 << CLAST_VERB_RENDER,
    CLAST_IN_GENERATE = 1 << CLAST_VERB_GENERATE,
    CLAST_IN_INFO = 1 << CLAST_VERB_INFO,
    CLAST_IN_COMPARE = 1 << CLAST_VERB_COMPARE,
    CLAST_IN_VALIDATE = 1 << CLAST_VERB_VALIDATE,
    CLAST_IN_EXPORT = 1 << CLAST_VERB_EXPORT,
    CLAST_IN_ALL = (1 << CLAST_VERB_COUNT_) - 1,
};

// The options beside the settings of a render. `verbs` says where one is taken, `field` where its value goes.
//   UINT(verbs, field, name, default, minimum, maximum, placeholder, help)
//   REAL(verbs, field, name, default, minimum, maximum, placeholder, help)
//   CHOICE(verbs, field, name, list, default, help)
//   SIZE(verbs, field, name, placeholder, help): bytes; 0 where not given
//   FLAG(verbs, field, name, help)
//   TEXT(verbs, field, name, placeholder, help): null where not given
//   OPTIONAL(verbs, field, name, placeholder, help): --name or --name=VALUE; "-" where no value is given
//   RANGE(verbs, field, name, placeholder, help): two whole numbers, as 1:24, or a single one
#define CLAST_COMMAND_OPTION_LIST(UINT, REAL, CHOICE, SIZE, FLAG, TEXT, OPTIONAL, RANGE) \
    CHOICE(CLAST_IN_RENDER, view, "view", CLAST_VIEW_LIST, CLAST_VIEW_COLOUR, \
           "what the picture shows; an .exr output holds all views as layers unless this is given") \
    CHOICE(CLAST_IN_RENDER, bits, "bits", CLAST_BITS_LIST, CLAST_BITS_AUTOMATIC, \
           "of a channel: .png has 8, or 16; .exr 32, or 16 for colours and normals") \
    TEXT(CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, chosen_scene, "scene", "SCENE", \
         "name or number of one of the scenes of a glTF file; without it, the file's default") \
    TEXT( \
        CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, variant, "variant", "VARIANT", \
        "name or number of a variant of a glTF file's materials (KHR_materials_variants); without it, those without variants") \
    UINT(CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, copies, "copies", 1, 1, 16777216, "N", \
         "repeats the scene in a square grid of N copies") \
    FLAG(CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, curved, "curved", \
         "tessellates all meshes, bent along their normals (PN triangles)") \
    UINT(CLAST_IN_EXPORT, instance, "instance", 0, 0, 4294967294u, "N", \
         "writes the instance of that number alone; without it, all that are visible") \
    FLAG(CLAST_IN_EXPORT, weld, "weld", \
         "gives each position one vertex: normals are averaged, texture coordinates and colours left out") \
    RANGE( \
        CLAST_IN_RENDER, frames, "frames", "A:B", \
        "renders frames A to B of the animation, each into a file of its own: OUTPUT with the frame's number before " \
        "the extension, or in place of %04d") \
    REAL(CLAST_IN_RENDER, fps, "fps", 24.0, 0.001, 100000.0, "N", \
         "frames a second: frame F of --frames shows the moment F / N") \
    TEXT( \
        CLAST_IN_RENDER, checkpoint, "checkpoint", "FILE", \
        "keeps what the picture has come to, so that --resume goes on; written at each interval, an interrupt and the end") \
    REAL(CLAST_IN_RENDER, checkpoint_interval, "checkpoint-interval", 300.0, 0.001, 1e9, "SECONDS", \
         "between two writes of --checkpoint") \
    TEXT(CLAST_IN_RENDER, resume, "resume", "FILE", \
         "goes on from a checkpoint: the picture is that of a render that was not interrupted; --spp may be more") \
    REAL(CLAST_IN_GENERATE, detail, "detail", 1.0, 0.02, 25.0, "FACTOR", \
         "scales the number of triangles; 1 is about a million") \
    UINT(CLAST_IN_GENERATE, generate_seed, "seed", 0, 0, 4294967295u, "N", "seed of the random numbers") \
    FLAG(CLAST_IN_GENERATE, list, "list", "lists the scenes that there are, and does nothing else") \
    FLAG(CLAST_IN_INFO, no_cook, "no-cook", "only reads the file: no clusters, no acceleration structures") \
    REAL(CLAST_IN_COMPARE, max_mse, "max-mse", 0.0, 0.0, 1e30, "X", "largest mean squared error of images that agree") \
    REAL(CLAST_IN_COMPARE, max_difference, "max-difference", 0.0, 0.0, 1e30, "X", \
         "largest difference of a channel of images that agree; without both bounds, 0: equal images") \
    REAL(CLAST_IN_COMPARE, max_flip, "max-flip", 0.0, 0.0, 1.0, "X", \
         "largest mean of FLIP, the difference that an eye sees, 0 to 1, of images that agree") \
    TEXT(CLAST_IN_COMPARE, layer, "layer", "LAYER", \
         "layer of two EXR files that is compared, as N or depth's Z; all: each layer, of which all must agree") \
    REAL(CLAST_IN_COMPARE, pixels_per_degree, "pixels-per-degree", 67.0206433, 1.0, 10000.0, "N", \
         "of the viewer's sight, for FLIP; the default is a 4K monitor as far away as it is wide") \
    OPTIONAL(CLAST_IN_ALL & ~CLAST_IN_GENERATE, json, "json", "FILE", \
             "writes one JSON object of results and statistics into FILE, or on standard output") \
    UINT(CLAST_IN_ALL, threads, "threads", 0, 0, 1024, "N", "threads that work; 0 is one for each processor") \
    CHOICE(CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, isa, "isa", CLAST_ISA_CHOICE_LIST, 0, \
           "instruction set of the kernels; auto is the best that the machine has; all give the same picture") \
    SIZE(CLAST_IN_ALL, memory, "memory", "BYTES", \
         "most memory that clast may hold at a time, as 4G or 512M; 0 is no bound") \
    TEXT(CLAST_IN_RENDER | CLAST_IN_INFO | CLAST_IN_EXPORT, cache_dir, "cache-dir", "FOLDER", \
         "where what took long to cook is kept for the next run; without it, nothing is") \
    FLAG(CLAST_IN_ALL, quiet, "quiet", "prints errors only") \
    FLAG(CLAST_IN_ALL, help, "help", "prints this text")

#define CLAST_ISA_CHOICE_LIST(X) \
    X(CLAST_ISA_AUTOMATIC, 0, "auto") \
    CLAST_ISA_LIST(X)

enum { CLAST_POSITIONALS_MOST = 3 };

// From first to last.
typedef struct clast_range {
    uint32_t first, last;
} clast_range;

// What a command line asks for.
typedef struct clast_command {
    clast_verb verb;
    const char *positionals[CLAST_POSITIONALS_MOST]; // null where left out
    clast_render_settings render;                    // zero where not given
#define CLAST_FIELD_UINT(verbs, field, ...) uint32_t field;
#define CLAST_FIELD_REAL(verbs, field, ...) double field;
#define CLAST_FIELD_SIZE(verbs, field, ...) uint64_t field;
#define CLAST_FIELD_FLAG(verbs, field, ...) bool field;
#define CLAST_FIELD_TEXT(verbs, field, ...) const char *field;
#define CLAST_FIELD_RANGE(verbs, field, ...) clast_range field;
    CLAST_COMMAND_OPTION_LIST(CLAST_FIELD_UINT, CLAST_FIELD_REAL, CLAST_FIELD_UINT, CLAST_FIELD_SIZE, CLAST_FIELD_FLAG,
                              CLAST_FIELD_TEXT, CLAST_FIELD_TEXT, CLAST_FIELD_RANGE)
    struct { // which options were on the command line
#define CLAST_GIVEN(name, ...) bool name;
        CLAST_RENDER_SETTING_LIST(CLAST_GIVEN, CLAST_GIVEN, CLAST_GIVEN, CLAST_GIVEN)
#define CLAST_GIVEN_FIELD(verbs, field, ...) bool field##_;
        CLAST_COMMAND_OPTION_LIST(CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD,
                                  CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD, CLAST_GIVEN_FIELD)
    } given;
} clast_command;

typedef enum clast_option_type {
    CLAST_OPTION_UINT,
    CLAST_OPTION_REAL,
    CLAST_OPTION_CHOICE,
    CLAST_OPTION_TEXT,
    CLAST_OPTION_SIZE,
    CLAST_OPTION_FLAG,
    CLAST_OPTION_OPTIONAL,
    CLAST_OPTION_RANGE,
} clast_option_type;

typedef struct clast_choice {
    const char *text;
    uint32_t value;
} clast_choice;

// A row of the table of options.
typedef struct clast_option {
    const char *name; // without the two dashes; see clast_option_spell
    clast_option_type type;
    uint32_t verbs; // CLAST_IN_ bits
    double default_number, minimum, maximum;
    const char *default_text;
    const char *placeholder;
    const char *help;
    const clast_choice *choices; // ends with a null text
    size_t offset;               // of the value in clast_command
    size_t given_offset;
} clast_option;

// A row of the table of verbs.
typedef struct clast_verb_info {
    const char *name;
    const char *summary;
    const char *positionals; // as the usage line has them
    uint32_t positionals_least, positionals_most;
    const char *const *details; // paragraphs; ends with null
    clast_exit (*run)(const clast_command *command);
} clast_verb_info;

// An option's name as it is written: with dashes for underscores.
typedef struct clast_option_word {
    char text[32];
} clast_option_word;

extern const clast_option clast_options[];
extern const size_t clast_option_count;
extern const clast_verb_info clast_verbs[CLAST_VERB_COUNT_];

clast_option_word clast_option_spell(const clast_option *option);
bool clast_option_is_for(const clast_option *option, clast_verb verb);

// The verbs' work, each in a file of its own.
clast_exit clast_run_render(const clast_command *command);
clast_exit clast_run_generate(const clast_command *command);
clast_exit clast_run_info(const clast_command *command);
clast_exit clast_run_compare(const clast_command *command);
clast_exit clast_run_export(const clast_command *command);
clast_exit clast_run_validate(const clast_command *command);

// Fills `command` from the arguments after the verb; prints one line on standard error and gives false where they are wrong.
bool clast_command_parse(clast_verb verb, int count, char *const *arguments, clast_command *command);
// The verb of that name; false, after one line on standard error, where there is none.
bool clast_verb_find(const char *name, clast_verb *verb);

// help.c: each prints on standard output.
void clast_help_overview(void);
void clast_help_verb(clast_verb verb);
void clast_help_manual(void);
void clast_help_completion(void);

#endif
