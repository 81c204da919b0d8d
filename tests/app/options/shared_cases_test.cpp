// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Small inputs that once went wrong, one test each: they lie in the folder cases/ beside the
// third-party data.
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

/// A folder of cases/, the command and the answer that is right. In the texts, @ stands for the
/// folder and # for a folder to write to.
struct SharedCase {
  std::string name, folder, command;
  int code = 0;
  std::vector<std::string> said = {};      ///< Pieces of standard error.
  std::vector<std::string> reported = {};  ///< Pieces of standard output or report.json.
};

void PrintTo(const SharedCase& one, std::ostream* out) { *out << one.folder; }

std::string info_of(const std::string& file) { return "info @/" + file; }

std::string small_replay(const std::string& sweep, const std::string& ct,
                         const std::string& options) {
  return "replay @/" + sweep + " --ct @/" + ct + " --out # --width 96 --height 64 --step 2 " +
         options;
}

std::string input_replay(const std::string& options = "") {
  return small_replay("sweep.igs.mha", "../phantom.mha",
                      "--ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1' " + options);
}

const std::vector<std::string> kPhantomHu{"hu_min: -500", "hu_max: 900"};

const std::vector<SharedCase> kCases{
    {"DicomClassicWithFunctionalGroups",
     "input/dicom-classic-with-functional-groups",
     info_of("ct"),
     3,
     {"functional groups"}},
    {"DicomHighBit", "input/dicom-highbit15", info_of("ct"), 3, {"HighBit: expected"}},
    {"DicomIodineMapBesideHu",
     "input/dicom-iodine-map-beside-hu",
     info_of("ct"),
     0,
     {"slices of MGML", "ct: series"},
     kPhantomHu},
    {"DicomPaletteColour",
     "input/dicom-palette-color",
     info_of("ct"),
     3,
     {"PhotometricInterpretation", "PALETTE COLOR"}},
    {"DicomRescaleTypeNotHu",
     "input/dicom-rescaletype-not-hu",
     info_of("ct"),
     0,
     {"RescaleType: MGML (expected HU)"}},
    {"DicomInterleavedAcquisitions",
     "input/dicom-two-acquisitions-interleaved",
     info_of("ct"),
     3,
     {"AcquisitionNumber 1, 2"}},
    {"DicomTwoFramesOfReference",
     "input/dicom-two-frames-of-reference",
     info_of("ct"),
     3,
     {"FrameOfReferenceUID"}},
    {"LandmarksWithByteOrderMark",
     "input/landmarks-bom",
     "register --landmarks @/points.csv",
     0,
     {},
     {"\"fre_rms_mm\": ", "e-05"}},
    {"MetaImageByteOrders",
     "input/mha-byte-order-contradiction",
     info_of("ct.mha"),
     3,
     {"ElementByteOrderMSB", "BinaryDataByteOrderMSB"}},
    {"MetaImageLettersOnly",
     "input/mha-letters-only",
     info_of("ct.mha"),
     3,
     {"AnatomicalOrientation RAS without TransformMatrix"}},
    {"MetaImageHeaderSizeMinusOne",
     "input/mha-local-headersize-minus1",
     info_of("ct.mha"),
     0,
     {},
     kPhantomHu},
    {"MetaImageRawLonger",
     "input/mhd-raw-longer-than-stated",
     info_of("ct.mhd"),
     0,
     {"12144 bytes stated against 12276 bytes found"}},
    {"NeedlePointsBackwards",
     "input/needle-points-backwards",
     input_replay("--needle-frame NeedleTip"),
     0,
     {"150 mm ahead of the tip"}},
    {"NiftiPixdimAgainstSForm",
     "input/nii-pixdim-contradicts-sform",
     info_of("ct.nii"),
     0,
     {"s-form 2 2.5 4 mm against pixdim 0.7 0.7 5 mm"}},
    {"NiftiSFormOfUnitSpacing",
     "input/nii-sform-of-unit-spacing",
     info_of("ct.nii"),
     3,
     {"spacing 1 1 1 by the s-form, 2 2.5 4 by pixdim"}},
    {"NrrdOldMinMax",
     "input/nrrd-old-min-max",
     info_of("ct.nrrd"),
     0,
     {"old min, old max: -1024 to 3071"}},
    {"PlusConfigAgainstFrames",
     "input/plus-config-ignored",
     input_replay("--config @/recalibrated.xml"),
     0,
     {"corners up to 3.86005 mm apart"},
     {"Image→Probe: ImageToProbe (frames)"}},
    {"PlusContradictingChain",
     "input/plus-contradicting-chain",
     input_replay(),
     3,
     {"ProbeToReference, which places it 20 mm away"}},
    {"PlusFrozenPicture",
     "input/plus-frozen-picture",
     input_replay(),
     0,
     {"the scanner is frozen or repeats images; used: these images, as degraded, and as stale"}},
    {"PlusFrozenPose",
     "input/plus-frozen-pose",
     input_replay(),
     0,
     {"pose: unchanged to the last digit", "used: these poses, as degraded"}},
    {"PlusIdentityCalibration",
     "input/plus-identity-calibration",
     input_replay(),
     0,
     {"ImageToProbe: the identity (is the probe calibrated?); used: as stated, as degraded"},
     {"is the probe calibrated?"}},
    {"PlusMetOther",
     "input/plus-met-other",
     info_of("poses.igs.mha"),
     0,
     {},
     {"frames: 8", "frames_without_image: 8", "ok: 8"}},
    {"PlusTimesInMilliseconds",
     "input/plus-timestamps-in-ms",
     input_replay(),
     0,
     {"images 100 s apart (are the stamps in milliseconds?)"}},
    {"ReferenceJump",
     "faults/reference_jump",
     small_replay("jump.igs.mha", "ct.mha", "--registration @/reg.json"),
     0,
     {"ReferenceToTracker at 100.300000 s: expected"},
     {"\"shown\": 11"}},
    {"ProbeJump",
     "faults/probe_jump_4400mm_s",
     small_replay("jump240.igs.mha", "ct.mha", "--registration @/reg.json"),
     0,
     {"ProbeToTracker at 100.250000 s: expected"},
     {"\"shown\": 11"}},
    {"SlicerPresetWithoutColours",
     "faults/vpjson_no_rgb",
     small_replay("u.igs.mha", "ct.mha", "--look @/t.vp.json"),
     3,
     {"t.vp.json: rgbTransferFunction: expected points, found none"}},
    {"SlicerPresetUnderAnotherName",
     "faults/vpjson_no_rgb",
     small_replay("u.igs.mha", "ct.mha", "--look @/x.vp.json"),
     3,
     {"x.vp.json: rgbTransferFunction: expected points, found none"}},
    {"DicomEmptySlices",
     "faults/dicom_empty_slices",
     info_of("dcm"),
     0,
     {"40 files that are not DICOM"}},
    {"RegistrationWithoutFrame",
     "faults/landmark_registration_in_tracker_frame",
     small_replay("ref_missing_all.igs.mha", "ct.mha", "--registration @/reg.json"),
     0,
     {"reference_frame: none (register with --reference-frame)", "as degraded"}},
    {"RawLongerCompressed",
     "faults/raw_longer",
     info_of("c.mha"),
     3,
     {"expected the compressed data to end with the last sample, found more"}},
    {"RawLongerByCarriageReturns",
     "faults/raw_longer",
     info_of("crlf_damaged.mha"),
     0,
     {"43904 bytes stated against 44344 bytes found"}},
    {"RawLongerThanTheHeader",
     "faults/raw_longer",
     info_of("shorter_header.mha"),
     0,
     {"4704 bytes stated against 43904 bytes found"}},
    {"StlInCapitals",
     "faults/stl_ascii_as_binary",
     "replay @/../seeds/u.igs.mha --ct @/../seeds/ct.mha --out # --cutaway-mesh @/upper.stl",
     3,
     {"upper.stl: expected ASCII STL in small letters (solid, facet, vertex), found SOLID"}},
    {"StlThatIsNoText",
     "faults/stl_ascii_as_binary",
     "replay @/../seeds/u.igs.mha --ct @/../seeds/ct.mha --out # --cutaway-mesh @/fuzz.stl",
     3,
     {"fuzz.stl: expected ASCII STL, found bytes that are no text"}}};

class SharedCasesTest : public CommandLineTest, public ::testing::WithParamInterface<SharedCase> {};

std::string with_folders(std::string text, const std::string& input, const std::string& output) {
  for (std::size_t at = 0; (at = text.find_first_of("@#", at)) != text.npos;) {
    const std::string& folder = text[at] == '@' ? input : output;
    text.replace(at, 1, folder);
    at += folder.size();
  }
  return text;
}

TEST_P(SharedCasesTest, HasTheRightAnswer) {
  const SharedCase& one = GetParam();
  SONDE_REQUIRE_DATA(folder, std::filesystem::path("..") / "cases" / one.folder);
  const auto out = folder_ / "out";
  const std::string command = with_folders(one.command, folder.string(), out.string());
  const Outcome outcome = sonde(command);
  if (one.code != 0) {
    expect_rejection(outcome, command, one.code, {one.said.at(0)});
  } else {
    ASSERT_EQ(outcome.code, 0) << command << "\n" << outcome.errors;
  }
  for (const std::string& piece : one.said) {
    EXPECT_NE(outcome.errors.find(piece), std::string::npos)
        << "expected '" << piece << "' in: " << outcome.errors;
  }
  const std::string report = outcome.output + text_of(out / "report.json");
  for (const std::string& piece : one.reported) {
    EXPECT_NE(report.find(piece), std::string::npos) << "expected '" << piece << "' in: " << report;
  }
  // A rejected run leaves no result behind.
  if (one.code != 0) {
    EXPECT_FALSE(std::filesystem::exists(out / "report.json"));
  }
}

INSTANTIATE_TEST_SUITE_P(All, SharedCasesTest, ::testing::ValuesIn(kCases),
                         [](const auto& made) { return made.param.name; });

}  // namespace
}  // namespace nav::app
