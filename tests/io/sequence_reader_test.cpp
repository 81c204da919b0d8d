// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>

#include "io/sequence.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::put;
using test::rejects;
using test::text_of;
using Code = ErrorCode;

// 3 columns, 2 rows, 2 frames. All pixels differ.
const std::string kPixels = "abcdefghijkl";

std::string meta(const std::string& extra, const std::string& sizes = "3 2 2",
                 const std::string& type = "MET_UCHAR", const std::string& data = "LOCAL") {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
         "DimSize = " +
         sizes + "\nElementType = " + type + "\nUltrasoundImageOrientation = MF\n" + extra +
         "ElementDataFile = " + data + "\n";
}

const std::string kFrames =
    "Seq_Frame0000_Timestamp = 1.5\nSeq_Frame0000_ImageStatus = OK\n"
    "Seq_Frame0001_Timestamp = 1.25\nSeq_Frame0001_UnfilteredTimestamp = 2\n"
    "Seq_Frame0001_ImageStatus = INVALID\nSeq_Frame0001_Custom = a = b\n";

class SequenceReaderTest : public ::testing::Test {
 protected:
  Result<SequenceReader> open(const std::string& content, const std::string& name = "a.igs.mha") {
    put(folder_ / name, content);
    return SequenceReader::open(folder_ / name);
  }
  test::TemporaryFolder folder_;
};

TEST_F(SequenceReaderTest, AFileThatBecomesShorterIsAnErrorOfReadingNotOfTheFrame) {
  auto reader = open(meta(kFrames) + kPixels);
  ASSERT_TRUE(test::has_value(reader));
  ASSERT_TRUE(test::has_value(reader->read(1)));
  const auto file = folder_ / "a.igs.mha";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 3);
  for (const std::int64_t frame : {0, 1}) {
    EXPECT_TRUE(rejects(reader->read(frame), Code::kIo, {"became shorter", "a.igs.mha"}));
  }
}

TEST_F(SequenceReaderTest, AFileThatIsOverwrittenInPlaceIsAnErrorOfReading) {
  for (const bool compressed : {false, true}) {
    const std::string header = meta(kFrames + (compressed ? "CompressedData = True\n" : ""));
    auto reader = open(header + (compressed ? test::deflated(kPixels) : kPixels));
    ASSERT_TRUE(test::has_value(reader));
    const auto file = folder_ / "a.igs.mha";
    // The length stays; the clock of the file system may not tell the times apart.
    const auto before = std::filesystem::last_write_time(file);
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary) << "O";
    std::filesystem::last_write_time(file, before + std::chrono::milliseconds(20));
    EXPECT_TRUE(rejects(reader->read(1), Code::kIo, {"a.igs.mha", "was written to while"}));
  }
}

TEST_F(SequenceReaderTest, RejectsALineWithoutAnEndBeforeReadingAllOfIt) {
  put(folder_ / "a.igs.mha", "ObjectType = Image\n");
  std::filesystem::resize_file(folder_ / "a.igs.mha", std::uintmax_t{1} << 40);  // Zeros.
  EXPECT_TRUE(rejects(SequenceReader::open(folder_ / "a.igs.mha"), Code::kMalformedData,
                      {"a.igs.mha", "line 2", "at most 1 MiB"}));
  EXPECT_TRUE(rejects(open("Comment = " + std::string(3 << 20, 'x') + "\n" + meta("") + kPixels),
                      Code::kMalformedData, {"line 1", "at most 1 MiB"}));
}

TEST_F(SequenceReaderTest, ReadsRawFramesInAnyOrder) {
  auto reader = open(meta(kFrames + "Odd key = kept\n") + kPixels);
  ASSERT_TRUE(test::has_value(reader));
  const SequenceHeader& h = reader->header();
  EXPECT_EQ(h.width, 3);
  EXPECT_EQ(h.height, 2);
  EXPECT_EQ(h.depth, 1);
  EXPECT_EQ(h.components, 1);
  EXPECT_EQ(h.frame_count, 2);
  EXPECT_EQ(h.readable_frames, 2);
  EXPECT_EQ(h.orientation, "MF");
  EXPECT_EQ(h.image_type, "");
  EXPECT_EQ(h.format, "MetaImage");
  EXPECT_FALSE(h.compressed);
  EXPECT_EQ(h.fields.at("Odd key"), "kept");
  const auto second = reader->read(1);
  ASSERT_TRUE(test::has_value(second));
  EXPECT_EQ(text_of(second->pixels), "ghijkl");
  EXPECT_EQ(second->timestamp_s, 1.25);
  EXPECT_EQ(second->unfiltered_timestamp_s, 2.0);
  EXPECT_FALSE(second->image_valid);
  EXPECT_EQ(second->fields.at("Custom"), "a = b");
  const auto first = reader->read(0);
  ASSERT_TRUE(test::has_value(first));
  EXPECT_EQ(text_of(first->pixels), "abcdef");
  EXPECT_TRUE(first->image_valid);
  EXPECT_FALSE(first->unfiltered_timestamp_s.has_value());
  EXPECT_TRUE(rejects(reader->read(2), Code::kUsage, {"frame 2", "0 to 1"}));
  EXPECT_TRUE(rejects(reader->read(-1), Code::kUsage, {"frame -1"}));
}

TEST_F(SequenceReaderTest, ReadsFramesOfACompressedStreamInAnyOrder) {
  const std::string z = test::deflated(kPixels);
  auto reader =
      open(meta("CompressedData = True\nCompressedDataSize = " + std::to_string(z.size()) +
                "          \n" + kFrames) +
           z);
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_TRUE(reader->header().compressed);
  for (const std::int64_t index : {1, 0, 1, 1, 0}) {
    const auto frame = reader->read(index);
    ASSERT_TRUE(test::has_value(frame));
    EXPECT_EQ(text_of(frame->pixels), kPixels.substr(static_cast<std::size_t>(index) * 6, 6));
  }
}

/// Simulates a network folder that is unavailable for a while.
TEST_F(SequenceReaderTest, ReadsEqualFramesAfterAReadThatFailed) {
  constexpr std::size_t kFrameBytes = 40000;  // The reader reads 65536 bytes at a time.
  std::mt19937 random(5);
  std::string pixels(3 * kFrameBytes, '\0');
  for (char& c : pixels)
    c = static_cast<char>(random());  // Random bytes that deflate cannot
                                      // compress.
  const int descriptor = ::dup(0);    // The lowest free descriptor, which the reader will get.
  ::close(descriptor);
  auto reader = open(meta("CompressedData = True\n", "200 200 3") + test::deflated(pixels));
  ASSERT_TRUE(test::has_value(reader));
  ASSERT_TRUE(test::has_value(reader->read(0)));
  const int kept = ::dup(descriptor);
  ASSERT_GE(kept, 0);
  ASSERT_EQ(::close(descriptor), 0);
  EXPECT_TRUE(rejects(reader->read(1), Code::kIo, {"frame 1", "cannot read"}));
  ASSERT_EQ(::dup2(kept, descriptor), descriptor);
  ::close(kept);
  for (const std::size_t i : {1U, 2U, 0U}) {
    const auto frame = reader->read(static_cast<std::int64_t>(i));
    ASSERT_TRUE(test::has_value(frame)) << i;
    EXPECT_TRUE(test::text_of(frame->pixels) == pixels.substr(i * kFrameBytes, kFrameBytes)) << i;
  }
}

TEST_F(SequenceReaderTest, ReadsDetachedRawAndCompressedFiles) {
  put(folder_ / "a.raw", kPixels);
  auto raw = open(meta(kFrames, "3 2 2", "MET_UCHAR", "a.raw"), "a.igs.mhd");
  ASSERT_TRUE(test::has_value(raw));
  EXPECT_EQ(text_of(raw->read(1)->pixels), "ghijkl");
  put(folder_ / "a.zraw", test::deflated(kPixels));
  auto packed =
      open(meta("CompressedData = True\n" + kFrames, "3 2 2", "MET_UCHAR", "a.zraw"), "b.igs.mhd");
  ASSERT_TRUE(test::has_value(packed));
  EXPECT_EQ(text_of(packed->read(1)->pixels), "ghijkl");
  EXPECT_TRUE(rejects(open(meta(kFrames, "3 2 2", "MET_UCHAR", "none.raw"), "c.igs.mhd"),
                      Code::kNotFound, {"none.raw"}));
}

std::string nrrd(const std::string& encoding, const std::string& extra = "") {
  return "NRRD0004\n# a comment\ndimension: 3\nencoding: " + encoding +
         "\nendian: little\nkinds: domain domain   list\nsizes: 3 2   2\ntype: uint8\n" + extra +
         "ultrasound image orientation:=UN\nultrasound image type:=BRIGHTNESS\n"
         "Seq_Frame0000_Timestamp:=1.5\nSeq_Frame0000_Status:=OK\n"
         "Seq_Frame0001_Timestamp:=1.75\nSeq_Frame0001_Status:=INVALID\n";
}

TEST_F(SequenceReaderTest, ReadsNrrdWithItsOwnStatusKey) {
  constexpr int kGzip = 31;
  const std::string gz = test::deflated(kPixels, kGzip);
  // gzip allows several members one after the other.
  const std::string members =
      test::deflated(kPixels.substr(0, 4), kGzip) + test::deflated(kPixels.substr(4), kGzip);
  for (const std::string& content :
       {nrrd("raw") + "\n" + kPixels, nrrd("gzip") + "\n" + gz, nrrd("gz") + "\n" + members}) {
    auto reader = open(content, "a.igs.nrrd");
    ASSERT_TRUE(test::has_value(reader));
    EXPECT_EQ(reader->header().format, "NRRD");
    EXPECT_EQ(reader->header().orientation, "UN");
    EXPECT_EQ(reader->header().image_type, "BRIGHTNESS");
    const auto second = reader->read(1);
    ASSERT_TRUE(test::has_value(second));
    EXPECT_EQ(text_of(second->pixels), "ghijkl");
    EXPECT_FALSE(second->image_valid);
    EXPECT_TRUE(reader->read(0)->image_valid);
  }
  put(folder_ / "d.raw", kPixels);
  auto detached = open(nrrd("raw", "data file: d.raw\n"), "a.nhdr");
  ASSERT_TRUE(test::has_value(detached));
  EXPECT_EQ(text_of(detached->read(1)->pixels), "ghijkl");
}

TEST_F(SequenceReaderTest, ReadsColourVolumesAndSingleImages) {
  auto colour = open(
      "NRRD0004\ndimension: 4\nencoding: raw\nkinds: vector domain domain list\n"
      "sizes: 3 2 1 2\ntype: uint8\n\n" +
          kPixels,
      "c.nrrd");
  ASSERT_TRUE(test::has_value(colour));
  EXPECT_EQ(colour->header().components, 3);
  EXPECT_EQ(colour->header().width, 2);
  EXPECT_EQ(text_of(colour->read(1)->pixels), "ghijkl");

  std::string four = meta("", "3 2 1 2");
  four.replace(four.find("NDims = 3"), 9, "NDims = 4");
  auto volume = open(four + kPixels);
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->header().depth, 1);
  EXPECT_EQ(volume->header().frame_count, 2);
  EXPECT_EQ(text_of(volume->read(1)->pixels), "ghijkl");

  std::string two = meta("", "3 4");
  two.replace(two.find("NDims = 3"), 9, "NDims = 2");
  auto single = open(two + kPixels);
  ASSERT_TRUE(test::has_value(single));
  EXPECT_EQ(single->header().frame_count, 1);
  EXPECT_EQ(single->header().height, 4);

  auto still = open(meta("Kinds = domain domain domain\n", "3 2 2") + kPixels);
  ASSERT_TRUE(test::has_value(still));
  EXPECT_EQ(still->header().frame_count, 1);
  EXPECT_EQ(still->header().depth, 2);
}

TEST_F(SequenceReaderTest, SwapsTheBytesOfBigEndianSamples) {
  const std::vector<std::int16_t> values = {1, -2, 300, -400, 5000, -6000};
  auto reader = open(
      "NDims = 3\nDimSize = 3 2 1\nElementType = MET_SHORT\n"
      "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n" +
      test::swapped_bytes_of(values));
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_EQ(text_of(reader->read(0)->pixels), test::bytes_of(values));
}

TEST_F(SequenceReaderTest, OpensRecordingsWithoutImages) {
  auto reader = open(meta(kFrames, "0 0 2"));
  ASSERT_TRUE(test::has_value(reader));
  const auto frame = reader->read(0);
  ASSERT_TRUE(test::has_value(frame));
  EXPECT_TRUE(frame->pixels.empty());
  EXPECT_FALSE(frame->image_valid);
  EXPECT_EQ(frame->timestamp_s, 1.5);
}

TEST_F(SequenceReaderTest, AcceptsTimestampsInAnyOrder) {
  auto reader = open(meta(kFrames) + kPixels);  // The timestamps are 1.5 s, then 1.25 s.
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_LT(*reader->frame_fields(1)->timestamp_s, *reader->frame_fields(0)->timestamp_s);
}

TEST_F(SequenceReaderTest, NamesTheFrameAndFieldOfABadTimestamp) {
  for (const char* text : {"nan", "inf", "12,5", "", "1.5s", "0x10"}) {
    auto reader = open(meta(std::string("Seq_Frame0001_Timestamp = ") + text + "\n") + kPixels);
    ASSERT_TRUE(test::has_value(reader));
    EXPECT_TRUE(
        rejects(reader->read(1), Code::kMalformedData, {"a.igs.mha", "frame 1", "Timestamp", text}))
        << text;
    EXPECT_TRUE(test::has_value(reader->read(0)));
  }
}

TEST_F(SequenceReaderTest, ReadsTheFramesBeforeADefectAndNamesTheDefectiveOne) {
  auto raw = open(meta(kFrames) + kPixels.substr(0, 9));
  ASSERT_TRUE(test::has_value(raw));
  EXPECT_EQ(raw->header().readable_frames, 1);
  EXPECT_EQ(text_of(raw->read(0)->pixels), "abcdef");
  EXPECT_TRUE(rejects(raw->read(1), Code::kMalformedData, {"frame 1", "cut short", "12", "9"}));

  // Random bytes do not compress, so the stream is cut at the same fraction as the file.
  std::string noise;
  unsigned state = 7;
  for (int i = 0; i < 1000 * 20; ++i) {
    state = state * 1664525U + 1013904223U;
    noise += static_cast<char>(state >> 24);
  }
  const std::string z = test::deflated(noise);
  auto packed = open(meta("CompressedData = True\n", "100 10 20") + z.substr(0, z.size() / 2));
  ASSERT_TRUE(test::has_value(packed));
  EXPECT_EQ(text_of(packed->read(5)->pixels), noise.substr(5000, 1000));
  EXPECT_TRUE(rejects(packed->read(15), Code::kMalformedData, {"frame 15", "cut short"}));
  EXPECT_EQ(text_of(packed->read(1)->pixels), noise.substr(1000, 1000));

  // All samples are there, but their checksum is missing.
  auto unchecked = open(meta("CompressedData = True\n", "100 10 20") + z.substr(0, z.size() - 2));
  ASSERT_TRUE(test::has_value(unchecked));
  EXPECT_TRUE(rejects(unchecked->read(19), Code::kMalformedData, {"frame 19", "cut short"}));
  std::string damaged = z;
  damaged[z.size() / 2] = static_cast<char>(damaged[z.size() / 2] ^ 0x55);
  auto broken = open(meta("CompressedData = True\n", "100 10 20") + damaged);
  ASSERT_TRUE(test::has_value(broken));
  EXPECT_TRUE(rejects(broken->read(19), Code::kMalformedData, {"frame 19", "damaged"}));
}

TEST_F(SequenceReaderTest, RejectsSizesThatTheFileCannotHold) {
  const std::string body(1000, 'x');
  EXPECT_TRUE(rejects(open(meta("", "40000 25000 1") + body), Code::kMalformedData,
                      {"1000000000", "1000"}));
  EXPECT_TRUE(rejects(open(meta("CompressedData = True\n", "1000 1000 1000") + body),
                      Code::kMalformedData, {"1000000000", "1100 times"}));
  EXPECT_TRUE(rejects(open(meta("", "4000000000 4000000000 4000000000") + body),
                      Code::kMalformedData, {"2^63"}));
  EXPECT_TRUE(rejects(open(meta("", "3 2 0")), Code::kMalformedData, {"at least 1 frame"}));
  EXPECT_TRUE(rejects(open(meta("", "3 -2 1")), Code::kMalformedData, {"DimSize", "3 -2 1"}));
  EXPECT_TRUE(rejects(open(meta("", "3 2")), Code::kMalformedData, {"DimSize", "3 sizes"}));
  EXPECT_TRUE(rejects(open(meta("", "3 2 nan")), Code::kMalformedData, {"DimSize"}));
  // Frames without pixels need no space in the file, but the reader visits every one of them.
  auto frames = open(meta("", "0 0 10000000"));
  ASSERT_TRUE(test::has_value(frames));
  EXPECT_TRUE(test::has_value(frames->read(9999999)));
  EXPECT_TRUE(rejects(open(meta("", "0 0 1000000000000")), Code::kMalformedData,
                      {"at most 10000000 frames", "1000000000000"}));
}

TEST_F(SequenceReaderTest, RejectsFilesThatAreNoSequence) {
  EXPECT_TRUE(rejects(SequenceReader::open(folder_ / "none.mha"), Code::kNotFound, {"none.mha"}));
  EXPECT_TRUE(rejects(SequenceReader::open(folder_.path()), Code::kIo, {"folder"}));
  EXPECT_TRUE(rejects(SequenceReader::open("/dev/zero"), Code::kIo, {"special file"}));
  EXPECT_TRUE(rejects(open(""), Code::kMalformedData, {"cut short"}));
  EXPECT_TRUE(rejects(open("hello\nworld\n"), Code::kUnsupportedData, {"hello"}));
  EXPECT_TRUE(rejects(open(std::string(5000, '\0')), Code::kMalformedData, {"line of text"}));
  const std::string good = meta(kFrames);
  EXPECT_TRUE(rejects(open(good.substr(0, good.size() / 2)), Code::kMalformedData,
                      {"cut short", "ElementDataFile"}));
  EXPECT_TRUE(rejects(open("ObjectType = Image\nno equals sign\n" + good), Code::kMalformedData,
                      {"line 2", "no equals sign"}));
  EXPECT_TRUE(rejects(open(meta("DimSize = 4 2 2\n") + kPixels), Code::kMalformedData,
                      {"DimSize", "3 2 2", "4 2 2"}));
  EXPECT_TRUE(rejects(open(meta("Seq_Frame0007_Timestamp = 1\n") + kPixels), Code::kMalformedData,
                      {"Seq_Frame0007_Timestamp", "below 2"}));
  EXPECT_TRUE(
      rejects(open(meta("Seq_Frame0001_Timestamp = 1\nSeq_Frame0001_Timestamp = 2\n") + kPixels),
              Code::kMalformedData, {"frame 1", "Timestamp", "'1'", "'2'"}));
  EXPECT_TRUE(rejects(open(meta("", "3 2 2", "MET_UCHAR_ARRAY") + kPixels), Code::kMalformedData,
                      {"ElementType"}));
  EXPECT_TRUE(rejects(open(meta("Kinds = list domain domain\n") + kPixels), Code::kUnsupportedData,
                      {"list"}));
  EXPECT_TRUE(rejects(open(meta("CompressedData = maybe\n") + kPixels), Code::kMalformedData,
                      {"CompressedData", "maybe"}));
  EXPECT_TRUE(rejects(
      open("NRRD0004\ndimension: 3\nsizes: 3 2 2\ntype: uint8\nencoding: hex\n\n", "h.nrrd"),
      Code::kUnsupportedData, {"encoding", "hex"}));
}

// Each of the next tests covers a defect of other readers of this format.

TEST_F(SequenceReaderTest, ReadsFramesBeyondFourGigabytes) {
  // One frame has 820 × 616 bytes. Frame 9000 starts at byte 4 546 080 000, which 32 bits would cut
  // to 251 112 704.
  constexpr std::int64_t kFrameBytes = 820LL * 616;
  constexpr std::int64_t kFrame = 9000;
  const auto raw = folder_ / "big.raw";
  put(raw, "");
  std::filesystem::resize_file(raw, static_cast<std::uintmax_t>(kFrameBytes * 9001));  // A sparse
                                                                                       // file.
  {
    std::fstream out(raw, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(kFrameBytes * kFrame);
    out << "here";
    out.seekp((kFrameBytes * kFrame) & 0xffffffff);
    out << "lost";
  }
  auto reader = open(meta("", "820 616 9001", "MET_UCHAR", "big.raw"), "big.igs.mhd");
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_EQ(reader->header().readable_frames, 9001);
  const auto frame = reader->read(kFrame);
  ASSERT_TRUE(test::has_value(frame));
  EXPECT_EQ(text_of(frame->pixels).substr(0, 4), "here");
  EXPECT_EQ(static_cast<std::int64_t>(frame->pixels.size()), kFrameBytes);
  EXPECT_TRUE(rejects(reader->read(9001), Code::kUsage, {"frame 9001"}));
}

TEST_F(SequenceReaderTest, AcceptsCompressedSizesBeyondFourGigabytes) {
  const std::string z = test::deflated(kPixels);
  auto reader =
      open(meta("CompressedData = True\nCompressedDataSize = 6000000000        \n" + kFrames) + z);
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_EQ(text_of(reader->read(1)->pixels), "ghijkl");
}

TEST_F(SequenceReaderTest, ReadsLinesOfAnyLength) {
  const std::string longer(300000, 'v');  // Longer than one chunk of the reader.
  auto reader = open(
      meta("Seq_Frame0001_Note = " + longer + "\nLong = " + longer + "\n" + kFrames) + kPixels);
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_EQ(reader->frame_fields(1)->fields.at("Note"), longer);
  EXPECT_EQ(reader->header().fields.at("Long"), longer);
  EXPECT_EQ(text_of(reader->read(1)->pixels), "ghijkl");
}

TEST_F(SequenceReaderTest, ReadsFrameNumbersOfFiveDigits) {
  auto reader =
      open(meta("Seq_Frame9999_Timestamp = 1\nSeq_Frame10000_Timestamp = 2\n"
                "Seq_Frame12344_Timestamp = 3\n",
                "0 0 12345"));
  ASSERT_TRUE(test::has_value(reader));
  EXPECT_EQ(reader->frame_fields(9999)->timestamp_s, 1.0);
  EXPECT_EQ(reader->frame_fields(10000)->timestamp_s, 2.0);
  EXPECT_EQ(reader->frame_fields(12344)->timestamp_s, 3.0);
  EXPECT_FALSE(reader->frame_fields(1000)->timestamp_s.has_value());
}

}  // namespace
}  // namespace nav::io
