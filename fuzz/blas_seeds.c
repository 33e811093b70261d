// SPDX-License-Identifier: Apache-2.0
// blas_seeds FOLDER: writes stored acceleration structures for the target that maps them.
#include "accel/meshes.h"
#include "seeds.h"

static void write_blas(clast_context *context, const char *name, mesh m, uint32_t most)
{
    clustered c;
    uint64_t size = 0;
    if (clustered_make(context, &m, most, &c) != CLAST_OK || clast_blas_serialise(c.blas, NULL, 0, &size) != CLAST_OK) {
        stop(name);
    }
    void *block = NULL;
    if (posix_memalign(&block, 64, (size_t)size) != 0 ||
        clast_blas_serialise(c.blas, block, (size_t)size, &size) != CLAST_OK) {
        stop(name);
    }
    write_seed("blas_map", name, block, (size_t)size);
    free(block);
    clustered_free(&c);
    mesh_free(&m);
}

int main(int argument_count, char **arguments)
{
    if (argument_count != 2) {
        fprintf(stderr, "usage: blas_seeds FOLDER\n");
        return 2;
    }
    seeds_begin(arguments[1]);
    clast_context *context;
    if (clast_context_create(&(clast_context_desc){.threads = 1}, &context) != CLAST_OK) {
        stop("context");
    }
    write_blas(context, "soup", mesh_soup(30, 0.5f, 3), 2);
    write_blas(context, "sphere", mesh_octasphere(2), 16);
    write_blas(context, "one", mesh_octasphere(0), 64);
    clast_context_destroy(context);
    return 0;
}
