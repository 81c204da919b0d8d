// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "render/cpu/cpu_picture.hpp"
#include "render/quality/sparse_rays.hpp"

namespace nav::render {

/// The squares that touch a tile of a picture, and the means between their corners.
class LatticeSquares {
 public:
  static constexpr int kTile = 32;  ///< Pixels.

  /// The picture must outlive it.
  LatticeSquares(CpuPicture& picture, const PixelLattice& lattice, float error)
      : picture_(picture), lattice_(lattice), error_(error) {}

  /// Looks which squares of that side are even about the tile from (x0, y0) on. Their corners must
  /// have been drawn.
  void find(int x0, int y0, int side);
  /// Whether a pixel in the middle of a square or of an edge may take a mean.
  [[nodiscard]] bool even_around(int x, int y) const;
  /// Gives it the mean.
  void fill(int x, int y) const;

 private:
  static constexpr int kMost = kTile / 2 + 1;  ///< Squares in a row.

  [[nodiscard]] bool find_one(int x, int y) const;
  [[nodiscard]] bool at(int column, int row) const {
    return even_[static_cast<std::size_t>(row * kMost + column)];
  }

  CpuPicture& picture_;
  PixelLattice lattice_;
  float error_;
  /// Of a square, pixels.
  [[nodiscard]] int side() const { return 1 << shift_; }
  /// How far a column or row lies beyond one of the squares' edges.
  [[nodiscard]] int beyond_edge(int pixel) const { return pixel & (side() - 1); }

  int shift_ = 1;  ///< Logarithm of the side: pixels are many, and divisions dear.
  int x0_ = 0;     ///< Upper left corner of the first square.
  int y0_ = 0;
  std::array<bool, static_cast<std::size_t>(kMost) * kMost> even_{};
};

}  // namespace nav::render
