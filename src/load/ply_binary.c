// SPDX-License-Identifier: Apache-2.0
// Binary PLY on all threads: vertices without lists lie at equal distances; faces are found by walking over their lengths once,
// which also counts the triangles, and cut side by side.
#include <stdatomic.h>

#include "base/thread.h"
#include "load/ply.h"

enum { VERTEX_GRAIN = 16384, FACE_GRAIN = 8192, CHUNKS_BETWEEN_PROGRESS = 256, LOOK = 1 << 17 };

static bool is_big_endian(const clast_ply_reader *reader)
{
    return reader->header.encoding == CLAST_PLY_BIG_ENDIAN;
}

static void note_least(atomic_size_t *least, size_t number)
{
    size_t known = atomic_load(least);
    while (number < known && !atomic_compare_exchange_weak(least, &known, number)) {
    }
}

// Runs a function over chunks, some at a time, with progress between; *first becomes the number of the first of those.
static clast_status run_chunks(clast_ply_reader *reader, size_t count, clast_range_function function, void *job,
                               size_t *first)
{
    clast_status status = CLAST_OK;
    for (size_t i = 0; status == CLAST_OK && i < count; i += CHUNKS_BETWEEN_PROGRESS) {
        size_t some = count - i < CHUNKS_BETWEEN_PROGRESS ? count - i : CHUNKS_BETWEEN_PROGRESS;
        *first = i;
        clast_parallel_for(reader->context, some, 1, function, job);
        status = clast_progress(reader->context, "load", i + some, count);
    }
    return status;
}

static clast_file_window *make_windows(const clast_ply_reader *reader)
{
    return clast_allocate_zeroed(reader->context, clast_worker_count(reader->context), sizeof(clast_file_window));
}

static void free_windows(const clast_ply_reader *reader, clast_file_window *windows)
{
    for (uint32_t i = 0; windows != NULL && i < clast_worker_count(reader->context); i++) {
        clast_file_free_window(reader->context, &windows[i]);
    }
    clast_free(reader->context, windows);
}

// ------------------------------------------------------------------------------------------------------------- vertices

// A value of a vertex: where it lies, and what it is for.
typedef struct vertex_value {
    size_t offset;
    clast_ply_type type;
    clast_ply_role role;
    double scale;
} vertex_value;

typedef struct vertex_job {
    size_t first_chunk;
    const clast_ply_reader *reader;
    clast_file_window *windows; // of each worker
    atomic_uint failed;         // a status
    size_t size;                // of a vertex
    const vertex_value *values;
    size_t value_count;
    atomic_size_t first_wrong; // vertex
} vertex_job;

static double read_value(const unsigned char *bytes, clast_ply_type type, bool big_endian)
{
    if (type == CLAST_PLY_FLOAT && !big_endian) {
        uint32_t word = clast_load_word(bytes);
        float value;
        memcpy(&value, &word, sizeof value);
        return (double)value;
    }
    return type == CLAST_PLY_UCHAR ? (double)bytes[0] : clast_ply_value(bytes, type, big_endian);
}

// Reads vertices [first, last) of the bytes at hand; false where one is wrong.
static bool read_some_vertices(vertex_job *job, const unsigned char *bytes, size_t first, size_t last)
{
    bool big_endian = is_big_endian(job->reader);
    for (size_t i = first; i < last; i++) {
        const unsigned char *vertex = bytes + (i - first) * job->size;
        double values[CLAST_PLY_ROLE_COUNT + 1] = {[CLAST_PLY_ALPHA] = 1.0};
        for (size_t k = 0; k < job->value_count; k++) {
            const vertex_value *value = &job->values[k];
            double number = read_value(vertex + value->offset, value->type, big_endian);
            values[value->role] = value->scale != 1.0 ? number / value->scale : number;
        }
        if (!clast_ply_store_vertex(job->reader, i, values)) {
            note_least(&job->first_wrong, i);
            return false;
        }
    }
    return true;
}

static void read_vertex_chunks(void *data, size_t begin, size_t end, uint32_t worker)
{
    vertex_job *job = data;
    size_t first = (job->first_chunk + begin) * VERTEX_GRAIN, last = (job->first_chunk + end) * VERTEX_GRAIN;
    size_t some = job->size < LOOK ? LOOK / job->size : 1, next;
    last = last < job->reader->vertex_count ? last : job->reader->vertex_count;
    for (size_t i = first; i < last; i = next) {
        const unsigned char *bytes;
        next = last - i < some ? last : i + some;
        clast_status status = clast_file_look(job->reader->file, &job->windows[worker],
                                              job->reader->position + i * job->size, (next - i) * job->size, &bytes);
        if (status != CLAST_OK) {
            atomic_store(&job->failed, (unsigned)status);
            return;
        }
        if (!read_some_vertices(job, bytes, i, next)) {
            return;
        }
    }
}

// Lists what there is to read of a vertex; false where a list makes vertices of different sizes.
static bool list_values(const clast_ply_reader *reader, const clast_ply_role *roles, vertex_value *values,
                        size_t *count, size_t *size)
{
    const clast_ply_element *element = reader->element;
    *count = *size = 0;
    for (size_t i = 0; i < element->property_count; i++) {
        const clast_ply_property *property = &reader->header.properties[element->first_property + i];
        if (property->is_list) {
            return false;
        }
        if (roles[i] != CLAST_PLY_NO_ROLE) {
            double scale = roles[i] >= CLAST_PLY_RED ? clast_ply_colour_scale(property->type) : 1.0;
            values[(*count)++] = (vertex_value){*size, property->type, roles[i], scale};
        }
        *size += clast_ply_type_size(property->type); // of 4096 properties at most
    }
    return true;
}

clast_status clast_ply_read_many_vertices(clast_ply_reader *reader, const clast_ply_role *roles)
{
    vertex_job job = {.reader = reader};
    if (reader->header.encoding == CLAST_PLY_ASCII) {
        return CLAST_OK;
    }
    vertex_value *values = clast_allocate(reader->context, reader->element->property_count, sizeof *values);
    job.windows = make_windows(reader);
    if (values == NULL || job.windows == NULL) {
        clast_free(reader->context, values);
        free_windows(reader, job.windows);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    if (list_values(reader, roles, values, &job.value_count, &job.size) && job.size != 0 &&
        reader->vertex_count <= (reader->bytes.size - reader->position) / job.size) {
        job.values = values;
        atomic_init(&job.first_wrong, reader->vertex_count);
        status = run_chunks(reader, ((size_t)reader->vertex_count + VERTEX_GRAIN - 1) / VERTEX_GRAIN,
                            read_vertex_chunks, &job, &job.first_chunk);
        status = status == CLAST_OK ? clast_ply_fail(reader, (clast_status)atomic_load(&job.failed)) : status;
        reader->item = atomic_load(&job.first_wrong);
        reader->position += reader->item * job.size;
    }
    clast_free(reader->context, values);
    free_windows(reader, job.windows);
    return status;
}

// ---------------------------------------------------------------------------------------------------------------- faces

// How a face is stored: bytes, the list of its vertices, bytes.
typedef struct face_form {
    size_t before, after;
    clast_ply_type length_type, index_type;
    size_t length_size, index_size;
} face_form;

// Where a chunk of faces begins.
typedef struct face_chunk {
    uint64_t offset;
    size_t triangle;
    uint64_t short_faces; // before it
} face_chunk;

typedef struct face_job {
    size_t first_chunk;
    const clast_ply_reader *reader;
    face_form form;
    const face_chunk *chunks;
    clast_polygon *polygons;    // of each worker
    clast_file_window *windows; // likewise
    uint32_t *indices;
    atomic_size_t first_wrong; // chunk
    atomic_uint failed;        // a status
} face_job;

static bool find_form(const clast_ply_reader *reader, face_form *form)
{
    const clast_ply_element *element = reader->element;
    bool is_found = false;
    *form = (face_form){0};
    for (size_t i = 0; i < element->property_count; i++) {
        const clast_ply_property *property = &reader->header.properties[element->first_property + i];
        size_t size = clast_ply_type_size(property->type);
        if (!property->is_list) {
            *(is_found ? &form->after : &form->before) += size;
            continue;
        }
        bool is_face = clast_word_is(property->name, "vertex_indices") || clast_word_is(property->name, "vertex_index");
        if (is_found || !is_face || property->type == CLAST_PLY_FLOAT || property->type == CLAST_PLY_DOUBLE) {
            return false;
        }
        is_found = true;
        form->length_type = property->count_type;
        form->index_type = property->type;
        form->length_size = clast_ply_type_size(property->count_type);
        form->index_size = size;
    }
    return is_found;
}

// A whole number; one that is negative becomes larger than any index.
static uint32_t read_whole(const unsigned char *bytes, clast_ply_type type, bool big_endian)
{
    switch (type) {
    case CLAST_PLY_UCHAR: return bytes[0];
    case CLAST_PLY_CHAR: return (uint32_t)(int32_t)(int8_t)bytes[0];
    case CLAST_PLY_SHORT:
    case CLAST_PLY_USHORT: {
        uint32_t value = (uint32_t)bytes[big_endian] | (uint32_t)bytes[!big_endian] << 8;
        return type == CLAST_PLY_SHORT ? (uint32_t)(int32_t)(int16_t)value : value;
    }
    default: {
        uint32_t value = clast_load_word(bytes);
        return big_endian ? __builtin_bswap32(value) : value;
    }
    }
}

// A look at some bytes, one place after another.
typedef struct face_walk {
    const clast_ply_reader *reader;
    clast_file_window window;
    const unsigned char *bytes;
    uint64_t begin, end; // what is in them
} face_walk;

// Bytes [position, position + length) of the file, which has them.
static clast_status look_ahead(face_walk *walk, uint64_t position, uint64_t length, const unsigned char **bytes)
{
    if (position < walk->begin || position + length > walk->end) {
        uint64_t left = walk->reader->bytes.size - position;
        size_t size = length > LOOK ? (size_t)length : left < LOOK ? (size_t)left : LOOK;
        clast_status status = clast_file_look(walk->reader->file, &walk->window, position, size, &walk->bytes);
        if (status != CLAST_OK) {
            return clast_ply_fail(walk->reader, status);
        }
        walk->begin = position;
        walk->end = position + size;
    }
    *bytes = walk->bytes + (position - walk->begin);
    return CLAST_OK;
}

// Walks over the faces; *fits is false where one does not fit into the file. `chunks` has one more than there are chunks.
static clast_status walk_faces(face_walk *walk, const face_form *form, face_chunk *chunks, bool *fits)
{
    const clast_ply_reader *reader = walk->reader;
    uint64_t position = reader->position, size = reader->bytes.size, short_faces = 0;
    size_t triangles = 0;
    *fits = false;
    for (uint64_t i = 0; i < reader->element->count; i++) {
        if (i % FACE_GRAIN == 0) {
            chunks[i / FACE_GRAIN] = (face_chunk){position, triangles, short_faces};
        }
        uint64_t head = form->before + form->length_size;
        if (size - position < head) {
            return CLAST_OK;
        }
        const unsigned char *bytes = NULL;
        clast_status status = look_ahead(walk, position, head, &bytes);
        if (status != CLAST_OK) {
            return status;
        }
        uint32_t length = read_whole(bytes + form->before, form->length_type, is_big_endian(reader));
        position += head;
        uint64_t rest = (uint64_t)length * form->index_size + form->after;
        if (length >= CLAST_NONE / 2 || size - position < rest) {
            return CLAST_OK;
        }
        position += rest;
        triangles += length >= 3 ? length - 2 : 0;
        short_faces += length < 3;
    }
    size_t count = (size_t)((reader->element->count + FACE_GRAIN - 1) / FACE_GRAIN);
    chunks[count] = (face_chunk){position, triangles, short_faces};
    *fits = true;
    return CLAST_OK;
}

static clast_status find_chunks(const clast_ply_reader *reader, const face_form *form, face_chunk *chunks, bool *fits)
{
    face_walk walk = {.reader = reader};
    clast_status status = walk_faces(&walk, form, chunks, fits);
    clast_file_free_window(reader->context, &walk.window);
    return status;
}

// Writes the triangles of a polygon whose vertices are the `length` numbers that `corners` stands for; false without memory.
static bool cut_face(face_job *job, clast_polygon *polygon, const unsigned char *list, uint32_t length, uint32_t *to)
{
    const clast_ply_reader *reader = job->reader;
    if (clast_polygon_reserve(reader->context, polygon, length) != CLAST_OK) {
        return false;
    }
    for (uint32_t i = 0; i < length; i++) {
        uint32_t vertex = read_whole(list + i * job->form.index_size, job->form.index_type, is_big_endian(reader));
        memcpy(polygon->points[i], reader->positions[vertex], sizeof *reader->positions);
    }
    clast_polygon_cut(polygon, length);
    for (uint32_t i = 0; i < 3 * (length - 2); i++) {
        to[i] = read_whole(list + polygon->corners[i] * job->form.index_size, job->form.index_type,
                           is_big_endian(reader));
    }
    return true;
}

// Reads a face of `length` corners; false where an index is out of range, or memory runs out.
static bool read_face(face_job *job, const unsigned char *list, uint32_t length, uint32_t worker, uint32_t *to)
{
    const clast_ply_reader *reader = job->reader;
    const face_form *form = &job->form;
    bool big_endian = is_big_endian(reader);
    for (uint32_t k = 0; k < length; k++) {
        uint32_t vertex = read_whole(list + k * form->index_size, form->index_type, big_endian);
        if (vertex >= reader->vertex_count) {
            return false;
        }
        if (length == 3) {
            to[k] = vertex;
        }
    }
    if (length > 3 && !cut_face(job, &job->polygons[worker], list, length, to)) {
        atomic_store(&job->failed, (unsigned)CLAST_ERROR_OUT_OF_MEMORY);
        return false;
    }
    return true;
}

// False where a face is wrong (also one that has another length than before), or the chunk cannot be had.
static bool read_face_chunk(face_job *job, size_t number, uint32_t worker)
{
    const clast_ply_reader *reader = job->reader;
    const face_form *form = &job->form;
    const face_chunk *chunk = &job->chunks[number];
    uint64_t left = reader->element->count - (uint64_t)number * FACE_GRAIN;
    uint64_t size = chunk[1].offset - chunk->offset, head = form->before + form->length_size, at = 0;
    size_t triangle = chunk->triangle;
    const unsigned char *bytes;
    clast_status status = clast_file_look(reader->file, &job->windows[worker], chunk->offset, (size_t)size, &bytes);
    if (status != CLAST_OK) {
        atomic_store(&job->failed, (unsigned)status);
        return false;
    }
    for (uint64_t i = 0; i < FACE_GRAIN && i < left; i++) {
        if (size - at < head) {
            return false;
        }
        uint32_t length = read_whole(bytes + at + form->before, form->length_type, is_big_endian(reader));
        uint64_t rest = (uint64_t)length * form->index_size + form->after;
        size_t triangles = length >= 3 ? length - 2 : 0;
        at += head;
        if (size - at < rest || triangles > chunk[1].triangle - triangle ||
            !read_face(job, bytes + at, length, worker, job->indices + 3 * triangle)) {
            return false;
        }
        triangle += triangles;
        at += rest;
    }
    return triangle == chunk[1].triangle;
}

static void read_face_chunks(void *data, size_t begin, size_t end, uint32_t worker)
{
    face_job *job = data;
    for (size_t i = job->first_chunk + begin; i < job->first_chunk + end; i++) {
        if (!read_face_chunk(job, i, worker)) {
            note_least(&job->first_wrong, i);
            return;
        }
    }
}

// Reads the faces of all chunks, or leaves the first that is wrong, and what follows, to the caller.
static clast_status read_chunks(clast_ply_reader *reader, face_job *job, size_t count)
{
    uint32_t workers = clast_worker_count(reader->context);
    reader->index_capacity = 3 * job->chunks[count].triangle;
    reader->indices = clast_allocate(reader->context, reader->index_capacity, sizeof *reader->indices);
    job->polygons = clast_allocate_zeroed(reader->context, workers, sizeof *job->polygons);
    job->windows = make_windows(reader);
    if (reader->indices == NULL || job->polygons == NULL || job->windows == NULL) {
        clast_free(reader->context, job->polygons);
        free_windows(reader, job->windows);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    job->indices = reader->indices;
    atomic_init(&job->first_wrong, count);
    clast_status status = run_chunks(reader, count, read_face_chunks, job, &job->first_chunk);
    size_t wrong = atomic_load(&job->first_wrong);
    for (uint32_t i = 0; i < workers; i++) {
        clast_polygon_free(reader->context, &job->polygons[i]);
    }
    clast_free(reader->context, job->polygons);
    free_windows(reader, job->windows);
    reader->item = wrong < count ? (uint64_t)wrong * FACE_GRAIN : reader->element->count;
    reader->position = job->chunks[wrong].offset;
    reader->index_count = 3 * job->chunks[wrong].triangle;
    reader->short_faces += job->chunks[wrong].short_faces;
    return status == CLAST_OK ? clast_ply_fail(reader, (clast_status)atomic_load(&job->failed)) : status;
}

clast_status clast_ply_read_many_faces(clast_ply_reader *reader)
{
    face_job job = {.reader = reader};
    if (reader->header.encoding == CLAST_PLY_ASCII || reader->indices != NULL || !find_form(reader, &job.form)) {
        return CLAST_OK;
    }
    size_t count = (size_t)((reader->element->count + FACE_GRAIN - 1) / FACE_GRAIN); // the file has room for the faces
    face_chunk *chunks = clast_allocate(reader->context, count + 1, sizeof *chunks);
    if (chunks == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    job.chunks = chunks;
    bool fits;
    clast_status status = find_chunks(reader, &job.form, chunks, &fits);
    if (status == CLAST_OK && fits && chunks[count].triangle <= UINT32_MAX / 3) {
        status = read_chunks(reader, &job, count);
    }
    clast_free(reader->context, chunks);
    return status;
}
