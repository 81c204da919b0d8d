// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The transfer function as a table over HU: colour in [0, 1], not premultiplied, and extinction
// per mm. Linear between entries; the end values hold outside.

uniform sampler1D transfer;        // rgb, extinction per mm.
uniform float transfer_first_hu;
uniform float transfer_per_hu;     // Entries per HU.
uniform float transfer_last;       // Index of the last entry.

vec4 transfer_at(float hu) {
  float x = clamp((hu - transfer_first_hu) * transfer_per_hu, 0.0, transfer_last);
  int i = min(int(x), int(transfer_last) - 1);
  return mix(texelFetch(transfer, i, 0), texelFetch(transfer, i + 1, 0), x - float(i));
}
