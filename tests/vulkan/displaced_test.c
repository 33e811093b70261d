// SPDX-License-Identifier: Apache-2.0
// Displaced meshes on a device against the processor: counts, records, words, positions and corners of composites are the same
// to the bit, for meshes with seams and hard edges, curved and moving ones, maps of every form, every metric, and triangles
// that are split many times.
#include "source/displaced_worlds.h"

#include "vulkan/fit.h"
#include "vulkan/mirror.h"
#include "vulkan/test_device.h"

enum { TRIANGLES_MOST = 60000 };

static test_device device;

// ------------------------------------------------------------------------------------------------------------- twins

// A unit of the processor, and what a device has of it.
typedef struct twin {
    const kind_world *world;
    clast_mirror *mirror;
    clast_frame_unit unit;
    clast_device_unit record;
    clast_gpu_buffer units, spans, counts, sums, drafts, draft_places, records, words, vertices, corners;
    uint32_t draws; // how many were compared
} twin;

static twin twin_open(const kind_world *world)
{
    twin t = {.world = world, .unit = {.unit = world->unit}};
    assert_ok(device.context, clast_mirror_create(device.gpu, &t.mirror));
    return t;
}

static void twin_close(twin *t)
{
    clast_gpu_buffer *const buffers[] = {&t->units,        &t->spans,   &t->counts, &t->sums,     &t->drafts,
                                         &t->draft_places, &t->records, &t->words,  &t->vertices, &t->corners};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        clast_gpu_free(device.gpu, buffers[i]);
    }
    clast_mirror_destroy(t->mirror);
}

static clast_gpu_commands *begin(void)
{
    clast_gpu_commands *commands = NULL;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    return commands;
}

static void reserve(clast_gpu_buffer *buffer, size_t bytes)
{
    assert_ok(device.context, clast_gpu_reserve(device.gpu, CLAST_GPU_DEVICE, bytes + 16, "test", buffer));
}

// Room for drafts: none, more than is ever needed, or so little that most items find none.
static void make_room_for_drafts(twin *t, clast_gpu_commands *commands)
{
    static const uint32_t rooms[] = {0, 1 << 22, 900};
    clast_draft_head head = {0, rooms[t->draws++ % 3]};
    reserve(&t->drafts, sizeof head + rooms[1] * sizeof(uint32_t));
    reserve(&t->draft_places, t->world->unit->item_count * sizeof(uint32_t));
    clast_gpu_write(commands, &t->drafts, 0, &head, sizeof head);
    t->record.drafts = store_address(head.room != 0 ? t->drafts.address : 0);
    t->record.draft_places = store_address(t->draft_places.address);
}

// Uploads the unit as a pose and a view have it.
static void mirror_unit(twin *t, clast_gpu_commands *commands, const clast_pose *pose, const clast_source_view *view)
{
    size_t items = t->world->unit->item_count;
    t->unit.pose = *pose;
    assert_ok(device.context, clast_mirror_begin(t->mirror, 1));
    assert_ok(device.context, clast_mirror_unit(t->mirror, commands, 0, &t->unit, &t->record));
    clast_mirror_end(t->mirror);
    reserve(&t->units, sizeof t->record);
    reserve(&t->spans, 2 * sizeof(clast_device_span));
    reserve(&t->counts, items * sizeof(clast_source_count));
    reserve(&t->sums, sizeof(clast_unit_sums));
    t->record.view = *view;
    t->record.item_counts = store_address(t->counts.address);
    t->record.sums = store_address(t->sums.address);
    make_room_for_drafts(t, commands);
}

static void write_unit(twin *t, clast_gpu_commands *commands)
{
    const clast_device_span spans[2] = {{0, 0}, {t->world->unit->item_count, CLAST_NONE}};
    clast_gpu_write(commands, &t->units, 0, &t->record, sizeof t->record);
    clast_gpu_write(commands, &t->spans, 0, spans, sizeof spans);
    clast_gpu_fill(commands, &t->sums, 0, sizeof(clast_unit_sums), 0);
    clast_gpu_barrier(commands);
}

// As shaders/frame/spans.glsl has them.
typedef struct span_push {
    uint64_t units, spans, templates;
    uint32_t span_count, keep;
} span_push;

static void run_items(twin *t, clast_gpu_commands *commands, clast_shader shader)
{
    span_push push = {t->units.address, t->spans.address, 0, 1, 1};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = shader,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = t->world->unit->item_count});
}

// ------------------------------------------------------------------------------------------------------------- duties

// Counts on the device, and leaves sums over what was counted there. False where there is more than a test should do.
static bool compare_counts(twin *t, const clast_pose *pose, const clast_source_view *view)
{
    const clast_unit *unit = t->world->unit;
    clast_source_count *counts = malloc(unit->item_count * sizeof *counts);
    clast_gpu_commands *commands = begin();
    mirror_unit(t, commands, pose, view);
    write_unit(t, commands);
    run_items(t, commands, CLAST_SHADER_FRAME_COUNT_DISPLACED);
    clast_gpu_read(commands, &t->counts, 0, counts, unit->item_count * sizeof *counts);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_source_count sum = {0};
    for (uint32_t item = 0; item < unit->item_count; item++) {
        clast_source_count expected = t->world->source->count(unit, pose, view, item), before = sum;
        assert_memory_equal(&counts[item], &expected, sizeof expected);
        sum.clusters += expected.clusters;
        sum.triangles += expected.triangles;
        sum.vertices += expected.vertices;
        sum.words += expected.words;
        counts[item] = before;
    }
    commands = begin();
    clast_gpu_write(commands, &t->counts, 0, counts, unit->item_count * sizeof *counts);
    assert_ok(device.context, clast_gpu_finish(commands));
    free(counts);
    return sum.triangles <= TRIANGLES_MOST;
}

static void compare_records(twin *t, const kind_emission *all)
{
    clast_cluster_record *records = malloc(all->record_count * sizeof *records);
    uint32_t *words = malloc(all->word_count * sizeof *words);
    reserve(&t->records, all->record_count * sizeof *records);
    reserve(&t->words, all->word_count * sizeof *words);
    reserve(&t->vertices, all->vertex_count * sizeof(packed3));
    reserve(&t->corners, all->record_count * TEMPLATE_TRIANGLES * sizeof(uint32_t));
    t->record.records = store_address(t->records.address);
    t->record.words = store_address(t->words.address);
    t->record.vertices = store_address(t->vertices.address);
    clast_gpu_commands *commands = begin();
    write_unit(t, commands);
    run_items(t, commands, CLAST_SHADER_FRAME_EMIT_DISPLACED);
    clast_gpu_read(commands, &t->records, 0, records, all->record_count * sizeof *records);
    clast_gpu_read(commands, &t->words, 0, words, all->word_count * sizeof *words);
    assert_ok(device.context, clast_gpu_finish(commands));
    assert_memory_equal(records, all->records, all->record_count * sizeof *records);
    assert_memory_equal(words, all->words, all->word_count * sizeof *words);
    free(records);
    free(words);
}

static void compare_corners(const twin *t, const kind_emission *all, size_t number, const uint32_t *corners)
{
    const clast_cluster_record *record = &all->records[number];
    if (record_form(*record) != FORM_COMPOSITE) {
        return;
    }
    uint8_t expected[3 * TEMPLATE_TRIANGLES];
    t->world->source->corners(t->world->unit, record, all->words + record->first_word, expected);
    for (uint32_t i = 0; i < record_triangles(*record); i++) {
        uint32_t word = expected[3 * i] | (uint32_t)expected[3 * i + 1] << 8 | (uint32_t)expected[3 * i + 2] << 16;
        assert_int_equal(corners[TEMPLATE_TRIANGLES * number + i], word);
    }
}

// As shaders/probe/displaced.comp has them.
typedef struct probe_push {
    uint64_t unit, corners;
    uint32_t count;
} probe_push;

static void compare_vertices(twin *t, const kind_emission *all)
{
    size_t corner_bytes = all->record_count * TEMPLATE_TRIANGLES * sizeof(uint32_t);
    packed3 *vertices = malloc(all->vertex_count * sizeof *vertices);
    uint32_t *corners = malloc(corner_bytes);
    probe_push push = {t->units.address, t->corners.address, (uint32_t)all->record_count};
    clast_gpu_commands *commands = begin();
    clast_gpu_lanes lanes = clast_gpu_lanes_of(device.gpu);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_PROBE_DISPLACED,
                                              .constants = {lanes.lanes, lanes.group},
                                              .constant_count = 2,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = clast_gpu_lane_groups(lanes, all->record_count),
                                              .subgroup = lanes.lanes});
    clast_gpu_read(commands, &t->vertices, 0, vertices, all->vertex_count * sizeof *vertices);
    clast_gpu_read(commands, &t->corners, 0, corners, corner_bytes);
    assert_ok(device.context, clast_gpu_finish(commands));
    for (size_t i = 0; i < 3 * all->vertex_count; i++) {
        float is = vertices[i / 3].v[i % 3], expected = all->vertices[i / 3].v[i % 3];
        if (is != expected) { // signs of zeros may differ
            fail_msg("vertex %zu, axis %zu: %.9g, expected %.9g", i / 3, i % 3, (double)is, (double)expected);
        }
    }
    for (size_t i = 0; i < all->record_count; i++) {
        compare_corners(t, all, i, corners);
    }
    free(vertices);
    free(corners);
}

// What was seen of all there is.
typedef struct tally {
    uint64_t triangles;
    uint32_t cooked, whole, composite, split;
} tally;

static void add_records(tally *sum, const kind_emission *all)
{
    for (size_t i = 0; i < all->record_count; i++) {
        const clast_cluster_record *record = &all->records[i];
        sum->triangles += record_triangles(*record);
        sum->cooked += record->detail == 0;
        sum->whole += record->detail == 1;
        sum->composite += record_form(*record) == FORM_COMPOSITE;
        for (uint32_t leaf = 0; leaf < record->detail; leaf++) {
            sum->split += displaced_leaf_is_split(all->words[record->first_word + 1 + leaf]);
        }
    }
}

static void compare(twin *t, const clast_pose *pose, const clast_source_view *view, tally *sum)
{
    if (!compare_counts(t, pose, view)) {
        return;
    }
    kind_emission all = kind_emit(t->world, pose, view);
    add_records(sum, &all);
    compare_records(t, &all);
    compare_vertices(t, &all);
    kind_emission_free(&all);
}

static void compare_views(const kind_world *world, uint32_t views, tally *sum)
{
    twin t = twin_open(world);
    numbers random = {99};
    for (uint32_t i = 0; i < views; i++) {
        clast_source_view view = random_view(&random, i);
        compare(&t, &at_rest, &view, sum);
    }
    twin_close(&t);
}

static void assert_all_seen(const tally *sum)
{
    assert_true(sum->whole > 0 && sum->composite > 0 && sum->split > 0);
}

// -------------------------------------------------------------------------------------------------------------- tests

static void spheres_are_the_same_from_everywhere(void **state)
{
    (void)state;
    shape s = shape_sphere(12, 7);
    for (int curved = 0; curved < 2; curved++) {
        kind_world world = world_of(device.context, &s.mesh, 0.3f, curved != 0);
        tally sum = {0};
        compare_views(&world, 12, &sum);
        assert_all_seen(&sum);
        kind_close(&world);
    }
    shape_free(&s);
}

static void hard_edges_and_seams_are_the_same(void **state)
{
    (void)state;
    box_mesh box;
    box_mesh_make(&box);
    for (int i = 0; i < 4; i++) {
        box.mesh.normals = i % 2 == 0 ? box.normals[0] : NULL;
        kind_world world = world_of(device.context, &box.mesh, 0.4f, i >= 2);
        tally sum = {0};
        compare_views(&world, 8, &sum);
        assert_all_seen(&sum);
        kind_close(&world);
    }
}

static void triangles_that_share_nothing_but_positions_are_the_same(void **state)
{
    (void)state;
    shape s = shape_sphere(10, 8);
    for (int i = 0; i < 2; i++) {
        loose l = loosen(&s.mesh, i == 0);
        kind_world world = world_of(device.context, &l.mesh, 0.3f, i == 1);
        tally sum = {0};
        compare_views(&world, 12, &sum);
        assert_all_seen(&sum);
        kind_close(&world);
        loose_free(&l);
    }
    shape_free(&s);
}

// Its foot has few segments, its sides are split again and again, so that lists are written over and made anew.
static void spikes_that_are_split_many_times_are_the_same(void **state)
{
    (void)state;
    clast_mesh mesh = spike_mesh(broad_spike);
    kind_world world = world_of(device.context, &mesh, 0.5f, false);
    clast_source_view view = view_from(vec3(0, 0, 20), vec3(0, 0, 0), 100.0f);
    view.metric = CLAST_METRIC_LENGTH;
    twin t = twin_open(&world);
    tally sum = {0};
    for (float segment = 8.0f; segment > 0.2f; segment *= 0.6f) {
        view.segment = segment;
        compare(&t, &at_rest, &view, &sum);
    }
    assert_all_seen(&sum);
    view.metric = CLAST_METRIC_FIXED;
    view.segment = 100.0f;
    sum = (tally){0};
    compare(&t, &at_rest, &view, &sum);
    assert_true(sum.triangles > 4 * 100 * 100 / 2);
    twin_close(&t);
    kind_close(&world);
}

// Thousands of segments an edge, four splits deep.
static void needles_are_the_same(void **state)
{
    (void)state;
    clast_mesh mesh = spike_mesh(needle);
    kind_world world = world_of(device.context, &mesh, 0.001f, false);
    clast_source_view view = view_from(vec3(0, 0, 20), vec3(0, 0, 0), 100.0f);
    view.metric = CLAST_METRIC_LENGTH;
    twin t = twin_open(&world);
    tally sum = {0};
    for (float segment = 0.1f; segment > 0.015f; segment *= 0.5f) {
        view.segment = segment;
        compare(&t, &at_rest, &view, &sum);
    }
    assert_true(sum.triangles > 50000);
    twin_close(&t);
    kind_close(&world);
}

// As budgets ask for them.
static void every_rate_gives_the_same(void **state)
{
    (void)state;
    shape s = shape_sphere(24, 16);
    kind_world world = world_of(device.context, &s.mesh, 0.3f, false);
    clast_source_view view = view_from(vec3(0.2f, 0.4f, 2.1f), vec3(0, 0, 0), 300.0f);
    twin t = twin_open(&world);
    tally sum = {0};
    for (uint32_t step = 0; step <= 128; step += 8) {
        view.rate = step < 128 ? exp2f(-(float)step / RATE_STEPS) : CLAST_RATE_LEAST;
        compare(&t, &at_rest, &view, &sum);
    }
    assert_true(sum.cooked > 0 && sum.whole > 0 && sum.composite > 0);
    twin_close(&t);
    kind_close(&world);
    shape_free(&s);
}

static void meshes_that_move_are_the_same(void **state)
{
    (void)state;
    shape s = shape_sphere(10, 6);
    loose l = loosen(&s.mesh, true);
    numbers random = {5};
    packed3 *positions = malloc(l.mesh.vertex_count * sizeof *positions);
    packed3 *normals = malloc(l.mesh.vertex_count * sizeof *normals);
    for (int with_normals = 0; with_normals < 2; with_normals++) {
        l.mesh.normals = with_normals != 0 ? l.normals : NULL;
        kind_world world = world_of(device.context, &l.mesh, 0.3f, with_normals == 0);
        twin t = twin_open(&world);
        tally sum = {0};
        for (uint32_t pose = 1; pose <= 4; pose++) {
            for (uint32_t i = 0; i < l.mesh.vertex_count; i++) {
                for (uint32_t axis = 0; axis < 3; axis++) {
                    positions[i].v[axis] = l.positions[3 * i + axis] + 0.1f * (float)pose * next_number(&random);
                    normals[i].v[axis] = next_number(&random);
                }
            }
            clast_pose moved = {
                .shape = pose,
                .positions = pose != 3 ? positions : NULL,
                .normals = pose % 2 == 0 && with_normals != 0 ? normals : NULL,
                .displacement_scale = -0.5f * (float)pose,
            };
            clast_source_view view = random_view(&random, pose);
            compare(&t, &moved, &view, &sum);
        }
        compare_views(&world, 3, &sum); // and at rest again
        assert_all_seen(&sum);
        twin_close(&t);
        kind_close(&world);
    }
    free(positions);
    free(normals);
    loose_free(&l);
    shape_free(&s);
}

// Heights of every type, in the second set of coordinates too, by every way of wrapping.
static void maps_of_every_form_are_the_same(void **state)
{
    (void)state;
    enum { SIDE = 13 };
    float values[SIDE * SIDE];
    shape s = shape_sphere(16, 9);
    float *coordinates = malloc(s.mesh.vertex_count * 8);
    memcpy(coordinates, s.mesh.coordinates[0], s.mesh.vertex_count * 8);
    s.mesh.coordinates[1] = coordinates;
    for (uint32_t i = 0; i < 9; i++) {
        numbers random = {i};
        for (uint32_t k = 0; k < SIDE * SIDE; k++) {
            float value = 0.5f + 0.5f * next_number(&random);
            switch ((clast_pixel_type)(i % 3)) {
            case CLAST_PIXEL_UNORM8: ((uint8_t *)values)[k] = (uint8_t)(255.0f * value); break;
            case CLAST_PIXEL_UNORM16: ((uint16_t *)values)[k] = (uint16_t)(65535.0f * value); break;
            case CLAST_PIXEL_FLOAT: values[k] = value; break;
            }
        }
        kind_world world = {.context = device.context, .source = clast_sources[CLAST_SOURCE_DISPLACED]};
        assert_ok(device.context, clast_scene_create(device.context, &world.scene));
        assert_ok(device.context, clast_template_set_create(device.context, &world.templates));
        assert_ok(device.context, clast_height_store_create(device.context, &world.heights));
        clast_image image = {SIDE, SIDE, 1, (clast_pixel_type)(i % 3), values};
        clast_texture texture = {0, (clast_wrap)(i / 3), (clast_wrap)((i + 1) % 3), CLAST_FILTER_LINEAR};
        clast_material_desc desc = clast_material_defaults();
        uint32_t geometry, number;
        assert_ok(device.context, clast_scene_add_image(world.scene, &image, NULL, &texture.image));
        assert_ok(device.context, clast_scene_add_texture(world.scene, &texture, &number));
        desc.displacement_texture = (clast_texture_slot){.texture = number,
                                                         .coordinate_set = i & 1,
                                                         .scale = {2.5f, -1.5f},
                                                         .offset = {0.3f, -0.7f},
                                                         .rotation = 0.4f};
        desc.displacement_scale = 0.2f;
        desc.displacement_offset = 0.01f;
        assert_ok(device.context, clast_scene_add_mesh(world.scene, &s.mesh, "mesh", &geometry));
        assert_ok(device.context, clast_scene_set_material(world.scene, 0, &desc));
        assert_ok(device.context, clast_scene_set_tessellation(world.scene, geometry, &(clast_tessellation){false}));
        kind_cook(&world, geometry);
        tally sum = {0};
        compare_views(&world, 3, &sum);
        assert_true(sum.triangles > 0);
        kind_close(&world);
    }
    free(coordinates);
    shape_free(&s);
}

// Texture coordinates that no map has anything for.
static void coordinates_beyond_all_reason_are_the_same(void **state)
{
    (void)state;
    shape s = shape_sphere(10, 8);
    loose l = loosen(&s.mesh, true);
    const float strange[] = {3e38f, -3e38f, 1e30f, INFINITY, -INFINITY, NAN};
    for (uint32_t i = 0; i < 2 * l.mesh.vertex_count; i += 7) {
        l.coordinates[i] = strange[i % (sizeof strange / sizeof *strange)];
    }
    kind_world world = world_of(device.context, &l.mesh, 0.3f, false);
    tally sum = {0};
    compare_views(&world, 6, &sum);
    assert_true(sum.triangles > 0);
    kind_close(&world);
    loose_free(&l);
    shape_free(&s);
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_are_the_same_from_everywhere),
        cmocka_unit_test(hard_edges_and_seams_are_the_same),
        cmocka_unit_test(triangles_that_share_nothing_but_positions_are_the_same),
        cmocka_unit_test(spikes_that_are_split_many_times_are_the_same),
        cmocka_unit_test(needles_are_the_same),
        cmocka_unit_test(every_rate_gives_the_same),
        cmocka_unit_test(meshes_that_move_are_the_same),
        cmocka_unit_test(maps_of_every_form_are_the_same),
        cmocka_unit_test(coordinates_beyond_all_reason_are_the_same),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) && failed == 0 ? 0 : 1;
}
