// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/plus_config.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "io/config_findings.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

const std::string kConfig = R"(<?xml version="1.0"?>
<PlusConfiguration version="2.4">
  <DataCollection StartupDelaySec="1.0">
    <DeviceSet Name="x" />
    <Device Id="Video" Type="SavedDataSource" SequenceFile="a b.igs.mha"
      UseData="IMAGE_AND_TRANSFORM" UseOriginalTimestamps="TRUE" RepeatEnabled="false"
      LocalTimeOffsetSec="-0.125" ToolReferenceFrame="Tracker" Novel="kept">
      <DataSources>
        <DataSource Type="Video" Id="V" PortUsImageOrientation="UN" />
        <DataSource Type="Tool" Id="Probe" PortName="0" />
      </DataSources>
      <OutputChannels><OutputChannel Id="O"><RfProcessing>
        <ScanConversion TransducerName="C5" TransducerGeometry="CURVILINEAR" RadiusStartMm="10.5"
          RadiusStopMm="82" ThetaStartDeg="-90" ThetaStopDeg="45" OutputImageSizePixel="820 616"
          TransducerCenterPixel="410 87" OutputImageSpacingMmPerPixel="0.15 0.16"/>
      </RfProcessing></OutputChannel></OutputChannels>
    </Device>
    <Device Id="Other" Type="Stepper" />
  </DataCollection>
  <CoordinateDefinitions>
    <Transform From="Image" To="Probe" Matrix="
       0.1 2 3 4
       5	6 7 8
       9 10 11 12e-1
       0 0 0 1" Error="0.58" Date="2012.02.06 17:57:00"/>
    <Transform From="StylusTip" To="Stylus" Matrix="1 0 0 203 0 1 0 0 0 0 1 0 0 0 0 1" />
  </CoordinateDefinitions>
</PlusConfiguration>)";

class PlusConfigTest : public ::testing::Test {
 protected:
  Result<PlusConfig> read(const std::string& text) {
    test::put(folder_ / "c.xml", text);
    return read_plus_config(folder_ / "c.xml");
  }
  static std::string replaced(const std::string& what, const std::string& with) {
    std::string text = kConfig;
    return text.replace(text.find(what), what.size(), with);
  }
  test::TemporaryFolder folder_;
};

TEST_F(PlusConfigTest, ReadsTransformsDevicesAndGeometry) {
  const auto config = read(kConfig);
  ASSERT_TRUE(test::has_value(config));
  EXPECT_EQ(config->version, "2.4");
  ASSERT_EQ(config->transforms.size(), 2U);
  const CoordinateDefinition* image = config->find("Image", "Probe");
  ASSERT_NE(image, nullptr);
  Eigen::Matrix4d expected;
  expected << 0.1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 1.2, 0, 0, 0, 1;
  EXPECT_EQ(image->to_from_from, expected);
  EXPECT_EQ(image->error, 0.58);
  EXPECT_EQ(image->date, "2012.02.06 17:57:00");
  EXPECT_FALSE(config->find("StylusTip", "Stylus")->error.has_value());
  EXPECT_EQ(config->find("Probe", "Image"), nullptr);

  ASSERT_EQ(config->devices.size(), 2U);
  const PlusDevice& device = config->devices[0];
  EXPECT_EQ(device.id, "Video");
  EXPECT_EQ(device.sequence_file, "a b.igs.mha");
  EXPECT_EQ(device.use_data, "IMAGE_AND_TRANSFORM");
  EXPECT_TRUE(device.use_original_timestamps);
  EXPECT_FALSE(device.repeat);
  EXPECT_EQ(device.local_time_offset_s, -0.125);
  EXPECT_EQ(device.tool_reference_frame, "Tracker");
  EXPECT_EQ(device.attributes.at("Novel"), "kept");
  ASSERT_EQ(device.data_sources.size(), 2U);
  EXPECT_EQ(device.data_sources[0].image_orientation, "UN");
  EXPECT_EQ(device.data_sources[1].attributes.at("PortName"), "0");
  EXPECT_EQ(config->devices[1].local_time_offset_s, 0);

  ASSERT_TRUE(config->scan_conversion.has_value());
  const ScanConversion& scan = *config->scan_conversion;
  EXPECT_EQ(scan.geometry, TransducerGeometry::kCurvilinear);
  EXPECT_EQ(scan.radius_start_mm, 10.5);
  EXPECT_NEAR(*scan.theta_start_rad, -M_PI / 2, 1e-15);
  EXPECT_NEAR(*scan.theta_stop_rad, M_PI / 4, 1e-15);
  EXPECT_EQ(*scan.output_spacing_mm, Eigen::Vector2d(0.15, 0.16));
  EXPECT_EQ(*scan.transducer_centre_px, Eigen::Vector2d(410, 87));
  EXPECT_FALSE(scan.imaging_depth_mm.has_value());
  EXPECT_EQ(scan.attributes.at("TransducerName"), "C5");
}

TEST_F(PlusConfigTest, ErrorsNameTheElementTheExpectationAndTheFinding) {
  EXPECT_TRUE(rejects(read(replaced("12e-1", "nan")), Code::kMalformedData,
                      {"c.xml", "ImageToProbe", "Matrix", "16 finite"}));
  EXPECT_TRUE(rejects(read(replaced("12e-1", "")), Code::kMalformedData, {"ImageToProbe"}));
  EXPECT_TRUE(rejects(read(replaced("12e-1", "12 13")), Code::kMalformedData, {"ImageToProbe"}));
  EXPECT_TRUE(
      rejects(read(replaced("From=\"StylusTip\" To=\"Stylus\"", "From=\"Image\" To=\"Probe\"")),
              Code::kMalformedData, {"ImageToProbe", "found two"}));
  EXPECT_TRUE(rejects(read(replaced("To=\"Stylus\"", "To=\"\"")), Code::kMalformedData,
                      {"StylusTip", "From and To"}));
  EXPECT_TRUE(rejects(read(replaced("-0.125", "soon")), Code::kMalformedData,
                      {"Device Video", "LocalTimeOffsetSec", "'soon'"}));
  EXPECT_TRUE(rejects(read(replaced("\"TRUE\"", "\"maybe\"")), Code::kMalformedData,
                      {"UseOriginalTimestamps", "'maybe'"}));
  EXPECT_TRUE(rejects(read(replaced("CURVILINEAR", "ROUND")), Code::kMalformedData,
                      {"TransducerGeometry", "'ROUND'"}));
  EXPECT_TRUE(rejects(read(replaced("0.15 0.16", "0.15")), Code::kMalformedData,
                      {"OutputImageSpacingMmPerPixel", "2 finite"}));
  EXPECT_TRUE(rejects(read("<Other/>"), Code::kMalformedData, {"PlusConfiguration", "'Other'"}));
  EXPECT_TRUE(rejects(read("<PlusConfiguration>"), Code::kMalformedData, {"XML", "byte"}));
  EXPECT_TRUE(rejects(read(""), Code::kMalformedData, {"XML"}));
  EXPECT_TRUE(rejects(read_plus_config(folder_ / "no.xml"), Code::kNotFound, {"no.xml"}));
  EXPECT_TRUE(rejects(read_plus_config(folder_.path()), Code::kIo, {"folder"}));
}

TEST_F(PlusConfigTest, ExpandsNoXmlEntities) {
  test::put(folder_ / "secret.txt", "secret");
  const auto config =
      read("<!DOCTYPE x [<!ENTITY e SYSTEM \"file://" + (folder_ / "secret.txt").string() +
           "\"><!ENTITY a \"AAAA\"><!ENTITY b \"&a;&a;&a;\">]>"
           "<PlusConfiguration><DataCollection><Device Id=\"&e;\" Type=\"&b;\"/></DataCollection>"
           "</PlusConfiguration>");
  ASSERT_TRUE(test::has_value(config));
  EXPECT_EQ(config->devices[0].id, "&e;");
  EXPECT_EQ(config->devices[0].type, "&b;");
}

TEST_F(PlusConfigTest, SurvivesDeepNesting) {
  constexpr int kDepth = 200000;
  std::string text = "<PlusConfiguration>";
  for (int i = 0; i < kDepth; ++i) text += "<a>";
  for (int i = 0; i < kDepth; ++i) text += "</a>";
  EXPECT_TRUE(test::has_value(read(text + "</PlusConfiguration>")));
}

TEST_F(PlusConfigTest, FindsWhatAConfigurationContradicts) {
  const auto found = [&](const std::string& transforms) {
    const auto config = read("<PlusConfiguration><CoordinateDefinitions>" + transforms +
                             "</CoordinateDefinitions></PlusConfiguration>");
    EXPECT_TRUE(test::has_value(config));
    std::string all;
    for (const Finding& finding : findings_of(*config)) {
      EXPECT_EQ(finding.subject, (folder_ / "c.xml").string());
      all += finding.key + ": " + sentence_of(finding) + "\n";
    }
    return all;
  };
  const auto transform = [](const char* from, const char* to, const char* matrix) {
    return std::string("<Transform From=\"") + from + "\" To=\"" + to + "\" Matrix=\"" + matrix +
           "\"/>";
  };
  const char* const good = "0.2 0 0 1  0 0.2 0 2  0 0 0.2 3  0 0 0 1";
  const char* const tip = "1 0 0 0  0 1 0 0  0 0 1 150  0 0 0 1";
  EXPECT_EQ(found(transform("Image", "Probe", good) + transform("StylusTip", "Stylus", tip)), "");
  EXPECT_NE(found(transform("Image", "Probe", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"))
                .find("ImageToProbe: the identity"),
            std::string::npos);
  EXPECT_NE(found(transform("Image", "Probe", "1e-5 0 0 1  0 0.2 0 2  0 0 0.2 3  0 0 0 1"))
                .find("pixels of at least 1e-4 mm"),
            std::string::npos);
  EXPECT_NE(found(transform("StylusTip", "Stylus", "1 0 0 0  0 1 0 0  0 0 1 0.15  0 0 0 1"))
                .find("unit of StylusTip on Stylus"),
            std::string::npos);
  EXPECT_NE(found(transform("Stylus", "Phantom", "2 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1"))
                .find("StylusToPhantom"),
            std::string::npos);
  const std::string loop =
      found(transform("A", "B", tip) + transform("B", "C", tip) + transform("A", "C", tip));
  EXPECT_NE(loop.find("position of A in C: "), std::string::npos) << loop;
  EXPECT_NE(loop.find("AToC, which places it 150 mm away"), std::string::npos) << loop;
  EXPECT_NE(found(transform("A", "B", tip) + transform("B", "A", tip))
                .find("expected each other's inverse"),
            std::string::npos);
  EXPECT_TRUE(test::has_value(read(kConfig)));
}

}  // namespace
}  // namespace nav::io
