/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CLAST_VERSION_H
#define CLAST_VERSION_H

#include "clast/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* CMake reads the version from these lines. */
#define CLAST_VERSION_MAJOR 0
#define CLAST_VERSION_MINOR 1
#define CLAST_VERSION_PATCH 0

/** The version of the library that runs, as "0.1.0". */
CLAST_API const char *clast_version(void);

#ifdef __cplusplus
}
#endif

#endif
