// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/detail/input_file.hpp"

namespace nav::io::detail {

/// Walks the elements of a DICOM file up to the end of its pixel data and checks that every length
/// stays within its bounds (PS3.5, section 7): the library that reads it next crashes on some that
/// do not. Returns what is wrong, or nothing.
std::string dicom_structure_defect(const InputFile& file);

}  // namespace nav::io::detail
