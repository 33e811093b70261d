// SPDX-License-Identifier: Apache-2.0
// Shared libraries opened at run time.
#ifndef CLAST_BASE_LIBRARY_H
#define CLAST_BASE_LIBRARY_H

typedef struct clast_library clast_library;
typedef void (*clast_library_function)(void);

// Null where there is no such library.
clast_library *clast_library_open(const char *name);
void clast_library_close(clast_library *library);
// Null where it has none of that name.
clast_library_function clast_library_find(clast_library *library, const char *name);

#endif
