// SPDX-License-Identifier: Apache-2.0
// PNG files from functions of the pixel.
#ifndef CLAST_GENERATE_PICTURE_H
#define CLAST_GENERATE_PICTURE_H

#include "generate/outputs.h"
#include "shared/dialect.h"

enum { CLAST_GAMMA_STEPS = 4096 };

// sRGB bytes of CLAST_GAMMA_STEPS linear values from 0 to 1; the same on every machine.
void clast_make_gamma(uint8_t table[CLAST_GAMMA_STEPS]);

static inline uint8_t clast_gamma_byte(const uint8_t *table, float linear)
{
    return table[(uint32_t)(clamp1(linear, 0.0f, 1.0f) * (CLAST_GAMMA_STEPS - 1) + 0.5f)];
}

// Writes 8-bit RGB rows.
void clast_picture_write(clast_outputs *outputs, const char *name, uint32_t width, uint32_t height,
                         const uint8_t *pixels);
// Evaluates `texel` everywhere, in parallel, and writes 16-bit grey: 0 is *low, 65535 is *high, which are found.
void clast_picture_write_heights(clast_outputs *outputs, const char *name, uint32_t width, uint32_t height,
                                 float (*texel)(const void *data, uint32_t x, uint32_t y), const void *data, float *low,
                                 float *high);

#endif
