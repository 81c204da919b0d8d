// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace nav::devices {

/// Judgement of a content's size before all of it is there.
enum class IgtlFit {
  kFits,         ///< The type has this size.
  kUnknownType,  ///< Nothing is known about the type, or the size is possible but unusual.
  kMore,         ///< The size depends on bytes that are not there yet.
  kWrong,        ///< The type cannot have this size.
};

/// Judges the size of a content of that type. \p start: the beginning of the content as far as it
/// is there. It lets a parser see at once that a size was damaged, instead of waiting for bytes
/// that never come.
IgtlFit igtl_fit(std::string_view type, std::uint64_t size, std::span<const std::byte> start);

}  // namespace nav::devices
