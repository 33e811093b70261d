// SPDX-License-Identifier: Apache-2.0
// The faults that a validation can find: X(code, severity, meaning). The codes of glTF are those of the Khronos Group's
// validator, so that who knows one report can read the other; docs/validate.md says where the two differ.
#ifndef CLAST_LOAD_VALIDATE_CODES_H
#define CLAST_LOAD_VALIDATE_CODES_H

// Any file.
#define CLAST_FILE_FAULT_LIST(X) \
    X(FILE_MALFORMED, ERROR, "the file breaks its format's rules") \
    X(FILE_UNSUPPORTED, ERROR, "the file needs what clast does not read") \
    X(FILE_LIMIT, ERROR, "the file is larger than a limit of clast") \
    X(IO_ERROR, ERROR, "a file that is named cannot be read")

// The container of .glb files.
#define CLAST_GLB_FAULT_LIST(X) \
    X(GLB_CHUNK_LENGTH_UNALIGNED, ERROR, "the length of a chunk is no multiple of 4") \
    X(GLB_CHUNK_TOO_BIG, ERROR, "a chunk does not fit into the declared length") \
    X(GLB_DUPLICATE_CHUNK, ERROR, "a second chunk of a type that comes once") \
    X(GLB_EMPTY_BIN_CHUNK, INFORMATION, "an empty BIN chunk, which should be left out") \
    X(GLB_EMPTY_CHUNK, ERROR, "the JSON chunk is empty") \
    X(GLB_EXTRA_DATA, WARNING, "data after the declared length") \
    X(GLB_INVALID_MAGIC, ERROR, "the file does not begin with glTF") \
    X(GLB_INVALID_VERSION, ERROR, "the version of the container is not 2") \
    X(GLB_LENGTH_MISMATCH, ERROR, "the declared length is not that of the file") \
    X(GLB_LENGTH_TOO_SMALL, ERROR, "the declared length has no room for a chunk") \
    X(GLB_UNEXPECTED_BIN_CHUNK, ERROR, "the BIN chunk is not the second") \
    X(GLB_UNEXPECTED_END_OF_CHUNK_DATA, ERROR, "the file ends inside a chunk") \
    X(GLB_UNEXPECTED_END_OF_CHUNK_HEADER, ERROR, "the file ends inside the header of a chunk") \
    X(GLB_UNEXPECTED_END_OF_HEADER, ERROR, "the file ends inside its header") \
    X(GLB_UNEXPECTED_FIRST_CHUNK, ERROR, "the first chunk is not JSON") \
    X(GLB_UNKNOWN_CHUNK_TYPE, WARNING, "a chunk of an unknown type")

// The form of the JSON.
#define CLAST_SCHEMA_FAULT_LIST(X) \
    X(ARRAY_LENGTH_NOT_IN_LIST, ERROR, "an array of a length that is not allowed there") \
    X(ARRAY_TYPE_MISMATCH, ERROR, "an element of another type than expected") \
    X(DUPLICATE_ELEMENTS, ERROR, "an element occurs twice in a list that names each once") \
    X(EMPTY_ENTITY, ERROR, "an array or object that may not be empty is") \
    X(INVALID_INDEX, ERROR, "an index is negative") \
    X(INVALID_JSON, ERROR, "the JSON cannot be parsed") \
    X(INVALID_URI, ERROR, "a URI breaks the rules of URIs") \
    X(ONE_OF_MISMATCH, ERROR, "not exactly one of some properties is there") \
    X(PATTERN_MISMATCH, ERROR, "a text has not the form that it must have") \
    X(TYPE_MISMATCH, ERROR, "a property of another type than expected") \
    X(UNDEFINED_PROPERTY, ERROR, "a property that must be there is missing") \
    X(UNEXPECTED_PROPERTY, WARNING, "a property that the specification does not know") \
    X(UNSATISFIED_DEPENDENCY, ERROR, "a property that needs another one, which is missing") \
    X(VALUE_MULTIPLE_OF, ERROR, "a number is no multiple of what it must be one of") \
    X(VALUE_NOT_IN_LIST, WARNING, "a value that is none of those defined") \
    X(VALUE_NOT_IN_RANGE, ERROR, "a number is out of range")

// What single objects mean.
#define CLAST_SEMANTIC_FAULT_LIST(X) \
    X(ACCESSOR_MATRIX_ALIGNMENT, ERROR, "a matrix accessor's offset is no multiple of 4") \
    X(ACCESSOR_NORMALIZED_INVALID, ERROR, "floats or 32-bit integers are declared normalised") \
    X(ACCESSOR_OFFSET_ALIGNMENT, ERROR, "an offset is no multiple of the component's size") \
    X(ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE, ERROR, "more elements are replaced than there are") \
    X(ANIMATION_CHANNEL_TARGET_NODE_SKIN, WARNING, "the animated transform of a skinned mesh has no effect") \
    X(ASSET_MIN_VERSION_GREATER_THAN_VERSION, ERROR, "minVersion is above version") \
    X(BUFFER_DATA_URI_MIME_TYPE_INVALID, ERROR, "the media type of a buffer's data URI is not one of buffers") \
    X(BUFFER_VIEW_INVALID_BYTE_STRIDE, ERROR, "byteStride in a view that holds no vertices") \
    X(BUFFER_VIEW_TOO_BIG_BYTE_STRIDE, ERROR, "byteStride is above byteLength") \
    X(CAMERA_XMAG_YMAG_NEGATIVE, WARNING, "a negative magnification") \
    X(CAMERA_XMAG_YMAG_ZERO, ERROR, "a magnification of zero") \
    X(CAMERA_YFOV_GEQUAL_PI, WARNING, "a field of view of half a turn or more") \
    X(CAMERA_ZFAR_LEQUAL_ZNEAR, ERROR, "the far plane is not behind the near one") \
    X(EXTRA_PROPERTY, INFORMATION, "a property without effect there") \
    X(INVALID_EXTENSION_NAME_FORMAT, WARNING, "an extension's name lacks a prefix") \
    X(INVALID_GL_VALUE, ERROR, "a bound does not fit the component's type") \
    X(KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE, ERROR, "a channel with a pointer has a node too") \
    X(KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH, ERROR, \
      "the path of a channel with a pointer is not pointer") \
    X(KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES, ERROR, "a spot's outer angle is not above its inner one") \
    X(KHR_MATERIALS_ANISOTROPY_ANISOTROPY_TEXTURE_TEXCOORD, WARNING, \
      "the normal and anisotropy textures have different coordinates") \
    X(KHR_MATERIALS_DISPERSION_NO_VOLUME, WARNING, "dispersion without a volume") \
    X(KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT, ERROR, "a variant is mapped twice for a primitive") \
    X(KHR_MATERIALS_VOLUME_DOUBLE_SIDED, WARNING, "a volume's material is double sided") \
    X(KHR_MATERIALS_VOLUME_NO_TRANSMISSION, WARNING, "a volume that no light enters") \
    X(MATERIAL_ALPHA_CUTOFF_INVALID_MODE, WARNING, "an alpha cutoff without the mode MASK") \
    X(MESH_INVALID_WEIGHTS_COUNT, ERROR, "not one weight for each morph target") \
    X(MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT, ERROR, "primitives of a mesh have different numbers of morph targets") \
    X(MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY, ERROR, "numbered attributes do not count from 0 without a gap") \
    X(MESH_PRIMITIVE_INVALID_ATTRIBUTE, ERROR, "no such attribute is defined, and the name has no underscore first") \
    X(MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH, ERROR, "not as many sets of joints as of weights") \
    X(MESH_PRIMITIVE_NO_POSITION, WARNING, "a primitive without positions") \
    X(MESH_PRIMITIVE_TANGENT_WITHOUT_NORMAL, WARNING, "tangents without normals") \
    X(NODE_EMPTY, INFORMATION, "a node without content") \
    X(NODE_MATRIX_DEFAULT, INFORMATION, "an identity matrix, which should be left out") \
    X(NODE_MATRIX_NON_TRS, ERROR, "a matrix that is no translation, rotation and scale") \
    X(NODE_MATRIX_TRS, ERROR, "a matrix beside translation, rotation or scale") \
    X(NODE_SKINNED_MESH_LOCAL_TRANSFORMS, WARNING, "the transform of a skinned mesh has no effect") \
    X(NODE_SKINNED_MESH_PARENT_TRANSFORMS, WARNING, "the transforms above a skinned mesh have no effect") \
    X(NODE_SKIN_NO_SCENE, ERROR, "a skinned mesh is in a scene without its joints") \
    X(NON_OBJECT_EXTRAS, INFORMATION, "extras that are no object") \
    X(NON_RELATIVE_URI, WARNING, "a URI that is not relative") \
    X(NON_REQUIRED_EXTENSION, ERROR, "an extension that cannot be optional is not required") \
    X(ROTATION_NON_UNIT, ERROR, "a rotation that is not of unit length") \
    X(SKIN_NO_COMMON_ROOT, ERROR, "the joints have no common root") \
    X(SKIN_SKELETON_INVALID, ERROR, "the skeleton is not above all joints") \
    X(UNKNOWN_ASSET_MAJOR_VERSION, ERROR, "a major version other than 2") \
    X(UNKNOWN_ASSET_MINOR_VERSION, WARNING, "a minor version above 0") \
    X(UNUSED_EXTENSION_REQUIRED, ERROR, "an extension is required and not declared as used")

// How objects refer to each other.
#define CLAST_LINK_FAULT_LIST(X) \
    X(ACCESSOR_SMALL_BYTESTRIDE, ERROR, "a stride below the size of an element") \
    X(ACCESSOR_TOO_LONG, ERROR, "an accessor reaches beyond its view") \
    X(ACCESSOR_TOTAL_OFFSET_ALIGNMENT, ERROR, "the offset in the buffer is no multiple of the component's size") \
    X(ACCESSOR_USAGE_OVERRIDE, ERROR, "an accessor is used for two purposes that exclude each other") \
    X(ANIMATION_CHANNEL_TARGET_NODE_MATRIX, ERROR, "an animated node has a matrix") \
    X(ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS, ERROR, "animated weights of a mesh without morph targets") \
    X(ANIMATION_DUPLICATE_TARGETS, ERROR, "two channels animate the same") \
    X(ANIMATION_SAMPLER_ACCESSOR_WITH_BYTESTRIDE, ERROR, "key frames in a view with byteStride") \
    X(ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT, ERROR, "times that are not single floats") \
    X(ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS, ERROR, "too few key frames for the interpolation") \
    X(ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS, ERROR, "times without min and max") \
    X(ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT, ERROR, "not as many values as the times need") \
    X(ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT, ERROR, "values of a type that the path does not take") \
    X(BUFFER_MISSING_GLB_DATA, ERROR, "a buffer without URI in a .glb file without BIN chunk") \
    X(BUFFER_VIEW_TARGET_MISSING, HINT, "a view of vertices or indices without target") \
    X(BUFFER_VIEW_TARGET_OVERRIDE, ERROR, "a view is used for two purposes that exclude each other") \
    X(BUFFER_VIEW_TOO_LONG, ERROR, "a view reaches beyond its buffer") \
    X(IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE, ERROR, "an image in a view with byteStride") \
    X(INVALID_IBM_ACCESSOR_COUNT, ERROR, "fewer inverse bind matrices than joints") \
    X(MESH_PRIMITIVE_ACCESSOR_UNALIGNED, ERROR, "vertices that are not aligned to 4 bytes") \
    X(MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE, ERROR, "attributes share a view without byteStride") \
    X(MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT, ERROR, "an attribute of a type that its name does not take") \
    X(MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT, ERROR, "an attribute of 32-bit integers") \
    X(MESH_PRIMITIVE_GENERATED_TANGENT_SPACE, WARNING, "a normal texture without normals and tangents") \
    X(MESH_PRIMITIVE_INCOMPATIBLE_MODE, WARNING, "a number of vertices that the mode leaves a rest of") \
    X(MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT, ERROR, "indices that are not single unsigned integers") \
    X(MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE, ERROR, "indices in a view with byteStride") \
    X(MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT, ERROR, "a morph target of another number of vertices") \
    X(MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR, ERROR, "a morph target of an attribute that is not there") \
    X(MESH_PRIMITIVE_NO_TANGENT_SPACE, ERROR, "a material needs tangents that can neither be read nor made") \
    X(MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS, ERROR, "positions without min and max") \
    X(MESH_PRIMITIVE_TOO_FEW_TEXCOORDS, ERROR, "a material needs texture coordinates that are not there") \
    X(MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT, ERROR, "attributes of different numbers of vertices") \
    X(NODE_LOOP, ERROR, "a node is below itself") \
    X(NODE_PARENT_OVERRIDE, ERROR, "a node has two parents") \
    X(NODE_SKINNED_MESH_NON_ROOT, INFORMATION, "a skinned mesh is not at the root") \
    X(NODE_SKINNED_MESH_WITHOUT_SKIN, WARNING, "a mesh with joints on a node without skin") \
    X(NODE_SKIN_WITH_NON_SKINNED_MESH, ERROR, "a skin on a node whose mesh has no joints") \
    X(NODE_WEIGHTS_INVALID, ERROR, "not one weight for each morph target of the mesh") \
    X(SCENE_NON_ROOT_NODE, ERROR, "a scene names a node that has a parent") \
    X(SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE, ERROR, "inverse bind matrices in a view with byteStride") \
    X(SKIN_IBM_INVALID_FORMAT, ERROR, "inverse bind matrices that are not 4 x 4 floats") \
    X(UNDECLARED_EXTENSION, ERROR, "an extension that extensionsUsed does not name") \
    X(UNEXPECTED_EXTENSION_OBJECT, ERROR, "an extension where it is not defined") \
    X(UNRESOLVED_REFERENCE, ERROR, "an index of something that is not there") \
    X(UNSUPPORTED_EXTENSION, INFORMATION, "an extension that is not checked") \
    X(UNUSED_MESH_TANGENT, INFORMATION, "tangents that no normal texture uses") \
    X(UNUSED_MESH_WEIGHTS, INFORMATION, "weights that every node overrides") \
    X(UNUSED_OBJECT, INFORMATION, "an object that nothing refers to")

// What buffers and images hold.
#define CLAST_DATA_FAULT_LIST(X) \
    X(ACCESSOR_ANIMATION_INPUT_NEGATIVE, ERROR, "a negative time") \
    X(ACCESSOR_ANIMATION_INPUT_NON_INCREASING, ERROR, "times that do not grow") \
    X(ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION, ERROR, "an animated rotation not of unit length") \
    X(ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND, ERROR, "elements above the declared maximum") \
    X(ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND, ERROR, "elements below the declared minimum") \
    X(ACCESSOR_INDEX_OOB, ERROR, "an index of a vertex that is not there") \
    X(ACCESSOR_INDEX_PRIMITIVE_RESTART, ERROR, "an index that restarts a primitive") \
    X(ACCESSOR_INDEX_TRIANGLE_DEGENERATE, INFORMATION, "triangles that name a vertex twice") \
    X(ACCESSOR_INVALID_FLOAT, ERROR, "a float that is infinite or no number") \
    X(ACCESSOR_INVALID_IBM, ERROR, "an inverse bind matrix whose last row is not 0 0 0 1") \
    X(ACCESSOR_INVALID_SIGN, ERROR, "a tangent whose sign is neither 1 nor -1") \
    X(ACCESSOR_JOINTS_INDEX_DUPLICATE, ERROR, "a vertex names a joint twice") \
    X(ACCESSOR_JOINTS_INDEX_OOB, ERROR, "a vertex names a joint that the skin has not") \
    X(ACCESSOR_JOINTS_USED_ZERO_WEIGHT, WARNING, "a joint other than 0 with a weight of zero") \
    X(ACCESSOR_MAX_MISMATCH, ERROR, "the declared maximum is not the largest element") \
    X(ACCESSOR_MIN_MISMATCH, ERROR, "the declared minimum is not the smallest element") \
    X(ACCESSOR_NON_CLAMPED, ERROR, "a colour outside 0 to 1") \
    X(ACCESSOR_SPARSE_INDEX_OOB, ERROR, "an element that is not there is replaced") \
    X(ACCESSOR_SPARSE_INDICES_NON_INCREASING, ERROR, "the indices of replaced elements do not grow") \
    X(ACCESSOR_VECTOR3_NON_UNIT, ERROR, "a normal or tangent that is not of unit length") \
    X(ACCESSOR_WEIGHTS_NEGATIVE, ERROR, "a negative weight of a joint") \
    X(ACCESSOR_WEIGHTS_NON_NORMALIZED, ERROR, "weights of joints that do not add up to 1") \
    X(BUFFER_EMBEDDED_BYTELENGTH_MISMATCH, ERROR, "a data URI of another length than byteLength") \
    X(BUFFER_EXTERNAL_BYTELENGTH_MISMATCH, ERROR, "fewer bytes than byteLength") \
    X(BUFFER_GLB_CHUNK_TOO_BIG, WARNING, "the BIN chunk is longer than byteLength needs") \
    X(DATA_URI_GLB, WARNING, "a data URI in a .glb file") \
    X(IMAGE_DATA_INVALID, ERROR, "an image that cannot be decoded") \
    X(IMAGE_MIME_TYPE_INVALID, ERROR, "an image of another type than declared") \
    X(IMAGE_NON_ENABLED_MIME_TYPE, ERROR, "a type of image that needs an extension") \
    X(IMAGE_NPOT_DIMENSIONS, INFORMATION, "an image whose sides are no powers of two") \
    X(IMAGE_UNRECOGNIZED_FORMAT, WARNING, "an image of no known type")

#define CLAST_FAULT_LIST(X) \
    CLAST_FILE_FAULT_LIST(X) \
    CLAST_GLB_FAULT_LIST(X) \
    CLAST_SCHEMA_FAULT_LIST(X) \
    CLAST_SEMANTIC_FAULT_LIST(X) \
    CLAST_LINK_FAULT_LIST(X) \
    CLAST_DATA_FAULT_LIST(X)

#define CLAST_FAULT_ENUMERATOR(code, severity, meaning) CLAST_FAULT_##code,
typedef enum clast_fault_code { CLAST_FAULT_LIST(CLAST_FAULT_ENUMERATOR) CLAST_FAULT_COUNT } clast_fault_code;

#endif
