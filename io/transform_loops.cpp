// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/transform_loops.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

namespace nav::io {
namespace {

constexpr double kSameMm = 1;
constexpr double kLeverMm = 50;

bool has_pose(const NamedTransform& transform) {
  return (transform.status == TrackingStatus::kOk ||
          transform.status == TrackingStatus::kUnknown) &&
         transform.to_from_from.allFinite();
}

std::string joined(const std::vector<ChainLink>& links) {
  std::string text;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (i > 0) text += i + 1 == links.size() ? " and " : ", ";
    text += links[i].name;
  }
  return text;
}

}  // namespace

TransformLoops::TransformLoops(const TransformTree& tree, std::set<std::string> used,
                               std::string image, const std::string& probe, int width, int height,
                               std::string subject)
    : image_(std::move(image)), width_(width), height_(height), subject_(std::move(subject)) {
  for (auto& [link, other] : tree.loops(used)) {
    const bool calibration =
        other.links.size() == 1 && std::minmax(other.from, other.to) == std::minmax(image_, probe);
    if (calibration) continue;
    Loop loop{.link = link, .other = other, .names = joined(other.links)};
    loop.uses_link = used.contains(link.name);
    loop.uses_other = std::ranges::any_of(
        other.links, [&](const ChainLink& one) { return used.contains(one.name); });
    loops_.push_back(std::move(loop));
  }
}

/// Largest distance between the places of a point by both ways; absent: not both have a pose.
std::optional<double> TransformLoops::apart_mm(const Loop& loop, const SequenceImage& frame) const {
  NamedTransform stated{loop.link.name, loop.link.step, TrackingStatus::kOk};
  if (loop.link.from_frame) {
    const auto found = transform(frame, loop.link.name);
    if (!found) return std::nullopt;
    stated = *found;
  }
  const auto other = loop.other.evaluate(frame);
  if (!other || !has_pose(stated) || !has_pose(*other)) return std::nullopt;
  Eigen::Matrix4d a = stated.to_from_from;
  Eigen::Matrix4d b = other->to_from_from;
  // Distances in pixels would say nothing.
  if (loop.other.to == image_) {
    a = a.inverse().eval();
    b = b.inverse().eval();
  }
  const bool of_image = loop.other.to == image_ || loop.other.from == image_;
  const double right = width_ - 1;
  const double bottom = height_ - 1;
  const std::array<Eigen::Vector4d, 4> corners{
      {{0, 0, 0, 1}, {right, 0, 0, 1}, {0, bottom, 0, 1}, {right, bottom, 0, 1}}};
  const std::array<Eigen::Vector4d, 4> axes{
      {{0, 0, 0, 1}, {kLeverMm, 0, 0, 1}, {0, kLeverMm, 0, 1}, {0, 0, kLeverMm, 1}}};
  double most_mm = 0;
  for (const Eigen::Vector4d& point : of_image ? corners : axes) {
    most_mm = std::max(most_mm, (a * point - b * point).head<3>().norm());
  }
  return most_mm;
}

std::vector<Finding> TransformLoops::findings(const SequenceImage& frame) const {
  std::vector<Finding> found;
  for (const Loop& loop : loops_) {
    const auto mm = apart_mm(loop, frame);
    if (!mm || *mm <= kSameMm) continue;
    std::ostringstream text;
    text << loop.link.name << ", which places it " << *mm << " mm away";
    if (!frame.fields.empty()) text << " in frame " << frame.index;
    std::string used = loop.uses_link ? loop.link.name : loop.names;
    if (loop.uses_link && loop.uses_other) used = "each where it is named";
    const bool no_effect = !loop.uses_link && !loop.uses_other;
    found.push_back({.subject = subject_,
                     .key = "position of " + loop.other.from + " in " + loop.other.to,
                     .values = {loop.names, text.str()},
                     .used = no_effect ? "neither" : used,
                     .severity = no_effect ? Severity::kInfo : Severity::kWarning});
  }
  return found;
}

}  // namespace nav::io
