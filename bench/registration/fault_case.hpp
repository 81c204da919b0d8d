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

/// What is wrong with a sweep, or with the patient in it, that no pose makes up for.
enum class FaultKind {
  kNone,
  kDelay,        ///< Pictures and poses of different moments.
  kPixelSize,    ///< Pixels that are taken to be of another size.
  kSoundSpeed,   ///< The same of depth alone.
  kCalibration,  ///< Pictures that lie elsewhere on the probe, shifted and turned.
  kShiftAcross,  ///< Shifted along their width alone,
  kShiftDeep,
  kShiftOut,   ///< or along their normal: a pose takes up all of it where the probe turns about it.
  kBreathing,  ///< A patient who breathes, smoothly, while the sweep is taken.
  kDeformation,  ///< Tissue that lies otherwise than in the CT.
};
/// Stable lower-case name: "none", "delay", "pixel_size", "sound_speed", "calibration",
/// "shift_across", "shift_deep", "shift_out", "breathing", "deformation".
const char* to_string(FaultKind kind);

/// A fault and how large it is.
struct Fault {
  FaultKind kind = FaultKind::kNone;
  /// kDelay: by how much pictures are later than their poses, ms. kPixelSize, kSoundSpeed: taken
  /// over true, > 0. kCalibration: shift, mm, with a turn of kCalibrationRadPerMm. kShift…: mm.
  /// kBreathing: mean motion towards the feet, mm. kDeformation: of the target that moves most, mm.
  /// kNone: 0.
  double size = 0;
  friend bool operator==(const Fault&, const Fault&) = default;
};
inline constexpr double kCalibrationRadPerMm = 0.01;

/// "ms", "x" (a factor), "mm", or "" of none.
const char* unit_of(FaultKind kind);
/// "-200 ms", "x 0.985", "2 mm, 1.1 deg"; "" of none.
std::string size_in_words(const Fault& fault);
/// What a misfit of such a fault should be taken for; absent of none.
std::optional<registration::MisfitCause> cause_of(FaultKind kind);
/// Whether it is the patient's, who is simulated with it; others befall a sweep that is there.
bool in_patient(FaultKind kind);

/// Every fault that is measured, none first.
std::vector<Fault> default_faults();

/// A sweep with a fault as the registration gets it, with its truth.
struct FaultCase {
  std::shared_ptr<const ReadyCt> ct;
  Sweep sweep;
  CtPose start;  ///< Target error of 5 mm where nothing is deformed.
  CtPose truth;
  std::vector<Point<frames::Ct>> targets;  ///< Those that the sweep shows.
  std::vector<Point<frames::Ct>> lying;  ///< Where they lie: elsewhere in tissue that is deformed.
};

/// A sweep that is changed afterwards. Precondition: not of a fault in the patient, otherwise a
/// Bug.
Sweep with_fault(const Sweep& sweep, const Fault& fault, std::uint64_t seed);

/// A sweep of the cohort with a fault that is not in the patient.
FaultCase fault_case(const Fault& fault, const Patient& patient, const RecordedSweep& recorded,
                     std::shared_ptr<const ReadyCt> ct);

/// The simulated session of a patient with a fault in him, or with none; options: of its sweep.
/// Errors: those of make_session_case().
Result<SessionCase> make_faulty_session(const Fault& fault, sim::SimulatedSessionOptions options);

/// Its sweep with tracker errors of the cohort. ct: that of the session, prepared.
FaultCase fault_case(const SessionCase& session, std::uint64_t seed,
                     std::shared_ptr<const ReadyCt> ct);

}  // namespace nav::bench
