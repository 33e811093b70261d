// SPDX-License-Identifier: Apache-2.0
#include "load_tinyobj.h"

#include <string>
#include <vector>

#include <tiny_obj_loader.h>

int tinyobj_load(const char *path)
{
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    return tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, path, nullptr, true);
}
