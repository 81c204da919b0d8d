// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/user_settings.hpp"

#include <cstdlib>
#include <sstream>
#include <string>
#include <toml++/toml.h>

#include "io/atomic_file.hpp"

namespace nav::app {
namespace {

constexpr std::uint64_t kLargestSettings = 1 << 20;
constexpr const char* kSettingsFile = "window.toml";
constexpr const char* kTextScaleKey = "text_scale";

std::string text_of(const toml::node& node) {
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

Result<UserSettings> settings_of(const std::string& file, const toml::table& table) {
  UserSettings settings;
  for (const auto& [key, value] : table) {
    if (key.str() != kTextScaleKey) {
      return Error{ErrorCode::kMalformedData, file + ": expected the key " + kTextScaleKey +
                                                  ", found " + std::string(key.str())};
    }
    const auto scale = value.value<double>();
    if (!scale ||
        !(*scale >= UserSettings::kLeastTextScale && *scale <= UserSettings::kMostTextScale)) {
      return Error{ErrorCode::kMalformedData,
                   file + ": text_scale: expected a number from 1 to 2, found " + text_of(value)};
    }
    settings.text_scale = *scale;
  }
  return settings;
}

}  // namespace

std::filesystem::path settings_folder() {
  const char* given = std::getenv("XDG_CONFIG_HOME");
  if (given != nullptr && std::filesystem::path(given).is_absolute()) {
    return std::filesystem::path(given) / "sonde";
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config" / "sonde";
}

Result<UserSettings> read_user_settings(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kSettingsFile;
  std::error_code failed;
  if (folder.empty() || !std::filesystem::exists(path, failed)) return UserSettings();
  const auto text = io::read_file(path, kLargestSettings);
  if (!text) return text.error();
  try {
    return settings_of(path.string(), toml::parse(*text));
  } catch (const toml::parse_error& problem) {
    return Error{ErrorCode::kMalformedData, path.string() + ": line " +
                                                std::to_string(problem.source().begin.line) + ": " +
                                                std::string(problem.description())};
  }
}

Result<void> write_user_settings(const UserSettings& settings,
                                 const std::filesystem::path& folder) {
  if (folder.empty()) return {};
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) {
    return Error{ErrorCode::kIo, folder.string() + ": cannot be created: " + failed.message()};
  }
  std::ostringstream text;
  text << "# What was chosen in the window of Sonde, for all sessions: docs/window.md\n"
       << toml::table{{kTextScaleKey, settings.text_scale}} << "\n";
  return io::write_file(folder / kSettingsFile, std::string_view(text.str()));
}

}  // namespace nav::app
