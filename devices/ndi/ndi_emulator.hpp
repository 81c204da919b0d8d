// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "devices/ndi/ndi_emulated_tracker.hpp"
#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// A fault of one reply.
enum class NdiEmulatedFault {
  kBadCrc,     ///< One byte is changed.
  kSilence,    ///< Nothing is sent.
  kSplit,      ///< It comes in two parts.
  kTruncated,  ///< The second half is missing.
  kGarbage,    ///< Bytes that belong to nothing come before it.
  kRepeat,     ///< The frame number of the reply before.
  kReset,      ///< The tracker is reset instead.
};

/// Faults of the replies with poses, by chance.
struct NdiFaultPlan {
  std::uint64_t seed = 1;
  double rate = 0;  ///< Part of the replies, [0, 1].
  std::vector<NdiEmulatedFault> kinds{};
};

/// Line of the emulator.
struct NdiEmulatorLine {
  bool tcp = false;        ///< Otherwise a pseudo terminal.
  std::uint16_t port = 0;  ///< TCP at 127.0.0.1; 0: the system chooses one.
  /// Pseudo terminal: a symbolic link to it that is made, as for a device with a lasting name;
  /// empty: none.
  std::filesystem::path link{};
};

/// A tracker of NDI without hardware: it serves NdiEmulatedTracker to one client on a pseudo
/// terminal or by TCP. It has one thread, which the destructor joins; all functions are
/// thread-safe. A pseudo terminal carries no BREAK and no baud rate.
class NdiEmulator {
 public:
  /// kUnavailable when the line cannot be had.
  static Result<std::unique_ptr<NdiEmulator>> start(NdiEmulatedOptions options,
                                                    NdiEmulatorLine line, NdiFaultPlan plan = {});
  ~NdiEmulator();
  NdiEmulator(const NdiEmulator&) = delete;
  NdiEmulator& operator=(const NdiEmulator&) = delete;

  /// Path of the pseudo terminal or of its link; empty for TCP.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] std::uint16_t port() const;
  /// The next replies have this fault.
  void inject(NdiEmulatedFault fault, std::size_t replies = 1);
  /// Replies that are still to have an injected fault.
  [[nodiscard]] std::size_t injected() const;
  /// Plugs a wired tool in or out.
  void plug(std::size_t tool, bool in);
  /// Resets the tracker, which says so.
  void reset();
  /// Takes the whole device away, and brings it back: reset, and at a new pseudo terminal behind
  /// the same link.
  void unplug();
  Result<void> replug();
  [[nodiscard]] std::uint64_t commands() const;

 private:
  NdiEmulator(NdiEmulatedOptions options, NdiEmulatorLine line, NdiFaultPlan plan);
  Result<void> open();
  Result<void> open_terminal();
  void close();
  void run();
  void take_bytes();
  void answer(std::string_view command);
  void send(std::vector<std::byte> reply);
  void flush();

  NdiEmulatorLine line_;
  NdiFaultPlan plan_;
  WakeEvent wake_;

  mutable std::mutex mutex_;  ///< Guards everything below.
  bool stopped_ = false;
  NdiEmulatedTracker tracker_;
  std::mt19937_64 random_;
  FileDescriptor listener_;
  FileDescriptor peer_;   ///< Client, or the master of the pseudo terminal.
  FileDescriptor slave_;  ///< Keeps the pseudo terminal alive while no client has it open.
  std::string path_;
  std::string terminal_;  ///< Target of the link; empty: there is no link of ours.
  std::string received_;
  std::vector<std::byte> unsent_;
  std::vector<NdiEmulatedFault> injected_;
  std::uint64_t commands_ = 0;

  std::thread thread_;
};

}  // namespace nav::devices
