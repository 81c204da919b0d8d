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

/// Stable lower-case name ("smooth"), and its inverse; kUsage for an unknown name.
const char* to_string(BreathingKind kind);
Result<BreathingKind> breathing_kind_from(std::string_view name);

/// Breathing of a patient. The depth over a cycle is sin^2n, longest at expiration (Lujan et al.
/// 1999, Med. Phys. 26). Amplitudes: median of 14 liver patients, Liang et al. 2018 (J. Appl. Clin.
/// Med. Phys. 19): 11.9 mm towards the feet, 3.8 mm to the front, 1.3 mm sideways.
struct BreathingOptions {
  BreathingKind kind = BreathingKind::kNone;
  double period_s = 4;                             ///< Mean length of a cycle, [0.5, 30].
  double period_variation = 0.1;                   ///< Uniform, relative, [0, 0.5].
  double amplitude_variation = 0.15;               ///< Uniform, relative, [0, 0.5].
  int sharpness = 2;                               ///< n of sin^2n, 1 to 6.
  Eigen::Vector3d amplitude_mm{1.3, -3.8, -11.9};  ///< Mean, LPS; each within 60 mm.
  /// Delay of the motion towards the front after the motion towards the feet: the path is a loop
  /// instead of a line (hysteresis). [0, period/2].
  double lag_s = 0.15;
  Eigen::Vector3d centre_mm{-60, 0, 10};      ///< Point with the full amplitude: the liver.
  Eigen::Vector3d extent_mm{90, 80, 90};      ///< Standard deviations of the smooth kind, >= 20.
  Eigen::Vector3d turn_rad{0.03, 0.0, 0.02};  ///< Rigid kind, at full depth; each within 0.3.
  double stretch = -0.05;                     ///< Affine kind, strain along z; (-0.3, 0.3).
  std::uint64_t seed = 1;
};

/// Rejects invalid options; the message names the first one out of range, or a smooth motion that
/// could fold.
Result<void> validate(const BreathingOptions& options);

/// Position in the breathing cycle.
struct BreathingState {
  std::int64_t cycle;    ///< Number of the breath; may be negative.
  double phase;          ///< Share of the cycle, [0, 1); 0: end of expiration.
  double depth;          ///< 0 at the end of expiration, about 1 at full inspiration.
  double lagging_depth;  ///< Depth at the time lag_s earlier.
};

/// Breathing as a closed form of time: the result does not depend on the order of calls or on the
/// thread.
class Breathing {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit Breathing(const BreathingOptions& options);
  [[nodiscard]] const BreathingOptions& options() const { return options_; }
  [[nodiscard]] BreathingState state(Timestamp time) const;
  /// Motion of the patient at a time, as a map of the patient at rest. Never null.
  [[nodiscard]] std::shared_ptr<const Warp> warp(Timestamp time) const;

 private:
  [[nodiscard]] BreathingState cycle_at(double seconds) const;
  BreathingOptions options_;
};

}  // namespace nav::sim
