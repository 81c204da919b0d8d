// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_codec.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "devices/usb/interson_sender.hpp"
#include "devices/usb/sector_scan.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using Bytes = std::vector<std::byte>;
using std::chrono::milliseconds;

/// A sample that tells image, line and depth apart.
std::uint8_t truth_sample(unsigned image, std::size_t line, std::size_t sample) {
  return static_cast<std::uint8_t>((31 * image + 7 * line + sample) % 251);
}

void append_scan_line(Bytes& bytes, unsigned image, std::size_t line) {
  bytes.push_back(static_cast<std::byte>(image % kIntersonNumbers));
  for (std::size_t i = 0; i < kIntersonSamples; ++i) {
    bytes.push_back(static_cast<std::byte>(truth_sample(image, line, i)));
  }
}

Bytes scan_bytes(unsigned image) {
  Bytes bytes;
  for (std::size_t line = 0; line < kIntersonLines; ++line) append_scan_line(bytes, image, line);
  return bytes;
}

class IntersonAssemblerTest : public ::testing::Test {
 protected:
  void take(const Bytes& bytes, std::size_t transfer = 16 * kIntersonLineBytes) {
    for (std::size_t at = 0; at < bytes.size(); at += transfer) {
      const std::size_t length = std::min(transfer, bytes.size() - at);
      assembler_.take(std::span(bytes).subspan(at, length), Timestamp(milliseconds(++time_)),
                      [this](IntersonNews&& news) { keep(std::move(news)); });
    }
  }
  void keep(IntersonNews&& news) {
    if (news.kind == IntersonNews::Kind::kBad) {
      causes_.emplace_back(news.cause);
    } else {
      images_.push_back(std::move(news));
    }
  }
  void expect_whole(const IntersonNews& news, unsigned image) const {
    ASSERT_EQ(news.kind, IntersonNews::Kind::kImage);
    ASSERT_EQ(news.samples.size(), kIntersonLines * kIntersonSamples);
    for (std::size_t line = 0; line < kIntersonLines; line += 30) {
      for (std::size_t i = 0; i < kIntersonSamples; i += 100) {
        ASSERT_EQ(news.samples[line * kIntersonSamples + i], truth_sample(image, line, i));
      }
    }
    EXPECT_LE(news.begun, news.ended);
  }
  IntersonAssembler assembler_;
  std::vector<IntersonNews> images_;
  std::vector<std::string> causes_;
  int time_ = 0;
};

TEST_F(IntersonAssemblerTest, MakesImagesOfTransfersOfAnySize) {
  for (const std::size_t transfer : {std::size_t{512}, std::size_t{1024}, std::size_t{16384}}) {
    assembler_.restart();
    images_.clear();
    for (unsigned image = 0; image < 20; ++image) take(scan_bytes(image), transfer);
    ASSERT_EQ(images_.size(), 19U) << "the last one waits for the next";
    for (unsigned image = 0; image < 19; ++image) expect_whole(images_[image], image);
    for (std::size_t i = 1; i < images_.size(); ++i) EXPECT_EQ(images_[i].advance, 1U);
  }
  EXPECT_TRUE(causes_.empty());
}

TEST_F(IntersonAssemblerTest, AMissingLineCostsItsImageOnly) {
  Bytes bytes = scan_bytes(0);
  for (std::size_t line = 0; line < kIntersonLines; ++line) {
    if (line != 100) append_scan_line(bytes, 1, line);
  }
  take(bytes);
  take(scan_bytes(2));
  take(scan_bytes(3));
  ASSERT_EQ(images_.size(), 3U);
  expect_whole(images_[0], 0);
  EXPECT_EQ(images_[1].kind, IntersonNews::Kind::kIncomplete);
  EXPECT_EQ(images_[1].lines, kIntersonLines - 1);
  expect_whole(images_[2], 2);
}

TEST_F(IntersonAssemblerTest, ALostImageIsSeenByTheNumbers) {
  for (const unsigned image : {14U, 15U, 18U, 19U, 20U}) take(scan_bytes(image));
  ASSERT_EQ(images_.size(), 4U);
  // Nobody can say that the lines of 15 were not shifted, as 16 does not follow.
  EXPECT_EQ(images_[1].kind, IntersonNews::Kind::kIncomplete);
  expect_whole(images_[2], 18);
  EXPECT_EQ(images_[2].advance, 3U);
  expect_whole(images_[3], 19);
}

TEST_F(IntersonAssemblerTest, AWrongNumberOfALineIsCountedAndTheLineStays) {
  take(scan_bytes(0));
  Bytes bytes = scan_bytes(1);
  bytes[50 * kIntersonLineBytes] = std::byte{9};
  bytes[60 * kIntersonLineBytes] = std::byte{200};
  take(bytes);
  take(scan_bytes(2));
  ASSERT_EQ(images_.size(), 2U);
  expect_whole(images_[1], 1);
  EXPECT_EQ(causes_, (std::vector<std::string>{"line_number", "line_number"}));
}

TEST_F(IntersonAssemblerTest, ACutLineAndHalfALineCostTheirImageOnly) {
  take(scan_bytes(0));
  Bytes first = scan_bytes(1);
  const Bytes rest(first.begin() + 33 * 1024, first.end());
  first.resize(32 * 1024 + 300);
  take(first);
  take(rest);
  take(scan_bytes(2));
  Bytes shifted = scan_bytes(3);
  shifted.erase(shifted.begin() + 10 * 1024, shifted.begin() + 10 * 1024 + 512);
  take(shifted);
  take(scan_bytes(4));
  take(scan_bytes(5));
  take(scan_bytes(6));
  const auto whole = std::ranges::count(images_, IntersonNews::Kind::kImage, &IntersonNews::kind);
  EXPECT_EQ(std::ranges::count(causes_, "cut_line"), 1);
  EXPECT_GE(std::ranges::count(causes_, "alignment"), 1);
  EXPECT_GE(whole, 3);
  expect_whole(images_.front(), 0);
  expect_whole(images_.back(), 5);
}

/// Lines that are shifted by half a line, and whose samples look like numbers, are no image.
TEST_F(IntersonAssemblerTest, ShiftedDarkLinesAreNoImage) {
  const auto dark = [](unsigned image) {
    Bytes bytes(kIntersonLines * kIntersonLineBytes);
    for (std::size_t line = 0; line < kIntersonLines; ++line) {
      bytes[line * kIntersonLineBytes] = static_cast<std::byte>(image % kIntersonNumbers);
    }
    return bytes;
  };
  for (unsigned image = 0; image < 3; ++image) take(dark(image));
  Bytes shifted = dark(3);
  shifted.erase(shifted.begin() + 512, shifted.begin() + 1024);
  take(shifted);
  const std::size_t before = images_.size();
  for (unsigned image = 4; image < 12; ++image) take(dark(image));
  for (std::size_t i = before; i < images_.size(); ++i) {
    EXPECT_NE(images_[i].kind, IntersonNews::Kind::kImage) << i;
  }
}

TEST_F(IntersonAssemblerTest, TakesAnyBytes) {
  std::mt19937 random(3);
  for (int round = 0; round < 60; ++round) {
    Bytes noise(random() % 5000);
    for (std::byte& one : noise) one = static_cast<std::byte>(random() % 24);
    take(noise, 1 + random() % 2000);
  }
  for (const IntersonNews& news : images_) {
    if (news.kind == IntersonNews::Kind::kImage) {
      EXPECT_EQ(news.samples.size(), kIntersonLines * kIntersonSamples);
    }
  }
}

TEST(IntersonSettingsTest, WritesTheRegistersInOrder) {
  const IntersonSettings settings{.frequency = 2, .band_pass = 1, .high_voltage = 100};
  ASSERT_TRUE(test::has_value(validate(settings)));
  const auto writes = interson_setup(settings);
  const auto value = [&](std::uint16_t reg) {
    const auto found = std::ranges::find(writes, reg, &IntersonWrite::reg);
    return found == writes.end() ? -1 : found->value;
  };
  EXPECT_EQ(writes.front(), (IntersonWrite{interson::kMode, 0}));
  EXPECT_EQ(value(interson::kFrequency), 2);
  EXPECT_EQ(value(interson::kBandPass), 1);
  EXPECT_EQ(value(interson::kVoltage), 100);
  EXPECT_EQ(value(interson::kMotorSpeed), 0x7A);
  EXPECT_EQ(value(interson::kMotorSpeed + 6), 0x32);
  EXPECT_EQ(writes.back(), (IntersonWrite{interson::kMotor, 1}));
  const auto bad = [](IntersonSettings changed, std::initializer_list<std::string> words) {
    EXPECT_TRUE(test::rejects(validate(changed), ErrorCode::kUsage, words));
  };
  bad({.frequency = 4, .high_voltage = 1}, {"frequency", "0 to 3", "4"});
  bad({.band_pass = -1, .high_voltage = 1}, {"band_pass", "-1"});
  bad({.high_voltage = 0}, {"high_voltage", "1 to 178", "0"});
  bad({.high_voltage = 179}, {"179"});
  bad({.high_voltage = 9, .images_hz = 20}, {"images_hz", "10, 12.5 or 15"});
}

constexpr SectorShape kShape{.radius_mm = 20, .depth_mm = 100, .angle_deg = 60, .spacing_mm = 0.25};

/// Closed forms: rings and rays keep their places.
TEST(SectorScanTest, EverySampleLiesAtItsRadiusAndAngle) {
  const SectorScan scan(kShape, kIntersonLines, kIntersonSamples);
  IntersonLines by_depth(kIntersonLines * kIntersonSamples), by_line(by_depth.size());
  for (std::size_t line = 0; line < kIntersonLines; ++line) {
    for (std::size_t i = 0; i < kIntersonSamples; ++i) {
      by_depth[line * kIntersonSamples + i] = static_cast<std::uint8_t>(i / 5);
      by_line[line * kIntersonSamples + i] = static_cast<std::uint8_t>(line);
    }
  }
  const auto depths = scan.convert(by_depth), lines = scan.convert(by_line);
  const SectorOutline& outline = scan.outline();
  EXPECT_NEAR(outline.apex_mm.y(), -20 * std::cos(std::numbers::pi / 6), 1e-9);
  int inside = 0;
  for (int row = 0; row < depths.height(); ++row) {
    for (int column = 0; column < depths.width(); ++column) {
      const Eigen::Vector3d at = scan.grid().at(column, row).mm;
      const Eigen::Vector2d from_apex = at.head<2>() - outline.apex_mm;
      const double radius = from_apex.norm();
      const double angle = std::atan2(from_apex.x(), from_apex.y());
      if (!outline.contains(at.head<2>())) continue;
      ++inside;
      const double sample = (radius - 20) / 100 * (kIntersonSamples - 1);
      EXPECT_NEAR(depths.at(column, row), sample / 5, 1.01);
      const double line = (angle / (std::numbers::pi / 6) + 1) / 2 * (kIntersonLines - 1);
      EXPECT_NEAR(lines.at(column, row), line, 0.51);
    }
  }
  EXPECT_GT(inside, 50000);
  EXPECT_EQ(depths.at(0, 0), 0) << "outside of the sector";
}

TEST(SectorScanTest, LinesOfAnImageMakeTheImageAgain) {
  const SectorScan scan(kShape, kIntersonLines, kIntersonSamples);
  UltrasoundImage image;
  std::vector<std::uint8_t> smooth;
  const auto blank = scan.convert(IntersonLines(kIntersonLines * kIntersonSamples));
  for (int row = 0; row < blank.height(); ++row) {
    for (int column = 0; column < blank.width(); ++column) {
      smooth.push_back(static_cast<std::uint8_t>(
          std::lround(128 + 60 * std::sin(0.02 * column) + 60 * std::cos(0.015 * row))));
    }
  }
  image.pixels = {blank.width(), blank.height(), std::move(smooth)};
  image.grid = scan.grid();
  image.outline = scan.outline();
  const EmulatedSector sector = sector_of(image);
  EXPECT_NEAR(sector.shape.radius_mm, 20, 1e-9);
  EXPECT_NEAR(sector.shape.angle_deg, 60, 1e-9);
  const auto again = scan.convert(scan_lines_of(image, sector));
  double worst = 0;
  for (int row = 4; row < again.height(); ++row) {
    for (int column = 0; column < again.width(); ++column) {
      if (!scan.outline().contains(scan.grid().at(column, row).mm.head<2>())) continue;
      if (row + 2 >= again.height()) continue;
      worst = std::max(worst, std::abs(1.0 * again.at(column, row) - image.pixels.at(column, row)));
    }
  }
  EXPECT_LE(worst, 4) << "one pixel of the smooth image, and rounding";
}

TEST(SectorScanTest, RejectsShapesOutOfRange) {
  const auto bad = [](const std::function<void(SectorShape&)>& change,
                      std::initializer_list<std::string> words) {
    SectorShape shape = kShape;
    change(shape);
    EXPECT_TRUE(test::rejects(validate(shape), ErrorCode::kUsage, words));
  };
  EXPECT_TRUE(test::has_value(validate(kShape)));
  bad([](auto& s) { s.radius_mm = -1; }, {"radius_mm", "0 to 200 mm"});
  bad([](auto& s) { s.depth_mm = 0; }, {"depth_mm"});
  bad([](auto& s) { s.angle_deg = 171; }, {"angle_deg", "171"});
  bad([](auto& s) { s.spacing_mm = std::nan(""); }, {"spacing_mm"});
  bad([](auto& s) { s.depth_mm = 500, s.spacing_mm = 0.05; }, {"4096 pixels"});
}

}  // namespace
}  // namespace nav::devices
