/* SPDX-License-Identifier: Apache-2.0
 *
 * All of clast.
 */
#ifndef CLAST_CLAST_H
#define CLAST_CLAST_H

#include "clast/accel.h"
#include "clast/animation.h"
#include "clast/context.h"
#include "clast/deform.h"
#include "clast/export.h"
#include "clast/generate.h"
#include "clast/geometry.h"
#include "clast/image.h"
#include "clast/render.h"
#include "clast/scene.h"
#include "clast/status.h"
#include "clast/validate.h"
#include "clast/version.h"

#endif
