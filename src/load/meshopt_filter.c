// SPDX-License-Identifier: Apache-2.0
// Filters of decoded attributes (KHR_meshopt_compression, appendix B). Where the specification leaves a result open, for
// values that no encoder makes, it is what the formula gives, brought into range.
#include <math.h>

#include "load/meshopt.h"

static int32_t load_component(const unsigned char *at, uint32_t size)
{
    return size == 1 ? (int8_t)at[0] : (int16_t)(uint16_t)(at[0] | at[1] << 8);
}

// Rounds half away from zero; what is no number becomes zero.
static void store_component(unsigned char *at, uint32_t size, float value, float least, float most)
{
    float rounded = value < 0.0f ? value - 0.5f : value + 0.5f;
    int32_t whole = rounded > most       ? (int32_t)most
                    : rounded < least    ? (int32_t)least
                    : rounded == rounded ? (int32_t)rounded
                                         : 0;
    at[0] = (unsigned char)whole;
    if (size == 2) {
        at[1] = (unsigned char)((uint32_t)whole >> 8);
    }
}

static void decode_octahedral(unsigned char *element, uint32_t size)
{
    float most = size == 1 ? 127.0f : 32767.0f;
    float one = (float)load_component(element + 2 * size, size);
    one = one >= 1.0f ? one : 1.0f;
    float x = (float)load_component(element, size) / one, y = (float)load_component(element + size, size) / one;
    float z = 1.0f - fabsf(x) - fabsf(y);
    float fold = z < 0.0f ? z : 0.0f; // the lower half is folded outwards
    x -= copysignf(fold, x);
    y -= copysignf(fold, y);
    float length = sqrtf(x * x + y * y + z * z);
    const float v[3] = {x, y, z};
    for (uint32_t i = 0; i < 3; i++) {
        store_component(element + i * size, size, v[i] / length * most, -most, most);
    }
}

static void decode_quaternion(unsigned char *element)
{
    int32_t code = load_component(element + 6, 2);
    float one = (float)(code | 3), sum = 0.0f, v[4];
    for (uint32_t i = 0; i < 3; i++) {
        v[i] = (float)load_component(element + 2 * i, 2) / one * 0.70710678f;
        sum += v[i] * v[i];
    }
    v[3] = sqrtf(sum < 1.0f ? 1.0f - sum : 0.0f);
    uint32_t largest = (uint32_t)code & 3u;
    for (uint32_t i = 0; i < 4; i++) {
        store_component(element + 2 * ((largest + 1 + i) % 4), 2, v[i] * 32767.0f, -32767.0f, 32767.0f);
    }
}

static void decode_exponential(unsigned char *element)
{
    uint32_t mantissa_bits = element[0] | (uint32_t)element[1] << 8 | (uint32_t)element[2] << 16;
    int32_t mantissa = mantissa_bits >= 1u << 23 ? (int32_t)mantissa_bits - (1 << 24) : (int32_t)mantissa_bits;
    float value = ldexpf((float)mantissa, (int8_t)element[3]);
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (uint32_t i = 0; i < 4; i++) {
        element[i] = (unsigned char)(bits >> (8 * i));
    }
}

// YCoCg to RGB; alpha's highest bit says how many bits there are.
static void decode_colour(unsigned char *element, uint32_t size)
{
    uint32_t alpha = size == 1 ? element[3] : element[6] | (uint32_t)element[7] << 8;
    uint32_t scale = 1;
    while (scale < alpha) {
        scale = scale << 1 | 1u;
    }
    int32_t y = size == 1 ? element[0] : element[0] | element[1] << 8;
    int32_t orange = load_component(element + size, size), green = load_component(element + 2 * size, size);
    alpha &= scale >> 1;
    alpha = alpha << 1 | (alpha & 1u);
    const int32_t channels[4] = {y + orange - green, y + green, y - orange - green, (int32_t)alpha};
    float most = size == 1 ? 255.0f : 65535.0f;
    for (uint32_t i = 0; i < 4; i++) {
        store_component(element + i * size, size, (float)channels[i] * (most / (float)scale), 0.0f, most);
    }
}

void clast_meshopt_apply_filter(const clast_meshopt_stream *stream, unsigned char *decoded)
{
    uint32_t step = stream->filter == CLAST_MESHOPT_EXPONENTIAL ? 4 : stream->stride;
    uint64_t count = stream->count * (stream->stride / step);
    for (uint64_t i = 0; i < count; i++) {
        unsigned char *element = decoded + i * step;
        switch (stream->filter) {
        case CLAST_MESHOPT_NONE: return;
        case CLAST_MESHOPT_OCTAHEDRAL: decode_octahedral(element, step / 4); break;
        case CLAST_MESHOPT_QUATERNION: decode_quaternion(element); break;
        case CLAST_MESHOPT_EXPONENTIAL: decode_exponential(element); break;
        case CLAST_MESHOPT_COLOUR: decode_colour(element, step / 4); break;
        }
    }
}
