// SPDX-License-Identifier: Apache-2.0
#include "clast/version.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

const char *clast_version(void)
{
    return TEXT(CLAST_VERSION_MAJOR) "." TEXT(CLAST_VERSION_MINOR) "." TEXT(CLAST_VERSION_PATCH);
}
