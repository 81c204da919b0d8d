// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/openigtlink/igtl_header.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/diagnostics.hpp"

namespace nav::devices {

struct OpenIgtLinkServerOptions {
  /// Address to listen at. The default can be reached from this machine only.
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;         ///< 0: the system chooses one.
  std::size_t most_clients = 16;  ///< 1 to 32; more are turned away.
  /// Bytes that wait for one client; more supersede what is older.
  std::size_t most_waiting = std::size_t{8} << 20;
};

/// Account of one client that is connected.
struct OpenIgtLinkClient {
  std::uint16_t version = 1;     ///< Header version that it is sent.
  std::uint64_t messages = 0;    ///< Handed to the system whole.
  std::uint64_t superseded = 0;  ///< Given up for newer ones because the client was slow.
  std::size_t waiting = 0;       ///< Bytes.
};

/// Sends messages to all its clients. A client gets header version 1 without metadata until it has
/// sent a header of version 2 or higher, as from PLUS. A client that is slow loses older messages
/// of the same type and device first, then the oldest, and costs the others nothing; one that
/// vanished is dropped in two seconds. GET_STATUS is answered; other messages are read and ignored.
/// One thread of its own; the public functions are thread-safe.
class OpenIgtLinkServer {
 public:
  /// Listens, and starts the thread. \p diagnostics must outlive the server. kUnavailable when the
  /// address cannot be had, kUsage for a number of clients out of range.
  static Result<std::unique_ptr<OpenIgtLinkServer>> start(const OpenIgtLinkServerOptions& options,
                                                          Diagnostics& diagnostics);
  ~OpenIgtLinkServer() { stop(); }
  OpenIgtLinkServer(const OpenIgtLinkServer&) = delete;
  OpenIgtLinkServer& operator=(const OpenIgtLinkServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Queues a message for every client; never waits for one. The version of the envelope is not
  /// used.
  void send(const IgtlEnvelope& envelope, std::span<const std::byte> content);
  /// Queues bytes as they are for every client: for tests of what a broken peer sends.
  void send_raw(std::span<const std::byte> bytes);
  [[nodiscard]] std::vector<OpenIgtLinkClient> clients() const;
  /// Disconnects all clients and joins the thread. Idempotent.
  void stop() noexcept;

 private:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  struct Waiting {
    Bytes bytes;
    std::string key;  ///< Type and device; a newer message of the same key supersedes.
  };
  struct Client {
    FileDescriptor socket;
    IgtlParser parser{{.largest_body = 1 << 20}};
    std::deque<Waiting> waiting;
    std::size_t sent = 0;  ///< Bytes of the first waiting message that are sent.
    OpenIgtLinkClient account;
    bool lost = false;
  };
  OpenIgtLinkServer(const OpenIgtLinkServerOptions& options, FileDescriptor listener,
                    Diagnostics& diagnostics);

  void run(const std::stop_token& stop);
  void serve(const std::stop_token& stop);
  bool accept_one();
  void read(Client& client);
  void write(Client& client);
  void drop_lost();
  static void queue(Client& client, Waiting message, std::size_t most_waiting);

  OpenIgtLinkServerOptions options_;
  FileDescriptor listener_;
  std::uint16_t port_;
  Diagnostics& diagnostics_;
  WakeEvent wake_;
  mutable std::mutex mutex_;   ///< Guards queues and accounts.
  std::list<Client> clients_;  ///< Only the thread adds, removes and uses sockets.
  std::jthread thread_;
};

}  // namespace nav::devices
