// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Devices of a session file on a real clock: a simulated patient, by itself and by OpenIGTLink.
#include <algorithm>
#include <atomic>
#include <fstream>
#include <gtest/gtest.h>
#include <thread>

#include "app/verbs/simulate/simulated_recording.hpp"
#include "devices/ndi/ndi_emulator.hpp"
#include "devices/openigtlink/openigtlink_sender.hpp"
#include "session/driver.hpp"
#include "session/live_session.hpp"
#include "session/paced_source.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

constexpr std::uint64_t kSeed = 3;

/// Runs a session to its end, or until so many images have come. Returns them.
std::vector<TrackedImage> play_live(LiveSession& live, std::size_t most) {
  std::vector<TrackedImage> images;
  Driver driver(live.session(), {}, [&](const tracking::PairedImage& paired) {
    if (paired.tracked) images.push_back(*paired.tracked);
  });
  live.start();
  const MonotonicClock since;
  while (!driver.over() && images.size() < most && to_seconds(since.now()) < 60) {
    (void)driver.next_at_pace(since.now(), false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  live.session().finish();
  live.session().navigator().finish();
  return images;
}

void expect_account(const LiveSession& live) {
  for (const DeviceStatus& device : live.status()) {
    for (const auto& stream : device.streams) {
      const auto& ledger = stream.account.ledger;
      EXPECT_GT(ledger.received(), 0U) << stream.account.info.name;
      EXPECT_TRUE(ledger.balanced()) << stream.account.info.name;
      EXPECT_EQ(ledger.dropped_total(), 0U) << stream.account.info.name;
    }
  }
}

sim::SimulatedSessionOptions simulation() {
  sim::SimulatedSessionOptions options;
  options.seed = kSeed;
  options.duration_s = 1.5;
  options.tracker = sim::TrackerKind::kIdeal;
  options.probe.columns = 160;
  options.probe.rows = 120;
  return options;
}

TEST(LiveTest, ASimulatedDeviceRunsToItsEnd) {
  SourceOptions options{.kind = SourceKind::kLive};
  options.devices = {{.id = "sim",
                      .kind = "simulated",
                      .tracker = "ideal",
                      .needle = true,
                      .seed = kSeed,
                      .duration_s = 1}};
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  auto live = LiveSession::open(options, clock, diagnostics);
  ASSERT_TRUE(test::has_value(live));
  EXPECT_GE(play_live(*live, 1000).size(), 1U);
  EXPECT_TRUE(live->session().failures().empty());
  EXPECT_GT(live->session().navigator().ledger(ToolRole::kNeedle).received(), 0U);
  expect_account(*live);
}

TEST(LiveTest, ImagesByOpenIgtLinkLieWhereTheSimulatedProbeHeldThem) {
  const auto made = sim::SimulatedSession::create(simulation());
  ASSERT_TRUE(test::has_value(made));
  const sim::SimulatedSession& session = *made;
  CollectingDiagnostics diagnostics;
  const MonotonicClock clock;
  auto server = devices::OpenIgtLinkServer::start({}, diagnostics);
  ASSERT_TRUE(test::has_value(server));

  test::TemporaryFolder folder;
  SourceOptions options{.kind = SourceKind::kLive};
  options.plus_config = folder / "plus.xml";
  const Eigen::Matrix4d probe_from_pixels =
      session.probe_from_image().matrix() * app::image_from_pixels(session.grid());
  std::ofstream(options.plus_config)
      << "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" "
         "Matrix=\""
      << probe_from_pixels << "\"/></CoordinateDefinitions></PlusConfiguration>";
  options.devices = {{.id = "plus",
                      .kind = "openigtlink",
                      .address = "tcp:127.0.0.1:" + std::to_string((*server)->port()),
                      .bodies = {{"Probe", ""}, {"Reference", ""}},
                      .image = "Image"}};
  auto live = LiveSession::open(options, clock, diagnostics);
  ASSERT_TRUE(test::has_value(live));

  // Times of the wall clock begin at 1970; any offset does.
  const DeviceTime began{std::chrono::hours(24 * 365 * 50)};
  const devices::OpenIgtLinkSender sender(**server, "Tracker", began);
  auto simulated = std::make_shared<sim::SimulatedSource>();
  simulated->add("Probe", ToolRole::kProbe, session.probe_poses());
  simulated->add("Reference", ToolRole::kReference, session.reference_poses());
  simulated->add("Image", session.frames());
  PacedSource paced(simulated, clock);
  std::atomic<bool> go_on{true};
  std::jthread peer([&] {
    while (go_on && (*server)->clients().empty()) std::this_thread::yield();
    while (go_on) {
      const auto sample = paced.next(clock.now() + std::chrono::milliseconds(50));
      if (sample) sender.send(paced.streams()[sample->stream], *sample);
      if (!sample && sample.error().code == ErrorCode::kEndOfStream) break;
    }
  });
  const auto images = play_live(*live, 12);
  go_on = false;
  peer.join();
  ASSERT_GE(images.size(), 12U);
  expect_account(*live);
  ASSERT_NE(live->session().clock(0), nullptr);
  EXPECT_EQ(live->session().clock(0)->steps(), 0);

  // The simulated image with the same pixels gives the truth. The hand moves by 40 mm/s: a mistake
  // of 25 ms in time would be 1 mm.
  std::vector<UltrasoundImage> simulated_images;
  const auto stream = session.frames();
  while (auto frame = stream->next(Timestamp::max())) simulated_images.push_back(*frame);
  for (const TrackedImage& image : images) {
    const auto same = std::ranges::find_if(simulated_images, [&](const UltrasoundImage& one) {
      return std::ranges::equal(one.pixels.pixels(), image.frame.pixels.pixels());
    });
    ASSERT_NE(same, simulated_images.end());
    const auto truth = session.ct_from_reference().inverse() *
                       session.truth(static_cast<int>(same->sequence)).ct_from_image;
    // The two image frames have their own origins; pixels are the same.
    const auto found = image.reference_from_image * image.frame.grid.at(80, 60);
    EXPECT_LT((found - truth * session.grid().at(80, 60)).v.norm(), 1.0);
  }
}

TEST(LiveTest, AnNdiTrackerIsOpenedByItsKind) {
  devices::NdiEmulatedOptions emulated;
  emulated.tools = {{.port = 1}, {.port = 2}};
  emulated.see = [](std::size_t tool, std::uint32_t /*number*/) {
    return devices::NdiToolReading{.presence = devices::NdiPresence::kMeasured,
                                   .rotation_wxyz = {1, 0, 0, 0},
                                   .translation_mm = {10.0 * static_cast<double>(tool), 0, -1000}};
  };
  const auto emulator = devices::NdiEmulator::start(emulated, {.tcp = true});
  ASSERT_TRUE(test::has_value(emulator));
  const DeviceOptions device{.id = "tracker",
                             .kind = "ndi",
                             .address = "tcp:127.0.0.1:" + std::to_string((*emulator)->port()),
                             .bodies = {{"Probe", "port:2"}, {"Reference", ""}}};
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  const auto opened = open_device(device, "", {}, clock, diagnostics);
  ASSERT_TRUE(test::has_value(opened));
  ASSERT_EQ(opened->source->streams().size(), 2U);
  EXPECT_EQ(opened->source->streams()[0].role, ToolRole::kProbe);
  EXPECT_EQ(opened->source->streams()[1].role, ToolRole::kReference);
  for (int i = 0; i < 4; ++i) {
    const auto sample = opened->source->next(clock.now() + std::chrono::seconds(20));
    ASSERT_TRUE(test::has_value(sample));
    const auto& pose = std::get<PoseSample>(sample->what).pose;
    EXPECT_EQ(pose.tracker_from_body(0, 3), sample->stream == 0 ? 10.0 : 0.0);
  }
  EXPECT_EQ(opened->source->health().serial, "P4-00000");
}

}  // namespace
}  // namespace nav::session
