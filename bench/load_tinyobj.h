// SPDX-License-Identifier: Apache-2.0
// A peer that is C++.
#ifndef CLAST_BENCH_LOAD_TINYOBJ_H
#define CLAST_BENCH_LOAD_TINYOBJ_H

#ifdef __cplusplus
extern "C" {
#endif

// Reads an OBJ file with tinyobjloader, polygons cut into triangles; 0 where that fails.
int tinyobj_load(const char *path);

#ifdef __cplusplus
}
#endif

#endif
