// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

struct ServeOptions {
  std::string listen = "127.0.0.1";  ///< Address; the default is reached from this machine only.
  int port = 18944;                  ///< 0: the system chooses one and the program prints it.
  std::string emulated =
      "openigtlink";  ///< Emulate only: "openigtlink", "ndi", "can-arm", "polhemus", "interson".
  /// Line of the emulated tracker: for ndi "serial:PATH", a link to a pseudo terminal that is made;
  /// for can-arm "can:INTERFACE"; for all others "tcp:PORT" at 127.0.0.1 (0: the system chooses
  /// one). Empty: the usual one.
  std::string line{};
  std::string arm{};       ///< Emulated can-arm: file for its kinematics.
  double fault_rate = 0;   ///< Part of the tracker's replies that have a fault, [0, 1].
  std::uint64_t seed = 1;  ///< Seed of the faults.
};

/// Serves the samples of a session file's devices by OpenIGTLink, as PLUS names them, for
/// config.output.seconds (0: until Ctrl-C, or the devices have nothing more). Clients may come and
/// go. kUnavailable when the address cannot be had.
Result<void> run_serve(const SessionConfig& config, const ServeOptions& options,
                       const std::optional<std::string>& json, Console& console);

/// Does what run_serve() does, with the poses or images by the other side of another wire. kUsage
/// for a line that cannot be read, or devices without poses.
Result<void> run_emulate(const SessionConfig& config, const ServeOptions& options,
                         const std::optional<std::string>& json, Console& console);

}  // namespace nav::app
