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
  int harmonics = 2;  ///< Harmonics of the motion over a breath, [1, 4].
  /// Cost of any one coefficient of the first harmonic at its usual size; the k-th harmonic costs
  /// k⁴ times as much, > 0.
  double stiffness = 0.003;
  /// Usual motion with the breath, Ct [60 rad | mm], each > 0. The translations are those of the
  /// liver, mostly towards the feet (11.9, 3.8 and 1.3 mm: Liang et al. 2018, J. Appl. Clin. Med.
  /// Phys. 19).
  Vector6d usual_mm = (Vector6d() << 2, 2, 2, 1.3, 3.8, 11.9).finished();
  int max_iterations = 40;       ///< Limit for each fit, [1, 200].
  double cost_tolerance = 3e-5;  ///< See SolveLimits; for fits on the finest level, > 0.
  double ridge = 0.01;           ///< See ImageRegistrationOptions::ridge, > 0.
  int threads = 2;               ///< [1, 64]; the result does not depend on it.
  int min_images = 12;           ///< Ultrasound images with patches and a phase, >= 8.
  double max_gap = 0.3;          ///< Longest part of the breath without an image, (0, 1).
  double min_gain_sigmas = 3;    ///< See DeformableOptions.
  double min_gain_share = 0.03;  ///< See DeformableOptions.
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const PhaseOptions& options);

struct PhaseResult {
  PhaseMotion motion;      ///< The refined rigid pose if not supported.
  bool supported = false;  ///< True if the data support a motion with the breath.
  std::string reason{};    ///< One sentence, whether supported or not.
  double rigid_cost;       ///< Cost of all images at their best common pose, [0, 1].
  double final_cost;
  /// Mean cost of images that were left out of the fit: at the best common pose, and with the
  /// motion.
  double held_out_rigid = 0, held_out_moving = 0;
  double gain_sigmas = 0;  ///< Their difference over its standard error.
  int images;
  int iterations;
  /// unseen[p]: the motion that was fitted to all but part p of the breaths.
  std::vector<PhaseMotion> unseen;
  std::vector<int> part;  ///< Part of every image of the sweep: parts take turns, breath by breath.
};

/// One level of a fit, from coarse to fine: the patches and the CT smoothed for them.
struct PhaseLevel {
  const CtChannels& ct;
  const PatchSet& patches;
};

/// Refines a registration by a motion with the breath: LC² of every ultrasound image at the pose of
/// its phase, Levenberg–Marquardt by Ceres. phases: one phase in [0, 1) for every image of the
/// sweep that the patches were made from, from a ventilator or a belt; NaN: unknown, the image is
/// left out. The motion is kept only if breaths that were left out of the fit match better with it
/// than with the best common pose; each breath is left out in turn (of more than four breaths,
/// every fourth together). Otherwise the result is that pose and says why. Whole breaths are left
/// out because a wrong period also explains single images among their neighbours. Deterministic.
/// Errors: kUsage (options, phases), kRefused (too few images or breaths, or a part of the breath
/// without images), kNumerical (a cost that is not finite).
Result<PhaseResult> refine_by_phase(std::span<const PhaseLevel> levels,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options);

/// refine_by_phase() on a single level.
Result<PhaseResult> refine_by_phase(const CtChannels& ct, const PatchSet& patches,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options);

}  // namespace nav::registration
