// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Surfaces and points: STL, PLY, legacy VTK, text.
#include <string_view>

#include "io/surface_file.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_text(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const char* name = text.starts_with("ply")     ? "a.ply"
                     : text.starts_with("# vtk") ? "a.vtk"
                                                 : "a.stl";
  const auto surface = io::read_surface(fuzz::as_file(bytes, size, name));
  if (!surface) fuzz::check_message(surface.error().message);
  const auto points = io::read_point_groups(fuzz::as_file(bytes, size, "a.txt"));
  if (!points) fuzz::check_message(points.error().message);
  return 0;
}
