// SPDX-License-Identifier: Apache-2.0
// One text, read by the C compiler and by the GLSL compiler: what lies in this folder is written in this dialect, so that
// a record, a limit or a formula exists once and both backends agree on it. docs/shared.md explains the rules.
//
//   vec2 vec3 vec4              registers: a + b * s, v[0], vec3(x, y, z), splat3(s); never inside a record
//   packed2 packed3 packed4     memory: tightly packed floats, inside records only; load3() and store3() convert
//   packed_address              an address in a device's memory, inside records only: the lower half first
//   FN                          before every function: computed as written, never fused
//   RECORD, RECORD_SIZE         a struct with scalar layout, its size asserted
//   LIMIT, ENUM                 constants
#ifndef CLAST_SHARED_DIALECT_H
#define CLAST_SHARED_DIALECT_H

#ifdef VULKAN // --------------------------------------------------------------------------------------------- GLSL

#define FN precise
#define RECORD(name) struct name
#define RECORD_SIZE(name, bytes)
#define LIMIT(name, value, text) const uint name = value;
#define ENUM(list) list(ENUM_ENTRY)
#define ENUM_ENTRY(name, value, text) const uint name = value;
#define TABLE const

#define packed2 vec2
#define packed3 vec3
#define packed4 vec4
#define packed_address uvec2
#define load2(p) (p)
#define load3(p) (p)
#define load4(p) (p)
#define store2(v) (v)
#define store3(v) (v)
#define store4(v) (v)
// load_address() is shaders/gpu.glsl's: it needs 64-bit integers.

// Roots, quotients and transcendental functions differ between machines. Formulas that decide an integer or a shared
// point may use them for a guess only, by these names; formulas of shading may use them freely.
FN float rough_divide(float a, float b) { return a / b; }
FN float rough_sqrt(float x) { return sqrt(x); }
FN float rough_sin(float x) { return sin(x); }
FN float rough_cos(float x) { return cos(x); }
FN float rough_acos(float x) { return atan(sqrt((1.0f - x) * (1.0f + x)), x); } // its own has three good digits on some
FN float rough_atan2(float y, float x) { return atan(y, x); }
FN float rough_exp(float x) { return exp(x); }
FN float rough_log(float x) { return log(x); }
FN float rough_pow(float x, float y) { return pow(x, y); }

#else // -------------------------------------------------------------------------------------------------------- C

#ifdef __FAST_MATH__
#error "the shared formulas need strict arithmetic: compile without -ffast-math, with -ffp-contract=off"
#endif

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define FN static inline
#define precise // -ffp-contract=off does it for the whole project
#define RECORD(name) typedef struct name name; struct name
#define RECORD_SIZE(name, bytes) _Static_assert(sizeof(name) == (bytes), "size of " #name);
#define LIMIT(name, value, text) enum { name = value };
#define ENUM(list) // C has them from the public headers
#define TABLE static const

typedef unsigned int uint;
typedef struct packed2 { float v[2]; } packed2;
typedef struct packed3 { float v[3]; } packed3;
typedef struct packed4 { float v[4]; } packed4;
typedef struct packed_address { uint v[2]; } packed_address;

typedef float vec2 __attribute__((vector_size(8)));
typedef float vec3 __attribute__((vector_size(16))); // the fourth lane is never looked at
typedef float vec4 __attribute__((vector_size(16)));

#define vec2(x, y) ((vec2){(x), (y)})
#define vec3(x, y, z) ((vec3){(x), (y), (z), 0.0f})
#define vec4(x, y, z, w) ((vec4){(x), (y), (z), (w)})

FN vec2 load2(packed2 p) { return vec2(p.v[0], p.v[1]); }
FN vec3 load3(packed3 p) { return vec3(p.v[0], p.v[1], p.v[2]); }
FN vec4 load4(packed4 p) { return vec4(p.v[0], p.v[1], p.v[2], p.v[3]); }
FN packed2 store2(vec2 v) { return (packed2){{v[0], v[1]}}; }
FN packed3 store3(vec3 v) { return (packed3){{v[0], v[1], v[2]}}; }
FN packed4 store4(vec4 v) { return (packed4){{v[0], v[1], v[2], v[3]}}; }
FN uint64_t load_address(packed_address p) { return (uint64_t)p.v[1] << 32 | p.v[0]; }
FN packed_address store_address(uint64_t a) { return (packed_address){{(uint)a, (uint)(a >> 32)}}; }

FN uint floatBitsToUint(float x) { uint bits; memcpy(&bits, &x, sizeof bits); return bits; }
FN float uintBitsToFloat(uint bits) { float x; memcpy(&x, &bits, sizeof x); return x; }

FN float rough_divide(float a, float b) { return a / b; }
FN float rough_sqrt(float x) { return sqrtf(x); }
FN float rough_sin(float x) { return sinf(x); }
FN float rough_cos(float x) { return cosf(x); }
FN float rough_acos(float x) { return acosf(x); }
FN float rough_atan2(float y, float x) { return atan2f(y, x); }
FN float rough_exp(float x) { return expf(x); }
FN float rough_log(float x) { return logf(x); }
FN float rough_pow(float x, float y) { return powf(x, y); }
FN float floor1(float x) { return floorf(x); }

#endif // -------------------------------------------------------------------------------------------------- both

#ifdef VULKAN
FN float floor1(float x) { return floor(x); }
#endif

// The built-in min and max may return either zero and, for NaN, either operand; these return `a` then.
FN float min1(float a, float b) { return b < a ? b : a; }
FN float max1(float a, float b) { return a < b ? b : a; }
FN float clamp1(float x, float low, float high) { return min1(max1(low, x), high); } // NaN gives low
FN float abs1(float x) { return x < 0.0f ? -x : x; }
FN uint min_uint(uint a, uint b) { return b < a ? b : a; }
FN uint max_uint(uint a, uint b) { return a < b ? b : a; }

// The sign of a zero is no machine's promise: for bits that are stored, hashed or compared.
FN float unsigned_zero(float x) { return x == 0.0f ? 0.0f : x; }

// Exact below 2^24. To uint: towards zero, 0 <= x < 2^31; anything else (NaN too) is undefined, so clamp1() first.
#ifdef VULKAN
FN float to_float(uint x) { return float(x); }
FN uint to_uint(float x) { return uint(x); }
#else
FN float to_float(uint x) { return (float)x; }
FN uint to_uint(float x) { return (uint)x; }
#endif

// 2^(exponent - 127), for 0 < exponent < 255
FN float power_of_two(uint exponent) { return uintBitsToFloat(exponent << 23u); }

FN vec2 splat2(float s) { return vec2(s, s); }
FN vec3 splat3(float s) { return vec3(s, s, s); }
FN vec3 min3(vec3 a, vec3 b) { return vec3(min1(a[0], b[0]), min1(a[1], b[1]), min1(a[2], b[2])); }
FN vec3 max3(vec3 a, vec3 b) { return vec3(max1(a[0], b[0]), max1(a[1], b[1]), max1(a[2], b[2])); }
FN float dot2(vec2 a, vec2 b) { return a[0] * b[0] + a[1] * b[1]; }
FN float dot3(vec3 a, vec3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
FN vec3 cross3(vec3 a, vec3 b)
{
    return vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}
FN float length3(vec3 v) { return rough_sqrt(dot3(v, v)); }
// A zero vector, and one whose square is not finite, stays as it is.
FN vec3 normalize3(vec3 v)
{
    float square = dot3(v, v);
    bool sound = square > 0.0f && square < 3e38f;
    return sound ? v * rough_divide(1.0f, rough_sqrt(square)) : v;
}
FN vec3 mix3(vec3 a, vec3 b, float t) { return a * (1.0f - t) + b * t; }
FN float mix1(float a, float b, float t) { return a * (1.0f - t) + b * t; }
FN float largest3(vec3 v) { return max1(v[0], max1(v[1], v[2])); }
FN bool is_finite1(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
FN bool is_finite3(vec3 v) { return is_finite1(v[0]) && is_finite1(v[1]) && is_finite1(v[2]); }
// Luminance of linear Rec. 709.
FN float luminance(vec3 c) { return 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2]; }

#endif
