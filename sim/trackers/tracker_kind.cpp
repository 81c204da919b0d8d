// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/tracker_kind.hpp"

#include "sim/named_kind.hpp"
#include "sim/trackers/electromagnetic_tracker.hpp"
#include "sim/trackers/encoder_arm.hpp"
#include "sim/trackers/optical_tracker.hpp"

namespace nav::sim {
namespace {

class IdealSensor final : public TrackerSensor {
 public:
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t,
                                    std::uint64_t) const override {
    return {TrackingStatus::kOk, truth};
  }
  [[nodiscard]] const char* name() const override { return "ideal"; }
};

template <class Tracker, class Options>
std::shared_ptr<const TrackerSensor> seeded(std::uint64_t seed) {
  Options options;
  options.seed = seed;
  return std::make_shared<Tracker>(options);
}

}  // namespace

const char* to_string(TrackerKind kind) {
  switch (kind) {
    case TrackerKind::kIdeal:
      return "ideal";
    case TrackerKind::kOptical:
      return "optical";
    case TrackerKind::kElectromagnetic:
      return "electromagnetic";
    case TrackerKind::kArm:
      return "arm";
  }
  return "unknown";
}

Result<TrackerKind> tracker_kind_from(std::string_view name) {
  return kind_by_name("tracker",
                      {TrackerKind::kIdeal, TrackerKind::kOptical, TrackerKind::kElectromagnetic,
                       TrackerKind::kArm},
                      name);
}

std::shared_ptr<const TrackerSensor> make_sensor(TrackerKind kind, std::uint64_t seed) {
  switch (kind) {
    case TrackerKind::kIdeal:
      break;
    case TrackerKind::kOptical:
      return seeded<OpticalTracker, OpticalTrackerOptions>(seed);
    case TrackerKind::kElectromagnetic:
      return seeded<ElectromagneticTracker, ElectromagneticTrackerOptions>(seed);
    case TrackerKind::kArm:
      return seeded<EncoderArm, EncoderArmOptions>(seed);
  }
  return std::make_shared<IdealSensor>();
}

Eigen::Vector3d sweet_spot_mm(TrackerKind kind) {
  switch (kind) {
    case TrackerKind::kElectromagnetic:
      return {0, 0, 280};
    case TrackerKind::kArm:
      return {450, 0, 350};
    default:
      return {0, 0, 1500};
  }
}

}  // namespace nav::sim
