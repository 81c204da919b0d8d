// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

/// Commands and folders of the machine that tests/kernel/machine.py boots.
namespace nav::kernel {

/// Exit status of a command of the shell; 128: it did not end by itself.
inline int shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return status >= 0 && WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// A variable of the environment that jobs.sh sets.
inline std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  if (value == nullptr) ADD_FAILURE() << name << " is not set: run this in tests/kernel/jobs.sh";
  return value == nullptr ? "" : value;
}

/// Folder whose files are read when the machine has ended.
inline std::filesystem::path results() { return variable("OUT"); }

/// A virtual CAN interface, which is up. It is removed by the destructor.
class VirtualBus {
 public:
  explicit VirtualBus(std::string name = "vcan0") : name_(std::move(name)) { add(); }
  ~VirtualBus() { shell("ip link delete " + name_ + " 2>/dev/null"); }
  VirtualBus(const VirtualBus&) = delete;
  VirtualBus& operator=(const VirtualBus&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  void add() const {
    EXPECT_EQ(shell("ip link add dev " + name_ + " type vcan"), 0);
    up();
  }
  void up() const { EXPECT_EQ(shell("ip link set " + name_ + " up"), 0); }
  void down() const { EXPECT_EQ(shell("ip link set " + name_ + " down"), 0); }
  void remove() const { EXPECT_EQ(shell("ip link delete " + name_), 0); }

 private:
  std::string name_;
};

}  // namespace nav::kernel
