// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "app/window/faulty_source.hpp"
#include "app/window/feed.hpp"
#include "session/driver.hpp"
#include "session/paced_source.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"

namespace nav::app {
namespace {

// Images that two loaded cores can simulate beside the 3D view.
constexpr double kSimulatedRateHz = 15;
constexpr int kSimulatedColumns = 300;
constexpr int kSimulatedRows = 220;
constexpr int kSimulatedLines = 112;
constexpr double kSweepSeconds = 3;
constexpr double kApproachSeconds = 20;

sim::SimulatedSessionOptions simulated_procedure(std::uint64_t seed) {
  sim::SimulatedSessionOptions session = sim::demonstrated_procedure(seed);
  session.probe.columns = kSimulatedColumns;
  session.probe.rows = kSimulatedRows;
  session.probe.lines = kSimulatedLines;
  session.frame_rate_hz = kSimulatedRateHz;
  session.duration_s = kSweepSeconds;
  session.approach->duration_s = kApproachSeconds;
  return session;
}

/// The parts of a simulated procedure that do not change when it begins again.
struct Simulated {
  sim::SimulatedSession session;
  SessionConfig config;
  PlacedView::Parts parts;
};

class SimulatedFeed final : public Feed {
 public:
  SimulatedFeed(Simulated made, const Clock& clock, Console& console)
      : simulation_(std::move(made.session)),
        config_(std::move(made.config)),
        clock_(clock),
        console_(console),
        view_(config_, console, std::move(made.parts)) {
    placement_ = view_.show_before_images();
    begin();
  }
  ~SimulatedFeed() override { session_->stop(); }

  Result<std::optional<session::Epoch>> next(Timestamp now) override {
    if (driver_->over()) begin();
    auto epoch = driver_->next_at_pace(now, false);
    if (failure_) return *failure_;
    if (!faced_ && view_.placement()) {
      faced_ = true;
      face_the_needle();
    }
    return epoch;
  }
  [[nodiscard]] session::Epoch again(session::Epoch, Timestamp) override {
    return session().refresh();
  }
  [[nodiscard]] Timestamp on_clock(Timestamp time) const override { return time; }
  [[nodiscard]] bool over() const override { return false; }
  void finish() override {
    session_->finish();
    session_->navigator().finish();
  }
  bool cover_marker(Duration time) override {
    faults_->cover_marker(time);
    return true;
  }
  bool hold_images(Duration time) override {
    faults_->hold_images(time);
    return true;
  }
  [[nodiscard]] session::Session& session() override { return *session_; }
  [[nodiscard]] PlacedView& view() override { return view_; }
  [[nodiscard]] std::string kind() const override { return "SIMULATED"; }
  [[nodiscard]] std::string ended() const override { return "the simulation has ended"; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> facts() override {
    return {
        {"patient", "simulated patient " + std::to_string(simulation_.options().seed)},
        {"devices", "simulated probe, reference and needle"},
        {"calibration", "known, because it is simulated"},
        {"registration", view_.placement() ? view_.placement()->statement
                                           : "The CT is placed by the truth of the simulation."},
        {"plan", "the simulated needle follows the path of its own procedure"}};
  }

 private:
  /// The camera looks at the plane in which the needle comes, not at that of the first image.
  void face_the_needle() {
    const auto last = simulation_.truth(simulation_.frame_count() - 1).ct_from_image;
    view_.presenter().set_facts(
        {.plan = view_.plan(),
         .needle_expected = true,
         .focus_ct = view_.plan()->target_ct,
         .typical_plane = SessionFacts::TypicalPlane{last, simulation_.options().probe.depth_mm},
         .window = view_.presenter().window(),
         .banner = kind(),
         .warning = view_.presenter().facts().warning,
         .uncertainty = view_.presenter().facts().uncertainty});
  }
  void begin() {
    if (session_) finish();
    driver_.reset();
    session::SessionSetup setup{ProbeCalibration{simulation_.probe_from_image()}};
    setup.navigator.frame_period.reset();
    setup.navigator.needle_period.reset();
    session_ = std::make_unique<session::Session>(setup, console_);
    faults_ = std::make_shared<FaultySource>(
        std::make_shared<session::PacedSource>(sim::source_of(simulation_), clock_), clock_);
    session_->add(faults_);
    if (view_.placement()) {
      session_->navigator().set_placement(view_.placement()->placement);
    } else if (placement_) {
      session_->navigator().set_placement(*placement_);
    }
    if (view_.plan()) session_->navigator().set_plan(*view_.plan());
    driver_.emplace(*session_, session::RefreshRule{},
                    placing_listener(view_, *session_, failure_));
    session_->start(clock_);
  }

  sim::SimulatedSession simulation_;
  SessionConfig config_;
  const Clock& clock_;
  Console& console_;
  PlacedView view_;
  bool faced_ = false;
  std::optional<session::CtPlacement> placement_;
  std::optional<Error> failure_;
  std::shared_ptr<FaultySource> faults_;
  std::unique_ptr<session::Session> session_;
  std::optional<session::Driver> driver_;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_simulated_feed(const SessionConfig& config, const Clock& clock,
                                                  Console& console) {
  auto simulation = sim::SimulatedSession::create(simulated_procedure(config.source.seed));
  if (!simulation) return simulation.error();
  sim::CtOptions scan;
  scan.seed = config.source.seed;
  auto ct = sim::scan_ct(simulation->patient(), scan);
  if (!ct) return ct.error();
  SessionConfig own = config;
  // The user may have planned another path than that of the simulated needle.
  if (!own.plan) own.plan = simulation->needle()->plan();
  auto parts = PlacedView::prepare(own, "Reference", std::make_shared<const Volume>(*std::move(ct)),
                                   console);
  if (!parts) return parts.error();
  parts->needle_expected = true;
  // The user may have placed the CT otherwise.
  if (!parts->given) {
    parts->given = session::Placement{
        .placement = {simulation->ct_from_reference(), {SafetyState::kValid, ""}},
        .kind = "registered",
        .statement = "The CT is placed by the truth of the simulation."};
  }
  return std::unique_ptr<Feed>(std::make_unique<SimulatedFeed>(
      Simulated{*std::move(simulation), std::move(own), *std::move(parts)}, clock, console));
}

}  // namespace nav::app
