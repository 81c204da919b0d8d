// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "nav/result.hpp"
#include "nav/time.hpp"
#include "sim/motion/warp.hpp"

namespace nav::sim {

enum class BreathingKind { kNone, kRigid, kAffine, kSmooth };

/// Stable lower-case name ("smooth"), and back; kUsage for a name that is none.
const char* to_string(BreathingKind kind);
Result<BreathingKind> breathing_kind_from(std::string_view name);

/// How a patient breathes. Depth over a cycle is sin^2n, longest at expiration (Lujan et al. 1999,
/// Med. Phys. 26). Amplitudes: median of 14 liver patients, Liang et al. 2018 (J. Appl. Clin. Med.
/// Phys. 19): 11.9 mm towards the feet, 3.8 mm to the front, 1.3 mm sideways.
struct BreathingOptions {
  BreathingKind kind = BreathingKind::kNone;
  double period_s = 4;                             ///< Mean length of a cycle, [0.5, 30].
  double period_variation = 0.1;                   ///< Uniform, relative, [0, 0.5].
  double amplitude_variation = 0.15;               ///< Uniform, relative, [0, 0.5].
  int sharpness = 2;                               ///< n of sin^2n, 1 to 6.
  Eigen::Vector3d amplitude_mm{1.3, -3.8, -11.9};  ///< Mean, LPS; each within 60 mm.
  /// The motion towards the front lags the motion towards the feet: a loop instead of a line
  /// (hysteresis). [0, period/2].
  double lag_s = 0.15;
  Eigen::Vector3d centre_mm{-60, 0, 10};      ///< Where the amplitude is reached: the liver.
  Eigen::Vector3d extent_mm{90, 80, 90};      ///< Standard deviations of the smooth kind, >= 20.
  Eigen::Vector3d turn_rad{0.03, 0.0, 0.02};  ///< At full depth, rigid kind; each within 0.3.
  double stretch = -0.05;                     ///< Along z at full depth, affine kind; (-0.3, 0.3).
  std::uint64_t seed = 1;
};

/// A refusal that names the first option out of range, or a smooth motion that could fold.
Result<void> validate(const BreathingOptions& options);

/// Where in the cycle a moment lies.
struct BreathingState {
  std::int64_t cycle;    ///< Number of the breath; may be negative.
  double phase;          ///< [0, 1) of the cycle; 0: end of expiration.
  double depth;          ///< 0 at the end of expiration, about 1 at full inspiration.
  double lagging_depth;  ///< Depth lag_s earlier.
};

/// Breathing as a closed form of time: the same answer in any order, on any thread.
class Breathing {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit Breathing(const BreathingOptions& options);
  [[nodiscard]] const BreathingOptions& options() const { return options_; }
  [[nodiscard]] BreathingState state(Timestamp time) const;
  /// The patient at a time, as a map of the patient at rest. Never null.
  [[nodiscard]] std::shared_ptr<const Warp> warp(Timestamp time) const;

 private:
  [[nodiscard]] BreathingState cycle_at(double seconds) const;
  BreathingOptions options_;
};

}  // namespace nav::sim
