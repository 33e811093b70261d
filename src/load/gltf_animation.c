// SPDX-License-Identifier: Apache-2.0
// Animations (section 3.11). Key frames that the file holds as floats are used where they lie.
#include <stdio.h>
#include <string.h>

#include "load/gltf.h"

#define FLOAT CLAST_GLTF_BIT(CLAST_GLTF_FLOAT)
#define INTEGER \
    (CLAST_GLTF_BIT(CLAST_GLTF_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_SHORT) | CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_BYTE) | \
     CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_SHORT))

static const char *const ANIMATED[] = {
#define NAME(name, value, text) [value] = text,
    CLAST_ANIMATED_LIST(NAME)};
static const char *const INTERPOLATIONS[] = {CLAST_INTERPOLATION_LIST(NAME)};
#undef NAME
enum {
    ANIMATED_COUNT = sizeof ANIMATED / sizeof *ANIMATED,
    INTERPOLATION_COUNT = sizeof INTERPOLATIONS / sizeof *INTERPOLATIONS,
};

// ------------------------------------------------------------------------------------------------------- what moves

static bool any_targets(clast_gltf *gltf)
{
    for (uint32_t i = 0; i < clast_gltf_size(&gltf->lists[CLAST_GLTF_MESHES]); i++) {
        clast_gltf_value mesh = clast_gltf_entry(gltf, CLAST_GLTF_MESHES, i);
        clast_gltf_value primitives = clast_gltf_array(gltf, &mesh, "primitives");
        clast_gltf_value first = clast_gltf_element(&primitives, 0);
        if (!clast_gltf_ok(gltf) || json_object_get(first.json, "targets") != NULL ||
            json_object_get(mesh.json, "weights") != NULL) {
            return clast_gltf_ok(gltf);
        }
    }
    return false;
}

// Notes the node whose weights a channel moves. What is wrong with the channel is said when it is read.
static void note_weights(clast_gltf *gltf, const json_t *channel)
{
    const json_t *target = json_object_get(channel, "target"), *node = json_object_get(target, "node");
    const char *path = json_string_value(json_object_get(target, "path"));
    json_int_t number = json_is_number(node) ? (json_int_t)json_number_value(node) : -1;
    if (path != NULL && strcmp(path, ANIMATED[CLAST_ANIMATED_WEIGHTS]) == 0 && number >= 0 &&
        (uint64_t)number < clast_gltf_size(&gltf->lists[CLAST_GLTF_NODES])) {
        gltf->weights_move[number] = true;
    }
}

bool clast_gltf_find_motion(clast_gltf *gltf, bool *moves)
{
    size_t count = clast_gltf_size(&gltf->lists[CLAST_GLTF_ANIMATIONS]);
    *moves = count != 0 || clast_gltf_size(&gltf->lists[CLAST_GLTF_SKINS]) != 0 || any_targets(gltf);
    for (size_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value animation = clast_gltf_entry(gltf, CLAST_GLTF_ANIMATIONS, (uint32_t)i);
        const json_t *channels = json_object_get(animation.json, "channels");
        for (size_t k = 0; k < json_array_size(channels); k++) {
            note_weights(gltf, json_array_get(channels, k));
        }
    }
    return clast_gltf_ok(gltf);
}

// ------------------------------------------------------------------------------------------------------- key frames

// The elements of an accessor as floats, kept by the scene; null on failure.
static const float *read_keys(clast_gltf *gltf, const clast_gltf_value *place, uint32_t components, uint32_t rows,
                              uint64_t *count)
{
    clast_gltf_accessor accessor;
    uint32_t index = place->json != NULL ? clast_gltf_value_index(gltf, place, CLAST_GLTF_ACCESSORS) : CLAST_NONE;
    if (place->json == NULL) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place, "missing: expected an accessor");
    }
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, place, index, &accessor) ||
        !clast_gltf_accessor_is(gltf, place, &accessor, components, 1, rows)) {
        return NULL;
    }
    *count = accessor.count;
    accessor.normalised = accessor.component != CLAST_GLTF_FLOAT;
    const float *floats = accessor.component == CLAST_GLTF_FLOAT ? clast_gltf_borrow(gltf, &accessor) : NULL;
    if (floats != NULL || !clast_gltf_ok(gltf)) {
        return floats;
    }
    bool fits = clast_gltf_account(gltf, place, accessor.count, rows * sizeof(float));
    float *block = fits ? clast_allocate(gltf->context, accessor.count, rows * sizeof *block) : NULL;
    if (block == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    clast_gltf_read_floats(&accessor, 0, accessor.count, block);
    return clast_gltf_check(gltf, clast_scene_keep_block(gltf->scene, block)) ? block : NULL;
}

// A sampler of an animation, read when first asked for.
typedef struct sampler {
    bool is_read;
    uint32_t rows; // of its values' elements
    clast_interpolation interpolation;
    const float *times, *values;
    uint64_t time_count, value_count;
} sampler;

static uint32_t find_text(const char *const *texts, uint32_t count, const char *text)
{
    uint32_t i = 0;
    while (i < count && strcmp(texts[i], text) != 0) {
        i++;
    }
    return i;
}

static bool read_sampler(clast_gltf *gltf, const clast_gltf_value *value, clast_animated animated, sampler *made)
{
    clast_gltf_value input = clast_gltf_member(value, "input"), output = clast_gltf_member(value, "output");
    const char *text = clast_gltf_text(gltf, value, "interpolation");
    uint32_t interpolation = find_text(INTERPOLATIONS, INTERPOLATION_COUNT, text != NULL ? text : INTERPOLATIONS[0]);
    bool takes_integers = animated == CLAST_ANIMATED_ROTATION || animated == CLAST_ANIMATED_WEIGHTS;
    uint32_t rows = animated == CLAST_ANIMATED_ROTATION ? 4 : animated == CLAST_ANIMATED_WEIGHTS ? 1 : 3;
    if (clast_gltf_ok(gltf) && interpolation == INTERPOLATION_COUNT) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value,
                        "interpolation \"%.40s\": expected LINEAR, STEP or CUBICSPLINE", text);
    }
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    *made = (sampler){.is_read = true, .rows = rows, .interpolation = (clast_interpolation)interpolation};
    made->times = read_keys(gltf, &input, FLOAT, 1, &made->time_count);
    made->values = made->times != NULL
                       ? read_keys(gltf, &output, takes_integers ? FLOAT | INTEGER : FLOAT, rows, &made->value_count)
                       : NULL;
    return made->values != NULL;
}

// --------------------------------------------------------------------------------------------------------- channels

// Which node's what a channel moves; false where it moves nothing here, or on failure.
static bool read_target(clast_gltf *gltf, const clast_gltf_value *channel, clast_channel *made)
{
    clast_gltf_value target = clast_gltf_object(gltf, channel, "target");
    const char *path = clast_gltf_text(gltf, &target, "path");
    uint32_t node = clast_gltf_index(gltf, &target, "node", CLAST_GLTF_NODES);
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (path != NULL && strcmp(path, "pointer") == 0) {
        clast_gltf_warn(gltf, channel, "KHR_animation_pointer is not followed");
        return false;
    }
    uint32_t animated = find_text(ANIMATED, ANIMATED_COUNT, path != NULL ? path : "");
    if (animated == ANIMATED_COUNT) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &target,
                               "path \"%.40s\": expected translation, rotation, scale or weights",
                               path != NULL ? path : "");
    }
    if (node == CLAST_NONE) { // left to extensions (section 3.11)
        return false;
    }
    made->node = gltf->node_numbers[node];
    made->animated = (clast_animated)animated;
    if (animated == CLAST_ANIMATED_WEIGHTS && gltf->scene->motion.nodes[made->node].weight_count == 0) {
        clast_gltf_warn(gltf, channel, "node %u shows no morph targets: left out", node);
        return false;
    }
    return true;
}

static bool read_channel(clast_gltf *gltf, const clast_gltf_value *list, const clast_gltf_value *channel,
                         sampler *samplers, clast_channel *made)
{
    size_t sampler_count = clast_gltf_size(list);
    uint64_t index = clast_gltf_integer(gltf, channel, "sampler", 0, sampler_count != 0 ? sampler_count - 1 : 0,
                                        CLAST_GLTF_REQUIRED);
    if (clast_gltf_ok(gltf) && sampler_count == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, channel, "sampler: the animation has none");
    }
    if (!clast_gltf_ok(gltf) || !read_target(gltf, channel, made)) {
        return false;
    }
    clast_gltf_value value = clast_gltf_element_object(gltf, list, (size_t)index);
    sampler *from = &samplers[index];
    if (!clast_gltf_ok(gltf) || (!from->is_read && !read_sampler(gltf, &value, made->animated, from))) {
        return false;
    }
    uint64_t width = made->animated == CLAST_ANIMATED_WEIGHTS ? gltf->scene->motion.nodes[made->node].weight_count : 1;
    uint64_t values = width * (from->interpolation == CLAST_INTERPOLATION_CUBICSPLINE ? 3 : 1);
    uint32_t rows = made->animated == CLAST_ANIMATED_ROTATION ? 4 : made->animated == CLAST_ANIMATED_WEIGHTS ? 1 : 3;
    if (from->rows != rows || from->value_count != from->time_count * values) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value,
                               "output: %llu elements of %u numbers: expected %llu of %u for %llu key frames",
                               (unsigned long long)from->value_count, from->rows,
                               (unsigned long long)(from->time_count * values), rows,
                               (unsigned long long)from->time_count);
    }
    made->interpolation = from->interpolation;
    made->key_count = (uint32_t)from->time_count;
    made->times = from->times;
    made->values = from->values;
    return true;
}

// What the scene finds wrong is the file's fault.
static void blame_file(clast_gltf *gltf, const clast_gltf_value *animation, clast_status status)
{
    if (status == CLAST_ERROR_INVALID_ARGUMENT) {
        char what[256];
        snprintf(what, sizeof what, "%s", clast_context_error(gltf->context));
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, animation, "%s", what);
    }
    clast_gltf_check(gltf, status);
}

static void read_animation(clast_gltf *gltf, const clast_gltf_value *animation, bool is_first)
{
    clast_gltf_value samplers = clast_gltf_array(gltf, animation, "samplers"),
                     channels = clast_gltf_array(gltf, animation, "channels");
    const char *name = clast_gltf_text(gltf, animation, "name");
    size_t count = clast_gltf_size(&channels), kept = 0;
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    sampler *read = clast_allocate_zeroed(gltf->context, clast_gltf_size(&samplers), sizeof *read);
    clast_channel *made = read != NULL ? clast_allocate(gltf->context, count, sizeof *made) : NULL;
    if (made == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    for (size_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value channel = clast_gltf_element_object(gltf, &channels, i);
        kept += clast_gltf_ok(gltf) && read_channel(gltf, &samplers, &channel, read, &made[kept]);
    }
    uint32_t number;
    if (clast_gltf_ok(gltf)) {
        blame_file(gltf, animation, clast_scene_adopt_animation(gltf->scene, made, kept, is_first, name, &number));
    }
    clast_free(gltf->context, made);
    clast_free(gltf->context, read);
}

void clast_gltf_read_animations(clast_gltf *gltf)
{
    for (uint32_t i = 0; i < clast_gltf_size(&gltf->lists[CLAST_GLTF_ANIMATIONS]) && clast_gltf_ok(gltf); i++) {
        clast_gltf_value animation = clast_gltf_entry(gltf, CLAST_GLTF_ANIMATIONS, i);
        if (clast_gltf_ok(gltf)) {
            read_animation(gltf, &animation, i == 0);
        }
    }
}
