// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/sample.hpp"

#include "nav/source.hpp"

namespace nav {

const char* to_string(ToolRole role) {
  switch (role) {
    case ToolRole::kProbe:
      return "Probe";
    case ToolRole::kReference:
      return "Reference";
    case ToolRole::kNeedle:
      return "Needle";
    case ToolRole::kStylus:
      return "Stylus";
    case ToolRole::kPhantom:
      return "Phantom";
    case ToolRole::kOther:
      break;
  }
  return "Other";
}

const char* to_string(ButtonAction action) {
  switch (action) {
    case ButtonAction::kCapture:
      return "capture";
    case ButtonAction::kFreeze:
      return "freeze";
    case ButtonAction::kMark:
      return "mark";
    case ButtonAction::kNone:
      break;
  }
  return "none";
}

std::optional<ButtonAction> button_action_from(std::string_view name) {
  for (const ButtonAction action :
       {ButtonAction::kNone, ButtonAction::kCapture, ButtonAction::kFreeze, ButtonAction::kMark}) {
    if (name == to_string(action)) return action;
  }
  return std::nullopt;
}

const char* to_string(StreamKind kind) {
  switch (kind) {
    case StreamKind::kImages:
      return "image";
    case StreamKind::kPoses:
      return "pose";
    case StreamKind::kButtons:
      break;
  }
  return "button";
}

const char* to_string(SourceState state) {
  switch (state) {
    case SourceState::kStarting:
      return "starting";
    case SourceState::kReady:
      return "ready";
    case SourceState::kStreaming:
      return "streaming";
    case SourceState::kSilent:
      return "silent";
    case SourceState::kWaiting:
      return "waiting";
    case SourceState::kEnded:
      break;
  }
  return "ended";
}

}  // namespace nav
