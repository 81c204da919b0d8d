// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "registration/motion/phase_motion.hpp"

namespace nav::registration {

struct PhaseOptions {
  int harmonics = 2;  ///< Of the motion over a breath, [1, 4].
  /// Cost of the usual first harmonic of any one coefficient; the k-th costs k⁴ times it, > 0.
  double stiffness = 0.003;
  /// Usual motion with the breath, Ct [60 rad | mm], each > 0: that of the liver, mostly towards
  /// the feet (11.9, 3.8 and 1.3 mm: Liang et al. 2018, J. Appl. Clin. Med. Phys. 19).
  Vector6d usual_mm = (Vector6d() << 2, 2, 2, 1.3, 3.8, 11.9).finished();
  int max_iterations = 40;       ///< Of each fit, [1, 200].
  double cost_tolerance = 3e-5;  ///< As SolveLimits, of fits on the finest level, > 0.
  double ridge = 0.01;           ///< As ImageRegistrationOptions::ridge, > 0.
  int threads = 2;               ///< [1, 64]; the result does not depend on it.
  int min_pictures = 12;         ///< With patches and a phase, >= 8.
  double max_gap = 0.3;          ///< Longest part of the breath without a picture, (0, 1).
  double min_gain_sigmas = 3;    ///< As DeformableOptions.
  double min_gain_share = 0.03;  ///< As DeformableOptions.
};

/// A refusal that names the first option out of its range.
Result<void> validate(const PhaseOptions& options);

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
  /// unseen[p]: the motion that was fitted to all but part p of the breaths.
  std::vector<PhaseMotion> unseen;
  std::vector<int> part;  ///< Of every picture of the sweep: by turns, breath for breath.
};

/// One step of a fit, coarse to fine: patches, and the CT smoothed to them.
struct PhaseLevel {
  const CtChannels& ct;
  const PatchSet& patches;
};

/// Refines a registration by a motion with the breath: LC² of every picture at the pose of its
/// phase, Levenberg–Marquardt by Ceres. phases: of every picture of the sweep that the patches were
/// made of, [0, 1), from a ventilator or a belt; NaN: unknown, the picture is left out. The motion
/// is kept only where breaths that it was not fitted to (each in turn; of more than four breaths
/// every fourth) match better with it than with the best common pose; else the answer is that pose,
/// and says why. Whole breaths are left out, as a wrong period explains single pictures among their
/// neighbours too.
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
