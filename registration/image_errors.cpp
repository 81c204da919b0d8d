// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_errors.hpp"

namespace nav::registration {

ErrorVector ImageErrors::vector() const {
  ErrorVector out;
  out << delay_s, depth_scale - 1, width_scale - 1, turn_rad, shift_mm;
  return out;
}

ImageErrors ImageErrors::of(const ErrorVector& values) {
  return {.delay_s = values[0],
          .depth_scale = 1 + values[1],
          .width_scale = 1 + values[2],
          .turn_rad = values.segment<3>(3),
          .shift_mm = values.tail<3>()};
}

ErrorVector ErrorSigmas::vector() const {
  ErrorVector out;
  out << delay_s, depth_scale, width_scale, turn_rad, turn_rad, turn_rad, shift_mm, shift_mm,
      shift_mm;
  return out;
}

}  // namespace nav::registration
