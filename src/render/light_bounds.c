// SPDX-License-Identifier: Apache-2.0
#include "render/light_bounds.h"

#include "base/thread.h"

static const double HALF_TURN = 3.14159265358979323846;

clast_light_box clast_light_no_box(void)
{
    return (clast_light_box){store3(splat3(INFINITY)), store3(splat3(-INFINITY))};
}

float clast_light_scale(const clast_light_sources *sources)
{
    int exponent;
    frexpf(sources->extent, &exponent);
    exponent = exponent < -100 ? -100 : exponent > 100 ? 100 : exponent;
    return ldexpf(1.0f, -exponent);
}

// --------------------------------------------------------------------------------------------------------------- items

typedef struct item_job {
    const clast_light_sources *sources;
    float scale;
    clast_light_item *items;
} item_job;

static float bounded_power(double power)
{
    return (float)(power > 1e-25 ? power < 1e25 ? power : 1e25 : 1e-25);
}

static clast_light_item emitter_item(const item_job *job, uint32_t number)
{
    const clast_emitter *emitter = &job->sources->emitters[number];
    vec3 corners[3];
    for (int k = 0; k < 3; k++) {
        corners[k] = load3(emitter->corners[k]) * job->scale;
    }
    double power = (double)job->sources->emitter_radiances[number] * (double)emitter->area * (double)job->scale *
                   (double)job->scale;
    return (clast_light_item){
        .box = {store3(min3(corners[0], min3(corners[1], corners[2]))),
                store3(max3(corners[0], max3(corners[1], corners[2])))},
        .axis = store3(normalize3(cross3(corners[1] - corners[0], corners[2] - corners[0]))),
        .power = bounded_power(power),
        .number = number,
        .two_sided = true,
    };
}

static void emitter_items(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const item_job *job = data;
    for (size_t i = begin; i < end; i++) {
        job->items[i] = emitter_item(job, (uint32_t)i);
    }
}

static bool has_cone(const clast_light *light)
{
    return light->type == CLAST_LIGHT_SPOT && is_finite3(load3(light->direction)) &&
           length3(load3(light->direction)) > 0.5f;
}

static bool shines_from_somewhere(const clast_light *light)
{
    float strength = light_strength(load3(light->radiance));
    return light->type != CLAST_LIGHT_DIRECTIONAL && strength > 0.0f && is_finite1(strength) &&
           is_finite3(load3(light->position));
}

uint32_t clast_light_items(clast_context *context, const clast_light_sources *sources, float scale,
                           clast_light_item *items)
{
    item_job job = {sources, scale, items};
    clast_parallel_for(context, sources->emitter_count, 4096, emitter_items, &job);
    uint32_t count = (uint32_t)sources->emitter_count;
    for (size_t i = 0; i < sources->punctual_count; i++) {
        const clast_light *light = &sources->punctual[i];
        if (!shines_from_somewhere(light)) {
            continue;
        }
        packed3 place = store3(load3(light->position) * scale);
        items[count++] = (clast_light_item){
            .box = {place, place},
            .axis = has_cone(light) ? light->direction : store3(splat3(0.0f)),
            .power = bounded_power((double)light_strength(load3(light->radiance)) * (double)scale * (double)scale),
            .number = (uint32_t)(sources->emitter_count + i),
        };
    }
    return count;
}

// -------------------------------------------------------------------------------------------------------------- covers

clast_light_cover clast_light_cover_of(const clast_light_sources *sources, const clast_light_item *item, float scale)
{
    clast_light_cover cover = {.box = item->box,
                               .axis = {1.0, 0.0, 0.0},
                               .spread = HALF_TURN,
                               .emission = 0.5 * HALF_TURN,
                               .power = (double)item->power,
                               .two_sided = item->two_sided};
    const float *v = item->axis.v;
    double x = (double)v[0], y = (double)v[1], z = (double)v[2], length = sqrt(x * x + y * y + z * z);
    bool is_directed = length > 0.5;
    if (is_directed) {
        cover.axis[0] = x / length;
        cover.axis[1] = y / length;
        cover.axis[2] = z / length;
    }
    if (item->number < sources->emitter_count) {
        cover.spread = is_directed ? 0.0 : HALF_TURN;
        return cover;
    }
    const clast_light *light = &sources->punctual[item->number - sources->emitter_count];
    cover.reach = is_finite1(light->range) ? light->range * scale : 0.0f;
    if (is_directed) {
        double inner = acos((double)clamp1(light->inner_cosine, -1.0f, 1.0f)),
               outer = acos((double)clamp1(light->outer_cosine, -1.0f, 1.0f));
        cover.spread = inner < outer ? inner : outer;
        cover.emission = outer - cover.spread + 1e-3;
    }
    return cover;
}

// The angle between unit vectors, also where it is small.
static double angle_between(const double a[3], const double b[3])
{
    double sum = 0.0, difference = 0.0;
    for (int k = 0; k < 3; k++) {
        sum += (a[k] + b[k]) * (a[k] + b[k]);
        difference += (a[k] - b[k]) * (a[k] - b[k]);
    }
    return 2.0 * atan2(sqrt(difference), sqrt(sum));
}

// The narrowest cone around two: Physically Based Rendering, fourth edition, section 3.8.4.
static void join_cones(clast_light_cover *cover, const clast_light_cover *other)
{
    double axis[3], dot = 0.0;
    for (int k = 0; k < 3; k++) {
        dot += cover->axis[k] * other->axis[k];
    }
    double side = (cover->two_sided || other->two_sided) && dot < 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 3; k++) {
        axis[k] = other->axis[k] * side;
    }
    double apart = angle_between(cover->axis, axis);
    if (apart + other->spread <= cover->spread) {
        return;
    }
    if (apart + cover->spread <= other->spread) {
        memcpy(cover->axis, axis, sizeof axis);
        cover->spread = other->spread;
        return;
    }
    double spread = 0.5 * (cover->spread + apart + other->spread), turn = spread - cover->spread, sine = sin(apart);
    if (spread >= HALF_TURN || sine < 1e-9) {
        cover->spread = sine < 1e-9 && apart < 1.0
                            ? (cover->spread > other->spread ? cover->spread : other->spread) + 1e-8
                            : HALF_TURN;
        return;
    }
    double length = 0.0;
    for (int k = 0; k < 3; k++) {
        cover->axis[k] = (sin(apart - turn) * cover->axis[k] + sin(turn) * axis[k]) / sine;
        length += cover->axis[k] * cover->axis[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; k++) {
        cover->axis[k] /= length;
    }
    cover->spread = spread + 1e-9;
}

void clast_light_cover_add(clast_light_cover *cover, const clast_light_cover *other)
{
    join_cones(cover, other);
    cover->box.lower = store3(min3(load3(cover->box.lower), load3(other->box.lower)));
    cover->box.upper = store3(max3(load3(cover->box.upper), load3(other->box.upper)));
    cover->emission = cover->emission > other->emission ? cover->emission : other->emission;
    cover->power += other->power;
    bool endless = cover->reach == 0.0f || other->reach == 0.0f;
    cover->reach = endless ? 0.0f : max1(cover->reach, other->reach);
    cover->two_sided = cover->two_sided || other->two_sided;
}

// -------------------------------------------------------------------------------------------------------------- packing

// The largest code whose cosine is not above that of the angle.
static uint32_t cosine_code(double angle, uint32_t most, float (*decode)(uint32_t bits), uint32_t shift)
{
    double cosine = angle < HALF_TURN ? cos(angle) : -1.0;
    uint32_t code = (uint32_t)(0.5 * (cosine + 1.0) * most + 1.0);
    code = code < most ? code : most;
    while (code != 0 && (double)decode(code << shift) > cosine) {
        code--;
    }
    return code;
}

static uint32_t reach_code(float reach)
{
    uint32_t code = 1;
    while (code < LIGHT_REACH_CODES && light_reach(code) < reach) {
        code++;
    }
    return reach > 0.0f && code < LIGHT_REACH_CODES ? code : 0;
}

clast_light_node clast_light_cover_pack(const clast_light_cover *cover, double total)
{
    double square = 0.0, rounding = 0.0;
    packed3 centre;
    for (int k = 0; k < 3; k++) {
        double lower = (double)cover->box.lower.v[k], upper = (double)cover->box.upper.v[k];
        centre.v[k] = (float)(0.5 * (lower + upper));
        square += 0.25 * (upper - lower) * (upper - lower);
        rounding += fabs((double)centre.v[k]) * 0x1p-23;
    }
    double radius = sqrt(square);
    clast_light_node node = {.centre = centre};
    node.radius = (float)((radius > 0.0 ? radius + rounding : 0.0) * (1.0 + 0x1p-20));
    node.power = max1((float)(cover->power / total), CLAST_LIGHT_POWER_LEAST);
    node.axis = pack_direction(vec3((float)cover->axis[0], (float)cover->axis[1], (float)cover->axis[2]));
    vec3 axis = unpack_direction(node.axis);
    const double kept[3] = {(double)axis[0], (double)axis[1], (double)axis[2]};
    node.bounds = light_node_bits(
        cosine_code(cover->spread + angle_between(cover->axis, kept) + 1e-6, 2047, light_node_spread, 0),
        cosine_code(cover->emission, 255, light_node_emission, 11), cover->two_sided, 0, reach_code(cover->reach));
    return node;
}
