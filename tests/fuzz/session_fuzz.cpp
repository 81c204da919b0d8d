// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Session files (TOML): reading, checks, and writing what was read.
#include "app/options/session_config.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_text(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const auto config = app::read_session_config(fuzz::as_file(bytes, size, "a.toml"));
  if (!config) {
    fuzz::check_message(config.error().message);
    return 0;
  }
  if (const auto valid = app::validate(*config); !valid) {
    fuzz::check_message(valid.error().message);
  }
  (void)app::to_toml(*config);
  return 0;
}
