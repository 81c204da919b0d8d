// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Predicate sets, scribbles, and labels between surfaces.
#include "app/predicates/predicate_file.hpp"
#include "app/predicates/predicate_layers.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_json(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const auto file = fuzz::as_file(bytes, size, "a.json");
  const auto set = app::read_predicate_file(file);
  if (!set) fuzz::check_message(set.error().message);
  const auto strokes = app::read_scribble_file(file);
  if (!strokes) fuzz::check_message(strokes.error().message);
  VoxelGrid grid;
  grid.size = {4, 5, 6};
  const auto layers = app::read_layers(file, grid);
  if (!layers) fuzz::check_message(layers.error().message);
  return 0;
}
