/* SPDX-License-Identifier: Apache-2.0
 *
 * A scene: what there is to draw. Made by clast_scene_load, or by hand from arrays; edited at any time by one call at a
 * time; seen by a renderer at its next commit. Coordinates are right-handed; glTF's conventions hold: y up by default, a
 * camera looks along its -z, counter-clockwise triangles face the viewer, lengths in metres.
 */
#ifndef CLAST_SCENE_H
#define CLAST_SCENE_H

#include "clast/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum clast_source_kind { CLAST_SOURCE_LIST(CLAST_ENUMERATOR) } clast_source_kind;
typedef enum clast_alpha_mode { CLAST_ALPHA_LIST(CLAST_ENUMERATOR) } clast_alpha_mode;
typedef enum clast_wrap { CLAST_WRAP_LIST(CLAST_ENUMERATOR) } clast_wrap;
typedef enum clast_filter { CLAST_FILTER_LIST(CLAST_ENUMERATOR) } clast_filter;
typedef enum clast_light_type { CLAST_LIGHT_LIST(CLAST_ENUMERATOR) } clast_light_type;
typedef enum clast_environment_type { CLAST_ENVIRONMENT_LIST(CLAST_ENUMERATOR) } clast_environment_type;
typedef enum clast_projection { CLAST_PROJECTION_LIST(CLAST_ENUMERATOR) } clast_projection;
typedef enum clast_pixel_type { CLAST_PIXEL_LIST(CLAST_ENUMERATOR) } clast_pixel_type;

typedef struct clast_scene clast_scene;

CLAST_API clast_status clast_scene_create(clast_context *context, clast_scene **scene);
CLAST_API void clast_scene_destroy(clast_scene *scene);

/** Reads a scene: glTF 2.0 (.gltf, .glb), Wavefront (.obj), Stanford (.ply), or a scene file (.json, docs/scene-file.md).
 *  The type is told by the contents, then the name. A scene without material gets a plain one; the caller adds camera and
 *  light where they lack (clast_scene_add_default_camera). Errors: FILE_NOT_FOUND, FILE_READ, MALFORMED, UNSUPPORTED (names
 *  the extension), LIMIT, OUT_OF_MEMORY, CANCELLED; the message says the file, the place and what was expected. */
CLAST_API clast_status clast_scene_load(clast_context *context, const char *path, clast_scene **scene);

/** Which of several to take from glTF files, by name, or by number where none has that name. Null: what the file says is its
 *  default. Of a scene file, what its models say goes before this. */
typedef struct clast_scene_choice {
    const char *scene;   /**< one of the file's scenes; null: its default, or the first */
    const char *variant; /**< of KHR_materials_variants; null: none, the materials without variants */
} clast_scene_choice;

/** The same with a choice, null for none. A choice that a glTF file does not have is INVALID_ARGUMENT; the message lists those that
 *  it has. */
CLAST_API clast_status clast_scene_load_chosen(clast_context *context, const char *path,
                                               const clast_scene_choice *choice, clast_scene **scene);

/* ----------------------------------------------------------------------------------------------- images and materials */

/** Pixels, row by row from the top, tightly packed. */
typedef struct clast_image {
    uint32_t width, height;
    uint32_t channels; /**< 1 to 4: grey; grey, alpha; red, green, blue; with alpha */
    clast_pixel_type type;
    const void *pixels;
} clast_image;

/** An image with the way it is read. */
typedef struct clast_texture {
    uint32_t image;
    clast_wrap wrap_u, wrap_v;
    clast_filter filter;
} clast_texture;

/** A texture in a material's slot. Colours (base, emissive, specular and sheen) of integer images are taken as sRGB, all else as linear. */
typedef struct clast_texture_slot {
    uint32_t texture;        /**< CLAST_NONE for none */
    uint32_t coordinate_set; /**< 0 or 1 */
    float offset[2];         /**< KHR_texture_transform */
    float scale[2];
    float rotation; /**< radians */
} clast_texture_slot;

/** A material: glTF 2.0 metallic-roughness, with what its extensions add. Begin with clast_material_defaults(). */
typedef struct clast_material_desc {
    float base_colour[4]; /**< linear, 0 to 1 */
    float emissive[3];    /**< linear, any size */
    float metallic;       /**< 0 to 1 */
    float roughness;      /**< 0 to 1 */
    float normal_scale;
    float occlusion_strength;
    float alpha_cutoff; /**< for CLAST_ALPHA_MASK */
    clast_alpha_mode alpha_mode;
    bool double_sided; /**< else the camera looks through backs (clockwise triangles); light never does */
    clast_texture_slot base_colour_texture;
    clast_texture_slot metallic_roughness_texture; /**< green roughness, blue metallic */
    clast_texture_slot normal_texture;
    clast_texture_slot occlusion_texture;
    clast_texture_slot emissive_texture;
    /** How far tessellated meshes are displaced along their normals: the texture's red channel, taken as it is, times the
     *  scale, plus the offset; in the mesh's own unit of length. KHR_materials_displacement. */
    clast_texture_slot displacement_texture;
    float displacement_scale;
    float displacement_offset; /**< counts where there is a displacement texture */
    float ior;                 /**< index of refraction, from 1; 0 is infinite. KHR_materials_ior */
    /** How strongly a surface that is not metal reflects, 0 to 1, times the texture's alpha; and in which colour, times the
     *  texture's. KHR_materials_specular */
    float specular;
    float specular_colour[3]; /**< linear, any size */
    clast_texture_slot specular_texture;
    clast_texture_slot specular_colour_texture;
    float clearcoat; /**< 0 to 1, times the texture's red. KHR_materials_clearcoat */
    float clearcoat_roughness;
    float clearcoat_normal_scale;
    clast_texture_slot clearcoat_texture;
    clast_texture_slot clearcoat_roughness_texture; /**< green */
    clast_texture_slot clearcoat_normal_texture;
    float sheen_colour[3]; /**< of fuzz, linear, 0 to 1; black is none. KHR_materials_sheen */
    float sheen_roughness;
    clast_texture_slot sheen_colour_texture;
    clast_texture_slot sheen_roughness_texture; /**< alpha */
    float anisotropy;                           /**< 0 to 1: how stretched highlights are. KHR_materials_anisotropy */
    float anisotropy_rotation;                  /**< radians, counter-clockwise from the tangent */
    clast_texture_slot anisotropy_texture;      /**< red and green a direction, blue a factor */
    float transmission; /**< 0 to 1: how much of what is not metal is clear. KHR_materials_transmission */
    clast_texture_slot transmission_texture; /**< red */
    /** More than zero: what is clear is the border of a volume, which refracts; zero: a thin wall. KHR_materials_volume; a
     *  ray tracer knows the rest of the thickness. */
    float thickness;
    float attenuation_distance;  /**< after which light has the colour below; 0 is endless */
    float attenuation_colour[3]; /**< linear, 0 to 1 */
    float dispersion;  /**< of a volume: how much it parts colours, 20 over its Abbe number. KHR_materials_dispersion */
    float iridescence; /**< 0 to 1, times the texture's red: how much a thin film covers. KHR_materials_iridescence */
    float iridescence_ior; /**< the film's index of refraction, from 1 */
    /** The film's thickness in nanometres, where the texture is 0 and where it is 1; without a texture, the maximum counts. */
    float iridescence_thickness_minimum;
    float iridescence_thickness_maximum;
    clast_texture_slot iridescence_texture;           /**< red */
    clast_texture_slot iridescence_thickness_texture; /**< green */
    /** 0 to 1, times the texture's alpha: how much of the diffuse part leaves on the other side, and in which colour, times the
     *  texture's. KHR_materials_diffuse_transmission */
    float diffuse_transmission;
    float diffuse_transmission_colour[3]; /**< linear, 0 to 1 */
    clast_texture_slot diffuse_transmission_texture;
    clast_texture_slot diffuse_transmission_colour_texture;
    bool unlit; /**< its base colour is seen as it is, whatever the light. KHR_materials_unlit */
} clast_material_desc;

/** X(slot): all texture slots of a material. */
#define CLAST_MATERIAL_TEXTURE_LIST(X) \
    X(base_colour_texture) \
    X(metallic_roughness_texture) \
    X(normal_texture) \
    X(occlusion_texture) \
    X(emissive_texture) \
    X(displacement_texture) \
    X(specular_texture) \
    X(specular_colour_texture) \
    X(clearcoat_texture) \
    X(clearcoat_roughness_texture) \
    X(clearcoat_normal_texture) \
    X(sheen_colour_texture) \
    X(sheen_roughness_texture) \
    X(anisotropy_texture) \
    X(transmission_texture) \
    X(iridescence_texture) \
    X(iridescence_thickness_texture) \
    X(diffuse_transmission_texture) \
    X(diffuse_transmission_colour_texture)

/** Light grey, rough, not metallic, double sided, without textures or layers, of refractive index 1.5; a displacement texture
 *  has scale 1 and offset 0. */
CLAST_API clast_material_desc clast_material_defaults(void);

/** Each adds a copy and gives its number. `name` may be null. Errors: INVALID_ARGUMENT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_scene_add_image(clast_scene *scene, const clast_image *image, const char *name,
                                             uint32_t *number);
CLAST_API clast_status clast_scene_add_texture(clast_scene *scene, const clast_texture *texture, uint32_t *number);
CLAST_API clast_status clast_scene_add_material(clast_scene *scene, const clast_material_desc *material,
                                                const char *name, uint32_t *number);
CLAST_API clast_status clast_scene_set_material(clast_scene *scene, uint32_t number,
                                                const clast_material_desc *material);

/* ----------------------------------------------------------------------------------------------------------- geometry */

/** A triangle mesh as arrays. Attributes may be null where there are none; without normals, triangles are flat. */
typedef struct clast_mesh {
    uint32_t vertex_count;
    uint32_t triangle_count;
    const float *positions;             /**< 3 for each vertex */
    const float *normals;               /**< 3 for each vertex, unit length */
    const float *tangents;              /**< 4 for each vertex; the fourth is the bitangent's sign */
    const float *coordinates[2];        /**< 2 for each vertex: texture coordinates, (0, 0) is the image's upper left */
    const float *colours;               /**< 4 for each vertex, linear: times the base colour */
    const uint32_t *indices;            /**< 3 for each triangle */
    const uint32_t *triangle_materials; /**< one for each triangle, or null: `material` for all */
    uint32_t material;                  /**< CLAST_NONE: the scene's plain material */
} clast_mesh;

/** A sheet of grids that waves with time, in the plane y = 0 around the origin: the smallest animated, adaptive source. */
typedef struct clast_wave {
    float size;       /**< side length; more than 0 */
    uint32_t tiles;   /**< grids along a side; 1 to 1024 */
    float amplitude;  /**< height of the waves */
    float wavelength; /**< more than 0 */
    float speed;      /**< wavelengths a second */
    uint32_t material;
} clast_wave;

/** Each adds a geometry (a copy of the arrays) and gives its number. A vertex that is not finite, or an index out of
 *  range, is INVALID_ARGUMENT. */
CLAST_API clast_status clast_scene_add_mesh(clast_scene *scene, const clast_mesh *mesh, const char *name,
                                            uint32_t *geometry);
CLAST_API clast_status clast_scene_add_wave(clast_scene *scene, const clast_wave *wave, const char *name,
                                            uint32_t *geometry);
/** Replaces a mesh's positions, and normals where given (else they go). The counts stay. */
CLAST_API clast_status clast_scene_set_mesh_positions(clast_scene *scene, uint32_t geometry, const float *positions,
                                                      const float *normals);

/** How a mesh is tessellated. */
typedef struct clast_tessellation {
    bool curved; /**< the surface bends along the normals (PN triangles); else it is that of the triangles */
} clast_tessellation;

/** Lets a mesh be cut anew each frame, as finely as it is seen, and displaced as its materials say; null lets it be as it
 *  is. Errors: INVALID_ARGUMENT. */
CLAST_API clast_status clast_scene_set_tessellation(clast_scene *scene, uint32_t geometry,
                                                    const clast_tessellation *tessellation);

/* ---------------------------------------------------------------------------------------------------------- instances */

/** Places a geometry; `transform` is object to world, three rows of four, null for the identity. Numbers of removed
 *  instances are not used again. */
CLAST_API clast_status clast_scene_add_instance(clast_scene *scene, uint32_t geometry, const float transform[12],
                                                const char *name, uint32_t *instance);
CLAST_API clast_status clast_scene_set_instance_transform(clast_scene *scene, uint32_t instance,
                                                          const float transform[12]);
CLAST_API clast_status clast_scene_set_instance_visible(clast_scene *scene, uint32_t instance, bool visible);
CLAST_API clast_status clast_scene_remove_instance(clast_scene *scene, uint32_t instance);
/** Repeats the whole scene in a square grid until `copies` of it stand side by side, a small gap apart. */
CLAST_API clast_status clast_scene_repeat(clast_scene *scene, uint32_t copies);

/* ------------------------------------------------------------------------------------------------- lights and cameras */

/** A punctual light, as KHR_lights_punctual defines it. */
typedef struct clast_light_desc {
    clast_light_type type;
    float position[3];
    float direction[3]; /**< the way it shines; need not have unit length */
    float colour[3];    /**< linear */
    float intensity;    /**< point, spot: candela; directional: lux */
    float range;        /**< 0 is endless */
    float inner_angle;  /**< spot: radians from the axis; 0 to outer_angle */
    float outer_angle;  /**< spot: up to pi / 2 */
} clast_light_desc;
CLAST_API clast_status clast_scene_add_light(clast_scene *scene, const clast_light_desc *light, const char *name,
                                             uint32_t *number);

/** What surrounds the scene. */
typedef struct clast_environment {
    clast_environment_type type;
    uint32_t image;  /**< IMAGE: latitude and longitude; its middle is direction +x, turned to -z by `rotation` */
    float rotation;  /**< IMAGE: radians about the y axis */
    float colour[3]; /**< CONSTANT: radiance; else a factor, where zero in all three is one */
    float sun_direction[3]; /**< SKY: towards the sun */
    float turbidity;        /**< SKY: haze, 1 (clear) to 10; 0 is 2.5 */
    float sun_size;         /**< SKY: the sun's angular radius in radians; 0 is the real one, 0.00465 */
} clast_environment;
CLAST_API clast_status clast_scene_set_environment(clast_scene *scene, const clast_environment *environment);

typedef struct clast_camera_desc {
    clast_projection projection;
    float position[3];
    float target[3];
    float up[3];          /**< all zero is the y axis */
    float vertical_angle; /**< PERSPECTIVE: radians; 0 is 0.8 */
    float height;         /**< ORTHOGRAPHIC: of what is seen */
    float near_plane;     /**< 0 is none */
    float far_plane;      /**< 0 is none */
    float aperture;       /**< diameter of the lens, in the scene's unit of length; 0 is a pinhole */
    float focus;          /**< distance along the axis that is sharp; 0 is the target's */
} clast_camera_desc;
CLAST_API clast_status clast_scene_add_camera(clast_scene *scene, const clast_camera_desc *camera, const char *name,
                                              uint32_t *number);
/** Adds a camera that sees the whole scene from the front, a little from above. */
CLAST_API clast_status clast_scene_add_default_camera(clast_scene *scene, uint32_t *number);

/* ------------------------------------------------------------------------------------------------------------ queries */

typedef struct clast_scene_counts {
    uint32_t images, textures, materials, geometries, instances, lights, cameras;
    uint64_t triangles; /**< of all mesh geometries */
    uint64_t instanced_triangles;
    uint64_t image_bytes;
} clast_scene_counts;
CLAST_API void clast_scene_count(const clast_scene *scene, clast_scene_counts *counts);
/** The box of all visible instances, displaced as textures from 0 to 1 displace them; lower > upper where there are none. */
CLAST_API void clast_scene_bounds(const clast_scene *scene, float lower[3], float upper[3]);

#ifdef __cplusplus
}
#endif

#endif
