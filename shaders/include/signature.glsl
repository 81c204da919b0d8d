// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A hash of everything that a ray meets besides the volume. When something moves, rays of the same
// signature look the same and keep their pixels. The hashes of the surfaces are summed: each
// contains its position, and so the order.

uniform bool keeps;               // The targets hold an image of the same view.
uniform usampler2D signatures;    // Signatures of that image.

uvec2 with_bits(uvec2 hash, uint bits) {
  hash = (hash ^ bits) * uvec2(0x9e3779b1u, 0x85ebca77u);
  return hash ^ (hash >> 15u);
}

uvec2 with_numbers(uvec2 hash, vec4 numbers) {
  uvec4 bits = floatBitsToUint(numbers);
  return with_bits(with_bits(with_bits(with_bits(hash, bits.x), bits.y), bits.z), bits.w);
}

#ifdef SURFACES
uvec2 signature_of_surface(Surface surface) {
  uvec2 hash = uvec2(surface.order, 1u + uint(surface.live));
  hash = with_numbers(hash, vec4(surface.rgb, surface.alpha));
  return surface.t < kNever ? with_bits(hash, floatBitsToUint(surface.t)) : uvec2(0u);
}
#endif

// cut: a surface of the cutaway meets the ray in the volume.
uvec2 signature_of(Ray ray, float t_eye, bool cut) {
  uvec2 sum = uvec2(1u);
#ifdef CUTAWAY
  if (cut) sum += with_numbers(uvec2(7u), vec4(cut_span.t1, cut_span.t2, overlay_mm, fade_by.y + 7.0 * fade_by.z));
#endif
#ifdef PLANE
  sum += signature_of_surface(hit_plane(ray, t_eye));
#endif
#ifdef SOLIDS
  for (int i = 0; i < solid_count; ++i) sum += signature_of_surface(hit_solid(i, ray, t_eye));
#endif
  return sum;
}

// True if the pixel already shows a ray of this signature.
bool is_kept(uvec2 signature) {
  return keeps && signature == texelFetch(signatures, ivec2(fragment_centre), 0).rg;
}
