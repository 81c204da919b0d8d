// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Pairs of landmarks (CSV), Markups and ITK transforms, told apart by how they begin.
#include <string_view>

#include "app/verbs/register/landmark_file.hpp"
#include "io/markups.hpp"
#include "io/transform_file.hpp"
#include "tests/fuzz/fuzz_input.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_text(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  if (text.starts_with("#Insight")) {
    const auto pose = io::read_ct_from_reference(fuzz::as_file(bytes, size, "a.tfm"));
    if (!pose) fuzz::check_message(pose.error().message);
  } else if (text.starts_with("{") || text.starts_with("# Markups")) {
    const bool table = text.starts_with("#");
    const auto markups =
        io::read_markups(fuzz::as_file(bytes, size, table ? "a.fcsv" : "a.mrk.json"));
    if (!markups) fuzz::check_message(markups.error().message);
  } else {
    const auto list = app::read_landmarks(fuzz::as_file(bytes, size, "a.csv"));
    if (!list) fuzz::check_message(list.error().message);
  }
  return 0;
}
