// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/buttons/button_source.hpp"

#include <utility>

namespace nav::devices {

Result<void> validate(const ButtonTimes& times) {
  const bool good = times.silence >= Duration(0) && times.streaming > Duration(0) &&
                    times.first_retry > Duration(0) && times.longest_retry >= times.first_retry;
  if (good) return {};
  return Error{ErrorCode::kUsage,
               "buttons: expected times above 0, and a longest retry of at least the first"};
}

ButtonSource::ButtonSource(std::string name, std::vector<StreamInfo> buttons,
                           const ButtonTimes& times, ButtonOpener open, const Clock& clock,
                           Diagnostics& diagnostics, const char* reporter)
    : ReopenedSource(std::move(name), {times.first_retry, times.longest_retry}, clock, diagnostics,
                     reporter),
      times_(times),
      open_(std::move(open)),
      contacts_(buttons.size()),
      sequences_(buttons.size()) {
  for (StreamInfo& button : buttons) add_stream(std::move(button));
}

/// Plans what is due next while the device is open.
void ButtonSource::plan() {
  Timestamp due = Timestamp::max();
  if (state() == SourceState::kStreaming) due = changed_ + times_.streaming;
  if (times_.silence > Duration(0) && state() != SourceState::kSilent) {
    due = std::min(due, heard_ + times_.silence);
  }
  set_due(due);
}

void ButtonSource::advance(Timestamp now) {
  if (!device_.is_open()) {
    auto opened = open_();
    if (!opened) return lose({"unavailable", without_name(opened.error().message)});
    device_ = *std::move(opened);
    restart();
    forget_contacts();
    heard_ = now;
    if (connected()) report(Severity::kInfo, "the buttons are there again");
    set_state(SourceState::kReady);
  } else if (times_.silence > Duration(0) && now - heard_ >= times_.silence) {
    if (state() != SourceState::kSilent) set_cause("silent");
    set_state(SourceState::kSilent);
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(times_.silence).count();
    report_once(Severity::kWarning, "silent",
                "nothing has come for " + std::to_string(ms) +
                    " ms; check the power and the cable of the buttons");
  } else if (state() == SourceState::kStreaming && now - changed_ >= times_.streaming) {
    set_state(SourceState::kReady);
  }
  plan();
}

void ButtonSource::attend(bool readable, bool /*writable*/) {
  if (!readable || !device_.is_open()) return;
  read_device();
  if (device_.is_open()) plan();
}

void ButtonSource::heard(std::size_t bytes) {
  heard_ = clock().now();
  if (state() == SourceState::kSilent) {
    forget_report("silent");
    set_state(SourceState::kReady);
  }
  count_bytes(bytes);
}

void ButtonSource::take_contact(std::size_t button, bool pressed, Timestamp time) {
  switch (contacts_[button].take(pressed, time)) {
    case ButtonChange::kNone:
      return;
    case ButtonChange::kBounce:
      return count("bounce");
    case ButtonChange::kChange:
      break;
  }
  const Timestamp now = clock().now();
  deliver({.stream = button,
           .sequence = sequences_[button]++,
           .received = now,
           .what = ButtonSample{.acquired = std::min(time, now), .pressed = pressed}});
  changed_ = now;
  set_state(SourceState::kStreaming);
}

void ButtonSource::forget_contacts() {
  for (ButtonFilter& contact : contacts_) contact.forget();
}

}  // namespace nav::devices
