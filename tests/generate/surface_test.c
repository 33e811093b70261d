// SPDX-License-Identifier: Apache-2.0
// Meshes from functions are closed where their parameters are, in strips of any length.
#include "folder.h"

#include <math.h>

#include "generate/noise.h"
#include "generate/surface.h"

static void evaluate_torus(const void *shape, float u, float v, clast_surface_point *point)
{
    (void)shape;
    float radius = 3.0f + wave_cosine(v);
    point->position = vec3(wave_cosine(u) * radius, wave_sine(u) * radius, wave_sine(v));
    point->coordinates = vec2(u, v);
}

static void evaluate_cube(const void *shape, vec3 p, uint32_t face, clast_surface_point *point)
{
    (void)shape, (void)face;
    point->position = normalize3(p);
    point->normal = point->position;
    point->coordinates = vec2(p[0], p[1]);
}

typedef struct built {
    folder to;
    packed3 *positions, *normals;
    uint32_t *indices;
    size_t vertices, triangles;
} built;

typedef void (*build_function)(clast_builder *builder, const void *what);

static void build_sheet(clast_builder *builder, const void *what)
{
    clast_build_sheet(builder, what);
}
static void build_block(clast_builder *builder, const void *what)
{
    clast_build_block(builder, what);
}

static built build(clast_context *context, build_function function, const void *what)
{
    built b = {.to = folder_make()};
    clast_outputs outputs;
    clast_gltf_writer writer;
    clast_outputs_begin(&outputs, context, b.to.path);
    clast_gltf_begin(&writer, &outputs, "test");
    clast_builder builder = {.context = context, .writer = &writer, .expected = 1};
    uint32_t material = clast_gltf_add_material(&writer, &(clast_gltf_material){.name = "plain", .roughness = 1.0f});
    clast_gltf_begin_mesh(&writer);
    clast_gltf_begin_primitive(&writer, material);
    function(&builder, what);
    clast_gltf_end_primitive(&writer);
    clast_gltf_add_node(&writer, "test", clast_gltf_end_mesh(&writer, "test"), splat3(0.0f),
                        vec4(0.0f, 0.0f, 0.0f, 1.0f), splat3(1.0f));
    clast_builder_end(&builder);
    clast_gltf_end(&writer);
    assert_ok(context, clast_outputs_commit(&outputs));
    char path[512];
    size_t size;
    folder_file(&b.to, "test_positions.bin", path);
    b.positions = (packed3 *)read_whole(path, &size);
    b.vertices = size / sizeof(packed3);
    folder_file(&b.to, "test_normals.bin", path);
    b.normals = (packed3 *)read_whole(path, &size);
    folder_file(&b.to, "test_indices.bin", path);
    b.indices = (uint32_t *)read_whole(path, &size);
    b.triangles = size / 12;
    return b;
}

static void built_free(built *b)
{
    free(b->positions);
    free(b->normals);
    free(b->indices);
    folder_remove(&b->to);
}

// An edge as its two end positions, with the way it is gone.
typedef struct edge {
    packed3 a, b;
    int way;
} edge;

static int compare_edges(const void *x, const void *y)
{
    const edge *a = x, *b = y;
    for (int i = 0; i < 6; i++) {
        float p = i < 3 ? a->a.v[i] : a->b.v[i - 3], q = i < 3 ? b->a.v[i] : b->b.v[i - 3];
        if (p != q) {
            return p < q ? -1 : 1;
        }
    }
    return 0;
}

static bool is_less(packed3 a, packed3 b)
{
    for (int i = 0; i < 3; i++) {
        if (a.v[i] != b.v[i]) {
            return a.v[i] < b.v[i];
        }
    }
    return false;
}

// Every edge, told by its end positions to the bit, is gone once each way: closed, and turned the same way everywhere.
static void assert_closed(const built *b)
{
    edge *edges = malloc(b->triangles * 3 * sizeof *edges);
    for (size_t i = 0; i < b->triangles; i++) {
        for (size_t k = 0; k < 3; k++) {
            packed3 p = b->positions[b->indices[3 * i + k]], q = b->positions[b->indices[3 * i + (k + 1) % 3]];
            edges[3 * i + k] = is_less(p, q) ? (edge){p, q, 1} : (edge){q, p, -1};
        }
    }
    qsort(edges, b->triangles * 3, sizeof *edges, compare_edges);
    for (size_t i = 0; i < b->triangles * 3; i += 2) {
        assert_int_equal(compare_edges(&edges[i], &edges[i + 1]), 0);
        assert_int_equal(edges[i].way + edges[i + 1].way, 0);
    }
    free(edges);
}

static void a_sheet_that_wraps_is_closed(void **state)
{
    clast_sheet sheet = {
        .evaluate = evaluate_torus, .columns = 37, .rows = 23, .wraps_columns = true, .wraps_rows = true};
    built b = build(*state, build_sheet, &sheet);
    assert_int_equal(b.triangles, 37 * 23 * 2);
    assert_closed(&b);
    built_free(&b);
}

static void strips_of_a_large_sheet_join(void **state)
{
    clast_sheet sheet = {
        .evaluate = evaluate_torus, .columns = 400, .rows = 700, .wraps_columns = true, .wraps_rows = true};
    built b = build(*state, build_sheet, &sheet);
    assert_int_equal(b.triangles, 400 * 700 * 2);
    assert_closed(&b);
    built_free(&b);
}

static void normals_point_outwards(void **state)
{
    clast_sheet sheet = {
        .evaluate = evaluate_torus, .columns = 90, .rows = 60, .wraps_columns = true, .wraps_rows = true};
    built b = build(*state, build_sheet, &sheet);
    for (size_t i = 0; i < b.vertices; i++) {
        vec3 p = load3(b.positions[i]), n = load3(b.normals[i]);
        vec3 middle = normalize3(vec3(p[0], p[1], 0.0f)) * 3.0f;
        assert_true(dot3(n, p - middle) > 0.99f);
    }
    built_free(&b);
}

static void a_block_is_closed(void **state)
{
    clast_block block = {
        .evaluate = evaluate_cube, .segments = {7, 4, 9}, .bevel_segments = 1, .bevels = {0.1f, 0.2f, 0.05f}};
    built b = build(*state, build_block, &block);
    assert_int_equal(b.triangles, 4 * (7 * 4 + 4 * 9 + 9 * 7));
    assert_closed(&b);
    built_free(&b);
}

static void evaluate_cone(const void *shape, float u, float v, clast_surface_point *point)
{
    (void)shape;
    point->position = vec3(wave_cosine(u) * (1.0f - v), v, -wave_sine(u) * (1.0f - v));
    point->coordinates = vec2(u, v);
}

static void a_pole_has_no_slivers_and_sound_normals(void **state)
{
    clast_sheet sheet = {.evaluate = evaluate_cone, .columns = 20, .rows = 5, .wraps_columns = true};
    built b = build(*state, build_sheet, &sheet);
    assert_int_equal(b.triangles, 20 * 5 * 2 - 20);
    for (size_t i = 0; i < b.vertices; i++) {
        vec3 n = load3(b.normals[i]);
        assert_true(fabsf(dot3(n, n) - 1.0f) < 1e-5f && n[1] > 0.6f);
    }
    built_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_sheet_that_wraps_is_closed),
        CONTEXT_TEST(strips_of_a_large_sheet_join),
        CONTEXT_TEST(normals_point_outwards),
        CONTEXT_TEST(a_block_is_closed),
        CONTEXT_TEST(a_pole_has_no_slivers_and_sound_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
