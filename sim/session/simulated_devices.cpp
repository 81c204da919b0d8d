// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/simulated_devices.hpp"

namespace nav::sim {

const std::vector<SimulatedDevice>& simulated_devices() {
  static const std::vector<SimulatedDevice> devices{
      {"ideal", "tracker", "true poses at 50 Hz"},
      {"optical", "tracker",
       "stereo camera with markers: larger errors along the view, needs line of sight"},
      {"electromagnetic", "tracker", "field distorted by metal; noise grows with distance"},
      {"arm", "tracker",
       "six encoders: angles rounded to counts, calibration errors, limited reach"},
      {"convex", "probe", "66 degrees, 140 mm deep, 3.5 MHz: abdomen"},
      {"linear", "probe", "38 mm wide, 60 mm deep, 9 MHz: neck, tendons"},
      {"sector", "probe", "80 degrees, 100 mm deep, 5 MHz: through a craniotomy"}};
  return devices;
}

}  // namespace nav::sim
