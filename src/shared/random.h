// SPDX-License-Identifier: Apache-2.0
// Random numbers as a hash of what they are for: no state to hand on, the same on every lane, thread and machine.
// Hash: PCG output permutation, Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020.
#ifndef CLAST_SHARED_RANDOM_H
#define CLAST_SHARED_RANDOM_H

#include "shared/dialect.h"

FN uint hash1(uint x)
{
    uint state = x * 747796405u + 2891336453u;
    uint mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (mixed >> 22u) ^ mixed;
}

FN uint hash2(uint x, uint y) { return hash1(x + hash1(y)); }
FN uint hash3(uint x, uint y, uint z) { return hash1(x + hash2(y, z)); }

// [0, 1): 24 bits, every value exact
FN float unit_float(uint bits) { return to_float(bits >> 8u) * 5.9604644775390625e-8f; }

#endif
