// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/detail/input_file.hpp"

namespace nav::io::detail {

/// Checks the elements of a DICOM file: every length must stay within its bounds (PS3.5, section
/// 7); zeros may follow the pixel data. The library that reads the file next crashes on some files
/// that violate this. Returns the defect, or an empty text.
std::string dicom_structure_defect(const InputFile& file);
/// True for a DICOM file, with or without the preamble of part 10; a file with the preamble may be
/// broken.
bool is_dicom(const InputFile& file);

}  // namespace nav::io::detail
