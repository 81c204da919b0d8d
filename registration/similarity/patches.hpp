// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/image.hpp"
#include "nav/sweep.hpp"
#include "registration/image_registration.hpp"

namespace nav::registration {

/// The weight of a patch is this power of its contrast. Larger powers let a few bright interfaces
/// dominate a search from afar.
inline constexpr double kPatchWeightPower = 0.3;

/// A square of ultrasound samples in the plane of its image, fixed in Reference.
struct Patch {
  Eigen::Vector3d centre_mm;       ///< Reference.
  Eigen::Vector3d step_a, step_b;  ///< Reference, mm per sample along the image's x and y.
  Eigen::Vector3d beam;            ///< Reference, unit, away from the transducer.
  double weight;                   ///< >= 0; the weights of a set sum to 1.
  int frame;                       ///< Index of the ultrasound image in the sweep.
  double mean_grey = 0;            ///< Mean of the samples before normalisation.
  double norm_grey = 0;            ///< Grey = mean_grey + norm_grey · u.
  double depth_mm = 0;             ///< Depth from the transducer along the beam.
  std::size_t index = 0;  ///< Index in the whole set of its level, of which other sets are parts.
};

/// The patches of one level.
struct PatchSet {
  int side = 0;
  std::vector<Patch> patches;
  std::vector<float> samples;  ///< side² values per patch, mean 0, norm 1.
  int frames = 0;              ///< Thinned ultrasound images that were used.

  [[nodiscard]] std::span<const float> u(std::size_t patch) const {
    const auto n = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    return {samples.data() + patch * n, n};
  }
};

/// Largest distance that a corner moves from one ultrasound image to another, Reference, mm.
double corners_moved_mm(const TrackedImage& from, const TrackedImage& to);

/// Indices of ultrasound images about step_mm apart: the first, then each image with a corner that
/// has moved at least step_mm since the last kept one.
std::vector<int> thin_frames(const Sweep& sweep, double step_mm);

/// Cuts patches on a grid of half their width, with all samples inside the mask, as many as the
/// level asks for and chosen as it says. The image is smoothed to the level first, without the
/// pixels outside the mask. May be empty. Deterministic.
PatchSet make_patches(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks,
                      const LevelOptions& level, double sigma_mm);

/// The given patches with every stride-th sample from their middle, centred and normalised again,
/// with the same grey scale. Patches that become flat are left out. Precondition: 1 <= stride <=
/// (side − 1)/2.
PatchSet coarsened(const PatchSet& patches, int stride);

/// The patches for which keep(patch) is true; their weights are rescaled to sum to 1.
template <class Predicate>
PatchSet subset(const PatchSet& all, Predicate keep) {
  PatchSet out{all.side, {}, {}, all.frames};
  double total = 0;
  for (std::size_t i = 0; i < all.patches.size(); ++i) {
    if (!keep(all.patches[i])) continue;
    out.patches.push_back(all.patches[i]);
    total += all.patches[i].weight;
    const auto u = all.u(i);
    out.samples.insert(out.samples.end(), u.begin(), u.end());
  }
  for (Patch& patch : out.patches) patch.weight /= total;
  return out;
}

}  // namespace nav::registration
