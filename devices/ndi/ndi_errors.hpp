// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace nav::devices {

/// Codes of ERROR that decide what is done next.
inline constexpr std::uint8_t kNdiInvalidCommand = 0x01;
inline constexpr std::uint8_t kNdiWrongMode = 0x0C;
inline constexpr std::uint8_t kNdiNotInitialised = 0x10;

/// An ERROR of the combined API: "error 0C: the command … ; what to do". A code that is not known
/// is said as such.
std::string ndi_error_sentence(std::uint8_t code);
/// A WARNING of the combined API; 0: one without a number.
std::string ndi_warning_sentence(std::uint8_t code);

}  // namespace nav::devices
