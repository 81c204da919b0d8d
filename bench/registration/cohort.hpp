// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "sim/abdomen_phantom.hpp"
#include "sim/probe_model.hpp"
#include "sim/random.hpp"

/// The seeded cohort that registration is judged on: simulated patients, freehand sweeps with
/// tracker errors, starts of known target error. Nothing here is clinical accuracy.
namespace nav::bench {

using CtPose = Transform<frames::Ct, frames::Reference>;

/// How the hand moves over the skin.
enum class SweepPath {
  kSubcostal,  ///< From the midline to the right flank below the ribs, tilting and turning.
  kFan,        ///< One place, tilted from feet to head.
  kSlide,      ///< Along the ribs with hardly a tilt: nearly parallel pictures.
  kSagittal,   ///< Turned by 90 degrees, from the midline to the flank, rocking.
  kCross,      ///< One place, turned from across to along while it tilts.
};
inline constexpr int kSweepPaths = 5;
const char* to_string(SweepPath path);

struct SweepRequest {
  SweepPath path = SweepPath::kSubcostal;
  std::uint64_t seed = 1;  ///< Hand, tracker errors, speckle, depth gain.
  int frames = 60;         ///< >= 2.
  sim::AcousticModel model = sim::AcousticModel::kRays;
};

/// Tracker errors of the cohort: uniform, one standard deviation per axis.
inline constexpr double kTrackerMm = 0.15;
inline constexpr double kTrackerRad = 0.0015;
/// A pose as the tracker gives it.
Transform<frames::Reference, frames::Image> measured(
    const Transform<frames::Reference, frames::Image>& exact, sim::Random& random);

/// A patient with a CT of 1.5 x 1.5 x 2 mm and 12 HU of noise.
struct Patient {
  std::uint64_t seed;
  sim::AbdomenPhantom phantom;
  std::shared_ptr<const Volume> ct;
  CtPose truth;  ///< Seeded: no axis of Reference lies along one of the CT.
};

/// The CT is half of the work of a patient.
Patient make_patient(std::uint64_t seed);

/// Whether a point lies within 8 mm of one of the pictures and inside its field.
bool seen(const Point<frames::Ct>& p,
          const std::vector<Transform<frames::Ct, frames::Image>>& poses,
          const SectorOutline& outline);

/// A sweep with the points of the liver that it shows.
struct RecordedSweep {
  SweepPath path;
  Sweep sweep;
  /// Points of the liver that are seen(): where the error counts.
  std::vector<Point<frames::Ct>> targets;
};
RecordedSweep record_sweep(const Patient& patient, const SweepRequest& request);

/// RMS distance of the targets from where the truth says, mm. Precondition: targets not empty.
double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets);
/// The same where they lie elsewhere than in the CT when the pictures are taken.
double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets,
                       const std::vector<Point<frames::Ct>>& lying);

/// A start whose target error is error_mm: a rotation of 0.8 degrees per mm (at most 30, less where
/// it alone would exceed the error) about the sweep's centroid and a translation, both in seeded
/// random directions.
CtPose start_at(double error_mm, const CtPose& truth, const RecordedSweep& recorded,
                std::uint64_t seed);

}  // namespace nav::bench
