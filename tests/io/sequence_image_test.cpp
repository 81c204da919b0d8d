// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <clocale>
#include <cmath>
#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <type_traits>

#include "io/sequence.hpp"
#include "tests/support/matchers.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

SequenceImage frame_with(const std::string& matrix, const std::string& status = "OK") {
  SequenceImage frame;
  frame.index = 7;
  frame.fields["ProbeToTrackerTransform"] = matrix;
  if (status != "absent") frame.fields["ProbeToTrackerTransformStatus"] = status;
  return frame;
}

const std::string kMatrix = "1 2 3 4  5 6 7 8 9 10 11 12e0 0 0 -2.5e-016 +1 ";

TEST(FrameTransformTest, ReadsRowMajorNumbers) {
  const auto t = transform(frame_with(kMatrix), "ProbeToTracker");
  ASSERT_TRUE(test::has_value(t));
  Eigen::Matrix4d expected;
  expected << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, -2.5e-16, 1;
  EXPECT_EQ(t->to_from_from, expected);
  EXPECT_EQ(t->status, TrackingStatus::kOk);
  EXPECT_EQ(t->name, "ProbeToTracker");
}

TEST(FrameTransformTest, ErrorsNameTheFrameTheFieldTheExpectationAndTheFinding) {
  const auto refused = [](const std::string& text, const std::string& found) {
    return rejects(transform(frame_with(text), "ProbeToTracker"), Code::kMalformedData,
                   {"frame 7", "ProbeToTrackerTransform", "16", found});
  };
  // Readers that stop at the first word that they cannot parse leave an identity behind.
  EXPECT_TRUE(refused("nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan", "nan"));
  EXPECT_TRUE(refused("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 inf", "'inf' as number 16"));
  EXPECT_TRUE(refused("1 2 3 4 5 6 7", "7 words"));
  EXPECT_TRUE(refused(kMatrix + " 17", "17 words"));
  EXPECT_TRUE(refused("", "0 words"));
  EXPECT_TRUE(refused("1 0 0 0,5 0 1 0 0 0 0 1 0 0 0 0 1", "'0,5' as number 4"));
  EXPECT_TRUE(rejects(transform(frame_with(kMatrix), "StylusToTracker"), Code::kNotFound,
                      {"frame 7", "StylusToTrackerTransform", "ProbeToTracker"}));
}

TEST(FrameTransformTest, RoundsTinyNumbersToZeroAndRejectsHugeOnes) {
  const std::string zeros(400, '0');
  const auto first = [](const std::string& number) {
    return transform(frame_with(number + " 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), "ProbeToTracker");
  };
  const std::vector<std::string> small = {"1e-400", "0." + zeros + "1", "-0." + zeros + "25e+3",
                                          "12e-9999999999999999999", "1" + zeros + "e-800"};
  for (const std::string& number : small) {
    const auto t = first(number);
    ASSERT_TRUE(test::has_value(t)) << number;
    EXPECT_EQ(t->to_from_from(0, 0), 0) << number;
  }
  const std::vector<std::string> large = {"1e400", "1" + zeros + "e-5", "-1" + zeros,
                                          "1e9999999999999999999", "0." + zeros + "1e+900"};
  for (const std::string& number : large) {
    EXPECT_TRUE(rejects(first(number), Code::kMalformedData, {"as number 1"})) << number;
  }
}

TEST(FrameTransformTest, DoesNotDependOnTheLocale) {
  const char* old = std::setlocale(LC_ALL, nullptr);
  const std::string keep = old != nullptr ? old : "C";
  // If the locales are missing, the default stays. The test then proves less but does not fail.
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"}) std::setlocale(LC_ALL, name);
  const auto t = transform(frame_with("1.5 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), "ProbeToTracker");
  std::setlocale(LC_ALL, keep.c_str());
  ASSERT_TRUE(test::has_value(t));
  EXPECT_EQ(t->to_from_from(0, 0), 1.5);
}

TEST(FrameTransformTest, AMissingOrUnknownStatusIsNeverOk) {
  const auto status = [](const std::string& text) {
    return transform(frame_with(kMatrix, text), "ProbeToTracker").value().status;
  };
  EXPECT_EQ(status("absent"), TrackingStatus::kUnknown);
  EXPECT_EQ(status(""), TrackingStatus::kUnknown);
  EXPECT_EQ(status("OK "), TrackingStatus::kOk);
  EXPECT_EQ(status("MISSING"), TrackingStatus::kOccluded);
  EXPECT_EQ(status("OUT_OF_VIEW"), TrackingStatus::kOccluded);
  EXPECT_EQ(status("OUT_OF_VOLUME"), TrackingStatus::kOutOfVolume);
  EXPECT_EQ(status("REQ_TIMEOUT"), TrackingStatus::kTimeout);
  EXPECT_EQ(status("INVALID"), TrackingStatus::kInvalid);
  EXPECT_EQ(status("ok"), TrackingStatus::kInvalid);
  EXPECT_EQ(status("SHINY"), TrackingStatus::kInvalid);
}

TEST(FrameTransformTest, AcceptsNanOnlyIfTheStatusIsNotOk) {
  const std::string nan = "nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  const auto t = transform(frame_with(nan, "MISSING"), "ProbeToTracker");
  ASSERT_TRUE(test::has_value(t));
  EXPECT_TRUE(std::isnan(t->to_from_from(0, 0)));
  EXPECT_NE(t->status, TrackingStatus::kOk);
  EXPECT_TRUE(rejects(transform(frame_with(nan, "absent"), "ProbeToTracker"), Code::kMalformedData,
                      {"nan"}));
}

TEST(FrameTransformTest, WritesTransformsThatReadBackEqual) {
  NamedTransform t{"AToB", Eigen::Matrix4d::Random(), TrackingStatus::kOutOfVolume};
  t.to_from_from(0, 0) = 0.1;
  SequenceImage frame;
  for (const auto status :
       {TrackingStatus::kOk, TrackingStatus::kUnknown, TrackingStatus::kOccluded,
        TrackingStatus::kOutOfVolume, TrackingStatus::kTimeout, TrackingStatus::kInvalid}) {
    t.status = status;
    set_transform(frame, t);
    const auto back = transform(frame, "AToB");
    ASSERT_TRUE(test::has_value(back));
    EXPECT_EQ(back->to_from_from, t.to_from_from);
    EXPECT_EQ(back->status, status);
  }
  EXPECT_EQ(transform_names(frame), std::vector<std::string>{"AToB"});
}

// Pixels 1 2 3 / 4 5 6. A flip or a transpose changes the image.
struct SmallFrame {
  SequenceHeader header;
  SequenceImage frame;
};
SmallFrame small_frame(const std::string& orientation) {
  SmallFrame p;
  p.header.path = "p.mha";
  p.header.width = 3;
  p.header.height = 2;
  p.header.orientation = orientation;
  p.header.image_type = "BRIGHTNESS";
  p.frame.image_valid = true;
  for (int i = 1; i <= 6; ++i) p.frame.pixels.push_back(static_cast<std::byte>(i));
  return p;
}

TEST(BrightnessImageTest, FlipsEveryOrientationToMf) {
  using Pixels = std::vector<std::uint8_t>;
  const auto pixels = [](const std::string& orientation) {
    const SmallFrame p = small_frame(orientation);
    const auto image = brightness_image(p.header, p.frame);
    return image ? Pixels(image->pixels().begin(), image->pixels().end()) : Pixels();
  };
  for (const char* third : {"", "A", "D"}) {
    EXPECT_EQ(pixels(std::string("MF") + third), (Pixels{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(pixels(std::string("UF") + third), (Pixels{3, 2, 1, 6, 5, 4}));
    EXPECT_EQ(pixels(std::string("MN") + third), (Pixels{4, 5, 6, 1, 2, 3}));
    EXPECT_EQ(pixels(std::string("UN") + third), (Pixels{6, 5, 4, 3, 2, 1}));
  }
}

/// Frame of 3 x 2 pixels of 16 bits.
template <class Sample>
SmallFrame deep_frame(const std::vector<Sample>& samples) {
  SmallFrame p = small_frame("MF");
  p.header.pixel_type = std::is_signed_v<Sample> ? PixelType::kInt16 : PixelType::kUint16;
  p.frame.pixels.resize(samples.size() * sizeof(Sample));
  std::memcpy(p.frame.pixels.data(), samples.data(), p.frame.pixels.size());
  return p;
}

TEST(BrightnessImageTest, SixteenBitsKeepTheScaleOfTheFirstImage) {
  GreyScale scale;
  const auto first = deep_frame<std::uint16_t>({0, 1, 1000, 2048, 3000, 4000});
  const auto image = brightness_image(first.header, first.frame, scale);
  ASSERT_TRUE(image);
  EXPECT_EQ(scale.white, 4095u);
  EXPECT_THAT(image->pixels(), ::testing::ElementsAre(0, 0, 62, 128, 187, 249));
  const auto brighter = deep_frame<std::int16_t>({0, 0, 0, 2048, 4095, 9000});
  const auto second = brightness_image(brighter.header, brighter.frame, scale);
  ASSERT_TRUE(second);
  EXPECT_EQ(scale.white, 4095u);
  EXPECT_EQ(scale.largest, 9000u);
  EXPECT_THAT(second->pixels(), ::testing::ElementsAre(0, 0, 0, 128, 255, 255));
  const auto negative = deep_frame<std::int16_t>({0, 0, 0, 0, 0, -7});
  EXPECT_TRUE(rejects(brightness_image(negative.header, negative.frame), Code::kUnsupportedData,
                      {"p.mha", "from 0", "-7"}));
}

TEST(BrightnessImageTest, EightBitsInSixteenKeepTheirValues) {
  const auto p = deep_frame<std::uint16_t>({0, 1, 2, 127, 254, 255});
  const auto image = brightness_image(p.header, p.frame);
  ASSERT_TRUE(image);
  EXPECT_THAT(image->pixels(), ::testing::ElementsAre(0, 1, 2, 127, 254, 255));
}

TEST(BrightnessImageTest, ABlackFirstImageDoesNotDecideTheScale) {
  GreyScale scale;
  const auto black = deep_frame<std::uint16_t>({0, 0, 0, 0, 0, 0});
  const auto first = brightness_image(black.header, black.frame, scale);
  ASSERT_TRUE(first);
  EXPECT_THAT(first->pixels(), ::testing::Each(0));
  EXPECT_EQ(scale.white, 0u);
  const auto seen = deep_frame<std::uint16_t>({0, 1, 1000, 2048, 3000, 4000});
  ASSERT_TRUE(brightness_image(seen.header, seen.frame, scale));
  EXPECT_EQ(scale.white, 4095u);
}

TEST(BrightnessImageTest, ElementMaxOfTheHeaderDecidesTheScale) {
  GreyScale scale;
  auto dark = deep_frame<std::uint16_t>({0, 0, 16, 0, 0, 100});
  dark.header.fields["ElementMax"] = "4000";
  const auto image = brightness_image(dark.header, dark.frame, scale);
  ASSERT_TRUE(image);
  EXPECT_EQ(scale.white, 4095u);
  EXPECT_TRUE(scale.of_header);
  EXPECT_THAT(image->pixels(), ::testing::ElementsAre(0, 0, 1, 0, 0, 6));
  for (const char* nonsense : {"", "0", "-3", "1e9", "nan", "bright"}) {
    GreyScale other;
    dark.header.fields["ElementMax"] = nonsense;
    ASSERT_TRUE(brightness_image(dark.header, dark.frame, other));
    EXPECT_EQ(other.white, 255u) << nonsense;
    EXPECT_FALSE(other.of_header);
  }
}

constexpr Rgb8 kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255}, kGrey{9, 9, 9},
    kWhite{255, 255, 255}, kBlack{0, 0, 0};

/// Frame of 3 x 2 pixels: red, green, blue / grey, white, black. Swapped channels change it too.
SmallFrame colour_frame(const std::string& orientation) {
  SmallFrame p = small_frame(orientation);
  p.header.components = 3;
  p.header.image_type = "RGB_COLOR";
  p.frame.pixels.clear();
  for (const Rgb8& pixel : {kRed, kGreen, kBlue, kGrey, kWhite, kBlack}) {
    for (const std::uint8_t value : {pixel.r, pixel.g, pixel.b}) {
      p.frame.pixels.push_back(static_cast<std::byte>(value));
    }
  }
  return p;
}

TEST(SequenceImageTest, ColoursAndTheirLumaAreFlippedToMf) {
  using Colours = std::vector<Rgb8>;
  const std::map<std::string, Colours> expected = {
      {"MF", {kRed, kGreen, kBlue, kGrey, kWhite, kBlack}},
      {"UF", {kBlue, kGreen, kRed, kBlack, kWhite, kGrey}},
      {"MN", {kGrey, kWhite, kBlack, kRed, kGreen, kBlue}},
      {"UNA", {kBlack, kWhite, kGrey, kBlue, kGreen, kRed}}};
  for (const auto& [orientation, colours] : expected) {
    const SmallFrame p = colour_frame(orientation);
    GreyScale scale;
    const auto image = sequence_image(p.header, p.frame, scale);
    ASSERT_TRUE(image);
    EXPECT_EQ(Colours(image->colours.pixels().begin(), image->colours.pixels().end()), colours)
        << orientation;
    ASSERT_EQ(image->pixels.width(), 3);
    ASSERT_EQ(image->pixels.height(), 2);
    for (std::size_t i = 0; i < colours.size(); ++i) {
      EXPECT_EQ(image->pixels.pixels()[i], luma(colours[i])) << orientation << ' ' << i;
    }
  }
}

TEST(SequenceImageTest, GreyImagesKeepNoColours) {
  GreyScale scale;
  const SmallFrame grey = small_frame("MF");
  const auto image = sequence_image(grey.header, grey.frame, scale);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->colours.pixels().data(), nullptr);
  SmallFrame same = colour_frame("MF");
  for (std::size_t i = 0; i < 18; ++i) same.frame.pixels[i] = static_cast<std::byte>(i / 3);
  const auto three = sequence_image(same.header, same.frame, scale);
  ASSERT_TRUE(three);
  EXPECT_EQ(three->colours.pixels().data(), nullptr) << "red, green and blue are equal";
  EXPECT_THAT(three->pixels.pixels(), ::testing::ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(SequenceImageTest, ColoursOfSixteenBitsHaveOneScale) {
  auto p = deep_frame<std::uint16_t>(
      {4095, 0, 0, 0, 2048, 0, 0, 0, 1000, 0, 0, 0, 4095, 4095, 4095, 0, 1, 17});
  p.header.components = 3;
  GreyScale scale;
  const auto image = sequence_image(p.header, p.frame, scale);
  ASSERT_TRUE(image);
  EXPECT_EQ(scale.white, 4095u);
  EXPECT_THAT(image->colours.pixels(), ::testing::ElementsAre(kRed, Rgb8{0, 128, 0}, Rgb8{0, 0, 62},
                                                              kBlack, kWhite, Rgb8{0, 0, 1}));
}

TEST(BrightnessImageTest, RejectsEachOtherKindOfImageInOneSentence) {
  const auto refused = [](auto change, std::initializer_list<std::string> pieces,
                          Code code = Code::kUnsupportedData) {
    SmallFrame p = small_frame("MF");
    change(p);
    return rejects(brightness_image(p.header, p.frame), code, pieces);
  };
  EXPECT_TRUE(
      refused([](auto& p) { p.header.components = 2; }, {"p.mha", "frame 0", "2 of BRIGHTNESS"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.image_type = "RGB_COLOR"; }, {"1 of RGB_COLOR"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.pixel_type = PixelType::kFloat32; }, {"float32"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.image_type = "RF_REAL"; }, {"RF_REAL"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.orientation = "FM"; }, {"FM"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.orientation = "XX"; }, {"'XX'"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.orientation = ""; }, {"found none"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.orientation = "MFX"; }, {"'MFX'"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.orientation = "M"; }, {"'M'"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.image_type = "ELASTO"; }, {"'ELASTO'"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.depth = 2; }, {"slice", "2"}));
  EXPECT_TRUE(refused([](auto& p) { p.header.width = 0; }, {"0 x 0"}));
  EXPECT_TRUE(refused([](auto& p) { p.frame.image_valid = false; }, {"invalid"}));
  EXPECT_TRUE(refused([](auto& p) { p.frame.pixels.pop_back(); }, {"6", "5"}, Code::kUsage));
}

}  // namespace
}  // namespace nav::io
