// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/pose_gate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

namespace nav::tracking {

const char* to_string(PoseRejection cause) {
  switch (cause) {
    case PoseRejection::kStatus:
      return "status_not_ok";
    case PoseRejection::kNotRigid:
      return "not_rigid";
    case PoseRejection::kOutsideVolume:
      return "outside_working_volume";
    case PoseRejection::kTime:
      return "time_not_increasing";
    case PoseRejection::kClock:
      return "clock_not_believed";
    case PoseRejection::kTooFast:
      return "too_fast";
    case PoseRejection::kUnconfirmed:
      return "off_path";
  }
  return "unknown";
}

Result<void> validate(const PoseGateOptions& options) {
  if (!(options.working_radius_mm > 0) || !std::isfinite(options.working_radius_mm)) {
    return Error{ErrorCode::kUsage, "pose gate: expected working_radius_mm > 0, found " +
                                        std::to_string(options.working_radius_mm)};
  }
  if (!(options.max_speed_mm_per_s > 0)) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_speed_mm_per_s > 0, found " +
                                        std::to_string(options.max_speed_mm_per_s)};
  }
  if (!(options.rigid.orthonormality > 0 && options.rigid.orthonormality < 0.1)) {
    return Error{ErrorCode::kUsage, "pose gate: expected an orthonormality tolerance in (0, 0.1)"};
  }
  for (const auto& [limit, what] :
       {std::pair{options.max_stuck_mm, "max_stuck_mm"},
        std::pair{options.max_turn_rad_per_s, "max_turn_rad_per_s"},
        std::pair{options.max_acceleration_mm_per_s2, "max_acceleration_mm_per_s2"},
        std::pair{options.max_acceleration_rad_per_s2, "max_acceleration_rad_per_s2"},
        std::pair{options.max_patient_speed_mm_per_s, "max_patient_speed_mm_per_s"},
        std::pair{options.max_patient_turn_rad_per_s, "max_patient_turn_rad_per_s"}}) {
    if (!(limit > 0)) {
      return Error{ErrorCode::kUsage, std::string("pose gate: expected ") + what + " > 0, found " +
                                          std::to_string(limit)};
    }
  }
  if (options.max_stuck <= Duration::zero()) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_stuck > 0"};
  }
  if (options.max_delay_change <= Duration::zero()) {
    return Error{ErrorCode::kUsage, "pose gate: expected max_delay_change > 0"};
  }
  return {};
}

namespace detail {
namespace {

constexpr double kLeastMm = 3;        // Distance from the path that noise may have, mm.
constexpr double kLeastRad = 0.04;    // Turn from the path that noise may have, rad.
constexpr double kOverUsual = 10;     // Largest distance from the path, as a multiple of the usual.
constexpr double kLostAfter = 0.3;    // Seconds without a pose after which no path continues.
constexpr double kForgetAfter = 1.0;  // Seconds without a pose after which a body may be anywhere.
constexpr double kNearMm = 8;  // A body that was lost and is this near to its path is admitted.
constexpr double kNearRad = 0.1;
constexpr double kCalmMmPerS2 = 3000;  // Accelerations of a hand at work.
constexpr double kCalmRadPerS2 = 20;
constexpr double kHandMmPerS = 600;  // Speed of a hand whose path is not known yet.
constexpr double kHandRadPerS = 6;
constexpr double kSpeedSeconds = 0.1;   // Time over which the speed of a body is averaged.
constexpr double kStuckLeverMm = 100;   // Distance from the body at which its turn counts.
constexpr double kSameMm = 2e-3;        // Changes of the last digits; a tracker's noise is larger.
constexpr double kSameRotation = 5e-6;  // Likewise, elements of the rotation matrix.
constexpr double kBackMm = 2;           // A reference this near to its place before is back.
constexpr double kBackRad = 0.02;

/// Running median: moves by a twentieth of itself.
double towards(double usual, double found, double least) {
  return std::max(least, usual * (found > usual ? 1.05 : 1 / 1.05));
}

std::string distance(double mm, double rad) {
  std::ostringstream text;
  text.precision(3);
  text << mm << " mm and " << rad * 180 / std::numbers::pi << " degrees";
  return text.str();
}

}  // namespace

double GateState::lost_after_s() const { return std::max(kLostAfter, 3 * usual_s_); }

std::string GateState::at(Timestamp time) const {
  return name_ + " at " + std::to_string(to_seconds(time)) + " s: ";
}

GateState::Verdict GateState::judge_time(const RawPose& raw) {
  // Every pose is checked: otherwise a clock that was set back would be reported as "too old" only.
  const DeviceTime stamp(DeviceClock::duration(raw.acquired.time_since_epoch().count()));
  const ClockModel::Reading clock = clock_.add(stamp, raw.received);
  const auto ms = [](Duration duration) { return std::to_string(1e3 * to_seconds(duration)); };
  if (newest_ && raw.acquired <= *newest_) {
    return {PoseRejection::kTime, at(raw.acquired) + "expected a time after " +
                                      std::to_string(to_seconds(*newest_)) + " s"};
  }
  if (raw.acquired - raw.received > options_.max_future) {
    return {PoseRejection::kTime, at(raw.acquired) + "expected a time at most " +
                                      ms(options_.max_future) + " ms after its reception at " +
                                      std::to_string(to_seconds(raw.received)) + " s"};
  }
  if (clock.fault) {
    const Duration usual = clock_.map(stamp) + clock_.usual_residual() - raw.acquired;
    return {PoseRejection::kClock, at(raw.acquired) + "expected to be received " + ms(usual) +
                                       " ms after acquisition as usual, found " +
                                       ms(raw.received - raw.acquired) +
                                       " ms: the device's clock was set, or its data were held up"};
  }
  // Stamps that are off the session clock by more than the tolerance are used, but not relied on.
  const Duration change = clock_.change();
  const bool was = clock_degraded_;
  clock_degraded_ = std::chrono::abs(change) > options_.max_delay_change;
  Verdict verdict{std::nullopt, "",
                  clock_degraded_ || raw.clock_unsure ? PoseDoubt::kClock : PoseDoubt::kNone};
  if (clock_degraded_ && !was) {
    verdict.message = at(raw.acquired) + "the time from acquisition to reception has changed by " +
                      ms(change) +
                      " ms since the beginning: the device's clock drifts or was set, or its data "
                      "take longer";
  }
  return verdict;
}

/// Distance of a pose from where the path of the last poses leads.
GateState::Distance GateState::off_path(const Place& place) const {
  const Place& last = path_[0];
  if (path_count_ < 2) {
    return {(place.position_mm - last.position_mm).norm(),
            place.rotation.angularDistance(last.rotation)};
  }
  const double ahead = to_seconds(place.time - last.time);
  const double before = to_seconds(last.time - path_[1].time);
  const double share = ahead / before;
  const Eigen::Vector3d step = last.position_mm - path_[1].position_mm;
  Eigen::AngleAxisd turn(last.rotation * path_[1].rotation.conjugate());
  if (turn.angle() > std::numbers::pi) turn.angle() -= 2 * std::numbers::pi;
  turn.angle() *= share;
  // A body that stops at once is no surprise.
  const double moving = (place.position_mm - last.position_mm - share * step).norm();
  const double stopped = (place.position_mm - last.position_mm).norm();
  return {std::min(moving, stopped), std::min(place.rotation.angularDistance(turn * last.rotation),
                                              place.rotation.angularDistance(last.rotation))};
}

/// Distance from the path that the largest acceleration of a hand reaches.
GateState::Distance GateState::hardest(const Place& place) const {
  const double seconds = to_seconds(place.time - path_[0].time);
  const double half = 0.5 * seconds * seconds;
  return {kLeastMm + half * options_.max_acceleration_mm_per_s2,
          kLeastRad + half * options_.max_acceleration_rad_per_s2};
}

/// Largest distance from the path at which a pose is admitted at once.
GateState::Distance GateState::limit(const Place& place) const {
  const double seconds = to_seconds(place.time - path_[0].time);
  if (options_.patient) {
    return {kLeastMm + options_.max_patient_speed_mm_per_s * seconds,
            kLeastRad + options_.max_patient_turn_rad_per_s * seconds};
  }
  const double half = 0.5 * seconds * seconds;
  const Distance most = hardest(place);
  if (path_count_ < 2) {
    return {kLeastMm + kHandMmPerS * seconds, kLeastRad + kHandRadPerS * seconds};
  }
  // Poses further apart than the ones before may leave the path by more.
  const double stretch = std::max(1.0, seconds / to_seconds(path_[0].time - path_[1].time));
  const Distance calm{kLeastMm + half * kCalmMmPerS2, kLeastRad + half * kCalmRadPerS2};
  return {std::min(most.mm, std::max(calm.mm, kOverUsual * usual_.mm * stretch * stretch)),
          std::min(most.rad, std::max(calm.rad, kOverUsual * usual_.rad * stretch * stretch))};
}

void GateState::follow(const Place& place) {
  if (path_count_ > 0 && to_seconds(place.time - path_[0].time) > lost_after_s()) path_count_ = 0;
  if (path_count_ == 2) {
    const Distance off = off_path(place);
    usual_ = {towards(usual_.mm, off.mm, 0.05 * kLeastMm),
              towards(usual_.rad, off.rad, 0.05 * kLeastRad)};
  }
  path_[1] = path_[0];
  path_[0] = place;
  path_count_ = std::min(path_count_ + 1, 2);
  aside_count_ = 0;
  impossible_ = false;
}

/// True for what trackers give for a tool that they do not see.
bool GateState::is_identity(const Place& place) {
  return place.position_mm.isZero(0) && place.rotation.vec().isZero(0);
}

/// Withholds a pose off the path. The third of three that continue each other is admitted, but for
/// a second not where no hand could have moved the body.
GateState::Verdict GateState::leave_path(const Place& place, const Distance& off,
                                         const Distance& limit) {
  const auto agrees = [&](const Place& a, const Place& b) {
    const double seconds = to_seconds(b.time - a.time);
    return (b.position_mm - a.position_mm).norm() <= kLeastMm + kHandMmPerS * seconds &&
           b.rotation.angularDistance(a.rotation) <= kLeastRad + kHandRadPerS * seconds;
  };
  // A body that went on would have been accelerated by more than a hand can.
  if (!options_.patient && to_seconds(place.time - path_[0].time) <= lost_after_s()) {
    const Distance most = hardest(place);
    impossible_ = impossible_ || off.mm > most.mm || off.rad > most.rad;
  }
  if (aside_count_ > 0 && !agrees(aside_[static_cast<std::size_t>(aside_count_ - 1)], place)) {
    aside_count_ = 0;
  }
  const bool forgotten = to_seconds(place.time - path_[0].time) >= kForgetAfter;
  if (is_identity(place) && !options_.patient) {
    return {PoseRejection::kUnconfirmed,
            at(place.time) +
                "expected a pose on the path of the poses before, found the identity, " +
                distance(off.mm, off.rad) + " off"};
  }
  if (aside_count_ == 2 && impossible_ && !forgotten) {
    aside_[0] = aside_[1];
    aside_count_ = 1;
  }
  if (aside_count_ < 2) {
    aside_[static_cast<std::size_t>(aside_count_++)] = place;
    if (off.mm <= limit.mm && off.rad <= limit.rad) {
      return {PoseRejection::kUnconfirmed,
              at(place.time) + "expected poses all the time, found the first after " +
                  std::to_string(std::lround(1e3 * to_seconds(place.time - path_[0].time))) +
                  " ms: poses are withheld until three agree"};
    }
    return {PoseRejection::kUnconfirmed,
            at(place.time) + "expected a pose within " + distance(limit.mm, limit.rad) +
                " of the path of the poses before, found " + distance(off.mm, off.rad)};
  }
  const Place before = path_[0];
  path_count_ = 0;
  follow(aside_[1]);
  follow(place);
  if (!options_.patient) return {};
  if (!place_before_) place_before_ = before;
  return {std::nullopt,
          at(place.time) + "the patient's reference was moved by " +
              distance((place.position_mm - before.position_mm).norm(),
                       place.rotation.angularDistance(before.rotation)) +
              ": register again, or put it back",
          PoseDoubt::kMoved};
}

GateState::Verdict GateState::judge_motion(const Place& place) {
  if (place.position_mm.norm() > options_.working_radius_mm) {
    std::ostringstream text;
    text << at(place.time) << "expected a position within " << options_.working_radius_mm
         << " mm of the tracker, found " << place.position_mm.norm() << " mm";
    return {PoseRejection::kOutsideVolume, text.str()};
  }
  if (path_count_ == 0) {
    follow(place);
    return {};
  }
  const double seconds = to_seconds(place.time - path_[0].time);
  if (seconds < std::max(kForgetAfter, 3 * usual_s_)) {
    const double mm = (place.position_mm - path_[0].position_mm).norm();
    const double turn = place.rotation.angularDistance(path_[0].rotation);
    if (mm > kLeastMm + options_.max_speed_mm_per_s * seconds ||
        turn > kLeastRad + options_.max_turn_rad_per_s * seconds) {
      impossible_ = true;
      return {PoseRejection::kTooFast, at(place.time) + "expected at most " +
                                           std::to_string(options_.max_speed_mm_per_s) +
                                           " mm/s, found " + distance(mm, turn) + " in " +
                                           std::to_string(1e3 * seconds) + " ms"};
    }
  }
  const Distance off = off_path(place);
  const Distance most = limit(place);
  // A body that was lost may be anywhere, unless it is near its path.
  const bool near = off.mm <= kNearMm && off.rad <= kNearRad;
  // After poses aside, what the growing limits allow may be one of them.
  const bool aside = (aside_count_ > 0 || is_identity(place)) && !near && !options_.patient;
  const bool lost = seconds > lost_after_s() && !near && !options_.patient;
  if (lost || aside || off.mm > most.mm || off.rad > most.rad) return leave_path(place, off, most);
  follow(place);
  if (place_before_) {
    const bool back = (place.position_mm - place_before_->position_mm).norm() <= kBackMm &&
                      place.rotation.angularDistance(place_before_->rotation) <= kBackRad;
    if (back) place_before_.reset();
  }
  return {std::nullopt, "", place_before_ ? PoseDoubt::kMoved : PoseDoubt::kNone};
}

/// True if two poses differ in their last digits only.
bool GateState::is_same(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
  const Eigen::Matrix4d change = (a - b).cwiseAbs();
  return change.topRightCorner<3, 1>().maxCoeff() <= kSameMm &&
         change.topLeftCorner<3, 3>().maxCoeff() <= kSameRotation;
}

/// True for a pose of a tool that has not changed, but for its last digits, for too long.
bool GateState::is_stuck(const RawPose& raw) {
  if (options_.patient) return false;
  if (!is_same(raw.tracker_from_body, same_)) {
    const double seconds = to_seconds(raw.acquired - same_since_);
    if (seconds > 0) {
      // Frobenius norm: a small turn by x changes the rotation matrix by sqrt(2) x.
      const double turned =
          (raw.tracker_from_body - same_).topLeftCorner<3, 3>().norm() / std::numbers::sqrt2;
      const double moved = (raw.tracker_from_body - same_).topRightCorner<3, 1>().norm();
      const double share = std::min(1.0, seconds / kSpeedSeconds);
      speed_mm_s_ += share * ((moved + kStuckLeverMm * turned) / seconds - speed_mm_s_);
    }
    same_ = raw.tracker_from_body;
    same_since_ = raw.acquired;
    same_count_ = 0;
    said_stuck_ = false;
    return false;
  }
  ++same_count_;
  constexpr int kLeastRepeats = 3;
  const Duration stuck = raw.acquired - same_since_;
  const bool long_enough = stuck > options_.max_stuck && same_count_ >= kLeastRepeats;
  const bool far_enough = speed_mm_s_ * to_seconds(stuck) > options_.max_stuck_mm;
  return long_enough || far_enough;
}

Finding GateState::stuck_finding(const RawPose& raw) const {
  const Duration stuck = raw.acquired - same_since_;
  return {.subject = name_,
          .key = "pose",
          .values = {std::string(raw.tracker_from_body == same_
                                     ? "unchanged to the last digit from "
                                     : "unchanged but for the last digits from ") +
                     std::to_string(to_seconds(same_since_)) + " s on, for " +
                     std::to_string(to_seconds(stuck)) +
                     " s or more (does the tracker repeat the last pose of a "
                     "tool that it does not see?)"},
          .used = "these poses, as degraded"};
}

GateState::Verdict GateState::judge(const RawPose& raw) {
  Verdict time = judge_time(raw);
  if (time.rejection) return time;
  if (newest_) {
    const double seconds = to_seconds(raw.acquired - *newest_);
    usual_s_ = usual_s_ > 0 ? towards(usual_s_, seconds, 1e-4) : seconds;
  }
  newest_ = raw.acquired;

  if (raw.status != TrackingStatus::kOk && raw.status != TrackingStatus::kUnknown) {
    return {PoseRejection::kStatus,
            at(raw.acquired) + "expected status ok, found " + nav::to_string(raw.status)};
  }
  const auto rotation =
      nav::detail::rotation_from_matrix(raw.tracker_from_body, name_, options_.rigid);
  if (!rotation) {
    return {PoseRejection::kNotRigid,
            rotation.error().message + " at " + std::to_string(to_seconds(raw.acquired)) + " s"};
  }
  Verdict verdict =
      judge_motion({raw.acquired, raw.tracker_from_body.topRightCorner<3, 1>(), *rotation});
  // A pose that is rejected may be stuck as well, and admitted later.
  const bool stuck = is_stuck(raw);
  if (verdict.rejection) return verdict;
  if (verdict.doubt == PoseDoubt::kNone) verdict.doubt = time.doubt;
  if (verdict.message.empty()) verdict.message = std::move(time.message);
  if (!stuck) return verdict;
  verdict.doubt = PoseDoubt::kStuck;
  if (!std::exchange(said_stuck_, true)) verdict.finding = stuck_finding(raw);
  return verdict;
}

}  // namespace detail
}  // namespace nav::tracking
