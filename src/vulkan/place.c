// SPDX-License-Identifier: Apache-2.0
#include "vulkan/place.h"

enum { GROUP = 128 };

void clast_gpu_place_instances(clast_gpu_commands *commands, const clast_gpu_place *place)
{
    if (place->count != 0) {
        clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_PLACE,
                                                  .push = place,
                                                  .push_bytes = sizeof *place,
                                                  .groups = (place->count - 1) / GROUP + 1});
    }
}
