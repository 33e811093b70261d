// SPDX-License-Identifier: Apache-2.0
// How given surfaces scatter light, for tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "render/scatter.glsl"
layout(local_size_x = 64) in;

struct scatter_question
{
    uint material;
    clast_bsdf_input surface;
    float alpha_floor;
    packed3 view, light;
    packed2 square;
    float lobe;
};

struct scatter_answer
{
    clast_bsdf bsdf;
    clast_brdf_answer value;
    clast_bsdf_sample direction;
};

ARRAY_OF(scatter_questions, scatter_question, 4)
ARRAY_OF(scatter_answers, scatter_answer, 4)

layout(push_constant, scalar) uniform clast_scatter_probe
{
    uint64_t materials, questions, answers;
    uint count;
}
push;

void main()
{
    uint number = linear_group() * 64u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    scatter_question question = scatter_questions(push.questions).at[number];
    vec3 view = load3(question.view);
    scatter_answer answer;
    answer.bsdf = scatter_make(materials_reference(push.materials), question.material, question.surface,
                               question.alpha_floor, view);
    answer.value = bsdf_evaluate(answer.bsdf, view, load3(question.light));
    answer.direction = bsdf_direction(answer.bsdf, view, load2(question.square), question.lobe);
    scatter_answers(push.answers).at[number] = answer;
}
