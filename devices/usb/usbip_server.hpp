// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "devices/usb/usb_emulated_device.hpp"
#include "devices/usb/usbip_protocol.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// Exports one emulated device by USB/IP, as bus id "1-1". A host takes it by
///   usbip attach --remote=ADDRESS --busid=1-1
/// as root, after which the kernel and libusb see a USB device, or by open_usbip() without a
/// kernel. One host has the device at a time; the list may be asked for by others meanwhile. One
/// thread, which the destructor joins; all functions are thread-safe.
class UsbipServer {
 public:
  /// Listens at \p address; port 0: the system chooses one. kUnavailable when it cannot be had.
  static Result<std::unique_ptr<UsbipServer>> start(std::unique_ptr<UsbEmulatedDevice> device,
                                                    const std::string& address, std::uint16_t port);
  ~UsbipServer();
  UsbipServer(const UsbipServer&) = delete;
  UsbipServer& operator=(const UsbipServer&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Takes the device from its host and from the list, and brings it back.
  void unplug();
  void replug();
  /// Transfers that have been answered.
  [[nodiscard]] std::uint64_t transfers() const;
  /// Times that a host cleared the halt of an endpoint.
  [[nodiscard]] std::uint64_t cleared_halts() const;

 private:
  /// A transfer of an IN endpoint that waits for the device.
  struct Waiting {
    std::uint32_t number = 0;
    std::uint8_t endpoint = 0;
    std::uint32_t room = 0;
  };
  struct Client {
    FileDescriptor socket;
    std::vector<std::byte> received{}, unsent{};
    bool imported = false;
    bool ends = false;  ///< It is closed when all is sent.
  };
  UsbipServer(std::unique_ptr<UsbEmulatedDevice> device, FileDescriptor listener);
  void run();
  void serve_one(Client& client, bool readable);
  bool parse(Client& client);
  bool parse_operation(Client& client);
  void submit(Client& client, const UsbipHeader& header, std::span<const std::byte> bytes);
  void unlink(Client& client, const UsbipHeader& header);
  void answer(Client& client, std::uint32_t number, const UsbReply& reply, std::uint32_t length);
  UsbReply standard(const UsbSetup& setup, std::span<const std::byte> bytes, std::size_t room);
  void give_what_is_due();
  void drop(Client& client);

  WakeEvent wake_;
  FileDescriptor listener_;
  std::uint16_t port_;
  MonotonicClock clock_;

  mutable std::mutex mutex_;  ///< Guards everything below.
  std::unique_ptr<UsbEmulatedDevice> device_;
  UsbipDevice exported_;
  bool stopped_ = false, plugged_ = true;
  bool drops_all_ = false;  ///< The thread ends all connections.
  std::vector<Client> clients_;
  std::deque<Waiting> waiting_;
  std::set<std::uint8_t> halted_;  ///< Endpoints.
  std::uint64_t transfers_ = 0, cleared_ = 0;

  std::thread thread_;
};

}  // namespace nav::devices
