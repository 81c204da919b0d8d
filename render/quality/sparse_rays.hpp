// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/scene.hpp"

namespace nav::render {

/// Fewer rays than pixels, for the CPU and the OpenGL engine (after Levoy 1990, adaptive
/// refinement). With quality.pixel_error > 0 rays are cast first for the pixels of a lattice: every
/// stride-th column and row from the upper left on, and all beyond its last column and row. Then
/// the squares between four neighbours of the lattice are divided in four, until they are pixels.
///
/// The rule. The middle of a square and the middles of its edges take the mean of the four or two
/// corners around them if every square that they belong to is *even*: its corners differ by no more
/// than error in any channel of what lies around the ultrasound picture, the scene's background
/// included, and in the weight of that, and either all or none of them show it. Otherwise they have
/// rays of their own, and so has every pixel that a needle, sphere or line may reach or that the
/// border of the ultrasound picture is on, narrower than a square. Means are of what was there
/// before the picture was put in, so that its pixels are shown as sharply as ever.
///
/// Both engines draw the same by it, to rounding, but near shapes: the CPU engine and OpenGL on the
/// processor say by blocks of 8 x 8 pixels what a needle, sphere or line may reach, OpenGL on a
/// graphics card by pixels and so spares more rays there.
///
/// Nothing bounds the error of a mean: what lies between the rays of a lattice is not seen by it.
/// So the lattice is never wider than two voxels in the middle of the volume, the narrowest
/// structure that a CT can show (its sampling theorem), and stillness asks for 0.
struct SparseRays {
  int stride;   ///< Pixels between the rays of the lattice: 2 or 4.
  float error;  ///< quality.pixel_error.
};

/// The pixels of a picture that have a ray whatever it shows, and in which order the others are
/// decided: pass 0 casts the lattice, each later one halves its squares.
struct PixelLattice {
  int stride;
  int last_x;  ///< Last column and row of the lattice; beyond them every pixel has a ray.
  int last_y;

  PixelLattice(int width, int height, int pixels_between)
      : stride(pixels_between),
        last_x((width - 1) / pixels_between * pixels_between),
        last_y((height - 1) / pixels_between * pixels_between) {}

  [[nodiscard]] int passes() const { return stride == 2 ? 2 : 3; }
  /// Of the squares that a pass > 0 halves, pixels.
  [[nodiscard]] int side(int pass) const { return stride >> (pass - 1); }
  [[nodiscard]] bool beyond(int x, int y) const { return x > last_x || y > last_y; }
  /// Whether a pixel in the middle of a square, or of an edge of one, may take a mean: squares have
  /// 2^shift pixels a side, and even(column, row) says it of one, counted from the upper left.
  /// Squares that are not there decide nothing.
  template <class Even>
  [[nodiscard]] bool even_around(int x, int y, int shift, const Even& even) const {
    const int within = (1 << shift) - 1;  // Divisions are dear.
    const int column = x >> shift;
    const int row = y >> shift;
    if ((x & within) == 0) {
      const bool left = x > 0;
      const bool right = x < last_x;
      return (left || right) && (!left || even(column - 1, row)) && (!right || even(column, row));
    }
    if ((y & within) == 0) {
      const bool above = y > 0;
      const bool below = y < last_y;
      return (above || below) && (!above || even(column, row - 1)) && (!below || even(column, row));
    }
    return even(column, row);
  }
};

/// How a scene's rays are spared; none: every pixel has its ray. Pictures by predicates, whose
/// speckle hides nothing between rays, and jittered ones, whose rays differ by intent, have all.
std::optional<SparseRays> sparse_rays(const Scene& scene);

}  // namespace nav::render
