// SPDX-License-Identifier: Apache-2.0
// The arrays of a unit lie one after the other in one buffer. What several units have, displacement maps and common arrays,
// has a buffer of its own, and is counted by its users.
#include "vulkan/mirror.h"

#include <string.h>

static const uint64_t array_alignment = 16;

// What several units may have.
typedef struct shared_data {
    uint64_t key;
    uint64_t bytes;
    clast_gpu_buffer buffer;
    uint32_t users; // 0: the place is free
} shared_data;

typedef struct mirrored_array {
    uint64_t bytes;
    uint64_t offset;  // in the unit's buffer
    uint64_t common;  // not 0: the array lies in shared data instead
    uint32_t version; // that was uploaded
} mirrored_array;

typedef struct mirrored_unit {
    bool is_there, seen;
    uint32_t serial;
    mirrored_array arrays[SOURCE_ARRAYS];
    clast_gpu_buffer buffer;
    clast_gpu_buffer heights; // clast_device_height
    uint64_t *height_keys;    // of those; 0 for none
    uint32_t height_count;
    clast_gpu_buffer pose;
    uint32_t pose_shape; // that was uploaded; 0 is none
} mirrored_unit;

struct clast_mirror {
    clast_gpu *gpu;
    clast_context *context;
    mirrored_unit *units; // by geometry number
    size_t unit_count, unit_capacity;
    shared_data *shared;
    size_t shared_count, shared_capacity;
};

clast_status clast_mirror_create(clast_gpu *gpu, clast_mirror **result)
{
    clast_mirror *mirror = clast_allocate_zeroed(clast_gpu_context(gpu), 1, sizeof *mirror);
    if (mirror == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    mirror->gpu = gpu;
    mirror->context = clast_gpu_context(gpu);
    *result = mirror;
    return CLAST_OK;
}

static uint64_t round_up(uint64_t bytes)
{
    return (bytes + array_alignment - 1) / array_alignment * array_alignment;
}

// ------------------------------------------------------------------------------------------------------- shared data

static shared_data *find_shared(const clast_mirror *mirror, uint64_t key)
{
    for (size_t i = 0; i < mirror->shared_count; i++) {
        if (mirror->shared[i].users != 0 && mirror->shared[i].key == key) {
            return &mirror->shared[i];
        }
    }
    return NULL;
}

static shared_data *free_place(clast_mirror *mirror)
{
    for (size_t i = 0; i < mirror->shared_count; i++) {
        if (mirror->shared[i].users == 0) {
            return &mirror->shared[i];
        }
    }
    if (CLAST_RESERVE(mirror->context, mirror->shared, mirror->shared_capacity, mirror->shared_count + 1) != CLAST_OK) {
        return NULL;
    }
    return &mirror->shared[mirror->shared_count++];
}

// Makes the caller one more user of what stands under a key, and uploads it for the first.
static clast_status share(clast_mirror *mirror, clast_gpu_commands *commands, uint64_t key, const void *data,
                          uint64_t bytes, const char *name)
{
    shared_data *found = find_shared(mirror, key);
    if (found != NULL) {
        found->users++;
        return CLAST_OK;
    }
    shared_data *place = free_place(mirror);
    if (place == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *place = (shared_data){.key = key, .bytes = bytes};
    clast_status status = clast_gpu_allocate(mirror->gpu, CLAST_GPU_DEVICE, bytes, name, &place->buffer);
    if (status == CLAST_OK) {
        clast_gpu_write(commands, &place->buffer, 0, data, bytes);
        place->users = 1;
    }
    return status;
}

static void unshare(clast_mirror *mirror, uint64_t key)
{
    shared_data *found = find_shared(mirror, key);
    if (found != NULL && --found->users == 0) {
        clast_gpu_free(mirror->gpu, &found->buffer);
    }
}

// Keys of maps and of common arrays are apart; none is 0.
static uint64_t height_key(const clast_height *height)
{
    return height->hash << 1 | 1;
}

static uint64_t common_key(const clast_source_array *array)
{
    return array->common << 1 != 0 ? array->common << 1 : 2;
}

// -------------------------------------------------------------------------------------------------------------- units

static void forget_unit(clast_mirror *mirror, mirrored_unit *unit)
{
    for (uint32_t i = 0; i < SOURCE_ARRAYS; i++) {
        if (unit->arrays[i].common != 0) {
            unshare(mirror, unit->arrays[i].common);
        }
    }
    for (uint32_t i = 0; i < unit->height_count; i++) {
        if (unit->height_keys[i] != 0) {
            unshare(mirror, unit->height_keys[i]);
        }
    }
    clast_gpu_free(mirror->gpu, &unit->buffer);
    clast_gpu_free(mirror->gpu, &unit->heights);
    clast_gpu_free(mirror->gpu, &unit->pose);
    clast_free(mirror->context, unit->height_keys);
    *unit = (mirrored_unit){0};
}

void clast_mirror_forget(clast_mirror *mirror)
{
    for (size_t i = 0; i < mirror->unit_count; i++) {
        forget_unit(mirror, &mirror->units[i]);
    }
}

void clast_mirror_destroy(clast_mirror *mirror)
{
    if (mirror == NULL) {
        return;
    }
    clast_mirror_forget(mirror);
    clast_free(mirror->context, mirror->units);
    clast_free(mirror->context, mirror->shared);
    clast_free(mirror->context, mirror);
}

clast_status clast_mirror_begin(clast_mirror *mirror, size_t unit_count)
{
    clast_status status = CLAST_RESERVE(mirror->context, mirror->units, mirror->unit_capacity, unit_count);
    while (status == CLAST_OK && mirror->unit_count < unit_count) {
        mirror->units[mirror->unit_count++] = (mirrored_unit){0};
    }
    for (size_t i = 0; i < mirror->unit_count; i++) {
        mirror->units[i].seen = false;
    }
    return status;
}

void clast_mirror_end(clast_mirror *mirror)
{
    for (size_t i = 0; i < mirror->unit_count; i++) {
        if (!mirror->units[i].seen) {
            forget_unit(mirror, &mirror->units[i]);
        }
    }
}

static clast_status upload_heights(clast_mirror *mirror, clast_gpu_commands *commands, mirrored_unit *unit,
                                   const clast_unit *from)
{
    const clast_source *source = clast_source_of(from);
    uint32_t count = source->height_count != NULL ? source->height_count(from) : 0;
    if (count == 0) {
        return CLAST_OK;
    }
    clast_device_height *records = clast_allocate_zeroed(mirror->context, count, sizeof *records);
    unit->height_keys = clast_allocate_zeroed(mirror->context, count, sizeof *unit->height_keys);
    clast_status status = records != NULL && unit->height_keys != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    unit->height_count = status == CLAST_OK ? count : 0;
    for (uint32_t i = 0; i < count && status == CLAST_OK; i++) {
        const clast_height *height = source->height(from, i);
        if (height == NULL) {
            continue;
        }
        uint64_t bytes = height->texel_count * (height->map.is_float != 0 ? sizeof(float) : sizeof(uint16_t));
        status = share(mirror, commands, height_key(height), height->texels, bytes, "displacement map");
        if (status == CLAST_OK) {
            unit->height_keys[i] = height_key(height);
            uint64_t address = find_shared(mirror, unit->height_keys[i])->buffer.address;
            records[i] = (clast_device_height){store_address(address), height->map};
        }
    }
    if (status == CLAST_OK) {
        status = clast_gpu_allocate(mirror->gpu, CLAST_GPU_DEVICE, count * sizeof *records, "displacement maps",
                                    &unit->heights);
    }
    if (status == CLAST_OK) {
        clast_gpu_write(commands, &unit->heights, 0, records, count * sizeof *records);
    }
    clast_free(mirror->context, records);
    return status;
}

// Gives each array of a unit a place. `list` has SOURCE_ARRAYS of them.
static clast_status upload_unit(clast_mirror *mirror, clast_gpu_commands *commands, mirrored_unit *unit,
                                const clast_unit *from, const clast_source_array *list)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < SOURCE_ARRAYS; i++) {
        if (list[i].common == 0) {
            unit->arrays[i] = (mirrored_array){list[i].bytes, bytes, 0, list[i].version};
            bytes += round_up(list[i].bytes);
        }
    }
    clast_status status = CLAST_OK;
    if (bytes != 0) {
        status = clast_gpu_allocate(mirror->gpu, CLAST_GPU_DEVICE, bytes, "cooked arrays", &unit->buffer);
    }
    for (uint32_t i = 0; i < SOURCE_ARRAYS && status == CLAST_OK; i++) {
        if (list[i].bytes == 0) {
            continue;
        }
        if (list[i].common == 0) {
            clast_gpu_write(commands, &unit->buffer, unit->arrays[i].offset, list[i].data, list[i].bytes);
            continue;
        }
        status = share(mirror, commands, common_key(&list[i]), list[i].data, list[i].bytes, list[i].name);
        if (status == CLAST_OK) {
            unit->arrays[i] = (mirrored_array){list[i].bytes, 0, common_key(&list[i]), list[i].version};
        }
    }
    return status == CLAST_OK ? upload_heights(mirror, commands, unit, from) : status;
}

// Whether the arrays are as long as those that are there.
static bool same_sizes(const mirrored_unit *unit, const clast_source_array *list)
{
    for (uint32_t i = 0; i < SOURCE_ARRAYS; i++) {
        if (unit->arrays[i].bytes != list[i].bytes) {
            return false;
        }
    }
    return true;
}

static void refresh_arrays(clast_gpu_commands *commands, mirrored_unit *unit, const clast_source_array *list)
{
    for (uint32_t i = 0; i < SOURCE_ARRAYS; i++) {
        mirrored_array *array = &unit->arrays[i];
        if (array->common == 0 && array->bytes != 0 && array->version != list[i].version) {
            clast_gpu_write(commands, &unit->buffer, array->offset, list[i].data, list[i].bytes);
            array->version = list[i].version;
        }
    }
}

// --------------------------------------------------------------------------------------------------------------- pose

// Vertices that a pose moves lie one after the other: as many bytes as it has of each.
typedef struct pose_bytes {
    uint64_t positions, normals, tangents;
} pose_bytes;

static pose_bytes pose_bytes_of(const clast_frame_unit *unit)
{
    if (!clast_geometry_is_mesh(unit->unit->geometry)) {
        return (pose_bytes){0};
    }
    uint64_t count = unit->unit->geometry->of.mesh.vertex_count;
    return (pose_bytes){unit->pose.positions != NULL ? count * sizeof(packed3) : 0,
                        unit->pose.normals != NULL ? count * sizeof(packed3) : 0,
                        unit->pose.tangents != NULL ? count * sizeof(packed4) : 0};
}

// The push constants of shaders/source/pose.source.comp.
typedef struct pose_push {
    uint64_t unit, to;
    uint32_t count;
} pose_push;

// What a kind makes of a pose, which takes the place of one of its arrays. Behind it lies the unit as it is without.
static void make_posed_array(clast_gpu_commands *commands, const mirrored_unit *mirrored, const clast_source *source,
                             uint64_t offset, const clast_device_unit *record)
{
    uint64_t bytes = mirrored->arrays[source->posed_array].bytes, unit_at = offset + round_up(bytes);
    clast_gpu_write(commands, &mirrored->pose, unit_at, record, sizeof *record);
    clast_gpu_barrier(commands);
    pose_push push = {mirrored->pose.address + unit_at, mirrored->pose.address + offset,
                      (uint32_t)(bytes / source->posed_bytes)};
    // kernels of all kinds follow each other
    clast_shader shader = (clast_shader)((uint32_t)CLAST_SHADER_SOURCE_POSE_CLUSTERS + record->kind);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = shader,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = ((uint64_t)push.count + SOURCE_GROUP - 1) / SOURCE_GROUP});
}

static clast_status upload_pose(clast_mirror *mirror, clast_gpu_commands *commands, mirrored_unit *mirrored,
                                const clast_frame_unit *unit, clast_device_unit *record)
{
    const clast_source *source = clast_source_of(unit->unit);
    pose_bytes bytes = pose_bytes_of(unit);
    uint64_t normals = round_up(bytes.positions), tangents = normals + round_up(bytes.normals);
    uint64_t posed = tangents + round_up(bytes.tangents), all = posed;
    bool has_posed = source->posed_array != 0 && bytes.positions + bytes.normals != 0;
    if (has_posed) {
        all += round_up(mirrored->arrays[source->posed_array].bytes) + sizeof *record;
    }
    if (all == 0) {
        clast_gpu_free(mirror->gpu, &mirrored->pose);
        mirrored->pose_shape = 0;
        return CLAST_OK;
    }
    bool anew = mirrored->pose.bytes < all || mirrored->pose_shape != unit->pose.shape;
    if (anew) {
        mirrored->pose_shape = 0;
        clast_status status = clast_gpu_reserve(mirror->gpu, CLAST_GPU_DEVICE, all, "posed vertices", &mirrored->pose);
        if (status != CLAST_OK) {
            return status;
        }
        clast_gpu_write(commands, &mirrored->pose, 0, unit->pose.positions, bytes.positions);
        clast_gpu_write(commands, &mirrored->pose, normals, unit->pose.normals, bytes.normals);
        clast_gpu_write(commands, &mirrored->pose, tangents, unit->pose.tangents, bytes.tangents);
        mirrored->pose_shape = unit->pose.shape;
    }
    uint64_t address = mirrored->pose.address;
    record->positions = store_address(bytes.positions != 0 ? address : 0);
    record->normals = store_address(bytes.normals != 0 ? address + normals : 0);
    record->tangents = store_address(bytes.tangents != 0 ? address + tangents : 0);
    if (has_posed && anew) {
        make_posed_array(commands, mirrored, source, posed, record);
    }
    if (has_posed) {
        record->arrays[source->posed_array] = store_address(address + posed);
    }
    return CLAST_OK;
}

static void describe_arrays(const clast_mirror *mirror, const mirrored_unit *unit, clast_device_unit *record)
{
    for (uint32_t i = 0; i < SOURCE_ARRAYS; i++) {
        const mirrored_array *array = &unit->arrays[i];
        uint64_t address = 0;
        if (array->common != 0) {
            address = find_shared(mirror, array->common)->buffer.address;
        } else if (array->bytes != 0) {
            address = unit->buffer.address + array->offset;
        }
        record->arrays[i] = store_address(address);
    }
    record->heights = store_address(unit->heights.address);
}

clast_status clast_mirror_unit(clast_mirror *mirror, clast_gpu_commands *commands, size_t number,
                               const clast_frame_unit *unit, clast_device_unit *record)
{
    mirrored_unit *mirrored = &mirror->units[number];
    const clast_source *source = clast_source_of(unit->unit);
    clast_source_array list[CLAST_SOURCE_ARRAYS_MOST] = {0};
    uint32_t listed = source->arrays(unit->unit, list);
    memset(list + listed, 0, (SOURCE_ARRAYS - listed) * sizeof *list);
    if (mirrored->is_there && (mirrored->serial != unit->unit->serial || !same_sizes(mirrored, list))) {
        forget_unit(mirror, mirrored);
    }
    clast_status status = CLAST_OK;
    if (!mirrored->is_there) {
        status = upload_unit(mirror, commands, mirrored, unit->unit, list);
        mirrored->is_there = true;
        mirrored->serial = unit->unit->serial;
    } else {
        refresh_arrays(commands, mirrored, list);
    }
    *record = (clast_device_unit){
        .displacement_scale = unit->pose.displacement_scale,
        .kind = (uint32_t)unit->unit->kind,
        .number = unit->unit->number,
        .item_count = unit->unit->item_count,
        .moment = source->moment != NULL ? source->moment(unit->unit, &unit->pose) : (packed4){{0.0f}},
    };
    if (status == CLAST_OK) {
        describe_arrays(mirror, mirrored, record);
        status = upload_pose(mirror, commands, mirrored, unit, record);
    }
    if (status != CLAST_OK) {
        forget_unit(mirror, mirrored);
        return status;
    }
    mirrored->seen = true;
    return CLAST_OK;
}

uint64_t clast_mirror_bytes(const clast_mirror *mirror)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < mirror->unit_count; i++) {
        const mirrored_unit *unit = &mirror->units[i];
        bytes += unit->buffer.bytes + unit->heights.bytes + unit->pose.bytes;
    }
    for (size_t i = 0; i < mirror->shared_count; i++) {
        bytes += mirror->shared[i].users != 0 ? mirror->shared[i].buffer.bytes : 0;
    }
    return bytes;
}
