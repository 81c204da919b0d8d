// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <span>
#include <vector>

#include "sim/needle_shaft.hpp"
#include "sim/scan_geometry.hpp"

namespace nav::sim {

/// Echo of a needle in one picture: a thin bright line where the shaft lies within the slice,
/// strongest where the beam meets it square, with a brighter tip, weakened as any echo by the
/// tissue in front of it. Private to sim/. Geometry and probe must outlive it. Thread-safe to read.
class NeedleEcho {
 public:
  NeedleEcho(const NeedleShaft& needle, const Transform<frames::Ct, frames::Image>& ct_from_image,
             const ScanGeometry& geometry, const ProbeModel& probe);
  /// No needle: nothing to add.
  [[nodiscard]] bool empty() const { return pieces_.empty(); }
  /// Adds what a scan line receives, before depth gain, to all its samples. left: amplitude that is
  /// left of an echo from each after the way there and back, (0, 1].
  void add(int line, std::span<const float> left, std::span<std::complex<float>> samples) const;

 private:
  /// A straight piece of the shaft, Image coordinates.
  struct Piece {
    Eigen::Vector3d front, axis;  ///< End nearer to the tip; unit, towards the tip.
    double length_mm;
    double behind_tip_mm;  ///< Along the shaft from the tip to the front.
  };
  /// The point of the shaft that a sample hears best.
  struct Nearest {
    double exponent;  ///< Of the amplitude, twice negated; smaller is louder.
    double behind_tip_mm;
    double facing;  ///< Square of the sine between beam and shaft.
  };
  void look(const Piece& piece, const ScanLine& ray, std::span<Nearest> best) const;

  const ScanGeometry& geometry_;
  const ProbeModel& probe_;
  std::vector<Piece> pieces_;
};

}  // namespace nav::sim
