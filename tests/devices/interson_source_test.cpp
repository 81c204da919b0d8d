// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_source.hpp"

#include <gtest/gtest.h>

#include "tests/devices/source_bench.hpp"
#include "tests/devices/usb_rigs.hpp"
#include "tests/support/matchers.hpp"

/// The source meets the emulated probe by USB/IP, without a kernel that has USB.
namespace nav::devices {
namespace {

struct IntersonBench : SourceBench<IntersonSource> {
  IntersonBench() : emulator(emulated_see_more()) {}
  void start() {
    source =
        *IntersonSource::create(see_more_options(), "probe",
                                usbip_opener(emulator->server(), kSeeMoreId), clock, diagnostics);
  }
  std::uint64_t bad(const std::string& cause) const {
    const auto health = source->health();
    const auto found = health.bad_messages.find(cause);
    return found == health.bad_messages.end() ? 0 : found->second;
  }
  /// Takes samples, of which each image must be true, until \p done.
  bool until_true(const std::function<bool(const Sample&)>& done) {
    for (int i = 0; i < 500; ++i) {
      const auto got = sample();
      if (!got) return false;
      if (const auto* image = std::get_if<UltrasoundImage>(&got->what)) expect_true(*image);
      if (done(*got)) return true;
    }
    return false;
  }
  /// All of the truth of an image is one brightness along each line.
  static void expect_true(const UltrasoundImage& image) {
    ASSERT_TRUE(image.outline);
    EXPECT_LE(image.acquired, image.received);
    const int middle = image.pixels.width() / 2;
    const int row = image.pixels.height() / 2;
    const int brightness = image.pixels.at(middle, row);
    const auto truth = see_more_truth(static_cast<std::uint64_t>(brightness / 2));
    const IntersonOptions options = see_more_options();
    const SectorScan scan(options.shape, kIntersonLines, kIntersonSamples);
    const auto pixels = scan.convert(truth);
    ASSERT_EQ(pixels.pixels().size(), image.pixels.pixels().size());
    EXPECT_TRUE(std::ranges::equal(pixels.pixels(), image.pixels.pixels())) << brightness;
  }
  std::unique_ptr<IntersonEmulator> emulator;
};

bool is_image(const Sample& sample) { return std::holds_alternative<UltrasoundImage>(sample.what); }

TEST(IntersonSourceTest, GivesTheTruthWithGeometry) {
  IntersonBench bench;
  bench.start();
  std::optional<std::uint64_t> before;
  int images = 0;
  ASSERT_TRUE(bench.until_true([&](const Sample& got) {
    if (!is_image(got)) return false;
    EXPECT_TRUE(!before || got.sequence > *before);
    before = got.sequence;
    return ++images == 12;
  })) << bench.reports();
  EXPECT_EQ(bench.emulator->probe().reg(interson::kMode), 1);
  EXPECT_EQ(bench.emulator->probe().reg(interson::kVoltage), 100);
}

TEST(IntersonSourceTest, SwitchesVoltageAndMotorOffWhenItEnds) {
  IntersonBench bench;
  bench.start();
  ASSERT_TRUE(bench.until_true(is_image));
  bench.source->stop();
  EXPECT_EQ(bench.source->next(bench.clock.now()).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(bench.emulator->probe().reg(interson::kMode), 0);
  EXPECT_EQ(bench.emulator->probe().reg(interson::kVoltageOn), 0);
  EXPECT_EQ(bench.emulator->probe().reg(interson::kMotor), 0);
}

TEST(IntersonSourceTest, EachFaultIsCountedByItsCauseAndCostsItsImageOnly) {
  struct FaultCase {
    IntersonFault fault;
    const char* cause;
  };
  IntersonBench bench;
  bench.start();
  ASSERT_TRUE(bench.until_true(is_image)) << bench.reports();
  for (const FaultCase& one : {FaultCase{IntersonFault::kLostLine, "incomplete"},
                               {IntersonFault::kLostImage, "lost_images"},
                               {IntersonFault::kLineNumber, "line_number"},
                               {IntersonFault::kCutLine, "cut_line"},
                               {IntersonFault::kEmpty, "empty"},
                               {IntersonFault::kStall, "stall"},
                               {IntersonFault::kOverflow, "overflow"},
                               {IntersonFault::kProtocol, "transfer_error"}}) {
    const auto count = bench.bad(one.cause);
    bench.emulator->probe().inject(one.fault, 1);
    ASSERT_TRUE(bench.until_true([&](const Sample&) { return bench.bad(one.cause) > count; }))
        << one.cause << "\n"
        << bench.reports();
    int images = 0;
    ASSERT_TRUE(bench.until_true([&](const Sample& got) { return (images += is_image(got)) == 3; }))
        << one.cause;
  }
  EXPECT_EQ(bench.source->health().reconnects, 0U) << bench.reports();
}

TEST(IntersonSourceTest, AnUnpluggedProbeComesBack) {
  IntersonBench bench;
  bench.start();
  ASSERT_TRUE(bench.until_true(is_image));
  bench.emulator->server().unplug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.cause == "not_exported"; }));
  bench.emulator->server().replug();
  ASSERT_TRUE(bench.until([](const auto& h) { return h.reconnects == 1; })) << bench.reports();
  EXPECT_TRUE(bench.until_true(is_image));
}

TEST(IntersonSourceTest, RejectsOptionsOutOfRange) {
  IntersonOptions options = see_more_options();
  EXPECT_TRUE(test::has_value(validate(options)));
  options.image.clear();
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"name of the images"}));
  options = see_more_options();
  options.shape.angle_deg = 0;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"angle_deg"}));
}

}  // namespace
}  // namespace nav::devices
