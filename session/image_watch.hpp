// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nav/image.hpp"

namespace nav::session {

/// A rectangle of a screen, pixels.
struct ScreenArea {
  int left = 0, top = 0, width = 0, height = 0;
};
/// The area of four whole numbers: left, top, width, height. Absent: other numbers.
std::optional<ScreenArea> screen_area(const std::vector<double>& numbers);

struct ImageWatchOptions {
  /// Part of the image that shows its depth in digits or as a scale; absent: there is none.
  std::optional<ScreenArea> depth_display = std::nullopt;
};

/// Watches the screen of a scanner, which says nothing of its geometry: a calibration holds as long
/// as the screen shows the sector and the depth that it showed at first. Learns both from the first
/// images. A change counts after three images in a row:
///   - another size of the images;
///   - the depth display shows something else;
///   - echoes lie where the screen was black: the sector has grown;
///   - where the sector began, at the probe, the screen is black: the sector has shrunk or moved.
///   At
///     the probe it is bright also without a patient.
/// A change of the depth that leaves the outline of the sector is seen by the depth display only.
/// Not thread-safe.
class ImageWatch {
 public:
  explicit ImageWatch(const ImageWatchOptions& options) : options_(options) {}

  /// Takes the next image. Returns change().
  const std::string& look(const Image2d<std::uint8_t>& image);
  /// The change, as a clause; empty: none.
  [[nodiscard]] const std::string& change() const { return change_; }

 private:
  /// Blocks of kBlock x kBlock pixels with echoes.
  using Blocks = std::vector<bool>;
  [[nodiscard]] Blocks lit_blocks(const Image2d<std::uint8_t>& image) const;
  void learn(const Image2d<std::uint8_t>& image);
  void end_learning();
  [[nodiscard]] std::string difference(const Image2d<std::uint8_t>& image) const;
  [[nodiscard]] std::vector<std::uint8_t> display_of(const Image2d<std::uint8_t>& image) const;

  ImageWatchOptions options_;
  int width_ = 0, height_ = 0;  ///< Size of the first image.
  int columns_ = 0, rows_ = 0;  ///< Blocks.
  int learned_ = 0;             ///< Images that were learned from.
  std::vector<int> times_lit_;  ///< Counts for each block, while it learns.
  Blocks never_lit_, first_lit_;
  std::vector<std::uint8_t> display_;  ///< The display as it was at first.
  std::string change_, seen_;
  int in_a_row_ = 0;  ///< Images that agree with each other, but not with change_.
};

}  // namespace nav::session
