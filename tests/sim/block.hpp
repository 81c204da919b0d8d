// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// Shape of a block that is liver everywhere.
inline double nowhere(const Eigen::Vector3d&) { return 1e3; }

/// Liver below y = 0, with another tissue inside the shape (where its signed distance is negative).
/// The probe looks along +y from the origin.
class Block final : public Anatomy {
 public:
  using Shape = double (*)(const Eigen::Vector3d&);
  Block(Tissue inside, Shape shape) : inside_(inside), shape_(shape) {}
  [[nodiscard]] std::string name() const override { return "block"; }
  [[nodiscard]] Tissue tissue(const Point<frames::Ct>& p) const override {
    return shape_(p.mm) < 0 ? inside_ : Tissue::kLiver;
  }
  [[nodiscard]] double hu(const Point<frames::Ct>&) const override { return 0; }
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Point<frames::Ct>&) const override {
    return {0, {Eigen::Vector3d::Zero()}};
  }
  [[nodiscard]] Acoustics acoustics(const Point<frames::Ct>& p) const override {
    const auto share = static_cast<float>(std::clamp(0.5 - shape_(p.mm) / 0.8, 0.0, 1.0));
    Acoustics a = tissue_acoustics(Tissue::kLiver);
    const Acoustics& b = tissue_acoustics(inside_);
    a.impedance_mrayl += share * (b.impedance_mrayl - a.impedance_mrayl);
    a.attenuation_db_per_cm_mhz +=
        share * (b.attenuation_db_per_cm_mhz - a.attenuation_db_per_cm_mhz);
    a.scatter += share * (b.scatter - a.scatter);
    return a;
  }
  [[nodiscard]] double skin_distance_mm(const Point<frames::Ct>&) const override { return -50; }
  [[nodiscard]] Eigen::AlignedBox3d region_mm() const override {
    return {Eigen::Vector3d::Constant(-100), Eigen::Vector3d::Constant(100)};
  }
  [[nodiscard]] std::vector<NamedPoint> landmarks() const override { return {}; }
  [[nodiscard]] std::vector<Point<frames::Ct>> targets() const override { return {}; }

 private:
  Tissue inside_;
  Shape shape_;
};

}  // namespace nav::sim
