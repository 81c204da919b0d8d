// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// One DICOM file in a folder of its own.
#include "io/ct.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  fuzz::SilentDiagnostics silent;
  const auto ct = io::read_ct(fuzz::as_file(bytes, size, "a.dcm"), silent);
  if (!ct) fuzz::check_message(ct.error().message);
  return 0;
}
