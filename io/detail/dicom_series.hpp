// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/ct.hpp"
#include "io/detail/dicom_stack.hpp"

namespace nav::io::detail {

/// A DICOM series as its headers tell it.
struct DicomSeries {
  std::string uid;
  std::string modality;
  std::string description;
  std::string tilt_tag;  ///< GantryDetectorTilt, degrees as text; empty when absent.
  std::vector<DicomSlice> slices;
  std::size_t without_rescale = 0;  ///< Slices that say nothing of their unit.
  std::size_t localizers = 0;       ///< Overview pictures left out.
  std::string defect;  ///< First thing that makes the series unreadable; empty when none.
};

/// Parses the headers of the files that are DICOM and groups their pictures.
Result<std::vector<DicomSeries>> scan_dicom(const std::vector<std::filesystem::path>& files,
                                            const std::string& name);

/// Takes the series asked for, or the CT series with most slices, and says what it passed over.
Result<DicomSeries> choose_series(std::vector<DicomSeries> all, const std::string& name,
                                  const CtOptions& options, Diagnostics& diagnostics);

/// Decodes the slices of a stack, in its order, to HU. Reads each file once.
Result<HuBuilder> decode_slices(const DicomStack& stack, const std::string& name,
                                std::int16_t least);

}  // namespace nav::io::detail
