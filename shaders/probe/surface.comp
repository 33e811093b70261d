// SPDX-License-Identifier: Apache-2.0
// Surfaces of given hits, and what alpha decides of them, for tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "render/alpha.glsl"
layout(local_size_x = 64) in;

struct surface_question
{
    clast_visibility seen;
    packed3 origin, direction; // of the ray
    clast_ray_cone cone;
    uint look;
};

struct surface_answer
{
    packed3 position, geometric_normal, normal;
    float offset;
    clast_basis frame;
    clast_bsdf_input surface;
    packed3 absorption, emission;
    packed2 coordinates;
    clast_ray_cone cone;
    float bend;
    uint unlit, material, frame_instance, primitive;
    uint accepts, accepts_by_chance, hidden_back;
};

ARRAY_OF(surface_questions, surface_question, 4)
ARRAY_OF(surface_answers, surface_answer, 4)

layout(push_constant, scalar) uniform clast_surface_probe
{
    uint64_t frame, materials, questions, answers;
    uint count;
}
push;

void main()
{
    uint number = linear_group() * 64u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    frame_reference frame = frame_reference(push.frame);
    materials_reference all = materials_reference(push.materials);
    surface_question question = surface_questions(push.questions).at[number];
    clast_visibility seen = question.seen;
    vec3 origin = load3(question.origin);
    vec3 direction = load3(question.direction);
    finding_ray ray;
    ray.direction = direction;
    ray.cone = question.cone;
    ray.look = question.look;
    shading_point point = surface_of_hit(frame, all, seen, ray);
    surface_answer answer;
    answer.position = store3(point.position);
    answer.geometric_normal = store3(point.geometric_normal);
    answer.normal = store3(point.normal);
    answer.offset = point.offset;
    answer.frame = point.frame;
    answer.surface = point.surface;
    answer.absorption = store3(point.absorption);
    answer.emission = store3(point.emission);
    answer.coordinates = store2(point.coordinates);
    answer.cone = point.cone;
    answer.bend = point.bend;
    answer.unlit = point.unlit ? 1u : 0u;
    answer.material = point.material;
    answer.frame_instance = point.frame_instance;
    answer.primitive = point.primitive;
    vec2 weights = load2(seen.barycentrics);
    hit_surface found = surface_of_candidate(frame, all, seen.instance, seen.cluster, seen.triangle, weights);
    answer.accepts = candidate_accepts(found) ? 1u : 0u;
    answer.accepts_by_chance = candidate_accepts_by_chance(found, origin, direction, seen.instance) ? 1u : 0u;
    answer.hidden_back = candidate_is_hidden_back(found, load3(seen.normal), direction) ? 1u : 0u;
    surface_answers(push.answers).at[number] = answer;
}
