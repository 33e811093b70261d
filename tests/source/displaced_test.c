// SPDX-License-Identifier: Apache-2.0
// What tessellated and displaced meshes promise beside the contract of all sources; that they have no cracks is tested in
// displaced_crack_test.c.
#include <string.h>

#include "source/displaced.h"
#include "source/kinds.h"

// Material 0 displaces by `height`, material 1 does not.
static kind_world open_shape(clast_context *context, const clast_mesh *mesh, float height, bool curved)
{
    kind_world world = kind_begin(context, CLAST_SOURCE_DISPLACED);
    uint32_t geometry = CLAST_NONE, still = CLAST_NONE;
    clast_material_desc plain = clast_material_defaults();
    assert_ok(context, clast_scene_add_material(world.scene, &plain, "still", &still));
    assert_ok(context, clast_scene_add_mesh(world.scene, mesh, "shape", &geometry));
    if (height != 0.0f) {
        shape_displace(context, world.scene, geometry, 0, height);
    }
    assert_ok(context, clast_scene_set_tessellation(world.scene, geometry, &(clast_tessellation){curved}));
    kind_cook(&world, geometry);
    return world;
}

static kind_world open_sphere(clast_context *context, uint32_t columns, float height, bool curved)
{
    shape sphere = shape_sphere(columns, columns / 2);
    kind_world world = open_shape(context, &sphere.mesh, height, curved);
    shape_free(&sphere);
    return world;
}

static uint64_t triangles_at(const kind_world *world, const clast_pose *pose, const clast_source_view *view)
{
    uint64_t sum = 0;
    for (uint32_t item = 0; item < world->unit->item_count; item++) {
        sum += world->source->count(world->unit, pose, view, item).triangles;
    }
    return sum;
}

// ------------------------------------------------------------------------------------------------------------- rates

// Where a corner of a record's triangle is on the mesh: weights of its triangle's corners.
typedef struct base_place {
    uint32_t primitive;
    vec3 weights;
    vec3 position; // before it is displaced
} base_place;

static base_place place_of(const kind_world *world, const kind_emission *all, size_t record, uint32_t triangle, vec2 at)
{
    const clast_mesh *mesh = &world->unit->geometry->of.mesh;
    const uint32_t *words = all->words + all->records[record].first_word;
    clast_surface_point point = world->source->locate(world->unit, &kind_poses[0], &all->records[record], words,
                                                      triangle, at);
    vec2 b = load2(point.coordinates);
    base_place place = {point.primitive, vec3(1.0f - b[0] - b[1], b[0], b[1]), splat3(0.0f)};
    for (uint32_t k = 0; k < 3; k++) {
        const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)point.primitive + k];
        place.position += vec3(p[0], p[1], p[2]) * place.weights[k];
    }
    return place;
}

// Whether two points lie on an edge of their triangle that is cut between them and elsewhere.
static bool is_segment(base_place a, base_place b)
{
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t next = (k + 1) % 3;
        float part = fabsf(a.weights[next] - b.weights[next]);
        if (fabsf(a.weights[k]) < 1e-5f && fabsf(b.weights[k]) < 1e-5f && part < 0.999f) {
            return true;
        }
    }
    return false;
}

// On a sphere about the origin: turned to the eye by more than grazing, and within the picture.
static bool is_seen(const clast_source_view *view, vec3 position)
{
    vec3 away = load3(view->eye) - position;
    vec3 camera = transform_point(view->to_camera, position);
    return dot3(normalize3(position), normalize3(away)) > 0.1f && fabsf(camera[0]) < view->extent.v[0] * camera[2] &&
           fabsf(camera[1]) < view->extent.v[1] * camera[2];
}

static float pixels_between(const clast_source_view *view, vec3 a, vec3 b)
{
    vec3 p = transform_point(view->to_camera, a), q = transform_point(view->to_camera, b);
    float x = p[0] / p[2] - q[0] / q[2], y = p[1] / p[2] - q[1] / q[2];
    return sqrtf(x * x + y * y) * view->pixels;
}

typedef struct tally {
    uint32_t all, near;
} tally;

static void tally_record(const kind_world *world, const clast_source_view *view, const kind_emission *all,
                         size_t record, tally *sum)
{
    const vec2 corners[3] = {vec2(0.0f, 0.0f), vec2(1.0f, 0.0f), vec2(0.0f, 1.0f)};
    for (uint32_t t = 0; t < record_triangles(all->records[record]); t++) {
        base_place places[3];
        for (uint32_t k = 0; k < 3; k++) {
            places[k] = place_of(world, all, record, t, corners[k]);
        }
        for (uint32_t k = 0; k < 3; k++) {
            base_place a = places[k], b = places[(k + 1) % 3];
            if (is_segment(a, b) && is_seen(view, a.position) && is_seen(view, b.position)) {
                float pixels = pixels_between(view, a.position, b.position);
                sum->all++;
                sum->near += pixels >= 0.5f && pixels <= 2.0f;
            }
        }
    }
}

static void segments_of_seen_edges_are_as_long_as_wanted(void **state)
{
    kind_world world = open_sphere(*state, 40, 0.02f, false);
    clast_source_view views[] = {
        KIND_VIEW(0.2f, 0.3f, 5, 600, 1, 0),    // all of it, most edges a pattern's
        KIND_VIEW(0, 0.4f, 1.4f, 400, 1, 0),    // near, mostly split
        KIND_VIEW(0.7f, 0.8f, 1.1f, 300, 1, 0), // at the side
    };
    for (uint32_t i = 0; i < sizeof views / sizeof *views; i++) {
        views[i].segment = 1.0f;
        kind_emission all = kind_emit(&world, &kind_poses[0], &views[i]);
        tally sum = {0};
        for (size_t record = 0; record < all.record_count; record++) {
            tally_record(&world, &views[i], &all, record, &sum);
        }
        kind_emission_free(&all);
        print_message("%u segments, %.1f %% of half a pixel to two\n", sum.all, 100.0 * sum.near / sum.all);
        assert_true(sum.all > 1000);
        assert_true((double)sum.near >= 0.95 * sum.all);
    }
    kind_close(&world);
}

static void every_metric_counts_in_its_own_unit(void **state)
{
    kind_world world = open_sphere(*state, 40, 0.0f, false);
    const clast_pose *pose = &kind_poses[0];
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.alone = 0; // nothing is hidden
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 3.0f;
    assert_int_equal(triangles_at(&world, pose, &view),
                     1520 * 9 + 80 * 5); // those at the poles have an edge of no length
    clast_source_view nearer = view;
    nearer.eye.v[2] = nearer.to_camera.rows[2].v[3] = 2.5f;
    assert_int_equal(triangles_at(&world, pose, &nearer), triangles_at(&world, pose, &view));

    view.metric = nearer.metric = CLAST_METRIC_LENGTH;
    view.segment = nearer.segment = 0.01f;
    uint64_t sparse = triangles_at(&world, pose, &view);
    assert_int_equal(triangles_at(&world, pose, &nearer), sparse);
    double area = 12.566, ideal = area / (0.01 * 0.01 * 0.5);
    assert_true((double)sparse > 0.6 * ideal && (double)sparse < 1.5 * ideal);

    view.metric = nearer.metric = CLAST_METRIC_SPHERE;
    view.segment = nearer.segment = 4.0f;
    double ratio = (double)triangles_at(&world, pose, &nearer) / (double)triangles_at(&world, pose, &view);
    assert_true(ratio > 4.0 && ratio < 9.0); // the near side comes nearer by a factor of 2.7, the far one of 1.7
    clast_source_view away = view;
    away.to_camera.rows[0].v[0] = -1.0f; // turned round
    away.to_camera.rows[2].v[2] = 1.0f;
    away.to_camera.rows[2].v[3] = -5.0f;
    assert_int_equal(triangles_at(&world, pose, &away), triangles_at(&world, pose, &view));
    kind_close(&world);
}

static void what_is_not_seen_keeps_its_fraction(void **state)
{
    kind_world world = open_sphere(*state, 40, 0.0f, false);
    const clast_pose *pose = &kind_poses[0];
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_LENGTH;
    view.segment = 0.004f;
    view.alone = 0;
    uint64_t all = triangles_at(&world, pose, &view);
    view.alone = 1;
    uint64_t front = triangles_at(&world, pose, &view); // half of it faces away
    assert_true((double)front > 0.65 * (double)all && (double)front < 0.85 * (double)all);
    view.hidden = 1;
    uint64_t hidden = triangles_at(&world, pose, &view);
    double part = (double)hidden / (double)all; // a quarter each way
    assert_true(part > 0.05 && part < 0.09);
    // turned to where nothing is
    view.hidden = 0;
    view.to_camera.rows[0].v[0] = -1.0f;
    view.to_camera.rows[2].v[2] = 1.0f;
    view.to_camera.rows[2].v[3] = -5.0f;
    assert_int_equal(triangles_at(&world, pose, &view), hidden);
    kind_close(&world);
}

static void edges_are_hidden_little_by_little(void **state)
{
    kind_world world = open_sphere(*state, 40, 0.0f, false);
    clast_source_view view = KIND_VIEW(0, 0, 3, 900, 1, 0);
    uint64_t last = 0, most = 0, jump = 0;
    for (uint32_t i = 0; i <= 400; i++) { // the camera moves aside
        float x = 4.0f * (float)i / 400.0f;
        view.eye.v[0] = x;
        view.to_camera.rows[0].v[3] = -x;
        uint64_t now = triangles_at(&world, &kind_poses[0], &view);
        uint64_t step = now > last ? now - last : last - now;
        jump = i != 0 && step > jump ? step : jump;
        most = now > most ? now : most;
        last = now;
    }
    assert_true(last < most / 3);
    assert_true((double)jump < 0.05 * (double)most);
    kind_close(&world);
}

// The least that the weights of two corners of a part differ by; WEIGHT_ONE where nothing is split.
static uint32_t narrowest_part(const kind_world *world, const clast_source_view *view)
{
    const displaced_unit *unit = clast_displaced_of(world->unit);
    kind_emission all = kind_emit(world, &kind_poses[0], view);
    uint32_t least = WEIGHT_ONE;
    for (size_t i = 0; i < all.record_count; i++) {
        displaced_reader reader = clast_displaced_read(unit, &all.records[i], all.words + all.records[i].first_word);
        while (clast_displaced_next(&reader)) {
            for (uint32_t k = 0; k < 3 && reader.leaf.split; k++) {
                least = min_uint(least, weights_apart(reader.leaf.corners[k].at, reader.leaf.corners[(k + 1) % 3].at));
            }
        }
    }
    kind_emission_free(&all);
    return least;
}

// An edge that has as many segments as a pattern at most keeps them. On rough ground, edges beside it may ask for more: they have
// other middles.
static void parts_beside_an_edge_that_is_kept_are_not_split_without_end(void **state)
{
    kind_world world = open_sphere(*state, 6, 4.0f, false);
    uint32_t least = WEIGHT_ONE;
    float segment = 27.0f;
    for (uint32_t i = 0; i < 80; i++, segment *= 0.985f) {
        clast_source_view view = KIND_VIEW(0, 0, 2.5f + 0.05f * (float)(i % 20), 500, 1, 0);
        view.segment = segment;
        least = min_uint(least, narrowest_part(&world, &view));
    }
    assert_true(least < WEIGHT_ONE / 8); // some are split more than once
    assert_true(least >= WEIGHT_ONE / 512);
    kind_close(&world);
}

static void a_bulge_between_ends_is_not_missed(void **state)
{
    // two triangles, seen along their plane; the map rises in the middle only
    float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    float coordinates[] = {0, 1, 1, 1, 1, 0, 0, 0};
    uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    clast_mesh mesh = {.vertex_count = 4,
                       .triangle_count = 2,
                       .positions = positions,
                       .normals = normals,
                       .coordinates = {coordinates, NULL},
                       .indices = indices,
                       .material = CLAST_NONE};
    kind_world world = open_shape(*state, &mesh, 2.0f, false);
    clast_pose flat = {.displacement_scale = 0.0f};
    clast_source_view view = KIND_VIEW(0, 0, 6, 300, 1, 0);
    uint64_t raised = triangles_at(&world, &kind_poses[0], &view), plain = triangles_at(&world, &flat, &view);
    assert_true(raised > plain);
    kind_close(&world);
}

// However near one looks, as much as the picture shows is wanted; also where maps do not agree at a seam, so that there is a step.
static void looking_closer_wants_no_more_of_what_is_not_seen(void **state)
{
    shape sphere = shape_sphere(90, 45);
    uint32_t *materials = calloc(sphere.mesh.triangle_count, sizeof *materials);
    for (uint32_t i = 0; i < sphere.mesh.triangle_count; i += 3) {
        materials[i] = 1;
    }
    for (uint32_t torn = 0; torn < 2; torn++) {
        sphere.mesh.triangle_materials = torn != 0 ? materials : NULL;
        kind_world world = open_shape(*state, &sphere.mesh, 0.3f, false);
        for (float zoom = 16.0f; zoom < 2000.0f; zoom *= 8.0f) {
            clast_source_view view = KIND_VIEW(0.15f, 0.1f, 3, 450 * zoom, 1, 0);
            view.segment = 2.0f;
            view.extent = (packed2){{0.7f / zoom, 0.44f / zoom}};
            uint64_t triangles = triangles_at(&world, &kind_poses[0], &view);
            print_message("%g: %llu triangles\n", (double)zoom, (unsigned long long)triangles);
            assert_in_range(triangles, 50000, 1500000);
        }
        kind_close(&world);
    }
    free(materials);
    shape_free(&sphere);
}

// ------------------------------------------------------------------------------------------------------------ records

static void small_leaves_fill_their_clusters(void **state)
{
    kind_world world = open_sphere(*state, 100, 0.01f, false);
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_SPHERE;
    view.alone = 0;
    for (float segment = 6.0f; segment > 1.0f; segment *= 0.7f) {
        view.segment = segment;
        kind_emission all = kind_emit(&world, &kind_poses[0], &view);
        uint64_t triangles = triangles_at(&world, &kind_poses[0], &view);
        double fill = (double)triangles / (double)all.record_count;
        double shared = (double)all.vertex_count / (double)triangles;
        print_message("%.1f triangles a base triangle: %.1f a cluster, %.2f vertices a triangle\n",
                      (double)triangles / world.unit->geometry->of.mesh.triangle_count, fill, shared);
        assert_true(fill >= 96.0);
        assert_true(shared < 0.85);
        kind_emission_free(&all);
    }
    kind_close(&world);
}

// ------------------------------------------------------------------------------------------------------------ surface

static void curved_triangles_bend_along_their_normals(void **state)
{
    kind_world world = open_sphere(*state, 12, 0.0f, true);
    kind_world flat = open_sphere(*state, 12, 0.0f, false);
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 7.0f;
    float least[2] = {1.0f, 1.0f}, most[2] = {0.0f, 0.0f};
    for (uint32_t i = 0; i < 2; i++) {
        const kind_world *of = i == 0 ? &world : &flat;
        kind_emission all = kind_emit(of, &kind_poses[0], &view);
        for (size_t v = 0; v < all.vertex_count; v++) {
            float radius = length3(load3(all.vertices[v]));
            least[i] = min1(least[i], radius);
            most[i] = max1(most[i], radius);
        }
        kind_emission_free(&all);
    }
    assert_true(least[1] < 0.96f && least[0] > 0.99f);
    assert_true(most[0] < 1.01f && most[1] < 1.0001f);
    kind_close(&world);
    kind_close(&flat);
}

static void poses_move_the_surface_and_its_normals(void **state)
{
    kind_world world = open_sphere(*state, 24, 0.1f, false);
    const clast_mesh *mesh = &world.unit->geometry->of.mesh;
    packed3 *turned = malloc(mesh->vertex_count * sizeof *turned),
            *normals = malloc(mesh->vertex_count * sizeof *normals);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) { // a quarter about the z axis, and aside
        const float *p = mesh->positions + 3 * i, *n = mesh->normals + 3 * i;
        turned[i] = (packed3){{-p[1] + 4.0f, p[0], p[2]}};
        normals[i] = (packed3){{-n[1], n[0], n[2]}};
    }
    clast_pose pose = {.positions = turned, .normals = normals, .shape = 1, .displacement_scale = 1.0f};
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 5.0f;
    kind_emission still = kind_emit(&world, &kind_poses[0], &view), moved = kind_emit(&world, &pose, &view);
    assert_int_equal(still.vertex_count, moved.vertex_count);
    clast_box box = world.source->bounds(world.unit, &pose);
    for (size_t i = 0; i < still.vertex_count; i++) {
        const float *from = still.vertices[i].v, *to = moved.vertices[i].v;
        assert_true(fabsf(to[0] - (4.0f - from[1])) < 1e-5f && fabsf(to[1] - from[0]) < 1e-5f &&
                    fabsf(to[2] - from[2]) < 1e-5f);
        for (uint32_t axis = 0; axis < 3; axis++) {
            assert_true(to[axis] >= box.lower.v[axis] && to[axis] <= box.upper.v[axis]);
        }
    }
    const uint32_t *words = still.words + still.records[0].first_word;
    clast_surface_point point = world.source->locate(world.unit, &pose, &still.records[0], words, 0, vec2(0.3f, 0.3f));
    vec3 before = normalize3(world.source->evaluate(world.unit, &kind_poses[0], point).normal);
    vec3 after = normalize3(world.source->evaluate(world.unit, &pose, point).normal);
    assert_true(dot3(after, vec3(-before[1], before[0], before[2])) > 0.9999f);
    kind_emission_free(&still);
    kind_emission_free(&moved);
    free(turned);
    free(normals);
    kind_close(&world);
}

// The normals of a surface are those of its triangles where these are small.
static void normals_follow_the_map(void **state)
{
    kind_world world = open_sphere(*state, 24, 0.1f, false);
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 40.0f;
    kind_emission all = kind_emit(&world, &kind_poses[0], &view);
    double sum = 0.0;
    size_t count = 0;
    for (size_t record = 0; record < all.record_count; record++) {
        const uint32_t *words = all.words + all.records[record].first_word;
        const packed3 *vertices = kind_vertices(&world, &all, record);
        for (uint32_t t = 0; t < record_triangles(all.records[record]); t += 7) {
            uint32_t c[3];
            kind_corners(&world, &all.records[record], words, t, c);
            vec3 origin = load3(vertices[c[0]]);
            vec3 flat = cross3(load3(vertices[c[1]]) - origin, load3(vertices[c[2]]) - origin);
            if (fabsf(origin[1]) > 0.8f || length3(flat) < 1e-9f) {
                continue; // towards the poles, where texture coordinates meet
            }
            clast_surface_point point = world.source->locate(world.unit, &kind_poses[0], &all.records[record], words, t,
                                                             vec2(0.33f, 0.33f));
            clast_source_surface surface = world.source->evaluate(world.unit, &kind_poses[0], point);
            sum += (double)dot3(normalize3(surface.normal), flat * (1.0f / length3(flat)));
            count++;
        }
    }
    assert_true(count > 1000);
    assert_true(sum / (double)count > 0.99);
    kind_emission_free(&all);
    kind_close(&world);
}

// -------------------------------------------------------------------------------------------------------------- faults

static void displacement_that_is_out_of_all_bounds_is_refused(void **state)
{
    clast_context *context = *state;
    kind_world world = kind_begin(context, CLAST_SOURCE_DISPLACED);
    uint32_t geometry = shape_add_sphere(context, world.scene, 12, 6);
    shape_displace(context, world.scene, geometry, 0, 1e30f);
    clast_cook_job job = kind_job(&world, geometry);
    assert_int_equal(world.source->cook(&job, &world.unit), CLAST_ERROR_LIMIT);
    assert_non_null(strstr(clast_context_error(context), "sphere: displacement by more than"));
    kind_close(&world);
}

static void a_mesh_without_coordinates_is_not_displaced(void **state)
{
    shape sphere = shape_sphere(12, 6);
    sphere.mesh.coordinates[0] = NULL;
    kind_world world = open_shape(*state, &sphere.mesh, 0.5f, false);
    clast_box box = world.source->bounds(world.unit, &kind_poses[0]);
    assert_true(box.upper.v[1] < 1.001f && box.lower.v[1] > -1.001f);
    kind_emission all = kind_emit(&world, &kind_poses[0], &kind_views[0]);
    for (size_t i = 0; i < all.vertex_count; i++) {
        assert_true(length3(load3(all.vertices[i])) < 1.0001f);
    }
    kind_emission_free(&all);
    shape_free(&sphere);
    kind_close(&world);
}

static void a_mesh_without_normals_is_displaced_along_those_of_its_triangles(void **state)
{
    shape sphere = shape_sphere(24, 12);
    sphere.mesh.normals = NULL;
    kind_world world = open_shape(*state, &sphere.mesh, 0.5f, false);
    kind_emission all = kind_emit(&world, &kind_poses[0], &kind_views[0]);
    float most = 0.0f;
    for (size_t i = 0; i < all.vertex_count; i++) {
        assert_true(is_finite3(load3(all.vertices[i])));
        most = max1(most, length3(load3(all.vertices[i])));
    }
    assert_true(most > 1.05f);
    kind_emission_free(&all);
    shape_free(&sphere);
    kind_close(&world);
}

// Flat triangles, points, lines, normals that are none: finite, and as many as counted.
static void degenerate_meshes_have_a_defined_surface(void **state)
{
    float positions[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 1, 1, 0, 1, 0, 0};
    float normals[] = {0, 0, 0, NAN, 0, 0, 0, 1, 0, 0, -1, 0, INFINITY, 0, 0, 0, 0, 1};
    float coordinates[] = {0, 0, NAN, 0, 1e30f, 1, 0.5f, INFINITY, 0.5f, 0.5f, 1, 1};
    uint32_t indices[] = {0, 1, 2, 0, 0, 0, 0, 3, 1, 1, 5, 4, 0, 1, 4, 3, 4, 2};
    clast_mesh mesh = {.vertex_count = 6,
                       .triangle_count = 6,
                       .positions = positions,
                       .normals = normals,
                       .coordinates = {coordinates, NULL},
                       .indices = indices,
                       .material = CLAST_NONE};
    for (uint32_t curved = 0; curved < 2; curved++) {
        kind_world world = open_shape(*state, &mesh, 0.1f, curved != 0);
        for (uint32_t i = 0; i < KIND_VIEWS; i++) {
            kind_emission all = kind_emit(&world, &kind_poses[0], &kind_views[i]);
            for (size_t v = 0; v < all.vertex_count; v++) {
                assert_true(is_finite3(load3(all.vertices[v])));
            }
            for (size_t r = 0; r < all.record_count; r++) {
                clast_surface_point point = world.source->locate(world.unit, &kind_poses[0], &all.records[r],
                                                                 all.words + all.records[r].first_word, 0,
                                                                 vec2(0.2f, 0.3f));
                assert_true(is_finite3(world.source->evaluate(world.unit, &kind_poses[0], point).position));
            }
            kind_emission_free(&all);
        }
        kind_close(&world);
    }
}

// No frame can hold what these ask for: the count says so instead of counting on.
static void more_triangles_than_can_be_counted_are_not(void **state)
{
    kind_world world = open_sphere(*state, 12, 0.0f, false);
    clast_source_view view = KIND_VIEW(0, 0, 5, 600, 1, 0);
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 30000.0f;
    clast_source_count count = world.source->count(world.unit, &kind_poses[0], &view, 0);
    assert_int_equal(count.triangles, UINT32_MAX);
    kind_close(&world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(segments_of_seen_edges_are_as_long_as_wanted),
        CONTEXT_TEST(every_metric_counts_in_its_own_unit),
        CONTEXT_TEST(what_is_not_seen_keeps_its_fraction),
        CONTEXT_TEST(edges_are_hidden_little_by_little),
        CONTEXT_TEST(parts_beside_an_edge_that_is_kept_are_not_split_without_end),
        CONTEXT_TEST(a_bulge_between_ends_is_not_missed),
        CONTEXT_TEST(looking_closer_wants_no_more_of_what_is_not_seen),
        CONTEXT_TEST(small_leaves_fill_their_clusters),
        CONTEXT_TEST(curved_triangles_bend_along_their_normals),
        CONTEXT_TEST(poses_move_the_surface_and_its_normals),
        CONTEXT_TEST(normals_follow_the_map),
        CONTEXT_TEST(displacement_that_is_out_of_all_bounds_is_refused),
        CONTEXT_TEST(a_mesh_without_coordinates_is_not_displaced),
        CONTEXT_TEST(a_mesh_without_normals_is_displaced_along_those_of_its_triangles),
        CONTEXT_TEST(degenerate_meshes_have_a_defined_surface),
        CONTEXT_TEST(more_triangles_than_can_be_counted_are_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
