// SPDX-License-Identifier: Apache-2.0
// A ray against a triangle, such that no ray slips between triangles that share an edge: Woop, Benthin and Wald, Watertight
// Ray/Triangle Intersection, JCGT 2(1), 2013.
//
// The triangle is moved and sheared so that the ray becomes the z axis. What a vertex becomes depends on the vertex and the
// ray alone; from there on all signs are exact: an edge function a b - c d is computed as the difference of rounded
// products, which is zero or has the right sign as rounding keeps order; where it is zero, the products' own rounding
// errors, which are floats (Dekker 1971), decide. So both sides of an edge agree on which side the ray passes, and a ray that
// passes exactly through an edge hits both. Nothing may be fused here.
//
// Lengths are multiplied by a power of two that brings the largest coordinate that can occur to WATERTIGHT_EXPONENT: edge
// functions and their sums stay finite, and what is 2^-100 of that still has exact rounding errors.
#ifndef CLAST_SHARED_WATERTIGHT_H
#define CLAST_SHARED_WATERTIGHT_H

#include "shared/dialect.h"

LIMIT(WATERTIGHT_EXPONENT, 40u, "coordinates relative to the ray's origin lie below 2^41 after scaling")
TABLE float WATERTIGHT_SHEAR_LEAST = 8.8817841970012523e-16f; // 2^-50; less is zero, so that shears make no denormals

// A ray as the test uses it.
RECORD(clast_watertight_ray)
{
    packed3 origin;
    float scale;   // a power of two
    uint axis;     // of the direction's largest component; the next two, in turn, are x and y of the sheared space
    float shear_x;
    float shear_y;
};
RECORD_SIZE(clast_watertight_ray, 28)

// Edge functions: weights of the corners, up to their sum. All zero or of one sign where the ray passes the triangle.
RECORD(clast_watertight_edges)
{
    float a;
    float b;
    float c;
    float sum;
    float depth; // along the largest axis, scaled, times the sum
};
RECORD_SIZE(clast_watertight_edges, 20)

FN float component3(vec3 v, uint axis) { return axis == 0u ? v[0] : axis == 1u ? v[1] : v[2]; }

FN clast_watertight_ray watertight_ray(vec3 origin, vec3 direction, float scale)
{
    clast_watertight_ray ray;
    ray.origin = store3(origin);
    ray.scale = scale;
    float x = abs1(direction[0]);
    float y = abs1(direction[1]);
    float z = abs1(direction[2]);
    ray.axis = x >= y && x >= z ? 0u : y >= z ? 1u : 2u;
    float along = component3(direction, ray.axis);
    float shear_x = rough_divide(component3(direction, (ray.axis + 1u) % 3u), along);
    float shear_y = rough_divide(component3(direction, (ray.axis + 2u) % 3u), along);
    ray.shear_x = abs1(shear_x) < WATERTIGHT_SHEAR_LEAST ? 0.0f : shear_x;
    ray.shear_y = abs1(shear_y) < WATERTIGHT_SHEAR_LEAST ? 0.0f : shear_y;
    return ray;
}

// A vertex in the ray's sheared space: x, y scaled, z scaled.
FN vec3 watertight_vertex(clast_watertight_ray ray, vec3 vertex)
{
    vec3 v = vertex - load3(ray.origin);
    float z = component3(v, ray.axis);
    float x = component3(v, (ray.axis + 1u) % 3u) - ray.shear_x * z;
    float y = component3(v, (ray.axis + 2u) % 3u) - ray.shear_y * z;
    return vec3(x * ray.scale, y * ray.scale, z * ray.scale);
}

// The upper 12 bits of a float's 24; the rest is exact.
FN float upper_bits(float x)
{
    float large = x * 4097.0f;
    return large - (large - x);
}

// a * b - product, exactly, where product is a * b rounded.
FN float product_error(float a, float b, float product)
{
    float a1 = upper_bits(a);
    float a2 = a - a1;
    float b1 = upper_bits(b);
    float b2 = b - b1;
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
}

// a * b - c * d, with the sign that it has in real numbers.
FN float signed_difference(float a, float b, float c, float d)
{
    float ab = a * b;
    float cd = c * d;
    float rough = ab - cd;
    return rough == 0.0f ? product_error(a, b, ab) - product_error(c, d, cd) : rough;
}

FN clast_watertight_edges watertight_edges(vec3 a, vec3 b, vec3 c)
{
    clast_watertight_edges e;
    e.a = signed_difference(c[0], b[1], c[1], b[0]);
    e.b = signed_difference(a[0], c[1], a[1], c[0]);
    e.c = signed_difference(b[0], a[1], b[1], a[0]);
    e.sum = (e.a + e.b) + e.c;
    e.depth = (e.a * a[2] + e.b * b[2]) + e.c * c[2];
    return e;
}

// Whether the ray's line passes the triangle. False where something is not a number, and for a triangle seen edge on.
FN bool watertight_passes(clast_watertight_edges e)
{
    bool positive = e.a >= 0.0f && e.b >= 0.0f && e.c >= 0.0f;
    bool negative = e.a <= 0.0f && e.b <= 0.0f && e.c <= 0.0f;
    return (positive || negative) && e.sum != 0.0f;
}

#endif
