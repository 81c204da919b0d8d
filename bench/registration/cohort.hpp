// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/error_level.hpp"
#include "sim/probe_model.hpp"
#include "sim/random.hpp"

/// The seeded cohort that evaluates registration: simulated patients, freehand sweeps with tracker
/// errors, starts of known target error. Nothing here is clinical accuracy.
namespace nav::bench {

using CtPose = Transform<frames::Ct, frames::Reference>;

/// Motion of the hand over the skin.
enum class SweepPath {
  kSubcostal,  ///< From the midline to the right flank below the ribs, tilting and rotating.
  kFan,        ///< One position, tilted from feet to head.
  kSlide,      ///< Along the ribs with hardly any tilt: nearly parallel images.
  kSagittal,   ///< Rotated by 90 degrees, from the midline to the flank, rocking.
  kCross,      ///< One position, rotated from transverse to longitudinal while it tilts.
  kRibs,       ///< Over the ribs of the right flank: shadows in every image.
};
/// Paths of the cohort of the documents: all but kRibs.
inline constexpr int kSweepPaths = 5;
const char* to_string(SweepPath path);

using sim::ErrorLevel;
using sim::errors_of;
using sim::kErrorLevels;
using sim::LevelErrors;
using sim::to_string;

struct SweepRequest {
  SweepPath path = SweepPath::kSubcostal;
  std::uint64_t seed = 1;  ///< Seed of the hand motion, tracker errors, speckle and depth gain.
  int frames = 60;         ///< >= 2.
  sim::AcousticModel model = sim::AcousticModel::kRays;
  /// Absent: the errors of the cohort, a tracker of 0.15 mm and 0.0015 rad and nothing else.
  std::optional<ErrorLevel> level = {};
};

/// Tracker errors of the cohort: uniformly distributed, standard deviation per axis.
inline constexpr double kTrackerMm = 0.15;
inline constexpr double kTrackerRad = 0.0015;
/// A pose as the tracker measures it.
Transform<frames::Reference, frames::Image> measured(
    const Transform<frames::Reference, frames::Image>& exact, sim::Random& random,
    double tracker_mm = kTrackerMm, double tracker_rad = kTrackerRad);

/// A patient with a CT of 1.5 x 1.5 x 2 mm and 12 HU of noise.
struct Patient {
  std::uint64_t seed;
  sim::AbdomenPhantom phantom;
  std::shared_ptr<const Volume> ct;
  CtPose truth;  ///< Seeded: no axis of Reference is parallel to one of the CT.
};

/// Making the CT is half of the work.
Patient make_patient(std::uint64_t seed);

/// True if a point lies within 8 mm of one of the images and inside its field of view.
bool seen(const Point<frames::Ct>& p,
          const std::vector<Transform<frames::Ct, frames::Image>>& poses,
          const SectorOutline& outline);

/// A sweep with the points of the liver that it shows.
struct RecordedSweep {
  SweepPath path;
  Sweep sweep;
  /// Points of the liver that are seen(): the target error is measured there.
  std::vector<Point<frames::Ct>> targets;
};
RecordedSweep record_sweep(const Patient& patient, const SweepRequest& request);

/// RMS distance of the targets from their true positions, mm. Precondition: targets is not empty.
double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets);
/// RMS distance of the targets from their true positions, mm, if these (lying) differ during the
/// sweep from those in the CT.
double target_error_mm(const CtPose& found, const CtPose& truth,
                       const std::vector<Point<frames::Ct>>& targets,
                       const std::vector<Point<frames::Ct>>& lying);

/// A start whose target error is error_mm: a rotation of 0.8 degrees per mm (at most 30, less if it
/// alone would exceed the error) about the sweep's centroid and a translation, both in seeded
/// random directions.
CtPose start_at(double error_mm, const CtPose& truth, const RecordedSweep& recorded,
                std::uint64_t seed);

}  // namespace nav::bench
