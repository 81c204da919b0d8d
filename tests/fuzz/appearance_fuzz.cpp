// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Appearance files, and presets of 3D Slicer as JSON and as text.
#include <string_view>

#include "app/appearance/appearance_file.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_json(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const bool slicer = text.find("volumeProperties") != text.npos;
  const char* name = slicer ? "a.vp.json" : text.starts_with("{") ? "a.json" : "a.vp";
  const auto file = app::read_appearance_file(fuzz::as_file(bytes, size, name));
  if (!file) fuzz::check_message(file.error().message);
  return 0;
}
