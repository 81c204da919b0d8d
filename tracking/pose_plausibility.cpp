// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_plausibility.hpp"

#include <algorithm>
#include <sstream>

namespace nav::tracking {
namespace {

constexpr int kEnoughPoses = 10;
constexpr int kEnoughFarPoses = 3;
constexpr int kEnoughSame = 3;
/// Bodies of two devices are not measured at the same instant.
constexpr Duration kTogether = std::chrono::milliseconds(100);
/// A probe or needle that moves is farther from its tracker or its patient at some time.
constexpr double kLeastMm = 5;
/// The working volume of the pose gate.
constexpr double kMostMm = 10000;

std::string quantity_mm(double mm) {
  std::ostringstream text;
  text.precision(3);
  text << mm << " mm";
  return text.str();
}

}  // namespace

void PosePlausibility::report(const std::string& subject, const std::string& key,
                              const std::string& value, const std::string& used) {
  if (!said_.insert(subject + key).second) return;
  diagnostics_.report("tracking",
                      {.subject = subject, .key = key, .values = {value}, .used = used});
}

void PosePlausibility::add(ToolRole role, const RawPose& pose) {
  const bool claimed =
      pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown;
  if (!claimed || !pose.tracker_from_body.allFinite()) return;
  Body& body = bodies_[role];
  const double mm = pose.tracker_from_body.topRightCorner<3, 1>().norm();
  if (body.poses == 0 || pose.tracker_from_body != body.newest) ++body.different;
  ++body.poses;
  if (mm > kMostMm) ++body.far;
  body.farthest_mm = std::max(body.farthest_mm, mm);
  body.newest = pose.tracker_from_body;
  body.acquired = pose.acquired;
  judge_unit(role, body);
  judge_others(role, body);
}

void PosePlausibility::judge_unit(ToolRole role, Body& body) {
  const std::string subject = to_string(role);
  if (body.far >= kEnoughFarPoses) {
    report(subject, "unit of the poses",
           "positions up to " + quantity_mm(body.farthest_mm) +
               " from the tracker (are they in micrometres?)",
           "millimetres; positions beyond 10000 mm are rejected");
  }
  // A patient's reference may lie still anywhere.
  if (role == ToolRole::kReference || body.different != kEnoughPoses) return;
  if (!(body.farthest_mm > 0 && body.farthest_mm < kLeastMm)) return;
  report(subject, "unit of the poses",
         std::to_string(kEnoughPoses) + " different poses within " + quantity_mm(body.farthest_mm) +
             " of the tracker (are they in metres?)",
         "millimetres");
}

void PosePlausibility::judge_others(ToolRole role, const Body& body) {
  for (const auto& [other_role, other] : bodies_) {
    if (other_role == role) continue;
    const auto both = std::minmax(role, other_role);
    if (body.newest != other.newest) {
      // The other one may be older: a pose that follows it is no difference between them.
      if (body.acquired == other.acquired) same_[both] = 0;
      continue;
    }
    const bool together = std::chrono::abs(body.acquired - other.acquired) <= kTogether;
    if (!together || ++same_[both] < kEnoughSame) continue;
    report(std::string(to_string(both.first)) + " and " + to_string(both.second), "poses",
           "the same to the last digit in " + std::to_string(kEnoughSame) +
               " poses in a row (is one body taken for two?)",
           "both as they came");
  }
}

}  // namespace nav::tracking
