// SPDX-License-Identifier: Apache-2.0
// Structures and rays on a Vulkan device, beside the acceleration structures and the ray tracing pipeline of its driver: times
// are the device's own, in milliseconds.
//
//   sort                  ms for 262,144 keys of 32 bits, with values
//   copy                  GB/s read and written by a kernel that copies
//   fill                  vertices are written; of meshes: all are moved
//   fill_fit              vertices are written and clusters fitted in one go; of meshes: gathered from the moved ones, and fitted
//   fill_fit_rate         the same in Gtri/s
//   fill_fit_share        the same: bytes written (of meshes: and gathered) a second, as a share of what `copy` does
//   tree_kept             the tree over the clusters, in the order in which they are stored; of meshes: a tree that was
//                         built with care for the mesh at rest, fitted
//   tree_sorted           the same, whatever their order
//   tree_refit            such a tree fitted to boxes that moved
//   ready_vs_build        fill_fit and tree_kept: rays can be traced; the driver's fastest build, its vertices not included
//   ready_vs_trace_build  the same; the driver's build for fast rays
//   ready_vs_update       the same; the driver's update of its fastest build
//   any_order_vs_build    fill_fit and tree_sorted; the driver's fastest build
//   bytes_per_triangle    all that rays need, vertices included; the driver's fastest build, vertices and indices
//   primary, diffuse      Mrays/s: a picture of 1920x1080, and one ray from each hit of it; the driver's build for fast rays
//   primary_differ, ...   rays of a million of which clast and the driver tell other hits, but for triangles at the same distance
//
// A driver that has no such structures leaves the rows without a peer. --quick leaves out 32 M triangles, and takes fewer turns.
// Drivers that are programs on the processor count with --triangles only: what they take for millions is of no interest.
#include "vulkan_open.h"
#include "vulkan_rays.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vulkan/sort.h"

enum {
    TURNS = 11,
    TURNS_QUICK = 5,
    COPY_BYTES_HARDWARE = 1 << 30,
    COPY_BYTES_SOFTWARE = 1 << 24,
    DIFFER_MOST = 1000, // rays of a million
    SORT_PAIRS = 1 << 18,
};

// What is measured, in turns.
typedef struct vulkan_turn {
    vulkan_work *work;
    const vulkan_rays *rays;
    void (*record)(const struct vulkan_turn *turn, clast_gpu_commands *commands);
    void (*record_peer)(const struct vulkan_turn *turn, clast_gpu_commands *commands);
    clast_gpu_tree_order order;
    clast_driver_build build;
    bool update, diffuse;
} vulkan_turn;

typedef void (*vulkan_recorder)(const vulkan_turn *turn, clast_gpu_commands *commands);

// -------------------------------------------------------------------------------------------------------------- times

static double measure(const vulkan_turn *turn, vulkan_recorder record)
{
    vulkan_device *device = turn->work->device;
    clast_gpu_commands *commands = vulkan_begin(device);
    clast_gpu_pass(commands, "measured");
    record(turn, commands);
    clast_gpu_pass(commands, "after");
    vulkan_finish(device, commands);
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t count = clast_gpu_passes(device->gpu, times);
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(times[i].pass, "measured") == 0) {
            return times[i].milliseconds;
        }
    }
    fprintf(stderr, "the device has no clock\n");
    exit(1);
}

static double measure_own(void *data)
{
    const vulkan_turn *turn = data;
    return measure(turn, turn->record);
}

static double measure_peer(void *data)
{
    const vulkan_turn *turn = data;
    return turn->record_peer != NULL ? measure(turn, turn->record_peer) : 0.0;
}

static bench_pair alternate(const bench *b, vulkan_turn *turn)
{
    vulkan_wake(turn->work->device->context, turn->work->device->gpu);
    measure_own(turn); // kernels are compiled, and memory is reserved
    measure_peer(turn);
    return bench_alternate(b, measure_own, measure_peer, turn);
}

// --------------------------------------------------------------------------------------------------------------- rows

static bench_row row_of(const vulkan_work *work, const char *metric, const char *unit, double value)
{
    bench_row row = {.triangles = work->triangle_count, .threads = 1, .metric = metric, .unit = unit, .clast = value};
    snprintf(row.workload, sizeof row.workload, "%s", work->name);
    return row;
}

static void add_plain(bench *b, const vulkan_work *work, const char *metric, const char *unit, double value, bool less)
{
    bench_row row = row_of(work, metric, unit, value);
    row.less_is_better = less;
    bench_add(b, row);
}

static void add_beside(bench *b, const vulkan_work *work, const char *metric, const char *unit, bool less,
                       bench_pair values, const char *peer)
{
    bench_row row = row_of(work, metric, unit, values.clast);
    row.less_is_better = less;
    if (work->peer.is_there) {
        snprintf(row.peer, sizeof row.peer, "%s", peer);
        row.peer_value = values.peer;
    }
    bench_add(b, row);
}

// ----------------------------------------------------------------------------------------------------------- structures

static void record_fill(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_fill(turn->work, commands);
}

static void record_fit(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_fit(turn->work, commands);
}

static void record_tree(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_tree(turn->work, commands, turn->order);
}

static void record_refit(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_tree_refit(turn->work, commands);
}

static void record_ready(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_fit(turn->work, commands);
    vulkan_tree(turn->work, commands, turn->order);
}

static void record_build(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    if (turn->update) {
        vulkan_peer_update(turn->work, commands);
    } else {
        vulkan_peer_build(turn->work, commands, turn->build);
    }
}

static double median_of(const bench *b, vulkan_turn turn)
{
    return alternate(b, &turn).clast;
}

// What fill and fit must write at least and, of meshes, read.
static double bytes_moved(const vulkan_work *work)
{
    double vertices = (double)work->vertices.bytes;
    double gathered = work->kind == VULKAN_MESH ? (double)work->positions.bytes + (double)work->numbers.bytes : 0.0;
    return vertices + gathered + (double)work->clusters.bytes + (double)work->boxes.bytes;
}

static void measure_parts(bench *b, vulkan_work *work, double copy)
{
    double fill = median_of(b, (vulkan_turn){.work = work, .record = record_fill});
    double fit = median_of(b, (vulkan_turn){.work = work, .record = record_fit});
    add_plain(b, work, "fill", "ms", fill, true);
    add_plain(b, work, "fill_fit", "ms", fit, true);
    add_plain(b, work, "fill_fit_rate", "Gtri/s", 1e-6 * work->triangle_count / fit, false);
    add_plain(b, work, "fill_fit_share", "of copy", 1e-6 * bytes_moved(work) / fit / copy, false);
    add_plain(b, work, "tree_kept", "ms",
              median_of(b, (vulkan_turn){.work = work, .record = record_tree, .order = CLAST_GPU_TREE_STORED}), true);
    add_plain(b, work, "tree_sorted", "ms",
              median_of(b, (vulkan_turn){.work = work, .record = record_tree, .order = CLAST_GPU_TREE_SORTED}), true);
    clast_gpu_commands *commands = vulkan_begin(work->device);
    vulkan_tree_keep(work, commands);
    vulkan_finish(work->device, commands);
    add_plain(b, work, "tree_refit", "ms", median_of(b, (vulkan_turn){.work = work, .record = record_refit}), true);
}

static void measure_ready(bench *b, vulkan_work *work)
{
    const struct {
        const char *metric, *peer;
        clast_gpu_tree_order order;
        clast_driver_build build;
        bool update;
    } kinds[] = {
        {"any_order_vs_build", "driver, fast build", CLAST_GPU_TREE_SORTED, CLAST_DRIVER_FAST_BUILD, false},
        {"ready_vs_trace_build", "driver, fast trace", CLAST_GPU_TREE_STORED, CLAST_DRIVER_FAST_TRACE, false},
        {"ready_vs_build", "driver, fast build", CLAST_GPU_TREE_STORED, CLAST_DRIVER_FAST_BUILD, false},
        {"ready_vs_update", "driver, update", CLAST_GPU_TREE_STORED, CLAST_DRIVER_FAST_BUILD, true},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        vulkan_turn turn = {.work = work,
                            .record = record_ready,
                            .record_peer = work->peer.is_there ? record_build : NULL,
                            .order = kinds[i].order,
                            .build = kinds[i].build,
                            .update = kinds[i].update};
        add_beside(b, work, kinds[i].metric, "ms", true, alternate(b, &turn), kinds[i].peer);
    }
}

static void measure_bytes(bench *b, const vulkan_work *work)
{
    const clast_gpu_buffer *const parts[] = {&work->vertices, &work->clusters,  &work->boxes,  &work->places,
                                             &work->pairs,    &work->templates, &work->inputs, &work->shape};
    double bytes = (double)work->tree_bytes;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        bytes += (double)parts[i]->bytes;
    }
    double triangles = work->triangle_count;
    if (work->kind == VULKAN_MESH) {
        bytes -= 4.0 * triangles; // corners beside the pairs are for those who shade
    }
    bench_pair values = {bytes / triangles, 0.0};
    if (work->peer.is_there) {
        values.peer = (double)vulkan_peer_bytes(work, CLAST_DRIVER_FAST_BUILD) / triangles;
    }
    add_beside(b, work, "bytes_per_triangle", "bytes", true, values, "driver, fast build");
}

// --------------------------------------------------------------------------------------------------------------- rays

static void record_trace(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_trace(turn->rays, commands, turn->diffuse);
}

static void record_trace_peer(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    vulkan_trace_peer(turn->rays, commands, turn->diffuse);
}

// Ends the program where the two tell hits apart: figures of rays that go wrong say nothing.
static void check_agreement(bench *b, const vulkan_rays *rays, bool diffuse, double count)
{
    vulkan_agreement a = vulkan_compare(rays, diffuse);
    double differ = 1e6 * ((double)a.one_alone + (double)a.distances) / (count > 0.0 ? count : 1.0);
    add_plain(b, rays->work, diffuse ? "diffuse_differ" : "primary_differ", "per million", differ, true);
    if (differ > DIFFER_MOST || a.hits == 0) {
        fprintf(stderr, "%s: %u hits, %u rays that one alone hits, %u distances that differ\n", rays->work->name,
                a.hits, a.one_alone, a.distances);
        exit(1);
    }
}

static void measure_rays(bench *b, vulkan_work *work)
{
    bool software = clast_gpu_features_of(work->device->gpu)->is_software;
    vulkan_rays rays;
    vulkan_rays_make(work, software ? 160 : 1920, software ? 96 : 1080, &rays);
    for (int diffuse = 0; diffuse < 2; diffuse++) {
        vulkan_turn turn = {.work = work,
                            .rays = &rays,
                            .record = record_trace,
                            .record_peer = work->peer.is_there ? record_trace_peer : NULL,
                            .diffuse = diffuse != 0};
        bench_pair times = alternate(b, &turn);
        double count = diffuse != 0 ? rays.diffuse_count : rays.primary_count;
        bench_pair rates = {1e-3 * count / times.clast, times.peer > 0.0 ? 1e-3 * count / times.peer : 0.0};
        add_beside(b, work, diffuse != 0 ? "diffuse" : "primary", "Mrays/s", false, rates, "driver, fast trace");
        if (work->peer.is_there) {
            check_agreement(b, &rays, diffuse != 0, count);
        }
    }
    vulkan_rays_free(&rays);
}

// ---------------------------------------------------------------------------------------------------------------- all

typedef struct copy_push {
    uint64_t from, to;
    uint32_t count;
} copy_push;

static clast_gpu_buffer copy_from, copy_to;

static void record_copy(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    (void)turn;
    copy_push push = {copy_from.address, copy_to.address, (uint32_t)(copy_from.bytes / 16)};
    clast_gpu_barrier(commands);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_COPY,
                                              .push = &push,
                                              .push_bytes = 20,
                                              .groups = ((uint64_t)push.count + 255) / 256});
    clast_gpu_barrier(commands);
}

// GB/s read and written.
static double measure_copy(bench *b, vulkan_device *device)
{
    uint64_t bytes = clast_gpu_features_of(device->gpu)->is_software ? COPY_BYTES_SOFTWARE : COPY_BYTES_HARDWARE;
    vulkan_allocate(device, bytes, "copied", &copy_from);
    vulkan_allocate(device, bytes, "copy", &copy_to);
    clast_gpu_commands *commands = vulkan_begin(device);
    clast_gpu_fill(commands, &copy_from, 0, bytes, 1);
    vulkan_finish(device, commands);
    vulkan_work work = {.device = device, .name = "copy"};
    double milliseconds = median_of(b, (vulkan_turn){.work = &work, .record = record_copy});
    double rate = 2e-6 * (double)bytes / milliseconds;
    add_plain(b, &work, "copy", "GB/s", rate, false);
    clast_gpu_free(device->gpu, &copy_from);
    clast_gpu_free(device->gpu, &copy_to);
    return rate;
}

static clast_gpu_sort_desc sorted; // what record_sort sorts

static void record_sort(const vulkan_turn *turn, clast_gpu_commands *commands)
{
    (void)turn;
    clast_gpu_sort(commands, &sorted);
    clast_gpu_barrier(commands);
}

static void measure_sort(bench *b, vulkan_device *device)
{
    uint32_t *keys = malloc(SORT_PAIRS * sizeof *keys), key = 1;
    vulkan_check(device, keys != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY);
    for (uint32_t i = 0; i < SORT_PAIRS; i++) {
        keys[i] = key = key * 1664525u + 1013904223u;
    }
    clast_gpu_buffer buffers[4], scratch;
    for (int i = 0; i < 4; i++) {
        vulkan_upload(device, keys, SORT_PAIRS * sizeof *keys, "sorted", &buffers[i]);
    }
    vulkan_allocate(device, CLAST_GPU_SORT_SCRATCH, "scratch of sorts", &scratch);
    sorted = (clast_gpu_sort_desc){.keys = buffers[0].address,
                                   .values = buffers[1].address,
                                   .spare_keys = buffers[2].address,
                                   .spare_values = buffers[3].address,
                                   .scratch = scratch.address,
                                   .count = SORT_PAIRS,
                                   .bits = 32,
                                   .numbered = true};
    vulkan_work work = {.device = device, .name = "sort", .triangle_count = SORT_PAIRS};
    add_plain(b, &work, "sort", "ms", median_of(b, (vulkan_turn){.work = &work, .record = record_sort}), true);
    for (int i = 0; i < 4; i++) {
        clast_gpu_free(device->gpu, &buffers[i]);
    }
    clast_gpu_free(device->gpu, &scratch);
    free(keys);
}

static void measure_work(bench *b, vulkan_device *device, vulkan_kind kind, vulkan_surface surface, uint32_t triangles,
                         double copy)
{
    vulkan_work work;
    vulkan_work_make(device, kind, surface, triangles, &work);
    measure_parts(b, &work, copy);
    measure_ready(b, &work);
    measure_bytes(b, &work);
    clast_gpu_commands *commands = vulkan_begin(device);
    vulkan_fit(&work, commands);
    vulkan_tree(&work, commands, CLAST_GPU_TREE_STORED); // which the rays go through
    vulkan_finish(device, commands);
    measure_rays(b, &work);
    vulkan_work_free(&work);
}

static void measure_all(bench *b, vulkan_device *device)
{
    const struct {
        const char *name;
        vulkan_kind kind;
        vulkan_surface surface;
    } works[] = {{"terrain, grids", VULKAN_GRIDS, VULKAN_TERRAIN},
                 {"sphere, grids", VULKAN_GRIDS, VULKAN_SPHERE},
                 {"terrain, patterns", VULKAN_PATTERNS, VULKAN_TERRAIN},
                 {"mesh, moved", VULKAN_MESH, VULKAN_TERRAIN}};
    const uint32_t sizes[] = {1u << 20, 1u << 23, 1u << 25};
    uint32_t size_count = b->options.triangles != 0 ? 1 : b->options.quick ? 2 : 3;
    double copy = measure_copy(b, device);
    measure_sort(b, device);
    for (size_t i = 0; i < sizeof works / sizeof *works; i++) {
        for (uint32_t s = 0; s < size_count && bench_wants(b, works[i].name); s++) {
            uint32_t triangles = b->options.triangles != 0 ? b->options.triangles : sizes[s];
            measure_work(b, device, works[i].kind, works[i].surface, triangles, copy);
        }
    }
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "vulkan", count, arguments);
    b.options.repetitions = b.options.quick ? TURNS_QUICK : TURNS;
    vulkan_device device = {0};
    if (!vulkan_open(&b, true, &device.context, &device.gpu)) {
        return BENCH_NO_DEVICE;
    }
    const clast_gpu_features *features = clast_gpu_features_of(device.gpu);
    vulkan_check(&device, clast_gpu_trees_create(device.gpu, &device.trees));
    if (features->ray_tracing) {
        vulkan_check(&device, clast_driver_create(device.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_COUNT_},
                                                  &device.driver));
    } else {
        fprintf(stderr, "%s has no ray tracing pipeline: there is no peer\n", features->name);
    }
    measure_all(&b, &device);
    clast_driver_destroy(device.driver);
    clast_gpu_trees_destroy(device.trees);
    vulkan_close(device.context, device.gpu);
    return bench_end(&b);
}
