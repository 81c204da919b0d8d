// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Predicate sets and scribbles.
#include "app/predicates/predicate_file.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const auto file = fuzz::as_file(bytes, size, "a.json");
  const auto set = app::read_predicate_file(file);
  if (!set) fuzz::check_message(set.error().message);
  const auto strokes = app::read_scribble_file(file);
  if (!strokes) fuzz::check_message(strokes.error().message);
  return 0;
}
