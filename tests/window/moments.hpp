// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>

#include "app/window/flat_engine.hpp"
#include "app/window/moment.hpp"

namespace nav::test {

inline constexpr auto kMs = std::chrono::milliseconds(1);
inline constexpr Timestamp kStart{std::chrono::seconds(100)};

/// A moment with a valid image, needle and numbers, acquired at a time, which become stale after
/// 100 ms.
inline std::shared_ptr<app::Moment> valid_moment(std::uint64_t number, Timestamp acquired) {
  auto moment = std::make_shared<app::Moment>();
  const Safety valid{SafetyState::kValid, ""};
  moment->number = number;
  moment->epoch.ultrasound = moment->epoch.plane = moment->epoch.placement = valid;
  moment->epoch.needle = valid;
  moment->epoch.ct_from_needle.emplace(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
  moment->epoch.guidance = NeedleGuidance{12.3, 12.0, 1.0, 0.1};
  moment->published = acquired + 20 * kMs;
  moment->acquired = acquired;
  moment->ultrasound_until = moment->needle_until = acquired + 100 * kMs;
  return moment;
}

inline app::ViewImage view_image_of(app::SharedMoment moment) {
  app::ViewImage view_image;
  view_image.moment = std::move(moment);
  return view_image;
}

inline app::FlatImages flat_of(const app::SharedMoment& moment) {
  app::FlatImages flat;
  flat.moment = moment;
  flat.views[app::ViewId::kUltrasound] = view_image_of(moment);
  flat.views[app::ViewId::kCt] = view_image_of(moment);
  return flat;
}

}  // namespace nav::test
