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
  /// SeriesInstanceUID to read from a DICOM folder; empty: the CT series with most slices.
  std::string series_uid;
  /// Accepts a file without axis orientation as LPS, with a warning; otherwise it is rejected.
  bool accept_unknown_orientation = false;
  /// Reports values that do not seem to be Hounsfield units (is_hounsfield()).
  bool expect_hounsfield_units = true;
  /// Largest gap between slices that is interpolated, mm; wider gaps are rejected.
  double max_gap_mm = 10.0;
};

/// Reads a CT as Hounsfield units in LPS: a DICOM folder or file (also compressed and multi-frame),
/// NIfTI (.nii, .nii.gz), MetaImage (.mha, .mhd) or NRRD (.nrrd, .nhdr), recognised by ending and
/// content. The directions are those of the file, including left-handed ones. Values are rounded to
/// int16. Values below -1024 HU (padding) are set to it, and their number is reported. A DICOM
/// stack that is tilted or unevenly spaced is resampled by linear interpolation onto a regular
/// orthogonal grid, with a warning. Impossible values are rejected by name. Real values that
/// rounding would destroy (some not whole, all within less than 64 of each other) are rejected too.
/// Blocks; thread-safe.
Result<Volume> read_ct(const std::filesystem::path& path, Diagnostics& diagnostics,
                       const CtOptions& options = {});

/// Reads a volume of another kind than CT, such as 3D ultrasound, in stored values and LPS.
/// Formats, rounding, resampling and errors are those of read_ct(). A single slice is accepted.
/// Values outside [-32768, 32767] are set to the nearer limit, and their number is reported.
/// Blocks; thread-safe.
Result<StoredVolume> read_stored_volume(const std::filesystem::path& path,
                                        Diagnostics& diagnostics);

/// True when read_ct() would read a file of a folder as DICOM, by its content; false when it cannot
/// be read. Blocks; thread-safe.
bool is_dicom(const std::filesystem::path& path);

/// Writes a CT, or another volume of stored values, as a MetaImage with exact geometry (LPS),
/// atomically; zlib-compressed by default. \p mark: it names Sonde, so that is_own_file()
/// recognises it; for files that the user does not name.
Result<void> write_ct_mha(const StoredVolume& volume, const std::filesystem::path& path,
                          bool compress = true, bool mark = false);

}  // namespace nav::io
