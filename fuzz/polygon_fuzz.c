// SPDX-License-Identifier: Apache-2.0
// Polygons cut into triangles: any points give a whole triangulation.
#include "fuzz.h"
#include "load/polygon.h"

enum { CORNERS_MOST = 200 };

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    clast_polygon polygon = {0};
    uint32_t count = 3 + fuzz_byte(&bytes) % (CORNERS_MOST - 2u), used[CORNERS_MOST] = {0};
    bool is_wild = fuzz_byte(&bytes) % 2 != 0;
    size_t given = size / (is_wild ? 15 : 3); // more would lie at one place
    count = given < count ? (uint32_t)(given > 3 ? given : 3) : count;
    if (clast_polygon_reserve(context, &polygon, count) == CLAST_OK) {
        for (uint32_t i = 0; i < 3 * count; i++) {
            uint32_t bits = is_wild ? fuzz_word(&bytes) : 0;
            float value = (float)(int8_t)fuzz_byte(&bytes) * 0.25f;
            if (is_wild) {
                memcpy(&value, &bits, sizeof value);
            }
            polygon.points[i / 3][i % 3] = value - value == 0.0f ? value : 0.0f; // loaders refuse what is not finite
        }
        clast_polygon_cut(&polygon, count);
        for (uint32_t i = 0; i < 3 * (count - 2); i++) {
            FUZZ_CHECK(polygon.corners[i] < count);
            used[polygon.corners[i]]++;
        }
        for (uint32_t i = 0; i < count; i++) {
            FUZZ_CHECK(used[i] != 0);
        }
    }
    clast_polygon_free(context, &polygon);
}
