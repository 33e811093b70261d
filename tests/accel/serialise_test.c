// SPDX-License-Identifier: Apache-2.0
// Stored BLASes: what was written is hit as before, wherever it lies; what was not written is refused, or does no harm.
#include "test.h"

#include "accel/meshes.h"
#include "accel/stored.h"

enum { RAYS = 2000, FLIP_RAYS = 5 };

typedef struct block {
    uint8_t *bytes; // aligned, and as long as it says, so that sanitizers see what is read beyond
    size_t size;
} block;

static block block_of(size_t size)
{
    block b = {NULL, size};
    assert_int_equal(posix_memalign((void **)&b.bytes, 64, size != 0 ? size : 1), 0);
    return b;
}

static block store(clast_context *context, const clast_blas *blas)
{
    uint64_t size;
    assert_ok(context, clast_blas_serialise(blas, NULL, 0, &size));
    block b = block_of((size_t)size);
    assert_ok(context, clast_blas_serialise(blas, b.bytes, b.size, &size));
    assert_int_equal(size, b.size);
    return b;
}

static block copy_of(const block *from, size_t size)
{
    block b = block_of(size);
    memcpy(b.bytes, from->bytes, size < from->size ? size : from->size);
    return b;
}

static clast_tlas *tlas_over(clast_context *context, const clast_blas *blas)
{
    clast_tlas *tlas;
    clast_tlas_instance instances[2] = {instance_of(blas, 0), instance_of(blas, 1)};
    instances[1].transform[0][3] = 0.5f;
    assert_ok(context, clast_tlas_create(context, &tlas));
    assert_ok(context, clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST));
    return tlas;
}

static clast_ray random_ray(randoms *r)
{
    return (clast_ray){{random_between(r, -2, 2), random_between(r, -2, 2), random_between(r, -2, 2)},
                       0,
                       {random_between(r, -1, 1), random_between(r, -1, 1), random_between(r, -1, 1)},
                       INFINITY};
}

// `slots`: which of the first one's clusters the second one's are; null where they are the same.
static void assert_same_hits(clast_context *context, const clast_blas *first, const clast_blas *second,
                             const uint32_t *slots)
{
    clast_tlas *a = tlas_over(context, first), *b = tlas_over(context, second);
    randoms r = {1};
    uint32_t hits = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray ray = random_ray(&r);
        clast_hit hit[2];
        uint8_t any[2];
        memset(hit, 0, sizeof hit);
        clast_trace_closest(a, &ray, 1, NULL, &hit[0]);
        clast_trace_closest(b, &ray, 1, NULL, &hit[1]);
        clast_trace_any(a, &ray, 1, NULL, &any[0]);
        clast_trace_any(b, &ray, 1, NULL, &any[1]);
        assert_int_equal(any[0], any[1]);
        assert_int_equal(hit[0].instance, hit[1].instance);
        assert_int_equal(hit[0].steps, hit[1].steps);
        if (hit[0].instance != CLAST_NONE) {
            hit[1].cluster = slots != NULL ? slots[hit[1].cluster] : hit[1].cluster;
            assert_memory_equal(&hit[0], &hit[1], sizeof hit[0]);
            hits++;
        }
    }
    assert_true(hits > RAYS / 200);
    clast_tlas_destroy(a);
    clast_tlas_destroy(b);
}

static void assert_round_trip(clast_context *context, const clast_blas *blas, const uint32_t *slots)
{
    block b = store(context, blas), moved = copy_of(&b, b.size);
    memset(b.bytes, 0x55, b.size); // nothing may point back
    clast_blas *mapped;
    assert_ok(context, clast_blas_map(context, moved.bytes, moved.size, true, &mapped));
    assert_same_hits(context, blas, mapped, slots);
    float bounds[4][3];
    clast_blas_bounds(blas, bounds[0], bounds[1]);
    clast_blas_bounds(mapped, bounds[2], bounds[3]);
    assert_memory_equal(bounds[0], bounds[2], sizeof bounds / 2);
    clast_blas_destroy(mapped);
    free(b.bytes);
    free(moved.bytes);
}

static void stored_meshes_are_hit_as_before(void **state)
{
    clast_context *context = *state;
    mesh meshes[] = {mesh_octasphere(4), mesh_torus(40, 20, 1.0f, 0.3f), mesh_soup(3000, 0.1f, 5)};
    for (uint32_t i = 0; i < 3; i++) {
        clustered c;
        assert_ok(context, clustered_make(context, &meshes[i], i == 1 ? 256 : 64, &c));
        assert_round_trip(context, c.blas, NULL);
        clustered_free(&c);
        mesh_free(&meshes[i]);
    }
}

static void clusters_of_a_part_of_a_pool_are_numbered_anew(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_soup(3000, 0.2f, 5);
    clustered c;
    assert_ok(context, clustered_make(context, &m, 32, &c));
    uint32_t backwards[40], ascending[40];
    for (uint32_t i = 0; i < 40; i++) {
        ascending[i] = 2 * i + 1;
        backwards[39 - i] = ascending[i];
    }
    assert_ok(context, clast_blas_build(c.blas, backwards, 40, CLAST_BUILD_BEST));
    assert_round_trip(context, c.blas, ascending);
    clustered_free(&c);
    mesh_free(&m);
}

static void grids_store_their_template_once(void **state)
{
    clast_context *context = *state;
    enum { GRIDS = 64 };
    static float vertices[GRIDS][81][3];
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_clas_input inputs[GRIDS];
    uint32_t number;
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_template_set_add_grid(set, 8, 8, &number));
    assert_ok(context, clast_clas_pool_create(set, &pool));
    assert_ok(context, clast_blas_create(pool, &blas));
    for (uint32_t i = 0; i < GRIDS; i++) {
        for (uint32_t k = 0; k < 81; k++) {
            const float p[3] = {(float)(i % 8) + (float)(k % 9) / 8.0f, (float)(i / 8) + (float)(k / 9) / 8.0f,
                                0.1f * sinf((float)(i + k))};
            for (int axis = 0; axis < 3; axis++) {
                vertices[i][k][axis] = 0.5f * p[axis] - 2.0f * (axis != 2);
            }
        }
        inputs[i] = (clast_clas_input){number, vertices[i][0]};
    }
    assert_ok(context, clast_clas_instantiate(pool, 0, GRIDS, inputs));
    assert_ok(context, clast_blas_build(blas, NULL, GRIDS, CLAST_BUILD_BEST));
    assert_round_trip(context, blas, NULL);
    block b = store(context, blas);
    stored_header *header = (void *)b.bytes;
    assert_int_equal(header->topology_bytes, sizeof(clast_template) + 16 * sizeof(clast_block));
    free(b.bytes);
    clast_blas_destroy(blas);
    clast_clas_pool_destroy(pool);
    clast_template_set_destroy(set);
}

static void the_same_tree_gives_the_same_bytes(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(30, 20, 1.0f, 0.3f);
    clustered c[2];
    block b[2];
    for (int i = 0; i < 2; i++) {
        assert_ok(context, clustered_make(context, &m, 64, &c[i])); // elsewhere in memory
        b[i] = store(context, c[i].blas);
    }
    assert_int_equal(b[0].size, b[1].size);
    assert_memory_equal(b[0].bytes, b[1].bytes, b[0].size);
    clast_blas *mapped;
    assert_ok(context, clast_blas_map(context, b[0].bytes, b[0].size, true, &mapped));
    block again = store(context, mapped);
    assert_int_equal(again.size, b[0].size);
    assert_memory_equal(again.bytes, b[0].bytes, again.size);
    clast_blas_destroy(mapped);
    free(again.bytes);
    for (int i = 0; i < 2; i++) {
        free(b[i].bytes);
        clustered_free(&c[i]);
    }
    mesh_free(&m);
}

static void what_has_nothing_to_hit_is_stored_too(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_terrain(8, 0.2f, 1);
    clustered c;
    assert_ok(context, clustered_make(context, &m, 16, &c));
    for (uint32_t i = 0; i < c.vertex_count; i++) {
        c.vertices[3 * i] = i < c.vertex_count / 2 ? NAN : c.vertices[3 * i];
    }
    assert_ok(context, clast_clas_refit(c.pool, 0, c.cluster_count));
    assert_ok(context, clast_blas_refit(c.blas));
    assert_round_trip(context, c.blas, NULL);
    for (uint32_t i = 0; i < c.vertex_count; i++) {
        c.vertices[3 * i] = NAN;
    }
    assert_ok(context, clast_clas_refit(c.pool, 0, c.cluster_count));
    for (int empty = 0; empty < 2; empty++) {
        assert_ok(context, clast_blas_build(c.blas, NULL, empty ? 0 : c.cluster_count, CLAST_BUILD_BEST));
        block b = store(context, c.blas);
        clast_blas *mapped;
        assert_ok(context, clast_blas_map(context, b.bytes, b.size, true, &mapped));
        clast_tlas *tlas = tlas_over(context, mapped);
        clast_ray ray = {{0.3f, 0.3f, 2}, 0, {0, 0, -1}, INFINITY};
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, CLAST_NONE);
        clast_tlas_destroy(tlas);
        clast_blas_destroy(mapped);
        free(b.bytes);
    }
    clustered_free(&c);
    mesh_free(&m);
}

static void mapped_trees_are_only_read(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(2);
    clustered c;
    assert_ok(context, clustered_make(context, &m, 64, &c));
    block b = store(context, c.blas), before = copy_of(&b, b.size);
    clast_blas *mapped;
    assert_ok(context, clast_blas_map(context, b.bytes, b.size, false, &mapped));
    assert_int_equal(clast_blas_build(mapped, NULL, 1, CLAST_BUILD_BEST), CLAST_ERROR_STATE);
    assert_int_equal(clast_blas_refit(mapped), CLAST_ERROR_STATE);
    assert_int_equal(clast_blas_reserve(mapped, 10), CLAST_ERROR_STATE);
    assert_int_equal(clast_blas_use_memory(mapped, NULL, 0), CLAST_ERROR_STATE);
    assert_true(clast_blas_bytes(mapped) > b.size);
    assert_memory_equal(b.bytes, before.bytes, b.size);
    clast_blas_destroy(mapped);
    free(b.bytes);
    free(before.bytes);
    clustered_free(&c);
    mesh_free(&m);
}

static void memory_must_be_aligned_and_large_enough(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(1);
    clustered c;
    assert_ok(context, clustered_make(context, &m, 64, &c));
    block b = store(context, c.blas), room = block_of(b.size + 64);
    clast_blas *mapped;
    uint64_t size;
    assert_int_equal(clast_blas_serialise(c.blas, room.bytes, b.size - 1, &size), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_blas_serialise(c.blas, room.bytes + 4, b.size, &size), CLAST_ERROR_INVALID_ARGUMENT);
    memcpy(room.bytes + 4, b.bytes, b.size);
    assert_int_equal(clast_blas_map(context, room.bytes + 4, b.size, true, &mapped), CLAST_ERROR_INVALID_ARGUMENT);
    free(b.bytes);
    free(room.bytes);
    clustered_free(&c);
    mesh_free(&m);
}

// ------------------------------------------------------------------------------------------------------- hostile blocks

// Several levels, several clusters, two templates.
static block small_block(clast_context *context)
{
    mesh m = mesh_soup(50, 0.5f, 3);
    clustered c;
    assert_ok(context, clustered_make(context, &m, 2, &c));
    block b = store(context, c.blas);
    clustered_free(&c);
    mesh_free(&m);
    return b;
}

// A context for each instruction set that there is: what reads a block differs.
typedef struct readers {
    clast_context *contexts[8];
    uint32_t count;
} readers;

static readers readers_make(void)
{
    readers all = {.count = 0};
#define MAKE(name, value, text) \
    if (clast_context_create(&(clast_context_desc){.isa = name, .threads = 1}, &all.contexts[all.count]) == \
        CLAST_OK) { \
        all.count++; \
    }
    CLAST_ISA_LIST(MAKE)
#undef MAKE
    assert_true(all.count > 0);
    return all;
}

static void readers_free(readers *all)
{
    for (uint32_t i = 0; i < all->count; i++) {
        clast_context_destroy(all->contexts[i]);
    }
}

static void use(clast_context *context, const clast_blas *blas)
{
    clast_tlas *tlas = tlas_over(context, blas);
    randoms r = {7};
    for (uint32_t i = 0; i < FLIP_RAYS; i++) {
        clast_ray ray = random_ray(&r);
        clast_hit hit;
        uint8_t any;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        clast_trace_any(tlas, &ray, 1, NULL, &any);
    }
    clast_tlas_destroy(tlas);
}

static void changed_bytes_are_refused_or_harmless(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    readers all = readers_make();
    const uint8_t flips[] = {0x01, 0x40, 0xff};
    uint32_t refused = 0, used = 0;
    for (size_t i = 0; i < b.size; i++) {
        for (size_t k = 0; k < sizeof flips; k++) {
            clast_blas *mapped;
            b.bytes[i] ^= flips[k];
            assert_int_not_equal(clast_blas_map(context, b.bytes, b.size, true, &mapped), CLAST_OK);
            if (clast_blas_map(context, b.bytes, b.size, false, &mapped) == CLAST_OK) {
                use(all.contexts[used++ % all.count], mapped);
                clast_blas_destroy(mapped);
            } else {
                refused++;
            }
            b.bytes[i] ^= flips[k];
        }
    }
    assert_true(refused > 0 && used > 0);
    readers_free(&all);
    free(b.bytes);
}

static void random_changes_are_refused_or_harmless(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    readers all = readers_make();
    randoms r = {11};
    for (uint32_t i = 0; i < 4000; i++) {
        block changed = copy_of(&b, b.size);
        uint32_t count = 1 + random_below(&r, 4);
        for (uint32_t k = 0; k < count; k++) {
            const uint32_t values[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, random_bits(&r)};
            size_t at = random_below(&r, (uint32_t)b.size / 4) * (size_t)4;
            memcpy(changed.bytes + at, &values[random_below(&r, 6)], 4);
        }
        clast_blas *mapped;
        if (clast_blas_map(context, changed.bytes, changed.size, false, &mapped) == CLAST_OK) {
            use(all.contexts[i % all.count], mapped);
            clast_blas_destroy(mapped);
        }
        free(changed.bytes);
    }
    readers_free(&all);
    free(b.bytes);
}

static void every_shorter_block_is_refused(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    for (size_t size = 0; size < b.size; size++) {
        block shorter = copy_of(&b, size);
        clast_blas *mapped;
        assert_int_equal(clast_blas_map(context, shorter.bytes, size, false, &mapped), CLAST_ERROR_MALFORMED);
        if (size >= sizeof(stored_header)) { // one that says so itself
            stored_header *header = (void *)shorter.bytes;
            header->bytes = size;
            assert_int_equal(clast_blas_map(context, shorter.bytes, size, false, &mapped), CLAST_ERROR_MALFORMED);
        }
        free(shorter.bytes);
    }
    block longer = copy_of(&b, b.size + 64);
    clast_blas *mapped;
    assert_int_equal(clast_blas_map(context, longer.bytes, longer.size, false, &mapped), CLAST_ERROR_MALFORMED);
    free(longer.bytes);
    free(b.bytes);
}

static void assert_refused(clast_context *context, block *b, clast_status status)
{
    clast_blas *mapped;
    assert_int_equal(clast_blas_map(context, b->bytes, b->size, false, &mapped), status);
    free(b->bytes);
}

static clast_node *nodes_of(block *b)
{
    return (clast_node *)(void *)(b->bytes + stored_layout_of((stored_header *)(void *)b->bytes).nodes);
}

static clast_clas *cluster_of(block *b, uint32_t number)
{
    const stored_header *header = (void *)b->bytes;
    return (clast_clas *)(void *)(b->bytes + stored_layout_of(header).slots + number * header->stride);
}

static void cycles_and_shared_nodes_are_refused(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    assert_true(((stored_header *)(void *)b.bytes)->node_count >= 3);
    uint32_t last = ((stored_header *)(void *)b.bytes)->node_count - 1;
    const uint32_t children[][2] = {{0, 0}, {0, 1u << 20}, {last, last}, {last, 0}, {0, CLAST_CHILD_ITEM | 1u << 20}};
    for (size_t i = 0; i < sizeof children / sizeof children[0]; i++) {
        block changed = copy_of(&b, b.size);
        nodes_of(&changed)[children[i][0]].children[0] = children[i][1];
        assert_refused(context, &changed, CLAST_ERROR_MALFORMED);
    }
    block shared = copy_of(&b, b.size);
    clast_node *root = nodes_of(&shared);
    uint32_t second = 0;
    for (uint32_t i = 0; i < root->child_count; i++) { // two ways to one node
        second = root->children[i] == 2 ? i : second;
    }
    root->children[second] = 1;
    assert_refused(context, &shared, CLAST_ERROR_MALFORMED);
    block wide = copy_of(&b, b.size);
    nodes_of(&wide)->child_count = 9;
    assert_refused(context, &wide, CLAST_ERROR_MALFORMED);
    free(b.bytes);
}

// A chain of nodes, each with one child: as large as a block of so many nodes must be.
static block chain_of(uint32_t count)
{
    stored_header header = {.version = STORED_VERSION,
                            .order = STORED_ORDER,
                            .node_count = count,
                            .slot_count = 1,
                            .stride = 128,
                            .box = {{{0, 0, 0}}, {{1, 1, 1}}}};
    memcpy(header.magic, STORED_MAGIC, sizeof STORED_MAGIC);
    header.bytes = stored_layout_of(&header).end;
    block b = block_of((size_t)header.bytes);
    memset(b.bytes, 0, b.size);
    memcpy(b.bytes, &header, sizeof header);
    for (uint32_t i = 0; i < count; i++) {
        clast_node *node = &nodes_of(&b)[i];
        memset(node->exponents, 127 - 7, 3);
        memset(node->boxes[0][1], 255, 8);
        node->child_count = 1;
        node->children[0] = i + 1 < count ? i + 1 : CLAST_CHILD_ITEM;
    }
    return b;
}

static void trees_deeper_than_a_stack_are_refused(void **state)
{
    clast_context *context = *state;
    block b = chain_of(TREE_DEPTH);
    clast_blas *mapped;
    assert_ok(context, clast_blas_map(context, b.bytes, b.size, false, &mapped));
    use(context, mapped);
    clast_blas_destroy(mapped);
    free(b.bytes);
    b = chain_of(TREE_DEPTH + 1);
    assert_refused(context, &b, CLAST_ERROR_MALFORMED);
}

static void clusters_must_lie_in_the_block(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    const int64_t distances[] = {-64, 2, INT64_MAX, INT64_MIN, (int64_t)b.size, 1 << 20};
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        block topology = copy_of(&b, b.size), vertices = copy_of(&b, b.size);
        cluster_of(&topology, 1)->topology = distances[i];
        assert_refused(context, &topology, CLAST_ERROR_MALFORMED);
        cluster_of(&vertices, 1)->vertices = distances[i];
        assert_refused(context, &vertices, CLAST_ERROR_MALFORMED);
    }
    block last = copy_of(&b, b.size); // one vertex less than the last cluster has
    stored_header *header = (void *)last.bytes;
    cluster_of(&last, header->slot_count - 1)->vertices += 12;
    assert_refused(context, &last, CLAST_ERROR_MALFORMED);
    free(b.bytes);
}

static void other_versions_and_machines_are_told_apart(void **state)
{
    clast_context *context = *state;
    block b = small_block(context);
    block version = copy_of(&b, b.size), order = copy_of(&b, b.size), kind = copy_of(&b, b.size);
    ((stored_header *)(void *)version.bytes)->version = STORED_VERSION + 1;
    assert_refused(context, &version, CLAST_ERROR_UNSUPPORTED);
    ((stored_header *)(void *)order.bytes)->order = 0x04030201;
    assert_refused(context, &order, CLAST_ERROR_UNSUPPORTED);
    kind.bytes[0] = 'x';
    assert_refused(context, &kind, CLAST_ERROR_MALFORMED);
    free(b.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(stored_meshes_are_hit_as_before),
        CONTEXT_TEST(clusters_of_a_part_of_a_pool_are_numbered_anew),
        CONTEXT_TEST(grids_store_their_template_once),
        CONTEXT_TEST(the_same_tree_gives_the_same_bytes),
        CONTEXT_TEST(what_has_nothing_to_hit_is_stored_too),
        CONTEXT_TEST(mapped_trees_are_only_read),
        CONTEXT_TEST(memory_must_be_aligned_and_large_enough),
        CONTEXT_TEST(changed_bytes_are_refused_or_harmless),
        CONTEXT_TEST(random_changes_are_refused_or_harmless),
        CONTEXT_TEST(every_shorter_block_is_refused),
        CONTEXT_TEST(cycles_and_shared_nodes_are_refused),
        CONTEXT_TEST(trees_deeper_than_a_stack_are_refused),
        CONTEXT_TEST(clusters_must_lie_in_the_block),
        CONTEXT_TEST(other_versions_and_machines_are_told_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
