// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the whole program with real recordings and real CTs.
#include <cctype>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <ostream>

#include "app/report.hpp"
#include "app/verbs/replay.hpp"
#include "io/ct.hpp"
#include "io/sequence.hpp"
#include "session/recorded_session.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

struct Recording {
  const char* file;
  const char* config;
  int frames;
  const char* tracker = "Tracker";
};

void PrintTo(const Recording& recording, std::ostream* out) { *out << recording.file; }

class RecordingTest : public ::testing::TestWithParam<Recording> {};

TEST_P(RecordingTest, EveryImageIsPairedAndShown) {
  const Recording& recording = GetParam();
  SONDE_REQUIRE_DATA(sequences, std::filesystem::path("plus-sequences/sequences"));
  SONDE_REQUIRE_DATA(ct, std::filesystem::path("ct-abdomen-totalseg/example_ct.nii.gz"));
  const test::TemporaryFolder folder;
  SessionConfig config;
  config.source.recording = sequences / recording.file;
  config.source.plus_config = sequences / "../config" / recording.config;
  config.source.tracker_frame = recording.tracker;
  config.ct.path = ct;
  config.output.folder = folder / "out";
  config.output.width = 64;
  config.output.height = 48;
  config.output.step_voxels = 2;
  Console console(false);
  ASSERT_TRUE(test::has_value(run_replay(config, std::nullopt, console)));
  std::ifstream file(folder / "out/report.json");
  const io::Json report = io::Json::parse(file, nullptr, false);
  EXPECT_EQ(report["ledger"]["received"], recording.frames);
  EXPECT_EQ(report["ledger"]["shown"], recording.frames);
  EXPECT_TRUE(report["ledger"]["balanced"]);
  EXPECT_EQ(report["placement"]["kind"], "centred");
}

INSTANTIATE_TEST_SUITE_P(
    PlusSequences, RecordingTest,
    ::testing::Values(
        Recording{"SpinePhantomFreehand.igs.mha",
                  "PlusDeviceSet_VolumeReconstructionOnly_SpinePhantom_NN_MEAN.xml", 21},
        Recording{"BoneUltrasound_L14.igs.mha", "BoneUltrasound_L14_config.xml", 21},
        Recording{"NwirePhantomFreehand.igs.mha",
                  "PlusDeviceSet_NwirePhantomFreehand_vtkVolumeReconstructorTest2.xml", 97},
        Recording{"fCal_Test_Calibration_3NWires.igs.mha",
                  "PlusDeviceSet_fCal_Sim_VolumeReconstruction.xml", 188},
        Recording{"fCal_Test_Validation_3NWires.igs.mha",
                  "PlusDeviceSet_fCal_Sim_VolumeReconstruction.xml", 94},
        Recording{"USTC_3NWires_ProbeTranslation.igs.mha", "BoneUltrasound_L14_config.xml", 159,
                  "StepperHome"}),
    [](const auto& parameter) {
      std::string name = parameter.param.file;
      name.resize(name.find('.'));
      for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
      return name;
    });

/// PLUS reconstructed the spine phantom from this recording with this calibration (nearest
/// neighbour). The images, positioned by our chain of transforms, must agree with that independent
/// volume.
TEST(RecordingTest, ImagesAgreeWithTheReconstructionOfPlus) {
  SONDE_REQUIRE_DATA(sequences, std::filesystem::path("plus-sequences/sequences"));
  SONDE_REQUIRE_DATA(baseline,
                     std::filesystem::path(
                         "plus-sequences/baselines/vtkVolumeReconstructorTestNNMEANvolumeRef.mha"));
  CollectingDiagnostics diagnostics;
  const auto volume = io::read_ct(baseline, diagnostics);
  ASSERT_TRUE(test::has_value(volume));
  SessionConfig config;
  config.source.recording = sequences / "SpinePhantomFreehand.igs.mha";
  config.source.plus_config =
      sequences / "../config/PlusDeviceSet_VolumeReconstructionOnly_SpinePhantom_NN_MEAN.xml";
  auto session = session::RecordedSession::open(config.source, diagnostics);
  ASSERT_TRUE(test::has_value(session));
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
  std::size_t count = 0;
  const VoxelGrid& grid = volume->grid();
  for (;;) {
    const auto more = session->step([&](const tracking::PairedImage& paired) {
      ASSERT_TRUE(paired.tracked) << paired.cause;
      const auto& frame = paired.tracked->frame;
      for (int row = 40; row < 560; row += 7) {
        for (int column = 250; column < 600; column += 7) {
          const auto p = paired.tracked->reference_from_image * frame.grid.at(column, row);
          // The axes of the baseline are those of Reference. Its header says RAI, which is LPS in
          // DICOM.
          const Eigen::Vector3d index = grid.index_of({p.mm});
          const Eigen::Vector3i nearest = index.array().round().cast<int>();
          bool inside = true;
          for (int axis = 0; axis < 3; ++axis) {
            inside = inside && nearest[axis] >= 0 &&
                     nearest[axis] < grid.size[static_cast<std::size_t>(axis)];
          }
          if (!inside) continue;
          const double a = volume->at(nearest.x(), nearest.y(), nearest.z());
          if (a <= 0) continue;  // The sweep did not reach this voxel.
          const double b = frame.pixels.at(column, row);
          sum_a += a;
          sum_b += b;
          sum_aa += a * a;
          sum_bb += b * b;
          sum_ab += a * b;
          ++count;
        }
      }
    });
    ASSERT_TRUE(test::has_value(more));
    if (!*more) break;
  }
  ASSERT_GT(count, 5000u);
  const auto n = static_cast<double>(count);
  const double correlation = (sum_ab - sum_a * sum_b / n) /
                             std::sqrt((sum_aa - sum_a * sum_a / n) * (sum_bb - sum_b * sum_b / n));
  // Voxels of 0.5 mm average several speckle pixels of 0.08 mm. A shift of 2 mm would reduce the
  // correlation below 0.8.
  EXPECT_GT(correlation, 0.9) << count << " samples";
}

TEST(RecordingTest, RadioFrequencyDataAreRejectedByName) {
  SONDE_REQUIRE_DATA(file,
                     std::filesystem::path("plus-sequences/sequences/BkCurvilinearRfData.igs.mhd"));
  auto reader = io::SequenceReader::open(file);
  ASSERT_TRUE(test::has_value(reader));
  const auto frame = reader->read(0);
  ASSERT_TRUE(test::has_value(frame));
  EXPECT_TRUE(test::rejects(io::brightness_image(reader->header(), *frame),
                            ErrorCode::kUnsupportedData, {"RF_IQ_LINE"}));
}

}  // namespace
}  // namespace nav::app
