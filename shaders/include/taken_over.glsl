// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Copies of uniforms. Software rasterisers read a uniform again for each ray of a group at every
// use, which costs half as much as a voxel. So the uniforms that the loops along a ray need are
// copied before the loops, through an operation that no compiler traces back to the uniform.

float taken_over(float uniform_value) { return max(uniform_value, -3.0e38); }
vec3 taken_over(vec3 uniform_value) { return max(uniform_value, vec3(-3.0e38)); }
int taken_over(int uniform_value) { return max(uniform_value, -2147483647); }
