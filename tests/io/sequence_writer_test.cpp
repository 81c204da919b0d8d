// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/sequence_writer.hpp"

#include <climits>
#include <gtest/gtest.h>
#include <limits>

#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

SequenceHeader header(int width, int height, PixelType type, bool compressed) {
  SequenceHeader h;
  h.width = width;
  h.height = height;
  h.pixel_type = type;
  h.orientation = "UN";
  h.image_type = "BRIGHTNESS";
  h.compressed = compressed;
  h.fields["DimSize"] = "999 999 999";  // The writer replaces this field.
  h.fields["Device"] = "phantom";
  return h;
}

SequenceImage frame(std::int64_t index, std::size_t bytes) {
  SequenceImage f;
  f.timestamp_s = 0.1 * static_cast<double>(index);
  f.unfiltered_timestamp_s = 0.1 * static_cast<double>(index) + 0.001;
  f.image_valid = index != 1;
  f.fields["FrameNumber"] = std::to_string(index + 100);
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(0, 3) = 1.0 / 3 + static_cast<double>(index);
  set_transform(f, {"ProbeToTracker", m, TrackingStatus::kOk});
  for (std::size_t i = 0; i < bytes; ++i) {
    f.pixels.push_back(static_cast<std::byte>(i * 7 + static_cast<std::size_t>(index)));
  }
  return f;
}

struct Case {
  const char* name;
  bool compressed;
};

class SequenceWriterTest : public ::testing::Test {
 protected:
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_.path()), {}));
  }
  test::TemporaryFolder folder_;
};

TEST_F(SequenceWriterTest, RoundTripsEveryFormat) {
  for (const Case& c : {Case{"a.igs.mha", false}, Case{"b.igs.mha", true},
                        Case{"c.igs.nrrd", false}, Case{"d.igs.nrrd", true}}) {
    auto h = header(5, 3, PixelType::kInt16, c.compressed);
    auto writer = SequenceWriter::create(folder_ / c.name, h);
    ASSERT_TRUE(test::has_value(writer));
    for (std::int64_t i = 0; i < 4; ++i) {
      ASSERT_TRUE(test::has_value(writer->append(frame(i, 30))));
    }
    ASSERT_TRUE(test::has_value(writer->finish()));
    auto reader = SequenceReader::open(folder_ / c.name);
    ASSERT_TRUE(test::has_value(reader)) << c.name;
    EXPECT_EQ(reader->header().width, 5);
    EXPECT_EQ(reader->header().height, 3);
    EXPECT_EQ(reader->header().frame_count, 4);
    EXPECT_EQ(reader->header().orientation, "UN");
    EXPECT_EQ(reader->header().image_type, "BRIGHTNESS");
    EXPECT_EQ(reader->header().compressed, c.compressed);
    EXPECT_EQ(reader->header().pixel_type, PixelType::kInt16);
    EXPECT_EQ(reader->header().fields.at("Device"), "phantom");
    for (std::int64_t i = 0; i < 4; ++i) {
      const auto back = reader->read(i);
      ASSERT_TRUE(test::has_value(back)) << c.name;
      const SequenceImage sent = frame(i, 30);
      EXPECT_EQ(back->pixels, sent.pixels);
      EXPECT_EQ(back->timestamp_s, sent.timestamp_s);  // The numbers are equal bit for bit.
      EXPECT_EQ(back->unfiltered_timestamp_s, sent.unfiltered_timestamp_s);
      EXPECT_EQ(back->image_valid, sent.image_valid);
      EXPECT_EQ(back->fields.at("FrameNumber"), sent.fields.at("FrameNumber"));
      EXPECT_EQ(transform(*back, "ProbeToTracker")->to_from_from,
                transform(sent, "ProbeToTracker")->to_from_from);
    }
  }
  EXPECT_EQ(files(), 4U);
}

TEST_F(SequenceWriterTest, WritesTheHeaderThatPlusWrites) {
  SequenceHeader h;
  h.width = 2;
  h.height = 1;
  auto writer = SequenceWriter::create(folder_ / "p.igs.mha", h);
  ASSERT_TRUE(test::has_value(writer));
  SequenceImage f;
  f.image_valid = true;
  f.timestamp_s = 215.102186;
  f.pixels = {std::byte{'x'}, std::byte{'y'}};
  set_transform(f, {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kOk});
  ASSERT_TRUE(test::has_value(writer->append(f)));
  ASSERT_TRUE(test::has_value(writer->finish()));
  EXPECT_EQ(test::get(folder_ / "p.igs.mha"),
            "ObjectType = Image\n"
            "NDims = 3\n"
            "AnatomicalOrientation = RAI\n"
            "BinaryData = True\n"
            "BinaryDataByteOrderMSB = False\n"
            "CenterOfRotation = 0 0 0\n"
            "CompressedData = False\n"
            "DimSize = 2 1 1               \n"
            "Kinds = domain domain list\n"
            "ElementNumberOfChannels = 1\n"
            "ElementSpacing = 1 1 1\n"
            "ElementType = MET_UCHAR\n"
            "Offset = 0 0 0\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\n"
            "UltrasoundImageOrientation = MF\n"
            "UltrasoundImageType = BRIGHTNESS\n"
            "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
            "Seq_Frame0000_ProbeToTrackerTransformStatus = OK\n"
            "Seq_Frame0000_Timestamp = 215.102186\n"
            "Seq_Frame0000_ImageStatus = OK\n"
            "ElementDataFile = LOCAL\n"
            "xy");
}

TEST_F(SequenceWriterTest, PadsTheCompressedSizeAndWritesFiveDigitFrameNumbers) {
  auto writer = SequenceWriter::create(folder_ / "t.mha", header(0, 0, PixelType::kUint8, true));
  ASSERT_TRUE(test::has_value(writer));
  for (std::int64_t i = 0; i <= 10000; ++i) {
    SequenceImage f;
    f.timestamp_s = static_cast<double>(i);
    ASSERT_TRUE(test::has_value(writer->append(f)));
  }
  ASSERT_TRUE(test::has_value(writer->finish()));
  const std::string text = test::get(folder_ / "t.mha");
  const auto at = text.find("CompressedDataSize = ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(text.find('\n', at) - at, std::string("CompressedDataSize = ").size() + 40);
  EXPECT_NE(text.find("Seq_Frame9999_Timestamp = 9999\n"), std::string::npos);
  EXPECT_NE(text.find("Seq_Frame10000_Timestamp = 10000\n"), std::string::npos);
  EXPECT_EQ(SequenceReader::open(folder_ / "t.mha")->frame_fields(10000)->timestamp_s, 10000.0);
}

TEST_F(SequenceWriterTest, EqualFramesGiveEqualBytes) {
  for (const char* name : {"x.nrrd", "y.nrrd"}) {
    auto writer = SequenceWriter::create(folder_ / name, header(5, 3, PixelType::kUint8, true));
    ASSERT_TRUE(test::has_value(writer));
    for (std::int64_t i = 0; i < 3; ++i) {
      ASSERT_TRUE(test::has_value(writer->append(frame(i, 15))));
    }
    ASSERT_TRUE(test::has_value(writer->finish()));
  }
  EXPECT_EQ(test::get(folder_ / "x.nrrd"), test::get(folder_ / "y.nrrd"));
}

TEST_F(SequenceWriterTest, RoundTripsColourAndVolumes) {
  auto h = header(2, 3, PixelType::kUint8, true);
  h.components = 3;
  h.depth = 2;
  h.image_type = "RGB_COLOR";
  for (const char* name : {"c.mha", "c.nrrd"}) {
    auto writer = SequenceWriter::create(folder_ / name, h);
    ASSERT_TRUE(test::has_value(writer));
    ASSERT_TRUE(test::has_value(writer->append(frame(0, 36))));
    ASSERT_TRUE(test::has_value(writer->finish()));
    auto reader = SequenceReader::open(folder_ / name);
    ASSERT_TRUE(test::has_value(reader));
    EXPECT_EQ(reader->header().components, 3);
    EXPECT_EQ(reader->header().depth, 2);
    EXPECT_EQ(reader->read(0)->pixels, frame(0, 36).pixels);
  }
}

TEST_F(SequenceWriterTest, WritesNoFileWithoutFinish) {
  {
    auto writer = SequenceWriter::create(folder_ / "a.mha", header(5, 3, PixelType::kUint8, false));
    ASSERT_TRUE(test::has_value(writer));
    ASSERT_TRUE(test::has_value(writer->append(frame(0, 15))));
    EXPECT_EQ(files(), 0U);  // There is not even a temporary file.
  }
  EXPECT_EQ(files(), 0U);
  test::put(folder_ / "old.mha", "old");
  {
    auto writer =
        SequenceWriter::create(folder_ / "old.mha", header(5, 3, PixelType::kUint8, false));
    ASSERT_TRUE(test::has_value(writer));
    EXPECT_TRUE(rejects(writer->finish(), Code::kRefused, {"old.mha", "at least 1 frame"}));
  }
  EXPECT_EQ(test::get(folder_ / "old.mha"), "old");
}

TEST_F(SequenceWriterTest, AcceptsEveryNameLengthThatTheSystemAccepts) {
  const std::string longest = std::string(NAME_MAX - 4, 'x') + ".mha";
  const auto shape = header(5, 3, PixelType::kUint8, false);
  auto writer = SequenceWriter::create(folder_ / longest, shape);
  ASSERT_TRUE(test::has_value(writer));
  ASSERT_TRUE(test::has_value(writer->append(frame(0, 15))));
  ASSERT_TRUE(test::has_value(writer->finish()));
  EXPECT_TRUE(std::filesystem::exists(folder_ / longest));
  // The writer reports the error before anything is recorded.
  EXPECT_TRUE(rejects(SequenceWriter::create(folder_ / ("x" + longest), shape), Code::kIo,
                      {longest, "create", "too long"}));
}

TEST_F(SequenceWriterTest, RejectsFramesThatWouldBreakTheFile) {
  const auto h = header(5, 3, PixelType::kUint8, false);
  EXPECT_TRUE(rejects(SequenceWriter::create(folder_ / "a.mhd", h), Code::kUsage, {".mha"}));
  EXPECT_TRUE(
      rejects(SequenceWriter::create(folder_.path() / "no" / "a.mha", h), Code::kIo, {"a.mha"}));
  auto writer = SequenceWriter::create(folder_ / "a.mha", h);
  ASSERT_TRUE(test::has_value(writer));
  EXPECT_TRUE(rejects(writer->append(frame(0, 14)), Code::kUsage, {"frame 0", "15", "14"}));
  auto bad = frame(0, 15);
  bad.fields["Note"] = "two\nlines";
  EXPECT_TRUE(rejects(writer->append(bad), Code::kUsage, {"Note", "two\\nlines"}));
  bad = frame(0, 15);
  bad.fields["a=b"] = "x";
  EXPECT_TRUE(rejects(writer->append(bad), Code::kUsage, {"a=b"}));
  bad = frame(0, 15);
  bad.timestamp_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(rejects(writer->append(bad), Code::kUsage, {"timestamp", "nan"}));
  // Rejected frames do not change the file.
  ASSERT_TRUE(test::has_value(writer->append(frame(0, 15))));
  ASSERT_TRUE(test::has_value(writer->finish()));
  EXPECT_EQ(SequenceReader::open(folder_ / "a.mha")->header().frame_count, 1);
}

}  // namespace
}  // namespace nav::io
