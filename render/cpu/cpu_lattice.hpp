// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "render/cpu/cpu_image.hpp"
#include "render/quality/sparse_rays.hpp"

namespace nav::render {

/// The squares that touch a tile of an image, and the means between their corners.
class LatticeSquares {
 public:
  static constexpr int kTile = 32;  ///< Pixels.

  /// \p image must outlive it.
  LatticeSquares(CpuImage& image, const PixelLattice& lattice, float error)
      : image_(image), lattice_(lattice), error_(error) {}

  /// Finds the even squares with this side around the tile that begins at (x0, y0). Their corners
  /// must already be drawn.
  void find(int x0, int y0, int side);
  /// True when a pixel in the middle of a square or of an edge may take a mean.
  [[nodiscard]] bool even_around(int x, int y) const;
  /// Sets the pixel to the mean.
  void fill(int x, int y) const;

 private:
  static constexpr int kMost = kTile / 2 + 1;  ///< Greatest number of squares in a row.

  [[nodiscard]] bool find_one(int x, int y) const;
  [[nodiscard]] bool at(int column, int row) const {
    return even_[static_cast<std::size_t>(row * kMost + column)];
  }

  CpuImage& image_;
  PixelLattice lattice_;
  float error_;
  /// Side of a square, pixels.
  [[nodiscard]] int side() const { return 1 << shift_; }
  /// Distance of a column or row from the last edge of a square in front of it, pixels.
  [[nodiscard]] int beyond_edge(int pixel) const { return pixel & (side() - 1); }

  int shift_ = 1;  ///< Logarithm of the side: there are many pixels, and divisions are slow.
  int x0_ = 0;     ///< Upper left corner of the first square.
  int y0_ = 0;
  std::array<bool, static_cast<std::size_t>(kMost) * kMost> even_{};
};

}  // namespace nav::render
