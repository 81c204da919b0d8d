// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_rows.hpp"

namespace nav::app {
namespace {

bool shows_a_session(const Settings& settings) {
  return !settings.session.empty() || settings.window.simulated ||
         !settings.window.phantom.empty() || !settings.config.predicates.volume.empty();
}
bool names_no_session(const Settings& settings) { return settings.session.empty(); }

const std::vector<std::string_view> kWindow{"window"};

}  // namespace

void add_window_rows(std::vector<Option>& rows) {
  const std::vector<Option> window{
      {.name = "session",
       .type = "SESSION",
       .text = "session file (TOML): a recording, live devices or the simulated procedure",
       .group = group::kGroupFiles,
       .verbs = kWindow,
       .slot = NAV_SLOT(session),
       .absent = "a window without a session",
       .usual = true},
      {.name = "--simulated",
       .text = "show the simulated procedure",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.simulated),
       .usual = true,
       .needs = {{.met = names_no_session, .text = "no session file"}}},
      {.name = "--seed",
       .type = "N",
       .text = "number of the simulated patient",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.seed),
       .needs = {{.any_of = {{"--simulated"}}}}},
      {.name = "--engine",
       .type = "NAME",
       .text = "engine of the 3D view; auto is gl on a graphics card, otherwise cpu",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.engine),
       .choices = {"auto", "cpu", "gl"},
       .usual = true},
      {.name = "--once",
       .text = "play a recording to its end, not again and again",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.once),
       .usual = true},
      {.name = "--seconds",
       .type = "S",
       .unit = "s",
       .text = "close the window this long after the session has begun; 0: the user closes it",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(config.output.seconds),
       .range = within(0, 1e6),
       .usual = true,
       .needs = {{.met = shows_a_session,
                  .text = "a session file, --simulated, --us-volume or --phantom"}}},
      {.name = "--record",
       .type = "MCAP",
       .text = "record every sample of live devices into this file, which must not exist",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(config.output.record),
       .absent = "none; Ctrl+R begins one",
       .usual = true,
       .needs = {{.any_of = {{"session"}}}}},
      {.name = "--script",
       .type = "FILE",
       .text = "lines that drive the window by events, as a user would (docs/window.md)",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.script),
       .absent = "none",
       .usual = true},
      {.name = "--shots",
       .type = "DIR",
       .text = "folder for the images of 'shot', for snapshots and for recordings of Ctrl+R",
       .group = group::kGroupWindowRun,
       .verbs = kWindow,
       .slot = NAV_SLOT(window.shots),
       .absent = "the folder in which the window was started, without the images of 'shot'",
       .usual = true}};
  rows.insert(rows.end(), window.begin(), window.end());
}

}  // namespace nav::app
