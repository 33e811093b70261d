// SPDX-License-Identifier: Apache-2.0
// The ground that tessellation is measured on.
#include "tess_ground.h"

#include <math.h>
#include <stdio.h>

static void *allocate(size_t count, size_t size)
{
    void *block = calloc(count, size);
    if (block == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return block;
}

static float hill(float x, float y)
{
    return 0.3f * sinf(0.9f * x) * cosf(0.7f * y + 0.4f) + 0.1f * sinf(2.3f * x + 1.7f * y);
}

static uint16_t *make_map(void)
{
    uint16_t *map = allocate((TESS_MAP_SIDE + 1) * TESS_MAP_SIDE, sizeof *map);
    for (uint32_t j = 0; j < TESS_MAP_SIDE; j++) {
        for (uint32_t i = 0; i < TESS_MAP_SIDE; i++) {
            float x = 6.2831853f * (float)i / TESS_MAP_SIDE, y = 6.2831853f * (float)j / TESS_MAP_SIDE, height = 0.5f;
            float size = 0.2f;
            for (int octave = 0; octave < 5; octave++, size *= 0.5f) {
                float f = (float)(16 << octave);
                height += size * sinf(f * x + (float)octave) * cosf(f * y - 2.0f * (float)octave);
            }
            map[(size_t)j * TESS_MAP_SIDE + i] = (uint16_t)(65535.0f * fminf(fmaxf(height, 0.0f), 1.0f));
        }
    }
    return map;
}

tess_ground tess_ground_make(uint32_t base_triangles)
{
    uint32_t side = (uint32_t)ceil(sqrt((double)base_triangles / 2.0));
    tess_ground g = {.base = mesh_of((side + 1) * (side + 1), 2 * side * side), .spacing = 8.0f / (float)side};
    g.coordinates = allocate((size_t)g.base.vertex_count, 8);
    g.map = make_map();
    g.map_scale = TESS_MAP_SIDE / 2.0f; // repeats each two units
    g.height_scale = 0.02f / 65535.0f;
    randoms r = {7};
    uint32_t *corner = g.base.indices;
    for (uint32_t j = 0; j <= side; j++) {
        for (uint32_t i = 0; i <= side; i++) {
            float *p = g.base.positions + 3 * (size_t)(j * (side + 1) + i);
            p[0] = g.spacing * ((float)i + 0.5f * (float)(j % 2) + random_between(&r, -0.05f, 0.05f));
            p[1] = g.spacing * (0.8660254f * (float)j + random_between(&r, -0.05f, 0.05f));
            p[2] = hill(p[0], p[1]);
            float *uv = g.coordinates + 2 * (size_t)(j * (side + 1) + i);
            uv[0] = p[0] * g.map_scale / TESS_MAP_SIDE;
            uv[1] = p[1] * g.map_scale / TESS_MAP_SIDE;
            if (i < side && j < side) {
                uint32_t a = j * (side + 1) + i, b = a + side + 1; // the quad's shorter diagonal cuts it
                if (j % 2 != 0) {
                    mesh_quad(&corner, a, a + 1, b + 1, b);
                } else {
                    mesh_quad(&corner, a + 1, b + 1, b, a);
                }
            }
        }
    }
    return g;
}

void tess_ground_free(tess_ground *g)
{
    mesh_free(&g->base);
    free(g->coordinates);
    free(g->map);
}

clast_scene *tess_ground_scene(const tess_ground *g, clast_context *context)
{
    clast_scene *scene;
    uint32_t image, texture, material, geometry, instance;
    bench_check(clast_scene_create(context, &scene), context);
    clast_image map = {TESS_MAP_SIDE, TESS_MAP_SIDE, 1, CLAST_PIXEL_UNORM16, g->map};
    bench_check(clast_scene_add_image(scene, &map, NULL, &image), context);
    clast_texture use = {.image = image};
    bench_check(clast_scene_add_texture(scene, &use, &texture), context);
    clast_material_desc ground = clast_material_defaults();
    ground.displacement_texture.texture = texture;
    ground.displacement_scale = g->height_scale * 65535.0f;
    bench_check(clast_scene_add_material(scene, &ground, NULL, &material), context);
    clast_mesh base = {.vertex_count = g->base.vertex_count,
                       .triangle_count = g->base.triangle_count,
                       .positions = g->base.positions,
                       .coordinates = {g->coordinates},
                       .indices = g->base.indices,
                       .material = material};
    bench_check(clast_scene_add_mesh(scene, &base, NULL, &geometry), context);
    bench_check(clast_scene_set_tessellation(scene, geometry, &(clast_tessellation){0}), context);
    bench_check(clast_scene_add_instance(scene, geometry, NULL, NULL, &instance), context);
    return scene;
}

clast_frame_settings tess_ground_settings(double segment)
{
    clast_camera_desc desc = {.position = {4, -4, 6}, .target = {4, 4, 0}, .up = {0, 0, 1}, .vertical_angle = 0.9f};
    clast_camera camera = clast_camera_record(&desc, 1920, 1080);
    return (clast_frame_settings){.camera = camera,
                                  .camera_number = CLAST_NONE,
                                  .rate_camera = camera,
                                  .rate_camera_number = CLAST_NONE,
                                  .width = 1920,
                                  .height = 1080,
                                  .metric = CLAST_METRIC_LENGTH,
                                  .rate = 1.0,
                                  .segment = segment,
                                  .hidden_fraction = 1.0,
                                  .displacement_scale = 1.0};
}
