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
/// CT. Writes images, pose log, HTML report, session file and report.json into the output folder.
/// With a window it plays at the recording's own pace; without a folder it then shows what is
/// newest and writes nothing but the JSON report. Ctrl-C closes the window.
Result<void> run_replay(const SessionConfig& config, const std::optional<std::string>& json,
                        Console& console);

/// Names of the files that the replay writes into the folder, without the images.
std::vector<std::string> replay_outputs();

struct RegisterOptions {
  std::filesystem::path landmarks;  ///< Start pose, or the whole registration.
  /// Points of the CT when the landmarks are a Markups file; else empty.
  std::filesystem::path ct_landmarks;
  std::filesystem::path save_transform;  ///< ITK file of the accepted pose; empty: none.
  /// Direction in the patient to which the images' left edge, that of the marker, points: right,
  /// left, anterior, posterior, superior or inferior; empty: not known. For a search without a
  /// start.
  std::string marker_towards;
  /// auto, bone, tissue or both: evidence that registers a sweep. auto: tissue, and a word where
  /// bone would fit.
  std::string by = "auto";
  std::string effort = "usual";              ///< quick or usual: registration::Effort.
  std::optional<double> time_limit_s;        ///< For registration by images; absent: none.
  std::string loss = "cauchy";               ///< none, cauchy or geman-mcclure.
  std::string stretch = "none";              ///< none, sound-speed or affine.
  double calibration_sigma_mm = 0.5;         ///< ImageRegistrationOptions'.
  double delay_sigma_ms = 200;               ///< ImageRegistrationOptions', in ms.
  MotionOptions motion;                      ///< Refined after the common pose.
  ShapeFiles shape;                          ///< Points onto a surface or vessels; empty: none.
  std::optional<Eigen::Vector3d> target_ct;  ///< Point at which the error is judged, LPS mm;
                                             ///< absent: centre of the sweep or of the landmarks.
};

/// Registers a CT to a recorded sweep (from a declared pose or landmarks), or, when the
/// configuration names no recording, by points on a surface or along vessels, or by landmarks.
/// Writes the result as JSON; kRefused, after writing, when it was not accepted.
Result<void> run_register(const SessionConfig& config, const RegisterOptions& options,
                          const std::optional<std::string>& json, Console& console);

/// Names of what it writes into the folder, or takes away there.
std::vector<std::string> register_outputs();

}  // namespace nav::app
