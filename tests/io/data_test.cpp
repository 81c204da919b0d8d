// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdlib>
#include <gtest/gtest.h>

#include "io/ct.hpp"
#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "io/transform_tree.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::says;

struct Recording {
  const char* name;
  int width, height;
  std::int64_t frames;
  const char* rejected;  ///< Reason why frame 0 is no B-mode image. Empty if it is one.
};

// The frame counts are those of DimSize. The reasons for a rejection come from each header.
const std::array kRecordings = {
    Recording{"BkCurvilinearRfData.igs.mhd", 3480, 358, 1, "radio-frequency"},
    Recording{"BkCurvilinearScanConvertedData.igs.mha", 600, 400, 1, ""},
    Recording{"BoneUltrasound_L14.igs.mha", 820, 616, 21, ""},
    Recording{"ColorNrrdSample.igs.nrrd", 1152, 648, 1, ""},
    Recording{"NrrdSample.igs.nrrd", 256, 256, 1, ""},
    Recording{"NwirePhantomFreehand.igs.mha", 820, 616, 97, ""},
    Recording{"NwirePhantomFreehand.igs.nrrd", 820, 616, 97, ""},
    Recording{"NwirePhantomFreehandCropped.igs.mha", 200, 150, 20, ""},
    Recording{"ReferenceToRASCalibration.igs.mha", 0, 0, 93, "0 x 0"},
    Recording{"SegmentationTest_BKMedical_RandomStepperMotionData2_Trimmed.igs.mha", 640, 480, 6,
              ""},
    Recording{"SpinePhantomFreehand.igs.mha", 820, 616, 21, ""},
    Recording{"SyntheticTrackerBuffer20.igs.mha", 1, 1, 20, ""},
    Recording{"SyntheticVideoBuffer20.igs.mha", 320, 240, 20, ""},
    Recording{"TimestampFilteringTest.igs.mha", 1, 1, 500, ""},
    Recording{"TransformInterpolationTest.igs.mha", 1, 1, 500, ""},
    Recording{"USTC_3NWires_ProbeTranslation.igs.mha", 820, 616, 159, ""},
    Recording{"UltrasonixCurvilinearBrightnessData.igs.mha", 3640, 96, 5, "beam-wise"},
    Recording{"UltrasonixCurvilinearScanConvertedDataGroundTruth.igs.mha", 820, 616, 5, ""},
    Recording{"fCal_Test_Calibration_3NWires.igs.mha", 820, 616, 188, ""},
    Recording{"fCal_Test_Validation_3NWires.igs.mha", 820, 616, 94, ""},
    Recording{"outputPlusTransverseProcessEnhancerTest.igs.mha", 820, 616, 21, ""},
};

TEST(RecordedSequenceTest, ReadsEveryRecordingToItsEnd) {
  SONDE_REQUIRE_DATA(folder, "plus-sequences/sequences");
  for (const Recording& r : kRecordings) {
    auto reader = SequenceReader::open(folder / r.name);
    ASSERT_TRUE(test::has_value(reader));
    EXPECT_EQ(reader->header().width, r.width) << r.name;
    EXPECT_EQ(reader->header().height, r.height) << r.name;
    ASSERT_EQ(reader->header().frame_count, r.frames) << r.name;
    for (std::int64_t i = 0; i < r.frames; ++i) {
      const auto frame = reader->read(i);
      ASSERT_TRUE(test::has_value(frame)) << r.name;
      for (const std::string& name : transform_names(*frame)) {
        ASSERT_TRUE(test::has_value(transform(*frame, name))) << r.name;
      }
      const auto image = brightness_image(reader->header(), *frame);
      if (*r.rejected == '\0') {
        ASSERT_TRUE(test::has_value(image)) << r.name;
      } else {
        ASSERT_TRUE(test::rejects(image, ErrorCode::kUnsupportedData, {r.name, r.rejected}));
      }
    }
  }
  // The table lists every recording of the folder.
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().find(".igs.") != std::string::npos) ++found;
  }
  EXPECT_EQ(found, kRecordings.size());
}

TEST(RecordedSequenceTest, KeepsTheColoursOfAScreen) {
  SONDE_REQUIRE_DATA(folder, "plus-sequences/sequences");
  auto reader = SequenceReader::open(folder / "ColorNrrdSample.igs.nrrd");
  ASSERT_TRUE(test::has_value(reader));
  const auto frame = reader->read(0);
  ASSERT_TRUE(test::has_value(frame));
  GreyScale scale;
  const auto image = sequence_image(reader->header(), *frame, scale);
  ASSERT_TRUE(test::has_value(image));
  ASSERT_EQ(image->colours.width(), 1152);
  ASSERT_EQ(image->colours.height(), 648);
  // Counted in the decompressed file: three bytes that are not equal.
  EXPECT_EQ(std::ranges::count_if(image->colours.pixels(),
                                  [](const Rgb8& p) { return p.r != p.g || p.g != p.b; }),
            181'628);
}

TEST(RecordedSequenceTest, BothFormatsOfOneRecordingAgree) {
  SONDE_REQUIRE_DATA(folder, "plus-sequences/sequences");
  auto mha = SequenceReader::open(folder / "NwirePhantomFreehand.igs.mha");
  auto nrrd = SequenceReader::open(folder / "NwirePhantomFreehand.igs.nrrd");
  ASSERT_TRUE(test::has_value(mha));
  ASSERT_TRUE(test::has_value(nrrd));
  for (std::int64_t i = 0; i < 97; ++i) {
    const auto a = mha->read(i);
    const auto b = nrrd->read(i);
    ASSERT_TRUE(test::has_value(a));
    ASSERT_TRUE(test::has_value(b));
    ASSERT_EQ(a->pixels, b->pixels);
    ASSERT_EQ(a->timestamp_s, b->timestamp_s);
    ASSERT_EQ(a->image_valid, b->image_valid);
    ASSERT_EQ(transform(*a, "ProbeToTracker")->to_from_from,
              transform(*b, "ProbeToTracker")->to_from_from);
    ASSERT_EQ(transform(*a, "StylusToTracker")->status, TrackingStatus::kInvalid);
  }
}

TEST(RecordedConfigTest, ReadsEveryConfiguration) {
  SONDE_REQUIRE_DATA(folder, "plus-sequences/config");
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".xml") continue;
    ++found;
    EXPECT_TRUE(test::has_value(read_plus_config(entry.path()))) << entry.path();
  }
  EXPECT_GE(found, 12U);
}

TEST(RecordedConfigTest, PositionsARecordedImageInTheReference) {
  SONDE_REQUIRE_DATA(folder, "plus-sequences");
  const auto config = read_plus_config(folder / "config/BoneUltrasound_L14_config.xml");
  ASSERT_TRUE(test::has_value(config));
  auto reader = SequenceReader::open(folder / "sequences/BoneUltrasound_L14.igs.mha");
  ASSERT_TRUE(test::has_value(reader));
  const auto frame = reader->frame_fields(4);
  ASSERT_TRUE(test::has_value(frame));
  const auto tree = TransformTree::create(transform_names(*frame), config->transforms);
  ASSERT_TRUE(test::has_value(tree));
  const auto chain = tree->find("Image", "Reference");
  ASSERT_TRUE(test::has_value(chain));
  const auto placed = chain->evaluate(*frame);
  ASSERT_TRUE(test::has_value(placed));
  EXPECT_EQ(placed->status, TrackingStatus::kOk);
  const auto calibration =
      calibration_from_matrix(config->find("Image", "Probe")->to_from_from, 820, 616);
  ASSERT_TRUE(test::has_value(calibration));
  // The configuration states the pixel spacing of the scanner: 0.085 mm.
  constexpr double kCalibrationMm = 0.001;
  EXPECT_NEAR(calibration->grid.mm_per_pixel.col(0).norm(), 0.085, kCalibrationMm);
  EXPECT_NEAR(calibration->grid.mm_per_pixel.col(1).norm(), 0.085, kCalibrationMm);
}

TEST(RecordedCtTest, HeadIsEqualInBothFormats) {
  SONDE_REQUIRE_DATA(folder, "ct-headsq");
  CollectingDiagnostics diagnostics;
  const auto dicom = read_ct(folder / "dicom", diagnostics);
  ASSERT_TRUE(test::has_value(dicom));
  // This head is stored without air below -200 HU.
  ASSERT_EQ(diagnostics.entries().size(), 1U);
  ASSERT_TRUE(diagnostics.entries()[0].finding);
  EXPECT_EQ(diagnostics.entries()[0].finding->key, "unit of the values");
  EXPECT_TRUE(test::rejects(read_ct(folder / "raw/quarter.nhdr", diagnostics),
                            ErrorCode::kUnsupportedData, {"3D-left-handed"}));
  CtOptions options;
  options.accept_unknown_orientation = true;
  const auto raw = read_ct(folder / "raw/quarter.nhdr", diagnostics, options);
  ASSERT_TRUE(test::has_value(raw));
  EXPECT_TRUE(says(diagnostics, Severity::kWarning, {"3D-left-handed"}));
  const std::array<int, 3> size = {64, 64, 93};
  ASSERT_EQ(dicom->grid().size, size);
  ASSERT_EQ(raw->grid().size, size);
  EXPECT_LT((dicom->grid().spacing_mm - Eigen::Vector3d(3.2, 3.2, 1.5)).norm(), 1e-9);
  EXPECT_LT((raw->grid().spacing_mm - Eigen::Vector3d(3.2, 3.2, 1.5)).norm(), 1e-9);
  // One format stores the slices from the top, the other from the bottom.
  std::size_t different = 0;
  for (int k = 0; k < 93; ++k) {
    for (int j = 0; j < 64; ++j) {
      for (int i = 0; i < 64; ++i) different += dicom->at(i, j, k) != raw->at(i, j, 92 - k);
    }
  }
  EXPECT_EQ(different, 0U);
}

/// Unpacks an archive into a folder. Returns false if the machine has no zstd.
bool unpack(const std::filesystem::path& archive, const std::filesystem::path& folder) {
  const std::string command =
      "tar -I zstd -xf '" + archive.string() + "' -C '" + folder.string() + "' 2>/dev/null";
  return std::system("zstd --version >/dev/null 2>&1") == 0 && std::system(command.c_str()) == 0;
}

double fraction(const Volume& v, int low, int high) {
  const auto hu = v.hu();
  const auto n =
      std::count_if(hu.begin(), hu.end(), [&](std::int16_t x) { return x >= low && x <= high; });
  return static_cast<double>(n) / static_cast<double>(hu.size());
}

TEST(RecordedCtTest, PelvisWithSlopeTenIsInHounsfieldUnits) {
  SONDE_REQUIRE_DATA(archive, "ucl-pelvis/dicom_2mm_236.tar.zst");
  const test::TemporaryFolder folder;
  if (!unpack(archive, folder.path())) GTEST_SKIP() << "zstd is missing";
  CollectingDiagnostics diagnostics;
  const auto v = read_ct(folder.path(), diagnostics);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(v->grid().size, (std::array<int, 3>{512, 512, 236}));
  EXPECT_LT((v->grid().spacing_mm - Eigen::Vector3d(0.9140625, 0.9140625, 2)).norm(), 1e-3);
  EXPECT_GT(fraction(*v, -1024, -950), 0.5);   // Air around the phantom.
  EXPECT_GT(fraction(*v, 300, 3000), 0.002);   // Bone.
  EXPECT_LT(fraction(*v, 3001, 32767), 0.01);  // The values are not ten times too large.
}

TEST(RecordedCtTest, ResamplesTheTiltedHead) {
  SONDE_REQUIRE_DATA(archive, "ct-gantry-tilt/GE_human_head_tilt18.5_varspacing.tar.zst");
  const test::TemporaryFolder folder;
  if (!unpack(archive, folder.path())) GTEST_SKIP() << "zstd is missing";
  CollectingDiagnostics diagnostics;
  const auto v = read_ct(folder.path(), diagnostics);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_TRUE(says(diagnostics, Severity::kWarning, {"18.5 degrees", "gaps from 1.08 mm to 7 mm"}));
  EXPECT_GT(fraction(*v, 0, 100), 0.05);  // Brain.
  CtOptions strict;
  strict.max_gap_mm = 5;
  EXPECT_TRUE(test::rejects(read_ct(folder.path(), diagnostics, strict), ErrorCode::kMalformedData,
                            {"at most 5 mm", "7 mm before"}));
}

TEST(RecordedCtTest, SmallVolumesHavePlausibleGeometry) {
  struct Case {
    const char* path;
    std::array<int, 3> size;
    double spacing_mm;
  };
  SONDE_REQUIRE_DATA(folder, "ct-abdomen-totalseg");
  for (const Case& c :
       {Case{"cta-aorta-totalseg/ct_cropped.nii.gz", {120, 126, 164}, 1.5},
        Case{"ct-abdomen-totalseg/example_ct.nii.gz", {122, 101, 112}, 3.0},
        Case{"ct-lung-elastix/3DCT_lung.mha", {115, 157, 129}, 1.366},
        Case{"ct-lung-elastix/3DCT_lung_baseline_small.mha", {57, 78, 64}, 2.732}}) {
    CollectingDiagnostics diagnostics;
    const auto v = read_ct(folder / ".." / c.path, diagnostics);
    ASSERT_TRUE(test::has_value(v));
    EXPECT_EQ(v->grid().size, c.size) << c.path;
    EXPECT_NEAR(v->grid().spacing_mm.x(), c.spacing_mm, 1e-4) << c.path;
    EXPECT_GT(fraction(*v, -150, 150), 0.1) << c.path;  // Soft tissue.
    EXPECT_GT(fraction(*v, 200, 1500), 0.001) << c.path;
  }
}

}  // namespace
}  // namespace nav::io
