// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usbip_server.hpp"

#include <algorithm>
#include <cerrno>
#include <sys/socket.h>
#include <utility>

#include "devices/usb/usb_descriptors.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kMostUsbipClients = 8;
constexpr const char* kUsbipBusId = "1-1";

std::uint8_t address_of(const UsbipHeader& header) {
  return static_cast<std::uint8_t>((header.endpoint & 0x0F) | (header.is_in ? 0x80U : 0U));
}

}  // namespace

Result<std::unique_ptr<UsbipServer>> UsbipServer::start(std::unique_ptr<UsbEmulatedDevice> device,
                                                        const std::string& address,
                                                        std::uint16_t port) {
  const auto endpoint = resolve_tcp(address, port);
  if (!endpoint) return endpoint.error();
  auto listener = listen_tcp(*endpoint);
  if (!listener) return listener.error();
  return std::unique_ptr<UsbipServer>(new UsbipServer(std::move(device), *std::move(listener)));
}

UsbipServer::UsbipServer(std::unique_ptr<UsbEmulatedDevice> device, FileDescriptor listener)
    : listener_(std::move(listener)), port_(bound_port(listener_)), device_(std::move(device)) {
  const UsbDescription& description = device_->description();
  exported_ = {.path = "/sys/devices/platform/sonde/usb1/1-1",
               .bus_id = kUsbipBusId,
               .bus = 1,
               .device = 2,
               .vendor = description.vendor,
               .product = description.product};
  thread_ = std::thread([this] { run(); });
}

UsbipServer::~UsbipServer() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.signal();
  thread_.join();
}

void UsbipServer::unplug() {
  {
    const std::lock_guard lock(mutex_);
    plugged_ = false;
    drops_all_ = true;
  }
  wake_.signal();
}

void UsbipServer::replug() {
  const std::lock_guard lock(mutex_);
  plugged_ = true;
}

std::uint64_t UsbipServer::transfers() const {
  const std::lock_guard lock(mutex_);
  return transfers_;
}

std::uint64_t UsbipServer::cleared_halts() const {
  const std::lock_guard lock(mutex_);
  return cleared_;
}

void UsbipServer::drop(Client& client) {
  client.socket.close();
  if (std::exchange(client.imported, false)) {
    waiting_.clear();
    halted_.clear();
  }
}

void UsbipServer::run() {
  std::vector<Watched> watched;
  for (;;) {
    Duration longest = std::chrono::seconds(1);
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) return;
      if (std::exchange(drops_all_, false)) {
        for (Client& client : clients_) drop(client);
      }
      std::erase_if(clients_, [](const Client& client) { return !client.socket.is_open(); });
      const bool accepts = clients_.size() < kMostUsbipClients;
      watched.assign({{.fd = wake_.get(), .read = true},
                      {.fd = accepts ? listener_.get() : -1, .read = true}});
      for (const Client& client : clients_) {
        watched.push_back(
            {.fd = client.socket.get(), .read = true, .write = !client.unsent.empty()});
      }
      if (!waiting_.empty()) {
        longest = std::clamp(device_->due() - clock_.now(), Duration(0), longest);
      }
    }
    wait_for(watched, longest);
    if (watched[0].read) wake_.clear();
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 2; i < watched.size() && i - 2 < clients_.size(); ++i) {
      serve_one(clients_[i - 2], watched[i].read);
    }
    if (watched[1].read) {
      FileDescriptor socket(
          ::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (socket.is_open()) {
        set_tcp_options(socket, TcpUnsent::kKeep);
        clients_.push_back({.socket = std::move(socket)});
      }
    }
    give_what_is_due();
    for (Client& client : clients_) serve_one(client, false);
  }
}

/// Reads and sends what can be.
void UsbipServer::serve_one(Client& client, bool readable) {
  if (!client.socket.is_open()) return;
  if (readable) {
    std::vector<std::byte> bytes(std::size_t{1} << 16);
    const TcpTransfer got = receive_now(client.socket, bytes);
    client.received.insert(client.received.end(), bytes.begin(),
                           bytes.begin() + static_cast<std::ptrdiff_t>(got.bytes));
    while (client.socket.is_open() && parse(client)) {
    }
    if (got.failure) return drop(client);
  }
  while (client.socket.is_open() && !client.unsent.empty()) {
    const TcpTransfer sent = send_now(client.socket, client.unsent);
    if (sent.failure) return drop(client);
    if (sent.bytes == 0) return;
    client.unsent.erase(client.unsent.begin(),
                        client.unsent.begin() + static_cast<std::ptrdiff_t>(sent.bytes));
  }
  if (client.ends) drop(client);
}

/// Takes one message; false: it is not there as a whole.
bool UsbipServer::parse(Client& client) {
  if (!client.imported) return parse_operation(client);
  if (client.received.size() < kUsbipHeaderBytes) return false;
  const UsbipHeader header = read_usbip_header(std::span(client.received).first(kUsbipHeaderBytes));
  const bool submits = header.command == static_cast<std::uint32_t>(UsbipCommand::kSubmit);
  const bool isochronous = header.packets != 0 && header.packets != 0xFFFFFFFF;
  if (submits && (isochronous || header.length > kUsbipLargestTransfer)) {
    drop(client);  // The device has no such endpoint, and bytes of unknown meaning follow.
    return false;
  }
  const std::size_t bytes = submits && !header.is_in ? header.length : 0;
  if (client.received.size() < kUsbipHeaderBytes + bytes) return false;
  const auto begin = client.received.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(kUsbipHeaderBytes + bytes);
  const std::vector<std::byte> data(begin + kUsbipHeaderBytes, end);
  client.received.erase(begin, end);
  if (submits) {
    submit(client, header, data);
  } else if (header.command == static_cast<std::uint32_t>(UsbipCommand::kUnlink)) {
    unlink(client, header);
  } else {
    drop(client);
  }
  return client.socket.is_open();
}

bool UsbipServer::parse_operation(Client& client) {
  if (client.ends || client.received.size() < kUsbipOperationBytes) return false;
  const auto header = read_usbip_operation(std::span(client.received).first(kUsbipOperationBytes));
  if (header.code == static_cast<std::uint16_t>(UsbipOperation::kListRequest)) {
    append_usbip_operation(client.unsent, UsbipOperation::kListReply);
    const std::byte count{plugged_ ? std::uint8_t{1} : std::uint8_t{0}};
    client.unsent.insert(client.unsent.end(), {std::byte{0}, std::byte{0}, std::byte{0}, count});
    if (plugged_) {
      append_usbip_device(client.unsent, exported_);
      client.unsent.insert(client.unsent.end(),
                           {std::byte{0xFF}, std::byte{0}, std::byte{0}, std::byte{0}});
    }
    client.ends = true;
    return false;
  }
  if (header.code != static_cast<std::uint16_t>(UsbipOperation::kImportRequest)) {
    drop(client);
    return false;
  }
  if (client.received.size() < kUsbipOperationBytes + kUsbipBusIdBytes) return false;
  const std::string bus_id =
      read_usbip_bus_id(std::span(client.received).subspan(kUsbipOperationBytes, kUsbipBusIdBytes));
  client.received.erase(client.received.begin(),
                        client.received.begin() +
                            static_cast<std::ptrdiff_t>(kUsbipOperationBytes + kUsbipBusIdBytes));
  const bool taken = std::ranges::any_of(clients_, [](const Client& one) { return one.imported; });
  if (!plugged_ || taken || bus_id != kUsbipBusId) {
    append_usbip_operation(client.unsent, UsbipOperation::kImportReply, 1);
    client.ends = true;
    return false;
  }
  append_usbip_operation(client.unsent, UsbipOperation::kImportReply);
  append_usbip_device(client.unsent, exported_);
  client.imported = true;
  device_->attach(clock_.now());
  return true;
}

void UsbipServer::answer(Client& client, std::uint32_t number, const UsbReply& reply,
                         std::uint32_t length) {
  append_usbip_header(client.unsent,
                      {.command = static_cast<std::uint32_t>(UsbipCommand::kSubmitted),
                       .number = number,
                       .length = length,
                       .status = static_cast<std::int32_t>(reply.fault)});
  client.unsent.insert(client.unsent.end(), reply.bytes.begin(), reply.bytes.end());
  ++transfers_;
}

void UsbipServer::submit(Client& client, const UsbipHeader& header,
                         std::span<const std::byte> bytes) {
  if (header.endpoint == 0) {
    UsbReply reply = standard(usb_setup_of(header.setup), bytes, header.length);
    if (!header.is_in) reply.bytes.clear();
    reply.bytes.resize(std::min<std::size_t>(reply.bytes.size(), header.length));
    const std::size_t moved = header.is_in ? reply.bytes.size() : bytes.size();
    return answer(client, header.number, reply, static_cast<std::uint32_t>(moved));
  }
  const std::uint8_t endpoint = address_of(header);
  const auto& all = device_->description().endpoints;
  const bool known =
      std::ranges::any_of(all, [&](const UsbEndpoint& one) { return one.address == endpoint; });
  if (!known) return answer(client, header.number, {.fault = UsbFault::kStall}, 0);
  if (header.is_in) {
    waiting_.push_back({header.number, endpoint, header.length});
    return;
  }
  UsbFault fault = UsbFault::kStall;
  if (!halted_.contains(endpoint)) fault = device_->take(endpoint, bytes, clock_.now());
  if (fault == UsbFault::kStall) halted_.insert(endpoint);
  const bool done = fault == UsbFault::kNone;
  answer(client, header.number, {.fault = fault},
         done ? static_cast<std::uint32_t>(bytes.size()) : 0);
}

void UsbipServer::unlink(Client& client, const UsbipHeader& header) {
  const std::size_t erased =
      std::erase_if(waiting_, [&](const Waiting& one) { return one.number == header.unlinked; });
  append_usbip_header(client.unsent,
                      {.command = static_cast<std::uint32_t>(UsbipCommand::kUnlinked),
                       .number = header.number,
                       .status = erased > 0 ? -ECONNRESET : 0});
}

/// Answers the requests that every device knows (USB 2.0, 9.4); others go to the device.
UsbReply UsbipServer::standard(const UsbSetup& setup, std::span<const std::byte> bytes,
                               std::size_t room) {
  constexpr std::uint8_t kKindBits = 0x60, kRecipientBits = 0x1F, kToEndpoint = 2;
  constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kGetDescriptor = 6,
                         kGetConfiguration = 8, kSetConfiguration = 9, kGetInterface = 10,
                         kSetInterface = 11;
  if ((setup.request_type & kKindBits) != 0) return device_->control(setup, bytes, room);
  switch (setup.request) {
    case kGetStatus:
      return {.bytes = {std::byte{0}, std::byte{0}}};
    case kGetConfiguration:
      return {.bytes = {std::byte{1}}};
    case kGetInterface:
      return {.bytes = {std::byte{0}}};
    case kSetConfiguration:
    case kSetInterface:
      return {};
    case kClearFeature:
      if ((setup.request_type & kRecipientBits) == kToEndpoint) {
        halted_.erase(static_cast<std::uint8_t>(setup.index & 0xFF));
        ++cleared_;
      }
      return {};
    case kGetDescriptor:
      if (auto found = usb_descriptor(device_->description(), setup.value)) {
        return {.bytes = *std::move(found)};
      }
      return {.fault = UsbFault::kStall};
    default:
      return {.fault = UsbFault::kStall};
  }
}

/// Answers the transfers that wait, as far as the device has something for them.
void UsbipServer::give_what_is_due() {
  const auto host = std::ranges::find_if(clients_, [](const Client& one) { return one.imported; });
  if (host == clients_.end()) return;
  std::set<std::uint8_t> empty;
  const Timestamp now = clock_.now();
  for (auto one = waiting_.begin(); one != waiting_.end();) {
    if (empty.contains(one->endpoint)) {
      ++one;
      continue;
    }
    std::optional<UsbReply> reply{{.fault = UsbFault::kStall}};
    if (!halted_.contains(one->endpoint)) reply = device_->give(one->endpoint, one->room, now);
    if (!reply) {
      empty.insert(one->endpoint);
      ++one;
      continue;
    }
    if (reply->fault == UsbFault::kStall) halted_.insert(one->endpoint);
    if (reply->fault != UsbFault::kNone) reply->bytes.clear();
    reply->bytes.resize(std::min<std::size_t>(reply->bytes.size(), one->room));
    answer(*host, one->number, *reply, static_cast<std::uint32_t>(reply->bytes.size()));
    one = waiting_.erase(one);
  }
}

}  // namespace nav::devices
