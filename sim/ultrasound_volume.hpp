// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nav/volume.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Options of a three-dimensional acquisition by a matrix probe, or by a linear probe that is swept
/// evenly. The probe's frequency, focus, beam widths, levels and depth gain are used; its kind,
/// sizes, and numbers of lines and pixels are not.
struct UltrasoundVolumeOptions {
  ProbeModel probe = linear_l14();
  std::array<int, 3> size{192, 192, 192};  ///< Voxels across, in depth, along; [8, 512].
  double width_mm = 40;                    ///< Width across, at the greatest depth.
  double depth_mm = 40;                    ///< Depth from the face.
  double thickness_mm = 40;                ///< Width in elevation, at the greatest depth.
  /// Distance from the face back to the point where the scan lines meet, mm; 0: they are parallel.
  double apex_mm = 0;
  std::uint64_t seed = 1;  ///< Seed of speckle and noise; that of the patient's images.
};

/// Log-compressed ultrasound with speckle on a grid, 0 (black) to 255 (white), and the origin of
/// its scan lines. Voxels that no scan line reaches are 0.
struct UltrasoundVolume {
  StoredVolume volume;  ///< Axes: across (image +x), depth (+y), along (+z).
  Point<frames::Ct> face_ct;
  Direction<frames::Ct> into_ct;  ///< Unit direction of the middle scan line.
  double apex_mm;                 ///< Value of the options: the apex is face - apex_mm · into.
};

/// Rejects invalid options; the message names the first invalid setting.
Result<void> validate(const UltrasoundVolumeOptions& options);

/// Applies the model of UltrasoundSimulator to a grid of scan lines: interfaces with the true
/// incidence angle, beam width in both directions. \p ct_from_image: pose of the face, like that of
/// an image in the middle of the volume. The bytes do not depend on the number of threads. It needs
/// about 60 bytes per voxel.
Result<UltrasoundVolume> scan_ultrasound_volume(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const UltrasoundVolumeOptions& options = {});

/// Bit field for each voxel, i fastest: bit n is set where the voxel's centre is in a tissue of
/// groups[n] (at most 32 groups).
std::vector<std::uint32_t> label_bits(const Anatomy& patient, const VoxelGrid& grid,
                                      const std::vector<std::vector<Tissue>>& groups);

}  // namespace nav::sim
