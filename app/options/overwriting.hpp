// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// A file, and the option or key that names it.
struct NamedFile {
  std::string name;
  std::filesystem::path path;  ///< Empty: none.
};

/// Rejects outputs that would replace an input, a DICOM image in a folder that is one, the pixels
/// beside a header that is one, or one another, by both names. Pipes, /dev/null and "-" may be
/// written to more than once.
Result<void> reject_overwriting(const std::vector<NamedFile>& outputs,
                                const std::vector<NamedFile>& inputs);

/// Rejects outputs that the user did not name, and in whose place lies a file that Sonde did not
/// write (io::is_own_file()).
Result<void> reject_foreign(const std::vector<NamedFile>& outputs);

/// Rejects outputs that cannot be written, by name, before anything is computed; leaves nothing
/// behind, and removes unfinished files that killed runs left beside them. What lies in one of the
/// folders that the verb makes by itself is taken as it is.
Result<void> reject_unwritable(const std::vector<NamedFile>& outputs,
                               const std::vector<std::filesystem::path>& made = {});

}  // namespace nav::app
