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

const char* to_string(SourceState state) {
  switch (state) {
    case SourceState::kStarting:
      return "starting";
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
