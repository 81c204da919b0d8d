// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "app/verbs/device_report.hpp"
#include "app/window/feed.hpp"
#include "nav/cause_words.hpp"
#include "session/live_devices.hpp"
#include "session/live_session.hpp"

namespace nav::app {
namespace {

std::string kind_in_words(session::LiveKind kind) {
  switch (kind) {
    case session::LiveKind::kSimulated:
      return "SIMULATED";
    case session::LiveKind::kRecording:
      return "RECORDING";
    case session::LiveKind::kLive:
      break;
  }
  return "LIVE";
}

class LiveFeed final : public Feed {
 public:
  LiveFeed(const SessionConfig& config, const Clock& clock, Console& console,
           std::shared_ptr<WindowRecorder> recorder, session::LiveSession live,
           PlacedView::Parts parts)
      : config_(config),
        clock_(clock),
        recorder_(std::move(recorder)),
        live_(std::move(live)),
        view_(config, console, std::move(parts)),
        driver_(live_.session(), {}, listener()) {
    if (config_.plan) live_.session().navigator().set_plan(*config_.plan);
    if (const auto placement = view_.show_before_images()) {
      live_.session().navigator().set_placement(*placement);
    }
    live_.start();
  }
  ~LiveFeed() override { live_.session().stop(); }

  Result<std::optional<session::Epoch>> next(Timestamp now) override {
    auto epoch = driver_.next_at_pace(now, false);
    if (failure_) return *failure_;
    return epoch;
  }
  [[nodiscard]] session::Epoch again(session::Epoch, Timestamp) override {
    return session().refresh();
  }
  [[nodiscard]] Timestamp on_clock(Timestamp time) const override { return time; }
  [[nodiscard]] bool over() const override { return driver_.over(); }
  void finish() override {
    const auto before = live_.status();  // Their states are those of the session, not of its end.
    live_.session().finish();
    live_.session().navigator().finish();
    (void)recorder_->finish();  // It keeps its error.
    auto devices = live_.status();
    for (std::size_t i = 0; i < devices.size(); ++i) devices[i].health = before[i].health;
    const auto& failures = live_.session().failures();
    outcome_ = failures.empty() ? check_all_deliver(devices)
                                : Error{ErrorCode::kUnavailable, failures.front()};
  }
  [[nodiscard]] Result<void> outcome() const override { return outcome_; }
  std::vector<session::PressedButton> take_presses() override {
    return std::exchange(presses_, {});
  }
  [[nodiscard]] io::Json presses() override {
    return json_of(live_.session().presses(), live_.status());
  }
  Result<void> start_recording(const std::filesystem::path& path) override {
    return recorder_->start(path, live_);
  }
  WindowRecorder* recorder() override { return recorder_.get(); }
  [[nodiscard]] session::Session& session() override { return live_.session(); }
  [[nodiscard]] PlacedView& view() override { return view_; }
  [[nodiscard]] std::string reference_frame() override { return live_.reference_frame(); }
  [[nodiscard]] std::string kind() const override {
    return kind_in_words(session::live_kind(config_.source.devices));
  }
  [[nodiscard]] std::string ended() const override { return "the devices have nothing more"; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> facts() override {
    std::vector<std::pair<std::string, std::string>> all;
    all.emplace_back("patient", "CT " + config_.ct.path.string());
    for (const auto& device : live_.status()) {
      all.emplace_back("devices", device.id + " (" + device.kind +
                                      "): " + to_string(device.health.state) +
                                      (device.health.cause.empty() ? "" : ", ") +
                                      words_of_cause(device.health.cause));
    }
    all.emplace_back("calibration", live_.calibration_statement());
    all.emplace_back("registration", live_.reference_statement());
    if (const auto& placement = view_.placement()) {
      all.emplace_back("registration", placement->statement);
    }
    return all;
  }

 private:
  session::Session::Listener listener() {
    auto listener = placing_listener(view_, live_.session(), failure_);
    listener.pressed = [this](const session::PressedButton& press) { presses_.push_back(press); };
    return listener;
  }

  const SessionConfig& config_;
  const Clock& clock_;
  std::shared_ptr<WindowRecorder> recorder_;  ///< The threads of the devices call it too.
  session::LiveSession live_;
  PlacedView view_;
  std::optional<Error> failure_;
  Result<void> outcome_;
  std::vector<session::PressedButton> presses_;
  session::Driver driver_;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_live_feed(const SessionConfig& config, const Clock& clock,
                                             Console& console) {
  auto recorder = std::make_shared<WindowRecorder>(config, clock, console);
  auto live = session::LiveSession::open(
      config.source, clock, console,
      [recorder](std::size_t device, const Sample& sample) { recorder->record(device, sample); });
  if (!live) return live.error();
  auto parts = PlacedView::prepare(config, live->reference_frame(), console);
  if (!parts) return parts.error();
  if (!config.output.record.empty()) {
    if (auto ok = recorder->start(config.output.record, *live); !ok) return ok.error();
  }
  return std::unique_ptr<Feed>(std::make_unique<LiveFeed>(
      config, clock, console, std::move(recorder), *std::move(live), *std::move(parts)));
}

}  // namespace nav::app
