// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/appearance/appearance_file.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Preset that is drawn unless a session names another: ct-contextual for volumes in Hounsfield
/// units, mr-contextual for others.
inline constexpr const char* kContextualPreset = "contextual";

/// Folder of the presets that are appearance files: that of the environment variable
/// SONDE_APPEARANCES if it is set, else `appearances` beside the program, else the installed one.
/// It may be missing.
std::filesystem::path preset_folder();

/// Names of all presets: `contextual`, those of render::preset_names(), and the name, without
/// ending, of every .json file of a folder, sorted. A missing folder adds none.
std::vector<std::string> all_preset_names(const std::filesystem::path& folder = preset_folder());

/// Reads a preset of a folder. Errors: kNotFound, with folder and name, when there is no such file;
/// those of read_appearance_file(), which name the file.
Result<AppearanceFile> read_preset(const std::string& name,
                                   const std::filesystem::path& folder = preset_folder());

}  // namespace nav::app
