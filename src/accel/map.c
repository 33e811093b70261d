// SPDX-License-Identifier: Apache-2.0
// Uses a block that clast_blas_serialise wrote (stored.h) where it lies. All that could lead a ray out of the block, or keep it
// from coming to an end, is checked here once, so that rays need not: the block may be a file from anywhere.
#include <float.h>
#include <string.h>

#include "accel/stored.h"
#include "base/size.h"
#include "shared/box.h"

// The BLAS of a block, and the pool that it needs. Both are only read.
typedef struct mapped_blas {
    clast_blas blas; // first: it is what the caller has
    clast_clas_pool pool;
} mapped_blas;

typedef struct reader {
    clast_context *context;
    const uint8_t *memory;
    const stored_header *header;
    stored_layout layout;
} reader;

#define REFUSE(r, ...) clast_fail((r)->context, CLAST_ERROR_MALFORMED, "stored BLAS: " __VA_ARGS__)

static bool is_finite_corner(const float v[3])
{
    for (int axis = 0; axis < 3; axis++) {
        if (!(v[axis] <= BOX_COORDINATE_MOST && v[axis] >= -BOX_COORDINATE_MOST)) {
            return false;
        }
    }
    return true;
}

// What quantised boxes are based on.
static bool is_sound_base(const float lower[3], const uint8_t exponents[3])
{
    bool sound = is_finite_corner(lower);
    for (int axis = 0; axis < 3; axis++) {
        sound &= exponents[axis] >= BOX_STEP_LEAST && exponents[axis] < 255;
    }
    return sound;
}

static bool is_sound_box(const clast_box *box)
{
    bool sound = is_finite_corner(box->lower.v) && is_finite_corner(box->upper.v);
    for (int axis = 0; axis < 3; axis++) {
        sound &= box->lower.v[axis] <= box->upper.v[axis];
    }
    return sound || box->lower.v[0] > box->upper.v[0];
}

// -------------------------------------------------------------------------------------------------------------- header

static clast_status check_kind(const reader *r, size_t size)
{
    const stored_header *header = r->header;
    if (size < sizeof *header) {
        return REFUSE(r, "%zu bytes; the header alone has %zu", size, sizeof *header);
    }
    if (memcmp(header->magic, STORED_MAGIC, sizeof STORED_MAGIC) != 0) {
        return REFUSE(r, "does not begin as one");
    }
    if (header->order != STORED_ORDER) {
        return clast_fail(r->context, CLAST_ERROR_UNSUPPORTED,
                          "stored BLAS: written by a machine with another order of bytes");
    }
    if (header->version != STORED_VERSION) {
        return clast_fail(r->context, CLAST_ERROR_UNSUPPORTED, "stored BLAS: version %u, expected %d", header->version,
                          STORED_VERSION);
    }
    if (header->bytes != size) {
        return REFUSE(r, "%zu bytes; it has %llu", size, (unsigned long long)header->bytes);
    }
    return CLAST_OK;
}

static clast_status check_header(reader *r, size_t size)
{
    clast_status status = check_kind(r, size);
    if (status != CLAST_OK) {
        return status;
    }
    const stored_header *header = r->header;
    size_t groups = (TEMPLATE_BLOCKS + CLUSTER_WIDTH - 1) / CLUSTER_WIDTH;
    uint64_t most = stored_align(sizeof(clast_clas) + groups * sizeof(((clast_clas *)0)->groups[0]));
    if (header->stride < sizeof(clast_clas) || header->stride > most || header->stride % STORED_ALIGNMENT != 0) {
        return REFUSE(r, "clusters of %llu bytes", (unsigned long long)header->stride);
    }
    if (header->node_count >= CLAST_CHILD_ITEM || header->slot_count >= CLAST_CHILD_ITEM ||
        header->topology_bytes > size || header->vertex_bytes > size) {
        return REFUSE(r, "has more parts than its %zu bytes hold", size);
    }
    r->layout = stored_layout_of(header);
    if (r->layout.end != size) {
        return REFUSE(r, "%zu bytes; its parts have %llu", size, (unsigned long long)r->layout.end);
    }
    if (header->node_count != 0 && !is_sound_box(&header->box)) {
        return REFUSE(r, "a box that is none");
    }
    for (size_t i = 0; i < sizeof header->zeros; i++) {
        if (header->zeros[i] != 0) {
            return REFUSE(r, "byte %zu of the header is not zero", offsetof(stored_header, zeros) + i);
        }
    }
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------------- nodes

// Nodes must be numbered as they are found level by level: then each is the child of one node before it, there is no cycle,
// no node that is met twice, and the levels tell how high a stack grows.
static clast_status check_nodes(const reader *r, clast_tree *tree)
{
    const clast_node *nodes = (const clast_node *)(const void *)(r->memory + r->layout.nodes);
    uint32_t count = r->header->node_count, found = count != 0 ? 1 : 0, level_end = 0;
    for (uint32_t i = 0; i < found; i++) {
        const clast_node *node = &nodes[i];
        if (i == level_end) {
            if (tree->level_count == TREE_DEPTH) {
                return REFUSE(r, "a tree of more than %d levels", TREE_DEPTH);
            }
            tree->levels[tree->level_count++] = i;
            level_end = found;
        }
        if (node->child_count < 1 || node->child_count > TREE_WIDTH || !is_sound_base(node->lower, node->exponents)) {
            return REFUSE(r, "node %u has %u children, or boxes that are none", i, node->child_count);
        }
        for (uint32_t k = 0; k < node->child_count; k++) {
            uint32_t child = node->children[k];
            if ((child & CLAST_CHILD_ITEM) != 0 ? (child & ~CLAST_CHILD_ITEM) >= r->header->slot_count
                                                : child != found || found++ >= count) {
                return REFUSE(r, "node %u has the child %u", i, child);
            }
        }
    }
    tree->levels[tree->level_count] = count;
    return found == count ? CLAST_OK : REFUSE(r, "%u nodes, of which %u are in the tree", count, found);
}

// ------------------------------------------------------------------------------------------------------------ clusters

// Where in the block something lies that a cluster tells the distance of; false where it is not within [begin, end).
static bool resolve(const reader *r, const clast_clas *clas, int64_t distance, uint64_t begin, uint64_t end,
                    uint64_t alignment, uint64_t *place)
{
    // Unsigned: wraps instead of overflowing, and what is out of range is out of range.
    *place = (uint64_t)((const uint8_t *)clas - r->memory) + (uint64_t)distance;
    return *place >= begin && *place < end && *place % alignment == 0;
}

static bool is_sound_topology(const reader *r, uint64_t place)
{
    uint64_t room = r->layout.topologies + r->header->topology_bytes - place;
    if (room < sizeof(clast_template)) {
        return false;
    }
    const clast_template *topology = (const clast_template *)(const void *)(r->memory + place);
    uint32_t triangles = topology->triangle_count, vertices = topology->vertex_count;
    if (triangles < 1 || triangles > TEMPLATE_TRIANGLES || vertices < 1 || vertices > TEMPLATE_VERTICES ||
        topology->block_count != clast_blocks_of(triangles) || room < stored_template_bytes(topology)) {
        return false;
    }
    for (uint32_t i = 0; i < topology->block_count; i++) {
        const clast_block *block = &topology->blocks[i];
        for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
            if (block->triangles[lane] >= triangles || block->corners[0][lane] >= vertices ||
                block->corners[1][lane] >= vertices || block->corners[2][lane] >= vertices) {
                return false;
            }
        }
    }
    return true;
}

static clast_status check_cluster(const reader *r, uint32_t number)
{
    const stored_header *header = r->header;
    const clast_clas *clas = (const clast_clas *)(const void *)(r->memory + r->layout.slots + number * header->stride);
    if (clas->topology == 0) {
        return clas->block_count == 0 && clas->vertices == 0 ? CLAST_OK
                                                             : REFUSE(r, "cluster %u has no topology", number);
    }
    uint64_t place, vertices;
    if (!resolve(r, clas, clas->topology, r->layout.topologies, r->layout.topologies + header->topology_bytes,
                 _Alignof(clast_template), &place) ||
        !is_sound_topology(r, place)) {
        return REFUSE(r, "cluster %u has a topology that is none", number);
    }
    const clast_template *topology = (const clast_template *)(const void *)(r->memory + place);
    uint64_t vertices_end = r->layout.vertices + header->vertex_bytes;
    if (!resolve(r, clas, clas->vertices, r->layout.vertices, vertices_end, _Alignof(float), &vertices) ||
        vertices_end - vertices < stored_vertex_bytes(topology)) {
        return REFUSE(r, "cluster %u has vertices outside the block", number);
    }
    size_t groups = (clas->block_count + CLUSTER_WIDTH - 1) / CLUSTER_WIDTH;
    if (clas->block_count != 0 &&
        (clas->block_count != topology->block_count || !is_sound_base(clas->lower, clas->exponents) ||
         sizeof *clas + groups * sizeof clas->groups[0] > header->stride)) {
        return REFUSE(r, "cluster %u has %u boxes of blocks, or boxes that are none", number, clas->block_count);
    }
    return CLAST_OK;
}

static clast_status check_clusters(const reader *r)
{
    clast_status status = CLAST_OK;
    for (uint32_t i = 0; i < r->header->slot_count && status == CLAST_OK; i++) {
        status = check_cluster(r, i);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------- mapping

static clast_status check_all(reader *r, size_t size, bool checksum, clast_tree *tree)
{
    clast_status status = check_header(r, size);
    if (status == CLAST_OK && checksum && clast_stored_checksum(r->header) != r->header->checksum) {
        status = REFUSE(r, "its checksum is wrong");
    }
    status = status == CLAST_OK ? check_nodes(r, tree) : status;
    return status == CLAST_OK ? check_clusters(r) : status;
}

clast_status clast_blas_map(clast_context *context, const void *memory, size_t size, bool checksum, clast_blas **blas)
{
    if (context == NULL || memory == NULL || blas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if ((uintptr_t)memory % STORED_ALIGNMENT != 0) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "the memory given is not aligned to %d bytes",
                          STORED_ALIGNMENT);
    }
    reader r = {.context = context, .memory = memory, .header = memory};
    clast_tree tree = {.placed = true};
    clast_status status = check_all(&r, size, checksum, &tree);
    if (status != CLAST_OK) {
        return status;
    }
    mapped_blas *mapped = clast_allocate_zeroed(context, 1, sizeof *mapped);
    if (mapped == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    // Without their const: nothing writes through these, as what would is refused for a mapped BLAS.
    uint8_t *block = (uint8_t *)(uintptr_t)memory;
    tree.nodes = (clast_node *)(void *)(block + r.layout.nodes);
    tree.boxes = &((stored_header *)(void *)block)->box; // of the root: rays look at no other
    tree.node_count = r.header->node_count;
    mapped->pool = (clast_clas_pool){
        .context = context, .slots = block + r.layout.slots, .stride = r.header->stride, .count = r.header->slot_count};
    mapped->blas = (clast_blas){.pool = &mapped->pool, .context = context, .tree = tree, .mapped_bytes = size};
    *blas = &mapped->blas;
    return CLAST_OK;
}
