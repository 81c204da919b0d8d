// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/can/error.h>
#include <linux/tty.h>
#include <mutex>
#include <net/if.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <thread>
#include <unistd.h>

#include "devices/can/can_socket.hpp"
#include "tests/kernel/commands.hpp"
#include "tests/support/matchers.hpp"

/// A CAN adapter at a serial line (slcan): the test is the adapter, at the other end of a pseudo
/// terminal, so that the kernel's own driver makes the interface and its error frames.
namespace nav::devices {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kAdapterCertainly = seconds(20);  ///< Wait for what is certain to happen.

/// An adapter that the kernel has as a CAN interface. One thread reads what the kernel sends.
class SerialAdapter {
 public:
  SerialAdapter() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    std::array<char, 64> path{};
    EXPECT_EQ(::grantpt(master_.get()) + ::unlockpt(master_.get()), 0);
    EXPECT_EQ(::ptsname_r(master_.get(), path.data(), path.size()), 0);
    line_ = FileDescriptor(::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    termios settings{};
    ::tcgetattr(line_.get(), &settings);
    ::cfmakeraw(&settings);
    ::tcsetattr(line_.get(), TCSANOW, &settings);
    int discipline = N_SLCAN;
    EXPECT_EQ(::ioctl(line_.get(), TIOCSETD, &discipline), 0) << "the kernel has no slcan";
    std::array<char, IFNAMSIZ> name{};
    EXPECT_EQ(::ioctl(line_.get(), SIOCGIFNAME, name.data()), 0);
    name_ = name.data();
    thread_ = std::jthread([this](const std::stop_token& stop) { read(stop); });
    EXPECT_EQ(kernel::shell("ip link set " + name_ + " up type can bitrate 500000"), 0);
  }
  ~SerialAdapter() { unplug(); }
  SerialAdapter(const SerialAdapter&) = delete;
  SerialAdapter& operator=(const SerialAdapter&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Sends a line to the kernel, as the adapter does.
  void say(const std::string& line) const {
    const std::string bytes = line + "\r";
    EXPECT_EQ(::write(master_.get(), bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
  }
  /// True if the kernel has sent this line, or does in time.
  [[nodiscard]] bool hears(const std::string& line) const {
    for (Duration waited{0}; waited < kAdapterCertainly; waited += milliseconds(10)) {
      {
        const std::lock_guard lock(mutex_);
        if (("\r" + heard_).find("\r" + line + "\r") != std::string::npos) return true;
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }
  /// Reads nothing more, or goes on.
  void stall(bool stalled) { stalled_ = stalled; }
  void unplug() {
    thread_ = {};
    line_.close();
    master_.close();
  }

 private:
  void read(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::array<Watched, 1> one{Watched{.fd = stalled_ ? -1 : master_.get(), .read = true}};
      wait_for(one, milliseconds(10));
      if (stalled_ || !one[0].read) continue;
      std::array<char, 256> bytes{};
      const ssize_t got = ::read(master_.get(), bytes.data(), bytes.size());
      const std::lock_guard lock(mutex_);
      if (got > 0) heard_.append(bytes.data(), static_cast<std::size_t>(got));
    }
  }

  FileDescriptor master_, line_;
  std::string name_;
  std::atomic<bool> stalled_ = false;
  mutable std::mutex mutex_;  ///< Guards heard_.
  std::string heard_;
  std::jthread thread_;
};

class SlcanKernelTest : public ::testing::Test {
 protected:
  SlcanKernelTest() {
    auto opened = open_can(adapter_.name(), {{.id = 0, .mask = 0}});
    EXPECT_TRUE(test::has_value(opened));
    if (opened) socket_ = *std::move(opened);
  }
  [[nodiscard]] CanReceive next() const {
    std::array<Watched, 1> one{Watched{.fd = socket_.get(), .read = true}};
    wait_for(one, kAdapterCertainly);
    return receive_can(socket_);
  }
  /// Causes of the error frame that a line of the adapter makes.
  [[nodiscard]] std::vector<std::string> causes_of(const std::string& line) const {
    adapter_.say(line);
    const CanReceive got = next();
    if (!got.received) return {"no frame"};
    const auto causes = can_error_causes(got.received->frame);
    return {causes.begin(), causes.end()};
  }
  SerialAdapter adapter_;
  FileDescriptor socket_;
};

TEST_F(SlcanKernelTest, FramesGoThroughTheAdapterBothWays) {
  EXPECT_TRUE(adapter_.hears("S6")) << "the bit rate was not set";
  EXPECT_TRUE(adapter_.hears("O")) << "the bus was not opened";
  EXPECT_FALSE(send_can(socket_, {.id = 0x123, .size = 2, .data = {0xAB, 0xCD}}).failure);
  EXPECT_TRUE(adapter_.hears("t1232ABCD"));
  adapter_.say("t18531122FF");
  const CanReceive got = next();
  ASSERT_TRUE(got.received);
  EXPECT_EQ(got.received->frame, (CanFrame{.id = 0x185, .size = 3, .data = {0x11, 0x22, 0xFF}}));
}

TEST_F(SlcanKernelTest, ErrorsOfTheAdapterAreNamed) {
  using ::testing::Contains;
  EXPECT_THAT(causes_of("e1a"), Contains("no_ack"));
  EXPECT_THAT(causes_of("e1c"), Contains("protocol_error"));
  EXPECT_THAT(causes_of("e1o"), Contains("receive_overflow"));
  EXPECT_THAT(causes_of("sw100020"), Contains("error_warning"));
  EXPECT_THAT(causes_of("sp130020"), Contains("error_passive"));
  EXPECT_THAT(causes_of("sb256256"), Contains("bus_off"));
}

TEST_F(SlcanKernelTest, AQueueThatIsFullTakesNoFramesUntilTheAdapterReadsAgain) {
  adapter_.stall(true);
  bool full = false;
  for (int i = 0; i < 100000 && !full; ++i) {
    const CanSend sent = send_can(socket_, {.id = 1, .size = 8});
    ASSERT_FALSE(sent.failure) << sent.failure->message;
    full = sent.full;
  }
  EXPECT_TRUE(full);
  adapter_.stall(false);
  bool taken = false;
  for (int i = 0; i < 1000 && !taken; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    taken = !send_can(socket_, {.id = 0x7AB, .size = 0}).full;
  }
  EXPECT_TRUE(taken);
  EXPECT_TRUE(adapter_.hears("t7AB0"));
}

TEST_F(SlcanKernelTest, AnAdapterThatIsUnpluggedIsNamed) {
  adapter_.unplug();
  CanReceive got = next();
  // The interface goes down before it goes.
  if (got.failure && std::string(got.failure->cause) == "interface_down") got = next();
  ASSERT_TRUE(got.failure);
  EXPECT_STREQ(got.failure->cause, "interface_gone");
}

}  // namespace
}  // namespace nav::devices
