// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The transfer function as a table with an entry per whole HU: colour in [0, 1], not premultiplied,
// and extinction per mm, linear between entries and constant outside; importance of the nearest
// entry. Entry i of row r is texel r * transfer_size + i.
//
// A texel is rgb and extinction per mm.
#ifdef STORAGE
layout(std430, binding = 3) readonly buffer Transfer { vec4 transfer[]; };
#define transfer_texel(i) transfer[i]
#else
uniform samplerBuffer transfer;
#define transfer_texel(i) texelFetch(transfer, i)
#endif
uniform float transfer_first_hu;
uniform int transfer_size;  // Entries of a row.
#ifdef IMPORTANCE
uniform samplerBuffer importances;
#endif
#ifdef GRADIENT_WINDOWS
uniform int transfer_rows;
uniform float rows_per_gradient;  // Per HU/mm.
#endif

float first_hu;  // Copies: taken_over.glsl.
int last_entry_of_row;

void take_over_transfer() {
  first_hu = taken_over(transfer_first_hu);
  last_entry_of_row = transfer_size - 1;
}

vec4 transfer_entry(int entry) { return transfer_texel(entry); }

#ifdef IMPORTANCE
float importance_at(float hu, float gradient) {
  int nearest = int(clamp(hu - first_hu, 0.0, float(last_entry_of_row)) + 0.5);
#ifdef GRADIENT_WINDOWS
  int row = int(clamp(gradient * rows_per_gradient, 0.0, float(transfer_rows - 1)) + 0.5);
  nearest += row * transfer_size;
#endif
  return texelFetch(importances, nearest).r;
}
#endif

// rgb and extinction. importance is 1 unless IMPORTANCE is defined.
vec4 transfer_at(float hu, float gradient, out float importance) {
  float x = clamp(hu - first_hu, 0.0, float(last_entry_of_row));
  int i = min(int(x), last_entry_of_row - 1);
  float w = x - float(i);
  int nearest = w >= 0.5 ? i + 1 : i;
#ifdef GRADIENT_WINDOWS
  float y = clamp(gradient * rows_per_gradient, 0.0, float(transfer_rows - 1));
  int row = min(int(y), transfer_rows - 2);
  float v = y - float(row);
  i += row * transfer_size;
  nearest += (v >= 0.5 ? row + 1 : row) * transfer_size;
  vec4 value = mix(mix(transfer_entry(i), transfer_entry(i + 1), w),
                   mix(transfer_entry(i + transfer_size), transfer_entry(i + transfer_size + 1), w),
                   v);
#else
  vec4 value = mix(transfer_entry(i), transfer_entry(i + 1), w);
#endif
#ifdef IMPORTANCE
  importance = texelFetch(importances, nearest).r;
#else
  importance = 1.0;
#endif
  return value;
}
