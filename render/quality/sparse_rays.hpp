// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/scene.hpp"

namespace nav::render {

/// Fewer rays than pixels, for the CPU and the OpenGL engine (after Levoy 1990, adaptive
/// refinement). With quality.pixel_error > 0 the first rays are those of a lattice of pixels: every
/// stride-th column and row from the upper left on, and all pixels beyond its last column and row.
/// Then the squares between four neighbours of the lattice are divided in four until they are
/// pixels.
///
/// The rule. The middle of a square and the middles of its edges take the mean of the four or two
/// corners around them if every square that they belong to is *even*. A square is even if its
/// corners differ by no more than error in every channel of the image without the ultrasound image,
/// which includes the scene's background, and in the weight of the ultrasound image, and if all or
/// none of them show the ultrasound image. Other pixels have rays of their own. So does every pixel
/// that a needle, sphere or line may reach, and every pixel on the border of the ultrasound image,
/// because these are narrower than a square. Means are taken before the ultrasound image is put in,
/// so that its pixels stay sharp.
///
/// Both engines draw the same image by this rule, up to rounding, except near shapes. The CPU
/// engine decides by blocks of 8 x 8 pixels what a needle, sphere or line may reach. OpenGL decides
/// by pixels and so spares more rays there.
///
/// The error of a mean has no bound: structures between the rays of a lattice are not seen. So the
/// lattice is never wider than two voxels in the middle of the volume, the narrowest structure that
/// a CT can show (by the sampling theorem), and a still scene asks for a pixel error of 0.
struct SparseRays {
  int stride;   ///< Pixels between the rays of the lattice: 2 or 4.
  float error;  ///< quality.pixel_error.
};

/// The pixels of an image that always have a ray, and the order in which the others are decided:
/// pass 0 casts the lattice, and each later pass halves its squares.
struct PixelLattice {
  int stride;
  int last_x;  ///< Last column and row of the lattice. Every pixel beyond has a ray.
  int last_y;

  PixelLattice(int width, int height, int pixels_between)
      : stride(pixels_between),
        last_x((width - 1) / pixels_between * pixels_between),
        last_y((height - 1) / pixels_between * pixels_between) {}

  [[nodiscard]] int passes() const { return stride == 2 ? 2 : 3; }
  /// Side of the squares that a pass > 0 halves, pixels.
  [[nodiscard]] int side(int pass) const { return stride >> (pass - 1); }
  [[nodiscard]] bool beyond(int x, int y) const { return x > last_x || y > last_y; }
  /// True if a pixel in the middle of a square, or of an edge of one, may take a mean. Squares have
  /// 2^shift pixels a side. even(column, row) tells it for one square, counted from the upper left.
  /// Squares outside the lattice decide nothing.
  template <class Even>
  [[nodiscard]] bool even_around(int x, int y, int shift, const Even& even) const {
    const int within = (1 << shift) - 1;  // Divisions are expensive.
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

/// The lattice of a scene; none if every pixel has its own ray. Images by predicates have all rays,
/// because their speckle hides nothing between rays. So have jittered images, because their rays
/// differ on purpose.
std::optional<SparseRays> sparse_rays(const Scene& scene);

}  // namespace nav::render
