// SPDX-License-Identifier: Apache-2.0
// The validator, on glTF as text or binary: it looks at what readers leave alone.
#include "clast/validate.h"
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    clast_validation *validation = NULL;
    const char *name = size > 4 && memcmp(data, "glTF", 4) == 0 ? "input.glb" : "input.gltf";
    fuzz_put_file(name, data, size);
    if (clast_validate(context, name, &validation) == CLAST_OK) {
        size_t count = clast_validation_fault_count(validation);
        for (size_t i = 0; i < count; i++) {
            const clast_fault *fault = clast_validation_fault(validation, i);
            FUZZ_CHECK(fault->code != NULL && fault->text != NULL && strchr(fault->text, '\n') == NULL);
        }
        clast_validation_destroy(validation);
    }
}
