// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "nav/diagnostics.hpp"
#include "session/recorded_session.hpp"

/// Opens a recording that is not there: the message must name it.
int main() {
  nav::CollectingDiagnostics diagnostics;
  nav::session::SourceOptions options;
  options.recording = "absent.igs.mha";
  const auto session = nav::session::RecordedSession::open(options, diagnostics);
  if (session) return 1;
  std::cout << session.error().message << '\n';
  return session.error().code == nav::ErrorCode::kNotFound ? 0 : 1;
}
