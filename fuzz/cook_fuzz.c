// SPDX-License-Identifier: Apache-2.0
// A scene from bytes, cooked, built, traced and drawn: whatever is finite can be.
#include "clast/render.h"
#include "mesh.h"

enum { WIDTH = 4, HEIGHT = 3, RAYS = 8 };

static void fill(fuzz_bytes *bytes, clast_scene *scene)
{
    static fuzz_mesh mesh;
    uint8_t flags = fuzz_byte(bytes);
    uint32_t instances = 1u + fuzz_byte(bytes) % 4u, wave = CLAST_NONE, geometry, number;
    float transforms[4][12];
    for (uint32_t i = 0; i < 12 * instances; i++) {
        transforms[i / 12][i % 12] = i % 5 == 0 && (flags & 1) == 0 ? 1.0f : fuzz_float(bytes, (flags & 2) != 0);
    }
    clast_wave sheet = {.size = 1.0f + fuzz_byte(bytes),
                        .tiles = 1u + fuzz_byte(bytes) % 4u,
                        .amplitude = fuzz_float(bytes, false),
                        .wavelength = 0.5f + fuzz_byte(bytes),
                        .speed = 1,
                        .material = CLAST_NONE};
    fuzz_mesh_fill(bytes, &mesh);
    clast_mesh described = {.vertex_count = mesh.vertex_count,
                            .triangle_count = mesh.triangle_count,
                            .positions = mesh.positions,
                            .indices = mesh.indices,
                            .material = CLAST_NONE};
    FUZZ_CHECK(clast_scene_add_mesh(scene, &described, "mesh", &geometry) == CLAST_OK);
    if ((flags & 4) != 0) {
        FUZZ_CHECK(clast_scene_add_wave(scene, &sheet, "wave", &wave) == CLAST_OK);
    }
    for (uint32_t i = 0; i < instances; i++) {
        clast_scene_add_instance(scene, wave != CLAST_NONE && i % 2 != 0 ? wave : geometry, transforms[i], NULL,
                                 &number);
    }
}

static void look_at(clast_renderer *renderer)
{
    static float colour[WIDTH * HEIGHT * 3];
    const clast_render_output output = {CLAST_VIEW_COLOUR, colour};
    clast_render_settings settings = {.width = WIDTH, .height = HEIGHT, .spp = 1, .bounces = 2, .env = "1,1,1"};
    clast_status status = clast_render(renderer, &settings, &output, 1, NULL);
    FUZZ_CHECK(status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY || status == CLAST_ERROR_INVALID_ARGUMENT);
    if (status != CLAST_OK) {
        return;
    }
    for (uint32_t i = 0; i < WIDTH * HEIGHT * 3; i++) {
        FUZZ_CHECK(colour[i] == colour[i]); // no NaN
    }
    clast_ray rays[RAYS];
    clast_hit hits[RAYS];
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (clast_ray){{(float)i - 4.0f, 2.0f, -20.0f}, 0, {0.1f * (float)i, -0.1f, 1.0f}, 1e30f};
    }
    FUZZ_CHECK(clast_renderer_trace_closest(renderer, rays, RAYS, hits) == CLAST_OK);
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_surface surface;
        if (hits[i].instance != CLAST_NONE) {
            FUZZ_CHECK(clast_renderer_locate(renderer, &hits[i], &surface) == CLAST_OK);
        }
    }
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    clast_scene *scene;
    clast_renderer *renderer;
    FUZZ_CHECK(clast_scene_create(context, &scene) == CLAST_OK);
    fill(&bytes, scene);
    FUZZ_CHECK(clast_renderer_create(scene, &renderer) == CLAST_OK);
    look_at(renderer);
    clast_renderer_destroy(renderer);
    clast_scene_destroy(scene);
}
