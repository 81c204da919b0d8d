// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/ultrasound_image.hpp"

namespace nav::sim {

/// Persistence of a scanner: each grey value is a mean of the new image and of the last shown one.
/// One object for each stream of images.
class Persistence {
 public:
  /// \p share: share of the last image, [0, 1); 0 changes nothing.
  explicit Persistence(double share) : share_(static_cast<float>(share)) {}
  /// Changes the pixels of the next image. The first image, and one of another size, stays as it
  /// is.
  void apply(UltrasoundImage& frame);

 private:
  float share_;
  std::vector<float> shown_;
};

}  // namespace nav::sim
