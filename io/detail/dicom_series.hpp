// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "io/ct.hpp"
#include "io/detail/dicom_stack.hpp"

namespace nav::io::detail {

/// False for a RescaleType of iodine maps, effective atomic numbers and the like; an absent or
/// unspecified one is taken as HU.
inline bool is_hounsfield_unit(const std::string& rescale_type) {
  return rescale_type.empty() || rescale_type == "HU" || rescale_type == "US";
}

/// DICOM series, read from its headers.
struct DicomSeries {
  std::string uid;
  std::string modality;
  std::string description;
  std::string unit;      ///< RescaleType of the first image; empty when absent: HU.
  std::string tilt_tag;  ///< GantryDetectorTilt, degrees as text; empty when absent.
  // Different values of the images; one of each is expected.
  std::set<std::string> patients;    ///< PatientID.
  std::set<std::string> studies;     ///< StudyInstanceUID.
  std::set<std::string> modalities;  ///< Modality.
  std::set<std::string> positions;   ///< PatientPosition, such as HFS.
  std::vector<DicomSlice> slices;
  std::size_t without_rescale = 0;  ///< Number of slices without a rescale: unknown unit.
  std::size_t localizers = 0;       ///< Number of overview images (localizers) that were left out.
  std::size_t longer_files = 0;     ///< Number of files with more pixel data than stated.
  std::string first_longer;         ///< The first of them, with both lengths in bytes.
  std::string defect;  ///< First defect that makes the series unreadable; empty when there is none.

  [[nodiscard]] bool in_hu() const { return is_hounsfield_unit(unit); }
};

/// Parses the headers of the DICOM files and groups their images by series. Names files that are
/// not DICOM, but may be damaged slices.
Result<std::vector<DicomSeries>> scan_dicom(const std::vector<std::filesystem::path>& files,
                                            const std::string& name, Diagnostics& diagnostics);

/// Selects the requested series, or the CT series with most slices, and reports the series that
/// were left out.
Result<DicomSeries> choose_series(std::vector<DicomSeries> all, const std::string& name,
                                  const CtOptions& options, Diagnostics& diagnostics);

/// Decodes the slices of a stack to HU, in their order. Each file is read once.
Result<HuBuilder> decode_slices(const DicomStack& stack, const std::string& name,
                                std::int16_t least);

}  // namespace nav::io::detail
