/* SPDX-License-Identifier: Apache-2.0
 *
 * What is wrong with a file: every fault with a code, a place and a severity.
 */
#ifndef CLAST_VALIDATE_H
#define CLAST_VALIDATE_H

#include "clast/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum clast_severity {
    CLAST_SEVERITY_LIST(CLAST_ENUMERATOR) CLAST_SEVERITY_COUNT /**< how many there are */
} clast_severity;

/** A fault. docs/validate.md lists the codes. */
typedef struct clast_fault {
    clast_severity severity;
    const char *code;    /**< as "ACCESSOR_TOO_LONG" */
    const char *pointer; /**< a JSON pointer (RFC 6901) into the file's JSON; null where the place is none of it */
    uint64_t offset;     /**< of a byte of the file, where `pointer` is null; 0 where the whole file is meant */
    const char *text;    /**< one line */
} clast_fault;

typedef struct clast_validation clast_validation;

/** Looks for every fault of a file. glTF 2.0 (.gltf, .glb) is checked against the whole specification, the buffers' contents and
 *  images included; of any other file that clast reads, the reader's error is the one fault. Files that a glTF file names are
 *  looked for beside it. A file with faults is no error of the call. Errors: INVALID_ARGUMENT, FILE_NOT_FOUND, FILE_READ,
 *  OUT_OF_MEMORY, LIMIT. `validation` is for clast_validation_destroy; it lives no longer than its context. */
CLAST_API clast_status clast_validate(clast_context *context, const char *path, clast_validation **validation);
CLAST_API void clast_validation_destroy(clast_validation *validation);

/** How many faults of each severity there are, those beyond the list included. */
CLAST_API void clast_validation_count(const clast_validation *validation, uint64_t counts[CLAST_SEVERITY_COUNT]);
/** How many faults are listed: the first 10,000. */
CLAST_API size_t clast_validation_fault_count(const clast_validation *validation);
/** A listed fault, in the order of finding; null where there is none of that number. Valid until the destroy. */
CLAST_API const clast_fault *clast_validation_fault(const clast_validation *validation, size_t number);

#ifdef __cplusplus
}
#endif

#endif
