// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct SimulateOptions {
  std::filesystem::path out;    ///< Sequence, .mha or .nrrd; the truth goes beside it.
  std::filesystem::path truth;  ///< JSON; empty: the sequence's name with .truth.json.
  std::filesystem::path ct;     ///< .mha; empty: no CT is written.
  std::string family = "abdomen";
  std::string contrast = "portal";   ///< Of the CT: native, arterial, portal; mr: grey values.
  std::filesystem::path patient_ct;  ///< A recorded CT as the patient; empty: one of the family.
  /// What the probe looks at in that CT, LPS mm; absent: the middle of its soft tissue.
  std::optional<std::array<double, 3>> look_at_mm;
  std::uint64_t seed = 1;
  std::string path = "sweep";  ///< sweep, fan, rock or tilt.
  double length_mm = 0;        ///< Of a slide; 0: what the probe is usually led over.
  double angle_deg = 50;       ///< Of a swing.
  /// The family's own in its standard view; convex, linear or sector, held where the way is free.
  std::string probe = "standard";
  std::string model = "rays";       ///< How echoes are computed: rays or scatterers.
  std::string tracker = "optical";  ///< ideal, optical, electromagnetic or arm.
  std::string breathing = "none";   ///< none, rigid, affine or smooth.
  /// Of a patient who breathes: mean way towards the feet, and mean time of a breath.
  std::optional<double> breathing_mm;        ///< Absent: 12.
  std::optional<double> breathing_period_s;  ///< Absent: 4.
  double deform_mm = 0;  ///< Largest displacement of a target against the CT; 0: none.
  /// Chance of each fault at each sample: one for all, or "drop=0.02,nan=0.001".
  std::string faults = "0";
  double tracker_rate_hz = 50;
  double latency_ms = 15;        ///< Of the tracker's samples.
  double jitter_ms = 2;          ///< Added latency, at most.
  double clock_offset_ms = 0;    ///< Of the tracker's stamps.
  double clock_drift_ppm = 0;    ///< Of the tracker's clock.
  double loss = 0;               ///< Chance that a burst of lost samples begins at one.
  double picture_offset_ms = 0;  ///< Of the pictures' stamps.
  bool mirrored = false;         ///< The probe's marker is on the other side.
  std::string needle = "none";   ///< none, straight, bevel or tip-load.
  /// Sideways way of the tip at the target; absent: that of a usual needle (NeedleBending).
  std::optional<double> needle_bending_mm;
  double needle_bevel_deg = 0;    ///< Direction of the bending about the needle's axis.
  double needle_speed_mm_s = 0;   ///< 0: the target is reached with the last picture.
  double needle_length_mm = 150;  ///< Hub to tip.
  double duration_s = 4;
  double frame_rate_hz = 15;
  int columns = 0, rows = 0;  ///< Of the pictures; 0: the probe's own.
  double ct_spacing_mm = 1.5;
  bool compress = false;
};

/// A refusal that names the first number out of its range, or one of what was not asked for.
Result<void> validate(const SimulateOptions& options);

/// Writes a simulated recording with its truth and, if asked for, the CT of the same patient at the
/// end of expiration. Errors name the option.
Result<void> run_simulate(const SimulateOptions& options, Console& console);

}  // namespace nav::app
