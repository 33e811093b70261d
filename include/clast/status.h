/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CLAST_STATUS_H
#define CLAST_STATUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "clast/lists.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__) && !defined(CLAST_STATIC)
#define CLAST_API __attribute__((visibility("default")))
#else
#define CLAST_API
#endif

#define CLAST_ENUMERATOR(name, value, ...) name = value,

typedef enum clast_status { CLAST_STATUS_LIST(CLAST_ENUMERATOR) } clast_status;
typedef enum clast_build { CLAST_BUILD_LIST(CLAST_ENUMERATOR) } clast_build;
typedef enum clast_isa { CLAST_ISA_AUTOMATIC = 0, CLAST_ISA_LIST(CLAST_ENUMERATOR) } clast_isa;
typedef enum clast_log_level { CLAST_LOG_LIST(CLAST_ENUMERATOR) } clast_log_level;

/** The one-line text of a status; never null, also for values that are none. */
CLAST_API const char *clast_status_text(clast_status status);

#ifdef __cplusplus
}
#endif

#endif
