// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The fragment that is drawn, and its results: premultiplied colour and alpha in [0, 1]; the cost
// of the ray, see lattice.glsl. With PLANE also the layer behind the ultrasound image, or the
// weight of that image if predicates are drawn, and the column and row at which the ray meets the
// image. With COMPUTE the same program is a compute shader, because some devices give fragments
// only a small part of their processors.

#ifdef COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) writeonly uniform image2D colour_target;
layout(rgba32f, binding = 1) writeonly uniform image2D spent_target;
vec4 colour;
vec4 spent;
#ifdef PLANE
layout(rgba32f, binding = 2) writeonly uniform image2D behind_target;
layout(rg32f, binding = 3) writeonly uniform image2D live_at_target;
vec4 behind;
vec2 live_at;
#endif
#ifdef SIGNATURE
layout(rg32ui, binding = 4) writeonly uniform uimage2D signature_target;
uvec2 signature;
#endif
vec2 fragment_centre;  // In pixels, row 0 at the bottom.

// Returns false outside the image.
bool begin_fragment() {
  fragment_centre = vec2(gl_GlobalInvocationID.xy) + 0.5;
  return all(lessThan(fragment_centre, image_size));
}

void write_fragment() {
  ivec2 at = ivec2(fragment_centre);
  imageStore(colour_target, at, colour);
  imageStore(spent_target, at, spent);
#ifdef PLANE
  imageStore(behind_target, at, behind);
  imageStore(live_at_target, at, vec4(live_at, 0.0, 0.0));
#endif
#ifdef SIGNATURE
  imageStore(signature_target, at, uvec4(signature, 0u, 0u));
#endif
}
#else
#define fragment_centre gl_FragCoord.xy
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 spent;
#ifdef PLANE
layout(location = 2) out vec4 behind;
layout(location = 3) out vec2 live_at;
#endif
#ifdef SIGNATURE
layout(location = 4) out uvec2 signature;
#endif
#endif
