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

/// Width of blended boundaries, mm: the partial volume of a point.
struct Blend {
  double ct_mm = 1.0;
  double acoustic_mm = 0.8;
};

/// Stack of organs, evaluated through a grid; every analytic patient is one. Outside all organs
/// there is air. Private to sim/. Reading is thread-safe.
class OrganStack {
 public:
  /// The organs' surfaces lie within \p box. \p seed: seed of the strands of organs with fibres.
  OrganStack(std::vector<Organ> organs, const Eigen::AlignedBox3d& box, double cell_mm, Blend blend,
             Contrast contrast, std::uint64_t seed);
  OrganStack(const OrganStack&) = delete;
  OrganStack& operator=(const OrganStack&) = delete;

  [[nodiscard]] Tissue tissue(const Vec3d& p) const;
  /// Result of tissue() by evaluation of every organ, for tests of the grid. Slow.
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
  std::vector<Acoustics> alone_;              ///< Values of each organ where it fills a point.
  std::vector<std::vector<Septa>> septa_;     ///< Septa of each organ.
  std::vector<std::array<Vec3d, 2>> beside_;  ///< Axes across the fibres of each organ.
  std::array<double, static_cast<std::size_t>(Tissue::kCount)> hu_{};
};

}  // namespace nav::sim
