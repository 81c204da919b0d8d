// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/openigtlink_source.hpp"

#include <algorithm>
#include <ctime>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <thread>

#include "devices/openigtlink/openigtlink_sender.hpp"
#include "devices/openigtlink/openigtlink_server.hpp"
#include "session/session.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Bytes;

constexpr Duration kCertain = seconds(20);  ///< Wait for what is certain to happen.

struct Peer {
  CollectingDiagnostics diagnostics;
  std::unique_ptr<OpenIgtLinkServer> server = *OpenIgtLinkServer::start({}, diagnostics);

  [[nodiscard]] bool wait_for_clients(std::size_t count) const {
    for (int i = 0; i < 10'000; ++i) {
      if (server->clients().size() == count) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }
  /// Waits until the client has asked for version 2.
  [[nodiscard]] bool wait_for_version_2() const {
    for (int i = 0; i < 10'000; ++i) {
      const auto clients = server->clients();
      if (!clients.empty() && clients[0].version == 2) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }
  void send(std::string_view device, const Eigen::Matrix4d& matrix, std::string_view status,
            DeviceTime time) const {
    const IgtlMetadataEntry entry{.key = "TransformStatus", .value = status};
    server->send({.type = "TRANSFORM",
                  .device = device,
                  .stamp = igtl_stamp(time),
                  .metadata = std::span(&entry, status.empty() ? 0u : 1u)},
                 test::content_of(IgtlTransform::from(matrix)));
  }
};

OpenIgtLinkOptions options_for(std::uint16_t port) {
  OpenIgtLinkOptions options;
  options.port = port;
  options.streams = {{"ProbeToTracker", StreamKind::kPoses, ToolRole::kProbe},
                     {"ReferenceToTracker", StreamKind::kPoses, ToolRole::kReference},
                     {"Image", StreamKind::kImages, ToolRole::kOther}};
  options.first_retry = milliseconds(20);
  options.longest_retry = milliseconds(50);
  return options;
}

struct Client {
  explicit Client(const OpenIgtLinkOptions& options)
      : source(*OpenIgtLinkSource::create(options, clock, diagnostics)) {}
  explicit Client(std::uint16_t port) : Client(options_for(port)) {}

  /// Calls next() until the connection stands.
  void connect(const Peer& peer) {
    const auto before = source->account().connections;
    const Timestamp end = clock.now() + kCertain;
    while (source->account().connections == before && clock.now() < end) {
      const auto nothing = source->next(clock.now() + milliseconds(5));
      EXPECT_FALSE(nothing);
    }
    EXPECT_TRUE(peer.wait_for_version_2());
  }
  Result<Sample> next() { return source->next(clock.now() + kCertain); }
  [[nodiscard]] bool reported(const std::string& piece) const {
    for (const auto& entry : diagnostics.entries()) {
      if (entry.message.find(piece) != std::string::npos) return true;
    }
    return false;
  }

  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  std::unique_ptr<OpenIgtLinkSource> source;
};

const DeviceTime kDeviceTime{seconds(1'700'000'000)};

double processor_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(OpenIgtLinkSourceTest, GivesPosesWithTheStatusAndTimeOfTheSender) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  peer.send("ProbeToTracker", test::translation(1, 2, 3), "OK", kDeviceTime);
  peer.send("ReferenceToTracker", test::translation(4, 5, 6), "OUT_OF_VIEW", kDeviceTime);
  peer.send("ProbeToTracker", test::translation(7, 8, 9), "", DeviceTime{});

  const auto probe = client.next();
  ASSERT_TRUE(test::has_value(probe));
  EXPECT_EQ(probe->stream, 0u);
  EXPECT_EQ(probe->sequence, 0u);
  EXPECT_EQ(probe->device_time, kDeviceTime);
  EXPECT_LE(probe->received, client.clock.now());
  const auto& pose = std::get<PoseSample>(probe->what).pose;
  EXPECT_EQ(pose.status, TrackingStatus::kOk);
  EXPECT_EQ(pose.received, probe->received);
  EXPECT_EQ(pose.tracker_from_body, test::translation(1, 2, 3));

  const auto reference = client.next();
  ASSERT_TRUE(test::has_value(reference));
  EXPECT_EQ(reference->stream, 1u);
  EXPECT_EQ(std::get<PoseSample>(reference->what).pose.status, TrackingStatus::kOccluded);

  const auto plain = client.next();
  ASSERT_TRUE(test::has_value(plain));
  EXPECT_EQ(plain->sequence, 1u);
  EXPECT_EQ(plain->device_time, std::nullopt) << "a stamp of 0 is none";
  EXPECT_EQ(std::get<PoseSample>(plain->what).pose.status, TrackingStatus::kUnknown)
      << "no status is never OK";
}

TEST(OpenIgtLinkSourceTest, GivesEveryToolOfOneMessage) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  IgtlTrackingElement probe{.name = "ProbeToTracker", .pose = {}};
  probe.pose = IgtlTransform::from(test::translation(1, 0, 0));
  IgtlTrackingElement reference{.name = "ReferenceToTracker", .pose = {}};
  const IgtlMetadataEntry status{.key = "ProbeToTrackerStatus", .value = "OK"};
  const Bytes tools = test::operator+(test::content_of(probe), test::content_of(reference));
  peer.server->send({.type = "TDATA", .device = "Tracker", .metadata = std::span(&status, 1)},
                    tools);
  const auto first = client.next();
  ASSERT_TRUE(test::has_value(first));
  EXPECT_EQ(first->stream, 0u);
  EXPECT_EQ(std::get<PoseSample>(first->what).pose.status, TrackingStatus::kOk);
  const auto second = client.next();
  ASSERT_TRUE(test::has_value(second));
  EXPECT_EQ(second->stream, 1u);
  EXPECT_EQ(std::get<PoseSample>(second->what).pose.status, TrackingStatus::kUnknown);
}

TEST(OpenIgtLinkSourceTest, GivesGreyImagesAndNamesTheOthers) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  test::GreyImage grey(31, 17);
  peer.server->send({.type = "IMAGE", .device = "Image"}, grey.content());
  const auto sample = client.next();
  ASSERT_TRUE(test::has_value(sample));
  EXPECT_EQ(sample->stream, 2u);
  const auto& image = std::get<UltrasoundImage>(sample->what);
  EXPECT_EQ(image.pixels.width(), 31);
  EXPECT_EQ(image.pixels.height(), 17);
  EXPECT_EQ(image.pixels.at(30, 16), std::to_integer<std::uint8_t>(grey.pixels.back()));
  constexpr double kSingleMm = 1e-6;
  EXPECT_NEAR(image.grid.at(0, 0).mm.x(), -3, kSingleMm);
  EXPECT_NEAR(image.grid.at(30, 16).mm.x(), 3, kSingleMm);
  EXPECT_NEAR(image.grid.at(30, 16).mm.y(), 4.8, kSingleMm);

  const auto expect_missing = [&](const char* cause) {
    const auto missing = client.next();
    ASSERT_TRUE(test::has_value(missing));
    EXPECT_EQ(std::get<MissingImage>(missing->what).cause, cause);
  };
  peer.server->send({.type = "IMAGE", .device = "Image"}, {});
  expect_missing("empty_image");
  grey.image.steps_mm[0] = {0, 0, 0};
  peer.server->send({.type = "IMAGE", .device = "Image"}, grey.content());
  expect_missing("malformed_image");
  grey.image.steps_mm[0] = {1000, 0, 0};
  peer.server->send({.type = "IMAGE", .device = "Image"}, grey.content());
  expect_missing("invalid_pixel_grid");
  const Bytes wide(std::size_t{31 * 17 * 4});
  grey.image.scalar = IgtlScalar::kFloat32;
  grey.image.pixels = wide;
  peer.server->send({.type = "IMAGE", .device = "Image"}, grey.content());
  expect_missing("unsupported_image_type");
  EXPECT_TRUE(client.reported("spacing of columns"));
}

TEST(OpenIgtLinkSourceTest, GivesRgbImagesInTheirColours) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  // Red, green, blue / cyan, magenta, grey: no flip and no other order of the channels is the same.
  const std::vector<Rgb8> colours{{255, 0, 0},   {0, 255, 0},   {0, 0, 255},
                                  {0, 200, 200}, {200, 0, 200}, {50, 50, 50}};
  test::GreyImage sent(3, 2);
  sent.image.components = 3;
  sent.image.pixels = std::as_bytes(std::span(colours));
  peer.server->send({.type = "IMAGE", .device = "Image"}, sent.content());
  const auto sample = client.next();
  ASSERT_TRUE(test::has_value(sample));
  const auto& image = std::get<UltrasoundImage>(sample->what);
  ASSERT_EQ(image.colours.width(), 3);
  ASSERT_EQ(image.colours.height(), 2);
  EXPECT_TRUE(std::ranges::equal(image.colours.pixels(), colours));
  EXPECT_TRUE(std::ranges::equal(image.pixels.pixels(), luma(image.colours).pixels()));

  const OpenIgtLinkSender sender(*peer.server, "Tracker", DeviceTime());
  sender.send({"Image", StreamKind::kImages}, *sample);
  const auto again = client.next();
  ASSERT_TRUE(test::has_value(again));
  EXPECT_TRUE(std::ranges::equal(std::get<UltrasoundImage>(again->what).colours.pixels(), colours))
      << "as Sonde sends it";
}

TEST(OpenIgtLinkSourceTest, SaysOnceHowSixteenBitsBecomeEight) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  test::GreyImage sent(3, 2);
  Bytes wide(std::size_t{3 * 2 * 2});
  sent.image.scalar = IgtlScalar::kUint16;
  sent.image.pixels = wide;
  const auto largest = [&](int value) {
    wide[0] = static_cast<std::byte>(value & 255);
    wide[1] = static_cast<std::byte>(value >> 8);
    peer.server->send({.type = "IMAGE", .device = "Image"}, sent.content());
    const auto sample = client.next();
    ASSERT_TRUE(test::has_value(sample));
    EXPECT_EQ(std::get<UltrasoundImage>(sample->what).pixels.at(0, 0), 255);
  };
  largest(1023);
  EXPECT_TRUE(client.reported("0 to 1023 become 0 to 255"));
  EXPECT_FALSE(client.reported("drawn white"));
  largest(5000);
  EXPECT_TRUE(client.reported("expected samples up to 1023, found 5000"));
}

TEST(OpenIgtLinkSourceTest, NamesWhatNoStreamDeclares) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  peer.send("Stylus\x1bToTracker", test::translation(0, 0, 0), "OK", kDeviceTime);
  peer.server->send({.type = "NDARRAY", .device = "A"}, Bytes(5));
  peer.send("ProbeToTracker", test::translation(0, 0, 0), "OK", kDeviceTime);
  ASSERT_TRUE(test::has_value(client.next()));
  const auto health = client.source->account();
  EXPECT_EQ(health.undeclared.at("TRANSFORM Stylus\\x1bToTracker"), 1u);
  EXPECT_EQ(health.skipped.at("NDARRAY"), 1u);
  EXPECT_TRUE(client.reported("Stylus\\x1bToTracker, which no stream declares"));
}

TEST(OpenIgtLinkSourceTest, BrokenBytesCostOnlyTheBrokenMessage) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  Bytes broken = test::transform_message("ProbeToTracker", test::translation(0, 0, 0));
  broken[80] ^= std::byte{1};
  peer.server->send_raw(broken);
  peer.server->send_raw(test::text_bytes("noise"));
  peer.send("ProbeToTracker", test::translation(1, 0, 0), "OK", kDeviceTime);
  const auto sample = client.next();
  ASSERT_TRUE(test::has_value(sample));
  EXPECT_EQ(std::get<PoseSample>(sample->what).pose.tracker_from_body(0, 3), 1);
  EXPECT_EQ(client.source->account().stream.of(IgtlFault::kCrc), 1u);
  EXPECT_TRUE(client.reported("crc"));
}

TEST(OpenIgtLinkSourceTest, ReconnectsWhenTheServerComesBack) {
  Peer peer;
  const std::uint16_t port = peer.server->port();
  Client client(port);
  client.connect(peer);
  peer.send("ProbeToTracker", test::translation(1, 0, 0), "OK", kDeviceTime);
  ASSERT_TRUE(test::has_value(client.next()));
  peer.server->stop();
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(test::rejects(client.source->next(client.clock.now() + milliseconds(10)),
                              ErrorCode::kTimeout, {std::to_string(port)}));
  }
  EXPECT_EQ(client.source->account().losses.at("closed"), 1u);
  EXPECT_GE(client.source->account().losses.at("no_listener"), 1u);
  EXPECT_TRUE(client.reported("the peer closed the connection; trying again in 0.02 s"));

  peer.server = *OpenIgtLinkServer::start({.port = port}, peer.diagnostics);
  client.connect(peer);
  peer.send("ProbeToTracker", test::translation(2, 0, 0), "OK", kDeviceTime);
  const auto sample = client.next();
  ASSERT_TRUE(test::has_value(sample));
  EXPECT_EQ(sample->stream, 0u);
  EXPECT_EQ(sample->sequence, 1u) << "the stream goes on";
  EXPECT_EQ(client.source->account().connections, 2u);
}

TEST(OpenIgtLinkSourceTest, ReportsSilenceAndTheNextBytes) {
  const Peer peer;
  auto options = options_for(peer.server->port());
  options.silence = milliseconds(30);
  Client client(options);
  client.connect(peer);
  EXPECT_TRUE(test::rejects(client.source->next(client.clock.now() + milliseconds(200)),
                            ErrorCode::kTimeout, {"deadline"}));
  EXPECT_EQ(client.source->account().state, OpenIgtLinkState::kSilent);
  EXPECT_TRUE(client.reported("nothing has come for 0.03 s"));
  peer.send("ProbeToTracker", test::translation(1, 0, 0), "OK", kDeviceTime);
  ASSERT_TRUE(test::has_value(client.next()));
  EXPECT_EQ(client.source->account().state, OpenIgtLinkState::kConnected);
}

TEST(OpenIgtLinkSourceTest, WaitsWithoutWorkWhileNothingComes) {
  Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  const auto used_in_half_a_second = [&] {
    const double before = processor_seconds();
    const Timestamp end = client.clock.now() + milliseconds(500);
    while (client.clock.now() < end)
      (void)client.source->next(client.clock.now() + milliseconds(50));
    return processor_seconds() - before;
  };
  // A fifth of a core, which a loop that never waits exceeds several times: what a busy machine and
  // a sanitizer add stays below it.
  constexpr double kIdleSeconds = 0.1;
  EXPECT_LT(used_in_half_a_second(), kIdleSeconds) << "connected";
  peer.server->stop();
  EXPECT_LT(used_in_half_a_second(), kIdleSeconds) << "without a server";
}

TEST(OpenIgtLinkSourceTest, StopEndsAWaitingCallAtOnce) {
  const Peer peer;
  Client client(peer.server->port());
  client.connect(peer);
  std::atomic<bool> ended{false};
  std::thread waiting([&] {
    EXPECT_TRUE(test::rejects(client.source->next(Timestamp::max()), ErrorCode::kCancelled, {}));
    ended = true;
  });
  std::this_thread::sleep_for(milliseconds(20));
  const Timestamp before = client.clock.now();
  client.source->stop();
  waiting.join();
  EXPECT_LT(client.clock.now() - before, milliseconds(200));
  EXPECT_TRUE(ended);
  client.source->stop();
  EXPECT_TRUE(test::rejects(client.next(), ErrorCode::kCancelled, {}));
  EXPECT_EQ(client.source->account().state, OpenIgtLinkState::kStopped);
}

TEST(OpenIgtLinkSourceTest, AHundredStopsFromAnotherThread) {
  const Peer peer;
  for (int i = 0; i < 100; ++i) {
    Client client(peer.server->port());
    std::thread waiting([&] {
      while (client.source->next(client.clock.now() + milliseconds(i % 3)) ||
             client.source->account().state != OpenIgtLinkState::kStopped) {
      }
    });
    client.source->stop();
    waiting.join();
  }
}

/// Ends a connection without telling the peer, as when its machine loses power. Needs rights that
/// only root has.
bool vanish(FileDescriptor& socket) {
  const int on = 1;
  if (::setsockopt(socket.get(), IPPROTO_TCP, TCP_REPAIR, &on, sizeof on) != 0) return false;
  socket.close();
  return true;
}

TEST(OpenIgtLinkSourceTest, FindsAPeerThatVanishedInTwoSeconds) {
  auto listener = listen_tcp(*resolve_tcp("127.0.0.1", 0));
  ASSERT_TRUE(test::has_value(listener));
  Client client(bound_port(*listener));
  ASSERT_FALSE(client.source->next(client.clock.now() + milliseconds(200)));
  ASSERT_EQ(client.source->account().connections, 1u);
  FileDescriptor accepted(::accept(listener->get(), nullptr, nullptr));
  ASSERT_TRUE(accepted.is_open());
  if (!vanish(accepted)) GTEST_SKIP() << "no right to end a connection silently";
  listener->close();
  const Timestamp before = client.clock.now();
  while (client.source->account().losses.empty() && client.clock.now() - before < seconds(10)) {
    (void)client.source->next(client.clock.now() + milliseconds(20));
  }
  constexpr Duration kBusyMachine = milliseconds(500);
  EXPECT_LT(client.clock.now() - before, seconds(2) + kBusyMachine);
  EXPECT_FALSE(client.source->account().losses.empty());
}

TEST(OpenIgtLinkSourceTest, AsksThePeerForASignOfLife) {
  auto listener = listen_tcp(*resolve_tcp("127.0.0.1", 0));
  const auto socket = begin_tcp_connect(*resolve_tcp("127.0.0.1", bound_port(*listener)));
  ASSERT_TRUE(test::has_value(socket));
  const auto option = [&](int level, int name) {
    int value = -1;
    socklen_t length = sizeof value;
    EXPECT_EQ(::getsockopt(socket->get(), level, name, &value, &length), 0);
    return value;
  };
  EXPECT_EQ(option(SOL_SOCKET, SO_KEEPALIVE), 1);
  EXPECT_LE(option(IPPROTO_TCP, TCP_KEEPIDLE) +
                option(IPPROTO_TCP, TCP_KEEPINTVL) * option(IPPROTO_TCP, TCP_KEEPCNT),
            2);
  EXPECT_LE(option(IPPROTO_TCP, TCP_USER_TIMEOUT), 2000);
  EXPECT_EQ(option(IPPROTO_TCP, TCP_NODELAY), 1);
}

TEST(OpenIgtLinkSourceTest, RejectsOptionsByName) {
  MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  const auto create = [&](const OpenIgtLinkOptions& options) {
    return OpenIgtLinkSource::create(options, clock, diagnostics);
  };
  OpenIgtLinkOptions options = options_for(18944);
  options.streams.clear();
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUsage, {"stream", "none"}));
  options.streams = {{"StylusTipToReferenceFrame", StreamKind::kPoses, ToolRole::kStylus},
                     {"StylusTipToReference", StreamKind::kPoses, ToolRole::kNeedle}};
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUsage, {"first 20", "StylusTipToRef"}));
  options.streams[1].kind = StreamKind::kImages;
  EXPECT_TRUE(test::has_value(create(options)));
  options.port = 0;
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUsage, {"port"}));
  options = options_for(1);
  options.silence = Duration(0);
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUsage, {"times", "0 s"}));
  options = options_for(1);
  options.longest_retry = milliseconds(1);
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUsage, {"longest retry"}));
  options = options_for(1);
  options.host = "256.1.1.1.nowhere.invalid";
  EXPECT_TRUE(test::rejects(create(options), ErrorCode::kUnavailable, {"nowhere.invalid"}));
  EXPECT_EQ(plus_transform_name("Probe", "Tracker"), "ProbeToTracker");
}

TEST(OpenIgtLinkSourceTest, FeedsALiveSessionWithPairedImages) {
  const Peer peer;
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  session::SessionSetup setup{ProbeCalibration{Transform<frames::Probe, frames::Image>(
      Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero())}};
  setup.images = session::QueuePolicy::kLossless;
  setup.learn_outline = false;
  session::Session session(setup, diagnostics);
  session.add(*OpenIgtLinkSource::create(options_for(peer.server->port()), clock, diagnostics));
  session.start(clock);
  ASSERT_TRUE(peer.wait_for_version_2());

  std::size_t paired = 0;
  double depth_mm = 0;
  const test::GreyImage grey(31, 17);
  const Bytes content = grey.content();
  const Timestamp begin = clock.now();
  const auto listener = [&](const tracking::PairedImage& frame) {
    if (!frame.tracked) return;
    ++paired;
    depth_mm = frame.tracked->frame.grid.at(0, 16).mm.y();
  };
  for (int i = 0; paired < 10 && clock.now() - begin < kCertain; ++i) {
    const DeviceTime now = kDeviceTime + (clock.now() - begin);
    // The probe moves a little: a pose that stays the same to the last digit is not believed.
    peer.send("ProbeToTracker", test::translation(0.01 * i, 0, 100), "OK", now);
    peer.send("ReferenceToTracker", test::translation(0, 0.01 * (i % 2), 0), "OK", now);
    if (i % 2 == 1) {
      peer.server->send({.type = "IMAGE", .device = "Image", .stamp = igtl_stamp(now)}, content);
    }
    std::this_thread::sleep_for(milliseconds(10));
    session.take_in(listener);
  }
  EXPECT_GE(paired, 10u);
  constexpr double kSingleMm = 1e-6;
  EXPECT_NEAR(depth_mm, 4.8, kSingleMm);
  ASSERT_NE(session.clock(0), nullptr) << "the sender's stamps reach the clock model";
  session.finish();
  session.navigator().finish();
  for (const auto& account : session.accounts()) {
    EXPECT_TRUE(account.ledger.balanced()) << account.info.name;
  }
  EXPECT_TRUE(session.failures().empty());
}

}  // namespace
}  // namespace nav::devices
