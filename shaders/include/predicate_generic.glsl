// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Any predicate set, read from a table instead of compiled from its text. Used until the program of
// the set is ready. Each leaf has kLeafTexels texels. If classes are entries, the tokens that
// combine leaves follow. The numbers are those of the set's own uniforms.

uniform usamplerBuffer leaf_table;
uniform int leaf_count;
uniform int token_count;  // 0: each class is a leaf.
uniform bool has_undefined;

const int kLeafTexels = 6;
const uint kRangeLeaf = 0u;  // PredicateForm::Kind
const uint kWedgeLeaf = 1u;
const uint kBitsLeaf = 2u;
const uint kSegmentLeaf = 3u;
const uint kSlabLeaf = 4u;

uint asked_leaves;  // Only these leaves matter.

uvec4 leaf_texel(int leaf, int texel) {
  return texelFetch(leaf_table, kLeafTexels * leaf + texel);
}
vec4 leaf_numbers(int leaf, int texel) { return uintBitsToFloat(leaf_texel(leaf, texel)); }

// slot: 0 for the volume, otherwise 1 + 4 texture + component.
float code_of(vec4 texels[FEATURES], float volume, uint slot) {
  if (slot == 0u) return volume;
  uint which = (slot - 1u) >> 2u;
  vec4 texel = which == 0u ? texels[0] : which == 1u ? texels[1] : texels[2];
  return texel[(slot - 1u) & 3u];
}

bool is_within(float x, vec2 range) { return x >= range.x && x <= range.y; }

bool is_within_wedge(int leaf, vec2 codes) {
  vec4 scales = leaf_numbers(leaf, 5);
  vec2 g = scales.xz + scales.yw * codes;
  vec4 wedge = leaf_numbers(leaf, 2);
  vec4 limits = leaf_numbers(leaf, 3);  // Slack of the three forms, least gradient.
  vec3 forms = vec3(dot(wedge.xy, g), dot(wedge.zw, g), dot(leaf_numbers(leaf, 4).xy, g));
  return dot(g, g) >= limits.w * limits.w && all(greaterThanEqual(forms, -limits.xyz));
}

float distance_to_segment(int leaf, vec3 position) {
  vec3 d = position - leaf_numbers(leaf, 2).xyz;
  float along = clamp(dot(d, leaf_numbers(leaf, 4).xyz), 0.0, 1.0);
  return length(d - along * leaf_numbers(leaf, 3).xyz);
}

bool is_true(int leaf, vec4 texels[FEATURES], float volume, uint undefined, uint labels,
             vec3 position) {
  uvec4 head = leaf_texel(leaf, 0);  // Kind, slots of its channels, bits of undefined channels.
  if ((undefined & head.w) != 0u) return false;
  uvec4 limits = leaf_texel(leaf, 1);  // Mask, 0, range.
  vec2 range = uintBitsToFloat(limits.zw);
  float code = code_of(texels, volume, head.y);
  if (head.x == kRangeLeaf) return is_within(code, range);
  if (head.x == kBitsLeaf) return (labels & limits.x) != 0u;
  if (head.x == kSegmentLeaf) return is_within(distance_to_segment(leaf, position), range);
  if (head.x == kSlabLeaf) return is_within(dot(leaf_numbers(leaf, 3).xyz, position), range);
  if (head.x == kWedgeLeaf)
    return is_within_wedge(leaf, vec2(code, code_of(texels, volume, head.z)));
  return false;
}

uint predicate_leaves(vec4 texels[FEATURES], float volume, uint undefined, uint labels,
                      vec3 position) {
  uint rest = asked_leaves & (leaf_count < 32 ? (1u << uint(leaf_count)) - 1u : ~0u);
  uint leaves = 0u;
  while (rest != 0u) {
    int leaf = findLSB(rest);
    if (is_true(leaf, texels, volume, undefined, labels, position)) leaves |= 1u << uint(leaf);
    rest &= rest - 1u;
  }
  return leaves;
}

// Tokens in postfix order: operation, index of a leaf or of an entry. The stack consists of the
// bits of a number.
uint predicate_class(uint leaves) {
  if (token_count == 0) return leaves;
  uint entries = 0u;
  uint stack = 0u;
  for (int i = 0; i < token_count; ++i) {
    uvec4 token = texelFetch(leaf_table, kLeafTexels * leaf_count + i);
    uint top = stack & 1u;
    if (token.x == 0u) stack = (stack << 1u) | ((leaves >> token.y) & 1u);
    if (token.x == 1u) stack = (stack << 1u) | ((entries >> token.y) & 1u);
    if (token.x == 2u) stack ^= 1u;
    if (token.x == 3u) stack = (stack >> 1u) & (~1u | top);
    if (token.x == 4u) stack = (stack >> 1u) | top;
    if (token.x == 5u) {  // The result of an entry.
      entries |= top << token.y;
      stack >>= 1u;
    }
  }
  return entries;
}
