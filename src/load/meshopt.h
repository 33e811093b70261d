// SPDX-License-Identifier: Apache-2.0
// Decoders for the streams of EXT_meshopt_compression and KHR_meshopt_compression (Khronos Group; appendix A of the latter
// describes the streams, appendix B the filters). They read nothing outside the stream and write exactly what is asked for,
// whatever the stream holds.
#ifndef CLAST_LOAD_MESHOPT_H
#define CLAST_LOAD_MESHOPT_H

#include "load/bytes.h"

// X(name, text): how a stream is made.
#define CLAST_MESHOPT_MODE_LIST(X) \
    X(CLAST_MESHOPT_ATTRIBUTES, "ATTRIBUTES") \
    X(CLAST_MESHOPT_TRIANGLES, "TRIANGLES") \
    X(CLAST_MESHOPT_INDICES, "INDICES")

// X(name, text): what is done to attributes after they are decoded.
#define CLAST_MESHOPT_FILTER_LIST(X) \
    X(CLAST_MESHOPT_NONE, "NONE") \
    X(CLAST_MESHOPT_OCTAHEDRAL, "OCTAHEDRAL") \
    X(CLAST_MESHOPT_QUATERNION, "QUATERNION") \
    X(CLAST_MESHOPT_EXPONENTIAL, "EXPONENTIAL") \
    X(CLAST_MESHOPT_COLOUR, "COLOR")

#define CLAST_MESHOPT_ENUMERATOR(name, text) name,
typedef enum clast_meshopt_mode { CLAST_MESHOPT_MODE_LIST(CLAST_MESHOPT_ENUMERATOR) } clast_meshopt_mode;
typedef enum clast_meshopt_filter { CLAST_MESHOPT_FILTER_LIST(CLAST_MESHOPT_ENUMERATOR) } clast_meshopt_filter;

typedef struct clast_meshopt_stream {
    clast_meshopt_mode mode;
    clast_meshopt_filter filter;
    uint64_t count;  // of elements
    uint32_t stride; // bytes of an element
    bool version_1;  // streams of version 1 and the filter COLOR are allowed: only the KHR extension has them
} clast_meshopt_stream;

// The rules that mode, filter, count and stride obey together; null where they do, else what was expected.
const char *clast_meshopt_check(const clast_meshopt_stream *stream);
// Decodes into count * stride bytes, aligned to 4, and applies the filter. The stream has passed the check. Gives null, or
// what is wrong with the stream; the bytes are undefined then.
const char *clast_meshopt_decode(const clast_meshopt_stream *stream, clast_bytes bytes, unsigned char *decoded);
// Applies the filter to decoded attributes.
void clast_meshopt_apply_filter(const clast_meshopt_stream *stream, unsigned char *decoded);

#endif
