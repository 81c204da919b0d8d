// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/exit_code.hpp"

namespace nav::app {

int exit_code(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUsage:
      return kExitUsage;
    case ErrorCode::kNotFound:
    case ErrorCode::kMalformedData:
    case ErrorCode::kUnsupportedData:
    case ErrorCode::kIo:
    case ErrorCode::kEndOfStream:
      return kExitBadInput;
    case ErrorCode::kUnavailable:
    case ErrorCode::kTimeout:
      return kExitDevice;
    case ErrorCode::kRefused:
    case ErrorCode::kNumerical:
    case ErrorCode::kCancelled:
      return kExitRefused;
  }
  return kExitBug;
}

}  // namespace nav::app
