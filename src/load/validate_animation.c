// SPDX-License-Identifier: Apache-2.0
// Animations: samplers, channels and what they move (section 3.11).
#include "load/validate.h"

typedef enum animated { TRANSLATION, ROTATION, SCALE, WEIGHTS, OTHER } animated;

static animated read_path(const clast_gltf_value *target)
{
    static const char *const names[] = {"translation", "rotation", "scale", "weights"};
    const char *path = clast_validate_text(target, "path");
    for (int i = TRANSLATION; path != NULL && i <= WEIGHTS; i++) {
        if (strcmp(names[i], path) == 0) {
            return (animated)i;
        }
    }
    return OTHER;
}

static bool is_cubic(const clast_gltf_value *sampler)
{
    const char *interpolation = clast_validate_text(sampler, "interpolation");
    return interpolation != NULL && strcmp(interpolation, "CUBICSPLINE") == 0;
}

// An accessor of a sampler, with its use noted; null where it makes no sense.
static const clast_validate_accessor *sampler_accessor(clast_validator *v, const clast_gltf_value *sampler,
                                                       const char *name)
{
    clast_gltf_value place = clast_gltf_member(sampler, name);
    uint32_t index = clast_validate_index(v, sampler, name, CLAST_VALIDATE_ACCESSORS);
    if (index == CLAST_NONE || v->accessors[index].components == 0) {
        return NULL;
    }
    const clast_validate_accessor *accessor = &v->accessors[index];
    clast_validate_use(v, &place, index, CLAST_USAGE_ANIMATION);
    if (accessor->view != CLAST_NONE && v->views[accessor->view].stride != 0) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE, &place,
                             "view %u has a byteStride", accessor->view);
    }
    return accessor;
}

static void check_sampler(clast_validator *v, const clast_gltf_value *sampler)
{
    clast_gltf_value place = clast_gltf_member(sampler, "input");
    const clast_validate_accessor *input = sampler_accessor(v, sampler, "input");
    sampler_accessor(v, sampler, "output");
    if (input == NULL) {
        return;
    }
    clast_gltf_value accessor = clast_validate_entry(
        v, CLAST_VALIDATE_ACCESSORS, clast_validate_index(v, sampler, "input", CLAST_VALIDATE_ACCESSORS));
    if (json_object_get(accessor.json, "min") == NULL || json_object_get(accessor.json, "max") == NULL) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS, &place,
                             "times need min and max");
    }
    if (input->components != 1 || input->component != CLAST_GLTF_FLOAT) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT, &place,
                             "expected single floats");
    }
    if (is_cubic(sampler) && input->count < 2) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS, &place,
                             "one key frame: splines need two");
    }
}

static bool is_fraction(const clast_validate_accessor *accessor)
{
    bool is_small = accessor->component <= CLAST_GLTF_UNSIGNED_SHORT;
    return accessor->component == CLAST_GLTF_FLOAT || (is_small && accessor->is_normalised);
}

// The values of a channel must suit its path and number.
static void check_output(clast_validator *v, const clast_gltf_value *place, const clast_gltf_value *sampler,
                         animated path, size_t targets)
{
    uint32_t input = clast_validate_index(v, sampler, "input", CLAST_VALIDATE_ACCESSORS);
    uint32_t output = clast_validate_index(v, sampler, "output", CLAST_VALIDATE_ACCESSORS);
    if (input == CLAST_NONE || output == CLAST_NONE || v->accessors[input].components == 0 ||
        v->accessors[output].components == 0 || path == OTHER) {
        return;
    }
    const clast_validate_accessor *values = &v->accessors[output];
    static const uint32_t components[] = {3, 4, 3, 1};
    bool takes_fractions = path == ROTATION || path == WEIGHTS;
    bool is_right = values->columns == 1 && values->rows == components[path] &&
                    (takes_fractions ? is_fraction(values) : values->component == CLAST_GLTF_FLOAT);
    if (!is_right) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT, place,
                             "values of %u components of type %u: not what the path takes", values->components,
                             values->component);
        return;
    }
    uint64_t each = (path == WEIGHTS ? targets : 1) * (is_cubic(sampler) ? 3u : 1u);
    if (each != 0 &&
        (v->accessors[input].count > UINT64_MAX / each || values->count != v->accessors[input].count * each)) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT, place,
                             "%llu values for %llu times, with %llu each", (unsigned long long)values->count,
                             (unsigned long long)v->accessors[input].count, (unsigned long long)each);
    }
}

static void check_target(clast_validator *v, const clast_gltf_value *target, uint32_t node_index, animated path)
{
    clast_gltf_value node = clast_validate_entry(v, CLAST_VALIDATE_NODES, node_index);
    if (path <= SCALE && json_object_get(node.json, "matrix") != NULL) {
        clast_validate_fault(v, CLAST_FAULT_ANIMATION_CHANNEL_TARGET_NODE_MATRIX, target, "node %u has a matrix",
                             node_index);
    }
    if (path <= SCALE && clast_validate_index(v, &node, "skin", CLAST_VALIDATE_SKINS) != CLAST_NONE) {
        clast_validate_member_fault(v, CLAST_FAULT_ANIMATION_CHANNEL_TARGET_NODE_SKIN, target, "path",
                                    "of no effect on the skinned mesh of node %u", node_index);
    }
}

static size_t targets_of_node(const clast_validator *v, uint32_t node_index)
{
    clast_gltf_value node = clast_validate_entry(v, CLAST_VALIDATE_NODES, node_index);
    uint32_t mesh = clast_validate_index(v, &node, "mesh", CLAST_VALIDATE_MESHES);
    clast_gltf_value value = mesh != CLAST_NONE ? clast_validate_entry(v, CLAST_VALIDATE_MESHES, mesh)
                                                : (clast_gltf_value){.json = NULL};
    return clast_validate_target_count(&value);
}

// The last channel that moved a node's path, and its animation, from 1.
typedef struct last_channel {
    uint32_t animation, channel;
} last_channel;

// Tells of a channel that moves what an earlier one of the same animation does.
static void check_channel(clast_validator *v, const clast_gltf_value *channels, const clast_gltf_value *samplers,
                          size_t number, uint32_t animation, last_channel *seen)
{
    clast_gltf_value channel = clast_gltf_element(channels, number), target = clast_gltf_member(&channel, "target");
    clast_gltf_value place = clast_gltf_member(&channel, "sampler");
    uint32_t node = clast_validate_index(v, &target, "node", CLAST_VALIDATE_NODES);
    animated path = read_path(&target);
    uint64_t sampler = clast_validate_unsigned_or(&channel, "sampler", UINT64_MAX);
    size_t targets = 0;
    if (node != CLAST_NONE && path != OTHER) {
        check_target(v, &target, node, path);
        targets = targets_of_node(v, node);
        if (path == WEIGHTS && targets == 0) {
            clast_validate_fault(v, CLAST_FAULT_ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS, &target,
                                 "node %u has no morph targets", node);
        }
        last_channel *last = &seen[4 * (size_t)node + path];
        if (last->animation == animation) {
            clast_gltf_value earlier = clast_gltf_element(channels, last->channel);
            clast_gltf_value same = clast_gltf_member(&earlier, "target");
            clast_validate_fault(v, CLAST_FAULT_ANIMATION_DUPLICATE_TARGETS, &same, "channel %zu moves the same",
                                 number);
        } else {
            *last = (last_channel){animation, (uint32_t)number};
        }
    }
    if (json_is_number(place.json) && sampler >= clast_gltf_size(samplers)) {
        clast_validate_fault(v, CLAST_FAULT_UNRESOLVED_REFERENCE, &place, "there are %zu samplers",
                             clast_gltf_size(samplers));
    } else if (place.json != NULL && sampler < clast_gltf_size(samplers)) {
        clast_gltf_value value = clast_gltf_element(samplers, (size_t)sampler);
        check_output(v, &place, &value, path, targets);
    }
}

void clast_validate_animations(clast_validator *v)
{
    last_channel *seen = clast_allocate_zeroed(v->context, clast_validate_size(v, CLAST_VALIDATE_NODES),
                                               4 * sizeof *seen);
    if (seen == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_ANIMATIONS) && v->status == CLAST_OK; i++) {
        clast_gltf_value animation = clast_validate_entry(v, CLAST_VALIDATE_ANIMATIONS, i);
        clast_gltf_value samplers = clast_gltf_member(&animation, "samplers"),
                         channels = clast_gltf_member(&animation, "channels");
        for (size_t k = 0; k < clast_gltf_size(&samplers) && v->status == CLAST_OK; k++) {
            clast_gltf_value sampler = clast_gltf_element(&samplers, k);
            check_sampler(v, &sampler);
        }
        for (size_t k = 0; k < clast_gltf_size(&channels) && v->status == CLAST_OK; k++) {
            check_channel(v, &channels, &samplers, k, (uint32_t)i + 1, seen);
        }
    }
    clast_free(v->context, seen);
}
