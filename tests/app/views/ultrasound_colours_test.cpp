// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Colours of a file in the ultrasound views, to the last bit.
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "app/views/flat_views.hpp"
#include "io/recording_reader.hpp"
#include "io/sequence_writer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

constexpr int kBlock = 20;  // Pixels.
constexpr int kColumns = 3, kRows = 2;
constexpr double kPixelMm = 0.5;
// No flip and no other order of the channels gives the same image.
constexpr Rgb8 kBlocks[kRows][kColumns] = {{{250, 10, 20}, {30, 240, 40}, {50, 60, 230}},
                                           {{200, 200, 0}, {90, 90, 90}, {0, 150, 100}}};

Rgb8 colour_of_pixel(int column, int row) { return kBlocks[row / kBlock][column / kBlock]; }

/// Writes one image in an orientation and reads it as a recording. Pixels have \p components.
UltrasoundImage read_back(const std::string& orientation, int components = 3) {
  const test::TemporaryFolder folder;
  io::SequenceHeader header;
  header.width = kColumns * kBlock;
  header.height = kRows * kBlock;
  header.components = components;
  header.orientation = orientation;
  header.image_type = components == 3 ? "RGB_COLOR" : "BRIGHTNESS";
  io::SequenceImage frame;
  frame.timestamp_s = 1.0;
  frame.image_valid = true;
  for (int y = 0; y < header.height; ++y) {
    for (int x = 0; x < header.width; ++x) {
      const Rgb8 c = colour_of_pixel(orientation[0] == 'U' ? header.width - 1 - x : x,
                                     orientation[1] == 'N' ? header.height - 1 - y : y);
      const std::map<int, std::vector<std::uint8_t>> values = {{1, {luma(c)}},
                                                               {3, {c.r, c.g, c.b}}};
      for (const std::uint8_t value : values.at(components)) {
        frame.pixels.push_back(static_cast<std::byte>(value));
      }
    }
  }
  Eigen::Matrix4d spacing = Eigen::Matrix4d::Identity();
  spacing.topLeftCorner<3, 3>() *= kPixelMm;
  io::set_transform(frame, {"ImageToProbe", spacing, TrackingStatus::kOk});
  io::set_transform(frame, {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
  const auto path = folder / "colours.igs.mha";
  auto writer = io::SequenceWriter::create(path, header);
  EXPECT_TRUE(test::has_value(writer));
  EXPECT_TRUE(test::has_value(writer->append(frame)));
  EXPECT_TRUE(test::has_value(writer->finish()));
  CollectingDiagnostics diagnostics;
  io::RecordingOptions options;
  options.reference_frame.clear();
  auto reader = io::RecordingReader::open(path, nullptr, options, diagnostics);
  EXPECT_TRUE(test::has_value(reader));
  auto next = reader->next();
  EXPECT_TRUE(test::has_value(next));
  EXPECT_TRUE(test::has_value(next->image));
  return *next->image;
}

/// The view whose pixels are those of the image.
PlaneView one_to_one(const UltrasoundImage& frame) {
  return {.x = 0,
          .y = 0,
          .width = frame.pixels.width(),
          .height = frame.pixels.height(),
          .origin_mm = frame.grid.origin_mm,
          .mm_per_px = frame.grid.mm_per_pixel(0, 0)};
}

TEST(UltrasoundColoursViewTest, EveryPixelHasTheColourOfTheFile) {
  for (const char* orientation : {"MF", "UF", "MN", "UNA"}) {
    const UltrasoundImage frame = read_back(orientation);
    ASSERT_FALSE(frame.colours.empty()) << orientation;
    render::Canvas canvas(frame.pixels.width(), frame.pixels.height(), {0, 0, 0, 255});
    draw_ultrasound(canvas, one_to_one(frame), frame);
    const auto image = canvas.image();
    int others = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const Rgb8 c = colour_of_pixel(x, y);
        others += image.at(x, y) == Rgba8{c.r, c.g, c.b, 255} ? 0 : 1;
      }
    }
    EXPECT_EQ(others, 0) << orientation;
  }
}

TEST(UltrasoundColoursViewTest, AGreyFileCostsNoColoursAndIsDrawnGrey) {
  const UltrasoundImage frame = read_back("MF", 1);
  EXPECT_EQ(frame.colours.pixels().data(), nullptr);
  render::Canvas canvas(frame.pixels.width(), frame.pixels.height(), {0, 0, 0, 255});
  draw_ultrasound(canvas, one_to_one(frame), frame);
  const std::uint8_t grey = luma(kBlocks[1][0]);
  EXPECT_EQ(canvas.image().at(5, 30), (Rgba8{grey, grey, grey, 255}));
}

TEST(UltrasoundColoursViewTest, ExactlyThePixelsInsideTheSectorAreDrawn) {
  for (const double half_angle_rad : {0.3, 0.25 * M_PI, 1.2, 1.55, 2.5}) {
    UltrasoundImage frame = read_back("MF", 1);
    frame.pixels = Image2d<std::uint8_t>(
        frame.pixels.width(), frame.pixels.height(),
        std::vector<std::uint8_t>(frame.pixels.pixels().size(), std::uint8_t{200}));
    const PlaneView view = one_to_one(frame);
    const Eigen::Vector2d apex = view.point_of(frame.pixels.width() / 2, 3);
    const double reach = view.mm_per_px * frame.pixels.height();
    frame.outline = SectorOutline{apex, 0.2 * reach, 0.8 * reach, half_angle_rad};
    render::Canvas canvas(frame.pixels.width(), frame.pixels.height(), {0, 0, 0, 255});
    draw_ultrasound(canvas, view, frame);
    const auto image = canvas.image();
    int inside = 0;
    for (int y = 1; y < image.height() - 1; ++y) {
      for (int x = 1; x < image.width() - 1; ++x) {
        const bool drawn = image.at(x, y).r == 200;
        ASSERT_EQ(drawn, frame.outline->contains(view.point_of(x, y))) << x << ' ' << y;
        inside += drawn ? 1 : 0;
      }
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(UltrasoundColoursViewTest, WhatMeasuresSeesTheLuma) {
  const UltrasoundImage frame = read_back("UN");
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const auto middle = frame.grid.at(column * kBlock + 10, row * kBlock + 10).mm.head<2>();
      EXPECT_DOUBLE_EQ(intensity(frame, middle), luma(kBlocks[row][column]));
    }
  }
}

TEST(UltrasoundColoursViewTest, TheFlatViewHasThemInsideTheSectorOnly) {
  UltrasoundImage frame = read_back("MF");
  session::Epoch epoch;
  epoch.ultrasound = {SafetyState::kValid, ""};
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const std::optional<NeedlePlan> plan;
  const std::string banner;
  const auto drawn = [&] {
    const Transform<frames::Reference, frames::Image> still(Eigen::Quaterniond::Identity(),
                                                            Eigen::Vector3d::Zero());
    epoch.frame = TrackedImage{frame, still, Duration(0)};
    return draw_ultrasound_view({.epoch = epoch, .ct = *ct, .plan = plan, .banner = banner},
                                {300, 200});
  };
  const auto at_block = [&](const FlatView& view, int column, int row) {
    const Eigen::Vector2d px =
        view.plane->pixel_of(frame.grid.at(column * kBlock + 10, row * kBlock + 10).mm.head<2>());
    return view.image.at(static_cast<int>(std::lround(px.x())),
                         static_cast<int>(std::lround(px.y())));
  };
  const FlatView whole = drawn();
  ASSERT_TRUE(whole.plane);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Rgb8 c = kBlocks[row][column];
      EXPECT_EQ(at_block(whole, column, row), (Rgba8{c.r, c.g, c.b, 255})) << column << ' ' << row;
    }
  }
  // A narrow sector around the middle column.
  const auto apex = frame.grid.at(30, -60).mm.head<2>();
  frame.outline = SectorOutline{apex, 0, 1000, 0.1};
  const FlatView cut = drawn();
  EXPECT_EQ(at_block(cut, 1, 0), at_block(whole, 1, 0));
  EXPECT_EQ(at_block(cut, 0, 0), cut.image.at(0, 0)) << "outside the sector: background";
  EXPECT_EQ(at_block(cut, 2, 1), cut.image.at(0, 0));
}

}  // namespace
}  // namespace nav::app
