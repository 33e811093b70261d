// SPDX-License-Identifier: Apache-2.0
// clast info: what a file holds, and what it takes.
#include <inttypes.h>
#include <string.h>

#include "app/print.h"
#include "app/session.h"
#include "app/report.h"
#include "clast/image.h"
#include "scene/scene.h"

typedef struct clast_info_work {
    clast_session session;
    clast_scene *scene;
    clast_scene_counts counts;
    float lower[3], upper[3];
    bool is_cooked;
    clast_render_statistics statistics;
} clast_info_work;

static const char *const pixel_texts[] = {
#define PIXEL_TEXT(name, value, text) [value] = text,
    CLAST_PIXEL_LIST(PIXEL_TEXT)};
static const char *const light_texts[] = {
#define LIGHT_TEXT(name, value, text) [value] = text,
    CLAST_LIGHT_LIST(LIGHT_TEXT)};
static const char *const source_texts[] = {
#define SOURCE_TEXT(name, value, text) [value] = text,
    CLAST_SOURCE_LIST(SOURCE_TEXT)};
static const char *const environment_texts[] = {
#define ENVIRONMENT_TEXT(name, value, text) [value] = text,
    CLAST_ENVIRONMENT_LIST(ENVIRONMENT_TEXT)};

static const char *name_or(const char *name, const char *otherwise)
{
    return name != NULL && name[0] != '\0' ? name : otherwise;
}

// ----------------------------------------------------------------------------------------------------------- as text

// Lists of thousands help nobody: the first of them do.
enum { LISTED_MOST = 20 };

static void print_rest(size_t count)
{
    if (count > LISTED_MOST) {
        printf("  ... and %zu more\n", count - LISTED_MOST);
    }
}

static void print_geometries(const clast_scene *scene)
{
    char vertices[32];
    char triangles[32];
    for (size_t i = 0; i < scene->geometry_count && i < LISTED_MOST; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        const char *name = name_or(geometry->name, "(no name)");
        if (clast_geometry_is_mesh(geometry)) {
            const clast_mesh *mesh = &geometry->of.mesh;
            printf(
                "  %zu %s: %s vertices, %s triangles%s%s%s%s\n", i, name,
                clast_format_count(mesh->vertex_count, vertices), clast_format_count(mesh->triangle_count, triangles),
                mesh->normals != NULL ? ", normals" : "", mesh->tangents != NULL ? ", tangents" : "",
                mesh->coordinates[0] != NULL ? ", texture coordinates" : "", mesh->colours != NULL ? ", colours" : "");
        } else {
            printf("  %zu %s: %s\n", i, name, source_texts[geometry->kind]);
        }
    }
    print_rest(scene->geometry_count);
}

static void print_images(const clast_scene *scene)
{
    for (size_t i = 0; i < scene->image_count && i < LISTED_MOST; i++) {
        const clast_image *image = &scene->images[i].image;
        printf("  %zu %s: %u x %u, %u channels, %s\n", i, name_or(scene->images[i].name, "(no name)"), image->width,
               image->height, image->channels, pixel_texts[image->type]);
    }
    print_rest(scene->image_count);
}

static void print_lights_and_cameras(const clast_scene *scene)
{
    printf("lights: %zu\n", scene->light_count);
    for (size_t i = 0; i < scene->light_count && i < LISTED_MOST; i++) {
        printf("  %zu %s: %s\n", i, name_or(scene->lights[i].name, "(no name)"),
               light_texts[scene->lights[i].record.type]);
    }
    print_rest(scene->light_count);
    printf("environment: %s\n", scene->has_environment ? environment_texts[scene->environment.type] : "none");
    printf("cameras: %zu\n", scene->camera_count);
    for (size_t i = 0; i < scene->camera_count && i < LISTED_MOST; i++) {
        printf("  %zu %s\n", i, name_or(scene->cameras[i].name, "(no name)"));
    }
    print_rest(scene->camera_count);
}

static void print_motion(const clast_scene *scene)
{
    const clast_motion *motion = &scene->motion;
    printf("nodes: %zu, skins: %zu\n", motion->node_count, motion->skin_count);
    printf("animations: %zu\n", motion->animation_count);
    for (size_t i = 0; i < motion->animation_count && i < LISTED_MOST; i++) {
        printf("  %zu %s: %g s, %zu channels\n", i, name_or(motion->animations[i].name, "(no name)"),
               motion->animations[i].length, motion->animations[i].channel_count);
    }
    print_rest(motion->animation_count);
}

static void print_structures(const clast_render_statistics *statistics)
{
    char count[32];
    char bytes[32];
    const struct {
        const char *name;
        uint64_t bytes;
    } rows[] = {
        {"cooked data", statistics->cook_bytes},
        {"templates", statistics->template_bytes},
        {"clusters (CLAS)", statistics->clas_bytes},
        {"vertices of the frame", statistics->vertex_bytes},
        {"trees over clusters (BLAS)", statistics->blas_bytes},
        {"tree over instances (TLAS)", statistics->tlas_bytes},
    };
    printf("clusters: %s, %.1f triangles each on average, %.1f %% full\n",
           clast_format_count(statistics->clusters, count),
           statistics->clusters != 0 ? (double)statistics->triangles / (double)statistics->clusters : 0.0,
           100.0 * statistics->cluster_fill);
    printf("memory:\n");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        printf("  %-27s %10s", rows[i].name, clast_format_bytes(rows[i].bytes, bytes));
        if (statistics->triangles != 0) {
            printf(", %.2f bytes a triangle", (double)rows[i].bytes / (double)statistics->triangles);
        }
        printf("\n");
    }
}

static void print_scene(const clast_info_work *work)
{
    char count[32];
    const clast_scene *scene = work->scene;
    const clast_scene_counts *counts = &work->counts;
    printf("geometries: %u, %s triangles\n", counts->geometries, clast_format_count(counts->triangles, count));
    print_geometries(scene);
    printf("instances: %u, %s triangles\n", counts->instances, clast_format_count(counts->instanced_triangles, count));
    printf("materials: %u, textures: %u\n", counts->materials, counts->textures);
    printf("images: %u, %s\n", counts->images, clast_format_bytes(counts->image_bytes, count));
    print_images(scene);
    print_lights_and_cameras(scene);
    if (scene->motion.node_count != 0) {
        print_motion(scene);
    }
    if (work->lower[0] <= work->upper[0]) {
        printf("bounds: %g %g %g to %g %g %g\n", (double)work->lower[0], (double)work->lower[1], (double)work->lower[2],
               (double)work->upper[0], (double)work->upper[1], (double)work->upper[2]);
    } else {
        printf("bounds: empty\n");
    }
    if (work->is_cooked) {
        print_structures(&work->statistics);
    }
}

// ----------------------------------------------------------------------------------------------------------- as JSON

static json_t *geometries_array(const clast_scene *scene)
{
    json_t *array = json_array();
    for (size_t i = 0; array != NULL && i < scene->geometry_count; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        bool is_mesh = clast_geometry_is_mesh(geometry);
        json_t *row = json_pack("{s:o, s:s, s:I, s:I}", "name", clast_report_text(name_or(geometry->name, "")), "kind",
                                source_texts[geometry->kind], "vertices",
                                is_mesh ? (json_int_t)geometry->of.mesh.vertex_count : 0, "triangles",
                                is_mesh ? (json_int_t)geometry->of.mesh.triangle_count : 0);
        if (json_array_append_new(array, row) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static json_t *images_array(const clast_scene *scene)
{
    json_t *array = json_array();
    for (size_t i = 0; array != NULL && i < scene->image_count; i++) {
        const clast_image *image = &scene->images[i].image;
        json_t *row = json_pack("{s:o, s:I, s:I, s:I, s:s}", "name",
                                clast_report_text(name_or(scene->images[i].name, "")), "width",
                                (json_int_t)image->width, "height", (json_int_t)image->height, "channels",
                                (json_int_t)image->channels, "type", pixel_texts[image->type]);
        if (json_array_append_new(array, row) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static json_t *cameras_array(const clast_scene *scene)
{
    json_t *array = json_array();
    for (size_t i = 0; array != NULL && i < scene->camera_count; i++) {
        if (json_array_append_new(array, clast_report_text(name_or(scene->cameras[i].name, ""))) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static json_t *animations_array(const clast_scene *scene)
{
    json_t *array = json_array();
    for (size_t i = 0; array != NULL && i < scene->motion.animation_count; i++) {
        const clast_scene_animation *animation = &scene->motion.animations[i];
        json_t *row = json_pack("{s:o, s:f, s:I}", "name", clast_report_text(name_or(animation->name, "")), "seconds",
                                animation->length, "channels", (json_int_t)animation->channel_count);
        if (json_array_append_new(array, row) != 0) {
            json_decref(array);
            return NULL;
        }
    }
    return array;
}

static json_t *corner_or_null(const clast_info_work *work, const float corner[3])
{
    if (!(work->lower[0] <= work->upper[0])) {
        return json_null();
    }
    return json_pack("[f, f, f]", (double)corner[0], (double)corner[1], (double)corner[2]);
}

static json_t *scene_object(const clast_info_work *work)
{
    const clast_scene *scene = work->scene;
    const clast_scene_counts *counts = &work->counts;
    json_t *object = json_pack(
        "{s:s, s:o, s:o, s:o, s:I, s:I, s:I, s:I, s:o, s:I, s:I, s:o, s:o, s:o, s:o, s:o}", "verb", "info", "clast",
        clast_report_program(&work->session), "input", clast_report_text(work->session.command->positionals[0]),
        "geometries", geometries_array(scene), "mesh_triangles", (json_int_t)counts->triangles, "instances",
        (json_int_t)counts->instances, "materials", (json_int_t)counts->materials, "textures",
        (json_int_t)counts->textures, "images", images_array(scene), "image_bytes", (json_int_t)counts->image_bytes,
        "lights", (json_int_t)counts->lights, "environment",
        scene->has_environment ? json_string(environment_texts[scene->environment.type]) : json_null(), "cameras",
        cameras_array(scene), "animations", animations_array(scene), "lower", corner_or_null(work, work->lower),
        "upper", corner_or_null(work, work->upper));
    if (object != NULL && work->is_cooked) {
        json_t *cooked = json_object();
        if (cooked == NULL || clast_report_add_counts(cooked, &work->statistics) != 0 ||
            json_object_set(object, "cooked", cooked) != 0) {
            json_decref(object);
            object = NULL;
        }
        json_decref(cooked);
    }
    return object;
}

// -------------------------------------------------------------------------------------------------------------- work

static clast_status cook(clast_info_work *work)
{
    clast_renderer *renderer = NULL;
    clast_status status = clast_renderer_create(work->scene, &renderer);
    if (status == CLAST_OK) {
        status = clast_renderer_commit(renderer, NULL);
    }
    if (status == CLAST_OK) {
        status = clast_renderer_statistics(renderer, &work->statistics);
        work->is_cooked = status == CLAST_OK;
    }
    clast_renderer_destroy(renderer);
    return status;
}

static clast_exit tell_scene(clast_info_work *work)
{
    const clast_command *command = work->session.command;
    clast_status status = clast_session_change(&work->session, work->scene);
    clast_scene_count(work->scene, &work->counts);
    clast_scene_bounds(work->scene, work->lower, work->upper);
    if (status == CLAST_OK && !command->no_cook) {
        status = cook(work);
    }
    if (status != CLAST_OK) {
        return clast_session_fail(&work->session, status);
    }
    clast_session_clear_line(&work->session);
    if (clast_session_prints(&work->session)) {
        print_scene(work);
    }
    bool good = command->json == NULL || clast_session_write_json(&work->session, scene_object(work));
    return good ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
}

static clast_exit tell_image(clast_session *session, const clast_image *image)
{
    const clast_command *command = session->command;
    if (clast_session_prints(session)) {
        printf("image: %u x %u, %u channels, %s\n", image->width, image->height, image->channels,
               pixel_texts[image->type]);
    }
    bool good = true;
    if (command->json != NULL) {
        json_t *object = json_pack("{s:s, s:o, s:o, s:I, s:I, s:I, s:s}", "verb", "info", "clast",
                                   clast_report_program(session), "input", clast_report_text(command->positionals[0]),
                                   "width", (json_int_t)image->width, "height", (json_int_t)image->height, "channels",
                                   (json_int_t)image->channels, "type", pixel_texts[image->type]);
        good = clast_session_write_json(session, object);
    }
    return good ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
}

clast_exit clast_run_info(const clast_command *command)
{
    clast_info_work work = {0};
    if (!clast_session_begin(&work.session, command)) {
        return CLAST_EXIT_FAILURE;
    }
    clast_context *context = work.session.context;
    clast_exit code = CLAST_EXIT_FAILURE;
    clast_image image = {0};
    // What is not an image is read as a scene, whose error tells more. A damaged image is told as an image.
    clast_status status = clast_image_read(context, command->positionals[0], &image);
    if (status == CLAST_OK) {
        code = tell_image(&work.session, &image);
        clast_image_free(context, &image);
    } else if (status == CLAST_ERROR_UNSUPPORTED) {
        clast_scene_choice choice = {command->chosen_scene, command->variant};
        status = clast_scene_load_chosen(context, command->positionals[0], &choice, &work.scene);
        code = status == CLAST_OK ? tell_scene(&work) : clast_session_fail(&work.session, status);
    } else {
        code = clast_session_fail(&work.session, status);
    }
    clast_scene_destroy(work.scene);
    clast_session_end(&work.session);
    return code;
}
