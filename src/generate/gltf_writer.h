// SPDX-License-Identifier: Apache-2.0
// Writes a glTF 2.0 scene piece by piece: vertices and indices go straight to files, one for each attribute, so that a
// scene of many millions of triangles needs little memory. Failures are kept in outputs->status; calls after one do
// nothing.
#ifndef CLAST_GENERATE_GLTF_WRITER_H
#define CLAST_GENERATE_GLTF_WRITER_H

#include <jansson.h>

#include "generate/outputs.h"
#include "shared/dialect.h"

typedef enum clast_gltf_stream {
    CLAST_GLTF_POSITIONS,   // 3 floats
    CLAST_GLTF_NORMALS,     // 3 floats
    CLAST_GLTF_TANGENTS,    // 4 floats
    CLAST_GLTF_COORDINATES, // 2 floats
    CLAST_GLTF_COLOURS,     // 4 normalised 16-bit
    CLAST_GLTF_INDICES,     // 32-bit
    CLAST_GLTF_STREAMS,
} clast_gltf_stream;

// Vertices on their way to the files.
typedef struct clast_gltf_vertices {
    packed3 *positions;
    packed3 *normals;
    packed4 *tangents;
    packed2 *coordinates;
    uint16_t (*colours)[4];
} clast_gltf_vertices;

typedef struct clast_gltf_material {
    const char *name;
    float roughness, metallic; // factors of the texture
    float normal_scale;
    bool double_sided;
    const char *colour_image; // file names; null for none
    const char *roughness_image;
    const char *normal_image;
    float colour[3]; // linear, factor
    const char *displacement_image;
    float displacement_factor, displacement_offset; // metres = texel * factor + offset
    float emissive[3];
    json_t *extensions; // null, or the material's by their names: the writer's once added
} clast_gltf_material;

typedef struct clast_gltf_writer {
    clast_outputs *outputs;
    const char *name;
    char stream_names[CLAST_GLTF_STREAMS][64];
    clast_file_output *streams[CLAST_GLTF_STREAMS];
    uint64_t bytes[CLAST_GLTF_STREAMS]; // written
    json_t *accessors, *meshes, *nodes, *materials, *textures, *images, *cameras;
    json_t *extensions; // that materials have, by their names
    json_t *extras;     // of the whole; the writer's once set
    bool failed;        // jansson could not allocate
    // The primitive under way.
    json_t *primitives;
    uint64_t first_byte[CLAST_GLTF_STREAMS];
    uint32_t vertex_count;
    uint64_t index_count;
    vec3 lower, upper;
    uint32_t material;
    uint64_t triangle_count; // of all primitives
} clast_gltf_writer;

// Begins NAME.gltf with its NAME_*.bin.
void clast_gltf_begin(clast_gltf_writer *writer, clast_outputs *outputs, const char *name);
// Writes the .gltf, and frees what the writer holds. Must be called, also after failures.
void clast_gltf_end(clast_gltf_writer *writer);

uint32_t clast_gltf_add_material(clast_gltf_writer *writer, const clast_gltf_material *material);

// A mesh is a series of primitives, of one material each.
void clast_gltf_begin_mesh(clast_gltf_writer *writer);
void clast_gltf_begin_primitive(clast_gltf_writer *writer, uint32_t material);
// `indices` count from the first vertex of the primitive; each must be below the number of vertices added by then.
void clast_gltf_add_vertices(clast_gltf_writer *writer, const clast_gltf_vertices *vertices, uint32_t count);
void clast_gltf_add_indices(clast_gltf_writer *writer, const uint32_t *indices, uint32_t count);
void clast_gltf_end_primitive(clast_gltf_writer *writer);
uint32_t clast_gltf_end_mesh(clast_gltf_writer *writer, const char *name);

// Places a mesh. rotation: a unit quaternion x y z w.
void clast_gltf_add_node(clast_gltf_writer *writer, const char *name, uint32_t mesh, vec3 translation, vec4 rotation,
                         vec3 scale);
void clast_gltf_writer_add_camera(clast_gltf_writer *writer, const char *name, vec3 position, vec3 target,
                                  float vertical_angle);

// Writes the file scene.json of a document, and ends that. Null: memory ran out.
void clast_write_scene_file(clast_outputs *outputs, json_t *root);

#endif
