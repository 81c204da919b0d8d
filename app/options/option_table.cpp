// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_rows.hpp"

namespace nav::app {

const std::vector<Option>& option_table() {
  static const std::vector<Option> table = [] {
    std::vector<Option> rows;
    add_file_rows(rows);
    add_simulate_rows(rows);
    add_replay_rows(rows);
    add_register_rows(rows);
    add_slices_rows(rows);
    add_derive_rows(rows);
    add_reconstruct_rows(rows);
    add_window_rows(rows);
    add_recording_rows(rows);
    // The first row with a key says what a session file may hold.
    add_view_rows(rows);
    add_appearance_rows(rows);
    add_volume_rows(rows);
    add_predicate_rows(rows);
    add_plan_rows(rows);
    add_window_state_rows(rows);
    return rows;
  }();
  return table;
}

}  // namespace nav::app
