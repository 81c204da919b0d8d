// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "io/detail/input_file.hpp"

namespace nav::io::detail {

/// Statements of a DICOM file about its compressed images.
struct ClaimedImages {
  std::string transfer_syntax;
  std::int64_t pixel_data = 0;  ///< Offset of the value of the pixel data in the file, bytes.
  std::int64_t bytes = 0;       ///< Length of the value, bytes.
  int rows = 0;
  int columns = 0;
  int frames = 1;
  int bytes_of_sample = 2;
};

/// A defect of JPEG 2000 or JPEG-LS data that a decoder would answer with memory for more than they
/// hold, or with zeros in place of samples; otherwise an empty text. The codestream of the first
/// image has another size than Rows and Columns, that of the last has no end, or there are more
/// samples than so many bytes can stand for. Other syntaxes have no defect here. ISO/IEC 15444-1,
/// annex A.5.1 (SIZ); ISO/IEC 14495-1, annexes C.2.2 (SOF55) and A.7.1 (a line of runs takes a bit
/// at least).
std::string codestream_defect(const InputFile& file, const ClaimedImages& claimed);

}  // namespace nav::io::detail
