// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>

#include "io/ct.hpp"
#include "tests/io/dicom_file.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::ct_slice;
using test::DicomFile;
using test::rejects;
using test::says;
using Code = ErrorCode;

constexpr double kTextMm = 1e-9;  // Positions are written as decimal text.

/// Pixel values that differ in every direction, so that a flip or a transpose changes the image.
int stored(int i, int j, int k) { return 1000 + 100 * k + 10 * j + i; }

class CtDicomTest : public ::testing::Test {
 protected:
  void put(const std::string& name, const DicomFile& file) {
    test::put(folder_ / name, file.bytes());
  }
  /// Writes n slices 2 mm apart. Slice k = 0 is the lowest.
  void put_stack(int n, const std::function<void(int, DicomFile&)>& change = {}) {
    for (int k = 0; k < n; ++k) {
      auto slice = ct_slice("10\\20\\" + std::to_string(30 + 2 * k),
                            [k](int i, int j) { return stored(i, j, k); });
      if (change) change(k, slice);
      // The order of the names is opposite to the order of the positions.
      put("s" + std::to_string(9 - k) + ".dcm", slice);
    }
  }
  /// The pixels of most tests are no Hounsfield units.
  static CtOptions of_any_unit() {
    CtOptions options;
    options.expect_hounsfield_units = false;
    return options;
  }
  Result<Volume> read(const CtOptions& options = of_any_unit()) {
    return read_ct(folder_.path(), diagnostics_, options);
  }
  test::TemporaryFolder folder_;
  CollectingDiagnostics diagnostics_;
};

void expect_stack(const Volume& volume, int n) {
  const VoxelGrid& g = volume.grid();
  ASSERT_EQ(g.size, (std::array<int, 3>{5, 4, n}));
  EXPECT_LT((g.spacing_mm - Eigen::Vector3d(0.5, 0.75, 2)).norm(), kTextMm);
  EXPECT_LT((g.origin_mm - Eigen::Vector3d(10, 20, 30)).norm(), kTextMm);
  EXPECT_LT((g.directions - Eigen::Matrix3d::Identity()).norm(), kTextMm);
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 5; ++i) ASSERT_EQ(volume.at(i, j, k), stored(i, j, k) - 1000);
    }
  }
}

TEST_F(CtDicomTest, SortsSlicesByPositionNotByName) {
  put_stack(4);
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 4);
  EXPECT_TRUE(diagnostics_.entries().empty()) << diagnostics_.entries()[0].message;
}

TEST_F(CtDicomTest, PositionsObliqueSlices) {
  // Columns grow towards -x and rows towards +z. The normal is (-1,0,0) × (0,0,1) = +y.
  for (int k = 0; k < 3; ++k) {
    put("o" + std::to_string(k),
        ct_slice(
            "7\\" + std::to_string(5 + 3 * k) + "\\-4",
            [k](int i, int j) { return stored(i, j, k); }, "-1\\0\\0\\0\\0\\1"));
  }
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  const Eigen::Vector3d p = volume->grid().at({4, 3, 2}).mm;
  EXPECT_LT((p - Eigen::Vector3d(7 - 4 * 0.5, 5 + 2 * 3, -4 + 3 * 0.75)).norm(), kTextMm);
  EXPECT_EQ(volume->at(4, 3, 2), stored(4, 3, 2) - 1000);
  EXPECT_NEAR(volume->grid().directions.determinant(), 1, kTextMm);
}

TEST_F(CtDicomTest, AppliesTheRescaleOfEachSlice) {
  put_stack(3, [](int k, DicomFile& d) {
    d.text(0x00281053, "DS", k == 1 ? "10" : "0.5").text(0x00281052, "DS", "-10240");
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(3, 2, 1), 10 * stored(3, 2, 1) - 10240);
  EXPECT_EQ(volume->at(3, 2, 0), -1024);  // -9728.5 HU is no tissue.
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"values below -1024 HU: 40 voxels, down to -97", "used: -1024 HU"}));
}

TEST_F(CtDicomTest, ReadsPaddingAndUnsignedPixels) {
  put_stack(2, [](int k, DicomFile& d) {
    std::vector<std::uint16_t> pixels(20, 60000);
    pixels[0] = 50;
    pixels[1] = 63536;  // -2000 as an unsigned number: padding.
    pixels[2] = static_cast<std::uint16_t>(500 + k);
    d.us(0x00280103, 0).us(0x00280120, 63536).raw(0x7fe00010, "OW", test::bytes_of(pixels));
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(0, 0, 0), -950);
  EXPECT_EQ(volume->at(1, 0, 0), -1024);
  EXPECT_EQ(volume->at(2, 0, 1), -499);
  EXPECT_EQ(volume->at(3, 0, 0), 32767);
  EXPECT_TRUE(says(diagnostics_, Severity::kInfo, {"2 voxels", "padding"}));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"34 voxels", "above 32767"}));
}

TEST_F(CtDicomTest, ReadsSignedPaddingWrittenAsUnsigned) {
  put_stack(2, [](int, DicomFile& d) {
    std::vector<std::int16_t> pixels(20, 1500);
    pixels[7] = -2000;
    d.us(0x00280120, 63536).raw(0x7fe00010, "OW", test::bytes_of(pixels));
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(2, 1, 0), -1024);
  EXPECT_EQ(volume->at(0, 0, 0), 500);
  EXPECT_TRUE(says(diagnostics_, Severity::kInfo, {"2 voxels", "padding"}));
}

TEST_F(CtDicomTest, ReadsUnsignedPaddingWrittenAsSigned) {
  put_stack(2, [](int, DicomFile& d) {
    std::vector<std::uint16_t> pixels(20, 1500);
    pixels[7] = 63536;  // -2000 as an unsigned number.
    const auto as_signed = test::bytes_of(std::vector<std::int16_t>{-2000});
    d.us(0x00280103, 0).raw(0x00280120, "SS", as_signed);
    d.raw(0x7fe00010, "OW", test::bytes_of(pixels));
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(2, 1, 0), -1024);
  EXPECT_EQ(volume->at(0, 0, 0), 500);
  EXPECT_TRUE(says(diagnostics_, Severity::kInfo, {"2 voxels", "padding"}));
}

TEST_F(CtDicomTest, DecodesRunLengthCode) {
  put_stack(3, [](int k, DicomFile& d) {
    std::vector<std::int16_t> pixels;
    for (int i = 0; i < 20; ++i)
      pixels.push_back(static_cast<std::int16_t>(stored(i % 5, i / 5, k)));
    d.encapsulated({test::run_length_code(pixels)}, "1.2.840.10008.1.2.5");
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
}

TEST_F(CtDicomTest, SortsFramesOfEnhancedMultiFrameByPosition) {
  // The frames are stored from top to bottom.
  std::vector<DicomFile> per_frame;
  std::vector<std::int16_t> pixels;
  for (const int k : {2, 1, 0}) {
    DicomFile position;
    position.text(0x00200032, "DS", "10\\20\\" + std::to_string(30 + 2 * k));
    DicomFile item;
    item.sequence(0x00209113, {position});
    per_frame.push_back(item);
    for (int i = 0; i < 20; ++i)
      pixels.push_back(static_cast<std::int16_t>(stored(i % 5, i / 5, k)));
  }
  DicomFile orientation;
  orientation.text(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  DicomFile measures;
  measures.text(0x00280030, "DS", "0.75\\0.5").text(0x00180050, "DS", "2");
  DicomFile rescale;
  rescale.text(0x00281052, "DS", "-1000").text(0x00281053, "DS", "1");
  DicomFile shared;
  shared.sequence(0x00209116, {orientation}).sequence(0x00289110, {measures});
  shared.sequence(0x00289145, {rescale});
  auto file = ct_slice("0\\0\\0", [](int, int) { return 0; });
  for (const std::uint32_t tag :
       {0x00200032U, 0x00200037U, 0x00280030U, 0x00281052U, 0x00281053U}) {
    file.erase(tag);
  }
  file.text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2.1").text(0x00280008, "IS", "3");
  file.sequence(0x52009229, {shared}).sequence(0x52009230, per_frame);
  file.raw(0x7fe00010, "OW", test::bytes_of(pixels));
  put("multi.dcm", file);
  const auto volume = read_ct(folder_ / "multi.dcm", diagnostics_);
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
}

// Linear interpolation reproduces a field that is linear in the patient exactly. On any grid, each
// voxel must therefore hold the value of the field at its own position.
double field(const Eigen::Vector3d& p) { return 6 * p.x() - 4 * p.y() + 5 * p.z() + 300; }
// Rounding: 0.5 HU in the slices and 0.5 HU in the result.
constexpr double kFieldHu = 1.0;

std::string text(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out.precision(10);
  out << v.x() << "\\" << v.y() << "\\" << v.z();
  return out.str();
}

TEST_F(CtDicomTest, ResamplesATiltedUnevenStack) {
  constexpr double kTilt = 18.5 * M_PI / 180;
  constexpr int kColumns = 24;
  constexpr int kRows = 30;
  const Eigen::Vector3d x(1, 0, 0);
  const Eigen::Vector3d y(0, std::cos(kTilt), -std::sin(kTilt));
  const Eigen::Vector3d normal = x.cross(y);
  double table = 0;
  double last = 0;
  for (int k = 0; k < 9; ++k) {
    const Eigen::Vector3d position(-8, -12, -20 + table);  // The table moves along z.
    last = table;
    put("t" + std::to_string(k), ct_slice(
                                     text(position),
                                     [&](int i, int j) {
                                       const Eigen::Vector3d p =
                                           position + 0.5 * i * x + 0.75 * j * y;
                                       return static_cast<int>(std::lround(field(p))) + 1000;
                                     },
                                     text(x) + "\\" + text(y), kColumns, kRows)
                                     .text(0x00181120, "DS", "18.5"));
    table += k == 4 ? 4.2 : 1.5 + 0.1 * k;
  }
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"18.5 degrees", "resampled", "t5", "3.98"}));
  const VoxelGrid& g = volume->grid();
  EXPECT_LT((g.directions.col(2) - normal).norm(), 1e-6);
  EXPECT_NEAR(g.spacing_mm.z() * (g.size[2] - 1), last * std::cos(kTilt), 1e-6);
  std::size_t inside = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (volume->at(i, j, k) == kAirHu) continue;
        ++inside;
        const Eigen::Vector3d p = g.at(Eigen::Vector3d(i, j, k)).mm;
        ASSERT_NEAR(volume->at(i, j, k), field(p), kFieldHu) << p.transpose();
      }
    }
  }
  // The scanned volume is a sheared box of columns × rows × length.
  const double slab = kColumns * kRows * static_cast<double>(g.size[2]);
  EXPECT_GT(static_cast<double>(inside), 0.9 * slab);
}

TEST_F(CtDicomTest, InterpolatesAMissingSliceAndNamesTheGap) {
  put_stack(6);
  std::filesystem::remove(folder_ / "s6.dcm");  // k = 3
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"4 mm before s5.dcm", "from 2 mm"}));
  expect_stack(*volume, 6);  // Values are linear in k, so interpolation restores the missing slice
                             // exactly.
}

TEST_F(CtDicomTest, RejectsGapsTooWideToInterpolate) {
  put_stack(3);
  put("far.dcm", ct_slice("10\\20\\50.5", [](int, int) { return 0; }));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"far.dcm", "16.5 mm", "at most 10 mm"}));
}

TEST_F(CtDicomTest, RejectsInconsistentStacks) {
  const auto zero = [](int, int) { return 0; };
  put_stack(3);
  put("x.dcm", ct_slice("10\\20\\32.001", zero));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"x.dcm", "s8.dcm", "one slice per position"}));
  put("x.dcm", ct_slice("10\\20\\38", zero, "1\\0\\0\\0\\0\\1"));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData,
                      {"one orientation", "1 0 0 0 0 1 in x.dcm", "1 0 0 0 1 0 in s7.dcm"}));
  put("x.dcm", ct_slice("10\\20\\38", zero, "1\\0\\0\\0\\1\\0", 6, 4));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"x.dcm", "6 x 4", "one size"}));
  put("x.dcm", ct_slice("10\\20\\38", zero).text(0x00280030, "DS", "0.75\\0.6"));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"x.dcm", "0.6 mm", "one pixel spacing"}));
  put("x.dcm", ct_slice("10\\20\\38", zero, "1\\0\\0\\1\\0\\0"));
  EXPECT_FALSE(read());
}

TEST_F(CtDicomTest, NamesTheFileWithAMissingOrInvalidAttribute) {
  const auto broken = [&](const std::function<void(DicomFile&)>& change) {
    put_stack(3, [&](int k, DicomFile& d) {
      if (k == 1) change(d);
    });
    return read();
  };
  EXPECT_TRUE(rejects(broken([](auto& d) { d.erase(0x7fe00010); }), Code::kMalformedData,
                      {"s8.dcm", "pixel data"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.erase(0x00200032); }), Code::kMalformedData,
                      {"s8.dcm", "ImagePositionPatient"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.text(0x00200032, "DS", "10\\20\\nan"); }),
                      Code::kMalformedData, {"s8.dcm", "ImagePositionPatient"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.erase(0x00200037); }), Code::kMalformedData,
                      {"s8.dcm", "ImageOrientationPatient"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.text(0x00280030, "DS", "0\\0.5"); }),
                      Code::kMalformedData, {"s8.dcm", "PixelSpacing"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.text(0x00280030, "DS", "-1\\0.5"); }),
                      Code::kMalformedData, {"s8.dcm", "PixelSpacing"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.text(0x00281053, "DS", "0"); }), Code::kMalformedData,
                      {"s8.dcm", "RescaleSlope"}));
  EXPECT_TRUE(rejects(broken([](auto& d) { d.us(0x00280002, 3); }), Code::kMalformedData,
                      {"s8.dcm", "SamplesPerPixel", "3"}));
}

TEST_F(CtDicomTest, RejectsTruncatedFilesWithoutPrinting) {
  put_stack(3);
  const std::string whole = test::get(folder_ / "s8.dcm");
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  for (const std::size_t size : {whole.size() - 10, whole.size() - 40, whole.size() / 2}) {
    test::put(folder_ / "s8.dcm", whole.substr(0, size));
    const auto volume = read();
    EXPECT_FALSE(volume.has_value()) << size;
    if (!volume) {
      EXPECT_NE(volume.error().message.find("s8.dcm"), std::string::npos) << volume.error().message;
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

TEST_F(CtDicomTest, WarnsAboutOtherModalitiesAndMissingRescale) {
  put_stack(2, [](int, DicomFile& d) { d.text(0x00080060, "CS", "MR"); });
  ASSERT_TRUE(test::has_value(read()));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"Modality: 'MR' (expected CT)"}));
  put_stack(2, [](int, DicomFile& d) { d.erase(0x00281052).erase(0x00281053); });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(1, 0, 0), stored(1, 0, 0));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"RescaleSlope", "2 slices without"}));
}

TEST_F(CtDicomTest, ChoosesTheLargestCtSeriesOrTheRequestedOne) {
  put_stack(3);
  for (int k = 0; k < 5; ++k) {
    const std::string n = std::to_string(k);
    const auto low = [](int, int) { return 1; };
    put("mr" + n,
        ct_slice("0\\0\\" + n, low).text(0x0020000e, "UI", "9.9.1").text(0x00080060, "CS", "MR"));
    if (k < 2) put("small" + n, ct_slice("0\\0\\" + n, low).text(0x0020000e, "UI", "9.9.2"));
  }
  auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"series: ", "used: 1.2.3.1", "9.9.1 (MR, 5 slices", "9.9.2 (CT, 2"}));
  CtOptions options;
  options.series_uid = "9.9.2";
  volume = read(options);
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->grid().size[2], 2);
  options.series_uid = "5.5";
  EXPECT_TRUE(rejects(read(options), Code::kNotFound, {"5.5", "9.9.1", "9.9.2", "1.2.3.1"}));
}

TEST_F(CtDicomTest, SkipsLocalizerImages) {
  put_stack(3);
  put("scout", ct_slice(
                   "0\\0\\0", [](int, int) { return 0; }, "1\\0\\0\\0\\0\\-1")
                   .text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER"));
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"1 overview"}));
}

TEST_F(CtDicomTest, SkipsOtherFilesButRejectsTruncatedDicomFiles) {
  put_stack(3);
  test::put(folder_ / "note.txt", "nothing to see");
  test::put(folder_ / "alike.bin", std::string("\x08\0\x05\0garbage that is no element", 30));
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
  test::put(folder_ / "half.dcm", test::get(folder_ / "s9.dcm").substr(0, 300));
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"half.dcm", "at byte"}));
}

TEST_F(CtDicomTest, NamesSlicesThatCannotBeRead) {
  put_stack(3);
  std::filesystem::rename(folder_ / "s7.dcm", folder_ / "elsewhere");
  std::filesystem::create_symlink("elsewhere", folder_ / "s7.dcm");
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"one slice per position"}));
  std::filesystem::remove(folder_ / "elsewhere");
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 2);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"s7.dcm", "link points to no file"}));
  // Root may read any file, so this part tests something only for other users.
  if (::geteuid() != 0) {
    std::filesystem::remove(folder_ / "s7.dcm");
    put_stack(3);
    ASSERT_EQ(::chmod((folder_ / "s7.dcm").c_str(), 0), 0);
    EXPECT_TRUE(rejects(read(), Code::kIo, {"s7.dcm", "Permission denied"}));
  }
}

TEST_F(CtDicomTest, ReadsOldFilesWithoutPreamble) {
  put_stack(3);
  for (const char* name : {"s7.dcm", "s8.dcm", "s9.dcm"}) {
    test::put(folder_ / name, test::get(folder_ / name).substr(132));
  }
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
}

TEST_F(CtDicomTest, RecognisesDicomByItsContent) {
  put_stack(2);
  const std::string whole = test::get(folder_ / "s9.dcm");
  const auto is = [&](const std::string& content) {
    test::put(folder_ / "x", content);
    return is_dicom(folder_ / "x");
  };
  EXPECT_TRUE(is(whole));
  EXPECT_TRUE(is(whole.substr(132)));
  EXPECT_TRUE(is(whole.substr(0, 300)));  // The file is cut short but is surely DICOM, so the
                                          // reader rejects the folder.
  EXPECT_FALSE(is(std::string("\x08\0\x05\0garbage that is no element", 30)));
  EXPECT_FALSE(is("nothing to see"));
  EXPECT_FALSE(is(""));
  EXPECT_FALSE(is_dicom(folder_.path()));
  EXPECT_FALSE(is_dicom(folder_ / "missing"));
}

TEST_F(CtDicomTest, ReadsFilesWithoutValueRepresentations) {
  put_stack(3, [](int, DicomFile& d) { d.implicit(); });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  expect_stack(*volume, 3);
}

TEST_F(CtDicomTest, ReadsNegativeTwelveBitPixels) {
  // The pixel is -5 in 12 bits. The standard does not define the other four bits.
  put_stack(2, [](int, DicomFile& d) {
    std::vector<std::uint16_t> pixels(20, 0x0ffb);
    pixels[0] = 0xfffb;
    pixels[1] = 5;
    d.us(0x00280101, 12).us(0x00280102, 11).raw(0x7fe00010, "OW", test::bytes_of(pixels));
    d.text(0x00281052, "DS", "0");
  });
  const auto volume = read();
  ASSERT_TRUE(test::has_value(volume));
  EXPECT_EQ(volume->at(0, 0, 0), -5);
  EXPECT_EQ(volume->at(1, 0, 0), 5);
  EXPECT_EQ(volume->at(2, 0, 0), -5);
}

TEST_F(CtDicomTest, RejectsIncompleteRescaleAttributes) {
  const auto one = [&](const std::function<void(DicomFile&)>& change) {
    put_stack(3, [&](int k, DicomFile& d) {
      if (k == 1) change(d);
    });
    return read();
  };
  for (const auto& change : std::vector<std::function<void(DicomFile&)>>{
           [](auto& d) { d.erase(0x00281052); }, [](auto& d) { d.erase(0x00281053); },
           [](auto& d) { d.text(0x00281052, "DS", "-1000,0"); },
           [](auto& d) { d.text(0x00281053, "DS", "1\\1"); }}) {
    EXPECT_TRUE(rejects(one(change), Code::kMalformedData,
                        {"s8.dcm", "RescaleSlope and RescaleIntercept, one number each"}));
  }
  // The other slices of the stack have a rescale and are in HU.
  EXPECT_TRUE(rejects(one([](auto& d) { d.erase(0x00281052).erase(0x00281053); }),
                      Code::kMalformedData, {"all of 3 slices or in none", "1 without"}));
}

TEST_F(CtDicomTest, RejectsSlicesThatAreShiftedSideways) {
  const auto zero = [](int, int) { return 0; };
  put_stack(3);
  for (const char* position : {"1e12\\20\\36", "10\\-1e300\\36", "10\\50\\36"}) {
    put("x.dcm", ct_slice(position, zero));
    EXPECT_TRUE(rejects(read(), Code::kMalformedData,
                        {"above each other", "x.dcm shifted by", "6 mm from s9.dcm"}));
  }
}

TEST_F(CtDicomTest, RejectsDeflatedFiles) {
  put_stack(2, [](int, DicomFile& d) { d.encapsulated({"xx"}, "1.2.840.10008.1.2.1.99"); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {".dcm", "not deflated"}));
}

/// The library reads a length of 0xffffffff there as one, and asks for as many bytes.
TEST_F(CtDicomTest, RejectsFileMetaInformationWithoutALength) {
  std::string bytes(128, '\0');
  bytes += "DICM";
  bytes += std::string("\2\0\0\0UL\4\0\x98\0\0\0", 12);
  bytes += std::string("\2\0\1\0OB\0\1\xff\xff\xff\xff", 12) + std::string(24, '\xff');
  test::put(folder_ / "a.dcm", bytes);
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"a.dcm", "length", "group 2"}));
}

TEST_F(CtDicomTest, RejectsFoldersWithoutAStack) {
  EXPECT_TRUE(rejects(read(), Code::kNotFound, {"DICOM", "0 files"}));
  test::put(folder_ / "note.txt", "hello, this is no image at all");
  EXPECT_TRUE(rejects(read(), Code::kNotFound, {"1 files"}));
  put_stack(1);
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"at least 2 slices", "found 1"}));
  EXPECT_TRUE(rejects(read_ct(folder_ / "s9.dcm", diagnostics_), Code::kMalformedData,
                      {"s9.dcm", "at least 2 slices"}));
  EXPECT_TRUE(rejects(read_ct(folder_ / "gone", diagnostics_), Code::kNotFound, {"gone"}));
  EXPECT_TRUE(rejects(read_ct(folder_ / "note.txt", diagnostics_), Code::kUnsupportedData,
                      {"note.txt", "another kind"}));
}

TEST_F(CtDicomTest, RejectsSamplesThatAreNoValues) {
  put_stack(3, [](int, DicomFile& d) { d.text(0x00280004, "CS", "PALETTE COLOR"); });
  EXPECT_TRUE(
      rejects(read(), Code::kMalformedData, {"PhotometricInterpretation", "PALETTE COLOR"}));
  put_stack(3, [](int, DicomFile& d) { d.text(0x00280004, "CS", "MONOCHROME1"); });
  EXPECT_TRUE(test::has_value(read()));
  put_stack(3, [](int, DicomFile& d) { d.us(0x00280101, 12); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"HighBit", "11", "15"}));
}

TEST_F(CtDicomTest, RejectsFunctionalGroupsInAClassicImage) {
  DicomFile measures;
  measures.sequence(0x00289110, {DicomFile().text(0x00280030, "DS", "9\\9")});
  put_stack(3, [&](int, DicomFile& d) { d.sequence(0x52009229, {measures}); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"functional groups"}));
}

TEST_F(CtDicomTest, PrefersTheSeriesInHu) {
  put_stack(3, [](int, DicomFile& d) { d.text(0x00281054, "LO", "MGML"); });
  ASSERT_TRUE(test::has_value(read()));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"RescaleType", "HU", "MGML"}));
  // Fewer slices in HU beside them.
  for (int k = 0; k < 2; ++k) {
    auto slice = ct_slice("10\\20\\" + std::to_string(30 + 2 * k),
                          [k](int i, int j) { return stored(i, j, k); });
    put("z" + std::to_string(k) + ".dcm", slice.text(0x0020000e, "UI", "1.2.3.9"));
  }
  const auto v = read();
  ASSERT_TRUE(test::has_value(v));
  expect_stack(*v, 2);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"used: 1.2.3.9", "3 slices of MGML"}));
}

TEST_F(CtDicomTest, RejectsPhasesThatAlternateByAnyAttribute) {
  struct Phase {
    std::uint32_t tag;
    const char* type;
    const char* first;
    const char* second;
    const char* name;
  };
  for (const Phase& phase :
       {Phase{0x00200100, "IS", "1", "2", "TemporalPositionIdentifier 1, 2"},
        Phase{0x00180060, "DS", "140", "80", "KVP 140, 80"},
        Phase{0x00181210, "SH", "B30f", "B60f", "ConvolutionKernel B30f, B60f"},
        Phase{0x00080032, "TM", "101500", "101530", "AcquisitionTime 101500, 101530"}}) {
    put_stack(6, [&](int k, DicomFile& d) {
      d.text(phase.tag, phase.type, k % 2 == 0 ? phase.first : phase.second);
    });
    EXPECT_TRUE(rejects(read(), Code::kMalformedData, {phase.name})) << phase.name;
  }
  // Each slice at a time of its own, and detectors of two rows.
  put_stack(6, [](int k, DicomFile& d) { d.text(0x00080032, "TM", std::to_string(101500 + k)); });
  EXPECT_TRUE(test::has_value(read()));
  put_stack(6, [](int k, DicomFile& d) {
    d.text(0x00080032, "TM", std::to_string(101500 + (k == 3 ? 0 : k / 2)));
  });
  EXPECT_TRUE(test::has_value(read()));
}

TEST_F(CtDicomTest, RejectsAcquisitionsThatAlternate) {
  put_stack(6, [](int k, DicomFile& d) { d.text(0x00200012, "IS", k % 2 == 0 ? "1" : "2"); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"AcquisitionNumber 1, 2"}));
  put_stack(6, [](int k, DicomFile& d) { d.text(0x00200012, "IS", k < 3 ? "1" : "2"); });
  const auto v = read();
  ASSERT_TRUE(test::has_value(v)) << "one after the other";
  expect_stack(*v, 6);
}

TEST_F(CtDicomTest, RejectsTwoFramesOfReference) {
  put_stack(
      4, [](int k, DicomFile& d) { d.text(0x00200052, "UI", k == 1 ? "1.2.3.4.6" : "1.2.3.4.5"); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"FrameOfReferenceUID", "2"}));
}

TEST_F(CtDicomTest, RejectsASeriesThatMixesPatientsStudiesModalitiesOrPositions) {
  const auto mixed = [&](std::uint32_t tag, const char* vr, const char* first, const char* second) {
    put_stack(4, [&](int k, DicomFile& d) { d.text(tag, vr, k < 2 ? first : second); });
    return read();
  };
  const auto patients = mixed(0x00100020, "LO", "Ada", "Grace");
  EXPECT_TRUE(rejects(patients, Code::kMalformedData, {"expected one PatientID", "found 2"}));
  EXPECT_EQ(patients.error().message.find("Ada"), std::string::npos) << "a patient is named";
  EXPECT_TRUE(rejects(mixed(0x0020000d, "UI", "1.5", "1.6"), Code::kMalformedData,
                      {"expected one StudyInstanceUID", "found 2"}));
  EXPECT_TRUE(rejects(mixed(0x00080060, "CS", "CT", "MR"), Code::kMalformedData,
                      {"expected one Modality", "found 2 (CT, MR)"}));
  EXPECT_TRUE(rejects(mixed(0x00185100, "CS", "HFP", "HFS"), Code::kMalformedData,
                      {"expected one PatientPosition", "found 2 (HFP, HFS)"}));
  EXPECT_TRUE(test::has_value(mixed(0x00185100, "CS", "HFP", "HFP")));
}

TEST_F(CtDicomTest, NamesAFolderOfSeveralPatients) {
  put_stack(3, [](int, DicomFile& d) { d.text(0x00100020, "LO", "Ada"); });
  for (int k = 0; k < 2; ++k) {
    auto slice = ct_slice("10\\20\\" + std::to_string(30 + 2 * k),
                          [k](int i, int j) { return stored(i, j, k); });
    put("other" + std::to_string(k),
        slice.text(0x0020000e, "UI", "1.2.3.9").text(0x00100020, "LO", "Grace"));
  }
  const auto v = read();
  ASSERT_TRUE(test::has_value(v));
  expect_stack(*v, 3);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"PatientID: 2 different ones among 2 series", "which 1 of the series have"}));
  for (const auto& entry : diagnostics_.entries()) {
    EXPECT_EQ(entry.message.find("Grace"), std::string::npos) << "a patient is named";
  }
}

TEST_F(CtDicomTest, NamesGapsAndNumbersThatContradictThePositions) {
  const auto numbered = [&](int step, const char* gap) {
    put_stack(4, [&](int k, DicomFile& d) {
      d.text(0x00180088, "DS", gap).text(0x00200013, "IS", std::to_string(1 + step * k));
    });
    ASSERT_TRUE(test::has_value(read()));
  };
  numbered(1, "-2.0");
  EXPECT_TRUE(diagnostics_.entries().empty()) << diagnostics_.entries()[0].message;
  numbered(2, "1.0");
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"SpacingBetweenSlices: 1 mm stated against 2 mm by the positions"}));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"InstanceNumber: 1 to 7 against 4 images", "used: the images"}));
}

TEST_F(CtDicomTest, NamesPixelDataThatAreLongerThanStated) {
  put_stack(3, [](int k, DicomFile& d) {
    std::vector<std::int16_t> pixels(k == 1 ? 22 : 20, 0);
    d.raw(0x7fe00010, "OW", test::bytes_of(pixels));
  });
  ASSERT_TRUE(test::has_value(read()));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning,
                   {"length of the samples: 1 files", "s8.dcm: 40 bytes stated, 44 found"}));
}

TEST_F(CtDicomTest, RejectsBytesBehindThePixelDataUnlessTheyAreZeros) {
  put_stack(3);
  const std::string slice = test::get(folder_ / "s8.dcm");
  test::put(folder_ / "s8.dcm", slice + std::string(3, '\0'));
  ASSERT_TRUE(test::has_value(read()));
  test::put(folder_ / "s8.dcm", slice + "abc");
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"s8.dcm"}));
}

TEST_F(CtDicomTest, RejectsASeriesOfTwoUnits) {
  put_stack(3, [](int k, DicomFile& d) { d.text(0x00281054, "LO", k == 1 ? "MGML" : "HU"); });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"RescaleType", "MGML", "HU"}));
}

TEST_F(CtDicomTest, RejectsMoreSamplesThanRunLengthsCanHold) {
  put_stack(3, [](int k, DicomFile& d) {
    std::vector<std::int16_t> pixels(20, 0);
    d.encapsulated({test::run_length_code(pixels)}, "1.2.840.10008.1.2.5");
    if (k == 1) d.us(0x00280010, 30000).us(0x00280011, 30000);
  });
  EXPECT_TRUE(rejects(read(), Code::kMalformedData, {"s8.dcm", "cut short", "compressed"}));
}

/// Big-endian bytes of an integer.
std::string be(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>((value >> (8 * i)) & 255);
  return out;
}

std::string jpeg_2000(int columns, int rows) {
  return be(0xff4fff51, 4) + be(41, 2) + be(0, 2) + be(static_cast<unsigned>(columns), 4) +
         be(static_cast<unsigned>(rows), 4) + std::string(30, '\0');
}

std::string jpeg_ls(int columns, int rows) {
  return be(0xffd8, 2) + be(0xffe0, 2) + be(4, 2) + "ab" + be(0xfff7, 2) + be(11, 2) + be(16, 1) +
         be(static_cast<unsigned>(rows), 2) + be(static_cast<unsigned>(columns), 2) +
         std::string(30, '\0');
}

TEST_F(CtDicomTest, ComparesTheSizeOfCodestreamsBeforeTheyAreDecoded) {
  const auto read_coded = [&](const std::string& stream, const char* syntax, int rows,
                              int columns) {
    put_stack(3, [&](int, DicomFile& d) {
      d.encapsulated({stream}, syntax);
      d.us(0x00280010, static_cast<unsigned>(rows)).us(0x00280011, static_cast<unsigned>(columns));
    });
    return read();
  };
  const char* const k2000 = "1.2.840.10008.1.2.4.90";
  const char* const kLs = "1.2.840.10008.1.2.4.80";
  for (const auto& [syntax, other] : {std::pair(k2000, jpeg_2000(7, 4)), {kLs, jpeg_ls(7, 4)}}) {
    EXPECT_TRUE(rejects(read_coded(other, syntax, 4, 5), Code::kMalformedData,
                        {"expected 5 x 4 pixels (Columns, Rows), found 7 x 4"}));
    EXPECT_TRUE(rejects(read_coded("no codestream at all, only text", syntax, 4, 5),
                        Code::kMalformedData, {"expected the size of the image"}));
  }
  // The decoder would fill what is missing with zeros.
  for (const auto& [syntax, same] : {std::pair(k2000, jpeg_2000(5, 4)), {kLs, jpeg_ls(5, 4)}}) {
    EXPECT_TRUE(rejects(read_coded(same, syntax, 4, 5), Code::kMalformedData,
                        {"cut short", "the marker of their end"}));
  }
  // 1.8 GB out of a hundred bytes.
  EXPECT_TRUE(rejects(read_coded(jpeg_2000(30000, 30000) + be(0xffd9, 2), k2000, 30000, 30000),
                      Code::kMalformedData, {"cut short"}));
  EXPECT_TRUE(rejects(read_coded(jpeg_ls(300, 60000) + be(0xffd9, 2), kLs, 60000, 300),
                      Code::kMalformedData, {"cut short"}));
}

TEST_F(CtDicomTest, NamesFilesThatAreNotDicom) {
  put_stack(3);
  test::put(folder_ / "readme.txt", "of the hospital");
  ASSERT_TRUE(test::has_value(read()));
  EXPECT_TRUE(diagnostics_.entries().empty());
  test::put(folder_ / "empty.dcm", "");
  test::put(folder_ / "IM0007", "cut");
  ASSERT_TRUE(test::has_value(read()));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"2 files", "IM0007", "empty.dcm"}));
}

}  // namespace
}  // namespace nav::io
