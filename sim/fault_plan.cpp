// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <optional>
#include <ranges>

#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

constexpr std::uint64_t kFaultStream = 0x6661756c74;

/// Members in the order of FaultKind.
constexpr std::array<double FaultPlan::*, 11> kChances = {
    &FaultPlan::drop,         &FaultPlan::duplicate,   &FaultPlan::reorder,
    &FaultPlan::future_stamp, &FaultPlan::clock_step,  &FaultPlan::stall,
    &FaultPlan::empty,        &FaultPlan::nan,         &FaultPlan::flip,
    &FaultPlan::mirror,       &FaultPlan::denormalised};

std::optional<double> chance_from(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0 && value <= 1)) {
    return std::nullopt;
  }
  return value;
}

Error bad_faults(std::string_view found) {
  std::string names;
  for (std::size_t k = 0; k < kChances.size(); ++k) {
    names += (k == 0 ? "" : ", ") + std::string(to_string(static_cast<FaultKind>(k)));
  }
  return {ErrorCode::kUsage, "faults: expected a chance in [0, 1] or NAME=CHANCE,... of " + names +
                                 "; found '" + std::string(found) + "'"};
}

const FaultPlan& checked(const FaultPlan& plan) {
  const auto ok = validate(plan);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
  return plan;
}

template <class Item, class Source>
Result<Item> next_of(Source& source, detail::FaultInjector<Item>& injector, Deadline deadline) {
  for (;;) {
    if (injector.front() != nullptr && injector.front()->received <= deadline) {
      return injector.pop();
    }
    auto item = source.next(deadline);
    if (!item) {
      if (item.error().code != ErrorCode::kEndOfStream) return item.error();
      injector.flush();
      if (injector.front() == nullptr) return item.error();
      if (injector.front()->received <= deadline) return injector.pop();
      return Error{ErrorCode::kTimeout, "faulty source: no sample before the deadline"};
    }
    injector.push(std::move(*item));
  }
}

}  // namespace

const char* to_string(FaultKind kind) {
  constexpr std::array<const char*, 11> kNames = {
      "drop",  "duplicate", "reorder", "future_stamp", "clock_step",  "stall",
      "empty", "nan",       "flip",    "mirror",       "denormalised"};
  return kNames[static_cast<std::size_t>(kind)];
}

FaultPlan FaultPlan::everything(double chance, std::uint64_t seed) {
  FaultPlan plan;
  plan.seed = seed;
  for (const auto of : kChances) plan.*of = chance;
  return plan;
}

Result<FaultPlan> FaultPlan::from(std::string_view text, std::uint64_t seed) {
  if (const auto chance = chance_from(text)) return everything(*chance, seed);
  if (text.empty()) return bad_faults(text);
  FaultPlan plan;
  plan.seed = seed;
  for (const auto part : std::views::split(text, ',')) {
    const std::string_view item(part.begin(), part.end());
    const std::size_t sign = item.find('=');
    if (sign == std::string_view::npos) return bad_faults(item);
    const auto chance = chance_from(item.substr(sign + 1));
    std::size_t kind = 0;
    while (kind < kChances.size() &&
           item.substr(0, sign) != to_string(static_cast<FaultKind>(kind))) {
      ++kind;
    }
    if (!chance || kind == kChances.size()) return bad_faults(item);
    plan.*kChances[kind] = *chance;
  }
  return plan;
}

Result<void> validate(const FaultPlan& plan) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("fault plan: expected ") + what};
  };
  const auto chance = [&](auto of) { return plan.*of >= 0 && plan.*of <= 1; };
  if (!std::ranges::all_of(kChances, chance)) return reject("chances in [0, 1]");
  if (plan.drop_samples < 1) return reject("drop_samples >= 1");
  if (plan.step_samples < 1) return reject("step_samples >= 1");
  if (plan.future <= Duration::zero()) return reject("future > 0");
  if (plan.step == Duration::zero()) return reject("a step that is not 0");
  if (plan.stall_length <= Duration::zero()) return reject("stall_length > 0");
  if (!(plan.norm > 0 && plan.norm < 1e3)) return reject("a norm in (0, 1000)");
  return {};
}

namespace detail {

template <class Item>
bool FaultInjector<Item>::happens(FaultKind kind, double chance, Timestamp received) {
  const auto of = kFaultStream + 64 * stream_ + static_cast<std::uint64_t>(kind);
  if (!(unit_from_bits(hash_bits(plan_.seed, of, sample_)) <= chance)) return false;
  faults_.push_back({kind, sample_, received});
  return true;
}

template <>
void FaultInjector<UltrasoundImage>::spoil(UltrasoundImage& frame) {
  if (happens(FaultKind::kEmpty, plan_.empty, frame.received)) {
    frame.pixels = {};
    frame.colours = {};
  }
}

template <>
void FaultInjector<RawPose>::spoil(RawPose& pose) {
  const Timestamp received = pose.received;
  Eigen::Matrix4d& m = pose.tracker_from_body;
  if (happens(FaultKind::kEmpty, plan_.empty, received)) {
    // Some drivers send identity with such a status, so the status alone must be sufficient.
    pose.status = TrackingStatus::kOccluded;
    m.setIdentity();
  }
  const auto axis =
      static_cast<Eigen::Index>(hash_bits(plan_.seed, kFaultStream + stream_, sample_) % 3);
  if (happens(FaultKind::kNan, plan_.nan, received)) m(axis, 3) = std::nan("");
  if (happens(FaultKind::kFlip, plan_.flip, received)) {
    const Eigen::AngleAxisd half_turn(std::numbers::pi, Eigen::Vector3d::Unit(axis));
    m.topLeftCorner<3, 3>() = (m.topLeftCorner<3, 3>() * half_turn.toRotationMatrix()).eval();
  }
  if (happens(FaultKind::kMirror, plan_.mirror, received)) m.col(axis) *= -1;
  if (happens(FaultKind::kDenormalised, plan_.denormalised, received)) {
    // The usual conversion of a quaternion to a matrix scales with the square of the norm.
    m.topLeftCorner<3, 3>() *= plan_.norm * plan_.norm;
  }
}

template <class Item>
void FaultInjector<Item>::spoil_time(Item& item, Timestamp received) {
  if (happens(FaultKind::kFutureStamp, plan_.future_stamp, received)) item.acquired += plan_.future;
  if (stepped_ > 0) {
    --stepped_;
  } else if (happens(FaultKind::kClockStep, plan_.clock_step, received)) {
    stepped_ = plan_.step_samples;
  }
  if (stepped_ > 0) item.acquired += plan_.step;
  if (received >= stalled_until_ && happens(FaultKind::kStall, plan_.stall, received)) {
    stalled_until_ = received + plan_.stall_length;
  }
  item.received = std::max(received, stalled_until_);
}

template <class Item>
void FaultInjector<Item>::release(Item item) {
  // A delayed item arrives no earlier than the items that it waited for.
  if (!ready_.empty()) item.received = std::max(item.received, ready_.back().received);
  ready_.push_back(std::move(item));
}

template <class Item>
void FaultInjector<Item>::push(Item item) {
  const Timestamp received = item.received;
  const bool drop = dropping_ > 0 || happens(FaultKind::kDrop, plan_.drop, received);
  if (drop) {
    dropping_ = dropping_ > 0 ? dropping_ - 1 : plan_.drop_samples - 1;
    ++sample_;
    return;
  }
  spoil(item);
  spoil_time(item, received);
  const bool twice = happens(FaultKind::kDuplicate, plan_.duplicate, received);
  const bool late = held_.empty() && happens(FaultKind::kReorder, plan_.reorder, received);
  ++sample_;
  if (late) {
    held_.push_back(std::move(item));
    return;
  }
  if (twice) release(item);
  release(std::move(item));
  while (!held_.empty()) {
    release(std::move(held_.front()));
    held_.pop_front();
  }
}

template <class Item>
void FaultInjector<Item>::flush() {
  while (!held_.empty()) {
    release(std::move(held_.front()));
    held_.pop_front();
  }
}

template <class Item>
Item FaultInjector<Item>::pop() {
  Item item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

template class FaultInjector<RawPose>;
template class FaultInjector<UltrasoundImage>;

}  // namespace detail

FaultyPoseSource::FaultyPoseSource(std::unique_ptr<PoseStream> source, const FaultPlan& plan,
                                   std::uint64_t stream)
    : source_(std::move(source)), injector_(checked(plan), stream) {
  NAV_CHECK(source_ != nullptr);
}
Result<RawPose> FaultyPoseSource::next(Deadline deadline) {
  return next_of(*source_, injector_, deadline);
}

FaultyImageSource::FaultyImageSource(std::unique_ptr<ImageStream> source, const FaultPlan& plan,
                                     std::uint64_t stream)
    : source_(std::move(source)), injector_(checked(plan), stream) {
  NAV_CHECK(source_ != nullptr);
}
Result<UltrasoundImage> FaultyImageSource::next(Deadline deadline) {
  return next_of(*source_, injector_, deadline);
}

}  // namespace nav::sim
