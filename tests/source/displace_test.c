// SPDX-License-Identifier: Apache-2.0
// Points displaced many at once, beside the shared formulas one by one: the same bits for every instruction set.
#include "test.h"

#include <math.h>
#include <string.h>

#include "shared/tessellation.h"
#include "shared/random.h"
#include "source/displace.h"

enum { ROUNDS = 300, POINTS = 256, CORNERS = 256 };

static const clast_isa all_sets[] = {
#define SET(name, value, text) name,
    CLAST_ISA_LIST(SET)
#undef SET
};

typedef struct randoms {
    uint32_t state;
} randoms;

static uint32_t next(randoms *r)
{
    r->state = r->state * 747796405u + 2891336453u;
    uint32_t word = ((r->state >> ((r->state >> 28) + 4)) ^ r->state) * 277803737u;
    return word >> 22 ^ word;
}

static uint32_t below(randoms *r, uint32_t end)
{
    return next(r) % end;
}

static float between(randoms *r, float low, float high)
{
    return low + (high - low) * (float)(next(r) >> 8) * 0x1p-24f;
}

// ------------------------------------------------------------------------------------------------------------- scenes

typedef struct maps {
    clast_scene *scene;
    clast_height_store *store;
    const clast_height *heights[9];
    uint32_t count;
} maps;

static void add_map(clast_context *context, maps *m, randoms *r, clast_pixel_type type, uint32_t width, uint32_t rows,
                    clast_wrap wrap_u, clast_wrap wrap_v)
{
    size_t texels = (size_t)width * rows;
    uint32_t *pixels = malloc(texels * sizeof *pixels);
    for (size_t i = 0; i < texels; i++) {
        float value = between(r, -4.0f, 4.0f);
        memcpy(&pixels[i], &value, sizeof value);
    }
    clast_image image = {width, rows, 1, type, pixels};
    uint32_t number = 0;
    assert_ok(context, clast_scene_add_image(m->scene, &image, NULL, &number));
    clast_texture texture = {number, wrap_u, wrap_v, CLAST_FILTER_LINEAR};
    assert_ok(context, clast_scene_add_texture(m->scene, &texture, &number));
    assert_ok(context, clast_height_acquire(m->store, m->scene, number, &m->heights[m->count]));
    m->count++;
    free(pixels);
}

static void open_maps(clast_context *context, maps *m, randoms *r)
{
    *m = (maps){0};
    assert_ok(context, clast_scene_create(context, &m->scene));
    assert_ok(context, clast_height_store_create(context, &m->store));
    static const clast_wrap ways[] = {CLAST_WRAP_REPEAT, CLAST_WRAP_CLAMP, CLAST_WRAP_MIRROR};
    static const clast_pixel_type types[] = {CLAST_PIXEL_UNORM16, CLAST_PIXEL_UNORM8, CLAST_PIXEL_FLOAT};
    static const uint32_t sizes[][2] = {{64, 32}, {37, 61}, {1, 1}, {200, 3}, {1, 9}, {256, 256}, {17, 130}, {2, 2}};
    for (uint32_t i = 0; i < 8; i++) {
        add_map(context, m, r, types[i % 3], sizes[i][0], sizes[i][1], ways[i % 3], ways[(i + i / 3) % 3]);
    }
    m->heights[m->count++] = NULL;
}

static void close_maps(maps *m)
{
    for (uint32_t i = 0; i < m->count; i++) {
        clast_height_release(m->store, m->heights[i]);
    }
    clast_height_store_destroy(m->store);
    clast_scene_destroy(m->scene);
}

// --------------------------------------------------------------------------------------------------------------- jobs

typedef struct points {
    clast_displace_corner corners[CORNERS];
    uint32_t numbers[POINTS], weights[POINTS];
    clast_weights within[3];        // of a part's corners
    vec3 positions[3], controls[6]; // of the curve
    clast_displace_curve curve;
    packed3 wanted[POINTS], found[POINTS + 1];
} points;

static uint32_t any_weights(randoms *r)
{
    switch (below(r, 6)) {
    case 0: return 0;
    case 1: return 32768u;
    case 2: return 32768u << 16;
    case 3: return below(r, 32769);
    default: break;
    }
    uint32_t second = below(r, 32769), third = below(r, 32769 - second);
    return second | third << 16;
}

static float special(randoms *r)
{
    static const float specials[] = {0.0f,   -0.0f, 1.0f,  -1.0f, 0.5f,        2.0f,     -3.0f, 1e-20f,
                                     -1e-7f, 1e7f,  -1e9f, 3e8f,  0.99999994f, 16384.0f, -0.5f, 123456.78f};
    return specials[below(r, sizeof specials / sizeof *specials)];
}

static void make_corners(points *p, randoms *r, const clast_height *height)
{
    float levels = height != NULL ? (float)height->map.level_count : 1.0f;
    bool odd = below(r, 4) == 0, whole_levels = below(r, 3) == 0;
    for (uint32_t i = 0; i < CORNERS; i++) {
        clast_displace_corner *c = &p->corners[i];
        float level = floorf(between(r, 0.0f, levels - 1.0f) * 256.0f) / 256.0f;
        *c = (clast_displace_corner){{0}};
        c->of[DISPLACE_LEVEL] = whole_levels ? floorf(levels * 0.5f) : level;
        for (int k = 0; k < 3; k++) {
            c->of[DISPLACE_POSITION + k] = odd && below(r, 4) == 0 ? special(r) : between(r, -10.0f, 10.0f);
            c->of[DISPLACE_NORMAL + k] = odd && below(r, 3) == 0 ? 0.0f : between(r, -1.0f, 1.0f);
        }
        for (int k = 0; k < 2; k++) {
            c->of[DISPLACE_COORDINATES + k] = odd && below(r, 2) == 0 ? special(r) : between(r, -2.0f, 3.0f);
        }
    }
}

// Of the first three corners.
static void make_curve(points *p)
{
    vec3 normals[3];
    for (uint32_t k = 0; k < 3; k++) {
        const float *of = p->corners[k].of;
        p->positions[k] = vec3(of[0], of[1], of[2]);
        normals[k] = vec3(of[3], of[4], of[5]);
    }
    for (uint32_t k = 0; k < 6; k++) {
        p->controls[k] = curved_control(p->positions, normals, k);
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        for (uint32_t k = 0; k < 3; k++) {
            p->curve.positions[k][axis] = p->positions[k][axis];
        }
        for (uint32_t k = 0; k < 6; k++) {
            p->curve.controls[k][axis] = p->controls[k][axis];
        }
    }
}

static packed3 displaced(const points *p, const clast_displace_job *job, uint32_t i)
{
    uint32_t numbers = job->numbers != NULL ? job->numbers[i] : 0x020100;
    const clast_displace_corner *a = &job->corners[numbers & 255], *b = &job->corners[numbers >> 8 & 255];
    const clast_displace_corner *c = &job->corners[numbers >> 16];
    clast_weights own = weights_of(job->weights[i]), w = own;
    if (job->within != NULL) {
        w = weights_within(job->within[0], job->within[1], job->within[2], own);
    }
    float of[DISPLACE_ATTRIBUTES];
    for (int k = 0; k < DISPLACE_ATTRIBUTES; k++) {
        of[k] = blend1(a->of[k], b->of[k], c->of[k], w);
    }
    vec3 position = vec3(of[0], of[1], of[2]);
    if (job->curve != NULL) {
        position = curved_blend(p->positions, p->controls, curved_weights(w));
    }
    of[DISPLACE_LEVEL] = blend1(a->of[DISPLACE_LEVEL], b->of[DISPLACE_LEVEL], c->of[DISPLACE_LEVEL], own);
    float height = job->offset;
    if (job->height != NULL) {
        height = clast_height_value(job->height, vec2(of[6], of[7]), of[8]) * job->scale + job->offset;
    }
    return store3(displaced_point(position, vec3(of[3], of[4], of[5]), height));
}

static void make_job(points *p, randoms *r, const clast_height *height, clast_displace_job *job)
{
    make_corners(p, r, height);
    *job = (clast_displace_job){.height = height, .scale = between(r, -2.0f, 2.0f), .offset = between(r, -1.0f, 1.0f)};
    job->corners = p->corners;
    job->weights = p->weights;
    job->count = 1 + below(r, below(r, 3) == 0 ? POINTS : 40);
    for (uint32_t i = 0; i < job->count; i++) {
        p->weights[i] = any_weights(r);
        p->numbers[i] = next(r) & 0xffffff;
    }
    job->numbers = below(r, 2) == 0 ? p->numbers : NULL;
    make_curve(p);
    job->curve = job->numbers == NULL && below(r, 2) == 0 ? &p->curve : NULL;
    job->within = job->curve != NULL && below(r, 2) == 0 ? p->within : NULL;
    for (uint32_t k = 0; k < 3; k++) {
        p->within[k] = weights_of(any_weights(r));
    }
    for (uint32_t i = 0; i < job->count; i++) {
        p->wanted[i] = displaced(p, job, i);
    }
}

static void assert_same_points(points *p, clast_displace_job *job, clast_isa set)
{
    memset(p->found, 0x55, sizeof p->found);
    job->positions = p->found;
    clast_displace_kernel_of(set)(job);
    for (uint32_t i = 0; i < job->count; i++) {
        for (int k = 0; k < 3; k++) {
            if (memcmp(&p->wanted[i].v[k], &p->found[i].v[k], sizeof(float)) != 0) {
                fail_msg("%s: point %u of %u: %a instead of %a", clast_isa_text(set), i, job->count,
                         (double)p->found[i].v[k], (double)p->wanted[i].v[k]);
            }
        }
    }
    packed3 untouched;
    memset(&untouched, 0x55, sizeof untouched);
    assert_memory_equal(&p->found[job->count], &untouched, sizeof untouched);
}

static void many_points_have_the_bits_of_single_ones(void **state)
{
    randoms r = {1};
    maps m;
    open_maps(*state, &m, &r);
    points *p = aligned_alloc(64, (sizeof *p + 63) / 64 * 64);
    for (uint32_t round = 0; round < ROUNDS; round++) {
        clast_displace_job job;
        make_job(p, &r, m.heights[round % m.count], &job);
        for (size_t i = 0; i < sizeof all_sets / sizeof *all_sets && all_sets[i] <= clast_isa_best(); i++) {
            assert_same_points(p, &job, all_sets[i]);
        }
    }
    free(p);
    close_maps(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(many_points_have_the_bits_of_single_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
