// SPDX-License-Identifier: Apache-2.0
// Displacement as files say it: glTF, MTL, and scene files for models whose own cannot. What is displaced is tessellated.
#include "loader_fixture.h"

// Two triangles of a square, each a primitive of its own, and a normal and texture coordinates for each corner.
static const float VERTICES[4 * 3] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const float COORDINATES[4 * 2] = {0, 0, 1, 0, 1, 1, 0, 1};
static const uint32_t INDICES[6] = {0, 1, 2, 0, 2, 3};

static const char *quoted(const char *text)
{
    static char result[8192];
    size_t length = strlen(text);
    assert_true(length < sizeof result);
    for (size_t i = 0; i <= length; i++) {
        result[i] = text[i] == '\'' ? '"' : text[i];
    }
    return result;
}

static void put_files(fixture *f)
{
    static unsigned char bytes[sizeof VERTICES + sizeof COORDINATES + sizeof INDICES];
    memcpy(bytes, VERTICES, sizeof VERTICES);
    memcpy(bytes + sizeof VERTICES, COORDINATES, sizeof COORDINATES);
    memcpy(bytes + sizeof VERTICES + sizeof COORDINATES, INDICES, sizeof INDICES);
    memory_files_put(&f->files, "data.bin", bytes, sizeof bytes);
    memory_files_put(&f->files, "height.pfm", "Pf\n1 1\n-1\n\0\0\0\x3f", 14); // 0.5
    memory_files_put(&f->files, "normals.pfm", "PF\n1 1\n-1\n\0\0\0\x3f\0\0\0\x3f\0\0\x80\x3f", 22);
}

#define PRIMITIVE(indices, material, more) \
    "{'attributes':{'POSITION':0,'TEXCOORD_0':1" more "},'indices':" indices ",'material':" material "}"
#define GLTF(primitives, materials, more) \
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],'meshes':[{'primitives':[" primitives \
    "]}],'buffers':[{'uri':'data.bin','byteLength':104}],'bufferViews':[{'buffer':0,'byteLength':48}," \
    "{'buffer':0,'byteOffset':48,'byteLength':32},{'buffer':0,'byteOffset':80,'byteLength':24}],'accessors':[" \
    "{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},{'bufferView':1,'componentType':5126,'count':4,'type':'VEC2'}," \
    "{'bufferView':2,'componentType':5125,'count':3,'type':'SCALAR'}," \
    "{'bufferView':2,'byteOffset':12,'componentType':5125,'count':3,'type':'SCALAR'}],'materials':[" materials \
    "]" more "}"
#define IMAGE ",'images':[{'uri':'height.pfm'}],'textures':[{'source':0}]"
#define DISPLACED(members) "{'extensions':{'KHR_materials_displacement':{" members "}}}"
#define TEXTURE "'displacementGeometryTexture':{'index':0}"

static void assert_gltf(fixture *f, const char *text)
{
    put_files(f);
    assert_loads(f, "a.gltf", quoted(text));
}

static void gltf_materials_displace(void **state)
{
    fixture *f = *state;
    assert_gltf(
        f, GLTF(PRIMITIVE("2", "0", ""),
                DISPLACED("'displacementGeometryTexture':{'index':0,'texCoord':1,'extensions':{'KHR_texture_transform':"
                          "{'scale':[2,3]}}},'displacementGeometryFactor':0.25,'displacementGeometryOffset':-0.125"),
                IMAGE));
    const clast_material *material = &f->scene->materials[1].record;
    assert_int_equal(material->displacement_texture.texture, 0);
    assert_int_equal(material->displacement_texture.coordinate_set, 1);
    ASSERT_FLOATS(material->displacement_texture.scale.v, 0, 2, 3);
    ASSERT_FLOATS(&material->displacement_scale, 0, 0.25f, -0.125f);
    assert_true(f->scene->geometries[0].tessellated);
    assert_false(f->scene->geometries[0].tessellation.curved);
    float lower[3], upper[3]; // without normals, any way
    clast_scene_bounds(f->scene, lower, upper);
    ASSERT_FLOATS(lower, 1e-6, -0.125f, -0.125f, -0.125f);
    ASSERT_FLOATS(upper, 1e-6, 1.125f, 1.125f, 0.125f);
}

static void gltf_displacement_has_defaults(void **state)
{
    fixture *f = *state;
    assert_gltf(f, GLTF(PRIMITIVE("2", "0", ""), DISPLACED(TEXTURE), IMAGE));
    ASSERT_FLOATS(&f->scene->materials[1].record.displacement_scale, 0, 1, 0);
    assert_true(f->scene->geometries[0].tessellated);
}

static void what_cannot_displace_is_told(void **state)
{
    fixture *f = *state;
    assert_gltf(f, GLTF(PRIMITIVE("2", "0", ""), DISPLACED("'displacementGeometryFactor':2"), ""));
    assert_non_null(strstr(f->log, "not displaced"));
    assert_false(f->scene->geometries[0].tessellated);
    put_files(f);
    assert_refused(f, "a.gltf", quoted(GLTF(PRIMITIVE("2", "0", ""), DISPLACED(TEXTURE), "")), CLAST_ERROR_MALFORMED,
                   "displacementGeometryTexture.index: 0: the file has no textures");
    assert_refused(f, "a.gltf",
                   quoted(GLTF(PRIMITIVE("2", "0", ""), DISPLACED("'displacementGeometryFactor':'x'"), IMAGE)),
                   CLAST_ERROR_MALFORMED, "displacementGeometryFactor");
    assert_refused(f, "a.gltf",
                   quoted(GLTF(PRIMITIVE("2", "0", ""), DISPLACED(TEXTURE),
                               ",'images':[{'uri':'nowhere.png'}],'textures':[{'source':0}]")),
                   CLAST_ERROR_FILE_NOT_FOUND, "nowhere.png");
}

// A displaced surface is whole only within one geometry.
static void primitives_of_a_displaced_mesh_are_joined(void **state)
{
    fixture *f = *state;
    assert_gltf(f, GLTF(PRIMITIVE("2", "0", "") "," PRIMITIVE("3", "1", ",'NORMAL':0,'COLOR_0':0"),
                        DISPLACED(TEXTURE) ",{}", IMAGE));
    assert_int_equal(f->scene->geometry_count, 1);
    assert_int_equal(f->scene->instance_count, 1);
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 8);
    assert_int_equal(mesh->triangle_count, 2);
    assert_indices(mesh->indices, (const uint32_t[]){0, 1, 2, 4, 6, 7}, 6);
    assert_indices(mesh->triangle_materials, (const uint32_t[]){1, 2}, 2);
    assert_floats(mesh->positions, VERTICES, 12, 0);
    assert_floats(mesh->positions + 12, VERTICES, 12, 0);
    assert_floats(mesh->coordinates[0] + 8, COORDINATES, 8, 0);
    ASSERT_FLOATS(mesh->normals, 0, 0, 0, 1);          // of its triangle
    ASSERT_FLOATS(mesh->normals + 12 + 3, 0, 1, 0, 0); // as given
    ASSERT_FLOATS(mesh->colours, 0, 1, 1, 1, 1);
    float lower[3], upper[3];
    clast_scene_bounds(f->scene, lower, upper);
    assert_float_equal(upper[2], 1.0f, 1e-6); // along the normal of the first triangle
    assert_float_equal(lower[2], 0.0f, 1e-6);
    assert_true(f->scene->geometries[0].tessellated);
}

static void other_meshes_stay_parted(void **state)
{
    fixture *f = *state;
    assert_gltf(f, GLTF(PRIMITIVE("2", "0", "") "," PRIMITIVE("3", "1", ""), "{},{}", IMAGE));
    assert_int_equal(f->scene->geometry_count, 2);
    assert_false(f->scene->geometries[0].tessellated);
}

static void memory_runs_out_while_primitives_are_joined(void **state)
{
    fixture *f = *state;
    put_files(f);
    put_text(
        f, "a.gltf",
        quoted(GLTF(PRIMITIVE("2", "0", "") "," PRIMITIVE("3", "1", ",'NORMAL':0"), DISPLACED(TEXTURE) ",{}", IMAGE)));
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    long blocks = 0;
    for (; status != CLAST_OK && blocks < 1000; blocks++) {
        f->blocks_left = blocks;
        status = load(f, "a.gltf");
        assert_true(status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY);
    }
    f->blocks_left = -1;
    assert_int_equal(status, CLAST_OK);
    assert_true(blocks > 20);
}

// --------------------------------------------------------------------------------------------------------------- MTL

static const clast_material *load_mtl(fixture *f, const char *text)
{
    put_files(f);
    put_text(f, "m.mtl", text);
    put_text(f, "a.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
    assert_ok(f->context, load(f, "a.obj"));
    return &f->scene->materials[1].record;
}

static void mtl_maps_displace(void **state)
{
    fixture *f = *state;
    const clast_material *material = load_mtl(f, "newmtl m\ndisp -mm -0.5 2 -s 3 3 height.pfm\n");
    assert_int_equal(material->displacement_texture.texture, 0);
    ASSERT_FLOATS(&material->displacement_scale, 0, 2, -0.5f);
    ASSERT_FLOATS(material->displacement_texture.scale.v, 0, 3, 3);
    assert_true(f->scene->geometries[0].tessellated);
    material = load_mtl(f, "newmtl m\nmap_disp -bm 0.5 height.pfm\n");
    ASSERT_FLOATS(&material->displacement_scale, 0, 0.5f, 0);
}

static void mtl_bump_maps_of_heights_displace_where_they_say_how_far(void **state)
{
    fixture *f = *state;
    const clast_material *material = load_mtl(f, "newmtl m\nmap_Bump -mm 0 0.1 height.pfm\n");
    assert_int_equal(material->displacement_texture.texture, 0);
    assert_int_equal(material->normal_texture.texture, CLAST_NONE);
    ASSERT_FLOATS(&material->displacement_scale, 0, 0.1f, 0);
    assert_true(f->scene->geometries[0].tessellated);
    material = load_mtl(f, "newmtl m\nmap_Bump height.pfm\n");
    assert_int_equal(material->displacement_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "-mm"));
    material = load_mtl(f, "newmtl m\nmap_Bump -mm 0 1 normals.pfm\n");
    assert_int_equal(material->displacement_texture.texture, CLAST_NONE);
    assert_int_equal(material->normal_texture.texture, 0);
    assert_false(f->scene->geometries[0].tessellated);
}

static void a_missing_mtl_map_does_not_displace(void **state)
{
    fixture *f = *state;
    const clast_material *material = load_mtl(f, "newmtl m\ndisp nowhere.png\n");
    assert_int_equal(material->displacement_texture.texture, CLAST_NONE);
    assert_non_null(strstr(f->log, "nowhere.png"));
    assert_false(f->scene->geometries[0].tessellated);
}

// -------------------------------------------------------------------------------------------------------- scene files

static void load_scene_file(fixture *f, const char *members)
{
    char text[1024];
    put_files(f);
    put_text(f, "plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    snprintf(text, sizeof text, "{'clast': 1, 'models': [{'path': 'plain.obj'}, {'path': 'plain.obj'%s}]}", members);
    assert_loads(f, "a.json", quoted(text));
}

static void scene_files_displace_models(void **state)
{
    fixture *f = *state;
    load_scene_file(f, ", 'displacement': {'image': 'height.pfm', 'scale': 0.5, 'offset': -0.25, 'repeat': [2, 4], "
                       "'coordinate_set': 1, 'wrap': 'CLAMP_TO_EDGE'}");
    const clast_mesh *mesh = mesh_of(f, 1);
    assert_int_not_equal(mesh->material, mesh_of(f, 0)->material);
    const clast_material *material = &f->scene->materials[mesh->material].record;
    assert_int_equal(f->scene->textures[material->displacement_texture.texture].wrap_u, CLAST_WRAP_CLAMP);
    assert_int_equal(material->displacement_texture.coordinate_set, 1);
    ASSERT_FLOATS(material->displacement_texture.scale.v, 0, 2, 4);
    ASSERT_FLOATS(&material->displacement_scale, 0, 0.5f, -0.25f);
    assert_false(f->scene->geometries[0].tessellated);
    assert_true(f->scene->geometries[1].tessellated);
}

static void scene_files_decide_what_is_tessellated(void **state)
{
    fixture *f = *state;
    load_scene_file(f, ", 'tessellated': true");
    assert_false(f->scene->geometries[0].tessellated);
    assert_true(f->scene->geometries[1].tessellated);
    load_scene_file(f, ", 'curved': true");
    assert_true(f->scene->geometries[1].tessellated);
    assert_true(f->scene->geometries[1].tessellation.curved);
    load_scene_file(f, ", 'displacement': {'image': 'height.pfm'}, 'tessellated': false");
    assert_false(f->scene->geometries[1].tessellated);
}

static void wrong_displacements_of_scene_files_are_refused(void **state)
{
    fixture *f = *state;
    put_files(f);
    put_text(f, "plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
#define MODEL(members) quoted("{'clast': 1, 'models': [{'path': 'plain.obj', " members "}]}")
    assert_refused(f, "a.json", MODEL("'displacement': {'scale': 1}"), CLAST_ERROR_MALFORMED,
                   "models[0].displacement.image: expected a value");
    assert_refused(f, "a.json", MODEL("'displacement': {'image': 'height.pfm', 'height': 1}"), CLAST_ERROR_MALFORMED,
                   "models[0].displacement.height: unknown key");
    assert_refused(f, "a.json", MODEL("'displacement': {'image': 'height.pfm', 'coordinate_set': 2}"),
                   CLAST_ERROR_MALFORMED, "models[0].displacement.coordinate_set: 2");
    assert_refused(f, "a.json", MODEL("'curved': 1"), CLAST_ERROR_MALFORMED,
                   "models[0].curved: expected true or false");
    put_text(f, "a.json", MODEL("'displacement': {'image': 'nowhere.png'}"));
    assert_int_equal(load(f, "a.json"), CLAST_ERROR_FILE_NOT_FOUND);
}

static void zero_in_settings_is_not_the_default(void **state)
{
    fixture *f = *state;
    put_files(f);
    assert_loads(f, "a.json", quoted("{'clast': 1, 'settings': {'rate': 0, 'displacement_scale': 0, 'time': 0}}"));
    const clast_render_settings *settings = &f->scene->settings;
    assert_true(settings->rate == CLAST_ZERO && settings->displacement_scale == CLAST_ZERO);
    assert_true(settings->time == 0.0 && settings->segment == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(gltf_materials_displace),
        LOADER_TEST(gltf_displacement_has_defaults),
        LOADER_TEST(what_cannot_displace_is_told),
        LOADER_TEST(primitives_of_a_displaced_mesh_are_joined),
        LOADER_TEST(other_meshes_stay_parted),
        LOADER_TEST(memory_runs_out_while_primitives_are_joined),
        LOADER_TEST(mtl_maps_displace),
        LOADER_TEST(mtl_bump_maps_of_heights_displace_where_they_say_how_far),
        LOADER_TEST(a_missing_mtl_map_does_not_displace),
        LOADER_TEST(scene_files_displace_models),
        LOADER_TEST(scene_files_decide_what_is_tessellated),
        LOADER_TEST(wrong_displacements_of_scene_files_are_refused),
        LOADER_TEST(zero_in_settings_is_not_the_default),
    };
    return cmocka_run_group_tests_name("displacement", tests, NULL, NULL);
}
