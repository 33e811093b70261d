// SPDX-License-Identifier: Apache-2.0
// Exact signs, by expansions: sums of doubles that do not overlap, least first (Shewchuk, Adaptive Precision Floating-Point
// Arithmetic and Fast Robust Geometric Predicates, 1997). Floats from 1e-30 to 1e30 have products of three, with all their
// rounding errors, well within double's range, so nothing is lost.
#include "accel/watertight.h"

enum { TERMS = 128 };

typedef struct expansion {
    double terms[TERMS];
    uint32_t count;
} expansion;

// Adds a double: each sum's rounding error (Knuth's two-sum) is a term of the result.
static void add_term(expansion *e, double x)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < e->count; i++) {
        double sum = x + e->terms[i], other = sum - x;
        double error = (x - (sum - other)) + (e->terms[i] - other);
        if (error != 0.0) {
            e->terms[kept++] = error;
        }
        x = sum;
    }
    if (x != 0.0) {
        e->terms[kept++] = x;
    }
    e->count = kept;
}

// The largest term is larger than all others together.
static int sign_of(const expansion *e)
{
    double largest = e->count > 0 ? e->terms[e->count - 1] : 0.0;
    return (largest > 0.0) - (largest < 0.0);
}

// a - b of floats as two doubles.
static void difference(float a, float b, double parts[2])
{
    double x = (double)a, y = -(double)b, sum = x + y, other = sum - x;
    parts[0] = sum;
    parts[1] = (x - (sum - other)) + (y - other);
}

// Adds sign * d * p * q.
static void add_product(expansion *e, double sign, float d, const double p[2], const double q[2])
{
    for (int i = 0; i < 4; i++) {
        double a = p[i / 2], b = q[i % 2], high = a * b, low = fma(a, b, -high), factor = sign * (double)d;
        double high_product = factor * high, low_product = factor * low;
        add_term(e, fma(factor, low, -low_product));
        add_term(e, low_product);
        add_term(e, fma(factor, high, -high_product));
        add_term(e, high_product);
    }
}

int exact_side(const float origin[3], const float direction[3], const float a[3], const float b[3])
{
    double p[3][2], q[3][2];
    for (int axis = 0; axis < 3; axis++) {
        difference(a[axis], origin[axis], p[axis]);
        difference(b[axis], origin[axis], q[axis]);
    }
    expansion e = {.count = 0};
    for (int axis = 0; axis < 3; axis++) {
        int next = (axis + 1) % 3, last = (axis + 2) % 3;
        add_product(&e, 1.0, direction[axis], p[next], q[last]);
        add_product(&e, -1.0, direction[axis], p[last], q[next]);
    }
    return sign_of(&e);
}
