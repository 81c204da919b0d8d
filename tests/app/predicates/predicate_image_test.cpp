// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_image.hpp"

#include <gtest/gtest.h>
#include <utility>

#include "render/canvas.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::app {
namespace {

using render::features::Paint;
using render::features::Stroke;

render::PredicateModel model_of(int count, const std::string& prefix = "predicate ") {
  render::PredicateModel model;
  std::vector<render::PredicateHistogram::Bar> bars;
  for (int j = 0; j < count; ++j) {
    model.entries.push_back(
        {prefix + std::to_string(j), render::PredicateExpression::kind("intensity", {0, 1})});
    bars.push_back({1.0 / count, 11.0 * j, 0.7});
  }
  model.histogram = *render::PredicateHistogram::create(std::move(bars));
  return model;
}

Image2d<Rgba8> drawn(int width, const render::PredicateModel& model) {
  const Image2d<Rgba8> view(
      width, 40, std::vector<Rgba8>(static_cast<std::size_t>(40 * width), Rgba8{0, 0, 0, 255}));
  return predicate_image({{"a view", view, model}});
}

bool same(const Image2d<Rgba8>& a, const Image2d<Rgba8>& b) {
  const auto x = a.pixels();
  const auto y = b.pixels();
  return x.size() == y.size() && std::equal(x.begin(), x.end(), y.begin(), [](auto p, auto q) {
           return p.r == q.r && p.g == q.g && p.b == q.b;
         });
}

TEST(PredicateImageTest, TheLegendNamesEveryEntryAtAnyWidth) {
  const std::pair<int, int> cases[] = {{200, 1}, {200, 32}, {800, 12}, {2000, 1}, {2000, 32}};
  for (const auto& [width, count] : cases) {
    const auto model = model_of(count);
    const auto image = drawn(width, model);
    constexpr int kEvery = test::kSanitized ? 6 : 1;
    for (int j = 0; j < count; j += kEvery) {
      auto renamed = model;
      renamed.entries[static_cast<std::size_t>(j)].name[0] = 'q';
      EXPECT_FALSE(same(drawn(width, renamed), image)) << width << " " << count << " " << j;
    }
  }
}

TEST(PredicateImageTest, NamesOfAnyLengthFit) {
  const auto model = model_of(32, std::string(3000, 'w') + "äöü");
  EXPECT_LT(drawn(200, model).height(), 4000);
  EXPECT_GT(drawn(200, model_of(32, "ö")).height(), 40);
}

/// First row of the legend in an image with panels of 40 rows.
constexpr int kLegend = 28 + 40 + 120;

/// True when the legend of an image shows the whole number.
bool says_number(const Image2d<Rgba8>& image, const std::string& number) {
  render::Canvas measure(1, 1, render::rgb8(0));
  const int width = measure.text_width(15, number);
  render::Canvas canvas(width, 20, render::rgb8(0x202020));
  canvas.text(0, 15, 15, number, render::rgb8(0xd0d0d0));
  const auto wanted = canvas.image();
  // Capitals and digits stand on the base line, row 15; descenders of names are below.
  const auto is_at = [&](int left, int top) {
    for (int y = 3; y < 15; ++y) {
      for (int x = 0; x < width; ++x) {
        if (image.at(left + x, top + y).r != wanted.at(x, y).r) return false;
      }
    }
    return true;
  };
  for (int top = kLegend; top + 20 <= image.height(); ++top) {
    for (int left = 0; left + width <= image.width(); ++left) {
      if (is_at(left, top)) return true;
    }
  }
  return false;
}

TEST(PredicateImageTest, TheImportanceIsShownWholeAfterAnyName) {
  std::vector<std::size_t> lengths{1, 60, 3000};
  for (std::size_t n = 8; n < 24; ++n) lengths.push_back(n);  // Some of these lengths fill a line.
  for (const std::size_t length : lengths) {
    auto model = model_of(2, std::string(length, 'n'));
    model.histogram.drag(0, 0.164);
    const auto image = drawn(200, model);
    EXPECT_TRUE(says_number(image, "0.164")) << length;
    EXPECT_TRUE(says_number(image, "0.836")) << length;
    EXPECT_FALSE(says_number(image, "0.165")) << length;
  }
}

TEST(PredicateImageTest, NamesOutsideAsciiAreDrawn) {
  EXPECT_FALSE(same(drawn(400, model_of(1, "Gefäß")), drawn(400, model_of(1, "Gef"))));
  EXPECT_FALSE(same(drawn(400, model_of(1, "Gefäß")), drawn(400, model_of(1, "Gef??"))));
  EXPECT_TRUE(same(drawn(400, model_of(1, "血管")), drawn(400, model_of(1, "??"))));
}

TEST(PredicateImageTest, TheHighestBarFillsTheHeight) {
  const auto image = drawn(800, model_of(32));
  int coloured = 0;
  for (int y = 68; y < 68 + 120; ++y) {
    const Rgba8& p = image.at(14, y);
    coloured += p.r > p.g + 40 ? 1 : 0;
  }
  EXPECT_GT(coloured, 80) << "32 equal bars";
}

class StrokeImageTest : public ::testing::Test {
 protected:
  StrokeImageTest() {
    VoxelGrid grid;
    grid.size = {40, 40, 40};
    volume_ = std::make_shared<const StoredVolume>(*StoredVolume::create(
        grid, std::vector<std::int16_t>(grid.voxel_count(), std::int16_t{60}), "block"));
  }
  static Stroke stroke(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    Stroke made;
    made.points = {{from}, {to}};
    made.plane_normal = {{0, 0, 1}};
    return made;
  }
  /// Number of pixels in the colour of "show".
  int green(const std::vector<Stroke>& strokes, int side = 200) {
    const auto image = stroke_image(*volume_, {0, 255}, strokes, side, side);
    int count = 0;
    for (const Rgba8& p : image.pixels()) count += p.g > p.r + 60 && p.g > p.b + 40 ? 1 : 0;
    return count;
  }
  std::shared_ptr<const StoredVolume> volume_;
};

TEST_F(StrokeImageTest, EverySliceIsShown) {
  std::vector<Stroke> strokes;
  int before = 0;
  for (int n = 0; n < 7; ++n) {
    strokes.push_back(stroke({5, 20, 4.0 + 5 * n}, {35, 20, 4.0 + 5 * n}));
    auto hidden = strokes;
    hidden.back().paint = Paint::kHide;
    EXPECT_GT(green(strokes), green(hidden)) << "slice " << n;
    before = green(strokes);
  }
  EXPECT_GT(before, 0);
}

// Slices may be nearer to each other than half a millimetre, and may cross.
TEST_F(StrokeImageTest, CloseAndCrossingSlicesAreAllShown) {
  VoxelGrid fine;
  fine.size = {40, 40, 40};
  fine.spacing_mm = {0.4, 0.4, 0.4};
  volume_ = std::make_shared<const StoredVolume>(*StoredVolume::create(
      fine, std::vector<std::int16_t>(fine.voxel_count(), std::int16_t{60}), "block"));
  const Stroke first = stroke({3, 4, 4.8}, {10, 4, 4.8});
  const Stroke beside = stroke({3, 10, 5.2}, {10, 10, 5.2});
  Stroke hidden = first;
  hidden.paint = Paint::kHide;
  EXPECT_GT(green({hidden, beside}), 50);
  // Its points lie in the first slice, but most of its voxels do not.
  Stroke across = stroke({3, 6, 4.8}, {10, 6, 4.8});
  across.plane_normal = {{0, 1, 0}};
  across.radius_mm = 2;
  EXPECT_GT(green({hidden, across}), 400);
}

TEST_F(StrokeImageTest, CountsTheSlicesThatDoNotFit) {
  std::vector<Stroke> strokes;
  for (int n = 0; n < 12; ++n) strokes.push_back(stroke({5, 20, 3.0 * n}, {35, 20, 3.0 * n}));
  const auto yellow = [&](int side) {
    const auto image = stroke_image(*volume_, {0, 255}, strokes, side, side);
    int count = 0;
    for (const Rgba8& p : image.pixels()) count += p.r > 180 && p.g > 140 && p.b < 110 ? 1 : 0;
    return count;
  };
  EXPECT_GT(yellow(200), 20) << "9 of 12";
  EXPECT_EQ(yellow(400), 0);
}

TEST_F(StrokeImageTest, OnlyMarkedVoxelsAreColoured) {
  const int inside = green({stroke({5, 20, 20}, {35, 20, 20})});
  const int a_fifth = green({stroke({5, 20, 20}, {11, 20, 20})});
  EXPECT_GT(inside, 1000);
  EXPECT_GT(a_fifth, inside / 8);
  EXPECT_LT(a_fifth, inside / 3);
  Stroke erased = stroke({0, 20, 20}, {39, 20, 20});
  erased.paint = Paint::kErase;
  erased.radius_mm = 3;
  EXPECT_EQ(green({stroke({5, 20, 20}, {35, 20, 20}), erased}), 0);
}

}  // namespace
}  // namespace nav::app
