// SPDX-License-Identifier: Apache-2.0
// A cloth that waves, moved each frame, and rays traced through it: what a dynamic scene of Embree's does, with the call that
// each line replaces beside it. Prints how long frames take, and writes a picture of the last one.
//
//   cc dynamic_cloth.c -o dynamic_cloth $(pkg-config --cflags --libs clast) -lm
//   ./dynamic_cloth [FRAMES [PICTURE.png]]
#include <clast/clast.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum {
    SIDE = 513, // vertices of the cloth's side: half a million triangles
    VERTICES = SIDE * SIDE,
    TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1),
    WIDTH = 640,
    HEIGHT = 360,
    PIXELS = WIDTH * HEIGHT,
    CLOTH = 0,
    FLOOR = 1,
};

typedef struct stage {
    clast_context *context;
    clast_deforming_mesh *cloth, *floor;
    clast_tlas *tlas;
    float positions[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
    clast_ray rays[PIXELS], shadow_rays[PIXELS];
    clast_hit hits[PIXELS];
    uint8_t shadows[PIXELS];
    uint8_t pixels[3 * PIXELS];
} stage;

static const float light[3] = {0.48f, 0.64f, 0.6f}; // towards it; unit length

// Every call that can fail gives a status; the context keeps the text of the newest error.
static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "dynamic_cloth: %s\n",
                context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

static double milliseconds(void)
{
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

// ---------------------------------------------------------------------------------------------- the engine's own part

// Hangs from its upper edge; waves run down it and grow.
static void move_cloth(float *positions, float time)
{
    for (uint32_t i = 0; i < VERTICES; i++) {
        float u = (float)(i % SIDE) / (SIDE - 1), down = (float)(i / SIDE) / (SIDE - 1);
        float slow = sinf(6.0f * down - 3.0f * time + 2.5f * u), fast = sinf(13.0f * u + 9.0f * down - 5.0f * time);
        positions[3 * i] = 2.0f * u - 1.0f + 0.06f * down * sinf(8.0f * down - 4.0f * time);
        positions[3 * i + 1] = 2.0f - 1.7f * down + 0.15f * down * slow * slow;
        positions[3 * i + 2] = down * (0.3f * slow + 0.09f * fast + 0.03f * sinf(41.0f * u + 5.0f * slow));
    }
}

static void connect_cloth(uint32_t *corner)
{
    for (uint32_t j = 0; j + 1 < SIDE; j++) {
        for (uint32_t i = 0; i + 1 < SIDE; i++) {
            uint32_t a = j * SIDE + i;
            const uint32_t quad[6] = {a, a + SIDE, a + SIDE + 1, a, a + SIDE + 1, a + 1};
            for (int k = 0; k < 6; k++) {
                *corner++ = quad[k];
            }
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- set-up

static clast_deforming_mesh *add_mesh(const stage *s, const float *positions, uint32_t vertices,
                                      const uint32_t *indices, uint32_t triangles)
{
    // rtcNewGeometry, rtcSetSharedGeometryBuffer twice, rtcSetGeometryBuildQuality, rtcCommitGeometry, rtcAttachGeometry,
    // rtcCommitScene
    clast_deforming_mesh *mesh = NULL;
    const clast_deforming_mesh_desc desc = {
        .positions = positions, .position_count = vertices, .indices = indices, .triangle_count = triangles};
    check(clast_deforming_mesh_create(s->context, &desc, &mesh), s->context);
    return mesh;
}

static void set_up(stage *s)
{
    static const float corners[12] = {-4, 0, -4, -4, 0, 4, 4, 0, 4, 4, 0, -4};
    static const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
    check(clast_context_create(NULL, &s->context), NULL);       // rtcNewDevice
    check(clast_tlas_create(s->context, &s->tlas), s->context); // rtcNewScene
    move_cloth(s->positions, 0.0f);
    connect_cloth(s->indices);
    s->cloth = add_mesh(s, s->positions, VERTICES, s->indices, TRIANGLES);
    s->floor = add_mesh(s, corners, 4, quad, 2);
}

static void tear_down(stage *s)
{
    clast_tlas_destroy(s->tlas); // rtcReleaseScene
    clast_deforming_mesh_destroy(s->cloth);
    clast_deforming_mesh_destroy(s->floor);
    clast_context_destroy(s->context); // rtcReleaseDevice
}

// ---------------------------------------------------------------------------------------------------------- each frame

static clast_tlas_instance instance_of(const clast_deforming_mesh *mesh, uint32_t id)
{
    return (clast_tlas_instance){
        .blas = clast_deforming_mesh_blas(mesh), .transform = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .id = id};
}

// rtcUpdateGeometryBuffer, rtcCommitGeometry, rtcCommitScene
static void update(stage *s)
{
    const clast_tlas_instance instances[2] = {instance_of(s->cloth, CLOTH), instance_of(s->floor, FLOOR)};
    check(clast_deforming_mesh_update(s->cloth, s->positions, NULL), s->context);
    check(clast_tlas_build(s->tlas, instances, 2, CLAST_BUILD_FAST), s->context);
}

// Tiles of 8 x 8 pixels: rays that are near each other in the array should be near each other in space.
static uint32_t pixel_of(uint32_t ray)
{
    uint32_t tile = ray / 64, within = ray % 64;
    return (tile / (WIDTH / 8) * 8 + within / 8) * WIDTH + tile % (WIDTH / 8) * 8 + within % 8;
}

static void aim(stage *s)
{
    static const float right[3] = {0.88f, 0, -0.475f}, up[3] = {-0.1f, 0.978f, -0.185f},
                       forward[3] = {-0.465f, -0.21f, -0.86f};
    for (uint32_t i = 0; i < PIXELS; i++) {
        float x = ((float)(pixel_of(i) % WIDTH) + 0.5f) / HEIGHT - 0.5f * WIDTH / HEIGHT;
        float y = 0.5f - ((float)(pixel_of(i) / WIDTH) + 0.5f) / HEIGHT;
        s->rays[i] = (clast_ray){.origin = {1.9f, 1.9f, 3.4f}, .t_max = INFINITY};
        for (int k = 0; k < 3; k++) {
            s->rays[i].direction[k] = forward[k] + x * right[k] + y * up[k];
        }
    }
}

// From each hit towards the light, a little away from the surface; rays that hit nothing get one that hits nothing.
static void aim_shadows(stage *s)
{
    for (uint32_t i = 0; i < PIXELS; i++) {
        const clast_ray *ray = &s->rays[i];
        const clast_hit *hit = &s->hits[i];
        s->shadow_rays[i] = (clast_ray){.t_min = 1e-3f, .t_max = INFINITY};
        for (int k = 0; k < 3 && hit->instance != CLAST_NONE; k++) {
            s->shadow_rays[i].origin[k] = ray->origin[k] + hit->t * ray->direction[k];
            s->shadow_rays[i].direction[k] = light[k];
        }
    }
}

static void shade(stage *s, uint32_t i)
{
    const clast_hit *hit = &s->hits[i];
    float colour[3] = {0.55f, 0.7f, 0.9f};
    if (hit->instance != CLAST_NONE) {
        const float *n = hit->normal;
        float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        float lit = fabsf(n[0] * light[0] + n[1] * light[1] + n[2] * light[2]) / length; // thin: seen from both sides
        float strength = 0.15f + (s->shadows[i] != 0 ? 0.0f : 0.85f * lit);
        colour[0] = strength * (hit->instance == CLOTH ? 0.85f : 0.6f);
        colour[1] = strength * (hit->instance == CLOTH ? 0.2f : 0.6f);
        colour[2] = strength * (hit->instance == CLOTH ? 0.15f : 0.6f);
    }
    for (int k = 0; k < 3; k++) {
        s->pixels[3 * pixel_of(i) + (uint32_t)k] = (uint8_t)(255.0f * sqrtf(colour[k]));
    }
}

// A call takes as many rays as there are, and runs on the thread that calls: an engine gives parts to its own threads.
static void trace(stage *s)
{
    clast_trace_closest(s->tlas, s->rays, PIXELS, NULL, s->hits); // rtcIntersect1, rtcIntersect8, rtcIntersect1M
    aim_shadows(s);
    clast_trace_any(s->tlas, s->shadow_rays, PIXELS, NULL, s->shadows); // rtcOccluded1 and its like
}

// Sums times over what was moved, updated and traced, and keeps the longest update.
typedef struct times {
    double move, update, trace, longest;
} times;

static void run_frame(stage *s, uint32_t frame, times *sum)
{
    double begun = milliseconds();
    move_cloth(s->positions, (float)frame / 30.0f);
    double moved = milliseconds();
    update(s);
    double updated = milliseconds();
    trace(s);
    double traced = milliseconds();
    sum->move += moved - begun;
    sum->update += updated - moved;
    sum->trace += traced - updated;
    sum->longest = fmax(sum->longest, updated - moved);
    if (frame % 24 == 0) {
        printf("frame %3u: update %6.2f ms, trace %7.2f ms\n", frame, updated - moved, traced - updated);
    }
}

int main(int count, char **arguments)
{
    uint32_t frames = count > 1 ? (uint32_t)strtoul(arguments[1], NULL, 10) : 240;
    stage *s = calloc(1, sizeof *s);
    if (s == NULL || frames == 0) {
        fprintf(stderr, "usage: dynamic_cloth [FRAMES [PICTURE.png]]\n");
        return 2;
    }
    times sum = {0};
    set_up(s);
    aim(s);
    for (uint32_t frame = 0; frame < frames; frame++) {
        run_frame(s, frame, &sum);
    }
    printf("%d triangles, %u threads, %.1f bytes a triangle; of %u frames the mean: cloth moved in %.2f ms, "
           "updated in %.2f ms (at most %.2f), %d rays and their shadows traced on one thread in %.2f ms\n",
           TRIANGLES, clast_context_threads(s->context), (double)clast_deforming_mesh_bytes(s->cloth) / TRIANGLES,
           frames, sum.move / frames, sum.update / frames, sum.longest, PIXELS, sum.trace / frames);
    if (count > 2) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            shade(s, i);
        }
        clast_image image = {
            .width = WIDTH, .height = HEIGHT, .channels = 3, .type = CLAST_PIXEL_UNORM8, .pixels = s->pixels};
        check(clast_image_write(s->context, arguments[2], &image), s->context);
    }
    tear_down(s);
    free(s);
    return 0;
}
