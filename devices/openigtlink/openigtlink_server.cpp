// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/openigtlink_server.hpp"

#include <array>
#include <cerrno>
#include <exception>
#include <sys/socket.h>

#include "devices/openigtlink/igtl_messages.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr const char* kServerReporter = "devices.openigtlink.server";
constexpr std::size_t kMostClients = 32;
/// Header versions that are sent: 1 and 2.
constexpr std::size_t kVersions = 2;
constexpr std::size_t kRoomForRequests = 4096;
/// Time between looks for clients that vanished, and before accept() is tried again after it
/// failed.
constexpr Duration kServerLook = std::chrono::milliseconds(250);

}  // namespace

Result<std::unique_ptr<OpenIgtLinkServer>> OpenIgtLinkServer::start(
    const OpenIgtLinkServerOptions& options, Diagnostics& diagnostics) {
  if (options.most_clients < 1 || options.most_clients > kMostClients) {
    return Error{ErrorCode::kUsage, "OpenIGTLink server: expected 1 to 32 clients, found " +
                                        std::to_string(options.most_clients)};
  }
  const auto address = resolve_tcp(options.address, options.port);
  if (!address) return address.error();
  auto listener = listen_tcp(*address);
  if (!listener) return listener.error();
  return std::unique_ptr<OpenIgtLinkServer>(
      new OpenIgtLinkServer(options, *std::move(listener), diagnostics));
}

OpenIgtLinkServer::OpenIgtLinkServer(const OpenIgtLinkServerOptions& options,
                                     FileDescriptor listener, Diagnostics& diagnostics)
    : options_(options),
      listener_(std::move(listener)),
      port_(bound_port(listener_)),
      diagnostics_(diagnostics),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void OpenIgtLinkServer::stop() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  wake_.signal();
  thread_.join();
}

/// The root of the thread: nothing leaves it but reports.
void OpenIgtLinkServer::run(const std::stop_token& stop) {
  try {
    serve(stop);
  } catch (const std::exception& error) {
    diagnostics_.report(Severity::kError, kServerReporter,
                        std::string("internal error: ") + error.what());
  }
  const std::lock_guard lock(mutex_);
  clients_.clear();
  listener_.close();
}

void OpenIgtLinkServer::serve(const std::stop_token& stop) {
  std::vector<Watched> watched;
  bool accepting = true;
  while (!stop.stop_requested()) {
    watched.assign({{.fd = wake_.get(), .read = true},
                    {.fd = accepting ? listener_.get() : -1, .read = true}});
    {
      const std::lock_guard lock(mutex_);
      for (const Client& client : clients_) {
        watched.push_back(
            {.fd = client.socket.get(), .read = true, .write = !client.waiting.empty()});
      }
    }
    wait_for(watched, clients_.empty() && accepting ? Duration::max() : kServerLook);
    if (watched[0].read) wake_.clear();
    std::size_t i = 2;
    for (Client& client : clients_) {
      if (watched[i].read) read(client);
      if (watched[i].write && !client.lost) write(client);
      if (peer_vanished(client.socket)) client.lost = true;
      ++i;
    }
    drop_lost();
    accepting = !watched[1].read || accept_one();
  }
}

/// Returns false when nobody can be accepted now, such as without a free descriptor.
bool OpenIgtLinkServer::accept_one() {
  FileDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!socket.is_open()) return errno == EAGAIN || errno == EINTR || errno == ECONNABORTED;
  if (clients_.size() >= options_.most_clients) {
    diagnostics_.report(Severity::kWarning, kServerReporter,
                        "a client was turned away: expected at most " +
                            std::to_string(options_.most_clients) + " clients");
    return true;
  }
  set_tcp_options(socket, TcpUnsent::kKeep);
  const std::lock_guard lock(mutex_);
  clients_.emplace_back().socket = std::move(socket);
  return true;
}

void OpenIgtLinkServer::read(Client& client) {
  const TcpTransfer got = receive_now(client.socket, client.parser.prepare(kRoomForRequests));
  if (got.failure) client.lost = true;
  if (got.bytes == 0) return;
  client.parser.commit(got.bytes);
  while (const auto request = client.parser.next()) {
    const std::lock_guard lock(mutex_);
    if (request->header.version > 1) client.account.version = 2;
    if (request->header.type_name() != "GET_STATUS") continue;
    std::vector<std::byte> content;
    append_igtl_status(content, {.code = 1});
    auto answer = std::make_shared<std::vector<std::byte>>();
    append_igtl_message(*answer, {.version = client.account.version, .type = "STATUS"}, content);
    queue(client, {std::move(answer), "STATUS"}, options_.most_waiting);
  }
}

/// Sends what the client takes now. The mutex is not held while the system copies.
void OpenIgtLinkServer::write(Client& client) {
  constexpr int kMostAtOnce = 64;  // Then it is another client's turn.
  for (int i = 0; i < kMostAtOnce; ++i) {
    Bytes first;
    {
      const std::lock_guard lock(mutex_);
      if (client.waiting.empty()) return;
      first = client.waiting.front().bytes;
    }
    const TcpTransfer moved = send_now(client.socket, std::span(*first).subspan(client.sent));
    if (moved.failure) client.lost = true;
    if (moved.bytes == 0) return;
    const std::lock_guard lock(mutex_);
    client.sent += moved.bytes;
    client.account.waiting -= moved.bytes;
    if (client.sent < first->size()) continue;
    client.waiting.pop_front();
    client.sent = 0;
    ++client.account.messages;
  }
}

void OpenIgtLinkServer::drop_lost() {
  const std::lock_guard lock(mutex_);
  clients_.remove_if([](const Client& client) { return client.lost; });
}

/// Appends a message. The first waiting one may have been sent in part, and is never given up.
void OpenIgtLinkServer::queue(Client& client, Waiting message, std::size_t most_waiting) {
  auto& waiting = client.waiting;
  client.account.waiting += message.bytes->size();
  const auto give_up = [&](auto one) {
    client.account.waiting -= one->bytes->size();
    ++client.account.superseded;
    return waiting.erase(one);
  };
  for (auto one = waiting.begin(); client.account.waiting > most_waiting && one != waiting.end();) {
    const bool same = one != waiting.begin() && one->key == message.key;
    one = same ? give_up(one) : one + 1;
  }
  while (client.account.waiting > most_waiting && waiting.size() > 1) give_up(waiting.begin() + 1);
  waiting.push_back(std::move(message));
}

void OpenIgtLinkServer::send(const IgtlEnvelope& envelope, std::span<const std::byte> content) {
  const auto encoded = [&](std::uint16_t version) {
    IgtlEnvelope sent = envelope;
    sent.version = version;
    auto bytes = std::make_shared<std::vector<std::byte>>();
    append_igtl_message(*bytes, sent, content);
    return bytes;
  };
  // The message is encoded, where a client wants it, before the clients are locked.
  std::array<Bytes, kVersions> by_version;
  for (const OpenIgtLinkClient& client : clients()) {
    Bytes& bytes = by_version[client.version - 1u];
    if (!bytes) bytes = encoded(client.version);
  }
  std::string key(envelope.type);
  key += ' ';
  key += envelope.device;
  {
    const std::lock_guard lock(mutex_);
    for (Client& client : clients_) {
      Bytes& bytes = by_version[client.account.version - 1u];
      if (!bytes) bytes = encoded(client.account.version);
      queue(client, {bytes, key}, options_.most_waiting);
    }
  }
  wake_.signal();
}

void OpenIgtLinkServer::send_raw(std::span<const std::byte> bytes) {
  const auto copy = std::make_shared<const std::vector<std::byte>>(bytes.begin(), bytes.end());
  {
    const std::lock_guard lock(mutex_);
    for (Client& client : clients_) queue(client, {copy, ""}, options_.most_waiting);
  }
  wake_.signal();
}

std::vector<OpenIgtLinkClient> OpenIgtLinkServer::clients() const {
  const std::lock_guard lock(mutex_);
  std::vector<OpenIgtLinkClient> all;
  for (const Client& client : clients_) all.push_back(client.account);
  return all;
}

}  // namespace nav::devices
