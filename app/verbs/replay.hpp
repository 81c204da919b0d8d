// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "app/verbs/register/register_motion.hpp"
#include "app/verbs/register/register_shape.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Replays a recorded sweep through the live pipeline on the virtual clock and shows its plane in a
/// CT. Writes pictures, pose log, HTML report, session file and report.json into the output folder.
/// With a window it plays at the recording's own pace; without a folder it then shows what is
/// newest and writes nothing but the JSON report. Ctrl-C closes the window.
Result<void> run_replay(const SessionConfig& config, const std::optional<std::string>& json,
                        Console& console);

/// Names of what it writes into the folder, but for the pictures.
std::vector<std::string> replay_outputs();

struct RegisterOptions {
  std::filesystem::path landmarks;  ///< Start pose, or the whole registration.
  /// Where the left edge of the pictures, the marker's, points in the patient: right, left,
  /// anterior, posterior, superior or inferior; empty: not known. For a search without a start.
  std::string marker_towards;
  std::string effort = "usual";              ///< quick or usual: registration::Effort.
  std::optional<double> time_limit_s;        ///< Of a registration by image; absent: none.
  std::string loss = "cauchy";               ///< none, cauchy or geman-mcclure.
  std::string stretch = "none";              ///< none, sound-speed or affine.
  double calibration_sigma_mm = 0;           ///< ImageRegistrationOptions'.
  MotionOptions motion;                      ///< Refined after the common pose.
  ShapeFiles shape;                          ///< Points onto a surface or vessels; empty: none.
  std::optional<Eigen::Vector3d> target_ct;  ///< Where the error is judged, LPS mm; absent: centre
                                             ///< of the sweep or of the landmarks.
};

/// Registers a CT to a recorded sweep (from a declared pose or landmarks), or, when the
/// configuration names no recording, by points on a surface or along vessels, or by landmarks.
/// Writes the result as JSON; kRefused, after writing, when it was not accepted.
Result<void> run_register(const SessionConfig& config, const RegisterOptions& options,
                          const std::optional<std::string>& json, Console& console);

/// Names of what it writes into the folder, or takes away there.
std::vector<std::string> register_outputs();

}  // namespace nav::app
