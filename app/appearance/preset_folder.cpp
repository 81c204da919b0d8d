// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/preset_folder.hpp"

#include <algorithm>
#include <cstdlib>

#include "nav/on_demand.hpp"
#include "render/transfer/transfer_presets.hpp"

namespace nav::app {

std::filesystem::path preset_folder() {
  if (const char* named = std::getenv("SONDE_APPEARANCES"); named != nullptr && *named != '\0') {
    return named;
  }
  return library_of_program("appearances", SONDE_APPEARANCES_FOLDER);
}

std::vector<std::string> all_preset_names(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  std::error_code none;
  for (std::filesystem::directory_iterator at(folder, none), end; !none && at != end;
       at.increment(none)) {
    if (at->path().extension() == ".json") files.push_back(at->path().stem().string());
  }
  std::ranges::sort(files);
  std::vector<std::string> names{kContextualPreset};
  for (const auto& more : {render::preset_names(), files}) {
    for (const std::string& name : more) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

Result<AppearanceFile> read_preset(const std::string& name, const std::filesystem::path& folder) {
  const auto file = folder / (name + ".json");
  std::error_code none;
  if (!std::filesystem::is_directory(folder, none)) {
    return Error{ErrorCode::kNotFound, folder.string() + ": expected the folder of the presets, " +
                                           "found none: " + name +
                                           " cannot be drawn (set SONDE_APPEARANCES, or choose "
                                           "another --transfer-function)"};
  }
  if (!std::filesystem::exists(file, none)) {
    std::string known;
    for (const std::string& one : all_preset_names(folder)) {
      known += (known.empty() ? "" : ", ") + one;
    }
    return Error{ErrorCode::kNotFound,
                 file.string() + ": expected a preset, found none; presets: " + known};
  }
  return read_appearance_file(file);
}

}  // namespace nav::app
