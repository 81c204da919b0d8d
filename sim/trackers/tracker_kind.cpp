// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/tracker_kind.hpp"

#include <Eigen/Geometry>

#include "sim/named_kind.hpp"
#include "sim/random.hpp"
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

class NoisySensor final : public TrackerSensor {
 public:
  NoisySensor(std::shared_ptr<const TrackerSensor> tracker, double noise_mm, std::uint64_t seed)
      : tracker_(std::move(tracker)), noise_mm_(noise_mm), seed_(seed) {}
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const override {
    constexpr double kRadPerMm = 0.01;
    Observation seen = tracker_->observe(truth, body, sample);
    if (seen.status != TrackingStatus::kOk) return seen;
    const std::uint64_t own = hash_bits(seed_, body, sample);
    Eigen::Vector3d shift, turn;
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::uint64_t>(axis);
      shift[axis] = noise_mm_ * normal_at(own, 0x7368696674, k);
      turn[axis] = kRadPerMm * noise_mm_ * normal_at(own, 0x7475726e, k);
    }
    const Eigen::AngleAxisd turned(turn.norm(), turn.normalized());
    seen.pose.topLeftCorner<3, 3>() = seen.pose.topLeftCorner<3, 3>() * turned.toRotationMatrix();
    seen.pose.topRightCorner<3, 1>() += shift;
    return seen;
  }
  [[nodiscard]] const char* name() const override { return tracker_->name(); }

 private:
  std::shared_ptr<const TrackerSensor> tracker_;
  double noise_mm_;
  std::uint64_t seed_;
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

std::shared_ptr<const TrackerSensor> with_noise(std::shared_ptr<const TrackerSensor> tracker,
                                                double noise_mm, std::uint64_t seed) {
  if (!(noise_mm > 0)) return tracker;
  return std::make_shared<NoisySensor>(std::move(tracker), noise_mm, seed);
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
