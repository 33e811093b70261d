// SPDX-License-Identifier: Apache-2.0
// Embree's subdivision surfaces over a ground, displaced by the same map.
#include "tess.h"

#include <math.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Texels of the map by the place in the plane, as the ground's texture coordinates have them, filtered linearly.
static float height_of(const tess_ground *g, float x, float y)
{
    float u = x * g->map_scale - 0.5f, v = y * g->map_scale - 0.5f;
    float left = floorf(u), top = floorf(v), s = u - left, t = v - top;
    uint32_t mask = TESS_MAP_SIDE - 1, i = (uint32_t)(int32_t)left, j = (uint32_t)(int32_t)top;
    const uint16_t *row = g->map + (size_t)(j & mask) * TESS_MAP_SIDE,
                   *next = g->map + (size_t)((j + 1) & mask) * TESS_MAP_SIDE;
    float a = row[i & mask], b = row[(i + 1) & mask], c = next[i & mask], d = next[(i + 1) & mask];
    float low = a + (b - a) * s, high = c + (d - c) * s;
    return (low + (high - low) * t) * g->height_scale;
}

static void displace_some(const tess_ground *g, const struct RTCDisplacementFunctionNArguments *a, uint32_t first)
{
    for (uint32_t i = first; i < a->N; i++) {
        float height = height_of(g, a->P_x[i], a->P_y[i]);
        a->P_x[i] += a->Ng_x[i] * height;
        a->P_y[i] += a->Ng_y[i] * height;
        a->P_z[i] += a->Ng_z[i] * height;
    }
}

#if defined(__x86_64__)
// Two neighbouring texels of each lane, the left one in the lower half.
__attribute__((target("avx2"))) static inline __m256 texel8(const uint16_t *map, __m256i column, __m256i row)
{
    __m256i place = _mm256_add_epi32(_mm256_slli_epi32(row, TESS_MAP_BITS), column);
    __m256i words = _mm256_i32gather_epi32((const int *)(const void *)map, place, 2);
    return _mm256_cvtepi32_ps(_mm256_and_si256(words, _mm256_set1_epi32(0xffff)));
}

__attribute__((target("avx2"))) static uint32_t displace_eights(const tess_ground *g,
                                                                const struct RTCDisplacementFunctionNArguments *a)
{
    const __m256 scale = _mm256_set1_ps(g->map_scale), half = _mm256_set1_ps(0.5f);
    const __m256i mask = _mm256_set1_epi32(TESS_MAP_SIDE - 1), one = _mm256_set1_epi32(1);
    uint32_t i = 0;
    for (; i + 8 <= a->N; i += 8) {
        __m256 x = _mm256_loadu_ps(a->P_x + i), y = _mm256_loadu_ps(a->P_y + i), z = _mm256_loadu_ps(a->P_z + i);
        __m256 u = _mm256_sub_ps(_mm256_mul_ps(x, scale), half), v = _mm256_sub_ps(_mm256_mul_ps(y, scale), half);
        __m256 left = _mm256_floor_ps(u), top = _mm256_floor_ps(v);
        __m256 s = _mm256_sub_ps(u, left), t = _mm256_sub_ps(v, top);
        __m256i c0 = _mm256_cvttps_epi32(left), r0 = _mm256_cvttps_epi32(top);
        __m256i c1 = _mm256_and_si256(_mm256_add_epi32(c0, one), mask),
                r1 = _mm256_and_si256(_mm256_add_epi32(r0, one), mask);
        c0 = _mm256_and_si256(c0, mask);
        r0 = _mm256_and_si256(r0, mask);
        __m256 p = texel8(g->map, c0, r0), q = texel8(g->map, c1, r0), k = texel8(g->map, c0, r1),
               l = texel8(g->map, c1, r1);
        __m256 low = _mm256_add_ps(p, _mm256_mul_ps(_mm256_sub_ps(q, p), s));
        __m256 high = _mm256_add_ps(k, _mm256_mul_ps(_mm256_sub_ps(l, k), s));
        __m256 height = _mm256_add_ps(low, _mm256_mul_ps(_mm256_sub_ps(high, low), t));
        height = _mm256_mul_ps(height, _mm256_set1_ps(g->height_scale));
        _mm256_storeu_ps(a->P_x + i, _mm256_add_ps(x, _mm256_mul_ps(_mm256_loadu_ps(a->Ng_x + i), height)));
        _mm256_storeu_ps(a->P_y + i, _mm256_add_ps(y, _mm256_mul_ps(_mm256_loadu_ps(a->Ng_y + i), height)));
        _mm256_storeu_ps(a->P_z + i, _mm256_add_ps(z, _mm256_mul_ps(_mm256_loadu_ps(a->Ng_z + i), height)));
    }
    return i;
}
#endif

static void displace(const struct RTCDisplacementFunctionNArguments *a)
{
    const tess_ground *g = a->geometryUserPtr;
    uint32_t done = 0;
#if defined(__x86_64__)
    done = __builtin_cpu_supports("avx2") ? displace_eights(g, a) : 0;
#endif
    displace_some(g, a, done);
}

tess_subdivision tess_subdivision_make(RTCDevice device, const tess_ground *g, float segment, bool dynamic)
{
    tess_subdivision s = {.ground = g, .scene = rtcNewScene(device)};
    s.geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    size_t corners = 3 * (size_t)g->base.triangle_count;
    uint32_t *faces = rtcSetNewGeometryBuffer(s.geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, 4,
                                              g->base.triangle_count);
    for (uint32_t i = 0; i < g->base.triangle_count; i++) {
        faces[i] = 3;
    }
    rtcSetSharedGeometryBuffer(s.geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, g->base.indices, 0, 4, corners);
    rtcSetSharedGeometryBuffer(s.geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g->base.positions, 0, 12,
                               g->base.vertex_count);
    s.levels = rtcSetNewGeometryBuffer(s.geometry, RTC_BUFFER_TYPE_LEVEL, 0, RTC_FORMAT_FLOAT, 4, corners);
    tess_subdivision_levels(&s, segment);
    rtcSetGeometryUserData(s.geometry, (void *)(uintptr_t)g);
    rtcSetGeometryDisplacementFunction(s.geometry, displace);
    rtcSetSceneFlags(s.scene, dynamic ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(s.scene, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryBuildQuality(s.geometry, RTC_BUILD_QUALITY_LOW);
    rtcCommitGeometry(s.geometry);
    rtcAttachGeometry(s.scene, s.geometry);
    rtcCommitScene(s.scene);
    return s;
}

// A triangle becomes three quads, of half as many segments: of three halves as many triangles as the pattern has. So that
// both sides make as many, the peer's levels are smaller by the root of that.
void tess_subdivision_levels(tess_subdivision *s, float segment)
{
    const mesh *m = &s->ground->base;
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        const float *p = m->positions + 3 * (size_t)m->indices[i];
        const float *q = m->positions + 3 * (size_t)m->indices[i % 3 == 2 ? i - 2 : i + 1];
        float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
        s->levels[i] = fmaxf(0.8164966f * sqrtf(x * x + y * y + z * z) / segment, 1.0f);
    }
}

void tess_subdivision_commit(tess_subdivision *s)
{
    rtcUpdateGeometryBuffer(s->geometry, RTC_BUFFER_TYPE_LEVEL, 0);
    rtcCommitGeometry(s->geometry);
    rtcCommitScene(s->scene);
}

void tess_subdivision_free(tess_subdivision *s)
{
    rtcReleaseGeometry(s->geometry);
    rtcReleaseScene(s->scene);
}
