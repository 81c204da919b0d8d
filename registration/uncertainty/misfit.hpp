// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "nav/transform.hpp"
#include "registration/motion/picture_motion.hpp"
#include "registration/twist.hpp"

/// What pictures and CT disagree about at a pose besides noise, by what may cause it: no pose takes
/// it up, so that a pose alone looks well determined and is wrong.
namespace nav::registration {

struct LocalShape;
struct PatchSet;

/// What may be wrong with a sweep, or with the patient in it; those of fewest numbers first.
enum class MisfitCause {
  kDelay,        ///< Pictures were taken later or earlier than their poses.
  kPixelSize,    ///< Depth and width of a pixel, or the speed of sound.
  kCalibration,  ///< Where the pictures lie on the probe.
  kMotion,       ///< The patient moved while the pictures were taken.
  kBend,         ///< The tissue lies otherwise than in the CT: a polynomial of second degree.
};
inline constexpr int kMisfitCauses = 5;

/// Stable lower-case name: "delay", "pixel_size", "calibration", "motion", "bend".
const char* to_string(MisfitCause cause);

/// From where on an excess is no chance, by MisfitCause, mm.
inline constexpr std::array<double, kMisfitCauses> kTellingMm = {0.4, 0.45, 0.5, 0.85, 0.95};

/// What one cause would explain.
struct Misfit {
  MisfitCause cause;
  /// How far what the pictures show would move if the cause were accounted for and the pose found
  /// anew, one Newton step, RMS over the patches, mm.
  double found_mm = 0;
  double noise_mm = 0;  ///< What found_mm is expected to be where nothing is wrong.
  double gain = 0;      ///< What the step takes off the cost, by its curvature.
  /// kDelay: by how much the pictures are later than their poses say, s. kPixelSize: true over
  /// assumed depth and width, less 1. kCalibration: turn (rad) and shift (mm) in the picture's
  /// axes. Others: empty. A step from afar is inexact: of 200 ms it finds 110 to 280.
  std::vector<double> values = {};

  /// How large a fault would be only just worth a warning in this sweep: a delay, s, a share of
  /// depth, a shift of the calibration in the direction that it shows least of, mm, how far a
  /// motion or a bend moves what the pictures show besides what a pose takes up, RMS, mm; infinite
  /// where the sweep never shows it.
  double unnoticed = 0;
  /// kCalibration: that direction in the picture's axes, a unit vector. A probe that turns about
  /// one axis shows nothing of a shift along it, and one that does not turn of none: the pose takes
  /// it up, pictures lie right in the CT, and what is tracked by itself does not.
  std::vector<double> unnoticed_along = {};

  /// √(found² − 3 noise²), 0 where that is negative: what is beyond noise, mm.
  [[nodiscard]] double excess_mm() const;
};

/// One Newton step for pose and cause together from the pose that is best alone (a score test; Rao
/// 1948), with the true curvature as frame_bootstrap() has it, and with the scatter of what is left
/// of the patches' gradients in cubes of 20 mm for noise. A direction that the sweep does not tell
/// from a pose is left out. Nothing is found where patches lie in fewer cubes than a covariance
/// needs. Empty where the pose itself is not determined, and of a similarity without parts.
/// motions: of the pictures that patches are of.
std::vector<Misfit> find_misfits(const LocalShape& shape, const PatchSet& patches,
                                 const Transform<frames::Ct, frames::Reference>& pose,
                                 std::span<const PictureMotion> motions);

/// What a pose's covariance gains where the calibration is right within sigma_mm, >= 0: standard
/// deviation of a shift along each of the picture's axes and, at 60 mm, of a turn about each. So
/// much of it goes into the pose, and off what is tracked by itself. [rad | mm] about the shape's
/// centre, as PoseUncertainty. Nothing where a pose is not determined, and of a similarity without
/// parts.
Matrix6d calibration_covariance(const LocalShape& shape, const PatchSet& patches,
                                const Transform<frames::Ct, frames::Reference>& pose,
                                std::span<const PictureMotion> motions, double sigma_mm);

/// The largest excess, each by how little it may be chance, mm: none of it up to half of
/// kTellingMm, all of it from there on, linearly between. 0 without misfits. NaN where one is NaN.
double telling_excess_mm(const std::vector<Misfit>& misfits);

/// For the user: faults that this sweep would not show, by Misfit::unnoticed; empty without
/// misfits.
std::string unnoticed_in_words(const std::vector<Misfit>& misfits);

/// For the user: what a misfit would mean, with its numbers, and what to do about it.
std::string in_words(const Misfit& misfit);

}  // namespace nav::registration
