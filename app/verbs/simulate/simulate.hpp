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
  std::filesystem::path out;    ///< Sequence, .mha or .nrrd.
  std::filesystem::path truth;  ///< JSON; empty: the sequence's name with .truth.json.
  std::filesystem::path ct;     ///< .mha; empty: no CT is written.
  std::string family = "abdomen";
  std::string contrast = "portal";   ///< CT phase native, arterial or portal; mr: grey values.
  std::filesystem::path patient_ct;  ///< Recorded CT as the patient; empty: one of the family.
  /// Point in that CT that the probe looks at, LPS mm; absent: the middle of its soft tissue.
  std::optional<std::array<double, 3>> look_at_mm;
  std::uint64_t seed = 1;
  std::string path = "sweep";  ///< sweep, fan, rock or tilt.
  /// Recording whose hand moves the probe instead; empty: none. With its PLUS configuration.
  std::filesystem::path path_from, path_config;
  /// ideal, good, usual or poor: errors of a whole system (sim::LevelErrors), or none of them.
  std::string level = "none";
  double unevenness = 0.5;  ///< How uneven the pace of the hand is, [0, 0.9].
  double length_mm = 0;     ///< Length of a slide; 0: usual for the probe.
  double angle_deg = 50;    ///< Angle of a swing.
  /// standard: the family's probe in its standard view; convex, linear or sector: held where the
  /// path to the skin is free.
  std::string probe = "standard";
  std::string model = "rays";       ///< Model of echoes: rays or scatterers.
  std::string tracker = "optical";  ///< ideal, optical, electromagnetic or arm.
  std::string breathing = "none";   ///< none, rigid, affine or smooth.
  /// Mean motion towards the feet, and mean time of a breath, of a patient who breathes.
  std::optional<double> breathing_mm;        ///< Absent: 12.
  std::optional<double> breathing_period_s;  ///< Absent: 4.
  bool layered_speed = false;                ///< Every tissue has its own speed of sound.
  double pressure_mm = 0;   ///< Displacement of the tissue under the probe; 0: none.
  double stand_off_mm = 0;  ///< Thickness of a gel pad between face and skin; 0: none.
  double deform_mm = 0;     ///< Largest displacement of a target relative to the CT; 0: none.
  /// Probability of each fault at each sample: one for all, or "drop=0.02,nan=0.001".
  std::string faults = "0";
  double tracker_rate_hz = 50;
  double latency_ms = 15;       ///< Latency of the tracker's samples.
  double jitter_ms = 2;         ///< Largest additional latency.
  double clock_offset_ms = 0;   ///< Offset of the tracker's time stamps.
  double clock_drift_ppm = 0;   ///< Drift of the tracker's clock.
  double loss = 0;              ///< Probability that a burst of lost samples begins at a sample.
  double image_offset_ms = 0;   ///< Offset of the images' time stamps.
  bool mirrored = false;        ///< The probe's marker is on the other side.
  std::string needle = "none";  ///< none, straight, bevel or tip-load.
  /// Sideways displacement of the tip at the target; absent: of a usual needle (NeedleBending).
  std::optional<double> needle_bending_mm;
  double needle_bevel_deg = 0;       ///< Direction of the bending around the needle's axis.
  double needle_speed_mm_s = 0;      ///< 0: the target is reached with the last image.
  double needle_length_mm = 150;     ///< Hub to tip.
  std::optional<double> duration_s;  ///< Absent: 4, or that of the recorded hand.
  double frame_rate_hz = 15;
  int columns = 0, rows = 0;  ///< Size of the images; 0: of the probe.
  double ct_spacing_mm = 1.5;
  bool compress = false;
};

/// Rejects the first number out of its range, a bend of a straight needle, and numbers of a breath
/// for a patient who does not breathe.
Result<void> validate(const SimulateOptions& options);

/// Writes a simulated recording and its truth and, if requested, the CT of the same patient at the
/// end of expiration. Errors name the option.
Result<void> run_simulate(const SimulateOptions& options, Console& console);

}  // namespace nav::app
