// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Recordings of devices (MCAP): survey, all samples, and the setup.
#include "io/mcap/device_recording.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  constexpr int kSamples = 1000;
  auto recording = io::mcap::DeviceRecording::open(fuzz::as_file(bytes, size, "a.mcap"));
  if (!recording) {
    fuzz::check_message(recording.error().message);
    return 0;
  }
  for (std::size_t i = 0; i < recording->devices().size() && i < 8; ++i) {
    auto source = recording->source(i);
    if (!source) {
      fuzz::check_message(source.error().message);
      continue;
    }
    for (int k = 0; k < kSamples; ++k) {
      if (!(*source)->next(Timestamp::max())) break;
    }
    (void)(*source)->damage();
  }
  return 0;
}
