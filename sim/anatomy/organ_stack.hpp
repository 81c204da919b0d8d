// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sim/anatomy/anatomy.hpp"
#include "sim/anatomy/organ.hpp"
#include "sim/anatomy/organ_grid.hpp"
#include "sim/speckle.hpp"

namespace nav::sim {

/// How wide boundaries are, mm: the partial volume of a point.
struct Blend {
  double ct_mm = 1.0;
  double acoustic_mm = 0.8;
};

/// Organs on top of each other, asked through a grid: what every analytic patient is. Outside all
/// of them is air. Private to sim/. Thread-safe to read.
class OrganStack {
 public:
  /// The organs' surfaces lie within the box. seed: of the strands of grained organs.
  OrganStack(std::vector<Organ> organs, const Eigen::AlignedBox3d& box, double cell_mm, Blend blend,
             Contrast contrast, std::uint64_t seed);
  OrganStack(const OrganStack&) = delete;
  OrganStack& operator=(const OrganStack&) = delete;

  [[nodiscard]] Tissue tissue(const Vec3d& p) const;
  /// Same, asking every organ. Slow: the oracle of the grid.
  [[nodiscard]] Tissue tissue_exhaustive(const Vec3d& p) const;
  [[nodiscard]] double hu(const Vec3d& p) const;
  [[nodiscard]] ValueAndGradient hu_with_gradient(const Vec3d& p) const;
  [[nodiscard]] Acoustics acoustics(const Vec3d& p) const;

 private:
  [[nodiscard]] Tissue topmost(const OrgansNear& near, const Vec3d& p) const;
  template <class S>
  [[nodiscard]] S hu_at(const Vec3d& p, const Vec3<S>& q) const;
  template <class S, class Mix>
  void cover(const Vec3d& p, const Vec3<S>& q, double blend_mm, const Mix& mix) const;
  [[nodiscard]] float strands(const Organ& organ, const Vec3d& p) const;
  [[nodiscard]] std::size_t index_of(const Organ& organ) const {
    return static_cast<std::size_t>(&organ - organs_.data());
  }
  [[nodiscard]] Vec3d sheet(const Organ& organ, const Vec3d& p) const;

  std::vector<Organ> organs_;
  OrganGrid grid_;
  Blend blend_;
  SmoothField strands_;
  std::vector<Acoustics> alone_;              ///< Of each organ, where it fills a point.
  std::vector<std::vector<Septa>> septa_;     ///< Of each organ.
  std::vector<std::array<Vec3d, 2>> beside_;  ///< Of each organ, axes across its grain.
  std::array<double, static_cast<std::size_t>(Tissue::kCount)> hu_{};
};

}  // namespace nav::sim
