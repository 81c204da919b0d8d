// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"

namespace nav::sim {

/// Reason why a needle does not follow its hub's direction.
enum class BendingKind {
  kStraight,
  kBevelArc,  ///< A bevel tip steers along a circle (Webster et al. 2006, Int. J. Robotics Res.
              ///< 25).
  kTipLoad,   ///< A sideways force at the tip bends the shaft inside the tissue (Euler–Bernoulli
              ///< cantilever, clamped at the skin).
};

/// Stable lower-case name ("bevel"), and its inverse; kUsage for an unknown name.
const char* to_string(BendingKind kind);
Result<BendingKind> bending_kind_from(std::string_view name);

struct NeedleBending {
  BendingKind kind = BendingKind::kStraight;
  double curvature_per_mm = 2e-4;   ///< Bevel arc; 20 to 22 gauge: 1e-4 to 1e-3. [0, 0.01].
  double tip_force_n = 0.05;        ///< Tip load, [0, 5].
  double youngs_modulus_gpa = 200;  ///< Stainless steel, > 0.
  double outer_mm = 0.9;            ///< Outer diameter; 20 gauge. > inner.
  double inner_mm = 0.6;            ///< Diameter of the bore, >= 0.
  double bevel_rad = 0;             ///< Direction of the deflection about the needle's axis.
};

/// Rejects invalid values; the message names the first one out of range.
Result<void> validate(const NeedleBending& bending);

/// Largest sideways deflection of a tip as a share of its path. Beyond it, slopes are no longer
/// small.
inline constexpr double kMostAsideShare = 0.2;

/// Returns the needle with the curvature (bevel) or the load (tip load) that deflects its tip by
/// aside_mm sideways after a path. Errors: kUsage for a path that is not positive, a deflection
/// beyond kMostAsideShare of it, and values that validate() rejects.
Result<NeedleBending> bending_aside(const NeedleBending& bending, double path_mm, double aside_mm);

/// Needle inserted to a length into tissue. Needle frame: that of the straight needle as its hub
/// indicates it, origin at its ideal tip, +z from the hub to the tip.
class BentNeedle {
 public:
  /// \p inserted_mm: path in tissue, [0, 1000]. Precondition: validate(bending), otherwise a Bug.
  BentNeedle(const NeedleBending& bending, double inserted_mm);
  /// Point of the shaft at arc_mm from the skin, [0, inserted]: sideways and backwards
  /// displacement.
  [[nodiscard]] Point<frames::Needle> at(double arc_mm) const;
  /// Unit direction of the shaft at arc_mm.
  [[nodiscard]] Direction<frames::Needle> direction(double arc_mm) const;
  /// The true tip.
  [[nodiscard]] Point<frames::Needle> tip() const { return at(inserted_mm_); }
  /// Distance of the true tip from the tip that the hub indicates, mm.
  [[nodiscard]] double tip_error_mm() const { return tip().mm.norm(); }
  /// Points of the shaft in tissue, skin first.
  [[nodiscard]] std::vector<Point<frames::Needle>> shaft(int points) const;

 private:
  NeedleBending bending_;
  double inserted_mm_;
  double rigidity_n_mm2_;  ///< Flexural rigidity E I.
};

}  // namespace nav::sim
