// SPDX-License-Identifier: Apache-2.0
#include "base/library.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

clast_library *clast_library_open(const char *name)
{
    return (clast_library *)dlopen(name, RTLD_NOW | RTLD_LOCAL);
}

void clast_library_close(clast_library *library)
{
    if (library != NULL) {
        dlclose(library);
    }
}

clast_library_function clast_library_find(clast_library *library, const char *name)
{
    // C has no conversion from an object's address to a function's: POSIX promises that the bits are the same.
    void *address = dlsym(library, name);
    clast_library_function function;
    memcpy(&function, &address, sizeof function);
    return function;
}
