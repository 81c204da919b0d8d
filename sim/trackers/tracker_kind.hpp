// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>

#include "nav/result.hpp"
#include "sim/trackers/tracker_sensor.hpp"

namespace nav::sim {

enum class TrackerKind { kIdeal, kOptical, kElectromagnetic, kArm };

/// Stable lower-case name ("optical"), and its inverse; kUsage for an unknown name.
const char* to_string(TrackerKind kind);
Result<TrackerKind> tracker_kind_from(std::string_view name);

/// Tracker of a kind with its default options.
std::shared_ptr<const TrackerSensor> make_sensor(TrackerKind kind, std::uint64_t seed);

/// A tracker whose good poses have white noise on top: \p noise_mm per axis (standard deviation),
/// and 0.01 rad for each mm about each axis of the body. 0: the tracker itself.
std::shared_ptr<const TrackerSensor> with_noise(std::shared_ptr<const TrackerSensor> tracker,
                                                double noise_mm, std::uint64_t seed);

/// Centre of the measurement volume, Tracker frame.
Eigen::Vector3d sweet_spot_mm(TrackerKind kind);

}  // namespace nav::sim
