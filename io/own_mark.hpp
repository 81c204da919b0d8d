// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "nav/result.hpp"

namespace nav::io {

/// Text that PNG and WebP files of Sonde carry as the name of the software.
inline constexpr std::string_view kSoftwareMark = "Sonde";

/// True if Sonde wrote the file, by a mark inside it. The mark is, by the end of the name:
///   .png    text chunk "Software" behind the header
///   .webp   XMP chunk at the end
///   .json   object with the texts "verb" and "version"
///   .html   footer of a report
///   .csv    first line of a pose log or of a log of the following
///   .mha    key Software, or that of scan lines
///   .toml   first line of with_mark(), and the digest in it fits the rest
/// A file that was changed by hand is not recognised, except a PNG or a WebP whose marks stay.
/// Follows links. Errors: kIo, kNotFound when the file cannot be read.
Result<bool> is_own_file(const std::filesystem::path& path);

/// TOML text with a first line that says who wrote it and the digest of \p text.
std::string with_mark(std::string_view text);

}  // namespace nav::io
