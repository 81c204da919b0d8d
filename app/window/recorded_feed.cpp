// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <utility>

#include "app/window/feed.hpp"
#include "session/driver.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

class RecordedFeed final : public Feed {
 public:
  RecordedFeed(const SessionConfig& config, bool loop, Console& console,
               session::RecordedSession session, PlacedView::Parts parts)
      : config_(config),
        loop_(loop),
        session_(std::move(session)),
        view_(config, console, std::move(parts)) {
    if (const auto placement = view_.show_before_images()) session_.set_placement(*placement);
    begin();
  }

  Result<std::optional<session::Epoch>> next(Timestamp now) override {
    if (driver_->over() && loop_) {
      if (auto rewound = session_.rewind(); !rewound) return rewound.error();
      begin();
    }
    auto epoch = driver_->next_at_pace(now, false);
    if (failure_) return *failure_;
    if (!epoch || !*epoch || by_period_) return epoch;
    // The first image has come: from here on by the clock, so that a needle moves between images.
    by_period_ = true;
    driver_.emplace(session_.session(), session::RefreshRule{kPeriod}, listener());
    driver_->restart_pace(now);
    return epoch;
  }
  [[nodiscard]] session::Epoch again(session::Epoch epoch, Timestamp now) override {
    return driver_->aged(std::move(epoch), now);
  }
  [[nodiscard]] Timestamp on_clock(Timestamp time) const override {
    return driver_->on_clock(time);
  }
  [[nodiscard]] bool over() const override { return driver_->over() && !loop_; }
  void finish() override {
    session_.session().finish();
    session_.navigator().finish();
  }
  [[nodiscard]] session::Session& session() override { return session_.session(); }
  [[nodiscard]] PlacedView& view() override { return view_; }
  [[nodiscard]] std::string reference_frame() override { return session_.reference_frame(); }
  [[nodiscard]] std::string kind() const override { return "RECORDING"; }
  [[nodiscard]] std::string ended() const override { return "the recording has ended"; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> facts() override {
    std::vector<std::pair<std::string, std::string>> all{
        {"patient", "CT " + config_.ct.path.string()},
        {"devices", "recording " + session_.name()},
        {"calibration", session_.description()},
        {"registration", "patient's frame: " + session_.reference_statement()}};
    if (const auto& placement = view_.placement()) {
      all.emplace_back("registration", placement->statement);
    }
    return all;
  }

 private:
  static constexpr Duration kPeriod = std::chrono::milliseconds(33);

  session::Session::Listener listener() {
    return placing_listener(
        view_, session_.session(), failure_,
        [this](const UltrasoundImage& image) { return session::recording_read(session_, image); });
  }
  void begin() {
    // Its placement was decided by the first image of the first round.
    if (const auto& placement = view_.placement()) session_.set_placement(placement->placement);
    if (view_.plan()) session_.navigator().set_plan(*view_.plan());
    by_period_ = false;
    driver_.emplace(session_.session(), session::RefreshRule{}, listener());
  }

  const SessionConfig& config_;
  bool loop_;
  session::RecordedSession session_;
  PlacedView view_;
  std::optional<Error> failure_;
  bool by_period_ = false;
  std::optional<session::Driver> driver_;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_recorded_feed(const SessionConfig& config, bool loop,
                                                 Console& console) {
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  auto parts = PlacedView::prepare(config, session->reference_frame(), console);
  if (!parts) return parts.error();
  parts->needle_expected = session->has_needle();
  // A pipe can be read only once.
  if (config.source.survey && !std::filesystem::is_fifo(config.source.recording)) {
    console.begin("surveying the sweep");
    auto surveyed = session::survey(*session, config.source.skip_bad_frames);
    if (!surveyed) return surveyed.error();
    console.end(std::to_string(surveyed->paired) + " images with a pose");
    parts->survey = *std::move(surveyed);
  }
  if (!config.source.whole_image) {
    if (auto ok = session->learn_outline(); !ok) return ok.error();
  }
  return std::unique_ptr<Feed>(std::make_unique<RecordedFeed>(
      config, loop, console, *std::move(session), *std::move(parts)));
}

}  // namespace nav::app
