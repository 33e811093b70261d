#version 460
// SPDX-License-Identifier: Apache-2.0
// A kernel that does nothing: tests/api/device_test.c puts it in the place of another.
layout(local_size_x = 64) in;

void main() {}
