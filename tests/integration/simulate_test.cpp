// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/simulate.hpp"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <sstream>

#include "app/options/command_line.hpp"
#include "app/verbs/replay.hpp"
#include "io/ct.hpp"
#include "io/json_member.hpp"
#include "session/placement.hpp"
#include "session/recorded_session.hpp"
#include "sim/anatomy/ct_patient.hpp"
#include "sim/fault_plan.hpp"
#include "sim/motion/needle_bending.hpp"
#include "tests/integration/truth_file.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Reads what 'sonde simulate' writes with the parts of 'sonde replay' and 'sonde register'.
namespace nav::app {
namespace {

template <class To, class From>
Transform<To, From> transform_of(const io::Json& numbers) {
  return *rigid_from_matrix<To, From>(matrix_of(numbers));
}

SimulateOptions small(const test::TemporaryFolder& folder) {
  SimulateOptions options;
  options.out = folder / "sweep.igs.mha";
  options.columns = 100;
  options.rows = 70;
  options.duration_s = 1.5;
  options.frame_rate_hz = 8;
  return options;
}

io::Json truth_file(const SimulateOptions& options) {
  return read_json(std::filesystem::path(options.out).replace_extension(".truth.json"));
}

SessionConfig config_of(const SimulateOptions& options) {
  SessionConfig config;
  config.source.recording = options.out;
  return config;
}

std::vector<TrackedImage> replayed(const SimulateOptions& options, Console& console) {
  std::vector<TrackedImage> frames;
  auto session = session::RecordedSession::open(config_of(options).source, console);
  EXPECT_TRUE(session.has_value()) << session.error().message;
  const auto played = session->play([&](const tracking::PairedImage& paired) {
    if (paired.tracked) frames.push_back(*paired.tracked);
  });
  EXPECT_TRUE(played.has_value());
  session->navigator().finish();
  EXPECT_TRUE(session->navigator().ledger().balanced());
  return frames;
}

TEST(SimulateTest, AReplayedRecordingAgreesWithTheTruth) {
  const test::TemporaryFolder folder;
  Console console(false);
  for (const char* ending : {".igs.mha", ".nrrd"}) {
    SimulateOptions options = small(folder);
    options.out = folder / (std::string("sweep") + ending);
    options.tracker = "ideal";
    options.breathing = "smooth";
    options.compress = true;
    const auto written = run_simulate(options, console);
    ASSERT_TRUE(written) << written.error().message;
    const io::Json truth = truth_file(options);
    const auto frames = replayed(options, console);
    ASSERT_EQ(frames.size(), truth.at("frames").size());
    ASSERT_EQ(frames.size(), 13u);
    const auto ct_from_reference =
        transform_of<frames::Ct, frames::Reference>(truth.at("ct_from_reference_mm"));
    const Eigen::Matrix4d image_from_pixels = matrix_of(truth.at("image_from_pixels_mm"));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto expected =
          transform_of<frames::Ct, frames::Image>(truth.at("frames")[i].at("ct_from_image_mm"));
      // Poses come every 20 ms. Their interpolation misses part of the tremor (0.08 mm at 8 to 12
      // Hz). The Image frame of the recording has another origin in the plane, so positions of
      // pixels are compared.
      for (const double column : {0.0, 99.0}) {
        for (const double row : {0.0, 69.0}) {
          const Eigen::Vector4d pixel(column, row, 0, 1);
          const Point<frames::Image> image{(image_from_pixels * pixel).head<3>()};
          const auto replayed_ct = ct_from_reference * (frames[i].reference_from_image *
                                                        frames[i].frame.grid.at(column, row));
          EXPECT_LE((replayed_ct.mm - (expected * image).mm).norm(), 0.5);
        }
      }
      EXPECT_GT(truth.at("frames")[i].at("depth").get<double>(), -1e-12);
    }
    EXPECT_GE(truth.at("targets_ct_mm").size(), 100u);
  }
}

/// Patient whose sweep and CT are in a folder.
struct Recorded {
  using Pose = Transform<frames::Ct, frames::Reference>;
  SimulateOptions options;
  io::Json truth;
  /// \p patient_ct: a recorded CT. If it is empty, the CT of a simulated patient is written.
  Recorded(const test::TemporaryFolder& folder, std::uint64_t seed, const std::string& path,
           const std::filesystem::path& patient_ct = {}, double image_offset_ms = 0,
           const std::string& needle = "none") {
    const std::string name = std::to_string(seed);
    options.out = folder / (name + ".igs.mha");
    options.patient_ct = patient_ct;
    if (patient_ct.empty()) options.ct = folder / (name + ".ct.mha");
    options.seed = seed;
    options.path = path;
    options.duration_s = 3;
    options.ct_spacing_mm = 2;
    options.image_offset_ms = image_offset_ms;
    options.needle = needle;
    options.layered_speed = true;
    Console console(false);
    const auto written = run_simulate(options, console);
    EXPECT_TRUE(written) << written.error().message;
    truth = truth_file(options);
  }
  /// \p made: options of a recording that exists.
  explicit Recorded(const SimulateOptions& made) : options(made), truth(truth_file(made)) {}
  [[nodiscard]] Pose ct_from_reference() const {
    return transform_of<frames::Ct, frames::Reference>(truth.at("ct_from_reference_mm"));
  }
};

/// Returns the report of 'sonde register', whether it accepts or rejects.
io::Json registered(const Recorded& sweep, const std::filesystem::path& ct,
                    const std::optional<Recorded::Pose>& start, const std::filesystem::path& report,
                    const RegisterOptions& options = {}, double temporal_offset_ms = 0,
                    const std::string& needle_frame = "") {
  SessionConfig config;
  config.source.needle_frame = needle_frame;
  config.source.recording = sweep.options.out;
  config.source.temporal_offset_ms = temporal_offset_ms;
  config.ct.path = ct;
  if (start) config.placement.ct_from_reference = start->matrix();
  Console console(false);
  const auto done = run_register(config, options, report.string(), console);
  EXPECT_TRUE(done || done.error().code == ErrorCode::kRefused) << done.error().message;
  io::Json json = read_json(report);
  EXPECT_EQ(json.at("registration").at("accepted"), done.has_value());
  return json;
}

/// Returns the pose of a registration. Its key says whether the pose was accepted or rejected.
const io::Json& pose_of(const io::Json& registration) {
  const bool accepted = registration.at("accepted").get<bool>();
  EXPECT_NE(registration.contains(session::kAcceptedPose),
            registration.contains(session::kRefusedPose));
  return registration.at(accepted ? session::kAcceptedPose : session::kRefusedPose);
}

/// RMS error over the targets of the truth file, mm.
double target_error_mm(const Recorded& sweep, const io::Json& report) {
  const auto found =
      transform_of<frames::Ct, frames::Reference>(pose_of(report.at("registration")));
  const auto back = sweep.ct_from_reference().inverse();
  double sum = 0;
  int count = 0;
  for (const io::Json& target : sweep.truth.at("targets_ct_mm")) {
    const auto at = [&](std::size_t axis) { return target.at(axis).get<double>(); };
    const Point<frames::Ct> p{Eigen::Vector3d(at(0), at(1), at(2))};
    sum += (found * (back * p) - p).v.squaredNorm();
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(SimulateTest, ARecordingIsRegisteredOnlyToItsOwnCt) {
  const test::TemporaryFolder folder;
  const Recorded sweep(folder, 1, "sweep");
  const Recorded fan(folder, 2, "fan");
  const auto report = folder / "report.json";
  for (const Recorded* patient : {&sweep, &fan}) {
    const auto truth = patient->ct_from_reference();
    const Eigen::AngleAxisd turn(0.05, Eigen::Vector3d(1, 2, -1).normalized());
    const Recorded::Pose start(
        Eigen::Quaterniond(turn) * truth.rotation(),
        Eigen::Quaterniond(turn) * truth.translation_mm() + Eigen::Vector3d(3, -4, 3));
    const Recorded& other = patient == &sweep ? fan : sweep;
    for (const char* effort : {"usual", "quick"}) {
      RegisterOptions options;
      options.effort = effort;
      const io::Json own = registered(*patient, patient->options.ct, start, report, options);
      // A quick registration may be correct but rejected, because six images agree less well with
      // six others than thirty images do.
      const bool accepted = own.at("registration").at("accepted").get<bool>();
      EXPECT_TRUE(accepted || options.effort == "quick") << own.at("registration").dump(1);
      EXPECT_EQ(own.at("effort"), effort);
      EXPECT_LE(own.at("registration").at("basin").at("shift_mm"), 0.5);
      EXPECT_GE(own.at("registration").at("regions").size(), 6u);
      EXPECT_LT(target_error_mm(*patient, own), 1);
      const io::Json wrong = registered(*patient, other.options.ct, start, report, options);
      EXPECT_FALSE(wrong.at("registration").at("accepted"));
      EXPECT_EQ(pose_of(wrong.at("registration")).size(), 16U);
    }
  }
  // Without a start pose, the position of the probe comes from the skin of the CT.
  const io::Json found = registered(sweep, sweep.options.ct, std::nullopt, report);
  EXPECT_TRUE(found.at("registration").at("accepted")) << found.at("registration").dump(1);
  EXPECT_LT(target_error_mm(sweep, found), 1);
  EXPECT_EQ(found.at("start").at("kind"), "skin");
  EXPECT_TRUE(found.at("start").at("ct_from_reference_mm").is_null());
}

/// A patient of layered speed of sound whose sweep has no error of the tracker; the rest by the
/// test.
SimulateOptions of_exact_poses(const test::TemporaryFolder& folder, const std::string& path) {
  SimulateOptions options = small(folder);
  options.columns = options.rows = 0;
  options.duration_s = 4;
  options.frame_rate_hz = 15;
  options.path = path;
  options.tracker = "ideal";
  options.layered_speed = true;
  options.ct = folder / "ct.mha";
  return options;
}

/// Report of a registration that starts 5 mm from the truth.
io::Json registered_from_5_mm(const Recorded& sweep, const test::TemporaryFolder& folder) {
  const auto truth = sweep.ct_from_reference();
  const Recorded::Pose start(truth.rotation(), truth.translation_mm() + Eigen::Vector3d(3, -3, 3));
  return registered(sweep, sweep.options.ct, start, folder / "report.json");
}

TEST(RegisterTest, PressureAndSpeedsOfSoundAreFoundWithThePose) {
  const test::TemporaryFolder folder;
  SimulateOptions options = of_exact_poses(folder, "tilt");
  options.pressure_mm = 6;
  Console console(false);
  ASSERT_TRUE(run_simulate(options, console).has_value());
  const Recorded sweep(options);
  const io::Json report = registered_from_5_mm(sweep, folder);
  const io::Json& found = report.at("registration");
  EXPECT_LT(target_error_mm(sweep, report), 1.2);
  EXPECT_LT(found.at("error_probability"), 0.1);
  EXPECT_GT(found.at("pressed").at("mm"), 3);
  EXPECT_GT(found.at("pressed").at("deviation_mm"), 0);
}

TEST(RegisterTest, ADelayAlongAnAlmostEvenFanIsNotLeftInThePose) {
  const test::TemporaryFolder folder;
  SimulateOptions options = of_exact_poses(folder, "fan");
  options.seed = 2;
  options.image_offset_ms = 40;
  Console console(false);
  ASSERT_TRUE(run_simulate(options, console).has_value());
  const Recorded sweep(options);
  const io::Json report = registered_from_5_mm(sweep, folder);
  // The probe moves at 10 to 20 mm/s: a delay that is left in the pose moves it by 0.4 to 0.8 mm.
  EXPECT_LT(target_error_mm(sweep, report), 0.75);
  const io::Json& delay = report.at("registration").at("misfits").at(0);
  ASSERT_EQ(delay.at("cause"), "delay");
  EXPECT_NEAR(delay.at("values").at(0).get<double>(), -0.04, 0.015);
}

TEST(RegisterTest, PointsWithoutLandmarksCauseAWarning) {
  const test::TemporaryFolder folder;
  // Three curved branches, touched exactly.
  const auto lines = folder / "vessels.txt";
  std::ofstream out(lines);
  for (int branch = 0; branch < 3; ++branch) {
    for (int i = 0; i <= 60; ++i) {
      const double bend = 0.01 * i * i;
      const double p[] = {branch == 0 ? i : bend, branch == 1 ? i : 0.4 * bend,
                          branch == 2 ? i : -0.7 * bend};
      out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
    }
    out << '\n';
  }
  out.close();
  SessionConfig config;
  config.placement.ct_from_reference = Eigen::Matrix4d::Identity();
  RegisterOptions options;
  options.shape.points = options.shape.centre_lines = lines;
  Console console(false);
  const auto report = folder / "report.json";
  const auto done = run_register(config, options, report.string(), console);
  ASSERT_TRUE(done) << done.error().message;
  const io::Json found = read_json(report).at("registration");
  EXPECT_EQ(found.at("verdict"), "warn");
  EXPECT_NE(found.at("warnings").dump().find("goes into the pose unnoticed"), std::string::npos)
      << found.at("warnings");
}

TEST(SimulateTest, ANeedleCausesAWarningAboutHiddenCalibrationErrors) {
  const test::TemporaryFolder folder;
  const Recorded fan(folder, 2, "fan", {}, 0, "straight");
  const auto report = folder / "report.json";
  const auto truth = fan.ct_from_reference();
  const auto warnings = [&](double sigma_mm, const std::string& needle_frame) {
    RegisterOptions options;
    options.calibration_sigma_mm = sigma_mm;
    const io::Json found = registered(fan, fan.options.ct, truth, report, options, 0, needle_frame);
    const io::Json& registration = found.at("registration");
    EXPECT_TRUE(registration.at("accepted")) << registration.dump(1);
    EXPECT_EQ(found.at("calibration_sigma_mm"), sigma_mm);
    return std::pair(registration.at("warnings").dump(),
                     registration.at("predicted_target_error_rms_mm").get<double>());
  };
  const auto [plain, plain_mm] = warnings(0, "");
  const auto [needle, needle_mm] = warnings(0, "NeedleTip");
  const auto [known, known_mm] = warnings(1, "NeedleTip");
  EXPECT_EQ(plain.find("needle"), std::string::npos) << plain;
  EXPECT_NE(needle.find("across the images"), std::string::npos) << needle;
  EXPECT_NE(needle.find("--calibration-sigma-mm"), std::string::npos) << needle;
  EXPECT_EQ(known.find("--calibration-sigma-mm"), std::string::npos) << known;
  EXPECT_EQ(needle_mm, plain_mm);
  // A shift across the images goes completely into the pose.
  EXPECT_GT(known_mm, std::hypot(plain_mm, 0.99));
}

TEST(SimulateTest, WrongTimestampsAreNamedUntilTheyAreCorrected) {
  const test::TemporaryFolder folder;
  const Recorded sweep(folder, 1, "sweep", {}, 150);
  const auto report = folder / "report.json";
  const auto truth = sweep.ct_from_reference();
  const io::Json off = registered(sweep, sweep.options.ct, truth, report).at("registration");
  // The delay is estimated with the pose, which is right; the images are drawn with the delay.
  EXPECT_EQ(off.at("verdict"), "warn");
  EXPECT_NE(off.at("warnings").dump().find("earlier than their poses: raise --temporal-offset-ms"),
            std::string::npos)
      << off.at("warnings");
  ASSERT_FALSE(off.at("misfits").empty());
  const io::Json& delay = off.at("misfits").at(0);
  EXPECT_EQ(delay.at("cause"), "delay");
  EXPECT_NEAR(delay.at("values").at(0).get<double>(), -0.15, 0.02);
  EXPECT_LT(delay.at("deviations").at(0), 0.02);
  EXPECT_GT(delay.at("excess_mm"), 0.6);
  EXPECT_GT(delay.at("found_mm"), delay.at("noise_mm"));
  EXPECT_LT(delay.at("unnoticed"), 0.15);
  EXPECT_EQ(off.at("misfits").back().at("cause"), "bend");
  EXPECT_GT(off.at("misfits").back().at("unnoticed"), 0.9);
  const io::Json corrected = registered(sweep, sweep.options.ct, truth, report, {}, 150);
  EXPECT_NE(corrected.at("registration").at("verdict"), "refuse")
      << corrected.at("registration").at("reasons");
  EXPECT_LT(target_error_mm(sweep, corrected), 0.6);
  // A replay that uses this registration must use its temporal offset.
  Console console(false);
  const auto placed = [&](double temporal_offset_ms) -> Result<session::Placement> {
    SessionConfig config = config_of(sweep.options);
    config.ct.path = sweep.options.ct;
    config.source.temporal_offset_ms = temporal_offset_ms;
    config.placement.registration = report;
    const auto ct = session::read_session_ct(config.ct, console);
    auto session = session::RecordedSession::open(config.source, console);
    if (!ct || !session) return Error{ErrorCode::kIo, "not read"};
    const auto surveyed = session::survey(*session, false);
    if (!surveyed) return surveyed.error();
    return session::place_ct(config.placement, **ct, *surveyed, surveyed->recording,
                             session->reference_frame());
  };
  const auto same = placed(150);
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(same->kind, "registered");
  EXPECT_TRUE(test::rejects(placed(0), ErrorCode::kMalformedData,
                            {"expected the temporal offset that 1.igs.mha was registered with, 150 "
                             "ms, found 0 ms"}));
}

TEST(SimulateTest, AnOffsetThatLosesManyImagesCausesAWarning) {
  const test::TemporaryFolder folder;
  const auto report = folder / "report.json";
  // The timestamps are late and are corrected, so the first images are older than the first pose.
  const auto warnings_of = [&](double late_ms) {
    const Recorded sweep(folder, 1, "sweep", {}, late_ms);
    const auto truth = sweep.ct_from_reference();
    const io::Json json = registered(sweep, sweep.options.ct, truth, report, {}, late_ms);
    const io::Json& registration = json.at("registration");
    EXPECT_TRUE(registration.at("accepted")) << registration.at("reasons");
    EXPECT_GT(json.at("ledger").at("rejected").at("Probe.before_first_pose"), 0);
    const std::string said = "images without a pose: by --temporal-offset-ms";
    EXPECT_EQ(json.at("diagnostics").dump().find(said) != std::string::npos,
              registration.at("warnings").dump().find(said) != std::string::npos);
    return registration.at("warnings").dump();
  };
  const std::string lost = warnings_of(600);
  EXPECT_NE(lost.find("by --temporal-offset-ms 600, "), std::string::npos) << lost;
  EXPECT_NE(lost.find(" images lie before the first pose, by 0 to 600 ms"), std::string::npos)
      << lost;
  const std::string few = warnings_of(150);
  EXPECT_EQ(few.find("images without a pose"), std::string::npos) << few;
}

TEST(SimulateTest, AReplayWarnsAboutImagesLostByAnOffset) {
  const test::TemporaryFolder folder;
  const Recorded sweep(folder, 1, "sweep", {}, 600);
  const auto warned = [&](double offset_ms) {
    Console console(false);
    SessionConfig config;
    config.source.recording = sweep.options.out;
    config.source.temporal_offset_ms = offset_ms;
    config.ct.path = sweep.options.ct;
    config.output.folder = folder / "replay";
    config.output.frames = 1;
    config.output.width = 64;
    config.output.height = 48;
    const auto ok = run_replay(config, std::nullopt, console);
    EXPECT_TRUE(ok) << ok.error().message;
    return std::ranges::any_of(console.entries(), [](const DiagnosticEntry& entry) {
      return entry.severity == Severity::kWarning &&
             entry.message.starts_with("images without a pose: by --temporal-offset-ms");
    });
  };
  EXPECT_TRUE(warned(600));
  EXPECT_FALSE(warned(0));
}

TEST(SimulateTest, ARecordingIsDrawnWithinItsSector) {
  const test::TemporaryFolder folder;
  Console console(false);
  for (const char* family : {"abdomen", "tendon"}) {  // A convex and a linear probe.
    SimulateOptions options = small(folder);
    options.family = family;
    options.columns = 200;
    options.rows = 140;
    ASSERT_TRUE(run_simulate(options, console));
    auto session = session::RecordedSession::open(config_of(options).source, console);
    ASSERT_TRUE(test::has_value(session));
    const auto surveyed = session::survey(*session, false);
    ASSERT_TRUE(test::has_value(surveyed));
    EXPECT_EQ(surveyed->corners.size(), 4 * surveyed->paired);
    const auto sector = session::sector_of(*surveyed);
    ASSERT_EQ(sector.has_value(), std::string(family) == "abdomen");
    if (!sector) continue;
    session->set_outline(*sector);
    int lit = 0, lit_inside = 0, dark_outside = 0;
    ASSERT_TRUE(session->play([&](const tracking::PairedImage& paired) {
      const UltrasoundImage& frame = paired.tracked->frame;
      ASSERT_TRUE(frame.outline);
      for (int row = 0; row < frame.pixels.height(); ++row) {
        for (int column = 0; column < frame.pixels.width(); ++column) {
          const bool inside = frame.outline->contains(frame.grid.at(column, row).mm.head<2>());
          const bool shown = frame.pixels.at(column, row) > 0;
          lit += shown ? 1 : 0;
          lit_inside += shown && inside ? 1 : 0;
          dark_outside += !shown && !inside ? 1 : 0;
        }
      }
    }));
    EXPECT_GT(lit_inside, 0.99 * lit);  // Except for pixels that the edge cuts.
    EXPECT_GT(dark_outside, 0.1 * lit);
  }
}

TEST(SimulateTest, AFaultyRecordingIsReplayedWithoutItsFaults) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = small(folder);
  options.tracker = "ideal";
  options.duration_s = 6;
  options.faults = "0.02";
  ASSERT_TRUE(run_simulate(options, console));
  const io::Json truth = truth_file(options);
  ASSERT_FALSE(truth.at("faults").empty());
  SessionConfig config = config_of(options);
  config.source.skip_bad_frames = true;
  auto session = session::RecordedSession::open(config.source, console);
  ASSERT_TRUE(session) << session.error().message;
  const auto played = session->play([](const auto&) {});
  ASSERT_TRUE(played);
  session->navigator().finish();
  EXPECT_TRUE(session->navigator().ledger().balanced());
}

TEST(SimulateTest, EachFaultCanBeSelectedByNameAndReplayed) {
  for (int k = 0; k <= static_cast<int>(sim::FaultKind::kDenormalised); ++k) {
    const std::string name = to_string(static_cast<sim::FaultKind>(k));
    const test::TemporaryFolder folder;
    Console console(false);
    SimulateOptions options = small(folder);
    options.family = "tendon";
    options.tracker = "ideal";
    options.duration_s = 1.5;
    options.faults = name + "=0.1";
    ASSERT_TRUE(run_simulate(options, console)) << name;
    const io::Json truth = truth_file(options);
    ASSERT_FALSE(truth.at("faults").empty()) << name;
    for (const io::Json& fault : truth.at("faults")) EXPECT_EQ(fault.at("kind"), name);
    SessionConfig config = config_of(options);
    config.source.skip_bad_frames = true;
    auto session = session::RecordedSession::open(config.source, console);
    ASSERT_TRUE(session) << name << ": " << session.error().message;
    ASSERT_TRUE(session->play([](const auto&) {})) << name;
    session->navigator().finish();
    EXPECT_TRUE(session->navigator().ledger().balanced()) << name;
  }
}

TEST(SimulateTest, ANeedleIsRecordedLikePlusAndReplayedAtItsTruePose) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = small(folder);
  options.tracker = "ideal";
  options.needle = "bevel";
  options.needle_bending_mm = 5;
  const auto written = run_simulate(options, console);
  ASSERT_TRUE(written) << written.error().message;
  const io::Json truth = truth_file(options);
  const auto ct_from_reference =
      transform_of<frames::Ct, frames::Reference>(truth.at("ct_from_reference_mm"));
  SessionConfig config = config_of(options);
  config.source.needle_frame = "NeedleTip";
  auto session = session::RecordedSession::open(config.source, console);
  ASSERT_TRUE(session) << session.error().message;
  EXPECT_NE(session->description().find("NeedleToTracker"), std::string::npos);
  session->set_placement({ct_from_reference, {SafetyState::kValid, ""}});
  std::size_t seen = 0;
  for (;;) {
    const auto more = session->step([](const auto&) {});
    ASSERT_TRUE(more);
    if (!*more) break;
    const io::Json& needle = truth.at("frames").at(seen++).at("needle");
    const session::Epoch epoch = session->refresh();
    ASSERT_TRUE(epoch.ct_from_needle) << epoch.needle.cause;
    // A second pose confirms the first one of each body.
    const auto state = seen == 1 ? SafetyState::kDegraded : SafetyState::kValid;
    EXPECT_EQ(epoch.needle.state, state) << epoch.needle.cause;
    const auto expected =
        transform_of<frames::Ct, frames::Needle>(needle.at("ct_from_straight_tip_mm"));
    // Interpolation is exact for constant speed, except at the start and the end of the motion.
    EXPECT_TRUE(test::is_near(*epoch.ct_from_needle, expected, 0.5, 1e-5));
    sim::NeedleBending bending;
    bending.kind = sim::BendingKind::kBevelArc;
    bending.curvature_per_mm = truth.at("needle").at("curvature_per_mm");
    const sim::BentNeedle bent(bending, needle.at("inserted_mm"));
    EXPECT_NEAR(needle.at("tip_error_mm").get<double>(), bent.tip_error_mm(), 1e-9);
    const Eigen::Vector3d tip = (expected * bent.tip()).mm;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(needle.at("tip_ct_mm")[axis].get<double>(), tip[static_cast<int>(axis)], 1e-6);
    }
  }
  EXPECT_EQ(seen, 13u);
  const io::Json& last = truth.at("frames").back().at("needle");
  EXPECT_NEAR(last.at("inserted_mm").get<double>(), truth.at("needle").at("path_mm").get<double>(),
              1e-9);
  EXPECT_GT(last.at("tip_error_mm").get<double>(), 5) << "sideways, and a little short";
}

TEST(SimulateTest, TheHandOfARecordingMovesTheProbe) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions first = small(folder);
  first.tracker = "ideal";
  first.unevenness = 0.9;
  ASSERT_TRUE(run_simulate(first, console).has_value());
  SimulateOptions again = small(folder);
  again.out = folder / "again.igs.mha";
  again.tracker = "ideal";
  again.seed = 5;
  again.path_from = first.out;
  again.duration_s = {};
  const auto ran = run_simulate(again, console);
  ASSERT_TRUE(ran.has_value()) << ran.error().message;
  const auto recorded = replayed(first, console);
  const auto moved = replayed(again, console);
  ASSERT_EQ(moved.size(), recorded.size());
  // The skin of another patient is curved otherwise, so ways are compared, not poses.
  const auto way = [](const std::vector<TrackedImage>& sweep, std::size_t i) {
    return (sweep[i].reference_from_image.translation_mm() -
            sweep[i - 1].reference_from_image.translation_mm())
        .norm();
  };
  for (std::size_t i = 1; i < moved.size(); ++i) {
    EXPECT_NEAR(way(moved, i), way(recorded, i), 0.25 * way(recorded, i) + 0.6) << i;
  }
  const auto truth = truth_file(again);
  EXPECT_EQ(truth["path"]["kind"], "recorded");

  again.duration_s = 60;
  const auto longer = run_simulate(again, console);
  ASSERT_FALSE(longer.has_value());
  EXPECT_NE(longer.error().message.find("--duration-s: expected at most 1.5 s"), std::string::npos)
      << longer.error().message;
}

TEST(SimulateTest, ALevelGivesTheRecordingItsStatedErrors) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = small(folder);
  options.level = "usual";
  options.duration_s = 4;
  ASSERT_TRUE(run_simulate(options, console).has_value());
  const auto truth = truth_file(options);
  const auto calibration = transform_of<frames::Probe, frames::Image>(truth["calibration_mm"]);
  const auto exact = transform_of<frames::Probe, frames::Image>(truth["probe_from_image_mm"]);
  const auto error = exact.inverse() * calibration;
  EXPECT_NEAR(error.translation_mm().norm(), 0.6, 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(error.rotation()).angle(), 0.006, 1e-6);
  EXPECT_NEAR(truth["errors"]["image_delay_ms"].get<double>(), 40, 1e-9);
  const auto& frame = truth["frames"][0];
  EXPECT_NEAR(frame["stamped_s"].get<double>() - frame["physical_s"].get<double>(), 0.04, 1e-9);
  // The recording has the calibration as it is known, the poses with noise.
  for (const TrackedImage& tracked : replayed(options, console)) {
    EXPECT_FALSE(tracked.frame.pixels.empty());
  }
  auto session = session::RecordedSession::open(config_of(options).source, console);
  ASSERT_TRUE(session.has_value());
  ASSERT_TRUE(session->play([](const tracking::PairedImage&) {}).has_value());
  EXPECT_LE((session->probe_from_image().rotation().angularDistance(calibration.rotation())), 1e-5);
}

TEST(SimulateTest, AnotherTrackedToolDoesNotChangeTheReplay) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = small(folder);
  options.needle = "straight";
  ASSERT_TRUE(run_simulate(options, console));
  EXPECT_EQ(replayed(options, console).size(), 13u);
  SessionConfig config = config_of(options);
  config.source.needle_frame = "Stylus";
  const auto refused = session::RecordedSession::open(config.source, console);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("Stylus"), std::string::npos);
}

TEST(SimulateTest, RejectsUnknownOptions) {
  const test::TemporaryFolder folder;
  Console console(false);
  for (std::string SimulateOptions::*option :
       {&SimulateOptions::family, &SimulateOptions::path, &SimulateOptions::probe,
        &SimulateOptions::tracker, &SimulateOptions::breathing, &SimulateOptions::model,
        &SimulateOptions::faults, &SimulateOptions::needle, &SimulateOptions::contrast}) {
    SimulateOptions options = small(folder);
    options.*option = "nonsense";
    const auto refused = run_simulate(options, console);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("nonsense"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(options.out));
  }
  SimulateOptions options = small(folder);
  options.faults = "2";
  EXPECT_FALSE(run_simulate(options, console));
}

TEST(SimulateTest, OutputFilesNeverOverwriteEachOther) {
  const test::TemporaryFolder folder;
  Console console(false);
  const auto rejects = [&](const SimulateOptions& options, const std::string& option) {
    const auto refused = run_simulate(options, console);
    ASSERT_FALSE(refused) << option;
    EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
    EXPECT_NE(refused.error().message.find(option), std::string::npos) << refused.error().message;
    EXPECT_FALSE(std::filesystem::exists(options.out));
  };
  SimulateOptions options = small(folder);
  options.truth = folder / "." / std::filesystem::path(options.out).filename();
  rejects(options, "--truth");
  options = small(folder);
  options.ct = options.out;
  rejects(options, "--ct");
  options.ct = folder / "ct.nii";
  rejects(options, "ct.nii");
  options.ct = folder / "both.mha";
  options.truth = folder / "both.mha";
  rejects(options, "both.mha");
}

/// A short recording with its CT.
SimulateOptions with_ct(const test::TemporaryFolder& folder, double spacing_mm) {
  SimulateOptions options = small(folder);
  options.duration_s = 0.25;
  options.ct = folder / "ct.mha";
  options.ct_spacing_mm = spacing_mm;
  return options;
}

/// Runs the simulation and returns its truth file.
io::Json simulated(const SimulateOptions& options, Console& console) {
  const auto written = run_simulate(options, console);
  EXPECT_TRUE(written) << written.error().message;
  return truth_file(options);
}

/// Mean HU of the written CT at the targets of the patient, which lie in the liver.
double mean_at_targets(const SimulateOptions& options, Console& console) {
  const io::Json truth = simulated(options, console);
  const auto ct = io::read_ct(options.ct, console);
  EXPECT_TRUE(test::has_value(ct));
  EXPECT_EQ(truth.at("contrast"), options.contrast);
  double sum = 0;
  for (const io::Json& p : truth.at("targets_ct_mm")) {
    sum += ct->sample({Eigen::Vector3d(p.at(0), p.at(1), p.at(2))}).value_or(-1000);
  }
  return sum / static_cast<double>(truth.at("targets_ct_mm").size());
}

TEST(SimulateTest, TheCtHasTheRequestedContrastPhase) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = with_ct(folder, 4);
  std::map<std::string, double> mean;
  for (const char* contrast : {"native", "arterial", "portal", "mr"}) {
    options.contrast = contrast;
    mean[contrast] = mean_at_targets(options, console);
  }
  // Textbook values of the liver: 58, 68 and 112 HU, and a grey value of 480 for MR. Some targets
  // lie in vessels.
  EXPECT_NEAR(mean["native"], 58, 8);
  EXPECT_NEAR(mean["arterial"], 68, 10);
  EXPECT_NEAR(mean["portal"], 115, 12);
  EXPECT_NEAR(mean["mr"], 470, 50);
}

TEST(SimulateTest, ARecordedCtCanBeThePatient) {
  const test::TemporaryFolder folder;
  Console console(false);
  const SimulateOptions first = with_ct(folder, 2);
  ASSERT_TRUE(run_simulate(first, console));
  SimulateOptions options = small(folder);
  options.patient_ct = first.ct;
  options.look_at_mm = {-40, -10, 5};
  const io::Json truth = simulated(options, console);
  EXPECT_EQ(truth.at("family"), "ct");
  EXPECT_TRUE(truth.at("contrast").is_null());
  ASSERT_GT(truth.at("targets_ct_mm").size(), 20u);
  const Eigen::Vector3d aim(options.look_at_mm->data());
  const Eigen::Matrix4d image_from_pixels = matrix_of(truth.at("image_from_pixels_mm"));
  for (const io::Json& p : truth.at("targets_ct_mm")) {
    EXPECT_LE((Eigen::Vector3d(p.at(0), p.at(1), p.at(2)) - aim).norm(), sim::kAboutMm);
  }
  // The plane of the middle image passes near the point of interest.
  const io::Json& middle = truth.at("frames").at(truth.at("frames").size() / 2);
  const Eigen::Matrix4d ct_from_image = matrix_of(middle.at("ct_from_image_mm"));
  const Eigen::Vector3d local =
      (image_from_pixels.inverse() * ct_from_image.inverse() * aim.homogeneous()).head<3>();
  EXPECT_LT(std::abs(local.z()), 12);
  EXPECT_GT(local.x(), 0);
  EXPECT_LT(local.x(), options.columns);
  EXPECT_GT(local.y(), 0);
  EXPECT_LT(local.y(), options.rows);
  const auto frames = replayed(options, console);
  ASSERT_EQ(frames.size(), 13u);
  double sum = 0;
  for (const std::uint8_t v : frames[6].frame.pixels.pixels()) sum += v;
  EXPECT_GT(sum / static_cast<double>(frames[6].frame.pixels.pixels().size()), 10);
}

TEST(SimulateTest, ADistantRecordedCtIsWrittenAndBreathesThere) {
  const test::TemporaryFolder folder;
  Console console(false);
  const SimulateOptions first = with_ct(folder, 2);
  ASSERT_TRUE(run_simulate(first, console));
  const auto recorded = io::read_ct(first.ct, console);
  ASSERT_TRUE(test::has_value(recorded));
  const Eigen::Vector3d away(30, -40, 400);
  VoxelGrid grid = recorded->grid();
  grid.origin_mm += away;
  const auto hu = recorded->hu();
  const auto elsewhere = Volume::create(grid, {hu.begin(), hu.end()}, "elsewhere");
  ASSERT_TRUE(test::has_value(elsewhere));
  SimulateOptions options = small(folder);
  options.patient_ct = folder / "elsewhere.mha";
  ASSERT_TRUE(io::write_ct_mha(*elsewhere, options.patient_ct));
  const Eigen::Vector3d aim = Eigen::Vector3d(-40, -10, 5) + away;
  options.look_at_mm = {aim.x(), aim.y(), aim.z()};
  options.ct = folder / "again.mha";
  options.ct_spacing_mm = 4;
  options.breathing = "smooth";
  options.breathing_mm = 10;
  options.breathing_period_s = 1;
  const io::Json truth = simulated(options, console);
  const auto again = io::read_ct(options.ct, console);
  ASSERT_TRUE(test::has_value(again));
  double apart_hu = 0;
  const io::Json& targets = truth.at("targets_ct_mm");
  for (const io::Json& p : targets) {
    const Point<frames::Ct> target{Eigen::Vector3d(p.at(0), p.at(1), p.at(2))};
    ASSERT_TRUE(again->sample(target).has_value());
    apart_hu += std::abs(*again->sample(target) - *elsewhere->sample(target)) /
                static_cast<double>(targets.size());
  }
  EXPECT_LT(apart_hu, 40);  // Noise of 12 HU in each CT, and larger voxels.
  double deepest = 0;
  for (const io::Json& frame : truth.at("frames")) {
    const Eigen::Matrix4d rest_from_now = matrix_of(frame.at("rest_ct_from_image_mm")) *
                                          matrix_of(frame.at("ct_from_image_mm")).inverse();
    deepest = std::max(deepest, (rest_from_now * aim.homogeneous()).z() - aim.z());
  }
  // The breaths of 10 mm vary in depth, and the image plane as a whole moves a little less.
  EXPECT_GT(deepest, 5);
}

// Anatomy, noise and voxels are real. The ultrasound is simulated.
TEST(SimulateTest, ImagesSimulatedFromARealCtAreRegisteredToIt) {
  SONDE_REQUIRE_DATA(file, "ct-abdomen-totalseg/example_ct.nii.gz");
  const test::TemporaryFolder folder;
  const Recorded sweep(folder, 2, "tilt", file);
  const Recorded::Pose truth = sweep.ct_from_reference();
  const Recorded::Pose start(truth.rotation(), truth.translation_mm() + Eigen::Vector3d(4, -2, 2));
  const io::Json found = registered(sweep, file, start, folder / "report.json");
  EXPECT_LT(target_error_mm(sweep, found), 0.6);
}

TEST(SimulateTest, RejectsACtWithoutTissueAtThePointOfInterest) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options = small(folder);
  options.patient_ct = folder / "missing.mha";
  EXPECT_TRUE(test::rejects(run_simulate(options, console), ErrorCode::kNotFound, {"missing.mha"}));
  const SimulateOptions first = with_ct(folder, 4);
  ASSERT_TRUE(run_simulate(first, console));
  std::filesystem::remove(options.out);
  options.patient_ct = first.ct;
  options.look_at_mm = {1000, 0, 0};
  EXPECT_TRUE(test::rejects(run_simulate(options, console), ErrorCode::kUsage,
                            {"soft tissue", "50 mm", "1000"}));
  EXPECT_FALSE(std::filesystem::exists(options.out));
}

/// Result of 'sonde register' for three breaths of 8 mm depth, with a start error of 5 mm. The
/// errors are those of the pose at the end of expiration, at the targets of the patient, for any
/// verdict.
struct Registered {
  io::Json report;
  double error_mm, common_mm;
};

/// Runs 'sonde register' with a start error of 5 mm, with --deformable and the options \p more.
io::Json run_verb(const std::filesystem::path& sweep, const std::filesystem::path& ct,
                  const Recorded::Pose& true_pose, const std::vector<std::string>& more,
                  const std::string& json) {
  const Transform<frames::Ct, frames::Ct> off(Eigen::Quaterniond::Identity(), {3, -4, 0});
  std::ostringstream start;
  start.precision(12);
  start << (off * true_pose).matrix().reshaped<Eigen::RowMajor>().transpose();
  std::vector<std::string> words = {
      "sonde",     "register",     sweep.string(), "--ct", ct.string(), "--ct-from-reference",
      start.str(), "--deformable", "--json",       json};
  words.insert(words.end(), more.begin(), more.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size());
  for (std::string& word : words) arguments.push_back(word.data());
  run_command_line(static_cast<int>(arguments.size()), arguments.data());
  return read_json(json);
}

Registered register_breathing(const std::string& breathing) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options;
  options.out = folder / "sweep.igs.mha";
  options.ct = folder / "ct.mha";
  options.seed = 502;
  options.breathing = breathing;
  if (breathing != "none") options.breathing_mm = 8;
  options.duration_s = 12;
  options.frame_rate_hz = 5;
  EXPECT_TRUE(run_simulate(options, console));
  const io::Json truth = truth_file(options);
  const auto true_pose =
      transform_of<frames::Ct, frames::Reference>(truth.at("ct_from_reference_mm"));
  Registered out{run_verb(options.out, options.ct, true_pose, {"--breath-period", "4"},
                          (folder / "report.json").string()),
                 0, 0};
  const auto error = [&](const io::Json& matrix) {
    const auto pose = transform_of<frames::Ct, frames::Reference>(matrix);
    double sum = 0;
    for (const auto& at : truth.at("targets_ct_mm")) {
      const Point<frames::Ct> p{
          Eigen::Vector3d(at[0].get<double>(), at[1].get<double>(), at[2].get<double>())};
      sum += ((pose * (true_pose.inverse() * p)) - p).v.squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(truth.at("targets_ct_mm").size()));
  };
  out.error_mm = error(pose_of(out.report.at("registration")));
  const io::Json& breath = out.report.at("breath");
  if (breath.contains("common")) out.common_mm = error(pose_of(breath["common"]));
  return out;
}

TEST(RegisterBreathingTest, FindsThePoseAtRestOfTissueThatMovesAndDeforms) {
  const Registered found = register_breathing("smooth");
  RecordProperty("error_um", static_cast<int>(1000 * found.error_mm));
  RecordProperty("common_um", static_cast<int>(1000 * found.common_mm));
  EXPECT_GE(found.report.at("breath").at("gain_sigmas"), 3) << found.report.at("breath").dump();
  EXPECT_LT(found.error_mm, 1.0);
  EXPECT_GT(found.common_mm, 1.2);
  // At rest the tissue lies as in the CT, so there is no deformation.
  EXPECT_FALSE(found.report.at("deformable").at("supported")) << found.report.at("deformable");
}

TEST(RegisterBreathingTest, FindsNoMotionAndNoDeformationInAStillPatient) {
  const Registered found = register_breathing("none");
  EXPECT_LT(found.error_mm, 0.6);
  EXPECT_FALSE(found.report.at("breath").at("supported")) << found.report.at("breath");
  EXPECT_FALSE(found.report.at("deformable").at("supported")) << found.report.at("deformable");
  EXPECT_FALSE(found.report.at("deformable").at("reason").get<std::string>().empty());
}

Eigen::Vector3d vector_of(const io::Json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

/// Displacement of the field of a report, from the definition of uniform cubic B-splines.
Eigen::Vector3d displacement(const io::Json& field, const Eigen::Vector3d& p) {
  const auto basis = [](double x) {
    const double a = std::abs(x);
    if (a >= 2) return 0.0;
    return a >= 1 ? std::pow(2 - a, 3) / 6 : (4 - 6 * a * a + 3 * a * a * a) / 6;
  };
  const Eigen::Vector3d at =
      (p - vector_of(field.at("origin_ct_mm"))) / field.at("spacing_mm").get<double>();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t n = 0;
  for (int k = 0; k < field.at("size")[2]; ++k) {
    for (int j = 0; j < field.at("size")[1]; ++j) {
      for (int i = 0; i < field.at("size")[0]; ++i, n += 3) {
        const double w = basis(at.x() - i) * basis(at.y() - j) * basis(at.z() - k);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          sum[static_cast<int>(axis)] += w * field.at("coefficients_mm")[n + axis].get<double>();
        }
      }
    }
  }
  return sum;
}

/// A patient with seed 1, and the CT of seed 1 or of seed 2.
struct Deformed {  // NOLINT: the JSON value checks its invariant when it is moved.
  io::Json report;
  double rigid_mm = 0, deformed_mm = 0;  ///< Mean errors over the targets. rigid_mm uses the common
                                         ///< pose.
};

Deformed register_deformed_patient(double deform_mm, std::uint64_t ct_seed) {
  const test::TemporaryFolder folder;
  Console console(false);
  SimulateOptions options;
  options.out = folder / "sweep.igs.mha";
  options.deform_mm = deform_mm;
  EXPECT_TRUE(run_simulate(options, console));
  const io::Json truth = truth_file(options);
  SimulateOptions other = options;
  other.seed = ct_seed;
  other.out = folder / "other.igs.mha";
  other.duration_s = 0.2;
  other.ct = folder / "ct.mha";
  EXPECT_TRUE(run_simulate(other, console));
  const auto pose = transform_of<frames::Ct, frames::Reference>(truth.at("ct_from_reference_mm"));
  Deformed out;
  out.report = run_verb(options.out, other.ct, pose, {}, (folder / "report.json").string());
  const io::Json& tissue = out.report.at("deformable");
  if (!tissue.at("accepted").get<bool>()) return out;
  const auto found =
      transform_of<frames::Ct, frames::Reference>(pose_of(out.report.at("registration")));
  const auto common = transform_of<frames::Ct, frames::Reference>(pose_of(tissue.at("common")));
  const io::Json& now = truth.at("deformation").at("targets_now_ct_mm");
  for (std::size_t i = 0; i < now.size(); ++i) {
    const auto seen = pose.inverse() * Point<frames::Ct>{vector_of(now[i])};
    const Eigen::Vector3d target = vector_of(truth.at("targets_ct_mm")[i]);
    const Eigen::Vector3d y = (found * seen).mm;
    const auto count = static_cast<double>(now.size());
    out.rigid_mm += ((common * seen).mm - target).norm() / count;
    out.deformed_mm += (y + displacement(tissue.at("field"), y) - target).norm() / count;
  }
  return out;
}

TEST(RegisterDeformedTest, ADeformationModelReducesTheErrorOfDeformedTissue) {
  const Deformed found = register_deformed_patient(8, 1);
  EXPECT_TRUE(found.report.at("registration").at("accepted")) << found.report.at("deformable");
  ASSERT_TRUE(found.report.at("deformable").at("accepted")) << found.report.at("deformable");
  RecordProperty("rigid_um", static_cast<int>(1000 * found.rigid_mm));
  RecordProperty("deformed_um", static_cast<int>(1000 * found.deformed_mm));
  EXPECT_GT(found.rigid_mm, 1.5);
  EXPECT_LT(found.deformed_mm, 0.7 * found.rigid_mm);
  const double predicted_mm =
      found.report.at("registration").at("predicted_target_error_rms_mm").get<double>();
  EXPECT_GT(predicted_mm, 0.7 * found.deformed_mm);
  EXPECT_LT(predicted_mm, 2 * found.deformed_mm);
}

TEST(RegisterDeformedTest, UndeformedTissueIsReportedAsRigid) {
  const io::Json report = register_deformed_patient(0, 1).report;
  EXPECT_TRUE(report.at("registration").at("accepted"));
  EXPECT_FALSE(report.at("deformable").at("accepted")) << report.at("deformable");
  EXPECT_EQ(report.at("deformable").at("model"), "rigid");
}

TEST(RegisterDeformedTest, NoDeformationMakesTheCtOfAnotherPatientFit) {
  for (const double mm : {0.0, 8.0}) {
    const io::Json report = register_deformed_patient(mm, 2).report;
    EXPECT_FALSE(report.at("registration").at("accepted")) << report.at("deformable");
    EXPECT_FALSE(report.at("deformable").at("accepted")) << report.at("deformable");
  }
}

}  // namespace
}  // namespace nav::app
