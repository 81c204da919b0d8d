// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>

#include "session/driver.hpp"
#include "tests/support/scripted_source.hpp"

/// Live sessions: one thread for each source.
namespace nav::session {
namespace {

using std::chrono::milliseconds;
using test::image_at;
using test::pose_at;
using test::ScriptedSource;

constexpr std::size_t kImages = 200;

SessionSetup live_setup(QueuePolicy images) {
  SessionSetup setup{ProbeCalibration{Transform<frames::Probe, frames::Image>(
      Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero())}};
  setup.images = images;
  setup.learn_outline = false;
  return setup;
}

ScriptedSource tracker() {
  ScriptedSource source({{"Probe", StreamKind::kPoses, ToolRole::kProbe},
                         {"Reference", StreamKind::kPoses, ToolRole::kReference}});
  for (int t = 0; t < static_cast<int>(kImages); ++t) {
    source.add(0, t, PoseSample{pose_at(t)});
    source.add(1, t, PoseSample{pose_at(t)});
  }
  return source;
}

ScriptedSource scanner() {
  ScriptedSource source({{"Image", StreamKind::kImages, ToolRole::kOther}});
  for (int t = 0; t < static_cast<int>(kImages); ++t) {
    source.add(0, t, image_at(static_cast<std::uint64_t>(t), t));
  }
  return source;
}

/// Takes in until all sources have ended.
void run(Session& session) {
  while (!session.ended()) {
    session.take_in();
    std::this_thread::yield();
  }
  session.take_in();
}

void expect_balanced(const Session& session) {
  for (const auto& [info, ledger, timing] : session.accounts()) {
    EXPECT_TRUE(ledger.balanced()) << info.name << ": " << ledger.waiting();
  }
}

TEST(LiveSessionTest, LosesNothingInLosslessQueues) {
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  Session session(live_setup(QueuePolicy::kLossless), diagnostics);
  session.add(std::make_shared<ScriptedSource>(tracker()));
  session.add(std::make_shared<ScriptedSource>(scanner()));
  session.start(clock);
  run(session);
  session.finish();
  session.navigator().finish();
  expect_balanced(session);
  const auto accounts = session.accounts();
  EXPECT_EQ(accounts[0].ledger.received(), kImages);
  EXPECT_EQ(accounts[2].ledger.received(), kImages);
  EXPECT_EQ(accounts[2].ledger.dropped_total(), 0u);
  EXPECT_TRUE(session.failures().empty());
}

TEST(LiveSessionTest, CountsImagesThatANewerOneReplaced) {
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  Session session(live_setup(QueuePolicy::kNewestOnly), diagnostics);
  session.add(std::make_shared<ScriptedSource>(scanner()));
  session.start(clock);
  while (!session.ended()) std::this_thread::yield();  // Nobody takes anything in.
  session.take_in();
  session.finish();
  session.navigator().finish();
  expect_balanced(session);
  EXPECT_EQ(session.accounts()[0].ledger.received(), kImages);
  EXPECT_GE(session.accounts()[0].ledger.superseded(), kImages - 1);
}

TEST(LiveSessionTest, AThreadThatThrowsIsLostAndTheOthersGoOn) {
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  Session session(live_setup(QueuePolicy::kLossless), diagnostics);
  auto broken = tracker();
  broken.then([]() -> Error { throw std::runtime_error("the tracker's cable is a snake"); });
  session.add(std::make_shared<ScriptedSource>(std::move(broken)));
  session.add(std::make_shared<ScriptedSource>(scanner()));
  session.start(clock);
  run(session);
  ASSERT_EQ(session.failures().size(), 1u);
  EXPECT_NE(session.failures()[0].find("the tracker's cable is a snake"), std::string::npos);
  const Epoch epoch = session.refresh();
  EXPECT_EQ(epoch.ultrasound.state, SafetyState::kLost);
  EXPECT_EQ(epoch.ultrasound.cause, session.failures()[0]);
  EXPECT_EQ(epoch.plane.state, SafetyState::kLost);
  EXPECT_EQ(session.accounts()[2].ledger.received(), kImages) << "the scanner went on";
}

TEST(LiveSessionTest, ABugInASourceDoesNotEndTheProgram) {
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  Session session(live_setup(QueuePolicy::kLossless), diagnostics);
  auto broken = scanner();
  broken.then([]() -> Error {
    NAV_CHECK(1 == 2, "planted");
    return {ErrorCode::kEndOfStream, ""};
  });
  session.add(std::make_shared<ScriptedSource>(std::move(broken)));
  session.start(clock);
  run(session);
  ASSERT_EQ(session.failures().size(), 1u);
  EXPECT_NE(session.failures()[0].find("planted"), std::string::npos);
}

TEST(LiveSessionTest, StopsAThreadThatWaits) {
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  Session session(live_setup(QueuePolicy::kLossless), diagnostics);
  ScriptedSource waiting({{"Image", StreamKind::kImages, ToolRole::kOther}});
  waiting.then([]() -> Error {
    std::this_thread::sleep_for(milliseconds(1));
    return {ErrorCode::kTimeout, "nothing yet"};
  });
  session.add(std::make_shared<ScriptedSource>(std::move(waiting)));
  session.start(clock);
  session.stop();
  EXPECT_TRUE(session.ended());
  EXPECT_TRUE(session.failures().empty());
}

}  // namespace
}  // namespace nav::session
