// SPDX-License-Identifier: Apache-2.0
// Animations of a scene, and how its nodes stand at a moment. glTF 2.0, section 3.11 and appendix C. Nothing here is left to
// the transcendental functions of a library, which differ between machines: the same moment has the same bits everywhere.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/size.h"
#include "scene/scene.h"

enum { VALUES_OF_CUBIC = 3 };

// How many numbers a key's value has.
static size_t channel_width(const clast_motion *motion, const clast_channel *channel)
{
    switch (channel->animated) {
    case CLAST_ANIMATED_TRANSLATION:
    case CLAST_ANIMATED_SCALE: return 3;
    case CLAST_ANIMATED_ROTATION: return 4;
    case CLAST_ANIMATED_WEIGHTS: return motion->nodes[channel->node].weight_count;
    }
    return 0;
}

static bool is_cubic(const clast_channel *channel)
{
    return channel->interpolation == CLAST_INTERPOLATION_CUBICSPLINE;
}

// ----------------------------------------------------------------------------------------------------------- adding

static const char *find_fault(const clast_motion *motion, const clast_channel *channel)
{
    if (channel->node >= motion->node_count) {
        return "the node is not there";
    }
    if ((unsigned)channel->animated > CLAST_ANIMATED_WEIGHTS ||
        (unsigned)channel->interpolation > CLAST_INTERPOLATION_CUBICSPLINE) {
        return "what it animates, or the interpolation, is none of the list";
    }
    const clast_scene_node *node = &motion->nodes[channel->node];
    if (channel->animated == CLAST_ANIMATED_WEIGHTS ? node->weight_count == 0 : node->has_matrix) {
        return channel->animated == CLAST_ANIMATED_WEIGHTS ? "the node has no weights" : "the node has a matrix";
    }
    if (channel->key_count == 0 || channel->times == NULL || channel->values == NULL) {
        return "expected a key at least, with its time and value";
    }
    float before = -1.0f;
    for (size_t i = 0; i < channel->key_count; i++) {
        if (!(channel->times[i] >= 0.0f && channel->times[i] > before) || !is_finite1(channel->times[i])) {
            return "the times of its keys do not ascend from 0 on";
        }
        before = channel->times[i];
    }
    size_t count = channel->key_count * channel_width(motion, channel) * (is_cubic(channel) ? VALUES_OF_CUBIC : 1);
    for (size_t i = 0; i < count; i++) {
        if (!is_finite1(channel->values[i])) {
            return "a value is not finite";
        }
    }
    return NULL;
}

static clast_status check_channels(const clast_scene *scene, const clast_channel *channels, size_t count)
{
    clast_context *context = scene->context;
    uint8_t *seen = clast_allocate_zeroed(context, scene->motion.node_count, sizeof *seen); // a bit for each property
    if (seen == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < count && status == CLAST_OK; i++) {
        const char *fault = find_fault(&scene->motion, &channels[i]);
        uint8_t bit = fault == NULL ? (uint8_t)(1u << channels[i].animated) : 0;
        if (fault == NULL && (seen[channels[i].node] & bit) != 0) {
            fault = "a channel before it moves the same of the same node";
        }
        if (fault != NULL) {
            status = clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "channel %zu: %s", i, fault);
        } else {
            seen[channels[i].node] |= bit;
        }
    }
    clast_free(context, seen);
    return status;
}

clast_status clast_scene_adopt_animation(clast_scene *scene, const clast_channel *channels, size_t count, bool is_first,
                                         const char *name, uint32_t *number)
{
    clast_context *context = scene->context;
    clast_motion *motion = &scene->motion;
    clast_status status = check_channels(scene, channels, count);
    if (status == CLAST_OK && motion->animation_count >= CLAST_ANIMATION_FIRST) {
        status = clast_fail(context, CLAST_ERROR_LIMIT, "a scene holds at most %u animations", CLAST_ANIMATION_FIRST);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, motion->animations, motion->animation_capacity, motion->animation_count + 1);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_scene_animation added = {.channel_count = count, .is_first = is_first};
    added.channels = clast_allocate(context, count, sizeof *added.channels);
    added.name = name != NULL && name[0] != '\0' && added.channels != NULL ? clast_copy_text(context, name) : NULL;
    if (added.channels == NULL || (name != NULL && name[0] != '\0' && added.name == NULL)) {
        clast_free(context, added.channels);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (count != 0) {
        memcpy(added.channels, channels, count * sizeof *channels);
    }
    for (size_t i = 0; i < count; i++) {
        added.length = fmax(added.length, (double)channels[i].times[channels[i].key_count - 1]);
    }
    *number = (uint32_t)motion->animation_count;
    motion->animations[motion->animation_count++] = added;
    return CLAST_OK;
}

// How many floats the arrays of channels hold; false where that is too much to be told.
static bool count_floats(const clast_motion *motion, const clast_channel *channels, size_t count, size_t *floats)
{
    *floats = 0;
    for (size_t i = 0; i < count; i++) {
        size_t width = channel_width(motion, &channels[i]) * (is_cubic(&channels[i]) ? VALUES_OF_CUBIC : 1), all;
        if (!clast_multiply_size(channels[i].key_count, width + 1, &all) || !clast_add_size(*floats, all, floats)) {
            return false;
        }
    }
    return true;
}

clast_status clast_scene_add_animation(clast_scene *scene, const clast_channel *channels, size_t count,
                                       const char *name, uint32_t *number)
{
    if (scene == NULL || number == NULL || (channels == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    const clast_motion *motion = &scene->motion;
    clast_status status = check_channels(scene, channels, count);
    if (status != CLAST_OK) {
        return status;
    }
    size_t floats;
    if (!count_floats(motion, channels, count, &floats)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "animation: more keys than memory could hold");
    }
    float *block = clast_allocate(context, floats, sizeof *block), *next = block;
    clast_channel *copies = block != NULL ? clast_allocate(context, count, sizeof *copies) : NULL;
    if (copies == NULL) {
        clast_free(context, block);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        copies[i] = channels[i];
        size_t values = channels[i].key_count * channel_width(motion, &channels[i]) *
                        (is_cubic(&channels[i]) ? VALUES_OF_CUBIC : 1);
        copies[i].times = memcpy(next, channels[i].times, channels[i].key_count * sizeof *next);
        next += channels[i].key_count;
        copies[i].values = memcpy(next, channels[i].values, values * sizeof *next);
        next += values;
    }
    status = clast_scene_keep_block(scene, block);
    if (status == CLAST_OK) {
        status = clast_scene_adopt_animation(scene, copies, count, motion->animation_count == 0, name, number);
    }
    clast_free(context, copies);
    return status;
}

double clast_scene_animation_length(const clast_scene *scene, uint32_t number)
{
    return scene != NULL && number < scene->motion.animation_count ? scene->motion.animations[number].length : 0.0;
}

clast_status clast_scene_choose_animation(const clast_scene *scene, const char *text, uint32_t *animation)
{
    static const struct {
        const char *text;
        uint32_t value;
    } words[] = {{"", CLAST_ANIMATION_FIRST}, {"all", CLAST_ANIMATION_ALL}, {"none", CLAST_ANIMATION_REST}};
    const clast_motion *motion = &scene->motion;
    text = text != NULL ? text : "";
    for (size_t i = 0; i < motion->animation_count && text[0] != '\0'; i++) {
        char number[24];
        snprintf(number, sizeof number, "%zu", i);
        const char *name = motion->animations[i].name;
        if ((name != NULL && strcmp(name, text) == 0) || strcmp(number, text) == 0) {
            *animation = (uint32_t)i;
            return CLAST_OK;
        }
    }
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(words[i].text, text) == 0) {
            *animation = words[i].value;
            return CLAST_OK;
        }
    }
    return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                      "animation \"%s\": expected the name or number of one of the scene's %zu animations, all or none",
                      text, motion->animation_count);
}

// ----------------------------------------------------------------------------------------------------- between keys

// A series for sin(t angle) / sin(angle), in powers of the cosine less one; Eberly, A Fast and Accurate Algorithm for
// Computing SLERP, JGT 15(3), 2011. For angles up to 12 degrees eight terms are exact to double precision.
static double slerp_weight(double t, double cosine_less_one)
{
    double sum = 1.0;
    for (int k = 8; k >= 1; k--) {
        sum = 1.0 + sum * cosine_less_one * (t * t - (double)(k * k)) / (double)(k * (2 * k + 1));
    }
    return t * sum;
}

static double dot4(const double a[4], const double b[4])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static bool make_unit(double q[4])
{
    double square = dot4(q, q);
    if (!(square > 0.0) || !isfinite(square)) {
        return false;
    }
    double scale = 1.0 / sqrt(square);
    for (int i = 0; i < 4; i++) {
        q[i] *= scale;
    }
    return true;
}

// Between equal ends nothing moves, not by a bit. The arc is halved until the series is good for what is left of it.
void clast_slerp(const double from[4], const double to[4], double t, double result[4])
{
    double a[4], b[4];
    memcpy(a, from, sizeof a);
    memcpy(b, to, sizeof b);
    if (memcmp(from, to, sizeof a) == 0 || !make_unit(a) || !make_unit(b)) {
        memcpy(result, t < 0.5 ? from : to, sizeof a);
        return;
    }
    double sign = dot4(a, b) < 0.0 ? -1.0 : 1.0; // the shorter way (appendix C.4)
    for (int i = 0; i < 4; i++) {
        b[i] *= sign;
    }
    for (int halving = 0; halving < 3; halving++) {
        double middle[4] = {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
        make_unit(middle);
        memcpy(t < 0.5 ? b : a, middle, sizeof middle);
        t = t < 0.5 ? 2.0 * t : 2.0 * t - 1.0;
    }
    double less = dot4(a, b) - 1.0;
    double weight_a = slerp_weight(1.0 - t, less), weight_b = slerp_weight(t, less);
    for (int i = 0; i < 4; i++) {
        result[i] = weight_a * a[i] + weight_b * b[i];
    }
}

// The last key that is not after `time`; the first where all are.
static size_t find_key(const clast_channel *channel, double time)
{
    size_t low = 0, high = channel->key_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if ((double)channel->times[middle] <= time) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Appendix C.5.
static double cubic(const float *key, const float *next, size_t width, size_t i, double t, double duration)
{
    double before = (double)key[width + i], after = (double)next[width + i];
    double leave = duration * (double)key[2 * width + i], arrive = duration * (double)next[i];
    double square = t * t, cube = square * t;
    return (2.0 * cube - 3.0 * square + 1.0) * before + (cube - 2.0 * square + t) * leave +
           (3.0 * square - 2.0 * cube) * after + (cube - square) * arrive;
}

// A place between two keys.
typedef struct key_place {
    const float *key, *next; // equal where the value stands still
    double t, duration;
} key_place;

static key_place place_in(const clast_channel *channel, size_t width, double time)
{
    size_t stride = width * (is_cubic(channel) ? VALUES_OF_CUBIC : 1), index = find_key(channel, time);
    key_place place = {.key = channel->values + index * stride, .next = channel->values + index * stride};
    if (index + 1 < channel->key_count && time > (double)channel->times[index]) {
        place.next += stride;
        place.duration = (double)channel->times[index + 1] - (double)channel->times[index];
        place.t = (time - (double)channel->times[index]) / place.duration;
    }
    return place;
}

static double between(const clast_channel *channel, size_t width, key_place at, size_t i)
{
    switch (channel->interpolation) {
    case CLAST_INTERPOLATION_LINEAR: return (double)at.key[i] + at.t * ((double)at.next[i] - (double)at.key[i]);
    case CLAST_INTERPOLATION_STEP: return (double)at.key[i];
    case CLAST_INTERPOLATION_CUBICSPLINE: return cubic(at.key, at.next, width, i, at.t, at.duration);
    }
    return 0.0;
}

static void turn(const clast_channel *channel, key_place at, double rotation[4])
{
    if (channel->interpolation != CLAST_INTERPOLATION_LINEAR) {
        for (size_t i = 0; i < 4; i++) {
            rotation[i] = between(channel, 4, at, i);
        }
        return;
    }
    double from[4], to[4];
    for (size_t i = 0; i < 4; i++) {
        from[i] = (double)at.key[i];
        to[i] = (double)at.next[i];
    }
    clast_slerp(from, to, at.t, rotation);
}

// ----------------------------------------------------------------------------------------------------------- posing

static void play_channel(const clast_motion *motion, const clast_channel *channel, double time, clast_posed_node *nodes,
                         float *weights)
{
    clast_node_parts *parts = &nodes[channel->node].parts;
    size_t width = channel_width(motion, channel);
    key_place at = place_in(channel, width, time);
    switch (channel->animated) {
    case CLAST_ANIMATED_TRANSLATION:
    case CLAST_ANIMATED_SCALE: {
        double *moved = channel->animated == CLAST_ANIMATED_SCALE ? parts->scale : parts->translation;
        for (size_t i = 0; i < width; i++) {
            moved[i] = between(channel, width, at, i);
        }
        return;
    }
    case CLAST_ANIMATED_ROTATION: turn(channel, at, parts->rotation); return;
    case CLAST_ANIMATED_WEIGHTS:
        for (size_t i = 0; i < width; i++) {
            weights[motion->nodes[channel->node].first_weight + i] = (float)between(channel, width, at, i);
        }
    }
}

static void play(const clast_motion *motion, const clast_scene_animation *animation, double time,
                 clast_posed_node *nodes, float *weights)
{
    double local = animation->length > 0.0 ? fmod(time, animation->length) : 0.0;
    local = local < 0.0 ? local + animation->length : local;
    for (size_t i = 0; i < animation->channel_count; i++) {
        play_channel(motion, &animation->channels[i], local, nodes, weights);
    }
}

static bool plays(const clast_motion *motion, size_t number, uint32_t choice)
{
    return choice == CLAST_ANIMATION_ALL || number == choice ||
           (choice == CLAST_ANIMATION_FIRST && motion->animations[number].is_first);
}

void clast_scene_pose(const clast_scene *scene, clast_moment moment, clast_posed_node *nodes, float *weights)
{
    const clast_motion *motion = &scene->motion;
    for (size_t i = 0; i < motion->node_count; i++) {
        nodes[i].parts = motion->nodes[i].parts;
    }
    if (motion->weight_count != 0) {
        memcpy(weights, motion->weights, motion->weight_count * sizeof *weights);
    }
    for (size_t i = 0; i < motion->animation_count; i++) {
        if (plays(motion, i, moment.animation)) {
            play(motion, &motion->animations[i], moment.time, nodes, weights);
        }
    }
    for (size_t i = 0; i < motion->node_count; i++) {
        const clast_scene_node *node = &motion->nodes[i];
        const clast_node_parts *parts = &nodes[i].parts;
        clast_matrix local = node->has_matrix ? node->matrix
                                              : clast_matrix_compose(parts->translation, parts->rotation, parts->scale);
        nodes[i].to_world = node->parent != CLAST_NONE ? clast_matrix_product(&nodes[node->parent].to_world, &local)
                                                       : local;
    }
}
