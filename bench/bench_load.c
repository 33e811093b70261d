// SPDX-License-Identifier: Apache-2.0
// Reading large meshes from files, beside tinyobjloader (OBJ) and assimp (OBJ and PLY), from the path of a file to arrays of
// triangles. The files are written here: a terrain with normals and texture coordinates as OBJ, one with normals as binary PLY.
//
//   load            megabytes of the file a second
//   memory          the most memory that clast held, what it held of the file included, over what the scene keeps; the goal is 1.3
//   memory_process  the same of the process's resident memory, of a process that does nothing else
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/thread.h"
#include "bench.h"
#include "clast/clast.h"
#include "load_tinyobj.h"

typedef struct job {
    clast_context *context;
    char path[256];
    double megabytes;
    double kept, peak, process; // bytes
} job;

// ---------------------------------------------------------------------------------------------------------------- files

static float height_at(uint32_t x, uint32_t y)
{
    return 0.3f * sinf((float)x * 0.031f) * cosf((float)y * 0.027f) + 0.02f * sinf((float)(x * 7 + y * 3));
}

static FILE *create(const char *path)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        fprintf(stderr, "%s cannot be written\n", path);
        exit(1);
    }
    return file;
}

static void close_file(FILE *file, const char *path)
{
    if (fclose(file) != 0) {
        fprintf(stderr, "%s cannot be written\n", path);
        exit(1);
    }
}

// Corners as programs write them: position, texture coordinate and normal of one number.
static void write_obj(const char *path, uint32_t side)
{
    FILE *file = create(path);
    for (uint32_t i = 0; i < side * side; i++) {
        fprintf(file, "v %.6f %.6f %.6f\n", (double)(i % side) * 0.01, (double)(i / side) * 0.01,
                (double)height_at(i % side, i / side));
    }
    for (uint32_t i = 0; i < side * side; i++) {
        fprintf(file, "vt %.6f %.6f\n", (double)(i % side) / side, (double)(i / side) / side);
    }
    for (uint32_t i = 0; i < side * side; i++) {
        float slope = height_at(i % side + 1, i / side) - height_at(i % side, i / side);
        fprintf(file, "vn %.4f %.4f %.4f\n", (double)-slope, 0.0, 1.0);
    }
    for (uint32_t y = 0; y + 1 < side; y++) {
        for (uint32_t x = 0; x + 1 < side; x++) {
            uint32_t a = y * side + x + 1, b = a + 1, c = a + side, d = c + 1;
            fprintf(file, "f %u/%u/%u %u/%u/%u %u/%u/%u\nf %u/%u/%u %u/%u/%u %u/%u/%u\n", a, a, a, b, b, b, d, d, d, a,
                    a, a, d, d, d, c, c, c);
        }
    }
    close_file(file, path);
}

static void write_ply(const char *path, uint32_t side)
{
    FILE *file = create(path);
    fprintf(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex %u\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nelement face %u\n"
        "property list uchar int vertex_indices\nend_header\n",
        side * side, 2 * (side - 1) * (side - 1));
    for (uint32_t i = 0; i < side * side; i++) {
        float slope = height_at(i % side + 1, i / side) - height_at(i % side, i / side);
        const float vertex[6] = {
            (float)(i % side), (float)(i / side), height_at(i % side, i / side), -slope, 0.0f, 1.0f};
        fwrite(vertex, sizeof vertex, 1, file);
    }
    for (uint32_t y = 0; y + 1 < side; y++) {
        for (uint32_t x = 0; x + 1 < side; x++) {
            uint32_t a = y * side + x, faces[2][3] = {{a, a + 1, a + side + 1}, {a, a + side + 1, a + side}};
            for (int i = 0; i < 2; i++) {
                fputc(3, file);
                fwrite(faces[i], sizeof faces[i], 1, file);
            }
        }
    }
    close_file(file, path);
}

// -------------------------------------------------------------------------------------------------------------- readers

static double load_clast(void *data)
{
    job *j = data;
    clast_scene *scene;
    double before = bench_seconds();
    bench_check(clast_scene_load(j->context, j->path, &scene), j->context);
    double seconds = bench_seconds() - before;
    j->kept = (double)clast_context_memory(j->context);
    j->peak = (double)clast_context_memory_peak(j->context);
    clast_scene_destroy(scene);
    return seconds;
}

// Loads in a process of its own, as memory that was given back to this one's heap would hide what is taken.
static void measure_memory(job *j)
{
    double bytes[3] = {0};
    int ends[2];
    if (pipe(ends) != 0) {
        exit(1);
    }
    pid_t child = fork();
    if (child == 0) {
        uint64_t before = clast_process_memory_peak();
        clast_context_desc desc = {.threads = 1};
        if (clast_context_create(&desc, &j->context) != CLAST_OK) {
            _exit(1);
        }
        load_clast(j);
        const double measured[3] = {j->kept, j->peak, (double)(clast_process_memory_peak() - before)};
        _exit(write(ends[1], measured, sizeof measured) != (ssize_t)sizeof measured);
    }
    close(ends[1]);
    bool is_whole = child > 0 && read(ends[0], bytes, sizeof bytes) == (ssize_t)sizeof bytes;
    close(ends[0]);
    if (!is_whole || waitpid(child, NULL, 0) != child) {
        fprintf(stderr, "%s cannot be loaded in another process\n", j->path);
        exit(1);
    }
    j->kept = bytes[0];
    j->peak = bytes[1];
    j->process = bytes[2];
}

static double load_assimp(void *data)
{
    const job *j = data;
    double before = bench_seconds();
    const struct aiScene *scene = aiImportFile(j->path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
    double seconds = bench_seconds() - before;
    if (scene == NULL) {
        fprintf(stderr, "assimp: %s\n", aiGetErrorString());
        exit(1);
    }
    aiReleaseImport(scene);
    return seconds;
}

static double load_tinyobj(void *data)
{
    const job *j = data;
    double before = bench_seconds();
    if (!tinyobj_load(j->path)) {
        fprintf(stderr, "tinyobjloader cannot read %s\n", j->path);
        exit(1);
    }
    return bench_seconds() - before;
}

// ----------------------------------------------------------------------------------------------------------------- rows

typedef struct workload {
    const char *name, *file;
    void (*write)(const char *path, uint32_t side);
    uint32_t factor; // triangles for one of the option
    const char *peer;
    double (*load_peer)(void *data);
    job job; // with what it takes of memory
} workload;

static uint32_t side_of(const bench *b, const workload *w)
{
    uint32_t triangles = (b->options.triangles != 0 ? b->options.triangles : 1000000) * w->factor;
    return (uint32_t)sqrt((double)triangles / 2.0) + 1;
}

static void prepare(const bench *b, workload *w, const char *folder)
{
    struct stat status;
    snprintf(w->job.path, sizeof w->job.path, "%s/%s", folder, w->file);
    if (stat(w->job.path, &status) != 0) {
        w->write(w->job.path, side_of(b, w));
    }
    measure_memory(&w->job);
}

static void measure(bench *b, const workload *w, uint32_t threads)
{
    job j = w->job;
    struct stat status;
    uint32_t side = side_of(b, w);
    if (stat(j.path, &status) != 0 ||
        clast_context_create(&(clast_context_desc){.threads = threads}, &j.context) != CLAST_OK) {
        exit(1);
    }
    double megabytes = (double)status.st_size / 1e6;
    bench_pair seconds = bench_alternate(b, load_clast, w->load_peer, &j);
    bench_row row = {.triangles = 2 * (uint64_t)(side - 1) * (side - 1),
                     .threads = threads,
                     .metric = "load",
                     .unit = "MB/s",
                     .clast = megabytes / seconds.clast,
                     .peer_value = megabytes / seconds.peer};
    snprintf(row.workload, sizeof row.workload, "%s", w->name);
    snprintf(row.peer, sizeof row.peer, "%s", w->peer);
    bench_add(b, row);
    const struct {
        const char *metric;
        double bytes;
    } memory[] = {{"memory", w->job.peak}, {"memory_process", w->job.process}};
    for (int i = 0; threads == 1 && i < 2; i++) {
        row.metric = memory[i].metric;
        row.unit = "x kept";
        row.less_is_better = true;
        row.clast = memory[i].bytes / w->job.kept;
        row.peer_value = 1.3;
        snprintf(row.peer, sizeof row.peer, "goal");
        bench_add(b, row);
    }
    clast_context_destroy(j.context);
}

int main(int count, char **arguments)
{
    static workload workloads[] = {
        {"OBJ", "terrain.obj", write_obj, 1, "tinyobjloader", load_tinyobj, {0}},
        {"OBJ", "terrain.obj", write_obj, 1, "assimp", load_assimp, {0}},
        {"binary PLY", "terrain.ply", write_ply, 4, "assimp", load_assimp, {0}},
    };
    bench b;
    bench_begin(&b, "load", count, arguments);
    char folder[128];
    snprintf(folder, sizeof folder, "%s/clast-bench-XXXXXX", getenv("TMPDIR") != NULL ? getenv("TMPDIR") : "/tmp");
    if (mkdtemp(folder) == NULL) {
        fprintf(stderr, "no folder can be made in %s\n", folder);
        return 1;
    }
    for (size_t i = 0; i < sizeof workloads / sizeof *workloads; i++) { // before this process holds any
        if (bench_wants(&b, workloads[i].name)) {
            prepare(&b, &workloads[i], folder);
        }
    }
    for (size_t i = 0; i < sizeof workloads / sizeof *workloads; i++) {
        for (uint32_t threads = 1; bench_wants(&b, workloads[i].name) && threads <= 2; threads++) {
            if (b.options.threads == 0 || b.options.threads == threads) {
                measure(&b, &workloads[i], threads);
            }
        }
    }
    for (size_t i = 0; i < sizeof workloads / sizeof *workloads; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", folder, workloads[i].file);
        unlink(path);
    }
    rmdir(folder);
    return bench_end(&b);
}
