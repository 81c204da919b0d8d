// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::io {

struct CtOptions {
  /// SeriesInstanceUID to take from a DICOM folder; empty: the CT series with most slices.
  std::string series_uid;
  /// Take a file that does not say how its axes lie in the patient as LPS, with a warning;
  /// otherwise it is refused.
  bool accept_unknown_orientation = false;
  /// Wider gaps between slices are refused instead of interpolated, mm.
  double max_gap_mm = 10.0;
  /// Fewer slices in a file other than DICOM are refused: one is no CT, but may be ultrasound.
  int least_slices = 2;
  /// Of values, in messages; empty: stored values of something else, which have none.
  std::string unit = "HU";
  std::int16_t least = kAirHu;  ///< Lower values are set to it: no tissue has them, padding has.
};

/// Reads a CT as Hounsfield units in LPS: a DICOM folder or file (compressed and multi-frame too),
/// NIfTI (.nii, .nii.gz), MetaImage (.mha, .mhd) or NRRD (.nrrd, .nhdr), told apart by ending and
/// content. Directions are those of the file, left-handed ones included. Values are rounded to
/// int16 and those below the options' least, -1024 HU (padding), set to it; how many is reported. A
/// DICOM stack that is tilted or unevenly spaced is resampled by linear interpolation onto a
/// regular orthogonal grid, with a warning; what cannot be true is refused by name, and so are
/// reals that rounding would destroy (some not whole, all within less than 64 of each other).
/// Blocks; thread-safe.
Result<Volume> read_ct(const std::filesystem::path& path, Diagnostics& diagnostics,
                       const CtOptions& options = {});

/// Whether read_ct takes a file of a folder for one of DICOM, by its content; false for one that
/// cannot be read. Blocks; thread-safe.
bool is_dicom(const std::filesystem::path& path);

/// Writes a MetaImage with exact geometry (LPS), zlib-compressed unless told otherwise; atomically.
Result<void> write_ct_mha(const Volume& volume, const std::filesystem::path& path,
                          bool compress = true);

}  // namespace nav::io
