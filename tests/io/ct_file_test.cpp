// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <span>

#include "io/ct.hpp"
#include "io/detail/hu_builder.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::rejects;
using test::says;
using Code = ErrorCode;

constexpr double kMm = 1e-9;         // Rounding of decimal text.
constexpr double kFloat32Mm = 1e-5;  // NIfTI-1 stores 32-bit floating-point numbers.

/// Returns 3 x 2 x 4 voxels that all differ: 100 i + 10 j + k.
template <class T>
std::vector<T> voxels() {
  std::vector<T> out;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 3; ++i) out.push_back(static_cast<T>(100 * i + 10 * j + k));
    }
  }
  return out;
}

void expect_voxels(const Volume& volume) {
  ASSERT_EQ(volume.grid().size, (std::array<int, 3>{3, 2, 4}));
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 3; ++i) ASSERT_EQ(volume.at(i, j, k), 100 * i + 10 * j + k);
    }
  }
}

/// The voxels of most tests are no Hounsfield units.
CtOptions of_any_unit() {
  CtOptions options;
  options.expect_hounsfield_units = false;
  return options;
}

/// The finding with a key; empty if there is none.
Finding finding_of(const CollectingDiagnostics& diagnostics, const std::string& key) {
  for (const auto& entry : diagnostics.entries()) {
    if (entry.finding && entry.finding->key == key) return *entry.finding;
  }
  return {};
}

class CtFileTest : public ::testing::Test {
 protected:
  Result<Volume> read(const std::string& name, const std::string& bytes,
                      const CtOptions& options = of_any_unit()) {
    test::put(folder_ / name, bytes);
    return read_ct(folder_ / name, diagnostics_, options);
  }
  test::TemporaryFolder folder_;
  CollectingDiagnostics diagnostics_;
};

// The matrix permutes the axes cyclically, so that its transpose differs from it: i runs along +y,
// j along +z, k along +x (LPS).
const std::string kTurn = "TransformMatrix = 0 1 0 0 0 1 1 0 0\n";
const Eigen::Vector3d kLastVoxel(5 + 3 * 4.0, 6 + 2 * 2.0, 7 + 1 * 3.0);

std::string meta(const std::string& geometry = kTurn, const std::string& type = "MET_SHORT",
                 const std::string& spacing = "2 3 4", const std::string& extra = "") {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\n" + geometry +
         "Offset = 5 6 7\nElementSpacing = " + spacing + "\nDimSize = 3 2 4\n" + extra +
         "ElementType = " + type + "\nElementDataFile = LOCAL\n";
}

TEST_F(CtFileTest, PositionsVoxelsOfAMetaImageWithPermutedAxes) {
  const auto v = read("a.mha", meta() + test::bytes_of(voxels<std::int16_t>()));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kMm);
  EXPECT_TRUE(diagnostics_.entries().empty());
}

TEST_F(CtFileTest, ReadsEverySampleTypeCompressedAndByteSwapped) {
  const auto check = [&](const std::string& type, const std::string& bytes,
                         const std::string& extra) {
    const auto v = read("a.mha", meta(kTurn, type, "2 3 4", extra) + bytes);
    ASSERT_TRUE(test::has_value(v)) << type;
    expect_voxels(*v);
  };
  check("MET_USHORT", test::bytes_of(voxels<std::uint16_t>()), "");
  check("MET_INT", test::bytes_of(voxels<std::int32_t>()), "");
  check("MET_UINT", test::bytes_of(voxels<std::uint32_t>()), "");
  check("MET_FLOAT", test::bytes_of(voxels<float>()), "");
  check("MET_DOUBLE", test::bytes_of(voxels<double>()), "");
  check("MET_SHORT", test::swapped_bytes_of(voxels<std::int16_t>()),
        "BinaryDataByteOrderMSB = True\n");
  check("MET_FLOAT", test::swapped_bytes_of(voxels<float>()), "ElementByteOrderMSB = True\n");
  check("MET_SHORT", test::deflated(test::bytes_of(voxels<std::int16_t>())),
        "CompressedData = True\n");
}

TEST_F(CtFileTest, RoundsAndClampsAndReportsTheCounts) {
  auto values = voxels<float>();
  values[0] = 1.6F;
  values[1] = -2.6F;
  values[2] = 40000.0F;
  values[3] = -3024.0F;
  values[4] = -1024.4F;
  const auto v = read("a.mha", meta(kTurn, "MET_FLOAT") + test::bytes_of(values));
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(v->at(0, 0, 0), 2);
  EXPECT_EQ(v->at(1, 0, 0), -3);
  EXPECT_EQ(v->at(2, 0, 0), 32767);
  EXPECT_EQ(v->at(0, 1, 0), -1024);
  EXPECT_EQ(v->at(1, 1, 0), -1024);
  EXPECT_TRUE(
      says(diagnostics_, Severity::kWarning, {"a.mha", "1 voxels above 32767 HU set to 32767 HU"}));
  EXPECT_TRUE(says(diagnostics_, Severity::kInfo,
                   {"a.mha", "values below -1024 HU: 1 voxels, down to -3024 HU; used: -1024 HU"}));
}

TEST_F(CtFileTest, ReadsStoredValuesWithoutAUnitAndWithoutTheLimitOfAir) {
  auto values = voxels<float>();
  values[2] = 40000.0F;
  values[3] = -3024.0F;
  values[4] = -40000.0F;
  test::put(folder_ / "b.mha", meta(kTurn, "MET_FLOAT") + test::bytes_of(values));
  const auto v = read_stored_volume(folder_ / "b.mha", diagnostics_);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(v->at(2, 0, 0), 32767);
  EXPECT_EQ(v->at(0, 1, 0), -3024);
  EXPECT_EQ(v->at(1, 1, 0), -32768);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"b.mha", "above 32767 set to 32767"}));
  EXPECT_TRUE(
      says(diagnostics_, Severity::kWarning, {"b.mha", "values below -32768: ", "used: -32768"}));
}

TEST_F(CtFileTest, RejectsNanVoxelsAndReportsTheirCountAndIndex) {
  auto values = voxels<float>();
  values[6 + 3 + 2] = std::numeric_limits<float>::quiet_NaN();  // (2, 1, 1)
  values[20] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(rejects(read("a.mha", meta(kTurn, "MET_FLOAT") + test::bytes_of(values)),
                      Code::kMalformedData, {"a.mha", "found 2", "(2, 1, 1)"}));
}

TEST_F(CtFileTest, RejectsFractionsThatRoundingWouldDestroy) {
  auto values = voxels<float>();
  const auto read_scaled = [&](float slope, float offset) {
    auto scaled = values;
    for (float& v : scaled) v = slope * v + offset;
    return read("a.mha", meta(kTurn, "MET_FLOAT") + test::bytes_of(scaled));
  };
  EXPECT_TRUE(rejects(read_scaled(1.0F / 256, 0), Code::kUnsupportedData,
                      {"a.mha", "0 to 0.83", "multiply them by 10000"}));
  EXPECT_TRUE(rejects(read_scaled(0.25F, -7), Code::kUnsupportedData,
                      {"-7 to 46.25", "multiply them by 100"}));
  // Hounsfield units with fractions are rounded.
  const auto v = read_scaled(1, 12.3F);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(v->at(2, 1, 3), 225) << "213 + 12.3";
  EXPECT_TRUE(test::has_value(read_scaled(0.31F, 0))) << "a span of 66";
  // The reader also accepts whole numbers of any range, and a constant fraction.
  EXPECT_TRUE(test::has_value(read_scaled(0, 1)));
  EXPECT_TRUE(test::has_value(read_scaled(0, 0.25F)));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 2 == 0 ? 1.0F : 0.0F;
  EXPECT_TRUE(test::has_value(read_scaled(1, 0)));
}

TEST_F(CtFileTest, TakesNoLettersWithoutAMatrixButRai) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  auto v = read("a.mha", meta("AnatomicalOrientation = RAI\n") + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(7, 9, 11)).norm(), kMm);
  for (const char* letters : {"RAS", "LPI", "LPS", "rai"}) {
    const std::string file = meta(std::string("AnatomicalOrientation = ") + letters + "\n") + data;
    EXPECT_TRUE(rejects(read("l.mha", file), Code::kUnsupportedData, {"l.mha", letters}));
    CtOptions accept;
    accept.accept_unknown_orientation = true;
    v = read("l.mha", file, accept);
    ASSERT_TRUE(test::has_value(v));
    EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(7, 9, 11)).norm(), kMm);
  }
  v = read("b.mha",
           meta("AnatomicalOrientation = LPI\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n") + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(7, 9, 11)).norm(), kMm);
  ASSERT_TRUE(says(diagnostics_, Severity::kWarning, {"b.mha: orientation: ", "LPI", " against "}));
}

TEST_F(CtFileTest, RejectsTwoByteOrdersThatDiffer) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto orders = [&](const char* element, const char* binary) {
    return read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4",
                              std::string("ElementByteOrderMSB = ") + element +
                                  "\nBinaryDataByteOrderMSB = " + binary + "\n") +
                             data);
  };
  EXPECT_TRUE(test::has_value(orders("False", "False")));
  EXPECT_TRUE(test::has_value(orders("0", "False")));
  EXPECT_TRUE(rejects(orders("True", "False"), Code::kMalformedData,
                      {"ElementByteOrderMSB", "BinaryDataByteOrderMSB", "True", "False"}));
}

TEST_F(CtFileTest, LocalDataMayEndTheFile) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto with = [&](const std::string& size, const std::string& before) {
    return read("a.mha",
                meta(kTurn, "MET_SHORT", "2 3 4", "HeaderSize = " + size + "\n") + before + data);
  };
  auto v = with("-1", std::string(40, 'x'));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  v = with("0", "");
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_TRUE(rejects(with("17", ""), Code::kMalformedData, {"HeaderSize", "17"}));
}

TEST_F(CtFileTest, WarnsOfMoreDataThanStated) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto v = read("a.mha", meta() + data + std::string(132, '\0'));
  ASSERT_TRUE(test::has_value(v));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"a.mha", "48 bytes", "180"}));
}

TEST_F(CtFileTest, WarnsOfMoreDataThanStatedInSeveralFiles) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string header = meta();
  header.replace(header.find("LOCAL"), 5, "s%d.raw 0 3 1");
  for (int k = 0; k < 4; ++k) {
    test::put(folder_ / ("s" + std::to_string(k) + ".raw"),
              data.substr(static_cast<std::size_t>(12 * k), 12) + (k == 1 ? "xyz" : ""));
  }
  const auto v = read("a.mhd", header);
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"a.mhd", "48 bytes", "51 bytes"}));
}

TEST_F(CtFileTest, FindingsHaveKeyValuesAndWhatIsUsed) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  ASSERT_TRUE(test::has_value(read(
      "b.mha",
      meta("AnatomicalOrientation = LPI\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n") + data + "tail")));
  using Values = std::vector<std::string>;
  const Finding axes = finding_of(diagnostics_, "orientation");
  EXPECT_EQ(axes.subject, (folder_ / "b.mha").string());
  EXPECT_EQ(axes.values, (Values{"AnatomicalOrientation LPI", "TransformMatrix of RAI"}));
  EXPECT_EQ(axes.used, "TransformMatrix");
  const Finding length = finding_of(diagnostics_, "length of the samples");
  EXPECT_EQ(length.values, (Values{"48 bytes stated", "52 bytes found"}));
  EXPECT_EQ(length.used, "the first 48 bytes");
  EXPECT_EQ(diagnostics_.entries().size(), 2U);
}

TEST_F(CtFileTest, NamesFieldsOfAMetaImageThatContradictEachOther) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  auto v = read("a.mha", meta(kTurn + "Rotation = 1 0 0 0 1 0 0 0 1\nPosition = 5 6 7\n" +
                              "ElementSize = 2 3 5\n") +
                             data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kMm) << "TransformMatrix is used";
  const Finding turned = finding_of(diagnostics_, "TransformMatrix");
  EXPECT_EQ(turned.values, (std::vector<std::string>{"TransformMatrix 0 1 0 0 0 1 1 0 0",
                                                     "Rotation 1 0 0 0 1 0 0 0 1"}));
  EXPECT_EQ(turned.used, "TransformMatrix");
  EXPECT_EQ(finding_of(diagnostics_, "ElementSpacing").values.at(1), "ElementSize 2 3 5");
  EXPECT_EQ(finding_of(diagnostics_, "Offset").values.size(), 0U) << "they agree";
  const std::string packed = test::deflated(data);
  const auto sized = [&](std::size_t stated) {
    return read(
        "p" + std::to_string(stated) + ".mha",
        meta(kTurn, "MET_SHORT", "2 3 4",
             "CompressedData = True\nCompressedDataSize = " + std::to_string(stated) + "\n") +
            packed);
  };
  ASSERT_TRUE(test::has_value(sized(packed.size())));
  EXPECT_TRUE(finding_of(diagnostics_, "CompressedDataSize").values.empty());
  ASSERT_TRUE(test::has_value(sized(packed.size() + 7)));
  EXPECT_EQ(finding_of(diagnostics_, "CompressedDataSize").values.at(1),
            std::to_string(packed.size()) + " bytes found");
  EXPECT_TRUE(rejects(sized(packed.size() - 7), Code::kMalformedData, {"cut short"}));
}

TEST_F(CtFileTest, WarnsOfValuesThatAreNotHounsfieldUnits) {
  const auto finding = [&](std::int16_t first, std::int16_t last) {
    auto values = voxels<std::int16_t>();
    std::ranges::fill(values, static_cast<std::int16_t>(100));
    values.front() = first;
    values.back() = last;
    const std::string name = std::to_string(first) + " to " + std::to_string(last) + ".mha";
    EXPECT_TRUE(test::has_value(read(name, meta() + test::bytes_of(values), CtOptions{})));
    const auto entries = diagnostics_.entries();
    const bool found = !entries.empty() && entries.back().message.find(name) != std::string::npos;
    return found ? entries.back().finding->values.at(0) : std::string();
  };
  EXPECT_EQ(finding(-1000, 400), "");
  EXPECT_EQ(finding(-300, 400), "");
  EXPECT_NE(finding(0, 255).find("0 to 255, none below -200 HU"), std::string::npos);
  EXPECT_NE(finding(0, 254).find("in 8 bits?"), std::string::npos);
  EXPECT_NE(finding(0, 3000).find("HU + 1024?"), std::string::npos);
  EXPECT_NE(finding(-100, 3000).find("without air?"), std::string::npos);
  test::put(folder_ / "mr.mha", meta() + test::bytes_of(voxels<std::int16_t>()));
  const std::size_t before = diagnostics_.entries().size();
  ASSERT_TRUE(test::has_value(read_ct(folder_ / "mr.mha", diagnostics_, of_any_unit())));
  ASSERT_TRUE(test::has_value(read_stored_volume(folder_ / "mr.mha", diagnostics_)));
  EXPECT_EQ(diagnostics_.entries().size(), before) << "not asked for";
}

TEST_F(CtFileTest, KeepsLeftHandedDirections) {
  const auto v = read("a.mha", meta("TransformMatrix = 1 0 0 0 1 0 0 0 -1\n") +
                                   test::bytes_of(voxels<std::int16_t>()));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_NEAR(v->grid().directions.determinant(), -1, kMm);
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(7, 9, 3)).norm(), kMm);
}

TEST_F(CtFileTest, RejectsBadMetaImageGeometry) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto spacing = [&](const std::string& s) {
    return read("a.mha", meta(kTurn, "MET_SHORT", s) + data);
  };
  EXPECT_TRUE(
      rejects(spacing("0 3 4"), Code::kMalformedData, {"a.mha", "ElementSpacing", "0 3 4"}));
  EXPECT_TRUE(rejects(spacing("2 -3 4"), Code::kMalformedData, {"ElementSpacing", "-3"}));
  EXPECT_TRUE(rejects(spacing("2 nan 4"), Code::kMalformedData, {"ElementSpacing", "nan"}));
  EXPECT_TRUE(rejects(spacing("2 3"), Code::kMalformedData, {"ElementSpacing", "3 finite"}));
  const auto turned = [&](const std::string& m) {
    return read("a.mha", meta("TransformMatrix = " + m + "\n") + data);
  };
  EXPECT_TRUE(rejects(turned("1 0 0 0 nan 0 0 0 1"), Code::kMalformedData, {"TransformMatrix"}));
  EXPECT_TRUE(rejects(turned("2 0 0 0 1 0 0 0 1"), Code::kMalformedData, {"unit vectors"}));
  EXPECT_TRUE(rejects(turned("1 0 0 0.6 0.8 0 0 0 1"), Code::kUnsupportedData, {"orthogonal"}));
  EXPECT_TRUE(rejects(turned("1 0 0 0 1 0 0 0"), Code::kMalformedData, {"9 finite"}));
  EXPECT_TRUE(
      rejects(read("a.mha", meta("") + data), Code::kUnsupportedData, {"orientation of the axes"}));
  CtOptions options;
  options.accept_unknown_orientation = true;
  EXPECT_TRUE(test::has_value(read("a.mha", meta("") + data, options)));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"left, posterior, superior"}));
}

TEST_F(CtFileTest, RejectsBadMetaImageData) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  EXPECT_TRUE(rejects(read("a.mha", meta() + data.substr(0, 47)), Code::kMalformedData,
                      {"cut short", "48", "47"}));
  std::string huge = meta() + data;
  huge.replace(huge.find("3 2 4\n", huge.find("DimSize")), 6, "1000 1000 1000\n");
  EXPECT_TRUE(rejects(read("a.mha", huge), Code::kMalformedData, {"2000000000"}));
  std::string flat = meta() + data;
  flat.replace(flat.find("3 2 4\n", flat.find("DimSize")), 6, "6 4 1\n");
  EXPECT_TRUE(rejects(read("a.mha", flat), Code::kMalformedData, {"at least 2 slices"}));
  EXPECT_TRUE(rejects(
      read("a.mha",
           meta(kTurn, "MET_SHORT", "2 3 4", "ElementNumberOfChannels = 3\n") + data + data + data),
      Code::kUnsupportedData, {"one component", "3"}));
  const std::string z = test::deflated(data);
  EXPECT_TRUE(rejects(read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", "CompressedData = True\n") +
                                        z.substr(0, z.size() / 2)),
                      Code::kMalformedData, {"a.mha", "cut short"}));
}

TEST_F(CtFileTest, RejectsASequenceOfImages) {
  const std::string pixels = test::bytes_of(voxels<std::int16_t>());
  const std::string one = "Seq_Frame0000_ImageStatus = OK\n";
  EXPECT_TRUE(rejects(
      read("a.mha",
           meta(kTurn, "MET_SHORT", "2 3 4", one + "Seq_Frame0001_ImageStatus = OK\n") + pixels),
      Code::kUnsupportedData,
      {"a.mha: expected a volume, found a sequence of images (Seq_Frame fields)"}));
  const auto volume = read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", one) + pixels);
  ASSERT_TRUE(test::has_value(volume));
  expect_voxels(*volume);
}

TEST_F(CtFileTest, WritesAVolumeThatReadsBackEqual) {
  const auto v = read("a.mha", meta() + test::bytes_of(voxels<std::int16_t>()));
  ASSERT_TRUE(test::has_value(v));
  VoxelGrid grid = v->grid();
  grid.directions = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()) *
                    Eigen::Vector3d(1, 1, -1).asDiagonal();
  grid.spacing_mm << 0.1, 1.0 / 3, 2.7;
  const auto turned = Volume::create(grid, {v->hu().begin(), v->hu().end()}, "turned");
  ASSERT_TRUE(test::has_value(turned));
  for (const bool compress : {false, true}) {
    ASSERT_TRUE(test::has_value(write_ct_mha(*turned, folder_ / "out.mha", compress)));
    const auto back = read_ct(folder_ / "out.mha", diagnostics_);
    ASSERT_TRUE(test::has_value(back));
    expect_voxels(*back);
    EXPECT_LT((back->grid().directions - grid.directions).norm(), kMm);
    EXPECT_LT((back->grid().spacing_mm - grid.spacing_mm).norm(), kMm);
    EXPECT_LT((back->grid().origin_mm - grid.origin_mm).norm(), kMm);
  }
  EXPECT_TRUE(
      rejects(write_ct_mha(*turned, folder_.path() / "no" / "x.mha"), Code::kIo, {"x.mha"}));
}

std::string nrrd(const std::string& space, const std::string& extra = "",
                 const std::string& directions = "(0,2,0) (0,0,3) (4,0,0)") {
  return "NRRD0005\ntype: short\ndimension: 3\nsizes: 3 2 4\nspace: " + space +
         "\nspace directions: " + directions +
         "\nspace origin: (5,6,7)\nendian: little\nkinds: domain domain domain\n" + extra;
}

TEST_F(CtFileTest, ConvertsNrrdSpacesToLps) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto last = [&](const std::string& space) -> Eigen::Vector3d {
    const auto v = read("a.nrrd", nrrd(space, "encoding: raw\n\n") + data);
    if (!v) return Eigen::Vector3d::Constant(std::nan(""));
    expect_voxels(*v);
    return v->grid().at({2, 1, 3}).mm;
  };
  const Eigen::Vector3d p = kLastVoxel;
  EXPECT_LT((last("left-posterior-superior") - p).norm(), kMm);
  EXPECT_LT((last("LPS") - p).norm(), kMm);
  EXPECT_LT((last("RAS") - Eigen::Vector3d(-p.x(), -p.y(), p.z())).norm(), kMm);
  EXPECT_LT((last("Right-Anterior-Superior") - Eigen::Vector3d(-p.x(), -p.y(), p.z())).norm(), kMm);
  EXPECT_LT((last("LAS") - Eigen::Vector3d(p.x(), -p.y(), p.z())).norm(), kMm);
}

TEST_F(CtFileTest, ReadsGzipAndDetachedSlicesOfNrrd) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  constexpr int kGzip = 31;
  auto v = read("a.nrrd", nrrd("LPS", "encoding: gzip\n\n") + test::deflated(data, kGzip));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  // One file per slice. Each file starts with a header of 3 bytes.
  for (int k = 0; k < 4; ++k) {
    test::put(folder_ / ("s.0" + std::to_string(2 * k + 1)),
              "xyz" + data.substr(static_cast<std::size_t>(k) * 12, 12));
  }
  v = read("a.nhdr", nrrd("LPS", "encoding: raw\nbyte skip: 3\ndata file: s.%02d 1 7 2\n"));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  v = read("b.nhdr", nrrd("LPS", "encoding: raw\nbyte skip: -1\ndata file: s.%02d 1 7 2\n"));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_TRUE(rejects(read("c.nhdr", nrrd("LPS", "encoding: raw\ndata file: s.%02d 1 9 2\n")),
                      Code::kNotFound, {"s.09"}));
}

TEST_F(CtFileTest, ReadsOnlyItsShareOfEachDetachedFile) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto put_slice = [&](int k, const std::string& change) {
    const std::string slice = data.substr(static_cast<std::size_t>(k) * 12, 12);
    test::put(folder_ / ("s.0" + std::to_string(k)), change.empty() ? slice + "tail" : change);
  };
  for (int k = 0; k < 4; ++k) put_slice(k, "");
  const std::string header = nrrd("LPS", "encoding: raw\ndata file: s.%02d 0 3\n");
  const auto v = read("a.nhdr", header);
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  put_slice(1, "short");
  put_slice(2, std::string(30, 'x'));
  EXPECT_TRUE(rejects(read("a.nhdr", header), Code::kMalformedData, {"s.01", "12 bytes", "5"}));
  EXPECT_TRUE(rejects(read("b.nhdr", nrrd("LPS", "encoding: raw\ndata file: s.%02d 0 4\n")),
                      Code::kNotFound, {"s.04"}));
  put_slice(4, "");
  put_slice(1, "");
  EXPECT_TRUE(rejects(read("b.nhdr", nrrd("LPS", "encoding: raw\ndata file: s.%02d 0 4\n")),
                      Code::kMalformedData, {"5 files of one size", "48 bytes"}));
}

TEST_F(CtFileTest, MatchesNrrdDirectionsToTheirAxes) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto of_four = [&](const std::string& sizes, const std::string& kinds,
                           const std::string& directions) {
    return read("a.nrrd", "NRRD0004\ntype: int16\ndimension: 4\nsizes: " + sizes +
                              "\nendian: little\nspace: LPS\nkinds: " + kinds +
                              "\nspace directions: " + directions +
                              "\nspace origin: (0,0,0)\nencoding: raw\n\n" + data);
  };
  const std::string three = "(1,0,0) (0,1,0) (0,0,1)";
  const auto v = of_four("3 2 4 1", "domain domain domain list", three + " none");
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  // This file holds a list of three images of 2 x 4 pixels, not a volume of 3 x 2 x 4 voxels.
  EXPECT_TRUE(rejects(of_four("3 2 4 1", "list domain domain domain", "none " + three),
                      Code::kMalformedData, {"kinds", "'list domain domain domain'"}));
  EXPECT_TRUE(
      rejects(of_four("3 2 4 1", "domain list domain domain", "(1,0,0) none (0,1,0) (0,0,1)"),
              Code::kMalformedData, {"kinds"}));
  const auto one = of_four("1 3 2 4", "vector domain domain domain", "none " + three);
  ASSERT_TRUE(test::has_value(one));
  expect_voxels(*one);
  EXPECT_TRUE(rejects(of_four("1 3 2 4", "vector domain domain domain", three + " none"),
                      Code::kMalformedData, {"space directions"}));
}

TEST_F(CtFileTest, RejectsOtherUnitsThanMmInAMetaImage) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  for (const char* unit : {"um", "cm", "in"}) {
    const std::string line = std::string("DistanceUnits = ") + unit + "\n";
    EXPECT_TRUE(rejects(read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", line) + data),
                        Code::kMalformedData, {"DistanceUnits", "mm", unit}));
  }
  for (const char* line : {"DistanceUnits = mm\n", "DistanceUnits = ?\n"}) {
    EXPECT_TRUE(test::has_value(read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", line) + data)));
  }
}

TEST_F(CtFileTest, RejectsASkipBeyondTheEndOfTheFile) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  for (const char* skip : {"1", "1000", "9223372036854775807"}) {
    const std::string rest = std::string("encoding: raw\nbyte skip: ") + skip + "\n\n";
    const auto v = read("a.nrrd", nrrd("LPS", rest) + data);
    EXPECT_TRUE(rejects(v, Code::kMalformedData, {"cut short: expected 48 bytes, found"}));
    EXPECT_EQ(v.error().message.find("found -"), std::string::npos) << v.error().message;
  }
}

TEST_F(CtFileTest, RejectsBadNrrd) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto directions = [&](const std::string& d) {
    return read("a.nrrd", nrrd("LPS", "encoding: raw\n\n", d) + data);
  };
  EXPECT_TRUE(rejects(directions("(1,0,0) (0,1,0)"), Code::kMalformedData, {"space directions"}));
  EXPECT_TRUE(
      rejects(directions("(1,0,0) (0,nan,0) (0,0,1)"), Code::kMalformedData, {"space directions"}));
  EXPECT_TRUE(rejects(directions("(1,0,0) (0,0,0) (0,0,1)"), Code::kMalformedData, {"spacing"}));
  EXPECT_TRUE(
      rejects(directions("(1,0,0) (0.5,1,0) (0,0,1)"), Code::kUnsupportedData, {"orthogonal"}));
  EXPECT_TRUE(rejects(read("a.nrrd", nrrd("scanner-xyz", "encoding: raw\n\n") + data),
                      Code::kUnsupportedData, {"scanner-xyz"}));
  EXPECT_TRUE(rejects(read("a.nrrd", nrrd("LPS", "encoding: bzip2\n\n") + data),
                      Code::kUnsupportedData, {"bzip2"}));
  EXPECT_TRUE(rejects(
      read("a.nrrd", nrrd("LPS", "space units: \"cm\" \"cm\" \"cm\"\nencoding: raw\n\n") + data),
      Code::kMalformedData, {"space units", "mm"}));
}

template <class T>
void set(std::string& bytes, std::size_t offset, T value, bool swap = false) {
  std::string raw =
      swap ? test::swapped_bytes_of(std::vector<T>{value}) : test::bytes_of(std::vector<T>{value});
  bytes.replace(offset, sizeof(T), raw);
}

/// Returns a NIfTI-1 header of 3 x 2 x 4 int16 voxels without any orientation.
std::string nifti(bool swap = false, std::int16_t datatype = 4) {
  std::string h(352, '\0');
  set<std::int32_t>(h, 0, 348, swap);
  const std::vector<std::int16_t> dim = {3, 3, 2, 4, 1, 1, 1, 1};
  const std::vector<float> pixdim = {1, 2, 3, 4, 0, 0, 0, 0};
  for (std::size_t i = 0; i < 8; ++i) {
    set(h, 40 + 2 * i, dim[i], swap);
    set(h, 76 + 4 * i, pixdim[i], swap);
  }
  set<std::int16_t>(h, 70, datatype, swap);
  set<float>(h, 108, 352, swap);
  h[123] = 2;  // Unit: mm.
  h.replace(344, 4, std::string("n+1\0", 4));
  return h;
}

/// Sets an s-form in RAS that is equivalent to kTurn and kLastVoxel in LPS.
void set_sform(std::string& h, bool swap = false) {
  set<std::int16_t>(h, 254, 1, swap);
  const std::vector<float> rows = {0, 0, -4, -5, -2, 0, 0, -6, 0, 3, 0, 7};
  for (std::size_t i = 0; i < 12; ++i) set(h, 280 + 4 * i, rows[i], swap);
}

TEST_F(CtFileTest, ConvertsNiftiWithSformToLps) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string h = nifti();
  set_sform(h);
  constexpr int kGzip = 31;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>("a.nii", h + data),
                                    {"a.nii.gz", test::deflated(h + data, kGzip)}}) {
    const auto v = read(name, bytes);
    ASSERT_TRUE(test::has_value(v)) << name;
    expect_voxels(*v);
    EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kFloat32Mm);
  }
  std::string big = nifti(true);
  set_sform(big, true);
  const auto v = read("big.nii", big + test::swapped_bytes_of(voxels<std::int16_t>()));
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kFloat32Mm);
}

TEST_F(CtFileTest, ConvertsNiftiWithQformToLps) {
  // Half a turn about the RAS x axis (b = 1). It reverses j and k.
  std::string h = nifti();
  set<std::int16_t>(h, 252, 1);
  set<float>(h, 256, 1);
  set<float>(h, 268, 50);
  set<float>(h, 272, 60);
  set<float>(h, 276, 70);
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  auto v = read("q.nii", h + data);
  ASSERT_TRUE(test::has_value(v));
  // RAS (50 + 2, 60 - 3, 70 - 4) for index (1, 1, 1).
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(-52, -57, 66)).norm(), kFloat32Mm);
  set<float>(h, 76, -1);  // A qfac of -1 reverses the third axis.
  v = read("q.nii", h + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(-52, -57, 74)).norm(), kFloat32Mm);
  EXPECT_NEAR(v->grid().directions.determinant(), -1, kFloat32Mm);
  EXPECT_EQ(v->at(2, 1, 3), 213);
  // If the s-form and the q-form differ, the reader uses the s-form and warns.
  set_sform(h);
  v = read("q.nii", h + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kFloat32Mm);
  EXPECT_TRUE(
      says(diagnostics_, Severity::kWarning, {"q.nii", "s-form [", "q-form [", "used: s-form"}));
}

TEST_F(CtFileTest, NamesSpacingsOfAnNrrdThatContradictItsDirections) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  ASSERT_TRUE(
      test::has_value(read("a.nrrd", nrrd("LPS", "spacings: 2 3 4.01\nencoding: raw\n\n") + data)));
  EXPECT_TRUE(diagnostics_.entries().empty()) << "rounded";
  const auto v = read("b.nrrd", nrrd("LPS", "spacings: 1 1 1\nencoding: raw\n\n") + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().spacing_mm - Eigen::Vector3d(2, 3, 4)).norm(), kMm);
  const Finding found = finding_of(diagnostics_, "spacing");
  EXPECT_EQ(found.values,
            (std::vector<std::string>{"space directions 2 3 4 mm", "spacings 1 1 1"}));
  EXPECT_EQ(found.used, "space directions");
}

TEST_F(CtFileTest, ComparesBitsAndQuaternionOfANifti) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string h = nifti();
  set_sform(h);
  set<std::int16_t>(h, 72, 16);
  ASSERT_TRUE(test::has_value(read("a.nii", h + data)));
  EXPECT_TRUE(diagnostics_.entries().empty());
  set<std::int16_t>(h, 72, 32);
  ASSERT_TRUE(test::has_value(read("b.nii", h + data)));
  EXPECT_EQ(finding_of(diagnostics_, "bits of a voxel").values,
            (std::vector<std::string>{"datatype 16", "bitpix 32"}));
  std::string q = nifti();
  set<std::int16_t>(q, 252, 1);
  set<float>(q, 256, 0.9F);
  set<float>(q, 260, 0.9F);
  EXPECT_TRUE(rejects(read("q.nii", q + data), Code::kMalformedData, {"q.nii", "q-form", "1.62"}));
}

TEST_F(CtFileTest, NamesVoxelsOfAnotherUnit) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  for (const auto& [spacing, guess] : {std::pair("0.002 0.002 0.002", "metres?"),
                                       {"1000 1000 1000", "micrometres?"},
                                       {"0.7 0.7 0.009", "metres?"}}) {
    CollectingDiagnostics heard;
    test::put(folder_ / "a.mha", meta(kTurn, "MET_SHORT", spacing) + data);
    ASSERT_TRUE(test::has_value(read_ct(folder_ / "a.mha", heard, of_any_unit())));
    const Finding found = finding_of(heard, "size of the voxels");
    ASSERT_EQ(found.values.size(), 1u) << spacing;
    EXPECT_NE(found.values[0].find(guess), std::string::npos) << found.values[0];
    EXPECT_EQ(found.used, "millimetres");
  }
  ASSERT_TRUE(test::has_value(read("b.mha", meta(kTurn, "MET_SHORT", "0.05 0.05 10") + data)));
  EXPECT_EQ(finding_of(diagnostics_, "size of the voxels").values.size(), 0u);
}

TEST_F(CtFileTest, RejectsKeysOfAMetaImageInAnotherCase) {
  const std::string data = test::swapped_bytes_of(voxels<std::int16_t>());
  const auto v =
      read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", "BinaryDataByteOrderMSB = true\n") + data);
  ASSERT_TRUE(test::has_value(v)) << "the value, not the key";
  expect_voxels(*v);
  for (const std::string key :
       {"binarydatabyteordermsb", "compresseddata", "Anatomicalorientation"}) {
    EXPECT_TRUE(rejects(read("a.mha", meta(kTurn, "MET_SHORT", "2 3 4", key + " = True\n") + data),
                        Code::kMalformedData, {"a.mha", "expected the key", key}));
  }
  EXPECT_TRUE(rejects(read("a.mha", meta("TransformMatrix = 1 0 0 0 1 0 0 0\n") + data),
                      Code::kMalformedData, {"TransformMatrix: expected 9 finite numbers"}));
}

TEST_F(CtFileTest, NamesKeysThatAreOneLetterOff) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  for (const std::string key : {"CompressedDat", "DistanceUnit", "AnatomicalOrientatiom"}) {
    CollectingDiagnostics heard;
    test::put(folder_ / "a.mha", meta(kTurn, "MET_SHORT", "2 3 4", key + " = x\n") + data);
    ASSERT_TRUE(test::has_value(read_ct(folder_ / "a.mha", heard, of_any_unit())));
    EXPECT_TRUE(says(heard, Severity::kWarning, {key + ": unknown (is it "})) << key;
  }
  ASSERT_TRUE(test::has_value(read("b.nrrd", nrrd("LPS", "old mim: 0\nencoding: raw\n\n") + data)));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"old mim: unknown (is it old min?)"}));
  CollectingDiagnostics quiet;
  test::put(folder_ / "c.mha", meta(kTurn, "MET_SHORT", "2 3 4", "Comment = x\n") + data);
  ASSERT_TRUE(test::has_value(read_ct(folder_ / "c.mha", quiet, of_any_unit())));
  EXPECT_TRUE(quiet.entries().empty());
}

TEST_F(CtFileTest, ReadsKeysOfAnNrrdInAnyCase) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string header = nrrd("LPS", "encoding: raw\n\n");
  for (const auto& [usual, other] : {std::pair("space directions", "Space Directions"),
                                     {"space:", "SPACE:"},
                                     {"sizes", "Sizes"}}) {
    header.replace(header.find(usual), std::string(usual).size(), other);
  }
  const auto v = read("a.nrrd", header + data);
  ASSERT_TRUE(test::has_value(v));
  expect_voxels(*v);
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kMm);
}

TEST_F(CtFileTest, NamesStatementsOfAnNrrdThatAreNotUsed) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  const auto v = read("a.nrrd", nrrd("LPS",
                                     "thicknesses: NaN NaN 8\nsample units: Gy\naxis mins: 0 0 0\n"
                                     "measurement frame: (1,0,0) (0,1,0) (0,0,1)\n"
                                     "space dimension: 2\nencoding: raw\n\n") +
                                    data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(finding_of(diagnostics_, "thicknesses").values,
            (std::vector<std::string>{"slices 8 mm thick", "4 mm apart"}));
  EXPECT_EQ(finding_of(diagnostics_, "sample units").values, std::vector<std::string>{"Gy"});
  EXPECT_EQ(finding_of(diagnostics_, "axis mins").used, "space directions and space origin");
  EXPECT_EQ(finding_of(diagnostics_, "space dimension").used, "3");
  EXPECT_EQ(finding_of(diagnostics_, "measurement frame").severity, Severity::kInfo);
  std::string header = nrrd("LPS", "encoding: raw\n\n");
  const std::string kinds = "domain domain domain";
  header.replace(header.find(kinds), kinds.size(), "domain domain time");
  EXPECT_TRUE(rejects(read("t.nrrd", header + data), Code::kMalformedData,
                      {"kinds: expected three axes in space, found 'domain domain time'"}));
}

TEST_F(CtFileTest, NamesStatementsOfANiftiThatAreNotUsed) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string h = nifti();
  set_sform(h);
  ASSERT_TRUE(test::has_value(read("a.nii", h + data)));
  EXPECT_TRUE(diagnostics_.entries().empty());
  set<std::int16_t>(h, 68, 1002);
  set<float>(h, 116, -1024);
  h[123] = 0;
  ASSERT_TRUE(test::has_value(read("b.nii", h + data)));
  EXPECT_EQ(finding_of(diagnostics_, "intent_code").values,
            std::vector<std::string>{"1002, labels (expected 0, none)"});
  EXPECT_EQ(finding_of(diagnostics_, "scl_slope, scl_inter").values,
            (std::vector<std::string>{"a slope of 0, no scaling", "scl_inter -1024"}));
  EXPECT_EQ(finding_of(diagnostics_, "xyzt_units").used, "millimetres");
}

TEST_F(CtFileTest, WarnsOfQuantisedNrrd) {
  const auto v = read("a.nrrd", nrrd("LPS", "old min: -1024\nold max: 3071\nencoding: raw\n\n") +
                                    test::bytes_of(voxels<std::int16_t>()));
  ASSERT_TRUE(test::has_value(v));
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"a.nrrd", "-1024", "3071", "quantised"}));
}

TEST_F(CtFileTest, ComparesTheSpacingOfTheSformWithPixdim) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  std::string h = nifti();
  set_sform(h);
  set<float>(h, 80, 0.5F);
  auto v = read("p.nii", h + data);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kFloat32Mm) << "by the s-form";
  EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"p.nii", "2 3 4", "0.5 3 4", "pixdim"}));
  set<std::int16_t>(h, 252, 1);  // A q-form has the spacing of pixdim, too.
  EXPECT_TRUE(rejects(read("q.nii", h + data), Code::kMalformedData,
                      {"q.nii", "2 3 4", "0.5 3 4", "q-form"}));
  for (const float no_spacing : {0.0F, -2.0F, std::nanf("")}) {
    set<float>(h, 80, no_spacing);
    v = read("r.nii", h + data);
    ASSERT_TRUE(test::has_value(v)) << no_spacing;
    EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kFloat32Mm) << "by the s-form";
    EXPECT_TRUE(says(diagnostics_, Severity::kWarning, {"r.nii", "2 3 4", "pixdim"}));
  }
}

TEST_F(CtFileTest, ReadsNifti2AndScaling) {
  std::string h(544, '\0');
  set<std::int32_t>(h, 0, 540);
  h.replace(4, 8, std::string("n+2\0\r\n\032\n", 8));
  set<std::int16_t>(h, 12, 16);  // float
  const std::vector<std::int64_t> dim = {3, 3, 2, 4, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) {
    set(h, 16 + 8 * i, dim[i]);
    set<double>(h, 104 + 8 * i, 1);
  }
  set<std::int64_t>(h, 168, 544);
  set<double>(h, 176, 2);
  set<double>(h, 184, -100);
  set<std::int32_t>(h, 348, 1);
  const std::vector<double> rows = {0, 0, -4, -5, -2, 0, 0, -6, 0, 3, 0, 7};
  for (std::size_t i = 0; i < 12; ++i) set(h, 400 + 8 * i, rows[i]);
  set<std::int32_t>(h, 500, 2);
  const auto v = read("two.nii", h + test::bytes_of(voxels<float>()));
  ASSERT_TRUE(test::has_value(v));
  EXPECT_EQ(v->at(2, 1, 3), 2 * 213 - 100);
  EXPECT_LT((v->grid().at({2, 1, 3}).mm - kLastVoxel).norm(), kMm);
}

TEST_F(CtFileTest, VerifiesTheChecksumOfCompressedNifti) {
  constexpr int kGzip = 31;
  constexpr std::size_t kBuffer = 64 << 10;  // Probable read size of a reader.
  std::string noise;  // Random bytes do not compress, so a changed bit of the file changes a voxel.
  unsigned state = 7;
  while (noise.size() < kBuffer) {
    state = state * 1664525U + 1013904223U;
    noise += static_cast<char>(state >> 24);
  }
  constexpr std::size_t kVoxels = 2UL * 30 * 20 * 54;
  const auto file = [&](std::size_t offset, const std::string& tail) {
    std::string h = nifti();
    set_sform(h);
    set<std::int16_t>(h, 42, 30);
    set<std::int16_t>(h, 44, 20);
    set<std::int16_t>(h, 46, 54);
    set(h, 108, static_cast<float>(offset));
    h += noise.substr(noise.size() - (offset - h.size()));
    return test::deflated(h + noise.substr(0, kVoxels) + tail, kGzip);
  };
  // The offset is chosen so that the checksum, which precedes the 4 bytes of the length, crosses
  // the end of the buffer.
  constexpr std::size_t kAcross = 6;
  const std::size_t tight = file(352, "").size() % kBuffer;
  const std::size_t offset = 352 + (kBuffer + kAcross - tight) % kBuffer;
  ASSERT_LT(offset, 1000U);
  const std::string whole = file(offset, "");
  ASSERT_NEAR(static_cast<double>(whole.size() % kBuffer), kAcross, 1);
  EXPECT_TRUE(test::has_value(read("a.nii.gz", whole)));
  std::string changed = whole;
  changed[20000] = static_cast<char>(changed[20000] ^ 64);
  EXPECT_TRUE(rejects(read("a.nii.gz", changed), Code::kMalformedData, {"a.nii.gz", "damaged"}));
  std::string other_sum = whole;
  other_sum[whole.size() - 8] = static_cast<char>(other_sum[whole.size() - 8] ^ 1);
  EXPECT_TRUE(rejects(read("a.nii.gz", other_sum), Code::kMalformedData, {"a.nii.gz", "checksum"}));
  EXPECT_TRUE(rejects(read("a.nii.gz", whole.substr(0, whole.size() - 5)), Code::kMalformedData,
                      {"a.nii.gz", "cut short"}));
  // Data after the voxels are read, with a warning.
  EXPECT_TRUE(test::has_value(read("a.nii.gz", file(352, noise))));
}

TEST_F(CtFileTest, SaysThatANiftiHasMoreVoxelsThanItsHeaderStates) {
  std::string h = nifti();
  set_sform(h);
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  constexpr int kGzip = 31;
  ASSERT_TRUE(test::has_value(read("a.nii", h + data)));
  ASSERT_TRUE(test::has_value(read("a.nii.gz", test::deflated(h + data, kGzip))));
  EXPECT_TRUE(diagnostics_.entries().empty());
  ASSERT_TRUE(test::has_value(read("b.nii", h + data + "xyz")));
  ASSERT_TRUE(test::has_value(read("c.nii.gz", test::deflated(h + data + "xyz", kGzip))));
  const auto entries = diagnostics_.entries();
  ASSERT_EQ(entries.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = i == 0 ? "b.nii: " : "c.nii.gz: ";
    EXPECT_NE(entries[i].message.find(
                  name + "length of the samples: 48 bytes stated against 51 bytes found"),
              std::string::npos)
        << entries[i].message;
  }
}

TEST_F(CtFileTest, AsksAboutVoxelsThatNoScannerMakes) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  for (const auto& [spacing, usual] : {std::pair("0.5 0.5 10", true),
                                       {"10 0.5 0.5", true},
                                       {"0.5 0.5 0.2", true},
                                       {"2 0.2 2", false},
                                       {"0.5 0.5 50", false}}) {
    const std::size_t before = diagnostics_.entries().size();
    ASSERT_TRUE(test::has_value(
        read(std::string(spacing) + ".mha", meta(kTurn, "MET_SHORT", spacing) + data)));
    EXPECT_EQ(diagnostics_.entries().size(), before + (usual ? 0 : 1)) << spacing;
  }
  EXPECT_NE(diagnostics_.entries()[0].message.find(
                "spacing: 2 x 0.2 x 2 mm (expected pixels that are about square)"),
            std::string::npos)
      << diagnostics_.entries()[0].message;
}

TEST_F(CtFileTest, RejectsBadNifti) {
  const std::string data = test::bytes_of(voxels<std::int16_t>());
  EXPECT_TRUE(rejects(read("a.nii", nifti() + data), Code::kUnsupportedData,
                      {"neither s-form nor q-form"}));
  CtOptions accept;
  accept.accept_unknown_orientation = true;
  const auto v = read("a.nii", nifti() + data, accept);
  ASSERT_TRUE(test::has_value(v));
  EXPECT_LT((v->grid().at({1, 1, 1}).mm - Eigen::Vector3d(2, 3, 4)).norm(), kMm);
  const auto broken = [&](const std::function<void(std::string&)>& change) {
    std::string h = nifti();
    set_sform(h);
    change(h);
    return read("a.nii", h + data);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<float>(h, 284, nan); }), Code::kMalformedData,
                      {"s-form", "finite"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<float>(h, 280, 3); }), Code::kUnsupportedData,
                      {"orthogonal"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<std::int16_t>(h, 70, 1024); }),
                      Code::kUnsupportedData, {"datatype", "1024"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<std::int16_t>(h, 42, 30000); }),
                      Code::kMalformedData, {"cut short"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<std::int16_t>(h, 42, -3); }),
                      Code::kUnsupportedData, {"dim"}));
  EXPECT_TRUE(
      rejects(broken([&](auto& h) { set<std::int16_t>(h, 40, 4), set<std::int16_t>(h, 48, 2); }),
              Code::kUnsupportedData, {"dim", "4 3 2 4 2"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<float>(h, 108, nan); }), Code::kMalformedData,
                      {"vox_offset"}));
  EXPECT_TRUE(rejects(broken([&](auto& h) { set<float>(h, 112, nan); }), Code::kMalformedData,
                      {"scl_slope"}));
  EXPECT_TRUE(
      rejects(broken([&](auto& h) { h[0] = 1; }), Code::kUnsupportedData, {"NIfTI header"}));
  EXPECT_TRUE(rejects(read("a.nii", "short"), Code::kMalformedData, {"header cut short"}));
  std::string q = nifti();
  set<std::int16_t>(q, 252, 1);
  set<float>(q, 84, 0);
  EXPECT_TRUE(rejects(read("a.nii", q + data), Code::kMalformedData, {"pixdim", "found 0"}));
}

/// Returns the HU of the samples with the rescale, and the messages of the builder.
std::pair<std::vector<std::int16_t>, std::string> hu_of(const std::string& bytes, PixelType type,
                                                        const detail::Rescale& rescale) {
  detail::HuBuilder builder(1);
  builder.append(std::as_bytes(std::span(bytes)), type, rescale);
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::has_value(builder.report("a", {1, 1, 1}, "HU", diagnostics)));
  std::string said;
  for (const auto& entry : diagnostics.entries()) said += entry.message + '\n';
  return {builder.take(), said};
}

template <class T>
void expect_shift_is_rescaling(PixelType type) {
  std::vector<T> samples;
  for (int i = 0; i < 65536; ++i) samples.push_back(static_cast<T>(i));
  const std::string bytes = test::bytes_of(samples) + 'x';  // The last half of a sample is ignored.
  for (const double intercept : {0.0, -1024.0, 1000.0, -1e6, 1e6, 3e9, 0.25}) {
    // A padding range that no sample has disables the fast path.
    const auto slow = hu_of(bytes, type, {1, intercept, {{1e9, 1e9}}});
    const auto quick = hu_of(bytes, type, {1, intercept, {}});
    EXPECT_EQ(quick.first.size(), samples.size());
    EXPECT_EQ(quick, slow) << intercept;
  }
}

TEST(HuBuilderTest, WarnsAboutValuesBelowAirThatAreNoPadding) {
  const auto said = [](const std::vector<std::int16_t>& values, std::int16_t least) {
    detail::HuBuilder builder(0, least);
    builder.append(std::as_bytes(std::span(values)), PixelType::kInt16, {1, 0, {}});
    CollectingDiagnostics diagnostics;
    EXPECT_TRUE(test::has_value(
        builder.report("a", {static_cast<int>(values.size()), 1, 1}, "HU", diagnostics)));
    std::vector<std::pair<Severity, std::string>> out;
    for (const auto& entry : diagnostics.entries()) {
      out.emplace_back(entry.severity, entry.message);
    }
    return std::pair(builder.take(), out);
  };
  std::vector<std::int16_t> padded(1000, 40);
  std::fill_n(padded.begin(), 300, -3024);
  const auto [hu, quiet] = said(padded, kAirHu);
  EXPECT_EQ(hu.front(), kAirHu);
  ASSERT_EQ(quiet.size(), 1u);
  EXPECT_EQ(quiet[0].first, Severity::kInfo);
  std::vector<std::int16_t> magnetic(1000);
  for (std::size_t i = 0; i < magnetic.size(); ++i) {
    magnetic[i] = static_cast<std::int16_t>(4 * static_cast<int>(i) - 2000);
  }
  const auto [lost, loud] = said(magnetic, kAirHu);
  EXPECT_EQ(lost.front(), kAirHu);
  ASSERT_EQ(loud.size(), 1u);
  EXPECT_EQ(loud[0].first, Severity::kWarning);
  EXPECT_NE(loud[0].second.find("values below -1024 HU: 244 voxels, down to -2000 HU"),
            std::string::npos)
      << loud[0].second;
  const auto [kept, nothing] = said(magnetic, -32768);
  EXPECT_EQ(kept, magnetic) << "ultrasound keeps them";
  EXPECT_TRUE(nothing.empty());
}

TEST(HuBuilderTest, WholeNumbersGiveTheSameHuWithAndWithoutRescaling) {
  expect_shift_is_rescaling<std::int16_t>(PixelType::kInt16);
  expect_shift_is_rescaling<std::uint16_t>(PixelType::kUint16);
}

}  // namespace
}  // namespace nav::io
