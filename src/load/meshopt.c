// SPDX-License-Identifier: Apache-2.0
// The three kinds of streams (KHR_meshopt_compression, appendix A).
#include "load/meshopt.h"

enum {
    GROUP = 16, // elements whose deltas are coded together
    BLOCK_BYTES = 8192,
    BLOCK_MOST = 256,
    STRIDE_MOST = 256,
    FIFO = 16,
    CODE_TABLE = 16,
};

static const char truncated[] = "it ends too early";
static const char too_long[] = "there are bytes after its last element";

// What is left of a stream.
typedef struct reader {
    const unsigned char *at, *end;
} reader;

static size_t left_in(const reader *r)
{
    return (size_t)(r->end - r->at);
}

// The next bytes; null where there are fewer.
static const unsigned char *take(reader *r, size_t count)
{
    if (count > left_in(r)) {
        return NULL;
    }
    const unsigned char *bytes = r->at;
    r->at += count;
    return bytes;
}

// ---------------------------------------------------------------------------------------------------------- attributes

typedef struct attributes {
    reader data;
    bool version_1;
    uint32_t stride;
    const unsigned char *channels; // a mode for each four bytes
    unsigned char previous[STRIDE_MOST];
} attributes;

// Sixteen deltas of `bits` bits each; those with all bits set follow as bytes. A single bit's lowest comes first, others'
// highest.
static bool read_group(reader *r, uint32_t bits, unsigned char deltas[GROUP])
{
    if (bits == 0) {
        memset(deltas, 0, GROUP);
        return true;
    }
    const unsigned char *packed = take(r, GROUP * bits / 8);
    if (packed == NULL) {
        return false;
    }
    if (bits == 8) {
        memcpy(deltas, packed, GROUP);
        return true;
    }
    uint32_t per_byte = 8 / bits, sentinel = (1u << bits) - 1;
    for (uint32_t i = 0; i < GROUP; i++) {
        uint32_t place = bits == 1 ? i % per_byte : per_byte - 1 - i % per_byte;
        uint32_t delta = (uint32_t)packed[i / per_byte] >> (place * bits) & sentinel;
        if (delta == sentinel) {
            const unsigned char *whole = take(r, 1);
            if (whole == NULL) {
                return false;
            }
            delta = *whole;
        }
        deltas[i] = (unsigned char)delta;
    }
    return true;
}

// The deltas of one byte of a block's elements. `control`: 0 and 1 say which lengths may follow, 2 that all are zero, 3 that
// they are stored as they are.
static bool read_deltas(attributes *a, uint32_t control, uint32_t count, unsigned char deltas[BLOCK_MOST])
{
    static const unsigned char lengths[3][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}, {0, 2, 4, 8}};
    if (control == 2) {
        memset(deltas, 0, count);
        return true;
    }
    if (control == 3) {
        const unsigned char *whole = take(&a->data, count);
        if (whole != NULL) {
            memcpy(deltas, whole, count);
        }
        return whole != NULL;
    }
    uint32_t groups = (count + GROUP - 1) / GROUP;
    const unsigned char *headers = take(&a->data, (groups + 3) / 4);
    const unsigned char *of = lengths[a->version_1 ? control : 2];
    for (uint32_t i = 0; headers != NULL && i < groups; i++) {
        if (!read_group(&a->data, of[headers[i / 4] >> (i % 4 * 2) & 3], deltas + (size_t)i * GROUP)) {
            return false;
        }
    }
    return headers != NULL;
}

static unsigned char unfold8(unsigned char v)
{
    return (unsigned char)((v & 1) != 0 ? ~(v >> 1) : v >> 1);
}

static uint16_t unfold16(uint16_t v)
{
    return (uint16_t)((v & 1) != 0 ? ~(v >> 1) : v >> 1);
}

static uint32_t unfold32(uint32_t v)
{
    return (v & 1) != 0 ? ~(v >> 1) : v >> 1;
}

static void add_byte_deltas(unsigned char deltas[4][BLOCK_MOST], uint32_t i, unsigned char *previous)
{
    for (uint32_t k = 0; k < 4; k++) {
        previous[k] = (unsigned char)(previous[k] + unfold8(deltas[k][i]));
    }
}

static void add_pair_deltas(unsigned char deltas[4][BLOCK_MOST], uint32_t i, unsigned char *previous)
{
    for (uint32_t k = 0; k < 4; k += 2) {
        uint16_t value = (uint16_t)(previous[k] | previous[k + 1] << 8);
        value = (uint16_t)(value + unfold16((uint16_t)(deltas[k][i] | deltas[k + 1][i] << 8)));
        previous[k] = (unsigned char)value;
        previous[k + 1] = (unsigned char)(value >> 8);
    }
}

static void turn_word(unsigned char deltas[4][BLOCK_MOST], uint32_t i, uint32_t turn, unsigned char *previous)
{
    uint32_t delta = 0;
    for (uint32_t k = 0; k < 4; k++) {
        delta |= (uint32_t)deltas[k][i] << (8 * k);
    }
    delta = delta << turn | delta >> ((32 - turn) & 31);
    for (uint32_t k = 0; k < 4; k++) {
        previous[k] = (unsigned char)(previous[k] ^ delta >> (8 * k));
    }
}

// Four bytes of each of a block's elements.
static bool decode_channel(attributes *a, uint32_t channel, uint32_t controls, uint32_t count, unsigned char *decoded)
{
    unsigned char deltas[4][BLOCK_MOST];
    for (uint32_t k = 0; k < 4; k++) {
        if (!read_deltas(a, controls >> (2 * k) & 3u, count, deltas[k])) {
            return false;
        }
    }
    uint32_t mode = a->channels != NULL ? a->channels[channel] : 0;
    unsigned char *previous = a->previous + 4 * (size_t)channel;
    for (uint32_t i = 0; i < count; i++) {
        switch (mode & 15u) {
        case 0: add_byte_deltas(deltas, i, previous); break;
        case 1: add_pair_deltas(deltas, i, previous); break;
        default: turn_word(deltas, i, mode >> 4, previous); break;
        }
        memcpy(decoded + (size_t)i * a->stride + 4 * (size_t)channel, previous, 4);
    }
    return true;
}

// The first element's base and the channels' modes, at the end; zeros before them make up a least length.
static const char *read_tail(attributes *a, const clast_meshopt_stream *stream)
{
    size_t channels = a->version_1 ? stream->stride / 4 : 0, needed = stream->stride + channels;
    size_t least = a->version_1 ? 24 : 32, tail = needed > least ? needed : least;
    if (left_in(&a->data) < tail) {
        return truncated;
    }
    memcpy(a->previous, a->data.end - needed, stream->stride);
    a->channels = a->version_1 ? a->data.end - channels : NULL;
    for (size_t i = 0; i < channels; i++) {
        if ((a->channels[i] & 15) > 2 || ((a->channels[i] & 15) < 2 && a->channels[i] >> 4 != 0)) {
            return "the mode of a channel is none of those that there are";
        }
    }
    a->data.end -= tail;
    return NULL;
}

static const char *decode_attributes(const clast_meshopt_stream *stream, reader r, unsigned char *decoded)
{
    const unsigned char *header = take(&r, 1);
    if (header == NULL || *header < 0xa0 || *header > (stream->version_1 ? 0xa1 : 0xa0)) {
        return stream->version_1 ? "its first byte is not a0 or a1" : "its first byte is not a0";
    }
    attributes a = {.data = r, .version_1 = *header == 0xa1, .stride = stream->stride};
    const char *fault = read_tail(&a, stream);
    uint32_t block_most = BLOCK_BYTES / stream->stride & ~(uint32_t)(GROUP - 1);
    block_most = block_most < BLOCK_MOST ? block_most : BLOCK_MOST;
    for (uint64_t done = 0; fault == NULL && done < stream->count;) {
        uint64_t left = stream->count - done;
        uint32_t count = left < block_most ? (uint32_t)left : block_most;
        const unsigned char *controls = a.version_1 ? take(&a.data, stream->stride / 4) : NULL;
        for (uint32_t channel = 0; channel < stream->stride / 4; channel++) {
            if ((a.version_1 && controls == NULL) ||
                !decode_channel(&a, channel, controls != NULL ? controls[channel] : 0, count,
                                decoded + done * stream->stride)) {
                return truncated;
            }
        }
        done += count;
    }
    return fault != NULL ? fault : left_in(&a.data) != 0 ? too_long : NULL;
}

// ------------------------------------------------------------------------------------------------------------- indices

// One to five bytes of seven bits each, the low ones first.
static bool read_number(reader *r, uint32_t *number)
{
    *number = 0;
    for (uint32_t i = 0; i < 5; i++) {
        const unsigned char *byte = take(r, 1);
        if (byte == NULL) {
            return false;
        }
        *number |= (uint32_t)(*byte & 127) << (7 * i);
        if (*byte < 128) {
            return true;
        }
    }
    return false;
}

static void store_index(const clast_meshopt_stream *stream, uint64_t i, uint32_t index, unsigned char *decoded)
{
    for (uint32_t k = 0; k < stream->stride; k++) {
        decoded[i * stream->stride + k] = (unsigned char)(index >> (8 * k));
    }
}

static const char *decode_indices(const clast_meshopt_stream *stream, reader r, unsigned char *decoded)
{
    enum { PADDING = 4 };
    const unsigned char *header = take(&r, 1);
    if (header == NULL || *header != 0xd1) {
        return "its first byte is not d1";
    }
    if (left_in(&r) < PADDING) {
        return truncated;
    }
    r.end -= PADDING;
    uint32_t last[2] = {0, 0};
    for (uint64_t i = 0; i < stream->count; i++) {
        uint32_t number;
        if (!read_number(&r, &number)) {
            return truncated;
        }
        last[number & 1] += unfold32(number >> 1);
        store_index(stream, i, last[number & 1], decoded);
    }
    return left_in(&r) != 0 ? too_long : NULL;
}

// ----------------------------------------------------------------------------------------------------------- triangles

typedef struct triangles {
    reader data;
    const unsigned char *table;
    uint32_t next, last;
    uint32_t edges[FIFO][2], vertices[FIFO];
    uint32_t edge_count, vertex_count; // ever pushed: the newest is the last
    const char *fault;
} triangles;

static void push_edge(triangles *t, uint32_t a, uint32_t b)
{
    uint32_t *edge = t->edges[t->edge_count % FIFO];
    edge[0] = a;
    edge[1] = b;
    t->edge_count = t->edge_count + 1 == 2 * FIFO ? FIFO : t->edge_count + 1;
}

static void push_vertex(triangles *t, uint32_t vertex)
{
    t->vertices[t->vertex_count % FIFO] = vertex;
    t->vertex_count = t->vertex_count + 1 == 2 * FIFO ? FIFO : t->vertex_count + 1;
}

static const char unwritten[] = "it uses an edge or a vertex that has not been there";

static uint32_t recent_vertex(triangles *t, uint32_t age)
{
    if (age >= t->vertex_count) {
        t->fault = unwritten;
        return 0;
    }
    return t->vertices[(t->vertex_count - 1 - age) % FIFO];
}

static uint32_t read_index(triangles *t)
{
    uint32_t number;
    if (!read_number(&t->data, &number)) {
        t->fault = truncated;
        return 0;
    }
    t->last += unfold32(number);
    return t->last;
}

// A corner by its code: 0 a new vertex, 15 one that is spelt out, else a recent one. New ones become recent.
static uint32_t coded_vertex(triangles *t, uint32_t code)
{
    return code == 0 ? t->next++ : code == 15 ? read_index(t) : recent_vertex(t, code - 1);
}

static void remember_triangle(triangles *t, const uint32_t v[3], uint32_t code_b, uint32_t code_c)
{
    push_edge(t, v[1], v[0]);
    push_edge(t, v[2], v[1]);
    push_edge(t, v[0], v[2]);
    push_vertex(t, v[0]);
    if (code_b == 0 || code_b == 15) {
        push_vertex(t, v[1]);
    }
    if (code_c == 0 || code_c == 15) {
        push_vertex(t, v[2]);
    }
}

// Codes f0 to ff: a triangle that shares no recent edge.
static void decode_apart(triangles *t, uint32_t code, uint32_t v[3])
{
    uint32_t pair = code < 14 ? t->table[code] : 0;
    if (code >= 14) {
        const unsigned char *byte = take(&t->data, 1);
        if (byte == NULL) {
            t->fault = truncated;
            return;
        }
        pair = *byte;
        t->next = pair == 0 ? 0 : t->next; // a stream may hold several, one after the other
    }
    v[0] = code == 15 ? read_index(t) : t->next++;
    v[1] = coded_vertex(t, pair >> 4);
    v[2] = coded_vertex(t, pair & 15u);
    remember_triangle(t, v, pair >> 4, pair & 15u);
}

// Other codes: a recent edge, and a third corner.
static void decode_beside(triangles *t, uint32_t age, uint32_t code, uint32_t v[3])
{
    if (age >= t->edge_count) {
        t->fault = unwritten;
        return;
    }
    const uint32_t *edge = t->edges[(t->edge_count - 1 - age) % FIFO];
    v[0] = edge[0];
    v[1] = edge[1];
    switch (code) {
    case 0: v[2] = t->next++; break;
    case 13: v[2] = --t->last; break;
    case 14: v[2] = ++t->last; break;
    case 15: v[2] = read_index(t); break;
    default: v[2] = recent_vertex(t, code); break;
    }
    push_edge(t, v[2], v[1]);
    push_edge(t, v[0], v[2]);
    if (code == 0 || code >= 13) {
        push_vertex(t, v[2]);
    }
}

static const char *check_table(const unsigned char *table)
{
    for (uint32_t i = 0; i < CODE_TABLE; i++) {
        if (table[i] >> 4 == 15 || (table[i] & 15) == 15 || (i >= 14 && table[i] != 0)) {
            return "its table of codes holds what it must not";
        }
    }
    return NULL;
}

static const char *decode_triangles(const clast_meshopt_stream *stream, reader r, unsigned char *decoded)
{
    const unsigned char *header = take(&r, 1);
    if (header == NULL || *header != 0xe1) {
        return "its first byte is not e1";
    }
    uint64_t count = stream->count / 3;
    if (left_in(&r) < CODE_TABLE || left_in(&r) - CODE_TABLE < count) {
        return truncated;
    }
    r.end -= CODE_TABLE;
    const unsigned char *codes = take(&r, (size_t)count);
    triangles t = {.data = r, .table = r.end, .fault = check_table(r.end)};
    for (uint64_t i = 0; t.fault == NULL && i < count; i++) {
        uint32_t v[3] = {0, 0, 0};
        if (codes[i] >= 0xf0) {
            decode_apart(&t, codes[i] & 15u, v);
        } else {
            decode_beside(&t, codes[i] >> 4, codes[i] & 15u, v);
        }
        for (uint32_t corner = 0; corner < 3; corner++) {
            store_index(stream, 3 * i + corner, v[corner], decoded);
        }
    }
    return t.fault != NULL ? t.fault : left_in(&t.data) != 0 ? too_long : NULL;
}

// ----------------------------------------------------------------------------------------------------------------- all

const char *clast_meshopt_check(const clast_meshopt_stream *stream)
{
    uint32_t stride = stream->stride;
    if (stream->mode != CLAST_MESHOPT_ATTRIBUTES) {
        return stride != 2 && stride != 4             ? "expected a byteStride of 2 or 4 with indices"
               : stream->filter != CLAST_MESHOPT_NONE ? "expected no filter with indices"
               : stream->mode == CLAST_MESHOPT_TRIANGLES && stream->count % 3 != 0
                   ? "expected a count that is a multiple of 3 with triangles"
                   : NULL;
    }
    if (stride < 4 || stride > STRIDE_MOST || stride % 4 != 0) {
        return "expected a byteStride that is a multiple of 4, up to 256, with attributes";
    }
    switch (stream->filter) {
    case CLAST_MESHOPT_COLOUR:
        if (!stream->version_1) {
            return "expected no filter COLOR: only KHR_meshopt_compression has it";
        }
        return stride == 4 || stride == 8 ? NULL : "expected a byteStride of 4 or 8 with the filter COLOR";
    case CLAST_MESHOPT_OCTAHEDRAL:
        return stride == 4 || stride == 8 ? NULL : "expected a byteStride of 4 or 8 with the filter OCTAHEDRAL";
    case CLAST_MESHOPT_QUATERNION: return stride == 8 ? NULL : "expected a byteStride of 8 with the filter QUATERNION";
    default: return NULL;
    }
}

const char *clast_meshopt_decode(const clast_meshopt_stream *stream, clast_bytes bytes, unsigned char *decoded)
{
    reader r = {bytes.data, bytes.data + bytes.size};
    const char *fault = NULL;
    switch (stream->mode) {
    case CLAST_MESHOPT_ATTRIBUTES: fault = decode_attributes(stream, r, decoded); break;
    case CLAST_MESHOPT_TRIANGLES: fault = decode_triangles(stream, r, decoded); break;
    case CLAST_MESHOPT_INDICES: fault = decode_indices(stream, r, decoded); break;
    }
    if (fault == NULL && stream->mode == CLAST_MESHOPT_ATTRIBUTES) {
        clast_meshopt_apply_filter(stream, decoded);
    }
    return fault;
}
