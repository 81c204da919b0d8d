// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/needle_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "sim/scan_geometry.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kPathStepMm = 1;
constexpr double kDepthShare = 0.6;  // Wanted length of the path as a share of the image depth.
constexpr double kShortestMm = 10;
constexpr double kLongestPathMm = 140;
constexpr std::size_t kTargets = 16;

/// Point where a path out of the patient crosses the skin, unless it meets bone or gas.
std::optional<Vec> way_out(const Anatomy& patient, const Vec& target, const Vec& out) {
  for (double t = 0; t <= kLongestPathMm; t += kPathStepMm) {
    const Point<frames::Ct> p{target + t * out};
    const double skin = patient.skin_distance_mm(p);
    if (skin >= 0) return t > 0 ? std::optional<Vec>(p.mm - skin * out) : std::nullopt;
    if (blocks_ultrasound(patient.tissue(p))) return std::nullopt;
  }
  return std::nullopt;
}

/// Targets in or near the image, those nearest to its plane first.
std::vector<Vec> targets_in_view(const Anatomy& patient,
                                 const Transform<frames::Image, frames::Ct>& image_from_ct,
                                 const ProbeModel& probe) {
  const ScanGeometry geometry(probe);
  std::vector<std::pair<double, Vec>> found;
  for (const auto& target : patient.targets()) {
    const Vec image = (image_from_ct * target).mm;
    const Eigen::Vector2d beam = geometry.beam_of(image.head<2>());
    const double line = beam.x() / (probe.lines - 1), sample = beam.y() / geometry.samples();
    const bool shown = line > 0.1 && line < 0.9 && sample > 0.1 && sample < 0.9;
    found.emplace_back(std::abs(image.z()) + (shown ? 0.0 : 1000.0), target.mm);
  }
  std::ranges::stable_sort(found, {}, [](const auto& f) { return f.first; });
  std::vector<Vec> targets;
  for (const auto& f : found) {
    if (targets.size() < kTargets) targets.push_back(f.second);
  }
  return targets;
}

}  // namespace

Result<NeedlePlan> needle_path(const Anatomy& patient,
                               const Transform<frames::Ct, frames::Image>& ct_from_image,
                               const ProbeModel& probe) {
  const auto image_from_ct = ct_from_image.inverse();
  const double clear = beside_probe_mm(probe);
  double best = 1e9;
  std::optional<NeedlePlan> plan;
  const auto consider = [&](const Vec& target, double aside_deg, double tilt_deg) {
    const double aside = aside_deg * kRadPerDegree;
    const double tilt = tilt_deg * kRadPerDegree;
    const Vec out_image(std::sin(aside) * std::cos(tilt), -std::cos(aside) * std::cos(tilt),
                        std::sin(tilt));
    const double off_plane = std::abs((image_from_ct * Point<frames::Ct>{target}).mm.z());
    // The score prefers a needle that is fully visible, at an angle that reflects, and with about
    // the wanted length.
    const double turned = 0.5 * std::abs(tilt_deg) + 0.2 * std::abs(std::abs(aside_deg) - 45);
    const double unseen = off_plane + turned;
    if (unseen >= best) return;
    const auto skin =
        way_out(patient, target, (ct_from_image * Direction<frames::Image>{out_image}).v);
    if (!skin || (*skin - target).norm() < kShortestMm) return;
    const double score =
        unseen + 0.3 * std::abs((*skin - target).norm() - kDepthShare * probe.depth_mm);
    if (score >= best) return;
    const Vec entry = (image_from_ct * Point<frames::Ct>{*skin}).mm;
    if (std::abs(entry.x()) < clear && std::abs(entry.z()) < clear) return;
    best = score;
    plan = NeedlePlan{{*skin}, {target}, 0, 0};
  };
  for (const Vec& target : targets_in_view(patient, image_from_ct, probe)) {
    for (const double aside : {-45., 45., -30., 30., -60., 60., -75., 75., -15., 15., 0.}) {
      for (const double tilt : {0., -15., 15., -30., 30., -50., 50.}) consider(target, aside, tilt);
    }
  }
  if (plan) return *plan;
  return Error{ErrorCode::kUsage, patient.name() +
                                      ": expected a needle path from the skin beside the probe to "
                                      "a target, free of bone and gas, found none"};
}

}  // namespace nav::sim
