// SPDX-License-Identifier: Apache-2.0
// Compressed streams, made by the library whose format they have (version 0), and written out by hand (version 1).
#include <math.h>
#include <stdlib.h>

#include "test.h"

#include "load/meshopt.h"
#ifdef CLAST_TESTS_WITH_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

static const char *decode(clast_meshopt_stream stream, const unsigned char *bytes, size_t size, void *decoded)
{
    // A copy of exactly that length, so that a sanitizer sees what is read beyond it.
    unsigned char *copy = malloc(size + 1);
    memcpy(copy + 1, bytes, size);
    const char *fault = clast_meshopt_decode(&stream, (clast_bytes){copy + 1, size}, decoded);
    free(copy);
    return fault;
}

// --------------------------------------------------------------------------------------------------------- by the peer

#ifdef CLAST_TESTS_WITH_MESHOPTIMIZER

typedef struct randoms {
    uint64_t state;
} randoms;

static uint32_t random_bits(randoms *r)
{
    r->state = r->state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(r->state >> 33);
}

// Cuts a stream at every length and turns its bits: whatever comes, nothing outside is touched.
static void break_stream(clast_meshopt_stream stream, unsigned char *bytes, size_t size, unsigned char *decoded)
{
    for (size_t length = 0; length < size; length++) {
        assert_non_null(decode(stream, bytes, length, decoded));
    }
    for (size_t i = 0; i < size; i++) {
        for (uint32_t bit = 0; bit < 8; bit++) {
            bytes[i] ^= (unsigned char)(1u << bit);
            decode(stream, bytes, size, decoded);
            bytes[i] ^= (unsigned char)(1u << bit);
        }
    }
}

static void attributes_of_any_stride_and_count_come_back(void **state)
{
    (void)state;
    randoms r = {1};
    for (uint32_t stride = 4; stride <= 256; stride += stride < 32 ? 4 : 28) {
        for (uint32_t round = 0; round < 12; round++) {
            size_t count = round < 4 ? round * 16 + 1 : random_bits(&r) % 700 + 1;
            unsigned char *data = malloc(count * stride), *decoded = malloc(count * stride);
            for (size_t i = 0; i < count * stride; i++) { // some bytes still, some slow, some wild
                uint32_t step = i % stride % 3 == 0 ? 0 : i % stride % 3 == 1 ? random_bits(&r) % 5 : random_bits(&r);
                data[i] = (unsigned char)((i >= stride ? data[i - stride] : 7) + step);
            }
            size_t room = meshopt_encodeVertexBufferBound(count, stride);
            unsigned char *bytes = malloc(room);
            size_t size = meshopt_encodeVertexBuffer(bytes, room, data, count, stride);
            clast_meshopt_stream stream = {.count = count, .stride = stride};
            assert_null(clast_meshopt_check(&stream));
            assert_null(decode(stream, bytes, size, decoded));
            assert_memory_equal(decoded, data, count * stride);
            if (round == 2 && stride <= 12) {
                break_stream(stream, bytes, size, decoded);
            }
            free(bytes);
            free(decoded);
            free(data);
        }
    }
}

static uint32_t *grid_indices(uint32_t side, uint64_t seed, size_t *count)
{
    randoms r = {seed};
    *count = 6 * (size_t)side * side;
    uint32_t *indices = malloc(*count * sizeof *indices);
    for (uint32_t i = 0; i < side * side; i++) {
        uint32_t a = i / side * (side + 1) + i % side;
        const uint32_t quad[6] = {a, a + 1, a + side + 1, a + side + 1, a + 1, a + side + 2};
        memcpy(indices + 6 * (size_t)i, quad, sizeof quad);
    }
    for (size_t i = 0; i < *count / 20 * seed; i++) { // some triangles from nowhere
        indices[random_bits(&r) % *count] = random_bits(&r) % ((side + 1) * (side + 1));
    }
    return indices;
}

static void triangles_come_back_as_the_peer_decodes_them(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 12; seed++) {
        size_t count;
        uint32_t *indices = grid_indices(seed % 4 * 17 + 2, seed, &count);
        size_t room = meshopt_encodeIndexBufferBound(count, 4096);
        unsigned char *bytes = malloc(room);
        meshopt_encodeIndexVersion(1);
        size_t size = meshopt_encodeIndexBuffer(bytes, room, indices, count);
        uint32_t *expected = malloc(count * 4), *decoded = malloc(count * 4);
        assert_int_equal(meshopt_decodeIndexBuffer(expected, count, 4, bytes, size), 0);
        clast_meshopt_stream stream = {.mode = CLAST_MESHOPT_TRIANGLES, .count = count, .stride = 4};
        assert_null(decode(stream, bytes, size, decoded));
        assert_memory_equal(decoded, expected, count * 4);
        stream.stride = 2;
        assert_null(decode(stream, bytes, size, decoded));
        for (size_t i = 0; i < count; i++) {
            assert_int_equal(((uint16_t *)decoded)[i], (uint16_t)expected[i]);
        }
        if (seed % 4 == 0) {
            break_stream(stream, bytes, size, (unsigned char *)decoded);
        }
        free(indices);
        free(bytes);
        free(expected);
        free(decoded);
    }
}

static void index_sequences_come_back(void **state)
{
    (void)state;
    randoms r = {3};
    uint32_t indices[500], decoded[500];
    for (size_t i = 0; i < 500; i++) {
        indices[i] = i % 2 == 0 ? (uint32_t)i : i % 7 == 0 ? random_bits(&r) % 1000000 : (uint32_t)(100000 - i);
    }
    unsigned char bytes[4096];
    meshopt_encodeIndexVersion(1);
    size_t size = meshopt_encodeIndexSequence(bytes, sizeof bytes, indices, 500);
    clast_meshopt_stream stream = {.mode = CLAST_MESHOPT_INDICES, .count = 500, .stride = 4};
    assert_null(decode(stream, bytes, size, decoded));
    assert_memory_equal(decoded, indices, sizeof indices);
    break_stream(stream, bytes, size, (unsigned char *)decoded);
}

// The specification leaves the last unit open.
static void assert_near(const void *ours, const void *theirs, size_t count, uint32_t size)
{
    for (size_t i = 0; i < count; i++) {
        int a = size == 1 ? ((const int8_t *)ours)[i] : ((const int16_t *)ours)[i];
        int b = size == 1 ? ((const int8_t *)theirs)[i] : ((const int16_t *)theirs)[i];
        assert_true(abs(a - b) <= 1);
    }
}

static void filters_agree_with_the_peer(void **state)
{
    (void)state;
    enum { COUNT = 1024 };
    randoms r = {5};
    static float vectors[COUNT][4];
    for (size_t i = 0; i < COUNT; i++) {
        float length = 0.0f;
        for (uint32_t k = 0; k < 4; k++) {
            vectors[i][k] = (float)random_bits(&r) / 1073741824.0f - 1.0f;
            length += vectors[i][k] * vectors[i][k];
        }
        for (uint32_t k = 0; k < 4; k++) {
            vectors[i][k] /= sqrtf(length);
        }
    }
    static unsigned char ours[16 * COUNT], theirs[16 * COUNT];
    for (uint32_t size = 1; size <= 2; size++) {
        clast_meshopt_stream stream = {.filter = CLAST_MESHOPT_OCTAHEDRAL, .count = COUNT, .stride = 4 * size};
        meshopt_encodeFilterOct(ours, COUNT, 4 * size, size == 1 ? 7 : 12, vectors[0]);
        memcpy(theirs, ours, sizeof ours);
        clast_meshopt_apply_filter(&stream, ours);
        meshopt_decodeFilterOct(theirs, COUNT, 4 * size);
        assert_near(ours, theirs, 4 * COUNT, size);
    }
    clast_meshopt_stream quaternions = {.filter = CLAST_MESHOPT_QUATERNION, .count = COUNT, .stride = 8};
    meshopt_encodeFilterQuat(ours, COUNT, 8, 13, vectors[0]);
    memcpy(theirs, ours, sizeof ours);
    clast_meshopt_apply_filter(&quaternions, ours);
    meshopt_decodeFilterQuat(theirs, COUNT, 8);
    assert_near(ours, theirs, 4 * COUNT, 2);
    clast_meshopt_stream floats = {.filter = CLAST_MESHOPT_EXPONENTIAL, .count = COUNT, .stride = 16};
    meshopt_encodeFilterExp(ours, COUNT, 16, 15, vectors[0]);
    memcpy(theirs, ours, sizeof ours);
    clast_meshopt_apply_filter(&floats, ours);
    meshopt_decodeFilterExp(theirs, COUNT, 16);
    assert_memory_equal(ours, theirs, sizeof ours);
}

#endif

// ------------------------------------------------------------------------------------------------------------- by hand

// The specification's own example: sixteen four-bit deltas of which two follow as bytes.
static const unsigned char example_group[10] = {0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5};
static const int8_t example_deltas[16] = {-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0};

typedef struct writer {
    unsigned char bytes[4096];
    size_t size;
} writer;

static void put(writer *w, const void *bytes, size_t size)
{
    memcpy(w->bytes + w->size, bytes, size);
    w->size += size;
}

static void put_byte(writer *w, uint32_t byte)
{
    w->bytes[w->size++] = (unsigned char)byte;
}

// Padding to 24 bytes, the base of a stride of four, and the mode of its channel.
static void put_tail_1(writer *w, uint32_t base, uint32_t channel)
{
    static const unsigned char padding[19] = {0};
    put(w, padding, sizeof padding);
    put(w, &base, 4);
    put_byte(w, channel);
}

static const clast_meshopt_stream words = {.count = 16, .stride = 4, .version_1 = true};

static void version_1_has_lengths_zeros_and_literals(void **state)
{
    (void)state;
    writer w = {0};
    put_byte(&w, 0xa1);
    put_byte(&w, 0u | 1u << 2 | 2u << 4 | 3u << 6); // controls of bytes 0 to 3
    put_byte(&w, 3);                                // byte 0, control 0: the group has four bits
    put(&w, example_group, sizeof example_group);
    put_byte(&w, 0); // byte 1, control 1: the group has one bit, the lowest first
    put_byte(&w, 0x01);
    put_byte(&w, 0x80);
    put_byte(&w, 4); // of element 0, and of element 15, as bytes
    put_byte(&w, 5);
    for (uint32_t i = 0; i < 16; i++) { // byte 3: as they are; byte 2 has none
        put_byte(&w, 2 * i);
    }
    put_tail_1(&w, 0x03020100, 0);
    uint8_t decoded[16][4];
    assert_null(decode(words, w.bytes, w.size, decoded));
    uint8_t expected[4] = {0, 1, 2, 3};
    for (uint32_t i = 0; i < 16; i++) {
        expected[0] = (uint8_t)(expected[0] + example_deltas[i]);
        expected[1] = (uint8_t)(expected[1] + (i == 0 ? 2 : i == 15 ? -3 : 0));
        expected[3] = (uint8_t)(expected[3] + i);
        assert_memory_equal(decoded[i], expected, 4);
    }
}

static void version_1_has_pairs_and_turned_words(void **state)
{
    (void)state;
    uint8_t deltas[16][4];
    for (uint32_t mode = 1; mode <= 2; mode++) {
        writer w = {0};
        uint32_t turn = mode == 2 ? 5 : 0;
        put_byte(&w, 0xa1);
        put_byte(&w, 0xff);
        for (uint32_t k = 0; k < 4; k++) {
            for (uint32_t i = 0; i < 16; i++) {
                deltas[i][k] = (uint8_t)(37 * i + 11 * k + 1);
                put_byte(&w, deltas[i][k]);
            }
        }
        put_tail_1(&w, 0x89abcdef, mode | turn << 4);
        uint32_t decoded[16], value = 0x89abcdef;
        assert_null(decode(words, w.bytes, w.size, decoded));
        for (uint32_t i = 0; i < 16; i++) {
            uint32_t word, pairs[2] = {value & 0xffff, value >> 16};
            memcpy(&word, deltas[i], 4);
            for (uint32_t k = 0; k < 2; k++) {
                uint32_t pair = word >> (16 * k) & 0xffff;
                pairs[k] = (pairs[k] + ((pair & 1) != 0 ? ~(pair >> 1) : pair >> 1)) & 0xffff;
            }
            value = mode == 1 ? pairs[0] | pairs[1] << 16 : value ^ (word << turn | word >> (32 - turn));
            assert_int_equal(decoded[i], value);
        }
    }
}

static void unknown_channels_are_refused(void **state)
{
    (void)state;
    static const uint32_t unknown[] = {3, 15, 0x10, 0x21};
    for (uint32_t i = 0; i < 4; i++) {
        writer w = {0};
        put_byte(&w, 0xa1);
        put_byte(&w, 0xaa);
        put_tail_1(&w, 0, unknown[i]);
        unsigned char decoded[64];
        assert_non_null(decode(words, w.bytes, w.size, decoded));
    }
}

static void version_1_is_refused_where_only_version_0_is_allowed(void **state)
{
    (void)state;
    writer w = {0};
    put_byte(&w, 0xa1);
    put_byte(&w, 0xaa);
    put_tail_1(&w, 1, 0);
    unsigned char decoded[64];
    clast_meshopt_stream stream = words;
    assert_null(decode(stream, w.bytes, w.size, decoded));
    stream.version_1 = false;
    assert_non_null(decode(stream, w.bytes, w.size, decoded));
}

static void colours_come_back(void **state)
{
    (void)state;
    for (uint32_t size = 1; size <= 2; size++) {
        // Eight bits of colour: alpha has the eighth as its mark.
        const int32_t y = 100, orange = 30, green = -20, alpha = 128 + 77;
        const int32_t in[4] = {y, orange, green, alpha};
        const int32_t out[4] = {y + orange - green, y + green, y - orange - green, 2 * 77 + 1};
        unsigned char element[8];
        for (uint32_t i = 0; i < 4; i++) {
            element[i * size] = (unsigned char)in[i];
            if (size == 2) {
                element[i * size + 1] = (unsigned char)((uint32_t)in[i] >> 8);
            }
        }
        clast_meshopt_stream stream = {
            .filter = CLAST_MESHOPT_COLOUR, .count = 1, .stride = 4 * size, .version_1 = true};
        assert_null(clast_meshopt_check(&stream));
        clast_meshopt_apply_filter(&stream, element);
        for (uint32_t i = 0; i < 4; i++) {
            uint32_t value = size == 1 ? element[i] : element[2 * i] | (uint32_t)element[2 * i + 1] << 8;
            assert_int_equal(value, out[i] * (size == 1 ? 1 : 257));
        }
    }
}

static void combinations_without_sense_are_refused(void **state)
{
    (void)state;
    const clast_meshopt_stream wrong[] = {
        {.count = 1, .stride = 6},
        {.count = 1, .stride = 260},
        {.count = 1, .stride = 12, .filter = CLAST_MESHOPT_OCTAHEDRAL},
        {.count = 1, .stride = 4, .filter = CLAST_MESHOPT_QUATERNION},
        {.count = 1, .stride = 4, .filter = CLAST_MESHOPT_COLOUR},
        {.count = 1, .stride = 16, .filter = CLAST_MESHOPT_COLOUR, .version_1 = true},
        {.mode = CLAST_MESHOPT_TRIANGLES, .count = 4, .stride = 4},
        {.mode = CLAST_MESHOPT_TRIANGLES, .count = 3, .stride = 1},
        {.mode = CLAST_MESHOPT_INDICES, .count = 3, .stride = 4, .filter = CLAST_MESHOPT_EXPONENTIAL},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_non_null(clast_meshopt_check(&wrong[i]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifdef CLAST_TESTS_WITH_MESHOPTIMIZER
        cmocka_unit_test(attributes_of_any_stride_and_count_come_back),
        cmocka_unit_test(triangles_come_back_as_the_peer_decodes_them),
        cmocka_unit_test(index_sequences_come_back),
        cmocka_unit_test(filters_agree_with_the_peer),
#endif
        cmocka_unit_test(version_1_has_lengths_zeros_and_literals),
        cmocka_unit_test(version_1_has_pairs_and_turned_words),
        cmocka_unit_test(unknown_channels_are_refused),
        cmocka_unit_test(version_1_is_refused_where_only_version_0_is_allowed),
        cmocka_unit_test(colours_come_back),
        cmocka_unit_test(combinations_without_sense_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
