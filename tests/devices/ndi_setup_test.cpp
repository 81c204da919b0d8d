// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_setup.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "devices/ndi/ndi_encode.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "tests/support/test_data.hpp"

namespace nav::devices {
namespace {

/// Gives the current command the reply with this text, and returns the command's name.
std::string answer_with(NdiSetup& setup, const std::string& text) {
  const std::string command = setup.step()->command;
  const auto bytes = ndi_text_reply(text);
  setup.take(frame_ndi_reply(bytes).reply);
  return command.substr(0, command.find(':'));
}

TEST(NdiSetupTest, AsksInOrderAndRaisesTheSpeedBeforeTheTools) {
  NdiSetup setup({{.name = "Needle"}}, 115200);
  EXPECT_EQ(answer_with(setup, "ERROR0C"), "TSTOP") << "an error is expected here";
  EXPECT_EQ(answer_with(setup, "OKAY"), "INIT");
  EXPECT_EQ(answer_with(setup, "Aurora Control Firmware\nNDI S/N: A3-00142\n"), "VER");
  EXPECT_EQ(setup.step()->baud, 115200);
  EXPECT_FALSE(setup.step()->repeatable);
  EXPECT_EQ(answer_with(setup, "ERROR06"), "COMM");
  EXPECT_EQ(setup.step()->baud, 57600) << "the next lower rate";
  EXPECT_EQ(answer_with(setup, "OKAY"), "COMM");
  EXPECT_EQ(answer_with(setup, "00"), "PHSR");
  EXPECT_EQ(answer_with(setup, "010A000"), "PHSR");
  EXPECT_EQ(answer_with(setup, "OKAY"), "PHF");
  EXPECT_EQ(answer_with(setup, "010B001"), "PHSR");
  EXPECT_EQ(answer_with(setup, "WARNING"), "PINIT");
  EXPECT_EQ(answer_with(setup, "00"), "PHSR") << "initialising may show other ports";
  EXPECT_EQ(answer_with(setup, "010B011"), "PHSR");
  EXPECT_EQ(answer_with(setup, "02000000Traxtal Tech0003408D4083FA3-00142100200"), "PHINF");
  EXPECT_EQ(setup.step()->command.substr(0, 8), "PENA:0BD");
  EXPECT_EQ(answer_with(setup, "OKAY"), "PENA");
  EXPECT_EQ(answer_with(setup, "OKAY"), "TSTART");
  EXPECT_EQ(setup.step(), nullptr);
  EXPECT_FALSE(setup.failure());
  EXPECT_EQ(setup.tools()[0].handle, 0x0B);
  EXPECT_EQ(setup.version().serial, "A3-00142");
  ASSERT_EQ(setup.notes().size(), 2U);
}

TEST(NdiSetupTest, SaysWhyTrackingCannotBegin) {
  NdiSetup setup({{.name = "Needle"}}, 0);
  answer_with(setup, "OKAY");
  answer_with(setup, "ERROR15");
  EXPECT_EQ(setup.step(), nullptr);
  ASSERT_TRUE(setup.failure());
  EXPECT_NE(setup.failure()->find("error 15"), std::string::npos);
}

/// Replies that a tracker could give to some command, and nonsense.
TEST(NdiSetupTest, EndsWhateverTheTrackerAnswers) {
  constexpr int kSetups = 3000;
  constexpr int kMostSteps = 20'000;
  const test::TemporaryFolder folder;
  std::ofstream(folder / "tool.rom", std::ios::binary) << std::string("NDI\0\x03\0\x01\x02", 8);
  const std::vector<std::string> replies = {"OKAY",
                                            "OKAY",
                                            "OKAY",
                                            "WARNING",
                                            "ERROR13",
                                            "00",
                                            "01",
                                            "0A",
                                            "010A011",
                                            "020A0010B031",
                                            "0201",
                                            "UNOCCUPIED",
                                            "02000000Traxtal Tech0003408D4083FA3-00142100200",
                                            "",
                                            "RESET"};
  std::mt19937_64 random(48);
  for (int i = 0; i < kSetups; ++i) {
    NdiSetup setup({{.name = "A", .rom = folder / "tool.rom"},
                    {.name = "B"},
                    {.name = "C", .rom = folder / "absent.rom"},
                    {.name = "D", .place = NdiPlace{.port = 2}}},
                   921600);
    int steps = 0;
    for (; setup.step() != nullptr && steps < kMostSteps; ++steps) {
      answer_with(setup, replies[random() % replies.size()]);
      if (setup.step() == nullptr && !setup.failure() && random() % 4 == 0) setup.look_again();
    }
    EXPECT_LT(steps, kMostSteps);
    EXPECT_FALSE(setup.tools()[2].handle);
  }
}

}  // namespace
}  // namespace nav::devices
