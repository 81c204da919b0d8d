// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace nav::app {

/// Options of the window.
struct WindowOptions {
  std::filesystem::path script{};  ///< Lines that drive the window; empty: the user does.
  std::filesystem::path shots{};   ///< Folder of shots and snapshots; empty: none, and here.
  std::string engine = "auto";     ///< auto: OpenGL on a graphics card, otherwise cpu.
  bool simulated = false;          ///< The simulated procedure, without a session file.
  std::uint64_t seed = 1;          ///< Number of the simulated patient.
  std::string phantom{};           ///< Simulated 3D ultrasound that is shown alone; empty: none.
  bool once = false;               ///< A recording is played to its end, not again and again.
};

}  // namespace nav::app
