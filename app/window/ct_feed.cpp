// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "app/window/feed.hpp"

namespace nav::app {
namespace {

/// Nothing in it is live: one moment, and another one for each change by the user.
class CtFeed final : public Feed {
 public:
  CtFeed(const SessionConfig& config, Console& console, PlacedView::Parts parts)
      : config_(config),
        session_(session::SessionSetup{}, console),
        view_(config, console, std::move(parts)) {
    view_.show_before_images();
  }

  Result<std::optional<session::Epoch>> next(Timestamp) override {
    if (std::exchange(shown_, true)) return std::optional<session::Epoch>();
    session::Epoch epoch = session_.refresh();
    const std::string cause = "a CT alone: no recording and no devices";
    epoch.ultrasound = epoch.plane = epoch.placement = epoch.needle = {SafetyState::kLost, cause};
    return std::optional<session::Epoch>(std::move(epoch));
  }
  [[nodiscard]] session::Epoch again(session::Epoch epoch, Timestamp) override { return epoch; }
  [[nodiscard]] Timestamp on_clock(Timestamp time) const override { return time; }
  [[nodiscard]] bool over() const override { return false; }
  void finish() override {
    session_.finish();
    session_.navigator().finish();
  }
  [[nodiscard]] bool stored() const override { return true; }
  [[nodiscard]] session::Session& session() override { return session_; }
  [[nodiscard]] PlacedView& view() override { return view_; }
  [[nodiscard]] std::string notice() const override {
    return "a CT alone: no recording and no devices, so there is no live image and no number";
  }
  [[nodiscard]] std::string kind() const override { return "CT ALONE"; }
  [[nodiscard]] std::string ended() const override { return {}; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> facts() override {
    return {{"patient", "CT " + config_.ct.path.string()},
            {"devices",
             "Missing: a recording or live devices. They stand in a session file ([source], "
             "[[devices]]), which 'sonde window SESSION' opens."},
            {"calibration", "Missing: images of a probe, to which a calibration belongs."},
            {"registration",
             "Missing: ultrasound images or a tracked needle. Without them the CT has no position "
             "in the patient."},
            {"navigate", "Missing: a tracked needle and a registered CT."}};
  }

 private:
  const SessionConfig& config_;
  session::Session session_;
  PlacedView view_;
  bool shown_ = false;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_ct_feed(const SessionConfig& config, Console& console) {
  auto parts = PlacedView::prepare(config, "", console);
  if (!parts) return parts.error();
  return std::unique_ptr<Feed>(std::make_unique<CtFeed>(config, console, *std::move(parts)));
}

}  // namespace nav::app
