// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/breathing.hpp"

#include <cmath>
#include <numbers>

#include "nav/check.hpp"
#include "sim/named_kind.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::uint64_t kPeriodStream = 0x62726561;
constexpr std::uint64_t kDepthStream = 0x64657074;

/// Start of breath k, s. The ends of expiration are spread about an even beat, so that the start of
/// any breath is known without summing the earlier ones.
double begin_of(const BreathingOptions& o, std::int64_t k) {
  const double spread =
      unit_from_bits(hash_bits(o.seed, kPeriodStream, static_cast<std::uint64_t>(k))) - 0.5;
  return o.period_s * (static_cast<double>(k) + o.period_variation * spread);
}

std::vector<WarpBump> bumps_of(const BreathingOptions& o, const Vec& shift) {
  return {{o.centre_mm, o.extent_mm, shift}};
}

}  // namespace

const char* to_string(BreathingKind kind) {
  switch (kind) {
    case BreathingKind::kNone:
      return "none";
    case BreathingKind::kRigid:
      return "rigid";
    case BreathingKind::kAffine:
      return "affine";
    case BreathingKind::kSmooth:
      return "smooth";
  }
  return "unknown";
}

Result<BreathingKind> breathing_kind_from(std::string_view name) {
  return kind_by_name(
      "breathing",
      {BreathingKind::kNone, BreathingKind::kRigid, BreathingKind::kAffine, BreathingKind::kSmooth},
      name);
}

Result<void> validate(const BreathingOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("breathing: expected ") + what};
  };
  const auto within = [](double v, double low, double high) { return v >= low && v <= high; };
  if (!within(o.period_s, 0.5, 30)) return reject("a period of 0.5 to 30 s");
  if (!within(o.period_variation, 0, 0.5)) return reject("a period variation in [0, 0.5]");
  if (!within(o.amplitude_variation, 0, 0.5)) return reject("an amplitude variation in [0, 0.5]");
  if (o.sharpness < 1 || o.sharpness > 6) return reject("a sharpness of 1 to 6");
  if (!within(o.lag_s, 0, 0.5 * o.period_s)) return reject("a lag of 0 to half a period");
  if (!o.amplitude_mm.allFinite() || !o.turn_rad.allFinite()) return reject("finite numbers");
  if (!(o.amplitude_mm.cwiseAbs().maxCoeff() <= 60)) return reject("amplitudes within 60 mm");
  if (!(o.turn_rad.cwiseAbs().maxCoeff() <= 0.3)) return reject("turns within 0.3 rad");
  if (!(std::abs(o.stretch) < 0.3)) return reject("a stretch in (-0.3, 0.3)");
  if (!o.centre_mm.allFinite()) return reject("a finite centre");
  if (!(o.extent_mm.allFinite() && o.extent_mm.minCoeff() >= 20)) {
    return reject("extents >= 20 mm");
  }
  if (o.kind != BreathingKind::kSmooth) return {};
  const Vec deepest = (1 + o.amplitude_variation) * o.amplitude_mm;
  const auto warp = SmoothWarp::create(bumps_of(o, deepest));
  if (!warp) return warp.error();
  return {};
}

Breathing::Breathing(const BreathingOptions& options) : options_(options) {
  const auto ok = validate(options);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
}

BreathingState Breathing::cycle_at(double seconds) const {
  auto k = static_cast<std::int64_t>(std::floor(seconds / options_.period_s));
  // A start deviates from the beat by at most a quarter of a period.
  while (begin_of(options_, k + 1) <= seconds) ++k;
  while (begin_of(options_, k) > seconds) --k;
  const double begin = begin_of(options_, k);
  const double phase = (seconds - begin) / (begin_of(options_, k + 1) - begin);
  const double vary =
      2 * unit_from_bits(hash_bits(options_.seed, kDepthStream, static_cast<std::uint64_t>(k))) - 1;
  const double wave = std::sin(std::numbers::pi * phase);
  const double depth =
      (1 + options_.amplitude_variation * vary) * std::pow(wave * wave, options_.sharpness);
  return {k, phase, depth, depth};
}

BreathingState Breathing::state(Timestamp time) const {
  if (options_.kind == BreathingKind::kNone) return {0, 0, 0, 0};
  BreathingState now = cycle_at(to_seconds(time));
  now.lagging_depth = cycle_at(to_seconds(time) - options_.lag_s).depth;
  return now;
}

std::shared_ptr<const Warp> Breathing::warp(Timestamp time) const {
  const BreathingOptions& o = options_;
  const BreathingState s = state(time);
  const Vec shift = o.amplitude_mm.cwiseProduct(Vec(s.lagging_depth, s.lagging_depth, s.depth));
  switch (o.kind) {
    case BreathingKind::kNone:
      break;
    case BreathingKind::kRigid:
      return std::make_shared<AffineWarp>(
          AffineWarp::rigid(s.depth * o.turn_rad, o.centre_mm, shift));
    case BreathingKind::kAffine: {
      Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
      m(2, 2) += s.depth * o.stretch;
      return std::make_shared<AffineWarp>(m, o.centre_mm - m * o.centre_mm + shift);
    }
    case BreathingKind::kSmooth: {
      auto warp = SmoothWarp::create(bumps_of(o, shift));
      NAV_CHECK(warp.has_value());
      return std::make_shared<SmoothWarp>(std::move(*warp));
    }
  }
  return std::make_shared<AffineWarp>(Eigen::Matrix3d::Identity(), Vec::Zero());
}

}  // namespace nav::sim
