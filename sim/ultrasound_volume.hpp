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

/// A three-dimensional acquisition: a matrix probe, or a linear probe that was swept evenly.
/// The probe gives frequency, focus, beam widths, levels and depth gain; its kind, sizes, numbers
/// of lines and pixels play no part.
struct UltrasoundVolumeOptions {
  ProbeModel probe = linear_l14();
  std::array<int, 3> size{192, 192, 192};  ///< Voxels across, deep, along; [8, 512] each.
  double width_mm = 40;                    ///< Across, at the greatest depth.
  double depth_mm = 40;                    ///< From the face.
  double thickness_mm = 40;                ///< In elevation, at the greatest depth.
  /// Scan lines come from a point this far behind the face, mm; 0: they are parallel.
  double apex_mm = 0;
  std::uint64_t seed = 1;  ///< Of speckle and noise; equal to the pictures' of the same patient.
};

/// Log-compressed, speckled ultrasound on a grid, 0 (black) to 255 (white), with where its scan
/// lines came from. Voxels that no scan line reaches are 0.
struct UltrasoundVolume {
  Volume volume;  ///< Axes: across (image +x), deep (+y), along (+z).
  Point<frames::Ct> face_ct;
  Direction<frames::Ct> into_ct;  ///< Unit; the middle scan line.
  double apex_mm;                 ///< As in the options: the apex is face - apex_mm · into.
};

/// A refusal that names the first setting that cannot be.
Result<void> validate(const UltrasoundVolumeOptions& options);

/// The model of UltrasoundSimulator on a grid of scan lines: interfaces with the true incidence
/// angle, beam width in both directions. ct_from_image: the face, as of a picture in the middle of
/// the volume. The same bytes for any number of threads. About 60 bytes per voxel while it runs.
Result<UltrasoundVolume> scan_ultrasound_volume(
    const Anatomy& patient, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const UltrasoundVolumeOptions& options = {});

/// One bit for each group of tissues per voxel, i fastest: bit n is set where the voxel's centre
/// holds a tissue of groups[n] (at most 32 groups).
std::vector<std::uint32_t> label_bits(const Anatomy& patient, const VoxelGrid& grid,
                                      const std::vector<std::vector<Tissue>>& groups);

}  // namespace nav::sim
