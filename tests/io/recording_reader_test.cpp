// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/recording_reader.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <iomanip>
#include <limits>
#include <map>

#include "io/sequence_writer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using frames::Ct;
using frames::Image;
using frames::Probe;
using frames::Tracker;

constexpr int kWidth = 4;
constexpr int kHeight = 3;
constexpr double kTextMm = 1e-9;  // The file has 17 digits.

struct Frame {
  std::map<std::string, std::string> fields;
};

std::string text_of(const Eigen::Matrix4d& m) {
  std::ostringstream text;
  text.precision(17);
  for (int i = 0; i < 16; ++i) text << (i > 0 ? " " : "") << m(i / 4, i % 4);
  return text.str();
}

Eigen::Matrix4d rigid(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& mm) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  m.topRightCorner<3, 1>() = mm;
  return m;
}

Eigen::Matrix4d probe_pose(int index) {
  return rigid(0.4 + 0.05 * index, {1, 2, 3}, {10.0 * index, 20, -1500});
}
Eigen::Matrix4d reference_pose(int index) {
  return rigid(-0.9, {0, 1, 1}, {5, -7.0 - index, -1400});
}
/// Calibration with pixels of 0.2 x 0.3 mm, a rotation and a translation.
Eigen::Matrix4d image_to_probe() {
  Eigen::Matrix4d m = rigid(1.1, {2, -1, 1}, {8, -30, 80});
  m.col(0) *= 0.2;
  m.col(1) *= 0.3;
  m.col(2) *= 0.25;
  return m;
}

/// Writes a raw MetaImage. A pixel has the value 10 * frame + its offset in the image.
std::filesystem::path write(const test::TemporaryFolder& folder, const std::vector<Frame>& frames) {
  const auto path = folder / "recording.igs.mha";
  std::ofstream out(path, std::ios::binary);
  out << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      << "CompressedData = False\nDimSize = " << kWidth << ' ' << kHeight << ' ' << frames.size()
      << "\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MF\n"
      << "UltrasoundImageType = BRIGHTNESS\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const auto& [key, value] : frames[i].fields) {
      out << "Seq_Frame" << std::setw(4) << std::setfill('0') << i << '_' << key << " = " << value
          << '\n';
    }
  }
  out << "ElementDataFile = LOCAL\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (int p = 0; p < kWidth * kHeight; ++p) {
      out.put(static_cast<char>(10 * static_cast<int>(i) + p));
    }
  }
  return path;
}

void put(Frame& frame, const std::string& name, const Eigen::Matrix4d& m,
         const std::string& status = "OK") {
  frame.fields[name + "Transform"] = text_of(m);
  if (!status.empty()) frame.fields[name + "TransformStatus"] = status;
}

std::vector<Frame> tracked_frames(int count) {
  std::vector<Frame> frames(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Frame& f = frames[static_cast<std::size_t>(i)];
    put(f, "ProbeToTracker", probe_pose(i));
    put(f, "ReferenceToTracker", reference_pose(i));
    f.fields["Timestamp"] = std::to_string(100 + i) + ".25";
    f.fields["ImageStatus"] = "OK";
  }
  return frames;
}

io::PlusConfig calibration_config() {
  io::PlusConfig config;
  config.transforms.push_back({.from = "Image", .to = "Probe", .to_from_from = image_to_probe()});
  return config;
}

std::vector<RecordingImage> drain(RecordingReader& session) {
  std::vector<RecordingImage> events;
  while (auto event = session.next()) events.push_back(std::move(*event));
  return events;
}

TEST(RecordingReaderTest, StreamsImagesAndPosesAsRecorded) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  const auto config = calibration_config();
  auto session = RecordingReader::open(write(folder, tracked_frames(3)), &config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  EXPECT_EQ(session->form(), RecordingForm::kTracked);
  EXPECT_EQ(session->total_images(), 3);
  ASSERT_TRUE(session->calibration().has_value());
  for (int round = 0; round < 2; ++round) {
    const auto events = drain(*session);
    ASSERT_EQ(events.size(), 3U);
    for (int i = 0; i < 3; ++i) {
      const RecordingImage& e = events[static_cast<std::size_t>(i)];
      ASSERT_TRUE(test::has_value(e.image));
      EXPECT_EQ(e.acquired, Timestamp(from_seconds(100.25 + i)));
      EXPECT_EQ(e.image->acquired, *e.acquired);
      EXPECT_EQ(e.image->pixels.at(1, 2), 10 * i + 2 * kWidth + 1);
      EXPECT_EQ(e.probe.status, TrackingStatus::kOk);
      EXPECT_EQ(e.probe.acquired, *e.acquired);
      EXPECT_LT((e.probe.tracker_from_body - probe_pose(i)).norm(), kTextMm);
      ASSERT_TRUE(e.reference.has_value());
      EXPECT_LT((e.reference->tracker_from_body - reference_pose(i)).norm(), kTextMm);
    }
    EXPECT_TRUE(test::rejects(session->next(), ErrorCode::kEndOfStream, {"recording.igs.mha"}));
    session->rewind();
  }
  EXPECT_TRUE(said.entries().empty());
}

/// Returns the position of a pixel of an event, in the target frame of the pose.
Eigen::Vector3d place(const RecordingReader& session, const RecordingImage& event, double column,
                      double row) {
  const auto pose = rigid_from_matrix<Tracker, Probe>(event.probe.tracker_from_body);
  EXPECT_TRUE(test::has_value(pose));
  const auto& calibration = *session.calibration();
  return (*pose * calibration.probe_from_image * event.image->grid.at(column, row)).mm;
}

Eigen::Vector3d place(const Eigen::Matrix4d& to_from_pixels, double column, double row) {
  return (to_from_pixels * Eigen::Vector4d(column, row, 0, 1)).head<3>();
}

TEST(RecordingReaderTest, AllThreeFormsPositionAPixelEqually) {
  const Eigen::Matrix4d in_reference =
      reference_pose(1).inverse() * probe_pose(1) * image_to_probe();
  std::vector<Frame> probe_frames = tracked_frames(2);
  std::vector<Frame> image_frames = tracked_frames(2);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Matrix4d m = reference_pose(i).inverse() * probe_pose(i);
    for (auto* frames : {&probe_frames, &image_frames}) {
      auto& fields = (*frames)[static_cast<std::size_t>(i)].fields;
      std::erase_if(fields, [](const auto& f) { return f.first.find("Tracker") < 30; });
    }
    put(probe_frames[static_cast<std::size_t>(i)], "ProbeToReference", m);
    put(image_frames[static_cast<std::size_t>(i)], "ImageToReference", m * image_to_probe());
  }
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  const auto config = calibration_config();
  const auto check = [&](const std::vector<Frame>& frames, const io::PlusConfig* calibration,
                         RecordingForm form) {
    auto session = RecordingReader::open(write(folder, frames), calibration, {}, said);
    ASSERT_TRUE(test::has_value(session));
    EXPECT_EQ(session->form(), form);
    const auto events = drain(*session);
    EXPECT_FALSE(events[1].reference.has_value());
    for (const auto& [column, row] : {std::pair{0.0, 0.0}, {3.0, 0.0}, {1.0, 2.0}}) {
      EXPECT_LT((place(*session, events[1], column, row) - place(in_reference, column, row)).norm(),
                1e-6);
    }
  };
  check(probe_frames, &config, RecordingForm::kProbeInReference);
  check(image_frames, nullptr, RecordingForm::kImageInReference);
}

TEST(RecordingReaderTest, ReplaysWithoutAReferenceOnlyIfRequested) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = tracked_frames(2);
  for (Frame& f : frames) f.fields.erase("ReferenceToTrackerTransform");
  const auto path = write(folder, frames);
  const auto config = calibration_config();
  EXPECT_TRUE(test::rejects(RecordingReader::open(path, &config, {}, said), ErrorCode::kNotFound,
                            {"Reference", "Tracker", "name the tracker frame"}));
  RecordingOptions options;
  options.reference_frame = "Tracker";
  auto session = RecordingReader::open(path, &config, options, said);
  ASSERT_TRUE(test::has_value(session));
  const auto event = session->next();
  ASSERT_TRUE(test::has_value(event));
  EXPECT_FALSE(event->reference.has_value());
  EXPECT_LT((event->probe.tracker_from_body - probe_pose(0)).norm(), kTextMm);
}

TEST(RecordingReaderTest, KeepsTheStatusOfLostPosesAndNamesUnreadableOnes) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = tracked_frames(5);
  frames[0].fields["ProbeToTrackerTransform"] =
      "nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan";
  frames[0].fields["ProbeToTrackerTransformStatus"] = "OUT_OF_VIEW";
  frames[1].fields.erase("ProbeToTrackerTransformStatus");
  frames[2].fields["ProbeToTrackerTransform"] = "1 2 3";
  frames[3].fields.erase("Timestamp");
  frames[4].fields["ImageStatus"] = "INVALID";
  const auto config = calibration_config();
  auto session = RecordingReader::open(write(folder, frames), &config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  const auto events = drain(*session);
  ASSERT_EQ(events.size(), 5U);
  EXPECT_EQ(events[0].probe.status, TrackingStatus::kOccluded);
  EXPECT_TRUE(events[0].probe.tracker_from_body.hasNaN());
  EXPECT_EQ(events[0].reference->status, TrackingStatus::kOk);
  EXPECT_EQ(events[1].probe.status, TrackingStatus::kUnknown);  // An unknown status never becomes
                                                                // kOk.
  EXPECT_EQ(events[2].probe.status, TrackingStatus::kInvalid);
  EXPECT_TRUE(events[2].probe.tracker_from_body.array().isNaN().all());
  EXPECT_FALSE(events[3].acquired.has_value());
  EXPECT_TRUE(test::rejects(events[3].image, ErrorCode::kMalformedData, {"frame 3", "Timestamp"}));
  EXPECT_EQ(events[3].probe.status, TrackingStatus::kInvalid);
  EXPECT_TRUE(test::rejects(events[4].image, ErrorCode::kUnsupportedData, {"frame 4"}));
  EXPECT_EQ(events[4].probe.status, TrackingStatus::kOk);
  ASSERT_EQ(said.entries().size(), 1U);
  EXPECT_NE(said.entries()[0].message.find("frame 2: ProbeToTracker"), std::string::npos);
}

TEST(RecordingReaderTest, FindsANeedleThatAppearsLateInTheRecording) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = tracked_frames(101);
  put(frames.back(), "NeedleToTracker", probe_pose(7));
  const auto config = calibration_config();
  RecordingOptions options;
  options.needle_frame = "Needle";
  auto session = RecordingReader::open(write(folder, frames), &config, options, said);
  ASSERT_TRUE(test::has_value(session));
  const auto events = drain(*session);
  ASSERT_EQ(events.size(), 101U);
  ASSERT_TRUE(events.back().needle.has_value());
  EXPECT_LT((events.back().needle->tracker_from_body - probe_pose(7)).norm(), kTextMm);
  EXPECT_NE(events.front().needle->status, TrackingStatus::kOk);
}

std::vector<Frame> frames_with_calibration(int count) {
  auto frames = tracked_frames(count);
  for (Frame& f : frames) put(f, "ImageToProbe", image_to_probe());
  return frames;
}

TEST(RecordingReaderTest, AFrameWithoutAValidCalibrationHasNoImage) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = frames_with_calibration(6);
  put(frames[0], "ImageToProbe", image_to_probe(), "INVALID");
  frames[2].fields["ImageToProbeTransform"] = "nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  Eigen::Matrix4d sheared = image_to_probe();
  sheared.col(1) += sheared.col(0);
  put(frames[3], "ImageToProbe", sheared);
  frames[4].fields.erase("ImageToProbeTransform");
  const auto config = calibration_config();
  auto session = RecordingReader::open(write(folder, frames), &config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  const auto events = drain(*session);
  ASSERT_EQ(events.size(), 6U);
  EXPECT_TRUE(test::rejects(events[0].image, ErrorCode::kUnsupportedData,
                            {"frame 0: ImageToProbe", "invalid"}));
  EXPECT_TRUE(test::has_value(events[1].image));
  EXPECT_TRUE(test::rejects(events[2].image, ErrorCode::kMalformedData,
                            {"frame 2: ImageToProbe", "finite", "nan"}));
  EXPECT_TRUE(test::rejects(events[3].image, ErrorCode::kMalformedData, {"frame 3: ImageToProbe"}));
  EXPECT_TRUE(test::rejects(events[4].image, ErrorCode::kMalformedData, {"frame 4: ImageToProbe"}));
  ASSERT_TRUE(test::has_value(events[5].image));
  const Eigen::Matrix4d truth = probe_pose(5) * image_to_probe();
  EXPECT_LT((place(*session, events[5], 3, 2) - place(truth, 3, 2)).norm(), 1e-6);
}

TEST(RecordingReaderTest, AFrameWithAnotherCalibrationHasNoImageAndNamesBoth) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = frames_with_calibration(5);
  const auto read = [&](const Eigen::Matrix4d& other) {
    for (const std::size_t i : {2U, 3U}) put(frames[i], "ImageToProbe", other);
    auto session = RecordingReader::open(write(folder, frames), nullptr, {}, said);
    EXPECT_TRUE(test::has_value(session));
    return session ? drain(*session) : std::vector<RecordingImage>();
  };
  Eigen::Matrix4d larger = image_to_probe();
  larger.leftCols<2>() *= 1.5;
  for (const Eigen::Matrix4d& other :
       {Eigen::Matrix4d(rigid(0, {0, 0, 1}, {0, 0.1, 0}) * image_to_probe()),
        Eigen::Matrix4d(rigid(0.5, {1, 0, 0}, {0, 0, 0}) * image_to_probe()), larger}) {
    const auto events = read(other);
    ASSERT_EQ(events.size(), 5U);
    for (const std::size_t i : {0U, 1U, 4U}) EXPECT_TRUE(test::has_value(events[i].image)) << i;
    for (const std::size_t i : {2U, 3U}) {
      EXPECT_TRUE(test::rejects(events[i].image, ErrorCode::kMalformedData,
                                {"frame 2: ImageToProbe", "the calibration of frame 0",
                                 "at (8 -30 80)", "found one with corners", "mm away"}));
      EXPECT_EQ(events[i].probe.status, TrackingStatus::kOk) << "its pose is as good as any";
    }
  }
  EXPECT_TRUE(test::rejects(read(rigid(0, {0, 0, 1}, {0, 0.1, 0}) * image_to_probe())[2].image,
                            ErrorCode::kMalformedData,
                            {"at (8 -29.9 80)", "0.1 mm away at a corner"}));
  // A calibration that is rounded like decimal text counts as equal.
  for (const RecordingImage& event :
       read((image_to_probe() * 1e5).array().round().matrix() / 1e5)) {
    EXPECT_TRUE(test::has_value(event.image)) << event.index;
  }
}

TEST(RecordingReaderTest, PixelsOfAnotherSizeInPosesOfImagesNameBothSizes) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  auto frames = tracked_frames(3);
  for (int i = 0; i < 3; ++i) {
    Frame& f = frames[static_cast<std::size_t>(i)];
    std::erase_if(f.fields, [](const auto& field) {
      return field.first.find("ToTracker") != std::string::npos;
    });
    Eigen::Matrix4d pose = reference_pose(i).inverse() * probe_pose(i) * image_to_probe();
    if (i == 2) pose.col(1) *= 1.5;
    put(f, "ImageToReference", pose);
  }
  auto session = RecordingReader::open(write(folder, frames), nullptr, {}, said);
  ASSERT_TRUE(test::has_value(session));
  const auto events = drain(*session);
  ASSERT_EQ(events.size(), 3U);
  EXPECT_EQ(events[1].probe.status, TrackingStatus::kOk);
  EXPECT_EQ(events[2].probe.status, TrackingStatus::kInvalid);
  ASSERT_EQ(said.entries().size(), 1U);
  EXPECT_EQ(said.entries()[0].message,
            "frame 2: expected the pixel size of frame 0, 0.2 x 0.3 mm, found 0.2 x 0.45 mm");
}

TEST(RecordingReaderTest, RejectsRecordingsWithoutAPathOfTransforms) {
  const test::TemporaryFolder folder;
  CollectingDiagnostics said;
  const auto config = calibration_config();
  RecordingOptions options;
  options.probe_frame = "Transducer";
  options.image_frame = "Picture";
  const auto path = write(folder, tracked_frames(2));
  EXPECT_TRUE(test::rejects(RecordingReader::open(path, &config, options, said),
                            ErrorCode::kNotFound,
                            {"recording.igs.mha", "Transducer", "Probe→Tracker"}));
  EXPECT_TRUE(test::rejects(RecordingReader::open(path, nullptr, {}, said), ErrorCode::kNotFound,
                            {"Image", "Probe"}));
  EXPECT_FALSE(RecordingReader::open(folder / "absent.mha", nullptr, {}, said));
}

TEST(RecordingReaderTest, ReplaysARealRecording) {
  SONDE_REQUIRE_DATA(path, "plus-sequences/sequences/NwirePhantomFreehand.igs.mha");
  SONDE_REQUIRE_DATA(xml,
                     "plus-sequences/config/"
                     "PlusDeviceSet_NwirePhantomFreehand_vtkVolumeReconstructorTest2.xml");
  const auto config = io::read_plus_config(xml);
  ASSERT_TRUE(test::has_value(config));
  CollectingDiagnostics said;
  auto session = RecordingReader::open(path, &*config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  EXPECT_EQ(session->total_images(), 97);
  const auto events = drain(*session);
  ASSERT_EQ(events.size(), 97U);
  for (const RecordingImage& e : events) {
    ASSERT_TRUE(test::has_value(e.image));
    EXPECT_EQ(e.image->pixels.width(), 820);
    ASSERT_TRUE(e.acquired.has_value());
    ASSERT_TRUE(e.reference.has_value());
  }
  // An image of 820 columns of a scanner covers some centimetres.
  EXPECT_LT(*events.front().acquired, *events.back().acquired);
  const double spacing_mm = session->calibration()->grid.mm_per_pixel.col(0).norm();
  EXPECT_GT(spacing_mm, 0.05);
  EXPECT_LT(spacing_mm, 0.5);
}

TEST(RecordingReaderTest, NamesTwoCalibrationsThatDiffer) {
  const test::TemporaryFolder folder;
  auto frames = tracked_frames(2);
  for (Frame& frame : frames) put(frame, "ImageToProbe", image_to_probe());
  auto config = calibration_config();
  config.path = "plus.xml";
  CollectingDiagnostics same;
  ASSERT_TRUE(test::has_value(RecordingReader::open(write(folder, frames), &config, {}, same)));
  EXPECT_TRUE(same.entries().empty());
  config.transforms[0].to_from_from(0, 3) += 2;
  CollectingDiagnostics said;
  ASSERT_TRUE(test::has_value(RecordingReader::open(write(folder, frames), &config, {}, said)));
  ASSERT_EQ(said.entries().size(), 1U);
  EXPECT_NE(said.entries()[0].message.find("2 mm apart"), std::string::npos)
      << said.entries()[0].message;
}

TEST(RecordingReaderTest, WarnsOfCalibrationsThatNoProbeHas) {
  const auto warning = [](const Eigen::Matrix4d& image_to_probe) {
    const test::TemporaryFolder folder;
    io::PlusConfig config;
    config.transforms.push_back({.from = "Image", .to = "Probe", .to_from_from = image_to_probe});
    CollectingDiagnostics said;
    EXPECT_TRUE(test::has_value(
        RecordingReader::open(write(folder, tracked_frames(2)), &config, {}, said)));
    return said.entries().empty() ? std::string() : said.entries()[0].message;
  };
  EXPECT_EQ(warning(image_to_probe()), "");
  EXPECT_NE(warning(Eigen::Matrix4d::Identity()).find("the identity"), std::string::npos);
  Eigen::Matrix4d metres = image_to_probe();
  metres.topRows<3>() *= 1e-3;
  EXPECT_NE(warning(metres).find("in metres?"), std::string::npos) << warning(metres);
  const auto changed = [](double wide, double high, double shear) {
    Eigen::Matrix4d change = Eigen::Matrix4d::Identity();
    change(0, 0) = wide;
    change(1, 1) = high;
    change(0, 1) = shear;
    return Eigen::Matrix4d(image_to_probe() * change);
  };
  EXPECT_NE(warning(changed(100, 100, 0)).find("larger than"), std::string::npos);
  EXPECT_NE(warning(changed(1, 8, 0)).find("square"), std::string::npos);
  EXPECT_NE(warning(changed(1, 1, 0.3)).find("right angle"), std::string::npos);
  EXPECT_EQ(warning(changed(1, 1, 0.05)), "") << "real calibrations shear";
}

TEST(RecordingReaderTest, ReportsFramesThatContradictThemselves) {
  const test::TemporaryFolder folder;
  auto frames = tracked_frames(3);
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix4d direct = reference_pose(i).inverse() * probe_pose(i);
    if (i == 1) direct(0, 3) += 20;
    put(frames[static_cast<std::size_t>(i)], "ProbeToReference", direct);
  }
  CollectingDiagnostics said;
  const auto config = calibration_config();
  auto session = RecordingReader::open(write(folder, frames), &config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  EXPECT_EQ(drain(*session).size(), 3U);
  ASSERT_EQ(said.entries().size(), 1U);
  ASSERT_TRUE(said.entries()[0].finding.has_value());
  const Finding finding = *said.entries()[0].finding;
  EXPECT_EQ(finding.key, "position of Probe in Reference");
  EXPECT_EQ(finding.values,
            (std::vector<std::string>{"ProbeToTracker and ReferenceToTracker",
                                      "ProbeToReference, which places it 20 mm away in frame 1"}));
  EXPECT_EQ(finding.used, "ProbeToTracker and ReferenceToTracker");
}

TEST(RecordingReaderTest, WarnsOfANeedleThatPointsBackwards) {
  const test::TemporaryFolder folder;
  auto frames = tracked_frames(2);
  for (Frame& frame : frames) put(frame, "NeedleToTracker", probe_pose(0));
  const auto config = calibration_config();
  const auto warnings = [&](const Eigen::Matrix4d& body_from_tip) {
    for (Frame& frame : frames) put(frame, "NeedleTipToNeedle", body_from_tip);
    CollectingDiagnostics said;
    EXPECT_TRUE(test::has_value(RecordingReader::open(write(folder, frames), &config,
                                                      {.needle_frame = "NeedleTip"}, said)));
    return said.entries().size();
  };
  const Eigen::Matrix4d forwards = rigid(0.1, {0, 0, 1}, {0, 0, 150});
  EXPECT_EQ(warnings(forwards), 0U);
  EXPECT_EQ(warnings(forwards * rigid(M_PI, {1, 0, 0}, {0, 0, 0})), 1U);
}

TEST(RecordingReaderTest, ReportsEveryLoopOfTransformsThatDoesNotClose) {
  const test::TemporaryFolder folder;
  auto frames = tracked_frames(3);
  for (int i = 0; i < 3; ++i) {
    Frame& frame = frames[static_cast<std::size_t>(i)];
    Eigen::Matrix4d image = reference_pose(i).inverse() * probe_pose(i) * image_to_probe();
    // Half a pixel is no contradiction; pixels of another size are, far from the first one.
    image(0, 3) += 0.1;
    if (i == 2) image.leftCols<2>() *= 3;
    put(frame, "ImageToReference", image);
    put(frame, "StylusToTracker", rigid(0.1, {0, 0, 1}, {1, 2, 3}));
    put(frame, "StylusToReference", rigid(0.1, {0, 0, 1}, {1, 2, 3}));
  }
  CollectingDiagnostics said;
  const auto config = calibration_config();
  auto session = RecordingReader::open(write(folder, frames), &config, {}, said);
  ASSERT_TRUE(test::has_value(session));
  drain(*session);
  ASSERT_EQ(said.entries().size(), 2U);
  for (const auto& entry : said.entries()) {
    ASSERT_TRUE(entry.finding.has_value());
    if (entry.finding->key == "position of Stylus in Reference" ||
        entry.finding->key == "position of Stylus in Tracker") {
      EXPECT_EQ(entry.severity, Severity::kWarning) << "the reference is used";
      EXPECT_EQ(entry.count, 3U);
      continue;
    }
    EXPECT_EQ(entry.finding->key, "position of Image in Reference");
    EXPECT_EQ(entry.count, 1U);
    EXPECT_NE(entry.finding->values.at(1).find("ImageToReference, which places it "),
              std::string::npos);
    EXPECT_EQ(entry.finding->used, "ImageToProbe, ProbeToTracker and ReferenceToTracker");
    EXPECT_NE(entry.finding->values.at(1).find("in frame 2"), std::string::npos);
  }
}

TEST(RecordingReaderTest, ReportsATipThatMovesOnItsNeedleOrIsInMetres) {
  const test::TemporaryFolder folder;
  const auto said_of = [&](double tip_mm, double later_mm) {
    auto frames = tracked_frames(4);
    for (int i = 0; i < 4; ++i) {
      put(frames[static_cast<std::size_t>(i)], "NeedleToTracker", probe_pose(i + 3));
      put(frames[static_cast<std::size_t>(i)], "NeedleTipToNeedle",
          rigid(0, {0, 0, 1}, {0, 0, i < 2 ? tip_mm : later_mm}));
    }
    CollectingDiagnostics said;
    const auto config = calibration_config();
    RecordingOptions options;
    options.needle_frame = "NeedleTip";
    auto session = RecordingReader::open(write(folder, frames), &config, options, said);
    EXPECT_TRUE(test::has_value(session));
    if (session) drain(*session);
    return said.entries();
  };
  EXPECT_TRUE(said_of(150, 150.05).empty());
  const auto moved = said_of(150, 153);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].finding->key, "position of NeedleTip on Needle");
  EXPECT_EQ(moved[0].finding->values,
            (std::vector<std::string>{"that of frame 0", "another in frame 2, 3 mm away"}));
  EXPECT_EQ(moved[0].count, 2U);
  const auto metres = said_of(0.15, 0.15);
  ASSERT_EQ(metres.size(), 1U);
  EXPECT_EQ(metres[0].finding->key, "unit of NeedleTip on Needle");
  EXPECT_NE(metres[0].finding->values.at(0).find("in metres?"), std::string::npos);
}

TEST(RecordingReaderTest, SaysOnceHowSixteenBitsBecomeEightAndDoesNotFlicker) {
  const test::TemporaryFolder folder;
  const auto path = folder / "deep.igs.mha";
  SequenceHeader header;
  header.width = 2;
  header.height = 1;
  header.pixel_type = PixelType::kUint16;
  auto writer = SequenceWriter::create(path, header);
  ASSERT_TRUE(test::has_value(writer));
  const std::vector<std::array<std::uint16_t, 2>> images = {
      {0, 0}, {2000, 1000}, {100, 1000}, {4000, 1000}, {2047, 1000}};
  for (std::size_t i = 0; i < images.size(); ++i) {
    SequenceImage frame;
    frame.timestamp_s = 0.1 * static_cast<double>(i);
    frame.image_valid = true;
    frame.pixels.resize(sizeof images[i]);
    std::memcpy(frame.pixels.data(), images[i].data(), sizeof images[i]);
    set_transform(frame, {"ImageToProbe", image_to_probe(), TrackingStatus::kOk});
    set_transform(frame, {"ProbeToTracker", probe_pose(0), TrackingStatus::kOk});
    ASSERT_TRUE(test::has_value(writer->append(frame)));
  }
  ASSERT_TRUE(test::has_value(writer->finish()));
  CollectingDiagnostics said;
  RecordingOptions options;
  options.reference_frame.clear();
  auto reader = RecordingReader::open(path, nullptr, options, said);
  ASSERT_TRUE(test::has_value(reader));
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<int> second;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto next = reader->next();
      ASSERT_TRUE(test::has_value(next));
      ASSERT_TRUE(test::has_value(next->image));
      second.push_back(next->image->pixels.at(1, 0));
    }
    EXPECT_EQ(second, (std::vector<int>{0, 125, 125, 125, 125})) << pass;
    reader->rewind();
  }
  const auto entries = said.entries();
  ASSERT_EQ(entries.size(), 2U);
  ASSERT_TRUE(entries[0].finding);
  EXPECT_EQ(entries[0].finding->values, std::vector<std::string>{"up to 2000 in frame 1"});
  EXPECT_EQ(entries[0].finding->used, "0 to 2047 as 0 to 255, in all images");
  EXPECT_NE(entries[1].message.find("up to 2047, found 4000"), std::string::npos)
      << entries[1].message;
  EXPECT_EQ(entries[0].count + entries[1].count, 2U);
}

}  // namespace
}  // namespace nav::io
