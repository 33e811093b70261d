// SPDX-License-Identifier: Apache-2.0
// Values of materials' textures at given coordinates, for tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "render/texture.glsl"
layout(local_size_x = 64) in;

struct texture_question
{
    uint material, slot, encoding, look;
    packed2 coordinates[2];
    clast_footprint footprints[2];
};

struct texture_answer
{
    packed4 value;
    float alpha;
};

ARRAY_OF(texture_questions, texture_question, 4)
ARRAY_OF(texture_answers, texture_answer, 4)

layout(push_constant, scalar) uniform clast_texture_probe
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
    materials_reference all = materials_reference(push.materials);
    texture_question question = texture_questions(push.questions).at[number];
    material_reference material = material_at(all, question.material);
    vec2 coordinates[2] = vec2[2](load2(question.coordinates[0]), load2(question.coordinates[1]));
    vec4 none = vec4(-1.0f, -2.0f, -3.0f, -4.0f);
    texture_area area;
    area.coordinates = coordinates;
    area.footprints = question.footprints;
    area.look = question.look;
    vec4 value = texture_value(all, material, question.slot, area, question.encoding, none);
    texture_answers(push.answers).at[number].value = store4(value);
    texture_answers(push.answers).at[number].alpha = texture_alpha(all, material, question.slot, coordinates);
}
