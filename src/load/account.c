// SPDX-License-Identifier: Apache-2.0
#include "load/account.h"

clast_status clast_account_make(clast_scene *scene, const char *name, uint64_t count, uint64_t size)
{
    uint64_t most = clast_unpacked_most(scene->stored_bytes),
             left = most - scene->made_bytes; // made before: within the bound
    if (count != 0 && size > left / count) {
        return clast_fail(scene->context, CLAST_ERROR_LIMIT,
                          "%s: %llu elements of %llu bytes more than the %llu that files of %llu bytes may come to",
                          name, (unsigned long long)count, (unsigned long long)size, (unsigned long long)most,
                          (unsigned long long)scene->stored_bytes);
    }
    scene->made_bytes += count * size;
    return CLAST_OK;
}
