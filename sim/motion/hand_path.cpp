// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/hand_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav/check.hpp"
#include "nav/matrices.hpp"
#include "sim/named_kind.hpp"
#include "sim/random.hpp"
#include "sim/shapes.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::uint64_t kWobbleStream = 0x776f62;
constexpr int kWaves = 4;
constexpr std::uint64_t kPaceStream = 0x70616365;
constexpr double kMostBesideMm = 4 / 0.6;  // Largest way beside the straight one, over unevenness.

/// Sum of waves with unit variance between two frequencies.
double band(std::uint64_t seed, std::uint64_t stream, double low_hz, double high_hz, double s) {
  double sum = 0;
  for (std::uint64_t k = 0; k < kWaves; ++k) {
    const double place = unit_from_bits(hash_bits(seed, stream, 2 * k));
    const double hz = low_hz + (high_hz - low_hz) * (static_cast<double>(k) + place) / kWaves;
    const double phase = unit_from_bits(hash_bits(seed, stream, 2 * k + 1));
    sum += std::sin(2 * std::numbers::pi * (hz * s + phase));
  }
  return sum * std::sqrt(2.0 / kWaves);
}

/// Way beside the straight one, mm: 0 at both ends.
double beside_mm(double share, double unevenness, std::uint64_t seed) {
  const double first = unit_from_bits(hash_bits(seed, kPaceStream, 10)) - 0.5;
  const double second = unit_from_bits(hash_bits(seed, kPaceStream, 11)) - 0.5;
  return kMostBesideMm * unevenness *
         (first * std::sin(std::numbers::pi * share) +
          second * std::sin(2 * std::numbers::pi * share));
}

/// The recorded hand on the skin of a patient: turned with the skin, as deep as the middle pose.
std::vector<HandPath::Pose> on_skin(const Anatomy& patient, const HandPath::Pose& middle,
                                    const RecordedHand& hand) {
  constexpr double kFootprintMm = 8;
  constexpr int kCorrections = 4;
  const double depth_mm = patient.skin_distance_mm({middle.translation_mm()});
  const Vec up = outward(patient, middle.translation_mm(), kFootprintMm);
  std::vector<HandPath::Pose> poses;
  for (const auto& sample : hand.samples()) {
    const HandPath::Pose flat = middle * sample.step;
    Vec at = flat.translation_mm();
    for (int i = 0; i < kCorrections; ++i) {
      at -= (patient.skin_distance_mm({at}) - depth_mm) * outward(patient, at, kFootprintMm);
    }
    const Eigen::Quaterniond turn = rotation_between(up, outward(patient, at, kFootprintMm));
    const HandPath::Pose placed((turn * flat.rotation()).normalized(), at);
    // The probe stays where the patient has no skin.
    poses.push_back(at.allFinite() || poses.empty() ? placed : poses.back());
  }
  return poses;
}

}  // namespace

const char* to_string(HandPathKind kind) {
  switch (kind) {
    case HandPathKind::kSweep:
      return "sweep";
    case HandPathKind::kFan:
      return "fan";
    case HandPathKind::kRock:
      return "rock";
    case HandPathKind::kTilt:
      return "tilt";
  }
  return "unknown";
}

Result<HandPathKind> hand_path_kind_from(std::string_view name) {
  return kind_by_name(
      "path", {HandPathKind::kSweep, HandPathKind::kFan, HandPathKind::kRock, HandPathKind::kTilt},
      name);
}

Result<void> validate(const HandPathOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("hand path: expected ") + what};
  };
  const auto within = [](double v, double high) { return v >= 0 && v <= high; };
  if (!within(o.length_mm, 500)) return reject("a length of 0 to 500 mm");
  if (!within(o.angle_rad, 3)) return reject("an angle of 0 to 3 rad");
  if (o.end <= o.begin) return reject("an end after the begin");
  if (!within(o.unevenness, 0.9)) return reject("an unevenness of 0 to 0.9");
  if (o.recorded && o.end - o.begin > o.recorded->duration()) {
    return reject("a duration of at most that of the recorded hand");
  }
  if (!within(o.tremor.drift_mm, 20)) return reject("a drift of 0 to 20 mm");
  if (!within(o.tremor.drift_rad, 0.2)) return reject("a drift of 0 to 0.2 rad");
  if (!within(o.tremor.tremor_mm, 5)) return reject("a tremor of 0 to 5 mm");
  if (!within(o.tremor.tremor_rad, 0.05)) return reject("a tremor of 0 to 0.05 rad");
  return {};
}

HandWobble wobble_at(const HandTremor& tremor, Timestamp time) {
  const double s = to_seconds(time);
  HandWobble wobble;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t stream = kWobbleStream + 4 * static_cast<std::uint64_t>(axis);
    const auto slow = [&](std::uint64_t k) { return band(tremor.seed, stream + k, 0.1, 1, s); };
    const auto fast = [&](std::uint64_t k) { return band(tremor.seed, stream + k, 8, 12, s); };
    wobble.shift_mm[axis] = tremor.drift_mm * slow(0) + tremor.tremor_mm * fast(1);
    wobble.turn_rad[axis] = tremor.drift_rad * slow(2) + tremor.tremor_rad * fast(3);
  }
  return wobble;
}

double uneven_share(double share, double unevenness, std::uint64_t seed) {
  constexpr int kRhythms = 3;
  double sum = share;
  for (int k = 1; k <= kRhythms; ++k) {
    const double phase =
        unit_from_bits(hash_bits(seed, kPaceStream, static_cast<std::uint64_t>(k)));
    const double angle = 2 * std::numbers::pi;
    sum += unevenness / kRhythms / (angle * k) *
           (std::sin(angle * (k * share + phase)) - std::sin(angle * phase));
  }
  return sum;
}

HandPath::HandPath(const Pose& middle, const HandPathOptions& options)
    : middle_(middle), options_(options) {
  const auto ok = validate(options);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
  if (!options.recorded) return;
  for (const auto& sample : options.recorded->samples()) recorded_.push_back(middle * sample.step);
}

HandPath::HandPath(const Anatomy& patient, const Pose& middle, const HandPathOptions& options)
    : HandPath(middle, options) {
  if (options.recorded) {
    recorded_ = on_skin(patient, middle, *options.recorded);
  } else {
    skin_.emplace(patient, middle, 0.5 * options.length_mm);
  }
}

void HandPath::hold(const Pose& pose, Timestamp arrival) {
  NAV_CHECK(arrival > options_.end);
  held_ = Held{pose, arrival};
}

HandPath::Pose HandPath::recorded_at(Timestamp time) const {
  const auto& samples = options_.recorded->samples();
  const Timestamp at(std::clamp(time - options_.begin, Duration(0), options_.end - options_.begin));
  const auto after = std::ranges::upper_bound(samples, at, {}, &RecordedHand::Sample::time);
  const auto next = std::clamp<std::ptrdiff_t>(after - samples.begin(), 1,
                                               static_cast<std::ptrdiff_t>(samples.size()) - 1);
  const auto i = static_cast<std::size_t>(next);
  const double share =
      to_seconds(at - samples[i - 1].time) / to_seconds(samples[i].time - samples[i - 1].time);
  return interpolate(recorded_[i - 1], recorded_[i], std::clamp(share, 0.0, 1.0));
}

HandPath::Pose HandPath::steady(Timestamp time) const {
  const auto share_of = [time](Timestamp begin, Timestamp end) {
    return shapes::smooth_step(to_seconds(time - begin) / to_seconds(end - begin));
  };
  if (held_ && time > options_.end) {
    return interpolate(steady(options_.end), held_->pose, share_of(options_.end, held_->arrival));
  }
  if (options_.recorded) return recorded_at(time);
  double share = share_of(options_.begin, options_.end);
  double beside = 0;
  if (options_.unevenness > 0) {
    share = uneven_share(share, options_.unevenness, options_.tremor.seed);
    beside = beside_mm(share, options_.unevenness, options_.tremor.seed);
  }
  const double way = share - 0.5;
  double slide_mm = 0;
  Vec axis = Vec::UnitX();
  double angle = 0;
  switch (options_.kind) {
    case HandPathKind::kSweep:
      slide_mm = way * options_.length_mm;
      break;
    case HandPathKind::kFan:
      angle = way * options_.angle_rad;
      break;
    case HandPathKind::kRock:
      axis = Vec::UnitZ();
      angle = way * options_.angle_rad;
      break;
    case HandPathKind::kTilt:
      slide_mm = way * options_.length_mm;
      angle = 0.5 * options_.angle_rad * std::sin(2 * std::numbers::pi * way);
      break;
  }
  using Step = Transform<frames::Image, frames::Image>;
  const Pose there = skin_ ? skin_->at(slide_mm)
                           : middle_ * Step(Eigen::Quaterniond::Identity(), {0, 0, slide_mm});
  if (!(std::abs(slide_mm) > 0)) beside = 0;
  return there * Step(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), {beside, 0, 0});
}

HandPath::Pose HandPath::at(Timestamp time) const {
  if (options_.recorded && time <= options_.end) return recorded_at(time);
  const HandWobble wobble = wobble_at(options_.tremor, time);
  const double angle = wobble.turn_rad.norm();
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  if (angle > 0) turn = Eigen::AngleAxisd(angle, wobble.turn_rad / angle);
  return steady(time) * Transform<frames::Image, frames::Image>(turn, wobble.shift_mm);
}

}  // namespace nav::sim
