// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The greatest, least or mean value at the middles of all cells of a stretch, as grey. A brick
// takes no sample if its range of values cannot change the result so far. For the mean, a brick of
// one value takes one sample. Neither changes a bit of the result.

uniform float grey_level_hu;
uniform float grey_width_hu;

const float kRangeMargin = 1.0 / 64.0;  // HU; more than rounding adds to the range of a brick.

#if defined(MAXIMUM)
const float kNothingFound = -3.0e38;
#elif defined(MINIMUM)
const float kNothingFound = 3.0e38;
#else
const float kNothingFound = 0.0;
#endif

// The result so far, combined with the value of cell k of a stretch.
float with_value(float found, float value, int k, float begin, float end) {
#if defined(MAXIMUM)
  return max(found, value);
#elif defined(MINIMUM)
  return min(found, value);
#else
  float stop = min(end, float(k + 1));
  precise float mean = found + (value - found) * ((stop - max(begin, float(k))) / (stop - begin));
  return mean;
#endif
}

#ifdef SKIPPING
// Data of a brick: its least and greatest value, as unsigned numbers.
struct Range {
  float low;   // HU.
  float high;
  int until;   // The last cell whose sample surely lies in the brick.
};

Range range_at(int k) {
  ivec3 brick = brick_of(k);
  vec2 known = vec2(texelFetch(bricks, brick, 0).rg) - 32768.0;
  return Range(known.x, known.y, max(k, int(floor(leaves_cube(brick, 1, -rounding)))));
}

bool is_useless(Range range, float found) {
#if defined(MAXIMUM)
  return range.high + kRangeMargin < found;
#elif defined(MINIMUM)
  return found < range.low - kRangeMargin;
#else
  return false;
#endif
}
#endif

float grey_of(float value) {
  return clamp((value - grey_level_hu) / grey_width_hu + 0.5, 0.0, 1.0);
}

// begin < end, cells.
float projected_grey(float begin, float end) {
  int last = int(ceil(end));
  int k = int(floor(begin));
  float found = kNothingFound;
  float value = 0.0;
#ifdef SKIPPING
  if (k < last) do {
    Range range;
    bool useless;
    do {
      range = range_at(k);
      useless = is_useless(range, found);
      if (useless) k = range.until + 1;
    } while (useless && k < last);
    int run_end = min(range.until + 1, last);
#if defined(MAXIMUM) || defined(MINIMUM)
    if (k < run_end) do {
      found = with_value(found, value_at(float(k) + 0.5), k, begin, end);
    } while (++k < run_end);
#else
    bool known = false;
    if (k < run_end) do {
      if (!known) value = value_at(float(k) + 0.5);
      known = range.low == range.high;
      found = with_value(found, value, k, begin, end);
    } while (++k < run_end);
#endif
  } while (k < last);
#else
  if (k < last) do {
    found = with_value(found, value_at(float(k) + 0.5), k, begin, end);
  } while (++k < last);
#endif
  return grey_of(found);
}
