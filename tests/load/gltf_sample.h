// SPDX-License-Identifier: Apache-2.0
// A glTF file that uses everything the reader reads, written with ' for ", and the files that it names.
#ifndef CLAST_TESTS_LOAD_GLTF_SAMPLE_H
#define CLAST_TESTS_LOAD_GLTF_SAMPLE_H

#include "memory_files.h"

static const char SAMPLE[] =
    "{'asset':{'version':'2.0','minVersion':'2.0'},'extensionsUsed':['KHR_lights_punctual'],'extensionsRequired':['KHR_mesh_quantization'],"
    "'scene':0,'scenes':[{'nodes':[0,3]}],"
    "'nodes':[{'mesh':0,'children':[1,2],'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},"
    "{'mesh':1,'translation':[1,2,3],'rotation':[0,0,0,1],'scale':[1,1,1],'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':0}}}},"
    "{'camera':0,'extensions':{'KHR_lights_punctual':{'light':0}}},{'mesh':1,'skin':0,'camera':1,'weights':[0.5]},{'name':'joint'}],"
    "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1,'zfar':10}},{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'znear':0,'zfar':1}}],"
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','color':[1,1,1],'intensity':2,'range':3,'spot':{'innerConeAngle':0.1,'outerConeAngle':0.2}}]}},"
    "'skins':[{'joints':[4],'inverseBindMatrices':8}],"
    "'meshes':[{'name':'first','weights':[0.25],'primitives':[{'attributes':{'POSITION':0,'NORMAL':0,'TEXCOORD_0':2,'COLOR_0':3},'indices':1,'material':0,'mode':4,'targets':[{'POSITION':0}]}]},"
    "{'weights':[0.5],'primitives':[{'attributes':{'POSITION':4,'TEXCOORD_1':2,'JOINTS_0':6,'WEIGHTS_0':7},'material':1,'mode':5,"
    "'targets':[{'POSITION':0,'NORMAL':0}]},{'attributes':{'POSITION':5},'mode':6,'targets':[{'POSITION':5}]}]}],"
    "'materials':[{'name':'m','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,1],'metallicFactor':0,'roughnessFactor':1,'baseColorTexture':{'index':0,'texCoord':0}},"
    "'normalTexture':{'index':1,'scale':1,'texCoord':0},'alphaMode':'MASK','alphaCutoff':0.5,'doubleSided':true},"
    "{'emissiveFactor':[1,1,1],'occlusionTexture':{'index':0,'strength':1,'texCoord':1,'extensions':{'KHR_texture_transform':{'offset':[0,0],'scale':[1,1],'rotation':0,'texCoord':1}}},"
    "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':2}}}],"
    "'textures':[{'source':0,'sampler':0},{'source':1}],'samplers':[{'magFilter':9728,'minFilter':9987,'wrapS':33071,'wrapT':33648}],"
    "'images':[{'bufferView':2,'mimeType':'image/png'},{'uri':'pixel.png'}],"
    "'buffers':[{'uri':'data.bin','byteLength':300},{'byteLength':36,'uri':'data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}],"
    "'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':64,'byteStride':8},{'buffer':0,'byteOffset':128,'byteLength':67},"
    "{'buffer':1,'byteLength':36},{'buffer':0,'byteOffset':100,'byteLength':12},{'buffer':0,'byteOffset':200,'byteLength':64}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','min':[0,0,0],'max':[1,1,0]},"
    "{'bufferView':4,'byteOffset':6,'componentType':5123,'count':3,'type':'SCALAR'},{'bufferView':1,'componentType':5126,'count':3,'type':'VEC2'},"
    "{'bufferView':1,'componentType':5121,'normalized':true,'count':3,'type':'VEC4'},"
    "{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':2,'indices':{'bufferView':4,'componentType':5121},'values':{'bufferView':0,'byteOffset':12}}},"
    "{'bufferView':3,'componentType':5126,'count':3,'type':'VEC3'},{'bufferView':1,'byteOffset':32,'componentType':5121,'count':3,'type':'VEC4'},"
    "{'bufferView':1,'byteOffset':36,'componentType':5121,'normalized':true,'count':3,'type':'VEC4'},"
    "{'bufferView':5,'componentType':5126,'count':1,'type':'MAT4'}]}";

static const unsigned char PIXEL_PNG[67] = {
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
    0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81,
    0x77, 0xcd, 0x72, 0xb6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
};

// data.bin of the sample.
static unsigned char sample_bytes[300];

static inline void fill_sample_bytes(void)
{
    static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const unsigned char joints_and_weights[8] = {0, 0, 0, 0, 255, 0, 0, 0};
    memset(sample_bytes, 0, sizeof sample_bytes);
    memcpy(sample_bytes, triangle, sizeof triangle);
    for (int i = 0; i < 4; i++) {
        memcpy(sample_bytes + 68 + 8 * i, joints_and_weights, 8);
    }
    memcpy(sample_bytes + 100, (unsigned char[]){0, 2, 0, 0, 0, 0, 0, 0, 1, 0, 2, 0}, 12);
    memcpy(sample_bytes + 128, PIXEL_PNG, sizeof PIXEL_PNG);
    memcpy(sample_bytes + 200, identity, sizeof identity);
}

static inline void put_sample(memory_files *files)
{
    fill_sample_bytes();
    memory_files_put(files, "data.bin", sample_bytes, sizeof sample_bytes);
    memory_files_put(files, "pixel.png", PIXEL_PNG, sizeof PIXEL_PNG);
}

#endif
