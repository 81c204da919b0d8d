// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/openigtlink_server.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <thread>

#include "devices/openigtlink/igtl_messages.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using test::Bytes;

/// Time that a test waits for something that is certain to happen.
constexpr auto kPatience = std::chrono::seconds(20);

bool wait_until(const std::function<bool()>& happened) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!happened()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// Client that reads only when the test says so.
class PlainClient {
 public:
  explicit PlainClient(std::uint16_t port) {
    const auto peer = resolve_tcp("127.0.0.1", port);
    auto socket = begin_tcp_connect(*peer);
    socket_ = *std::move(socket);
    Watched writable{.fd = socket_.get(), .write = true};
    wait_for(std::span(&writable, 1), kPatience);
    EXPECT_FALSE(finish_tcp_connect(socket_));
  }
  void send(const Bytes& bytes) const { EXPECT_EQ(send_now(socket_, bytes).bytes, bytes.size()); }
  /// The next message; absent when none comes in time or the connection has ended.
  std::optional<IgtlMessage> next() {
    for (;;) {
      if (auto message = parser_.next()) return message;
      Watched readable{.fd = socket_.get(), .read = true};
      wait_for(std::span(&readable, 1), kPatience);
      const TcpTransfer got = receive_now(socket_, parser_.prepare(65536));
      if (got.bytes == 0) return std::nullopt;
      parser_.commit(got.bytes);
    }
  }

 private:
  FileDescriptor socket_;
  IgtlParser parser_;
};

std::unique_ptr<OpenIgtLinkServer> server_with(Diagnostics& diagnostics,
                                               const OpenIgtLinkServerOptions& options = {}) {
  auto server = OpenIgtLinkServer::start(options, diagnostics);
  EXPECT_TRUE(test::has_value(server));
  return *std::move(server);
}

void send_pose(OpenIgtLinkServer& server, double x) {
  const IgtlMetadataEntry ok{.key = "TransformStatus", .value = "OK"};
  server.send({.type = "TRANSFORM",
               .device = "ProbeToTracker",
               .stamp = test::kStamp,
               .metadata = std::span(&ok, 1)},
              test::content_of(IgtlTransform::from(test::translation(x, 0, 0))));
}

TEST(OpenIgtLinkServerTest, SpeaksVersion1UntilTheClientSpeaksVersion2) {
  CollectingDiagnostics diagnostics;
  const auto server = server_with(diagnostics);
  PlainClient old_client(server->port());
  PlainClient new_client(server->port());
  ASSERT_TRUE(wait_until([&] { return server->clients().size() == 2; }));
  new_client.send(test::message({.version = 2, .type = "GET_STATUS"}, {}));
  const auto status = new_client.next();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->header.type_name(), "STATUS");
  send_pose(*server, 1);
  const auto plain = old_client.next();
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->header.version, 1);
  EXPECT_EQ(plain->metadata.size(), 0u);
  const auto rich = new_client.next();
  ASSERT_TRUE(rich);
  EXPECT_EQ(rich->header.version, 2);
  EXPECT_EQ(rich->metadata.find("TransformStatus"), "OK");
}

TEST(OpenIgtLinkServerTest, AStalledClientCostsTheOthersNothing) {
  CollectingDiagnostics diagnostics;
  const auto server = server_with(diagnostics, {.most_waiting = std::size_t{1} << 20});
  PlainClient stalled(server->port());
  std::vector<std::unique_ptr<PlainClient>> others;
  for (int i = 0; i < 8; ++i) others.push_back(std::make_unique<PlainClient>(server->port()));
  ASSERT_TRUE(wait_until([&] { return server->clients().size() == 9; }));
  const test::GreyImage grey(1000, 300);
  const Bytes content = grey.content();
  // Twelve times what may wait for one client, and more than the system buffers.
  constexpr int kImages = 40;
  for (int i = 0; i < kImages; ++i) {
    server->send({.type = "IMAGE", .device = "Image"}, content);
    send_pose(*server, i);
    for (const auto& other : others) {
      const auto image = other->next();
      ASSERT_TRUE(image);
      EXPECT_EQ(image->header.type_name(), "IMAGE");
      const auto pose = other->next();
      ASSERT_TRUE(pose);
      EXPECT_EQ(decode_igtl_transform(pose->content)->matrix()(0, 3), i);
    }
  }
  const auto accounts = server->clients();
  ASSERT_EQ(accounts.size(), 9u);
  EXPECT_GT(accounts[0].superseded, 0u);
  EXPECT_LE(accounts[0].waiting, 2 * (std::size_t{1} << 20));
  EXPECT_EQ(accounts[1].superseded, 0u);
  // The stalled client gets whole messages, and the newest last.
  send_pose(*server, -1);
  double newest = 0;
  while (newest != -1) {
    const auto message = stalled.next();
    ASSERT_TRUE(message);
    if (message->header.type_name() != "TRANSFORM") continue;
    newest = decode_igtl_transform(message->content)->matrix()(0, 3);
  }
}

TEST(OpenIgtLinkServerTest, TurnsAwayClientsBeyondTheLimitAndServesTheNextWhenOneLeaves) {
  CollectingDiagnostics diagnostics;
  const auto server = server_with(diagnostics, {.most_clients = 1});
  auto first = std::make_unique<PlainClient>(server->port());
  ASSERT_TRUE(wait_until([&] { return server->clients().size() == 1; }));
  PlainClient second(server->port());
  EXPECT_FALSE(second.next()) << "the connection ends";
  first.reset();
  ASSERT_TRUE(wait_until([&] { return server->clients().empty(); }));
  PlainClient third(server->port());
  ASSERT_TRUE(wait_until([&] { return server->clients().size() == 1; }));
  send_pose(*server, 3);
  EXPECT_TRUE(third.next());
}

TEST(OpenIgtLinkServerTest, StopsTwiceAndSaysWhyItCannotListen) {
  CollectingDiagnostics diagnostics;
  const auto server = server_with(diagnostics);
  EXPECT_TRUE(test::rejects(OpenIgtLinkServer::start({.port = server->port()}, diagnostics),
                            ErrorCode::kUnavailable,
                            {"127.0.0.1:" + std::to_string(server->port()), "cannot listen"}));
  EXPECT_TRUE(test::rejects(OpenIgtLinkServer::start({.most_clients = 33}, diagnostics),
                            ErrorCode::kUsage, {"1 to 32", "33"}));
  server->stop();
  server->stop();
  EXPECT_TRUE(server->clients().empty());
}

}  // namespace
}  // namespace nav::devices
