// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The greatest, least or mean value at the middles of all cells of a stretch, as grey.

uniform float grey_level_hu;
uniform float grey_width_hu;

// begin < end, cells.
float projected_grey(float begin, float end) {
  int last = int(ceil(end));
#if defined(MAXIMUM)
  float value = -3.0e38;
#elif defined(MINIMUM)
  float value = 3.0e38;
#else
  float value = 0.0;
#endif
  for (int k = int(floor(begin)); k < last; ++k) {
    float v = value_at(float(k) + 0.5);
#if defined(MAXIMUM)
    value = max(value, v);
#elif defined(MINIMUM)
    value = min(value, v);
#else
    float part = min(end, float(k + 1)) - max(begin, float(k));
    value += (v - value) * (part / (min(end, float(k + 1)) - begin));
#endif
  }
  return clamp((value - grey_level_hu) / grey_width_hu + 0.5, 0.0, 1.0);
}
