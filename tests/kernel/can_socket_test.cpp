// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_socket.hpp"

#include <array>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <thread>

#include "tests/kernel/commands.hpp"
#include "tests/support/matchers.hpp"

/// The socket on a virtual interface of a real kernel.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kFrameCertainly = seconds(20);  ///< Wait for what is certain to happen.
const std::vector<CanFilter> kAllShort{{.id = 0, .mask = 0}};

CanFrame frame_of(std::uint32_t id, std::uint8_t size = 8) {
  CanFrame frame{.id = id, .size = size};
  for (std::uint8_t i = 0; i < size; ++i) frame.data[i] = static_cast<std::uint8_t>(0x10 + i);
  return frame;
}

CanFrame extended_of(std::uint32_t id) {
  CanFrame frame = frame_of(id, 3);
  frame.extended = true;
  return frame;
}

class CanSocketKernelTest : public ::testing::Test {
 protected:
  FileDescriptor open(const std::vector<CanFilter>& filters = kAllShort) {
    auto opened = open_can(bus_.name(), filters);
    EXPECT_TRUE(test::has_value(opened));
    return opened ? *std::move(opened) : FileDescriptor();
  }
  /// The next outcome of a receive that is not "nothing is there".
  static CanReceive next(const FileDescriptor& socket, Duration longest = kFrameCertainly) {
    std::array<Watched, 1> one{Watched{.fd = socket.get(), .read = true}};
    wait_for(one, longest);
    return receive_can(socket);
  }
  static void expect_frame(const FileDescriptor& socket, const CanFrame& frame) {
    const CanReceive got = next(socket);
    ASSERT_TRUE(got.received);
    EXPECT_EQ(got.received->frame, frame);
  }
  static void expect_sent(const FileDescriptor& socket, const CanFrame& frame) {
    const CanSend sent = send_can(socket, frame);
    EXPECT_FALSE(sent.full);
    EXPECT_FALSE(sent.failure) << sent.failure->message;
  }
  kernel::VirtualBus bus_;
};

TEST_F(CanSocketKernelTest, CarriesStandardAndExtendedFrames) {
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open({{.id = 0, .mask = 0}, {.mask = 0, .extended = true}});
  for (const CanFrame& frame : {frame_of(0x000, 0), frame_of(0x7FF), extended_of(0x1FFFFFFF)}) {
    expect_sent(sender, frame);
    expect_frame(receiver, frame);
  }
  EXPECT_FALSE(receive_can(sender).received) << "a socket does not hear itself";
}

TEST_F(CanSocketKernelTest, TheKernelFiltersByIdentifierAndKind) {
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open({{.id = 0x180, .mask = 0x7F0}});
  CanFrame remote{.id = 0x185, .remote = true};
  for (const CanFrame& other : {frame_of(0x285), extended_of(0x185), remote, frame_of(0x190)}) {
    expect_sent(sender, other);
  }
  expect_sent(sender, frame_of(0x18F));
  expect_frame(receiver, frame_of(0x18F));  // The first that came: none of the others passed.
}

TEST_F(CanSocketKernelTest, AFrameOfCanFdDoesNotDisturbAClassicSocket) {
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open();
  FileDescriptor flexible(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  const int on = 1;
  ASSERT_EQ(::setsockopt(flexible.get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on), 0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(bus_.name().c_str()));
  ASSERT_EQ(::bind(flexible.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  canfd_frame frame{};
  frame.can_id = 0x185;
  frame.len = 64;
  ASSERT_EQ(::write(flexible.get(), &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
  expect_sent(sender, frame_of(0x185));
  const CanReceive got = next(receiver);
  EXPECT_FALSE(got.malformed);
  ASSERT_TRUE(got.received);
  EXPECT_EQ(got.received->frame, frame_of(0x185));
}

TEST_F(CanSocketKernelTest, ErrorFramesPassEveryFilterWithTheirCauses) {
  const FileDescriptor controller = open();
  const FileDescriptor receiver = open({{.id = 0x180, .mask = 0x7FF}});
  CanFrame error{.id = CAN_ERR_BUSOFF | CAN_ERR_CRTL, .error = true, .size = CAN_ERR_DLC};
  error.data[1] = CAN_ERR_CRTL_TX_PASSIVE;
  expect_sent(controller, error);
  const CanReceive got = next(receiver);
  ASSERT_TRUE(got.received);
  EXPECT_TRUE(got.received->frame.error);
  EXPECT_THAT(
      can_error_causes(got.received->frame),
      ::testing::ElementsAre(::testing::StrEq("bus_off"), ::testing::StrEq("error_passive")));
}

TEST_F(CanSocketKernelTest, FramesThatAFullQueueLosesAreCounted) {
  constexpr std::uint32_t kSent = 5000;
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open();
  for (std::uint32_t i = 0; i < kSent; ++i) expect_sent(sender, frame_of(i % 0x800));
  std::uint32_t received = 0, dropped = 0;
  const auto take_all = [&] {
    for (CanReceive got = receive_can(receiver); got.received; got = receive_can(receiver)) {
      ++received;
      dropped = got.received->dropped;
    }
  };
  take_all();
  EXPECT_LT(received, kSent) << "the queue took them all: nothing was tested";
  EXPECT_EQ(dropped, 0U) << "the frames in the queue came before the first that was lost";
  expect_sent(sender, frame_of(1));  // The count comes with the next frame.
  take_all();
  EXPECT_GT(dropped, 0U);
  EXPECT_EQ(received + dropped, kSent + 1);
}

TEST_F(CanSocketKernelTest, TheAgeCountsFromTheStampOfTheKernel) {
  constexpr Duration kInQueue = milliseconds(50);
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open();
  // The kernel begins to stamp a moment after the first socket has asked for it; until then a frame
  // has the time at which it is read.
  Duration age{0};
  for (int i = 0; i < 100 && age < kInQueue; ++i) {
    expect_sent(sender, frame_of(1));
    std::this_thread::sleep_for(kInQueue);
    const CanReceive got = next(receiver);
    ASSERT_TRUE(got.received);
    age = got.received->age;
  }
  EXPECT_GE(age, kInQueue);
}

TEST_F(CanSocketKernelTest, AnInterfaceThatIsDownIsNamedAndServesAgainWhenItIsUp) {
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open();
  bus_.down();
  const CanReceive got = next(receiver);
  ASSERT_TRUE(got.failure);
  EXPECT_STREQ(got.failure->cause, "interface_down");
  const CanSend sent = send_can(sender, frame_of(1));
  ASSERT_TRUE(sent.failure);
  EXPECT_STREQ(sent.failure->cause, "interface_down");
  bus_.up();
  (void)receive_can(sender);  // Its own notice that the interface went down.
  expect_sent(sender, frame_of(2));
  expect_frame(receiver, frame_of(2));
}

TEST_F(CanSocketKernelTest, AnInterfaceThatIsRemovedIsGone) {
  const FileDescriptor sender = open();
  const FileDescriptor receiver = open();
  bus_.remove();
  const CanReceive got = next(receiver);
  ASSERT_TRUE(got.failure);
  EXPECT_STREQ(got.failure->cause, "interface_gone");
  const CanSend sent = send_can(sender, frame_of(1));
  ASSERT_TRUE(sent.failure);
  EXPECT_STREQ(sent.failure->cause, "interface_gone");
  EXPECT_TRUE(test::rejects(open_can(bus_.name(), kAllShort), ErrorCode::kNotFound, {"vcan0"}));
  bus_.add();
  EXPECT_TRUE(open().is_open());
}

TEST_F(CanSocketKernelTest, AnInterfaceOfAnotherKindIsRejected) {
  EXPECT_TRUE(test::rejects(open_can("lo", kAllShort), ErrorCode::kNotFound,
                            {"lo", "expected a CAN interface"}));
}

}  // namespace
}  // namespace nav::devices
