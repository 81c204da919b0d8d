// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <thread>

#include "devices/usb/usb_descriptors.hpp"
#include "devices/usb/usbip_link.hpp"
#include "devices/usb/usbip_protocol.hpp"
#include "devices/usb/usbip_server.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::byte>;

constexpr std::uint8_t kIn = 0x81, kOut = 0x02;

Bytes word_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// A device that sends back what it was sent, and does as the words say.
class EchoDevice final : public UsbEmulatedDevice {
 public:
  [[nodiscard]] const UsbDescription& description() const override { return description_; }
  void attach(Timestamp /*now*/) override { replies_.clear(); }
  UsbReply control(const UsbSetup& setup, std::span<const std::byte> bytes,
                   std::size_t room) override {
    if (setup.request == 0x55) return {.fault = UsbFault::kStall};
    if (!setup.is_in()) kept_.assign(bytes.begin(), bytes.end());
    Bytes answer = kept_;
    answer.resize(std::min(answer.size(), room));
    return {.bytes = answer};
  }
  UsbFault take(std::uint8_t /*endpoint*/, std::span<const std::byte> bytes,
                Timestamp /*now*/) override {
    const Bytes all(bytes.begin(), bytes.end());
    if (all == word_bytes("halt")) {
      replies_.push_back({.fault = UsbFault::kStall});
    } else if (all == word_bytes("babble")) {
      replies_.push_back({.fault = UsbFault::kOverflow});
    } else if (all == word_bytes("reject")) {
      return UsbFault::kStall;
    } else {
      replies_.push_back({.bytes = all});
    }
    return UsbFault::kNone;
  }
  std::optional<UsbReply> give(std::uint8_t /*endpoint*/, std::size_t /*room*/,
                               Timestamp /*now*/) override {
    if (replies_.empty()) return std::nullopt;
    UsbReply first = replies_.front();
    replies_.pop_front();
    return first;
  }
  [[nodiscard]] Timestamp due() const override { return Timestamp::max(); }

 private:
  UsbDescription description_{.vendor = 0x1209,
                              .product = 0x0001,
                              .maker = "Sonde",
                              .name = "Echo",
                              .serial = "7",
                              .endpoints = {{kIn}, {kOut}}};
  std::deque<UsbReply> replies_;
  Bytes kept_;
};

class UsbipTest : public ::testing::Test {
 protected:
  UsbipTest() : server_(*UsbipServer::start(std::make_unique<EchoDevice>(), "127.0.0.1", 0)) {}
  std::unique_ptr<UsbLink> open(UsbId id = {0x1209, 0x0001}) {
    return *open_usbip("127.0.0.1", server_->port(), id);
  }
  /// The next transfer that ends.
  static std::optional<UsbTransfer> next(UsbLink& link) {
    for (int i = 0; i < 2000; ++i) {
      if (auto transfer = link.take()) return transfer;
      std::array<Watched, 1> one{link.watched()};
      wait_for(one, milliseconds(10));
      link.attend();
    }
    return std::nullopt;
  }
  static void expect_bytes(UsbLink& link, std::string_view text) {
    const auto got = next(link);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->endpoint, kIn);
    EXPECT_EQ(got->end, UsbEnd::kDone);
    EXPECT_EQ(got->bytes, word_bytes(text));
  }
  static void expect_end(UsbLink& link, std::uint8_t endpoint, UsbEnd end) {
    const auto got = next(link);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->endpoint, endpoint);
    EXPECT_EQ(got->end, end) << to_string(got->end);
    EXPECT_TRUE(got->bytes.empty());
  }
  std::unique_ptr<UsbipServer> server_;
};

TEST_F(UsbipTest, CarriesBulkTransfersInOrder) {
  const auto link = open();
  link->keep_reading(kIn, 64, 4);
  for (const char* word : {"one", "two", "", "four"}) link->write(kOut, word_bytes(word));
  for (const char* word : {"one", "two", "", "four"}) expect_bytes(*link, word);
}

TEST_F(UsbipTest, CarriesControlTransfersBothWays) {
  const auto link = open();
  link->control({.request_type = 0x40, .request = 1}, word_bytes("kept"));
  auto got = next(*link);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->end, UsbEnd::kDone);
  link->control({.request_type = 0xC0, .request = 2}, Bytes(2));
  got = next(*link);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->bytes, word_bytes("ke"));
  link->control({.request_type = 0xC0, .request = 0x55}, Bytes(2));
  expect_end(*link, 0, UsbEnd::kStall);
  link->control({.request_type = 0x80, .request = 6, .value = 0x0100}, Bytes(18));
  got = next(*link);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->bytes.size(), 18U);
  EXPECT_EQ(got->bytes[8], std::byte{0x09}) << "the low byte of the vendor";
}

TEST_F(UsbipTest, AHaltedEndpointIsClearedAndReadAgain) {
  const auto link = open();
  link->keep_reading(kIn, 64, 4);
  link->write(kOut, word_bytes("halt"));
  link->write(kOut, word_bytes("after"));
  expect_end(*link, kIn, UsbEnd::kStall);
  expect_bytes(*link, "after");
  EXPECT_EQ(server_->cleared_halts(), 1U);
  // The number of reads that wait is that of before.
  for (const char* word : {"1", "2", "3", "4", "5", "6"}) link->write(kOut, word_bytes(word));
  for (const char* word : {"1", "2", "3", "4", "5", "6"}) expect_bytes(*link, word);
  link->write(kOut, word_bytes("reject"));
  expect_end(*link, kOut, UsbEnd::kStall);
  link->write(kOut, word_bytes("7"));
  expect_bytes(*link, "7");
}

TEST_F(UsbipTest, AnOverflowCostsItsTransferOnly) {
  const auto link = open();
  link->keep_reading(kIn, 64, 4);
  link->write(kOut, word_bytes("babble"));
  link->write(kOut, word_bytes("fine"));
  expect_end(*link, kIn, UsbEnd::kOverflow);
  expect_bytes(*link, "fine");
}

TEST_F(UsbipTest, ADeviceThatIsNotExportedOrTakenIsGoneWithACause) {
  const auto other = open({0x1209, 0x0002});
  expect_end(*other, 0, UsbEnd::kGone);
  ASSERT_TRUE(other->failure());
  EXPECT_EQ(other->failure()->message, "the server exports no usb:1209:0002");
  const auto first = open();
  first->keep_reading(kIn, 64, 1);
  first->write(kOut, word_bytes("mine"));
  expect_bytes(*first, "mine");
  const auto second = open();
  expect_end(*second, 0, UsbEnd::kGone);
  EXPECT_STREQ(second->failure()->cause, "not_exported");
}

TEST_F(UsbipTest, AnUnpluggedDeviceIsGoneAndCanBeTakenAgain) {
  auto link = open();
  link->keep_reading(kIn, 64, 4);
  link->write(kOut, word_bytes("here"));
  expect_bytes(*link, "here");
  server_->unplug();
  expect_end(*link, 0, UsbEnd::kGone);
  link = open();
  expect_end(*link, 0, UsbEnd::kGone);
  server_->replug();
  link = open();
  link->keep_reading(kIn, 64, 4);
  link->write(kOut, word_bytes("again"));
  expect_bytes(*link, "again");
}

TEST_F(UsbipTest, DrainWaitsUntilAllIsSent) {
  const auto link = open();
  link->keep_reading(kIn, 64, 2);
  link->write(kOut, word_bytes("first"));
  expect_bytes(*link, "first");
  const std::uint64_t before = server_->transfers();
  for (int i = 0; i < 10; ++i) link->write(kOut, word_bytes("more"));
  link->drain(std::chrono::seconds(10));
  EXPECT_GE(server_->transfers(), before + 10);
}

/// Bytes that are no USB/IP end their connection and cost the others nothing.
TEST_F(UsbipTest, ForeignBytesEndTheirConnectionOnly) {
  const auto link = open();
  link->keep_reading(kIn, 64, 2);
  for (const char* words :
       {"GET / HTTP/1.1\r\n\r\n", "\x01\x11\x80\x03zzzz", "\x01\x11\x00\x00zzzz"}) {
    const auto socket = begin_tcp_connect(*resolve_tcp("127.0.0.1", server_->port()));
    ASSERT_TRUE(test::has_value(socket));
    std::array<Watched, 1> one{Watched{.fd = socket->get(), .write = true}};
    wait_for(one, std::chrono::seconds(5));
    (void)send_now(*socket, word_bytes(words));
    std::array<Watched, 1> end{Watched{.fd = socket->get(), .read = true}};
    wait_for(end, milliseconds(200));
  }
  link->write(kOut, word_bytes("still here"));
  expect_bytes(*link, "still here");
}

TEST(UsbipProtocolTest, AHeaderOfTheDocumentationIsReadAndWritten) {
  // CMD_SUBMIT of the kernel's documentation: number 13, device 0x00010002, IN of endpoint 1, 64
  // bytes, no isochronous packets.
  Bytes wire;
  for (const unsigned word : {1U, 13U, 0x00010002U, 1U, 1U, 0U, 64U, 0U, 0xFFFFFFFFU, 0U, 0U, 0U}) {
    for (int i = 3; i >= 0; --i) wire.push_back(static_cast<std::byte>(word >> (8 * i) & 0xFF));
  }
  const UsbipHeader header = read_usbip_header(wire);
  EXPECT_EQ(header.number, 13U);
  EXPECT_EQ(header.device, 0x00010002U);
  EXPECT_TRUE(header.is_in);
  EXPECT_EQ(header.endpoint, 1U);
  EXPECT_EQ(header.length, 64U);
  Bytes written;
  append_usbip_header(written, header);
  EXPECT_EQ(written, wire);
}

TEST(UsbipProtocolTest, ADeviceIsReadAsItWasWritten) {
  Bytes wire;
  append_usbip_device(wire, {.path = "/sys/x",
                             .bus_id = "3-2",
                             .bus = 3,
                             .device = 4,
                             .vendor = 0x0F44,
                             .product = 0xFF20,
                             .interfaces = 2});
  ASSERT_EQ(wire.size(), kUsbipDeviceBytes);
  const UsbipDevice device = read_usbip_device(wire);
  EXPECT_EQ(device.bus_id, "3-2");
  EXPECT_EQ(device.device, 4U);
  EXPECT_EQ(device.vendor, 0x0F44);
  EXPECT_EQ(device.product, 0xFF20);
  EXPECT_EQ(device.interfaces, 2);
}

TEST(UsbDescriptorsTest, AConfigurationStatesItsOwnLengthAndEndpoints) {
  const UsbDescription device{.vendor = 1, .product = 2, .endpoints = {{0x88}, {0x04}}};
  const auto bytes = usb_descriptor(device, 0x0200);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->size(), 9U + 9U + 7U + 7U);
  EXPECT_EQ((*bytes)[2], static_cast<std::byte>(bytes->size()));
  EXPECT_EQ((*bytes)[20], std::byte{0x88});
  EXPECT_FALSE(usb_descriptor(device, 0x0304));
  EXPECT_FALSE(usb_descriptor(device, 0x2200));
}

}  // namespace
}  // namespace nav::devices
