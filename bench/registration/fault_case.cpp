// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/fault_case.hpp"

#include <iomanip>
#include <numbers>
#include <sstream>

#include "bench/registration/altered_sweep.hpp"
#include "nav/check.hpp"

namespace nav::bench {
namespace {

using registration::MisfitCause;

constexpr double kFaultStartMm = 5;

/// Keeps the session's targets that its images show; all if they show none.
void keep_seen(const SessionCase& session, FaultCase& into) {
  std::vector<Transform<frames::Ct, frames::Image>> poses;
  for (const TrackedImage& tracked : session.sweep.frames()) {
    poses.push_back(session.truth * tracked.reference_from_image);
  }
  const auto& outline = session.sweep.frames().front().frame.outline;
  for (std::size_t i = 0; outline && i < session.targets.size(); ++i) {
    if (!seen(session.lying[i], poses, *outline)) continue;
    into.targets.push_back(session.targets[i]);
    into.lying.push_back(session.lying[i]);
  }
  if (!into.targets.empty()) return;
  into.targets = session.targets;
  into.lying = session.lying;
}

Sweep with_tracker_errors(const Sweep& sweep, std::uint64_t seed) {
  sim::Random errors(seed, 0x747261636b);
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) {
    tracked.reference_from_image = measured(tracked.reference_from_image, errors);
  }
  return std::move(Sweep::create(std::move(frames), sweep.calibration_id())).value();
}

}  // namespace

const char* to_string(FaultKind kind) {
  switch (kind) {
    case FaultKind::kNone:
      return "none";
    case FaultKind::kDelay:
      return "delay";
    case FaultKind::kPixelSize:
      return "pixel_size";
    case FaultKind::kSoundSpeed:
      return "sound_speed";
    case FaultKind::kCalibration:
      return "calibration";
    case FaultKind::kShiftAcross:
      return "shift_across";
    case FaultKind::kShiftDeep:
      return "shift_deep";
    case FaultKind::kShiftOut:
      return "shift_out";
    case FaultKind::kBreathing:
      return "breathing";
    case FaultKind::kDeformation:
      return "deformation";
  }
  return "none";
}

const char* unit_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::kNone:
      return "";
    case FaultKind::kDelay:
      return "ms";
    case FaultKind::kPixelSize:
    case FaultKind::kSoundSpeed:
      return "x";
    case FaultKind::kCalibration:
    case FaultKind::kShiftAcross:
    case FaultKind::kShiftDeep:
    case FaultKind::kShiftOut:
    case FaultKind::kBreathing:
    case FaultKind::kDeformation:
      return "mm";
  }
  return "";
}

std::string size_in_words(const Fault& fault) {
  const std::string unit = unit_of(fault.kind);
  if (unit.empty()) return "";
  std::ostringstream text;
  if (fault.kind == FaultKind::kDelay) text << std::showpos;
  if (unit == "x") {
    text << "x " << fault.size;
  } else {
    text << fault.size << ' ' << unit;
  }
  if (fault.kind == FaultKind::kCalibration) {
    text << ", " << std::fixed << std::setprecision(2)
         << kCalibrationRadPerMm * fault.size * 180 / std::numbers::pi << " deg";
  }
  return text.str();
}

std::optional<MisfitCause> cause_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::kNone:
      return {};
    case FaultKind::kDelay:
      return MisfitCause::kDelay;
    case FaultKind::kPixelSize:
    case FaultKind::kSoundSpeed:
      return MisfitCause::kPixelSize;
    case FaultKind::kCalibration:
    case FaultKind::kShiftAcross:
    case FaultKind::kShiftDeep:
    case FaultKind::kShiftOut:
      return MisfitCause::kCalibration;
    case FaultKind::kBreathing:
      return MisfitCause::kMotion;
    case FaultKind::kDeformation:
      return MisfitCause::kBend;
  }
  return {};
}

bool in_patient(FaultKind kind) {
  return kind == FaultKind::kBreathing || kind == FaultKind::kDeformation;
}

std::vector<Fault> default_faults() {
  std::vector<Fault> all{{}};
  for (const double ms : {-200, -100, -50, 50, 100, 200}) all.push_back({FaultKind::kDelay, ms});
  for (const double factor : {0.97, 0.985, 1.015, 1.03}) {
    all.push_back({FaultKind::kPixelSize, factor});
  }
  for (const double factor : {0.97, 1.03}) all.push_back({FaultKind::kSoundSpeed, factor});
  for (const double mm : {2, 4}) all.push_back({FaultKind::kCalibration, mm});
  for (const auto kind : {FaultKind::kShiftAcross, FaultKind::kShiftDeep, FaultKind::kShiftOut}) {
    all.push_back({kind, 4});
  }
  for (const double mm : {6, 12}) all.push_back({FaultKind::kBreathing, mm});
  for (const double mm : {2, 4, 8}) all.push_back({FaultKind::kDeformation, mm});
  return all;
}

Sweep with_fault(const Sweep& sweep, const Fault& fault, std::uint64_t seed) {
  NAV_CHECK(!in_patient(fault.kind), to_string(fault.kind));
  switch (fault.kind) {
    case FaultKind::kDelay:
      return delayed(sweep, from_seconds(1e-3 * fault.size));
    case FaultKind::kPixelSize:
      return enlarged(sweep, fault.size);
    case FaultKind::kSoundSpeed:
      return deepened(sweep, fault.size);
    case FaultKind::kCalibration:
      return miscalibrated(sweep, fault.size, kCalibrationRadPerMm * fault.size, seed);
    case FaultKind::kShiftAcross:
      return shifted(sweep, {fault.size, 0, 0});
    case FaultKind::kShiftDeep:
      return shifted(sweep, {0, fault.size, 0});
    case FaultKind::kShiftOut:
      return shifted(sweep, {0, 0, fault.size});
    default:
      return sweep;
  }
}

FaultCase fault_case(const Fault& fault, const Patient& patient, const RecordedSweep& recorded,
                     std::shared_ptr<const ReadyCt> ct) {
  // The sweeps of one patient have different hand motions and calibrations.
  const std::uint64_t seed = 100 * patient.seed + static_cast<std::uint64_t>(recorded.path);
  return {.ct = std::move(ct),
          .sweep = with_fault(recorded.sweep, fault, seed),
          .start = start_at(kFaultStartMm, patient.truth, recorded, seed),
          .truth = patient.truth,
          .targets = recorded.targets,
          .lying = recorded.targets};
}

Result<SessionCase> make_faulty_session(const Fault& fault, sim::SimulatedSessionOptions options) {
  NAV_CHECK(in_patient(fault.kind) || fault.kind == FaultKind::kNone, to_string(fault.kind));
  if (fault.kind == FaultKind::kBreathing) {
    options.breathing.kind = sim::BreathingKind::kSmooth;
    options.breathing.amplitude_mm *= fault.size / -options.breathing.amplitude_mm.z();
  }
  if (fault.kind == FaultKind::kDeformation) options.deformation.largest_mm = fault.size;
  return make_session_case(options);
}

FaultCase fault_case(const SessionCase& session, std::uint64_t seed,
                     std::shared_ptr<const ReadyCt> ct) {
  FaultCase made{.ct = std::move(ct),
                 .sweep = with_tracker_errors(session.sweep, seed),
                 .start = session.truth,
                 .truth = session.truth};
  keep_seen(session, made);
  made.start = start_at(kFaultStartMm, session.truth,
                        {SweepPath::kSlide, session.sweep, made.targets}, seed);
  return made;
}

}  // namespace nav::bench
