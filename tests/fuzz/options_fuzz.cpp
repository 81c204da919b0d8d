// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Command lines, one word in each line: options, their values and their checks. No verb is run.
#include <string>
#include <vector>

#include "app/options/verbs.hpp"
#include "tests/fuzz/fuzz_mutation.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  return nav::fuzz::mutate_text(data, size, most, seed);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  std::vector<std::string> words{"sonde", ""};
  for (std::size_t i = 0; i < size; ++i) {
    if (bytes[i] == 0) continue;  // No word can hold it.
    if (bytes[i] == '\n') {
      words.emplace_back();
    } else {
      words.back() += static_cast<char>(bytes[i]);
    }
  }
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  (void)app::CommandLine().parse(static_cast<int>(arguments.size()), arguments.data());
  return 0;
}
