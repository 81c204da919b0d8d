// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/cohort.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bench/registration/altered_sweep.hpp"
#include "nav/check.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/motion/pressure.hpp"
#include "sim/motion/skin_track.hpp"
#include "sim/persistence.hpp"
#include "sim/ultrasound.hpp"

namespace nav::bench {
namespace {

using Vec = Eigen::Vector3d;
using ImagePose = Transform<frames::Ct, frames::Image>;

constexpr double kPressMm = 8;  // Depth that a curved probe face is pressed into the soft skin.
constexpr double kFramesPerSecond = 20;
constexpr double kSeenMm = 8;
constexpr double kRadPerMm = 0.8 * std::numbers::pi / 180;
constexpr double kMaxStartRad = 30 * std::numbers::pi / 180;

/// Position of the probe on the skin and its orientation, rad and mm.
struct Hand {
  double around;  ///< Angle about the body, as in AbdomenPhantom::skin_point().
  double z_mm;
  double tilt, turn, rock;  ///< About the image's x, y (the beam) and z.
};

double ease(double t) { return t * t * (3 - 2 * t); }

/// share: fraction of the sweep, 0 to 1.
Hand hand_at(SweepPath path, double share) {
  const double way = ease(share);
  const double wave = std::sin(2 * std::numbers::pi * share);
  switch (path) {
    case SweepPath::kSubcostal:
      return {.around = 4.50 - 0.70 * way,
              .z_mm = 14 - 26 * way,
              .tilt = 0.18 + 0.38 * wave,
              .turn = 0.35 * wave,
              .rock = 0.1 * wave};
    case SweepPath::kFan:
      return {.around = 4.25,
              .z_mm = 4,
              .tilt = -0.30 + 0.95 * way,
              .turn = 0.1 * wave,
              .rock = 0.05 * wave};
    case SweepPath::kSlide:
      return {.around = 4.55 - 0.75 * way,
              .z_mm = 12 - 22 * way,
              .tilt = 0.30 + 0.04 * wave,
              .turn = 0.08 * wave,
              .rock = 0.04 * wave};
    case SweepPath::kSagittal:
      return {.around = 4.55 - 0.60 * way,
              .z_mm = 8 - 16 * way,
              .tilt = 0.06 * wave,
              .turn = 1.45 + 0.1 * wave,
              .rock = -0.25 - 0.2 * wave};
    case SweepPath::kCross:
      return {.around = 4.20,
              .z_mm = 4,
              .tilt = 0.35 * std::sin(3 * std::numbers::pi * share) + 0.1,
              .turn = 1.5 * way,
              .rock = 0.05 * wave};
    case SweepPath::kRibs:
      return {.around = 3.85 - 0.45 * way,
              .z_mm = 48 - 30 * way,
              .tilt = 0.05 + 0.25 * wave,
              .turn = 0.3 + 0.2 * wave,
              .rock = 0.1 * wave};
  }
  return {};
}

ImagePose view_of(const sim::AbdomenPhantom& phantom, const Hand& hand) {
  const Vec skin = phantom.skin_point(hand.around, hand.z_mm).mm;
  const Vec into = -sim::outward(phantom, skin, 0.5);
  Eigen::Matrix3d axes;
  axes.col(1) = into;
  axes.col(0) = into.cross(Vec::UnitZ()).normalized();
  axes.col(2) = axes.col(0).cross(into);
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(axes) * Eigen::AngleAxisd(hand.turn, Vec::UnitY()) *
      Eigen::AngleAxisd(hand.tilt, Vec::UnitX()) * Eigen::AngleAxisd(hand.rock, Vec::UnitZ());
  return {turned.normalized(), skin + kPressMm * into};
}

/// The path with the deviations of this hand: offset and wobble.
std::vector<ImagePose> views(const Patient& patient, const SweepRequest& request) {
  sim::Random random(request.seed, 0x68616e64);
  const Hand off{.around = random.uniform(-0.06, 0.06),
                 .z_mm = random.uniform(-5, 5),
                 .tilt = random.uniform(-0.06, 0.06),
                 .turn = random.uniform(-0.1, 0.1),
                 .rock = random.uniform(-0.05, 0.05)};
  const double phase = random.uniform(0, 2 * std::numbers::pi);
  const double unevenness = request.level ? errors_of(*request.level).unevenness : 0;
  std::vector<ImagePose> all;
  for (int i = 0; i < request.frames; ++i) {
    const double share = static_cast<double>(i) / (request.frames - 1);
    Hand hand = hand_at(request.path, sim::uneven_share(share, unevenness, request.seed));
    const double wobble = std::sin(0.9 * i + phase);
    hand.around += off.around;
    hand.z_mm += off.z_mm + 0.3 * wobble;
    hand.tilt += off.tilt + 0.004 * wobble;
    hand.turn += off.turn;
    hand.rock += off.rock + 0.004 * std::cos(1.3 * i + phase);
    all.push_back(view_of(patient.phantom, hand));
  }
  return all;
}

}  // namespace

const char* to_string(SweepPath path) {
  constexpr std::array<const char*, kSweepPaths + 1> kNames{"subcostal", "fan",   "slide",
                                                            "sagittal",  "cross", "ribs"};
  return kNames[static_cast<std::size_t>(path)];
}

Transform<frames::Reference, frames::Image> measured(
    const Transform<frames::Reference, frames::Image>& exact, sim::Random& random,
    double tracker_mm, double tracker_rad) {
  const Vec turn = random.offset(std::sqrt(3.0) * tracker_rad);
  const Vec shift = random.offset(std::sqrt(3.0) * tracker_mm);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return {(q * exact.rotation()).normalized(), exact.translation_mm() + shift};
}

bool seen(const Point<frames::Ct>& p, const std::vector<ImagePose>& poses,
          const SectorOutline& outline) {
  return std::ranges::any_of(poses, [&](const ImagePose& pose) {
    const Vec q = (pose.inverse() * p).mm;
    return std::abs(q.z()) < kSeenMm && outline.contains(q.head<2>());
  });
}

Patient make_patient(std::uint64_t seed) {
  const sim::AbdomenPhantom phantom({.seed = seed});
  sim::CtOptions options;
  options.seed = seed;
  auto ct = sim::scan_ct(phantom, options);
  NAV_CHECK(ct.has_value(), seed);
  sim::Random random(seed, 0x706f7365);
  const double angle = random.uniform(0.8, 2.6);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, random.direction()));
  return {seed, phantom, std::make_shared<const Volume>(std::move(*ct)),
          CtPose(turn, Vec(20, -125, 70) + random.offset(15))};
}

RecordedSweep record_sweep(const Patient& patient, const SweepRequest& request) {
  NAV_CHECK(request.frames >= 2, request.frames);
  sim::ProbeModel transducer = sim::convex_abdominal();
  transducer.model = request.model;
  const auto errors_of_level =
      request.level ? std::optional(errors_of(*request.level)) : std::nullopt;
  double tracker_mm = kTrackerMm;
  double tracker_rad = kTrackerRad;
  if (errors_of_level) {
    tracker_mm = errors_of_level->tracker_mm;
    tracker_rad = kTrackerRad / kTrackerMm * tracker_mm;
    sim::set_image_errors(*errors_of_level, transducer);
  }
  const sim::UltrasoundSimulator probe(patient.phantom, transducer, request.seed);
  const auto poses = views(patient, request);
  const auto reference_from_ct = patient.truth.inverse();
  sim::Random errors(request.seed, 0x747261636b);
  const double pressure_mm = errors_of_level ? errors_of_level->pressure_mm : 0;
  sim::Persistence persistence(transducer.persistence);
  std::vector<TrackedImage> frames;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Timestamp time(from_seconds(static_cast<double>(i) / kFramesPerSecond));
    const auto pressed = pressure_mm > 0 ? sim::pressed_by(poses[i], transducer, pressure_mm)
                                         : std::shared_ptr<const sim::Warp>();
    UltrasoundImage image = probe.simulate(poses[i], time, i, {}, pressed.get());
    persistence.apply(image);
    frames.push_back({std::move(image),
                      measured(reference_from_ct * poses[i], errors, tracker_mm, tracker_rad),
                      Duration{0}});
  }
  auto sweep = Sweep::create(std::move(frames), "simulated");
  NAV_CHECK(sweep.has_value());
  RecordedSweep recorded{request.path, std::move(*sweep), {}};
  if (errors_of_level) {
    const LevelErrors& e = *errors_of_level;
    if (e.calibration_mm > 0) {
      recorded.sweep =
          miscalibrated(recorded.sweep, e.calibration_mm, e.calibration_rad, request.seed);
    }
    if (e.delay_ms > 0) {
      recorded.sweep = delayed(recorded.sweep, from_seconds(1e-3 * e.delay_ms));
    }
  }
  const auto outline = probe.outline();
  NAV_CHECK(outline.has_value());
  for (const auto& target : patient.phantom.targets()) {
    if (seen(target, poses, *outline)) recorded.targets.push_back(target);
  }
  NAV_CHECK(!recorded.targets.empty(), request.seed);
  return recorded;
}

double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets) {
  return target_error_mm(found, truth, targets, targets);
}

double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets,
                       const std::vector<Point<frames::Ct>>& lying) {
  NAV_CHECK(!targets.empty() && targets.size() == lying.size(), targets.size(), lying.size());
  const auto back = truth.inverse();
  double sum = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    sum += (found * (back * lying[i]) - targets[i]).v.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(targets.size()));
}

CtPose start_at(double error_mm, const CtPose& truth, const RecordedSweep& recorded,
                std::uint64_t seed) {
  sim::Random random(seed, 0x7374617274);
  const Vec axis = random.direction();
  const Vec direction = random.direction();
  const Vec centre = (truth * recorded.sweep.centroid()).mm;
  const auto off = [&](double rad, double mm) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(rad, axis));
    return CtPose((q * truth.rotation()).normalized(),
                  centre + q * (truth.translation_mm() - centre) + mm * direction);
  };
  const auto error = [&](double rad, double mm) {
    return target_error_mm(off(rad, mm), truth, recorded.targets);
  };
  double rad = std::min(kRadPerMm * error_mm, kMaxStartRad);
  while (error(rad, 0) > 0.9 * error_mm) rad *= 0.9;
  // The error grows with the distance once it is longer than twice the effect of the rotation.
  double low = 0;
  double high = 3 * error_mm;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (error(rad, middle) < error_mm ? low : high) = middle;
  }
  return off(rad, high);
}

}  // namespace nav::bench
