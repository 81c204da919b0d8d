// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "nav/transform.hpp"
#include "registration/image_errors.hpp"
#include "registration/motion/image_motion.hpp"
#include "registration/twist.hpp"

/// Disagreement of ultrasound images and CT at a pose beyond noise, by its possible causes. No pose
/// can absorb it, so that a pose alone may look well determined and be wrong.
namespace nav::registration {

struct LocalShape;
struct PatchSet;

/// Possible faults of a sweep, or of the patient in it; causes with the fewest parameters first.
enum class MisfitCause {
  kDelay,        ///< Ultrasound images were taken later or earlier than their poses.
  kPixelSize,    ///< Depth and width of a pixel, or the speed of sound, are wrong.
  kCalibration,  ///< The position of the images relative to the probe is wrong.
  kMotion,       ///< The patient moved during the sweep.
  kBend,         ///< The tissue is deformed relative to the CT: a polynomial of second degree.
};
inline constexpr int kMisfitCauses = 5;

/// Stable lower-case name: "delay", "pixel_size", "calibration", "motion", "bend".
const char* to_string(MisfitCause cause);

/// Excess from which a misfit is not chance, by MisfitCause, mm.
inline constexpr std::array<double, kMisfitCauses> kTellingMm = {0.4, 0.45, 0.5, 0.85, 0.95};

/// The part of the disagreement that one cause would explain.
struct Misfit {
  MisfitCause cause;
  /// Distance that the image content would move if the cause were corrected and the pose found
  /// again (one Newton step), RMS over the patches, mm.
  double found_mm = 0;
  double noise_mm = 0;  ///< Expected value of found_mm if nothing is wrong.
  double gain = 0;      ///< Reduction of the cost by the step, from its curvature.
  /// kDelay: delay of the images relative to their poses, s. kPixelSize: true over assumed depth
  /// and width, minus 1. kCalibration: rotation (rad) and translation (mm) in the image's axes.
  /// Others: empty. A large step is inexact: for 200 ms it finds 110 to 280.
  std::vector<double> values = {};
  /// Standard deviations of the values; empty: the cause was not estimated with the pose.
  std::vector<double> deviations = {};

  /// Size of a fault that is only just worth a warning in this sweep: a delay, s; a fraction of the
  /// depth; a calibration shift in the direction that the sweep shows least, mm; the distance that
  /// a motion or deformation moves the image content beyond what a pose absorbs, RMS, mm. Infinite
  /// if the sweep never shows it.
  double unnoticed = 0;
  /// kCalibration: that direction in the image's axes, a unit vector. A probe that rotates about
  /// one axis does not show a shift along that axis, and a probe that does not rotate shows no
  /// shift at all. The pose then absorbs the shift: images lie right in the CT, but a tool that is
  /// tracked by itself does not.
  std::vector<double> unnoticed_along = {};

  /// √(found² − 3 noise²), 0 if that is negative: the part beyond noise, mm.
  [[nodiscard]] double excess_mm() const;
  /// True if the 95 % interval of one of the values excludes 0, or if they have none.
  [[nodiscard]] bool telling() const;
};

/// One Newton step for pose and cause together from the best pose alone (a score test; Rao 1948).
/// It uses the true curvature as in image_bootstrap(); the noise comes from the scatter of the
/// remaining gradients of the patches in cubes of 20 mm. Directions that the sweep cannot
/// distinguish from a pose are left out. Nothing is found if the patches lie in fewer cubes than a
/// covariance needs. Empty if the pose itself is not determined, and for a similarity without terms
/// of single patches. motions: motions of the images that the patches belong to. corrected: errors
/// that the patches of the shape were corrected by before; they count as found.
std::vector<Misfit> find_misfits(const LocalShape& shape, const PatchSet& patches,
                                 const Transform<frames::Ct, frames::Reference>& pose,
                                 std::span<const ImageMotion> motions,
                                 const ImageErrors& corrected = {});

/// The most likely cause among the misfits whose excess is beyond limits_mm, by MisfitCause: the
/// simplest (with the fewest parameters) that explains at least two fifths of what the best of them
/// explains. A delay also looks like a motion, and wrong pixels like a bend. Causes that were
/// estimated with the pose do not count. Points into \p misfits; null: none is beyond its limit.
const Misfit* likeliest_of(const std::vector<Misfit>& misfits,
                           const std::array<double, kMisfitCauses>& limits_mm);

/// The largest excess, weighted by how unlikely it is chance, mm: weight 0 up to half of
/// kTellingMm, 1 from kTellingMm on, linear in between. 0 without misfits. NaN if one is NaN.
/// Causes that were estimated with the pose do not count.
double telling_excess_mm(const std::vector<Misfit>& misfits);

/// Says how well errors are known that were estimated with the pose: sets Misfit::deviations of
/// their causes, and Misfit::unnoticed to the half width of the 95 % interval. covariance: of
/// ImageErrors::vector(); sigmas: before the sweep, 0 for an error that was not estimated. An error
/// that the sweep leaves within 10 % as unknown as it was is one that it never shows.
void set_intervals(const Eigen::Matrix<double, kErrorParameters, kErrorParameters>& covariance,
                   const ErrorSigmas& sigmas, std::vector<Misfit>& misfits);

/// Text for the user: faults that this sweep would not show, by Misfit::unnoticed; empty without
/// misfits.
std::string unnoticed_in_words(const std::vector<Misfit>& misfits);

/// Text for the user: the meaning of a misfit, with its numbers, and what to do about it.
std::string in_words(const Misfit& misfit);

}  // namespace nav::registration
