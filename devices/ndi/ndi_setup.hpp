// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// Place of a tool that is plugged in.
struct NdiPlace {
  unsigned port = 0;  ///< From 1.
  unsigned channel = 0;
  auto operator<=>(const NdiPlace&) const = default;
};

/// A tool that is wanted.
struct NdiTool {
  std::string name;             ///< For messages.
  std::filesystem::path rom{};  ///< Tool definition of a wireless tool; empty: it is plugged in.
  /// Port that it is plugged in at; absent: the next port that no other tool names.
  std::optional<NdiPlace> place{};
};

/// One command whose reply is awaited.
struct NdiStep {
  std::string command;
  Duration longest;        ///< Time for its reply.
  bool repeatable = true;  ///< It may be sent again if the reply is lost.
  int baud = 0;            ///< Rate of the line after OKAY; 0: unchanged.
};

/// The dialogue from a connection to tracking, without I/O: it names the next command and takes the
/// reply. A tool that cannot be used costs only itself. Not thread-safe.
class NdiSetup {
 public:
  struct Tool {
    std::optional<std::uint8_t> handle{};
    std::string fault{};  ///< Why there is no handle, with what to do; a clause.
  };

  /// \p baud: rate to raise the line to; 0: it has none. The tracker has just been reset or
  /// connected. Reads the tool definitions from their files.
  NdiSetup(std::vector<NdiTool> tools, int baud);

  /// Current command; null: done, or failed.
  [[nodiscard]] const NdiStep* step() const { return steps_.empty() ? nullptr : &steps_[0].step; }
  /// Takes the reply to the current command.
  void take(const NdiReply& reply);
  /// Why tracking cannot begin; a clause.
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }
  [[nodiscard]] const NdiVersion& version() const { return version_; }
  /// One for each wanted tool, in the same order.
  [[nodiscard]] const std::vector<Tool>& tools() const { return found_; }
  /// Warnings of the tracker, each to be reported once.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  /// Looks for tools again, while tracking: one was plugged in. Tools in use keep their handles.
  void look_again();
  /// Forgets the handle of a tool that was unplugged.
  void forget(std::size_t tool) { found_[tool] = {}; }

 private:
  using Handler = std::function<void(const NdiReply&)>;
  struct Asked {
    NdiStep step;
    Handler handler;
  };
  using Phase = void (NdiSetup::*)();

  void ask(std::string_view name, const std::string& arguments, Duration longest, Handler handler);
  void run_phases();
  void fail(const NdiReply& reply, const std::string& what);
  void with_handles(const char* which, const std::function<void(const NdiHandle&)>& use);
  void say_hello();
  void raise_speed();
  void free_left_over();
  void free_ports();
  void load_tools();
  void load(std::size_t tool);
  void upload(std::size_t tool, std::uint8_t handle, const std::string& rom);
  void initialise_ports();
  void take_initialised(std::uint8_t handle, const NdiReply& reply);
  void find_plugged();
  void assign_plugged();
  void enable_tools();
  void start_tracking();
  void give_up_tool(std::uint8_t handle, const std::string& why);
  [[nodiscard]] std::optional<std::size_t> tool_of(std::uint8_t handle) const;

  std::vector<NdiTool> wanted_;
  int baud_;
  std::vector<Tool> found_;
  std::deque<Asked> steps_;
  std::vector<Phase> phases_;  ///< Left to do, the next one last.
  std::optional<std::string> failure_;
  NdiVersion version_;
  std::vector<std::string> notes_;
  std::vector<std::uint8_t> tried_;  ///< Handles whose PINIT has been sent.
  struct Plugged {
    NdiPlace place;
    std::uint8_t handle;
  };
  std::vector<Plugged> plugged_;
  std::string plugged_fault_;  ///< Newest failure of a tool that is plugged in.
};

}  // namespace nav::devices
