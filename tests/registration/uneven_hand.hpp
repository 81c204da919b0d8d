// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "tests/registration/synthetic.hpp"

/// A sweep by an uneven hand: it shows delay, scale and calibration as far as any sweep does.
namespace nav::test {

inline constexpr int kHandImages = 48;
inline constexpr double kHandStepS = 0.1;  ///< Time between images.

inline const BlobPatient& hand_patient() {
  static const BlobPatient instance(7, 150);
  return instance;
}

inline const Volume& hand_ct() {
  static const Volume instance = blob_ct(hand_patient(), cubic_grid(75));
  return instance;
}

/// A hand that moves at an uneven speed, tilts and turns.
inline Transform<frames::Ct, frames::Image> uneven_hand_at(double seconds) {
  using Vec = Eigen::Vector3d;
  const double t = seconds / (kHandStepS * (kHandImages - 1));  // Ranges from 0 to 1.
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(0.5 * std::sin(5 * t), Vec::UnitY()) *
                                  Eigen::AngleAxisd(0.25 * std::sin(9 * t), Vec::UnitX());
  const double along = 70 * (t - 0.5) + 6 * std::sin(7 * t);
  return {turn.normalized(), Vec(0, 0, along) - turn * Vec(0, 45, 0)};
}

/// Images of the hand's path. rest: see images_along().
template <class Rest>
Sweep uneven_sweep(const Rest& rest) {
  return images_along(
             hand_patient(), kHandImages, [](int f) { return uneven_hand_at(kHandStepS * f); },
             rest)
      .sweep;
}

/// Images of a patient at rest, with the poses of late_s before the images.
inline Sweep uneven_sweep_late_by(double late_s) {
  const Sweep right =
      uneven_sweep([](int, const Eigen::Vector3d& now, const Eigen::Vector3d& beam) -> AtRest {
        return {now, beam};
      });
  std::vector<TrackedImage> frames = right.frames();
  for (int f = 0; f < kHandImages; ++f) {
    frames[static_cast<std::size_t>(f)].reference_from_image =
        true_pose().inverse() * uneven_hand_at(kHandStepS * f - late_s);
  }
  return *Sweep::create(std::move(frames), "late");
}

/// Options that fit these images.
inline registration::ImageRegistrationOptions hand_options() {
  registration::ImageRegistrationOptions solver = small_options(0);
  solver.levels.back() = {.sample_step_mm = 1.6,
                          .patch_side = 9,
                          .patches = 1500,
                          .frame_step_mm = 1,
                          .choice = registration::PatchChoice::kEven};
  return solver;
}

}  // namespace nav::test
