// SPDX-License-Identifier: Apache-2.0
// What lights send to given points, for tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "render/lights.glsl"
layout(local_size_x = 64) in;

struct lights_question
{
    packed3 position, geometric_normal, normal, direction;
    packed2 square, sun_square;
    float choice, distance, cosine;
    uint instance, primitive, passes;
};

struct lights_answer
{
    clast_light_shares shares;
    clast_light_sample light, sun;
    packed3 distant_radiance;
    float distant_density;
    float emitter_density;
};

ARRAY_OF(lights_questions, lights_question, 4)
ARRAY_OF(lights_answers, lights_answer, 4)

layout(push_constant, scalar) uniform clast_lights_probe
{
    uint64_t frame, materials, lights, questions, answers;
    uint count;
}
push;

void main()
{
    uint number = linear_group() * 64u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    lights_question question = lights_questions(push.questions).at[number];
    light_room room =
        light_room(frame_reference(push.frame), materials_reference(push.materials), lights_reference(push.lights));
    vec3 position = load3(question.position);
    vec3 direction = load3(question.direction);
    lights_answer answer;
    clast_lit_point point = lit_point(position, load3(question.normal), question.passes != 0u);
    answer.shares = lights_share(room.lights, point, load3(question.geometric_normal), load3(question.normal));
    answer.light = lights_sample(room, answer.shares, point, false, question.choice, load2(question.square));
    answer.sun = lights_sample(room, answer.shares, point, true, 0.0f, load2(question.sun_square));
    answer.distant_radiance = store3(distant_radiance(room, direction));
    answer.distant_density = distant_density(room.lights, answer.shares, direction);
    answer.emitter_density = emitter_density_at(room.lights, answer.shares.tree, point, question.instance,
                                                question.primitive, question.distance, question.cosine);
    lights_answers(push.answers).at[number] = answer;
}
