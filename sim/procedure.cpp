// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/procedure.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "nav/check.hpp"
#include "nav/matrices.hpp"
#include "sim/motion/skin_track.hpp"
#include "sim/mount.hpp"
#include "sim/random.hpp"
#include "sim/shapes.hpp"

namespace nav::sim {
namespace {

using frames::Ct;
using frames::Image;
using frames::Needle;
using frames::Probe;
using frames::Reference;
using frames::Tracker;
using Vec = Eigen::Vector3d;

constexpr double kStartSeconds = 1.0;
constexpr double kPauseSeconds = 2.0;  // Pause between the sweep and the approach.
constexpr double kPressMm = 8;         // Depth of a curved face in the soft skin.
constexpr double kContactMm = 0.5;     // Half width for the skin's slope.
constexpr double kCameraMm = 1500;
constexpr double kParkedMm = 120;   // Distance of the needle tip from the entry while it waits.
constexpr double kReadyMm = 30;     // Distance when the approach begins.
constexpr double kHandErrorMm = 4;  // Sideways error before the needle touches the skin.

/// Rotation with a given y axis, and x as near as possible to \p x_wish.
Eigen::Quaterniond facing(const Vec& y, const Vec& x_wish) {
  Eigen::Matrix3d axes;
  axes.col(1) = y.normalized();
  axes.col(0) = (x_wish - x_wish.dot(axes.col(1)) * axes.col(1)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return Eigen::Quaterniond(axes);
}

/// Path of the hand below the costal arch, from the midline to the right flank; the beam fans up
/// and down and the probe turns about it. \p share: 0 to 1 of the path.
Transform<Ct, Image> sweep_view(const AbdomenPhantom& phantom, double share) {
  const double way = shapes::smooth_step(share);
  const double turn = 2 * std::numbers::pi * share;
  const Vec skin = phantom.skin_point(4.50 - 0.70 * way, 14 - 26 * way).mm;
  const Vec into = -outward(phantom, skin, kContactMm);
  const Vec across = into.cross(Vec::UnitZ());
  const Eigen::Quaterniond straight = facing(into, across);
  const Eigen::AngleAxisd tilt(0.18 + 0.38 * std::sin(1.5 * turn), Vec::UnitX());
  const Eigen::AngleAxisd roll(0.35 * std::sin(turn + 0.6), Vec::UnitY());
  const Eigen::AngleAxisd rock(0.12 * std::sin(2 * turn), Vec::UnitZ());
  return {(straight * roll * tilt * rock).normalized(), skin + kPressMm * into};
}

/// Number of samples between two points that block sound.
int blocked_samples(const AbdomenPhantom& phantom, const Vec& from, const Vec& to) {
  const int steps = static_cast<int>((to - from).norm() / 1.5);
  int blocked = 0;
  for (int i = 2; i <= steps; ++i) {
    const Vec p = from + (to - from) * (static_cast<double>(i) / steps);
    blocked += blocks_ultrasound(phantom.tissue({p})) ? 1 : 0;
  }
  return blocked;
}

/// Pose of the probe beside the entry, with the lesion and the needle path in its plane: the
/// position with the least obstructed view of the lesion. The needle enters from the -x side.
Transform<Ct, Image> choose_approach_view(const AbdomenPhantom& phantom, const NeedlePlan& plan) {
  const Vec entry = plan.entry_ct.mm;
  const Vec target = plan.target_ct.mm;
  const double entry_angle = std::atan2(entry.y(), entry.x()) + 2 * std::numbers::pi;
  double best_score = std::numeric_limits<double>::infinity();
  Vec best = Vec::Zero();
  for (double da = -0.6; da <= 0.61; da += 0.1) {
    for (double dz = -60; dz <= 60; dz += 10) {
      const Vec skin = phantom.skin_point(entry_angle + da, entry.z() + dz).mm;
      const double beside = (skin - entry).norm();
      if (beside < 38 || beside > 75) continue;
      const Vec view = (target - skin).normalized();
      const double slant =
          std::acos(std::clamp(-view.dot(outward(phantom, skin, kContactMm)), -1.0, 1.0));
      const double spread =
          std::asin(std::clamp(view.cross((target - entry).normalized()).norm(), 0.0, 1.0));
      if (slant > 0.75 || spread < 0.35) continue;
      const Vec halfway = 0.5 * (entry + target);
      // Neighbouring scan lines start beside the centre of the face and end beside the target.
      const Vec side = facing(view, skin - entry) * Vec::UnitX();
      int blocked = blocked_samples(phantom, skin, halfway);
      for (const double aside : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
        const Vec start = skin + kPressMm * view + 10.0 * aside * side;
        blocked += blocked_samples(phantom, start, target + 16.0 * aside * side);
      }
      const double score = blocked + 12.0 * slant + 0.05 * (target - skin).norm();
      if (score < best_score) {
        best_score = score;
        best = skin;
      }
    }
  }
  NAV_CHECK(std::isfinite(best_score), "no position for the probe beside the entry");
  const Vec view = (target - best).normalized();
  return {facing(view, best - entry), best + kPressMm * view};
}

Transform<Ct, Image> with_tremor(const Transform<Ct, Image>& pose, const ProcedureOptions& options,
                                 double seconds) {
  Vec shift;
  Vec turn;
  for (int axis = 0; axis < 3; ++axis) {
    const auto wobble = [&](std::uint64_t stream) {
      double sum = 0;
      for (std::uint64_t k = 0; k < 3; ++k) {  // Hand tremor of a few hertz.
        const double phase =
            2 * std::numbers::pi * unit_from_bits(hash_bits(options.seed, stream, k));
        const double hz = 0.6 + 1.7 * static_cast<double>(k) +
                          0.5 * unit_from_bits(hash_bits(options.seed, stream + 50, k));
        sum += std::sin(2 * std::numbers::pi * hz * seconds + phase) / 3.0;
      }
      return sum;
    };
    shift[axis] = options.tremor_mm * wobble(0x7472 + static_cast<std::uint64_t>(axis));
    turn[axis] = options.tremor_rad * wobble(0x7482 + static_cast<std::uint64_t>(axis));
  }
  Eigen::Quaterniond small = Eigen::Quaterniond::Identity();
  if (turn.norm() > 0) small = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return {(pose.rotation() * small).normalized(), pose.translation_mm() + shift};
}

const ProcedureOptions& checked(const ProcedureOptions& options) {
  NAV_CHECK(options.sweep_frames >= 2 && options.approach_frames >= 2, options.sweep_frames,
            options.approach_frames);
  NAV_CHECK(options.frame_rate_hz > 0 && options.frame_rate_hz <= 1000, options.frame_rate_hz);
  NAV_CHECK(validate(options.tracker).has_value());
  NAV_CHECK(validate(options.probe).has_value());
  // An image cannot arrive before its time stamp.
  NAV_CHECK(options.image_timing.latency >= options.image_timing.stamp_offset &&
            options.image_timing.latency >= Duration(0));
  return options;
}

/// Pose of the reference body on the front of the chest.
Transform<Ct, Reference> place_reference(Random random) {
  const Vec at = Vec(20, -125, 70) + random.offset(15);
  return {random_mount(random), at};
}
Transform<Tracker, Reference> place_camera(Random random) {
  const Vec at = Vec(0.15, -0.1, 1).normalized() * kCameraMm + random.offset(60);
  return {random_mount(random), at};
}

}  // namespace

Result<void> validate(const TrackerModel& model) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("simulated tracker: expected ") + what};
  };
  if (!(model.rate_hz > 0 && model.rate_hz <= 10000)) return reject("rate_hz in (0, 10000]");
  if (!(model.noise_mm >= 0 && model.noise_mm < 1e3)) return reject("noise_mm in [0, 1000)");
  if (!(model.noise_rad >= 0 && model.noise_rad < 1)) return reject("noise_rad in [0, 1)");
  if (model.latency < Duration(0)) return reject("latency >= 0");
  if (model.jitter < Duration(0)) return reject("jitter >= 0");
  if (!(model.dropout_probability >= 0 && model.dropout_probability <= 1)) {
    return reject("dropout_probability in [0, 1]");
  }
  if (model.dropout_samples < 1) return reject("dropout_samples >= 1");
  return {};
}

Procedure::Procedure(const ProcedureOptions& options)
    : options_(checked(options)),
      phantom_({options.seed, options.contrast}),
      plan_(phantom_.plan()),
      ct_from_reference_(place_reference(Random(options.seed, 0x726566))),
      tracker_from_reference_(place_camera(Random(options.seed, 0x63616d))),
      probe_from_image_(mount_probe(Random(options.seed, 0x6d6f756e74))),
      approach_view_(choose_approach_view(phantom_, plan_)) {
  const auto at = [](double seconds) { return Timestamp(from_seconds(seconds)); };
  const double period = 1.0 / options.frame_rate_hz;
  const double sweep_end = kStartSeconds + period * (options.sweep_frames - 1);
  const double approach = sweep_end + kPauseSeconds;
  phases_.push_back({.phase = Phase::kSweep,
                     .begin = at(kStartSeconds),
                     .end = at(sweep_end),
                     .first_frame = 0,
                     .frame_count = options.sweep_frames});
  phases_.push_back({.phase = Phase::kApproach,
                     .begin = at(approach),
                     .end = at(approach + period * (options.approach_frames - 1)),
                     .first_frame = options.sweep_frames,
                     .frame_count = options.approach_frames});
}

int Procedure::frame_count() const { return options_.sweep_frames + options_.approach_frames; }

Timestamp Procedure::frame_time(int index) const {
  NAV_CHECK(index >= 0 && index < frame_count(), index, frame_count());
  const PhaseInterval& phase = index < options_.sweep_frames ? phases_[0] : phases_[1];
  return phase.begin + from_seconds((index - phase.first_frame) / options_.frame_rate_hz);
}

Timestamp Procedure::end() const { return phases_.back().end; }

Transform<Ct, Image> Procedure::ct_from_image(Timestamp time) const {
  const Timestamp t = std::clamp(time, phases_.front().begin, end());
  const PhaseInterval& sweep = phases_[0];
  const PhaseInterval& approach = phases_[1];
  const auto share = [t](Timestamp begin, Timestamp end) {
    return std::clamp(to_seconds(t - begin) / to_seconds(end - begin), 0.0, 1.0);
  };
  const auto base = [&]() -> Transform<Ct, Image> {
    if (t <= sweep.end) return sweep_view(phantom_, share(sweep.begin, sweep.end));
    if (t >= approach.begin) return approach_view_;
    return interpolate(sweep_view(phantom_, 1.0), approach_view_,
                       shapes::smooth_step(share(sweep.end, approach.begin)));
  };
  return with_tremor(base(), options_, to_seconds(t));
}

Transform<Ct, Needle> Procedure::ct_from_needle(Timestamp time) const {
  const PhaseInterval& sweep = phases_[0];
  const PhaseInterval& approach = phases_[1];
  const auto share = [time](Timestamp begin, Timestamp end) {
    return shapes::smooth_step(to_seconds(time - begin) / to_seconds(end - begin));
  };
  const Vec path = plan_.target_ct.mm - plan_.entry_ct.mm;
  const Vec axis = path.normalized();
  // Distance along the planned path from the entry; negative: outside the patient.
  double along = -kParkedMm + (kParkedMm - kReadyMm) * share(sweep.end, approach.begin);
  if (time > approach.begin) {
    along = -kReadyMm + (path.norm() + kReadyMm) * share(approach.begin, approach.end);
  }
  const double aside = kHandErrorMm * std::clamp(-along / kReadyMm, 0.0, 1.0);
  const Eigen::Quaterniond rotation = rotation_between(Vec::UnitZ(), axis);
  return {rotation, plan_.entry_ct.mm + along * axis + aside * (rotation * Vec::UnitX())};
}

Transform<Tracker, Reference> Procedure::tracker_from_reference(Timestamp) const {
  return tracker_from_reference_;
}

Transform<Tracker, Probe> Procedure::tracker_from_probe(Timestamp time) const {
  return tracker_from_reference(time) * ct_from_reference_.inverse() * ct_from_image(time) *
         probe_from_image_.inverse();
}

Transform<Tracker, Needle> Procedure::tracker_from_needle(Timestamp time) const {
  return tracker_from_reference(time) * ct_from_reference_.inverse() * ct_from_needle(time);
}

}  // namespace nav::sim
