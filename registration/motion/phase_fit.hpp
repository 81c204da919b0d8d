// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/motion/phase_registration.hpp"

/// Fits of a motion with the breath to a subset of the ultrasound images. Private to registration/.
namespace nav::registration {

/// The patches of one image, the image's share of all weights, its phase and the part that it
/// belongs to.
struct PhaseImage {
  PatchSet patches;
  double weight;
  double phase;
  int part;
};

using ChosenImages = std::vector<const PhaseImage*>;

/// The images of one level.
struct PhaseImages {
  const CtChannels& ct;
  std::vector<PhaseImage> images;

  [[nodiscard]] ChosenImages all() const { return chosen(-1, false); }
  /// The images of one part of the breaths, and all others.
  [[nodiscard]] ChosenImages of(int part) const { return chosen(part, true); }
  [[nodiscard]] ChosenImages without(int part) const { return chosen(part, false); }

 private:
  [[nodiscard]] ChosenImages chosen(int part, bool inside) const {
    ChosenImages out;
    for (const PhaseImage& image : images) {
      if ((image.part == part) == inside) out.push_back(&image);
    }
    return out;
  }
};

/// A series [60 rad | mm] about a pose: start and result of a fit.
struct PhaseFit {
  Pose pose;
  Eigen::Vector3d centre;
  Eigen::MatrixXd series;  ///< With one column: a common pose.
  double cost = 0;         ///< Cost of the images, including the stiffness.
  int iterations = 0;
  bool finite = true;

  [[nodiscard]] PhaseMotion motion() const { return {pose, centre, series}; }
};

/// Minimises the mean cost of the images at the poses of their phases + stiffness, over a series
/// with \p columns columns (columns that start lacks begin at 0). Iterations are added to those of
/// start. Images are evaluated in parallel; the result does not depend on the threads.
PhaseFit fit_phases(const CtChannels& ct, const ChosenImages& images, const PhaseFit& start,
                    Eigen::Index columns, const PhaseOptions& options);

/// Cost of each image under a motion; NaN if a patch has no finite similarity.
std::vector<double> costs_at(const CtChannels& ct, const ChosenImages& images,
                             const PhaseMotion& motion, const PhaseOptions& options);

}  // namespace nav::registration
