// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/deformed_registration.hpp"

#include <algorithm>
#include <cmath>
#include <tbb/parallel_for.h>

#include "nav/check.hpp"
#include "registration/motion/motion_evidence.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

// Right results have 0.43 to 1.02 on the development seeds (docs/registration-experiments.md).
constexpr double kMaxHalvesMm = 1.5;
// A field explains a part of any CT, so this limit is stricter than the cost of a pose alone. On
// the development seeds right results cost 0.15 to 0.28, those with another patient's CT at least
// 0.35.
constexpr double kMaxBentCost = 0.3;

}  // namespace

Result<Volume> bent_ct(const Volume& ct, const SplineField& field) {
  std::vector<std::int16_t> hu(ct.hu().begin(), ct.hu().end());
  const VoxelGrid& grid = ct.grid();
  // Rows of most CTs run along x, where a field is cheaper to evaluate.
  const bool along_x = grid.directions(1, 0) == 0 && grid.directions(2, 0) == 0;
  tbb::parallel_for(0, grid.size[2], [&](int k) {
    auto voxel = hu.begin() + static_cast<std::ptrdiff_t>(k) * grid.size[0] * grid.size[1];
    for (int j = 0; j < grid.size[1]; ++j, voxel += grid.size[0]) {
      const Vec first = grid.at(Vec(0, j, k)).mm;
      const SplineField::Row row = along_x ? field.row(first.y(), first.z()) : SplineField::Row{};
      if (along_x && row.empty()) continue;
      for (int i = 0; i < grid.size[0]; ++i) {
        const Point<frames::Ct> p = grid.at(Vec(i, j, k));
        const Vec moved = along_x ? row.displacement(p.mm.x()) : field.displacement(p.mm);
        if (moved.isZero(0)) continue;
        const auto value = ct.sample({p.mm + moved});
        voxel[i] = value ? static_cast<std::int16_t>(std::lround(*value)) : kAirHu;
      }
    }
  });
  return Volume::create(grid, std::move(hu), ct.name() + ", deformed");
}

Result<DeformedRegistration> register_deformed(
    const Volume& ct, const Sweep& sweep, const Pose& common, const DeformableOptions& fit,
    const ImageRegistrationOptions& solver, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress) {
  const auto evidence = motion_evidence(ct, sweep, common, solver.mask);
  if (!evidence) return evidence.error();
  auto tissue = refine_deformable(evidence->ct, evidence->patches, common, fit);
  if (!tissue) return tissue.error();
  DeformedRegistration deformed{std::move(*tissue), {}, 0};
  if (!deformed.tissue.supported) return deformed;
  const auto bent = bent_ct(ct, deformed.tissue.field);
  if (!bent) return bent.error();
  // The field already has what the probe presses away, and layers of other speed of sound.
  ImageRegistrationOptions in_field = solver;
  in_field.pressed_sigma_mm = 0;
  in_field.speed_from_ct = false;
  auto found = register_sweep(*bent, sweep, common, in_field, diagnostics, progress);
  if (!found) return found.error();
  // The unknown part of the field is about as large as the known part: on the development seeds the
  // error at the targets was 0.8 to 1.7 times the displacement (docs/registration-experiments.md).
  found->uncertainty.widen(deformed.tissue.displacement_mm);
  deformed.settled_mm = apart_mm(sweep, common, found->ct_from_reference);
  deformed.in_bent_ct = std::move(*found);
  return deformed;
}

Decision decide(const DeformedRegistration& deformed, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target) {
  NAV_CHECK(deformed.in_bent_ct.has_value(), deformed.tissue.reason);
  AcceptanceLimits bent = limits;
  bent.max_cost = std::min(bent.max_cost, kMaxBentCost);
  Judge judge(decide(*deformed.in_bent_ct, bent, target));
  judge.at_most("distance between the poses in the deformed and the original CT",
                deformed.settled_mm, kMaxSettlingMm, kMaxSettlingMm, " mm");
  judge.at_most("disagreement of the deformations of odd and even images",
                deformed.tissue.halves_disagreement_mm, kMaxHalvesMm, kMaxHalvesMm, " mm");
  return std::move(judge).decision();
}

}  // namespace nav::registration
