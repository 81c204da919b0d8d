// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/inventory.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::devices {
namespace {

void add_interface(const std::filesystem::path& net, const std::string& name, int type,
                   const std::string& flags) {
  std::filesystem::create_directories(net / name);
  std::ofstream(net / name / "type") << type << '\n';
  std::ofstream(net / name / "flags") << flags << '\n';
}

TEST(InventoryTest, FindsOnlyCanInterfacesAndTheirState) {
  const test::TemporaryFolder net;
  add_interface(net.path(), "vcan1", 280, "0x40080");
  add_interface(net.path(), "can0", 280, "0x40081");
  add_interface(net.path(), "eth0", 1, "0x1003");
  add_interface(net.path(), "lo", 772, "0x9");
  const auto found = list_can(net.path());
  ASSERT_TRUE(test::has_value(found));
  ASSERT_EQ(found->size(), 2u);
  EXPECT_EQ((*found)[0].name, "can0");
  EXPECT_TRUE((*found)[0].up);
  EXPECT_EQ((*found)[1].name, "vcan1");
  EXPECT_FALSE((*found)[1].up);
}

TEST(InventoryTest, ReportsAMissingNetworkFolder) {
  EXPECT_TRUE(
      test::rejects(list_can("/nonexistent/net"), ErrorCode::kUnavailable, {"/nonexistent/net"}));
}

TEST(InventoryTest, FindsSerialPortsVideoAndInputAndWhyTheyCannotBeOpened) {
  const test::TemporaryFolder root;
  const auto sys = root.path() / "class", dev = root.path() / "dev";
  const auto add = [&](const std::string& path, const std::string& text) {
    std::filesystem::create_directories((sys / path).parent_path());
    std::ofstream(sys / path) << text << '\n';
  };
  const auto driven = [&](const std::string& tty, const std::string& driver) {
    std::filesystem::create_directories(sys / "tty" / tty / "device");
    std::filesystem::create_directory_symlink("../drivers/" + driver,
                                              sys / "tty" / tty / "device/driver");
  };
  driven("ttyUSB0", "ftdi_sio");
  driven("ttyS0", "serial8250");
  add("tty/ttyS0/type", "4");
  driven("ttyS1", "serial8250");
  add("tty/ttyS1/type", "0");
  std::filesystem::create_directories(sys / "tty/tty1");
  add("video4linux/video0/name", "USB grabber");
  add("input/event3/device/name", "PCsensor FootSwitch");
  add("input/mouse0/device/name", "Mouse");
  std::filesystem::create_directories(dev / "input");
  std::ofstream(dev / "ttyUSB0") << "x";
  const auto found = list_nodes(sys, dev);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].path, dev / "ttyS0");
  EXPECT_EQ(found[0].trouble, "No such file or directory");
  EXPECT_EQ(found[1].path, dev / "ttyUSB0");
  EXPECT_EQ(found[1].name, "ftdi_sio");
  EXPECT_EQ(found[1].trouble, "");
  EXPECT_EQ(found[2].name, "USB grabber");
  EXPECT_EQ(found[3].path, dev / "input/event3");
  EXPECT_EQ(found[3].name, "PCsensor FootSwitch");
  EXPECT_TRUE(list_nodes(root.path() / "none", dev).empty());
}

/// Expects a list, or an error message that says why this machine has none.
template <class T>
void expect_list_or_reason(const Result<T>& found) {
  if (found) return;
  EXPECT_EQ(found.error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(found.error().message.empty());
}

TEST(InventoryTest, ListsTheInterfacesOfThisMachineOrReportsTheReason) {
  expect_list_or_reason(list_can());
  expect_list_or_reason(list_usb());
}

}  // namespace
}  // namespace nav::devices
