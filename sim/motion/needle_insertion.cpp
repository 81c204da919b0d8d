// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/needle_insertion.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "nav/matrices.hpp"
#include "sim/shapes.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kShaftPoints = 17;
constexpr double kLongestMm = 1000;

std::string text(double mm) {
  if (!std::isfinite(mm)) return std::to_string(mm);
  std::string s = std::to_string(mm);
  return s.substr(0, s.find('.') + 3);
}

/// \p unit includes its leading space.
Error rejected_insertion(const std::string& expected, double found,
                         const std::string& unit = " mm") {
  return Error{ErrorCode::kUsage, "needle: expected " + expected + ", found " + text(found) + unit};
}

}  // namespace

Result<void> validate(const NeedleInsertionOptions& o) {
  if (const auto ok = validate(o.bending); !ok) return ok.error();
  if (!(o.speed_mm_s >= 0 && o.speed_mm_s <= 1000)) {
    return rejected_insertion("a speed of 0 to 1000 mm/s (0: the target is reached at the end)",
                              o.speed_mm_s, " mm/s");
  }
  if (!(o.length_mm > 0 && o.length_mm <= kLongestMm)) {
    return rejected_insertion("a length of 0 to 1000 mm", o.length_mm);
  }
  if (!(o.outside_mm >= 0 && o.outside_mm <= 500)) {
    return rejected_insertion("a tip 0 to 500 mm outside the skin at the start", o.outside_mm);
  }
  if (!o.aside_at_target_mm) return {};
  if (!(*o.aside_at_target_mm >= 0 && std::isfinite(*o.aside_at_target_mm))) {
    return rejected_insertion("a sideways distance >= 0 mm at the target", *o.aside_at_target_mm);
  }
  if (o.bending.kind == BendingKind::kStraight && *o.aside_at_target_mm > 0) {
    return rejected_insertion("a sideways distance of 0 mm for a straight needle",
                              *o.aside_at_target_mm);
  }
  return {};
}

Result<NeedleInsertion> NeedleInsertion::create(const NeedlePlan& plan,
                                                const NeedleInsertionOptions& options,
                                                Timestamp begin, Timestamp end) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (const auto ok = validate(plan); !ok) return ok.error();
  const double path = (plan.target_ct.mm - plan.entry_ct.mm).norm();
  if (!(options.length_mm >= path)) {
    return rejected_insertion(
        "a length of at least the path from the skin to the target, " + text(path) + " mm",
        options.length_mm);
  }
  NeedleInsertionOptions resolved = options;
  if (options.aside_at_target_mm) {
    const auto bending = bending_aside(options.bending, path, *options.aside_at_target_mm);
    if (!bending) return bending.error();
    resolved.bending = *bending;
  }
  const double aside = BentNeedle(resolved.bending, path).tip().mm.head<2>().norm();
  if (!(aside <= kMostAsideShare * path)) {
    return rejected_insertion(
        "a tip at most " + text(kMostAsideShare * path) +
            " mm sideways at the target (a fifth of the path, the limit of the model)",
        aside);
  }
  if (options.speed_mm_s == 0 && !(end > begin)) {
    return Error{ErrorCode::kUsage, "needle: expected the insertion to end after it begins"};
  }
  const double speed = options.speed_mm_s > 0
                           ? options.speed_mm_s
                           : (options.outside_mm + path) / to_seconds(end - begin);
  return NeedleInsertion(plan, resolved, begin, speed);
}

NeedleInsertion::NeedleInsertion(const NeedlePlan& plan, const NeedleInsertionOptions& options,
                                 Timestamp begin, double speed_mm_s)
    : plan_(plan),
      options_(options),
      begin_(begin),
      path_mm_((plan.target_ct.mm - plan.entry_ct.mm).norm()),
      speed_mm_s_(speed_mm_s) {}

double NeedleInsertion::along_mm(Timestamp time) const {
  const double whole = options_.outside_mm + path_mm_;
  const double advanced = std::clamp(speed_mm_s_ * to_seconds(time - begin_), 0.0, whole);
  if (options_.outside_mm == 0) return advanced;
  return whole * shapes::smooth_step(advanced / whole) - options_.outside_mm;
}

double NeedleInsertion::inserted_mm(Timestamp time) const { return std::max(along_mm(time), 0.0); }

Transform<frames::Ct, frames::Needle> NeedleInsertion::ct_from_needle(Timestamp time) const {
  const Vec axis = (plan_.target_ct.mm - plan_.entry_ct.mm) / path_mm_;
  return {rotation_between(Vec::UnitZ(), axis), plan_.entry_ct.mm + along_mm(time) * axis};
}

Transform<NeedleHub, frames::Needle> NeedleInsertion::hub_from_needle() const {
  return {Eigen::Quaterniond::Identity(), Vec(0, 0, options_.length_mm)};
}

Transform<frames::Ct, NeedleHub> NeedleInsertion::ct_from_hub(Timestamp time) const {
  return ct_from_needle(time) * hub_from_needle().inverse();
}

NeedleTruth NeedleInsertion::truth(Timestamp time) const {
  const double inserted = inserted_mm(time);
  const BentNeedle needle(options_.bending, inserted);
  const auto pose = ct_from_needle(time);
  return {.inserted_mm = inserted,
          .ct_from_needle = pose,
          .tip_ct = pose * needle.tip(),
          .straight_tip_ct = pose * Point<frames::Needle>{Vec::Zero()},
          .tip_error_mm = needle.tip_error_mm()};
}

std::vector<Point<frames::Ct>> NeedleInsertion::shaft_ct(Timestamp time) const {
  const auto pose = ct_from_needle(time);
  auto shaft = BentNeedle(options_.bending, inserted_mm(time)).shaft(kShaftPoints);
  std::ranges::reverse(shaft);
  std::vector<Point<frames::Ct>> points;
  for (const auto& p : shaft) points.push_back(pose * p);
  points.push_back(pose * Point<frames::Needle>{Vec(0, 0, -options_.length_mm)});
  return points;
}

}  // namespace nav::sim
