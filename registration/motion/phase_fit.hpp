// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/motion/phase_registration.hpp"

/// Fits of a motion with the breath to some of the pictures. Private to registration/.
namespace nav::registration {

/// The patches of one picture, their share of all weights, its phase and which part it is of.
struct PhasePicture {
  PatchSet patches;
  double weight;
  double phase;
  int part;
};

using ChosenPictures = std::vector<const PhasePicture*>;

/// A level's pictures.
struct PhasePictures {
  const CtChannels& ct;
  std::vector<PhasePicture> pictures;

  [[nodiscard]] ChosenPictures all() const { return chosen(-1, false); }
  /// Those of a part of the breaths, and the others.
  [[nodiscard]] ChosenPictures of(int part) const { return chosen(part, true); }
  [[nodiscard]] ChosenPictures without(int part) const { return chosen(part, false); }

 private:
  [[nodiscard]] ChosenPictures chosen(int part, bool inside) const {
    ChosenPictures out;
    for (const PhasePicture& picture : pictures) {
      if ((picture.part == part) == inside) out.push_back(&picture);
    }
    return out;
  }
};

/// A series [60 rad | mm] about a pose: what a fit starts from and ends with.
struct PhaseFit {
  Pose pose;
  Eigen::Vector3d centre;
  Eigen::MatrixXd series;  ///< One column: a common pose.
  double cost = 0;         ///< Of the pictures, with the stiffness.
  int iterations = 0;
  bool finite = true;

  [[nodiscard]] PhaseMotion motion() const { return {pose, centre, series}; }
};

/// Minimises the mean of the pictures' costs at the poses of their phases + stiffness, over a
/// series with so many columns (those that start lacks begin at 0). Iterations are added up.
/// Pictures are evaluated side by side; the result does not depend on the threads.
PhaseFit fit_phases(const CtChannels& ct, const ChosenPictures& pictures, const PhaseFit& start,
                    Eigen::Index columns, const PhaseOptions& options);

/// Cost of each picture under a motion; NaN where a patch has no finite similarity.
std::vector<double> costs_at(const CtChannels& ct, const ChosenPictures& pictures,
                             const PhaseMotion& motion, const PhaseOptions& options);

}  // namespace nav::registration
