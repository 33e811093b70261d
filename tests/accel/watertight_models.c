// SPDX-License-Identifier: Apache-2.0
// The meshes of real models, those that are closed.
#include <dirent.h>
#include <stdio.h>

#include "accel/watertight.h"
#include "scene/scene.h"

typedef struct gathering {
    clast_context *context;
    surface **surfaces;
    uint32_t count, open, unread;
    bool open_too;
} gathering;

static mesh copy_of_mesh(const clast_mesh *from)
{
    mesh m = mesh_of(from->vertex_count, from->triangle_count);
    memcpy(m.positions, from->positions, 12 * (size_t)from->vertex_count);
    memcpy(m.indices, from->indices, 12 * (size_t)from->triangle_count);
    return m;
}

// Whether a surface of the same triangles is there: models come in several formats and versions.
static bool is_known(const gathering *g, const mesh *m)
{
    for (uint32_t i = 0; i < g->count; i++) {
        const mesh *other = &(*g->surfaces)[i].m;
        if (other->triangle_count == m->triangle_count && other->vertex_count == m->vertex_count &&
            memcmp(other->positions, m->positions, 12 * (size_t)m->vertex_count) == 0) {
            return true;
        }
    }
    return false;
}

static void add_meshes(gathering *g, const clast_scene *scene, const char *path)
{
    for (size_t i = 0; i < scene->geometry_count; i++) {
        if (scene->geometries[i].kind != CLAST_SOURCE_CLUSTERS || scene->geometries[i].of.mesh.triangle_count < 4) {
            continue;
        }
        mesh m = copy_of_mesh(&scene->geometries[i].of.mesh);
        if (is_known(g, &m)) {
            mesh_free(&m);
            continue;
        }
        surface s;
        uint32_t open = surface_make(g->context, path, &m, &s);
        if (!g->open_too && (open != 0 || !surface_find_inside(&s, 1))) {
            printf("%s: %u triangles, %u edges without two faces: skipped\n", path, s.m.triangle_count, open);
            g->open++;
            surface_free(&s);
        } else {
            *g->surfaces = realloc(*g->surfaces, (g->count + 1) * sizeof **g->surfaces);
            (*g->surfaces)[g->count++] = s;
        }
    }
}

static bool is_model(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot != NULL && (strcmp(dot, ".obj") == 0 || strcmp(dot, ".ply") == 0 || strcmp(dot, ".gltf") == 0 ||
                           strcmp(dot, ".glb") == 0);
}

// Entries by name, so that the order does not depend on the file system. Folders of broken models are left out.
static void load_folder(gathering *g, const char *folder, uint32_t depth)
{
    struct dirent **entries;
    int count = scandir(folder, &entries, NULL, alphasort);
    for (int i = 0; i < count; i++) {
        const char *name = entries[i]->d_name;
        char path[2048];
        clast_scene *scene;
        int length = snprintf(path, sizeof path, "%s/%s", folder, name);
        if (name[0] != '.' && strcmp(name, "malformed") != 0 && length < (int)sizeof path) {
            if (!is_model(name)) {
                if (depth < 8) {
                    load_folder(g, path, depth + 1); // what is no folder has no entries
                }
            } else if (clast_scene_load(g->context, path, &scene) == CLAST_OK) {
                add_meshes(g, scene, path);
                clast_scene_destroy(scene);
            } else {
                g->unread++;
            }
        }
        free(entries[i]);
    }
    if (count >= 0) {
        free(entries);
    }
}

uint32_t surfaces_load_all(clast_context *context, const char *folder, surface **surfaces)
{
    gathering g = {.context = context, .surfaces = surfaces, .open_too = true};
    load_folder(&g, folder, 0);
    return g.count;
}

uint32_t surfaces_load(clast_context *context, const char *folder, surface **surfaces, uint32_t count)
{
    gathering g = {.context = context, .surfaces = surfaces, .count = count};
    load_folder(&g, folder, 0);
    printf("%s: %u closed meshes, %u others, %u files not read\n", folder, g.count - count, g.open, g.unread);
    return g.count;
}
