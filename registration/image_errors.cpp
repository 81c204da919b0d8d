// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_errors.hpp"

#include <cmath>

namespace nav::registration {

ErrorVector ImageErrors::vector() const {
  ErrorVector out;
  out << delay_s, depth_scale - 1, width_scale - 1, pressed_mm, turn_rad, shift_mm;
  return out;
}

ImageErrors ImageErrors::of(const ErrorVector& values) {
  return {.delay_s = values[0],
          .depth_scale = 1 + values[1],
          .width_scale = 1 + values[2],
          .pressed_mm = values[3],
          .turn_rad = values.segment<3>(4),
          .shift_mm = values.tail<3>()};
}

ErrorVector ErrorSigmas::vector() const {
  ErrorVector out;
  const double along_beam_mm = shift_mm > 0 ? std::hypot(shift_mm, layers_mm) : 0;
  out << delay_s, depth_scale, width_scale, pressed_mm, turn_rad, turn_rad, turn_rad, shift_mm,
      along_beam_mm, shift_mm;
  return out;
}

}  // namespace nav::registration
