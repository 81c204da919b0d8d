// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "app/options/session_config.hpp"
#include "app/verbs/demo.hpp"
#include "app/verbs/derive.hpp"
#include "app/verbs/export.hpp"
#include "app/verbs/reconstruct.hpp"
#include "app/verbs/replay.hpp"
#include "app/verbs/serve.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "app/verbs/slices.hpp"
#include "app/verbs/window_options.hpp"

namespace nav::app {

/// Everything that an option of the table can set. A default-constructed value holds the defaults;
/// the help texts and the documents take them from there.
struct Settings {
  SessionConfig config;
  DemoOptions demo;  ///< Only the seed and the start error; all else of a demo lies in config.
  RegisterOptions registration;
  SlicesOptions slices;
  DeriveOptions derive;
  SimulateOptions simulate;
  ServeOptions serve;
  ExportOptions exported;
  ReconstructOptions reconstruct;
  WindowOptions window;
  std::filesystem::path session;  ///< Session file; empty: none.
  std::string json;               ///< File of the JSON report; "-": standard output; empty: none.
  std::filesystem::path file;     ///< Argument of info.
  bool print_session = false;
};

/// Defaults of a verb. demo has another appearance and camera than replay.
Settings default_settings(std::string_view verb);

}  // namespace nav::app
