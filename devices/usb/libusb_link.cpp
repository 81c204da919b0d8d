// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/libusb_link.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <libusb-1.0/libusb.h>
#include <list>
#include <map>
#include <poll.h>
#include <sys/epoll.h>

#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr int kUsbInterface = 0;
constexpr unsigned kUsbWriteMs = 1000;
/// Longest wait for transfers that were cancelled.
constexpr std::chrono::seconds kLongestCancel{2};

struct UsbContextEnd {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
struct UsbHandleEnd {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
struct UsbTransferEnd {
  void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); }
};
using UsbContext = std::unique_ptr<libusb_context, UsbContextEnd>;
using UsbHandle = std::unique_ptr<libusb_device_handle, UsbHandleEnd>;

UsbEnd end_of(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return UsbEnd::kDone;
    case LIBUSB_TRANSFER_STALL:
      return UsbEnd::kStall;
    case LIBUSB_TRANSFER_OVERFLOW:
      return UsbEnd::kOverflow;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return UsbEnd::kTimeout;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return UsbEnd::kGone;
    default:
      return UsbEnd::kError;
  }
}

class LibusbLink final : public UsbLink {
 public:
  LibusbLink(UsbContext context, UsbHandle handle)
      : context_(std::move(context)),
        handle_(std::move(handle)),
        events_(::epoll_create1(EPOLL_CLOEXEC)) {
    NAV_CHECK(events_.is_open());
    const libusb_pollfd** all = libusb_get_pollfds(context_.get());
    for (const libusb_pollfd** one = all; one != nullptr && *one != nullptr; ++one) {
      watch((*one)->fd, (*one)->events, this);
    }
    libusb_free_pollfds(all);
    libusb_set_pollfd_notifiers(context_.get(), watch, forget, this);
  }
  ~LibusbLink() override;

  [[nodiscard]] Watched watched() const override { return {.fd = events_.get(), .read = true}; }
  void attend() override;
  void keep_reading(std::uint8_t endpoint, std::size_t bytes, int queued) override;
  void write(std::uint8_t endpoint, std::vector<std::byte> bytes) override;
  void control(const UsbSetup& setup, std::vector<std::byte> bytes) override;
  std::optional<UsbTransfer> take() override;
  void drain(Duration longest) override;

 private:
  /// One transfer of libusb; it stays where it is as long as libusb may use it.
  struct Slot {
    LibusbLink* link = nullptr;
    std::unique_ptr<libusb_transfer, UsbTransferEnd> transfer{};
    std::vector<unsigned char> buffer{};
    std::uint8_t endpoint = 0;
    bool reads_again = false;  ///< It belongs to keep_reading().
    bool under_way = false;
  };

  static void watch(int fd, short events, void* user);
  static void forget(int fd, void* user);
  static void LIBUSB_CALL ended(libusb_transfer* transfer);
  Slot& add_slot(std::uint8_t endpoint, std::vector<unsigned char> buffer);
  void submit(Slot& slot);
  void finish(Slot& slot);
  void report(const Slot& slot, UsbEnd end);
  void clear_halts();
  void handle_events(std::chrono::milliseconds longest);
  [[nodiscard]] bool is_under_way(std::uint8_t endpoint) const;

  UsbContext context_;
  UsbHandle handle_;
  FileDescriptor events_;  ///< Watches the descriptors of libusb.
  std::list<Slot> slots_;
  std::deque<Slot*> ended_;              ///< Filled by libusb's callback.
  std::map<std::uint8_t, bool> halted_;  ///< Endpoints that wait for all their transfers to end.
  std::deque<UsbTransfer> taken_;
  bool gone_ = false;
};

LibusbLink::~LibusbLink() {
  for (Slot& slot : slots_) {
    if (slot.under_way) libusb_cancel_transfer(slot.transfer.get());
  }
  const auto busy = [&] {
    return std::ranges::any_of(slots_, [](const Slot& slot) { return slot.under_way; });
  };
  const auto end = std::chrono::steady_clock::now() + kLongestCancel;
  while (busy() && std::chrono::steady_clock::now() < end) {
    handle_events(std::chrono::milliseconds(50));
  }
  libusb_set_pollfd_notifiers(context_.get(), nullptr, nullptr, nullptr);
  if (busy()) {
    // The kernel does not give a transfer back. Its memory stays, rather than being written to
    // after it was freed.
    static_cast<void>(new std::list<Slot>(std::move(slots_)));
    static_cast<void>(handle_.release());
    static_cast<void>(context_.release());
    return;
  }
  slots_.clear();
  libusb_release_interface(handle_.get(), kUsbInterface);
  handle_.reset();
}

void LibusbLink::watch(int fd, short events, void* user) {
  epoll_event event{};
  event.events =
      ((events & POLLIN) != 0 ? EPOLLIN : 0U) | ((events & POLLOUT) != 0 ? EPOLLOUT : 0U);
  event.data.fd = fd;
  ::epoll_ctl(static_cast<LibusbLink*>(user)->events_.get(), EPOLL_CTL_ADD, fd, &event);
}

void LibusbLink::forget(int fd, void* user) {
  epoll_event none{};
  ::epoll_ctl(static_cast<LibusbLink*>(user)->events_.get(), EPOLL_CTL_DEL, fd, &none);
}

/// Only notes the end: nothing that handles events may be called from here.
void LIBUSB_CALL LibusbLink::ended(libusb_transfer* transfer) {
  auto* const slot = static_cast<Slot*>(transfer->user_data);
  slot->under_way = false;
  slot->link->ended_.push_back(slot);
}

LibusbLink::Slot& LibusbLink::add_slot(std::uint8_t endpoint, std::vector<unsigned char> buffer) {
  Slot& slot = slots_.emplace_back();
  slot.link = this;
  slot.transfer.reset(libusb_alloc_transfer(0));
  NAV_CHECK(slot.transfer != nullptr);
  slot.endpoint = endpoint;
  slot.buffer = std::move(buffer);
  return slot;
}

void LibusbLink::submit(Slot& slot) {
  if (gone_) return;
  const int code = libusb_submit_transfer(slot.transfer.get());
  slot.under_way = code == 0;
  if (code == 0) return;
  gone_ = code == LIBUSB_ERROR_NO_DEVICE;
  report(slot, gone_ ? UsbEnd::kGone : UsbEnd::kError);
}

void LibusbLink::report(const Slot& slot, UsbEnd end) {
  taken_.push_back({.endpoint = slot.endpoint, .end = end});
}

void LibusbLink::keep_reading(std::uint8_t endpoint, std::size_t bytes, int queued) {
  for (int i = 0; i < queued; ++i) {
    Slot& slot = add_slot(endpoint, std::vector<unsigned char>(bytes));
    slot.reads_again = true;
    libusb_fill_bulk_transfer(slot.transfer.get(), handle_.get(), endpoint, slot.buffer.data(),
                              static_cast<int>(bytes), ended, &slot, 0);
    submit(slot);
  }
}

void LibusbLink::write(std::uint8_t endpoint, std::vector<std::byte> bytes) {
  std::vector<unsigned char> buffer;
  for (const std::byte byte : bytes) buffer.push_back(std::to_integer<unsigned char>(byte));
  Slot& slot = add_slot(endpoint, std::move(buffer));
  libusb_fill_bulk_transfer(slot.transfer.get(), handle_.get(), endpoint, slot.buffer.data(),
                            static_cast<int>(slot.buffer.size()), ended, &slot, kUsbWriteMs);
  submit(slot);
}

void LibusbLink::control(const UsbSetup& setup, std::vector<std::byte> bytes) {
  std::vector<unsigned char> buffer(LIBUSB_CONTROL_SETUP_SIZE);
  for (const std::byte byte : bytes) buffer.push_back(std::to_integer<unsigned char>(byte));
  Slot& slot = add_slot(0, std::move(buffer));
  libusb_fill_control_setup(slot.buffer.data(), setup.request_type, setup.request, setup.value,
                            setup.index, static_cast<std::uint16_t>(bytes.size()));
  libusb_fill_control_transfer(slot.transfer.get(), handle_.get(), slot.buffer.data(), ended, &slot,
                               kUsbWriteMs);
  submit(slot);
}

std::optional<UsbTransfer> LibusbLink::take() {
  if (taken_.empty()) return std::nullopt;
  UsbTransfer first = std::move(taken_.front());
  taken_.pop_front();
  return first;
}

void LibusbLink::handle_events(std::chrono::milliseconds longest) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(longest).count();
  timeval wait{.tv_sec = 0, .tv_usec = static_cast<suseconds_t>(us)};
  libusb_handle_events_timeout_completed(context_.get(), &wait, nullptr);
}

void LibusbLink::attend() {
  handle_events(std::chrono::milliseconds(0));
  while (!ended_.empty()) {
    Slot& slot = *ended_.front();
    ended_.pop_front();
    finish(slot);
  }
  clear_halts();
}

/// Takes the outcome of a transfer, and queues it again where it belongs to a row of reads.
void LibusbLink::finish(Slot& slot) {
  const libusb_transfer& transfer = *slot.transfer;
  const bool cancelled = transfer.status == LIBUSB_TRANSFER_CANCELLED;
  const UsbEnd end = end_of(transfer.status);
  const bool receives = slot.reads_again || (transfer.endpoint & LIBUSB_ENDPOINT_IN) != 0 ||
                        (slot.endpoint == 0 && (slot.buffer[0] & LIBUSB_ENDPOINT_IN) != 0);
  // Transfers that waited at a halted endpoint may end with a stall of their own: it is one halt.
  const bool again = end == UsbEnd::kStall && slot.endpoint != 0 && halted_[slot.endpoint];
  if (!cancelled && !again && (receives || slot.endpoint == 0 || end != UsbEnd::kDone)) {
    UsbTransfer news{.endpoint = slot.endpoint, .end = end};
    const std::size_t skip = slot.endpoint == 0 ? LIBUSB_CONTROL_SETUP_SIZE : 0;
    const auto length = static_cast<std::size_t>(std::max(transfer.actual_length, 0));
    if (receives && end == UsbEnd::kDone && skip + length <= slot.buffer.size()) {
      for (std::size_t i = 0; i < length; ++i) {
        news.bytes.push_back(static_cast<std::byte>(slot.buffer[skip + i]));
      }
    }
    taken_.push_back(std::move(news));
  }
  if (end == UsbEnd::kGone) gone_ = true;
  // A control endpoint is never halted: the next request clears it (USB 2.0, 8.5.3.4).
  if (end == UsbEnd::kStall && slot.endpoint != 0 && !halted_[slot.endpoint]) {
    halted_[slot.endpoint] = true;
    for (Slot& other : slots_) {
      if (other.endpoint == slot.endpoint && other.under_way) {
        libusb_cancel_transfer(other.transfer.get());
      }
    }
  }
  if (slot.reads_again) {
    if (!halted_[slot.endpoint] && !cancelled) submit(slot);
    return;
  }
  slots_.remove_if([&](const Slot& one) { return &one == &slot; });
}

bool LibusbLink::is_under_way(std::uint8_t endpoint) const {
  return std::ranges::any_of(
      slots_, [&](const Slot& slot) { return slot.endpoint == endpoint && slot.under_way; });
}

/// Clears the halt of each endpoint whose transfers have all ended, and reads again.
void LibusbLink::clear_halts() {
  for (auto& [endpoint, halted] : halted_) {
    if (!halted || gone_ || is_under_way(endpoint)) continue;
    halted = false;
    const int code = libusb_clear_halt(handle_.get(), endpoint);
    if (code == LIBUSB_ERROR_NO_DEVICE || code == LIBUSB_ERROR_NOT_FOUND) {
      gone_ = true;
      taken_.push_back({.endpoint = endpoint, .end = UsbEnd::kGone});
      return;
    }
    for (Slot& slot : slots_) {
      if (slot.endpoint == endpoint && slot.reads_again) submit(slot);
    }
  }
}

void LibusbLink::drain(Duration longest) {
  const auto sending = [&] {
    return std::ranges::any_of(
        slots_, [](const Slot& slot) { return slot.under_way && !slot.reads_again; });
  };
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!gone_ && sending() && std::chrono::steady_clock::now() < end) {
    handle_events(std::chrono::milliseconds(5));
    attend();
  }
}

Error usb_open_error(const std::string& name, int code) {
  switch (code) {
    case LIBUSB_ERROR_ACCESS:
      return {ErrorCode::kUnavailable,
              name +
                  ": expected to be opened, found permission denied: install "
                  "share/udev/70-sonde.rules and plug the device in again"};
    case LIBUSB_ERROR_BUSY:
      return {ErrorCode::kUnavailable,
              name +
                  ": expected a device for this program alone, found that another program has "
                  "claimed it; end that program"};
    case LIBUSB_ERROR_NO_DEVICE:
      return {ErrorCode::kNotFound, name + ": the device was unplugged while it was opened"};
    default:
      return {ErrorCode::kUnavailable, name + ": cannot be opened: " + libusb_strerror(code)};
  }
}

std::string serial_of(libusb_device_handle* handle, const libusb_device_descriptor& descriptor) {
  if (descriptor.iSerialNumber == 0) return "";
  std::array<unsigned char, 256> text{};
  const int length = libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber,
                                                        text.data(), static_cast<int>(text.size()));
  return length > 0 ? std::string(text.begin(), text.begin() + length) : "";
}

/// The devices of these numbers that can be opened, and what became of the others.
struct UsbFound {
  std::vector<UsbHandle> handles{};
  std::vector<std::string> other_serials{};
  int error = 0;  ///< The newest failure; 0: none.
};

UsbFound find_usb(libusb_context* context, const UsbId& id) {
  UsbFound found;
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context, &list);
  if (count < 0) {
    found.error = static_cast<int>(count);
    return found;
  }
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
    if (descriptor.idVendor != id.vendor || descriptor.idProduct != id.product) continue;
    libusb_device_handle* opened = nullptr;
    if (const int code = libusb_open(list[i], &opened); code != 0) {
      found.error = code;
      continue;
    }
    UsbHandle handle(opened);
    if (!id.serial.empty()) {
      const std::string serial = serial_of(opened, descriptor);
      if (serial != id.serial) {
        found.other_serials.push_back(serial);
        continue;
      }
    }
    found.handles.push_back(std::move(handle));
  }
  libusb_free_device_list(list, 1);
  return found;
}

Error not_found_error(const UsbId& id, const UsbFound& found) {
  if (found.error != 0) return usb_open_error(usb_name(id), found.error);
  if (found.other_serials.empty()) {
    return {ErrorCode::kNotFound,
            usb_name(id) +
                ": expected a USB device with these numbers, found none; plug it in (sonde devices "
                "lists them)"};
  }
  std::string serials;
  for (const std::string& serial : found.other_serials) {
    serials.append(serials.empty() ? "'" : ", '").append(serial).append("'");
  }
  return {ErrorCode::kNotFound, usb_name(id) + ": expected this serial number, found " + serials};
}

}  // namespace

Result<std::unique_ptr<UsbLink>> open_usb(const UsbId& id) {
  libusb_context* started = nullptr;
  if (const int code = libusb_init(&started); code != 0) {
    return Error{ErrorCode::kUnavailable,
                 usb_name(id) + ": cannot start the USB library: " + libusb_strerror(code)};
  }
  UsbContext context(started);
  UsbFound found = find_usb(context.get(), id);
  if (found.handles.empty()) return not_found_error(id, found);
  if (found.handles.size() > 1) {
    return Error{ErrorCode::kUnavailable,
                 usb_name(id) + ": expected one device, found " +
                     std::to_string(found.handles.size()) +
                     "; name its serial number, usb:" + "VENDOR:PRODUCT:SERIAL"};
  }
  UsbHandle handle = std::move(found.handles.front());
  libusb_set_auto_detach_kernel_driver(handle.get(), 1);
  if (const int code = libusb_claim_interface(handle.get(), kUsbInterface); code != 0) {
    return usb_open_error(usb_name(id), code);
  }
  return std::unique_ptr<UsbLink>(new LibusbLink(std::move(context), std::move(handle)));
}

}  // namespace nav::devices
