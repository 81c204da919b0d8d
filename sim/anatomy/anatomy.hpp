// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "nav/transform.hpp"
#include "sim/tissue.hpp"

namespace nav::sim {

struct NamedPoint {
  std::string name;
  Point<frames::Ct> position_ct;
};

struct ValueAndGradient {
  double value;
  Direction<frames::Ct> gradient_per_mm;
};

/// Patient whose truth is known at every point; images are simulated from it. CT coordinates (LPS,
/// mm). Implementations are immutable; reading is thread-safe.
class Anatomy {
 public:
  virtual ~Anatomy() = default;

  /// Family and seed, for messages: "neck 3".
  [[nodiscard]] virtual std::string name() const = 0;
  /// Tissue at a point: its label.
  [[nodiscard]] virtual Tissue tissue(const Point<frames::Ct>& p) const = 0;
  /// CT value without noise in the patient's contrast, HU (kMr: MR-like grey value). Boundaries are
  /// blended over a fraction of a millimetre (partial volume).
  [[nodiscard]] virtual double hu(const Point<frames::Ct>& p) const = 0;
  /// hu() with its exact gradient.
  [[nodiscard]] virtual ValueAndGradient hu_with_gradient(const Point<frames::Ct>& p) const = 0;
  /// Acoustic values, blended in the same way.
  [[nodiscard]] virtual Acoustics acoustics(const Point<frames::Ct>& p) const = 0;
  /// Distance to the skin surface, mm; negative inside the patient. First order.
  [[nodiscard]] virtual double skin_distance_mm(const Point<frames::Ct>& p) const = 0;
  /// Box that is useful to scan.
  [[nodiscard]] virtual Eigen::AlignedBox3d region_mm() const = 0;
  /// Anatomical points that a person can identify in CT and ultrasound.
  [[nodiscard]] virtual std::vector<NamedPoint> landmarks() const = 0;
  /// Points at which the target registration error is evaluated.
  [[nodiscard]] virtual std::vector<Point<frames::Ct>> targets() const = 0;

 protected:
  Anatomy() = default;
  Anatomy(const Anatomy&) = default;
  Anatomy& operator=(const Anatomy&) = default;
};

}  // namespace nav::sim
