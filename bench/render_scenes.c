// SPDX-License-Identifier: Apache-2.0
#include "render_scenes.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "shapes.h"
#include "shared/random.h"

enum { INSTANCES_SIDE = 22 };

// ---------------------------------------------------------------------------------------------------------------- parts

static clast_scene *new_scene(clast_context *context)
{
    clast_scene *scene;
    bench_check(clast_scene_create(context, &scene), context);
    return scene;
}

static uint32_t add_material(clast_context *context, clast_scene *scene, vec3 colour, float emissive, float roughness)
{
    clast_material_desc material = clast_material_defaults();
    for (int c = 0; c < 3; c++) {
        material.base_colour[c] = colour[c];
        material.emissive[c] = emissive;
    }
    material.roughness = roughness;
    uint32_t number;
    bench_check(clast_scene_add_material(scene, &material, NULL, &number), context);
    return number;
}

static void look(clast_context *context, clast_scene *scene, vec3 from, vec3 at, float angle)
{
    clast_camera_desc camera = {
        .position = {from[0], from[1], from[2]}, .target = {at[0], at[1], at[2]}, .vertical_angle = angle};
    uint32_t number;
    bench_check(clast_scene_add_camera(scene, &camera, NULL, &number), context);
}

static void add_mesh(clast_context *context, clast_scene *scene, const float *positions, uint32_t triangles,
                     uint32_t material)
{
    uint32_t *indices = malloc(3 * (size_t)triangles * sizeof *indices), geometry, instance;
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        indices[i] = i;
    }
    clast_mesh mesh = {.vertex_count = 3 * triangles,
                       .triangle_count = triangles,
                       .positions = positions,
                       .indices = indices,
                       .material = material};
    bench_check(clast_scene_add_mesh(scene, &mesh, NULL, &geometry), context);
    bench_check(clast_scene_add_instance(scene, geometry, NULL, NULL, &instance), context);
    free(indices);
}

static void put(float *positions, uint32_t vertex, vec3 place)
{
    for (int k = 0; k < 3; k++) {
        positions[3 * vertex + (uint32_t)k] = place[k];
    }
}

static void add_square(clast_context *context, clast_scene *scene, vec3 centre, vec3 right, vec3 up, uint32_t material)
{
    float positions[18];
    const float signs[6][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}};
    for (uint32_t i = 0; i < 6; i++) {
        put(positions, i, centre + right * signs[i][0] + up * signs[i][1]);
    }
    add_mesh(context, scene, positions, 2, material);
}

// Of half the size along each axis; turned around the vertical by an angle.
static void add_box(clast_context *context, clast_scene *scene, vec3 centre, vec3 half, float angle, uint32_t material)
{
    vec3 x = vec3(cosf(angle), 0.0f, -sinf(angle)) * half[0], y = vec3(0.0f, half[1], 0.0f),
         z = vec3(sinf(angle), 0.0f, cosf(angle)) * half[2];
    const vec3 axes[3] = {x, y, z};
    for (int k = 0; k < 3; k++) {
        add_square(context, scene, centre + axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3], material);
        add_square(context, scene, centre - axes[k], axes[(k + 2) % 3], axes[(k + 1) % 3], material);
    }
}

// --------------------------------------------------------------------------------------------------------------- scenes

static void add_walls(clast_context *context, clast_scene *scene, uint32_t white, uint32_t left, uint32_t right)
{
    vec3 x = vec3(1, 0, 0), y = vec3(0, 1, 0), z = vec3(0, 0, 1);
    add_square(context, scene, y * -1.0f, z, x, white);
    add_square(context, scene, y, x, z, white);
    add_square(context, scene, z * -1.0f, x, y, white);
    add_square(context, scene, x * -1.0f, y, z, left);
    add_square(context, scene, x, z, y, right);
}

clast_scene *render_scene_cornell(clast_context *context)
{
    clast_scene *scene = new_scene(context);
    uint32_t white = add_material(context, scene, vec3(0.73f, 0.73f, 0.73f), 0.0f, 1.0f),
             red = add_material(context, scene, vec3(0.65f, 0.05f, 0.05f), 0.0f, 1.0f),
             green = add_material(context, scene, vec3(0.12f, 0.45f, 0.15f), 0.0f, 1.0f),
             lamp = add_material(context, scene, splat3(0.0f), 12.0f, 1.0f);
    add_walls(context, scene, white, red, green);
    add_square(context, scene, vec3(0.0f, 0.99f, 0.0f), vec3(0.25f, 0, 0), vec3(0, 0, 0.25f), lamp);
    add_box(context, scene, vec3(-0.35f, -0.4f, -0.3f), vec3(0.3f, 0.6f, 0.3f), 0.3f, white);
    add_box(context, scene, vec3(0.35f, -0.7f, 0.3f), vec3(0.3f, 0.3f, 0.3f), -0.3f, white);
    look(context, scene, vec3(0.0f, 0.0f, 3.9f), splat3(0.0f), 0.68f);
    return scene;
}

clast_scene *render_scene_instances(clast_context *context)
{
    clast_scene *scene = new_scene(context);
    uint32_t geometry, instance;
    shape sphere = shape_sphere(64, 32);
    sphere.mesh.material = add_material(context, scene, vec3(0.7f, 0.5f, 0.3f), 0.0f, 0.4f);
    bench_check(clast_scene_add_mesh(scene, &sphere.mesh, NULL, &geometry), context);
    shape_free(&sphere);
    for (uint32_t i = 0; i < INSTANCES_SIDE * INSTANCES_SIDE * INSTANCES_SIDE; i++) {
        float place[3], size = 0.3f + 0.5f * unit_float(hash2(i, 3));
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t cell = k == 0   ? i % INSTANCES_SIDE
                            : k == 1 ? i / INSTANCES_SIDE % INSTANCES_SIDE
                                     : i / INSTANCES_SIDE / INSTANCES_SIDE;
            place[k] = 2.0f * ((float)cell + unit_float(hash2(i, k)) - 0.5f * INSTANCES_SIDE);
        }
        const float transform[12] = {size, 0, 0, place[0], 0, size, 0, place[1], 0, 0, size, place[2]};
        bench_check(clast_scene_add_instance(scene, geometry, transform, NULL, &instance), context);
    }
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.6f, 0.4f}};
    bench_check(clast_scene_set_environment(scene, &sky), context);
    look(context, scene, vec3(40.0f, 26.0f, 44.0f), splat3(0.0f), 0.8f);
    return scene;
}

static void remove_folder(const char *folder)
{
    DIR *opened = opendir(folder);
    for (const struct dirent *entry; opened != NULL && (entry = readdir(opened)) != NULL;) {
        char path[512];
        if (entry->d_name[0] != '.' && snprintf(path, sizeof path, "%s/%s", folder, entry->d_name) < (int)sizeof path) {
            unlink(path);
        }
    }
    if (opened != NULL) {
        closedir(opened);
    }
    rmdir(folder);
}

clast_scene *render_scene_demonstration(clast_context *context, double detail)
{
    char folder[256], path[300];
    snprintf(folder, sizeof folder, "%s/clast-bench-XXXXXX", getenv("TMPDIR") != NULL ? getenv("TMPDIR") : "/tmp");
    if (mkdtemp(folder) == NULL) {
        fprintf(stderr, "%s: no folder could be made\n", folder);
        exit(1);
    }
    clast_generate_desc desc = {.scene = "canyon", .detail = detail};
    clast_status status = clast_generate(context, &desc, folder);
    snprintf(path, sizeof path, "%s/scene.json", folder);
    clast_scene *scene = NULL;
    status = status == CLAST_OK ? clast_scene_load(context, path, &scene) : status;
    remove_folder(folder);
    bench_check(status, context);
    return scene;
}

static vec3 random_direction(uint32_t seed)
{
    float z = 2.0f * unit_float(hash2(seed, 11)) - 1.0f, level = sqrtf(fmaxf(1.0f - z * z, 0.0f)),
          angle = 6.2831853f * unit_float(hash2(seed, 12));
    return vec3(level * cosf(angle), z, level * sinf(angle));
}

clast_scene *render_scene_lamps(clast_context *context, uint32_t lamps)
{
    clast_scene *scene = new_scene(context);
    uint32_t white = add_material(context, scene, vec3(0.7f, 0.7f, 0.7f), 0.0f, 1.0f),
             lamp = add_material(context, scene, splat3(0.0f), 40.0f, 1.0f);
    add_walls(context, scene, white, white, white);
    add_box(context, scene, vec3(-0.35f, -0.6f, -0.3f), vec3(0.2f, 0.4f, 0.2f), 0.3f, white);
    add_box(context, scene, vec3(0.35f, -0.8f, 0.2f), vec3(0.2f, 0.2f, 0.2f), -0.3f, white);
    float *positions = malloc(9 * (size_t)lamps * sizeof *positions), size = 0.2f / sqrtf((float)lamps);
    for (uint32_t i = 0; i < lamps; i++) {
        vec3 place = vec3(1.8f * unit_float(hash2(i, 1)) - 0.9f, 1.2f * unit_float(hash2(i, 2)) - 0.3f,
                          1.8f * unit_float(hash2(i, 3)) - 0.9f);
        vec3 right = random_direction(i) * size, up = normalize3(cross3(right, random_direction(~i))) * size;
        put(positions, 3 * i, lamps == 1 ? vec3(0.0f, 0.6f, 0.0f) : place);
        put(positions, 3 * i + 1, (lamps == 1 ? vec3(0.0f, 0.6f, 0.0f) : place) + right);
        put(positions, 3 * i + 2, (lamps == 1 ? vec3(0.0f, 0.6f, 0.0f) : place) + up);
    }
    add_mesh(context, scene, positions, lamps, lamp);
    free(positions);
    look(context, scene, vec3(0.0f, 0.0f, 3.9f), splat3(0.0f), 0.68f);
    return scene;
}
