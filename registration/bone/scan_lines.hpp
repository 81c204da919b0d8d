// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "nav/sweep.hpp"

namespace nav::registration {

/// Samples of ultrasound images along their scan lines: rays from the apex if the images have an
/// outline, else parallel lines down the image. All images of a sweep share them. Values are
/// depth-major: depth * lines + line.
class ScanLines {
 public:
  /// Lines line_mm apart half way down (more if an image would have over 320 lines), samples one
  /// row of pixels apart, 0.1 to 0.5 mm. Preconditions: the grid and outline are valid, line_mm >
  /// 0.
  ScanLines(const Sweep& sweep, double line_mm);

  [[nodiscard]] int lines() const { return lines_; }
  [[nodiscard]] int depths() const { return depths_; }
  [[nodiscard]] std::size_t samples() const;
  /// Distance of samples along a line, mm.
  [[nodiscard]] double step_mm() const { return step_mm_; }
  /// Distance of neighbouring lines half way down, mm.
  [[nodiscard]] double line_mm() const { return line_mm_; }
  /// First sample of a line that lies in the image and is not always black.
  [[nodiscard]] int first(int line) const { return first_[static_cast<std::size_t>(line)]; }
  /// Position of a sample, which need not be whole, Image frame, mm.
  [[nodiscard]] Eigen::Vector2d at_mm(int line, double depth) const;
  /// Direction of a line away from the transducer, unit, Image frame.
  [[nodiscard]] Eigen::Vector2d along(int line) const {
    return along_[static_cast<std::size_t>(line)];
  }
  /// Bilinear grey of each sample, 0 to 255; 0 outside the image. Precondition: the image has the
  /// sweep's size.
  [[nodiscard]] std::vector<float> sample(const Image2d<std::uint8_t>& pixels) const;

 private:
  /// The pixel above and left of a sample, and the weights of the next column and row in 1/256.
  struct Tap {
    std::int32_t pixel;  ///< Negative: outside the image.
    std::uint16_t right, below;
  };
  int lines_ = 0, depths_ = 0;
  double step_mm_ = 1, line_mm_ = 1;
  std::vector<Eigen::Vector2d> start_mm_, along_;
  std::vector<int> first_;
  std::vector<Tap> taps_;
};

}  // namespace nav::registration
