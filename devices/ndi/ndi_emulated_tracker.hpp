// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/ndi/ndi_poses.hpp"

namespace nav::devices {

/// A tool that an emulated tracker can see.
struct NdiEmulatedTool {
  std::string rom{};          ///< Content of its .rom file; empty: it is plugged in.
  unsigned port = 0;          ///< Port of a tool that is plugged in, from 1.
  bool plugged = true;        ///< Plugged in at the beginning.
  bool wrong_memory = false;  ///< Its PINIT fails (error 13).
};

struct NdiEmulatedOptions {
  std::vector<NdiEmulatedTool> tools;
  /// Gives the reading of a tool (index in `tools`) at a frame number: rotation, translation,
  /// error, presence and volume flags. A reading with a number of its own keeps it; the rest is
  /// filled in. Called by the emulator's thread.
  std::function<NdiToolReading(std::size_t tool, std::uint32_t number)> see;
  std::string firmware = "Polaris Control Firmware";
  std::string serial = "P4-00000";
  bool knows_bx2 = true;
  bool knows_bx = true;
  int most_baud = 921600;  ///< COMM with a higher rate fails (error 06).
};

/// The tracker's side of the combined API, without I/O. Each question for poses advances the frame
/// number by one, which is 1/60 s. Not thread-safe.
class NdiEmulatedTracker {
 public:
  explicit NdiEmulatedTracker(NdiEmulatedOptions options);

  /// Reply to one command, with or without CRC, without its CR.
  std::vector<std::byte> answer(std::string_view command);
  /// Reset by BREAK or by itself: all handles are forgotten. Returns what the tracker says.
  std::vector<std::byte> reset();
  void plug(std::size_t tool, bool in);
  /// The next question for poses gets the frame number of the one before.
  void hold_number() { hold_ = true; }
  [[nodiscard]] bool is_tracking() const { return tracking_; }

 private:
  struct Port {
    std::optional<std::size_t> tool{};  ///< Absent: no .rom that is known was loaded.
    bool wired = false;
    std::string rom{};
    bool initialised = false;
    bool enabled = false;
    bool gone = false;  ///< Unplugged; the handle is to be freed.
  };
  struct Command {
    std::string_view name;
    std::string_view arguments;
  };
  using Answer = std::string (NdiEmulatedTracker::*)(std::string_view);

  std::string text_answer(const Command& command);
  std::string list_ports(std::string_view which);
  std::string request_port(std::string_view arguments);
  std::string free_port(std::string_view arguments);
  std::string load(std::string_view arguments);
  std::string initialise(std::string_view arguments);
  std::string enable(std::string_view arguments);
  std::string disable(std::string_view arguments);
  std::string describe(std::string_view arguments);
  std::string change_speed(std::string_view arguments);
  std::string begin(std::string_view arguments);
  std::string version(std::string_view arguments);
  std::string start(std::string_view arguments);
  std::string stop(std::string_view arguments);
  NdiReadings look();
  void allocate_plugged();
  Port* port(std::string_view handle);

  NdiEmulatedOptions options_;
  std::map<std::uint8_t, Port> ports_;  ///< Keys: handles.
  std::vector<bool> plugged_;
  bool initialised_ = false;
  bool tracking_ = false;
  bool hold_ = false;
  bool news_of_ports_ = false;
  std::uint32_t number_ = 0;
};

}  // namespace nav::devices
