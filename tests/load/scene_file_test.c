// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

// Puts a scene file, written with ' for ".
static char scene_text[8192];

static const char *quoted(const char *text)
{
    size_t length = strlen(text);
    assert_true(length < sizeof scene_text);
    for (size_t i = 0; i <= length; i++) {
        scene_text[i] = text[i] == '\'' ? '"' : text[i];
    }
    return scene_text;
}

static void put_model(fixture *f)
{
    put_text(f, "s/m.obj", "v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n");
}

static void assert_scene(fixture *f, const char *text)
{
    put_model(f);
    assert_loads(f, "s/a.json", quoted(text));
}

static void assert_scene_refused(fixture *f, const char *text, clast_status expected, const char *words)
{
    put_model(f);
    assert_refused(f, "s/a.json", quoted(text), expected, words);
}

static void models_are_placed(void **state)
{
    fixture *f = *state;
    assert_scene(
        f,
        "{'clast': 1, 'models': [{'path': 'm.obj'}, {'path': 'm.obj', 'translation': [1, 2, 3], 'scale': 2, 'rotation': [0, 2, 0, 2]},"
        "{'path': 'm.obj', 'scale': [1, 2, 3]}]}");
    assert_int_equal(f->scene->instance_count, 3);
    ASSERT_FLOATS(f->scene->instances[0].to_world.rows[0].v, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0);
    // a quarter turn about y takes x to -z and z to x
    ASSERT_FLOATS(f->scene->instances[1].to_world.rows[0].v, 1e-6, 0, 0, 2, 1, 0, 2, 0, 2, -2, 0, 0, 3);
    ASSERT_FLOATS(f->scene->instances[2].to_world.rows[0].v, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0);
}

static void copies_stand_in_a_grid(void **state)
{
    fixture *f = *state;
    assert_scene(f, "{'clast': 1, 'models': [{'path': 'm.obj'}, {'path': 'm.obj', 'scale': 2, 'copies': 3}]}");
    assert_int_equal(f->scene->instance_count, 4);
    assert_int_equal(f->scene->geometry_count, 2);
    ASSERT_FLOATS(f->scene->instances[1].to_world.rows[0].v, 1e-6, 2, 0, 0, 0);
    ASSERT_FLOATS(f->scene->instances[2].to_world.rows[0].v, 1e-6, 2, 0, 0, 2.1f, 0, 2, 0, 0, 0, 0, 2, 0);
    ASSERT_FLOATS(f->scene->instances[3].to_world.rows[0].v, 1e-6, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, -2.1f);
}

// A model of which node 0 is animated; accessors without bytes are zeros.
static void put_moving(fixture *f, const char *nodes, const char *more)
{
    static char moving[2048]; // put_text keeps a pointer
    snprintf(moving, sizeof moving,
             "{'asset':{'version':'2.0'},'nodes':[%s],'meshes':[{'primitives':[{'attributes':{'POSITION':0,"
             "'JOINTS_0':3,'WEIGHTS_0':4},'targets':[{'POSITION':0}]}]}],'accessors':["
             "{'componentType':5126,'count':3,'type':'VEC3'},{'componentType':5126,'count':1,'type':'SCALAR'},"
             "{'componentType':5126,'count':1,'type':'VEC3'},{'componentType':5121,'count':3,'type':'VEC4'},"
             "{'componentType':5126,'count':3,'type':'VEC4'}],'animations':[{'name':'a','samplers':["
             "{'input':1,'output':2},{'input':1,'output':1}],"
             "'channels':[{'sampler':0,'target':{'node':0,'path':'translation'}}%s]}]%s}",
             nodes, more, more[0] != '\0' ? ",'skins':[{'joints':[0]}]" : "");
    memcpy(moving, quoted(moving), strlen(moving));
    put_text(f, "s/moving.gltf", moving);
}

// What moves hangs from a node that is placed; copies stand beside it whenever.
static void what_moves_in_a_model_is_placed_with_it(void **state)
{
    fixture *f = *state;
    put_moving(f, "{'mesh':0,'translation':[1,0,0]}", "");
    assert_scene(f, "{'clast': 1, 'models': [{'path': 'm.obj', 'translation': [9, 9, 9]},"
                    "{'path': 'moving.gltf', 'translation': [5, 6, 7], 'scale': 2, 'copies': 2}]}");
    const clast_motion *motion = &f->scene->motion;
    assert_int_equal(f->scene->instance_count, 3);
    assert_int_equal(motion->node_count, 2); // the model that does not move needs none
    assert_int_equal(motion->attachment_count, 2);
    ASSERT_FLOATS(f->scene->instances[0].to_world.rows[0].v, 0, 1, 0, 0, 9);
    ASSERT_FLOATS(f->scene->instances[1].to_world.rows[0].v, 0, 2, 0, 0, 7, 0, 2, 0, 6, 0, 0, 2, 7);
    clast_posed_node nodes[2];
    clast_scene_pose(f->scene, (clast_moment){CLAST_ANIMATION_FIRST, 0.0}, nodes, NULL);
    assert_true(nodes[1].to_world.rows[0][3] == 5.0 && nodes[1].to_world.rows[1][1] == 2.0);
}

static void settings_may_change_with_time(void **state)
{
    fixture *f = *state;
    assert_scene(
        f, "{'clast': 1, 'settings': {'exposure': {'keys': [[0, 1], [2, 3], [4, 0]]}, 'rate': {'keys': [[0, 0]]}}}");
    const clast_motion *motion = &f->scene->motion;
    assert_int_equal(motion->setting_count, 2);
    assert_int_equal(motion->settings[1].offset, offsetof(clast_render_settings, exposure));
    assert_int_equal(motion->settings[1].key_count, 3);
    assert_true(motion->settings[1].keys[3] == 3.0);
    assert_true(motion->settings[0].has_default && !motion->settings[1].has_default);
#define REFUSED(setting, words) \
    assert_scene_refused(f, "{'clast': 1, 'settings': {" setting "}}", CLAST_ERROR_MALFORMED, words)
    REFUSED("'exposure': {'keys': []}", "settings.exposure.keys: expected a key at least");
    REFUSED("'exposure': {}", "settings.exposure.keys: expected a value");
    REFUSED("'exposure': {'keys': [[1, 0], [1, 1]]}", "keys[1]: expected a time after");
    REFUSED("'exposure': {'keys': [[1]]}", "keys[0]: expected a time and a value");
    REFUSED("'exposure': {'keys': [[1, 100]]}", "keys[0][1]: 100: expected -64 to 64");
    REFUSED("'exposure': {'keys': [[1, 0]], 'loop': true}", "settings.exposure.loop: unknown key");
    REFUSED("'time': {'keys': [[1, 0]]}", "settings.time: expected a number");
    REFUSED("'spp': {'keys': [[1, 1]]}", "settings.spp: expected a whole number");
}

static void a_sky_is_read(void **state)
{
    fixture *f = *state;
    assert_scene(f,
                 "{'clast': 1, 'environment': {'sky': {'sun_direction': [0, 3, 4], 'turbidity': 5, 'sun_size': 1}}}");
    const clast_environment *environment = &f->scene->environment;
    assert_true(f->scene->has_environment);
    assert_int_equal(environment->type, CLAST_ENVIRONMENT_SKY);
    ASSERT_FLOATS(environment->sun_direction, 1e-6, 0, 0.6f, 0.8f);
    ASSERT_FLOATS(&environment->turbidity, 0, 5);
    ASSERT_FLOATS(&environment->sun_size, 1e-6, 0.01745329f);
}

static void an_environment_image_is_read(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "s/e.pfm", "Pf\n1 1\n1.0\n\x3f\0\0\0", 15);
    assert_scene(f, "{'clast': 1, 'environment': {'image': 'e.pfm', 'rotation': 90, 'intensity': 2}}");
    const clast_environment *environment = &f->scene->environment;
    assert_int_equal(environment->type, CLAST_ENVIRONMENT_IMAGE);
    assert_int_equal(environment->image, 0);
    ASSERT_FLOATS(&environment->rotation, 1e-6, 1.5707963f);
    ASSERT_FLOATS(environment->colour, 0, 2, 2, 2);
}

static void a_constant_environment_is_read(void **state)
{
    fixture *f = *state;
    assert_scene(f, "{'clast': 1, 'environment': {'colour': [1, 2, 3]}}");
    assert_int_equal(f->scene->environment.type, CLAST_ENVIRONMENT_CONSTANT);
    ASSERT_FLOATS(f->scene->environment.colour, 0, 1, 2, 3);
}

static void cameras_are_read(void **state)
{
    fixture *f = *state;
    assert_scene(
        f,
        "{'clast': 1, 'cameras': [{'name': 'front', 'position': [0, 1, 2], 'target': [0, 0, 0], 'up': [0, 0, 1], 'vertical_angle': 90,"
        "'near_plane': 0.5, 'far_plane': 9}, {'projection': 'orthographic', 'position': [0, 0, 1], 'target': [0, 0, 0], 'height': 3}]}");
    const clast_camera_desc *camera = &f->scene->cameras[0].desc;
    assert_string_equal(f->scene->cameras[0].name, "front");
    ASSERT_FLOATS(camera->position, 0, 0, 1, 2);
    ASSERT_FLOATS(camera->up, 0, 0, 0, 1);
    ASSERT_FLOATS(&camera->vertical_angle, 1e-6, 1.5707963f);
    ASSERT_FLOATS(&camera->near_plane, 0, 0.5f, 9);
    assert_int_equal(f->scene->cameras[1].desc.projection, CLAST_PROJECTION_ORTHOGRAPHIC);
    ASSERT_FLOATS(&f->scene->cameras[1].desc.height, 0, 3);
}

static void lights_are_read(void **state)
{
    fixture *f = *state;
    assert_scene(
        f,
        "{'clast': 1, 'lights': [{'type': 'spot', 'name': 'lamp', 'position': [0, 1, 0], 'direction': [0, -2, 0], 'colour': [1, 0.5, 0], 'intensity': 4,"
        "'range': 7, 'inner_angle': 0, 'outer_angle': 60}, {'type': 'directional', 'direction': [1, 0, 0]}]}");
    const clast_light *light = &f->scene->lights[0].record;
    assert_int_equal(light->type, CLAST_LIGHT_SPOT);
    ASSERT_FLOATS(light->radiance.v, 1e-6, 4, 2, 0);
    ASSERT_FLOATS(light->direction.v, 1e-6, 0, -1, 0);
    ASSERT_FLOATS(&light->range, 0, 7);
    ASSERT_FLOATS(&light->outer_cosine, 1e-6, 0.5f);
    assert_int_equal(f->scene->lights[1].record.type, CLAST_LIGHT_DIRECTIONAL);
}

static void waves_are_read(void **state)
{
    fixture *f = *state;
    assert_scene(
        f,
        "{'clast': 1, 'waves': [{'name': 'sea', 'size': 10, 'tiles': 4, 'amplitude': 0.5, 'wavelength': 3, 'speed': 2, 'translation': [0, 1, 0],"
        "'material': {'base_colour': [0, 0.25, 0.5], 'metallic': 0.5, 'roughness': 0.125, 'emissive': [0, 0, 1], 'double_sided': false}}]}");
    const clast_geometry *geometry = &f->scene->geometries[0];
    assert_int_equal(geometry->kind, CLAST_SOURCE_WAVE);
    assert_int_equal(geometry->of.wave.tiles, 4);
    ASSERT_FLOATS(&geometry->of.wave.amplitude, 0, 0.5f, 3, 2);
    const clast_material *material = &f->scene->materials[geometry->of.wave.material].record;
    ASSERT_FLOATS(material->base_colour.v, 0, 0, 0.25f, 0.5f, 1);
    ASSERT_FLOATS(&material->metallic, 0, 0.5f, 0.125f);
    assert_int_equal(material->double_sided, 0);
    ASSERT_FLOATS(f->scene->instances[0].to_world.rows[1].v, 0, 0, 1, 0, 1);
}

static void settings_are_those_of_the_list(void **state)
{
    fixture *f = *state;
    assert_scene(
        f,
        "{'clast': 1, 'settings': {'width': 320, 'spp': 7, 'exposure': -1.5, 'time': 2, 'tonemap': 'none', 'camera': 'front', 'env': 'sky'}}");
    const clast_render_settings *settings = &f->scene->settings;
    assert_int_equal(settings->width, 320);
    assert_int_equal(settings->height, 0);
    assert_int_equal(settings->spp, 7);
    assert_true(settings->exposure == -1.5 && settings->time == 2.0);
    assert_int_equal(settings->tonemap, CLAST_TONE_MAP_NONE);
    assert_string_equal(settings->camera, "front");
    assert_string_equal(settings->env, "sky");
    assert_scene(f, "{'clast': 1, 'settings': {'env': 'e.hdr'}}");
    assert_string_equal(f->scene->settings.env, "s/e.hdr");
    assert_scene(f, "{'clast': 1, 'settings': {'env': '1,1,0.5'}}");
    assert_string_equal(f->scene->settings.env, "1,1,0.5");
}

static void every_setting_of_the_list_is_a_key(void **state)
{
    fixture *f = *state;
#define TRY(name, ...) \
    assert_scene_refused(f, "{'clast': 1, 'settings': {'" #name "': []}}", CLAST_ERROR_MALFORMED, \
                         "settings." #name ": expected a");
#define TRY_CHOICE(name, list, ...) \
    assert_scene_refused(f, "{'clast': 1, 'settings': {'" #name "': 'no such'}}", CLAST_ERROR_MALFORMED, \
                         "settings." #name ": expected one of");
    CLAST_RENDER_SETTING_LIST(TRY, TRY, TRY_CHOICE, TRY)
}

static void unknown_keys_are_refused_by_name(void **state)
{
    fixture *f = *state;
    static const char *const cases[][2] = {
        {"{'clast': 1, 'modles': []}", "modles"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'position': [0,0,0]}]}", "models[0].position"},
        {"{'clast': 1, 'environment': {'sun': 1}}", "environment.sun"},
        {"{'clast': 1, 'environment': {'colour': [1,1,1], 'rotation': 2}}", "environment.rotation"},
        {"{'clast': 1, 'environment': {'sky': {'sun_direction': [0,1,0], 'haze': 1}}}", "environment.sky.haze"},
        {"{'clast': 1, 'cameras': [{'position': [0,0,1], 'target': [0,0,0], 'fov': 45}]}", "cameras[0].fov"},
        {"{'clast': 1, 'lights': [{'type': 'point', 'position': [0,0,0], 'power': 1}]}", "lights[0].power"},
        {"{'clast': 1, 'waves': [{'size': 1}, {'size': 1, 'material': {'color': [1,1,1]}}]}",
         "waves[1].material.color"},
        {"{'clast': 1, 'settings': {'samples': 1}}", "settings.samples"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_scene_refused(f, cases[i][0], CLAST_ERROR_MALFORMED, cases[i][1]);
        assert_non_null(strstr(clast_context_error(f->context), "unknown key"));
    }
}

static void wrong_values_are_refused_with_their_place(void **state)
{
    fixture *f = *state;
    static const char *const cases[][2] = {
        {"{'clast': 1, 'models': {}}", "models: expected an array"},
        {"{'clast': 1, 'models': [3]}", "models[0]: expected an object"},
        {"{'clast': 1, 'models': [{}]}", "models[0].path: expected a value"},
        {"{'clast': 1, 'models': [{'path': 3}]}", "models[0].path: expected a text"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'translation': [0, 1]}]}",
         "models[0].translation: expected an array of 3 numbers"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'translation': [0, 1, 'x']}]}",
         "models[0].translation[2]: expected a number"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'translation': [0, 1, 1e50]}]}", "models[0].translation[2]: "},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'rotation': [0, 0, 0, 0]}]}",
         "models[0].rotation: expected a quaternion"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'copies': 0}]}", "models[0].copies: 0: expected 1 to "},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'copies': 1.5}]}", "models[0].copies: expected a whole number"},
        {"{'clast': 1, 'models': [{'path': 'm.obj', 'scale': 3e38, 'copies': 9}]}", "range"},
        {"{'clast': 1, 'environment': {}}", "environment: expected one of"},
        {"{'clast': 1, 'environment': {'sky': {}}}", "environment.sky.sun_direction: expected a value"},
        {"{'clast': 1, 'environment': {'sky': {'sun_direction': [0,0,0]}}}", "environment: "},
        {"{'clast': 1, 'environment': {'sky': {'sun_direction': [0,1,0], 'turbidity': 99}}}",
         "environment.sky.turbidity: 99"},
        {"{'clast': 1, 'cameras': [{'position': [0,0,0], 'target': [0,0,0]}]}", "cameras[0]: "},
        {"{'clast': 1, 'cameras': [{'position': [0,0,0], 'target': [0,0,1], 'vertical_angle': 180}]}",
         "cameras[0].vertical_angle: 180"},
        {"{'clast': 1, 'cameras': [{'position': [0,0,0], 'target': [0,0,1], 'projection': 'fisheye'}]}",
         "cameras[0].projection: expected one of: perspective, orthographic"},
        {"{'clast': 1, 'lights': [{'type': 'spot', 'position': [0,0,0]}]}", "lights[0].direction: expected a value"},
        {"{'clast': 1, 'lights': [{'type': 'point', 'position': [0,0,0], 'intensity': -1}]}",
         "lights[0].intensity: -1"},
        {"{'clast': 1, 'waves': [{'size': 1, 'tiles': 5000}]}", "waves[0].tiles: 5000"},
        {"{'clast': 1, 'waves': [{'size': 1, 'material': {'double_sided': 1}}]}",
         "waves[0].material.double_sided: expected true or false"},
        {"{'clast': 1, 'settings': {'width': 0}}", "settings.width: 0: expected 1 to 65536"},
        {"{'clast': 1, 'settings': {'width': -3}}", "settings.width: -3"},
        {"{'clast': 1, 'settings': {'exposure': 'x'}}", "settings.exposure: expected a number"},
        {"{'clast': 1, 'settings': {'tonemap': 'x'}}", "settings.tonemap: expected one of: aces, none"},
        {"{'clast': '1'}", "clast: expected the format's version"},
        {"{'clast': 1, 'clast': 1}", "duplicate"},
        {"{'clast': 1,", "line 1"},
        {"{'clast': 1} x", "line 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_scene_refused(f, cases[i][0], CLAST_ERROR_MALFORMED, cases[i][1]);
    }
    assert_scene_refused(f, "{'clast': 2}", CLAST_ERROR_UNSUPPORTED, "version 2");
}

static void a_model_may_be_no_scene_file(void **state)
{
    fixture *f = *state;
    put_text(f, "s/a.json", "{\"clast\": 1, \"models\": [{\"path\": \"a.json\"}]}");
    assert_int_equal(load(f, "s/a.json"), CLAST_ERROR_UNSUPPORTED);
    assert_non_null(strstr(clast_context_error(f->context), "another scene file"));
}

static void what_is_wrong_with_a_model_is_said(void **state)
{
    fixture *f = *state;
    put_text(f, "s/a.json", "{\"clast\": 1, \"models\": [{\"path\": \"nowhere.obj\"}]}");
    assert_int_equal(load(f, "s/a.json"), CLAST_ERROR_FILE_NOT_FOUND);
    assert_non_null(strstr(clast_context_error(f->context), "s/nowhere.obj"));
}

static const char whole[] =
    "{'clast': 1, 'models': [{'path': 'm.obj', 'translation': [1, 2, 3], 'scale': 2, 'rotation': [0, 2, 0, 2], 'copies': 2}],"
    "'environment': {'sky': {'sun_direction': [0, 3, 4], 'turbidity': 5}},"
    "'cameras': [{'name': 'front', 'position': [0, 1, 2], 'target': [0, 0, 0]}], 'lights': [{'type': 'point', 'position': [0, 1, 0]}],"
    "'waves': [{'size': 10, 'material': {'base_colour': [0, 1, 0]}}], 'settings': {'width': 320, 'camera': 'front', 'env': 'e.hdr'}}";

static void broken_files_do_no_harm(void **state)
{
    fixture *f = *state;
    put_model(f);
    quoted(whole);
    load_broken(f, "s/a.json", scene_text, strlen(scene_text), 3000);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    assert_scene(f, whole);
    load_without_memory(f, "s/a.json");
}

static void memory_that_runs_out_for_what_moves_is_an_error(void **state)
{
    fixture *f = *state;
    put_moving(f, "{'name':'joint','children':[1,2]},{'mesh':0,'skin':0},{'mesh':0,'skin':0}",
               ",{'sampler':1,'target':{'node':1,'path':'weights'}}");
    assert_scene(f, "{'clast': 1, 'models': [{'path': 'moving.gltf', 'copies': 2}],"
                    "'settings': {'exposure': {'keys': [[0, 1], [1, 2]]}}}");
    assert_int_equal(f->scene->motion.skin_count, 1);
    assert_int_equal(f->scene->geometries[0].deformation.target_count, 1);
    assert_int_equal(f->scene->geometries[1].deformation.target_count, 0);
    assert_ptr_equal(f->scene->geometries[0].deformation.joints, f->scene->geometries[1].deformation.joints);
    load_without_memory(f, "s/a.json");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(models_are_placed),
        LOADER_TEST(copies_stand_in_a_grid),
        LOADER_TEST(what_moves_in_a_model_is_placed_with_it),
        LOADER_TEST(settings_may_change_with_time),
        LOADER_TEST(a_sky_is_read),
        LOADER_TEST(an_environment_image_is_read),
        LOADER_TEST(a_constant_environment_is_read),
        LOADER_TEST(cameras_are_read),
        LOADER_TEST(lights_are_read),
        LOADER_TEST(waves_are_read),
        LOADER_TEST(settings_are_those_of_the_list),
        LOADER_TEST(every_setting_of_the_list_is_a_key),
        LOADER_TEST(unknown_keys_are_refused_by_name),
        LOADER_TEST(wrong_values_are_refused_with_their_place),
        LOADER_TEST(a_model_may_be_no_scene_file),
        LOADER_TEST(what_is_wrong_with_a_model_is_said),
        LOADER_TEST(broken_files_do_no_harm),
        LOADER_TEST(memory_that_runs_out_is_an_error),
        LOADER_TEST(memory_that_runs_out_for_what_moves_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
