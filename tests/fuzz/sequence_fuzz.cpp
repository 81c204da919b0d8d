// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Recordings: headers, frames and poses of MetaImage and NRRD sequences.
#include <algorithm>

#include "io/recording_source.hpp"
#include "io/sequence.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav;
  constexpr std::int64_t kFrames = 5;
  const auto file = fuzz::as_file(bytes, size, "a.igs.mha");
  auto reader = io::SequenceReader::open(file);
  if (!reader) {
    fuzz::check_message(reader.error().message);
    return 0;
  }
  for (std::int64_t i = 0; i < std::min(kFrames, reader->header().frame_count); ++i) {
    const auto frame = reader->read(i);
    if (!frame) {
      fuzz::check_message(frame.error().message);
      continue;
    }
    if (frame->pixels.size() != reader->header().frame_bytes()) __builtin_trap();
    (void)io::brightness_image(reader->header(), *frame);
    for (const std::string& name : io::transform_names(*frame)) (void)io::transform(*frame, name);
  }
  fuzz::SilentDiagnostics silent;
  auto source = io::RecordingSource::open(file, nullptr, {}, silent);
  for (int i = 0; source && i < 20; ++i) {
    if (!(*source)->next(Timestamp::max())) break;
  }
  return 0;
}
