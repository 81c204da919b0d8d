// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/options/overwriting.hpp"
#include "app/options/session_config.hpp"

namespace nav::app {

/// Every file and folder that a session reads, but for itself, by the option that names it.
std::vector<NamedFile> session_inputs(const SessionConfig& config);

/// Files of these names in a folder that --out names; none without a folder.
std::vector<NamedFile> files_in(const std::filesystem::path& folder,
                                const std::vector<std::string>& names);

/// Rejects a report (--json) in the place of another output of the run: a file of \p outputs, which
/// all lie in \p folder, or an image there. report.json may be both.
Result<void> reject_report_over(const std::string& json, const std::filesystem::path& folder,
                                const std::vector<NamedFile>& outputs);

/// Rejects outputs of a session that would replace what it reads, or one another. json: of --json;
/// names: of what goes into the session's folder, the report among it.
Result<void> reject_overwriting_of(const SessionConfig& config, const std::string& json,
                                   const std::vector<std::string>& names);

}  // namespace nav::app
