// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "registration/lc2_cost.hpp"

namespace nav::registration {

struct PhaseOptions {
  int harmonics = 2;  ///< Of the motion over a breath, [1, 4].
  double stiffness =
      2e-4;  ///< Cost of 1 mm of the first harmonic; the k-th costs k⁴ times it, > 0.
  int max_iterations = 40;       ///< Of each fit, [1, 200].
  double ridge = 0.01;           ///< As ImageRegistrationOptions::ridge, > 0.
  int threads = 2;               ///< [1, 64]; the result does not depend on it.
  int min_pictures = 12;         ///< With patches and a phase, >= 8.
  double max_gap = 0.3;          ///< Longest part of the breath without a picture, (0, 1).
  double min_gain_sigmas = 3;    ///< As DeformableOptions.
  double min_gain_share = 0.03;  ///< As DeformableOptions.
};

/// A refusal that names the first option out of its range.
Result<void> validate(const PhaseOptions& options);

/// A rigid motion that repeats with every breath: a pose for each phase. The twist about a centre
/// is a Fourier series of the phase, so that neighbouring phases have neighbouring poses.
class PhaseMotion {
 public:
  /// The same pose at all phases.
  explicit PhaseMotion(const Pose& mean, const Eigen::Vector3d& centre_ct_mm = {0, 0, 0});
  /// series: columns constant, cos 1, sin 1, cos 2, sin 2, …; [60 rad | mm] as kRotationScaleMm.
  PhaseMotion(const Pose& mean, const Eigen::Vector3d& centre_ct_mm, Eigen::MatrixXd series);

  /// Phase of the breath; any number, of which only the part after the point counts.
  [[nodiscard]] Pose ct_from_reference(double phase) const;
  /// The same motion, and then a step of the tissue.
  [[nodiscard]] PhaseMotion after(const Transform<frames::Ct, frames::Ct>& step) const;
  /// Longest way of a point of the CT between two phases, mm.
  [[nodiscard]] double amplitude_mm(const Point<frames::Ct>& at_mean) const;
  [[nodiscard]] const Eigen::MatrixXd& series() const { return series_; }

 private:
  Pose mean_;
  Eigen::Vector3d centre_;
  Eigen::MatrixXd series_;
};

struct PhaseResult {
  PhaseMotion motion;  ///< The refined rigid pose unless supported.
  bool supported;      ///< Whether the data support a motion with the breath.
  std::string reason;  ///< One sentence, either way.
  double rigid_cost;   ///< Of all pictures at their best common pose, [0, 1].
  double final_cost;
  /// Pictures that a fit of the others did not see: mean cost at the best common pose, and with
  /// motion.
  double held_out_rigid, held_out_moving;
  double gain_sigmas;  ///< Their difference over its standard error.
  int pictures;
  int iterations;
  /// unseen[h]: the motion that was fitted to all but half h of the breaths.
  std::array<PhaseMotion, 2> unseen;
  std::vector<int> half;  ///< Of every picture of the sweep, 0 or 1: by turns, breath for breath.
};

/// One step of a fit, coarse to fine: patches, and the CT smoothed to them.
struct PhaseLevel {
  const CtChannels& ct;
  const PatchSet& patches;
};

/// Refines a registration by a motion with the breath: LC² of every picture at the pose of its
/// phase, Levenberg–Marquardt by Ceres. phases: of every picture of the sweep that the patches were
/// made of, [0, 1), from a ventilator or a belt; NaN: unknown, the picture is left out. The motion
/// is kept only where breaths that it was not fitted to (every second, then the others) match
/// better with it than with the best common pose; else the answer is that pose, and says why. Whole
/// breaths are left out, as a wrong period explains single pictures among their neighbours too.
/// Deterministic. Errors: kUsage (options, phases), kRefused (too few pictures or breaths, or a
/// part of the breath that none shows), kNumerical (a cost that is not finite).
Result<PhaseResult> refine_by_phase(std::span<const PhaseLevel> levels,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options);

/// The same on one level.
Result<PhaseResult> refine_by_phase(const CtChannels& ct, const PatchSet& patches,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options);

}  // namespace nav::registration
