// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "devices/openigtlink/igtl_parser.hpp"
#include "devices/openigtlink/tcp_socket.hpp"
#include "devices/polled_source.hpp"
#include "nav/grey_scale.hpp"

namespace nav::devices {

/// One stream that is expected from the peer.
struct OpenIgtLinkStream {
  /// Name on the wire: device name of IMAGE, TRANSFORM and POSITION, tool name in TDATA and QTDATA.
  /// The wire holds 20 bytes; a longer name is compared by its first 20, as PLUS cuts it.
  std::string device;
  StreamKind kind = StreamKind::kPoses;
  ToolRole role = ToolRole::kOther;  ///< Poses only.
};
/// Name that PLUS gives a transform: "ProbeToTracker" is tracker_from_probe.
std::string plus_transform_name(std::string_view from, std::string_view to);

struct OpenIgtLinkOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 18944;
  std::vector<OpenIgtLinkStream> streams;
  Duration connect_timeout = std::chrono::seconds(2);  ///< > 0.
  Duration first_retry = std::chrono::seconds(1);      ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);    ///< >= first_retry.
  /// Time without any bytes after which a connection is reported as silent, > 0.
  Duration silence = std::chrono::milliseconds(500);
  /// Asks for the status (GET_STATUS) with header version 2 when a connection begins: PLUS then
  /// sends the tracking status with each pose. Libraries that know version 1 only, such as
  /// Debian's, cannot read it: false for their servers.
  bool announce_version_2 = true;
  /// Asks for TDATA with this period (STT_TDATA), where a server sends it only on request.
  std::optional<std::uint32_t> request_tdata_ms = std::nullopt;
  IgtlParserOptions parser;
};
/// Rejects no streams, empty names, names that are the same on the wire, port 0 and times out of
/// range.
Result<void> validate(const OpenIgtLinkOptions& options);

enum class OpenIgtLinkState { kWaiting, kConnecting, kConnected, kSilent, kStopped };
/// Stable lower-case name, for reports.
const char* to_string(OpenIgtLinkState state);

/// Account of a source.
struct OpenIgtLinkHealth {
  OpenIgtLinkState state = OpenIgtLinkState::kWaiting;
  std::string cause;              ///< Cause of the newest loss; empty: none yet.
  std::uint64_t connections = 0;  ///< That began.
  std::uint64_t silences = 0;
  using Counts = std::map<std::string, std::uint64_t, std::less<>>;
  Counts losses;            ///< Connections and attempts that failed, by cause.
  IgtlStreamCounts stream;  ///< Bytes, messages and broken messages.
  Counts rejected;          ///< Intact messages whose content was rejected, by type.
  Counts skipped;           ///< Intact messages of types that give no samples; at most 64.
  Counts undeclared;        ///< Messages for no declared stream: "TYPE name"; at most 64.
  std::vector<std::uint64_t> samples;  ///< Count for each stream.
};

/// Client of an OpenIGTLink server, such as PLUS or 3D Slicer. It connects in next() and has no
/// thread of its own: call next() from a thread that does nothing else. A connection that is lost
/// is not the end of the streams: it is tried again after 1, 2, 4 and then every 5 s, and next()
/// returns kTimeout meanwhile. Samples:
///   - poses from TRANSFORM, POSITION, TDATA and QTDATA, with the status of the metadata, kUnknown
///     without;
///   - images from IMAGE: one slice of grey, RGB or RGBA values of 8 or 16 bits (set_pixels()).
///     Others are MissingImage.
/// Sample::device_time is the header's time stamp, ns since 1970; absent when the sender gives
/// none. The times `acquired` are those of reception until a clock model has mapped the device
/// time.
class OpenIgtLinkSource final : public PolledSource {
 public:
  /// Finds the address of the host, which may wait for the name service. \p clock advances with
  /// real time; clock and diagnostics must outlive the source. Errors: those of validate(), and
  /// kUnavailable for an unknown host.
  static Result<std::unique_ptr<OpenIgtLinkSource>> create(OpenIgtLinkOptions options,
                                                           const Clock& clock,
                                                           Diagnostics& diagnostics);

  /// Thread-safe.
  [[nodiscard]] OpenIgtLinkHealth account() const;
  [[nodiscard]] SourceHealth health() const override;

 private:
  OpenIgtLinkSource(OpenIgtLinkOptions options, TcpEndpoint peer, const Clock& clock,
                    Diagnostics& diagnostics);

  [[nodiscard]] std::string name() const override { return peer_.text; }
  [[nodiscard]] Timestamp wake_time() const override;
  void advance(Timestamp now) override;
  [[nodiscard]] Watched watched() const override;
  void attend(bool readable, bool writable) override;
  void close() noexcept override { socket_.close(); }
  void connected(Timestamp now);
  void receive();
  void lose(const TcpFailure& failure);
  void read_messages(Timestamp received);
  void take_message(const IgtlMessage& message, Timestamp received);
  void take_pose(std::string_view device, const Eigen::Matrix4d& matrix, TrackingStatus status,
                 const IgtlMessage& message, Timestamp received);
  void take_tools(const IgtlMessage& message, Timestamp received);
  void take_image(const IgtlMessage& message, Timestamp received);
  void add(std::size_t stream, const IgtlMessage& message, Timestamp received,
           decltype(Sample::what) what);
  /// Says how 16-bit samples become 8 bits, when it is decided and when they exceed it.
  void say_scale(const std::string& image, const GreyScale& before, const GreyScale& now);
  void reject(const IgtlMessage& message, const std::string& why);
  void report_faults();
  [[nodiscard]] std::optional<std::size_t> stream_of(std::string_view device,
                                                     StreamKind kind) const;
  void note_undeclared(std::string_view device, const IgtlMessage& message);

  OpenIgtLinkOptions options_;
  TcpEndpoint peer_;

  // Used by next() only.
  FileDescriptor socket_;
  IgtlParser parser_;
  Timestamp due_{};    ///< Time of the next attempt, or the end of the one that runs.
  Timestamp heard_{};  ///< Newest bytes.
  RetryTimes retry_;
  std::string reported_loss_;
  IgtlStreamCounts reported_faults_;
  std::vector<GreyScale> scales_;  ///< One for each stream; used for images of 16 bits.

  mutable std::mutex mutex_;  ///< Guards the health; never held while calling out.
  OpenIgtLinkHealth health_;
};

}  // namespace nav::devices
