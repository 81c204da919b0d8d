// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "nav/result.hpp"

namespace nav::app {

/// Choices of a user for all sessions, on this account. Sessions keep everything else.
struct UserSettings {
  static constexpr double kLeastTextScale = 1;
  static constexpr double kMostTextScale = 2;
  double text_scale = 1;  ///< Factor of all texts, within the limits above.
};

/// Folder of the user's settings: $XDG_CONFIG_HOME/sonde, else ~/.config/sonde; empty: neither
/// variable is set.
std::filesystem::path settings_folder();

/// The settings in window.toml of a folder; without that file, or with an empty folder, those of a
/// new user. Errors name the file and the key: kMalformedData (no TOML, a value that is out of its
/// range, an unknown key), kIo.
Result<UserSettings> read_user_settings(const std::filesystem::path& folder);
/// Writes window.toml, and makes the folder if need be. Does nothing with an empty folder.
Result<void> write_user_settings(const UserSettings& settings, const std::filesystem::path& folder);

}  // namespace nav::app
