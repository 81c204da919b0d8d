// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/case_store.hpp"
#include "bench/registration/session_case.hpp"
#include "registration/uncertainty/misfit.hpp"

namespace nav::bench {

/// A fault of a sweep, or of the patient in it, that no pose can compensate.
enum class FaultKind {
  kNone,
  kDelay,        ///< Images and poses of different moments.
  kPixelSize,    ///< Wrong assumed pixel size.
  kSoundSpeed,   ///< Wrong assumed pixel size along the depth only.
  kCalibration,  ///< Wrong position of the images relative to the probe, translated and rotated.
  kShiftAcross,  ///< Translation along the width of the images only.
  kShiftDeep,
  /// Translation along their normal: a pose absorbs all of it if the probe rotates about the
  /// normal.
  kShiftOut,
  kBreathing,    ///< A patient who breathes smoothly during the sweep.
  kDeformation,  ///< Tissue that is deformed relative to the CT.
};
/// Stable lower-case name: "none", "delay", "pixel_size", "sound_speed", "calibration",
/// "shift_across", "shift_deep", "shift_out", "breathing", "deformation".
const char* to_string(FaultKind kind);

/// A fault and its size.
struct Fault {
  FaultKind kind = FaultKind::kNone;
  /// kDelay: delay of the images relative to their poses, ms. kPixelSize, kSoundSpeed: assumed over
  /// true value, > 0. kCalibration: translation, mm, with a rotation of kCalibrationRadPerMm.
  /// kShift…: mm. kBreathing: mean motion towards the feet, mm. kDeformation: movement of the
  /// target that moves most, mm. kNone: 0.
  double size = 0;
  friend bool operator==(const Fault&, const Fault&) = default;
};
inline constexpr double kCalibrationRadPerMm = 0.01;

/// "ms", "x" (a factor), "mm", or "" for kNone.
const char* unit_of(FaultKind kind);
/// "-200 ms", "x 0.985", "2 mm, 1.1 deg"; "" for kNone.
std::string size_in_words(const Fault& fault);
/// The cause that a misfit of this fault should name; absent for kNone.
std::optional<registration::MisfitCause> cause_of(FaultKind kind);
/// True for a fault of the patient, who is simulated with it; the others are applied to an existing
/// sweep.
bool in_patient(FaultKind kind);

/// Every fault that is measured, kNone first.
std::vector<Fault> default_faults();

/// A sweep with a fault as the registration receives it, with its truth.
struct FaultCase {
  std::shared_ptr<const ReadyCt> ct;
  Sweep sweep;
  CtPose start;  ///< Target error of 5 mm if nothing is deformed.
  CtPose truth;
  std::vector<Point<frames::Ct>> targets{};  ///< Targets that the sweep shows.
  std::vector<Point<frames::Ct>> lying{};  ///< Their true positions: different in deformed tissue.
};

/// Applies a fault to a sweep. Precondition: not a fault of the patient, otherwise a Bug.
Sweep with_fault(const Sweep& sweep, const Fault& fault, std::uint64_t seed);

/// A sweep of the cohort with a fault that is not of the patient.
FaultCase fault_case(const Fault& fault, const Patient& patient, const RecordedSweep& recorded,
                     std::shared_ptr<const ReadyCt> ct);

/// The simulated session of a patient with a fault of the patient, or with none; options: options
/// of its sweep. Errors: those of make_session_case().
Result<SessionCase> make_faulty_session(const Fault& fault, sim::SimulatedSessionOptions options);

/// The session's sweep with tracker errors of the cohort. ct: the prepared CT of the session.
FaultCase fault_case(const SessionCase& session, std::uint64_t seed,
                     std::shared_ptr<const ReadyCt> ct);

}  // namespace nav::bench
