// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The CT. Space: index, continuous voxel coordinates with voxel centres at integers. Values in HU.

uniform sampler3D ct;            // Signed 16 bit normalised: HU = texel * 32767.
uniform ivec3 ct_size;           // Voxels.
uniform mat3 index_from_local;   // Per mm.

const float kHuPerTexel = 32767.0;

#ifdef MANUAL_FILTER
// Between two equal values exactly that one, which mix() does not promise.
vec4 between(vec4 a, vec4 b, float w) { return a + w * (b - a); }
#endif

// Trilinear; the index is clamped to the outermost voxel centres.
vec4 trilinear(sampler3D volume, vec3 index) {
  vec3 inside = clamp(index, vec3(0.0), vec3(ct_size - 1));
#ifdef MANUAL_FILTER
  ivec3 a = min(ivec3(inside), max(ct_size - 2, 0));
  ivec3 b = min(a + 1, ct_size - 1);
  vec3 f = inside - vec3(a);
  vec4 v000 = texelFetch(volume, a, 0);
  vec4 v100 = texelFetch(volume, ivec3(b.x, a.yz), 0);
  vec4 v010 = texelFetch(volume, ivec3(a.x, b.y, a.z), 0);
  vec4 v110 = texelFetch(volume, ivec3(b.xy, a.z), 0);
  vec4 v001 = texelFetch(volume, ivec3(a.xy, b.z), 0);
  vec4 v101 = texelFetch(volume, ivec3(b.x, a.y, b.z), 0);
  vec4 v011 = texelFetch(volume, ivec3(a.x, b.yz), 0);
  vec4 v111 = texelFetch(volume, b, 0);
  vec4 front = between(between(v000, v100, f.x), between(v010, v110, f.x), f.y);
  vec4 back = between(between(v001, v101, f.x), between(v011, v111, f.x), f.y);
  return between(front, back, f.z) * kHuPerTexel;
#else
  return textureLod(volume, (inside + 0.5) / vec3(ct_size), 0.0) * kHuPerTexel;
#endif
}

float ct_hu(vec3 index) { return trilinear(ct, index).r; }

// Part of an index ray inside the box of voxel centres and in front of the eye; mm, empty when
// y <= x. A single voxel fills half a voxel either side.
vec2 clip_to_box(vec3 origin, vec3 direction, float t_eye) {
  vec2 part = vec2(t_eye, 3.0e38);
  for (int axis = 0; axis < 3; ++axis) {
    float low = ct_size[axis] > 1 ? 0.0 : -0.5;
    float high = ct_size[axis] > 1 ? float(ct_size[axis] - 1) : 0.5;
    float o = origin[axis];
    float d = direction[axis];
    if (d == 0.0) {
      if (o < low || o > high) return vec2(0.0);
    } else {
      float a = (low - o) / d;
      float b = (high - o) / d;
      part = vec2(max(part.x, min(a, b)), min(part.y, max(a, b)));
    }
  }
  return part.y > part.x ? part : vec2(0.0);
}
