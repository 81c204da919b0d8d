// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/session.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <thread>

#include "session/driver.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/scripted_source.hpp"

namespace nav::session {
namespace {

using std::chrono::milliseconds;
using test::at_ms;
using test::image_at;
using test::pose_at;
using test::ScriptedSource;

constexpr std::size_t kProbeStream = 0, kReferenceStream = 1, kImageStream = 2;

SessionSetup usual_setup() {
  SessionSetup setup{ProbeCalibration{Transform<frames::Probe, frames::Image>(
      Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero())}};
  setup.images = QueuePolicy::kLossless;
  setup.learn_outline = false;
  return setup;
}

/// Poses every 10 ms and an image every 20 ms.
ScriptedSource steady(int until_ms) {
  auto source = ScriptedSource::usual();
  std::uint64_t sequence = 0;
  for (int t = 0; t <= until_ms; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    if (t % 20 == 0) source.add(kImageStream, t, image_at(sequence++, t));
  }
  return source;
}

void expect_identity(const Session& session) {
  for (const auto& [info, ledger, timing] : session.accounts()) {
    EXPECT_EQ(ledger.received(), ledger.delivered() + ledger.superseded() +
                                     ledger.rejected_total() + ledger.dropped_total() +
                                     ledger.waiting())
        << info.name;
  }
}

TEST(SessionTest, AccountsForEverySampleAtEveryMoment) {
  auto source = steady(200);
  source.add(kProbeStream, 201, PoseSample{pose_at(150)});  // Backwards in time.
  source.add(kImageStream, 202, MissingImage{"no_image", "0 x 0"});
  source.add(kImageStream, 203, image_at(90, 100));  // Backwards in time.
  source.add(kImageStream, 204, image_at(91, 203));  // No pose will come.
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  for (int now = 0; now <= 210; now += 35) {
    ASSERT_TRUE(test::has_value(session.advance_to(at_ms(now))));
    expect_identity(session);
    (void)session.refresh();
    expect_identity(session);
  }
  session.finish();
  session.navigator().finish();
  const auto accounts = session.accounts();
  ASSERT_EQ(accounts.size(), 3u);
  for (const auto& account : accounts) EXPECT_TRUE(account.ledger.balanced()) << account.info.name;
  EXPECT_EQ(accounts[kProbeStream].ledger.received(), 22u);
  EXPECT_EQ(accounts[kProbeStream].ledger.delivered(), 21u);
  EXPECT_EQ(accounts[kProbeStream].ledger.rejected().at("time_not_increasing"), 1u);
  EXPECT_EQ(accounts[kReferenceStream].ledger.delivered(), 21u);
  const auto& images = accounts[kImageStream].ledger;
  EXPECT_EQ(images.received(), 14u);
  EXPECT_EQ(images.rejected().at("no_image"), 1u);
  EXPECT_EQ(images.rejected().at("time_not_increasing"), 1u);
  EXPECT_EQ(images.rejected().at("Probe.no_pose_yet"), 1u);
  EXPECT_EQ(images.delivered() + images.superseded(), 11u);
  EXPECT_GT(images.superseded(), 0u) << "refreshes every 35 ms, images every 20 ms";
}

TEST(SessionTest, DropsStreamsThatNothingUsesAndCountsThem) {
  ScriptedSource source({{"Stylus", StreamKind::kPoses, ToolRole::kStylus},
                         {"Image", StreamKind::kImages, ToolRole::kOther},
                         {"Endoscope", StreamKind::kImages, ToolRole::kOther}});
  source.add(0, 1, PoseSample{pose_at(1)});
  source.add(2, 1, image_at(0, 1));
  source.add(2, 2, image_at(1, 2));
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(10))));
  const auto accounts = session.accounts();
  EXPECT_EQ(accounts[0].ledger.dropped().at("not_used"), 1u);
  EXPECT_EQ(accounts[1].ledger.received(), 0u);
  EXPECT_EQ(accounts[2].ledger.dropped().at("not_used"), 2u);
}

TEST(SessionTest, ImagesOfAScreenThatChangesAreWithdrawnUntilItIsAsBefore) {
  auto setup = usual_setup();
  setup.image_watch = ImageWatchOptions{.depth_display = ScreenArea{0, 0, 2, 1}};
  auto source = ScriptedSource::usual();
  constexpr int kImages = 60, kFirstOther = 40, kLastOther = 49;
  for (int i = 0; i < kImages; ++i) {
    const int ms = 20 * i;
    source.add(kProbeStream, ms, PoseSample{pose_at(ms)});
    source.add(kReferenceStream, ms, PoseSample{pose_at(ms)});
    const bool other = i >= kFirstOther && i <= kLastOther;
    UltrasoundImage image = image_at(static_cast<std::uint64_t>(i), ms);
    const auto varied = static_cast<std::uint8_t>(i);
    image.pixels =
        Image2d<std::uint8_t>(2, 2, {static_cast<std::uint8_t>(other ? 200 : 20), 20, varied, 4});
    source.add(kImageStream, ms, std::move(image));
  }
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(20 * kImages))));
  session.finish();
  session.navigator().finish();
  const auto accounts = session.accounts();
  const auto& images = accounts[kImageStream].ledger;
  // The first two of ten are not believed yet; the first two after them, not either.
  EXPECT_EQ(images.rejected().at("screen_changed"), 10U);
  EXPECT_TRUE(images.balanced());
  std::string reports;
  for (const auto& entry : diagnostics.entries()) reports += entry.message + "\n";
  EXPECT_NE(reports.find("shows another depth than at first: its images are withdrawn"),
            std::string::npos)
      << reports;
  EXPECT_NE(reports.find("is as at first"), std::string::npos) << reports;
}

TEST(SessionTest, HearsOfPressedButtonsInOrderAndAccountsForThem) {
  ScriptedSource source({{"left", StreamKind::kButtons, ToolRole::kOther, ButtonAction::kMark},
                         {"right", StreamKind::kButtons, ToolRole::kOther, ButtonAction::kFreeze}});
  source.add(0, 5, ButtonSample{at_ms(4), true});
  source.add(1, 6, ButtonSample{at_ms(6), true});
  source.add(0, 8, ButtonSample{at_ms(8), false});
  source.add(0, 9, ButtonSample{at_ms(9), true});
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(steady(20)));
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  std::vector<ButtonAction> heard;
  Session::Listener listener;
  listener.pressed = [&](const PressedButton& press) { heard.push_back(press.action); };
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(30), listener)));
  EXPECT_EQ(heard, (std::vector{ButtonAction::kMark, ButtonAction::kFreeze, ButtonAction::kMark}));
  ASSERT_EQ(session.presses().size(), 3U);
  EXPECT_EQ(session.presses()[0].source, 1U);
  EXPECT_EQ(session.presses()[0].button, "left");
  EXPECT_EQ(session.presses()[0].acquired, at_ms(4));
  const auto left = session.accounts()[3].ledger;
  EXPECT_EQ(left.received(), 3U);
  EXPECT_EQ(left.delivered(), 3U);
  EXPECT_TRUE(left.balanced());
}

TEST(SessionTest, MapsTheTimesOfDevicesWhoseClocksDrift) {
  // The tracker's clock is 150 ppm fast, the scanner's 150 ppm slow; both begin anywhere. A minute
  // later the stamps differ by 18 ms, in which the probe moves by 2 mm.
  ScriptedSource source = ScriptedSource::usual();
  const auto stamp = [](double s, double ppm, double origin) {
    return DeviceTime(DeviceClock::duration(std::llround(1e9 * (origin + s * (1 + 1e-6 * ppm)))));
  };
  const auto x_mm = [](double s) { return 100 * std::sin(s); };
  std::uint64_t sequence = 0;
  for (int i = 0; i <= 6000; ++i) {
    const double s = 0.01 * i;
    const Timestamp received(from_seconds(s + 0.005));
    RawPose pose = pose_at(0, {x_mm(s), 0, 0});
    source.add_stamped(kProbeStream, received, stamp(s, 150, 7), PoseSample{pose});
    RawPose reference = pose_at(0);
    source.add_stamped(kReferenceStream, received, stamp(s, 150, 7), PoseSample{reference});
    if (i % 5 == 0) {
      source.add_stamped(kImageStream, received, stamp(s, -150, -3000), image_at(sequence++, 0));
    }
  }
  source.add_stamped(kProbeStream, Timestamp(from_seconds(60.01)), stamp(59, 150, 7),
                     PoseSample{pose_at(0)});
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  int sure = 0;
  const auto hear = [&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    const double s = 0.05 * static_cast<double>(paired.sequence);
    EXPECT_NEAR(paired.tracked->reference_from_image.translation_mm().x(), x_mm(s), 0.05) << s;
    sure += paired.tracked->doubt.find("clock") == std::string::npos ? 1 : 0;
  };
  for (int ms = 0; ms <= 61000; ms += 500) {
    ASSERT_TRUE(test::has_value(session.advance_to(at_ms(ms), hear)));
  }
  EXPECT_GE(sure, 1150) << "unsure for the first two seconds only";
  ASSERT_NE(session.clock(kProbeStream), nullptr);
  EXPECT_NEAR(session.clock(kProbeStream)->skew_ppm(), -150, 1);
  EXPECT_NEAR(session.clock(kImageStream)->skew_ppm(), 150, 1);
  const auto accounts = session.accounts();
  EXPECT_EQ(accounts[kProbeStream].ledger.rejected().at("time_not_increasing"), 1u);
}

TEST(SessionTest, MergesSourcesInOrderOfArrival) {
  ScriptedSource tracker({{"Probe", StreamKind::kPoses, ToolRole::kProbe},
                          {"Reference", StreamKind::kPoses, ToolRole::kReference}});
  ScriptedSource scanner({{"Image", StreamKind::kImages, ToolRole::kOther}});
  for (int t = 0; t <= 100; t += 10) {
    tracker.add(0, t, PoseSample{pose_at(t)});
    tracker.add(1, t, PoseSample{pose_at(t)});
    scanner.add(0, t, image_at(static_cast<std::uint64_t>(t), t));
  }
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(scanner)));
  session.add(std::make_shared<ScriptedSource>(std::move(tracker)));
  int paired = 0;
  ASSERT_TRUE(test::has_value(session.advance_to(
      at_ms(100), [&](const tracking::PairedImage& one) { paired += one.tracked ? 1 : 0; })));
  EXPECT_EQ(paired, 11);
  const auto next = session.next_arrival();
  ASSERT_TRUE(test::has_value(next));
  EXPECT_FALSE(*next);
  EXPECT_TRUE(session.ended());
}

TEST(SessionTest, AChangedGeometryIsLostUntilACalibrationFits) {
  auto setup = usual_setup();
  setup.calibration->geometry = geometry_of(image_at(0, 0));
  auto source = ScriptedSource::usual();
  const auto deeper = [](std::uint64_t sequence, int ms) {
    UltrasoundImage image = image_at(sequence, ms);
    image.grid = PixelGrid::centred(2, 1, 2);  // The user has doubled the depth.
    return image;
  };
  for (int t = 0; t <= 200; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    const auto sequence = static_cast<std::uint64_t>(t);
    if (t >= 50) {
      source.add(kImageStream, t, deeper(sequence, t));
    } else {
      source.add(kImageStream, t, image_at(sequence, t));
    }
  }
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(40))));
  EXPECT_EQ(session.refresh().ultrasound.state, SafetyState::kValid);
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(60))));
  const Epoch lost = session.refresh();
  EXPECT_EQ(lost.ultrasound.state, SafetyState::kLost);
  EXPECT_NE(lost.ultrasound.cause.find("calibration"), std::string::npos);
  EXPECT_NE(lost.ultrasound.cause.find("2.000 mm"), std::string::npos) << lost.ultrasound.cause;
  const auto said = diagnostics.entries();
  EXPECT_TRUE(std::ranges::any_of(said, [](const DiagnosticEntry& entry) {
    return entry.finding && entry.finding->subject == "Image" &&
           entry.finding->key == "size of the images" && entry.finding->values.size() == 2;
  }));
  ProbeCalibration other = *setup.calibration;
  other.geometry = geometry_of(deeper(0, 0));
  session.navigator().add_calibration(other);
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(90))));
  EXPECT_EQ(session.refresh().ultrasound.state, SafetyState::kValid);
  expect_identity(session);
}

/// Time that the test sets, read by the threads of a session.
class SetClock final : public Clock {
 public:
  [[nodiscard]] Timestamp now() const override { return at_ms(ms_); }
  void set(int ms) { ms_ = ms; }

 private:
  std::atomic<int> ms_{0};
};

TEST(SessionTest, NamesAStreamThatVanishesAndNoneThatEnds) {
  constexpr std::uint64_t kPoses = 11;
  const auto findings = [&](bool ends) {
    SetClock clock;
    auto source = steady(100);
    if (!ends) source.then([] { return Error{ErrorCode::kTimeout, "nothing more yet"}; });
    CollectingDiagnostics diagnostics;
    Session session(usual_setup(), diagnostics);
    session.add(std::make_shared<ScriptedSource>(std::move(source)));
    session.start(clock);
    clock.set(200);
    while (session.accounts()[kReferenceStream].ledger.received() < kPoses ||
           session.ended() != ends) {
      std::this_thread::yield();
    }
    for (const int ms : {300, 2200, 2500, 2700}) {
      clock.set(ms);
      session.take_in();
    }
    session.stop();
    std::multiset<std::string> streams;
    for (const auto& entry : diagnostics.entries()) {
      if (entry.finding && entry.finding->key == "stream") streams.insert(entry.finding->subject);
    }
    return streams;
  };
  EXPECT_EQ(findings(false), (std::multiset<std::string>{"Probe", "Reference", "Image"}));
  EXPECT_EQ(findings(true), std::multiset<std::string>());
}

TEST(SessionTest, SaysOnceWhatBecomesOfColours) {
  auto source = ScriptedSource::usual();
  for (int t = 0; t <= 100; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    UltrasoundImage image = image_at(static_cast<std::uint64_t>(t), t);
    if (t >= 30) set_colours(image, {2, 2, {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 1, 1}}});
    source.add(kImageStream, t, image);
  }
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  std::size_t shown = 0;
  Session::Listener listener;
  listener.settled = [&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    const UltrasoundImage& frame = paired.tracked->frame;
    EXPECT_EQ(frame.colours.empty(), frame.acquired < at_ms(30));
    if (frame.colours.empty()) return;
    ++shown;
    EXPECT_EQ(frame.colours.at(0, 1), (Rgb8{0, 0, 255}));
  };
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(100), listener)));
  session.finish(listener);
  EXPECT_EQ(shown, 8u);
  std::size_t said = 0;
  for (const auto& entry : diagnostics.entries()) {
    if (!entry.finding || entry.finding->key != "colours") continue;
    said += entry.count;
    EXPECT_NE(entry.message.find("image 30"), std::string::npos) << entry.message;
  }
  EXPECT_EQ(said, 1u);
}

TEST(SessionTest, PixelsToProbeHoldForImagesLikeTheFirst) {
  SessionSetup setup = usual_setup();
  setup.calibration.reset();
  setup.probe_from_pixels = Eigen::Matrix4d::Identity();
  setup.probe_from_pixels->topLeftCorner<3, 3>() *= 0.5;
  auto source = ScriptedSource::usual();
  for (int t = 0; t <= 200; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    UltrasoundImage image = image_at(static_cast<std::uint64_t>(t), t);
    // A spacing of 1 mm says nothing; the user changes the depth at 100 ms.
    if (t >= 100) image.grid = PixelGrid::centred(2, 0.7, 0.7);
    source.add(kImageStream, t, image);
  }
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(90))));
  const Epoch placed = session.refresh();
  EXPECT_EQ(placed.ultrasound.state, SafetyState::kValid) << placed.ultrasound.cause;
  ASSERT_TRUE(placed.frame);
  EXPECT_NEAR(placed.frame->frame.grid.mm_per_pixel(0, 0), 0.5, 1e-12);
  // Pixel (1, 1) lies at (0.5, 0.5, 0) on the probe.
  const auto corner = placed.frame->reference_from_image * placed.frame->frame.grid.at(1, 1);
  EXPECT_NEAR((corner.mm - Eigen::Vector3d(0.5, 0.5, 0)).norm(), 0, 1e-12);
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(150))));
  const Epoch deeper = session.refresh();
  EXPECT_EQ(deeper.ultrasound.state, SafetyState::kLost);
  EXPECT_NE(deeper.ultrasound.cause.find("0.700 × 0.700 mm"), std::string::npos)
      << deeper.ultrasound.cause;
  expect_identity(session);
}

TEST(SessionTest, AnImageOfAnotherSpacingThanItsCalibrationIsNotDrawn) {
  SessionSetup setup = usual_setup();
  setup.calibration.reset();
  setup.probe_from_pixels = Eigen::Matrix4d::Identity();
  setup.probe_from_pixels->topLeftCorner<3, 3>() *= 0.5;
  auto source = ScriptedSource::usual();
  for (int t = 0; t <= 100; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    UltrasoundImage image = image_at(static_cast<std::uint64_t>(t), t);
    image.grid = PixelGrid::centred(2, 0.4, 0.4);
    source.add(kImageStream, t, image);
  }
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(100))));
  EXPECT_EQ(session.refresh().ultrasound.state, SafetyState::kLost);
  const auto said = diagnostics.entries();
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said[0].message.find("0.400 × 0.400 mm"), std::string::npos) << said[0].message;
  EXPECT_NE(said[0].message.find("0.500 × 0.500 mm"), std::string::npos) << said[0].message;
}

TEST(SessionTest, TheTipOfANeedleLiesWhereItsCalibrationSays) {
  SessionSetup setup = usual_setup();
  setup.body_from_tip = Eigen::Matrix4d::Identity();
  (*setup.body_from_tip)(2, 3) = 150;
  ScriptedSource source({{"Probe", StreamKind::kPoses, ToolRole::kProbe},
                         {"Reference", StreamKind::kPoses, ToolRole::kReference},
                         {"Image", StreamKind::kImages, ToolRole::kOther},
                         {"Needle", StreamKind::kPoses, ToolRole::kNeedle}});
  for (int t = 0; t <= 100; t += 10) {
    source.add(kProbeStream, t, PoseSample{pose_at(t)});
    source.add(kReferenceStream, t, PoseSample{pose_at(t)});
    source.add(3, t, PoseSample{pose_at(t, {7, 0, 0})});
    source.add(kImageStream, t, image_at(static_cast<std::uint64_t>(t), t));
  }
  CollectingDiagnostics diagnostics;
  Session session(setup, diagnostics);
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  session.navigator().set_placement(
      {{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()}, {SafetyState::kValid, ""}});
  ASSERT_TRUE(test::has_value(session.advance_to(at_ms(100))));
  const Epoch epoch = session.refresh();
  ASSERT_TRUE(epoch.ct_from_needle) << epoch.needle.cause;
  const Eigen::Vector3d tip = epoch.ct_from_needle->translation_mm();
  EXPECT_NEAR((tip - Eigen::Vector3d(7, 0, 150)).norm(), 0, 1e-12);
}

TEST(StreamQueueTest, NewestOnlySupersedesAndLosslessDropsWhatDoesNotFit) {
  StreamQueue newest(QueuePolicy::kNewestOnly, 8);
  StreamQueue lossless(QueuePolicy::kLossless, 2);
  for (std::uint64_t i = 0; i < 3; ++i) {
    newest.push({.sequence = i, .received = at_ms(1), .what = MissingImage{}});
    lossless.push({.sequence = i, .received = at_ms(1), .what = MissingImage{}});
  }
  EXPECT_EQ(newest.ledger().superseded(), 2u);
  EXPECT_EQ(newest.ledger().waiting(), 1u);
  EXPECT_EQ(lossless.ledger().dropped().at("queue_full"), 1u);
  EXPECT_EQ(lossless.ledger().waiting(), 2u);
  std::vector<Sample> taken;
  std::vector<SupersededStamp> stamps;
  newest.drain(taken, stamps);
  lossless.drain(taken, stamps);
  ASSERT_EQ(taken.size(), 3u);
  EXPECT_EQ(stamps.size(), 2u) << "the times of what was superseded are kept";
  EXPECT_EQ(taken[0].sequence, 2u);
  EXPECT_EQ(taken[1].sequence, 0u);
  EXPECT_TRUE(newest.ledger().balanced());
  EXPECT_TRUE(lossless.ledger().balanced());
}

TEST(DriverTest, TellsItsListenerOfPressedButtons) {
  ScriptedSource source({{"left", StreamKind::kButtons, ToolRole::kOther, ButtonAction::kMark}});
  source.add(0, 5, ButtonSample{at_ms(5), true});
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(steady(60)));
  session.add(std::make_shared<ScriptedSource>(std::move(source)));
  std::vector<std::string> pressed;
  Session::Listener listener;
  listener.pressed = [&](const PressedButton& press) { pressed.push_back(press.button); };
  Driver driver(session, {}, listener);
  ASSERT_TRUE(test::has_value(driver.pass(at_ms(50))));
  EXPECT_EQ(pressed, std::vector<std::string>{"left"});
}

TEST(DriverTest, RefreshesWithEveryNthPairedImage) {
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(steady(200)));  // 11 images.
  Driver driver(session, {std::nullopt, 3});
  std::vector<std::uint64_t> shown;
  for (;;) {
    const auto epoch = driver.next();
    ASSERT_TRUE(test::has_value(epoch));
    if (!*epoch) break;
    shown.push_back((*epoch)->frame->frame.sequence);
  }
  EXPECT_EQ(shown, (std::vector<std::uint64_t>{0, 3, 6, 9}));
  EXPECT_TRUE(driver.over());
}

TEST(DriverTest, RefreshesWithAFixedPeriodUpToALimit) {
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(steady(400)));
  Driver driver(session, {milliseconds(40)});
  int refreshes = 0;
  for (;; ++refreshes) {
    const auto epoch = driver.next(at_ms(100));
    ASSERT_TRUE(test::has_value(epoch));
    if (!*epoch) break;
  }
  EXPECT_EQ(refreshes, 3) << "at 40, 80 and 100 ms";
  EXPECT_EQ(session.now(), at_ms(100));
  ASSERT_TRUE(test::has_value(driver.pass(at_ms(200))));
  EXPECT_EQ(session.now(), at_ms(200));
}

TEST(DriverTest, KeepsThePaceOfAClockAndLeavesLateRefreshesOut) {
  CollectingDiagnostics diagnostics;
  Session session(usual_setup(), diagnostics);
  session.add(std::make_shared<ScriptedSource>(steady(400)));
  Driver driver(session, {});
  const auto at = [&](int ms) { return driver.next_at_pace(at_ms(ms), false); };
  auto epoch = at(1000);
  ASSERT_TRUE(epoch && *epoch) << "the first refresh starts the pace";
  EXPECT_EQ((*epoch)->frame->frame.sequence, 0u);
  epoch = at(1010);
  ASSERT_TRUE(epoch);
  EXPECT_FALSE(*epoch) << "the next image is due at 1020 ms";
  epoch = at(1300);
  ASSERT_TRUE(epoch && *epoch);
  EXPECT_EQ((*epoch)->frame->frame.acquired, at_ms(200)) << "100 ms late at most";
  EXPECT_FALSE(driver.over());
}

}  // namespace
}  // namespace nav::session
