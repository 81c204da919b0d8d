// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/clock_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nav/check.hpp"

namespace nav::tracking {
namespace {

constexpr double kSecondsPerNs = 1e-9;
constexpr double kKnownSpan = 2;           // Seconds after which an epoch is known.
constexpr std::uint64_t kKnownCount = 20;  // Samples after which an epoch is known.
constexpr double kLearningSpan = 0.5;      // Seconds after which the first floor counts as learned.
constexpr Duration kProbation = std::chrono::milliseconds(100);
constexpr Duration kConfirmSpan = std::chrono::milliseconds(500);
constexpr std::size_t kConfirmCount = 8;
constexpr Duration kRunStep =
    std::chrono::milliseconds(10);  // 64 of them are longer than kConfirmSpan.

double most_skew(ClockKind kind) { return kind == ClockKind::kDevice ? 500e-6 : 0.1; }

/// Nanoseconds between two times of one clock; a device may send any number, so they are limited.
template <class Time>
std::int64_t between(Time from, Time to) {
  std::int64_t ns = 0;
  if (!__builtin_sub_overflow(to.time_since_epoch().count(), from.time_since_epoch().count(),
                              &ns)) {
    constexpr std::int64_t kMost = std::int64_t{1} << 60;
    return std::clamp(ns, -kMost, kMost);
  }
  return to < from ? -(std::int64_t{1} << 60) : std::int64_t{1} << 60;
}

Duration rounded(double s) { return Duration(std::llround(s / kSecondsPerNs)); }

}  // namespace

const char* to_string(ClockFault fault) {
  switch (fault) {
    case ClockFault::kRepeated:
      return "time_repeated";
    case ClockFault::kDisorder:
      return "time_not_increasing";
    case ClockFault::kEarly:
      return "clock_ahead";
    case ClockFault::kLate:
      return "late";
    case ClockFault::kHeldUp:
      return "after_late";
  }
  return "unknown";
}

ClockModel::ClockModel(const ClockModelOptions& options)
    : options_(options), tolerance_s_(to_seconds(options.tolerance)) {
  NAV_CHECK(options.tolerance > Duration::zero(), options.tolerance.count());
}

ClockModel::Point ClockModel::point(DeviceTime device, Timestamp received) const {
  // The delay is the small difference of two integers, so it keeps its nanoseconds.
  const std::int64_t x = between(device_origin_, device);
  return {kSecondsPerNs * static_cast<double>(x),
          kSecondsPerNs * static_cast<double>(between(origin_, received) - x)};
}

void ClockModel::begin_epoch(DeviceTime device, Timestamp received) {
  begun_ = true;
  device_origin_ = device;
  origin_ = received;
  span_s_ = 0;
  learned_ = 0;
  base_ = slope_ = usual_ = 0;
  first_ = count_ = 0;
  bucket_ = 0;
  run_count_ = 0;
}

ClockModel::Reading ClockModel::add(DeviceTime device, Timestamp received) {
  if (!begun_) begin_epoch(device, received);
  const Point p = point(device, received);
  if (learned_ > 0 && device == newest_) return {map(device), ClockFault::kRepeated};
  const bool back = learned_ > 0 && device < newest_;
  const double excess = p.y - floor_at(p.x);
  if (excess - usual_ > tolerance_s_ || excess < -tolerance_s_) {
    late_ |= excess > 0;
    in_time_since_.reset();
    const bool began = confirm_epoch(device, received);
    return {map(device),
            back         ? ClockFault::kDisorder
            : excess > 0 ? ClockFault::kLate
                         : ClockFault::kEarly,
            began};
  }
  run_count_ = 0;
  if (back) return {map(device), ClockFault::kDisorder};
  newest_ = device;
  if (late_) {
    // A sample that arrives with late ones says nothing about the least delay.
    if (!in_time_since_) in_time_since_ = received;
    late_ = received - *in_time_since_ < kProbation;
    if (late_) return {map(device), ClockFault::kHeldUp};
  }
  learn(p);
  return {map(device), std::nullopt};
}

/// Takes a sample that fits into the model.
void ClockModel::learn(const Point& p) {
  const double excess = p.y - floor_at(p.x);
  span_s_ = std::max(span_s_, p.x);
  const auto bucket = static_cast<std::int64_t>(std::floor(p.x / kBucketSeconds));
  const bool next = count_ == 0 || bucket > bucket_;
  if (next) {
    bucket_ = bucket;
    const double oldest = p.x - static_cast<double>(kBuckets) * kBucketSeconds;
    while (count_ == kBuckets || (count_ > 0 && buckets_[first_].x < oldest)) {
      first_ = (first_ + 1) % kBuckets;
      --count_;
    }
    buckets_[(first_ + count_++) % kBuckets] = p;
  } else {
    Point& least = buckets_[(first_ + count_ - 1) % kBuckets];
    if (p.y - slope_ * p.x < least.y - slope_ * least.x) least = p;
  }
  if (next || excess < 0) fit();
  const double above = std::max(p.y - floor_at(p.x), 0.0);
  residuals_[learned_ % residuals_.size()] = static_cast<float>(above);
  ++learned_;
  // The running median moves by a hundredth of the tolerance with each sample.
  const double step = 0.01 * tolerance_s_;
  usual_ = std::max(0.0, usual_ + (above > usual_ ? step : -step));
}

/// Finds the line below the least delays that is nearest to them: it touches their lower hull at
/// their mean time.
void ClockModel::fit() {
  std::array<Point, kBuckets> hull;
  std::size_t corners = 0;
  double mean = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Point& p = buckets_[(first_ + i) % kBuckets];
    mean += p.x;
    const auto above = [&](const Point& a, const Point& b) {
      return (b.x - a.x) * (p.y - a.y) <= (b.y - a.y) * (p.x - a.x);
    };
    while (corners >= 2 && above(hull[corners - 2], hull[corners - 1])) --corners;
    hull[corners++] = p;
  }
  mean /= static_cast<double>(count_);
  std::size_t right = 1;
  while (right + 1 < corners && hull[right].x < mean) ++right;
  double slope = 0;
  if (corners >= 2) {
    const Point& a = hull[right - 1];
    const Point& b = hull[right];
    if (b.x > a.x) slope = (b.y - a.y) / (b.x - a.x);
  }
  const double most = most_skew(options_.kind);
  slope_ = std::clamp(slope, -most, most);
  base_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners; ++i) base_ = std::min(base_, hull[i].y - slope_ * hull[i].x);
  if (steps_ == 0 && span_s_ < kLearningSpan) first_floor_s_ = base_;
}

/// Takes a sample that does not fit. Samples that agree with each other for half a second begin a
/// new epoch. Samples that were held up do not agree: their delay falls while they arrive.
bool ClockModel::confirm_epoch(DeviceTime device, Timestamp received) {
  if (run_count_ > 0 && device <= run_newest_) run_count_ = 0;
  run_newest_ = device;
  if (run_count_ == kRun) {
    std::move(run_.begin() + kRun / 2, run_.end(), run_.begin());
    run_count_ = kRun / 2;
  }
  RunSample* last = run_count_ > 0 ? &run_[run_count_ - 1] : nullptr;
  if (last != nullptr && received - last->received < kRunStep) {
    // Close samples count as one, that with the least delay.
    if (received - last->received < device - last->device) *last = {device, received};
  } else {
    run_[run_count_++] = {device, received};
  }
  // The first samples of all may themselves be wrong.
  const bool unsure = steps_ == 0 && learned_ < kConfirmCount;
  const std::size_t count = unsure ? kConfirmCount / 2 : kConfirmCount;
  const Duration span = unsure ? kProbation : kConfirmSpan;
  if (run_count_ < count || received - run_[0].received < span) return false;
  // The least delay of each half, relative to the first sample.
  std::array<double, 2> least{std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::infinity()};
  const Timestamp middle = run_[0].received + (received - run_[0].received) / 2;
  for (std::size_t i = 0; i < run_count_; ++i) {
    const Duration delay =
        (run_[i].received - run_[0].received) - (run_[i].device - run_[0].device);
    double& half = least[run_[i].received > middle ? 1 : 0];
    half = std::min(half, kSecondsPerNs * static_cast<double>(delay.count()));
  }
  if (!(std::abs(least[1] - least[0]) <= 0.25 * tolerance_s_)) {
    // Keeps the newer half, which may be the beginning of an epoch.
    const std::size_t keep = run_count_ / 2;
    std::move(run_.begin() + static_cast<std::ptrdiff_t>(run_count_ - keep),
              run_.begin() + static_cast<std::ptrdiff_t>(run_count_), run_.begin());
    run_count_ = keep;
    return false;
  }
  const RunSample first = run_[0];
  const double floor_s = point(first.device, first.received).y + std::min(least[0], least[1]);
  if (!unsure) {
    changed_s_ += floor_s - (steps_ == 0 ? first_floor_s_ : base_);
    ++steps_;
  }
  const std::size_t agreeing = run_count_;
  begin_epoch(first.device, first.received);
  for (std::size_t i = 0; i < agreeing; ++i) {
    learn(point(run_[i].device, run_[i].received));
    newest_ = run_[i].device;
  }
  late_ = false;
  in_time_since_.reset();
  return true;
}

ClockState ClockModel::state() const {
  if (learned_ == 0) return ClockState::kUnknown;
  return span_s_ >= kKnownSpan && learned_ >= kKnownCount ? ClockState::kKnown
                                                          : ClockState::kDegraded;
}

Timestamp ClockModel::map(DeviceTime device) const {
  NAV_CHECK(begun_);
  const std::int64_t x = between(device_origin_, device);
  return origin_ + Duration(x) + rounded(floor_at(kSecondsPerNs * static_cast<double>(x)));
}

Duration ClockModel::offset() const {
  return map(newest_).time_since_epoch() - Duration(newest_.time_since_epoch().count());
}

Duration ClockModel::change() const {
  return rounded(changed_s_ + floor_at(span_s_) - (steps_ == 0 ? first_floor_s_ : base_));
}

double ClockModel::skew_ci95_ppm() const {
  if (state() != ClockState::kKnown || count_ < 4) return std::numeric_limits<double>::infinity();
  double mean = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Point& p = buckets_[(first_ + i) % kBuckets];
    mean += p.y - floor_at(p.x);
  }
  mean /= static_cast<double>(count_);
  const double span = buckets_[(first_ + count_ - 1) % kBuckets].x - buckets_[first_].x;
  // Slope of a line through as many points whose errors have the mean of the least delays.
  return 1e6 * 1.96 * std::sqrt(12.0 / static_cast<double>(count_)) * mean / span;
}

Duration ClockModel::residual_p95() const {
  const std::size_t count = std::min<std::size_t>(learned_, residuals_.size());
  if (count == 0) return Duration::zero();
  auto sorted = residuals_;
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>((count - 1) * 95 / 100);
  std::nth_element(sorted.begin(), at, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  return rounded(static_cast<double>(*at));
}

Duration ClockModel::usual_residual() const { return rounded(usual_); }

TickUnwrapper::TickUnwrapper(int bits, std::chrono::duration<double, std::nano> tick)
    : mask_(bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1), tick_(tick) {
  NAV_CHECK(bits >= 1 && bits <= 64, bits);
  NAV_CHECK(tick.count() > 0, tick.count());
}

DeviceTime TickUnwrapper::add(std::uint64_t ticks) {
  ticks &= mask_;
  if (!last_) {
    total_ = static_cast<std::int64_t>(ticks);
  } else {
    const std::uint64_t forward = (ticks - *last_) & mask_;
    const bool back = forward > mask_ / 2;
    total_ += back ? -static_cast<std::int64_t>(((*last_ - ticks) & mask_))
                   : static_cast<std::int64_t>(forward);
  }
  last_ = ticks;
  return DeviceTime(
      DeviceClock::duration(std::llround(static_cast<double>(total_) * tick_.count())));
}

}  // namespace nav::tracking
