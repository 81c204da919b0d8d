// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/recorded_hand.hpp"

#include <algorithm>
#include <sstream>

namespace nav::sim {
namespace {

constexpr double kMostMotionMm = 500;

Error rejected(const std::string& expected, const std::string& found) {
  return {ErrorCode::kMalformedData, "recorded hand: expected " + expected + ", found " + found};
}

}  // namespace

Result<RecordedHand> RecordedHand::create(const std::vector<Pose>& poses) {
  if (poses.size() < 2) {
    return rejected("at least 2 poses", std::to_string(poses.size()));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto& pose = poses[i].reference_from_image;
    if (!pose.translation_mm().allFinite() || !pose.rotation().coeffs().allFinite()) {
      return rejected("finite poses", "pose " + std::to_string(i) + " that is not");
    }
    if (i > 0 && poses[i].time <= poses[i - 1].time) {
      return rejected("times that increase", "pose " + std::to_string(i) + " not after the last");
    }
    mean += pose.translation_mm() / static_cast<double>(poses.size());
  }
  const auto from_mean = [&](const Pose& pose) {
    return (pose.reference_from_image.translation_mm() - mean).norm();
  };
  const Pose& middle = *std::ranges::min_element(poses, {}, from_mean);
  const auto back = middle.reference_from_image.inverse();
  std::vector<Sample> samples;
  samples.reserve(poses.size());
  for (const Pose& pose : poses) {
    const auto step = back * pose.reference_from_image;
    if (step.translation_mm().norm() > kMostMotionMm) {
      std::ostringstream found;
      found << step.translation_mm().norm() << " mm";
      return rejected("a motion of at most 500 mm about the middle", found.str());
    }
    samples.push_back({Timestamp(pose.time - poses.front().time), step});
  }
  return RecordedHand(std::move(samples));
}

}  // namespace nav::sim
