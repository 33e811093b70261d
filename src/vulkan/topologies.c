// SPDX-License-Identifier: Apache-2.0
#include "vulkan/topologies.h"

#include <string.h>

#include "base/thread.h"
#include "vulkan/pairs.h"

enum { TOPOLOGY_GRAIN = 16 };

// Templates that are new, and where each one's pairs begin; its corners follow them.
typedef struct pairs_job {
    const clast_template_set *set;
    uint32_t first;
    const uint64_t *places;
    clast_pair *pairs;
} pairs_job;

static void make_corners(const clast_template *topology, uint32_t *words)
{
    for (uint32_t i = 0; i < topology->triangle_count; i++) {
        uint32_t corners[3] = {0};
        clast_template_corners(topology, i, corners);
        words[i] = corners[0] | corners[1] << 8 | corners[2] << 16;
    }
}

static void make_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const pairs_job *job = data;
    for (size_t i = begin; i < end; i++) {
        clast_pair pairs[CLAST_PAIRS_MOST];
        const clast_template *topology = job->set->templates[job->first + i];
        uint32_t words[TEMPLATE_TRIANGLES];
        uint32_t count = cluster_pairs(triangles_counts(topology->triangle_count));
        clast_pairs_of_template(topology, pairs);
        make_corners(topology, words);
        memcpy(job->pairs + job->places[i], pairs, count * sizeof *pairs);
        memcpy(job->pairs + job->places[i] + count, words, topology->triangle_count * sizeof *words);
    }
}

static uint32_t counts_of(const clast_template_set *set, uint32_t number)
{
    return triangles_counts(set->templates[number]->triangle_count);
}

// What a template takes, in pairs.
static uint64_t room_of(const clast_template_set *set, uint32_t number)
{
    return cluster_pairs(counts_of(set, number)) + (set->templates[number]->triangle_count + 1) / 2;
}

// Makes and uploads the pairs of templates [first, first + count), whose places are known.
static clast_status upload_pairs(clast_topologies *t, clast_gpu_commands *commands, const clast_template_set *set,
                                 uint32_t count, const uint64_t *places)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    clast_context *context = clast_gpu_context(gpu);
    uint64_t bytes = places[count] * sizeof(clast_pair);
    clast_gpu_buffer buffer = {0};
    clast_pair *pairs = clast_allocate_zeroed(context, places[count], sizeof *pairs);
    clast_status status = pairs != NULL ? CLAST_RESERVE(context, t->pairs, t->pair_capacity, t->pair_buffers + 1)
                                        : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        status = clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, bytes, "topologies", &buffer);
    }
    if (status == CLAST_OK) {
        pairs_job job = {set, t->count, places, pairs};
        clast_parallel_for(context, count, TOPOLOGY_GRAIN, make_range, &job);
        clast_gpu_write(commands, &buffer, 0, pairs, bytes);
        t->pairs[t->pair_buffers++] = buffer;
    }
    clast_free(context, pairs);
    return status;
}

// All records anew, as their array may have to move.
static clast_status upload_records(clast_topologies *t, clast_gpu_commands *commands, const clast_template_set *set,
                                   uint32_t count, const uint64_t *places)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    uint32_t all = t->count + count;
    uint64_t bytes = (uint64_t)all * sizeof *t->records, address = t->pairs[t->pair_buffers - 1].address;
    if (t->templates.bytes < bytes) {
        clast_gpu_buffer larger = {0};
        clast_status status = clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, bytes + bytes / 2, "templates", &larger);
        if (status != CLAST_OK) {
            return status;
        }
        clast_gpu_free(gpu, &t->templates);
        t->templates = larger;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t counts = counts_of(set, t->count + i);
        t->records[t->count + i] = (clast_device_template){
            .pairs = store_address(address + places[i] * sizeof(clast_pair)),
            .corners = store_address(address + (places[i] + cluster_pairs(counts)) * sizeof(clast_pair)),
            .counts = counts,
            .vertices = set->templates[t->count + i]->vertex_count,
        };
    }
    clast_gpu_write(commands, &t->templates, 0, t->records, bytes);
    t->count = all;
    return CLAST_OK;
}

static void forget(clast_gpu *gpu, clast_topologies *t)
{
    for (size_t i = 0; i < t->pair_buffers; i++) {
        clast_gpu_free(gpu, &t->pairs[i]);
    }
    t->pair_buffers = 0;
    t->count = 0;
    t->set = NULL;
}

clast_status clast_topologies_update(clast_topologies *topologies, clast_gpu_commands *commands,
                                     const clast_template_set *set)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    clast_context *context = clast_gpu_context(gpu);
    if (topologies->set != set || topologies->count > set->count) {
        forget(gpu, topologies);
    }
    uint32_t count = (uint32_t)set->count - topologies->count;
    if (count == 0) {
        return CLAST_OK;
    }
    uint64_t *places = clast_allocate(context, (size_t)count + 1, sizeof *places);
    clast_status status = places != NULL
                              ? CLAST_RESERVE(context, topologies->records, topologies->record_capacity, set->count)
                              : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        places[0] = 0;
        for (uint32_t i = 0; i < count; i++) {
            places[i + 1] = places[i] + room_of(set, topologies->count + i);
        }
        status = upload_pairs(topologies, commands, set, count, places);
    }
    if (status == CLAST_OK) {
        status = upload_records(topologies, commands, set, count, places);
        if (status != CLAST_OK) {
            clast_gpu_free(gpu, &topologies->pairs[--topologies->pair_buffers]);
        }
    }
    topologies->set = status == CLAST_OK ? set : topologies->set;
    clast_free(context, places);
    return status;
}

void clast_topologies_free(clast_gpu *gpu, clast_topologies *topologies)
{
    clast_context *context = clast_gpu_context(gpu);
    forget(gpu, topologies);
    clast_gpu_free(gpu, &topologies->templates);
    clast_free(context, topologies->pairs);
    clast_free(context, topologies->records);
    *topologies = (clast_topologies){0};
}
