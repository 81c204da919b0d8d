// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/free_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/motion/skin_track.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kTurn = 2 * std::numbers::pi;

Vec centre_of(const std::vector<Point<frames::Ct>>& points) {
  Vec sum = Vec::Zero();
  for (const auto& p : points) sum += p.mm;
  return sum / static_cast<double>(points.size());
}

/// Point where a ray leaves the patient.
std::optional<Vec> skin_along(const Anatomy& patient, const Vec& from, const Vec& direction) {
  constexpr double kStepMm = 1;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    const Vec p = from + i * kStepMm * direction;
    if (patient.skin_distance_mm({p}) >= 0) return p;
  }
  return std::nullopt;
}

double lean_rad(const Anatomy& patient, const Vec& skin, const Vec& into) {
  constexpr double kFootprintMm = 15;  // Footprint of a probe.
  return std::acos(std::clamp(-into.dot(outward(patient, skin, kFootprintMm)), -1.0, 1.0));
}

constexpr int kSamples = 48;

/// Number of samples of a line, of kSamples, from where it first meets tissue that blocks sound.
int blocked_samples(const Anatomy& patient, const Vec& from, const Vec& way) {
  for (int i = 0; i < kSamples; ++i) {
    if (blocks_ultrasound(patient.tissue({from + (0.05 + 0.02 * i) * way}))) return kSamples - i;
  }
  return 0;
}

/// Half the width of a fan of lines at the skin and at the target.
struct Fan {
  double skin_mm, target_mm;
};

/// The best of the views of a point from the skin.
class BestView {
 public:
  BestView(const Anatomy& patient, const Vec& target, const Fan& fan, double press_mm)
      : patient_(patient), target_(target), fan_(fan), press_mm_(press_mm) {}

  /// \p side: direction of the image's x axis, as near as possible.
  void consider(const Vec& skin, const Vec& side) {
    const Vec into = (target_ - skin).normalized();
    const Vec x = (side - side.dot(into) * into).normalized();
    int blocked = 0;
    for (int line = -4; line <= 4; ++line) {
      const Vec way = target_ + fan_.target_mm * line / 4 * x - skin;
      blocked += blocked_samples(patient_, skin + fan_.skin_mm * line / 4 * x, way);
    }
    // The score prefers free lines, then a pose that can be held, then the shortest path.
    const double too_far = std::max(lean_rad(patient_, skin, into) - kMostLeanRad, 0.0);
    const double score = blocked / (9.0 * kSamples) + too_far + 2e-4 * (skin - target_).norm();
    if (score >= best_) return;
    best_ = score;
    Eigen::Matrix3d axes;
    axes << x, into, x.cross(into);
    view_.emplace(Eigen::Quaterniond(axes).normalized(), skin + press_mm_ * into);
  }
  [[nodiscard]] const std::optional<Transform<frames::Ct, frames::Image>>& view() const {
    return view_;
  }

 private:
  const Anatomy& patient_;
  Vec target_;
  Fan fan_;
  double press_mm_;
  double best_ = 1e9;
  std::optional<Transform<frames::Ct, frames::Image>> view_;
};

}  // namespace

double press_mm(const ProbeModel& probe) {
  if (probe.stand_off_mm > 0) return -probe.stand_off_mm;
  return probe.kind == ProbeKind::kConvex ? 8 : 2;
}

std::optional<Transform<frames::Ct, frames::Image>> settled(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& view, double press_mm) {
  constexpr double kBackMm = 20;
  const Vec into = view.rotation() * Vec::UnitY();
  // Ray from inside, outwards along the beam.
  const auto skin = skin_along(patient, view.translation_mm() + kBackMm * into, -into);
  if (!skin || lean_rad(patient, *skin, into) > kMostLeanRad) return std::nullopt;
  return Transform<frames::Ct, frames::Image>(view.rotation(), *skin + press_mm * into);
}

Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm) {
  const auto targets = patient.targets();
  const Error none{ErrorCode::kUsage,
                   "simulated patient: expected skin around targets, found none"};
  if (targets.empty()) return none;
  const Vec centre = centre_of(targets);
  BestView best(patient, centre, {16, 48}, press_mm);
  for (int i = 0; i < 24; ++i) {
    for (const double up : {-0.6, -0.3, 0.0, 0.3}) {
      const double turn = kTurn * i / 24;
      const Vec out(std::cos(turn) * std::cos(up), std::sin(turn) * std::cos(up), std::sin(up));
      const auto skin = skin_along(patient, centre, out);
      if (!skin) continue;
      best.consider(*skin, Vec::UnitZ().cross(out));
    }
  }
  if (!best.view()) return none;
  return *best.view();
}

Result<Transform<frames::Ct, frames::Image>> approach_view(const Anatomy& patient,
                                                           const NeedlePlan& plan,
                                                           const ProbeModel& probe) {
  constexpr double kMostLeanToNeedleRad = 0.75;  // A needle beside the probe takes its place.
  constexpr double kFarthest = 2;                // Farthest entry relative to the nearest.
  constexpr double kDepthShare = 0.9;            // Deepest target as a share of the image depth.
  const Vec entry = plan.entry_ct.mm;
  const Vec target = plan.target_ct.mm;
  const Vec back = (entry - target).normalized();
  const Vec across = back.unitOrthogonal();
  const double press = press_mm(probe);
  const double beside = beside_probe_mm(probe);
  BestView best(patient, target, {0.3 * beside, 0.5 * beside}, press);
  // Angles between needle and beam.
  for (double spread = 0.35; spread < 1.3; spread += 0.05) {
    for (int i = 0; i < 24; ++i) {
      const Vec aside = Eigen::AngleAxisd(kTurn * i / 24, back) * across;
      const Vec out = std::cos(spread) * back + std::sin(spread) * aside;
      const auto skin = skin_along(patient, target, out);
      const double gap = skin ? (*skin - entry).norm() : 0;
      if (gap < beside || gap > kFarthest * beside ||
          (*skin - target).norm() - press > kDepthShare * probe.depth_mm ||
          lean_rad(patient, *skin, -out) > kMostLeanToNeedleRad ||
          blocked_samples(patient, *skin, target - *skin) > 0) {
        continue;
      }
      best.consider(*skin, *skin - entry);
    }
  }
  if (best.view()) return *best.view();
  return Error{ErrorCode::kUsage, patient.name() +
                                      ": expected a view of the needle's path from the skin beside "
                                      "it, free of bone and gas, found none"};
}

}  // namespace nav::sim
