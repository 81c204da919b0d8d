// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <gtest/gtest.h>
#include <linux/input.h>
#include <regex>
#include <set>

#include "devices/buttons/button_filter.hpp"
#include "devices/buttons/evdev_codec.hpp"
#include "devices/buttons/input_device.hpp"
#include "devices/can/can_button_source.hpp"
#include "devices/usb/interson_codec.hpp"
#include "devices/usb/polhemus_codec.hpp"
#include "devices/usb/usb_link.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::devices {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

Timestamp at_ms(int ms) { return Timestamp(milliseconds(ms)); }

/// Bytes of events as the documentation of the kernel lays them out (little endian, 64 bits): time
/// in seconds and microseconds, type, code, value.
std::vector<std::byte> raw_event(std::uint64_t s, std::uint64_t us, unsigned type, unsigned code,
                                 std::uint32_t value) {
  std::vector<std::byte> bytes;
  const auto put = [&](std::uint64_t number, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(number >> (8 * i)));
  };
  put(s, 8);
  put(us, 8);
  put(type, 2);
  put(code, 2);
  put(value, 4);
  return bytes;
}

std::vector<EvdevNews> news_of(EvdevParser& parser, std::span<const std::byte> bytes) {
  std::vector<EvdevNews> all;
  parser.take(bytes, [&](const EvdevNews& news) { all.push_back(news); });
  return all;
}

TEST(EvdevCodecTest, ReadsTheLayoutOfTheKernel) {
  const auto bytes = raw_event(12, 345678, EV_KEY, BTN_1, 1);
  ASSERT_EQ(bytes.size(), kEvdevBytes);
  const EvdevEvent event = decode_evdev(std::span<const std::byte, kEvdevBytes>(bytes));
  EXPECT_EQ(event, (EvdevEvent{microseconds(12'345'678), EV_KEY, 0x101, 1}));
  const auto back = encode_evdev(event);
  EXPECT_TRUE(std::ranges::equal(back, bytes));
}

TEST(EvdevCodecTest, APressIsReadFromBytesThatComeOneByOne) {
  EvdevParser parser;
  std::vector<EvdevNews> all;
  for (const auto& event :
       {raw_event(1, 0, EV_MSC, MSC_SCAN, 0x90001), raw_event(1, 0, EV_KEY, BTN_0, 1),
        raw_event(1, 0, EV_SYN, 0, 0), raw_event(1, 250'000, EV_KEY, BTN_0, 2),  // Repeat.
        raw_event(2, 0, EV_KEY, BTN_0, 0), raw_event(2, 0, EV_SYN, 0, 0)}) {
    for (const std::byte& one : event) {
      for (const EvdevNews& news : news_of(parser, std::span(&one, 1))) all.push_back(news);
    }
  }
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].kind, EvdevNews::Kind::kDown);
  EXPECT_EQ(all[0].key, BTN_0);
  EXPECT_EQ(all[0].time, microseconds(1'000'000));
  EXPECT_EQ(all[1].kind, EvdevNews::Kind::kUp);
}

TEST(EvdevCodecTest, NothingBetweenALossAndItsReportIsUsed) {
  EvdevParser parser;
  std::vector<std::byte> bytes;
  for (const auto& event :
       {raw_event(1, 0, EV_SYN, SYN_DROPPED, 0), raw_event(1, 0, EV_KEY, BTN_0, 1),
        raw_event(1, 0, EV_SYN, SYN_REPORT, 0), raw_event(1, 0, EV_KEY, BTN_1, 1)}) {
    bytes.insert(bytes.end(), event.begin(), event.end());
  }
  const auto all = news_of(parser, bytes);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].kind, EvdevNews::Kind::kLost);
  EXPECT_EQ(all[1].key, BTN_1);
}

TEST(EvdevCodecTest, ImpossibleEventsAreNamedAndForeignOnesPassedOver) {
  EvdevParser parser;
  const auto kind_of = [&](const std::vector<std::byte>& event) {
    const auto news = news_of(parser, event);
    return news.empty() ? std::optional<EvdevNews::Kind>() : news.front().kind;
  };
  EXPECT_EQ(kind_of(raw_event(1, 0, EV_KEY, BTN_0, 7)), EvdevNews::Kind::kMalformed);
  EXPECT_EQ(kind_of(raw_event(1, 0, EV_KEY, 0x300, 1)), EvdevNews::Kind::kMalformed);
  EXPECT_FALSE(kind_of(raw_event(1, 0, EV_REL, REL_X, 1)));
  EXPECT_FALSE(kind_of(raw_event(1, 0, 0xFFFF, 1, 1)));
  // Times that no kernel gives do not overflow.
  EXPECT_EQ(kind_of(raw_event(~0ULL >> 1, ~0ULL >> 1, EV_KEY, BTN_0, 1)), EvdevNews::Kind::kDown);
}

TEST(EvdevCodecTest, KeysHaveTheNamesOfTheKernelOrNumbers) {
  EXPECT_EQ(evdev_key("BTN_0"), 0x100);
  EXPECT_EQ(evdev_key("KEY_B"), 48);
  EXPECT_EQ(evdev_key("256"), 0x100);
  EXPECT_EQ(evdev_key("0x101"), 0x101);
  for (const char* wrong : {"", "BTN", "768", "0x", "-1", "1 ", "KEY_QUIT"}) {
    EXPECT_FALSE(evdev_key(wrong)) << wrong;
  }
  EXPECT_EQ(evdev_key_name(0x100), "BTN_0");
  EXPECT_EQ(evdev_key_name(700), "700");
}

TEST(ButtonFilterTest, TwoPressesWithin150MsCountOnce) {
  ButtonFilter filter;
  EXPECT_EQ(filter.take(false, at_ms(0)), ButtonChange::kNone);
  EXPECT_EQ(filter.take(true, at_ms(10)), ButtonChange::kChange);
  EXPECT_EQ(filter.take(true, at_ms(11)), ButtonChange::kNone);
  EXPECT_EQ(filter.take(false, at_ms(20)), ButtonChange::kChange);
  EXPECT_EQ(filter.take(true, at_ms(159)), ButtonChange::kBounce);
  EXPECT_EQ(filter.take(false, at_ms(165)), ButtonChange::kNone);
  EXPECT_EQ(filter.take(true, at_ms(166)), ButtonChange::kChange);
  filter.forget();
  EXPECT_FALSE(filter.pressed());
  EXPECT_EQ(filter.take(false, at_ms(400)), ButtonChange::kNone);
}

struct SysInput {
  void add(const std::string& node, const std::string& vendor, const std::string& product,
           const std::string& keys) const {
    const auto device = folder / node / "device";
    std::filesystem::create_directories(device / "id");
    std::filesystem::create_directories(device / "capabilities");
    std::ofstream(device / "id/vendor") << vendor << '\n';
    std::ofstream(device / "id/product") << product << '\n';
    std::ofstream(device / "capabilities/key") << keys << '\n';
  }
  [[nodiscard]] Result<std::filesystem::path> find(std::vector<std::uint16_t> keys) const {
    return find_input({0x0c45, 0x7403}, keys, folder.path(), "/dev/input");
  }
  test::TemporaryFolder folder;
};

TEST(InputDeviceTest, FindsTheNodeWithTheKeysAmongThoseOfADevice) {
  const SysInput sys;
  sys.add("event2", "0c45", "7403", "0");                             // Its mouse, say.
  sys.add("event3", "0c45", "7403", "ffff 0 0 0 0 1000000000000 0");  // Has other keys.
  sys.add("event4", "0c45", "7403", "7 0 0 0 0");                     // BTN_0 to BTN_2: word 4.
  sys.add("event5", "05f3", "00ff", "7 0 0 0 0");
  sys.add("mouse0", "0c45", "7403", "7 0 0 0 0");
  const auto found = sys.find({BTN_0, BTN_1});
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(*found, "/dev/input/event4");
}

TEST(InputDeviceTest, NamesWhatIsMissingOrAmbiguous) {
  const SysInput sys;
  EXPECT_TRUE(test::rejects(sys.find({BTN_0}), ErrorCode::kNotFound, {"hid:0c45:7403", "plug it"}));
  sys.add("event4", "0c45", "7403", "7 0 0 0 0");
  EXPECT_TRUE(test::rejects(sys.find({KEY_A}), ErrorCode::kUnavailable,
                            {"hid:0c45:7403", "keys of the buttons", "event4"}));
  sys.add("event9", "0c45", "7403", "7 0 0 0 0");
  EXPECT_TRUE(test::rejects(sys.find({BTN_0}), ErrorCode::kUnavailable,
                            {"/dev/input/event4", "/dev/input/event9", "input:"}));
}

TEST(InputDeviceTest, AFileThatIsNoInputDeviceOrNotThereIsNamed) {
  const test::TemporaryFolder folder;
  const auto file = folder / "file";
  EXPECT_TRUE(test::rejects(open_input(file), ErrorCode::kNotFound, {file.string(), "plug it in"}));
  std::ofstream(file) << "x";
  EXPECT_TRUE(test::rejects(open_input(file), ErrorCode::kUnavailable,
                            {file.string(), "expected an input device", "another file"}));
  if (::geteuid() == 0) return;  // Root may read everything.
  std::filesystem::permissions(file, std::filesystem::perms::none);
  EXPECT_TRUE(test::rejects(open_input(file), ErrorCode::kUnavailable,
                            {file.string(), "permission denied", "70-sonde.rules"}));
}

TEST(CanButtonTest, ReadsOneBitOfOneFrame) {
  CanButton button{.name = "left", .frame = 0x18A, .byte = 1, .bit = 3};
  CanFrame frame{.id = 0x18A, .size = 2, .data = {0xFF, 0x08}};
  EXPECT_EQ(read_can_button(button, frame), CanButtonReading::kDown);
  frame.data[1] = 0xF7;
  EXPECT_EQ(read_can_button(button, frame), CanButtonReading::kUp);
  button.pressed_when_zero = true;
  EXPECT_EQ(read_can_button(button, frame), CanButtonReading::kDown);
  frame.size = 1;
  EXPECT_EQ(read_can_button(button, frame), CanButtonReading::kShort);
  for (auto change :
       {+[](CanFrame& f) { f.id = 0x18B; }, +[](CanFrame& f) { f.extended = true; },
        +[](CanFrame& f) { f.remote = true; }, +[](CanFrame& f) { f.error = true; }}) {
    CanFrame other = frame;
    change(other);
    EXPECT_EQ(read_can_button(button, other), CanButtonReading::kForeign);
  }
}

TEST(CanButtonTest, ImpossibleOptionsAreNamed) {
  const auto with = [](auto change) {
    CanButtonOptions options{.buttons = {{.name = "left", .frame = 0x18A}}};
    change(options);
    return validate(options);
  };
  EXPECT_TRUE(test::has_value(with([](auto&) {})));
  const auto bad = [&](auto change, std::initializer_list<std::string> words) {
    EXPECT_TRUE(test::rejects(with(change), ErrorCode::kUsage, words));
  };
  bad([](auto& o) { o.buttons.clear(); }, {"at least one button"});
  bad([](auto& o) { o.buttons[0].frame = 0x800; }, {"'left'", "2047", "2048", "extended"});
  bad([](auto& o) { o.buttons[0].byte = 8; }, {"byte of 'left'", "0 to 7", "8"});
  bad([](auto& o) { o.buttons[0].bit = -1; }, {"bit of 'left'", "-1"});
  bad([](auto& o) { o.buttons.push_back(o.buttons[0]); }, {"name of its own", "left"});
  bad([](auto& o) { o.buttons.push_back({.name = "right", .frame = 0x18A}); },
      {"bit of its own", "'right'"});
}

/// Each line of the rules tags the files of one device: the event file of a foot switch, or the USB
/// device of an adapter.
TEST(UdevRulesTest, EveryRuleGivesAccessToOneDevice) {
  std::ifstream file(std::filesystem::path(SONDE_SOURCE_DIR) / "share/udev/70-sonde.rules");
  ASSERT_TRUE(file);
  const std::regex rule(
      R"rule(SUBSYSTEM=="input", KERNEL=="event\*", ATTRS\{idVendor\}=="([0-9a-f]{4})", )rule"
      R"rule(ATTRS\{idProduct\}=="([0-9a-f]{4})", TAG\+="uaccess")rule");
  const std::regex usb_rule(
      R"rule(SUBSYSTEM=="usb", ENV\{DEVTYPE\}=="usb_device", ATTR\{idVendor\}=="([0-9a-f]{4})", )rule"
      R"rule(ATTR\{idProduct\}=="([0-9a-f]{4})", TAG\+="uaccess")rule");
  std::set<std::string> ids, usb_ids;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::smatch found;
    if (std::regex_match(line, found, usb_rule)) {
      EXPECT_TRUE(usb_ids.insert("usb:" + found[1].str() + ":" + found[2].str()).second) << line;
      continue;
    }
    ASSERT_TRUE(std::regex_match(line, found, rule)) << line;
    EXPECT_TRUE(ids.insert(found[1].str() + ":" + found[2].str()).second) << line;
  }
  EXPECT_TRUE(ids.contains("05f3:00ff"));
  EXPECT_TRUE(ids.contains("0c45:7403"));
  EXPECT_EQ(usb_ids, (std::set<std::string>{usb_name({kPolhemusVendor, kLibertyProduct}),
                                            usb_name({kIntersonVendor, kSeeMoreProduct})}));
}

}  // namespace
}  // namespace nav::devices
