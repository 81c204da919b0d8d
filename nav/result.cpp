// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/result.hpp"

namespace nav {

const char* to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return "usage";
    case ErrorCode::kNotFound:
      return "not_found";
    case ErrorCode::kMalformedData:
      return "malformed_data";
    case ErrorCode::kUnsupportedData:
      return "unsupported_data";
    case ErrorCode::kIo:
      return "io";
    case ErrorCode::kUnavailable:
      return "unavailable";
    case ErrorCode::kTimeout:
      return "timeout";
    case ErrorCode::kCancelled:
      return "cancelled";
    case ErrorCode::kEndOfStream:
      return "end_of_stream";
    case ErrorCode::kRefused:
      return "refused";
    case ErrorCode::kNumerical:
      return "numerical";
  }
  return "unknown";
}

}  // namespace nav
