// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nav::io {

/// Kind of one sample in a file.
enum class PixelType { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat32, kFloat64 };

/// Bytes of one sample: 1, 2, 4 or 8.
std::size_t size_of(PixelType type);

/// Stable lower-case name ("uint8"), for reports.
const char* to_string(PixelType type);

}  // namespace nav::io
