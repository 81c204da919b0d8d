// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usbip_link.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <deque>
#include <map>

#include "devices/usb/usbip_protocol.hpp"

namespace nav::devices {
namespace {

/// More devices than any server exports.
constexpr std::uint32_t kMostUsbipDevices = 128;

UsbEnd end_of_status(std::int32_t status) {
  switch (-status) {
    case 0:
    case EREMOTEIO:  // A short packet.
      return UsbEnd::kDone;
    case EPIPE:
      return UsbEnd::kStall;
    case EOVERFLOW:
      return UsbEnd::kOverflow;
    case ETIMEDOUT:
      return UsbEnd::kTimeout;
    case ENODEV:
    case ESHUTDOWN:
      return UsbEnd::kGone;
    default:
      return UsbEnd::kError;
  }
}

class UsbipLink final : public UsbLink {
 public:
  UsbipLink(TcpEndpoint server, UsbId id, FileDescriptor socket)
      : server_(std::move(server)), id_(std::move(id)), socket_(std::move(socket)) {}
  ~UsbipLink() override;

  [[nodiscard]] bool is_open() const override { return state_ == State::kOpen; }
  [[nodiscard]] Watched watched() const override {
    return {.fd = socket_.get(),
            .read = state_ != State::kListing && state_ != State::kImporting,
            .write = state_ == State::kListing || state_ == State::kImporting || !unsent_.empty()};
  }
  void attend() override;
  void keep_reading(std::uint8_t endpoint, std::size_t bytes, int queued) override;
  void write(std::uint8_t endpoint, std::vector<std::byte> bytes) override;
  void control(const UsbSetup& setup, std::vector<std::byte> bytes) override;
  std::optional<UsbTransfer> take() override;
  void drain(Duration longest) override;
  [[nodiscard]] std::optional<TcpFailure> failure() const override { return failure_; }

 private:
  enum class State {
    kListing,  ///< Connects to ask for the list.
    kListed,   ///< Waits for the list.
    kImporting,
    kImported,  ///< Waits for the answer to the import.
    kOpen,
    kGone,
  };
  /// A transfer that the server has.
  struct Pending {
    std::uint8_t endpoint = 0;
    std::uint32_t bytes = 0;
    bool receives = false;
    bool reads_again = false;
    bool clears_halt = false;
  };
  void fail(TcpFailure why);
  void flush();
  void receive();
  bool parse();
  bool parse_list();
  bool parse_import();
  bool parse_answer();
  void take_answer(const UsbipHeader& header, std::span<const std::byte> bytes);
  void submit(const Pending& pending, const std::array<std::uint8_t, 8>& setup,
              std::span<const std::byte> bytes);
  void take_unlinked(const UsbipHeader& header);
  void begin_halt(std::uint8_t endpoint);
  void clear_halts();
  void queue(std::span<const std::byte> bytes);
  void consume(std::size_t bytes);

  TcpEndpoint server_;
  UsbId id_;
  FileDescriptor socket_;
  State state_ = State::kListing;
  UsbipDevice device_;
  std::vector<std::byte> received_;
  std::vector<std::byte> unsent_;   ///< For the connection that stands.
  std::vector<std::byte> waiting_;  ///< Transfers that wait for the import.
  std::uint32_t number_ = 0;
  std::map<std::uint32_t, Pending> pending_;
  std::map<std::uint32_t, std::uint32_t> unlinks_;  ///< Transfer that each unlink takes back.
  std::map<std::uint8_t, int> halted_;              ///< Endpoints with the reads to queue again.
  std::map<std::uint8_t, std::uint32_t> sizes_;
  std::deque<UsbTransfer> taken_;
  std::optional<TcpFailure> failure_;
};

UsbipLink::~UsbipLink() {
  if (state_ != State::kOpen) return;
  // The server ends what is under way when the connection closes; this only tells it so.
  for (const auto& [number, pending] : pending_) {
    std::vector<std::byte> bytes;
    append_usbip_header(bytes, {.command = static_cast<std::uint32_t>(UsbipCommand::kUnlink),
                                .number = ++number_,
                                .unlinked = number});
    queue(bytes);
  }
  flush();
}

void UsbipLink::fail(TcpFailure why) {
  if (state_ == State::kGone) return;
  state_ = State::kGone;
  failure_ = std::move(why);
  pending_.clear();
  socket_.close();
  taken_.push_back({.end = UsbEnd::kGone});
}

void UsbipLink::queue(std::span<const std::byte> bytes) {
  auto& into = state_ == State::kOpen ? unsent_ : waiting_;
  into.insert(into.end(), bytes.begin(), bytes.end());
}

void UsbipLink::submit(const Pending& pending, const std::array<std::uint8_t, 8>& setup,
                       std::span<const std::byte> bytes) {
  if (state_ == State::kGone) return;
  const std::uint32_t number = ++number_;
  pending_.emplace(number, pending);
  std::vector<std::byte> message;
  append_usbip_header(message, {.command = static_cast<std::uint32_t>(UsbipCommand::kSubmit),
                                .number = number,
                                .device = 1,
                                .is_in = pending.receives,
                                .endpoint = pending.endpoint & 0x0FU,
                                .length = pending.bytes,
                                .setup = setup});
  message.insert(message.end(), bytes.begin(), bytes.end());
  queue(message);
  if (state_ == State::kOpen) flush();
}

void UsbipLink::keep_reading(std::uint8_t endpoint, std::size_t bytes, int queued) {
  sizes_[endpoint] = static_cast<std::uint32_t>(bytes);
  for (int i = 0; i < queued; ++i) {
    submit({.endpoint = endpoint,
            .bytes = static_cast<std::uint32_t>(bytes),
            .receives = true,
            .reads_again = true},
           {}, {});
  }
}

void UsbipLink::write(std::uint8_t endpoint, std::vector<std::byte> bytes) {
  submit({.endpoint = endpoint, .bytes = static_cast<std::uint32_t>(bytes.size())}, {}, bytes);
}

void UsbipLink::control(const UsbSetup& setup, std::vector<std::byte> bytes) {
  const auto length = static_cast<std::uint16_t>(bytes.size());
  if (setup.is_in()) bytes.clear();
  submit({.bytes = length, .receives = setup.is_in()}, usb_setup_bytes(setup, length), bytes);
}

std::optional<UsbTransfer> UsbipLink::take() {
  if (taken_.empty()) return std::nullopt;
  UsbTransfer first = std::move(taken_.front());
  taken_.pop_front();
  return first;
}

void UsbipLink::attend() {
  if (state_ == State::kGone) return;
  if (state_ == State::kListing || state_ == State::kImporting) {
    std::array<Watched, 1> one{Watched{.fd = socket_.get(), .write = true}};
    wait_for(one, Duration(0));
    if (!one[0].write) return;
    if (auto failure = finish_tcp_connect(socket_)) return fail(*std::move(failure));
    unsent_.clear();
    if (state_ == State::kListing) {
      append_usbip_operation(unsent_, UsbipOperation::kListRequest);
      state_ = State::kListed;
    } else {
      append_usbip_operation(unsent_, UsbipOperation::kImportRequest);
      append_usbip_bus_id(unsent_, device_.bus_id);
      state_ = State::kImported;
    }
  }
  flush();
  receive();
  clear_halts();
}

void UsbipLink::flush() {
  while (!unsent_.empty() && state_ != State::kGone) {
    const TcpTransfer sent = send_now(socket_, unsent_);
    if (sent.failure) return fail(*sent.failure);
    if (sent.bytes == 0) return;
    unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(sent.bytes));
  }
}

void UsbipLink::receive() {
  constexpr int kMostReads = 64;
  std::vector<std::byte> bytes(std::size_t{1} << 16);
  for (int i = 0; i < kMostReads && state_ != State::kGone && state_ != State::kImporting; ++i) {
    const TcpTransfer got = receive_now(socket_, bytes);
    received_.insert(received_.end(), bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(got.bytes));
    while (parse()) {
    }
    // A server ends the connection after its list.
    if (got.failure && state_ != State::kImporting) return fail(*got.failure);
    if (got.bytes == 0) return;
  }
}

void UsbipLink::consume(std::size_t bytes) {
  received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(bytes));
}

/// Takes one message; false: it is not there as a whole.
bool UsbipLink::parse() {
  switch (state_) {
    case State::kListed:
      return parse_list();
    case State::kImported:
      return parse_import();
    case State::kOpen:
      return parse_answer();
    default:
      return false;
  }
}

bool UsbipLink::parse_list() {
  constexpr std::size_t kInterfaceBytes = 4;
  const std::span<const std::byte> all = received_;
  std::size_t at = kUsbipOperationBytes + 4;
  if (all.size() < at) return false;
  const auto header = read_usbip_operation(all.first(kUsbipOperationBytes));
  std::uint32_t count = 0;
  for (std::size_t i = kUsbipOperationBytes; i < at; ++i) {
    count = count << 8 | std::to_integer<std::uint32_t>(all[i]);
  }
  if (header.code != static_cast<std::uint16_t>(UsbipOperation::kListReply) || header.status != 0 ||
      count > kMostUsbipDevices) {
    fail({"usbip", "expected the list of the devices of a USB/IP server, found something else"});
    return false;
  }
  std::optional<UsbipDevice> found;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (all.size() < at + kUsbipDeviceBytes) return false;
    const UsbipDevice device = read_usbip_device(all.subspan(at, kUsbipDeviceBytes));
    at += kUsbipDeviceBytes + kInterfaceBytes * device.interfaces;
    if (device.vendor == id_.vendor && device.product == id_.product && !found) found = device;
  }
  if (all.size() < at) return false;
  if (!found) {
    fail({"not_exported", "the server exports no " + usb_name(id_)});
    return false;
  }
  device_ = *found;
  received_.clear();
  auto again = begin_tcp_connect(server_);
  if (!again) {
    fail({"unavailable", again.error().message});
    return false;
  }
  socket_ = *std::move(again);
  state_ = State::kImporting;
  return false;
}

bool UsbipLink::parse_import() {
  if (received_.size() < kUsbipOperationBytes) return false;
  const auto header = read_usbip_operation(std::span(received_).first(kUsbipOperationBytes));
  if (header.code != static_cast<std::uint16_t>(UsbipOperation::kImportReply) ||
      header.status != 0) {
    fail({"not_exported",
          "the server does not give " + usb_name(id_) + "; another program may have it"});
    return false;
  }
  if (received_.size() < kUsbipOperationBytes + kUsbipDeviceBytes) return false;
  consume(kUsbipOperationBytes + kUsbipDeviceBytes);
  state_ = State::kOpen;
  unsent_.insert(unsent_.end(), waiting_.begin(), waiting_.end());
  waiting_.clear();
  flush();
  return true;
}

bool UsbipLink::parse_answer() {
  if (received_.size() < kUsbipHeaderBytes) return false;
  const UsbipHeader header = read_usbip_header(std::span(received_).first(kUsbipHeaderBytes));
  const auto found = pending_.find(header.number);
  const bool is_answer = header.command == static_cast<std::uint32_t>(UsbipCommand::kSubmitted);
  std::size_t bytes = 0;
  if (is_answer && found != pending_.end() && found->second.receives) {
    if (header.length > found->second.bytes) {
      fail({"usbip", "expected at most " + std::to_string(found->second.bytes) +
                         " bytes of a transfer, found " + std::to_string(header.length)});
      return false;
    }
    bytes = header.length;
  } else if (is_answer && found == pending_.end() && header.length > 0) {
    fail({"usbip", "expected the answer to a transfer that is under way, found that to number " +
                       std::to_string(header.number)});
    return false;
  } else if (!is_answer && header.command != static_cast<std::uint32_t>(UsbipCommand::kUnlinked)) {
    fail({"usbip",
          "expected the answer to a transfer, found command " + std::to_string(header.command)});
    return false;
  }
  if (received_.size() < kUsbipHeaderBytes + bytes) return false;
  const std::vector<std::byte> data(
      received_.begin() + kUsbipHeaderBytes,
      received_.begin() + static_cast<std::ptrdiff_t>(kUsbipHeaderBytes + bytes));
  consume(kUsbipHeaderBytes + bytes);
  if (is_answer) {
    take_answer(header, data);
  } else {
    take_unlinked(header);
  }
  return state_ == State::kOpen;
}

void UsbipLink::take_answer(const UsbipHeader& header, std::span<const std::byte> bytes) {
  const auto found = pending_.find(header.number);
  if (found == pending_.end()) return;
  const Pending pending = found->second;
  pending_.erase(found);
  if (pending.clears_halt) return;
  const UsbEnd end = end_of_status(header.status);
  if (end == UsbEnd::kGone) return fail({"unplugged", "the device was unplugged"});
  // Transfers that waited at a halted endpoint may end with a stall of their own: it is one halt.
  const bool again = end == UsbEnd::kStall && halted_.contains(pending.endpoint);
  if (!again && (pending.receives || pending.endpoint == 0 || end != UsbEnd::kDone)) {
    UsbTransfer news{.endpoint = pending.endpoint, .end = end};
    if (end == UsbEnd::kDone) news.bytes.assign(bytes.begin(), bytes.end());
    taken_.push_back(std::move(news));
  }
  const bool halts = end == UsbEnd::kStall && pending.endpoint != 0;
  if (halts && !halted_.contains(pending.endpoint)) begin_halt(pending.endpoint);
  if (!pending.reads_again) return;
  if (const auto halted = halted_.find(pending.endpoint); halted != halted_.end()) {
    ++halted->second;
  } else {
    submit(pending, {}, {});
  }
}

/// Takes back what waits at a halted endpoint.
void UsbipLink::begin_halt(std::uint8_t endpoint) {
  halted_[endpoint] = 0;
  for (const auto& [number, pending] : pending_) {
    if (pending.endpoint != endpoint || !pending.reads_again) continue;
    const std::uint32_t unlink = ++number_;
    unlinks_[unlink] = number;
    std::vector<std::byte> message;
    append_usbip_header(message, {.command = static_cast<std::uint32_t>(UsbipCommand::kUnlink),
                                  .number = unlink,
                                  .device = 1,
                                  .unlinked = number});
    queue(message);
  }
  flush();
}

/// Takes the answer to an unlink. A transfer that had ended before has had an answer of its own.
void UsbipLink::take_unlinked(const UsbipHeader& header) {
  const auto unlink = unlinks_.find(header.number);
  if (unlink == unlinks_.end()) return;
  const auto found = pending_.find(unlink->second);
  unlinks_.erase(unlink);
  if (found == pending_.end()) return;
  const Pending pending = found->second;
  pending_.erase(found);
  if (const auto halted = halted_.find(pending.endpoint); halted != halted_.end()) ++halted->second;
}

/// Sends CLEAR_FEATURE(ENDPOINT_HALT) once all transfers of an endpoint have ended, and then the
/// reads again.
void UsbipLink::clear_halts() {
  constexpr std::uint8_t kToEndpoint = 0x02, kClearFeature = 1;
  for (auto one = halted_.begin(); one != halted_.end() && state_ == State::kOpen;) {
    const std::uint8_t endpoint = one->first;
    const int reads = one->second;
    const bool busy = std::ranges::any_of(
        pending_, [&](const auto& other) { return other.second.endpoint == endpoint; });
    if (busy) {
      ++one;
      continue;
    }
    one = halted_.erase(one);
    submit({.clears_halt = true},
           usb_setup_bytes(
               {.request_type = kToEndpoint, .request = kClearFeature, .index = endpoint}, 0),
           {});
    keep_reading(endpoint, sizes_[endpoint], reads);
  }
}

void UsbipLink::drain(Duration longest) {
  const auto sending = [&] {
    return std::ranges::any_of(pending_, [](const auto& one) { return !one.second.receives; });
  };
  const auto end = std::chrono::steady_clock::now() + longest;
  while (state_ != State::kGone && (sending() || !unsent_.empty()) &&
         std::chrono::steady_clock::now() < end) {
    std::array<Watched, 1> one{watched()};
    wait_for(one, std::chrono::milliseconds(5));
    attend();
  }
}

}  // namespace

Result<std::unique_ptr<UsbLink>> open_usbip(const std::string& host, std::uint16_t port,
                                            const UsbId& id) {
  auto server = resolve_tcp(host, port);
  if (!server) return server.error();
  auto socket = begin_tcp_connect(*server);
  if (!socket) return socket.error();
  return std::unique_ptr<UsbLink>(new UsbipLink(*std::move(server), id, *std::move(socket)));
}

}  // namespace nav::devices
