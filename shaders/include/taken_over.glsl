// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Software rasterisers read a uniform anew for each ray of a group wherever it stands, at the price
// of half a voxel. What the loops along a ray need is taken over in front of them, through an
// operation that no compiler traces back to the uniform.

float taken_over(float uniform_value) { return max(uniform_value, -3.0e38); }
vec3 taken_over(vec3 uniform_value) { return max(uniform_value, vec3(-3.0e38)); }
int taken_over(int uniform_value) { return max(uniform_value, -2147483647); }
